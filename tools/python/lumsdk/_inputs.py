"""Where the bytes of captures come from: files, memory, file objects, URLs."""
from __future__ import annotations

import glob
import io
import os
import re
import stat
from collections.abc import Callable, Sequence
from typing import Any, Optional

from ._c import ffi, lib, sized, text
from ._errors import CaptureError, Error, OptionError

RIGHT = ('right is a path, a pattern such as "drive-*.pcap", a list of paths, the bytes of a capture, a binary file '
         "object or a URL")


def _raise(error: Any) -> None:
    raise CaptureError(text(error.text))


class _File:
    """A binary file object, as the library calls it. It does not know its callback, so that no cycle keeps a file open."""

    def __init__(self, file: Any, name: str) -> None:
        self.name = name
        self.problem: Optional[BaseException] = None
        self._file = file
        self._into = getattr(file, "readinto", None)

    def note(self, _: Any, problem: Any, __: Any) -> None:
        """What fill() raised."""
        self.problem = problem

    def fill(self, _: Any, buffer: Any, room: int, error: Any) -> int:
        """Called in the thread that reads."""
        try:
            return self._take(buffer, room)
        except BaseException as problem:
            said = f"{self.name}: {type(problem).__name__}: {problem}".encode(errors="replace")
            ffi.memmove(error.text, said[:lib.LUM_ERROR_BYTES - 1] + b"\0", min(len(said) + 1, lib.LUM_ERROR_BYTES))
            raise

    def _take(self, buffer: Any, room: int) -> int:
        if self._into is not None:
            count = self._into(memoryview(ffi.buffer(buffer, room)).cast("B"))
        else:
            got = self._file.read(room)
            if got is not None and not isinstance(got, (bytes, bytearray, memoryview)):
                raise TypeError(f"its read() gives {type(got).__name__}; right is bytes, as of a file that is opened "
                                'with mode "rb"')
            count = None if got is None else len(got)
            if count is not None and count <= room:
                ffi.memmove(buffer, got, count)
        if count is None:
            raise BlockingIOError("it has no bytes at present; right is a file that waits for them")
        if not 0 <= count <= room:
            raise ValueError(f"{count} bytes were read where {room} were asked for")
        return int(count)


class Functions:
    """The functions of a lum_source for a binary file object. What the object raises is kept."""

    def __init__(self, file: Any, name: str) -> None:
        self._state = _File(file, name)
        self._read = ffi.callback("int64_t(void *, void *, size_t, lum_error *)", self._state.fill, error=-1,
                                  onerror=self._state.note)
        self.functions = sized("lum_source_functions", read=self._read)

    @property
    def problem(self) -> Optional[BaseException]:
        """What the object raised."""
        return self._state.problem


class Input:
    """A source of bytes that readers can be opened on."""

    name: str
    is_kept = False  # whether an index can stand beside it

    def ask(self) -> Any:
        """An open capture for its comments, as by ffi.gc(); None: there is none that can be asked."""
        return None

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        """The members of lum_reader_options for a reading from the start. kept gets what has to outlive it."""
        raise NotImplementedError

    def close(self) -> None:
        """Nothing is read any more."""


def _capture(status: int, out: Any, error: Any) -> Any:
    if status != 0:
        _raise(error)
    return ffi.gc(out[0], lib.lum_capture_close)


def _is_regular(path: Any) -> bool:
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return False


class Files(Input):
    """Paths, read as one."""

    def __init__(self, paths: Sequence[Any]) -> None:
        self.paths = [os.fsdecode(path) for path in paths]
        more = len(paths) - 1
        self.name = f"{self.paths[0]} and {more} more" if more else self.paths[0]
        self._check_twice()

    def _check_twice(self) -> None:
        seen: dict[tuple[int, int], str] = {}
        for path in self.paths:
            try:
                found = os.stat(path)
            except OSError:
                if not re.fullmatch(r"(\d+\.){3}\d+(:\d+)?", path):
                    continue
                raise CaptureError(f"{path}: there is no such file; a sensor is read by lumsdk.Sensor({path!r})") from None
            key = found.st_dev, found.st_ino
            if found.st_ino and key in seen:
                raise OptionError(f"{seen[key]} and {path} are one file: name each source once")
            seen[key] = path

    def _array(self, paths: Sequence[str], kept: list[Any]) -> Any:
        names = [ffi.new("char[]", os.fsencode(path)) for path in paths]
        made = ffi.new("const char *[]", names)
        kept += [*names, made]
        return made

    def ask(self) -> Any:
        paths = [path for path in self.paths if _is_regular(path)]
        kept: list[Any] = []
        if not paths:
            return None
        out = ffi.new("lum_capture **")
        if lib.lum_capture_open_several(self._array(paths, kept), len(paths), out, ffi.NULL) != 0:
            return None  # the reader tells why
        return ffi.gc(out[0], lib.lum_capture_close)

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        array = self._array(self.paths, kept)
        if len(self.paths) == 1:
            return {"path": array[0]}, None
        return {"paths": array, "path_count": len(self.paths)}, None


class Memory(Input):
    """The bytes of a capture."""

    def __init__(self, content: Any) -> None:
        self._buffer = ffi.from_buffer(content)
        self.name = f"{len(self._buffer)} bytes"

    def _source(self) -> Any:
        made = lib.lum_source_from_memory(self.name.encode(), self._buffer, len(self._buffer))
        if not made:
            raise MemoryError
        return made

    def ask(self) -> Any:
        out = ffi.new("lum_capture **")
        if lib.lum_capture_open_source(self._source(), out, ffi.NULL) != 0:
            return None
        return ffi.gc(out[0], lib.lum_capture_close)

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        kept.append(self._buffer)
        return {"source": self._source()}, None


class Stream(Input):
    """A file object. The capture that was asked is the one that is read: what has been read cannot be read again."""

    def __init__(self, file: Any, name: str) -> None:
        self.name = name
        self._file = file
        self._start = self._tell()
        self._opened: Optional[tuple[Any, Functions]] = None
        self._used = False

    def _tell(self) -> Optional[int]:
        """Where it begins; None: it cannot be read again."""
        try:
            return int(self._file.tell()) if self._file.seekable() else None
        except Exception:
            return None

    def _rewind(self) -> Any:
        if self._used:
            if self._start is None:
                raise Error(f"{self.name}: it can be read only once, since it cannot seek; open it again, or give a path")
            self._file.seek(self._start)
        self._used = True
        return self._file

    def _open(self) -> tuple[Any, Functions]:
        functions = Functions(self._rewind(), self.name)
        out, error = ffi.new("lum_capture **"), ffi.new("lum_error *")
        source = lib.lum_source_from_functions(self.name.encode(errors="replace"), functions.functions, error)
        status = lib.lum_capture_open_source(source, out, error) if source else -1
        if functions.problem is not None:
            raise functions.problem
        return _capture(status, out, error), functions

    def ask(self) -> Any:
        self._opened = self._open()
        return self._opened[0]

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        opened, self._opened = self._opened, None
        capture, functions = opened or self._open()
        ffi.gc(capture, None)  # the reader's now
        records = sized("lum_record_source", context=capture,
                        next=ffi.cast("int (*)(void *, lum_record *, lum_error *)", lib.lum_capture_next),
                        progress=ffi.cast("void (*)(void *, uint64_t *, uint64_t *)", lib.lum_capture_progress),
                        close=ffi.cast("void (*)(void *)", lib.lum_capture_close))
        kept += [functions, records]
        return {"records": records}, functions

    def close(self) -> None:
        self._opened = None


class Opened(Stream):
    """A file object of our own, opened anew for each reading."""

    def __init__(self, opener: Callable[[], Any], name: str) -> None:
        self._opener = opener
        self._files: list[Any] = []
        super().__init__(None, name)

    def _rewind(self) -> Any:
        self._files.append(self._opener())
        return self._files[-1]

    def close(self) -> None:
        super().close()
        for file in self._files:
            file.close()
        self._files.clear()


def _is_url(name: str) -> bool:
    return re.match(r"[A-Za-z][A-Za-z0-9+.-]*(::[A-Za-z][A-Za-z0-9+.-]*)*://", name) is not None


def _fsspec(url: str) -> Any:
    if url.startswith("udp://"):
        raise OptionError(f"{url}: a sensor is no capture; it is read by lumsdk.Sensor({url[6:]!r})")
    try:
        import fsspec  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        raise OptionError(f"{url}: a URL needs fsspec: pip install lumsdk[url]") from None
    return fsspec


def _open_url(url: str) -> Input:
    fsspec = _fsspec(url)
    try:
        files = fsspec.open_files(url, "rb")
    except ImportError as error:
        raise OptionError(f"{url}: {error}") from error
    if not files:
        raise CaptureError(f"{url}: no file has such a name")
    if len(files) > 1:
        return Files(_fetch(url))
    return Opened(files[0].open, url)


def _fetch(url: str) -> list[str]:
    """Files of several URLs on this machine: they are read as one, by their times."""
    return [str(path) for path in _fsspec(url).open_local(f"simplecache::{url}", mode="rb")] \
        if glob.has_magic(url) else [str(_fsspec(url).open_local(f"simplecache::{url}", mode="rb"))]


def _paths(given: Any) -> list[Any]:
    """A path, or those that a pattern means."""
    if isinstance(given, str) and _is_url(given):
        return _fetch(given)
    if not isinstance(given, (str, os.PathLike)):
        raise TypeError(f"a source in a list is {given!r}, of type {type(given).__name__}; right is a path, a pattern "
                        "or a URL: captures in memory and file objects are read alone")
    name = os.fsdecode(given)
    if not glob.has_magic(name) or os.path.lexists(name):
        return [given]
    found = sorted(glob.glob(name))
    if not found:
        raise CaptureError(f"{name}: no file has such a name")
    return list(found)


def _of_files(paths: list[Any]) -> Input:
    """Files; standard input and pipes are waited for in Python, so that Ctrl-C ends that too."""
    if not paths:
        raise OptionError("no capture is named; " + RIGHT)
    name = os.fsdecode(paths[0])
    if len(paths) == 1 and name == "-":
        return Opened(lambda: open(0, "rb", closefd=False, buffering=0), "standard input")
    if len(paths) == 1 and os.path.exists(name) and not os.path.isdir(name) and not _is_regular(name):
        return Opened(lambda: open(name, "rb", buffering=0), name)
    return Files(paths)


def open_input(given: Any) -> Input:
    """The input that a program names."""
    if isinstance(given, str) and _is_url(given):
        return _open_url(given)
    if isinstance(given, (str, os.PathLike)):
        return _of_files(_paths(given))
    if isinstance(given, (list, tuple)):
        return _of_files([path for each in given for path in _paths(each)])
    try:
        return Memory(given)
    except (TypeError, BufferError, ValueError):
        pass
    if isinstance(given, io.TextIOBase):
        raise TypeError('the file object is opened as text; right is mode "rb"')
    if callable(getattr(given, "read", None)):
        return Stream(given, str(getattr(given, "name", "the file object")))
    raise TypeError(f"a source is given as {type(given).__name__}; {RIGHT}")
