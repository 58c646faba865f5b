"""What ends a run before it begins, or makes it stop."""
from __future__ import annotations


class FleetError(Exception):
    """A run cannot begin or go on. The text is for the user; status is that of the program."""

    def __init__(self, text: str, status: int = 1) -> None:
        super().__init__(text)
        self.status = status


class WorkerDied(Exception):
    """A worker's process or its machine ended: what it was asked has no answer."""


class LockTaken(FleetError):
    """Another run writes to OUT: this one may not touch it any more."""


class Usage(FleetError):
    """Arguments that are wrong."""

    def __init__(self, text: str) -> None:
        super().__init__(text, 2)
