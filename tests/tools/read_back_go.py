#!/usr/bin/env python3
"""MCAP files of lumdump, read by Foxglove's library for Go (tests/mcap_go): whole ones, those that are cut, damaged, or of
a recording that was killed. What it reads of a file is what lumdump reads."""
import hashlib
import itertools
import json
import pathlib
import signal
import subprocess
import unittest

import mcap_maker
from live import Sensor, tool, wait_until
from support import Folder, frames_of, run, simulate

LOOK = pathlib.Path("build/mcap-go/mcap_look").resolve()
ADDRESSES = (f"127.22.0.{i}" for i in itertools.count(1))
PLAIN = ("--compression", "none")


def look(*paths):
    done = subprocess.run([LOOK, *paths], capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def make(self, name, *arguments, frames=2):
        source = simulate(self.folder / "street.pcap", "--frames", str(frames), "--seed", "5")
        r = run("lumdump", source, "-o", self.folder / name, "-q", *arguments)
        self.assertEqual(r.returncode, 0, r.stderr)
        return self.folder / name

    def datagrams(self, path):
        """As many as lumdump reads of it."""
        r = run("lumdump", path, "--json", "-q")
        return json.loads(r.stdout)["data"] if r.stdout else 0


class Whole(Case):
    def test_each_kind_of_contents(self):
        for contents, compression in itertools.product(("frames", "lines", "packets", "frames,packets"), ("zstd", "none")):
            with self.subTest(contents=contents, compression=compression):
                (seen,) = look(self.make("a.mcap", "--mcap", contents, "--compression", compression))
                self.assertEqual((seen["error"], seen["whole"]), ("", True))
                self.assertEqual({t: n for t, n in seen["statistics"].items() if n}, seen["messages"])
                self.assertEqual("/datagrams" in seen["messages"], "packets" in contents)
                self.assertEqual("/points" in seen["messages"], contents != "packets")

    def test_datagrams_are_those_of_the_capture(self):
        (seen,) = look(self.make("a.mcap", "--mcap", "packets"))
        capture = (self.folder / "street.pcap").read_bytes()
        want = hashlib.sha256()
        for ns, frame in zip(mcap_maker.times_of(capture), frames_of(capture)):
            want.update(mcap_maker.datagram(ns, frame))
        self.assertEqual(seen["sha256"]["/datagrams"], want.hexdigest())


class Broken(Case):
    def test_a_file_that_is_cut_gives_its_whole_chunks(self):
        for compression in "zstd", "none":
            data = self.make("a.mcap", "--mcap", "packets", "--compression", compression, frames=8).read_bytes()
            counts = set()
            for n in (len(data) * k // 30 for k in range(1, 30)):
                path = self.folder.write("cut.mcap", data[:n])
                (seen,) = look(path)
                self.assertFalse(seen["whole"])
                self.assertTrue(seen["error"])
                count = seen["messages"].get("/datagrams", 0)
                self.assertEqual(count, self.datagrams(path), n)
                counts.add(count)
            self.assertGreater(max(counts), 1000)

    def test_a_bit_of_a_chunk_is_noticed(self):
        data = bytearray(self.make("a.mcap", "--mcap", "packets", *PLAIN).read_bytes())
        for at in (len(data) // 3, len(data) // 2):
            data[at] ^= 4
            (seen,) = look(self.folder.write("flipped.mcap", bytes(data)))
            self.assertIn("crc", seen["error"].lower())
            self.assertIn("its check sum is wrong", run("lumdump", self.folder / "flipped.mcap", "--json").stderr)
            data[at] ^= 4


class Killed(Case):
    def test_a_recording_gives_what_lumdump_reads_of_it(self):
        address = next(ADDRESSES)
        Sensor(self, self.folder, "--frames", "2", address=address)
        path = self.folder / "a.mcap"
        p = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", "-q", "--mcap", "packets", "-o", path)
        # Some chunks are whole.
        wait_until(lambda: path.exists() and look(path)[0]["messages"].get("/datagrams", 0) > 5000, "5000 datagrams")
        p.send(signal.SIGKILL)
        p.wait()
        (seen,) = look(path)
        self.assertFalse(seen["whole"])
        self.assertEqual(seen["messages"]["/datagrams"], self.datagrams_of_any_kind(path))

    def datagrams_of_any_kind(self, path):
        r = run("lumdump", path, "-o", self.folder / "b.pcap")
        self.assertIn("cannot be read beyond", r.stderr)
        return sum(1 for _ in frames_of((self.folder / "b.pcap").read_bytes()))


if __name__ == "__main__":
    unittest.main()
