"""What command lines of the package's programs have in common: how they are refused, and names of files."""
from __future__ import annotations

import argparse
import os
from collections.abc import Iterable
from typing import NoReturn, Optional

from ._errors import OptionError
from ._target import is_url


class Parser(argparse.ArgumentParser):
    """Raises OptionError, with our sentences."""

    def error(self, message: str) -> NoReturn:
        """Refuse the command line."""
        unknown = "unrecognized arguments: "
        said = message.removeprefix("argument ")
        if said.startswith(unknown):
            said = f"unknown option {said[len(unknown):].split()[0]}"
        raise OptionError(f"{said}; see {self.prog} --help")


def parser(prog: str, inputs: str, texts: Iterable[str]) -> Parser:
    """What all programs take: files to read, an output, options that have a text, and the usual flags."""
    made = Parser(prog=prog, add_help=False, allow_abbrev=False)
    made.add_argument(f"{inputs.lower()}s", nargs="*", metavar=inputs)
    made.add_argument("-o", "--output")
    for name in ("report", "calibration", "profile", "sensor", *texts):
        made.add_argument(f"--{name}")
    made.add_argument("--set", action="append", default=[])
    for name in ("json", "help", "version"):
        made.add_argument(f"--{name}", action="store_true")
    made.add_argument("-q", "--quiet", action="store_true")
    return made


def check_end(option: str, name: Optional[str], *endings: str) -> None:
    """Refuse a name of a file to be written, but for these endings."""
    if name is None:
        return
    if is_url(name):
        raise OptionError(f"{option}: {name}: is a URL; a file of this machine is needed")
    if not name.endswith(endings):
        raise OptionError(f"{option}: {name}: a name that ends in {' or '.join(endings)} is needed")


def check_apart(outputs: Iterable[Optional[str]], inputs: Iterable[Optional[str]]) -> None:
    """Refuse to write what is read."""
    read = {os.path.realpath(name) for name in inputs if name is not None}
    for name in outputs:
        if name is not None and os.path.realpath(name) in read:
            raise OptionError(f"{name}: is read and cannot be written too: choose another name")
