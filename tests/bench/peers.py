"""Captures to x y z in NumPy: lumsdk beside the packages of other makers, and beside its own loop in C."""
import os
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
VENV = HERE.parents[1] / "build" / "venv-peers"
PACKAGES = ("ouster-sdk==1.0.1", "velodyne-decoder==3.1.0", "cffi", "PyYAML")
NEEDS = ("bench/bench_read", "bench/bench_frame", "python/lumsdk/__init__.py")

FRAMES = 48  # of 640 lines, both eyes
TINY_FRAMES = 10_000
FASTER, FASTER_IN_C, OF_C, OVERHEAD_S, IMPORT_S, GROWTH_MB = 2.0, 2.2, 0.85, 0.2e-3, 0.15, 4.0

# How many points a frame or a packet of each capture has.
CAPTURES = {"ouster-one": 128 * 2048, "ouster-low": 128 * 2048, "ouster-two": 2 * 128 * 2048, "velodyne": 12 * 32}

# What is read, how, the name, and whether the bar is for it.
PEERS = (("ouster", "ouster-one", "ouster-sdk, one return a pixel", True),
         ("ouster", "ouster-low", "ouster-sdk, low data rate", True),
         ("ouster", "ouster-two", "ouster-sdk, two returns a pixel", True),
         ("ouster-ranges", "ouster-one", "only ranges, XYZLutFloat, one return", False),
         ("ouster-ranges", "ouster-two", "only ranges, XYZLutFloat, two returns", False),
         ("velodyne", "velodyne", "velodyne-decoder, VLP-16", False))


def install():
    """A venv of its own, and the Python in it."""
    python = VENV / "bin" / "python"
    done = VENV / "packages.txt"
    if not done.is_file() or done.read_text().split() != list(PACKAGES):
        print(f"installing {', '.join(PACKAGES)} into {VENV}", flush=True)
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", *PACKAGES], check=True)
        done.write_text("\n".join(PACKAGES) + "\n")
    return python


class Worker:
    """A process that does its work again for each line that it gets: wall and processor seconds, and a count."""

    def __init__(self, command, task="again", **environment):
        self.task = task
        self.process = subprocess.Popen([str(part) for part in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True, env={**os.environ, **environment})

    def run(self):
        self.process.stdin.write(self.task + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().split()
        if len(answer) != 3:
            sys.exit(f"bench: {' '.join(map(str, self.process.args))} broke off")
        return float(answer[0]), float(answer[1]), int(answer[2])

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def rounds_of(workers, rounds):
    """All workers in turn, after a round that does not count: name -> (wall, processor, count), medians."""
    results = {name: [] for name in workers}
    for i in range(rounds + 1):
        for name, worker in workers.items():
            result = worker.run()
            if i > 0:
                results[name].append(result)
    for worker in workers.values():
        worker.close()
    return {name: tuple(statistics.median(r[k] for r in result) for k in range(3)) for name, result in results.items()}


class Bench:
    """The programs and captures of one run."""

    def __init__(self, build, folder, rounds):
        self.build, self.folder, self.rounds = build, folder, rounds
        self.python = install()

    def loop(self, name, capture):
        return Worker([self.python, "-B", HERE / "peer_loop.py", name, capture], PYTHONPATH=str(self.build / "python"))

    def in_c(self, task):
        return Worker([self.build / "bench" / "bench_read"], task)

    def make(self, name, count):
        path = self.folder / f"{name}.pcap"
        subprocess.run([self.python, "-B", HERE / "peer_captures.py", name, path, str(count)], check=True)
        return path

    def street(self):
        path = self.folder / "street.pcap"
        subprocess.run([self.build / "bin" / "lumsim", "-o", path, "--frames", str(FRAMES), "--lines", "640", "--seed", "7",
                        "--quiet"], check=True)
        return path


def machine():
    """What it runs on, in a line."""
    text = pathlib.Path("/proc/cpuinfo").read_text() if os.path.exists("/proc/cpuinfo") else ""
    model = re.search(r"model name\s*: (.*)", text)
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{model.group(1) if model else platform.processor()}, {os.cpu_count()} cores, Python {platform.python_version()}{load}"


def rate(result, by=0):
    """Millions a second, of wall or processor time."""
    return result[2] / result[by] / 1e6


def speeds(bench, row):
    """pcap to x y z, all in one series of rounds."""
    street = bench.street()
    count = bench.in_c(f"frames {street}")
    points = count.run()[2]
    count.close()
    captures = {name: bench.make(name, round(points / each)) for name, each in CAPTURES.items()}
    workers = {"ours": bench.loop("lumsdk", street), "c": bench.in_c(f"frames {street}"),
               "c2": bench.in_c(f"threads {street}"), "read": bench.in_c(f"read {street}"),
               "memcpy": bench.in_c("memcpy")}
    workers.update({title: bench.loop(name, captures[capture]) for name, capture, title, _ in PEERS})
    results = rounds_of(workers, bench.rounds)
    ours = results["ours"]
    sizes = {"ours": street.stat().st_size, **{title: captures[capture].stat().st_size for _, capture, title, _ in PEERS}}
    print(f"{points / 1e6:.1f} million points; pcap in the page cache to x y z in NumPy, medians of {bench.rounds} rounds\n")
    print(f"      {'':44} {'Mpoints/s':>10} {'by processor':>13} {'bytes a point':>14}")
    for name, title in (("ours", "lumsdk"), ("c2", "the same loop in C, 2 threads"), ("c", "in C, 1 thread"), *((t, t) for _, _, t, _ in PEERS)):
        size = sizes.get(name, sizes["ours"])
        print(f"      {title:44} {rate(results[name]):10.1f} {rate(results[name], 1):13.1f} {size / results[name][2]:14.1f}")
    print(f"      memcpy() of 64 MiB: {rate(results['memcpy']) / 1e3:.1f} GB/s; read() of our capture:"
          f" {rate(results['read']) / 1e3:.1f} GB/s\n")
    met = [row("lumsdk against the same loop in C", rate(ours) / rate(results["c2"]), OF_C,
               f"by processor time {rate(ours, 1) / rate(results['c2'], 1):.3f}")]
    for _, _, title, has_bar in PEERS:
        theirs = results[title]
        met.append(row(f"lumsdk against {title}", rate(ours) / rate(theirs), FASTER if has_bar else 0,
                       f"by processor time {rate(ours, 1) / rate(theirs, 1):.3f}"))
        if has_bar:
            met.append(row(f"C, 2 threads, against {title}", rate(results["c2"]) / rate(theirs), FASTER_IN_C,
                           f"1 thread {rate(results['c']) / rate(theirs):.3f}"))
    for path in (street, *captures.values()):
        path.unlink()
    return met


def from_memory(bench, row):
    """Datagrams in memory to frames of x y z, one word a pixel, beside Ouster's ranges of packets in memory."""
    theirs, ours, worker = [], [], bench.loop("ouster-memory", 16)
    for i in range(bench.rounds + 1):
        theirs.append(rate(worker.run(), 1))
        text = subprocess.run([bench.build / "bench" / "bench_frame", "1"], check=True, capture_output=True, text=True).stdout
        ours.append(float(re.search(r"([\d.]+) M points/s in frames of x y z", text)[1]))
    worker.close()
    ours, theirs = statistics.median(ours[1:]), statistics.median(theirs[1:])
    return [row("memory to x y z, a word a pixel, against Ouster's ranges", ours / theirs, 1,
                f"{ours:.0f} of {theirs:.0f} M points/s, by processor time")]


def overhead(bench, row):
    """Tiny frames: what Python adds to each, and memory."""
    tiny = bench.make("tiny", TINY_FRAMES)
    results = rounds_of({"ours": bench.loop("lumsdk", tiny), "c": bench.in_c(f"frames {tiny}")}, bench.rounds)
    each = [(results["ours"][k] - results["c"][k]) / TINY_FRAMES for k in range(2)]
    worker = bench.loop("memory", tiny)
    early, late, frames = worker.run()
    worker.close()
    tiny.unlink()
    if frames != TINY_FRAMES:
        sys.exit(f"bench: {frames} frames and not {TINY_FRAMES}")
    return [row("0.2 ms over what Python adds to a frame", OVERHEAD_S / each[0], 1,
                f"{each[0] * 1e6:.1f} us, by processor time {each[1] * 1e6:.1f} us"),
            row(f"{GROWTH_MB:g} MB over the growth in {frames} frames", GROWTH_MB / max(late - early, 1e-3), 1,
                f"{early:.1f} MB after {frames // 10}, {late:.1f} MB at the end")]


def imports(bench, row):
    """import lumsdk, NumPy included, against a Python that imports nothing."""
    seconds = {"import lumsdk": [], "import numpy": [], "pass": []}
    for i in range(bench.rounds + 1):
        for code, list_of in seconds.items():
            began = time.monotonic()
            subprocess.run([bench.python, "-c", code], check=True, env={**os.environ, "PYTHONPATH": str(bench.build / "python")})
            if i > 0:
                list_of.append(time.monotonic() - began)
    lumsdk, numpy, nothing = (statistics.median(s) for s in seconds.values())
    return [row("0.15 s over the time of import lumsdk", IMPORT_S / (lumsdk - nothing), 1,
                f"{lumsdk - nothing:.3f} s, of these NumPy {numpy - nothing:.3f} s")]


def run(build, folder, rounds, row):
    """Measures, prints, and returns what was met. row(WHAT, RATIO, BAR, DETAIL) prints one."""
    bench = Bench(build.resolve(), folder, rounds)
    print(machine())
    return [*speeds(bench, row), *from_memory(bench, row), *overhead(bench, row), *imports(bench, row)]
