"""Captures of a sensor that stands still as grids of mean ranges, and the flat faces in them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Union

from ._result import Array

if TYPE_CHECKING:
    import os

    from .._settings import Calibration, Profile


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


def grid(capture: Union[str, os.PathLike[str]], profile: Optional[Union[Profile, str]] = None, **options: Any) -> Grid:
    """The mean of a capture's frames."""
    raise NotImplementedError


def points(grid: Grid, eye: int, calibration: Calibration) -> Array:
    """Points of an eye in the frame of the sensor: (lines * 1000, 3), nan where nothing was measured."""
    raise NotImplementedError


def find_planes(grid: Grid, calibration: Calibration) -> list[Patch]:
    """Connected flat parts of what each eye sees, the largest first."""
    raise NotImplementedError
