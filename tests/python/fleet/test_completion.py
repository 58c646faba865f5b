"""Completion of lumfleet in bash, asked as the shell asks."""
import os
import subprocess
import sys

import pytest
import support

from lumsdk.fleet import _arguments


@pytest.fixture(scope="module")
def complete(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bin")
    program = folder / "lumfleet"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -B -m lumsdk.fleet.main "$@"\n')
    program.chmod(0o755)
    script = """
        source "$0"
        COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
        _lumsdk "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
        printf '%s\\n' "${COMPREPLY[@]}"
    """

    def ask(*words):
        return subprocess.run(["bash", "-c", script, support.TOP / "tools/completion/lumsdk.bash", "lumfleet", *words],
                              capture_output=True, text=True, env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"},
                              timeout=support.LONG_S).stdout.split()
    return ask


def test_formats_are_all(complete):
    assert complete("--format", "") == list(_arguments.FORMATS)
    assert complete("--format", "pc") == ["pcd", "pcap", "pcapng"]


def test_options_are_those_of_the_help(complete):
    offered = complete("--")
    assert {"--out", "--format", "--address", "--return", "--dry-run"} <= set(offered)
    assert all(option in _arguments.HELP for option in offered)


def test_words_and_files(complete, tmp_path, monkeypatch):
    assert complete("--edge", "") == ["rising", "falling", "both"]
    assert complete("--set", "tof") == ["tof_lsb_ps="]
    (tmp_path / "drives").mkdir()
    monkeypatch.chdir(tmp_path)
    assert complete("dri") == complete("a", "--out", "dri") == ["drives"]
