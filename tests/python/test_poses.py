"""Poses, frames moved by them, and files of such frames."""
import math
import pickle

import lumsdk
import numpy as np
import pytest

TURN, RADIUS = 1.25, 8.0
TIMES_NS = 4_900_000_000 + 10_000_000 * np.arange(60)


def on_circle(time_ns):
    """The pose of a sensor that begins its circle at 5 s."""
    angle = TURN * (np.asarray(time_ns) * 1e-9 - 5.0)
    made = np.zeros((*angle.shape, 4, 4))
    made[..., 0, 0] = made[..., 1, 1] = np.cos(angle)
    made[..., 1, 0], made[..., 0, 1] = np.sin(angle), -np.sin(angle)
    made[..., 0, 3], made[..., 1, 3] = RADIUS * np.sin(angle), -RADIUS * np.cos(angle)
    made[..., 2, 2] = made[..., 3, 3] = 1.0
    return made


@pytest.fixture(scope="module")
def poses():
    return lumsdk.Poses(TIMES_NS, on_circle(TIMES_NS))


@pytest.fixture(scope="module")
def file(poses, tmp_path_factory):
    path = tmp_path_factory.mktemp("poses") / "poses.txt"
    poses.save(path)
    return path


@pytest.fixture(scope="module")
def path(make_capture):
    return make_capture("-n", 3)


@pytest.fixture(scope="module", params=["of the library", "pickled"])
def frame(request, path):
    made = list(lumsdk.open(path, columns="all"))[1]
    return made if request.param == "of the library" else pickle.loads(pickle.dumps(made))


def exact(frame, back=None):
    """Its points by their own times, in double."""
    times_ns = frame.info["begin_clock_us"] * 1000 + frame["time"].astype("f8") * 1e9
    matrices = on_circle(times_ns)
    if back is not None:
        matrices = back @ matrices
    return np.einsum("nij,nj->ni", matrices[:, :3, :3], frame.xyz.astype("f8")) + matrices[:, :3, 3]


def assert_near(got, expected, frame):
    """By the bound of lum/frame/move.h."""
    reach = np.maximum(np.linalg.norm(frame.xyz.astype("f8"), axis=1), 100.0)
    assert (np.linalg.norm(got.xyz - expected, axis=1) < 1.5e-6 * reach).all()


def test_a_file_and_arrays_are_the_same(poses, file):
    of_file = lumsdk.Poses(file)
    assert len(of_file) == len(poses) == 60 and of_file.span == poses.span == (TIMES_NS[0], TIMES_NS[-1])
    assert of_file.clock == "sensor" and lumsdk.Poses(TIMES_NS, poses.tum, clock="utc").clock == "utc"
    assert np.array_equal(of_file.times, TIMES_NS) and np.allclose(of_file.tum, poses.tum, atol=1e-15)
    assert np.allclose(lumsdk.Poses(TIMES_NS * 1e-9, on_circle(TIMES_NS)[:, :3]).tum, poses.tum, atol=1e-15)


def test_kitti_has_its_times_beside_it(poses, tmp_path):
    np.savetxt(tmp_path / "00.txt", on_circle(TIMES_NS)[:, :3].reshape(-1, 12))
    np.savetxt(tmp_path / "times.txt", TIMES_NS * 1e-9)
    read = lumsdk.Poses(tmp_path / "00.txt", times=tmp_path / "times.txt")
    assert np.allclose(np.abs((read.tum[:, 3:] * poses.tum[:, 3:]).sum(axis=1)), 1.0)
    assert np.allclose(read.tum[:, :3], poses.tum[:, :3])


def test_any_rotation_becomes_a_quaternion_and_back():
    random = np.random.default_rng(1)
    q = np.vstack([random.normal(size=(200, 4)), np.eye(4)])
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    first = lumsdk.Poses(np.arange(len(q)) * 1000, np.hstack([np.zeros((len(q), 3)), q]))
    again = lumsdk.Poses(first.times, np.array([first.at(int(time)) for time in first.times]))
    assert np.allclose(np.abs((again.tum[:, 3:] * q).sum(axis=1)), 1.0)


def test_at_is_on_the_circle_between_poses(poses):
    for time_ns in (TIMES_NS[0], 5_003_333_333, TIMES_NS[-1]):
        assert np.allclose(poses.at(time_ns), on_circle(time_ns), atol=1e-9)
    assert np.array_equal(poses.at(5.25), poses.at(5_250_000_000))
    with pytest.raises(lumsdk.OptionError, match=r"1\.000000 s is outside of them: they are from 4\.900000 to 5\.490000 s"):
        poses.at(1.0)
    assert np.allclose(poses.at(1.0, outside="nearest"), on_circle(TIMES_NS[0]))
    with pytest.raises(lumsdk.OptionError, match="an int of nanoseconds, .* or a float of seconds"):
        poses.at("5")


def test_to_world_is_each_point_by_its_own_time(frame, poses):
    moved = frame.to_world(poses)
    assert_near(moved, exact(frame), frame)
    assert moved.columns == frame.columns and np.array_equal(moved["range"], frame["range"])
    assert np.array_equal(moved.lines, frame.lines) and moved.number == frame.number
    assert np.array_equal(moved["x"], moved.xyz[:, 0]) and not np.array_equal(moved["x"], frame["x"])
    assert pickle.loads(pickle.dumps(moved)) == moved


def test_an_origin_is_subtracted(frame, poses):
    far = on_circle(TIMES_NS)
    far[:, :3, 3] += [500_000.0, 5_400_000.0, 0.0]
    moved = frame.to_world(lumsdk.Poses(TIMES_NS, far), origin=(500_000, 5_400_000, 0))
    assert_near(moved, exact(frame), frame)


def test_a_far_world_has_an_origin(path, frame, poses, tmp_path):
    """The same one in frames, in files of the package and in those of lumdump; half kilometres are rounded away from 0."""
    far = on_circle(TIMES_NS)
    far[:, :3, 3] += [6800.0 - far[0, 0, 3], -far[0, 1, 3], -6500.0]
    world = lumsdk.Poses(TIMES_NS, far)
    assert world.origin() == (7000, 0, -7000) and poses.origin() is None
    with pytest.warns(lumsdk.CaptureWarning, match=r"farther than 5 km from 0, .* give origin=\(7000\.0, 0\.0, -7000\.0\)"):
        near = frame.to_world(world).xyz + [-7000, 0, 7000]
    assert np.abs(near - frame.to_world(world, origin=world.origin()).xyz).max() < 1e-3
    for name, comments in ("far.csv", True), ("far.npz", None):
        with pytest.warns(lumsdk.CaptureWarning, match="7000"):
            lumsdk.convert(path, tmp_path / name, poses=world, columns="x,y,z", comments=comments)
    for name in "far.csv", "far.npy", "far.bin":
        with pytest.raises(lumsdk.OptionError, match="relative to the origin=7000,0,-7000, and nothing in a file of .* would say so"):
            lumsdk.convert([frame], tmp_path / name, poses=world)
    of_csv = np.genfromtxt(tmp_path / "far.csv", delimiter=",", comments="#")[1:]
    with np.load(tmp_path / "far.npz") as made:
        assert np.abs(of_csv - np.stack([made[name] for name in "xyz"], axis=1)).max() < 6e-5


def test_files_know_what_a_text_of_poses_does_not_say(path, poses, tmp_path):
    """A longer gap, and a clock that is not that of times of this size."""
    part = lumsdk.Poses(TIMES_NS[[0, 1, -1]], poses.tum[[0, 1, -1]], gap=0.5)
    of_utc = lumsdk.Poses(TIMES_NS, poses.tum, clock="utc")
    assert poses.is_plain and not part.is_plain and not of_utc.is_plain
    for name in "a.csv", "a.npz":
        for wrong, told in (part, "no point|points have no pose"), (of_utc, "another drive"):
            with pytest.raises(lumsdk.CaptureError, match=told):
                lumsdk.convert(path, tmp_path / name, poses=wrong)
    with pytest.raises(lumsdk.OptionError, match="voxel is done by lumdump: .* Poses with the usual gap and jump"):
        lumsdk.convert(path, tmp_path / "a.las", poses=part, voxel=0.5)


def test_deskew_is_as_if_the_sensor_had_stood_still(frame, poses):
    begin_ns = frame.info["begin_clock_us"] * 1000
    for to, then in (("start", begin_ns), ("middle", begin_ns + frame.duration / 2 * 1e9)):
        assert_near(frame.deskew(poses, to=to), exact(frame, np.linalg.inv(on_circle(then))), frame)
    with pytest.raises(ValueError, match='use "start" or "middle"'):
        frame.deskew(poses, to="world")


def test_points_without_a_pose_are_told(frame, poses):
    half = lumsdk.Poses(TIMES_NS[:25], poses.tum[:25])  # up to 5.14 s, and the frame begins at 5.1
    with pytest.warns(lumsdk.CaptureWarning, match=rf"of {len(frame)} points have no pose: \d+ after the last one; they are NaN"):
        moved = frame.to_world(half)
    late = frame["time"] > 0.040001  # a microsecond more
    assert np.array_equal(np.isnan(moved["x"]), late) and 0 < late.sum() < len(frame)
    with pytest.warns(lumsdk.CaptureWarning, match="the nearest pose moved them"):
        assert not np.isnan(frame.to_world(half, outside="nearest").xyz).any()
    with pytest.raises(lumsdk.CaptureError, match="have no pose"):
        frame.to_world(half, outside="raise")
    other = lumsdk.Poses(TIMES_NS + 10**12, poses.tum)
    with pytest.raises(lumsdk.CaptureError, match=r"from 1004\.900 to 1005\.490 s .*, the points from 5\.1.* another drive"):
        frame.to_world(other, outside="raise")


def test_what_is_wrong_is_refused(frame, path, poses, tmp_path):
    with pytest.raises(lumsdk.CaptureError, match="No such file"):
        lumsdk.Poses(tmp_path / "none.txt")
    with pytest.raises(lumsdk.OptionError, match=r"pose 1 has the time of pose 0"):
        lumsdk.Poses([5, 5], poses.tum[:2])
    with pytest.raises(lumsdk.OptionError, match=r"for 2 times use \(2, 4, 4\)"):
        lumsdk.Poses([5, 6], np.eye(4))
    with pytest.raises(lumsdk.OptionError, match="pose 1 has no rotation"):
        lumsdk.Poses([5, 6], np.stack([np.eye(4), np.diag([1.0, 1, -1, 1])]))
    with pytest.raises(lumsdk.OptionError, match="nanoseconds are given as ints"):
        lumsdk.Poses([5e9, 6e9], poses.tum[:2])
    for options in {"gap": -1}, {"gap": 0}, {"gap": math.nan}, {"jump": -1.0}, {"jump": 0}, {"jump": math.nan}, {"clock": "gps"}:
        (name,) = options
        with pytest.raises(lumsdk.OptionError, match=f"{name} is .*; use "):
            lumsdk.Poses(TIMES_NS, poses.tum, **options)
    with pytest.raises(TypeError, match="use lumsdk.Poses"):
        frame.to_world("poses.txt")
    (bare, *_) = lumsdk.open(path, columns="x,y,z")
    with pytest.raises(lumsdk.UnknownKeyError, match='no column time, .* open its source with columns="x,y,z,time", or "all"'):
        bare.to_world(poses)
    assert "time" in next(iter(lumsdk.open(path, columns="x,y,z,time")))


@pytest.mark.parametrize("origin", [(1, 2), (1, 2, 3, 4), 5, "abc", (math.nan, 0, 0), (0, math.inf, 0), [[1, 2, 3]]])
def test_an_origin_is_three_numbers(frame, poses, origin):
    with pytest.raises(lumsdk.OptionError, match="origin is .*; use x, y and z in metres"):
        frame.to_world(poses, origin=origin)


@pytest.mark.parametrize("make, told", [
    (lambda p: p.at(10**30), r"a time is 10+; use an int of nanoseconds, below 2\^63"),
    (lambda p: p.at(-2**63), "use an int of nanoseconds"), (lambda p: p.at(math.nan), "use an int of nanoseconds"),
    (lambda p: lumsdk.Poses("a\0b"), "without the character 0"), (lambda p: lumsdk.Poses("a", times="b\0"), "without the character 0"),
    (lambda p: lumsdk.Poses(p.times, p.tum, gap="1"), "gap is '1'; use seconds"),
    (lambda p: lumsdk.Poses(p.times, p.tum, gap=1e300), r"gap is 1e\+300; use seconds"),
    (lambda p: lumsdk.Poses(p.times, p.tum, jump="far"), "jump is 'far'; use metres"),
    (lambda p: lumsdk.Poses(p.times, p.tum, clock=[]), r"clock is \[\]; use"),
    (lambda p: lumsdk.Poses(p.times, "abc"), "times and poses are arrays of numbers"),
    (lambda p: lumsdk.Poses(np.array([2**63, 2**63 + 9], "u8"), p.tum[:2]), r"use times below 2\^63"),
])
def test_wrong_arguments_are_told_in_sentences(poses, make, told):
    with pytest.raises(lumsdk.OptionError, match=told):
        make(poses)


def test_a_frame_is_moved_once(frame, poses):
    """Also after it was pickled, and by convert()."""
    for moved, to in (frame.deskew(poses), "the start"), (frame.deskew(poses, "middle"), "the middle"), (frame.to_world(poses), "the world"):
        for given in moved, pickle.loads(pickle.dumps(moved)):
            for again in given.deskew, given.to_world:
                with pytest.raises(lumsdk.OptionError, match=f"points were moved already, to {to}.*: take the frame as it was read"):
                    again(poses)


def test_moved_frames_are_not_moved_into_a_file(frame, poses, tmp_path):
    moved = frame.deskew(poses)
    with pytest.raises(lumsdk.OptionError, match="moved already"):
        lumsdk.convert([moved], tmp_path / "a.npz", poses=poses)
    assert lumsdk.convert([moved], tmp_path / "a.npz")["points"] == len(frame)


def test_poses_are_values_and_can_be_pickled(poses, file):
    of_file = lumsdk.Poses(file)
    for made in poses, of_file, lumsdk.Poses(TIMES_NS, poses.tum, clock="utc", gap=0.5, jump=math.inf):
        back = pickle.loads(pickle.dumps(made))
        assert back == made and hash(back) == hash(made) and repr(back) == repr(made)
        assert back.is_plain == made.is_plain and np.allclose(back.at(5.003), made.at(5.003), atol=1e-14)
    assert of_file == lumsdk.Poses(file) and poses != "poses"
    shifted = poses.tum
    shifted[30, 0] += 1e-12
    turned = poses.tum
    turned[30, 3:] = turned[31, 3:]
    for other in (lumsdk.Poses(TIMES_NS, shifted), lumsdk.Poses(TIMES_NS, turned), lumsdk.Poses(TIMES_NS, poses.tum, gap=0.5),
                  lumsdk.Poses(TIMES_NS + (TIMES_NS == TIMES_NS[9]), poses.tum), lumsdk.Poses(TIMES_NS, poses.tum, clock="utc"),
                  lumsdk.Poses(TIMES_NS[1:], poses.tum[1:])):
        assert other != poses


@pytest.mark.parametrize("name", ["p.csv", "p.npz", "p.xyz"])
def test_files_of_poses_are_not_overwritten(path, file, poses, tmp_path, name):
    """Neither by lumdump nor by the package, from a capture and from frames."""
    own, times = tmp_path / name, tmp_path / f"t-{name}"
    own.write_bytes(file.read_bytes())
    np.savetxt(tmp_path / "00.txt", on_circle(TIMES_NS)[:, :3].reshape(-1, 12))
    np.savetxt(times, TIMES_NS * 1e-9)
    kept = own.read_bytes(), times.read_bytes()
    for source in path, list(lumsdk.open(path)):
        for given in own, lumsdk.Poses(own):
            with pytest.raises(lumsdk.OptionError, match="is a file of the poses, which this run reads: name another output"):
                lumsdk.convert(source, own, poses=given)
        with pytest.raises(lumsdk.OptionError, match="is a file of the poses"):
            lumsdk.convert(source, times, poses=tmp_path / "00.txt", pose_times=times)
    assert kept == (own.read_bytes(), times.read_bytes())


def points_of(path):
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=(0, 1, 2))


@pytest.mark.parametrize("to", ["start", "middle", "world"])
def test_lumdump_moves_as_frames_do(path, file, poses, tmp_path, to):
    """The functions on frames, and those on arrays."""
    lumsdk.convert(path, tmp_path / "moved.csv", poses=poses, to=to)
    lumsdk.convert(path, tmp_path / "moved.npz", poses=file, to=to, columns="x,y,z")
    frames = [frame.to_world(poses) if to == "world" else frame.deskew(poses, to=to)
              for frame in lumsdk.open(path, columns="x,y,z,time")]
    expected = np.vstack([frame.xyz for frame in frames])
    assert np.abs(points_of(tmp_path / "moved.csv") - expected).max() < 6e-5
    with np.load(tmp_path / "moved.npz") as made:
        assert np.array_equal(np.stack([made[name] for name in "xyz"], axis=1), expected)


@pytest.mark.parametrize("name", ["half.csv", "half.npz"])
def test_files_lack_what_has_no_pose(path, poses, tmp_path, name):
    half = lumsdk.Poses(TIMES_NS[:25], poses.tum[:25])
    with pytest.warns(lumsdk.CaptureWarning, match="have no pose and are left out"):
        done = lumsdk.convert(path, tmp_path / name, poses=half)
    frames = list(lumsdk.open(path, columns="time"))
    late = [(frame["time"] + (frame.info["begin_clock_us"] - 5_140_000) * 1e-6 > 1e-6).sum() for frame in frames]
    assert done["left_out"] == sum(late) > 0 and done["points"] == sum(map(len, frames)) - sum(late)
    other = lumsdk.Poses(TIMES_NS + 10**12, poses.tum)
    with pytest.raises(lumsdk.Error, match="another drive"):
        lumsdk.convert(path, tmp_path / f"none-{name}", poses=other)
    assert not (tmp_path / f"none-{name}").exists()


def test_options_of_motion_go_together(path, poses, tmp_path):
    with pytest.raises(lumsdk.OptionError, match="give poses= too"):
        lumsdk.convert(path, tmp_path / "a.npz", to="world")
    with pytest.raises(lumsdk.OptionError, match="to is 'end'"):
        lumsdk.convert(path, tmp_path / "a.npz", poses=poses, to="end")
    with pytest.raises(lumsdk.OptionError, match="--poses does not go with png"):
        lumsdk.convert(path, tmp_path / "a.png", poses=poses)


def test_time_steps_are_not_too_coarse():
    with pytest.raises(lumsdk.OptionError, match="all poses are 2 s apart"):
        lumsdk.Poses([0.0, 2.0, 4.0], np.stack([np.eye(4)] * 3))
    assert math.isclose(lumsdk.Poses([0.0, 2.0], np.stack([np.eye(4)] * 2), gap=3.0).at(1.0)[0, 0], 1.0)
