"""Captures and live sensors of the Luminar Model G2 as arrays.

    with lumsdk.open("drive.pcap") as source:
        for frame in source:
            use(frame.xyz, frame["range"])
"""
from ._c import lib as _lib
from ._errors import CaptureError, ClosedError, Error, OptionError
from ._frame import Frame
from ._source import Source, open

__all__ = ["CaptureError", "ClosedError", "Error", "Frame", "OptionError", "Source", "open"]
__version__ = "0.1.0"
del _lib
