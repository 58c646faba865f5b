"""lumdump --poses: points moved by the sensor's motion, in every format."""
import collections
import json
import math
import pathlib
import struct
import tempfile
import unittest

from support import Folder, read_csv, run, simulate

TURN, RADIUS = 1.25, 8.0
BEGIN_S, END_S = 4.99, 5.3  # of lumsim's clock, in a capture of 3 frames


def pose(seconds):
    """x, y, heading on a circle."""
    angle = TURN * (seconds - 5.0)
    return RADIUS * math.sin(angle), -RADIUS * math.cos(angle), angle


def tum(begin_s=BEGIN_S, end_s=END_S, scale=1.0, offset=0.0, shift_s=0.0):
    rows = ["# timestamp tx ty tz qx qy qz qw"]
    for i in range(round((end_s - begin_s) * 100) + 1):
        seconds = begin_s + i / 100
        x, y, angle = pose(seconds)
        rows.append(f"{(seconds + shift_s) * scale:.6f} {x + offset:.9f} {y:.9f} 0 0 0 {math.sin(angle / 2):.12f} "
                    f"{math.cos(angle / 2):.12f}")
    return "\n".join(rows) + "\n"


def numbers(row):
    return [float(row[name]) for name in "xyz"]


class Poses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        shared = pathlib.Path(folder.name)
        cls.drive = simulate(shared / "drive.pcap", "--frames", 3)
        done = run("lumdump", cls.drive, "-q", "--columns", "x,y,z,timestamp,time,frame", "-o", shared / "still.csv")
        assert done.returncode == 0, done.stderr
        cls.still = read_csv(shared / "still.csv")
        cls.begins = {}
        for row in cls.still:
            cls.begins.setdefault(row["frame"], int(row["timestamp"]))

    def setUp(self):
        self.folder = Folder(self)
        self.poses = self.folder / "poses.txt"
        self.poses.write_text(tum())

    def dump(self, *arguments, status=0, **options):
        done = run("lumdump", self.drive, *arguments, **options)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def expected(self, row):
        """A point in the world, by its own time."""
        begin_us = self.begins[row["frame"]]
        x, y, angle = pose(begin_us * 1e-6 + float(row["time"]))
        px, py, pz = numbers(row)
        return x + px * math.cos(angle) - py * math.sin(angle), y + px * math.sin(angle) + py * math.cos(angle), pz

    def test_each_point_is_moved_by_its_own_time(self):
        out = self.folder / "moved.csv"
        self.dump("-q", "--poses", self.poses, "-o", out)
        moved = read_csv(out)
        self.assertEqual(len(moved), len(self.still))
        for before, after in list(zip(self.still, moved))[::997]:
            for a, b in zip(self.expected(before), numbers(after)):
                self.assertLess(abs(a - b), 4e-4)

    def test_every_format_has_the_moved_points(self):
        reference = self.folder / "a.csv"
        names = [self.folder / f"a.{ending}" for ending in ("csv", "ply", "pcd", "las", "xyz", "mcap")]
        self.dump("-q", "--poses", self.poses, "--compression", "none", *(word for name in names for word in ("-o", name)))
        rows = [numbers(row) for row in read_csv(reference)]
        xyz = [list(map(float, row.split()))[:3] for row in (self.folder / "a.xyz").read_text().splitlines()]
        self.assertEqual(xyz[::1009], rows[::1009])
        las = (self.folder / "a.las").read_bytes()
        at, size = struct.unpack_from("<I", las, 96)[0], struct.unpack_from("<H", las, 105)[0]
        self.assertEqual(struct.unpack_from("<Q", las, 247)[0], len(rows))
        for i in range(0, len(rows), 1009):
            point = [unit / 1e4 for unit in struct.unpack_from("<3i", las, at + i * size)]
            self.assertLess(max(abs(a - b) for a, b in zip(point, rows[i])), 2e-4)
        self.assertIn(b"--poses=", las[:at])
        mcap = (self.folder / "a.mcap").read_bytes()
        self.assertTrue(b"\x04\0\0\0map\0" in mcap and b"luminar" not in mcap)

    def test_the_start_is_where_the_first_line_was(self):
        out = self.folder / "start.csv"
        self.dump("-q", "--poses", self.poses, "--to", "start", "--columns", "x,y,z,time,frame", "-o", out)
        first = [(before, after) for before, after in zip(self.still, read_csv(out)) if float(after["time"]) < 1e-4]
        self.assertGreater(len(first), 50)
        for before, after in first:
            self.assertLess(max(abs(a - b) for a, b in zip(numbers(before), numbers(after))), 0.03)

    def test_what_has_no_pose_is_left_out_and_counted(self):
        self.poses.write_text(tum(end_s=5.15))
        out = self.folder / "half.csv"
        done = self.dump("--poses", self.poses, "--json", "-o", out)
        counts = json.loads(done.stdout)["poses"]
        self.assertEqual(len(read_csv(out)), counts["points"] - counts["without"])
        self.assertEqual(counts["without"], counts["after"])
        self.assertGreater(counts["after"], 100_000)
        self.assertIn(f"{counts['without']} of {counts['points']} points have no pose and are left out: "
                      f"{counts['after']} after the last one", done.stderr)

    def test_frames_and_rows_lack_it_too(self):
        self.poses.write_text(tum(end_s=5.15))
        self.dump("-q", "--poses", self.poses, "--organized", "--return", "last", "--ascii", "-o", self.folder / "%d.pcd")
        counts = collections.Counter()
        for i in range(1, 4):
            rows = (self.folder / f"{i}.pcd").read_text().split("DATA ascii\n")[1].splitlines()
            self.assertEqual(len(rows), 128_000)
            counts[i] = sum(not row.startswith("nan") for row in rows)
        self.assertTrue(counts[1] > 90_000 and 0 < counts[2] < 90_000 and counts[3] == 0, counts)

    def test_a_far_world_has_an_origin(self):
        self.poses.write_text(tum(offset=512345.0))
        done = self.dump("--poses", self.poses, "-o", self.folder / "far.las", "-o", self.folder / "far.ply")
        self.assertIn("relative to the origin 512000 0 0", done.stderr)
        las = (self.folder / "far.las").read_bytes()
        self.assertEqual(struct.unpack_from("<3d", las, 155), (512000.0, 0.0, 0.0))
        high, low = struct.unpack_from("<2d", las, 179)
        self.assertTrue(512340 < low < high < 512800, (low, high))
        self.assertIn(b"origin=512000,0,0", (self.folder / "far.ply").read_bytes()[:2000])

    def test_no_file_is_silent_about_its_origin(self):
        self.poses.write_text(tum(offset=512345.0))
        for ending in "csv", "xyz":
            name = self.folder / f"far.{ending}"
            done = self.dump("-q", "--poses", self.poses, "-o", name, status=2)
            self.assertIn(f"{name}: the poses are farther than 5 km from 0, so x, y and z are relative to the origin "
                          "512000 0 0, and nothing in the file would say so: give --comments, or", done.stderr)
            self.assertFalse(name.exists())
            self.dump("-q", "--poses", self.poses, "--comments", "-o", name)
            self.assertIn("origin=512000,0,0", name.read_text()[:2000])
        mcap = self.folder / "far.mcap"
        done = self.dump("--poses", self.poses, "--json", "--compression", "none", "-o", mcap)
        self.assertIn(b"origin=512000,0,0", mcap.read_bytes())
        self.assertIn("512000 0 0; a comment of the file gives it\n", done.stderr)
        self.assertEqual(json.loads(done.stdout)["poses"]["origin_m"], [512000, 0, 0])

    def test_a_wide_world_tells_how_coarse_its_ends_are(self):
        """13 km at 130 m/s, seen for its first tenth of a second."""
        self.poses.write_text("".join(f"{4.9 + i / 2} {65 * i} 0 0 0 0 0 1\n" for i in range(200)))
        done = self.dump("--poses", self.poses, "-o", self.folder / "wide.las")
        self.assertIn("relative to the origin 6000 0 0; the file has it as its offset", done.stderr)
        self.assertRegex(done.stderr, r"up to 6\.9 km from the origin: there x, y and z, which are floats, have steps of 0\.49 mm")
        self.poses.write_text("".join(f"{4.9 + i / 2} {65 * (i - 100)} 0 0 0 0 0 1\n" for i in range(201)))
        name = self.folder / "around.csv"
        done = self.dump("--poses", self.poses, "-o", name)
        self.assertNotIn("relative", done.stderr)
        self.assertIn("up to 6.5 km from the origin", done.stderr)

    def test_a_pipe_has_the_same_bytes(self):
        name = self.folder / "a.las"
        self.dump("-q", "--poses", self.poses, "-o", name)
        done = self.dump("-q", "--poses", self.poses, "-o", "-", "--format", "las", "--threads", 1)
        self.assertEqual(done.stdout_bytes, name.read_bytes())

    def test_poses_are_never_overwritten(self):
        times = self.folder / "times.csv"
        times.write_text("1\n")
        for name in self.poses, times:
            before = name.read_bytes()
            done = self.dump("-q", "--poses", self.poses, "--pose-times", times, "--format", "csv", "-o", name, status=2)
            self.assertRegex(done.stderr, f"{name} is the file of .*poses.*, which this run reads: name another output")
            self.assertEqual(name.read_bytes(), before)
        second = self.folder.write("m-0002.csv", self.poses.read_text())
        done = self.dump("-q", "--poses", second, "-o", self.folder / "m-%04d.csv", status=2)
        self.assertIn("m-0002.csv, which this run reads, has one of the names of", done.stderr)
        self.assertFalse((self.folder / "m-0001.csv").exists())

    def test_standard_input_can_be_the_poses(self):
        outputs = [self.folder / "file.ply", self.folder / "stdin.ply"]
        self.dump("-q", "--poses", self.poses, "-o", outputs[0])
        self.dump("-q", "--poses", "-", "-o", outputs[1], stdin=self.poses.read_bytes())
        first, second = (name.read_bytes().split(b"end_header")[1] for name in outputs)
        self.assertEqual(first, second)
        done = self.dump("--poses", "-", "-o", outputs[1], status=2)
        self.assertIn("standard input: has no poses", done.stderr)
        done = run("lumdump", "-", "--poses", "-", "-o", outputs[1])
        self.assertIn("standard input can be read only once: --poses and the source both name it", done.stderr)

    def test_what_is_wrong_is_refused(self):
        out = self.folder / "no.ply"
        for text, message in ((tum(shift_s=500), "its poses are from 504.990 to 505.300 s of the sensor's clock, the points from"),
                              (tum(scale=1000), "if the times are milliseconds, convert them to seconds"),
                              (tum(shift_s=1.7e9), "UTC"),
                              ("", "has no poses; at least one is needed")):
            self.poses.write_text(text)
            self.assertIn(message, self.dump("--poses", self.poses, "-o", out, status=2).stderr)
            self.assertFalse(out.exists())
        for arguments, message in ((["--to", "world", "-o", out], "give --poses FILE too"),
                                   (["--pose-times", "t", "-o", out], "give that too"),
                                   (["--poses", self.poses], "--poses moves points, and no output has any"),
                                   (["--poses", self.poses, "-o", self.folder / "a.png"], "does not go with png"),
                                   (["--poses", self.poses, "-o", self.folder / "a.pcap"], "no output has any")):
            self.assertIn(message, self.dump(*arguments, status=2).stderr)
        done = run("lumdump", "udp://127.0.0.1", "--poses", self.poses, "-o", out)
        self.assertIn("--poses goes with captures", done.stderr)


if __name__ == "__main__":
    unittest.main()
