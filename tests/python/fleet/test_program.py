"""lumfleet as a program: what it prints, its exit status, second runs, a full disk, signals."""
import json
import os
import pty
import re
import shutil
import signal
import subprocess
import sys

import pytest
import support
from support import Gate, lumfleet, outputs, rows, started, until


@pytest.fixture
def drives(small, tmp_path):
    """Four captures in two folders."""
    for n, path in enumerate(small):
        target = tmp_path / "in" / f"day{n % 2}" / f"drive{n}.pcap"
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
    return tmp_path / "in"


def test_on_this_machine_alone(drives, tmp_path):
    """Without Ray; each output is what lumdump writes; nothing else is left."""
    (tmp_path / "ray.py").write_text("raise AssertionError('Ray is for clusters')")
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    out = tmp_path / "out"
    ended = lumfleet(drives, "--out", out, "--format", "csv", "--return", "last", "--jobs", "2",
                     env={**os.environ, "TMPDIR": str(temporary), "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ['PYTHONPATH']}"})
    assert (ended.returncode, ended.stderr) == (0, "")
    assert re.search(r"^4 captures, .* as csv$", ended.stdout, re.M)
    assert re.search(r"^  converted   4, .*GB/s.*captures/s with 2 workers$", ended.stdout, re.M)
    for path in drives.rglob("*.pcap"):
        expected = support.run_tool("lumdump", path, "-o", "-", "--format", "csv", "--return", "last").stdout
        assert (out / path.relative_to(drives).with_suffix(".csv")).read_text() == expected
    assert not [p for p in outputs(out) if not p.endswith(".csv")]
    assert not [p for p in temporary.rglob("*") if p.is_file()]
    for row in rows(out):
        said = json.loads(support.run_tool("lumdump", row["source"], "--json", "--return", "last").stdout)
        assert {name: row[name] for name in ("frames", "lines", "points", "records", "lost_words", "no_range")} == \
            {name: said[name] for name in ("frames", "lines", "points", "records", "lost_words", "no_range")}
        assert row["digest"] == subprocess.run(["sha256sum", row["source"]], capture_output=True, text=True).stdout.split()[0]
        assert json.loads(row["options"]) == {"format": "csv", "return": "last"}


def test_a_dry_run_writes_nothing(drives, tmp_path):
    arguments = (drives, "--out", tmp_path / "out", "--format", "ply", "--dry-run")
    ended = lumfleet(*arguments)
    assert ended.returncode == 0 and not (tmp_path / "out").exists()
    assert f"{drives}/day0/drive0.pcap -> {tmp_path}/out/day0/drive0.ply\n" in ended.stdout
    assert ended.stdout.splitlines()[-1].startswith("4 captures, ")
    said = json.loads(lumfleet(*arguments, "--json").stdout)
    assert (said["captures"], said["to_convert"], said["unchanged"]) == (4, 4, 0)
    assert said["bytes"] == sum(p.stat().st_size for p in drives.rglob("*.pcap"))


def test_a_second_run_does_only_what_is_missing_or_has_changed(drives, nodes, tmp_path):
    out = tmp_path / "out"

    def run(*more):
        ended = lumfleet(drives, "--out", out, "--format", "ply", "--jobs", "2", "--address", nodes.address, "--json", *more)
        said = json.loads(ended.stdout)
        assert ended.returncode == (1 if said["failed"] else 0), ended
        return said["converted"], said["unchanged"], said["failed"]

    assert run() == (4, 0, 0)
    first = rows(out)
    kept = {p: p.stat().st_ino for p in out.rglob("*.ply")}
    assert run() == (0, 4, 0)
    os.utime(drives / "day0/drive0.pcap", ns=(1, 1))  # written again with the same bytes
    (out / "day1/drive1.ply").unlink()
    assert run() == (1, 3, 0)
    assert [{**r, "stamp": ""} for r in rows(out)] == [{**r, "stamp": ""} for r in first]
    assert rows(out)[0]["stamp"] == "mtime:1"
    assert sum(p.stat().st_ino == inode for p, inode in kept.items()) == 3
    (drives / "day1/drive3.pcap").write_bytes(b"")
    (drives / "day1/new.pcap").write_bytes((drives / "day0/drive0.pcap").read_bytes())
    assert run() == (1, 3, 1)
    assert [r["message"] for r in rows(out) if r["status"] == "failed"] == \
        [f"{drives}/day1/drive3.pcap: is empty; a pcap, pcapng, MCAP or bag file is expected"]
    assert run("--eye", "blue") == (4, 0, 1)
    # Captures of another day are added to the same table.
    (tmp_path / "more").mkdir()
    shutil.copy(drives / "day0/drive0.pcap", tmp_path / "more/other.pcap")
    ended = lumfleet(tmp_path / "more", "--out", out, "--format", "ply", "--jobs", "2", "--address", nodes.address, "-q")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
    assert len(rows(out)) == 6
    # Another capture would take an output's name.
    shutil.copytree(drives / "day0", tmp_path / "again" / "day0")
    before = outputs(out)
    ended = lumfleet(tmp_path / "again", "--out", out, "--format", "ply", "--jobs", "2", "--address", nodes.address)
    assert ended.returncode == 2 and "was made of" in ended.stderr
    assert outputs(out) == before


def test_what_is_wrong_is_said_before_anything_begins(drives, tmp_path):
    shutil.copy(drives / "day0/drive0.pcap", drives / "day0/drive0.cap")
    out = tmp_path / "out"
    for arguments, status, sentence in (
            ((drives,), 2, "would both be day0/drive0.ply"), ((drives / "none",), 1, "none: no such capture"),
            ((drives, "--box", "1"), 2, "lumfleet: --box"), ((), 2, "no captures are named")):
        ended = lumfleet(*arguments, "--out", out, "--format", "ply")
        assert (ended.returncode, ended.stdout) == (status, ""), ended
        assert ended.stderr.startswith("lumfleet: ") and sentence in ended.stderr
        assert not out.exists()
    ended = lumfleet(drives / "day1", "--out", drives / "day1/drive1.pcap", "--format", "ply")
    assert ended.returncode == 2 and "is a file" in ended.stderr
    ended = lumfleet(drives / "day1", "--out", out, "--format", "ply", "--address", "127.0.0.1:1")
    assert ended.returncode == 1 and "127.0.0.1:1 cannot be reached" in ended.stderr


@pytest.mark.skipif(os.geteuid() != 0, reason="a small disk is mounted by root alone")
def test_a_full_disk_fails_what_does_not_fit(drives, nodes, tmp_path):
    """The others are made; when there is room the rest is, and all is as it would have been."""
    out = tmp_path / "small"
    out.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", out], check=True)
    try:
        for n in range(4):
            os.link(drives / "day0/drive0.pcap", drives / f"few{n}.pcap")
        arguments = (drives, "--out", out, "--format", "ply", "--jobs", "2", "--address", nodes.address, "-q")
        ended = lumfleet(*arguments)
        assert ended.returncode == 1, ended
        status = {r["output"]: r["status"] for r in rows(out)}
        failed = [r for r in rows(out) if r["status"] == "failed"]
        assert len(status) == 8 and 0 < len(failed) < 8
        assert all("No space left on device" in r["message"] for r in failed)
        assert {p for p in outputs(out)} == {name for name, s in status.items() if s == "done"}
        subprocess.run(["mount", "-o", "remount,size=60m", out], check=True)
        assert lumfleet(*arguments).returncode == 0
        got, made = rows(out), outputs(out)
        shutil.rmtree(out, ignore_errors=True)
        assert lumfleet(*arguments).returncode == 0
        assert (got, made) == (rows(out), outputs(out))
    finally:
        subprocess.run(["umount", out], check=True)


def test_another_run_in_the_same_folder_is_refused(drives, nodes, tmp_path):
    arguments = (drives, "--out", tmp_path / "out", "--format", "ply", "--jobs", "2", "--address", nodes.address, "-q")
    with Gate() as gate, started(*arguments) as first:
        until("a conversion", lambda: support.held(nodes), first)
        second = lumfleet(*arguments)
        assert second.returncode == 1 and "another lumfleet is writing to it" in second.stderr
        gate.open()
        assert first.wait(support.LONG_S) == 0, first.said()


def test_a_capture_that_kills_each_of_its_workers_is_given_up(drives, nodes, tmp_path):
    """A bounded number of times; the others are converted."""
    one = drives / "day0/drive0.pcap"
    with Gate() as gate, started(one, "--out", tmp_path / "out", "--format", "ply", "--jobs", "2", "--address", nodes.address, "--retries", "2",
                                 "--json") as process:
        for _ in range(3):
            until("its worker", lambda: support.held(nodes), process)
            pid, = support.held(nodes)
            support.kill(pid)
            until("its end", lambda: pid not in support.held(nodes))
        process.wait(support.LONG_S)
        gate.open()
    assert process.returncode == 1
    assert [r["message"] for r in rows(tmp_path / "out")] == \
        ["its worker or its machine died, 3 times; too little memory is the usual cause"]


def converting(process):
    """Workers of this machine that have a conversion under way."""
    return [pid for pid in support.below(process.pid) if support.below(pid)]


def test_a_worker_of_this_machine_dies(drives, tmp_path):
    """Another one makes its capture; one that kills each of its workers is given up."""
    with Gate() as gate, started(drives, "--out", tmp_path / "out", "--format", "ply", "--jobs", "2") as process:
        until("both workers", lambda: len(converting(process)) == 2, process)
        victim = converting(process)[0]
        lumdump = support.below(victim)
        support.kill(victim)
        until("the end of its lumdump", lambda: not any(support.title(pid) for pid in lumdump), process)
        until("another one", lambda: len(converting(process)) == 2, process)
        gate.open()
        assert process.wait(support.LONG_S) == 0, process.said()
        assert "its worker or its machine died; it is tried again" in process.said() and "retried     1" in process.said()
    assert [r["status"] for r in rows(tmp_path / "out")] == 4 * ["done"]
    with Gate() as gate, started(drives / "day0/drive0.pcap", "--out", tmp_path / "one", "--format", "ply", "--retries", "1") as process:
        for _ in range(2):
            until("its worker", lambda: converting(process), process)
            pid, = converting(process)
            support.kill(pid)
            until("its end", lambda: pid not in converting(process))
        assert process.wait(support.LONG_S) == 1, process.said()
    assert [r["message"] for r in rows(tmp_path / "one")] == \
        ["its worker or its machine died, 2 times; too little memory is the usual cause"]


def test_a_worker_that_cannot_begin_says_why(drives, tmp_path):
    out = tmp_path / "out"
    code = """
import sys
from lumsdk.fleet import _local, main
class Process(_local.Process):
    def __init__(self, job):
        super().__init__(type(job)(**{**job.__dict__, "run": "another"}))
_local.Process = Process
if __name__ == "__main__":
    sys.exit(main.main())
"""
    ended = subprocess.run([sys.executable, "-B", "-c", code, drives, "--out", out, "--format", "ply"], capture_output=True, text=True,
                           timeout=support.LONG_S)
    assert ended.returncode == 1 and f"does not see {out}" in ended.stderr, ended


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_no_worker_outlives_the_run(drives, tmp_path, number):
    """Ctrl-C of a terminal goes to all of its processes; only the driver acts on it, and writes the manifest."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    out = tmp_path / "out"
    with Gate(), open(tmp_path / "said", "w+") as said:
        process = subprocess.Popen(support.command(drives, "--out", out, "--format", "ply", "--jobs", "2"), start_new_session=True,
                                   stdout=said, stderr=said, env={**os.environ, "TMPDIR": str(temporary)})
        until("both workers", lambda: len(converting(process)) == 2, process)
        pids = [pid for worker in converting(process) for pid in (worker, *support.below(worker))]
        os.killpg(process.pid, number)
        assert process.wait(support.LONG_S) == -number
        until("their end", lambda: not any(support.title(pid) for pid in pids))
        said.seek(0)
        assert "Traceback" not in said.read()
    if number == signal.SIGINT:
        assert rows(out) == [] and not outputs(out)
        assert not [p for p in temporary.rglob("*") if p.is_file()]
    assert lumfleet(drives, "--out", out, "--format", "ply", "--jobs", "2").returncode == 0
    assert len(outputs(out)) == 4


def test_ctrl_c_while_workers_begin(drives, tmp_path):
    """It is the terminal's, which sends it to workers too."""
    out = tmp_path / "out"
    with open(tmp_path / "said", "w+") as said:
        process = subprocess.Popen(support.command(drives, "--out", out, "--format", "ply", "--jobs", "2"), start_new_session=True,
                                   stdout=said, stderr=said)
        until("a worker", lambda: (out / ".lumfleet/run").exists() and len(support.below(process.pid)) > 1)
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(support.LONG_S) == -signal.SIGINT
        said.seek(0)
        assert "Traceback" not in said.read()


def test_workers_begin_with_ctrl_c_held(drives, tmp_path):
    code = """
import signal, sys
from multiprocessing import util
from lumsdk.fleet import main
held, spawn = [], util.spawnv_passfds
def noted(*arguments):
    held.append(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))
    return spawn(*arguments)
util.spawnv_passfds = noted
if __name__ == "__main__":
    status = main.main()
    print(held)
    sys.exit(status)
"""
    ended = subprocess.run([sys.executable, "-B", "-c", code, drives, "--out", tmp_path / "out", "--format", "ply", "--jobs", "1", "-q"],
                           capture_output=True, text=True, timeout=support.LONG_S)
    assert ended.stdout == "[True, True]\n", ended  # Python's own helper, and the worker


def test_ctrl_c_before_the_first_capture(drives, tmp_path):
    """While workers begin."""
    out = tmp_path / "out"
    with started(drives, "--out", out, "--format", "ply") as process:
        until("the begin", lambda: (out / ".lumfleet/run").exists(), process)
        process.send_signal(signal.SIGINT)
        assert process.wait(support.LONG_S) == -signal.SIGINT, process.said()
        assert "Traceback" not in process.said()
    assert all(r["status"] == "done" for r in rows(out))


def test_a_signal_as_soon_as_the_run_has_begun(drives, tmp_path):
    """The manifest is written all the same."""
    code = """
import os, signal, sys
from lumsdk.fleet import main
class Run(main.Run):
    def _reserve(self):
        os.kill(os.getpid(), signal.SIGINT)
        super()._reserve()
main.Run = Run
sys.exit(main.main())
"""
    ended = subprocess.run([sys.executable, "-B", "-c", code, drives, "--out", tmp_path / "out", "--format", "ply"],
                           capture_output=True, text=True, timeout=support.LONG_S)
    assert ended.returncode == -signal.SIGINT, ended.stderr
    assert rows(tmp_path / "out") == []
    assert not (tmp_path / "out/.lumfleet/run").exists()


def test_progress_on_a_terminal_alone(drives, nodes, tmp_path):
    main, other = pty.openpty()
    process = subprocess.Popen(support.command(drives, "--out", tmp_path / "out", "--format", "ply", "--jobs", "2", "--address", nodes.address),
                               stdout=subprocess.PIPE, stderr=other, text=True)
    os.close(other)
    shown = b""
    with process:
        while True:
            try:
                data = os.read(main, 4096)
            except OSError:
                break
            if not data:
                break
            shown += data
        assert process.wait(support.LONG_S) == 0
    os.close(main)
    assert re.search(rb"\r\d of 4 captures, .* GB/s", shown)
    assert shown.split(b"\r")[-1].strip() == b""


def test_help_and_version():
    ended = lumfleet("--help")
    assert ended.returncode == 0 and ended.stdout.startswith("Usage: lumfleet IN... --out OUT")
    ended = lumfleet("--version")
    assert re.fullmatch(r"lumfleet \d+\.\d+\.\d+\n", ended.stdout)


def test_the_manual_has_every_option():
    manual = (support.TOP / "docs/man/lumfleet.1").read_text()
    for name in re.findall(r"--([a-z-]+)", lumfleet("--help").stdout):
        assert re.search(r"\\-" + name.replace("-", r"\\-") + r"\b", manual), name


def test_names_that_are_no_text(small, tmp_path):
    """In a folder, on the command line, as OUT, and in a second run; one that only looks like another's text too."""
    folder = tmp_path / "in"
    folder.mkdir()
    for name in (b"a\xff.pcap", rb"a\xff.pcap"):
        shutil.copy2(small[0], folder / os.fsdecode(name))
    (folder / os.fsdecode(b"bad\xfe.pcap")).write_bytes(b"no capture" * 10)
    out = tmp_path / os.fsdecode(b"out\xfd")
    arguments = (folder, folder / os.fsdecode(b"a\xff.pcap"), "--out", out, "--format", "ply", "--jobs", "1")
    for done in ("converted   2,", "unchanged   2"):
        ended = lumfleet(*arguments)
        assert ended.returncode == 1 and done in ended.stdout, ended
        assert ended.stderr == f"lumfleet: {folder}/bad\\xfe.pcap: {support.DAMAGED}\n"
        assert rf"{tmp_path}/out\xfd/manifest.parquet" in ended.stdout
    assert [name for name in sorted(os.listdir(os.fsencode(out))) if name.endswith(b"ply")] == [rb"a\xff.ply", b"a\xff.ply"]
    with open(out / "manifest.parquet", "rb") as file:
        table = rows(file)
    assert [(row["output"], row["status"]) for row in table] == \
        [(r"a\x5cxff.ply", "done"), (r"a\xff.ply", "done"), (r"bad\xfe.ply", "failed")]
    assert rf"{folder}/a\xff.pcap -> {tmp_path}/out\xfd/a\xff.ply" in lumfleet(*arguments, "--again", "--dry-run").stdout
