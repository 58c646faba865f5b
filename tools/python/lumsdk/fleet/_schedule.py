"""Captures to workers: so many at a time, again when a worker or its machine dies."""
from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Callable, Optional, Protocol

from ._errors import FleetError, WorkerDied
from ._job import Job
from ._names import to_text
from ._ledger import Record, Task

# One is converted, the other waits at the worker: it does not have to wait for us.
TASKS_OF_WORKER = 2
WAIT_S = 0.2
PATIENCE_S = 15.0
CLOSE_S = 3.0


class Pool(Protocol):
    """Those who have workers: Ray on a cluster, or processes of this machine. A worker is asked for methods of Converter."""

    def start(self, job: Job) -> Any:
        """A worker, which may not have begun yet."""
        ...

    def ask(self, worker: Any, method: str, *arguments: Any) -> Any:
        """An answer to wait for."""
        ...

    def wait(self, answers: list[Any], seconds: float) -> list[Any]:
        """Those that are there, as soon as one is or the time is over."""
        ...

    def take(self, answer: Any) -> Any:
        """The value of one that is there. Raises WorkerDied; and FleetError for what ends the run."""
        ...

    def end(self, worker: Any) -> None:
        """At once; it may be gone already."""
        ...


@dataclass
class Worker:
    """One of the pool; ready is its first answer until it came."""

    who: Any
    ready: Any
    tasks: deque[Any] = field(default_factory=deque)  # of (answer, Task), oldest first


class Schedule:
    """Runs the tasks. Not more than two of each worker are under way, however many there are."""

    def __init__(self, pool: Pool, job: Job, jobs: int, retries: int, tell: Callable[[str], None]) -> None:
        self._pool = pool
        self._job = job
        self._jobs = jobs
        self._retries = retries
        self._tell = tell
        self._workers: list[Worker] = []
        self._again: deque[Task] = deque()
        self._tried: dict[str, int] = {}
        self._attempts = 0
        self._failed_starts = 0
        self._idle_since: Optional[float] = time.monotonic()
        self.lost = 0
        self.begun: Optional[float] = None  # when the first worker could begin

    def run(self, tasks: Iterator[Task], stop: Callable[[], bool], tick: Callable[[], None]) -> Iterator[Record]:
        """The rows in the order in which they are finished. Ends early when stop() says so."""
        more = True
        while not stop():
            more = self._fill(tasks) if more or self._again else False
            if not more and not self._again and not any(worker.tasks for worker in self._workers):
                return
            yield from self._collect()
            tick()
            self._tell_idle()

    def close(self) -> None:
        """Ends the workers and what they do. Those that have nothing to do leave nothing on their machines."""
        idle = [self._pool.ask(worker.who, "close") for worker in self._workers if worker.ready is None and not worker.tasks]
        end = time.monotonic() + CLOSE_S
        while idle and time.monotonic() < end:
            done = self._pool.wait(idle, end - time.monotonic())
            idle = [answer for answer in idle if answer not in done]
        for worker in self._workers:
            self._pool.end(worker.who)
        self._workers.clear()

    # Work out

    def _fill(self, tasks: Iterator[Task]) -> bool:
        """Gives workers what they have room for; False when there is nothing left to give."""
        for depth in range(TASKS_OF_WORKER):
            for worker in self._workers:
                if worker.ready is None and len(worker.tasks) <= depth:
                    task = self._again.popleft() if self._again else next(tasks, None)
                    if task is None:
                        return False
                    self._give(worker, task)
        self._start_workers()
        return True

    def _give(self, worker: Worker, task: Task) -> None:
        self._attempts += 1
        attempt = f"{self._job.run}-{self._attempts}"
        worker.tasks.append((self._pool.ask(worker.who, "convert", task, attempt), task))

    def _start_workers(self) -> None:
        while len(self._workers) < self._jobs:
            who = self._pool.start(self._job)
            self._workers.append(Worker(who, self._pool.ask(who, "ready")))

    # Results in

    def _collect(self) -> Iterator[Record]:
        owed = {}
        for worker in self._workers:
            if worker.ready is not None:
                owed[worker.ready] = worker
            owed.update({answer: worker for answer, _ in worker.tasks})
        if not owed:
            return
        for answer in self._pool.wait(list(owed), WAIT_S):
            worker = owed[answer]
            if worker in self._workers:
                yield from self._take(worker, answer)

    def _take(self, worker: Worker, answer: Any) -> Iterator[Record]:
        try:
            result: Any = self._pool.take(answer)
        except WorkerDied as error:
            yield from self._remove_dead(worker, error)
            return
        if worker.ready is answer:
            self._take_ready(worker, result)
            return
        task = next(t for a, t in worker.tasks if a is answer)
        worker.tasks = deque(pair for pair in worker.tasks if pair[0] is not answer)
        why = result.pop("lost", "")
        if not why:
            yield result
        elif self._may_try_again(task, why):
            self._again.append(task)
        else:
            result["message"] = self._gave_up(why)
            yield result

    def _take_ready(self, worker: Worker, result: dict[str, Any]) -> None:
        worker.ready = None
        self.begun = self.begun or time.monotonic()
        self._failed_starts = 0
        self._idle_since = None
        if "error" in result:
            raise FleetError(result["error"])
        if result["version"] != self._job.version:
            raise FleetError(f"a machine of the cluster has lumsdk {result['version']}, this one {self._job.version}:"
                             " install the same on all")

    # Workers that die

    def _remove_dead(self, worker: Worker, error: Exception) -> Iterator[Record]:
        """Its oldest capture was under way and counts as tried; what only waited there does not."""
        self._workers.remove(worker)
        self._pool.end(worker.who)
        if worker.ready is not None:
            self._failed_starts += 1
            if self._failed_starts > 3 * self._jobs + 10:
                raise FleetError(f"workers cannot be started: {str(error).strip().splitlines()[0]}")
        self._start_workers()
        if not any(w.ready is None for w in self._workers):
            self._idle_since = time.monotonic()
        for at, (_, task) in enumerate(worker.tasks):
            if at or self._may_try_again(task, "its worker or its machine died"):
                self._again.append(task)
            else:
                yield self._given_up(task)

    def _may_try_again(self, task: Task, why: str) -> bool:
        tried = self._tried[task.output] = self._tried.get(task.output, 0) + 1
        if tried <= self._retries:
            self.lost += 1
            self._tell(f"{to_text(task.source)}: {why}; it is tried again")
        return tried <= self._retries

    def _gave_up(self, why: str) -> str:
        return f"{why}, {self._retries + 1} times"

    def _given_up(self, task: Task) -> Record:
        return {"output": to_text(task.output), "source": to_text(task.source), "size": task.size, "stamp": task.stamp,
                "options": self._job.options, "version": self._job.version, "status": "failed", "seconds": 0.0,
                "message": self._gave_up("its worker or its machine died") + "; too little memory is the usual cause"}

    def _tell_idle(self) -> None:
        if self._idle_since is not None and time.monotonic() - self._idle_since > PATIENCE_S:
            self._tell("no worker could begin yet; waiting for a free processor")
            self._idle_since = None
