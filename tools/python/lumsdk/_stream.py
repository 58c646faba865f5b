"""Frames of a live sensor: a reader in C over its session, and what ends them."""
from __future__ import annotations

import collections
import math
import threading
import time as clock
import weakref
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Optional

from ._c import failure, ffi, lib, sized
from ._errors import ClosedError, Error, LaserError, SensorError, SensorWarning, warn
from ._frame import Frame
from ._reading import LOSSES, Counts
from ._session import RECEIVE_BUFFER, Event, hazards_of, is_down, names_of, show

if TYPE_CHECKING:
    from ._sensor import Sensor

_TICK_S = 0.02
_POLL_S = 1.0
_FOREVER_MS = 0xFFFFFFFF
_DROPS_S = 10.0


def losses_of(reader: Any) -> dict[str, int]:
    """What is missing so far in what a reader gave, by cause."""
    counts = Counts(reader).counts
    return {name: counts[name] for name in LOSSES}


class Stream:
    """Frames of a session under way."""

    def __init__(self, sensor: Sensor, duration: Optional[float], silence: float, framer: Any) -> None:
        self._sensor = sensor
        self._session: Any = sensor._session
        self._duration, self._silence = duration, silence
        self._ready: collections.deque[Frame] = collections.deque()
        self._warnings: list[str] = []
        self._told: set[str] = set()
        self.failure: Optional[BaseException] = None
        self.has_ended = False
        self._next_tick = 0.0
        now = clock.monotonic()
        self._begun, self._poll, self._heard = now, now, now
        self._first: Optional[float] = None
        self._packets = self._drops = 0
        self._drops_told = -math.inf
        self._error, self._out = ffi.new("lum_error *"), ffi.new("const lum_frame **")
        self._demux = sized("lum_demux_counters")
        self._handle = ffi.new_handle(weakref.ref(self))
        self._reader: Any = ffi.NULL
        lib.lum_cancel_reset(sensor._cancel)
        live = sized("lum_live_options", sensor=self._session, silence_ms=_FOREVER_MS, on_event=_c_on_event,
                     context=self._handle)
        records, reader = sized("lum_record_source"), ffi.new("lum_reader **")
        if lib.lum_live_source(live, records, self._error) != 0:
            raise failure(self._error, SensorError)
        options = sized("lum_reader_options", records=records, framer=framer, go_on=_c_go_on, go_on_context=self._handle)
        if lib.lum_reader_open(options, reader, self._error) != 0:
            raise failure(self._error, SensorError)
        self._reader = reader[0]

    def __del__(self) -> None:
        if getattr(self, "_reader", None):
            self.close()

    def close(self) -> None:
        """End it; what it counted stays with the sensor."""
        reader, self._reader = self._reader, ffi.NULL
        if reader and not self._sensor._is_of_parent():
            self._sensor._add_losses(reader)
            lib.lum_reader_close(reader)
            lib.lum_cancel_reset(self._sensor._cancel)
        self.has_ended = True

    @property
    def reader(self) -> Any:
        """The reader in C; NULL once it has ended."""
        return self._reader

    # What happens inside C's calls.

    def take(self, event: Event) -> bool:
        """Look at an event of the session. Whether to go on."""
        self._look(event)
        return self.failure is None

    def tick(self) -> None:
        """Look at what may end the stream, and ask for the status. Called every few milliseconds."""
        now = clock.monotonic()
        if now < self._next_tick or not self._reader:  # it is also called while the reader opens
            return
        self._next_tick = now + _TICK_S
        self._count(now)
        self.failure = self.failure or self._find_failure(now)
        is_over = self._first is not None and self._duration is not None and now - self._first >= self._duration
        if is_over or self.failure is not None:
            lib.lum_cancel_raise(self._sensor._cancel)  # then what was read comes out first
        elif now >= self._poll and not lib.lum_sensor_is_waiting(self._session):
            lib.lum_sensor_request(self._session, ffi.NULL, 0)
            self._poll = now + _POLL_S
            self._tell_drops(now)

    def _look(self, event: Event) -> None:
        name = self._sensor.address
        if event.kind == lib.LUM_SENSOR_LINK:
            self._warnings.append(f"sending to {name} works again" if event.is_up else
                                  f"sending to {name} fails: {event.error}; it is tried again and again")
        elif event.kind == lib.LUM_SENSOR_NO_ANSWER:
            if self._packets:
                self._warn_once(f"{name} sends data, but does not answer when asked for its status")
        elif event.kind in (lib.LUM_SENSOR_ANSWER, lib.LUM_SENSOR_ALERT):
            is_alert = event.kind == lib.LUM_SENSOR_ALERT
            self._warnings += self._sensor._texts(event)
            if is_alert:
                self._poll = 0.0  # it may be older than what is known: the sensor is asked
            if event.status is not None:
                self._judge(event.status, is_alert)

    def _warn_once(self, told: str) -> None:
        if told not in self._told:
            self._told.add(told)
            self._warnings.append(told)

    def _judge(self, status: int, is_alert: bool) -> None:
        """A laser that we switched on and that is down ends the stream: from there on, frames have no points."""
        sensor, hazards = self._sensor, hazards_of(status)
        if not is_alert:
            sensor._status = status
        if sensor._laser_is_up and (hazards or (is_down(status) and not is_alert)):
            sensor._laser_is_up = False
            self.failure = sensor._fell(status)
        elif hazards and self.failure is None:
            self._warn_once(f"{sensor.address} reports a hazard: {' '.join(names_of(hazards))}")
        elif not is_alert:
            sensor._pause = 0.0

    def _find_failure(self, now: float) -> Optional[SensorError]:
        """Data that does not come, or comes from elsewhere."""
        has_lasted = self._first is None and self._duration is not None and now - self._begun >= self._duration
        if now - self._heard >= self._silence or has_lasted:
            return self._silent(now)
        new, old = ffi.new("lum_endpoint *"), self._sensor.address
        if lib.lum_sensor_moved_to(self._session, new):
            return SensorError(f"the data comes from {show(new)} now, not from {old}: the sensor has got that address. "
                               f"It ends in 3 s, since the heartbeats go to {old}: say "
                               f'lumsdk.Sensor("{show(new)}") from now on')
        return None

    def _count(self, now: float) -> None:
        lib.lum_demux_total(lib.lum_framer_demux(lib.lum_reader_framer(self._reader)), self._demux)
        packets = int(self._demux.packets[lib.LUM_PACKET_DATA])
        if packets != self._packets:
            self._packets, self._heard = packets, now
            self._first = now if self._first is None else self._first

    def _tell_drops(self, now: float) -> None:
        drops = int(lib.lum_socket_drops(lib.lum_sensor_socket(self._session)))
        if drops == self._drops or now < self._drops_told + _DROPS_S:
            return
        self._drops, self._drops_told = drops, now
        has_room = lib.lum_socket_has_room(lib.lum_sensor_socket(self._session))
        why = ("; this program is too slow" if has_room else
               f", and is smaller than was asked for: sysctl -w net.core.rmem_max={RECEIVE_BUFFER}")
        self._warnings.append(f"{self._sensor.address}: the system dropped {drops} datagrams so far: its receive buffer was full"
                              f"{why}; or they came damaged, with wrong checksums")

    def _silent(self, now: float) -> SensorError:
        name, since = self._sensor.address, now - self._heard
        if self._first is not None:
            return SensorError(f"no data from {name} for {since:.3g} s (a sensor that was restarted is at 10.42.0.37 "
                               f"again; lumctl --host {name} doctor finds out more)")
        why = (", though it answers: is a profile needed, or does a firewall drop what is not an answer?"
               if self._sensor._status_is_known else
               ", nor any answer: is it on, connected and at this address? It boots at 10.42.0.37")
        return SensorError(f"no data from {name} within {since:.3g} s{why}; look with lumctl --host {name} doctor")

    # What the sensor's calls do.

    def read(self) -> bool:
        """Read until a frame is ready, and keep it; False: there is none any more."""
        if self.has_ended:
            return False
        # The time between two calls was the program's, and no silence of the sensor.
        self._heard = clock.monotonic()
        if self._first is None:
            self._begun = self._heard
        status = lib.lum_reader_next_frame(self._reader, self._out, self._error)
        lost = _lost.pop(threading.get_ident(), None)
        if lost is not None:
            self.failure = lost
        if isinstance(self.failure, LaserError) and self._sensor._laser_is_due:
            self._sensor._put_down_after(self.failure)
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
        while self._warnings:
            warn(self._warnings.pop(0), SensorWarning)
        if self._ready:
            return self._ready.popleft()
        problem, self.failure = self.failure, None
        if problem is not None:
            raise problem
        return None


_lost: dict[int, BaseException] = {}


def _keep(kind: Any, value: Any, traceback: Any) -> None:
    """An exception outside the function's own try, such as Ctrl-C as it begins."""
    _lost[threading.get_ident()] = value


def _on_event(context: Any, event: Any) -> bool:
    stream: Optional[Stream] = ffi.from_handle(context)()
    if stream is None:
        return False
    try:
        return stream.take(Event(event))
    except BaseException as problem:
        stream.failure = problem
        return False


def _go_on(context: Any) -> bool:
    stream: Optional[Stream] = ffi.from_handle(context)()
    if stream is None:
        return False
    try:
        stream.tick()
        return True
    except BaseException as problem:
        stream.failure = problem
        return False


_c_on_event = ffi.callback("bool(void *, const lum_sensor_event *)", _on_event, error=False, onerror=_keep)
_c_go_on = ffi.callback("bool(void *)", _go_on, error=False, onerror=_keep)


class Frames(Iterator[Frame]):
    """The frames of a live sensor, as they come; made by Sensor.frames()."""

    def __init__(self, sensor: Sensor, stream: Stream) -> None:
        self._sensor, self._stream = sensor, stream

    def __iter__(self) -> Frames:
        return self

    def __next__(self) -> Frame:
        """Wait for the next frame. Heartbeats are sent in here."""
        stream = self._stream
        with self._sensor._use():
            if stream is not self._sensor._stream_ref():
                raise ClosedError(f"{self._sensor.address}: these frames have ended: frames() was called again")
            frame = stream.next()
        if frame is None:
            raise StopIteration
        return frame

    def close(self) -> None:
        """End it. Frames, and arrays of them, stay valid."""
        with self._sensor._use(closed_is_fine=True):
            self._stream._ready.clear()
            self._stream.failure = None
            self._stream.close()

    def __enter__(self) -> Frames:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Frames of {self._sensor.address}{', ended' if self._stream.has_ended else ''}>"
