#!/usr/bin/env python3
"""lumsim from outside: options, exit statuses, files, signals, truth."""
import os
import pathlib
import re
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import shards
from support import BIN, PATIENCE_S, frames_of, run, summary

TICK_S = 0.02


def sim(*arguments, **options):
    return run("lumsim", *arguments, **options)


def parse(frame):
    """Times aside: what a frame of our own captures holds."""
    return {"source": ".".join(map(str, frame[26:30])),
            "destination": ".".join(map(str, frame[30:34])),
            "ports": struct.unpack(">HH", frame[34:38]),
            "payload": frame[42:]}


class Lumsim(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.dir = pathlib.Path(directory.name)
        self.pcap = self.dir / "street.pcap"

    def files(self):
        return sorted(p.name for p in self.dir.iterdir())

    def simulate(self, *arguments, frames=1, name="street.pcap"):
        r = sim("-o", self.dir / name, "--frames", frames, "-q", *arguments)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return (self.dir / name).read_bytes()


class Options(Lumsim):
    def refused(self, *arguments, says):
        r = sim(*arguments)
        self.assertEqual(r.returncode, 2, r.stderr)
        self.assertEqual(r.stdout, "")
        self.assertRegex(r.stderr, says)
        self.assertEqual(self.files(), [])

    def test_help_and_version_go_to_standard_output(self):
        r = sim("--help")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        for word in ("Examples:", "--truth", "--reorder", "Exit status"):
            self.assertIn(word, r.stdout)
        r = sim("--version")
        self.assertEqual(r.returncode, 0)
        self.assertRegex(r.stdout, r"^lumsim \d+\.\d+\.\d+\n$")

    def test_help_names_every_option_that_works(self):
        manual = pathlib.Path(__file__).parents[2] / "docs/man/lumsim.1"
        page = manual.read_text()
        for option in re.findall(r"--([a-z-]+)", sim("--help").stdout):
            self.assertRegex(page, rf"Fl \\-{option}\b".replace("-", r"\\?-"))

    def test_values_out_of_range_are_refused_with_what_is_right(self):
        for arguments, says in [
                (("--frames", 0), "'0' is not a whole number from 1"),
                (("--frames", "-1"), "from 1 to"),
                (("--frames", "3x"), "'3x'"),
                (("--frames", ""), "''"),
                (("--lines", 128), "64 or 640"),
                (("--rate", 0), "0.2 to 100"),
                (("--rate", "nan"), "0.2 to 100"),
                (("--rate", 101), "0.2 to 100"),
                (("--seed", "-1"), "from 0 to"),
                (("--seed", "x"), "from 0 to"),
                (("--returns-max", 9), "from 1 to 8"),
                (("--loss", 1.01), "--loss.*probability from 0 to 1"),
                (("--loss", "-0.1"), "probability"),
                (("--duplicate", "nan"), "--duplicate.*probability"),
                (("--reorder", "inf"), "--reorder.*probability"),
                (("--corrupt", "1e3"), "--corrupt.*probability"),
                (("--drift", "1001"), "-1000 to 1000"),
                (("--batch", "-1"), "0 to 1000"),
                (("--time", "arrival"), "one of sensor utc"),
                (("--time", "utc"), "--truth"),
                (("--address", "10.42.0"), "nor the name of a host"),
                (("--address", "0.0.0.0"), "address of a host"),
                (("--address", "224.0.0.1"), "address of a host"),
                (("--client", "10.42.0.1:0"), "port"),
                (("--client", "10.42.0.1:65536"), "port"),
                (("--client", ":1"), "nor the name of a host"),
                (("--nonsense",), "nonsense"),
                (("stray",), "stray")]:
            with self.subTest(arguments=arguments):
                self.refused("-o", self.pcap, *arguments, says=says)

    def test_names_of_options_are_written_out(self):
        for arguments, says in [
                (("--fram", "1"), r"--fram: no such option; did you mean --frames\? See lumsim --help"),
                (("--frmes=1",), r"did you mean --frames\?"),
                (("--re", "0"), "--re: no such option"),
                (("--truth",), "--truth: a value is missing: the name of a file"),
                (("--rate",), "--rate: a value is missing: a number from 0.2 to 100"),
                (("--quiet=1",), "--quiet takes no value: '1'"),
                (("-x",), "-x: no such option")]:
            with self.subTest(arguments=arguments):
                self.refused("-o", self.pcap, *arguments, says=says)

    def test_two_outputs_with_one_name_are_refused(self):
        self.refused("-o", self.pcap, "--truth", self.pcap, says="different names")
        self.refused("-o", "-", "--truth", "-", says="different names")

    def test_faults_of_configuration_files_are_told(self):
        self.refused("-o", self.pcap, "--calibration", "/nonexistent.yaml",
                     says="/nonexistent.yaml")
        for option, text, says in [
                ("--calibration", "version: 1\nnonsense: 3\n", "nonsense"),
                ("--profile", "version: 1\nangle_lsb_deg: 0.0001\n", "angle_lsb_deg"),
                ("--profile", "version: 1\ngroup: {num_samples: {at: 16, bytes: 1}}\n",
                 "group.num_samples is too narrow for what it has to hold: it has 8 bits and needs 9\n"),
                ("--profile", "version: 1\ngroup: {first_sample_index: {at: 18, bytes: 2, bits: [4, 15]}}\n",
                 "group.first_sample_index is too narrow for what it has to hold: it has 12 bits and needs"),
                ("--profile", "version: 1\ngroup: {tag: {at: 12, bits: [7, 7]}}\n",
                 "group.tag is too narrow for what it has to hold: it has 1 bit and needs 2\n")]:
            with self.subTest(text=text), tempfile.NamedTemporaryFile("w", suffix=".yaml") as f:
                f.write(text)
                f.flush()
                self.refused("-o", self.pcap, option, f.name, says=says)
                self.refused("-o", self.pcap, option, f.name, says=f.name)


class Captures(Lumsim):
    def test_the_same_arguments_give_the_same_bytes(self):
        arguments = ("--seed", 5, "--loss", 0.05, "--duplicate", 0.05,
                     "--reorder", 0.05, "--corrupt", 0.05)
        truths = [self.dir / "a.csv", self.dir / "b.csv"]
        a = self.simulate(*arguments, "--truth", truths[0], frames=2, name="a.pcap")
        b = self.simulate(*arguments, "--truth", truths[1], frames=2, name="b.pcap")
        self.assertEqual(a, b)
        self.assertEqual(truths[0].read_bytes(), truths[1].read_bytes())
        other = self.simulate("--seed", 6, frames=2, name="c.pcap")
        self.assertNotEqual(a, other)

    def test_a_longer_run_begins_with_the_same_frames(self):
        one = self.simulate(frames=1)
        two = self.simulate(frames=2, name="two.pcap")
        self.assertEqual(two[:len(one)], one)
        self.assertGreater(len(two), 1.9 * len(one))

    def test_standard_output_gives_the_same_capture(self):
        r = sim("-o", "-", "--frames", 1)
        self.assertEqual(r.returncode, 0)
        self.assertEqual(r.stdout_bytes, self.simulate())
        self.assertIn("standard output: 1 frame of 64 lines", r.stderr)

    def test_addresses_are_those_asked_for(self):
        data = self.simulate("--address", "10.1.2.3", "--client", "10.9.8.7:1234")
        for frame in frames_of(data):
            p = parse(frame)
            self.assertEqual((p["source"], p["destination"], p["ports"]),
                             ("10.1.2.3", "10.9.8.7", (5517, 1234)))

    def test_packets_fit_ethernet(self):
        frames = list(frames_of(self.simulate("--lines", 640)))
        self.assertGreater(len(frames), 640 * 2 * 4)
        for frame in frames:
            self.assertLessEqual(len(frame), 1514)

    def test_joined_packets_are_those_that_a_host_would_join(self):
        def records(data):
            at = 24
            while at < len(data):
                s, ns, length = struct.unpack_from("<III", data, at)
                yield (s, ns), data[at + 16 + 42:at + 16 + length]
                at += 16 + length

        options = "--lines", 640, "--returns-max", 8, "--loss", 0.01, "--seed", 4
        alone = list(records(self.simulate(*options, name="alone.pcap")))
        lengths, at = set(), 0
        for arrival, payload in records(self.simulate(*options, "--joined")):
            parts = []
            while sum(map(len, parts)) < len(payload):
                parts.append(alone[at][1])
                at += 1
            self.assertEqual((b"".join(parts), alone[at - 1][0]), (payload, arrival))
            self.assertEqual({len(p) for p in parts[:-1]} - {len(parts[0])}, set())
            self.assertLessEqual(len(parts[-1]), len(parts[0]))
            self.assertLessEqual(len(payload), 65507)
            self.assertLessEqual(len(parts), 64)
            lengths.add(len(parts))
        self.assertEqual(at, len(alone))
        self.assertGreater(max(lengths), 10)

    def test_losing_everything_leaves_an_empty_capture(self):
        self.assertEqual(len(self.simulate("--loss", 1)), 24)

    def test_duplicates_double_the_packets(self):
        clean = list(frames_of(self.simulate()))
        twice = list(frames_of(self.simulate("--duplicate", 1)))
        self.assertEqual([f[42:] for f in twice[::2]], [f[42:] for f in clean])
        self.assertEqual([f[42:] for f in twice[1::2]], [f[42:] for f in clean])

    def test_reordering_loses_nothing_and_times_rise(self):
        data = self.simulate("--reorder", 0.3)
        clean = [f[42:] for f in frames_of(self.simulate(name="clean.pcap"))]
        mixed = [f[42:] for f in frames_of(data)]
        self.assertNotEqual(mixed, clean)
        self.assertEqual(sorted(mixed), sorted(clean))
        at, before = 24, (0, 0)
        while at < len(data):
            seconds, ns, length = struct.unpack_from("<III", data, at)
            self.assertLessEqual(before, (seconds, ns))
            before = (seconds, ns)
            at += 16 + length

    def test_the_summary_counts_the_faults(self):
        r = sim("-o", self.pcap, "--frames", 1, "--loss", 0.1, "--corrupt", 0.1)
        self.assertEqual(r.returncode, 0)
        self.assertRegex(r.stderr, r"; \d+ lost; \d+ corrupted\n$")


class Truth(Lumsim):
    def compare(self, *arguments, dump=(), frames=1):
        truth = self.dir / "truth.csv"
        cloud = self.dir / "cloud.csv"
        self.simulate("--truth", truth, *arguments, frames=frames)
        r = run("lumdump", self.pcap, "-q", "-o", cloud, *dump)
        self.assertEqual(r.returncode, 0, r.stderr)
        exact, measured = map(self.table, (truth, cloud))
        self.assertEqual(list(exact), list(measured))
        self.assertEqual(len(exact["x"]), len(measured["x"]))
        self.assertGreater(len(exact["x"]), 50_000)
        return exact, measured

    @staticmethod
    def table(path):
        """Name -> the texts of its column."""
        head, _, rest = path.read_text().partition("\n")
        names, cells = head.split(","), rest.replace("\n", ",").split(",")
        return {name: cells[i:-1:len(names)] for i, name in enumerate(names)}

    def agree(self, exact, measured):
        for k in ("timestamp", "frame", "eye", "line", "pixel", "return_number", "number_of_returns", "edge"):
            self.assertTrue(exact[k] == measured[k], k)
        noise = {"range": 0.0720, "azimuth": 0.02, "elevation": 0.02, "pulse_width": 0.01}
        worst = {k: max(abs(float(e) - float(m)) for e, m in zip(exact[k], measured[k])) for k in noise}
        for k, limit in noise.items():
            self.assertLess(worst[k], limit, k)
        self.assertGreater(worst["range"], 0.05)
        self.assertGreater(worst["azimuth"], 0.01)

    def test_truth_has_the_rows_of_a_lossless_capture(self):
        self.agree(*self.compare())

    def test_truth_in_utc_is_that_of_the_capture_with_its_drift(self):
        first, second = self.dir / "sensor.csv", self.dir / "utc.csv"
        self.simulate("--truth", first, "--drift", "-300", frames=2)
        self.simulate("--truth", second, "--time", "utc", "--drift", "-300", frames=2)
        pairs = {(int(a), int(b)) for a, b in set(zip(self.table(first)["timestamp"], self.table(second)["timestamp"]))}
        self.assertGreater(len(pairs), 100)
        for clock, utc in pairs:
            self.assertLessEqual(abs(1767225600 * 10**6 + clock * (1 - 300e-6) - utc), 1)

    def test_batches_are_stamped_together_and_never_early(self):
        self.simulate(frames=1)
        exact = self.stamps()
        self.simulate("--batch", "8", frames=1)
        batched = self.stamps()
        self.assertEqual(len(exact), len(batched))
        self.assertLess(max(ns % 8_000_000 for ns in batched), 10_000)
        self.assertTrue(all(0 <= b - e < 8_010_000 for e, b in zip(exact, batched)))

    def stamps(self):
        data = self.pcap.read_bytes()
        at, out = 24, []
        while at < len(data):
            seconds, ns, length = struct.unpack_from("<III", data, at)
            out.append(seconds * 10**9 + ns)
            at += 16 + length
        return out

    def test_truth_holds_with_another_calibration_and_profile(self):
        calibration = self.dir / "calibration.yaml"
        calibration.write_text(
            "version: 1\nspeed_of_light: 299792458\ntof_lsb_ps: 14.5\neyes:\n"
            "  blue:\n    tof_offset_ps: -350.0\n"
            "    azimuth: {center_deg: 2.0, width_deg: 50.0}\n"
            "  green:\n    elevation: {min_deg: -15.0, max_deg: 4.0}\n"
            "    mount: {x_m: 0.1, y_m: 0.2, z_m: -0.3, roll_deg: 1.0, yaw_deg: 20.0}\n")
        profile = self.dir / "profile.yaml"
        profile.write_text(
            "version: 1\nangle_order: elevation_azimuth\nangle_lsb_deg: 0.002\n"
            "eye_values: {blue: 7, green: 3}\n"
            "group: {tag: 8, line: {at: 24, bytes: 4}, timestamp: {at: 20, bytes: 2}, samples: 28}\n")
        both = ("--calibration", calibration, "--profile", profile)
        self.agree(*self.compare(*both, dump=both))

    def test_truth_holds_with_wider_profiles(self):
        for text in (
                "sample_order: big\ngroup: {line: {at: 14, bytes: 2, bits: [0, 14]}, eye: {at: 14, bytes: 2, "
                "bits: [15, 15]}, num_samples: none, timestamp: {at: 24, bytes: 8, order: big, unit_ns: 1}, samples: 32}\n",
                "sample_order: big\nangle_order: elevation_azimuth\ngroup: {tag: {at: 12, bytes: 8, order: big, "
                "bits: [40, 41]}, eye: {at: 12, bytes: 8, order: big, bits: [3, 3]}, line: {at: 20, bytes: 4, order: big}, "
                "num_samples: {at: 24, bytes: 8}, first_sample_index: {at: 32, bytes: 2, order: big}, "
                "timestamp: {at: 34, bytes: 2, bits: [0, 10], unit_ns: 100000}, samples: 40}\nline_span_us: 200000\n",
                "group: {timestamp: {at: 20, bytes: 4, bits: [4, 31], unit_ns: 333}}\n"):
            with self.subTest(profile=text):
                profile = self.dir / "profile.yaml"
                profile.write_text("version: 1\n" + text)
                both = ("--profile", profile)
                self.agree(*self.compare(*both, dump=both))

    def test_640_lines_make_one_frame(self):
        truth = self.dir / "truth.csv"
        self.simulate("--lines", 640, "--truth", truth)
        found = summary(self.pcap)
        self.assertEqual((found["frames"], found["lines"]), (1, 1280))
        self.assertEqual(found["points"], truth.read_bytes().count(b"\n") - 1)
        for loss in ("lost_words", "late", "stray", "lines_missing_angles", "lines_skipped"):
            self.assertEqual(found[loss], 0, loss)

    def test_faults_harm_no_line_they_did_not_befall(self):
        self.simulate("--corrupt", 0.02, "--reorder", 0.1, "--duplicate", 0.1, frames=5)
        found = summary(self.pcap)
        self.assertEqual((found["frames"], found["lines_skipped"]), (5, 0))
        self.assertGreater(found["duplicate"] + found["late"], 400)
        self.assertGreater(found["points"], 500_000)


class Failures(Lumsim):
    def failed(self, *arguments, says, **options):
        r = sim(*arguments, **options)
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertRegex(r.stderr, says)

    def test_a_directory_that_does_not_exist(self):
        self.failed("-o", self.dir / "no" / "x.pcap", says="directory does not exist")
        self.failed("-o", self.pcap, "--truth", self.dir / "no" / "x.csv", says="directory does not exist")
        self.assertEqual(self.files(), [])

    def test_a_directory_in_the_file_s_place(self):
        self.failed("-o", self.dir, says="[Dd]irectory")
        self.assertEqual(self.files(), [])

    def test_a_directory_that_cannot_be_written(self):
        closed = self.dir / "closed"
        closed.mkdir()
        closed.chmod(0o555)
        self.dir.chmod(0o755)
        try:  # permissions do not bind root
            self.failed("-o", closed / "x.pcap", says="Permission denied",
                        **({"user": "nobody"} if os.geteuid() == 0 else {}))
        except PermissionError:
            self.skipTest("root, and nobody else may run the tool here")

    def test_a_full_disk(self):
        self.failed("-o", "/dev/full", "--frames", 2, says="No space left")
        self.failed("-o", self.pcap, "--truth", "/dev/full", "--frames", 2, says="No space left")
        self.assertEqual(self.files(), [])
        self.assertFalse(os.path.isfile("/dev/full"))

    def test_a_full_disk_on_standard_output(self):
        with open("/dev/full", "wb") as full:
            r = subprocess.run([BIN / "lumsim", "-o", "-", "--frames", "1"], stdout=full,
                               stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 1)
        self.assertIn(b"No space left", r.stderr)

    def test_help_to_a_full_disk(self):
        with open("/dev/full", "wb") as full:
            r = subprocess.run([BIN / "lumsim", "--help"], stdout=full, stderr=subprocess.PIPE,
                               timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 1)

    def test_a_reader_that_leaves_ends_the_run_quietly(self):
        p = subprocess.Popen([BIN / "lumsim", "-o", "-", "--frames", "100000"],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        p.stdout.read(1000)
        p.stdout.close()
        self.assertEqual(p.stderr.read(), b"")
        p.stderr.close()
        self.assertEqual(p.wait(timeout=PATIENCE_S), 0)

    def interrupt(self, number, *arguments, wait_for=None):
        p = subprocess.Popen([BIN / "lumsim", "-o", self.pcap, "--frames", "100000",
                              *map(str, arguments)], stderr=subprocess.PIPE)
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline and len(self.files()) < 1 + bool(arguments):
            time.sleep(TICK_S)
        time.sleep(5 * TICK_S)
        p.send_signal(number)
        self.assertEqual(p.stderr.read(), b"")
        p.stderr.close()
        self.assertEqual(p.wait(timeout=PATIENCE_S), -number)
        self.assertEqual(self.files(), [])

    def test_ctrl_c_dies_of_the_signal_and_leaves_nothing(self):
        self.interrupt(signal.SIGINT)
        self.interrupt(signal.SIGTERM)
        self.interrupt(signal.SIGINT, "--truth", self.dir / "truth.csv")

    def test_ctrl_c_ends_a_run_whose_reader_has_stalled(self):
        p = subprocess.Popen([BIN / "lumsim", "-o", "-", "--frames", "100000"],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        p.stdout.read(1)
        time.sleep(0.5)
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(timeout=PATIENCE_S), -signal.SIGINT)
        p.stdout.close()
        p.stderr.close()

    def test_a_file_that_stood_there_survives_an_interruption(self):
        self.pcap.write_text("before")
        p = subprocess.Popen([BIN / "lumsim", "-q", "-o", self.pcap, "--frames", "100000"])
        while len(self.files()) < 2:
            time.sleep(TICK_S)
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(timeout=PATIENCE_S), -signal.SIGINT)
        self.assertEqual(self.files(), ["street.pcap"])
        self.assertEqual(self.pcap.read_text(), "before")


if __name__ == "__main__":
    shards.main()
