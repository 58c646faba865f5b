"""The sessions of a live sensor in C: one caller at a time, another session for commands while frames come, none after a fork."""
from __future__ import annotations

import collections
import contextlib
import os
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Optional

from ._c import ffi, lib, sized
from ._errors import ClosedError, SensorError
from ._session import Plan, Status, lacks_heartbeats, new_cancel, show, status_of

if TYPE_CHECKING:
    from ._stream import Stream


class Connection:
    """The sessions with one sensor, and what they counted."""

    def __init__(self, plan: Plan, owns: bool) -> None:
        self.plan, self.owns = plan, owns
        self.lock = threading.Lock()
        self.stream_ref: Callable[[], Optional[Stream]] = lambda: None
        self.past_losses: collections.Counter[str] = collections.Counter()
        self._counted: dict[str, int] = {}
        self._why_closed = "the sensor is closed; open it again to use it"
        self._process = os.getpid()
        self.cancel = new_cancel()
        self._second: Any = ffi.NULL
        self.session: Any = plan.open(owns, self.cancel)
        self.address = show(lib.lum_sensor_endpoint(self.session))

    @contextlib.contextmanager
    def use(self, closed_is_fine: bool = False) -> Iterator[None]:
        """A call of the session, one at a time."""
        if not self.lock.acquire(blocking=False):
            raise SensorError(f"{self.address}: the session is in use by another thread; one thread at a time may use "
                              "it, and several sensors can be used in several")
        try:
            if not closed_is_fine:
                self.check()
            if self.stream() is None:
                lib.lum_cancel_reset(self.cancel)
            yield
        finally:
            self.lock.release()

    def check(self) -> None:
        """Raise ClosedError where there is no session."""
        if self.is_of_parent():
            raise ClosedError(f"{self.address}: the session belongs to the process that began it; this one was forked "
                              "from it, and opens its own")
        if not self.session:
            raise ClosedError(f"{self.address}: {self._why_closed}")

    def is_of_parent(self) -> bool:
        """Whether this process was forked from the one that began the session."""
        return self._process != os.getpid()

    def leave(self) -> None:
        """Close the sockets; nothing is sent, so a forked process can do it too."""
        for session in (self._second, self.session):
            lib.lum_sensor_close(session)
        self._second = self.session = ffi.NULL

    def end(self, why: Optional[str] = None) -> None:
        """End the session, and with it the heartbeats."""
        self._why_closed = why or self._why_closed
        stream = self.stream()
        if stream is not None:
            stream.close()
        self.count()
        self.leave()

    def stream(self) -> Optional[Stream]:
        """The frames that are under way."""
        stream = self.stream_ref()
        return None if stream is None or stream.has_ended else stream

    def command_session(self) -> Any:
        """The session for requests: while frames stream, they use a second one, so that no data is lost."""
        if self.stream() is None:
            return self.session
        if not self._second:
            self._second = self.plan.open(False)
        return self._second

    def has_owner(self) -> bool:
        """Whether heartbeats go to the sensor."""
        return self.owns or bool(lib.lum_sensor_is_owned(lib.lum_sensor_endpoint(self.session), self.plan.interface, ffi.NULL))

    def status_of(self, value: int) -> Status:
        """A status by its bits."""
        return status_of(value, self.owns or (lacks_heartbeats(value) and self.has_owner()))

    def count(self) -> dict[str, int]:
        """What the session counted since it began, also when it has ended."""
        if self.session:
            c = sized("lum_sensor_counters")
            lib.lum_sensor_count(self.session, c)
            names = [name for name, _ in ffi.typeof("lum_sensor_counters").fields if name != "struct_size"]
            self._counted = {name: int(getattr(c, name)) for name in names}
        return dict(self._counted)
