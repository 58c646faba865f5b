"""view(): the page, and what is in it for its script, which tests/view has in a browser."""
import base64
import html
import io
import json
import os
import pathlib
import re
import stat
import struct
import sys
import types
import warnings

import lumsdk
import numpy as np
import pytest
from lumsdk import _shown, _view

pytestmark = pytest.mark.skipif(not pathlib.Path(_view.__file__).with_name("lumview.html").exists(), reason="built without lumview.html")


@pytest.fixture(scope="module")
def frame(capture):
    return next(iter(lumsdk.open(capture, columns="all")))


def data_of(view):
    file = io.BytesIO()
    file.writelines(view._parts())
    return json.loads(re.search(rb'<script type="application/json" id="lumview-data">(.*?)</script>', file.getvalue())[1])


def shown(given, **options):
    return data_of(lumsdk.view(given, browser=False, **options))


def heads(message):
    """Of each piece: the frame's number and points, and the points of the piece (lum/frame/packed.h)."""
    content, at, out = base64.b64decode(message), 0, []
    while at < len(content):
        length, piece, pieces, count = struct.unpack_from("<IIII", content, at + 80)
        out.append((struct.unpack_from("<d", content, at + 8)[0], struct.unpack_from("<I", content, at + 32)[0], count))
        assert piece < pieces
        at += length
    return out


def of_page(data):
    """The numbers and counts of frames."""
    made = []
    for message in data["frames"]:
        (number, total), = {head[:2] for head in heads(message)}
        assert sum(count for _, _, count in heads(message)) == total
        made.append((number, total))
    return made


def test_a_capture_is_in_the_page_as_it_is(capture):
    data = shown(capture, calibration={"eyes.blue.mount.x_m": 0.25})
    (one,) = data["captures"]
    assert one["name"] == capture.name and base64.b64decode(one["base64"]) == capture.read_bytes()
    assert lumsdk.Calibration(data["options"]["calibration"]["text"])["eyes.blue.mount.x_m"] == 0.25
    assert lumsdk.Profile(data["options"]["profile"]["text"]) == lumsdk.Profile()
    with lumsdk.open(capture, set={"eyes.blue.mount.x_m": 0.25}) as source:
        assert shown(source) == data


@pytest.mark.parametrize("as_what", [str, lambda path: path.read_bytes(), lambda path: open(path, "rb"), lambda path: [path]])
def test_a_capture_is_given_as_to_open(capture, as_what):
    assert shown(as_what(capture))["captures"][0]["base64"] == shown(capture)["captures"][0]["base64"]


def test_all_of_a_file_object_is_read(capture):
    class Slow(io.BytesIO):
        def read(self, count=-1):
            return super().read(1000 if count is None or count < 0 else min(count, 1000))
    assert shown(Slow(capture.read_bytes()))["captures"][0]["base64"] == shown(capture)["captures"][0]["base64"]


def test_what_can_be_read_only_once_is_shown_as_its_frames(capture):
    class Pipe(io.BytesIO):
        def seekable(self):
            return False
    assert of_page(shown(Pipe(capture.read_bytes()))) == [(frame.number, len(frame)) for frame in lumsdk.open(capture)]


def test_a_rig_comes_with_all_of_its_files(capture):
    rig = lumsdk.Rig([{"name": "front", "address": "10.42.0.37", "pose": {"x_m": 1.5}, "calibration": {"tof_lsb_ps": 12.9}}])
    options = shown(capture, rig=rig)["options"]
    assert "front-calibration.yaml" in options["rig"]["text"]
    beside = {one["name"]: one["text"] for one in options["beside"]}
    assert lumsdk.Calibration(beside["front-calibration.yaml"]) == rig["front"].calibration


def test_a_source_that_chooses_is_shown_as_its_frames(capture):
    data = shown(capture, range="5:20", frames="2:3")
    known = [(frame.number, len(frame)) for frame in lumsdk.open(capture, range="5:20", frames="2:3")]
    assert of_page(data) == known and data["hello"]["source"] == str(capture)
    with lumsdk.open(capture) as source:
        assert of_page(shown(source.seek(0.15))) == [(frame.number, len(frame)) for frame in source.seek(0.15)]


def test_frames_have_all_their_points(capture, frame):
    frames = list(lumsdk.open(capture))
    assert of_page(shown(frames)) == [(one.number, len(one)) for one in frames]
    with pytest.warns(UserWarning, match="do not rise, so the page numbers them from 0 on"):
        assert of_page(shown(frames[::-1])) == [(i, len(one)) for i, one in enumerate(frames[::-1])]
    with lumsdk.open(capture) as source:
        assert of_page(shown(source[:2])) == of_page(shown(iter(frames[:2])))
    hello = shown(frame)["hello"]
    assert [eye["name"] for eye in hello["eyes"]] == ["blue", "green"] and hello["eyes"][0]["lacks"] == []
    assert hello["source"] == "10.42.0.37" and hello["labels"] is None


def test_the_eyes_are_where_the_ranges_say(capture, frame):
    own = {"eyes.green.mount.y_m": -0.5}
    with lumsdk.open(capture, calibration=own) as source:
        made = next(iter(source))
    mount = shown(made, calibration=own)["hello"]["eyes"][1]["mount"]
    assert mount == pytest.approx([0, -0.5, 0])

    def is_unknown(one, **options):
        (first, _) = shown(one, **options)["hello"]["eyes"]
        return "place" in first["lacks"]
    assert not is_unknown(made, calibration=own) and is_unknown(made) and is_unknown(frame, calibration=own)
    assert is_unknown(frame.replace(x=frame["x"] + np.float32(0.01))), "moved"


@pytest.mark.filterwarnings("ignore:the numbers of the frames")
def test_where_the_eyes_are_and_what_lacks_is_told_of_all_frames(frame):
    moved = frame.replace(x=frame["x"] + np.float32(5))
    bare = lumsdk.Frame.from_arrays({name: frame[name] for name in frame if name not in ("line", "pixel")}, sensor=frame.sensor)
    for second, lacks in ((frame, []), (moved, ["place"]), (bare, ["line"])):
        eyes = shown([frame, second])["hello"]["eyes"]
        assert [eye["lacks"] for eye in eyes] == [lacks, lacks]


def test_frames_that_were_chosen_of_a_rig_have_its_calibrations(capture):
    rig = lumsdk.Rig([{"name": "front", "address": "10.42.0.37", "pose": {"x_m": 1}, "calibration": {"eyes.blue.mount.y_m": 0.5}}])
    eye = shown(capture, rig=rig, frames="1:2")["hello"]["eyes"][0]
    assert eye["mount"] == pytest.approx([1, 0.5, 0]) and eye["lacks"] == []


def test_sets_that_were_read_without_a_rig_are_warned_of(frame):
    other = lumsdk.Frame.from_arrays({name: frame[name] for name in frame}, sensor="10.42.0.38", utc_ns=frame.utc_ns)
    with pytest.warns(UserWarning, match="were read without a rig"):
        shown(list(lumsdk.sync([frame, other])))


def test_losses_are_marks():
    with lumsdk.open(lumsdk.simulate(frames=4, loss=0.01)) as source:
        frames = list(source)
    inside = [one for one in frames if not one.first and not one.last]
    marks = {mark[0]: mark[1:] for mark in shown(frames)["hello"]["marks"]}
    assert sum(one.losses["lost_words"] for one in inside) > 0
    assert [marks.get(one.number, [0])[0] for one in inside] == [one.losses["lost_words"] for one in inside]


def test_points_that_float32_cannot_hold_are_warned_of():
    far = np.array([[500_000.125, 2, 3], [500_001.3, 2, 3]])
    with pytest.warns(UserWarning, match=r"rounds them by up to 0\.0125 m: subtract an origin"):
        shown(far)


def test_arrays_are_points(frame):
    points = np.random.default_rng(1).uniform(-50, 50, (7000, 3))
    data = shown(points)
    assert of_page(data) == [(0, 7000)]
    assert data["hello"]["eyes"][0]["name"] is None and set(data["hello"]["eyes"][0]["lacks"]) == {"line", "return", "edge", "eye",
                                                                                             "place"}
    assert of_page(shown([points, points[:10]])) == [(0, 7000), (1, 10)]
    assert of_page(shown({"xyz": points.astype("f4")})) == of_page(shown(np.asarray(frame)[:7000]["x"][:, None] * np.ones((1, 3)))) == [
        (0, 7000)]


def test_points_that_are_nowhere_are_left_out(frame):
    x = frame["x"].copy()
    x[::3] = np.nan
    data = shown(frame.replace(x=x).with_columns(label=np.arange(len(x)) % 4))
    assert of_page(data) == [(frame.number, int(np.isfinite(x).sum()))]
    (number, text), = data["hello"]["labels"]["frames"]
    assert number == frame.number
    assert np.array_equal(np.frombuffer(base64.b64decode(text), "u1"), (np.arange(len(x)) % 4 + 1)[np.isfinite(x)])


def test_masked_points_are_left_out():
    points = np.ma.array(np.ones((4, 3)), mask=False)
    points[1, 2] = np.ma.masked
    points.data[1, 2] = 1e20
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert of_page(shown(points)) == [(0, 3)]
        assert of_page(shown([np.ma.array(np.ones((4, 3), int), mask=points.mask), points.astype("f4")])) == [(0, 3), (1, 3)]
    rows = np.ma.zeros(4, [("x", "f4"), ("y", "f4"), ("z", "f4")])
    assert of_page(shown(rows)) == [(0, 4)]
    rows["y"][2] = np.ma.masked
    for given in (rows, {name: rows[name] for name in "xyz"}, {"xyz": points}):
        with pytest.raises(TypeError, match="a masked array"):
            shown(given)


def test_points_beyond_float32_are_counted():
    with pytest.warns(UserWarning) as told:
        assert of_page(shown([[[1e300, 2, -1e300], [1, 2, 3], [1, 1e39, 3], [np.inf, 2, 3]]])) == [(0, 1)]
    assert [str(one.message) for one in told] == ["2 points are beyond float32, and left out"]


def test_values_that_the_page_cannot_hold_are_warned_of_once(frame):
    points = {"xyz": np.ones((2, 3), "f4"), "line": [1, 70000], "return_number": [200, 1], "number_of_returns": [63, 64],
              "pulse_width": np.array([np.nan, 700], "f4")}
    with pytest.warns(UserWarning) as told:
        shown([points, points])
    (one,) = told
    assert str(one.message) == ("the page has line up to 65535, return_number up to 127, number_of_returns up to 63, pulse_width up "
                                "to 655.35: greater values are shown as these")
    most = {"xyz": points["xyz"], "line": [65535] * 2, "return_number": [127] * 2, "number_of_returns": [63] * 2,
            "pulse_width": np.array([655.35, 0], "f4")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        shown(most), shown(frame)


@pytest.mark.filterwarnings("ignore:the numbers of the frames")
def test_labels_are_small_numbers_with_names(frame):
    labels = np.where(frame["x"] > 10, -5, 900)
    made = shown([frame.with_columns(object=labels), frame])["hello"]["labels"]
    assert made["names"] == ["-5", "900"] and len(made["frames"]) == 1
    assert np.array_equal(np.frombuffer(base64.b64decode(made["frames"][0][1]), "u1"), np.where(labels == -5, 1, 2))
    floats = np.where(frame["x"] > 10, 1234567, 0.25)
    assert shown(frame.with_columns(label=floats))["hello"]["labels"]["names"] == ["0.25", "1234567"], "no digit is lost"
    with pytest.warns(UserWarning, match="300 different labels"):
        most = shown(frame.with_columns(label=np.arange(len(frame)) % 300))["hello"]["labels"]
    assert len(most["names"]) == 254 and max(base64.b64decode(most["frames"][0][1])) == 254


def test_sets_of_a_rig_are_shown_together(capture):
    rig = lumsdk.Rig([{"name": "front", "address": "10.42.0.37", "pose": {"x_m": 1.5, "yaw_deg": 90}}])
    with lumsdk.open(capture, rig=rig, frames="1:2") as source:
        data = shown(source)
    hello = data["hello"]
    assert hello["rig"]["sensors"] == ["front"] and len(data["frames"]) == 2 and len(hello["eyes"]) == 2
    assert hello["rig"]["poses"][0] == pytest.approx([0, -1, 0, 1.5, 1, 0, 0, 0, 0, 0, 1, 0])
    assert hello["eyes"][0]["mount"] == pytest.approx([1.5, 0, 0])
    assert base64.b64decode(data["frames"][0])[39] == 1, "a sensor of a rig"


def test_frames_of_several_sensors_are_refused(frame):
    other = lumsdk.Frame.from_arrays({name: frame[name] for name in frame}, sensor="10.42.0.38")
    with pytest.raises(lumsdk.OptionError, match=re.escape("lumsdk.view(lumsdk.sync(frames))")):
        lumsdk.view([frame, other], browser=False)


def test_points_of_no_sensor_are_not_mixed_with_frames(frame):
    for given in ([frame, np.ones((2, 3))], [np.ones((2, 3)), frame]):
        with pytest.raises(lumsdk.OptionError, match="frames of 10.42.0.37 and points of no sensor are mixed"):
            lumsdk.view(given, browser=False)


def test_frames_without_numbers_are_not_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert of_page(shown([{"xyz": np.ones((2, 3), "f4")}] * 2)) == [(0, 2), (1, 2)]


@pytest.mark.parametrize("height", [np.int64(500), np.uint16(500)])
def test_any_whole_number_is_a_height(height):
    assert lumsdk.view(np.ones((2, 3)), height=height, browser=False)._repr_html_().count("height:500px") == 1


def test_what_is_too_large_is_refused(capture, frame, monkeypatch):
    for module in (_view, _shown):
        monkeypatch.setattr(module, "MOST_BYTES", 1 << 20)
    for given in (capture, capture.read_bytes(), io.BytesIO(capture.read_bytes())):
        with pytest.raises(lumsdk.OptionError, match="a page, which holds at most 1 MB; use some of its frames"):
            lumsdk.view(given, browser=False)
    with pytest.raises(lumsdk.OptionError, match="use at most 1 of them"):
        lumsdk.view([frame[::2], frame[::2]], browser=False)
    with pytest.raises(lumsdk.OptionError, match="use a part of its points"):
        lumsdk.view(frame, browser=False)


@pytest.mark.parametrize("given", ["10.42.0.37", "udp://10.42.0.37:5517"])
def test_a_live_sensor_is_for_lumview(given):
    with pytest.raises(TypeError, match="the program 'lumview 10.42.0.37"):
        lumsdk.view(given, browser=False)
    with lumsdk.Sensor("127.0.0.1:1") as sensor, pytest.raises(TypeError, match="lumview 127.0.0.1:1"):
        lumsdk.view(sensor, browser=False)


@pytest.mark.parametrize("given, options, says", [
    ([], {}, "no frame"), (np.zeros((5, 2)), {}, r"use \(n, 3\)"), (object(), {}, "cannot be shown"),
    (np.full((2, 3), 3e6), {}, "subtract an origin"), (np.zeros((2, 3)), {"range": "1:2"}, "options of captures"),
    (np.zeros((2, 3)), {"height": 5}, "from 100 to 10000"), (np.zeros((2, 3)), {"height": 500.0}, "from 100 to 10000"),
    (np.zeros((2, 3)), {"height": True}, "from 100 to 10000")])
def test_what_cannot_be_shown_is_refused(given, options, says):
    with pytest.raises((lumsdk.OptionError, TypeError), match=says):
        lumsdk.view(given, browser=False, **options)


def test_a_frame_without_places_is_refused(capture):
    with pytest.raises(lumsdk.UnknownKeyError, match="no column 'z'"):
        lumsdk.view(next(iter(lumsdk.open(capture, columns=["x", "y"]))), browser=False)


def test_without_the_page_it_says_so(monkeypatch, tmp_path, frame):
    monkeypatch.setattr(_view, "__file__", str(tmp_path / "_view.py"))
    with pytest.raises(lumsdk.Error, match=re.escape("docs/internals/wheels.md")):
        lumsdk.view(frame, browser=False)


def test_a_script_opens_a_browser_once_with_a_file_of_ones_own(frame, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(_view.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(_view.webbrowser, "get", lambda: types.SimpleNamespace(open=lambda url: asked.append(url) or True))
    view = lumsdk.view(frame)
    path = pathlib.Path(view.path)
    assert asked == [path.as_uri()] and path.parent == tmp_path
    assert os.name == "nt" or stat.S_IMODE(path.stat().st_mode) == 0o600
    assert view.open() == view.path and len(list(tmp_path.iterdir())) == 1
    view.save(tmp_path / "saved.html")
    assert (tmp_path / "saved.html").read_bytes() == path.read_bytes()
    assert str(path) in repr(view)


def test_where_no_browser_is_the_path_is_told(frame, monkeypatch, tmp_path):
    monkeypatch.setattr(_view.tempfile, "tempdir", str(tmp_path))
    for found in (_view.webbrowser.GenericBrowser("lynx"), types.SimpleNamespace(open=lambda url: False)):
        monkeypatch.setattr(_view.webbrowser, "get", lambda found=found: found)
        with pytest.warns(UserWarning, match=re.escape(str(tmp_path))):
            lumsdk.view(frame)


def test_a_notebook_has_the_page_in_the_cell(frame, monkeypatch):
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(kernel=1)))
    view = lumsdk.view(frame.with_columns(label=np.arange(len(frame)) % 2), height=300)
    assert view.path is None, "no browser"
    cell = view._repr_html_()
    assert cell.startswith("<iframe") and "height:300px" in cell and 'sandbox="allow-scripts allow-downloads"' in cell
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', cell)[1])
    file = io.BytesIO()
    file.writelines(view._parts())
    assert page.encode() == file.getvalue()
    monkeypatch.setattr(_view, "_MOST_OF_CELL", 1000)
    assert "<iframe" not in view._repr_html_() and ".save(" in view._repr_html_()


def test_names_do_not_end_the_script(capture, tmp_path):
    path = tmp_path / "<!--<script>&.pcap"
    path.write_bytes(capture.read_bytes())
    assert shown(path)["captures"][0]["name"] == path.name
