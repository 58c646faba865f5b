"""A session with a sensor in C: how it is opened, how requests and their answers go, how the laser goes off."""
from __future__ import annotations

import contextlib
import dataclasses
import ipaddress
import re
import threading
import time
from typing import Any, NamedTuple, Optional

from ._c import address_of, failure, ffi, lib, sized, text
from ._errors import HazardError, LaserError, OptionError, SensorError, SensorWarning, warn

SLICE_NS = 50_000_000
"""Longest wait in C, so that Ctrl-C is taken soon."""

RECEIVE_BUFFER = int(lib.LUM_SOCKET_RECEIVE_BUFFER)
"""Bytes of data that the system is asked to keep for a session."""

_OFF_SLICE_MS = 200
_OFF_ALONE_S = lib.LUM_HEARTBEAT_TIMEOUT_MS / 1000
_HAZARDS = int(lib.LUM_LASER_HAZARDS)
_TIMEOUT_BIT = int(lib.LUM_LASER_HEARTBEAT_TIMEOUT)


def now_ns() -> int:
    """The time of sessions."""
    return int(lib.lum_time_monotonic_ns())


# --- What a sensor says ---


@dataclasses.dataclass(frozen=True)
class Status:
    """The laser's status, as `lumctl status` tells it."""

    value: int
    """All 16 bits."""
    laser_on: bool
    """Whether it shows the laser up, by TLV_CMD_ON."""
    bits: tuple[str, ...]
    """The names of all bits that are set."""
    hazards: tuple[str, ...]
    """Those of them that are hazards, each of which keeps the laser down; none while the sensor is idle."""
    idle: bool
    """Whether nobody has the session: HEARTBEAT_TIMEOUT is set, and it is no hazard then."""

    @property
    def laser_down(self) -> bool:
        """Whether it shows the laser down. Where it shows it neither down nor on, as 0 does, the laser may be on."""
        return bool(lib.lum_laser_is_down(self.value))

    def __str__(self) -> str:
        named = f": {', '.join(self.bits) or 'no bit set'}"
        return f"laser {text(lib.lum_laser_status_name(self.value))}{', idle' if self.idle else ''}{named}"


@dataclasses.dataclass(frozen=True)
class Answer:
    """What a sensor answered to a request."""

    status: Optional[Status]
    """The laser's status; None: the answer has none."""
    debug: tuple[str, ...]
    """Texts of the sensor."""
    tlvs: tuple[tuple[int, bytes], ...]
    """All other TLVs: type and value."""
    tries: int
    """How often the request was sent."""
    round_trip: Optional[float]
    """Seconds until the answer; None: it was sent more than once, so that this is not known."""


@dataclasses.dataclass(frozen=True)
class Clock:
    """The sensor's clock against this host's, as `lumctl time` tells it."""

    clock_us: int
    """The last reading in microseconds, beyond the wrap of its 32 bits."""
    offset_ns: int
    """When it was 0, in nanoseconds since 1970 UTC by this host's clock."""
    error_ns: int
    """The bound of the offset's error."""
    round_trip: float
    """Seconds that the last exchange took."""
    drift_ppb: Optional[int]
    """By how many billionths this host's clock runs faster; None: not known until later calls."""
    drift_error_ppb: Optional[int]
    """The bound of the drift's error."""
    exchanges: int
    """How many exchanges it is made of."""
    resets: int
    """How often the sensor's clock began anew."""


def names_of(bits: int) -> tuple[str, ...]:
    """The names of bits of a status."""
    return tuple(text(lib.lum_laser_bit_name(i)) for i in range(int(lib.LUM_LASER_BITS)) if bits >> i & 1)


def hazards_of(value: int) -> int:
    """The hazards that are more than missing heartbeats."""
    return value & _HAZARDS & ~_TIMEOUT_BIT


def status_of(value: int, is_owned: bool) -> Status:
    """A status by its bits."""
    idle = value & _HAZARDS == _TIMEOUT_BIT and not is_owned
    is_on = text(lib.lum_laser_status_name(value)) == "up"
    return Status(value, is_on, names_of(value), () if idle else names_of(value & _HAZARDS), idle)


def lacks_heartbeats(value: int) -> bool:
    """Whether missing heartbeats are the only hazard."""
    return value & _HAZARDS == _TIMEOUT_BIT


def tlvs_of(reader: Any) -> list[tuple[int, bytes]]:
    """The TLVs of an event: type and value."""
    at, tlv, found = ffi.new("lum_tlv_reader *", reader), ffi.new("lum_tlv *"), []
    while lib.lum_tlv_next(at, tlv) == lib.LUM_OK:
        found.append((int(tlv.type), bytes(ffi.buffer(tlv.value, tlv.length)) if tlv.length else b""))
    return found


def printable(value: bytes) -> str:
    """A text of the sensor, without what would disturb a terminal."""
    return "".join(c if c.isprintable() else "?" for c in value.decode("latin-1"))


# --- Where it is ---

_SENSOR_URL = "udp://"


def _look_up(host: str, out: Any, error: Any) -> int:
    """An address of a name. The system's resolver may wait long, and not for Ctrl-C: it has a thread of its own."""
    if re.fullmatch(r"[0-9.:]*", host):
        return int(lib.lum_resolve(host.encode(), out, error))
    results: list[int] = []
    thread = threading.Thread(target=lambda: results.append(lib.lum_resolve(host.encode(), out, error)), daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(0.05)
    return results[0]


def parse_host(given: Any) -> tuple[int, int]:
    """Address and port of HOST, HOST:PORT, or either with udp:// before it."""
    right = 'right is HOST or HOST:PORT, such as "10.42.0.37"'
    if isinstance(given, ipaddress.IPv4Address):
        given = str(given)
    if not isinstance(given, str):
        raise TypeError(f"the host is {given!r}, of type {type(given).__name__}; {right}")
    host = given[len(_SENSOR_URL):] if given.startswith(_SENSOR_URL) else given
    port = int(lib.LUM_PORT)
    if not host or (host[0] == ":" and host[1:2] != ":"):
        raise OptionError(f"{given!r}: there is no host in it; {right}")
    if "/" in host or "\0" in host:
        raise OptionError(f"{given!r}: nothing stands behind the host and its port; {right}")
    if host.count(":") == 1:
        host, number = host.split(":")
        if not re.fullmatch(r"\d{1,5}", number) or not 1 <= int(number) <= 65535:
            raise OptionError(f"{given!r}: the port is not a number from 1 to 65535; {right}")
        port = int(number)
    out, error = ffi.new("uint32_t *"), ffi.new("lum_error *")
    if _look_up(host, out, error) != 0:
        raise SensorError(text(error.text))
    if not lib.lum_address_is_host(out[0]) or out[0] >> 24 == 0 or out[0] >> 28 >= 14:
        raise OptionError(f"{given!r}: no sensor can have this address; {right}")
    return int(out[0]), port


def show(endpoint: Any) -> str:
    """An address, with its port where it is not the usual one."""
    name = address_of(endpoint.address)
    return name if endpoint.port == lib.LUM_PORT else f"{name}:{endpoint.port}"


# --- The session ---


class Plan:
    """How sessions with one sensor are opened."""

    def __init__(self, host: Any, interface: Optional[str], profile: Any, timeout: float, retries: int) -> None:
        if interface is not None and not isinstance(interface, str):
            raise TypeError(f"interface is {interface!r}; right is the name of one, such as \"eth0\"")
        self.address, self.port = parse_host(host)
        self.interface = ffi.NULL if interface is None else ffi.new("char[]", interface.encode())
        self.layout = ffi.new("lum_layout *")
        if lib.lum_layout_init(self.layout, profile._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK:
            raise OptionError("the profile is out of range")
        self.timeout_ms, self.retries = _timeout(timeout), _retries(retries)

    def options(self, owns: bool, cancel: Any = ffi.NULL) -> Any:
        """Of a session in C; its waits end with the cancel. One that owns the sensor sends heartbeats and gets data."""
        options = sized("lum_sensor_options", interface_name=self.interface, owns=owns, timeout_ms=self.timeout_ms,
                        heartbeat_ms=lib.LUM_HEARTBEAT_MS, retries=self.retries,
                        receive_buffer=RECEIVE_BUFFER, cancel=cancel)
        options.sensor.address, options.sensor.port = self.address, self.port
        options.layout = self.layout[0]
        return options

    def open(self, owns: bool, cancel: Any = ffi.NULL) -> Any:
        """The session."""
        out, error = ffi.new("lum_sensor **"), ffi.new("lum_error *")
        if lib.lum_sensor_open(self.options(owns, cancel), out, error) != lib.LUM_NET_OK:
            raise failure(error, SensorError)
        return out[0]

    def news(self, kind: int, said: str = "") -> News:
        """What is to be said of the sensor, where no laser session has found it."""
        c = sized("lum_news", kind=kind, interface_name=self.interface, text=said.encode()[:int(lib.LUM_NEWS_TEXT_BYTES) - 1],
                  tlv_status=self.layout.profile.tlv[lib.LUM_TLV_STATUS])
        c.sensor.address, c.sensor.port = self.address, self.port
        return News(c)


def new_cancel() -> Any:
    """What ends waits from outside."""
    out, error = ffi.new("lum_cancel **"), ffi.new("lum_error *")
    if lib.lum_cancel_new(out, error) != 0:
        raise failure(error, SensorError)
    return ffi.gc(out[0], lib.lum_cancel_free)


def _timeout(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"timeout is {value!r}; right is a number of seconds, such as 0.4")
    if not 0.001 <= value <= 60:
        raise OptionError(f"timeout is {value!r}; right is 0.001 to 60 seconds")
    return round(value * 1000)


def _retries(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"retries is {value!r}; right is a whole number, such as 4")
    if not 0 <= value <= 100:
        raise OptionError(f"retries is {value!r}; right is 0 to 100")
    return value


class Event:
    """An event of a session, copied: nothing in it ends with the next one."""

    def __init__(self, c: Any) -> None:
        self.kind = int(c.kind)
        self.status = int(c.status) if c.has_status else None
        self.tries = int(c.tries)
        self.sent_ns, self.received_ns, self.clock_us = int(c.sent_ns), int(c.received_ns), int(c.clock_us)
        has_tlvs = self.kind in (lib.LUM_SENSOR_ANSWER, lib.LUM_SENSOR_ALERT)
        self.tlvs = tlvs_of(c.tlvs) if has_tlvs else []
        self.error = text(c.error.text) if self.kind == lib.LUM_SENSOR_FAILED else ""


def receive(session: Any, laser: Optional[LaserSession] = None) -> Event:
    """Do all that is due and wait for one event, but not for long. The laser session of the session gets it too."""
    c = ffi.new("lum_sensor_event *")
    lib.lum_sensor_receive(session, now_ns() + SLICE_NS, c)
    if laser is not None:
        lib.lum_laser_session_take(laser.c, c, now_ns())
    return Event(c)


# --- Its laser session ---

# What a program does about news, where the table tells a person at a terminal what to run.
_REMEDIES = dict.fromkeys(("laser-fell", "laser-refused", "laser-held-up"),
                          "it is not switched on again automatically: when it is safe, call laser_on(); heartbeats are sent "
                          "only inside calls") | {"unknown-layout": "is a profile needed?"}

# What there is to say where data does not come.
MISSING = ("no-answer-yet", "no-data-yet", "unknown-layout", "silent", "data-stopped", "link-down", "moved")


class News:
    """News of a laser session, as lum_news_tell() has it."""

    def __init__(self, c: Any) -> None:
        self.name = text(lib.lum_news_name(c.kind)) if c.kind else ""
        self.weight = int(lib.lum_news_weigh(c.kind))
        self.status = int(c.status)
        out = ffi.new("char[]", int(lib.LUM_ERROR_BYTES))
        self.told = text(lib.lum_news_sentence(c, out, len(out)))
        remedy = _REMEDIES.get(self.name) or text(lib.lum_news_remedy(c, out, len(out)))
        self.told += f"; {remedy}" if remedy else ""

    def error(self, also: str = "") -> SensorError:
        """It, where it ends the work."""
        is_of_laser = self.name.startswith(("laser-", "off-", "ended-"))
        kind = LaserError if is_of_laser and self.name not in ("laser-unanswered", "laser-held-up") else SensorError
        if self.name in ("laser-fell", "laser-refused") and hazards_of(self.status):
            kind = HazardError
        error = kind(self.told + also)
        error.news = self.name
        return error

    def warning(self) -> SensorWarning:
        """It, where the work goes on."""
        warning = SensorWarning(self.told)
        warning.news = self.name
        return warning


class LaserSession:
    """What keeps a sensor and its laser, in C (lum/live/laser_session.h): it alone has the rules for both."""

    def __init__(self, plan: Plan, owns: bool) -> None:
        options, out, error = ffi.new("lum_laser_session_options *"), ffi.new("lum_laser_session **"), ffi.new("lum_error *")
        lib.lum_laser_session_options_default(options, plan.options(owns))
        if lib.lum_laser_session_new(options, now_ns(), out, error) != 0:
            raise failure(error, SensorError)
        self.c = ffi.gc(out[0], lib.lum_laser_session_free)
        self._view, self._news = sized("lum_laser_session_view"), sized("lum_news")

    def want(self, want: int) -> None:
        """Of the laser."""
        lib.lum_laser_session_want(self.c, want, now_ns())

    def look(self) -> Any:
        """What it knows, until the next look."""
        lib.lum_laser_session_look(self.c, self._view)
        return self._view

    def news(self) -> list[News]:
        """What has happened."""
        found = []
        while lib.lum_laser_session_next(self.c, self._news):
            found.append(News(self._news))
        return found

    def missing(self, since_ns: int) -> News:
        """Why no data came since then, also where a sensor may be silent for longer."""
        found, now = sized("lum_news"), now_ns()
        for at in (now, now + int(lib.LUM_SENSOR_SILENCE_MS) * 1_000_000):
            if lib.lum_laser_session_standing(self.c, at, found, 1) and News(found).name in MISSING:
                break
        found.ns = now - since_ns
        return News(found)

    def end(self, session: Any, ms: int, goes_on_ms: int = 0) -> tuple[int, News]:
        """Switch the laser off, as lum_laser_session_end(). Earlier news is lost."""
        result = int(lib.lum_laser_session_end(self.c, session, ms, goes_on_ms, ffi.NULL))
        return result, self.news()[-1]


class Off(NamedTuple):
    """How an attempt to switch the laser off ended."""

    result: int
    """One of lum_laser_off."""
    news: News
    """What to say."""
    is_broken: bool
    """The session sends nothing any more; another one may."""
    was_interrupted: bool
    """Ctrl-C came meanwhile."""


def put_down(laser: LaserSession, session: Any, seconds: float = lib.LUM_SENSOR_OFF_MS / 1000) -> Off:
    """Switch the laser off and see that it is down. In the first three seconds nothing ends it; after that a sensor
    that gets no heartbeats is down by itself, and Ctrl-C ends it."""
    begin, is_told, was_interrupted = time.monotonic(), False, False
    while True:
        try:
            before = time.monotonic()
            is_alone = before - begin >= _OFF_ALONE_S
            slice_ms = _OFF_SLICE_MS if is_alone else round(1000 * min(_OFF_ALONE_S, seconds))
            rest = seconds - (before - begin) - slice_ms / 1000
            is_last = rest <= 0 or (is_alone and was_interrupted)
            result, news = laser.end(session, slice_ms, 0 if is_last else 1000 * max(1, round(rest)))
            if is_last or result in (lib.LUM_LASER_OFF_SEEN, lib.LUM_LASER_OFF_UNSEEN):
                return Off(result, news, False, was_interrupted)
            if time.monotonic() - before < _OFF_SLICE_MS / 2000:
                return Off(*laser.end(ffi.NULL, 0), True, was_interrupted)
            if is_alone and not is_told:
                is_told = True
                news.told += "; Ctrl-C gives up"
                with contextlib.suppress(SensorWarning):  # where warnings are errors, this one comes first
                    warn(news.warning())
        except KeyboardInterrupt:
            was_interrupted = True
