"""Work folders of a process. If the process dies, a later one removes them."""
from __future__ import annotations

import glob
import os
import shutil
import tempfile
from typing import IO

from .._target import fcntl

PREFIX = "lumfleet-"


class WorkFolder:
    """A folder in TMPDIR that is locked while its process lives."""

    def __init__(self) -> None:
        remove_dead()
        self.path = tempfile.mkdtemp(prefix=PREFIX)
        # Others find it by its lock, which is held before it has its name; without locks they do not look for it.
        path = os.path.join(self.path, "lock")
        self._lock: IO[bytes] = open(f"{path}.new", "wb")
        if _lock(self._lock):
            os.rename(f"{path}.new", path)

    def remove(self) -> None:
        self._lock.close()
        shutil.rmtree(self.path, ignore_errors=True)


def _lock(file: IO[bytes]) -> bool:
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def remove_dead() -> None:
    """Removes those whose process was killed."""
    for path in glob.glob(os.path.join(glob.escape(tempfile.gettempdir()), PREFIX + "*", "lock")):
        try:
            with open(path, "rb") as file:
                if _lock(file):
                    shutil.rmtree(os.path.dirname(path), ignore_errors=True)
        except OSError:
            continue
