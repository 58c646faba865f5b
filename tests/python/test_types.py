"""The package's types say what a program may do: checkers find each mistake of typed/mistakes.py, and none in typed/use.py."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import typing

import lumsdk
import numpy as np
import pytest
from conftest import PACKAGE, PATIENCE_S
from lumsdk import _types

FOLDER = pathlib.Path(__file__).parent / "typed"


def mistakes():
    """The lines of mistakes, and what mypy calls each."""
    found = {}
    for i, line in enumerate((FOLDER / "mistakes.py").read_text().splitlines(), 1):
        if "  # wrong" in line:
            found[i] = re.search(r"  # wrong: [^:]+: ([\w-]+)$", line)[1]
    return found


def found_by(command, pattern, tmp_path):
    """The lines in which a checker finds an error, by file, and all that it calls them."""
    pytest.importorskip(command[0])
    for name in ("use.py", "mistakes.py"):
        shutil.copy(FOLDER / name, tmp_path / name)
    environment = {**os.environ, "MYPYPATH": str(PACKAGE), "PYTHONPATH": str(PACKAGE), "PYRIGHT_PYTHON_GLOBAL_NODE": "1",
                   "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    done = subprocess.run([sys.executable, "-m", *command, "use.py", "mistakes.py"], cwd=tmp_path, env=environment,
                          capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    found = {"use.py": {}, "mistakes.py": {}}
    for name, line, kind in re.findall(pattern, done.stdout, re.M):
        found[name].setdefault(int(line), set()).add(kind)
    assert found["use.py"] == {}, done.stdout
    return found["mistakes.py"], done.stdout


def test_there_are_mistakes_of_every_part():
    assert len(mistakes()) > 70


def test_mypy_finds_each_mistake_and_no_other(tmp_path):
    found, said = found_by(["mypy", "--strict", "--cache-dir", str(tmp_path), "--follow-imports", "silent"],
                           r"^(\w+\.py):(\d+): error: .*\[([\w-]+)\]$", tmp_path)
    assert found == {line: {kind} for line, kind in mistakes().items()}, said


def test_pyright_finds_each_mistake_and_no_other(tmp_path):
    found, said = found_by(["pyright", "--pythonpath", sys.executable], r"(\w+\.py):(\d+):\d+ - error: ([^(]*)", tmp_path)
    assert sorted(found) == list(mistakes()), said


def test_the_names_of_columns_are_those_of_the_library():
    of = {"float32": _types.FloatColumn, "uint32": _types.Uint32Column, "uint16": _types.Uint16Column, "uint8": _types.Uint8Column}
    typed = {name: np.dtype(kind) for kind, names in of.items() for name in typing.get_args(names)}
    assert typed == dict(lumsdk.COLUMNS)
    assert sorted(typing.get_args(lumsdk.Column)) == sorted(lumsdk.COLUMNS)


def test_a_column_of_ones_own_is_its_name():
    assert lumsdk.OwnColumn("label") == "label" and type(lumsdk.OwnColumn("label")) is str
