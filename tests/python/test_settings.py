"""Calibrations and profiles: files are taken and refused as lumdump takes and refuses them."""
import pickle
import subprocess

import lumsdk
import numpy as np
import pytest
from conftest import BIN
from hypothesis import given
from hypothesis import strategies as st

V1 = "version: 1\n"
ROOT = ["", " \n\n", "# nothing\n# here\n", "---\n", "---\n...\n", "\n- 1\n", "hello\n", "~\n", "&a {version: 1}\n",
        "!!map {version: 1}\n", "*a\n", V1 + "---\n" + V1, V1 + "...\n---\n", V1 + "\nversion: 1\n",
        V1 + "'version': 1\n", V1 + "verison: 1\n", "x: &a [*a, *a]\n", "<<: {version: 1}\n", V1 + "? [a, b]\n: 1\n",
        V1 + "{a: b}: 1\n", V1 + "&k version: 1\n", V1 + "!!str version: 1\n", "version: &a 1\n", "version: !!int 1\n",
        "version: ! 1\n", "version: *a\n", "version: &a [1]\n", "version: !!seq [1]\n", "version: [1]\n",
        "version:\n- 1\n", "version: {a: 1}\n", "version:\n", "version\n: 1\n", V1 + "\tversion: 1\n", "version: 2\n",
        '"\\n\\e[2J\\u2028": 1\n', V1 + "k" * 900 + ": 1\n"]
PLAIN = ["{version: 1\n", "version: 'x\n", V1 + "%TAG\n", "\nversion: @x\n", V1 + "\n# caf\udce9\n", V1 + "# \udcc0\udcaf\n",
         V1 + "# \x01\n", "\udcff\udcfev"]
NUMBERS = [".nan", ".inf", "inf", "1e999", "99999999999999999999999999", "~", "true", "0x10", "017", "-007.5", "1_000",
           "1:30", "1,5", "1.5.", "1.5 m", "1e", "+-1", "1f", '"1"', "'1'", "|\n    1", "\u0661", "", "[1]", "{a: 1}",
           "8.5", "-0.1", '"\\n"', "k" * 80, "1e3"]
CALIBRATIONS = [*(f"{V1}tof_lsb_ps: {number}\n" for number in NUMBERS),
                *(f"{V1}eyes:\n  blue: \n   tof_offset_ps: {number}\n" for number in NUMBERS),
                V1 + "eyes: 1\n", V1 + "eyes: {blue: {mount: 1}}\n", V1 + "eyes: {red: {}}\n", V1 + "eyes.blue: {}\n",
                V1 + "eyes: {blue: {elevation: {min_deg: 5}}}\n", V1 + "eyes: {blue: {elevation: {max_deg: -20}}}\n",
                "speed_of_light: 3e8\n", "{}", "eyes: {green: {}, blue: {mount: {}}}"]
PROFILES = [*(f"{V1}angle_lsb_deg: {number}\n" for number in NUMBERS), *(f"{V1}group: {{line: {number}}}\n"
                                                                        for number in ("8.0", "42", "none", "7")),
            "data_packet_type: 9\n", V1 + "data_packet_type: 7\n", V1 + "set_ip_order: big\n",
            V1 + "set_ip_order: 'little'\n", V1 + "set_ip_order: \"network\"\n", V1 + "angle_order: azimuth\n",
            V1 + "group: {timestamp: none, samples: 20}\n", V1 + "group: {timestamp: none}\n", V1 + "group: {tag: 8}\n",
            V1 + "group: {line: {at: 12}}\n", V1 + "group: {line: {at: 12, bytes: 3}}\n",
            V1 + "eye_values: {blue: 1, green: 1}\n", V1 + "tlv: {status: 1, debug: 1}\n", V1 + "line_span_us: -1\n",
            V1 + "group: {timestamp: {bytes: 2}, eye: {at: 40}, line: 42, samples: 48}\ntlv: {yscan: 9}\n"]


def of_lumdump(capture, kind, path):
    """What lumdump says of a file; empty: it takes it."""
    done = subprocess.run([BIN / "lumdump", capture, f"--{kind}", path, "--json", "-q", "--duration", "0.001"],
                          capture_output=True, check=False)
    said = done.stderr.decode(errors="replace").strip().replace("lumdump: ", "", 1)
    return said if said.startswith(str(path)) else ""


def check(capture, tmp_path, kind, make, text, is_whole=True):
    path = tmp_path / "f"
    path.write_bytes(text.encode(errors="surrogateescape"))
    want = of_lumdump(capture, kind, path)
    if not want:
        make(path)
        return
    with pytest.raises(lumsdk.OptionError) as caught:
        make(path)
    got = str(caught.value)
    if not is_whole:  # the two libraries word what is no YAML differently
        want, got = (said.split(" Y")[0].split(": not plain")[0] for said in (want, got))
    assert got == want, text


@pytest.fixture
def tiny(make_capture):
    return make_capture("-n", 1, "--loss", 0.99)


@pytest.mark.parametrize("kind, make, texts", [
    ("calibration", lumsdk.Calibration, [*ROOT, *CALIBRATIONS]), ("profile", lumsdk.Profile, [*ROOT, *PROFILES])])
def test_files_are_refused_with_lumdumps_sentence(tiny, tmp_path, kind, make, texts):
    for text in texts:
        check(tiny, tmp_path, kind, make, text)
    for text in PLAIN:
        check(tiny, tmp_path, kind, make, text, is_whole=False)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(lumsdk.OptionError, match="cannot be read: No such file"):
        lumsdk.Calibration(tmp_path / "none.yaml")
    with pytest.raises(lumsdk.OptionError, match="is a directory; a YAML file is needed"):
        lumsdk.Calibration(tmp_path)
    (tmp_path / "long").write_bytes(b"#" * 65537)
    with pytest.raises(lumsdk.OptionError, match="longer than the 65536 bytes"):
        lumsdk.Profile(tmp_path / "long")


def test_a_file_with_the_mark_of_utf8_is_read(tmp_path):
    (tmp_path / "f").write_bytes(b"\xef\xbb\xbfversion: 1\ntof_lsb_ps: 12.5\n")
    assert lumsdk.Calibration(tmp_path / "f")["tof_lsb_ps"] == 12.5


def test_it_is_a_mapping_of_values_with_their_types():
    calibration, profile = lumsdk.Calibration(), lumsdk.Profile()
    assert calibration["eyes.blue.mount.yaw_deg"] == -30.0
    assert isinstance(calibration["eyes.blue.mount.x_m"], float)
    assert profile["group.line"] == profile["group.line.at"] and isinstance(profile["group.line"], int)
    assert profile["set_ip_order"] == "network" and profile["angle_lsb_deg"] == "span"
    assert len(calibration) == len(list(calibration)) == 25
    assert "eyes.blue" not in calibration and calibration.get("eyes") is None
    with pytest.raises(KeyError, match="did you mean 'tof_lsb_ps'"):
        calibration["tof_lsb"]
    assert lumsdk.Profile({"group.timestamp": "none"})["group.timestamp"] == "none"


def test_it_is_made_of_text_mapping_and_another():
    nested = lumsdk.Calibration({"eyes": {"blue": {"mount": {"x_m": 0.5}}}})
    dotted = lumsdk.Calibration({"eyes.blue.mount.x_m": np.float32(0.5)})
    written = lumsdk.Calibration("version: 1\neyes: {blue: {mount: {x_m: 0.5}}}\n")
    assert nested == dotted == written == lumsdk.Calibration(nested) == lumsdk.Calibration().replace(nested)
    assert nested != lumsdk.Calibration() and hash(nested) == hash(written)
    assert repr(nested) == "Calibration({'eyes.blue.mount.x_m': 0.5})"
    assert nested.replace({"tof_lsb_ps": 12})["eyes.blue.mount.x_m"] == 0.5


def test_what_is_wrong_is_told():
    with pytest.raises(lumsdk.OptionError, match="the calibration: eyes: unknown key 'red'"):
        lumsdk.Calibration({"eyes": {"red": {"mount": {"x_m": 1}}}})
    with pytest.raises(TypeError, match="tof_lsb_ps: a value is a number or a word, not list"):
        lumsdk.Calibration({"tof_lsb_ps": [1]})
    with pytest.raises(TypeError, match="a calibration is a path, a text of YAML, a mapping"):
        lumsdk.Calibration(3)
    with pytest.raises(TypeError, match="a profile is given where a calibration belongs"):
        lumsdk.Calibration(lumsdk.Profile())
    with pytest.raises(lumsdk.OptionError, match="elevation.*(the default)"):
        lumsdk.Calibration({"eyes.blue.elevation.min_deg": 10})
    with pytest.raises(TypeError, match="a key is a text"):
        lumsdk.Profile({1: 2})


@pytest.mark.parametrize("given, made", [([4, 11], "[4, 11]"), ((0, 13), "[0, 13]"), (np.array([4, 11]).tolist(), "[4, 11]"),
                                         ((np.uint8(4), np.int64(11)), "[4, 11]"), ("[4, 11]", "[4, 11]"), ("all", "all")])
def test_bits_are_a_pair_or_a_word(given, made):
    for profile in (lumsdk.Profile({"group": {"line": {"bits": given}}}), lumsdk.Profile().replace({"group.line.bits": given}),
                    lumsdk.Profile(f"version: 1\ngroup: {{line: {{bits: {made}}}}}\n")):
        assert profile["group.line.bits"] == made
        assert lumsdk.Profile(profile.to_yaml()) == lumsdk.Profile(dict(profile)) == pickle.loads(pickle.dumps(profile)) == profile


@pytest.mark.parametrize("given, told", [
    ([4], r"'\[4\]' is not \[LOW, HIGH\]"), ([4, 5, 6], r"is not \[LOW, HIGH\]"), ([4, "x"], r"is not \[LOW, HIGH\]"),
    ([4.5, 6], r"is not \[LOW, HIGH\]"), ([11, 4], "has the higher number first"), ([0, 64], "0 to 63"), (4, r"\[LOW, HIGH\]")])
def test_bits_that_are_no_pair_are_refused(given, told):
    with pytest.raises(lumsdk.OptionError, match=f"the profile: group.line.bits: .*{told}"):
        lumsdk.Profile({"group.line.bits": given})


def test_what_cannot_be_a_pair_is_told():
    for wrong in [True, 2], [[1, 2], 3], None:
        with pytest.raises(TypeError, match=r"group.line.bits: a value is a word, or two whole numbers such as \[0, 13\], not"):
            lumsdk.Profile({"group.line.bits": wrong})


def test_bits_are_set_on_top(capture):
    for chosen in {"group.line.bits": [0, 13]}, ["group.line.bits=[0, 13]"], "group.line.bits=[0,13]":
        with lumsdk.open(capture, set=chosen) as source:
            assert source.profile["group.line.bits"] == "[0, 13]"


@given(st.dictionaries(st.sampled_from(["x_m", "y_m", "z_m"]), st.floats(-1000, 1000)),
       st.floats(200e6, 310e6), st.floats(1e-3, 1000))
def test_its_text_reads_back_exactly(mount, speed, lsb):
    made = lumsdk.Calibration({"eyes": {"green": {"mount": mount}}, "speed_of_light": round(speed), "tof_lsb_ps": lsb})
    assert lumsdk.Calibration(made.to_yaml()) == made
    assert pickle.loads(pickle.dumps(made)) == made
    assert lumsdk.Calibration(dict(made)) == made


def test_a_capture_brings_its_own(make_capture, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text("eyes: {blue: {mount: {x_m: 1.25}}}\n")
    capture, out = make_capture("-n", 1), tmp_path / "own.pcapng"
    subprocess.run([BIN / "lumdump", capture, "-q", "--calibration", own, "-o", out], check=True)
    with lumsdk.open(out) as source:
        assert source.calibration["eyes.blue.mount.x_m"] == 1.25
        assert "lumdump" in source.provenance[0] and source.profile == lumsdk.Profile()
        shifted = next(iter(source))["x"]
    with lumsdk.open(out, set={"eyes.blue.mount.y_m": 2}) as source:
        assert source.calibration["eyes.blue.mount.x_m"] == 1.25 and source.calibration["eyes.blue.mount.y_m"] == 2
    with open(out, "rb") as file:
        assert np.array_equal(next(iter(lumsdk.open(file)))["x"], shifted)
    assert lumsdk.open(out.read_bytes()).calibration == lumsdk.Calibration(own)
    with pytest.warns(lumsdk.CaptureWarning, match="which is not used: calibration= names another"):
        with lumsdk.open(out, calibration={}) as source:
            assert source.calibration == lumsdk.Calibration()
            assert not np.array_equal(next(iter(source))["x"], shifted)


def test_a_comment_that_cannot_be_used_is_told(make_capture, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text("eyes: {blue: {mount: {x_m: 1.25}}}\n")
    out = tmp_path / "own.pcapng"
    subprocess.run([BIN / "lumdump", make_capture("-n", 1), "-q", "--calibration", own, "-o", out], check=True)
    content = out.read_bytes()
    for old, new, said in [(b"x_m: 1.25", b"x_m: none", "its calibration:"), (b"calibration 1", b"calibration 2",
                                                                             "the comment 'calibration 2'")]:
        assert old in content
        with pytest.warns(lumsdk.CaptureWarning, match=said):
            assert lumsdk.open(content.replace(old, new)).calibration == lumsdk.Calibration()
