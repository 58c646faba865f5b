"""lumdump udp://...: a session with a sensor, lumsim's or one made by hand, on loopback addresses of this file."""
import fcntl
import itertools
import json
import os
import pty
import re
import resource
import select
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import time
import unittest

import shards
from support import BIN, PATIENCE_S, Folder, frames_of, ip, line, read_csv, run, signal_and_see, simulate, summary, word

ADDRESSES = (f"127.20.{8 * shards.index() + i // 250}.{i % 250 + 1}" for i in itertools.count())

LIVE_KEYS = "received kernel_drops ring_drops foreign_source heartbeats_sent seconds laser".split()
HALF_A_PIPE = 32768  # bytes
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

    def sensor(self, refusals=0, lines=1_000_000):
        sensor = Handmade(self.address, refusals, lines)
        sensor.start()
        self.addCleanup(sensor.join)
        self.addCleanup(setattr, sensor, "ends", True)
        return sensor

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

    def wait_for_laser(self):
        """That is up, and that the program has heard of."""
        self.wait_for(lambda: self.laser()[-1:] == [True], "the laser")
        self.wait_for_heartbeats()

    def wait_for_points(self, *names, least=10_000):
        """Until the laser is up, and each of those files of a run holds what came of it."""
        self.wait_for(lambda: self.laser()[-1:] == [True], "the laser")
        for name in names:
            self.wait_for_data(name, least)

    def wait_for_more(self, name="raw.pcap"):
        """Data that comes from now on."""
        self.wait_for_data(name, self.size(name) + 1_000_000)

    def wait_for_heartbeats(self, n=6):
        """That many more: by then what the sensor said before has been heard."""
        enough = len(self.events("heartbeat")) + n
        self.wait_for(lambda: len(self.events("heartbeat")) >= enough, "heartbeats")

    def run_until_files(self, count, stem, *arguments):
        """A run that a signal ends once there are so many finished files; its summary."""
        p = self.start("--laser", *arguments, "--json", stdout=subprocess.PIPE)
        self.addCleanup(p.stdout.close)
        self.wait_for(lambda: len([n for n in self.folder.names() if n.startswith(stem) and not n.endswith(".part")])
                      >= count, f"{count} files")
        p.send_signal(signal.SIGINT)
        text = p.stdout.read()
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        return json.loads(text)

    def fifo(self, name, reads=True):
        """A named pipe, with a reader that opens it and never reads, or with none."""
        path = self.folder / name
        os.mkfifo(path)
        if reads:
            self.reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
            self.addCleanup(os.close, self.reader)
        return path

    def wait_for_a_full_pipe(self, looks=25):
        """That of the last fifo(), or the one that `self.reader` is of: what waits in it no longer grows."""
        seen = [0]

        def is_full():
            seen.append(struct.unpack("i", fcntl.ioctl(self.reader, termios.FIONREAD, bytes(4)))[0])
            return seen[-1] > HALF_A_PIPE and len(set(seen[-looks:])) == 1
        self.wait_for(is_full, "a full pipe")

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
        said = p.stderr.read().decode()
        self.assertIsNotNone(p.wait(PATIENCE_S))
        return said

    def assert_laser_went_on_and_off(self):
        self.assertEqual(self.laser(), [True, False])
        self.assertTrue(self.heard("d"))

    def assert_laser_is_off(self):
        """By a command, whether it had come up or not: what ends a run may be faster."""
        self.assertIn(self.laser(), ([], [True, False]))
        self.assertTrue(self.heard("d"))

    def assert_no_parts(self):
        self.assertEqual([n for n in self.folder.names() if n.endswith(".part")], [])

    def assert_same_summary(self, live, recorded):
        """Unless the machine was too busy, and the recording has what was not decoded."""
        for key in recorded if live["ring_drops"] == 0 else ():
            if key not in LIVE_ONLY:
                self.assertEqual(live[key], recorded[key], key)


class Recording(Case):
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

    def test_the_summary_is_that_of_the_recorded_capture(self):
        self.simulator("--loss", "0.01", "--duplicate", "0.01", "--reorder", "0.01", "--corrupt", "0.01")
        raw = self.folder / "raw.pcap"
        for _ in range(10):  # until this machine is not too busy to decode what it records
            r = self.dump("--laser", "--duration", "2", "-o", raw, "--json")
            self.assertEqual(r.returncode, 0, r.stderr)
            live = json.loads(r.stdout)
            if live["ring_drops"] == 0 and live["points"] > 10_000:
                break
        self.assertEqual([k for k in LIVE_KEYS if k not in live], [])
        self.assert_same_summary(live, summary(raw))
        self.assertEqual(live["records"] + live["ring_drops"], live["received"])
        self.assertEqual(live["laser"], "off")
        self.assertGreater(live["lost_words"], 0)
        self.assertGreater(live["points"], 10_000)
        self.assertGreaterEqual(live["heartbeats_sent"], 2)
        self.assertGreater(live["tlv"], 0)
        self.assertGreaterEqual(live["seconds"], 2)

    def test_the_recording_tells_who_sent_and_who_received(self):
        self.simulator()
        for extra in [], ["--interface", "lo"]:
            r = self.dump("--duration", "0.2", "-o", self.folder / "raw.pcap", *extra)
            self.assertEqual(r.returncode, 0, r.stderr)
            frame = next(frames_of((self.folder / "raw.pcap").read_bytes()))
            self.assertEqual(frame[26:34], ip(self.address) + ip("127.0.0.1"))

    def test_without_an_output_it_sums_up(self):
        self.simulator()
        r = self.dump("--duration", "0.5")
        self.assertEqual(r.returncode, 0, r.stderr)
        for text in "heartbeats sent", "untouched", "lines":
            self.assertIn(text, r.stdout)
        self.assertEqual(self.heard("u"), [])
        self.assertEqual(self.heard("d"), [])

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

    def test_one_file_a_frame(self):
        self.simulator()
        self.run_until_files(5, "f-", "-o", self.folder / "f-%04d.csv")
        self.assert_no_parts()

    def test_frames_come_as_from_the_recorded_capture(self):
        self.simulator()
        raw = self.folder / "raw.pcap"
        what = ["--columns", "frame,eye,line,pixel,x,time", "--organized", "--return", "last"]
        for _ in range(5):  # on a busy machine datagrams may be dropped, which the recording may have
            for name in self.folder.names():
                if name.startswith("live"):
                    (self.folder / name).unlink()
            got = self.run_until_files(5, "live-", "-o", raw, *what, "-o", self.folder / "live.csv",
                                       "-o", self.folder / "live-%d.pcd")
            if got["kernel_drops"] == 0 and all(o["dropped"] == 0 for o in got["outputs"]):
                break
        else:
            self.fail(f"each run lacked datagrams: {got['outputs']}")
        r = run("lumdump", raw, "-q", *what, "-o", self.folder / "again.csv", "-o", self.folder / "again-%d.pcd")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertGreater(count_rows(self.folder / "live.csv"), 10_000)
        self.assertEqual((self.folder / "live.csv").read_bytes(), (self.folder / "again.csv").read_bytes())
        live = [n for n in self.folder.names() if n.startswith("live-")]
        self.assertGreaterEqual(len(live), 5)
        for name in live:  # but for the source, which is told
            got, want = ((self.folder / n).read_bytes().split(b"\nVERSION 0.7\n")[1]
                         for n in (name, name.replace("live", "again")))
            self.assertEqual(got, want)

    def test_utc_and_the_time_of_arrival_are_of_now(self):
        for clock in "arrival", "utc":
            with self.subTest(clock):
                self.simulator()
                before = time.time()
                self.run_until_files(2, clock, "--time", clock, "--eye", "blue", "-o", self.folder / f"{clock}-%d.csv")
                times = [int(row["timestamp"]) / 1e6 for path in self.folder.path.glob(f"{clock}-*.csv")
                         for row in read_csv(path)]
                self.assertGreaterEqual(min(times), before)
                self.assertLessEqual(max(times), time.time())

    def test_another_port_is_shown_as_the_sensors(self):
        self.simulator("--port", "5600")
        self.url += ":5600"
        r = self.dump("--duration", "0.3", "-o", self.folder / "raw.pcap", "--json")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assert_same_summary(json.loads(r.stdout), summary(self.folder / "raw.pcap"))

    def test_quiet_says_nothing(self):
        self.simulator()
        for _ in range(10):  # until this machine is not too busy
            r = self.dump("--duration", "0.3", "-q", "-o", self.folder / "raw.pcap")
            if "datagrams are missing from this recording" not in r.stderr:
                break
        self.assertEqual((r.returncode, r.stdout, r.stderr), (0, "", ""))


class Rotation(Case):
    def files(self, stem, ending):
        names = [n for n in self.folder.names() if n.startswith(stem + "-") and n.endswith(ending)]
        self.assertEqual(names, [f"{stem}-{i:04d}{ending}" for i in range(1, len(names) + 1)])
        return [self.folder / n for n in names]

    def test_by_time(self):
        self.simulator()
        got = self.run_until_files(3, "c-", "--rotate", "1s", "-o", self.folder / "r.pcap", "-o", self.folder / "c.csv")
        captures = self.files("r", ".pcap")
        self.assertGreaterEqual(len(captures), 3)
        parts = [summary(p) for p in captures]
        recording, cloud = got["outputs"]
        self.assertEqual(sum(p["records"] for p in parts), recording["datagrams"])
        for part in parts[:-1]:  # it begins anew with a frame, or when that is waited for in vain
            self.assertGreater(part["duration_s"], 0.8)
        self.assertLess(len(captures), got["seconds"] + 2)
        clouds = self.files("c", ".csv")
        if got["ring_drops"] + cloud["dropped"] == 0:  # no more than a busy machine
            self.assertEqual(sum(count_rows(p) for p in clouds), got["points"])
        self.assert_no_parts()

    def test_by_size(self):
        self.simulator()
        got = self.run_until_files(3, "r-", "--rotate", "1MB", "-o", self.folder / "r.pcap")
        captures = self.files("r", ".pcap")
        self.assertGreater(len(captures), 2)
        for path in captures[:-1]:
            self.assertGreaterEqual(path.stat().st_size, 1_000_000)
        self.assertEqual(sum(summary(p)["records"] for p in captures), got["received"])

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

    def test_a_recording_as_pcapng_knows_its_calibration(self):
        calibration = self.folder.write("front.yaml", "version: 1\neyes: {blue: {mount: {x_m: 10.0}}}\n")
        self.simulator()
        p = self.start("--laser", "--calibration", calibration, "-q", "-o", self.folder / "a.pcap", "-o", self.folder / "a.pcapng")
        self.wait_for_points()
        for name in "a.pcap", "a.pcapng":
            self.wait_for_more(name)
        p.send_signal(signal.SIGINT)
        said = self.end(p).splitlines()
        self.assertEqual((p.returncode, [s for s in said if "datagrams are missing" not in s]), (0, []))
        rows = []
        for name, arguments in (("a.pcap", ["--calibration", calibration]), ("a.pcapng", [])):
            out = self.folder / f"{name}.csv"
            r = run("lumdump", self.folder / name, *arguments, "-o", out, "-q")
            self.assertEqual((r.returncode, r.stderr), (0, ""))
            rows.append(out.read_bytes())
        self.assertGreater(len(rows[0]), 100000)
        self.assertTrue(rows[0] == rows[1])
        self.assertIn(f'source: "{self.url}"\n'.encode(), (self.folder / "a.pcapng").read_bytes())

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
                    self.assertIn("named twice" if there or link not in (first, second) else "leads nowhere", r.stderr)
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

    def test_signals_that_come_again_do_not_leave_the_laser_on(self):
        self.simulator("--answer-delay", "150")
        p = self.start_recording("--laser")
        self.wait_for_laser()
        for _ in range(5):
            signal_and_see(p, signal.SIGTERM)
        self.end(p)
        self.assert_laser_went_on_and_off()
        self.assertEqual(p.returncode, 0)

    def test_a_reader_that_leaves_ends_it(self):
        self.simulator()
        r = subprocess.run(f"'{BIN}/lumdump' {self.url} --laser -o - --format csv | head -n 5 | wc -l; "
                           "echo ${PIPESTATUS[0]}", shell=True, executable="/bin/bash", capture_output=True, text=True,
                           timeout=PATIENCE_S)
        self.assertEqual(r.stdout.split(), ["5", "0"])
        self.assertEqual(r.stderr, "")
        self.assert_laser_went_on_and_off()

    def test_a_reader_that_leaves_ends_its_output_alone(self):
        self.simulator()
        r = subprocess.run(f"'{BIN}/lumdump' {self.url} --laser --duration 4 -o - --format csv "
                           f"-o '{self.folder.path}/raw.pcap' | head -n 5 | wc -l; echo ${{PIPESTATUS[0]}}", shell=True,
                           executable="/bin/bash", capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(r.stdout.split(), ["5", "0"])
        self.assertEqual(len(warnings_in(r.stderr)), 1, r.stderr)
        self.assertIn("the reader of standard output has left", r.stderr)
        self.assertGreater(summary(self.folder / "raw.pcap")["duration_s"], 1.5)
        self.assert_laser_went_on_and_off()

    def test_the_last_reader_that_leaves_ends_it(self):
        self.simulator()
        fifo = self.folder / "points.xyz"
        os.mkfifo(fifo)
        reader = subprocess.Popen(["head", "-c", "100", fifo], stdout=subprocess.DEVNULL)
        self.addCleanup(reader.wait)
        self.addCleanup(reader.kill)
        p = self.start("--laser", "-o", "-", "--format", "csv", "-o", fifo, stdout=subprocess.PIPE,
                       stderr=open(self.folder / "said", "wb"))
        self.addCleanup(p.stdout.close)
        self.assertEqual(reader.wait(PATIENCE_S), 0)
        self.wait_for(lambda: p.stdout.read(100_000) and f"the reader of {fifo} has left" in self.said(), "the news")
        self.assertIsNone(p.poll())
        p.stdout.close()
        self.assertEqual(p.wait(PATIENCE_S), 0, self.said())
        self.assertEqual(len([s for s in self.said().splitlines() if "the system dropped" not in s]), 1, self.said())
        self.assert_laser_went_on_and_off()

    def test_a_reader_that_leaves_is_noticed_though_there_are_no_points(self):
        self.simulator()
        r = subprocess.run(f"'{BIN}/lumdump' {self.url} -o - --format csv | head -n 1 | wc -l; echo ${{PIPESTATUS[0]}}",
                           shell=True, executable="/bin/bash", capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((r.stdout.split(), r.stderr), (["1", "0"], ""))

    def test_points_come_while_they_are_measured(self):
        self.simulator()
        p = self.start("--laser", "-o", "-", "--format", "csv", stdout=subprocess.PIPE)
        got = b""
        while got.count(b"\n") < 1000:
            self.assertTrue(select.select([p.stdout], [], [], PATIENCE_S)[0], got)
            got += os.read(p.stdout.fileno(), 65536)
        self.assertIsNone(p.poll())
        p.stdout.close()
        self.end(p)
        self.assertEqual(p.returncode, 0)

    def test_a_capture_on_standard_output_is_one(self):
        self.simulator()
        p = self.start("--duration", "2", "-o", "-", "--format", "pcap", stdout=subprocess.PIPE)
        (self.folder / "raw.pcap").write_bytes(p.stdout.read())
        p.stdout.close()
        self.end(p)
        self.assertEqual(p.returncode, 0)
        self.assertGreater(summary(self.folder / "raw.pcap")["data"], 10)

    def test_killed_it_leaves_what_was_recorded(self):
        self.simulator()
        for _ in range(5):  # until this machine does not hold up the simulator
            p = self.start_recording("--laser")
            self.wait_for_points()
            self.wait_for_heartbeats()
            self.wait_for_more()
            p.kill()
            self.end(p)
            got = summary(self.folder / "raw.pcap")
            self.assertGreater(got["duration_s"], 0.5)
            self.wait_for(lambda: not self.laser()[-1], "the sensor's own switching off")
            late_s = self.events("laser")[-1]["t"] - self.events("heartbeat")[-1]["t"]
            if late_s < 3.2:
                return
            (self.folder / "raw.pcap").unlink()
        self.fail(f"off {late_s} s after the last heartbeat")

    def test_a_recording_grows_as_it_comes(self):
        self.sensor(lines=3)  # lines of 4 kB: no more come that would bring these to the file
        p = self.start("-o", self.folder / "raw.pcap")
        self.wait_for_data(least=10_000)
        p.kill()
        self.end(p)
        self.assertGreater(summary(self.folder / "raw.pcap")["data"], 5)

    def test_stopped_it_sends_no_heartbeats(self):
        self.simulator()
        p = self.start_recording("--laser")
        self.wait_for_laser()
        p.send_signal(signal.SIGSTOP)
        before = len(self.events("heartbeat"))
        self.wait_for(lambda: self.laser() == [True, False], "the sensor's own switching off")
        self.assertLessEqual(len(self.events("heartbeat")) - before, 1)
        p.send_signal(signal.SIGCONT)
        self.wait_for(lambda: len(self.events("heartbeat")) > before + 5, "heartbeats")
        self.wait_for_heartbeats()
        self.assertEqual(len(self.heard("u")), 1)
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        self.assertIn("not switched on again", said)
        self.assertIn("laser on", said)


class Stalls(Case):
    def test_a_reader_that_stalls_costs_data_and_not_the_laser(self):
        self.simulator()
        p = self.start("--laser", "--buffer", "1MB", "-o", "-", "--format", "xyz", stdout=subprocess.PIPE)
        self.wait_for(lambda: self.laser() == [True], "the laser")
        self.wait_for_heartbeats(20)  # 4 s of them
        self.assertEqual(self.laser(), [True])
        # the reader comes to its senses; all ends well
        drain = threading.Thread(target=p.stdout.read)
        drain.start()
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        drain.join()
        p.stdout.close()
        self.assertEqual(p.returncode, 0, said)
        self.assertIn("standard output is too slow for the data", said)
        self.assertRegex(said, r"outputs +done  standard output, \d+ datagrams dropped")
        self.assertNotIn("recording_drops", said)
        self.assert_laser_went_on_and_off()

    def test_a_reader_that_never_comes_back_is_not_waited_for(self):
        self.simulator()
        p = self.start("--laser", "-o", "-", "--format", "csv", stdout=subprocess.PIPE)
        self.reader = p.stdout.fileno()
        self.wait_for(lambda: self.laser() == [True], "the laser")
        self.wait_for_a_full_pipe()
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 1)
        self.assert_laser_went_on_and_off()
        p.stdout.close()
        said = self.end(p)
        self.assertIn("standard output makes no progress and is given up", said)
        self.assertRegex(said, "outputs +stalled  standard output")

    def test_a_second_signal_does_not_wait_for_an_output(self):
        self.simulator()
        p = self.start("--laser", "-o", self.fifo("stalls.csv"), stderr=open(self.folder / "said", "wb"))
        self.wait_for(lambda: self.laser() == [True], "the laser")
        self.wait_for_a_full_pipe()
        p.send_signal(signal.SIGINT)
        self.wait_for(lambda: self.laser() == [True, False], "the end of the laser")
        self.wait_for(lambda: p.send_signal(signal.SIGINT) or p.poll() is not None, "the end")
        self.assertIn(p.returncode, (-signal.SIGINT, 1))

    def test_a_terminal_that_stalls_costs_nothing(self):
        self.simulator()
        ends = os.pipe()
        os.set_blocking(ends[1], False)
        try:
            while True:
                os.write(ends[1], bytes(4096))
        except BlockingIOError:
            os.set_blocking(ends[1], True)
        p = subprocess.Popen([BIN / "lumdump", self.url, "--laser", "--buffer", "128KiB", "-o", "-", "--format", "csv"],
                             stdout=subprocess.PIPE, stderr=ends[1])
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        self.wait_for(lambda: self.laser() == [True], "the laser")
        self.wait_for_heartbeats(20)
        self.assertEqual(self.laser(), [True])
        p.stdout.close()
        for end in ends:
            os.close(end)

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
        r = subprocess.run([BIN / "lumdump", self.url, "--laser", *arguments], capture_output=True, timeout=PATIENCE_S,
                           restore_signals=False, text=True,
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
        self.assert_laser_is_off()
        self.assert_no_parts()


class Alone(Case):
    """An output that stalls or fails does so alone. Recordings are waited for by their disk alone."""

    def record_beside(self, *outputs, arguments=(), until=""):
        """A recording beside others, ended when it has said something; its JSON."""
        p = self.start("--laser", "--json", *arguments, *[a for o in outputs for a in ("-o", o)], stdout=subprocess.PIPE,
                       stderr=open(self.folder / "said", "wb"))
        self.addCleanup(p.stdout.close)
        self.wait_for(lambda: re.search(until, self.said()) or p.poll() is not None, until)
        self.assertIsNone(p.poll(), self.said())
        self.wait_for_heartbeats()
        p.send_signal(signal.SIGINT)
        got = json.loads(p.stdout.read())
        self.assertEqual(p.wait(PATIENCE_S), 1, self.said())
        self.assertEqual(self.laser()[-1], False)
        return got

    def assert_nothing_is_missing(self, got, name="raw.pcap"):
        """All that came is in the recording, as often as it came."""
        self.assertEqual(got["recording_drops"], 0)
        output = self.output(got, name)
        self.assertEqual((output["end"], output["dropped"], output["datagrams"]), ("done", 0, got["received"]))
        recorded = summary(self.folder / name)
        self.assertEqual(recorded["records"], got["received"])
        self.assert_same_summary(got, recorded)

    def output(self, got, name):
        return next(o for o in got["outputs"] if o["name"].endswith(name))

    def test_those_that_stall_are_dropped_and_the_recording_is_whole(self):
        self.simulator()
        clouds = [self.fifo("before.csv"), self.fifo("after.xyz")]
        got = self.record_beside(clouds[0], self.folder / "raw.pcap", clouds[1], arguments=["--buffer", "32MiB"],
                                 until="(?s)makes no progress.*makes no progress")
        self.assert_nothing_is_missing(got)
        for cloud in clouds:
            self.assertEqual(self.said().count(f"{cloud} makes no progress and is given up"), 1)
            stalled = self.output(got, cloud.name)
            self.assertEqual(stalled["end"], "stalled")
            self.assertGreater(stalled["dropped"], 0)
            self.assertLess(stalled["ended_s"], got["seconds"])
        self.assertEqual(self.said().count("the others go on"), 2)

    def test_a_pipe_without_a_reader_keeps_nothing_from_beginning(self):
        self.simulator()
        cloud = self.fifo("nobody.csv", reads=False)
        p = self.start("--laser", "-o", cloud, "-o", self.folder / "raw.pcap", "--json",
                       stdout=subprocess.PIPE, stderr=open(self.folder / "said", "wb"))
        self.wait_for_points("raw.pcap", least=1_000_000)
        p.send_signal(signal.SIGINT)
        got = json.loads(p.communicate(timeout=PATIENCE_S)[0])
        self.assertEqual(p.returncode, 1)
        self.assert_nothing_is_missing(got)
        self.assert_laser_went_on_and_off()
        self.assertIn(f"{cloud} makes no progress and is given up", self.said())

    def test_a_reader_that_comes_late_gets_all(self):
        self.simulator()
        cloud = self.fifo("late.csv", reads=False)
        p = self.start("--laser", "-o", cloud, "-o", self.folder / "raw.pcap", stderr=open(self.folder / "said", "wb"))
        self.wait_for(lambda: self.size("raw.pcap") > 1_000_000, "a recording")
        rows = []
        reader = threading.Thread(target=lambda: rows.append(count_rows(cloud)))
        reader.start()
        self.wait_for_heartbeats()
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 0, self.said())
        reader.join()
        self.assertEqual(rows, [summary(self.folder / "raw.pcap")["points"]])

    def test_one_that_fails_ends_alone(self):
        self.simulator()
        full = self.folder / "full.csv"
        full.symlink_to("/dev/full")
        for number in range(2, 2000):  # of the first frame with points, which comes with the laser
            (self.folder / f"f-{number:04d}.ply").mkdir()  # cannot be written over
        for name, error in (full, "No space left on device"), (self.folder / "f-%04d.ply", r"f-\d{4}\.ply: is a directory"):
            with self.subTest(name):
                got = self.record_beside(self.folder / "raw.pcap", name, self.folder / "c.csv",
                                         until=f"{error}.*: that output has ended, the others go on")
                self.assert_nothing_is_missing(got)
                failed = self.output(got, name.name)
                self.assertEqual(failed["end"], "failed")
                self.assertRegex(failed["error"], error)
                self.assertEqual(self.output(got, "c.csv")["end"], "done")
                if got["ring_drops"] + self.output(got, "c.csv")["dropped"] == 0:
                    self.assertEqual(count_rows(self.folder / "c.csv"), got["points"])
                self.assert_no_parts()

    def test_a_recording_that_fails_leaves_the_other(self):
        self.simulator()
        (self.folder / "a-0002.pcap").mkdir()
        got = self.record_beside(self.folder / "a.pcap", self.folder / "b.pcap", arguments=["-q", "--rotate", "1MB"],
                                 until="a-0002.pcap.*: that output has ended, the others go on")
        self.assertEqual(self.output(got, "a.pcap")["end"], "failed")
        parts = [summary(self.folder / n)["records"] for n in self.folder.names() if n.startswith("b-")]
        self.assertGreater(len(parts), 2)
        self.assertEqual(sum(parts), got["received"])
        self.assertGreater(summary(self.folder / "a-0001.pcap")["records"], 100)

    def test_what_a_recording_lost_is_told_though_it_is_quiet(self):
        self.simulator()
        p = self.start("--laser", "-q", "--buffer", "128KiB", "-o", self.fifo("slow.pcap"),
                       stderr=open(self.folder / "said", "wb"))
        self.wait_for(lambda: re.search(r"slow.pcap is too slow for the data: \d+ datagrams are missing from this recording",
                                        self.said()), "the news")
        self.wait_for(lambda: self.laser() == [True], "the laser")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 1)
        self.assertRegex(self.said(), r"slow.pcap: datagrams are missing from this recording: \d+ dropped by its buffer")
        self.assert_laser_went_on_and_off()

    def test_what_has_ended_is_not_told_to_be_too_slow(self):
        self.simulator()
        slow = self.folder / "slow.pcap"
        os.mkfifo(slow)
        reader = os.open(slow, os.O_RDONLY | os.O_NONBLOCK)
        p = self.start("--laser", "--buffer", "128KiB", "-o", slow, "-o", self.folder / "c.csv",
                       stderr=open(self.folder / "said", "wb"))
        self.wait_for(lambda: "slow.pcap is too slow" in self.said(), "the news")
        told = time.monotonic()
        self.wait_for_heartbeats(2)  # more are dropped, of which it would be told 10 s later
        os.close(reader)
        self.wait_for(lambda: f"the reader of {slow} has left" in self.said(), "the news")
        self.wait_for(lambda: time.monotonic() > told + 11, "what would be told every 10 s")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 0, self.said())
        self.assertNotIn("slow.pcap is too slow", self.said().split("has left")[1])


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

    def wait_for_fsync(self):
        self.wait_for((self.folder / "hold.held").exists, "fsync()")

    def finish(self, p, status):
        """Its JSON."""
        self.assertEqual(p.wait(PATIENCE_S), status, self.said())
        return json.loads((self.folder / "summary").read_text())

    def test_a_disk_that_takes_longer_than_half_a_minute_loses_nothing(self):
        p = self.begin("--laser", "--duration", "0.5", "-o", self.folder / "c.csv", "-o", self.folder / "raw.pcap")
        self.wait_for_fsync()
        self.wait_for(lambda: "to be written; Ctrl-C gives it up" in self.said(), "the notice")
        held = time.monotonic()
        while time.monotonic() < held + 25:  # the notice came after 10 s
            self.assertIsNone(p.poll(), self.said())
            time.sleep(0.1)
        self.hold.unlink()
        got = self.finish(p, 0)
        self.assertEqual(summary(self.folder / "raw.pcap")["records"], got["received"])
        self.assertEqual(count_rows(self.folder / "c.csv"), got["points"])
        self.assert_no_parts()

    def test_one_signal_gives_up_what_the_disk_does_not_finish(self):
        p = self.begin("--laser", "--duration", "0.5", "-o", self.folder / "c.csv")
        self.wait_for_fsync()
        p.send_signal(signal.SIGINT)
        got = self.finish(p, 1)
        self.assertEqual(got["outputs"][0]["end"], "stalled")
        self.assertIn("c.csv was waited for and is given up", self.said())
        self.assert_laser_is_off()

    def test_so_does_the_next_signal_of_a_run_that_one_ended(self):
        p = self.begin("--laser", "-o", self.folder / "c.csv")
        self.wait_for_points("c.csv")
        p.send_signal(signal.SIGTERM)
        self.wait_for_fsync()
        p.send_signal(signal.SIGINT)
        self.assertEqual(self.finish(p, 1)["outputs"][0]["end"], "stalled")

    def test_rotation_waits_for_no_disk(self):
        p = self.begin("--laser", "--rotate", "200kB", "-o", self.folder / "r.pcap")
        self.wait_for_fsync()
        # sixteen wait for the disk; the next goes on for as long
        self.wait_for(lambda: self.size("r-0017.pcap") > 1_000_000, "a file that goes on")
        self.hold.unlink()
        self.wait_for(lambda: self.size("r-0018.pcap") > 0, "the next")
        p.send_signal(signal.SIGINT)
        got = self.finish(p, 0)
        parts = [summary(self.folder / n)["records"] for n in self.folder.names() if n.startswith("r-")]
        self.assertEqual((sum(parts), got["recording_drops"]), (got["received"], 0))
        self.assert_no_parts()

    def test_files_of_a_frame_that_wait_for_the_disk_are_not_given_up(self):
        p = self.begin("--laser", "--buffer", "1MB", "-o", self.folder / "f-%04d.csv", "-o", self.folder / "raw.pcap")
        # told every 10 s; what stands still is given up after 5 s
        self.wait_for(lambda: self.said().count("f-%04d.csv is too slow") >= 2, "drops, twice")
        self.assertNotIn("given up", self.said())
        self.hold.unlink()
        p.send_signal(signal.SIGINT)
        self.assertEqual([o["end"] for o in self.finish(p, 0)["outputs"]], ["done", "done"])
        self.assert_no_parts()

    def test_a_cloud_that_rotates_waits_for_no_disk(self):
        p = self.begin("--laser", "--rotate", "100kB", "-o", self.folder / "r.csv")

        def last():
            return sum(self.size(n) for n in self.folder.names() if n.startswith("r-0005.csv"))
        self.wait_for(lambda: last() > 2_000_000, "a file that goes on")
        self.hold.unlink()
        p.send_signal(signal.SIGINT)
        got = self.finish(p, 0)
        if got["ring_drops"] + got["outputs"][0]["dropped"] == 0:  # no more than a busy machine
            self.assertEqual(sum(count_rows(self.folder / n) for n in self.folder.names() if n.startswith("r-")), got["points"])
        self.assert_no_parts()

    def test_what_the_disk_refuses_of_a_rotated_file_is_told(self):
        (self.folder / "hold.broken").touch()
        p = self.begin("--rotate", "200kB", "-o", self.folder / "r.pcap", hold=False)
        self.assertEqual(self.finish(p, 1)["outputs"][0]["end"], "failed")
        self.assertIn("r-0001.pcap: cannot bring it to the disk: Input/output error", self.said())

    def test_a_thread_that_cannot_be_had_ends_it_though_a_pipe_waits_for_its_reader(self):
        p = self.begin("--laser", "-o", self.fifo("nobody.csv", reads=False), "-o", self.folder / "raw.pcap", hold=False,
                       LUM_THREADS="1")
        self.assertEqual(p.wait(PATIENCE_S), 1, self.said())
        self.assertIn("cannot start the writing thread", self.said())
        self.assertEqual(self.laser(), [])


class Sensors(Case):
    def test_one_that_is_not_there(self):
        r = self.dump("--laser", "--duration", "1", "-o", self.folder / "c.csv", "-o", self.folder / "r.pcap")
        self.assertEqual(r.returncode, 3, r.stderr)
        self.assertIn(f"no data from {self.address}", r.stderr)
        self.assertIn("doctor", r.stderr)
        self.assertEqual(self.folder.names(), [])

    def old_files(self):
        """Outputs of an earlier run, by their names."""
        names = "keep.ply keep.csv keep.pcap keep.pcapng".split()
        for name in names:
            self.folder.write(name, "old")
        return [a for n in names for a in ("-o", self.folder / n)]

    def assert_old_files_stay(self):
        for name in "keep.ply keep.csv keep.pcap keep.pcapng".split():
            self.assertEqual((self.folder / name).read_text(), "old", name)

    def deaf_sensor(self):
        """A socket in the sensor's place, which hears and says nothing."""
        deaf = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(deaf.close)
        deaf.bind((self.address, 5517))
        return deaf

    def wait_for_session(self, deaf):
        """A signal that comes before it has begun ends the program at once."""
        self.assertTrue(select.select([deaf], [], [], PATIENCE_S)[0], "waited in vain for a packet")

    def forget(self, deaf):
        """What a session that has ended sent."""
        while select.select([deaf], [], [], 0)[0]:
            deaf.recv(2048)

    def test_a_signal_before_the_first_data_leaves_all_as_it_was(self):
        outputs = self.old_files()
        before = self.folder.names()
        deaf = self.deaf_sensor()
        for number in signal.SIGINT, signal.SIGTERM:
            for extra in [], ["-q"], ["--json"]:
                with self.subTest(number=number, extra=extra):
                    p = self.start(*outputs, "-o", self.folder / "new.pcap", *extra, stdout=subprocess.PIPE)
                    self.addCleanup(p.stdout.close)
                    self.wait_for_session(deaf)
                    self.assertEqual(len([n for n in self.folder.names() if n.endswith(".part")]), 5)
                    p.send_signal(number)
                    self.assertEqual(p.stdout.read(), b"")
                    said = self.end(p)
                    self.assertEqual(p.returncode, 3, said)
                    self.assertRegex(said, rf"no data from {re.escape(self.address)} within \d+\.\d s, nor any answer")
                    self.assertNotIn("5517", said)
                    self.assertEqual(said.count("\n"), 1, said)
                    self.assert_old_files_stay()
                    self.assertEqual(self.folder.names(), before)
                    self.forget(deaf)

    def test_a_reader_gets_a_whole_header_if_a_signal_comes_before_the_first_data(self):
        deaf = self.deaf_sensor()
        p = self.start("-o", "-", "--format", "pcap", stdout=subprocess.PIPE)
        header = p.stdout.read(24)
        self.wait_for_session(deaf)
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.stdout.read(), b"")
        p.stdout.close()
        said = self.end(p)
        self.assertEqual((p.returncode, len(header)), (3, 24), said)
        self.assertIn(f"no data from {self.address}", said)

    def test_a_reader_that_leaves_before_the_first_data_is_no_failure(self):
        p = self.start("-o", "-", "--format", "csv", stdout=subprocess.PIPE)
        self.assertTrue(p.stdout.readline())
        p.stdout.close()
        self.assertEqual((self.end(p), p.returncode), ("", 0))

    def test_why_no_data_came_is_told_before_the_laser_is_switched_off(self):
        p = self.start("--laser", "-o", self.folder / "c.csv", stderr=open(self.folder / "said", "wb"))
        self.wait_for(lambda: "repeated for 7 s more" in self.said(), "the second part of laser off")
        first, second = self.said().splitlines()
        self.assertIn(f"no data from {self.address} within 5 s, nor any answer", first)
        self.assertIn("laser off is repeated for 7 s more; Ctrl-C twice gives up", second)
        signal_and_see(p, signal.SIGINT)
        signal_and_see(p, signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 3, self.said())
        self.assertEqual(self.said().count("no data from"), 1, self.said())

    def test_a_second_session_is_refused_and_harms_nothing(self):
        self.simulator()
        p = self.start_recording()
        self.folder.write("old.csv", "old")
        r = self.dump("--laser", "-o", self.folder / "old.csv")
        self.assertEqual(r.returncode, 1)
        self.assertIn(f"lumdump (process {p.pid}) has the session", r.stderr)
        self.assertIn("must end", r.stderr)
        self.assertNotIn("does not own", r.stderr)
        self.assertEqual((self.folder / "old.csv").read_text(), "old")
        self.assertEqual(self.laser(), [])
        p.send_signal(signal.SIGINT)
        self.end(p)
        self.assertEqual(p.returncode, 0)

    def test_no_points_are_told_with_their_reason(self):
        sensor = self.simulator("--fault", "interlock@USR1")
        r = self.dump("--duration", "0.5")
        self.assertIn("no point is left of them: the laser is off: use --laser", r.stderr)
        sensor.send_signal(signal.SIGUSR1)
        self.wait_for(lambda: self.events("fault"), "the fault")
        for arguments in [], ["--laser"]:
            r = self.dump("--duration", "1", *arguments)
            self.assertEqual(r.returncode, 0)
            self.assertIn("no point is left of them: a hazard keeps the laser down: HW_SAFETY_BAD", r.stderr)
        self.assertEqual(self.laser(), [])

    def test_a_hazard_at_the_start_is_told_and_recorded(self):
        self.simulator("--fault", "fan@0")
        r = self.dump("--laser", "--duration", "1.5", "-o", self.folder / "raw.pcap")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("stays down", r.stderr)
        self.assertEqual(r.stderr.count("hazard: FAN_PWM_BAD"), 1)
        self.assertEqual(self.laser(), [])
        self.assertTrue(self.heard("d"))
        self.assertGreater(summary(self.folder / "raw.pcap")["lines"], 10)

    def test_a_laser_that_is_lost_is_not_switched_on_again(self):
        sensor = self.simulator("--fault", "fan@USR1-USR2")
        p = self.start_recording("--laser")
        self.wait_for_laser()
        sensor.send_signal(signal.SIGUSR1)
        self.wait_for(lambda: self.heard("d"), "laser off")
        sensor.send_signal(signal.SIGUSR2)
        self.wait_for(lambda: len(self.events("fault")) == 2, "the end of the hazard")
        self.wait_for_heartbeats()
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        self.assertIn("went off", said)
        self.assertIn(f"lumctl --host {self.address} laser on", said)
        self.assertEqual(len(self.heard("u")), 1)
        self.assertEqual(self.laser(), [True, False])

    def test_a_reboot_is_told_and_the_recording_goes_on(self):
        sensor = self.simulator("--fault", "reboot@USR1")
        p = self.start_recording("--laser", "--json", stdout=subprocess.PIPE)
        self.addCleanup(p.stdout.close)
        self.wait_for_laser()
        sensor.send_signal(signal.SIGUSR1)
        self.wait_for(lambda: self.events("fault"), "the reboot")
        before = self.size("raw.pcap")
        self.wait_for_heartbeats()
        self.wait_for(lambda: self.size("raw.pcap") > before + 200_000, "more data")
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        self.assertIn("went off", said)
        self.assertEqual(len(self.heard("u")), 1)
        self.assert_same_summary(json.loads(p.stdout.read()), summary(self.folder / "raw.pcap"))

    def test_silence_is_told_and_waited_for(self):
        sensor = self.simulator("--fault", "silence@USR1-USR2")
        p = self.start_recording(stderr=open(self.folder / "said", "wb"))
        sensor.send_signal(signal.SIGUSR1)
        self.wait_for(lambda: re.search(rf"\d\d:\d\d:\d\d: no data from {self.address} for 3 s", self.said()), "the news")
        sensor.send_signal(signal.SIGUSR2)
        self.wait_for(lambda: re.search(rf"data from {self.address} again, after \d+\.\d s", self.said()), "data")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 0, self.said())

    def test_a_laser_whose_end_nobody_confirms_is_an_error(self):
        self.simulator("--answer-loss", "1")
        r = self.dump("--laser", "--duration", "2", "-o", self.folder / "raw.pcap")
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertIn("laser off was not answered", r.stderr)
        self.assertGreater(summary(self.folder / "raw.pcap")["data"], 10)
        self.assertEqual(self.laser()[-1], False)

    def test_another_layout_is_diagnosed(self):
        self.simulator()
        profile = self.folder.write("p.yaml", "version: 1\ndata_packet_type: 9\n")
        r = self.dump("--profile", profile, "-o", self.folder / "c.csv")
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertIn("none of them is a data packet", r.stderr)
        self.assertIn(f"  lumdump {self.url} --laser --duration 3 -o look.pcap\n  lumdump look.pcap --infer -o profile.yaml\n", r.stderr)
        self.assertEqual(self.folder.names(), ["p.yaml", "sim.log"])

    def test_a_recording_of_another_layout_is_kept_and_named(self):
        self.simulator()
        profile = self.folder.write("p.yaml", "version: 1\ndata_packet_type: 9\n")
        out = self.folder / "raw.pcap"
        r = self.dump("--profile", profile, "-o", out)
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertIn(f"  lumdump {out} --infer -o profile.yaml\n", r.stderr)
        self.assertNotIn("look.pcap", r.stderr)
        self.assertGreater(summary(out)["data"], 100)

    def test_what_others_send_is_not_taken(self):
        self.simulator()
        p = self.start_recording("--json", stdout=subprocess.PIPE)
        port = int(self.events("heartbeat")[0]["from"].split(":")[1])
        target = self.events("heartbeat")[0]["from"].split(":")[0]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.bind((next(ADDRESSES), 5517))
            for packet in line([word(1000, 5)], 0, 3, 777):
                other.sendto(packet, (target, port))
            other.sendto(b"junk", (target, port))
        time.sleep(0.2)
        p.send_signal(signal.SIGINT)
        got = json.loads(p.stdout.read())
        p.stdout.close()
        self.end(p)
        self.assertEqual(got["foreign_source"], 5)
        self.assertEqual((got["stray"], got["foreign"]), (0, 0))

    def test_a_sensor_that_is_moved_is_named_with_its_new_address(self):
        self.simulator()
        new = next(ADDRESSES)
        p = self.start_recording()
        self.assertEqual(run("lumctl", "--host", self.address, "set-ip", new).returncode, 0)
        told = b""
        while b"udp://" + new.encode() not in told:
            line_told = p.stderr.readline()
            self.assertNotEqual(line_told, b"", told)
            told += line_told
        self.assertIn(f"the data comes from {new} now, not from {self.address}".encode(), told)
        p.send_signal(signal.SIGINT)
        self.end(p)

    def test_laser_off_that_a_moved_sensor_does_not_answer_is_advised_at_its_new_address(self):
        self.simulator()
        new = next(ADDRESSES)
        p = self.start_recording("--laser")
        self.assertEqual(run("lumctl", "--host", self.address, "set-ip", new).returncode, 0)

        def read_until(text):
            told = b""
            while text not in told:
                line_told = p.stderr.readline()
                self.assertNotEqual(line_told, b"", told)
                told += line_told
        read_until(b"udp://" + new.encode())
        p.send_signal(signal.SIGINT)
        read_until(b"laser off is repeated for")
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertIn(f"lumdump: udp://{self.address}: laser off was not answered", said)
        self.assertIn(f"make sure by lumctl --host {new} laser off", said)
        self.assertEqual(run("lumctl", "--host", new, "laser", "off").returncode, 0)

    def test_a_status_line_is_shown_on_a_terminal_alone(self):
        self.simulator()
        main, terminal = pty.openpty()
        p = subprocess.Popen([BIN / "lumdump", self.url, "--laser", "-o", self.folder / "c.csv"], stderr=terminal)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        shown = b""
        is_asked = False
        while p.poll() is None:
            if select.select([main], [], [], 0.1)[0]:
                shown += os.read(main, 65536)
            if b"laser on  buf" in shown and not is_asked:
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
                                                      rb"ring \d+, bad \d+  laser on  buf \d+%", t)], lines)


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

    def test_each_tool_paints_in_the_foreground_alone(self):
        self.simulator()
        source = simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64")
        for command in (f"lumsim --frames 2 --lines 64 -o {self.folder / 'sim.pcap'}", f"lumdump {source} -o {self.folder / 'c.csv'}",
                        f"lumctl --host {self.address} heartbeat --duration 2",
                        "lumctl find --subnet 127.62.20.0/30",
                        f"lumdump {self.url} -o {self.folder / 'live.pcap'} --duration 2"):
            with self.subTest(command):
                shown = self.shown_until(self.shell(f"{BIN}/{command}; echo over"), b"over\r\n")
                self.assertIn(b"\r\x1b[K", shown)
                shown = self.shown_until(self.shell(f"{BIN}/{command} & wait; echo over"), b"over\r\n")
                self.assertNotIn(b"\x1b[K", shown)

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


class Handmade(threading.Thread):
    """A sensor that answers every TLV packet by a status, refuses the first lasers for want of a heartbeat, and sends a
    line of data for each heartbeat, or for the first so many."""

    def __init__(self, address, refusals, lines):
        super().__init__(daemon=True)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((address, 5517))
        self.socket.settimeout(0.1)
        self.refusals = refusals
        self.lines_left = lines
        self.commands = []
        self.sequences = []  # of the commands
        self.mute = set()  # commands that get no answer
        self.has_status = True  # in answers
        self.status = 0x0210
        self.ends = False
        self.clock = 0
        self.heard = 0  # requests

    def run(self):
        while not self.ends:
            try:
                packet, sender = self.socket.recvfrom(2048)
            except TimeoutError:
                continue
            for answer in self.answers(packet):
                self.socket.sendto(answer, sender)
        self.socket.close()

    def answers(self, packet):
        if packet[8] == 8 and self.lines_left > 0:
            self.lines_left -= 1
            self.clock += 2500
            yield from line([word(1000, 5)], 0, self.clock // 2500 % 64, self.clock)
        if packet[8] == 7:
            self.heard += 1
            if len(packet) > 16:
                is_new = packet[12:16] not in self.sequences
                self.sequences.append(packet[12:16])
                (self.take if is_new else self.commands.append)(packet[20:])
            if packet[20:] in self.mute:
                return
            status = struct.pack("<HHH", 2, 2, self.status) if self.has_status else b""
            yield packet[:16] + status + struct.pack("<HH", 3, 6) + b"a\x1bbc\n\xff"

    def orders(self):
        """The commands, each once however often it was sent: a busy machine answers late."""
        return list(dict(zip(self.sequences, self.commands)).values())

    def take(self, command):
        self.commands.append(command)
        if command == b"d":
            self.status = 0x0200
        elif self.refusals > 0:
            self.refusals -= 1
            self.status = 0x0810
        else:
            self.status = 0x0800


class HandmadeSensors(Case):
    def wait_for_polls(self, sensor):
        """By then what it answered before has been heard."""
        enough = sensor.heard + 3
        self.wait_for(lambda: sensor.heard >= enough, "requests")

    def test_a_laser_refused_before_the_first_heartbeat_is_asked_for_again(self):
        sensor = self.sensor(refusals=3)
        p = self.start("--laser", stdout=subprocess.DEVNULL)
        self.wait_for(lambda: sensor.status == 0x0800, "the laser")
        self.wait_for_polls(sensor)
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        self.assertEqual(sensor.orders(), [b"u"] * 4 + [b"d"])
        self.assertNotIn("hazard", said)

    def test_a_laser_that_is_given_up_is_switched_off(self):
        sensor = self.sensor()
        sensor.mute = {b"u"}
        r = self.dump("--laser", "--duration", "8")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("did not answer to laser on (sent 5 times): it is switched off", r.stderr)
        first = sensor.commands.index(b"d")
        self.assertEqual(set(sensor.commands[:first]), {b"u"})
        self.assertEqual(set(sensor.commands[first:]), {b"d"})
        self.assertEqual(sensor.orders()[-2:], [b"d", b"d"])  # at once, and at the end

    def test_a_laser_that_cannot_be_seen_is_switched_off(self):
        sensor = self.sensor()
        sensor.has_status = False
        p = self.start("--laser", stdout=subprocess.DEVNULL)
        self.wait_for(lambda: b"d" in sensor.orders() and sensor.clock > 0, "laser off, and data")
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 1, said)
        self.assertIn("without a status: whether it is on is not known, so it is switched off", said)
        self.assertEqual(sensor.orders()[:2], [b"u", b"d"])
        self.assertEqual(sensor.orders().count(b"u"), 1)

    def test_laser_off_that_a_hazard_calls_for_is_said_until_it_is_answered(self):
        sensor = self.sensor()
        sensor.mute = {b"d"}
        p = self.start("--laser", stdout=subprocess.DEVNULL)
        self.wait_for(lambda: sensor.orders() == [b"u"], "laser on")
        self.wait_for_polls(sensor)
        sensor.commands.clear()
        sensor.take = sensor.commands.append
        sensor.status = 0x0840
        self.wait_for(lambda: len(sensor.commands) > 7, "more than one try of laser off")
        sensor.mute = set()
        p.send_signal(signal.SIGINT)
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        self.assertEqual(set(sensor.commands), {b"d"})
        self.assertEqual(said.count("does not answer to laser off"), 1, said)

    def test_one_that_answers_and_sends_no_data_is_told_from_one_that_is_not_there(self):
        sensor = self.sensor(lines=0)
        r = self.dump("--laser", "-o", self.folder / "c.csv")
        self.assertEqual(r.returncode, 3, r.stderr)
        self.assertIn("though it answers", r.stderr)
        self.assertEqual(sensor.orders(), [b"u", b"d"])
        self.assertEqual(self.folder.names(), [])

    def test_points_left_out_are_told_of_each_output(self):
        """A line number that is damaged has no row."""
        def answers(packet):
            yield from Handmade.answers(sensor, packet)
            if packet[8] == 8:
                yield from line([word(1000, 5)], 0, 60_000, sensor.clock + 1000)
        sensor = self.sensor()
        sensor.answers = answers
        lacking, whole, raw = (self.folder / n for n in ("f-%d.pcd", "whole.csv", "raw.pcap"))
        p = self.start("--organized", "--return", "first", "-o", raw, "-o", whole, "-o", lacking,
                       "--json", stdout=subprocess.PIPE)
        self.wait_for(lambda: sensor.clock > 5 * 2500, "lines")
        p.send_signal(signal.SIGINT)
        got = json.loads(p.stdout.read())
        p.stdout.close()
        said = self.end(p)
        self.assertEqual(p.returncode, 0, said)
        count = got["left_out"][0]["no_place"]
        self.assertGreater(count, 1)
        self.assertEqual(got["left_out"], [{"output": str(lacking), "late": 0, "cut": 0, "no_place": count}])
        self.assertEqual([text for text in said.splitlines() if "left out" in text],
                         [f"lumdump: warning: {lacking}: {count} points left out, which have no place in an organised cloud"])

    def test_answers_alone_replace_no_recording(self):
        sensor = self.sensor(lines=0)
        path = self.folder.write("keep.pcap", "old")
        for has_signal in True, False:
            sensor.heard = 0
            p = self.start("-o", path)
            if has_signal:
                self.wait_for(lambda: sensor.heard > 2, "requests, which were answered")
                p.send_signal(signal.SIGINT)
            said = self.end(p)
            self.assertEqual(p.returncode, 3, said)
            self.assertRegex(said, r"no data from \S+ within \S+ s, though it answers")
            self.assertEqual(path.read_text(), "old")
            self.assertEqual(self.folder.names(), ["keep.pcap"])

    def test_how_many_signals_end_a_long_laser_off(self):
        sensor = self.sensor()
        sensor.mute = {b"d"}
        for before, told in (0, "for 7 s more; Ctrl-C twice gives up\n"), (1, "for 7 s more; Ctrl-C gives up\n"), (2, ""):
            with self.subTest(before):
                sensor.commands.clear()
                sensor.sequences.clear()
                sensor.clock = 0
                p = self.start("--laser", *([] if before else ["--duration", "0.2"]), "-q",
                               stderr=open(self.folder / "said", "wb"), stdout=subprocess.DEVNULL)
                self.wait_for(lambda: b"u" in sensor.commands and sensor.clock > 0, "laser on, and data")
                for sent in range(before):
                    p.send_signal(signal.SIGINT)
                    self.wait_for(lambda: b"d" in sensor.commands, "laser off")
                if told:
                    self.wait_for(lambda: "laser off is repeated" in self.said(), "the news")
                    self.assertIn(told, self.said())
                for sent in range(before, 2):
                    signal_and_see(p, signal.SIGINT)
                self.assertEqual(p.wait(PATIENCE_S), 1, self.said())
                self.assertEqual("laser off is repeated" in self.said(), told != "", self.said())
                self.assertIn("laser off was not answered", self.said())

    def test_what_the_sensor_says_cannot_upset_a_terminal(self):
        self.sensor()
        r = self.dump("--duration", "0.3")
        self.assertIn("says: a?bc??\n", r.stderr)


class Arguments(Case):
    def test_each_wrong_one_is_named_with_what_is_right(self):
        for arguments, message in (
                (["udp://"], "udp://10.42.0.37"), (["udp://sensor.invalid"], "'sensor.invalid'"), (["udp://1.2.3"], "four numbers"),
                (["udp://[::1]"], "IPv4"), (["udp://::1"], "IPv4"), (["udp://:5517"], "no host in it"),
                ([self.url, "--interface", "nosuch0"], "there is no interface nosuch0; this host has: "),
                (["x.pcap", "--sensor", "sensor.invalid"], "--sensor: 'sensor.invalid'"), (["udp://10.42.0.37:0"], "port"), (["udp://10.42.0.37:99999"], "port"),
                (["udp://10.42.0.37/x"], "udp://HOST"), (["udp://0.0.0.0"], "no sensor"),
                (["udp://224.0.0.1"], "no sensor"), (["udp://255.255.255.255"], "no sensor"),
                ([self.url, "--sensor", "10.42.0.37"], "already names one"), ([self.url, "--buffer", "1"], "256MB"),
                ([self.url, "--rotate", "1s"], "--rotate"), ([self.url, "--rotate", "5x", "-o", "a.csv"], "10min"),
                ([self.url, "--rotate", "0s", "-o", "a.csv"], "10min"),
                ([self.url, "-o", "-", "--format", "ply"], "cannot seek"),
                ([self.url, "-o", "a.csv", "-o", "b"], "--format"), (["x.pcap", "--laser"], "udp://"),
                ([self.url, "--l"], "did you mean --laser?"), ([self.url, "--dur", "1"], "--duration"),
                ([self.url, "--bu=1MB"], "did you mean --buffer?"), ([self.url, "--ver"], "did you mean --version?"),
                (["127.0.0.1"], "no such file; a sensor is named as udp://127.0.0.1\n"),
                (["udp:/127.0.0.1:55"], "udp://127.0.0.1:55\n"),
                (["x.pcap", "--interface", "lo"], "udp://"), (["x.pcap", "--buffer", "1MB"], "udp://")):
            with self.subTest(arguments):
                r = run("lumdump", *arguments)
                self.assertEqual(r.returncode, 2, r.stderr)
                self.assertIn(message, r.stderr)

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
