#!/usr/bin/env python3
"""test_program.py WORLD: what the program of the simulated world makes of its arguments, and its report."""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORLD = sys.argv.pop(1)


def world(*arguments):
    return subprocess.run([WORLD, *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True)


def without_times(text):
    """Seconds on the clock and of processors differ from run to run."""
    return re.sub(r"(simulated hours) in .*", r"\1", text)


class Program(unittest.TestCase):
    def test_more_processes_tell_the_same(self):
        one, two, three = (world("--hours", "3", "-j", n) for n in ("1", "2", "3"))
        self.assertEqual(one.returncode, 0, one.stdout)
        self.assertEqual(without_times(one.stdout), without_times(two.stdout))
        self.assertEqual(without_times(one.stdout), without_times(three.stdout))

    def test_hours_are_reached_and_not_passed_by_more_than_a_session(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "report.json"
            r = world("--hours", "2", "-j", "2", "--report", str(path))
            self.assertEqual(r.returncode, 0, r.stdout)
            report = json.loads(path.read_text())
            n = report["sessions"]
            self.assertEqual((report["first_seed"], report["last_seed"]), (1, n))
            fewer = world("--dice", "--seeds", f"1..{n - 1}", "--report", str(path))
            self.assertEqual(fewer.returncode, 0, fewer.stdout)
            self.assertLess(json.loads(path.read_text())["hours"], 2)
            self.assertGreaterEqual(report["hours"], 2)

    def test_hours_tell_all_seeds_too(self):
        r = world("--hours", "0.01", "--seeds", "5..20")
        self.assertEqual(r.returncode, 0, r.stdout)
        self.assertIn("16 sessions, seeds 5 to 20, ", r.stdout)

    def test_the_report_has_all(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "report.json"
            r = world("--dice", "--seeds", "1..40", "--report", str(path))
            report = json.loads(path.read_text())
        self.assertEqual((report["sessions"], report["failed"], report["findings"]), (40, 0, []))
        self.assertEqual(report["met"]["step:run"]["sessions"], 40)
        self.assertEqual(report["rules"]["one-fate"]["sessions"], 40)
        count = len(report["met"])
        self.assertEqual(len(report["pairs"]), count * (count - 1) // 2)
        for pair in report["pairs"]:
            a, b = (report["met"][name] for name in pair["of"])
            self.assertLessEqual(pair["near"], pair["together"])
            self.assertLessEqual(pair["together"], min(a["sessions"], b["sessions"]))
        for name, met in report["met"].items():
            self.assertRegex(r.stdout, rf"(?m)^  {name} +{met['sessions']} +{met['times']}$")

    def test_the_report_has_each_rule_of_the_documentation(self):
        text = (ROOT / "docs" / "internals" / "testing.md").read_text()
        table = text[text.index("| rules | what must hold |"):].split("\n\n")[0].splitlines()[2:]
        rules = [name for line in table for name in line.split("|")[1].strip().split(", ")]
        r = world("--dice", "--seeds", "1..2")
        told = r.stdout[r.stdout.index("rules "):r.stdout.index("rules were asked")]
        self.assertEqual(sorted(re.findall(r"(?m)^  ([\w-]+) ", told)), sorted(rules))

    def test_a_part_of_a_session_is_told(self):
        r = world("--dice", "--seed", "7", "--steps", "1,3", "--end", "20", "--trace")
        script = r.stderr[:r.stderr.index("the end")]
        self.assertEqual(re.findall(r"(?m)^ +(\d+) +[\d.]+ s  ", script), ["1", "3"])
        self.assertIn("20.000 s  the end", r.stderr)

    def test_a_trace_names_the_processes_of_a_script(self):
        r = world("--dice", "--seed", "7", "--trace")
        tools = re.findall(r"(?m)^ +\d+ +[\d.]+ s  \[(\d+)\](?: \(other\))? \$ (\w+) ", r.stderr)
        self.assertTrue(tools)
        for number, name in tools:
            self.assertRegex(r.stderr, rf"user: \[{number}\] = {name}\[\d+\]\n")

    def test_wrong_arguments(self):
        for arguments in (["--steps", "1"], ["--dice", "--steps", "1"], ["--dice", "--seed", "1", "--steps", "x"],
                          ["--dice", "--seeds", "1..2", "--end", "5"], ["--dice", "--seed", "1", "--end", "0"],
                          ["--hours", "0"], ["--hours", "x"], ["-j", "0"], ["--seeds", "3..1"], ["--story", "none_such"],
                          ["--dice", "--story", "off_at_half_loss"], ["--trace=some"], ["more"]):
            with self.subTest(arguments):
                self.assertEqual(world(*arguments).returncode, 2)

    def test_a_report_that_cannot_be_written(self):
        r = world("--dice", "--seed", "1", "--report", "/nowhere/report.json")
        self.assertEqual(r.returncode, 1)
        self.assertIn("/nowhere/report.json: ", r.stderr)


if __name__ == "__main__":
    unittest.main()
