#!/usr/bin/env python3
"""examples/bench/thresholds.sh: whole, and killed at moments that its files and the sensor's log show."""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time
import unittest

from live import Sensor, wait_until
from support import BIN, Folder, run

TOP = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = TOP / "examples/bench/thresholds.sh"
PLAN = """steps:
  - {lines: 64, power: 40, threshold: {green: 20, blue: 20}, record: {frames: 3}}
  - {threshold: {green: 40, blue: 40}, settle: 0.2, record: {frames: 3}}
  - {power: 80, threshold: {green: 20, blue: 20}, settle: 0.2, record: {frames: 3}}
  - {threshold: {green: 40, blue: 40}, settle: 0.2, record: {frames: 3}}
  - {record: {frames: 3}}
"""
ENDLESS = PLAN.replace("{record: {frames: 3}}", "{record: 3600}")  # no moment can be missed: it runs until it is killed
STEPS = 5
OFF_S = 3.2  # the laser is off, after the last heartbeat
ADDRESS = "127.31.1."


def lumctls(folder):
    """Those that run and were given this folder."""
    found = []
    for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:
            continue  # it has just ended
        if os.path.basename(words[0]) == b"lumctl" and bytes(folder) in words:
            found.append(int(path.parent.name))
    return found


@unittest.skipUnless(shutil.which("setpriv"), "setpriv is missing, which Linux has")
class Bench(unittest.TestCase):
    def prepare(self, last, *arguments):
        self.folder = Folder(self)
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "10", *arguments, address=f"{ADDRESS}{last}")
        self.plan = self.folder.write("plan.yaml", PLAN)
        self.out = self.folder / "out"

    def start(self, **more):
        environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", "LUM_HOST": self.sensor.address, **more}
        with open(self.folder / "told", "ab") as told:
            p = subprocess.Popen([SCRIPT, self.out, self.plan], env=environment, stdin=subprocess.DEVNULL, stdout=told, stderr=told,
                                 start_new_session=True)
        self.addCleanup(self.end_all_of, p)
        return p

    @staticmethod
    def end_all_of(p):
        try:
            os.killpg(p.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        p.wait()

    def to_the_end(self, status=0, **more):
        p = self.start(**more)
        self.assertEqual(p.wait(), status, (self.folder / "told").read_text())

    # What is to be seen.

    def steps(self):
        path = self.out / "manifest.json"
        return json.loads(path.read_text())["steps"] if path.exists() else []

    def done(self):
        return [step for step in self.steps() if step["done"]]

    def parts(self, step):
        return list(self.out.glob(f"step-{step:04d}.pcapng.*.part"))

    def named(self):
        return sorted(path for path in self.out.iterdir() if not path.name.startswith(".") and path.suffix != ".part")

    def identities(self):
        return {path.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in self.named() if path.name != "manifest.json"}

    def check_files(self):
        """Each that has a name is whole, and the manifest knows what is done."""
        for path in self.named():
            if path.suffix == ".ply":
                head, body = path.read_bytes().split(b"end_header\n", 1)
                self.assertEqual(len(body), 52 * int(re.search(rb"element vertex (\d+)", head)[1]), path)
            elif path.suffix == ".pcapng":
                r = run("lumdump", path, "--json")
                self.assertEqual(r.returncode, 0, r.stderr)
            else:
                self.assertEqual(path.name, "manifest.json")
        for step in self.done():
            told = json.loads(run("lumdump", self.out / step["file"], "--json").stdout)
            # Where packets were lost, a frame's begin may be among them: then there is another one.
            self.assertGreaterEqual(told["sensors"][0]["frames"], 3, step)
            self.assertEqual(told["records"], step["packets"], step)

    def check_whole(self):
        self.assertEqual(len(self.done()), STEPS)
        self.assertEqual(sorted(path.name for path in self.out.iterdir() if path.suffix != ".lumsdk"),
                         ["manifest.json"] + [f"step-{n:04d}.{end}" for n in range(1, STEPS + 1) for end in ("pcapng", "ply")])
        self.check_files()

    def wait_until_off(self):
        wait_until(lambda: not self.sensor.laser_is_up(), "the end of the laser")
        off = self.sensor.events("laser")[-1]["t"]
        self.assertLessEqual(off - self.sensor.events("heartbeat")[-1]["t"], OFF_S)

    def kill_when(self, is_so, target, number):
        p = self.start()
        wait_until(lambda: is_so() or p.poll() is not None, "the moment")
        self.assertIsNone(p.poll(), (self.folder / "told").read_text())
        if target == "lumctl":
            os.kill(wait_until(lambda: lumctls(self.out), "lumctl")[0], number)
        elif target == "all":
            os.killpg(p.pid, number)
        else:
            p.send_signal(number)
        at = time.monotonic()
        self.assertNotEqual(p.wait(), 0)
        self.wait_until_off()
        self.assertLessEqual(self.sensor.events("laser")[-1]["t"] - at, OFF_S)
        wait_until(lambda: not lumctls(self.out), "the end of lumctl")
        self.check_files()

    # The facts.

    def test_whole_and_again(self):
        self.prepare(1)
        self.to_the_end()
        self.check_whole()
        self.assertFalse(self.sensor.laser_is_up())
        self.assertEqual(len([e for e in self.sensor.events("laser") if e["up"]]), 1)  # one session for all steps
        before = self.identities()
        self.to_the_end()
        self.assertEqual(self.identities(), before)
        self.assertFalse(self.sensor.laser_is_up())
        (self.out / "step-0002.ply").unlink()
        self.to_the_end()
        after = self.identities()
        self.assertEqual({name: after[name] for name in after if name != "step-0002.ply"},
                         {name: before[name] for name in before if name != "step-0002.ply"})
        self.check_whole()

    def test_thresholds_at_two_powers(self):
        """The sample plan, with fewer lines."""
        self.folder = Folder(self)
        self.sensor = Sensor(self, self.folder, "--rate", "0.5", address=f"{ADDRESS}5")
        sample = (TOP / "calib/sweep.yaml").read_text()
        self.plan = self.folder.write("plan.yaml", sample.replace("lines: 640", "lines: 64").replace("settle: 1", "settle: 0.1"))
        self.out = self.folder / "out"
        self.to_the_end()
        steps = self.done()
        self.assertEqual([(step["settings"]["power"], step["settings"]["threshold green"], step["settings"]["threshold blue"])
                          for step in steps], [(power, t, t) for power in ("40", "80") for t in ("20", "40", "60", "80")])
        for step in steps:
            self.assertGreater((self.out / step["file"]).with_suffix(".ply").stat().st_size, 10000, step)
        self.assertFalse(self.sensor.laser_is_up())

    def test_killed_at_any_moment_and_run_again(self):
        self.prepare(2)
        self.plan.write_text(ENDLESS)
        moments = ((lambda: self.sensor.laser_is_up() and self.parts(1), "lumctl", signal.SIGKILL),
                   (lambda: len(self.done()) >= 1, "shell", signal.SIGTERM),
                   (lambda: len(self.done()) >= 1 and any(map(self.parts, range(2, STEPS + 1))), "shell", signal.SIGKILL),
                   (lambda: len(self.done()) >= 2, "all", signal.SIGINT),
                   (lambda: len(self.done()) >= 3 and self.sensor.laser_is_up(), "lumctl", signal.SIGKILL))
        kept = {}
        for is_so, target, number in moments:
            with self.subTest(f"{number.name} {target}, {len(self.done())} done"):
                self.kill_when(is_so, target, number)
                now = self.identities()
                self.assertEqual({name: now[name] for name in kept}, kept)
                kept = {step["file"]: now[step["file"]] for step in self.done()}
        self.assertGreaterEqual(len(kept), 3)
        self.plan.write_text(PLAN)
        self.to_the_end()
        now = self.identities()
        self.assertEqual({name: now[name] for name in kept}, kept)
        self.check_whole()

    def test_killed_between_clouds(self):
        self.prepare(3)
        p = self.start()
        wait_until(lambda: (self.out / "step-0001.ply").exists() or p.poll() is not None, "a cloud")
        os.killpg(p.pid, signal.SIGKILL)
        p.wait()
        self.assertFalse(self.sensor.laser_is_up())
        self.check_files()
        before = self.identities()
        self.to_the_end()
        now = self.identities()
        self.assertEqual({name: now[name] for name in before}, before)
        self.check_whole()

    def test_a_hazard_raises_the_alarm(self):
        self.prepare(4, "--fault", "interlock@USR1-USR2")
        alarm = self.folder.write("alarm", '#!/bin/sh\necho "$1" >>"$0.told"\n')
        alarm.chmod(0o755)
        p = self.start(ALARM=str(alarm))
        wait_until(lambda: len(self.done()) == 1 or p.poll() is not None, "a step")
        self.sensor.cue(signal.SIGUSR1)
        self.assertEqual(p.wait(), 4)
        self.wait_until_off()
        self.assertIn("hazard", (self.folder / "alarm.told").read_text())
        manifest = json.loads((self.out / "manifest.json").read_text())
        self.assertEqual(manifest["exit_status"], 4)
        self.assertIn("HW_SAFETY_BAD", manifest["why"])
        self.check_files()
        self.sensor.cue(signal.SIGUSR2)
        self.assertFalse(self.sensor.laser_is_up())  # it does not come on again by itself
        self.to_the_end()
        self.check_whole()


class Documents(unittest.TestCase):
    def test_the_guide_names_the_script(self):
        self.assertLessEqual(len(SCRIPT.read_text().splitlines()), 20)
        self.assertIn(f"(../{SCRIPT.relative_to(TOP)})", (TOP / "docs/record.md").read_text())

    def test_its_plan_is_the_sample(self):
        self.assertIn("/../../calib/sweep.yaml", SCRIPT.read_text())
        r = run("lumctl", "sweep", TOP / "calib/sweep.yaml", "--dry-run")
        self.assertEqual((r.returncode, len(re.findall(r"step \d of 8, records 5 s", r.stderr))), (0, 8), r.stderr)


if __name__ == "__main__":
    unittest.main()
