#!/usr/bin/env python3
"""lumdump -o drive.mcap: messages of ROS 2, from captures and live. Other readers: read_back_mcap.py."""
import collections
import itertools
import json
import math
import os
import pathlib
import signal
import struct
import subprocess
import unittest

import outages
import shards
import yaml
from live import Sensor, tool, wait_until
from mcap_file import File, statuses_of
from support import BIN, Folder, group, line, pcap, read_csv, run, simulate, udp, word

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

    def test_a_stray_of_a_break_is_among_all(self):
        capture = outages.Capture(BIN, self.folder.path, 64, 10, 6, 1)
        capture.without(210000, 170000)
        self.dump(capture.path, "-o", self.folder / "a.mcap", *PLAIN, "-q")
        losses = statuses_of(self.file("a.mcap").of("/diagnostics")[1])[0][3]
        self.assertEqual([losses[key] for key in ("pauses", "stray", "stray_at_breaks")], ["1", "2", "2"])

    def test_the_lines_of_a_frame_can_be_stated(self):
        source = self.street()
        for lines, first, highest in (("640", 640, 703), ("63", 63, 65535)):
            self.dump(source, "--lines", lines, "-o", self.folder / "a.mcap", *PLAIN)
            green = [p.ring for c in self.file("a.mcap").clouds() for p in c.points if p.eye == 1]
            self.assertEqual((min(green), max(green)), (first, highest))
        for arguments, says in ((("--lines", "64", "-o", "a.csv"), "--lines goes with mcap output only"),
                                (("--lines", "32768", "-o", "a.mcap"), "32767")):
            self.assertIn(says, self.dump(source, *arguments, status=2).stderr)

    def test_options_of_points_choose_beside_all_packets(self):
        source = self.street()
        self.dump(source, "--mcap", "frames,packets", "--range", "5:20", "--edge", "both", "-o", self.folder / "a.mcap", *PLAIN)
        self.dump(source, "--range", "5:20", "--edge", "both", "-o", self.folder / "b.mcap", *PLAIN)
        both, clouds = self.file("a.mcap"), self.file("b.mcap")
        self.assertTrue(both.clouds() == clouds.clouds())
        self.assertEqual(len(both.of("/datagrams")), json.loads(self.dump(source, "--json", "-q").stdout)["data"])

    def test_a_pipe_hears_of_losses_on_the_way(self):
        source = simulate(self.folder / "long.pcap", "--frames", "25", "--lines", "64", "--loss", "0.01")
        r = subprocess.run([BIN / "lumdump", source, "-o", "-", "--format", "mcap", "-q", *PLAIN], capture_output=True, check=True)
        told = [s for m in File(r.stdout).of("/diagnostics") for s in statuses_of(m)]
        data = [s for s in told if s[0] == "lumdump: data"]
        self.assertEqual([s[2] for s in data], ["packets come", "packets come", "the capture has ended"])
        lost = [int(s[3]["lost_words"]) for s in told if s[0] == "lumdump: losses"]
        self.assertTrue(0 < lost[0] < lost[1] < lost[2], lost)

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

    def test_another_frame_id(self):
        self.dump(self.street(), "-o", self.folder / "a.mcap", "--frame-id", "front", *PLAIN)
        file = self.file("a.mcap")
        self.assertIn(b"front_green\0", file.of("/tf_static")[0].data)
        self.assertTrue(all(b"front\0" in m.data[:40] for m in file.of("/points")))
        for name in "", "x" * 201:
            r = self.dump(self.street(), "-o", self.folder / "b.mcap", "--frame-id", name, status=2)
            self.assertIn("a name of 1 to 200 bytes", r.stderr)
        r = self.dump(self.street(), "-o", self.folder / "b.pcd", "--frame-id", "front", status=2)
        self.assertIn("--frame-id goes with mcap output only", r.stderr)

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


class Contents(Case):
    def csv(self, source, *arguments):
        self.dump(source, "-o", self.folder / "points.csv", "-q", *arguments)
        return (self.folder / "points.csv").read_bytes()

    def test_packets_give_the_points_that_they_came_from(self):
        source = self.street("--loss", "0.01")
        self.dump(source, "--mcap", "packets", "-o", self.folder / "a.mcap", "-o", self.folder / "a.pcap")
        file, name = self.file("a.mcap"), self.folder / "a.mcap"
        self.assertTrue(file.is_whole)
        self.assertEqual(list(file.topics.values()), ["/diagnostics", "/datagrams"])
        for choice in ((), ("--time", "utc", "--eye", "green")):
            self.assertEqual(self.csv(name, *choice), self.csv(source, *choice))
        self.dump(name, "-o", self.folder / "b.pcap")
        self.assertEqual((self.folder / "b.pcap").read_bytes(), (self.folder / "a.pcap").read_bytes())
        self.dump(name, "--mcap", "packets", "-o", self.folder / "b.mcap")
        self.assertEqual(len(self.file("b.mcap").metadata["lumsdk"]["provenance"].split("---\n")), 2)

    def test_packets_stand_beside_clouds(self):
        source = self.street()
        self.dump(source, "--mcap", "frames,packets", "-o", self.folder / "a.mcap", *PLAIN)
        self.dump(source, "-o", self.folder / "b.mcap", *PLAIN)
        file = self.file("a.mcap")
        self.assertTrue(file.clouds() == self.file("b.mcap").clouds())
        self.assertEqual(len(file.of("/tf_static")), 1)
        self.assertGreater(len(file.of("/datagrams")), 100)
        self.assertEqual(self.csv(self.folder / "a.mcap"), self.csv(source))

    def test_lines_have_the_points_of_frames(self):
        source = self.street("--loss", "0.01")
        self.dump(source, "--mcap", "lines", "-o", self.folder / "a.mcap", *PLAIN)
        self.dump(source, "-o", self.folder / "b.mcap", *PLAIN)
        lines, frames = self.file("a.mcap").clouds(), self.file("b.mcap").clouds()
        self.assertEqual(len({(p.ring, c.stamp_ns) for c in lines for p in c.points}), len(lines))

        def points(clouds):
            return sorted((p._replace(time=0), c.stamp_ns + round(p.time * 1e9)) for c in clouds for p in c.points)
        got, want = points(lines), points(frames)
        self.assertTrue([p for p, _ in got] == [p for p, _ in want], "other points")
        self.assertLess(max(abs(a - b) for (_, a), (_, b) in zip(got, want)), 100)
        stamps = [c.stamp_ns for c in lines]
        self.assertGreater(len(lines), 300)
        self.assertEqual(stamps, sorted(stamps))
        self.assertTrue(all(c.points[0].time == 0 for c in lines))

    def test_a_part_of_the_packets(self):
        source = self.street()
        self.dump(source, "--mcap", "packets", "--frames", "1:1", "-o", self.folder / "a.mcap", "-o", self.folder / "a.pcap")
        self.assertEqual(self.csv(self.folder / "a.mcap"), self.csv(self.folder / "a.pcap"))

    def test_files_that_rotate_are_read_together(self):
        source = simulate(self.folder / "street.pcap", "--frames", "8", "--seed", "5")
        self.dump(source, "--mcap", "packets", "--rotate", "1MB", "-o", self.folder / "r.mcap", *PLAIN)
        names = [self.folder / n for n in sorted(self.folder.names()) if n.startswith("r-")]
        self.assertGreater(len(names), 1)
        self.dump(*names, "-o", self.folder / "all.csv", "-q")
        self.assertEqual((self.folder / "all.csv").read_bytes(), self.csv(source))

    def test_what_packets_need_to_be_read_is_in_the_file(self):
        calibration = self.folder.write("c.yaml", "speed_of_light: 250000000\n")
        self.dump(self.street(), "--calibration", calibration, "--mcap", "packets", "-o", self.folder / "a.mcap")
        want = self.csv(self.street(), "--calibration", calibration)
        self.assertEqual(self.csv(self.folder / "a.mcap"), want)
        self.assertNotEqual(self.csv(self.street()), want)

    def test_what_does_not_go_together_is_refused(self):
        source, name = self.street(), self.folder / "a.mcap"
        for arguments, says in (
                (("--mcap", "frames,lines", "-o", name), "frames, lines or packets, or packets with one of the others"),
                (("--mcap", "packets,packets", "-o", name), "frames, lines or packets"),
                (("--mcap", "packets,", "-o", name), "frames, lines or packets"),
                (("--mcap", "packets", "-o", self.folder / "a.csv"), "--mcap goes with mcap output only"),
                (("--mcap", "packets"), "--mcap goes with mcap output only"),
                (("--mcap", "lines", "--preset", "pdal", "-o", name), "are of whole frames"),
                (("--mcap", "packets", "--preset", "pdal", "-o", name), "--preset goes with"),
                (("--mcap", "packets", "-o", self.folder / "f-%d.mcap"), "packets are not of one frame"),
                (("--mcap", "packets", "--range", "2:80", "-o", name), "a packet holds many points")):
            with self.subTest(arguments):
                r = self.dump(source, *arguments, status=2)
                self.assertIn(says, r.stderr)
                self.assertFalse(name.exists())


class Rosbag2(Case):
    def bag(self, source, *arguments, status=0):
        return self.dump(source, "-o", self.folder / "drive", "--format", "rosbag2", "-q", *arguments, status=status)

    def metadata(self):
        return yaml.safe_load((self.folder / "drive/metadata.yaml").read_text())["rosbag2_bagfile_information"]

    def test_a_folder_says_what_its_files_have(self):
        source = simulate(self.folder / "street.pcap", "--frames", "8", "--seed", "5")
        self.bag(source, "--mcap", "frames,packets", "--rotate", "6MB", *PLAIN)
        about = self.metadata()
        self.assertEqual((about["version"], about["storage_identifier"]), (5, "mcap"))
        self.assertGreater(len(about["files"]), 2)
        self.assertEqual(sorted(os.listdir(self.folder / "drive")), [*about["relative_file_paths"], "metadata.yaml"])
        counts, begins, ends = collections.Counter(), [], []
        for name, said in zip(about["relative_file_paths"], about["files"]):
            file = self.file(f"drive/{name}")
            self.assertTrue(file.is_whole)
            counts.update(m.topic for m in file.messages)
            times = [m.time for m in file.messages]
            self.assertEqual((said["path"], said["message_count"]), (name, len(times)))
            self.assertEqual(said["starting_time"]["nanoseconds_since_epoch"], min(times))
            self.assertEqual(said["duration"]["nanoseconds"], max(times) - min(times))
            begins.append(min(times)), ends.append(max(times))
        self.assertEqual(about["message_count"], counts.total())
        self.assertEqual(about["duration"]["nanoseconds"], max(ends) - min(begins))
        topics = {t["topic_metadata"]["name"]: t for t in about["topics_with_message_count"]}
        self.assertEqual({name: t["message_count"] for name, t in topics.items()}, counts)
        for name, qos in file.qos.items():
            self.assertEqual(topics[name]["topic_metadata"]["offered_qos_profiles"], qos)

    def test_a_folder_is_a_source(self):
        source = simulate(self.folder / "street.pcap", "--frames", "12", "--seed", "5")
        self.bag(source, "--mcap", "packets", "--rotate", "1s", *PLAIN)
        self.dump(source, "-o", self.folder / "a.csv", "-q")
        r = self.dump(self.folder / "drive", "-o", self.folder / "b.csv")
        self.assertEqual((self.folder / "a.csv").read_bytes(), (self.folder / "b.csv").read_bytes())
        # As after a kill, and beside what is no capture.
        (self.folder / "drive/metadata.yaml").unlink()
        self.folder.write("drive/.drive_9.mcap.lumsdk", "")
        self.folder.write("drive/.hidden.mcap", "")
        r = self.dump(self.folder / "drive", "--json")
        self.assertEqual([pathlib.Path(s["name"]).name for s in json.loads(r.stdout)["sources"]], ["drive_0.mcap", "drive_1.mcap"])

    def test_a_folder_that_is_there_stays(self):
        (self.folder / "drive").mkdir()
        r = self.bag(self.street(), status=1)
        self.assertIn("drive: is there already; rosbag2 makes a new folder", r.stderr)
        self.assertEqual(os.listdir(self.folder / "drive"), [])

    def test_a_conversion_that_fails_leaves_no_folder(self):
        two = [udp(p, source=address) for address in ("10.0.0.1", "10.0.0.2") for p in line([word(2000, 0)])]
        self.bag(self.folder.write("two.pcap", pcap(two)), status=2)
        self.assertFalse((self.folder / "drive").exists())

    def test_folders_without_captures_are_refused(self):
        (self.folder / "drive").mkdir()
        self.assertIn("a folder without an .mcap file", self.dump(self.folder / "drive", status=1).stderr)
        self.folder.write("drive/drive_0.db3", "")
        self.assertIn("is SQLite (.db3)", self.dump(self.folder / "drive", status=1).stderr)
        self.assertIn("rosbag2 is a folder: name one", self.dump(self.street(), "-o", "-", "--format", "rosbag2", status=2).stderr)
        self.assertIn("rosbag2 is a folder", self.dump(self.street(), "-o", self.folder / "d-%d", "--format", "rosbag2", status=2).stderr)


class Live(Case):
    def start(self, *arguments, topic="/points", count=2):
        address = next(ADDRESSES)
        self.sensor = Sensor(self, self.folder, "--frames", "2", address=address)
        p = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", "-q", "-o", self.folder / "a.mcap", *PLAIN,
                 *arguments)
        path = self.folder / "a.mcap"
        wait_until(lambda: path.exists() and len(self.file("a.mcap").of(topic)) >= count, f"{count} of {topic}")
        return p

    def test_a_folder_is_whole_after_ctrl_c(self):
        p = self.start("-o", self.folder / "drive", "--format", "rosbag2")
        self.assertEqual(p.end(signal.SIGINT), 0)
        self.assertTrue(self.file("drive/drive_0.mcap").is_whole)
        about = yaml.safe_load((self.folder / "drive/metadata.yaml").read_text())["rosbag2_bagfile_information"]
        self.assertEqual(about["message_count"], len(self.file("drive/drive_0.mcap").messages))

    def test_a_folder_can_be_read_after_a_kill(self):
        p = self.start("--mcap", "packets", "-o", self.folder / "drive", "--format", "rosbag2", topic="/datagrams", count=500)
        inside = self.folder / "drive/drive_0.mcap"
        wait_until(lambda: inside.exists() and len(self.file("drive/drive_0.mcap").of("/datagrams")) >= 500, "500 in the folder")
        seen = len(self.file("drive/drive_0.mcap").of("/datagrams"))
        p.send(signal.SIGKILL)
        p.wait()
        self.assertFalse((self.folder / "drive/metadata.yaml").exists())
        r = self.dump(self.folder / "drive", "-o", self.folder / "b.pcap")
        self.assertIn("cannot be read beyond", r.stderr)
        again = run("lumdump", self.folder / "b.pcap", "--json", "-q")
        self.assertGreaterEqual(json.loads(again.stdout)["data"], 0.9 * seen)

    def test_packets_are_those_of_a_pcap_file(self):
        p = self.start("--mcap", "packets", "-o", self.folder / "a.pcap", topic="/datagrams", count=500)
        self.assertEqual(p.end(signal.SIGINT), 0)
        self.assertTrue(self.file("a.mcap").is_whole)
        self.dump(self.folder / "a.mcap", "-o", self.folder / "b.pcap")
        # A capture has all packets of the sensor, also its answers to commands.
        self.dump(self.folder / "a.pcap", "-o", self.folder / "c.pcap")
        self.assertEqual((self.folder / "b.pcap").read_bytes(), (self.folder / "c.pcap").read_bytes())

    def test_packets_can_be_read_after_a_kill(self):
        p = self.start("--mcap", "packets", topic="/datagrams", count=500)
        seen = len(self.file("a.mcap").of("/datagrams"))
        p.send(signal.SIGKILL)
        p.wait()
        r = self.dump(self.folder / "a.mcap", "-o", self.folder / "b.pcap")
        self.assertIn("cannot be read beyond", r.stderr)
        again = run("lumdump", self.folder / "b.pcap", "--json", "-q")
        self.assertGreaterEqual(json.loads(again.stdout)["data"], 0.9 * seen)

    def test_it_is_whole_after_ctrl_c(self):
        p = self.start()
        self.assertEqual(p.end(signal.SIGINT), 0)
        file = self.file("a.mcap")
        self.assertTrue(file.is_whole)
        self.assertGreater(sum(len(c.points) for c in file.clouds()), 0)
        self.assertGreater(len(file.of("/diagnostics")), 1)

    def test_it_tells_of_the_laser(self):
        p = self.start()
        def told():
            found = [s for m in self.file("a.mcap").of("/diagnostics") for s in statuses_of(m)]
            return {s[0]: s for s in found}
        wait_until(lambda: told().get("lumdump: laser", ("", 3))[1] == 0, "the laser")
        _, _, message, values = told()["lumdump: laser"]
        self.assertEqual((message, values["laser"], values["hazards"], values["TLV_CMD_ON"]), ("up", "up", "none", "true"))
        self.assertEqual(told()["lumdump: losses"][3]["node_drops"], "0")
        self.assertEqual(p.end(signal.SIGINT), 0)

    def test_a_reader_that_hangs_keeps_no_laser_on(self):
        address = next(ADDRESSES)
        sensor = Sensor(self, self.folder, "--frames", "2", address=address)
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        p = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", "-o", "-", "--format", "mcap", *PLAIN, stdout=writer)
        os.close(writer)
        wait_until(sensor.laser_is_up, "the laser")
        self.assertEqual(p.wait(), 1)
        self.assertIn("standard output makes no progress and is given up", p.stderr())
        self.assertFalse(sensor.laser_is_up())

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
