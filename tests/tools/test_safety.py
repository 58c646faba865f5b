#!/usr/bin/env python3
"""The laser goes off when nobody listens any more. All times are those of the sensor's own log, of one monotonic
clock."""
import os
import signal
import socket
import struct
import subprocess
import time
import unittest

import shards
from live import Sensor, tool, wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder

HEARTBEATS_END_S = 2.5
LASER_ENDS_S = 3.2

# A busy machine may hold up the simulator itself, or the test between a signal and a look at the clock. So one run of so
# many that keeps the limit is enough, and what keeps none fails each time.
RUNS = 5


class Safety(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def start(self, last, *arguments, **options):
        """A sensor, and a recording with the laser on."""
        address = f"127.30.0.{last}"
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=address)
        self.dump = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", *arguments, **options)
        wait_until(self.sensor.laser_is_up, "the laser")

    def wait_for_data(self, least=1000):
        """That the recording has got: one that ends before has status 3."""
        path = self.folder / "a.pcap"
        wait_until(lambda: path.exists() and path.stat().st_size > least, "data")

    def assert_soon_enough(self, run):
        """run() tells pairs of how long something took and how long it may."""
        for _ in range(RUNS):
            took = run()
            self.sensor.end()
            if all(a < b for a, b in took):
                return
            (self.folder / "a.pcap").unlink(missing_ok=True)
        self.fail(took)

    def wait_for_darkness(self):
        wait_until(lambda: not self.sensor.laser_is_up(), "the end of the laser")
        return self.sensor.events("laser")[-1]["t"]

    def last_heartbeat(self):
        return self.sensor.events("heartbeat")[-1]["t"]

    def test_heartbeats_come_several_times_a_second(self):
        def run():
            self.start(1, "-o", self.folder / "a.pcap")
            wait_until(lambda: len(self.sensor.events("heartbeat")) >= 8, "eight heartbeats")
            self.wait_for_data()
            times = [e["t"] for e in self.sensor.events("heartbeat")]
            self.assertEqual(self.dump.end(signal.SIGINT), 0, self.dump.stderr())
            self.assertFalse(self.sensor.laser_is_up())
            return [(max(b - a for a, b in zip(times, times[1:])), 3.0)]
        self.assert_soon_enough(run)

    def test_a_stopped_program_stops_its_heartbeats(self):
        def run():
            self.start(2, "-o", self.folder / "a.pcap")
            self.dump.send(signal.SIGSTOP)
            stopped = time.monotonic()
            dark = self.wait_for_darkness()
            last = self.last_heartbeat()
            self.dump.kill()
            return [(last, stopped + HEARTBEATS_END_S), (dark, last + LASER_ENDS_S)]
        self.assert_soon_enough(run)

    def test_a_killed_program_leaves_the_laser_off(self):
        def run():
            self.start(3, "-o", self.folder / "a.pcap")
            killed = time.monotonic()
            self.dump.send(signal.SIGKILL)
            return [(self.wait_for_darkness(), killed + LASER_ENDS_S)]
        self.assert_soon_enough(run)

    def test_a_killed_lumctl_heartbeat_leaves_the_laser_off(self):
        def run():
            self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address="127.30.0.4")
            beat = tool(self, self.folder, "lumctl", "--host", "127.30.0.4", "heartbeat")
            wait_until(lambda: self.sensor.events("heartbeat"), "a heartbeat")
            on = tool(self, self.folder, "lumctl", "--host", "127.30.0.4", "laser", "on")
            self.assertEqual(on.wait(), 0, on.stderr())
            killed = time.monotonic()
            beat.send(signal.SIGKILL)
            return [(self.wait_for_darkness(), killed + LASER_ENDS_S)]
        self.assert_soon_enough(run)

    def test_after_a_pause_the_laser_stays_off(self):
        self.start(5, "-o", self.folder / "a.pcap")
        self.dump.send(signal.SIGSTOP)
        self.wait_for_darkness()
        before = len(self.sensor.events("heartbeat"))
        self.dump.send(signal.SIGCONT)
        wait_until(lambda: len(self.sensor.events("heartbeat")) > before + 5, "heartbeats")
        self.assertFalse(self.sensor.laser_is_up())
        self.dump.end(signal.SIGINT)

    def start_with_hazard(self, last, hazard="fan", begun=True):
        """A sensor whose hazard, begun or not, waits for a signal, and a recording that wants the laser."""
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", "--fault", f"{hazard}@USR1-USR2",
                             address=f"127.30.0.{last}")
        if begun:
            self.sensor.cue(signal.SIGUSR1)
        self.dump = tool(self, self.folder, "lumdump", f"udp://127.30.0.{last}", "--laser", "-o", self.folder / "a.pcap")

    def wait_for_heartbeats(self, n=10):
        """So long that a laser would have come up."""
        before = len(self.sensor.events("heartbeat"))
        wait_until(lambda: len(self.sensor.events("heartbeat")) > before + n, "heartbeats")

    def end_hazard_and_recording(self):
        self.sensor.cue(signal.SIGUSR2)
        self.wait_for_heartbeats()
        self.wait_for_data()
        self.assertEqual(self.dump.end(signal.SIGINT), 0, self.dump.stderr())

    def test_the_end_of_a_hazard_does_not_bring_the_laser_back(self):
        for last, hazard in ((12, "fan"), (13, "interlock")):
            with self.subTest(hazard):
                self.start_with_hazard(last, hazard, begun=False)
                wait_until(self.sensor.laser_is_up, "the laser")
                self.sensor.cue(signal.SIGUSR1)
                wait_until(lambda: self.heard("d"), "laser off")
                self.end_hazard_and_recording()
                self.assertEqual([e["up"] for e in self.sensor.events("laser")], [True, False])

    def test_a_laser_that_a_hazard_refused_does_not_come_up_at_its_end(self):
        self.start_with_hazard(14, "interlock")
        wait_until(lambda: self.heard("d"), "laser off")
        self.end_hazard_and_recording()
        self.assertEqual(self.sensor.events("laser"), [])

    def heard(self, command):
        """Each once however often it was sent: a busy machine answers late."""
        return list({(e["from"], e["sequence"]): e for e in self.sensor.events("tlv") if e.get("note") == command}.values())

    def test_after_a_hazard_a_person_can_switch_on_again(self):
        self.start_with_hazard(15)
        wait_until(lambda: self.heard("d"), "laser off")
        self.sensor.cue(signal.SIGUSR2)
        on = tool(self, self.folder, "lumctl", "--host", "127.30.0.15", "laser", "on")
        self.assertEqual(on.wait(), 0, on.stderr())
        self.wait_for_heartbeats()
        self.wait_for_data()
        self.assertEqual([e["up"] for e in self.sensor.events("laser")], [True])
        self.assertEqual(self.dump.end(signal.SIGINT), 0, self.dump.stderr())
        self.assertIn("is on", self.dump.stderr())
        self.assertFalse(self.sensor.laser_is_up())

    def test_what_a_hazard_refused_to_another_program_does_not_stand(self):
        self.start_with_hazard(16)
        wait_until(lambda: self.heard("d"), "laser off")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(MAGIC + struct.pack("<IIHH", 7, 1, 1, 1) + b"u", ("127.30.0.16", 5517))
        wait_until(lambda: len(self.heard("u")) == 2 and len(self.heard("d")) == 2, "laser off again")
        self.end_hazard_and_recording()
        self.assertEqual(self.sensor.events("laser"), [])

    def test_a_stalled_reader_does_not_turn_the_laser_off(self):
        reader = subprocess.Popen(["sleep", "1000"], stdin=subprocess.PIPE)
        self.addCleanup(reader.wait)
        self.addCleanup(reader.kill)
        self.addCleanup(reader.stdin.close)
        self.start(6, "-o", "-", "--format", "csv", stdout=reader.stdin)
        self.wait_for_heartbeats(25)  # in longer than the sensor waits for them
        self.assertTrue(self.sensor.laser_is_up())
        self.dump.end(signal.SIGINT)
        self.assertFalse(self.sensor.laser_is_up())

    def test_a_stalled_disk_does_not_turn_the_laser_off(self):
        fifo = self.folder / "disk.pcap"
        os.mkfifo(fifo)
        reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)  # open, and never read
        self.addCleanup(os.close, reader)
        self.start(7, "-o", fifo)
        self.wait_for_heartbeats(25)
        self.assertTrue(self.sensor.laser_is_up())
        self.dump.end(signal.SIGINT)
        self.assertFalse(self.sensor.laser_is_up())

    def test_every_way_out_switches_the_laser_off(self):
        ways = ((8, ["--duration", "2", "-o", self.folder / "b.ply"], None),
                (10, ["-o", self.folder / "c.csv"], signal.SIGTERM), (11, ["-o", self.folder / "d.csv"], signal.SIGHUP))
        for last, arguments, number in ways:
            with self.subTest(arguments=arguments, signal=number):
                address = f"127.30.0.{last}"
                sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=address)
                dump = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", *arguments)
                wait_until(lambda: [e for e in sensor.events("laser") if e["up"]], "the laser")
                if number is not None:
                    dump.send(number)
                dump.wait()
                self.assertFalse(sensor.laser_is_up())
                # By a command, not by the sensor's timeout.
                off = sensor.events("laser")[-1]["t"]
                statuses = [e for e in sensor.events("status") if e["t"] <= off + 1e-5]
                self.assertNotIn("HEARTBEAT_TIMEOUT", statuses[-1]["bits"])
                self.assertTrue([e for e in sensor.events("tlv") if e.get("note") == "d"])


def deaf(*numbers):
    """What a shell without job control does to what it runs in the background, and worse: signals ignored and blocked."""
    def prepare():
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    return prepare


class Inherited(unittest.TestCase):
    """Signals end what keeps a laser on, whatever they were when it began."""

    def setUp(self):
        self.folder = Folder(self)

    def sensor_at(self, last):
        self.address = f"127.30.1.{last}"
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=self.address)
        return self.sensor

    def start(self, command, *numbers, **options):
        p = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                             preexec_fn=deaf(*numbers), **options)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        return p

    def wait_for_laser(self):
        wait_until(self.sensor.laser_is_up, "the laser")

    def switch_on(self):
        """Once there are heartbeats."""
        wait_until(lambda: self.sensor.events("heartbeat"), "a heartbeat")
        on = tool(self, self.folder, "lumctl", "--host", self.address, "laser", "on")
        self.assertEqual(on.wait(), 0, on.stderr())
        self.wait_for_laser()

    def wait_for_data(self, name):
        """A recording that ends before any data came has status 3."""
        path = self.folder / name
        wait_until(lambda: path.exists() and path.stat().st_size > 1000, "data")

    def assert_ends(self, p, number, status=0):
        p.send_signal(number)
        self.assertEqual(p.wait(PATIENCE_S), status)
        wait_until(lambda: not self.sensor.laser_is_up(), "the end of the laser")

    def test_a_recording(self):
        self.sensor_at(1)
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGQUIT:
            with self.subTest(number):
                name = f"{number.name}.pcap"
                p = self.start([BIN / "lumdump", "-q", f"udp://{self.address}", "--laser", "-o", self.folder / name],
                               signal.SIGINT, signal.SIGTERM, signal.SIGQUIT)
                self.wait_for_laser()
                self.wait_for_data(name)
                self.assert_ends(p, number)

    def test_a_recording_whose_laser_another_program_switched_on(self):
        self.sensor_at(2)
        p = self.start([BIN / "lumdump", "-q", f"udp://{self.address}", "-o", self.folder / "a.pcap"], signal.SIGINT)
        self.switch_on()
        self.wait_for_data("a.pcap")
        self.assert_ends(p, signal.SIGINT)

    @unittest.skipUnless((BIN / "lumview").exists(), "lumview is not built")
    def test_a_viewer(self):
        self.sensor_at(3)
        for number in signal.SIGINT, signal.SIGQUIT:
            with self.subTest(number):
                p = self.start([BIN / "lumview", "-q", "--laser", f"udp://{self.address}"], signal.SIGINT, signal.SIGQUIT)
                self.wait_for_laser()
                self.assert_ends(p, number)

    def test_heartbeats_alone(self):
        self.sensor_at(4)
        for number in signal.SIGINT, signal.SIGQUIT:
            with self.subTest(number):
                beats = len(self.sensor.events("heartbeat"))
                p = self.start([BIN / "lumctl", "--host", self.address, "heartbeat"], signal.SIGINT, signal.SIGQUIT)
                wait_until(lambda: len(self.sensor.events("heartbeat")) > beats, "a heartbeat")
                self.switch_on()
                self.assert_ends(p, number)

    def test_a_shell(self):
        self.sensor_at(5)
        for number in signal.SIGTERM, signal.SIGQUIT:
            with self.subTest(number):
                p = self.start([BIN / "lumctl", "--host", self.address, "--heartbeat", "shell"], signal.SIGTERM,
                               signal.SIGQUIT, stdin=subprocess.PIPE)
                self.addCleanup(p.stdin.close)
                p.stdin.write(b"laser on\n")
                p.stdin.flush()
                self.wait_for_laser()
                beats = len(self.sensor.events("heartbeat"))  # by then the answer has come: a command is died of
                wait_until(lambda beats=beats: len(self.sensor.events("heartbeat")) > beats + 6, "heartbeats")
                self.assert_ends(p, number)

    def test_a_hang_up_stays_as_nohup_made_it(self):
        self.sensor_at(6)
        p = self.start([BIN / "lumdump", "-q", f"udp://{self.address}", "--laser", "-o", self.folder / "a.pcap"], signal.SIGHUP)
        self.wait_for_laser()
        self.wait_for_data("a.pcap")
        p.send_signal(signal.SIGHUP)
        beats = len(self.sensor.events("heartbeat"))
        wait_until(lambda: len(self.sensor.events("heartbeat")) > beats + 5, "heartbeats")
        self.assertTrue(self.sensor.laser_is_up())
        self.assert_ends(p, signal.SIGINT)

    def test_a_script_that_is_broken_off(self):
        """Ctrl-C goes to all of a terminal's processes; sh has made the recording deaf to it."""
        self.sensor_at(7)
        script = self.folder.write("bench.sh", f"'{BIN}/lumdump' -q udp://{self.address} --laser -o '{self.folder.path}/night.pcap' &\n"
                                               f"echo $! >'{self.folder.path}/pid'\nwait\n")
        p = subprocess.Popen(["sh", script], start_new_session=True)
        self.addCleanup(p.wait)
        self.addCleanup(lambda: p.poll() is None and os.killpg(p.pid, signal.SIGKILL))
        self.wait_for_laser()
        os.killpg(p.pid, signal.SIGINT)
        recording = (self.folder / "pid").read_text().strip()
        wait_until(lambda: not os.path.exists(f"/proc/{recording}"), "the end of the recording")
        self.assertFalse(self.sensor.laser_is_up())
        self.assertTrue([e for e in self.sensor.events("tlv") if e.get("note") == "d"])


if __name__ == "__main__":
    shards.main()
