"""Captures and live sensors of the Luminar Model G2 as arrays.

    with lumsdk.open("drive-*.pcap") as source:
        for frame in source:
            use(frame.xyz, frame["range"])

Units are metres, degrees and nanoseconds; x looks forward, y left, z up. Options are those of lumdump, by the same names.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._c import VERSION as __version__
from ._errors import (CaptureError, CaptureWarning, ClosedError, Error, HazardError, LaserError, OptionError, SensorError,
                      SensorWarning, UnknownKeyError)

if TYPE_CHECKING:
    from ._columns import COLUMNS
    from ._convert import convert
    from ._frame import Frame
    from ._infer import Finding, Inference, infer
    from ._poses import Poses
    from ._project import Projection
    from ._rig import Rig, RigSensor
    from ._sensor import Sensor
    from ._session import Answer, Clock, Status
    from ._settings import Calibration, Profile
    from ._simulate import SimulatedSensor, simulate
    from ._source import Source, open
    from ._sync import FrameSet, sync
    from ._types import Column, OwnColumn
    from ._view import View, view
    from ._write import Line, Written, write_capture

__all__ = ["COLUMNS", "Answer", "Calibration", "CaptureError", "CaptureWarning", "Clock", "ClosedError", "Column", "Error",
           "Finding", "Frame", "FrameSet", "HazardError", "Inference", "LaserError", "Line", "OptionError", "OwnColumn", "Poses",
           "Profile", "Projection", "Rig", "RigSensor", "Sensor", "SensorError", "SensorWarning", "SimulatedSensor",
           "Source", "Status", "UnknownKeyError", "View", "Written", "__version__", "convert", "infer", "open", "simulate", "sync",
           "view", "write_capture"]

# Imported when it is asked for. Programs of the package that only start others need not even NumPy.
_LATER = {"Answer": "_session", "COLUMNS": "_columns", "Calibration": "_settings", "Clock": "_session", "Column": "_types",
          "Finding": "_infer", "Frame": "_frame", "FrameSet": "_sync", "Inference": "_infer", "Line": "_write",
          "OwnColumn": "_types", "Poses": "_poses", "Profile": "_settings", "Projection": "_project", "Rig": "_rig",
          "RigSensor": "_rig", "Sensor": "_sensor", "SimulatedSensor": "_simulate", "Source": "_source", "Status": "_session",
          "View": "_view", "Written": "_write", "convert": "_convert", "infer": "_infer", "open": "_source",
          "simulate": "_simulate", "sync": "_sync", "view": "_view", "write_capture": "_write"}


if not TYPE_CHECKING:  # it would take every name for one that there is
    def __getattr__(name: str) -> Any:
        if name not in _LATER:
            raise AttributeError(f"module 'lumsdk' has no attribute '{name}'")
        import importlib

        value = getattr(importlib.import_module(f".{_LATER[name]}", __name__), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER})
