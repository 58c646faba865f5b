"""convert(): captures and frames into files of other formats."""
from __future__ import annotations

import contextlib
import itertools
import os
import queue
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _lumdump
from ._by_lumdump import FOREIGN, by_lumdump
from ._c import LOSSES, VERSION
from ._errors import Error, OptionError
from ._formats import WRITERS, About, AnyTarget, Job, Writer
from ._frame import Frame
from ._grid import JOINED
from ._points_file import FORMATS, OF_MESSAGES, Messages, PointsFile
from ._poses import Motion, Poses
from ._settings import Calibration, Profile
from ._source import Source, open
from ._plan import APPLIES, OF_TABLES, Plan, Summary, name_for
from ._sync import check_frame
from ._table import OF_RAW, Layout, own_types
from ._target import Target, UrlTarget, failed, is_url, local_for

if TYPE_CHECKING:
    from typing_extensions import Unpack
    from ._types import ConvertOptions, Given, Path

_UNTOLD = ("calibration", "profile", "set", "rig", "columns", "broken", "threads", "progress")
"""Options that the origin of a file does not name: what they give is in it."""


# --- Of frames ---


class _Cancelled(Exception):
    """The output was given up."""


def _why(error: Exception, target: Optional[AnyTarget]) -> Exception:
    """lazrs does not say why it could not write; the file does, when what is left in it is written."""
    if target is not None and not isinstance(error, OSError):
        try:
            target.file.flush()
        except OSError as told:
            return told
    return error


class _File:
    """A file that grows frame by frame: one that Python writes, or one of the library."""

    def __init__(self, plan: Plan, about: About, layout: Layout, name: str) -> None:
        self.name = name
        self._url: Optional[contextlib.ExitStack] = None
        self._target: Optional[AnyTarget] = None
        self.bytes = 0
        if plan.format in FORMATS:
            self._begin_points(plan, about, layout)
        else:
            self._begin(plan, about, layout)

    def _begin(self, plan: Plan, about: About, layout: Layout) -> None:
        self._target = UrlTarget(self.name, plan.storage) if is_url(self.name) else Target(self.name)
        try:
            compression = plan.output.get("compression")
            kind = WRITERS[plan.format]
            if compression is not None and compression not in kind.compressions:
                raise OptionError(f"compression is {compression!r}; for {plan.format} use one of "
                                  f"{', '.join(kind.compressions)}")
            with self._writing():
                self._writer: Union[Writer, PointsFile] = kind(Job(self._target, about, layout, plan.time, compression))
        except BaseException:
            self._target.discard()
            raise

    def _begin_points(self, plan: Plan, about: About, layout: Layout) -> None:
        self._url = contextlib.ExitStack()
        self._local = self._url.enter_context(local_for(self.name, plan.storage))
        has_comment = plan.format not in APPLIES["comments"] or bool(plan.output.get("comments"))
        columns = layout.columns if "columns" in plan.output else None
        calibration = Calibration(about.calibration)._to_c() if about.calibration else None
        messages = Messages(plan.is_of_world, calibration, about.calibration, about.profile)
        try:
            self._writer = PointsFile(self._local, plan.format, about.text() if has_comment else "", columns,
                                      bool(plan.output.get("ascii")), plan.time, layout.own, messages)
        except BaseException:
            self._forget()
            raise

    def _forget(self) -> None:
        """Send nothing to the URL."""
        with contextlib.suppress(_Cancelled):
            if self._url is not None:
                self._url.__exit__(_Cancelled, _Cancelled(), None)

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Libraries that write a format have errors of their own, which do not name the file."""
        try:
            yield
        except Error:
            raise
        except Exception as error:
            if not isinstance(error, OSError) and type(error).__module__.split(".")[0] not in FOREIGN:
                raise
            raise failed(self.name, _why(error, self._target)) from error

    def add(self, frame: Frame) -> None:
        """Append a frame."""
        with self._writing():
            self._writer.add(frame)

    def finish(self, losses: dict[str, int], last_look: Callable[[], None]) -> None:
        """Complete it; then it has its name, unless last_look() raises before."""
        if isinstance(self._writer, PointsFile):
            assert self._url is not None
            self._writer.finish()
            self.bytes = os.path.getsize(self._local)
            self._url.close()
        else:
            assert self._target is not None
            with self._writing():
                self._writer.finish(losses)
            self.bytes = self._target.finish(last_look)

    def discard(self) -> None:
        """Leave nothing of it."""
        if isinstance(self._writer, PointsFile):
            self._writer.discard()
            self._forget()
        else:
            assert self._target is not None
            with contextlib.suppress(Exception):
                self._writer.abort()
            self._target.discard()


class _Made:
    """What outputs have come to."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.bytes = self.frames = self.points = 0
        self.cancelled = False
        """Whether nothing is to be left of what is not complete; set by another thread."""


class _Output:
    """The file, or the file of each frame."""

    def __init__(self, plan: Plan, about: About, own: Mapping[str, np.dtype[Any]], motion: Optional[Motion] = None,
                 made: Optional[_Made] = None) -> None:
        self._plan, self._about, self._layout, self._own = plan, about, plan.layout(own), own
        self.motion = motion or plan.motion()
        if motion is None and self.motion is not None:
            about.options += self.motion.notes
        self.made = made or _Made()
        self._sensor: Optional[str] = None
        self._file: Optional[_File] = None if plan.is_pattern else self._open(plan.name)

    def _open(self, name: str) -> _File:
        self._plan.check_written(name)
        return _File(self._plan, self._about, self._layout, name)

    def _check_sensor(self, frame: Frame) -> None:
        self._sensor = self._sensor or frame.sensor
        if bool(frame._info.member) != self._plan.has_rig:
            raise OptionError(f"{self._about.source}: some frames were read with a rig, others without, so their "
                              "points are in different frames of reference: read all with the rig")
        if self._plan.has_rig:
            is_several = frame._info.member == JOINED or frame.sensor != self._sensor and not self._plan.is_pattern
            if is_several and self._plan.output.get("time") == "sensor":
                raise self._plan.own_clocks()
            if self._about.rig != list(frame._info.rig):
                raise OptionError(f"frame {frame.number} of {frame.sensor} was read with another rig than the first one; use "
                                  "frames of one rig")
            if frame.sensor != self._sensor and self._plan.is_pattern:
                raise OptionError(f"{self._about.source}: frames of several sensors have the same numbers: put %s, the sensor's name, "
                                  f"into the name of the files, as in {_with_sensor(self._plan.name)}")
            return
        cannot_tell = self._plan.is_pattern or "sensor" not in self._layout.columns or "%" in frame.sensor
        if frame.sensor != self._sensor and cannot_tell:
            raise OptionError(f"{self._about.source}: packets of several sensors; choose one by sensor=: {self._sensor} "
                              f"{frame.sensor}" + ("; a table can have a column \"sensor\""
                                                   if self._plan.format in OF_TABLES else ""))

    def _check_alike(self, frame: Frame) -> None:
        """A file has one set of columns, and points of one frame of reference."""
        if self.motion is None and (frame._moved == "world") != self._plan.is_of_world:
            raise OptionError(f"frame {frame.number} {'is' if frame._moved == 'world' else 'is not'} in the world, unlike the first "
                              "one; use frames that to_world() moved, or others alone")
        named = [{name: dtype for name, dtype in of.items() if name not in OF_RAW or name in self._layout.columns}
                 for of in (self._own, own_types(frame))]
        if named[0] != named[1]:
            first, other = (", ".join(f"{name} ({dtype})" for name, dtype in of.items()) or "none" for of in named)
            raise OptionError(f"frame {frame.number} has other columns of its own than the first one: {other} and not {first}; "
                              "use the same ones for all, in the same types")

    def _check_cancelled(self) -> None:
        if self.made.cancelled:
            raise _Cancelled

    def add(self, frame: Frame) -> None:
        """Append a frame."""
        self._check_cancelled()
        self._check_sensor(frame)
        self._check_alike(frame)
        if self.motion is not None:
            frame = self.motion.move(frame)
        if self._plan.is_pattern:
            if not len(frame):
                self.made.frames += 1
                return
            self._file = self._open(name_for(self._plan.name, frame))
        assert self._file is not None
        self._file.add(frame)
        self.made.frames += 1
        self.made.points += len(frame)
        if self._plan.is_pattern:
            self.finish(frame.losses)

    def finish(self, losses: dict[str, int]) -> None:
        """Complete it."""
        self._check_cancelled()
        if self._file is not None:
            self._file.finish(losses, self._check_cancelled)
            self.made.names.append(self._file.name)
            self.made.bytes += self._file.bytes
        self._file = None

    def discard(self) -> None:
        """Leave nothing of what is not complete."""
        if self._file is not None:
            self._file.discard()
        self._file = None


def _with_sensor(name: str) -> str:
    folder, base = os.path.split(name)
    return os.path.join(folder, f"%s-{base}")


class _Split:
    """The files of each sensor of a rig."""

    def __init__(self, plan: Plan, about: About, own: Mapping[str, np.dtype[Any]],
                 losses_of: Callable[[str], dict[str, int]]) -> None:
        self._plan, self._about, self._own, self._losses_of = plan, about, own, losses_of
        self.motion = plan.motion()
        if self.motion is not None:
            about.options += self.motion.notes
        self.made = _Made()
        self._parts: dict[str, _Output] = {}

    def add(self, frame: Frame) -> None:
        """Append a frame to the files of its sensor."""
        if frame._info.member <= 0:
            raise OptionError(f"{self._plan.name}: %s stands for the name of a rig's sensor, and a frame of {frame.sensor} is not of "
                              "one: read frames by open(rig=), and write those of a set one by one")
        if frame.sensor not in self._parts:
            plan = self._plan.of_sensor(frame.sensor)
            self._parts[frame.sensor] = _Output(plan, self._about, self._own, self.motion, self.made)
        self._parts[frame.sensor].add(frame)

    def finish(self, _: dict[str, int]) -> None:
        """Complete them."""
        for name, part in self._parts.items():
            part.finish(self._losses_of(name))

    def discard(self) -> None:
        """Leave nothing of what is not complete."""
        for part in self._parts.values():
            part.discard()


_WAIT_S = 0.05


class _Thread(threading.Thread):
    """Writes frames while the next ones are read, and so that Ctrl-C need not wait for it.

    From its start on the output is its own. It is no daemon, so that a program ends only when nothing is left of an
    output that was given up.
    """

    def __init__(self, output: Union[_Output, _Split], is_alone: bool) -> None:
        super().__init__(name="lumsdk-convert", daemon=False)
        self._output, self._is_alone = output, is_alone
        self._queue: queue.SimpleQueue[Optional[Frame]] = queue.SimpleQueue()  # None: no more come
        self._taken = threading.Semaphore(0)
        self._losses: dict[str, int] = {}
        self.error: Optional[BaseException] = None

    def run(self) -> None:
        try:
            while (frame := self._queue.get()) is not None:
                if not self._is_alone:
                    self._taken.release()
                self._output.add(frame)
                del frame  # its memory is for the next one
                if self._is_alone:
                    self._taken.release()
            if self._output.motion is not None:
                self._output.motion.finish()
            self._output.finish(self._losses)
        except BaseException as error:
            self.error = error
            self._output.discard()

    def _put(self, frame: Frame) -> None:
        """Hand over a frame. Returns when the next one may be read: there is memory for two, or for one."""
        self._queue.put(frame)
        while self.error is None and not self._taken.acquire(timeout=_WAIT_S):
            pass

    def write(self, frames: Iterable[Frame], losses: Callable[[], dict[str, int]]) -> None:
        """Write all of them, and complete the output."""
        for frame in frames:
            check_frame(frame)
            self._put(frame)
            del frame
            if self.error is not None:
                raise self.error
        self._losses = losses()
        self._queue.put(None)
        while self.is_alive():
            self.join(_WAIT_S)
        if self.error is not None:
            raise self.error

    def stop(self, waits: bool) -> None:
        """End it early, and leave nothing of the output.

        Args:
            waits: until that is done; else what it is doing just now goes on for a while.
        """
        self._output.made.cancelled = True
        self._queue.put(None)
        if self.ident is not None:  # else it was interrupted before it began
            self.join(None if waits else _WAIT_S)


def _about(source: Optional[Source], read: Mapping[str, Any]) -> About:
    told = {name: value for name, value in read.items() if name not in _UNTOLD}
    options = _lumdump.arguments(told, "")
    if source is None:
        return About(f"lumsdk {VERSION}", "frames", options, is_of_frames=True)
    name = source.name.replace("\\", "/").rsplit("/", 1)[-1]
    if source.rig is not None:
        return About(f"lumsdk {VERSION}", name, options, rig=source.rig.describe(), earlier=source.provenance)
    calibration, profile = source.calibration, source.profile
    return About(f"lumsdk {VERSION}", name, options, calibration.to_yaml(), profile.to_yaml(),
                 calibration == Calibration(), profile == Profile(), earlier=source.provenance)


def _losses_by_sensor(source: Optional[Source]) -> Callable[[str], dict[str, int]]:
    def of(name: str) -> dict[str, int]:
        counts = source.counts_by_sensor[name] if source is not None else {}
        return {cause: counts[cause] for cause in LOSSES if cause in counts}
    return of


def _peek(frames: Iterable[Any]) -> tuple[Any, Iterable[Any]]:
    """The first frame, whose columns of one's own the file has, and all of them; a source gives none such, and is not begun."""
    if isinstance(frames, Source):
        return None, frames
    rest = iter(frames)
    first = list(itertools.islice(rest, 1))
    return (first or [None])[0], itertools.chain(first, rest)


def _write(plan: Plan, frames: Iterable[Frame], source: Optional[Source]) -> Summary:
    moved: dict[str, Any] = {name: plan.output[name] for name in ("poses", "pose_times", "to") if name in plan.output}
    if isinstance(moved.get("poses"), Poses):
        moved["poses"] = moved["poses"].name
    about = _about(source, {**(plan.read if source is None else source._choice.given), **moved})
    first, frames = _peek(frames)
    plan.is_of_world = plan.is_of_world or getattr(first, "_moved", "") == "world"
    if isinstance(first, Frame):
        plan.has_rig, plan.is_of_joined = first._info.member != 0, first._info.member == JOINED
        about.rig = list(first._info.rig)
    if plan.format == "mcap" and plan.has_rig and not plan.is_of_world:
        raise OptionError("frames of a rig are in the vehicle's frame, but messages are in each sensor's own: convert the capture "
                          "itself to mcap with rig=")
    own = own_types(first) if isinstance(first, Frame) else plan.besides
    output = _Split(plan, about, own, _losses_by_sensor(source)) if plan.is_split else _Output(plan, about, own)
    kind = WRITERS.get(plan.format)
    thread = _Thread(output, kind is not None and kind.is_alone)
    try:
        thread.start()
        thread.write(frames, lambda: source.losses if source is not None else {})
    except BaseException as error:
        thread.stop(isinstance(error, Exception))
        raise
    made = output.made
    summary = Summary(source=about.source, format=plan.format, outputs=made.names, frames=made.frames, points=made.points,
                      bytes=made.bytes, truncated=False, sensors=[], losses={}, left_out=0)
    if output.motion is not None:
        summary["left_out"] = output.motion.without
    if source is not None:
        counts = source.counts
        summary["source"], summary["sensors"], summary["losses"] = source.name, source.sensors, source.losses
        summary["truncated"] = source.truncated
        summary["left_out"] += counts["points_late"] + counts["points_cut"]
    return summary


def _by_frames(plan: Plan) -> Summary:
    if isinstance(plan.source, Source):
        plan.paths = list(plan.source._input.files)
        return _write(plan, plan.source, plan.source)
    if plan.is_of_frames:
        return _write(plan, plan.source, None)
    kind = WRITERS.get(plan.format)
    needs = kind.needs if kind is not None and kind.needs is not None else plan.layout(plan.besides).needs
    if plan.format == "las":
        needs = WRITERS["laz"].needs or ()
    if plan.format == "mcap":
        needs = (*OF_MESSAGES, "time")
    if "poses" in plan.output:
        needs = tuple(dict.fromkeys((*needs, *Motion.needs)))
    options: dict[str, Any] = {"broken": "warn", **plan.read, "columns": list(needs)}
    with open(plan.source, storage_options=plan.source_storage, **options) as source:
        plan.paths = list(source._input.files)
        return _write(plan, source, source)


# --- The function ---


def convert(source: Union[Given, Source, Iterable[Frame], Frame], destination: Path, **options: Unpack[ConvertOptions]) -> Summary:
    """Write a capture, or frames, to a file of another format.

        lumsdk.convert("drive.pcap", "drive.laz", returns="last")
        lumsdk.convert("drive.pcap", "frames/%04d.bin", range=(2, 80))
        lumsdk.convert(sensor.frames(duration=5), "now.parquet")

    Memory does not grow with the capture. A file has its name only when it is whole and on the disk: an interruption leaves nothing,
    and a file that is replaced stays as it is until then.

    Args:
        source: what open() takes, a Source, or frames: one, a list, or anything that gives them one by one.
        destination: a path, or a URL (fsspec; sent under a temporary key, which gets the name at the end). Its ending is the format:
            .csv .ply .pcd .las .xyz .png .mcap .pcap .pcapng, which lumdump writes with the same bytes as by itself, and .laz
            .parquet .feather .npy .npz .bin (KITTI). A %d or %04d in it stands for the number of a frame: then each frame has a
            file. Also {utc_ns} of those formats that lumdump does not write.

    Options are all of open(), and these of the output:

        format       of the destination, whatever its ending is
        columns      of csv, ply, pcd, parquet, feather, npy and npz: names, or "all"; x y z range azimuth elevation
                     pulse_width timestamp frame eye line pixel return_number number_of_returns edge if not given;
                     also time, and of the latter four strongest and sensor. Columns that with_columns() added to frames are
                     there, too, and in las, laz and mcap
        poses        where the sensor was: Poses, or the name of a file of them; points are moved, what has no pose is left
                     out; pose_times, the file of times of KITTI; to, "world" if not given, "start" or "middle"
        time         what timestamps are: "sensor", the sensor's clock; "utc", usual where a file has several sensors;
                     "arrival"
        preset       of parquet and feather: "argoverse2", its columns in its types
        compression  of parquet and feather: "lz4" if not given, "zstd", "none" and so on
        storage_options  a mapping for fsspec: for the URLs of destination and source, or, if they are of different stores
                     such as s3:// and https://, of the destination; then open() opens the source, with its own
        voxel        of csv, ply, pcd, las and laz: the size of voxels in metres. By poses into the world, all frames become
                     one map; else each frame is thinned on its own. Of each voxel, the point nearest to its centre
                     stays, with the number of its points. Memory does not grow with the road: docs/formats.md
        colour, size  of png: what colours mean, "range" if not given, "height" or "pulse_width"; (width, height) in pixels
        ascii, comments, organized, rotate, duration, packets  as of lumdump, for what it writes

    Unlike open(), convert() warns of a capture that breaks off or is damaged (broken="warn"), as lumdump does.

    Returns:
        What was done: a mapping with source, format, outputs, frames, points, bytes, truncated, sensors, losses and left_out.

    Raises:
        OptionError: an option is not allowed, or does not go with the format.
        CaptureError: the capture cannot be read.
        Error: the file cannot be written (also an OSError), or a library is missing; the message names its extra.
        TypeError: the source or an option is of a wrong type.
    """
    plan = Plan(source, destination, {**options})
    return by_lumdump(plan) if plan.by_lumdump else _by_frames(plan)
