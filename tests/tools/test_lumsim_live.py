#!/usr/bin/env python3
"""lumsim on a real network, and what it makes of captures and arguments. What it does over time: tests/world/stories/simulator.c."""
import itertools
import json
import os
import signal
import socket
import struct
import subprocess
import time
import unittest

import shards
from support import (BIN, MAGIC, PATIENCE_S, Folder, frames_of, group, interface, limited, packet, pcap, run, section,
                     simulate, udp)

PORT = 5517
QUIET_S = 0.4      # for what must not
BUSY_S = 60.0      # by which a busy host may be late
BEAT_S = 0.2
MISSING = "192.0.2.77"  # an address no host has

# Tests that run side by side do not share addresses.
HOSTS = (f"127.{64 + os.getpid() % 128}.{os.getpid() // 128 % 256}.{n}" for n in itertools.count(1))


def header(kind):
    return MAGIC + struct.pack("<I", kind)


HEARTBEAT = header(8)


def timestamp(sequence):
    return header(6) + struct.pack("<II", sequence, 0)


def tlv(sequence, *items):
    return header(7) + struct.pack("<I", sequence) + b"".join(
        struct.pack("<HH", kind, len(value)) + value for kind, value in items)


def set_ip(address):
    return header(5) + socket.inet_aton(address)


def items_of(packet):
    at = 16
    while at < len(packet):
        kind, length = struct.unpack_from("<HH", packet, at)
        yield kind, packet[at + 4:at + 4 + length]
        at += 4 + length


def status_of(packet):
    return next(struct.unpack("<H", v)[0] for k, v in items_of(packet) if k == 2)


def is_data(packet):
    return packet[8] == 8 and len(packet) > 12


class Data:
    """A data packet."""

    def __init__(self, packet):
        self.tag, self.eye, self.line, self.count, self.first, self.clock = struct.unpack_from(
            "<BBHHHI", packet, 12)
        self.samples = packet[24:24 + 4 * self.count]


class Client:
    """A socket that keeps a sensor awake while it receives."""

    def __init__(self, test, sensor):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        test.addCleanup(self.socket.close)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 23)
        self.socket.bind(("127.0.0.1", 0))
        self.name = "%s:%d" % self.socket.getsockname()
        self.sensor = sensor
        self.sequence = 100
        self.beats = True
        self.beat_at = 0.0

    def send(self, packet, to=None):
        self.socket.sendto(packet, (to or self.sensor, PORT))

    def beat(self):
        if self.beats and time.monotonic() >= self.beat_at:
            self.send(HEARTBEAT)
            self.beat_at = time.monotonic() + BEAT_S

    def packets(self, seconds=PATIENCE_S):
        """What comes, with its sender, for at most so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.beat()
            self.socket.settimeout(0.05)
            try:
                packet, sender = self.socket.recvfrom(65536)
            except socket.timeout:
                continue
            yield packet, sender[0]

    def first(self, wanted, seconds=PATIENCE_S):
        """The first packet that is wanted, or None."""
        return next((p for p, _ in self.packets(seconds) if wanted(p)), None)

    def ask(self, packet, seconds=PATIENCE_S):
        """The answer to a packet with a sequence."""
        self.send(packet)
        return self.first(lambda p: p[:16] == packet[:16], seconds)

    def command(self, text, seconds=PATIENCE_S):
        self.sequence += 1
        return self.ask(tlv(self.sequence, (1, text.encode())), seconds)

    def clock(self, seconds=PATIENCE_S):
        """The sensor's clock, or None."""
        self.sequence += 1
        answer = self.ask(timestamp(self.sequence), seconds)
        return answer and struct.unpack_from("<I", answer, 16)[0]

    def data(self, count, seconds=PATIENCE_S):
        """The next so many data packets."""
        found = (Data(p) for p, _ in self.packets(seconds) if is_data(p))
        return list(itertools.islice(found, count))

    def drain(self):
        self.socket.setblocking(False)
        try:
            while True:
                self.socket.recv(65536)
        except BlockingIOError:
            pass


class Live(unittest.TestCase):
    def setUp(self):
        self.dir = Folder(self)
        self.log = self.dir / "log.jsonl"
        self.host = next(HOSTS)

    def start(self, *arguments, log=None, beats=True):
        """A sensor, and a client for it."""
        self.process = subprocess.Popen(
            [BIN / "lumsim", "--address", self.host, "--log", log or self.log, *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(self.end, process=self.process)
        with limited(self.process):
            self.ready = self.process.stderr.readline().decode()
        client = Client(self, self.host)
        client.beats = beats
        return client

    def end(self, number=signal.SIGTERM, process=None):
        """End it, or one of before, well; the rest of what it said."""
        process = process or self.process
        if process.stderr.closed:
            return ""
        process.send_signal(number)
        process.stdout.close()
        with limited(process):
            said = process.stderr.read().decode()
        process.stderr.close()
        self.assertEqual(process.wait(timeout=PATIENCE_S), 0, said)
        return said

    def events(self, *names):
        """What the log holds so far."""
        whole = self.log.read_text().rpartition("\n")[0]
        found = [json.loads(line) for line in whole.splitlines()]
        return [e for e in found if not names or e["event"] in names]

    def wait_for(self, event, client=None, **values):
        """The first event of that kind and with those values. What a client gets meanwhile is gone."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            for found in self.events(event):
                if values.items() <= found.items():
                    return found
            if client is not None:
                client.beat()
                client.drain()
            time.sleep(0.02)
        self.fail(f"no {event} {values} in {self.events()}")


class Answers(Live):
    def test_it_says_what_it_is_before_it_renders_and_answers_at_once(self):
        client = self.start("--lines", 640, "--frames", 3, beats=False)
        self.assertEqual(self.ready, f"lumsim: a G2 at {self.host}:5517, 640 lines at 10 Hz; try: lumdump "
                                     f"udp://{self.host} --laser -o cloud.ply; Ctrl-C ends it\n")
        self.assertIsNotNone(client.clock())
        self.assertEqual(self.events("frames"), [])
        self.wait_for("frames", frames=3, lines=640)


class Network(Live):
    def test_an_address_that_is_not_there_is_told_and_changes_nothing(self):
        client = self.start(beats=False)
        client.send(set_ip(MISSING))
        reason = self.wait_for("move", address=MISSING, done=False)["reason"]
        self.assertIn(MISSING, reason)
        self.assertIsNotNone(client.clock())
        self.assertIn(f"cannot move to {MISSING}", self.end())

    def test_a_taken_port_is_told(self):
        self.start(beats=False)
        r = run("lumsim", "--address", self.host)
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertRegex(r.stderr, rf"{self.host}:5517 is taken by lumsim \(process {self.process.pid}\)")


class Replay(Live):
    def payloads(self, path, sensor=None):
        frames = frames_of(path.read_bytes())
        return [f[42:] for f in frames
                if sensor is None or f[26:30] == socket.inet_aton(sensor)]

    def received(self, client, count, seconds=PATIENCE_S):
        found = (p for p, _ in client.packets(seconds) if is_data(p))
        return list(itertools.islice(found, count))

    def test_packets_come_as_recorded(self):
        capture = simulate(self.dir / "street.pcap", "--frames", 3)
        recorded = self.payloads(capture)
        client = self.start("--replay", capture)
        self.assertEqual(self.received(client, len(recorded)), recorded)
        self.assertIsNone(client.first(is_data, QUIET_S))
        self.assertEqual(status_of(client.command("u")), 0x0800)
        replayed = self.wait_for("replayed", packets=len(recorded))
        seconds = replayed["t"] - self.events("stream")[0]["t"]
        self.assertGreater(seconds, 0.25)
        self.assertLess(seconds, 0.3 + BUSY_S)

    def test_speed_and_loop(self):
        capture = simulate(self.dir / "street.pcap", "--frames", 2)
        recorded = self.payloads(capture)
        client = self.start("--replay", capture, "--speed", 0.5, "--loop")
        self.assertEqual(self.received(client, 2 * len(recorded)), 2 * recorded)
        self.wait_for("replayed", client, rounds=2)
        seconds = self.events("replayed")[1]["t"] - self.events("stream")[0]["t"]
        self.assertGreater(seconds, 0.75)
        self.assertLess(seconds, 0.8 + BUSY_S)

    def test_it_begins_anew_when_the_data_does(self):
        capture = simulate(self.dir / "street.pcap", "--frames", 1)
        recorded = self.payloads(capture)
        client = self.start("--replay", capture)
        self.assertEqual(self.received(client, len(recorded)), recorded)
        client.beats = False
        self.wait_for("stream", to=None)
        client.beats = True
        self.assertEqual(self.received(client, len(recorded)), recorded)

    def test_one_sensor_of_several_is_asked_for(self):
        packets = [(group(2, 0, i, [bytes(4)]), sensor)
                   for i in range(50) for sensor in ("10.0.0.1", "10.0.0.2")]
        capture = self.dir.write("two.pcap", pcap([udp(p, source=s) for p, s in packets]))
        r = run("lumsim", "--address", self.host, "--replay", capture)
        self.assertEqual(r.returncode, 1)
        self.assertRegex(r.stderr, "10.0.0.1, 10.0.0.2; choose one by --sensor")
        r = run("lumsim", "--address", self.host, "--replay", capture, "--sensor", "10.0.0.3")
        self.assertEqual(r.returncode, 1)
        self.assertRegex(r.stderr, "no data of 10.0.0.3")
        client = self.start("--replay", capture, "--sensor", "10.0.0.2")
        self.assertEqual(self.received(client, 50), self.payloads(capture, "10.0.0.2"))

    def test_sensors_of_one_address_are_told_apart(self):
        sides = {name: list(frames_of(simulate(self.dir / "one.pcap", "--frames", 1, "--seed", seed).read_bytes()))
                 for name, seed in ((b"eth0", 4), (b"eth1", 3))}
        payloads = {name: [f[42:] for f in frames] for name, frames in sides.items()}
        mixed = [(i, f) for pair in zip(*sides.values()) for i, f in enumerate(pair)]
        mixed += [(i, f) for i, frames in enumerate(sides.values()) for f in frames[len(mixed) // 2:]]
        capture = self.dir.write("two.pcapng", section() + b"".join(interface(name=name) for name in sides) + b"".join(
            packet(f, i, 1_700_000_000_000_000 + 20 * n) for n, (i, f) in enumerate(mixed)))
        r = run("lumsim", "--address", self.host, "--replay", capture)
        self.assertEqual(r.returncode, 1)
        self.assertIn("10.42.0.37, 10.42.0.37%eth1; choose one by --sensor", r.stderr)
        r = run("lumsim", "--address", self.host, "--replay", capture, "--sensor", "10.42.0.37%eth2")
        self.assertEqual(r.returncode, 1)
        self.assertIn("no data of 10.42.0.37%eth2; there is data of 10.42.0.37, 10.42.0.37%eth1", r.stderr)
        for name, asked in ((b"eth1", "10.42.0.37%eth1"), (b"eth0", "10.42.0.37")):
            client = self.start("--replay", capture, "--sensor", asked)
            self.assertEqual("name the other as 10.42.0.37%eth1" in self.ready, "%" not in asked)
            self.assertEqual(self.received(client, len(payloads[name])), payloads[name])
            self.end()

    def test_another_port_is_told_and_can_be_chosen(self):
        data = [group(2, 0, i, [bytes(4)]) for i in range(4)]
        capture = self.dir.write("nat.pcap", pcap([udp(data[0]), *(udp(p, sport=5600) for p in data[1:])]))
        client = self.start("--replay", capture)
        self.assertIn("3 packets of a G2 came from UDP port 5600, but only port 5517 is read", self.ready)
        self.assertEqual(self.received(client, 1), data[:1])
        self.end()
        client = self.start("--replay", capture, "--sensor-port", 5600)
        self.assertEqual(self.received(client, 3), data[1:])

    def test_what_is_no_sensor_s_is_not_sent(self):
        data = group(2, 0, 1, [bytes(4)])
        capture = self.dir.write("mixed.pcap", pcap(
            [udp(HEARTBEAT, "10.42.0.1", "10.42.0.37", 50000, 5517), udp(b"other"), udp(data),
             udp(timestamp(3)), udp(data, sport=9, dport=10), udp(data)]))
        client = self.start("--replay", capture)
        self.assertEqual(self.received(client, 2), [data, data])
        self.assertIsNone(client.first(is_data, QUIET_S))

    def test_captures_without_data_are_refused(self):
        for content, says in [(pcap([udp(b"x")]), "not one data packet"), (b"junk", "not a capture")]:
            capture = self.dir.write("x.pcap", content)
            r = run("lumsim", "--address", self.host, "--replay", capture)
            self.assertEqual(r.returncode, 1)
            self.assertIn(says, r.stderr)

    def test_a_capture_that_is_cut_off_is_replayed_so_far(self):
        whole = simulate(self.dir / "street.pcap", "--frames", 1)
        capture = self.dir.write("cut.pcap", whole.read_bytes()[:-100])
        client = self.start("--replay", capture)
        self.assertIn("cannot be read to its end", self.ready)
        recorded = self.payloads(whole)[:-1]
        self.assertEqual(self.received(client, len(recorded)), recorded)


    def test_a_damaged_part_is_said(self):
        whole = simulate(self.dir / "street.pcap", "--frames", 1)
        made = self.dir / "damaged.pcapng"
        self.assertEqual(run("lumdump", whole, "-q", "-o", made).returncode, 0)
        content = bytearray(made.read_bytes())
        struct.pack_into("<I", content, content.index(self.payloads(whole)[3]) - 50, 65535)  # the length of its packet
        client = self.start("--replay", self.dir.write("damaged.pcapng", content))
        self.assertIn("1 part of it could not be read and was passed over: byte ", self.ready)
        recorded = self.payloads(whole)
        self.assertEqual(self.received(client, len(recorded) - 1), recorded[:3] + recorded[4:])


class Ends(Live):
    def test_while_rendering_too(self):
        self.start("--lines", 640, "--frames", 100, beats=False)
        self.end()
        self.assertEqual(self.events("frames"), [])

    def test_a_log_on_a_full_disk_ends_it(self):
        r = run("lumsim", "--address", self.host, "--log", "/dev/full")
        self.assertEqual(r.returncode, 1)
        self.assertRegex(r.stderr, "/dev/full cannot be written: No space left")


class Options(unittest.TestCase):
    def test_options_that_do_not_go_together_are_refused(self):
        for arguments, says in [
                (("--truth", "x"), "--truth works only with -o FILE"),
                (("--client", "10.0.0.1"), "--client works only with -o FILE"),
                (("--loop",), "--loop works only with --replay"),
                (("--speed", 2), "--speed works only with --replay"),
                (("--sensor", "10.0.0.1"), "--sensor works only with --replay"),
                (("--replay", "x", "--lines", 64), "--lines does not go with --replay"),
                (("--replay", "x", "--calibration", "y"), "--calibration does not go with --replay"),
                (("--replay", "x", "-o", "y"), "choose"),
                (("-o", "x", "--log", "y"), "--log .*does not go with -o"),
                (("-o", "x", "--fault", "fan@1"), "--fault .*does not go with -o"),
                (("-o", "x", "--duration", 1), "--duration .*does not go with -o"),
                (("-o", "x", "--jitter", 1), "--jitter .*does not go with -o")]:
            with self.subTest(arguments=arguments):
                r = run("lumsim", *arguments)
                self.assertEqual((r.returncode, r.stdout), (2, ""))
                self.assertRegex(r.stderr, says)

    def test_values_that_cannot_be_are_refused(self):
        for arguments, says in [
                (("--port", 0), "from 1 to 65535"),
                (("--clock", 2**32), "from 0 to 4294967295"),
                (("--duration", 0), "from 0.001"),
                (("--jitter", -1), "from 0 to 10000"),
                (("--answer-delay", "x"), "from 0 to 10000"),
                (("--answer-loss", 2), "probability"),
                *((("--boot-status", bits), "0 to 0xffff without the bit 0x0800") for bits in ("0x0810", "0x10000", "-1", "fan", "0x", "")),
                (("--replay", "x", "--speed", 0), "from 0.001 to 1000"),
                (("--frames", 1001), "at most 1000"),
                (("--fault", "fan"), "NAME@SECONDS"),
                (("--fault", "fun@1"), "galvo-bx.*silence"),
                (("--fault", "fan@"), "NAME@SECONDS"),
                (("--fault", "fan@x"), "NAME@SECONDS"),
                (("--fault", "fan@-1"), "NAME@SECONDS"),
                (("--fault", "fan@2-1"), "the second one later"),
                (("--fault", "reboot@2-3"), "a reboot has only one"),
                ((x for i in range(65) for x in ("--fault", f"fan@{i}")), "at most 32")]:
            arguments = tuple(arguments)
            with self.subTest(arguments=arguments):
                r = run("lumsim", *arguments)
                self.assertEqual((r.returncode, r.stdout), (2, ""))
                self.assertRegex(r.stderr, says)


if __name__ == "__main__":
    shards.main()
