"""scale.py COUNT BUILD FOLDER: lumfleet over COUNT captures of a few kilobytes, for script/soak fleet-scale.

Prints a line for each run: the first, one with nothing left to do, and --dry-run: seconds, captures a second, and the most
memory and the processor time of the driver, which is the process that holds the plan. Then, for a few large captures,
processor seconds of lumdump for each gigabyte, and gigabytes a second.
"""
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time

LARGE = 4  # captures of 209 MB


def tool(build, name, *arguments):
    subprocess.run([build / "bin" / name, *map(str, arguments)], check=True)


def make_small(build, folder, count):
    """A thousand in a folder; the first record of each has a time of its own. Returns the bytes of all."""
    whole, small = folder.parent / "whole.pcap", folder.parent / "small.pcap"
    tool(build, "lumsim", "-q", "-o", whole, "--frames", 1)
    tool(build, "lumdump", "-q", whole, "--duration", "0.001", "-o", small)
    data = bytearray(small.read_bytes())
    for i in range(count):
        path = folder / f"day{i // 1000:04}" / f"drive{i:07}.pcap"
        path.parent.mkdir(parents=True, exist_ok=True)
        struct.pack_into("<I", data, 24 + 4, i % 1_000_000)
        path.write_bytes(data)
    return count * len(data)


class Driver:
    """What a process took so far, by /proc."""

    def __init__(self, pid):
        self.folder, self.peak_mb, self.processor_s = pathlib.Path("/proc", str(pid)), 0.0, 0.0

    def look(self):
        try:
            status = (self.folder / "status").read_text()
            times = (self.folder / "stat").read_text().rpartition(")")[2].split()[11:13]
        except OSError:
            return
        for line in status.splitlines():
            if line.startswith("VmHWM:"):
                self.peak_mb = int(line.split()[1]) / 1024
        self.processor_s = sum(map(int, times)) / os.sysconf("SC_CLK_TCK")


def lumfleet(build, *arguments):
    """A run: its seconds, and what the driver took."""
    environment = {**os.environ, "LUM_BIN": str(build / "bin"), "PYTHONPATH": str(build / "python"), "RAY_USAGE_STATS_ENABLED": "0"}
    began = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen([sys.executable, "-B", "-m", "lumsdk.fleet.main", *map(str, arguments), "--json", "-q"],
                                   stdout=subprocess.DEVNULL, stderr=said, env=environment)
        driver = Driver(process.pid)
        while process.poll() is None:
            driver.look()
            time.sleep(0.05)
        seconds = time.monotonic() - began
        said.seek(0)
        if process.returncode != 0:
            sys.exit(f"scale: lumfleet ended with status {process.returncode}: {said.read()[-2000:]}")
    return seconds, driver


def small_ones(build, folder, count):
    captures, out = folder / "small", folder / "made"
    size = make_small(build, captures, count)
    print(f"{count} captures of {size / count / 1e3:.0f} KB, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    for what, *arguments in (("converted",), ("nothing left to do",), ("--dry-run --again", "--dry-run", "--again")):
        seconds, driver = lumfleet(build, captures, "--out", out, "--format", "las", *arguments)
        print(f"  {what:20} {seconds:8.1f} s  {count / seconds:9.1f} captures/s  driver {driver.peak_mb:7.1f} MB,"
              f" {driver.processor_s:.1f} s of its processor time", flush=True)
    manifest = (out / "manifest.parquet").stat().st_size
    print(f"  manifest {manifest / 1e6:.1f} MB, {manifest / count:.0f} bytes a capture")
    shutil.rmtree(captures)
    shutil.rmtree(out)


def large_ones(build, folder):
    captures, out = folder / "large", folder / "made"
    captures.mkdir()
    for i in range(LARGE):
        tool(build, "lumsim", "-q", "-o", captures / f"{i}.pcap", "--frames", 12, "--lines", 640, "--seed", i + 1)
    size = sum(path.stat().st_size for path in captures.iterdir())
    print(f"{LARGE} captures of {size / LARGE / 1e6:.0f} MB; lumdump alone, one after another, by its processor time:")
    for ending in ("las", "ply"):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        made = 0
        for path in captures.iterdir():
            tool(build, "lumdump", "-q", path, "-o", folder / f"cloud.{ending}")
            made += (folder / f"cloud.{ending}").stat().st_size
            (folder / f"cloud.{ending}").unlink()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print(f"  {ending}: {spent / size * 1e9:.2f} s for each GB, {made / size:.2f} bytes of output for each byte", flush=True)
    seconds, driver = lumfleet(build, captures, "--out", out, "--format", "las")
    print(f"  lumfleet to las: {seconds:.1f} s with its start, {size / seconds / 1e9:.2f} GB/s, driver {driver.peak_mb:.0f} MB")


def main(count, build, folder):
    build = pathlib.Path(build).resolve()
    with tempfile.TemporaryDirectory(dir=folder) as tmp:
        small_ones(build, pathlib.Path(tmp), int(count))
        large_ones(build, pathlib.Path(tmp))


if __name__ == "__main__":
    main(*sys.argv[1:])
