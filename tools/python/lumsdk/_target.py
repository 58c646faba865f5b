"""Where a file that is made goes: beside its final name until it is whole, or to a URL.

Names and marks are those of lumdump (docs/formats.md), so that its runs and these see each other.
"""
from __future__ import annotations

import contextlib
import importlib
import io
import os
import secrets
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, BinaryIO, Optional

from ._errors import Error, OptionError, install

# Without locks, on Windows, two runs cannot see each other.
fcntl: Any = importlib.import_module("fcntl") if os.name == "posix" else None

_STEM = 200
_MAGIC = "lumsdk\n"
_TRIES = 100


class TargetError(Error, OSError):
    """A file cannot be written."""


def is_url(name: str) -> bool:
    """Whether a name is a URL and not a path."""
    return "://" in name


def check_not_read(name: str, paths: Iterable[Any], what: str) -> None:
    """OptionError: an output of this name would replace one of these files, which are read."""
    for path in paths:
        if not isinstance(path, (str, os.PathLike)) or "\n" in os.fsdecode(path):
            continue
        if not is_url(name) and os.path.exists(name) and os.path.exists(path) and os.path.samefile(name, path):
            raise OptionError(f"{name} is {what}, which this run reads: name another output")


def _reason(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "the directory does not exist; create it or write elsewhere"
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return f"{type(error).__name__}: {error}"  # file systems of fsspec and writers have errors of their own


def failed(name: str, error: Exception) -> TargetError:
    """What is raised where a file cannot be written to its end."""
    return TargetError(f"{name}: cannot write it: {_reason(error)}")


# --- The right to a name ---


def _stem(base: str) -> str:
    raw = os.fsencode(base)
    if len(raw) <= _STEM:
        return base
    value = 0xCBF29CE484222325
    for byte in raw:
        value = (value ^ byte) * 0x100000001B3 % (1 << 64)
    return os.fsdecode(raw[:_STEM - 17]) + f"~{value:016x}"


def _line(text: str, key: str) -> Optional[str]:
    found = [line[len(key):] for line in text.splitlines()[1:] if line.startswith(key)]
    return found[0] if found else None


def _is_locked(path: str) -> bool:
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False


class _Claim:
    """The right to write the file of a name: a locked mark beside it."""

    def __init__(self, path: str, shown: str) -> None:
        folder, base = os.path.split(path)
        self._folder, self._stem, self._shown = folder, _stem(base), shown
        self.mark = os.path.join(folder, f".{self._stem}.lumsdk")
        self._fd = -1
        if fcntl is None:
            return
        for _ in range(_TRIES):
            if self._attempt():
                return
        raise TargetError(f"{shown}: another run is writing it: wait for its end, or choose another name")

    def _attempt(self) -> bool:
        try:
            fd = os.open(self.mark, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise TargetError(f"{self._shown}: cannot create it: {_reason(error)}") from error
        kept = False
        try:
            kept = self._take(fd)
        finally:
            if not kept:
                os.close(fd)
        return kept

    def _take(self, fd: int) -> bool:
        text = os.pread(fd, 512, 0).decode(errors="replace")
        if text and not text.startswith(_MAGIC):
            raise TargetError(f"{self._shown}: cannot be written while {self.mark} is there, which would mark that it is "
                              "being written: rename that one, or choose another name")
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._refuse(text)
        except OSError:
            return self._keep(fd)  # a file system without locks
        try:
            if not os.path.samestat(os.fstat(fd), os.lstat(self.mark)):
                return False
        except FileNotFoundError:
            return False
        self._remove_unfinished(os.pread(fd, 512, 0).decode(errors="replace"))
        return self._keep(fd)

    def _refuse(self, text: str) -> None:
        process = _line(text, "process ") or ""
        if process == str(os.getpid()):
            raise TargetError(f"{self._shown}: this run is writing it already: choose another name")
        by = f" (process {process})" if process.isdigit() else ""
        raise TargetError(f"{self._shown}: another run is writing it{by}: wait for its end, or choose another name")

    def _remove_unfinished(self, text: str) -> None:
        name = _line(text, "unfinished ") or ""
        number = name[len(self._stem) + 1:-len(".part")]
        is_ours = name == f"{self._stem}.{number}.part" and len(number) == 12 and set(number) <= set("0123456789abcdef")
        path = os.path.join(self._folder, name)
        with contextlib.suppress(OSError):
            if is_ours and stat.S_ISREG(os.lstat(path).st_mode) and not _is_locked(path):
                os.unlink(path)

    def _keep(self, fd: int) -> bool:
        self._fd = fd
        self._write(f"{_MAGIC}process {os.getpid()}\n")
        return True

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError):
            os.ftruncate(self._fd, 0)
            os.pwrite(self._fd, os.fsencode(text), 0)

    def beside(self) -> str:
        """A new name for the unfinished file, noted in the mark."""
        base = f"{self._stem}.{secrets.token_hex(6)}.part"
        if self._fd >= 0:
            self._write(f"{_MAGIC}process {os.getpid()}\nunfinished {base}\n")
        return os.path.join(self._folder, base)

    def drop(self) -> None:
        """Give it back."""
        if self._fd >= 0:
            with contextlib.suppress(OSError):
                os.unlink(self.mark)
            os.close(self._fd)
        self._fd = -1


# --- Files ---

_AHEAD = 16 << 20
"""Bytes that wait until the disk begins with them."""


class _Early(io.FileIO):
    """A file that goes to the disk while more of it is made, so that little is left for fsync() at its end."""

    _begun = 0

    def write(self, data: Any) -> Optional[int]:  # type: ignore[override,unused-ignore]
        """As of any file."""
        count = super().write(data)
        ahead = self.tell() - self._begun
        if ahead >= _AHEAD:
            with contextlib.suppress(OSError):  # the advice begins to write them; they stay in memory while they are under way
                os.posix_fadvise(self.fileno(), self._begun, ahead, os.POSIX_FADV_DONTNEED)
            self._begun += ahead
        return count


class Target:
    """A file being made. It has its name once it is whole and on the disk."""

    file: BinaryIO

    def __init__(self, name: str) -> None:
        """Begin; the file of this name stays as it is until finish()."""
        self.name = name
        self._path = os.path.realpath(name)
        self._mode = self._look()
        self._claim = _Claim(self._path, name)
        self._part = ""
        try:
            self._open()
        except OSError as error:
            self._claim.drop()
            raise TargetError(f"{name}: cannot create it: {_reason(error)}") from error

    def _look(self) -> Optional[int]:
        try:
            mode = os.stat(self._path).st_mode
        except OSError:
            if os.path.islink(self.name):
                raise TargetError(f"{self.name} is a link to a missing file: name a file") from None
            return None
        if not stat.S_ISREG(mode):
            raise TargetError(f"{self.name} is not a regular file, which this format needs: name a file")
        return stat.S_IMODE(mode)

    def _open(self) -> None:
        self._part = self._claim.beside()
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
        raw = (_Early if hasattr(os, "posix_fadvise") else io.FileIO)(os.open(self._part, flags, 0o666), "r+b")
        self.file = io.BufferedRandom(raw, 1 << 20)
        self._made = os.fstat(self.file.fileno())
        if fcntl is not None:
            with contextlib.suppress(OSError):
                fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _is_there(self) -> bool:
        """Whether others have not removed, renamed or replaced it."""
        with contextlib.suppress(OSError):
            return os.path.samestat(os.lstat(self._part), self._made)
        return False

    @property
    def folder(self) -> str:
        """Where it is made, for what else needs room."""
        return os.path.dirname(self._path) or "."

    def fill(self, content: bytes) -> None:
        """Write it, and wait until it is on the disk. It has its name after finish()."""
        try:
            self.file.write(content)
            self.file.flush()
            os.fsync(self.file.fileno())
        except OSError as error:
            self.discard()
            raise failed(self.name, error) from error

    def finish(self, last_look: Callable[[], None] = lambda: None) -> int:
        """Wait until it is on the disk, and give it its name. Returns its size in bytes.

        Args:
            last_look: called before it gets its name, which it does not get if that raises.
        """
        try:
            return self._finish(last_look)
        except OSError as error:
            self.discard()
            raise failed(self.name, error) from error

    def _finish(self, last_look: Callable[[], None]) -> int:
        self.file.flush()
        os.fsync(self.file.fileno())
        size = os.fstat(self.file.fileno()).st_size
        self.file.close()
        last_look()
        if not self._is_there():
            raise OSError(f"{self._part}, where it is written, was removed or renamed while it was written: convert again")
        if self._mode is not None:
            os.chmod(self._part, self._mode)
        os.replace(self._part, self._path)
        self._part = ""
        self._claim.drop()
        if fcntl is not None:
            folder = os.open(self.folder, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)
        return size

    def discard(self) -> None:
        """Remove what was written. Nothing happens after finish()."""
        with contextlib.suppress(OSError, ValueError):
            self.file.close()
        if self._part and self._is_there():
            with contextlib.suppress(OSError):
                os.unlink(self._part)
        self._part = ""
        self._claim.drop()


# --- URLs ---


def _file_system(url: str, options: Mapping[str, Any]) -> tuple[Any, str]:
    try:
        fsspec: Any = importlib.import_module("fsspec")
    except ImportError as error:
        raise Error(f"{url}: fsspec is missing: {install('url')}") from error
    try:
        fs, path = fsspec.core.url_to_fs(url, **options)
    except (ImportError, ValueError) as error:
        raise OptionError(f"{url}: {error}") from error
    return fs, path


def upload(local: str, url: str, options: Mapping[str, Any]) -> None:
    """A whole file to a URL: under a temporary key, which gets the name when all bytes are there."""
    fs, path = _file_system(url, options)
    part = f"{path}.{secrets.token_hex(6)}.part"
    try:
        fs.put_file(local, part)
        fs.mv(part, path)
    except BaseException as error:
        with contextlib.suppress(Exception):
            fs.rm_file(part)
        if isinstance(error, Exception):
            raise failed(url, error) from error
        raise


class UrlTarget:
    """As Target, for a URL: a file of the temporary folder, sent when it is whole."""

    def __init__(self, url: str, options: Mapping[str, Any]) -> None:
        """Begin; nothing is sent until finish()."""
        self.name = url
        self._options = options
        _file_system(url, options)
        self._kept = tempfile.TemporaryDirectory(prefix="lumsdk-")
        self.folder = self._kept.name
        self._local = os.path.join(self.folder, "whole")
        self.file: BinaryIO = open(self._local, "w+b", buffering=1 << 20)

    def finish(self, last_look: Callable[[], None] = lambda: None) -> int:
        """Send it; as Target.finish()."""
        self.file.close()
        try:
            last_look()
            size = os.path.getsize(self._local)
            upload(self._local, self.name, self._options)
        finally:
            self.discard()
        return size

    def discard(self) -> None:
        """Remove what was written. Nothing happens after finish()."""
        with contextlib.suppress(OSError, ValueError):
            self.file.close()
        self._kept.cleanup()


@contextlib.contextmanager
def local_for(name: str, options: Mapping[str, Any]) -> Iterator[str]:
    """A path for a program that writes files itself: the name, or for a URL a file that is sent at the end."""
    if not is_url(name):
        yield name
        return
    _file_system(name, options)
    with tempfile.TemporaryDirectory(prefix="lumsdk-") as folder:
        local = os.path.join(folder, name.rstrip("/").rsplit("/", 1)[-1])
        yield local
        for made in sorted(os.listdir(folder)):
            upload(os.path.join(folder, made), name.rsplit("/", 1)[0] + "/" + made, options)
