"""A frame as a picture oriented like the scene, and back. C does the work, on the frame's arrays."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._c import ffi, lib, sized
from ._errors import OptionError, warn
from ._grid import floats

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ._frame import Frame
    from ._types import AnyColumn, Array, Floats

CHOICES: dict[str, int] = {"nearest": lib.LUM_IMAGE_NEAREST, "farthest": lib.LUM_IMAGE_FARTHEST,
                           "strongest": lib.LUM_IMAGE_STRONGEST, "first": lib.LUM_IMAGE_FIRST, "last": lib.LUM_IMAGE_LAST}

EYES: dict[str, int] = {"blue": lib.LUM_IMAGE_BLUE, "green": lib.LUM_IMAGE_GREEN, "both": lib.LUM_IMAGE_BOTH}


def _chosen(value: Any, name: str, known: dict[str, int]) -> int:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} is {value!r}; use " + ", ".join(f'"{one}"' for one in known))
    return known[value]


def _put_view(out: Any, view: Optional[Sequence[float]], rows: Optional[int], columns: Optional[int]) -> None:
    if view is not None:
        try:
            out.left_deg, out.right_deg, out.top_deg, out.bottom_deg = view
        except (TypeError, ValueError):
            raise ValueError(f"view is {view!r}; use four numbers in degrees: left, right, top, bottom, such as "
                             "(60, -60, 3, -17)") from None
    for name, value in (("rows", rows), ("columns", columns)):
        if value is not None:
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 < value <= lib.LUM_IMAGE_PIXELS_MAX:
                raise ValueError(f"{name} is {value!r}; use a whole number from 1")
            setattr(out, name, int(value))
    if lib.lum_image_scale_init(ffi.new("lum_image_scale *"), out) != lib.LUM_OK:
        raise ValueError(f"the view of {out.left_deg:g}, {out.right_deg:g}, {out.top_deg:g}, {out.bottom_deg:g} degrees in "
                         f"{out.rows} rows and {out.columns} columns is impossible; use left above right by at most 360, top above "
                         f"bottom within 90 and -90, and at most {lib.LUM_IMAGE_PIXELS_MAX} pixels")


def _floats(array: Any) -> Any:
    return ffi.from_buffer("float[]", np.ascontiguousarray(array, "f4"))


def _eyes(frame: Frame) -> Array:
    """The eye of each point."""
    if len(frame.lines) or not len(frame):
        return np.repeat(frame.lines["eye"], frame.lines["point_count"])
    if "eye" not in frame.columns:
        raise OptionError(f"frame {frame.number} has neither lines nor the column eye, so the eye of its points "
                          'is not known; use eye="both"')
    return np.ascontiguousarray(frame["eye"])


def _seen_by_its_sensor(frame: Frame) -> list[Array]:
    """x, y and z, of a frame of a rig in its sensor's own frame."""
    pose = frame.pose
    if pose is None or frame._moved == "world":
        return [frame["x"], frame["y"], frame["z"]]
    return list(pose[:3, :3].T @ (frame.xyz.T.astype("f8") - pose[:3, 3:]))


def index(frame: Frame, eye: str, returns: str, view: Optional[Sequence[float]], rows: Optional[int], columns: Optional[int],
          pixels: bool) -> Array:
    """The point of each pixel, or with pixels the pixel of each point."""
    options, points, counts = sized("lum_image_options"), sized("lum_image_points"), sized("lum_image_counts")
    options.eyes, options.choice = _chosen(eye, "eye", EYES), _chosen(returns, "returns", CHOICES)
    asked = [i for i in range(2) if options.eyes >> i & 1]
    lib.lum_image_view_default(ffi.addressof(options, "view"), options.eyes, max(frame._info.rows[i] for i in asked))
    _put_view(ffi.addressof(options, "view"), view, rows, columns)
    kept = {name: _floats(array) for name, array in zip(("x", "y", "z"), _seen_by_its_sensor(frame))}
    if returns == "strongest":
        kept["pulse_width"] = _floats(frame["pulse_width"])
    if len(asked) == 1:
        kept["eye"] = ffi.from_buffer("uint8_t[]", _eyes(frame))
    points.count = len(frame)
    for name, array in kept.items():
        setattr(points, name, array)
    out = np.empty((options.view.rows, options.view.columns), "u4")
    lie = np.empty(len(frame), "u4") if pixels else None
    result = lib.lum_image_index(points, options, ffi.from_buffer("uint32_t[]", out),
                                 ffi.NULL if lie is None else ffi.from_buffer("uint32_t[]", lie), counts)
    if result != lib.LUM_OK:
        raise RuntimeError(f"lum_image_index() refused frame {frame.number}: this is a fault of lumsdk")
    if counts.outside:
        v = options.view
        warn(f"frame {frame.number}: {counts.outside} of {counts.filled + counts.hidden + counts.outside} points lie outside of "
             f"the picture, which shows azimuths from {v.left_deg:g} to {v.right_deg:g} and elevations from {v.top_deg:g} to "
             f"{v.bottom_deg:g} degrees; view= sets what it shows")
    return (out if lie is None else lie).view(np.int32)


def take(frame: Frame, column: AnyColumn, chosen: Array) -> Floats:
    """A column in the pixels of an index: NaN for -1."""
    out: Floats = np.empty(chosen.shape, "f4")
    numbers = np.ascontiguousarray(floats(frame, column))
    if lib.lum_image_take(ffi.from_buffer("float[]", numbers), len(frame), ffi.from_buffer("uint32_t[]", chosen.view("u4")),
                          chosen.size, ffi.from_buffer("float[]", out, require_writable=True)) != lib.LUM_OK:
        raise RuntimeError("lum_image_take() refused an index: this is a fault of lumsdk")
    return out
