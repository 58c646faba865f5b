#!/usr/bin/env python3
"""lumctl: its words and packets, and a little of both on a real system. Against sensors that behave and misbehave:
tests/world/stories (commands.c, answers.c, set_ip.c)."""
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
from live import Hosts, Process, Sensor, inside, needs_namespaces, readable, wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder, run

DONE, FAILED, BAD, NO_ANSWER, HAZARD = range(5)

# Where a busy machine may answer late, and it matters how often something was sent.
PATIENT = ["--timeout", 20000]
PICTURE = b"\033[H\033[J"
CMD_OFF = 0x0200


def status_tlv(value):
    return struct.pack("<HHH", 2, 2, value)


def debug_tlv(text):
    return struct.pack("<HH", 3, len(text)) + text.encode()


def tlv_packet(sequence, *tlvs):
    return MAGIC + struct.pack("<II", 7, sequence) + b"".join(tlvs)


class FakeSensor:
    """Answers as a test says: answer(kind, sequence, body, count) gives the packets to send back. body is what follows
    the sequence, count how many of this kind came before."""

    def __init__(self, test, address, answer=None, port=5517):
        self.socket = self.bind(address, port)
        self.answer = answer or (lambda kind, sequence, body, count: self.plain(kind, sequence))
        self.packets = []
        self.ends = False
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()
        test.addCleanup(self.stop)

    @staticmethod
    def bind(address, port=5517):
        s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        s.bind((address, port))
        s.settimeout(0.05)
        return s

    @staticmethod
    def plain(kind, sequence, status=CMD_OFF, clock=5_000_000):
        if kind == 6:
            return [MAGIC + struct.pack("<III", 6, sequence, clock)]
        return [tlv_packet(sequence, status_tlv(status))] if kind == 7 else []

    def of(self, kind):
        return [p for p in self.packets if p[8] == kind]

    def serve(self):
        while not self.ends:
            try:
                packet, sender = self.socket.recvfrom(2048)
            except socket.timeout:
                continue
            if not packet.startswith(MAGIC):
                continue
            self.packets.append(packet)
            kind = packet[8]
            if kind in (6, 7):
                sequence = struct.unpack_from("<I", packet, 12)[0]
                for out in self.answer(kind, sequence, packet[16:], len(self.of(kind)) - 1):
                    if isinstance(out, tuple):
                        pause, out = out
                        time.sleep(pause)
                    self.socket.sendto(out, sender)

    def stop(self):
        self.ends = True
        self.thread.join()
        self.socket.close()


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def ctl(self, address, *words, **options):
        return run("lumctl", "--host", address, *words, **options)

    def check(self, status, address, *words, **options):
        r = self.ctl(address, *words, **options)
        self.assertEqual(r.returncode, status, (words, r.stdout, r.stderr))
        return r

    def json(self, status, address, *words):
        """The one object that a command prints."""
        return json.loads(self.check(status, address, *words, "--json").stdout)

    def one_line(self, r, *texts):
        self.assertEqual(r.returncode, BAD, r.stderr)
        self.assertEqual(r.stdout, "")
        self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
        self.assertTrue(r.stderr.startswith("lumctl: "), r.stderr)
        for text in texts:
            self.assertIn(text, r.stderr)


def dry(*words):
    return run("lumctl", "--dry-run", "--sequence", 7, *words)


HEAD = MAGIC.hex() + "0700000007000000"


def command(text):
    return HEAD + struct.pack("<HH", 1, len(text)).hex() + text.encode().hex()


class Packets(Case):
    def test_every_packet_of_the_table_is_the_protocols_byte_by_byte(self):
        for words, packet in (
                (["heartbeat"], MAGIC.hex() + "08000000"),
                (["status"], HEAD),
                (["time"], MAGIC.hex() + "060000000700000000000000"),
                (["set-ip", "10.42.0.99"], MAGIC.hex() + "050000000a2a0063"),
                (["laser", "on"], command("u")),
                (["laser", "off"], command("d")),
                (["power", "0"], command("0p")),
                (["power", "100"], command("100p")),
                (["threshold", "green", "40"], command("40g")),
                (["threshold", "blue", "100"], command("100b")),
                (["lines", "640"], command("0f")),
                (["lines", "64"], command("1f")),
                (["holdoff", "250"], command("250h")),
                (["offset", "green", "30"], command("30G")),
                (["offset", "blue", "0"], command("0B")),
                (["send", "50p 15y u"], command("50p 15y u")),
                (["tlv", "9:deadBEEF", "2:"], HEAD + "09000400deadbeef02000000")):
            r = dry(*words)
            note = "lumctl: set-ip: not checked in a dry run: whether another device has the address\n"
            self.assertEqual((r.returncode, r.stdout, r.stderr), (DONE, packet + "\n", note * (words[0] == "set-ip")), words)

    def test_a_dry_run_refuses_an_address_of_this_host(self):
        for words in (["127.0.0.1"], ["127.3.2.1"], ["127.0.0.1", "--json"]):
            r = dry("set-ip", *words)
            self.assertEqual((r.returncode, r.stdout), (BAD, ""), r.stderr)
            self.one_line(r, words[0], "loopback", "--force")
        self.assertEqual(dry("set-ip", "127.0.0.1", "--force", "-q").stdout, MAGIC.hex() + "050000007f000001\n")

    def test_json_holds_every_packet_in_one_object(self):
        for words, packets in ((["power", "5"], [command("5p")]), (["laser", "off"], [command("d")]),
                               (["heartbeat"], [MAGIC.hex() + "08000000"]), (["status"], [HEAD])):
            r = dry(*words, "--json")
            self.assertEqual((r.returncode, json.loads(r.stdout)), (DONE, {"packets": packets}), words)
            self.assertEqual(r.stdout.count("\n"), 1)
        settings = self.folder.write("s.yaml", "version: 1\nlines: 640\npower: 50\nyscan: {shape: uniform}\n")
        plain = dry("apply", settings)
        self.assertEqual(plain.returncode, DONE, plain.stderr)
        self.assertEqual(json.loads(dry("apply", settings, "--json").stdout)["packets"], plain.stdout.split())

    def test_a_set_ip_packet_follows_the_profile(self):
        profile = self.folder.write("p.yaml", "version: 1\nset_ip_order: little\ntlv: {command: 77}\n")
        self.assertTrue(dry("--profile", profile, "set-ip", "10.42.0.99").stdout.endswith("63002a0a\n"))
        self.assertIn("4d000100", dry("--profile", profile, "laser", "on").stdout)

    def test_a_packet_holds_as_much_as_it_can_and_no_more(self):
        room = 1472 - 16 - 4
        self.assertEqual(len(dry("tlv", "9:" + "00" * room).stdout), 2 * 1472 + 1)
        self.one_line(dry("tlv", "9:" + "00" * (room + 1)), "1472")
        self.one_line(dry("tlv", "9:" + "00" * room, "9:"), "1472")

    def test_options_stand_anywhere_and_in_both_forms(self):
        for words in (["power", "50", "--dry-run", "--sequence", "7"], ["--dry-run", "power", "--sequence=7", "50"],
                      ["power", "--sequence=7", "50", "--dry-run", "-q"], ["--dry-run", "--sequence=7", "--", "power", "50"]):
            self.assertEqual(run("lumctl", *words).stdout, command("50p") + "\n", words)


class Refused(Case):
    def test_values_outside_the_manuals_limits_are_named_with_what_is_allowed(self):
        for words, texts in (
                (["power", "101"], ["'101'", "0 to 100"]),
                (["power", "-1"], ["'-1'", "0 to 100"]),
                (["power", "-.5"], ["'-.5'", "0 to 100"]),
                (["power", "5.5"], ["'5.5'", "0 to 100"]),
                (["power", ""], ["''", "0 to 100"]),
                (["power", "+5"], ["'+5'"]),
                (["power", "05"], ["'05'"]),
                (["power", " 5"], ["' 5'"]),
                (["power", "0x10"], ["'0x10'"]),
                (["power", "5p 6"], ["'5p 6'"]),
                (["power", "9" * 400], ["0 to 100"]),
                (["power", "99999999999999999999"], ["0 to 100"]),
                (["power"], ["missing", "0 to 100"]),
                (["power", "5", "6"], ["'6'"]),
                (["threshold", "red", "5"], ["'red'", "green or blue"]),
                (["threshold"], ["green", "blue"]),
                (["threshold", "green", "101"], ["'101'", "0 to 100"]),
                (["lines", "320"], ["'320'", "640 or 64"]),
                (["lines", "0"], ["'0'", "640 or 64"]),
                (["holdoff", "155"], ["'155'", "steps of 10"]),
                (["offset", "green", "31"], ["'31'", "0 to 30"]),
                (["laser", "up"], ["'up'", "on or off"]),
                (["laser"], ["on or off"]),
                (["laser", "on", "off"], ["'off'"]),
                (["set-ip", "256.1.1.1"], ["'256.1.1.1'"]),
                (["set-ip", "0.0.0.0"], ["'0.0.0.0'"]),
                (["set-ip", "224.0.0.1"], ["'224.0.0.1'"]),
                (["set-ip", "255.255.255.255"], ["'255.255.255.255'"]),
                (["set-ip", "10.42.0"], ["'10.42.0'"]),
                (["set-ip", "10.42.0.01"], ["'10.42.0.01'"]),
                (["set-ip", "10.42.0.1 "], ["'10.42.0.1 '"]),
                (["set-ip"], ["one address"]),
                (["send", "50q"], ["'50q'"]),
                (["send", "u 101p"], ["'101p'", "0 to 100"]),
                (["send", "u 155h"], ["'155h'", "steps of 10"]),
                (["send", ""], ["''"]),
                (["send", "50p  15y"], ["one space"]),
                (["send", "50p", "15y"], ["quote"]),
                (["tlv", "70000:00"], ["'70000:00'", "65535"]),
                (["tlv", "1"], ["'1'"]),
                (["tlv", ":00"], ["':00'"]),
                (["tlv", "1:0"], ["'1:0'", "even"]),
                (["tlv", "1:zz"], ["'1:zz'", "hex"]),
                (["tlv"], ["TYPE:HEX"]),
                (["status", "now"], ["'now'"]),
                (["time", "now"], ["'now'"]),
                (["heartbeat", "5"], ["'5'"])):
            self.one_line(dry(*words), *texts)

    def test_an_unknown_name_is_answered_with_the_nearest(self):
        for words, near in ((["statsu"], "status"), (["pwer", "5"], "power"), (["set-up", "1.2.3.4"], "set-ip"),
                            (["status", "--jsn"], "--json"), (["status", "--wach"], "--watch")):
            self.one_line(dry(*words), "did you mean " + near)
        self.one_line(dry("nonsense"), "'nonsense'", "--help")
        self.one_line(dry("status", "--zzzzzz"), "--zzzzzz", "--help")
        self.one_line(dry("status", "-x"), "-x")
        self.one_line(run("lumctl"), "--help")

    def test_options_are_checked_as_strictly_as_words(self):
        for words, texts in (
                (["status", "--host", "300.1.1.1"], ["--host", "'300.1.1.1'", "10.42.0.37"]),
                (["status", "--host", "0.0.0.0"], ["'0.0.0.0'"]),
                (["status", "--host", "10.42.0.37:"], ["'10.42.0.37:'"]),
                (["status", "--host", "10.42.0.37:65536"], ["'10.42.0.37:65536'"]),
                (["status", "--host"], ["missing"]),
                (["status", "--port", "0"], ["'0'", "1 to 65535"]),
                (["status", "--timeout", "0.4"], ["'0.4'", "milliseconds"]),
                (["status", "--retries", "-1"], ["'-1'", "0 to 100"]),
                (["status", "--sequence", "4294967296"], ["'4294967296'", "4294967295"]),
                (["heartbeat", "--rate", "0"], ["'0'", "1 to 100"]),
                (["heartbeat", "--rate", "101"], ["'101'", "1 to 100"]),
                (["heartbeat", "--duration", "nan"], ["'nan'"]),
                (["status", "--json=yes"], ["--json", "no value", "'yes'"]),
                (["power", "5", "--watch"], ["--watch", "power", "status"]),
                (["status", "--duration", "2"], ["--duration", "--watch"]),
                (["time", "--duration", "2"], ["--duration", "--watch"]),
                (["status", "--rate", "5"], ["--rate", "heartbeat"])):
            self.one_line(dry(*words), *texts)

    def test_a_letter_in_the_place_of_a_digit_is_told(self):
        """The manual prints Of, with the letter O, where 0f is meant."""
        for text, meant in (("Of", "the letter O, not the digit zero; did you mean 0f?"), ("50p Of u", "did you mean 0f?"),
                            ("of", "did you mean 0f?"), ("lf", "not the digit one; did you mean 1f?"),
                            ("5Op", "a letter among its digits; did you mean 50p?")):
            self.one_line(dry("send", text), meant)
        for text in ("Oq", "O", "Ou", "f", "oo"):
            self.assertNotIn("did you mean", dry("send", text).stderr)

    def test_an_interface_that_is_not_there_is_a_bad_argument_of_every_tool(self):
        for words in (["lumctl", "status"], ["lumctl", "shell"], ["lumctl", "heartbeat"],
                      ["lumdump", "udp://127.33.9.1"], ["lumsim"], ["lumview", "udp://127.33.9.1"]):
            if not (BIN / words[0]).exists():
                continue  # a build without the viewer
            r = run(*words, "--interface", "nosuch0")
            self.assertEqual(r.returncode, BAD, (words, r.stderr))
            self.assertIn("there is no interface nosuch0; this host has: ", r.stderr)

    def test_a_name_of_no_host_is_told_by_every_tool(self):
        for words in (["lumctl", "--host", "sensor.invalid", "status"], ["lumctl", "set-ip", "sensor.invalid"],
                      ["lumdump", "udp://sensor.invalid:5517"], ["lumdump", "x.pcap", "--sensor", "sensor.invalid"],
                      ["lumsim", "--address", "sensor.invalid"], ["lumview", "udp://sensor.invalid"],
                      ["lumview", "x.pcap", "--sensor", "sensor.invalid"], ["lumview", "x.pcap", "--bind", "sensor.invalid"]):
            if not (BIN / words[0]).exists():
                continue
            r = run(*words)
            self.assertEqual(r.returncode, BAD, (words, r.stderr))
            self.assertIn("'sensor.invalid'", r.stderr)
            self.assertIn("give its address", r.stderr)

    def test_a_profile_that_cannot_be_is_told_with_its_line(self):
        bad = self.folder.write("bad.yaml", "version: 1\nset_ip_order: sideways\n")
        self.one_line(dry("--profile", bad, "status"), "bad.yaml:2", "set_ip_order")
        self.one_line(dry("--profile", self.folder / "none.yaml", "status"), "none.yaml")


class Help(Case):
    def test_help_names_every_command_and_each_has_its_own(self):
        r = run("lumctl", "--help")
        self.assertEqual((r.returncode, r.stderr), (DONE, ""))
        self.assertIn("Examples:", r.stdout)
        commands = re.findall(r"^  ([a-z][a-z-]*) ", r.stdout.split("Options")[0], re.M)
        self.assertEqual(len(commands), 21)
        for name in commands:
            one = run("lumctl", name, "-h")
            self.assertEqual((one.returncode, one.stderr), (DONE, ""))
            self.assertIn(f"lumctl [OPTION]... {name}", one.stdout)

    def test_help_and_manual_tell_the_defaults_of_the_headers(self):
        top = pathlib.Path(__file__).resolve().parents[2]
        headers = "".join((top / "include/lum" / name).read_text() for name in ("wire.h", "net/sensor.h"))
        value = {name: int(text) for name, text in re.findall(r"#define (LUM_\w+) +(\d+)u", headers)}
        text = run("lumctl", "--help").stdout
        page = re.sub(r"\n", " ", (top / "docs/man/lumctl.1").read_text())
        rate = 1000 // value["LUM_HEARTBEAT_MS"]
        for option, usual in (("port", value["LUM_PORT"]), ("timeout", value["LUM_SENSOR_TIMEOUT_MS"]),
                              ("retries", value["LUM_SENSOR_RETRIES"]), ("rate", rate)):
            self.assertRegex(text, rf"--{option} .*default {usual}\b")
            self.assertRegex(page, rf"Fl \\-{option} Ar \w+(?: (?!\.It).*?)?\b{usual}\b")

    def test_help_is_a_word_too(self):
        self.assertEqual(run("lumctl", "help").stdout, run("lumctl", "--help").stdout)
        r = run("lumctl", "help", "power")
        self.assertEqual((r.returncode, r.stdout, r.stderr), (DONE, run("lumctl", "power", "--help").stdout, ""))
        self.one_line(run("lumctl", "help", "pwer"), "did you mean power")
        self.one_line(run("lumctl", "help", "power", "lines"), "'lines'")

    def test_the_version_is_told(self):
        self.assertRegex(run("lumctl", "--version").stdout, r"^lumctl \d+\.\d+\.\d+\n$")

    def test_no_line_is_wider_than_a_terminal(self):
        commands = re.findall(r"^  ([a-z][a-z-]*) ", run("lumctl", "--help").stdout.split("Options")[0], re.M)
        for words in ([], *([name] for name in commands)):
            for text in run("lumctl", *words, "--help").stdout.splitlines():
                self.assertLessEqual(len(text), 80, text)

    def test_output_that_cannot_be_written_is_a_failure(self):
        with open("/dev/full", "wb") as full:
            p = subprocess.run([BIN / "lumctl", "--help"], stdout=full, stderr=subprocess.PIPE)
        self.assertEqual(p.returncode, FAILED)
        self.assertIn(b"standard output", p.stderr)


class Live(Case):
    """Against lumsim."""

    def sensor(self, address, *arguments):
        return Sensor(self, self.folder, "--rate", 2, "-q", *arguments, address=address)

    def heartbeats(self, address, *arguments):
        """A session of another process, until the test ends."""
        p = Process(self, self.folder, BIN / "lumctl", "--host", address, "heartbeat", *arguments)
        wait_until(lambda: p.stdout() or p.p.poll() is not None, "the session")
        return p

    def test_the_laser_goes_on_and_off_and_each_is_seen(self):
        sensor = self.sensor("127.33.1.6")
        r = self.check(FAILED, "127.33.1.6", "laser", "on")
        self.assertIn("heartbeat", r.stderr)
        self.assertFalse(sensor.laser_is_up())
        beats = self.heartbeats("127.33.1.6")
        r = self.check(DONE, "127.33.1.6", "laser", "on")
        self.assertIn("laser up", r.stdout)
        self.assertIn("3 s after the last heartbeat", r.stderr)
        self.assertTrue(sensor.laser_is_up())
        self.assertEqual(self.json(DONE, "127.33.1.6", "laser", "on")["laser"], "up")
        self.assertEqual(self.json(DONE, "127.33.1.6", "status")["laser"], "up")
        wait_until(lambda: "laser up: TLV_CMD_ON" in beats.stdout(), "the laser in the session's log")
        self.assertEqual(self.json(DONE, "127.33.1.6", "laser", "off")["done"], True)
        self.assertFalse(sensor.laser_is_up())
        self.check(DONE, "127.33.1.6", "laser", "off")
        self.assertEqual(beats.end(signal.SIGINT), DONE, beats.stderr())

    def test_a_terminal_gets_colour_and_a_picture_that_is_redrawn(self):
        self.sensor("127.33.1.14", "--fault", "fan@0")
        wait_until(lambda: "FAN" in self.ctl("127.33.1.14", "status").stdout, "the hazard")
        self.assertIn("\033[1;31m", self.at_a_terminal("127.33.1.14", "status"))
        self.assertNotIn("\033[1;31m", self.at_a_terminal("127.33.1.14", "status", NO_COLOR="1"))
        self.assertGreaterEqual(self.at_a_terminal("127.33.1.14", "status", "--watch", pictures=2).count(PICTURE.decode()), 2)

    def at_a_terminal(self, address, *words, pictures=None, **environment):
        """What is shown there; after so many pictures a signal ends it."""
        ours, theirs = pty.openpty()
        environment = {**{k: v for k, v in os.environ.items() if k != "NO_COLOR"}, "TERM": "xterm", **environment}
        p = subprocess.Popen([BIN / "lumctl", "--host", address, *words], stdin=theirs, stdout=theirs, stderr=theirs,
                             env=environment)
        os.close(theirs)
        out = b""
        while readable(ours, PATIENCE_S):
            try:
                data = os.read(ours, 4096)
            except OSError:
                break
            out += data
            if pictures is not None and out.count(PICTURE) >= pictures:
                p.send_signal(signal.SIGINT)
                pictures = None
        os.close(ours)
        self.assertEqual(p.wait(PATIENCE_S), HAZARD)
        return out.decode()


class Misbehaviour(Case):
    """Against a sensor whose answers are lost, late, repeated, foreign or wrong."""

    def test_a_host_may_have_a_name(self):
        try:
            address = socket.gethostbyname("localhost")
        except OSError as e:
            self.skipTest(f"this host does not know localhost: {e}")
        port = FakeSensor(self, address, port=0).socket.getsockname()[1]
        found = self.json(DONE, f"localhost:{port}", "status")
        self.assertEqual(found["sensor"], f"{address}:{port}")
        self.assertEqual(run("lumctl", "status", env={**os.environ, "LUM_HOST": f"localhost:{port}"}).returncode, DONE)

    def third_host(self, hosts, address):
        """A computer without a sensor, on the same network; its MAC."""
        name = hosts.sensor + "t"
        self.addCleanup(subprocess.run, ["ip", "netns", "del", name], capture_output=True)
        hosts.ip("netns", "add", name)
        hosts.ip("-n", hosts.sensor, "link", "add", "link", "eth0", "name", "eth1", "type", "macvlan", "mode", "bridge")
        hosts.ip("-n", hosts.sensor, "link", "set", "eth1", "netns", name, "name", "eth0")
        hosts.ip("-n", name, "addr", "add", f"{address}/24", "dev", "eth0")
        hosts.ip("-n", name, "link", "set", "eth0", "up")
        return hosts.mac(name)

    def unprivileged(self, hosts, *words):
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        return subprocess.run([*inside(hosts.client), sys.executable, "-c",
                               "import os, sys; os.setgroups([]); os.setgid(65534); os.setuid(65534);"
                               "os.execv(sys.argv[1], sys.argv[1:])", copy, *map(str, words)],
                              capture_output=True, text=True, timeout=PATIENCE_S)

    @needs_namespaces
    def test_a_dry_run_refuses_what_this_host_knows_and_notes_what_the_network_tells(self):
        hosts = Hosts(self, self.folder)
        own = hosts.run("lumctl", "--dry-run", "set-ip", "10.42.0.1")
        self.assertEqual((own.returncode, own.stdout), (BAD, ""), own.stderr)
        self.assertIn("own address, on eth0", own.stderr)
        far = hosts.run("lumctl", "--dry-run", "set-ip", "10.43.0.9")
        self.assertEqual((far.returncode, far.stdout), (DONE, MAGIC.hex() + "050000000a2b0009\n"), far.stderr)
        self.assertIn("out of reach", far.stderr)

    @needs_namespaces
    def test_set_ip_takes_no_address_of_another_device(self):
        hosts = Hosts(self, self.folder)
        mac = self.third_host(hosts, "10.42.0.50")
        sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "0.5", address="10.42.0.37", namespace=hosts.sensor)
        for r, says in ((hosts.run("lumctl", "set-ip", "10.42.0.50"), f"({mac})"),
                        (hosts.run("lumctl", "--interface", "eth0", "set-ip", "10.42.0.50"), f"({mac})"),
                        (self.unprivileged(hosts, "set-ip", "10.42.0.50"), f"({mac}, as this host's ARP table says)")):
            self.assertEqual(r.returncode, BAD, r.stderr)
            self.assertIn(f"another device has 10.42.0.50 {says}", r.stderr)
            self.assertIn("nothing was sent. Choose another address; --force", r.stderr)
            self.assertEqual(sensor.events("set_ip"), [])
        # moved all the same, the sensor hears nothing: the other one answers ARP first
        hosts.ip("-n", hosts.sensor, "addr", "add", "10.42.0.50/32", "dev", "lo")
        subprocess.run([*inside(hosts.sensor), "sysctl", "-qw", "net.ipv4.conf.eth0.arp_ignore=1"], check=True)
        r = hosts.run("lumctl", "set-ip", "10.42.0.50", "--force")
        self.assertEqual((r.returncode, sensor.events("set_ip")[0]["address"]), (NO_ANSWER, "10.42.0.50"), r.stderr)
        self.assertIn(f"another device has 10.42.0.50 ({mac})", r.stderr)

    @needs_namespaces
    def test_set_ip_goes_back_to_an_address_that_the_sensor_had(self):
        hosts = Hosts(self, self.folder)
        hosts.ip("-n", hosts.sensor, "addr", "add", "10.42.0.50/24", "dev", "eth0")  # answers ARP, as this host's table knows
        Sensor(self, self.folder, "--lines", "64", "--rate", "0.5", address="10.42.0.37", namespace=hosts.sensor)
        for old, new in (("10.42.0.37", "10.42.0.50"), ("10.42.0.50", "10.42.0.37")):
            r = hosts.run("lumctl", "--host", old, "set-ip", new)
            self.assertEqual(r.returncode, DONE, r.stderr)
        for old, new in (("10.42.0.37", "10.42.0.50"), ("10.42.0.50", "10.42.0.37")):
            r = self.unprivileged(hosts, "--host", old, "set-ip", new)
            self.assertEqual(r.returncode, DONE, r.stderr)

    def test_a_hazard_that_is_over_before_the_answer_to_on_refuses_it(self):
        asked = []

        def answer(_, sequence, body, __):
            asked.append(body[4:])
            status = 0x0800 if body[4:] == b"u" else CMD_OFF
            alert = [tlv_packet(1 << 31, status_tlv(0x0840))] if body[4:] == b"u" else []
            return [*alert, tlv_packet(sequence, status_tlv(status))]

        FakeSensor(self, "127.33.2.99", answer)
        r = self.check(HAZARD, "127.33.2.99", "laser", "on")
        self.assertIn("FAN_PWM_BAD", r.stderr)
        self.assertIn("cancelled", r.stderr)
        self.assertEqual(asked[:2], [b"u", b"d"])

    def test_a_signal_ends_a_request_by_that_signal(self):
        asked = []
        FakeSensor(self, "127.33.2.22", lambda *_: asked.append(1) or [])
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.22", "status", *PATIENT)
        wait_until(lambda: asked, "the request")
        self.assertEqual(p.end(signal.SIGINT), -signal.SIGINT)
        self.assertIn("interrupted", p.stderr())


if __name__ == "__main__":
    shards.main()
