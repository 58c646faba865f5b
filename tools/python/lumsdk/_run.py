"""What programs of the package have in common: what they tell, the files of a run, how a run ends."""
from __future__ import annotations

import contextlib
import importlib
import os
import signal
import sys
import time
import warnings
from collections.abc import Iterator
from typing import Any, Callable, Optional, Protocol, TypeVar

from ._c import VERSION
from ._errors import Error, OptionError, install
from ._target import Target

PERIOD_S = 0.2
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")


def told(name: str, text: str) -> None:
    """A line for the user of a program, apart from the result."""
    shown = "".join(c if c.isprintable() else "?" for c in text)
    print(f"{name}: {shown}".encode(errors="replace").decode(), file=sys.stderr, flush=True)


# --- Signals ---


class Stopped(BaseException):
    """A signal came."""


class Signals:
    """The first signal stops the run, the next one ends the program at once."""

    def __init__(self) -> None:
        self.caught = 0
        self.waits = False  # the run looks at `caught` itself

    def install(self) -> None:
        """Catch them from now on."""
        for name in SIGNALS:
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


# --- Progress ---


class Progress:
    """One line on a terminal; nothing elsewhere."""

    def __init__(self, is_on: bool) -> None:
        self._is_on = is_on and sys.stderr.isatty()
        self._shown_s = 0.0
        self._stage = ""
        self._width = 0

    def __call__(self, stage: str, share: Optional[float] = None) -> None:
        """What is done now, and how much of it is: 0 to 1."""
        now = time.monotonic()
        if not self._is_on or (stage == self._stage and now - self._shown_s < PERIOD_S):
            return
        self._stage, self._shown_s = stage, now
        line = stage if share is None else f"{stage}: {100 * share:.0f} %"
        try:
            line = line[:(os.get_terminal_size(sys.stderr.fileno()).columns or 80) - 1]
        except OSError:
            line = line[:79]
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)

    def clear(self) -> None:
        """Remove the line."""
        if self._width:
            sys.stderr.write("\r" + " " * self._width + "\r")
            sys.stderr.flush()
            self._width = 0
            self._stage = ""


@contextlib.contextmanager
def warnings_told(name: str, progress: Progress, is_on: bool, known: str = "") -> Iterator[None]:
    """What the package warns of, as a line of the program, once for each text, without those that match `known`."""
    seen = set()

    def show(message: Any, category: type[Warning], *_: Any, **__: Any) -> None:
        text = str(message)
        if is_on and issubclass(category, UserWarning) and text not in seen:
            seen.add(text)
            progress.clear()
            told(name, f"warning: {text}")

    with warnings.catch_warnings():
        warnings.simplefilter("always")
        if known:
            warnings.filterwarnings("ignore", known)
        warnings.showwarning = show  # type: ignore[assignment,unused-ignore]
        yield


# --- Files ---


class Outputs:
    """The files of a run. They get their names together, when all of them are on the disk."""

    def __init__(self) -> None:
        self._targets: dict[str, Target] = {}
        self._whole: list[Target] = []

    def begin(self, name: Optional[str]) -> None:
        """Refuse now what could not be written at the end."""
        if name is not None:
            self._targets[name] = Target(name)

    def write(self, name: Optional[str], make: Callable[[], bytes]) -> None:
        """Give a file that was begun its content."""
        if name is not None:
            self._targets[name].fill(make())
            self._whole.append(self._targets[name])

    def finish(self) -> None:
        """Give all that was written its names."""
        for target in self._whole:
            target.finish()

    def drop(self) -> None:
        """Remove what was not written whole."""
        for target in self._targets.values():
            target.discard()


# --- Its begin and its end ---


def need(module: str, what: str, extra: str) -> None:
    """Refuse at the begin what would fail at the end."""
    try:
        importlib.import_module(module)
    except ImportError as error:
        shown = {"scipy": "SciPy", "kiss_icp": "kiss-icp"}.get(module, module)
        raise Error(f"{what} needs {shown}, which is not installed ({error}): {install(extra)}") from error


def run(name: str, work: Callable[[list[str]], int], arguments: Optional[list[str]], signals: Optional[Signals] = None) -> int:
    """Exit status 0 done, 1 failed, 2 bad arguments; a signal ends the program as a signal does."""
    signals = signals or Signals()
    signals.install()
    try:
        status = work(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
    except Stopped:
        status = -signals.caught
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = 1
    except OptionError as error:
        told(name, str(error))
        status = 2
    except (Error, OSError) as error:
        told(name, str(error))
        status = 1
    if status < 0:
        die_of(-status)
    return status


class Asked(Protocol):
    """What a command line asks every program for."""

    quiet: bool
    help: str
    """The text to print; empty: none was asked for."""
    version: bool


_Options = TypeVar("_Options", bound=Asked)


def main(name: str, parse: Callable[[list[str]], _Options], act: Callable[[_Options, Outputs, Progress], int],
         arguments: Optional[list[str]], known: str = "") -> int:
    """A program that reads captures and writes files; known: warnings that it does not pass on. Its exit status, as of run()."""
    def work(words: list[str]) -> int:
        options = parse(words)
        if options.help or options.version:
            print(options.help or f"{name} {VERSION}\n", end="")
            return 0
        outputs, progress = Outputs(), Progress(not options.quiet)
        try:
            with warnings_told(name, progress, not options.quiet, known):
                return act(options, outputs, progress)
        finally:
            progress.clear()
            outputs.drop()

    return run(name, work, arguments)
