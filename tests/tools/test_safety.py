#!/usr/bin/env python3
"""The laser goes off when nobody listens any more. All times are those of the sensor's own log, of one monotonic
clock."""
import os
import signal
import subprocess
import unittest

import shards
from live import Sensor, wait_until
from support import BIN, PATIENCE_S, Folder


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

    @unittest.skipUnless((BIN / "lumview").exists(), "lumview is not built")
    def test_a_viewer(self):
        self.sensor_at(3)
        for number in signal.SIGINT, signal.SIGQUIT:
            with self.subTest(number):
                p = self.start([BIN / "lumview", "-q", "--laser", f"udp://{self.address}"], signal.SIGINT, signal.SIGQUIT)
                self.wait_for_laser()
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
        quiet = subprocess.DEVNULL  # nobody waits for a pipe that the recording has too
        p = subprocess.Popen(["sh", script], start_new_session=True, stdin=quiet, stdout=quiet, stderr=quiet)
        self.addCleanup(p.wait)
        self.addCleanup(end_all_of, p)
        self.wait_for_laser()
        os.killpg(p.pid, signal.SIGINT)
        recording = (self.folder / "pid").read_text().strip()
        wait_until(lambda: not os.path.exists(f"/proc/{recording}"), "the end of the recording")
        self.assertFalse(self.sensor.laser_is_up())
        self.assertTrue([e for e in self.sensor.events("tlv") if e.get("note") == "d"])


def end_all_of(process):
    """Its group outlives it."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


if __name__ == "__main__":
    shards.main()
