"""lumsdk.sync(): frames that belong together, of made-up sensors."""
import math
import pickle
import re
import warnings

import lumsdk
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lumsdk._build import restore
from lumsdk._lines import LINE_DTYPE

PERIOD_NS = 100_000_000
BEGIN_NS = 1_800_000_000 * 10 ** 9

LOSSES = {name: 0 for name in ("lost_words", "lines_missing_angles", "lines_missing", "lines_in_pauses", "lines_cut", "lines_late",
                               "points_cut", "no_angle", "no_range")}


def frame(name, number, at_ns, *, period_ns=PERIOD_NS, has_clock=True, member=0, points=3, first=False, columns="xyz"):
    """A frame of a sensor that began at a time."""
    utc_ns = BEGIN_NS + at_ns
    clock_us = 5_000_000 + at_ns // 1000
    lines = np.zeros(1, LINE_DTYPE)
    lines["point_count"], lines["clock_us"] = points, clock_us
    info = {"number": number, "sensor": 1, "is_complete": True, "is_first": first, "is_last": False, "begin_clock_us": clock_us,
            "end_clock_us": clock_us + period_ns // 1000, "begin_arrival_ns": utc_ns, "end_arrival_ns": utc_ns + period_ns,
            "begin_utc_ns": utc_ns if has_clock else 0, "utc_error_ns": 1000, "has_pause": False, "interface": "",
            "lines": (1, 0), "rows": (1, 0), "losses": LOSSES, "member": member, "name": name,
            "pose": tuple(map(tuple, np.eye(4).tolist())) if member else None}
    arrays = {column: np.full(points, number + i, "f4") for i, column in enumerate(columns)}
    arrays["time"] = np.linspace(0, 0.09, points, dtype="f4")
    return restore(info, arrays, lines)


def stream(**sensors):
    """Frames of several sensors, (times, period) each, in the order in which they end."""
    made = [(at + period, place, frame(name, number, at, period_ns=period))
            for place, (name, (times, period)) in enumerate(sensors.items()) for number, at in times]
    return [entry[2] for entry in sorted(made, key=lambda entry: entry[:2])]


def free(phase, count=12, period=PERIOD_NS, lost=()):
    """The times of a sensor that runs freely."""
    return [(i, round(phase * PERIOD_NS) + i * period) for i in range(count) if i not in lost], period


def numbers(sets):
    return [{name: one.number for name, one in made.items()} for made in sets]


def test_sensors_of_one_rate_make_complete_sets():
    sets = list(lumsdk.sync(stream(a=free(0), b=free(0.3), c=free(0.45))))
    assert all(made.complete for made in sets)
    assert numbers(sets) == [{"a": i, "b": i, "c": i} for i in range(12)]
    assert all(math.isclose(made.spread, 0.045) for made in sets)
    assert [made.utc_ns for made in sets] == [BEGIN_NS + i * PERIOD_NS for i in range(12)]


def test_a_set_ends_where_nothing_begins_for_long():
    """Not where the first frame of the stream happens to lie."""
    sets = list(lumsdk.sync(stream(a=free(0.9), b=free(0))))
    assert numbers(sets) == [{"b": 0}, *({"a": i, "b": i + 1} for i in range(11)), {"a": 11}]
    assert sets[0].missing == {"a": "no frame of it begins within 0.100 s that is not in another set"}
    assert sets[-1].missing == {"b": "the stream ended; its last frame, 11, began 0.090 s before"} or sets[-1].missing


@pytest.mark.parametrize("lost", ["a", "b", "c"])
def test_a_frame_that_did_not_come_is_named_and_moves_nothing(lost):
    """Also where the frames of a set are two thirds of a period apart, as those of three sensors can be."""
    sensors = {"a": 0.0, "b": 0.31, "c": 0.62}
    sets = list(lumsdk.sync(stream(**{name: free(phase, lost=(5,) if name == lost else ()) for name, phase in sensors.items()})))
    assert numbers(sets) == [{name: i for name in sensors if (name, i) != (lost, 5)} for i in range(12)]
    assert sets[5].missing == {lost: "its frame 5 did not come"}
    assert all(made.complete for i, made in enumerate(sets) if i != 5)


def test_frames_of_several_rates():
    """Every second frame of the faster one is alone, and says so."""
    sets = list(lumsdk.sync(stream(slow=free(0, 6), fast=free(0.1, 12, PERIOD_NS // 2))))
    assert numbers(sets) == [made for i in range(6) for made in ({"slow": i, "fast": 2 * i}, {"fast": 2 * i + 1})]
    assert sets[1].missing == {"slow": "no frame of it begins within 0.050 s that is not in another set"}


def test_a_sensor_that_stops_is_missed_and_comes_back():
    stopped = [(i, at) for i, at in free(0.2, 60)[0] if not 10 <= i < 40]
    source, given_ = stream(a=free(0, 60), b=(stopped, PERIOD_NS)), 0

    def count():
        nonlocal given_
        for one in source:
            given_ += 1
            yield one

    sets, most, got = [], 0, 0
    for made in lumsdk.sync(count()):
        sets.append(made)
        got += len(made)
        most = max(most, given_ - got)
    assert most < 20
    assert got == len(source)
    assert [i for i, made in enumerate(sets) if not made.complete] == list(range(10, 40))
    assert sets[20].missing["b"] == "no later frame of it has come; its last frame, 9, began 1.080 s before"


def test_a_frame_that_comes_late_is_a_set_that_says_so():
    """The last one of a sensor that stops ends when the stream does."""
    source = sorted([*stream(a=free(0, 16)), *stream(b=free(0, 4))], key=lambda one: one.utc_ns) + [frame("b", 4, 4 * PERIOD_NS)]
    [late] = [made for made in lumsdk.sync(source) if numbers([made]) == [{"b": 4}]]
    assert late.missing == {"a": "the set came late, after the sets of its time"}


def test_a_clock_that_goes_back_is_told_by_its_times():
    """Of the frames of one sensor from number 8 on, by 3 s."""
    source = [frame(name, i, i * PERIOD_NS - (30 * PERIOD_NS if name == "b" and i >= 8 else 0)) for i in range(20) for name in "ab"]
    sets = list(lumsdk.sync(source))
    assert sorted((name, one.number) for made in sets for name, one in made.items()) == [(n, i) for n in "ab" for i in range(20)]
    assert [made["b"].number for made in sets if made.complete] == list(range(8))
    [missing] = [made.missing for made in sets if numbers([made]) == [{"a": 12}]]
    assert re.fullmatch(r"no later frame of it has come; its last frame, \d+, began (2\.[6-9]|3\.\d)00 s before", missing["b"]), missing


def test_a_sensor_that_never_comes_is_missed():
    sets = list(lumsdk.sync(stream(a=free(0), b=free(0.1)), sensors=["a", "b", "c"]))
    assert numbers(sets) == [{"a": i, "b": i} for i in range(12)]
    assert sets[0].missing == {"c": "no frame of it has come yet"}
    assert sets[-1].missing == {"c": "no frame of it came"}


def test_the_end_is_told():
    sets = list(lumsdk.sync(stream(a=free(0), b=free(0.1, 11))))
    assert numbers(sets)[-1] == {"a": 11}
    assert sets[-1].missing == {"b": "the stream ended; its last frame, 10, began 0.090 s before"}


def test_the_tolerance_parts():
    sets = list(lumsdk.sync(stream(a=free(0), b=free(0.3)), tolerance=0.02))
    assert all(len(made) == 1 for made in sets)
    assert "within 0.020 s" in sets[0].missing["b"]
    together = list(lumsdk.sync(stream(a=free(0), b=free(0)), tolerance=0))
    assert all(made.complete and made.spread == 0 for made in together)


def test_arrival_in_place_of_a_clock_is_told():
    with pytest.warns(lumsdk.CaptureWarning, match="frames of a have no clock"):
        [made, _] = lumsdk.sync([frame("a", 0, 0, has_clock=False), frame("b", 0, 10), frame("a", 1, PERIOD_NS, has_clock=False)])
    assert made.utc_error_ns is None


def test_two_sensors_of_one_name_are_told():
    with pytest.warns(lumsdk.CaptureWarning, match="frames of two sensors have the name a, .* use different names") as said:
        list(lumsdk.sync(stream(a=free(0)) + stream(b=free(0.2))))  # of b alone, as in a second capture
        list(lumsdk.sync(sorted(stream(a=free(0)) + stream(a=free(0.2)), key=lambda one: one.utc_ns)))
    assert len(said) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a sensor that boots again
        list(lumsdk.sync(stream(a=free(0)) + stream(a=free(20))))


def test_a_set_is_a_mapping():
    [made] = lumsdk.sync([frame("a", 0, 0), frame("b", 3, 1000)], 1, ["a", "b", "c"])
    assert list(made) == ["a", "b"] and len(made) == 2 and "c" not in made
    assert made["b"].number == 3 and made.utc_error_ns == 1000
    assert repr(made) == "<FrameSet a 0, b 3; missing: c; 0.0 ms apart>"
    with pytest.raises(lumsdk.UnknownKeyError, match="no frame of c: no frame of it came"):
        made["c"]
    with pytest.raises(lumsdk.UnknownKeyError, match="'d'; it has a, b"):
        made["d"]
    again = pickle.loads(pickle.dumps(made))
    assert again == made and again.missing == made.missing


@pytest.mark.parametrize(("arguments", "kind", "said"), [
    (([], "1"), TypeError, "tolerance is '1'"), (([], -1), lumsdk.OptionError, "tolerance is -1"),
    (([], float("nan")), lumsdk.OptionError, "tolerance is nan"), (([], 1, "front"), TypeError, "use a list of names"),
    (([], 1, 5), TypeError, "sensors is 5; use a list"), (([], 1, [5]), TypeError, "use a list of names"),
    ((3,), TypeError, "a source is given as int"), ((["drive.pcap"],), TypeError, "gives str and not frames")])
def test_what_is_wrong_is_told(arguments, kind, said):
    with pytest.raises(kind, match=said):
        list(lumsdk.sync(*arguments))


# --- Joined ---


def test_joined_has_all_points_on_one_clock():
    a, b = frame("a", 4, 10_000_000, member=2, points=4), frame("b", 9, 0, member=1, points=3)
    [made] = lumsdk.sync([a, b], 0.05, ["b", "a"])
    joined = made.joined()
    assert len(joined) == 7 and joined.utc_ns == made.utc_ns == b.utc_ns and joined.sensor == "b+a"
    assert joined["sensor"].dtype == np.uint8 and joined["sensor"].tolist() == [0] * 3 + [1] * 4
    for name in "xyz":
        assert np.array_equal(joined[name], np.concatenate([b[name], a[name]]))
    moments = np.concatenate([one.utc_ns + (one["time"].astype("f8") * 1e9).astype("i8") for one in (b, a)])
    assert np.abs(joined.utc_ns + (joined["time"].astype("f8") * 1e9).astype("i8") - moments).max() < 100
    assert joined.lines["first_point"].tolist() == [0, 3] and joined.lines["point_count"].tolist() == [3, 4]
    assert joined.lines["clock_us"].tolist() == [5_000_000, 5_010_000]
    assert joined.complete and math.isclose(joined.duration, 0.11)
    assert pickle.loads(pickle.dumps(joined)) == joined
    assert joined.pose is None and joined.image("x", view=(180, -180, 90, -90)).shape == (64, 1600)
    with pytest.raises(lumsdk.OptionError, match=r"several sensors, b\+a, whose lines have the same numbers"):
        joined.grid("x")
    assert set(made.joined("x,y,z").columns) >= {"x", "y", "z"} and "time" not in made.joined("x,y,z")
    with pytest.raises(lumsdk.UnknownKeyError, match="range"):
        made.joined(["x", "y", "z", "range"])


def test_frames_without_a_rig_are_not_joined():
    [made] = lumsdk.sync([frame("a", 0, 0), frame("b", 0, 0)], 0.05)
    with pytest.raises(lumsdk.OptionError, match=r"a are in its own frame.*rig="):
        made.joined()


def test_a_column_that_not_all_frames_have_is_told():
    one, other = frame("a", 0, 0, member=1), frame("b", 0, 0, member=2)
    [made] = lumsdk.sync([one.with_columns(label=np.arange(3)), other], 0.05)
    with pytest.warns(lumsdk.CaptureWarning, match="that all of them have, without label, which b has not"):
        assert "label" not in made.joined()
    assert made.time == one.time


def test_frames_that_were_moved_to_other_moments_are_not_joined():
    times = BEGIN_NS + np.arange(-2, 3) * PERIOD_NS
    poses = np.tile(np.eye(4), (5, 1, 1))
    poses[:, 0, 3] = np.arange(5.0)
    moving = lumsdk.Poses(times, poses)
    for to in "start", "middle":
        frames = [frame("a", 0, 0, member=1), frame("b", 0, 30_000_000, member=2)]
        [made] = lumsdk.sync([one.deskew(moving, to) for one in frames], 0.05)
        with pytest.raises(lumsdk.OptionError, match=rf"its {to}, and these are 30.0 ms apart: .*frames.joined\(\).deskew"):
            made.joined()
    [made] = lumsdk.sync(frames, 0.05)
    right, world = made.joined().deskew(moving), made.joined().to_world(moving)
    assert np.abs(world["x"] - right["x"] - 2).max() < 1e-5 and np.ptp(world["x"] - made.joined()["x"]) > 0.5
    [near] = lumsdk.sync([one.deskew(moving) for one in (frames[0], frame("b", 0, 50_000, member=2))], 0.05)
    assert len(near.joined()) == 6


def test_a_set_where_frames_are_taken_says_what_is_right(tmp_path):
    [made] = lumsdk.sync([frame("a", 0, 0, member=1), frame("b", 0, 0, member=2)], 0.05)
    for call in (lambda: lumsdk.convert(made, tmp_path / "a.npy"), lambda: lumsdk.convert([made], tmp_path / "a.npy"),
                 lambda: lumsdk.convert(iter([made]), tmp_path / "a.npy"), lambda: lumsdk.write_capture(tmp_path / "a.pcap", made),
                 lambda: lumsdk.write_capture(tmp_path / "a.pcap", [made]), lambda: list(lumsdk.sync([made]))):
        with pytest.raises(TypeError, match=r"frames.joined\(\), one frame of all its points, or frames.values\(\)"):
            call()
    for source in "drive.pcapng", tmp_path:
        with pytest.raises(TypeError, match=r"use a Source: lumsdk.sync\(lumsdk.open\("):
            lumsdk.sync(source)
    assert not list(tmp_path.iterdir())


def test_joined_frames_were_moved_to_the_same_place():
    frames = [frame("a", 0, 0, member=1), frame("b", 0, 0, member=2)]
    times = BEGIN_NS + np.arange(-2, 3) * PERIOD_NS
    frames[0] = frames[0].to_world(lumsdk.Poses(times, np.tile(np.eye(4), (5, 1, 1))))
    [made] = lumsdk.sync(frames, 0.05)
    with pytest.raises(lumsdk.OptionError, match="some frames of the set were moved"):
        made.joined()


# --- By properties ---


@st.composite
def streams(draw):
    """Frames of some sensors: rates, phases, jitter, losses, stops; in the order in which they end."""
    made = []
    for place in range(draw(st.integers(1, 5))):
        period = draw(st.sampled_from([PERIOD_NS, PERIOD_NS, PERIOD_NS, PERIOD_NS // 2, PERIOD_NS * 3]))
        phase, jitter = draw(st.integers(0, period)), draw(st.sampled_from([0, 1000, period // 20]))
        count = draw(st.integers(0, 30))
        lost = draw(st.sets(st.integers(0, 30), max_size=6))
        stop = draw(st.integers(0, 30))
        back = stop + draw(st.sampled_from([0, 0, 2, 12]))
        random = draw(st.randoms(use_true_random=False))
        for i in range(count):
            if i in lost or stop <= i < back:
                continue
            at = phase + i * period + random.randint(0, jitter)
            made.append((at + period, place, frame(f"s{place}", i, at, period_ns=period, points=0)))
    return [entry[2] for entry in sorted(made, key=lambda entry: entry[:2])]


@settings(max_examples=100)
@given(streams(), st.sampled_from([None, 0, 0.001, 0.05, 0.1, 0.5]))
def test_every_frame_is_in_one_set_and_what_is_missing_is_named(frames, tolerance):
    names = sorted({one.sensor for one in frames} | {"absent"})
    sets = list(lumsdk.sync(iter(frames), tolerance, names))
    given_ = sorted((one.sensor, one.number) for one in frames)
    assert sorted((name, one.number) for made in sets for name, one in made.items()) == given_
    most = tolerance if tolerance is not None else max([one.duration for one in frames], default=0) * 1.06
    for made in sets:
        assert all(one.sensor == name for name, one in made.items())
        assert made.spread <= most + 1e-12
        assert list(made) == [name for name in names if name in made]
        assert sorted([*made, *made.missing]) == names and all(made.missing.values())
        assert made.complete == (not made.missing)


@settings(max_examples=60)
@given(st.lists(st.floats(0, 0.999), min_size=2, max_size=8), st.data())
def test_at_one_rate_all_sets_are_complete_but_for_what_is_named(phases, data):
    """Whatever the phases are: behind the first period, and before the last one."""
    lost = {place: data.draw(st.sets(st.integers(5, 25), max_size=2)) if place else set() for place in range(len(phases))}
    frames = stream(**{f"s{place}": free(phase, 30, lost=lost[place]) for place, phase in enumerate(phases)})
    sets = list(lumsdk.sync(frames))
    named = {(name, int(why.split()[2])) for made in sets for name, why in made.missing.items() if why.endswith("did not come")}
    assert named == {(f"s{place}", number) for place, those in lost.items() for number in those}
    for made in sets:
        if 4 * PERIOD_NS < made.utc_ns - BEGIN_NS < 25 * PERIOD_NS:
            assert all(why.endswith("did not come") for why in made.missing.values()), numbers(sets)


@settings(max_examples=15)
@given(st.lists(st.floats(0, 0.999), min_size=2, max_size=3), st.sampled_from([1e-6, 3e-4]))
def test_rates_that_differ_a_little_leave_a_frame_alone_now_and_then(phases, error):
    """Only as often as a whole period has been made up."""
    count = 400
    frames = stream(**{f"s{place}": free(phase, count, round(PERIOD_NS * (1 + place * error))) for place, phase in enumerate(phases)})
    sets = list(lumsdk.sync(frames, sensors=[f"s{place}" for place in range(len(phases))]))
    parted = sum(not made.complete for made in sets)
    assert parted <= 2 * len(phases) + math.ceil(count * error * len(phases)) * 2 * len(phases)


def test_a_stream_that_stands_still_ends_nothing_and_keeps_little():
    """Clocks that all say the same: no period is ever known."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sets = list(lumsdk.sync([frame("a", i, 0) for i in range(300)]))
    assert [len(made) for made in sets] == [1] * 300
