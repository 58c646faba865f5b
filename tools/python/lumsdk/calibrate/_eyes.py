"""lumcal eyes: from captures of a room to a calibration."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ._result import Solution


@dataclass
class Options:
    """What `lumcal eyes` is told."""

    captures: Sequence[str]
    calibration: Any = None
    """What it was before: a lumsdk.Calibration, a path or None for the typical one."""
    profile: Any = None
    reading: dict[str, Any] = field(default_factory=dict)
    """More options of lumsdk.open(), such as sensor= and set=."""


def run(options: Options) -> Solution:
    """Calibrate. Raises lumsdk.OptionError, lumsdk.CaptureError, or ValueError where the captures do not suffice."""
    raise NotImplementedError


def to_yaml(solution: Solution) -> str:
    """A calibration file with standard deviations and provenance as comments; it loads as it is."""
    raise NotImplementedError


def to_json(solution: Solution) -> dict[str, Any]:
    """What --json prints."""
    raise NotImplementedError
