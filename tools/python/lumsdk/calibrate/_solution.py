"""What a calibration finds: values with their standard deviations, residuals and planes."""
from __future__ import annotations

import copy
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._grid import EYES

Array = np.ndarray[Any, np.dtype[Any]]


EYE_KEYS = ("tof_offset_ps", "azimuth.width_deg", "elevation.min_deg", "elevation.max_deg")
MOUNT_KEYS = ("mount.x_m", "mount.y_m", "mount.z_m", "mount.roll_deg", "mount.pitch_deg", "mount.yaw_deg")
KEYS = tuple(f"{eye}.{key}" for eye in EYES for key in EYE_KEYS) + tuple(f"green.{key}" for key in MOUNT_KEYS)
"""What is looked for."""

WISHES = {"tof_offset_ps": 33.0, "width_deg": 0.015, "min_deg": 0.03, "max_deg": 0.03, "x_m": 0.003, "y_m": 0.003, "z_m": 0.003,
          "roll_deg": 0.017, "pitch_deg": 0.017, "yaw_deg": 0.017}
"""Standard deviations that are wished for, by a key's end: half of what docs/calibrate-accuracy.md allows of mild walls, as for
95 of 100."""


@dataclass
class Parameter:
    """A number of the calibration."""

    key: str
    """As in a calibration file, below "eyes", such as "green.mount.yaw_deg" or "blue.tof_offset_ps"."""
    value: float
    before: float
    """As it was before."""
    sigma: float
    """Standard deviation, in the unit of the key; inf where it is held."""
    held: str = ""
    """Why it is held, and which recording would determine it; "" where it is measured."""
    wish: float = math.inf
    """The standard deviation that is wished for."""

    def more(self, captures: int) -> int:
        """How many more than so many captures reach what is wished for, if all are independent and alike; 0: reached, or held."""
        if self.held or not self.sigma > self.wish:
            return 0
        return math.ceil(captures * ((self.sigma / self.wish) ** 2 - 1))


@dataclass
class Residuals:
    """What is left of the ranges, each the mean of some neighbouring cells of a face: arrays of one length."""

    eye: Array
    """0 blue, 1 green."""
    range_m: Array
    azimuth_deg: Array
    """Azimuth and elevation are those of the eye, before the mount."""
    elevation_deg: Array
    plane: Array
    """An index into Solution.planes."""
    capture: Array
    """An index into Solution.captures."""
    before_m: Array
    """Measured less expected range with the calibration as it was, and the best poses and planes for that."""
    after_m: Array


@dataclass
class Plane:
    """A flat face that the captures share, in the frame of the first capture's sensor."""

    normal: Array
    """A unit vector towards the sensor: (3,)."""
    offset: float
    """normal . point of all its points, in metres."""
    captures: tuple[int, ...]
    """Those that see it: indices into Solution.captures."""
    eyes: tuple[int, ...]
    """Those that see it: 0 blue, 1 green."""
    cells: int
    """Cells of the grids that lie on it."""
    points: Array
    """Some of its points in metres, in the frame of the first capture's sensor: (n, 3)."""
    rms_before_m: float
    rms_after_m: float
    bias_m: float = 0.0
    """How much longer than to the others ranges to it are."""


@dataclass
class Solution:
    """A calibration that was found."""

    parameters: list[Parameter]
    residuals: Residuals
    planes: list[Plane]
    captures: list[str]
    rms_before_m: float
    rms_after_m: float
    held_out_before_m: float
    """Root mean square on planes that the solution had not seen; nan where there is no plane to spare."""
    held_out_after_m: float
    is_better: bool
    """Whether it settled, and planes that were held out are no worse than before, within allowed_m."""
    base: dict[str, Any] = field(default_factory=dict)
    """The calibration as it was, nested as in a file."""
    notes: list[str] = field(default_factory=list)
    allowed_m: float = float("nan")
    """Root mean square up to which it counts as no worse than before; nan where it is not known."""
    began: str = "typical values"
    """Where the calibration as it was comes from, in words."""
    bends_deg: Array = field(default_factory=lambda: np.zeros((2, 2, 3)))
    """How far readings of the mirrors are bent: Legendre terms 2, 3 and 4 by eye and mirror (azimuth, elevation), in
    degrees. No calibration holds them."""
    spread: dict[str, float] = field(default_factory=dict)
    """How uneven faces and mirrors were taken to be: standard deviations in metres, and in degrees where the name ends in _deg."""
    is_settled: bool = True
    """Whether the last round of the fit moved hardly anything."""
    exchanged: str = ""
    """What to do where a wall continues from eye to eye only with the eyes exchanged; empty: one goes on as they are called, or
    none tells."""
    poses: list[tuple[Array, Array]] = field(default_factory=list)
    """Turn (3, 3) and place in metres of each capture's sensor, in the frame of the first capture's."""

    def calibration(self) -> dict[str, Any]:
        """Nested as in a calibration file: as it was, with the values that were measured."""
        made = copy.deepcopy(self.base)
        for parameter in self.parameters:
            put(made, f"eyes.{parameter.key}", parameter.value)
        return made


def put(made: dict[str, Any], key: str, value: Any) -> None:
    """Set a value of nested mappings by its key with dots."""
    *above, name = key.split(".")
    for part in above:
        made = made.setdefault(part, {})
    made[name] = value
