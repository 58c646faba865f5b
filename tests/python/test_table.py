"""Frames as tables: columns and their units, Arrow, pandas, presets, and other libraries' arrays."""
import json

import lumsdk
import numpy as np
import pytest
from lumsdk import _table


@pytest.fixture(scope="module")
def frame(capture):
    return next(iter(lumsdk.open(capture, columns="all")))


@pytest.fixture(scope="module")
def empty(capture):
    """A frame without points."""
    made = next(iter(lumsdk.open(capture, columns="all", range="900:901")))
    assert len(made) == 0 and made.columns
    return made


def csv_of(lumdump, capture, *options):
    """lumdump's rows as a dictionary of columns."""
    text = lumdump(capture, "-o", "-", "--format", "csv", "-q", *options).decode()
    names, rows = text.split("\n", 1)
    columns = names.split(",")
    return dict(zip(columns, np.fromstring(rows.replace("\n", ","), sep=",").reshape(-1, len(columns)).T))


def test_every_column_of_a_frame_is_in_the_table():
    assert set(lumsdk.COLUMNS) <= set(_table.COLUMNS)
    for name, dtype in lumsdk.COLUMNS.items():
        assert _table.COLUMNS[name].dtype == dtype, name
    assert all(column.description for column in _table.COLUMNS.values())


@pytest.mark.parametrize("time", _table.TIMES)
def test_columns_are_those_of_lumdump(make_capture, lumdump, time):
    capture = make_capture("-n", 2)
    columns = [*_table.FILE_COLUMNS, "time"]
    rows = csv_of(lumdump, capture, "--time", time, "--columns", ",".join(columns))
    frames = list(lumsdk.open(capture, columns="all"))
    for name in columns:
        ours = np.concatenate([_table.value(frame, name, time) for frame in frames]).astype("f8")
        bound = {"f": 1e-3 if name == "pulse_width" else 1e-4}.get(_table.COLUMNS[name].dtype.kind, 0)
        if (name, time) == ("timestamp", "utc"):  # a frame has one fit, a line of lumdump each its own
            bound = 50
        assert np.abs(ours - rows[name]).max() <= bound, name


def test_names_that_are_not_columns_are_refused(frame):
    for names, said in ((["x", "why"], "'why' is not a column; columns are x, y, z"), (["x", "x"], "'x' is there twice"),
                        ([], "no column is named")):
        with pytest.raises(lumsdk.OptionError, match=said):
            _table.check_names(names, ())
    with pytest.raises(TypeError, match="give names such as"):
        _table.check_names([1], ())
    assert _table.check_names("x,range", ()) == ("x", "range")
    with pytest.raises(lumsdk.OptionError, match="is not a preset; presets are argoverse2"):
        _table.check_preset("nuscenes", None)


def test_a_column_that_the_frame_lacks_is_named(capture):
    frame = next(iter(lumsdk.open(capture, columns="x,y,z")))
    with pytest.raises(lumsdk.OptionError, match="has no column 'range', only x, y, z; name it in the option columns"):
        _table.value(frame, "range")


def test_arrow_has_units_and_does_not_copy(frame):
    pytest.importorskip("pyarrow")
    table = frame.to_arrow()
    assert table.num_rows == len(frame)
    assert table.column_names == [name for name in _table.COLUMNS if name != "sensor"]
    for name in table.column_names:
        assert np.array_equal(table[name].to_numpy(), _table.value(frame, name)), name
    for name, unit in (("x", b"m"), ("azimuth", b"deg"), ("pulse_width", b"ns"), ("timestamp", b"us"), ("time", b"s")):
        assert table.schema.field(name).metadata[b"unit"] == unit
        assert table.schema.field(name).metadata[b"description"]
    assert b"unit" not in table.schema.field("pixel").metadata
    about = json.loads(table.schema.metadata[b"lumsdk.frame"])
    assert about["number"] == frame.number and about["sensor"] == frame.sensor and about["utc_ns"] == frame.utc_ns
    assert table["range"].chunk(0).buffers()[1].address == frame["range"].__array_interface__["data"][0]


def test_arrow_of_chosen_columns_and_of_no_points(frame, empty):
    pytest.importorskip("pyarrow")
    assert frame.to_arrow(columns="range,sensor").column_names == ["range", "sensor"]
    assert set(frame.to_arrow(columns=["sensor"])["sensor"].to_pylist()) == {(10 << 24) + (42 << 16) + 37}
    assert empty.to_arrow().num_rows == 0
    assert empty.to_arrow().schema.types == frame.to_arrow().schema.types
    assert empty.to_arrow(preset="argoverse2").num_rows == 0


def test_arrow_stays_valid_without_the_frame(capture):
    pytest.importorskip("pyarrow")
    tables = [(frame.to_arrow(columns=["range"]), frame["range"].copy()) for frame in lumsdk.open(capture)]
    for table, expected in tables:
        assert np.array_equal(table["range"].to_numpy(), expected)


def test_pandas_has_the_same_values(frame, empty):
    pytest.importorskip("pandas")
    table = frame.to_pandas()
    assert len(table) == len(frame)
    for name in table.columns:
        assert np.array_equal(table[name].to_numpy(), _table.value(frame, name)), name
        assert table[name].dtype == _table.COLUMNS[name].dtype
    assert table.attrs["units"]["range"] == "m" and table.attrs["frame"]["number"] == frame.number
    assert len(empty.to_pandas()) == 0


def test_argoverse_has_its_types_and_ours_within_them(frame):
    pa = pytest.importorskip("pyarrow")
    table = frame.to_arrow(preset="argoverse2")
    assert list(zip(table.column_names, table.schema.types)) == [
        ("x", pa.float16()), ("y", pa.float16()), ("z", pa.float16()), ("intensity", pa.uint8()),
        ("laser_number", pa.uint8()), ("offset_ns", pa.int32())]
    for i, name in enumerate("xyz"):
        assert np.array_equal(table[name].to_numpy(), frame.xyz[:, i].astype("f2"))
    assert np.abs(table["intensity"].to_numpy() * 0.1 - frame["pulse_width"])[frame["pulse_width"] < 25.5].max() <= 0.0501
    lasers = table["laser_number"].to_numpy()
    assert np.array_equal(lasers // 32, frame["eye"])
    assert np.array_equal(lasers % 32, frame["line"] // 2)  # 64 lines
    assert np.abs(table["offset_ns"].to_numpy() * 1e-9 - frame["time"]).max() < 1e-8


def test_argoverse_lasers_of_640_lines(make_capture):
    pytest.importorskip("pyarrow")
    frame = next(iter(lumsdk.open(make_capture("-n", 1, "--lines", 640), returns="first", columns="all")))
    lasers = frame.to_arrow(preset="argoverse2")["laser_number"].to_numpy()
    assert np.array_equal(lasers, frame["eye"] * 32 + frame["line"] // 20)
    assert lasers.max() == 63


def test_a_preset_has_its_own_columns(frame):
    pytest.importorskip("pyarrow")
    with pytest.raises(lumsdk.OptionError, match="the preset 'argoverse2' has its own"):
        frame.to_arrow(columns=["x"], preset="argoverse2")


def test_a_missing_library_is_named_with_its_extra(frame, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(lumsdk.Error, match=r"pyarrow is missing: in a clone of lumsdk, pip install '\.\[parquet\]'"):
        frame.to_arrow()
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(lumsdk.Error, match=r"pandas is missing: in a clone of lumsdk, pip install '\.\[pandas\]'"):
        frame.to_pandas()


@pytest.mark.skipif(not hasattr(np, "from_dlpack"), reason="this NumPy has no from_dlpack")
def test_dlpack_shares_the_memory(frame):
    for array in (frame.xyz, frame["range"], frame["line"]):
        other = np.from_dlpack(array)
        assert np.shares_memory(other, array) and np.array_equal(other, array)


def test_open3d_takes_points(frame):
    o3d = pytest.importorskip("open3d")
    cloud = o3d.t.geometry.PointCloud(o3d.core.Tensor.from_numpy(np.ascontiguousarray(frame.xyz)))
    assert np.array_equal(cloud.point.positions.numpy(), frame.xyz)
    tensor = o3d.core.Tensor.from_dlpack(frame["range"].__dlpack__())
    assert tensor.numpy().__array_interface__["data"][0] == frame["range"].__array_interface__["data"][0]
    legacy = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(frame.xyz))
    assert np.array_equal(np.asarray(legacy.points), frame.xyz.astype("f8"))
