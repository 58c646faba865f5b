"""Options: lumdump's, by its names; what it refuses is refused, and told."""
import subprocess

import lumsdk
import numpy as np
import pytest
from conftest import BIN
from hypothesis import given, settings
from hypothesis import strategies as st


@pytest.fixture(scope="module")
def content(make_capture):
    """A small capture with losses, in memory."""
    return make_capture("-n", 3, "--loss", 0.02, "--seed", 3, "--returns-max", 3).read_bytes()


def numbers(content, **options):
    return [frame.number for frame in lumsdk.open(content, **options)]


def test_frames_are_chosen_by_number(content):
    assert numbers(content) == [1, 2, 3]
    for frames in ["2:3", "2:", (2, 3), (2, None), [2, 3], range(2, 4), ("2", 3), (np.int64(2), 3)]:
        assert numbers(content, frames=frames) == [2, 3], frames
    assert numbers(content, frames=2) == numbers(content, frames="2:2") == [2]
    assert numbers(content, frames=":2") == [1, 2]
    assert numbers(content, frames=None) == [1, 2, 3]


def test_limits_are_texts_or_pairs(content):
    for limits in ["2:80", (2, 80), [2, 80.0], ("2", "8e1")]:
        (first, *_) = lumsdk.open(content, range=limits)
        assert 2 <= first["range"].min() and first["range"].max() <= 80
    (boxed, *_) = lumsdk.open(content, box="0:50,-10:10,:4")
    assert boxed == next(iter(lumsdk.open(content, box=((0, 50), (-10, 10), (None, 4)))))
    assert len(boxed) and (boxed.xyz <= [50, 10, 4]).all() and (boxed.xyz[:, :2] >= [0, -10]).all()


def test_columns_are_names(content):
    assert next(iter(lumsdk.open(content))).columns == ("x", "y", "z", "range", "pulse_width", "line", "pixel", "eye")
    assert next(iter(lumsdk.open(content, columns="all"))).columns == tuple(lumsdk.COLUMNS)
    for columns in ["z,x", ["z", "x"], iter(["x", "z"])]:
        assert next(iter(lumsdk.open(content, columns=columns))).columns == ("x", "z")
    empty = next(iter(lumsdk.open(content, columns=[])))
    assert empty.columns == () and len(empty.lines) == 128


WRONG = [
    ({"edges": "rising"}, TypeError, "there is no option edges; did you mean edge?"),
    ({"zoom": 1}, TypeError, "there is no option zoom; there are columns, returns"),
    ({"returns": "best"}, lumsdk.OptionError, 'returns is \'best\'; use "all", "first"'),
    ({"returns": 0}, lumsdk.OptionError, "or a number from 1"),
    ({"returns": 70000}, lumsdk.OptionError, "or a number from 1"),
    ({"returns": 1.5}, TypeError, "of type float"),
    ({"returns": True}, TypeError, "of type bool"),
    ({"edge": "up"}, lumsdk.OptionError, 'use "rising", "falling" or "both"'),
    ({"eye": 1}, TypeError, 'use "blue", "green" or "both"'),
    ({"port": 0}, lumsdk.OptionError, "a number from 1 to 65535"),
    ({"port": 65536}, lumsdk.OptionError, "a number from 1 to 65535"),
    ({"port": 5.5}, TypeError, "a number from 1 to 65535"),
    ({"sensor": "10.42.0"}, lumsdk.OptionError, 'an address such as "10.42.0.37"'),
    ({"sensor": "10.42.0.256"}, lumsdk.OptionError, "an address"),
    ({"sensor": 7}, TypeError, "an address"),
    ({"frames": "7"}, lumsdk.OptionError, "FIRST:LAST"),
    ({"frames": "3:2"}, lumsdk.OptionError, "FIRST:LAST"),
    ({"frames": (1, 2, 3)}, lumsdk.OptionError, "FIRST:LAST"),
    ({"frames": 1.0}, TypeError, "of type float"),
    ({"frames": "1:99999999999999999999"}, lumsdk.OptionError, "FIRST:LAST"),
    ({"frames": range(1, 9, 2)}, lumsdk.OptionError, "FIRST:LAST"),
    ({"range": "80"}, lumsdk.OptionError, "MIN:MAX"),
    ({"range": (80, 2)}, lumsdk.OptionError, "MIN:MAX"),
    ({"range": (float("nan"), 2)}, lumsdk.OptionError, "MIN:MAX"),
    ({"range": 80}, TypeError, "MIN:MAX"),
    ({"range": ("a", 2)}, lumsdk.OptionError, "MIN:MAX"),
    ({"range": (2e6, None)}, lumsdk.OptionError, "MIN:MAX"),
    ({"box": "0:1,0:1"}, lumsdk.OptionError, "XMIN:XMAX"),
    ({"box": 5}, TypeError, "XMIN:XMAX"),
    ({"box": (1, 2, 3)}, TypeError, "XMIN:XMAX"),
    ({"incomplete": "no"}, lumsdk.OptionError, '"keep" or "drop"'),
    ({"smooth": 4}, lumsdk.OptionError, "an odd number of pixels up to 63"),
    ({"smooth": "31:31"}, lumsdk.OptionError, "an odd number"),
    ({"smooth": 2 ** 40}, lumsdk.OptionError, "an odd number"),
    ({"smooth": (31, 2, 1)}, lumsdk.OptionError, "an odd number"),
    ({"smooth": "x"}, lumsdk.OptionError, "an odd number"),
    ({"columns": ["rnge"]}, lumsdk.OptionError, "unknown column 'rnge'; did you mean 'range'?"),
    ({"columns": [1]}, TypeError, "names of x, y, z"),
    ({"columns": 1}, TypeError, "names of x, y, z"),
    ({"broken": "stop"}, lumsdk.OptionError, '"raise" or "warn"'),
    ({"threads": 0}, lumsdk.OptionError, "a number from 1 to 64"),
    ({"threads": 65}, lumsdk.OptionError, "a number from 1 to 64"),
    ({"threads": "many"}, lumsdk.OptionError, "a number from 1 to 64"),
    ({"threads": 1.5}, TypeError, "a number from 1 to 64"),
    ({"progress": 1}, TypeError, "a function of two numbers"),
    ({"calibration": 3}, TypeError, "a calibration is a path"),
    ({"calibration": "none.yaml"}, lumsdk.OptionError, "none.yaml: cannot be read: No such file"),
    ({"profile": {"group": {"lne": 1}}}, lumsdk.OptionError, "did you mean 'line'?"),
    ({"set": {"group.lne.at": 1}}, lumsdk.OptionError, "did you mean 'group.line.at'?"),
    ({"set": {"version": 1}}, lumsdk.OptionError, "version is a key of files only"),
    ({"set": ["group.line.at"]}, lumsdk.OptionError, "KEY=VALUE"),
    ({"set": 5}, TypeError, "KEY=VALUE"),
    ({"set": [5]}, TypeError, "KEY=VALUE"),
    ({"set": "tof_lsb_ps=-1"}, lumsdk.OptionError, "set: tof_lsb_ps: '-1' is out of range; allowed: above 0"),
]


@pytest.mark.parametrize("options, kind, said", WRONG, ids=lambda value: str(value)[:40])
def test_what_is_wrong_is_told(content, options, kind, said):
    with pytest.raises(kind) as caught:
        lumsdk.open(content, **options)
    assert said in str(caught.value)


def test_a_key_is_set_on_top(content):
    with lumsdk.open(content, calibration={"tof_lsb_ps": 12}, set=["eyes.blue.mount.x_m=1", "line_span_us=900"]) as source:
        assert source.calibration["tof_lsb_ps"] == 12 and source.calibration["eyes.blue.mount.x_m"] == 1
        assert source.profile["line_span_us"] == 900


def test_a_generator_is_as_good_as_a_list(content):
    keys = ["eyes.blue.mount.x_m=1.5", "eyes.green.mount.x_m=2.5"]
    with lumsdk.open(content, set=(key for key in keys), columns=(name for name in ("x", "range"))) as source:
        assert source.calibration == lumsdk.open(content, set=keys).calibration
        assert next(iter(source)).columns == ("x", "range")


TEXTS = {"frames": st.one_of(st.just("1:2"), st.text("0123:- +", max_size=6)),
         "range": st.text("0123.e-+:", max_size=8), "return": st.text("0129alst+-", max_size=5),
         "smooth": st.text("0123579:-", max_size=5), "box": st.text("01:,-.", max_size=12)}


@given(st.sampled_from(sorted(TEXTS)).flatmap(lambda name: st.tuples(st.just(name), TEXTS[name])))
@settings(max_examples=60)
def test_a_text_is_right_where_lumdump_takes_it(make_capture, named):
    name, text = named
    capture = make_capture("-n", 1, "--loss", 0.99)
    done = subprocess.run([BIN / "lumdump", capture, f"--{name}={text}", "--json", "-q"], capture_output=True,
                          check=False)
    try:
        lumsdk.open(capture, **{"returns" if name == "return" else name: text})
        taken = True
    except lumsdk.OptionError:
        taken = False
    assert taken == (done.returncode != 2), done.stderr
