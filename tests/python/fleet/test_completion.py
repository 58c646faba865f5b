"""Completion of lumfleet in bash, asked as the shell asks."""
import sys

import pytest

from lumsdk.fleet import _arguments


@pytest.fixture(scope="module")
def complete(completion):
    return completion("lumfleet", sys.executable, "-B", "-m", "lumsdk.fleet.main")


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
