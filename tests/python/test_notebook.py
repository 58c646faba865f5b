"""A frame in a notebook: pictures where matplotlib is, a table of counts always, and never an exception."""
import base64
import re
import struct
import subprocess
import sys

import lumsdk
import numpy as np
import pytest
from lumsdk import _notebook


@pytest.fixture(scope="module")
def frame(capture):
    return next(iter(lumsdk.open(capture, columns="all")))


def test_without_matplotlib_it_is_a_table(frame, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.setitem(sys.modules, "matplotlib.backends.backend_agg", None)
    shown = frame._repr_html_()
    assert "<img" not in shown and f"{len(frame):,}" in shown and "64 blue, 64 green" in shown and "10.42.0.37" in shown


def test_a_range_image_has_the_nearest_point_of_each_cell(frame):
    image, (left, right) = _notebook.range_image(frame, "green")
    assert image.shape == (64, 400) and left > 55 and -5 < right < 5  # the green eye looks to the left
    azimuths = np.degrees(np.arctan2(frame["y"], frame["x"]))
    green = frame["eye"] == 1
    assert np.nanmin(image) == frame["range"][green].min()
    for line in (10, 11):  # scanned to one side, and to the other
        chosen = green & (frame["line"] == line)
        at = np.rint((left - azimuths[chosen]) * 399 / (left - right)).astype(int)
        for column in np.unique(at)[::40]:
            assert image[line, column] == frame["range"][chosen][at == column].min()


def test_the_same_azimuth_has_the_same_label(capture, monkeypatch):
    """Whatever columns are there: that of the eye is turned by 30 degrees against that of the sensor."""
    Axes = pytest.importorskip("matplotlib.axes").Axes
    labels = []
    monkeypatch.setattr(Axes, "set_xlabel", lambda axes, label, **_: labels.append(label))
    needed = ["range", "line", "eye"]
    seen = {}
    for columns in ["all", [*needed, "x", "y"], [*needed, "azimuth"], [*needed, "azimuth", "x"]]:
        frame = next(iter(lumsdk.open(capture, columns=columns)))
        assert _notebook.to_png(frame)
        (label,) = {labels.pop(), labels.pop()}
        ends = tuple(_notebook.range_image(frame, eye)[1] for eye in _notebook.EYES)
        assert seen.setdefault(label, ends) == ends
    assert len(seen) == 2
    of_sensor, of_eye = seen["azimuth from the sensor, degrees"], seen["azimuth in the eye, degrees"]
    assert np.abs(np.subtract(of_sensor, of_eye)).min() > 25


def test_many_lines_make_no_larger_picture(make_capture):
    frame = next(iter(lumsdk.open(make_capture("-n", 1, "--lines", 640), columns="all")))
    assert _notebook.range_image(frame, "blue")[0].shape == (320, 400)


def test_a_damaged_line_number_does_not_spoil_the_picture(frame):
    class Damaged:
        """The frame, with a line that claims a high number."""

        def __init__(self):
            self.lines = frame.lines.copy()
            self.lines["number"][3] = 60000
            self.columns = frame.columns

        def __getitem__(self, name):
            return frame[name]

    assert _notebook.range_image(Damaged(), "blue")[0].shape == (64, 400)


def test_shows_both_eyes_with_matplotlib(frame):
    pytest.importorskip("matplotlib")
    shown = frame._repr_html_()
    png = base64.b64decode(re.search(r'base64,([^"]+)"', shown)[1])
    assert png.startswith(b"\x89PNG") and len(png) > 10000
    width, height = struct.unpack(">II", png[16:24])
    assert 500 < width < 1500 and 100 < height < 600
    assert "<table>" in shown


def test_needs_no_screen_and_leaves_pyplot_alone(capture):
    pytest.importorskip("matplotlib")
    program = ("import lumsdk, sys; f = next(iter(lumsdk.open(sys.argv[1]))); assert '<img' in f._repr_html_(); "
               "assert 'matplotlib.pyplot' not in sys.modules")
    subprocess.run([sys.executable, "-c", program, str(capture)], check=True)


@pytest.mark.parametrize("options", [{"range": "900:901"}, {"columns": "x,y,z"}, {"eye": "blue"},
                                     {"columns": "x,y,z,range,line,eye"}, {"columns": "range"}])
def test_never_raises(capture, options):
    shown = next(iter(lumsdk.open(capture, **options)))._repr_html_()
    assert "<table>" in shown and "Frame" in shown


def test_a_failure_in_matplotlib_leaves_the_table(frame, monkeypatch):
    def fail(_):
        raise RuntimeError("no fonts")

    monkeypatch.setattr(_notebook, "to_png", fail)
    assert "<table>" in frame._repr_html_() and "<img" not in frame._repr_html_()
