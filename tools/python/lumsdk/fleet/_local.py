"""Workers as processes of this machine."""
from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Optional

from ._errors import FleetError, WorkerDied
from ._job import Job
from ._work import Converter

_SPAWN = multiprocessing.get_context("spawn")


class Answer:
    """What a worker owes: a value, or the error that it raised."""

    def __init__(self, worker: Process) -> None:
        self.worker = worker
        self.is_there = False
        self.value: Any = None
        self.error: Optional[Exception] = None


class Process:
    """A worker. It does what it is asked in that order."""

    def __init__(self, job: Job) -> None:
        self.pipe, other = _SPAWN.Pipe()
        self._owed: deque[Answer] = deque()
        self._process = _SPAWN.Process(target=_serve, args=(other, job), daemon=True)
        _begin_tracker()
        with _interrupts_held():
            self._process.start()
        other.close()

    def ask(self, method: str, arguments: tuple[Any, ...]) -> Answer:
        answer = Answer(self)
        self._owed.append(answer)
        with suppress(OSError):  # it died: receive() notices
            self.pipe.send((method, arguments))
        return answer

    def receive(self) -> None:
        """Take an answer that is there; if the process ended, all that it owes are errors."""
        try:
            value, error = self.pipe.recv()
        except (EOFError, OSError):
            value, error = None, WorkerDied("its process ended")
        while self._owed:
            answer = self._owed.popleft()
            answer.is_there, answer.value, answer.error = True, value, error
            if not isinstance(error, WorkerDied):
                return

    def end(self) -> None:
        """At once, with the lumdump that it has under way: both are a group of processes, also if it died."""
        if hasattr(os, "killpg") and self._process.pid is not None:
            with suppress(OSError):  # it has not come to make its group
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()
        self.pipe.close()


class Processes:
    """A pool of processes. They end with this one."""

    def start(self, job: Job) -> Process:
        return Process(job)

    def ask(self, worker: Process, method: str, *arguments: Any) -> Answer:
        return worker.ask(method, arguments)

    def wait(self, answers: list[Answer], seconds: float) -> list[Answer]:
        """Those that are there, as soon as one is."""
        workers: dict[Any, Process] = {answer.worker.pipe: answer.worker for answer in answers}
        for pipe in multiprocessing.connection.wait(list(workers), seconds):
            workers[pipe].receive()
        return [answer for answer in answers if answer.is_there]

    def take(self, answer: Answer) -> Any:
        """The value of one that is there."""
        if isinstance(answer.error, WorkerDied):
            raise answer.error
        if answer.error is not None:
            raise FleetError(f"a worker failed: {answer.error}")
        return answer.value

    def end(self, worker: Process) -> None:
        worker.end()


def _begin_tracker() -> None:
    """The system's own helper of processes. When it begins, it lets signals through that are held."""
    if os.name == "posix":
        from multiprocessing import resource_tracker

        resource_tracker.ensure_running()


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """A process that begins has Ctrl-C of this one's terminal held until it is out of its reach."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin_group() -> None:
    """Ctrl-C of a terminal is for the driver, which ends its workers itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setsid"):
        os.setsid()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


def _end_with_driver() -> None:
    driver = multiprocessing.parent_process()
    if driver is not None:
        driver.join()
    if hasattr(os, "killpg"):
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _serve(pipe: Any, job: Job) -> None:
    """The work of the process. An error is the answer: of a conversion, convert() has made a row of it."""
    _begin_group()
    threading.Thread(target=_end_with_driver, daemon=True).start()
    converter: Optional[Converter] = None
    with suppress(EOFError, OSError):  # the driver is gone
        while True:
            method, arguments = pipe.recv()
            value, failure = None, None
            try:
                converter = converter or Converter(job, has_group=hasattr(os, "killpg"))
                value = getattr(converter, method)(*arguments)
            except Exception as error:
                failure = FleetError(str(error) or repr(error))
            pipe.send((value, failure))
