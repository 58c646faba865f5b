"""convert(): each format read back by its library, whole files or none, and what is refused."""
import contextlib
import importlib.util
import io
import itertools
import json
import os
import pathlib
import shutil
import stat
import subprocess
import sys
import threading
import time
import warnings
import weakref

import lumsdk
import numpy as np
import pytest
from conftest import interrupts_at_a_terminal, on_interface
from lumsdk import _table
from lumsdk._formats import WRITERS

OF_LUMDUMP = ("csv", "ply", "pcd", "las", "xyz", "mcap", "pcapng")
NEEDS = {"laz": ("laspy", "lazrs"), "parquet": ("pyarrow",), "feather": ("pyarrow",)}
OURS = ("laz", "parquet", "feather", "npy", "npz", "bin")
COLUMNS = list(_table.FILE_COLUMNS)


def need(kind):
    for module in NEEDS.get(kind, ()):
        pytest.importorskip(module)


@pytest.fixture(scope="session")
def drive(make_capture):
    """Two frames, and some losses."""
    return make_capture("-n", 2, "--returns-max", 1, "--loss", 0.005, "--duplicate", 0.002)


@pytest.fixture(scope="session")
def frames(drive):
    return list(lumsdk.open(drive, columns="all"))


@pytest.fixture(scope="session")
def two_sensors(make_capture):
    """A capture of each of two sensors, of the same time."""
    return [make_capture("-n", 2, "--address", f"10.42.0.{n}", name=f"{n}.pcap") for n in (37, 38)]


def expected(frames, name, time="sensor"):
    return np.concatenate([_table.value(frame, name, time) for frame in frames])


def left_in(folder):
    """The names in a folder, hidden ones too."""
    return sorted(entry.name for entry in os.scandir(folder))


# --- What lumdump writes ---


@pytest.mark.parametrize("kind", ["ply", "pcd", "las", "laz"])
def test_a_map_is_that_of_lumdump(drive, lumdump, tmp_path, kind):
    need(kind)
    poses = tmp_path / "poses.txt"
    poses.write_text("".join(f"{i * 0.1} {i * 0.5} 0 0 0 0 0 1\n" for i in range(400)))
    written = "las" if kind == "laz" else kind
    lumdump(drive, "-o", tmp_path / f"theirs.{written}", "--poses", poses, "--voxel", 0.5)
    made = lumsdk.convert(drive, tmp_path / f"ours.{kind}", poses=poses, voxel=0.5)
    ours, theirs = tmp_path / f"ours.{kind}", tmp_path / f"theirs.{written}"
    assert made["outputs"] == [str(ours)] and made["bytes"] == ours.stat().st_size
    if kind == "laz":
        import laspy

        mine, whole = laspy.read(ours), laspy.read(theirs)
        assert np.array_equal(mine.points.array, whole.points.array) and made["points"] == len(whole)
        assert np.array_equal(mine.header.offsets, whole.header.offsets) and [v.user_id for v in mine.vlrs] == [v.user_id for v in whole.vlrs]
    else:
        assert ours.read_bytes()[-50000:] == theirs.read_bytes()[-50000:]
    assert left_in(tmp_path) == sorted(["poses.txt", ours.name, theirs.name])


def test_voxels_that_cannot_be_written_are_refused(drive, frames, tmp_path):
    for source, name, text in (drive, "a.parquet", "voxel does not go with"), (frames, "a.las", "needs a capture"):
        with pytest.raises(lumsdk.OptionError, match=text):
            lumsdk.convert(source, tmp_path / name, voxel=0.5)
    pytest.importorskip("laspy")
    for name, voxel, text in ("%d.laz", 0.5, "one file"), ("a.laz", 0, r"0\.01 to 100"):
        with pytest.raises(lumsdk.OptionError, match=text):
            lumsdk.convert(drive, tmp_path / name, voxel=voxel)
    assert left_in(tmp_path) == []


@pytest.mark.parametrize("kind", [*OF_LUMDUMP, "png"])
def test_bytes_are_those_of_lumdump(drive, lumdump, tmp_path, kind):
    selects = kind not in ("pcapng",)
    options = dict(returns="last", range=(2, 80), box=((0, None), (-20, 20), (None, 4))) if selects else {}
    arguments = ["--return=last", "--range=2:80", "--box=0:,-20:20,:4"] if selects else []
    lumdump(drive, "-o", tmp_path / f"theirs.{kind}", *arguments, "--frames=1:2", "--eye=blue")
    made = lumsdk.convert(drive, tmp_path / f"ours.{kind}", frames=(1, 2), eye="blue", **options)
    ours, theirs = (tmp_path / f"{name}.{kind}" for name in ("ours", "theirs"))
    assert made["outputs"] == [str(ours)] and made["bytes"] == ours.stat().st_size and made["format"] == kind
    if kind in ("csv", "xyz", "png"):
        assert ours.read_bytes() == theirs.read_bytes()
    else:  # the origin names the options in the order in which they were given
        assert ours.stat().st_size == theirs.stat().st_size
        assert ours.read_bytes()[-50000:] == theirs.read_bytes()[-50000:]


def test_a_picture_is_of_one_frame(drive, lumdump, tmp_path):
    lumdump(drive, "-o", tmp_path / "first.png", "--frames=1:1")
    with pytest.warns(lumsdk.CaptureWarning, match="it shows frame 1, the first with points, as none is whole"):
        made = lumsdk.convert(drive, tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "first.png").read_bytes()
    lumdump(drive, "-o", tmp_path / "first.png", "--frames=1:1", "--colour=height", "--size=900x800")
    with pytest.warns(lumsdk.CaptureWarning, match="it shows frame 1, which is not whole"):
        lumsdk.convert(drive, tmp_path / "a.png", frames=1, colour="height", size=(900, 800))
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "first.png").read_bytes()
    with lumsdk.open(drive) as source:
        assert (made["frames"], made["points"]) == (1, len(next(iter(source))))


def test_options_of_the_output_go_to_lumdump(drive, lumdump, tmp_path):
    lumdump(drive, "-o", tmp_path / "a.ply", "--ascii", "--columns=x,time", "--time=arrival", "--smooth=31:2",
            "--set=line_span_us=4000", "--edge=both", "--incomplete=drop")
    lumsdk.convert(drive, tmp_path / "b.ply", ascii=True, columns=["x", "time"], time="arrival", smooth=(31, 2),
                   set={"line_span_us": 4000}, edge="both", incomplete="drop")
    first, second = ((tmp_path / name).read_text().split("end_header\n") for name in ("a.ply", "b.ply"))
    assert first[1] == second[1]
    assert set(first[0].splitlines()) == set(second[0].splitlines())


@pytest.mark.parametrize("given", ["bytes", "file", "list", "pattern"])
def test_every_kind_of_source_gives_the_same_points(drive, lumdump, tmp_path, given):
    rows = lumdump(drive, "-o", "-", "--format", "csv", "-q")
    with open(drive, "rb") as file:
        source = {"bytes": drive.read_bytes(), "file": file, "list": [str(drive)], "pattern": str(drive)[:-1] + "?"}[given]
        made = lumsdk.convert(source, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_bytes() == rows
    assert made["points"] == rows.count(b"\n") - 1


def test_a_calibration_of_python_is_used(drive, lumdump, tmp_path):
    calibration = lumsdk.Calibration({"eyes.blue.mount.yaw_deg": -20})
    text = tmp_path / "c.yaml"
    text.write_text(calibration.to_yaml())
    lumdump(drive, "-o", tmp_path / "a.csv", "--calibration", text)
    for given in (calibration, text, str(text), {"eyes": {"blue": {"mount": {"yaw_deg": -20}}}}):
        lumsdk.convert(drive, tmp_path / "b.csv", calibration=given)
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_a_file_of_each_frame_and_rotation(drive, tmp_path, frames):
    made = lumsdk.convert(drive, tmp_path / "f-%03d.pcd")
    assert made["outputs"] == [str(tmp_path / f"f-{frame.number:03d}.pcd") for frame in frames]
    assert made["bytes"] == sum(os.path.getsize(name) for name in made["outputs"])
    again = lumsdk.convert(drive, tmp_path / "r.csv", rotate="4MB")
    assert again["outputs"] == [str(tmp_path / f"r-{i:04d}.csv") for i in range(1, len(again["outputs"]) + 1)]
    assert len(again["outputs"]) > 1


# --- What Python writes ---


@pytest.mark.parametrize("time", ["sensor", "arrival"])
def test_laz_is_las_of_lumdump_compressed(drive, lumdump, tmp_path, time):
    need("laz")
    laspy = pytest.importorskip("laspy")
    lumdump(drive, "-o", tmp_path / "a.las", "--time", time, "--edge=both")
    lumsdk.convert(drive, tmp_path / "b.laz", time=time, edge="both")
    theirs, ours = laspy.read(tmp_path / "a.las"), laspy.read(tmp_path / "b.laz")
    assert len(ours.points) == len(theirs.points)
    order = [np.lexsort([cloud[name] for name in ("return_number", "edge", "pixel", "eye", "line", "frame")])
             for cloud in (ours, theirs)]
    assert list(ours.point_format.dimension_names) == list(theirs.point_format.dimension_names)
    for name in ours.point_format.dimension_names:
        assert np.array_equal(np.asarray(ours[name])[order[0]], np.asarray(theirs[name])[order[1]]), name
    for name in ("version", "point_count", "system_identifier", "creation_date", "uuid"):
        assert getattr(ours.header, name) == getattr(theirs.header, name), name
    for name in ("mins", "maxs", "scales", "offsets", "number_of_points_by_return"):
        assert np.array_equal(getattr(ours.header, name), getattr(theirs.header, name)), name
    assert ours.header.global_encoding.wkt and ours.header.point_format.id == 6
    assert ours.header.global_encoding.gps_time_type == theirs.header.global_encoding.gps_time_type
    assert [(r.user_id, r.record_id) for r in ours.header.vlrs if r.user_id == "lumsdk"] == [("lumsdk", 1)]


def test_laz_says_where_its_points_come_from(make_capture, lumdump, tmp_path):
    need("laz")
    laspy = pytest.importorskip("laspy")
    kept = tmp_path / "kept.pcapng"
    lumdump(make_capture("-n", 1), "-o", kept, "--set=eyes.blue.mount.yaw_deg=-20")
    lumdump(kept, "-o", tmp_path / "a.las", "--eye=blue")
    lumsdk.convert(kept, tmp_path / "b.laz", eye="blue")
    theirs, ours = (laspy.read(tmp_path / name).header.vlrs.get_by_id("lumsdk")[0].record_data.decode()
                    for name in ("a.las", "b.laz"))
    assert ours == theirs.replace('"lumdump', '"lumsdk', 1)
    assert "# lumsdk calibration 1" in ours and ours.count("# lumsdk origin 1") == 2


def test_laz_is_the_same_for_the_same_points(drive, tmp_path):
    need("laz")
    for name in "ab":
        lumsdk.convert(drive, tmp_path / f"{name}.laz")
    assert (tmp_path / "a.laz").read_bytes() == (tmp_path / "b.laz").read_bytes()
    assert (tmp_path / "a.laz").read_bytes()[90:94] == bytes(4)


def test_parquet_has_a_row_group_a_frame_and_metadata(drive, frames, tmp_path):
    need("parquet")
    pq = pytest.importorskip("pyarrow.parquet")
    made = lumsdk.convert(drive, tmp_path / "a.parquet", eye="both")
    table = pq.read_table(tmp_path / "a.parquet")
    assert table.column_names == COLUMNS
    for name in COLUMNS:
        assert np.array_equal(table[name].to_numpy(), expected(frames, name)), name
        assert table.schema.field(name).metadata.get(b"unit", b"").decode() == _table.COLUMNS[name].unit
    file = pq.ParquetFile(tmp_path / "a.parquet")
    assert [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)] == [len(f) for f in frames]
    about = {key.decode(): value.decode() for key, value in file.metadata.metadata.items()}
    assert about["lumsdk.program"] == f"lumsdk {lumsdk.__version__}" and about["lumsdk.source"] == "drive.pcap"
    assert json.loads(about["lumsdk.options"]) == ["--eye=both"]
    assert lumsdk.Calibration(about["lumsdk.calibration"]) == lumsdk.Calibration()
    assert lumsdk.Profile(about["lumsdk.profile"]) == lumsdk.Profile()
    assert [frame["number"] for frame in json.loads(about["lumsdk.frames"])] == [frame.number for frame in frames]
    assert json.loads(about["lumsdk.losses"]) == made["losses"]


def test_parquet_splits_floats_and_has_dictionaries_only_of_columns_that_were_added(drive, frames, tmp_path):
    need("parquet")
    pq = pytest.importorskip("pyarrow.parquet")
    lumsdk.convert([frame.with_columns(own=frame["line"] % 3, weight=frame["range"]) for frame in frames], tmp_path / "a.parquet")
    group = pq.ParquetFile(tmp_path / "a.parquet").metadata.row_group(0)
    columns = {column.path_in_schema: column for column in map(group.column, range(group.num_columns))}
    assert {column.compression for column in columns.values()} == {"LZ4"}
    split = {name for name, column in columns.items() if "BYTE_STREAM_SPLIT" in column.encodings}
    assert split == {"x", "y", "z", "range", "azimuth", "elevation", "pulse_width"}
    assert {name for name, column in columns.items() if "RLE_DICTIONARY" in column.encodings} == {"own", "weight"}
    pq.write_table(pq.read_table(tmp_path / "a.parquet"), tmp_path / "usual.parquet")
    assert os.path.getsize(tmp_path / "a.parquet") < os.path.getsize(tmp_path / "usual.parquet")


@pytest.mark.parametrize("kind", ["parquet", "feather"])
def test_tables_need_no_pandas(drive, tmp_path, kind):
    need(kind)
    program = "import sys, lumsdk; lumsdk.convert(*sys.argv[1:]); assert 'pandas' not in sys.modules"
    subprocess.run([sys.executable, "-c", program, drive, tmp_path / f"a.{kind}"], check=True)


@pytest.mark.parametrize("kind", ["csv", "npy"])
def test_options_of_generators_are_those_of_lists(drive, tmp_path, kind):
    options = {"set": ["eyes.blue.mount.x_m=1.5"], "columns": ["x", "range"]}
    lumsdk.convert(drive, tmp_path / f"list.{kind}", **options)
    lumsdk.convert(drive, tmp_path / f"once.{kind}", **{name: iter(value) for name, value in options.items()})
    lumsdk.convert(drive, tmp_path / f"other.{kind}", columns=options["columns"])
    once = (tmp_path / f"once.{kind}").read_bytes()
    assert once == (tmp_path / f"list.{kind}").read_bytes() != (tmp_path / f"other.{kind}").read_bytes()


def test_the_origin_names_the_options_of_an_open_source(drive, tmp_path):
    need("parquet")
    pq = pytest.importorskip("pyarrow.parquet")
    with lumsdk.open(drive, returns="last", range=(2, 80), columns="all", broken="warn") as source:
        lumsdk.convert(source, tmp_path / "a.parquet")
    about = pq.read_metadata(tmp_path / "a.parquet").metadata
    assert json.loads(about[b"lumsdk.options"]) == ["--return=last", "--range=2:80"]


@pytest.mark.parametrize("kind", OURS)
def test_a_name_may_have_bytes_that_are_no_text(drive, tmp_path, kind):
    need(kind)
    source = os.path.join(os.fsencode(tmp_path), b"dr\xffive.pcap")
    try:
        shutil.copy(drive, source)
    except OSError:
        pytest.skip("this file system has no such names")
    assert lumsdk.convert(os.fsdecode(source), tmp_path / f"a.{kind}")["frames"]


def test_feather_has_a_batch_a_frame(drive, frames, tmp_path):
    need("feather")
    feather, ipc = pytest.importorskip("pyarrow.feather"), pytest.importorskip("pyarrow.ipc")
    for compression in (None, "zstd", "none"):
        lumsdk.convert(drive, tmp_path / "a.feather", columns="range,time,strongest", compression=compression)
        table = feather.read_table(tmp_path / "a.feather")
        assert table.column_names == ["range", "time", "strongest"]
        for name in table.column_names:
            assert np.array_equal(table[name].to_numpy(), expected(frames, name)), name
        assert table.schema.field("time").metadata[b"unit"] == b"s"
    with ipc.open_file(tmp_path / "a.feather") as file:
        for i, frame in enumerate(frames):
            batch, about = file.get_batch_with_custom_metadata(i)
            assert batch.num_rows == len(frame)
            assert json.loads(about[b"lumsdk.frame"])["number"] == frame.number


def test_argoverse_sweeps_by_pandas(drive, frames, tmp_path):
    need("feather")
    pd = pytest.importorskip("pandas")
    made = lumsdk.convert(drive, tmp_path / "{utc_ns}.feather", preset="argoverse2")
    assert [int(pathlib.Path(name).stem) for name in made["outputs"]] == [frame.utc_ns for frame in frames]
    sweep = pd.read_feather(made["outputs"][1])
    assert list(map(str, sweep.dtypes)) == ["float16"] * 3 + ["uint8"] * 2 + ["int32"]
    assert np.array_equal(sweep["x"].to_numpy(), frames[1].xyz[:, 0].astype("f2"))


def test_npy_and_npz(drive, frames, tmp_path):
    columns = [*COLUMNS, "time", "strongest", "sensor"]
    lumsdk.convert(drive, tmp_path / "a.npy", columns=columns)
    lumsdk.convert(drive, tmp_path / "a.npz", columns=columns)
    records = np.load(tmp_path / "a.npy", mmap_mode="r")
    arrays = np.load(tmp_path / "a.npz")
    assert list(records.dtype.names) == columns and set(arrays) == {*columns, "metadata"}
    for name in columns:
        assert np.array_equal(records[name], expected(frames, name)), name
        assert np.array_equal(arrays[name], expected(frames, name)) and arrays[name].dtype == records[name].dtype
    about = json.loads(str(arrays["metadata"]))
    assert about["lumsdk.source"] == "drive.pcap" and len(about["lumsdk.frames"]) == len(frames)


def test_kitti(drive, frames, tmp_path):
    made = lumsdk.convert(drive, tmp_path / "%06d.bin")
    assert [pathlib.Path(name).name for name in made["outputs"]] == [f"{frame.number:06d}.bin" for frame in frames]
    for frame, name in zip(frames, made["outputs"]):
        points = np.fromfile(name, "<f4").reshape(-1, 4)
        assert np.array_equal(points[:, :3], frame.xyz)
        assert np.allclose(points[:, 3], np.minimum(frame["pulse_width"] / 25.5, 1), atol=1e-6)
    lumsdk.convert(drive, tmp_path / "all.bin")
    assert (tmp_path / "all.bin").read_bytes() == b"".join(pathlib.Path(name).read_bytes() for name in made["outputs"])


def test_open3d_reads_ply_and_pcd_of_frames(frames, tmp_path):
    o3d = pytest.importorskip("open3d")
    for kind in ("ply", "pcd"):
        lumsdk.convert(frames[1], tmp_path / f"a.{kind}")
        cloud = o3d.t.io.read_point_cloud(str(tmp_path / f"a.{kind}"))
        assert np.array_equal(cloud.point.positions.numpy(), frames[1].xyz)


@pytest.mark.parametrize("kind", OURS)
def test_counts_are_those_of_lumdump(drive, lumdump, tmp_path, kind):
    need(kind)
    summary = json.loads(lumdump(drive, "--json", "--return=last"))
    made = lumsdk.convert(drive, tmp_path / f"a.{kind}", returns="last")
    assert {name: made[name] for name in ("source", "frames", "points", "truncated")} == {
        name: summary[name] for name in ("source", "frames", "points", "truncated")}
    assert summary.items() >= {name: made["losses"][name] for name in made["losses"].keys() & summary}.items()
    assert made["losses"]["lost_words"] > 0
    assert made["sensors"] == ["10.42.0.37"] and made["bytes"] == os.path.getsize(tmp_path / f"a.{kind}")
    assert made["left_out"] == 0


@pytest.mark.parametrize("kind", OURS)
def test_frames_without_points_and_no_frames(drive, tmp_path, kind):
    need(kind)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = lumsdk.convert(drive, tmp_path / f"a.{kind}", range="900:901")
    assert made["points"] == 0 and made["frames"] == 2
    none = lumsdk.convert(iter([]), tmp_path / f"b.{kind}")
    assert none["points"] == none["frames"] == 0
    for name in "ab":
        assert points_in(tmp_path / f"{name}.{kind}") == 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert lumsdk.convert(drive, tmp_path / f"%d.{kind}", range="900:901")["outputs"] == []


@pytest.mark.parametrize("kind", ["csv", "las", *OURS])
def test_frames_are_those_of_the_outputs(make_capture, tmp_path, kind):
    need(kind)
    drive = make_capture("-n", 8, "--lines", 64, "--returns-max", 1, name="eight.pcap")
    for options, want in ({}, 8), ({"frames": (5, 7)}, 3), ({"frames": 8, "eye": "green"}, 1), ({"frames": "3:", "range": "900:"}, 6):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            made = [lumsdk.convert(drive, tmp_path / f"a.{kind}", **options),
                    lumsdk.convert(drive, tmp_path / f"%d.{kind}", **options)]
        assert [one["frames"] for one in made] == [want, want]
        assert len(made[1]["outputs"]) == (want if made[1]["points"] else 0)
    with lumsdk.open(drive, frames=(2, 6), columns="all") as source:
        assert lumsdk.convert(source, tmp_path / f"b.{kind}")["frames"] == source.counts["frames_selected"] == 5
        assert lumsdk.convert(itertools.islice(source, 2), tmp_path / f"c.{kind}")["frames"] == 2


def wait_for_writers():
    """What was interrupted cleans up behind the exception."""
    for thread in threading.enumerate():
        if thread.name == "lumsdk-convert":
            thread.join()


def points_in(path):
    """By the library that reads the format."""
    kind = path.suffix[1:]
    if kind == "laz":
        import laspy
        return len(laspy.read(path).points)
    if kind in ("parquet", "feather"):
        import pyarrow.feather
        import pyarrow.parquet
        return (pyarrow.parquet if kind == "parquet" else pyarrow.feather).read_table(path).num_rows
    if kind == "bin":
        return len(np.fromfile(path, "<f4")) // 4
    return len(np.load(path)["x"])


# --- Frames as the source ---


@pytest.mark.parametrize("kind", ["csv", "xyz"])
def test_text_of_frames_has_the_rows_of_lumdump(drive, frames, lumdump, tmp_path, kind):
    rows = lumdump(drive, "-o", "-", "--format", kind, "-q").splitlines()
    lumsdk.convert(frames, tmp_path / f"a.{kind}")
    assert sorted((tmp_path / f"a.{kind}").read_bytes().splitlines()) == sorted(rows)


def test_las_and_ply_of_frames_have_the_points_of_lumdump(drive, frames, lumdump, tmp_path):
    for kind in ("las", "ply"):
        lumdump(drive, "-o", tmp_path / f"a.{kind}")
        with lumsdk.open(drive, columns="all") as source:
            made = lumsdk.convert(source, tmp_path / f"b.{kind}")
        assert made["points"] == sum(map(len, frames))
        theirs, ours = ((tmp_path / name).read_bytes() for name in (f"a.{kind}", f"b.{kind}"))
        size = {"las": 62, "ply": 52}[kind]
        count = made["points"]
        points = [np.sort(np.frombuffer(whole, f"V{size}", offset=len(whole) - size * count)) for whole in (theirs, ours)]
        assert np.array_equal(*points)


def test_frames_of_any_kind_and_time(frames, tmp_path):
    for given in (frames, tuple(frames), iter(frames), (frame for frame in frames)):
        lumsdk.convert(given, tmp_path / "a.npy", time="utc", columns="timestamp,time")
        times = np.load(tmp_path / "a.npy")
        utc = times["timestamp"][0] / 1e6
        assert abs(utc - frames[0].utc_ns / 1e9) < 1
        assert np.abs(np.diff(times["timestamp"])).max() < 1e6
    lumsdk.convert(frames[0], tmp_path / "a.ply", columns="x,time", ascii=True)
    assert b"property float x\nproperty float scalar_time\n" in (tmp_path / "a.ply").read_bytes()


def test_frames_that_lack_a_column_are_refused(drive, tmp_path):
    with lumsdk.open(drive, columns="x,y,z,range") as source:
        for kind in ("csv", "las", "npy"):
            with pytest.raises(lumsdk.OptionError, match="has no column '.*', only x, y, z, range; name it in"):
                lumsdk.convert(source, tmp_path / f"a.{kind}")
        assert left_in(tmp_path) == []
        lumsdk.convert(source, tmp_path / "a.csv", columns="range,x")
        lumsdk.convert(source, tmp_path / "a.xyz")


@pytest.mark.parametrize(("kind", "alive"), [("bin", 3), ("laz", 2)])
def test_memory_does_not_grow_with_the_frames(drive, tmp_path, monkeypatch, kind, alive):
    need(kind)
    made, most = [], 0
    add = WRITERS[kind].add

    def slow(self, frame):
        """The first time, until the reader has come as far as it comes."""
        while len(made) < 40:
            count = len(made)
            time.sleep(0.3)
            if count == len(made):
                break
        add(self, frame)
        monkeypatch.setattr(WRITERS[kind], "add", add)

    monkeypatch.setattr(WRITERS[kind], "add", slow)

    def many():
        nonlocal most
        for _ in range(20):
            for frame in lumsdk.open(drive, columns=WRITERS["laz"].needs):
                made.append(weakref.ref(frame))
                most = max(most, sum(ref() is not None for ref in made))
                yield frame

    assert lumsdk.convert(many(), tmp_path / f"a.{kind}")["frames"] == 40
    assert most <= alive


@pytest.mark.parametrize("kind", OURS)
def test_files_do_not_depend_on_how_many_points_are_written_at_once(drive, tmp_path, monkeypatch, kind):
    need(kind)
    from lumsdk import _formats

    lumsdk.convert(drive, tmp_path / f"a.{kind}")
    monkeypatch.setattr(_formats, "_AT_ONCE", 4999)
    lumsdk.convert(drive, tmp_path / f"b.{kind}")
    assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


@pytest.mark.skipif(not hasattr(os, "posix_fadvise"), reason="the system takes no advice about files")
def test_the_disk_begins_while_more_is_written(frames, tmp_path, monkeypatch):
    from lumsdk import _target

    begun, advise = [], os.posix_fadvise

    def note(fd, first, count, advice):
        begun.append((first, count))
        advise(fd, first, count, advice)

    monkeypatch.setattr(_target, "_AHEAD", 1 << 20)
    monkeypatch.setattr(os, "posix_fadvise", note)
    lumsdk.convert(frames, tmp_path / "a.npy")
    assert len(begun) > 2
    assert [first for first, _ in begun] == [0, *itertools.accumulate(count for _, count in begun)][:-1]
    size = os.path.getsize(tmp_path / "a.npy")
    assert size - 2 * (2 << 20) < sum(count for _, count in begun) <= size


def test_npy_fills_records_while_others_are_written(frames, tmp_path, monkeypatch):
    from lumsdk._formats import Npy

    writers, before, wait = set(), threading.active_count(), Npy._wait

    def note(self):
        writers.update(thread.name for thread in threading.enumerate() if thread.name.startswith("lumsdk-write"))
        wait(self)

    monkeypatch.setattr(Npy, "_wait", note)
    lumsdk.convert(frames, tmp_path / "a.npy")
    assert len(writers) == 1 and threading.active_count() == before
    records = np.load(tmp_path / "a.npy")
    for name in records.dtype.names:
        assert np.array_equal(records[name], expected(frames, name)), name


# --- Whole files or none ---


@pytest.mark.parametrize("problem", [RuntimeError("no more"), KeyboardInterrupt()])
@pytest.mark.parametrize("kind", [*OURS, "csv", "las"])
def test_nothing_is_left_after_a_failure(frames, tmp_path, kind, problem):
    need(kind)

    def failing():
        yield from frames[:2]
        raise problem

    old = tmp_path / f"a.{kind}"
    old.write_text("as it was")
    with pytest.raises(type(problem)):
        lumsdk.convert(failing(), old)
    wait_for_writers()
    assert old.read_text() == "as it was"
    assert left_in(tmp_path) == [old.name]


@pytest.mark.parametrize("kind", ["ply", "npy"])
@pytest.mark.parametrize("problem", [TimeoutError, BrokenPipeError])
def test_a_file_object_that_fails_in_the_middle(drive, tmp_path, kind, problem):
    class Failing(io.BytesIO):
        def read(self, size=-1):
            if self.tell() > 500000:
                raise problem("the network is gone")
            return super().read(min(size, 100000))

        readinto = None

    with pytest.raises(problem, match="the network is gone"):
        lumsdk.convert(Failing(drive.read_bytes()), tmp_path / f"a.{kind}")
    assert left_in(tmp_path) == []


def test_a_file_object_that_waits_is_not_waited_for_once_it_is_refused(tmp_path):
    released, waited = threading.Event(), []

    class Waiting:
        def read(self, size=-1):
            if waited:
                released.wait(60)
                waited.append("to the end")
            waited.append("once")
            return bytes(65536)

    with pytest.raises(lumsdk.CaptureError):
        lumsdk.convert(Waiting(), tmp_path / "a.csv")
    assert "to the end" not in waited
    released.set()


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_control_c_ends_it_and_leaves_nothing(drive, tmp_path, kind):
    need(kind)
    program = """
import os, signal, sys, lumsdk
def stream():
    with open(sys.argv[1], "rb") as file:
        head = file.read(24)
        rest = file.read()
    yield head
    while True:
        yield rest
class Endless:
    def __init__(self): self.blocks, self.count = stream(), 0
    def read(self, size=-1):
        self.count += 1
        if self.count == 4: print("reading", flush=True)
        kept = getattr(self, "kept", b"") or next(self.blocks)
        self.kept = kept[size:]
        return kept[:size]
try:
    lumsdk.convert(Endless(), sys.argv[2])
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program, str(drive), str(tmp_path / f"a.{kind}")],
                               stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "reading\n"
    process.send_signal(2)
    assert process.stdout.readline() == "interrupted\n"
    assert process.wait() == 0
    assert left_in(tmp_path) == []
    process.stdout.close()


@pytest.mark.skipif(os.name == "nt", reason="needs signals of POSIX")
def test_control_c_at_a_terminal_ends_lumdump_once(drive, tmp_path):
    assert interrupts_at_a_terminal(tmp_path, f"lumsdk.convert({str(drive)!r}, 'a.csv')") == "one"


def test_a_file_is_replaced_with_its_mode_and_through_a_link(drive, tmp_path):
    real = tmp_path / "real.npy"
    real.write_text("old")
    real.chmod(0o640)
    (tmp_path / "link.npy").symlink_to(real)
    lumsdk.convert(drive, tmp_path / "link.npy")
    assert (tmp_path / "link.npy").is_symlink() and stat.S_IMODE(real.stat().st_mode) == 0o640
    assert len(np.load(real)) and left_in(tmp_path) == ["link.npy", "real.npy"]


@pytest.mark.parametrize(("kind", "told"), [("csv", "was removed while it was written; its data was put back as .*a.csv"),
                                            ("npy", "was removed or renamed while it was written: convert again")])
@pytest.mark.parametrize("is_replaced", [False, True])
def test_a_file_that_is_removed_meanwhile_is_told(frames, tmp_path, kind, told, is_replaced):
    lumsdk.convert(frames, tmp_path / f"whole.{kind}")

    def removing():
        yield frames[0]
        (part,) = tmp_path.glob("a.*.part")
        part.unlink()
        if is_replaced:
            part.write_text("mine")
        yield from frames[1:]
    with pytest.raises(OSError, match=f"a.{kind}: .*[.]part, where it is written, {told}"):
        lumsdk.convert(removing(), tmp_path / f"a.{kind}")
    if is_replaced:
        (part,) = tmp_path.glob("a.*.part")
        assert part.read_text() == "mine"
        part.unlink()
    if kind == "csv":
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert left_in(tmp_path) == (["a.csv", "whole.csv"] if kind == "csv" else [f"whole.{kind}"])


def test_two_runs_do_not_write_one_file(frames, tmp_path, drive):
    def slow():
        yield frames[0]
        with pytest.raises(lumsdk.Error, match="this run is writing it already"):
            lumsdk.convert(frames, tmp_path / "a.npy")
        found = subprocess.run([os.path.join(os.environ["LUM_BIN"], "lumdump"), drive, "--format=csv", "-o", "a.npy"],
                               cwd=tmp_path, capture_output=True, text=True, check=False)
        assert found.returncode == 1 and f"another run is writing it (process {os.getpid()})" in found.stderr
        yield frames[1]

    assert lumsdk.convert(slow(), tmp_path / "a.npy")["frames"] == 2
    assert left_in(tmp_path) == ["a.npy"]


def test_what_a_killed_run_left_is_removed(drive, tmp_path):
    program = ("import lumsdk, os, sys\ndef frames():\n    yield next(iter(lumsdk.open(sys.argv[1], columns='all')))\n"
               "    os.kill(os.getpid(), 9)\nlumsdk.convert(frames(), sys.argv[2])")
    killed = [sys.executable, "-c", program, str(drive), str(tmp_path / "a.npy")]
    assert subprocess.run(killed, check=False).returncode == -9
    assert len(left_in(tmp_path)) == 2
    lumsdk.convert(drive, tmp_path / "a.npy")
    assert left_in(tmp_path) == ["a.npy"]
    assert subprocess.run(killed, check=False).returncode == -9
    subprocess.run([os.path.join(os.environ["LUM_BIN"], "lumdump"), drive, "--format=csv", "-o", tmp_path / "a.npy", "-q"],
                   check=True)
    assert left_in(tmp_path) == ["a.npy"]


def test_a_foreign_mark_is_left_alone(drive, tmp_path):
    (tmp_path / ".a.npy.lumsdk").write_text("mine")
    with pytest.raises(lumsdk.Error, match="rename that one, or choose another name"):
        lumsdk.convert(drive, tmp_path / "a.npy")
    assert (tmp_path / ".a.npy.lumsdk").read_text() == "mine"


def test_the_source_is_not_overwritten(drive, tmp_path):
    copy = tmp_path / "a.npy"
    copy.write_bytes(drive.read_bytes())
    (tmp_path / "b.npy").symlink_to(copy)
    for name in ("a.npy", "b.npy"):
        with pytest.raises(lumsdk.OptionError, match="is the source itself, which this run reads: name another output"):
            lumsdk.convert(copy, tmp_path / name)
    with pytest.raises(lumsdk.OptionError, match="is the source itself"):
        lumsdk.convert(copy, copy, format="csv")
    assert copy.read_bytes() == drive.read_bytes()


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_an_interruption_does_not_wait_for_what_is_written(frames, tmp_path, monkeypatch, kind):
    from lumsdk import _formats, _points_file

    began, goes_on, released = threading.Event(), threading.Event(), []

    def slow(self, frame):
        began.set()
        released.append(goes_on.wait(60))

    def interrupted():
        yield frames[0]
        began.wait()
        raise KeyboardInterrupt

    monkeypatch.setattr(_formats.Npy, "add", slow)
    monkeypatch.setattr(_points_file.PointsFile, "add", slow)
    with pytest.raises(KeyboardInterrupt):
        lumsdk.convert(interrupted(), tmp_path / f"a.{kind}")
    goes_on.set()
    wait_for_writers()
    assert released == [True] and left_in(tmp_path) == []


# --- What is refused ---


@pytest.mark.parametrize("name, options, said", [
    ("a.foo", {}, r"'.*a\.foo' has no ending that shows a format: use \.csv .*\.laz .*, or give format="),
    ("a", {}, "has no ending that shows a format"),
    ("a.npy", {"format": "e57"}, "format is 'e57'; formats are csv, ply, .*laz, parquet"),
    ("a.copc.laz", {}, "by pdal translate or untwine"),
    ("a%x.npy", {}, r"a % in the name stands for the frame number: write %d or %04d, once"),
    ("a%d%d.npy", {}, "write %d or %04d, once"),
    ("a.npy", {"columns": ["x", "colour"]}, "'colour' is not a column; columns are x, y, z"),
    ("a.bin", {"columns": ["x"]}, "columns does not go with the format bin; it goes with csv, ply, pcd, parquet"),
    ("a.npy", {"ascii": True}, "ascii does not go with the format npy; it goes with ply, pcd"),
    ("a.npy", {"time": "gps"}, 'time is \'gps\'; use "sensor", "utc", "arrival"'),
    ("a.csv", {"colour": "height"}, "--colour goes with png output only"),
    ("a.png", {"size": (10, 10)}, "from 640 to 8000"),
    ("a.npy", {"rotate": "1GB"}, "rotate does not go with the format npy"),
    ("a.csv", {"compression": "zstd"}, "compression does not go with the format csv"),
    ("a.csv", {"preset": "argoverse2"}, "preset does not go with the format csv"),
    ("a.npy", {"returns": "some"}, "returns is 'some'; use"),
    ("{utc_ns}.csv", {}, "use %04d, the number of the frame"),
    ("-", {"format": "csv"}, "standard output, which convert"),
    ("a.ply", {"comments": True}, "comments"),
    ("a.csv", {"columns": ["x", "colour"]}, "--columns: 'colour' is not a column; columns are x, y"),
    ("a.pcd", {"organized": True, "returns": "last"}, "--organized makes a file of each frame"),
    ("a.pcapng", {"range": "2:80"}, "a packet holds many points"),
    ("a.npy", {"storage_options": {"anon": True}}, "storage_options does not go with a.npy: it is for a URL"),
    ("a.csv", {"storage_options": {"anon": True}}, "storage_options does not go with a.csv"),
])
def test_wrong_options_are_refused(drive, tmp_path, monkeypatch, name, options, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(lumsdk.OptionError, match=said):
        lumsdk.convert(drive, name, **options)
    assert left_in(tmp_path) == []


@pytest.mark.parametrize("source, name, options, said", [
    (3, "a.npy", {}, "a source is given as int"),
    ([1, 2], "a.npy", {}, "a source in a list is 1"),
    (iter([1]), "a.npy", {}, "gives int and not frames"),
    ("drive", 7, {}, "the destination is 7; use a path or a URL"),
    ("drive", "a.npy", {"colums": "x"}, "there is no option colums"),
])
def test_wrong_types_are_refused(tmp_path, monkeypatch, source, name, options, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TypeError, match=said):
        lumsdk.convert(source, name, **options)
    assert left_in(tmp_path) == []


def test_what_frames_do_not_take_is_refused(frames, tmp_path):
    for name, options, said in (("a.npy", {"returns": "last"}, "returns: frames have been read already"),
                                ("a.pcd", {"organized": True}, "organized is done by lumdump: it needs a capture as source"),
                                ("a.png", {}, "png is written by lumdump: it needs a capture as source"), ("a.pcap", {}, "pcap is written by lumdump: it needs a capture"),
                                ("a.ply", {"columns": "x,sensor"}, "columns: ply has x, y, z")):
        with pytest.raises(lumsdk.OptionError, match=said):
            lumsdk.convert(frames, tmp_path / name, **options)
    assert left_in(tmp_path) == []


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_sources_and_places_that_are_not_there(drive, tmp_path, kind):
    with pytest.raises(lumsdk.CaptureError, match="nope.pcap: cannot be opened: No such file"):
        lumsdk.convert(tmp_path / "nope.pcap", tmp_path / f"a.{kind}")
    with pytest.raises(lumsdk.Error, match="cannot create it: the directory does not exist; create it or write elsewhere"):
        lumsdk.convert(drive, tmp_path / "no" / f"a.{kind}")
    (tmp_path / "bad.pcap").write_text("hi")
    with pytest.raises(lumsdk.CaptureError, match="bad.pcap: not a capture"):
        lumsdk.convert(tmp_path / "bad.pcap", tmp_path / f"a.{kind}")
    with pytest.raises(lumsdk.OptionError, match="it is read by lumsdk.Sensor"):
        lumsdk.convert("udp://10.42.0.37", tmp_path / f"a.{kind}")
    assert left_in(tmp_path) == ["bad.pcap"]


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_a_capture_that_breaks_off(drive, tmp_path, kind):
    cut = tmp_path / "cut.pcap"
    cut.write_bytes(drive.read_bytes()[:drive.stat().st_size * 3 // 5])
    with pytest.warns(lumsdk.CaptureWarning, match="cut.pcap: cannot be read beyond record"):
        made = lumsdk.convert(cut, tmp_path / f"a.{kind}")
    assert made["truncated"] and made["points"] > 0
    os.unlink(tmp_path / f"a.{kind}")
    with pytest.raises(lumsdk.CaptureError, match="cannot be read beyond record"):
        lumsdk.convert(cut, tmp_path / f"a.{kind}", broken="raise")
    assert left_in(tmp_path) == ["cut.pcap"]


def test_several_sensors(two_sensors, tmp_path):
    for kind in ("csv", "npy", "bin"):
        with pytest.raises(lumsdk.OptionError, match="packets of several sensors; choose one by"):
            lumsdk.convert(two_sensors, tmp_path / f"a.{kind}")
    assert left_in(tmp_path) == []
    made = lumsdk.convert(two_sensors, tmp_path / "a.npy", columns=["x", "sensor"])
    assert made["sensors"] == ["10.42.0.37", "10.42.0.38"]
    assert set(np.load(tmp_path / "a.npy")["sensor"] & 255) == {37, 38}
    one = lumsdk.convert(two_sensors, tmp_path / "b.npy", sensor="10.42.0.38")
    assert 0 < one["points"] < made["points"]


def test_two_sensors_with_one_address(make_capture, tmp_path):
    pair = [on_interface(make_capture("-n", 2, "--seed", seed), tmp_path / f"{seed}.pcapng", name)
            for seed, name in ((4, b"eth0"), (3, b"eth1"))]
    alone = [[len(frame) for frame in lumsdk.open(path)] for path in pair]
    names = ["10.42.0.37", "10.42.0.37%eth1"]
    with lumsdk.open(pair) as source:
        found = [(frame.sensor, frame.info["sensor"], len(frame)) for frame in source]
        assert source.sensors == names
    for name, lengths in zip(names, alone):
        assert [length for sensor, of_info, length in found if sensor == of_info == name] == lengths
    assert [len(frame) for frame in lumsdk.open(pair, sensor="10.42.0.37%eth0")] == alone[0]
    assert [len(frame) for frame in lumsdk.open(pair, sensor=names[1])] == alone[1]
    with pytest.warns(lumsdk.CaptureWarning, match="the first one was taken: name the other as 10.42.0.37%eth1 "):
        assert [len(frame) for frame in lumsdk.open(pair, sensor=names[0])] == alone[0]
    with pytest.raises(lumsdk.CaptureError, match="no data of 10.42.0.37%eth2 in it, but of 10.42.0.37 10.42.0.37%eth1"):
        list(lumsdk.open(pair, sensor="10.42.0.37%eth2"))
    with pytest.raises(lumsdk.OptionError, match="use an address such as"):
        lumsdk.open(pair, sensor="10.42.0.37%")
    with pytest.raises(lumsdk.OptionError, match="choose one by sensor=: 10.42.0.37 10.42.0.37%eth1"):
        lumsdk.convert(pair, tmp_path / "a.npy", columns=["x", "sensor"])
    with pytest.raises(lumsdk.OptionError, match="a number cannot distinguish 10.42.0.37%eth1"):
        lumsdk.convert(pair, tmp_path / "a.npy", columns=["x", "sensor"], sensor=names[1])
    for kind in ("csv", "npy"):
        made = lumsdk.convert(pair, tmp_path / f"a.{kind}", sensor=names[1])
        assert (made["sensors"][-1:], made["points"]) == (names[1:], sum(alone[1]))


@pytest.mark.parametrize("kind, module, extra", [("laz", "laspy", "laz"), ("laz", "lazrs", "laz"),
                                                 ("parquet", "pyarrow", "parquet"), ("feather", "pyarrow", "parquet")])
def test_a_missing_library_is_named_with_its_extra(drive, tmp_path, monkeypatch, kind, module, extra):
    if module == "lazrs":
        need("laz")
    monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.setitem(sys.modules, f"{module}.parquet", None)
    with pytest.raises(lumsdk.Error, match=rf"{module} is missing: in a clone of lumsdk, pip install '\.\[{extra}\]'"):
        lumsdk.convert(drive, tmp_path / f"a.{kind}")
    assert left_in(tmp_path) == []


def test_progress_is_told(drive, tmp_path):
    size = drive.stat().st_size
    for kind in ("npy", "ply"):
        told = []
        lumsdk.convert(drive, tmp_path / f"a.{kind}", progress=lambda *numbers, told=told: told.append(numbers))
        assert told[-1] == (size, size) and told == sorted(told)


# --- URLs ---


@pytest.fixture
def store():
    """A place for objects, in memory."""
    fsspec = pytest.importorskip("fsspec")
    fs = fsspec.filesystem("memory")
    fs.store.clear()
    yield fs
    fs.store.clear()


@pytest.mark.parametrize("kind", ["npy", "csv", "las"])
def test_a_url_gets_the_whole_file(store, drive, tmp_path, kind):
    made = lumsdk.convert(drive, f"memory://b/a.{kind}")
    lumsdk.convert(drive, tmp_path / f"a.{kind}")
    assert store.cat(f"/b/a.{kind}") == (tmp_path / f"a.{kind}").read_bytes()
    assert made["outputs"] == [f"memory://b/a.{kind}"] and list(store.store) == [f"/b/a.{kind}"]


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_a_fault_of_a_store_is_told_with_its_url(store, drive, monkeypatch, kind):
    def fail(*_, **__):
        raise RuntimeError("no credentials")

    monkeypatch.setattr(type(store), "put_file", fail)
    with pytest.raises(lumsdk.Error, match=f"memory://b/a.{kind}: cannot write it: RuntimeError: no credentials"):
        lumsdk.convert(drive, f"memory://b/a.{kind}")
    assert not store.store


def test_urls_of_frames_and_from_a_url(store, drive, frames):
    store.pipe("/in/drive.pcap", drive.read_bytes())
    made = lumsdk.convert("memory://in/drive.pcap", "memory://out/%04d.pcd")
    assert made["outputs"] == [f"memory://out/{frame.number:04d}.pcd" for frame in frames]
    made = lumsdk.convert("memory://in/drive.pcap", "memory://out/%04d.bin")
    assert sorted(store.store) == ["/in/drive.pcap", *(f"/out/{f.number:04d}.{k}" for f in frames for k in ("bin", "pcd"))]
    lumsdk.convert(frames, "memory://out/a.xyz")
    assert store.cat("/out/a.xyz").count(b"\n") == made["points"]


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_nothing_is_left_at_a_url_after_a_failure(store, frames, drive, monkeypatch, kind):
    def failing():
        yield frames[0]
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError):
        lumsdk.convert(failing(), f"memory://b/a.{kind}")
    assert not store.store

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(store), "mv", full)
    with pytest.raises(lumsdk.Error, match="memory://b/a.* cannot write it: No space left on device"):
        lumsdk.convert(drive, f"memory://b/a.{kind}")
    assert not store.store


def test_a_url_of_no_known_kind(drive):
    pytest.importorskip("fsspec")
    with pytest.raises(lumsdk.OptionError, match="nosuch"):
        lumsdk.convert(drive, "nosuch://b/a.npy")


def test_a_full_disk_is_told_and_leaves_nothing(drive, frames, tmp_path):
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with contextlib.ExitStack() as kept:
        kept.callback(resource.setrlimit, resource.RLIMIT_FSIZE, before)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, before[1]))
        for kind in ("npy", "bin", "npz", *(name for name, writer in WRITERS.items() if writer.module and importlib.util.find_spec(writer.module))):
            with pytest.raises(lumsdk.Error, match=f"a.{kind}: cannot write it: .*[Ff]ile too large") as told:
                lumsdk.convert(itertools.chain(*[frames] * 8), tmp_path / f"a.{kind}")
            assert isinstance(told.value, OSError)
        for kind in ("csv", "ply", "pcd", "las", "xyz", "pcap"):
            with pytest.raises(OSError, match=f"a.{kind}: .*File too large"):
                lumsdk.convert(drive, tmp_path / f"a.{kind}")
    assert left_in(tmp_path) == []
