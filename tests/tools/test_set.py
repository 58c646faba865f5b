#!/usr/bin/env python3
"""--set KEY=VALUE: calibration and profile by key from the command line, on top of files and of what captures bring along."""
import re
import unittest

import shards
from support import BIN, Folder, frames_of, line, pcap, read_csv, run, simulate, udp, word

CALIBRATION = "version: 1\neyes: {blue: {mount: {x_m: 20.0, y_m: -3.0}}}\ntof_lsb_ps: 12.5\n"
PROFILE = "version: 1\ndata_packet_type: 3\ngroup: {timestamp: none}\nangle_order: elevation_azimuth\n"
PROFILE_SET = ["--set", "data_packet_type=3", "--set=group.timestamp=none", "--set", "angle_order=elevation_azimuth"]


def built(*commands):
    """Those whose tool is there."""
    return [c for c in commands if (BIN / c[0]).exists()]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def done(self, tool, *arguments, **options):
        r = run(tool, *arguments, **options)
        self.assertEqual(r.returncode, 0, r.stderr)
        return r

    def refused(self, tool, *arguments):
        r = run(tool, *arguments)
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        return r.stderr

    def capture(self, *tail):
        packets = [p for n in range(2) for p in line([word(100000 + 100 * n, 500)], number=n, clock=1000 + n)]
        return self.folder.write("in.pcap", pcap([udp(p) for p in packets], *tail))

    def points(self, *arguments, **options):
        out = self.folder / "points.csv"
        r = self.done("lumdump", *arguments, "-o", out, "-q", **options)
        self.assertEqual(r.stderr, "")
        return read_csv(out)


class Dump(Case):
    def test_a_value_is_as_one_of_a_file(self):
        source = self.capture()
        file = self.folder.write("c.yaml", CALIBRATION)
        values = ["eyes.blue.mount.x_m=20", "eyes.blue.mount.y_m=-3.0", "tof_lsb_ps=1.25e1"]
        wanted = self.points(source, "--calibration", file)
        self.assertNotEqual(wanted, self.points(source))
        self.assertEqual(wanted, self.points(source, *[f"--set={v}" for v in values]))
        self.assertEqual(wanted, self.points("-", *[f"--set={v}" for v in values], stdin=source.read_bytes()))

    def test_bits_are_a_pair(self):
        source = self.capture()
        bits = ("--set", "group.line.bits=[0, 14]", "--set", "group.num_samples=none")
        self.assertEqual(self.points(source), self.points(source, *bits))
        self.assertIn("group.line.bits: '[0, 16' is not [LOW, HIGH], two whole numbers; allowed: all, or [LOW, HIGH]",
                      self.refused("lumdump", source, "--set", "group.line.bits=[0, 16"))
        self.assertIn("bit 16 is not one of group.line.bytes, 2; allowed: 0 to 15",
                      self.refused("lumdump", source, "--set", "group.line.bits=[0, 16]"))

    def test_it_lies_on_top_of_the_file(self):
        source = self.capture()
        file = self.folder.write("c.yaml", CALIBRATION)
        both = self.folder.write("both.yaml", CALIBRATION.replace("-3.0", "7"))
        wanted = self.points(source, "--calibration", both)
        self.assertEqual(wanted, self.points(source, "--set", "eyes.blue.mount.y_m=7", "--calibration", file))

    def test_the_last_of_a_key_holds(self):
        source = self.capture()
        self.assertEqual(self.points(source, "--set", "tof_lsb_ps=12"),
                         self.points(source, "--set", "tof_lsb_ps=900", "--set", "tof_lsb_ps=12"))

    def test_a_layout_is_set_as_well(self):
        file = self.folder.write("p.yaml", PROFILE)
        source = simulate(self.folder / "other.pcap", "-n", 1, "--profile", file)
        wanted = self.points(source, "--profile", file)
        self.assertGreater(len(wanted), 1000)
        self.assertEqual(wanted, self.points(source, *PROFILE_SET))
        self.assertEqual(wanted, self.points(source, "--profile", file, "--set", "line_span_us=2000"))

    def test_outputs_say_what_was_used(self):
        source = self.capture()
        file = self.folder.write("c.yaml", CALIBRATION)
        known = self.folder / "known.pcapng"
        wanted = self.points(source, "--calibration", file, "--set", "eyes.blue.mount.yaw_deg=-31")
        self.done("lumdump", source, "--calibration", file, "--set", "eyes.blue.mount.yaw_deg=-31", "-o", known, "-q")
        self.assertEqual(wanted, self.points(known))
        ply = self.folder / "out.ply"
        self.done("lumdump", source, "--set", "line_span_us=4000", "-o", ply, "-q")
        text = ply.read_bytes().split(b"end_header")[0].decode()
        self.assertIn("comment calibration: built-in\ncomment profile: below\n", text)
        self.assertIn("comment line_span_us: 4000\n", text)

    def test_it_lies_on_top_of_what_a_capture_brings_along(self):
        source = self.capture()
        file = self.folder.write("c.yaml", CALIBRATION)
        known = self.folder / "known.pcapng"
        self.done("lumdump", source, "--calibration", file, "-o", known, "-q")
        both = self.folder.write("both.yaml", CALIBRATION.replace("-3.0", "7"))
        self.assertEqual(self.points(source, "--calibration", both), self.points(known, "--set", "eyes.blue.mount.y_m=7"))

    def test_what_a_pcap_file_has_no_room_for_is_said(self):
        source = self.capture()
        calibration = self.folder.write("c.yaml", CALIBRATION)
        profile = self.folder.write("p.yaml", "version: 1\nline_span_us: 3000\n")
        known = self.folder / "known.pcapng"
        self.done("lumdump", source, "--calibration", calibration, "-o", known, "-q")
        out = self.folder / "copy.pcap"
        one, other, both = "the calibration that is", "the profile that is", "the calibration and the profile that are"
        for words, said in (((source,), None), ((known,), one),
                            ((source, "--set", "tof_lsb_ps=12"), one), ((source, "--calibration", calibration), one),
                            ((source, "--set", "line_span_us=3000"), other), ((source, "--profile", profile), other),
                            ((known, "--set", "line_span_us=3000"), both), ((known, "--profile", profile), both)):
            with self.subTest(words=words[1:]):
                text = self.done("lumdump", *words, "-o", out).stderr
                if said is None:
                    self.assertNotIn("no room", text)
                else:
                    pronoun = "them" if said is both else "it"
                    self.assertIn(f"lumdump: warning: {out}: pcap has no room for {said} used: write pcapng to keep "
                                  f"{pronoun}\n", text)
                    self.assertNotIn("no room", self.done("lumdump", *words, "-o", self.folder / "c.pcapng").stderr)
                    self.assertEqual(self.done("lumdump", *words, "-o", out, "-q").stderr, "")

    def test_what_is_wrong_is_said_with_what_is_right(self):
        source = self.capture()
        out = self.folder / "out.csv"
        for setting, said in (
                ("eyes.blu.mount.x_m=1", "unknown key 'eyes.blu.mount.x_m'; did you mean 'eyes.blue.mount.x_m'?"),
                ("group.line.to=1", "unknown key 'group.line.to'; did you mean 'group.line.at'?"),
                ("eyes.red.mount.x_m=1", "eyes: unknown key 'red'; allowed here: blue, green"),
                ("tlv=1", "tlv: a single value does not belong here; allowed: a mapping of command, status, debug, yscan"),
                ("colour=blue", "'colour' is not a key of a calibration or a profile; see calib/typical.yaml and"),
                ("x" * 300 + "=1", "is not a key of a calibration or a profile"),
                ("tof_lsb_ps\n=13", "'tof_lsb_ps?=13': a key and its value are printable ASCII"),
                ("tof_lsb_ps=\x1b[1m", "'tof_lsb_ps=?[1m': a key and its value are printable ASCII"),
                ("version=1", "version is a key of files only"),
                ("tof_lsb_ps", "'tof_lsb_ps' is not KEY=VALUE, such as eyes.blue.mount.yaw_deg=-30.5"),
                ("=3", "'=3' is not KEY=VALUE"),
                ("", "'' is not KEY=VALUE"),
                ("tof_lsb_ps=", "tof_lsb_ps: '' is not a decimal number; allowed: above 0, at most 1000 ps"),
                ("tof_lsb_ps=1000.001", "tof_lsb_ps: '1000.001' is out of range; allowed: above 0, at most 1000 ps"),
                ("line_span_us=1.5", "line_span_us: '1.5' is not a whole number in digits; allowed: 0 to 1000000000 us"),
                ("set_ip_order=big", "set_ip_order: 'big' is not known; allowed: network or little")):
            for tool in built(("lumdump", source, "-o", out), ("lumview", source), ("lumsim", "-o", out), ("lumtable",),
                              ("lumctl", "status")):
                with self.subTest(setting=setting, tool=tool[0]):
                    text = self.refused(*tool, "--set", setting)
                    self.assertIn(f"{tool[0]}: --set: ", text)
                    self.assertIn(said, text)
        self.assertFalse(out.exists())

    def test_values_that_clash_blame_the_setting(self):
        source = self.capture()
        out = self.folder / "out.csv"
        file = self.folder.write("c.yaml", "version: 1\neyes: {green: {elevation: {max_deg: -10}}}\n")
        lumdump = ("lumdump", source, "-o", out)
        for tool in built(lumdump, ("lumview", source), ("lumsim", "-o", out), ("lumtable",)):
            with self.subTest(tool[0]):
                text = self.refused(*tool, "--set", "eyes.blue.elevation.max_deg=-20")
                self.assertIn("--set eyes.blue.elevation.max_deg=-20: min_deg must be below max_deg; they are -17 (the "
                              "default) and -20", text)
                text = self.refused(*tool, "--calibration", file, "--set=eyes.green.elevation.min_deg=-5")
                self.assertIn("they are -5 and -10 (as it was)", text)
                text = self.refused(*tool, "--set", "group.tag=14", "--set", "tof_lsb_ps=12")
                self.assertIn("--set group.tag=14: bytes 14 to 14 overlap group.line", text)
        self.assertIn("the profile of --set gives packets no timestamp", self.refused(
            *lumdump, "--time", "utc", "--set", "group.timestamp=none"))
        self.assertFalse(out.exists())


class Others(Case):
    def test_lumsim(self):
        profile = self.folder.write("p.yaml", PROFILE)
        calibration = self.folder.write("c.yaml", CALIBRATION)
        by_file = simulate(self.folder / "file.pcap", "-n", 1, "--profile", profile, "--calibration", calibration)
        by_key = simulate(self.folder / "key.pcap", "-n", 1, *PROFILE_SET, "--set", "eyes.blue.mount.x_m=20", "--set",
                          "eyes.blue.mount.y_m=-3", "--set", "tof_lsb_ps=12.5")
        self.assertEqual(*[list(frames_of(p.read_bytes())) for p in (by_file, by_key)])
        known = simulate(self.folder / "key.pcapng", "-n", 1, *PROFILE_SET, "--set", "tof_lsb_ps=12.5")
        self.assertGreater(len(self.points(known)), 1000)
        text = self.refused("lumsim", "--replay", known, "--set", "tof_lsb_ps=12")
        self.assertIn("--set tof_lsb_ps=12: a key of a calibration does not go with --replay", text)
        text = self.refused("lumsim", "-o", self.folder / "x.pcap", "--set", "group.num_samples.bytes=1")
        self.assertIn("lumsim: --set: group.num_samples is too narrow for what it has to hold: it has 8 bits and needs 9\n", text)

    def test_lumtable(self):
        file = self.folder.write("c.yaml", CALIBRATION)
        by_key = self.done("lumtable", "--set", "eyes.blue.mount.x_m=20", "--set", "eyes.blue.mount.y_m=-3", "--set",
                           "tof_lsb_ps=12.5").stdout
        self.assertIn(" *   calibration: built in\n *   set: eyes.blue.mount.x_m=20\n", by_key)
        by_file = self.done("lumtable", "--calibration", file).stdout
        self.assertEqual(*[re.sub(r"/\*.*?\*/", "", text, count=1, flags=re.S) for text in (by_key, by_file)])

    def test_lumctl(self):
        profile = self.folder.write("p.yaml", "version: 1\nset_ip_order: little\n")
        words = ["lumctl", "--dry-run", "--sequence", "7", "set-ip", "10.42.0.38"]
        by_file = self.done(*words, "--profile", profile).stdout
        self.assertNotEqual(by_file, self.done(*words).stdout)
        self.assertEqual(by_file, self.done(*words, "--set", "set_ip_order=little").stdout)
        calibration = self.folder.write("c.yaml", "version: 1\neyes: {blue: {elevation: {max_deg: -5}}}\n")
        words = ["lumctl", "--dry-run", "--sequence", "7", "yscan", "--shape", "uniform"]
        by_file = self.done(*words, "--calibration", calibration).stdout
        self.assertNotEqual(by_file, self.done(*words).stdout)
        self.assertEqual(by_file, self.done(*words, "--set", "eyes.blue.elevation.max_deg=-5").stdout)

    def test_commands_of_lumctl_that_use_no_calibration_refuse_it(self):
        owners = "yscan, apply, sweep, shell"
        commands = [("status",), ("time", "--watch"), ("set-ip", "10.42.0.38"), ("laser", "off"), ("power", 50), ("lines", 64),
                    ("send", "50p"), ("tlv", "1:00"), ("find",), ("show",), ("save",), ("heartbeat",), ("doctor",)]
        for command in commands:
            with self.subTest(command):
                self.assertEqual(self.refused("lumctl", "--host", "127.0.0.1", *command, "--calibration", "nofile"),
                                 f"lumctl: --calibration does not go with {command[0]}; it goes with {owners}\n")
                self.assertEqual(self.refused("lumctl", "--set", "line_span_us=9", "--set", "tof_lsb_ps=3", *command),
                                 "lumctl: --set tof_lsb_ps=3: a key of a calibration does not go with "
                                 f"{command[0]}; it goes with {owners}\n")

    def test_a_shell_of_lumctl_takes_a_calibration_for_its_commands(self):
        top = "eyes.blue.elevation.max_deg=-5"
        words = ["--dry-run", "--sequence", "7", "yscan", "--shape", "uniform"]
        wanted = self.done("lumctl", *words, "--set", top).stdout
        r = run("lumctl", "--host", "127.0.0.1", "shell", "--set", top, stdin=(
            " ".join(words) + "\nset-ip 10.42.0.38 --dry-run --sequence 7\npower 5 --dry-run --set tof_lsb_ps=3\n"
            "set-ip 10.42.0.38 --dry-run --profile nofile\n").encode())
        plain = self.done("lumctl", "--dry-run", "--sequence", 7, "set-ip", "10.42.0.38").stdout
        self.assertEqual(r.stdout, wanted + plain)
        self.assertIn("--set tof_lsb_ps=3: a key of a calibration does not go with power", r.stderr)
        self.assertIn("and --profile hold for a whole shell", r.stderr)

    def test_a_shell_of_lumctl_has_one_layout(self):
        words = [b"set-ip 10.42.0.38", b"set-ip 10.42.0.38 --set tlv.debug=9", b"set-ip 10.42.0.38"]
        r = run("lumctl", "--host", "127.0.0.1", "--set", "set_ip_order=little", "shell",
                stdin=b"".join(w + b" --dry-run --sequence 7 -q\n" for w in words))
        little = self.done("lumctl", "--dry-run", "--sequence", 7, "set-ip", "10.42.0.38", "--set",
                           "set_ip_order=little").stdout
        self.assertEqual(r.stdout, 2 * little)
        self.assertEqual(r.stderr, "lumctl: --set tlv.debug=9: a key of a profile holds for a whole shell: leave it, and "
                                   "give it to lumctl shell\n")


if __name__ == "__main__":
    shards.main()
