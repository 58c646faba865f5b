"""Every capture of a folder gives what lumdump gives: its counts, and each column of each point."""
import json
import os
import pathlib
import subprocess
import warnings

import lumsdk
import numpy as np
import pytest
from conftest import BIN

VECTORS = pathlib.Path(os.environ.get("LUM_VECTORS", pathlib.Path(__file__).parents[3] / "shared/vectors"))
CASES = sorted(path for path in VECTORS.glob("*.json") if path.stem != "packets")

# Digits that lumdump writes: half a unit of the last one.
TOLERANCE = {"x": 6e-5, "y": 6e-5, "z": 6e-5, "range": 6e-5, "azimuth": 6e-6, "elevation": 6e-6, "pulse_width": 6e-4}
NAMES = {"edge": "edge", "return": "returns", "eye": "eye", "frames": "frames", "range": "range", "box": "box",
         "incomplete": "incomplete", "calibration": "calibration", "profile": "profile", "smooth": "smooth",
         "sensor": "sensor", "set": "set"}


def options_of(arguments):
    """Arguments of lumdump as options of open()."""
    options = {}
    words = iter(arguments)
    for word in words:
        name, _, value = word[2:].partition("=")
        value = value or str(next(words))
        if name == "set":
            options.setdefault("set", []).append(value)
        else:
            options[NAMES[name]] = value
    return options


def dump(capture, arguments):
    """lumdump's points by columns, its summary, its status, and what it said."""
    run = [str(BIN / "lumdump"), str(capture), *arguments]
    done = subprocess.run([*run, "-q", "-o", "-", "--format", "csv"], capture_output=True, text=True, check=False)
    summary = subprocess.run([*run, "--json", "-q"], capture_output=True, text=True, check=False)
    names, _, rows = done.stdout.partition("\n")
    numbers = np.fromstring(rows.replace("\n", ","), sep=",").reshape(-1, len(names.split(",")))
    columns = {name: numbers[:, i] for i, name in enumerate(names.split(","))}
    return columns, json.loads(summary.stdout) if summary.stdout else {}, done.returncode, done.stderr


def of_points(frames, values):
    """One array of what each frame gives, frame after frame by number."""
    return np.concatenate([values(frame) for frame in sorted(frames, key=lambda frame: frame.number)])


def compare(capture, arguments):
    want, summary, status, said = dump(capture, arguments)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            source = lumsdk.open(capture, columns="all", broken="warn", **options_of(arguments))
            frames = list(source)
    except lumsdk.Error as error:
        assert status != 0, f"lumdump reads it, but: {error}"
        return
    assert status == 0, said
    of_frames = ("lines_late", "points_late", "points_cut")  # lumdump has these by output
    counts = {name: count for name, count in source.counts.items() if name not in of_frames and summary[name] != count}
    assert not counts, {name: (count, summary[name]) for name, count in counts.items()}
    assert source.truncated == summary["truncated"]
    if frames:
        compare_points(want, frames)
        for place in {len(frames) // 2, len(frames) - 1}:
            with warnings.catch_warnings(), lumsdk.open(capture, columns="all", broken="warn", **options_of(arguments)) as again:
                warnings.simplefilter("ignore")
                assert again[place] == frames[place]
    else:
        assert not len(want.get("x", ()))


def compare_points(want, frames):
    """lumdump writes line by line as they are complete, so that frames overlap."""
    rows = np.argsort(want["frame"], kind="stable")
    got = {name: of_points(frames, lambda frame, name=name: frame[name]) for name in lumsdk.COLUMNS}
    got["frame"] = of_points(frames, lambda frame: np.full(len(frame), frame.number))
    got["timestamp"] = of_points(frames, lambda frame: np.repeat(frame.lines["clock_us"], frame.lines["point_count"]))
    for name in want:
        assert len(got[name]) == len(rows)
        assert np.abs(got[name] - want[name][rows]).max(initial=0) <= TOLERANCE.get(name, 0), name


@pytest.mark.skipif(not CASES, reason="the conformance captures are not beside this checkout")
@pytest.mark.parametrize("case", CASES, ids=[case.stem for case in CASES])
def test_gives_what_lumdump_gives(case):
    spec = json.loads(case.read_text())
    compare(VECTORS / spec["capture"], [str(VECTORS / word) if word.endswith(".yaml") else word
                                        for word in spec["arguments"]])


OWN = {"clean": ["-n", 2], "lossy": ["-n", 3, "--loss", 0.02, "--duplicate", 0.01, "--reorder", 0.05, "--seed", 7],
       "corrupt": ["-n", 2, "--corrupt", 0.02, "--seed", 8]}
CHOICES = [["--edge", "both"], ["--return", "last", "--eye", "green"], ["--return", "2", "--range", "5:60"],
           ["--frames", "2:3", "--incomplete", "drop"], ["--box", "0:50,-10:10,:4", "--smooth", "31:2"],
           ["--set", "eyes.blue.mount.x_m=1.5", "--set", "speed_of_light=299792458"]]


@pytest.mark.parametrize("name", OWN)
def test_gives_what_lumdump_gives_of_our_own(make_capture, name):
    compare(make_capture(*OWN[name]), [])


@pytest.mark.parametrize("arguments", CHOICES, ids=" ".join)
def test_gives_what_lumdump_gives_of_a_choice(make_capture, arguments):
    compare(make_capture(*OWN["lossy"]), arguments)
