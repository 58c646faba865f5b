"""lumcal eyes: from captures of a room to a calibration."""
from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Optional

import numpy as np

from .._errors import CaptureError
from .._frame import EYES
from .._settings import Calibration
from ._faces import Scene, begin, join, observe, without
from ._match import look, place_all
from ._model import CALIBRATION_COUNT, KEYS, Eye, State, fixed_of, priors, tangents, values_of
from ._planes import Grid, grid
from ._result import Array, Parameter, Plane, Residuals, Solution
from ._solve import Fit, Group, Problem, Spread, covariance, estimate_bends, estimate_spread, linearise, solve, untold

_WORTH = 0.5
"""What leaves more than this share of what was known before is not observable."""

_HELD_OUT = 3
_FACES_LEFT = 5
_SPARE_SQUARES = 20
_BENT = 0.004, 6.0
"""A face whose residuals are usually so many metres, and so many times those of other faces, is none."""

_WORSE = 1.02, 0.0002
_SHOWN_POINTS = 400
_FRAMES = 20

CAPTURES = 3
"""As many suffice."""


@dataclass
class Options:
    """What `lumcal eyes` is told."""

    captures: Sequence[str]
    calibration: Any = None
    """What it was before: a lumsdk.Calibration, a path or None for the typical one."""
    profile: Any = None
    reading: dict[str, Any] = field(default_factory=dict)
    """More options of lumsdk.open(), such as sensor=."""


@dataclass
class _Found:
    """A solution with what is held."""

    fit: Fit
    held: Array
    covariance: Array
    spread: Spread


# --- The solution ---


def _without_bent(problem: Problem, fit: Fit) -> Optional[Problem]:
    """The problem without faces that are no planes, or several; None: there is none."""
    off = np.abs(fit.left) / np.sqrt(fit.linear.slant)
    plane = np.concatenate([group.plane for group in problem.groups])
    usual = np.full(len(fit.state.offsets), np.nan)
    for j in np.unique(plane):
        usual[j] = np.median(off[plane == j])
    is_bent = usual > max(_BENT[0], _BENT[1] * float(np.nanmedian(usual)))
    return problem.of(without(problem.groups, is_bent)) if is_bent.any() else None


def _settle(problem: Problem, state: State) -> tuple[Problem, _Found]:
    """Estimate the variance components, then hold what the captures do not tell."""
    fit = solve(problem, state)
    for _ in range(3):
        fewer = _without_bent(problem, fit)
        if fewer is None:
            break
        problem, fit = fewer, solve(fewer, state)
    for _ in range(2):
        problem.spread = estimate_spread(problem, fit)
        fit = solve(problem, fit.state, 4)
        problem.spread = estimate_bends(problem, fit)
        fit = solve(problem, fit.state, 4)
    held = np.zeros(CALIBRATION_COUNT, bool)
    while True:
        known = covariance(fit, held)
        unknown = (np.sqrt(np.diag(known)) > _WORTH * priors()) & ~held
        if not unknown.any():
            return problem, _Found(fit, held, known, problem.spread)
        held = held | unknown
        problem.held = held
        start = fit.state.copy()
        start.values[held] = problem.before[held]
        fit = solve(problem, start)


def _with_values(problem: Problem, state: State, values: Array) -> State:
    """Poses and faces that fit best where the calibration is given, as a file has it: without bends of the mirrors."""
    total = float(np.linalg.norm([problem.spread.tile, problem.spread.spot, problem.spread.bow]))
    given = Problem(problem.groups, problem.fixed, values, problem.captures, held=np.ones(CALIBRATION_COUNT, bool),
                    spread=replace(problem.spread, spot=total), is_bent=False)
    start = state.copy()
    start.values, start.bends = values.copy(), np.zeros_like(state.bends)
    return solve(given, start).state


def _residuals(groups: Sequence[Group], state: State, problem: Problem) -> Array:
    """Residuals of observations across their faces, in metres."""
    made = []
    for group in groups:
        eye = Eye(group.cells, state, problem.fixed)
        made.append(group.mean(eye.residual * eye.slope))
    return np.concatenate(made)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values ** 2))) if len(values) else float("nan")


# --- Faces that are held out ---


def _spare_faces(problem: Problem, state: State) -> Array:
    """Faces that can be held out: seen more than once, and of a middling size."""
    count = len(state.offsets)
    size, seen = np.zeros(count), np.zeros(count)
    for group in problem.groups:
        squares = np.bincount(group.plane, minlength=count)
        size += squares
        seen += squares > 0
    spare = np.flatnonzero((seen > 1) & (size >= _SPARE_SQUARES))
    most = min(_HELD_OUT, max(0, len(spare) - _FACES_LEFT))
    order = spare[np.argsort(-size[spare], kind="stable")]
    first = len(order) // 3
    return np.asarray(order[first:first + most])


def _fit_faces(problem: Problem, state: State) -> Array:
    """Residuals across faces once each face is fitted, poses and calibration as they are."""
    for _ in range(3):
        linear, layout = linearise(problem, state)
        columns = linear.matrix[:, layout.faces:layout.biases].toarray()
        weight = 1 / np.sqrt(linear.slant)[:, None]
        step = np.linalg.lstsq(columns * weight, -linear.residual * weight[:, 0], rcond=1e-9)[0].reshape(-1, 3)
        first, second = tangents(state.normals)
        state = state.copy()
        state.normals = state.normals + step[:, :1] * first + step[:, 1:2] * second
        length = np.linalg.norm(state.normals, axis=1)
        state.normals /= length[:, None]
        state.offsets = (state.offsets + step[:, 2]) / length
    return _residuals(problem.groups, state, problem)


def _held_out(problem: Problem, found: _Found) -> tuple[float, float]:
    """Root mean squares on faces that the solution has not seen, before and after; nan where none can be spared."""
    spare = _spare_faces(problem, found.fit.state)
    if not len(spare):
        return float("nan"), float("nan")
    is_spare = np.zeros(len(found.fit.state.offsets), bool)
    is_spare[spare] = True
    rest = problem.of(without(problem.groups, is_spare))
    kept = problem.of(without(problem.groups, ~is_spare))
    values = solve(rest, found.fit.state).state.values
    made = [_rms(_fit_faces(kept, _with_values(rest, found.fit.state, v))) for v in (problem.before, values)]
    return made[0], made[1]


# --- What is told ---


_CENTRE = ("is the same as the yaw of the eye's mount, which means both together; no recording of still faces tells them "
           "apart")


def _why_held(key: str, captures: int) -> str:
    what = "where green sits and looks against blue" if ".mount." in key else "it"
    if captures == 1:
        return (f"one capture does not tell {what}: add two of the same room, the sensor turned by 20 to 30 degrees to either "
                "side so that both eyes see the same faces, one of them rolled by about +12 degrees and the other by -12")
    if captures < CAPTURES:
        return (f"two captures do not tell {what} well enough: add a third of the same room, the sensor turned by 20 to 30 degrees "
                "and rolled by about 12, to the other side than one before")
    return (f"these captures do not tell {what} well enough: record a room with faces in more directions, floor and ceiling "
            "among them, the sensor turned by 20 to 30 degrees between captures and rolled by about +12 in one and -12 in another")


def _parameters(problem: Problem, found: _Found) -> list[Parameter]:
    sigma = np.sqrt(np.diag(found.covariance))
    made = []
    for index, key in enumerate(KEYS):
        is_held = bool(found.held[index])
        made.append(Parameter(key, float(found.fit.state.values[index]), float(problem.before[index]),
                              float("inf") if is_held else float(sigma[index]), _why_held(key, problem.captures) if is_held else ""))
        if is_held:
            made[-1].value = made[-1].before
    for eye, centre in zip(EYES, problem.fixed.centres):
        made.append(Parameter(f"{eye}.azimuth.center_deg", float(centre), float(centre), float("inf"), _CENTRE))
    return made


def _tell_residuals(problem: Problem, before: State, after: State) -> Residuals:
    parts: dict[str, list[Array]] = {name: [] for name in Residuals.__dataclass_fields__}
    for group in problem.groups:
        eye, old = Eye(group.cells, after, problem.fixed), Eye(group.cells, before, problem.fixed)
        count = len(group.count)
        for name, values in (("eye", np.full(count, group.cells.eye)), ("range_m", group.mean(eye.expected)),
                             ("azimuth_deg", group.mean(eye.azimuth_deg)), ("elevation_deg", group.mean(eye.elevation_deg)),
                             ("plane", group.plane), ("capture", np.full(count, group.cells.capture)),
                             ("before_m", group.mean(old.residual)), ("after_m", group.mean(eye.residual))):
            parts[name].append(values)
    return Residuals(**{name: np.concatenate(values) for name, values in parts.items()})


def _tell_planes(problem: Problem, before: Array, after: Array, state: State) -> list[Plane]:
    plane = np.concatenate([group.plane for group in problem.groups])
    made = []
    for j in range(len(state.offsets)):
        mine = [(group, group.cells.plane == j) for group in problem.groups]
        mine = [(group, at) for group, at in mine if at.any()]
        points = [Eye(group.cells, state, problem.fixed).points[at] for group, at in mine]
        every = np.concatenate(points) if points else np.empty((0, 3))
        made.append(Plane(state.normals[j], float(state.offsets[j]), tuple(sorted({group.cells.capture for group, _ in mine})),
                          tuple(sorted({group.cells.eye for group, _ in mine})), len(every),
                          every[::max(1, len(every) // _SHOWN_POINTS)], _rms(before[plane == j]), _rms(after[plane == j])))
    return made


def _apart(row: Array) -> Array:
    """Which captures move against the others along a direction that nothing tells: row has all captures but the first."""
    moved = np.concatenate((np.zeros((1, 3)), row))
    away = np.linalg.norm(moved - np.median(moved, 0), axis=1)
    return np.flatnonzero(away > 0.5 * away.max())


def _pose_notes(problem: Problem, state: State, names: Sequence[str]) -> Iterator[str]:
    """What the faces that captures share do not tell of how the sensor stood."""
    if problem.captures < 2:
        return
    turns, places = untold(problem.groups, problem.captures, state.normals)
    for rows, is_turn in ((turns, True), (places, False)):
        for row in rows:
            who = " and ".join(names[k] for k in _apart(row))
            if not is_turn and (row[:, 2] ** 2).sum() > 0.5:
                yield (f"{who}: no floor or ceiling that another capture shows too: how high the sensor stood is not told, and was "
                       "taken as the same; pitch the sensor down a little, so that it sees the floor")
            else:
                yield (f"{who}: faces that other captures show too lie in too few directions: how the sensor {'turned' if is_turn else 'moved'} "
                       "is not wholly told, and was left as first guessed; turn it so that it sees more of the faces that others see")


def _notes(grids: Sequence[Grid]) -> Iterator[str]:
    for g in grids:
        if g.frames < _FRAMES:
            yield f"{g.name}: {g.frames} whole frames; {_FRAMES} or more measure better"
    if len(grids) < CAPTURES:
        yield (f"{len(grids)} capture{'s' if len(grids) > 1 else ''}; {CAPTURES} suffice, the sensor turned by 20 "
               "to 30 degrees between them, one rolled by about +12 degrees and one by -12")


# --- All of it ---


def _scene(grids: Sequence[Grid], calibration: Calibration) -> tuple[Scene, State, Array]:
    views = [look(g, calibration) for g in grids]
    for view in views:
        if not view.patches:
            raise CaptureError(f"{view.grid.name}: shows no flat face; record a room or a yard with walls")
    poses = place_all(views)
    if len({g.is_span for g in grids}) > 1:
        raise CaptureError("some captures have angles in degrees, others as parts of the span: they are not of one sensor")
    scene = Scene(views, begin(views, poses, calibration), fixed_of(calibration, grids[0].is_span), values_of(calibration))
    state, of = join(scene, poses)
    return scene, state, of


def solve_grids(grids: Sequence[Grid], calibration: Calibration) -> Solution:
    """Calibrate from grids of captures."""
    scene, state, of = _scene(grids, calibration)
    groups, tiles = observe(scene, state, of)
    problem, found = _settle(Problem(groups, scene.fixed, scene.before, len(grids), tiles), state)
    groups = problem.groups
    old = _with_values(problem, state, problem.before)
    new = _with_values(problem, found.fit.state, found.fit.state.values)
    before, after = _residuals(groups, old, problem), _residuals(groups, new, problem)
    held_out = _held_out(problem, found)
    compared = held_out if np.isfinite(held_out[0]) else (_rms(before), _rms(after))
    notes = [*_notes(grids), *_pose_notes(problem, found.fit.state, [g.name for g in grids])]
    if not np.isfinite(held_out[0]):
        notes.append("too few faces to hold one out: whether the calibration is better was judged on the faces it is made of")
    return Solution(_parameters(problem, found), _tell_residuals(problem, old, new), _tell_planes(problem, before, after, new),
                    [g.name for g in grids], _rms(before), _rms(after), *held_out,
                    is_better=compared[1] <= compared[0] * _WORSE[0] + _WORSE[1], base=_nested(calibration), notes=notes)


def run(options: Options) -> Solution:
    """Calibrate. Raises lumsdk.OptionError, or lumsdk.CaptureError, also where the captures do not suffice."""
    given = options.calibration
    calibration = given if isinstance(given, Calibration) else Calibration(given)
    return solve_grids([grid(capture, options.profile, calibration=calibration, **options.reading) for capture in options.captures],
                       calibration)


# --- As a file ---


def _nested(calibration: Calibration) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for key, value in calibration.items():
        place = made
        *above, name = key.split(".")
        for part in above:
            place = place.setdefault(part, {})
        place[name] = value
    return made


_DIGITS = {"deg": 5, "ps": 2, "m": 6}
_BLUE = "as it was: the frame of the sensor follows from it"


def _written(key: str, value: float) -> str:
    return f"{value:.{_DIGITS.get(key.rsplit('_', 1)[-1], 6)}f}"


def _comment(key: str, parameter: Optional[Parameter]) -> str:
    if parameter is None:
        return f"  # {_BLUE}" if key.startswith("eyes.blue.mount.") else ""
    if parameter.held:
        return f"  # held: {parameter.held}"
    was = _written(key, parameter.before)
    return f"  # +- {_written(key, parameter.sigma)}, was {was}"


def _lines(values: dict[str, Any], parameters: dict[str, Parameter], above: str = "") -> Iterator[str]:
    for name, value in values.items():
        key, indent = above + name, "  " * above.count(".")
        if isinstance(value, dict):
            yield f"{indent}{name}:"
            yield from _lines(value, parameters, key + ".")
        else:
            told = _written(key, value) if key.startswith("eyes.") else f"{value!r}"
            yield f"{indent}{name}: {told}{_comment(key, parameters.get(key))}"


def _printable(name: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in os.fsdecode(name))


def to_yaml(solution: Solution) -> str:
    """A calibration file with standard deviations and provenance as comments; it loads as it is."""
    from .. import __version__

    told = [f"Calibration by lumcal eyes of lumsdk {__version__}, from", *(f"    {_printable(name)}" for name in solution.captures),
            "Behind each value stand its standard deviation and the value before.",
            f"{len(solution.planes)} faces, root mean square {solution.rms_before_m * 1e3:.2f} mm before, "
            f"{solution.rms_after_m * 1e3:.2f} mm after"]
    if np.isfinite(solution.held_out_before_m):
        told.append(f"on faces held out {solution.held_out_before_m * 1e3:.2f} mm before, "
                    f"{solution.held_out_after_m * 1e3:.2f} mm after")
    told += map(_printable, solution.notes)
    parameters = {f"eyes.{parameter.key}": parameter for parameter in solution.parameters}
    return "\n".join([*(f"# {line}" for line in told), *_lines(solution.calibration(), parameters), ""])


def _number(value: float) -> Optional[float]:
    return float(value) if np.isfinite(value) else None


def to_json(solution: Solution) -> dict[str, Any]:
    """What --json prints. A standard deviation is null where the value is held."""
    return {
        "captures": [os.fsdecode(name) for name in solution.captures],
        "parameters": [{"key": f"eyes.{p.key}", "value": p.value, "before": p.before, "sigma": _number(p.sigma),
                        "held": p.held or None}
                       for p in solution.parameters],
        "planes": [{"normal": [float(x) for x in p.normal], "offset_m": p.offset, "captures": list(p.captures),
                    "eyes": [EYES[e] for e in p.eyes], "cells": p.cells, "rms_before_m": _number(p.rms_before_m),
                    "rms_after_m": _number(p.rms_after_m)} for p in solution.planes],
        "rms_before_m": _number(solution.rms_before_m), "rms_after_m": _number(solution.rms_after_m),
        "held_out_before_m": _number(solution.held_out_before_m), "held_out_after_m": _number(solution.held_out_after_m),
        "is_better": solution.is_better, "notes": solution.notes,
    }
