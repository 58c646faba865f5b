"""The programs that come with the package: lumdump, lumctl and lumsim."""
from __future__ import annotations

import os
import pathlib
import shutil
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from typing import Any

from ._errors import Error

NAMES = ("lumctl", "lumdump", "lumsim")
"""The programs of the wheel."""


def _script_folders() -> Iterator[pathlib.Path]:
    """Where pip puts the programs of a package: this Python's, those of --user, and those of --target."""
    yield pathlib.Path(sysconfig.get_path("scripts"))
    user = {"nt": "nt_user", "posix": "osx_framework_user" if sys.platform == "darwin" and
            sysconfig.get_config_var("PYTHONFRAMEWORK") else "posix_user"}.get(os.name)
    if user is not None:
        yield pathlib.Path(sysconfig.get_path("scripts", user))
    package = pathlib.Path(__file__).resolve().parent
    yield package.parent / "bin"
    # A build of the sources has its package in python and its programs in bin.
    yield package.parent.parent / "bin"


def _named(folder: pathlib.Path, name: str) -> str | None:
    """The program in a folder, if it is one that can be run."""
    return shutil.which(name, path=os.fspath(folder))


def find(name: str) -> str:
    """The path of a program: among this Python's scripts, then in the folder LUM_BIN of the environment, then in PATH.

    Raises Error if it is nowhere; its text says where it was looked for."""
    if os.path.basename(name) != name or not name:
        raise Error(f"{name!r} is not the name of a program; use one of {', '.join(NAMES)}")
    folders = list(_script_folders())
    if os.environ.get("LUM_BIN"):
        folders.append(pathlib.Path(os.environ["LUM_BIN"]))
    for folder in folders:
        found = _named(folder, name)
        if found is not None:
            return found
    found = shutil.which(name)
    if found is not None:
        return found
    named = f"LUM_BIN ({os.environ['LUM_BIN']})" if os.environ.get("LUM_BIN") else "LUM_BIN, which is not set,"
    raise Error(f"{name} is not among the scripts of this Python ({folders[0]}), nor in {named} nor in PATH; "
                f"a wheel of lumsdk brings it: pip install --force-reinstall lumsdk, or name the folder that has it in LUM_BIN")


def left_out_of(said: Mapping[str, Any]) -> int:
    """Points that lumdump left out of its outputs, by its JSON."""
    left_out = sum(output[why] for output in said["left_out"] for why in ("late", "cut", "no_place"))
    return int(said.get("poses", {}).get("without", 0) + left_out)
