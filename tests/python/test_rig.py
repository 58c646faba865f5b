"""Rigs: their files and mappings, captures that are read by one, and what does not go together."""
import json
import os
import pickle
import subprocess
import threading
import warnings

import lumsdk
import numpy as np
import pytest
from conftest import BIN
from hypothesis import given
from hypothesis import strategies as st

RIG = """version: 1
frame: chassis
sensors:
  - {name: front, address: 10.42.0.37, interface: eth0, calibration: front.yaml, pose: {x_m: 1.2, z_m: 1.8, pitch_deg: 3}}
  - {name: left, address: 10.42.0.37%eth1, pose: {y_m: 0.9, z_m: 1.7, yaw_deg: 90, roll_deg: -2.5}}
  - name: back
    address: 10.42.0.38
    profile: back.yaml
    pose: {x_m: -2, z_m: 1.6, yaw_deg: 180}
"""
FRONT = lumsdk.Calibration({"eyes.blue.mount.yaw_deg": -30.5, "eyes.green.tof_offset_ps": 1500})
BACK = lumsdk.Profile({"data_packet_type": 77})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """rig.yaml with the files that it names."""
    made = tmp_path_factory.mktemp("rig")
    (made / "rig.yaml").write_text(RIG)
    (made / "front.yaml").write_text(FRONT.to_yaml())
    (made / "back.yaml").write_text(BACK.to_yaml())
    return made


@pytest.fixture(scope="module")
def rig(folder):
    return lumsdk.Rig(folder / "rig.yaml")


# --- Rigs ---


def test_a_file_has_all(rig):
    assert list(rig) == ["front", "left", "back"] and rig.frame == "chassis" and len(rig) == 3
    assert (rig["left"].address, rig["left"].interface) == ("10.42.0.37", "eth1")
    assert rig["front"].calibration == FRONT and rig["front"].profile == lumsdk.Profile()
    assert rig["back"].profile == BACK and rig["back"].interface == ""
    assert np.allclose(rig["back"].pose, [[-1, 0, 0, -2], [0, -1, 0, 0], [0, 0, 1, 1.6], [0, 0, 0, 1]])
    assert rig["back"].pose.dtype == np.float64 and not rig["back"].pose.flags.writeable
    with pytest.raises(lumsdk.UnknownKeyError, match="no sensor 'lft'; did you mean 'left'"):
        rig["lft"]
    assert repr(rig) == "<Rig front (10.42.0.37%eth0), left (10.42.0.37%eth1), back (10.42.0.38)>"


def test_a_rig_is_the_same_however_it_is_given(rig, folder, tmp_path, monkeypatch):
    assert pickle.loads(pickle.dumps(rig)) == rig and hash(pickle.loads(pickle.dumps(rig))) == hash(rig)
    assert lumsdk.Rig(rig) == rig
    rig.save(tmp_path / "own.yaml")
    assert lumsdk.Rig(tmp_path / "own.yaml") == rig
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own-back-profile.yaml", "own-front-calibration.yaml", "own.yaml"]
    monkeypatch.chdir(folder)
    assert lumsdk.Rig(RIG) == lumsdk.Rig("rig.yaml") == rig
    sensors = [{"name": "front", "address": "10.42.0.37%eth0", "calibration": dict(FRONT), "pose": rig["front"].pose},
               {"name": "left", "address": "10.42.0.37", "interface": "eth1", "pose": rig["left"].pose.astype("f4")},
               {"name": "back", "address": "10.42.0.38", "profile": BACK, "pose": {"x_m": -2, "z_m": 1.6, "yaw_deg": 180.0}}]
    assert lumsdk.Rig({"version": 1, "frame": "chassis", "sensors": sensors}) == rig
    assert lumsdk.Rig(sensors) != rig and lumsdk.Rig(sensors).frame == "base_link"
    with pytest.raises(lumsdk.OptionError, match="calibration of front is not the default.*save"):
        rig.to_yaml()
    text = rig.to_yaml({("front", "calibration"): "front.yaml", ("back", "profile"): "back.yaml"})
    assert lumsdk.Rig(text) == rig
    assert rig != lumsdk.Rig(text.replace("1.8", "1.8001"))


@given(st.lists(st.floats(-180, 180), min_size=3, max_size=3), st.lists(st.floats(-1000, 1000), min_size=3, max_size=3))
def test_a_matrix_is_the_pose_to_a_micrometre(angles, at):
    keys = dict(zip(("roll_deg", "pitch_deg", "yaw_deg", "x_m", "y_m", "z_m"), [*angles, *at]))
    pose = lumsdk.Rig([{"name": "a", "address": "1.2.3.4", "pose": keys}])["a"].pose
    again = lumsdk.Rig([{"name": "a", "address": "1.2.3.4", "pose": pose}])["a"].pose
    assert np.abs(again - pose).max() < 1e-6


BAD_FILES = [
    ("", "1: nothing but blanks or comments; begin with 'version: 1'"),
    ("5\n", "1: not a mapping of keys; allowed here: version, frame, sensors"),
    ("version: 1\n", " sensors: missing; a rig has 1 to 8 sensors"),
    ("sensors:\n  - {name: a, address: 1.2.3.4}\n", "1: version: missing; a rig needs 'version: 1'"),
    ("version: 2\n", "1: version: '2' is out of range; allowed: 1"),
    ("version: 1\nsensors: 5\n", "2: sensors: '5' is no list; allowed: a list of 1 to 8 sensors, each begun by '-'"),
    ("version: 1\nsensors: {a: 1}\n", "2: sensors: a mapping does not belong here; allowed: a list of 1 to 8"),
    ("version: 1\nfrme: x\n", "2: unknown key 'frme'; did you mean 'frame'"),
    ("version: 1\nframe: 'base link'\n", "2: frame: 'base link' has another character; allowed: 1 to 63 letters"),
    ("version: 1\nsensors:\n  - 5\n", "3: sensors.1: not a mapping of keys"),
    ("version: 1\nsensors:\n  - {}\n", "3: sensors.1: has no keys; each sensor needs a name and its address"),
    ("version: 1\nsensors:\n  - {address: 1.2.3.4}\n", "3: sensors.1.name: missing; each sensor needs a name"),
    ("version: 1\nsensors:\n  - {name: a}\n", "3: sensors.1.address: missing; each sensor needs its address"),
    ("version: 1\nsensors:\n  - {name: 5a, address: 1.2.3.4}\n", "3: sensors.1.name: '5a' does not begin with a letter"),
    ("version: 1\nsensors:\n  - name: [a]\n", "3: sensors.1.name: a sequence does not belong here; allowed: 1 to 31"),
    ("version: 1\nsensors:\n  - {name: é, address: 1.2.3.4}\n", r"3: sensors.1.name: '\xc3\xa9' does not begin with a letter"),
    ("version: 1\nsensors:\n  - {name: , address: 1.2.3.4}\n", "3: sensors.1.name: no value; allowed: 1 to 31 letters"),
    ("version: 1\nsensors:\n  - name: a\n    name: b\n", "4: sensors.1.name: repeated; it is already on line 3"),
    ("version: 1\nsensors:\n  - name: a\n    address: here\n", "4: sensors.1.address: 'here' is not an IPv4 address; allowed: "),
    ("version: 1\nsensors:\n  - {name: a, adress: 1.2.3.4}\n", "3: sensors.1: unknown key 'adress'; did you mean 'address'"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, pose: {x: 1}}\n", "3: sensors.1.pose: unknown key 'x'; "),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, pose: 1}\n", "3: sensors.1.pose: a single value does not belong here"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, pose: {x_m: '1'}}\n", "3: sensors.1.pose.x_m: '1' is text; write a "),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, pose: {x_m: 1001}}\n", "3: sensors.1.pose.x_m: '1001' is out of range"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, pose: {x_m: ü}}\n", "3: sensors.1.pose.x_m: "),
    ("version: 1\nsensors:\n  - &a {name: a}\n", "3: sensors.1: anchors (&) are not accepted"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4}\n  - name: A\n    address: 1.2.3.5\n",
     "4: sensors.2.name: another sensor has this name"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4}\n  - name: b\n    address: 1.2.3.4\n",
     "5: sensors.2.address: 1.2.3.4 is already that of 'a'; to tell them apart, give each an interface of its own"),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, calibration: no.yaml}\n", "3: sensors.1.calibration: "),
    ("version: 1\nsensors:\n  - {name: a, address: 1.2.3.4, profile: bad.yaml}\n", "3: sensors.1.profile: "),
    ("version: 1\nsensors:\n" + "".join(f"  - {{name: a{i}, address: 1.2.3.{i}}}\n" for i in range(9)),
     "11: sensors.9: more than the 8 that are accepted"),
]


@pytest.mark.parametrize(("content", "said"), BAD_FILES, ids=[said for _, said in BAD_FILES])
def test_what_a_file_says_wrong_is_told_as_lumdump_tells_it(content, said, folder, tmp_path, capture):
    (tmp_path / "bad.yaml").write_text("version: 1\ngroup: 5\n")
    path = tmp_path / "wrong.yaml"
    path.write_text(content)
    with pytest.raises(lumsdk.OptionError) as refusal:
        lumsdk.Rig(path)
    assert str(refusal.value).startswith(f"{path}:{said}")
    done = subprocess.run([BIN / "lumdump", capture, "--rig", path], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, f"lumdump: {refusal.value}\n")


A = {"name": "a", "address": "1.2.3.4"}


@pytest.mark.parametrize(("value", "kind", "said"), [
    (5, TypeError, "a rig is a path, a text of YAML, a mapping, a list"),
    ([], lumsdk.OptionError, "the rig: sensors: missing; a rig has 1 to 8"),
    ({"front": {"address": "1.2.3.4"}}, lumsdk.OptionError, "'front' is not a key of a rig; use version, frame, sensors; sensors"),
    ([5], TypeError, "the rig: sensors.1 is 5; use a mapping"),
    ([{}], lumsdk.OptionError, "the rig: sensors.1: has no keys"),
    ({"sensors": A}, TypeError, "use a list of mappings"),
    ({"frame": None, "sensors": [A]}, TypeError, "'frame': use a text"),
    ({"frames": "x", "sensors": [A]}, lumsdk.OptionError, "unknown key 'frames'; did you mean 'frame'"),
    ([A, A], lumsdk.OptionError, "the rig: sensors.2.name: another sensor has this name"),
    ([{**A, "address": 5}], lumsdk.OptionError, "sensors.1.address: '5' is not an IPv4 address"),
    ([{**A, "address": None}], TypeError, "sensors.1.address: a value is a text or a number, not NoneType"),
    ([{**A, 5: "x"}], TypeError, "sensors.1: a key is a text"),
    ([{**A, "calibration": {"eyes.red": 1}}], lumsdk.OptionError, "the rig: sensors.1.calibration: the calibration: "),
    ([{**A, "profile": 5}], TypeError, "the rig: sensors.1.profile: a profile is a path"),
    ([{**A, "pose": {"x_m": float("nan")}}], lumsdk.OptionError, "sensors.1.pose.x_m: 'nan' is not a decimal number"),
    ([{**A, "pose.x_m": 1, "pose": {"x_m": 2}}], lumsdk.OptionError, "sensors.1.pose.x_m: repeated"),
    ([{**A, "pose": np.eye(3)}], lumsdk.OptionError, r"sensors.1.pose: it is not a pose; use a mapping of x_m, .* or a \(4, 4\)"),
    ([{**A, "pose": np.diag([1, 1, 1.001, 1])}], lumsdk.OptionError, "sensors.1.pose: the first three columns are not a rotation"),
    ([{**A, "pose": np.diag([1, 1, -1, 1])}], lumsdk.OptionError, "are not a rotation"),
    ([{**A, "name": f"a{i}", "address": f"1.2.3.{i}"} for i in range(9)], lumsdk.OptionError, "it has 9 sensors; use 1 to 8"),
])
def test_what_a_mapping_says_wrong_is_told(value, kind, said):
    with pytest.raises(kind, match=said):
        lumsdk.Rig(value)


# --- Captures ---


@pytest.fixture(scope="module")
def drive(folder):
    """A capture of the rig, which lost 1 % of its packets."""
    return lumsdk.simulate(folder / "drive.pcapng", frames=4, rig=folder / "rig.yaml", loss=0.01)


def alone(drive, sensor, **options):
    """The capture as if there were only this sensor, by its own calibration and profile."""
    name = sensor.address + (f"%{sensor.interface}" if sensor.interface else "")
    return lumsdk.open(drive, sensor=name, calibration=sensor.calibration, profile=sensor.profile, **options)


def test_points_are_those_of_each_sensor_moved_by_its_pose(drive, rig):
    seen = {name: [] for name in rig}
    with lumsdk.open(drive, rig=rig, columns="all") as source:
        for frame in source:
            seen[frame.sensor].append(frame)
        assert sorted(source.sensors) == sorted(rig) and source.rig == rig
        lost = {name: counts["lost_words"] for name, counts in source.counts_by_sensor.items()}
        assert sum(lost.values()) == source.losses["lost_words"] > 0
    for name, sensor in rig.items():
        own = alone(drive, sensor, columns="all")
        want = list(own)
        assert len(seen[name]) == len(want) == 4 and lost[name] == own.losses["lost_words"]
        for frame, one in zip(seen[name], want):
            assert (frame.number, frame.complete, frame.losses) == (one.number, one.complete, one.losses)
            assert np.array_equal(frame.pose, sensor.pose) and one.pose is None
            moved = one.xyz.astype("f8") @ sensor.pose[:3, :3].T + sensor.pose[:3, 3]
            assert np.abs(frame.xyz - moved).max() < 1e-4
            for column in set(one.columns) - set("xyz"):
                assert np.array_equal(frame[column], one[column], equal_nan=True), column


def test_a_picture_is_seen_by_the_sensor(drive, rig):
    placed = next(frame for frame in lumsdk.open(drive, rig=rig) if frame.sensor == "left" and not frame.first)
    own = next(frame for frame in alone(drive, rig["left"]) if frame.number == placed.number)
    same = placed.image_pixels() == own.image_pixels()
    assert same.mean() > 0.999  # but for those at the edge of a pixel


def test_sets_are_complete_at_losses_but_for_what_is_named(drive, rig):
    with lumsdk.open(drive, rig=rig) as source:
        sets = list(lumsdk.sync(source))
        total = source.counts["points"]
        parts = list(lumsdk.sync(source, tolerance=0))
    assert [made.complete for made in sets] == [True] * 4 and all(list(made) == list(rig) for made in sets)
    assert len(parts) == 12 and all(len(made.missing) == 2 for made in parts)
    joined = [made.joined() for made in sets]
    assert sum(map(len, joined)) == total
    assert [np.unique(one["sensor"]).tolist() for one in joined] == [[0, 1, 2]] * 4
    assert all(np.array_equal(one.xyz[one["sensor"] == 1], made["left"].xyz) for one, made in zip(joined, sets))


def test_one_sensor_of_the_rig(drive, rig):
    with lumsdk.open(drive, rig=rig, sensor="left") as source:
        frames = list(source)
        assert {frame.sensor for frame in frames} == {"left"} and np.array_equal(frames[0].pose, rig["left"].pose)
        [made] = [made for made in lumsdk.sync(source) if made["left"].number == frames[1].number]
        assert set(made.joined()["sensor"]) == {1}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        every = [frame for frame in lumsdk.open(drive, rig=rig) if frame.sensor == "left"]
        assert len(list(lumsdk.open(drive, rig=rig, sensor="left"))) == len(every)  # the others are in the rig
        source = lumsdk.open(drive, rig=rig, sensor="left")
        assert len(list(source)) == len(every) and sorted(source.sensors) == ["back", "front", "left"]
        assert source.counts["unknown_type"] == 0
    assert frames == every
    two = {"version": 1, "sensors": [{"name": "back", "address": "10.42.0.38", "profile": BACK}, {"name": "roof", "address": "10.42.0.99"}]}
    with pytest.warns(lumsdk.CaptureWarning) as said:
        assert list(lumsdk.open(drive, rig=two, sensor="back"))
    assert [str(one.message).partition(": ")[2][:51] for one in said] == ["2 sensors sent data and are not in the rig, so they"]


def test_a_rig_goes_where_a_source_goes(drive, rig, folder):
    with lumsdk.open(drive, rig=folder / "rig.yaml") as source:
        frames = list(source)
        for place in (0, 7, len(frames) - 1, -2):
            assert source[place] == frames[place]
        assert list(source[3:6]) == frames[3:6] and len(source) == len(frames)
        again = pickle.loads(pickle.dumps(source))
        assert list(again) == frames and again.rig == rig
        for frame, same in zip(frames, pickle.loads(pickle.dumps(frames))):
            assert frame == same and frame.sensor == same.sensor and np.array_equal(frame.pose, same.pose)
        source.seek(frames[6].utc_ns)
        assert next(iter(source)).utc_ns >= frames[6].utc_ns
    got = []
    threads = [threading.Thread(target=lambda: got.append(list(lumsdk.open(drive, rig=rig)))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert got == [frames, frames]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_rig_after_a_fork(drive, rig):
    source = lumsdk.open(drive, rig=rig)
    want = [(frame.sensor, len(frame)) for frame in source]
    receiver, sender = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(sender, pickle.dumps([(frame.sensor, len(frame)) for frame in source]))
        finally:
            os._exit(0)
    os.close(sender)
    with os.fdopen(receiver, "rb") as file:
        assert pickle.loads(file.read()) == want
    os.waitpid(child, 0)


def test_a_selection_is_of_the_vehicle_but_for_the_range(drive, rig):
    with lumsdk.open(drive, rig=rig, box=((0, None), (None, None), (None, None)), range=(5, 40)) as source:
        frames = [frame for frame in source if len(frame)]
    assert all(frame["x"].min() >= 0 and frame["range"].min() >= 5 and frame["range"].max() <= 40 for frame in frames)


def test_what_the_rig_and_the_capture_do_not_share_is_told(drive):
    two = lumsdk.Rig([{"name": "back", "address": "10.42.0.38", "profile": BACK}, {"name": "roof", "address": "10.42.0.99"}])
    with pytest.warns(lumsdk.CaptureWarning) as said:
        frames = list(lumsdk.open(drive, rig=two))
    assert {frame.sensor for frame in frames} == {"back"}
    told = [str(warning.message) for warning in said]
    assert any("the rig's sensor 10.42.0.99 sent no data; these did: " in one and "10.42.0.37%eth0" in one for one in told)
    assert any("2 sensors sent data and are not in the rig, so they were left out; to have them, name in the rig: " in one
               for one in told)
    assert len(told) == 2
    with pytest.raises(lumsdk.CaptureError, match=r"no data of roof \(10.42.0.99\) in it, but of "):
        list(lumsdk.open(drive, rig=[{"name": "roof", "address": "10.42.0.99"}]))


def test_what_does_not_go_with_a_rig_is_refused(drive, rig, tmp_path):
    for name, value in (("calibration", FRONT), ("profile", BACK), ("set", {"tof_lsb_ps": 12})):
        with pytest.raises(lumsdk.OptionError, match=f"{name} does not go with rig, which has a calibration and a profile for each"):
            lumsdk.open(drive, rig=rig, **{name: value})
    with pytest.raises(lumsdk.OptionError, match="sensor is '10.42.0.37'; use one of the rig: front, left, back"):
        lumsdk.open(drive, rig=rig, sensor="10.42.0.37")
    with lumsdk.open(drive, rig=rig) as source, pytest.raises(lumsdk.OptionError, match=r"source.rig\[\"front\"\].calibration"):
        source.calibration
    with lumsdk.open(drive) as source:
        assert source.rig is None


def test_a_calibration_of_the_capture_is_not_taken_and_that_is_told(make_capture, folder, tmp_path):
    own = tmp_path / "own.pcapng"
    subprocess.run([BIN / "lumdump", "-q", make_capture("-n", 2), "-o", own, "--calibration", folder / "front.yaml"], check=True)
    with pytest.warns(lumsdk.CaptureWarning, match="calibration of its own, which is not used: the rig names those of each sensor"):
        frames = list(lumsdk.open(own, rig=[{"name": "a", "address": "10.42.0.37"}]))
    assert np.array_equal(frames[0].xyz, next(iter(lumsdk.open(own, calibration=lumsdk.Calibration()))).xyz)


# --- Files ---


COLUMNS = ["x", "y", "z", "frame", "sensor"]


@pytest.fixture(scope="module")
def frames(drive, rig):
    return list(lumsdk.open(drive, rig=rig, columns="all"))


def read(path):
    """The columns of COLUMNS of a file that convert() made, and the type of sensor."""
    if path.suffix == ".npy":
        table = np.load(path)
    elif path.suffix == ".parquet":
        table = pytest.importorskip("pyarrow.parquet").read_table(path).to_pandas()
    elif path.suffix == ".laz":
        table = pytest.importorskip("laspy").read(path)
    else:
        table = pytest.importorskip("pandas").read_csv(path, comment="#")
    return [np.asarray(table[name]) for name in COLUMNS]


@pytest.mark.parametrize(("kind", "way"), [("npy", "capture"), ("csv", "capture"), ("parquet", "source"), ("laz", "source"),
                                           ("npy", "frames"), ("csv", "frames")])
def test_a_file_has_the_places_of_its_sensors(kind, way, drive, rig, frames, tmp_path):
    pytest.importorskip({"parquet": "pyarrow", "laz": "laspy", "csv": "pandas"}.get(kind, "numpy"))
    path = tmp_path / f"a.{kind}"
    frames = [frame for frame in frames if frame.number == 2]
    if way == "capture":
        made = lumsdk.convert(drive, path, rig=rig, frames=2)
    elif way == "source":
        with lumsdk.open(drive, rig=rig, columns="all", frames=2) as source:
            made = lumsdk.convert(source, path)
    else:
        made = lumsdk.convert(iter(frames), path)
    assert made["frames"] == len(frames) and made["points"] == sum(map(len, frames))
    assert way == "frames" or sorted(made["sensors"]) == sorted(rig)
    columns = read(path)
    places = np.concatenate([np.full(len(frame), list(rig).index(frame.sensor)) for frame in frames])
    if way == "capture" and kind == "csv":  # lumdump's, line by line as they come
        assert [np.sum(columns[4] == place) for place in range(3)] == [np.sum(places == place) for place in range(3)]
        return
    assert np.array_equal(columns[4], places) and (kind == "csv" or columns[4].dtype == np.uint8)
    for i, name in enumerate("xyz"):
        assert np.abs(columns[i] - np.concatenate([frame[name] for frame in frames])).max() < 1e-3


@pytest.mark.parametrize("kind", ["npy", "csv"])
def test_times_of_several_sensors_are_utc(kind, drive, rig, tmp_path):
    """Their clocks differ by up to a minute; those of one sensor stay its own."""
    def times(made, source=drive, name="left", **options):
        path = tmp_path / f"{made}.{kind}"
        lumsdk.convert(source, path, frames=2, **options) if source is drive else lumsdk.convert(source, path, **options)
        path = str(path).replace("%s", "left").replace("joined-%d", name)
        return np.load(path)["timestamp"] if kind == "npy" else pytest.importorskip("pandas").read_csv(path, comment="#")["timestamp"]

    def opened(**options):
        return lumsdk.open(drive, rig=rig, columns="all", frames=2, **options)

    assert min(times("all", rig=rig)) > 1e15 and min(times("all", opened())) > 1e15 and min(times("all", list(opened()))) > 1e15
    assert max(times("%s", rig=rig)) < 1e9 and max(times("%s", opened())) < 1e9
    assert max(times("one", rig=rig, sensor="left")) < 1e9 and max(times("one", opened(sensor="left"))) < 1e9
    assert min(times("all", rig=rig, time="arrival")) > 1e15
    [joined, *_] = [made.joined() for made in lumsdk.sync(opened())]
    assert min(times("all", [joined])) > 1e15 and min(times("joined-%d", [joined], name=f"joined-{joined.number}")) > 1e15
    poses = tmp_path / "poses.txt"
    poses.write_text("".join(f"{t} 0 0 0 0 0 0 1\n" for t in range(90)))
    for source in (drive, opened(), list(opened()), [joined]):
        with pytest.raises(lumsdk.OptionError, match="sensor has a clock of its own"):
            times("all", source, time="sensor", **({"rig": rig} if source is drive else {}))
        with pytest.raises(lumsdk.OptionError, match="has times of a sensor's clock, and each sensor"):
            times("all", source, poses=poses, **({"rig": rig} if source is drive else {}))
    with pytest.raises(lumsdk.OptionError, match="has times of a sensor's clock, and each sensor"):
        joined.deskew(lumsdk.Poses(poses))


def test_tables_of_frames_have_the_place(frames):
    pytest.importorskip("pyarrow")
    table = frames[1].to_arrow()
    assert str(table.schema.field("sensor").type) == "uint8"
    assert set(table["sensor"].to_pylist()) == {["front", "left", "back"].index(frames[1].sensor)}


@pytest.mark.parametrize("kind", ["npy", "ply"])
def test_each_sensor_has_files_of_its_own(kind, drive, rig, frames, tmp_path):
    made = lumsdk.convert(drive, tmp_path / f"all-%s.{kind}", rig=rig)
    assert sorted(map(os.path.basename, made["outputs"])) == [f"all-back.{kind}", f"all-front.{kind}", f"all-left.{kind}"]
    assert made["points"] == sum(map(len, frames))
    if kind == "npy":
        left = np.load(tmp_path / "all-left.npy")
        assert "sensor" not in left.dtype.names and len(left) == sum(len(frame) for frame in frames if frame.sensor == "left")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of packets of the others, which fit the layouts that the rig has for them
        made = lumsdk.convert(drive, tmp_path / f"%s-%04d.{kind}", rig=rig, sensor="left")
    assert len(made["outputs"]) == sum(frame.sensor == "left" and len(frame) > 0 for frame in frames)


def test_names_that_cannot_be_are_refused(drive, rig, frames, tmp_path):
    with pytest.raises(lumsdk.OptionError, match="%s stands for the name of a rig's sensor: give rig= too"):
        lumsdk.convert(drive, tmp_path / "%s.npy")
    with pytest.raises(lumsdk.OptionError, match="%s stands for the sensor's name, and has to be there once"):
        lumsdk.convert(drive, tmp_path / "%s-%s.npy", rig=rig)
    with pytest.raises(lumsdk.OptionError, match="frames of several sensors have the same numbers: put %s"):
        lumsdk.convert(drive, tmp_path / "%04d.npy", rig=rig)
    read = tmp_path / "rig.npy"
    rig.save(read)
    with pytest.raises(lumsdk.OptionError, match="rig.npy is the rig, which this run reads: name another output"):
        lumsdk.convert(drive, read, rig=read)
    bare = next(iter(lumsdk.open(drive, columns="all")))
    with pytest.raises(lumsdk.OptionError, match="%s stands for the name of a rig's sensor, and a frame of 10.42.0"):
        lumsdk.convert([bare], tmp_path / "%s.npy")
    with pytest.raises(lumsdk.OptionError, match="some frames were read with a rig, others without"):
        lumsdk.convert([frames[0], bare], tmp_path / "a.npy")
    assert not [path for path in tmp_path.iterdir() if path.stat().st_size and "part" in path.name]


def test_files_of_frames_say_the_rig_or_nothing(drive, rig, frames, tmp_path):
    front = [frame for frame in frames if frame.sensor == "front"]
    with lumsdk.open(drive, rig=rig, columns="all", frames=2) as source:
        [joined, *_] = [made.joined() for made in lumsdk.sync(source)]
    for points in joined, front, iter(frames):
        lumsdk.convert(points, tmp_path / "a.ply")
        said = (tmp_path / "a.ply").read_bytes().split(b"end_header")[0].decode()
        assert all(json.dumps(line) in said for line in rig.describe()) and "calibration:" not in said
        lumsdk.convert(points if isinstance(points, (list, lumsdk.Frame)) else frames, tmp_path / "a.npz")
        about = json.loads(str(np.load(tmp_path / "a.npz")["metadata"]))
        assert json.loads(about["lumsdk.rig"]) == rig.describe()
        assert not {"lumsdk.calibration", "lumsdk.profile", "lumsdk.options"} & set(about)
    bare = next(iter(lumsdk.open(drive, columns="all", calibration={"eyes.blue.mount.x_m": 1})))
    lumsdk.convert(bare, tmp_path / "a.ply")
    assert b"calibration:" not in (tmp_path / "a.ply").read_bytes().split(b"end_header")[0]
    other = next(iter(lumsdk.open(drive, rig=[{"name": "front", "address": "10.42.0.37"}], columns="all")))
    with pytest.raises(lumsdk.OptionError, match="was read with another rig than the first one"):
        lumsdk.convert([frames[0], other], tmp_path / "a.npy")


def test_what_is_left_out_of_a_file_without_columns_is_named(frames, tmp_path):
    with pytest.warns(lumsdk.CaptureWarning, match="the frames have the column sensor, the place in the rig, which are left out: xyz has"):
        lumsdk.convert(frames[0], tmp_path / "a.xyz")


def test_a_joined_set_can_be_written(drive, rig, tmp_path):
    with lumsdk.open(drive, rig=rig, columns="all", frames=(2, 3)) as source:
        joined = [made.joined() for made in lumsdk.sync(source)]
    lumsdk.convert(joined, tmp_path / "a.npy")
    assert np.array_equal(np.load(tmp_path / "a.npy")["sensor"], np.concatenate([one["sensor"] for one in joined]))
