"""Frames as the page of lumview takes them: messages, labels, losses, and what is known of all of them."""
from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._c import VERSION, ffi, lib, sized
from ._columns import COLUMNS
from ._errors import OptionError, warn
from ._frame import Frame
from ._grid import EYES
from ._settings import Calibration, Profile
from ._sync import FrameSet

if TYPE_CHECKING:
    from ._types import Array

MOST_BYTES = 256 << 20
"""Of a capture, or of frames, in a page: browsers keep all of it as one text, which cannot be longer than 512 MiB."""

_LABELS = ("label", "class", "object")
"""Columns that colour points as labels; the first that there is."""

_LABELS_MOST = 254

_FURTHEST_M = 2.0 ** 21
"""Coordinates of lum/frame/packed.h."""

_SAME_RANGE_M = 0.002

_ROUNDED_M = 0.001
"""By which float32 may round coordinates in silence."""

_LINE_POINTS = 1000

ALWAYS: Mapping[str, int] = {"pulse_width": 0, "line": 0, "pixel": 0, "return_number": 1, "number_of_returns": 1, "eye": 0, "edge": 1,
                             "strongest": 1}
"""Columns of a message beside x, y and z, and what stands there where a frame lacks them."""

_LACKS = {"line": ("line", "pixel"), "return": ("return_number", "number_of_returns"), "edge": ("edge",), "eye": ("eye",)}
"""What the page then does not say of a point."""

_NO_SENSOR = "0.0.0.0"
"""Of frames of arrays that were not told one."""

_MOST: Mapping[str, float] = {"line": 65535, "return_number": 127, "number_of_returns": 63, "pulse_width": 655.35}
"""That the page has: of lum/frame/packed.h, and for lines of tools/lumview/page/frame.js."""

_LOST_LINES = ("lines_missing", "lines_missing_angles", "lines_late", "lines_cut")


def refuse_size(name: str, size: int, instead: str) -> OptionError:
    return OptionError(f"{name}: {size / 2 ** 20:,.0f} MB are too much for a page, which holds at most {MOST_BYTES >> 20} MB; "
                       f"use {instead}")


def text_of(content: bytes) -> str:
    return base64.b64encode(content).decode()


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
                          "subtract an origin, such as by frame.to_world(poses, origin=poses.origin())")
    arrays = {name: frame._array(name) if name in frame else np.full(len(frame), usual) for name, usual in ALWAYS.items()}
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
            warn(f"{len(present)} different labels: the page shows the lowest {_LABELS_MOST}; points with others look unlabelled")
        names = [str(v if isinstance(v, np.floating) and not v.is_integer() else int(v)) for v in present[:_LABELS_MOST]]
        frames = []
        for number, values in zip(numbers, self._of):
            if values is not None:
                places = np.searchsorted(present, values) + 1
                frames.append([number, text_of(np.where(places > _LABELS_MOST, 0, places).astype("u1").tobytes())])
        return {"names": names, "frames": frames}


def _numbered(message: bytes, number: int) -> bytes:
    """All pieces of a frame with this number in their heads."""
    out, at = bytearray(message), 0
    while at < len(out):
        out[at + 8:at + 16] = np.array(number, "<f8").tobytes()
        at += int.from_bytes(out[at + 80:at + 84], "little")
    return bytes(out)


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


# --- What frames have in common ---


class _Kind:
    """What frames have in common: whether all are frames, or sets of a rig, and what is known of all of them."""

    def __init__(self, calibration: Calibration, own: Mapping[str, Calibration]) -> None:
        """own: calibrations of a rig's sensors."""
        self.first: dict[str, Frame] = {}  # of each sensor
        self.sets: Optional[bool] = None
        self._calibration, self._own, self._is_told = calibration, own, False
        self._eyes: dict[str, list[dict[str, Any]]] = {}
        self._lacks: set[str] = set()
        self._above: set[str] = set()  # columns with values above those that the page has
        self._elsewhere: set[str] = set()  # sensors with a frame that was not seen from their eyes

    def take(self, shown: Union[Frame, FrameSet]) -> None:
        is_set = isinstance(shown, FrameSet)
        if self.sets not in (None, is_set):
            raise OptionError("frames and sets of a rig's sensors are given; give only one kind")
        for frame in _parts_of(shown):
            self._note(frame.sensor, frame)
        if not is_set and len(self.first) > 1 and _NO_SENSOR in self.first:
            raise OptionError(f"frames of {', '.join(name for name in self.first if name != _NO_SENSOR)} and points of no sensor are "
                              "mixed; give only one kind, or give the points its address: "
                              "lumsdk.Frame.from_arrays(xyz=points, sensor=...)")
        if not is_set and len(self.first) > 1:
            raise OptionError(f"frames of several sensors, {', '.join(self.first)}; use lumsdk.view(lumsdk.sync(frames)), where "
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
        self._above.update(column for column, most in _MOST.items()
                           if column in frame and np.fmax.reduce(frame._array(column), initial=0) > np.float32(most))
        if name not in self._elsewhere and not _is_seen_from(frame, self._eyes[name]):
            self._elsewhere.add(name)

    def warn_of_most(self) -> None:
        told = [f"{name} up to {most:g}" for name, most in _MOST.items() if name in self._above]
        if told:
            warn(f"the page has {', '.join(told)}: greater values are shown as these", UserWarning)

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


# --- All together ---


def as_frame(given: Any, place: int) -> Union[Frame, FrameSet]:
    if isinstance(given, (Frame, FrameSet)):
        return given
    if hasattr(given, "keys"):
        return Frame.from_arrays(given)
    array = given if isinstance(given, np.ma.MaskedArray) else np.asarray(given)  # of rows, from_arrays() tells what is masked
    if array.dtype.names is not None:
        return Frame.from_arrays({name: array[name] for name in array.dtype.names})
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{type(given).__name__} cannot be shown; use a capture's path, a source, a frame, an array of the shape "
                        "(n, 3), or several frames or arrays")
    is_masked, array = np.ma.getmaskarray(array), np.asarray(array)
    with np.errstate(over="ignore", invalid="ignore"):
        made = array.astype("f4")
        is_beyond = np.isinf(made) & np.isfinite(array) & ~is_masked
        made[is_masked | is_beyond] = np.nan
        rounded = float(np.fmax.reduce(np.abs(made - array), None, initial=0)) if array.dtype.itemsize > made.dtype.itemsize else 0.0
    frame = Frame.from_arrays(xyz=made, number=place)
    beyond = np.count_nonzero(is_beyond.any(axis=1))
    if beyond:
        warn(f"{beyond} {'points are' if beyond > 1 else 'point is'} beyond float32, and left out", UserWarning)
    if rounded > _ROUNDED_M:
        warn(f"the points are so far from 0 that float32 rounds them by up to {rounded:.3g} m: subtract an origin from them, such as "
             "numpy.round(points[0])", UserWarning)
    return frame


def _numbers_of(told: list[Optional[int]]) -> list[int]:
    """Theirs where they rise; else places, from 0 on."""
    known = [number for number in told if number is not None]
    if len(known) == len(told) and all(a < b for a, b in zip(known, known[1:])):
        return known
    if any(known):  # else nobody has numbered them
        warn("the numbers of the frames do not rise, so the page numbers them from 0 on", UserWarning)
    return list(range(len(told)))


def _hello(name: str, kind: _Kind) -> dict[str, Any]:
    """The greeting, as lumview's own (tools/lumview/page_status.c)."""
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


def of_frames(given: Iterable[Any], name: Optional[str], calibration: Any,
               own: Optional[Mapping[str, Calibration]] = None) -> dict[str, Any]:
    """{"hello", "frames"} for the page. own: calibrations of a rig's sensors, in place of that one."""
    kind, labels, size = _Kind(Calibration(calibration), own or {}), _Labels(), 0
    messages: list[bytes] = []
    losses: list[list[int]] = []
    told: list[Optional[int]] = []
    for place, one in enumerate(given):
        shown = as_frame(one, place)
        kind.take(shown)
        told.append(shown.number if isinstance(shown, Frame) else None)
        message, is_seen = _message(shown, place, kind.places())
        labels.add(shown, is_seen)
        messages.append(message)
        losses.append(_loss(shown))
        size += len(message)
        if size > MOST_BYTES:
            some = f"at most {place} of them, such as frames[:{place}]" if place else "a part of its points, such as frame[::2]"
            raise refuse_size(f"{place + 1} frames" if place else "the frame", size,
                               f"{some}, or write a capture and open it with the program 'lumview'")
    if not messages:
        raise OptionError("there is no frame to show")
    kind.warn_of_most()
    numbers = _numbers_of(told)
    known = [sensor for sensor in kind.first if sensor != _NO_SENSOR]
    hello = _hello(name or ", ".join(known) or "points", kind)
    hello["labels"] = labels.to_page(numbers)
    hello["marks"] = [[number, *lost] for number, lost in zip(numbers, losses) if any(lost)]
    return {"hello": hello, "frames": [text_of(_numbered(message, number)) for message, number in zip(messages, numbers)]}
