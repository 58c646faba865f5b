"""Types of the package, for type checkers: names that options take, arrays, and the options themselves."""
from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import IO, TYPE_CHECKING, Any, Literal, NewType, Optional, TypedDict, Union

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from typing_extensions import Buffer

    from ._poses import Poses
    from ._rig import Rig
    from ._settings import Calibration, Profile

    # --- Arrays ---

    Array = NDArray[Any]
    Floats = NDArray[np.float32]
    Doubles = NDArray[np.float64]
    Places = Union[slice, NDArray[np.bool_], NDArray[np.integer[Any]], list[bool], list[int]]
    """Which points: a slice, a mask, or places in ascending order."""
    Records = NDArray[np.void]
    """A structured array: array["name"] is a field."""

    # --- What is read ---

    Path = Union[str, os.PathLike[str]]
    Given = Union[Path, Sequence[Path], Buffer, IO[bytes]]
    """What open() takes."""

# --- Names ---

FloatColumn = Literal["x", "y", "z", "range", "azimuth", "elevation", "pulse_width", "time"]
Uint32Column = Literal["line"]
Uint16Column = Literal["pixel", "return_number", "number_of_returns"]
Uint8Column = Literal["eye", "edge", "strongest"]
Int16Column = Literal["raw_azimuth", "raw_elevation"]

Column = Literal[FloatColumn, Uint32Column, Uint16Column, Uint8Column]
"""The name of a column that every frame can have."""

OwnColumn = NewType("OwnColumn", str)
"""The name of a column of one's own, for type checkers, which take no other text: frame[OwnColumn("label")]."""

AnyColumn = Union[Column, Literal["tof", "raw_place", "sensor"], Int16Column, OwnColumn]
"""Also those of raw=True, and that of frames which were joined."""
ImageColumn = Union[AnyColumn, Literal["xyz"]]
DataColumn = Union[Column, Literal["xyz"]]
TableColumn = Union[AnyColumn, Literal["timestamp", "frame", "sensor"]]

Eye = Literal["blue", "green"]
Eyes = Literal["blue", "green", "both"]
Clock = Literal["sensor", "utc"]
Moment = Literal["start", "middle"]
Outside = Literal["nan", "nearest", "raise"]
Filling = Literal["nearest", "farthest", "strongest", "first", "last"]
PictureColour = Literal["range", "height", "pulse_width", "label"]
Preset = Literal["argoverse2"]
Format = Literal["csv", "ply", "pcd", "las", "xyz", "png", "pcap", "pcapng", "mcap", "laz", "parquet", "feather", "npy", "npz", "bin"]

# --- Options ---

Limits = Union[str, tuple[Optional[float], Optional[float]]]
Progress = Callable[[int, int], object]


class PointOptions(TypedDict, total=False):
    """The options that all functions share, each as open() tells, but for columns."""

    returns: Union[Literal["all", "first", "last", "strongest"], int]
    edge: Literal["rising", "falling", "both"]
    eye: Eyes
    port: int
    frames: Union[str, int, tuple[Optional[int], Optional[int]]]
    range: Limits
    box: Union[str, tuple[Limits, Limits, Limits]]
    incomplete: Literal["keep", "drop"]
    smooth: Union[str, int, tuple[int, int]]
    calibration: Union[str, os.PathLike[str], Mapping[str, Any], Calibration]
    set: Union[Mapping[str, Any], Iterable[str]]


class LiveOptions(PointOptions, total=False):
    """The options of frames of a sensor."""

    columns: Union[Literal["all"], Iterable[Column]]


class CaptureOptions(PointOptions, total=False):
    """The options of all that reads captures, but for columns."""

    sensor: str
    rig: Union[str, os.PathLike[str], Mapping[str, Any], Sequence[Mapping[str, Any]], Rig]
    profile: Union[str, os.PathLike[str], Mapping[str, Any], Profile]
    broken: Literal["raise", "warn"]
    threads: Optional[int]


class Options(CaptureOptions, total=False):
    """The options of open(). At run time columns may be a text too, "x,y,z", in which a checker would find no mistake."""

    columns: Union[Literal["all"], Iterable[Column]]
    raw: bool
    progress: Optional[Progress]


class XyzOptions(CaptureOptions, total=False):
    """The options of data sets, which may have the three coordinates as one column."""

    columns: Union[Literal["all"], Iterable[DataColumn]]


class ConvertOptions(CaptureOptions, total=False):
    """The options of convert(), each as it tells."""

    columns: Union[Literal["all"], Iterable[TableColumn]]
    progress: Optional[Progress]
    format: Format
    poses: Union[Poses, str, os.PathLike[str]]
    pose_times: Union[str, os.PathLike[str]]
    to: Literal["world", "start", "middle"]
    time: Literal["sensor", "utc", "arrival"]
    preset: Preset
    compression: Literal["zstd", "snappy", "gzip", "lz4", "none"]
    storage_options: Mapping[str, Any]
    voxel: float
    colour: Literal["range", "height", "pulse_width"]
    size: tuple[int, int]
    ascii: bool
    comments: bool
    organized: bool
    rotate: str
    duration: float
    packets: Literal["lines", "all"]
