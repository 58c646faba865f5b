"""lumdump as its users meet it: options, outputs, faults."""
import json
import os
import pathlib
import pty
import re
import select
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import outages
import shards
import test_rows
from support import (BIN, MAGIC, PATIENCE_S, Folder, frames_of, group, line, pcap, read_csv, run, simulate,
                     summary, udp, word)

COLUMNS = ("x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,line,pixel,"
           "return_number,number_of_returns,edge")
DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
KEYS = """lines lines_missing_angles lines_skipped words lost_words points late duplicate conflict no_room stray
malformed unknown_tag unknown_type foreign other cut_short out_of_order bad_words no_angle no_range heartbeat set_ip timestamp tlv
frames frames_selected truncated damaged sensors""".split()


def two_lines():
    """Two lines of blue, one of green; several returns; a pulse 2 units wide."""
    frames = []
    for number, eye, clock in ((0, 0, 1000), (0, 1, 1000), (1, 0, 2500)):
        words = [word(1000, 0), word(1002, 0, False), word(3000, 0), word(3010, 0, False),
                 word(2000, 500), word(4000, 999)]
        frames += [udp(p) for p in line(words, eye, number, clock)]
    return pcap(frames)


class Joined(unittest.TestCase):
    """A capture begins and ends somewhere: what was under way then is no loss, and frames seen in part tell no rate."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            source = simulate(pathlib.Path(folder) / "s.pcap", "--frames", "13", "--lines", "64", "--seed", "1")
            data = source.read_bytes()
        cls.header, cls.records = data[:24], []
        at = 24
        while at < len(data):
            end = at + 16 + struct.unpack_from("<I", data, at + 8)[0]
            cls.records.append(data[at:end])
            at = end

    def setUp(self):
        self.folder = Folder(self)

    def capture(self, records):
        return self.folder.write("cut.pcap", self.header + b"".join(records))

    def test_what_was_under_way_is_no_loss(self):
        lines = no_angle = 0
        for first, last in ((0, 1000), (701, 3000), (702, 3001), (703, 3002), (704, 3003), (705, 3004), (706, 3005)):
            with self.subTest(first):
                cut = self.capture(self.records[first:last])
                got = summary(cut)
                self.assertEqual(got["lines_missing_angles"], got["lines_under_way"])
                self.assertEqual(got["lost_words"], got["words_under_way"])
                self.assertEqual(got["no_angle"], got["no_angle_under_way"])
                self.assertEqual(got["sensors"][0]["lines_under_way"], got["lines_under_way"])
                text = run("lumdump", cut).stdout
                self.assertRegex(text, r"losses +none")
                self.assertEqual("under way" in text, any(got[k + "_under_way"] for k in ("lines", "words", "no_angle", "missing")))
                lines += got["lines_under_way"]
                no_angle += got["no_angle_under_way"]
        self.assertGreater(lines, 0)
        self.assertGreater(no_angle, 0)

    def test_what_is_lost_between_is_told(self):
        cut = self.capture(self.records[701:1500] + self.records[1510:3000])
        got = summary(cut)
        whole = summary(self.capture(self.records[701:3000]))
        self.assertEqual((got["lines_under_way"], got["words_under_way"]), (whole["lines_under_way"], whole["words_under_way"]))
        self.assertGreater(got["lost_words"] + got["lines_missing_angles"], whole["lost_words"] + whole["lines_missing_angles"])
        cut = self.capture(self.records[701:1500] + self.records[1510:3000])
        self.assertNotRegex(run("lumdump", cut).stdout, r"losses +none")

    def test_frames_a_second_are_of_whole_frames(self):
        for first in 300, 900, 1150:
            with self.subTest(first):
                got = summary(self.capture(self.records[first:]), "--duration", "1")
                self.assertGreaterEqual(got["frames"], 11)
                self.assertAlmostEqual(got["frames_per_second"], 10, delta=0.02)
                self.assertIn("10.00  frames a second, of whole frames", run("lumdump", self.folder / "cut.pcap", "--duration", "1").stdout)
        part = self.capture(self.records[300:1300])
        self.assertNotIn("frames_per_second", summary(part))
        self.assertNotIn("frames a second", run("lumdump", part).stdout)


class Pauses(unittest.TestCase):
    """Outages are cut out of captures."""

    def test_none_is_silent_and_its_lines_are_counted_once(self):
        runs, wrong, too_many = outages.quick(BIN, Folder(self).path)
        self.assertGreater(runs, 130)
        self.assertLess(len(too_many), 10)
        self.assertEqual(wrong, [])

    def test_the_summary_is_that_of_its_frames(self):
        folder = Folder(self)
        capture = outages.Capture(BIN, folder.path, 64, 10, 6, 1)
        got = capture.without(93.99 * capture.sweep_us / 64, 58 * capture.sweep_us / 64)
        self.assertEqual((got["pauses"], got["lines_in_pauses"], got["lines_missing"], got["stray"]), (1, 116, got["missing_under_way"], 0))
        self.assertAlmostEqual(got["paused_s"], 0.0914, delta=0.001)
        text = run("lumdump", capture.path).stdout
        self.assertRegex(text, r" 116 +lines_in_pauses .*\n +1 +pauses +times that no lines came, 0.09\d s in all")
        # a break: the stray of each eye is no loss of its own
        got = capture.without(93.99 * capture.sweep_us / 64, 170000)
        self.assertEqual((got["pauses"], got["stray"], got["stray_at_breaks"]), (1, 2, 2))
        self.assertNotRegex(run("lumdump", capture.path).stdout, r"stray ")
        kept = capture.cut(93.99 * capture.sweep_us / 64, 170000)[1]
        far = bytearray(kept[20][2])
        far[16 + outages.CLOCK + 3] ^= 0x40
        got = capture.summary_of([*kept[:20], (0, 0, bytes(far)), *kept[20:]])
        self.assertEqual((got["stray"], got["stray_at_breaks"]), (3, 2))
        self.assertRegex(run("lumdump", capture.path).stdout, r" 3 +stray .*\n(.*\n)* +2 +stray_at_breaks ")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def capture(self, data=None, name="in.pcap"):
        return self.folder.write(name, two_lines() if data is None else data)

    def rows(self, *arguments, data=None):
        source = self.capture(data)
        out = self.folder / "out.csv"
        r = run("lumdump", source, "-o", out, *arguments)
        self.assertEqual(r.returncode, 0, r.stderr)
        return read_csv(out)

    def refused(self, status, *arguments, message):
        r = run("lumdump", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        self.assertIn(message, r.stderr)
        self.assertEqual(r.stdout, "")
        return r


class Points(Case):
    def test_header_and_one_row_are_as_documented(self):
        self.rows()
        first, row = (self.folder / "out.csv").read_text().splitlines()[:2]
        self.assertEqual(first, COLUMNS)
        # blue looks 30 degrees to the right, 7 degrees down, 1.95 m away
        self.assertEqual(row, "1.6762,-0.9677,-0.2376,1.9500,0.00000,-7.00000,0.026,1000,1,0,0,0,1,2,1")

    def test_edges(self):
        self.assertEqual(len(self.rows()), 12)
        self.assertEqual(len(self.rows("--edge", "falling")), 6)
        self.assertEqual([r["edge"] for r in self.rows("--edge", "both")[:4]], ["1", "0", "1", "0"])

    def test_returns(self):
        for choice, want in (("all", 12), ("first", 9), ("last", 9), ("strongest", 9), ("1", 9), ("2", 3), ("3", 0)):
            with self.subTest(choice):
                self.assertEqual(len(self.rows("--return", choice)), want)
                self.assertEqual(summary(self.folder / "in.pcap", "--return", choice)["points"], want)
        self.assertEqual(self.rows("--return", "strongest")[0]["return_number"], "2")

    def test_a_return_is_chosen_before_range_and_box(self):
        near, far = 3.9, 39.0  # metres, about
        data = pcap([udp(p) for p in line([word(n, pixel) for pixel in (1, 2) for n in (2000, 20000)])])
        for limits in ["--range", f":{(near + far) / 2}"], ["--box", f":{(near + far) / 2},:,:"]:
            for choice, want in (("all", 2), ("first", 2), ("1", 2), ("last", 0), ("2", 0)):
                self.assertEqual(len(self.rows("--return", choice, *limits, data=data)), want, choice)
        kept = self.rows("--range", f"{(near + far) / 2}:", data=data)
        self.assertEqual([(r["return_number"], r["number_of_returns"]) for r in kept], [("2", "2")] * 2)

    def test_the_documents_say_so(self):
        for page in "man/lumdump.1", "formats.md":
            text = " ".join((DOCS / page).read_text().split())
            self.assertRegex(text, "before .*range.* and .*box.* apply", page)

    def test_eye_frames_range_and_box(self):
        for arguments, want in ((("--eye", "green"), 4), (("--eye", "both"), 12), (("--frames", "1:1"), 12),
                                (("--frames", "2:"), 0), (("--frames", ":1"), 12), (("--range", "3:6"), 6),
                                (("--range", ":2"), 3), (("--box", ":,0:,:"), 4), (("--box", "0:2,:,:"), 3)):
            with self.subTest(arguments):
                self.assertEqual(len(self.rows(*arguments)), want)
                self.assertEqual(summary(self.folder / "in.pcap", *arguments)["points"], want)

    def test_selected_frames_are_counted_beside_all(self):
        source = simulate(self.folder / "s.pcap", "--frames", "6", "--lines", "64", "--returns-max", "1")
        for arguments, want in (((), 6), (("--frames", "2:3"), 2), (("--frames", "5:"), 2), (("--frames", "7:9"), 0),
                                (("--frames", "2:3", "--eye", "green", "--range", "900:901"), 2)):
            with self.subTest(arguments):
                got = summary(source, *arguments)
                self.assertEqual((got["frames"], got["frames_selected"]), (6, want))
                self.assertEqual(got["sensors"][0]["frames_selected"], want)
                text = run("lumdump", source, *arguments).stdout
                self.assertEqual(text.count("frames_selected"), want not in (0, 6))
        run("lumdump", source, "--frames", "2:3", "-o", self.folder / "out.csv")
        self.assertEqual({row["frame"] for row in read_csv(self.folder / "out.csv")}, {"2", "3"})

    def test_whole_frames_begin_behind_the_tail_of_a_sweep_and_the_dark(self):
        def joined(frame, number, eye, packets):
            """Frame 1 is a tail, the laser comes on inside frame 3, frame 4 lacks a line; then two more tails."""
            if (frame == 1 and number < test_rows.LINES - 1) or (frame, number) == (4, 1):
                return []
            return packets[:3] if (2, 0) <= (frame, number) < (3, 2) else packets
        source = self.folder.write("s.pcap", test_rows.drive(joined, frames=8))
        for asked, want in ((1, {"5"}), (2, {"5", "6"}), (4, {"5", "6", "7", "8"})):
            out = self.folder / "out.csv"
            r = run("lumdump", source, "--frames", f"whole:{asked}", "-o", out, "--json")
            got = json.loads(r.stdout)
            self.assertEqual(({row["frame"] for row in read_csv(out)}, r.stderr), (want, ""))
            self.assertEqual((got["frames"], got["frames_selected"], got["points"]), (8, asked, len(read_csv(out))))
        for name, more in (("a.ply", []), ("a.pcd", ["--organized", "--return", "first"]), ("a.mcap", []), ("a.las", []),
                           ("a.xyz", ["--comments"]), ("f-%04d.csv", ["--columns", "x,y,z,time"])):
            for frames in "whole:1", "5:5":
                r = run("lumdump", source, "--frames", frames, "-o", self.folder / name, *more)
                self.assertEqual((r.returncode, "warning" in r.stderr), (0, False), r.stderr)
                self.assertRegex(r.stderr, " 1  frames_selected")
        self.assertEqual([n for n in self.folder.names() if n.startswith("f-")], ["f-0005.csv"])
        few = run("lumdump", source, "--frames", "whole:9", "-o", self.folder / "out.csv")
        self.assertEqual(few.returncode, 0)
        self.assertIn("only 4 of 9 whole frames came", few.stderr)
        for arguments in ([], ["-o", self.folder / "z.pcap"], ["-o", self.folder / "z.mcap", "--mcap", "frames,packets"]):
            self.refused(2, source, "--frames", "whole:1", *arguments, message="goes with an output of points")
        for wrong in "whole:0", "whole:", "whole:-1", "whole":
            self.refused(2, source, "--frames", wrong, "-o", self.folder / "z.csv", message="or whole:N")

    def test_a_selection_that_leaves_nothing_is_told(self):
        r = run("lumdump", self.capture(), "--frames", "7:9", "-o", self.folder / "out.csv")
        self.assertEqual(r.returncode, 0)
        self.assertIn("no point is left", r.stderr)

    def test_incomplete_lines_can_be_dropped(self):
        frames = list(frames_of(two_lines()))
        del frames[0]
        self.assertEqual(len(self.rows(data=pcap(frames))), 10)
        self.assertEqual(len(self.rows("--incomplete", "drop", data=pcap(frames))), 8)
        self.assertEqual(summary(self.folder / "in.pcap", "--incomplete", "drop")["no_angle"], 2 + 2)

    def test_arrival_is_the_capture_time_of_the_lines_first_packet(self):
        rows = self.rows("--time", "arrival")
        self.assertEqual(rows[0]["timestamp"], "1700000000000000")
        self.assertEqual({r["timestamp"] for r in rows if r["eye"] == "1"}, {"1700000000004000"})

    def test_duration_ends_the_reading(self):
        self.assertEqual(summary(self.capture(), "--duration", "0.0035")["lines"], 1)

    def test_calibration_moves_points(self):
        calibration = self.folder.write("c.yaml", "eyes: {blue: {mount: {x_m: 10.0, yaw_deg: 0}}}\n")
        self.assertEqual(self.rows("--calibration", calibration)[0]["x"], "11.9355")

    def test_profile_changes_the_layout(self):
        profile = self.folder.write("p.yaml", "version: 1\neye_values: {blue: 1, green: 0}\n")
        self.assertEqual(sum(r["eye"] == "1" for r in self.rows("--profile", profile)), 8)


def records_of(data):
    """The records of a little-endian pcap file of nanoseconds: time, rest."""
    at = 24
    while at < len(data):
        s, ns, length = struct.unpack_from("<III", data, at)
        yield s * 10**9 + ns, data[at + 8:at + 16 + length]
        at += 16 + length


class Times(unittest.TestCase):
    """Stamps in batches of 8 ms, and a clock that is off by 50 ppm: the sensor's clock tells the truth."""

    EPOCH_US = 1767225600 * 10**6
    SIMULATED = ("--lines", "64", "--returns-max", "1", "--seed", "3", "--drift", "50")

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.shared.name)
        cls.batched = simulate(folder / "batched.pcap", "--frames", "50", "--batch", "8", *cls.SIMULATED)
        even = simulate(folder / "even.pcap", "--frames", "2", *cls.SIMULATED)
        # What each line's first packet needs; nobody can see that.
        cls.delay = min(cls.errors(cls.times(even, "sensor"), cls.times(even, "arrival")))

    @classmethod
    def tearDownClass(cls):
        cls.shared.cleanup()

    def setUp(self):
        self.folder = Folder(self)

    @staticmethod
    def times(source, clock, *options, stdin=b""):
        """Of a few points: (frame, eye, line) and its time."""
        r = run("lumdump", source, "-q", "-o", "-", "--format", "csv", "--columns", "frame,eye,line,timestamp", "--time", clock,
                "--range", "4:6", *options, stdin=stdin)
        if r.returncode != 0:
            raise AssertionError(r.stderr)
        rows = (map(int, row.split(",")) for row in dict.fromkeys(r.stdout.splitlines()[1:]))  # each line has one, of many points
        return {(frame, eye, line): time for frame, eye, line, time in rows}

    @classmethod
    def errors(cls, clocks, times):
        return [times[at] - cls.EPOCH_US - clocks[at] * 1.00005 for at in clocks]

    def test_utc_is_within_50_us_of_the_truth_from_the_first_line_on(self):
        clocks = self.times(self.batched, "sensor")
        self.assertGreater(len(clocks), 1000)
        for error in self.errors(clocks, self.times(self.batched, "utc")):
            self.assertLess(abs(error - self.delay), 50)
        arrivals = self.errors(clocks, self.times(self.batched, "arrival"))
        self.assertGreater(max(arrivals) - min(arrivals), 6000)

    def test_a_stream_is_as_good_after_three_seconds(self):
        clocks = self.times(self.batched, "sensor")
        times = self.times("-", "utc", stdin=self.batched.read_bytes())
        late = {at: us for at, us in clocks.items() if at[0] > 30}
        for error in self.errors(late, times):
            self.assertLess(abs(error - self.delay), 50)

    def test_the_summary_tells_rates(self):
        path = self.folder / "ten_a_second.pcap"
        simulate(path, "--frames", "5", "--lines", "64", "--rate", "10")
        found = summary(path)
        self.assertAlmostEqual(found["frames_per_second"], 10, delta=0.1)
        self.assertAlmostEqual(found["points_per_second"], found["points"] / 0.5, delta=0.01 * found["points"] / 0.5)
        self.assertRegex(run("lumdump", path).stdout, r"rates +0\.(50[0-9]|49[0-9]) +seconds of capture\n")

    def test_the_summary_tells_drift_and_error(self):
        clock = summary(self.batched)["sensors"][0]["clock"]
        self.assertLess(abs(clock["drift_ppm"] - 50), clock["drift_error_ppm"])
        self.assertLess(clock["drift_error_ppm"], 50)
        self.assertLess(clock["utc_error_us"], 400)
        self.assertEqual((clock["sensor_breaks"], clock["host_steps"]), (0, 0))
        text = run("lumdump", self.batched).stdout
        self.assertIn("clock             +", text)
        self.assertIn("ppm: host's clock minus sensor's, +- ", text)
        self.assertIn("microseconds that UTC may be off", text)

    def shifted(self, shift_ns, repeat=False):
        """From the middle on, stamps shifted; or all once more, as if the sensor had restarted."""
        data = self.batched.read_bytes()
        records = list(records_of(data))
        half = len(records) // 2
        later = [(t + shift_ns, rest) for t, rest in (records if repeat else records[half:])]
        out = [data[:24]]
        for t, rest in (records if repeat else records[:half]) + later:
            out.append(struct.pack("<II", *divmod(t, 10**9)) + rest)
        return self.folder.write("shifted.pcap", b"".join(out))

    def test_a_step_of_the_hosts_clock_is_followed(self):
        clocks = self.times(self.batched, "sensor")
        for seconds in 3, -3:
            source = self.shifted(seconds * 10**9)
            clock = summary(source)["sensors"][0]["clock"]
            self.assertEqual((clock["sensor_breaks"], clock["host_steps"]), (0, 1))
            times = self.times(source, "utc")
            late = {at: us for at, us in clocks.items() if at[0] > 45}
            for error in self.errors(late, times):
                self.assertLess(abs(error - self.delay - seconds * 1e6), 60)

    def test_a_restart_of_the_sensor_is_noticed(self):
        source = self.shifted(20 * 10**9, repeat=True)
        clock = summary(source)["sensors"][0]["clock"]
        self.assertEqual((clock["sensor_breaks"], clock["host_steps"]), (1, 0))

    def test_packets_without_a_clock_are_refused(self):
        profile = self.folder.write("p.yaml", "version: 1\ngroup: {timestamp: none}\n")
        r = run("lumdump", self.batched, "--profile", profile, "--time", "utc", "-o", self.folder / "o.csv")
        self.assertEqual(r.returncode, 2)
        self.assertIn("--time arrival", r.stderr)
        self.assertEqual(len(self.times(self.batched, "arrival", "--profile", profile)) > 0, True)


class Outputs(Case):
    def test_all_formats_and_nothing_else_appear(self):
        source = self.capture()
        for ending in "csv ply pcd las xyz png pcap".split():
            with self.subTest(ending):
                out = self.folder / f"out.{ending}"
                self.assertEqual(run("lumdump", source, "-o", out).returncode, 0)
                self.assertGreater(out.stat().st_size, 100)
        self.assertEqual([n for n in self.folder.names() if n.endswith(".part")], [])

    def test_pcap_output_holds_the_same_points(self):
        want = self.rows()
        copy = self.folder / "copy.pcap"
        self.assertEqual(run("lumdump", self.folder / "in.pcap", "-o", copy).returncode, 0)
        self.assertEqual(run("lumdump", copy, "-o", self.folder / "out.csv").returncode, 0)
        self.assertEqual(read_csv(self.folder / "out.csv"), want)

    def test_stdin_and_stdout(self):
        want = len(self.rows())
        r = run("lumdump", "-", "-o", "-", "--format", "csv", stdin=two_lines())
        self.assertEqual((r.returncode, len(r.stdout.splitlines())), (0, want + 1))

    def test_headers_with_counts_reach_a_pipe_from_a_file_only(self):
        source = self.capture()
        for kind in "ply", "pcd", "las":
            file = self.folder / f"out.{kind}"
            self.assertEqual(run("lumdump", source, "-o", file).returncode, 0)
            r = run("lumdump", source, "-o", "-", "--format", kind)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertEqual(r.stdout_bytes, file.read_bytes())
            r = run("lumdump", "-", "-o", "-", "--format", kind, stdin=two_lines())
            self.assertEqual((r.returncode, r.stdout), (2, ""))
            self.assertIn("-o FILE", r.stderr)

    def test_one_file_a_frame(self):
        frames = []
        for frame in range(3):
            for number in range(20):
                for eye in 0, 1:
                    clock = 1000 + (frame * 20 + number) * 1500
                    frames += [udp(p) for p in line([word(1000 + number, 5)], eye, number, clock)]
        source = self.capture(pcap(frames))
        r = run("lumdump", source, "-o", self.folder / "f-%04d.csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(self.folder.names(), ["f-0001.csv", "f-0002.csv", "f-0003.csv", "in.pcap"])
        for n in 1, 2, 3:
            self.assertEqual({r["frame"] for r in read_csv(self.folder / f"f-000{n}.csv")}, {str(n)})
            self.assertEqual(len(read_csv(self.folder / f"f-000{n}.csv")), 40)

    def test_patterns_that_are_none_are_refused(self):
        source = self.capture()
        for name in "f-%5s.csv", "f-%d-%d.csv", "f-%.csv":
            self.refused(2, source, "-o", self.folder / name, message="%04d")
        self.refused(2, source, "-o", self.folder / "f-%d.pcap", message="name one file")

    def test_format_overrides_the_ending(self):
        out = self.folder / "out.txt"
        self.assertEqual(run("lumdump", self.capture(), "-o", out, "--format", "xyz").returncode, 0)
        self.assertEqual(len(out.read_text().split("\n")[0].split(" ")), 3)


class Summaries(Case):
    def test_json_has_every_key(self):
        got = summary(self.capture())
        self.assertEqual([k for k in KEYS if k not in got], [])
        self.assertEqual((got["lines"], got["words"], got["points"], got["truncated"]), (3, 18, 12, False))
        self.assertEqual(got["sensors"][0]["address"], "10.42.0.37")

    def test_json_holds_any_name(self):
        for name, want in (("\u00e9\u4e2d\U0001f600.pcap", None), ('a"b\\c\n.pcap', None), (b"\xff\xc3(.pcap", "\u00ff\u00c3(.pcap")):
            source = pathlib.Path(os.fsdecode(name)) if isinstance(name, bytes) else pathlib.Path(name)
            path = self.folder.path / source
            path.write_bytes(two_lines())
            got = json.loads(subprocess.run([BIN / "lumdump", os.fsencode(path), "--json"], capture_output=True).stdout)
            self.assertTrue(got["source"].endswith(want or name), got["source"])

    def test_text_names_what_was_lost(self):
        frames = list(frames_of(two_lines()))
        r = run("lumdump", self.capture(pcap(frames + frames[:1])))
        self.assertIn("duplicate", r.stdout)
        self.assertNotIn("conflict", r.stdout)
        self.assertIn("none", run("lumdump", self.capture()).stdout)

    def test_one_is_not_many(self):
        r = run("lumdump", self.capture())
        self.assertRegex(r.stdout, r" 1  frame\n")
        self.assertRegex(r.stdout, r" 3  lines\n")

    def test_with_an_output_the_summary_goes_to_standard_error(self):
        r = run("lumdump", self.capture(), "-o", self.folder / "out.csv")
        self.assertEqual(r.stdout, "")
        self.assertIn("points", r.stderr)
        r = run("lumdump", self.capture(), "-o", self.folder / "out.csv", "--quiet")
        self.assertEqual(r.stderr, "")

    def test_progress_is_shown_on_a_terminal_alone(self):
        source = simulate(self.folder / "s.pcap", "--frames", "3", "--lines", "64", "--seed", "1")
        main, terminal = pty.openpty()
        with subprocess.Popen([BIN / "lumdump", "-", "-o", self.folder / "o.csv"], stdin=subprocess.PIPE,
                              stderr=terminal) as p:
            data = source.read_bytes()
            p.stdin.write(data[:len(data) // 2])
            p.stdin.flush()
            self.assertTrue(select.select([main], [], [], PATIENCE_S)[0])
            p.stdin.write(data[len(data) // 2:])
            p.stdin.close()
            self.assertEqual(p.wait(PATIENCE_S), 0)
        self.assertIn(b"points", os.read(main, 65536))
        os.close(terminal)
        os.close(main)


class Sensors(Case):
    def both(self):
        frames = [udp(p) for p in line([word(1000, 1)])]
        frames += [udp(p, source="10.42.0.38") for p in line([word(1000, 1), word(1000, 2)])]
        return self.capture(pcap(frames))

    def test_a_summary_names_them_and_adds(self):
        got = summary(self.both())
        self.assertEqual([(s["address"], s["points"]) for s in got["sensors"]], [("10.42.0.37", 1), ("10.42.0.38", 2)])
        self.assertEqual(got["points"], 3)

    def test_an_output_needs_one(self):
        r = self.refused(2, self.both(), "-o", self.folder / "out.csv", message="--sensor")
        self.assertIn("10.42.0.37 10.42.0.38", r.stderr)
        self.assertEqual(self.folder.names(), ["in.pcap"])

    def test_one_is_taken_and_the_other_not_counted(self):
        got = summary(self.both(), "--sensor", "10.42.0.38")
        self.assertEqual((got["points"], got["data"], len(got["sensors"])), (2, 4, 1))

    def test_selected_frames_are_told_if_frames_were_chosen(self):
        two = self.both()
        for path in (two, self.capture(two.read_bytes() + pcap([udp(p) for p in line([word(1000, 1)], number=9)])[24:])):
            for sensor in ((), ("--sensor", "10.42.0.38")):
                for frames, says in (((), 0), (("--frames", "1:1"), 1)):
                    with self.subTest(sensor=sensor, frames=frames):
                        self.assertEqual("selected" in run("lumdump", path, *sensor, *frames).stdout, bool(says))

    def test_one_that_is_not_there(self):
        r = self.refused(1, self.both(), "--sensor", "10.42.0.9", message="no data of 10.42.0.9")
        self.assertIn("but of 10.42.0.37 10.42.0.38", r.stderr)

    def test_a_scan_of_many_addresses_hides_no_sensor(self):
        heartbeat = MAGIC + b"\x08\0\0\0"
        frames = [udp(heartbeat, source="10.42.0.1", destination=f"10.42.1.{i}", sport=50000, dport=5517)
                  for i in range(100)]
        data = pcap(frames + [udp(p) for p in line([word(1000, 1)])])
        got = summary(self.capture(data))
        self.assertEqual((got["points"], got["heartbeat"], got["other"]), (1, 100, 0))
        self.assertEqual(summary(self.capture(data), "--sensor", "10.42.0.37")["points"], 1)

    def test_data_of_more_than_sixteen_is_other(self):
        frames = [udp(p, source=f"10.42.0.{i}") for i in range(1, 19) for p in line([word(1000, 1)])]
        source = self.capture(pcap(frames))
        got = summary(source)
        self.assertEqual((len(got["sensors"]), got["points"], got["other"]), (16, 16, 8))
        self.assertEqual(summary(source, "--sensor", "10.42.0.18")["points"], 1)


class Diagnosis(Case):
    def test_another_layout_is_told_with_types_lengths_and_hex(self):
        frames = [udp(group(2, 0, 0, [bytes(4)] * 334, packet_type=9)) for _ in range(5)]
        r = run("lumdump", self.capture(pcap(frames)), "-o", self.folder / "out.csv")
        self.assertEqual(r.returncode, 1)
        for text in "5 of type 9, 1360 bytes", "ed fe f3 a1", "--profile", "data_packet_type":
            self.assertIn(text, r.stderr)
        self.assertEqual(self.folder.names(), ["in.pcap"])

    def test_types_are_counted_whole_and_the_hex_is_of_one_that_may_be_data(self):
        frames = [udp(MAGIC + b"\x07\0\0\0" + bytes(904))]
        frames += [udp(group(2, 0, 0, [bytes(4)] * n, packet_type=9)) for n in range(20, 60)]
        frames += [udp(group(2, 0, 0, [bytes(4)] * 9, packet_type=3))] * 50
        frames += [udp(group(2, 0, 0, [bytes(4)] * 9, packet_type=2))]
        r = run("lumdump", self.capture(pcap(frames)))
        self.assertEqual(r.returncode, 1)
        for text in "50 of type 3, 60 bytes", "40 of type 9, 104 to 260 bytes", "One of them, 260 bytes", "tag: 8":
            self.assertIn(text, r.stderr)

    def test_lengths_are_those_of_a_type_and_of_a_verdict(self):
        """Type 5 is set IP at 16 bytes, and cannot be at others."""
        frames = [udp(MAGIC + b"\x05\0\0\0" + bytes(n)) for n in [4] * 9 + [0, 1]]
        frames += [udp(MAGIC + b"\x06\0\0\0" + bytes(n)) for n in [8] * 7 + [3] * 3 + [2, 2]]
        r = run("lumdump", self.capture(pcap(frames)))
        self.assertEqual(r.returncode, 1)
        shapes = re.findall(r"^ +(\d+) of type (\d+), (\d+)(?: to (\d+))? bytes \(.*\)$", r.stderr, re.M)
        self.assertEqual(shapes, [("9", "5", "16", ""), ("7", "6", "20", ""), ("5", "6", "14", "15"), ("2", "5", "12", "13")], r.stderr)

    def test_heartbeats_alone_are_no_matter_of_layout(self):
        r = run("lumdump", self.capture(pcap([udp(MAGIC + b"\x08\0\0\0", sport=50000, dport=5517)] * 3)))
        self.assertEqual(r.returncode, 1)
        self.assertIn("heartbeat", r.stderr)
        self.assertNotIn("--profile", r.stderr)

    def test_nothing_for_us_is_a_warning(self):
        for frames in [], [udp(b"hello", sport=1, dport=2)]:
            r = run("lumdump", self.capture(pcap(frames)), "--json")
            self.assertEqual(r.returncode, 0)
            self.assertIn("no packet of a G2", r.stderr)
            self.assertEqual(json.loads(r.stdout)["points"], 0)


class BadSources(Case):
    def test_what_is_not_a_capture_is_refused(self):
        for name, data in (("empty", b""), ("text", b"x,y,z\n1,2,3\n" * 99), ("zeros", bytes(4096)),
                           ("short", two_lines()[:23])):
            with self.subTest(name):
                source = self.folder.write(name, data)
                for extra in [], ["-o", self.folder / "out.csv"]:
                    self.refused(1, source, *extra, message=name)
                self.assertEqual(self.folder.names().count("out.csv"), 0)
                source.unlink()

    def test_directory_and_missing(self):
        self.refused(1, self.folder.path, message="is a folder without an .mcap file")
        self.refused(1, self.folder / "nowhere.pcap", message="No such file")

    def test_unreadable(self):
        source = self.capture()
        source.chmod(0)
        self.folder.path.chmod(0o755)
        try:
            r = run("lumdump", source, **({"user": "nobody"} if os.geteuid() == 0 else {}))
        except PermissionError:
            self.skipTest("root, and nobody else may run the tool here")
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertIn("Permission denied", r.stderr)

    def test_unknown_link_type(self):
        self.refused(1, self.capture(pcap([], link=147)), message="link")

    def test_cut_anywhere_gives_what_was_before(self):
        data = two_lines()
        whole = summary(self.capture(data))
        last = 0
        for n in [*range(24, 24 + 16 + 200), *range(300, len(data), 211), len(data) - 1]:
            r = run("lumdump", self.capture(data[:n]), "--json")
            if r.returncode == 1:
                self.assertIn("none of them", r.stderr)
                continue
            self.assertEqual(r.returncode, 0, r.stderr)
            got = json.loads(r.stdout)
            self.assertGreaterEqual(got["data"], last)
            last = got["data"]
            if got["truncated"]:
                self.assertIn("warning", r.stderr)
        self.assertEqual(last, whole["data"] - 1)

    def test_snap_length_is_counted(self):
        got = summary(self.capture(pcap([*frames_of(two_lines())] , snap=1300)))
        self.assertGreater(got["cut_short"], 0)

    def test_a_sparse_ten_gigabyte_file_is_refused_at_once(self):
        source = self.folder / "sparse.pcap"
        with open(source, "wb") as f:
            f.truncate(10 << 30)
        self.refused(1, source, message="sparse.pcap")

    def test_a_sparse_tail_ends_in_a_warning(self):
        source = self.capture()
        with open(source, "r+b") as f:
            f.truncate(10 << 30)
        r = run("lumdump", source, "--json", "--duration", "5")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(json.loads(r.stdout)["points"], 12)


class BadOutputs(Case):
    def test_full_disk(self):
        for kind in "csv", "xyz", "pcap", "png", "ply", "pcd", "las":
            with self.subTest(kind):
                with open("/dev/full", "wb") as full:
                    r = subprocess.run([BIN / "lumdump", self.capture(), "-o", "-", "--format", kind], stdout=full,
                                       stderr=subprocess.PIPE, timeout=PATIENCE_S)
                self.assertEqual(r.returncode, 1, r.stderr)
                self.assertIn(b"No space left on device; free some space or write elsewhere\n", r.stderr)

    def test_missing_directory_and_name_of_a_directory(self):
        source = self.capture()
        for kind in "csv", "ply", "pcap", "png":
            self.refused(1, source, "-o", self.folder / "no" / f"out.{kind}", message="irectory")
        for kind in "csv", "ply":
            (self.folder / f"dir.{kind}").mkdir()
            self.refused(1, source, "-o", self.folder / f"dir.{kind}", message=f"dir.{kind}: is a directory; name a file")
        self.assertEqual(self.folder.names(), ["dir.csv", "dir.ply", "in.pcap"])

    def test_the_source_itself(self):
        source = self.capture()
        self.refused(2, source, "-o", source, message="source itself")
        with open(source, "rb") as f:
            r = subprocess.run([BIN / "lumdump", "-", "-o", source], stdin=f, capture_output=True, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 2, r.stderr)
        with open(source, "ab") as f:
            r = subprocess.run([BIN / "lumdump", source, "-o", "-", "--format", "pcap"], stdout=f,
                               stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 2, r.stderr)
        os.link(source, self.folder / "link.csv")
        self.refused(2, source, "-o", self.folder / "link.csv", message="source itself")
        self.assertEqual(source.read_bytes(), two_lines())

    def test_a_reader_that_leaves_ends_it_quietly(self):
        source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64", "--seed", "1")
        for kind in "csv", "xyz", "ply", "pcap":
            with self.subTest(kind):
                r = subprocess.run(f"'{BIN}/lumdump' '{source}' -o - --format {kind} | head -c 100 | wc -c; "
                                   "echo ${PIPESTATUS[0]}", shell=True, executable="/bin/bash", capture_output=True,
                                   text=True, timeout=PATIENCE_S)
                self.assertEqual(r.stdout.split(), ["100", "0"])
                self.assertEqual(r.stderr, "")

    def test_a_reader_that_leaves_ends_its_output_alone(self):
        source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64", "--seed", "1")
        for kind in "csv", "pcap":
            with self.subTest(kind):
                copy = self.folder / "copy.pcap"
                r = subprocess.run(f"'{BIN}/lumdump' '{source}' -q -o '{copy}' -o - --format {kind} | head -c 100 | wc -c; "
                                   "echo ${PIPESTATUS[0]}", shell=True, executable="/bin/bash", capture_output=True,
                                   text=True, timeout=PATIENCE_S)
                self.assertEqual((r.stdout.split(), r.stderr), (["100", "0"], ""))
                self.assertEqual(summary(copy)["points"], summary(source)["points"])
                copy.unlink()
        r = subprocess.run(f"'{BIN}/lumdump' '{source}' -o '{copy}' -o - --format csv | head -n 1", shell=True,
                           capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertIn("warning: " + str(source) + ": the reader of standard output has left", r.stderr)
        self.assertRegex(r.stderr, r"\d+  points")

    def test_a_reader_that_has_left_before_the_end_is_no_failure(self):
        source = self.capture()
        for arguments in (["-o", "-", "--format", "csv"], ["-o", "-", "--format", "png"], ["--json"], ["--help"]):
            with self.subTest(arguments):
                end, other = os.pipe()
                os.close(end)
                r = subprocess.run([BIN / "lumdump", source, "--quiet", *arguments], stdout=other,
                                   stderr=subprocess.PIPE, timeout=PATIENCE_S)
                os.close(other)
                self.assertEqual((r.returncode, r.stderr), (0, b""))

    def test_links_are_followed_and_devices_written_in_place(self):
        source = self.capture()
        for kind in "csv", "pcap":
            with self.subTest(kind):
                target, link = self.folder / f"target-{kind}", self.folder / f"link-{kind}"
                target.write_text("old")
                link.symlink_to(target)
                self.assertEqual(run("lumdump", source, "-o", link, "--format", kind).returncode, 0)
                self.assertTrue(link.is_symlink())
                self.assertNotEqual(target.read_bytes(), b"old")
                target.unlink()
                r = run("lumdump", source, "-o", link, "--format", kind)
                self.assertEqual(r.returncode, 1)
                self.assertTrue(link.is_symlink())
                fifo = self.folder / f"fifo-{kind}"
                os.mkfifo(fifo)
                with subprocess.Popen(["cat", fifo], stdout=subprocess.PIPE) as p:
                    self.assertEqual(run("lumdump", source, "-o", fifo, "--format", kind).returncode, 0)
                    self.assertTrue(p.stdout.read())
                self.assertTrue(fifo.is_fifo())

    def test_an_interrupt_leaves_nothing_and_is_died_of(self):
        data = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64", "--seed", "1").read_bytes()
        (self.folder / "s.pcap").unlink()
        for number in signal.SIGINT, signal.SIGTERM:
            for name in "out.csv", "out.ply", "out.pcap", "out.png", "f-%d.csv":
                with self.subTest(name=name, number=number):
                    with subprocess.Popen([BIN / "lumdump", "-", "-o", self.folder / name], stdin=subprocess.PIPE,
                                          stderr=subprocess.PIPE) as p:
                        p.stdin.write(data)
                        p.stdin.flush()
                        self.wait_for_part()
                        p.send_signal(number)
                        self.assertEqual(p.wait(PATIENCE_S), -number)
                    self.assertEqual(self.folder.names(), [])

    def test_an_interrupt_ends_a_wait_for_a_reader_that_stalls(self):
        source = simulate(self.folder / "s.pcap", "--frames", "4", "--lines", "64", "--seed", "1")
        for kind in "csv", "pcap":
            with self.subTest(kind):
                with subprocess.Popen([BIN / "lumdump", source, "-o", "-", "--format", kind], stdout=subprocess.PIPE,
                                      stderr=subprocess.PIPE) as p:
                    p.stdout.read(100)
                    time.sleep(0.3)
                    p.send_signal(signal.SIGINT)
                    self.assertEqual(p.wait(PATIENCE_S), -signal.SIGINT)

    def wait_for_part(self):
        deadline = time.monotonic() + PATIENCE_S
        while not any(n.endswith(".part") for n in self.folder.names()):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)

    def test_an_output_that_was_there_stays_until_the_new_one_is_whole(self):
        old = self.folder.write("out.csv", "old")
        self.refused(1, self.folder / "missing.pcap", "-o", old, message="missing.pcap")
        self.assertEqual(old.read_text(), "old")
        self.assertEqual(run("lumdump", self.capture(), "-o", old).returncode, 0)
        self.assertTrue(old.read_text().startswith(COLUMNS))


class Arguments(Case):
    def test_each_wrong_value_is_named_with_what_is_right(self):
        source = self.capture()
        for arguments, message in (
                (["--edge", "left"], "rising"), (["--return", "0"], "strongest"), (["--eye", "red"], "green"),
                (["--frames", "5"], "10:20"), (["--frames", "3:1"], "10:20"), (["--range", "a:b"], "metres"),
                (["--range", "5:1"], "metres"), (["--range", "nan:1"], "metres"), (["--box", "1:2"], "XMIN"),
                (["--box", "1:2,3:4,5:6,7:8"], "XMIN"), (["--sensor", "10.0.0"], "10.42.0.37"),
                (["--time", "now"], "utc"), (["--incomplete", "x"], "drop"), (["--duration", "0"], "above 0"),
                (["--form", "csv"], "did you mean --format?"), (["--ver"], "did you mean --version?"),
                (["--lsaer"], "did you mean --laser?"), (["--eye"], "a value is missing: one of blue green both"),
                (["--json=1"], "--json takes no value: '1'"), (["--profile", ""], "'' is not the name of a file"),
                (["--format", "doc"], "csv"), (["-o", "out.doc"], ".csv"), (["-o", "out"], "--format"),
                (["-o", "-"], "--format"), (["--ascii", "-o", "x.csv"], "--ascii"), (["--unknown"], "--help"),
                (["udp://10.42.0.38"], "only source"), (["--json", "-o", "-", "--format", "csv"], "--json"),
                (["--calibration", "none.yaml"], "none.yaml"), (["--profile", "none.yaml"], "none.yaml")):
            with self.subTest(arguments):
                self.refused(2, source, *arguments, message=message)
        self.refused(2, message="SOURCE")

    def test_bad_configuration_names_file_line_and_key(self):
        bad = self.folder.write("bad.yaml", "version: 1\neyes:\n  blue: {tof: 3}\n")
        r = self.refused(2, self.capture(), "--calibration", bad, message="bad.yaml")
        self.assertIn("tof", r.stderr)
        self.assertRegex(r.stderr, r"bad\.yaml:3")

    def test_help_and_version(self):
        r = run("lumdump", "--help")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.assertIn("Examples:", r.stdout)
        told = re.findall(r"^ +(?:-., )?(--[a-z]+)", r.stdout, re.M)
        self.assertEqual(sorted(told), sorted(set(told)))
        self.assertRegex(run("lumdump", "--version").stdout, r"^lumdump \d+\.\d+\.\d+\n$")


if __name__ == "__main__":
    shards.main()
