"""Selections give the points that NumPy picks from all of them."""
import lumsdk
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

EYES = ("blue", "green")


@pytest.fixture(scope="module")
def content(make_capture):
    return make_capture("-n", 2, "--loss", 0.3, "--seed", 21).read_bytes()


@pytest.fixture(scope="module")
def whole(content):
    return list(lumsdk.open(content, columns="all", edge="both"))


def limits(low, high):
    """(MIN, MAX), each of which may be missing."""
    ends = st.one_of(st.none(), st.floats(low, high, width=32))
    return st.tuples(ends, ends).map(lambda pair: pair if None in pair else tuple(sorted(pair)))


def is_within(values, pair):
    low, high = (np.float32(end if end is not None else rest) for end, rest in zip(pair, (-np.inf, np.inf)))
    return (values >= low) & (values <= high)


def picks(frame, options):
    """Which of all points an option leaves, by NumPy."""
    kept = np.ones(len(frame), bool)
    returns, edge, eye = options.get("returns", "all"), options.get("edge", "rising"), options.get("eye", "both")
    if returns == "strongest":
        kept &= frame["strongest"] == 1
    elif returns == "last":
        kept &= frame["return_number"] == frame["number_of_returns"]
    elif returns != "all":
        kept &= frame["return_number"] == (1 if returns == "first" else returns)
    if edge != "both":
        kept &= frame["edge"] == (edge == "rising")
    if eye != "both":
        kept &= frame["eye"] == EYES.index(eye)
    if "range" in options:
        kept &= is_within(frame["range"], options["range"])
    for axis, pair in zip("xyz", options.get("box", ())):
        kept &= is_within(frame[axis], pair)
    return kept


@given(st.fixed_dictionaries({}, optional={
    "returns": st.one_of(st.sampled_from(["all", "first", "last", "strongest"]), st.integers(1, 5)),
    "edge": st.sampled_from(["rising", "falling", "both"]), "eye": st.sampled_from(["blue", "green", "both"]),
    "range": limits(0, 250), "box": st.tuples(limits(-10, 200), limits(-60, 60), limits(-5, 20))}))
@settings(max_examples=40)
@pytest.mark.filterwarnings("ignore::lumsdk.CaptureWarning")
def test_a_selection_is_what_numpy_picks(content, whole, options):
    got = list(lumsdk.open(content, columns="all", **options))
    assert len(got) == len(whole)
    for chosen, frame in zip(got, whole):
        kept = picks(frame, options)
        for name in frame.columns:
            assert chosen[name].tobytes() == frame[name][kept].tobytes(), name


@given(st.sets(st.sampled_from(list(lumsdk.COLUMNS))))
@settings(max_examples=20)
def test_columns_do_not_depend_on_each_other(content, whole, names):
    for chosen, frame in zip(lumsdk.open(content, columns=names, edge="both"), whole):
        assert set(chosen.columns) == names and len(chosen) == (len(frame) if names else 0)
        for name in names:
            assert chosen[name].tobytes() == frame[name].tobytes()
