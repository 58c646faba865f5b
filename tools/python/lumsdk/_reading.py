"""One pass over a capture, from its start."""
from __future__ import annotations

import contextlib
import os
import time
import weakref
from _thread import allocate_lock
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Optional

from ._c import check, ffi, lib, sized, text
from ._errors import CaptureError, ClosedError, Error, warn
from ._frame import Frame
from ._raw import Origin, frame_of

if TYPE_CHECKING:
    from ._inputs import Functions, Input
    from ._options import Choice
    from ._rig import RigSensor
    from ._settings import Calibration, Profile

_PROGRESS_S = 0.1

_KINDS = {"data": lib.LUM_PACKET_DATA, "heartbeat": lib.LUM_PACKET_HEARTBEAT, "set_ip": lib.LUM_PACKET_SET_IP,
          "timestamp": lib.LUM_PACKET_TIMESTAMP, "tlv": lib.LUM_PACKET_TLV}
_BAD_KINDS = {"malformed": lib.LUM_PACKET_MALFORMED, "unknown_tag": lib.LUM_PACKET_UNKNOWN_TAG,
              "unknown_type": lib.LUM_PACKET_UNKNOWN_TYPE, "foreign": lib.LUM_PACKET_FOREIGN}


def _of_packets(c: Any) -> dict[str, int]:
    """lum_demux_counters by lumdump's names."""
    a = c.assembly
    found = {name: c.packets[kind] for name, kind in {**_KINDS, **_BAD_KINDS}.items()}
    found.update({name: getattr(c, name) for name in (
        "angle_packets", "range_packets", "joined", "cut_short", "out_of_order", "other")})
    found.update({name: getattr(a, name) for name in (
        "frames", "lines", "words", "lost_words", "lines_missing_angles", "lines_skipped", "bad_words", "late",
        "duplicate", "conflict", "no_room", "stray")})
    return found


def _of_lines(c: Any) -> dict[str, int]:
    """lum_framer_counters by lumdump's names."""
    return {"lines_blue": c.lines[lib.LUM_EYE_BLUE], "lines_green": c.lines[lib.LUM_EYE_GREEN],
            "points": c.points - c.points_late - c.points_cut, "points_late": c.points_late, "points_cut": c.points_cut,
            "lines_missing": c.lines_missing, "lines_in_pauses": c.lines_in_pauses, "pauses": c.pauses,
            "lines_late": c.lines_late, "lines_cut": c.lines_cut, "no_angle": c.losses.no_angle, "no_range": c.losses.no_range,
            "lines_under_way": c.under_way.lines, "words_under_way": c.under_way.words,
            "no_angle_under_way": c.under_way.no_angle, "missing_under_way": c.missing_under_way,
            "stray_at_breaks": c.stray_at_breaks, "frames_selected": c.frames}


def _of_clock(clock: Any) -> dict[str, int]:
    """lum_clock_fit_info by lumdump's names."""
    info = sized("lum_clock_fit_info")
    if clock != ffi.NULL:
        lib.lum_clock_fit_get_info(clock, info)
    return {"sensor_breaks": info.sensor_breaks, "host_steps": info.host_steps, "stamps_still": info.still}


class Counts:
    """What was counted: counts by lumdump's names, and the sensors that sent data."""

    def __init__(self, reader: Any, damaged: int = 0, members: Sequence[RigSensor] = ()) -> None:
        """Of a reader, or all 0 without one."""
        framer = ffi.NULL if reader is None else lib.lum_reader_framer(reader)
        demux = ffi.NULL if reader is None else lib.lum_framer_demux(framer)
        total, of_sensor = sized("lum_demux_counters"), sized("lum_framer_counters")
        number, name = 0, ffi.new("char[]", lib.LUM_SENSOR_NAME_BYTES)
        if reader is not None:
            lib.lum_demux_total(demux, total)
            number = lib.lum_demux_sensor_count(demux)
        self.sensors = [text(lib.lum_demux_name(demux, i, name)) for i in range(number)]
        self.requested = [self.sensors[i] for i in range(number) if lib.lum_demux_is_requested(demux, i)]
        of_member = [lib.lum_framer_member(framer, i) if members else -1 for i in range(number)]
        of_packets = sized("lum_demux_counters")
        lines = {**_of_lines(of_sensor), **_of_clock(ffi.NULL)}
        self.paused_s = 0.0
        self.by_sensor: dict[str, dict[str, int]] = {}
        for i in range(len(self.sensors)):
            lib.lum_framer_count(framer, i, of_sensor)
            lib.lum_demux_count(demux, i, of_packets)
            self.paused_s += of_sensor.paused_us * 1e-6
            here = {**_of_lines(of_sensor), **_of_clock(lib.lum_framer_clock(framer, i))}
            for name, count in here.items():
                lines[name] += count
            if of_member[i] >= 0:
                self.sensors[i] = members[of_member[i]].name
            if not members or lib.lum_demux_is_requested(demux, i):
                self.by_sensor[self.sensors[i]] = {**_of_packets(of_packets), **here}
        self.counts: dict[str, int] = {**_of_packets(total), **lines, "damaged": damaged}

    @property
    def packets(self) -> int:
        """Packets of a G2."""
        return sum(self.counts[name] for name in (*_KINDS, *_BAD_KINDS) if name != "foreign")


class _Watch:
    """Asked by the library every few milliseconds: takes Ctrl-C, and tells the progress.

    It does not know its callback, so that no cycle keeps a reader open."""

    def __init__(self, tell: Any) -> None:
        self._tell = tell
        self._told_s = time.monotonic()
        self.problem: Optional[BaseException] = None
        self.reader: Any = None
        self.bytes = ffi.new("uint64_t[2]")

    def note(self, _: Any, problem: Any, __: Any) -> None:
        """What go_on() raised, or a signal during it."""
        self.problem = problem

    def go_on(self, _: Any) -> bool:
        """Called in the thread that reads."""
        if self._tell is not None and self.reader is not None and time.monotonic() - self._told_s >= _PROGRESS_S:
            self.tell()
        return True

    def tell(self) -> None:
        """Tell the progress to whoever asked for it."""
        self._told_s = time.monotonic()
        if self._tell is not None:
            self.measure()
            self._tell(self.bytes[0], self.bytes[1])

    def measure(self) -> None:
        """Find out how much was read."""
        lib.lum_reader_progress(self.reader, self.bytes, self.bytes + 1)

    def raise_problem(self) -> None:
        """What was raised, in the call that it ended."""
        problem, self.problem = self.problem, None
        if problem is not None:
            raise problem


_open_readings: weakref.WeakSet[Reading] = weakref.WeakSet()


def _abandon_all() -> None:
    """In a process that was forked."""
    for reading in list(_open_readings):
        reading.abandon()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_abandon_all)


class Reading:
    """One pass, used by one thread at a time, in the process that began it."""

    def __init__(self, source: Input, choice: Choice, settings: tuple[Calibration, Profile],
                 origins: Sequence[str]) -> None:
        self._choice, self._name = choice, source.name
        self._origin = Origin(source.name, *settings, tuple(origins), source.files)
        self._busy = allocate_lock()
        self._reader: Any = None
        self._error, self._out = ffi.new("lum_error *"), ffi.new("const lum_frame **")
        self._counts: Optional[Counts] = None
        self._watch = _Watch(choice.progress)
        self.ended = False
        self.truncated = False
        self.frames = 0
        self.place: Optional[int] = 0  # of the frame that comes next; None: not known
        self.was_sought = False
        self.was_forked = False  # this process was forked from the one that reads
        self.was_stopped = False  # by Ctrl-C, what the program's functions raised, or a failure: it cannot be used any more
        self._kept: list[Any] = []
        framer, kept = choice.framer_options(*settings)
        self._kept += [framer, kept]
        self._functions: Optional[Functions]
        members, self._functions = source.begin(self._kept)
        self.can_jump = "records" not in members
        self._capture = None if self.can_jump else ffi.cast("lum_capture *", members["records"].context)
        self._open(framer, members)
        _open_readings.add(self)

    def abandon(self) -> None:
        """What a process that was forked does not have: threads, and a place of its own in files. So nothing is closed."""
        if self._reader is not None:
            ffi.gc(self._reader, None)
            self._reader = None
            self.was_forked = self.was_stopped = True
        self._busy = allocate_lock()

    def _open(self, framer: Any, members: dict[str, Any]) -> None:
        reader = ffi.new("lum_reader **")
        go_on = ffi.callback("bool(void *)", self._watch.go_on, error=False, onerror=self._watch.note)
        self._kept.append(go_on)
        options = sized("lum_reader_options", framer=framer, go_on=go_on, keeps_index=True, **members)
        status = lib.lum_reader_open(options, reader, self._error)
        self._watch.raise_problem()
        check(status, self._error, CaptureError)
        self._reader = ffi.gc(reader[0], lib.lum_reader_close)
        self._watch.reader = reader[0]

    def _raise_problem(self) -> None:
        """What ended the call that was under way: Ctrl-C, or the function for the progress."""
        if self._watch.problem is not None:
            self.ended = self.was_stopped = True
        self._watch.raise_problem()
        problem = self._functions.problem if self._functions is not None else None
        if problem is not None and not isinstance(problem, Exception):
            self.ended = self.was_stopped = True
            raise problem

    @contextlib.contextmanager
    def _use(self, is_open: bool = True) -> Iterator[None]:
        """One call at a time, of a reading that is open."""
        if not self._busy.acquire(blocking=False):
            raise Error(f"{self._name}: another thread, or the function called just now, is "
                        "reading it; open a source for each thread")
        try:
            if is_open:
                self._check_open()
            yield
        finally:
            self._busy.release()

    def _check_open(self) -> None:
        if self.was_forked:
            raise Error(f"{self._name}: this iteration began before this process was forked and belongs "
                        "to the other one; begin one here")
        if self._reader is None:
            raise ClosedError(f"{self._name}: the source is closed; open it again to read it")

    # Frames.

    def next(self) -> Optional[Frame]:
        """The next frame; None at the end."""
        with self._use():
            try:
                return None if self.ended else self._next()
            except StopIteration as problem:  # a loop would take it for the end
                raise RuntimeError(f"{self._name}: a function of the program that was called raised StopIteration") from problem

    def _make(self, pointer: Any) -> Frame:
        frame = Frame(pointer, self._choice.of_frames)
        return frame_of(frame, self._origin_of(frame)) if self._choice.raw else frame

    def _origin_of(self, frame: Frame) -> Origin:
        if not frame._info.member:
            return self._origin
        sensor = self._choice.members[frame._info.member - 1]
        return self._origin._replace(calibration=sensor.calibration, profile=sensor.profile)

    def _next(self) -> Optional[Frame]:
        status = lib.lum_reader_next_frame(self._reader, self._out, self._error)
        self._raise_problem()
        frame = self._make(self._out[0]) if status > 0 else None
        if frame is not None:
            self.frames += not self.was_sought
            self.place = None if self.place is None else self.place + 1
        else:
            self.ended = True
            self.truncated = status < 0
        self._watch.tell()
        if frame is None:
            self._conclude()
        return frame

    # Places.

    def _seek(self, function: Any, *place: Any) -> None:
        """Go to a place. What was counted until now stays what count() gives."""
        with self._use():
            if self._counts is None:
                self._counts = self._count()
            self.was_sought, self.ended, self.truncated = True, False, False
            self.place = None
            status = function(self._reader, *place, self._error)
            self._raise_problem()
            if status != 0:
                self.ended = self.was_stopped = True
                told = text(self._error.text)
                raise CaptureError(told if told.startswith(f"{self._name}: ") else f"{self._name}: {told}")

    def seek_frame(self, place: int) -> None:
        """Let a frame come next, by its place in the order of the stream."""
        if self.place != place:
            self._seek(lib.lum_reader_seek_frame, place)
            self.place = place

    def seek_time(self, utc_ns: int) -> None:
        """Let the first frame come next that begins at a time or later."""
        self._seek(lib.lum_reader_seek_time, utc_ns)

    def known(self) -> tuple[int, bool]:
        """How many frames are known, and whether these are all."""
        info = sized("lum_reader_index")
        with self._use():
            lib.lum_reader_get_index(self._reader, info)
        return info.frames, info.is_whole

    def load_index(self) -> None:
        """Use the index that stands beside the capture, if it fits."""
        lib.lum_reader_load_index(self._reader, ffi.NULL, ffi.NULL)

    def save_index(self) -> None:
        """Write the index beside the capture."""
        with self._use():
            check(lib.lum_reader_save_index(self._reader, ffi.NULL, self._error), self._error, CaptureError)

    # Its end.

    def _conclude(self) -> None:
        """As lumdump concludes: raises for what it refuses, and warns as it warns."""
        if self._functions is not None and self._functions.problem is not None:
            raise self._functions.problem
        said = [part for part in (self._damage()[1], text(self._error.text) if self.truncated else "") if part]
        if said and not self._choice.warns:
            raise CaptureError("; ".join(said))
        for part in said:
            warn(part)
        if not self.was_sought:
            self._check_all(self._count())

    def _check_all(self, counts: Counts) -> None:
        """What only a whole pass tells."""
        self._check_sensor(counts)
        self._check_rig(counts)
        if counts.counts["data"] == 0 and counts.packets:
            kinds = ", ".join(f"{name} {counts.counts[name]}" for name in (*_KINDS, *_BAD_KINDS) if counts.counts[name])
            raise CaptureError(f"{self._name}: packets of a G2 came, but none of them is a data packet: {kinds}; lumdump "
                               "shows their types and lengths, and with --infer finds their layout, for a profile")
        if not counts.packets:
            warn(f"{self._name}: no packet of a G2 was found: no complete packet to or from UDP port "
                 f"{self._choice.port} has its magic")
        for remark in self._remarks():
            warn(f"{self._name}: {remark}")
        self._check_points(counts.counts)
        self._check_clocks(counts.counts)

    def _remarks(self) -> list[str]:
        """What is odd about the records, as lumdump says it."""
        remarks: list[str] = []
        out = ffi.new("lum_error *")
        while lib.lum_reader_remark(self._reader, len(remarks), out):
            remarks.append(text(out.text))
        return remarks

    def _check_rig(self, counts: Counts) -> None:
        """Sensors of the rig of which one sent nothing are told by the remarks."""
        wanted = self._choice.wanted
        if wanted and counts.sensors and not counts.by_sensor:
            raise CaptureError(f"{self._name}: no data of {', '.join(map(str, wanted))} in it, but of {', '.join(counts.sensors)}: "
                               "use the addresses that the capture has, and its interfaces for sensors with one address")

    def _check_sensor(self, counts: Counts) -> None:
        wanted = self._choice.sensor
        if wanted is None or not counts.sensors:
            return
        if not counts.requested:
            raise CaptureError(f"{self._name}: no data of {wanted.name} in it, but of {' '.join(counts.sensors)}")

    def _check_clocks(self, counts: dict[str, int]) -> None:
        if counts["stamps_still"]:
            warn(f"{self._name}: the arrival times of {counts['stamps_still']} lines stood still: UTC is not known there, and "
                 "utc_error_ns of their frames is None")
        if counts["host_steps"]:
            warn(f"{self._name}: the clock of the host that recorded it was stepped {counts['host_steps']} times: within a "
                 "second of that UTC is not known, and utc_error_ns of frames is None")

    def _check_points(self, counts: dict[str, int]) -> None:
        if counts["points"] or not counts["lines_blue"] + counts["lines_green"]:
            return
        why = "the selection leaves none"
        if not counts["words"]:
            why = "there are no ranges, as when the laser is off"
        elif counts["no_angle"] + counts["no_range"]:
            why = "see no_angle and no_range in the losses, and the selection"
        warn(f"{self._name}: lines came, but no point is left of them: {why}")

    # What is known of it.

    def progress(self) -> tuple[int, int]:
        """Bytes that were read, and all of them; 0: not known."""
        if self._reader is not None and self._busy.acquire(blocking=False):
            try:
                self._watch.measure()
            finally:
                self._busy.release()
        return self._watch.bytes[0], self._watch.bytes[1]

    def _damage(self) -> tuple[int, str]:
        """How many parts could not be read and were passed over, and a message about them."""
        error = ffi.new("lum_error *")
        if self._capture is not None:
            return int(lib.lum_capture_damaged(self._capture, error)), text(error.text)
        return int(lib.lum_reader_damaged(self._reader, error)), text(error.text)

    def _count(self) -> Counts:
        return Counts(self._reader, self._damage()[0], self._choice.members)

    def count(self) -> Counts:
        """What was counted so far."""
        if self._counts is not None:
            return self._counts
        if self._reader is None:
            return Counts(None)
        with self._use(is_open=False):
            return self._count()

    def close(self) -> None:
        """Close it; what was counted stays."""
        with self._use(is_open=False):
            if self._reader is not None:
                self._counts = self._counts or self._count()
                self._watch.measure()
                self._watch.reader = None
                ffi.release(self._reader)
                self._reader = None
