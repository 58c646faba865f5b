#!/usr/bin/env python3
"""lumsim with --rig, from outside: the packets of each sensor, what is true of it, what is lost of it, and refusals."""
import bisect
import collections
import math
import os
import re
import struct
import unittest

from support import Folder, ip, run, simulate, summary
from test_moving import labels, poses
from test_scene import columns

LEAKS = {**os.environ, "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":detect_leaks=1"}
EPOCH = 1767225600
# Of each: name, address, interface, x, y, z, yaw; two have one address.
FRONT = ("front", "10.42.0.37", "eth0", 1.2, 0.0, 1.7, 0.0)
LEFT = ("left", "10.42.0.37", "eth1", 0.1, 0.3, 1.5, 90.0)
REAR = ("rear", "10.42.0.39", "eth0", -0.5, -0.1, 1.6, -170.0)
RIG = (FRONT, LEFT, REAR)
FILES = {"front": "", "left": ", calibration: left.yaml", "rear": ", calibration: rear.yaml, profile: rear-profile.yaml"}
NAMES = "frame line eye pixel return_number"


def write_rig(folder, *sensors, name="rig.yaml"):
    folder.write("left.yaml", "version: 1\neyes: {blue: {tof_offset_ps: 800, mount: {x_m: 0.02, yaw_deg: -31}}}\n")
    folder.write("rear.yaml", "version: 1\ntof_lsb_ps: 12.5\neyes: {green: {mount: {y_m: -0.05, yaw_deg: 29}}}\n")
    folder.write("rear-profile.yaml", "version: 1\ngroup: {line: {at: 14, order: big}}\n")
    lines = [f"  - {{name: {n}, address: {a}, interface: {i}, pose: {{x_m: {x}, y_m: {y}, z_m: {z}, yaw_deg: {yaw}}}"
             f"{FILES[n]}}}\n" for n, a, i, x, y, z, yaw in sensors]
    return folder.write(name, "version: 1\nsensors:\n" + "".join(lines))


def blocks(data):
    """The interfaces of a pcapng file, and its packets: interface, nanoseconds, source, payload."""
    names, packets, at = [], [], 0
    while at < len(data):
        kind, length = struct.unpack_from("<II", data, at)
        if kind == 1:
            code, size = struct.unpack_from("<HH", data, at + 16)
            names.append(data[at + 20:at + 20 + size].decode() if code == 2 else "")
        elif kind == 6:
            index, high, low, size = struct.unpack_from("<IIII", data, at + 8)
            frame = data[at + 28:at + 28 + size]
            packets.append((index, high << 32 | low, frame[26:30], frame[42:]))
        at += length
    return names, packets


def packets_of(path, sensor):
    """Times and payloads of one sensor."""
    names, packets = blocks(path.read_bytes())
    return [(ns, payload) for i, ns, source, payload in packets if names[i] == sensor[2] and source == ip(sensor[1])]


def alone(packets):
    """The same of the capture of one sensor."""
    return [(ns, payload) for _, ns, _, payload in blocks(packets.read_bytes())[1]]


def moved(pose, point):
    """By x, y, z, yaw."""
    c, s = math.cos(math.radians(pose[3])), math.sin(math.radians(pose[3]))
    return (pose[0] + c * point[0] - s * point[1], pose[1] + s * point[0] + c * point[1], pose[2] + point[2])


def files_of(folder, sensor):
    """The options of a run of that sensor alone."""
    of = {"front": (), "left": ("--calibration", folder / "left.yaml"),
          "rear": ("--calibration", folder / "rear.yaml", "--profile", folder / "rear-profile.yaml")}
    return of[sensor[0]]


class Sensors(unittest.TestCase):
    def test_each_is_what_it_is_alone_where_it_stands(self):
        vehicle = (0.3, -0.2, -0.2, 40.0)
        for first in range(3):
            sensors = RIG[first:] + RIG[:first]
            name, address, interface, x, y, z, yaw = sensors[0]
            with self.subTest(name):
                folder = Folder(self)
                rig = write_rig(folder, *sensors)
                scene = "--scene", "room", "--walls", "mild", "--frames", 2, "--seed", 5
                pose = ",".join(map(str, vehicle[:3])) + ",0,0,40"
                simulate(folder / "rig.pcapng", *scene, "--rig", rig, f"--pose={pose}")
                at = [round(v, 9) for v in moved(vehicle, (x, y, z))]
                turned = (vehicle[3] + yaw + 180) % 360 - 180
                simulate(folder / "one.pcapng", *scene, *files_of(folder, sensors[0]),
                         f"--pose={','.join(map(str, at))},0,0,{turned}")
                own = packets_of(folder / "rig.pcapng", sensors[0])
                self.assertEqual(len(own), len(alone(folder / "one.pcapng")))
                # Times and clocks too. Places are equal but for rounding, so a word in some thousands differs by one.
                same = [a == b for a, b in zip(own, alone(folder / "one.pcapng"))]
                self.assertEqual([t for t, _ in own], [t for t, _ in alone(folder / "one.pcapng")])
                self.assertGreater(sum(same), 0.95 * len(same))

    def test_the_first_is_one_alone_on_its_way(self):
        folder = Folder(self)
        for height, *scene in ((1.5, "--scene", "yard", "--path", "eight"), (1.8, "--path", "straight", "--velocity", 12),
                               (1.2, "--scene", "room")):
            here = (*LEFT[:3], 0, 0, height, 0)  # the vehicle's frame is on the ground
            rig = write_rig(folder, here, FRONT, REAR)
            with self.subTest(scene):
                simulate(folder / "rig.pcapng", *scene, "--rig", rig, "--frames", 2, "--drift", 40)
                simulate(folder / "one.pcapng", *scene, "--frames", 2, "--drift", 40, *files_of(folder, LEFT))
                self.assertEqual(packets_of(folder / "rig.pcapng", here), alone(folder / "one.pcapng"))

    def test_a_street_is_driven_along(self):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        simulate(folder / "a.pcapng", "--rig", rig, "--frames", 2)
        simulate(folder / "b.pcapng", "--rig", rig, "--frames", 2, "--path", "straight")
        self.assertEqual((folder / "a.pcapng").read_bytes(), (folder / "b.pcapng").read_bytes())

    def test_they_run_freely_and_come_by_time(self):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        simulate(folder / "a.pcapng", "--rig", rig, "--frames", 4, "--scene", "room", "--rate", 20)
        names, packets = blocks((folder / "a.pcapng").read_bytes())
        self.assertEqual(names, ["eth0", "eth1"])
        times = [ns for _, ns, _, _ in packets]
        self.assertEqual(times, sorted(times))
        begins, clocks = [], []
        for sensor in RIG:
            own = packets_of(folder / "a.pcapng", sensor)
            begins.append(own[0][0] / 1e9 - EPOCH - 5)
            clocks.append(struct.unpack_from("<I", own[0][1], 20)[0] / 1e6)
            lasts = own[-1][0] - own[0][0]
            self.assertLess(abs(lasts / 0.2e9 - 1), 0.001)
        self.assertLess(begins[0], 1e-4)
        self.assertTrue(all(0.0025 < b < 0.0476 for b in begins[1:]), begins)
        self.assertGreater(abs(begins[1] - begins[2]), 1e-3)
        self.assertEqual(clocks[0], 5)
        self.assertTrue(all(5 <= c < 65 for c in clocks) and len(set(clocks)) == 3, clocks)

    def test_the_seed_decides(self):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        options = "--rig", rig, "--frames", 1, "--scene", "room", "--loss", 0.1, "--duplicate", 0.1, "--reorder", 0.1
        for name, seed in (("a", 1), ("b", 1), ("c", 2)):
            simulate(folder / f"{name}.pcapng", *options, "--seed", seed)
        self.assertEqual((folder / "a.pcapng").read_bytes(), (folder / "b.pcapng").read_bytes())
        begins = [packets_of(folder / f"{name}.pcapng", LEFT)[0][0] for name in "ac"]
        self.assertGreater(abs(begins[0] - begins[1]), 100_000)

    def test_a_rig_without_interfaces_is_a_pcap_too(self):
        folder = Folder(self)
        rig = folder.write("rig.yaml", "version: 1\nsensors:\n  - {name: a, address: 10.42.0.37, pose: {z_m: 1.8}}\n  - {name: b, "
                                       "address: 10.42.0.38, pose: {z_m: 1.8, yaw_deg: 180}}\n")
        simulate(folder / "a.pcap", "--rig", rig, "--frames", 1)
        simulate(folder / "a.pcapng", "--rig", rig, "--frames", 1)
        self.assertEqual(blocks((folder / "a.pcapng").read_bytes())[0], [""])
        for name in ("a.pcap", "a.pcapng"):
            self.assertEqual([s["address"] for s in summary(folder / name)["sensors"]], ["10.42.0.37", "10.42.0.38"])


class Truth(unittest.TestCase):
    def make(self, *options):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        simulate(folder / "a.pcapng", "--rig", rig, "--frames", 1, "--noise", 0, "--truth", folder / "t-%s.csv",
                 "--truth", folder / "c-%s.yaml", "--labels", folder / "l-%s.npy", "--poses", folder / "p.txt",
                 "--time", "utc", *options)
        return folder

    def test_points_are_the_sensors_own_moved_by_its_pose(self):
        folder = self.make("--scene", "town", "--path", "circle")
        for sensor in RIG:
            name, address, interface, *pose = sensor
            with self.subTest(name):
                r = run("lumdump", folder / "a.pcapng", "-q", "-o", folder / "d.csv", "--sensor", f"{address}%{interface}",
                        *files_of(folder, sensor)[2:], "--calibration", folder / f"c-{name}.yaml")
                self.assertEqual((r.returncode, r.stderr), (0, ""))
                own = columns(folder / "d.csv", f"{NAMES} x y z range")
                true = columns(folder / f"t-{name}.csv", f"{NAMES} x y z range")
                self.assertEqual([row[:5] for row in own], [row[:5] for row in true])
                self.assertGreater(len(own), 20_000)
                # 4 mm of a word, and 0.018 degrees of an encoder and half a bit in both angles
                worst = max(math.dist(moved(pose, a[5:8]), b[5:8]) / (0.004 + 0.00045 * b[8]) for a, b in zip(own[::5], true[::5]))
                self.assertLess(worst, 1)

    def test_all_see_one_world_from_the_vehicles_poses(self):
        folder = self.make("--scene", "yard", "--path", "eight", "--velocity", 3)
        times, rows = poses(folder / "p.txt")
        seconds = [float(t) - EPOCH for t in times]
        headings = [2 * math.degrees(math.atan2(row[5], row[6])) for row in rows]
        for name, *_ in RIG:
            true = columns(folder / f"t-{name}.csv", f"{NAMES} x y z timestamp")
            walls = 0
            for row in true[::7]:
                t = (row[8] - EPOCH * 1e6) * 1e-6 + row[3] * 1e-3 * 0.1 / 64
                i = bisect.bisect(seconds, t)
                self.assertTrue(0 < i < len(seconds), (name, t))
                share = (t - seconds[i - 1]) / (seconds[i] - seconds[i - 1])
                at = [a + share * (b - a) for a, b in zip(rows[i - 1], rows[i])]
                yaw = headings[i - 1] + share * (headings[i] - headings[i - 1])
                x, y, z = moved((*at[:3], yaw), row[5:8])
                off = min(abs(abs(x) - 15), abs(abs(y) - 10), abs(z))
                walls += off < 0.003
                self.assertLess(abs(x), 15.003)
                self.assertLess(abs(y), 10.003)
                self.assertGreater(z, -0.003)
            self.assertGreater(walls, 0.4 * len(true[::7]))

    def test_labels_have_a_row_for_each_point(self):
        folder = self.make("--scene", "room")
        rows = labels(folder / "l-left.npy")[1]
        self.assertEqual(sorted((f, n, e, p, r) for f, n, _, p, r, e, *_ in rows), sorted(columns(folder / "t-left.csv", NAMES)))
        self.assertIn("l-rear.npy", folder.names())
        self.assertEqual(len({row[0] for row in poses(folder / "p.txt")[1]}), 1)  # it stands


class Losses(unittest.TestCase):
    def test_what_is_lost_is_told_of_each(self):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        options = "--rig", rig, "--frames", 2, "--scene", "room"
        simulate(folder / "whole.pcapng", *options)
        r = run("lumsim", "-o", folder / "a.pcapng", *options, "--loss", 0.05, "--duplicate", 0.02, env=LEAKS)
        self.assertEqual(r.returncode, 0, r.stderr)
        said = re.findall(r"^  (\w+): \d+ points in (\d+) packets; (\d+) lost; (\d+) repeated$", r.stderr, re.M)
        self.assertEqual([s[0] for s in said], ["front", "left", "rear"])
        for sensor, (_, count, lost, repeated) in zip(RIG, said):
            whole = collections.Counter(p for _, p in packets_of(folder / "whole.pcapng", sensor))
            left = collections.Counter(p for _, p in packets_of(folder / "a.pcapng", sensor))
            self.assertLessEqual(set(left), set(whole))
            self.assertEqual(sum(left.values()), int(count))
            self.assertEqual(sum(whole.values()) + int(repeated) - int(lost), int(count))
            self.assertTrue(0.02 < int(lost) / sum(whole.values()) < 0.1, lost)
        total = re.search(r"2 frames of 64 lines of each sensor, \d+ points in (\d+) packets; (\d+) lost", r.stderr)
        self.assertEqual([int(g) for g in total.groups()], [sum(int(s[i]) for s in said) for i in (1, 2)])


class Options(unittest.TestCase):
    def refused(self, *arguments, says, output="a.pcapng"):
        folder = Folder(self)
        write_rig(folder, *RIG)
        folder.write("same.yaml", "version: 1\nsensors:\n  - {name: a, address: 10.42.0.37}\n  - {name: b, address: 10.42.0.37}\n")
        folder.write("crossed.yaml", "version: 1\nsensors:\n  - {name: front, address: 10.42.0.37, calibration: rear.yaml, pose: {z_m: 1.8}}\n"
                                     "  - {name: rear, address: 10.42.0.38, pose: {z_m: 1.8}}\n")
        folder.write("low.yaml", "version: 1\nsensors:\n  - {name: a, address: 10.42.0.37}\n")
        folder.write("short.txt", "10 0 0 1.8 0 0 0 1\n10.5 1 0 1.8 0 0 0 1\n")
        folder.write("left.npy", "")
        before = folder.names()
        out = ("-o", output) if output else ()
        r = run("lumsim", "--rig", "rig.yaml", *out, *arguments, cwd=folder / ".", env=LEAKS)
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        self.assertRegex(r.stderr, says)
        self.assertEqual(sorted(folder.names()), sorted(before))

    def test_what_cannot_be_is_refused_with_what_is_right(self):
        for arguments, says in [
                (("-o", "a.pcap"), r"'front' has an interface, and a pcap file .*; use .* ends in \.pcapng"),
                (("-o", "-"), "a pcap file has no names of interfaces"),
                (("--calibration", "left.yaml"), "--calibration does not go with --rig, whose file says that of each"),
                (("--profile", "left.yaml"), "--profile does not go with --rig"),
                (("--set", "tof_lsb_ps=13"), "--set does not go with --rig"),
                (("--address", "10.0.0.1"), "--address does not go with --rig"),
                (("--joined",), "--joined does not go with --rig"),
                (("--truth", "t.csv"), r"--truth: 't\.csv': with --rig each sensor has a file of its own, .* %s once"),
                (("--truth", "%s-%s.yaml"), "--truth: '%s-%s.yaml': .* %s once"),
                (("--labels", "l.npy"), "--labels: 'l.npy': with --rig"),
                (("--poses", "p.txt"), "clocks of its sensors differ, .* add --time utc"),
                (("--rig", "none.yaml"), "--rig: none.yaml: cannot be read"),
                (("--rig", "same.yaml"), "--rig: same.yaml.*10.42.0.37"),
                (("-o", "rig.yaml"), "--output: rig.yaml is the rig, which this run reads"),
                (("--truth", "%s.yaml"), "--truth: left.yaml is the calibration, which this run reads"),
                (("--rig", "crossed.yaml", "--truth", "%s.yaml"), "--truth: rear.yaml is the calibration, which this run reads"),
                (("--labels", "%s.npy", "-o", "left.npy"), "has an interface"),
                (("--path", "short.txt", "--frames", 5), r"last 0\.5 s, and 5 frames 0\.59\d+ s; use --frames 4"),
                (("--scene", "room", "--pose", "3.2,0,0,0,0,0"),
                 "--rig: the sensor 'front', with --pose: the blue eye would be outside the room"),
                (("--rig", "low.yaml", "--scene", "room"),
                 r"'a', with its pose on a vehicle that stands at 0,0,0 \(or use --pose\): the blue eye would be"),
                (("--path", "loop"), "--path: loop: cannot be read: .*; use straight, circle, eight, stop-and-go or"),
                (("--scene", "room", "--path", "circle", "--pose", "0,0,1.2,0,0,0"), "--path and --pose"),
                (("--interface", "lo"), "is for a sensor on the network; it does not go with -o")]:
            with self.subTest(arguments):
                self.refused(*arguments, says=says)

    def test_on_the_network_each_sensor_is_a_run(self):
        for arguments in ((), ("--replay", "a.pcap")):
            with self.subTest(arguments):
                self.refused(*arguments, output=None, says="only with -o FILE; on the network, run one lumsim for each")

    def test_a_path_from_a_file_lasts_for_all(self):
        folder = Folder(self)
        rig = write_rig(folder, *RIG)
        path = folder.write("path.txt", "10 0 0 1.8 0 0 0 1\n10.5 1 0 1.8 0 0 0 1\n")
        r = run("lumsim", "-o", folder / "a.pcapng", "--rig", rig, "--path", path, env=LEAKS)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("4 frames of 64 lines of each sensor", r.stderr)

    def test_quiet_says_nothing(self):
        folder = Folder(self)
        r = run("lumsim", "-q", "-o", folder / "a.pcapng", "--rig", write_rig(folder, *RIG), "--frames", 1, env=LEAKS)
        self.assertEqual((r.returncode, r.stdout, r.stderr), (0, "", ""))

    def test_the_capture_says_whose_it_is(self):
        folder = Folder(self)
        simulate(folder / "a.pcapng", "--rig", write_rig(folder, *RIG), "--frames", 1)
        data = (folder / "a.pcapng").read_bytes()
        self.assertIn(b'source: "a simulated street"\nrig:\n  - "front"\n  - "left"\n  - "rear"\n', data)
        self.assertNotIn(b"calibration", data)


if __name__ == "__main__":
    unittest.main()
