#!/usr/bin/env python3
"""lumctl doctor: what it finds, what it says of it, and that its mends mend."""
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import unittest

import shards
from live import HERE, Hosts, Process, Sensor, inside, needs_namespaces, wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder, angles, run

NAMES = ["interface", "route", "arp", "port", "session", "firewall", "buffer", "mtu", "answer", "data", "layout", "loss",
         "strangers", "clock", "status"]
WIRE = ["data", "layout", "loss", "strangers", "clock", "status"]
HEARTBEAT = MAGIC + struct.pack("<I", 8)

is_root = os.geteuid() == 0
needs_root = unittest.skipUnless(is_root, "only root may become another user")
needs_nft = unittest.skipUnless(is_root and shutil.which("nft", path="/usr/sbin:/sbin:/usr/bin"), "nft is not installed")

# As well as answers of a busy host can tell it.
FIVE_PERCENT_FASTER = r"\b([3-6]\d|7[0-4])\d\d\d ppm faster"
NET = f"127.35.{shards.index()}."  # tests that run side by side do not share addresses


# A busy machine that is held up loses what the queue between two hosts cannot hold; with fewer frames a second it holds more.
CALM = ["--rate", "4"]


class Findings:
    """What the doctor said, by check."""

    def __init__(self, r):
        self.status, self.error = r.returncode, r.stderr
        said = json.loads(r.stdout)
        self.overall = said["overall"]
        self.names = [c["name"] for c in said["checks"]]
        self.of = {c["name"]: c for c in said["checks"]}

    def __getitem__(self, name):
        return self.of[name]["result"]

    def text(self, name):
        return self.of[name]["text"]

    def mend(self, name):
        return self.of[name]["mend"]

    def __str__(self):
        return "\n".join(f"{c['result']} {n}: {c['text']} [{c['mend']}]" for n, c in self.of.items())


class Fake(threading.Thread):
    """A sensor that answers as it is told to, on a loopback address. The first heartbeat brings the stream. slow: how long,
    in seconds, so many of four answers to timestamp requests are under way. answers_from: another port."""

    def __init__(self, test, address, speed=1.0, status=0x0200, stream=(), slow=0.0, slow_of_4=2, answers_from=None):
        super().__init__(daemon=True)
        self.speed, self.status, self.stream = speed, status, list(stream)
        self.slow, self.slow_of_4 = slow, slow_of_4
        self.heard = []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((address, 5517))
        self.socket.settimeout(0.1)
        self.answers_by = self.socket
        if answers_from is not None:
            self.answers_by = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.answers_by.bind((address, answers_from))
        self.begin = time.monotonic()
        self.ends = False
        test.addCleanup(self.end)
        self.start()

    def end(self):
        self.ends = True
        self.join()
        self.socket.close()
        self.answers_by.close()

    def clock(self):
        return int((time.monotonic() - self.begin) * 1e6 * self.speed) & 0xFFFFFFFF

    def answer(self, packet):
        kind = packet[8]
        if kind == 6:
            return MAGIC + struct.pack("<I", 6) + packet[12:16] + struct.pack("<I", self.clock())
        if kind == 7:
            return MAGIC + struct.pack("<I", 7) + packet[12:16] + struct.pack("<HHH", 2, 2, self.status)
        return None

    def run(self):
        while not self.ends:
            try:
                packet, client = self.socket.recvfrom(2048)
            except socket.timeout:
                continue
            self.heard.append(packet[8])
            reply = self.answer(packet)
            if reply is not None:
                if packet[8] == 6 and self.heard.count(6) % 4 >= 4 - self.slow_of_4:
                    time.sleep(self.slow)
                self.answers_by.sendto(reply, client)
            elif packet[8] == 8:
                self.send_stream(client)

    def send_stream(self, client):
        for count, packet in enumerate(self.stream):
            self.socket.sendto(packet, client)
            if count % 12 == 0:
                time.sleep(0.01)  # so that a small receive buffer lasts for a while
        self.stream = []


def lines(first, end, clock=1_000_000, without=()):
    """Data of both eyes, taking turns, without laser: three packets of angles for each line. without: (line, eye,
    packet) that are not there."""
    for line in range(first, end):
        of_eye = [list(angles(eye, line, clock + 500 * line)) for eye in (0, 1)]
        for part in range(3):
            for eye in (0, 1):
                if (line, eye, part) not in without:
                    yield of_eye[eye][part]


class Doctor(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def examine(self, address, *options):
        return Findings(run("lumctl", "--host", address, *options, "doctor", "--json"))

    def assert_fine(self, found, but=()):
        self.assertEqual((found.status, found.overall), (0, "fine"), str(found))
        self.assertEqual(found.names, NAMES)
        for name in NAMES:
            if name not in but:
                self.assertEqual(found[name], "fine", str(found))


class Loopback(Doctor):
    def sensor(self, *arguments, address=NET + "1"):
        return Sensor(self, self.folder, *CALM, *arguments, address=address)

    def test_a_simulator_is_all_fine(self):
        self.sensor()
        found = self.examine(NET + "1")
        # what only root or a tuned host may see is no fault
        self.assert_fine(found, but=("buffer", "loss"))
        self.assertIn("lumsim", found.text("port"))
        self.assertIn(NET + "1", found.text("route"))
        self.assertIn("host's rate", found.text("clock"))
        self.assertIn("laser down", found.text("status"))

    def test_it_only_looks(self):
        sensor = self.sensor()
        self.examine(NET + "1")
        kinds = {e["event"] for e in sensor.log()}
        self.assertLessEqual(kinds, {"start", "frames", "heartbeat", "reply", "status", "stream", "timestamp", "tlv"})
        notes = {e.get("note") for e in sensor.events("tlv")}
        self.assertEqual(len(notes), 1, notes)
        self.assertFalse(sensor.laser_is_up())
        beats = [e["t"] for e in sensor.events("heartbeat")]
        self.assertLess(beats[-1] - beats[0], 20.0)

    def test_people_get_a_line_for_each_check_and_a_verdict(self):
        self.sensor()
        r = run("lumctl", "--host", NET + "1", "doctor")
        lines = r.stdout.splitlines()
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        self.assertEqual([line.split()[1] for line in lines if line[2:7].strip()][:len(NAMES)], NAMES)
        self.assertEqual(lines[-1], NET + "1: nothing is wrong")
        self.assertNotIn("\033", r.stdout)

    def test_colours_are_for_terminals_that_want_them(self):
        for variables, coloured in (({}, True), ({"NO_COLOR": "1"}, False)):
            ours, theirs = pty.openpty()
            environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"} | {"TERM": "xterm"} | variables
            p = subprocess.Popen([str(BIN / "lumctl"), "--host", NET + "2", "doctor"], stdout=theirs,
                                 stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, env=environment)
            os.close(theirs)
            out = b""
            try:
                while chunk := os.read(ours, 4096):
                    out += chunk
            except OSError:
                pass
            os.close(ours)
            self.assertEqual(p.wait(PATIENCE_S), 1)
            self.assertEqual(b"\033[" in out, coloured, out)

    def test_nothing_that_listens_is_said_with_the_command_that_starts_a_simulator(self):
        found = self.examine(NET + "3")
        self.assertEqual((found.status, found.overall), (1, "wrong"), str(found))
        self.assertEqual(found["port"], "wrong")
        for name in WIRE:
            self.assertEqual(found[name], "not looked at")
            self.assertIn("nothing listens", found.text(name))

    def test_a_simulator_at_another_address_is_pointed_at(self):
        self.sensor(address=NET + "4")
        found = self.examine(NET + "5")
        self.assertEqual(found.status, 1)
        self.assertIn("lumsim", found.text("port"))
        self.assertRegex(found.mend("port"), r"^lumctl --host 127\.\d+\.\d+\.\d+( --port \d+)? doctor$")

    def test_a_session_of_this_host_keeps_its_data(self):
        sensor = self.sensor(address=NET + "6")
        Process(self, self.folder, BIN / "lumctl", "--host", NET + "6", "heartbeat")
        wait_until(lambda: sensor.events("heartbeat"), "a heartbeat")
        found = self.examine(NET + "6")
        self.assertEqual((found.status, found["session"]), (0, "note"), str(found))
        self.assertIn("lumctl (process", found.text("session"))
        for name in ("data", "layout", "loss", "strangers"):
            self.assertEqual(found[name], "not looked at")
            self.assertIn("another session", found.text(name))
        for name in ("answer", "clock", "status"):
            self.assertEqual(found[name], "fine")
        self.assertEqual(len({e["from"] for e in sensor.events("heartbeat")}), 1)

    def test_a_laser_that_another_host_drives_is_left_alone(self):
        sensor = self.sensor(address=NET + "7")
        other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(other.close)
        ends = threading.Event()

        def drive():
            other.sendto(MAGIC + struct.pack("<IIHH", 7, 1, 1, 1) + b"u", (NET + "7", 5517))
            while not ends.wait(0.2):
                other.sendto(HEARTBEAT, (NET + "7", 5517))

        other.sendto(HEARTBEAT, (NET + "7", 5517))
        driver = threading.Thread(target=drive)
        driver.start()
        self.addCleanup(driver.join)
        self.addCleanup(ends.set)
        wait_until(sensor.laser_is_up, "the laser")
        found = self.examine(NET + "7")
        self.assertEqual((found.status, found["answer"], found["data"]), (0, "note", "not looked at"), str(found))
        self.assertIn("another host", found.text("data"))
        self.assertEqual(len({e["from"] for e in sensor.events("heartbeat")}), 1)
        self.assertTrue(sensor.laser_is_up())

    def test_a_hazard_has_its_exit_status_its_name_and_its_mend(self):
        sensor = self.sensor("--fault", "fan@0", address=NET + "8")
        wait_until(lambda: sensor.events("status"), "the fault")
        found = self.examine(NET + "8")
        self.assertEqual((found.status, found.overall, found["status"]), (4, "hazard", "wrong"), str(found))
        self.assertIn("FAN_PWM_BAD", found.text("status"))
        self.assertIn("fan", found.mend("status"))

    def test_another_layout_is_told_from_a_sensor_without_data(self):
        profile = self.folder.write("other.yaml", "version: 1\ndata_packet_type: 9\n")
        self.sensor("--profile", profile, address=NET + "9")
        found = self.examine(NET + "9")
        self.assertEqual((found.status, found["data"], found["layout"]), (1, "fine", "wrong"), str(found))
        self.assertIn("type 9", found.text("layout"))
        self.assertEqual(found["loss"], "not looked at")
        commands = found.mend("layout").partition("#")[0].strip()
        self.assertEqual(commands, f"lumdump udp://{NET}9 --laser --duration 3 -o look.pcap; lumdump look.pcap --infer -o profile.yaml")
        r = subprocess.run(commands, shell=True, cwd=self.folder.path, capture_output=True, text=True, timeout=PATIENCE_S,
                           env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"})
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assert_fine(self.examine(NET + "9", "--profile", self.folder / "profile.yaml"), but=("buffer", "loss"))
        self.assert_fine(self.examine(NET + "9", "--profile", profile), but=("buffer", "loss"))

    def test_a_clock_at_another_place_of_the_packet_shows(self):
        profile = self.folder.write("other.yaml", "version: 1\ngroup: {timestamp: 24, samples: 28, line: 20, "
                                                  "num_samples: 16, first_sample_index: 18}\n")
        mine = self.folder.write("mine.yaml", "version: 1\ngroup: {timestamp: 20, samples: 28, line: 14}\n")
        self.sensor("--profile", profile, address=NET + "10")
        found = self.examine(NET + "10", "--profile", mine)
        self.assertEqual(found.status, 1, str(found))
        self.assertTrue("wrong" in (found["clock"], found["layout"]), str(found))

    def test_loss_on_the_wire_is_told_from_loss_in_the_kernel(self):
        self.sensor("--loss", "0.05", address=NET + "11")
        found = self.examine(NET + "11")
        self.assertEqual((found.status, found["loss"]), (1, "wrong"), str(found))
        self.assertIn("lost by the simulator", found.text("loss"))
        self.assertIn("the kernel dropped none", found.text("loss"))
        self.assertNotIn("cable", found.text("loss"))
        self.assertTrue(found.mend("loss").startswith(f"lumsim --address {NET}11 &"), found.mend("loss"))
        self.assertIn("--loss", found.mend("loss"))

    def test_what_was_under_way_at_the_beginning_is_no_loss(self):
        begun = [p for line in (5, 6) for eye in (0, 1) for p in list(angles(eye, line, 1_002_000 + 500 * line))[2:]]
        Fake(self, NET + "23", stream=begun + list(lines(7, 60, 1_002_000)))
        found = self.examine(NET + "23")
        self.assertEqual(found["loss"], "fine", str(found))
        self.assertGreater(int(found.text("loss").split()[0]), 80)

    def test_what_a_jump_of_the_clock_costs_is_no_loss(self):
        Fake(self, NET + "24", stream=[*lines(0, 40), *lines(40, 80, 11_000_000)])
        found = self.examine(NET + "24")
        self.assertEqual(found["loss"], "fine", str(found))
        self.assertGreater(int(found.text("loss").split()[0]), 100)

    def test_one_packet_that_is_missing_in_between_is_a_loss(self):
        Fake(self, NET + "25", stream=lines(0, 60, without=[(30, 1, 1)]))
        found = self.examine(NET + "25")
        self.assertEqual(found["loss"], "wrong", str(found))
        self.assertIn("1 without all angles, 0 more whole", found.text("loss"))

    def test_corruption_is_no_other_layout(self):
        self.sensor("--corrupt", "0.1", address=NET + "12")
        found = self.examine(NET + "12")
        self.assertEqual(found["layout"], "note", str(found))
        self.assertIn("corrupted", found.text("layout"))

    def test_a_silent_sensor_is_told_in_time(self):
        self.sensor("--fault", "silence@0", address=NET + "13")
        begin = time.monotonic()
        found = self.examine(NET + "13")
        self.assertEqual((found.status, found["answer"]), (3, "wrong"), str(found))
        self.assertIn("tcpdump", found.mend("answer"))
        self.assertEqual(found["firewall"], "not looked at")
        self.assertLess(time.monotonic() - begin, 120)

    def test_a_sensor_without_data_is_told(self):
        fake = Fake(self, NET + "14")
        found = self.examine(NET + "14")
        self.assertEqual((found.status, found["answer"], found["data"]), (1, "fine", "wrong"), str(found))
        self.assertIn("no data came", found.text("data"))
        self.assertEqual(found["layout"], "not looked at")
        self.assertEqual(found["status"], "fine")
        self.assertLessEqual(set(fake.heard), {6, 7, 8})

    def examine_clock(self, address):
        """Until answers came fast enough to tell its rate, which they do unless this machine is too busy."""
        for _ in range(10):
            found = self.examine(address)
            if "as far as answers so slow can tell" not in found.text("clock"):
                break
        return found

    def test_a_clock_that_runs_at_another_rate_is_told(self):
        Fake(self, NET + "15", speed=1.05)
        found = self.examine_clock(NET + "15")
        self.assertEqual((found.status, found["clock"]), (1, "wrong"), str(found))
        self.assertRegex(found.text("clock"), FIVE_PERCENT_FASTER)

    def test_a_host_that_was_held_up_is_no_wrong_clock_in_the_data(self):
        sensor = self.sensor(address=NET + "27")
        p = Process(self, self.folder, BIN / "lumctl", "--host", NET + "27", "doctor", "--json")
        wait_until(lambda: sensor.events("heartbeat"), "a heartbeat")
        time.sleep(0.5)
        p.send(signal.SIGSTOP)
        time.sleep(2.2)
        p.send(signal.SIGCONT)
        p.wait()
        found = {c["name"]: c for c in json.loads(p.stdout())["checks"]}
        self.assertEqual(found["data"]["result"], "fine", p.stdout())
        self.assertEqual(found["clock"]["result"], "fine", p.stdout())

    def test_a_rate_is_told_by_the_answers_that_came_at_once(self):
        Fake(self, NET + "26", speed=1.05, slow=0.12)
        found = self.examine_clock(NET + "26")
        self.assertEqual((found.status, found["clock"]), (1, "wrong"), str(found))
        self.assertRegex(found.text("clock"), FIVE_PERCENT_FASTER)

    def test_a_rate_by_slow_answers_alone_is_told_as_such(self):
        Fake(self, NET + "28", slow=0.05, slow_of_4=4)
        found = self.examine(NET + "28")
        self.assertEqual((found.status, found["clock"]), (1, "fine"), str(found))
        self.assertIn("as far as answers so slow can tell", found.text("clock"))

    def test_datagrams_of_others_are_noted(self):
        sensor = self.sensor(address=NET + "16")
        stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(stranger.close)
        p = Process(self, self.folder, BIN / "lumctl", "--host", NET + "16", "doctor", "--json")
        beat = wait_until(lambda: sensor.events("heartbeat"), "a heartbeat")[0]
        host, port = beat["from"].split(":")
        for _ in range(20):
            stranger.sendto(b"hello", (host, int(port)))
        self.assertEqual(p.wait(), 0)
        found = {c["name"]: c for c in json.loads(p.stdout())["checks"]}
        self.assertEqual(found["strangers"]["result"], "note")
        self.assertIn("20 datagrams", found["strangers"]["text"])

    def test_a_signal_ends_it_and_the_session_is_free(self):
        sensor = self.sensor(address=NET + "17")
        for _ in range(5):  # until the signal comes before the verdict, as it does unless this test is held up
            before = len(sensor.events("heartbeat"))
            p = Process(self, self.folder, BIN / "lumctl", "--host", NET + "17", "doctor")
            wait_until(lambda before=before: len(sensor.events("heartbeat")) > before, "a heartbeat")
            status = p.end(signal.SIGINT)
            if not re.search("(nothing|something) is wrong", p.stdout()):
                break
        self.assertEqual(status, -signal.SIGINT)
        self.assertNotRegex(p.stdout(), "(nothing|something) is wrong")
        self.assertEqual(self.examine(NET + "17")["session"], "fine")

    def test_troubleshooting_has_a_section_for_each_check(self):
        text = (HERE.parents[1] / "docs/troubleshooting.md").read_text()
        self.assertEqual([line[3:] for line in text.splitlines() if line.startswith("## ")][:len(NAMES)], NAMES)

    def test_words_and_options_that_it_cannot_have_are_refused(self):
        for arguments, says in ((("doctor", "now"), "now"), (("--dry-run", "doctor"), "--dry-run")):
            r = run("lumctl", "--host", NET + "18", *arguments)
            self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
            self.assertIn(says, r.stderr)

    def test_an_interface_that_is_not_there_is_named(self):
        found = self.examine(NET + "18", "--interface", "nowhere0")
        self.assertEqual((found.status, found["interface"]), (1, "wrong"), str(found))
        self.assertIn("nowhere0", found.text("interface"))
        self.assertIn("lo", found.text("interface"))
        self.assertEqual(found["route"], "not looked at")

    def test_a_full_disk_is_no_success(self):
        with open("/dev/full", "wb") as full:
            r = subprocess.run([str(BIN / "lumctl"), "--host", NET + "19", "doctor"], stdout=full,
                               stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 1)
        self.assertIn(b"standard output", r.stderr)

    def test_a_reader_that_leaves_ends_it_quietly(self):
        self.sensor(address=NET + "21")
        p = subprocess.Popen([str(BIN / "lumctl"), "--host", NET + "21", "doctor"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        p.stdout.readline()
        p.stdout.close()
        with p.stderr:
            self.assertEqual((p.stderr.read(), p.wait(PATIENCE_S)), (b"", 0))

    def test_a_shell_that_owns_the_sensor_keeps_it_meanwhile(self):
        sensor = self.sensor(address=NET + "22")
        p = Process(self, self.folder, BIN / "lumctl", "--host", NET + "22", "shell", "--heartbeat",
                    stdin=subprocess.PIPE)
        wait_until(lambda: sensor.events("heartbeat"), "a heartbeat")
        p.p.stdin.write(b"doctor\ndoctor\nquit\n")
        p.p.stdin.flush()
        p.wait()
        self.assertEqual(p.stdout().count("another session of this host"), 8, p.stdout() + p.stderr())
        beats = [e["t"] for e in sensor.events("heartbeat")]
        self.assertLess(max(b - a for a, b in zip(beats, beats[1:])), 3.0)  # then its laser would go off

    @needs_root
    def test_a_trace_is_refused_without_rights(self):
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        r = subprocess.run([copy, "--host", NET + "29", "doctor", "--trace"], capture_output=True, text=True, timeout=PATIENCE_S,
                           user=65534, group=65534, extra_groups=[])
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertIn("needs root: sudo lumctl doctor --trace", r.stderr)

    def test_a_trace_belongs_to_the_doctor_alone(self):
        r = run("lumctl", "--host", NET + "29", "status", "--trace")
        self.assertEqual((r.returncode, r.stdout), (2, ""))
        self.assertIn("--trace", r.stderr)

    def test_answers_from_another_port_are_told_from_silence(self):
        Fake(self, NET + "30", answers_from=6000)
        found = self.examine(NET + "30")
        self.assertEqual((found.status, found["answer"]), (1, "wrong"), str(found))
        self.assertIn("answers from port 6000 to what is sent to its port 5517", found.text("answer"))
        self.assertIn("tcpdump", found.mend("answer"))

    @needs_root
    def test_without_rights_it_says_what_it_could_not_look_at(self):
        self.sensor("--rate", "2", address=NET + "20")  # the receive buffer may be small
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        r = subprocess.run([copy, "--host", NET + "20", "doctor", "--json"], capture_output=True, text=True, timeout=PATIENCE_S,
                           user=65534, group=65534, extra_groups=[])
        found = Findings(r)
        self.assertEqual(found.status, 0, str(found))
        self.assertIn("root", found.text("port"))
        self.assertIn(found["buffer"], ("note", "fine"))
        for name in ("interface", "route", "firewall", "mtu", "answer", "data", "layout", "clock", "status"):
            self.assertEqual(found[name], "fine", str(found))


class OnHosts(Doctor):
    """The client's host is broken in one way, and mended by the very commands that the doctor gives."""

    def setUp(self):
        super().setUp()
        self.hosts = Hosts(self, self.folder)
        shim = self.folder / "bin"
        shim.mkdir()
        (shim / "sudo").write_text('#!/bin/sh\nexec "$@"\n')
        (shim / "sudo").chmod(0o755)
        self.environment = dict(os.environ, PATH=f"{shim}:{BIN}:{os.environ['PATH']}:/usr/sbin:/sbin")

    def sensor(self, *arguments):
        return Sensor(self, self.folder, *CALM, *arguments, address="10.42.0.37", namespace=self.hosts.sensor)

    def shell(self, command, timeout=None):
        """As it stands, on the client's host. One that does not end, since it only looks, is ended."""
        p = subprocess.Popen([*inside(self.hosts.client), "sh", "-ec", command], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, env=self.environment, start_new_session=True)
        try:
            out, _ = p.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(p.pid, signal.SIGKILL)
            out, _ = p.communicate()
        return p.returncode, out

    def client(self, command):
        status, out = self.shell(command)
        self.assertEqual(status, 0, f"{command}: {out}")

    def look(self, *options):
        return Findings(self.hosts.run("lumctl", *options, "doctor", "--json"))

    def broken(self, check, status=1, says="", *options):
        found = self.look(*options)
        self.assertEqual((found.status, found[check]), (status, "wrong"), str(found))
        self.assertIn(says, found.text(check))
        return found

    def link_shows(self, flag):
        """The kernel notices a cable a moment later."""
        def shows():
            return flag in Hosts.ip("-n", self.hosts.client, "link", "show", "eth0")
        wait_until(shows, flag)

    def other_interface(self, address):
        self.client("ip link add other0 type veth peer name other1; ip link set other1 up; ip link set other0 up;"
                    f"ip addr add {address} dev other0")

    def follow(self, mend):
        """Do what a mend says, to the letter. The options of the next look, where it is one."""
        if mend.endswith(" &"):
            name, option, address, *others = mend[:-2].split()
            self.assertEqual((name, option), ("lumsim", "--address"))
            Sensor(self, self.folder, *others, address=address, namespace=self.hosts.client)
            return None
        looks = re.match(r"(?:sudo )?lumctl (.*) doctor( --trace)?(?:    #.*)?$", mend)
        if looks:
            return looks[1].split() + (["--trace"] if looks[2] else [])
        changes = re.match(r"sudo (ip|nft|iptables-nft|iptables-legacy|sysctl) ", mend)
        status, out = self.shell(mend, timeout=None if changes else 1.0)
        if changes:
            self.assertEqual(status, 0, f"{mend}: {out}")
        return None

    def mended(self, found, check, options=(), says=""):
        """Each mend, of the first thing that is wrong, is done; in the end nothing is wrong, and the sensor answers. says:
        of the check, when it was looked at for the last time and was still wrong."""
        mends = [found.mend(check)]
        last = found.text(check)
        for _ in range(4):
            self.assertIsNotNone(mends[-1], str(found))
            options = self.follow(mends[-1]) or options
            self.link_shows("state UP")
            found = self.look(*options)
            wrong = [name for name in NAMES if found[name] == "wrong"]
            if not wrong:
                break
            mends.append(found.mend(wrong[0]))
            last = found.text(check)
        self.assertIn(says, last)
        self.assert_fine(found)
        options = [o for o in options if o != "--trace"]
        self.assertEqual(self.hosts.run("lumctl", *options, "time").returncode, 0)
        return mends

    def unharmed(self, *options):
        """A set-up that works: nothing is wrong with it, and no mend of a note breaks it."""
        found = self.look(*options)
        self.assertEqual(found.status, 0, str(found))
        for name in NAMES:
            if found.mend(name):
                self.follow(found.mend(name))
                again = self.look(*options)
                self.assertEqual({n: again[n] for n in NAMES}, {n: found[n] for n in NAMES}, f"{found}\n---\n{again}")
        return found


@needs_namespaces
class TwoHosts(OnHosts):
    def test_all_fine(self):
        self.sensor()
        found = self.look()
        self.assert_fine(found)
        self.assertEqual(found.text("interface"), "eth0 is up and has 10.42.0.1/24")
        self.assertRegex(found.text("arp"), r"10\.42\.0\.37 is at (..:){5}..")

    def test_no_address(self):
        self.sensor()
        self.client("ip addr flush dev eth0")
        found = self.broken("interface", 1, "subnet")
        self.assertEqual(found.mend("interface"), "sudo ip addr add 10.42.0.1/24 dev eth0")
        for name in ("route", "arp", "mtu", "answer", *WIRE):
            self.assertEqual(found.text(name), "not looked at: no interface in the sensor's subnet")
        self.mended(found, "interface")

    def test_an_address_of_another_subnet(self):
        self.sensor()
        self.client("ip addr flush dev eth0; ip addr add 192.168.7.1/24 dev eth0; ip route add default via 192.168.7.2")
        self.mended(self.broken("interface"), "interface")

    def test_a_netmask_that_leaves_the_sensor_out(self):
        self.sensor()
        self.client("ip addr flush dev eth0; ip addr add 10.42.0.1/28 dev eth0")
        found = self.broken("interface", 1, "eth0 has 10.42.0.1/28, a subnet from 10.42.0.0 to 10.42.0.15, which leaves "
                                            "10.42.0.37 out")
        self.assertEqual(self.mended(found, "interface"), ["sudo ip addr add 10.42.0.1/24 dev eth0"])

    def test_what_interfaces_have_instead_is_shown(self):
        self.other_interface("192.168.7.1/24")
        self.client("ip addr flush dev eth0")
        found = self.broken("interface", 1, "other0 has 192.168.7.1/24")
        self.assertIn("eth0 has none", found.text("interface"))

    def test_an_address_that_another_device_has_is_not_proposed(self):
        self.sensor()
        Hosts.ip("-n", self.hosts.sensor, "addr", "add", "10.42.0.1/24", "dev", "eth0")
        self.client("ip addr flush dev eth0")
        found = self.broken("interface", 1, "subnet")
        self.assertEqual(self.mended(found, "interface"), ["sudo ip addr add 10.42.0.2/24 dev eth0"])

    def test_where_every_address_is_taken_none_is_proposed(self):
        """The last one that is looked at is the sensor's own."""
        Hosts.ip("-n", self.hosts.sensor, "addr", "flush", "dev", "eth0")
        for n in range(1, 17):
            Hosts.ip("-n", self.hosts.sensor, "addr", "add", f"10.42.0.{n}/32", "dev", "eth0")
        self.client("ip addr flush dev eth0")
        found = self.look("--host", "10.42.0.16")
        self.assertIn("of 10.42.0.1 to 10.42.0.16 every address is taken", found.text("interface"))
        self.assertEqual(found.mend("interface"), "sudo lumctl find --interface eth0 --subnet 10.42.0.0/24    # who has which; "
                                                  "then give eth0 one that nobody has")
        Hosts.ip("-n", self.hosts.sensor, "addr", "del", "10.42.0.9/32", "dev", "eth0")
        self.assertEqual(self.look("--host", "10.42.0.16").mend("interface"), "sudo ip addr add 10.42.0.9/24 dev eth0")

    def test_a_simulator_on_this_host_is_the_mend_and_is_not_to_be_killed(self):
        self.client("ip addr flush dev eth0")
        Sensor(self, self.folder, "--port", "5600", address="127.0.0.1", namespace=self.hosts.client)
        found = self.broken("interface", 1, "subnet")
        self.assertEqual(found.mend("interface"), "lumctl --host 127.0.0.1 --port 5600 doctor    # lumsim is there; for "
                                                  "another sensor: sudo ip addr add 10.42.0.1/24 dev eth0")
        self.assertEqual((found["port"], found.mend("port")), ("note", "lumctl --host 127.0.0.1 --port 5600 doctor"))
        r = self.hosts.run("lumctl", *found.mend("port").split()[1:], "--json")
        self.assertEqual(r.returncode, 0, r.stdout)

    def test_mends_bear_the_port(self):
        found = self.broken("port", 1, "nothing listens on its port 5518", "--host", "127.0.0.3", "--port", "5518")
        self.assertEqual(self.mended(found, "port", ("--host", "127.0.0.3", "--port", "5518")),
                         ["lumsim --address 127.0.0.3 --port 5518 &"])

    def test_mends_bear_another_port(self):
        Sensor(self, self.folder, address="127.0.0.1", namespace=self.hosts.client)
        found = self.broken("port", 1, "lumsim (process", "--host", "127.0.0.3", "--port", "5518")
        self.assertEqual(found.mend("port"), "lumctl --host 127.0.0.1 doctor")
        self.assertIn("at 127.0.0.1:5517", found.text("port"))

    def test_loss_on_a_wire_is_the_cables(self):
        self.sensor("--loss", "0.05")
        found = self.broken("loss", 1, "lost on the wire")
        self.assertIn("cable", found.text("loss"))
        self.assertIn("ethtool -S eth0", found.mend("loss"))

    def test_interface_down(self):
        self.sensor()
        self.client("ip link set eth0 down")
        found = self.broken("interface", 1, "down")
        self.assertEqual(found.mend("interface"), "sudo ip link set eth0 up")
        self.mended(found, "interface")

    def test_interface_down_and_without_address(self):
        self.sensor()
        self.client("ip addr flush dev eth0; ip link set eth0 down")
        self.mended(self.broken("interface"), "interface")

    def test_no_cable(self):
        Hosts.ip("-n", self.hosts.sensor, "link", "set", "eth0", "down")
        self.link_shows("NO-CARRIER")
        self.broken("interface", 1, "no link")

    def test_the_route_leads_elsewhere(self):
        self.sensor()
        self.other_interface("172.16.5.1/24")
        self.client("ip route add 10.42.0.37/32 dev other0")
        found = self.broken("route", 1, "goes out by other0, and not by eth0 in its subnet, where it answers")
        self.assertEqual(found.text("answer"), "not looked at: the route leads elsewhere")
        self.assertEqual(self.mended(found, "route"), ["lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface "
                                                       "eth0 with every tool"])

    def test_the_route_leads_to_a_gateway(self):
        self.sensor()
        self.client("ip route add 10.42.0.32/29 via 10.42.0.9")
        found = self.broken("route", 1, "to the gateway 10.42.0.9")
        self.assertEqual(self.mended(found, "route"), ["sudo ip route replace 10.42.0.37/32 dev eth0 src 10.42.0.1"])

    def test_a_gateway_that_works_is_left_alone(self):
        self.sensor()
        Hosts.ip("-n", self.hosts.sensor, "addr", "add", "10.42.0.9/24", "dev", "eth0")
        self.client("ip route add 10.42.0.32/29 via 10.42.0.9")
        found = self.unharmed()
        self.assertEqual((found["route"], found.mend("route")), ("note", None), str(found))

    def test_a_sensor_behind_the_default_route_is_left_alone(self):
        self.sensor()
        Hosts.ip("-n", self.hosts.sensor, "addr", "add", "192.168.7.2/24", "dev", "eth0")
        self.client("ip addr flush dev eth0; ip addr add 192.168.7.1/24 dev eth0; ip route add default via 192.168.7.2")
        found = self.unharmed()
        self.assertEqual((found["interface"], found.mend("interface")), ("note", None), str(found))
        self.assertEqual(found["answer"], "fine")

    def test_two_interfaces_in_its_subnet_and_the_route_leads_by_the_right_one(self):
        self.sensor()
        self.other_interface("10.42.0.2/24")
        found = self.unharmed()
        self.assert_fine(found)
        self.assertEqual(found.text("interface"), "eth0 is up and has 10.42.0.1/24, and 10.42.0.37 answers there; other0 with "
                                                  "10.42.0.2/24 is in that subnet too, and nobody answers there")

    def by_the_wrong_one(self, address="10.42.0.2/24"):
        """The route of the address that came first holds."""
        self.sensor()
        self.client("ip addr flush dev eth0")
        self.other_interface(address)
        self.client("ip addr add 10.42.0.1/24 dev eth0")

    def test_two_interfaces_in_its_subnet_and_the_route_leads_by_the_wrong_one(self):
        self.by_the_wrong_one()
        found = self.broken("route", 1, "goes out by other0, and not by eth0 in its subnet, where it answers")
        self.assertTrue(found.text("interface").startswith("eth0 is up and has 10.42.0.1/24, and 10.42.0.37 answers there"))
        self.assertEqual(self.mended(found, "route"), ["lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface "
                                                       "eth0 with every tool"])

    def test_two_interfaces_with_the_same_address(self):
        self.by_the_wrong_one("10.42.0.1/24")  # as NetworkManager gives it to one that it shares
        found = self.broken("route", 1, "goes out by other0, and not by eth0 in its subnet, where it answers")
        self.mended(found, "route")

    def test_an_interface_in_its_subnet_and_the_cable_in_another(self):
        self.sensor()
        self.client("ip addr flush dev eth0")
        self.other_interface("10.42.0.1/24")
        found = self.broken("arp", 1, "nobody on other0 answers for 10.42.0.37, but a device on eth0 does, which has no address")
        self.assertEqual(found.mend("arp"), "sudo ip addr add 10.42.0.2/32 dev eth0 && sudo ip route add 10.42.0.37/32 dev eth0 "
                                            "src 10.42.0.2")
        self.follow(found.mend("arp"))
        found = self.unharmed()
        self.assertEqual((found["route"], found["answer"], found["data"]), ("note", "fine", "fine"), str(found))

    def test_the_wrong_interface_is_asked_for(self):
        self.sensor()
        self.other_interface("10.42.0.2/24")
        found = self.broken("arp", 1, "but a device on eth0 does", "--interface", "other0")
        self.assertEqual(self.mended(found, "arp"), ["lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface eth0 "
                                                     "with every tool"])

    def test_an_interface_without_address_is_asked_for(self):
        self.sensor()
        self.client("ip link add other0 type veth peer name other1; ip link set other1 up; ip link set other0 up")
        mend = "lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface eth0 with every tool"
        found = self.broken("interface", 1, "interface other0 has no address in the sensor's subnet", "--interface", "other0")
        self.assertEqual(self.mended(found, "interface", ("--interface", "other0")), [mend])
        self.assertEqual(self.look_unprivileged("--interface", "other0").mend("interface"), mend)
        self.client("ip addr add 10.42.0.2/24 dev other0; ip link set other0 down")
        found = self.broken("interface", 1, "down; 10.42.0.37 answers on eth0", "--interface", "other0")
        self.assertEqual(self.mended(found, "interface", ("--interface", "other0")), [mend])
        self.client("ip addr flush dev eth0; ip addr flush dev other0; ip link set other0 up")
        found = self.broken("interface", 1, "10.42.0.37 answers on eth0", "--interface", "other0")
        self.mended(found, "interface", ("--interface", "other0"))

    def test_the_cable_with_the_sensor_is_known_by_its_answer(self):
        self.sensor()
        self.client("ip link add enp1s0 type veth peer name enp1s1; ip link set enp1s1 up; ip link set enp1s0 up;"
                    "ip addr flush dev eth0; ip addr add 192.168.7.9/24 dev eth0")  # the other one looks likelier
        found = self.broken("interface", 1, "subnet")
        self.assertEqual(self.mended(found, "interface"), ["sudo ip addr add 10.42.0.1/24 dev eth0"])

    def test_two_interfaces_in_its_subnet_and_a_strict_filter(self):
        self.by_the_wrong_one()
        self.client("sysctl -qw net.ipv4.conf.all.rp_filter=1")
        found = self.broken("route", 1, "other0")
        mends = self.mended(found, "route")
        self.assertEqual(mends[1:], ["sudo sysctl -w net/ipv4/conf/eth0/rp_filter=2"])

    def test_two_interfaces_in_its_subnet_and_no_sensor(self):
        Hosts.ip("-n", self.hosts.sensor, "addr", "flush", "dev", "eth0")
        self.other_interface("10.42.0.2/24")
        found = self.broken("arp", 3, "nobody on eth0")
        self.assertEqual(found["route"], "fine", str(found))

    def test_a_second_interface_that_is_down_is_no_matter(self):
        self.sensor()
        self.other_interface("10.42.0.2/24")
        self.client("ip link set other0 down")
        self.assert_fine(self.unharmed())

    def test_two_devices_with_its_address(self):
        self.sensor()
        third = self.rival()
        found = self.look()
        self.assertEqual(found["arp"], "wrong", str(found))
        self.assertRegex(found.text("arp"), r"2 devices on eth0 answer for 10\.42\.0\.37: (..:){5}.. and (..:){5}..; ")
        self.follow(found.mend("arp"))
        Hosts.ip("-n", third, "link", "del", "mac0")  # a namespace lives on for a while after it was deleted
        self.assert_fine(self.look())

    def test_two_devices_with_its_address_and_the_one_reached_is_no_sensor(self):
        self.rival()
        found = self.broken("arp", 1, "2 devices on eth0 answer")
        self.assertEqual((found.overall, found["answer"]), ("wrong", "wrong"), str(found))

    def rival(self):
        """A computer with the sensor's address; the namespace, where its interface is mac0."""
        third = self.hosts.sensor + "t"
        self.addCleanup(subprocess.run, ["ip", "netns", "del", third], capture_output=True)
        Hosts.ip("netns", "add", third)
        Hosts.ip("-n", self.hosts.sensor, "link", "add", "link", "eth0", "name", "mac0", "netns", third, "type", "macvlan",
                 "mode", "bridge")
        Hosts.ip("-n", third, "addr", "add", "10.42.0.37/24", "dev", "mac0")
        Hosts.ip("-n", third, "link", "set", "mac0", "up")
        return third

    def test_the_sensors_address_on_the_host_itself(self):
        self.sensor()
        self.client("ip addr add 10.42.0.37/24 dev eth0")
        found = self.broken("port", 1, "own address (dev eth0)")
        self.assertEqual(found["arp"], "wrong", str(found))
        self.assertEqual(self.mended(found, "port"), ["sudo ip addr del 10.42.0.37/24 dev eth0"])

    def test_the_sensors_address_on_the_host_itself_and_no_sensor(self):
        self.client("ip addr add 10.42.0.37/24 dev eth0")
        Hosts.ip("-n", self.hosts.sensor, "addr", "flush", "dev", "eth0")
        Sensor(self, self.folder, address="127.0.0.1", namespace=self.hosts.client)
        found = self.broken("port", 1, "own address")
        self.assertEqual((found["arp"], found.mend("port")), ("fine", "sudo ip addr del 10.42.0.37/24 dev eth0"), str(found))

    def test_the_sensors_address_on_the_loopback(self):
        self.sensor()
        self.client("ip addr add 10.42.0.37/32 dev lo")  # left over from a simulator
        found = self.broken("port", 1, "own address (dev lo)")
        self.assertEqual((found["arp"], found.mend("arp")), ("wrong", "sudo ip addr del 10.42.0.37/32 dev lo"), str(found))
        self.assertIn(f"a device on eth0 has it, too: {Hosts.mac(self.hosts.sensor)}", found.text("arp"))
        self.assertEqual(self.mended(found, "port"), ["sudo ip addr del 10.42.0.37/32 dev lo"])

    def test_a_port_that_is_rewritten(self):
        self.sensor("--port", "6000")
        r = subprocess.run([*inside(self.hosts.sensor), "nft", "-f", "-"], input="""table ip rewrite {
            chain in { type filter hook prerouting priority -300; udp dport 5517 udp dport set 6000; }
        }""", capture_output=True, text=True)
        self.assertEqual(r.returncode, 0, r.stderr)
        found = self.broken("answer", 1, "answers from port 6000")
        self.assertEqual(self.mended(found, "answer"), ["lumctl --host 10.42.0.37 --port 6000 doctor"])

    def test_a_program_that_has_the_port_lives_on(self):
        self.sensor()
        p = Process(self, self.folder, sys.executable, "-c", "import socket, time\ns = socket.socket(type=socket.SOCK_DGRAM)\n"
                    "s.bind(('127.0.0.1', 5517))\nprint('bound', flush=True)\ntime.sleep(3600)", namespace=self.hosts.client)
        wait_until(p.stdout, "the port")
        self.assertEqual(self.unharmed()["port"], "note")
        self.assertIsNone(p.p.poll())

    def test_a_route_that_forbids(self):
        self.client("ip route add unreachable 10.42.0.37/32")
        self.assertEqual(self.broken("route", 1, "no route").text("arp"), "not looked at: no route")

    def test_nobody_has_the_address(self):
        found = self.broken("arp", 3, "nobody on eth0", "--host", "10.42.0.99")
        self.assertIn("--host 10.42.0.37", found.mend("arp"))
        self.assertIn("tcpdump", self.broken_boot_address())

    def broken_boot_address(self):
        Hosts.ip("-n", self.hosts.sensor, "addr", "flush", "dev", "eth0")
        return self.broken("arp", 3, "10.42.0.37").mend("arp")

    def test_a_host_without_a_sensor(self):
        self.broken("answer", 3, "nothing listens on its port")

    def test_a_silent_sensor(self):
        self.sensor("--fault", "silence@0")
        found = self.broken("answer", 3, "no answer")
        self.assertEqual(found["arp"], "fine")

    def test_mtu(self):
        self.sensor()
        self.client("ip link set eth0 mtu 1400")
        found = self.broken("mtu", 1, "1400")
        self.assertEqual(found["answer"], "fine")
        self.mended(found, "mtu")

    def test_a_device_that_has_gone_is_not_believed(self):
        self.sensor()
        self.assert_fine(self.look())
        Hosts.ip("-n", self.hosts.sensor, "addr", "flush", "dev", "eth0")
        self.broken("arp", 3, "nobody on eth0")

    def test_an_interface_of_two(self):
        self.sensor()
        self.other_interface("10.42.0.2/24")
        self.assertEqual(self.look("--interface", "eth0").status, 0)
        found = self.look("--interface", "other0")
        self.assertIn("other0", found.text("interface"))
        self.assertEqual((found.status, found["arp"]), (1, "wrong"), str(found))

    def look_unprivileged(self, *options):
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        r = subprocess.run([*inside(self.hosts.client), sys.executable, "-c",
                            "import os, sys; os.setgroups([]); os.setgid(65534); os.setuid(65534);"
                            "os.execv(sys.argv[1], sys.argv[1:])", copy, *options, "doctor", "--json"],
                           capture_output=True, text=True, timeout=PATIENCE_S)
        return Findings(r)

    def test_two_interfaces_in_its_subnet_without_rights(self):
        self.by_the_wrong_one()
        found = self.look_unprivileged()
        self.assertEqual(found["route"], "wrong", str(found))
        self.assertEqual(found.mend("route"), "lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface eth0 with "
                                              "every tool")

    @needs_nft
    def test_a_rule_without_rights(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; }; }'")
        found = self.look_unprivileged()
        self.assertEqual((found.status, found["firewall"]), (3, "not looked at"), str(found))
        self.assertIn("only root can see whether one comes in and is dropped", found.text("firewall"))

    def test_unprivileged(self):
        self.sensor("--rate", "2")  # the receive buffer may be small
        found = self.look_unprivileged()
        for name in ("interface", "route", "arp", "firewall", "mtu", "answer", "data", "layout", "clock", "status"):
            self.assertEqual(found[name], "fine", str(found))
        self.assertIn("only root can see whether another device answers", found.text("arp"))
        limit = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text())
        self.assertEqual(found["buffer"], "fine" if limit >= 33554432 else "wrong", str(found))
        self.assertEqual(found.status, 0 if found["buffer"] == "fine" else 1)


# Each drops what comes from the sensor, or what goes to it: the commands, and the chain that the trace names.
RULES = {
    "policy": ("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; tcp dport 22 accept; }; }'",
               "policy of chain in (table inet f)"),
    "a chain behind a jump": (
        "nft 'add table ip g { chain no_udp { udp sport { 53, 5000-6000 } counter drop; }; chain in { type filter hook "
        "prerouting priority 0; ip saddr 10.42.0.0/16 jump no_udp; }; }'", "rule of chain no_udp (table ip g)"),
    "what leaves": ("nft 'add table inet f { chain out { type filter hook output priority 0; udp dport 5517 reject; }; }'",
                    "rule of chain out (table inet f) drops packets to 10.42.0.37: udp dport 5517 reject"),
    "after routing": ("nft 'add table ip f { chain po { type filter hook postrouting priority 0; ip daddr 10.42.0.37 drop; }; }'",
                      "rule of chain po"),
    "no tracking": (
        "nft 'add table inet f { chain raw { type filter hook prerouting priority -300; udp sport 5517 notrack; }; chain in { "
        "type filter hook input priority 0; policy drop; ct state established accept; }; }'", "policy of chain in"),
    "a set": (
        "nft 'add table inet f { set bad { type ipv4_addr; elements = { 10.42.0.37 }; }; chain in { type filter hook input "
        "priority 0; ip saddr @bad drop; }; }'", "rule of chain in"),
    "a map": ("nft 'add table inet f { chain in { type filter hook input priority 0; udp sport vmap { 5517 : drop }; }; }'",
              "rule of chain in"),
    "a mark": (
        "nft 'add table ip f { chain p { type filter hook prerouting priority -150; ip saddr 10.42.0.0/24 meta mark set 5; }; "
        "chain in { type filter hook input priority 0; meta mark 5 drop; }; }'", "rule of chain in"),
    "the device's own chain": (
        "nft 'add table netdev f { chain i { type filter hook ingress device eth0 priority 0; udp sport 5517 drop; }; }'",
        "rule of chain i (table netdev f)"),
    "iptables, policy": ("iptables-nft -P INPUT DROP; iptables-nft -A INPUT -p tcp --dport 22 -j ACCEPT",
                         "policy of chain INPUT (table ip filter)"),
    "iptables, a match of its own": ("iptables-nft -A INPUT -p udp -m length --length 48 -j DROP", "rule of chain INPUT"),
    "iptables, a chain": ("iptables-nft -N LOGDROP; iptables-nft -A LOGDROP -j DROP; iptables-nft -A INPUT -i eth0 -j LOGDROP",
                          "rule of chain LOGDROP"),
}


@needs_namespaces
@needs_nft
class Firewall(OnHosts):
    """A rule drops packets: that is seen without asking, and named by a trace that leaves nothing behind."""

    def tables(self):
        return self.shell("nft list tables")[1].split("\n")

    def drops(self, name):
        rules, says = RULES[name]
        if "iptables" in rules and not shutil.which("iptables-nft", path="/usr/sbin:/sbin"):
            self.skipTest("iptables-nft is not installed")
        self.sensor()
        self.client(rules)
        before = self.tables()
        found = self.broken("firewall")
        self.assertNotIn("chain", found.text("firewall"))
        self.assertEqual(found.mend("firewall"), "sudo lumctl --host 10.42.0.37 doctor --trace    # names the rule")
        mends = self.mended(found, "firewall", says=says)
        self.assertEqual(len(mends), 2, mends)
        self.assertEqual(self.tables(), before)

    def test_rules_let_all_but_answers_drop(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; iif lo accept; "
                    "ct state vmap { invalid : drop, established : accept, related : accept }; }; }'")
        self.assert_fine(self.look())
        found = self.look("--trace")
        self.assert_fine(found)
        self.assertIn("as the kernel's trace shows", found.text("firewall"))

    def old_kind(self, rules, says):
        if not shutil.which("iptables-legacy", path="/usr/sbin:/sbin"):
            self.skipTest("iptables-legacy is not installed")
        self.sensor()
        self.client(rules)
        found = self.broken("firewall", 1, "come in by eth0, and this host drops them")
        self.mended(found, "firewall", says=says)

    def test_rules_of_the_old_kind(self):
        self.old_kind("iptables-legacy -t raw -A PREROUTING -s 10.42.0.37 -j DROP",
                      "rule of chain PREROUTING (iptables-legacy, table raw) drops packets from 10.42.0.37: -A PREROUTING")

    def test_a_policy_of_the_old_kind(self):
        self.old_kind("iptables-legacy -P INPUT DROP; iptables-legacy -A INPUT -p tcp --dport 22 -j ACCEPT",
                      "the policy of chain INPUT (iptables-legacy, table filter)")

    def test_a_trace_beside_another_sessions_data_marks_none_of_it(self):
        self.sensor()
        self.hosts.start("lumctl", "heartbeat")
        marks = Process(self, self.folder, "nft", "monitor", "trace", namespace=self.hosts.client)
        for looks in range(1, 20):  # until the monitor listens, which it does not say
            self.assertEqual(self.look("--trace")["firewall"], "fine")
            if marks.stdout():
                break
        marks.end()
        traced = {line.split()[2] for line in marks.stdout().splitlines() if line.startswith("trace id")}
        self.assertGreaterEqual(len(traced), 2)
        self.assertLessEqual(len(traced), 12 * looks)

    def test_rules_that_let_answers_pass_and_data_not(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; udp length > 300 drop; }; }'")
        found = self.broken("data", 1, "came in by eth0, and this host drops them, though not short answers")
        self.assertEqual((found["answer"], found["firewall"]), ("fine", "fine"), str(found))
        self.assertIn("udp length > 300 drop", self.shell(found.mend("data"))[1])
        traced = self.look("--trace")  # of requests and answers alone
        self.assertEqual((traced["firewall"], traced.mend("data")), ("fine", found.mend("data")), str(traced))
        self.assertIn("requests to 10.42.0.37 and its answers pass", traced.text("firewall"))

    def test_a_rule_that_limits_is_no_bad_cable(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; udp length > 300 limit rate over "
                    "100/second drop; }; }'")
        found = self.broken("loss", 1, "this host dropped")
        self.assertIn("not for want of buffer", found.text("loss"))
        self.assertIn("limit rate over 100/second", self.shell(found.mend("loss"))[1])

    def test_a_trace_that_cannot_be_is_no_success(self):
        self.sensor()
        old = self.folder.write("nft", "#!/bin/sh\nwhile read -r line; do echo 'Error: syntax error, unexpected flags' >&2; done\n")
        os.chmod(old, 0o755)
        private = "unshare --mount --propagation private"  # else every program would have this nft
        if self.shell(f"{private} true")[0] != 0:
            self.skipTest("no mounts of its own: the root is no mount point")
        status, out = self.shell(f"{private} sh -c 'mount --bind {old} $(readlink -f /usr/sbin/nft) && "
                                 "exec lumctl doctor --trace --json'")
        found = {c["name"]: c for c in json.loads(out)["checks"]}
        self.assertEqual((status, found["firewall"]["result"], found["answer"]["result"]), (1, "wrong", "fine"), out)
        self.assertIn("no trace: nft or the kernel cannot", found["firewall"]["text"])

    def test_a_trace_that_is_killed_leaves_nothing(self):
        self.sensor("--fault", "silence@0")
        p = self.hosts.start("lumctl", "doctor", "--trace")
        wait_until(lambda: any("lumctl_" in t for t in self.tables()), "the trace's table")
        p.p.kill()
        p.p.wait()
        wait_until(lambda: self.tables() == [""], "the table's end")
        wait_until(lambda: "nft" not in self.shell("ip netns pids $(ip netns identify) | xargs -r ps -o comm= -p")[1], "the end of nft")


def add_stories():
    for name in RULES:
        def story(self, name=name):
            self.drops(name)
        setattr(Firewall, "test_rules_" + re.sub(r"\W+", "_", name), story)


add_stories()


if __name__ == "__main__":
    shards.main()
