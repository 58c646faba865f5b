"""Columns of frames as tables: what each column is, and frames as Arrow tables and data frames."""
from __future__ import annotations

import importlib
import ipaddress
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np

from ._errors import Error, OptionError, install
from ._grid import JOINED
from ._raw import RAW_COLUMNS

if TYPE_CHECKING:
    from ._frame import Frame

Array = np.ndarray[Any, Any]
Names = Union[str, Iterable[str], None]


class Column(NamedTuple):
    """What a column is."""

    dtype: np.dtype[Any]
    unit: str
    """Of its numbers, empty if they have none."""
    description: str


def _column(dtype: str, unit: str, description: str) -> Column:
    return Column(np.dtype(dtype), unit, description)


COLUMNS: Mapping[str, Column] = {
    "x": _column("f4", "m", "forward"),
    "y": _column("f4", "m", "to the left"),
    "z": _column("f4", "m", "up"),
    "range": _column("f4", "m", "distance from the eye"),
    "azimuth": _column("f4", "deg", "of the eye, positive to the left"),
    "elevation": _column("f4", "deg", "of the eye, positive up"),
    "pulse_width": _column("f4", "ns", "of the return; 0 if it is unknown"),
    "timestamp": _column("i8", "us", "of the line: the sensor's clock, or since 1970-01-01 UTC"),
    "frame": _column("i8", "", "number of the frame"),
    "eye": _column("u1", "", "0 blue, 1 green"),
    "line": _column("u4", "", "number of the line within the frame, from the top"),
    "pixel": _column("u2", "", "of the line, 0 to 999"),
    "return_number": _column("u2", "", "from 1, among the returns of the pixel and edge"),
    "number_of_returns": _column("u2", "", "of the pixel and edge"),
    "edge": _column("u1", "", "1 rising, 0 falling"),
    "time": _column("f4", "s", "from the beginning of the frame"),
    "strongest": _column("u1", "", "1 for the widest pulse of its pixel and edge"),
    "sensor": _column("u4", "", "IPv4 address of the sensor as a number, its first part the highest"),
}
"""Every column of a table, with its type, its unit and its meaning."""

FILE_COLUMNS = tuple(COLUMNS)[:15]
"""The columns of a file if none are chosen: those of lumdump."""

_OF_LINES = {"timestamp", "frame", "sensor"}
"""Columns that a frame has for its lines or as a whole, and not for each point."""

OF_RAW: Mapping[str, Column] = {
    "tof": Column(RAW_COLUMNS["tof"], "", "time of flight as sent, in the profile's unit"),
    "raw_azimuth": Column(RAW_COLUMNS["raw_azimuth"], "", "as sent; 32768 would be half the azimuth's width"),
    "raw_elevation": Column(RAW_COLUMNS["raw_elevation"], "", "as sent; 32768 would be half the elevation's range"),
    "raw_place": Column(RAW_COLUMNS["raw_place"], "", "place in the packets of the line, from 0"),
}
"""The columns that frames of open(raw=True) have besides. Files have them if they are named."""

OF_RIG = _column("u1", "", "place in the rig, from 0")
"""The column sensor of frames that were read with a rig."""

TIMES = ("sensor", "utc", "arrival")
"""What can be in the column timestamp, by lumdump's names."""


# --- Names ---


def needed(columns: Sequence[str]) -> list[str]:
    """The columns that frames must have, so that a table can have these."""
    return [name for name in columns if name not in _OF_LINES and name not in OF_RAW]


def available(frame: Frame) -> tuple[str, ...]:
    """The columns that a table of a frame can have, without being asked for more than lumdump's."""
    made = ("frame",) if len(frame) and not len(frame.lines) else ("timestamp", "frame")
    return tuple(dict.fromkeys((*(name for name in COLUMNS if name in frame.columns or name in made), *own_types(frame))))


def own_types(frame: Frame) -> dict[str, np.dtype[Any]]:
    """The columns of a frame besides those that every one has, and their types: those that a program added, raw ones, and, of a
    rig, the place of each point's sensor."""
    own = {name: frame._array(name).dtype for name in (*OF_RAW, *frame._own) if name in frame}
    return {**own, "sensor": OF_RIG.dtype} if frame._info.member else own


def check_names(columns: Names, default: Sequence[str], own: Iterable[str] = ()) -> tuple[str, ...]:
    """Names as the user gives them: a sequence, or one text with commas. own are known besides."""
    if columns is None:
        return tuple(default)
    known = tuple(dict.fromkeys((*COLUMNS, *own)))
    if columns == "all":
        return known
    names = tuple(columns.split(",")) if isinstance(columns, str) else tuple(columns)
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"columns: {name!r} is not a name; give names such as [\"x\", \"range\"]")
        if name in OF_RAW and name not in known:
            raise OptionError(f"columns: '{name}' is of raw frames; read them with raw=True")
        if name not in known:
            raise OptionError(f"columns: '{name}' is not a column; columns are {', '.join(known)}")
        if names.count(name) > 1:
            raise OptionError(f"columns: '{name}' is there twice; give each column once")
    if not names:
        raise OptionError("columns: no column is named; give at least one")
    return names


# --- Values ---


def _line_times(frame: Frame, time: str) -> Array:
    lines = frame.lines
    if time == "arrival":
        if len(lines) and not lines["arrival_ns"].any():
            raise OptionError(f"frame {frame.number} has no times of arrival: give Frame.from_arrays() utc_ns= and use \"utc\", or "
                              "lines= with arrival_ns")
        return np.asarray(lines["arrival_ns"] // 1000)
    clocks = np.asarray(lines["clock_us"])
    if time == "sensor" or not len(clocks):
        return clocks
    if not frame.info["begin_utc_ns"]:
        raise OptionError("time: 'utc' needs packets with a clock, which the profile does not have: use \"arrival\"; or "
                          "Frame.from_arrays() with utc_ns=")
    return np.asarray(clocks - frame.info["begin_clock_us"] + frame.utc_ns // 1000)


def sensor_number(frame: Frame) -> int:
    """The address of the frame's sensor as a number."""
    if "%" in frame.sensor:
        raise OptionError(f"columns: a number cannot distinguish {frame.sensor} from the other sensor with its address: leave out "
                          "the column \"sensor\"")
    return int(ipaddress.IPv4Address(frame.sensor))


def places(frame: Frame) -> Array:
    """The place in the rig of the sensor of each point."""
    if frame._info.member == JOINED:
        return frame["sensor"]
    return np.full(len(frame), frame._info.member - 1, OF_RIG.dtype)


def value(frame: Frame, name: str, time: str = "sensor") -> Array:
    """A column of a frame, without a copy if the frame has it.

    Args:
        frame: the frame.
        name: one of COLUMNS, or a column of one's own.
        time: what the column timestamp is, one of TIMES.

    Raises:
        OptionError: the frame lacks the column.
    """
    if name == "timestamp":
        if len(frame) and not len(frame.lines):
            raise OptionError(f"frame {frame.number} has no lines, which timestamps need: give Frame.from_arrays() the columns line "
                              "and eye, or lines=, or leave out the column timestamp")
        return np.repeat(_line_times(frame, time).astype("i8"), frame.lines["point_count"])
    if name == "frame":
        return np.full(len(frame), frame.number, "i8")
    if name == "sensor" and frame._info.member:
        return places(frame)
    if name == "sensor":
        return np.full(len(frame), sensor_number(frame), "u4")
    if name not in frame.columns:
        raise OptionError(f"frame {frame.number} has no column '{name}', only {', '.join(frame.columns)}; "
                          "name it in the option columns when the source is opened, or choose columns of what is made")
    return frame._array(name)


# --- Presets ---

Preset = Mapping[str, "tuple[np.dtype[Any], str, str, Callable[[Frame], Array]]"]
"""Of each column the type, the unit, what it is, and how it is made."""

INTENSITY_NS = 0.1
"""Nanoseconds of pulse width in a step of an intensity of 8 bits."""

_RINGS = 32
"""Laser numbers of each eye in Argoverse 2."""


def intensity(frame: Frame) -> Array:
    """Pulse widths as intensities from 0 to 255: steps of 0.1 ns; 25.5 ns and more are 255."""
    steps = value(frame, "pulse_width") / np.float32(INTENSITY_NS)
    return np.asarray(np.clip(np.rint(steps), 0, 255).astype("u1"))


def _laser_number(frame: Frame) -> Array:
    lines = value(frame, "line")
    highest = int(np.max(frame.lines["number"])) if len(frame.lines) else 0
    count = 64 if highest < 64 else max(640, highest + 1)
    rings = lines.astype("u8") * _RINGS // count
    return (rings + value(frame, "eye") * np.uint64(_RINGS)).astype("u1")


def _offset_ns(frame: Frame) -> Array:
    offsets = np.rint(value(frame, "time").astype("f8") * 1e9)
    if len(offsets) and offsets.max() > np.iinfo("i4").max:
        raise OptionError(f"frame {frame.number} lasts longer than 2.147 s, which offset_ns of Argoverse 2 cannot hold; "
                          "use another format")
    return offsets.astype("i4")


def _half(name: str) -> Callable[[Frame], Array]:
    return lambda frame: value(frame, name).astype("f2")


PRESETS: Mapping[str, Preset] = {
    "argoverse2": {
        "x": (np.dtype("f2"), "m", "forward", _half("x")),
        "y": (np.dtype("f2"), "m", "to the left", _half("y")),
        "z": (np.dtype("f2"), "m", "up", _half("z")),
        "intensity": (np.dtype("u1"), "0.1 ns", "pulse width; 255 for 25.5 ns and more", intensity),
        "laser_number": (np.dtype("u1"), "", "0 to 31 blue eye from the top, 32 to 63 green eye", _laser_number),
        "offset_ns": (np.dtype("i4"), "ns", "from the beginning of the frame", _offset_ns),
    },
}
"""Columns as data sets have them, by the name of the preset."""

PRESET_NEEDS: Mapping[str, tuple[str, ...]] = {
    "argoverse2": ("x", "y", "z", "pulse_width", "line", "eye", "time"),
}
"""The columns that frames must have for a preset."""


def check_preset(preset: str, columns: Names) -> None:
    """Refuse a preset that is not known, or that comes with columns."""
    if preset not in PRESETS:
        raise OptionError(f"preset: '{preset}' is not a preset; presets are {', '.join(PRESETS)}")
    if columns is not None:
        raise OptionError(f"columns: the preset '{preset}' has its own; leave one of the two out")


class Layout:
    """The columns of a table, and how they are made of a frame."""

    def __init__(self, columns: Sequence[str], preset: str | None = None, time: str = "sensor",
                 own: Mapping[str, np.dtype[Any]] = MappingProxyType({})) -> None:
        self._time = time
        self._preset = PRESETS[preset] if preset is not None else None
        self.columns = tuple(self._preset) if self._preset is not None else tuple(columns)
        self.own = {name: own[name] for name in self.columns if name in own}
        """Its columns of own_types(), and their types."""
        self.needs = PRESET_NEEDS[preset] if preset is not None else tuple(needed(columns))

    def about(self, name: str) -> tuple[np.dtype[Any], str, str]:
        """Type, unit and description of a column."""
        if self._preset is not None:
            return self._preset[name][:3]
        if name in self.own:
            known = {**OF_RAW, "sensor": OF_RIG}
            return known.get(name) or Column(self.own[name], "", "a column of the program that wrote this")
        column = COLUMNS[name]
        if name != "timestamp":
            return column.dtype, column.unit, column.description
        zero = "the sensor's clock" if self._time == "sensor" else "since 1970-01-01 UTC"
        return column.dtype, column.unit, f"of the line: {zero}"

    def values(self, frame: Frame) -> list[Array]:
        """The columns of a frame."""
        if self._preset is not None:
            return [make(frame) for _, _, _, make in self._preset.values()]
        return [value(frame, name, self._time) for name in self.columns]

    def dtype(self) -> np.dtype[Any]:
        """A point as a structured type."""
        return np.dtype([(name, self.about(name)[0]) for name in self.columns])


# --- Arrow and pandas ---


def extra(module: str, name: str) -> Any:
    """A module that an extra of the package installs."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Error(f"{module.split('.')[0]} is missing: {install(name)}") from error


def about_frame(frame: Frame) -> dict[str, Any]:
    """What is known of a frame as a whole, for metadata."""
    return {"number": frame.number, "sensor": str(frame.sensor), "points": len(frame), "utc_ns": frame.utc_ns,
            "utc_error_ns": frame.utc_error_ns, "complete": frame.complete}


def arrow_schema(layout: Layout, metadata: Mapping[str, str]) -> Any:
    """The schema of a table: types, and each field's unit and description as metadata."""
    pa = extra("pyarrow", "parquet")
    fields = []
    for name in layout.columns:
        dtype, unit, description = layout.about(name)
        about = {"unit": unit, "description": description} if unit else {"description": description}
        fields.append(pa.field(name, pa.from_numpy_dtype(dtype), nullable=False, metadata=about))
    return pa.schema(fields, metadata=dict(metadata))


def _arrow_array(column: Array) -> Any:
    pa = extra("pyarrow", "parquet")
    if column.dtype.kind == "b":  # Arrow has bits
        return pa.array(column)
    # The first pa.array() imports pandas, which takes longer than a frame.
    column = np.ascontiguousarray(column)
    return pa.Array.from_buffers(pa.from_numpy_dtype(column.dtype), len(column), [None, pa.py_buffer(column)])


def arrow_batch(layout: Layout, frame: Frame, schema: Any) -> Any:
    """The points of a frame as a record batch."""
    pa = extra("pyarrow", "parquet")
    return pa.record_batch([_arrow_array(column) for column in layout.values(frame)], schema=schema)


def _layout_for(frame: Frame, columns: Names, preset: str | None) -> Layout:
    if preset is not None:
        check_preset(preset, columns)
        return Layout((), preset)
    own = own_types(frame)
    return Layout(check_names(columns, available(frame), own), own=own)


def to_arrow(frame: Frame, columns: Names = None, preset: str | None = None) -> Any:
    """A frame as a pyarrow.Table.

    Columns that lie together in the frame's memory are not copied; the table keeps that memory. Each field has its unit
    and description as metadata; the schema's metadata has the frame as JSON, under "lumsdk.frame".

    Args:
        frame: the frame.
        columns: names; by default those that the frame has, its number and the clock of each point's line (us).
        preset: instead of columns, those of a data set: "argoverse2".

    Raises:
        OptionError: the frame lacks a column, or there is no such column or preset.
        Error: pyarrow is missing.
    """
    pa = extra("pyarrow", "parquet")
    layout = _layout_for(frame, columns, preset)
    schema = arrow_schema(layout, {"lumsdk.frame": json.dumps(about_frame(frame))})
    return pa.Table.from_batches([arrow_batch(layout, frame, schema)])


def to_pandas(frame: Frame, columns: Names = None, preset: str | None = None) -> Any:
    """A frame as a pandas.DataFrame, a row a point.

    Columns are not copied where pandas allows it. `attrs` of the data frame has the frame's number, sensor and time
    under "frame" and the units under "units".

    Args and errors are those of to_arrow(); pandas is needed, and not pyarrow.
    """
    pd = extra("pandas", "pandas")
    layout = _layout_for(frame, columns, preset)
    table = pd.DataFrame(dict(zip(layout.columns, layout.values(frame))), copy=False)
    table.attrs["frame"] = about_frame(frame)
    table.attrs["units"] = {name: layout.about(name)[1] for name in layout.columns}
    return table
