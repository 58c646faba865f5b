"""open(): each kind of source gives the same frames."""
import pickle

import lumsdk
import pytest


def test_gives_the_same_frames_for_every_kind_of_source(capture):
    frames = list(lumsdk.open(capture))
    assert len(frames) == 10
    content = capture.read_bytes()
    assert list(lumsdk.open(content)) == frames
    assert list(lumsdk.open(str(capture)[:-1] + "?")) == frames
    assert list(lumsdk.open([capture])) == frames
    with open(capture, "rb") as file:
        assert list(lumsdk.open(file)) == frames
    assert pickle.loads(pickle.dumps(frames[0])) == frames[0]


def test_refuses_an_option_that_is_not_known(capture):
    with pytest.raises(TypeError, match="did you mean edge"):
        lumsdk.open(capture, edges="rising")
