#!/usr/bin/env python3
"""lumdump -o drive.mcap: messages of ROS 2, from captures and live. Other readers: read_back_mcap.py."""
import collections
import itertools
import math
import signal
import struct
import unittest

import shards
from live import Sensor, tool, wait_until
from mcap_file import File, statuses_of
from support import Folder, group, line, pcap, read_csv, run, simulate, udp, word

ADDRESSES = (f"127.21.0.{i}" for i in itertools.count(1))
PLAIN = ("--compression", "none")


# x y z intensity range azimuth elevation, timestamp, frame, eye, line, pixel, return, returns, edge
PCD_ROW = struct.Struct("<7fdiBIHHHB")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def dump(self, *arguments, status=0):
        r = run("lumdump", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        return r

    def file(self, name):
        return File((self.folder / name).read_bytes())

    def street(self, *arguments):
        return simulate(self.folder / "street.pcap", "--frames", "3", "--seed", "5", *arguments)


class Capture(Case):
    def test_points_are_those_of_pcd(self):
        self.dump(self.street("--loss", "0.01"), "-o", self.folder / "a.pcd", "-o", self.folder / "a.mcap", *PLAIN)
        want = collections.defaultdict(list)
        for row in PCD_ROW.iter_unpack((self.folder / "a.pcd").read_bytes().split(b"DATA binary\n", 1)[1]):
            x, y, z, width, *_, frame, eye, number, _, return_number, _, _ = row
            want[frame].append((x, y, z, width, eye * 64 + number, return_number, eye))
        clouds = self.file("a.mcap").clouds()
        self.assertEqual(len(clouds), 3)
        for frame, cloud in zip(sorted(want), clouds):
            got = [(p.x, p.y, p.z, p.intensity, p.ring, p.number, p.eye) for p in cloud.points]
            self.assertEqual(len(got), len(want[frame]))
            self.assertTrue(sorted(got) == sorted(want[frame]), f"other points in frame {frame}")

    def test_points_are_in_order_of_time_from_the_stamp(self):
        self.dump(self.street(), "-o", self.folder / "a.mcap", *PLAIN)
        file = self.file("a.mcap")
        for cloud in file.clouds():
            times = [p.time for p in cloud.points]
            self.assertEqual(times, sorted(times))
            self.assertEqual(times[0], 0.0)
            self.assertLess(times[-1], 0.2)
        stamps = [c.stamp_ns for c in file.clouds()]
        for a, b in itertools.pairwise(stamps):
            self.assertAlmostEqual(b - a, 1e8, delta=1e6)

    def test_a_file_has_mounts_and_what_was_lost(self):
        self.dump(self.street("--loss", "0.05"), "-o", self.folder / "a.mcap", *PLAIN, "-q")
        file = self.file("a.mcap")
        self.assertTrue(file.is_whole)
        self.assertEqual(file.messages[0].topic, "/tf_static")
        self.assertEqual(len(file.of("/tf_static")), 1)
        (data,), (losses,) = map(statuses_of, file.of("/diagnostics"))
        self.assertEqual((data[0], data[1], data[3]["frames"]), ("lumdump: data", 0, "3"))
        self.assertEqual(int(data[3]["points"]), sum(len(c.points) for c in file.clouds()))
        self.assertEqual((losses[0], losses[1]), ("lumdump: losses", 1))
        self.assertGreater(int(losses[3]["lost_words"]), 0)

    def test_it_says_where_it_is_from(self):
        calibration = self.folder.write("c.yaml", "speed_of_light: 299792458\n")
        self.dump(self.street(), "--calibration", calibration, "--eye", "blue", "-o", self.folder / "a.mcap")
        file = self.file("a.mcap")
        self.assertIn('- "--eye=blue"', file.metadata["lumsdk"]["provenance"])
        self.assertEqual(list(file.attachments), ["calibration.yaml"])
        self.assertIn("speed_of_light: 299792458", file.attachments["calibration.yaml"])

    def test_standard_output_has_the_same_bytes(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "a.mcap")
        r = self.dump(source, "-o", "-", "--format", "mcap", "-q")
        self.assertEqual(r.stdout_bytes, (self.folder / "a.mcap").read_bytes())

    def test_compression(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "a.mcap")
        self.dump(source, "-o", self.folder / "b.mcap", *PLAIN)
        used = set(self.file("a.mcap").compressions)
        self.assertEqual(set(self.file("b.mcap").compressions), {""})
        r = run("lumdump", source, "-o", self.folder / "c.mcap", "--compression", "zstd")
        if used == {"zstd"}:
            self.assertEqual(r.returncode, 0)
            self.assertEqual((self.folder / "c.mcap").read_bytes(), (self.folder / "a.mcap").read_bytes())
            self.assertLess((self.folder / "a.mcap").stat().st_size, (self.folder / "b.mcap").stat().st_size)
        else:
            self.assertEqual(r.returncode, 2)
            self.assertIn("built without a libzstd", r.stderr)

    def test_compression_of_other_formats_is_refused(self):
        r = self.dump(self.street(), "-o", self.folder / "a.ply", *PLAIN, status=2)
        self.assertIn("--compression goes with mcap output only", r.stderr)

    def test_a_file_for_each_frame(self):
        self.dump(self.street(), "-o", self.folder / "f-%04d.mcap", *PLAIN)
        names = [n for n in self.folder.names() if n.startswith("f-")]
        self.assertEqual(len(names), 3)
        for name in names:
            file = self.file(name)
            self.assertEqual([m.topic for m in file.messages], ["/tf_static", "/points"])
            self.assertTrue(file.is_whole)

    def test_rotation_gives_whole_files(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "one.mcap", *PLAIN)
        self.dump(source, "-o", self.folder / "r.mcap", "--rotate", "3MB", *PLAIN)
        names = [n for n in self.folder.names() if n.startswith("r-")]
        self.assertGreater(len(names), 1)
        files = [self.file(n) for n in names]
        self.assertTrue(all(f.is_whole and len(f.of("/tf_static")) == 1 for f in files))
        self.assertEqual([c for f in files for c in f.clouds()], self.file("one.mcap").clouds())

    def test_stamps_are_arrivals_if_asked_for(self):
        frames = [udp(p) for number in range(2) for p in line([word(2000, 0)], 0, number, 5000 + 1000 * number)]
        source = self.folder.write("a.pcap", pcap(frames, start=1_700_000_000.0))
        self.dump(source, "--time", "arrival", "-o", self.folder / "a.mcap", *PLAIN, "-q")
        (cloud,) = self.file("a.mcap").clouds()
        self.assertEqual(cloud.stamp_ns, 1_700_000_000 * 10**9)
        self.assertEqual([p.ring for p in cloud.points], [0, 1])
        self.assertTrue(math.isclose(cloud.points[1].time, 0.001, rel_tol=1e-5))

    def test_other_outputs_keep_their_times(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "a.csv", "-o", self.folder / "a.mcap")
        self.dump(source, "-o", self.folder / "b.csv")
        self.assertEqual((self.folder / "a.csv").read_bytes(), (self.folder / "b.csv").read_bytes())

    def test_messages_are_the_same_beside_other_frames(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "a.mcap")
        self.dump(source, "-o", self.folder / "b.mcap", "-o", self.folder / "b.csv", "--columns", "azimuth,pixel,time")
        self.assertEqual((self.folder / "a.mcap").read_bytes(), (self.folder / "b.mcap").read_bytes())
        self.assertTrue(any(float(row["azimuth"]) != 0 for row in read_csv(self.folder / "b.csv")))

    def test_frames_without_points_are_clouds_without_width(self):
        frames = [udp(p) for p in line([word(2000, 0)])] + [udp(group(3, 0, 5, [], 0, 9000))]
        source = self.folder.write("a.pcap", pcap(frames))
        self.dump(source, "--range", "999:1000", "-o", self.folder / "a.mcap", *PLAIN, "-q")
        self.assertEqual([c.points for c in self.file("a.mcap").clouds()], [[]])


class Live(Case):
    def start(self):
        address = next(ADDRESSES)
        Sensor(self, self.folder, "--frames", "2", address=address)
        p = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", "-q", "-o", self.folder / "a.mcap", *PLAIN)
        path = self.folder / "a.mcap"
        wait_until(lambda: path.exists() and len(self.file("a.mcap").of("/points")) > 1, "the second cloud")
        return p

    def test_it_is_whole_after_ctrl_c(self):
        p = self.start()
        self.assertEqual(p.end(signal.SIGINT), 0)
        file = self.file("a.mcap")
        self.assertTrue(file.is_whole)
        self.assertGreater(sum(len(c.points) for c in file.clouds()), 0)
        self.assertGreater(len(file.of("/diagnostics")), 1)

    def test_it_can_be_read_after_a_kill(self):
        p = self.start()
        seen = len(self.file("a.mcap").of("/points"))
        p.send(signal.SIGKILL)
        p.wait()
        file = self.file("a.mcap")
        self.assertFalse(file.is_whole)
        self.assertGreaterEqual(len(file.clouds()), seen)


if __name__ == "__main__":
    shards.main()
