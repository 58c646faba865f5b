"""Planning, the manifest and the journal, without Ray."""
import json
import os
import pathlib
import re
import subprocess
import sys

import pytest
import support  # noqa: F401  the package's place

import lumsdk
from lumsdk.fleet import _arguments, _folders, _journal, _manifest, _summary, main
from lumsdk.fleet._errors import FleetError, Usage
from lumsdk.fleet._captures import captures, stem, translate
from lumsdk.fleet._ledger import Ledger
from lumsdk.fleet._lock import Lease, lock
from lumsdk.fleet._names import to_name, to_text
from lumsdk.fleet._places import Entry, Local, place


def tree(folder, *names):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x" * len(name))
    return folder


def found(*names, out="/nowhere"):
    return {c.stem: c.source for c in captures([str(n) for n in names], None, str(out))}


@pytest.fixture
def ledger(tmp_path):
    made = Ledger(str(tmp_path))
    yield made
    made.close()


# IN


def test_a_folder_is_searched_with_all_in_it(tmp_path):
    tree(tmp_path, "a.pcap", "b/c.PCAPNG", "b/d/e.pcap.gz", "b/f.pcap.zst", "b/notes.txt", "g.cap")
    assert found(tmp_path) == {name: f"{tmp_path}/{path}" for name, path in {
        "a": "a.pcap", "b/c": "b/c.PCAPNG", "b/d/e": "b/d/e.pcap.gz", "b/f": "b/f.pcap.zst", "g": "g.cap"}.items()}


def test_what_is_in_out_is_no_input(tmp_path):
    tree(tmp_path, "a.pcap", "out/b.pcap", "out2/c.pcap")
    assert set(found(tmp_path, out=tmp_path / "out")) == {"a", "out2/c"}


def test_a_capture_that_is_named_may_have_any_ending(tmp_path):
    tree(tmp_path, "drive", "b.dump")
    assert set(found(tmp_path / "drive", tmp_path / "b.dump")) == {"drive", "b"}


def test_a_name_without_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tree(tmp_path, "a.pcap"))
    assert found("a.pcap") == {"a": f"{tmp_path}/a.pcap"}


@pytest.mark.parametrize("pattern, names", [
    ("*.pcap", {"a"}), ("**/*.pcap", {"a", "x/b", "x/y/c"}), ("x/?.pcap", {"b"}), ("x*", {"x/b", "x/y/c"}),
    ("[xz]/*/c.pcap", {"x/y/c"}), ("[!x].pcap", {"a"}), ("*", {"a", "x/b", "x/y/c", "n.txt"[:-4]})])
def test_a_pattern_keeps_the_folders_behind_its_fixed_part(tmp_path, pattern, names):
    tree(tmp_path, "a.pcap", "x/b.pcap", "x/y/c.pcap", "n.txt")
    assert set(found(tmp_path / pattern)) == names


def test_a_file_whose_name_is_a_pattern_is_this_file(tmp_path):
    tree(tmp_path, "a[1].pcap", "a1.pcap")
    assert set(found(tmp_path / "a[1].pcap")) == {"a[1]"}


@pytest.mark.parametrize("name", ["none.pcap", "none-*.pcap", "empty", "nowhere/*.pcap"])
def test_a_name_without_a_capture_is_refused(tmp_path, name):
    (tmp_path / "empty").mkdir()
    with pytest.raises(FleetError, match=re.escape(name)) as refused:
        found(tmp_path / name)
    assert not isinstance(refused.value, Usage)


def test_a_sensor_is_no_capture():
    with pytest.raises(FleetError, match="lumdump") as refused:
        found("udp://10.42.0.37")
    assert isinstance(refused.value, Usage)


def test_a_link_to_a_folder_above_is_not_followed(tmp_path):
    tree(tmp_path, "x/a.pcap")
    (tmp_path / "x/loop").symlink_to(tmp_path)
    assert set(found(tmp_path)) == {"x/a"}


def test_endings():
    assert [stem(n) for n in ("a.pcap", "a.b.pcapng.gz", "a.tar", ".hidden", "x/a.cap.zst")] == \
        ["a", "a.b", "a", ".hidden", "x/a"]
    assert re.fullmatch(translate("a.+[]x"), "a.+[]x")


# What is to be done


def plan(ledger, tmp_path, *names):
    tree(tmp_path / "in", *names)
    ledger.plan(captures([str(tmp_path / "in")], None, ""), "ply")


def row(tmp_path, name="a", **other):
    info = os.stat(tmp_path / "in" / f"{name}.pcap")
    return {"output": f"{name}.ply", "source": str(tmp_path / "in" / f"{name}.pcap"), "size": info.st_size,
            "stamp": f"mtime:{info.st_mtime_ns}", "digest": "abc", "options": "{}", "version": "0", "status": "done",
            "message": "", "output_size": 7, "seconds": 1.0, **other}


def test_two_captures_of_one_name_are_refused(ledger, tmp_path):
    with pytest.raises(FleetError, match=r"a\.pcap(ng)? and .*a\.pcap(ng)? would both be a\.ply") as refused:
        plan(ledger, tmp_path, "a.pcap", "a.pcapng")
    assert isinstance(refused.value, Usage)


def test_a_capture_that_is_named_twice_is_one(ledger, tmp_path):
    plan(ledger, tmp_path, "a.pcap")
    ledger.plan(captures([str(tmp_path / "in" / "a.pcap")], None, ""), "ply")
    assert ledger.totals().captures == 1


@pytest.mark.parametrize("changes, there, pending", [
    ({}, 7, False), ({}, None, True), ({}, 8, True), ({"status": "failed"}, 7, True), ({"options": "{1}"}, 7, True),
    ({"size": 1}, 7, True), ({"version": "other"}, 7, False)])
def test_only_what_is_missing_or_has_changed(ledger, tmp_path, changes, there, pending):
    plan(ledger, tmp_path, "a.pcap")
    ledger.put(row(tmp_path, **changes))
    ledger.see([Entry("a.ply", there, "")] if there is not None else [])
    ledger.compare("{}", again=False)
    assert [task.digest for task in ledger.tasks()] == ([""] if pending else [])


def test_a_new_stamp_is_looked_into(ledger, tmp_path):
    plan(ledger, tmp_path, "a.pcap")
    ledger.put(row(tmp_path, stamp="mtime:1"))
    ledger.see([Entry("a.ply", 7, "")])
    ledger.compare("{}", again=False)
    assert [task.digest for task in ledger.tasks()] == ["abc"]


def test_again_is_all(ledger, tmp_path):
    plan(ledger, tmp_path, "a.pcap")
    ledger.put(row(tmp_path))
    ledger.see([Entry("a.ply", 7, "")])
    ledger.compare("{}", again=True)
    assert ledger.totals().pending == 1


def test_an_output_of_another_capture_is_not_replaced(ledger, tmp_path):
    plan(ledger, tmp_path, "a.pcap")
    ledger.put(row(tmp_path, source="/elsewhere/a.pcap"))
    ledger.see([Entry("a.ply", 7, "")])
    with pytest.raises(FleetError, match="was made of /elsewhere/a.pcap"):
        ledger.compare("{}", again=False)


def test_the_largest_come_first(ledger, tmp_path):
    plan(ledger, tmp_path, "a.pcap", "longer.pcap", "z.pcap")
    assert [task.output for task in ledger.tasks()] == ["longer.ply", "a.ply", "z.ply"]


# Names that are no text

NAMES = ["a\udcff.pcap", "a\\xff.pcap", "a\\x5cxff.pcap", "a\\\udcff.pcap", "a\\x5c.pcap", "\udc80\\x80\\.pcap", "a\\ud800.pcap", "C:\\xa.pcap",
         "ä.pcap", "\\x5\udc80"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_comes_back_from_its_text(name):
    text = to_text(name)
    assert text.encode().decode() == text and to_name(text) == name
    assert to_text("drives\\2026/a.pcap") == "drives\\2026/a.pcap"


def test_names_that_differ_have_texts_that_differ():
    assert len({to_text(name) for name in NAMES}) == len(NAMES)


def test_a_surrogate_that_is_no_byte_is_text_too():
    assert to_text("a\ud800") == "a\\ud800" and to_name("a\\ud800") == "a\ud800"


def test_names_that_are_no_text_are_planned_and_kept(ledger, tmp_path):
    (tmp_path / "in").mkdir()
    names = [b"a\xff.pcap", rb"a\xff.pcap", b"a\xfe.pcap"]
    for name in names:
        (pathlib.Path(tmp_path, "in") / os.fsdecode(name)).write_bytes(b"x")
    ledger.plan(captures([str(tmp_path / "in")], None, "/nowhere"), "ply")
    tasks = list(ledger.tasks())
    assert {os.fsencode(os.path.basename(task.source)) for task in tasks} == set(names)
    assert {os.fsencode(task.output) for task in tasks} == {name.replace(b"pcap", b"ply") for name in names}
    # What a run writes is found by the next one.
    out = Local(str(tmp_path / os.fsdecode(b"out\xfe")))
    journal = _journal.Journal(out, "run")
    for task in tasks:
        journal.add({"status": "done", "options": "{}", "output_size": 7, "digest": "d", "output": to_text(task.output), "source": to_text(task.source), "stamp": task.stamp, "size": 1})
        out.write(out.name_of(task.output), b"seven b")
    journal.close()
    for record in _journal.earlier(out):
        ledger.put(record)
    _manifest.write(out, ledger.rows(), str(tmp_path), ".lumfleet/parts/m")
    assert [r["output"] for r in _manifest.read(out)] == [r"a\x5cxff.ply", r"a\xfe.ply", r"a\xff.ply"]
    for record in _manifest.read(out):
        ledger.put(record)
    ledger.see(out.outputs(apart=out.where(".lumfleet")))
    ledger.compare("{}", again=False)
    assert ledger.totals().pending == 0


# The manifest and the journal


def test_a_manifest_is_read_as_it_was_written(tmp_path):
    out = Local(str(tmp_path / "out"))
    rows = [{"output": f"{n:06}.ply", "source": "s", "size": n, "points": n, "status": "done", "seconds": 0.5} for n in range(25_000)]
    _manifest.write(out, iter(rows), str(tmp_path), ".lumfleet/parts/m")
    again = list(_manifest.read(out))
    assert [{name: value for name, value in r.items() if value is not None} for r in again] == rows
    assert [p.name for p in pathlib.Path(out.url).rglob("*") if p.is_file()] == ["manifest.parquet"]


def test_a_manifest_has_texts_and_numbers_of_all_kinds(tmp_path):
    out = Local(str(tmp_path / "out"))
    rows = [{"output": r"a\xff", "source": "\u00f6\U0001f697", "stamp": "2024-01-01T00:00:00Z", "options": '{"a": "b\\n"}',
             "message": 'two\nlines\t"', "size": 2**63 - 1, "truncated": True, "seconds": 3, "of_another_version": {"x": [1]}},
            {"output": "b", "points": -1, "truncated": False, "message": "2024-01-01", "digest": "1", "seconds": 0.001}]
    _manifest.write(out, iter(rows), str(tmp_path), ".lumfleet/parts/m")
    names = _manifest.schema().names
    assert list(_manifest.read(out)) == [{name: row.get(name) for name in names} for row in rows]


def test_what_many_captures_do_not_need_is_not_imported(tmp_path):
    script = """
import sys
from lumsdk.fleet import _local, _manifest, main
from lumsdk.fleet._places import Local
assert not {"numpy", "pyarrow", "ray"} & set(sys.modules)
_manifest.write(Local(sys.argv[1]), [{"output": "a", "seconds": 0.5}], sys.argv[1], ".lumfleet/parts/m")
assert "pandas" not in sys.modules
"""
    package = str(pathlib.Path(lumsdk.__file__).parents[1])
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "out")], check=True, env={**os.environ, "PYTHONPATH": package})


def test_a_manifest_that_is_none_is_named(tmp_path):
    (tmp_path / "manifest.parquet").write_text("text")
    with pytest.raises(FleetError, match="manifest.parquet: cannot be read"):
        list(_manifest.read(Local(str(tmp_path))))


def test_a_journal_is_read_up_to_where_it_was_cut(tmp_path):
    out = Local(str(tmp_path))
    journal = _journal.Journal(out, "run")
    for n in range(3):
        journal.add({"output": str(n)})
    path = tmp_path / ".lumfleet/journal/run.jsonl"
    whole = path.read_bytes()
    assert whole.count(b"\n") == 3
    journal.close()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        outputs = [r["output"] for r in _journal.earlier(out)]
        assert outputs == [str(n) for n in range((length + 1) // (len(whole) // 3))]
    out.remove_folder(_journal.FOLDER)
    assert list(_journal.earlier(out)) == []


def test_later_runs_say_last_what_became_of_a_capture(tmp_path):
    out = Local(str(tmp_path))
    for run in ("20260102", "20260101"):
        journal = _journal.Journal(out, run)
        journal.add({"run": run})
        journal.close()
    assert [r["run"] for r in _journal.earlier(out)] == ["20260101", "20260102"]


# One run at a time


def test_a_second_run_is_refused(tmp_path):
    out = Local(str(tmp_path))
    held = lock(out, "one")
    with pytest.raises(FleetError, match="another lumfleet"):
        lock(out, "two")
    held.release()
    lock(out, "three").release()


def test_a_lease_holds_while_its_process_lives(tmp_path):
    out = Local(str(tmp_path))
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        held = {"run": "x", "host": os.uname().nodename, "pid": other.pid, "time": 9e12}
        out.write(".lumfleet/lease.json", json.dumps(held).encode())
        with pytest.raises(FleetError, match=f"process {other.pid}"):
            Lease(out, "y")
        other.communicate()
    Lease(out, "y").release()
    assert out.entry(".lumfleet/lease.json") is None


@pytest.mark.parametrize("seconds, is_held", [(0, True), (61, False)])
def test_a_lease_of_another_machine_ends_by_itself(tmp_path, seconds, is_held, monkeypatch):
    monkeypatch.setattr("time.time", lambda: 1000.0)
    out = Local(str(tmp_path))
    out.write(".lumfleet/lease.json", json.dumps({"run": "x", "host": "elsewhere", "pid": 1, "time": 1000.0 - seconds}).encode())
    if is_held:
        with pytest.raises(FleetError, match="of elsewhere"):
            Lease(out, "y")
    else:
        Lease(out, "y").release()


OTHER = {"run": "other", "host": "elsewhere", "pid": 7, "time": 9e12}


@pytest.mark.parametrize("text, sentence", [
    (json.dumps(OTHER), "another lumfleet took it over, process 7 of elsewhere"), (None, "lease.json was removed")])
def test_a_lease_that_another_run_took_is_noticed_and_left(tmp_path, monkeypatch, text, sentence):
    monkeypatch.setattr("lumsdk.fleet._lock.RENEW_S", 0.01)
    out = Local(str(tmp_path))
    held = Lease(out, "one")
    held.check(again=True)
    path = tmp_path / ".lumfleet/lease.json"
    if text is None:
        out.remove(".lumfleet/lease.json")
    else:
        out.write(".lumfleet/lease.json", text.encode())
    held._thread.join(support.LONG_S)  # it ends when it has looked
    with pytest.raises(FleetError, match=sentence):
        held.check()
    held.release()
    assert path.read_text() == text if text else not path.exists()


def test_a_run_whose_lease_was_taken_stops_and_leaves_the_other_s_files(tmp_path, monkeypatch):
    tree(tmp_path, "in/a.pcap")
    options = _arguments.parse([str(tmp_path / "in"), "--out", str(tmp_path / "out"), "--format", "ply"])
    run = main.Run(options, _arguments.job(options, "run", "0"), main.Signals())
    others = {".lumfleet/run": "other", ".lumfleet/parts/other-1/made": "part", ".lumfleet/lease.json": json.dumps(OTHER)}

    def taken(self, *_):
        for name, text in others.items():
            self._out.write(name, text.encode())
        self._held._thread.join(support.LONG_S)
        self._tick(None)
        raise AssertionError("it went on")
    monkeypatch.setattr("lumsdk.fleet._lock.RENEW_S", 0.01)
    monkeypatch.setattr(main, "lock", Lease)
    monkeypatch.setattr(main.Run, "_by_workers", taken)
    try:
        run.plan()
        with pytest.raises(FleetError, match="took it over") as refused:
            run.convert()
    finally:
        run.close()
    assert not isinstance(refused.value, Usage)
    left = {str(p.relative_to(tmp_path / "out")): p.read_text() for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert left.pop(".lumfleet/reserve", "") is not None and left == others


def test_a_dead_process_s_folder_is_removed_by_the_next(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    script = "import tempfile, sys, os\nfrom lumsdk.fleet._folders import WorkFolder\nw = WorkFolder()\nprint(w.path)\n" \
             "sys.stdout.flush()\nos.kill(os.getpid(), 9)"
    left = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                          env={**os.environ, "TMPDIR": str(tmp_path)}).stdout.strip()
    assert os.path.isdir(left)
    mine = _folders.WorkFolder()
    assert not os.path.exists(left)
    other = _folders.WorkFolder()
    assert os.path.isdir(mine.path)
    mine.remove()
    other.remove()
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_made_just_now_is_not_removed(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    lock = _folders._lock

    def lock_late(file):
        monkeypatch.setattr(_folders, "_lock", lock)
        _folders.remove_dead()
        return lock(file)

    monkeypatch.setattr(_folders, "_lock", lock_late)
    mine = _folders.WorkFolder()
    assert os.path.isdir(mine.path)
    _folders.remove_dead()
    assert os.path.isdir(mine.path)
    mine.remove()


# Arguments


@pytest.mark.parametrize("arguments, sentence", [
    ([], "no captures are named"),
    (["a"], "--out is needed"),
    (["a", "--out", "o"], "--format is needed: one of parquet"),
    (["a", "--out", "o", "--format", "doc"], "'doc' is not known: one of parquet"),
    (["a", "--out", "o", "--format", "ply", "--jobs", "0"], "'0' is not a number from 1"),
    (["a", "--out", "o", "--form", "ply"], "--form"),
    (["a", "--out", "o", "--format", "ply", "--laser"], "--laser"),
])
def test_arguments_that_are_refused(arguments, sentence):
    with pytest.raises(FleetError, match=sentence) as refused:
        _arguments.parse(arguments)
    assert isinstance(refused.value, Usage)


@pytest.mark.parametrize("arguments, sentence", [
    (["--return", "many"], "--return: 'many' is not all, first"),
    (["--set", "a=1"], "--set: 'a' is not a key"),
    (["--calibration", "none.yaml"], "--calibration: none.yaml: cannot be read"),
    (["--rig", "none.yaml"], "--rig: none.yaml: cannot be read"),
    (["--columns", "x", "--format", "las"], "--columns goes with csv"),
    (["--ascii", "--format", "parquet"], "--ascii does not go with parquet"),
    (["--preset", "argoverse2"], "--preset does not go with ply"),
])
def test_values_are_refused_with_lumdump_s_sentence(arguments, sentence):
    options = _arguments.parse(["a", "--out", "o", "--format", "ply", *arguments])
    with pytest.raises(FleetError, match=re.escape(sentence)) as refused:
        _arguments.job(options, "run", "0")
    assert isinstance(refused.value, Usage)


def test_options_are_told_with_what_is_in_their_files(tmp_path):
    calibration = tmp_path / "c.yaml"
    texts = []
    for name in ("a", "b"):
        calibration.write_text(f"# {name}\ntof_lsb_ps: 12.9\n")
        options = _arguments.parse(["x", "--out", "o", "--format", "ply", "--calibration", str(calibration), "--return", "last"])
        job = _arguments.job(options, "run", "0")
        texts.append(job.options)
        assert job.arguments == ("--return", "last", "--calibration", "c.yaml")
        assert job.files == {"c.yaml": calibration.read_bytes()}
    assert texts[0] != texts[1]
    assert json.loads(texts[0])["return"] == "last"


def test_a_rig_is_sent_with_its_files(tmp_path):
    (tmp_path / "c.yaml").write_text("tof_lsb_ps: 12.9\n")
    rig = tmp_path / "vehicle.yaml"
    texts = []
    for x in (1, 2):
        rig.write_text(f"version: 1\nsensors:\n  - {{name: front, address: 10.42.0.37, calibration: c.yaml, pose: {{x_m: {x}}}}}\n")
        options = _arguments.parse(["x", "--out", "o", "--format", "npy", "--rig", str(rig)])
        job = _arguments.job(options, "run", "0")
        texts.append(job.options)
        assert job.arguments == ("--rig", "rig.yaml") and job.keywords == {"rig": "rig.yaml"}
        assert list(job.files) == ["rig-front-calibration.yaml", "rig.yaml"]
    assert texts[0] != texts[1] and json.loads(texts[0])["rig"]["name"] == "vehicle.yaml"
    for name, data in job.files.items():
        (tmp_path / name).write_bytes(data)
    assert lumsdk.Rig(tmp_path / "rig.yaml") == lumsdk.Rig(rig)


def test_help_has_every_option():
    parser_text = pathlib.Path(_arguments.__file__).read_text()
    for name in (*_arguments.VALUES, *_arguments.FLAGS, *_arguments.FILES, *_arguments.OF_CONVERT, "rig", "out", "jobs", "address"):
        assert f"--{name}" in _arguments.HELP
    assert all(len(line) < 80 for line in _arguments.HELP.splitlines())
    assert "--retries" in parser_text


# Words


def test_sizes_and_times_for_people():
    assert [_summary.size(n) for n in (0, 999, 1000, 99_949, 99_960, 5e9, 2e15)] == \
        ["0 B", "999 B", "1.0 kB", "99.9 kB", "100 kB", "5.0 GB", "2.0 PB"]
    assert [_summary.span(n) for n in (0.4, 99, 100, 3600, 90000)] == ["0 s", "99 s", "1 min 40 s", "1 h 00 min", "25 h 00 min"]


def test_places_by_name(tmp_path):
    assert place(f"file://{tmp_path}").url == str(tmp_path)
    with pytest.raises(FleetError, match="not a protocol"):
        place("ftpx://there/x")
