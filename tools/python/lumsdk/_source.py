"""Captures as sources of frames."""
from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

from ._c import failure, ffi, lib, sized
from ._errors import CaptureError, ClosedError
from ._frame import Frame


class Source:
    """A capture, or several as one. Iteration gives its frames."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._kept = [ffi.new("char[]", os.fsencode(path))]
        options = sized("lum_reader_options", path=self._kept[0])
        error = ffi.new("lum_error *")
        reader = ffi.new("lum_reader **")
        if lib.lum_reader_open(options, reader, error) != 0:
            raise failure(error, CaptureError)
        self._reader: Any = reader[0]

    def __iter__(self) -> Iterator[Frame]:
        out = ffi.new("const lum_frame **")
        error = ffi.new("lum_error *")
        while True:
            if not self._reader:
                raise ClosedError("the source is closed")
            status = lib.lum_reader_next_frame(self._reader, out, error)
            if status < 0:
                raise failure(error, CaptureError)
            if status == 0:
                return
            yield Frame(out[0])

    def close(self) -> None:
        """Close; frames and arrays of it stay valid."""
        if self._reader:
            lib.lum_reader_close(self._reader)
        self._reader = None

    def __enter__(self) -> Source:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open(path: str | os.PathLike[str]) -> Source:
    """Open a capture."""
    return Source(path)
