"""What ends a run before it begins, or makes it stop."""
from __future__ import annotations

from .._errors import Error, OptionError
from ._names import printable


class FleetError(Error):
    """A run cannot begin or go on. The text is for the user."""

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


class WorkerDied(Exception):
    """A worker's process or its machine ended: what it was asked has no answer."""


class LockTaken(FleetError):
    """Another run writes to OUT: this one may not touch it any more."""


class Usage(FleetError, OptionError):
    """Arguments that are wrong."""
