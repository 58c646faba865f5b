#!/usr/bin/env python3
"""Two hosts, and between them a wire that loses, delays, reorders and repeats: the story of the bench guide."""
import json
import pathlib
import signal
import subprocess
import time
import unittest

from live import Hosts, Sensor, needs_namespaces, wait_until
from support import Folder, run

SETTINGS = pathlib.Path(__file__).resolve().parents[2] / "calib" / "settings.yaml"

BAD_WIRE = ["--loss", "0.03", "--duplicate", "0.03", "--reorder", "0.05", "--delays", "0.02", "--delay", "0.02"]
WORSE_WIRE = ["--loss", "0.35", "--duplicate", "0.2", "--reorder", "0.2", "--delays", "0.3", "--delay", "0.15"]

# What depends on when and where it was counted, and not on what came.
OF_THE_RUN = {"source", "seconds", "first", "last", "records", "packets_per_second", "points_per_second",
              "frames_per_second"}


def counts(summary):
    return {k: v for k, v in summary.items() if isinstance(v, int) and not isinstance(v, bool) and k not in OF_THE_RUN}


@needs_namespaces
class Story(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def sensor(self, hosts, *arguments):
        return Sensor(self, self.folder, *arguments, address="10.42.0.37", namespace=hosts.sensor)

    def carried_out(self, sensor, text):
        """How often the sensor's log says that it did a command."""
        return sum(text in e.get("note", "").replace(";", " ").split() for e in sensor.events("tlv"))

    def test_a_drive_is_recorded_and_its_summary_is_that_of_what_the_wire_forwarded(self):
        forwarded = self.folder / "forwarded.pcap"
        hosts = Hosts(self, self.folder, relay=["--seed", "5", "--record", forwarded, *BAD_WIRE])
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "2")

        status = hosts.run("lumctl", "status", "--json")
        self.assertEqual(status.returncode, 0, status.stderr)
        self.assertTrue(json.loads(status.stdout)["idle"])
        self.assertEqual(hosts.run("lumctl", "time").returncode, 0)

        drive = self.folder / "drive.pcap"
        cloud = self.folder / "drive.csv"
        dump = hosts.start("lumdump", "udp://10.42.0.37", "-o", drive, "-o", cloud, "--json")
        wait_until(lambda: sensor.events("stream"), "the stream")
        on = hosts.run("lumctl", "laser", "on")
        self.assertEqual(on.returncode, 0, on.stderr)
        self.assertTrue(sensor.laser_is_up())
        for words, text in ((("power", "80"), "80p"), (("threshold", "green", "40"), "40g"), (("holdoff", "180"), "180h")):
            r = hosts.run("lumctl", *words)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertGreaterEqual(self.carried_out(sensor, text), 1)
        wait_until(lambda: drive.stat().st_size > 4_000_000, "the drive")
        sensor.end()  # nothing is on its way any more when the recording ends
        time.sleep(0.5)
        self.assertEqual(dump.end(signal.SIGINT), 0, dump.stderr())
        relay = hosts.end_relay()
        for what in ("lost", "repeated", "reordered", "delayed"):
            self.assertGreater(relay["to_client"][what], 0)

        live = json.loads(dump.stdout())
        self.assertEqual(live["kernel_drops"], 0)
        self.assertEqual(live["ring_drops"], 0)
        self.assertGreater(live["points"], 10000)
        for other in (forwarded, drive):
            recorded = json.loads(run("lumdump", other, "--json").stdout)
            common = counts(recorded)
            self.assertEqual({k: live[k] for k in common}, common, other)
        self.assertEqual(len(cloud.read_bytes().splitlines()) - 1, live["points"])

    def test_the_bench_guide_runs_from_the_first_look_to_the_end(self):
        hosts = Hosts(self, self.folder, relay=["--seed", "7", *BAD_WIRE])
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "2")

        def ok(name, *words, **options):
            r = hosts.run(name, *words, **options)
            self.assertEqual(r.returncode, 0, (words, r.stdout, r.stderr))
            return r

        # The wire loses packets, which doctor finds; all else is fine.
        report = json.loads(hosts.run("lumctl", "doctor", "--json").stdout)
        self.assertLessEqual({c["name"] for c in report["checks"] if c["result"] == "wrong"}, {"loss", "buffer"})
        ok("lumctl", "status")
        ok("lumctl", "time")
        ok("lumdump", "udp://10.42.0.37", "--duration", "1")
        ok("lumdump", "udp://10.42.0.37", "--laser", "--duration", "2", "-o", self.folder / "cloud.ply")
        self.assertGreater((self.folder / "cloud.ply").stat().st_size, 100_000)
        self.assertFalse(sensor.laser_is_up())

        dump = hosts.start("lumdump", "udp://10.42.0.37", "-o", self.folder / "drive.pcap", "--rotate", "2s")
        wait_until(lambda: sensor.events("stream")[-1]["to"] and dump.p.poll() is None, "the stream")
        ok("lumctl", "laser", "on")
        ok("lumctl", "power", "60")
        ok("lumctl", "threshold", "green", "40")
        ok("lumctl", "lines", "64")
        ok("lumctl", "yscan", "15")
        ok("lumctl", "yscan", "--shape", "gaussian:-3:4", "--lines", "64")
        ok("lumctl", "apply", SETTINGS)
        ok("lumctl", "status", "--watch", "--duration", "1")
        for text in ("60p", "40g", "15y"):
            self.assertGreaterEqual(self.carried_out(sensor, text), 1, text)
        wait_until(lambda: len([n for n in self.folder.names() if n.startswith("drive-")]) > 1, "a second file")
        ok("lumctl", "laser", "off")
        self.assertFalse(sensor.laser_is_up())
        self.assertEqual(dump.end(signal.SIGINT), 0, dump.stderr())
        parts = [n for n in self.folder.names() if n.startswith("drive-")]
        self.assertGreater(len(parts), 1)
        for part in parts:
            self.assertEqual(run("lumdump", self.folder / part, "--json").returncode, 0, part)

        shell = hosts.start("lumctl", "shell", "--heartbeat", stdin=subprocess.PIPE)
        shell.p.stdin.write(b"status\nlaser on\n50p\n")
        shell.p.stdin.close()
        self.assertEqual(shell.wait(), 0, shell.stderr())
        self.assertGreaterEqual(self.carried_out(sensor, "50p"), 1)
        self.assertFalse(sensor.laser_is_up())

    def test_a_command_is_done_only_if_the_sensor_did_it(self):
        hosts = Hosts(self, self.folder, relay=["--seed", "11", *WORSE_WIRE])
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "0.5")
        done = failed = 0
        for value in range(20, 45):
            r = hosts.run("lumctl", "--timeout", "200", "--retries", "1", "power", str(value))
            if r.returncode == 0:
                done += 1
                self.assertGreaterEqual(self.carried_out(sensor, f"{value}p"), 1, r.stdout)
            else:
                failed += 1
                self.assertEqual(r.returncode, 3, r.stderr)
        self.assertGreater(done, 0)
        self.assertGreater(failed, 0)

    def test_laser_off_never_leaves_it_on(self):
        hosts = Hosts(self, self.folder, relay=["--seed", "3", *WORSE_WIRE])
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "0.5")
        beat = hosts.start("lumctl", "heartbeat", "--rate", "10")
        wait_until(lambda: sensor.events("stream"), "the stream")
        seen = 0
        for _ in range(8):
            hosts.run("lumctl", "--timeout", "150", "laser", "on")
            off = hosts.run("lumctl", "--timeout", "150", "laser", "off")
            ended = time.monotonic()
            if off.returncode == 0:
                seen += 1
                time.sleep(0.3)  # what is still on its way
                self.assertFalse(sensor.laser_is_up(), sensor.events("laser"))
                self.assertFalse([e for e in sensor.events("laser", after=ended) if e["up"]])
            else:
                self.assertIn(off.returncode, (1, 3))
                self.assertIn("laser", off.stderr)
        self.assertGreater(seen, 0)
        self.assertEqual(beat.end(signal.SIGINT), 0)

    def test_laser_off_succeeds_though_half_of_all_packets_are_lost(self):
        hosts = Hosts(self, self.folder, relay=["--seed", "6", "--loss", "0.5"])
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "0.5")
        beat = hosts.start("lumctl", "heartbeat", "--rate", "20")
        wait_until(lambda: sensor.events("stream"), "the stream")
        for _ in range(12):
            hosts.run("lumctl", "--timeout", "100", "--retries", "30", "send", "u")
            off = hosts.run("lumctl", "laser", "off")
            self.assertEqual(off.returncode, 0, off.stderr)
            self.assertFalse(sensor.laser_is_up())
        self.assertEqual(beat.end(signal.SIGINT), 0)
        for _ in range(3):
            dump = hosts.run("lumdump", "udp://10.42.0.37", "--laser", "--duration", "1", "--json")
            self.assertEqual(json.loads(dump.stdout)["laser"], "off", dump.stderr)
            self.assertFalse(sensor.laser_is_up())

    def test_set_ip_moves_the_sensor_and_proves_it(self):
        hosts = Hosts(self, self.folder, relay=["--seed", "2", *BAD_WIRE])
        hosts.ip("-n", hosts.sensor, "addr", "add", "10.42.0.99/24", "dev", "eth0")
        sensor = self.sensor(hosts, "--lines", "64", "--rate", "0.5")
        r = hosts.run("lumctl", "set-ip", "10.42.0.99")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertTrue(sensor.events("move"))
        self.assertIn("10.42.0.37", r.stdout + r.stderr)  # where it boots
        self.assertEqual(hosts.run("lumctl", "--host", "10.42.0.99", "status").returncode, 0)


if __name__ == "__main__":
    unittest.main()
