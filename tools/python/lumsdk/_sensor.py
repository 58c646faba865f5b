"""A live sensor, as a program has it: the methods of lumsdk.Sensor."""
from __future__ import annotations

import atexit
import collections
import math
import os
import warnings
import weakref
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

from ._c import ffi, lib
from ._commands import Requests, by_eye, check_commands, whole
from ._connection import Connection
from ._errors import OptionError, SensorError, SensorWarning, warn
from ._laser import LaserControl, LaserSession, news_of
from ._options import Choice
from ._session import Answer, Clock, Plan, Status
from ._settings import Calibration, Profile, setting_of
from ._stream import Frames, Stream, losses_of

if TYPE_CHECKING:
    from ipaddress import IPv4Address

    from typing_extensions import Literal, Unpack

    from ._types import Eye, LiveOptions


_EXCHANGES = 8
_APART_S = 0.01

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
        sensor._connection.leave()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


# --- The laser, for a block ---


class Laser:
    """The laser on for a block; made by Sensor.laser()."""

    def __init__(self, sensor: Sensor) -> None:
        self._sensor = sensor

    def __enter__(self) -> Status:
        return self._sensor.laser_on()

    def __exit__(self, *_: object) -> None:
        # What ended the session in the block has switched the laser off, or has said that it could not.
        if self._sensor._connection.session:
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
    waits or works on something else for 3 s, loses the laser. This is for safety: no thread keeps
    the laser on without the program.

    The laser goes off at the end of the block of laser() or of this object, by close(), when the object is collected,
    and at the end of the interpreter, each time only if this object switched it on. A process that is killed
    sends nothing any more, so the sensor switches the laser off after 3 s; likewise after a SIGTERM that the
    program does not handle.

    One program of a host can own a sensor at a time. With owns=False it only queries and sets, like lumctl, beside a
    program that owns the sensor.

    Only one thread at a time may use it; a call during another one raises SensorError, except laser_off()
    and cancel(). Several sensors can be used in several threads. A process that was forked cannot use it.
    """

    def __init__(self, host: Union[str, IPv4Address] = "10.42.0.37", *, interface: Optional[str] = None,
                 calibration: Union[str, os.PathLike[str], Mapping[str, Any], Calibration, None] = None,
                 profile: Union[str, os.PathLike[str], Mapping[str, Any], Profile, None] = None,
                 set: Union[Mapping[str, Any], Iterable[str], None] = None, owns: bool = True, timeout: float = 0.4,
                 retries: int = 4) -> None:
        """Begin a session. Nothing is sent yet, so whether there is a sensor is still unknown.

        host is an address or a name, alone or with a port: "10.42.0.37", "lidar.local", "10.42.0.37:5517"; udp:// may
        stand before it, as for lumdump. interface is the name of one, such as "eth0". calibration, profile and set
        are as for lumsdk.open(). timeout is in seconds for each try of a request, retries the number of further tries.

        Raises SensorError where the host is not known, another program owns the sensor, or the network refuses;
        OptionError and TypeError for what is not allowed.
        """
        self._sync: Any = None
        self._calibration = calibration if isinstance(calibration, Calibration) else Calibration(calibration)
        self._profile = profile if isinstance(profile, Profile) else Profile(profile)
        if set is not None:
            self._calibration, self._profile = setting_of(self._calibration, self._profile, set)
        if not isinstance(owns, bool):
            raise TypeError(f"owns is {owns!r}; use True or False")
        plan = Plan(host, interface, self._profile, timeout, retries)
        laser = LaserSession(plan, owns)
        self._connection = Connection(plan, owns)
        self._laser = LaserControl(self._connection, laser)
        self._requests = Requests(self._connection, self._laser)
        self.address = self._connection.address
        """Where the sensor is, with its port where that is not 5517."""
        _open.add(self)

    # Its life.

    def close(self) -> None:
        """Switch the laser off if this object switched it on, and end the session. Frames stay valid.

        Raises LaserError where the laser was not confirmed off; the session has still ended.
        """
        if not self._connection.session:
            return
        if self._connection.lock.locked() and self._laser.was_switched_on:
            self._laser.off()
        with self._connection.use(closed_is_fine=True):
            try:
                if self._laser.was_switched_on:
                    self._laser.off_now()
            finally:
                self._connection.end()

    def __enter__(self) -> Sensor:
        self._connection.check()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        connection = getattr(self, "_connection", None)
        if connection is None or not connection.session or connection.is_of_parent():
            return
        warnings.warn(f"{self!r} was not closed; use 'with' or call close()", ResourceWarning, stacklevel=1, source=self)
        warning = self._laser.off_at_collection() if self._laser.was_switched_on else None
        if warning is not None:
            warnings.warn(warning, stacklevel=1)
        connection.end()

    def __repr__(self) -> str:
        is_up = self._laser.session.look().laser == lib.LUM_LASER_UP
        laser = "" if not self._laser.was_switched_on else ", laser on" if is_up else ", laser switched on"
        owner = "" if self._connection.owns else ", not its owner"
        return f"<Sensor {self.address}{laser if self._connection.session else ', closed'}{owner}>"

    # What it tells.

    def status(self) -> Status:
        """The laser's status. Raises SensorError if no answer comes."""
        with self._connection.use():
            event = self._requests.ask(lambda session: int(lib.lum_sensor_request(session, ffi.NULL, 0)))
        answer = self._requests.answer_of(event)
        for said in answer.debug:
            warn(news_of(self._connection.plan, lib.LUM_NEWS_TEXT, said).warning())
        if answer.status is None:
            raise news_of(self._connection.plan, lib.LUM_NEWS_NO_STATUS).error()
        return answer.status

    def time(self) -> Clock:
        """The sensor's clock against this host's, by eight exchanges. The drift becomes known with later calls."""
        with self._connection.use():
            if self._sync is None:
                self._sync = ffi.new("lum_clock_sync *")
                lib.lum_clock_sync_init(self._sync)
            trip = 0
            for i in range(_EXCHANGES):
                if i:
                    self._requests.rest(_APART_S)
                event = self._requests.ask(lambda session: int(lib.lum_sensor_request_time(session)))
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

    @property
    def counters(self) -> dict[str, int]:
        """What the session counted since it began: datagrams, heartbeats, requests and so on."""
        with self._connection.use(closed_is_fine=True):
            return self._connection.count()

    @property
    def losses(self) -> dict[str, int]:
        """What is missing so far in all of its frames, by cause, with lumdump's names.

        kernel_drops are datagrams that this host dropped because the program was too slow to read them.
        """
        with self._connection.use(closed_is_fine=True):
            stream, total = self._connection.stream(), collections.Counter(self._connection.past_losses)
            total.update(losses_of(stream.reader) if stream is not None else {})
            return {"kernel_drops": self._connection.count().get("kernel_drops", 0), **total}

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
        """Switch the laser on, and check that it is up. Returns its status.

        Keep people's eyes away from the beam. It is not switched on again by itself after it went down. Full strength
        takes several seconds.

        Raises HazardError where a hazard keeps it down, LaserError where it does not come up for another reason,
        SensorError where no answer comes for 5 s. In each case `laser off` was sent and confirmed, so that it does
        not come up later.
        """
        with self._connection.use():
            return self._laser.on()

    def laser_off(self) -> Status:
        """Switch the laser off, and check that it is down. Returns its status.

        It is repeated for ten seconds; after three of them, Ctrl-C ends it. It also works while another thread uses
        the session. Raises LaserError where nothing showed that it is off: then this session has ended, since its
        heartbeats would keep the laser on.
        """
        self._connection.check()
        return self._laser.off()

    # Its data.

    def frames(self, duration: Optional[float] = None, *, silence: float = 5.0, **options: Unpack[LiveOptions]) -> Frames:
        """The frames that come from now on.

        duration is in seconds from the first data on; None: until the loop ends. silence is how many seconds without
        data are a failure; math.inf: none. The options are those of lumsdk.open(), except profile, sensor, broken,
        threads and progress, which a session does not take. Calling it again ends the frames before.

        A program that takes longer for a frame than the sensor loses data: the system's buffer holds a fraction of a
        second. losses counts it, and a SensorWarning says so. Other calls of this object can be made between
        two frames without losing data.

        The laser stays as it is: while it is off, frames have no points. Where this object switched it on and it goes
        down, the frames end: with HazardError in a hazard, else with LaserError, once `laser off` was confirmed.

        Raises SensorError where no data comes, and OptionError and TypeError for what is not allowed.
        """
        for name, why in (("profile", "the profile is that of the session: lumsdk.Sensor(profile=...)"),
                          ("sensor", "frames are those of this sensor alone"),
                          ("rig", "give lumsdk.Sensor() the calibration and profile of rig[name], and move xyz by rig[name].pose"),
                          ("broken", "it is for captures"), ("threads", "it is for captures"), ("raw", "it is for captures"),
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
        connection = self._connection
        with connection.use():
            if not connection.owns:
                raise SensorError(f"{self.address}: frames come only to the session that owns the sensor: use "
                                  "lumsdk.Sensor(...) without owns=False")
            before, problem = connection.stream(), self._laser.take_problem()
            if before is not None:
                before.close()
            if problem is not None:
                raise problem
            lib.lum_sensor_give_up(connection.session)
            stream = Stream(connection, self._laser, wanted, patience, framer)
            connection.stream_ref = weakref.ref(stream)
            del kept
        return Frames(self, stream)

    def cancel(self) -> None:
        """End the frames that are read now, as if their duration were over. From any thread, and in a signal handler."""
        lib.lum_cancel_raise(self._connection.cancel)

    # Its settings.

    def power(self, percent: int) -> Answer:
        """Set the laser's power, 0 to 100 percent."""
        return self._requests.set(lib.LUM_COMMAND_POWER, "power", percent, " percent")

    def threshold(self, eye: Eye, percent: int) -> Answer:
        """Set an eye's detection threshold, 0 to 100 percent."""
        return self._requests.set(by_eye("threshold", eye, lib.LUM_COMMAND_THRESHOLD_BLUE, lib.LUM_COMMAND_THRESHOLD_GREEN),
                                  f"threshold {eye}", percent, " percent")

    def lines(self, count: Literal[640, 64]) -> Answer:
        """Set the number of lines of a frame: 640 or 64."""
        number = whole("lines", count, "640 or 64")
        if number not in (640, 64):
            raise OptionError(f"lines: {count!r} is not 640 or 64")
        return self._requests.change("0f" if number == 640 else "1f", f"lines {number}")

    def yscan(self, degrees: int) -> Answer:
        """Spread the lines evenly over 11 to 30 degrees around the horizon. Other shapes: lumctl yscan."""
        return self._requests.set(lib.LUM_COMMAND_YSCAN, "yscan", degrees, " degrees")

    def holdoff(self, delay: int) -> Answer:
        """Set the holdoff delay, 150 to 250 in steps of 10."""
        return self._requests.set(lib.LUM_COMMAND_HOLDOFF, "holdoff", delay)

    def offset(self, eye: Eye, value: int) -> Answer:
        """Set the offset of an eye's galvo and ADC, 0 to 30."""
        return self._requests.set(by_eye("offset", eye, lib.LUM_COMMAND_OFFSET_BLUE, lib.LUM_COMMAND_OFFSET_GREEN),
                                  f"offset {eye}", value)

    def send(self, commands: str) -> Answer:
        """Send commands as the manual's text, such as "50p 15y". The laser is switched by laser_on() and laser_off()."""
        if not isinstance(commands, str):
            raise TypeError(f"commands are {commands!r}; use a text such as \"50p 15y\"")
        check_commands(commands)
        return self._requests.change(commands, commands)

    def tlv(self, *tlvs: tuple[int, bytes]) -> Answer:
        """Send any TLVs in one packet, each as type and value; none: a status poll. The answer is not judged."""
        return self._requests.tlvs(tlvs)


# --- Values ---


def _seconds(name: str, value: Any, most: float) -> float:
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise TypeError(f"{name} is {value!r}, of type {type(value).__name__}; use a number of seconds, such as 5")
    if not 0 < float(value) <= most:
        raise OptionError(f"{name} is {value!r}; use a number of seconds above 0, such as 5")
    return float(value)
