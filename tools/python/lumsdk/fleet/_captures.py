"""What IN names: captures, patterns and folders, as captures with a name in OUT."""
from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Optional

from .._inputs import ENDINGS
from .._target import is_url
from ._errors import FleetError, Usage
from ._places import Place, place


class Capture(NamedTuple):
    """A capture: where it is, its state, and the name of its output, without an ending."""

    source: str
    size: int
    stamp: str
    stem: str


def captures(names: Iterable[str], endpoint: Optional[str], out: str) -> Iterator[Capture]:
    """The captures that arguments name, except those below OUT. Each argument names at least one."""
    for name in names:
        if name.startswith("udp://"):
            raise Usage(f"{name}: a sensor is recorded by lumdump; lumfleet converts captures")
        nothing = True
        for capture in _of_argument(name, endpoint, out):
            nothing = False
            yield capture
        if nothing:
            raise FleetError(f"{name}: there is no capture (.pcap .pcapng .cap, or such a name with .gz or .zst)")


def _of_argument(name: str, endpoint: Optional[str], out: str) -> Iterator[Capture]:
    whole = place(name, endpoint)
    kind = whole.kind()
    if kind == "folder":
        yield from _of_folder(whole, out)
    elif kind == "file":
        yield _of_file(name, endpoint)
    elif re.search(r"[*?[]", name):
        yield from _of_pattern(name, endpoint, out)
    else:
        raise FleetError(f"{name}: no such capture and no such folder")


def _of_file(name: str, endpoint: Optional[str]) -> Capture:
    folder, _, last = _split(name)
    there = place(folder, endpoint)
    entry = there.entry(last)
    if entry is None:
        raise FleetError(f"{name}: no such capture and no such folder")
    return Capture(there.where(last), entry.size, entry.stamp, stem(last))


def _of_folder(folder: Place, out: str) -> Iterator[Capture]:
    for entry in folder.walk(apart=out):
        if ENDINGS.search(entry.name):
            yield Capture(folder.where(entry.name), entry.size, entry.stamp, stem(entry.name))


def _of_pattern(name: str, endpoint: Optional[str], out: str) -> Iterator[Capture]:
    fixed, pattern = _cut(name)
    folder = place(fixed, endpoint)
    is_one = re.compile(translate(pattern))
    for entry in folder.walk(apart=out) if folder.kind() == "folder" else ():
        parts = entry.name.split("/")
        within = any(is_one.fullmatch("/".join(parts[:n])) for n in range(1, len(parts)))
        if is_one.fullmatch(entry.name) or within and ENDINGS.search(entry.name):
            yield Capture(folder.where(entry.name), entry.size, entry.stamp, stem(entry.name))


def _split(name: str) -> tuple[str, str, str]:
    """Folder, /, last part; the folder of a bare name is the present one."""
    folder, slash, last = (name if is_url(name) else name.replace(os.sep, "/")).rpartition("/")
    return folder or (slash or "."), slash, last


def _cut(name: str) -> tuple[str, str]:
    """A pattern's folder that has no wildcards, and the rest."""
    name = name if is_url(name) else name.replace(os.sep, "/")
    head, slash, rest = name.partition("://") if is_url(name) else ("", "", name)
    parts = rest.split("/")
    first = next(i for i, part in enumerate(parts) if re.search(r"[*?[]", part))
    fixed = "/".join(parts[:first])
    if not fixed:
        fixed = "/" if rest.startswith("/") else "."
    return head + slash + fixed, "/".join(parts[first:])


def translate(pattern: str) -> str:
    """A pattern as a regular expression: ** goes through folders, * ? [ ] do not."""
    out = ""
    at = 0
    while at < len(pattern):
        if pattern.startswith("**/", at):
            out, at = out + "(?:.*/)?", at + 3
        elif pattern.startswith("**", at):
            out, at = out + ".*", at + 2
        elif pattern[at] == "[" and "]" in pattern[at + 2:]:
            end = pattern.index("]", at + 2)
            inside = pattern[at + 1:end].replace("\\", "\\\\")
            out, at = out + "[" + ("^" + inside[1:] if inside[0] in "!^" else inside) + "]", end + 1
        else:
            out += {"*": "[^/]*", "?": "[^/]"}.get(pattern[at], re.escape(pattern[at]))
            at += 1
    return out


def stem(name: str) -> str:
    """A capture's name without its ending."""
    return ENDINGS.sub("", name) if ENDINGS.search(name) else os.path.splitext(name)[0] or name
