"""Frames of a live sensor: a reader in C over its session, and what ends them."""
from __future__ import annotations

import collections
import threading
import weakref
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Optional

from ._c import LOSSES, check, failure, ffi, lib, sized
from ._errors import ClosedError, Error, LaserError, SensorError, SensorWarning
from ._frame import Frame
from ._laser import MISSING
from ._reading import Counts
from ._session import RECEIVE_BUFFER, now_ns

if TYPE_CHECKING:
    from ._connection import Connection
    from ._laser import LaserControl
    from ._sensor import Sensor

_TICK_MS = 20
_FOREVER_MS = 0xFFFFFFFF
_DROPS_NS = 10_000_000_000


def losses_of(reader: Any) -> dict[str, int]:
    """What is missing so far in what a reader gave, by cause."""
    counts = Counts(reader).counts
    return {name: counts[name] for name in LOSSES}


class Stream:
    """Frames of a session under way."""

    def __init__(self, connection: Connection, laser: LaserControl, duration: Optional[float], silence: float,
                 framer: Any) -> None:
        self._connection, self._laser = connection, laser
        self._session: Any = connection.session
        self._duration, self._silence = duration, silence
        self._ready: collections.deque[Frame] = collections.deque()
        self.failure: Optional[BaseException] = None
        self.has_ended = False
        self._begun = self._heard = self._next_tick = now_ns()
        self._first: Optional[int] = None
        self._drops, self._drops_told = 0, -_DROPS_NS
        self._error, self._out = ffi.new("lum_error *"), ffi.new("const lum_frame **")
        self._handle = ffi.new_handle(weakref.ref(self))
        self.reader: Any = ffi.NULL
        """In C; NULL once it has ended."""
        lib.lum_cancel_reset(connection.cancel)
        live = sized("lum_live_options", sensor=self._session, silence_ms=_FOREVER_MS, on_event=_c_on_event,
                     context=self._handle, data_ms=_TICK_MS)
        records, reader = sized("lum_record_source"), ffi.new("lum_reader **")
        check(lib.lum_live_source(live, records, self._error), self._error, SensorError)
        options = sized("lum_reader_options", records=records, framer=framer, go_on=_c_go_on, go_on_context=self._handle)
        check(lib.lum_reader_open(options, reader, self._error), self._error, SensorError)
        self.reader = reader[0]

    def __del__(self) -> None:
        if getattr(self, "reader", None):
            self.close()

    def close(self) -> None:
        """End it; what it counted stays with the sensor."""
        reader, self.reader = self.reader, ffi.NULL
        if reader and not self._connection.is_of_parent():
            self._connection.past_losses.update(losses_of(reader))
            lib.lum_reader_close(reader)
            lib.lum_cancel_reset(self._connection.cancel)
        self.has_ended = True

    # What happens inside C's calls.

    def take(self, event: Any) -> bool:
        """An event of the session, in C. Whether to go on."""
        lib.lum_laser_session_take(self._laser.session.c, event, now_ns())
        return self.failure is None

    def tick(self) -> bool:
        """Look at what may end the stream, and send what is due. Called every few milliseconds."""
        now, laser = now_ns(), self._laser
        if now < self._next_tick or not self.reader:  # it is also called while the reader opens
            return True
        self._next_tick = now + _TICK_MS * 1_000_000
        laser.take_news()
        laser.send_due()
        view = laser.session.look()
        if view.has_data and view.data_ns > self._begun:
            self._heard = max(self._heard, int(view.data_ns))
            self._first = self._first or now
        self.failure = self.failure or laser.take_problem() or self._find_silence(now)
        is_over = self._first is not None and _is_past(self._first, self._duration, now)
        if self.failure is not None:  # which says it
            laser.drop_warnings((*MISSING, "hazard", getattr(self.failure, "news", "")))
        if is_over or self.failure is not None:
            lib.lum_cancel_raise(self._connection.cancel)  # then what was read comes out first
        else:
            self._tell_drops(now)
        return True

    def _find_silence(self, now: int) -> Optional[SensorError]:
        """Data that does not come."""
        has_lasted = self._first is None and _is_past(self._begun, self._duration, now)
        is_silent = has_lasted or _is_past(self._heard, self._silence, now)
        return self._laser.session.missing(self._heard).error() if is_silent else None

    def _tell_drops(self, now: int) -> None:
        if now < self._drops_told + _DROPS_NS:
            return
        drops = int(lib.lum_socket_drops(lib.lum_sensor_socket(self._session)))
        if drops == self._drops:
            return
        self._drops, self._drops_told = drops, now
        has_room = lib.lum_socket_has_room(lib.lum_sensor_socket(self._session))
        why = ("; this program is too slow" if has_room else
               f", and is smaller than was asked for: sysctl -w net.core.rmem_max={RECEIVE_BUFFER}")
        self._laser.warnings.append(SensorWarning(
            f"{self._connection.address}: the system dropped {drops} datagrams so far: its receive buffer was full{why}; "
            "or they came damaged, with wrong checksums"))

    # What the sensor's calls do.

    def read(self) -> bool:
        """Read until a frame is ready, and keep it; False: there is none any more."""
        if self.has_ended:
            return False
        # The time between two calls was the program's, and no silence of the sensor.
        self._heard = now_ns()
        if self._first is None:
            self._begun = self._heard
        status = lib.lum_reader_next_frame(self.reader, self._out, self._error)
        lost = _lost.pop(threading.get_ident(), None)
        if lost is not None:
            self.failure = lost
        if isinstance(self.failure, LaserError) and self._laser.was_switched_on:
            self._laser.off_after(self.failure)
        if self.failure is not None and not isinstance(self.failure, Error):
            problem, self.failure = self.failure, None
            self.close()
            raise problem
        if status > 0:
            self._ready.append(Frame(self._out[0]))
            return True
        if status < 0 and self.failure is None:
            self.failure = failure(self._error, SensorError)
        self.close()
        return False

    def next(self) -> Optional[Frame]:
        """The next frame; None: it has ended."""
        while not self._ready and self.read():
            pass
        self._laser.give_warnings()
        if self._ready:
            return self._ready.popleft()
        problem, self.failure = self.failure, None
        if problem is not None:
            raise problem
        return None


def _is_past(since: int, seconds: Optional[float], now: int) -> bool:
    return seconds is not None and now - since >= seconds * 1e9


_lost: dict[int, BaseException] = {}


def _keep(kind: Any, value: Any, traceback: Any) -> None:
    """An exception outside the function's own try, such as Ctrl-C as it begins."""
    _lost[threading.get_ident()] = value


def _call(context: Any, method: Callable[..., bool], *arguments: Any) -> bool:
    """A method of the stream, by C; what it raises is raised once C has returned."""
    stream: Optional[Stream] = ffi.from_handle(context)()
    if stream is None:
        return False
    try:
        return method(stream, *arguments)
    except BaseException as problem:
        stream.failure = problem
        return False


def _on_event(context: Any, event: Any) -> bool:
    return _call(context, Stream.take, event)


def _go_on(context: Any) -> bool:
    return _call(context, Stream.tick)


_c_on_event = ffi.callback("bool(void *, const lum_sensor_event *)", _on_event, error=False, onerror=_keep)
_c_go_on = ffi.callback("bool(void *)", _go_on, error=False, onerror=_keep)


class Frames(Iterator[Frame]):
    """The frames of a live sensor, as they come; made by Sensor.frames()."""

    def __init__(self, sensor: Sensor, stream: Stream) -> None:
        self._stream, self._sensor = stream, sensor  # in this order they are collected

    def __iter__(self) -> Frames:
        return self

    def __next__(self) -> Frame:
        """Wait for the next frame, and send heartbeats meanwhile."""
        stream = self._stream
        with self._sensor._connection.use():
            if stream is not self._sensor._connection.stream_ref():
                raise ClosedError(f"{self._sensor.address}: these frames have ended: frames() was called again")
            frame = stream.next()
        if frame is None:
            raise StopIteration
        return frame

    def close(self) -> None:
        """End it. Frames, and arrays of them, stay valid."""
        with self._sensor._connection.use(closed_is_fine=True):
            self._stream._ready.clear()
            self._stream.failure = None
            self._stream.close()

    def __enter__(self) -> Frames:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Frames of {self._sensor.address}{', ended' if self._stream.has_ended else ''}>"
