"""The motion of a sensor by kiss-icp: each frame is aligned with a map of those before it.

kiss-icp itself moves a frame's points to the time of the last one, by the motion until the frame before. If that motion is
wrong, as where a bend begins, so is the place by half of the error. Here points are moved to the middle of the frame, where
the errors of both halves nearly cancel: the first round finds the motion, and the second one has points moved by it.
"""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np

from .._errors import CaptureError
from ._drive import Scan
from ._motion import Array, angle, inverse, part

ROUNDS = ((2.0, 35_000), (0.5, 70_000))
"""Of each, kiss-icp's kernel in metres, of which points may be three away, and how many points suffice. The first one has to
find a bend of 70 degrees a second that was not there in the frame before."""

MARGIN_S = 1e-3
"""The first and the last pose are so far outside of the points: times are rounded, and UTC is an estimate."""

STEP_S = 0.5
"""Poses are at most so far apart where there are points: lumdump takes what is more than 1 s apart for a gap."""

FEWEST = 20
"""Points that a frame is aligned by, after they were thinned."""

AHEAD_M, FASTEST_M_S, FARTHEST_M = 2.0, 60.0, 40.0
"""Motions that the first two frames are tried with: straight ahead, in steps of this, up to this speed, and up to this far. With
none, kiss-icp finds up to some 1.5 m; of a longer motion it finds next to nothing, since the lines on the road are alike in both."""

_SETTLED_M, _SETTLED_RAD = 1e-2, 1e-4
_FIRST_ROUNDS = 4
_SAMPLE = 200


@dataclass
class Settings:
    """Those of kiss-icp, by its names."""

    max_range: float = 100.0
    voxel_size: float = 1.0
    deskew: bool = True

    def config(self) -> Any:
        """As kiss-icp takes them."""
        from kiss_icp.config import KISSConfig

        config = KISSConfig()
        config.data.max_range, config.data.min_range, config.data.deskew = self.max_range, 0.0, self.deskew
        config.mapping.voxel_size = self.voxel_size
        return config


@dataclass
class Track:
    """Where the sensor was."""

    poses: list[Array] = field(default_factory=list)
    """Just before the first point, where the world begins; in the middle of each frame; just after the last point."""
    clock_ns: list[int] = field(default_factory=list)
    utc_ns: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    """Of the frames."""
    residuals_m: list[float] = field(default_factory=list)
    """Of each frame but the first: the median distance of its points from the nearest one of the frame before."""
    reaches_s: list[float] = field(default_factory=list)
    """Of each frame: how far its points are from its pose in time, and a margin."""

    def times_s(self) -> Array:
        """Seconds from the beginning, by the sensor's clock."""
        clock = np.array(self.clock_ns, "i8")
        return np.asarray((clock - clock[0]) * 1e-9)

    def filled(self) -> Track:
        """With poses in between on the screw, so that each point has one: frames may be longer than STEP_S."""
        made, reaches = Track(), (0.0, *self.reaches_s, 0.0)
        for i in range(len(self.poses) - 1):
            span_ns = self.clock_ns[i + 1] - self.clock_ns[i]
            motion = inverse(self.poses[i]) @ self.poses[i + 1]
            for passed_ns in _between(span_ns, reaches[i], reaches[i + 1]):
                share = passed_ns / span_ns
                made.poses.append(self.poses[i] @ part(motion, share))
                made.clock_ns.append(self.clock_ns[i] + passed_ns)
                made.utc_ns.append(self.utc_ns[i] + round(share * (self.utc_ns[i + 1] - self.utc_ns[i])))
        made.poses.append(self.poses[-1])
        made.clock_ns.append(self.clock_ns[-1])
        made.utc_ns.append(self.utc_ns[-1])
        return made


def _between(span_ns: int, after_s: float, before_s: float) -> list[int]:
    """The first pose's time, 0, and times until the next one, near points: so long after the first, or before the second."""
    if span_ns <= 1e9 * STEP_S:
        return [0]
    after, before = (1e9 * np.arange(1, count + 1) * reach / max(count, 1)
                     for reach, count in ((reach, int(np.ceil(reach / STEP_S))) for reach in (after_s, before_s)))
    times = np.unique(np.round(np.concatenate([after, span_ns - before]))).astype("i8")
    return [0, *times[(times > 0) & (times < span_ns)].tolist()]


def _settled(a: Array, b: Array) -> bool:
    change = inverse(a) @ b
    return bool(np.linalg.norm(change[:3, 3]) < _SETTLED_M and angle(change) < _SETTLED_RAD)


class Estimate:
    """Frames come in, in their order; poses come out."""

    def __init__(self, settings: Settings) -> None:
        """Begin a drive."""
        self._settings = settings
        self._begin(np.eye(4), 1.0)

    def _begin(self, motion: Array, span_s: float) -> None:
        """An empty map, and the motion at the first frame."""
        from kiss_icp.kiss_icp import KissICP

        self._kiss = KissICP(self._settings.config())
        self._pose, self._motion, self._span_s = np.eye(4), motion, span_s
        self._last: Any = None
        self._before = np.zeros((0, 3))
        self.track = Track()

    def run(self, scans: Iterable[Scan], tell: Callable[[int], None] = lambda count: None) -> Track:
        """The poses of a drive; tell is called with the number of frames so far."""
        first: list[Scan] = []
        for count, scan in enumerate(scans, 1):
            if count <= 2:
                first.append(scan)
            if count == 2:
                self._start(first)
            else:
                self._take(scan)
            tell(count)
        self._finish()
        return self.track

    def _start(self, first: list[Scan]) -> None:
        """The first frame has none before it: it moved as it did until the second one, which depends on that."""
        span_s = (first[1].clock_ns - first[0].clock_ns) * 1e-9
        tried = []
        for ahead_m in np.arange(0, min(FASTEST_M_S * span_s, FARTHEST_M), AHEAD_M):
            motion = np.eye(4)
            motion[0, 3] = ahead_m
            self._take_first(first, motion, span_s)
            tried.append((self.track.residuals_m[0], self._motion))
        _, motion = min(tried, key=lambda one: one[0])
        for _ in range(_FIRST_ROUNDS if self._settings.deskew else 1):
            self._take_first(first, motion, span_s)
            if _settled(motion, self._motion):
                break
            motion = self._motion

    def _take_first(self, first: list[Scan], motion: Array, span_s: float) -> None:
        self._begin(motion, span_s)
        for scan in first:
            self._take(scan)

    def _finish(self) -> None:
        """Poses for the times before the first middle and after the last."""
        track = self.track
        if len(track.poses) < 2:
            return
        span_s = (track.clock_ns[1] - track.clock_ns[0]) * 1e-9
        begun_s, ended_s = track.reaches_s[0], track.reaches_s[-1]
        before = part(inverse(track.poses[0]) @ track.poses[1], -begun_s / span_s)
        after = part(self._motion, ended_s / self._span_s)
        track.poses = [track.poses[0] @ before, *track.poses, track.poses[-1] @ after]
        for times in (track.clock_ns, track.utc_ns):
            times.insert(0, times[0] - round(1e9 * begun_s))
            times.append(times[-1] + round(1e9 * ended_s))
        begin = inverse(track.poses[0])
        track.poses = [np.eye(4), *(begin @ pose for pose in track.poses[1:])]

    def _take(self, scan: Scan) -> None:
        if self._last is None:
            span_s, pose = self._span_s, self._pose
            points = self._points(scan, part(self._motion, scan.length_s / span_s), ROUNDS[-1][1])
        else:
            span_s = (scan.clock_ns - self._last.clock_ns) * 1e-9
            pose, points = self._align(scan, span_s)
            self._motion = inverse(self._pose) @ pose
            self._note(points, pose)
        self._kiss.local_map.update(points[1], pose)
        self._before = points[1] @ pose[:3, :3].T + pose[:3, 3]
        self._pose, self._span_s, self._last = pose, span_s, scan
        self.track.poses.append(pose)
        self.track.clock_ns.append(scan.clock_ns)
        self.track.utc_ns.append(scan.utc_ns)
        self.track.numbers.append(scan.number)
        self.track.reaches_s.append(scan.length_s / 2 + MARGIN_S)

    def _align(self, scan: Scan, span_s: float) -> tuple[Array, tuple[Array, Array]]:
        """Align a frame with the map: its pose, and its points as kiss-icp thins them for that and for the map."""
        kiss = self._kiss
        motion = part(self._motion, span_s / self._span_s)
        pose, points = self._pose @ motion, (self._before, self._before)
        for kernel, most in ROUNDS:
            points = self._points(scan, part(motion, scan.length_s / span_s), most)
            pose = kiss.registration.align_points_to_map(points=points[0], voxel_map=kiss.local_map, initial_guess=pose,
                                                         max_correspondance_distance=3 * kernel, kernel=kernel)
            motion = inverse(self._pose) @ pose
        return pose, points

    def _points(self, scan: Scan, swept: Array, most: int) -> tuple[Array, Array]:
        """Points moved to the middle of the frame; swept is the motion from the first point to the last."""
        every = -(-len(scan.points) // most)
        points = self._kiss.preprocessor.preprocess(scan.points[::every], scan.times_s[::every], swept)
        if self._settings.deskew:  # kiss-icp has moved them to the last point
            half = part(swept, 0.5)
            points = points @ half[:3, :3].T + half[:3, 3]
        thinned, of_map = self._kiss.voxelize(points)
        if len(thinned) < FEWEST:
            raise CaptureError(f"frame {scan.number}: {len(thinned)} of its points are left to align it by, and {FEWEST} are needed: "
                               "a larger --max-range or a smaller --voxel leaves more")
        return thinned, of_map

    def _note(self, points: tuple[Array, Array], pose: Array) -> None:
        """How far some of the points are from the frame before."""
        chosen = points[0][::max(1, len(points[0]) // _SAMPLE)]
        placed = (chosen @ pose[:3, :3].T + pose[:3, 3] - self._pose[:3, 3]).astype("f4")
        before = (self._before - self._pose[:3, 3]).astype("f4")
        squares = (placed ** 2).sum(1)[:, None] + (before ** 2).sum(1) - 2 * placed @ before.T
        self.track.residuals_m.append(float(np.sqrt(max(np.median(squares.min(1)), 0.0))))
