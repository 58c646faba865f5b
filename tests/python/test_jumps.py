"""Frames by their place and by time: the same as in an iteration, in every column and clock."""
import datetime
import gzip
import io
import itertools
import operator
import subprocess
import sys

import lumsdk
import numpy as np
import pytest
from conftest import BIN
from hypothesis import given, settings
from hypothesis import strategies as st

COUNT = 12


@pytest.fixture(scope="module")
def path(make_capture):
    """Many frames with few points, losses and a first frame that lacks its start."""
    return make_capture("-n", COUNT, "--loss", 0.6, "--returns-max", 2, "--reorder", 0.05, "--batch", 4, "--drift", 30, "--seed", 13)


@pytest.fixture(scope="module")
def frames(path):
    return list(lumsdk.open(path, columns="all"))


@pytest.fixture(scope="module")
def source(path):
    """One that is used by many."""
    with lumsdk.open(path, columns="all") as opened:
        yield opened


def test_joined_datagrams_are_those_that_were_sent(make_capture):
    alone, joined = (lumsdk.open(make_capture("-n", 6, "--loss", 0.02, "--reorder", 0.02, *extra)) for extra in ((), ("--joined",)))
    frames = list(joined)
    assert [frame.xyz.tobytes() for frame in frames] == [frame.xyz.tobytes() for frame in alone]
    assert alone.counts["joined"] == 0 and joined.counts["joined"] > joined.counts["data"] // 2
    assert {**joined.counts, "joined": 0} == alone.counts
    joined.index()
    for place in 4, 1, 5, 0, 3, 2:
        assert joined[place] == frames[place]


bounds = st.one_of(st.none(), st.integers(-COUNT - 4, COUNT + 4))
checks = settings(max_examples=25)


@given(st.lists(st.integers(-COUNT - 2, COUNT + 1), min_size=1, max_size=4))
@checks
def test_a_frame_of_a_place_is_that_of_the_iteration(source, frames, places):
    assert len(frames) == COUNT
    for place in places:
        if -COUNT <= place < COUNT:
            assert source[place] == frames[place]
        else:
            with pytest.raises(IndexError, match=f"there is no frame {place}: it has {COUNT}"):
                source[place]


@given(bounds, bounds, st.one_of(st.none(), st.integers(-5, 5).filter(bool)))
@checks
def test_a_slice_is_that_of_a_list(source, frames, start, stop, step):
    part = source[start:stop:step]
    want = frames[start:stop:step]
    assert list(part) == want and len(part) == len(want)
    assert [frame.number for frame in part[::-2]] == [frame.number for frame in want[::-2]]
    if want:
        assert part[-1] == want[-1] and part[0] == want[0] and want[0] in part


@given(st.integers(-10 ** 8, 14 * 10 ** 8))
@checks
def test_a_time_is_sought(source, frames, after_ns):
    moment = frames[0].utc_ns + after_ns
    want = next((i for i, frame in enumerate(frames) if frame.utc_ns >= moment), COUNT)
    assert list(itertools.islice(source.seek(moment), 3)) == frames[want:want + 3]


def test_a_time_is_a_datetime_or_seconds_from_the_start(source, frames):
    third = frames[3]
    for time in [third.time, third.time.astimezone(datetime.timezone(datetime.timedelta(hours=2))), third.utc_ns,
                 np.int64(third.utc_ns), (third.utc_ns - frames[0].utc_ns - 1000) * 1e-9]:
        assert next(iter(source.seek(time))) == third, time
    assert list(source.seek(frames[0].time)) == frames
    assert list(source.seek(1e6)) == []


@pytest.mark.parametrize("time, kind, said", [
    (datetime.datetime(2026, 1, 1), ValueError, "has no time zone"), ("12:00", TypeError, "a time is given as str"),
    (True, TypeError, "a time is given as bool"), (float("nan"), ValueError, "nan is not a time")])
def test_what_is_no_time_is_told(source, time, kind, said):
    with pytest.raises(kind, match=said):
        source.seek(time)


@pytest.mark.parametrize("index", ["3", 1.5, None, (1, 2), slice("a", None)])
def test_what_is_no_place_is_told(source, index):
    with pytest.raises(TypeError, match="use a whole number, its place in the stream"):
        source[index]


def test_jumps_leave_an_iteration_alone(path, frames):
    with lumsdk.open(path, columns="all") as source:
        iterator = iter(source)
        got = [next(iterator), next(iterator)]
        assert source[10] == frames[10] and source[1] == frames[1]
        got += [next(iterator)]
        next(iter(source.seek(frames[7].time)))
        assert got + list(iterator) == frames
        assert source[-1] == frames[-1] and list(iterator) == []


def test_counts_are_those_of_the_iteration(path):
    with lumsdk.open(path) as source:
        list(source)
        counts = source.counts
        source[3], source[2], list(source[4:6])
        assert source.counts == counts and operator.length_hint(source) == COUNT


def test_it_works_for_memory_and_for_file_objects(path, frames):
    content = path.read_bytes()
    with open(path, "rb") as file:
        for given_as in [content, io.BytesIO(content), file, io.BytesIO(content)]:
            with lumsdk.open(given_as, columns="all") as source:
                iterator = iter(source)
                assert next(iterator) == frames[0] and source[9] == frames[9] and next(iterator) == frames[1]
                assert list(source[3:5]) == frames[3:5] and source.index() == COUNT
                assert list(iterator) == frames[2:]


def test_what_cannot_seek_cannot_jump(path):
    code = ("import lumsdk\ns = lumsdk.open('-')\nfor again in range(2):\n    try:\n        s[2]\n    except lumsdk.Error as "
            "error:\n        print(error)\n    list(s) if not again else None\n")
    done = subprocess.run([sys.executable, "-c", code], input=path.read_bytes(), capture_output=True, check=True)
    assert done.stdout.decode().splitlines() == ["standard input: it can be read only once, since it cannot seek; open it "
                                                 "again, or give a path"] * 2


def test_several_captures_are_one_stream(path, frames, tmp_path):
    subprocess.run([BIN / "lumdump", path, "-q", "--rotate", "2MB", "-o", tmp_path / "part.pcap"], check=True)
    parts = sorted(tmp_path.glob("*.pcap"))
    with lumsdk.open(parts, columns="all") as source:
        assert len(parts) > 1 and source[COUNT - 2] == frames[-2] and source[1] == frames[1] and source[-1] == frames[-1]


def test_an_index_is_kept_and_used(path, frames, tmp_path):
    copy = tmp_path / "drive.pcap"
    copy.write_bytes(path.read_bytes())
    kept = tmp_path / "drive.pcap.lumindex"
    with lumsdk.open(copy, columns="all") as source:
        assert source.index() == COUNT and not kept.exists()
        assert source.index(keep=True) == COUNT and kept.exists()
    with lumsdk.open(copy, columns="all") as source:
        assert source[-1] == frames[-1] and source[COUNT // 2] == frames[COUNT // 2]
    kept.write_bytes(kept.read_bytes()[:-9])
    with lumsdk.open(copy, columns="all") as source:
        assert source[-1] == frames[-1], "one that is damaged is not used"
    with lumsdk.open(copy.read_bytes()) as source, pytest.raises(lumsdk.CaptureError):
        source.index(keep=True)


def test_a_capture_that_breaks_off(path, frames, tmp_path):
    cut = tmp_path / "cut.pcap"
    cut.write_bytes(path.read_bytes()[:-10 ** 6])
    with lumsdk.open(cut, columns="all") as source:
        assert source[3] == frames[3]
        with pytest.raises(lumsdk.CaptureError, match="cut.pcap"):
            source[COUNT - 1]
    with lumsdk.open(cut, columns="all", broken="warn") as source, pytest.warns(lumsdk.CaptureWarning):
        with pytest.raises(IndexError):
            source[COUNT - 1]
        assert source[3] == frames[3]


def test_a_file_that_went_away_is_told_each_time(path, tmp_path):
    packed = tmp_path / "drive.pcap.gz"
    packed.write_bytes(gzip.compress(path.read_bytes(), 1))
    with lumsdk.open(packed) as source:
        assert source[3].number == 4
        packed.unlink()
        for _ in range(2):
            with pytest.raises(lumsdk.CaptureError) as told:
                source[1]
            assert str(told.value).count("drive.pcap.gz") == 1 and "No such file" in str(told.value)


@pytest.mark.parametrize("problem, raised", [(IndexError, IndexError), (StopIteration, RuntimeError)])
@pytest.mark.parametrize("of", [lambda source: source, lambda source: source[0:]], ids=["all", "slice"])
def test_what_a_file_object_raises_is_no_end(path, of, problem, raised):
    class Failing(io.BytesIO):
        def readinto(self, room):
            if self.tell() > 2 * 10 ** 6:
                raise problem("a fault")
            return super().readinto(room)

    with lumsdk.open(Failing(path.read_bytes())) as source, pytest.raises(raised, match="a fault|StopIteration"):
        for _ in of(source):  # list() would ask for the length first
            pass


def test_what_tells_the_progress_is_no_end(path):
    def tell(done, total):
        raise StopIteration

    with lumsdk.open(path, progress=tell) as source, pytest.raises(RuntimeError, match="raised StopIteration"):
        list(source)


def test_a_jump_that_was_interrupted_can_be_tried_again(path, frames):
    stops = iter([False, True, False, True])

    def tell(done, total):
        if next(stops, False):
            raise KeyboardInterrupt

    with lumsdk.open(path, columns="all", progress=tell) as source:
        with pytest.raises(KeyboardInterrupt):
            for place in (4, 9):
                assert source[place] == frames[place]
        assert source[3] == frames[3]
        with pytest.raises(KeyboardInterrupt):
            list(source)
        assert source[-1] == frames[-1] and list(source) == frames
