"""Pictures of frames: they lie as the world does, and a mask on one selects points."""
import pickle

import lumsdk
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

CHOICES = ("nearest", "farthest", "strongest", "first", "last")


@pytest.fixture(scope="module")
def frames(make_capture):
    (made,) = lumsdk.open(make_capture("-n", 1, "--loss", 0.01, "--seed", 34), columns="all", edge="both")
    return [made, pickle.loads(pickle.dumps(made, protocol=5))]


@pytest.fixture(scope="module")
def room(make_capture):
    (made,) = lumsdk.open(make_capture("-n", 1, "--scene", "room"), columns="all")
    return made


def rank(frame, returns):
    """Of the points of a pixel, the one with the smallest number fills it, the first among equals."""
    square = (frame["x"] * frame["x"] + frame["y"] * frame["y"]) + frame["z"] * frame["z"]
    place = np.arange(len(frame))
    return {"nearest": square, "farthest": -square, "strongest": -frame["pulse_width"], "first": place, "last": -place}[returns]


@settings(max_examples=40)
@given(eye=st.sampled_from(["blue", "green", "both"]), returns=st.sampled_from(CHOICES), pickled=st.booleans(),
       rows=st.integers(1, 200), columns=st.integers(1, 900))
def test_a_picture_and_its_points_agree_in_both_directions(frames, eye, returns, pickled, rows, columns):
    frame = frames[pickled]
    size = {"rows": rows, "columns": columns}
    index, lie = frame.image_index(eye, returns, **size), frame.image_pixels(eye, **size)
    assert index.shape == (rows, columns) and lie.shape == (len(frame),)
    asked = np.full(len(frame), True) if eye == "both" else frame["eye"] == ("blue", "green").index(eye)
    assert np.array_equal(lie >= 0, asked)  # the typical eyes see nothing beyond the view
    order = np.lexsort((np.arange(len(frame)), rank(frame, returns)))[::-1]
    expected = np.full(rows * columns, -1)
    order = order[lie[order] >= 0]
    expected[lie[order]] = order  # the last one that is written stays
    assert np.array_equal(index.ravel(), expected)
    filled = index.ravel() >= 0
    assert np.array_equal(lie[index.ravel()[filled]], np.flatnonzero(filled))
    ranges = frame.image("range", eye, returns, **size)
    assert np.array_equal(ranges.ravel()[filled], frame["range"][index.ravel()[filled]]) and np.isnan(ranges.ravel()[~filled]).all()


def test_a_mask_selects_points(frames):
    frame = frames[0]
    near = np.nan_to_num(frame.image("range"), nan=np.inf) < 10
    shown = frame.image_index()[near]
    assert (frame["range"][shown] < 10).all() and len(shown) == near.sum()
    pixels = frame.image_pixels()
    there = (pixels >= 0) & near.ravel()[pixels]
    assert there.sum() > len(shown) and there[shown].all()


def test_sizes(frames, make_capture):
    frame = frames[0]
    assert frame.image("range").shape == (64, 1600) and frame.image("range", "blue").shape == (64, 800)
    assert frame.image("xyz", "green", rows=32, columns=100).shape == (32, 100, 3)
    (dense,) = lumsdk.open(make_capture("-n", 1, "--lines", 640))
    image = dense.image("pixel")
    assert image.shape == (640, 1600) and image.dtype == np.float32
    assert np.isfinite(image[300:]).mean() > 0.98  # what is below the horizon returns


@pytest.mark.parametrize("pickled", [False, True])
def test_a_grid_of_xyz(frames, pickled):
    frame = frames[pickled]
    grid = frame.grid("xyz", "blue")
    assert grid.shape == (64, 1000, 3)
    assert frame.grid("xyz", "blue", returns=2).shape == (64, 1000, 2, 3)
    for i, name in enumerate("xyz"):
        assert np.array_equal(grid[..., i], frame.grid(name, "blue"), equal_nan=True)


def steps(image, axis):
    """Where the ranges of each row, or of each column, step most."""
    return np.argmax(np.nan_to_num(np.abs(np.diff(image, axis=axis))), axis=axis)


def test_upright_and_level_edges_are_straight(room):
    """A cupboard stands before the wall on the left: its edge is one column of the picture. In raw lines, it is at a place
    and at that place from the other end, in turn."""
    image = room.image("range")
    beside = steps(image[20:, :400], axis=1)
    assert np.ptp(beside) <= 1 and 200 < beside[0] < 399
    above = steps(image[:30, 400:500], axis=0)
    assert (np.abs(above - np.median(above)) <= 1).mean() > 0.9  # where nothing else steps more
    azimuth = np.degrees(np.arctan2(room["y"], room["x"]))
    edge = np.abs(azimuth - (60 - (beside[0] + 1) * 120 / 1600)) < 0.1
    lines, pixels = room["line"][edge], room["pixel"][edge].astype(int)
    there, back = pixels[lines % 2 == 0], pixels[lines % 2 == 1]
    assert np.ptp(there) < 10 and np.ptp(back) < 10 and abs(there.mean() + back.mean() - 999) < 5
    assert abs(there.mean() - back.mean()) > 100


def test_points_outside_are_told(frames):
    with pytest.warns(lumsdk.CaptureWarning, match=r"frame \d+: \d+ of \d+ points lie outside of the picture, which shows azimuths from 10 to"):
        image = frames[0].image("range", view=(10, -10, 3, -17))
    assert np.isfinite(image).any()


@pytest.mark.parametrize("arguments, said", [
    ({"eye": "red"}, 'eye is \'red\'; use "blue", "green", "both"'),
    ({"returns": "second"}, 'returns is \'second\'; use "nearest"'),
    ({"rows": 0}, "rows is 0; use a whole number from 1"),
    ({"columns": 1.5}, "columns is 1.5; use a whole number"),
    ({"view": (1, 2, 3)}, "use four numbers in degrees: left, right, top, bottom"),
    ({"view": (-60, 60, 3, -17)}, "the view of -60, 60, 3, -17 degrees in 64 rows and 1600 columns is impossible"),
    ({"rows": 1 << 20, "columns": 1 << 20}, "at most 268435456 pixels"),
])
def test_what_cannot_be_is_refused(frames, arguments, said):
    with pytest.raises(ValueError) as refused:
        frames[0].image("range", **arguments)
    assert said in str(refused.value)


def test_a_column_that_is_missing_is_named(make_capture):
    (frame,) = lumsdk.open(make_capture("-n", 1), columns="x,y,range")
    with pytest.raises(lumsdk.UnknownKeyError, match="has no column 'z'"):
        frame.image("range")
    with pytest.raises(lumsdk.UnknownKeyError, match="no column 'colour'"):
        frame.image("colour")


def test_a_frame_without_points_is_an_empty_picture(make_capture):
    (frame,) = lumsdk.open(make_capture("-n", 1), range="900:901")
    for one in (frame, pickle.loads(pickle.dumps(frame))):
        assert np.isnan(one.image("range")).all() and (one.image_index("blue", "strongest") == -1).all()
