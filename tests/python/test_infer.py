"""infer(): what lumdump --infer finds, as Python has it."""
import io
import json

import conftest
import pytest

import lumsdk

OTHER = {"data_packet_type": 3, "group.tag": 13, "group.eye": 12, "group.samples": 28}


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    path = tmp_path_factory.mktemp("infer") / "c.pcap"
    lumsdk.simulate(path, frames=2, lines=64, set=OTHER)
    return path


def points(capture, profile):
    with lumsdk.open(capture, profile=profile) as source:
        return [frame.xyz.tobytes() for frame in source]


def test_the_profile_gives_the_points_of_the_true_one(capture):
    found = lumsdk.infer(capture)
    assert found.verdict in ("found", "unsure")
    assert found.profile["group.tag"] == 13
    expected = points(capture, lumsdk.Profile(OTHER))
    assert len(expected) == 2
    assert points(capture, found.profile) == expected
    assert points(capture, lumsdk.Profile(found.yaml)) == expected


def test_it_is_what_lumdump_tells(capture):
    found, told = lumsdk.infer(capture), json.loads(conftest.run("lumdump", capture, "--infer", "--json"))
    assert (found.verdict, found.text, found.yaml) == (told["verdict"], told["text"], told["profile"])
    assert (found.packets, found.fit, round(found.margin, 3)) == (told["packets"], told["fit"], told["margin"])
    assert found.margin_key == told["margin_key"]
    assert found.counts == {name: told[name] for name in found.counts}
    assert (found.second is None) == (told["second"] is None)
    assert [vars(finding) for finding in found.findings] == told["findings"]


def test_every_kind_of_source(capture):
    expected = lumsdk.infer(capture).yaml
    content = capture.read_bytes()
    for source in content, io.BytesIO(content), str(capture), [capture], str(capture.parent / "*.pcap"):
        assert lumsdk.infer(source).yaml == expected


def test_a_sensor_is_chosen(capture):
    assert lumsdk.infer(capture, sensor="10.42.0.37").profile is not None
    other = lumsdk.infer(capture, sensor="10.42.0.99")
    assert other.profile is None and other.packets == 0 and sum(other.counts.values()) == other.counts["elsewhere"] > 100
    with pytest.raises(lumsdk.OptionError, match="sensor"):
        lumsdk.infer(capture, sensor="here")


def test_nothing_that_fits_is_told_and_not_raised(capture):
    found = lumsdk.infer(capture.read_bytes()[:24])
    assert (found.verdict, found.profile, found.second, found.findings, found.yaml) == ("too little", None, None, (), "")
    assert found.text and not found.margin_key


def test_a_capture_that_breaks_off_is_a_warning(capture):
    with pytest.warns(lumsdk.CaptureWarning):
        assert lumsdk.infer(capture.read_bytes()[:-100]).profile is not None


def test_what_is_no_capture_is_refused(tmp_path):
    with pytest.raises(lumsdk.CaptureError, match="none.pcap"):
        lumsdk.infer(tmp_path / "none.pcap")
    with pytest.raises(lumsdk.CaptureError):
        lumsdk.infer(b"not a capture, but long enough to be looked at")


def test_what_a_file_object_raises_is_raised(capture):
    class Broken(io.BytesIO):
        def readinto(self, _):
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        lumsdk.infer(Broken(capture.read_bytes()))
