"""Captures as a Ray Dataset: every frame is read by one machine of a cluster, and no machine holds a whole capture.

    import lumsdk.ray

    points = lumsdk.ray.read_captures("s3://drives/2026-11/", columns=["x", "y", "z", "range"])
    points.write_parquet("s3://points/")

Needs Ray 2.51 or later and pyarrow: pip install '.[ray]' in a clone.
"""
from __future__ import annotations

import fnmatch
import glob
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Union

import numpy as np

from ._errors import install

try:
    import pyarrow
    import pyarrow.fs
    import ray.data
    from ray.data.block import Block, BlockMetadata
    from ray.data.datasource import FileBasedDatasource
    from ray.data.datasource.file_meta_provider import DefaultFileMetadataProvider
except ImportError as error:
    raise ImportError(f"lumsdk.ray needs Ray and pyarrow, and one of them is missing ({error}): {install('ray')}") from error

import lumsdk

from ._errors import OptionError
from ._inputs import ENDINGS
from ._options import Choice, columns_of, data_columns

if TYPE_CHECKING:
    from typing_extensions import Literal, Unpack

    from ._frame import Frame
    from ._types import DataColumn, XyzOptions

    Paths = Union[str, os.PathLike[str], Sequence[Union[str, os.PathLike[str]]]]

__all__ = ["read_captures"]

_KEYS = ("source", "frame", "sensor", "utc")
_UTC = pyarrow.timestamp("ns", "UTC")

# What is read of the start of some captures, to learn how many bytes of blocks come of one of a capture.
_SAMPLES = 3
_SAMPLE_BYTES = 24_000_000
_SAMPLE_FRAMES = 12
_BUFFER_BYTES = 1 << 20


class _Stream:
    """A stream of bytes with a name, which counts what was read of it and keeps why it failed."""

    def __init__(self, file: Any, name: str) -> None:
        self.file, self.name, self.count = file, name, 0
        self.problem: Optional[BaseException] = None

    def read(self, size: int) -> bytes:
        """As that of a binary file."""
        try:
            got: bytes = self.file.read(size)
        except BaseException as problem:
            self.problem = problem
            raise
        self.count += len(got)
        return got


def _frames(stream: _Stream, options: Mapping[str, Any]) -> Iterator[Frame]:
    """The frames of a stream, the same in each attempt.

    Where a stream fails, the library still gives what had come of the last frames. These are kept back: Ray reads again
    and leaves out as many blocks as it had, and must not take a part of a frame for the frame.
    """
    with lumsdk.open(stream, **options) as source:  # type: ignore[arg-type]
        for frame in source:
            if stream.problem is not None:
                raise stream.problem
            yield frame


class _Form(NamedTuple):
    """What a block looks like."""

    columns: tuple[DataColumn, ...]
    keys: tuple[str, ...]
    whole: bool  # a row is a frame, and not a point

    def table(self, frame: Frame, source: str) -> Block:
        """The block of a frame."""
        values = {"source": pyarrow.array([source]), "frame": pyarrow.array([frame.number], pyarrow.int64()),
                  "sensor": pyarrow.array([frame.sensor]), "utc": pyarrow.array([frame.utc_ns], _UTC)}
        keys = {name: values[name] for name in self.keys}
        return self._of_frame(frame, keys) if self.whole else self._of_points(frame, keys)

    def _of_points(self, frame: Frame, keys: dict[str, Any]) -> Block:
        # a value for all points takes 4 bytes of each if it is a text, since it is one entry of a dictionary
        same = np.zeros(len(frame), "i4")
        repeated = {name: pyarrow.DictionaryArray.from_arrays(same, one) if pyarrow.types.is_string(one.type)
                    else one.take(pyarrow.array(same)) for name, one in keys.items()}
        columns: dict[str, Any] = {name: pyarrow.array(_array(frame, name)) for name in self.columns}
        return pyarrow.table({**repeated, **columns})

    def _of_frame(self, frame: Frame, keys: dict[str, Any]) -> Block:
        from ray.data.extensions import ArrowVariableShapedTensorArray

        made = {"complete": pyarrow.array([frame.complete]), "points": pyarrow.array([len(frame)], pyarrow.int64())}
        for name in self.columns:
            array = np.ascontiguousarray(_array(frame, name))
            made[name] = ArrowVariableShapedTensorArray.from_numpy(_one(array))
        return pyarrow.table({**keys, **made})


def _array(frame: Frame, name: DataColumn) -> Any:
    return frame.xyz if name == "xyz" else frame[name]


def _one(array: Any) -> Any:
    """An array as the only element of an array of objects."""
    made = np.empty(1, object)
    made[0] = array
    return made


class _Metadata(DefaultFileMetadataProvider):
    """The sizes of blocks, by those of their captures."""

    def __init__(self, ratio: float) -> None:
        super().__init__()
        self.ratio = ratio

    def _get_block_metadata(self, *given: Any, **known: Any) -> BlockMetadata:
        known["file_sizes"] = [None if size is None else int(size * self.ratio) for size in known["file_sizes"]]
        return super()._get_block_metadata(*given, **known)


class _Captures(FileBasedDatasource):
    """Frames of captures as blocks."""

    def __init__(self, paths: list[str], form: _Form, options: Mapping[str, Any], **others: Any) -> None:
        super().__init__(paths, **others)
        self._form = form
        self._options = dict(options)
        self._ratio: Optional[float] = None

    def get_name(self) -> str:
        """As Ray shows it."""
        return "Captures"

    def resolve_compression(self, path: str, open_args: dict[str, Any]) -> Optional[str]:
        """None: the library unpacks, and says in lumdump's words what is wrong."""
        return None

    def _resolve_buffer_size(self, open_args: dict[str, Any]) -> Optional[int]:
        size: Optional[int] = open_args.pop("buffer_size", None)
        return _BUFFER_BYTES if size is None else size

    def _open_stream(self, path: str) -> Any:
        return self._filesystem.open_input_stream(path, buffer_size=_BUFFER_BYTES, compression=None)

    def _read_stream(self, f: Any, path: str) -> Iterator[Block]:
        # Not f: where an attempt failed, some versions of Ray give it again as it stands, and what was read is lost.
        with self._open_stream(path) as file:
            for frame in _frames(_Stream(file, path), self._options):
                yield self._form.table(frame, path)

    def _sample(self, path: str) -> tuple[int, int]:
        """Bytes of a capture, and of the blocks made of them; (0, 0) if it is not readable: reading it will say why."""
        taken: list[tuple[int, int]] = []
        size = 0
        try:
            with self._open_stream(path) as file:
                stream = _Stream(file, path)
                for frame in _frames(stream, self._options):
                    size += self._form.table(frame, path).nbytes
                    taken.append((stream.count, size))
                    if len(taken) >= _SAMPLE_FRAMES or stream.count > _SAMPLE_BYTES:
                        break
                else:
                    return stream.count, size
        except (OSError, lumsdk.Error):
            pass
        # What is read is ahead of the frames, by as much after the first frame as after the last.
        read, made = (last - first for first, last in zip(taken[0], taken[-1])) if taken else (0, 0)
        return (read, made) if read > 0 else taken[-1] if taken else (0, 0)

    def _find_ratio(self) -> float:
        """Bytes of blocks for each byte of a capture."""
        if self._ratio is None:
            sized = sorted((size, path) for size, path in zip(self._file_sizes(), self._paths()) if size)
            at = sorted({len(sized) * k // (2 * _SAMPLES) for k in range(1, 2 * _SAMPLES, 2)}) if sized else []
            read, made = (sum(part) for part in zip(*(self._sample(sized[i][1]) for i in at))) if at else (0, 0)
            self._ratio = made / read if read else 1.0
        return self._ratio

    def estimate_inmemory_data_size(self) -> Optional[int]:
        """Bytes of all blocks, by samples of the captures."""
        sizes = [size for size in self._file_sizes() if size is not None]
        return int(sum(sizes) * self._find_ratio())

    def get_read_tasks(self, *arguments: Any, **others: Any) -> Any:
        """As many tasks as asked for, or as there are captures, with the sizes that their blocks have."""
        self._meta_provider = _Metadata(self._find_ratio())
        return super().get_read_tasks(*arguments, **others)


def _match(path: str, filesystem: Any) -> list[str]:
    """The paths that a pattern means."""
    if filesystem is None and "://" not in path:
        return [path] if os.path.exists(path) else sorted(glob.glob(path, recursive=True))
    if filesystem is not None and hasattr(filesystem, "glob"):  # fsspec's
        return sorted(filesystem.glob(path))
    begin = "".join(path[:min(path.index(mark) for mark in "*?[" if mark in path)].rpartition("/")[:2])
    folder, wanted = begin.rstrip("/") or begin, path[len(begin):]
    where, inside = (filesystem, folder) if filesystem is not None else pyarrow.fs.FileSystem.from_uri(folder)
    found = where.get_file_info(pyarrow.fs.FileSelector(inside, recursive=True, allow_not_found=True))
    names = [info.path[len(inside):].lstrip("/") for info in found if info.is_file]
    depth = None if "**" in wanted else wanted.count("/")
    return sorted(begin + name for name in names if fnmatch.fnmatchcase(name, wanted) and depth in (None, name.count("/")))


def _expand(given: Any, filesystem: Any) -> list[str]:
    """Paths without patterns."""
    if isinstance(given, (str, os.PathLike)):
        given = [given]
    if not isinstance(given, Iterable) or isinstance(given, (bytes, bytearray)):
        raise TypeError(f"paths is of type {type(given).__name__}; use a path, a folder, a pattern such as "
                        '"drives/*.pcap", a URL such as "s3://bucket/drives/", or a list of these')
    paths: list[str] = []
    for one in given:
        path = os.fspath(one)
        if not isinstance(path, str):
            raise TypeError(f"a path is {one!r}; use a text or a pathlib.Path")
        found = _match(path, filesystem) if any(mark in path for mark in "*?[") else [path]
        if not found:
            raise lumsdk.CaptureError(f"{path}: no file has such a name")
        paths += found
    if not paths:
        raise lumsdk.CaptureError("no capture is named")
    # Some versions of Ray take a second URL of a list for a path.
    return [pyarrow.fs.FileSystem.from_uri(path)[1] if filesystem is None and path.startswith("file://") else path for path in paths]


def _is_capture(named: Sequence[str]) -> Callable[[Sequence[str]], list[str]]:
    """Of the files of folders, those that are captures by their names; others only if they were named."""
    files = tuple(name.partition("://")[2] or name for name in named)

    def keep(paths: Sequence[str]) -> list[str]:
        return [path for path in paths if ENDINGS.search(path)
                or any(path == name or path.endswith("/" + name.lstrip("./")) for name in files)]
    return keep


def _portable(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options for every machine: files of this one become their content."""
    if options.get("progress") is not None:
        raise TypeError("progress is not an option here: Ray shows the progress of a Dataset")
    choice = Choice(options)
    made = dict(choice.given)
    if made.get("threads") is None:
        made["threads"] = 1  # Ray gives each task a core
    if choice.names_calibration:
        made["calibration"] = choice.calibration
    if choice.names_profile:
        made["profile"] = choice.profile
    if choice.rig is not None:
        made["rig"] = choice.rig
    return made


def read_captures(paths: Paths, *, rows: Literal["points", "frames"] = "points", keys: Iterable[str] = ("source", "frame"),
                  filesystem: Any = None, shuffle: Any = None, ignore_missing_paths: bool = False,
                  override_num_blocks: Optional[int] = None, concurrency: Optional[int] = None,
                  ray_remote_args: Optional[dict[str, Any]] = None, **options: Unpack[XyzOptions]) -> ray.data.Dataset:
    """A Dataset of the points or the frames of captures.

    paths is a path, a folder, a pattern, a URL, or a list of these; of a folder, what ends in .pcap, .pcapng or .cap, also
    with .gz or .zst, is read. Every machine that reads must reach them: a local path is one of each machine's own.
    filesystem is one of pyarrow.fs or of fsspec; without it, a URL says which.

    rows="points": one row a point, with the columns asked for, of the types that lumsdk.COLUMNS tells.
    rows="frames": one row a frame: complete (bool), points (int64), and for each column a tensor, (points,), or "xyz",
    (points, 3). In a row or a batch it is a NumPy array.

    keys are added to every row, of "source" (the path, as the file system names it), "frame" (its number, int64),
    "sensor" (its address, or its name in the rig) and "utc" (its begin, in nanoseconds). Of points, the texts are dictionaries
    of Arrow.

    The options are those of lumsdk.open(), such as columns, without progress. A calibration, a profile or a rig named by a
    path is read here, once. shuffle, ignore_missing_paths, override_num_blocks, concurrency and ray_remote_args are those of
    Ray's own functions.

    A block is a frame, made while it is read; a capture is read by one task, a megabyte or so at a time. If a task or its machine
    is lost, its blocks are made again, the same bit by bit. A capture that cannot be read makes the Dataset raise lumsdk.CaptureError
    with lumdump's sentence; with broken="warn", one that breaks off gives what could be read.

    Raises lumsdk.OptionError, TypeError or lumsdk.CaptureError here, for what is wrong before any capture is read.
    """
    if rows not in ("points", "frames"):
        raise OptionError(f'rows is {rows!r}; use "points" or "frames"')
    added = (keys,) if isinstance(keys, str) else tuple(keys)
    for key in added:
        if key not in _KEYS:
            raise OptionError(f"keys has {key!r}; use some of {', '.join(_KEYS)}")
    form = _Form(data_columns(options.get("columns"), rows == "frames"), tuple(dict.fromkeys(added)), rows == "frames")
    portable = _portable({**options, "columns": columns_of(form.columns)})
    named = _expand(paths, filesystem)
    source = _Captures(named, form, portable, filesystem=filesystem, shuffle=shuffle,
                       partition_filter=_is_capture(named), ignore_missing_paths=ignore_missing_paths)
    made: ray.data.Dataset = ray.data.read_datasource(source, override_num_blocks=override_num_blocks, concurrency=concurrency,
                                                      ray_remote_args=ray_remote_args)
    return made
