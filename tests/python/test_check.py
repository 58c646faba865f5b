"""lumcal check: what it measures in rooms that are known, and how it tells it."""
import dataclasses
import json

import numpy as np
import pytest

pytest.importorskip("scipy")

import rooms  # noqa: E402, needs SciPy
from lumsdk import Calibration  # noqa: E402
from lumsdk.calibrate import _check, _cli, _tell  # noqa: E402

pytestmark = pytest.mark.usefixtures("own_signals")

MILD = {"rms": 0.0014, "bias": 0.002, "sine": 0.003}


def calibration(true, **changes):
    """The calibration of a sensor, with these changes added to the green eye's mount, and to its offset in metres."""
    eyes = {eye: {"tof_offset_ps": (c["offset_m"] + (changes.get("offset_m", 0) if eye == "green" else 0)) * rooms.PICOSECONDS_A_METRE,
                  "azimuth": {"width_deg": c["width"]}, "elevation": {"min_deg": c["low"], "max_deg": c["high"]},
                  "mount": {key: value + (changes.get(key, 0) if eye == "green" else 0) for key, value in
                            zip(("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg"), c["mount"])}} for eye, c in true.items()}
    return Calibration({"eyes": eyes})


@pytest.fixture(scope="module")
def yard():
    """A yard: a wall straight ahead and a floor."""
    true = rooms.true_calibration(np.random.default_rng(1))
    return true, rooms.captures(1, true, poses=rooms.FIVE[:1], kind="yard")[0]


def seams(seen, made):
    return {seam.kind: seam for seam in _check.check_grid(seen, made, "mine").seams}


def test_the_true_calibration_meets(yard):
    true, seen = yard
    found = _check.check_grid(seen, calibration(true), "mine")
    assert found.verdict == "meet"
    assert {seam.kind for seam in found.seams} == {"wall", "floor"}
    assert max(found.flat_m) < 0.0005
    for seam in found.seams:
        assert abs(seam.step_m) < 0.001 and abs(seam.tilt_deg) < 0.01 and abs(seam.twist_deg) < 0.02


def test_typical_values_do_not(yard):
    assert _check.check_grid(yard[1], Calibration(), "typical").verdict == "apart"


@pytest.mark.parametrize("change, kind, name, wanted, within", [
    ({"z_m": 0.03}, "floor", "step_m", 0.03, 0.002), ({"z_m": -0.01}, "floor", "step_m", -0.01, 0.001),
    ({"x_m": -0.03}, "wall", "step_m", 0.03, 0.003), ({"offset_m": 0.02}, "wall", "step_m", -0.02, 0.003),
    ({"yaw_deg": 0.5}, "wall", "tilt_deg", 0.5, 0.02), ({"yaw_deg": -0.2}, "wall", "tilt_deg", -0.2, 0.02),
    ({"pitch_deg": 0.3}, "floor", "step_m", None, 0.0),
])
def test_an_error_shows_as_what_it_is(yard, change, kind, name, wanted, within):
    true, seen = yard
    seam = seams(seen, calibration(true, **change))[kind]
    assert seam.verdict == "apart"
    if wanted is not None:
        assert getattr(seam, name) == pytest.approx(wanted, abs=within)


@pytest.fixture(scope="module")
def wavy():
    """Rooms and yards with wavy walls, as their true calibrations show them."""
    made = []
    for seed in range(4):
        true = rooms.true_calibration(np.random.default_rng(seed))
        seen, = rooms.captures(seed, true, poses=rooms.FIVE[:1], kind=("room", "yard")[seed % 2], **MILD)
        made.append(_check.check_grid(seen, calibration(true), "mine"))
    return made


def test_wavy_walls_are_no_error(wavy):
    for found in wavy:
        assert found.verdict == "meet"
        assert max(found.flat_m) < 0.004


def test_standard_deviations_hold_what_waves_do(wavy):
    off = np.abs([part for found in wavy for s in found.seams for part in (
        s.step_m / s.step_sigma_m, s.tilt_deg / s.tilt_sigma_deg, s.twist_deg / s.twist_sigma_deg)])
    assert len(off) > 15
    assert np.mean(off < 2) > 0.8 and np.mean(off < 3) > 0.9
    assert np.sqrt(np.mean(np.square(off))) > 0.5  # and they are not so large that they say nothing


def few(seen, rng):
    """A grid of a few noisy cells: 9 lines of the floor, 6 degrees wide, not far from the other eye's."""
    made = type(seen)(**{**seen.__dict__, "range_m": seen.range_m + rng.normal(scale=0.03, size=seen.range_m.shape)})
    kept = np.zeros(seen.range_m.shape, bool)
    kept[0, -9:, -175:-75] = kept[1, -9:, 75:175] = True
    made.range_m[~kept] = np.nan
    return made


def test_what_is_known_too_little_of_does_not_meet(yard):
    """A floor of a few noisy cells: 3 cm are no more than chance makes of it, and nobody may say that the eyes meet."""
    true, seen = yard
    rng = np.random.default_rng(1)
    found = _check.check_grid(few(seen, rng), calibration(true, z_m=0.03), "mine")
    seam, = found.seams
    assert abs(seam.step_m) > 0.015
    assert found.verdict == "unknown"
    text = _tell.check_text(found)
    assert next(line for line in text.splitlines() if line.startswith("floor")).endswith("cannot tell")
    assert "unknown: what both eyes see here is too small or too uneven" in text
    told = json.loads(_tell.check_json(found))
    assert told["verdict"] == told["seams"][0]["verdict"] == "unknown" and told["advice"].startswith("unknown: ")


@pytest.mark.parametrize("numbers, wanted", [
    ((0.0, 0.001, 0.0, 0.01, 0.0, 0.01), "meet"), ((0.019, 0.005, 0.0, 0.01, 0.0, 0.01), "meet"),
    ((0.0, 0.0051, 0.0, 0.01, 0.0, 0.01), "unknown"), ((0.19, 0.049, 0.0, 0.01, 0.0, 0.01), "unknown"),
    ((0.0, 0.001, 0.0, 0.16, 0.0, 0.01), "unknown"), ((0.0, 0.001, 0.0, 0.01, 0.0, 0.16), "unknown"),
    ((0.0051, 0.001, 0.0, 0.01, 0.0, 0.01), "apart"), ((0.0, 0.001, 2.0, 0.3, 0.0, 0.3), "apart"),
    ((0.21, 0.049, 0.0, 0.3, 0.0, 0.3), "apart")])
def test_a_face_tells_only_what_it_knows(numbers, wanted):
    half = _check.Face(0, np.zeros(9, int), np.zeros((9, 3)), np.array((0, 0, 1.0)), -1.0, 0.0)
    made = _check.Seam(half, half, np.zeros(3), half.normal, half.normal, "floor", *numbers)
    assert made.verdict == wanted
    found = _check.Check("a.pcap", "mine", 20, [half], [made])
    assert found.verdict == wanted
    assert found.step_m == abs(numbers[0])


def test_one_face_that_tells_is_enough_and_one_apart_too():
    half = _check.Face(0, np.zeros(9, int), np.zeros((9, 3)), np.array((0, 0, 1.0)), -1.0, 0.0)
    meet, apart, unknown = (_check.Seam(half, half, np.zeros(3), half.normal, half.normal, "floor", step, sigma, 0.0, 0.02, 0.0, 0.03)
                            for step, sigma in ((0.001, 0.002), (0.02, 0.001), (0.0, 0.02)))
    for seams, wanted in ([unknown, meet], "meet"), ([unknown, unknown], "unknown"), ([meet, apart, unknown], "apart"):
        found = _check.Check("a.pcap", "mine", 20, [half], seams)
        assert found.verdict == wanted
        if wanted == "meet":  # and it says within what
            assert found.bounds == (0.008, 0.12) and "within 8 mm and 0.12 degrees" in _tell.advice(found)


def wall(eye, x, left, up):
    """A part of a wall across the view, at so many metres ahead, from and to so many metres to the left and up."""
    y, z = (part.ravel() for part in np.meshgrid(np.linspace(*left, 80), np.linspace(*up, 40)))
    cells = np.stack((np.full_like(y, x), y, z), 1)
    return _check.Face(eye, np.arange(len(cells)), cells, np.array((-1.0, 0.0, 0.0)), -x, 0.0)


def test_the_smallest_step_does_not_choose():
    """A board in front of the wall lies where a wrong calibration has the wall of the other eye."""
    blue, green, board = wall(0, 4.0, (-2, -0.1), (-1, 1)), wall(1, 4.06, (0.1, 2), (-1, 1)), wall(1, 4.0, (0.1, 0.9), (-1.2, -0.5))
    seams, strange = _check.find_seams([blue, green, board])
    assert [(seam.blue, seam.green) for seam in seams] == [(blue, green)] and not strange
    assert seams[0].step_m == pytest.approx(-0.06, abs=0.001) and seams[0].verdict == "apart"


@pytest.mark.parametrize("change, angle, away", [({"roll_deg": 9}, 9, None), ({"z_m": 0.4}, 0, 0.4)])
def test_what_is_torn_far_apart_is_no_wall_that_is_missing(yard, change, angle, away):
    """The advice is not to look for a wall."""
    true, seen = yard
    made = type(seen)(**{**seen.__dict__, "range_m": seen.range_m.copy()})
    made.range_m[:, :30] = np.nan  # what is left is the floor
    found = _check.check_grid(made, calibration(true, **change), "mine")
    assert found.verdict == "unknown" and not found.seams
    assert found.strange[0].apart_deg == pytest.approx(angle, abs=0.5)
    assert away is None or found.strange[0].step_m == pytest.approx(away, abs=0.02)
    assert "or the calibration is wrong by as much" in _tell.advice(found)


def test_where_one_eye_sees_nothing_it_is_unknown(yard):
    true, seen = yard
    blind = type(seen)(**{**seen.__dict__, "range_m": seen.range_m.copy()})
    blind.range_m[1] = np.nan
    found = _check.check_grid(blind, calibration(true), "mine")
    assert found.verdict == "unknown" and found.seams == [] and found.flat_m[1] is None and found.step_m is None
    told = json.loads(_tell.check_json(found))
    assert told["verdict"] == "unknown" and told["flat_mm"]["green"] is None and told["step_mm"] is None
    assert "no flat faces" in _tell.check_text(found)


def exchanged(seen):
    """What a profile with eye_values the wrong way round makes of a grid."""
    return dataclasses.replace(seen, **{name: getattr(seen, name)[::-1].copy() for name in ("azimuth", "elevation", "range_m", "sigma_m", "count")})


def test_exchanged_eyes_do_not_meet_by_the_floor_alone(yard):
    """Of a level sensor the floor goes on whichever eye is which; the wall straight ahead tells."""
    true, seen = yard
    for made in calibration(true), Calibration():
        assert not _check.check_grid(seen, made, "mine").is_exchanged
        found = _check.check_grid(exchanged(seen), made, "mine")
        assert found.is_exchanged and found.verdict == "unknown"
        assert "eye_values" in _tell.advice(found) and json.loads(_tell.check_json(found))["eyes_exchanged"] is True


def test_a_floor_does_not_tell_which_eye_is_which(yard):
    true, seen = yard
    floor = dataclasses.replace(seen, range_m=seen.range_m.copy())
    floor.range_m[:, :30] = np.nan
    for made in floor, exchanged(floor):
        assert not _check.check_grid(made, calibration(true), "mine").is_exchanged


def test_text_and_json_tell_the_same(yard):
    true, seen = yard
    found = _check.check_grid(seen, calibration(true, z_m=0.03), "mine.yaml")
    told = json.loads(_tell.check_json(found))
    assert told["verdict"] == "apart" and told["calibration"] == "mine.yaml" and told["frames"] == 20
    floor, = (seam for seam in told["seams"] if seam["kind"] == "floor")
    assert floor["step_mm"] == pytest.approx(30, abs=2) and floor["verdict"] == "apart"
    text = _tell.check_text(found)
    line, = (line for line in text.splitlines() if line.startswith("floor"))
    assert f"{floor['step_mm']:.1f} +-" in line and "green higher" in line and line.endswith("APART")
    assert "the eyes are apart" in text


def test_the_picture_is_a_png_and_the_same_each_time(yard):
    pytest.importorskip("matplotlib")
    from lumsdk.calibrate import _check_picture

    true, seen = yard
    found = _check.check_grid(seen, calibration(true, z_m=0.03), "mine")
    made = _check_picture.check_png(found)
    assert made.startswith(b"\x89PNG") and made == _check_picture.check_png(found)
    assert int.from_bytes(made[16:20], "big") >= 1000
    found.seams = []
    assert _check_picture.check_png(found).startswith(b"\x89PNG")


def test_the_picture_shows_the_step(yard):
    pytest.importorskip("matplotlib")
    from lumsdk.calibrate import _check_picture

    true, seen = yard
    seam = seams(seen, calibration(true, z_m=0.03))["floor"]
    across, height = _check_picture.profile(seam, seam.green)
    other, other_height = _check_picture.profile(seam, seam.blue)
    assert np.median(across) > 0.2 and np.median(other) < -0.2
    assert height.mean() - other_height.mean() == pytest.approx(0.03, abs=0.003)


def test_a_capture_is_checked_from_the_command_line(make_capture, tmp_path, monkeypatch, capsys):
    """The way from a file and the options to numbers."""
    pytest.importorskip("matplotlib")
    yard = make_capture("--scene", "yard", "--pose", "0,0,1.2,0,0,0", "--frames", 8, "--lines", 64, name="yard.pcap")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("version: 1\neyes: {green: {mount: {z_m: 0.1}}}\n")
    status = _cli.main(["check", str(yard), "--calibration", "mine.yaml", "-o", "yard.png", "--json"])
    told = capsys.readouterr()
    assert status == 1 and told.err == ""
    found = json.loads(told.out)
    assert found["calibration"] == "mine.yaml" and found["frames"] >= 6 and found["verdict"] == "apart"
    assert found["faces"]["blue"] and found["faces"]["green"]
    assert (tmp_path / "yard.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "twice.yaml").write_text("version: 1\nspeed_of_light: 2.9e8\neyes: {green: {mount: {z_m: 0.1}}}\n")
    for arguments in ["--calibration", "twice.yaml"], ["--set", "speed_of_light=2.9e8", "--set", "eyes.green.mount.z_m=0.1"]:
        _cli.main(["check", str(yard), "--json", *arguments])
        scaled = json.loads(capsys.readouterr().out)
        assert scaled["seams"][0]["distance_m"] == pytest.approx(found["seams"][0]["distance_m"] * 29 / 30, rel=0.02)


def test_a_yard_is_checked_from_its_packets(make_capture, tmp_path, capsys):
    """The calibration that a sensor has meets; a wrong one shows as the step and the tilt that it is."""
    true = tmp_path / "true.yaml"
    true.write_text("version: 1\neyes: {green: {tof_offset_ps: -150, mount: {x_m: 0.02, z_m: 0.03, pitch_deg: 0.6, yaw_deg: 31.2}}}\n")
    yard = make_capture("--scene", "yard", "--pose", "0,0,1.2,0,0,0", "--frames", 8, "--lines", 64, "--calibration", true, name="yard.pcap")

    def check(*settings):
        status = _cli.main(["check", str(yard), "--json", "--calibration", str(true), *(word for text in settings for word in ("--set", text))])
        found = json.loads(capsys.readouterr().out)
        assert (status, found["verdict"]) in ((0, "meet"), (1, "apart"))
        return found["verdict"], {seam["kind"]: seam for seam in found["seams"]}

    verdict, found = check()
    assert verdict == "meet" and set(found) == {"wall", "floor"}
    assert max(abs(seam["step_mm"]) for seam in found.values()) < 3
    verdict, found = check("eyes.green.mount.z_m=0")
    assert verdict == "apart" and found["floor"]["step_mm"] == pytest.approx(-30, abs=2)
    verdict, found = check("eyes.green.mount.yaw_deg=30")
    assert verdict == "apart" and found["wall"]["tilt_deg"] == pytest.approx(-1.2, abs=0.05)
