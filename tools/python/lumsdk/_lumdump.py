"""Conversions that the program lumdump does: it writes, and its summary and its messages come back."""
from __future__ import annotations

import contextlib
import io
import json
import math
import os
import subprocess
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import IO, Any, Union

from ._errors import CaptureError, CaptureWarning, Error, OptionError
from ._poses import Poses
from ._programs import find
from ._rig import Rig
from ._settings import Calibration, Profile, entries

_BLOCK = 1 << 20
END_S = 10.0
_WAIT_S = 0.05


# --- Options as arguments ---


def _number(value: object) -> str:
    if value is None or (isinstance(value, float) and math.isinf(value)):
        return ""
    return str(value)


def _joined(mark: str, part: Callable[[Any], str] = _number) -> Callable[[Any], str]:
    """Values as one text, with a mark between them; a text is one already, and a number is one value."""
    return lambda value: part(value) if isinstance(value, str) or hasattr(value, "__index__") else mark.join(map(part, value))


def _frames(value: Any) -> str:
    if isinstance(value, range):
        value = (value[0], value[-1])
    return f"{value}:{value}" if hasattr(value, "__index__") else _joined(":")(value)


_TEXTS: Mapping[str, Callable[[Any], str]] = {"range": _joined(":"), "box": _joined(",", _joined(":")), "frames": _frames,
                                              "smooth": _joined(":"), "columns": _joined(","), "size": _joined("x")}
_NAMES = {"returns": "return", "pose_times": "pose-times"}
_FLAGS = ("ascii", "comments", "organized")


_KINDS: Mapping[str, Any] = {"calibration": Calibration, "profile": Profile, "rig": Rig}


def setting_file(name: str, value: Any, folder: str) -> str:
    """The path of a calibration, a profile or a rig."""
    if isinstance(value, os.PathLike) or (isinstance(value, str) and "\n" not in value):
        return os.fsdecode(value)
    path = os.path.join(folder, f"{name}.yaml")
    made = _KINDS[name](value)
    if isinstance(made, Rig):
        made.save(path)
    else:
        with open(path, "w", encoding="utf-8") as file:
            file.write(made.to_yaml())
    return path


def arguments(options: Mapping[str, Any], folder: str) -> list[str]:
    """Options of Python, which were checked, as those of lumdump.

    Args:
        options: by their names in Python.
        folder: for files with values that have none.
    """
    out = []
    for name, value in options.items():
        if name in _FLAGS:
            out += [f"--{name}"] if value else []
        elif name == "set":
            out += [f"--set={key}={given}" for key, given in entries(value)]
        elif name == "poses" and isinstance(value, Poses):
            value.save(os.path.join(folder, "poses.txt"))
            out.append(f"--poses={os.path.join(folder, 'poses.txt')}")
        elif name in ("poses", "pose_times"):
            out.append(f"--{_NAMES.get(name, name)}={os.fsdecode(value)}")
        elif name in _KINDS:
            out.append(f"--{name}={setting_file(name, value, folder)}")
        else:
            out.append(f"--{_NAMES.get(name, name)}={_TEXTS.get(name, str)(value)}")
    return out


# --- The run ---


def _feed(file: Any, pipe: IO[bytes], failed: list[BaseException], process: subprocess.Popen[bytes]) -> None:
    """The bytes of a file object to the program. If they end in a failure, the program must not take that for the end."""
    try:
        while True:
            block = file.read(_BLOCK)
            if not isinstance(block, (bytes, bytearray, memoryview)):
                raise TypeError(f"read() gives {type(block).__name__} and not bytes: open the file with mode \"rb\"")
            if not len(block):
                break
            try:
                pipe.write(block)
            except OSError:  # the program has ended, and says why
                break
    except BaseException as error:
        failed.append(error)
        process.terminate()
        process.wait()
    finally:
        with contextlib.suppress(OSError):
            pipe.close()


def _gather(pipe: IO[bytes], into: list[bytes]) -> None:
    with pipe:
        into.append(pipe.read())


def end(process: subprocess.Popen[bytes]) -> None:
    """End a program, which removes what it has begun."""
    process.terminate()
    try:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(END_S)
    finally:
        if process.returncode is None:  # it does not end, or Ctrl-C came again
            process.kill()
            process.wait()


def _say(lines: Sequence[str], status: int) -> None:
    """Warnings of the program as warnings; its last sentence as an exception if it failed."""
    said = []
    for line in lines:
        text = line[len("lumdump: "):] if line.startswith("lumdump: ") else ""
        if text.startswith("warning: "):
            warnings.warn(text[len("warning: "):], CaptureWarning, stacklevel=5)
        elif text:
            said.append(text)
    if status == 0:
        return
    sentence = said[-1] if said else "\n".join(lines[-3:]) or f"lumdump ended with status {status}"
    raise (OptionError if status == 2 else CaptureError)(sentence)


def run(source: Union[Sequence[str], Any], output: str, options: Iterable[str]) -> dict[str, Any]:
    """Convert.

    Args:
        source: paths, or an object with read() of bytes, which is read once.
        output: the name of the output, as lumdump takes it.
        options: further arguments.

    Returns:
        The summary that lumdump prints as JSON.

    Raises:
        OptionError, CaptureError: what lumdump says when it refuses or fails.
        Whatever read() raises.
    """
    is_paths = isinstance(source, (list, tuple))
    command = [find("lumdump"), *options, "--json", "-o", output, "--", *(source if is_paths else ["-"])]
    with tempfile.TemporaryFile() as errors:
        given = None if is_paths and "-" in source else subprocess.DEVNULL if is_paths else subprocess.PIPE
        # A session of its own: Ctrl-C is for this program, which ends the other once.
        process = subprocess.Popen(command, stdin=given, stdout=subprocess.PIPE, stderr=errors,
                                   start_new_session=os.name != "nt")
        printed: list[bytes] = []
        failed: list[BaseException] = []
        threads = [threading.Thread(target=_gather, args=(process.stdout, printed), daemon=True)]
        if not is_paths:
            threads.append(threading.Thread(target=_feed, args=(source, process.stdin, failed, process), daemon=True))
        try:
            for thread in threads:
                thread.start()
            while threads[0].is_alive():  # wait() would take Ctrl-C a quarter of a second late
                threads[0].join(_WAIT_S)
            process.wait()
        except BaseException:
            end(process)
            raise
        # A file object may wait for bytes that nobody needs any more.
        threads[-1].join(_WAIT_S)
        if failed:
            raise failed[0]
        errors.seek(0)
        lines = errors.read().decode(errors="replace").splitlines()
    _say(lines, process.returncode)
    try:
        summary: dict[str, Any] = json.loads(b"".join(printed))
    except ValueError as error:
        raise Error(f"lumdump printed no summary: {error}") from error
    return summary


def bytes_of(source: Any) -> int:
    """The size of what run() reads, as far as it is known before; else 0."""
    if isinstance(source, io.BytesIO):
        return len(source.getbuffer())
    return sum(os.path.getsize(path) for path in source if os.path.isfile(path)) if isinstance(source, list) else 0
