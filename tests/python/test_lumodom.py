"""lumodom: its command line, its files, how it ends; and drives from lumsim, of which the truth is known."""
import dataclasses
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import lumsdk
import numpy as np
import pytest
from conftest import PATIENCE_S, run
from lumsdk.odometry import _arguments, _cli, _drive, _estimate, _result

TOP = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("arguments, told", [
    ((), "one drive is needed, and none is named; files of one drive are named by a pattern in quotes, as 'drive-*.pcap'; see lumodom --help"),
    (("a.pcap", "b.pcap"), "one drive is needed, and 2 are named; files of one drive are named by a pattern in quotes, as 'drive-*.pcap'; see lumodom --help"),
    (("a.pcap", "--bad"), "unknown option --bad; see lumodom --help"),
    (("a.pcap", "--time", "gps"), "--time: gps: is utc or sensor"),
    (("a.pcap", "--time", "utc"), "--time: sets the seconds in the output, and there is none: name one by --output"),
    (("a.pcap", "-o", "a.csv"), "--output: a.csv: a name that ends in .txt or .tum is needed"),
    (("a.pcap", "--report", "a.pdf"), "--report: a.pdf: a name that ends in .png is needed"),
    (("a.pcap", "-o", "t.txt", "--truth", "./t.txt"), "t.txt: is read and cannot be written too: choose another name"),
    *((("a.pcap", "--voxel", value), f"--voxel: {value}: metres are needed, from 0.01 to 1000") for value in ("0", "-1", "nan", "1m", "2000")),
    (("a.pcap", "--voxel", "5", "--max-range", "10"), "--voxel: 5 m are too much for --max-range 10: at most a quarter of it"),
    (("a.pcap", "--set", "tof_lsb=13"), "set: unknown key 'tof_lsb'; did you mean 'tof_lsb_ps'?"),
    (("a.pcap", "--profile", "none.yaml"), "none.yaml: cannot be read: No such file or directory")])
def test_wrong_arguments_are_told_with_what_would_be_right(arguments, told, capsys):
    assert _cli.main(list(arguments)) == 2
    assert capsys.readouterr() == ("", f"lumodom: {told}\n")


def test_help_and_version(capsys):
    assert _cli.main(["--help"]) == 0
    assert capsys.readouterr() == (_arguments.HELP, "")
    assert max(map(len, _arguments.HELP.splitlines())) <= 80
    assert _cli.main(["--version"]) == 0
    assert re.fullmatch(r"lumodom \d+\.\d+\.\d+\n", capsys.readouterr().out)


def options_of(text):
    return set(re.findall(r"(?<![\w-])--[a-z]+(?:-[a-z]+)*", text))


def test_help_manual_parser_and_completion_have_the_same_options(completion):
    manual = (TOP / "docs/man/lumodom.1").read_text().replace("\\-", "-")
    listed = {f"-{name}" for name in re.findall(r"-[a-z]+(?:-[a-z]+)*", " ".join(re.findall(r"^\.It (Fl .*)$", manual, re.M)))}
    known = {name for action in _arguments._parser()._actions for name in action.option_strings if name.startswith("--")}
    assert options_of(_arguments.HELP.split("Exit status")[0]) == known
    assert listed == known
    complete = completion("lumodom", sys.executable, "-B", "-m", "lumsdk.odometry._cli")
    assert set(complete("--re")) == {"--report"}


def test_a_missing_package_is_named_with_the_command_that_brings_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "kiss_icp", None)
    assert _cli.main(["a.pcap", "-o", "a.txt"]) == 1
    assert re.fullmatch(r"lumodom: lumodom needs kiss-icp, which is not installed \(.*\): in a clone of lumsdk, pip install '\.\[odometry\]'\n", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


# --- With kiss-icp ---


@pytest.fixture
def kiss(tmp_path, monkeypatch):
    pytest.importorskip("kiss_icp")
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def drive(make_capture):
    return str(make_capture("-n", 4))


def read(name):
    return np.loadtxt(name)


def test_a_drive_becomes_poses_by_either_clock_and_a_report(kiss, drive, tmp_path, capsys):
    assert _cli.main([drive, "-o", "utc.txt", "--report", "a.png", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["frames"], told["poses"], told["errors"], told["deskew"]) == (4, 6, None, True)
    assert _cli.main([drive, "-o", "sensor.txt", "--time", "sensor", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    utc, sensor = read("utc.txt"), read("sensor.txt")
    assert utc.shape == (6, 8) and np.array_equal(utc[:, 1:], sensor[:, 1:])
    assert utc[0, 1:].tolist() == [0, 0, 0, 0, 0, 0, 1] and 1e9 < utc[0, 0] and sensor[0, 0] < 1e3
    assert np.diff(sensor[:, 0]) == pytest.approx([0.051, 0.1, 0.1, 0.1, 0.051], abs=5e-4)
    for name, words in ("utc.txt", "seconds since 1970 UTC"), ("sensor.txt", "seconds of the sensor's clock"):
        assert words in pathlib.Path(name).read_text().splitlines()[0]
    assert pathlib.Path("a.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "sensor.txt", "utc.txt"]


def test_poses_are_their_own_truth_and_others_are_told(kiss, drive, capsys):
    assert _cli.main([drive, "-o", "poses.txt", "-q"]) == 0
    lines = pathlib.Path("poses.txt").read_text().splitlines()
    pathlib.Path("part.txt").write_text("\n".join(lines[:-2]) + "\n")
    assert _cli.main([drive, "--truth", "part.txt", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["errors"]["poses"], told["errors"]["poses_without_truth"]) == (4, 2) and told["errors"]["absolute_rms_m"] < 1e-3
    assert told["notes"] == ["2 of 6 poses are outside the truth and not compared"]
    pathlib.Path("late.txt").write_text("5000 0 0 0 0 0 0 1\n5000.1 1 0 0 0 0 0 1\n")
    assert _cli.main([drive, "--truth", "late.txt", "-o", "none.txt"]) == 1
    assert re.fullmatch(r"lumodom: late\.txt: its poses are from 5000\.000 to 5000\.100 s, by seconds of the sensor's clock, and the drive is from .*: "
                        r"the truth of this drive is needed\n", capsys.readouterr().err)
    assert not pathlib.Path("none.txt").exists()


@pytest.mark.parametrize("clock", ["utc", "sensor"])
def test_every_point_of_the_drive_has_a_pose(kiss, drive, clock):
    assert _cli.main([drive, "-o", "poses.txt", "--time", clock, "-q"]) == 0
    poses = lumsdk.Poses("poses.txt")
    assert poses.clock == clock
    for frame in lumsdk.open(drive, columns=["x", "y", "z", "time"]):
        assert np.isfinite(frame.to_world(poses).xyz).all()


def test_with_a_rig_poses_are_the_vehicles(kiss, tmp_path, capsys):
    """A sensor to the left looks aside; the vehicle drives along x all the same."""
    pathlib.Path("rig.yaml").write_text("version: 1\nsensors:\n  - {name: front, address: 10.42.0.37, pose: {x_m: 1.2, z_m: 1.8}}\n"
                                        "  - {name: left, address: 10.42.0.38, pose: {x_m: 2, y_m: 0.9, z_m: 1.7, yaw_deg: 40}}\n")
    drive = lumsdk.simulate("drive.pcap", frames=8, rig="rig.yaml", motion="straight", velocity=8, poses="truth.txt", time="utc")
    assert _cli.main([drive, "--rig", "rig.yaml", "--sensor", "left", "-o", "poses.txt", "--truth", "truth.txt", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["errors"]["absolute_rms_m"] < 0.3
    went = read("poses.txt")[-1, 1:4]
    assert went[0] > 5 and abs(went[1]) < 0.5
    assert "where the vehicle was" in pathlib.Path("poses.txt").read_text()
    assert _cli.main([drive, "--rig", "rig.yaml"]) == 1
    assert "has frames of several sensors, front and left: a drive has one; name it with --sensor" in capsys.readouterr().err


def test_one_frame_is_no_drive(kiss, drive, tmp_path, capsys):
    assert _cli.main([drive, "--frames", "2:2", "-o", "a.txt", "-q"]) == 1
    assert capsys.readouterr().err == f"lumodom: {drive}: has one frame with points; a motion needs at least two\n"
    assert list(tmp_path.iterdir()) == []


def test_frames_of_which_nothing_is_left_are_refused(kiss, drive, tmp_path, capsys):
    assert _cli.main([drive, "--max-range", "1", "--voxel", "0.2", "-o", "a.txt", "-q"]) == 1
    assert re.fullmatch(r"lumodom: frame \d+: 0 of its points are left to align it by, and 20 are needed: .*\n", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


def test_frames_without_a_clock_are_refused(kiss, tmp_path, capsys):
    profile = tmp_path / "none.yaml"
    profile.write_text("version: 1\ngroup: {timestamp: none}\n")
    run("lumsim", "-q", "-o", tmp_path / "still.pcap", "--frames", 2, "--profile", profile)
    assert _cli.main(["still.pcap", "--profile", str(profile), "-q"]) == 1
    assert re.fullmatch(r"lumodom: still\.pcap: frame \d+ has no clock: .*; name a profile with one by --profile\n", capsys.readouterr().err)


def test_a_signal_leaves_nothing(kiss, drive, tmp_path):
    waits = f"""
import pathlib, signal, sys
import lumsdk.odometry._estimate as estimate
from lumsdk.odometry import _cli
def align(*_):
    pathlib.Path("begun").touch()
    signal.pause()
estimate.Estimate._align = align
sys.exit(_cli.main([{drive!r}, "-o", "a.txt"]))
"""
    process = subprocess.Popen([sys.executable, "-B", "-c", waits], cwd=tmp_path)
    begin = time.monotonic()
    while not (tmp_path / "begun").exists():
        assert process.poll() is None and time.monotonic() < begin + PATIENCE_S
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE_S) == -signal.SIGTERM
    assert os.listdir(tmp_path) == ["begun"]


# --- How exact it is ---


@pytest.mark.parametrize("options", [("--velocity", 20), ("--velocity", 2, "--rate", 0.5)])
def test_a_drive_that_is_under_way_when_it_begins_is_found(kiss, capsys, options):
    """From no motion, kiss-icp finds a hundredth of it: the lines on the road are alike in both frames."""
    run("lumsim", "-q", "-o", "fast.pcap", "--scene", "town", "--path", "circle", *options, "--frames", 3)
    assert _cli.main(["fast.pcap", "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["mean_m_s"] == pytest.approx(options[1], rel=0.02)


@pytest.mark.long
def test_a_jump_back_along_the_street_is_told(kiss, tmp_path):
    """Its motion is found as if it had gone on."""
    run("lumsim", "-q", "-o", "town.pcap", "--scene", "town", "--path", "circle", "--velocity", 10, "--frames", 13, cwd=tmp_path)
    with _drive.Drive("town.pcap", {}) as drive:
        scans = list(drive)
    begin, played = scans[0], [*scans[2:12], *scans[2:8]]
    looped = [dataclasses.replace(scan, number=100 + i, clock_ns=begin.clock_ns + 10**8 * i, utc_ns=begin.utc_ns + 10**8 * i)
              for i, scan in enumerate(played)]
    track = _estimate.Estimate(_estimate.Settings()).run(looped)
    assert _result.misfits(track, 1.0) == [110]


@pytest.mark.long
def test_a_drive_through_bends_is_found_and_points_have_to_be_moved(kiss, tmp_path, capsys):
    """Two right-angled bends at 10 m/s, of 8 m radius, which begin from one moment to the next."""
    run("lumsim", "-q", "-o", "town.pcap", "--scene", "town", "--path", "circle", "--velocity", 10, "--frames", 300, "--poses", "truth.txt", cwd=tmp_path)
    found = []
    for word in "--deskew", "--no-deskew":
        assert _cli.main(["town.pcap", "--frames", "150:300", "--truth", "truth.txt", "--json", "-q", word]) == 0
        found.append(json.loads(capsys.readouterr().out)["errors"]["segments"][0])
    (moved, still) = found
    assert moved["length_m"] == still["length_m"] == 100 and moved["count"] >= 4
    assert moved["translation_percent"] <= 0.5
    assert still["translation_percent"] >= 1.5 * moved["translation_percent"]
