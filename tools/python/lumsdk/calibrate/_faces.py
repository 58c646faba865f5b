"""Patches joined to faces over captures and eyes, and the observations that a solution needs of them."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Optional

import numpy as np

from .._grid import EYES
from .._settings import Calibration
from ._edges import collect
from ._match import Pose, Seen, View, assign
from ._model import Cells, Eye, Fixed, State, cells_of, priors
from ._planes import points
from ._solution import Array
from ._solve import TILE_M, TILES_MAX, Group, Problem, Surface, group_cells, solve, surface_of, untold

_STARTS_M = 0.1, 0.05, 0.2, 0.4
_ROUNDS = ((8.0, 1.0, 0.05), (6.0, 0.6, 0.03), (5.0, 0.4, 0.02), (4.0, 0.2, 0.01), (4.0, 0.2, 0.005))
"""Of each round: degrees and share of the start's distance within which patches join a face, and the loss in metres."""

_JOINT_M = 0.02
_SAME, _FITS = (2.0, 0.01), (8.0, 0.012)
"""Degrees and metres, by a solution: closer faces are one, and a closer patch fits its face."""

_COARSE_CELLS = 250
"""Cells of a patch in the first rounds."""

_FINE_LINES, _FINE_PIXELS = 64, 4
_GRAZING = 0.12
_SQUARES_MIN = 8
"""Fewest observations of a face."""


# --- Views to cells ---


@dataclass
class Scene:
    """Captures with their faces."""

    views: list[View]
    seen: list[Seen]
    fixed: Fixed
    before: Array


def _cells(scene: Scene, of: Array, choose: Any) -> list[Cells]:
    """Cells of all patches by capture and eye; choose(patch) tells which of a patch."""
    made = []
    for k, view in enumerate(scene.views):
        for e in range(len(EYES)):
            mine = [(index, s) for index, s in enumerate(scene.seen) if s.capture == k and s.patch.eye == e and of[index] >= 0]
            if not mine:
                continue
            at = [choose(s.patch.cells) for _, s in mine]
            plane = np.concatenate([np.full(len(cells), of[index]) for (index, _), cells in zip(mine, at)])
            cells = np.concatenate(at)
            made.append(cells_of(view.grid, k, e, cells, plane))
    return made


def _sparse(cells: Array) -> Array:
    return cells[::max(1, len(cells) // _COARSE_CELLS)]


def _single(cells: Cells) -> Group:
    """Each cell as an observation."""
    count = len(cells.plane)
    return Group(cells, np.arange(count), np.ones(count), cells.plane, np.full(count, -1), cells.variance)


def _state(poses: list[Pose], faces: list[tuple[Array, float]], values: Array, bends: Optional[Array] = None) -> State:
    return State(values.copy(), np.zeros((2, 2, 3)) if bends is None else bends.copy(), list(poses),
                 np.array([f[0] for f in faces]).reshape(-1, 3), np.array([f[1] for f in faces]), np.zeros(len(faces)))


def _replace(scene: Scene, state: State, of: Array) -> None:
    """Fit each patch again, as the state sees it."""
    for index, s in enumerate(scene.seen):
        eye = Eye(_cells_of(scene, s, _sparse(s.patch.cells), int(of[index])), state, scene.fixed)
        s.points = eye.points + (eye.residual / eye.expected)[:, None] * (eye.points - eye.origin)
        centre = np.median(s.points, 0)
        rest = s.points - centre
        normal = np.linalg.eigh(rest.T @ rest)[1][:, 0]
        s.normal = normal if normal @ (eye.origin - centre) > 0 else -normal
        s.offset = float(s.normal @ centre)


def _cells_of(scene: Scene, s: Seen, cells: Array, plane: int) -> Cells:
    return cells_of(scene.views[s.capture].grid, s.capture, s.patch.eye, cells, plane)


def begin(views: list[View], poses: list[Pose], calibration: Calibration) -> list[Seen]:
    """The patches of all captures in the world, except those at which rays only graze."""
    made = []
    for k, view in enumerate(views):
        every = [points(view.grid, eye, calibration) for eye in range(len(EYES))]
        for patch in view.patches:
            mine = every[patch.eye][_sparse(patch.cells)]
            if -patch.offset < _GRAZING * float(np.median(np.linalg.norm(mine, axis=1))):
                continue
            normal = poses[k].turn @ patch.normal
            offset = patch.offset + float(normal @ poses[k].place)
            made.append(Seen(k, patch, normal, offset, mine @ poses[k].turn.T + poses[k].place))
    return made


def _stand_still(state: State, groups: list[Group]) -> None:
    """Where no face tells how a sensor moved, it has not."""
    count = len(state.poses)
    if count < 2:
        return
    rows = untold(groups, count, state.normals)[1].reshape(-1, 3 * count - 3)
    places = np.concatenate([pose.place for pose in state.poses[1:]])
    places = (places - rows.T @ (rows @ places)).reshape(-1, 3)
    state.poses[1:] = [Pose(pose.turn, at) for pose, at in zip(state.poses[1:], places)]


def _try(scene: Scene, seen: list[Seen], poses: list[Pose], start_m: float) -> tuple[float, State, Array]:
    """Join patches to faces and fit them, in rounds that grow stricter; and how good that is.

    Each patch that finds a face and fits it speaks for it, by its size; a calibration that is not likely, against it.
    """
    scene.seen = [replace(s) for s in seen]
    state = _state(poses, [], scene.before)
    for number, (angle, share, loss) in enumerate(_ROUNDS):
        of, faces = assign(scene.seen, angle, max(_JOINT_M, start_m * share))
        state = _state(state.poses, faces, state.values, state.bends)
        groups = [_single(cells) for cells in _cells(scene, of, _sparse)]
        if number == 0:
            _stand_still(state, groups)
        problem = Problem(groups, scene.fixed, scene.before, len(scene.views), loss_m=loss)
        state = solve(problem, state, 10 if number == 0 else 5).state
        _replace(scene, state, of)
    of, faces = assign(scene.seen, _ROUNDS[-1][0], _JOINT_M)
    away = (state.values - scene.before) / priors()
    return _joins(scene.seen, of, faces) - 0.5 * float(away @ away), _state(state.poses, faces, state.values, state.bends), of


def _joins(seen: list[Seen], of: Array, faces: list[tuple[Array, float]]) -> float:
    """How many patches fit a face that others made, one of usual size counting 1."""
    weight = np.sqrt([len(s.patch.cells) for s in seen])
    made = 0.0
    for number, (normal, offset) in enumerate(faces):
        # The first and largest has made the face, and fits it anyway.
        for index in sorted(np.flatnonzero(of == number), key=lambda i: -weight[i])[1:]:
            made += weight[index] * max(0.0, 1.0 - _rms_off(seen[index], normal, offset) / _JOINT_M)
    return made / float(weight.mean())


def _rms_off(s: Seen, normal: Array, offset: float) -> float:
    """How far a patch is from a face, whatever the noise of its points: its own plane stands for them."""
    flat = s.points - np.outer(s.points @ s.normal - s.offset, s.normal)
    return float(np.sqrt(np.mean((flat @ normal - offset) ** 2)))


def join(scene: Scene, poses: list[Pose]) -> tuple[State, Array]:
    """The best of several starts: faces that lie near each other must not be taken for one."""
    seen, tried = scene.seen, []
    for start_m in _STARTS_M:
        tried.append((*_try(scene, seen, poses, start_m), scene.seen))
    _, state, of, scene.seen = max(tried, key=lambda one: one[0])
    return state, of


# --- Patches joined again, by a solution ---


def _degrees(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def _merged(seen: list[Seen], state: State, of: Array) -> Array:
    """The face of each patch where faces that are one are made one."""
    of = of.copy()
    size = np.bincount(of, [len(s.patch.cells) for s in seen], len(state.offsets))
    order = np.argsort(-size, kind="stable")
    for at, small in enumerate(order):
        mine = [s for s, j in zip(seen, of) if j == small]
        for large in order[:at]:
            if mine and _degrees(state.normals[large], state.normals[small]) < _SAME[0] and all(
                    _rms_off(s, state.normals[large], float(state.offsets[large])) < _SAME[1] for s in mine):
                of[of == small] = large
                break
    return of


def rejoin(scene: Scene, state: State, of: Array) -> tuple[State, Array]:
    """The faces of all patches by a solution: faces that are one are joined, and patches that do not fit theirs go elsewhere."""
    _replace(scene, state, of)
    merged = _merged(scene.seen, state, of)
    normals, offsets, biases = list(state.normals), list(state.offsets), list(state.biases)

    def off(s: Seen, j: int) -> float:
        return max(_degrees(normals[j], s.normal) / _FITS[0], _rms_off(s, normals[j], offsets[j]) / _FITS[1])

    # What is wrong pulls others with it: the worst go first.
    wrong = [off(s, j) for s, j in zip(scene.seen, merged)]
    least = max(1.0, 0.5 * max(wrong))
    for index, s in enumerate(scene.seen):
        if wrong[index] <= least:
            continue
        best = min(range(len(normals)), key=lambda j: off(s, j))
        if off(s, best) > 1:
            best = len(normals)
            normals.append(s.normal)
            offsets.append(s.offset)
            biases.append(0.0)
        merged[index] = best
    used, again = np.unique(merged, return_inverse=True)
    made = State(state.values.copy(), state.bends.copy(), list(state.poses), np.array(normals)[used], np.array(offsets)[used],
                 np.array(biases)[used])
    return made, again.ravel()


# --- Cells to observations ---


def _fine(scene: Scene, state: State, cells: Cells, at: Array) -> tuple[Cells, Array]:
    """Cells of a patch, and their places in the grid, without outliers."""
    eye = Eye(cells, state, scene.fixed)
    off = np.abs(eye.residual * eye.slope)
    kept = off < max(0.01, 4 * 1.4826 * float(np.median(off)))
    return cells.at(kept), at[kept]


def _shrink(scene: Scene, state: State, s: Seen, found: Array, plane: int) -> Cells:
    """Cells of a patch without outliers, as means of neighbours: each stands on the ray of its mean angles."""
    lines, pixels = scene.views[s.capture].grid.range_m.shape[1:]
    cells, at = _fine(scene, state, _cells_of(scene, s, found, plane), found)
    key = (at // pixels // max(1, lines // _FINE_LINES)) * pixels + at % pixels // _FINE_PIXELS
    _, of = np.unique(key, return_inverse=True)
    of = of.ravel()
    count = np.bincount(of)

    def mean(values: Array) -> Array:
        made: Array = np.bincount(of, values) / count
        return made

    residual = Eye(cells, state, scene.fixed).residual
    made = Cells(cells.capture, cells.eye, mean(cells.azimuth), mean(cells.elevation), np.zeros(len(count)),
                 mean(cells.variance) / count, np.full(len(count), plane))
    made.range_m = mean(residual) - Eye(made, state, scene.fixed).residual
    return made


def _joined(parts: list[Cells]) -> Cells:
    def all_of(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    return Cells(parts[0].capture, parts[0].eye, all_of("azimuth"), all_of("elevation"), all_of("range_m"), all_of("variance"),
                 all_of("plane"))


def observe(scene: Scene, state: State, of: Array) -> tuple[list[Group], Surface]:
    """Squares of faces as observations, and how alike their heights are."""
    joined = []
    for k, e in sorted({(s.capture, s.patch.eye) for s in scene.seen}):
        mine = [(i, int(of[i]), s.patch.cells) for i, s in enumerate(scene.seen) if (s.capture, s.patch.eye) == (k, e)]
        cells = collect(scene.views[k].grid, k, e, mine, state, scene.fixed)
        joined.append(_joined([_shrink(scene, state, scene.seen[i], cells[i], plane) for i, plane, _ in mine if len(cells[i])]))
    scale = 1.0
    while True:
        made = [group_cells(cells, state, scene.fixed, TILE_M * scale) for cells in joined]
        groups = [group for group, _ in made]
        size = np.bincount(np.concatenate([group.plane for group in groups]), minlength=len(state.offsets))
        if size.sum() <= TILES_MAX:
            surface = surface_of(groups, [places for _, places in made])
            return without(groups, size < _SQUARES_MIN), surface
        scale *= max(1.1, float(np.sqrt(size.sum() / TILES_MAX)))


def without(groups: list[Group], is_out: Array) -> list[Group]:
    """The observations of all faces but those that are out: by face, or by group and face."""
    made = []
    for group, out in zip(groups, np.broadcast_to(is_out, (len(groups), is_out.shape[-1]))):
        kept = ~out[group.plane]
        if not kept.any():
            continue
        at = kept[group.of]
        number = np.cumsum(kept) - 1
        made.append(Group(group.cells.at(at), number[group.of[at]], group.count[kept], group.plane[kept], group.place[kept],
                          group.noise[kept]))
    return made
