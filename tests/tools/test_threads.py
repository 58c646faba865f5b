"""lumdump with several threads: what it writes and says is that of one thread."""
import json
import os
import pathlib
import re
import resource
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import shards
from support import BIN, PATIENCE_S, Folder, run, simulate, summary

THREADS = ("2", "4", "7")

# What is written, and how its lines are chosen. The last three count a line's points before it is handed on.
CLOUDS = [("csv", []), ("ply", []), ("pcd", []), ("xyz", []), ("ply", ["--ascii"]), ("pcd", ["--ascii"]),
          ("csv", ["--columns", "pixel,x,frame,line,timestamp", "--comments"]), ("ply", ["--columns", "z,y,x,edge"]),
          ("csv", ["--edge", "both", "--time", "arrival"]), ("ply", ["--edge", "falling", "--time", "utc"]),
          ("csv", ["--smooth", "31", "--eye", "green"]), ("xyz", ["--incomplete", "drop", "--frames", "2:3"]),
          ("csv", ["--return", "strongest"]), ("ply", ["--range", "5:40", "--smooth", "9"]),
          ("pcd", ["--box", ":,-10:10,:3", "--edge", "both"])]


def rows_of(ply):
    """The columns of a binary PLY by their names."""
    head, _, body = ply.partition(b"end_header\n")
    properties = [line.split()[1:] for line in head.decode().splitlines() if line.startswith("property ")]
    codes = {"float": "f", "double": "d", "int": "i", "uint16": "H", "uchar": "B"}
    columns = zip(*struct.iter_unpack("<" + "".join(codes[kind] for kind, _ in properties), body))
    return {name.removeprefix("scalar_"): values for (_, name), values in zip(properties, columns)}


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.captures = pathlib.Path(folder.name)
        cls.many = simulate(cls.captures / "many.pcap", "--frames", "4", "--lines", "64", "--returns-max", "6", "--seed", "3")
        cls.bad = simulate(cls.captures / "bad.pcap", "--frames", "4", "--lines", "64", "--loss", "0.05", "--duplicate", "0.05",
                           "--seed", "4")
        cls.cut = cls.captures / "cut.pcap"
        cls.cut.write_bytes(cls.many.read_bytes()[:-70_001])
        cls.dense = simulate(cls.captures / "dense.pcap", "--frames", "1", "--lines", "640", "--seed", "5")

    def setUp(self):
        self.folder = Folder(self)

    def written(self, threads, *arguments, status=0, **options):
        """What a run has left in its folder, and what it said; the names of its outputs do not differ."""
        r = run("lumdump", *arguments, "--threads", threads, cwd=self.folder.path, **options)
        self.assertEqual(r.returncode, status, r.stderr)
        files = {}
        for name in self.folder.names():
            files[name] = (self.folder / name).read_bytes()
            (self.folder / name).unlink()
        return files, r.stdout_bytes, re.sub(r"\r[^\n]*\r", "", r.stderr)

    def same(self, *arguments, **options):
        want = self.written("1", *arguments, **options)
        for threads in THREADS:
            with self.subTest(threads=threads, arguments=arguments[1:]):
                got = self.written(threads, *arguments, **options)
                self.assertEqual(sorted(got[0]), sorted(want[0]))
                self.assertEqual(got[2], want[2])
                # a difference of megabytes is not to be shown
                self.assertTrue(got == want, "the bytes differ")
        return want


class Same(Case):
    def test_every_cloud_of_every_capture(self):
        for ending, options in CLOUDS:
            for source in self.many, self.bad, self.cut:
                files, _, said = self.same(source, "-o", f"out.{ending}", *options)
                self.assertGreater(len(files[f"out.{ending}"]), 20_000)
                self.assertEqual("warning" in said, source is self.cut, said)

    def test_a_column_alone_is_that_of_the_whole_file(self):
        whole = rows_of(self.written("1", self.many, "-o", "out.ply", "--edge", "both")[0]["out.ply"])
        for names in "x,y,z", "z,azimuth,frame", "number_of_returns,x,edge,eye", "timestamp,pulse_width,line,pixel,range":
            files, _, _ = self.same(self.many, "-o", "out.ply", "--edge", "both", "--columns", names)
            some = rows_of(files["out.ply"])
            self.assertEqual(len(some), len(names.split(",")))
            for name, values in some.items():
                self.assertTrue(values == whole[name], f"{name} of {names} differs")

    def test_what_takes_many_batches(self):
        for ending in "csv", "ply":
            files, _, _ = self.same(self.dense, "-o", f"out.{ending}")
            self.assertGreater(len(files[f"out.{ending}"]), 40_000_000)

    def test_what_one_thread_does_anyway(self):
        for ending, options in (("las", []), ("pcap", []), ("png", ["--frames", "2:2"]), ("mcap", []),
                                ("csv", ["--columns", "x,y,z,time"]), ("ply", ["--preset", "autoware"])):
            self.same(self.many, "-o", f"out.{ending}", *options)
        self.same(self.many, "-o", "out.csv", "-o", "out.ply")
        self.same(self.many, "-o", "out.csv", "--rotate", "1MB")
        self.same(self.many, "-o", "f-%d.pcd", "--organized", "--return", "last")

    def test_a_file_a_frame(self):
        for source in self.many, self.bad:
            files, _, _ = self.same(source, "-o", "f-%04d.csv")
            self.assertEqual(sorted(files), [f"f-000{n}.csv" for n in (1, 2, 3, 4)])
            self.same(source, "-o", "f-%d.ply", "--return", "last")

    def test_pipes(self):
        data = self.many.read_bytes()
        self.same("-", "-o", "out.ply", stdin=data)
        self.same("-", "-o", "f-%d.csv", stdin=data)
        _, out, _ = self.same("-", "-o", "-", "--format", "csv", stdin=data)
        self.assertGreater(len(out), 4_000_000)
        self.same(self.many, "-o", "-", "--format", "ply")

    def test_the_summary(self):
        for source in self.many, self.bad, self.cut:
            for options in [], ["--range", "5:40"]:
                _, out, _ = self.same(source, "--json", "-o", "out.csv", *options)
                self.assertGreater(json.loads(out)["points"], 10_000)

    def test_no_threads_given_is_the_same_too(self):
        self.assertEqual(run("lumdump", self.many, "-o", self.folder / "out.csv").returncode, 0)
        own = (self.folder / "out.csv").read_bytes()
        (self.folder / "out.csv").unlink()
        self.assertTrue(self.written("1", self.many, "-o", "out.csv")[0] == {"out.csv": own})


class Faults(Case):
    def test_a_full_device(self):
        for kind in "csv", "xyz", "ply":
            said = set()
            for threads in ("1", *THREADS):
                with open("/dev/full", "wb") as full:
                    r = subprocess.run([BIN / "lumdump", self.many, "-o", "-", "--format", kind, "--threads", threads],
                                       stdout=full, stderr=subprocess.PIPE, timeout=PATIENCE_S)
                self.assertEqual(r.returncode, 1, r.stderr)
                said.add(r.stderr)
            self.assertEqual(said, {b"lumdump: standard output: cannot write: No space left on device; free some space or "
                                    b"write elsewhere\n"})

    def test_a_file_that_cannot_grow(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))
        for name in "out.csv", "out.ply", "f-%d.csv":
            files, _, said = self.same(self.dense, "-o", name, status=1, preexec_fn=limit, restore_signals=False)
            self.assertEqual(files, {})
            self.assertIn("cannot write: File too large", said)

    def test_a_frames_file_that_cannot_be_made(self):
        (self.folder / "f-3.csv").mkdir()
        for threads in ("1", *THREADS):
            r = run("lumdump", self.many, "-o", self.folder / "f-%d.csv", "--threads", threads)
            self.assertEqual(r.returncode, 1)
            self.assertIn("f-3.csv: is a directory; name a file in it", r.stderr)
            self.assertFalse((self.folder / "f-4.csv").exists())

    def test_a_reader_that_leaves_ends_it_quietly(self):
        for kind in "csv", "ply":
            for threads in ("1", *THREADS):
                r = subprocess.run(f"'{BIN}/lumdump' '{self.dense}' -o - --format {kind} --threads {threads} | head -c 100 | "
                                   "wc -c; echo ${PIPESTATUS[0]}", shell=True, executable="/bin/bash", capture_output=True,
                                   text=True, timeout=PATIENCE_S)
                self.assertEqual((r.stdout.split(), r.stderr), (["100", "0"], ""))

    def interrupted(self, threads, number, after):
        """A run into a pipe that is interrupted when this many bytes were read; all bytes of it."""
        with subprocess.Popen([BIN / "lumdump", self.dense, "-o", "-", "--format", "csv", "-q", "--threads", threads],
                              stdout=subprocess.PIPE) as p:
            got = p.stdout.read(after)
            p.send_signal(number)
            got += p.stdout.read()
            self.assertEqual(p.wait(PATIENCE_S), -number)
        return got

    def test_an_interrupt_leaves_the_begin_of_what_would_have_come(self):
        whole = self.written("1", self.dense, "-o", "out.csv")[0]["out.csv"]
        for number in signal.SIGINT, signal.SIGTERM:
            for threads in THREADS:
                with self.subTest(threads=threads, number=number):
                    got = self.interrupted(threads, number, 3_000_000)
                    self.assertTrue(whole.startswith(got))
                    self.assertLess(len(got), len(whole))

    def test_an_interrupt_leaves_no_file(self):
        data = self.many.read_bytes()
        for threads in THREADS:
            for name in "out.csv", "f-%d.ply":
                with subprocess.Popen([BIN / "lumdump", "-", "-o", self.folder / name, "--threads", threads],
                                      stdin=subprocess.PIPE, stderr=subprocess.PIPE) as p:
                    p.stdin.write(data)
                    p.stdin.flush()
                    self.wait_for(lambda: any(n.endswith(".part") for n in self.folder.names()))
                    p.send_signal(signal.SIGINT)
                    self.assertEqual(p.wait(PATIENCE_S), -signal.SIGINT)
                for n in self.folder.names():  # of whole frames
                    self.assertRegex(n, r"^f-[123]\.ply$")
                    (self.folder / n).unlink()

    def test_a_frame_has_its_file_while_the_next_is_waited_for(self):
        data = self.many.read_bytes()
        for threads in ("1", *THREADS):
            with subprocess.Popen([BIN / "lumdump", "-", "-q", "-o", self.folder / "f-%d.csv", "--threads", threads],
                                  stdin=subprocess.PIPE) as p:
                p.stdin.write(data)
                p.stdin.flush()
                self.wait_for(lambda: {"f-1.csv", "f-2.csv", "f-3.csv"} <= set(self.folder.names()))
                self.assertFalse((self.folder / "f-4.csv").exists())
                p.stdin.close()
                self.assertEqual(p.wait(PATIENCE_S), 0)
            for n in 1, 2, 3, 4:
                (self.folder / f"f-{n}.csv").unlink()

    def wait_for(self, what):
        end = time.monotonic() + PATIENCE_S
        while not what():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)


class Threads(Case):
    def count(self, least, *arguments):
        """Threads of a run whose output nobody reads, when there are so many at least and it does not get any further. One
        writes into the pipe, and an instrument may have its own."""
        end = time.monotonic() + PATIENCE_S
        with subprocess.Popen([BIN / "lumdump", *arguments, "-q", "-o", "-", "--format", "csv"],
                              stdout=subprocess.PIPE) as p:
            folder = pathlib.Path(f"/proc/{p.pid}/task")
            seen = []
            while len(seen) < 20 or len(set(seen[-20:])) > 1 or seen[-1][0] < least and time.monotonic() < end:
                seen.append((len(list(folder.iterdir())), self.processor(folder)))
                time.sleep(0.02)
            p.kill()
            p.stdout.read()
        return seen[-1][0]

    @staticmethod
    def processor(folder):
        return sum(sum(map(int, (t / "stat").read_text().rpartition(")")[2].split()[11:13])) for t in folder.iterdir())

    def test_there_are_as_many_as_asked_for(self):
        others = self.count(2, self.dense, "--threads", "1") - 1
        self.assertGreaterEqual(others, 1)
        for threads in 2, 4, 7:
            self.assertEqual(self.count(threads + others, self.dense, "--threads", str(threads)), threads + others)

    def test_by_default_they_are_as_many_as_the_cores(self):
        cores = min(len(os.sched_getaffinity(0)), 8)
        others = self.count(2, self.dense, "--threads", "1") - 1
        self.assertEqual(self.count(cores + others, self.dense), cores + others)
        one = next(iter(os.sched_getaffinity(0)))
        own = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {one})
        self.addCleanup(os.sched_setaffinity, 0, own)
        self.assertEqual(self.count(1 + others, self.dense), 1 + others)

    def test_wrong_numbers_are_refused(self):
        for value in "0", "65", "-1", "x", "":
            r = run("lumdump", self.many, "--threads", value)
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn("whole number from 1 to 64", r.stderr)

    def test_a_sensor_has_its_own(self):
        r = run("lumdump", "udp://127.0.0.1", "--threads", "2", "-o", self.folder / "out.csv")
        self.assertEqual((r.returncode, r.stderr), (2, "lumdump: --threads goes with captures: of a sensor each output has a "
                                                       "thread of its own\n"))

    def test_a_summary_has_nothing_for_them(self):
        self.assertEqual(summary(self.many), summary(self.many, "--threads", "4"))


if __name__ == "__main__":
    shards.main()
