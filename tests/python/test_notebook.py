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


def size_of(png):
    assert png.startswith(b"\x89PNG") and len(png) > 10000
    return struct.unpack(">II", png[16:24])


def test_the_picture_is_that_of_the_frame(frame, monkeypatch):
    """What is drawn: from above the values of points where they stand, the highest first, and both eyes by image()."""
    Axes = pytest.importorskip("matplotlib.axes").Axes
    shown, show = [], Axes.imshow

    def see(axes, image, **options):
        shown.append((image, options["extent"], options["norm"]))
        return show(axes, image, **options)

    monkeypatch.setattr(Axes, "imshow", see)
    assert size_of(frame.to_png()) == (1600, 1200)
    (strip, angles, norm), (above, metres, _) = shown
    assert angles == (60.0, -60.0, -17.0, 3.0)
    assert np.array_equal(strip, frame.image("range", columns=800), equal_nan=True)
    assert (norm.vmin, norm.vmax) == pytest.approx(np.percentile(frame["range"], (2, 98)))
    left, right, low, high = metres
    assert (left - right) / above.shape[1] == pytest.approx((high - low) / above.shape[0])
    rows, columns = np.nonzero(np.isfinite(above))
    far = np.hypot(low + rows * (high - low) / above.shape[0], left - columns * (left - right) / above.shape[1])
    ranges = above[rows, columns]
    assert np.percentile(np.abs(far - ranges), 90) < 2.5, "from above a range is nearly the distance"
    assert 0.9 * np.percentile(frame["range"], 95) < far.max()


@pytest.mark.parametrize("colour", ["height", "pulse_width", "label"])
def test_colours_are_of_what_is_asked_for(frame, colour):
    pytest.importorskip("matplotlib")
    made = frame.with_columns(label=(frame["x"] // 5).astype("i2")).to_png(colour, size=(1000, 750))
    assert size_of(made) == (1000, 750)
    assert made != frame.to_png(size=(1000, 750))


@pytest.mark.parametrize("options, says", [({"colour": "red"}, "use one of range, height, pulse_width, label"),
                                           ({"colour": "label"}, "there is no column 'label'"),
                                           ({"size": (639, 800)}, "each from 640 to 8000"), ({"size": (800,)}, "width, height")])
def test_what_cannot_be_drawn_is_refused(frame, options, says):
    with pytest.raises((lumsdk.OptionError, KeyError), match=re.escape(says)):
        frame.to_png(**options)


def test_a_frame_of_no_points_has_no_picture(frame):
    with pytest.raises(lumsdk.OptionError, match="has no points"):
        frame[frame["range"] > 900].to_png()


def test_points_that_are_nowhere_are_not_drawn(frame):
    pytest.importorskip("matplotlib")
    x = frame["x"].copy()
    x[::2] = np.nan
    assert size_of(frame.replace(x=x).to_png()) == (1600, 1200)
    with pytest.raises(lumsdk.OptionError, match="has no points"):
        frame.replace(x=np.full_like(x, np.nan)).to_png()


def test_to_png_without_matplotlib_names_the_extra(frame, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(lumsdk.Error, match="notebook"):
        frame.to_png()


def test_shows_both_with_matplotlib(frame):
    pytest.importorskip("matplotlib")
    shown = frame._repr_html_()
    assert size_of(base64.b64decode(re.search(r'base64,([^"]+)"', shown)[1])) == (1000, 750)
    assert "<table>" in shown


def test_needs_no_screen_and_leaves_pyplot_alone(capture):
    pytest.importorskip("matplotlib")
    program = ("import lumsdk, sys; f = next(iter(lumsdk.open(sys.argv[1]))); assert '<img' in f._repr_html_(); "
               "assert 'matplotlib.pyplot' not in sys.modules")
    subprocess.run([sys.executable, "-c", program, str(capture)], check=True)


@pytest.mark.parametrize("options", [{"range": "900:901"}, {"columns": "x,y,z"}, {"eye": "blue"},
                                     {"columns": "x,y,z,range"}, {"columns": "range"}])
def test_never_raises(capture, options):
    shown = next(iter(lumsdk.open(capture, **options)))._repr_html_()
    assert "<table>" in shown and "Frame" in shown


def test_a_failure_in_matplotlib_leaves_the_table(frame, monkeypatch):
    def fail(*_):
        raise RuntimeError("no fonts")

    monkeypatch.setattr(_notebook, "to_png", fail)
    assert "<table>" in frame._repr_html_() and "<img" not in frame._repr_html_()
