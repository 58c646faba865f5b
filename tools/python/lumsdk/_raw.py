"""The raw part of frames: every word a row, the angles of all pixels, and the packets of the lines."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np

from ._c import ffi, lib, sized
from ._columns import Memory, struct_dtype
from ._errors import OptionError

if TYPE_CHECKING:
    from ._frame import Frame
    from ._types import Array
    from ._settings import Calibration, Profile

PIXELS = int(lib.LUM_LINE_PIXELS)
MARKS = (PIXELS + 31) // 32

RAW_COLUMNS: dict[str, np.dtype[Any]] = {"tof": np.dtype("i4"), "raw_azimuth": np.dtype("i2"), "raw_elevation": np.dtype("i2"),
                                         "raw_place": np.dtype("u2")}
"""The columns that raw=True adds, and the type of their numbers; raw_place only to frames with words out of the
order of pixels, or with bad ones."""

WRITTEN = (*RAW_COLUMNS, "line", "pixel", "eye", "edge")
"""The columns that packets are made of again."""

NEEDED = ("line", "pixel", "eye", "edge")
"""The columns that a raw frame has whichever are chosen: with tof they are the words."""

PACKET_DTYPE = struct_dtype("lum_raw_packet")
"""The fields of Frame.packets."""


class Origin(NamedTuple):
    """What frames were read with, and from where."""

    source: str
    calibration: Calibration
    profile: Profile
    earlier: tuple[str, ...]
    paths: tuple[str, ...] = ()
    """The files that they are read from, from the root."""


class Raw(NamedTuple):
    """What a frame has beside its columns."""

    angles: Array
    """(lines, 1000, 2) int16: azimuth and elevation; 0 where there are none."""
    marks: Array
    """(lines, 32) uint32: a bit for each pixel that has angles."""
    packets: Array
    origin: Optional[Origin]
    replaced: tuple[str, ...] = ()
    """Columns that were replaced and are not of packets."""

    def has_angles(self) -> Array:
        """(lines, 1000) bool."""
        octets = self.marks.astype("<u4").view("u1")
        return np.unpackbits(octets, axis=1, bitorder="little")[:, :PIXELS].view(bool)


def marks_of(has_angles: Array) -> Array:
    """(lines, 32) uint32 of (lines, 1000) bool."""
    padded = np.zeros((len(has_angles), MARKS * 32), bool)
    padded[:, :PIXELS] = has_angles
    octets = np.packbits(padded, axis=1, bitorder="little")
    return np.ascontiguousarray(octets).view("<u4").astype("u4")


def of(frame: Frame) -> Raw:
    """That of a frame."""
    raw: Optional[Raw] = getattr(frame, "_raw", None)
    if raw is None:
        raise OptionError(f"frame {frame.number} has no raw part: open the capture with raw=True, or give it one by with_raw()")
    return raw


def words_of(tof: Array, edge: Array, pixel: Array) -> Array:
    """Range words of columns that were checked."""
    return np.asarray((tof.astype("i8").astype("u4") << 12) | (edge.astype("u4") << 10) | pixel.astype("u4"))


def _view(owner: Any, pointer: Any, shape: tuple[int, ...], dtype: str) -> Array:
    """Memory of a frame, which stays as long as the array."""
    if 0 in shape:
        return np.zeros(shape, dtype)
    return np.asarray(Memory(owner, int(ffi.cast("uintptr_t", pointer)), shape, None, np.dtype(dtype)))


def _gives_point(raw: Any, base: Frame, first: Array) -> Array:
    """For each word whether it has a point in the frame; points beyond the most of a frame are none."""
    gives = _view(base._c, raw.gives_point, (int(first[-1]),), "u1").astype(bool)
    if gives.sum() != len(base):
        before = np.cumsum(gives) - gives
        for i, line in enumerate(base.lines):
            part = slice(int(first[i]), int(first[i + 1]))
            if part.start < part.stop:
                gives[part] &= before[part] - before[part.start] < line["point_count"]
    return gives


def frame_of(base: Frame, origin: Origin) -> Frame:
    """A frame of the library as one with a raw part: every word of it is a row."""
    from ._build import restore


    raw = sized("lum_frame_raw")
    lib.lum_frame_get_raw(base._c, raw)
    owner, count = base._c, int(raw.line_count)
    first = _view(owner, raw.first_word, (count + 1,), "u8")
    angles = np.array(_view(owner, raw.angles, (count, PIXELS, 2), "i2"))  # a copy: a view would keep all of the library's frame
    marks = np.array(_view(owner, raw.angle_marks, (count, MARKS), "u4"))
    packets = np.array(_view(owner, raw.packets, (raw.packet_count * PACKET_DTYPE.itemsize,), "u1")).view(PACKET_DTYPE)
    words = _view(owner, raw.words, (int(first[-1]),), "u4")
    gives, which = _gives_point(raw, base, first), np.repeat(np.arange(count), np.diff(first.astype("i8")))
    columns: dict[str, Array] = {}
    for name in base.columns:
        column = base[name]
        made = np.full(len(words), np.nan if column.dtype.kind == "f" else 0, column.dtype)
        made[gives] = column
        columns[name] = made
    lines = base.lines.copy()
    lines["first_point"], lines["point_count"] = first[:-1], np.diff(first.astype("i8"))
    pixel = (words & lib.LUM_WORD_PIXEL).astype("u2")
    columns.update(line=lines["number"][which], eye=lines["eye"][which], pixel=pixel,
                   edge=(words >> 10 & 1).astype("u1"), tof=words.view("i4") >> 12,
                   raw_azimuth=angles[which, pixel, 0], raw_elevation=angles[which, pixel, 1])
    if raw.places != ffi.NULL:
        columns["raw_place"] = np.array(_view(owner, raw.places, (len(words),), "u2"))
    made_frame = restore(vars(base._info), columns, lines)
    made_frame._raw = Raw(angles, marks, packets, origin)
    return made_frame


def packets_of(packets: Any, where: str = "") -> Array:
    """A table of packets, in a copy; None: an empty one."""
    table = np.zeros(0, PACKET_DTYPE) if packets is None else np.asarray(packets)
    if table.dtype.names != PACKET_DTYPE.names or table.ndim != 1:
        raise OptionError(f"{where}packets has the fields {', '.join(table.dtype.names or ()) or 'of no structured array'}; use "
                          f"{', '.join(PACKET_DTYPE.names or ())}, as of frame.packets, a row a packet")
    return np.array(table, PACKET_DTYPE)


def attach(frame: Frame, angles: Any, has_angles: Any, packets: Any, profile: Any) -> Raw:
    """A raw part of arrays, for a frame with so many lines."""
    from ._settings import Calibration, Profile

    count = len(frame.lines)
    marks = np.ones((count, PIXELS), bool) if has_angles is None else np.asarray(has_angles)
    table = packets_of(packets)
    given = whole(angles, "angles", -32768, 32767)
    if given.shape != (count, PIXELS, 2):
        raise OptionError(f"angles has the shape {given.shape}; use {(count, PIXELS, 2)}: raw azimuth and elevation of each "
                          "pixel of each line")
    if marks.shape != (count, PIXELS) or marks.dtype != bool:
        raise OptionError(f"has_angles has the shape {marks.shape} and the type {marks.dtype}; use {(count, PIXELS)} bool")
    if len(table) and (table["line"] >= count).any():
        raise OptionError(f"packets: line is {table['line'].max()}; use a place in frame.lines, below {count}")
    kept: Optional[Raw] = getattr(frame, "_raw", None)
    origin = None if kept is None else kept.origin
    if profile is not None:
        paths = () if origin is None else origin.paths
        origin = Origin("", Calibration() if origin is None else origin.calibration, Profile(profile), (), paths)
    return Raw(np.ascontiguousarray(given, "i2"), marks_of(marks), table, origin, replaced=() if kept is None else kept.replaced)


def whole(values: Any, name: str, low: int, high: int, where: str = "") -> Array:
    """Whole numbers in a range.

    Raises:
        OptionError: there are others.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "iub":
        if array.dtype.kind != "f" or not np.array_equal(array, np.trunc(array)):
            raise OptionError(f"{where}{name} has the type {array.dtype}, or values that are not whole; use whole numbers from "
                              f"{low} to {high}")
        array = array.astype("i8")
    wrong = (array < low) | (array > high)
    if wrong.any():
        raise OptionError(f"{where}{name} is {array[wrong][0]}; use a whole number from {low} to {high}")
    return array
