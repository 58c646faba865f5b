#!/usr/bin/env python3
"""lumctl sweep: what --continue takes over of a folder, and what it refuses. The rest is told in tests/world."""
import json
import unittest

from live import Sensor
from support import Folder, run

ADDRESS = "127.31.5."
PLAN = """steps:
  - {lines: 64, power: 40, record: {frames: 1}}
  - {power: 50}
  - {yscan: {shape: regions, regions: {1: {min_deg: -10, max_deg: %d}, 2: {min_deg: 0, max_deg: 2}}}, record: {frames: 1}}
"""


class Sweep(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.out = self.folder / "out"
        self.plan = self.folder.write("plan.yaml", PLAN % -6)

    def start_sensor(self, last):
        return Sensor(self, self.folder, "--lines", "64", "--rate", "10", address=f"{ADDRESS}{last}")

    def sweep(self, sensor, *arguments, plan=None):
        return run("lumctl", "--host", sensor.address, "sweep", plan or self.plan, "-o", self.out, *arguments)

    def done(self, sensor, *arguments, **more):
        r = self.sweep(sensor, *arguments, **more)
        self.assertEqual(r.returncode, 0, r.stderr)
        return r

    def refused(self, why, sensor, *arguments, **more):
        before = {path.name: path.read_bytes() for path in self.out.iterdir()}
        seen = len(sensor.events("tlv"))
        r = self.sweep(sensor, *arguments, **more)
        self.assertEqual(r.returncode, 2, r.stderr)
        self.assertIn(why, r.stderr)
        self.assertEqual({path.name: path.read_bytes() for path in self.out.iterdir()}, before)
        self.assertEqual(len(sensor.events("tlv")), seen)

    def test_what_is_the_same_is_taken_over(self):
        sensor = self.start_sensor(1)
        self.done(sensor)
        self.assertIn("3 of 3 steps were done before", self.done(sensor, "--continue").stderr)
        (self.out / "step-0003.pcapng").unlink()
        self.assertIn("2 of 3 steps were done before", self.done(sensor, "--continue").stderr)
        steps = json.loads((self.out / "manifest.json").read_text())["steps"]
        self.assertEqual([step["done"] for step in steps], [True] * 3)
        self.assertEqual([step["settings"].get("power") for step in steps], ["40", "50", "50"])
        longer = self.folder.write("longer.yaml", PLAN % -6 + "  - {power: 60}\n")
        self.assertIn("3 of 4 steps were done before", self.done(sensor, "--continue", plan=longer).stderr)

    def test_what_differs_is_refused(self):
        sensor, other = self.start_sensor(2), self.start_sensor(3)
        self.done(sensor)
        self.refused("with --continue", sensor)
        why = "were done with another plan, sensor or calibration, or differ in --laser"
        self.refused(why, other, "--continue")
        self.refused(why, sensor, "--continue", "--laser")
        self.refused(why, sensor, "--continue", "--set", "eyes.blue.elevation.min_deg=-16.9")
        self.refused(why, sensor, "--continue", plan=self.folder.write("table.yaml", PLAN % -5))
        self.refused(why, sensor, "--continue", plan=self.folder.write("short.yaml", "steps:\n  - {lines: 64, power: 40, record: {frames: 1}}\n"))

    def test_a_folder_of_others_is_refused(self):
        sensor = self.start_sensor(4)
        self.done(sensor)
        manifest = self.out / "manifest.json"
        text = manifest.read_text()
        for broken in "", text[:500], text[:-3], "{}\n", json.dumps(json.loads(text)) + "\n":
            manifest.write_text(broken)
            self.refused("is damaged, or lumctl did not write it", sensor, "--continue")
        manifest.unlink()
        self.refused("recordings of steps and no manifest", sensor)

    def test_a_dry_run_shows_all_steps(self):
        r = run("lumctl", "sweep", self.plan, "--dry-run")
        self.assertEqual((r.returncode, len(r.stdout.splitlines())), (0, 3), r.stderr)
        self.assertIn("step 1 of 3, records 1 frame\n", r.stderr)
        self.assertIn("step 2 of 3\n", r.stderr)


if __name__ == "__main__":
    unittest.main()
