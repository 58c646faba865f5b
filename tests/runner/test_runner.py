#!/usr/bin/env python3
"""The closing line of script/test adds what ctest and the steps say, and nothing that was planned is lost from it; what
runs for long is named meanwhile."""
import contextlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.sax.saxutils

import budget
import watch

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
import suite  # noqa: E402

TELL = pathlib.Path(__file__).parent / "tell.py"


class Tell(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.planned, self.cases = [], []

    def add(self, name, output="", status="run", message=None, step=False):
        self.plan(name, step)
        skipped = f'<skipped message="{message}"/>' if message else ""
        self.cases.append(f'<testcase name="{name}" time="1.5" status="{status}">{skipped}'
                          f"<system-out>{xml.sax.saxutils.escape(output)}</system-out></testcase>")

    def plan(self, name, step=False):
        labels = ["all", "step"] if step else ["all"]
        self.planned.append({"name": name, "properties": [{"name": "LABELS", "value": labels}]})

    def tell(self, *words, junit=True):
        planned, results = self.folder / "planned.json", self.folder / "tests.xml"
        planned.write_text(json.dumps({"tests": self.planned}))
        if junit:
            results.write_text(f"<testsuite>{''.join(self.cases)}</testsuite>")
        r = subprocess.run([sys.executable, "-B", TELL, planned, results, *words], capture_output=True, text=True, check=False)
        self.assertEqual(r.stderr, "")
        return r.returncode, r.stdout.splitlines()

    def test_a_step_counts_what_its_last_line_says_and_a_test_one(self):
        self.add("headers", "ok\n589 passed, 0 failed\n", step=True)
        self.add("doc", "", step=True)
        self.add("unit.wire", "7 passed, 0 failed\n")
        self.assertEqual(self.tell(), (0, ["ok    headers (589 passed, 2 s)", "ok    doc (1 passed, 2 s)",
                                           "ok    tests (1 passed, 2 s)", "591 passed, 0 failed"]))

    def test_builds_are_told_apart(self):
        for name in "unit.wire", "asan.unit.wire", "asan.unit.socket", "memcheck.unit.wire":
            self.add(name)
        self.assertEqual(self.tell()[1][:3], ["ok    tests (1 passed, 2 s)", "ok    tests-asan (2 passed, 3 s)",
                                              "ok    tests-memcheck (1 passed, 2 s)"])

    def test_a_failure_counts_at_least_one_and_shows_its_end(self):
        self.add("lint", "first\nlast", "fail", step=True)
        self.add("abi", "20 passed, 0 failed", "fail", step=True)
        self.add("fuzz", "10 passed, 2 failed", "fail", step=True)
        status, lines = self.tell()
        self.assertEqual((status, lines[-1]), (1, "30 passed, 4 failed"))
        self.assertIn("      last", lines)

    def test_what_did_not_run_is_told_with_its_reason(self):
        self.add("view", "lumview is left out\n", "notrun", "SKIP_RETURN_CODE=77", step=True)
        self.add("python", "not run: no scipy\n640 passed, 0 failed, 1 skipped\n", step=True)
        self.add("tools.find", "test_a (__main__.B.test_a) ... skipped 'needs root'\n")
        self.add("asan.unit.socket", "[  SKIPPED ] it_is_bound\n[  SKIPPED ] 1 test(s).\n")
        self.assertEqual(self.tell(), (0, [
            "skip  view (0 passed, 1 skipped, 2 s)", "      not run: lumview is left out",
            "ok    python (640 passed, 1 skipped, 2 s)", "      not run: no scipy",
            "ok    tests (1 passed, 2 s)", "      not run: tools.find: test_a: 'needs root'",
            "ok    tests-asan (1 passed, 2 s)", "      not run: asan.unit.socket: it_is_bound",
            "642 passed, 0 failed, 2 skipped"]))

    def test_what_ctest_could_not_begin_has_failed(self):
        self.add("asan.unit.wire", "Failed test dependencies: build-asan", "notrun", "Fixture dependency failed")
        self.plan("asan.unit.clock")
        self.assertEqual(self.tell()[1][-1], "0 passed, 2 failed")
        self.assertEqual(self.tell(junit=False)[1][-1], "0 passed, 2 failed")

    def test_where_ctest_found_nothing_that_is_a_failure(self):
        status, lines = self.tell(junit=False)
        self.assertEqual((status, lines[-1]), (1, "0 passed, 1 failed"))

    def test_setup_counts_as_a_step(self):
        log = self.folder / "setup.log"
        log.write_text("no network\n")
        self.assertEqual(self.tell(f"setup=1:{log}")[1][:2], ["FAIL  setup (0 passed, 1 failed, 0 s)", "      no network"])

    def test_steps_alone_need_no_ctest(self):
        log = self.folder / "python.log"
        log.write_text("590 passed, 0 failed\n")
        r = subprocess.run([sys.executable, "-B", TELL, "-", "-", f"python=0:{log}"], capture_output=True, text=True, check=False)
        self.assertEqual((r.returncode, r.stdout.splitlines()[-1]), (0, "590 passed, 0 failed"))


BUILD = suite.ROOT / "build" / "release"


@unittest.skipUnless((BUILD / "CTestTestfile.cmake").exists(), "there is no build")
class Rooms(unittest.TestCase):
    def test_each_test_is_that_of_a_room(self):
        """Or of the whole: an installed package, and the arrows between rooms."""
        r = subprocess.run(["ctest", "--test-dir", BUILD, "--show-only=json-v1"], check=True, capture_output=True, text=True)
        tests = json.loads(r.stdout)["tests"]
        self.assertGreater(len(tests), 100)
        self.assertEqual({t["name"] for t in tests if "LABELS" not in {p["name"] for p in t["properties"]}}, {"package", "rooms"})


class Budget(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = pathlib.Path(folder.name) / "budget.txt"
        self.file.write_text("# why\nfiles 100\nwords 9\ndesign 9\nlines 9\nfast 10.0\n")

    def hold(self, files, minutes, speed=1.0):
        out = io.StringIO()
        return budget.hold(self.file, "fast", {"files": files}, minutes * 60, speed, out), out.getvalue().splitlines()

    def test_what_is_within_passes_and_says_how_much_is_left(self):
        self.assertEqual(self.hold(100, 10.0), (0, ["ok    100 of 100 files in git", "ok    10.0 of 10.0 processor minutes",
                                                    "2 passed, 0 failed"]))

    def test_one_more_file_or_minute_fails_and_says_what_to_do(self):
        status, lines = self.hold(101, 9.0)
        self.assertEqual((status, lines[0], lines[-1]), (1, "FAIL  101 of 100 files in git", "1 passed, 1 failed"))
        self.assertIn("budget.txt", lines[1])
        self.assertEqual(self.hold(1, 10.1)[1][1], "FAIL  10.1 of 10.0 processor minutes")

    def test_sizes_are_those_of_what_git_has(self):
        top = self.file.parent
        for name, text in (("README.md", "one two"), ("docs/internals/design.md", "three\n"), ("docs/x.1", "no"), ("src/a.c", "1\n2\n")):
            (top / name).parent.mkdir(parents=True, exist_ok=True)
            (top / name).write_text(text)
        self.assertEqual(budget.sizes_of(top), {})
        subprocess.run("git init -q && git add README.md docs src", shell=True, cwd=top, check=True)
        (top / "src/b.c").write_text("not in git\n")
        self.assertEqual(budget.sizes_of(top), {"files": 4, "words": 3, "design": 1, "lines": 2})

    def test_a_slow_machine_has_more_minutes(self):
        self.assertEqual(self.hold(1, 19.9, 2.0)[1][1], "ok    19.9 of 20.0 processor minutes, as this machine took 2.0 times as long")

    def test_a_machine_is_as_slow_as_it_was_most_of_the_time(self):
        samples = self.file.with_name("samples.txt")
        for times, slow in (([1, 2, 9], 2.0), ([0.5], 1.0)):
            samples.write_text("".join(f"{budget.YARDSTICK_S * time}\n" for time in times))
            self.assertAlmostEqual(budget.slowness(samples), slow)

    def test_it_is_watched_until_the_shell_ends(self):
        samples = self.file.with_name("samples.txt")
        command = f"{sys.executable} -B {budget.__file__} watch {samples} & while [ ! -s {samples} ]; do sleep 0.01; done; kill $!; wait $!"
        self.assertEqual(subprocess.run(["sh", "-c", command], check=False).returncode, 128 + 15)
        self.assertGreaterEqual(budget.slowness(samples), 1.0)

    def test_a_line_that_is_missing_or_broken_is_an_error(self):
        self.file.write_text("files 100\nfast ten\n")
        with self.assertRaisesRegex(ValueError, "budget.txt:2"):
            self.hold(1, 1.0)
        self.file.write_text("files 100\nwords 9\ndesign 9\nlines 9\n")
        with self.assertRaisesRegex(ValueError, "no line for fast"):
            self.hold(1, 1.0)


class Suite(unittest.TestCase):
    """script/soak suite, with runs of no time."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tally = pathlib.Path(folder.name) / "soak" / "suite.json"
        self.made = []
        for name, value in ("run", self.run_one), ("commit", lambda: self.commit):
            self.addCleanup(setattr, suite, name, getattr(suite, name))
            setattr(suite, name, value)
        self.commit, self.bad = "one", False

    def run_one(self, way, folder, log):
        log.write_text("FAIL  unit.wire (0 passed, 1 failed, 0 s)\n" if self.bad else "1 passed, 0 failed\n")
        self.made.append(way)
        if len(self.made) == 3:
            raise KeyboardInterrupt
        return {"way": way, "status": int(self.bad), "seconds": 0, "failed": ["unit.wire"] if self.bad else [], "closing": ""}

    def soak(self):
        with contextlib.redirect_stdout(io.StringIO()) as self.said:
            return suite.soak(self.tally, {"quiet": 2, "busy": 2}, None)

    def test_what_was_interrupted_goes_on_and_counts_the_run_that_was_cut_again(self):
        with self.assertRaises(KeyboardInterrupt):
            self.soak()
        self.assertTrue(self.soak())
        self.assertEqual(self.made, ["quiet", "quiet", "busy", "busy", "busy"])
        self.assertIn("4 runs of one: 4 passed, 0 failed", self.said.getvalue())

    def test_a_run_that_failed_fails_all_and_its_output_is_kept(self):
        self.made, self.bad = ["", "", ""], True
        self.assertFalse(self.soak())
        self.assertIn("FAIL  unit.wire", (self.tally.parent / "failed-0.log").read_text())
        self.bad = False
        self.assertFalse(self.soak())

    def test_runs_of_another_commit_do_not_count(self):
        self.made = ["", "", ""]
        self.soak()
        self.commit = "two"
        self.soak()
        self.assertEqual(len(self.made), 3 + 8)

    def test_what_cannot_be_counted_is_refused(self):
        with self.assertRaisesRegex(SystemExit, "three numbers"):
            suite.parse("10,x,2")
        self.commit = "one-dirty"
        with self.assertRaisesRegex(SystemExit, "commit first"):
            self.soak()

    def test_other_programs_run_beside_and_end(self):
        def children():
            count = 0
            for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
                with contextlib.suppress(OSError):  # it has ended
                    count += stat.read_text().rpartition(")")[2].split()[1] == str(os.getpid())
            return count
        before = children()
        with suite.busy(self.tally.parent.parent):
            self.assertEqual(children(), before + suite.COMPUTING + suite.WRITING)
        self.assertEqual(children(), before)


class Watch(unittest.TestCase):
    def watch(self, *events):
        """events: a line, or the seconds that pass until the next."""
        now_s = 0.0

        def lines():
            nonlocal now_s
            for event in events:
                if isinstance(event, str):
                    yield event + "\n"
                else:
                    now_s += event
                    yield None
        out = io.StringIO()
        watch.watch(lines(), out, 300.0, lambda: now_s)
        return [line for line in out.getvalue().splitlines() if line not in events]

    def test_what_runs_for_long_is_named_with_its_time(self):
        self.assertEqual(self.watch("      Start  7: python-ray", "      Start 12: unit.wire", 200,
                                    " 1/3 Test #12: unit.wire ....   Passed    0.02 sec", "      Start 13: view", 200, 400),
                         ["still running: python-ray (7 min)", "still running: python-ray (13 min), view (10 min)"])

    def test_what_has_ended_in_any_way_is_not_named(self):
        self.assertEqual(self.watch("      Start 1: a", "      Start 2: b", "1/2 Test #1: a ...***Failed  1.0 sec",
                                    "2/2 Test  #2: b ...***Timeout  9.0 sec", 1000, 1000), [])

    def test_lines_pass_as_they_come(self):
        read, write = os.pipe()
        lines = watch.lines_of(open(read, "rb", buffering=0), 0.01)
        os.write(write, b"one\ntw")
        self.assertEqual([next(lines), next(lines)], ["one\n", None])
        os.write(write, b"o\nend")
        os.close(write)
        self.assertEqual(list(lines), ["two\n", "end"])


if __name__ == "__main__":
    unittest.main()
