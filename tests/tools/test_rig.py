#!/usr/bin/env python3
"""lumdump --rig: several sensors, each by its own calibration, profile and pose. Two of them have one address."""
import itertools
import json
import math
import pathlib
import struct
import subprocess
import tempfile
import unittest

import mcap_file
import png_rows
from support import BIN, Folder, interface, packet, read_csv, run, section, simulate, summary

LEFT_CALIBRATION = "eyes:\n  green:\n    mount: {x_m: 0.2, yaw_deg: 3}\n  blue:\n    mount: {z_m: -0.1, roll_deg: 1}\n"
REAR_PROFILE = "data_packet_type: 9\n"
RIG = """version: 1
frame: car
sensors:
  - {name: front, address: 10.42.0.37, interface: eth0, pose: {x_m: 1.2, z_m: 1.8}}
  - {name: left, address: 10.42.0.37%eth1, calibration: left.yaml, pose: {y_m: 0.9, yaw_deg: 90, pitch_deg: 5}}
  - {name: rear, address: 10.42.0.38, profile: rear.yaml, pose: {x_m: -3, yaw_deg: 180, roll_deg: -4}}
"""
POSES = {"front": ((1.2, 0, 1.8), (0, 0, 0)), "left": ((0, 0.9, 0), (0, 5, 90)), "rear": ((-3, 0, 0), (-4, 0, 180))}
NAMES = tuple(POSES)
OWN = {"front": (), "left": ("--calibration", "left.yaml"), "rear": ("--profile", "rear.yaml")}
FEW = ("--range", "30:40", "--return", "first")  # points enough
EPOCH = 1767225600
EXACT = ("range", "azimuth", "elevation", "frame", "eye", "line", "pixel")


def placed(pose, p):
    at, (roll, pitch, yaw) = pose[0], [math.radians(a) for a in pose[1]]
    x, y, z = p
    y, z = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    x, z = x * math.cos(pitch) + z * math.sin(pitch), -x * math.sin(pitch) + z * math.cos(pitch)
    x, y = x * math.cos(yaw) - y * math.sin(yaw), x * math.sin(yaw) + y * math.cos(yaw)
    return x + at[0], y + at[1], z + at[2]


def datagrams(path):
    data, at = path.read_bytes(), 24
    while at < len(data):
        seconds, fraction, length = struct.unpack_from("<III", data, at)
        yield seconds * 1_000_000 + (fraction // 1000 if data[:4] == b"\x4d\x3c\xb2\xa1" else fraction), data[at + 16:at + 16 + length]
        at += 16 + length


def merged(captures):
    """Captures by their interface, as one pcapng in order of time."""
    names = sorted({name for name, _ in captures})
    found = sorted((us, names.index(name), frame) for name, path in captures for us, frame in datagrams(path))
    return (section() + b"".join(interface(name=n.encode()) for n in names) +
            b"".join(packet(frame, index, us) for us, index, frame in found))


def xyz(row):
    return [float(row[axis]) for axis in "xyz"]


class Rig(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.at = pathlib.Path(folder.name)
        (cls.at / "left.yaml").write_text(f"version: 1\n{LEFT_CALIBRATION}")
        (cls.at / "rear.yaml").write_text(f"version: 1\n{REAR_PROFILE}")
        (cls.at / "rig.yaml").write_text(RIG)
        one = ("--frames", 2, "--returns-max", 1)
        cls.alone = {
            "front": simulate(cls.at / "front.pcap", "--seed", 1, *one),
            "left": simulate(cls.at / "left.pcap", "--seed", 2, *one),
            "rear": simulate(cls.at / "rear.pcap", "--seed", 3, "--address", "10.42.0.38", "--profile", cls.at / "rear.yaml", *one)}
        cls.on = {"front": "eth0", "left": "eth1", "rear": "eth0"}
        cls.drive = cls.at / "drive.pcapng"
        cls.drive.write_bytes(merged([(cls.on[name], path) for name, path in cls.alone.items()]))
        cls.own = {}
        for name, path in cls.alone.items():
            done = run("lumdump", path, "-q", *OWN[name], *FEW, "-o", cls.at / f"own-{name}.csv", cwd=cls.at)
            assert done.returncode == 0, done.stderr
            cls.own[name] = read_csv(cls.at / f"own-{name}.csv")

    def setUp(self):
        self.folder = Folder(self)

    def dump(self, *arguments, status=0, source=None, rig="rig.yaml", **options):
        done = run("lumdump", source or self.drive, "--rig", self.at / rig, *arguments, **options)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def refuse(self, says, *arguments, **options):
        self.assertIn(says, self.dump(*arguments, status=2, **options).stderr)

    def expect(self, name, rows, pose):
        self.assertEqual(len(rows), len(self.own[name]))
        for got, own in zip(rows, self.own[name]):
            self.assertEqual([got[key] for key in EXACT], [own[key] for key in EXACT])
            for a, b in zip(xyz(got), placed(pose, xyz(own))):
                self.assertAlmostEqual(a, b, delta=3e-4)

    def test_points_are_those_of_each_own_run_moved_by_its_pose(self):
        self.dump("-q", *FEW, "-o", self.folder / "all.csv", "-o", self.folder / "%s.csv")
        joined = read_csv(self.folder / "all.csv")
        for place, name in enumerate(NAMES):
            of_it = [row for row in joined if row["sensor"] == str(place)]
            self.expect(name, of_it, POSES[name])
            alone = read_csv(self.folder / f"{name}.csv")
            self.assertNotIn("sensor", alone[0])
            self.assertEqual(alone, [{key: row[key] for key in alone[0]} for row in of_it])
        self.assertEqual({row["sensor"] for row in joined}, {"0", "1", "2"})

    def test_times_of_several_sensors_are_utc(self):
        """Their clocks differ by up to a minute; those of one sensor stay its own."""
        poses = self.folder.write("p.txt", "".join(f"{t} 0 0 0 0 0 0 1\n" for t in range(20)))
        for of, joined in (("all", True), ("%s", False)):
            self.dump("-q", *FEW, "-o", self.folder / f"{of}.csv", "--comments")
            names = [of] if joined else NAMES
            for name in names:
                text = (self.folder / f"{name}.csv").read_text()
                self.assertEqual("--time=utc" in text, joined)
                lines = [line for line in text.splitlines() if not line.startswith("#")]
                at = lines[0].split(",").index("timestamp")
                self.assertGreater(len(lines), 1)
                for line in lines[1:]:
                    self.assertEqual(float(line.split(",")[at]) > EPOCH * 1e6, joined)
        self.refuse("--time sensor: each sensor has a clock of its own", "--time", "sensor", "-o", self.folder / "a.ply")
        self.dump("-q", *FEW, "--time", "sensor", "-o", self.folder / "%s.ply")
        self.refuse("has times of a sensor's clock, and each sensor of", "--poses", poses, "-o", self.folder / "a.ply")
        self.dump("-q", *FEW, "--sensor", "rear", "--poses", poses, "-o", self.folder / "a.ply")

    def test_threads_and_pipes_give_the_same_bytes(self):
        all_points = ("--frames", "1:1", "--eye", "green")  # their words go to the threads, and no samples
        for ending, choice in itertools.product(("csv", "ply", "pcd", "las", "xyz"), (FEW, all_points)):
            out = self.folder / f"out.{ending}"
            self.dump("-q", *choice, "--threads", 1, "-o", out)
            want = out.read_bytes()
            self.dump("-q", *choice, "--threads", 4, "-o", out)
            self.assertTrue(out.read_bytes() == want, ending)
            if choice is all_points:
                continue
            piped = subprocess.run([BIN / "lumdump", self.drive, "--rig", self.at / "rig.yaml", "-q", *FEW, "-o", "-", "--format", ending],
                                   capture_output=True, check=True)
            self.assertTrue(piped.stdout == want, ending)

    def test_a_box_is_of_the_vehicles_frame(self):
        self.dump("-q", *FEW, "-o", self.folder / "all.csv")
        self.dump("-q", *FEW, "--box", "-35:30,-36:33,:3", "-o", self.folder / "box.csv")
        limits = ((-35, 30), (-36, 33), (-math.inf, 3))
        want = [row for row in read_csv(self.folder / "all.csv") if all(a <= v <= b for v, (a, b) in zip(xyz(row), limits))]
        self.assertGreater(len(want), 100)
        self.assertEqual({row["sensor"] for row in want}, {"0", "1", "2"})
        self.assertEqual(read_csv(self.folder / "box.csv"), want)

    def test_what_the_rig_reads_is_not_overwritten(self):
        for name, what in (("rig.yaml", "the rig"), ("left.yaml", "a calibration of the rig"), ("rear.yaml", "a profile of the rig")):
            kept = (self.at / name).read_bytes()
            self.refuse(f"{name} is {what}, which this run reads", "--format", "csv", "-o", self.at / name)
            self.assertEqual((self.at / name).read_bytes(), kept)
        self.refuse("standard input can be read only once: --rig and the source", source="-", rig="/dev/stdin")

    def test_one_sensor_by_its_name(self):
        self.dump("-q", *FEW, "--sensor", "left", "-o", self.folder / "a.csv")
        rows = read_csv(self.folder / "a.csv")
        self.assertNotIn("sensor", rows[0])
        self.expect("left", rows, POSES["left"])
        self.dump("-q", *FEW, "--sensor", "left", "--columns", "x,sensor", "--frames", "whole:1", "-o", self.folder / "b.csv")
        self.assertEqual({row["sensor"] for row in read_csv(self.folder / "b.csv")}, {"1"})
        done = self.dump("--json", "--sensor", "left")
        got = json.loads(done.stdout)
        self.assertEqual((done.stderr, got["rig"]["missing"], got["rig"]["unnamed"]), ("", [], []))  # rear's profile is its own
        self.assertEqual([s["rig_name"] for s in got["sensors"]], ["left"])
        self.assertEqual((got["data"], got["unknown_type"]), (summary(self.alone["left"])["data"], 0))
        text = self.dump("--sensor", "left").stdout
        for name in ("front", "rear"):
            self.assertRegex(text, rf"{name}  10\.42\.0\.3[78].*  left out: another was chosen")
        self.refuse("'right' is not a sensor of", "--sensor", "right", "-o", self.folder / "a.csv")

    def test_files_say_of_which_sensors_they_are(self):
        self.dump("-q", *FEW, "-o", self.folder / "a.ply", "-o", self.folder / "%s.ply")
        self.dump("-q", "-o", self.folder / "%s.pcapng")
        text = (self.folder / "a.ply").read_bytes().split(b"end_header")[0].decode()
        self.assertIn("property uchar scalar_sensor\n", text)
        for line in ("0: front, 10.42.0.37%eth0, calibration built-in, profile built-in, at 1.200000 0.000000 1.800000 m",
                     "1: left, 10.42.0.37%eth1, calibration left.yaml", "2: rear, 10.42.0.38, calibration built-in, profile rear.yaml"):
            self.assertIn(line, text)
        text = (self.folder / "left.ply").read_bytes().split(b"end_header")[0].decode()
        self.assertIn("1: left,", text)
        self.assertNotIn("front", text)
        self.assertIn("yaw_deg: 3", text)
        for name in NAMES:  # a capture of one sensor has its calibration and profile, and is its own again
            done = run("lumdump", self.folder / f"{name}.pcapng", "-q", *FEW, "-o", self.folder / "again.csv")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.expect(name, read_csv(self.folder / "again.csv"), ((0, 0, 0), (0, 0, 0)))

    def test_a_file_a_frame_of_each(self):
        self.dump("-q", *FEW, "-o", self.folder / "f-%s-%02d.csv")
        self.assertEqual(self.folder.names(), sorted(f"f-{n}-{i:02}.csv" for n in NAMES for i in (1, 2)))
        for name in NAMES:
            rows = [row for i in (1, 2) for row in read_csv(self.folder / f"f-{name}-{i:02}.csv")]
            self.assertEqual(len(rows), len(self.own[name]))
        self.dump("-q", "--organized", *FEW, "-o", self.folder / "g-%s-%d.pcd", "-o", self.folder / "%s.png")
        self.assertIn("g-rear-2.pcd", self.folder.names())
        self.assertIn("front.png", self.folder.names())

    def test_a_picture_shows_what_the_eyes_see_wherever_they_are_on_the_vehicle(self):
        alone, size = self.folder / "alone.png", ("--size", "640x640")
        self.dump("-q", "--sensor", "rear", *size, "-o", self.folder / "%s.png")
        self.assertEqual(run("lumdump", self.alone["rear"], "-q", *OWN["rear"], *size, "-o", alone, cwd=self.at).returncode, 0)
        images = [png_rows.rows(path.read_bytes())[520:616] for path in (self.folder / "rear.png", alone)]
        same = [a == b for one, other in zip(*images) for a, b in zip(*(png_rows.colours(row, 40, 629) for row in (one, other)))]
        self.assertGreater(sum(same) / len(same), 0.99)

    def test_messages_have_topics_and_frames_of_each_sensor(self):
        self.dump("-q", *FEW, "-o", self.folder / "a.mcap", "--compression", "none")
        file = mcap_file.File((self.folder / "a.mcap").read_bytes())
        self.assertEqual(set(file.topics.values()), {*(f"/{n}/points" for n in NAMES), "/tf_static", "/diagnostics"})
        for name in NAMES:
            clouds = [mcap_file.cloud_of(m) for m in file.of(f"/{name}/points")]
            got = sorted(p[:3] for c in clouds for p in c.points)
            want = sorted(tuple(xyz(row)) for row in self.own[name])  # in its own frame
            self.assertEqual(len(got), len(want))
            for a, b in zip(sorted(p[2] for p in got), sorted(p[2] for p in want)):
                self.assertAlmostEqual(a, b, delta=1e-4)
            b = mcap_file.cdr(file.of(f"/{name}/points")[0])
            b.take(8)
            self.assertEqual(b.text(), name)
        self.assertEqual(file.attachments.keys(), {"calibration-left.yaml", "profile-rear.yaml"})
        (message,) = file.of("/tf_static")
        got = self.transforms(message)
        self.assertEqual([t[:2] for t in got], [pair for n in NAMES for pair in
                                                (("car", n), (n, f"{n}_blue"), (n, f"{n}_green"))])
        by_child = {child: (at, turn) for _, child, at, turn in got}
        for name in NAMES:
            for a, b in zip(by_child[name][0], POSES[name][0]):
                self.assertAlmostEqual(a, b, places=9)
        half = math.radians(45)
        self.assertAlmostEqual(by_child["left"][1][3], math.cos(half) * math.cos(math.radians(2.5)), places=9)
        self.assertAlmostEqual(by_child["left_green"][0][0], 0.2, places=9)

    def transforms(self, message):
        b = mcap_file.cdr(message)
        out = []
        for _ in range(b.number(4)):
            b.number(4), b.number(4)
            parent, child = b.text(), b.text()
            b.take(-b.at % 8)
            numbers = struct.unpack("<7d", b.take(56))
            out.append((parent, child, numbers[:3], numbers[3:]))
        return out

    def test_poses_are_the_vehicles(self):
        poses = self.folder.write("poses.txt", "".join(f"{EPOCH + t / 10} 10 20 0.5 0 0 1 0\n" for t in range(0, 120)))
        self.dump("-q", *FEW, "--poses", poses, "-o", self.folder / "a.csv", "-o", self.folder / "a.mcap", "--compression", "none")
        rows = read_csv(self.folder / "a.csv")
        for place, name in enumerate(NAMES):
            got = sorted(tuple(xyz(row)) for row in rows if row["sensor"] == str(place))
            want = sorted((10 - x, 20 - y, 0.5 + z) for x, y, z in (placed(POSES[name], xyz(r)) for r in self.own[name]))
            for axis in range(3):
                for a, b in zip(sorted(p[axis] for p in got), sorted(p[axis] for p in want), strict=True):
                    self.assertAlmostEqual(a, b, delta=3e-3)
        file = mcap_file.File((self.folder / "a.mcap").read_bytes())
        self.assertEqual(file.of("/tf_static"), [])
        b = mcap_file.cdr(file.of("/left/points")[0])
        b.take(8)
        self.assertEqual(b.text(), "map")

    def test_one_map_of_all(self):
        poses = self.folder.write("poses.txt", "".join(f"{EPOCH + t / 10} 0 0 0 0 0 0 1\n" for t in range(0, 120)))
        done = self.dump("--json", *FEW, "--poses", poses, "--voxel", 0.5, "-o", self.folder / "map.csv")
        got = json.loads(done.stdout)
        self.assertEqual(got["voxels"]["points"], sum(map(len, self.own.values())))
        self.assertEqual(sum(int(row["points"]) for row in read_csv(self.folder / "map.csv")), got["voxels"]["points"])
        self.refuse("one map of all sensors", "--poses", poses, "--voxel", 1, "-o", self.folder / "%s.csv")

    def test_the_summary_names_each(self):
        got = json.loads(self.dump("--json").stdout)
        self.assertEqual({s["rig_name"]: s["points"] for s in got["sensors"]},
                         {n: summary(*[self.alone[n], *(a if a.startswith("-") else self.at / a for a in OWN[n])])["points"] for n in NAMES})
        self.assertEqual((got["rig"]["missing"], got["rig"]["unnamed"]), ([], []))
        text = self.dump().stdout
        for name in NAMES:
            self.assertIn(f"{name}  10.42.0.3", text)

    def test_sensors_that_only_one_of_both_has_are_named(self):
        (self.at / "other.yaml").write_text("version: 1\nsensors:\n  - {name: rear, address: 10.42.0.38, profile: rear.yaml}\n"
                                            "  - {name: top, address: 10.42.0.40}\n")
        done = self.dump("--json", rig="other.yaml")
        self.assertIn("the rig's sensor 10.42.0.40 sent no data", done.stderr)
        self.assertIn("2 sensors sent data and are not in the rig", done.stderr)
        text = self.dump(rig="other.yaml").stdout
        self.assertRegex(text, r"[0-9]+ packets; this line adds it: - {name: sensor[0-9], address: 10.42.0.37, interface: eth1}")
        self.assertIn("top  no data came from it", text)
        got = json.loads(done.stdout)
        self.assertEqual(got["rig"]["missing"], ["top"])
        self.assertEqual([(u["address"], u["packets"]) for u in got["rig"]["unnamed"]], [("10.42.0.37", summary(self.alone["front"])["data"]), ("10.42.0.37%eth1", summary(self.alone["left"])["data"])])
        self.assertEqual([s["rig_name"] for s in got["sensors"]], ["rear"])
        (self.at / "none.yaml").write_text("version: 1\nsensors:\n  - {name: top, address: 10.42.0.40}\n")
        done = self.dump("-o", self.folder / "a.csv", status=1, rig="none.yaml")
        self.assertIn("no data of top (10.42.0.40) in it", done.stderr)
        (self.at / "none.yaml").write_text("version: 1\nsensors:\n  - {name: front, address: 10.42.0.37%eth0}\n")
        done = self.dump("-o", self.folder / "a.csv", status=1, source=self.alone["front"], rig="none.yaml")  # a pcap file
        self.assertIn("did, on an unknown interface: record with", done.stderr)
        self.assertEqual(self.folder.names(), [])

    def test_without_a_rig_it_says_what_one_would_do(self):
        done = run("lumdump", self.drive, "-o", self.folder / "a.csv")
        self.assertEqual(done.returncode, 2)
        self.assertIn("choose one by --sensor:", done.stderr)
        self.assertIn("read all of them, each by its own calibration and pose, by --rig FILE", done.stderr)
        told = self.folder.write("told.yaml", done.stderr[done.stderr.index("version: 1"):])
        self.assertIn("- {name: sensor2, address: 10.42.0.37, interface: eth1}", told.read_text())
        self.dump("-q", *FEW, "-o", self.folder / "a.csv", rig=told)
        self.assertIn("--rig FILE reads all of them", run("lumdump", self.drive).stdout)

    def test_a_sensor_that_names_no_interface_is_none_of_those_that_others_name(self):
        (self.at / "first.yaml").write_text(RIG.replace(", interface: eth0", ""))
        self.dump("-q", *FEW, "-o", self.folder / "%s.csv", rig="first.yaml")
        self.dump("-q", "-o", self.folder / "%s.pcapng", rig="first.yaml")
        for name in ("front", "left"):
            self.expect(name, read_csv(self.folder / f"{name}.csv"), POSES[name])
            self.assertEqual(summary(self.folder / f"{name}.pcapng")["data"], summary(self.alone[name])["data"], name)
        got = json.loads(self.dump("--json", rig="first.yaml").stdout)
        self.assertEqual({s["rig_name"]: s.get("interface") for s in got["sensors"]}, {"front": "eth0", "left": "eth1", "rear": None})
        self.assertEqual(self.dump("--sensor", "left", "-q", *FEW, "-o", self.folder / "a.csv", rig="first.yaml").stderr, "")
        self.expect("left", read_csv(self.folder / "a.csv"), POSES["left"])
        self.assertEqual(self.dump("--sensor", "front", "-q", *FEW, "-o", self.folder / "b.csv", rig="first.yaml").stderr, "")
        self.expect("front", read_csv(self.folder / "b.csv"), POSES["front"])

    def test_a_file_that_keeps_no_calibration_says_so(self):
        self.assertIn("a.pcap: a capture of several sensors has no room for the calibrations and profiles of",
                      self.dump("-o", self.folder / "a.pcap", rig=self.apart()).stderr)
        said = self.dump("-o", self.folder / "%s.pcap").stderr
        self.assertIn("left.pcap: pcap has no room for the calibration that is used", said)
        self.assertIn("rear.pcap: pcap has no room for the profile that is used", said)
        self.assertNotIn("front.pcap:", said)

    def apart(self):
        """A rig of sensors with an address each."""
        (self.at / "apart.yaml").write_text("".join(line for line in RIG.splitlines(True) if "front" not in line).replace("%eth1", ""))
        return "apart.yaml"

    def test_rotated_captures_begin_with_a_frame_of_their_sensor(self):
        self.dump("-q", "--rotate", "1MB", "-o", self.folder / "%s.pcapng")
        for name in NAMES:
            files = [self.folder / n for n in self.folder.names() if n.startswith(name)]
            self.assertGreater(len(files), 1)
            parts = [summary(f) for f in files]
            self.assertEqual(sum(p["data"] for p in parts), summary(self.alone[name], *(self.at / a if ".yaml" in a else a for a in OWN[name]))["data"])
            self.assertEqual([p["frames"] for p in parts], [1] * len(parts))

    def test_a_calibration_of_the_capture_is_not_taken(self):
        done = run("lumdump", self.alone["left"], "-q", "--calibration", self.at / "left.yaml", "-o", self.folder / "own.pcapng")
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.at / "bare.yaml").write_text("version: 1\nsensors:\n  - {name: left, address: 10.42.0.37}\n")
        done = self.dump(*FEW, "-o", self.folder / "a.csv", source=self.folder / "own.pcapng", rig="bare.yaml")
        self.assertIn("it has a calibration of its own, which is not used", done.stderr)
        (self.at / "own.yaml").write_text((self.at / "bare.yaml").read_text().replace("}", ", calibration: left.yaml}"))
        done = self.dump(*FEW, "-o", self.folder / "c.csv", source=self.folder / "own.pcapng", rig="own.yaml")
        self.assertNotIn("warning", done.stderr)
        done = run("lumdump", self.alone["left"], "-q", *FEW, "-o", self.folder / "b.csv")
        self.assertEqual([xyz(r) for r in read_csv(self.folder / "a.csv")], [xyz(r) for r in read_csv(self.folder / "b.csv")])

    def test_what_does_not_go_together_is_refused(self):
        out = self.folder
        for says, arguments in (
                ("--calibration does not go with --rig", ("--calibration", self.at / "left.yaml")),
                ("--profile does not go with --rig", ("--profile", self.at / "rear.yaml")),
                ("--set does not go with --rig", ("--set", "speed_of_light=299792458")),
                ("--frame-id does not go with --rig", ("--frame-id", "a", "-o", out / "a.mcap")),
                ("a picture shows one sensor: put %s into the name", ("-o", out / "a.png")),
                ("the rows of --organized are of one sensor", ("--organized", "--return", "first", "--frames", "1:1", "-o", out / "a.pcd")),
                ("have no common numbers: put %s into the name", ("-o", out / "a-%d.csv")),
                ("two sensors of the rig have one address", ("-o", out / "a.pcapng")),
                ("make them by two runs", ("-o", out / "a.mcap", "-o", out / "a.csv")),
                ("--box is in the vehicle's frame, and mcap", ("--box", ":1,:,:", "-o", out / "a.mcap")),
                ("whole:N is of one sensor", ("--frames", "whole:1", "-o", out / "a.csv")),
                ("cut the capture of one sensor", ("--frames", "1:1", "-o", out / "%s.pcap")),
                ("has to be there once", ("-o", out / "%s-%s.csv")),
                ("there are more than 16 outputs", itertools.chain(*(("-o", out / f"{i}-%s.csv") for i in range(6))))):
            self.refuse(says, *arguments)
        done = run("lumdump", self.drive, "--sensor", "10.42.0.38", "-o", out / "%s.csv")
        self.assertEqual((done.returncode, "give --rig FILE too" in done.stderr), (2, True))
        done = run("lumdump", self.drive, "--sensor", "10.42.0.38", "--columns", "x,sensor", "-o", out / "a.csv")
        self.assertEqual((done.returncode, "give --rig FILE too" in done.stderr), (2, True))
        done = run("lumdump", "udp://10.42.0.39", "--rig", self.at / "rig.yaml", "-o", out / "a.csv")
        self.assertEqual((done.returncode, "a live run reads one" in done.stderr), (2, True))
        done = run("lumdump", "udp://10.42.0.37", "--rig", self.at / "rig.yaml", "-o", out / "a.csv")
        self.assertEqual((done.returncode, "--sensor NAME where two share one" in done.stderr), (2, True))
        self.assertEqual(self.folder.names(), [])


if __name__ == "__main__":
    unittest.main()
