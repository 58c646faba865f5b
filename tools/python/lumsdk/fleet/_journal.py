"""What is finished, written as it happens, so that a run that is killed loses nothing."""
from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from typing import Any, Optional, TextIO

from ._places import Place

FOLDER = ".lumfleet/journal"
SEGMENT_S = 2.0
SEGMENT_ROWS = 1000


class Journal:
    """Lines of JSON below OUT: a line as soon as a capture is finished in a folder; a few seconds'
    lines at once in an object store, where nothing can be appended."""

    def __init__(self, out: Place, run: str) -> None:
        self._out = out
        self._run = run
        self._file: Optional[TextIO] = None
        self._waiting: list[str] = []
        self._segment = 0
        self._written = time.monotonic()
        self.failed = ""

    def add(self, record: dict[str, Any]) -> None:
        self._waiting.append(json.dumps(record) + "\n")
        self.tick()

    def tick(self, now: bool = False) -> None:
        """Writes what waits, if it is time. A full disk is noted: the run goes on without a journal."""
        due = self._out.is_local or now or len(self._waiting) >= SEGMENT_ROWS or \
            time.monotonic() - self._written >= SEGMENT_S
        if not self._waiting or not due or self.failed:
            return
        try:
            self._write("".join(self._waiting))
        except OSError as error:
            self.failed = str(error)
        self._waiting.clear()
        self._written = time.monotonic()

    def _write(self, lines: str) -> None:
        if not self._out.is_local:
            self._segment += 1
            self._out.write(f"{FOLDER}/{self._run}-{self._segment:06}.jsonl", lines.encode())
            return
        if self._file is None:
            path = self._out.where(f"{FOLDER}/{self._run}.jsonl")
            os.makedirs(os.path.dirname(path), exist_ok=True)
            self._file = open(path, "a", encoding="utf-8", buffering=1 << 16)
        self._file.write(lines)
        self._file.flush()

    def close(self) -> None:
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                self.failed = self.failed or str(error)
        self._file = None


def earlier(out: Place) -> Iterator[dict[str, Any]]:
    """The rows of runs that did not come to write their manifest, oldest first. A line that was cut
    is the last of its file, and of a capture that will be converted again."""
    below = out.below(FOLDER)
    for name in sorted(entry.name for entry in below.walk()):
        for line in below.read(name).decode(errors="replace").splitlines():
            try:
                yield json.loads(line)
            except ValueError:
                break
