"""Sources: what they read, how they end, what they refuse, and how they behave among threads and signals."""
import contextlib
import functools
import gc
import gzip
import http.server
import io
import mmap
import multiprocessing
import operator
import os
import pathlib
import pickle
import random
import signal
import struct
import subprocess
import sys
import textwrap
import threading
import tracemalloc
import warnings

import lumsdk
import numpy as np
import pytest
from conftest import BIN, PATIENCE_S
from hypothesis import given, settings
from hypothesis import strategies as st


@pytest.fixture(scope="module")
def path(make_capture):
    return make_capture("-n", 5, "--loss", 0.01, "--seed", 5)


@pytest.fixture(scope="module")
def content(path):
    return path.read_bytes()


@pytest.fixture(scope="module")
def frames(path):
    return list(lumsdk.open(path))


# --- Kinds of sources ---


class Reads:
    """An object with read() alone, which gives as many bytes as it likes."""

    def __init__(self, content, most=70001):
        self.file, self.most = io.BytesIO(content), most

    def read(self, size):
        return self.file.read(min(size, self.most))


def test_every_kind_of_source_gives_the_same(path, content, frames, tmp_path):
    packed = tmp_path / "drive.pcap.gz"
    packed.write_bytes(gzip.compress(content, 1))
    with open(path, "rb") as file, open(path, "rb", buffering=0) as raw, gzip.open(packed) as unpacked, \
            mmap.mmap(os.open(path, os.O_RDONLY), 0, access=mmap.ACCESS_READ) as mapped:
        for source in [str(path), path, [path], (path,), str(path)[:-2] + "?p", [str(path)[:-1] + "*"], content,
                       bytearray(content), memoryview(content), np.frombuffer(content, "u1"), io.BytesIO(content), file,
                       raw, unpacked, Reads(content), Reads(content, 1000), packed]:
            assert list(lumsdk.open(source)) == frames, source
        source = lumsdk.open(mapped)
        assert list(source) == frames
        source.close()
        del source
        gc.collect()


def test_a_pipe_and_standard_input_are_read(path, frames):
    code = "import lumsdk, sys; s = lumsdk.open(sys.argv[1]); print(sum(len(f) for f in s), s.losses['lost_words'])"
    want = f"{sum(map(len, frames))} {sum(frame.losses['lost_words'] for frame in frames)}"
    with open(path, "rb") as file:
        for name in ["-", "/dev/stdin"] if sys.platform == "linux" else ["-"]:
            file.seek(0)
            done = subprocess.run([sys.executable, "-c", code, name], stdin=file, capture_output=True, text=True, check=True)
            assert done.stdout.split() == want.split()
    done = subprocess.run([sys.executable, "-c", code, "-"], input=path.read_bytes(), capture_output=True, check=True)
    assert done.stdout.decode().split() == want.split()


def test_a_file_object_is_read_from_where_it_stands(content, frames):
    file = io.BytesIO(b"some head" + content)
    file.seek(9)
    source = lumsdk.open(file)
    assert list(source) == frames
    assert list(source) == frames, "it can seek, so it is read again"


def test_what_cannot_be_read_again_says_so(content):
    source = lumsdk.open(Reads(content))
    assert len(list(source)) == 5
    with pytest.raises(lumsdk.Error, match="it can be read only once"):
        iter(source)


def test_an_iteration_begins_at_the_start(path, frames):
    with lumsdk.open(path) as source:
        one, other = iter(source), iter(source)
        assert next(one) == next(other) == frames[0]
        assert next(one) == frames[1] and list(other) == frames[1:] and next(one) == frames[2]


def test_a_url_is_read(path, frames):
    pytest.importorskip("fsspec")
    assert list(lumsdk.open(f"file://{path}")) == frames
    with lumsdk.open(f"file://{path}") as source:
        assert list(source) == list(source) == frames
    for missing in (f"file://{path}-none", [f"file://{path}-none"]):
        with pytest.raises(lumsdk.CaptureError, match="-none: cannot be opened: there is no such file"):
            lumsdk.open(missing)
    with pytest.raises(lumsdk.OptionError, match="nosuch://a/b.pcap: Protocol not known"):
        lumsdk.open("nosuch://a/b.pcap")
    with pytest.raises(lumsdk.CaptureError, match="no file has such a name"):
        lumsdk.open(f"file://{path}-none-*")
    assert list(lumsdk.open([f"file://{path}"])) == frames


def test_several_urls_are_one_stream(rotated):
    pytest.importorskip("fsspec")
    parts, drive = rotated
    want = list(lumsdk.open(drive))
    assert list(lumsdk.open([f"file://{part}" for part in parts])) == want
    assert list(lumsdk.open(f"file://{parts[0].parent}/part-*.pcap")) == want


def test_a_fault_of_a_store_is_told_with_its_url(monkeypatch):
    memory = pytest.importorskip("fsspec.implementations.memory")

    def fail(*_, **__):
        raise RuntimeError("no credentials")

    monkeypatch.setattr(memory.MemoryFileSystem, "_open", fail)
    with pytest.raises(lumsdk.CaptureError, match="memory://a.pcap: cannot be opened: RuntimeError: no credentials"):
        lumsdk.open("memory://a.pcap")


@pytest.fixture
def web(drive):
    """web(ranges): the folder of the capture by HTTP, for who brings a token, with or without parts of files."""
    pytest.importorskip("fsspec.implementations.http")
    kept = contextlib.ExitStack()

    def serve(ranges):
        class Handler(http.server.SimpleHTTPRequestHandler):
            def send_head(self):
                if self.headers["X-Token"] != "open":
                    self.send_error(403)
                    return None
                first, _, last = self.headers.get("Range", "").removeprefix("bytes=").partition("-")
                if not ranges or not last:
                    return super().send_head()
                part = drive.read_bytes()[int(first):int(last) + 1]
                self.send_response(206)
                self.send_header("Content-Length", str(len(part)))
                self.end_headers()
                return io.BytesIO(part)

            def handle(self):
                with contextlib.suppress(OSError):  # whoever has what it wants leaves
                    super().handle()

            def log_message(self, *_):
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=drive.parent))
        kept.enter_context(server)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        kept.callback(server.shutdown)
        return f"http://127.0.0.1:{server.server_port}/{drive.name}"
    with kept:
        yield serve


TOKEN = {"headers": {"X-Token": "open"}}


def test_what_a_store_needs_goes_to_it(web, drive, tmp_path):
    url, want = web(True), list(lumsdk.open(drive))
    with pytest.raises(lumsdk.CaptureError, match=f"{url}: cannot be opened: .*403"):
        lumsdk.open(url)
    with lumsdk.open(url, storage_options=TOKEN) as source:
        assert list(source) == want and source[4] == want[4]
        assert pickle.loads(pickle.dumps(source))[3] == want[3]
        if hasattr(os, "fork"):
            check_forked(source, want)
    for keyed in TOKEN, {"http": TOKEN}:
        source = lumsdk.open([url], storage_options=keyed)
        assert list(source) == want
        sent = pickle.loads(pickle.dumps(source))
        assert list(sent) == want and sent._input.given == [url] and sent._input.storage == keyed
    for kind in ("csv", "npy"):
        lumsdk.convert(drive, tmp_path / f"a.{kind}")
        lumsdk.convert(url, tmp_path / f"b.{kind}", storage_options=TOKEN)
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()
    for named in (str(drive), [drive], b"bytes"):
        with pytest.raises(lumsdk.OptionError, match="storage_options does not go with .*: it is for a URL"):
            lumsdk.open(named, storage_options=TOKEN)
    with pytest.raises(TypeError, match="storage_options is 1, of type int; use a mapping for fsspec"):
        lumsdk.open(url, storage_options=1)


def test_a_server_without_ranges_is_told_with_what_helps(web, drive, tmp_path):
    url, want = web(False), list(lumsdk.open(drive))
    said = rf"{url}: cannot be read: its server does not give parts .*by storage_options=.'block_size': 0., or download it"
    for read in (list, lambda source: source[-1], lambda source: lumsdk.convert(source, tmp_path / "a.npy", columns="x")):
        with pytest.raises(lumsdk.CaptureError, match=said.replace("'", '"')):
            read(lumsdk.open(url, storage_options=TOKEN))
    with pytest.raises(lumsdk.CaptureError, match=said.replace("'", '"')):
        lumsdk.convert(url, tmp_path / "a.csv", storage_options=TOKEN)
    with lumsdk.open(url, storage_options={**TOKEN, "block_size": 0}) as source:
        assert list(source) == list(source) == want


def test_a_message_does_not_have_a_whole_capture(path):
    content = path.read_bytes()
    for call in (lambda: lumsdk.open([content]), lambda: lumsdk.convert("drive.npy", content)):
        with pytest.raises(TypeError) as told:
            call()
        assert len(str(told.value)) < 500


def test_a_url_without_fsspec_says_what_to_install(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(lumsdk.OptionError, match=r"in a clone of lumsdk, pip install '\.\[url\]'"):
        lumsdk.open(f"s3://bucket/{path.name}")


# --- Several ---


@pytest.fixture(scope="module")
def rotated(tmp_path_factory, make_capture):
    """A recording in several files, and all of it in one."""
    drive = make_capture("-n", 6, "--seed", 9)
    out = tmp_path_factory.mktemp("rotated")
    subprocess.run([BIN / "lumdump", drive, "-q", "--rotate", "3MB", "-o", out / "part.pcap"], check=True)
    parts = sorted(out.glob("*.pcap"))
    assert len(parts) > 2
    return parts, drive


@given(st.data())
@settings(max_examples=5)
def test_several_are_one_stream_in_any_order(rotated, data):
    parts, drive = rotated
    got, want = list(lumsdk.open(data.draw(st.permutations(parts)))), list(lumsdk.open(drive))
    assert got == want


def test_a_pattern_means_all_that_it_finds(rotated):
    parts, _ = rotated
    folder = parts[0].parent
    with lumsdk.open(folder / "*.pcap") as source:
        assert len(list(source)) == 6 and source.name == f"{parts[0]} and {len(parts) - 1} more"
    with pytest.raises(lumsdk.CaptureError, match=r"x\*\.pcap: no file has such a name"):
        lumsdk.open(str(folder / "x*.pcap"))
    odd = folder / "a[1].pcap"
    odd.write_bytes(parts[0].read_bytes())
    assert list(lumsdk.open(odd)) == list(lumsdk.open(parts[0]))
    odd.unlink()


def test_a_file_that_is_named_twice_is_refused(rotated):
    parts, _ = rotated
    link = parts[0].parent / "link"
    link.symlink_to(parts[0])
    with pytest.raises(lumsdk.OptionError, match="are one file: name each source once"):
        lumsdk.open([parts[0], link])
    link.unlink()


# --- What cannot be read ---


@pytest.mark.parametrize("given, kind, said", [
    (3, TypeError, "a source is given as int; use a path, a pattern"),
    (None, TypeError, "a source is given as NoneType; use"),
    ([3], TypeError, "a source in a list is 3, of type int"),
    ([b"abc"], TypeError, "captures in memory and file objects are read alone"),
    (io.StringIO("text"), TypeError, 'opened as text; use mode "rb"'),
    ([], lumsdk.OptionError, "no capture is named"),
    ("none.pcap", lumsdk.CaptureError, "none.pcap: cannot be opened: No such file"),
    (b"", lumsdk.CaptureError, "0 bytes: "),
    (b"not a capture, but long enough to be looked at", lumsdk.CaptureError, "46 bytes: not a"),
    (io.BytesIO(b"not a capture, but long enough to be looked at"), lumsdk.CaptureError, "not a"),
    ("10.42.0.37", lumsdk.CaptureError, "there is no such file; a sensor is read by lumsdk.Sensor('10.42.0.37')"),
    ("udp://10.42.0.37", lumsdk.OptionError, "lumsdk.Sensor('10.42.0.37')"),
])
def test_what_cannot_be_read_is_told(given, kind, said):
    with pytest.raises(kind) as caught:
        lumsdk.open(given)
    assert said in str(caught.value)


def test_a_folder_is_refused_as_lumdump_refuses_it(tmp_path):
    done = subprocess.run([BIN / "lumdump", tmp_path], capture_output=True, text=True, check=False)
    with pytest.raises(lumsdk.CaptureError) as caught:
        lumsdk.open(tmp_path)
    assert f"lumdump: {caught.value}" == done.stderr.strip()


def test_a_folder_of_rosbag2_is_its_files(path, tmp_path):
    subprocess.run([BIN / "lumdump", path, "--format", "rosbag2", "--mcap", "packets", "--rotate", "1s", "-q", "-o",
                    tmp_path / "drive"], check=True)
    (tmp_path / "drive" / ".x.mcap").write_bytes(b"hidden")
    for each in (tmp_path / "drive", [str(tmp_path / "drive")]):
        with lumsdk.open(each) as got, lumsdk.open(path) as want:
            assert [f.xyz.tolist() for f in got] == [f.xyz.tolist() for f in want]


def test_a_bag_has_the_frames_of_its_capture(path, content, tmp_path):
    # In a process of its own: what the tests of the tools share changes the process that imports it.
    program = "import sys, bag_maker; sys.stdout.buffer.write(bag_maker.bag(sys.stdin.buffer.read()))"
    made = subprocess.run([sys.executable, "-c", program], cwd=pathlib.Path(__file__).parents[1] / "tools", input=content,
                          stdout=subprocess.PIPE, check=True).stdout
    (tmp_path / "drive.bag").write_bytes(made)
    want = [f.xyz.tolist() for f in lumsdk.open(path)]
    for each in (tmp_path / "drive.bag", made, io.BytesIO(made)):
        assert [f.xyz.tolist() for f in lumsdk.open(each)] == want


def test_a_folder_of_sqlite_is_refused(tmp_path):
    (tmp_path / "drive_0.db3").touch()
    with pytest.raises(lumsdk.CaptureError, match="SQLite"):
        lumsdk.open(tmp_path)


def test_a_capture_that_breaks_off_gives_its_frames_first(content, tmp_path):
    path = tmp_path / "cut.pcap"
    path.write_bytes(content[:-5000])
    got = []
    with pytest.raises(lumsdk.CaptureError) as caught:
        for frame in lumsdk.open(path):
            got.append(frame.number)
    done = subprocess.run([BIN / "lumdump", path], capture_output=True, text=True, check=False)
    assert got == [1, 2, 3, 4, 5] and f"warning: {caught.value}\n" in done.stderr
    with pytest.warns(lumsdk.CaptureWarning, match="cut.pcap: "):
        source = lumsdk.open(path, broken="warn")
        assert len(list(source)) == 5 and source.truncated


def test_a_damaged_part_is_told_behind_all_frames(path, tmp_path):
    made = tmp_path / "damaged.pcapng"
    subprocess.run([BIN / "lumdump", path, "-q", "-o", made], check=True)
    content = bytearray(made.read_bytes())
    at = content.index(bytes((6, 0, 0, 0)), len(content) // 2)
    while struct.unpack_from("<I", content, at + 4) != struct.unpack_from("<I", content, at + struct.unpack_from("<I", content, at + 4)[0] - 4):
        at = content.index(bytes((6, 0, 0, 0)), at + 1)
    struct.pack_into("<I", content, at + 20, 65535)
    made.write_bytes(content)
    told = f"damaged.pcapng: 1 part of it could not be read and was passed over: byte {at}: a packet of 65535 bytes"
    got = []
    with pytest.raises(lumsdk.CaptureError, match=told):
        for frame in lumsdk.open(made):
            got.append(frame.xyz.tolist())
    assert len(got) == 5
    for each in (made, bytes(content), io.BytesIO(content)):
        with pytest.warns(lumsdk.CaptureWarning, match=told.partition(": ")[2]):
            source = lumsdk.open(each, broken="warn")
            assert [frame.xyz.tolist() for frame in source] == got
        assert source.counts["damaged"] == source.losses["damaged"] == 1 and not source.truncated
    with lumsdk.open(made, broken="warn") as source, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert [source[i].xyz.tolist() for i in (4, 0, 2)] == [got[i] for i in (4, 0, 2)]
    with pytest.warns(lumsdk.CaptureWarning, match=told):
        assert lumsdk.infer(made).profile is not None


def test_a_sensor_that_is_not_in_it_is_refused(path):
    with lumsdk.open(path, sensor="10.42.0.37") as source:
        assert len(list(source)) == 5 and source.sensors == ["10.42.0.37"]
    with pytest.raises(lumsdk.CaptureError, match="no data of 10.42.0.99 in it, but of 10.42.0.37"):
        list(lumsdk.open(path, sensor="10.42.0.99"))


def test_a_capture_of_another_layout_is_refused(path):
    with pytest.raises(lumsdk.CaptureError, match="packets of a G2 came, but none of them is a data packet: .*unknown_type"):
        list(lumsdk.open(path, profile={"data_packet_type": 77}))


def test_a_capture_without_a_sensor_gives_a_warning(tmp_path, content):
    with pytest.warns(lumsdk.CaptureWarning, match="no packet of a G2 was found"):
        assert list(lumsdk.open(content[:24])) == []


def test_a_capture_of_cut_wrapped_or_unsorted_packets_gives_a_warning(content):
    records, at = [], 24
    while at < len(content):
        length = int.from_bytes(content[at + 8:at + 12], "little")
        records.append((content[at:at + 8], content[at + 16:at + 16 + length]))
        at += 16 + length

    def capture(change):
        made = [(head, change(frame), len(frame)) for head, frame in records]
        return content[:24] + b"".join(h + len(f).to_bytes(4, "little") + max(len(f), n).to_bytes(4, "little") + f
                                       for h, f, n in made)

    with pytest.warns(lumsdk.CaptureWarning, match="snap length of 1000 bytes; record whole packets"):
        list(lumsdk.open(capture(lambda frame: frame[:1000])))
    gre = bytes.fromhex("45000018000100004 02f0000 0a000001 0a000002 00000800".replace(" ", ""))
    with pytest.warns(lumsdk.CaptureWarning, match="came wrapped in 38 bytes of other headers, .*editcap -C 38 -L -T rawip4 IN OUT"):
        list(lumsdk.open(capture(lambda frame: frame[:14] + gre + frame[14:])))
    records = [r for i in range(0, len(records), 200) for r in records[i:i + 200:2] + records[i + 1:i + 200:2]]
    source = lumsdk.open(capture(lambda frame: frame))
    with pytest.warns(lumsdk.CaptureWarning, match="too far out of order in the capture.*reordercap IN OUT"):
        list(source)
    assert source.counts["out_of_order"] > 2


def test_another_port_is_named_and_can_be_chosen(content, frames):
    made = content.replace(b"\x15\x8d", b"\x15\xe0")
    with pytest.warns(lumsdk.CaptureWarning, match="came from UDP port 5600.*port=5600"):
        assert list(lumsdk.open(made)) == []
    assert [f.number for f in lumsdk.open(made, port=5600)] == [f.number for f in frames]
    assert lumsdk.infer(made).verdict == "too little" and lumsdk.infer(made, port=5600).profile is not None


# --- File objects that fail ---


class Broken(io.RawIOBase):
    """A file that fails after some bytes."""

    def __init__(self, content, after, problem):
        self.file, self.left, self.problem = io.BytesIO(content), after, problem

    def readable(self):
        return True

    def readinto(self, buffer):
        if self.left <= 0:
            raise self.problem
        size = min(len(buffer), self.left)
        self.left -= size
        return self.file.readinto(memoryview(buffer)[:size])


@pytest.mark.parametrize("problem", [OSError(5, "the network is gone"), RuntimeError("odd"), MemoryError()])
def test_what_a_file_object_raises_comes_out_after_the_frames(content, problem):
    got = []
    with pytest.raises(type(problem)) as caught:
        for frame in lumsdk.open(Broken(content, len(content) * 3 // 5, problem)):
            got.append(frame.number)
    assert caught.value is problem and got[:2] == [1, 2] and len(got) in (3, 4)


def test_what_a_file_object_raises_at_first_comes_out_of_open(content):
    with pytest.raises(OSError, match="at once"):
        lumsdk.open(Broken(content, 0, OSError("at once")))
    with pytest.raises(KeyboardInterrupt):
        lumsdk.open(Broken(content, 0, KeyboardInterrupt()))


def test_ctrl_c_in_a_file_object_comes_out_at_once(content):
    source = lumsdk.open(Broken(content, len(content) // 2, KeyboardInterrupt()))
    got = []
    with pytest.raises(KeyboardInterrupt):
        for frame in source:
            got.append(frame.number)
    assert len(got) < 3


@pytest.mark.parametrize("gives, kind, said", [("text", TypeError, "its read() gives str"), (None, BlockingIOError, "waits"),
                                               (b"x" * 10 ** 6, ValueError, "bytes were read where")])
def test_a_file_object_that_gives_nonsense_is_refused(gives, kind, said):
    class Odd:
        def read(self, _):
            return gives

    with pytest.raises(kind) as caught:
        lumsdk.open(Odd())
    assert said in str(caught.value)


def test_a_file_object_is_let_go(content):
    class File(io.BytesIO):
        pass

    import weakref
    file = File(content)
    alive = weakref.ref(file)
    assert len(list(lumsdk.open(file))) == 5
    del file
    assert alive() is None, "a cycle keeps it until the collector comes"


# --- Its end ---


def test_a_closed_source_says_so(path, frames):
    with lumsdk.open(path) as source:
        iterator = iter(source)
        frame = next(iterator)
    source.close()
    for use in [lambda: iter(source), lambda: next(iterator), lambda: source[0], lambda: source.__enter__()]:
        with pytest.raises(lumsdk.ClosedError, match="the source is closed; open it again"):
            use()
    assert frame == frames[0] and frame.grid("range", "blue").shape == (64, 1000)
    assert source.counts["frames"] >= 1 and source.sensors == ["10.42.0.37"] and source.progress[0] > 0
    assert repr(source) == f"<Source {path}: closed>"
    with pytest.raises(lumsdk.ClosedError):
        pickle.dumps(source)


# --- Processes ---


@pytest.fixture(scope="module")
def drive(make_capture):
    return make_capture("-n", 24, "--lines", 64, "--seed", 6, name="long.pcap")


_ours = {}  # what a worker that was forked finds


def find(place):
    """A frame of the source that the workers got as they were forked."""
    return _ours["source"][place]


def take(source_and_place):
    source, place = source_and_place
    return source[place], len(source)


def go_on():
    return next(_ours["iteration"])


def check_forked(source, want):
    """Frames that are sought at random by forked workers, while this process reads on, are those of the drive."""
    _ours["source"], _ours["iteration"] = source, iter(source)
    source[7]
    assert next(_ours["iteration"]) == want[0]
    places = [i * 7 % len(want) for i in range(4 * len(want))]
    with multiprocessing.get_context("fork").Pool(4) as pool:
        asked = pool.map_async(find, places, chunksize=1)
        assert [source[i] for i in reversed(range(len(want)))] == want[::-1]
        assert list(_ours["iteration"]) == want[1:]
        assert asked.get(PATIENCE_S) == [want[i] for i in places]
        with pytest.raises(lumsdk.Error, match="began before this process was forked.*begin one here"):
            pool.apply(go_on)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_forked_workers_give_right_frames(drive):
    want = list(lumsdk.open(drive))
    content = drive.read_bytes()
    with open(drive, "rb") as file, open(drive, "rb", buffering=0) as raw:
        for given in (drive, [drive], content, io.BytesIO(content), file, raw):
            with lumsdk.open(given) as source:
                check_forked(source, want)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_a_file_object_that_two_processes_would_move_is_refused(drive, tmp_path):
    gone = tmp_path / "gone.pcap"
    gone.write_bytes(drive.read_bytes())
    packed = tmp_path / "drive.gz"
    packed.write_bytes(gzip.compress(drive.read_bytes(), 1))
    with open(gone, "rb") as removed, gzip.open(packed) as unpacked:
        gone.unlink()
        for file in removed, unpacked:
            with lumsdk.open(file) as source:
                _ours["source"] = source
                with multiprocessing.get_context("fork").Pool(1) as pool, \
                        pytest.raises(lumsdk.Error, match="before this process was forked.*open it in the process that reads it"):
                    pool.apply(find, (0,))


def fill(pipe, content):
    with contextlib.suppress(BrokenPipeError):
        pipe.write_bytes(content)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_a_pipe_belongs_to_one_process(drive, tmp_path):
    pipes = [tmp_path / "a", tmp_path / "b"]
    for named in pipes[0], pipes:
        writers = [threading.Thread(target=fill, args=(pipe, drive.read_bytes())) for pipe in pipes]
        for pipe in pipes:
            os.mkfifo(pipe)
        for writer in writers:
            writer.start()
        with lumsdk.open(named) as source:
            _ours["source"] = source
            with multiprocessing.get_context("fork").Pool(1) as pool, \
                    pytest.raises(lumsdk.Error, match="before this process was forked.*open it in the process that reads it"):
                pool.apply(find, (0,))
            with pytest.raises(TypeError, match="read only once"):
                len(source)
            with pytest.raises(TypeError, match="only a source opened from paths or URLs"):
                pickle.dumps(source)
            assert next(iter(source)) == lumsdk.open(drive)[0]
        for pipe in pipes:
            with open(pipe, "rb", buffering=0, opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)):
                pass
        for writer in writers:
            writer.join()
        for pipe in pipes:
            pipe.unlink()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_a_place_that_was_sought_is_that_of_each_process(drive):
    want = lumsdk.open(drive)[9]
    with lumsdk.open(drive) as source:
        _ours["source"] = source.seek(want.utc_ns)
        with multiprocessing.get_context("fork").Pool(1) as pool:
            assert pool.apply(take_first) == want
        assert next(iter(pickle.loads(pickle.dumps(source)))) == next(iter(source)) == want
        assert next(iter(source)) == source[0]


def take_first():
    return next(iter(_ours["source"]))


def look():
    source = _ours["source"]
    told = [repr(source)]
    source.close()
    return [*told, repr(source), source.losses, source.sensors]


def test_another_file_of_the_name_is_not_read(drive, path, tmp_path, monkeypatch):
    want = list(lumsdk.open(drive))
    here = tmp_path / "drive.pcap"
    here.write_bytes(drive.read_bytes())
    monkeypatch.chdir(tmp_path)
    with lumsdk.open("drive.pcap") as source:
        assert list(source) == want
        (tmp_path / "sub").mkdir()
        (tmp_path / "sub" / "drive.pcap").write_bytes(path.read_bytes())
        monkeypatch.chdir(tmp_path / "sub")
        assert list(source) == want and source[3] == want[3]
        os.replace("drive.pcap", here)
        for read in list, lambda source: lumsdk.open(here)[0] == want[0] or next(iter(source)):
            with pytest.raises(lumsdk.Error, match="another file has had this name since it was opened; open it again"):
                read(source)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_a_child_can_close_what_its_parent_reads(drive):
    with lumsdk.open(drive) as source:
        iterator = iter(source)
        next(iterator)
        _ours["source"] = source
        with multiprocessing.get_context("fork").Pool(1) as pool:
            told, closed, losses, sensors = pool.apply(look)
        assert told.endswith("0 frames read>") and closed.endswith("closed>") and not any(losses.values()) and sensors == []
        assert len(list(iterator)) == 23


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing is forked here")
def test_a_fork_in_the_middle_of_a_read_is_harmless(drive):
    """The library is at work in another thread, with its locks."""
    want = list(lumsdk.open(drive))
    ended, wrong = threading.Event(), []
    with lumsdk.open(drive) as read, lumsdk.open(io.BytesIO(drive.read_bytes())) as source:
        def read_on():
            while not ended.is_set():
                wrong.extend(i for i, frames in enumerate(zip(want, read)) if frames[0] != frames[1])
                wrong.extend(i for i, frames in enumerate(zip(want, source)) if frames[0] != frames[1])

        thread = threading.Thread(target=read_on)
        thread.start()
        for given in (read, source) * 3:
            _ours["source"] = given
            with multiprocessing.get_context("fork").Pool(2) as pool:
                assert pool.map(find, (3, 20, 1)) == [want[3], want[20], want[1]]
        ended.set()
        thread.join()
    assert wrong == []


def collate(frames):
    return frames


@pytest.mark.torch
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_the_loader_of_torch(drive, method):
    from torch.utils import data

    want = list(lumsdk.open(drive))
    with lumsdk.open(drive) as source:
        assert source[3] == want[3]
        order = random.Random(5).sample(range(len(want)), len(want))
        loader = data.DataLoader(source, batch_size=2, sampler=order, num_workers=2, collate_fn=collate, multiprocessing_context=method)
        assert [frame for batch in loader for frame in batch] == [want[i] for i in order]


def test_a_source_of_paths_or_urls_is_sent_to_another_process(drive, tmp_path, monkeypatch):
    want = list(lumsdk.open(drive, columns=["x", "range"], profile=lumsdk.Profile(), eye="blue"))
    monkeypatch.chdir(drive.parent)
    source = lumsdk.open(drive.name, columns=iter(["x", "range"]), profile=lumsdk.Profile(), eye="blue")
    monkeypatch.chdir(tmp_path)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(take, ((source, 3),)) == (want[3], len(want))
    assert list(pickle.loads(pickle.dumps(lumsdk.open([drive])[5:7]))) == list(lumsdk.open(drive)[5:7])


def test_a_url_is_sent_to_another_process(drive):
    pytest.importorskip("fsspec")
    want = list(lumsdk.open(drive))
    with lumsdk.open(f"file://{drive}") as source:
        assert pickle.loads(pickle.dumps(source))[3] == want[3]
        if hasattr(os, "fork"):
            check_forked(source, want)


def test_a_source_of_other_things_is_not_sent_to_another_process(path, content):
    for named in content, io.BytesIO(content):
        with pytest.raises(TypeError, match="from paths or URLs.*or send its frames"):
            pickle.dumps(lumsdk.open(named))
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (sent, *_) = lumsdk.open(path)
        assert pool.apply(operator.attrgetter("info"), (sent,)) == sent.info
        assert pool.apply(operator.itemgetter("x"), (sent,)).tobytes() == sent["x"].tobytes()


def test_a_source_has_a_length(path, content, frames):
    with lumsdk.open(path) as source:
        assert len(source) == 5 and source and len(source[1:]) == 4
    with lumsdk.open(content, frames=(10 ** 9, None)) as none:
        assert len(none) == 0 and none
    read = []
    with lumsdk.open(path, progress=lambda done, total: read.append(done)) as source:
        assert list(source) == frames and read == sorted(read)  # list() asks for the length
        iterator = iter(source)
        assert len(source) == 5 and next(iterator) == frames[0]
    with lumsdk.open(path) as source:
        iterator = iter(source)
        with pytest.raises(TypeError, match=r"ask for the length before, or index\(\)"):
            len(source)
        assert next(iterator) == frames[0] and len(source) == 5
    with lumsdk.open(Reads(content)) as once:
        with pytest.raises(TypeError, match="read only once"):
            len(once)
        assert list(once) == frames


def test_losses_grow_as_it_is_read(path):
    source = lumsdk.open(path)
    assert set(source.losses.values()) == {0} and source.sensors == []
    list(source)
    assert source.losses["lost_words"] > 0 and list(source.losses)[0] == "lost_words"
    assert source.counts["frames"] == 5 and source.counts["points"] > 0


def records_of(content):
    """The records of a pcap of Ethernet, by what their data packets say: (record, eye, number)."""
    at = 24
    while at < len(content):
        end = at + 16 + int.from_bytes(content[at + 8:at + 12], "little")
        yield content[at:end], content[at + 71], int.from_bytes(content[at + 72:at + 74], "little")
        at = end


def test_late_lines_are_in_no_frame_and_in_no_count_of_points(make_capture):
    content = make_capture("-n", 6).read_bytes()
    sweep, kept, delayed = 0, [], []
    for record, eye, number in records_of(content):
        sweep += eye == 1 and number == 0 and record[58 + 12] == 2 and int.from_bytes(record[76:78], "little") == 0
        kept.append(record) if eye == 0 or sweep < 2 else delayed.append(record)
    source = lumsdk.open(content[:24] + b"".join(kept + delayed))
    frames = list(source)
    counts = source.counts
    assert counts["points_late"] > 0 and sum(map(len, frames)) == counts["points"]
    assert source.losses["lines_late"] == sum(frame.losses["lines_late"] for frame in frames) > 0
    assert source.losses["points_late"] == counts["points_late"]


def test_progress_and_the_hint_of_its_length(path, content):
    told = []
    source = lumsdk.open(path, progress=lambda done, total: told.append((done, total)))
    assert source.__length_hint__() == 0
    iterator = iter(source)
    next(iterator)
    assert 2 <= source.__length_hint__() <= 10
    rest = list(iterator)
    assert operator.length_hint(source) == 5 == 1 + len(rest) and operator.length_hint(iterator) == 0
    assert told == sorted(told) and told[-1] == (len(content), len(content)) == source.progress
    assert f"{source!r}".endswith("5 frames read, 100 %>")


def test_what_the_progress_function_raises_comes_out(path):
    def stop(done, total):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        list(lumsdk.open(path, progress=stop))


def test_the_progress_function_cannot_use_the_source(path):
    source = lumsdk.open(path, progress=lambda *_: source.losses)
    with pytest.raises(lumsdk.Error, match="is reading it; open a source for each thread"):
        list(source)


# --- Threads, signals, memory ---


def test_sources_in_threads_share_nothing(path, frames):
    results = [None] * 4

    def read(i):
        results[i] = list(lumsdk.open(path)) == frames

    threads = [threading.Thread(target=read, args=(i,)) for i in range(len(results))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True] * 4


def test_c_works_without_the_lock_of_python(content):
    """While one thread waits in C for a file, another one runs Python."""
    begun, go = threading.Event(), threading.Event()

    class Waits(io.BytesIO):
        def readinto(self, buffer):
            begun.set()
            go.wait()
            return super().readinto(buffer)

    got = []
    thread = threading.Thread(target=lambda: got.extend(lumsdk.open(Waits(content))))
    thread.start()
    begun.wait()
    go.set()
    thread.join()
    assert len(got) == 5


def test_a_source_in_two_threads_raises(content):
    begun, go = threading.Event(), threading.Event()

    class Waits(io.BytesIO):
        def readinto(self, buffer):
            if self.tell() > len(content) // 2:
                begun.set()
                go.wait()
            return super().readinto(buffer)

    source = lumsdk.open(Waits(content))
    iterator = iter(source)
    thread = threading.Thread(target=lambda: list(iterator))
    thread.start()
    begun.wait()
    for use in [lambda: next(iterator), lambda: source.losses, source.close]:
        with pytest.raises(lumsdk.Error, match="another thread, or the function called just now, is reading it"):
            use()
    go.set()
    thread.join()
    source.close()


INTERRUPTED = """
    import os, signal, sys, threading
    import lumsdk

    class Endless:
        '''A capture that never ends, and never has a frame of its own.'''
        def __init__(self, content):
            self.head, self.rest, self.at, self.told = content[:24], content[24:], -24, False

        def read(self, size):
            if self.at < 0:
                self.at = 0
                return self.head
            if self.at > 10 ** 7 and not self.told:
                print('reading', flush=True)
                self.told = True
            got = self.rest[self.at % len(self.rest):][:size]
            self.at += len(got)
            return got

    what = sys.argv[2]
    try:
        if what == 'frames':
            for frame in lumsdk.open(Endless(open(sys.argv[1], 'rb').read()), frames='1000000:'):
                pass
        elif what == 'pipe':
            print('reading', flush=True)
            list(lumsdk.open('-'))
        else:
            class Told:
                count = 0
            def tell(done, total):
                Told.count += 1
                if Told.count == 2:
                    print('reading', flush=True)
            while True:
                for frame in lumsdk.open(sys.argv[1], progress=tell):
                    pass
    except KeyboardInterrupt:
        print('interrupted', flush=True)
        os._exit(0)
    """


@pytest.mark.skipif(os.name == "nt", reason="a signal cannot be sent to a single program")
@pytest.mark.parametrize("what", ["frames", "pipe", "loop"])
def test_ctrl_c_ends_reading(path, what):
    """It would not end without: the capture has no end, or nobody writes into the pipe."""
    with subprocess.Popen([sys.executable, "-c", textwrap.dedent(INTERRUPTED), str(path), what], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "reading\n"
        process.send_signal(signal.SIGINT)
        lines = process.stdout.readlines()
        assert [line for line in lines if line != "reading\n"] == ["interrupted\n"]
        assert process.wait() == 0


def rss_kb():
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1])
    raise AssertionError


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_does_not_grow(make_capture):
    """Many small frames, read and dropped, and many sources that are never closed."""
    content = make_capture("-n", 40, "--loss", 0.97, "--seed", 2).read_bytes()

    def use(times):
        for _ in range(times):
            for frame in lumsdk.open(content):
                frame.xyz, frame["range"], frame.grid("range", "blue"), frame.lines, frame.losses, repr(frame)

    use(3)
    gc.disable()
    try:
        tracemalloc.start()
        use(3)
        before, (python, _) = rss_kb(), tracemalloc.get_traced_memory()
        use(12)
        after, (python_after, _) = rss_kb(), tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
        gc.enable()
    assert after - before < 8000, f"{after - before} KB more after 480 frames of 12 sources"
    assert python_after - python < 500_000


GROWN = """
import resource, sys, lumsdk
source = lumsdk.open(sys.argv[1], columns=["range", "azimuth", "elevation", "time", "pulse_width"], threads=1)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
frame = next(iter(source))
pages = sum(frame[name].nbytes for name in frame.columns) / resource.getpagesize()
print(pages, resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems copy a block that grows")
def test_a_frame_that_grows_touches_its_memory_once(make_capture):
    """The first one has no size to go by: its memory grows a dozen times."""
    made = subprocess.run([sys.executable, "-c", GROWN, make_capture("-n", 1, "--lines", 640)], capture_output=True, text=True,
                          check=True).stdout.split()
    pages, faults = map(float, made)
    assert pages > 2000 and faults < 2 * pages, made


def test_warnings_name_the_line_that_reads(tmp_path, content):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in lumsdk.open(content[:24]):
            pass
    assert [pathlib.Path(warning.filename).name for warning in caught] == [pathlib.Path(__file__).name]


@pytest.mark.parametrize("threads", [2, 3, 64])
def test_frames_are_the_same_with_any_number_of_threads(path, threads):
    """Lines wait for a thread of their own only where there are enough of them: the capture has 128 a frame."""
    options = {"columns": "all", "edge": "both", "smooth": 5}
    with lumsdk.open(path, threads=1, **options) as one, lumsdk.open(path, threads=threads, **options) as several:
        pairs = list(zip(one, several))
        assert len(pairs) == 5
        for a, b in pairs:
            assert a.number == b.number and a.columns == b.columns
            assert all(a[name].tobytes() == b[name].tobytes() for name in a.columns)
        assert one.losses == several.losses


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork()")
def test_a_child_of_fork_can_close_a_source_whose_threads_it_lacks(path):
    with lumsdk.open(path, threads=2) as source:
        next(iter(source))
        child = os.fork()
        if child == 0:
            signal.alarm(int(PATIENCE_S))  # one that hangs ends by it
            source.close()
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        assert len(list(source)) == 5
