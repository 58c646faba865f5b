"""lumsdk.torch: frames of captures as data sets, read by workers; what they give is what lumsdk.open() gives."""
import pickle
import subprocess
import sys

import lumsdk
import numpy as np
import pytest

METHODS = ["fork", "spawn"]


def test_without_torch_a_sentence_names_the_extra():
    code = "import sys; sys.modules['torch'] = None; import lumsdk; import lumsdk.torch"
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and "lumsdk.torch needs torch" in done.stderr and "pip install '.[torch]'" in done.stderr
    code = "import sys, lumsdk; lumsdk.open; lumsdk.Frame; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-B", "-c", code]).returncode == 0


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """Captures of 4 and 2 frames."""
    folder = tmp_path_factory.mktemp("torch")
    return [lumsdk.simulate(folder / f"{name}.pcap", frames=frames, seed=frames) for name, frames in (("a", 4), ("b", 2))]


def want(captures, **options):
    return [frame for capture in captures for frame in lumsdk.open(capture, **options)]


def pair(sample):
    return sample["capture"], sample["frame"]


def count(frame):
    return len(frame)


def fail(frame):
    raise ZeroDivisionError("no luck")


@pytest.mark.torch
def test_items_are_the_frames_in_their_memory(captures):
    import torch
    from lumsdk.torch import Frames, tensors

    frames = Frames(captures, columns=["xyz", "range", "eye"])
    every = want(captures, columns=["x", "y", "z", "range", "eye"])
    assert len(frames) == 6 and frames.counts == (4, 2)
    for i, frame in enumerate(every):
        sample = frames[i]
        assert list(sample) == ["xyz", "range", "eye", "capture", "frame", "utc_ns"] and pair(sample) == (i // 4, i % 4)
        assert sample["utc_ns"] == frame.utc_ns and np.array_equal(sample["xyz"].numpy(), frame.xyz)
        assert sample["eye"].dtype == torch.uint8 and np.array_equal(sample["range"].numpy(), frame["range"])
    assert pair(frames[-1]) == pair(frames.at(1, -1)) == pair(frames.at(captures[1], 1)) == (1, 1)
    assert frames.place(5) == (captures[1], 1)
    made = tensors(every[0])
    assert made["range"].data_ptr() == every[0]["range"].ctypes.data and list(made) == list(every[0])
    assert frames.at(0, 2)["range"].sum() == pickle.loads(pickle.dumps(frames)).at(0, 2)["range"].sum()


@pytest.mark.torch
def test_types_that_torch_lacks_are_told_and_wider(captures):
    import torch
    from lumsdk.torch import Frames

    if hasattr(torch, "uint16"):
        frames = Frames(captures[0], columns=["line", "pixel"])
        assert (frames[0]["line"].dtype, frames[0]["pixel"].dtype) == (torch.uint32, torch.uint16)
    else:
        with pytest.warns(UserWarning, match="has no uint16 and no uint32: columns of these types become int32 and int64"):
            frames = Frames(captures[0], columns=["line", "pixel"])
        assert (frames[0]["line"].dtype, frames[0]["pixel"].dtype) == (torch.int64, torch.int32)
    frame = lumsdk.open(captures[0])[0]
    assert np.array_equal(frames[0]["line"].numpy(), frame["line"]) and np.array_equal(frames[0]["pixel"].numpy(), frame["pixel"])


@pytest.mark.torch
@pytest.mark.parametrize("method", METHODS)
def test_workers_read_batches(captures, method):
    from lumsdk.torch import Frames, collate
    from torch.utils.data import DataLoader

    frames, every = Frames(captures, columns=["xyz", "range"]), want(captures)
    assert len(frames[1]["range"]) == len(every[1])  # open before the workers are
    order = [5, 0, 3, 1, 4, 2]
    loader = DataLoader(frames, batch_size=2, sampler=order, num_workers=2, collate_fn=collate, multiprocessing_context=method,
                        persistent_workers=True)
    for _ in range(2):
        for batch, first in zip(loader, range(0, 6, 2)):
            chosen = [every[i] for i in order[first:first + 2]]
            assert np.array_equal(batch["xyz"].numpy(), np.concatenate([frame.xyz for frame in chosen]))
            assert batch["row_splits"].tolist() == [0, len(chosen[0]), len(chosen[0]) + len(chosen[1])]
            assert batch["batch"].tolist() == [0] * len(chosen[0]) + [1] * len(chosen[1])
            assert batch["frame"].tolist() == [i % 4 for i in order[first:first + 2]]


@pytest.mark.torch
def test_padded_batches():
    import torch
    from lumsdk.torch import collate_padded

    batch = collate_padded([{"xyz": torch.ones(2, 3), "range": torch.tensor([5., 6.]), "frame": 7},
                            {"xyz": torch.ones(1, 3), "range": torch.tensor([8.]), "frame": 9}])
    assert batch["range"].tolist() == [[5, 6], [8, 0]] and batch["mask"].tolist() == [[True, True], [True, False]]
    assert batch["xyz"].shape == (2, 2, 3) and batch["xyz"].sum() == 9 and batch["frame"].tolist() == [7, 9]


@pytest.mark.torch
def test_items_that_do_not_go_together_are_refused():
    import torch
    from lumsdk.torch import collate

    points = torch.ones(2, 3)
    for samples, said in (([points], "takes items that are dictionaries"), ([], "takes items that are dictionaries"),
                          ([{"x": points}, {"y": points}], "other names than the first, x"), ([{"x": points, "batch": 1}], "which a batch adds"),
                          ([{"x": 1}], "none is a tensor of the points"),
                          ([{"x": points, "pose": torch.eye(4)}], "'pose' has 4 rows and 'x' has 2")):
        with pytest.raises((TypeError, ValueError), match=said):
            collate(samples)


@pytest.mark.torch
@pytest.mark.filterwarnings("ignore:This DataLoader will create")
@pytest.mark.parametrize("method", METHODS)
def test_workers_divide_a_stream(captures, method):
    from lumsdk.torch import StreamedFrames
    from torch.utils.data import DataLoader

    stream = StreamedFrames(captures, columns=["range"])
    every = [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1)]
    assert [pair(sample) for sample in stream] == every
    for workers in (2, 4):  # by captures, and by parts of them
        loader = DataLoader(stream, batch_size=None, num_workers=workers, multiprocessing_context=method)
        assert sorted(pair(sample) for sample in loader) == every


@pytest.mark.torch
def test_ranks_and_workers_have_each_frame_once(captures):
    from lumsdk.torch import StreamedFrames

    for world in (1, 2, 3, 5, 9):
        found = []
        for rank in range(world):
            stream = StreamedFrames(captures, transform=count)
            stream._rank, stream._world = rank, world
            part = [(capture, place) for capture, first, last in stream._parts()
                    for place in range(first, stream.counts[capture] if last is None else last)]
            assert len(list(stream)) == len(part)
            found += part
        assert sorted(found) == [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1)]


@pytest.mark.torch
@pytest.mark.parametrize("method", METHODS)
def test_what_fails_in_a_worker_names_the_capture(captures, method):
    from lumsdk.torch import Frames
    from torch.utils.data import DataLoader

    assert list(DataLoader(Frames(captures[1], transform=count), batch_size=None)) == [len(frame) for frame in want(captures[1:])]
    loader = DataLoader(Frames(captures, transform=fail), batch_size=None, num_workers=1, multiprocessing_context=method)
    with pytest.raises(lumsdk.Error, match=r"a\.pcap: frame 0: the transform failed: ZeroDivisionError: no luck"):
        list(loader)


@pytest.mark.torch
def test_a_capture_that_breaks_off_or_has_no_frames_is_told(captures, tmp_path):
    from lumsdk.torch import Frames, StreamedFrames

    cut, empty = tmp_path / "cut.pcap", tmp_path / "empty.pcap"
    with open(captures[0], "rb") as file:
        content = file.read()
    cut.write_bytes(content[:len(content) // 2])
    empty.write_bytes(content[:24])
    with pytest.raises(lumsdk.CaptureError, match=r"cut\.pcap"):
        len(Frames([captures[1], cut], columns=["x"]))
    with pytest.raises(lumsdk.CaptureError, match=r"cut\.pcap"):
        list(StreamedFrames(cut, transform=count))
    with pytest.warns(lumsdk.CaptureWarning, match=r"cut\.pcap"):
        assert 1 < len(Frames(cut, broken="warn")) < 4
    with pytest.warns(lumsdk.CaptureWarning, match=r"empty\.pcap: it has no frame, so it gives no item"):
        assert len(Frames([empty, captures[1]], transform=count)) == 2
    with pytest.warns(lumsdk.CaptureWarning, match=r"empty\.pcap: it has no frame"):
        assert len(list(StreamedFrames([empty, captures[1]], transform=count))) == 2


@pytest.mark.torch
def test_an_index_is_kept_on_request(captures, tmp_path):
    from lumsdk.torch import Frames

    path = tmp_path / "a.pcap"
    with open(captures[0], "rb") as file:
        path.write_bytes(file.read())
    assert len(Frames(path, transform=count)) == 4 and [each.name for each in tmp_path.iterdir()] == ["a.pcap"]
    assert len(Frames(path, transform=count, keep_index=True)) == 4
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.pcap", "a.pcap.lumindex"]
    assert len(Frames(str(tmp_path / "*.pcap"), transform=count)) == 4


@pytest.mark.torch
def test_what_is_not_right_is_refused_before_anything_is_read(captures):
    from lumsdk.torch import Frames

    for given, options, kind, said in (
            (b"", {}, TypeError, "a capture is given as bytes"), ([], {}, lumsdk.OptionError, "no capture is named"),
            ([[]], {}, lumsdk.OptionError, "a capture is an empty list"), ("no-*.pcap", {}, lumsdk.CaptureError, "no file has such a name"),
            (captures, {"columns": ["rnage"]}, lumsdk.OptionError, "did you mean 'range'"),
            (captures, {"progress": print}, TypeError, "progress is not an option here"),
            (captures, {"transform": 5}, TypeError, "use a function of a lumsdk.Frame")):
        with pytest.raises(kind, match=said):
            Frames(given, **options)
    frames = Frames([[captures[0], captures[1]], captures[0]], transform=count)
    assert frames.captures == (captures[0], captures[0])
    for index in (frames.counts[0] + 4, -99):
        with pytest.raises(IndexError, match="there is no item"):
            frames[index]
    with pytest.raises(IndexError, match="there is no capture 2: there are 2"):
        frames.at(2, 0)
    with pytest.raises(lumsdk.OptionError, match="there is no capture 'c.pcap'"):
        frames.at("c.pcap", 0)
