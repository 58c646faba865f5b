"""A session with a sensor in C: where the sensor is, how the session is opened, what comes over it."""
from __future__ import annotations

import dataclasses
import ipaddress
import re
import threading
from typing import TYPE_CHECKING, Any, Optional

from ._c import address_of, check, ffi, lib, sized, text
from ._errors import OptionError, SensorError

if TYPE_CHECKING:
    from ._laser import LaserSession

SLICE_NS = 50_000_000
"""Longest wait in C, so that Ctrl-C is taken soon."""

RECEIVE_BUFFER = int(lib.LUM_SOCKET_RECEIVE_BUFFER)
"""Bytes of data that the system is asked to keep for a session."""

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
    """Seconds until the answer; None: it was sent more than once, so this is unknown."""


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
    """How often the sensor's clock restarted."""


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
    right = 'use HOST or HOST:PORT, such as "10.42.0.37"'
    if isinstance(given, ipaddress.IPv4Address):
        given = str(given)
    if not isinstance(given, str):
        raise TypeError(f"the host is {given!r}, of type {type(given).__name__}; {right}")
    host = given[len(_SENSOR_URL):] if given.startswith(_SENSOR_URL) else given
    port = int(lib.LUM_PORT)
    if not host or (host[0] == ":" and host[1:2] != ":"):
        raise OptionError(f"{given!r}: the host is missing; {right}")
    if "/" in host or "\0" in host:
        raise OptionError(f"{given!r}: nothing may follow the host and its port; {right}")
    if host.count(":") == 1:
        host, number = host.split(":")
        if not re.fullmatch(r"\d{1,5}", number) or not 1 <= int(number) <= 65535:
            raise OptionError(f"{given!r}: the port is not a number from 1 to 65535; {right}")
        port = int(number)
    out, error = ffi.new("uint32_t *"), ffi.new("lum_error *")
    check(_look_up(host, out, error), error, SensorError)
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
            raise TypeError(f"interface is {interface!r}; use the name of one, such as \"eth0\"")
        self.address, self.port = parse_host(host)
        self.interface = ffi.NULL if interface is None else ffi.new("char[]", interface.encode())
        self.layout = ffi.new("lum_layout *")
        if lib.lum_layout_init(self.layout, profile._to_c(), ffi.NULL, ffi.NULL) != lib.LUM_OK:
            raise OptionError("the profile is out of range")
        seconds = _number("timeout", timeout, (int, float), "a number of seconds, such as 0.4", (0.001, 60), " seconds")
        self.timeout_ms = round(seconds * 1000)
        self.retries: int = _number("retries", retries, (int,), "a whole number, such as 4", (0, 100))

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
        check(lib.lum_sensor_open(self.options(owns, cancel), out, error), error, SensorError)
        return out[0]


def new_cancel() -> Any:
    """What ends waits from outside."""
    out, error = ffi.new("lum_cancel **"), ffi.new("lum_error *")
    check(lib.lum_cancel_new(out, error), error, SensorError)
    return ffi.gc(out[0], lib.lum_cancel_free)


def _number(name: str, value: Any, kinds: Any, right: str, bounds: tuple[float, int], unit: str = "") -> Any:
    if isinstance(value, bool) or not isinstance(value, kinds):
        raise TypeError(f"{name} is {value!r}; use {right}")
    if not bounds[0] <= value <= bounds[1]:
        raise OptionError(f"{name} is {value!r}; use {bounds[0]} to {bounds[1]}{unit}")
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
