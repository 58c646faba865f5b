"""The columns that frames of the library have, and their memory as arrays."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, Optional

import numpy as np

from ._c import ffi, lib, text

_TYPES: dict[int, np.dtype[Any]] = {lib.LUM_TYPE_FLOAT: np.dtype("f4"), lib.LUM_TYPE_UINT32: np.dtype("u4"),
          lib.LUM_TYPE_UINT16: np.dtype("u2"), lib.LUM_TYPE_UINT8: np.dtype("u1")}

NUMBERS: dict[str, int] = {text(lib.lum_column_name(c)): c for c in range(lib.LUM_COLUMN_COUNT)}

COLUMNS: Mapping[str, np.dtype[Any]] = MappingProxyType(
    {name: _TYPES[lib.lum_column_get_type(c)] for name, c in NUMBERS.items()})
"""Every column that a frame can have, and the type of its numbers."""


def _format(c: Any) -> Any:
    if c.kind == "array":
        return _format(c.item), (c.length,)
    return {"float": "f4", "size_t": "uintp"}.get(c.cname, c.cname[:-len("_t")])


def struct_dtype(name: str) -> np.dtype[Any]:
    """The layout of a struct of the library."""
    fields = dict(ffi.typeof(name).fields)
    return np.dtype({"names": list(fields), "formats": [_format(field.type) for field in fields.values()],
                     "offsets": [field.offset for field in fields.values()], "itemsize": ffi.sizeof(name)})


_ROWS = 4096
"""As many records stay in a cache while all of their fields are filled."""


def fill(out: np.ndarray[Any, np.dtype[Any]], columns: Iterable[np.ndarray[Any, np.dtype[Any]]]) -> None:
    """Columns into a structured array, in the order of its fields."""
    pairs = [(out[name], column) for name, column in zip(out.dtype.names or (), columns)]
    for first in range(0, len(out), _ROWS):
        for field, column in pairs:
            field[first:first + _ROWS] = column[first:first + _ROWS]


class Memory:
    """Memory of a frame, which keeps the frame alive: the base of every array of it."""

    __slots__ = ("__array_interface__", "owner")

    def __init__(self, owner: Any, address: int, shape: tuple[int, ...], strides: Optional[tuple[int, ...]],
                 dtype: np.dtype[Any]) -> None:
        self.owner = owner
        self.__array_interface__ = {"version": 3, "data": (address, False), "shape": shape, "strides": strides,
                                    "typestr": dtype.str}
