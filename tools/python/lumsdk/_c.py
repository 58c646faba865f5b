"""The C library: its functions by their names, and what every call of one needs."""
from __future__ import annotations

import os
import sys
from typing import Any

from ._declarations import ffi as _ffi  # type: ignore[import-not-found,import-untyped,unused-ignore]
from ._errors import Error

_NAMES = {"darwin": "liblumsdk.dylib", "win32": "liblumsdk.dll", "cygwin": "liblumsdk.dll"}

ffi: Any = _ffi


def _load() -> Any:
    """The library, for good: what is freed at the very end of the interpreter calls it still."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), _NAMES.get(sys.platform, "liblumsdk.so"))
    if hasattr(ffi, "RTLD_NODELETE"):
        return ffi.dlopen(path, ffi.RTLD_NOW | ffi.RTLD_NODELETE)
    import ctypes  # Windows has no such flag, but counts who has loaded it

    ctypes.CDLL(path)
    return ffi.dlopen(path)


lib: Any = _load()


def sized(name: str, **values: Any) -> Any:
    """A struct that tells its size, otherwise zero but for the values."""
    made = ffi.new(f"{name} *", values)
    made.struct_size = ffi.sizeof(name)
    return made


def text(pointer: Any) -> str:
    """A C string, whatever its bytes are."""
    raw: bytes = ffi.string(pointer)
    return raw.decode(errors="replace")


def failure(error: Any, kind: type[Error] = Error) -> Error:
    """The exception for a message of the library."""
    return kind(text(error.text))


def check(status: int, error: Any, kind: type[Error] = Error) -> None:
    """Raise what a call of the library said, if it failed."""
    if status != 0:
        raise failure(error, kind)


def address_of(number: int) -> str:
    """An address in host order as a.b.c.d."""
    return ".".join(str(number >> shift & 255) for shift in (24, 16, 8, 0))


def number_of(address: str) -> int:
    """a.b.c.d as an address in host order."""
    number = 0
    for part in address.split("."):
        number = number << 8 | int(part)
    return number


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


VERSION = f"{lib.LUM_VERSION_MAJOR}.{lib.LUM_VERSION_MINOR}.{lib.LUM_VERSION_PATCH}"

LOSSES = ("lost_words", "lines_missing_angles", "lines_skipped", "lines_missing", "lines_in_pauses", "pauses",
          "lines_cut", "lines_late", "points_cut", "points_late", "no_angle", "no_range", "bad_words", "late",
          "duplicate", "conflict", "no_room", "stray", "out_of_order", "malformed", "unknown_tag", "unknown_type",
          "cut_short", "foreign", "other", "damaged", "lines_under_way", "words_under_way", "no_angle_under_way",
          "missing_under_way", "stray_at_breaks")
"""What is lost, by the names that lumdump's JSON has."""
