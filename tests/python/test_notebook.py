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


def test_the_picture_is_that_of_the_frame(frame, monkeypatch):
    Axes = pytest.importorskip("matplotlib.axes").Axes
    shown, show = [], Axes.imshow

    def see(axes, image, **options):
        shown.append((image, options["extent"]))
        return show(axes, image, **options)

    monkeypatch.setattr(Axes, "imshow", see)
    assert _notebook.to_png(frame)
    ((image, extent),) = shown
    assert extent == (60.0, -60.0, -17.0, 3.0)
    assert np.array_equal(image, frame.image("range", rows=64, columns=800), equal_nan=True)
    assert np.nanmin(image) == frame["range"].min()


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
                                     {"columns": "x,y,z,range"}, {"columns": "range"}])
def test_never_raises(capture, options):
    shown = next(iter(lumsdk.open(capture, **options)))._repr_html_()
    assert "<table>" in shown and "Frame" in shown


def test_a_failure_in_matplotlib_leaves_the_table(frame, monkeypatch):
    def fail(_):
        raise RuntimeError("no fonts")

    monkeypatch.setattr(_notebook, "to_png", fail)
    assert "<table>" in frame._repr_html_() and "<img" not in frame._repr_html_()
