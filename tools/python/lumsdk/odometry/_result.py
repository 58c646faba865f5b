"""What is told of a drive."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional

import numpy as np

from ._drive import Drive
from ._estimate import Settings, Track
from ._metrics import Errors, Path

SUDDEN_M_S2 = 30.0
"""A car cannot: it is three times what its tyres hold."""


@dataclass
class Result:
    """A drive, its poses, and what was measured by them."""

    name: str
    settings: Settings
    track: Track
    path: Path
    frames: int
    errors: Optional[Errors] = None
    notes: list[str] = field(default_factory=list)
    """What is doubtful or was left out."""


def residual_m(track: Track) -> float:
    """The median over the frames."""
    return float(np.median(track.residuals_m))


def sudden(path: Path, track: Track) -> list[int]:
    """The frames within which the speed changes more than that of a car can."""
    spans = np.diff(track.times_s())
    changes = np.abs(np.diff(path.speeds_m_s)) / np.maximum(spans[1:], spans[:-1])
    return [track.numbers[i] for i in np.flatnonzero(changes > SUDDEN_M_S2)]


def notes(drive: Drive, path: Path, track: Track, clock: str, errors: Optional[Errors]) -> list[str]:
    """What is doubtful or was left out, in sentences."""
    made = []
    if drive.sparse:
        made.append(f"{drive.sparse} of {drive.frames} frames have too few points and no pose")
    jumps = sudden(path, track)
    if jumps:
        named = ", ".join(map(str, jumps[:5])) + (", ..." if len(jumps) > 5 else "")
        made.append(f"the speed changes by more than {SUDDEN_M_S2:g} m/s2 at {len(jumps)} frames ({named}): they were probably laid "
                    "wrong; a smaller --voxel may help, or less of the drive by --frames")
    if clock == "utc" and drive.without_utc_error:
        made.append(f"nobody knows how exact UTC is in {drive.without_utc_error} of {drive.frames} frames: --time sensor is exact")
    if errors is not None and errors.without:
        made.append(f"{errors.without} of {errors.count + errors.without} poses are outside the truth and not compared")
    return made
