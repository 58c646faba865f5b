"""A view that can be turned, of a capture or of frames: lumview.html with the data in it."""
from __future__ import annotations

import base64
import html
import json
import os
import pathlib
import re
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._c import VERSION, ffi, lib, sized
from ._errors import Error, OptionError, warn
from ._columns import COLUMNS
from ._frame import Frame
from ._grid import EYES
from ._inputs import Files, Input, Memory, Stream
from ._settings import Calibration, Profile
from ._source import Source, open as open_source
from ._sync import FrameSet

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from ._types import Array, Given, Options, Path

    OneShown = Union[Frame, FrameSet, ArrayLike]
    Shown = Union[Source, Given, OneShown, Iterable[OneShown]]

_MOST_BYTES = 256 << 20
"""Of a capture, or of frames, in a page: browsers keep all of it as one text, which cannot be longer than 512 MiB."""

_MOST_OF_CELL = 64 << 20
"""In a cell, as a notebook keeps it."""

_BY_PAGE = {"columns", "threads", "progress", "broken", "raw", "calibration", "profile", "set", "rig"}
"""Options of a source that the page needs not know, or is told. With others, it gets frames in place of the capture."""

_LABELS = ("label", "class", "object")
"""Columns that colour points as labels; the first that there is."""

_LABELS_MOST = 254

_FURTHEST_M = 2.0 ** 21
"""Coordinates of lum/frame/packed.h."""

_SAME_RANGE_M = 0.002

_ROUNDED_M = 0.001
"""By which float32 may round coordinates in silence."""

_PACKED_OTHERWISE = (b"BZh", b"\x04\x22\x4d\x18")
"""How captures begin that bzip2 or lz4 compressed, which the page cannot unpack."""

_LINE_POINTS = 1000

_ALWAYS: Mapping[str, int] = {"pulse_width": 0, "line": 0, "pixel": 0, "return_number": 1, "number_of_returns": 1, "eye": 0, "edge": 1,
                              "strongest": 1}
"""Columns of a message beside x, y and z, and what stands there where a frame lacks them."""

_LACKS = {"line": ("line", "pixel"), "return": ("return_number", "number_of_returns"), "edge": ("edge",), "eye": ("eye",)}
"""What the page then does not say of a point."""

_NO_PAGE = ("this installation has no lumview.html, which shows the points: in a clone, cmake -B build && cmake --build build makes "
            "it, and pip install . then takes it (docs/wheels.md); frame.to_png() draws a picture")

_LOST_LINES = ("lines_missing", "lines_missing_angles", "lines_late", "lines_cut")

_SENSOR = re.compile(r"(udp://)?(\d+\.){3}\d+(%\w+)?(:\d+)?")


def _refuse_live(name: str) -> TypeError:
    return TypeError(f"{name} is live, and a view holds what has been recorded: the program 'lumview {name}' shows it in a browser; "
                     "lumsdk.view(list(sensor.frames(2))) shows the frames of two seconds")


def _refuse_size(name: str, size: int, instead: str) -> OptionError:
    return OptionError(f"{name}: {size / 2 ** 20:,.0f} MB are too much for a page, which holds at most {_MOST_BYTES >> 20} MB; "
                       f"right is {instead}")


# --- Frames as messages ---


def _parts_of(shown: Union[Frame, FrameSet]) -> list[Frame]:
    return list(shown.values()) if isinstance(shown, FrameSet) else [shown]


def _seen(frame: Frame) -> tuple[dict[str, Array], Array]:
    """The columns of a message, and which points they have: those that are somewhere."""
    for name in "xyz":
        if name not in frame:
            raise frame._refuse(name)
    xyz = frame.xyz
    is_somewhere: Array = np.asarray(np.isfinite(xyz).all(axis=1))
    if len(xyz) and (np.abs(xyz[is_somewhere]) >= _FURTHEST_M).any():
        raise OptionError(f"frame {frame.number}: points lie more than {_FURTHEST_M:,.0f} m from 0, where the page cannot draw them; "
                          "right is to subtract an origin, such as by frame.to_world(poses, origin=poses.origin())")
    arrays = {name: frame._array(name) if name in frame else np.full(len(frame), usual) for name, usual in _ALWAYS.items()}
    arrays.update(zip("xyz", xyz.T))
    return {name: np.ascontiguousarray(array[is_somewhere], COLUMNS[name]) for name, array in arrays.items()}, is_somewhere


def _put_part(part: Any, frame: Frame, columns: Mapping[str, Array], place: int) -> list[Any]:
    """Fill in a lum_packed_part. Returns what has to live as long as it."""
    kept = []
    for name, array in columns.items():
        kept.append(ffi.from_buffer(ffi.typeof(getattr(part, name)), array))
        setattr(part, name, kept[-1])
    part.struct_size, part.count, part.frame, part.sensor = ffi.sizeof(part), len(columns["x"]), frame.number, place
    return kept


def _head(shown: Union[Frame, FrameSet], number: int, count: int, edges: int) -> Any:
    parts = _parts_of(shown)
    infos = [frame._info for frame in parts]
    first = infos[0]
    lines = sum(sum(info.lines) for info in infos) or -(-count // _LINE_POINTS)
    error_ns = shown.utc_error_ns
    time = lib.LUM_PACKED_TIME_FITTED if first.begin_utc_ns else lib.LUM_PACKED_TIME_ARRIVAL
    return sized("lum_packed_head", frame=number, clock_us=first.begin_clock_us, utc_ns=shown.utc_ns,
                 utc_error_ns=lib.LUM_CLOCK_ERROR_UNKNOWN if error_ns is None else error_ns,
                 lost_words=sum(info.losses["lost_words"] for info in infos), shown=1, sensor=first.sensor, lines=lines,
                 time=time if shown.utc_ns else lib.LUM_PACKED_TIME_UNKNOWN, edges=edges, is_rig=isinstance(shown, FrameSet))


def _edges_of(columns: Iterable[Mapping[str, Array]]) -> int:
    has = [any((part["edge"] == edge).any() for part in columns) for edge in (1, 0)]
    return int(lib.LUM_EDGES_BOTH if all(has) else lib.LUM_EDGES_FALLING if has[1] else lib.LUM_EDGES_RISING)


def _message(shown: Union[Frame, FrameSet], number: int, places: Mapping[str, int]) -> tuple[bytes, Array]:
    """A frame as the page takes it, and which of its points that has."""
    frames = _parts_of(shown)
    seen = [_seen(frame) for frame in frames]
    parts = ffi.new("lum_packed_part[]", len(frames))
    kept = [_put_part(part, frame, columns, places.get(frame.sensor, 0))
            for part, frame, (columns, _) in zip(parts, frames, seen)]
    head = _head(shown, number, sum(part.count for part in parts), _edges_of([columns for columns, _ in seen]))
    out = ffi.new("lum_packed *")
    try:
        result = lib.lum_packed_make(head, parts, len(frames), out)
        if result == lib.LUM_E_SPACE:
            raise MemoryError
        if result != lib.LUM_OK:
            raise OptionError(f"frame {shown.number if isinstance(shown, Frame) else number}: it cannot be shown: a view has at most "
                              f"{lib.LUM_PACKED_PARTS_MAX} sensors")
        return bytes(ffi.buffer(out.bytes, out.len)), np.concatenate([is_seen for _, is_seen in seen])
    finally:
        lib.lum_packed_free(out)
        del kept


class _Labels:
    """Labels of points as the page takes them: names, and for each frame a small number for each point."""

    def __init__(self) -> None:
        self._of: list[Optional[Array]] = []

    def add(self, shown: Union[Frame, FrameSet], is_seen: Array) -> None:
        found = [[name for name in _LABELS if name in frame._own] for frame in _parts_of(shown)]
        if not all(found):
            self._of.append(None)
            return
        values = np.concatenate([frame._array(names[0]) for frame, names in zip(_parts_of(shown), found)])
        self._of.append(values[is_seen])

    def to_page(self, numbers: Iterable[int]) -> Optional[dict[str, Any]]:
        known = [values for values in self._of if values is not None]
        if not known:
            return None
        present = np.unique(np.concatenate([np.unique(values) for values in known]))
        if len(present) > _LABELS_MOST:
            warn(f"{len(present)} different labels: the page has the lowest {_LABELS_MOST}; points of others are shown as without one")
        names = [str(v if isinstance(v, np.floating) and not v.is_integer() else int(v)) for v in present[:_LABELS_MOST]]
        frames = []
        for number, values in zip(numbers, self._of):
            if values is not None:
                places = np.searchsorted(present, values) + 1
                frames.append([number, _text_of(np.where(places > _LABELS_MOST, 0, places).astype("u1").tobytes())])
        return {"names": names, "frames": frames}


# --- Where the eyes are ---


def _turned(center_deg: float, rotation: Array) -> Array:
    """The rotation with the azimuth's centre in it, as the page measures from the axes."""
    c, s = np.cos(np.radians(center_deg)), np.sin(np.radians(center_deg))
    return np.asarray(rotation @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]))


def _eyes_of(calibration: Calibration, pose: Optional[Array]) -> list[dict[str, Any]]:
    """Where the eyes of a sensor are, by which the page tells ranges and angles."""
    layout, projector = ffi.new("lum_layout *"), ffi.new("lum_projector *")
    if (lib.lum_layout_init(layout, Profile()._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK
            or lib.lum_projector_init(projector, calibration._to_c(), layout) != lib.LUM_OK):
        raise OptionError("the calibration is out of range")
    out = []
    for name, eye in zip(EYES, projector.eye):
        mount, rotation = np.array(list(eye.mount)), _turned(eye.azimuth_center, np.reshape(list(eye.rotation), (3, 3)))
        if pose is not None:
            mount, rotation = pose[:3, :3] @ mount + pose[:3, 3], pose[:3, :3] @ rotation
        out.append({"name": name, "mount": mount.tolist(), "rotation": rotation.ravel().tolist()})
    return out


_AT_ORIGIN: Mapping[str, Any] = {"mount": [0, 0, 0], "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1]}
"""Where it is not known from where points were seen: the page tells how far they are from 0 instead."""


def _is_seen_from(frame: Frame, eyes: list[dict[str, Any]]) -> bool:
    """Whether the ranges of a frame are those from there: not where its calibration is another one, or after a movement."""
    if "eye" not in frame or "range" not in frame:
        return False
    ranges = np.linalg.norm(frame.xyz - np.array([eye["mount"] for eye in eyes])[frame["eye"]], axis=1)
    return not (np.abs(ranges - frame["range"]) > _SAME_RANGE_M).any()


def _loss(shown: Union[Frame, FrameSet]) -> list[int]:
    """[words, pauses, lines], as lumview marks it: what was under way when the recording began or ended is not lost."""
    infos = [frame._info for frame in _parts_of(shown)]
    inside = [info.losses for info in infos if not (info.is_first or info.is_last)]
    return [sum(losses["lost_words"] for losses in inside), sum(info.has_pause for info in infos),
            sum(losses[name] for losses in inside for name in _LOST_LINES)]


# --- What the page gets ---


def _text_of(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _hello(name: str, kind: _Kind) -> dict[str, Any]:
    """The greeting, as lumview's own (tools/lumview/status.c)."""
    view = ffi.new("lum_image_view *")
    lib.lum_image_view_default(view, lib.LUM_IMAGE_BOTH, 1)
    image = {"left": view.left_deg, "right": view.right_deg, "top": view.top_deg, "bottom": view.bottom_deg, "columns": view.columns,
             "rows_step": view.rows}
    made = {"type": "hello", "version": VERSION, "source": name, "live": False, "eyes": kind.eyes(), "profiles": None, "image": image,
            "smooth_max": 0}
    if kind.sets:
        poses = [np.eye(4) if frame.pose is None else frame.pose for frame in kind.first.values()]
        made["rig"] = {"frame": "vehicle", "sensors": list(kind.first), "poses": [pose[:3].ravel().tolist() for pose in poses]}
    return made


def _as_frame(given: Any, place: int) -> Union[Frame, FrameSet]:
    if isinstance(given, (Frame, FrameSet)):
        return given
    if hasattr(given, "keys"):
        return Frame.from_arrays(given)
    array = np.asarray(given)
    if array.dtype.names is not None:
        return Frame.from_arrays({name: array[name] for name in array.dtype.names})
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{type(given).__name__} cannot be shown; right is a capture's path, a source, a frame, an array of the shape "
                        "(n, 3), or several frames or arrays")
    with np.errstate(over="ignore", invalid="ignore"):
        made = array.astype("f4")
        rounded = float(np.fmax.reduce(np.abs(made - array), None, initial=0)) if array.dtype.itemsize > made.dtype.itemsize else 0.0
    if rounded > _ROUNDED_M:
        warn(f"the points are so far from 0 that float32 rounds them by up to {rounded:.3g} m: subtract an origin from them, such as "
             "numpy.round(points[0])", UserWarning)
    return Frame.from_arrays(xyz=made, number=place)


def _numbers_of(told: list[Optional[int]]) -> list[int]:
    """Theirs where they grow; else places, from 0 on."""
    known = [number for number in told if number is not None]
    if len(known) == len(told) and all(a < b for a, b in zip(known, known[1:])):
        return known
    return list(range(len(told)))


class _Kind:
    """What frames have in common: whether all are frames, or sets of a rig, and what is known of all of them."""

    def __init__(self, calibration: Calibration, own: Mapping[str, Calibration]) -> None:
        """own: calibrations of a rig's sensors."""
        self.first: dict[str, Frame] = {}  # of each sensor
        self.sets: Optional[bool] = None
        self._calibration, self._own, self._is_told = calibration, own, False
        self._eyes: dict[str, list[dict[str, Any]]] = {}
        self._lacks: set[str] = set()
        self._elsewhere: set[str] = set()  # sensors with a frame that was not seen from their eyes

    def take(self, shown: Union[Frame, FrameSet]) -> None:
        is_set = isinstance(shown, FrameSet)
        if self.sets not in (None, is_set):
            raise OptionError("frames and sets of a rig's sensors are given; right is one of both")
        for frame in _parts_of(shown):
            self._note(frame.sensor, frame)
        if not is_set and len(self.first) > 1:
            raise OptionError(f"frames of several sensors, {', '.join(self.first)}; right is lumsdk.view(lumsdk.sync(frames)), where "
                              "those of one moment are shown together")
        if len(self.first) > 1 and not self._is_told and not all(frame._info.member for frame in self.first.values()):
            self._is_told = True
            warn(f"frames of {', '.join(self.first)} were read without a rig, so each has its points in its own sensor's frame, and "
                 "they are shown over each other: open the source with rig=", UserWarning)
        self.sets = is_set

    def _note(self, name: str, frame: Frame) -> None:
        if name not in self.first:
            self.first[name] = frame
            self._eyes[name] = _eyes_of(self._own.get(name, self._calibration), frame.pose if frame._moved != "world" else None)
        self._lacks.update(what for what, names in _LACKS.items() if not all(column in frame for column in names))
        if name not in self._elsewhere and not _is_seen_from(frame, self._eyes[name]):
            self._elsewhere.add(name)

    def eyes(self) -> list[dict[str, Any]]:
        """Those of all sensors, and what the page does not tell of their points."""
        out = []
        for sensor, both in self._eyes.items():
            told: dict[str, Any] = {"lacks": sorted(self._lacks)}
            if "eye" in self._lacks:
                told["name"] = None
            if sensor in self._elsewhere:
                told = {**told, **_AT_ORIGIN, "lacks": [*told["lacks"], "place"]}
            out += [{**eye, **told} for eye in both]
        return out

    def places(self) -> dict[str, int]:
        """The sensors of the rig by their places in the page."""
        return {name: place for place, name in enumerate(self.first)}


def _of_frames(given: Iterable[Any], name: Optional[str], calibration: Any,
               own: Optional[Mapping[str, Calibration]] = None) -> dict[str, Any]:
    """{"hello", "frames"} for the page. own: calibrations of a rig's sensors, in place of that one."""
    kind, labels, size = _Kind(Calibration(calibration), own or {}), _Labels(), 0
    messages: list[bytes] = []
    losses: list[list[int]] = []
    told: list[Optional[int]] = []
    for place, one in enumerate(given):
        shown = _as_frame(one, place)
        kind.take(shown)
        told.append(shown.number if isinstance(shown, Frame) else None)
        message, is_seen = _message(shown, place, kind.places())
        labels.add(shown, is_seen)
        messages.append(message)
        losses.append(_loss(shown))
        size += len(message)
        if size > _MOST_BYTES:
            some = f"at most {place} of them, such as frames[:{place}]" if place else "a part of its points, such as frame[::2]"
            raise _refuse_size(f"{place + 1} frames" if place else "the frame", size,
                               f"{some}, or write a capture and open it with the program 'lumview'")
    if not messages:
        raise OptionError("there is no frame to show")
    numbers = _numbers_of(told)
    known = [sensor for sensor in kind.first if sensor != "0.0.0.0"]
    hello = _hello(name or ", ".join(known) or "points", kind)
    hello["labels"] = labels.to_page(numbers)
    hello["marks"] = [[number, *lost] for number, lost in zip(numbers, losses) if any(lost)]
    return {"hello": hello, "frames": [_text_of(_numbered(message, number)) for message, number in zip(messages, numbers)]}


def _numbered(message: bytes, number: int) -> bytes:
    """All pieces of a frame with this number in their heads."""
    out, at = bytearray(message), 0
    while at < len(out):
        out[at + 8:at + 16] = np.array(number, "<f8").tobytes()
        at += int.from_bytes(out[at + 80:at + 84], "little")
    return bytes(out)


def _read(file: Any, most: int) -> bytes:
    """All that a file object has, up to so many bytes; one read() may give less."""
    out = bytearray()
    while len(out) < most and (part := file.read(most - len(out))):
        out += part
    return bytes(out)


def _contents(given: Input) -> Iterator[tuple[str, bytes]]:
    """The names of captures, and their bytes."""
    what = "some of its frames, as lumsdk.view(source[:10]) has them, or the program 'lumview', which reads captures of any size"
    if isinstance(given, Files):
        paths = given._same_paths()
        size = sum(os.stat(path).st_size for path in paths)
        if size > _MOST_BYTES:
            raise _refuse_size(given.name, size, what)
        for path in paths:
            yield os.path.basename(path), pathlib.Path(path).read_bytes()
        return
    if isinstance(given, Memory):
        content = bytes(ffi.buffer(given._buffer))
    else:
        assert isinstance(given, Stream)
        content = _read(given._rewind(), _MOST_BYTES + 1)
    if len(content) > _MOST_BYTES:
        raise _refuse_size(given.name, len(content), what)
    yield os.path.basename(given.name), content


def _settings(source: Source) -> dict[str, Any]:
    """The page's options for the calibration, the profile and the rig of a source."""
    rig = source.rig
    if rig is None:
        return {name: {"name": f"{name}.yaml", "text": getattr(source, name).to_yaml()} for name in ("calibration", "profile")}
    beside = {(name, what): f"{name}-{what}.yaml" for name in rig for what in ("calibration", "profile")}
    texts = [{"name": path, "text": getattr(rig[name], what).to_yaml()} for (name, what), path in beside.items()]
    return {"rig": {"name": "rig.yaml", "text": rig.to_yaml(beside)}, "beside": texts}


def _frames_of(source: Source) -> dict[str, Any]:
    rig = source.rig
    if rig is None:
        return _of_frames(source, source.name, source.calibration)
    from ._sync import sync

    return _of_frames(sync(source), source.name, None, {name: rig[name].calibration for name in rig})


def _of_source(source: Source) -> dict[str, Any]:
    """{"captures", "options"} for the page; or frames, where the source has some of the capture alone, or the page cannot read it."""
    source._check_open()
    chosen = [name for name, value in source._choice.given.items() if name not in _BY_PAGE and value != "all"]
    if source._sought_ns is not None or chosen or not source._input.can_reopen:
        return _frames_of(source)
    captures = []
    for name, content in _contents(source._input):
        if content.startswith(_PACKED_OTHERWISE):
            return _frames_of(source)
        captures.append({"name": name, "base64": _text_of(content)})
    return {"captures": captures, "options": _settings(source)}


def _is_capture(given: Any) -> bool:
    """Whether it is what open() takes."""
    if isinstance(given, (list, tuple)):
        return len(given) > 0 and isinstance(given[0], (str, os.PathLike))
    return isinstance(given, (str, os.PathLike, bytes, bytearray, memoryview)) or callable(getattr(given, "read", None))


def _refuse_sensor(given: Any) -> None:
    from ._sensor import Sensor
    from ._stream import Frames

    if isinstance(given, Sensor):
        raise _refuse_live(given.address)
    if isinstance(given, Frames):
        raise _refuse_live(given._sensor.address)
    if isinstance(given, str) and _SENSOR.fullmatch(given):
        raise _refuse_live(given.replace("udp://", ""))


def _data(shown: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    _refuse_sensor(shown)
    if _is_capture(shown):
        given: Any = {"columns": ("x", "y", "z", "range", *_ALWAYS), **options}
        with open_source(shown, **given) as source:
            return _of_source(source)
    if isinstance(shown, Source):
        if options:
            raise OptionError(f"{', '.join(options)}: a source has its options already; right is to give them to lumsdk.open()")
        return _of_source(shown)
    others = [name for name in options if name != "calibration"]
    if others:
        raise OptionError(f"{', '.join(others)}: options of captures; with frames calibration alone can be given")
    is_one = isinstance(shown, (Frame, FrameSet)) or hasattr(shown, "__array__") or hasattr(shown, "keys")
    if not is_one and not isinstance(shown, Iterable):
        shown = _as_frame(shown, 0)
    return _of_frames([shown] if is_one else shown, None, options.get("calibration"))


# --- The view ---


def _page() -> tuple[bytes, bytes]:
    """lumview.html before and behind the place of the data."""
    try:
        page = pathlib.Path(__file__).with_name("lumview.html").read_bytes()
    except OSError:
        raise Error(_NO_PAGE) from None
    at = page.index(b"</head>")
    return page[:at], page[at:]


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def _browser() -> Optional[Callable[[str], bool]]:
    """What opens a page in a window of its own; None: there is nothing but browsers of a terminal."""
    try:
        found = webbrowser.get()
    except webbrowser.Error:
        return None
    is_of_terminal = type(found) is webbrowser.GenericBrowser
    return None if is_of_terminal else found.open


class View:
    """What view() makes: a page of which nothing is elsewhere. In a notebook, it shows itself at the end of a cell."""

    def __init__(self, data: bytes, height: int) -> None:
        """Made by view()."""
        self._data, self._height = data, height
        self._path: Optional[str] = None

    @property
    def path(self) -> Optional[str]:
        """The file that open() has made. None: none yet."""
        return self._path

    def _write(self, file: Any) -> None:
        before, after = _page()
        file.write(before + b'<script type="application/json" id="lumview-data">')
        file.write(self._data)
        file.write(b"</script>" + after)

    def save(self, path: Path) -> None:
        """Write the page as one file, such as "street.html", which any browser opens, without a network too."""
        with open(path, "wb") as file:
            self._write(file)

    def open(self) -> str:
        """Show it in a browser, from a temporary file that nobody else can read. The file stays, as the browser needs it; the
        system removes it with its other temporary files.

        Returns:
            The path of the file. A warning tells where no browser can be opened, as over SSH.
        """
        if self._path is None:
            handle, path = tempfile.mkstemp(prefix="lumsdk-", suffix=".html")
            try:
                with os.fdopen(handle, "wb") as file:
                    self._write(file)
            except BaseException:
                os.unlink(path)
                raise
            self._path = path
        show = _browser()
        if show is None or not show(pathlib.Path(self._path).as_uri()):
            warn(f"no browser can be opened here; the view is the file {self._path}", UserWarning)
        return self._path

    def _repr_html_(self) -> str:
        """In a notebook: the page itself, of which the notebook keeps a copy."""
        before, after = _page()
        size = len(self._data)
        if size > _MOST_OF_CELL:
            return (f"<p>The view has {size / 2 ** 20:,.0f} MB, and a cell keeps at most {_MOST_OF_CELL >> 20} MB. Fewer frames are "
                    'smaller, as in lumsdk.view(source[:10]); .save("view.html") writes a file, and .open() shows it.</p>')
        text = (before + b'<script type="application/json" id="lumview-data">' + self._data + b"</script>" + after).decode()
        return (f'<iframe title="lumview" sandbox="allow-scripts allow-downloads" srcdoc="{html.escape(text)}" '
                f'style="width:100%;height:{self._height}px;border:0"></iframe>')

    def __repr__(self) -> str:
        return f"<View of {len(self._data):,} bytes{f' in {self._path}' if self._path else ''}>"


def view(shown: Shown, *, height: int = 560, browser: bool = True, **options: Unpack[Options]) -> View:
    """Show points in a page where they can be turned, coloured, filtered, measured and saved, as the program lumview does it.

        lumsdk.view("street.pcap")                        # a capture: all of it, with a player
        lumsdk.view(source[100:110])                      # frames
        lumsdk.view(frame.with_columns(label=labels))     # coloured by a column of one's own: label, class or object
        lumsdk.view(points)                               # an array of the shape (n, 3), or a list of them

    In a notebook the value at the end of a cell is shown inside the cell. Elsewhere a browser opens, from a temporary file. The
    page holds the data, needs neither server nor network, and is shared by save("street.html").

    Args:
        shown: a capture, or several, as open() takes them; a Source; a Frame, or a FrameSet of sync(); an array; a mapping as
            Frame.from_arrays() takes it; several of these frames or arrays. A source that was opened with options that choose,
            such as range or frames, is shown as its frames; of others the page gets the packets.
        height: of the cell, in pixels.
        browser: whether a browser opens where this is no notebook; False leaves that to open().
        options: those of open(), where shown is a capture; with frames, calibration tells where the eyes are, from which the page
            computes ranges and angles; None is the built-in one. Where the frames' own column range differs, or there is none,
            the page tells how far a point is from 0 instead.

    Returns:
        The page. Coordinates of frames are rounded by at most 1 mm, and points without coordinates (NaN) are left out.

    Raises:
        OptionError: the data is larger than 256 MB, or an option or an array is not right.
        TypeError: it is a live sensor, which lumview shows, or something that has no points.
        CaptureError: a source cannot be read.
        Error: this installation has no page.
    """
    if isinstance(height, bool) or not isinstance(height, int) or not 100 <= height <= 10000:
        raise OptionError(f"height is {height!r}; right is a number of pixels from 100 to 10000")
    _page()
    text = json.dumps(_data(shown, options), separators=(",", ":"))
    made = View(text.replace("<", "\\u003c").encode(), height)
    if browser and not _in_notebook():
        made.open()
    return made
