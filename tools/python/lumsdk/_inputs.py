"""Where the bytes of captures come from: files, memory, file objects, URLs."""
from __future__ import annotations

import contextlib
import glob
import io
import os
import re
import reprlib
import stat
from _thread import allocate_lock
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Optional

from ._c import check, ffi, lib, sized
from ._errors import CaptureError, Error, OptionError, install

RIGHT = ('use a path, a pattern such as "drive-*.pcap", a list of paths, the bytes of a capture, a binary file '
         "object or a URL")

ENDINGS = re.compile(r"\.(pcap|pcapng|cap)(\.(gz|zst))?$", re.I)
"""What the names of captures end in, where a folder has other files too."""


class _Shared:
    """A binary file object that several readings use by turns, each at its own place."""

    def __init__(self, file: Any, name: str) -> None:
        self.file, self.name = file, name
        self.lock = allocate_lock()
        self.user: Any = None  # a token of who read it last
        self.into = getattr(file, "readinto", None)
        self.start: Optional[int] = None  # where it begins; None: it cannot be read again
        self.total = 0
        try:
            if file.seekable():
                start = int(file.tell())
                self.total = max(int(file.seek(0, os.SEEK_END)) - start, 0)
                file.seek(start)
                self.start = start
        except (AttributeError, OSError, ValueError):
            pass

    def take(self, buffer: Any, room: int) -> int:
        """Read into memory of the library."""
        if self.into is not None:
            count = self.into(memoryview(ffi.buffer(buffer, room)).cast("B"))
        else:
            got = self.file.read(room)
            if got is not None and not isinstance(got, (bytes, bytearray, memoryview)):
                raise TypeError(f"its read() gives {type(got).__name__}; use bytes, as of a file that is opened "
                                'with mode "rb"')
            count = None if got is None else len(got)
            if count is not None and count <= room:
                ffi.memmove(buffer, got, count)
        if count is None:
            raise BlockingIOError("it has no bytes at present; use a file that waits for them")
        if not 0 <= count <= room:
            raise ValueError(f"{count} bytes were read where {room} were asked for")
        return int(count)


class _User:
    """One reading of a file object, as the library calls it. It does not know its callbacks, so that no cycle keeps a
    file open."""

    def __init__(self, shared: _Shared) -> None:
        self.shared = shared
        self.problem: Optional[BaseException] = None
        self.token = object()
        self.at = 0

    def note(self, _: Any, problem: Any, __: Any) -> None:
        """What a callback raised."""
        self.problem = problem

    def read(self, _: Any, buffer: Any, room: int, error: Any) -> int:
        """Called in the thread that reads."""
        shared = self.shared
        try:
            with shared.lock:
                if shared.user is not self.token and shared.start is not None:
                    shared.file.seek(shared.start + self.at)
                shared.user = self.token
                count = shared.take(buffer, room)
            self.at += count
            return count
        except BaseException as problem:
            said = f"{shared.name}: {type(problem).__name__}: {problem}".encode(errors="replace")
            ffi.memmove(error.text, said[:lib.LUM_ERROR_BYTES - 1] + b"\0", min(len(said) + 1, lib.LUM_ERROR_BYTES))
            raise

    def seek(self, _: Any, offset: int, __: Any) -> int:
        """Go on from another place, with the next read."""
        self.at, self.shared.user = offset, None
        return 0


class Functions:
    """The functions of a lum_source for a binary file object. What the object raises is kept."""

    def __init__(self, shared: _Shared) -> None:
        self._user = _User(shared)
        self._read = ffi.callback("int64_t(void *, void *, size_t, lum_error *)", self._user.read, error=-1,
                                  onerror=self._user.note)
        self._functions = sized("lum_source_functions", read=self._read, total=shared.total)
        if shared.start is not None:
            self._seek = ffi.callback("int(void *, uint64_t, lum_error *)", self._user.seek, error=-1,
                                      onerror=self._user.note)
            self._functions.seek = self._seek

    def open(self) -> Any:
        """A source of the library."""
        error = ffi.new("lum_error *")
        made = lib.lum_source_from_functions(self._user.shared.name.encode(errors="replace"), self._functions, error)
        check(0 if made else -1, error, CaptureError)
        return made

    @property
    def problem(self) -> Optional[BaseException]:
        """What the object raised."""
        return self._user.problem


class Input:
    """A source of bytes that readers can be opened on."""

    name: str
    given: Any = None
    """What open() needs to read the same in any process; None: it cannot."""
    files: tuple[str, ...] = ()
    """Paths from the root of the files that it reads, as far as they are known."""
    storage: Optional[Mapping[str, Any]] = None
    """The storage_options that go with it."""

    @property
    def can_reopen(self) -> bool:
        """Whether it can be read more than once."""
        return True

    def after_fork(self) -> None:
        """In a process that was forked: share no place in a file with its parent."""

    def ask(self) -> Any:
        """An open capture for its comments, as by ffi.gc(); None: there is none that can be asked."""
        return None

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        """The members of lum_reader_options for a reading from the start. kept gets what has to outlive it."""
        raise NotImplementedError

    def close(self) -> None:
        """Nothing is read any more."""


def _is_regular(path: Any) -> bool:
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return False


def _forked(name: str) -> Error:
    return Error(f"{name}: it was opened before this process was forked, and reading it in both would mix its bytes; open "
                 "it in the process that reads it")


class Files(Input):
    """Paths, read as one."""

    def __init__(self, paths: Sequence[Any]) -> None:
        self.paths = [os.fsdecode(path) for path in paths]
        more = len(paths) - 1
        self.name = f"{self.paths[0]} and {more} more" if more else self.paths[0]
        if all(not os.path.exists(path) or _is_regular(path) for path in self.paths):
            self.given = [os.path.abspath(path) for path in self.paths]
        self._full = self.given or self.paths
        self.files = tuple(map(os.path.abspath, self.paths))
        self._found: dict[tuple[int, int], str] = {}
        self._check_twice()

    @property
    def can_reopen(self) -> bool:
        """Not a pipe."""
        return self.given is not None

    def after_fork(self) -> None:
        """A pipe gives each of its bytes to one process."""
        if not self.can_reopen:
            raise _forked(self.name)

    def _check_twice(self) -> None:
        seen = self._found
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

    def _same_paths(self) -> list[str]:
        """The paths of the files that it was opened with; where the working directory has changed, from the root."""
        if not self.can_reopen:
            return self.paths
        for path in self._full:
            with contextlib.suppress(FileNotFoundError):  # the reader tells it
                found = os.stat(path)
                if found.st_ino and self._found and (found.st_dev, found.st_ino) not in self._found:
                    raise Error(f"{path}: another file has had this name since it was opened; open it again")
        return [path if os.path.abspath(path) == full else full for path, full in zip(self.paths, self._full)]

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
        array = self._array(self._same_paths(), kept)
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


def _open_again(file: Any) -> Any:
    """The file that a file object reads, opened once more; None: it is not known, or another one has its name."""
    name = getattr(file, "name", None)
    if not isinstance(file, (io.BufferedReader, io.FileIO)) or not isinstance(name, (str, bytes)):
        return None
    try:
        again = open(name, "rb")
        if os.path.samestat(os.fstat(again.fileno()), os.fstat(file.fileno())):
            return again
        again.close()
    except (OSError, ValueError):
        pass
    return None


class Stream(Input):
    """A file object. One that cannot seek is read once: the capture that was asked for its comments is read on."""

    def __init__(self, file: Any, name: str, is_own: bool = False) -> None:
        self.name = name
        self._files = [file] if is_own else []  # to be closed
        self._shared = _Shared(file, name)
        path = getattr(file, "name", None)
        self.files = (os.path.abspath(path),) if isinstance(path, str) and _is_regular(path) else ()
        self._opened: Optional[tuple[Any, Functions]] = None
        self._used = False

    @property
    def can_reopen(self) -> bool:
        """A file that can seek is read again from its start."""
        return self._shared.start is not None

    def after_fork(self) -> None:
        """A file of the disk is opened by its name; a place that two processes move gives wrong bytes in silence."""
        shared = self._shared
        if isinstance(shared.file, io.BytesIO):  # this process has a copy
            shared.lock = allocate_lock()
            return
        file = _open_again(shared.file) if shared.start is not None else None
        if file is None:
            raise _forked(self.name)
        file.seek(shared.start)
        self._files, self._shared = [file], _Shared(file, self.name)

    def _share(self) -> _Shared:
        """The file object for a reading."""
        if self._used and self._shared.start is None:
            raise Error(f"{self.name}: it can be read only once, since it cannot seek; open it again, or give a path")
        self._used = True
        return self._shared

    def _rewind(self) -> Any:
        """The file object at its start, for a program that reads it itself."""
        shared = self._share()
        if shared.start is not None:
            shared.file.seek(shared.start)
            shared.user = None
        return shared.file

    def ask(self) -> Any:
        shared = self._share()
        functions = Functions(shared)
        out, error = ffi.new("lum_capture **"), ffi.new("lum_error *")
        status = lib.lum_capture_open_source(functions.open(), out, error)
        if functions.problem is not None:
            raise functions.problem
        check(status, error, CaptureError)
        capture = ffi.gc(out[0], lib.lum_capture_close)
        self._opened = (capture, functions) if shared.start is None else None
        return capture

    def begin(self, kept: list[Any]) -> tuple[dict[str, Any], Optional[Functions]]:
        opened, self._opened = self._opened, None
        if opened is None:
            functions = Functions(self._share())
            kept.append(functions)
            return {"source": functions.open()}, functions
        capture, functions = opened
        ffi.gc(capture, None)  # the reader's now
        records = sized("lum_record_source", context=capture,
                        next=ffi.cast("int (*)(void *, lum_record *, lum_error *)", lib.lum_capture_next),
                        progress=ffi.cast("void (*)(void *, uint64_t *, uint64_t *)", lib.lum_capture_progress),
                        close=ffi.cast("void (*)(void *)", lib.lum_capture_close))
        kept += [functions, records]
        return {"records": records}, functions

    def close(self) -> None:
        self._opened = None
        for file in self._files:
            file.close()
        self._files.clear()


class Opened(Stream):
    """A file object of our own that is opened anew for each reading."""

    def __init__(self, opener: Callable[[], Any], name: str) -> None:
        super().__init__(opener(), name, True)
        self._opener = opener

    @property
    def can_reopen(self) -> bool:
        """By its opener."""
        return True

    def after_fork(self) -> None:
        """The file object before stays that of the other process."""
        self._files = [self._opener()]
        self._shared = _Shared(self._files[0], self.name)
        self._used = False

    def _share(self) -> _Shared:
        if self._used and self._shared.start is None:
            self._files.append(self._opener())
            self._shared = _Shared(self._files[-1], self.name)
        self._used = True
        return self._shared


def _is_url(given: Any) -> bool:
    return isinstance(given, str) and re.match(r"[A-Za-z][A-Za-z0-9+.-]*(::[A-Za-z][A-Za-z0-9+.-]*)*://", given) is not None


def _fsspec(url: str) -> Any:
    if url.startswith("udp://"):
        raise OptionError(f"{url}: a sensor is not a capture; it is read by lumsdk.Sensor({url[6:]!r})")
    try:
        import fsspec  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        raise OptionError(f"{url}: a URL needs fsspec: {install('url')}") from None
    return fsspec


def _for_url(url: str, **storage: Any) -> str:
    """How storage_options are written for the file system of a URL, also behind others, as in zip://a::https://b."""
    text = ", ".join(f'"{name}": {value!r}' for name, value in storage.items())
    last = url.rsplit("::", 1)[-1]
    return f'storage_options={{"{last.partition("://")[0]}": {{{text}}}}}' if last != url else f"storage_options={{{text}}}"


@contextlib.contextmanager
def _of_url(url: str, done: str = "opened") -> Iterator[None]:
    """File systems of fsspec have errors of their own, which do not name the URL."""
    try:
        yield
    except Error:
        raise
    except FileNotFoundError as error:
        why = error.__cause__  # by HTTP, whatever the server answered
        is_missing = why is None or getattr(why, "status", None) == 404
        said = "there is no such file" if is_missing else f"{type(why).__name__}: {why}"
        raise CaptureError(f"{url}: cannot be {done}: {said}") from error
    except (ImportError, ValueError) as error:
        if done == "opened":
            raise OptionError(f"{url}: {error}") from error
        if "range" not in str(error):
            raise CaptureError(f"{url}: cannot be {done}: {error}") from error
        raise CaptureError(f"{url}: cannot be {done}: its server does not give parts of a file (HTTP ranges): read it from "
                           f"start to end by {_for_url(url, block_size=0)}, or download it") from error
    except Exception as error:
        raise CaptureError(f"{url}: cannot be {done}: {type(error).__name__}: {error}") from error


class _UrlFile:
    """A file object of fsspec, whose errors are ours."""

    def __init__(self, file: Any, url: str) -> None:
        self._file, self._url = file, url
        self.seekable, self.seek, self.tell, self.close = file.seekable, file.seek, file.tell, file.close

    def read(self, size: int = -1) -> Any:
        """As of any file."""
        with _of_url(self._url, "read"):
            return self._file.read(size)


def _open_url(url: str, storage: Mapping[str, Any]) -> Input:
    def opener() -> Any:
        with _of_url(url):
            return _UrlFile(_fsspec(url).open_files(url, "rb", **storage)[0].open(), url)

    with _of_url(url):
        files = _fsspec(url).open_files(url, "rb", **storage)
        if not files:
            raise CaptureError(f"{url}: no file has such a name")
        made: Input = Files(_fetch(url, storage)) if len(files) > 1 else Opened(opener, url)
    made.given, made.storage = url, storage or None
    return made


def _behind_cache(url: str, storage: Mapping[str, Any]) -> dict[str, Any]:
    """storage_options of a URL for the same behind a file system that keeps its files here: by the names of both."""
    names = [part.partition("://")[0] for part in url.split("::")]
    made = {name: value for name, value in storage.items() if name in names}
    own = {name: value for name, value in storage.items() if name not in names}
    return {**made, names[0]: {**made.get(names[0], {}), **own}}


def _fetch(url: str, storage: Mapping[str, Any]) -> list[str]:
    """Files of several URLs on this machine: they are read as one, by their times."""
    with _of_url(url):
        found = _fsspec(url).open_local(f"simplecache::{url}", mode="rb", **_behind_cache(url, storage))
        return [str(path) for path in found] if glob.has_magic(url) else [str(found)]


def _of_folder(folder: str) -> list[str]:
    """The captures in a folder of rosbag2. They are read by their times."""
    names = os.listdir(folder)
    found = [name for name in names if name.endswith(".mcap") and not name.startswith(".")]
    if not found:
        raise CaptureError(f"{folder}: its recording is SQLite (.db3), which is not read: ros2 bag convert makes MCAP of it"
                           if any(name.endswith(".db3") for name in names) else
                           f"{folder}: is a folder without an .mcap file; a folder of rosbag2 has one")
    return [os.path.join(folder, name) for name in sorted(found)]


def _paths(given: Any, storage: Mapping[str, Any]) -> list[Any]:
    """A path, or those that a pattern means."""
    if _is_url(given):
        return _fetch(given, storage)
    if not isinstance(given, (str, os.PathLike)):
        raise TypeError(f"a source in a list is {reprlib.repr(given)}, of type {type(given).__name__}; use a path, a "
                        "pattern or a URL: captures in memory and file objects are read alone")
    name = os.fsdecode(given)
    if os.path.isdir(name):
        return _of_folder(name)
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
        return Stream(open(0, "rb", closefd=False, buffering=0), "standard input", True)
    if len(paths) == 1 and os.path.exists(name) and not os.path.isdir(name) and not _is_regular(name):
        return Stream(open(name, "rb", buffering=0), name, True)
    return Files(paths)


def urls_of(given: Any) -> list[str]:
    """The URLs of what open() takes."""
    return [each for each in (given if isinstance(given, (list, tuple)) else [given]) if _is_url(each)]


def check_storage(storage: Any) -> dict[str, Any]:
    """The option storage_options."""
    if storage is not None and not isinstance(storage, Mapping):
        raise TypeError(f"storage_options is {storage!r}, of type {type(storage).__name__}; use a mapping for fsspec, such "
                        'as {"anon": True}')
    return dict(storage or {})


def _of_list(given: Sequence[Any], storage: Mapping[str, Any]) -> Input:
    parts = [_paths(each, storage) for each in given]
    made = _of_files([path for part in parts for path in part])
    if made.given is not None and urls_of(given):  # files that were fetched are there as long as this process
        made.storage = storage or None
        made.given = [name for each, part in zip(given, parts)
                      for name in ([each] if _is_url(each) else map(os.path.abspath, map(os.fsdecode, part)))]
    return made


def open_input(given: Any, storage: Optional[Mapping[str, Any]] = None) -> Input:
    """The input that a program names.

    Args:
        given: what open() takes.
        storage: what its URLs need for fsspec.
    """
    options = check_storage(storage)
    if options and not urls_of(given):
        raise OptionError(f"storage_options does not go with {reprlib.repr(given)}: it is for a URL")
    if _is_url(given):
        return _open_url(given, options)
    if isinstance(given, (str, os.PathLike)):
        return _of_files(_paths(given, options))
    if isinstance(given, (list, tuple)):
        return _of_list(given, options)
    try:
        return Memory(given)
    except (TypeError, BufferError, ValueError):
        pass
    if isinstance(given, io.TextIOBase):
        raise TypeError('the file object is opened as text; use mode "rb"')
    if callable(getattr(given, "read", None)):
        return Stream(given, str(getattr(given, "name", "the file object")))
    raise TypeError(f"a source is given as {type(given).__name__}; {RIGHT}")
