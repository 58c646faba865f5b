"""Captures of a sensor that stands still as grids of mean ranges, and the flat faces in them."""
from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from scipy.ndimage import label, uniform_filter1d

from .._errors import CaptureError
from .._frame import Frame
from .._grid import EYES, PIXELS
from .._settings import Calibration
from .._source import open as open_source
from ._solution import MOUNT_KEYS, Array

if TYPE_CHECKING:
    from .._source import Source

_FRAMES_MIN = 5

_MOVED_M = 0.04
"""A larger change of ranges within a recording means that the sensor moved."""

_SEEN_M, _SIGMAS = 0.003, 4.0
"""A note reports a change above this many metres and standard deviations."""

_MOVED_BLOCK = (8, 50)
"""Lines and pixels of a block, for which one change is estimated."""

_MOVED_PART = 0.1
"""Share of the view that must change for a note; for a sensor that moved, it is half of the view."""

_LINES_MAX = 4096


@dataclass
class Grid:
    """The mean of all frames of a capture: arrays of (2 eyes, lines, 1000), nan where nothing was measured.

    A line's cells are in the order of their azimuths. Nothing in it depends on a calibration.
    """

    name: str
    frames: int
    azimuth: Array
    """Readings of the horizontal mirror, as a fraction of half its width: -1 to 1; in degrees where the profile has
    angles in degrees (is_span is false)."""
    elevation: Array
    """Those of the vertical mirror."""
    range_m: Array
    """Mean range without an offset."""
    sigma_m: Array
    """Standard deviation of that mean."""
    count: Array
    """Frames that had the cell."""
    is_span: bool
    shift_m: float = 0.0
    """How far ranges go within the recording, as after one step half way, where that is more than noise."""
    eye_values: tuple[int, int] = (0, 1)
    """What packets call the blue and the green eye, by the profile."""


@dataclass
class Patch:
    """A connected part of a flat face, as one eye sees it in one capture."""

    eye: int
    cells: Array
    """Indices of its cells in the eye's flattened grid: (n,)."""
    normal: Array
    """A unit vector towards the sensor, in the frame of the sensor by the calibration given: (3,)."""
    offset: float
    """normal . point of its points, in metres; negative."""
    rms_m: float
    """Root mean square of the distances of its points to it."""

_EDGE_M = 0.03
"""A cell whose ranges scatter by this much more than usual lies on an edge."""

_BLOCK = (64, 250)
"""Faces are searched on about this many lines and columns of means."""

_NEAR_M, _TURN = 0.04, float(np.cos(np.radians(12.0)))
"""Largest distance and turn (cosine) of points and normals from their face: a typical calibration bends faces this much."""

_CELLS_MIN = 60
"""Fewest means of a face."""


# --- Frames to grids ---


class _Sums:
    """Sums over frames, by eye, line and pixel."""

    def __init__(self) -> None:
        self.frames = 0
        self.sums = np.zeros((6, 2, 0, PIXELS))
        self.count = np.zeros((2, 0, PIXELS), "i4")

    @property
    def lines(self) -> int:
        return self.count.shape[1]

    def add(self, frame: Frame) -> None:
        more = min(_usual_lines(frame), _LINES_MAX) - self.lines
        if more > 0:
            self.sums = np.pad(self.sums, ((0, 0), (0, 0), (0, more), (0, 0)))
            self.count = np.pad(self.count, ((0, 0), (0, more), (0, 0)))
        kept = frame["line"] < self.lines
        at = tuple(frame[name][kept].astype(np.intp) for name in ("eye", "line", "pixel"))
        ranges = frame["range"][kept].astype("f8")
        parts = ranges, ranges * ranges, frame["azimuth"][kept], frame["elevation"][kept], self.frames * ranges, self.frames
        for total, values in zip(self.sums, parts):
            total[at] += values
        self.count[at] += 1
        self.frames += 1

    def shifts_m(self, is_calm: Array, variance: float) -> tuple[Array, Array]:
        """How far the ranges of neighbours go together, by a straight line over the frames, which sees two thirds of a steady
        change and all of a step half way; by block of the cells that do not scatter. And the standard deviation of each of
        these, of ranges of this variance."""
        if self.lines == 0:
            return np.empty(0), np.empty(0)
        ranges, _, _, _, turned, turn = self.sums
        # Each cell was seen in about the same frames, of which the numbers have this variance.
        spread = (self.frames ** 2 - 1) / 12
        n = np.maximum(self.count, 1)
        slope = np.where(is_calm, (turned / n - turn / n * ranges / n) / spread, 0)
        block = min(_MOVED_BLOCK[0], self.lines), _MOVED_BLOCK[1]
        rows = self.lines // block[0]
        cells, sums, shares = (values[:, :rows * block[0]].reshape(2, rows, block[0], -1, block[1]).sum((2, 4))
                               for values in (is_calm, slope, np.where(is_calm, 1 / n, 0)))
        many = cells > 0.25 * block[0] * block[1]
        cells, scale = cells[many], self.frames * 2 / 3
        # A cell's slope has the variance of its ranges / (count * spread): of many frames, 12 * (2 / 3)^2 = 16 / 3 when scaled.
        sigma = np.sqrt(variance / spread * shares[many]) / cells
        return np.abs(sums[many] / cells) * scale, sigma * scale

    def means(self) -> tuple[Array, Array, Array, Array]:
        """Range, its variance by frame, azimuth and elevation; nan where few frames had a cell."""
        count = np.where(self.count > 0.5 * self.count.max(), self.count, 0)
        with np.errstate(invalid="ignore", divide="ignore"):
            ranges, squares, azimuth, elevation = self.sums[:4] / count
            variance = np.maximum(squares - ranges * ranges, 0) * count / np.maximum(count - 1, 1)
        for values in (ranges, variance, azimuth, elevation):
            values[count == 0] = np.nan
        return ranges, variance, azimuth, elevation


def _usual_lines(frame: Frame) -> int:
    """Lines of a frame; a damaged packet can claim any number."""
    numbers = np.sort(frame.lines["number"])
    return int(numbers[len(numbers) * 9 // 10] * 1.12) + 2 if len(numbers) else 0


def _sum(source: Source, name: str) -> _Sums:
    """Sums of all frames but those that the recording cuts."""
    made = _Sums()
    for frame in source:
        if len(frame) and not (frame.first or frame.last):
            made.add(frame)
    if made.frames < _FRAMES_MIN:
        raise CaptureError(f"{name}: {made.frames} whole frames; a calibration needs at least {_FRAMES_MIN} "
                           "of a sensor at rest, better 20")
    return made


def _shift(name: str, sums: _Sums, is_calm: Array, variance: float) -> float:
    """How far ranges go in a part of the view, 0 where that is noise; an error where they do in half of it."""
    shifts, sigma = sums.shifts_m(is_calm, variance)
    if not len(shifts):
        return 0.0
    told = np.where(shifts > _SIGMAS * sigma, shifts, 0)
    half, part = (float(np.quantile(told, 1 - share)) for share in (0.5, _MOVED_PART))
    if half > _MOVED_M:
        raise CaptureError(f"{name}: ranges change by {half:.2f} m within the recording: the sensor has to stand still")
    return part if part > _SEEN_M else 0.0


def grid(capture: Union[str, os.PathLike[str]], profile: Any = None, **options: Any) -> Grid:
    """The mean of a capture's frames. options are those of lumsdk.open().

    Raises lumsdk.CaptureError where the capture has too few frames, or the sensor was moved.
    """
    calibration = options.pop("calibration", None)
    calibration = calibration if isinstance(calibration, Calibration) else Calibration(calibration)
    eyes = {f"eyes.{eye}.{key}": value for eye in EYES for key, value in
            (("tof_offset_ps", 0.0), ("azimuth.center_deg", 0.0), ("azimuth.width_deg", 60.0),
             ("elevation.min_deg", -17.0), ("elevation.max_deg", 3.0))}
    name = os.fspath(capture)
    if profile is not None:
        options["profile"] = profile
    with open_source(name, columns=("range", "azimuth", "elevation", "line", "pixel", "eye"),
                     returns="first", calibration=calibration.replace(eyes), **options) as source:
        is_span = source.profile["angle_lsb_deg"] == "span"
        values = int(source.profile["eye_values.blue"]), int(source.profile["eye_values.green"])
        sums = _sum(source, name)
    ranges, variance, azimuth, elevation = sums.means()
    usual = float(np.nanmedian(variance)) if np.isfinite(variance).any() else 0.0
    with np.errstate(invalid="ignore"):
        is_edge = variance > (3 * math.sqrt(usual) + _EDGE_M) ** 2
    shift = _shift(name, sums, np.isfinite(ranges) & ~is_edge, usual)
    ranges[is_edge] = np.nan
    shape = 2, sums.lines, PIXELS
    scale = (30.0, 10.0) if is_span else (1.0, 1.0)
    made = Grid(name, sums.frames, azimuth.reshape(shape) / scale[0], (elevation.reshape(shape) + 7.0) / scale[1],
                ranges.reshape(shape), np.sqrt(np.where(sums.count > 0, usual / np.maximum(sums.count, 1), np.nan)).reshape(shape),
                sums.count.reshape(shape), is_span, shift, values)
    _align(made)
    return made


def _align(made: Grid) -> None:
    """Turn the lines of the mirror's way back round: columns then are in the order of their azimuths."""
    u = made.azimuth
    known = np.isfinite(u)
    middle = np.where(known, np.arange(PIXELS), 0).sum(2) / np.maximum(known.sum(2), 1)
    with np.errstate(invalid="ignore"):
        slope = np.nansum(u * (np.arange(PIXELS) - middle[:, :, None]), 2)
    for values in (made.azimuth, made.elevation, made.range_m, made.sigma_m, made.count):
        values[slope < 0] = values[slope < 0][:, ::-1]


# --- Points ---


def angles(grid: Grid, eye: int, calibration: Calibration) -> tuple[Array, Array]:
    """Azimuth and elevation of an eye's cells in degrees, before the mount."""
    name = f"eyes.{EYES[eye]}."
    low, high = float(calibration[name + "elevation.min_deg"]), float(calibration[name + "elevation.max_deg"])
    half = float(calibration[name + "azimuth.width_deg"]) / 2 if grid.is_span else 1.0
    rise = (high - low) / 2 if grid.is_span else 1.0
    return (float(calibration[name + "azimuth.center_deg"]) + grid.azimuth[eye] * half,
            (low + high) / 2 + grid.elevation[eye] * rise)


def offset_m(calibration: Calibration, eye: int) -> float:
    """What an eye's tof_offset_ps is in metres."""
    return float(calibration[f"eyes.{EYES[eye]}.tof_offset_ps"]) * metres_a_ps(calibration)


def metres_a_ps(calibration: Calibration) -> float:
    return 0.5e-12 * float(calibration["speed_of_light"])


def mount(calibration: Calibration, eye: int) -> tuple[Array, Array]:
    """Rotation and place of an eye on the sensor."""
    values = [float(calibration[f"eyes.{EYES[eye]}.{key}"]) for key in MOUNT_KEYS]
    return rotation(*values[3:]), np.array(values[:3])


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), of degrees."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in map(math.radians, (roll, pitch, yaw)))
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]])


def directions(azimuth: Array, elevation: Array) -> Array:
    """Unit vectors of degrees: (..., 3)."""
    az, el = np.radians(azimuth), np.radians(elevation)
    flat = np.cos(el)
    return np.stack((flat * np.cos(az), flat * np.sin(az), np.sin(el)), -1)


def points(grid: Grid, eye: int, calibration: Calibration) -> Array:
    """Points of an eye in the frame of the sensor: (lines * 1000, 3), nan where nothing was measured."""
    turn, place = mount(calibration, eye)
    made = directions(*angles(grid, eye, calibration)) * (grid.range_m[eye] + offset_m(calibration, eye))[..., None]
    out: Array = made.reshape(-1, 3) @ turn.T + place
    return out


# --- Faces ---


@dataclass
class _Means:
    """An eye's points as means of blocks of cells, with the normals there: arrays of (rows, columns, ...)."""

    xyz: Array
    normal: Array
    is_flat: Array
    block: tuple[int, int]


def block_of(lines: int) -> tuple[int, int]:
    """Lines and pixels of a mean."""
    return max(1, round(lines / _BLOCK[0])), max(1, PIXELS // _BLOCK[1])


def _block_means(xyz: Array, lines: int) -> tuple[Array, tuple[int, int]]:
    block = block_of(lines)
    rows = lines // block[0]
    cells = xyz.reshape(lines, PIXELS, 3)[:rows * block[0]].reshape(rows, block[0], -1, block[1], 3)
    known = np.isfinite(cells[..., 0])
    count = known.sum((1, 3))
    sums = np.where(known[..., None], cells, 0).sum((1, 3))
    with np.errstate(invalid="ignore", divide="ignore"):
        means = sums / count[..., None]
    means[2 * count < block[0] * block[1]] = np.nan
    return means, block


def _with_normals(xyz: Array, block: tuple[int, int]) -> _Means:
    """A plane through each window of 5 rows and 7 columns."""
    known = np.isfinite(xyz[..., 0])
    filled = np.where(known[..., None], xyz, 0)

    def mean(values: Array) -> Array:
        return np.asarray(uniform_filter1d(uniform_filter1d(values.astype("f8"), 5, 0, mode="constant"), 7, 1, mode="constant"))

    share = mean(known)
    enough = known & (share > 0.55)
    scale = 1 / np.maximum(share, 1e-9)
    first = [mean(filled[..., i]) * scale for i in range(3)]
    covariance = np.empty((*known.shape, 3, 3))
    for i in range(3):
        for j in range(i + 1):
            second = mean(filled[..., i] * filled[..., j]) * scale - first[i] * first[j]
            covariance[..., i, j] = covariance[..., j, i] = second
    normal = np.zeros_like(xyz)
    rms = np.full(known.shape, np.inf)
    values, vectors = np.linalg.eigh(covariance[enough])
    normal[enough] = vectors[:, :, 0]
    rms[enough] = np.sqrt(np.maximum(values[:, 0], 0))
    normal[np.nansum(normal * filled, -1) > 0] *= -1
    wide = np.zeros(known.shape, bool)
    wide[enough] = values[:, 1] > 9 * values[:, 0]
    return _Means(xyz, normal, enough & (rms < 0.5 * _NEAR_M) & wide, block)


def fit_plane(xyz: Array) -> tuple[Array, float, float]:
    """Normal towards the origin, offset and root mean square distance of a plane through points."""
    centre = xyz.mean(0)
    values, vectors = np.linalg.eigh(np.cov((xyz - centre).T))
    normal = vectors[:, 0]
    offset = float(normal @ centre)
    sign = -1.0 if offset > 0 else 1.0
    return normal * sign, offset * sign, math.sqrt(max(float(values[0]), 0.0))


def _vote(means: _Means, left: Array) -> Optional[tuple[Array, float]]:
    """The plane that most of what is left agrees on."""
    normal = means.normal[left]
    if len(normal) < _CELLS_MIN // 2:
        return None
    offset = (normal * means.xyz[left]).sum(1)
    bins = np.c_[np.round(normal * 6), np.round(offset / 0.2)].astype("i8")
    keys = ((bins[:, 0] * 16 + bins[:, 1]) * 16 + bins[:, 2]) * 4096 + bins[:, 3]
    _, where, count = np.unique(keys, return_inverse=True, return_counts=True)
    chosen = where.ravel() == count.argmax()
    if count.max() < _CELLS_MIN // 3:
        return None
    return np.median(normal[chosen], 0), float(np.median(offset[chosen]))


def _grow(means: _Means, left: Array, seed: tuple[Array, float]) -> Optional[Array]:
    """The largest connected part near a plane, which is fitted again and again."""
    normal, offset = seed
    part: Optional[Array] = None
    for _ in range(4):
        with np.errstate(invalid="ignore"):
            near = left & (np.abs(means.xyz @ normal - offset) < _NEAR_M) & (means.normal @ normal > _TURN)
        labels = np.zeros(near.shape, "i4")
        if label(near, output=labels) == 0:
            return part
        largest: Array = labels == 1 + np.bincount(labels.ravel())[1:].argmax()
        part = largest
        if largest.sum() < 8:
            return part
        normal, offset, _ = fit_plane(means.xyz[largest])
    return part


def _cells_of(part: Array, means: _Means, xyz: Array, plane: tuple[Array, float]) -> Array:
    """Cells of the grid behind a part of the means."""
    whole = np.repeat(np.repeat(part, means.block[0], 0), means.block[1], 1)
    at = np.flatnonzero(whole.ravel())
    with np.errstate(invalid="ignore"):
        made: Array = at[np.abs(xyz[at] @ plane[0] - plane[1]) < _NEAR_M]
    return made


def _patches_of(grid: Grid, eye: int, calibration: Calibration) -> Iterator[Patch]:
    xyz = points(grid, eye, calibration)
    means = _with_normals(*_block_means(xyz, grid.range_m.shape[1]))
    left = means.is_flat.copy()
    for _ in range(60):
        seed = _vote(means, left)
        if seed is None:
            return
        part = _grow(means, left, seed)
        if part is None or not part.any():
            part = left & (np.abs(means.xyz @ seed[0] - seed[1]) < 0.2) & (means.normal @ seed[0] > 0.9)
            if not part.any():
                return
            left &= ~part
            continue
        left &= ~part
        if part.sum() >= _CELLS_MIN:
            normal, offset, rms = fit_plane(means.xyz[part])
            yield Patch(eye, _cells_of(part, means, xyz, (normal, offset)), normal, offset, rms)


def find_planes(grid: Grid, calibration: Calibration) -> list[Patch]:
    """Connected flat parts of what each eye sees, the largest first."""
    made = [patch for eye in range(len(EYES)) for patch in _patches_of(grid, eye, calibration)]
    return sorted((patch for patch in made if len(patch.cells)), key=lambda patch: -len(patch.cells))
