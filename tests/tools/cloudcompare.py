#!/usr/bin/env python3
"""cloudcompare.py CSV FILE...: open files of one capture in CloudCompare, in batch, and compare with the CSV.

FILE is .ply or .xyz: what Debian's CloudCompare opens without a dialogue and without plugins. It exports what it
holds as text; all points and all scalar fields have to agree with CSV. CloudCompare keeps scalar fields as float32,
so a large timestamp agrees to 24 bits only. Prints "N passed, N failed"; the exit status is 1 if any failed, 77 if
CloudCompare is not installed.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from read_back import FIELDS, FLOAT32, HALF, read_csv  # noqa: E402

NAMES = {"intensity": "pulse_width", "return number": "return_number", "number of returns": "number_of_returns"}


def export(path, directory):
    """Have CloudCompare load a file and write what it has as text; gives columns by name."""
    out = pathlib.Path(directory) / "out.asc"
    command = ["CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-O", str(path.resolve()), "-C_EXPORT_FMT", "ASC"]
    command += ["-PREC", "9", "-SEP", "SEMICOLON", "-ADD_HEADER", "-SAVE_CLOUDS", "FILE", str(out)]
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": directory, "LC_ALL": "C"}
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    if not out.exists():
        raise ValueError(f"CloudCompare, exit status {run.returncode}: {(run.stdout + run.stderr)[-300:]!r}")
    with open(out, encoding="ascii") as file:
        names = file.readline().strip().lstrip("/").split(";")
    table = numpy.loadtxt(out, delimiter=";", skiprows=1, ndmin=2)
    return {NAMES.get(name, name.lower()): table[:, i] for i, name in enumerate(names)}


def compare(want, got, fields):
    if sorted(got) != sorted(fields):
        return f"has the fields {sorted(got)}, want {sorted(fields)}"
    for name in fields:
        exact = want[name].astype("f8")
        if len(got[name]) != len(exact):
            return f"{len(got[name])} points, want {len(exact)}"
        # CloudCompare prints 9 decimals of a float32.
        allowed = 2.02 * HALF.get(name, 0) + 2 * FLOAT32 * abs(exact)
        differs = ~(abs(got[name] - exact) <= allowed)
        if differs.any():
            at = int(numpy.argmax(differs))
            return f"{name} of point {at} is {got[name][at]}, want {exact[at]} ({int(differs.sum())} differ)"
    return None


def main():
    if len(sys.argv) < 3:
        raise SystemExit(__doc__.splitlines()[0])
    if shutil.which("CloudCompare") is None:
        print("CloudCompare is not installed: apt-get install cloudcompare")
        return 77
    want = read_csv(sys.argv[1])
    passed = failed = 0
    for path in map(pathlib.Path, sys.argv[2:]):
        fields = list("xyz") if path.suffix.lower() == ".xyz" else FIELDS
        with tempfile.TemporaryDirectory() as directory:
            try:
                why = compare(want, export(path, directory), fields)
            except (OSError, ValueError, subprocess.TimeoutExpired) as error:
                why = f"{type(error).__name__}: {error}"
        passed, failed = passed + (not why), failed + bool(why)
        print(f"FAIL {path}: {why}" if why else f"ok   {path}: {len(want['x'])} points")
    print(f"{passed} passed, {failed} failed")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
