"""The command line, and what it says to lumdump and to lumsdk.convert()."""
from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import tempfile
import warnings
from typing import Any, NoReturn

from .. import _run
from .._c import cores
from ._errors import FleetError, Usage
from ._job import LUMDUMP_FORMATS, PYTHON_FORMATS, Job, find_lumdump
from ._names import printable

# The options of lumdump that apply to a capture that becomes one file.
VALUES = ("columns", "time", "sensor", "port", "eye", "edge", "return", "frames", "range", "box", "incomplete", "packets",
          "duration", "smooth")
FLAGS = ("ascii", "comments")
FILES = ("calibration", "profile")
RIG = "rig.yaml"
"""A rig's name on a worker, where the files that it names are beside it."""
# Those that lumsdk.convert() has, with its name for them.
KEYWORDS = {"columns": "columns", "time": "time", "sensor": "sensor", "port": "port", "eye": "eye", "edge": "edge",
            "return": "returns", "frames": "frames", "range": "range", "box": "box", "incomplete": "incomplete", "smooth": "smooth"}

EMPTY_PCAP = bytes.fromhex("d4c3b2a1020004000000000000000000ffff000001000000")
# Those that only it has.
OF_CONVERT = ("preset", "compression")

FORMATS = (*PYTHON_FORMATS, *LUMDUMP_FORMATS)

HELP = f"""\
Usage: lumfleet IN... --out OUT --format FORMAT [OPTION]...
Convert the captures of a fleet, on this machine or on a cluster of Ray.

IN is a capture, a folder, which is searched with all folders in it, or a
pattern in quotes with * ? [] and ** for any folders; OUT is a folder. Both can
be of this machine or of an object store: s3://BUCKET/FOLDER.
Each capture becomes one file, with the folders that it has in IN. OUT gets
manifest.parquet too: a row for each capture, with its digest, its counts, its
losses, or why it failed. A second run does what is missing or has changed.

Output:
      --out OUT               folder, is made if it is not there
      --format {"|".join(FORMATS[:6])}|
               {"|".join(FORMATS[6:])}
      --preset NAME           columns of another project (parquet, feather):
                              argoverse2
      --compression NAME      of tables (parquet, feather)
      --again                 convert all, also what is there and unchanged
      --dry-run               say what would be done; nothing is written
      --json                  the summary as one JSON object
  -q, --quiet                 no summary, no progress, no warnings

Machines:
      --jobs N                captures at a time; default: a processor each
      --address ADDRESS       of a Ray cluster, such as ray-head:6379 or auto;
                              without it this machine converts, without Ray
      --endpoint URL          of an S3 server that is not Amazon's; the
                              environment's AWS_* apply as everywhere
      --retries N             how often a capture is tried again whose worker
                              or machine died; default: 4

As lumdump has them, see lumdump --help:
      --ascii --comments --columns NAMES --time sensor|utc|arrival
      --sensor ADDRESS --port N --eye blue|green|both
      --edge rising|falling|both --return all|first|last|strongest|N
      --frames A:B --range MIN:MAX
      --box XMIN:XMAX,YMIN:YMAX,ZMIN:ZMAX --incomplete keep|drop
      --packets lines|all --duration SECONDS --smooth WINDOW[:ORDER]
      --calibration FILE --profile FILE --set KEY=VALUE
      --rig FILE

      --help, --version

Exit status: 0 all is converted, 1 a capture failed, or the run did, 2 bad
arguments or configuration.

Examples:
  lumfleet drives/ --out clouds/ --format las
  lumfleet 'drives/2026-11-*/**/*.pcap' --out last/ --format ply --return last
  lumfleet s3://raw/2026 --out s3://points --format parquet --address auto
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise Usage(f"{message}; see lumfleet --help")


def _count(least: int) -> Any:
    def read(text: str) -> int:
        if not text.isdigit() or not least <= int(text) <= 100_000:
            raise argparse.ArgumentTypeError(f"'{text}' is not a number from {least} to 100000")
        return int(text)
    return read


def parse(arguments: list[str]) -> argparse.Namespace:
    """Refuses what cannot be right by itself."""
    parser = _Parser(prog="lumfleet", add_help=False, allow_abbrev=False)
    parser.add_argument("inputs", nargs="*", metavar="IN")
    parser.add_argument("--out")
    parser.add_argument("--format")
    for name in ("again", "dry-run", "json", "help", "version", *FLAGS):
        parser.add_argument(f"--{name}", action="store_true")
    parser.add_argument("-q", "--quiet", action="store_true")
    parser.add_argument("--jobs", type=_count(1), default=0)
    parser.add_argument("--retries", type=_count(0), default=4)
    for name in ("address", "endpoint", *VALUES, *OF_CONVERT, *FILES, "rig"):
        parser.add_argument(f"--{name}")
    parser.add_argument("--set", action="append", default=[])
    options = parser.parse_intermixed_args(arguments)
    if options.help or options.version:
        return options
    if not options.inputs:
        raise Usage("no captures are named; see lumfleet --help")
    if not options.out:
        raise Usage("--out is needed: the folder for the outputs; see lumfleet --help")
    if options.format not in FORMATS:
        text = "--format is needed" if options.format is None else f"--format: '{options.format}' is not known"
        raise Usage(f"{text}: one of {', '.join(FORMATS)}")
    return options


def job(options: argparse.Namespace, run: str, version: str) -> Job:
    """What all captures have in common. Wrong values are refused with lumdump's sentence."""
    files = {name: _read(name, getattr(options, name)) for name in FILES if getattr(options, name) is not None}
    of_rig = _read_rig(options.rig) if options.rig is not None else {}
    said: dict[str, Any] = {name: getattr(options, name) for name in (*VALUES, *OF_CONVERT) if getattr(options, name) is not None}
    said.update({name: True for name in FLAGS if getattr(options, name)})
    sent = {**{_name(name, options): data for name, data in files.items()}, **of_rig}
    told = {**files, "rig": b"".join(of_rig.values())} if of_rig else files
    made = Job(run=run, out=options.out, endpoint=options.endpoint, format=options.format,
               arguments=_arguments(options, said), keywords={}, files=sent, options=_text(options, said, told), version=version,
               lumdump=find_lumdump())
    _check(made, said, options)
    return made if made.format in LUMDUMP_FORMATS else _with_keywords(made, said, options)


def _name(name: str, options: argparse.Namespace) -> str:
    """A calibration's or profile's name on a worker; outputs tell it."""
    last = os.path.basename(getattr(options, name))
    same = options.calibration and options.profile and \
        os.path.basename(options.calibration) == os.path.basename(options.profile)
    return f"{name}-{last}" if same or last == "lock" else last


def _read(name: str, path: str) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise Usage(f"--{name}: {path}: cannot be read: {error.strerror}") from error


def _read_rig(path: str) -> dict[str, bytes]:
    """A rig, and beside it the files that it names, for another machine."""
    import lumsdk

    with tempfile.TemporaryDirectory() as folder:
        try:
            lumsdk.Rig(path).save(os.path.join(folder, RIG))
        except lumsdk.OptionError as error:
            raise Usage(f"--rig: {error}") from error
        return {name: _read("rig", os.path.join(folder, name)) for name in sorted(os.listdir(folder))}


def _arguments(options: argparse.Namespace, said: dict[str, Any]) -> tuple[str, ...]:
    out = []
    for name, value in said.items():
        out += [f"--{name}"] if value is True else [f"--{name}", value]
    for name in FILES:
        if getattr(options, name) is not None:
            out += [f"--{name}", _name(name, options)]
    if options.rig is not None:
        out += ["--rig", RIG]
    for pair in options.set:
        out += ["--set", pair]
    return tuple(out)


def _text(options: argparse.Namespace, said: dict[str, Any], files: dict[str, bytes]) -> str:
    """For the manifest: the same text means the same conversion."""
    parts: dict[str, Any] = {"format": options.format, **said}
    if options.set:
        parts["set"] = options.set
    for name, data in files.items():
        parts[name] = {"name": os.path.basename(getattr(options, name)), "sha256": hashlib.sha256(data).hexdigest()}
    return json.dumps(parts, sort_keys=True)


def _check(made: Job, said: dict[str, Any], options: argparse.Namespace) -> None:
    """Ask lumdump whether it takes them: it looks at its options before its source, here an empty one."""
    is_ours = made.format in LUMDUMP_FORMATS
    for name in said:
        if name in OF_CONVERT if is_ours else name not in (*KEYWORDS, *OF_CONVERT):
            raise Usage(f"--{name} does not go with {made.format}; it goes with"
                        f" {', '.join(PYTHON_FORMATS if is_ours else LUMDUMP_FORMATS)}")
    arguments = list(_arguments(options, {n: v for n, v in said.items() if is_ours or n not in ("columns", "time", *OF_CONVERT)}))
    for name in (*FILES, "rig"):
        if getattr(options, name) is not None:
            arguments[arguments.index(f"--{name}") + 1] = getattr(options, name)
    form = made.format if is_ours else "ply"
    command = [made.lumdump, os.devnull, "-o", f"lumfleet-never-made.{form}", *arguments]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, check=False)
    except OSError as error:
        raise FleetError(f"{made.lumdump}: cannot be started: {error.strerror or error}") from error
    if ended.returncode == 2:
        raise Usage(ended.stderr.strip().split("lumdump: ", 1)[-1].replace("lumdump --help", "lumfleet --help"))
    if ended.returncode != 1:
        raise FleetError(f"{made.lumdump}: does not work: {ended.stderr.strip() or 'status %d' % ended.returncode}")


def _with_keywords(made: Job, said: dict[str, Any], options: argparse.Namespace) -> Job:
    keywords: dict[str, object] = {KEYWORDS.get(name, name): value for name, value in said.items()}
    for name in FILES:
        if getattr(options, name) is not None:
            keywords[name] = _name(name, options)
    if options.rig is not None:
        keywords["rig"] = RIG
    if options.set:
        keywords["set"] = options.set
    _try_convert(made, keywords)
    return Job(**{**made.__dict__, "keywords": keywords})


def _try_convert(made: Job, keywords: dict[str, Any]) -> None:
    """An empty capture shows whether convert() takes the options, and has what the format needs."""
    import lumsdk

    from ._work import in_folder

    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, data in {**made.files, "empty.pcap": EMPTY_PCAP}.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
        try:
            with in_folder(folder):
                lumsdk.convert("empty.pcap", f"made.{made.format}", **keywords)
        except (lumsdk.OptionError, ImportError) as error:
            raise Usage(str(error)) from error
        except lumsdk.Error:
            pass  # that it is empty


def local_jobs(options: argparse.Namespace) -> int:
    """Captures at a time on this machine."""
    return int(options.jobs or cores())


def told(text: str) -> None:
    """A line for the user, apart from the summary."""
    _run.told("lumfleet", printable(text))
