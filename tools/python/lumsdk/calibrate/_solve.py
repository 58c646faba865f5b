"""Robust least squares of calibration, poses and faces together, and what it knows of its own errors.

Neighbouring cells of a face count as one observation. Faces are neither flat nor equally bright: they stand out in waves and
as a bow, so that observations of one face err alike, the more so the nearer they are to each other, whichever eye and capture
they are of; each observation errs a little more; and each face has a bias of range. How much of each there is, and how far the
mirrors' readings are bent, is estimated from the captures (restricted maximum likelihood) before any prior is trusted.
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Optional

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from ._match import Pose
from ._model import BEND_COUNT, CALIBRATION_COUNT, Cells, Eye, Fixed, State, priors, tangents, turned
from ._solution import Array
from ._waves import bow, waves

BEND_DEG, BIAS_M = 0.01, 0.004
"""Prior of the mirrors' bends and of the faces' biases, within a factor of e."""

TILE_M = 0.25
"""Side of a square of a face, whose cells are one observation for each eye and capture."""

TILES_MAX = 2500
"""Most observations; squares grow to keep this limit."""

_NEAR_ZERO_M = 1e-5, 5e-5, 1e-5

_AWAY_M = np.linspace(0.0, 100.0, 50001)
_ALIKE = waves(_AWAY_M)
"""Correlation of heights at these distances."""

_OWN = 0.001
"""Share of a height's variance that is independent of its neighbours."""

_BOW = 1 / 3
"""Usual bow of a face as a share of its waves, within a factor of e."""

_HUBER = 3.0
_LET_GO = 6.0, 12.0
"""Standard deviations from which an observation counts less, and from which it counts nothing."""
_SETTLED, _STEP = 1e-3, 0.02
"""A fit has settled when no step exceeds this share of the prior, or of the second number where there is no prior."""
_LOOSE = 1.0
"""Weight that limits a pose or a face that hardly anything measures: a radian or a metre a round."""
_TIGHT = 1e18
_STILL, _STILL_SHARE, _STILL_SQUARES = 1e9, float(np.sin(np.radians(4.0)) ** 2), 20
"""Weight that fixes a pose along a direction whose information is below this share of the best; and the most squares
that a face counts for."""


@dataclass
class Group:
    """Cells, and the observation that each belongs to."""

    cells: Cells
    of: Array
    count: Array
    plane: Array
    place: Array
    """Which place of the surface each observation is at; -1 without a surface."""
    noise: Array
    """Variance of each observation by the noise of ranges."""

    def mean(self, values: Array) -> Array:
        made: Array = np.bincount(self.of, values, len(self.count)) / self.count
        return made


@dataclass
class Linear:
    """Observations about a state."""

    residual: Array
    """Measured less expected, heights of faces left in."""
    matrix: sparse.csr_matrix
    """Derivatives of the residual."""
    noise: Array
    lean: Array
    """1 / (normal . direction): how much a range changes by the height of its face."""
    slant: Array
    """The mean of its square."""
    place: Array
    """As in Group."""


@dataclass
class Spread:
    """Variance components, as standard deviations in metres."""

    wave: float = 0.0015
    """Waves of faces."""
    spot: float = 0.0005
    """What each observation errs on its own."""
    bow: float = 0.001
    """Faces that are bent as a whole."""
    bend_deg: float = BEND_DEG
    bias: float = BIAS_M


@dataclass
class Layout:
    """Where each unknown stands."""

    captures: int
    planes: int

    @property
    def poses(self) -> int:
        return CALIBRATION_COUNT + BEND_COUNT

    @property
    def faces(self) -> int:
        return self.poses + 6 * (self.captures - 1)

    @property
    def biases(self) -> int:
        return self.faces + 3 * self.planes

    @property
    def size(self) -> int:
        return self.biases + self.planes


@dataclass
class Problem:
    """What is solved: observations, what is known before, and what is held."""

    groups: list[Group]
    fixed: Fixed
    before: Array
    captures: int
    surface: Surface = field(default_factory=lambda: Surface(np.zeros((0, 3))))
    spread: Spread = field(default_factory=Spread)
    held: Array = field(default_factory=lambda: np.zeros(CALIBRATION_COUNT, bool))
    loss_m: float = 0.0
    """Observations further off than this count less, in the first rounds; 0: by their standard deviations."""
    is_bent: bool = True
    """Whether the readings of mirrors may be bent."""
    lets_go: bool = False
    """Whether observations that are far off do not count at all, as near a solution, where what is far off is wrong."""

    def of(self, groups: list[Group]) -> Problem:
        """The same with other observations."""
        return replace(self, groups=groups)


# --- Cells to observations ---


def group_cells(cells: Cells, state: State, fixed: Fixed, tile_m: float) -> tuple[Group, Array]:
    """Squares of faces as observations; and where they are: (n, 3), of plane and place on it in metres."""
    points = Eye(cells, state, fixed).points
    first, second = tangents(state.normals)
    s = (first[cells.plane] * points).sum(1)
    t = (second[cells.plane] * points).sum(1)
    row, column = np.floor(s / tile_m).astype("i8"), np.floor(t / tile_m).astype("i8")
    key = (cells.plane.astype("i8") << 40) + ((row + (1 << 19)) << 20) + column + (1 << 19)
    _, index, of = np.unique(key, return_index=True, return_inverse=True)
    of = of.ravel()
    count = np.bincount(of).astype("f8")
    noise = np.bincount(of, cells.variance) / count ** 2
    group = Group(cells, of, count, cells.plane[index], np.full(len(count), -1), noise)
    return group, np.stack((group.plane, group.mean(s), group.mean(t)), 1)


@dataclass
class _Face:
    """Which places are of a face, and how alike they are by waves and by a bow."""

    at: Array
    waves: Array
    bow: Array


class Surface:
    """How alike the heights of faces are, at places by plane and place on it in metres: (n, 3)."""

    def __init__(self, places: Array) -> None:
        self.places = places
        self._faces = [self._face(np.flatnonzero(places[:, 0] == plane)) for plane in np.unique(places[:, 0])]

    def __len__(self) -> int:
        return len(self.places)

    def _face(self, at: Array) -> _Face:
        away = cdist(self.places[at, 1:], self.places[at, 1:])
        return _Face(at, np.interp(away, _AWAY_M, _ALIKE, right=0.0), bow(away))

    def covariances(self, place: Array, spread: Spread) -> Iterator[tuple[Array, Array]]:
        """Observations of each face by the place of each, and the covariance of their heights."""
        if not len(self):
            return
        where = np.full(len(self), -1)
        where[place[place >= 0]] = np.flatnonzero(place >= 0)
        for face in self._faces:
            at = where[face.at]
            seen = np.flatnonzero(at >= 0)
            if len(seen):
                index = np.ix_(seen, seen)
                made = spread.wave ** 2 * face.waves[index] + spread.bow ** 2 * face.bow[index]
                made[np.diag_indices_from(made)] *= 1 + _OWN
                yield at[seen], made


def surface_of(groups: Sequence[Group], places: Sequence[Array]) -> Surface:
    """The surface of all captures' observations: heights stand out for all alike."""
    at = 0
    for group in groups:
        group.place = np.arange(at, at + len(group.count))
        at += len(group.count)
    return Surface(np.concatenate(places))


# --- The linear problem ---


def _columns(group: Group, state: State, fixed: Fixed, layout: Layout) -> tuple[Eye, list[tuple[Array, Array]]]:
    """Columns of the matrix for a group: (number of the unknown for each observation, derivative)."""
    eye = Eye(group.cells, state, fixed)
    same = np.zeros(len(group.count), "i8")
    made: list[tuple[Array, Array]] = []

    def add(first: int, columns: Sequence[Array], spacing: Optional[Array] = None) -> None:
        for index, column in enumerate(columns):
            made.append((same + first + index + (0 if spacing is None else spacing), group.mean(column)))

    own, bends = eye.eye_columns()
    add(4 * group.cells.eye, own)
    add(CALIBRATION_COUNT + BEND_COUNT // 2 * group.cells.eye, bends)
    if group.cells.eye == 1:
        add(8, eye.mount_columns())
    if group.cells.capture > 0:
        add(layout.poses + 6 * (group.cells.capture - 1), eye.pose_columns())
    add(layout.faces, eye.plane_columns(), 3 * group.plane)
    add(layout.biases, [np.full_like(eye.expected, -1.0)], group.plane)
    return eye, made


def linearise(problem: Problem, state: State) -> tuple[Linear, Layout]:
    """The observations about a state."""
    layout = Layout(problem.captures, len(state.offsets))
    residual, noise, lean, slant, rows, where, values = [], [], [], [], [], [], []
    at = 0
    for group in problem.groups:
        eye, columns = _columns(group, state, problem.fixed, layout)
        count = len(group.count)
        residual.append(group.mean(eye.residual))
        lean.append(group.mean(1 / eye.slope))
        slant.append(group.mean(1 / eye.slope ** 2))
        noise.append(group.noise)
        for number, column in columns:
            rows.append(np.arange(at, at + count))
            where.append(number)
            values.append(column)
        at += count
    matrix = sparse.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(where))), (at, layout.size))
    place = np.concatenate([group.place for group in problem.groups])
    return Linear(np.concatenate(residual), matrix, np.concatenate(noise), np.concatenate(lean), np.concatenate(slant), place), layout


def _prior(problem: Problem, state: State, layout: Layout) -> tuple[Array, Array, Array]:
    """Weight of what is known of each unknown, how far the state is from that, and what keeps the poses."""
    weight, away = np.full(layout.size, _LOOSE), np.zeros(layout.size)
    weight[:CALIBRATION_COUNT] = np.where(problem.held, _TIGHT, 1.0) / priors() ** 2
    away[:CALIBRATION_COUNT] = problem.before - state.values
    weight[CALIBRATION_COUNT:layout.poses] = problem.spread.bend_deg ** -2 * (1.0 if problem.is_bent else _TIGHT)
    away[CALIBRATION_COUNT:layout.poses] = -state.bends.ravel()
    weight[layout.biases:] = problem.spread.bias ** -2
    away[layout.biases:] = -state.biases
    return weight, away, _stay(problem, state, layout)


def squares_of(groups: Sequence[Group], captures: int, faces: int) -> Array:
    """Observations by capture and face."""
    made = np.zeros((captures, faces))
    for group in groups:
        made[group.cells.capture] += np.bincount(group.plane, minlength=faces)
    return made


def untold(groups: Sequence[Group], captures: int, normals: Array) -> tuple[Array, Array]:
    """What no shared face tells of the turns and of the places of all captures but the first: unit vectors of (captures - 1, 3).

    Faces of any capture are tilted a little, by waves and by a calibration that is not yet right. There a pose that is free
    would take up millimetres of misfit by decimetres.
    """
    weight = np.minimum(squares_of(groups, captures, len(normals)), _STILL_SQUARES)
    across = normals[:, :, None] * normals[:, None, :]
    made = []
    for told in (np.eye(3) - across, across):
        square = np.zeros((captures, 3, captures, 3))
        for w, by in zip(weight.T[weight.sum(0) > 0], told[weight.sum(0) > 0]):
            square += (np.diag(w) - np.outer(w, w) / w.sum())[:, None, :, None] * by[:, None, :]
        values, vectors = np.linalg.eigh(square[1:, :, 1:].reshape(3 * captures - 3, -1))
        made.append(vectors.T[values <= _STILL_SHARE * values.max(initial=0.0)].reshape(-1, captures - 1, 3))
    return made[0], made[1]


def _stay(problem: Problem, state: State, layout: Layout) -> Array:
    """Weight of what keeps the poses where no face tells them."""
    poses = problem.captures - 1
    made = np.zeros((poses, 6, poses, 6))
    if poses:
        for part, rows in zip((slice(0, 3), slice(3, 6)), untold(problem.groups, problem.captures, state.normals)):
            made[:, part, :, part] = _STILL * np.einsum("nki,nlj->kilj", rows, rows)
    return made.reshape(6 * poses, 6 * poses)


def _variance(linear: Linear, spread: Spread) -> Array:
    made: Array = linear.noise + spread.spot ** 2 * linear.slant
    return made


class Errors:
    """Covariance of observations: each errs on its own, and those of a face by its heights."""

    def __init__(self, problem: Problem, linear: Linear, spread: Spread, variance: Array) -> None:
        self.variance = variance
        self.determinant = 0.0
        self._faces: list[tuple[Array, tuple[Array, bool]]] = []
        alone = np.ones(len(variance), bool)
        for at, heights in problem.surface.covariances(linear.place, spread):
            matrix = heights * linear.lean[at, None] * linear.lean[at]
            matrix[np.diag_indices_from(matrix)] += variance[at]
            factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
            self.determinant += 2 * float(np.log(np.diag(factor[0])).sum())
            self._faces.append((at, factor))
            alone[at] = False
        self._alone = np.flatnonzero(alone)
        self.determinant += float(np.log(variance[alone]).sum())

    def normal(self, linear: Linear) -> tuple[Array, Array, float]:
        """Normal equations: their matrix and right side, and the weighted square of the residuals."""
        rest, weight = linear.matrix[self._alone], 1 / self.variance[self._alone]
        residual = linear.residual[self._alone]
        made = (rest.T @ rest.multiply(weight[:, None])).toarray()
        right, square = -(rest.T @ (weight * residual)), float(weight @ residual ** 2)
        for at, factor in self._faces:
            part = linear.matrix[at]
            used = np.unique(part.indices)
            known = np.c_[part[:, used].toarray(), linear.residual[at]]
            whole = known.T @ cho_solve(factor, known, check_finite=False)
            made[np.ix_(used, used)] += whole[:-1, :-1]
            right[used] -= whole[:-1, -1]
            square += float(whole[-1, -1])
        return made, right, square

    def own(self, residual: Array) -> Array:
        """What of residuals is not by the heights of faces, as far as that is likely."""
        made = residual.copy()
        for at, factor in self._faces:
            made[at] = self.variance[at] * cho_solve(factor, residual[at], check_finite=False)
        return made


@dataclass
class Normal:
    """Normal equations."""

    matrix: Array
    right: Array
    square: float
    """Weighted squares of residuals and of what is known."""


def _normal(linear: Linear, layout: Layout, errors: Errors, prior: tuple[Array, Array, Array]) -> Normal:
    matrix, right, square = errors.normal(linear)
    matrix[np.diag_indices_from(matrix)] += prior[0]
    matrix[layout.poses:layout.faces, layout.poses:layout.faces] += prior[2]
    return Normal(matrix, right + prior[0] * prior[1], square + float(prior[0] @ prior[1] ** 2))


def _factor(matrix: Array) -> tuple[tuple[Array, bool], Array]:
    """Cholesky factor of the matrix scaled to a diagonal of 1, and the scale."""
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = 1 / np.sqrt(np.diag(matrix))
        scaled = matrix * scale[:, None] * scale
    if not np.isfinite(scaled).all():
        raise LinAlgError("the normal equations are not finite")
    try:
        return cho_factor(scaled, lower=True), scale
    except LinAlgError:
        return cho_factor(scaled + 1e-9 * np.eye(len(scaled)), lower=True), scale


def _robust(problem: Problem, linear: Linear, left: Array) -> Array:
    """Variances of the observations, larger for those that are far off."""
    if problem.loss_m > 0:
        made: Array = problem.loss_m ** 2 + left ** 2
        return made
    variance = _variance(linear, problem.spread)
    off = np.abs(left) / np.sqrt(variance)
    share = np.minimum(1.0, _HUBER / np.maximum(off, 1e-12))
    if problem.lets_go:
        share *= np.clip((_LET_GO[1] - off) / (_LET_GO[1] - _LET_GO[0]), 1e-6, 1.0)
    return variance / share


def _moved(state: State, step: Array, layout: Layout) -> State:
    """The state after a step."""
    made = state.copy()
    made.values += step[:CALIBRATION_COUNT]
    made.bends += step[CALIBRATION_COUNT:layout.poses].reshape(made.bends.shape)
    for k in range(1, layout.captures):
        part = step[layout.poses + 6 * (k - 1):][:6]
        pose = state.poses[k]
        made.poses[k] = Pose(turned(part[:3]) @ pose.turn, pose.place + part[3:])
    face = step[layout.faces:layout.biases].reshape(-1, 3)
    first, second = tangents(state.normals)
    made.normals = state.normals + face[:, :1] * first + face[:, 1:2] * second
    length = np.linalg.norm(made.normals, axis=1)
    made.normals /= length[:, None]
    made.offsets = (state.offsets + face[:, 2]) / length
    made.biases += step[layout.biases:]
    return made


@dataclass
class Fit:
    """A state with all that is known of it."""

    state: State
    linear: Linear
    layout: Layout
    left: Array
    """Residuals of the observations, heights of faces taken off."""
    normal: Normal
    is_settled: bool = True
    """Whether the last round moved hardly anything."""


def solve(problem: Problem, state: State, rounds: int = 8) -> Fit:
    """Gauss-Newton, with weights renewed in each round."""
    variance: Optional[Array] = None
    size = np.inf
    turn = 0
    while True:
        linear, layout = linearise(problem, state)
        if variance is None:
            variance = _variance(linear, problem.spread)
        left = Errors(problem, linear, problem.spread, variance).own(linear.residual)
        variance = _robust(problem, linear, left)
        normal = _normal(linear, layout, Errors(problem, linear, problem.spread, variance), _prior(problem, state, layout))
        turn += 1
        if size < _SETTLED or turn >= rounds:
            return Fit(state, linear, layout, left, normal, size < _SETTLED)
        factor, scale = _factor(normal.matrix)
        step = scale * cho_solve(factor, scale * normal.right)
        state = _moved(state, step, layout)
        usual = np.r_[priors(), np.full(layout.size - CALIBRATION_COUNT, _STEP)]
        size = float(np.abs(step / usual).max())


# --- How uneven the faces are ---


def estimate_spread(problem: Problem, fit: Fit) -> Spread:
    """Standard deviations of heights and of single observations that make the residuals most likely."""
    linear, layout = fit.linear, fit.layout
    less = _robust(problem, linear, fit.left) / _variance(linear, problem.spread)
    prior = _prior(problem, fit.state, layout)

    def cost(logs: Array) -> float:
        spread = _spread(logs, problem.spread)
        errors = Errors(problem, linear, spread, _variance(linear, spread) * less)
        normal = _normal(linear, layout, errors, prior)
        factor, scale = _factor(normal.matrix)
        determinant = 2 * np.log(np.diag(factor[0])).sum() - 2 * np.log(scale).sum()
        explained = float((scale * normal.right) @ cho_solve(factor, scale * normal.right))
        known = np.log(spread.bow / (_BOW * spread.wave)) ** 2
        return float(errors.determinant + determinant + normal.square - explained + known)

    start = np.log([problem.spread.wave, problem.spread.spot, problem.spread.bow])
    found = minimize(cost, start, method="Nelder-Mead", options={
        "xatol": 0.08, "fatol": 0.3, "maxfev": 60, "initial_simplex": start - np.eye(4, 3, -1)})
    return _spread(found.x, problem.spread)


def _spread(logs: Array, usual: Spread) -> Spread:
    wave, spot, bow = np.exp(np.clip(logs, np.log(_NEAR_ZERO_M), np.log(0.05)))
    return replace(usual, wave=float(wave), spot=float(spot), bow=float(bow))


def estimate_bends(problem: Problem, fit: Fit) -> Spread:
    """Standard deviations of bends and biases that make the residuals most likely: on the normal equations of those alone."""
    layout, spread = fit.layout, problem.spread
    is_own = np.zeros(layout.size, bool)
    is_own[CALIBRATION_COUNT:layout.poses] = is_own[layout.biases:] = True
    is_bend = np.flatnonzero(is_own) < layout.poses
    now = np.r_[fit.state.bends.ravel(), fit.state.biases]

    def weights(logs: Array) -> Array:
        return np.asarray(np.where(is_bend, np.exp(-2 * logs[0]), np.exp(-2 * logs[1])))

    usual = np.log([spread.bend_deg, spread.bias])
    factor, scale = _factor(fit.normal.matrix[np.ix_(~is_own, ~is_own)])
    cross = fit.normal.matrix[np.ix_(~is_own, is_own)]
    solved = scale[:, None] * cho_solve(factor, scale[:, None] * np.c_[cross, fit.normal.right[~is_own]])
    matrix = fit.normal.matrix[np.ix_(is_own, is_own)] - cross.T @ solved[:, :-1] - np.diag(weights(usual))
    right = fit.normal.right[is_own] - cross.T @ solved[:, -1] + weights(usual) * now

    def cost(logs: Array) -> float:
        weight = weights(logs)
        inner, size = _factor(matrix + np.diag(weight))
        vector = size * (right - weight * now)
        determinant = 2 * np.log(np.diag(inner[0])).sum() - 2 * np.log(size).sum() - np.log(weight).sum()
        known = ((logs - np.log([BEND_DEG, BIAS_M])) ** 2).sum()
        return float(determinant - vector @ cho_solve(inner, vector) + weight @ now ** 2 + known)

    found = minimize(cost, usual, method="Nelder-Mead", options={"xatol": 0.05, "fatol": 0.05, "maxfev": 80}).x
    bend, bias = np.exp(np.clip(found, np.log([5e-4, 2e-4]), np.log([0.1, 0.05])))
    return replace(spread, bend_deg=float(bend), bias=float(bias))


# --- What is known of the result ---


def covariance(fit: Fit, held: Array) -> Array:
    """Covariance of the calibration, what is held being as uncertain as its prior."""
    keep = np.ones(fit.layout.size, bool)
    keep[:CALIBRATION_COUNT] = ~held
    factor, scale = _factor(fit.normal.matrix[np.ix_(keep, keep)])
    free = CALIBRATION_COUNT - int(held.sum())
    right = np.zeros((len(scale), free))
    right[np.arange(free), np.arange(free)] = scale[:free]
    own = (scale[:, None] * cho_solve(factor, right))[:free]
    cross = fit.normal.matrix[np.ix_(keep, ~keep)]
    pulled = (scale[:, None] * cho_solve(factor, scale[:, None] * cross))[:free]
    made = np.zeros((CALIBRATION_COUNT, CALIBRATION_COUNT))
    known = own + pulled * priors()[held] ** 2 @ pulled.T
    index = np.flatnonzero(~held)
    made[np.ix_(index, index)] = known
    made[held, held] = priors()[held] ** 2
    return made
