"""The lines of a frame: those of the library's frames."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._c import ffi, lib

if TYPE_CHECKING:
    Array = np.ndarray[Any, np.dtype[Any]]

LINE_DTYPE = np.dtype([("number", "u4"), ("eye", "u1"), ("first_point", "u4"), ("point_count", "u4"),
                       ("angle_count", "u2"), ("lost_words", "u4"), ("clock_us", "i8"), ("arrival_ns", "i8")])
"""The fields of Frame.lines."""


def _c_lines() -> np.dtype[Any]:
    """The layout of lum_frame_line, which is filled in C."""
    fields = [name for name, _ in ffi.typeof("lum_frame_line").fields]
    types = {"struct_size": np.dtype(f"u{ffi.sizeof('size_t')}")}
    types.update({name: np.dtype(LINE_DTYPE[name]) for name in LINE_DTYPE.names or ()})
    return np.dtype({"names": fields, "formats": [types[name] for name in fields],
                     "offsets": [ffi.offsetof("lum_frame_line", name) for name in fields],
                     "itemsize": ffi.sizeof("lum_frame_line")})


_C_LINES = _c_lines()


def of_library(frame: Any) -> Array:
    """Those of a frame of the library."""
    made = np.zeros(lib.lum_frame_line_count(frame), _C_LINES)
    made["struct_size"] = _C_LINES.itemsize
    if len(made):
        first = ffi.cast("lum_frame_line *", ffi.from_buffer(made))
        get = lib.lum_frame_get_line
        for i in range(len(made)):
            get(frame, i, first + i)
    out = np.empty(len(made), LINE_DTYPE)
    for name in LINE_DTYPE.names or ():
        out[name] = made[name]
    return out
