"""lumdump udp://...: a session with a sensor, lumsim's or one made by hand, on loopback addresses of this file."""
import itertools
import json
import os
import pty
import re
import resource
import select
import signal
import subprocess
import sys
import time
import unittest

import shards
from support import BIN, PATIENCE_S, Folder, limited, run, simulate, summary

ADDRESSES = (f"127.20.{8 * shards.index() + i // 250}.{i % 250 + 1}" for i in itertools.count())

LIVE_KEYS = "received kernel_drops kernel_drops_at_least ring_drops foreign_source heartbeats_sent seconds laser".split()
LIVE_ONLY = {"source", "sources", "left_out", "sensors", *LIVE_KEYS}


def warnings_in(said):
    """But for datagrams that the system dropped, since this machine is too busy."""
    return [text for text in said.splitlines() if "warning" in text and "the system dropped" not in text]


def count_rows(path):
    """Rows of a CSV, however many."""
    return path.read_bytes().count(b"\n") - 1


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.address = next(ADDRESSES)
        self.url = f"udp://{self.address}"

    def simulator(self, *arguments):
        """A lumsim that listens; its log is in sim.log."""
        log = self.folder / "sim.log"
        p = subprocess.Popen([BIN / "lumsim", "--address", self.address, "--log", log, "--quiet", "--frames", "2",
                              *map(str, arguments)], stderr=subprocess.DEVNULL)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        self.wait_for(lambda: any(e["event"] == "frames" for e in self.log()), "lumsim's start")
        return p

    def log(self):
        try:
            lines = (self.folder / "sim.log").read_text().split("\n")[:-1]
        except FileNotFoundError:
            return []
        return [json.loads(text) for text in lines]

    def events(self, kind):
        return [e for e in self.log() if e["event"] == kind]

    def laser(self):
        """Each time the laser went up or down."""
        return [e["up"] for e in self.events("laser")]

    def heard(self, note):
        """A command, once however often it was sent: a busy machine answers late."""
        return list({(e["from"], e["sequence"]): e for e in self.events("tlv") if e.get("note") == note}.values())

    def wait_for(self, condition, what):
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), deadline, f"waited in vain for {what}")
            time.sleep(0.02)

    def dump(self, *arguments, **options):
        return run("lumdump", self.url, *arguments, **options)

    def start(self, *arguments, **options):
        options.setdefault("stderr", subprocess.PIPE)
        p = subprocess.Popen([BIN / "lumdump", self.url, *map(str, arguments)], **options)
        self.addCleanup((p.stderr or options["stderr"]).close)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        return p

    def start_recording(self, *arguments, name="raw.pcap", **options):
        """A lumdump that has recorded something."""
        p = self.start(*arguments, "-o", self.folder / name, **options)
        self.wait_for_data(name)
        return p

    def wait_for_data(self, name="raw.pcap", least=100_000):
        """Until that file of a run holds so much, whether it has its name yet or not. A signal that comes before the first
        data is another matter: such a run writes nothing."""
        self.wait_for(lambda: max(self.size(n) for n in [name, *self.folder.names()] if n.startswith(name)) > least, "data")

    def wait_for_points(self, *names, least=10_000):
        """Until the laser is up, and each of those files of a run holds what came of it."""
        self.wait_for(lambda: self.laser()[-1:] == [True], "the laser")
        for name in names:
            self.wait_for_data(name, least)

    def receive_buffer(self, p):
        """Bytes that the system grants to a program's socket, as it counts them; 0: it has none."""
        sockets = subprocess.run(["ss", "-uamnpHO"], capture_output=True, text=True, check=True).stdout.splitlines()
        return next((int(re.search(r"skmem:\(r\d+,rb(\d+)", s).group(1)) for s in sockets if f"pid={p.pid}," in s), 0)

    def unread_fifo(self, name):
        """A named pipe that nobody opens."""
        path = self.folder / name
        os.mkfifo(path)
        return path

    def size(self, name):
        try:
            return (self.folder / name).stat().st_size
        except FileNotFoundError:
            return 0

    def said(self):
        """What a program whose errors go to a file has said so far."""
        return (self.folder / "said").read_text()

    def end(self, p):
        """Wait for its end; what it said."""
        with limited(p):
            said = p.stderr.read().decode()
        self.assertIsNotNone(p.wait(PATIENCE_S))
        return said

    def assert_laser_went_on_and_off(self):
        self.assertEqual(self.laser(), [True, False])
        self.assertTrue(self.heard("d"))

    def assert_no_parts(self):
        self.assertEqual([n for n in self.folder.names() if n.endswith(".part")], [])

    def assert_same_summary(self, live, recorded):
        """Unless the machine was too busy, and the recording has what was not decoded."""
        for key in recorded if live["ring_drops"] == 0 else ():
            if key not in LIVE_ONLY:
                self.assertEqual(live[key], recorded[key], key)


class Recording(Case):
    def test_the_system_holds_what_it_is_asked_to_hold(self):
        self.simulator()
        for size, granted in (("64KiB", 131072), ("100kB", 200000)):
            with self.subTest(size):
                p = self.start("--receive-buffer", size)
                self.wait_for(lambda: self.receive_buffer(p) == granted, "a socket with that buffer")
                p.send_signal(signal.SIGINT)
                self.end(p)

    def test_the_line_of_the_readme_gives_points(self):
        for _ in range(5):  # until this machine does not hold up what switches the laser on
            self.address = next(ADDRESSES)
            self.url = f"udp://{self.address}"
            (self.folder / "sim.log").unlink(missing_ok=True)
            self.simulator()
            r = self.dump("--laser", "--duration", "2", "-o", self.folder / "cloud.ply")
            self.assertEqual(r.returncode, 0, r.stderr)
            if self.laser():
                break
        header = (self.folder / "cloud.ply").read_bytes()[:4096]
        self.assertGreater(int(re.search(rb"element vertex +(\d+)", header)[1]), 10_000)
        self.assertIn("points", r.stderr)
        self.assertEqual(warnings_in(r.stderr), [])
        self.assert_laser_went_on_and_off()
        self.assert_no_parts()

    def test_several_outputs_are_filled_by_one_run(self):
        self.simulator()
        names = [self.folder / f"out.{e}" for e in "csv ply pcd las xyz png pcap".split()]
        outputs = [a for n in names for a in ("-o", n)]
        with open(self.folder / "stdout", "wb") as out:
            p = self.start("--laser", *outputs, "-o", "-", "--format", "xyz", stdout=out)
        self.wait_for_points("out.csv", "out.xyz", "out.pcap", least=100_000)
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        got = summary(self.folder / "out.pcap")
        self.assertEqual(count_rows(self.folder / "out.csv"), got["points"])
        self.assertEqual((self.folder / "out.xyz").read_bytes(), (self.folder / "stdout").read_bytes())
        self.assertGreater(got["points"], 1000)
        self.assertEqual(self.folder.names(), sorted([n.name for n in names] + ["sim.log", "stdout"]))


    def test_of_a_rig_it_is_the_sensor_that_is_chosen(self):
        self.simulator()
        rig = self.folder.write("rig.yaml", f"version: 1\nsensors:\n  - {{name: right, address: {self.address}}}\n"
                                f"  - {{name: left, address: {self.address}, interface: lo, pose: {{x_m: 900}}}}\n")
        with open(self.folder / "said.json", "wb") as out:
            p = self.start("--laser", "--rig", rig, "--sensor", "left", "--json", "-o", self.folder / "a.csv", "-o", self.folder / "%s.pcap",
                           stdout=out)
        self.wait_for_points("a.csv", "left.pcap")
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        got = json.loads((self.folder / "said.json").read_text())
        self.assertEqual([s["rig_name"] for s in got["sensors"]], ["left"])
        self.assertEqual(got["rig"] | {"file": ""}, {"file": "", "missing": [], "unnamed": []})
        self.assertEqual(count_rows(self.folder / "a.csv"), summary(self.folder / "left.pcap")["points"])
        self.assertGreater(float((self.folder / "a.csv").read_text().split("\n")[1].split(",")[0]), 600)


class Rotation(Case):
    def files(self, stem, ending):
        names = [n for n in self.folder.names() if n.startswith(stem + "-") and n.endswith(ending)]
        self.assertEqual(names, [f"{stem}-{i:04d}{ending}" for i in range(1, len(names) + 1)])
        return [self.folder / n for n in names]

    def test_of_a_capture(self):
        source = simulate(self.folder / "s.pcap", "--frames", "5", "--lines", "64", "--seed", "1")
        whole = summary(source)
        for how, least in ("1MB", 3), ("100kB", 5):
            with self.subTest(how):
                r = run("lumdump", source, "--rotate", how, "-o", self.folder / "c.csv", "-o", self.folder / "r.pcap")
                self.assertEqual(r.returncode, 0, r.stderr)
                clouds = self.files("c", ".csv")
                self.assertGreaterEqual(len(clouds), least)
                self.assertEqual(sum(count_rows(p) for p in clouds), whole["points"])
                parts = [summary(p) for p in self.files("r", ".pcap")]
                self.assertEqual(sum(p["data"] for p in parts), whole["data"])

    def test_older_files_behind_the_last_one_are_told(self):
        source = simulate(self.folder / "s.pcap", "--frames", "3", "--lines", "64", "--seed", "1")
        old = [self.folder.write(f"r-{i:04d}.pcap", "old") for i in range(1, 100)]
        r = run("lumdump", source, "--rotate", "1MB", "-o", self.folder / "r.pcap")
        self.assertEqual(r.returncode, 0, r.stderr)
        written = [p for p in old if p.read_bytes() != b"old"]
        self.assertEqual(written, old[:len(written)])
        self.assertIn(f"{old[len(written)]} and what follows are of an earlier run", r.stderr)
        self.assertIn(f"number {len(written)};", r.stderr)
        for path in old:
            path.unlink()
        self.assertNotIn("earlier", run("lumdump", source, "--rotate", "1MB", "-o", self.folder / "r.pcap").stderr)
        self.simulator()
        for path in old[1:]:
            path.write_text("old")
        r = self.dump("--duration", "0.3", "--rotate", "1h", "-o", self.folder / "r.pcap")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(f"{old[1]} and what follows are of an earlier run", r.stderr)

    def test_never_over_the_source(self):
        source = simulate(self.folder / "s-0002.pcap", "--frames", "3", "--lines", "64", "--seed", "1")
        before = source.read_bytes()
        r = run("lumdump", source, "--rotate", "100kB", "-o", self.folder / "s.pcap")
        self.assertEqual(r.returncode, 2)
        self.assertIn("which this run reads", r.stderr)
        self.assertEqual(source.read_bytes(), before)


class Several(Case):
    """Several outputs of a capture."""

    def test_each_is_as_if_it_were_alone(self):
        source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64", "--seed", "1")
        kinds = "csv ply pcd las xyz png pcap".split()
        r = run("lumdump", source, *[a for k in kinds for a in ("-o", self.folder / f"all.{k}")])
        self.assertEqual(r.returncode, 0, r.stderr)
        for kind in kinds:
            self.assertEqual(run("lumdump", source, "-o", self.folder / f"one.{kind}").returncode, 0)
            self.assertEqual((self.folder / f"all.{kind}").read_bytes(), (self.folder / f"one.{kind}").read_bytes())

    def test_a_header_with_a_count_reaches_a_pipe_beside_a_file(self):
        source = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64", "--seed", "1")
        r = run("lumdump", source, "-o", "-", "--format", "ply", "-o", self.folder / "o.csv", "-o", self.folder / "o.ply")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(r.stdout_bytes, (self.folder / "o.ply").read_bytes())

    def test_names_that_collide_or_are_too_many_are_refused(self):
        source = simulate(self.folder / "s.pcap", "--frames", "1", "--lines", "64", "--seed", "1")
        r = run("lumdump", source, "-o", self.folder / "a.csv", "-o", self.folder / "a.csv")
        self.assertEqual(r.returncode, 2)
        self.assertIn("named twice", r.stderr)
        for ending in "csv", "pcap":
            name = self.folder / f"a.{ending}"
            link = self.folder / f"link.{ending}"
            for there in False, True:
                if there:
                    name.write_text("old")
                other = f"{self.folder.path}/./a.{ending}"
                for first, second in (name, other), (other, name), (name, link), (link, name):
                    link.unlink(missing_ok=True)
                    link.symlink_to(name)
                    r = run("lumdump", source, "-o", first, "-o", second)
                    self.assertEqual(r.returncode, 2, r.stderr)
                    self.assertIn("named twice" if there or link not in (first, second) else "link to a missing file", r.stderr)
        self.assertEqual((self.folder / "a.csv").read_text(), "old")
        r = run("lumdump", source, *[a for i in range(17) for a in ("-o", self.folder / f"{i}.csv")])
        self.assertEqual(r.returncode, 2)
        self.assertIn("16", r.stderr)


class Ends(Case):
    def test_a_signal_ends_it_in_good_order(self):
        self.simulator()
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
            with self.subTest(number):
                p = self.start_recording("--laser", "-o", self.folder / "c.las", "--json", stdout=subprocess.PIPE)
                self.wait_for_points("c.las", least=100_000)
                p.send_signal(number)
                with limited(p):
                    got = json.loads(p.stdout.read())
                p.stdout.close()
                said = self.end(p)
                self.assertEqual(p.returncode, 0, said)
                self.assertEqual(self.laser()[-1], False)
                self.assert_same_summary(got, summary(self.folder / "raw.pcap"))
                self.assertGreater(self.size("c.las"), 10_000)
                self.assert_no_parts()
                for name in "raw.pcap", "c.las":
                    (self.folder / name).unlink()


class Moved(Case):
    def test_a_file_that_is_moved_away_is_told_at_once_with_its_name(self):
        self.simulator()
        p = self.start_recording("-q", "-o", self.folder / "kept.pcap", stderr=open(self.folder / "said", "w"))
        os.rename(self.folder / "raw.pcap", self.folder / "mine.pcap")
        self.wait_for(lambda: "renamed" in self.said(), "the message")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 1)
        self.assertIn(f"raw.pcap: was renamed while it was written; its data is in {self.folder / 'mine.pcap'}", self.said())
        self.assertEqual(summary(self.folder / "mine.pcap")["records"], summary(self.folder / "kept.pcap")["records"])

    def test_a_file_of_a_folder_that_is_removed_is_told_and_put_back(self):
        self.simulator()
        p = self.start("-q", "-o", self.folder / "bag", "--format", "rosbag2", "--mcap", "packets", "--json",
                       stdout=subprocess.PIPE, stderr=open(self.folder / "said", "w"))
        lost = self.folder / "bag/bag_0.mcap"
        self.wait_for(lambda: lost.exists() and lost.stat().st_size > 100_000, "the first messages")
        lost.unlink()
        self.wait_for(lambda: "bag_0.mcap: was removed" in self.said(), "the message")
        p.send_signal(signal.SIGINT)
        with limited(p):
            got = json.loads(p.stdout.read())
        p.stdout.close()
        self.assertEqual(p.wait(PATIENCE_S), 1)
        self.assertIn(f"its data was put back as {lost}", self.said())
        self.assertEqual(summary(lost)["records"], got["received"])
        self.assertTrue((self.folder / "bag/metadata.yaml").exists())


class Stalls(Case):
    def test_a_full_disk_switches_the_laser_off(self):
        self.simulator()
        for kind in "csv", "pcap", "ply":
            with self.subTest(kind), open("/dev/full", "wb") as full:
                if kind == "ply":
                    r = self.limited("-o", self.folder / "o.ply")
                    self.assertIn("File too large", r.stderr)
                    self.assertIn("the laser is off", r.stderr)
                else:
                    r = subprocess.run([BIN / "lumdump", self.url, "--laser", "-o", "-", "--format", kind], stdout=full,
                                       stderr=subprocess.PIPE, timeout=PATIENCE_S, text=True)
                    self.assertIn("No space left on device; free some space", r.stderr)
                self.assertEqual(r.returncode, 1)
                self.assertEqual(self.laser(), [True, False] * (len(self.laser()) // 2))
                self.assertTrue(self.heard("d"))
                self.assert_no_parts()
        self.assertTrue(self.laser(), "so many points need it")

    def limited(self, *arguments):
        """Files of at most 3 MB."""
        r = subprocess.run([BIN / "lumdump", self.url, "--laser", *arguments], capture_output=True, timeout=PATIENCE_S, text=True,
                           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000)))
        return r

    def test_a_capture_on_a_full_disk_holds_what_was_before(self):
        self.simulator()
        r = self.limited("-o", self.folder / "raw.pcap")
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertRegex(r.stderr, r"lumdump: \d\d:\d\d:\d\d: .*raw.pcap: .*File too large\n")
        r = run("lumdump", self.folder / "raw.pcap", "--json")
        self.assertEqual(r.returncode, 0)
        self.assertGreater(json.loads(r.stdout)["data"], 1000)
        self.assertIn(self.laser(), ([], [True, False]))  # what ends a run may be faster
        self.assertTrue(self.heard("d"))
        self.assert_no_parts()


@unittest.skipUnless(sys.platform == "linux", "slow_disk.c takes the place of calls of Linux's C library")
class SlowDisk(Case):
    """fsync() takes as long as the test likes (slow_disk.c)."""

    def begin(self, *arguments, hold=True, **environment):
        """A lumdump on such a disk, with --json."""
        self.simulator()
        self.hold = self.folder / "hold"
        if hold:
            self.hold.touch()
        library = BIN / ".." / "tests" / "tools" / "slow_disk.so"
        sanitizer = os.environ.get("ASAN_OPTIONS", "")
        environment = {**os.environ, "LD_PRELOAD": str(library.resolve()), "LUM_HOLD": str(self.hold),
                       "ASAN_OPTIONS": f"{sanitizer}:verify_asan_link_order=0", **environment}
        with open(self.folder / "summary", "wb") as out:
            p = self.start("--json", *arguments, env=environment, stdout=out, stderr=open(self.folder / "said", "wb"))
        self.addCleanup(lambda: self.hold.unlink(missing_ok=True))
        return p

    def test_a_thread_that_cannot_be_had_ends_it_though_a_pipe_waits_for_its_reader(self):
        p = self.begin("--laser", "-o", self.unread_fifo("nobody.csv"), "-o", self.folder / "raw.pcap", hold=False,
                       LUM_THREADS="1")
        self.assertEqual(p.wait(PATIENCE_S), 1, self.said())
        self.assertIn("cannot start the writing thread", self.said())
        self.assertEqual(self.laser(), [])


class Terminal(Case):
    def test_a_status_line_is_shown_on_a_terminal_alone(self):
        self.simulator()
        main, terminal = pty.openpty()
        p = subprocess.Popen([BIN / "lumdump", self.url, "--laser", "-o", self.folder / "c.csv"], stderr=terminal)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        shown = b""
        is_asked = False
        end = time.monotonic() + PATIENCE_S
        while p.poll() is None:
            self.assertLess(time.monotonic(), end, shown)
            if select.select([main], [], [], 0.1)[0]:
                shown += os.read(main, 65536)
            if b"laser up  buf" in shown and not is_asked:
                p.send_signal(signal.SIGINT)
                is_asked = True
        os.close(terminal)
        os.close(main)
        self.assertEqual(p.returncode, 0)
        lines = re.findall(rb"\r\x1b\[K([^\r\n]*)", shown)
        for text in lines:
            self.assertLess(len(text), 80)
        # all that matters fits the 80 columns of a terminal that does not tell its width
        self.assertTrue([t for t in lines if re.match(rb"\d+\.\d\d Mpt/s  lost: wire \d+w \d+l, kernel \d+, "
                                                      rb"ring \d+, bad \d+  laser up  buf \d+%", t)], lines)


class Jobs(Case):
    """What is painted again and again on a terminal: by jobs in its foreground alone."""

    def shell(self, script):
        """sh with job control at a terminal of its own; the terminal's other end."""
        pid, main = pty.fork()
        if pid == 0:
            os.execvp("sh", ["sh", "-c", f"set -m; {script}"])
        self.addCleanup(os.close, main)
        self.addCleanup(lambda: os.waitpid(pid, 0))
        self.addCleanup(lambda: os.kill(pid, signal.SIGKILL))
        return main

    def shown_until(self, main, text):
        shown = b""
        while not re.search(text, shown):
            self.assertTrue(select.select([main], [], [], PATIENCE_S)[0], shown)
            try:
                shown += os.read(main, 65536)
            except OSError:  # all have left it
                self.fail(shown)
        return shown

    def test_one_that_comes_to_the_foreground_paints(self):
        self.simulator()
        main = self.shell(f"{BIN}/lumdump {self.url} -o {self.folder / 'live.pcap'} & echo begun; read line; fg %1")
        shown = self.shown_until(main, b"begun")
        self.wait_for(lambda: self.size("live.pcap") > 500_000, "a recording")
        os.write(main, b"\n")
        shown += self.shown_until(main, b"packets/s|Mpt/s")
        self.assertNotIn(b"Mpt/s", shown[:shown.index(b"begun")])
        os.write(main, b"\x03")
        self.assertIn(b"sensor", self.shown_until(main, b"losses"))


class Arguments(Case):
    def test_each_wrong_one_is_named_with_what_is_right(self):
        for arguments, message in (
                (["udp://"], "udp://10.42.0.37"), (["udp://sensor.invalid"], "'sensor.invalid'"), (["udp://1.2.3"], "four numbers"),
                (["udp://[::1]"], "IPv4"), (["udp://::1"], "IPv4"), (["udp://:5517"], "the host is missing"),
                ([self.url, "--interface", "nosuch0"], "there is no interface nosuch0; this host has: "),
                (["x.pcap", "--sensor", "sensor.invalid"], "--sensor: 'sensor.invalid'"), (["udp://10.42.0.37:0"], "port"), (["udp://10.42.0.37:99999"], "port"),
                (["udp://10.42.0.37/x"], "udp://HOST"), (["udp://0.0.0.0"], "no sensor"),
                (["udp://224.0.0.1"], "no sensor"), (["udp://255.255.255.255"], "no sensor"),
                ([self.url, "--sensor", "10.42.0.37"], "already names one"), ([self.url, "--buffer", "1"], "256MB"),
                ([self.url, "--rotate", "1s"], "--rotate"), ([self.url, "--rotate", "5x", "-o", "a.csv"], "10min"),
                ([self.url, "--rotate", "0s", "-o", "a.csv"], "10min"),
                ([self.url, "-o", "-", "--format", "ply"], "cannot seek"),
                ([self.url, "-o", "a.csv", "-o", "b"], "--format"), (["x.pcap", "--laser"], "udp://"),
                ([self.url, "--la"], "did you mean --laser?"), ([self.url, "--dur", "1"], "--duration"),
                ([self.url, "--bu=1MB"], "did you mean --buffer?"), ([self.url, "--ver"], "did you mean --version?"),
                (["127.0.0.1"], "no such file; a sensor is named as udp://127.0.0.1\n"),
                (["udp:/127.0.0.1:55"], "udp://127.0.0.1:55\n"),
                (["x.pcap", "--interface", "lo"], "udp://"), (["x.pcap", "--buffer", "1MB"], "udp://"),
                (["x.pcap", "--receive-buffer", "1MB"], "udp://"), ([self.url, "--receive-buffer", "1"], "from 64KiB to 1GB"),
                ([self.url, "--receive-buffer", "1.1GB"], "from 64KiB to 1GB"), ([self.url, "--receive-buffer", "65535"], "from 64KiB to 1GB")):
            with self.subTest(arguments):
                r = run("lumdump", *arguments)
                self.assertEqual(r.returncode, 2, r.stderr)
                self.assertIn(message, r.stderr)

    def test_a_wrong_url_is_named(self):
        for url in ("udp://", "udp://10.42", "udp://10.42.0.37:0", "udp://10.42.0.37:x", "udp://224.0.0.1", "udp://sensor"):
            with self.subTest(url):
                r = run("lumdump", url)
                self.assertEqual(r.returncode, 2)
                self.assertIn(url, r.stderr)

    def test_an_output_that_cannot_be_is_told_before_the_laser_is_touched(self):
        self.simulator()
        r = self.dump("--laser", "-o", self.folder / "no" / "c.csv")
        self.assertEqual(r.returncode, 1)
        self.assertIn("directory does not exist", r.stderr)
        self.assertEqual(self.events("heartbeat") + self.events("tlv"), [])
        (self.folder / "d.ply").mkdir()
        self.assertIn("is a directory; name a file in it", self.dump("-o", self.folder / "d.ply").stderr)


if __name__ == "__main__":
    shards.main()
