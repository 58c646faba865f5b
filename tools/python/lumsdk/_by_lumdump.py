"""convert() by lumdump: what it reads, what it is told, and which files it made."""
from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from collections.abc import Iterable, Iterator
from typing import Any

from . import _lumdump
from ._c import LOSSES
from ._errors import OptionError
from ._formats import WRITERS, AnyTarget
from ._inputs import Files, Stream, open_input
from ._plan import PATTERN, Plan, Summary
from ._programs import left_out_of
from ._table import extra
from ._target import Target, UrlTarget, failed, is_url, local_for

_POINTS_AT_ONCE = 500_000

FOREIGN = ("pyarrow", "laspy", "lazrs")
"""Libraries that write a format, and have errors of their own."""


def _sources(plan: Plan, kept: contextlib.ExitStack) -> Any:
    """What lumdump reads: paths, or an object with read()."""
    given = open_input(plan.source, plan.source_storage)
    kept.callback(given.close)
    if isinstance(given, Files):
        plan.paths = given.paths
        return given.paths
    return given._rewind() if isinstance(given, Stream) else io.BytesIO(plan.source)


def _made_by(name: str, rotates: bool, sensors: Iterable[str]) -> dict[str, tuple[int, int]]:
    """The files that outputs of this name have, also of each sensor, and what tells one from another of the same name."""
    if "%s" in name:
        return {path: mark for sensor in sensors for path, mark in _made_by(name.replace("%s", sensor), rotates, ()).items()}
    folder, base = os.path.split(name)
    if "%" in base:
        before, after = PATTERN.split(base)[0], PATTERN.split(base)[-1]
        pattern = re.escape(before) + r" *\d+" + re.escape(after)
    elif rotates:
        stem, dot, ending = base.rpartition(".")
        pattern = re.escape(stem if dot else base) + r"-\d{4,}" + re.escape(dot + ending if dot else "")
    else:
        pattern = re.escape(base)
    out = {}
    with contextlib.suppress(OSError):
        for entry in os.scandir(folder or "."):
            if re.fullmatch(pattern, entry.name):
                status = entry.stat()
                out[os.path.join(folder, entry.name)] = status.st_ino, status.st_mtime_ns
    return out


@contextlib.contextmanager
def _laz_of(plan: Plan) -> Iterator[str]:
    """A path for a LAS file, which becomes the LAZ file of the plan piece by piece."""
    laspy = extra("laspy", "laz")
    extra("lazrs", "laz")
    target: AnyTarget = UrlTarget(plan.name, plan.storage) if is_url(plan.name) else Target(plan.name)
    try:
        with tempfile.TemporaryDirectory(prefix=".lumsdk-", dir=target.folder) as folder:
            path = os.path.join(folder, "map.las")
            yield path
            with laspy.open(path) as reader, laspy.LasWriter(target.file, reader.header, do_compress=True, closefd=False,
                                                             laz_backend=laspy.LazBackend.LazrsParallel) as writer:
                for points in reader.chunk_iterator(_POINTS_AT_ONCE):
                    writer.write_points(points)
        target.finish()
    except BaseException as error:
        target.discard()
        if isinstance(error, Exception) and type(error).__module__.split(".")[0] in FOREIGN:
            raise failed(plan.name, error) from error
        raise


def by_lumdump(plan: Plan) -> Summary:
    if "{utc_ns}" in plan.name:
        raise OptionError(f"{plan.name}: {{utc_ns}} goes with {', '.join(WRITERS)}; use %04d, the number of the frame")
    options = {name: value for name, value in {**plan.read, **plan.output}.items() if name not in ("broken", "progress")}
    with contextlib.ExitStack() as kept:
        source = _sources(plan, kept)
        plan.check_written(plan.name)
        folder = kept.enter_context(tempfile.TemporaryDirectory(prefix="lumsdk-"))
        written = "las" if plan.is_laz_of_las else plan.format
        arguments = [f"--format={written}", *_lumdump.arguments(options, folder)]
        total = _lumdump.bytes_of(source)
        if plan.progress is not None:
            plan.progress(0, total)
        with _laz_of(plan) if plan.is_laz_of_las else local_for(plan.name, plan.storage) as local:
            like = local, "rotate" in options, plan.sensors
            before = _made_by(*like)
            said = _lumdump.run(source, local, arguments)
            made = {name: mark for name, mark in _made_by(*like).items() if before.get(name) != mark}
            size = sum(os.path.getsize(name) for name in made)
        if plan.is_laz_of_las:
            made = {plan.name: (0, 0)}
            size = 0 if is_url(plan.name) else os.path.getsize(plan.name)
        if plan.progress is not None:
            plan.progress(total, total)
    names = sorted(made)
    [shown] = said.get("pictures", [{"frames": said["frames_selected"], "points": said["points"]}])  # a picture shows one frame
    if "voxels" in said:
        shown = {**shown, "points": said["voxels"]["voxels"]}
    if is_url(plan.name):
        names = [plan.name.rsplit("/", 1)[0] + "/" + os.path.basename(name) for name in names]
    return Summary(source=said["source"], format=plan.format, outputs=names, frames=shown["frames"],
                   points=shown["points"] - (0 if "voxels" in said else said.get("poses", {}).get("without", 0)),
                   bytes=size, truncated=said["truncated"],
                   sensors=[sensor.get("rig_name", sensor.get("name", sensor["address"])) for sensor in said["sensors"]],
                   losses={cause: said[cause] for cause in LOSSES if cause in said},
                   left_out=left_out_of(said))
