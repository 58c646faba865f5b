#!/usr/bin/env python3
"""The laser goes off when nobody listens any more. All times are those of the sensor's own log, of one monotonic
clock."""
import os
import signal
import subprocess
import time
import unittest

import shards
from live import Sensor, tool, wait_until
from support import Folder

HEARTBEATS_END_S = 2.5
LASER_ENDS_S = 3.2


class Safety(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def start(self, last, *arguments, **options):
        """A sensor, and a recording with the laser on."""
        address = f"127.30.0.{last}"
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=address)
        self.dump = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", *arguments, **options)
        wait_until(self.sensor.laser_is_up, 20, "the laser")

    def wait_for_darkness(self):
        wait_until(lambda: not self.sensor.laser_is_up(), 10, "the end of the laser")
        return self.sensor.events("laser")[-1]["t"]

    def last_heartbeat(self):
        return self.sensor.events("heartbeat")[-1]["t"]

    def test_heartbeats_come_several_times_a_second(self):
        self.start(1, "-o", self.folder / "a.pcap")
        time.sleep(2)
        times = [e["t"] for e in self.sensor.events("heartbeat")]
        self.assertGreaterEqual(len(times), 8)
        self.assertLess(max(b - a for a, b in zip(times, times[1:])), 1.0)
        self.assertEqual(self.dump.end(signal.SIGINT), 0, self.dump.stderr())
        self.assertFalse(self.sensor.laser_is_up())

    def test_a_stopped_program_stops_its_heartbeats(self):
        self.start(2, "-o", self.folder / "a.pcap")
        self.dump.send(signal.SIGSTOP)
        stopped = time.monotonic()
        dark = self.wait_for_darkness()
        self.assertLess(self.last_heartbeat(), stopped + HEARTBEATS_END_S)
        self.assertLess(dark, self.last_heartbeat() + LASER_ENDS_S)

    def test_a_killed_program_leaves_the_laser_off(self):
        self.start(3, "-o", self.folder / "a.pcap")
        self.dump.send(signal.SIGKILL)
        killed = time.monotonic()
        self.assertLess(self.wait_for_darkness(), killed + LASER_ENDS_S)

    def test_a_killed_lumctl_heartbeat_leaves_the_laser_off(self):
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address="127.30.0.4")
        beat = tool(self, self.folder, "lumctl", "--host", "127.30.0.4", "heartbeat")
        wait_until(lambda: self.sensor.events("heartbeat"), 10, "a heartbeat")
        on = tool(self, self.folder, "lumctl", "--host", "127.30.0.4", "laser", "on")
        self.assertEqual(on.wait(), 0, on.stderr())
        beat.send(signal.SIGKILL)
        killed = time.monotonic()
        self.assertLess(self.wait_for_darkness(), killed + LASER_ENDS_S)

    def test_after_a_pause_the_laser_stays_off(self):
        self.start(5, "-o", self.folder / "a.pcap")
        self.dump.send(signal.SIGSTOP)
        self.wait_for_darkness()
        before = len(self.sensor.events("heartbeat"))
        self.dump.send(signal.SIGCONT)
        wait_until(lambda: len(self.sensor.events("heartbeat")) > before + 5, 10, "heartbeats")
        self.assertFalse(self.sensor.laser_is_up())
        self.dump.end(signal.SIGINT)

    def test_a_stalled_reader_does_not_turn_the_laser_off(self):
        reader = subprocess.Popen(["sleep", "60"], stdin=subprocess.PIPE)
        self.addCleanup(reader.wait)
        self.addCleanup(reader.kill)
        self.addCleanup(reader.stdin.close)
        self.start(6, "-o", "-", "--format", "csv", stdout=reader.stdin)
        begin = time.monotonic()
        time.sleep(5)  # longer than the sensor waits for heartbeats
        self.assertTrue(self.sensor.laser_is_up())
        self.assertGreater(len(self.sensor.events("heartbeat", after=begin)), 15)
        self.dump.end(signal.SIGINT)
        self.assertFalse(self.sensor.laser_is_up())

    def test_a_stalled_disk_does_not_turn_the_laser_off(self):
        fifo = self.folder / "disk.pcap"
        os.mkfifo(fifo)
        reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)  # open, and never read
        self.addCleanup(os.close, reader)
        self.start(7, "-o", fifo)
        begin = time.monotonic()
        time.sleep(5)
        self.assertTrue(self.sensor.laser_is_up())
        self.assertGreater(len(self.sensor.events("heartbeat", after=begin)), 15)
        self.dump.end(signal.SIGINT)
        self.assertFalse(self.sensor.laser_is_up())

    def test_every_way_out_switches_the_laser_off(self):
        ways = ((8, ["--duration", "1", "-o", self.folder / "b.ply"], None),
                (10, ["-o", self.folder / "c.csv"], signal.SIGTERM), (11, ["-o", self.folder / "d.csv"], signal.SIGHUP))
        for last, arguments, number in ways:
            with self.subTest(arguments=arguments, signal=number):
                address = f"127.30.0.{last}"
                sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=address)
                dump = tool(self, self.folder, "lumdump", f"udp://{address}", "--laser", *arguments)
                wait_until(lambda: [e for e in sensor.events("laser") if e["up"]], 20, "the laser")
                if number is not None:
                    dump.send(number)
                dump.wait(30)
                self.assertFalse(sensor.laser_is_up())
                # By a command, not by the sensor's timeout.
                beats = sensor.events("heartbeat")[-1]["t"]
                self.assertLess(sensor.events("laser")[-1]["t"], beats + 2.0)


if __name__ == "__main__":
    shards.main()
