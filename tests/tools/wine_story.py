#!/usr/bin/env python3
"""wine_story.py BIN: the programs for Windows, on loopback and with files, under wine64. The last line counts: N passed,
N failed, N skipped.

summary.txt beside BIN, which CMake wrote, tells what the build has; LUM_NATIVE_BIN in the environment names
the folder of this system's programs."""
import gzip
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

from support import PATIENCE_S

BIN = pathlib.Path(sys.argv.pop()).resolve()
ADDRESS = "127.0.0.1"  # under wine a socket sends from here, wherever it is bound
PORT = "5617"
ENVIRONMENT = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": os.environ.get("WINEPREFIX", str(BIN / "wine"))}

GZIP, ZSTD = "captures compressed by gzip", "captures compressed by zstd"
HAS = {part: f"{part}: yes" in (BIN.parent / "summary.txt").read_text().splitlines() for part in ("config", "picture", GZIP, ZSTD)}

# Debian's package of wine64 alone puts nothing on the PATH.
WINE = shutil.which("wine64") or "/usr/lib/wine/wine64"
SERVER = shutil.which("wineserver") or "/usr/lib/wine/wineserver64"


def wine(tool, *arguments):
    return [WINE, str(BIN / f"{tool}.exe"), *map(str, arguments)]


def run(tool, *arguments, stdin=None):
    return subprocess.run(wine(tool, *arguments), capture_output=True, text=True, timeout=PATIENCE_S, env=ENVIRONMENT, input=stdin,
                          stdin=subprocess.DEVNULL if stdin is None else None)


class Windows(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        ENVIRONMENT["XDG_STATE_HOME"] = cls.folder.name
        cls.log_path = pathlib.Path(cls.folder.name) / "sensor.log"
        cls.sensor = subprocess.Popen(wine("lumsim", "--port", PORT, "--lines", "64", "--rate", "2", "--duration", "3600", "--log", cls.log_path),
                                      stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                      env=ENVIRONMENT)
        end = time.monotonic() + PATIENCE_S
        while not cls.events("start"):
            if cls.sensor.poll() is not None or time.monotonic() > end:
                raise AssertionError(f"lumsim.exe does not start: {cls.sensor.stderr.read()}")
            time.sleep(0.1)

    @classmethod
    def tearDownClass(cls):
        cls.sensor.kill()
        cls.sensor.wait()
        cls.sensor.stderr.close()
        subprocess.run([SERVER, "-k"], env=ENVIRONMENT, capture_output=True)
        cls.folder.cleanup()

    @classmethod
    def events(cls, kind):
        text = cls.log_path.read_text() if cls.log_path.exists() else ""
        lines = [json.loads(line) for line in text.splitlines(True) if line.endswith("\n")]
        return [e for e in lines if e["event"] == kind]

    def wait_until(self, condition):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), end, "waited in vain")
            time.sleep(0.1)

    def ok(self, *arguments, **options):
        r = run("lumctl", "--host", ADDRESS, "--port", PORT, *arguments, **options)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        return r

    def did(self, text):
        return any(text in e.get("note", "").replace(";", " ").split() for e in self.events("tlv"))

    def test_status_of_a_sensor_that_nobody_owns_is_idle(self):
        # once heartbeats of other tests are forgotten
        self.wait_until(lambda: json.loads(self.ok("status", "--json").stdout)["idle"])

    def test_time_tells_an_offset(self):
        self.assertIn("offset_ns", json.loads(self.ok("time", "--json").stdout))

    def test_commands_are_carried_out(self):
        self.ok("power", "70")
        self.assertTrue(self.did("70p"))
        self.ok("send", "30g 40b")
        self.assertTrue(self.did("30g"))

    def test_what_was_set_is_remembered_and_can_be_applied(self):
        self.ok("threshold", "green", "33")
        shown = json.loads(self.ok("show", "--json").stdout)
        self.assertIn(("threshold green", "33"), [(s["setting"], s["value"]) for s in shown["settings"]])
        self.assertIs(shown["restarted"], False)
        saved = pathlib.Path(self.folder.name) / "saved.yaml"
        saved.write_text(self.ok("save").stdout)
        self.assertIn("green: 33", saved.read_text())

    def test_a_sensor_is_found_in_a_subnet(self):
        r = run("lumctl", "--port", PORT, "find", "--subnet", "127.0.0.0/30", "--json")
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        self.assertIn(f"{ADDRESS}:{PORT}", [s["sensor"] for s in json.loads(r.stdout)["sensors"]])

    def test_a_wrong_value_is_refused_with_status_2(self):
        r = run("lumctl", "power", "101")
        self.assertEqual(r.returncode, 2)
        self.assertIn("101", r.stderr)

    def test_silence_is_status_3(self):
        r = run("lumctl", "--host", "127.0.0.77", "--timeout", "100", "--retries", "1", "status")
        self.assertEqual(r.returncode, 3, r.stderr)

    def switch_during(self, seconds):
        """The laser on and off while heartbeats come, and a second session. Whether they came for long enough: starting
        programs takes its time on a busy machine."""
        before, changes = len(self.events("heartbeat")), len(self.events("laser"))
        beat = subprocess.Popen(wine("lumctl", "--host", ADDRESS, "--port", PORT, "heartbeat", "--duration", str(seconds)),
                                env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            self.wait_until(lambda: len(self.events("heartbeat")) > before)
            done = [run("lumctl", "--host", ADDRESS, "--port", PORT, "laser", state) for state in ("on", "off")]
            second = run("lumctl", "--host", ADDRESS, "--port", PORT, "heartbeat", "--duration", "1")
            is_enough = beat.poll() is None
        finally:
            beat.wait(PATIENCE_S)
            beat.stdout.close()
            beat.stderr.close()
        self.assertEqual(beat.returncode, 0)
        if is_enough:
            self.assertEqual([r.returncode for r in done], [0, 0], [r.stderr for r in done])
            self.assertEqual([e["up"] for e in self.events("laser")[changes:]], [True, False])
            self.assertEqual(second.returncode, 1, second.stderr)
        return is_enough

    def test_the_laser_goes_on_with_heartbeats_and_off_by_command(self):
        self.assertTrue(any(self.switch_during(seconds) for seconds in (20, 60, 180)))

    def test_the_shell_takes_commands_from_a_pipe(self):
        self.ok("shell", stdin="status\n55p\nquit\n")
        self.assertTrue(self.did("55p"))

    def test_doctor_says_what_it_cannot_look_at(self):
        r = run("lumctl", "--host", ADDRESS, "--port", PORT, "doctor", "--json")
        self.assertIn(r.returncode, (0, 4), r.stdout + r.stderr)
        self.assertTrue(json.loads(r.stdout)["checks"])

    def test_a_recording_of_a_sensor_is_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            capture, cloud = pathlib.Path(folder) / "live.pcap", pathlib.Path(folder) / "live.csv"
            r = run("lumdump", f"udp://{ADDRESS}:{PORT}", "--laser", "--json", "--duration", "4", "-o", capture, "-o", cloud)
            self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
            self.assertEqual(sorted(p.name for p in pathlib.Path(folder).iterdir()), ["live.csv", "live.pcap"])
            live, again = json.loads(r.stdout), json.loads(dump(capture, "--json").stdout)
            self.assertGreater(live["points"], 0)
            self.assertEqual([live["data"], live["points"]], [again["data"], again["points"]])
            self.assertEqual(len(cloud.read_text().splitlines()), 1 + live["points"])


def dump(*arguments):
    r = run("lumdump", *arguments)
    if r.returncode != 0:
        raise AssertionError(r.stdout + r.stderr)
    return r


def lines_of(path):
    return path.read_text().splitlines()


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.capture = cls.folder / "street.pcap"
        r = run("lumsim", "-o", cls.capture, "--frames", "2", "--lines", "64", "--seed", "3")
        if r.returncode != 0:
            raise AssertionError(r.stderr)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def tearDown(self):
        for path in self.folder.iterdir():
            if path != self.capture:
                path.unlink()

    def left(self):
        return sorted(p.name for p in self.folder.iterdir() if p != self.capture)

    def native(self, tool):
        path = os.environ.get("LUM_NATIVE_BIN")
        if path is None:
            self.skipTest("LUM_NATIVE_BIN does not name the programs of this system")
        return str(pathlib.Path(path) / tool)

    def test_every_format_is_byte_for_byte_what_other_systems_write(self):
        native = self.native("lumdump")
        endings = ["csv", "ply", "pcd", "las", "xyz"] + (["png"] if HAS["picture"] else [])
        for ending in endings:
            with self.subTest(ending):
                here, there = self.folder / f"w.{ending}", self.folder / f"n.{ending}"
                dump(self.capture, "-q", "-o", here)
                subprocess.run([native, str(self.capture), "-q", "-o", str(there)], check=True)
                self.assertEqual(here.read_bytes(), there.read_bytes())

    def test_a_capture_brings_its_calibration_where_yaml_is_read(self):
        native, known = self.native("lumdump"), self.folder / "known.pcapng"
        front = self.folder / "front.yaml"
        front.write_text("version: 1\neyes: {blue: {mount: {x_m: 7}}}\n")
        subprocess.run([native, str(self.capture), "-q", "--calibration", str(front), "-o", str(known)], check=True)
        here, there = self.folder / "w.csv", self.folder / "n.csv"
        said = dump(known, "-o", here).stderr
        subprocess.run([native, str(known if HAS["config"] else self.capture), "-q", "-o", str(there)], check=True)
        self.assertEqual(here.read_bytes(), there.read_bytes())
        self.assertEqual("its calibration cannot be read: this build reads no YAML; the built-in one is used" in said,
                         not HAS["config"], said)

    def test_the_simulator_writes_the_same_capture(self):
        other = self.folder / "native.pcap"
        subprocess.run([self.native("lumsim"), "-o", str(other), "--frames", "2", "--lines", "64", "--seed", "3"], check=True,
                       capture_output=True)
        self.assertEqual(self.capture.read_bytes(), other.read_bytes())

    def test_a_pipe_takes_what_a_file_would(self):
        dump(self.capture, "-q", "-o", self.folder / "a.csv")
        got = subprocess.run(wine("lumdump", "-q", self.capture, "-o", "-", "--format", "csv"), stdin=subprocess.DEVNULL,
                             capture_output=True, timeout=PATIENCE_S, env=ENVIRONMENT)
        self.assertEqual(got.returncode, 0, got.stderr)
        self.assertEqual(got.stdout, (self.folder / "a.csv").read_bytes())

    def test_standard_input_is_read_as_it_is(self):
        with self.capture.open("rb") as stream:
            r = subprocess.run(wine("lumdump", "-", "--json"), stdin=stream, capture_output=True, timeout=PATIENCE_S, env=ENVIRONMENT)
        self.assertEqual(json.loads(r.stdout)["points"], json.loads(dump(self.capture, "--json").stdout)["points"])

    def test_a_reader_that_leaves_ends_the_run(self):
        run_ = subprocess.Popen(wine("lumdump", "-q", self.capture, "-o", "-", "--format", "csv"), stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT)
        run_.stdout.readline()
        run_.stdout.close()
        run_.wait(PATIENCE_S)
        run_.stderr.close()
        self.assertEqual(run_.returncode, 0)

    def test_an_output_replaces_a_file_and_leaves_nothing_beside_it(self):
        cloud = self.folder / "cloud.csv"
        cloud.write_text("old")
        dump(self.capture, "-q", "-o", cloud)
        self.assertTrue(lines_of(cloud)[0].startswith("x,y,z"))
        self.assertEqual(self.left(), ["cloud.csv"])

    def test_a_run_that_fails_keeps_the_old_file_and_leaves_nothing(self):
        cloud, broken = self.folder / "cloud.csv", self.folder / "broken.pcap"
        cloud.write_text("old")
        broken.write_text("no capture")
        r = run("lumdump", broken, "-q", "-o", cloud)
        self.assertEqual(r.returncode, 1, r.stdout + r.stderr)
        self.assertEqual(cloud.read_text(), "old")
        self.assertEqual(self.left(), ["broken.pcap", "cloud.csv"])

    def test_two_runs_do_not_write_one_file(self):
        cloud = self.folder / "cloud.csv"
        first = subprocess.Popen(wine("lumdump", "-q", "-", "-o", cloud), stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, env=ENVIRONMENT)
        try:
            first.stdin.write(self.capture.read_bytes()[:1000])
            first.stdin.flush()
            end = time.monotonic() + PATIENCE_S
            while not any(name.endswith(".lumsdk") for name in self.left()) and time.monotonic() < end:
                time.sleep(0.05)
            second = run("lumdump", "-q", self.capture, "-o", cloud)
            self.assertEqual(second.returncode, 1)
            self.assertIn("another run is writing it (process ", second.stderr)
        finally:
            first.kill()
            first.wait()
            first.stdin.close()
            first.stderr.close()

    def test_what_a_killed_run_has_left_goes_with_the_next(self):
        cloud = self.folder / "cloud.csv"
        part = self.folder / "cloud.csv.0123456789ab.part"
        part.write_text("half")
        other = self.folder / "other.csv.0123456789ab.part"
        other.write_text("not ours")
        (self.folder / ".cloud.csv.lumsdk").write_text(f"lumsdk\nprocess 77\nunfinished {part.name}\n")
        dump(self.capture, "-q", "-o", cloud)
        self.assertEqual(self.left(), ["cloud.csv", other.name])

    def test_a_file_of_another_kind_in_the_marks_place_is_left_alone(self):
        foreign = self.folder / ".cloud.csv.lumsdk"
        foreign.write_text("my notes")
        r = run("lumdump", self.capture, "-q", "-o", self.folder / "cloud.csv")
        self.assertEqual(r.returncode, 1)
        self.assertIn("rename that one", r.stderr)
        self.assertEqual(foreign.read_text(), "my notes")

    def test_what_cannot_be_written_is_said(self):
        for name, said in (("none/cloud.csv", "the directory does not exist"), (".", "")):
            r = run("lumdump", self.capture, "-q", "--format", "csv", "-o", self.folder / name)
            self.assertIn(r.returncode, (1, 2))
            self.assertIn(said, r.stderr)
        same = run("lumdump", self.capture, "-q", "-o", self.capture)
        self.assertEqual(same.returncode, 2)
        self.assertIn("the source itself", same.stderr)

    def test_a_calibration_is_read_or_refused_by_name(self):
        calibration = self.folder / "calibration.yaml"
        calibration.write_text((pathlib.Path(__file__).parents[2] / "calib" / "typical.yaml").read_text())
        r = run("lumdump", self.capture, "-q", "--calibration", calibration, "-o", self.folder / "cloud.csv")
        if HAS["config"]:
            self.assertEqual(r.returncode, 0, r.stderr)
        else:
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn("no YAML", r.stderr)

    def test_a_compressed_capture_is_read_or_refused_by_name(self):
        dump(self.capture, "-q", "-o", self.folder / "whole.csv")
        for part, library, packed in ((GZIP, "zlib", self.folder / "street.pcap.gz"), (ZSTD, "libzstd", self.folder / "street.pcap.zst")):
            with self.subTest(part):
                if part == GZIP:
                    packed.write_bytes(gzip.compress(self.capture.read_bytes()))
                else:
                    subprocess.run(["zstd", "-q", str(self.capture), "-o", str(packed)], check=True)
                r = run("lumdump", packed, "-q", "-o", self.folder / "cloud.csv")
                if HAS[part]:
                    self.assertEqual(r.returncode, 0, r.stderr)
                    self.assertEqual(lines_of(self.folder / "cloud.csv"), lines_of(self.folder / "whole.csv"))
                else:
                    self.assertNotEqual(r.returncode, 0)
                    self.assertIn(f"no {library}", r.stderr)

    def test_a_picture_is_drawn_or_refused_by_name(self):
        r = run("lumdump", self.capture, "-q", "-o", self.folder / "street.png")
        if HAS["picture"]:
            self.assertEqual(r.returncode, 0, r.stderr)
        else:
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn("picture", r.stderr)


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print(f"{max(0, result.testsRun - bad - len(result.skipped))} passed, {bad} failed, {len(result.skipped)} skipped")
    sys.exit(bad > 0)
