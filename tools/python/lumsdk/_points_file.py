"""Frames into the formats of the library's writer of clouds: csv, ply, pcd, las and xyz."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._c import check, ffi, lib, sized
from ._errors import OptionError
from ._table import Array, places, value
from ._target import TargetError

if TYPE_CHECKING:
    from ._frame import Frame

FORMATS = {"csv": lib.LUM_FORMAT_CSV, "ply": lib.LUM_FORMAT_PLY, "pcd": lib.LUM_FORMAT_PCD, "las": lib.LUM_FORMAT_LAS,
           "xyz": lib.LUM_FORMAT_XYZ}
"""The formats, by name."""

_OF_SAMPLE = ("x", "y", "z", "range", "azimuth", "elevation", "pulse_width", "pixel", "return_number",
              "number_of_returns", "edge")
_TYPES = {"float": "f4", "uint16_t": "u2", "uint8_t": "u1"}


def _sample_dtype() -> np.dtype[Any]:
    fields = dict(ffi.typeof("lum_sample").fields)
    return np.dtype({"names": list(fields), "formats": [_TYPES[f.type.cname] for f in fields.values()],
                     "offsets": [f.offset for f in fields.values()], "itemsize": ffi.sizeof("lum_sample")})


_SAMPLE = _sample_dtype()


class PointsFile:
    """A file that the library writes. It has its name after finish(); until then nothing of it is seen."""

    def __init__(self, name: str, kind: str, comment: str, columns: Optional[tuple[str, ...]], is_ascii: bool,
                 time: str, has_sensor: bool = False) -> None:
        """Begin.

        Args:
            name: of the file.
            kind: one of FORMATS.
            comment: where the points come from; empty: the file does not say it.
            columns: of csv, ply and pcd; None: those of the format.
            is_ascii: ply, pcd: text.
            time: what timestamps are: "sensor", "utc" or "arrival".
            has_sensor: a column "sensor" has the places in the rig.
        """
        self._error = ffi.new("lum_error *")
        self._time = time
        self._has_time = columns is not None and "time" in columns
        self._names = ("x", "y", "z") if kind == "xyz" else tuple(
            c for c in _OF_SAMPLE if columns is None or c in columns or c in "xyz" and kind == "las")
        kept = [ffi.new("char[]", comment.encode())] if comment else []
        if columns is not None:
            kept.append(ffi.new("char[]", ",".join(columns).encode()))
        options = sized("lum_writer_options", format=FORMATS[kind], ascii=is_ascii, utc=time != "sensor")
        options.comment = kept[0] if comment else ffi.NULL
        options.columns = kept[-1] if columns is not None else ffi.NULL
        self._has_sensor = has_sensor
        if has_sensor:
            kept += [ffi.new("char[]", b"sensor")]
            kept += [ffi.new("lum_writer_extra []", [{"name": kept[-1], "type": lib.LUM_NUMBER_U8}])]
            options.extra, options.extra_count = kept[-1], 1
        if columns is not None:
            given = (options.columns,) if not has_sensor else (options.format, options.columns, options.extra, 1)
            checks = lib.lum_writer_check_extra if has_sensor else lib.lum_writer_check_columns
            check(checks(*given, self._error), self._error, OptionError)
        out = ffi.new("lum_writer **")
        check(lib.lum_writer_open(os.fsencode(name), options, out, self._error), self._error, TargetError)
        self._writer: Any = out[0]

    def add(self, frame: Frame) -> None:
        """Append the points of a frame, line by line."""
        samples = self._samples(frame)
        base = ffi.cast("char *", ffi.from_buffer(samples)) if len(samples) else ffi.NULL
        times = value(frame, "time") if self._has_time else None
        at = ffi.cast("char *", ffi.from_buffer(np.ascontiguousarray(times))) if times is not None and len(times) else None
        stamps = value(frame, "timestamp", self._time)
        line = sized("lum_line_samples", frame=frame.number)
        sensors = ffi.from_buffer("uint8_t[]", np.ascontiguousarray(places(frame))) if self._has_sensor and len(frame) else None
        extra = ffi.new("const void *[1]")
        found: Any
        for found in frame.lines:
            first, count = int(found["first_point"]), int(found["point_count"])
            if not count:
                continue
            line.samples = ffi.cast("lum_sample *", base + first * _SAMPLE.itemsize)
            line.count, line.timestamp_us = count, int(stamps[first])
            line.line, line.eye = int(found["number"]), int(found["eye"])
            if sensors is not None:
                extra[0], line.extra = sensors + first, extra
            line.times = ffi.NULL if at is None else ffi.cast("float *", at + 4 * first)
            check(lib.lum_writer_add(self._writer, line, self._error), self._error, TargetError)

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
