"""torch_loader CAPTURE...: frames a second that a DataLoader of torch gives of lumsdk.torch, by how many workers, in this run.

The first column is a loop over lumsdk.open() in this process. Each number is the median of three passes of a second and more;
workers are persistent, and the first pass, which starts them, does not count. docs/python/export.md has what came out."""
import os
import statistics
import sys
import time
import warnings

try:
    import lumsdk
    import numpy as np
    import torch
    from lumsdk.torch import Frames, StreamedFrames, collate
    from torch.utils.data import DataLoader
except ImportError as e:
    sys.exit(f"bench: --workers needs a Python with torch, NumPy and cffi (Debian: python3-torch python3-cffi): {e}")

PASSES, PASS_S = 3, 1.0
COLUMNS = ["xyz", "range"]


def passes(read):
    read()
    rates = []
    for _ in range(PASSES):
        began, frames, took = time.monotonic(), 0, 0.0
        while took < PASS_S:
            frames += read()
            took = time.monotonic() - began
        rates.append(frames / took)
    return statistics.median(rates)


def loop(paths):
    return sum(1 for path in paths for frame in lumsdk.open(path, columns=["x", "y", "z", "range"]) if len(frame))


def loaded(data, workers, method, **options):
    loader = DataLoader(data, num_workers=workers, multiprocessing_context=method, persistent_workers=workers > 0,
                        collate_fn=collate, batch_size=2, **options)
    return passes(lambda: sum(len(batch["row_splits"]) - 1 for batch in loader))


def picture(frame):
    """Work such as a data set does for a network: six pictures, and a count."""
    near = frame["range"] < 50
    return {"range": torch.from_numpy(np.concatenate([frame.image("range", eye, returns) for eye in ("blue", "green")
                                                      for returns in ("nearest", "farthest", "first")], axis=1)),
            "points": int(near.sum())}


def main(paths):
    warnings.simplefilter("ignore", UserWarning)  # of more workers than cores
    base = passes(lambda: loop(paths))
    print(f"cores {os.cpu_count()}, captures {len(paths)}; a loop over open(): {base:.1f} frames/s")
    frames, stream = Frames(paths, columns=COLUMNS, keep_index=True), StreamedFrames(paths, columns=COLUMNS, keep_index=True)
    len(frames)
    for name, data, options in (("Frames, shuffled", frames, {"shuffle": True}), ("StreamedFrames", stream, {}),
                                ("Frames, pictures", Frames(paths, transform=picture, keep_index=True), {"shuffle": True})):
        for workers, method in ((0, None), *((n, m) for m in ("fork", "spawn") for n in (1, 2, 4))):
            rate = loaded(data, workers, method, **options)
            print(f"{name:18} {workers} {method or '-':6} {rate:6.1f} frames/s  {rate / base:5.2f} of the loop", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
