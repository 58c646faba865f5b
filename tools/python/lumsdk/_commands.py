"""Commands to a live sensor: values and texts are checked, a request goes out, and its answer is waited for and judged."""
from __future__ import annotations

import operator
import re
import time
from collections.abc import Callable, Iterable
from typing import Any, Optional

from ._c import ffi, lib, text
from ._connection import Connection
from ._errors import OptionError, SensorError
from ._laser import LaserControl, news_of
from ._session import Answer, Event, now_ns, printable

_PUMP_S = 0.2


# --- Requests and answers ---


class Requests:
    """Requests over a connection, one at a time."""

    def __init__(self, connection: Connection, laser: LaserControl) -> None:
        self._connection, self._laser = connection, laser
        self._plan = connection.plan

    def ask(self, begin: Callable[[Any], int]) -> Event:
        """A request and its answer."""
        session = self._connection.command_session()
        lib.lum_sensor_give_up(session)
        if begin(session) != lib.LUM_OK:
            raise OptionError(f"the request does not fit one packet of {lib.LUM_SENSOR_REQUEST_BYTES} bytes")
        if session == self._connection.session:
            lib.lum_laser_session_lend(self._laser.session.c, now_ns())
        try:
            event = self._wait(session)
        except BaseException:
            lib.lum_sensor_give_up(session)
            raise
        if event.status is not None and self._laser.off_if_due():
            event.status = int(self._laser.session.look().status)
        self._laser.give_warnings()
        return event

    def _wait(self, session: Any) -> Event:
        read, was_due = time.monotonic(), bool(self._laser.session.look().is_off_due)
        while True:
            if not was_due and self._laser.off_if_due():  # whose answer would be taken for the request's
                raise SensorError(f"{self._connection.address}: laser off comes first: whether the sensor got the request is "
                                  "not known")
            before = time.monotonic()
            event, stream = self._laser.step(session, serves=not was_due), self._connection.stream()
            if event.kind in (lib.LUM_SENSOR_ANSWER, lib.LUM_SENSOR_TIME):
                return event
            if event.kind == lib.LUM_SENSOR_NO_ANSWER:
                raise self._no_answer(event.tries, time.monotonic() - before)
            if stream is not None and time.monotonic() - read >= _PUMP_S:  # heartbeats and data go on
                stream.read()
                read = time.monotonic()

    def _no_answer(self, tries: int, seconds: float) -> SensorError:
        if seconds >= lib.LUM_SENSOR_STALE_MS / 1000:
            return SensorError(f"{self._connection.address}: this program was held up for {seconds:.1f} s during a request; "
                               "whether the sensor got it is not known")
        times, each = ("time", "") if tries == 1 else ("times", " each")
        return news_of(self._plan, lib.LUM_NEWS_NO_ANSWER).error(f" (tried {tries} {times}, {self._plan.timeout_ms} ms{each})")

    def rest(self, seconds: float) -> None:
        """Pause, with heartbeats."""
        end, session = time.monotonic() + seconds, self._connection.command_session()
        while time.monotonic() < end:
            self._laser.step(session)

    def answer_of(self, event: Event) -> Answer:
        """An answer, as a program gets it."""
        numbers = self._plan.layout.profile.tlv
        debug = tuple(printable(value) for kind, value in event.tlvs if kind == numbers[lib.LUM_TLV_DEBUG])
        known = (numbers[lib.LUM_TLV_DEBUG], numbers[lib.LUM_TLV_STATUS])
        return Answer(None if event.status is None else self._connection.status_of(event.status), debug,
                      tuple(pair for pair in event.tlvs if pair[0] not in known), event.tries,
                      (event.received_ns - event.sent_ns) * 1e-9 if event.tries == 1 else None)

    def set(self, number: int, name: str, value: Any, unit: str = "") -> Answer:
        """A command that has a value."""
        spec = lib.lum_command_specs[number]
        right = f"a whole number from {spec.min} to {spec.max}{_steps(spec)}{unit}"
        number_of = whole(name, value, right)
        out, length = ffi.new("char[]", int(lib.LUM_COMMAND_TEXT_BYTES)), ffi.new("size_t *")
        is_allowed = 0 <= number_of <= 65535 and lib.lum_command_format(
            ffi.new("lum_command *", {"id": number, "value": number_of}), out, length) == lib.LUM_OK
        if not is_allowed:
            raise OptionError(f"{name}: {value!r} is not {right}")
        return self.change(bytes(ffi.buffer(out, length[0])).decode(), f"{name} {number_of}")

    def change(self, command: str, typed: str) -> Answer:
        """A command that the sensor must not refuse."""
        with self._connection.use():
            answer = self.answer_of(self.ask(lambda session: int(lib.lum_sensor_command(session, command.encode()))))
        said = refusal_of(command, answer.debug)
        if said is not None:
            raise SensorError(f"{self._connection.address} refused '{typed}': {said}")
        return answer

    def tlvs(self, tlvs: tuple[tuple[int, bytes], ...]) -> Answer:
        """Any TLVs. A laser that they switch on is guarded."""
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
        with self._connection.use():
            if switches_on:
                self._laser.was_switched_on = True
                self._laser.session.want(lib.LUM_WANT_GUARD)
            return self.answer_of(self.ask(
                lambda session: int(lib.lum_sensor_request(session, packet + head, writer.len - head))))


# --- Values and texts ---


def _steps(spec: Any) -> str:
    return f" in steps of {spec.step}" if spec.step > 1 else ""


def whole(name: str, value: Any, right: str) -> int:
    """A whole number, or TypeError."""
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError(f"{name}: {value!r} is not {right}")
    return operator.index(value)


def by_eye(name: str, eye: Any, blue: int, green: int) -> int:
    """That of the two which is the eye's."""
    if eye not in ("blue", "green"):
        raise OptionError(f'{name}: {eye!r} is not an eye: "blue" or "green"')
    return int(blue if eye == "blue" else green)


def _tlv(pair: Any) -> tuple[int, bytes]:
    right = 'a TLV is a pair of a type from 0 to 65535 and bytes, such as (1, b"50p")'
    if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not isinstance(pair[1], (bytes, bytearray, memoryview)):
        raise TypeError(f"{pair!r}: {right}")
    kind = whole("tlv", pair[0], "a type from 0 to 65535")
    if not 0 <= kind <= 65535:
        raise OptionError(f"{pair!r}: {right}")
    return kind, bytes(pair[1])


def check_commands(commands: str) -> None:
    """Whether the manual has them, and none switches the laser."""
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
            raise OptionError(f"{word!r}: use {spec.min} to {spec.max}{_steps(spec)}")
        if result != lib.LUM_OK:
            raise OptionError(f"{commands!r}: {word!r} is not a command: a whole number and one of p g b f y h G B, "
                              "separated by one space")
        if command.id in (lib.LUM_COMMAND_LASER_ON, lib.LUM_COMMAND_LASER_OFF):
            raise OptionError(f"{commands!r}: the laser is switched by laser_on() and laser_off(), which see what it does")


# --- What a sensor answers ---

_REFUSES = ("refus", "reject", "invalid", "error", "unknown", "denied", "cannot", "out of range", "malformed", "illegal",
            "not allowed", "unsupported")
_CONFIRMS = frozenset(("set", "done", "ok", "accepted", "applied"))
_DOUBTS = frozenset(("not", "no", "range", "limit", "failed", "max", "min", "must"))


def _words(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z0-9]+", text))


def refusal_of(command: str, debug: Iterable[str]) -> Optional[str]:
    """What the sensor said, where it refused a command or something that it does not name; None: it did not."""
    refuses = False
    for line in debug:
        lower = line.lower()
        words = _words(lower)
        says_no = any(stem in lower for stem in _REFUSES)
        confirms = bool(words & _CONFIRMS) and not words & _DOUBTS and not says_no
        is_named = any(word in _words(line) for word in command.split())
        refuses = refuses or (is_named and not confirms) or (not is_named and says_no)
    return "; ".join(debug) if refuses else None
