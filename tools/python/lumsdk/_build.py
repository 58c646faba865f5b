"""Frames of arrays: those that a program makes, some points of a frame, frames with other columns, what was pickled."""
from __future__ import annotations

import difflib
import ipaddress
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from . import _lines
from ._c import address_of, lib
from ._errors import OptionError, UnknownKeyError, warn
from ._columns import COLUMNS
from ._frame import Frame
from ._grid import EYES, PIXELS
from ._info import LOSSES, Info
from ._lines import LINE_DTYPE
from ._raw import RAW_COLUMNS, WRITTEN

if TYPE_CHECKING:
    from ._raw import Raw
    from ._types import Array

KNOWN: Mapping[str, np.dtype[Any]] = {**COLUMNS, **RAW_COLUMNS}
"""Columns that are not a program's own, and their types."""

_MOST = {"pixel": PIXELS - 1, "eye": 1, "edge": 1, "strongest": 1}
"""The greatest value of columns whose type could hold more."""

_TIME_MOST = 1e6
"""Seconds."""

_UTC_FROM_US = 10 ** 15
"""Microseconds of UTC since 2001; no sensor runs for 31 years."""

_OF_TABLES = ("timestamp", "frame", "sensor")
_RESERVED = (*_OF_TABLES, "xyz", "columns", "lines", "number", "utc_ns", "utc_error_ns", "clock_us")
"""Names that a column of one's own cannot have: tables make columns of them, and from_arrays() has arguments of them."""


def assemble(info: Info, columns: Mapping[str, Array], lines: Array, moved: str, xyz: Optional[Array] = None,
             raw: Optional[Raw] = None) -> Frame:
    """A frame of these arrays, which are kept; x, y and z are then those of xyz if that is given."""
    frame = Frame.__new__(Frame)
    frame._c, frame._members, frame._count = None, None, len(next(iter(columns.values()))) if columns else 0
    frame._info_made, frame._lines_made, frame._moved, frame._raw = info, lines, moved, raw
    frame._own = tuple(name for name in columns if name not in KNOWN)
    frame._arrays, frame._block = dict(columns), xyz
    if xyz is not None:
        frame._arrays.update(zip("xyz", xyz.T))
    return frame


def restore(info: Mapping[str, Any], arrays: Mapping[str, Array], lines: Array, moved: str = "",
            raw: Optional[Raw] = None) -> Frame:
    """A frame that was pickled."""
    xyz = np.array([arrays[name] for name in "xyz"], "f4").T if all(name in arrays for name in "xyz") else None
    return assemble(Info(**info), arrays, lines, moved, xyz, raw)


# --- Arrays as columns ---


def _numbers(name: str, given: Any, shape: str = "(n,)") -> Array:
    """An array of numbers, without a copy where it is one already."""
    array: Array = np.asarray(given)
    if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8:
        raise TypeError(f"{name}: values of type {array.dtype}; use bool, integers, or floats of up to 64 bits")
    if np.ma.is_masked(given):
        raise TypeError(f"{name}: a masked array; use one without a mask, such as {name}.filled(0)")
    if array.ndim != (1 if shape == "(n,)" else 2) or array.ndim == 2 and array.shape[1] != 3:
        raise OptionError(f"{name}: an array of the shape {array.shape}; use {shape}, n the number of points")
    return array if array.dtype.isnative else array.astype(array.dtype.newbyteorder("="))


def _fitted(name: str, array: Array, dtype: np.dtype[Any]) -> Array:
    """Numbers as this type, which has to hold each of them exactly; not copied if they are of that type."""
    if array.dtype == dtype:
        return array
    with np.errstate(all="ignore"):
        made: Array = array.astype(dtype)
        if np.can_cast(array.dtype, dtype, "safe"):
            return made
        differs = (made.astype(array.dtype) != array) | ((made < 0) != (array < 0))
    if dtype.kind == array.dtype.kind == "f":
        differs &= ~np.isnan(array)
    if differs.any():
        at = np.flatnonzero(differs.ravel())[0]
        right = (f'{name}.astype("{dtype}"), which rounds' if dtype.kind == "f" else
                 f"whole numbers from {np.iinfo(dtype).min} to {np.iinfo(dtype).max}")
        raise OptionError(f"{name}: {array.ravel()[at]} at {at} cannot be a number of type {dtype}; use {right}")
    return made


def _known(given: Mapping[str, Any]) -> tuple[dict[str, Array], Optional[Array]]:
    """The columns that every frame can have, in their types; and x, y and z, if they come as one array."""
    columns = {name: _fitted(name, _numbers(name, given[name]), dtype) for name, dtype in KNOWN.items() if name in given}
    for name in _MOST.keys() & columns.keys():
        above = np.flatnonzero(columns[name] > _MOST[name])
        if len(above):
            raise OptionError(f"{name}: {columns[name][above[0]]} at {above[0]}; use 0 to {_MOST[name]}")
    if "xyz" not in given:
        return columns, None
    both = [name for name in "xyz" if name in columns]
    if both:
        raise OptionError(f"xyz and {', '.join(both)} are given; use xyz, or x, y and z")
    xyz = _fitted("xyz", _numbers("xyz", given["xyz"], "(n, 3)"), np.dtype("f4"))
    return {**columns, **dict(zip("xyz", xyz.T))}, xyz


def _check_name(name: Any) -> None:
    if not isinstance(name, str) or not (name.isascii() and name.isidentifier()) or len(name) > lib.LUM_WRITER_EXTRA_NAME_MAX:
        raise OptionError(f"{name!r} cannot be the name of a column; use at most {lib.LUM_WRITER_EXTRA_NAME_MAX} "
                          "ASCII letters, digits and _, not a digit first")
    if name in KNOWN or name == "xyz":
        raise OptionError(f"{name} is a column that frames have by themselves: replace({name}=...) sets it; columns of your own "
                          "need other names")
    if name in _OF_TABLES:
        raise OptionError(f"{name} is a column that tables and files make of the frame; leave it out, or give a column of your own "
                          "another name")
    if name in _RESERVED:
        raise OptionError(f"{name} is an argument of Frame.from_arrays(); a column of your own needs another name")


def _check_lengths(columns: Mapping[str, Array], count: int, of: str) -> None:
    for name, array in columns.items():
        if len(array) != count:
            raise OptionError(f"{name} has {len(array)} values; use {count}, one a point, as {of}")


def _collect(columns: Any, more: Mapping[str, Any]) -> dict[str, Any]:
    """What was given as a mapping, as a structured array or by keywords."""
    if isinstance(columns, np.ndarray) and columns.dtype.names is not None:
        columns = {name: columns[name] for name in columns.dtype.names}
    of_arrow = getattr(columns, "column_names", None)
    if of_arrow is not None:
        columns = {name: columns[name] for name in of_arrow}
    if columns is None:
        columns = {}
    if not isinstance(columns, Mapping) and not hasattr(columns, "keys"):
        raise TypeError(f"columns are given as {type(columns).__name__}; use a mapping of names and arrays, a structured "
                        "array, or keywords: x=...")
    given = {name: columns[name] for name in list(columns)}
    twice = [name for name in given if name in more]
    if twice:
        raise OptionError(f"{twice[0]} is given twice; give it once")
    return {**given, **more}


# --- From arrays ---


def _one(name: str, array: Array) -> Optional[int]:
    """The number that all points have; None: there are no points."""
    found = np.unique(array)
    if len(found) > 1:
        raise OptionError(f"{name}: points of {found[0]} and of {found[1]}; use those of one {name}, such as "
                          f'rows[rows["{name}"] == {found[0]}]')
    return int(found[0]) if len(found) else None


class _OfFile(NamedTuple):
    """What columns of files say that are not of points."""

    number: Optional[int] = None
    sensor: Optional[str] = None
    clocks_us: Optional[Array] = None

    @classmethod
    def take(cls, given: dict[str, Any]) -> tuple[_OfFile, dict[str, Array]]:
        """What they say, and the columns, which are taken out."""
        metadata = np.asarray(given.get("metadata", 0))
        if metadata.ndim == 0 and metadata.dtype.kind == "U":  # the text of an npz
            del given["metadata"]
        found = {name: _fitted(name, _numbers(name, given.pop(name)), np.dtype("i8")) for name in _OF_TABLES if name in given}
        number = _one("frame", found["frame"]) if "frame" in found else None
        sensor = None
        if "sensor" in found and len(found["sensor"]) and (found["sensor"] < lib.LUM_RIG_SENSORS_MAX).all():
            warn("sensor: places in a rig are left out, since a frame of arrays has no rig: give the column another name to keep them")
        elif "sensor" in found:
            address = _one("sensor", found["sensor"])
            sensor = None if address is None else address_of(address)
        return cls(number, sensor, found.get("timestamp")), found


def _own_of(given: Mapping[str, Any]) -> dict[str, Array]:
    """The columns of one's own among all of a frame."""
    own = {name: array for name, array in given.items() if name not in KNOWN and name != "xyz"}
    for name in own:
        _check_name(name)
        near = difflib.get_close_matches(name.lower(), KNOWN, 1, 0.8)
        if near and len(name) <= len(near[0]):
            raise OptionError(f"there is no column {name}; is it {near[0]}? with_columns() adds a column "
                              "of your own with this name")
    return {name: _numbers(name, array) for name, array in own.items()}


def _given_lines(given: Any, columns: Mapping[str, Array], count: int) -> Array:
    lines = np.asarray(given)
    names = lines.dtype.names or ()
    needs = ("number", "eye", "first_point", "point_count")
    if lines.ndim != 1 or not set(needs) <= set(names) <= set(LINE_DTYPE.names or ()):
        raise OptionError(f"lines: an array of type {lines.dtype}; use a structured array such as Frame.lines, with the fields "
                          f"{', '.join(needs)}, and of the others those that are known: {', '.join((LINE_DTYPE.names or ())[4:])}")
    if lines.dtype != LINE_DTYPE:
        made = np.zeros(len(lines), LINE_DTYPE)
        made["angle_count"] = PIXELS
        for name in names:
            made[name] = _fitted(f"lines: {name}", lines[name], LINE_DTYPE[name])
        lines = made
    if (lines["eye"] > 1).any():
        raise OptionError("lines: eye is above 1; use 0 for blue, 1 for green")
    _lines.check(lines, count)
    if _lines.renumber(lines, columns) is not lines:
        raise OptionError("lines: the columns line and eye differ from the lines; use the same, or lines alone")
    return lines


def _line_info(lines: Array) -> tuple[tuple[int, int], tuple[int, int]]:
    """How many lines each eye has, and how many rows they make."""
    of = [lines[lines["eye"] == eye] for eye in range(len(EYES))]
    rows = [min(int((one["number"][one["point_count"] > 0] + np.int64(1)).max(initial=0)), lib.LUM_FRAME_ROWS_MAX) for one in of]
    return (len(of[0]), len(of[1])), (rows[0], rows[1])


def _address(sensor: Any) -> tuple[int, str]:
    address, _, interface = str(sensor).partition("%")
    try:
        return int(ipaddress.IPv4Address(address)), interface
    except ValueError:
        raise OptionError(f'sensor is {sensor!r}; use its address, such as "10.42.0.37"') from None


def _whole(name: str, value: Any, most: int = 2 ** 62) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value <= most:
        raise OptionError(f"{name} is {value!r}; use a whole number from 0 to {most}")
    return int(value)


def _clocks_us(columns: Mapping[str, Array], count: int, begin_us: int) -> Array:
    """The sensor's clock at each point; that of the frame's begin where the time is not known."""
    seconds = np.nan_to_num(columns["time"].astype("f8"), posinf=0, neginf=0) if "time" in columns else np.zeros(count)
    wrong = np.flatnonzero(np.abs(seconds) > _TIME_MOST)
    if len(wrong):
        raise OptionError(f"time: {seconds[wrong[0]]:g} at {wrong[0]}; use seconds since the frame began, up to {_TIME_MOST:g}")
    return np.asarray(begin_us + np.rint(seconds * 1e6).astype("i8"))


def _begin_us(columns: Mapping[str, Array], stamps: Array) -> int:
    """The clock at the frame's begin, from the clocks of the lines of points.

    The time of a point counts from there to the line's clock, and grows along the line by as much a pixel in the whole frame.
    """
    first = _whole("timestamp", int(stamps.min()))
    if "time" not in columns:
        return first
    starts = np.flatnonzero(np.r_[True, stamps[1:] != stamps[:-1]])
    at = np.union1d(starts, np.r_[starts[1:], len(stamps)] - 1)  # both ends of each line
    at = at[np.isfinite(columns["time"][at])]
    if not len(at):
        return first
    before = stamps[at] - first - columns["time"][at].astype("f8") * 1e6
    pixel = columns["pixel"][at].astype("f8") if "pixel" in columns else np.zeros(len(at))
    begin = before.max() if pixel.min() == pixel.max() else np.polyfit(pixel, before, 1)[1]
    return max(0, first + int(np.rint(begin)))


def from_arrays(given: Any, more: Mapping[str, Any], lines: Any, number: Optional[int], sensor: Optional[str], utc_ns: int,
                utc_error_ns: Optional[int], clock_us: Optional[int]) -> Frame:
    """As Frame.from_arrays() has it."""
    given = _collect(given, more)
    told, beside = _OfFile.take(given)
    known, xyz = _known(given)
    columns = {**known, **_own_of(given)}
    if not columns:
        raise OptionError("a frame of no columns; use at least one, such as x=...")
    first, count = next((name, len(array)) for name, array in columns.items())
    _check_lengths({**columns, **beside}, count, f"{first} has them")
    given_lines = None if lines is None else _given_lines(lines, columns, count)
    begin_us = _whole("clock_us", 0 if clock_us is None else clock_us)
    if clock_us is None and given_lines is not None and len(given_lines):
        begin_us = int(given_lines["clock_us"].min())
    stamps = told.clocks_us if clock_us is None and lines is None and count else None
    if stamps is not None:
        begin_us = _begin_us(columns, stamps)
        utc_ns = utc_ns or (begin_us * 1000 if begin_us >= _UTC_FROM_US else 0)
    clocks_us = _clocks_us(columns, count, begin_us)
    if given_lines is not None:
        lines = given_lines
    elif "line" in columns and "eye" in columns:
        lines = _lines.of_columns(columns["line"], columns["eye"], clocks_us if stamps is None else stamps, beside.get("sensor"))
    else:
        lines = np.zeros(0, LINE_DTYPE)
    address, interface = _address(sensor if sensor is not None else told.sensor or "0.0.0.0")
    arrivals, (of, rows) = lines["arrival_ns"], _line_info(lines)
    number = _whole("number", number if number is not None else told.number or 0, 2 ** 31 - 1)
    info = Info(number=number, sensor=address, interface=interface, is_complete=True, is_first=False, is_last=False,
                 begin_clock_us=begin_us, end_clock_us=int(np.r_[begin_us, lines["clock_us"], clocks_us].max()),
                 begin_arrival_ns=int(arrivals.min()) if len(lines) else 0, end_arrival_ns=int(arrivals.max()) if len(lines) else 0,
                 begin_utc_ns=_whole("utc_ns", utc_ns),
                 utc_error_ns=lib.LUM_CLOCK_ERROR_UNKNOWN if utc_error_ns is None else _whole("utc_error_ns", utc_error_ns),
                 has_pause=False, losses=dict.fromkeys(LOSSES, 0), lines=of, rows=rows)
    return assemble(info, columns, lines, "", xyz)


# --- Of another frame ---


def _indices(key: Any, count: int) -> Array:
    """The places that a mask or an array of places stands for."""
    found = np.asarray(key)
    if found.dtype.kind not in "biu" and found.size or found.ndim == 0:
        raise TypeError(f"frame[...] takes a column's name, a mask, a slice, or an array of places, not {type(key).__name__}"
                        + (f" of type {found.dtype}" if found.ndim else "")
                        + ("; frame[i:i + 1] is the frame of one point" if found.dtype.kind in "iu" else ""))
    if np.ma.is_masked(key):
        raise TypeError("frame[...]: a masked array; use one without a mask, such as .filled(False)")
    if found.dtype.kind == "b":
        if found.shape != (count,):
            raise OptionError(f"frame[mask]: a mask of the shape {found.shape}; use ({count},), one a point of the frame")
        return np.flatnonzero(found)
    if found.ndim != 1:
        raise OptionError(f"frame[places]: an array of the shape {found.shape}; use one of one dimension")
    if len(found) == count > 2 and not (found > 1).any() and (found >= 0).all():
        raise OptionError(f"frame[mask]: as many values as points, all 0 or 1, of type {found.dtype}; use a mask of bool: "
                          "frame[mask.astype(bool)]")
    if len(found) and not 0 <= found.min() <= found.max() < count:
        wrong = found[(found < 0) | (found >= count)][0]
        raise OptionError(f"frame[places]: {wrong} is no point of the frame; use 0 to {count - 1}"
                          + ("; -1 in an image_index() is a pixel without a point" if wrong == -1 else ""))
    found = found.astype(np.intp)
    if (found[1:] < found[:-1]).any():
        raise OptionError("frame[places]: they descend, but points of a frame stay in the order of its lines; use "
                          'frame[numpy.sort(places)], or in any order frame["x"][places]')
    return found


def _part(frame: Frame, key: slice) -> tuple[dict[str, Array], Optional[Array], Callable[[Array], Array]]:
    start, stop, step = key.indices(len(frame))
    if step < 0:
        raise OptionError('frame[a:b:step]: the step is below 0, but points of a frame stay in the order of its lines; use a '
                          'step from 1, or frame["x"][::-1]')
    block = frame._joined()

    def before(places: Array) -> Array:
        return np.asarray((np.clip(places, start, max(start, stop)) - start + step - 1) // step)

    return {name: frame[name][key] for name in frame.columns}, None if block is None else block[key], before


def _taken(frame: Frame, key: Any) -> tuple[dict[str, Array], Optional[Array], Callable[[Array], Array]]:
    places = _indices(key, len(frame))
    has_xyz = all(name in frame for name in "xyz")
    columns = {str(name): frame[name].take(places) for name in frame.columns if not has_xyz or name not in ("x", "y", "z")}
    block = np.empty((3, len(places)), "f4")
    if has_xyz:
        for row, name in zip(block, "xyz"):
            columns[name] = frame._array(name).take(places, out=row, mode="clip")
    return columns, block.T if has_xyz else None, lambda at: np.searchsorted(places, at)


def select(frame: Frame, key: Any) -> Frame:
    """Some points of a frame: as views for a slice, else a copy."""
    columns, xyz, before = _part(frame, key) if isinstance(key, slice) else _taken(frame, key)
    ordered = {str(name): columns[name] for name in frame.columns}
    return assemble(frame._info, ordered, _lines.cut(frame.lines, before), frame._moved, xyz, frame._raw)


def replace(frame: Frame, given: Any, more: Mapping[str, Any]) -> Frame:
    """As Frame.replace() has it."""
    given = _collect(given, more)
    for name in given:
        if name not in KNOWN and name != "xyz" and name not in frame._own:
            raise UnknownKeyError(f"the frame has no column {name!r} to replace, only {', '.join(frame.columns)}; with_columns() adds "
                                  "one of your own")
    known, xyz = _known(given)
    columns = {**known, **{name: _numbers(name, given[name]) for name in frame._own if name in given}}
    if "sensor" in columns:  # of joined frames: the place in the rig
        columns["sensor"] = _fitted("sensor", columns["sensor"], frame["sensor"].dtype)
    _check_lengths(columns, len(frame), "the frame has them")
    if xyz is None and not {"x", "y", "z"} & set(columns):
        xyz = frame._joined()
    columns = {**frame.to_dict(), **columns}
    lines, info = frame.lines, frame._info
    if {"line", "eye"} & set(known) and len(lines):
        lines = _lines.renumber(lines, known)
        of, rows = _line_info(lines)
        info = info.replace(lines=of, rows=rows)
    raw = frame._raw
    if raw is not None:
        beside = (name for name in given if name not in WRITTEN and name not in frame._own)
        raw = raw._replace(replaced=tuple(dict.fromkeys((*raw.replaced, *beside))))
    return assemble(info, columns, lines, frame._moved, xyz, raw)


def with_columns(frame: Frame, given: Any, more: Mapping[str, Any]) -> Frame:
    """As Frame.with_columns() has it."""
    given = _collect(given, more)
    for name in given:
        _check_name(name)
    own = {name: _numbers(name, array) for name, array in given.items()}
    _check_lengths(own, len(frame), "the frame has them")
    made = Frame.__new__(Frame)
    for slot in Frame.__slots__:
        if slot != "__weakref__":
            setattr(made, slot, getattr(frame, slot))
    made._arrays = {**frame._arrays, **own}
    made._own = tuple(dict.fromkeys((*frame._own, *own)))
    return made
