"""How a range follows from calibration, pose and face, with its derivatives.

A range is what the ray of a cell needs to reach its face. Its derivatives do not depend on the measured range: those taken
at noisy points would make the elevation span shrink.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Union

import numpy as np

from .._grid import EYES
from .._settings import Calibration
from ._match import Pose
from ._planes import Grid, metres_a_ps, mount, rotation
from ._solution import KEYS, Array

PRIORS = {"tof_offset_ps": 200.0, "azimuth.width_deg": 0.6, "elevation.min_deg": 0.2, "elevation.max_deg": 0.2,
          "mount.x_m": 0.05, "mount.y_m": 0.05, "mount.z_m": 0.05,
          "mount.roll_deg": 2.0, "mount.pitch_deg": 2.0, "mount.yaw_deg": 2.0}
"""Standard deviations of a typical sensor."""

ORDERS = (2, 3, 4)
"""Legendre terms of a mirror's readings. The lower two are the centre and the span."""

BEND_COUNT = 4 * len(ORDERS)
CALIBRATION_COUNT = len(KEYS)


@dataclass
class State:
    """All that is looked for."""

    values: Array
    """In the units of KEYS."""
    bends: Array
    """Degrees: (eye, mirror, order)."""
    poses: list[Pose]
    normals: Array
    offsets: Array
    biases: Array = field(default_factory=lambda: np.zeros(0))

    def copy(self) -> State:
        return State(self.values.copy(), self.bends.copy(), list(self.poses), self.normals.copy(), self.offsets.copy(),
                     self.biases.copy())


@dataclass
class Fixed:
    """What is not looked for."""

    centres: Array
    """Azimuth centres in degrees."""
    blue: tuple[Array, Array]
    """Blue's rotation and place."""
    metres_a_ps: float
    is_span: bool


def fixed_of(calibration: Calibration, is_span: bool) -> Fixed:
    return Fixed(np.array([float(calibration[f"eyes.{eye}.azimuth.center_deg"]) for eye in EYES]), mount(calibration, 0),
                 metres_a_ps(calibration), is_span)


def values_of(calibration: Calibration) -> Array:
    return np.array([float(calibration[f"eyes.{key}"]) for key in KEYS])


def priors() -> Array:
    return np.array([PRIORS[key.split(".", 1)[1]] for key in KEYS])


@dataclass
class Cells:
    """Cells of one eye in one capture: arrays of one length."""

    capture: int
    eye: int
    azimuth: Array
    elevation: Array
    range_m: Array
    variance: Array
    plane: Array

    def at(self, chosen: Array) -> Cells:
        """Some of them."""
        return Cells(self.capture, self.eye, self.azimuth[chosen], self.elevation[chosen], self.range_m[chosen],
                     self.variance[chosen], self.plane[chosen])


def cells_of(grid: Grid, capture: int, eye: int, at: Array, plane: Union[int, Array]) -> Cells:
    """Cells of a grid by their places in it, and their faces."""
    return Cells(capture, eye, grid.azimuth[eye].ravel()[at], grid.elevation[eye].ravel()[at], grid.range_m[eye].ravel()[at],
                 grid.sigma_m[eye].ravel()[at] ** 2, np.full(len(at), plane))


def _legendre(x: Array) -> Array:
    """Terms of ORDERS, and no more beyond the ends: (orders, n)."""
    x = np.clip(x, -1, 1)
    square = x * x
    return np.stack((1.5 * square - 0.5, (2.5 * square - 1.5) * x, (4.375 * square - 3.75) * square + 0.375))


def mount_of(state: State, fixed: Fixed, eye: int) -> tuple[Array, Array]:
    if eye == 0:
        return fixed.blue
    place = state.values[8:14]
    return rotation(*place[3:]), place[:3]


class Eye:
    """The rays of some cells, and their derivatives column by column."""

    def __init__(self, cells: Cells, state: State, fixed: Fixed) -> None:
        self.cells, self.state, self.fixed = cells, state, fixed
        e = cells.eye
        self.u, self.v = cells.azimuth, cells.elevation
        self.bend_u = _legendre(self.u if fixed.is_span else self.u / 30)
        self.bend_v = _legendre(self.v if fixed.is_span else self.v / 10)
        offset, width, low, high = state.values[4 * e:4 * e + 4]
        half, rise = (width / 2, (high - low) / 2) if fixed.is_span else (1.0, 1.0)
        self.azimuth_deg = fixed.centres[e] + self.u * half + state.bends[e, 0] @ self.bend_u
        self.elevation_deg = (low + high) / 2 + self.v * rise + state.bends[e, 1] @ self.bend_v
        az, el = np.radians(self.azimuth_deg), np.radians(self.elevation_deg)
        self.sin_az, self.cos_az, self.sin_el, self.cos_el = np.sin(az), np.cos(az), np.sin(el), np.cos(el)
        self.turn, self.place = mount_of(state, fixed, e)
        self.pose = state.poses[cells.capture]
        local = np.stack((self.cos_el * self.cos_az, self.cos_el * self.sin_az, self.sin_el), -1)
        world = local @ (self.pose.turn @ self.turn).T
        self.origin = self.pose.turn @ self.place + self.pose.place
        self.normal = state.normals[cells.plane]
        slope = (self.normal * world).sum(1)
        self.slope = np.where(slope < -0.02, slope, -0.02)
        self.expected = (state.offsets[cells.plane] - self.normal @ self.origin) / self.slope
        self.points = self.origin + self.expected[:, None] * world
        measured = cells.range_m + offset * fixed.metres_a_ps - state.biases[cells.plane]
        self.residual = measured - self.expected

    def _along(self, moved: Array) -> Array:
        """Change of the expected range where the point moves by this vector a unit."""
        made: Array = -(self.normal * moved).sum(1) / self.slope
        return made

    def angle_columns(self) -> tuple[Array, Array]:
        """Change of the expected range by degree of azimuth and of elevation."""
        turn = self.pose.turn @ self.turn
        scale = np.radians(1.0) * self.expected[:, None]
        azimuth = np.stack((-self.cos_el * self.sin_az, self.cos_el * self.cos_az, np.zeros_like(self.sin_az)), -1)
        elevation = np.stack((-self.sin_el * self.cos_az, -self.sin_el * self.sin_az, self.cos_el), -1)
        return self._along(azimuth @ turn.T * scale), self._along(elevation @ turn.T * scale)

    def eye_columns(self) -> tuple[list[Array], list[Array]]:
        """Derivatives of the residual by EYE_KEYS, and by the bends of both mirrors."""
        azimuth, elevation = self.angle_columns()
        size = (0.5, 0.5) if self.fixed.is_span else (0.0, 0.0)
        own = [np.full_like(azimuth, self.fixed.metres_a_ps), -azimuth * self.u * size[0],
               -elevation * (0.5 - self.v * size[1]), -elevation * (0.5 + self.v * size[1])]
        return own, [*(-azimuth * self.bend_u), *(-elevation * self.bend_v)]

    def mount_columns(self) -> list[Array]:
        """Derivatives of the residual by MOUNT_KEYS of this eye."""
        _, pitch, yaw = np.radians(self.state.values[11:14])
        z = np.array([0.0, 0.0, 1.0])
        y = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        x = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
        turn = self.pose.turn
        moved = [-self._along(np.broadcast_to(turn[:, i], self.points.shape)) for i in range(3)]
        arm = self.points - self.origin
        return moved + [-self._along(np.cross(turn @ axis, arm)) * np.radians(1.0) for axis in (x, y, z)]

    def pose_columns(self) -> list[Array]:
        """By a small turn (radians) and a small move of the sensor, in the frame of the world."""
        arm = self.points - self.pose.place
        unit = np.eye(3)
        return ([-self._along(np.cross(unit[i], arm)) for i in range(3)] +
                [-self._along(np.broadcast_to(unit[i], arm.shape)) for i in range(3)])

    def plane_columns(self) -> list[Array]:
        """By a small turn of the normal about its two tangents, and by the offset."""
        first, second = tangents(self.state.normals)
        of = self.cells.plane
        return [(first[of] * self.points).sum(1) / self.slope, (second[of] * self.points).sum(1) / self.slope, -1 / self.slope]


def tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors across each normal."""
    helper = np.where(np.abs(normals[:, 2:3]) < 0.8, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normals, first)


def turned(vector: Array) -> Array:
    """The rotation about a vector by its length in radians."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    made: Array = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return made
