#!/usr/bin/env python3
"""lumctl: its words and packets, against lumsim, and against a sensor that misbehaves."""
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
from support import BIN, MAGIC, PATIENCE_S, Folder, ip, run

DONE, FAILED, BAD, NO_ANSWER, HAZARD = range(5)

# Where a busy machine may answer late, and it matters how often something was sent.
PATIENT = ["--timeout", 20000]
PICTURE = b"\033[H\033[J"
HEARTBEAT_TIMEOUT, FAN, CMD_OFF, CMD_ON = 0x0010, 0x0040, 0x0200, 0x0800


def status_tlv(value):
    return struct.pack("<HHH", 2, 2, value)


def debug_tlv(text):
    return struct.pack("<HH", 3, len(text)) + text.encode()


def tlv_packet(sequence, *tlvs):
    return MAGIC + struct.pack("<II", 7, sequence) + b"".join(tlvs)


class FakeSensor:
    """Answers as a test says: answer(kind, sequence, body, count) gives the packets to send back. body is what follows
    the sequence, count how many of this kind came before. Takes set IP packets in either byte order."""

    def __init__(self, test, address, answer=None, set_ip="network", port=5517):
        self.socket = self.bind(address, port)
        self.answer = answer or (lambda kind, sequence, body, count: self.plain(kind, sequence))
        self.set_ip = set_ip
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

    def texts(self):
        """The command texts that came, in order."""
        return [p[20:].decode() for p in self.of(7) if len(p) > 20]

    def commands(self):
        """The same, each once however often it was sent: a busy machine answers late."""
        by_sequence = {p[12:16]: p[20:].decode() for p in self.of(7) if len(p) > 20}
        return list(by_sequence.values())

    def move(self, order):
        address = self.packets[-1][12:16]
        if self.set_ip == "ignored":
            return
        self.socket.close()
        self.socket = self.bind(".".join(str(b) for b in (address if order == "network" else address[::-1])))

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
            if kind == 5:
                self.move(self.set_ip)
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
            self.assertEqual((r.returncode, r.stdout, r.stderr), (DONE, packet + "\n", ""), words)

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

    def test_a_host_in_the_environment_is_checked_and_an_option_is_stronger(self):
        r = run("lumctl", "status", "--retries", 0, "--timeout", 50, env={**os.environ, "LUM_HOST": "127.33.9.1"})
        self.assertEqual(r.returncode, NO_ANSWER)
        self.assertIn("127.33.9.1", r.stderr)
        r = run("lumctl", "--host", "127.33.9.2", "status", "--retries", 0, "--timeout", 50,
                env={**os.environ, "LUM_HOST": "127.33.9.1"})
        self.assertIn("127.33.9.2", r.stderr)
        self.one_line(run("lumctl", "status", env={**os.environ, "LUM_HOST": "here.invalid"}), "LUM_HOST",
                      "'here.invalid'")


class Help(Case):
    def test_help_names_every_command_and_each_has_its_own(self):
        r = run("lumctl", "--help")
        self.assertEqual((r.returncode, r.stderr), (DONE, ""))
        self.assertIn("Examples:", r.stdout)
        commands = re.findall(r"^  ([a-z][a-z-]*) ", r.stdout.split("Options")[0], re.M)
        self.assertEqual(len(commands), 19)
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
        for words in ([], ["status"], ["send"], ["yscan"], ["heartbeat"]):
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

    def notes(self, sensor):
        once = {e["sequence"]: e.get("note", "") for e in sensor.events("tlv")}  # however often it was sent
        return [word for note in once.values() for word in note.split()]

    def test_status_of_a_sensor_that_nobody_uses_is_idle_and_well(self):
        self.sensor("127.33.1.1")
        found = wait_until(lambda: (s := self.json(DONE, "127.33.1.1", "status"))["idle"] and s, "idleness")
        self.assertEqual(found["laser"], "down")
        self.assertEqual(found["hazards"], [])
        self.assertIn("HEARTBEAT_TIMEOUT", found["bits"])
        self.assertEqual(int(found["status_hex"], 16), found["status"])
        self.assertEqual(found["sensor"], "127.33.1.1")
        self.assertGreater(found["round_trip_ms"], 0)
        r = self.check(DONE, "127.33.1.1", "status")
        self.assertIn("idle", r.stdout)
        self.assertNotIn("HAZARD", r.stdout)
        self.assertNotIn("\033", r.stdout)

    def test_a_hazard_comes_first_and_is_exit_status_4(self):
        self.sensor("127.33.1.2", "--fault", "fan@0")
        r = wait_until(lambda: "FAN" in (r := self.ctl("127.33.1.2", "status")).stdout and r, "the hazard")
        self.assertEqual(r.returncode, HAZARD)
        kinds = [text.split()[0] for text in r.stdout.splitlines()[1:]]
        self.assertEqual(kinds, sorted(kinds, key=lambda k: k != "HAZARD"))
        self.assertIn("FAN_PWM_BAD", self.json(HAZARD, "127.33.1.2", "status")["hazards"])
        r = self.check(HAZARD, "127.33.1.2", "laser", "on")
        self.assertIn("FAN_PWM_BAD", r.stderr)
        self.assertEqual(self.check(DONE, "127.33.1.2", "power", 40).stderr, "")

    def assert_no_laser_after_the_hazard(self, sensor):
        """The heartbeats went on, the hazard ended, and time has passed: all by the sensor's log."""
        end = sensor.cue(signal.SIGUSR2)["t"]
        wait_until(lambda: len(sensor.events("heartbeat", after=end)) > 5, "heartbeats without the hazard")
        self.assertEqual(sensor.events("laser"), [])
        self.assertEqual(sensor.events("status")[-1]["bits"], ["TLV_CMD_OFF"])

    def test_a_laser_on_that_a_hazard_defeats_is_taken_back(self):
        sensor = self.sensor("127.33.1.15", "--fault", "interlock@USR1-USR2")
        sensor.cue(signal.SIGUSR1)
        self.heartbeats("127.33.1.15")
        r = self.check(HAZARD, "127.33.1.15", "laser", "on")
        self.assertIn("HW_SAFETY_BAD", r.stderr)
        self.assertIn("taken back: it will not come up by itself", r.stderr)
        self.assertIs(self.json(HAZARD, "127.33.1.15", "laser", "on")["taken_back"], True)
        self.assertEqual(self.notes(sensor).count("u"), 2)
        self.assert_no_laser_after_the_hazard(sensor)
        self.assertNotIn("taken_back", self.json(DONE, "127.33.1.15", "laser", "on"))

    def test_a_raw_u_that_a_hazard_defeats_is_taken_back(self):
        sensor = self.sensor("127.33.1.16", "--fault", "fan@USR1-USR2")
        sensor.cue(signal.SIGUSR1)
        self.heartbeats("127.33.1.16")
        self.assertIn("taken back", self.check(HAZARD, "127.33.1.16", "send", "50p u").stderr)
        r = run("lumctl", "--host", "127.33.1.16", "shell", stdin=b"u\n")
        self.assertEqual(r.returncode, HAZARD)
        self.assertIn("taken back", r.stderr)
        self.assert_no_laser_after_the_hazard(sensor)

    def test_every_setting_is_carried_out_before_it_is_called_done(self):
        sensor = self.sensor("127.33.1.3")
        for words, text in ((["power", 40], "40p"), (["threshold", "green", 41], "41g"), (["threshold", "blue", 42], "42b"),
                            (["lines", 64], "1f"), (["yscan", 15], "15y"), (["holdoff", 170], "170h"),
                            (["offset", "green", 3], "3G"), (["offset", "blue", 4], "4B")):
            said = self.check(DONE, "127.33.1.3", *words).stdout
            self.assertIn(f"127.33.1.3: {' '.join(map(str, words))} done; ", said)
            self.assertIn(text, self.notes(sensor))
            found = self.json(DONE, "127.33.1.3", *words)
            self.assertEqual((found["command"], found["done"], found["refused"]), (text, True, ""))
        self.check(DONE, "127.33.1.3", "send", "51p 52g")
        self.assertIn("52g", self.notes(sensor))

    def test_a_raw_tlv_shows_what_came_back(self):
        self.sensor("127.33.1.4")
        found = self.json(DONE, "127.33.1.4", "tlv", "1:3530", "9:dead")
        self.assertTrue(any("50" in text for text in found["debug"]), found)
        self.assertIn("it says: ", self.check(DONE, "127.33.1.4", "tlv", "1:3530").stdout)

    def test_time_is_the_sensors_with_its_error_bound(self):
        self.sensor("127.33.1.5", "--clock", "4200000000")
        found = self.json(DONE, "127.33.1.5", "time")
        self.assertEqual(found["exchanges"], 8)
        self.assertGreaterEqual(found["error_ns"], int(found["round_trip_min_ms"] * 5e5) - 1000)
        self.assertGreater(found["clock_us"], 4199999999)
        r = self.check(DONE, "127.33.1.5", "time", "--watch", "--duration", "2.5")
        self.assertRegex(r.stdout.splitlines()[-1], r"Z  clock 1:1\d:\d\d\.\d{6}  offset \d+\.\d{6} s \+-[\d.]+ [um]s  round trip")
        lines = self.check(DONE, "127.33.1.5", "time", "--watch", "--duration", "1.5", "--json").stdout.splitlines()
        self.assertEqual(json.loads(lines[-1])["resets"], 0)
        self.assertIn("+-", self.check(DONE, "127.33.1.5", "time").stdout)

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

    def test_one_program_is_the_session_and_a_second_is_told_so(self):
        self.sensor("127.33.1.7")
        first = self.heartbeats("127.33.1.7")
        self.assertIn("this is now the session", first.stderr())
        second = self.ctl("127.33.1.7", "heartbeat", "--duration", 1)
        self.assertEqual(second.returncode, FAILED)
        self.assertIn("lumctl", second.stderr)
        self.assertIn(str(first.p.pid), second.stderr)
        self.check(DONE, "127.33.1.7", "power", 40)
        self.assertEqual(first.end(signal.SIGINT), DONE)

    def test_heartbeats_come_at_the_rate_for_the_duration(self):
        sensor = self.sensor("127.33.1.8")
        for _ in range(20):  # until this machine does not hold it up
            before = len(sensor.events("heartbeat"))
            found = json.loads(self.check(DONE, "127.33.1.8", "heartbeat", "--rate", 10, "--duration", 2, "--json")
                               .stdout.splitlines()[-1])
            wait_until(lambda before=before, n=found["heartbeats"]: len(sensor.events("heartbeat")) == before + n, "all of them")
            self.assertLess(found["heartbeats"], 23)
            if found["heartbeats"] >= 18 and found["packets"] > 0:
                return
        self.fail(found)

    def test_set_ip_proves_the_new_address(self):
        sensor = self.sensor("127.33.1.9")
        r = self.check(DONE, "127.33.1.9", "set-ip", "127.33.1.10")
        self.assertIn("127.33.1.10", r.stdout)
        self.assertIn("10.42.0.37", r.stderr)
        self.assertEqual([e["address"] for e in sensor.events("set_ip")], ["127.33.1.10"])
        self.check(DONE, "127.33.1.10", "status")
        self.assertEqual(self.json(DONE, "127.33.1.10", "set-ip", "127.33.1.9")["answers_at"], "new")
        self.check(DONE, "127.33.1.9", "set-ip", "127.33.1.9")

    def test_a_watch_logs_changes_with_their_time(self):
        sensor = self.sensor("127.33.1.11")
        watch = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.1.11", "status", "--watch")
        wait_until(lambda: watch.stdout() and len(sensor.events("tlv")) >= 4, "a few polls")
        self.heartbeats("127.33.1.11")
        self.check(DONE, "127.33.1.11", "laser", "on")
        wait_until(lambda: "laser up" in watch.stdout(), "the laser in the watch")
        self.assertEqual(watch.end(signal.SIGINT), DONE)
        lines = watch.stdout().splitlines()
        for before, after in zip(lines, lines[1:]):
            self.assertNotEqual(before.split(" ", 1)[1], after.split(" ", 1)[1])
        self.assertRegex(lines[0], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z 127\.33\.1\.11: laser down")

    def test_a_watch_ends_with_4_on_a_hazard_and_with_0_by_a_signal_without(self):
        self.sensor("127.33.1.12", "--fault", "fan@0")
        wait_until(lambda: "FAN" in self.ctl("127.33.1.12", "status").stdout, "the hazard")
        watch = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.1.12", "status", "--watch", "--json")
        wait_until(lambda: "\n" in watch.stdout(), "a status")
        self.assertEqual(watch.end(signal.SIGINT), HAZARD)
        self.assertIn("FAN_PWM_BAD", json.loads(watch.stdout().splitlines()[0])["hazards"])
        self.check(HAZARD, "127.33.1.12", "status", "--watch", "--duration", 3)

    def test_a_reader_that_leaves_ends_a_watch_quietly(self):
        self.sensor("127.33.1.13", "--fault", "fan@3")
        p = subprocess.Popen([BIN / "lumctl", "--host", "127.33.1.13", "time", "--watch"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
        p.stdout.readline()
        p.stdout.close()
        self.assertEqual(p.wait(PATIENCE_S), DONE)
        self.assertEqual(p.stderr.read(), b"")
        p.stderr.close()

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

    def test_no_answer_is_exit_status_3_after_the_tries_that_were_asked_for(self):
        fake = FakeSensor(self, "127.33.2.1", lambda *_: [])
        r = self.check(NO_ANSWER, "127.33.2.1", "power", 50, "--timeout", 60, "--retries", 2)
        self.assertIn("doctor --host 127.33.2.1", r.stderr)
        self.assertEqual(r.stdout, "")
        wait_until(lambda: len(fake.texts()) >= 3, "the last try")
        self.assertEqual(fake.texts(), ["50p"] * 3)
        self.assertEqual(len({p[12:16] for p in fake.of(7)}), 1)
        self.check(NO_ANSWER, "127.33.2.1", "time", "--timeout", 60, "--retries", 2)
        wait_until(lambda: len(fake.of(6)) >= 3, "the last try")
        self.assertEqual(len({p[12:16] for p in fake.of(6)}), 3)

    def test_a_lost_answer_is_asked_for_again(self):
        FakeSensor(self, "127.33.2.2", lambda kind, sequence, body, count:
                   FakeSensor.plain(kind, sequence) if count == 2 else [])
        self.assertEqual(self.json(DONE, "127.33.2.2", "power", 50, "--timeout", 1500)["tries"], 3)

    def test_answers_to_others_sequences_do_not_count(self):
        FakeSensor(self, "127.33.2.3", lambda kind, sequence, body, count:
                   [tlv_packet((sequence + d) & 0xffffffff, status_tlv(0x0900)) for d in (1, -1, 0x80000000)])
        self.check(NO_ANSWER, "127.33.2.3", "power", 50, "--timeout", 60, "--retries", 1)

    def test_an_answer_before_the_question_is_not_believed(self):
        """A late answer of an earlier request follows, and the next request gets its own."""
        FakeSensor(self, "127.33.2.4", lambda kind, sequence, body, count:
                   FakeSensor.plain(kind, sequence, clock=1000 * count) * 2)
        self.assertEqual(self.json(DONE, "127.33.2.4", "time")["exchanges"], 8)

    def test_a_command_that_the_answer_names_is_refused(self):
        FakeSensor(self, "127.33.2.5", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, status_tlv(CMD_OFF), debug_tlv("cannot: 15y"))])
        r = self.check(FAILED, "127.33.2.5", "send", "50p 15y")
        self.assertIn("'15y'", r.stderr)
        self.assertIn("cannot: 15y", r.stdout)
        found = self.json(FAILED, "127.33.2.5", "send", "50p 15y")
        self.assertEqual((found["done"], found["refused"]), (False, "15y"))
        self.assertIn("cannot: 15y", self.check(FAILED, "127.33.2.5", "send", "50p 5g").stderr)

    def test_a_refusal_is_told_from_a_confirmation_and_need_not_name_anything(self):
        said = {}
        FakeSensor(self, "127.33.2.30", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, status_tlv(CMD_OFF), *(debug_tlv(t) for t in said["texts"]))])
        for texts, status, refused, says in (
                (["3 more refused"], FAILED, "", "3 more refused"),
                (["Invalid command"], FAILED, "", "Invalid command"),
                (["50p"], FAILED, "50p", "refused '50p'; the others are done"),
                (["50p: limit is 40"], FAILED, "50p", "limit is 40"),
                (["50p not set"], FAILED, "50p", "50p not set"),
                (["refused 50p: hot", "2 more refused"], FAILED, "50p", "'50p' and more"),
                (["50p set"], DONE, "", ""),
                (["50p ok", "5g refused"], FAILED, "5g", "'5g'; the others"),
                (["a cool day"], DONE, "", "")):
            said["texts"] = texts
            found = self.ctl("127.33.2.30", "send", "50p 5g", "--json")
            out = json.loads(found.stdout)
            self.assertEqual((found.returncode, out["done"], out["refused"]), (status, status == DONE, refused), texts)
            self.assertIn(says, found.stderr)

    def test_raw_text_for_the_laser_is_done_when_the_answer_shows_it(self):
        state = {}
        FakeSensor(self, "127.33.2.31", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, *([] if state["is"] is None else [status_tlv(state["is"])]))])
        for text, status, expected in (("u", CMD_ON | FAN, HAZARD), ("u", CMD_OFF, FAILED), ("u", None, FAILED),
                                       ("50p u", CMD_ON, DONE), ("d", CMD_ON, FAILED), ("d", None, FAILED),
                                       ("u d", CMD_OFF, DONE), ("50p", CMD_ON | FAN, DONE)):
            state["is"] = status
            self.assertEqual(self.json(expected, "127.33.2.31", "send", text)["done"], expected == DONE, (text, status))

    def test_a_laser_on_that_cannot_be_taken_back_is_told(self):
        begun = []
        for address, words in (("127.33.2.35", ["laser", "on"]), ("127.33.2.47", ["send", "u"])):
            fake = FakeSensor(self, address, lambda kind, sequence, body, count:
                              [] if body.endswith(b"d") else FakeSensor.plain(kind, sequence, CMD_ON | FAN))
            begun.append((fake, Process(self, self.folder, BIN / "lumctl", "--host", address, *words)))
        for fake, p in begun:
            self.assertEqual(p.wait(), HAZARD, p.stderr())
            self.assertIn("NOT taken back", p.stderr())
            self.assertIn("WILL COME UP by itself", p.stderr())
            self.assertNotIn("it will not come up", p.stderr())
            self.assertEqual(fake.texts()[0], "u")
            self.assertEqual(set(fake.texts()[1:]), {"d"})

    def test_a_d_that_changes_nothing_takes_nothing_back(self):
        FakeSensor(self, "127.33.2.36", lambda kind, sequence, body, count:
                   FakeSensor.plain(kind, sequence, CMD_ON | FAN))
        self.assertIn("WILL COME UP", self.check(HAZARD, "127.33.2.36", "laser", "on").stderr)
        self.assertIs(self.json(HAZARD, "127.33.2.36", "send", "u")["taken_back"], False)

    def test_a_laser_on_without_an_answer_is_taken_back(self):
        """The sensor got it, and its answers were lost."""
        state = {"now": CMD_OFF}

        def answer(kind, sequence, body, count):
            if body.endswith(b"u"):
                state["now"] = CMD_ON
                return []
            state["now"] = CMD_OFF if body.endswith(b"d") else state["now"]
            return FakeSensor.plain(kind, sequence, state["now"])

        fake = FakeSensor(self, "127.33.2.37", answer)
        r = self.check(NO_ANSWER, "127.33.2.37", "laser", "on", "--timeout", 60, "--retries", 1)
        self.assertIn("taken back: it will not come up by itself", r.stderr)
        self.assertEqual(fake.texts()[:3], ["u", "u", "d"])
        self.assertEqual(fake.commands(), ["u", "d"])
        self.assertEqual(state["now"], CMD_OFF)

    def test_a_signal_does_not_keep_laser_on_from_being_taken_back(self):
        fake = FakeSensor(self, "127.33.2.38", lambda kind, sequence, body, count:
                          [] if body.endswith(b"u") else FakeSensor.plain(kind, sequence))
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.38", "laser", "on", *PATIENT)
        wait_until(fake.texts, "the command")
        self.assertEqual(p.end(signal.SIGINT), -signal.SIGINT)
        self.assertEqual(fake.commands(), ["u", "d"])
        self.assertIn("taken back", p.stderr())

    def test_a_laser_that_is_on_is_called_on_whatever_was_refused(self):
        FakeSensor(self, "127.33.2.46", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, status_tlv(CMD_ON), debug_tlv("refused u"))])
        r = self.check(FAILED, "127.33.2.46", "laser", "on")
        self.assertIn("laser ON, though the command was refused", r.stdout)
        self.assertNotIn("not on", r.stdout)

    def test_a_round_trip_is_not_known_when_the_request_was_sent_twice(self):
        FakeSensor(self, "127.33.2.32", lambda kind, sequence, body, count:
                   FakeSensor.plain(kind, sequence) if count % 2 else [])
        for words in (["status"], ["power", 50]):
            found = self.json(DONE, "127.33.2.32", *words, "--timeout", 1500)
            self.assertEqual((found["tries"], found["round_trip_ms"]), (2, None))
        self.assertNotIn("round trip", self.check(DONE, "127.33.2.32", "status", "--timeout", 1500).stdout)

    def test_a_second_signal_does_not_cut_laser_off_short(self):
        fake = FakeSensor(self, "127.33.2.33", lambda kind, sequence, body, count:
                          [(0.1, p) for p in FakeSensor.plain(kind, sequence)])
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.33", "laser", "off")
        wait_until(fake.texts, "the command")
        p.send(signal.SIGINT)
        time.sleep(0.05)
        p.send(signal.SIGTERM)
        self.assertEqual(p.wait(), DONE, p.stderr())

    def test_laser_off_is_repeated_often_and_for_ten_seconds(self):
        """What comes in the ninth second does it."""
        fake = FakeSensor(self, "127.33.2.48", lambda kind, sequence, body, count:
                          FakeSensor.plain(kind, sequence) if time.monotonic() - fake.first > 8 else [])
        fake.first = time.monotonic()
        self.check(DONE, "127.33.2.48", "laser", "off", "--timeout", 60, "--retries", 0)
        self.assertGreater(len(fake.texts()), 20)
        self.assertEqual(set(fake.texts()), {"d"})

    def test_a_second_signal_ends_a_laser_off_that_goes_on(self):
        fakes = {last: FakeSensor(self, f"127.33.2.{last}", lambda *_: []) for last in (49, 51)}
        cut, full = [Process(self, self.folder, BIN / "lumctl", "--host", f"127.33.2.{last}", "laser", "off") for last in fakes]
        wait_until(lambda: "laser off is repeated" in cut.stderr(), "the notice")
        for number in signal.SIGINT, signal.SIGTERM:  # two of one number could come as one
            cut.send(number)
        for p in cut, full:
            self.assertEqual(p.wait(), NO_ANSWER, p.stderr())
            self.assertIn("MAY BE ON", p.stderr())
        commands = [len(fake.texts()) for fake in fakes.values()]  # 3 s of them, and 10 s
        self.assertLess(commands[0], 0.75 * commands[1])

    def test_raw_text_that_switches_off_is_not_left_to_one_try(self):
        fake = FakeSensor(self, "127.33.2.50", lambda kind, sequence, body, count:
                          FakeSensor.plain(kind, sequence) if count > 3 else [])
        r = self.check(NO_ANSWER, "127.33.2.50", "send", "50p d", "--timeout", 60, "--retries", 0)
        self.assertIn("the laser is off; whether the rest", r.stderr)
        self.assertEqual(fake.texts()[:2], ["50p d", "d"])

    def test_silence_of_an_owner_is_a_hazard(self):
        FakeSensor(self, "127.33.2.34", lambda kind, sequence, body, count:
                   FakeSensor.plain(kind, sequence, HEARTBEAT_TIMEOUT | CMD_OFF))
        self.assertIs(self.json(DONE, "127.33.2.34", "status")["idle"], True)
        owner = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.34", "heartbeat")
        wait_until(lambda: "this is now the session" in owner.stderr(), "the session")
        owner.send(signal.SIGSTOP)
        found = self.json(HAZARD, "127.33.2.34", "status")
        self.assertEqual((found["idle"], found["laser"]), (False, "down"))
        r = self.check(HAZARD, "127.33.2.34", "status")
        self.assertIn("its owner's heartbeats do not come", r.stdout)
        self.assertIn(str(owner.p.pid), r.stdout)
        self.assertIn("HAZARD", r.stdout)
        watch = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.34", "status", "--watch")
        wait_until(lambda: "its owner's heartbeats do not come" in watch.stdout(), "the hazard")
        self.assertEqual(watch.end(signal.SIGINT), HAZARD)
        owner.kill()
        self.check(DONE, "127.33.2.34", "status")

    def test_what_comes_unasked_is_told_and_is_no_answer(self):
        FakeSensor(self, "127.33.2.6", lambda kind, sequence, body, count:
                   [tlv_packet(0, status_tlv(0x0840), debug_tlv("fan \033[2J slow")), (0.05, tlv_packet(sequence, status_tlv(0x0840)))])
        r = self.check(DONE, "127.33.2.6", "power", 50)
        self.assertIn("says: fan ?[2J slow", r.stderr)
        self.assertIn("FAN_PWM_BAD", r.stderr)

    def test_malformed_answers_are_no_answers(self):
        FakeSensor(self, "127.33.2.7", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, b"\x02\x00\xff\xff\x00"), MAGIC[:5], b"", MAGIC + b"\x07\x00\x00"])
        self.check(NO_ANSWER, "127.33.2.7", "power", 50, "--timeout", 60, "--retries", 1)

    def test_an_answer_without_status_is_no_status(self):
        FakeSensor(self, "127.33.2.8", lambda kind, sequence, body, count: [tlv_packet(sequence)])
        self.assertIn("no status", self.check(FAILED, "127.33.2.8", "status").stderr)
        self.assertIn("no status", self.check(DONE, "127.33.2.8", "power", 50).stdout)
        for words in (["laser", "on"], ["laser", "off"], ["send", "d"]):
            r = self.check(FAILED, "127.33.2.8", *words)
            self.assertIn("tlv.status of the profile" if words[0] == "send" or words[1] == "on" else
                          "answered without a status TLV", r.stderr)
            self.assertIn("tlv.status", r.stderr)

    def test_bits_without_a_name_are_shown(self):
        FakeSensor(self, "127.33.2.9", lambda kind, sequence, body, count:
                   [tlv_packet(sequence, status_tlv(0xffff))])
        bits = self.json(HAZARD, "127.33.2.9", "status")["bits"]
        self.assertEqual(len(bits), 16)
        self.assertIn("BIT_10", bits)
        self.assertIn("BIT_15", self.check(HAZARD, "127.33.2.9", "status").stdout)

    def test_laser_on_needs_a_status_that_shows_it(self):
        statuses = iter([CMD_OFF, 0, HEARTBEAT_TIMEOUT | CMD_ON, CMD_ON | 0x0400, CMD_ON])
        fake = FakeSensor(self, "127.33.2.10", lambda kind, sequence, body, count:
                          FakeSensor.plain(kind, sequence, next(statuses) if body.endswith(b"u") else CMD_OFF))
        on = ["laser", "on", *PATIENT]
        self.check(FAILED, "127.33.2.10", *on)
        self.assertEqual(self.json(DONE, "127.33.2.10", *on)["laser"], "up")
        self.assertIn("nobody sends heartbeats", self.check(FAILED, "127.33.2.10", *on).stderr)
        self.assertIn("BIT_10", self.check(FAILED, "127.33.2.10", *on).stderr)
        self.check(DONE, "127.33.2.10", *on)
        self.assertEqual(fake.commands(), ["u", "d", "u", "u", "d", "u", "d", "u"])

    def test_laser_off_ends_in_one_of_three_ways(self):
        FakeSensor(self, "127.33.2.11", lambda kind, sequence, body, count: FakeSensor.plain(kind, sequence, CMD_ON))
        r = self.check(FAILED, "127.33.2.11", "laser", "off", "--timeout", 60, "--retries", 1)
        self.assertIn("laser is ON", r.stderr)
        FakeSensor(self, "127.33.2.12", lambda *_: [])
        r = self.check(NO_ANSWER, "127.33.2.12", "laser", "off", "--timeout", 60, "--retries", 1)
        self.assertIn("MAY BE ON", r.stderr)
        self.assertIs(self.json(NO_ANSWER, "127.33.2.12", "laser", "off", "--timeout", 60, "--retries", 1)["done"], False)
        fake = FakeSensor(self, "127.33.2.13")
        self.check(DONE, "127.33.2.13", "laser", "off")
        self.assertEqual(fake.commands(), ["d"])

    def test_a_host_may_have_a_name(self):
        try:
            address = socket.gethostbyname("localhost")
        except OSError as e:
            self.skipTest(f"this host does not know localhost: {e}")
        port = FakeSensor(self, address, port=0).socket.getsockname()[1]
        found = self.json(DONE, f"localhost:{port}", "status")
        self.assertEqual(found["sensor"], f"{address}:{port}")
        self.assertEqual(run("lumctl", "status", env={**os.environ, "LUM_HOST": f"localhost:{port}"}).returncode, DONE)

    def test_set_ip_finds_a_sensor_that_took_the_bytes_the_other_way_round(self):
        FakeSensor(self, "127.33.2.14", set_ip="little")
        r = self.check(FAILED, "127.33.2.14", "set-ip", "127.33.2.127")
        self.assertIn("127.2.33.127", r.stderr)
        self.assertIn("set_ip_order: little", r.stderr)

    def test_set_ip_finds_a_sensor_that_has_not_moved(self):
        fake = FakeSensor(self, "127.33.2.15", set_ip="ignored")
        r = self.check(FAILED, "127.33.2.15", "set-ip", "127.33.2.16")
        self.assertIn("still answers at 127.33.2.15", r.stderr)
        self.assertGreater(len(fake.of(5)), 1)
        self.assertEqual(fake.of(5)[0][12:], ip("127.33.2.16"))

    def test_set_ip_looks_for_a_sensor_on_a_bad_wire_as_long_as_it_is_told(self):
        for at, lost, words in ((81, 16, ()), (83, 25, ("--timeout", 500, "--retries", 59))):
            def answer(kind, sequence, body, count, lost=lost):
                moved = [i for i, p in enumerate(fake.packets) if p[8] == 5]
                asked = [p for p in fake.packets[moved[0]:] if p[8] == 6] if moved else None
                return FakeSensor.plain(kind, sequence) if asked is None or len(asked) > lost else []
            fake = FakeSensor(self, f"127.33.2.{at}", answer)
            self.check(DONE, f"127.33.2.{at}", "set-ip", f"127.33.2.{at + 1}", *words)
            self.assertEqual(len(fake.of(5)), 1)

    def test_set_ip_does_not_give_two_sensors_one_address(self):
        fake = FakeSensor(self, "127.33.2.23")
        FakeSensor(self, "127.33.2.24")
        r = self.check(FAILED, "127.33.2.23", "set-ip", "127.33.2.24")
        self.assertIn("another sensor has 127.33.2.24", r.stderr)
        self.assertEqual(fake.of(5), [])

    def test_set_ip_says_when_nobody_answers_anywhere(self):
        r = self.check(NO_ANSWER, "127.33.2.17", "set-ip", "127.33.2.18")
        for text in ("127.33.2.17", "127.33.2.18", "The packet may still have arrived", "doctor", "10.42.0.37"):
            self.assertIn(text, r.stderr)
        self.assertEqual(self.json(NO_ANSWER, "127.33.2.17", "set-ip", "127.33.2.18")["answers_at"], "nowhere")

    @needs_namespaces
    def test_that_the_reversed_address_cannot_be_reached_is_no_news(self):
        r = Hosts(self, self.folder).run("lumctl", "--host", "127.0.0.9", "set-ip", "127.0.0.6")
        self.assertEqual(r.returncode, NO_ANSWER, r.stderr)
        self.assertIn("nobody answers at 127.0.0.6, nor at 127.0.0.9 or 6.0.0.127. ", r.stderr)
        self.assertNotIn("cannot send", r.stderr)
        r = Hosts(self, self.folder).run("lumctl", "--host", "127.0.0.9", "set-ip", "192.168.9.6", "--force")
        self.assertRegex(r.stderr.splitlines()[0], r"^lumctl: cannot send .* to 192\.168\.9\.6")
        self.assertIn("nobody answers at 192.168.9.6", r.stderr.splitlines()[1])

    @needs_namespaces
    def test_set_ip_strands_no_sensor(self):
        hosts = Hosts(self, self.folder)
        hosts.ip("-n", hosts.client, "link", "add", "other0", "type", "veth", "peer", "name", "other1")
        hosts.ip("-n", hosts.client, "addr", "add", "10.50.0.1/24", "dev", "other0")
        for name in ("other0", "other1"):
            hosts.ip("-n", hosts.client, "link", "set", name, "up")
        sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "0.5", address="10.42.0.37", namespace=hosts.sensor)

        def refused(address, *says, words=()):
            r = hosts.run("lumctl", "set-ip", address, *words)
            self.assertEqual(r.returncode, BAD, (address, r.stderr))
            self.assertEqual(sensor.events("set_ip"), [], address)
            for text in says:
                self.assertIn(text, r.stderr)

        force = "nothing was sent. --force"
        refused("10.42.0.1", "10.42.0.1 is this host's own address, on eth0", force)
        refused("10.50.0.1", "own address, on other0", force)
        refused("127.0.0.1", "loopback", force)
        refused("127.33.0.5", "loopback", force)
        refused("10.42.0.255", "the broadcast address of eth0's subnet 10.42.0.0/24", force)
        refused("10.42.0.0", "the network address of eth0's subnet 10.42.0.0/24", force)
        refused("10.50.0.255", "the broadcast address of other0's", force)
        refused("10.50.0.7", "is reached by other0, and the sensor is at eth0", force)
        refused("192.168.9.6", "out of reach: no route of eth0 leads there", force)
        hosts.ip("-n", hosts.client, "route", "add", "default", "via", "10.42.0.254")
        refused("192.168.9.6", "is reached by a gateway (eth0)", force)
        refused("192.168.9.6", "is reached by a gateway (eth0)", words=("--interface", "eth0"))
        for never in ("0.0.0.0", "224.0.0.1", "255.255.255.255"):
            refused(never, "not an address that a sensor can have", words=("--force",))
        shell = subprocess.run([*inside(hosts.client), BIN / "lumctl", "shell"], input="set-ip 10.42.0.255\n",
                               capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(shell.returncode, BAD)
        self.assertIn("broadcast", shell.stderr)
        self.assertEqual(sensor.events("set_ip"), [])

        # with a route of the sensor's interface, or when it is forced, it is sent
        hosts.ip("-n", hosts.client, "route", "add", "10.43.0.0/24", "dev", "eth0")
        for address, words in (("10.43.0.5", ()), ("10.42.0.255", ("--force",))):
            hosts.run("lumctl", "set-ip", address, *words, "--timeout", 50)
            self.assertEqual(sensor.events("set_ip")[-1]["address"], address)

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

    def test_force_goes_with_set_ip_alone(self):
        self.assertIn("--force does not go with power; it goes with set-ip",
                      self.check(BAD, "127.33.2.20", "power", 50, "--force").stderr)

    def test_heartbeats_that_bring_no_data_are_told(self):
        FakeSensor(self, "127.33.2.19")
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.19", "heartbeat")
        wait_until(lambda: "no data has come for 2 s" in p.stderr(), "the news")
        self.assertEqual(p.end(signal.SIGINT), DONE, p.stderr())
        r = self.check(NO_ANSWER, "127.33.2.20", "heartbeat", "--duration", "0.5")
        self.assertIn("does not answer (--duration ended after 0.5 s)", r.stderr)
        self.assertIn("heartbeats go to 127.33.2.20", r.stderr)
        self.assertNotIn("this is now the session", r.stderr)

    def test_a_watch_that_hears_nothing_says_so(self):
        for what in ("status", "time"):
            r = self.check(NO_ANSWER, "127.33.2.20", what, "--watch", "--duration", "0.3")
            self.assertIn("(--duration ended after 0.3 s)", r.stderr)
            self.assertNotIn("tried", r.stderr)
        r = self.check(NO_ANSWER, "127.33.2.20", "status", "--watch", "--duration", "0.3", "--json")
        self.assertEqual([json.loads(line)["answers"] for line in r.stdout.splitlines()], [False])

    def test_a_watch_tells_silence_and_goes_on(self):
        state = {"silent": False}
        FakeSensor(self, "127.33.2.21", lambda kind, sequence, body, count:
                   [] if state["silent"] else FakeSensor.plain(kind, sequence))
        watch = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.21", "status", "--watch", "--timeout", 50,
                        "--retries", 1)
        wait_until(lambda: "laser down" in watch.stdout(), "a status")
        state["silent"] = True
        wait_until(lambda: "does not answer" in watch.stdout(), "silence")
        state["silent"] = False
        wait_until(lambda: watch.stdout().count("laser down") == 2, "a status again")
        self.assertEqual(watch.end(signal.SIGINT), DONE)

    def test_a_signal_ends_a_request_by_that_signal(self):
        asked = []
        FakeSensor(self, "127.33.2.22", lambda *_: asked.append(1) or [])
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.33.2.22", "status", *PATIENT)
        wait_until(lambda: asked, "the request")
        self.assertEqual(p.end(signal.SIGINT), -signal.SIGINT)
        self.assertIn("interrupted", p.stderr())


class SetIpAndHeartbeat(Case):
    """What a session that owns the sensor does meanwhile, and when a move is one."""

    def assert_steady(self, sensor, begin, end):
        """Between two times of the log, heartbeats keep the sensor's laser on."""
        times = [e["t"] for e in sensor.events("heartbeat") if begin <= e["t"] <= end]
        self.assertGreater(len(times), 5)
        self.assertLess(max(b - a for a, b in zip(times, times[1:])), 3.0)

    def shell(self, address, *arguments):
        return Process(self, self.folder, BIN / "lumctl", "--host", address, "shell", *arguments,
                       stdin=subprocess.PIPE)

    def test_heartbeats_go_on_while_set_ip_looks_in_vain(self):
        # takes no set IP packet: it expects one of another profile
        profile = self.folder.write("p.yaml", "version: 1\nset_ip_order: little\n")
        sensor = Sensor(self, self.folder, "--rate", 2, "-q", "--profile", profile, address="127.33.5.1")
        shell = self.shell("127.33.5.1", "--heartbeat")
        shell.p.stdin.write(b"set-ip 127.33.5.2\n")
        shell.p.stdin.flush()
        wait_until(lambda: "still answers" in shell.stderr(), "the end of the looking")
        times = [e["t"] for e in sensor.events("heartbeat")]
        self.assert_steady(sensor, times[0], times[-1])
        shell.p.stdin.close()
        shell.wait()

    def test_a_sensor_that_is_moved_by_another_is_named_with_its_new_address(self):
        for at, words in ((11, ["heartbeat"]), (13, ["shell", "--heartbeat"])):
            old, new = f"127.33.5.{at}", f"127.33.5.{at + 1}"
            sensor = Sensor(self, self.folder, "--lines", "64", "--rate", "2", address=old)
            p = Process(self, self.folder, BIN / "lumctl", "--host", old, *words, stdin=subprocess.PIPE)
            wait_until(lambda: sensor.events("stream"), "the stream")
            self.check(DONE, old, "set-ip", new)
            wait_until(lambda: f"the data comes from {new} now, not from {old}" in p.stdout() + p.stderr(), "the new address")
            p.end(signal.SIGINT if at == 11 else signal.SIGTERM)

    def test_a_sensor_that_had_the_address_before_is_no_move(self):
        other = FakeSensor(self, "127.33.5.4")
        r = self.check(FAILED, "127.33.5.3", "set-ip", "127.33.5.4")
        self.assertIn("127.33.5.4 answers already; nothing was sent", r.stderr)
        self.assertEqual(r.stdout, "")
        self.assertEqual(other.of(5), [])

    def test_it_is_found_where_its_first_answers_were_lost(self):
        fake = FakeSensor(self, "127.33.5.6", lambda kind, sequence, body, count:
                          [] if count < 2 else FakeSensor.plain(kind, sequence))
        r = self.check(FAILED, "127.33.5.5", "set-ip", "127.33.5.6")
        self.assertIn("127.33.5.6 answers already", r.stderr)
        self.assertEqual(fake.of(5), [])

    def full_pipe(self):
        """The end to write to of a pipe that is full and that nobody reads."""
        ends = os.pipe()
        for end in ends:
            self.addCleanup(os.close, end)
        os.set_blocking(ends[1], False)
        try:
            while True:
                os.write(ends[1], bytes(4096))
        except BlockingIOError:
            os.set_blocking(ends[1], True)
        return ends[1]

    def test_heartbeats_go_on_though_nobody_reads_what_is_told(self):
        sensor = Sensor(self, self.folder, "--rate", 2, "-q", address="127.33.5.7")
        full = self.full_pipe()
        p = subprocess.Popen([BIN / "lumctl", "--host", "127.33.5.7", "heartbeat"], stdin=subprocess.DEVNULL,
                             stdout=full, stderr=full)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        wait_until(lambda: len(sensor.events("heartbeat")) > 2, "heartbeats")
        self.check(DONE, "127.33.5.7", "laser", "on")
        sensor.send(signal.SIGSTOP)  # no data for 2 s, which is worth a word
        time.sleep(3)
        sensor.send(signal.SIGCONT)
        count = len(sensor.events("heartbeat"))
        wait_until(lambda: len(sensor.events("heartbeat")) > count + 25, "further heartbeats")
        self.assertIsNone(p.poll())


if __name__ == "__main__":
    shards.main()
