"""Captures, lumfleet as a program, and a Ray cluster of several nodes on this machine."""
from __future__ import annotations

import atexit
import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

TOP = pathlib.Path(__file__).resolve().parents[3]
BIN = pathlib.Path(os.environ.get("LUM_BIN", TOP / "build/release/bin"))
PACKAGE = BIN.parent / "python"
OBJECT_STORE = 80 << 20  # the least that Ray takes, and a little
LONG_S = 600  # for what should take seconds: a machine can be busy
DAMAGED = "not a capture (it does not begin like one); a pcap, pcapng, MCAP or bag file is expected"

os.environ.setdefault("RAY_AUTH_MODE", "token")
os.environ.setdefault("RAY_AUTH_TOKEN", "0" * 64)
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"

# lumdump with a gate: while there is a folder of tickets, each conversion takes one and waits if there is none.
GATE = pathlib.Path(tempfile.mkdtemp(prefix="lumfleet-gate-"))
TICKETS = GATE / "tickets"
(GATE / "lumdump").write_text(f"""#!/bin/sh
while [ "$1" != /dev/null ] && [ -d {TICKETS} ]; do
    for ticket in {TICKETS}/*; do
        rm "$ticket" 2>/dev/null && break 2
    done
    sleep 0.02
done
exec {BIN}/lumdump "$@"
""")
(GATE / "lumdump").chmod(0o755)
atexit.register(shutil.rmtree, GATE, ignore_errors=True)
os.environ["LUM_BIN"] = str(GATE)
if str(PACKAGE) not in sys.path:
    sys.path.insert(0, str(PACKAGE))
os.environ["PYTHONPATH"] = os.pathsep.join([str(PACKAGE), *filter(None, [os.environ.get("PYTHONPATH")])])


def run_tool(name, *arguments):
    return subprocess.run([BIN / name, *map(str, arguments)], capture_output=True, text=True, check=True, timeout=LONG_S)


def make_captures(folder):
    """A few small ones: two seeds, whole and short."""
    folder = pathlib.Path(folder)
    made = []
    for seed in (1, 2):
        whole = folder / f"seed{seed}.pcap"
        run_tool("lumsim", "-q", "-o", whole, "--frames", 1, "--lines", 64, "--seed", seed)
        for part, seconds in enumerate((0.004, 0.02)):
            short = folder / f"seed{seed}-{part}.pcap"
            run_tool("lumdump", "-q", whole, "--duration", seconds, "-o", short)
            made.append(short)
        whole.unlink()
    return made


def make_fleet(folder, count, damaged, seed=1):
    """Many captures, by links, in folders; some are no captures. Their names by whether they are whole."""
    folder = pathlib.Path(folder)
    with tempfile.TemporaryDirectory(dir=folder.parent) as made:
        kinds = make_captures(made)
        bad = set(random.Random(seed).sample(range(count), damaged))
        names = {}
        for n in range(count):
            path = folder / f"car{n % 7}" / f"drive{n:05}.pcap"
            path.parent.mkdir(parents=True, exist_ok=True)
            if n in bad:
                path.write_bytes(b"This is not what a sensor sends. " * 20)
            else:
                os.link(kinds[n % len(kinds)], path)
            names[str(path.relative_to(folder).with_suffix(""))] = n not in bad
    return names


def command(*arguments):
    return [sys.executable, "-B", "-m", "lumsdk.fleet.main", *map(str, arguments)]


def lumfleet(*arguments, **options):
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=LONG_S, **options)


@contextlib.contextmanager
def started(*arguments):
    """lumfleet under way."""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command(*arguments), stdout=said, stderr=subprocess.STDOUT, text=True)
        process.said = lambda: (said.seek(0), said.read())[1]
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()


def until(what, true, process=None):
    """Waits for something to be seen."""
    end = time.monotonic() + LONG_S
    while not true():
        if process is not None and process.poll() is not None and not true():
            raise AssertionError(f"{what} did not come, lumfleet ended: {process.said()}")
        if time.monotonic() > end:
            raise AssertionError(f"{what} did not come")
        time.sleep(0.01)


def rows(out):
    """The manifest without what differs from run to run."""
    import pyarrow.parquet as pq

    table = pq.read_table(out if hasattr(out, "read") else pathlib.Path(out) / "manifest.parquet")
    return table.drop_columns(["seconds"]).to_pylist()


def moved(table, old, new):
    """Rows as if OUT had another name."""
    return json.loads(json.dumps(table).replace(str(old), str(new)))


def outputs(out):
    """Names and bytes of what was made; anything left over is in it."""
    out = pathlib.Path(out)
    return {str(p.relative_to(out)): p.read_bytes() for p in out.rglob("*") if p.is_file()
            and p.name != "manifest.parquet" and p != out / ".lumfleet" / "lock"}


class Nodes:
    """A cluster of nodes with one processor each, without the work of the head."""

    def __init__(self, count):
        from ray.cluster_utils import Cluster

        # A short name: Ray's sockets are below it.
        self.folder = tempfile.mkdtemp(prefix="lfc-", dir="/tmp")
        os.environ["RAY_TMPDIR"] = self.folder
        os.mkdir(os.path.join(self.folder, "ray"))
        self._cluster = Cluster(initialize_head=True, connect=False, head_node_args={
            "num_cpus": 0, "object_store_memory": OBJECT_STORE, "include_dashboard": False,
            "_system_config": {"automatic_object_spilling_enabled": False}})
        self.nodes = []
        for _ in range(count):
            self.add()
        self.address = self._cluster.address

    def add(self):
        self.nodes.append(self._cluster.add_node(num_cpus=1, object_store_memory=OBJECT_STORE, wait=False))

    def kill_node(self, at):
        self._cluster.remove_node(self.nodes.pop(at), allow_graceful=False)

    def ids(self):
        return [node.node_id for node in self.nodes]

    def raylets(self):
        return [info.process.pid for node in self.nodes
                for info in node.all_processes.get("raylet", [])]

    def workers(self):
        """The processes that convert."""
        return [pid for raylet in self.raylets() for pid in below(raylet) if "ray::Converter" in title(pid)]

    def close(self):
        self._cluster.shutdown()
        shutil.rmtree(self.folder, ignore_errors=True)


def title(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")
    except OSError:
        return ""


def below(pid):
    try:
        return [int(n) for task in os.listdir(f"/proc/{pid}/task")
                for n in pathlib.Path(f"/proc/{pid}/task/{task}/children").read_text().split()]
    except OSError:
        return []


def kill(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


class Gate:
    """Lets so many conversions begin; all of them, at its end."""

    def __enter__(self):
        TICKETS.mkdir()
        self._given = 0
        return self

    def give(self, count):
        """Returns when they are taken."""
        for _ in range(count):
            self._given += 1
            (TICKETS / str(self._given)).touch()
        until("every ticket's conversion", lambda: not os.listdir(TICKETS))

    def open(self):
        """Lets all others begin."""
        shutil.rmtree(TICKETS, ignore_errors=True)

    def __exit__(self, *_):
        self.open()


def held(nodes):
    """Workers that have a conversion under way."""
    return [pid for pid in nodes.workers() if below(pid)]


def disturb(nodes, gate, count, seed, faults=6):
    """Kills workers in the middle of a capture, and with every third one its node; chosen by the seed."""
    choice = random.Random(seed)
    for at in range(faults):
        gate.give(count // (faults + 2))
        until("a worker that converts", lambda: held(nodes))
        pid = choice.choice(sorted(held(nodes)) or [0])
        owner = next((n for n, raylet in enumerate(nodes.raylets()) if pid in below(raylet)), None)
        if at % 3 == 2 and owner is not None:
            nodes.kill_node(owner)
            nodes.add()
        elif pid:
            kill(pid)
