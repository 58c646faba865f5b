"""A simulated drive, against its own truth: walls of a map are as thin as those that a standing sensor sees, and points lie on
what their labels name."""
import numpy as np
import pytest
from conftest import run

import lumsdk

NOISE_M = 0.02
TOWN = ("-q", "--scene", "town", "--seed", "3")
DRIVE = (*TOWN, "--path", "circle", "--velocity", "10", "--frames", "24")
STANDING = (*TOWN, "--pose", "12,0,1.8,0,0,0", "--frames", "12")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("drive")
    for name, scene in ("drive", DRIVE), ("standing", STANDING):
        run("lumsim", *scene, "-o", made / f"{name}.pcap", "--poses", made / f"{name}.txt", "--labels", made / f"{name}.npy")
        run("lumsim", *scene, "-o", made / f"{name}-exact.pcap", "--noise", "0")
    return made


def cells(world, size):
    """Root mean squares of the points of each cubic cell along their three axes, the smallest first, and their number."""
    keys = np.floor(world / size).astype("i8") @ np.array([1 << 40, 1 << 20, 1])
    order = np.argsort(keys, kind="stable")
    keys, world = keys[order], world[order] - world.mean(axis=0)
    starts = np.flatnonzero(np.r_[True, np.diff(keys) > 0])
    count = np.diff(np.r_[starts, len(keys)])
    middle = np.add.reduceat(world, starts) / count[:, None]
    square = np.add.reduceat(world[:, :, None] * world[:, None, :], starts) / count[:, None, None]
    values, axes = np.linalg.eigh(square - middle[:, :, None] * middle[:, None, :])
    return {key: (*np.sqrt(np.maximum(v, 0)), abs(a[2, 0]), n)
            for key, v, a, n in zip(keys[starts].tolist(), values, axes, count.tolist()) if n >= 30}


def world_of(capture, poses, is_moved=True):
    """Points up to 30 m away and above the road; if they are not moved, each frame by one pose."""
    made = []
    for frame in lumsdk.open(capture, columns="x,y,z,range,time"):
        near = (frame["range"] < 30) & (frame["range"] > 3)
        if is_moved:
            points = frame.to_world(poses).xyz.astype("f8")
        else:
            turn = poses.at(frame.info["begin_clock_us"] * 1e-6)
            points = frame.xyz.astype("f8") @ turn[:3, :3].T + turn[:3, 3]
        made.append(points[near & (points[:, 2] > 0.5)])
    return np.concatenate(made)


def thickness(folder, name, **how):
    """Root mean square of the walls of a map: of cells that are plane and upright without noise."""
    poses = lumsdk.Poses(folder / f"{name}.txt")
    exact = cells(world_of(folder / f"{name}-exact.pcap", poses), 0.5)
    walls = {key for key, (thin, wide, _, upright, _) in exact.items() if thin < 0.002 and wide > 0.08 and upright < 0.1}
    assert len(walls) > 50
    seen = cells(world_of(folder / f"{name}.pcap", poses, **how), 0.5)
    found = np.array([(seen[key][0], seen[key][-1]) for key in walls if key in seen])
    return np.sqrt(np.average(found[:, 0] ** 2, weights=found[:, 1]))


def test_walls_of_a_map_are_as_thin_as_a_standing_sensor_sees_them(folder):
    standing, moved = thickness(folder, "standing"), thickness(folder, "drive")
    assert moved < 1.3 * standing
    assert 0.3 * NOISE_M < standing < NOISE_M


def test_walls_are_thick_where_frames_are_not_moved(folder):
    assert thickness(folder, "drive", is_moved=False) > 1.3 * thickness(folder, "drive")


def key_of(rows):
    return ((rows["line"].astype("i8") * 1000 + rows["pixel"]) * 16 + rows["return_number"]) * 2 + rows["eye"]


def test_points_lie_within_four_deviations_of_what_their_labels_name(folder):
    labels = np.load(folder / "drive.npy")
    exact = {frame.number: frame for frame in lumsdk.open(folder / "drive-exact.pcap", columns="all")}
    compared = mixed = 0
    for frame in lumsdk.open(folder / "drive.pcap", columns="all"):
        named = labels[labels["frame"] == frame.number]
        true = exact[frame.number]
        keys, at, of = np.intersect1d(key_of(frame), key_of(named), return_indices=True)
        assert len(keys) == len(frame) == len(named)  # each point has its label
        is_mixed = np.empty(len(frame), bool)
        is_mixed[at] = named["mixed"][of] != 0
        _, at, of = np.intersect1d(key_of(frame), key_of(true), return_indices=True)
        # Noise may make two pulses of one: then the next has another number.
        alike = ~is_mixed[at] & (frame["number_of_returns"][at] == true["number_of_returns"][of])
        off = np.abs(frame["range"][at] - true["range"][of])[alike]
        assert off.max() < 4 * NOISE_M
        compared += len(off)
        mixed += int(is_mixed.sum())
    assert compared > 10 * mixed > 0
