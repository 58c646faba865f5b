"""Simulated captures and sensors, by the program lumsim."""
from __future__ import annotations

import contextlib
import difflib
import functools
import inspect
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time as clock
from collections.abc import Callable, Iterable, Mapping
from typing import IO, TYPE_CHECKING, Any, Optional, TypeVar, Union, cast, overload

from ._errors import ClosedError, Error, OptionError, SensorError
from ._lumdump import END_S, end, setting_file
from ._programs import find
from ._settings import entries

if TYPE_CHECKING:
    from typing_extensions import Literal

    from ._rig import Given as OneRig
    from ._settings import Value

    Path = Union[str, os.PathLike[str]]
    Settings = Union[Path, Mapping[str, Any]]

_Function = TypeVar("_Function", bound=Callable[..., Any])

_READY_S = 120.0
_WAIT_S = 0.05  # without it, Ctrl-C is taken a quarter of a second late
_LOG_MAX = 200_000


# Ctrl-C is for this program, which switches the laser off before the sensor ends.
_GROUP: int = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)


# --- Options ---


def _word(name: str, value: Any) -> str:
    """An option's value as lumsim takes it, which checks it."""
    if isinstance(value, bool) or not isinstance(value, (str, int, float, os.PathLike)):
        if hasattr(value, "__index__"):
            return str(value.__index__())
        raise TypeError(f"{name} is {value!r}, of type {type(value).__name__}; see lumsim --help")
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _several(value: Any) -> list[Any]:
    return [value] if isinstance(value, str) or not isinstance(value, Iterable) else list(value)


def _arguments(options: Mapping[str, Any], folder: str) -> list[str]:
    """Options by their names as arguments; None: not given. The folder is for files with settings that have none."""
    words: list[str] = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
        elif name in ("calibration", "profile", "rig"):
            words += [option, setting_file(name, value, folder)]
        elif name == "set":
            words += [word for key, given in entries(value) for word in (option, f"{key}={given}")]
        elif name in ("fault", "truth"):
            words += [word for each in _several(value) for word in (option, _word(name, each))]
        elif name in ("pose", "noise"):
            words += [f"{option}={','.join(_word(name, number) for number in _several(value))}"]
        else:
            words += [option, _word(name, value)]
    return words


def _complaint(said: bytes, returncode: int) -> Error:
    """What lumsim said last, without its name."""
    lines = [line for line in said.decode(errors="replace").splitlines() if line and not line.startswith("Try '")]
    told = lines[-1] if lines else f"lumsim ended with status {returncode}"
    told = told[len("lumsim: "):] if told.startswith("lumsim: ") else told
    return OptionError(told) if returncode == 2 else Error(told)


# --- Captures ---


def _run(arguments: list[str]) -> bytes:
    # A session of its own: Ctrl-C is for this program, which ends the other once.
    process = subprocess.Popen([find("lumsim"), *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, start_new_session=sys.platform != "win32")
    ended = None
    try:
        while ended is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                ended = process.communicate(timeout=_WAIT_S)
    except BaseException:
        end(process)
        raise
    out, said = ended
    if process.returncode != 0:
        raise _complaint(said, process.returncode)
    return out


def _with_known_names(call: _Function) -> _Function:
    """A function whose refusals of options say what is right."""
    names = list(inspect.signature(call).parameters)

    @functools.wraps(call)
    def checked(*given: Any, **options: Any) -> Any:
        if given and "path" in options:
            raise TypeError("path is given twice: it is the file's name; how the sensor moves is motion=, such as "
                            'motion="circle"')
        for name in options:
            if name not in names:
                near = difflib.get_close_matches(name, names, 1)
                raise TypeError(f"there is no option {name}; " + (f"did you mean {near[0]}?" if near else
                                                                  f"there are {', '.join(names)}"))
        return call(*given, **options)
    return cast(_Function, checked)


@overload
def simulate(path: Path, frames: int = ..., lines: Literal[64, 640] = ..., seed: int = ..., *, rate: float = ...,
             returns_max: int = ..., loss: float = ..., duplicate: float = ..., reorder: float = ...,
             corrupt: float = ..., scene: Literal["street", "room", "yard", "town", None] = ...,
             pose: Union[str, Iterable[float], None] = ..., walls: Literal["flat", "mild", "rough", None] = ...,
             noise: Union[float, Iterable[float], None] = ..., truth: Union[Path, Iterable[Path], None] = ...,
             time: Literal["sensor", "utc", None] = ..., motion: Optional[Path] = ..., velocity: Optional[float] = ...,
             poses: Optional[Path] = ..., labels: Optional[Path] = ...,
             drift: float = ..., batch: float = ..., calibration: Optional[Settings] = ...,
             profile: Optional[Settings] = ..., set: Union[Mapping[str, Value], Iterable[str], None] = ...,
             address: Optional[str] = ..., client: Optional[str] = ..., rig: Optional[OneRig] = ...) -> str: ...
@overload
def simulate(path: None = ..., frames: int = ..., lines: Literal[64, 640] = ..., seed: int = ..., *, rate: float = ...,
             returns_max: int = ..., loss: float = ..., duplicate: float = ..., reorder: float = ...,
             corrupt: float = ..., scene: Literal["street", "room", "yard", "town", None] = ...,
             pose: Union[str, Iterable[float], None] = ..., walls: Literal["flat", "mild", "rough", None] = ...,
             noise: Union[float, Iterable[float], None] = ..., truth: Union[Path, Iterable[Path], None] = ...,
             time: Literal["sensor", "utc", None] = ..., motion: Optional[Path] = ..., velocity: Optional[float] = ...,
             poses: Optional[Path] = ..., labels: Optional[Path] = ...,
             drift: float = ..., batch: float = ..., calibration: Optional[Settings] = ...,
             profile: Optional[Settings] = ..., set: Union[Mapping[str, Value], Iterable[str], None] = ...,
             address: Optional[str] = ..., client: Optional[str] = ..., rig: Optional[OneRig] = ...) -> bytes: ...


@_with_known_names
def simulate(path: Optional[Path] = None, frames: int = 3, lines: Literal[64, 640] = 64, seed: int = 1, *,
             rate: float = 10.0, returns_max: int = 4, loss: float = 0.0, duplicate: float = 0.0, reorder: float = 0.0,
             corrupt: float = 0.0, scene: Literal["street", "room", "yard", "town", None] = None,
             pose: Union[str, Iterable[float], None] = None, walls: Literal["flat", "mild", "rough", None] = None,
             noise: Union[float, Iterable[float], None] = None, truth: Union[Path, Iterable[Path], None] = None,
             time: Literal["sensor", "utc", None] = None, motion: Optional[Path] = None, velocity: Optional[float] = None,
             poses: Optional[Path] = None, labels: Optional[Path] = None,
             drift: float = 0.0, batch: float = 0.0, calibration: Optional[Settings] = None,
             profile: Optional[Settings] = None, set: Union[Mapping[str, Value], Iterable[str], None] = None,
             address: Optional[str] = None, client: Optional[str] = None,
             rig: Optional[OneRig] = None) -> Union[str, bytes]:
    """A capture of a sensor that drives along a simulated street or round a town, or is in a room or a yard, written to
    a path, which is returned; without a path, its bytes, for lumsdk.open().

    The same arguments give the same bytes. A name that ends in .pcapng gives pcapng, with the calibration and the
    profile in it; all else is pcap.

    frames, lines (64 or 640), rate (frames a second, 0.2 to 100), seed (of street, noise and faults) and returns_max
    (of a pixel, 1 to 8) say what is recorded. loss, duplicate, reorder and corrupt are probabilities from 0 to 1 for
    each data packet. scene is "street", "town", "room" or "yard". With a pose (x, y, z in metres, roll, pitch, yaw in
    degrees) the sensor stands still there, as it does in all but the street if nothing else is said. The walls of a room
    and a yard are "flat", "mild" or "rough". With a motion ("straight", "circle", "eight", "stop-and-go", or a file of
    poses) it moves, with velocity in m/s, and each pixel is from where it is at its own time: --path of lumsim. poses is
    a path that gets these poses (TUM), labels one that gets the object and class of each exact point, for numpy.load().
    noise is the standard deviation of ranges in metres, of all returns or of the first, the second and so on. truth is
    a path that gets the exact points as CSV, with times by time; one that ends in .yaml gets the true calibration, and
    two paths get both. drift (parts in a million) and batch (milliseconds) are what the capture's clock does.
    calibration and profile are a path, a mapping or an object of lumsdk, set has single keys of them. address is the
    sensor's, client the receiver's HOST or HOST:PORT.

    rig is what open() takes for it: then all its sensors are in the capture, pose and motion are the vehicle's, and truth
    and labels have %s in their names, for the name of the sensor. Sensors with an interface need a name that ends in
    .pcapng.

    Raises OptionError for what lumsim refuses, and Error where it fails, both with its sentence.
    """
    options = {**locals()}
    options["path"] = options.pop("motion")
    if path is not None and not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"the path is {path!r}, of type {type(path).__name__}; use a path, or None for bytes")
    name = None if path is None else os.fspath(path)
    # A name such as -x is a path too.
    output = "-" if name is None else os.path.join(os.curdir, name) if name.startswith("-") else name
    with tempfile.TemporaryDirectory(prefix="lumsdk-") as folder:
        out = _run(["--quiet", "--output", output, *_arguments(options, folder)])
    return out if name is None else name


# --- Sensors ---


class _Log:
    """What a sensor writes, read by threads that do not keep the object alive of which it is the log."""

    def __init__(self) -> None:
        self.events: list[dict[str, Any]] = []
        self.said = b""
        self.news = threading.Condition()

    def read(self, process: subprocess.Popen[bytes]) -> list[threading.Thread]:
        """Begin to read."""
        readers = [threading.Thread(target=self._read_events, args=(process.stdout,), daemon=True),
                   threading.Thread(target=self._read_said, args=(process.stderr,), daemon=True)]
        for reader in readers:
            reader.start()
        return readers

    def _read_events(self, pipe: IO[bytes]) -> None:
        for line in pipe:
            with self.news:
                if line.endswith(b"\n") and len(self.events) < _LOG_MAX:
                    self.events.append(json.loads(line))
                    self.news.notify_all()
        pipe.close()

    def _read_said(self, pipe: IO[bytes]) -> None:
        self.said = pipe.read()
        pipe.close()


class SimulatedSensor:
    """A sensor on this machine's network, for tests and tutorials, as long as the block lasts.

        with lumsdk.SimulatedSensor("127.0.0.2") as simulated:
            with lumsdk.Sensor(simulated.host) as sensor:
                ...

    It is ready when the block begins. On Linux every address of 127.0.0.0/8 exists, so that any number can run at a
    time. The options are those of lumsim on the network. log is what it received and did so far, as `man lumsim` has
    it under LOG.
    """

    def __init__(self, address: str = "127.0.0.1", *, port: Optional[int] = None, lines: Literal[64, 640, None] = None,
                 frames: Optional[int] = None, rate: Optional[float] = None, seed: int = 1,
                 returns_max: Optional[int] = None, loss: float = 0.0, duplicate: float = 0.0, reorder: float = 0.0,
                 corrupt: float = 0.0, jitter: float = 0.0, answer_delay: float = 0.0, answer_loss: float = 0.0,
                 fault: Union[str, Iterable[str]] = (), clock: Optional[int] = None,
                 boot_status: Optional[int] = None, duration: Optional[float] = None, interface: Optional[str] = None,
                 replay: Optional[Path] = None, speed: Optional[float] = None, loop: bool = False, sensor: Optional[str] = None,
                 scene: Literal["street", "room", "yard", "town", None] = None,
                 pose: Union[str, Iterable[float], None] = None, walls: Literal["flat", "mild", "rough", None] = None,
                 motion: Optional[Path] = None, velocity: Optional[float] = None,
                 noise: Union[float, Iterable[float], None] = None, calibration: Optional[Settings] = None,
                 profile: Optional[Settings] = None, set: Union[Mapping[str, Value], Iterable[str], None] = None) -> None:
        """Start it, and wait until it is ready.

        frames of lines (64 or 640) are rendered with seed and played in a loop, rate of them a second; scene, pose,
        walls, motion, velocity and noise are those of simulate().
        replay sends the data of a capture instead, speed times as fast, once
        or in a loop. loss, duplicate, reorder and corrupt are probabilities from 0 to 1 for each data packet,
        answer_loss for each answer. jitter and answer_delay are milliseconds. fault is one or several of NAME@T,
        NAME@T-T2 or NAME@USR1-USR2, such as "fan@10-12"; cue() makes those with USR1 and USR2 happen. clock is its clock
        at the start in microseconds, boot_status its laser status at boot without 0x0800 (0x0010 if None).

        Raises OptionError for what lumsim refuses, SensorError where it cannot run there, both with its sentence.
        """
        options = {name: value for name, value in locals().items() if name != "self"}
        options["path"] = options.pop("motion")
        options["boot_status"] = None if boot_status is None else f"{boot_status:#06x}"
        if not isinstance(address, str):
            raise TypeError(f"the address is {address!r}; use a text, such as \"127.0.0.1\"")
        if replay is not None:
            options["seed"] = None if seed == 1 else seed
        self.address = address
        """Where it listens."""
        self.host = address if port is None else f"{address}:{port}"
        """What lumsdk.Sensor() takes."""
        self._log = _Log()
        self._process: Optional[subprocess.Popen[bytes]] = None
        with tempfile.TemporaryDirectory(prefix="lumsdk-") as folder:
            self._start(_arguments(options, folder), "start" if replay is not None else "frames")

    def _start(self, arguments: list[str], ready: str) -> None:
        process = subprocess.Popen([find("lumsim"), "--quiet", "--log", "-", *arguments], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, creationflags=_GROUP,
                                   start_new_session=sys.platform != "win32")
        self._process = process
        self._readers = self._log.read(process)
        try:
            self.wait_for(lambda: any(e["event"] == ready for e in self._log.events), _READY_S)
        except SensorError:
            returncode = process.wait(END_S) if not self._readers[0].is_alive() else 1
            self.close()
            problem = _complaint(self._log.said, returncode)
            raise problem if isinstance(problem, OptionError) else SensorError(str(problem)) from None
        except BaseException:
            self.close()
            raise

    @property
    def log(self) -> list[dict[str, Any]]:
        """What it received and did so far; the first 200,000 events."""
        with self._log.news:
            return list(self._log.events)

    def events(self, kind: str, after: float = 0.0) -> list[dict[str, Any]]:
        """The events of a kind, such as "laser", after a time of its log."""
        return [event for event in self.log if event["event"] == kind and event["t"] > after]

    @property
    def laser_on(self) -> bool:
        """Whether its laser is up."""
        changes = self.events("laser")
        return bool(changes) and bool(changes[-1]["up"])

    def wait_for(self, condition: Callable[[], Any], seconds: float = 10.0) -> Any:
        """Wait until a condition of its log holds, and return what it gave. Raises SensorError if that does not come
        in time, or if the sensor has ended."""
        end = clock.monotonic() + seconds
        with self._log.news:
            while True:
                found = condition()
                if found:
                    return found
                if not self._readers[0].is_alive():
                    raise SensorError("the simulated sensor has ended")
                if clock.monotonic() >= end:
                    raise SensorError(f"the condition did not hold within {seconds:g} s")
                # In short pieces, so that Ctrl-C is taken on every system.
                self._log.news.wait(0.05)

    def cue(self, number: int) -> None:
        """Make the faults happen that wait for USR1 (1) or USR2 (2). Not on Windows."""
        names = {1: "SIGUSR1", 2: "SIGUSR2"}
        if number not in names:
            raise OptionError(f"a cue is {number!r}; use 1 or 2")
        if not hasattr(signal, names[number]):
            raise Error(f"{sys.platform} has no such signals: name times in fault=")
        if self._process is None:
            raise ClosedError("the simulated sensor has ended")
        self._process.send_signal(getattr(signal, names[number]))

    def close(self) -> None:
        """End it; its log stays."""
        process, self._process = self._process, None
        if process is not None:
            end(process)
            for reader in self._readers:
                reader.join(END_S)

    def __enter__(self) -> SimulatedSensor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        process = getattr(self, "_process", None)
        if process is not None:
            process.kill()
            process.wait()

    def __repr__(self) -> str:
        state = "ended" if self._process is None else "laser on" if self.laser_on else "laser off"
        return f"<SimulatedSensor {self.host}: {state}>"
