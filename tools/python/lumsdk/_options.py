"""The options of open(): those of lumdump, by the same names."""
from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, cast

from ._c import cores, ffi, lib, number_of, sized
from ._errors import OptionError, nearest
from ._info import Members
from ._columns import COLUMNS
from ._raw import NEEDED, RAW_COLUMNS
from ._settings import Calibration, Profile, setting_of

if TYPE_CHECKING:
    from ._rig import Rig, RigSensor
    from ._types import Column, DataColumn, Options

DEFAULT_COLUMNS = ("x", "y", "z", "range", "pulse_width", "line", "pixel", "eye")

_ALLOWED = {
    "returns": '"all", "first", "last", "strongest" or a number from 1',
    "frames": '"FIRST:LAST", such as "10:20" or "10:", (10, 20) or one number',
    "range": '"MIN:MAX" in metres, such as "2:80", or (2, 80)',
    "box": '"XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX" in metres, such as "0:50,-10:10,:4", or three pairs such as '
           "((0, 50), (-10, 10), (None, 4))",
    "smooth": '0 for off, an odd number of pixels up to 63, such as 31, or "WINDOW:ORDER" or (WINDOW, ORDER), the '
              "order from 0 to 5 and below the window, such as (31, 2)",
    "sensor": 'an address such as "10.42.0.37", or "10.42.0.37%eth1"',
    "port": "a number from 1 to 65535",
    "threads": f"a number from 1 to {lib.LUM_FRAMER_THREADS_MAX}",
    "columns": f'"all" or names of {", ".join(COLUMNS)}, such as ["x", "y", "z"] or "x,y,z"',
}
_WORDS: dict[str, dict[str, int]] = {
    "edge": {"rising": lib.LUM_EDGES_RISING, "falling": lib.LUM_EDGES_FALLING, "both": lib.LUM_EDGES_BOTH},
    "eye": {"blue": lib.LUM_EYES_BLUE, "green": lib.LUM_EYES_GREEN, "both": lib.LUM_EYES_BOTH},
    "incomplete": {"keep": 0, "drop": 1},
    "broken": {"raise": 0, "warn": 1},
}
_RETURNS = {"all": lib.LUM_RETURNS_ALL, "first": lib.LUM_RETURNS_FIRST, "last": lib.LUM_RETURNS_LAST,
            "strongest": lib.LUM_RETURNS_STRONGEST}
_NAMES = ("columns", "returns", "edge", "eye", "sensor", "rig", "port", "frames", "range", "box", "incomplete", "smooth",
          "calibration", "profile", "set", "broken", "raw", "threads", "progress")
_OF_RIG = ("calibration", "profile", "set")
_INT64 = (-2 ** 63, 2 ** 63 - 1)
# More do not help: the one that reads and assembles takes most of the time, and lines have to be copied to the others.
_THREADS = 2


def _wrong(name: str, value: object, allowed: Optional[str] = None) -> OptionError:
    return OptionError(f"{name} is {value!r}; use {allowed or _ALLOWED[name]}")


def _wrong_type(name: str, value: object, allowed: Optional[str] = None) -> TypeError:
    return TypeError(f"{name} is {value!r}, of type {type(value).__name__}; use {allowed or _ALLOWED[name]}")


def _is_whole(value: object) -> bool:
    return hasattr(value, "__index__") and not isinstance(value, bool)


def _word(name: str, value: object) -> int:
    words = list(_WORDS[name])
    allowed = ", ".join(f'"{word}"' for word in words[:-1]) + f' or "{words[-1]}"'
    if not isinstance(value, str):
        raise _wrong_type(name, value, allowed)
    if value not in _WORDS[name]:
        raise _wrong(name, value, allowed)
    return _WORDS[name][value]


def _number(name: str, value: Any, whole: object) -> float:
    if isinstance(value, str):
        if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", value):
            raise _wrong(name, whole)
        return float(value)
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise _wrong_type(name, whole)
    return float(value)


def _pair(name: str, value: Any, whole: object) -> list[Any]:
    """Two values, each of which may be None."""
    if not isinstance(value, (str, tuple, list)):
        raise _wrong_type(name, whole)
    parts = [part or None for part in value.split(":")] if isinstance(value, str) else list(value)
    if len(parts) != 2:
        raise _wrong(name, whole)
    return parts


def _limits(name: str, value: Any, whole: object) -> tuple[float, float]:
    """(MIN, MAX), each of which may be missing."""
    parts = _pair(name, value, whole)
    low = -math.inf if parts[0] is None else _number(name, parts[0], whole)
    high = math.inf if parts[1] is None else _number(name, parts[1], whole)
    if not low <= high or any(math.isfinite(v) and abs(v) > 1e6 for v in (low, high)):
        raise _wrong(name, whole)
    return low, high


def _whole(name: str, value: Any, whole: object) -> int:
    if isinstance(value, str):
        if not re.fullmatch(r"-?\d+", value):
            raise _wrong(name, whole)
        return int(value)
    if not _is_whole(value):
        raise _wrong_type(name, whole)
    return int(value.__index__())


class FrameRange(NamedTuple):
    """Frames of these numbers, both included."""

    first: int = _INT64[0]
    last: int = _INT64[1]


def _frames(value: Any) -> FrameRange:
    if _is_whole(value):
        parts = [value, value]
    elif isinstance(value, range):
        parts = _pair("frames", (value[0], value[-1]) if value.step == 1 and len(value) else (), value)
    else:
        parts = _pair("frames", value, value)
    low = _INT64[0] if parts[0] is None else _whole("frames", parts[0], value)
    high = _INT64[1] if parts[1] is None else _whole("frames", parts[1], value)
    if not _INT64[0] <= low <= high <= _INT64[1]:
        raise _wrong("frames", value)
    return FrameRange(low, high)


def _columns(value: Any) -> int:
    """The bits of columns."""
    if isinstance(value, str):
        names = list(COLUMNS) if value == "all" else value.split(",") if value else []
    else:
        try:
            names = list(value)
        except TypeError:
            raise _wrong_type("columns", value) from None
    mask = 0
    for name in names:
        if not isinstance(name, str):
            raise _wrong_type("columns", value)
        if name not in COLUMNS:
            near = nearest(name, COLUMNS)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(COLUMNS)}"
            raise OptionError(f"columns: unknown column {name!r}; {hint}")
        mask |= 1 << list(COLUMNS).index(name)
    return mask


def data_columns(columns: Any, joins: bool) -> tuple[DataColumn, ...]:
    """The columns of a data set, in their order.

    Args:
        columns: the option.
        joins: whether "xyz" can be one of them, as it is by default.
    """
    if columns is None or columns == "all":
        names = list(DEFAULT_COLUMNS if columns is None else COLUMNS)
        if joins and {"x", "y", "z"} <= set(names):
            names = ["xyz", *(name for name in names if name not in ("x", "y", "z"))]
        return cast("tuple[DataColumn, ...]", tuple(names))
    names = columns.split(",") if isinstance(columns, str) else list(columns)
    if not joins and "xyz" in names:
        raise OptionError('columns: "xyz" is a column of rows="frames"; of points, name x, y and z')
    _columns([name for name in names if name != "xyz"])
    return cast("tuple[DataColumn, ...]", tuple(dict.fromkeys(names)))


def columns_of(names: Iterable[DataColumn]) -> tuple[Column, ...]:
    """The columns that a frame needs for those of a data set."""
    made: list[Column] = []
    for name in names:
        if name == "xyz":
            made.extend(("x", "y", "z"))
        else:
            made.append(name)
    return tuple(dict.fromkeys(made))


class ChosenSensor(NamedTuple):
    """One of several sensors."""

    name: str
    address: int
    """In host order."""
    interface: str
    """Empty: the first with that address."""


def parse_sensor(value: Any) -> ChosenSensor:
    """ADDRESS or ADDRESS%INTERFACE."""
    if not isinstance(value, str):
        raise _wrong_type("sensor", value)
    address, mark, interface = value.partition("%")
    if mark and not re.fullmatch(r"[!-~]{1,63}", interface):
        raise _wrong("sensor", value)
    return ChosenSensor(value, _parse_address(address, value), interface)


def _parse_address(text: str, value: str) -> int:
    parts = text.split(".")
    if len(parts) != 4 or not all(re.fullmatch(r"0|[1-9]\d{0,2}", part) and int(part) < 256 for part in parts):
        raise _wrong("sensor", value)
    return number_of(text)


def parse_port(value: Any) -> int:
    """The UDP port of sensors."""
    number = _whole("port", value, value)
    if not 1 <= number <= 65535:
        raise _wrong("port", value)
    return number


def _smooth(value: Any) -> tuple[int, int]:
    if isinstance(value, str):
        parts: list[Any] = value.split(":")
    elif isinstance(value, (tuple, list)):
        parts = list(value)
    else:
        parts = [value]
    if len(parts) not in (1, 2):
        raise _wrong("smooth", value)
    window = _whole("smooth", parts[0], value)
    order = _whole("smooth", parts[1], value) if len(parts) == 2 else 2 if window > 3 else 1 if window > 1 else 0
    if not (0 <= window <= lib.LUM_SMOOTH_WINDOW_MAX and 0 <= order <= lib.LUM_SMOOTH_ORDER_MAX):
        raise _wrong("smooth", value)
    if window and lib.lum_smooth_init(ffi.new("lum_smooth *"), window, order) != lib.LUM_OK:
        raise _wrong("smooth", value)
    return window, order


def _threads(value: Any) -> int:
    """As many as asked for, or as this process has cores, but not more than help."""
    if value is None:
        return min(cores(), _THREADS)
    number = _whole("threads", value, value)
    if not 1 <= number <= lib.LUM_FRAMER_THREADS_MAX:
        raise _wrong("threads", value)
    return number


def _fill_selection(selection: Any, options: Mapping[str, Any]) -> None:
    returns = options.get("returns", "all")
    if isinstance(returns, str) and returns in _RETURNS:
        selection.returns = _RETURNS[returns]
    else:
        number = _whole("returns", returns, returns)
        if not 1 <= number <= 65535:
            raise _wrong("returns", returns)
        selection.returns, selection.return_number = lib.LUM_RETURNS_NUMBER, number
    selection.edges = _word("edge", options.get("edge", "rising"))
    if "range" in options:
        selection.has_range = True
        selection.range_min, selection.range_max = _limits("range", options["range"], options["range"])
    if "box" in options:
        box = options["box"]
        axes = box.split(",") if isinstance(box, str) else box
        if not isinstance(axes, (tuple, list)):
            raise _wrong_type("box", box)
        if len(axes) != 3:
            raise _wrong("box", box)
        selection.has_box = True
        for i, axis in enumerate(axes):
            selection.box_min[i], selection.box_max[i] = _limits("box", axis, box)


def _raw(options: Mapping[str, Any]) -> bool:
    """Whether every word is a row; then nothing may hide some."""
    raw = options.get("raw", False)
    if not isinstance(raw, bool):
        raise _wrong_type("raw", raw, "True or False")
    for name, usual in ("edge", "both"), ("returns", "all"), ("range", None), ("box", None):
        if raw and options.get(name, usual) != usual:
            raise OptionError(f"{name} does not go with raw=True, where every word is a row: leave it out and "
                              "choose rows of the frames")
    return raw


class Choice:
    """What open() was asked for, checked, as the library takes it."""

    def __init__(self, given: Mapping[str, Any]) -> None:
        # What can be gone through once, as a generator, is needed several times.
        options = {name: list(value) if isinstance(value, Iterator) else value
                   for name, value in given.items() if value is not None}
        for name in given:
            if name not in _NAMES:
                near = nearest(name, _NAMES)
                raise TypeError(f"there is no option {name}" + (f"; did you mean {near[0]}?" if near else
                                                                f"; there are {', '.join(_NAMES)}"))
        self.progress: Any = options.get("progress")
        if self.progress is not None and not callable(self.progress):
            raise _wrong_type("progress", self.progress, "a function of two numbers: bytes read, and all of them")
        self.warns = bool(_word("broken", options.get("broken", "raise")))
        self.raw = _raw(options)
        self.given = {name: value for name, value in options.items() if name != "progress"}
        self.rig = self._take_rig(options)
        self.calibration, self.profile = self._settings(options)
        self.range = _frames(options["frames"]) if "frames" in options else FrameRange()
        self.members = () if self.rig is None else tuple(self.rig.values())
        """The sensors of the rig; none without one."""
        self.of_frames = None if self.rig is None else Members(self.members, tuple(self.rig.describe()))
        """What frames know of the rig."""
        self.wanted = self._wanted(options)
        """Those whose frames are to come."""
        self.sensor: Optional[ChosenSensor] = parse_sensor(options["sensor"]) if "sensor" in options and self.rig is None else None
        self.port = parse_port(options["port"]) if "port" in options else int(lib.LUM_PORT)
        self.eyes = _word("eye", options.get("eye", "both"))
        self.drops_incomplete = bool(_word("incomplete", options.get("incomplete", "keep")))
        self.threads = _threads(options.get("threads"))
        self.view = self._view(options)

    def to_give(self) -> Options:
        """The options, for the same choice where files of settings may be elsewhere."""
        named = {"calibration": (self.names_calibration, self.calibration), "profile": (self.names_profile, self.profile)}
        made = {**self.given, **{name: value for name, (is_named, value) in named.items() if is_named}}
        if self.rig is not None:
            made["rig"] = self.rig
        return cast("Options", {**made, "progress": self.progress} if self.progress is not None else made)

    @staticmethod
    def _take_rig(options: Mapping[str, Any]) -> Optional[Rig]:
        if "rig" not in options:
            return None
        from ._rig import Rig

        for name in _OF_RIG:
            if name in options:
                raise OptionError(f"{name} does not go with rig, which has a calibration and a profile for each sensor: name them "
                                  "there")
        return Rig(options["rig"])

    def _wanted(self, options: Mapping[str, Any]) -> tuple[RigSensor, ...]:
        name = options.get("sensor")
        if self.rig is None or name is None:
            return self.members
        if not isinstance(name, str):
            raise _wrong_type("sensor", name, f"one of the rig: {', '.join(self.rig)}")
        if name not in self.rig:
            raise _wrong("sensor", name, f"one of the rig: {', '.join(self.rig)}")
        return (self.rig[name],)

    def _settings(self, options: Mapping[str, Any]) -> tuple[Calibration, Profile]:
        """Those that are named, without what set= has on top."""
        self.names_calibration = "calibration" in options
        self.names_profile = "profile" in options
        self._set = options.get("set", ())
        made = Calibration(options.get("calibration")), Profile(options.get("profile"))
        self.with_set(*made)
        return made

    def with_set(self, calibration: Calibration, profile: Profile) -> tuple[Calibration, Profile]:
        """Both with what set= has on top."""
        return setting_of(calibration, profile, self._set) if self._set else (calibration, profile)

    @staticmethod
    def _view(options: Mapping[str, Any]) -> Any:
        is_raw = bool(options.get("raw", False))
        if is_raw:
            options = {**options, "edge": "both"}
        view = sized("lum_view")
        lib.lum_selection_default(ffi.addressof(view, "selection"))
        _fill_selection(view.selection, options)
        columns = options.get("columns", DEFAULT_COLUMNS)
        if is_raw and not isinstance(columns, str):
            columns = tuple(name for name in columns if name not in RAW_COLUMNS) or NEEDED
        view.columns = _columns(columns) | (_columns(NEEDED) if is_raw else 0)
        view.smooth_window, view.smooth_order = _smooth(options.get("smooth", 0))
        return view

    def _c_members(self, kept: list[Any]) -> Any:
        out = ffi.new("lum_rig_member []", len(self.members))
        kept.append(out)
        for c, sensor in zip(out, self.members):
            of_sensor = sensor.to_c()
            kept.append(of_sensor)
            c.address, c.interface = of_sensor.address, of_sensor.interface
            c.layout, c.calibration, c.pose = of_sensor.layout, of_sensor.calibration, of_sensor.pose
            c.is_left_out = sensor not in self.wanted
        return out

    def framer_options(self, calibration: Calibration, profile: Profile) -> tuple[Any, list[Any]]:
        """For lum_framer_new(), and what has to live as long as it is read."""
        layout, fault = ffi.new("lum_layout *"), ffi.new("lum_profile_fault *")
        if lib.lum_layout_init(layout, profile._to_c(), fault, ffi.NULL) != lib.LUM_OK:
            raise OptionError("the calibration or the profile is out of range")
        geometry = calibration._to_c()
        made = sized("lum_framer_options", layout=layout, calibration=geometry, views=self.view, view_count=1,
                     eyes=self.eyes, drop_incomplete=self.drops_incomplete, threads=self.threads, port=self.port,
                     keeps_raw=self.raw)
        kept = [layout, geometry, self.view]
        if self.sensor is not None:
            kept.append(ffi.new("char[]", self.sensor.interface.encode()))
            made.has_sensor, made.sensor, made.sensor_interface = True, self.sensor.address, kept[-1]
        if self.members:
            made.members, made.member_count = self._c_members(kept), len(self.members)
        if self.range != FrameRange():
            made.has_range, made.frame_first, made.frame_last = True, self.range.first, self.range.last
        return made, kept

