#!/usr/bin/env python3
"""lumctl status and heartbeat with --every: lines, --csv, --prometheus. Read by others: read_back_every.py."""
import csv
import json
import pathlib
import re
import signal
import unittest

from live import Sensor, tool, wait_until
from support import Folder, run

FORMATS = (pathlib.Path(__file__).resolve().parents[2] / "docs/formats.md").read_text()
ADDRESS = "127.31.3."
LINES = 20


def documented(begin, end):
    """The names in backquotes in the first column of a table."""
    table = FORMATS.split(begin, 1)[1].split(end, 1)[0]
    cells = re.findall(r"^\| (`[^|]*) \|", table, re.M)
    return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Every(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def start_sensor(self, last, *arguments):
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "10", *arguments, address=f"{ADDRESS}{last}")
        return self.sensor

    def start(self, *arguments):
        return tool(self, self.folder, "lumctl", "--host", self.sensor.address, *arguments)

    def wait_for_rows(self, path, count):
        wait_until(lambda: path.exists() and len(path.read_text().splitlines()) > count, f"{count} lines")

    def test_a_line_each_time_though_nothing_changes(self):
        self.start_sensor(1)
        r = run("lumctl", "--host", self.sensor.address, "status", "--every", "0.1", "--duration", "1.05")
        self.assertEqual(r.returncode, 0, r.stderr)
        lines = r.stdout.splitlines()
        self.assertGreaterEqual(len(lines), 2)
        for line in lines:
            self.assertRegex(line, r"^\d{4}-\d\d-\d\dT[\d:.]+Z 127\.31\.3\.1: laser down, idle: HEARTBEAT_TIMEOUT, round trip ")

    def test_lines_come_more_often_than_looks(self):
        self.start_sensor(10)
        p = self.start("status", "--every", "0.1")
        wait_until(lambda: len(p.stdout().splitlines()) >= LINES, f"{LINES} lines")
        self.assertEqual(p.end(), 0)
        self.assertLess(len(self.sensor.events("tlv")), LINES / 2)  # twice a second

    def test_a_hazard_is_no_failure_of_a_plain_heartbeat(self):
        self.start_sensor(11, "--fault", "fan@USR1")
        self.sensor.cue(signal.SIGUSR1)
        for words, status in (((), 0), (("--every", "0.1"), 4), (("--until", "up"), 4)):
            p = self.start("heartbeat", *words)
            wait_until(lambda p=p: "FAN_PWM_BAD" in p.stdout(), "the hazard")
            self.assertEqual(p.end(), status, (words, p.stderr()))

    def test_silence_is_a_line_and_status_3(self):
        csv_file, page = self.folder / "silent.csv", self.folder / "silent.prom"
        r = run("lumctl", "--host", f"{ADDRESS}2", "status", "--every", "0.2", "--duration", "2.5", "--csv", csv_file, "--prometheus",
                page)
        self.assertEqual(r.returncode, 3, r.stderr)
        self.assertEqual({row["answers"] for row in rows_of(csv_file)}, {"0"})
        self.assertIn('lumsdk_up{sensor="127.31.3.2"} 0\n', page.read_text())

    def test_a_hazard_that_came_and_went(self):
        self.start_sensor(3, "--fault", "fan@USR1-USR2")
        lines = self.folder / "night.csv"
        p = self.start("status", "--every", "3600", "--csv", lines)
        wait_until(lambda: self.sensor.events("tlv"), "a look")
        self.sensor.cue(signal.SIGUSR1)
        looks = len(self.sensor.events("tlv"))
        wait_until(lambda: len(self.sensor.events("tlv")) > looks + 1, "two looks")
        self.sensor.cue(signal.SIGUSR2)
        looks = len(self.sensor.events("tlv"))
        wait_until(lambda: len(self.sensor.events("tlv")) > looks + 1, "two looks")
        self.assertEqual(p.end(), 4)
        self.assertIn("hazards that came and went: FAN_PWM_BAD", p.stderr())
        last = rows_of(lines)[-1]
        self.assertEqual(last["hazards"], "")
        self.assertIn("FAN_PWM_BAD", last["hazards_since"])

    def test_until_ends_it(self):
        self.start_sensor(4, "--fault", "fan@USR1")
        p = self.start("status", "--every", "0.1", "--until", "hazard")
        wait_until(p.stdout, "a line")
        self.sensor.cue(signal.SIGUSR1)
        self.assertEqual(p.wait(), 4)

    def test_an_owner_counts_its_data(self):
        self.start_sensor(5)
        p = self.start("heartbeat", "--laser", "--every", "0.1", "--json")
        up = wait_until(lambda: [row for row in map(json.loads, p.stdout().splitlines(True)[:-1])
                                 if row["laser"] == "up" and row["packets"] > 0 and "clock_us" in row], "an owner's line")[0]
        self.assertEqual(p.end(), 0, p.stderr())
        self.assertFalse(self.sensor.laser_is_up())
        self.assertEqual((up["lost_words"], up["kernel_drops"], up["hazards_since"]), (0, 0, ""))

    def test_two_runs_share_a_file(self):
        self.start_sensor(6)
        shared = self.folder / "shared.csv"
        runs = [self.start("status", "--every", "0.1", "--csv", shared) for _ in range(2)]
        self.wait_for_rows(shared, LINES)
        for p in runs:
            self.assertEqual(p.end(), 0, p.stderr())
        text = shared.read_text()
        self.assertTrue(text.endswith("\n"))
        self.assertEqual([line.count(",") for line in text.splitlines()], [text.splitlines()[0].count(",")] * len(text.splitlines()))
        self.assertEqual(text.count("time,sensor,"), 1)
        self.assertEqual({row["sensor"] for row in rows_of(shared)}, {self.sensor.address})

    def test_a_page_is_always_whole(self):
        self.start_sensor(7)
        page = self.folder / "lumsdk.prom"
        p = self.start("heartbeat", "--every", "0.1", "--prometheus", page)
        seen = set()

        def look():
            text = page.read_text() if page.exists() else None
            if text is not None:
                seen.add(text)
                self.assertRegex(text, r"\A# HELP lumsdk_up .*\n(?s:.*)\nlumsdk_missing_lines\{[^}]*\} \d+\n\Z")
            return len(seen) >= LINES
        wait_until(look, f"{LINES} pages")
        self.assertEqual(p.end(), 0, p.stderr())

    def test_a_file_of_others_is_refused(self):
        self.start_sensor(8)
        other = self.folder.write("other.csv", "a,b\n1,2\n")
        r = run("lumctl", "--host", self.sensor.address, "status", "--every", "1", "--csv", other)
        self.assertEqual((r.returncode, "other columns" in r.stderr, other.read_text()), (1, True, "a,b\n1,2\n"))

    def test_the_documents_have_each_column_and_metric(self):
        self.start_sensor(9, "--fault", "fan@USR1")
        lines, page = self.folder / "all.csv", self.folder / "all.prom"
        p = self.start("heartbeat", "--every", "0.1", "--csv", lines, "--prometheus", page)
        # The drift takes a second look at the clock.
        wait_until(lambda: page.exists() and "lumsdk_clock_drift_ratio{" in page.read_text(), "a drift")
        self.assertIn("\nlumsdk_hazards_total{sensor=\"127.31.3.9\"} 0\n", page.read_text())
        self.sensor.cue(signal.SIGUSR1)
        wait_until(lambda: "\nlumsdk_hazards_total{sensor=\"127.31.3.9\"} 1\n" in page.read_text(), "a hazard")
        self.assertEqual(p.end(), 4, p.stderr())
        self.assertEqual(lines.read_text().splitlines()[0].split(","), documented("`--csv` writes", "`--json` has"))
        self.assertEqual(set(re.findall(r"^# TYPE (\w+) ", page.read_text(), re.M)),
                         set(documented("`--prometheus` has", "## Elevations")))


if __name__ == "__main__":
    unittest.main()
