"""What is to be made, what was made, and what is there: in a database on disk, so that a million
captures need no more memory than ten."""
from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple, Optional

from ._errors import Usage
from ._captures import Capture
from ._names import to_name, to_text
from ._places import Entry

Record = dict[str, Any]

TABLES = """
    PRAGMA journal_mode = OFF;
    PRAGMA synchronous = OFF;
    CREATE TABLE plan (output TEXT PRIMARY KEY, source TEXT, size INTEGER, stamp TEXT, digest TEXT, pending INTEGER) WITHOUT ROWID;
    CREATE TABLE rows (output TEXT PRIMARY KEY, status TEXT, record TEXT) WITHOUT ROWID;
    CREATE TABLE present (output TEXT PRIMARY KEY, size INTEGER) WITHOUT ROWID;
"""


class Task(NamedTuple):
    """A capture to be converted. A digest is given if an output of these bytes is there."""

    source: str
    size: int
    stamp: str
    output: str
    digest: str


class Totals(NamedTuple):
    """Captures and their bytes: all of the plan, and those to be converted."""

    captures: int
    size: int
    pending: int
    pending_size: int


class Ledger:
    """The plan of a run and the rows of its manifest, both by the outputs' names as to_text() writes them."""

    def __init__(self, folder: str) -> None:
        self._path = os.path.join(folder, "ledger.sqlite")
        self._base = sqlite3.connect(self._path, isolation_level=None)
        self._base.executescript(TABLES)
        self._base.execute("BEGIN")

    def close(self) -> None:
        self._base.close()

    # The plan

    def plan(self, found: Iterable[Capture], ending: str) -> None:
        """Refuses two captures with one output, before anything was made."""
        for capture in found:
            output, source = to_text(f"{capture.stem}.{ending}"), to_text(capture.source)
            try:
                self._base.execute("INSERT INTO plan VALUES (?, ?, ?, ?, '', 1)",
                                   (output, source, capture.size, capture.stamp))
            except sqlite3.IntegrityError:
                self._refuse_second(output, source)

    def _refuse_second(self, output: str, source: str) -> None:
        first = self._base.execute("SELECT source FROM plan WHERE output = ?", (output,)).fetchone()[0]
        if first == source:
            return
        raise Usage(f"{first} and {source} would both be {output}: name a folder that has both, or put a pattern in"
                         " quotes, so that the outputs keep the folders' names")

    def see(self, entries: Iterable[Entry]) -> None:
        """The outputs that are there, by their names in the manifest."""
        self._base.executemany("INSERT OR REPLACE INTO present VALUES (?, ?)", ((e.name, e.size) for e in entries))

    def compare(self, options: str, again: bool) -> None:
        """Marks in the plan what is missing or has changed since its row was written."""
        if again:
            return
        query = """SELECT p.output, p.source, p.size, p.stamp, r.record, e.size FROM plan p JOIN rows r USING (output)
                   LEFT JOIN present e USING (output)"""
        for output, source, size, stamp, text, there in self._base.cursor().execute(query):
            record: Record = json.loads(text)
            self._mark(output, *_state(record, source, size, stamp, options, there))

    def _mark(self, output: str, pending: bool, digest: str) -> None:
        self._base.execute("UPDATE plan SET pending = ?, digest = ? WHERE output = ?", (int(pending), digest, output))

    def totals(self) -> Totals:
        row = self._base.execute("SELECT COUNT(*), IFNULL(SUM(size), 0), IFNULL(SUM(pending), 0), IFNULL(SUM(size * pending), 0)"
                                 " FROM plan").fetchone()
        return Totals(*row)

    def tasks(self) -> Iterator[Task]:
        """What is to be made, the largest first: then no large one is left alone at the end."""
        for row in self._base.cursor().execute("SELECT source, size, stamp, output, digest FROM plan WHERE pending = 1"
                                           " ORDER BY size DESC, output"):
            source, size, stamp, output, digest = row
            yield Task(to_name(source), size, stamp, to_name(output), digest)

    # The rows of the manifest

    def put(self, record: Record) -> None:
        self._base.execute("INSERT OR REPLACE INTO rows VALUES (?, ?, ?)",
                           (record["output"], record["status"], json.dumps(record)))

    def rows(self) -> Iterator[Record]:
        for (text,) in self._base.cursor().execute("SELECT record FROM rows ORDER BY output"):
            yield json.loads(text)

    def row(self, output: str) -> Optional[Record]:
        found = self._base.execute("SELECT record FROM rows WHERE output = ?", (output,)).fetchone()
        return json.loads(found[0]) if found else None

    def planned_rows(self) -> Iterator[Record]:
        """Those of this run's plan, in the manifest's order."""
        for (text,) in self._base.cursor().execute("SELECT r.record FROM plan JOIN rows r USING (output) ORDER BY output"):
            yield json.loads(text)


def _state(record: Record, source: str, size: int, stamp: str, options: str, there: Optional[int]) -> tuple[bool, str]:
    """Whether to convert, and the digest of the bytes of which the output was made, if only the
    stamp says that they may be others."""
    if record["source"] != source and there is not None:
        raise Usage(f"{record['output']} was made of {record['source']}, which {source} would replace: name another"
                         " --out, or use --again to convert all again")
    if record["status"] != "done" or record["options"] != options or there != record["output_size"]:
        return True, ""
    if record["size"] != size:
        return True, ""
    if record["stamp"] != stamp or not stamp:
        return True, record["digest"]
    return False, ""
