"""Captures and outputs in an object store: a real server, which the test starts."""
import os
import pathlib
import shutil
import socket
import subprocess
import time

import pytest
import support
from support import Gate, lumfleet, rows, started, until

SERVER = pathlib.Path(os.environ.get("LUM_S3_SERVER", support.TOP / "build/go/bin/versitygw"))
KEYS = {"AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "testsecret", "AWS_DEFAULT_REGION": "us-east-1"}
pytestmark = pytest.mark.skipif(not SERVER.exists(), reason="there is no versitygw: script/setup --all builds it")


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Store:
    """A server and its folder, in which buckets are folders."""

    def __init__(self, folder):
        self.folder = folder
        self.endpoint = f"http://127.0.0.1:{free_port()}"
        (folder / "captures").mkdir(parents=True)
        (folder / "clouds").mkdir()
        self._log = open(folder.parent / "server.log", "w")
        self._server = subprocess.Popen([SERVER, "--port", self.endpoint[7:], "posix", folder], stdout=self._log, stderr=self._log,
                                        env={**os.environ, "ROOT_ACCESS_KEY": "test", "ROOT_SECRET_KEY": "testsecret"})
        end = time.monotonic() + support.LONG_S
        while True:
            try:
                socket.create_connection(("127.0.0.1", int(self.endpoint.rpartition(":")[2]))).close()
                return
            except ConnectionError:
                assert time.monotonic() < end and self._server.poll() is None
                time.sleep(0.02)

    def keys(self, bucket):
        top = self.folder / bucket
        return {str(p.relative_to(top)): p.read_bytes() for p in top.rglob("*") if p.is_file() and ".sgwtmp" not in p.parts}

    def close(self):
        self._server.kill()
        self._server.wait()
        self._log.close()


@pytest.fixture(scope="module")
def s3nodes():
    """Nodes that know the store's keys."""
    os.environ.update(KEYS)
    cluster = support.Nodes(2)
    yield cluster
    cluster.close()


@pytest.fixture
def store(tmp_path, small):
    made = Store(tmp_path / "store")
    for n in range(8):
        path = made.folder / "captures" / f"car{n % 2}" / f"drive{n}.pcap"
        path.parent.mkdir(exist_ok=True)
        shutil.copy(small[n % len(small)], path)
    (made.folder / "captures/car1/bad.pcap").write_bytes(b"no capture" * 10)
    yield made
    made.close()


def run(store, nodes, *more):
    return ("s3://captures", "--out", "s3://clouds/made", "--format", "ply", "--endpoint", store.endpoint, "--address", nodes.address,
            *more)


def check(store, tmp_path):
    """Each output has the bytes that lumdump writes; nothing else is left in the bucket."""
    keys = store.keys("clouds")
    expected = {"made/manifest.parquet": keys["made/manifest.parquet"]}
    for path in (store.folder / "captures").rglob("drive*.pcap"):
        support.run_tool("lumdump", "-q", path, "-o", tmp_path / "expected.ply")
        name = path.relative_to(store.folder / "captures").with_suffix(".ply")
        expected[f"made/{name}"] = (tmp_path / "expected.ply").read_bytes()
    assert keys == expected
    table = rows(store.folder / "clouds/made")
    assert [r["status"] for r in table].count("done") == 8 and len(table) == 9
    bad = next(r for r in table if r["status"] == "failed")
    assert bad["source"] == "s3://captures/car1/bad.pcap"
    assert bad["message"] == f"{bad['source']}: {support.DAMAGED}"
    assert all(r["stamp"].startswith("etag:") for r in table)
    return table


def test_from_a_store_to_a_store(store, s3nodes, tmp_path):
    ended = lumfleet(*run(store, s3nodes, "-q"))
    assert ended.returncode == 1 and ended.stderr.count("\n") == 1, ended
    first = check(store, tmp_path)
    # Written again: one with the same bytes, one with others.
    same = store.folder / "captures/car0/drive0.pcap"
    shutil.copy(store.folder / "captures/car1/drive1.pcap", store.folder / "captures/car1/drive3.pcap")
    (store.folder / "clouds/made/car0/drive2.ply").unlink()
    ended = lumfleet(*run(store, s3nodes, "-q"))
    assert ended.returncode == 1, ended
    table = check(store, tmp_path)
    changed = [new["output"] for old, new in zip(first, table) if old != new]
    assert changed == ["car1/drive3.ply"] and same.exists()


def test_the_driver_is_killed_and_started_again(store, s3nodes, tmp_path):
    with Gate() as gate, started(*run(store, s3nodes, "-q")) as process:
        gate.give(4)
        until("an output", lambda: list((store.folder / "clouds/made").rglob("car*/*.ply")), process)
        until("a worker that converts", lambda: support.held(s3nodes), process)
        process.kill()
        process.wait(support.LONG_S)
        until("the end of the workers", lambda: not s3nodes.workers())
    assert "made/.lumfleet/lease.json" in store.keys("clouds")
    ended = lumfleet(*run(store, s3nodes, "-q"))
    assert ended.returncode == 1, ended
    check(store, tmp_path)


def test_a_second_run_is_refused(store, s3nodes):
    with Gate() as gate, started(*run(store, s3nodes, "-q")) as first:
        until("a conversion", lambda: support.held(s3nodes), first)
        second = lumfleet(*run(store, s3nodes))
        assert second.returncode == 1 and f"process {first.pid} of" in second.stderr
        gate.open()
        assert first.wait(support.LONG_S) == 1, first.said()


def test_a_store_without_the_bucket(store, s3nodes):
    ended = lumfleet("s3://captures", "--out", "s3://none/made", "--format", "ply", "--endpoint", store.endpoint, "--address",
                     s3nodes.address)
    assert ended.returncode == 1 and ended.stderr.startswith("lumfleet: ") and "Traceback" not in ended.stderr, ended
    ended = lumfleet("s3://none", "--out", "s3://clouds/made", "--format", "ply", "--endpoint", store.endpoint, "--address",
                     s3nodes.address)
    assert ended.returncode == 1 and "s3://none" in ended.stderr, ended


def test_from_a_store_to_a_folder(store, s3nodes, tmp_path):
    ended = lumfleet("s3://captures/car*/drive[01].pcap", "--out", tmp_path / "out", "--format", "csv", "--endpoint", store.endpoint,
                     "--address", s3nodes.address, "-q")
    assert ended.returncode == 0, ended
    assert sorted(support.outputs(tmp_path / "out")) == ["car0/drive0.csv", "car1/drive1.csv"]
