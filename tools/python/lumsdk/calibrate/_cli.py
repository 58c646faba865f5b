"""The program lumcal."""
from __future__ import annotations

import contextlib
import importlib
import json
import os
import sys
import time
import warnings
from collections.abc import Iterator
from typing import Any, Callable, Optional

from .._c import VERSION
from .._errors import Error, OptionError, install
from .._signals import Signals, Stopped, die_of
from .._target import Target
from ._arguments import Options, parse

PERIOD_S = 0.2


def told(text: str) -> None:
    """A line for the user, apart from the result."""
    shown = "".join(c if c.isprintable() else "?" for c in text)
    print(f"lumcal: {shown}".encode(errors="replace").decode(), file=sys.stderr, flush=True)


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
def _warnings_told(is_on: bool, progress: Progress) -> Iterator[None]:
    """What the package warns of, as a line of this program, once for each text."""
    seen = set()

    def show(message: Any, category: type[Warning], *_: Any, **__: Any) -> None:
        text = str(message)
        if is_on and issubclass(category, UserWarning) and text not in seen:
            seen.add(text)
            progress.clear()
            told(f"warning: {text}")

    with warnings.catch_warnings():
        warnings.simplefilter("always")
        # A calibration is what this program looks for, or at: which one, its result says.
        warnings.filterwarnings("ignore", ".*: it has a calibration of its own, which is not used")
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


# --- The commands ---


def need(module: str, what: str) -> None:
    """Refuse at the begin what would fail at the end."""
    try:
        importlib.import_module(module)
    except ImportError as error:
        name = {"scipy": "SciPy"}.get(module, module)
        raise Error(f"{what} needs {name}, which is not installed ({error}): {install('calibrate')}") from error


def eyes(options: Options, outputs: Outputs, progress: Progress) -> int:
    """Find the calibration; the exit status."""
    need("scipy", "lumcal eyes")
    if options.report is not None:
        need("matplotlib", "--report")
    from . import _eyes, _report, _tell

    outputs.begin(options.output)
    outputs.begin(options.report)
    count = len(options.captures)
    progress(f"reading {count} capture{'' if count == 1 else 's'} and solving")
    reading = options.of_grid()
    solution = _eyes.run(_eyes.Options(options.captures, options.calibration, reading.pop("profile", None), reading,
                                       options.of_calibration(), options.calibration_name, options.wishes))
    progress.clear()
    outputs.write(options.report, lambda: _report.page(solution).encode())
    why = _tell.not_written(solution)
    if not why:
        outputs.write(options.output, lambda: _eyes.to_yaml(solution).encode())
    outputs.finish()
    if options.json:
        print(json.dumps(_eyes.to_json(solution), indent=2))
    elif not options.quiet:
        print(_tell.solution_text(solution), end="")
    if why:
        told((f"{options.output} is not written: " if options.output else "") + why)
    return 1 if why else 0


def check(options: Options, outputs: Outputs, progress: Progress) -> int:
    """Measure how well a calibration fits; the exit status."""
    need("scipy", "lumcal check")
    if options.output is not None:
        need("matplotlib", "a picture")
    from . import _check, _picture, _tell

    outputs.begin(options.output)
    found = _check.check(options, progress)
    progress.clear()
    outputs.write(options.output, lambda: _picture.check_png(found))
    outputs.finish()
    if options.json:
        print(_tell.check_json(found), end="")
    elif not options.quiet:
        print(_tell.check_text(found), end="")
    return 0 if found.verdict == "meet" else 1


def work(arguments: list[str]) -> int:
    """Do what the command line asks for; the exit status."""
    options = parse(arguments)
    if options.help or options.version:
        print(options.help or f"lumcal {VERSION}\n", end="")
        return 0
    outputs, progress = Outputs(), Progress(not options.quiet)
    try:
        with _warnings_told(not options.quiet, progress):
            return (eyes if options.command == "eyes" else check)(options, outputs, progress)
    finally:
        progress.clear()
        outputs.drop()


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit status 0 done, 1 failed, 2 bad arguments; a signal ends it as a signal does."""
    signals = Signals()
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
        told(str(error))
        status = 2
    except (Error, OSError) as error:
        told(str(error))
        status = 1
    if status < 0:
        die_of(-status)
    return status


if __name__ == "__main__":
    sys.exit(main())
