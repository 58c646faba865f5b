#!/usr/bin/env python3
"""lumctl yscan and lumctl apply, from outside: what they send, what they refuse, what they make of an answer."""
import json
import pathlib
import socket
import struct
import threading
import unittest

import shards
import support

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TLV_HEAD = "edfef3a1efbe34120700000007000000"


def lumctl(*arguments, **options):
    return support.run("lumctl", *arguments, **options)


def dry(*arguments, **options):
    return lumctl("--dry-run", "--sequence", 7, *arguments, **options)


def tlvs(packet):
    """(type, value) of each TLV of a packet."""
    at = 16
    while at < len(packet):
        kind, length = struct.unpack_from("<HH", packet, at)
        yield kind, packet[at + 4:at + 4 + length]
        at += 4 + length


def table(packet):
    """The raw elevations of a packet's Y-scan TLV."""
    value = dict(tlvs(packet))[4]
    return struct.unpack(f"<{len(value) // 2}h", value)


class Sensor:
    """Answers TLV packets: a status, and a debug text where refuse(packet) has one."""

    def __init__(self, test, refuse=lambda packet: None, silent=False):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.05)
        self.host = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.packets = []
        self.refuse, self.silent, self.is_over = refuse, silent, False
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()
        test.addCleanup(self.end)

    def serve(self):
        while not self.is_over:
            try:
                packet, sender = self.socket.recvfrom(2048)
            except socket.timeout:
                continue
            if packet[8] == 6:
                self.socket.sendto(packet, sender)
                continue
            self.packets.append(packet)
            if self.silent:
                continue
            answer = packet[:16] + struct.pack("<HHH", 2, 2, 0x0010)
            text = self.refuse(packet)
            if text:
                answer += struct.pack("<HH", 3, len(text)) + text.encode()
            self.socket.sendto(answer, sender)

    def end(self):
        self.is_over = True
        self.thread.join()
        self.socket.close()


class Case(unittest.TestCase):
    maxDiff = None

    def assert_refused(self, r, says):
        """Nothing on stdout, one line on stderr that says it, status 2."""
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
        self.assertIn(says, r.stderr)

    def dry_table(self, *arguments):
        r = dry("yscan", *arguments)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(r.stdout.count("\n"), 1)
        packet = bytes.fromhex(r.stdout.strip())
        self.assertEqual(packet[:16].hex(), TLV_HEAD)
        self.assertEqual(struct.unpack_from("<HH", packet, 16), (4, len(packet) - 20))
        return table(packet)


def degrees(raw, low=-17.0, high=3.0):
    return (low + high) / 2 + raw / 32768 * (high - low) / 2


class FieldOfView(Case):
    def test_is_the_manual_s_command(self):
        r = dry("yscan", 15)
        self.assertEqual((r.returncode, r.stdout), (0, TLV_HEAD + "01000300313579\n"))

    def test_outside_the_manual_s_limits_is_refused(self):
        for value in ("10", "31", "0", "-15", "15.0", "015", "15y", "", " 15", "+15", "65551"):
            with self.subTest(value=value):
                r = dry("yscan", "--", value) if value.startswith("-") else dry("yscan", value)
                self.assert_refused(r, "from 11 to 30")

    def test_beyond_what_the_eyes_see_is_warned_of_with_how_much(self):
        self.assertIn("the eyes see -17 to 3: 2.5 degrees above", dry("yscan", 11).stderr)
        self.assertEqual(dry("yscan", 11, "--quiet").stderr, "")
        folder = support.Folder(self)
        wide = folder.write("wide.yaml", "eyes: {blue: {elevation: {min_deg: -5, max_deg: 7}},"
                                         " green: {elevation: {min_deg: -15, max_deg: 15}}}")
        r = dry("yscan", 16, "--calibration", wide)
        self.assertEqual(r.returncode, 0)
        self.assertEqual(r.stderr.count("\n"), 1)
        self.assertIn("blue sees -5 to 7: 1 degrees above and 3 degrees below", r.stderr)
        self.assertEqual(dry("yscan", 10 + 1, "--calibration", folder.write(
            "all.yaml", "eyes: {blue: {elevation: {min_deg: -5.5, max_deg: 5.5}},"
                        " green: {elevation: {min_deg: -6, max_deg: 6}}}")).stderr, "")

    def test_words_too_many_or_too_few_are_refused(self):
        self.assert_refused(dry("yscan"), "give a field of view, 11 to 30 degrees, or --shape")
        self.assert_refused(dry("yscan", 15, 16), "'16' is one word too many")
        self.assert_refused(dry("yscan", 15, "--shape", "uniform"), "'15' is one word too many")
        self.assert_refused(dry("yscan", 15, "--lines", 64), "--lines goes with --shape")


class Shape(Case):
    def test_uniform_covers_the_whole_span(self):
        raw = self.dry_table("--shape", "uniform", "--lines", 64)
        self.assertEqual(list(raw), [round(32768 * (1 - (2 * i + 1) / 64)) for i in range(64)])

    def test_without_lines_it_is_640_and_says_so(self):
        r = dry("yscan", "--shape", "uniform")
        self.assertEqual(len(table(bytes.fromhex(r.stdout.strip()))), 640)
        self.assertIn("the table is for 640 lines, because a sensor cannot be asked", r.stderr)

    def test_uniform_between_two_elevations(self):
        raw = self.dry_table("--shape", "uniform:-5:-1", "--lines", 64)
        for i, value in enumerate(raw):
            self.assertAlmostEqual(degrees(value), -1 - 4 * (2 * i + 1) / 128, delta=0.0004)

    def test_gaussian_has_its_shares(self):
        raw = self.dry_table("--shape", "gaussian:-7:2")
        self.assertEqual(sorted(raw, reverse=True), list(raw))
        within = sum(abs(degrees(value) + 7) <= 2 for value in raw)
        self.assertAlmostEqual(within / 640, 0.6827, delta=0.002)
        self.assertEqual([-value for value in reversed(raw)], list(raw))

    def test_gaussian_between_two_elevations(self):
        raw = self.dry_table("--shape", "gaussian:-1:2:-3:0", "--lines", 64)
        self.assertTrue(all(-3 < degrees(value) < 0 for value in raw))

    def test_regions_in_any_order_share_the_lines(self):
        raw = self.dry_table("--shape", "regions:-17..-2=1,1..3=2,-2..1=5", "--lines", 64)
        self.assertEqual(sorted(raw, reverse=True), list(raw))
        self.assertEqual(sum(degrees(v) > 1 for v in raw), 16)
        self.assertEqual(sum(-2 < degrees(v) < 1 for v in raw), 40)
        self.assertEqual(sum(degrees(v) < -2 for v in raw), 8)
        self.assertEqual(self.dry_table("--shape", "regions:-3..2", "--lines", 64),
                         self.dry_table("--shape", "uniform:-3:2", "--lines", 64))

    def test_elevations_from_a_file(self):
        folder = support.Folder(self)
        rows = [3 - 20 * i / 63 for i in range(64)]
        text = "# a comment\r\nelevation_deg\r\n\r\n" + "".join(f"  {v:.6f} # line\r\n" for v in rows)
        for order in (rows, rows[::-1]):
            text = "# a comment\r\nelevation_deg\r\n\r\n" + "".join(f"  {v:.6f} # line\r\n" for v in order)
            raw = self.dry_table("--shape", f"csv:{folder.write('a.csv', text)}", "--lines", 64)
            for value, want in zip(raw, order):
                self.assertAlmostEqual(degrees(value), want, delta=0.0004)
        r = dry("yscan", "--shape", "csv:-", "--lines", 64, stdin=text.encode())
        self.assertEqual(table(bytes.fromhex(r.stdout.strip())), raw)

    def test_a_file_at_fault_is_refused_with_its_line(self):
        folder = support.Folder(self)
        good = "".join(f"{-i / 10}\n" for i in range(64))
        for text, says in (
                (good + "-7\n", "65 elevations; 64 lines need one each"),
                (good[5:], "63 elevations"),
                ("", "0 elevations"),
                ("elevation\nelevation\n" + good, "f.csv:2: 'elevation' is not an elevation"),
                ("-1,5\n" + good, "f.csv:1: '-1,5' is not an elevation"),
                (good.replace("-0.3", "nan"), "f.csv:4: 'nan'"),
                (good.replace("-0.3", "-91"), "f.csv:4: '-91'"),
                (good.replace("-0.3", "9" * 300), "f.csv:4: longer than"),
                (good.replace("-0.3", "-0.1"), "line 3 turns, from -0.2 to -0.1"),
                (good.replace("0.0\n", "3.000001\n", 1), "line 0 at 3 degrees is outside what the blue eye sees"),
                (good.replace("-6.3", "-18"), "line 63 at -18 degrees is outside what the blue eye sees, -17 to 3")):
            with self.subTest(says=says):
                self.assert_refused(dry("yscan", "--lines", 64, "--shape", f"csv:{folder.write('f.csv', text)}"), says)
        self.assert_refused(dry("yscan", "--shape", "csv:/nonexistent"), "/nonexistent: cannot be read")
        self.assert_refused(dry("yscan", "--shape", f"csv:{folder.path}"), "cannot be read")
        self.assert_refused(dry("yscan", "--shape", "csv:"), "cannot be read")

    def test_every_wrong_shape_is_refused(self):
        for shape, says in (
                ("bell", "is not uniform[:MIN:MAX]"), ("", ""), ("Uniform", "is not uniform"),
                ("uniform:", "is not uniform"), ("uniform:-3", "is not uniform"), ("uniform:-3:2:1", "is not uniform"),
                ("uniform:a:2", "'a' is not a number of degrees from -90 to 90"),
                ("uniform:-3:", "'' is not a number"), ("uniform:-3: 2", "' 2' is not a number"),
                ("uniform:-3:0x2", "'0x2' is not a number"), ("uniform:-3:inf", "'inf' is not a number"),
                ("uniform:-91:2", "'-91' is not a number"), ("uniform:2:-3", "2 is not below -3"),
                ("uniform:2:2", "2 is not below 2"),
                ("uniform:-17.001:3", "-17.001 degrees is outside the -17 to 3 that both eyes see"),
                ("uniform:-17:3.001", "3.001 degrees is outside"), ("uniform:4:5", "4 degrees is outside"),
                ("gaussian:1:2:-18:3", "-18 degrees is outside"),
                ("gaussian", "is not uniform"), ("gaussian:1", "is not uniform"), ("gaussian:1:2:3", "is not uniform"),
                ("gaussian:1:2:3:4:5", "is not uniform"), ("gaussian:1:2:3:4:5:6:7:8", "is not uniform"),
                ("gaussian:x:2", "'x' is not a number"), ("gaussian:1:0", "'0' is not a sigma from 0.01 to 90"),
                ("gaussian:1:0.009", "'0.009' is not a sigma"), ("gaussian:1:90.1", "'90.1' is not a sigma"),
                ("gaussian:1:-2", "'-2' is not a sigma"), ("gaussian:4:1", "the center 4 is not within the -17 to 3"),
                ("gaussian:1:1:-5:0", "the center 1 is not within the -5 to 0"),
                ("regions", "is not uniform"), ("regions:", "'' is not a region, MIN..MAX=WEIGHT"),
                ("regions:1=2", "'1=2' is not a region"), ("regions:1..2=", "'' is not a weight"),
                ("regions:1..2=0", "'0' is not a weight"), ("regions:1..2=1.5", "'1.5' is not a weight"),
                ("regions:1..2=1000001", "'1000001' is not a weight"), ("regions:2..1=1", "2 is not below 1"),
                ("regions:1..=1", "'' is not a number"), ("regions:1..2=1,", "'' is not a region"),
                ("regions:1..2=1,1.5..3=1", "one reaches up to 2, the next higher begins at 1.5"),
                ("regions:0..2=1,0..2=1", "overlap"),
                ("regions:" + ",".join(f"{-i / 2}..{-i / 2 + 0.5}=1" for i in range(17)), "more than 16 regions"),
                ("regions:-18..2=1", "-18 degrees is outside"), ("regions:-9..-8,-2..4", "4 degrees is outside")):
            with self.subTest(shape=shape):
                self.assert_refused(dry("yscan", "--lines", 64, "--shape", shape), says)
        for lines in (0, 1, 63, 65, 320, 641, "x", "", -64):
            with self.subTest(lines=lines):
                self.assert_refused(dry("yscan", "--shape", "uniform", f"--lines={lines}"), "lines")

    def test_sixteen_regions_fit(self):
        shape = "regions:" + ",".join(f"{-i}..{-i + 1}=1" for i in range(16))
        self.assertEqual(len(self.dry_table("--lines", 64, "--shape", shape)), 64)

    def test_the_drawing_shows_lines_and_the_horizon(self):
        r = dry("yscan", "--shape", "regions:0..1=1,-17..-16=3", "--lines", 64)
        rows = r.stderr.splitlines()
        self.assertEqual(rows[0], "Y scan: 64 lines from 0.97 down to -16.99 degrees")
        bars = [row for row in rows if "|" in row]
        self.assertEqual(len(bars), 20)
        self.assertEqual([row.split("|")[1].split()[-1] for row in bars], ["0", "0", "16"] + ["0"] * 16 + ["48"])
        horizon = next(i for i, row in enumerate(rows) if "horizon" in row)
        self.assertIn("0.00 ..   1.00 |", rows[horizon - 1])
        self.assertEqual(bars[2].count("#") * 3, bars[-1].count("#") + 1)
        self.assertTrue(all(len(row) <= 80 for row in rows))
        self.assertEqual(dry("yscan", "--shape", "uniform", "--quiet").stderr, "")

    def test_eyes_that_see_differently_share_a_table_halfway(self):
        folder = support.Folder(self)
        two = folder.write("two.yaml", "eyes: {green: {elevation: {min_deg: -16.9, max_deg: 3.1}}}")
        r = dry("yscan", "--calibration", two, "--shape", "uniform", "--lines", 64)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertRegex(r.stderr, r"it lies halfway, and lines are up to 0\.05\d* degrees off")
        raw = table(bytes.fromhex(r.stdout.strip()))
        for i, value in enumerate(raw):
            want = 3 - 19.9 * (2 * i + 1) / 128
            self.assertAlmostEqual(degrees(value), want - 0.05, delta=0.001)
            self.assertAlmostEqual(degrees(value, -16.9, 3.1), want + 0.05, delta=0.001)
        self.assert_refused(dry("yscan", "--calibration", two, "--shape", "uniform:-16.99:3", "--lines", 64),
                            "-16.99 degrees is outside the -16.9 to 3 that both eyes see")
        apart = folder.write("apart.yaml", "eyes: {green: {elevation: {min_deg: 3, max_deg: 4}}}")
        self.assert_refused(dry("yscan", "--calibration", apart, "--shape", "uniform"),
                            "no elevation is seen by both eyes")
        self.assert_refused(dry("yscan", "--calibration", folder / "none", "--shape", "uniform"), "cannot be read")

    def test_the_profile_s_number_and_scale_are_used(self):
        folder = support.Folder(self)
        profile = folder.write("p.yaml", "version: 1\nangle_lsb_deg: 0.001\ntlv: {yscan: 9}\n")
        r = dry("yscan", "--profile", profile, "--shape", "uniform:-17:3", "--lines", 64)
        packet = bytes.fromhex(r.stdout.strip())
        self.assertEqual(struct.unpack_from("<HHh", packet, 16), (9, 128, 9844))
        fine = folder.write("f.yaml", "version: 1\nangle_lsb_deg: 0.0001\n")
        self.assert_refused(dry("yscan", "--profile", fine, "--shape", "uniform", "--lines", 64),
                            "does not fit 16 bits")


class Answered(Case):
    def test_a_table_that_is_taken(self):
        sensor = Sensor(self)
        r = lumctl("--host", sensor.host, "yscan", "--shape", "uniform", "--lines", 64)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("Y scan 64 lines from 2.84 down to -16.84 degrees done", r.stdout)
        self.assertEqual([len(table(p)) for p in sensor.packets], [64])
        r = lumctl("--host", sensor.host, "yscan", "--shape", "uniform", "--lines", 64, "--json")
        self.assertIs(json.loads(r.stdout)["done"], True)

    def test_a_table_that_is_refused(self):
        for text in ("refused Y-scan table: 64 elevations, 640 lines", "bad TABLE"):
            sensor = Sensor(self, lambda packet, text=text: text)
            r = lumctl("--host", sensor.host, "yscan", "--shape", "uniform", "--lines", 64)
            self.assertEqual(r.returncode, 1, r.stderr)
            self.assertIn("refused", r.stderr)
            self.assertIn(text, r.stdout)
            r = lumctl("--host", sensor.host, "yscan", "--shape", "uniform", "--lines", 64, "--json")
            self.assertEqual(r.returncode, 1)
            self.assertIs(json.loads(r.stdout)["done"], False)

    def test_a_silent_sensor(self):
        sensor = Sensor(self, silent=True)
        quick = ("--host", sensor.host, "--timeout", 20, "--retries", 1)
        self.assertEqual(lumctl(*quick, "yscan", "--shape", "uniform").returncode, 3)
        folder = support.Folder(self)
        r = lumctl(*quick, "apply", folder.write("s.yaml", "power: 5"))
        self.assertEqual((r.returncode, r.stdout), (3, ""))


ALL = """\
offset: {green: 11, blue: 12}
holdoff: 210
threshold: {green: 41, blue: 42}
power: 51
yscan: {shape: uniform}
lines: 64
"""


class Apply(Case):
    def setUp(self):
        self.folder = support.Folder(self)

    def file(self, text):
        return self.folder.write("s.yaml", text)

    def test_all_goes_in_one_packet_lines_first_then_the_table(self):
        r = dry("apply", self.file(ALL))
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(r.stdout.count("\n"), 1)
        packet = bytes.fromhex(r.stdout.strip())
        self.assertEqual([(k, v if k == 1 else len(v)) for k, v in tlvs(packet)],
                         [(1, b"1f"), (4, 128), (1, b"51p 41g 42b 210h 11G 12B")])

    def test_a_plan_is_shown(self):
        r = dry("apply", self.file(ALL))
        rows = [row.split() for row in r.stderr.splitlines()]
        self.assertEqual(rows[0], ["setting", "value", "command"])
        self.assertEqual(rows[1], ["lines", "64", "1f"])
        self.assertEqual((rows[2][0], rows[2][1], rows[2][-1]), ("yscan", "64", "table"))
        self.assertEqual(rows[3:], [["power", "51", "51p"], ["threshold", "green", "41", "41g"],
                                    ["threshold", "blue", "42", "42b"], ["holdoff", "210", "210h"],
                                    ["offset", "green", "11", "11G"], ["offset", "blue", "12", "12B"]])
        self.assertEqual(dry("apply", self.file(ALL), "--quiet").stderr, "")

    def test_a_field_of_view_is_a_command_with_its_warning(self):
        r = dry("apply", self.file("power: 0\nyscan: 11\nlines: 640"))
        self.assertEqual([v for _, v in tlvs(bytes.fromhex(r.stdout.strip()))], [b"0f 11y 0p"])
        self.assertIn("2.5 degrees above", r.stderr)

    def test_a_table_without_lines_is_for_640_and_says_so(self):
        r = dry("apply", self.file("yscan: {shape: gaussian, center_deg: -2, sigma_deg: 3}"))
        self.assertEqual(len(table(bytes.fromhex(r.stdout.strip()))), 640)
        self.assertIn("names no lines", r.stderr)
        r2 = dry("yscan", "--shape", "gaussian:-2:3")
        self.assertEqual(r.stdout, r2.stdout)

    def test_regions_are_those_of_the_command_line(self):
        r = dry("apply", self.file("yscan:\n  shape: regions\n  regions:\n    1: {min_deg: -9, max_deg: -2, weight: 3}\n"
                                   "    2: {min_deg: 0, max_deg: 2}\n"))
        self.assertEqual(r.stdout, dry("yscan", "--shape", "regions:-9..-2=3,0..2").stdout)

    def test_the_sample_makes_a_plan(self):
        r = dry("apply", ROOT / "calib" / "settings.yaml")
        self.assertEqual((r.returncode, r.stdout.count("\n")), (0, 1), r.stderr)

    def test_what_all_is_taken_is_done(self):
        sensor = Sensor(self)
        r = lumctl("--host", sensor.host, "apply", self.file(ALL))
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(len(sensor.packets), 1)
        self.assertEqual(sum(row.endswith("done") for row in r.stdout.splitlines()), 8)
        self.assertIn("8 of 8 settings done", r.stdout)
        answer = json.loads(lumctl("--host", sensor.host, "apply", self.file(ALL), "--json").stdout)
        self.assertIs(answer["done"], True)
        self.assertEqual([(s["setting"], s["command"], s["done"]) for s in answer["settings"]][:3],
                         [("lines", "1f", True), ("yscan", "table", True), ("power", "51p", True)])

    def test_what_is_refused_is_named(self):
        for text, names in (("refused 41g: no", ["threshold green (41g)"]),
                            ("refused 210h; refused 11G", ["holdoff (210h)", "offset green (11G)"]),
                            ("refused Y-scan table: odd", ["yscan (table)"])):
            with self.subTest(text=text):
                sensor = Sensor(self, lambda packet, text=text: text)
                r = lumctl("--host", sensor.host, "apply", self.file(ALL))
                self.assertEqual(r.returncode, 1)
                self.assertTrue(r.stderr.endswith(": " + ", ".join(names) + "\n"), r.stderr)
                self.assertIn(f"{8 - len(names)} of 8 settings done", r.stdout)
                answer = json.loads(lumctl("--host", sensor.host, "apply", self.file(ALL), "--json").stdout)
                self.assertIs(answer["done"], False)
                self.assertEqual(sum(not s["done"] for s in answer["settings"]), len(names))

    def test_a_refusal_of_who_knows_what_is_a_failure(self):
        sensor = Sensor(self, lambda packet: "1 more Refused")
        r = lumctl("--host", sensor.host, "apply", self.file("power: 5"))
        self.assertEqual(r.returncode, 1)
        self.assertIn("does not say of what", r.stderr)
        quiet = Sensor(self, lambda packet: "all is well, no refits")
        self.assertEqual(lumctl("--host", quiet.host, "apply", self.file("power: 5")).returncode, 0)

    def test_a_file_that_names_nothing_sends_nothing(self):
        sensor = Sensor(self)
        r = lumctl("--host", sensor.host, "apply", self.file("version: 1"))
        self.assertEqual((r.returncode, r.stdout, sensor.packets), (0, "", []))
        self.assertIn("names no setting", r.stderr)

    def test_a_file_at_fault_is_refused_and_nothing_sent(self):
        sensor = Sensor(self)
        for text, says in (("power: 101", "s.yaml:1: power: '101' is out of range; allowed: 0 to 100"),
                           ("power: 5\nlaser: on", "s.yaml:2: laser: a file cannot switch the laser"),
                           ("powr: 5", "did you mean 'power'?"),
                           ("power: 5\npower: 5", "s.yaml:2: power: repeated"),
                           ("yscan: {shape: uniform, max_deg: 4}", "4 degrees is outside"),
                           ("yscan: {shape: gaussian, center_deg: 4, sigma_deg: 1}", "the center 4 is not within"),
                           ("yscan: {shape: uniform, min_deg: 3}", "no lines fit from 3 to 3 degrees")):
            with self.subTest(text=text):
                self.assert_refused(lumctl("--host", sensor.host, "--quiet", "apply", self.file(text)), says)
        self.assert_refused(lumctl("--host", sensor.host, "apply", self.folder / "none"), "none: cannot be read")
        self.assert_refused(lumctl("--host", sensor.host, "apply"), "give a file of settings")
        self.assert_refused(lumctl("--host", sensor.host, "apply", "a", "b"), "one file of settings, not more")
        self.assertEqual(sensor.packets, [])


if __name__ == "__main__":
    shards.main()
