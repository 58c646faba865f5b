"""What a capture costs on its way out by every other door: files, pipes, a fleet, and what a stream or an import adds."""
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FLEET_CAPTURES, FLEET_FRAMES = 40, 2  # of 34 MB
PARQUET_BYTES = 18.96  # a point, before floats were split into bytes
LAZ_MB, IMPORT_S = 150, 0.012
PAUSE_S = 4  # so that each begins alike: a virtual machine gives the memory of removed files to its host

# Points to LAZ in memory by lazrs alone, without the time to read them: the best that a file of them can reach.
LAZ_ALONE = """
import sys, time, laspy, lazrs, numpy
with laspy.open(sys.argv[1]) as f:
    record = numpy.frombuffer(f.read().points.memoryview(), "u1")
    form = f.header.point_format
vlr = lazrs.LazVlr.new_for_compression(form.id, form.num_extra_bytes)
began = time.monotonic()
lazrs.compress_points(vlr, record, True)
print(time.monotonic() - began)
"""

CONVERT = "import sys, lumsdk; lumsdk.convert(sys.argv[1], sys.argv[2])"
# Python as a pipe's reader.
READER = "import sys\nto = bytearray(1 << 20)\nwhile sys.stdin.buffer.raw.readinto(to): pass"


def python_with(*modules):
    """A Python that has the modules, or None: this one or that of a venv of the build."""
    for python in sys.executable, ROOT / "build" / "venv" / "bin" / "python", ROOT / "build" / "readers" / "bin" / "python":
        if shutil.which(str(python)) and subprocess.run([python, "-c", f"import {', '.join(modules)}"], check=False,
                                                        stderr=subprocess.DEVNULL).returncode == 0:
            return python
    return None


class Doors:
    """The programs and the capture of one run."""

    def __init__(self, build, folder, capture, rounds, row):
        self.tools, self.bench, self.folder, self.capture = build / "bin", build / "bench", folder, capture
        self.rounds, self.row = rounds, row
        self.environment = {**os.environ, "PYTHONPATH": str(build / "python"), "PATH": f"{self.tools}{os.pathsep}{os.environ['PATH']}",
                            "PYTHONPYCACHEPREFIX": str(folder / "pycache")}
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)  # modules are compiled once, as an installation does
        self.cores = ",".join(map(str, sorted(os.sched_getaffinity(0))[-2:]))

    def timed(self, command, new, pause_s=0):
        """Wall and processor seconds, peak memory in MB, and what it printed. A new file or folder is removed before."""
        if new is not None and new.is_dir():
            shutil.rmtree(new)
        elif new is not None:
            new.unlink(missing_ok=True)
        if pause_s > 0:
            os.sync()
            time.sleep(pause_s)
        began = time.monotonic()
        process = subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=self.environment)
        out, err = process.stdout.read(), process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        wall = time.monotonic() - began
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"bench: {' '.join(map(str, command))}: {err}")
        return wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, out

    def medians(self, pause_s=0, **commands):
        """All in turn, after a round that does not count: name -> (wall, processor, peak), medians."""
        results = {name: [] for name in commands}
        for i in range(self.rounds + 1):
            for name, (command, new) in commands.items():
                result = self.timed(command, new, pause_s)
                if i > 0:
                    results[name].append(result[:3])
        return {name: tuple(statistics.median(values) for values in zip(*result)) for name, result in results.items()}

    def lumdump(self, *options):
        return ["taskset", "-c", self.cores, self.tools / "lumdump", self.capture, "--quiet", *options]

    def beside_write(self, what, command, out, bar):
        """A file made by a command, against write() and fsync() of as many bytes; its size and peak memory."""
        self.timed(command, out)
        size, plain = out.stat().st_size, self.folder / "plain"
        found = self.medians(ours=(command, out), plain=([self.bench / "yardstick", "write", size, plain], plain))
        ours, theirs = found["ours"], found["plain"]
        met = self.row(f"{what}: speed over write()'s", theirs[0] / ours[0], bar,
                       f"{ours[0]:.2f} s, processor {ours[1]:.2f} s, peak {ours[2]:.0f} MB; write() {theirs[0]:.2f} s of {size / 1e6:.0f} MB")
        for path in out, plain:
            path.unlink()
        return met, size, ours

    def mcap(self):
        met = []
        for name, bar in ("none", 0.6), ("zstd", 0.2):
            out = self.folder / "cloud.mcap"
            met.append(self.beside_write(f"mcap, {name}, by 2 threads", self.lumdump("--threads", "2", "--compression", name, "-o", out),
                                         out, bar)[0])
        return met

    def by_python(self):
        python = python_with("numpy", "pyarrow", "laspy", "lazrs", "cffi")
        if python is None:
            print("      npy, parquet and laz are not measured: no Python with pyarrow, laspy and lazrs (script/setup --all)")
            return []
        convert = ["taskset", "-c", self.cores, python, "-c", CONVERT, self.capture]
        out = {ending: self.folder / f"cloud.{ending}" for ending in ("npy", "parquet", "laz", "las")}
        met = [self.beside_write("npy by Python", [*convert, out["npy"]], out["npy"], 0.7)[0]]
        reached, size, _ = self.beside_write("parquet", [*convert, out["parquet"]], out["parquet"], 0.12)
        points = self.points()
        met += [reached, self.row(f"parquet: {PARQUET_BYTES} bytes over a point's", PARQUET_BYTES * points / size, 1,
                                  f"{size / points:.2f} bytes a point")]
        self.timed(self.lumdump("-o", out["las"]), out["las"])
        ours, alone = [], []
        for i in range(self.rounds + 1):
            theirs = float(self.timed(["taskset", "-c", self.cores, python, "-c", LAZ_ALONE, out["las"]], None)[3])
            mine = self.timed([*convert, out["laz"]], out["laz"])
            if i > 0:
                ours.append(mine)
                alone.append(theirs)
        wall, peak, best = (statistics.median(m[0] for m in ours), max(m[2] for m in ours), statistics.median(alone))
        out["las"].unlink()
        out["laz"].unlink()
        return [*met, self.row("laz: speed over lazrs's alone, of points in memory", best / wall, 0.8, f"{wall:.2f} s, lazrs {best:.2f} s"),
                self.row(f"laz: {LAZ_MB} MB over the peak", LAZ_MB / peak, 1, f"peak {peak:.0f} MB")]

    def points(self):
        told = json.loads(self.timed([self.tools / "lumdump", self.capture, "--json"], None)[3])
        return sum(sensor["points"] for sensor in told["sensors"])

    def pipes(self):
        met = []
        for ending in "ply", "csv":
            out = self.folder / f"cloud.{ending}"
            made = f"{self.tools}/lumdump {self.capture} --quiet --threads 2 --format {ending} -o -"
            found = self.medians(file=(self.lumdump("--threads", "2", "-o", out), out),
                                 **{name: (["taskset", "-c", self.cores, "sh", "-c", f"{made} | {reader}"], None) for name, reader in
                                    (("cat", "cat >/dev/null"), ("python", f"{sys.executable} -c '{READER}'"))})
            out.unlink()
            met += [self.row(f"{ending} into a pipe that {name} reads: over a file's", found["file"][0] / found[name][0], 0.9,
                             f"{found[name][0]:.2f} s, a file {found['file'][0]:.2f} s") for name in ("cat", "python")]
        return met

    def few_columns(self):
        out = self.folder / "cloud.ply"
        found = self.medians(all=(self.lumdump("--threads", "1", "-o", out), out),
                             few=(self.lumdump("--threads", "1", "--columns", "x,y,z", "-o", out), out))
        out.unlink()
        ratio = found["few"][1] / found["all"][1]
        return [self.row("ply of x y z: half of all columns over it, processor", 0.5 / ratio, 1, f"{ratio:.3f} of all columns")]

    def columns(self):
        times = {words: [] for words in ("1", "2", "4")}
        for _ in range(self.rounds):
            for words, few, every in re.findall(r"^(\d) .*: ([\d.]+) M points/s in frames of x y z, ([\d.]+) of",
                                                self.timed([self.bench / "bench_frame"], None)[3], re.M):
                times[words].append(float(few) / float(every))
        return [self.row(f"all columns, {words} words a pixel: {most} times over ours", most / statistics.median(found), 1,
                         f"{statistics.median(found):.2f} times x y z") for (words, found), most in zip(times.items(), (2.5, 3.5, 3.5))]

    def slow_streams(self):
        """A packet of a summary, of a stream of 0.2 Hz and of 10 Hz: as many frames, so as many packets."""
        commands, packets = {}, {}
        for name, hz in ("slow", "0.2"), ("fast", "10"):
            path = self.folder / f"{name}.pcap"
            self.timed([self.tools / "lumsim", "-o", path, "--frames", "60", "--rate", hz, "--quiet"], path)
            packets[name] = json.loads(self.timed([self.tools / "lumdump", path, "--json"], None)[3])["records"]
            commands[name] = ([self.tools / "lumdump", path, "--json"], None)
        found = self.medians(**commands)
        ratio = found["slow"][1] / packets["slow"] / (found["fast"][1] / packets["fast"])
        for command, _ in commands.values():
            command[1].unlink()
        return [self.row("a packet of 0.2 Hz: 1.1 of one of 10 Hz over it", 1.1 / ratio, 1, f"{ratio:.3f} times the processor time")]

    def imports(self):
        python = python_with("numpy", "cffi")
        if python is None:
            print("      import lumsdk is not measured: no Python with NumPy (Debian: python3-numpy)")
            return []
        code = "import time, numpy; began = time.perf_counter(); import lumsdk; lumsdk.open; print(time.perf_counter() - began)"
        seconds = statistics.median(float(self.timed([python, "-c", code], None)[3]) for _ in range(3 * self.rounds + 1))
        return [self.row("import lumsdk beyond NumPy: 12 ms over it", IMPORT_S / seconds, 1, f"{seconds * 1e3:.1f} ms")]

    def fleet(self):
        """Captures to LAS by lumfleet, its start and end included, against xargs of lumdump."""
        python = python_with("pyarrow", "numpy", "cffi")
        if python is None:
            print("      lumfleet is not measured: no Python with pyarrow (script/setup --all)")
            return []
        drives, out = self.folder / "drives", self.folder / "clouds"
        drives.mkdir()
        first = drives / "00.pcap"
        self.timed([self.tools / "lumsim", "-o", first, "--frames", FLEET_FRAMES, "--lines", "640", "--quiet"], first)
        for i in range(1, FLEET_CAPTURES):
            shutil.copy(first, drives / f"{i:02}.pcap")
        by_hand = f"mkdir {out}; ls {drives} | sed 's/.pcap$//' | xargs -P2 -I@ lumdump {drives}/@.pcap --quiet -o {out}/@.las"
        found = self.medians(PAUSE_S, fleet=([python, "-m", "lumsdk.fleet.main", drives, "--out", out, "--format", "las", "--quiet"], out),
                             xargs=(["sh", "-c", by_hand], out))
        shutil.rmtree(drives)
        shutil.rmtree(out)
        fleet, xargs = found["fleet"], found["xargs"]
        return [self.row("lumfleet to las: speed over xargs -P2 lumdump", xargs[0] / fleet[0], 0.85,
                         f"{fleet[0]:.1f} s, xargs {xargs[0]:.1f} s of {FLEET_CAPTURES} captures")]


def run(build, folder, capture, rounds, row):
    """Measures, prints, and returns what was met. row(WHAT, RATIO, BAR, DETAIL) prints one."""
    doors = Doors(build.resolve(), folder, capture, rounds, row)
    print("\n(k) capture to file by two threads or by Python, against write() and fsync() of as many bytes:")
    met = [*doors.mcap(), *doors.by_python()]
    print("\n(l) into a pipe, against a file:")
    met += doors.pipes()
    print("\n(m) columns that nobody asked for, and all of them, against x y z alone, in processor time:")
    met += [*doors.few_columns(), *doors.columns()]
    print("\n(n) a slow stream, an import, a fleet:")
    return [*met, *doors.slow_streams(), *doors.imports(), *doors.fleet()]
