"""What all captures of a run have in common, and lumdump, which converts them."""
from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from typing import Optional

from .._errors import Error
from .._programs import find
from ._errors import FleetError

LUMDUMP_FORMATS = ("ply", "pcd", "las", "csv", "xyz", "png", "pcap", "pcapng")
# Written by lumsdk.convert().
PYTHON_FORMATS = ("parquet", "feather", "laz", "npy", "npz", "bin")


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
    """lumdump's path: in the folder LUM_BIN of the environment if that is set, else as the package finds
    it, else where another machine of the cluster has it."""
    folder = os.environ.get("LUM_BIN")
    found = folder and shutil.which("lumdump", path=folder)
    if found:
        return found
    try:
        return find("lumdump")
    except Error as error:
        if likely and os.access(likely, os.X_OK):
            return likely
        raise FleetError(str(error)) from error
