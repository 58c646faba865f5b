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
from support import MAGIC, Folder

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

    def record_through(self, last, *arguments, seconds=6.5):
        """A recording through the faults of a sensor, to its end; the times at which the laser went up."""
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", *arguments, address=f"127.30.0.{last}")
        dump = tool(self, self.folder, "lumdump", f"udp://127.30.0.{last}", "--laser", "--duration", str(seconds), "-q", "-o",
                    self.folder / "a.pcap")
        self.assertEqual(dump.wait(30), 0, dump.stderr())
        faults = self.sensor.events("fault")
        self.assertEqual([e["ends"] for e in faults], [False, True])
        # the end of the hazard is seen for longer than a laser takes to come up
        self.assertGreater(self.sensor.events("heartbeat")[-1]["t"], faults[-1]["t"] + 1)
        return [e["t"] for e in self.sensor.events("laser") if e["up"]], faults

    def test_the_end_of_a_hazard_does_not_bring_the_laser_back(self):
        for last, fault, end in ((12, "fan", 5), (13, "interlock", 3.1)):
            with self.subTest(fault):
                ups, faults = self.record_through(last, "--fault", f"{fault}@3-{end}")
                self.assertEqual(len(ups), 1)
                self.assertLess(ups[0], faults[0]["t"])
                self.assertFalse(self.sensor.laser_is_up())

    def test_a_laser_that_a_hazard_refused_does_not_come_up_at_its_end(self):
        ups, _ = self.record_through(14, "--fault", "interlock@0-5", seconds=9)
        self.assertEqual(ups, [], [self.sensor.events(what) for what in ("tlv", "laser", "fault")])

    def test_after_a_hazard_a_person_can_switch_on_again(self):
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", "--fault", "fan@0-5", address="127.30.0.15")
        dump = tool(self, self.folder, "lumdump", "udp://127.30.0.15", "--laser", "-o", self.folder / "a.pcap")
        wait_until(lambda: self.sensor.events("heartbeat"), 30, "a heartbeat")
        wait_until(lambda: len(self.sensor.events("fault")) == 2, 10, "the end of the hazard")
        on = tool(self, self.folder, "lumctl", "--host", "127.30.0.15", "laser", "on")
        self.assertEqual(on.wait(), 0, on.stderr())
        before = len(self.sensor.events("heartbeat"))
        wait_until(lambda: len(self.sensor.events("heartbeat")) > before + 10, 10, "heartbeats")
        self.assertEqual([e["up"] for e in self.sensor.events("laser")], [True])
        self.assertEqual(dump.end(signal.SIGINT), 0, dump.stderr())
        self.assertIn("is on", dump.stderr())
        self.assertFalse(self.sensor.laser_is_up())

    def test_what_a_hazard_refused_to_another_program_does_not_stand(self):
        self.sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", "--fault", "fan@0-5", address="127.30.0.16")
        dump = tool(self, self.folder, "lumdump", "udp://127.30.0.16", "--laser", "-o", self.folder / "a.pcap")

        def heard(command):
            return [e for e in self.sensor.events("tlv") if e.get("note") == command]

        wait_until(lambda: heard("d"), 10, "laser off")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(MAGIC + struct.pack("<IIHH", 7, 1, 1, 1) + b"u", ("127.30.0.16", 5517))
        wait_until(lambda: len(heard("u")) == 2 and len(heard("d")) == 2, 10, "laser off again")
        end = wait_until(lambda: [e for e in self.sensor.events("fault") if e["ends"]], 10, "the end of the hazard")
        wait_until(lambda: len(self.sensor.events("heartbeat", after=end[0]["t"])) > 8, 10, "heartbeats")
        self.assertEqual(self.sensor.events("laser"), [])
        self.assertEqual(dump.end(signal.SIGINT), 0, dump.stderr())

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
