"""The conversion of a capture, in a worker that lives for many of them."""
from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Optional

from .._c import LOSSES, VERSION
from .._programs import left_out_of
from .._target import is_url
from ._folders import WorkFolder
from ._job import LUMDUMP_FORMATS, Job, find_lumdump
from ._ledger import Record, Task
from ._manifest import COUNTS
from ._names import printable, to_text
from ._places import BLOCK, Entry, Local, Remote, place

MARK = ".lumfleet/run"
PARTS = ".lumfleet/parts"
LONGEST_MESSAGE = 2000
# There is a worker for each core.
_ONE_THREAD = ("--threads", "1")


class _Failed(Exception):
    """The capture cannot be converted; another attempt would end in the same way."""


class Lost(Exception):
    """The attempt ended for a reason that is not the capture's."""


class Converter:
    """Converts captures one after another. Used in a process of its own, or as an actor of Ray."""

    def __init__(self, job: Job, has_group: bool = False) -> None:
        """has_group: whoever ends this process ends all of its group, and so lumdump."""
        self._job = job
        self._work = WorkFolder()
        self._out = place(job.out, job.endpoint)
        self._lumdump = find_lumdump(job.lumdump) if job.format in LUMDUMP_FORMATS else ""
        self._threads = ThreadPoolExecutor(1)
        self._die_with_us = None if has_group else _death_signal()
        for name, data in job.files.items():
            with open(os.path.join(self._work.path, name), "wb") as file:
                file.write(data)

    def ready(self) -> dict[str, Any]:
        """Says where it is, once it can begin."""
        try:
            mark = self._out.read(MARK).decode()
        except FileNotFoundError:
            mark = ""
        if mark != self._job.run:
            return {"error": f"{os.uname().nodename} does not see {self._job.out}: all machines of a cluster need it by this"
                             " name; name a shared folder or an object store"}
        return {"pid": os.getpid(), "version": VERSION}

    def close(self) -> None:
        """Removes what it has on this machine."""
        self._threads.shutdown()
        self._work.remove()

    def convert(self, task: Task, attempt: str) -> Record:
        """The row of the manifest. `lost` in it: the attempt has to be made again."""
        begin = time.monotonic()
        record: Record = {"output": to_text(task.output), "source": to_text(task.source), "size": task.size, "stamp": task.stamp,
                          "options": self._job.options, "version": self._job.version, "message": "", "status": "failed"}
        try:
            self._convert(task, f"{PARTS}/{attempt}", record)
        except _Failed as failure:
            record["message"] = str(failure)
        except Lost as lost:
            record["lost"] = str(lost)
        except OSError as error:
            record["message"] = _sentence(error, task)
            if not self._out.is_local or is_url(task.source):
                record["lost"] = record["message"]
        except Exception as error:  # whatever one capture does, the others go on
            record["message"] = _unexpected(error, task)
        for key in {"message", "lost"} & record.keys():
            record[key] = printable(record[key].replace(task.source, record["source"]))[:LONGEST_MESSAGE]
        record["seconds"] = round(time.monotonic() - begin, 3)
        return record

    def _convert(self, task: Task, part: str, record: Record) -> None:
        with self._at_hand(task, record) as path:
            if path is None:
                return
            made = self._room(part)
            try:
                make = self._by_lumdump if self._job.format in LUMDUMP_FORMATS else self._by_convert
                record.update(make(path, made, task))
                self._check_unchanged(task, record)
                record["output_size"] = os.path.getsize(made)
                self._out.name_as(made, self._out.name_of(task.output), f"{part}/made")
                record["status"] = "done"
            finally:
                shutil.rmtree(os.path.dirname(made), ignore_errors=True)

    # The capture

    @contextmanager
    def _at_hand(self, task: Task, record: Record) -> Iterator[Optional[str]]:
        """The capture as a file of this machine; None if its output is there and its bytes are the same.
        Fills in its state and, at the end, its digest."""
        entry, source = self._entry(task)
        record.update(size=entry.size, stamp=entry.stamp)
        if isinstance(source, Remote):
            folder = os.path.join(self._work.path, "capture")
            os.makedirs(folder, exist_ok=True)
            path = os.path.join(folder, entry.name)
            try:
                sha = hashlib.sha256()
                source.fetch(entry.name, path, entry.size, sha.update)
                record["digest"] = sha.hexdigest()
                yield None if self._is_same(task, record) else path
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            return
        path = source.where(entry.name)
        if task.digest:
            record["digest"] = _digest(path)
            yield None if self._is_same(task, record) else path
            return
        digest = self._threads.submit(_digest, path)
        try:
            yield path
        finally:
            record["digest"] = digest.result()

    def _is_same(self, task: Task, record: Record) -> bool:
        if task.digest and record["digest"] == task.digest:
            self._check_unchanged(task, record)
            record["unchanged"] = True
        return "unchanged" in record

    def _entry(self, task: Task) -> tuple[Entry, Local | Remote]:
        folder, _, name = task.source.rpartition("/" if is_url(task.source) else os.sep)
        source = place(folder or os.sep, self._job.endpoint)
        entry = source.entry(name)
        if entry is None:
            raise _Failed(f"{task.source}: cannot be read: it is no longer there, or not on {os.uname().nodename}")
        return entry, source

    def _check_unchanged(self, task: Task, record: Record) -> None:
        entry, _ = self._entry(task)
        if (entry.size, entry.stamp) != (record["size"], record["stamp"]):
            raise _Failed(f"{task.source}: it changed while it was read")

    # The output

    def _room(self, part: str) -> str:
        """Where to write: on OUT's own disk, so that it only has to be named, or on ours, to be sent."""
        folder = self._out.where(part) if self._out.is_local else os.path.join(self._work.path, "made")
        os.makedirs(folder, exist_ok=True)
        return os.path.join(folder, f"made.{self._job.format}")

    def _by_lumdump(self, path: str, made: str, task: Task) -> Record:
        command = [self._lumdump, path, "-o", made, "--format", self._job.format, "--json", *_ONE_THREAD, *self._job.arguments]
        try:
            ended = subprocess.run(command, capture_output=True, text=True, errors="surrogateescape", cwd=self._work.path, check=False,
                                   stdin=subprocess.DEVNULL, preexec_fn=self._die_with_us)
        except OSError as error:
            raise Lost(f"{self._lumdump} on {os.uname().nodename} cannot be started: {error.strerror or error}") from error
        lines = [line.split("lumdump: ", 1)[-1] for line in ended.stderr.splitlines() if line.strip()]
        said = self._named("; ".join(lines), path, made, task)
        if ended.returncode < 0:
            raise Lost(f"lumdump was ended by {signal.Signals(-ended.returncode).name}")
        if ended.returncode:
            raise _Failed(said or f"lumdump ended with status {ended.returncode}")
        summary = json.loads(ended.stdout)
        return {"message": said, "truncated": summary["truncated"], "left_out": left_out_of(summary),
                **{name: summary.get(name) for name in COUNTS}, "frames": summary["frames_selected"]}

    def _by_convert(self, path: str, made: str, task: Task) -> Record:
        import lumsdk

        keywords: dict[str, Any] = self._job.keywords
        try:
            with in_folder(self._work.path), warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                summary = lumsdk.convert(path, made, threads=1, **keywords)
        except lumsdk.Error as error:
            raise _Failed(self._named(str(error), path, made, task)) from error
        words = dict.fromkeys(f"warning: {warning.message}" for warning in said)
        return {**counted(summary), "message": self._named("; ".join(words), path, made, task)}

    def _named(self, words: str, path: str, made: str, task: Task) -> str:
        """Words with the names that the user knows. The library's have U+FFFD for what is no text in a name."""
        for ours, known in ((path, task.source), (made, self._out.where(task.output))):
            for written in (ours, os.fsencode(ours).decode(errors="replace")):
                words = words.replace(written, known)
        return words


@contextmanager
def in_folder(path: str) -> Iterator[None]:
    """Calibration and profile are named as they are on every machine."""
    before = os.getcwd()
    os.chdir(path)
    try:
        yield
    finally:
        os.chdir(before)


def counted(summary: Any) -> Record:
    """lumsdk.convert()'s summary as columns of the manifest; it does not tell all of them."""
    return {"truncated": bool(summary["truncated"]), "left_out": summary["left_out"], **{name: summary.get(name) for name in COUNTS},
            **{name: summary["losses"].get(name, 0) for name in LOSSES}}


def _digest(path: str) -> str:
    sha = hashlib.sha256()
    room = memoryview(bytearray(BLOCK))
    with open(path, "rb", buffering=0) as file:
        while count := file.readinto(room):
            sha.update(room[:count])
    return sha.hexdigest()


def _sentence(error: OSError, task: Task) -> str:
    """What the system said, with a name that the user knows."""
    why = error.strerror or str(error)
    return f"{task.source}: {why}" if error.filename in (None, task.source) else f"{task.output}: {why}"


def _unexpected(error: Exception, task: Task) -> str:
    """A sentence for what is none of the errors that a conversion is known to raise."""
    if isinstance(error, MemoryError):
        return f"{task.source}: the conversion needs more memory than there is; fewer --jobs leave more for each"
    words = " ".join(str(error).split())
    return f"{task.source}: the conversion ended with {type(error).__name__}{': ' + words if words else ''}"


def _death_signal() -> Any:
    """Makes lumdump end when its worker is killed, where the system can do that. A fork that calls this copies the tables of
    all of the worker's memory, which takes some milliseconds."""
    if not sys.platform.startswith("linux"):
        return None
    import ctypes

    prctl = ctypes.CDLL(None, use_errno=True).prctl
    return lambda: prctl(1, signal.SIGKILL)
