"""Signals that end a program of the package as they end the other tools."""
from __future__ import annotations

import os
import signal

NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")


class Stopped(BaseException):
    """A signal came."""


class Signals:
    """The first signal stops the run, the next one ends the program at once."""

    def __init__(self) -> None:
        self.caught = 0
        self.waits = False  # the run looks at `caught` itself

    def install(self) -> None:
        """Catch them from now on."""
        for name in NAMES:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._take)

    def _take(self, number: int, _: object) -> None:
        if self.caught:
            die_of(number)
        self.caught = number
        if not self.waits:
            raise Stopped


def die_of(number: int) -> None:
    """The caller sees the signal."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
