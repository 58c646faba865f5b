"""Which file a run may write: none that another run writes, none that it reads, none of its user's."""
import json
import os
import signal
import stat
import subprocess
import time
import unittest

import shards
from support import BIN, PATIENCE_S, Folder, limited, run, summary
from test_lumdump import two_lines

ADDRESS = "127.47.0.1"
CALIBRATION = "eyes: {blue: {mount: {x_m: 10.0, yaw_deg: 0}}}\n"
PROFILE = "version: 1\neye_values: {blue: 1, green: 0}\n"


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.addCleanup(self.kill_all)
        self.running = []

    def kill_all(self):
        for p in self.running:
            p.kill()
            for pipe in p.stdin, p.stderr:
                if pipe is not None and not pipe.closed:
                    try:
                        pipe.close()
                    except BrokenPipeError:
                        pass
            p.wait()

    def start(self, tool, *arguments, **options):
        options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, **options}
        p = subprocess.Popen([BIN / tool, *map(str, arguments)], **options)
        self.running.append(p)
        return p

    def wait_for(self, condition, what):
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"waited in vain for {what}")
            time.sleep(0.01)

    def refused(self, status, tool, *arguments, says, **options):
        r = run(tool, *arguments, **options)
        self.assertEqual(r.returncode, status, (arguments, r.stderr))
        self.assertIn(says, r.stderr, arguments)
        return r

    def is_claimed(self, name):
        """Whether a run has told that it writes a file of the name; by then it has begun."""
        try:
            return "process" in (self.folder / f".{name}.lumsdk").read_text()
        except FileNotFoundError:
            return False

    def other_names(self, path):
        """More names of one file."""
        link = path.with_name(f"link-{path.name}")
        if not link.is_symlink():
            link.symlink_to(path)
        return [path, f"{path.parent}/../{path.parent.name}/./{path.name}", link]


class Rivals(Case):
    """Two runs and one name."""

    def begin(self, name, *arguments):
        """A conversion that has begun its output, and waits for its input's end."""
        p = self.start("lumdump", "-", "-o", self.folder / name, "-q", *arguments, stdin=subprocess.PIPE)
        p.stdin.write(two_lines())
        p.stdin.flush()
        self.wait_for(lambda: self.is_claimed(name), "its output")
        return p

    def end(self, p):
        p.stdin.close()
        with limited(p):
            said = p.stderr.read().decode()
        self.assertEqual(p.wait(PATIENCE_S), 0, said)

    def test_a_second_run_of_a_name_is_refused_and_the_first_is_whole(self):
        source = self.folder.write("in.pcap", two_lines())
        for kind in "csv", "ply", "las", "png", "pcap":
            with self.subTest(kind):
                out = self.folder / f"out.{kind}"
                self.assertEqual(run("lumdump", "-", "-o", out, stdin=two_lines()).returncode, 0)
                want = out.read_bytes()  # which says that it came by standard input
                for there in True, False:
                    if not there:
                        out.unlink()
                    p = self.begin(out.name)
                    for name in self.other_names(out) if there else [out]:
                        self.refused(1, "lumdump", source, "-o", name, says=f"another run is writing it (process {p.pid})")
                    self.refused(1, "lumsim", "-o", out, "--frames", "1", "-q", says="another run is writing it")
                    self.end(p)
                    self.assertEqual(out.read_bytes(), want)
                    for n in self.folder.names():
                        if n != "in.pcap" and not (n == out.name and there):
                            (self.folder / n).unlink()
                    self.assertEqual(self.folder.names(), sorted(["in.pcap"] + [out.name] * there))
                out.unlink(missing_ok=True)

    def test_files_of_the_user_are_not_touched(self):
        source = self.folder.write("in.pcap", two_lines())
        for kind in "csv", "pcap":
            mine = self.folder.write(f"n.{kind}.part", "mine")
            self.assertEqual(run("lumdump", source, "-o", self.folder / f"n.{kind}").returncode, 0)
            self.assertEqual(mine.read_text(), "mine")
        mark = self.folder.write(".n.csv.lumsdk", "mine")
        self.refused(1, "lumdump", source, "-o", self.folder / "n.csv", says=".n.csv.lumsdk")
        self.assertEqual(mark.read_text(), "mine")

    def test_what_a_killed_run_left_goes_with_the_next(self):
        source = self.folder.write("in.pcap", two_lines())
        mine = self.folder.write("out.csv.part", "mine")
        for kind in "csv", "pcap":
            p = self.start("lumdump", "-", "-o", self.folder / f"out.{kind}", stdin=subprocess.PIPE)
            p.stdin.write(two_lines()[:24])  # outputs begin when it is known what the source says of itself
            p.stdin.flush()
            self.wait_for(lambda: any(n.startswith(f"out.{kind}.") and n != mine.name for n in self.folder.names()),
                          "its output")
            self.wait_for(lambda: "unfinished" in (self.folder / f".out.{kind}.lumsdk").read_text(), "its note")
            p.send_signal(signal.SIGKILL)
            p.wait()
            self.assertEqual(run("lumdump", source, "-o", self.folder / f"out.{kind}").returncode, 0)
        self.assertEqual(self.folder.names(), ["in.pcap", "out.csv", "out.csv.part", "out.pcap"])

    def test_names_of_which_others_are_made_are_one_runs_too(self):
        source = self.folder.write("in.pcap", two_lines())
        for name, arguments in (("f-%04d.csv", []), ("r.csv", ["--rotate", "100MB"]), ("r.pcap", ["--rotate", "100MB"])):
            with self.subTest(name):
                p = self.begin(name, *arguments)
                self.refused(1, "lumdump", source, "-o", self.folder / name, *arguments, says="another run is writing it")
                self.end(p)
                for n in self.folder.names():
                    self.assertRegex(n, r"^(in\.pcap|f-0001\.csv|r-0001\.(csv|pcap))$")
                    if n != "in.pcap":
                        (self.folder / n).unlink()

    def test_the_mode_of_what_is_replaced_stays(self):
        source = self.folder.write("in.pcap", two_lines())
        for kind in "csv", "pcap":
            old = self.folder.write(f"out.{kind}", "old")
            old.chmod(0o600)
            self.assertEqual(run("lumdump", source, "-o", old).returncode, 0)
            self.assertEqual(stat.S_IMODE(old.stat().st_mode), 0o600)

    def test_two_outputs_may_be_called_name_and_name_part(self):
        source = self.folder.write("in.pcap", two_lines())
        part = self.folder / "a.csv.part"
        r = run("lumdump", source, "-o", self.folder / "a.csv", "-o", part, "--format", "csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(part.read_bytes(), (self.folder / "a.csv").read_bytes())

    def test_a_simulation_has_its_files_alone(self):
        out, truth = self.folder / "out.pcap", self.folder / "truth.csv"
        p = self.start("lumsim", "-o", out, "--truth", truth, "--frames", "100000", "-q")
        self.wait_for(lambda: self.is_claimed(truth.name), "its outputs")
        self.refused(1, "lumsim", "-o", out, "-q", says="another run is writing it")
        self.refused(1, "lumsim", "-o", self.folder / "x.pcap", "--truth", truth, "-q", says="another run is writing it")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), -signal.SIGINT)
        self.assertEqual(self.folder.names(), [])


class Live(Case):
    def sensor(self, address, *arguments):
        log = self.folder / f"{address}.log"
        p = self.start("lumsim", "--address", address, "--log", log, "--quiet", "--frames", "1", "--lines", "64", *arguments)
        self.wait_for(lambda: log.exists() and "frames" in log.read_text(), "lumsim")
        return p, log

    def test_what_a_recording_writes_is_not_replaced(self):
        source = self.folder.write("in.pcap", two_lines())
        raw, cloud = self.folder / "raw.pcap", self.folder / "cloud.csv"
        _, log = self.sensor(ADDRESS)
        raw.write_text("old")
        raw.chmod(0o640)
        with open(self.folder / "summary.json", "w") as out:
            p = self.start("lumdump", f"udp://{ADDRESS}", "--laser", "--json", "-o", raw, "-o", cloud, stdout=out)
        self.wait_for(lambda: '"up": true' in log.read_text(), "the laser")
        before = raw.stat().st_size
        self.wait_for(lambda: raw.stat().st_size > before + 1_000_000, "data")
        self.sensor("127.47.0.2")
        hard = self.folder / "hard.pcap"
        os.link(raw, hard)
        for name in [*self.other_names(raw), hard]:
            self.refused(1, "lumdump", source, "-o", name, says="writing it")
            self.refused(1, "lumdump", "udp://127.47.0.2", "--duration", "1", "-o", name, says="writing it")
            self.refused(1, "lumsim", "-q", "-o", name, says="writing it")
        self.refused(1, "lumdump", source, "-o", cloud, says=f"another run is writing it (process {p.pid})")
        p.send_signal(signal.SIGINT)
        with limited(p):
            said = p.stderr.read().decode()
        self.assertEqual(p.wait(PATIENCE_S), 0, said)
        self.assertGreater(summary(raw)["points"], 1000)
        self.assertEqual(stat.S_IMODE(raw.stat().st_mode), 0o640)
        points = cloud.read_bytes().count(b"\n") - 1
        told = json.loads((self.folder / "summary.json").read_text())["outputs"]
        if all(output["dropped"] == 0 for output in told):  # this machine is fast enough
            self.assertEqual(points, summary(raw)["points"], told)

    def test_a_log_is_one_runs(self):
        _, log = self.sensor("127.47.0.3")
        before = log.read_text()
        self.refused(1, "lumsim", "--address", "127.47.0.4", "--log", log, "--frames", "1", "--duration", "1", "-q",
                     says="writing it")
        self.refused(1, "lumsim", "-o", log, "-q", says="writing it")
        self.assertTrue(log.read_text().startswith(before))

    def test_an_old_recording_outlives_a_run_without_a_sensor(self):
        raw = self.folder / "raw.pcap"
        raw.write_text("of yesterday")
        r = run("lumdump", "udp://127.47.0.5", "-q", "-o", raw)
        self.assertEqual(r.returncode, 3, r.stderr)
        self.assertEqual(raw.read_text(), "of yesterday")
        self.assertEqual(self.folder.names(), ["raw.pcap"])


class Inputs(Case):
    """What a run reads is not what it writes."""

    def setUp(self):
        super().setUp()
        self.source = self.folder.write("in.pcap", two_lines())
        self.calibration = self.folder.write("cal.yaml", CALIBRATION)
        self.profile = self.folder.write("profile.yaml", PROFILE)
        self.inputs = {self.source: "the source itself", self.calibration: "the calibration", self.profile: "the profile"}
        self.before = {p: p.read_bytes() for p in self.inputs}
        self.read = [self.source, "--calibration", self.calibration, "--profile", self.profile]

    def unharmed(self):
        for path, data in self.before.items():
            self.assertEqual(path.read_bytes(), data, path)
            self.assertFalse(path.is_symlink())

    def spoiling_names(self, path):
        hard = self.folder / f"hard-{path.name}"
        if not hard.exists():
            os.link(path, hard)
        return [*self.other_names(path), hard]

    def test_lumdump_writes_over_none_of_them(self):
        for path, what in self.inputs.items():
            for name in self.spoiling_names(path):
                for kind in "csv", "ply", "pcap":
                    self.refused(2, "lumdump", *self.read, "-o", name, "--format", kind, says=f"{name} is {what}")
        for path in self.calibration, self.profile:
            self.refused(2, "lumdump", "udp://127.47.0.6", *self.read[1:], "-o", path, "--format", "csv", says="this run reads")
        self.unharmed()

    def test_names_that_are_made_are_looked_at_too(self):
        made = {p: p.rename(self.folder / n) for p, n in ((self.calibration, "x-0001.csv"), (self.profile, "y-0001.csv"))}
        self.before = {made[p]: self.before[p] for p in made}
        for pattern, rotate, option, path in (("x-%04d.csv", [], "--calibration", made[self.calibration]),
                                              ("x.csv", ["--rotate", "60s"], "--calibration", made[self.calibration]),
                                              ("y-%04d.csv", [], "--profile", made[self.profile]),
                                              ("y.csv", ["--rotate", "1MB"], "--profile", made[self.profile])):
            self.refused(2, "lumdump", self.source, option, path, "-o", self.folder / pattern, *rotate, says="this run reads")
        late = self.calibration.parent / "x-0777.csv"
        made[self.calibration].rename(late)
        self.before[late] = self.before.pop(made[self.calibration])
        for source in self.source, "udp://127.47.0.6":
            self.refused(2, "lumdump", source, "--calibration", late, "-o", self.folder / "x.csv", "--rotate", "1s",
                         says="this run reads")
        self.unharmed()
        self.assertEqual(self.folder.names(), ["in.pcap", "x-0777.csv", "y-0001.csv"])

    def test_other_names_of_a_file_that_is_read_are_found_when_they_are_made(self):
        os.link(self.calibration, self.folder / "z-0001.csv")
        for pattern, rotate in (("z-%04d.csv", []), ("z.csv", ["--rotate", "60s"])):
            self.refused(1, "lumdump", self.source, "--calibration", self.calibration, "-o", self.folder / pattern, *rotate,
                         says="this run reads")
        self.unharmed()

    def appended(self, path, tool, *arguments, stdin=subprocess.DEVNULL):
        """Refused, with standard output at a file's end."""
        with open(path, "ab") as out:
            r = subprocess.run([BIN / tool, *map(str, arguments)], stdin=stdin, stdout=out, stderr=subprocess.PIPE,
                               timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 2, (arguments, r.stderr))
        self.assertIn(b"which this run reads", r.stderr)
        self.unharmed()

    def test_standard_output_leads_to_none_of_them(self):
        settings = self.folder.write("s.yaml", "power: 50\n")
        scan = self.folder.write("scan.csv", "\n".join(str(i / 100) for i in range(64)) + "\n")
        self.before |= {settings: settings.read_bytes(), scan: scan.read_bytes()}
        ctl = ["lumctl", "--dry-run"]
        for path in self.inputs:
            self.appended(path, "lumdump", *self.read)
            self.appended(path, "lumdump", *self.read, "-o", self.folder / "x.csv", "--json")
            self.appended(path, "lumdump", *self.read, "-o", "-", "--format", "csv")
        with open(self.source, "rb") as f:
            self.appended(self.source, "lumdump", "-", stdin=f)
        with open(self.calibration, "rb") as f:
            self.appended(self.calibration, "lumdump", self.source, "--calibration", "-", stdin=f)
        self.appended(settings, *ctl, "apply", settings)
        self.appended(scan, *ctl, "yscan", "--shape", f"csv:{scan}", "--lines", "64")
        self.appended(self.calibration, *ctl, "yscan", "--shape", "uniform", "--calibration", self.calibration)
        self.appended(self.profile, *ctl, "laser", "off", "--profile", self.profile)
        for option, path in (("--calibration", self.calibration), ("--profile", self.profile)):
            self.appended(path, "lumsim", "-o", "-", option, path)
            self.appended(path, "lumsim", "--log", "-", option, path)
        self.appended(self.source, "lumsim", "--replay", self.source, "--log", "-")
        if (BIN / "lumview").exists():
            for path in self.inputs:
                self.appended(path, "lumview", "--no-open", "--json", *self.read)

    def test_standard_input_is_one_of_them_at_most(self):
        settings = self.folder.write("s.yaml", "power: 50\n")
        one, both = "standard input can be read only once: ", " both name it"
        c, p, profile = "--calibration", "--profile", self.profile.read_bytes()
        commands = [("lumdump", words) for words in ([p, "-", "-"], [p, "-", self.source, "-"], [c, "-", "-"], [c, "-", p, "-", "x"])]
        commands += [("lumview", ["--no-open", *words]) for _, words in commands]
        commands += [("lumdump", [c, "-", p, "-", "udp://127.47.0.6"]), ("lumview", [c, "-", p, "-", "udp://127.47.0.6"]),
                     ("lumsim", [c, "-", p, "-", "-o", self.folder / "x.pcap"]), ("lumsim", [p, "-", "--replay", "-"]),
                     ("lumtable", [c, "-", p, "-"])]
        ctl = ["--dry-run", p, "-"]
        commands += [("lumctl", words) for words in ([*ctl, "yscan", "--shape", "uniform", c, "-"], [*ctl, "apply", "-"],
                                                     [*ctl, "yscan", "--shape", "csv:-"], [p, "-", "shell"], [c, "-", "shell"])]
        others = {"apply": "apply", "csv:-": "--shape", "shell": "the shell"}
        for tool, words in commands:
            if (BIN / tool).exists():
                with self.subTest(tool=tool, words=words):
                    named = [w for w in (c, p) if w in words]
                    other = next((others[w] for w in words if w in others), "the source")
                    first, second = named if len(named) == 2 else (named[0], other)
                    r = self.refused(2, tool, *words, says=f"{one}{first} and {second}{both}", stdin=profile)
                    self.assertEqual((r.stdout, r.stderr.count("\n")), ("", 1), r.stderr)
        self.refused(0, "lumdump", p, "-", self.source, says="", stdin=profile)
        self.refused(0, "lumctl", *ctl, "apply", settings, says="", stdin=profile)
        r = run("lumctl", "shell", "--host", "127.47.0.6", stdin=b"--dry-run yscan --shape uniform --calibration -\nquit\n")
        self.assertIn(f"{one}--calibration and the shell{both}", r.stderr)

    @unittest.skipUnless(os.path.exists("/dev/stdin"), "has no /dev/stdin")
    def test_standard_input_is_known_by_its_other_name(self):
        for words in (["--profile", "-", "/dev/stdin"], ["--calibration", "/dev/stdin", "-"]):
            self.refused(2, "lumdump", *words, says="and the source both name it", stdin=self.profile.read_bytes())

    def test_lumsim_writes_over_none_of_them(self):
        fresh = self.folder / "fresh.pcap"
        for path, option in (self.calibration, "--calibration"), (self.profile, "--profile"):
            for name in self.spoiling_names(path):
                self.refused(2, "lumsim", "-o", name, option, path, says="this run reads")
                self.refused(2, "lumsim", "-o", fresh, "--truth", name, option, path, says="this run reads")
                self.refused(2, "lumsim", "--log", name, option, path, "--address", "127.47.0.7", says="this run reads")
        for name in self.spoiling_names(self.source):
            self.refused(2, "lumsim", "--log", name, "--replay", self.source, says="this run reads")
        self.unharmed()
        self.assertFalse(fresh.exists())


if __name__ == "__main__":
    shards.main()
