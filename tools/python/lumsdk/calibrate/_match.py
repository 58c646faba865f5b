"""Which face of one capture is which of another: turn and place of the sensor are searched, none is assumed."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from .._errors import CaptureError
from .._grid import EYES
from .._settings import Calibration
from ._planes import Grid, Patch, find_planes, points
from ._solution import Array

_ANGLE = float(np.cos(np.radians(6.0)))
"""How far normals of one face may be apart by a typical calibration."""

_OFFSET_M = 0.35
_TILT = float(np.cos(np.radians(60.0)))
_KEPT = 60
"""Ways to place a capture that are looked at closely."""

_STAYS = 0.02
_SEEN_M = 0.2
_SAMPLES = 1500


@dataclass
class View:
    """A capture with its faces and what it sees, by the calibration given."""

    grid: Grid
    patches: list[Patch]
    normals: Array
    offsets: Array
    weights: Array
    samples: Array
    """Some of its points."""
    rays: KDTree
    """Unit vectors of its points as seen from the sensor."""
    ranges: Array


@dataclass
class Pose:
    """Where a sensor stands: point of the world = turn @ point of the sensor + place."""

    turn: Array
    place: Array

    def after(self, other: Pose) -> Pose:
        """First the other, then this one."""
        return Pose(self.turn @ other.turn, self.turn @ other.place + self.place)

    def inverse(self) -> Pose:
        return Pose(self.turn.T, -self.turn.T @ self.place)


def look(grid: Grid, calibration: Calibration) -> View:
    """Find the faces of a capture."""
    patches = find_planes(grid, calibration)
    xyz = np.concatenate([points(grid, eye, calibration) for eye in range(len(EYES))])
    xyz = xyz[np.isfinite(xyz[:, 0])]
    sparse = xyz[::max(1, len(xyz) // 40000)]
    ranges = np.linalg.norm(sparse, axis=1)
    return View(grid, patches, np.array([p.normal for p in patches]).reshape(-1, 3), np.array([p.offset for p in patches]),
                np.sqrt(np.array([len(p.cells) for p in patches], "f8")), sparse[::max(1, len(sparse) // _SAMPLES)],
                KDTree(sparse / np.maximum(ranges, 1e-9)[:, None]), ranges)


# --- One capture against another ---


def _frames_of(normals: Array, pairs: Array) -> Array:
    """A right-handed frame of each pair of normals: (n, 3, 3), its axes as columns."""
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    third = np.cross(first, second)
    third /= np.linalg.norm(third, axis=1)[:, None]
    return np.stack((first, np.cross(third, first), third), -1)


def _pairs(view: View, most: int = 12) -> Array:
    """Ordered pairs of the largest faces that are not parallel."""
    n = min(len(view.patches), most)
    cosine = view.normals[:n] @ view.normals[:n].T
    return np.argwhere(np.abs(cosine) < 0.94)


def _turns(a: View, b: View) -> Array:
    """Rotations from b's frame to a's that bring two normals of b onto two of a, the best first: (n, 3, 3)."""
    pairs_a, pairs_b = _pairs(a), _pairs(b)
    if not len(pairs_a) or not len(pairs_b):
        return np.empty((0, 3, 3))
    angle_a = np.arccos((a.normals[pairs_a[:, 0]] * a.normals[pairs_a[:, 1]]).sum(1))
    angle_b = np.arccos((b.normals[pairs_b[:, 0]] * b.normals[pairs_b[:, 1]]).sum(1))
    i, j = np.nonzero(np.abs(angle_a[:, None] - angle_b[None]) < np.radians(6.0))
    turns = _frames_of(a.normals, pairs_a[i]) @ _frames_of(b.normals, pairs_b[j]).transpose(0, 2, 1)
    turns = turns[turns[:, 2, 2] > _TILT]
    cosine = np.einsum("ai,nij,bj->nab", a.normals, turns, b.normals)
    score = ((cosine.max(1) > _ANGLE) * b.weights).sum(1)
    kept: list[Array] = []
    for index in np.argsort(-score, kind="stable"):
        if all(np.trace(turns[index].T @ other) < 1 + 2 * _ANGLE for other in kept):
            kept.append(turns[index])
            if len(kept) == _KEPT:
                break
    return np.array(kept).reshape(-1, 3, 3)


def _places(a: View, b: View, turn: Array) -> list[tuple[float, Pose]]:
    """Ways to place b where its rotation is known, with the share of b's faces that then lie on faces of a."""
    matches = np.argwhere(a.normals @ turn @ b.normals.T > _ANGLE)
    if not len(matches):
        return []
    normal = a.normals[matches[:, 0]]
    rise = a.offsets[matches[:, 0]] - b.offsets[matches[:, 1]]
    weight = b.weights[matches[:, 1]]
    order = np.argsort(-weight, kind="stable")[:40]
    normal, rise, which = normal[order], rise[order], matches[order, 1]
    triples = np.array([(i, j, k) for i in range(len(order)) for j in range(i) for k in range(j)
                        if len({which[i], which[j], which[k]}) == 3]).reshape(-1, 3)
    if not len(triples):
        return []
    sides = normal[triples]
    # Where no three faces fix a direction, the sensor has hardly moved in it.
    square = sides.transpose(0, 2, 1) @ sides + _STAYS * np.eye(3)
    places = np.linalg.solve(square, sides.transpose(0, 2, 1) @ rise[triples][..., None])[..., 0]
    fits = np.abs(places @ normal.T - rise) < _OFFSET_M
    score = np.zeros(len(places))
    for index in range(len(b.patches)):
        of = which == index
        if of.any():
            score += fits[:, of].any(1) * b.weights[index]
    made: list[tuple[float, Pose]] = []
    for index in np.argsort(-score, kind="stable")[:200]:
        if all(np.linalg.norm(places[index] - pose.place) > 0.4 for _, pose in made):
            made.append((float(score[index]), Pose(turn, places[index])))
        if len(made) == 4:
            break
    return made


def _agreement(a: View, b: View, pose: Pose) -> float:
    """Share of b's points that a sees at their place, less those that a sees through."""
    at = b.samples @ pose.turn.T + pose.place
    ranges = np.linalg.norm(at, axis=1)
    distance, index = a.rays.query(at / np.maximum(ranges, 1e-9)[:, None], distance_upper_bound=0.02)
    seen = np.isfinite(distance)
    if seen.sum() < 0.05 * len(at):
        return 0.0
    apart = a.ranges[index[seen]] - ranges[seen]
    tolerance = _SEEN_M + 0.03 * ranges[seen]
    good, through = (np.abs(apart) < tolerance).sum(), (apart > 2 * tolerance).sum()
    return float((good - through) / seen.sum() * min(1.0, seen.mean() / 0.3))


def place(a: View, b: View) -> tuple[float, Pose]:
    """Where b's sensor stands in a's frame, and how well what both see agrees, up to 1; 0 where nothing fits."""
    tried = [found for turn in _turns(a, b) for found in _places(a, b, turn)]
    tried.sort(key=lambda found: -found[0])
    best = 0.0, Pose(np.eye(3), np.zeros(3))
    for _, pose in tried[:_KEPT]:
        score = 0.5 * (_agreement(a, b, pose) + _agreement(b, a, pose.inverse()))
        if score > best[0]:
            best = score, pose
    return best


# --- All captures ---


_LEAST_AGREEMENT = 0.6


def place_all(views: list[View]) -> list[Pose]:
    """The pose of each capture in the frame of the first. Raises lumsdk.CaptureError where one fits none of the others."""
    poses: dict[int, Pose] = {0: Pose(np.eye(3), np.zeros(3))}
    known: dict[tuple[int, int], tuple[float, Pose]] = {}
    while len(poses) < len(views):
        best: tuple[float, int, Pose] = -1.0, 0, poses[0]
        for i in [k for k in range(len(views)) if k not in poses]:
            for j in poses:
                if (j, i) not in known:
                    known[j, i] = place(views[j], views[i])
                score, pose = known[j, i]
                if score > best[0]:
                    best = score, i, poses[j].after(pose)
        if best[0] < _LEAST_AGREEMENT:
            missing = ", ".join(view.grid.name for k, view in enumerate(views) if k not in poses)
            raise CaptureError(f"{missing}: shows no faces that another capture shows too. Record the same room, the sensor turned "
                             "by 20 to 30 degrees between captures, and nothing moved meanwhile")
        poses[best[1]] = best[2]
    return [poses[k] for k in range(len(views))]


# --- Patches to faces ---


@dataclass
class Seen:
    """A patch with its capture, in the frame of the world."""

    capture: int
    patch: Patch
    normal: Array
    offset: float
    points: Array
    """Some of its points."""


def assign(seen: list[Seen], angle_deg: float, offset_m: float) -> tuple[Array, list[tuple[Array, float]]]:
    """The face of each patch, the largest patches first, and normal and offset of each face."""
    faces: list[tuple[Array, float]] = []
    of = np.full(len(seen), -1)
    for index in sorted(range(len(seen)), key=lambda i: -len(seen[i].patch.cells)):
        s = seen[index]
        best, at = 1.0, -1
        for number, (normal, offset) in enumerate(faces):
            turn = np.degrees(np.arccos(min(1.0, float(normal @ s.normal)))) / angle_deg
            away = float(np.sqrt(np.mean((s.points @ normal - offset) ** 2))) / offset_m
            if max(turn, away) < best:
                best, at = max(turn, away), number
        if at < 0:
            at = len(faces)
            faces.append((s.normal, s.offset))
        of[index] = at
    return of, faces
