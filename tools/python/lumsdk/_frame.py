"""A frame: all points of one sweep of one sensor, as arrays."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._c import ffi, lib, sized, text

_TYPES = {lib.LUM_TYPE_FLOAT: np.dtype("f4"), lib.LUM_TYPE_UINT32: np.dtype("u4"),
          lib.LUM_TYPE_UINT16: np.dtype("u2"), lib.LUM_TYPE_UINT8: np.dtype("u1")}

COLUMNS: dict[str, int] = {text(lib.lum_column_name(c)): c for c in range(lib.LUM_COLUMN_COUNT)}
"""The name of every column, and its number in C."""

DTYPES: dict[str, np.dtype[Any]] = {name: _TYPES[lib.lum_column_get_type(c)] for name, c in COLUMNS.items()}
"""The type of every column."""


class _Memory:
    """Memory of a frame, which keeps the frame alive: the base of every array of it."""

    def __init__(self, owner: Any, address: int, shape: tuple[int, ...], strides: tuple[int, ...] | None, dtype: np.dtype[Any]):
        self.owner = owner
        self.__array_interface__ = {"version": 3, "data": (address, False), "shape": shape, "strides": strides,
                                    "typestr": dtype.str}


class Frame:
    """All points of one sweep of one sensor. Its arrays stay valid after it, and after its source."""

    def __init__(self, pointer: Any) -> None:
        """Keep a frame of the library."""
        self._c = ffi.gc(lib.lum_frame_keep(pointer), lib.lum_frame_release)
        self._info = sized("lum_frame_info")
        lib.lum_frame_get_info(self._c, self._info)
        self._count: int = lib.lum_frame_count(self._c)

    def __len__(self) -> int:
        return self._count

    @property
    def number(self) -> int:
        """Frame number."""
        return int(self._info.number)

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that the frame has."""
        mask = lib.lum_frame_columns(self._c)
        return tuple(name for name, c in COLUMNS.items() if mask >> c & 1)

    def __getitem__(self, name: str) -> np.ndarray[Any, Any]:
        """A column: one value a point, a view of the frame's memory."""
        pointer = lib.lum_frame_column(self._c, COLUMNS[name])
        return np.asarray(_Memory(self._c, int(ffi.cast("uintptr_t", pointer)), (self._count,), None, DTYPES[name]))

    @property
    def xyz(self) -> np.ndarray[Any, Any]:
        """x, y and z in metres: (n, 3) float32."""
        return np.column_stack([self["x"], self["y"], self["z"]])
