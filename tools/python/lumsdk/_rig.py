"""The rig of a vehicle: its sensors by name, each with its calibration, its profile and its place."""
from __future__ import annotations

import dataclasses
import difflib
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, Optional, Union

import numpy as np
import yaml  # type: ignore[import-untyped,unused-ignore]

from ._c import address_of, ffi, lib, number_of, text
from ._errors import OptionError, UnknownKeyError
from ._keys import Text, quoted
from ._settings import Calibration, Profile, refusal, written
from ._yaml import Reader, content_of

if TYPE_CHECKING:
    Array = np.ndarray[Any, np.dtype[Any]]
    Path = Union[str, os.PathLike[str]]
    Given = Union[Path, Mapping[str, Any], Sequence[Mapping[str, Any]], "Rig"]

_PLACES = ("x_m", "y_m", "z_m")
_ANGLES = ("roll_deg", "pitch_deg", "yaw_deg")
_POSE = tuple(f"pose.{name}" for name in (*_PLACES, *_ANGLES))
_SENSOR = ("name", "address", "interface", "calibration", "profile", *_POSE)
_RIG = ("version", "frame", "sensors")
_FILES = {"calibration": Calibration, "profile": Profile}
_TURN_ERROR = 1e-5
"""What the rows of a rotation may be off from length 1 and from square."""


class _OfC(NamedTuple):
    """A sensor in memory of the library's types."""

    address: int
    interface: Any
    layout: Any
    calibration: Any
    pose: Any


def _pose_of(place: Sequence[int]) -> Any:
    x, y, z, roll, pitch, yaw = (number * 1e-6 for number in place)
    return ffi.new("lum_pose *", lib.lum_pose_of_angles(ffi.new("double [3]", [x, y, z]), roll, pitch, yaw))


@dataclasses.dataclass(frozen=True)
class RigSensor:
    """A sensor of a rig."""

    name: str
    """What it is called: letters, digits and _."""
    address: str
    """Such as "10.42.0.37"."""
    interface: str
    """As the capture names it, such as "eth1"; "": the first of its address."""
    calibration: Calibration
    """By which its points are made."""
    profile: Profile
    """By which its packets are read."""
    pose: Array = dataclasses.field(compare=False)
    """Where it is on the vehicle: (4, 4) float64, which takes points of the sensor, as columns, into the vehicle's frame."""
    place: tuple[int, ...] = dataclasses.field(repr=False)
    """The same as numbers of the file: x, y, z in micrometres, roll, pitch, yaw in microdegrees."""

    def to_c(self) -> _OfC:
        """What the library needs of it, as long as this lives."""
        layout = ffi.new("lum_layout *")
        if lib.lum_layout_init(layout, self.profile._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK:
            raise OptionError(f"the profile of {self.name} is out of range")
        interface = ffi.new("char[]", self.interface.encode(errors="surrogateescape")) if self.interface else ffi.NULL
        return _OfC(number_of(self.address), interface, layout, self.calibration._to_c(), _pose_of(self.place))

    def __str__(self) -> str:
        return self.name + f" ({self.address}" + (f"%{self.interface})" if self.interface else ")")


# --- The rules, which are in C ---


class _Made:
    """A rig that is being set value by value."""

    def __init__(self) -> None:
        self.c = ffi.new("lum_rig *")
        lib.lum_rig_init(self.c)
        self.why = ffi.new("lum_key_refusal *")
        self.files: list[dict[str, Any]] = []

    def set(self, place: Optional[int], key: str, value: str) -> bool:
        """Set a value of the rig, or of a sensor; False: why says what is wrong."""
        # What ends a text in C would hide the rest of it; no rule allows the other character either.
        given = *(part.replace("\0", "\1").encode(errors="surrogateescape") for part in (key, value)), self.why
        if place is None:
            return bool(lib.lum_rig_set(self.c, *given) == lib.LUM_OK)
        return bool(lib.lum_rig_set_sensor(self.c, place, *given) == lib.LUM_OK)

    def check(self) -> bool:
        """Whether all of it goes together; False: why says what is wrong."""
        return bool(lib.lum_rig_check(self.c, self.why) == lib.LUM_OK)


def _allowed(place: Optional[int], key: str) -> str:
    """What a value may be, as the refusal of one that can be none says it."""
    made = _Made()
    made.set(place, key, "\n")
    return text(made.why.text).partition("; allowed: ")[2]


# --- From YAML ---


class _RigReader(Reader):
    """A file of a rig."""

    bytes_max = 1 << 20

    def __init__(self, content: bytes, name: str, made: _Made) -> None:
        self._of_file = {key: Text(key, _allowed(None, key), key == "version") for key in _RIG}
        self._of_sensor = {key: Text(key, _allowed(0, key), key in _POSE) for key in _SENSOR}
        super().__init__(content, name, self._of_file)
        self.made = made
        self.place: Optional[int] = None  # of the sensor that is read
        self.lines: list[dict[str, int]] = []

    def set(self, key: str, value: str) -> None:
        if not self.made.set(self.place, key, value):
            self.fail(text(self.made.why.text))
        if self.place is not None:
            self.lines[-1][key] = self.line
            if key in _FILES:
                self.made.files[-1][key] = value

    def read_scalar(self) -> None:
        if self.known[self.path].is_number:
            super().read_scalar()
            return
        self.set(self.path, self.event.value)

    def read_list(self) -> None:
        if self.place is not None or self.path != "sensors":
            super().read_list()
        self.known, self.path = self._of_sensor, ""
        while not isinstance(self.next(), yaml.SequenceEndEvent):
            self._read_sensor()
        self.known, self.path, self.place, self.prefix = self._of_file, "sensors", None, ""

    def _read_sensor(self) -> None:
        self.line = self.event.start_mark.line + 1
        self.place = len(self.lines)
        self.prefix = f"sensors.{self.place + 1}"
        if self.place >= lib.LUM_RIG_SENSORS_MAX:
            self.fail(f"more than the {lib.LUM_RIG_SENSORS_MAX} that are accepted")
        self.refuse_links()
        if not isinstance(self.event, yaml.MappingStartEvent):
            self.fail("not a mapping of keys")
        self.lines.append({"": self.line})
        self.made.files.append({})
        self.read_mapping()
        if self.made.c.count != len(self.lines):
            self.line = self.lines[-1][""]
            self.fail("has no keys; each sensor needs a name and its address")

    def check(self) -> None:
        """What only the whole tells."""
        if not self.has_version:
            self.line, self.path = 1, "version"
            self.fail("missing; a rig needs 'version: 1'")
        if not self.made.check():
            place, key = self.made.why.place, text(self.made.why.key)
            lines = self.lines[place - 1] if place else {"": 0}
            self.line, self.path = lines.get(key.rpartition(".")[2], lines[""]), key
            self.fail(text(self.made.why.text))
        for place, files in enumerate(self.made.files):
            for key, name in files.items():
                try:
                    files[key] = _FILES[key](os.path.join(os.path.dirname(self.name), name))
                except OptionError as error:
                    self.line, self.path = self.lines[place][key], f"sensors.{place + 1}.{key}"
                    self.fail(str(error))


def _of_file(given: Path) -> _Made:
    made = _Made()
    reader = _RigReader(*content_of(given, _RigReader.bytes_max), made)
    reader.read()
    reader.check()
    return made


# --- From mappings ---


def _refuse(what: str) -> NoReturn:
    raise OptionError(f"the rig: {what}")


def _angles(turn: Array) -> list[float]:
    """Roll, pitch and yaw of a rotation in degrees."""
    pitch = math.asin(min(max(-turn[2, 0], -1.0), 1.0))
    if math.hypot(turn[0, 0], turn[1, 0]) > 1e-9:
        roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    else:  # it looks up or down, and only their sum counts
        roll, yaw = 0.0, math.atan2(-turn[0, 1], turn[1, 1])
    return [math.degrees(angle) for angle in (roll, pitch, yaw)]


def _of_matrix(where: str, given: Any) -> dict[str, Any]:
    """The keys of a pose that is a matrix."""
    try:
        made = np.asarray(given, "f8")
    except (TypeError, ValueError):
        made = np.zeros(0)
    if made.shape != (4, 4) or not np.isfinite(made).all() or (made[3] != (0, 0, 0, 1)).any():
        _refuse(f"{where}: it is not a pose; use a mapping of {', '.join((*_PLACES, *_ANGLES))}, or a (4, 4) array of finite "
                "numbers with 0 0 0 1 in its last row")
    turn = made[:3, :3]
    if np.abs(turn @ turn.T - np.eye(3)).max() > _TURN_ERROR or np.linalg.det(turn) < 0:
        _refuse(f"{where}: the first three columns are not a rotation; use right-handed rows of length "
                "1, square to each other")
    return dict(zip((*_PLACES, *_ANGLES), [*made[:3, 3].tolist(), *_angles(turn)]))


def _number(value: Any) -> Optional[str]:
    """A number of a pose, to its sixth digit behind the point: what is finer is of no use."""
    if isinstance(value, float) or (hasattr(value, "__float__") and not hasattr(value, "__index__")):
        return f"{float(value):.6f}" if math.isfinite(value) else repr(float(value))
    return written(value)


def _flat(where: str, given: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The keys of a sensor, those of its pose with a dot."""
    for key, value in given.items():
        if key != "pose":
            yield key, value
            continue
        pose = value if isinstance(value, Mapping) else _of_matrix(f"{where}.pose", value)
        yield from ((f"pose.{name}", number) for name, number in pose.items())


def _set_file(made: _Made, where: str, key: str, value: Any) -> None:
    if value is None:
        return
    is_path = isinstance(value, (str, os.PathLike)) and "\n" not in os.fsdecode(value)
    if is_path and not made.set(len(made.files) - 1, key, os.fsdecode(value)):
        _refuse(refusal(made.why))
    try:
        made.files[-1][key] = _FILES[key](value)
    except (OptionError, TypeError) as error:
        raise type(error)(f"the rig: {where}.{key}: {error}") from error


def _set_sensor(made: _Made, place: int, given: Any) -> None:
    where = f"sensors.{place + 1}"
    if not isinstance(given, Mapping):
        raise TypeError(f"the rig: {where} is {quoted(repr(given))}; use a mapping of {', '.join(_SENSOR[:5])} and pose")
    made.files.append({})
    files, seen = [], set()
    for key, value in _flat(where, given):
        if not isinstance(key, str):
            raise TypeError(f"the rig: {where}: a key is a text such as 'name', not {type(key).__name__}")
        if key in seen:
            _refuse(f"{where}.{key}: repeated")
        seen.add(key)
        if key in _FILES:
            files.append((key, value))
            continue
        as_text = _number(value) if key in _POSE else written(value)
        if as_text is None:
            raise TypeError(f"the rig: {where}.{key}: a value is a text or a number, not {type(value).__name__}")
        if not made.set(place, key, as_text):
            _refuse(refusal(made.why))
    if made.c.count == place:
        _refuse(f"{where}: has no keys; each sensor needs a name and its address")
    for key, value in files:
        _set_file(made, where, key, value)


def _of_mapping(given: Mapping[str, Any]) -> _Made:
    made = _Made()
    for key, value in given.items():
        if key == "sensors":
            continue
        if isinstance(value, Mapping):
            _refuse(f"{key!r} is not a key of a rig; use {', '.join(_RIG)}; sensors is a list of mappings: "
                    f"[{{'name': {key!r}, ...}}]")
        as_text = written(value)
        if not isinstance(key, str) or as_text is None:
            raise TypeError(f"the rig: {key!r}: use a text such as 'frame', and a text or a number for its value")
        if not made.set(None, key, as_text):
            _refuse(refusal(made.why))
    sensors = given.get("sensors", ())
    if isinstance(sensors, (str, Mapping)) or not isinstance(sensors, Sequence):
        raise TypeError(f"the rig: sensors is of type {type(sensors).__name__}; use a list of mappings")
    if len(sensors) > lib.LUM_RIG_SENSORS_MAX:
        _refuse(f"it has {len(sensors)} sensors; use 1 to {lib.LUM_RIG_SENSORS_MAX}")
    for place, sensor in enumerate(sensors):
        _set_sensor(made, place, sensor)
    if not made.check():
        _refuse(refusal(made.why))
    return made


# --- The rig ---


def _matrix(place: Sequence[int]) -> Array:
    rows = np.zeros((4, 4))
    lib.lum_pose_matrix(_pose_of(place), ffi.cast("double *", ffi.from_buffer(rows)))
    rows[3, 3] = 1.0
    rows.flags.writeable = False
    return rows


def _sensor_of(c: Any, files: Mapping[str, Any]) -> RigSensor:
    place = *c.at_um, c.roll_udeg, c.pitch_udeg, c.yaw_udeg
    return RigSensor(text(c.name), address_of(c.address), text(c.interface), files.get("calibration") or Calibration(),
                     files.get("profile") or Profile(), _matrix(place), place)


class Rig(Mapping[str, RigSensor]):
    """The sensors of a vehicle: a mapping of their names to RigSensor. It does not change.

        rig = lumsdk.Rig("rig.yaml")
        rig = lumsdk.Rig([{"name": "front", "address": "10.42.0.37", "pose": {"x_m": 1.2, "z_m": 1.8}},
                          {"name": "left", "address": "10.42.0.37", "interface": "eth1", "calibration": "left.yaml",
                           "pose": matrix}])
        rig["left"].pose

    It is a path, a text of YAML, a mapping as the file has it, or a list of the sensors alone. In a mapping a pose may also be a
    (4, 4) array, which is rounded to micrometres and microdegrees, and a calibration or a profile may also be a mapping, or a
    Calibration or Profile. docs/formats.md describes the file of a rig.
    """

    _frame: str
    _places: tuple[RigSensor, ...]

    def __init__(self, given: Given) -> None:
        """Read or take a rig.

        Raises:
            OptionError: the file cannot be read, or a value is not allowed, or sensors do not go together.
            TypeError: a value is of a wrong type.
        """
        if isinstance(given, Rig):
            self._frame, self._places = given._frame, given._places
            return
        if isinstance(given, (str, os.PathLike)):
            made = _of_file(given)
        elif isinstance(given, Mapping):
            made = _of_mapping(given)
        elif isinstance(given, Sequence):
            made = _of_mapping({"sensors": given})
        else:
            raise TypeError(f"a rig is a path, a text of YAML, a mapping, a list of mappings or a lumsdk.Rig, not "
                            f"{type(given).__name__}")
        self._frame = text(made.c.frame)
        self._places = tuple(_sensor_of(made.c.sensor[i], made.files[i]) for i in range(made.c.count))

    @property
    def frame(self) -> str:
        """The name of the vehicle's frame, for MCAP and ROS."""
        return self._frame

    def __getitem__(self, name: str) -> RigSensor:
        """A sensor by its name."""
        for sensor in self._places:
            if sensor.name == name:
                return sensor
        near = difflib.get_close_matches(str(name), list(self), 1)
        raise UnknownKeyError(f"the rig has no sensor {name!r}" +
                              (f"; did you mean {near[0]!r}?" if near else f"; it has {', '.join(self)}"))

    def __iter__(self) -> Iterator[str]:
        """The names of its sensors, in the order of the file: their places in the column "sensor"."""
        return (sensor.name for sensor in self._places)

    def __len__(self) -> int:
        return len(self._places)

    def describe(self) -> list[str]:
        """A line for each sensor, as files of points have them."""
        lines = []
        for place, sensor in enumerate(self._places):
            used = [f"{key} {'built-in' if getattr(sensor, key) == kind() else 'its own'}" for key, kind in _FILES.items()]
            x, y, z, roll, pitch, yaw = (f"{number * 1e-6:.6f}" for number in sensor.place)
            at = sensor.address + (f"%{sensor.interface}" if sensor.interface else "")
            lines.append(f"{place}: {sensor.name}, {at}, {', '.join(used)}, at {x} {y} {z} m, roll {roll} pitch {pitch} yaw {yaw} deg")
        return lines

    def to_yaml(self, files: Optional[Mapping[tuple[str, str], str]] = None) -> str:
        """As the text of a YAML file, which reads back exactly.

        Args:
            files: of (name, "calibration") and (name, "profile"), the paths of files that have them. Values that are not the
                default need one; save() writes them.
        """
        lines = ["version: 1", f"frame: {self._frame}", "sensors:"]
        for sensor in self._places:
            keys = [f"name: {sensor.name}", f"address: {sensor.address}"]
            keys += [f"interface: {_quoted(sensor.interface)}"] if sensor.interface else []
            for key, kind in _FILES.items():
                path = (files or {}).get((sensor.name, key))
                if path is not None:
                    keys.append(f"{key}: {_quoted(path)}")
                elif getattr(sensor, key) != kind():
                    raise OptionError(f"the {key} of {sensor.name} is not the default, and needs a file: name it in files=, or write "
                                      "all of it by save()")
            pose = [f"{name}: {_micro(n)}" for name, n in zip((*_PLACES, *_ANGLES), sensor.place) if n]
            keys += [f"pose: {{{', '.join(pose)}}}"] if pose else []
            lines.append(f"  - {{{', '.join(keys)}}}")
        return "\n".join(lines) + "\n"

    def save(self, path: Path) -> None:
        """Write it as a YAML file such as rig.yaml, and beside it rig-NAME-calibration.yaml and rig-NAME-profile.yaml of what is
        not the default."""
        folder, files = os.path.dirname(os.path.abspath(path)), {}
        stem = os.path.splitext(os.path.basename(os.fsdecode(path)))[0]
        for sensor in self._places:
            for key, kind in _FILES.items():
                value = getattr(sensor, key)
                if value != kind():
                    files[sensor.name, key] = f"{stem}-{sensor.name}-{key}.yaml"
                    with open(os.path.join(folder, files[sensor.name, key]), "w", encoding="utf-8") as file:
                        file.write(value.to_yaml())
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.to_yaml(files))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Rig) and (self._frame, self._places) == (other._frame, other._places)

    def __hash__(self) -> int:
        return hash((self._frame, self._places))

    def __repr__(self) -> str:
        return f"<Rig {', '.join(map(str, self._places))}>"

    def __reduce__(self) -> tuple[Any, ...]:
        sensors = [{"name": s.name, "address": s.address, **({"interface": s.interface} if s.interface else {}),
                    "calibration": s.calibration, "profile": s.profile,
                    "pose": {key: _micro(n) for key, n in zip((*_PLACES, *_ANGLES), s.place)}} for s in self._places]
        return Rig, ({"frame": self._frame, "sensors": sensors},)


def _micro(number: int) -> str:
    """Millionths as a decimal number."""
    return f"{'-' if number < 0 else ''}{abs(number) // 10 ** 6}.{abs(number) % 10 ** 6:06d}".rstrip("0").rstrip(".")


def _quoted(value: str) -> str:
    """A text as YAML has it between quotes."""
    return "'" + value.replace("'", "''") + "'"
