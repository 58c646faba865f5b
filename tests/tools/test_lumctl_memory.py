#!/usr/bin/env python3
"""lumctl show and lumctl save: what is remembered of a sensor's settings, and what is said where that cannot be told."""
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import time
import unittest

import shards
from live import Sensor, wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder, run
from test_lumctl import FakeSensor, debug_tlv, status_tlv, tlv_packet

DONE, FAILED, BAD, NO_ANSWER = range(4)
ROOT = pathlib.Path(__file__).resolve().parents[2]
UTC = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z")


def clock():
    """A sensor's clock that runs as this host's does."""
    return int(time.monotonic() * 1e6) & 0xFFFFFFFF


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.state = self.folder / "state"
        self.files = self.state / "lumsdk" / "sensors"

    def ctl(self, status, address, *words, state=None):
        r = run("lumctl", "--host", address, *words, env={**os.environ, "XDG_STATE_HOME": str(state or self.state)})
        self.assertEqual(r.returncode, status, (words, r.stdout, r.stderr))
        return r

    def known(self, address, status=DONE):
        """Each setting and its value, of those that are sure."""
        shown = json.loads(self.ctl(status, address, "show", "--json").stdout)
        return {s["setting"]: s["value"] for s in shown["settings"] if s["standing"] == "done"}

    def fake(self, address, answer=None):
        """A sensor whose clock runs; answer(text, count) gives its debug text or None; False: it says nothing."""
        def reply(kind, sequence, body, count):
            if kind == 6:
                return [MAGIC + struct.pack("<III", 6, sequence, clock())]
            text = answer(body[4:].decode(errors="replace"), count) if answer else None
            if text is False:
                return []
            return [tlv_packet(sequence, status_tlv(0x0200), *([debug_tlv(text)] if text else []))]
        return FakeSensor(self, address, reply)


class Remembers(Case):
    def test_what_was_acknowledged_is_shown_with_its_time(self):
        Sensor(self, self.folder, address="127.61.0.1")
        r = self.ctl(FAILED, "127.61.0.1", "show")
        self.assertIn("nothing is known of 127.61.0.1 on lo", r.stderr)
        self.ctl(DONE, "127.61.0.1", "power", 60)
        self.ctl(DONE, "127.61.0.1", "threshold", "blue", 41)
        self.ctl(DONE, "127.61.0.1", "lines", 64)
        text = self.ctl(DONE, "127.61.0.1", "show").stdout
        self.assertIn("as far as this host knows", text)
        for row in (r"power +60 ", r"threshold blue +41 ", r"lines +64 "):
            self.assertRegex(text, row + f" +{UTC.pattern}\n")
        self.assertIn("no restart since", text)
        shown = json.loads(self.ctl(DONE, "127.61.0.1", "show", "--json").stdout)
        self.assertEqual([shown[k] for k in ("sensor", "interface", "answers", "restarted", "restart")],
                         ["127.61.0.1", "lo", True, False, None])
        self.assertLess(shown["missed"], 0.01)
        self.assertEqual([s["setting"] for s in shown["settings"]], ["lines", "power", "threshold blue"])
        self.assertTrue(all(UTC.fullmatch(s["time"]) for s in shown["settings"]))

    def test_every_way_to_set_counts(self):
        Sensor(self, self.folder, address="127.61.0.2")
        self.ctl(DONE, "127.61.0.2", "send", "50p 30g")
        self.ctl(DONE, "127.61.0.2", "tlv", "1:" + "200h 7G".encode().hex())
        self.ctl(DONE, "127.61.0.2", "yscan", 15)
        shell = subprocess.run([BIN / "lumctl", "--host", "127.61.0.2", "shell"], input=b"offset blue 9\n51p\n",
                               capture_output=True, env={**os.environ, "XDG_STATE_HOME": str(self.state)}, timeout=PATIENCE_S)
        self.assertEqual(shell.returncode, DONE, shell.stderr)
        self.assertEqual(self.known("127.61.0.2"), {"power": "51", "threshold green": "30", "holdoff": "200", "yscan": "15 degrees",
                                                    "offset green": "7", "offset blue": "9"})

    def test_the_laser_is_not_remembered_and_nothing_more_is_sent_for_it(self):
        sensor = self.fake("127.61.0.3")
        for words in (["laser", "on"], ["status"], ["send", "d"]):
            run("lumctl", "--host", "127.61.0.3", *words, env={**os.environ, "XDG_STATE_HOME": str(self.state)})
        self.assertEqual(sensor.of(6), [])
        self.assertFalse(self.files.exists())

    def test_what_was_refused_is_not_known(self):
        self.fake("127.61.0.4", lambda text, count: "refused 60p: too hot" if "60p" in text else None)
        self.ctl(DONE, "127.61.0.4", "power", 50)
        self.ctl(FAILED, "127.61.0.4", "send", "60p 20g")
        self.assertEqual(self.known("127.61.0.4"), {"power": "50", "threshold green": "20"})

    def test_a_refusal_of_something_unnamed_makes_all_of_it_unsure(self):
        self.fake("127.61.0.5", lambda text, count: "error" if "60p" in text else None)
        self.ctl(DONE, "127.61.0.5", "send", "50p 10b")
        self.ctl(FAILED, "127.61.0.5", "send", "60p 20g")
        self.assertEqual(self.known("127.61.0.5"), {"threshold blue": "10"})
        text = self.ctl(DONE, "127.61.0.5", "show").stdout
        self.assertRegex(text, r"power +60 .*whether it took effect is not known")

    def test_what_was_not_answered_is_unsure(self):
        self.fake("127.61.0.6", lambda text, count: False if "60p" in text else None)
        self.ctl(DONE, "127.61.0.6", "send", "50p 10b")
        self.ctl(NO_ANSWER, "127.61.0.6", "power", 60, "--timeout", 20)
        self.assertEqual(self.known("127.61.0.6"), {"threshold blue": "10"})
        r = self.ctl(FAILED, "127.61.0.6", "save")
        self.assertIn("# left out: power, 60", r.stdout)
        self.assertNotIn("\npower", r.stdout)
        self.assertIn("power is left out", r.stderr)

    def test_the_folder_is_that_of_posix(self):
        """Neither Windows' variable nor its separators and drives have a meaning here."""
        Sensor(self, self.folder, address="127.61.0.15")
        home = self.folder / "home"
        env = {**os.environ, "HOME": str(home), "LOCALAPPDATA": str(self.folder / "local"), "XDG_STATE_HOME": "a:b"}
        r = run("lumctl", "--host", "127.61.0.15", "power", 50, env=env, cwd=self.folder.path)
        self.assertEqual((r.returncode, r.stderr), (DONE, ""))
        self.assertTrue((home / ".local" / "state" / "lumsdk" / "sensors").is_dir())
        self.ctl(DONE, "127.61.0.15", "power", 60, state=self.folder / "c\\d")
        self.assertEqual([p for p in self.folder.path.iterdir() if p.name in ("a:b", "local", "c")], [])

    def test_why_a_folder_cannot_be_made_is_told(self):
        Sensor(self, self.folder, address="127.61.0.16")
        r = self.ctl(DONE, "127.61.0.16", "power", 50, state="/sys")
        self.assertIn("/sys/lumsdk/sensors: cannot be made: ", r.stderr)
        self.assertNotIn("No such file", r.stderr)

    def test_raw_text_that_is_not_the_manuals_makes_all_unsure(self):
        self.fake("127.61.0.7")
        self.ctl(DONE, "127.61.0.7", "send", "50p 10b")
        self.ctl(DONE, "127.61.0.7", "tlv", "1:" + "060p".encode().hex())
        self.assertEqual(self.known("127.61.0.7"), {})

    def test_nothing_is_kept_of_an_address_where_nobody_answers(self):
        self.ctl(NO_ANSWER, "127.61.0.8", "power", 60, "--timeout", 20)
        self.assertEqual([p.name for p in self.files.iterdir()] if self.files.exists() else [], [".lock"])
        FakeSensor(self, "127.61.0.8")  # has power again
        for word in ("show", "save"):
            r = self.ctl(FAILED, "127.61.0.8", word)
            self.assertIn("no record that it acknowledged a setting that lumctl of this user on this host sent", r.stderr)

    def test_a_table_is_shown_with_what_its_calibration_was(self):
        Sensor(self, self.folder, address="127.61.0.12")
        file = self.folder.write("front.yaml", "version: 1\n")
        one, other = ["--set", "eyes.blue.elevation.max_deg=2"], ["--set", "eyes.green.elevation.max_deg=1.5"]
        for words, said in (([], None), (["--calibration", file], f"with --calibration {file}"),
                            (one, "with --set eyes.blue.elevation.max_deg=2"),
                            ([*one, "--calibration", file, *other, "--set", "line_span_us=9"],
                             f"with --calibration {file} {' '.join(one + other)}")):
            with self.subTest(said):
                self.ctl(DONE, "127.61.0.12", "yscan", "--shape", "uniform", "--lines", 64, *words)
                shown = self.ctl(DONE, "127.61.0.12", "show").stdout
                saved = self.ctl(DONE, "127.61.0.12", "save").stdout
                if said is None:
                    self.assertNotIn("the table was made", shown)
                else:
                    self.assertIn(f"  the table was made {said}\n", shown)
                    self.assertIn(f"# {said}\n", saved)

    def test_a_change_of_lines_clears_a_table(self):
        Sensor(self, self.folder, "--lines", "640", address="127.61.0.9")
        self.ctl(DONE, "127.61.0.9", "yscan", "--shape", "uniform")
        self.assertEqual(self.known("127.61.0.9"), {"yscan": "uniform of 640 lines"})
        self.ctl(DONE, "127.61.0.9", "lines", 640)
        self.assertEqual(self.known("127.61.0.9"), {"lines": "640"})

    def test_a_moved_sensor_takes_it_along(self):
        Sensor(self, self.folder, address="127.61.0.10")
        self.ctl(DONE, "127.61.0.10", "power", 60)
        self.ctl(DONE, "127.61.0.10", "set-ip", "127.61.0.11")
        self.assertEqual(self.known("127.61.0.11"), {"power": "60"})
        self.assertEqual(sorted(p.name for p in self.files.iterdir()), [".lock", "127.61.0.11_5517_lo"])

    def test_two_at_once_lose_nothing(self):
        Sensor(self, self.folder, address="127.61.0.12")
        words = [["power", 61], ["threshold", "green", 31], ["threshold", "blue", 32], ["holdoff", 210], ["offset", "green", 4],
                 ["offset", "blue", 5], ["yscan", 17], ["lines", 64]]
        running = [subprocess.Popen([BIN / "lumctl", "--host", "127.61.0.12", *map(str, w)], stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL, env={**os.environ, "XDG_STATE_HOME": str(self.state)})
                   for w in words]
        for p in running:
            self.assertEqual(p.wait(PATIENCE_S), DONE)
        self.assertEqual(len(self.known("127.61.0.12")), len(words))

    def test_a_setting_that_is_done_is_the_one_that_the_sensor_took_last(self):
        sensor, environment = Sensor(self, self.folder, address="127.61.0.14"), {**os.environ, "XDG_STATE_HOME": str(self.state)}
        for i in range(12):
            running = [subprocess.Popen([BIN / "lumctl", "-q", "--host", "127.61.0.14", "power", str(n)], env=environment,
                                        stdout=subprocess.DEVNULL) for n in range(4 * i, 4 * i + 4)]
            self.assertEqual([p.wait(PATIENCE_S) for p in running], [DONE] * 4)
            [shown] = json.loads(self.ctl(DONE, "127.61.0.14", "show", "--json").stdout)["settings"]
            took = [e["note"] for e in sensor.events("tlv") if re.fullmatch(r"\d+p", e.get("note", ""))]
            self.assertTrue(shown["standing"] == "unsure" or f"{shown['value']}p" == took[-1], (shown, took[-4:]))
        self.ctl(DONE, "127.61.0.14", "power", 60)
        self.assertEqual(self.known("127.61.0.14"), {"power": "60"})

    def test_sensors_of_other_ports_are_others(self):
        Sensor(self, self.folder, "--port", "5600", address="127.61.0.13")
        Sensor(self, self.folder, address="127.61.0.13")
        self.ctl(DONE, "127.61.0.13:5600", "power", 60)
        self.assertEqual(self.known("127.61.0.13:5600"), {"power": "60"})
        self.ctl(FAILED, "127.61.0.13", "show")


class Restart(Case):
    def test_a_restart_voids_all(self):
        sensor = Sensor(self, self.folder, "--clock", "3000000000", "--fault", "reboot@USR1", address="127.61.1.1")
        self.ctl(DONE, "127.61.1.1", "power", 60)
        self.assertEqual(self.known("127.61.1.1"), {"power": "60"})
        sensor.cue(signal.SIGUSR1)
        r = self.ctl(FAILED, "127.61.1.1", "show")
        self.assertRegex(r.stderr, f"by its clock it has restarted between {UTC.pattern} and {UTC.pattern}")
        self.assertEqual(r.stdout, "")
        r = self.ctl(FAILED, "127.61.1.1", "save")
        self.assertEqual((r.stdout, r.stderr.count("restarted")), ("", 1))
        shown = json.loads(self.ctl(FAILED, "127.61.1.1", "show", "--json").stdout)
        self.assertEqual(shown["settings"], [])
        self.assertIsNotNone(shown["restart"])
        self.ctl(DONE, "127.61.1.1", "holdoff", 200)
        self.assertEqual(self.known("127.61.1.1"), {"holdoff": "200"})

    def test_a_restart_is_seen_by_the_next_command_too(self):
        sensor = Sensor(self, self.folder, "--clock", "3000000000", "--fault", "reboot@USR1", address="127.61.1.2")
        self.ctl(DONE, "127.61.1.2", "power", 60)
        sensor.cue(signal.SIGUSR1)
        r = self.ctl(DONE, "127.61.1.2", "holdoff", 200)
        self.assertIn("has restarted", r.stderr)
        self.assertEqual(self.known("127.61.1.2"), {"holdoff": "200"})

    def test_the_clocks_turn_is_no_restart(self):
        Sensor(self, self.folder, "--clock", str(2**32 - 1_000_000), address="127.61.1.3")
        self.ctl(DONE, "127.61.1.3", "power", 60)
        wait_until(lambda: json.loads(self.ctl(DONE, "127.61.1.3", "time", "--json").stdout)["clock_us"] < 2**31, "the turn")
        self.assertEqual(self.known("127.61.1.3"), {"power": "60"})

    def test_a_silent_sensor_leaves_it_open(self):
        sensor = Sensor(self, self.folder, address="127.61.1.4")
        self.ctl(DONE, "127.61.1.4", "power", 60)
        sensor.end()
        r = self.ctl(NO_ANSWER, "127.61.1.4", "show", "--timeout", 20)
        self.assertRegex(r.stdout, "power +60")
        self.assertIn("whether it has restarted since is not known", r.stdout)
        shown = json.loads(self.ctl(NO_ANSWER, "127.61.1.4", "show", "--json", "--timeout", 20).stdout)
        self.assertEqual([shown["answers"], shown["restarted"], len(shown["settings"])], [False, None, 1])
        r = self.ctl(NO_ANSWER, "127.61.1.4", "save", "--timeout", 20)
        self.assertIn("\npower: 60\n", r.stdout)

    def test_a_sensor_without_a_clock_is_not_vouched_for(self):
        answers = [False]

        def reply(kind, sequence, body, count):
            if kind == 6:
                return [MAGIC + struct.pack("<III", 6, sequence, clock())] if answers[0] else []
            return [tlv_packet(sequence, status_tlv(0x0200))]
        FakeSensor(self, "127.61.1.5", reply)
        self.ctl(DONE, "127.61.1.5", "power", 60)
        answers[0] = True
        r = self.ctl(DONE, "127.61.1.5", "show")
        self.assertRegex(r.stdout, "power +60 .*whether it has restarted since is not known")
        self.assertEqual(self.known("127.61.1.5"), {})


class Save(Case):
    def packets(self, *words):
        return run("lumctl", "--dry-run", "--sequence", 7, "-q", "apply", *words).stdout

    def round_trip(self, address, yaml):
        """Applies a file, saves, and looks whether both send the same; what was saved."""
        before = self.folder.write("before.yaml", yaml)
        self.ctl(DONE, address, "apply", before)
        saved = self.ctl(DONE, address, "save").stdout
        after = self.folder.write("after.yaml", saved)
        self.assertEqual(self.packets(after), self.packets(before))
        self.ctl(DONE, address, "apply", after)
        again = self.ctl(DONE, address, "save").stdout
        self.assertEqual(UTC.sub("", re.sub("# Its.*", "", again)), UTC.sub("", re.sub("# Its.*", "", saved)))
        return saved

    def test_what_is_saved_can_be_applied(self):
        Sensor(self, self.folder, address="127.61.2.1")
        sample = (ROOT / "calib" / "settings.yaml").read_text()
        saved = self.round_trip("127.61.2.1", sample)
        self.assertIn("# Settings of 127.61.2.1 on lo, as far as this host knows", saved)
        for yscan in ("yscan: 15", "yscan: {shape: uniform}", "yscan: {shape: uniform, min_deg: -10.000001, max_deg: 2.5}",
                      "yscan: {shape: gaussian, center_deg: -0.5, sigma_deg: 3, min_deg: -12, max_deg: 0}",
                      "yscan: {shape: regions, regions: {2: {min_deg: -2, max_deg: 2, weight: 3}, 1: {min_deg: -17, max_deg: -3}}}"):
            for lines in (640, 64):
                with self.subTest(yscan=yscan, lines=lines):
                    self.round_trip("127.61.2.1", f"version: 1\nlines: {lines}\n{yscan}\npower: 0\nholdoff: 150\n"
                                                  f"threshold: {{green: 1, blue: 100}}\noffset: {{green: 30, blue: 2}}\n")

    def test_one_eye_alone(self):
        Sensor(self, self.folder, address="127.61.2.2")
        saved = self.round_trip("127.61.2.2", "threshold: {blue: 7}\noffset: {green: 3}\n")
        self.assertIn("threshold: {blue: 7}", saved)

    def test_a_table_without_lines_says_for_which(self):
        Sensor(self, self.folder, "--lines", "64", address="127.61.2.3")
        self.ctl(DONE, "127.61.2.3", "yscan", "--shape", "uniform", "--lines", 64)
        saved = self.folder.write("saved.yaml", self.ctl(DONE, "127.61.2.3", "save").stdout)
        self.assertIn("lines: 64\n", saved.read_text())
        self.ctl(DONE, "127.61.2.3", "apply", saved)

    def test_single_elevations_are_left_out_and_that_is_said(self):
        Sensor(self, self.folder, "--lines", "640", address="127.61.2.4")
        csv = self.folder.write("rows.csv", "".join(f"{2 - i / 50}\n" for i in range(640)))
        self.ctl(DONE, "127.61.2.4", "yscan", "--shape", f"csv:{csv}")
        self.ctl(DONE, "127.61.2.4", "power", 60)
        self.assertIn(str(csv), self.ctl(DONE, "127.61.2.4", "show").stdout)
        r = self.ctl(FAILED, "127.61.2.4", "save")
        self.assertIn("# left out: yscan, a table of 640 lines", r.stdout)
        self.assertIn("yscan is left out", r.stderr)
        self.ctl(DONE, "127.61.2.4", "apply", self.folder.write("rest.yaml", r.stdout))

    def test_options_that_do_not_apply(self):
        for words in (["save", "--json"], ["show", "--dry-run"], ["save", "--dry-run"], ["show", "power"], ["save", "x.yaml"]):
            r = self.ctl(BAD, "127.61.2.5", *words)
            self.assertEqual((r.stdout, r.stderr.count("\n")), ("", 1), words)


class Files(Case):
    def setUp(self):
        super().setUp()
        self.sensor = Sensor(self, self.folder, "--lines", "640", address="127.61.3.1")
        self.ctl(DONE, "127.61.3.1", "power", 60)
        self.file = self.files / "127.61.3.1_5517_lo"

    def test_a_file_that_makes_no_sense_is_said_and_passed_over(self):
        good = self.file.read_text()
        for bad in ("", "x", "\0" * 100, good[:-5], good.replace("power", "powder"), good.replace(" 60 ", " 160 "),
                    good.replace("done", "gone"), good.replace("lumctl-state 1", "lumctl-state 2"), good.replace("127.61.3.1", "127.61.3.2"),
                    good.replace("interface lo", "interface eth0"), good + "more\n", good.replace("end\n", "power done 60 1\nend\n"),
                    good.replace("end\n", "yscan done 640 5\nscan shape\nshape gaussian 5 1 0 0\nend\n"),
                    good.replace("end\n", "scan table\nend\n"), good.replace("end\n", "region 1 2 3\n" * 17 + "end\n"), "x" * 100000):
            with self.subTest(bad=bad[:200]):
                self.file.write_text(bad)
                r = self.ctl(FAILED, "127.61.3.1", "show")
                self.assertIn("it is ignored", r.stderr)
                self.assertIn(str(self.file), r.stderr)
        self.ctl(DONE, "127.61.3.1", "holdoff", 200)
        self.assertEqual(self.known("127.61.3.1"), {"holdoff": "200"})

    def test_any_file_cut_anywhere_is_no_crash(self):
        self.ctl(DONE, "127.61.3.1", "yscan", "--shape", "regions:-2..2=3,-17..-3")
        good = self.file.read_text()
        for size in range(0, len(good), 7):
            self.file.write_text(good[:size])
            self.ctl(FAILED, "127.61.3.1", "show")

    def test_where_nothing_can_be_written_the_command_is_done_all_the_same(self):
        blocked = self.folder.write("a-file", "")
        r = self.ctl(DONE, "127.61.3.1", "power", 61, state=blocked)
        self.assertIn("is not remembered for lumctl show", r.stderr)
        self.assertEqual(self.ctl(DONE, "127.61.3.1", "-q", "power", 61, state=blocked).stderr, "")
        self.ctl(DONE, "127.61.3.1", "set-ip", "127.61.3.2", state=blocked)

    def test_without_a_home_it_is_said(self):
        environment = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_STATE_HOME")}
        r = run("lumctl", "--host", "127.61.3.1", "power", 61, env=environment)
        self.assertEqual(r.returncode, DONE)
        self.assertIn("neither XDG_STATE_HOME nor HOME", r.stderr)

    def test_the_folder_is_in_the_home_where_nothing_else_is_said(self):
        environment = {k: v for k, v in os.environ.items() if k != "XDG_STATE_HOME"}
        for state in ({}, {"XDG_STATE_HOME": "relative"}):
            home = self.folder / f"home{len(state)}"
            r = run("lumctl", "--host", "127.61.3.1", "power", 61, env={**environment, **state, "HOME": str(home)})
            self.assertEqual((r.returncode, r.stderr), (DONE, ""))
            self.assertTrue((home / ".local/state/lumsdk/sensors/127.61.3.1_5517_lo").exists())

    def test_only_the_user_can_read_it(self):
        self.assertEqual(self.file.stat().st_mode & 0o077, 0)
        self.assertEqual(sorted(p.name for p in self.files.iterdir()), [".lock", self.file.name])


if __name__ == "__main__":
    shards.main()
