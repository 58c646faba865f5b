"""Frames into the formats of the library's writer of clouds: csv, ply, pcd, las, xyz and mcap."""
from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from ._c import check, ffi, lib, sized
from ._columns import struct_dtype
from ._errors import OptionError
from ._table import Array, value
from ._target import TargetError

if TYPE_CHECKING:
    from ._frame import Frame

FORMATS = {"csv": lib.LUM_FORMAT_CSV, "ply": lib.LUM_FORMAT_PLY, "pcd": lib.LUM_FORMAT_PCD, "las": lib.LUM_FORMAT_LAS,
           "xyz": lib.LUM_FORMAT_XYZ, "mcap": lib.LUM_FORMAT_MCAP}
"""The formats, by name."""

_NUMBERS: dict[str, int] = {name: getattr(lib, f"LUM_NUMBER_{name.upper()}")
                            for name in ("u8", "u16", "u32", "u64", "i8", "i16", "i32", "i64", "f32", "f64")}

_OF_SAMPLE = ("x", "y", "z", "range", "azimuth", "elevation", "pulse_width", "pixel", "return_number",
              "number_of_returns", "edge")
_SAMPLE = struct_dtype("lum_sample")


_WHOLE_64 = ("csv", "las")
"""Formats with integers of 64 bits."""


def file_type(kind: str, dtype: np.dtype[Any]) -> np.dtype[Any]:
    """The type in which a file has numbers of a column of one's own."""
    if dtype.kind == "b" or dtype == np.dtype("f2"):
        return np.dtype("u1" if dtype.kind == "b" else "f4")
    return np.dtype(f"{dtype.kind}4") if dtype.kind in "iu" and dtype.itemsize == 8 and kind not in _WHOLE_64 else dtype


def _as_written(frame: Frame, name: str, dtype: np.dtype[Any]) -> Array:
    """A column of one's own in the type of the file."""
    numbers, limits = value(frame, name), np.iinfo(dtype) if dtype.kind in "iu" else None
    if limits is not None and len(numbers) and not limits.min <= numbers.min() <= numbers.max() <= limits.max:
        raise OptionError(f"frame {frame.number}: {name} is from {numbers.min()} to {numbers.max()}, but this format has 32-bit "
                          "integers; use these, or float64, or another format, such as csv, las or parquet")
    return np.ascontiguousarray(numbers, dtype)


def _extras(own: Mapping[str, np.dtype[Any]]) -> tuple[Any, list[Any]]:
    """The columns of one's own as the library takes them, and what has to live as long."""
    kept = [ffi.new("char[]", name.encode()) for name in own]
    out = ffi.new("lum_writer_extra[]", len(own))
    for one, name, dtype in zip(out, kept, own.values()):
        one.name, one.type = name, _NUMBERS[f"{dtype.kind}{dtype.itemsize * 8}"]
    return out, kept


def check_own(kind: str, columns: Optional[tuple[str, ...]], own: Mapping[str, np.dtype[Any]]) -> None:
    """OptionError: a format has no such columns, or has one of that name itself, or not the type."""
    error, (extras, _names) = ffi.new("lum_error *"), _extras({name: file_type(kind, dtype) for name, dtype in own.items()})
    asked = ffi.NULL if columns is None else ffi.new("char[]", ",".join(columns).encode())
    check(lib.lum_writer_check_extra(FORMATS[kind], asked, extras, len(own), error), error, OptionError)


OF_MESSAGES = ("x", "y", "z", "pulse_width", "return_number")
"""The columns of frames, beside time, that messages have."""


class Messages(NamedTuple):
    """What is said of an MCAP file besides its frames."""

    is_in_world: bool
    """Whether points are in the poses' fixed frame, and not in that of the sensor."""
    calibration: Any
    """A lum_calibration, whose mounts are written; None: none are."""
    calibration_yaml: str
    profile_yaml: str


def _mcap_options(said: Messages) -> tuple[Any, list[Any]]:
    """The options of the library, and what has to live as long."""
    kept = [ffi.new("char[]", one.encode()) for one in ("map", said.calibration_yaml, said.profile_yaml)]
    mounts = said.calibration is not None and not said.is_in_world
    return sized("lum_mcap_options", frame_id=kept[0] if said.is_in_world else ffi.NULL, calibration_yaml=kept[1],
                 profile_yaml=kept[2], calibration=said.calibration if mounts else ffi.NULL), kept


class PointsFile:
    """A file that the library writes. It has its name after finish(); until then nothing of it is seen."""

    def __init__(self, name: str, kind: str, comment: str, columns: Optional[tuple[str, ...]], is_ascii: bool,
                 time: str, own: Mapping[str, np.dtype[Any]], messages: Messages) -> None:
        """Begin.

        Args:
            name: of the file.
            kind: one of FORMATS.
            comment: where the points come from; empty: the file does not say it.
            columns: of csv, ply and pcd; None: those of the format.
            is_ascii: ply, pcd: text.
            time: what timestamps are: "sensor", "utc" or "arrival".
            own: the columns of one's own that it has, and their types.
            messages: what is said of mcap.
        """
        self._error = ffi.new("lum_error *")
        self._has_frames = kind == "mcap"
        self._time = "utc" if self._has_frames and time == "sensor" else time
        self._has_time = self._has_frames or columns is not None and "time" in columns
        self._chosen = ", or choose other columns by columns=" if kind in ("csv", "ply", "pcd") else ""
        self._has_lines = kind != "xyz" and (columns is None or not {"line", "eye", "timestamp"}.isdisjoint(columns))
        self._own = {name: file_type(kind, dtype) for name, dtype in own.items()}
        self._names = ("x", "y", "z") if kind == "xyz" else OF_MESSAGES if kind == "mcap" else tuple(
            c for c in _OF_SAMPLE if columns is None or c in columns or c in "xyz" and kind == "las")
        kept = [ffi.new("char[]", comment.encode())] if comment else []
        if columns is not None:
            kept.append(ffi.new("char[]", ",".join(columns).encode()))
        options = sized("lum_writer_options", format=FORMATS[kind], ascii=is_ascii, utc=time != "sensor")
        options.comment = kept[0] if comment else ffi.NULL
        options.columns = kept[-1] if columns is not None else ffi.NULL
        check_own(kind, columns, own)
        mcap, _texts = _mcap_options(messages)
        options.mcap = mcap if self._has_frames else ffi.NULL
        extras, _names = _extras(self._own)
        options.extra, options.extra_count = extras, len(own)
        out = ffi.new("lum_writer **")
        check(lib.lum_writer_open(os.fsencode(name), options, out, self._error), self._error, TargetError)
        self._writer: Any = out[0]

    def add(self, frame: Frame) -> None:
        """Append the points of a frame, line by line."""
        if self._has_lines and len(frame) and not len(frame.lines):
            raise OptionError(f"frame {frame.number} has no lines, which the file's columns line, eye and timestamp need: give "
                              f"Frame.from_arrays() the columns line and eye, or lines={self._chosen}")
        samples = self._samples(frame)
        base = ffi.cast("char *", ffi.from_buffer(samples)) if len(samples) else ffi.NULL
        times = value(frame, "time") if self._has_time else None
        at = ffi.cast("char *", ffi.from_buffer(np.ascontiguousarray(times))) if times is not None and len(times) else None
        own = [ffi.from_buffer(_as_written(frame, name, dtype)) for name, dtype in self._own.items()]
        sizes, extra = [dtype.itemsize for dtype in self._own.values()], ffi.new("void *[]", len(own))
        line = sized("lum_line_samples", frame=frame.number, extra=extra)
        begin_ns = frame.info["begin_arrival_ns"] if self._time == "arrival" else frame.utc_ns
        check(lib.lum_writer_begin_frame(self._writer, begin_ns, self._error), self._error, TargetError)
        for first, count, stamp, number, eye in self._lines(frame):
            line.samples = ffi.cast("lum_sample *", base + first * _SAMPLE.itemsize)
            line.count, line.timestamp_us, line.line, line.eye = count, stamp, number, eye
            line.times = ffi.NULL if at is None else ffi.cast("float *", at + 4 * first)
            for i, array in enumerate(own):
                extra[i] = ffi.cast("char *", array) + sizes[i] * first
            check(lib.lum_writer_add(self._writer, line, self._error), self._error, TargetError)
        check(lib.lum_writer_end_frame(self._writer, self._error), self._error, TargetError)

    def _lines(self, frame: Frame) -> Iterator[tuple[int, int, int, int, int]]:
        """Of each line with points the first, how many, its timestamp, number and eye."""
        if len(frame) and not len(frame.lines):
            yield 0, len(frame), 0, 0, 0
            return
        has_clock = not self._has_frames or frame.info["begin_utc_ns"]
        stamps = value(frame, "timestamp", self._time if has_clock else "arrival")
        for number, eye, first, count, *_ in frame.lines.tolist():
            if count:
                yield first, count, int(stamps[first]), number, eye

    def _samples(self, frame: Frame) -> Array:
        out = np.zeros(len(frame), _SAMPLE)
        for name in self._names:
            out[name] = value(frame, name)
        return out

    def finish(self) -> None:
        """Complete it, and give it its name."""
        writer, self._writer = self._writer, None
        check(lib.lum_writer_close(writer, self._error), self._error, TargetError)

    def discard(self) -> None:
        """Remove what was written. Nothing happens after finish()."""
        if self._writer is not None:
            lib.lum_writer_abort(self._writer)
        self._writer = None
