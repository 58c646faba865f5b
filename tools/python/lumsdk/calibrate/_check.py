"""Whether a calibration is right: how flat walls are, and the step where a face goes on from one eye to the other."""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Callable, Optional

import numpy as np

from .._errors import CaptureError
from ._planes import Grid, Patch, find_planes, grid, points
from ._solution import Array
from ._waves import bow, waves

if TYPE_CHECKING:
    from .._settings import Calibration
    from ._arguments import Options


STEP_M = 0.005
TILT_DEG = 0.05
"""Largest step and tilt that are right: what a good calibration leaves on ordinary walls."""
SIGMAS = 4.0
"""Larger ones may be chance, up to this many standard deviations."""
TOLD_M, TOLD_DEG = 0.005, 0.15
"""If measured less exactly than this, a small value proves nothing. The angle makes the same step over 2 m."""

FRAMES = 20
_SAME_STEP_M = 0.25
_SAME_DEG = 6.0
_NEAR_STEP_M = 1.0
_NEAR_DEG = 20.0
"""Halves between the two limits are two faces, or show a calibration that is far off."""
_FAR_SIGMA_M = 0.05
"""A step that is measured less exactly is not used."""
_TILES = 6
_TILE_M = (2.0, 1.0, 0.5, 0.25, 0.12, 0.06)
_FLAT_TILE_M = 0.5
_USUAL_WAVES_M, _USUAL_TILES = 0.0015, 4.0
"""Waves of usual walls, and their weight against those seen."""
_BOW = 2 / 3
"""The bow of usual walls as a share of their waves."""
_GAP_DEG = 10.0
_WIDE_DEG = 4.0
"""A half that is narrower is mostly edge, where beams meet two faces."""

_Tell = Callable[..., object]


@dataclass
class Face:
    """What one eye sees of a flat face."""

    eye: int
    cells: Array
    """Indices into the eye's flattened grid: (n,)."""
    points: Array
    """In the frame of the sensor, in metres: (n, 3)."""
    normal: Array
    offset: float
    rms_m: float
    """Root mean square of the mean distances of its tiles, in which the noise of ranges hardly counts."""


@dataclass
class Seam:
    """A face that both eyes see, and how its halves meet."""

    blue: Face
    green: Face
    middle: Array
    """Where the step is measured: between the halves, in the frame of the sensor."""
    normal: Array
    """Of both together, towards the sensor."""
    across: Array
    """In the face, from the blue half to the green one."""
    kind: str
    """wall, floor, ceiling or face"""
    step_m: float
    """How much nearer the green half is, along the normal."""
    step_sigma_m: float
    tilt_deg: float
    """How much the halves are turned against each other, about the seam: positive where they form a hollow."""
    tilt_sigma_deg: float
    twist_deg: float
    """The same about the direction across the seam."""
    twist_sigma_deg: float

    @property
    def distance_m(self) -> float:
        """From the sensor to where the step is measured."""
        return float(np.linalg.norm(self.middle))

    @property
    def bounds(self) -> tuple[float, float]:
        """How large a step in metres and an angle in degrees may be here: what is right, or what chance makes."""
        return (max(STEP_M, SIGMAS * self.step_sigma_m),
                max(TILT_DEG, SIGMAS * max(self.tilt_sigma_deg, self.twist_sigma_deg)))

    @property
    def verdict(self) -> str:
        """apart where step, tilt or twist is large; else meet, or unknown where that they are small tells nothing."""
        is_apart = any(abs(value) > max(bound, SIGMAS * sigma) for value, sigma, bound in (
            (self.step_m, self.step_sigma_m, STEP_M), (self.tilt_deg, self.tilt_sigma_deg, TILT_DEG),
            (self.twist_deg, self.twist_sigma_deg, TILT_DEG)))
        is_told = self.step_sigma_m <= TOLD_M and max(self.tilt_sigma_deg, self.twist_sigma_deg) <= TOLD_DEG
        return "apart" if is_apart else "meet" if is_told else "unknown"

    @property
    def is_one(self) -> bool:
        """Whether the halves are so near each other that they are of one face."""
        is_near: bool = abs(self.step_m) <= _SAME_STEP_M and self.apart_deg <= _SAME_DEG
        return is_near

    @property
    def apart_deg(self) -> float:
        """The angle between the normals of the halves."""
        return float(np.degrees(np.arccos(min(1.0, float(self.blue.normal @ self.green.normal)))))


@dataclass
class Check:
    """What was measured."""

    capture: str
    calibration: str
    """Where the calibration comes from, in words."""
    frames: int
    faces: list[Face]
    seams: list[Seam]
    clouds: list[Array] = field(default_factory=list)
    """All points of each eye in the frame of the sensor: (cells, 3)."""
    strange: list[Seam] = field(default_factory=list)
    """Halves that are two faces, or one that a calibration which is far off tears apart."""
    is_exchanged: bool = False
    """No wall goes on from eye to eye, but one does if the blue eye is taken for the green one."""
    eye_values: tuple[int, int] = (0, 1)
    """What packets call the blue and the green eye, by the profile."""

    @property
    def flat_m(self) -> tuple[Optional[float], Optional[float]]:
        """How far faces are from flat, by eye: root mean square over their tiles; None: the eye sees none."""
        return _flat(self.faces, 0), _flat(self.faces, 1)

    @property
    def step_m(self) -> Optional[float]:
        """Root mean square of the steps."""
        return float(np.sqrt(np.mean([s.step_m ** 2 for s in self.seams]))) if self.seams else None

    @property
    def verdict(self) -> str:
        """apart where one face is, meet where one does, unknown where no face that both eyes see tells, or eyes seem exchanged."""
        if self.is_exchanged:
            return "unknown"
        told = {seam.verdict for seam in self.seams}
        return next((word for word in ("apart", "meet") if word in told), "unknown")

    @property
    def bounds(self) -> tuple[float, float]:
        """How far the eyes may be apart where they meet: the widest bounds of the seams that tell."""
        told = [seam.bounds for seam in self.seams if seam.verdict == "meet"]
        return max(step for step, _ in told), max(angle for _, angle in told)


def _flat(faces: Iterable[Face], eye: int) -> Optional[float]:
    chosen = [face for face in faces if face.eye == eye]
    if not chosen:
        return None
    weights = [len(face.cells) for face in chosen]
    return float(np.sqrt(np.average([face.rms_m ** 2 for face in chosen], weights=weights)))


# --- Faces ---


def _axes(normal: Array) -> tuple[Array, Array]:
    """Two directions in a face."""
    helper = np.array((0.0, 0.0, 1.0)) if abs(normal[2]) < 0.8 else np.array((1.0, 0.0, 0.0))
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _tiles(coordinates: Array, largest_m: float) -> Array:
    """Means of the points of each tile, (tiles, 3): along the face twice, and the height. Tiles are smaller on a small face."""
    made: Array = coordinates[:0]
    for size in (size for size in _TILE_M if size <= largest_m):
        keys = np.floor(coordinates[:, :2] / size).astype(np.int64)
        _, place, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
        place = place.reshape(-1)
        sums = np.stack([np.bincount(place, coordinates[:, i]) for i in range(3)], 1)
        made = (sums / counts[:, None])[counts >= 0.2 * np.median(counts)]
        if len(made) >= 4 * _TILES:
            break
    return made


@dataclass
class _Plane:
    """The plane through tiles."""

    tiles: Array
    values: Array
    """Height where the coordinates are 0, and slopes: (3,)."""
    solver: Array
    """Heights of tiles to values: (3, tiles)."""
    left: Array
    """Heights less those of the plane."""
    waviness: float
    """How much of the square of a wall's waves is in the squares of what is left, of all tiles together."""


def _alike(a: Array, b: Array) -> Array:
    """The covariance of the heights of a wall with waves of 1 m rms between places on it."""
    apart = np.sqrt(((a[:, None, :2] - b[None, :, :2]) ** 2).sum(2))
    return waves(apart) + _BOW ** 2 * bow(apart)


def _design(tiles: Array) -> Array:
    return np.column_stack((np.ones(len(tiles)), tiles[:, :2]))


def _plane_of(tiles: Array) -> _Plane:
    design = _design(tiles)
    solver = np.linalg.pinv(design)
    values = solver @ tiles[:, 2]
    rest = np.eye(len(tiles)) - design @ solver
    return _Plane(tiles, values, solver, tiles[:, 2] - design @ values, float((rest * _alike(tiles, tiles)).sum()))


def _covariance(blue: _Plane, green: _Plane) -> Array:
    """Of the green half's values less the blue one's. What is left tells how wavy the face is, together with what is usual
    for walls; waves go on from half to half."""
    square = (float(blue.left @ blue.left + green.left @ green.left) + _USUAL_TILES * _USUAL_WAVES_M ** 2) / (
        blue.waviness + green.waviness + _USUAL_TILES)
    between = blue.solver @ _alike(blue.tiles, green.tiles) @ green.solver.T
    own = sum(half.solver @ _alike(half.tiles, half.tiles) @ half.solver.T for half in (blue, green))
    return np.asarray(square * (own - between - between.T))


def _face(patch: Patch, cloud: Array) -> Optional[Face]:
    chosen = cloud[patch.cells]
    middle = chosen.mean(0)
    frame = np.stack((*_axes(patch.normal), patch.normal), 1)
    tiles = _tiles((chosen - middle) @ frame, _FLAT_TILE_M)
    if len(tiles) < _TILES:
        return None
    design = _design(tiles)
    left = tiles[:, 2] - design @ np.linalg.lstsq(design, tiles[:, 2], rcond=None)[0]
    return Face(patch.eye, patch.cells, chosen, patch.normal, patch.offset, float(np.sqrt(np.mean(left ** 2))))


# --- Seams ---


def _kind(normal: Array) -> str:
    if abs(normal[2]) > 0.9:
        return "floor" if normal[2] > 0 else "ceiling"
    return "wall" if abs(normal[2]) < 0.3 else "face"


def _azimuths(face: Face) -> tuple[float, float]:
    """The face's ends, degrees to the left."""
    low, high = np.percentile(np.degrees(np.arctan2(face.points[:, 1], face.points[:, 0])), (1, 99))
    return float(low), float(high)


def _edge(face: Face, direction: Array) -> Array:
    """The middle of the tenth of a half that is nearest to the other."""
    along = face.points @ direction
    chosen: Array = face.points[along >= np.quantile(along, 0.9)]
    return np.asarray(chosen.mean(0))


def _elevations(face: Face) -> tuple[float, float]:
    low, high = np.percentile(face.points[:, 2] / np.linalg.norm(face.points, axis=1), (5, 95))
    return float(low), float(high)


def _are_neighbours(blue: Face, green: Face) -> bool:
    """Whether they could be one face, which the seam cuts."""
    if float(blue.normal @ green.normal) < np.cos(np.radians(_NEAR_DEG)):
        return False
    right, left = _azimuths(blue), _azimuths(green)
    is_wide = min(right[1] - right[0], left[1] - left[0]) >= _WIDE_DEG
    return is_wide and left[0] - right[1] < _GAP_DEG


def _likeness(seam: Seam) -> float:
    """How much of both halves is beside each other: cells of the smaller one, by the elevations that they share. How far they
    are apart does not count: what is to be measured cannot choose."""
    (low, high), (other_low, other_high) = _elevations(seam.blue), _elevations(seam.green)
    shared = min(high, other_high) - max(low, other_low)
    share = max(shared, 0.0) / max(max(high, other_high) - min(low, other_low), 1e-6)
    return share * min(len(seam.blue.cells), len(seam.green.cells))


def _seam(blue: Face, green: Face) -> Optional[Seam]:
    """How two halves meet; None: they are not of one face, or too far from each other to tell."""
    normal = blue.normal + green.normal
    normal /= np.linalg.norm(normal)
    across = green.points.mean(0) - blue.points.mean(0)
    across -= normal * float(across @ normal)
    across /= np.linalg.norm(across)
    middle = (_edge(blue, across) + _edge(green, -across)) / 2
    frame = np.stack((across, np.cross(normal, across), normal), 1)
    halves = []
    for face in (blue, green):
        tiles = _tiles((face.points - middle) @ frame, _TILE_M[0])
        if len(tiles) < _TILES:
            return None
        halves.append(_plane_of(tiles))
    apart = halves[1].values - halves[0].values
    sigma = np.sqrt(np.maximum(np.diag(_covariance(halves[0], halves[1])), 0))
    if abs(apart[0]) > _NEAR_STEP_M or sigma[0] > _FAR_SIGMA_M:
        return None
    middle = middle + normal * float(halves[0].values[0] + halves[1].values[0]) / 2
    degrees, degrees_sigma = np.degrees(apart[1:]), np.degrees(sigma[1:])
    return Seam(blue, green, middle, normal, across, _kind(normal), float(apart[0]), float(sigma[0]), float(degrees[0]),
                float(degrees_sigma[0]), float(degrees[1]), float(degrees_sigma[1]))


def _chosen(found: Iterable[Seam]) -> list[Seam]:
    """Those that are most alike, the largest first. Each half belongs to one seam."""
    chosen: list[Seam] = []
    for seam in sorted(found, key=lambda s: -_likeness(s)):
        if not any(seam.blue is other.blue or seam.green is other.green for other in chosen):
            chosen.append(seam)
    return sorted(chosen, key=lambda s: -min(len(s.blue.cells), len(s.green.cells)))


def find_seams(faces: Iterable[Face]) -> tuple[list[Seam], list[Seam]]:
    """Faces that go on from eye to eye, and halves that do so only if the calibration is far off; the largest first."""
    faces = list(faces)
    found = [_seam(blue, green) for blue in faces for green in faces
             if (blue.eye, green.eye) == (0, 1) and _are_neighbours(blue, green)]
    made = [seam for seam in found if seam is not None]
    return _chosen(seam for seam in made if seam.is_one), _chosen(seam for seam in made if not seam.is_one)


# --- A capture ---


def _find_faces(seen: Grid, calibration: Calibration, clouds: list[Array]) -> list[Face]:
    made = (_face(patch, clouds[patch.eye]) for patch in find_planes(seen, calibration))
    return [face for face in made if face is not None]


def _clouds(seen: Grid, calibration: Calibration) -> list[Array]:
    return [points(seen, eye, calibration) for eye in range(2)]


def has_wall(seams: Iterable[Seam]) -> bool:
    """Whether one is of a wall. Of a level sensor a floor goes on whichever eye is which, and tells nothing of that."""
    return any(seam.kind not in ("floor", "ceiling") for seam in seams)


def are_exchanged(seen: Grid, calibration: Calibration, seams: Iterable[Seam]) -> bool:
    """Whether no wall goes on from eye to eye, of these seams of the grid, and one does with each eye taken for the other."""
    if has_wall(seams):
        return False
    other = replace(seen, **{name: getattr(seen, name)[::-1] for name in ("azimuth", "elevation", "range_m", "sigma_m", "count")})
    return has_wall(find_seams(_find_faces(other, calibration, _clouds(other, calibration)))[0])


def check_grid(seen: Grid, calibration: Calibration, named: str) -> Check:
    """What a grid tells of a calibration."""
    clouds = _clouds(seen, calibration)
    faces = _find_faces(seen, calibration, clouds)
    seams, strange = find_seams(faces)
    return Check(seen.name, named, seen.frames, faces, seams, clouds, strange, are_exchanged(seen, calibration, seams),
                 seen.eye_values)


def check(options: Options, progress: _Tell) -> Check:
    """Look at a capture with a calibration."""
    from .. import _source

    name = options.captures[0]
    with _source.open(name, **options.of_open()) as source:
        calibration, origins = source.calibration, bool(source.provenance)
    named = options.calibration_name or ("the capture's own" if origins else "typical values")
    progress(f"reading {name}")
    seen = grid(name, calibration=calibration, **options.of_grid())
    progress("finding walls")
    found = check_grid(seen, calibration, named + (" and --set" if options.set else ""))
    if not found.faces:
        raise CaptureError(f"{name}: no flat face is seen in it: record a room or a yard with walls, at least {FRAMES} frames, the "
                           "sensor and all else at rest")
    return found
