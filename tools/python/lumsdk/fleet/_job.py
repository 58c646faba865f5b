"""What all captures of a run have in common, and lumdump, which converts them."""
from __future__ import annotations

import importlib
import os
import shutil
from dataclasses import dataclass
from typing import Optional

from ._errors import FleetError

LUMDUMP_FORMATS = ("ply", "pcd", "las", "csv", "xyz", "png", "pcap", "pcapng")
# Written by lumsdk.convert().
PYTHON_FORMATS = ("parquet", "feather", "laz", "npy", "bin")


@dataclass(frozen=True)
class Job:
    """Sent to every worker."""

    run: str
    out: str
    endpoint: Optional[str]
    format: str
    arguments: tuple[str, ...]  # of lumdump; files by their names in `files`
    keywords: dict[str, object]  # of lumsdk.convert(), by the same names
    files: dict[str, bytes]  # calibration and profile, because other machines do not have them
    options: str  # the same as text for the manifest
    version: str
    lumdump: str  # where this machine has it


def find_lumdump(likely: str = "") -> str:
    """lumdump's path: as this machine's package finds it, or as another machine of the cluster did."""
    try:
        programs = importlib.import_module("lumsdk._programs")
    except ImportError:
        programs = None
    if programs is not None:
        try:
            return str(programs.find("lumdump"))
        except Exception as error:  # lumsdk.Error, whose module needs the library
            if not (likely and os.access(likely, os.X_OK)):
                raise FleetError(str(error)) from error
            return likely
    folder = os.environ.get("LUM_BIN")
    for found in (folder and shutil.which("lumdump", path=folder), shutil.which("lumdump"), likely):
        if found and os.access(found, os.X_OK):
            return found
    raise FleetError("lumdump is not installed: pip install lumsdk, or name its folder in LUM_BIN")
