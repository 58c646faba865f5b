#!/usr/bin/env python3
"""lumsim on a path, from outside: options, refusals, the poses and the labels beside a capture."""
import ast
import json
import math
import os
import struct
import time
import unittest

import test_lumsim_live
from support import PATIENCE_S, Folder, run, simulate
from test_scene import columns

TOWN = ("--scene", "town", "--path", "circle", "--velocity", "10")
# Also where a run of many tests does not look for leaks, to save time.
LEAKS = {**os.environ, "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":detect_leaks=1"}
ROW = struct.Struct("<qIIHHBB?B")


def labels(path):
    """The names of a structured array, and its rows."""
    data = path.read_bytes()
    length = struct.unpack_from("<H", data, 8)[0]
    head = ast.literal_eval(data[10:10 + length].decode())
    rows = list(ROW.iter_unpack(data[10 + length:]))
    assert data[:8] == b"\x93NUMPY\x01\x00" and (len(rows),) == head["shape"], head
    return [name for name, _ in head["descr"]], rows


def poses(path):
    """The rows of a TUM file as numbers, times as texts."""
    rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return [row[0] for row in rows], [tuple(map(float, row[1:])) for row in rows]


class Options(unittest.TestCase):
    def refused(self, *arguments, says):
        folder = Folder(self)
        (folder / "short.txt").write_text("10 0 0 1.8 0 0 0 1\n10.5 1 0 1.8 0 0 0 1\n")
        (folder / "wall.txt").write_text("0 0 0 1.8 0 0 0 1\n1 0 40 1.8 0 0 0 1\n")
        (folder / "one.txt").write_text("10 0 0 1.8 0 0 0 1\n")
        (folder / "brief.txt").write_text("10 0 0 1.8 0 0 0 1\n10.05 1 0 1.8 0 0 0 1\n")
        (folder / "gap.txt").write_text("".join(f"{t} {t} 0 1.8 0 0 0 1\n" for t in (10, 10.5, 11, 13.5, 14)))
        before = folder.names()
        output = () if "--output" in arguments else ("-o", "a.pcap")
        r = run("lumsim", *output, *arguments, cwd=folder / ".", env=LEAKS)
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        self.assertRegex(r.stderr, says)
        self.assertEqual(sorted(folder.names()), sorted(before))

    def test_what_cannot_be_is_refused_with_what_is_right(self):
        for arguments, says in [
                (("--path", "circle"), "circle is not for --scene street: there, straight, stop-and-go or a file"),
                ((*TOWN[:2], "--path", "eight"), "eight is not for --scene town: there, circle, stop-and-go or a file"),
                (("--scene", "room", "--path", "straight"), "not for --scene room: there, circle, eight or a file"),
                (("--velocity", "3"), "--velocity is that of --path straight, circle, eight or stop-and-go"),
                (("--path", "short.txt", "--velocity", "3"), "the times of its poses say how fast"),
                (("--path", "straight", "--pose", "0,0,1,0,0,0"), "--path and --pose: with one the sensor moves"),
                (("--path", "none.txt"), "--path: none.txt: cannot be read"),
                (("--path", "short.txt", "--frames", "6"), r"last 0\.5 s, and 6 frames 0\.6 s; use --frames 5"),
                (("--path", "wall.txt"), r"--path, 0\.\d+ s after the beginning: the blue eye would be outside"),
                (("--scene", "room", "--path", "circle", "--velocity", "3", "--set", "eyes.blue.mount.x_m=1.5"),
                 r"--path, 0\.\d+ s after the beginning: the blue eye would be outside the room"),
                (("--output", "a.npy", "--labels", "a.npy"), "--labels: 'a.npy' is the file of --output too"),
                (("--poses", "x.npy", "--labels", "x.npy"), "--labels: 'x.npy' is the file of --poses too"),
                (("--path", "one.txt"), "one.txt: it has one pose, but a path needs two or more; .* use --pose"),
                (("--path", "brief.txt"), r"its poses last 0\.05 s, and one frame 0\.1 s; use poses that last longer"),
                (("--path", "gap.txt"), r"1 gap is longer than 1 s, the longest from 11\.000 to 13\.500 s; use poses closer"),
                (("--path", "gap.txt", "--frames", "2"), "1 gap is longer than 1 s"),
                (("--labels", "y.csv"), r"'y\.csv': labels are an array of NumPy; use .* in \.npy"),
                (("--path", "short.txt", "--poses", "short.txt"), "--poses: .*the path"),
                (("--time", "utc"), "--time utc is about the times of the exact points in --truth FILE, and of --poses")]:
            with self.subTest(arguments):
                self.refused(*arguments, says=says)

    def test_a_long_path_is_looked_at_in_each_frame(self):
        aside = Folder(self).write("aside.txt", "".join(f"{i / 20} {i / 20} {30 if 7001 <= i <= 7003 else 0} 1.8 0 0 0 1\n"
                                                        for i in range(24001)))
        self.refused("--path", aside, says=r"--path, 350\.\d+ s after the beginning: the blue eye would be outside the street")


class Beside(unittest.TestCase):
    def test_poses_are_those_of_each_line(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", *TOWN, "--frames", "2", "--poses", folder / "a.txt")
        simulate(folder / "b.pcap", *TOWN, "--frames", "2", "--poses", folder / "b.txt", "--time", "utc")
        times, rows = poses(folder / "a.txt")
        self.assertEqual(len(rows), 130)  # the end of the last line, too, and a line more
        self.assertEqual((folder / "a.pcap").read_bytes(), (folder / "b.pcap").read_bytes())
        for second, (x, y, z, *turn) in zip(times, rows, strict=True):
            self.assertRegex(second, r"^5\.\d{9}$")
            self.assertAlmostEqual(x, 10 * (float(second) - 5), delta=1e-6)
            self.assertEqual((y, z, turn), (0, 1.8, [0, 0, 0, 1]))
        utc, same = poses(folder / "b.txt")
        self.assertEqual(same, rows)
        self.assertEqual(utc[5], f"{1767225600 + 5}{times[5][1:]}")

    def test_poses_of_a_drive_that_is_frozen_are_those_of_its_frames(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", "--frames", "2", "--poses", folder / "a.txt")
        self.assertEqual({row[0] for row in poses(folder / "a.txt")[1]}, {0.0, 0.5})

    def test_a_path_from_a_file_is_driven(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", "--scene", "yard", "--path", "eight", "--frames", "3", "--velocity", "6",
                 "--poses", folder / "a.txt")
        r = run("lumsim", "-q", "-o", folder / "b.pcap", "--scene", "yard", "--path", folder / "a.txt", "--poses",
                folder / "b.txt", env=LEAKS)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        first, second = poses(folder / "a.txt"), poses(folder / "b.txt")
        self.assertEqual(first[0], second[0])
        self.assertEqual(len(first[1]), len(second[1]))
        for a, b in zip(first[1], second[1]):
            self.assertLess(math.dist(a, b), 3e-6)

    def test_labels_have_a_row_for_each_exact_point(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", *TOWN, "--frames", "2", "--labels", folder / "a.npy", "--truth", folder / "a.csv")
        names, rows = labels(folder / "a.npy")
        keys = ["frame", "line", "eye", "pixel", "return_number"]
        at = [names.index(name) for name in keys]
        mine = [tuple(row[i] for i in at) for row in rows]
        self.assertEqual(mine, sorted(mine))
        self.assertEqual(mine, sorted(tuple(map(int, row)) for row in columns(folder / "a.csv", " ".join(keys))))
        classes = {}
        for row in rows:
            classes.setdefault(row[names.index("class")], set()).add(row[names.index("object")])
        self.assertTrue({1, 2, 3, 6, 7, 8} <= set(classes), classes.keys())
        self.assertEqual(classes[1], {1})
        objects = [number for each in classes.values() for number in each]
        self.assertEqual(len(objects), len(set(objects)))  # an object has one class

    def test_all_points_have_a_pose_by_utc(self):
        folder = Folder(self)
        for arguments in ((), ("--drift", "50"), ("--batch", "20")):
            with self.subTest(arguments):
                simulate(folder / "a.pcap", *TOWN, "--frames", "2", "--time", "utc", "--poses", folder / "a.txt", *arguments)
                r = run("lumdump", folder / "a.pcap", "--poses", folder / "a.txt", "-o", folder / "a.las", "--json")
                self.assertEqual((r.returncode, r.stderr), (0, ""))
                self.assertEqual(json.loads(r.stdout)["poses"]["without"], 0)

    def test_labels_need_a_file(self):
        folder = Folder(self)
        (folder / "a.npy").symlink_to("/dev/null")
        r = run("lumsim", "-o", folder / "a.pcap", "--frames", "1", "--labels", folder / "a.npy")
        self.assertEqual(r.returncode, 1)
        self.assertRegex(r.stderr, "--labels: .*a.npy is no regular file")
        self.assertEqual(folder.names(), ["a.npy"])


class Live(test_lumsim_live.Live):
    JUMP = "loop of 2, and at the end of each round the sensor jumps by 0.40 m and 0.0 degrees; more --frames"

    def test_that_a_loop_jumps_is_said(self):
        client = self.start("--path", "straight", "--velocity", "10", "--frames", "2", "--rate", "50")
        end = time.monotonic() + PATIENCE_S
        clocks = set()
        while len(clocks) < 3 * 2 * 64 and time.monotonic() < end:
            clocks.update(packet.clock for packet in client.data(50))
        said = self.end()
        self.assertIn(self.JUMP, said)
        self.assertRegex(said, r"; the sensor jumped [1-9]\d* times\n")

    def test_what_does_not_jump_says_nothing(self):
        there_and_back = self.dir / "path.txt"
        there_and_back.write_text("".join(f"0.{i} {i % 2} 0 1.8 0 0 0 1\n" for i in range(3)))
        for arguments in ((), ("--path", there_and_back)):
            with self.subTest(arguments):
                self.start("--frames", "2", *arguments, beats=False)
                self.assertNotIn("jump", self.end())


if __name__ == "__main__":
    unittest.main()
