#!/usr/bin/env python3
"""lumdump --rotate with --keep, and the systemd unit of it: which files go and which stay, also after a kill."""
import itertools
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import unittest

from live import Process, Sensor, tool, wait_until
from support import BIN, PATIENCE_S, Folder, run, simulate, small_disk, summary

ADDRESSES = (f"127.78.0.{i}" for i in itertools.count(1))
UNIT = pathlib.Path(__file__).resolve().parents[2] / "tools" / "lumdump" / "lumdump.service.in"
VERIFIER = shutil.which("systemd-analyze")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def capture(self):
        """20 frames of 1.7 MB, 2 s."""
        return simulate(self.folder / "s.pcap", "--frames", "20", "--lines", "64", "--seed", "1")

    def numbers(self, stem="r", ending=".pcap"):
        found = [re.fullmatch(rf"{stem}-(\d+){re.escape(ending)}", n) for n in self.folder.names()]
        return sorted(int(m[1]) for m in found if m)

    def sizes(self):
        return {n: (self.folder / f"r-{n:04d}.pcap").stat().st_size for n in self.numbers()}

    def ledger(self, name="r.pcap"):
        """What is listed: a size of each whole file, None of one that was begun."""
        lines = (self.folder / f".{name}.kept.lumsdk").read_text().split("\n")
        self.assertEqual((lines[0], lines[-2:]), ("lumdump keep 1", ["end", ""]))
        words = [line.split() for line in lines[1:-2]]
        return {int(w[0]): None if w[1] == "begun" else int(w[1]) for w in words}

    def keep(self, source, *arguments):
        r = run("lumdump", source, "--rotate", "1MB", "-o", self.folder / "r.pcap", "--json", *arguments)
        self.assertEqual(r.returncode, 0, r.stderr)
        return json.loads(r.stdout)

    def assert_whole(self):
        """What is there is what is listed, and can be read to its end."""
        self.assertEqual(self.ledger(), self.sizes())
        for number in self.numbers():
            self.assertFalse(summary(self.folder / f"r-{number:04d}.pcap")["truncated"])
        self.assertEqual([n for n in self.folder.names() if n.endswith(".part") or n == ".r.pcap.lumsdk"], [])


class Replays(Case):
    def test_a_size_and_a_restart(self):
        source = self.capture()
        for run_number in 1, 2, 3:
            said = self.keep(source, "--keep", "10MB")
            top = 20 * run_number
            self.assertEqual(self.numbers()[-1], top)
            self.assertEqual(said["kept_removed"], 16 if run_number == 1 else 20)
            self.assertEqual(said["kept_stuck"], 0)
            sizes = self.sizes()
            self.assertLessEqual(sum(sizes.values()) + max(sizes.values()), 10_000_000)
            self.assert_whole()

    def test_an_age_is_of_the_data(self):
        source = self.capture()
        self.keep(source, "--keep", "1s")
        times = [summary(self.folder / f"r-{n:04d}.pcap")["duration_s"] for n in self.numbers()]
        self.assertAlmostEqual(sum(times), 1.05, delta=0.2)
        self.assert_whole()

    def test_each_kind_of_output_has_its_own(self):
        source = simulate(self.folder / "s.pcap", "--frames", "40", "--lines", "64", "--seed", "1")
        names = [self.folder / f"r.{e}" for e in "pcap ply mcap png".split()]
        for _ in range(2):
            r = run("lumdump", source, "--rotate", "1s", "--keep", "1s", *[a for n in names for a in ("-o", n)])
            self.assertEqual(r.returncode, 0, r.stderr)
        self.assertRegex(r.stderr, r"\nkeep +\d+  old files were removed\n")
        for name in names:
            there = self.numbers(ending=name.suffix)
            self.assertEqual(sorted(self.ledger(name.name)), there)
            self.assertGreaterEqual(there[0], 2)

    def test_a_summary_without_it_says_nothing_of_it(self):
        said = self.keep(self.capture())
        self.assertFalse({"kept_removed", "kept_stuck"} & set(said))
        self.assertNotIn(".r.pcap.kept.lumsdk", self.folder.names())

    def test_files_of_others_stay(self):
        source = self.capture()
        self.keep(source)  # 20 that are not listed
        before = self.sizes()
        mine = self.folder.write("r-0021.pcap", "mine")
        for _ in range(2):
            self.keep(source, "--keep", "5MB")
        self.assertEqual({n: s for n, s in self.sizes().items() if n <= 20}, before)
        self.assertEqual(mine.read_text(), "mine")
        self.assertEqual(self.numbers()[-1], 61)

    def test_what_others_changed_is_left_and_said(self):
        source = self.capture()
        self.keep(source, "--keep", "1GB")
        changed = self.folder.write("r-0003.pcap", "mine")
        r = run("lumdump", source, "--rotate", "1MB", "--keep", "5MB", "-o", self.folder / "r.pcap")
        self.assertIn("r-0003.pcap: others have changed it: --keep leaves it, and no longer counts it", r.stderr)
        self.assertEqual(changed.read_text(), "mine")
        self.assertEqual(self.numbers(), [3, 40])

    def test_a_run_without_it_takes_its_files_back(self):
        source = self.capture()
        self.keep(source, "--keep", "1GB")
        self.keep(source, "--frames", "0:4")  # over the first ones, as ever
        again = [n for n, size in self.sizes().items() if size != self.ledger()[n]]
        self.keep(source, "--keep", "5MB")
        self.assertEqual(set(again) - set(self.numbers()), set())

    def test_wrong_words_are_refused(self):
        source = self.capture()
        for arguments, says in ((["--keep", "2h"], "give that too, such as --rotate 10min"),
                                (["--keep", "2h", "--rotate", "3h"], "at least the time of a file"),
                                (["--keep", "15MB", "--rotate", "10MB"], "twice its size"),
                                (["--keep", "5x", "--rotate", "10MB"], "such as 2h or 7d"),
                                (["--keep", "0s", "--rotate", "10MB"], "such as 2h or 7d"),
                                (["--keep", "1d", "--rotate", "10MB", "--format", "rosbag2"], "rosbag2")):
            r = run("lumdump", source, "-o", self.folder / "r.pcap", *arguments)
            self.assertEqual(r.returncode, 2, r.stderr)
            self.assertIn(says, r.stderr)
        self.assertEqual(self.folder.names(), ["s.pcap"])

    def test_a_list_that_is_something_else_is_refused(self):
        source = self.capture()
        other = self.folder.write(".r.pcap.kept.lumsdk", "mine")
        r = run("lumdump", source, "--rotate", "1MB", "--keep", "5MB", "-o", self.folder / "r.pcap")
        self.assertEqual(r.returncode, 1)
        self.assertIn("which is another file", r.stderr)
        self.assertEqual(other.read_text(), "mine")
        self.assertEqual(self.numbers(), [])

    def test_a_folder_that_cannot_be_marked_is_refused(self):
        source = self.capture()
        self.keep(source, "--keep", "1GB")
        before = self.folder.names()
        as_nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        mode = self.folder.path.stat().st_mode
        self.folder.path.chmod(0o555)
        self.addCleanup(self.folder.path.chmod, mode)
        r = run("lumdump", source, "--rotate", "1MB", "--keep", "5MB", "-o", self.folder / "r.pcap", **as_nobody)
        self.assertEqual(r.returncode, 1)
        self.assertIn("r.pcap: --keep needs a folder that this user may write to", r.stderr)
        self.assertEqual(self.folder.names(), before)
        r = run("lumdump", source, "--rotate", "1MB", "--keep", "5MB", "-o", self.folder / "none" / "r.pcap")
        self.assertEqual(r.returncode, 1)
        self.assertIn("none/r.pcap: cannot create it: No such file or directory", r.stderr)


class Live(Case):
    def setUp(self):
        super().setUp()
        self.address = next(ADDRESSES)

    def sensor(self):
        return Sensor(self, self.folder, "--quiet", "--frames", "2", "--lines", "64", address=self.address)

    def recorder(self, *arguments):
        return tool(self, self.folder, "lumdump", f"udp://{self.address}", "--rotate", "1MB", "-o", self.folder / "r.pcap", *arguments)

    def wait_for(self, p, condition, what):
        wait_until(lambda: p.p.poll() is not None or condition(), what)
        self.assertIsNone(p.p.poll(), p.stderr())

    def wait_for_files(self, p, above):
        self.wait_for(p, lambda: self.numbers()[-1:] > [above], f"a file above {above}")

    def test_old_files_go_while_it_records(self):
        self.sensor()
        p = self.recorder("--keep", "10MB", "--json")
        self.wait_for_files(p, 12)
        self.assertLessEqual(len(self.numbers()), 10)
        self.assertEqual(p.end(), 0, p.stderr())
        said = json.loads(p.stdout())
        self.assertEqual(said["kept_removed"], self.numbers()[0] - 1)
        self.assert_whole()

    def test_kills_at_any_moment_lose_no_file(self):
        self.sensor()
        top = 0
        for _ in range(8):
            p = self.recorder("--keep", "10MB")
            self.wait_for_files(p, top)
            p.send(signal.SIGKILL)
            p.wait()
            top = self.numbers()[-1]
            listed = self.ledger()
            self.assertEqual(set(self.numbers()) - set(listed), set())
        mine = self.folder.write(f"r-{top + 1:04d}.pcap", "mine")
        p = self.recorder("--keep", "5MB")
        self.wait_for_files(p, top + 5)
        self.assertEqual(p.end(), 0, p.stderr())
        self.assertEqual(mine.read_text(), "mine")
        mine.unlink()
        self.assertGreater(self.numbers()[0], top)
        self.assert_whole()

    def test_a_second_recorder_of_a_name_is_refused(self):
        self.sensor()
        p = self.recorder("--keep", "10MB")
        self.wait_for_files(p, 1)
        before = self.numbers()
        source = self.capture()
        for more in (["--keep", "10MB"], []):
            r = run("lumdump", source, "--rotate", "1MB", "-o", self.folder / "r.pcap", *more)
            self.assertEqual(r.returncode, 1)
            self.assertIn("another run is writing it", r.stderr)
        self.wait_for_files(p, before[-1])
        self.assertEqual(p.end(), 0, p.stderr())
        self.assert_whole()

    def test_a_folder_that_is_full_stays_dark(self):
        disk = small_disk(self, self.folder / "disk", "8m")
        sensor = self.sensor()
        command = [f"udp://{self.address}", "--laser", "--rotate", "1MB", "--keep", "1GB", "-o", disk / "r.pcap"]

        def fill():
            r = run("lumdump", *command)
            self.assertEqual(r.returncode, 1)
            self.assertIn("No space left on device; free some space", r.stderr)
            self.assertFalse(sensor.laser_is_up())
            return sorted(os.listdir(disk))

        names = fill()
        while (more := fill()) != names:  # what a run takes back of its last file can be room for another
            names = more
        lit = len(sensor.events("laser"))
        for _ in range(3):
            self.assertEqual(fill(), names)
        self.assertEqual(len(sensor.events("laser")), lit)
        first = disk / "r-0001.pcap"
        first.unlink()
        command[command.index("1GB")] = "5MB"  # own files make room
        p = tool(self, self.folder, "lumdump", *command)
        wait_until(lambda: p.p.poll() is not None or len(sensor.events("laser")) > lit, "the laser")
        self.assertEqual(p.end(), 0, p.stderr())


class Service(Case):
    """The unit, and its line of lumdump, run as systemd would run it."""

    def setUp(self):
        super().setUp()
        self.address = next(ADDRESSES)
        text = UNIT.read_text().replace("@bindir@", str(BIN))
        self.unit = self.folder.write(f"lumdump@{self.address}.service", text)
        pairs = [line.split("=", 1) for line in text.splitlines() if "=" in line and not line.startswith("#")]
        self.settings = {key: [v for k, v in pairs if k == key] for key, _ in pairs}
        self.state = self.folder / "state"
        self.state.mkdir()

    def setting(self, key):
        [value] = self.settings[key]
        return value

    def command(self, **given):
        """ExecStart= with its %i and its variables: ${A} is in a word, $A is any number of words."""
        env = dict(word.split("=", 1) for word in shlex.split(self.setting("Environment")))
        env.update(STATE_DIRECTORY=str(self.state), **given)
        words = []
        for word in self.setting("ExecStart").replace("%i", self.address).split():
            if re.fullmatch(r"\$\w+", word):
                words += env[word[1:]].split()
            else:
                words.append(re.sub(r"\$\{(\w+)\}", lambda m: env[m[1]], word))
        self.assertNotRegex(" ".join(words), r"[%$@]")
        return words

    def start(self, **given):
        return Process(self, self.folder, *self.command(**given))

    def recorded(self):
        return sorted(p.name for p in self.state.iterdir() if re.fullmatch(r"drive-\d{4}\.pcap", p.name))

    def test_the_verifier_of_systemd_finds_nothing(self):
        if VERIFIER is None:
            self.skipTest("systemd-analyze is not installed: the unit was not verified")
        r = subprocess.run([VERIFIER, "verify", "--man=no", self.unit], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stdout + r.stderr), (0, ""))

    def test_nothing_of_it_is_enabled_and_every_end_has_its_answer(self):
        self.assertEqual(self.setting("Restart"), "always")
        self.assertEqual(self.setting("StartLimitIntervalSec"), "0")
        self.assertEqual(self.setting("RestartPreventExitStatus"), "2")
        self.assertEqual(self.setting("SuccessExitStatus"), "3")
        wrong = subprocess.run(self.command(KEEP="nonsense"), capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(wrong.returncode, 2, wrong.stderr)

    def test_boot_without_the_sensor_then_records_and_ends_at_a_signal(self):
        early = self.start()
        self.assertEqual(early.wait(), 3, early.stderr())
        self.assertEqual(list(self.state.glob("drive-*")), [])
        sensor = Sensor(self, self.folder, "--quiet", "--frames", "2", "--lines", "64", address=self.address)
        for number in 1, 2:
            p = self.start(ROTATE="1MB", KEEP="10MB")
            top = self.recorded()[-1:]
            wait_until(lambda p=p, top=top: p.p.poll() is not None or (sensor.laser_is_up() and self.recorded()[-1:] > top),
                       "a recording")
            self.assertEqual(p.end(signal.SIGTERM), 0, p.stderr())
            self.assertEqual([e["up"] for e in sensor.events("laser")], [True, False] * number)
            for name in self.recorded():
                self.assertFalse(summary(self.state / name)["truncated"])
        self.assertEqual(list(self.state.glob("*.part")), [])


if __name__ == "__main__":
    unittest.main()
