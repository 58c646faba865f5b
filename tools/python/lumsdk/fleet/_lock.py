"""Allows one run at a time in an OUT: two runs would take each other's files for leftovers."""
from __future__ import annotations

import json
import os
import socket
import threading
import time
from contextlib import suppress
from typing import IO, Any, Optional

from ._errors import FleetError, LockTaken
from ._places import Local, Place

LEASE = ".lumfleet/lease.json"
LEASE_S = 60.0
RENEW_S = 15.0


class FolderLock:
    """The system's lock of a file, which ends with its process."""

    def __init__(self, out: Local) -> None:
        path = out.where(".lumfleet/lock")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        self._file: Optional[IO[str]] = open(path, "a+", encoding="utf-8")
        try:
            import fcntl
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:
            return
        except OSError as error:
            self._file.close()
            if not isinstance(error, BlockingIOError):
                return  # a file system without locks
            raise FleetError(f"{out.url}: another lumfleet is writing to it; two at once would damage each other's files") from error

    def check(self, again: bool = False) -> None:
        """The system takes it from nobody."""

    def release(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None


class Lease:
    """An object that its holder renews; a store has no locks. A holder that died on this machine is
    known at once, another one after a minute. One that only slept for so long finds that it is another's."""

    def __init__(self, out: Place, run: str) -> None:
        self._out = out
        self._text = {"run": run, "host": socket.gethostname(), "pid": os.getpid()}
        held = self._read()
        if held and not _is_over(held):
            raise FleetError(f"{out.url}: another lumfleet is writing to it, process {held.get('pid')} of {held.get('host')};"
                             f" if that has ended, try again in {LEASE_S:.0f} s")
        self._write()
        if (self._read() or {}).get("run") != run:
            raise FleetError(f"{out.url}: another lumfleet began to write to it at the same time")
        self._taken = ""
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._renew, daemon=True)
        self._thread.start()

    def _read(self) -> Optional[dict[str, Any]]:
        try:
            held: dict[str, Any] = json.loads(self._out.read(LEASE))
        except (FileNotFoundError, ValueError):
            return None
        return held

    def _write(self) -> None:
        self._out.write(LEASE, json.dumps({**self._text, "time": time.time()}).encode())

    def _renew(self) -> None:
        while not self._taken and not self._end.wait(RENEW_S):
            try:
                self._look()
                if not self._taken:
                    self._write()
            except OSError:
                continue  # the next one in time will do

    def _look(self) -> None:
        held = self._read()
        if held is None:
            self._taken = "its .lumfleet/lease.json was removed, perhaps by another lumfleet that is done"
        elif held.get("run") != self._text["run"]:
            self._taken = f"another lumfleet took it over, process {held.get('pid')} of {held.get('host')}, because this one" \
                          f" did not renew its lease for {LEASE_S:.0f} s"

    def check(self, again: bool = False) -> None:
        """Raises LockTaken if another run has it; looks for that itself if `again`, else the renewals have looked."""
        if again and not self._taken:
            with suppress(OSError):
                self._look()
        if self._taken:
            raise LockTaken(f"{self._out.url}: {self._taken}; this run ends without a manifest; the same"
                            " command continues it later")

    def release(self) -> None:
        self._end.set()
        self._thread.join()
        with suppress(LockTaken):
            self.check(again=True)
            self._out.remove(LEASE)


def _is_over(held: dict[str, Any]) -> bool:
    if held.get("host") == socket.gethostname():
        if held.get("pid") == os.getpid():
            return True
        try:
            os.kill(int(held["pid"]), 0)
        except ProcessLookupError:
            return True
        except (OSError, KeyError, ValueError):
            pass
    return time.time() - float(held.get("time", 0)) > LEASE_S


def lock(out: Place, run: str) -> FolderLock | Lease:
    """Refuses an OUT to which another run writes."""
    return FolderLock(out) if isinstance(out, Local) else Lease(out, run)
