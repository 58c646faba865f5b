"""Frames of several sensors that belong together."""
from __future__ import annotations

import bisect
import collections
import datetime
import math
import os
import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np

from ._errors import OptionError, UnknownKeyError, warn
from ._build import restore
from ._frame import Frame
from ._grid import JOINED
from ._source import Source

if TYPE_CHECKING:
    Array = np.ndarray[Any, np.dtype[Any]]

_PERIODS = 9
"""Of so many last ones, the median is the period of a sensor."""
_SILENT = 5
"""Periods after which a sensor without a frame is not waited for."""
_SKIPPED_MAX = 16
_MOMENT_NS = 100_000
"""Moments that are so near are one: a vehicle moves some millimetres."""
_HELD_MAX = 128
"""Most frames that wait. Only tolerances of many periods, or clocks that stand, make so many."""


# --- A set ---


class FrameSet(Mapping[str, Frame]):
    """Frames of several sensors that belong together: a mapping of the sensors' names to their frames, made by sync()."""

    def __init__(self, frames: Mapping[str, Frame], missing: Mapping[str, str]) -> None:
        """Made by sync()."""
        self._frames = dict(frames)
        self._missing = dict(missing)

    def __getitem__(self, name: str) -> Frame:
        """The frame of a sensor."""
        try:
            return self._frames[name]
        except KeyError:
            pass
        if name in self._missing:
            raise UnknownKeyError(f"the set has no frame of {name}: {self._missing[name]}")
        raise UnknownKeyError(f"the set has no frame of {name!r}; it has {', '.join(self._frames)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._frames)

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def missing(self) -> dict[str, str]:
        """The sensors that have no frame in it, and of each a sentence why."""
        return dict(self._missing)

    @property
    def complete(self) -> bool:
        """Whether each sensor has a frame in it. Whether these are complete, each of them says."""
        return not self._missing

    @property
    def utc_ns(self) -> int:
        """When the earliest of its frames began, in nanoseconds since 1970 UTC."""
        return min(frame.utc_ns for frame in self._frames.values())

    @property
    def time(self) -> datetime.datetime:
        """utc_ns as a datetime in UTC, down to the microsecond."""
        return min(self._frames.values(), key=lambda frame: frame.utc_ns).time

    @property
    def utc_error_ns(self) -> Optional[int]:
        """The largest estimated error of the times by which the frames were put together. None: of one it is not known."""
        errors = [frame.utc_error_ns for frame in self._frames.values()]
        known = [error for error in errors if error is not None]
        return max(known) if len(known) == len(errors) else None

    @property
    def spread(self) -> float:
        """Seconds from the start of its earliest frame to that of its latest."""
        return (max(frame.utc_ns for frame in self._frames.values()) - self.utc_ns) * 1e-9

    def joined(self, columns: Union[str, Iterable[str], None] = None) -> Frame:
        """All points of the set as one frame, in the vehicle's frame. A copy.

        Its column "sensor" is the place of each point's sensor in the rig, from 0, uint8. "time", and the clocks of its
        lines, count from utc_ns, on the clock of the earliest frame. Points are in the order of the
        sensors in the rig. grid() needs the frame of one sensor.

        Args:
            columns: names, as a list or "x,y,z"; without them, those that all of its frames have; a warning names
                others.

        Raises:
            OptionError: frames were read without a rig: x, y and z are then in each sensor's own frame; or poses moved
                only some of them, or not all to one frame, or deskew() moved each to its own moment:
                use frames.joined().deskew(poses).
            UnknownKeyError: a frame lacks a column.
        """
        return _join(list(self._frames.values()), columns, self.complete)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FrameSet):
            return NotImplemented
        return self._frames == other._frames and self._missing == other._missing

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        frames = ", ".join(f"{name} {frame.number}" for name, frame in self._frames.items())
        missing = f"; missing: {', '.join(self._missing)}" if self._missing else ""
        return f"<FrameSet {frames}{missing}; {self.spread * 1e3:.1f} ms apart>"


def refuse_set(given: Any) -> None:
    """TypeError: a set is given where frames are taken."""
    if isinstance(given, FrameSet):
        raise TypeError("a FrameSet is given where frames are expected: use frames.joined(), one frame of "
                        "all its points, or frames.values(), its frames")


def check_frame(given: Any) -> None:
    """TypeError: a source gives something else than a frame."""
    refuse_set(given)
    if not isinstance(given, Frame):
        raise TypeError(f"the source gives {type(given).__name__} and not frames")


def _names_of(frames: Sequence[Frame], columns: Union[str, Iterable[str], None]) -> list[str]:
    if columns is None:
        every = dict.fromkeys(name for frame in frames for name in frame.columns if name != "sensor")
        lacking = {name: [frame.sensor for frame in frames if name not in frame] for name in every}
        left_out = [f"{name}, which {' and '.join(of)} {'has' if len(of) == 1 else 'have'} not" for name, of in lacking.items() if of]
        if left_out:
            warn(f"joined frames have the columns that all of them have, without {'; '.join(left_out)}")
        return [name for name, of in lacking.items() if not of]
    names = columns.split(",") if isinstance(columns, str) else list(columns)
    for name in names:
        for frame in frames:
            if name != "sensor" and name not in frame:
                raise frame._refuse(name)
    return [name for name in dict.fromkeys(names) if name != "sensor"]


def _check_moments(frames: list[Frame]) -> None:
    """Points as of several moments are not one cloud of a vehicle that moves."""
    if frames[0]._moved not in ("start", "middle"):
        return
    part = 0.5 if frames[0]._moved == "middle" else 0.0
    moments = [frame.utc_ns + round(part * frame.duration * 1e9) for frame in frames]
    apart = max(moments) - min(moments)
    if apart > _MOMENT_NS:
        raise OptionError(f"each frame of the set was moved to a moment of its own, its {frames[0]._moved}, and these are "
                          f"{apart * 1e-6:.1f} ms apart: join them first, and move the joined frame: frames.joined().deskew(poses)")


def _join(frames: list[Frame], columns: Union[str, Iterable[str], None], is_whole: bool) -> Frame:
    for frame in frames:
        if frame._info.member <= 0:
            raise OptionError(f"the points of {frame.sensor} are in its own frame, since it was read without a rig, and cannot "
                              "be joined with others: open the source with rig=")
    if len({frame._moved for frame in frames}) > 1:
        raise OptionError("some frames of the set were moved by poses, others were not, or to "
                          "another frame: move all alike before joining them")
    if len({frame._info.rig for frame in frames}) > 1:
        raise OptionError("the frames were read with several rigs, but places of sensors belong to one: "
                          "read all of them with one rig")
    _check_moments(frames)
    names = _names_of(frames, columns)
    arrays = {name: np.concatenate([frame._array(name) for frame in frames]) for name in names}
    first = min(frames, key=lambda frame: frame.utc_ns)
    later_ns = [frame.utc_ns - first.utc_ns for frame in frames]
    if "time" in arrays:
        arrays["time"] = np.concatenate([(frame["time"].astype("f8") + ns * 1e-9).astype("f4")
                                         for frame, ns in zip(frames, later_ns)])
    counts = [len(frame) for frame in frames]
    arrays["sensor"] = np.repeat(np.array([frame._info.member - 1 for frame in frames], "u1"), counts)
    return restore(vars(_info_of(frames, first, is_whole)), arrays, _lines_of(frames, first, later_ns), first._moved)


def _lines_of(frames: list[Frame], first: Frame, later_ns: list[int]) -> Array:
    """The lines of all, on the clock of the earliest frame."""
    parts, before = [], 0
    for frame, ns in zip(frames, later_ns):
        part = frame.lines.copy()
        part["first_point"] += before
        part["clock_us"] += first._info.begin_clock_us - frame._info.begin_clock_us + ns // 1000
        before += len(frame)
        parts.append(part)
    return np.concatenate(parts)


def _info_of(frames: list[Frame], first: Frame, is_whole: bool) -> Any:
    infos = [frame._info for frame in frames]
    losses: collections.Counter[str] = collections.Counter()
    for info in infos:
        losses.update(info.losses)
    end_ns = max(frame.utc_ns + round(frame.duration * 1e9) for frame in frames)
    return first._info.replace(
        sensor=0, interface="", name="+".join(frame.sensor for frame in frames), pose=None, member=JOINED,
        is_complete=is_whole and all(info.is_complete for info in infos), is_first=any(info.is_first for info in infos),
        is_last=any(info.is_last for info in infos), has_pause=any(info.has_pause for info in infos),
        end_clock_us=first._info.begin_clock_us + (end_ns - first.utc_ns) // 1000,
        begin_arrival_ns=min(info.begin_arrival_ns for info in infos), end_arrival_ns=max(info.end_arrival_ns for info in infos),
        utc_error_ns=max(info.utc_error_ns for info in infos), losses=dict(losses),
        lines=(sum(info.lines[0] for info in infos), sum(info.lines[1] for info in infos)),
        rows=(max(info.rows[0] for info in infos), max(info.rows[1] for info in infos)))


# --- Which frames belong together ---


class _Item(NamedTuple):
    """A frame, or the place of one that did not come."""

    ns: int
    place: int  # in the order in which they were noted
    name: str
    number: int
    frame: Optional[Frame]


class _Track:
    """What is known of a sensor."""

    def __init__(self) -> None:
        self.number: Optional[int] = None  # of its latest frame; None: none came yet
        self.latest_ns = 0  # when that one began
        self.ns = 0  # the latest time at which one began
        self.was_first = False
        self.period_ns = 0  # not known
        self._periods: collections.deque[int] = collections.deque(maxlen=_PERIODS)

    def note(self, frame: Frame) -> list[tuple[int, int]]:
        """Take its next frame. Returns times and numbers of those before it that did not come."""
        ns, number = frame.utc_ns, frame.number
        skipped: list[tuple[int, int]] = []
        if self.number is not None:
            steps, passed = number - self.number, ns - self.ns
            usual = self.period_ns
            if usual and 1 < steps <= _SKIPPED_MAX and abs(passed // steps - usual) < usual // 4:
                skipped = [(self.ns + passed * i // steps, self.number + i) for i in range(1, steps)]
            if steps > 0 and passed > 0 and not self.was_first:
                self._periods.append(passed // steps)
                self.period_ns = statistics.median_low(self._periods)
        self.number, self.latest_ns, self.was_first = number, ns, frame.first
        self.ns = max(ns, self.ns)
        return skipped


def _first_set(items: Sequence[_Item], tolerance_ns: int) -> int:
    """How many items the first set has.

    Of all ways to part the items into sets, that one is taken where the links, from each item to the next one of its set, are
    worth most: a link is worth the tolerance without the time that it bridges. So sets are as large as may be, and part where
    nothing begins for long.
    """
    best: list[tuple[int, int, int]] = [(0, 0, 0)]  # worth, links, size of the first set
    for end in range(1, len(items) + 1):
        found: Optional[tuple[int, int, int]] = None
        names: set[str] = set()
        for begin in range(end - 1, -1, -1):
            span = items[end - 1].ns - items[begin].ns
            if span > tolerance_ns or items[begin].name in names:
                break
            names.add(items[begin].name)
            worth, links, first = best[begin]
            more = end - 1 - begin
            this = worth + more * tolerance_ns - span, links + more, first if begin else end
            found = this if found is None or this[:2] > found[:2] else found
        assert found is not None
        best.append(found)
    return best[-1][2]


class _Sync:
    """Frames on their way into sets."""

    def __init__(self, tolerance_ns: Optional[int], names: Iterable[str]) -> None:
        self._given_ns = tolerance_ns
        self._tracks = {name: _Track() for name in names}
        self._items: list[_Item] = []
        self._noted = 0
        self._durations_ns = 0
        self._begin_ns: Optional[int] = None
        self._now_ns = 0
        self._done_ns = 0
        self._told: set[str] = set()
        self._alike: set[str] = set()
        self.has_ended = False

    # What is known.

    def _tolerance_ns(self) -> Optional[int]:
        """None: the shortest period is not known yet."""
        if self._given_ns is not None:
            return self._given_ns
        periods = [track.period_ns for track in self._tracks.values() if track.period_ns]
        return min(periods) if periods else self._durations_ns if self.has_ended else None

    def _known_ns(self) -> float:
        """The time up to which all frames have come that are waited for."""
        longest = max((track.period_ns for track in self._tracks.values()), default=0)
        known = math.inf
        for track in self._tracks.values():
            since = self._begin_ns if track.number is None else track.ns
            wait = _SILENT * (track.period_ns or longest)
            if since is not None and (not longest or self._now_ns <= since + wait):
                known = min(known, since)
        return known

    def _tell_alike(self, frame: Frame, name: str) -> None:
        """The sources of two sensors may give both one name; a sensor's own numbers do not come twice in the time of a frame."""
        track = self._tracks.get(name)
        if track is None or track.number is None or name in self._alike:
            return
        if frame.number <= track.number and 0 <= frame.utc_ns - track.latest_ns < frame.duration * 1e9:
            self._alike.add(name)
            warn(f"frames of two sensors have the name {name}, so sync() takes them for one: use different "
                 "names, as open(rig=) gives them")

    def _tell(self, frame: Frame, name: str) -> None:
        if frame._info.begin_utc_ns or name in self._told:
            return
        self._told.add(name)
        warn(f"frames of {name} have no clock, by their profile: sync() takes the arrival of their first packet as their start")

    def add(self, frame: Frame) -> None:
        """Take a frame."""
        name = frame.sensor
        self._tell(frame, name)
        self._tell_alike(frame, name)
        track = self._tracks.setdefault(name, _Track())
        for ns, number in track.note(frame):
            if ns > self._done_ns:
                self._insert(_Item(ns, 0, name, number, None))
        self._insert(_Item(frame.utc_ns, 0, name, frame.number, frame))
        self._durations_ns = max(self._durations_ns, round(frame.duration * 1e9))
        self._begin_ns = frame.utc_ns if self._begin_ns is None else self._begin_ns
        self._now_ns = max(self._now_ns, frame.utc_ns + track.period_ns)

    def _insert(self, item: _Item) -> None:
        self._noted += 1
        bisect.insort(self._items, item._replace(place=self._noted))  # places differ, so nothing behind them is compared

    # Sets.

    def take(self) -> Optional[FrameSet]:
        """The next set that is certain; None: none is yet."""
        while self._items:
            tolerance = self._tolerance_ns()
            is_full = len(self._items) > _HELD_MAX
            if tolerance is None and not is_full:
                return None
            tolerance = tolerance or 0
            horizon = self._items[0].ns + 2 * tolerance
            if not (self.has_ended or is_full or self._known_ns() > horizon):
                return None
            near = self._items[:bisect.bisect_right(self._items, (horizon, math.inf))]
            chosen = near[:_first_set(near, tolerance)]
            del self._items[:len(chosen)]
            is_late = chosen[-1].ns < self._done_ns
            self._done_ns = max(self._done_ns, chosen[-1].ns)
            frames = {item.name: item.frame for item in chosen if item.frame is not None}
            if frames:
                return self._set(frames, {item.name: item for item in chosen}, tolerance, is_late)
        return None

    def _set(self, frames: Mapping[str, Frame], items: Mapping[str, _Item], tolerance: int, is_late: bool) -> FrameSet:
        ns = min(frame.utc_ns for frame in frames.values())
        missing = {name: self._why(name, items.get(name), ns, tolerance, is_late) for name in self._tracks if name not in frames}
        return FrameSet({name: frames[name] for name in self._tracks if name in frames}, missing)

    def _why(self, name: str, skipped: Optional[_Item], ns: int, tolerance: int, is_late: bool) -> str:
        track = self._tracks[name]
        if skipped is not None:
            return f"its frame {skipped.number} did not come"
        if track.number is None:
            return "no frame of it came" if self.has_ended else "no frame of it has come yet"
        if is_late:
            return "the set came late, after the sets of its time"
        if track.ns < ns:
            ago = f"its last frame, {track.number}, began {(ns - track.latest_ns) * 1e-9:.3f} s before"
            return f"the stream ended; {ago}" if self.has_ended else f"no later frame of it has come; {ago}"
        return f"no frame of it begins within {tolerance * 1e-9:.3f} s that is not in another set"


# --- The function ---


def _check_tolerance(value: Any) -> Optional[int]:
    right = "use seconds from 0, such as 0.02, or None"
    if value is None:
        return None
    if isinstance(value, bool) or not hasattr(value, "__float__") or isinstance(value, str):
        raise TypeError(f"tolerance is {value!r}, of type {type(value).__name__}; {right}")
    if not 0 <= float(value) <= 3600:
        raise OptionError(f"tolerance is {value!r}; {right}, up to 3600")
    return round(float(value) * 1e9)


def _sets(frames: Iterable[Frame], state: _Sync) -> Iterator[FrameSet]:
    for frame in frames:
        check_frame(frame)
        state.add(frame)
        yield from iter(state.take, None)
    state.has_ended = True
    yield from iter(state.take, None)


def sync(source: Union[Source, Iterable[Frame]], tolerance: Optional[float] = None,
         sensors: Optional[Iterable[str]] = None) -> Iterator[FrameSet]:
    """Frames of several sensors that belong together, by UTC.

        with lumsdk.open("drive.pcapng", rig="rig.yaml") as source:
            for frames in lumsdk.sync(source):
                if frames.complete:
                    use(frames["front"], frames["left"], frames.joined())
                else:
                    print(frames.missing)

    Each frame is in exactly one set, and a set has at most one frame of each sensor; all of its frames begin within the
    tolerance. Nothing is dropped: a frame without partners is a set of its own, and each set says which sensors it lacks, and why.
    Of several possible sets, those are made that keep frames together which begin shortly after
    each other; a set ends at a longer gap. Sets come by their time, but for late frames.

    Sensors that run freely at one rate make complete sets, whatever their phases are, as long as the tolerance is at least
    their period, or, of n sensors, (n - 1) / n of it. Where one runs twice as fast as others, every second of its frames is a set of
    its own. Where one period is a little longer than another, a frame is left alone each time the difference adds up to a period.

    A set comes when frames of all sensors have come that begin twice the tolerance later. A sensor from which nothing comes is
    waited for during five periods, so that memory is bounded when one stops: it is then missing from the sets, and joins
    them again when it continues. Its last frame before ends only then, or with the stream, so it comes late, in a set after those
    of its time. The same happens where the clock of one goes back.

    Args:
        source: a Source, opened with rig= or of several sensors; or anything that gives frames, such as
            heapq.merge(a, b, key=lambda frame: frame.utc_ns) of two sources, whose sensors have different names.
        tolerance: seconds. Without it, the shortest period of the sensors, as far as known.
        sensors: the names of all that are to come, such as a Rig; a Source that was opened with rig= has them itself.
            Without them, a sensor is missed only after its first frame.

    Raises:
        OptionError, TypeError: an option is not right, or the source gives something else than frames.
    """
    tolerance_ns = _check_tolerance(tolerance)
    names = list(sensors) if isinstance(sensors, Iterable) else []
    if sensors is not None and (not isinstance(sensors, Iterable) or isinstance(sensors, str) or
                                any(not isinstance(name, str) for name in names)):
        raise TypeError(f"sensors is {sensors!r}; use a list of names, or a Rig")
    if isinstance(source, Source) and sensors is None:
        names = source._names()
    if isinstance(source, (str, os.PathLike, bytes)):
        raise TypeError(f"a source is given as {type(source).__name__}; use a Source: "
                        "lumsdk.sync(lumsdk.open(..., rig=...))")
    if not isinstance(source, Iterable):
        raise TypeError(f"a source is given as {type(source).__name__}; use a Source, or what gives frames")
    return _sets(source, _Sync(tolerance_ns, names))
