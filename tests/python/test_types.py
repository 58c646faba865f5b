"""The package's types say what a program may do: a checker finds each mistake of typed/use.py, and nothing else."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from conftest import PACKAGE, PATIENCE_S

USE = pathlib.Path(__file__).parent / "typed/use.py"


def wrong_lines():
    return [i for i, line in enumerate(USE.read_text().splitlines(), 1) if line.endswith("# wrong")]


def found_by(command, pattern, tmp_path):
    """The lines in which a checker finds an error."""
    pytest.importorskip(command[0])
    shutil.copy(USE, tmp_path / "use.py")
    environment = {**os.environ, "MYPYPATH": str(PACKAGE), "PYTHONPATH": str(PACKAGE), "PYRIGHT_PYTHON_GLOBAL_NODE": "1",
                   "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    done = subprocess.run([sys.executable, "-m", *command, "use.py"], cwd=tmp_path, env=environment, capture_output=True,
                          text=True, timeout=PATIENCE_S, check=False)
    return sorted({int(number) for number in re.findall(pattern, done.stdout, re.M)}), done.stdout


def test_mypy_finds_each_mistake_and_no_other(tmp_path):
    found, said = found_by(["mypy", "--strict", "--cache-dir", str(tmp_path), "--follow-imports", "silent"],
                           r"^use\.py:(\d+): error: ", tmp_path)
    assert found == wrong_lines(), said


def test_pyright_finds_each_mistake_and_no_other(tmp_path):
    found, said = found_by(["pyright", "--pythonpath", sys.executable], r"use\.py:(\d+):\d+ - error: ", tmp_path)
    assert found == wrong_lines(), said
