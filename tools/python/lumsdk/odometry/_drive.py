"""The frames of a drive, as odometry takes them: points, and the time of each."""
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import open as open_source
from .._errors import CaptureError
from .._frame import Frame
from ._motion import Array

if TYPE_CHECKING:
    from .._types import Column

COLUMNS: tuple[Column, ...] = ("x", "y", "z", "time")
FEWEST_POINTS = 100


@dataclass
class Scan:
    """A frame with points."""

    number: int
    points: Array
    """(n, 3) float64."""
    times_s: Array
    """(n,) float64, seconds from its begin."""
    clock_ns: int
    """The sensor's clock in the middle between its first and its last point, which is the time of its pose."""
    utc_ns: int
    length_s: float
    """From its first point to its last."""


class Drive:
    """Frames of one sensor, in the order of its clock; what is wrong with them raises CaptureError."""

    def __init__(self, name: str, options: dict[str, Any]) -> None:
        """Open it; the options are those of lumsdk.open()."""
        self.name = name
        self._source = open_source(name, columns=COLUMNS, **options)
        self.frames = 0
        self.sparse = 0
        """Frames with too few points, which were left out."""
        self.without_utc_error = 0
        """Frames whose error of UTC is unknown."""

    def __enter__(self) -> Drive:
        return self

    def __exit__(self, *_: object) -> None:
        self._source.close()

    def expected(self) -> int:
        """About how many frames there are; 0: nobody knows."""
        return self._source.__length_hint__()

    def __iter__(self) -> Iterator[Scan]:
        last_ns, sensor = -1, ""
        for frame in self._source:
            if sensor not in ("", frame.sensor):
                raise CaptureError(f"{self.name}: has frames of several sensors, {sensor} and {frame.sensor}: a drive "
                                   "has one; name it with --sensor")
            sensor = frame.sensor
            scan = self._scan(frame)
            if scan is None:
                continue
            if scan.clock_ns <= last_ns:
                raise CaptureError(f"{self.name}: frame {scan.number} is earlier than the frame before it by the sensor's "
                                   "clock, as after a restart of the sensor: use "
                                   "--frames to take the frames before it, or those from it on")
            last_ns = scan.clock_ns
            yield scan

    def _scan(self, frame: Frame) -> Any:
        info = frame.info
        self.frames += 1
        if len(frame) < FEWEST_POINTS:
            self.sparse += 1
            return None
        if not info["begin_utc_ns"]:
            raise CaptureError(f"{self.name}: frame {frame.number} has no clock: its profile has no timestamp, and points have no "
                               "time of their own; name a profile with one by --profile")
        if info["utc_error_ns"] is None:
            self.without_utc_error += 1
        times = frame["time"].astype("f8")
        first, last = float(times.min()), float(times.max())
        middle_ns = round(5e8 * (first + last))
        return Scan(frame.number, frame.xyz.astype("f8", order="C"), times, 1000 * info["begin_clock_us"] + middle_ns,
                    info["begin_utc_ns"] + middle_ns, last - first)
