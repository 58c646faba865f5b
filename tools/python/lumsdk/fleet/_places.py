"""Folders on this machine and in object stores, by one interface.

A place is a folder; names in it are relative and have / on every system. A file has its name
only when it is whole: it is written under another name first.
"""
from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import Any, Callable, NamedTuple, Optional, Union

from .._target import is_url
from .._errors import install
from ._errors import FleetError, Usage
from ._names import to_text

BLOCK = 1 << 18  # stays in a processor's cache while it is hashed


class Entry(NamedTuple):
    """A file: its name in its place, its bytes, and what changes when it is written again."""

    name: str
    size: int
    stamp: str


class Local:
    """A folder of this machine, or one that all machines of a cluster mount."""

    is_local = True

    def __init__(self, url: str) -> None:
        self.url = os.path.abspath(url)

    def where(self, name: str) -> str:
        return os.path.join(self.url, *name.split("/")) if name else self.url

    def below(self, name: str) -> Local:
        return Local(self.where(name))

    def kind(self, name: str = "") -> str:
        """file, folder, or nothing."""
        path = self.where(name)
        return "folder" if os.path.isdir(path) else "file" if os.path.exists(path) else ""

    def entry(self, name: str) -> Optional[Entry]:
        try:
            info = os.stat(self.where(name))
        except FileNotFoundError:
            return None
        return Entry(name, info.st_size, f"mtime:{info.st_mtime_ns}")

    def walk(self, apart: str = "") -> Iterator[Entry]:
        """All files below, in no order; not below the folder `apart`, nor through links to folders."""
        folders = [""]
        while folders:
            folder = folders.pop()
            path = self.where(folder.rstrip("/"))
            if path == apart:
                continue
            try:
                children = os.scandir(path)
            except FileNotFoundError:
                continue
            except OSError as error:
                raise FleetError(f"{path}: cannot be listed: {error.strerror}") from error
            with children:
                for child in children:
                    name = folder + child.name
                    if child.is_dir(follow_symlinks=False):
                        folders.append(name + "/")
                    elif child.is_file():
                        info = child.stat()
                        yield Entry(name, info.st_size, f"mtime:{info.st_mtime_ns}")

    @staticmethod
    def name_of(output: str) -> str:
        """The name here of an output: the bytes of its capture's name."""
        return output

    def outputs(self, apart: str) -> Iterator[Entry]:
        """What walk() finds, by names as the manifest has them."""
        return (entry._replace(name=to_text(entry.name)) for entry in self.walk(apart))

    def read(self, name: str) -> bytes:
        with open(self.where(name), "rb") as file:
            return file.read()

    def write(self, name: str, data: bytes) -> None:
        path = self.where(name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        beside = path + ".part"
        try:
            with open(beside, "wb") as file:
                file.write(data)
            os.replace(beside, path)
        except OSError:
            self._forget(beside)
            raise

    def name_as(self, path: str, name: str, attempt: str) -> None:
        """Give a whole file of this place, or of another file system, its name."""
        final = self.where(name)
        os.makedirs(os.path.dirname(final), exist_ok=True)
        try:
            os.replace(path, final)
        except OSError as error:
            if error.errno != errno.EXDEV:
                raise
            beside = self.where(attempt)
            os.makedirs(os.path.dirname(beside), exist_ok=True)
            shutil.copyfile(path, beside)
            os.replace(beside, final)

    def remove(self, name: str) -> None:
        self._forget(self.where(name))

    def remove_folder(self, name: str) -> None:
        shutil.rmtree(self.where(name), ignore_errors=True)

    @staticmethod
    def _forget(path: str) -> None:
        try:
            os.unlink(path)
        except OSError:
            pass


class _Files:
    """A file system of fsspec. Some raise errors of their own for what the network did: here all are OSError."""

    def __init__(self, files: Any) -> None:
        self._files = files

    def __getattr__(self, name: str) -> Any:
        def call(*arguments: Any, **options: Any) -> Any:
            with _as_oserror():
                return getattr(self._files, name)(*arguments, **options)
        return call


@contextmanager
def _as_oserror() -> Iterator[None]:
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise OSError(f"{type(error).__name__}: {error}") from error


class Remote:
    """A folder of an object store, or of anything else that fsspec knows."""

    is_local = False

    def __init__(self, url: str, endpoint: Optional[str]) -> None:
        try:
            import fsspec
        except ImportError as error:
            raise Usage(f"{url}: object stores need fsspec: {install('fleet')}") from error
        protocol = url.split("://", 1)[0]
        options: dict[str, Any] = {"use_listings_cache": False}
        if protocol in ("s3", "s3a"):
            options["default_block_size"] = 16 << 20
            if endpoint:
                options["endpoint_url"] = endpoint
        try:
            self._files = _Files(fsspec.filesystem(protocol, **options))
        except ImportError as error:
            raise Usage(f"{url}: {error}") from error
        except ValueError as error:
            raise Usage(f"{url}: '{protocol}' is not a protocol that fsspec knows, such as s3") from error
        self.url = url.rstrip("/")
        self._top: str = self._files._strip_protocol(self.url).rstrip("/")

    def where(self, name: str) -> str:
        return f"{self.url}/{name}" if name else self.url

    def _key(self, name: str) -> str:
        return f"{self._top}/{name}" if name else self._top

    def kind(self, name: str = "") -> str:
        key = self._key(name)
        if self._files.isfile(key):
            return "file"
        return "folder" if self._files.isdir(key) else ""

    def entry(self, name: str) -> Optional[Entry]:
        try:
            info = self._files.info(self._key(name))
        except FileNotFoundError:
            return None
        return Entry(name, int(info["size"]), stamp_of(info))

    def walk(self, apart: str = "") -> Iterator[Entry]:
        """All files below, folder by folder; not below the folder `apart`."""
        # The bucket of an object store exists without any key of ours.
        folders = [self._top]
        while folders:
            folder = folders.pop()
            if f"{self.url}{folder[len(self._top):]}" == apart:
                continue
            try:
                found = self._files.ls(folder, detail=True)
            except FileNotFoundError:
                continue
            for info in found:
                path = info["name"].rstrip("/")
                if info["type"] == "directory":
                    if path != folder:
                        folders.append(path)
                elif path != folder:
                    yield Entry(path[len(self._top) + 1:], int(info["size"]), stamp_of(info))

    @staticmethod
    def name_of(output: str) -> str:
        """The name here of an output: a store takes only text."""
        return to_text(output)

    def outputs(self, apart: str) -> Iterator[Entry]:
        """What walk() finds, by names as the manifest has them."""
        return self.walk(apart)

    def read(self, name: str) -> bytes:
        data: bytes = self._files.cat_file(self._key(name))
        return data

    def write(self, name: str, data: bytes) -> None:
        self._files.pipe_file(self._key(name), data)

    def fetch(self, name: str, path: str, size: int, take: Callable[[bytes], object]) -> None:
        """Copy to a file of this machine; every block is given to take(). A part of its bytes is an error: a capture that
        ends at a record would look whole."""
        count = 0
        with _as_oserror(), self._files.open(self._key(name), "rb", block_size=16 << 20, cache_type="readahead") as source, \
                open(path, "wb") as target:
            while True:
                block = source.read(16 * BLOCK)
                if not block:
                    break
                count += len(block)
                take(block)
                target.write(block)
        if count != size:
            raise OSError(f"the store gave {count} of its {size} bytes")

    def name_as(self, path: str, name: str, attempt: str) -> None:
        """Send a whole file of this machine under the attempt's key, then name it: many stores would
        show a part of it under its name."""
        size = os.path.getsize(path)
        self._files.put_file(path, self._key(attempt))
        there = int(self._files.info(self._key(attempt))["size"])
        if there != size:
            raise OSError(f"{self.where(name)}: the store has {there} of its {size} bytes")
        self._files.cp_file(self._key(attempt), self._key(name))
        self.remove(attempt)

    def remove(self, name: str) -> None:
        try:
            self._files.rm_file(self._key(name))
        except OSError:
            pass

    def remove_folder(self, name: str) -> None:
        for entry in list(self.below(name).walk()):
            self.remove(f"{name}/{entry.name}")

    def below(self, name: str) -> Remote:
        below = object.__new__(Remote)
        below._files, below.url, below._top = self._files, self.where(name), self._key(name)
        return below


Place = Union[Local, Remote]


def stamp_of(info: dict[str, Any]) -> str:
    """What a store says of a file's state. Lists have fractions of seconds that a single file lacks."""
    for key in ("ETag", "etag", "md5", "checksum", "mtime", "LastModified", "last_modified", "updated", "created"):
        value = info.get(key)
        if value:
            whole = int(value.timestamp()) if isinstance(value, datetime) else str(value).strip('"')
            return f"{key.lower()}:{whole}"
    return ""


def place(url: str, endpoint: Optional[str] = None) -> Place:
    """The folder of this name."""
    if url.startswith("file://"):
        url = url[len("file://"):]
    if is_url(url):
        return Remote(url, endpoint)
    return Local(url)
