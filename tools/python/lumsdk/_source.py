"""Captures as sources of frames."""
from __future__ import annotations

import datetime
import glob
import os
import threading
import warnings
from collections.abc import Iterator, Sequence
from typing import IO, TYPE_CHECKING, Any, Optional, Union, overload

from ._c import address_of, failure, ffi, lib, sized, text
from ._errors import CaptureError, CaptureWarning, ClosedError, Error
from ._frame import Frame
from ._options import Choice
from ._settings import Calibration, Profile

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import Options

    Path = Union[str, os.PathLike[str]]
    Input = Union[Path, Sequence[Path], bytes, bytearray, memoryview, IO[bytes]]

_RIGHT = ("right is a path, a pattern such as \"drive-*.pcap\", a list of paths, the bytes of a capture, a binary file "
          "object, or a URL")
_PACKETS = {"data": lib.LUM_PACKET_DATA}
_ASSEMBLY = ("lost_words", "lines_skipped", "bad_words", "late", "duplicate", "conflict", "no_room", "stray")


class _Functions:
    """A binary file object as the functions of a lum_source."""

    def __init__(self, file: Any, name: str) -> None:
        self.file, self.error = file, None
        self._read = ffi.callback("int64_t(void *, void *, size_t, lum_error *)", self.read)
        self._functions = sized("lum_source_functions", read=self._read)
        self.name = name.encode(errors="replace")

    error: Optional[BaseException]

    def read(self, _: Any, buffer: Any, room: int, error: Any) -> int:
        """Called by the library, in the thread that reads."""
        try:
            got = self.file.read(room)
            if not isinstance(got, (bytes, bytearray, memoryview)):
                raise TypeError(f"{self.name.decode()}: its read() gives {type(got).__name__} and not bytes: open it "
                                'with mode "rb"')
            ffi.memmove(buffer, got, min(len(got), room))
            return min(len(got), room)
        except BaseException as problem:
            self.error = problem
            said = f"{self.name.decode()}: {type(problem).__name__}: {problem}".encode(errors="replace")[:500]
            ffi.memmove(error.text, said + b"\0", len(said) + 1)
            return -1

    def open(self) -> Any:
        """A source of the library."""
        return lib.lum_source_from_functions(self.name, self._functions, ffi.NULL)


class _Reading:
    """One pass over a source, from its start."""

    def __init__(self, source: Source, options: Any) -> None:
        self.choice = source._choice
        self.functions: Optional[_Functions] = None
        self._busy = threading.Lock()
        self._kept: list[Any] = []
        self._error = ffi.new("lum_error *")
        self._out = ffi.new("const lum_frame **")
        self._reader: Any = None
        self.ended = False
        self.truncated = False
        framer, self._kept = options
        o = sized("lum_reader_options", framer=framer, **source._input(self))
        reader = ffi.new("lum_reader **")
        if lib.lum_reader_open(o, reader, self._error) != 0:
            raise self._failure()
        self._reader = ffi.gc(reader[0], lib.lum_reader_close)

    def _failure(self) -> BaseException:
        problem = failure(self._error, CaptureError)
        if self.functions is not None and self.functions.error is not None:
            return self.functions.error
        return problem

    def next(self) -> Optional[Frame]:
        """The next frame; None at the end."""
        if not self._busy.acquire(blocking=False):
            raise Error("the source is in use by another thread: open one for each thread")
        try:
            return self._next()
        finally:
            self._busy.release()

    def _next(self) -> Optional[Frame]:
        if self._reader is None:
            raise ClosedError("the source is closed")
        if self.ended:
            return None
        status = lib.lum_reader_next_frame(self._reader, self._out, self._error)
        if self.choice.progress is not None:
            self.choice.progress(*self.progress())
        if status > 0:
            return Frame(self._out[0])
        self.ended = True
        if status < 0:
            self._break_off()
        return None

    def _break_off(self) -> None:
        self.truncated = True
        problem = self._failure()
        if self.choice.warns and isinstance(problem, CaptureError):
            warnings.warn(str(problem), CaptureWarning, stacklevel=5)
        else:
            raise problem

    def progress(self) -> tuple[int, int]:
        """Bytes that were read, and all of them; 0: not known."""
        numbers = ffi.new("uint64_t[2]")
        if self._reader is not None:
            lib.lum_reader_progress(self._reader, numbers, numbers + 1)
        return int(numbers[0]), int(numbers[1])

    def close(self) -> None:
        if not self._busy.acquire(blocking=False):
            raise Error("the source is in use by another thread: close it when that has ended")
        try:
            if self._reader is not None:
                ffi.release(self._reader)
            self._reader = None
        finally:
            self._busy.release()

    def counts(self) -> tuple[dict[str, int], list[str]]:
        """Losses by cause, and the sensors."""
        if self._reader is None:
            return {}, []
        framer = lib.lum_reader_framer(self._reader)
        demux = lib.lum_framer_demux(framer)
        total = sized("lum_demux_counters")
        lib.lum_demux_total(demux, total)
        a = total.assembly
        losses = {name: int(getattr(a, name)) for name in ("lost_words", "lines_missing_angles", "lines_skipped")}
        points = {"lines_cut": 0, "no_angle": 0, "no_range": 0}
        under_way = {"lines_under_way": 0, "words_under_way": 0, "no_angle_under_way": 0}
        sensors = []
        for i in range(lib.lum_demux_sensor_count(demux)):
            address = lib.lum_demux_address(demux, i)
            sensors.append(address_of(address))
            c = sized("lum_framer_counters")
            lib.lum_framer_count(framer, i, c)
            points["lines_cut"] += c.lines_cut
            points["no_angle"] += c.losses.no_angle
            points["no_range"] += c.losses.no_range
            under_way["lines_under_way"] += c.under_way.lines
            under_way["words_under_way"] += c.under_way.words
            under_way["no_angle_under_way"] += c.under_way.no_angle
        losses.update(points)
        return {**losses, **under_way}, sensors


class Source:
    """A capture, or several as one. Iteration gives its frames, each time from the start."""

    def __init__(self, kind: str, given: Any, name: str, choice: Choice) -> None:
        """Made by open()."""
        self._kind, self._given, self.name, self._choice = kind, given, name, choice
        self._calibration, self._profile = choice.calibration, choice.profile
        self._closed = False
        self._readings: list[_Reading] = []
        self._next: Optional[_Reading] = self._read()
        self._last: _Reading = self._next

    def _input(self, reading: _Reading) -> dict[str, Any]:
        """The members of lum_reader_options that name the source."""
        if self._kind == "paths":
            paths = [ffi.new("char[]", os.fsencode(path)) for path in self._given]
            reading._kept.extend(paths)
            if len(paths) == 1:
                return {"path": paths[0]}
            array = ffi.new("const char *[]", paths)
            reading._kept.append(array)
            return {"paths": array, "path_count": len(paths)}
        if self._kind == "bytes":
            buffer = ffi.from_buffer(self._given)
            reading._kept.append(buffer)
            return {"source": lib.lum_source_from_memory(b"bytes", buffer, len(buffer))}
        reading.functions = _Functions(self._given, self.name)
        return {"source": reading.functions.open()}

    def _read(self) -> _Reading:
        return _Reading(self, self._choice.framer_options(self._calibration, self._profile))

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError(f"{self.name}: the source is closed; open it again to read it")

    def __iter__(self) -> Iterator[Frame]:
        self._check_open()
        reading, self._next = self._next, None
        if reading is None:
            reading = self._again()
        self._last = reading
        return self._frames(reading)

    def _again(self) -> _Reading:
        if self._kind == "file":
            raise Error(f"{self.name}: it can be read once only; open it again, or name a path")
        return self._read()

    def _frames(self, reading: _Reading) -> Iterator[Frame]:
        while True:
            self._check_open()
            frame = reading.next()
            if frame is None:
                return
            yield frame

    def close(self) -> None:
        """Close it. Its frames, and arrays of them, stay valid."""
        self._counts = self._last.counts()
        self._closed = True
        for reading in (self._next, self._last):
            if reading is not None:
                reading.close()

    def __enter__(self) -> Source:
        self._check_open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def calibration(self) -> Calibration:
        """The calibration that its points are made with."""
        return self._calibration

    @property
    def profile(self) -> Profile:
        """The wire profile that its packets are read with."""
        return self._profile

    @property
    def losses(self) -> dict[str, int]:
        """What is missing so far in the latest iteration, by cause, with lumdump's names."""
        return self._counts[0] if self._closed else self._last.counts()[0]

    @property
    def sensors(self) -> list[str]:
        """The addresses of the sensors that sent data so far, such as "10.42.0.37"."""
        return self._counts[1] if self._closed else self._last.counts()[1]

    @property
    def progress(self) -> tuple[int, int]:
        """Bytes that the latest iteration has read, and all of them; 0: not known."""
        return self._last.progress()

    @property
    def truncated(self) -> bool:
        """Whether the latest iteration found that the capture breaks off before its end."""
        return self._last.truncated

    def __repr__(self) -> str:
        return f"<Source {self.name}>"

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Frame, list[Frame]]:
        """Frames by their place in the stream, from 0; below 0 from its end."""
        frames = list(self._frames(self._read()))
        return frames[index]

    def seek(self, time: Union[datetime.datetime, int, float]) -> Source:
        """Begin the next iteration at a time."""
        raise NotImplementedError


def _paths(given: Any) -> list[Any]:
    """A path, or those that a pattern means."""
    name = os.fsdecode(given)
    if not any(mark in name for mark in "*?[") or os.path.exists(name):
        return [given]
    found = sorted(glob.glob(name))
    if not found:
        raise CaptureError(f"{name}: no file has such a name")
    return list(found)


def open(source: Input, **options: Unpack[Options]) -> Source:
    """Open a capture, or several as one.

    source is a path; a pattern such as "drive-*.pcap"; a list of them; the bytes of a capture; or a binary file
    object, which is read once.
    """
    choice = Choice(options)
    if isinstance(source, (str, os.PathLike)):
        return Source("paths", _paths(source), os.fsdecode(source), choice)
    if isinstance(source, (bytes, bytearray, memoryview)):
        return Source("bytes", source, f"{len(source)} bytes", choice)
    if isinstance(source, (list, tuple)):
        paths = [path for given in source for path in _paths(given)]
        if not paths:
            raise CaptureError("no capture is named")
        return Source("paths", paths, os.fsdecode(paths[0]), choice)
    if callable(getattr(source, "read", None)):
        return Source("file", source, str(getattr(source, "name", "a file object")), choice)
    raise TypeError(f"a source is given as {type(source).__name__}; {_RIGHT}")
