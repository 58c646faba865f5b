"""Packets again: frames and lines into a capture."""
from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np

from . import _lines, _raw
from ._c import VERSION, address_of, check, ffi, lib, sized
from ._errors import OptionError, warn
from ._grid import EYES, JOINED
from ._inputs import check_storage
from ._options import parse_sensor
from ._settings import Calibration, Profile
from ._target import TargetError, check_not_read, is_url, local_for

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ._frame import Frame
    from ._types import Array

_FORMATS = {".pcap": lib.LUM_CAPTURE_PCAP, ".pcapng": lib.LUM_CAPTURE_PCAPNG}
_PLACE = (0, 2 ** 16 - 1)
_TOF = (-int(lib.LUM_TOF_MAX) - 1, int(lib.LUM_TOF_MAX))
_COLUMNS = ("tof", "pixel", "edge", "line", "eye")
_LINES_TOGETHER = 2048  # of lines without a frame, whose packets are put in order together
_NO_SENSOR = "0.0.0.0"  # of frames that from_arrays() was not told one of
_DROPPED = ("stray", "late", "duplicate", "conflict", "no_room")


class Written(NamedTuple):
    """What write_capture() wrote."""

    packets: int
    """Those that were written twice count twice."""
    lines: int
    frames: int
    repeated: int
    """Packets written twice: the clock jumps there, and a reader believes a jump when a second packet shows it."""
    cut_anew: int
    """Lines that were cut as the sensor does it: their packets are not known, or do not fit any more."""
    dropped: dict[str, int]
    """Packets that a reader will drop, by lumdump's names."""
    clock_jumps: int
    """Steps of the clock by half a round of its field or more: a reader then misses whole rounds."""
    no_range: int
    """Words with a time of flight of 0 or below, which gives no range unless the calibration's tof_offset_ps lifts it."""


@dataclasses.dataclass
class Line:
    """A line as packets bring it: frame.to_lines() gives those of a frame, and write_capture() writes them."""

    number: int
    eye: Union[str, int]
    """"blue" or "green", or 0 or 1."""
    clock_us: int
    """The sensor's clock."""
    angles: Any
    """(1000, 2) int16: raw azimuth and elevation of each pixel."""
    pixel: Any
    """Of each word, rising from word to word."""
    tof: Any
    """Of each word, in the profile's unit of 13 ps: -524288 to 524287."""
    rising: Any
    """Of each word, whether its edge is rising."""
    arrival_ns: int
    """When its first packet came, in ns since 1970."""
    has_angles: Any = None
    """(1000,) bool: which pixels have angles; None: all."""
    packets: Any = None
    """Those that it was made of, as in frame.packets; None: not known."""
    sensor: str = "10.42.0.37"
    origin: Optional[_raw.Origin] = dataclasses.field(default=None, compare=False)
    place: Any = None
    """Of each word, its place in its packets, as in the column raw_place; None: packets have their words ordered by pixel."""

    def __repr__(self) -> str:
        eye = EYES[self.eye] if self.eye in (0, 1) else self.eye
        return f"<Line {self.number} of the {eye} eye of {self.sensor}: {np.size(self.tof)} words>"


# --- A frame to arrays ---


class _Lines(NamedTuple):
    """Lines of one sensor as arrays."""

    sensor: str
    table: Array
    """LINE_DTYPE; first_point and point_count are those of words."""
    words: Array
    places: Optional[Array]
    angles: Array
    marks: Array
    packets: Array
    origin: Optional[_raw.Origin]
    replaced: tuple[str, ...] = ()
    """Columns that were replaced and are not of packets."""
    had_no_range: int = 0
    """Words that had no range when they were read."""


def _numbers(frame: Frame, where: str) -> dict[str, Array]:
    missing = [name for name in _COLUMNS if name not in frame.columns]
    if missing:
        raise OptionError(f"{where}it has no column {missing[0]!r}; use a frame of open(raw=True), or one made of arrays with "
                          f"{', '.join(_COLUMNS)}, and raw_azimuth and raw_elevation or with_raw(angles)")
    limits = {"tof": _TOF, "pixel": (0, _raw.PIXELS - 1), "edge": (0, 1), "line": (0, 2 ** 32 - 1), "eye": (0, 1)}
    return {name: _raw.whole(frame._array(name), name, *limits[name], where=where) for name in _COLUMNS}


def _lines_of(frame: Frame, columns: Mapping[str, Array], where: str) -> Array:
    """Its lines, with the numbers and eyes that the columns say."""
    try:
        _lines.check(frame.lines, len(frame))
        return _lines.renumber(frame.lines, columns)
    except OptionError as error:
        raise OptionError(f"{where}{error}") from error


def _put_angles(frame: Frame, raw: _raw.Raw, table: Array, columns: Mapping[str, Array], where: str) -> _raw.Raw:
    """The raw part with the columns raw_azimuth and raw_elevation over the angles of the lines."""
    if not {"raw_azimuth", "raw_elevation"} <= set(frame.columns):
        return raw
    which, pixel = np.repeat(np.arange(len(table)), table["point_count"].astype("i8")), columns["pixel"]
    own = np.empty((len(frame), 2), "i2")
    for i, name in enumerate(("raw_azimuth", "raw_elevation")):
        own[:, i] = _raw.whole(frame._array(name), name, -32768, 32767, where)
    pairs = np.ascontiguousarray(raw.angles).view("i4").ravel()  # both at once is faster
    if np.array_equal(pairs.take(which * _raw.PIXELS + pixel), own.view("i4").ravel()):
        return raw
    angles = raw.angles.copy()
    angles[which, pixel] = own
    changed = np.flatnonzero((angles[which, pixel] != own).any(axis=1))
    if len(changed):
        raise OptionError(f"{where}row {changed[0]} has raw angles other than another row of its pixel; a pixel of a line has "
                          "one pair, and rows are ordered by pixel")
    has = raw.has_angles().copy()
    has[which, pixel] |= own.any(axis=1)
    return raw._replace(angles=angles, marks=_raw.marks_of(has))


def _sensor_of(frame: Frame, where: str) -> str:
    """Its address, also with a rig."""
    info = frame._info
    if info.member == JOINED:
        raise OptionError(f"{where}it has the points of several sensors, {info.name}; write the frames "
                          "of a set one by one: frames.values()")
    return address_of(info.sensor) + (f"%{info.interface}" if info.interface else "")


def _take(frame: Frame) -> _Lines:
    where = f"frame {frame.number}: "
    sensor = _sensor_of(frame, where)
    columns = _numbers(frame, where)
    table = _lines_of(frame, columns, where)
    kept: Optional[_raw.Raw] = getattr(frame, "_raw", None)
    if kept is None:
        if "raw_azimuth" not in frame.columns or "raw_elevation" not in frame.columns:
            raise OptionError(f"{where}it has no angles; use the columns raw_azimuth and raw_elevation, or with_raw(angles)")
        has = np.zeros((len(table), _raw.PIXELS), bool)
        has[np.repeat(np.arange(len(table)), table["point_count"].astype("i8")), columns["pixel"]] = True
        kept = _raw.Raw(np.zeros((len(table), _raw.PIXELS, 2), "i2"), _raw.marks_of(has), np.zeros(0, _raw.PACKET_DTYPE), None)
    if len(kept.angles) != len(table):
        raise OptionError(f"{where}it has {len(table)} lines, and the angles of {len(kept.angles)}; with_raw() gives it those of its "
                          "lines")
    raw = _put_angles(frame, kept, table, columns, where)
    places = None
    if "raw_place" in frame.columns:
        places = np.ascontiguousarray(_raw.whole(frame._array("raw_place"), "raw_place", *_PLACE, where=where), "u2")
    replaced = (*raw.replaced, *(("xyz",) if frame._moved else ()))
    return _Lines(sensor, table, _raw.words_of(columns["tof"], columns["edge"], columns["pixel"]), places,
                  np.ascontiguousarray(raw.angles), np.ascontiguousarray(raw.marks), raw.packets, raw.origin, replaced,
                  frame.losses["no_range"])


def _by_line(packets: Array) -> Array:
    """Packets line by line, those of each in their order."""
    if (packets["line"][1:] < packets["line"][:-1]).any():
        packets = packets[np.argsort(packets["line"], kind="stable")]
    return np.ascontiguousarray(packets)


def to_lines(frame: Frame) -> list[Line]:
    """The lines of a frame, in copies."""
    found = _take(frame)
    has = _raw.Raw(found.angles, found.marks, found.packets, None).has_angles()
    packets = _by_line(found.packets)
    starts = np.searchsorted(packets["line"], np.arange(len(found.table) + 1))
    made = []
    for i, line in enumerate(found.table):
        rows = slice(line["first_point"], line["first_point"] + line["point_count"])
        words = found.words[rows]
        made.append(Line(int(line["number"]), EYES[line["eye"]], int(line["clock_us"]), found.angles[i].copy(),
                         (words & lib.LUM_WORD_PIXEL).astype("u2"), words.view("i4") >> 12, (words >> 10 & 1).astype(bool),
                         int(line["arrival_ns"]), has[i].copy(), packets[starts[i]:starts[i + 1]].copy(), found.sensor,
                         found.origin, None if found.places is None else found.places[rows].copy()))
    return made


def _whole(line: Line, name: str, low: int, high: int, shape: Optional[tuple[int, ...]]) -> Array:
    where = f"line {line.number} of the {line.eye} eye: "
    values = _raw.whole(getattr(line, name), name, low, high, where)
    if shape is not None and values.shape != shape:
        raise OptionError(f"{where}{name} has the shape {values.shape}; use {shape}")
    return values


def _take_line(line: Line) -> _Lines:
    if line.eye not in (*EYES, 0, 1):
        raise OptionError(f'line {line.number}: eye is {line.eye!r}; use "blue" or "green"')
    tof = _whole(line, "tof", *_TOF, None)
    shape = (tof.size,)
    pixel, edge = _whole(line, "pixel", 0, _raw.PIXELS - 1, shape), _whole(line, "rising", 0, 1, shape)
    angles = _whole(line, "angles", -32768, 32767, (_raw.PIXELS, 2))
    has = np.ones(_raw.PIXELS, bool) if line.has_angles is None else _whole(line, "has_angles", 0, 1, (_raw.PIXELS,)).astype(bool)
    table = np.zeros(1, _lines.LINE_DTYPE)
    for name, low, high in ("number", 0, 2 ** 32 - 1), ("clock_us", -2 ** 63, 2 ** 63 - 1), ("arrival_ns", 0, 2 ** 63 - 1):
        table[name] = _whole(line, name, low, high, ())
    table["eye"], table["point_count"] = EYES.index(line.eye) if isinstance(line.eye, str) else line.eye, tof.size
    packets = _raw.packets_of(line.packets, f"line {line.number} of the {line.eye} eye: ")
    packets["line"] = 0
    places = None if line.place is None else np.ascontiguousarray(_whole(line, "place", *_PLACE, shape), "u2")
    return _Lines(line.sensor, table, _raw.words_of(tof.reshape(shape), edge, pixel), places, np.ascontiguousarray(angles[None], "i2"),
                  _raw.marks_of(has[None]), packets, line.origin)


# --- The file ---


def _documents(origin: Optional[_raw.Origin], profile: Profile) -> list[bytes]:
    """What a pcapng file says of itself, as lumdump says it."""
    from ._formats import About

    calibration = Calibration() if origin is None else origin.calibration
    about = About(program=f"lumsdk.write_capture {VERSION}", source="arrays" if origin is None else os.path.basename(origin.source),
                  calibration=calibration.to_yaml(), profile=profile.to_yaml(), usual_calibration=calibration == Calibration(),
                  usual_profile=profile == Profile(), earlier=[] if origin is None else list(origin.earlier))
    return [text.encode("ascii", "replace") for text in about.text().split("---\n")]


class _File:
    """A capture that is written; the first lines tell what it says of itself."""

    def __init__(self, path: str, name: str, file_format: int, profile: Optional[Profile]) -> None:
        self._path, self._name, self._format, self._asked = path, name, file_format, profile
        self._error = ffi.new("lum_error *")
        self._writer: Any = None
        self._interfaces: dict[int, str] = {}
        self._profile: Optional[Profile] = None
        self._calibration: Optional[Calibration] = None
        self._layouts: dict[Profile, Any] = {}
        self._seen: Optional[_raw.Origin] = None
        self._no_range = 0
        self.frames = 0
        self.made_no_range = 0  # words that have no range since they were read
        self.replaced: dict[str, None] = {}  # columns that were replaced and are not written

    def _layout(self, profile: Profile) -> Any:
        if profile not in self._layouts:
            layout = ffi.new("lum_layout *")
            if lib.lum_layout_init(layout, profile._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK:
                raise OptionError("the profile is out of range")
            self._layouts[profile] = layout
        return self._layouts[profile]

    def begin(self, origin: Optional[_raw.Origin]) -> None:
        """Open it."""
        self._profile = self._asked or (origin.profile if origin is not None else Profile())
        self._calibration = None if origin is None else origin.calibration
        file = sized("lum_capture_writer_options", format=self._format)
        kept: list[Any] = []
        if self._format == lib.LUM_CAPTURE_PCAPNG:
            texts = _documents(origin, self._profile)
            kept = [ffi.new("char[]", text) for text in (f"lumsdk.write_capture {VERSION}".encode(), *texts)]
            kept.append(ffi.new("const char *[]", kept[1:]))
            file.application, file.comments, file.comment_count = kept[0], kept[-1], len(texts)
        options = sized("lum_packet_writer_options", layout=self._layout(self._profile), file=file)
        out = ffi.new("lum_packet_writer **")
        check(lib.lum_packet_writer_open(os.fsencode(self._path), options, out, self._error), self._error, TargetError)
        self._writer = out[0]

    def _check_origin(self, origin: Optional[_raw.Origin]) -> None:
        if origin is not None and origin is not self._seen:
            self._seen = origin
            check_not_read(self._name, origin.paths, "the source itself")
        if self._writer is None:
            self.begin(origin)
        if origin is None:
            return
        if self._asked is None and origin.profile != self._profile:
            raise OptionError(f"{self._name}: frames of two profiles, the second of {origin.source or 'arrays'}; profile= names the "
                              "one to write with")
        if self._calibration is not None and origin.calibration != self._calibration and self._format == lib.LUM_CAPTURE_PCAPNG:
            warn(f"{self._name}: the frames have several calibrations, and a file can name one: it names that of the first")
            self._calibration = None

    def _address(self, sensor: str) -> int:
        found = parse_sensor(sensor if sensor != _NO_SENSOR else Line.sensor)
        known = self._interfaces.setdefault(found.address, found.interface)
        if known != found.interface:
            raise OptionError(f"{self._name}: frames of {sensor} and of another sensor with its address; a "
                              "written capture has one interface: write a file for each")
        return found.address

    def add(self, lines: _Lines, where: str) -> None:
        """Write lines."""
        self._check_origin(lines.origin)
        no_range = int((lines.words.view("i4") >> 12 <= 0).sum())
        self._no_range += no_range
        self.made_no_range += max(0, no_range - lines.had_no_range)
        self.replaced.update(dict.fromkeys(lines.replaced))
        packets = _by_line(lines.packets)
        starts = np.searchsorted(packets["line"], np.arange(len(lines.table) + 1))
        one = sized("lum_raw_line", sensor=self._address(lines.sensor))
        if lines.origin is not None:
            one.layout = self._layout(lines.origin.profile)
        words, angles, marks, table = (ffi.cast(kind, array.ctypes.data) for kind, array in (
            ("uint32_t *", lines.words), ("lum_angle *", lines.angles), ("uint32_t *", lines.marks), ("lum_raw_packet *", packets)))
        places = None if lines.places is None else ffi.cast("uint16_t *", lines.places.ctypes.data)
        add, writer, error = lib.lum_packet_writer_add, self._writer, self._error
        for i, (number, eye, first, count, clock_us, arrival_ns) in enumerate(lines.table[
                ["number", "eye", "first_point", "point_count", "clock_us", "arrival_ns"]].tolist()):
            one.number, one.eye, one.clock_us, one.arrival_ns = number, eye, clock_us, arrival_ns
            one.words, one.word_count = words + first, count
            one.places = ffi.NULL if places is None else places + first
            one.angles, one.angle_marks = angles + i * _raw.PIXELS, marks + i * _raw.MARKS
            begin = int(starts[i])
            one.packets, one.packet_count = table + begin, int(starts[i + 1]) - begin
            if add(writer, one, error) != 0:
                raise OptionError(f"{where}{ffi.string(error.text).decode(errors='replace')}")

    def end_frame(self) -> None:
        """The lines since the last call belong together."""
        if self._writer is not None:
            check(lib.lum_packet_writer_end_frame(self._writer, self._error), self._error, TargetError)

    def finish(self) -> Written:
        """Give the file its name."""
        if self._writer is None:
            self.begin(None)
        check(lib.lum_packet_writer_flush(self._writer, self._error), self._error, TargetError)
        c = sized("lum_packet_writer_counters")
        lib.lum_packet_writer_count(self._writer, c)
        writer, self._writer = self._writer, None
        check(lib.lum_packet_writer_close(writer, self._error), self._error, TargetError)
        return Written(c.packets, c.lines, self.frames, c.repeated, c.lines_cut_anew,
                       {name: getattr(c, name) for name in _DROPPED if getattr(c, name)}, c.clock_jumps, self._no_range)

    def discard(self) -> None:
        """Remove what was written."""
        if self._writer is not None:
            lib.lum_packet_writer_abort(self._writer)
        self._writer = None


def _each(items: Iterable[Union[Frame, Line]]) -> Iterator[Union[Frame, Line]]:
    from ._frame import Frame
    from ._sync import refuse_set

    refuse_set(items)
    if isinstance(items, (Frame, Line)):
        items = [items]
    for item in items:
        refuse_set(item)
        if not isinstance(item, (Frame, Line)):
            raise TypeError(f"write_capture() takes frames and lines, not {type(item).__name__}; frames are those of open(raw=True)")
        yield item


def _write_all(file: _File, items: Iterable[Union[Frame, Line]]) -> None:
    together = 0
    for item in _each(items):
        if isinstance(item, Line):
            file.add(_take_line(item), "")
            together += 1
            if together == _LINES_TOGETHER:
                file.end_frame()
                together = 0
            continue
        if together:
            file.end_frame()
            together = 0
        file.add(_take(item), f"frame {item.number}: ")
        file.end_frame()
        file.frames += 1
    file.end_frame()


def write_capture(out: Union[str, os.PathLike[str]], items: Iterable[Union[Frame, Line]], *,
                  profile: Union[str, os.PathLike[str], Mapping[str, Any], Profile, None] = None,
                  storage_options: Optional[Mapping[str, Any]] = None) -> Written:
    """Write packets from frames or lines, to cut, edit, disturb or make up a drive.

        with lumsdk.open("drive.pcap", raw=True) as source:
            lumsdk.write_capture("part.pcapng", source[100:200])

    The columns tof, pixel, edge, line and eye of a frame are its words; raw_azimuth, raw_elevation and frame.angles its angles. Where
    a line's packets in frame.packets still fit these, they are cut, stamped and ordered as they were; if clock_us or arrival_ns in
    frame.lines is not that of the first of them any more, all are moved by the difference. Otherwise the line is cut as the sensor
    does it, with the line's clock and arrival. The clock is cut to the width of the profile's field, as the clock
    itself wraps, and where a tick is longer than a microsecond it is rounded down.

    Args:
        out: a path or a URL that ends with .pcap or .pcapng. A pcapng file says where it comes from, with calibration and profile. It
            is complete, or not there at all.
        items: frames of open(raw=True), or made of arrays; Line values; both may come mixed, and of several sensors.
        profile: of the packets; without it, that of the frames' source, or the built-in one.
        storage_options: for the file system of a URL, as fsspec takes them.

    Returns:
        What was written. A CaptureWarning says how many packets a reader will drop, how many words have a tof of 0 or below, and
        which changed columns, such as range, packets do not have.

    Raises:
        OptionError: the file is the source that frames come from, a frame without raw columns, a value that a packet cannot hold,
            rows out of order, frames of two profiles.
        Error: the file cannot be written (also an OSError).
    """
    name = os.fsdecode(out)
    ending = os.path.splitext(name)[1]
    if ending not in _FORMATS:
        raise OptionError(f"{name}: captures that are written end with .pcap or .pcapng")
    storage = check_storage(storage_options)
    if storage and not is_url(name):
        raise OptionError(f"storage_options does not go with {name}: it is for a URL")
    with local_for(name, storage) as path:
        file = _File(path, name, _FORMATS[ending], None if profile is None else Profile(profile))
        try:
            _write_all(file, items)
            written = file.finish()
        finally:
            file.discard()
    if file.replaced:
        warn(f"{name}: {', '.join(file.replaced)} of frames were changed, but packets do not have them: they "
             "hold tof, raw_azimuth and raw_elevation")
    if file.made_no_range:
        warn(f"{name}: {file.made_no_range} words have a tof of 0 or below, which gives no range unless tof_offset_ps lifts it")
    if written.dropped:
        warn(f"{name}: a reader will drop packets of it: {', '.join(f'{kind} {n}' for kind, n in written.dropped.items())}; lines "
             "are repeated, or their clocks or numbers are out of order")
    if written.clock_jumps:
        warn(f"{name}: at {written.clock_jumps} places the clock jumps by half a round of the profile's field or more: a reader "
             "then misses whole rounds of the clock; bring frames closer by clock_us of their lines")
    return written
