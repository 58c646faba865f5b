"""lumcal eyes: from captures of a room to a calibration."""
from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Optional

import numpy as np

from .._errors import CaptureError, OptionError
from .._grid import EYES
from .._settings import Calibration, Profile, setting_of
from .._source import open as open_source
from ._check import check_grid, has_wall
from ._faces import Scene, begin, join, observe, rejoin, without
from ._match import look, place_all
from ._model import CALIBRATION_COUNT, ORDERS, Eye, State, fixed_of, priors, tangents, values_of
from ._planes import Grid, grid
from ._solution import KEYS, WISHES, Array, Parameter, Plane, Residuals, Solution, put
from ._solve import Fit, Group, Problem, Spread, covariance, estimate_bends, estimate_spread, linearise, solve, untold
from ._tell import ADD_TWO, MOUNT, bends, exchange, more_captures, not_written

_WORTH = 0.5
"""A value is held if its uncertainty stays above this share of its prior."""
_PART = 0.3
"""A key is named with an uncertain direction if its component is larger."""

_HELD_OUT = 3
_FACES_LEFT = 5
_SPARE_SQUARES = 20
_LYING, _ALIKE = 0.7, 0.9
_BENT = 0.004, 6.0
"""Reject a face whose median residual exceeds this many metres and this many times the median of all faces."""

_MOVED = 0.002, 6.0
"""The same for the part of a face that one capture and eye see: it has moved, or is another face."""

_ROUNDS, _CLEANINGS, _JOININGS = 20, 6, 3
"""At most: rounds of a fit, removals of faces, and new joinings of patches."""

_WORSE = 1.02, 0.0002
_SHOWN_POINTS = 400
_FRAMES = 20

CAPTURES = 3
"""The fewest that should be given."""


@dataclass
class Options:
    """The options of `lumcal eyes`."""

    captures: Sequence[str]
    calibration: Any = None
    """What it was before: a lumsdk.Calibration, a path, or None for that of the captures, or the typical one."""
    profile: Any = None
    reading: dict[str, Any] = field(default_factory=dict)
    """More options of lumsdk.open(), such as sensor=."""
    changes: Sequence[str] = ()
    """Pairs KEY=VALUE on top of the calibration."""
    named: str = ""
    """How the calibration is called, where one is given."""


@dataclass
class _Found:
    """A solution with what is held."""

    fit: Fit
    held: Array
    covariance: Array
    spread: Spread
    moved: set[int]
    """Captures of faces that were left out."""


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


def _misfits(problem: Problem, fit: Fit) -> Array:
    """Which faces stand elsewhere in a capture and an eye than the others have them: (groups, faces)."""
    made = np.zeros((len(problem.groups), len(fit.state.offsets)), bool)
    plane = np.concatenate([group.plane for group in problem.groups])
    number = np.repeat(np.arange(len(problem.groups)), [len(group.count) for group in problem.groups])
    # Where only this capture sees the face, its heights take up what is off; elsewhere they are shared.
    for off, least in ((fit.left, _MOVED[0]), (fit.linear.residual, 3 * _MOVED[0])):
        across = off / np.sqrt(fit.linear.slant)
        usual = np.zeros(made.shape)
        for index, j in np.unique(np.stack((number, plane), 1), axis=0):
            usual[index, j] = abs(float(np.median(across[(number == index) & (plane == j)])))
        # What is wrong pulls others with it: the worst go first.
        made |= usual > max(least, _MOVED[1] * float(np.median(usual[usual > 0])), 0.5 * float(usual.max()))
    return made


def _fitting(problem: Problem, state: State) -> tuple[Problem, Fit, set[int]]:
    """The problem without what is no plane or has moved, its fit, and the captures of what has moved."""
    moved: set[int] = set()
    fit = solve(problem, state, _ROUNDS)
    for _ in range(_CLEANINGS):
        is_out = _misfits(problem, fit)
        if is_out.any():
            fewer: Optional[Problem] = problem.of(without(problem.groups, is_out))
            moved |= {problem.groups[index].cells.capture for index in np.flatnonzero(is_out.any(1))}
        else:
            fewer = _without_bent(problem, fit)
        if fewer is None or not fewer.groups:
            break
        problem, fit = fewer, solve(fewer, state, _ROUNDS)
    return problem, fit, moved


def _weigh(problem: Problem, fit: Fit) -> Fit:
    """Estimate the variance components."""
    problem.spread = estimate_spread(problem, fit)
    fit = solve(problem, fit.state, 4)
    problem.spread = estimate_bends(problem, fit)
    return solve(problem, fit.state, 4)


def _hold(held: Array, fit: Fit) -> tuple[Array, Array]:
    """What else is to be held, the least known first, and the covariance then."""
    while True:
        known = covariance(fit, held)
        share = np.where(held, 0.0, np.sqrt(np.diag(known)) / priors())
        if share.max() <= _WORTH:
            return held, known
        held = held.copy()
        held[share.argmax()] = True


def _settle(problem: Problem, state: State) -> tuple[Problem, _Found]:
    """Estimate the variance components, then hold what the captures do not tell."""
    problem, fit, moved = _fitting(problem, state)
    for _ in range(2):
        fit = _weigh(problem, fit)
    problem.lets_go = True
    fit = solve(problem, fit.state, _ROUNDS)
    held = np.zeros(CALIBRATION_COUNT, bool)
    while True:
        more, known = _hold(held, fit)
        if (more == held).all():
            return problem, _Found(fit, held, known, problem.spread, moved)
        held = problem.held = more
        start = fit.state.copy()
        start.values[held] = problem.before[held]
        fit = solve(problem, start, _ROUNDS)


def _with_values(problem: Problem, state: State, values: Array) -> State:
    """Poses and faces that fit best where the calibration is given, as a file has it: without bends of the mirrors."""
    total = float(np.linalg.norm([problem.spread.wave, problem.spread.spot, problem.spread.bow]))
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
    """Faces that can be held out: seen more than once and of a middling size, the first ones a lying and a standing one.

    Others lie in the same direction, and tell what these would have told.
    """
    count = len(state.offsets)
    squares = np.stack([np.bincount(group.plane, minlength=count) for group in problem.groups])
    spare = np.flatnonzero(((squares > 0).sum(0) > 1) & (squares.sum(0) >= _SPARE_SQUARES))
    order = spare[np.argsort(-squares.sum(0)[spare], kind="stable")]
    order = np.roll(order, -(len(order) // 3))
    lies = np.abs(state.normals[order, 2]) > _LYING
    first = [*order[lies][:1], *order[~lies][:1]]
    used = squares.sum(0) > 0
    made: list[int] = []
    for j in [*first, *(i for i in order if i not in first)]:
        others = used.copy()
        others[[*made, j]] = False
        if len(made) == _HELD_OUT or others.sum() < _FACES_LEFT:
            break
        if np.abs(state.normals[others] @ state.normals[j]).max() > _ALIKE and _tells_poses(problem, state, ~others):
            made.append(int(j))
    return np.array(made, "i8")


def _tells_poses(problem: Problem, state: State, is_out: Array) -> bool:
    """Whether the poses are told as well without some faces."""
    if problem.captures < 2:
        return True
    rest = without(problem.groups, is_out)
    return [len(rows) for rows in untold(rest, problem.captures, state.normals)] == \
        [len(rows) for rows in untold(problem.groups, problem.captures, state.normals)]


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
    """Root mean squares on faces that the solution has not seen, before and after; nan where none can be spared.

    Their patches were joined by a solution that had seen them; variances are estimated without them.
    """
    spare = _spare_faces(problem, found.fit.state)
    if not len(spare):
        return float("nan"), float("nan")
    is_spare = np.zeros(len(found.fit.state.offsets), bool)
    is_spare[spare] = True
    rest = problem.of(without(problem.groups, is_spare))
    kept = problem.of(without(problem.groups, ~is_spare))
    rest.spread, rest.lets_go = Spread(), False
    fit = _weigh(rest, solve(rest, found.fit.state))
    rest.lets_go = True
    values = solve(rest, fit.state).state.values
    made = [_rms(_fit_faces(kept, _with_values(rest, found.fit.state, v))) for v in (problem.before, values)]
    return made[0], made[1]


# --- What is told ---


_CENTRE = ("cannot be told from the yaw of the eye's mount, which includes it")


_DEGREES = {"azimuth.width_deg": "the width has no meaning there",
            "elevation.min_deg": "only the middle between the two ends has a meaning there",
            "elevation.max_deg": "only the middle between the two ends has a meaning there"}

_FLOOR = ("the floor under both eyes: pitch the sensor down a little, and roll it by about 12 degrees to the side where an eye "
          "misses the floor")
_AHEAD = ("a wall straight ahead that blue sees in one capture and green in another, the sensor turned by 20 to 30 degrees "
          "between")
_ENDS = "one wall, or the floor, in captures rolled by about +12 and -12 degrees, at the top and at the bottom of the eye's view"
_TELLS = {
    "mount.x_m": _AHEAD, "mount.yaw_deg": _AHEAD,
    "mount.y_m": "a wall at the side that blue sees in one capture and green in another, the sensor turned further",
    "mount.z_m": _FLOOR, "mount.roll_deg": _FLOOR, "mount.pitch_deg": _FLOOR,
    "tof_offset_ps": "walls near and far in the same direction, and ahead as well as at the side",
    "azimuth.width_deg": "a flat wall across the whole view of the eye",
    "elevation.min_deg": _ENDS, "elevation.max_deg": _ENDS}
"""What to record for a key."""


def _why_held(key: str, captures: int, is_span: bool) -> str:
    if not is_span and key.split(".", 1)[1] in _DEGREES:
        return f"the profile gives angles in degrees, and {_DEGREES[key.split('.', 1)[1]]}; no recording changes that"
    if captures == 1:
        what = MOUNT if ".mount." in key else "it"
        return f"one capture does not determine {what}: {ADD_TWO}"
    return f"these captures do not determine it well enough: add one of the same room that shows {_TELLS[key.split('.', 1)[1]]}"


def _parameters(problem: Problem, found: _Found) -> list[Parameter]:
    sigma = np.sqrt(np.diag(found.covariance))
    made = []
    for index, key in enumerate(KEYS):
        is_held = bool(found.held[index])
        why = _why_held(key, problem.captures, problem.fixed.is_span) if is_held else ""
        made.append(Parameter(key, float(found.fit.state.values[index]), float(problem.before[index]),
                              float("inf") if is_held else float(sigma[index]), why))
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
            who = " and ".join([str(names[int(k)]) for k in _apart(row)])
            if not is_turn and (row[:, 2] ** 2).sum() > 0.5:
                yield (f"{who}: no floor or ceiling in common with another capture: the sensor's height is unknown "
                       "and was taken as the same; pitch the sensor down a little, so that it sees the floor")
            else:
                yield (f"{who}: faces that other captures show too lie in too few directions: how the sensor "
                       f"{'turned' if is_turn else 'moved'} is not fully determined, and was left as first guessed; turn it so that "
                       "it sees more of the faces that others see")


def _together(found: _Found) -> Iterator[str]:
    """What is hardly told, though each value of it seems to be."""
    free = ~found.held
    if not free.any():
        return
    scale = priors()[free]
    values, vectors = np.linalg.eigh(found.covariance[np.ix_(free, free)] / scale[:, None] / scale)
    if values[-1] > _WORTH ** 2:
        keys = " and ".join(key for key, part in zip(np.array(KEYS)[free], vectors[:, -1]) if abs(part) > _PART)
        yield (f"{keys}: together they are hardly determined, {np.sqrt(values[-1]):.0%} as uncertain as before; captures with more "
               "roll, and walls near and far, would determine them better")


def _fit_notes(found: _Found, names: Sequence[str]) -> Iterator[str]:
    for k in sorted(found.moved):
        yield (f"{names[k]}: shows a face at another place than the other captures or its other eye; it was left out. "
               "Has something moved?")


def _notes(grids: Sequence[Grid]) -> Iterator[str]:
    for g in grids:
        if g.shift_m > 0:
            yield (f"{g.name}: ranges change by up to {1000 * g.shift_m:.0f} mm within the recording: the sensor was moved, or "
                   "something in front of it; better record it again")
        if g.frames < _FRAMES:
            yield f"{g.name}: {g.frames} whole frames; {_FRAMES} or more measure better"
    if len(grids) < CAPTURES:
        yield (f"{len(grids)} capture{'s' if len(grids) > 1 else ''}; use at least {CAPTURES}, the sensor turned by 20 "
               "to 30 degrees between them, one rolled by about +12 degrees and one by -12")


def _exchanged(grids: Sequence[Grid], *calibrations: Calibration) -> str:
    """What to do where, by each calibration, a wall continues from eye to eye only with the eyes exchanged, in no capture as they are
    called; empty: it does not."""
    for calibration in calibrations:
        found = [check_grid(g, calibration, "") for g in grids]
        if any(has_wall(made.seams) for made in found) or not any(made.is_exchanged for made in found):
            return ""
    return exchange(grids[0].eye_values)


# --- All of it ---


def _scene(grids: Sequence[Grid], calibration: Calibration) -> tuple[Scene, State, Array]:
    views = [look(g, calibration) for g in grids]
    for view in views:
        if not view.patches:
            raise CaptureError(f"{view.grid.name}: shows no flat face; record a room or a yard with walls")
    poses = place_all(views)
    if len({g.is_span for g in grids}) > 1:
        raise CaptureError("some captures have angles in degrees, others as parts of the span: they are from different sensors")
    scene = Scene(views, begin(views, poses, calibration), fixed_of(calibration, grids[0].is_span), values_of(calibration))
    state, of = join(scene, poses)
    return scene, state, of


def _solved(scene: Scene, state: State, of: Array) -> tuple[Problem, _Found, State]:
    """A solution of which the patches are joined as it sees them, and the state that it began from."""
    moved: set[int] = set()
    turn = 0
    while True:
        groups, surface = observe(scene, state, of)
        problem, found = _settle(Problem(groups, scene.fixed, scene.before, len(scene.views), surface), state)
        moved = found.moved = moved | found.moved
        better, again = rejoin(scene, found.fit.state, of)
        turn += 1
        if turn == _JOININGS or (again == of).all():
            return problem, found, state
        state, of = better, again


def solve_grids(grids: Sequence[Grid], calibration: Calibration) -> Solution:
    """Calibrate from grids of captures. Raises lumsdk.CaptureError."""
    try:
        return _solve_grids(grids, calibration)
    except np.linalg.LinAlgError as error:
        names = ", ".join(os.fsdecode(g.name) for g in grids)
        raise CaptureError(f"{names}: do not determine a solution ({error}); record a room with walls in several directions and the "
                           "floor") from error


def _solve_grids(grids: Sequence[Grid], calibration: Calibration) -> Solution:
    scene, state, of = _scene(grids, calibration)
    problem, found, state = _solved(scene, state, of)
    groups = problem.groups
    old = _with_values(problem, state, problem.before)
    new = _with_values(problem, found.fit.state, found.fit.state.values)
    before, after = _residuals(groups, old, problem), _residuals(groups, new, problem)
    held_out = _held_out(problem, found)
    compared = held_out if np.isfinite(held_out[0]) else (_rms(before), _rms(after))
    names = [os.fsdecode(g.name) for g in grids]
    notes = [*_notes(grids), *_pose_notes(problem, found.fit.state, names),
             *_fit_notes(found, names), *_together(found)]
    if not np.isfinite(held_out[0]):
        notes.append("too few faces to hold one out: the calibration was judged on the faces that it was fitted to")
    planes = _tell_planes(problem, before, after, new)
    for plane, bias in zip(planes, found.fit.state.biases):
        plane.bias_m = float(bias)
    allowed_m = compared[0] * _WORSE[0] + _WORSE[1]
    is_better = found.fit.is_settled and compared[1] <= allowed_m
    made = Solution(_parameters(problem, found), _tell_residuals(problem, old, new), planes,
                    [g.name for g in grids], _rms(before), _rms(after), *held_out, is_better=is_better,
                    base=_nested(calibration), notes=notes, allowed_m=allowed_m, bends_deg=found.fit.state.bends,
                    spread=asdict(found.spread), is_settled=found.fit.is_settled,
                    poses=[(pose.turn, pose.place) for pose in found.fit.state.poses])
    made.exchanged = _exchanged(grids, calibration, Calibration(made.calibration()))
    return made


def _own(options: Options) -> tuple[Calibration, str]:
    """The calibration that captures bring with them, or the typical one."""
    reading = dict(options.reading) if options.profile is None else {**options.reading, "profile": options.profile}
    typical, own = Calibration(), {}
    for capture in options.captures:
        with open_source(capture, **reading) as source:
            if source.calibration != typical:
                own[capture] = source.calibration
    if not own:
        return typical, "typical values"
    first, *others = own
    for other in others:
        if own[other] != own[first]:
            raise OptionError(f"{other}: its calibration is not that of {first}: name the one to start from by --calibration")
    return own[first], "the captures' own"


def run(options: Options) -> Solution:
    """Calibrate. Raises lumsdk.OptionError, or lumsdk.CaptureError, also where the captures do not suffice."""
    given = options.calibration
    if given is None:
        calibration, began = _own(options)
    else:
        calibration, began = given if isinstance(given, Calibration) else Calibration(given), options.named
    calibration = setting_of(calibration, Profile(), list(options.changes))[0]
    grids = [grid(capture, options.profile, calibration=calibration, **options.reading) for capture in options.captures]
    solution = solve_grids(grids, calibration)
    for parameter in solution.parameters:
        parameter.wish = next((sigma for end, sigma in WISHES.items() if parameter.key.endswith(end)), float("inf"))
    solution.began = (began or "a given one") + (" and --set" if options.changes else "")
    return solution


# --- As a file ---


def _nested(calibration: Calibration) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for key, value in calibration.items():
        put(made, key, value)
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
            f"After each value: its standard deviation, and the value before from {_printable(solution.began)}.",
            f"{len(solution.planes)} faces, root mean square {solution.rms_before_m * 1e3:.2f} mm before, "
            f"{solution.rms_after_m * 1e3:.2f} mm after"]
    if np.isfinite(solution.held_out_before_m):
        told.append(f"on faces held out {solution.held_out_before_m * 1e3:.2f} mm before, "
                    f"{solution.held_out_after_m * 1e3:.2f} mm after")
    told.append("Also found, but not in this file: mirror readings are bent by up to "
                + ", ".join(f"{bent:.4f} degrees ({name})" for name, bent in bends(solution)))
    told += map(_printable, solution.notes)
    parameters = {f"eyes.{parameter.key}": parameter for parameter in solution.parameters}
    return "\n".join([*(f"# {line}" for line in told), *_lines(solution.calibration(), parameters), ""])


def _number(value: float) -> Optional[float]:
    return float(value) if np.isfinite(value) else None


def to_json(solution: Solution) -> dict[str, Any]:
    """What --json prints. A standard deviation is null where the value is held."""
    more = more_captures(solution)
    return {
        "captures": [os.fsdecode(name) for name in solution.captures],
        "parameters": [{"key": f"eyes.{p.key}", "value": p.value, "before": p.before, "sigma": _number(p.sigma),
                        "held": p.held or None, "wish": _number(p.wish), "more_captures": more[p.key]}
                       for p in solution.parameters],
        "planes": [{"normal": [float(x) for x in p.normal], "offset_m": p.offset, "captures": list(p.captures),
                    "eyes": [EYES[e] for e in p.eyes], "cells": p.cells, "rms_before_m": _number(p.rms_before_m),
                    "rms_after_m": _number(p.rms_after_m), "bias_m": _number(p.bias_m)} for p in solution.planes],
        "rms_before_m": _number(solution.rms_before_m), "rms_after_m": _number(solution.rms_after_m),
        "held_out_before_m": _number(solution.held_out_before_m), "held_out_after_m": _number(solution.held_out_after_m),
        "allowed_m": _number(solution.allowed_m), "is_better": solution.is_better, "began": solution.began,
        "bends_deg": {eye: {mirror: {f"p{order}": float(term) for order, term in zip(ORDERS, terms)}
                            for mirror, terms in zip(("azimuth", "elevation"), both)} for eye, both in zip(EYES, solution.bends_deg)},
        "spread": {name: _number(value) for name, value in solution.spread.items()}, "notes": solution.notes,
        "not_written": not_written(solution) or None,
    }
