"""What is raised. Messages are those of lumdump and lumctl: what was wrong, where, and what to do."""
from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable
from typing import Union


class Error(Exception):
    """Anything that lumsdk refuses or cannot do."""


class CaptureError(Error, OSError):
    """A capture cannot be read, or only in part, or is not enough for a calibration."""


class OptionError(Error, ValueError):
    """An option, a calibration or a profile has a value that is not allowed."""


class UnknownKeyError(Error, KeyError):
    """A frame has no such column, or a calibration or profile no such key."""

    __str__ = Exception.__str__  # that of KeyError puts quotes around the sentence


class ClosedError(Error, ValueError):
    """A source or a sensor is used after it was closed."""


class SensorError(Error, OSError):
    """A sensor cannot be reached, or does not do what it was told."""

    news: str = ""
    """The name of what happened, such as "laser-fell": that of lum_news_name(); "" where it is none of these."""


class LaserError(SensorError):
    """The laser cannot be switched on, or was not confirmed off."""


class HazardError(LaserError):
    """The sensor reports a hazard, which keeps its laser down: where lumctl ends with status 4."""


class SensorWarning(UserWarning):
    """A sensor reports something, or does not do all that it should, but the work continues."""

    news: str = ""
    """As that of SensorError."""


class CaptureWarning(UserWarning):
    """A capture can be read, but something in it is wrong."""


def install(extra: str) -> str:
    """How to get what an extra of this package needs. No registry has lumsdk: what has its name there is not ours."""
    return f"in a clone of lumsdk, pip install '.[{extra}]'"


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Of known names, the one that was meant probably; none if nothing is like it."""
    import difflib  # only what is wrong needs it

    return difflib.get_close_matches(name, known, 1)


_FOLDER = os.path.dirname(__file__) + os.sep


def warn(said: Union[str, Warning], kind: type[UserWarning] = CaptureWarning) -> None:
    """Warn at the line of the program that uses this package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_FOLDER):
        level, frame = level + 1, frame.f_back
    warnings.warn(said, kind, stacklevel=level)
