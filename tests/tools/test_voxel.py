#!/usr/bin/env python3
"""lumdump --voxel: frames thinned, and the map of a drive by its poses."""
import csv
import json
import math
import os
import pathlib
import signal
import struct
import subprocess
import tempfile
import unittest

import shards
import support
from support import BIN, run

SIZE = 0.4
CLOUDS = ("csv", "ply", "pcd", "las")


def rows(path):
    with open(path, newline="") as file:
        text = (line for line in file if not line.startswith("#"))
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(text)]


def voxel(row):
    return tuple(math.floor(row[axis] / SIZE) for axis in "xyz")


def from_centre(row):
    return sum((row[axis] - (at + 0.5) * SIZE) ** 2 for axis, at in zip("xyz", voxel(row)))


def thin(points):
    """By voxel: the nearest point, and how many there were."""
    found = {}
    for row in points:
        best, count = found.get(voxel(row), (row, 0))
        found[voxel(row)] = (row if from_centre(row) < from_centre(best) else best, count + 1)
    return found


class Voxels(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.at = pathlib.Path(cls.folder.name)
        cls.capture = cls.at / "street.pcap"
        run("lumsim", "-q", "-o", cls.capture, "-n", 2, "--returns-max", 1, check=True)
        # A drive along a curve, 7 km from 0.
        with open(cls.at / "poses.txt", "w") as file:
            for i in range(400):
                t = i * 0.05
                file.write(f"{t} {7000 + 5 * t} {0.02 * t * t} 0.1 0 0 {math.sin(0.01 * t)} {math.cos(0.01 * t)}\n")

    def dump(self, *arguments, status=0):
        r = run("lumdump", self.capture, "--eye", "blue", "--range", ":25", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        return r

    def compare(self, thinned, points):
        """Coordinates have 4 decimals in the file of points, so that one in a thousand lies on another side."""
        wanted = thin(points)
        got = {voxel(row): row for row in thinned}
        self.assertEqual(sum(row["points"] for row in thinned), len(points))
        self.assertLessEqual(len(set(got) ^ set(wanted)), len(wanted) / 200)
        same = sum(abs(got[at]["points"] - count) <= 2 + count / 100 and abs(from_centre(got[at]) - from_centre(row)) < 1e-3
                   for at, (row, count) in wanted.items() if at in got)
        self.assertGreater(same, 0.98 * len(wanted))

    def test_each_frame_on_its_own(self):
        self.dump("-o", self.at / "all-%d.csv")
        self.dump("--voxel", SIZE, "-o", self.at / "thin-%d.csv")
        made = sorted(self.at.glob("thin-*.csv"))
        self.assertEqual(len(made), 2)
        for path in made:
            self.compare(rows(path), rows(self.at / path.name.replace("thin", "all")))

    def test_a_map_is_of_all_frames_by_the_poses(self):
        poses = ("--poses", self.at / "poses.txt", "--comments")
        self.dump(*poses, "-o", self.at / "world.csv")
        said = json.loads(self.dump(*poses, "--voxel", SIZE, "--json", "-o", self.at / "map.csv").stdout)
        made = rows(self.at / "map.csv")
        self.compare(made, rows(self.at / "world.csv"))
        self.assertEqual(said["voxels"], {"size_m": SIZE, "points": said["points"], "voxels": len(made), "without_pose": 0,
                                          "not_finite": 0, "out_of_range": 0, "spooled_bytes": 0})

    def test_points_without_a_pose_are_left_out_and_counted(self):
        short = self.at / "short.txt"
        times = [row["timestamp"] * 1e-6 for row in rows(self.all_points())]
        middle = (min(times) + max(times)) / 2
        short.write_text("".join(f"{middle + i * 0.05} {i} 0 0 0 0 0 1\n" for i in range(20)))
        said = json.loads(self.dump("--poses", short, "--voxel", SIZE, "--json", "-o", self.at / "half.las").stdout)
        self.assertGreater(said["voxels"]["without_pose"], 0)
        self.assertEqual(said["voxels"]["without_pose"], said["poses"]["without"])
        self.assertEqual(said["voxels"]["points"] + said["voxels"]["without_pose"], said["points"])

    def test_a_map_without_points_is_no_map(self):
        """Voxels of 0.4 m reach 858993459 m."""
        times = [row["timestamp"] * 1e-6 for row in rows(self.all_points())]
        far, made = self.at / "far.txt", self.at / "far.las"
        far.write_text("".join(f"{min(times) - 0.1 + i * 0.05} 1e12 {i} 0 0 0 0 1\n" for i in range(20)))
        r = self.dump("--poses", far, "--voxel", SIZE, "-o", made, status=2)
        self.assertRegex(r.stderr, "--voxel: no point is left for the map: all [0-9]{5,} are farther from 0 than 8\\.59e.05 km, "
                         "where voxels of 0.4 m end; use poses in metres")
        self.assertFalse(made.exists())
        edge = SIZE * 2 ** 31 - 12
        far.write_text("".join(f"{min(times) - 0.1 + i * 0.05} {edge} {i} 0 0 0 0 1\n" for i in range(20)))
        r = self.dump("--poses", far, "--voxel", SIZE, "--json", "-o", self.at / "edge.ply")
        said = json.loads(r.stdout)["voxels"]
        self.assertGreater(said["out_of_range"], 0)
        self.assertIn(f"{said['out_of_range']} of {said['out_of_range'] + said['points']} points are left out of the map", r.stderr)

    def all_points(self):
        path = self.at / "points.csv"
        if not path.exists():
            self.dump("-o", path)
        return path

    def test_formats_have_the_same_voxels(self):
        outputs = [self.at / f"same.{kind}" for kind in CLOUDS]
        self.dump("--poses", self.at / "poses.txt", "--comments", "--voxel", SIZE,
                  *(word for path in outputs for word in ("-o", path)))
        wanted = rows(outputs[0])
        las = outputs[3].read_bytes()
        [begin] = struct.unpack_from("<I", las, 96)
        [length] = struct.unpack_from("<H", las, 105)
        scale, offset = struct.unpack_from("<3d", las, 131), struct.unpack_from("<3d", las, 155)
        self.assertEqual((length, scale), (34, (0.001,) * 3))
        self.assertEqual(struct.unpack_from("<Q", las, 247), (len(wanted),))
        self.assertGreater(offset[0], 5000)
        for i, row in enumerate(wanted):
            point = struct.unpack_from("<3iH", las, begin + i * length)
            time, count = struct.unpack_from("<dI", las, begin + i * length + 22)
            for axis in range(3):
                self.assertAlmostEqual(point[axis] * 0.001, row["xyz"[axis]], delta=0.0006)
            self.assertAlmostEqual(point[3] * 0.01, row["intensity"], delta=0.006)
            self.assertAlmostEqual(time * 1e6, row["timestamp"], delta=0.002)
            self.assertEqual(count, row["points"])
        point = struct.Struct("<ffffdI")
        for path in outputs[1:3]:
            binary = path.read_bytes()
            self.assertIn(b"metres from %.3f %.3f %.3f;" % offset, binary)
            for i, row in enumerate(wanted):
                got = point.unpack_from(binary, len(binary) - (len(wanted) - i) * point.size)
                self.assertEqual(got[5], row["points"])
                self.assertAlmostEqual(got[0], row["x"], delta=1e-4)

    def test_the_same_bytes_with_any_number_of_threads(self):
        made = []
        for threads in (1, 3):
            path = self.at / f"threads-{threads}.ply"
            self.dump("--poses", self.at / "poses.txt", "--voxel", SIZE, "--threads", threads, "-o", path)
            made.append(path.read_bytes()[-20000:])
        self.assertEqual(*made)

    def test_what_does_not_fit_is_refused(self):
        poses = ("--poses", self.at / "poses.txt")
        cases = [(("-o", "a.png"), "csv, ply, pcd and las"), (("-o", "a.pcapng"), "csv, ply, pcd and las"),
                 ((), "-o map.las"), (("-o", "a.ply", "--columns", "x"), "columns of its own"),
                 (("-o", "a.ply", "--rotate", "1s"), "--rotate does not go with --voxel: leave it out"),
                 ((*poses, "-o", "a-%d.ply"), "one map of all frames")]
        for arguments, text in cases:
            with self.subTest(arguments):
                self.assertIn(text, self.dump("--voxel", 1, *arguments, status=2).stderr)
        for size in ("0", "0.001", "1000", "x"):
            self.assertIn("0.01 to 100", self.dump("--voxel", size, "-o", "a.las", status=2).stderr)
        self.assertIn("cannot seek", self.dump("--voxel", 1, "--format", "las", "-o", "-", status=2).stderr)

    def test_a_map_that_the_disk_has_no_room_for_is_refused(self):
        """Before it is written; a pipe needs no room."""
        disk = support.small_disk(self, self.at / "disk", "64k")
        command = (self.capture, "--poses", self.at / "poses.txt", "--voxel", SIZE)
        for kind in CLOUDS:
            r = run("lumdump", *command, *["--comments"] * (kind == "csv"), "-o", disk / f"map.{kind}")
            self.assertEqual(r.returncode, 1)
            self.assertRegex(r.stderr, r"map\.\w+: the map has at least \d+ voxels, .* take larger voxels, such as --voxel 0\.8")
            self.assertEqual(list(disk.iterdir()), [])
        r = run("lumdump", *command, "--comments", "-o", "-", "--format", "csv", cwd=disk)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertGreater(len(r.stdout), 65536)

    @unittest.skipIf(os.name == "nt", "signals")
    def test_an_interrupted_map_leaves_nothing(self):
        folder = self.at / "interrupted"
        folder.mkdir()
        process = subprocess.Popen([BIN / "lumdump", "-", "--poses", self.at / "poses.txt", "--voxel", str(SIZE), "-o",
                                    folder / "map.las"], stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
        with support.limited(process):
            process.stdin.write(self.capture.read_bytes())  # it has read nearly all of it, and waits for more
            process.stdin.flush()
            process.send_signal(signal.SIGINT)
            process.wait()
        process.stdin.close()
        self.assertNotEqual(process.returncode, 0)
        self.assertEqual(list(folder.glob("map*")), [])


if __name__ == "__main__":
    shards.main()
