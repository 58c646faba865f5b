"""lumsdk.ray: captures as a Dataset, on one machine and on a cluster of several nodes, and what is lost there."""
import contextlib
import gzip
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading

import pytest

ray = pytest.importorskip("ray", reason="Ray is not installed")
pytest.importorskip("pyarrow")
fsspec_local = pytest.importorskip("fsspec.implementations.local")

# The processes of Ray find the package by the same variable.
os.environ["PYTHONPATH"] = os.pathsep.join([str(pathlib.Path(__file__).parent), os.environ.get("PYTHONPATH", "")])

import lumsdk  # noqa: E402
import lumsdk.ray as lumray  # noqa: E402
import numpy as np  # noqa: E402
import pyarrow.fs  # noqa: E402
from failing_files import NETWORK, Failing  # noqa: E402

STORE_BYTES = 200_000_000
SYSTEM = {"health_check_period_ms": 500, "health_check_failure_threshold": 3}
XYZR = ("x", "y", "z", "range")


@contextlib.contextmanager
def ray_folder():
    """A short path, since those of sockets are in it."""
    folder = tempfile.mkdtemp(prefix="ray")
    before = os.environ.get("RAY_TMPDIR")
    os.environ["RAY_TMPDIR"] = folder
    try:
        yield folder
    finally:
        os.environ.pop("RAY_TMPDIR")
        if before is not None:
            os.environ["RAY_TMPDIR"] = before
        shutil.rmtree(folder, ignore_errors=True)


def set_up_data():
    context = ray.data.DataContext.get_current()
    context.enable_progress_bars = False
    context.execution_options.preserve_order = True


@pytest.fixture(scope="module")
def local():
    """Ray on this machine alone."""
    with ray_folder():
        ray.init(num_cpus=2, include_dashboard=False, object_store_memory=STORE_BYTES, logging_level="ERROR", log_to_driver=False)
        set_up_data()
        yield
        ray.shutdown()


class Nodes:
    """A cluster of three nodes on this machine."""

    def __init__(self):
        from ray.cluster_utils import Cluster

        ray.shutdown()  # that of one machine
        node = {"num_cpus": 1, "object_store_memory": STORE_BYTES}
        self.cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False, "_system_config": SYSTEM})
        ray.init(address=self.cluster.address, logging_level="ERROR", log_to_driver=False)  # at the head, as the others do not run yet
        self.others = [self.cluster.add_node(**node) for _ in range(2)]
        self.cluster.wait_for_nodes()
        set_up_data()

    def remove(self, node_id):
        node = next(node for node in self.others if node.node_id == node_id)
        self.others.remove(node)
        self.cluster.remove_node(node, allow_graceful=False)

    def close(self):
        ray.shutdown()
        self.cluster.shutdown()


@pytest.fixture(scope="module")
def nodes():
    with ray_folder():
        made = Nodes()
        yield made
        made.close()


@pytest.fixture(scope="module")
def drives(make_capture, tmp_path_factory):
    """Three captures, one of them packed."""
    folder = tmp_path_factory.mktemp("drives")
    paths = []
    for i, frames in enumerate((3, 4, 5)):
        capture = make_capture("-n", frames, "--seed", i + 1)
        path = folder / f"drive-{i}.pcap"
        if i == 2:
            path = path.with_suffix(".pcap.gz")
            path.write_bytes(gzip.compress(capture.read_bytes(), 1))
        else:
            shutil.copy(capture, path)
        paths.append(str(path))
    return paths


def expected(paths, columns=XYZR, **options):
    """(source, frame number) -> the bytes of the columns, by lumsdk.open()."""
    made = {}
    for path in paths:
        with lumsdk.open(path, columns=columns, **options) as source:
            for frame in source:
                made[path, frame.number] = [frame[name].tobytes() for name in columns]
    return made


def as_frames(dataset, columns=XYZR):
    """The same of the rows of a Dataset."""
    made = {}
    for batch in dataset.iter_batches(batch_size=None, batch_format="numpy"):
        of = list(zip(batch["source"], (int(number) for number in batch["frame"])))
        starts = [i for i in range(len(of)) if i == 0 or of[i] != of[i - 1]]
        for first, last in zip(starts, [*starts[1:], len(of)]):
            made.setdefault(of[first], [b""] * len(columns))
            made[of[first]] = [before + batch[name][first:last].tobytes() for before, name in zip(made[of[first]], columns)]
    return made


# --- On one machine ---

class TestPoints:
    def test_every_value_is_that_of_the_capture(self, local, drives):
        dataset = lumray.read_captures(drives, columns=XYZR)
        assert as_frames(dataset) == expected(drives)

    def test_counts_are_those_of_lumdump(self, local, drives, lumdump):
        summaries = [json.loads(lumdump(path, "--json")) for path in drives]
        assert lumray.read_captures(drives, columns=["x"]).count() == sum(s["points"] for s in summaries)
        assert lumray.read_captures(drives, rows="frames", columns=["x"]).count() == sum(s["frames"] for s in summaries)

    def test_options_are_those_of_open_and_their_files_are_read_once(self, local, drives, tmp_path):
        calibration = tmp_path / "moved.yaml"
        calibration.write_text("eyes.blue.mount.x_m: 1.5\n".replace("eyes.blue.mount.x_m", "eyes:\n  blue:\n    mount:\n      x_m"))
        options = {"returns": "last", "edge": "both", "frames": (1, 2), "range": (5, 60), "calibration": str(calibration)}
        wanted = expected(drives[:1], **options)
        dataset = lumray.read_captures(drives[0], columns=XYZR, **options)
        calibration.unlink()
        assert as_frames(dataset) == wanted and len(wanted) == 2

    @pytest.mark.parametrize("make", [dict, lambda keys: (f"{key}={value}" for key, value in keys.items())])
    def test_single_keys_are_set_on_top_of_what_the_capture_says_of_itself(self, local, make_capture, make):
        capture = str(make_capture("-n", 2, "--set", "eyes.green.mount.x_m=0.75", name="own.pcapng"))
        keys = {"eyes.blue.mount.x_m": 1.5}
        wanted = expected([capture], set=keys)
        assert wanted != expected([capture])
        assert as_frames(lumray.read_captures(capture, columns=XYZR, set=make(keys))) == wanted

    def test_keys_are_added_to_each_point(self, local, drives):
        dataset = lumray.read_captures(drives[0], columns=["line", "eye"], keys=["utc", "sensor", "frame"])
        assert dataset.columns() == ["utc", "sensor", "frame", "line", "eye"]
        row = dataset.take(1)[0]
        with lumsdk.open(drives[0]) as source:
            frame = next(iter(source))
        assert (row["utc"].value, row["sensor"], row["frame"]) == (frame.utc_ns, frame.sensor, frame.number)
        assert (row["line"], row["eye"]) == (frame["line"][0], frame["eye"][0])

    def test_points_can_be_written_and_read(self, local, drives, tmp_path):
        lumray.read_captures(drives[:2], columns=XYZR).write_parquet(str(tmp_path / "out"))
        table = pyarrow.parquet.read_table(str(tmp_path / "out"))
        assert table.num_rows == sum(len(columns[0]) // 4 for columns in expected(drives[:2]).values())
        assert set(table["source"].to_pylist()) == set(drives[:2])


class TestFrames:
    def test_a_row_is_a_frame(self, local, drives):
        rows = lumray.read_captures(drives[1], rows="frames", columns=["xyz", "line"], keys=["sensor", "frame", "utc"]).take_all()
        with lumsdk.open(drives[1]) as source:
            frames = list(source)
        assert len(rows) == len(frames) == 4
        for row, frame in zip(rows, frames):
            assert (row["frame"], row["sensor"], row["points"]) == (frame.number, frame.sensor, len(frame))
            assert row["utc"].value == frame.utc_ns and row["complete"] == frame.complete
            assert row["xyz"].dtype == np.float32 and np.array_equal(row["xyz"], frame.xyz)
            assert row["line"].dtype == np.uint32 and np.array_equal(row["line"], frame["line"])

    def test_all_columns_come_without_a_choice(self, local, drives):
        names = lumray.read_captures(drives[0], rows="frames").columns()
        assert names[:4] == ["source", "frame", "complete", "points"]
        assert {"xyz", "range", "pixel"} <= set(names) and "x" not in names


class TestPaths:
    def test_a_folder_has_captures_and_other_files(self, local, drives, tmp_path):
        shutil.copy(drives[0], tmp_path / "a.pcap")
        (tmp_path / "notes.txt").write_text("not a capture")
        assert lumray.read_captures(tmp_path, rows="frames", columns=["x"]).count() == 3

    def test_a_pattern_and_a_file_of_another_name(self, local, drives, tmp_path):
        odd = tmp_path / "odd.name"
        shutil.copy(drives[0], odd)
        assert lumray.read_captures(str(pathlib.Path(drives[0]).parent / "drive-*.pcap"), rows="frames", columns=["x"]).count() == 7
        assert lumray.read_captures([odd], rows="frames", columns=["x"]).count() == 3
        with pytest.raises(lumsdk.CaptureError, match="no file has such a name"):
            lumray.read_captures(str(tmp_path / "*.pcap"))

    @pytest.mark.parametrize("name", ["pyarrow", "fsspec", "url"])
    def test_file_systems(self, local, drives, name):
        folder = str(pathlib.Path(drives[0]).parent)
        filesystem, pattern = {
            "pyarrow": (pyarrow.fs.SubTreeFileSystem(folder, pyarrow.fs.LocalFileSystem()), "drive-[01].pcap"),
            "fsspec": (fsspec_local.LocalFileSystem(), f"{folder}/drive-[01].pcap"),
            "url": (None, f"file://{folder}/drive-[01].pcap")}[name]
        dataset = lumray.read_captures(pattern, rows="frames", columns=["x"], filesystem=filesystem)
        assert dataset.count() == 7


class TestSizes:
    def test_the_estimate_is_right_within_a_fifth(self, local, drives, make_capture, monkeypatch):
        monkeypatch.setattr(lumray, "_SAMPLE_FRAMES", 3)
        captures = [str(make_capture("-n", 12, "--seed", 5)), *drives]
        for rows, columns in (("points", XYZR), ("frames", ("xyz", "time")), ("points", ("eye",))):
            source = lumray._Captures(captures, lumray._Form(columns, ("source", "frame"), rows == "frames"),
                                      {"columns": XYZR + ("time", "eye")})
            made = lumray.read_captures(captures, rows=rows, columns=columns).materialize().size_bytes()
            assert source.estimate_inmemory_data_size() == pytest.approx(made, rel=0.2)

    def test_a_frame_comes_before_the_rest_is_read(self, local, make_capture):
        capture = make_capture("-n", 12, "--seed", 5)
        source = lumray._Captures([str(capture)], lumray._Form(XYZR, (), False), {"columns": XYZR})
        with open(capture, "rb") as file:
            blocks = source._read_stream(file, str(capture))
            next(blocks)
            assert file.tell() < capture.stat().st_size / 3
            blocks.close()


class TestRefusals:
    def test_a_file_that_is_no_capture_raises_lumdumps_sentence(self, local, drives, tmp_path):
        bad = tmp_path / "bad.pcap"
        bad.write_bytes(b"nothing of a capture" * 100)
        said = subprocess.run([pathlib.Path(os.environ["LUM_BIN"]) / "lumdump", bad], capture_output=True, text=True, check=False)
        sentence = said.stderr.strip().partition("lumdump: ")[2]
        assert sentence
        with pytest.raises(lumsdk.CaptureError) as error:
            lumray.read_captures([drives[0], str(bad)], columns=["x"]).count()
        assert sentence in str(error.value.cause)

    def test_a_capture_that_breaks_off(self, local, drives, tmp_path):
        cut = tmp_path / "cut.pcap"
        cut.write_bytes(pathlib.Path(drives[0]).read_bytes()[:-100])
        with pytest.raises(lumsdk.CaptureError, match="cut.pcap"):
            lumray.read_captures(str(cut), columns=["x"]).materialize()
        assert as_frames(lumray.read_captures(str(cut), columns=XYZR, broken="warn")) == expected([str(cut)], broken="warn")

    @pytest.mark.parametrize("arguments, error, text", [
        ({"rows": "lines"}, lumsdk.OptionError, '"points" or "frames"'),
        ({"columns": ["x", "rnage"]}, lumsdk.OptionError, "did you mean 'range'"),
        ({"columns": "xyz"}, lumsdk.OptionError, "name x, y and z"),
        ({"keys": ["file"]}, lumsdk.OptionError, "source, frame, sensor, utc"),
        ({"progress": print}, TypeError, "Ray shows"),
        ({"retruns": "last"}, TypeError, "did you mean returns"),
        ({"returns": "none"}, lumsdk.OptionError, "strongest"),
        ({"paths": 7}, TypeError, "use a path"),
        ({"paths": []}, lumsdk.CaptureError, "no capture is named")])
    def test_wrong_arguments_say_what_is_right(self, local, drives, arguments, error, text):
        with pytest.raises(error, match=text):
            lumray.read_captures(**{"paths": drives[0], **arguments})

    def test_without_ray_the_extra_is_named(self):
        code = "import sys; sys.modules['ray'] = None; import lumsdk.ray"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        assert "pip install '.[ray]'" in done.stderr and "ImportError" in done.stderr


# --- Where something fails ---

class TestFaults:
    def test_a_read_that_fails_is_repeated_bit_by_bit(self, local, drives, tmp_path):
        dataset = lumray.read_captures(drives[1], columns=XYZR, filesystem=Failing(str(tmp_path), "error"))
        assert as_frames(dataset) == expected([drives[1]])
        assert (tmp_path / "begun").exists()

    def test_a_read_that_fails_for_good_raises_its_cause(self, local, drives, tmp_path, monkeypatch):
        monkeypatch.setattr(ray.data.DataContext.get_current(), "retried_io_errors", [])
        dataset = lumray.read_captures(drives[1], columns=XYZR, filesystem=Failing(str(tmp_path), "error"))
        with pytest.raises(Exception, match=NETWORK):
            dataset.materialize()
        assert (tmp_path / "begun").exists()


class TestCluster:
    def test_several_nodes_give_the_same(self, nodes, drives):
        assert as_frames(lumray.read_captures(drives, columns=XYZR, override_num_blocks=3)) == expected(drives)

    def test_a_killed_worker_loses_nothing(self, nodes, drives, tmp_path):
        dataset = lumray.read_captures(drives, columns=XYZR, filesystem=Failing(str(tmp_path), "kill"), override_num_blocks=3)
        assert as_frames(dataset) == expected(drives)
        assert (tmp_path / "begun").exists()

    def test_a_removed_node_loses_nothing(self, nodes, drives, tmp_path):
        begun = tmp_path / "begun"
        others = {node.node_id for node in nodes.others}

        ended = threading.Event()

        def remove():
            while not ended.wait(0.05):
                node = begun.read_text() if begun.exists() else ""
                if node in others:
                    nodes.remove(node)
                    return
                if node:  # the head, which must stay: let that read go on
                    return

        where = {"scheduling_strategy": ray.util.scheduling_strategies.NodeAffinitySchedulingStrategy(sorted(others)[0], soft=True)}
        watcher = threading.Thread(target=remove)
        watcher.start()
        try:
            dataset = lumray.read_captures(drives, columns=XYZR, filesystem=Failing(str(tmp_path), "wait"), override_num_blocks=3,
                                           ray_remote_args=where)
            got = as_frames(dataset)
        finally:
            ended.set()
            watcher.join()
        assert len(nodes.others) == 1, "the node was not removed"
        assert got == expected(drives)
