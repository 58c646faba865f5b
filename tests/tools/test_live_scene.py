#!/usr/bin/env python3
"""The README's two lines, and that what they give is the scene: the points of a live sensor whose laser is warm are
those of the same frames written to a capture."""
import csv
import json
import unittest

from live import Sensor
from support import Folder, run, simulate

WARM_UP_FRAMES = 50  # 3 s at 10 frames a second, and up to 2 s until the laser is up
RUNS = 20  # until this machine is not so busy that the sensor leaves out lines, or the system drops datagrams


def frames(path):
    """Frame number -> its rows without frame and time."""
    result = {}
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            number = int(row.pop("frame"))
            row.pop("timestamp")
            result.setdefault(number, []).append(tuple(row.values()))
    return {number: sorted(rows) for number, rows in result.items()}


class Scene(unittest.TestCase):
    def test_a_live_cloud_is_the_scene(self):
        folder = Folder(self)
        for _ in range(RUNS):
            sensor = Sensor(self, folder, "--seed", "4", "--returns-max", "2", address="127.33.0.1")
            r = run("lumdump", "udp://127.33.0.1", "--laser", "--duration", "6.5", "--eye", "green", "--return", "first",
                    "--frames", f"{WARM_UP_FRAMES}:", "-o", folder / "cloud.ply", "-o", folder / "live.csv", "--json")
            self.assertEqual(r.returncode, 0, r.stderr)
            sensor.end()
            if sensor.events("stop")[-1]["lines_skipped"] + json.loads(r.stdout)["kernel_drops"] == 0:
                break
        self.assertGreater((folder / "cloud.ply").stat().st_size, 1_000_000)
        simulate(folder / "drive.pcap", "--seed", "4", "--returns-max", "2", "--frames", "10", "--lines", "64")
        self.assertEqual(run("lumdump", folder / "drive.pcap", "-q", "--eye", "green", "--return", "first", "-o", folder / "drive.csv").returncode, 0)
        live, drive = frames(folder / "live.csv"), frames(folder / "drive.csv")
        warm = sorted(live)[:-1]  # the last may be cut
        self.assertGreater(len(warm), 8)
        of_the_drive = {tuple(rows): number for number, rows in drive.items()}
        shown = [of_the_drive.get(tuple(live[n])) for n in warm]
        self.assertNotIn(None, shown)
        steps = {(b - a) % 10 for a, b in zip(shown, shown[1:])}
        self.assertEqual(steps, {1})  # in their order, again and again


if __name__ == "__main__":
    unittest.main()
