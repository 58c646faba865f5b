"""Formats that Python writes, and a worker by itself, without Ray."""
import hashlib
import io
import json
import os

import fsspec
import pyarrow
import pytest
import support
from support import run_tool

import lumsdk
from lumsdk.fleet import _arguments, _manifest, _summary, _work
from lumsdk.fleet._errors import FleetError
from lumsdk.fleet._ledger import Task, Totals
from lumsdk.fleet._places import Local, place


@pytest.fixture
def worker(tmp_path):
    """Makes a worker of lumfleet with options, and its OUT."""
    made = []

    def make(*arguments):
        options = _arguments.parse(["x", "--out", str(tmp_path / "out"), *arguments])
        made.append(_work.Converter(_arguments.job(options, "run", "0")))
        return made[-1]
    yield make
    for one in made:
        one.close()


def convert(worker, path, output="a/b.out", digest=""):
    info = os.stat(path)
    return worker.convert(Task(str(path), info.st_size, f"mtime:{info.st_mtime_ns}", output, digest), "run-1")


def summary(path, *arguments):
    return json.loads(run_tool("lumdump", path, "--json", *arguments).stdout)


@pytest.mark.parametrize("form", ["parquet", "feather", "laz", "npy"])
def test_formats_of_python_hold_lumdump_s_points(worker, small, tmp_path, form):
    pytest.importorskip("lumsdk._convert")
    got = convert(worker("--format", form, "--return", "strongest", "--range", "5:60"), small[1], f"a/b.{form}")
    said = summary(small[1], "--return", "strongest", "--range", "5:60")
    assert got["status"] == "done" and got["message"] == "" and got["points"] == said["points"] > 100
    assert {n: got[n] for n in ("frames", "lost_words", "no_range")} == {n: said[n] for n in ("frames", "lost_words", "no_range")}
    path = tmp_path / f"out/a/b.{form}"
    assert got["output_size"] == path.stat().st_size
    assert points_of(path) == said["points"]


@pytest.mark.parametrize("form", ["csv", "npy"])
def test_frames_are_those_of_the_output(worker, make_capture, form):
    got = convert(worker("--format", form, "--frames", "2:3"), make_capture("-n", 4, "--lines", 64), f"a/b.{form}")
    assert got["status"] == "done" and got["frames"] == 2


def points_of(path):
    if path.suffix == ".parquet":
        import pyarrow.parquet
        return pyarrow.parquet.read_table(path).num_rows
    if path.suffix == ".feather":
        import pyarrow.feather
        return pyarrow.feather.read_table(path).num_rows
    if path.suffix == ".laz":
        import laspy
        return len(laspy.read(path).points)
    import numpy
    return len(numpy.load(path))


@pytest.mark.parametrize("form", ["ply", "parquet"])
def test_a_damaged_capture_has_lumdump_s_sentence(worker, tmp_path, form):
    if form == "parquet":
        pytest.importorskip("lumsdk._convert")
    bad = tmp_path / "bad.pcap"
    bad.write_bytes(b"no capture" * 10)
    got = convert(worker("--format", form), bad)
    assert (got["status"], got["message"]) == ("failed", f"{bad}: {support.DAMAGED}")
    assert not support.outputs(tmp_path / "out")


@pytest.mark.parametrize("form", ["ply", "parquet"])
def test_a_capture_that_breaks_off_is_converted_with_a_warning(worker, small, tmp_path, form):
    if form == "parquet":
        pytest.importorskip("lumsdk._convert")
    cut = tmp_path / "cut.pcap"
    cut.write_bytes(small[1].read_bytes()[:100_000])
    got = convert(worker("--format", form), cut)
    assert got["status"] == "done" and got["truncated"] is True and got["points"] == summary(cut)["points"]
    assert f"{cut}: cannot be read beyond record" in got["message"]


def test_a_capture_that_changes_meanwhile_fails(worker, small, tmp_path):
    """Its first bytes and its last would be of two captures."""
    path = tmp_path / "a.pcap"
    path.write_bytes(small[0].read_bytes())
    one = worker("--format", "ply")
    by_lumdump = one._by_lumdump

    def and_changed(*arguments):
        got = by_lumdump(*arguments)
        path.write_bytes(small[1].read_bytes())
        return got
    one._by_lumdump = and_changed
    got = convert(one, path)
    assert (got["status"], got["message"]) == ("failed", f"{path}: it changed while it was read")
    assert not support.outputs(tmp_path / "out")


def test_a_capture_that_is_gone_fails(worker, tmp_path, small):
    path = tmp_path / "a.pcap"
    path.write_bytes(small[0].read_bytes())
    info = os.stat(path)
    path.unlink()
    got = worker("--format", "ply").convert(Task(str(path), info.st_size, "", "a.ply", ""), "run-1")
    assert got["status"] == "failed" and f"{path}: cannot be read: it is no longer there" in got["message"]


def test_the_same_bytes_are_not_converted_again(worker, small, tmp_path):
    one = worker("--format", "ply")
    first = convert(one, small[0])
    output = tmp_path / "out/a/b.out"
    before = output.stat()
    again = convert(one, small[0], digest=first["digest"])
    assert again["unchanged"] and output.stat() == before
    assert "unchanged" not in convert(one, small[1], digest=first["digest"])
    assert output.stat() != before


def test_lumdump_killed_is_an_attempt_lost(worker, small):
    one = worker("--format", "ply")
    killer = os.path.join(one._work.path, "killed")
    with open(killer, "w") as file:
        file.write("#!/bin/sh\nkill -9 $$\n")
    os.chmod(killer, 0o755)
    one._lumdump = killer
    assert convert(one, small[0])["lost"] == "lumdump was ended by SIGKILL"


@pytest.mark.parametrize("form", ["ply", "parquet"])
def test_a_name_that_is_no_text_is_converted(worker, small, tmp_path, form):
    path = tmp_path / os.fsdecode(b"a\xff.pcap")
    path.write_bytes(small[0].read_bytes())
    one = worker("--format", form)
    got = convert(one, path, os.fsdecode(b"a\xff.out"))
    assert (got["status"], got["source"], got["output"]) == ("done", f"{tmp_path}/a\\xff.pcap", r"a\xff.out")
    assert b"a\xff.out" in os.listdir(os.fsencode(tmp_path / "out"))
    path.write_bytes(b"no capture" * 10)
    got = convert(one, path, os.fsdecode(b"a\xff.out"))
    assert (got["status"], got["message"]) == ("failed", f"{tmp_path}/a\\xff.pcap: {support.DAMAGED}")


@pytest.mark.parametrize("form", ["ply", "parquet"])
@pytest.mark.parametrize("error, sentence", [
    (MemoryError(), "the conversion needs more memory than there is; fewer --jobs leave more for each"),
    (pyarrow.ArrowInvalid("a column is\ntoo long"), "the conversion ended with ArrowInvalid: a column is too long"), (AssertionError(), "the conversion ended with AssertionError")])
def test_whatever_a_capture_does_is_its_failure_alone(worker, small, tmp_path, monkeypatch, form, error, sentence):
    def fails(*_, **__):
        raise error
    one = worker("--format", form)
    with monkeypatch.context() as patch:
        patch.setattr("json.loads" if form == "ply" else "lumsdk.convert", fails)
        got = convert(one, small[0])
    assert (got["status"], got["message"]) == ("failed", f"{small[0]}: {sentence}") and "lost" not in got
    assert not support.outputs(tmp_path / "out")
    assert convert(one, small[1])["status"] == "done"


def test_lumdump_that_cannot_be_started_is_named(worker, small, tmp_path, monkeypatch):
    one = worker("--format", "ply")
    program = tmp_path / "lumdump"
    program.write_bytes((support.BIN / "lumdump").read_bytes())
    one._lumdump = str(program)
    got = convert(one, small[0])
    assert got["lost"] == f"{program} on {os.uname().nodename} cannot be started: Permission denied"
    monkeypatch.setattr(_arguments, "find_lumdump", lambda: str(program))
    with pytest.raises(FleetError, match=f"^{program}: cannot be started: Permission denied$"):
        worker("--format", "ply")


@pytest.fixture
def store():
    """A store in memory."""
    made = fsspec.filesystem("memory")
    made.makedirs("/captures", exist_ok=True)
    yield made
    made.rm("/captures", recursive=True)


def test_a_store_that_gives_a_part_of_a_capture_is_asked_again(worker, small, store, monkeypatch):
    """Also if the part ends at a record and looks like a whole capture."""
    data = small[1].read_bytes()
    store.pipe_file("/captures/a.pcap", data)
    record = 24 + 16 + int.from_bytes(data[32:36], "little")
    task = Task("memory://captures/a.pcap", len(data), "", "a.ply", "")
    one = worker("--format", "ply")
    opened = type(store)._open
    with monkeypatch.context() as patch:
        patch.setattr(type(store), "_open", lambda *a, **b: io.BytesIO(opened(*a, **b).read(record)))
        got = one.convert(task, "run-1")
    assert got["status"] == "failed" and got["lost"] == f"memory://captures/a.pcap: the store gave {record} of its {len(data)} bytes"
    assert "digest" not in got
    assert one.convert(task, "run-2")["digest"] == hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("form", ["ply", "parquet"])
def test_points_that_are_left_out_are_told(worker, small, tmp_path, monkeypatch, form):
    one = worker("--format", form)
    assert convert(one, small[0])["left_out"] == 0
    if form == "ply":
        program = tmp_path / "lumdump"
        left = r'"left_out": [{"output": "a", "late": 1, "cut": 2, "no_place": 4}, {"output": "b", "late": 8, "cut": 0, "no_place": 0}]'
        program.write_text(f"""#!/bin/sh
{support.BIN}/lumdump "$@" | sed 's/"left_out": *[[][]]/{left}/'
""")
        program.chmod(0o755)
        one._lumdump = str(program)
    else:
        by_lumsdk = lumsdk.convert
        monkeypatch.setattr("lumsdk.convert", lambda *a, **b: {**by_lumsdk(*a, **b), "left_out": 15})
    got = convert(one, small[0])
    assert (got["status"], got["left_out"]) == ("done", 15)
    _manifest.write(Local(str(tmp_path / "out")), [got], str(tmp_path), ".lumfleet/parts/m")
    assert support.rows(tmp_path / "out")[0]["left_out"] == 15
    told = _summary.Summary("out", form, Totals(1, 1, 1, 1))
    told.add_row(got, "0")
    told.add_row({**got, "left_out": None}, "0")  # of an earlier version
    assert "left out    15 points" in told.text() and json.loads(told.json())["left_out"] == 15


def test_a_name_that_is_no_text_is_text_in_a_store(worker, small, tmp_path, store):
    path = tmp_path / os.fsdecode(b"a\xff.pcap")
    path.write_bytes(small[0].read_bytes())
    got = convert(worker("--format", "ply", "--out", "memory://captures/made"), path, os.fsdecode(b"b/a\xff.ply"))
    assert (got["status"], got["output"]) == ("done", r"b/a\xff.ply")
    out = place("memory://captures/made")
    assert [entry.name for entry in out.outputs(apart=out.where(".lumfleet"))] == [r"b/a\xff.ply"]
