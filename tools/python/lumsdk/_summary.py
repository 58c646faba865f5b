"""What convert() returns."""
from __future__ import annotations

from typing import TypedDict


class Summary(TypedDict):
    """What a conversion did: a dictionary. Where lumdump's JSON has the same facts, they are the same."""

    source: str
    """Its name."""
    format: str
    """The name of the format."""
    outputs: list[str]
    """The files that were made."""
    frames: int
    """Frames in the outputs: those that were selected, or given, also where a frame has no points."""
    points: int
    """Points that were written."""
    bytes: int
    """Size of the outputs together."""
    truncated: bool
    """Whether the capture breaks off before its end."""
    sensors: list[str]
    """Names of the sensors: their addresses, as Frame.sensor has them."""
    losses: dict[str, int]
    """What is missing in the capture, by cause, with lumdump's names; empty if frames were given."""
    left_out: int
    """Points that were asked for and are in no file, since their line came too late or was beyond the most of a frame,
    or since their time has no pose."""
