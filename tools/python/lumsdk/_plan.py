"""What convert() is asked for: the source, the destination and the options, checked."""
from __future__ import annotations

import copy
import os
import re
import reprlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, Optional, TypedDict

import numpy as np

from ._errors import OptionError, warn
from ._formats import WRITERS
from ._frame import Frame
from ._inputs import check_storage, urls_of
from ._options import Choice
from ._points_file import FORMATS
from ._poses import MOMENTS, Motion, Poses, of_several
from ._source import Source
from ._sync import refuse_set
from ._table import FILE_COLUMNS, OF_RAW, OF_RIG, TIMES, Layout, check_names, check_preset
from ._target import check_not_read, is_url

_OF_LUMDUMP = ("csv", "ply", "pcd", "las", "xyz", "png", "mcap", "pcap", "pcapng")
OF_TABLES = ("parquet", "feather", "npy", "npz")
_ALL = (*_OF_LUMDUMP, *WRITERS)
_MOVED = tuple(name for name in _ALL if name not in ("png", "pcap", "pcapng"))

APPLIES: Mapping[str, tuple[str, ...]] = {
    "ascii": ("ply", "pcd"),
    "columns": ("csv", "ply", "pcd", *OF_TABLES),
    "colour": ("png",),
    "comments": ("csv", "xyz"),
    "compression": tuple(name for name, kind in WRITERS.items() if kind.compressions),
    "duration": _OF_LUMDUMP,
    "organized": ("pcd",),
    "packets": ("pcap", "pcapng"),
    "pose_times": _MOVED,
    "poses": _MOVED,
    "preset": ("parquet", "feather"),
    "rotate": _OF_LUMDUMP,
    "size": ("png",),
    "time": tuple(name for name in _MOVED if name not in ("bin", "xyz")),
    "to": _MOVED,
    "voxel": ("csv", "ply", "pcd", "las", "laz"),
}
"""The options of outputs, and the formats that have them."""

_NAMED = (*APPLIES["columns"], "las", "laz", "mcap")
"""Formats that take columns of one's own."""

_ONLY_BY_LUMDUMP = ("colour", "duration", "organized", "packets", "rotate", "size", "voxel")


def _format_of(name: str, given: Optional[str]) -> str:
    if given is not None:
        if not isinstance(given, str):
            raise TypeError(f"format is {given!r}; use one of {', '.join(_ALL)}")
        if given not in _ALL:
            raise OptionError(f"format is {given!r}; formats are {', '.join(_ALL)}")
        return given
    lowered = name.lower()
    if lowered.endswith(".copc.laz"):
        raise OptionError(f"{name}: COPC keeps points in an octree, which lumsdk does not make: write a .laz, "
                          "then make a .copc.laz from it by pdal translate or untwine")
    ending = lowered.rsplit(".", 1)[-1] if "." in lowered else ""
    if ending not in _ALL:
        raise OptionError(f"'{name}' has no ending that shows a format: use {' '.join('.' + f for f in _ALL)}, or give "
                          "format=")
    return ending


PATTERN = re.compile(r"%(0?)(\d{0,2})d")


def _check_pattern(name: str, has_rig: bool) -> bool:
    """Whether a name stands for a file a frame."""
    if "%s" in name:
        if not has_rig:
            raise OptionError(f"{name}: %s stands for the name of a rig's sensor: give rig= too")
        if name.count("%s") > 1:
            raise OptionError(f"{name}: %s stands for the sensor's name, and has to be there once")
        name = name.replace("%s", "")
    if "%" not in name:
        return "{utc_ns}" in name
    if name.count("%") != 1 or not PATTERN.search(name):
        raise OptionError(f"{name}: a % in the name stands for the frame number: write %d or %04d, once")
    return True


def name_for(pattern: str, frame: Frame) -> str:
    made = pattern % frame.number if "%" in pattern else pattern
    return made.replace("{utc_ns}", str(frame.utc_ns))


class Plan:
    """A conversion: what was asked for, checked."""

    def __init__(self, source: Any, destination: Any, options: dict[str, Any]) -> None:
        self.source: Any = [source] if isinstance(source, Frame) else source
        if not isinstance(destination, (str, os.PathLike)):
            raise TypeError(f"the destination is {reprlib.repr(destination)}; use a path or a URL, such as "
                            '"drive.laz"')
        self.name = os.fsdecode(destination)
        if self.name == "-":
            raise OptionError("'-' is standard output, which convert() does not write to: name a file")
        # What can be gone through once, as a generator, is needed several times.
        options = {name: list(value) if isinstance(value, Iterator) else value
                   for name, value in options.items() if value is not None}
        self.paths: list[str] = []
        """Files of the source."""
        self.storage = check_storage(options.pop("storage_options", None))
        urls = urls_of(self.source)
        if self.storage and not is_url(self.name) and not urls:
            raise OptionError(f"storage_options does not go with {self.name}: it is for a URL")
        store = self.name.partition("://")[0] + "://"
        self.source_storage = self.storage if not is_url(self.name) or any(url.startswith(store) for url in urls) else None
        """Those for the source: one of another store than the destination's has others."""
        self.format = _format_of(self.name, options.pop("format", None))
        self.output = {name: options.pop(name) for name in tuple(options) if name in APPLIES}
        self.read = options
        self.has_rig = "rig" in self.read or (isinstance(source, Source) and source.rig is not None)
        self.is_of_joined = False
        """Whether a frame is of several sensors, which is seen when frames come."""
        self.is_of_frames = self._is_of_frames()
        self.is_of_world = "poses" in self.output and self.output.get("to", "world") == "world"
        """Whether points are in the poses' fixed frame."""
        self.is_pattern = _check_pattern(self.name, self.has_rig or self.is_of_frames)
        self.is_split = "%s" in self.name
        """Whether each sensor of the rig has files of its own."""
        choice = Choice(self.read)
        self.progress: Optional[Callable[[int, int], object]] = choice.progress
        wanted = source._choice.wanted if isinstance(source, Source) else choice.wanted
        self.sensors = [sensor.name for sensor in wanted]
        """Of the rig, those that are converted."""
        if self.is_of_frames and self.read:
            raise OptionError(f"{', '.join(self.read)}: frames have been read already: give such options when the source is "
                              "opened")
        self.raises = self.read.get("broken") == "raise"
        self.is_laz_of_las = self.format == "laz" and "voxel" in self.output
        of_lumdump = self.format in _OF_LUMDUMP or self.is_laz_of_las
        poses = self.output.get("poses")
        is_plain = not isinstance(poses, Poses) or poses.is_plain or self.format not in _MOVED
        is_raw = choice.raw or isinstance(source, Source) and source._choice.raw
        self.besides: dict[str, np.dtype[Any]] = {name: column.dtype for name, column in OF_RAW.items() if is_raw}
        """Columns of frames of a source beside those that every one has, and their types."""
        if self.has_rig:
            self.besides["sensor"] = OF_RIG.dtype
        self.by_lumdump = of_lumdump and not self.is_of_frames and not self.raises and is_plain and not is_raw
        if self.is_laz_of_las and self.is_pattern:
            raise OptionError(f"{self.name}: with voxel, LAZ is one file; name one without % or {{utc_ns}}")
        self._check_output()

    def _is_of_frames(self) -> bool:
        given = self.source
        if isinstance(given, Source):
            return True
        if isinstance(given, (str, os.PathLike, bytes, bytearray, memoryview)) or callable(getattr(given, "read", None)):
            return False
        refuse_set(given)
        if isinstance(given, (list, tuple)):
            for item in given:
                refuse_set(item)
            return bool(given) and all(isinstance(item, Frame) for item in given)
        if isinstance(given, Iterable):
            return True
        raise TypeError(f"a source is given as {type(given).__name__}; use what open() takes, a Source, or frames")

    def _check_output(self) -> None:
        for name, value in self.output.items():
            applies = APPLIES[name]
            if self.by_lumdump and name not in ("compression", "preset"):
                continue
            if self.format not in applies:
                raise OptionError(f"{name} does not go with the format {self.format}; it goes with {', '.join(applies)}")
            if name in _ONLY_BY_LUMDUMP:
                raise OptionError(f"{name} is done by lumdump: it needs a capture as source, not frames; no broken=\"raise\"; and "
                                  "Poses with the usual gap and jump, and the clock that the size of their times shows")
            if name in ("pose_times", "to") and "poses" not in self.output:
                raise OptionError(f"{name} goes with poses, which say where the sensor was: give poses= too")
            if name == "to" and value not in MOMENTS:
                raise OptionError(f"to is {value!r}; use one of {', '.join(MOMENTS)}")
            if name == "time" and value == "sensor" and self._is_joined:
                raise self.own_clocks()
            if name == "time" and value not in TIMES:
                raise OptionError(f"time is {value!r}; use " + ", ".join(f'"{time}"' for time in TIMES))
        if not self.by_lumdump and self.format in ("png", "pcap", "pcapng"):
            raise OptionError(f"{self.format} is written by lumdump: it needs a capture as source, not frames, and no "
                              "broken=\"raise\"")

    def own_clocks(self) -> OptionError:
        """A file would have points of several sensors, and times of their clocks."""
        other = "" if self.is_of_joined else f", or put %s into {self.name}, which makes a file for each"
        return OptionError(f'time is "sensor", and each sensor has a clock of its own: leave it out{other}')

    @property
    def _is_joined(self) -> bool:
        """Whether a file has points of several sensors of the rig, or may have: of frames it is not known."""
        return self.is_of_joined or self.has_rig and not self.is_split and not self.is_pattern and len(self.sensors) != 1

    @property
    def time(self) -> str:
        """What timestamps are; sensors of a rig have no clock in common."""
        return str(self.output.get("time", "utc" if self._is_joined else "sensor"))

    def check_written(self, name: str) -> None:
        """OptionError: an output of this name would replace what the run reads."""
        poses = self.output.get("poses")
        files = [*(poses.files if isinstance(poses, Poses) else [poses]), self.output.get("pose_times")]
        settings = (([self.read.get(name)], f"the {name}") for name in ("rig", "calibration", "profile"))
        for paths, what in (self.paths, "the source itself"), (files, "a file of the poses"), *settings:
            check_not_read(name, paths, what)

    def motion(self) -> Optional[Motion]:
        """What moves the points; None: they stay where they were seen."""
        if "poses" not in self.output:
            return None
        is_bare = self.format in ("npy", "bin") or (self.format in APPLIES["comments"] and not self.output.get("comments"))
        made = Motion(self.output["poses"], self.output.get("pose_times"), str(self.output.get("to", "world")),
                      self.format if is_bare else "")
        if len(self.sensors) > 1 and made.poses.clock != "utc":
            raise of_several(made.poses)
        return made

    def layout(self, own: Mapping[str, np.dtype[Any]] = MappingProxyType({})) -> Layout:
        """The columns of a table; own are those that the frames have besides."""
        preset = self.output.get("preset")
        columns = self.output.get("columns")
        known = own
        if preset is not None:
            check_preset(preset, columns)
        if self.is_split:  # the name of a file says whose it is
            own = {name: dtype for name, dtype in own.items() if name != "sensor"}
        own = {name: dtype for name, dtype in own.items() if name not in OF_RAW}  # only where they are named
        if own and (preset is not None or self.format not in _NAMED):
            added = [name for name in own if name != "sensor"]
            what = [f"columns of their own, {', '.join(added)}"] if added else []
            what += ["the column sensor, the place in the rig"] if "sensor" in own else []
            warn(f"the frames have {' and '.join(what)}, which are left out: "
                 + (f"the preset {preset}" if preset is not None else self.format)
                 + f" has no place for them; {', '.join(_NAMED)} have")
            own = known = {}
        if preset is not None:
            return Layout((), preset)
        kind = WRITERS.get(self.format)
        if kind is not None and kind.needs is not None:
            return Layout((*kind.needs, *own), own=own)
        if columns == "all":  # not every raw frame has it
            known = {name: dtype for name, dtype in known.items() if name != "raw_place"}
        names = check_names(columns, ("x", "y", "z") if self.format == "xyz" else tuple(dict.fromkeys((*FILE_COLUMNS, *own))), known)
        if self.format in FORMATS and not set(names) <= {*FILE_COLUMNS, "time", *known}:
            raise OptionError(f"columns: {self.format} has {', '.join((*FILE_COLUMNS, 'time', *known))}")
        return Layout(names, time=self.time, own=known)

    def of_sensor(self, name: str) -> Plan:
        """The same for the files of one sensor of the rig."""
        made = copy.copy(self)
        made.name = self.name.replace("%s", name)
        return made


class Summary(TypedDict):
    """What a conversion did: a dictionary. Where lumdump's JSON has the same facts, they are the same."""

    source: str
    """Its name."""
    format: str
    """The name of the format."""
    outputs: list[str]
    """The files that were made."""
    frames: int
    """Frames in the outputs: those that were selected, or given, also where a frame has no points."""
    points: int
    """Points that were written."""
    bytes: int
    """Size of the outputs together."""
    truncated: bool
    """Whether the capture breaks off before its end."""
    sensors: list[str]
    """Names of the sensors: their addresses, as Frame.sensor has them."""
    losses: dict[str, int]
    """What is missing in the capture, by cause, with lumdump's names; empty if frames were given."""
    left_out: int
    """Points that were selected but are in no file: their line came too late or exceeded a frame's
    limit, or their time has no pose."""
