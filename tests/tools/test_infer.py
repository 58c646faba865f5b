#!/usr/bin/env python3
"""lumdump --infer: the layout of a capture, from its packets alone. Captures are the simulator's, by profiles that the
tool does not see."""
import gzip
import json
import os
import pathlib
import random
import re
import resource
import shlex
import shutil
import signal
import struct
import subprocess
import unittest

import built
import shards
from support import BIN, MAGIC, PATIENCE_S, Folder, frames_of, group, line, pcap, run, simulate, summary, udp, word

# No field where it is usual.
OTHER = """version: 1
data_packet_type: 3
group: {tag: 13, eye: 12, line: 16, num_samples: 14, first_sample_index: 18, timestamp: 20, samples: 28}
eye_values: {blue: 66, green: 71}
"""
# The tag is the type, and there is no clock.
TAG_AT_TYPE = """version: 1
group: {tag: 8, eye: 12, line: {at: 18, bytes: 1}, num_samples: 14, first_sample_index: 16, timestamp: none, samples: 20}
"""
# The eye is the top bit of the line's number, ticks of 10 us have 8 bytes, and nothing is little-endian.
WIDE = """version: 1
data_packet_type: 17
group:
  tag: 30
  eye: {at: 16, bytes: 2, order: big, bits: [15, 15]}
  line: {at: 16, bytes: 2, order: big, bits: [0, 14]}
  num_samples: none
  first_sample_index: {at: 12, bytes: 4, order: big}
  timestamp: {at: 20, bytes: 8, order: big, unit_ns: 10000}
  samples: 32
sample_order: big
angle_order: elevation_azimuth
"""
# Two numbers in the bits of four bytes.
PACKED = """version: 1
group:
  line: {at: 14, bytes: 4, bits: [0, 11]}
  first_sample_index: {at: 14, bytes: 4, bits: [12, 27]}
  num_samples: 18
"""
# The eye and an index, whose 11 lowest bits end with a byte.
TIGHT = """version: 1
group:
  eye: {at: 16, bytes: 4, bits: [0, 0]}
  first_sample_index: {at: 16, bytes: 4, bits: [5, 18]}
  num_samples: none
"""
KEYS = ("data_packet_type", "group.tag", "group.eye", "group.line", "group.num_samples", "group.first_sample_index",
        "group.timestamp", "group.samples", "eye_values", "angle_order", "angle_lsb_deg", "line_span_us")
FRAMES = ("--frames", "2", "--lines", "64")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def capture(self, profile=None, *options, name="c.pcap"):
        """A capture by a profile, which is given as text."""
        told = () if profile is None else ("--profile", self.folder.write("true.yaml", profile))
        return simulate(self.folder / name, *FRAMES, *told, *options)

    def infer(self, *sources, status=0, **options):
        r = run("lumdump", *sources, "--infer", **options)
        self.assertEqual(r.returncode, status, r.stderr)
        return r

    def points(self, capture, profile):
        """All that is decoded by a profile, as text."""
        r = run("lumdump", capture, "--profile", profile, "-q", "-o", "-", "--format", "csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertGreater(len(r.stdout_bytes), 100_000)
        return r.stdout_bytes

    def assert_same_points(self, capture, one, other):
        self.assertTrue(self.points(capture, one) == self.points(capture, other), "other points")


class Found(Case):
    def test_the_profile_gives_the_points_of_the_true_one(self):
        for name, profile in ("usual", "version: 1\n"), ("other", OTHER), ("tag at the type", TAG_AT_TYPE), ("wide", WIDE), \
                ("packed", PACKED):
            with self.subTest(name):
                capture = self.capture(profile)
                r = self.infer(capture, "-o", self.folder / "found.yaml")
                self.assertEqual(r.stdout, "")
                self.assertRegex(r.stderr, r"^lumdump: .*c\.pcap: found: ")
                self.assert_same_points(capture, self.folder / "true.yaml", self.folder / "found.yaml")

    def test_loss_disorder_and_corruption_do_no_harm(self):
        capture = self.capture(OTHER, "--loss", "0.03", "--reorder", "0.03", "--corrupt", "0.01", "--seed", "4")
        self.infer(capture, "-o", self.folder / "found.yaml")
        self.assert_same_points(capture, self.folder / "true.yaml", self.folder / "found.yaml")

    def test_a_number_has_all_its_bits_though_few_packets_need_the_highest(self):
        """Of lines with more than 2,048 words only two are left: 11 bits explain all packets but a few."""
        capture = self.capture(TIGHT)
        data = capture.read_bytes()
        packets, at = [], 24
        while at < len(data):
            length = struct.unpack_from("<I", data, at + 8)[0]
            packets.append(data[at:at + 16 + length])
            at += 16 + length
        word_of = lambda packet, first, size: int.from_bytes(packet[16 + 42 + first:16 + 42 + first + size], "little")
        line_of = lambda packet: (word_of(packet, 14, 2), word_of(packet, 16, 4) & 1)
        index_of = lambda packet: word_of(packet, 16, 4) >> 5 & 0x3fff
        full = sorted({line_of(p) for p in packets if index_of(p) >= 2048})
        self.assertGreater(len(full), 2)
        kept = [p for p in packets if line_of(p) not in full[2:]]
        few = sum(index_of(p) >= 2048 for p in kept)
        self.assertTrue(0 < few < 0.004 * len(kept), (few, len(kept)))
        source = self.folder.write("few.pcap", data[:24] + b"".join(kept))
        findings = {f["key"]: f for f in json.loads(self.infer(source, "--json").stdout)["findings"]}
        value = findings["group.first_sample_index"]["value"]
        self.assertRegex(value, r"^\{at: \d+, bytes: \d, bits: \[\d+, \d+\]\}$")
        first, size, low, high = map(int, re.findall(r"\d+", value))
        for p in kept:
            self.assertEqual(word_of(p, first, size) >> low & (1 << high - low + 1) - 1, index_of(p), value)

    def test_a_profile_that_the_capture_bears_is_not_used(self):
        """It is wrong, and lumdump would use it."""
        true = self.capture(OTHER)
        r = run("lumdump", true, "-o", self.folder / "c.pcapng", "--profile", self.folder / "true.yaml", "--set", "line_span_us=1")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.infer(self.folder / "c.pcapng", "-o", self.folder / "found.yaml")
        self.assert_same_points(true, self.folder / "true.yaml", self.folder / "found.yaml")


class Unsure(Case):
    """One frame, and a clock that ticks once a line: either number may be the line."""

    def setUp(self):
        super().setUp()
        profile = self.folder.write("true.yaml", "version: 1\n")
        data = bytearray(simulate(self.folder / "c.pcap", "--frames", "1", "--lines", "64", "--profile", profile).read_bytes())
        at = 24
        while at < len(data):
            length = struct.unpack_from("<I", data, at + 8)[0]
            number, = struct.unpack_from("<H", data, at + 16 + 42 + 14)
            struct.pack_into("<I", data, at + 16 + 42 + 20, number + 200)
            at += 16 + length
        self.source = self.folder.write("c.pcap", data)

    def test_a_profile_is_written_and_called_unsure(self):
        r = self.infer(self.source)
        self.assertRegex(r.stderr, r"^lumdump: .*c\.pcap: unsure: ")
        self.assertIn(": look at the points before you rely on this profile, or take a longer capture.\n", r.stderr)
        self.assertIn("\nversion: 1\n", "\n" + r.stdout)


class Told(Case):
    def setUp(self):
        super().setUp()
        self.source = self.capture(OTHER)

    def test_without_a_name_the_profile_goes_to_standard_output_and_the_report_to_standard_error(self):
        r = self.infer(self.source)
        self.infer(self.source, "-o", self.folder / "found.yaml")
        self.assertEqual(r.stdout, (self.folder / "found.yaml").read_text())
        self.assertEqual(self.infer(self.source, "-o", "-").stdout, r.stdout)
        self.assertTrue(r.stdout.endswith("\n"))
        self.assertIn("\nversion: 1\n", "\n" + r.stdout)

    def test_the_report_has_every_key_with_its_evidence_and_the_margin(self):
        text = self.infer(self.source).stderr
        for key in KEYS:
            self.assertRegex(text, rf"(?m)^{re.escape(key)}: \S.*\n    \S")
        self.assertRegex(text, r"(?m)^explained +\d+ of \d+ packets; margin \d+\.\d points, of group\.\w+ \(sure from 2\.0\)$")
        self.assertRegex(text, r"(?m)^looked at +\d+ packets that may be data, of 1 sensor; 0 of other kinds, 0 foreign$")

    def test_what_packets_cannot_tell_is_said_with_the_look_that_decides(self):
        findings = {f["key"]: f for f in json.loads(self.infer(self.source, "--json").stdout)["findings"]}
        self.assertTrue(findings["eye_values"]["equal"])
        self.assertIn("lumview", findings["eye_values"]["look"])
        text = self.infer(self.source, "-o", self.folder / "found.yaml").stderr
        self.assertRegex(text, r"\neye_values: .*\n    not in the packets: .*\n    fits equally well: .*\n    what decides: ")
        self.assertIn("\nTo look at two readings side by side, copy the profile as other.yaml, change the key in the copy, and:\n"
                      f"  lumview {self.source} --profile {self.folder / 'found.yaml'} --profile other.yaml\n", text)
        self.assertIn("\nTo look at two readings side by side, save the profile as profile.yaml, copy it as other.yaml, change the key in"
                      f" the copy, and:\n  lumview {self.source} --profile profile.yaml --profile other.yaml\n", self.infer(self.source).stderr)

    def test_json_is_one_object_with_all_of_it(self):
        r = self.infer(self.source, "--json")
        self.assertEqual(r.stderr, "")
        got = json.loads(r.stdout)
        self.assertEqual((got["source"], got["truncated"], got["sensors"], got["foreign"]), (str(self.source), False, 1, 0))
        self.assertEqual(got["verdict"], "found")
        self.assertTrue(0 < got["fit"] <= got["packets"] <= got["records"])
        self.assertGreater(got["margin"], 0)
        self.assertLessEqual(set(KEYS), {f["key"] for f in got["findings"]})
        for f in got["findings"]:
            self.assertEqual(set(f), {"key", "value", "told", "evidence", "equal", "look"})
            self.assertTrue(f["value"] and f["evidence"], f)
        self.assertEqual(got["profile"], self.infer(self.source).stdout)
        self.infer(self.source, "--json", "-o", self.folder / "found.yaml")
        self.assertEqual((self.folder / "found.yaml").read_text(), got["profile"])

    def test_each_record_is_counted_once(self):
        """Whatever it is: also packets of anything behind our magic, which are no data, and what goes by other ports."""
        random_of = random.Random(29)
        junk = [udp(MAGIC + random_of.randbytes(900)) for _ in range(600)]
        besides = [udp(MAGIC + bytes(4)), udp(b"no magic"), udp(MAGIC + bytes(900), sport=1, dport=2), bytes(60)]
        data = list(frames_of(self.source.read_bytes()))
        for name, packets, kinds in (("junk", junk, {"other_type": 600}), ("mixed", [*data, *junk, *besides], {"packets": len(data), "other_type": 600}),
                                     ("besides", besides, {})):
            with self.subTest(name):
                source = self.folder.write(f"{name}.pcap", pcap(packets, step=1e-5))
                r = run("lumdump", source, "--infer", "--json")
                got = json.loads(r.stdout)
                counts = {k: got[k] for k in ("packets", "other_type", "control", "foreign", "cut_short", "left_out", "elsewhere")}
                self.assertEqual(sum(counts.values()), got["records"], counts)
                self.assertLessEqual(kinds.items(), counts.items())
                if besides[0] in packets:
                    self.assertEqual((counts["control"], counts["foreign"], counts["elsewhere"]), (1, 1, 2))
        said = self.infer(self.folder / "junk.pcap", status=1).stderr
        self.assertRegex(said, r"(?m)^not used +600 packets with our magic, and without samples$")
        self.assertRegex(self.infer(self.folder / "besides.pcap", status=1).stderr, r"(?m)^not used +2 records of another port, sensor or interface, or no datagram$")

    def test_of_a_long_capture_the_first_packets_are_looked_at(self):
        """Within 64 MB of memory and 3 s of the processor, also where most of the header is 0: half of them, to be safe."""
        source = simulate(self.folder / "long.pcap", "--frames", "2", "--lines", "640", "--profile",
                          self.folder.write("long.yaml", "version: 1\ngroup: {samples: 64}\n"))
        # Programs that run under an instrument lie beside no build.
        is_fit = (BIN.parent / "CMakeCache.txt").is_file() and built.fault(BIN.parent, ()) is None
        memory = lambda: resource.setrlimit(resource.RLIMIT_AS, (64_000_000, 64_000_000))
        with subprocess.Popen([BIN / "lumdump", source, "--infer"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              preexec_fn=memory if is_fit else None) as p:
            said = p.stderr.read().decode()
            _, status, used = os.wait4(p.pid, 0)
            p.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(p.returncode, 0, said)
        self.assertRegex(said, r"(?m)^looked at +the first 20000 packets that may be data, of 1 sensor; until then 0 of other kinds, 0 foreign$")
        if is_fit:
            self.assertLess(used.ru_utime + used.ru_stime, 1.5)

    def test_quiet_is_quiet(self):
        r = self.infer(self.source, "-q", "-o", self.folder / "found.yaml")
        self.assertEqual((r.stdout, r.stderr), ("", ""))

    def test_the_evidence_stands_in_the_profile(self):
        text = self.infer(self.source).stdout
        findings = json.loads(self.infer(self.source, "--json").stdout)["findings"]
        comments = " ".join(re.findall(r"#\s?(.*)", text))
        for f in findings:
            self.assertIn(" ".join(f["evidence"].split())[:40], " ".join(comments.split()), f["key"])


class Shared(Case):
    """Captures of other makers' hands, with their true profiles: clocks of the eyes a few us apart, ticks of a nanosecond, bits."""

    WIDE = pathlib.Path(__file__).resolve().parents[3] / "shared" / "vectors-wide"

    def sources(self):
        sources = sorted(self.WIDE.glob("infer-*.pcap"))
        if not sources:
            self.skipTest("the captures of wider profiles are not beside this checkout")
        return sources

    def test_the_layout_is_found_and_gives_the_points_of_the_true_one(self):
        for source in self.sources():
            with self.subTest(source.name):
                found = self.folder / "found.yaml"
                self.assertIn(": found: ", self.infer(source, "-o", found).stderr)
                self.assert_same_points(source, source.with_suffix(".profile.yaml"), found)

    def test_the_margin_is_measured_and_a_second_reading_is_another_one(self):
        for source in self.sources():
            with self.subTest(source.name):
                r = self.infer(source, "--json")
                got = json.loads(r.stdout)
                self.assertGreater(got["margin"], 5)
                self.assertNotEqual(got["margin"], 10.0)
                self.assertNotEqual(got["second"], {})
                said = self.infer(source).stderr
                self.assertRegex(said, r"(?m)^(second best reading: group\.|no second reading was found$)")
                for f in got["findings"]:
                    if f["key"] in ("group.eye", "group.line"):
                        self.assertIn("there is no", f["evidence"])


class Sources(Case):
    def setUp(self):
        super().setUp()
        self.source = self.capture(OTHER)
        self.profile = self.infer(self.source).stdout

    def test_a_pipe(self):
        self.assertEqual(self.infer("-", stdin=self.source.read_bytes()).stdout, self.profile)

    def test_compressed(self):
        packed = self.folder.write("c.pcap.gz", gzip.compress(self.source.read_bytes(), 1))
        self.assertEqual(self.infer(packed).stdout, self.profile)
        if shutil.which("zstd"):
            subprocess.run(["zstd", "-q", self.source], check=True, timeout=PATIENCE_S)
            self.assertEqual(self.infer(self.folder / "c.pcap.zst").stdout, self.profile)

    def test_several(self):
        data = self.source.read_bytes()
        at, count = 24, 0
        while count < 1000:
            at += 16 + struct.unpack_from("<I", data, at + 8)[0]
            count += 1
        parts = [self.folder.write("b.pcap", data[:24] + data[at:]), self.folder.write("a.pcap", data[:at])]
        r = self.infer(*parts)
        self.assertEqual(r.stdout, self.profile)
        self.assertIn("b.pcap and 1 more: ", r.stderr)

    def test_one_that_breaks_off(self):
        cut = self.folder.write("cut.pcap", self.source.read_bytes()[:-100])
        r = self.infer(cut, "-o", self.folder / "found.yaml")
        self.assertRegex(r.stderr, r"^lumdump: warning: .*cut\.pcap")
        self.assert_same_points(self.source, self.folder / "true.yaml", self.folder / "found.yaml")
        self.assertTrue(json.loads(self.infer(cut, "--json", "-q").stdout)["truncated"])

    def test_the_reader_of_a_pipe_may_leave(self):
        """It has left before the first byte."""
        for options in (), ("--json",):
            reader, writer = os.pipe()
            os.close(reader)
            with open(writer, "wb") as pipe:
                r = subprocess.run([BIN / "lumdump", self.source, "--infer", *options], stdout=pipe, stderr=subprocess.PIPE, timeout=PATIENCE_S)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertNotIn(b"cannot be written", r.stderr)

    def test_ctrl_c_ends_it_and_leaves_nothing(self):
        out = self.folder / "found.yaml"
        with subprocess.Popen([BIN / "lumdump", "-", "--infer", "-o", out], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as p:
            p.stdin.write(self.source.read_bytes()[:200_000])
            p.stdin.flush()
            p.send_signal(signal.SIGINT)
            self.assertEqual(p.wait(PATIENCE_S), -signal.SIGINT)
            self.assertEqual((p.stdout.read(), p.stderr.read()), (b"", b""))
        self.assertFalse(out.exists())

    def test_a_sensor_is_chosen(self):
        """Two sensors with two layouts in one capture."""
        usual = simulate(self.folder / "u.pcap", *FRAMES, "--seed", "2")
        data, at = bytearray(usual.read_bytes()), 24
        while at < len(data):
            data[at + 42:at + 46] = bytes((10, 42, 0, 99))
            at += 16 + struct.unpack_from("<I", data, at + 8)[0]
        both = (self.source, self.folder.write("renamed.pcap", data))
        for sensor, capture, true in (("10.42.0.99", usual, self.folder.write("usual.yaml", "version: 1\n")),
                                      ("10.42.0.37", self.source, self.folder / "true.yaml")):
            r = self.infer(*both, "--sensor", sensor, "-o", self.folder / "found.yaml")
            self.assertIn("of 1 sensor;", r.stderr)
            self.assert_same_points(capture, true, self.folder / "found.yaml")
        self.infer(*both, "--sensor", "10.42.0.98", status=1)


class NothingFound(Case):
    """No profile, no file, and a reason."""

    def nothing(self, source, verdict, *words):
        out = self.folder.write("kept.yaml", "kept\n")
        before = self.folder.names()
        r = self.infer(source, "-o", out, status=1)
        self.assertEqual((r.stdout, out.read_text(), self.folder.names()), ("", "kept\n", before))
        self.assertRegex(r.stderr, rf"^lumdump: .*: {verdict}: \S")
        for wanted in words:
            self.assertIn(wanted, r.stderr)
        self.assertEqual(self.infer(source, status=1).stdout, "")
        r = self.infer(source, "--json", status=1)
        got = json.loads(r.stdout)
        self.assertEqual((got["verdict"], got["profile"], got["margin"], got["findings"]), (verdict, None, None, []))
        self.assertTrue(got["text"])

    def test_random_bytes_behind_the_magic(self):
        rng = random.Random(7)
        frames = [udp(MAGIC + rng.randbytes(rng.choice((1352, 900, 1460)))) for _ in range(600)]
        self.nothing(self.folder.write("c.pcap", pcap(frames)), "nothing fits")

    def test_heartbeats_and_answers_alone(self):
        frames = [udp(MAGIC + struct.pack("<I", 8), sport=50000, dport=5517)] * 30 + \
                 [udp(MAGIC + struct.pack("<III", 6, 5, n)) for n in range(30)]
        self.nothing(self.folder.write("c.pcap", pcap(frames)), "too little")

    def test_packets_that_are_cut(self):
        frames = list(frames_of(self.capture(OTHER).read_bytes()))
        count = sum(len(f) > 96 for f in frames)
        source = self.folder.write("cut.pcap", pcap([f[:96] for f in frames]))
        self.assertGreater(count, 1000)
        self.nothing(source, "too little", "only in part", "tcpdump -s 0", f"{count} datagrams")
        self.assertEqual(json.loads(self.infer(source, "--json", status=1).stdout)["cut_short"], count)

    def test_reserved_bytes_that_are_not_0(self):
        frames = [f[:42] + f[42:51] + b"\1" + f[52:] for f in frames_of(self.capture(OTHER).read_bytes())]
        self.nothing(self.folder.write("c.pcap", pcap(frames)), "nothing fits", "bytes 9 to 11 of ")

    def test_a_few_packets(self):
        source = self.capture(OTHER)
        few = self.folder.write("few.pcap", pcap(list(frames_of(source.read_bytes()))[:6]))
        self.nothing(few, "too little")

    def test_nothing_of_a_g2(self):
        self.nothing(self.folder.write("c.pcap", pcap([udp(b"hello")] * 40)), "too little")
        self.nothing(self.folder.write("c.pcap", pcap([])), "too little")

    def test_what_is_no_capture(self):
        r = self.infer(self.folder.write("c.txt", "not a capture, but long enough to be looked at"), "-o", self.folder / "p.yaml", status=1)
        self.assertIn("not a capture", r.stderr)
        self.assertEqual(self.folder.names(), ["c.txt"])
        self.assertIn("none.pcap", self.infer(self.folder / "none.pcap", status=1).stderr)


class Refused(Case):
    def refused(self, *arguments, message, status=2):
        r = run("lumdump", *arguments)
        self.assertEqual((r.returncode, r.stdout), (status, ""), r.stderr)
        self.assertIn(message, r.stderr)

    def test_options_that_do_not_apply(self):
        for option in (["--eye", "blue"], ["--frames", "1:2"], ["--profile", "p.yaml"], ["--calibration", "c.yaml"],
                       ["--set", "line_span_us=1"], ["--duration", "1"], ["--laser"], ["--format", "csv"], ["--rotate", "1MB"],
                       ["--time", "utc"], ["--smooth", "31"], ["--ascii"], ["--return", "last"], ["--edge", "both"],
                       ["--interface", "lo"], ["--packets", "all"], ["--columns", "x"], ["--comments"]):
            self.refused("c.pcap", "--infer", *option, message=f"{option[0]} does not go with --infer")

    def test_a_sensor_is_recorded_first(self):
        self.refused("udp://127.0.0.1", "--infer", message="lumdump udp://127.0.0.1 --laser --duration 3 -o look.pcap")

    def test_outputs(self):
        source = self.capture()
        self.refused(source, "--infer", "-o", "a.yaml", "-o", "b.yaml", message="name one output")
        for name in "c.ply", "c.pcap", "c.csv":
            self.refused(source, "--infer", "-o", name, message=f"'{name}': --infer writes a profile")
        self.refused(source, "--infer", "--json", "-o", "-", message="--json and -o - would both write to standard output")
        os.link(source, self.folder / "same.yaml")
        self.refused(source, "--infer", "-o", self.folder / "same.yaml", message="is the source itself")
        self.refused(source, "--infer", "-o", self.folder / "no" / "p.yaml", message="the directory does not exist", status=1)
        with open(source, "rb+") as out:
            r = subprocess.run([BIN / "lumdump", source, "--infer"], stdout=out, stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, b"standard output is the source itself" in r.stderr), (2, True), r.stderr)

    def test_a_disk_that_is_full(self):
        source = self.capture()
        with open("/dev/full", "wb") as full:
            r = subprocess.run([BIN / "lumdump", source, "--infer"], stdout=full, stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 1)
        self.assertIn(b"standard output", r.stderr)


class Named(Case):
    """Whoever meets packets that do not decode is led to a profile."""

    def follow(self, said):
        """Run the two commands that stand in a message, each in its line."""
        commands = re.findall(r"(?m)^  (lumdump .*)$", said)
        self.assertEqual(len(commands), 2, said)
        for command in commands:
            r = subprocess.run(command, shell=True, cwd=self.folder.path, capture_output=True, text=True, timeout=PATIENCE_S,
                               env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"})
            self.assertEqual(r.returncode, 0, r.stderr)
        self.assertRegex(r.stdout, r"\d+  points")

    def test_the_diagnosis_leads_to_points(self):
        r = run("lumdump", self.capture(OTHER))
        self.assertEqual(r.returncode, 1)
        self.follow(r.stderr)

    def test_names_are_words_of_a_shell(self):
        folder = self.folder / ("it's a long way; " + 180 * "x")
        folder.mkdir()
        source = folder / "-my drive.pcap"
        source.write_bytes(self.capture(OTHER).read_bytes())
        self.follow(run("lumdump", source).stderr)
        r = self.infer(source, "-o", self.folder / "my profile.yaml")
        command, = re.findall(r"(?m)^  (lumview .*)$", r.stderr)
        self.assertEqual(shlex.split(command),
                         ["lumview", str(source), "--profile", str(self.folder / "my profile.yaml"), "--profile", "other.yaml"])

    def test_a_name_that_no_line_can_show_is_not_shown(self):
        source = self.folder.write("a\nb.pcap", self.capture(OTHER).read_bytes())
        self.assertIn("  lumdump CAPTURE --infer -o profile.yaml\n", run("lumdump", source).stderr)

    def test_packets_that_partly_fit_are_a_warning(self):
        source = self.capture()
        wrong = self.folder.write("p.yaml", "version: 1\ngroup: {num_samples: 18, first_sample_index: 16}\n")
        warning = f"do not fit the layout: lumdump {source} --infer -o profile.yaml finds the layout"
        r = run("lumdump", source, "--profile", wrong)
        self.assertEqual(r.returncode, 0)
        self.assertIn(warning, r.stderr)
        self.assertNotIn("--infer", run("lumdump", source, "--profile", wrong, "-q").stderr)
        self.assertNotIn("--infer", run("lumdump", source).stderr)

    def test_a_bad_network_is_no_other_layout(self):
        source = self.capture(None, "--corrupt", "0.05", "--loss", "0.1", "--reorder", "0.1")
        self.assertGreater(summary(source)["malformed"] + summary(source)["bad_words"], 0)
        self.assertNotIn("--infer", run("lumdump", source).stderr)

    def test_a_few_packets_are_no_other_layout(self):
        for count, is_named in (19, False), (20, True):
            frames = [udp(p) for p in line([word(1000, 5)])] + [udp(group(2, 0, 0, [bytes(4)], packet_type=9))] * count
            r = run("lumdump", self.folder.write("c.pcap", pcap(frames)))
            self.assertEqual("--infer" in r.stderr, is_named, r.stderr)

    def test_words_that_cannot_be_name_it(self):
        source = self.capture("version: 1\ngroup: {samples: 28}\n")
        wrong = self.folder.write("p.yaml", "version: 1\ngroup: {samples: 25}\n")
        self.assertRegex(run("lumdump", source, "--profile", wrong).stderr, f"range words are impossible.*: lumdump {source} --infer")

    def test_lines_that_all_lack_angles_name_it(self):
        """The count of samples and the line are exchanged: short packets, which decode."""
        source = self.capture("version: 1\ngroup: {line: 16, num_samples: 14}\n")
        r = run("lumdump", source)
        self.assertEqual(r.returncode, 0)
        self.assertRegex(r.stderr, f"each of [0-9]+ lines lacks angles, so the layout may be another one: lumdump {source} --infer")
        frames = [udp(p) for n in range(20) for p in list(line([word(1000, 5)] * 4, number=n, clock=1000 * n))[n > 0:]]
        r = run("lumdump", self.folder.write("c.pcap", pcap(frames)))
        self.assertNotIn("--infer", r.stderr)

    def test_clocks_that_jump_name_it(self):
        rng = random.Random(3)
        frames = [udp(group(2, 0, n // 3, [bytes(4)] * 334, n % 3 * 333, rng.getrandbits(32))) for n in range(90)]
        source = self.folder.write("c.pcap", pcap(frames))
        self.assertRegex(run("lumdump", source).stderr, f"the clocks of .* jump.*: lumdump {source} --infer")

    def test_of_several_one_is_named_and_a_pipe_is_a_capture(self):
        source = self.capture(OTHER)
        copy = self.folder.write("d.pcap", source.read_bytes())
        self.assertIn(f"  lumdump {source} --infer -o profile.yaml\n", run("lumdump", source, copy).stderr)
        self.assertIn("  lumdump CAPTURE --infer -o profile.yaml\n", run("lumdump", "-", stdin=source.read_bytes()).stderr)


if __name__ == "__main__":
    shards.main()
