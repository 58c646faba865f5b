"""The lines of a frame: those of the library's frames, those that columns tell, those of some of the points."""
from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._c import ffi, lib
from ._columns import struct_dtype
from ._errors import OptionError

if TYPE_CHECKING:
    Array = np.ndarray[Any, np.dtype[Any]]

LINE_DTYPE = np.dtype([("number", "u4"), ("eye", "u1"), ("first_point", "u4"), ("point_count", "u4"),
                       ("angle_count", "u2"), ("lost_words", "u4"), ("clock_us", "i8"), ("arrival_ns", "i8")])
"""The fields of Frame.lines."""


_C_LINES = struct_dtype("lum_frame_line")


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


def of_columns(line: Array, eye: Array, clocks_us: Array, sensor: Optional[Array] = None) -> Array:
    """Those of points that stand line by line: each begins where the number of the line, the eye, or the sensor is another one."""
    sensor = np.zeros(len(line), "u1") if sensor is None else sensor
    changes = (line[1:] != line[:-1]) | (eye[1:] != eye[:-1]) | (sensor[1:] != sensor[:-1])
    starts = np.flatnonzero(np.r_[True, changes]) if len(line) else np.zeros(0, "i8")
    out = np.zeros(len(starts), LINE_DTYPE)
    out["number"], out["eye"], out["first_point"] = line[starts], eye[starts], starts
    out["point_count"] = np.diff(starts, append=len(line))
    out["angle_count"], out["clock_us"] = lib.LUM_LINE_PIXELS, clocks_us[starts]
    each = np.stack([sensor[starts].astype("i8"), out["eye"], out["number"]])
    _, first, which = np.unique(each, axis=1, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[which.ravel()] != np.arange(len(out)))
    if len(again):
        one, other = out[first[which.ravel()[again[0]]]], out[again[0]]
        raise OptionError(f"line: points {one['first_point']} and {other['first_point']} are of line {one['number']}, but points "
                          "between them are not; order points line by line, as numpy.lexsort((line, eye)) does, or give lines=")
    return out


def check(lines: Array, count: int) -> None:
    """OptionError: lines do not follow each other, or are not those of so many points."""
    ends = np.cumsum(lines["point_count"], dtype="i8")
    wrong = np.flatnonzero(lines["first_point"] != ends - lines["point_count"])
    if len(wrong):
        i = wrong[0]
        raise OptionError(f"lines: line {i} begins at point {lines['first_point'][i]}; use "
                          f"{ends[i] - lines['point_count'][i]}, the end of the lines before")
    if (ends[-1] if len(ends) else 0) != count:
        raise OptionError(f"lines: they have {ends[-1] if len(ends) else 0} points; use {count}, those of the columns")


def renumber(lines: Array, columns: Mapping[str, Array]) -> Array:
    """Lines with the numbers and eyes that the columns of their points say.

    Raises:
        OptionError: points of one line have several.
    """
    out = lines
    for name, field in ("line", "number"), ("eye", "eye"):
        if name not in columns:
            continue
        column, has = columns[name], lines["point_count"] > 0
        told = lines[field].astype(column.dtype)
        told[has] = column[lines["first_point"][has]]
        wrong = np.flatnonzero(np.repeat(told, lines["point_count"]) != column)
        if len(wrong):
            first = lines["first_point"][np.searchsorted(lines["first_point"], wrong[0], "right") - 1]
            raise OptionError(f"{name}: points {first} and {wrong[0]} are of one line of the frame, and have {column[first]} and "
                              f"{column[wrong[0]]}; use one number for all points of a line; Frame.from_arrays() makes "
                              "other lines")
        if not np.array_equal(told, out[field]):
            out = out.copy()
            out[field] = told
    return out


def cut(lines: Array, before: Callable[[Array], Array]) -> Array:
    """Lines of which some points stay; before() says how many of the first i points do."""
    out, first = lines.copy(), lines["first_point"].astype("i8")
    out["first_point"] = before(first)
    out["point_count"] = before(first + lines["point_count"]) - out["first_point"]
    return out
