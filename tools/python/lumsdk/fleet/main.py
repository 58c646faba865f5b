"""The program lumfleet."""
from __future__ import annotations

import argparse
import os
import secrets
import sys
import time
from contextlib import suppress
from typing import Any, Optional

from .._c import VERSION
from .._run import Signals, run
from . import _arguments, _journal, _manifest
from ._errors import FleetError, LockTaken, Usage
from ._folders import WorkFolder, remove_dead
from ._captures import captures
from ._job import Job
from ._journal import Journal
from ._ledger import Ledger, Record
from ._local import Processes
from ._names import printable, to_text
from ._lock import lock
from ._places import Local, Place, place
from ._schedule import Pool, Schedule
from ._summary import Progress, Summary, plan_json, plan_text
from ._work import MARK, PARTS

RESERVE = ".lumfleet/reserve"
RESERVE_OF_ROW = 512
RESERVE_LEAST = 32 << 10


class Run:
    """A run: plan, convert, manifest."""

    def __init__(self, options: argparse.Namespace, job: Job, signals: Signals) -> None:
        self._options, self._job, self._signals = options, job, signals
        self._out: Place = place(options.out, options.endpoint)
        self._work = WorkFolder()
        self._ledger = Ledger(self._work.path)

    # Plan

    def plan(self) -> None:
        """Refuses what cannot be done as a whole, before anything is written."""
        o = self._options
        if self._out.kind() == "file":
            raise Usage(f"--out: {o.out}: is a file; a folder is needed")
        self._ledger.plan(captures(o.inputs, o.endpoint, self._out.url), o.format)
        is_there = False
        for record in self._known():
            self._ledger.put(record)
            is_there = True
        if is_there:
            self._ledger.see(self._out.outputs(apart=self._out.where(".lumfleet")))
            self._ledger.compare(self._job.options, o.again)
        self.totals = self._ledger.totals()

    def _known(self) -> Any:
        yield from _manifest.read(self._out)
        yield from _journal.earlier(self._out)

    def dry(self) -> int:
        """Tell what a run would do; its exit status."""
        if self._options.json:
            print(plan_json(self.totals, printable(self._out.url), self._job.format))
            return 0
        if not self._options.quiet:
            for task in self._ledger.tasks():
                print(printable(f"{to_text(task.source)} -> {self._out.where(to_text(task.output))}"))
        print(plan_text(self.totals, printable(self._out.url), self._job.format))
        return 0

    # Convert

    def convert(self) -> int:
        """Status 0 or 1; -N for the signal N."""
        self._signals.waits = True  # from now on the lock is given back and the manifest is written
        self._held = lock(self._out, self._job.run)
        try:
            self._out.remove_folder(PARTS)
            self._out.write(MARK, self._job.run.encode())
            self._reserve()
            return self._convert_locked()
        finally:
            self._tidy()
            self._held.release()

    def _tidy(self) -> None:
        """Removes what is only of this run; what is there is another's if that took OUT."""
        with suppress(LockTaken):
            self._held.check(again=True)
            self._out.remove(MARK)
            self._out.remove_folder(PARTS)

    def _convert_locked(self) -> int:
        o = self._options
        self._journal = Journal(self._out, self._job.run)
        self.summary = Summary(printable(self._out.url), self._job.format, self.totals)
        self.summary.unchanged = self.totals.captures - self.totals.pending
        self._progress = Progress(self.totals, not o.quiet)
        trouble: Optional[FleetError] = None
        if self.totals.pending and not self._signals.caught:
            try:
                if o.address:
                    self._by_cluster()
                else:
                    self._by_workers(Processes(), _arguments.local_jobs(o))
            except LockTaken:
                self._progress.clear()
                self._journal.close()
                raise
            except FleetError as error:
                trouble = error
        self.summary.seconds, self.summary.converting = self._progress.seconds(), self._progress.converting()
        self._progress.clear()
        self._held.check(again=True)
        self._write_manifest()
        self._tell_summary()
        if trouble is not None:
            raise trouble
        if self._signals.caught:
            return -self._signals.caught
        return 1 if self.summary.failed or not self.summary.manifest else 0

    def _by_cluster(self) -> None:
        from ._cluster import connect

        cluster, jobs = connect(self._options)
        self._signals.install()  # Ray has its own
        try:
            self._by_workers(cluster, jobs)
        finally:
            cluster.leave()

    def _by_workers(self, pool: Pool, jobs: int) -> None:
        sizes: dict[str, int] = {}
        self.summary.workers = min(jobs, self.totals.pending)
        schedule = Schedule(pool, self._job, self.summary.workers, self._options.retries, self._tell)
        try:
            tasks = self._remember(sizes)
            for record in schedule.run(tasks, lambda: bool(self._signals.caught), lambda: self._tick(schedule.begun)):
                self._take(record, sizes.pop(record["output"]))
        finally:
            self.summary.lost = schedule.lost
            schedule.close()

    def _remember(self, sizes: dict[str, int]) -> Any:
        for task in self._ledger.tasks():
            sizes[to_text(task.output)] = task.size
            yield task

    def _tick(self, begun: Optional[float]) -> None:
        if begun is not None:
            self._progress.begin(begun)
        self._held.check()
        self._journal.tick()
        self._progress.show()

    def _take(self, record: Record, size: int) -> None:
        if record.pop("unchanged", False):
            record = {**(self._ledger.row(record["output"]) or {}), **{n: record[n] for n in ("source", "size", "stamp", "digest")}}
            self.summary.unchanged += 1
            self.summary.unchanged_now += 1
        else:
            self.summary.add_made(record)
            if record["status"] != "done":
                self._tell_failed(record)
        self._ledger.put(record)
        self._journal.add(record)
        self._progress.add(record, size)

    # The manifest

    def _reserve(self) -> None:
        """Room for the manifest, if the disk becomes full."""
        if isinstance(self._out, Local) and hasattr(os, "posix_fallocate"):
            path = self._out.where(RESERVE)
            try:
                with open(path, "wb") as file:
                    os.posix_fallocate(file.fileno(), 0, RESERVE_LEAST + RESERVE_OF_ROW * self.totals.captures)
            except OSError:
                self._out.remove(RESERVE)

    def _write_manifest(self) -> None:
        """Also of a run that was stopped. What cannot be written stays in the journal."""
        self._journal.tick(now=True)
        self._journal.close()
        self._out.remove_folder(PARTS)
        self._out.remove(RESERVE)
        try:
            _manifest.write(self._out, self._ledger.rows(), self._work.path, f"{PARTS}/{self._job.run}-manifest")
        except OSError as error:
            _arguments.told(f"{self._out.where(_manifest.NAME)}: cannot be written: {error.strerror or error}"
                            "; run the same command again when this is fixed")
            return
        self._out.remove_folder(_journal.FOLDER)
        self.summary.manifest = printable(self._out.where(_manifest.NAME))

    # Words

    def _tell(self, text: str) -> None:
        if not self._options.quiet:
            self._progress.clear()
            _arguments.told(f"warning: {text}")

    def _tell_failed(self, record: Record) -> None:
        self._progress.clear()
        text = record["message"]
        _arguments.told(text if record["source"] in text else f"{record['source']}: {text}")

    def _tell_summary(self) -> None:
        self.summary.interrupted = bool(self._signals.caught)
        for record in self._ledger.planned_rows():
            self.summary.add_row(record, self._job.version)
        if self._options.json:
            print(self.summary.json(), flush=True)
        elif not self._options.quiet:
            print(self.summary.text(), flush=True)

    def close(self) -> None:
        """Remove what only this run needs."""
        self._ledger.close()
        self._work.remove()
        remove_dead()


def run_name() -> str:
    """Later runs sort later."""
    return f"{time.strftime('%Y%m%dT%H%M%S', time.gmtime())}-{time.time_ns() % 10**9:09}-{secrets.token_hex(3)}"


def work(arguments: list[str], signals: Signals) -> int:
    """Do what the command line asks for; the exit status."""
    options = _arguments.parse(arguments)
    if options.help:
        print(_arguments.HELP, end="")
        return 0
    if options.version:
        print(f"lumfleet {VERSION}")
        return 0
    made = Run(options, _arguments.job(options, run_name(), VERSION), signals)
    try:
        made.plan()
        return made.dry() if options.dry_run else made.convert()
    finally:
        made.close()


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit status 0 done, 1 failed, 2 bad arguments; a signal ends it as a signal does."""
    signals = Signals()
    return run("lumfleet", lambda words: work(words, signals), arguments, signals)


if __name__ == "__main__":
    sys.exit(main())
