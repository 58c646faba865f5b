#!/usr/bin/env python3
"""read_back_every.py: what lumctl --every writes, read by pandas and by the parser of prometheus_client.

Prints "N passed, N failed"; the exit status is 1 if any failed."""
import sys
import unittest

import pandas
from live import Sensor, tool, wait_until
from prometheus_client.parser import text_string_to_metric_families
from support import Folder

ADDRESS = "127.31.4.1"
TEXTS = ("sensor", "laser", "hazards", "hazards_since")


class ReadBack(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.lines, self.page = self.folder / "all.csv", self.folder / "all.prom"
        Sensor(self, self.folder, "--lines", "64", "--rate", "10", address=ADDRESS)
        watcher = tool(self, self.folder, "lumctl", "--host", ADDRESS, "status", "--every", "0.1", "--csv", self.lines)
        wait_until(lambda: self.lines.exists() and len(self.lines.read_text().splitlines()) > 3, "lines of a watcher")
        owner = tool(self, self.folder, "lumctl", "--host", ADDRESS, "heartbeat", "--laser", "--every", "0.1", "--csv", self.lines,
                     "--prometheus", self.page)
        wait_until(lambda: self.page.exists() and "lumsdk_clock_drift_ratio{" in self.page.read_text(), "a drift")
        self.told = self.page.read_text()
        self.assertEqual((watcher.end(), owner.end()), (0, 0), watcher.stderr() + owner.stderr())

    def test_pandas(self):
        table = pandas.read_csv(self.lines, parse_dates=["time"])
        self.assertEqual(str(table["time"].dt.tz), "UTC")
        self.assertEqual(set(table["sensor"]), {ADDRESS})
        self.assertLessEqual({"up", "down"}, set(table["laser"]))
        for name in table.columns.difference(("time", *TEXTS)):
            self.assertTrue(pandas.api.types.is_numeric_dtype(table[name]), name)
        self.assertTrue(table["status"].notna().all())
        self.assertTrue((table["packets"].dropna() >= 0).all())
        self.assertGreater(table["packets"].max(), 0)
        self.assertGreater(table["round_trip_ms"].max(), 0)
        self.assertLess((table["clock_error_s"]).max(), 1)

    def test_prometheus(self):
        families = {family.name: family for family in text_string_to_metric_families(self.told)}
        self.assertEqual(len(families), self.told.count("# TYPE "))
        for family in families.values():
            self.assertTrue(family.documentation, family.name)
            self.assertIn(family.type, ("gauge", "counter"))
            self.assertEqual({sample.labels["sensor"] for sample in family.samples}, {ADDRESS})
            if family.name != "lumsdk_status_bit":
                self.assertEqual(len(family.samples), 1, family.name)
        value = {name: family.samples[0].value for name, family in families.items()}
        self.assertEqual((value["lumsdk_up"], value["lumsdk_laser_up"], value["lumsdk_hazard"]), (1, 1, 0))
        self.assertEqual(families["lumsdk_packets"].type, "counter")
        self.assertGreater(value["lumsdk_packets"], 0)
        bits = {sample.labels["bit"]: sample.value for sample in families["lumsdk_status_bit"].samples}
        self.assertEqual([bit for bit, is_set in bits.items() if is_set], ["TLV_CMD_ON"])
        self.assertEqual(len(bits), 16)


if __name__ == "__main__":
    result = unittest.TextTestRunner(sys.stdout).run(unittest.defaultTestLoader.loadTestsFromTestCase(ReadBack))
    failed = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - failed} passed, {failed} failed")
    sys.exit(failed != 0)
