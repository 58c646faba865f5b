"""Captures to workers: so many at a time, again when a worker or its machine dies."""
from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Callable, Optional

from ._errors import FleetError
from ._job import Job
from ._names import to_text
from ._ledger import Record, Task
from ._work import Converter

# One is converted, the other waits at the worker: it does not have to wait for us.
TASKS_OF_WORKER = 2
WAIT_S = 0.2
PATIENCE_S = 15.0
CLOSE_S = 3.0


@dataclass
class Worker:
    """An actor; ready is its first answer until it came."""

    actor: Any
    ready: Any
    tasks: deque[Any] = field(default_factory=deque)  # of (ref, Task), oldest first


class Schedule:
    """Runs the tasks. Not more than two of each worker are under way, however many there are."""

    def __init__(self, job: Job, jobs: int, retries: int, tell: Callable[[str], None]) -> None:
        import ray

        self._ray: Any = ray
        self._job = job
        self._jobs = jobs
        self._retries = retries
        self._tell = tell
        self._actor: Any = ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(Converter)
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
        idle = [worker.actor.close.remote() for worker in self._workers if worker.ready is None and not worker.tasks]
        if idle:
            self._ray.wait(idle, num_returns=len(idle), timeout=CLOSE_S)
        for worker in self._workers:
            self._kill(worker)
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
        self._hire()
        return True

    def _give(self, worker: Worker, task: Task) -> None:
        self._attempts += 1
        attempt = f"{self._job.run}-{self._attempts}"
        worker.tasks.append((worker.actor.convert.remote(task, attempt), task))

    def _hire(self) -> None:
        while len(self._workers) < self._jobs:
            actor = self._actor.remote(self._job)
            self._workers.append(Worker(actor, actor.ready.remote()))

    # Results in

    def _collect(self) -> Iterator[Record]:
        refs = {}
        for worker in self._workers:
            if worker.ready is not None:
                refs[worker.ready] = worker
            refs.update({ref: worker for ref, _ in worker.tasks})
        if not refs:
            return
        waited = list(refs)
        done, rest = self._ray.wait(waited, timeout=WAIT_S)
        if done and rest:
            done += self._ray.wait(rest, num_returns=len(rest), timeout=0)[0]
        for ref in done:
            worker = refs[ref]
            if worker in self._workers:
                yield from self._take(worker, ref)

    def _take(self, worker: Worker, ref: Any) -> Iterator[Record]:
        try:
            result: Any = self._ray.get(ref)
        except self._ray.exceptions.RayTaskError as error:
            raise FleetError(f"a worker failed: {error.cause if error.cause is not None else error}") from error
        except self._ray.exceptions.RayError as error:
            yield from self._bury(worker, error)
            return
        if worker.ready is ref:
            self._welcome(worker, result)
            return
        task = next(t for r, t in worker.tasks if r is ref)
        worker.tasks = deque(pair for pair in worker.tasks if pair[0] is not ref)
        why = result.pop("lost", "")
        if not why:
            yield result
        elif self._may_try_again(task, why):
            self._again.append(task)
        else:
            result["message"] = self._gave_up(why)
            yield result

    def _welcome(self, worker: Worker, result: dict[str, Any]) -> None:
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

    def _bury(self, worker: Worker, error: Exception) -> Iterator[Record]:
        """Its oldest capture was under way and counts as tried; what only waited there does not."""
        self._workers.remove(worker)
        self._kill(worker)
        if worker.ready is not None:
            self._failed_starts += 1
            if self._failed_starts > 3 * self._jobs + 10:
                raise FleetError(f"workers cannot be started: {str(error).strip().splitlines()[0]}")
        self._hire()
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

    def _kill(self, worker: Worker) -> None:
        try:
            self._ray.kill(worker.actor)
        except Exception:  # it is gone
            pass

    def _tell_idle(self) -> None:
        if self._idle_since is not None and time.monotonic() - self._idle_since > PATIENCE_S:
            self._tell("no machine of the cluster has a free processor; waiting for one")
            self._idle_since = None
