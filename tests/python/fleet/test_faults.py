"""Faults on a cluster of four nodes: the manifest and the outputs are the same as without."""
import os
import signal
import subprocess
import sys

import pytest
import support
from support import Gate, lumfleet, outputs, rows, started, until

COUNT = int(os.environ.get("LUM_FLEET_COUNT", "60"))
SEED = int(os.environ.get("LUM_FLEET_SEED", "7"))


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet") / "in"
    names = support.make_fleet(folder, COUNT, damaged=max(1, COUNT // 100))
    return folder, names


@pytest.fixture(scope="module")
def undisturbed(fleet, nodes, tmp_path_factory):
    """What a run without faults makes."""
    out = tmp_path_factory.mktemp("undisturbed")
    ended = lumfleet(fleet[0], "--out", out, "--format", "ply", "--address", nodes.address, "-q")
    assert ended.returncode == 1 and "not a capture" in ended.stderr, ended
    return out


def check(out, undisturbed, fleet):
    assert rows(out) == rows(undisturbed)
    assert outputs(out) == outputs(undisturbed)
    assert {row["output"][:-4]: row["status"] == "done" for row in rows(out)} == fleet[1]


def run(fleet, nodes, out):
    return started(fleet[0], "--out", out, "--format", "ply", "--address", nodes.address, "-q")


def test_a_manifest_has_what_each_capture_gave(fleet, undisturbed):
    folder, names = fleet
    for row in rows(undisturbed):
        if names[row["output"][:-4]]:
            assert (row["status"], row["message"]) == ("done", "")
            assert row["points"] > 1000 and row["frames"] == 1
            assert row["output_size"] == (undisturbed / row["output"]).stat().st_size
        else:
            assert row["status"] == "failed" and row["points"] is None
            assert row["message"] == f"{row['source']}: {support.DAMAGED}"


def test_workers_and_nodes_are_killed_at_random(fleet, nodes, undisturbed, tmp_path):
    with Gate() as gate, run(fleet, nodes, tmp_path) as process:
        support.disturb(nodes, gate, COUNT, SEED)
        gate.open()
        process.wait(support.LONG_S)
        assert process.returncode == 1, process.said()
    check(tmp_path, undisturbed, fleet)


FILL = """
import sys, ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy
ray.init(address=sys.argv[1], logging_level="ERROR", log_to_driver=False)
@ray.remote(num_cpus=0)
class Filler:
    def fill(self):
        self.kept = []
        for size in (8 << 20, 1 << 20, 1 << 16):
            try:
                for _ in range(100):
                    self.kept.append(ray.put(bytes(size)))
                return "never full"
            except ray.exceptions.ObjectStoreFullError:
                pass
        return "full"
fillers = [Filler.options(scheduling_strategy=NodeAffinitySchedulingStrategy(node, soft=False)).remote()
           for node in sys.argv[2:]]
print("found", *set(ray.get([filler.fill.remote() for filler in fillers])), flush=True)
sys.stdin.read()
"""


def test_the_object_store_is_full(fleet, nodes, undisturbed, tmp_path):
    filler = subprocess.Popen([sys.executable, "-c", FILL, nodes.address, *nodes.ids()], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE, text=True)
    try:
        found = next(line for line in filler.stdout if line.startswith("found"))
        assert found == "found full\n"
        ended = lumfleet(fleet[0], "--out", tmp_path, "--format", "ply", "--address", nodes.address, "-q")
    finally:
        filler.kill()
        filler.wait()
    assert ended.returncode == 1, ended
    check(tmp_path, undisturbed, fleet)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_the_driver_is_ended_and_started_again(fleet, nodes, undisturbed, tmp_path, number):
    with Gate() as gate, run(fleet, nodes, tmp_path) as process:
        gate.give(COUNT // 3)
        until("a worker that converts", lambda: support.held(nodes), process)
        process.send_signal(number)
        process.wait(support.LONG_S)
        assert process.returncode == -number, process.said()
        until("the end of the workers", lambda: not nodes.workers())
    made = {path: path.stat().st_ino for path in tmp_path.rglob("*.ply") if ".lumfleet" not in path.parts}
    assert 0 < len(made) <= COUNT // 3
    if number == signal.SIGINT:
        known = {row["output"] for row in rows(tmp_path) if row["status"] == "done"}
        assert known <= {str(path.relative_to(tmp_path)) for path in made}
        assert not list((tmp_path / ".lumfleet").rglob("*.ply"))
    ended = lumfleet(fleet[0], "--out", tmp_path, "--format", "ply", "--address", nodes.address, "-q")
    assert ended.returncode == 1, ended
    check(tmp_path, undisturbed, fleet)
    # Only what was named in the moment of the end, and not noted, was made again.
    assert sum(path.stat().st_ino != inode for path, inode in made.items()) <= 4
