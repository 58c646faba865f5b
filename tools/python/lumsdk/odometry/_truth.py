"""Poses as a file, and the true ones at their times."""
from __future__ import annotations

from typing import Optional

import numpy as np

from .._errors import CaptureError, OptionError
from .._poses import Poses
from . import _metrics
from ._estimate import Track
from ._motion import Array

CLOCKS = {"utc": "seconds since 1970 UTC", "sensor": "seconds of the sensor's clock"}


def to_text(track: Track, clock: str, made_by: str) -> str:
    """The poses as TUM has them, by "utc" or the "sensor"'s clock."""
    times = track.utc_ns if clock == "utc" else track.clock_ns
    poses = Poses(np.array(times, "i8"), np.array(track.poses), clock="utc" if clock == "utc" else "sensor")
    lines = [f"# {made_by}: where the sensor was, metres from where it was at the first line; {CLOCKS[clock]}",
             "# t x y z qx qy qz qw"]
    for time, (x, y, z, *turn) in zip(poses.times.tolist(), poses.tum.tolist()):
        lines.append(f"{time // 10 ** 9}.{time % 10 ** 9:09d} {x:.6f} {y:.6f} {z:.6f} " + " ".join(f"{q:.9f}" for q in turn))
    return "\n".join(lines) + "\n"


def _of(truth: Poses, time_ns: int) -> Optional[Array]:
    try:
        return truth.at(time_ns)
    except OptionError:  # outside, or in a gap
        return None


def compare(truth: Poses, track: Track) -> _metrics.Errors:
    """The errors where there is a truth; CaptureError: there is none for two poses of the drive."""
    times = track.utc_ns if truth.clock == "utc" else track.clock_ns
    found = [(i, pose) for i, pose in ((i, _of(truth, time)) for i, time in enumerate(times)) if pose is not None]
    if len(found) < 2:
        first, last = (time * 1e-9 for time in truth.span)
        raise CaptureError(f"{truth.name}: its poses are of {first:.3f} to {last:.3f} s, by {CLOCKS[truth.clock]}, and the drive is "
                           f"of {times[0] * 1e-9:.3f} to {times[-1] * 1e-9:.3f} s: the truth of this drive is needed")
    chosen = [i for i, _ in found]
    return _metrics.errors(np.array(track.poses)[chosen], np.array([pose for _, pose in found]), track.times_s()[chosen],
                           len(times) - len(found), chosen)
