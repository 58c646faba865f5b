#!/usr/bin/env python3
"""lumsim's room, yard and still street from outside: options, refusals, the true calibration, what decodes."""
import csv
import math
import statistics
import unittest

from support import Folder, run, simulate

TRUE = ("--set", "eyes.blue.mount.yaw_deg=-31.25", "--set", "eyes.blue.mount.x_m=0.04",
        "--set", "eyes.green.mount.pitch_deg=1.5", "--set", "eyes.green.tof_offset_ps=120.5",
        "--set", "eyes.blue.azimuth.width_deg=60.4", "--set", "eyes.green.elevation.min_deg=-17.2")


def columns(path, names):
    """Some columns of a CSV file, as rows of numbers."""
    with open(path, newline="") as file:
        rows = csv.reader(file)
        head = next(rows)
        at = [head.index(name) for name in names.split()]
        return [tuple(float(row[i]) for i in at) for row in rows]


def decode(path, names, *arguments):
    """Some columns of the points of a capture."""
    out = path.with_suffix(".points.csv")
    r = run("lumdump", path, "-q", "-o", out, *arguments)
    if r.returncode != 0:
        raise AssertionError(r.stderr)
    return columns(out, names)


def errors(folder, *arguments):
    """Return number -> measured ranges less the true ones."""
    simulate(folder / "a.pcap", "--truth", folder / "a.csv", *arguments)
    found = {}
    true = columns(folder / "a.csv", "return_number range")
    for (got,), (number, right) in zip(decode(folder / "a.pcap", "range"), true, strict=True):
        found.setdefault(int(number), []).append(got - right)
    return found


class Options(unittest.TestCase):
    def refused(self, *arguments, says):
        folder = Folder(self)
        r = run("lumsim", "-o", folder / "a.pcap", *arguments)
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        self.assertRegex(r.stderr, says)
        self.assertEqual(folder.names(), [])

    def test_what_cannot_be_is_refused_with_what_is_right(self):
        room = ("--scene", "room")
        for arguments, says in [
                (("--scene", "garden"), "--scene: 'garden' is not one of street room yard"),
                (("--walls", "mild"), "--walls is about the faces of --scene room and --scene yard"),
                (("--walls", "flat"), "--walls is about the faces"),
                ((*room, "--walls", "wavy"), "'wavy' is not one of flat mild rough"),
                ((*room, "--pose", "0,0,1.2"), "'0,0,1.2' is not X,Y,Z,ROLL,PITCH,YAW, in metres and degrees"),
                ((*room, "--pose", "0,0,1.2,0,0"), "'0,0,1.2,0,0'"),
                ((*room, "--pose", "0,0,1.2,0,0,0,0"), "is not X,Y,Z,ROLL,PITCH,YAW, in metres and degrees"),
                ((*room, "--pose", "0,0,high,0,0,0"), "z is not a number from -1000 to 1000"),
                ((*room, "--pose", "0,0,1.2,0,0,361"), "yaw is not a number from -360 to 360"),
                ((*room, "--pose", "0,0,nan,0,0,0"), "z is not a number"),
                ((*room, "--pose", ""), "x is not a number"),
                ((*room, "--pose", "5,0,1.2,0,0,0"), "--pose: the blue eye would be outside the room.*from -3.4 to 4.6 m"),
                ((*room, "--pose", "-2.6,-1.2,1,0,0,0"), "less than 0.5 m from something in it"),
                (("--scene", "yard", "--pose", "0,0,9.5,0,0,0"), "outside the yard.*z from 0 to 9 m"),
                (("--pose", "0,14,1.8,0,0,0"), "outside the street.*-7.5 to 11 m"),
                ((*room, "--set", "eyes.green.mount.x_m=4.3"), "the mount of an eye: the green eye would be outside"),
                (("--noise", "-0.1"), "from 0 to 1 metre"),
                (("--noise", "2"), "from 0 to 1 metre"),
                (("--noise", "0.1,"), "'0.1,' is not"),
                (("--noise", ""), "is not M or M,M"),
                (("--noise", "1,1,1,1,1,1,1,1,1"), "at most 8"),
                (("--truth", ""), "'' is not the name of a file"),
                (("--truth", "a.csv", "--truth", "b.csv"), "'b.csv': 'a.csv' is the exact points already"),
                (("--truth", "a.yml", "--truth", "b.YAML"), "'a.yml' is the true calibration already"),
                (("--time", "utc", "--truth", "a.yaml"), "--time utc is about the times of the exact points")]:
            with self.subTest(arguments=arguments):
                self.refused(*arguments, says=says)

    def test_a_replay_has_no_scene(self):
        for option, value in [("--scene", "room"), ("--walls", "mild"), ("--pose", "0,0,1.8,0,0,0"), ("--noise", "0")]:
            with self.subTest(option=option):
                r = run("lumsim", "--replay", "a.pcap", option, value)
                self.assertEqual(r.returncode, 2)
                self.assertIn(f"{option} does not go with --replay: the capture decides that", r.stderr)

    def test_no_file_gets_two_things(self):
        folder = Folder(self)
        (folder / "linked.yaml").symlink_to(folder / "points.csv")
        (folder / "points.csv").write_text("")
        for arguments, says in [
                (("-o", folder / "a.yaml", "--truth", folder / "a.yaml"), "is the capture's output too"),
                (("-o", folder / "a.pcap", "--truth", folder / "points.csv", "--truth", folder / "linked.yaml"),
                 "is the other --truth too")]:
            with self.subTest(says=says):
                r = run("lumsim", *arguments)
                self.assertEqual(r.returncode, 2)
                self.assertIn(says, r.stderr)

    def test_the_true_calibration_is_no_input_too(self):
        folder = Folder(self)
        folder.write("mine.yaml", b"version: 1\n")
        r = run("lumsim", "-o", folder / "a.pcap", "--calibration", folder / "mine.yaml", "--truth", folder / "mine.yaml")
        self.assertEqual(r.returncode, 2)
        self.assertIn("the calibration", r.stderr)
        self.assertEqual((folder / "mine.yaml").read_bytes(), b"version: 1\n")


class Truth(unittest.TestCase):
    def test_the_true_calibration_loads_as_it_is(self):
        folder = Folder(self)
        room = ("--scene", "room", "--frames", "1", "--seed", "3")
        simulate(folder / "a.pcap", *room, *TRUE, "--truth", folder / "true.yaml", "--truth", folder / "true.csv")
        simulate(folder / "b.pcap", *room, "--calibration", folder / "true.yaml", "--truth", folder / "again.yaml")
        self.assertEqual((folder / "a.pcap").read_bytes(), (folder / "b.pcap").read_bytes())
        self.assertEqual((folder / "true.yaml").read_bytes(), (folder / "again.yaml").read_bytes())
        found = decode(folder / "a.pcap", "x y z", "--calibration", folder / "true.yaml")
        true = columns(folder / "true.csv", "x y z")
        self.assertLess(max(map(math.dist, found, true)), 0.08)
        self.assertEqual(len(found), len(true))

    def test_it_says_what_the_recording_was_made_of(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", "--frames", "1", "--truth", folder / "a.yaml", "--scene", "yard", "--seed", "8")
        simulate(folder / "b.pcap", "--frames", "1", "--truth", folder / "b.yaml")
        text = (folder / "a.yaml").read_text()
        self.assertIn("# Scene: yard, seed 8\n# Pose: 0,0,1.5,0,0,0\n", text)
        self.assertIn("# Scene: street, seed 1\nversion: 1\n", (folder / "b.yaml").read_text())

    def test_a_run_that_fails_leaves_none(self):
        folder = Folder(self)
        r = run("lumsim", "-q", "-o", folder / "a.pcap", "--frames", "1", "--truth", folder / "no" / "a.yaml")
        self.assertEqual(r.returncode, 1)
        self.assertIn("a.yaml", r.stderr)
        r = run("lumsim", "-q", "-o", "/dev/full", "--frames", "1", "--truth", folder / "a.yaml")
        self.assertEqual(r.returncode, 1)
        self.assertEqual(folder.names(), [])


class Scenes(unittest.TestCase):
    def test_a_room_decodes_to_its_walls(self):
        folder = Folder(self)
        simulate(folder / "a.pcap", "--scene", "room", "--pose", "0.5,0,1.2,0,0,0", "--frames", "1", "--noise", "0", *TRUE,
                 "--truth", folder / "true.yaml")
        points = decode(folder / "a.pcap", "x y", "--calibration", folder / "true.yaml")
        self.assertEqual(len(points), 2 * 64 * 1000)
        self.assertLess(max(x for x, _ in points), 4.1 + 0.003)
        self.assertLess(max(abs(y) for _, y in points), 3.4 + 0.003)
        wall = [x for x, _ in points if x > 4.05]
        self.assertGreater(len(wall), 10000)
        self.assertLess(abs(statistics.median(wall) - 4.1), 0.001)

    def test_what_stands_still_is_the_same_in_each_frame(self):
        folder = Folder(self)
        for name, arguments in [("room", ("--scene", "room")), ("street", ("--pose", "4,1,2,3,2,40"))]:
            with self.subTest(name=name):
                simulate(folder / "a.pcap", "--frames", "2", "--truth", folder / "a.csv", *arguments)
                frames = {}
                for number, frame, range_m, *where in columns(folder / "a.csv", "return_number frame range eye line pixel"):
                    if number == 1:
                        frames.setdefault(frame, {})[tuple(where)] = range_m
                first, last = frames[1], frames[2]
                both = first.keys() & last.keys()
                self.assertGreater(len(both), 100_000)
                self.assertGreater(sum(first[k] == last[k] for k in both), 0.98 * len(both))

    def test_a_pose_moves_the_sensor_and_not_the_room(self):
        folder = Folder(self)
        pose = (0.25, -0.5, 1.3, 0, 0, 30)
        simulate(folder / "a.pcap", "--scene", "room", "--frames", "1", "--pose", ",".join(map(str, pose)),
                 "--truth", folder / "a.csv")
        c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
        points = [(c * x - s * y + pose[0], s * x + c * y + pose[1], z + pose[2])
                  for x, y, z in columns(folder / "a.csv", "x y z")]
        self.assertLess(abs(max(x for x, _, _ in points) - 4.6), 0.001)
        self.assertLess(abs(max(y for _, y, _ in points) - 2.6), 0.001)
        self.assertLess(abs(min(z for _, _, z in points)), 0.001)

    def test_noise_is_that_of_each_return(self):
        found = errors(Folder(self), "--frames", "1", "--noise", "0.005,0.05")
        self.assertAlmostEqual(statistics.pstdev(found[1]), 0.005, delta=0.0005)
        self.assertGreater(len(found[2]), 500)
        self.assertAlmostEqual(statistics.pstdev(found[2]), 0.05, delta=0.006)

    def test_walls_are_those_of_the_seed(self):
        folder = Folder(self)
        room = ("--scene", "room", "--walls", "mild", "--noise", "0", "--frames", "1")
        ranges = {}
        for name, arguments in [("a", ("--seed", "1")), ("b", ("--seed", "2")), ("flat", ("--walls", "flat"))]:
            simulate(folder / f"{name}.pcap", *room, *arguments, "--truth", folder / f"{name}.csv")
            ranges[name] = [r for r, in columns(folder / f"{name}.csv", "range")]
        for a, b in [("a", "flat"), ("b", "flat"), ("a", "b")]:
            waves = statistics.pstdev(x - y for x, y in zip(ranges[a], ranges[b]) if abs(x - y) < 0.02)
            self.assertTrue(0.0008 < waves < 0.004, (a, b, waves))

    def test_a_capture_says_what_it_shows(self):
        folder = Folder(self)
        simulate(folder / "a.pcapng", "--scene", "yard", "--frames", "1")
        self.assertIn(b"a simulated yard", (folder / "a.pcapng").read_bytes())


if __name__ == "__main__":
    unittest.main()
