"""How far a drive went, and how far its poses are from the truth."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Optional

import numpy as np

from .._errors import CaptureError, OptionError
from .._poses import Poses
from ._estimate import Track
from ._motion import Array, angle, inverse

CLOCKS = {"utc": "seconds since 1970 UTC", "sensor": "seconds of the sensor's clock"}

KITTI_M = tuple(float(length) for length in range(100, 801, 100))
SHORT_M = tuple(float(length) for length in range(10, 100, 10))
"""Lengths for a drive too short for KITTI's."""

STOOD_M = 1.0
"""Drives up to this are none: poses of a sensor that stands waver by millimetres."""

FIRST_EVERY_S = 1.0
"""Segments begin this far apart: at KITTI's 10 frames a second, each tenth frame."""


@dataclass
class Segments:
    """Errors of all segments of one length."""

    length_m: float
    count: int
    translation_percent: float
    rotation_deg_m: float


@dataclass
class Errors:
    """What poses are off by. Poses and truth are at the same times."""

    count: int
    """Poses that have a truth."""
    without: int
    """Poses before, after or in gaps of the truth."""
    absolute_rms_m: float
    absolute_max_m: float
    each_m: Array
    """Of each of them, after the alignment."""
    chosen: Sequence[int]
    """Which of the track's poses they are."""
    segments: list[Segments] = field(default_factory=list)
    is_kitti: bool = True
    """Whether the lengths are those of KITTI's benchmark."""

    @property
    def translation_percent(self) -> Optional[float]:
        """Mean over all segments, as the benchmark has it."""
        return self._mean([s.translation_percent for s in self.segments])

    @property
    def rotation_deg_m(self) -> Optional[float]:
        """The same of the turns."""
        return self._mean([s.rotation_deg_m for s in self.segments])

    def _mean(self, values: list[float]) -> Optional[float]:
        return float(np.average(values, weights=[s.count for s in self.segments])) if values else None


def along(places: Array) -> Array:
    """Metres driven until each place."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])


def aligned(places: Array, truth: Array) -> Array:
    """The motion, without a scale, that brings places (n, 3) as near to the truth as it can: (4, 4)."""
    middle, middle_truth = places.mean(0), truth.mean(0)
    u, _, vt = np.linalg.svd((truth - middle_truth).T @ (places - middle))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    made = np.eye(4)
    made[:3, :3] = u @ flip @ vt
    made[:3, 3] = middle_truth - made[:3, :3] @ middle
    return made


def _segments(poses: Array, truth: Array, times_s: Array, length_m: float) -> Optional[Segments]:
    """Errors over this length of the true path; None: it fits nowhere."""
    driven = along(truth[:, :3, 3])
    _, first = np.unique(np.floor((times_s - times_s[0]) / FIRST_EVERY_S), return_index=True)
    last = np.searchsorted(driven, driven[first] + length_m, "right")
    first, last = first[last < len(poses)], last[last < len(poses)]
    if not len(first):
        return None
    error = inverse(inverse(poses[first]) @ poses[last]) @ (inverse(truth[first]) @ truth[last])
    return Segments(length_m, len(first), float(100 * np.linalg.norm(error[:, :3, 3], axis=1).mean() / length_m),
                    float(np.degrees(angle(error)).mean() / length_m))


def errors(poses: Array, truth: Array, times_s: Array, without: int = 0, chosen: Sequence[int] = ()) -> Errors:
    """Absolute errors, and those over lengths of the path. There are at least two poses."""
    moved = aligned(poses[:, :3, 3], truth[:, :3, 3]) @ poses
    each = np.linalg.norm(moved[:, :3, 3] - truth[:, :3, 3], axis=1)
    made = Errors(len(poses), without, float(np.sqrt(np.mean(each ** 2))), float(each.max()), each, chosen)
    for lengths in (KITTI_M, SHORT_M):
        found = [_segments(poses, truth, times_s, length) for length in lengths]
        made.segments = [segments for segments in found if segments is not None]
        made.is_kitti = lengths is KITTI_M
        if made.segments:
            break
    return made


def _of(truth: Poses, time_ns: int) -> Optional[Array]:
    try:
        return truth.at(time_ns)
    except OptionError:  # outside, or in a gap
        return None


def compare(truth: Poses, track: Track) -> Errors:
    """The errors where there is a truth; CaptureError: there is none for two poses of the drive."""
    times = track.utc_ns if truth.clock == "utc" else track.clock_ns
    found = [(i, pose) for i, pose in ((i, _of(truth, time)) for i, time in enumerate(times)) if pose is not None]
    if len(found) < 2:
        first, last = (time * 1e-9 for time in truth.span)
        raise CaptureError(f"{truth.name}: its poses are from {first:.3f} to {last:.3f} s, by {CLOCKS[truth.clock]}, and the "
                           f"drive is from {times[0] * 1e-9:.3f} to {times[-1] * 1e-9:.3f} s: the truth of this drive is needed")
    chosen = [i for i, _ in found]
    return errors(np.array(track.poses)[chosen], np.array([pose for _, pose in found]), track.times_s()[chosen],
                           len(times) - len(found), chosen)


@dataclass
class Path:
    """What poses tell of a drive."""

    distance_m: float
    seconds: float
    mean_m_s: float
    max_m_s: float
    closure_m: float
    """From the first pose to the last."""
    closure_deg: float
    closure_percent: Optional[float]
    """Of the distance; None: it stood, and what it moved is noise."""
    speeds_m_s: Array
    """Between each pose and the next."""


def path(poses: Array, times_s: Array) -> Path:
    """Measure a drive of at least two poses."""
    driven, spans = along(poses[:, :3, 3]), np.diff(times_s)
    speeds = np.diff(driven) / spans
    whole = inverse(poses[0]) @ poses[-1]
    gap, seconds = float(np.linalg.norm(whole[:3, 3])), float(times_s[-1] - times_s[0])
    distance = float(driven[-1])
    return Path(distance, seconds, distance / seconds, float(speeds.max()), gap, float(np.degrees(angle(whole))),
                100 * gap / distance if distance > STOOD_M else None, speeds)
