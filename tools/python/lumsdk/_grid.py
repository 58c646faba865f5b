"""Columns of a frame as grids: lines by pixels."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._c import ffi, lib
from ._errors import OptionError, warn

if TYPE_CHECKING:
    from ._frame import Frame
    from ._types import Array

EYES = ("blue", "green")

PIXELS = int(lib.LUM_LINE_PIXELS)

JOINED = -1
"""In place of a member of a rig: points of several."""


def _count(value: Any, name: str) -> int:
    """A whole number from 0 on."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} is {value!r}; use a whole number")
    if value < 0:
        raise ValueError(f"{name} is {value}; use a whole number from 0")
    return int(value)


def _eye(frame: Frame, eye: Union[str, int, None]) -> int:
    if eye is None:
        present = [i for i, count in enumerate(frame._info.lines) if count]
        if len(present) > 1:
            raise ValueError('the frame has lines of both eyes: use eye="blue" or eye="green"')
        return present[0] if present else 0
    if isinstance(eye, str) and eye in EYES:
        return EYES.index(eye)
    raise ValueError(f'eye is {eye!r}; use "blue" or "green"')


def _believed_rows(frame: Frame, eye: int) -> int:
    rows = frame._info.rows[eye]
    lines = frame.lines
    beyond = lines[(lines["eye"] == eye) & (lines["number"] >= rows) & (lines["point_count"] > 0)]
    if len(beyond):
        numbers = ", ".join(str(number) for number in beyond["number"][:3])
        warn(f"frame {frame.number}: lines of the {EYES[eye]} eye without a row in the grid: {len(beyond)}, with "
             f"{beyond['point_count'].sum()} points: numbers as far from those of whole lines as {numbers} "
             "come from damaged packets; lines= sets how many rows there are")
    return rows


def grid(frame: Frame, column: str, eye: Optional[str], returns: int, lines: Optional[int]) -> Array:
    """As Frame.grid() has it."""
    if frame._info.member == JOINED:
        raise OptionError(f"the frame has points of several sensors, {frame.sensor}, whose lines have the same numbers; make "
                          "the grid of one sensor's frame")
    which = _eye(frame, eye)
    if column == "xyz":
        return np.stack([grid(frame, name, eye, returns, lines) for name in column], axis=-1)
    for name in (column, "pixel"):
        if name not in frame.columns:
            raise frame._refuse(name)
    rows = _believed_rows(frame, which) if lines is None else _count(lines, "lines")
    if _count(returns, "returns") < 1:
        raise ValueError("returns is 0; use a whole number from 1")
    out = np.empty((rows, PIXELS, returns), "f4")
    if len(frame) and not len(frame.lines):
        raise OptionError(f"frame {frame.number} has no lines, so there is no grid of it: give Frame.from_arrays() the columns line "
                          "and eye, or lines=")
    number = frame._number_of(column)
    if number is None:
        _fill(frame, column, which, out)
    elif out.size:
        lib.lum_frame_grid_floats(frame._c, number, which, rows, returns, ffi.cast("float *", ffi.from_buffer(out)))
    return out if returns > 1 else out[:, :, 0]


def floats(frame: Frame, column: str) -> Array:
    """A column as float32.

    Raises:
        OptionError: whole numbers of a column of one's own that float32 cannot hold.
    """
    numbers = frame._array(column)
    made = np.asarray(numbers, "f4")
    if column in frame._own and numbers.dtype.kind in "iu" and (made.astype("f8") != numbers).any():
        raise OptionError(f"{column}: float32, the type of grids and pictures, cannot hold all its numbers exactly; use whole "
                          "numbers up to 16777216, or the numbers of points by image_index()")
    return made


def _fill(frame: Frame, column: str, eye: int, out: Array) -> None:
    """As lum_frame_grid_floats(), of arrays."""
    out.fill(np.nan)
    rows, _, returns = out.shape
    lines = frame.lines
    numbers = lines["number"].astype("i8")
    possible = np.flatnonzero((lines["eye"] == eye) & (numbers < rows) & (lines["point_count"] > 0))
    shown = np.zeros(len(lines), bool)
    shown[possible[np.unique(numbers[possible], return_index=True)[1]]] = True  # of lines with one number the first
    points = np.flatnonzero(np.repeat(shown, lines["point_count"]))
    if not len(points):
        return
    cells = np.repeat(numbers, lines["point_count"])[points] * PIXELS + frame["pixel"][points]
    if (cells[1:] < cells[:-1]).any():
        order = np.argsort(cells, kind="stable")
        points, cells = points[order], cells[order]
    places = np.arange(len(cells))
    rank = places - np.maximum.accumulate(np.where(np.r_[True, cells[1:] != cells[:-1]], places, 0))
    kept = rank < returns
    out.reshape(-1, returns)[cells[kept], rank[kept]] = floats(frame, column)[points[kept]]
