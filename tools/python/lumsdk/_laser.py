"""The laser of a live sensor: switching it on and off, and the news of its laser session in C."""
from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

from ._c import check, ffi, lib, sized, text
from ._errors import HazardError, LaserError, SensorError, SensorWarning, warn
from ._session import Event, Plan, Status, hazards_of, lacks_heartbeats, now_ns, receive

if TYPE_CHECKING:
    from ._connection import Connection

_OFF_SLICE_MS = 200
_OFF_ALONE_S = lib.LUM_HEARTBEAT_TIMEOUT_MS / 1000
_GC_OFF_S = 3.0
_OWN = ": nobody sends heartbeats. Open a session that owns the sensor: lumsdk.Sensor(...) without owns=False"

# What became of laser_on(), and what a request says itself, or its answer.
_ON = ("laser-up", "laser-refused", "laser-unseen", "laser-unanswered", "laser-held-up")
_UNANSWERED = ("no-answer", "no-answer-yet", "unheard")
_ANSWERED = ("text", "hazard", "no-status")

# --- News ---

# What a program does about news, where the table tells a person at a terminal what to run.
_FIXES = dict.fromkeys(("laser-fell", "laser-refused", "laser-held-up"),
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
        fix = _FIXES.get(self.name) or text(lib.lum_news_fix(c, out, len(out)))
        self.told += f"; {fix}" if fix else ""

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


def news_of(plan: Plan, kind: int, said: str = "") -> News:
    """What is to be said of a sensor, where no laser session has found it."""
    c = sized("lum_news", kind=kind, interface_name=plan.interface, text=said.encode()[:int(lib.LUM_NEWS_TEXT_BYTES) - 1],
              tlv_status=plan.layout.profile.tlv[lib.LUM_TLV_STATUS])
    c.sensor.address, c.sensor.port = plan.address, plan.port
    return News(c)


# --- Its laser session ---


class LaserSession:
    """What keeps a sensor and its laser, in C (lum/live/laser_session.h): it alone has the rules for both."""

    def __init__(self, plan: Plan, owns: bool) -> None:
        options, out, error = ffi.new("lum_laser_session_options *"), ffi.new("lum_laser_session **"), ffi.new("lum_error *")
        lib.lum_laser_session_options_default(options, plan.options(owns))
        check(lib.lum_laser_session_new(options, now_ns(), out, error), error, SensorError)
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


# --- Laser off ---


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


# --- On, off, and news meanwhile ---


class LaserControl:
    """The laser of a connection, and what its laser session has to do and has found."""

    def __init__(self, connection: Connection, session: LaserSession) -> None:
        self.session = session
        self.was_switched_on = False
        """By this object, which so has to switch it off."""
        self._connection = connection
        self._off_was_called = False
        self._on: Optional[News] = None
        self._problem: Optional[SensorError] = None
        self.warnings: list[SensorWarning] = []
        """For the next give_warnings()."""

    # What is due, and news.

    def send_due(self) -> None:
        """Send what is due."""
        if self._off_was_called:  # in another thread, which has sent it too
            self._off_was_called = False
            self.session.want(lib.LUM_WANT_OFF)
        lib.lum_laser_session_serve(self.session.c, self._connection.session, now_ns())

    def take_news(self, said: tuple[str, ...] = ("no-answer",)) -> None:
        """Take news, but for what is said elsewhere. What ends frames ends the next ones, where there are none."""
        if self.was_switched_on:
            said += ("laser-came-up", "laser-fell") if self._off_was_called else ("laser-came-up",)
        for news in self.session.news():
            if news.name in _ON:
                self._on = news
            elif news.weight != lib.LUM_NEWS_INFO and news.name not in said:
                if news.weight == lib.LUM_NEWS_ERROR and (self.was_switched_on or news.name == "moved"):
                    self._problem = self._problem or news.error()
                self.warnings.append(news.warning())

    def take_problem(self) -> Optional[SensorError]:
        """The news that ends frames, once."""
        problem, self._problem = self._problem, None
        return problem

    def drop_warnings(self, said: tuple[str, ...]) -> None:
        """Forget warnings of news that an exception tells."""
        self.warnings = [warning for warning in self.warnings if warning.news not in said]

    def give_warnings(self) -> None:
        """Warn of what was found. In C's calls this is not possible."""
        while self.warnings:
            warn(self.warnings.pop(0))

    def step(self, session: Any, serves: bool = True) -> Event:
        """Send what is due, and take one event, or nothing for a while."""
        if session != self._connection.session:
            event = receive(session)
        else:
            if serves:
                self.send_due()
            event = receive(session, self.session)
            self.take_news(_UNANSWERED + (_ANSWERED if event.kind == lib.LUM_SENSOR_ANSWER else ()))
        if event.kind == lib.LUM_SENSOR_FAILED:
            raise SensorError(event.error)
        if event.kind == lib.LUM_SENSOR_CANCELLED:
            lib.lum_cancel_reset(self._connection.cancel)
        return event

    # On.

    def on(self) -> Status:
        """Switch it on, and see that it is up."""
        self.was_switched_on, self._off_was_called, self._on, self._problem = True, False, None, None
        try:
            return self._switch_on()
        except BaseException as problem:
            self.off_after(problem)
            raise

    def _switch_on(self) -> Status:
        connection = self._connection
        lib.lum_sensor_give_up(connection.session)
        lib.lum_laser_session_note_owner(self.session.c, connection.has_owner())
        self.session.want(lib.LUM_WANT_ON)
        while self.session.look().laser == lib.LUM_LASER_ASKED:
            stream = connection.stream()
            if stream is None:
                self.step(connection.session)
            else:
                stream.read()
        self.take_news()
        self.give_warnings()
        if self._on is None:
            raise LaserError(f"{connection.address}: laser_off() was called during laser_on()")
        if self._on.name != "laser-up":
            raise self._on.error(_OWN if not connection.owns and lacks_heartbeats(self._on.status) else "")
        return connection.status_of(self._on.status)

    # Off.

    def off(self) -> Status:
        """Switch it off from any thread, and see that it is down."""
        if not self._connection.lock.acquire(blocking=False):
            self._off_was_called = True
            return self._finish(self._try_anew(False), ends=False)
        try:
            return self.off_now()
        finally:
            self._connection.lock.release()

    def off_now(self) -> Status:
        """Switch it off in the thread that has the connection."""
        return self._finish(self._try())

    def off_if_due(self) -> bool:
        """A laser that the laser session switches off is seen to be down before the program goes on."""
        is_due = self._connection.stream() is None and bool(self.session.look().is_off_due)
        if is_due:
            self.give_warnings()
            self.off_now()
        return is_due

    def off_after(self, problem: BaseException) -> None:
        """The laser off after something failed. Raises LaserError in its place where that fails too."""
        try:
            self.off_now()
        except LaserError as worse:
            both = LaserError(f"{problem}; {worse}" if str(problem) else str(worse))
            both.news = worse.news
            raise both from problem

    def off_at_collection(self) -> Optional[SensorWarning]:
        """The laser off when its object is collected, where nothing can be raised."""
        off = put_down(self.session, self._connection.session, _GC_OFF_S)
        return None if off.result == lib.LUM_LASER_OFF_SEEN else off.news.warning()

    def _try(self) -> Off:
        try:
            off = put_down(self.session, self._connection.command_session())
        except SensorError:  # there is no other session
            return self._try_anew(self._connection.owns)
        if not off.is_broken:
            return off
        again = self._try_anew(self._connection.owns)
        return again._replace(was_interrupted=off.was_interrupted or again.was_interrupted)

    def _try_anew(self, ends: bool) -> Off:
        """A socket that broke sends nothing more, another may; and another thread has the session and its laser session."""
        laser = LaserSession(self._connection.plan, ends)
        try:
            session = self._connection.plan.open(False)
        except SensorError:
            return Off(*laser.end(ffi.NULL, 0), True, False)
        try:
            return put_down(laser, session)
        finally:
            lib.lum_sensor_close(session)

    def _finish(self, off: Off, ends: bool = True) -> Status:
        """What is to be done after laser off. The session stays where another thread uses it."""
        self.was_switched_on = False
        if off.result == lib.LUM_LASER_OFF_SEEN:
            if off.was_interrupted:
                raise KeyboardInterrupt
            return self._connection.status_of(off.news.status)
        if self._connection.owns and ends:
            self._connection.end("the session has ended, since laser off was not confirmed")
        raise off.news.error()
