#!/usr/bin/env python3
"""wine_story.py BIN: lumctl.exe and lumsim.exe on loopback, under wine64. The last line counts: N passed, N failed."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

BIN = pathlib.Path(sys.argv.pop()).resolve()
ADDRESS = "127.0.0.1"  # under wine a socket sends from here, wherever it is bound
PORT = "5617"
ENVIRONMENT = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": os.environ.get("WINEPREFIX", str(BIN / "wine"))}


# Debian's package of wine64 alone puts nothing on the PATH.
WINE = shutil.which("wine64") or "/usr/lib/wine/wine64"
SERVER = shutil.which("wineserver") or "/usr/lib/wine/wineserver64"


def wine(tool, *arguments):
    return [WINE, str(BIN / f"{tool}.exe"), *map(str, arguments)]


def run(tool, *arguments, stdin=None):
    return subprocess.run(wine(tool, *arguments), capture_output=True, text=True, timeout=90, env=ENVIRONMENT, input=stdin,
                          stdin=subprocess.DEVNULL if stdin is None else None)


class Windows(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        ENVIRONMENT["XDG_STATE_HOME"] = cls.folder.name
        cls.log_path = pathlib.Path(cls.folder.name) / "sensor.log"
        cls.sensor = subprocess.Popen(wine("lumsim", "--port", PORT, "--lines", "64", "--rate", "2", "--duration", "150", "--log", cls.log_path),
                                      stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                      env=ENVIRONMENT)
        end = time.monotonic() + 60
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

    def ok(self, *arguments, **options):
        r = run("lumctl", "--host", ADDRESS, "--port", PORT, *arguments, **options)
        self.assertEqual(r.returncode, 0, r.stdout + r.stderr)
        return r

    def did(self, text):
        return any(text in e.get("note", "").replace(";", " ").split() for e in self.events("tlv"))

    def test_status_of_a_sensor_that_nobody_owns_is_idle(self):
        time.sleep(3.5)  # until heartbeats of other tests are forgotten
        self.assertTrue(json.loads(self.ok("status", "--json").stdout)["idle"])

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

    def test_the_laser_goes_on_with_heartbeats_and_off_by_command(self):
        before = len(self.events("heartbeat"))
        beat = subprocess.Popen(wine("lumctl", "--host", ADDRESS, "--port", PORT, "heartbeat", "--duration", "20"), env=ENVIRONMENT,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            end = time.monotonic() + 30
            while len(self.events("heartbeat")) == before and time.monotonic() < end:
                time.sleep(0.1)
            self.ok("laser", "on")
            self.assertTrue(self.events("laser")[-1]["up"])
            self.ok("laser", "off")
            self.assertFalse(self.events("laser")[-1]["up"])
            second = run("lumctl", "--host", ADDRESS, "--port", PORT, "heartbeat", "--duration", "1")
            self.assertEqual(second.returncode, 1, second.stderr)
        finally:
            beat.wait(60)
            beat.stdout.close()
            beat.stderr.close()
        self.assertEqual(beat.returncode, 0)

    def test_the_shell_takes_commands_from_a_pipe(self):
        self.ok("shell", stdin="status\n55p\nquit\n")
        self.assertTrue(self.did("55p"))

    def test_doctor_says_what_it_cannot_look_at(self):
        r = run("lumctl", "--host", ADDRESS, "--port", PORT, "doctor", "--json")
        self.assertIn(r.returncode, (0, 4), r.stdout + r.stderr)
        self.assertTrue(json.loads(r.stdout)["checks"])

    def test_files_are_refused_with_a_reason(self):
        r = run("lumsim", "-o", "x.pcap")
        self.assertEqual(r.returncode, 2)
        self.assertIn("build", r.stderr)


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print(f"{max(0, result.testsRun - bad)} passed, {bad} failed")
    sys.exit(bad > 0)
