"""lumcal from the packets of a room to a calibration, through main(): reading, solving, files, JSON, and what is refused."""
import contextlib
import io
import json
import math
import re

import lumsdk
import pytest
from conftest import run

pytest.importorskip("scipy")
pytest.importorskip("matplotlib")

from lumsdk.calibrate import _cli, _eyes, _faces, _solution  # noqa: E402, needs SciPy

pytestmark = pytest.mark.usefixtures("own_signals")

TRUE = """\
version: 1
eyes:
  blue: {tof_offset_ps: 90, azimuth: {width_deg: 60.4}, elevation: {min_deg: -17.05, max_deg: 3.05}}
  green:
    {tof_offset_ps: -70, azimuth: {width_deg: 59.7}, elevation: {min_deg: -16.95, max_deg: 2.95},
     mount: {x_m: 0.02, y_m: -0.015, z_m: 0.03, roll_deg: 0.8, pitch_deg: -0.6, yaw_deg: 31.1}}
"""

PROFILE = """\
version: 1
group: {line: {at: 20, bytes: 4, order: big, bits: [0, 11]}, eye: {at: 18, bits: [7, 7]}, num_samples: 16, timestamp: none,
        first_sample_index: 24, samples: 32}
sample_order: big
"""

POSES = ("0.1,-0.1,1.2,0,0,0", "-0.1,0.1,1.25,12,0,27", "0,0.2,1.15,-12,0,-27")

BARS = {"ps": 60.0, "m": 0.004, "deg": 0.06}
"""How far off values may be, of a few frames and coarse squares."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, make_capture):
    """Three captures of a room with packets of another layout, the true calibration, the profile, and a capture of a yard."""
    made = tmp_path_factory.mktemp("room")
    (made / "true.yaml").write_text(TRUE)
    (made / "profile.yaml").write_text(PROFILE)
    (made / "begin.yaml").write_text("version: 1\neyes: {blue: {azimuth: {width_deg: 60.2}, mount: {x_m: 0.1}}, green: {mount: {x_m: 0.1}}}\n")
    usual = "--frames", 8, "--lines", 64, "--calibration", made / "true.yaml", "--profile", made / "profile.yaml"
    for name, pose in zip("abc", POSES):
        make_capture("--scene", "room", "--pose", pose, *usual).rename(made / f"{name}.pcap")
    make_capture("--scene", "yard", "--pose", POSES[2], *usual).rename(made / "elsewhere.pcap")
    return made


def lumcal(folder, *words):
    """Its exit status, run in the folder, with squares that are coarser than usual: it takes less time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(_faces, "TILES_MAX", 600)
        patch.setitem(_solution.WISHES, "x_m", 1e-5)
        return _cli.main([*words, "--profile", "profile.yaml", "--sensor", "10.42.0.37"])


@pytest.fixture(scope="module")
def found(folder):
    """A run of eyes from a begin that the options name: its exit status, what it printed, and the folder of its files."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        status = lumcal(folder, "eyes", "a.pcap", "b.pcap", "c.pcap", "-o", "found.yaml", "--report", "found.html", "--json", "-q",
                        "--calibration", "begin.yaml", "--set", "eyes.green.mount.yaw_deg=30.4")
    return status, json.loads(out.getvalue()), folder


def test_the_calibration_of_a_room_is_found_and_loads(found):
    status, _, folder = found
    assert status == 0
    true, made = (lumsdk.Calibration(folder / name) for name in ("true.yaml", "found.yaml"))
    for key in true:
        unit = key.rsplit("_", 1)[-1]
        moved = 0.1 if key.endswith("mount.x_m") else 0.0  # both eyes stand where the begin has the blue one
        if key.startswith("eyes."):
            assert made[key] == pytest.approx(true[key] + moved, abs=BARS[unit]), key


def test_json_tells_the_file_and_where_it_began(found):
    _, told, folder = found
    made = lumsdk.Calibration(folder / "found.yaml")
    values = {p["key"]: p for p in told["parameters"]}
    assert len(values) == 16 and told["is_better"] is True and told["not_written"] is None and len(told["planes"]) >= 5
    assert told["captures"] == ["a.pcap", "b.pcap", "c.pcap"]
    for key, p in values.items():
        assert made[key] == pytest.approx(p["value"], abs=6e-3 if key.endswith("ps") else 6e-6), key
        assert (p["sigma"] is None) == bool(p["held"]), key
        wish = 1e-5 if key.endswith("green.mount.x_m") else _solution.WISHES.get(key.rsplit(".")[-1])
        assert p["wish"] == wish and p["more_captures"] == (0 if wish is None else max(0, math.ceil(3 * ((p["sigma"] / wish) ** 2 - 1)))), key
    assert [values[f"eyes.{key}"]["before"] for key in ("blue.azimuth.width_deg", "green.mount.x_m", "green.mount.yaw_deg")] == [60.2, 0.1, 30.4]
    assert sum(p["held"] is None for p in values.values()) == 14


def test_exchanged_eyes_make_no_file(folder, capsys):
    before = sorted(folder.iterdir())
    exchange = "--set", "eye_values.blue=1", "--set", "eye_values.green=0"
    assert lumcal(folder, "eyes", "a.pcap", "b.pcap", "c.pcap", "-o", "none.yaml", "--json", *exchange) == 1
    out, err = capsys.readouterr()
    assert "none.yaml is not written: a wall continues from eye to eye only with the eyes exchanged" in err
    assert "--set eye_values.blue=0 --set eye_values.green=1" in err and json.loads(out)["not_written"] in err
    assert sorted(folder.iterdir()) == before


def test_the_file_says_where_from_and_how_sure(found):
    text = (found[2] / "found.yaml").read_text()
    assert all(f"#     {name}.pcap\n" in text for name in "abc")
    assert text.count("# +- ") == 14 and text.count("# held: ") == 2


def test_the_report_is_made_of_the_run(found):
    page = (found[2] / "found.html").read_text()
    assert page.count("data:image/png;base64,") == 3 and "green.mount.yaw_deg" in page and "c.pcap" in page


def test_no_other_file_is_left(found):
    assert sorted(path.name for path in found[2].iterdir()) == ["a.pcap", "b.pcap", "begin.yaml", "c.pcap", "elsewhere.pcap", "found.html",
                                                               "found.yaml", "profile.yaml", "true.yaml"]


def test_the_eyes_meet_with_it_and_not_without(found, capsys):
    folder = found[2]
    assert lumcal(folder, "check", "a.pcap", "--calibration", "found.yaml", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["verdict"] == "meet" and told["calibration"] == "found.yaml" and abs(told["step_mm"]) < 3
    assert lumcal(folder, "check", "a.pcap", "--json") == 1
    assert json.loads(capsys.readouterr().out)["verdict"] == "apart"


@pytest.fixture
def begins(monkeypatch):
    """The calibrations that runs of eyes begin with, which end there."""
    made = []

    def end(grids, calibration):
        made.append(calibration)
        raise lumsdk.CaptureError("enough")

    monkeypatch.setattr(_eyes, "solve_grids", end)
    return made


@pytest.fixture(scope="module")
def of_its_own(folder):
    """Recordings that bring a calibration with them: two of one, one of another."""
    for name, settings in ("own-a", "true.yaml"), ("own-b", "true.yaml"), ("other", "begin.yaml"):
        run("lumdump", folder / f"{name.replace('other', 'c')[-1]}.pcap", "-o", folder / f"{name}.pcapng", "--calibration", folder / settings,
            "--profile", folder / "profile.yaml")
    yield folder
    for path in folder.glob("*.pcapng"):
        path.unlink()


@pytest.mark.parametrize("words, yaw, x", [
    (("own-a.pcapng", "own-b.pcapng"), 31.1, 0.02), (("c.pcap", "own-b.pcapng"), 31.1, 0.02), (("a.pcap", "b.pcap"), 30.0, 0.0),
    (("own-a.pcapng", "own-b.pcapng", "--set", "eyes.green.mount.yaw_deg=29"), 29.0, 0.02),
    (("own-a.pcapng", "other.pcapng", "--calibration", "begin.yaml"), 30.0, 0.1)])
def test_the_search_begins_at_the_captures_own_calibration(of_its_own, begins, words, yaw, x, capsys):
    """As check does; and what is named, or set, comes first."""
    assert lumcal(of_its_own, "eyes", "-q", *words) == 1
    assert capsys.readouterr().err == "lumcal: enough\n"
    assert [(made["eyes.green.mount.yaw_deg"], made["eyes.green.mount.x_m"]) for made in begins] == [(yaw, x)]


def test_two_calibrations_of_captures_are_no_begin(of_its_own, begins, capsys):
    assert lumcal(of_its_own, "eyes", "-q", "own-a.pcapng", "other.pcapng") == 2
    assert capsys.readouterr().err == ("lumcal: other.pcapng: its calibration is not that of own-a.pcapng: name the one "
                                      "to start from by --calibration\n")
    assert not begins


def test_a_check_takes_the_captures_own_without_a_word(of_its_own, monkeypatch, capsys):
    monkeypatch.chdir(of_its_own)
    assert _cli.main(["check", "own-a.pcapng", "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["calibration"] == "the capture's own" and err == ""


@pytest.mark.parametrize("words, told", [
    (("elsewhere.pcap", "--profile", "profile.yaml"), r"lumcal: elsewhere\.pcap: shows no faces that another capture shows too\. .*\n"),
    (("c.pcap",), r"(lumcal: warning: .*; if the layout may be another one, .*\n)*lumcal: a\.pcap: .*\n"),
    (("c.pcap", "--profile", "profile.yaml", "--sensor", "10.42.0.99"), r"lumcal: a\.pcap: .*\n")])
def test_what_is_of_another_place_layout_or_sensor_makes_no_file(folder, words, told, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    assert _cli.main(["eyes", "a.pcap", "b.pcap", *words, "-o", "none.yaml", "--report", "none.html"]) == 1
    out, err = capsys.readouterr()
    assert out == "" and re.fullmatch(told, err), err
    assert sorted(folder.iterdir()) == before
