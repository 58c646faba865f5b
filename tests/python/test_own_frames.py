"""Frames of one's own: some points, other values, columns of one's own, frames from arrays; all of it as NumPy does it on plain
arrays, without copies that need not be; in files, and in other libraries."""
import gc
import importlib
import pickle
import warnings
import weakref

import lumsdk
import numpy as np
import pytest
from lumsdk import _columns, _table
from hypothesis import given, settings
from hypothesis import strategies as st

TYPES = ["?", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f2", "f4", "f8"]
cheap = settings(max_examples=25, derandomize=True)


@pytest.fixture(scope="module")
def whole(make_capture):
    """A frame of the library that lacks lines and words."""
    with lumsdk.open(make_capture("-n", 3, "--loss", 0.02, "--seed", 3), columns="all", edge="both", range="4:9") as source:
        return source[1]


@pytest.fixture(scope="module", params=["of the library", "pickled", "of arrays"])
def frame(request, whole):
    if request.param == "of the library":
        return whole.with_columns(label=np.arange(len(whole)) % 7, near=whole["range"] < 20)
    if request.param == "pickled":
        return pickle.loads(pickle.dumps(whole.with_columns(label=np.arange(len(whole), dtype="u4"))))
    arrays = {name: whole[name].copy() for name in whole.columns}
    return lumsdk.Frame.from_arrays(arrays, weight=np.linspace(0, 1, len(whole)), lines=whole.lines, number=7, sensor="10.42.0.38",
                                    utc_ns=whole.utc_ns)


def plain(frame):
    """Its columns, and the line of each point, as arrays of their own."""
    return {**{name: frame[name].copy() for name in frame.columns}, "of": np.repeat(np.arange(len(frame.lines)), frame.lines["point_count"])}


def check_part(frame, key, part):
    """A part has the points that NumPy chooses of plain arrays."""
    wanted = {name: array[key] for name, array in plain(frame).items()}
    assert part.columns == frame.columns and len(part) == len(wanted["x"])
    for name in frame.columns:
        assert part[name].dtype == frame[name].dtype and np.array_equal(part[name], wanted[name])
    assert np.array_equal(part.xyz, frame.xyz[key])
    assert part.xyz.flags.writeable == np.shares_memory(part.xyz, part["y"]) or not len(part)
    assert part.xyz.flags.writeable >= frame.xyz.flags.writeable
    lines = part.lines
    assert np.array_equal(np.repeat(np.arange(len(lines)), lines["point_count"]), wanted["of"])
    assert np.array_equal(lines["first_point"], np.cumsum(lines["point_count"]) - lines["point_count"])
    for name in ("number", "eye", "clock_us", "lost_words"):
        assert np.array_equal(lines[name], frame.lines[name])
    assert (part.number, part.sensor, part.losses, part.utc_ns) == (frame.number, frame.sensor, frame.losses, frame.utc_ns)
    assert pickle.loads(pickle.dumps(part)) == part and (part == frame) == (len(part) == len(frame))


@given(seed=st.integers(0, 2**32 - 1), share=st.sampled_from([0.0, 0.001, 0.3, 0.97, 1.0]))
@cheap
def test_a_mask_is_that_of_numpy(frame, seed, share):
    mask = np.random.default_rng(seed).random(len(frame)) < share
    check_part(frame, mask, frame[mask])
    assert frame[mask] == frame[np.flatnonzero(mask)]


@given(st.data())
@cheap
def test_a_slice_is_that_of_numpy_and_a_view(frame, data):
    place = st.none() | st.integers(-len(frame) - 9, len(frame) + 9)
    key = slice(data.draw(place), data.draw(place), data.draw(st.none() | st.integers(1, 999)))
    part = frame[key]
    check_part(frame, key, part)
    for name in part.columns:
        assert not len(part) or np.shares_memory(part[name], frame[name])
    again = part[::2]
    assert np.array_equal(again["range"], frame["range"][key][::2]) and again == part[np.arange(0, len(part), 2)]


@given(st.data())
@cheap
def test_places_are_those_of_numpy(frame, data):
    places = sorted(data.draw(st.lists(st.integers(0, len(frame) - 1), max_size=20)))
    part = frame[places]
    assert all(np.array_equal(part[name], frame[name][np.array(places, int)]) for name in frame.columns)
    assert np.array_equal(np.repeat(part.lines["number"], part.lines["point_count"]), part["line"])


@given(names=st.sets(st.sampled_from(["x", "y", "z", "range", "pulse_width", "time", "return_number"])), seed=st.integers(0, 99))
@cheap
def test_replaced_columns_are_those_given_and_the_others_are_shared(frame, names, seed):
    before = plain(frame)
    made = {name: np.random.default_rng(seed).permutation(frame[name]) for name in names}
    other = frame.replace(made)
    assert other.columns == frame.columns and np.array_equal(other.lines, frame.lines)
    for name in frame.columns:
        assert np.array_equal(other[name], made.get(name, frame[name])) and np.array_equal(frame[name], before[name])
        assert np.shares_memory(other[name], made.get(name, frame[name]))
    assert np.array_equal(other.xyz, np.array([other[name] for name in "xyz"]).T)
    assert np.shares_memory(other.xyz, other["x"]) == (frame.xyz.flags.writeable and not names & {"x", "y", "z"})
    assert other.xyz.flags.writeable == np.shares_memory(other.xyz, other["x"])
    assert (other == frame) == all(np.array_equal(made[name], frame[name]) for name in names)


@given(dtype=st.sampled_from(TYPES), step=st.sampled_from([1, 2]), fixed=st.booleans())
@cheap
def test_columns_of_ones_own_are_kept_as_they_are(frame, dtype, step, fixed):
    own = (np.arange(len(frame) * step) % 2).astype(dtype)[::step]
    own.flags.writeable = not fixed
    other = frame.with_columns(mine=own)
    assert other.columns == (*frame.columns, "mine") and "mine" not in frame and other != frame
    assert other["mine"] is own and all(np.shares_memory(other[name], frame[name]) for name in frame.columns)
    assert other.with_columns({"mine": own, "second": own}).columns == (*other.columns, "second")
    assert pickle.loads(pickle.dumps(other)) == other
    assert other[5:9]["mine"].dtype == own.dtype and np.array_equal(other[own == 1]["mine"], own[own == 1])
    assert other.replace(range=frame["range"], mine=own)["mine"] is own
    assert other.to_structured().dtype["mine"] == own.dtype


def test_xyz_is_one_array_where_it_was_given_as_one(whole):
    points = np.ascontiguousarray(whole.xyz)
    other = whole.replace(xyz=points)
    assert other.xyz is points and np.shares_memory(other["z"], points) and other == whole
    other["z"][:] = 1
    assert (other.xyz[:, 2] == 1).all() and (whole["z"] != 1).any()
    assert lumsdk.Frame.from_arrays(xyz=points).xyz is points


def test_parts_can_do_what_frames_can(frame):
    mask = (np.arange(len(frame)) % 3 > 0) & (frame["range"] < 60)
    part = frame[mask]
    for eye in ("blue", "green"):
        of = mask & (frame["eye"] == ("blue", "green").index(eye))
        wanted = np.full((64, 1000), np.nan, "f4")
        for at in np.flatnonzero(of)[::-1]:  # of a pixel's points the first
            wanted[frame["line"][at], frame["pixel"][at]] = frame["range"][at]
        assert np.array_equal(part.grid("range", eye, lines=64), wanted, equal_nan=True)
    index, pixels = part.image_index(), part.image_pixels()
    assert index.max() < len(part) and np.array_equal(np.flatnonzero(index.ravel() >= 0), np.unique(pixels[pixels >= 0]))
    assert np.array_equal(part.image("range")[index >= 0], part["range"][index[index >= 0]])
    assert (part["eye"][part.image_index(eye="green")[part.image_index(eye="green") >= 0]] == 1).all()
    K, T = np.array([[500.0, 0, 480], [0, 500, 270], [0, 0, 1]]), np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]], float)
    assert np.array_equal(part.project(K, T).pixels, frame.project(K, T).pixels[mask], equal_nan=True)
    poses = lumsdk.Poses(np.array([0.0, 100.0]), np.tile(np.eye(4), (2, 1, 1)) + np.array([0, 1])[:, None, None] * _way(), clock="sensor",
                         gap=1000, jump=1e6)
    for move in (lambda one: one.deskew(poses), lambda one: one.to_world(poses)):
        assert np.array_equal(move(part).xyz, move(frame).xyz[mask]) and move(part).columns == frame.columns
    own = frame._own[0]
    assert np.array_equal(part.grid(own, "blue").ravel()[:1], frame[mask].grid(own, "blue").ravel()[:1], equal_nan=True)
    assert part.image(own).shape == part.image("range").shape and part._repr_html_()


def _way():
    """10 m forward."""
    way = np.zeros((4, 4))
    way[0, 3] = 10
    return way


def test_a_frame_of_arrays_has_lines_of_its_columns(whole):
    made = lumsdk.Frame.from_arrays(whole.to_dict(), number=whole.number, sensor=whole.sensor, utc_ns=whole.utc_ns,
                                    clock_us=whole.info["begin_clock_us"])
    has = whole.lines[whole.lines["point_count"] > 0]
    for name in ("number", "eye", "first_point", "point_count"):
        assert np.array_equal(made.lines[name], has[name])
    assert np.abs(made.lines["clock_us"] - has["clock_us"]).max() < 2000  # a line's first points may be missing
    for eye in ("blue", "green"):
        assert np.array_equal(made.grid("range", eye, lines=64), whole.grid("range", eye, lines=64), equal_nan=True)
    assert made.time == whole.time and made.sensor == whole.sensor and made.complete and made.utc_error_ns is None
    again = lumsdk.Frame.from_arrays(np.asarray(made), lines=made.lines, number=made.number, sensor=made.sensor, utc_ns=made.utc_ns,
                                     clock_us=made.info["begin_clock_us"])
    assert again == made and all(np.shares_memory(made[name], whole[name]) for name in made.columns)


def test_lines_get_new_numbers_by_columns(whole):
    other = whole.replace(line=whole["line"] + np.uint32(2), eye=1 - whole["eye"])
    has = whole.lines["point_count"] > 0
    assert np.array_equal(other.lines["number"][has], whole.lines["number"][has] + 2)
    assert np.array_equal(other.grid("x", "green", lines=66)[2:], whole.grid("x", "blue", lines=64), equal_nan=True)
    assert other.info["rows_green"] == whole["line"][whole["eye"] == 0].max() + 3


def small(**more):
    return lumsdk.Frame.from_arrays(x=np.zeros(5, "f4"), y=np.zeros(5, "f4"), z=np.zeros(5, "f4"), **more)


MADE = lumsdk.Frame.from_arrays
LINES = np.array([(0, 0, 0, 2), (1, 0, 2, 3)], [("number", "u4"), ("eye", "u1"), ("first_point", "u4"), ("point_count", "u4")])


@pytest.mark.parametrize("call, said", [
    (lambda: small()[np.ones(4, bool)], r"a mask of the shape \(4,\); use \(5,\)"),
    (lambda: small()[np.ones((5, 1), bool)], r"a mask of the shape \(5, 1\); use \(5,\)"),
    (lambda: small()[[3, 1]], r"use frame\[numpy.sort\(places\)\]"),
    (lambda: small()[[0, 5]], "5 is no point of the frame; use 0 to 4"),
    (lambda: small()[[-1, 2]], "-1 in an image_index"),
    (lambda: small()[np.array([2**63], "u8")], "9223372036854775808 is no point"),
    (lambda: small()[np.zeros(5, "u1")], r"all 0 or 1, of type uint8; use .*mask.astype\(bool\)"),
    (lambda: small()[::-1], r'use a step from 1, or frame\["x"\]\[::-1\]'),
    (lambda: small().with_columns(x=np.zeros(5)), r"x is a column that frames have by themselves: replace\(x=...\) sets it"),
    (lambda: small().with_columns(timestamp=np.zeros(5)), "a column that tables and files make .*; leave it out"),
    (lambda: small().with_columns(lines=np.zeros(5)), "an argument of Frame.from_arrays"),
    (lambda: small().with_columns({"my label": np.zeros(5)}), "'my label' cannot be the name"),
    (lambda: small().with_columns({"l" * 32: np.zeros(5)}), "at most 31 ASCII letters"),
    (lambda: small().with_columns(label=np.zeros(4)), "label has 4 values; use 5"),
    (lambda: small().with_columns(label=np.zeros((5, 2))), r"the shape \(5, 2\); use \(n,\)"),
    (lambda: small().replace(y=np.zeros(6, "f4")), "y has 6 values; use 5"),
    (lambda: small().replace(y=np.full(5, 0.1)), r'y: 0.1 at 0 cannot be .* float32; use y.astype\("float32"\), which rounds'),
    (lambda: small().replace(xyz=np.zeros((5, 2))), r"the shape \(5, 2\); use \(n, 3\)"),
    (lambda: small().replace(xyz=np.zeros((5, 3)), x=np.zeros(5)), "use xyz, or x, y and z"),
    (lambda: small().replace({"y": np.zeros(5)}, y=np.zeros(5)), "y is given twice"),
    (lambda: small().replace(line=np.full(5, -1)), "line: -1 at 0 cannot be .* from 0 to 4294967295"),
    (lambda: small().replace(line=np.full(5, -1, "i4")), "line: -1 at 0 cannot be"),
    (lambda: small().replace(pixel=np.full(5, 1000)), "pixel: 1000 at 0; use 0 to 999"),
    (lambda: small(lines=LINES, line=np.zeros(5, "u4")), "differ from the lines"),
    (lambda: small(lines=LINES).replace(line=np.arange(5, dtype="u4")), "points 0 and 1 are of one line .* and have 0 and 1"),
    (lambda: small(lines=LINES[:1]), "they have 2 points; use 5"),
    (lambda: small(lines=LINES[::-1]), "line 0 begins at point 2; use 0"),
    (lambda: small(lines=np.arange(5)), "use a structured array such as Frame.lines"),
    (lambda: small(pixel=np.zeros(5, "u2")).grid("pixel", "blue", lines=-1), "use a whole number from 0"),
    (lambda: small(pixel=np.zeros(5, "u2")).grid("x"), "has no lines, so there is no grid of it"),
    (lambda: small().image("x", eye="blue"), 'use eye="both"'),
    (lambda: small(label=np.arange(5) + 2**24).image("label"), "whole numbers up to 16777216"),
    (lambda: _table.value(small(), "timestamp"), "leave out the column timestamp"),
    (lambda: MADE(rnage=np.zeros(5)), "no column rnage; is it range?"),
    (lambda: MADE(x=[0], y=[0, 1]), "y has 2 values; use 1, one a point, as x has them"),
    (lambda: MADE(), "use at least one"),
    (lambda: MADE(line=[1, 2, 1], eye=[0, 0, 0]), r"points 0 and 2 are of line 1.*numpy.lexsort\(\(line, eye\)\)"),
    (lambda: MADE(x=[0], sensor="front"), 'use its address, such as "10.42.0.37"'),
    (lambda: MADE(x=[0], time=np.float32([3e38])), "time: 3e.38 at 0; use seconds"),
    (lambda: MADE(x=[0], number=-1), "number is -1; use a whole number from 0"),
    (lambda: MADE(x=[0], number=2**31), "use a whole number from 0 to 2147483647"),
])
def test_what_is_not_right_says_what_is(call, said):
    with pytest.raises(ValueError, match=said):
        call()


@pytest.mark.parametrize("call, said", [
    (lambda: small()[3], r"frame\[i:i \+ 1\] is the frame of one point"),
    (lambda: small()[np.ma.masked_less(np.arange(5), 2)], r"a masked array; use .*filled\(False\)"),
    (lambda: small()[["x", "y"]], "not list of type <U1"),
    (lambda: small()[1.5], "takes a column's name, a mask, a slice, or an array of places, not float"),
    (lambda: small().with_columns(label=["a"] * 5), "use bool, integers, or floats"),
    (lambda: small().with_columns(label=np.zeros(5, "c16")), "values of type complex128"),
    (lambda: small().with_columns(label=np.ma.masked_less(np.arange(5), 2)), "a masked array"),
    (lambda: MADE([1, 2]), "use a mapping"),
    (lambda: np.asarray(small(), "f4"), r"not one array of float32: frame.xyz"),
])
def test_what_is_no_array_of_numbers_says_what_is(call, said):
    with pytest.raises(TypeError, match=said):
        call()


def test_a_column_that_is_not_there_is_told():
    with pytest.raises(KeyError, match="no column 'rnage'; did you mean 'range'"):
        small()["rnage"]
    for name, said in ("range", r"only x, y, z: .*or set it by replace\(range=...\)"), ("tof", "open the source with raw=True"):
        with pytest.raises(KeyError, match=said):
            small()[name]
    with pytest.raises(KeyError, match=r"no column 'label' to replace, only x, y, z; with_columns\(\) adds"):
        small().replace(label=np.zeros(5))
    assert small().replace(range=np.arange(5.0)).columns == ("x", "y", "z", "range")


def test_a_grid_counts_returns_by_their_order_wherever_they_stand():
    frame = MADE(x=np.arange(7.0), line=[0, 0, 0, 0, 1, 1, 1], eye=np.zeros(7), pixel=[9, 5, 9, 9, 9, 2, 9])
    grid = frame.grid("x", returns=2)
    assert grid[:, 9].tolist() == [[0, 2], [4, 6]] and grid[0, 5, 0] == 1 and grid[1, 2, 0] == 5 and np.isfinite(grid).sum() == 6


def test_a_grid_shows_of_lines_with_one_number_the_first_that_has_points(whole):
    lines = whole.lines.copy()
    [first, second] = np.flatnonzero((lines["eye"] == 0) & (lines["point_count"] > 0))[:2]
    lines["number"][second] = lines["number"][first]
    frame = MADE({name: whole[name] for name in whole.columns if name != "line"}, lines=lines)
    of = np.repeat(np.arange(len(lines)), lines["point_count"])
    for part, shown in (frame, first), (frame[of != first], second):
        wanted = np.unique(whole["pixel"][of == shown])
        assert np.array_equal(np.flatnonzero(np.isfinite(part.grid("x", "blue")[lines["number"][first]])), wanted)


def test_a_raw_frame_keeps_nothing_of_the_library(make_capture):
    with lumsdk.open(make_capture("-n", 1), raw=True) as source:
        frame = next(iter(source))
    arrays = [frame.angles, frame._raw.marks, *frame.to_dict().values()]
    assert not any(isinstance(base, _columns.Memory) for array in arrays for base in bases(array))


def bases(array):
    while array is not None:
        array = getattr(array, "base", None)
        yield array


def test_a_part_that_was_copied_keeps_no_other_memory(make_capture):
    with lumsdk.open(make_capture("-n", 2)) as source:
        frame = source[1]
    memory = weakref.ref(frame._c)
    kept = frame[frame["range"] < 20], frame[[0, 1]].with_columns(label=[1, 2]), pickle.loads(pickle.dumps(frame[:9]))
    del frame
    gc.collect()
    assert memory() is None and len(kept[2]) == 9


def test_joined_points_keep_columns_and_the_places_of_sensors(make_capture):
    with lumsdk.open(make_capture("-n", 1), rig=[{"name": "front", "address": "10.42.0.37"}]) as source:
        [one] = lumsdk.sync(frame.with_columns(label=frame["pixel"]) for frame in source)
    joined = one.joined()
    assert np.array_equal(joined["label"], joined["pixel"])
    assert joined.replace(sensor=np.full(len(joined), 7))["sensor"].dtype == np.uint8
    with pytest.raises(lumsdk.OptionError, match="sensor: 0.5 at 0 cannot be a number of type uint8"):
        joined.replace(sensor=np.full(len(joined), 0.5))


@pytest.mark.parametrize("kind", ["npy", "npz", "parquet", "array"])
def test_a_frame_is_made_of_what_the_package_made(kind, make_capture, tmp_path):
    pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")
    path = make_capture("-n", 2, name="one.pcap")
    frame = lumsdk.open(path, columns="all")[1]
    out = tmp_path / f"a.{kind}"
    if kind == "array":
        given = frame.to_arrow(columns="all").to_pandas().to_records(index=False)
    else:
        lumsdk.convert(frame, out, columns="all")
        given = importlib.import_module("pandas").read_parquet(out) if kind == "parquet" else np.load(out)
    made = MADE(given)
    assert (made.number, made.sensor, made.columns) == (frame.number, frame.sensor, frame.columns)
    assert np.array_equal(made.xyz, frame.xyz)
    has = frame.lines["point_count"] > 0
    assert np.array_equal(made.lines[["number", "eye", "clock_us"]], frame.lines[has][["number", "eye", "clock_us"]])
    assert MADE(given, number=7, sensor="10.0.0.9", clock_us=5).number == 7
    assert MADE(frame.to_arrow(columns="all")) == MADE(frame.to_arrow(columns="all").to_pandas())
    both = np.concatenate([lumsdk.open(path)[i].to_arrow(["x", "frame"]).to_pandas()["frame"] for i in (0, 1)])
    with pytest.raises(lumsdk.OptionError, match=r'points of 1 and of 2; use those of one frame, .*rows\["frame"\] == 1'):
        MADE(x=np.zeros(len(both)), frame=both)


@pytest.mark.parametrize("time", ["sensor", "utc"])
def test_a_part_of_rows_begins_where_their_frame_began(time, make_capture, tmp_path):
    frame = lumsdk.open(make_capture("-n", 2), columns="all")[1]
    lumsdk.convert(frame, tmp_path / "a.npy", columns="all", time=time)
    rows = np.load(tmp_path / "a.npy")
    later = rows[(rows["time"] > 0.05) & (rows["pixel"] > 500)]
    for part in rows, later:
        made = MADE(part, utc_ns=frame.utc_ns)
        assert made.utc_ns == frame.utc_ns
        assert made.info["begin_clock_us"] == (frame.info["begin_clock_us"] if time == "sensor" else frame.utc_ns // 1000)
    assert MADE(later).utc_ns == (0 if time == "sensor" else frame.utc_ns // 1000 * 1000)
    rows["timestamp"][0] = -5
    with pytest.raises(lumsdk.OptionError, match="timestamp is -5; use a whole number"):
        MADE(rows)


def test_a_frame_of_no_points_has_no_places(whole):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(MADE({"x": np.zeros(0), "sensor": np.zeros(0)})) == 0
    with pytest.raises(TypeError, match="metadata: values of type"):
        MADE(x=np.zeros(2), metadata=np.array(["a", "b"]))


def test_a_frame_is_made_of_a_joined_one(make_capture):
    paths = [make_capture("-n", 1, "--address", f"10.42.0.{i}", name=f"{i}.pcap") for i in (37, 38)]
    rig = [{"name": "front", "address": "10.42.0.37"}, {"name": "left", "address": "10.42.0.38"}]
    [one] = lumsdk.sync(lumsdk.open(paths, rig=rig, columns="all"))
    joined = one.joined()
    with pytest.warns(lumsdk.CaptureWarning, match="places in a rig are left out"):
        made = MADE(np.asarray(joined))
    assert np.array_equal(made.xyz, joined.xyz) and "sensor" not in made
    has = joined.lines["point_count"] > 0
    assert np.array_equal(made.lines[["number", "eye", "point_count"]], joined.lines[has][["number", "eye", "point_count"]])


# --- Files ---


@pytest.fixture(scope="module")
def own(whole):
    """A column of one's own of each type, of some of the points."""
    part = whole[whole["edge"] == 1][::3]
    values = np.arange(len(part))
    return part.with_columns({f"own_{np.dtype(name).name}": (values % 2 if name == "?" else values % 100).astype(name) for name in TYPES})


def of_ply(path):
    head, body = path.read_bytes().split(b"end_header\n", 1)
    types = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8"}
    fields = [line.split()[1:] for line in head.decode().splitlines() if line.startswith("property")]
    return np.frombuffer(body, [(name.replace("scalar_", ""), np.dtype(types.get(kind, kind))) for kind, name in fields])


def of_pcd(path):
    head, body = path.read_bytes().split(b"DATA binary\n", 1)
    said = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines() if line[:1] != "#"}
    return np.frombuffer(body, [(name, f"<{kind.lower()}{size}") for name, kind, size in zip(said["FIELDS"], said["TYPE"], said["SIZE"])])


def of_arrow(path):
    import pyarrow.feather
    import pyarrow.parquet
    table = pyarrow.parquet.read_table(path) if path.suffix == ".parquet" else pyarrow.feather.read_table(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def of_mcap(path):
    """The points of all clouds, in the order of the file."""
    import mcap.reader
    from mcap_ros2.decoder import DecoderFactory
    kinds = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
    out = []
    with path.open("rb") as file:
        for _, _, _, cloud in mcap.reader.make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(["/points"]):
            names = [field.name for field in cloud.fields]
            dtype = np.dtype({"names": names, "formats": [kinds[field.datatype] for field in cloud.fields],
                              "offsets": [field.offset for field in cloud.fields], "itemsize": cloud.point_step})
            out.append((cloud.header.frame_id, np.frombuffer(bytes(cloud.data), dtype)))
    return out


READERS = {"csv": lambda path: np.genfromtxt(path, delimiter=",", names=True), "ply": of_ply, "pcd": of_pcd,
           "las": lambda path: importlib.import_module("laspy").read(path), "laz": lambda path: importlib.import_module("laspy").read(path),
           "parquet": of_arrow, "feather": of_arrow, "npy": np.load, "npz": np.load}
NEEDS = {"las": "laspy", "laz": "lazrs", "parquet": "pyarrow", "feather": "pyarrow"}


@pytest.mark.parametrize("kind", READERS)
def test_columns_of_ones_own_are_in_files(own, kind, tmp_path):
    pytest.importorskip(NEEDS.get(kind, "numpy"))
    path = tmp_path / f"own.{kind}"
    assert lumsdk.convert([own, own[:50]], path)["points"] == len(own) + 50
    found = READERS[kind](path)
    for name in own._own:
        assert np.array_equal(np.asarray(found[name]), np.concatenate([own[name], own[name][:50]])), name
        if kind in ("parquet", "feather", "npy", "npz"):
            assert np.asarray(found[name]).dtype == own[name].dtype


@pytest.mark.parametrize("kind", ["csv", "ply", "pcd", "parquet", "npz"])
def test_columns_can_be_chosen(own, kind, tmp_path):
    pytest.importorskip(NEEDS.get(kind, "numpy"))
    path = tmp_path / f"own.{kind}"
    lumsdk.convert(own, path, columns=["x", "own_float64", "y"])
    found = READERS[kind](path)
    assert np.array_equal(found["own_float64"], own["own_float64"])
    assert "own_uint8" not in (found.dtype.names if hasattr(found, "dtype") else found)


@pytest.mark.parametrize("kind", ["xyz", "bin"])
def test_what_has_no_place_for_them_says_so(own, kind, tmp_path):
    with pytest.warns(lumsdk.CaptureWarning, match=rf"own_bool, .* are left out: {kind} has no place for them; csv, "):
        lumsdk.convert(own, tmp_path / f"own.{kind}")
    with pytest.raises(lumsdk.OptionError, match="columns does not go with"):
        lumsdk.convert(own, tmp_path / f"own.{kind}", columns="own_bool")


def test_a_preset_has_no_place_for_them(own, tmp_path):
    pytest.importorskip("pyarrow")
    with pytest.warns(lumsdk.CaptureWarning, match="are left out: the preset argoverse2 has no place for them"):
        lumsdk.convert(own, tmp_path / "own.feather", preset="argoverse2")


@pytest.mark.parametrize("made, kind, said", [
    (lambda own: [own, own.with_columns(more=own["own_bool"])], "npy", "frame 2 has other columns of its own .* more .bool."),
    (lambda own: [own, own.with_columns(own_int8=own["own_float32"])], "csv", "own_int8 .float32."),
    (lambda own: own.with_columns(scan_angle=own["own_bool"]), "las", "scan_angle is one of the format's own"),
    (lambda own: own.with_columns(scan_angle=own["own_bool"]), "laz", "scan_angle is one of the format's own"),
    (lambda own: own.with_columns(own_int64=own["own_int64"] + 2**31), "ply", "from 2147483648 to .* 32-bit integers"),
    (lambda own: small(), "csv", "has no lines, which the file's columns .* need: .*, or choose other columns"),
    (lambda own: small(), "las", "has no lines, which the file's columns .* need: .*, or lines=$"),
    (lambda own: MADE(own.to_dict()), "mcap", r"frame 0 has no times of arrival: give Frame.from_arrays\(\) utc_ns="),
])
def test_a_file_that_cannot_have_them_is_none(own, made, kind, said, tmp_path):
    pytest.importorskip(NEEDS.get(kind, "numpy"))
    with pytest.raises(lumsdk.OptionError, match=said):
        lumsdk.convert(made(own), tmp_path / f"own.{kind}")
    assert not list(tmp_path.iterdir())


def test_messages_are_those_of_lumdump_and_have_columns_of_ones_own(make_capture, tmp_path):
    pytest.importorskip("mcap_ros2")
    path = make_capture("-n", 1)
    lumsdk.convert(path, tmp_path / "a.mcap")
    lumsdk.convert(path, tmp_path / "b.mcap", broken="raise")
    [(name, wanted)], [(other, found)] = of_mcap(tmp_path / "a.mcap"), of_mcap(tmp_path / "b.mcap")
    assert name == other == "luminar" and found.tobytes() == wanted.tobytes()
    [frame] = lumsdk.open(path, columns="all")
    poses = lumsdk.Poses(np.array([0.0, 1e3]), np.tile(np.eye(4), (2, 1, 1)), clock="sensor", gap=1e4, jump=1e6)
    own = frame.with_columns(label=frame["pixel"].astype("i8"), near=frame["range"] < 9, x2=frame["x"].astype("f8"))
    with pytest.raises(lumsdk.OptionError, match=r"frame 1 is in the world, unlike the first one; use frames that to_world"):
        lumsdk.convert([own, own.to_world(poses)], tmp_path / "c.mcap")
    lumsdk.convert([own, own.deskew(poses)], tmp_path / "c.mcap")
    for _, found in of_mcap(tmp_path / "c.mcap"):
        assert np.array_equal(found["x2"], found["x"]) and found["label"].dtype == np.int32
        assert sorted(found["label"]) == sorted(frame["pixel"]) and found["near"].sum() == own["near"].sum()
    lumsdk.convert(own.to_world(poses), tmp_path / "d.mcap")
    assert of_mcap(tmp_path / "d.mcap")[0][0] == "map"


def test_a_cloud_without_lines_is_a_file(tmp_path):
    frame = small(label=np.arange(5))
    lumsdk.convert(frame, tmp_path / "a.ply", columns="x,y,z,label")
    assert of_ply(tmp_path / "a.ply")["label"].tolist() == [0, 1, 2, 3, 4]
    lumsdk.convert(small(), tmp_path / "a.xyz")
    assert len((tmp_path / "a.xyz").read_text().splitlines()) == 5


def test_files_of_a_part_have_its_points(whole, tmp_path):
    mask = whole["range"] < 15
    lumsdk.convert(whole[mask], tmp_path / "a.ply")
    found = of_ply(tmp_path / "a.ply")
    assert np.array_equal(found["x"], whole["x"][mask]) and np.array_equal(found["line"], whole["line"][mask])


# --- Other libraries ---


def test_arrow_takes_a_frame_without_copies(own):
    pa = pytest.importorskip("pyarrow")
    table = pa.table(own)
    assert table.equals(own.to_arrow()) and set(own.columns) < set(table.column_names)
    batches = list(pa.RecordBatchReader.from_stream(own))
    assert [batch.num_rows for batch in batches] == [len(own)]
    array = own.replace(range=own["range"].copy())
    address = pa.table(array)["range"].chunk(0).buffers()[1].address
    assert address == array["range"].__array_interface__["data"][0]
    asked = pa.schema([field.with_type(pa.float64()) if field.name == "x" else field for field in table.schema])
    assert pa.RecordBatchReader.from_stream(own, schema=asked).read_all()["x"].to_numpy().dtype == np.float64


def test_polars_takes_a_frame(own):
    polars = pytest.importorskip("polars")
    table = polars.DataFrame(own)
    assert table.height == len(own) and np.array_equal(table["own_int16"].to_numpy(), own["own_int16"])


def test_numpy_takes_a_frame_as_records(own):
    records = np.asarray(own)
    assert records.dtype.names == own.columns and all(np.array_equal(records[name], own[name]) for name in own.columns)
    with pytest.raises(ValueError, match="use copy=None"):
        own.__array__(copy=False)


@pytest.mark.skipif(not hasattr(np, "from_dlpack"), reason="this NumPy has no from_dlpack")
def test_dlpack_shares_each_column(own):
    is_new = tuple(map(int, np.__version__.split(".")[:2])) >= (2, 1)
    for name in own.columns:
        if is_new or own[name].dtype != bool:
            assert np.shares_memory(np.from_dlpack(own[name]), own[name])
    fixed = own["line"].copy()
    fixed.flags.writeable = False
    if is_new:
        shared = np.from_dlpack(own.replace(line=fixed)["line"])
        assert np.shares_memory(shared, fixed) and not shared.flags.writeable


def test_raw_frames_keep_their_raw_part(make_capture, tmp_path):
    path = make_capture("-n", 2)
    (frame, *_) = lumsdk.open(path, raw=True)
    for other in (frame.with_columns(label=frame["pixel"]), frame.replace(tof=frame["tof"].copy()), frame[:], frame[frame["tof"] > -1e6]):
        assert np.array_equal(other.angles, frame.angles) and np.array_equal(other.packets, frame.packets)
        assert np.array_equal(other["tof"], frame["tof"]) and pickle.loads(pickle.dumps(other)) == other
        again = other.with_raw(other.angles)
        assert all(np.shares_memory(again[name], other[name]) for name in other.columns)
        assert other.to_lines()[0].tof.tolist() == frame.to_lines()[0].tof.tolist()
    with pytest.raises(lumsdk.OptionError, match="tof is a column that frames have by themselves"):
        frame.with_columns(tof=frame["tof"])
    with pytest.raises(lumsdk.OptionError, match="raw_azimuth: 32768 at 0 cannot be .* from -32768 to 32767"):
        frame.replace(raw_azimuth=frame["raw_azimuth"].astype("i4") * 0 + 32768)
