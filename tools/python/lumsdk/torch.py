"""Captures as data sets of torch: a frame is an item, and workers read frames without reading those before them.

    from lumsdk.torch import Frames, collate

    frames = Frames("drives/*.pcap", columns=["xyz", "range"], keep_index=True)
    for batch in DataLoader(frames, batch_size=4, shuffle=True, num_workers=2, collate_fn=collate):
        use(batch["xyz"], batch["row_splits"])

Needs torch: pip install '.[torch]' in a clone.
"""
from __future__ import annotations

import bisect
import glob
import itertools
import os
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Optional, TypeVar, Union, overload

import numpy as np

from ._columns import COLUMNS
from ._errors import CaptureError, Error, OptionError, install, warn
from ._inputs import _is_url, check_storage
from ._options import Choice, columns_of, data_columns
from ._source import Source, open

try:
    import torch as _torch
    from torch.utils.data import Dataset, IterableDataset, get_worker_info  # pyright: ignore[reportMissingImports]
except ImportError as error:
    raise ImportError(f"lumsdk.torch needs torch, which is missing ({error}): {install('torch')}") from error

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._frame import Frame
    from ._types import DataColumn, Path, XyzOptions

    Captures = Union[Path, Sequence[Union[Path, Sequence[Path]]]]
    Sample = dict[str, Any]

__all__ = ["Frames", "Place", "StreamedFrames", "collate", "collate_padded", "tensors"]

torch: Any = _torch  # checkers need not have it

_T = TypeVar("_T")
_Made = TypeVar("_Made")
_OPEN = 16
_WIDER = {"uint16": ("int32", "i4"), "uint32": ("int64", "i8")}
_OF_BATCHES = ("batch", "row_splits", "mask")


# --- Frames as tensors ---


def _lacking(columns: Iterable[str]) -> list[str]:
    """The types of columns that this version of torch does not have."""
    types = {COLUMNS[name].name for name in columns if name in COLUMNS}
    return sorted(name for name in types & {*_WIDER} if not hasattr(torch, name))


def _tensor(array: Any) -> Any:
    if array.dtype.name in _WIDER and not hasattr(torch, array.dtype.name):
        array = array.astype(_WIDER[array.dtype.name][1])
    return torch.from_numpy(array)


def tensors(frame: Frame, columns: Optional[Iterable[DataColumn]] = None) -> Sample:
    """The columns of a frame as tensors, by their names, in the memory of the frame.

    Args:
        frame: the frame.
        columns: names, also "xyz", (n, 3); without them, those of the frame.

    Where torch has no uint16 or uint32, as before 2.3, these become int32 and int64, which are copies.
    """
    names = frame.columns if columns is None else tuple(columns)
    return {name: _tensor(frame.xyz if name == "xyz" else frame[name]) for name in names}


# --- Captures ---


class Place(NamedTuple):
    """Where an item comes from."""

    capture: str
    """The name of the capture."""
    frame: int
    """Its place in it, from 0 on."""


def _one(given: Any) -> list[Any]:
    """The captures that a path, a pattern or a URL means; a list of these is one capture in several files."""
    if isinstance(given, (list, tuple)):
        if not given:
            raise OptionError("a capture is an empty list; give the list of its files")
        return [[part for each in given for part in _one(each)]]
    if not isinstance(given, (str, os.PathLike)):
        raise TypeError(f"a capture is given as {type(given).__name__}; use a path, a pattern such as \"drives/*.pcap\", a "
                        "URL, or a list of the files of one capture")
    name = os.fsdecode(given)
    if _is_url(name):
        return [name]
    if not glob.has_magic(name) or os.path.lexists(name):
        return [os.path.abspath(name)]
    found = sorted(glob.glob(name, recursive=True))
    if not found:
        raise CaptureError(f"{name}: no file has such a name")
    return [os.path.abspath(path) for path in found]


def _expand(given: Any) -> list[Any]:
    several = given if isinstance(given, (list, tuple)) else [given]
    made = [capture for each in several for capture in _one(each)]
    if not made:
        raise OptionError("no capture is named; use a path, a pattern, a URL, or a list of these")
    return made


class _Captures(Generic[_T]):
    """What both data sets share: captures, how they are read, and how many frames each has."""

    def __init__(self, captures: Any, transform: Optional[Callable[[Frame], Any]], keep_index: bool,
                 storage_options: Optional[Mapping[str, Any]], options: Mapping[str, Any]) -> None:
        if options.get("progress") is not None:
            raise TypeError("progress is not an option here: workers read the captures")
        if transform is not None and not callable(transform):
            raise TypeError(f"transform is {transform!r}; use a function of a lumsdk.Frame")
        self._given = _expand(captures)
        self._columns = data_columns(options.get("columns"), True)
        self._options: dict[str, Any] = dict(Choice({**options, "columns": columns_of(self._columns)}).to_give())
        self._storage = check_storage(storage_options)
        self._transform, self._keeps = transform, keep_index
        self._counts: list[Optional[int]] = [None] * len(self._given)
        self._sources: OrderedDict[int, Source] = OrderedDict()
        lacking = _lacking(self._columns) if transform is None else []
        if lacking:
            warn(f"torch {torch.__version__} has no {' and no '.join(lacking)}: columns of these types become "
                 f"{' and '.join(_WIDER[name][0] for name in lacking)}, which are copies; torch has both from 2.3 on", UserWarning)

    @property
    def captures(self) -> tuple[str, ...]:
        """The names of the captures, in their order; of one in several files, the first."""
        return tuple(each if isinstance(each, str) else each[0] for each in self._given)

    @property
    def counts(self) -> tuple[int, ...]:
        """How many frames each capture has. Captures whose frames are not known yet are read once for that."""
        return tuple(self._count(i) for i in range(len(self._given)))

    def _open(self, capture: int) -> Source:
        """A source of one's own. A worker has its core for itself alone."""
        options: dict[str, Any] = {**({} if get_worker_info() is None else {"threads": 1}), **self._options}
        given = self._given[capture]
        storage = self._storage if _is_url(given) else None
        return open(given, storage_options=storage or None, **options)

    def _source(self, capture: int) -> Source:
        """The source of a capture. The latest few are kept open."""
        source = self._sources.pop(capture, None) or self._open(capture)
        self._sources[capture] = source
        if len(self._sources) > _OPEN:
            self._sources.popitem(last=False)[1].close()
        return source

    def _count(self, capture: int) -> int:
        found = self._counts[capture]
        if found is None:
            found = self._source(capture).index(keep=self._keeps)
            self._counts[capture] = found
            if not found:
                warn(f"{self.captures[capture]}: it has no frame, so it gives no item")
        return found

    def _item(self, frame: Frame, capture: int, place: int) -> Any:
        if self._transform is None:
            return {**tensors(frame, self._columns), "capture": capture, "frame": place, "utc_ns": frame.utc_ns}
        try:
            return self._transform(frame)
        except Exception as problem:
            raise Error(f"{self.captures[capture]}: frame {place}: the transform failed: {type(problem).__name__}: {problem}"
                        ) from problem

    def __getstate__(self) -> dict[str, Any]:
        """Each process opens the captures for itself."""
        return {**self.__dict__, "_sources": OrderedDict()}


class Frames(_Captures[_T], Dataset[_T]):  # type: ignore[misc,unused-ignore]
    """The frames of captures as a map-style data set: frames[i], len(frames).

    An item is a dictionary: the columns as tensors, those of open() with "xyz", (n, 3), in place of x, y and z, and the numbers
    "capture", "frame" (places, from 0 on) and "utc_ns". With a transform it is what that makes of a lumsdk.Frame.

    It can be pickled and used by workers, forked or spawned: each process opens the captures for itself. To find a frame, a
    process has to know where frames begin: a capture is read once for that by each process that uses it, or by none after
    keep_index wrote it beside the capture.
    """

    @overload
    def __init__(self: Frames[Sample], captures: Captures, *, transform: None = None, keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None: ...
    @overload
    def __init__(self: Frames[_Made], captures: Captures, *, transform: Callable[[Frame], _Made], keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None: ...

    def __init__(self, captures: Captures, *, transform: Optional[Callable[[Frame], Any]] = None, keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None:
        """Name the captures. They are opened when they are needed.

        Args:
            captures: a path, a pattern, a URL, or a list of these; each file is a capture. A list in the list is one capture in
                several files.
            transform: a function that makes an item of a frame; to spawned workers go only functions that can be pickled.
            keep_index: write what was found of a capture beside it, as Source.index(keep=True) does.
            storage_options: as open() takes them, for URLs.
            options: those of open(), except progress; columns can have "xyz". In a worker threads is 1 if not given.

        Raises:
            CaptureError: a pattern that no file has.
            OptionError, TypeError: an option is not allowed.
        """
        super().__init__(captures, transform, keep_index, storage_options, options)
        self._ends: Optional[list[int]] = None

    def _known_ends(self) -> list[int]:
        if self._ends is None:
            self._ends = list(itertools.accumulate(self.counts))
        return self._ends

    def __len__(self) -> int:
        """How many frames all captures have. A capture that breaks off raises CaptureError, unless broken="warn"."""
        return self._known_ends()[-1]

    def place(self, index: int) -> Place:
        """Where an item comes from."""
        capture, frame = self._locate(index)
        return Place(self.captures[capture], frame)

    def _locate(self, index: int) -> tuple[int, int]:
        ends = self._known_ends()
        found = index + ends[-1] if index < 0 else index
        if not 0 <= found < ends[-1]:
            raise IndexError(f"there is no item {index}: the captures have {ends[-1]} frames")
        capture = bisect.bisect_right(ends, found)
        return capture, found - (ends[capture - 1] if capture else 0)

    def __getitem__(self, index: int) -> _T:
        """An item by its place in all captures."""
        made: _T = self._read(*self._locate(index))
        return made

    def at(self, capture: Union[int, str], frame: int) -> _T:
        """An item by its capture, a place in captures or a name in it, and its frame's place, which may be below 0."""
        if isinstance(capture, str):
            names = [name for name in self.captures if capture in (name, os.path.relpath(name) if not _is_url(name) else name)]
            if not names:
                raise OptionError(f"there is no capture {capture!r}; captures are {', '.join(self.captures)}")
            capture = self.captures.index(names[0])
        elif not -len(self._given) <= capture < len(self._given):
            raise IndexError(f"there is no capture {capture}: there are {len(self._given)}")
        made: _T = self._read(capture % len(self._given), frame)
        return made

    def _read(self, capture: int, frame: int) -> Any:
        place = frame + self._count(capture) if frame < 0 else frame
        if place < 0:
            raise IndexError(f"{self.captures[capture]}: there is no frame {frame}: it has {self._count(capture)}")
        return self._item(self._source(capture)[place], capture, place)


def _ranks() -> tuple[int, int]:
    """The rank of this process and how many there are, as torch.distributed knows it."""
    if torch.distributed.is_available() and torch.distributed.is_initialized():
        return torch.distributed.get_rank(), torch.distributed.get_world_size()
    return 0, 1


class StreamedFrames(_Captures[_T], IterableDataset[_T]):  # type: ignore[misc,unused-ignore]
    """The frames of captures in their order, as an iterable data set. Items are those of Frames.

    Workers divide the captures among them, and so do the processes of torch.distributed if it was initialized before this object
    was made. If there are fewer captures than workers, each reads a part of all frames, whose number has to be found first, as
    Frames does. The parts differ: by a frame, or by whole captures.
    """

    @overload
    def __init__(self: StreamedFrames[Sample], captures: Captures, *, transform: None = None, keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None: ...
    @overload
    def __init__(self: StreamedFrames[_Made], captures: Captures, *, transform: Callable[[Frame], _Made], keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None: ...

    def __init__(self, captures: Captures, *, transform: Optional[Callable[[Frame], Any]] = None, keep_index: bool = False,
                 storage_options: Optional[Mapping[str, Any]] = None, **options: Unpack[XyzOptions]) -> None:
        """Arguments and errors are those of Frames."""
        super().__init__(captures, transform, keep_index, storage_options, options)
        self._rank, self._world = _ranks()

    def _shard(self) -> tuple[int, int]:
        worker = get_worker_info()
        of, number = (0, 1) if worker is None else (worker.id, worker.num_workers)
        return self._rank * number + of, self._world * number

    def _parts(self) -> Iterator[tuple[int, int, Optional[int]]]:
        """Captures, and which of their frames: from the first to before the last; None: all."""
        shard, shards = self._shard()
        if len(self._given) >= shards:
            yield from ((capture, 0, None) for capture in range(shard, len(self._given), shards))
            return
        counts = self.counts
        begin, end = (sum(counts) * k // shards for k in (shard, shard + 1))
        for capture, count in enumerate(counts):
            if begin < count and end > 0:
                yield capture, max(begin, 0), min(end, count)
            begin, end = begin - count, end - count

    def __iter__(self) -> Iterator[_T]:
        """The frames that are for this process."""
        for capture, first, last in self._parts():
            with self._open(capture) as source:
                place = first
                for frame in source if last is None else source[first:last]:
                    yield self._item(frame, capture, place)
                    place += 1
                if last is None and not place:
                    warn(f"{self.captures[capture]}: it has no frame, so it gives no item")


# --- Batches ---


def _checked(samples: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[str], list[int]]:
    """Names of what a point has and of what a frame has, and how many points each frame has."""
    if not samples or not all(isinstance(sample, Mapping) for sample in samples):
        raise TypeError("collate takes items that are dictionaries, as Frames without a transform gives them")
    names = list(samples[0])
    points = [name for name in names if isinstance(samples[0][name], torch.Tensor) and samples[0][name].dim()]
    if any(list(sample) != names for sample in samples):
        raise ValueError(f"items have other names than the first, {', '.join(names)}; use the same names in all")
    for name in _OF_BATCHES:
        if name in names:
            raise ValueError(f"items have {name!r}, which a batch adds; use another name")
    if not points:
        raise ValueError(f"of {', '.join(names)} none is a tensor of the points; give at least one of (n,) or (n, ...)")
    counts = [len(sample[points[0]]) for sample in samples]
    for sample, count in zip(samples, counts):
        for name in points:
            if len(sample[name]) != count:
                raise ValueError(f"{name!r} has {len(sample[name])} rows and {points[0]!r} has {count}; use a row a point, "
                                 "and for what a frame has as a whole a number or a tensor without dimensions")
    return points, [name for name in names if name not in points], counts


def collate(samples: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Items as a batch: the points of all frames one behind the other. For a DataLoader's collate_fn.

    Tensors of the points are joined, and numbers of each frame become a tensor, (frames,). Added are "batch", the place of each
    point's frame in the batch, int64, and "row_splits", where frames begin and end: frame i has the points from row_splits[i] to
    before row_splits[i + 1].
    """
    points, whole, counts = _checked(samples)
    made: dict[str, Any] = {name: torch.cat([sample[name] for sample in samples]) for name in points}
    made.update((name, torch.tensor([sample[name] for sample in samples])) for name in whole)
    lengths = torch.tensor(counts)
    made["batch"] = torch.repeat_interleave(torch.arange(len(counts)), lengths)
    made["row_splits"] = torch.tensor([0, *itertools.accumulate(counts)])
    return made


def collate_padded(samples: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Items as a batch: tensors of (frames, most points of a frame, ...), 0 where a frame has fewer points.

    Added is "mask", (frames, most points), which is True for points. Numbers of each frame are as collate() gives them.
    """
    points, whole, counts = _checked(samples)
    most = max(counts)
    made: dict[str, Any] = {}
    for name in points:
        first = samples[0][name]
        made[name] = torch.zeros((len(samples), most, *first.shape[1:]), dtype=first.dtype)
        for row, sample in zip(made[name], samples):
            row[:len(sample[name])] = sample[name]
    made.update((name, torch.tensor([sample[name] for sample in samples])) for name in whole)
    made["mask"] = torch.from_numpy(np.arange(most) < np.array(counts)[:, None])
    return made
