"""A live sensor: its laser, its settings, its frames."""
from __future__ import annotations

import atexit
import contextlib
import math
import operator
import os
import threading
import time as clock
import warnings
import weakref
from collections.abc import Callable, Iterator, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, Optional, Union

from ._c import ffi, lib, sized, text
from ._errors import ClosedError, LaserError, OptionError, SensorError, SensorWarning, warn
from ._options import Choice
from ._refusal import refusal_of
from ._session import (Answer, Clock, Event, LaserSession, News, Off, Plan, Status, lacks_heartbeats, new_cancel, now_ns, printable,
                       put_down, receive, show, status_of)
from ._settings import Calibration, Profile, setting_of
from ._stream import Frames, Stream, losses_of

if TYPE_CHECKING:
    from typing_extensions import Literal, Unpack

    from ._options import Options

    Eye = Literal["blue", "green"]

_PUMP_S = 0.2
_GC_OFF_S = 3.0
_EXCHANGES = 8
_APART_S = 0.01
_OWN = ": nobody sends heartbeats. Begin a session that owns the sensor, by lumsdk.Sensor(...) without owns=False"

# What became of laser_on(), and what a request says itself, or its answer.
_ON = ("laser-up", "laser-refused", "laser-unseen", "laser-unanswered", "laser-held-up")
_UNANSWERED = ("no-answer", "no-answer-yet", "unheard")
_ANSWERED = ("text", "hazard", "no-status")

_open: weakref.WeakSet[Sensor] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """No laser stays on because a program forgot it."""
    for sensor in list(_open):
        try:
            sensor.close()
        except Exception as problem:
            warnings.warn(str(problem), SensorWarning, stacklevel=1)


def _leave_to_parent() -> None:
    """The sockets that a forked process got belong to its parent, and the right to own the sensor with them."""
    for sensor in list(_open):
        sensor._leave()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


# --- The laser, for a block ---


class Laser:
    """The laser on for a block; made by Sensor.laser()."""

    def __init__(self, sensor: Sensor) -> None:
        self._sensor = sensor

    def __enter__(self) -> Status:
        return self._sensor.laser_on()

    def __exit__(self, kind: Optional[type[BaseException]], value: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        # What ended the session in the block has switched the laser off, or has said that it could not.
        if self._sensor._session:
            self._sensor.laser_off()


# --- The sensor ---


class Sensor:
    """A session with a sensor.

        with lumsdk.Sensor("10.42.0.37") as sensor:
            with sensor.laser():
                for frame in sensor.frames(duration=5):
                    use(frame.xyz)

    The sensor sends its data to the program that sends it heartbeats, and switches its laser off 3 s after the last
    one. Heartbeats are sent only inside the calls of this object: a program that stops calling it, because it hangs,
    waits or works on something else for 3 s, loses the laser. This is the safety, and there is no thread that would
    keep the laser on behind a program's back.

    The laser goes off at the end of the block of laser() or of this object, by close(), when the object is collected,
    and at the end of the interpreter, each time only if this object switched it on. A process that is killed sends
    nothing any more: then the sensor switches the laser off, after 3 s. That is so for SIGTERM too, where the program
    has no handler for it.

    One program of a host can own a sensor at a time. With owns=False it only asks and sets, as lumctl does, beside a
    program that owns it.

    Only one thread at a time may use it; a call during another one raises SensorError, but for laser_off() and
    cancel(). Several sensors can be used in several threads. A process that was forked cannot use it.
    """

    def __init__(self, host: Any = "10.42.0.37", *, interface: Optional[str] = None,
                 calibration: Union[str, os.PathLike[str], Mapping[str, Any], Calibration, None] = None,
                 profile: Union[str, os.PathLike[str], Mapping[str, Any], Profile, None] = None,
                 set: Any = None, owns: bool = True, timeout: float = 0.4, retries: int = 4) -> None:
        """Begin a session. Nothing is sent yet, so that it is not known whether there is a sensor.

        host is an address or a name, alone or with a port: "10.42.0.37", "lidar.local", "10.42.0.37:5517"; udp:// may
        stand before it, as for lumdump. interface is the name of one, such as "eth0". calibration, profile and set
        are as for lumsdk.open(). timeout is in seconds for each try of a request, retries the number of further tries.

        Raises SensorError where the host is not known, another program owns the sensor, or the network refuses;
        OptionError and TypeError for what is not allowed.
        """
        self._session: Any = ffi.NULL
        self._side: Any = ffi.NULL
        self._lock = threading.Lock()
        self._process = os.getpid()
        self._stream_ref: Callable[[], Optional[Stream]] = lambda: None
        self._laser_is_due = self._off_was_called = False
        self._on: Optional[News] = None
        self._problem: Optional[SensorError] = None
        self._told: list[SensorWarning] = []
        self._sync: Any = None
        self._past: dict[str, int] = {}
        self._calibration = calibration if isinstance(calibration, Calibration) else Calibration(calibration)
        self._profile = profile if isinstance(profile, Profile) else Profile(profile)
        if set is not None:
            self._calibration, self._profile = setting_of(self._calibration, self._profile, set)
        if not isinstance(owns, bool):
            raise TypeError(f"owns is {owns!r}; right is True or False")
        self._owns = owns
        self._plan = Plan(host, interface, self._profile, timeout, retries)
        self._cancel = new_cancel()
        self._laser = LaserSession(self._plan, owns)
        self._session = self._plan.open(owns, self._cancel)
        self.address = show(lib.lum_sensor_endpoint(self._session))
        """Where the sensor is, with its port where that is not 5517."""
        _open.add(self)

    # Its life.

    @contextlib.contextmanager
    def _use(self, closed_is_fine: bool = False) -> Iterator[None]:
        """A call of the session, one at a time."""
        if not self._lock.acquire(blocking=False):
            raise SensorError(f"{self.address}: the session is in use by another thread; one thread at a time may use "
                              "it, and several sensors can be used in several")
        try:
            if not closed_is_fine:
                self._check()
            if self._stream() is None:
                lib.lum_cancel_reset(self._cancel)
            yield
        finally:
            self._lock.release()

    def _check(self) -> None:
        if self._is_of_parent():
            raise ClosedError(f"{self.address}: the session belongs to the process that began it; this one was forked "
                              "from it, and opens its own")
        if not self._session:
            raise ClosedError(f"{self.address}: {self._why_closed}")

    def _is_of_parent(self) -> bool:
        return self._process != os.getpid()

    def _leave(self) -> None:
        """In a process that was forked: the sockets are closed, and nothing is sent."""
        for session in (self._side, self._session):
            lib.lum_sensor_close(session)
        self._side = self._session = ffi.NULL

    _why_closed = "the sensor is closed; open it again to use it"

    def _stream(self) -> Optional[Stream]:
        """The frames that are under way."""
        stream = self._stream_ref()
        return None if stream is None or stream.has_ended else stream

    def _end(self) -> None:
        """End the session in C, and with it the heartbeats."""
        stream = self._stream()
        if stream is not None:
            stream.close()
        if self._session:
            self._count()
        for session in (self._side, self._session):
            lib.lum_sensor_close(session)
        self._side = self._session = ffi.NULL
        _open.discard(self)

    def close(self) -> None:
        """Switch the laser off if this object switched it on, and end the session. Frames stay valid.

        Raises LaserError where the laser was not seen to go off; the session has ended then too.
        """
        if not self._session:
            return
        if self._lock.locked() and self._laser_is_due:
            self._put_down()
        with self._use(closed_is_fine=True):
            try:
                if self._laser_is_due:
                    self._finish_off(self._try_off())
            finally:
                self._end()

    def __enter__(self) -> Sensor:
        self._check()
        return self

    def __exit__(self, kind: Optional[type[BaseException]], value: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        self.close()

    def __del__(self) -> None:
        if not getattr(self, "_session", None) or self._is_of_parent():
            return
        warnings.warn(f"unclosed {self!r}: say with lumsdk.Sensor(...) as sensor, or close()", ResourceWarning,
                      stacklevel=1, source=self)
        if self._laser_is_due:
            off = put_down(self._laser, self._session, _GC_OFF_S)
            if off.result != lib.LUM_LASER_OFF_SEEN:
                warnings.warn(off.news.warning(), stacklevel=1)
        self._end()

    def __repr__(self) -> str:
        is_up = self._laser.look().laser == lib.LUM_LASER_UP
        laser = "" if not self._laser_is_due else ", laser on" if is_up else ", laser switched on"
        return f"<Sensor {self.address}{laser if self._session else ', closed'}{'' if self._owns else ', not its owner'}>"

    # What its laser session has to do, and has found.

    def _serve(self) -> None:
        """Send what is due."""
        if self._off_was_called:  # in another thread, which has sent it too
            self._off_was_called = False
            self._laser.want(lib.LUM_WANT_OFF)
        lib.lum_laser_session_serve(self._laser.c, self._session, now_ns())

    def _hear(self, said: tuple[str, ...] = ("no-answer",)) -> None:
        """Take its news, but for what is said elsewhere. What ends frames ends the next ones, where there are none."""
        if self._laser_is_due:
            said += ("laser-came-up", "laser-fell") if self._off_was_called else ("laser-came-up",)
        for news in self._laser.news():
            if news.name in _ON:
                self._on = news
            elif news.weight != lib.LUM_NEWS_INFO and news.name not in said:
                if news.weight == lib.LUM_NEWS_ERROR and (self._laser_is_due or news.name == "moved"):
                    self._problem = self._problem or news.error()
                self._told.append(news.warning())

    def _take_problem(self) -> Optional[SensorError]:
        problem, self._problem = self._problem, None
        return problem

    def _tell(self) -> None:
        while self._told:
            warn(self._told.pop(0))

    def _step(self, line: Any, serves: bool = True) -> Event:
        """Send what is due, and take one event, or nothing for a while."""
        if line == self._side:
            event = receive(line)
        else:
            if serves:
                self._serve()
            event = receive(line, self._laser)
            self._hear(_UNANSWERED + (_ANSWERED if event.kind == lib.LUM_SENSOR_ANSWER else ()))
        if event.kind == lib.LUM_SENSOR_FAILED:
            raise SensorError(event.error)
        if event.kind == lib.LUM_SENSOR_CANCELLED:
            lib.lum_cancel_reset(self._cancel)
        return event

    # Requests.

    def _line(self) -> Any:
        """The session that requests go over: while frames are under way, another one than theirs, which would lose the
        data that comes during a request."""
        if self._stream() is None:
            return self._session
        if not self._side:
            self._side = self._plan.open(False)
        return self._side

    def _request(self, begin: Callable[[Any], int]) -> Event:
        """A request and its answer."""
        line = self._line()
        lib.lum_sensor_give_up(line)
        if begin(line) != lib.LUM_OK:
            raise OptionError(f"the request does not fit one packet of {lib.LUM_SENSOR_REQUEST_BYTES} bytes")
        if line == self._session:
            lib.lum_laser_session_lend(self._laser.c, now_ns())
        try:
            event = self._answer(line)
        except BaseException:
            lib.lum_sensor_give_up(line)
            raise
        if event.status is not None and self._keep_down():
            event.status = int(self._laser.look().status)
        self._tell()
        return event

    def _answer(self, line: Any) -> Event:
        read, was_due = clock.monotonic(), bool(self._laser.look().is_off_due)
        while True:
            if not was_due and self._keep_down():  # whose answer would be taken for the request's
                raise SensorError(f"{self.address}: laser off comes first: whether the sensor got the request is not known")
            before = clock.monotonic()
            event, stream = self._step(line, serves=not was_due), self._stream()
            if event.kind in (lib.LUM_SENSOR_ANSWER, lib.LUM_SENSOR_TIME):
                return event
            if event.kind == lib.LUM_SENSOR_NO_ANSWER:
                raise self._no_answer(event.tries, clock.monotonic() - before)
            if stream is not None and clock.monotonic() - read >= _PUMP_S:  # heartbeats and data go on
                stream.read()
                read = clock.monotonic()

    def _no_answer(self, tries: int, seconds: float) -> SensorError:
        if seconds >= lib.LUM_SENSOR_STALE_MS / 1000:
            return SensorError(f"{self.address}: this program was held up for {seconds:.1f} s during a request; whether the "
                               "sensor got it is not known")
        return self._plan.news(lib.LUM_NEWS_NO_ANSWER).error(
            f" (tried {tries} {'time' if tries == 1 else 'times'}, {self._plan.timeout_ms} ms{'' if tries == 1 else ' each'})")

    def _keep_down(self) -> bool:
        """A laser that the laser session switches off is seen to be down before the program goes on."""
        is_due = self._stream() is None and bool(self._laser.look().is_off_due)
        if is_due:
            self._tell()
            self._finish_off(self._try_off())
        return is_due

    def _rest(self, seconds: float) -> None:
        """Pause, with heartbeats."""
        end, line = clock.monotonic() + seconds, self._line()
        while clock.monotonic() < end:
            self._step(line)

    def _has_owner(self) -> bool:
        """Whether heartbeats go to the sensor."""
        return self._owns or bool(lib.lum_sensor_is_owned(lib.lum_sensor_endpoint(self._session), self._plan.interface,
                                                          ffi.NULL))

    def _status_of(self, value: int) -> Status:
        return status_of(value, self._owns or (lacks_heartbeats(value) and self._has_owner()))

    def _answer_of(self, event: Event) -> Answer:
        numbers = self._plan.layout.profile.tlv
        debug = tuple(printable(value) for kind, value in event.tlvs if kind == numbers[lib.LUM_TLV_DEBUG])
        known = (numbers[lib.LUM_TLV_DEBUG], numbers[lib.LUM_TLV_STATUS])
        return Answer(None if event.status is None else self._status_of(event.status), debug,
                      tuple(pair for pair in event.tlvs if pair[0] not in known), event.tries,
                      (event.received_ns - event.sent_ns) * 1e-9 if event.tries == 1 else None)

    def _command(self, command: str) -> Answer:
        return self._answer_of(self._request(lambda line: int(lib.lum_sensor_command(line, command.encode()))))

    def _change(self, command: str, typed: str) -> Answer:
        """A command that the sensor must not refuse."""
        with self._use():
            answer = self._command(command)
        said = refusal_of(command, answer.debug)
        if said is not None:
            raise SensorError(f"{self.address} refused '{typed}': {said}")
        return answer

    # What it tells.

    def status(self) -> Status:
        """The laser's status. Raises SensorError if no answer comes."""
        with self._use():
            event = self._request(lambda line: int(lib.lum_sensor_request(line, ffi.NULL, 0)))
        for said in self._answer_of(event).debug:
            warn(self._plan.news(lib.LUM_NEWS_TEXT, said).warning())
        if event.status is None:
            raise self._plan.news(lib.LUM_NEWS_NO_STATUS).error()
        return self._status_of(event.status)

    def time(self) -> Clock:
        """The sensor's clock against this host's, by eight exchanges. The drift becomes known with later calls."""
        with self._use():
            if self._sync is None:
                self._sync = ffi.new("lum_clock_sync *")
                lib.lum_clock_sync_init(self._sync)
            trip = 0
            for i in range(_EXCHANGES):
                if i:
                    self._rest(_APART_S)
                event = self._request(lambda line: int(lib.lum_sensor_request_time(line)))
                trip = event.received_ns - event.sent_ns
                lib.lum_clock_sync_add(self._sync, event.sent_ns, event.received_ns, event.clock_us)
            e = ffi.new("lum_clock_estimate *")
            if lib.lum_clock_sync_estimate(self._sync, e) != lib.LUM_OK:
                raise SensorError(f"{self.address}: its clock could not be read")
        utc_ns = int(lib.lum_time_utc_ns()) - int(lib.lum_time_monotonic_ns())
        return Clock(int(e.clock_us), int(e.offset_ns) + utc_ns, int(e.error_ns), trip * 1e-9,
                     int(e.drift_ppb) if e.has_drift else None, int(e.drift_error_ppb) if e.has_drift else None,
                     int(e.exchanges), int(e.resets))

    @property
    def calibration(self) -> Calibration:
        """The calibration that frames are made with, if frames() is given no other."""
        return self._calibration

    @property
    def profile(self) -> Profile:
        """The wire profile that its packets are read with."""
        return self._profile

    def _count(self) -> None:
        """Take over what C has counted."""
        c = sized("lum_sensor_counters")
        lib.lum_sensor_count(self._session, c)
        names = [name for name, _ in ffi.typeof("lum_sensor_counters").fields if name != "struct_size"]
        self._counted = {name: int(getattr(c, name)) for name in names}

    @property
    def counters(self) -> dict[str, int]:
        """What the session counted since it began: datagrams, heartbeats, requests and so on."""
        with self._use(closed_is_fine=True):
            if self._session:
                self._count()
        return dict(self._counted)

    _counted: Mapping[str, int] = {}

    def _add_losses(self, reader: Any) -> None:
        for name, count in losses_of(reader).items():
            self._past[name] = self._past.get(name, 0) + count

    @property
    def losses(self) -> dict[str, int]:
        """What is missing so far in all of its frames, by cause, with lumdump's names.

        kernel_drops are datagrams that this host dropped since the program was too slow to read them.
        """
        drops = {"kernel_drops": self.counters.get("kernel_drops", 0)}
        with self._use(closed_is_fine=True):
            stream = self._stream_ref()
            now = losses_of(stream.reader) if stream is not None and stream.reader else {}
            names = {**now, **self._past}
            return {**drops, **{name: now.get(name, 0) + self._past.get(name, 0) for name in names}}

    # The laser.

    def laser(self) -> Laser:
        """The laser on for a block, and off on every way out of it: its end, an exception, Ctrl-C.

            with sensor.laser():
                ...

        Heartbeats, which keep it on, are sent only inside the calls of this object. Raises as laser_on() and
        laser_off() do.
        """
        return Laser(self)

    def laser_on(self) -> Status:
        """Switch the laser on, and see that it is up. Returns its status.

        Keep people's eyes away from the beam. It is not switched on again by itself after it went down. Full strength
        takes several seconds.

        Raises HazardError where a hazard keeps it down, LaserError where it does not come up for another reason,
        SensorError where no answer comes for 5 s. In each case `laser off` was sent and seen, so that it does not come
        up later.
        """
        with self._use():
            self._laser_is_due, self._off_was_called, self._on, self._problem = True, False, None, None
            try:
                return self._switch_on()
            except BaseException as problem:
                self._put_down_after(problem)
                raise

    def _switch_on(self) -> Status:
        lib.lum_sensor_give_up(self._session)
        lib.lum_laser_session_note_owner(self._laser.c, self._has_owner())
        self._laser.want(lib.LUM_WANT_ON)
        while self._laser.look().laser == lib.LUM_LASER_ASKED:
            stream = self._stream()
            if stream is None:
                self._step(self._session)
            else:
                stream.read()
        self._hear()
        self._tell()
        if self._on is None:
            raise LaserError(f"{self.address}: laser_off() was called during laser_on()")
        if self._on.name != "laser-up":
            raise self._on.error(_OWN if not self._owns and lacks_heartbeats(self._on.status) else "")
        return self._status_of(self._on.status)

    def laser_off(self) -> Status:
        """Switch the laser off, and see that it is down. Returns its status.

        It is repeated for ten seconds; after three of them, Ctrl-C ends it. It also works while another thread uses
        the session. Raises LaserError where nothing showed that it is off: then this session has ended, since its
        heartbeats would keep the laser on.
        """
        self._check()
        return self._put_down()

    def _put_down(self) -> Status:
        if not self._lock.acquire(blocking=False):
            self._off_was_called = True
            return self._finish_off(self._off_anew(False), ends=False)
        try:
            return self._finish_off(self._try_off())
        finally:
            self._lock.release()

    def _try_off(self) -> Off:
        try:
            off = put_down(self._laser, self._line())
        except SensorError:  # there is no other session
            return self._off_anew(self._owns)
        if not off.is_broken:
            return off
        again = self._off_anew(self._owns)
        return again._replace(was_interrupted=off.was_interrupted or again.was_interrupted)

    def _off_anew(self, ends: bool) -> Off:
        """A socket that broke sends nothing more, another may; and another thread has the session and its laser session."""
        laser = LaserSession(self._plan, ends)
        try:
            session = self._plan.open(False)
        except SensorError:
            return Off(*laser.end(ffi.NULL, 0), True, False)
        try:
            return put_down(laser, session)
        finally:
            lib.lum_sensor_close(session)

    def _finish_off(self, off: Off, ends: bool = True) -> Status:
        """What is to be done after laser off. The session stays where another thread uses it."""
        self._laser_is_due = False
        if off.result == lib.LUM_LASER_OFF_SEEN:
            if off.was_interrupted:
                raise KeyboardInterrupt
            return self._status_of(off.news.status)
        if self._owns and ends:
            self._why_closed = "the session has ended, since laser off was not seen to work"
            self._end()
        raise off.news.error()

    def _put_down_after(self, problem: BaseException) -> None:
        """The laser off after something failed. Raises LaserError in its place where that fails too."""
        try:
            self._finish_off(self._try_off())
        except LaserError as worse:
            both = LaserError(f"{problem}; {worse}" if str(problem) else str(worse))
            both.news = worse.news
            raise both from problem

    # Its data.

    def frames(self, duration: Optional[float] = None, *, silence: float = 5.0, **options: Unpack[Options]) -> Frames:
        """The frames that come from now on.

        duration is in seconds from the first data on; None: until the loop ends. silence is how many seconds without
        data are a failure; math.inf: none. The options are those of lumsdk.open(), but for profile, sensor, broken,
        threads and progress, which a session does not take. Calling it again ends the frames before.

        A program that takes longer for a frame than the sensor loses data: the system's buffer holds a fraction of a
        second. losses counts it, and a SensorWarning says so. Other calls of this object can be made between two
        frames; no data is lost by that.

        The laser stays as it is: while it is off, frames have no points. Where this object switched it on and it goes
        down, the frames end: with HazardError in a hazard, else with LaserError, once `laser off` was seen.

        Raises SensorError where no data comes, and OptionError and TypeError for what is not allowed.
        """
        for name, why in (("profile", "the profile is that of the session: lumsdk.Sensor(profile=...)"),
                          ("sensor", "frames are those of this sensor alone"),
                          ("broken", "it is for captures"), ("threads", "it is for captures"),
                          ("progress", "it is for captures")):
            if name in options:
                raise TypeError(f"{name} does not go with frames() of a sensor: {why}")
        wanted = None if duration is None else _seconds("duration", duration, 1e9)
        patience = _seconds("silence", silence, math.inf)
        choice = Choice({**options, "threads": 1})
        calibration, profile = choice.with_set(choice.calibration if choice.names_calibration else self._calibration,
                                               self._profile)
        if profile != self._profile:
            raise OptionError("set has a key of a profile; the profile is that of the session: lumsdk.Sensor(set=...)")
        framer, kept = choice.framer_options(calibration, profile)
        with self._use():
            if not self._owns:
                raise SensorError(f"{self.address}: frames come only to the session that owns the sensor: say "
                                  "lumsdk.Sensor(...) without owns=False")
            before, problem = self._stream(), self._take_problem()
            if before is not None:
                before.close()
            if problem is not None:
                raise problem
            lib.lum_sensor_give_up(self._session)
            stream = Stream(self, wanted, patience, framer)
            self._stream_ref = weakref.ref(stream)
            del kept
        return Frames(self, stream)

    def cancel(self) -> None:
        """End the frames that are read now, as if their duration were over. From any thread, and in a signal handler."""
        lib.lum_cancel_raise(self._cancel)

    # Its settings.

    def _set(self, number: int, name: str, value: Any, unit: str = "") -> Answer:
        spec = lib.lum_command_specs[number]
        steps = f" in steps of {spec.step}" if spec.step > 1 else ""
        right = f"a whole number from {spec.min} to {spec.max}{steps}{unit}"
        whole = _whole(name, value, right)
        out, length = ffi.new("char[]", int(lib.LUM_COMMAND_TEXT_BYTES)), ffi.new("size_t *")
        is_allowed = 0 <= whole <= 65535 and lib.lum_command_format(
            ffi.new("lum_command *", {"id": number, "value": whole}), out, length) == lib.LUM_OK
        if not is_allowed:
            raise OptionError(f"{name}: {value!r} is not {right}")
        return self._change(bytes(ffi.buffer(out, length[0])).decode(), f"{name} {whole}")

    def power(self, percent: int) -> Answer:
        """Set the laser's power, 0 to 100 percent."""
        return self._set(lib.LUM_COMMAND_POWER, "power", percent, " percent")

    def threshold(self, eye: Eye, percent: int) -> Answer:
        """Set an eye's detection threshold, 0 to 100 percent."""
        return self._set(_by_eye("threshold", eye, lib.LUM_COMMAND_THRESHOLD_BLUE, lib.LUM_COMMAND_THRESHOLD_GREEN),
                         f"threshold {eye}", percent, " percent")

    def lines(self, count: Literal[640, 64]) -> Answer:
        """Set the number of lines of a frame: 640 or 64."""
        whole = _whole("lines", count, "640 or 64")
        if whole not in (640, 64):
            raise OptionError(f"lines: {count!r} is not 640 or 64")
        return self._change("0f" if whole == 640 else "1f", f"lines {whole}")

    def yscan(self, degrees: int) -> Answer:
        """Spread the lines evenly over 11 to 30 degrees around the horizon. Other shapes: lumctl yscan."""
        return self._set(lib.LUM_COMMAND_YSCAN, "yscan", degrees, " degrees")

    def holdoff(self, delay: int) -> Answer:
        """Set the holdoff delay, 150 to 250 in steps of 10."""
        return self._set(lib.LUM_COMMAND_HOLDOFF, "holdoff", delay)

    def offset(self, eye: Eye, value: int) -> Answer:
        """Set the offset of an eye's galvo and ADC, 0 to 30."""
        return self._set(_by_eye("offset", eye, lib.LUM_COMMAND_OFFSET_BLUE, lib.LUM_COMMAND_OFFSET_GREEN),
                         f"offset {eye}", value)

    def send(self, commands: str) -> Answer:
        """Send commands as the manual's text, such as "50p 15y". The laser is switched by laser_on() and laser_off()."""
        if not isinstance(commands, str):
            raise TypeError(f"commands are {commands!r}; right is a text such as \"50p 15y\"")
        _check_commands(commands)
        return self._change(commands, commands)

    def tlv(self, *tlvs: tuple[int, bytes]) -> Answer:
        """Send any TLVs in one packet, each as type and value; none: a status poll. The answer is not judged."""
        writer, packet = ffi.new("lum_tlv_writer *"), ffi.new("uint8_t[]", int(lib.LUM_SENSOR_REQUEST_BYTES))
        if lib.lum_tlv_begin(writer, packet, len(packet), 0) != lib.LUM_OK:
            raise OptionError("no TLV fits")
        command = self._plan.layout.profile.tlv[lib.LUM_TLV_COMMAND]
        letter, switches_on = lib.lum_command_specs[lib.LUM_COMMAND_LASER_ON].letter, False
        for pair in tlvs:
            kind, value = _tlv(pair)
            if lib.lum_tlv_add(writer, kind, value, len(value)) != lib.LUM_OK:
                raise OptionError(f"the TLVs do not fit a packet, which holds {lib.LUM_SENSOR_REQUEST_BYTES} bytes in all")
            switches_on = switches_on or (kind == command and letter in value)
        head = int(lib.LUM_TLV_PACKET_BYTES)
        with self._use():
            if switches_on:
                self._laser_is_due = True
                self._laser.want(lib.LUM_WANT_GUARD)
            return self._answer_of(self._request(
                lambda line: int(lib.lum_sensor_request(line, packet + head, writer.len - head))))


# --- Values ---


def _whole(name: str, value: Any, right: str) -> int:
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name}: {value!r} is not {right}")
    return operator.index(value)


def _by_eye(name: str, eye: Any, blue: int, green: int) -> int:
    if eye not in ("blue", "green"):
        raise OptionError(f'{name}: {eye!r} is not an eye: "blue" or "green"')
    return int(blue if eye == "blue" else green)


def _seconds(name: str, value: Any, most: float) -> float:
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise TypeError(f"{name} is {value!r}, of type {type(value).__name__}; right is a number of seconds, such as 5")
    if not 0 < float(value) <= most:
        raise OptionError(f"{name} is {value!r}; right is a number of seconds above 0, such as 5")
    return float(value)


def _tlv(pair: Any) -> tuple[int, bytes]:
    right = 'a TLV is a pair of a type from 0 to 65535 and bytes, such as (1, b"50p")'
    if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not isinstance(pair[1], (bytes, bytearray, memoryview)):
        raise TypeError(f"{pair!r}: {right}")
    kind = _whole("tlv", pair[0], "a type from 0 to 65535")
    if not 0 <= kind <= 65535:
        raise OptionError(f"{pair!r}: {right}")
    return kind, bytes(pair[1])


def _check_commands(commands: str) -> None:
    raw = ffi.new("char[]", commands.encode())
    at, left = ffi.new("const char **", raw), ffi.new("size_t *", len(raw) - 1)
    command = ffi.new("lum_command *")
    if not commands or len(raw) - 1 > 1000:
        raise OptionError(f"{commands[:20]!r}: give commands of the manual, such as '50p 15y'")
    while left[0]:
        word = text(at[0]).split(" ")[0]
        result = lib.lum_command_parse(at, left, command)
        if result == lib.LUM_E_VALUE:
            spec = next(s for s in lib.lum_command_specs if s.letter == word[-1:].encode())
            raise OptionError(f"{word!r}: right is {spec.min} to {spec.max}"
                              f"{f' in steps of {spec.step}' if spec.step > 1 else ''}")
        if result != lib.LUM_OK:
            raise OptionError(f"{commands!r}: {word!r} is not a command: a whole number and one of p g b f y h G B, "
                              "separated by one space")
        if command.id in (lib.LUM_COMMAND_LASER_ON, lib.LUM_COMMAND_LASER_OFF):
            raise OptionError(f"{commands!r}: the laser is switched by laser_on() and laser_off(), which see what it does")
