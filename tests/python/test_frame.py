"""Frames: columns, grids, clocks, lines; arrays that outlive all; frames as values."""
import datetime
import gc
import pathlib
import pickle
import struct
import subprocess
import sys
import warnings

import lumsdk
import numpy as np
import pytest
from conftest import BIN, PATIENCE_S
from hypothesis import given, settings
from hypothesis import strategies as st


@pytest.fixture(scope="module")
def path(make_capture):
    return make_capture("-n", 3, "--loss", 0.01, "--reorder", 0.05, "--seed", 11)


@pytest.fixture(scope="module")
def frames(path):
    with lumsdk.open(path, columns="all", edge="both") as source:
        return list(source)


@pytest.fixture(scope="module", params=["of the library", "pickled"])
def frame(request, frames):
    """A frame, and one that was pickled: they are the same to whoever uses them."""
    return frames[1] if request.param == "of the library" else pickle.loads(pickle.dumps(frames[1], protocol=5))


def test_columns_have_their_types_and_lengths(frame):
    assert frame.columns == tuple(frame) == tuple(lumsdk.COLUMNS)
    for name, dtype in lumsdk.COLUMNS.items():
        assert frame[name].dtype == dtype and frame[name].shape == (len(frame),)
    assert set(dict(frame)) == set(frame.to_dict()) == set(frame.columns)
    assert "range" in frame and "colour" not in frame


def test_xyz_is_a_view_of_the_columns(frame):
    assert frame.xyz.shape == (len(frame), 3) and frame.xyz.dtype == np.float32
    for i, name in enumerate("xyz"):
        assert np.shares_memory(frame.xyz, frame[name]) and np.array_equal(frame.xyz[:, i], frame[name])
    assert frame.xyz is frame.xyz


def test_a_view_can_be_written(path):
    (frame, *_) = lumsdk.open(path)
    frame.xyz[:] += 1
    assert np.array_equal(frame["x"], frame.xyz[:, 0])
    assert not frame["x"].flags.owndata and frame["x"].flags.writeable


def test_points_agree_with_each_other(frame):
    mount = np.linalg.norm(frame.xyz.astype("f8"), axis=1)
    assert np.allclose(mount, frame["range"], atol=1e-3)  # the typical eyes sit at the origin
    assert set(np.unique(frame["edge"])) <= {0, 1} and (frame["return_number"] <= frame["number_of_returns"]).all()
    assert np.array_equal(np.repeat(frame.lines["number"], frame.lines["point_count"]), frame["line"])
    assert np.array_equal(np.repeat(frame.lines["eye"], frame.lines["point_count"]), frame["eye"])


def test_lines_follow_each_other(frame):
    lines = frame.lines
    assert lines.dtype.names[:2] == ("number", "eye") and len(lines) > 100
    ends = lines["first_point"].astype(int) + lines["point_count"]
    assert ends[-1] == len(frame) and np.array_equal(lines["first_point"][1:], ends[:-1])
    assert (lines["angle_count"] <= 1000).all() and lines["lost_words"].sum() == frame.losses["lost_words"]
    assert frame.info["lines_blue"] + frame.info["lines_green"] == len(lines)


@pytest.mark.parametrize("returns", [1, 3])
@pytest.mark.parametrize("eye", ["blue", "green"])
def test_a_grid_holds_each_pixel(frame, eye, returns):
    grid = frame.grid("range", eye=eye, returns=returns)
    assert grid.dtype == np.float32 and grid.shape == (64, 1000) + ((returns,) if returns > 1 else ())
    want = np.full((64, 1000, returns), np.nan, "f4")
    filled = np.zeros((64, 1000), int)
    for i in np.flatnonzero(frame["eye"] == ("blue", "green").index(eye)):
        line, pixel = frame["line"][i], frame["pixel"][i]
        if filled[line, pixel] < returns:
            want[line, pixel, filled[line, pixel]] = frame["range"][i]
            filled[line, pixel] += 1
    assert np.array_equal(grid, want if returns > 1 else want[:, :, 0], equal_nan=True)


def test_a_grid_takes_the_lines_that_are_asked_for(frame):
    assert frame.grid("pixel", "blue", lines=80).shape == (80, 1000)
    assert np.array_equal(frame.grid("x", "green", lines=10), frame.grid("x", "green")[:10], equal_nan=True)
    assert frame.grid("x", "green", lines=0).shape == (0, 1000)


def test_a_damaged_line_number_makes_no_large_grid_and_is_told(path):
    content = bytearray(path.read_bytes())
    at = 24
    while at < len(content):  # a bit of the number of each last line, in all of its packets
        eye, number = content[at + 71], int.from_bytes(content[at + 72:at + 74], "little")
        if (eye, number) == (0, 63):
            content[at + 73] |= 0x80
        at += 16 + int.from_bytes(content[at + 8:at + 12], "little")
    (frame, *_) = lumsdk.open(bytes(content))
    beyond = frame.lines[frame.lines["number"] == 0x8000 + 63]
    assert beyond["point_count"].sum() > 0
    with pytest.warns(lumsdk.CaptureWarning, match=f"1, with {beyond['point_count'].sum()} points: .* as 32831 come"):
        assert frame.grid("range", "blue").shape == (63, 1000)
    assert frame.grid("range", "blue", lines=0x8000 + 64).shape == (0x8000 + 64, 1000)
    assert frame.grid("range", "green").shape == (64, 1000)


def test_a_grid_of_the_only_eye_needs_no_name(path):
    (frame, *_) = lumsdk.open(path, eye="green")
    assert np.array_equal(frame.grid("range"), frame.grid("range", "green"), equal_nan=True)


@pytest.mark.parametrize("arguments, kind, said", [
    ({"column": "range"}, ValueError, 'use eye="blue" or eye="green"'),
    ({"column": "range", "eye": "red"}, ValueError, "eye is 'red'"),
    ({"column": "colour", "eye": "blue"}, KeyError, "there is no column 'colour'"),
    ({"column": "x", "eye": "blue", "returns": 0}, ValueError, "from 1"),
    ({"column": "x", "eye": "blue", "returns": "last"}, TypeError, "use a whole number"),
    ({"column": "x", "eye": "blue", "lines": -1}, ValueError, "from 0"),
])
def test_a_grid_tells_what_is_wrong(frame, arguments, kind, said):
    with pytest.raises(kind, match=said):
        frame.grid(**arguments)


def test_a_column_that_is_not_there_is_told(path):
    (frame, *_) = lumsdk.open(path, columns="x")
    for name, said in [("range", "name it in columns="), ("colour", "there is no column 'colour'; there are x, y")]:
        with pytest.raises(KeyError, match=said):
            frame[name]
    with pytest.raises(KeyError, match="no column 'y'"):
        frame.xyz
    with pytest.raises(KeyError, match="no column 'pixel'"):
        frame.grid("x", "blue")


@pytest.fixture(scope="module")
def exact():
    """A capture with a drift of 50 ppm and exact stamps in nanoseconds."""
    return lumsdk.simulate(frames=80, returns_max=1, drift=50)


def restamped(data, stamp):
    """A capture with other stamps: of the time since its first, and the exact one, in ns."""
    out, at, first = bytearray(data), 24, None
    while at < len(out):
        seconds, ns, length = struct.unpack_from("<III", out, at)
        exact = seconds * 10**9 + ns
        first = exact if first is None else first
        struct.pack_into("<II", out, at, *divmod(stamp(exact - first, exact), 10**9))
        at += 16 + length
    return bytes(out)


def utc_errors(source):
    """Of each frame: its begin on the sensor's clock, how far off its UTC is by a capture's exact stamps, and what is told."""
    return [(f.info["begin_clock_us"], f.utc_ns - 1767225600 * 10**9 - f.info["begin_clock_us"] * 1000.05, f.utc_error_ns)
            for f in source]


@pytest.mark.parametrize("step_ns, gain", [
    (10**6, lambda t: 0),
    (10**7, lambda t: 0),
    (1, lambda t: max(0, min(t, 6 * 10**9) - 3 * 10**9) // 2000),
    (10**5, lambda t: -max(0, t - 3 * 10**9) // 2000),
    (1, lambda t: (t > 4 * 10**9) * 20_000_000),
    (1, lambda t: (t > 4 * 10**9) * 10**9),
    (1, lambda t: (t > 4 * 10**9) * -10**9),
], ids=["1 ms", "10 ms", "500 ppm faster", "500 ppm slower and 100 us", "20 ms on", "1 s on", "1 s back"])
def test_the_error_of_utc_holds(exact, step_ns, gain):
    delay_ns = min(error for _, error, _ in utc_errors(lumsdk.open(exact)))  # that every packet needs
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        with lumsdk.open(restamped(exact, lambda t, ns: (ns + gain(t)) // step_ns * step_ns)) as source:
            found = utc_errors(source)
    holds = [told is None or abs(error - delay_ns - gain((us - found[0][0]) * 1000)) <= told for us, error, told in found]
    assert sum(holds) >= 79
    assert bool(source.counts["host_steps"]) == bool(warned) == any(told is None for _, _, told in found)
    assert sum(told is not None and told < 50e6 for _, _, told in found) > 50


def test_stamps_that_stand_still_tell_no_utc(exact, tmp_path):
    (tmp_path / "still.pcap").write_bytes(restamped(exact, lambda t, ns: 10**18))
    with pytest.warns(lumsdk.CaptureWarning, match="stood still"), lumsdk.open(tmp_path / "still.pcap") as source:
        frames = list(source)
        assert all(frame.utc_error_ns is None and frame.info["utc_error_ns"] is None for frame in frames)
        assert source.counts["stamps_still"] > 8000
    (again,) = pickle.loads(pickle.dumps(frames[:1]))
    assert again.utc_error_ns is None and again == frames[0]


def test_a_sensor_that_is_asked_for_may_come_second(tmp_path):
    paths = [lumsdk.simulate(tmp_path / f"{i}.pcap", frames=2, address=f"10.42.0.{i}") for i in (37, 38)]
    with lumsdk.open(paths, sensor="10.42.0.38") as source:
        assert [frame.sensor for frame in source] == ["10.42.0.38"] * 2


def test_clocks(frames):
    for frame in frames:
        assert isinstance(frame.utc_ns, int) and frame.utc_error_ns > 0
        assert frame.time.tzinfo is datetime.timezone.utc
        assert abs(frame.time.timestamp() - frame.utc_ns * 1e-9) < 1e-5
        assert abs(frame.utc_ns - frame.lines["arrival_ns"][0]) < 5e6 + frame.utc_error_ns
        assert 0.05 < frame.duration < 0.11
    assert abs(frames[2].utc_ns - frames[1].utc_ns - 10 ** 8) < 10 ** 6


def test_without_a_clock_the_arrival_counts(path):
    (frame, *_) = lumsdk.open(path, profile={"group.timestamp": "none"})
    assert frame.utc_error_ns is None and frame.utc_ns == frame.lines["arrival_ns"].min()


def test_losses_are_told_by_cause(frames):
    assert not frames[0].complete and frames[0].first and frames[-1].last and not frames[1].first
    assert sum(frame.losses["lost_words"] for frame in frames) > 0
    assert list(frames[1].losses) == ["lost_words", "lines_missing_angles", "lines_missing", "lines_in_pauses", "lines_cut",
                                      "lines_late", "points_cut", "no_angle", "no_range"]
    info = frames[1].info
    assert info["points"] == len(frames[1]) and info["sensor"] == "10.42.0.37" and "rows_blue" in info


def test_a_frame_that_holds_a_pause_is_not_complete(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(pathlib.Path(__file__).parents[1] / "tools"))
    import outages
    runs, wrong, _ = outages.quick(BIN, tmp_path, lumsdk)
    assert runs > 130 and not wrong


def test_it_is_shown_with_counts(frame):
    said = repr(frame)
    assert said.startswith("<Frame 2 of 10.42.0.37: ") and f"{len(frame)} points" in said and "incomplete" in said


def test_a_structured_array_has_all(frame):
    made = frame.to_structured()
    assert made.dtype == np.dtype(list(lumsdk.COLUMNS.items()))
    assert all(np.array_equal(made[name], frame[name]) for name in frame.columns)


def test_a_pickled_frame_is_the_same(frames):
    for frame in frames:
        for protocol in (2, 5):
            again = pickle.loads(pickle.dumps(frame, protocol))
            assert again == frame and frame == again and repr(again) == repr(frame) and again.info == frame.info
            assert again.time == frame.time and again.utc_error_ns == frame.utc_error_ns
            assert np.array_equal(again.lines, frame.lines)
    assert frames[0] != frames[1] and frames[0] != 1
    assert pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(frames[0])))) == frames[0]


def test_frames_without_points_are_frames(path):
    for options in [{"range": (900, 901)}, {"columns": ""}, {"columns": "pixel", "range": (900, 901)}]:
        with pytest.warns(lumsdk.CaptureWarning) if "range" in options else _nothing():
            frames = list(lumsdk.open(path, **options))
        assert len(frames) == 3 and frames[0] and len(frames[0]) == 0
        assert pickle.loads(pickle.dumps(frames[0])) == frames[0]
        if "columns" not in options:
            assert frames[0].xyz.shape == (0, 3) and np.isnan(frames[0].grid("range", "blue")).all()
            again = pickle.loads(pickle.dumps(frames[0]))
            assert again.xyz.shape == (0, 3) and np.isnan(again.grid("range", "blue")).all()


class _nothing:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None


@given(st.lists(st.sampled_from(["keep frame", "keep x", "keep xyz", "keep grid", "drop", "next", "close"]), max_size=30))
@settings(max_examples=25)
def test_arrays_outlive_their_frame_and_their_source(path, frames, steps):
    """Whatever is kept has its values at the end, though memory of frames that were dropped is used again."""
    want = {frame.number: frame for frame in lumsdk.open(path)}
    source = lumsdk.open(path)
    iterator, frame, kept = iter(source), None, []
    for step in steps:
        if step == "next" and not source.closed:
            frame = next(iterator, None)
        elif step == "close":
            source.close()
        elif step == "drop":
            frame = None
            gc.collect(0)
        elif frame is not None and step.startswith("keep"):
            what = step[5:]
            kept.append((frame.number, what, {"frame": frame, "x": frame["x"], "xyz": frame.xyz[::7],
                                              "grid": frame.grid("range", "blue")}[what]))
    del frame, iterator, source
    gc.collect(0)
    for number, what, value in kept:
        frame = want[number]
        if what == "frame":
            assert value == frame
        else:
            assert np.array_equal(value, {"x": frame["x"], "xyz": frame.xyz[::7],
                                          "grid": frame.grid("range", "blue")}[what], equal_nan=True)


def test_the_library_is_there_until_the_process_ends():
    """What is freed last, when the interpreter has dropped its modules, calls the library still."""
    code = """
import ctypes
from lumsdk._c import ffi, lib
release = int(ffi.cast("uintptr_t", lib.lum_frame_release))
ffi.dlclose(lib)
ctypes.CFUNCTYPE(None, ctypes.c_void_p)(release)(None)
print("released")
"""
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE_S).stdout == "released\n"
