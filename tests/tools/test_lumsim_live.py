#!/usr/bin/env python3
"""lumsim on the network, seen by raw sockets: what it answers, what it sends, what its log says."""
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
from live import wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder, frames_of, group, pcap, run, simulate, udp

PORT = 5517
QUIET_S = 0.4      # for what must not
BUSY_S = 60.0      # by which a busy host may be late
BEAT_S = 0.2
LINE_US = 1563     # at most, of 64 at 10 Hz
RUNS = 10          # until a busy host does not hold up the simulator
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


def debug_of(packet):
    return [v.decode() for k, v in items_of(packet) if k == 3]


def is_data(packet):
    return packet[8] == 8 and len(packet) > 12


class Data:
    """A data packet."""

    def __init__(self, packet):
        self.tag, self.eye, self.line, self.count, self.first, self.clock = struct.unpack_from(
            "<BBHHHI", packet, 12)
        self.samples = packet[24:24 + 4 * self.count]

    def elevations(self):
        """In degrees, of the default calibration."""
        raw = struct.unpack(f"<{2 * self.count}h", self.samples)[1::2]
        return [-7 + r / 32768 * 10 for r in raw]


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

    def stopped(self):
        """The counts of the whole run."""
        self.end()
        return self.events("stop")[-1]


class Answers(Live):
    def test_it_says_what_it_is_before_it_renders_and_answers_at_once(self):
        client = self.start("--lines", 640, "--frames", 3, beats=False)
        self.assertEqual(self.ready, f"lumsim: a G2 at {self.host}:5517, 640 lines at 10 Hz; try: lumdump "
                                     f"udp://{self.host} --laser -o cloud.ply; Ctrl-C ends it\n")
        self.assertIsNotNone(client.clock())
        self.assertEqual(self.events("frames"), [])
        self.wait_for("frames", frames=3, lines=640)

    def test_a_clock_counts_microseconds_from_its_start(self):
        client = self.start("--clock", 7_000_000, beats=False)
        before = client.clock()
        after = client.clock()
        start = self.events("start")[0]
        self.assertEqual(start["clock_us"], 7_000_000)
        for clock, heard in zip((before, after), self.events("timestamp")):
            self.assertAlmostEqual(clock - 7_000_000, (heard["t"] - start["t"]) * 1e6, delta=2)

    def test_a_clock_wraps(self):
        client = self.start("--clock", 2**32 - 100_000, beats=False)
        before = client.clock()
        time.sleep(0.3)
        after = client.clock()
        t = [e["t"] for e in self.events("timestamp")]
        self.assertGreater(before, after)
        self.assertAlmostEqual((after - before) % 2**32, (t[1] - t[0]) * 1e6, delta=2)

    def test_a_clock_is_that_of_the_arrival(self):
        client = self.start(beats=False)
        first = client.clock()
        self.process.send_signal(signal.SIGSTOP)
        client.send(timestamp(7))
        time.sleep(0.5)
        self.process.send_signal(signal.SIGCONT)
        answer = client.first(lambda p: p[:16] == timestamp(7)[:16])
        heard = self.events("timestamp")
        late = self.wait_for("reply", sequence=7)["t"] - heard[1]["t"]
        self.assertGreater(late, 0.4)
        elapsed = struct.unpack_from("<I", answer, 16)[0] - first
        self.assertAlmostEqual(elapsed, (heard[1]["t"] - heard[0]["t"]) * 1e6, delta=2)

    def test_a_poll_shows_the_status_and_changes_nothing(self):
        client = self.start()
        client.data(1)
        for sequence in (0, 0xFFFFFFFF):
            self.assertEqual(list(items_of(client.ask(tlv(sequence)))), [(2, struct.pack("<H", 0x0200))])
        self.assertEqual(self.events("laser"), [])

    def test_commands_are_done_and_refusals_named(self):
        client = self.start()
        client.data(1)
        answer = client.command("u 50p 101p 7x")
        self.assertEqual(status_of(answer), 0x0800)
        said = " ".join(debug_of(answer))
        self.assertIn("101p", said)
        self.assertIn("7x", said)
        self.assertNotIn("50p", said)
        self.assertEqual(status_of(client.command("d")), 0x0200)
        self.assertEqual([e["up"] for e in self.events("laser")], [True, False])
        notes = [e["note"] for e in self.events("tlv")]
        self.assertIn("refused 101p", notes[0])
        self.assertEqual(notes[1], "d")

    def test_what_is_not_for_a_sensor_is_ignored_and_counted(self):
        client = self.start(beats=False)
        for packet in (b"", b"x", MAGIC, header(9), header(6), header(7)[:11], bytes(1400)):
            client.send(packet)
        self.assertIsNotNone(client.clock())
        heard = self.stopped()["heard"]
        self.assertEqual((heard["foreign"], heard["unknown_type"], heard["malformed"]), (5, 1, 1))

    def test_a_flood_does_not_fill_the_log(self):
        client = self.start(beats=False)
        for _ in range(20):
            for _ in range(100):
                client.send(b"not for a sensor")
            self.assertIsNotNone(client.clock())
        self.assertEqual(self.stopped()["heard"]["foreign"], 2000)
        logged = self.events("ignored")
        self.assertLess(len(logged), 200)
        self.assertEqual(sum(e["count"] for e in logged), 2000)

    def test_an_answer_can_be_delayed(self):
        client = self.start("--answer-delay", 300, beats=False)
        client.clock()
        client.command("d")
        for kind in ("timestamp", "tlv"):
            heard = self.events(kind)[0]
            sent = self.wait_for("reply", kind=kind, sequence=heard["sequence"])
            self.assertGreaterEqual(sent["t"] - heard["t"], 0.3)

    def test_an_answer_can_be_lost_and_the_command_is_done(self):
        client = self.start("--answer-loss", 1)
        client.data(1)
        self.assertIsNone(client.command("u", QUIET_S))
        self.wait_for("laser", up=True)
        self.wait_for("reply", kind="tlv", lost=True)
        stop = self.stopped()
        self.assertEqual((stop["answers"], stop["answers_lost"]), (0, 1))


class Heartbeats(Live):
    def test_without_them_laser_and_data_go_off_after_3_s(self):
        client = self.start()
        client.data(1)
        client.command("u")
        client.data(100)
        client.beats = False
        down = self.wait_for("laser", up=False)
        stop = self.wait_for("stream", to=None)
        last = self.events("heartbeat")[-1]
        for event in (down, stop):
            self.assertGreaterEqual(event["t"] - last["t"], 2.9)
        self.assertEqual(self.events("status")[-1]["status"] & 0x0010, 0x0010)
        client.drain()
        self.assertIsNone(client.first(is_data, QUIET_S))
        client.beats = True
        self.assertEqual(client.data(1)[0].line, 0)
        self.assertEqual(self.events("status")[-1]["status"] & 0x0010, 0)

    def test_laser_and_data_go_off_no_later(self):
        for _ in range(RUNS):
            self.host = next(HOSTS)
            client = self.start()
            client.data(1)
            client.command("u")
            client.beats = False
            ends = self.wait_for("laser", up=False)["t"], self.wait_for("stream", to=None)["t"]
            late_s = max(ends) - self.events("heartbeat")[-1]["t"]
            self.end()
            self.log.unlink()
            if late_s < 3.2:
                return
        self.fail(f"off {late_s} s after the last heartbeat")

    def test_the_last_one_s_sender_gets_the_data(self):
        first = self.start()
        first.data(10)
        second = Client(self, self.host)
        second.send(HEARTBEAT)
        self.wait_for("stream", to=second.name)
        first.beats = False
        first.drain()
        self.assertEqual(len(second.data(10)), 10)
        self.assertIsNone(first.first(is_data, QUIET_S))

    def test_nothing_is_sent_before_the_first_one(self):
        client = self.start(beats=False)
        self.wait_for("frames")
        self.assertIsNone(client.first(is_data, QUIET_S))
        self.assertEqual(self.stopped()["packets"], 0)


class Scene(Live):
    def words(self, client):
        """Range words of each line of a frame, of both eyes; a frame of which a busy host left out lines does not count."""
        client.drain()
        found, clock, whole = {}, None, False
        for packet, _ in client.packets():
            if not is_data(packet):
                continue
            d = Data(packet)
            if d.clock != clock:  # the first line was perhaps half gone
                if len(found) == 64:
                    return found
                if clock is not None and (d.clock - clock) % 2**32 > LINE_US:
                    found = {}
                clock, whole = d.clock, clock is not None
            if whole:
                found[d.line] = found.get(d.line, 0) + (d.count if d.tag == 3 else 0)
        self.fail("no whole frame")

    def density(self, client):
        return sum(self.words(client).values()) / 64

    def wait_for_reels(self, client, count):
        """Until frames have been rendered so many times; the data of before is gone then."""
        end = time.monotonic() + PATIENCE_S
        while len(self.events("frames")) < count:
            self.assertLess(time.monotonic(), end)
            client.data(50)
        client.drain()

    def test_the_laser_brings_the_ranges_and_takes_them(self):
        client = self.start()
        self.assertEqual({d.tag for d in client.data(500)}, {2})
        client.command("u")
        self.assertIsNotNone(client.first(lambda p: is_data(p) and p[12] == 3))
        client.command("d")
        self.assertEqual({d.tag for d in client.data(500)}, {2})

    def test_power_and_thresholds_thin_the_returns(self):
        client = self.start("--frames", 1)
        client.data(1)
        client.command("u")
        for _ in client.packets(3.2):  # until full strength
            pass
        full = self.density(client)
        self.assertEqual(self.density(client), full)
        client.command("100b 100g")
        high = self.density(client)
        client.command("0b 0g")
        low = self.density(client)
        client.command("50b 50g 25p")
        weak = self.density(client)
        client.command("0p")
        self.assertEqual({d.tag for d in client.data(500)}, {2})
        self.assertGreater(full, 1000)
        self.assertLess(high, full)
        self.assertGreater(low, full)
        self.assertLess(weak, high)

    def test_returns_grow_after_switching_on(self):
        client = self.start("--frames", 1)
        client.data(1)
        client.command("u")
        early = self.density(client)
        for _ in client.packets(3.2):
            pass
        self.assertGreater(self.density(client), 1.02 * early)

    def lines(self, client, count):
        """Numbers of the lines that come, of so many in a frame: of more than one if a busy host leaves lines out."""
        seen, packets = set(), 0
        for packet, _ in client.packets():
            if is_data(packet):
                seen.add(Data(packet).line)
                packets += 1
                if packets >= 6 * count and len(seen) >= count:
                    break
        return seen

    def test_a_frame_has_64_lines_or_640(self):
        client = self.start("--frames", 1)
        self.assertEqual(self.lines(client, 64), set(range(64)))
        client.command("0f")
        self.wait_for("frames", client, lines=640)
        client.drain()
        self.assertEqual(self.lines(client, 640), set(range(640)))
        client.command("1f")
        self.wait_for_reels(client, 3)
        self.assertLess(max(d.line for d in client.data(500)), 64)

    def test_a_y_scan_moves_the_lines(self):
        def span():
            found = [e for d in client.data(4 * 64 * 6) if d.tag == 2 for e in d.elevations()]
            return min(found), max(found)

        def after(send, count):
            send()
            self.wait_for_reels(client, count)
            return span()

        client = self.start("--frames", 1)
        low, high = span()
        self.assertLess(low, -16)
        self.assertGreater(high, 2)
        low, high = after(lambda: client.command("11y"), 2)
        self.assertGreater(low, -5.7)
        self.assertGreater(high, 2)
        table = struct.pack("<64h", *(round((-3 - i / 64 + 7) / 10 * 32768) for i in range(64)))
        low, high = after(lambda: client.ask(tlv(9, (4, table))), 3)
        self.assertGreater(low, -4.3)
        self.assertLess(high, -2.7)

    def test_a_new_scan_cuts_no_line(self):
        client = self.start("--frames", 1, beats=False)
        self.wait_for("frames")
        dump = subprocess.Popen([BIN / "lumdump", f"udp://{self.host}", "--json", "--quiet", "--duration", "4"],
                                stdout=subprocess.PIPE)
        self.addCleanup(dump.stdout.close)
        for i, command in enumerate(("11y", "30y", "20y", "12y", "15y", "28y", "17y", "19y")):
            self.wait_for("stream")
            client.command(command)
            wait_until(lambda: len(self.events("frames")) >= 2 + i, "the frames")
        found = json.loads(dump.stdout.read())
        self.assertEqual(dump.wait(), 0)
        self.assertGreater(found["lines"], 1000)
        self.assertEqual(found["lost_words"], 0)
        self.assertLessEqual(found["lines_missing_angles"], 2, "no more than the recording's end cuts")

    def test_the_pace_is_that_of_the_rate(self):
        for rate in (10, 25):
            with self.subTest(rate=rate):
                self.host = next(HOSTS)
                client = self.start("--rate", rate)
                self.wait_for("frames")
                self.assertEqual(len(client.data(int(2.5 * rate * 64 * 6))), int(2.5 * rate * 64 * 6))
                stop = self.stopped()
                seconds = stop["t"] - self.events("stream")[0]["t"]
                lines = stop["packets"] / 6 + stop["lines_skipped"]  # a busy host may skip some
                self.assertAlmostEqual(lines / (seconds * rate * 64), 1, delta=0.05)
                self.log.unlink()

    def test_a_host_that_was_held_up_skips_lines_and_sends_no_burst(self):
        client = self.start()
        client.data(100)
        self.process.send_signal(signal.SIGSTOP)
        time.sleep(1.0)
        self.process.send_signal(signal.SIGCONT)
        skipped = self.wait_for("skipped", client)["lines"]
        stop = self.stopped()
        self.assertGreaterEqual(skipped, 600)
        self.assertGreaterEqual(stop["lines_skipped"], skipped)
        seconds = stop["t"] - self.events("stream")[0]["t"]
        self.assertLessEqual(stop["lines"] + skipped, 640 * seconds + 10)

    def test_data_bears_the_sensor_s_clock(self):
        for _ in range(RUNS):
            self.host = next(HOSTS)
            client = self.start("--clock", 2**32 - 3_000_000, "--frames", 1)
            found = (Data(p) for p, _ in client.packets() if is_data(p))
            clocks = [d.clock for d in itertools.takewhile(lambda d: not 50_000 < d.clock < 2**31, found)]
            if self.stopped()["lines_skipped"] == 0 and clocks[0] > 2**31:
                break
        steps = {(b - a) % 2**32 for a, b in zip(clocks, clocks[1:])}
        self.assertLess(max(steps), 10_000)
        self.assertLessEqual({1562, 1563}, steps)
        self.assertGreater(clocks[0], 2**31)
        self.assertLess(clocks[-1], 2**31)


class Network(Live):
    def test_a_new_address_holds_at_once(self):
        client = self.start()
        client.data(10)
        new = next(HOSTS)
        client.send(set_ip(new))
        self.wait_for("move", address=new, done=True)
        old, client.sensor = client.sensor, new
        self.assertIsNotNone(client.clock())
        client.drain()
        self.assertEqual({s for p, s in itertools.islice(client.packets(), 100)}, {new})
        client.sensor, client.beats = old, False
        client.send(timestamp(1))
        self.assertIsNone(client.first(lambda p: p[:16] == timestamp(1)[:16], QUIET_S))

    def test_an_address_that_is_not_there_is_told_and_changes_nothing(self):
        client = self.start(beats=False)
        client.send(set_ip(MISSING))
        reason = self.wait_for("move", address=MISSING, done=False)["reason"]
        self.assertIn(MISSING, reason)
        self.assertIsNotNone(client.clock())
        self.assertIn(f"cannot move to {MISSING}", self.end())

    def test_packets_get_lost_repeated_and_corrupted(self):
        client = self.start("--loss", 1)
        self.wait_for("frames")
        self.assertEqual(client.data(1, QUIET_S), [])
        stop = self.stopped()
        self.assertEqual(stop["packets"], 0)
        self.assertGreater(stop["lost"], 100)
        self.host = next(HOSTS)
        client = self.start("--duplicate", 1, "--corrupt", 0.1)
        client.data(1000)
        stop = self.stopped()
        self.assertAlmostEqual(stop["packets"] / (12 * stop["lines"]), 1, delta=0.05)
        self.assertGreater(stop["corrupted"], 50)

    def test_jitter_reorders_and_loses_nothing(self):
        for _ in range(RUNS):
            self.host = next(HOSTS)
            client = self.start("--jitter", 20)
            clocks = [d.clock for d in client.data(4000)]
            self.assertNotEqual(clocks, sorted(clocks))
            spread = max(a - b for a, b in zip(clocks, clocks[1:]))
            self.assertGreater(spread, 5_000)
            stop = self.stopped()
            if stop["lines_skipped"] == 0:
                break
        self.assertEqual((stop["no_room"], stop["given_up"], stop["lines_skipped"]), (0, 0, 0))
        self.assertGreater(stop["packets"], 6 * (stop["lines"] - 64))

    def test_a_taken_port_is_told(self):
        self.start(beats=False)
        r = run("lumsim", "--address", self.host)
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertRegex(r.stderr, rf"{self.host}:5517 is taken by lumsim \(process {self.process.pid}\)")

    def test_what_cannot_be_opened_is_told(self):
        for arguments, status, says in [
                (("--address", MISSING), 1, MISSING),
                (("--address", self.host, "--interface", "nope0"), 2, "nope0"),
                (("--address", self.host, "--log", "/nonexistent/log"), 1, "/nonexistent/log")]:
            with self.subTest(arguments=arguments):
                r = run("lumsim", *arguments)
                self.assertEqual(r.returncode, status)
                self.assertIn(says, r.stderr)

    def test_another_port_is_possible(self):
        client = self.start("--port", 5999, beats=False)
        self.assertIn(f"udp://{self.host}:5999 ", self.ready)
        client.socket.sendto(timestamp(1), (self.host, 5999))
        self.assertIsNotNone(client.first(lambda p: True))


class Mishaps(Live):
    def test_a_hazard_turns_the_laser_off_and_passes(self):
        client = self.start("--fault", "fan@4s-5", "--fault", "interlock@6")
        client.beat()
        client.command("u")
        alerts = [client.first(lambda p: p[8] == 7) for _ in range(3)]
        self.assertEqual([status_of(a) for a in alerts], [0x0840, 0x0800, 0x0880])
        self.assertEqual([e["up"] for e in self.events("laser")], [True, False, True, False])
        start = self.events("start")[0]["t"]
        for fault, at in zip(self.events("fault"), (4, 5, 6)):
            self.assertGreaterEqual(fault["t"] - start, at)
            self.assertLess(fault["t"] - start, at + BUSY_S)
        self.assertEqual({d.tag for d in client.data(500)}, {2})

    def test_every_hazard_has_its_bit(self):
        names = ("galvo-bx", "galvo-by", "galvo-gx", "galvo-gy", None, "board", "fan", "interlock", "switch")
        faults = [x for n in names if n for x in ("--fault", f"{n}@0")]
        client = self.start(*faults, beats=False)
        self.wait_for("fault", name="switch")
        self.assertEqual(status_of(client.ask(tlv(1))) & 0x01EF, 0x01EF)

    def test_a_reboot_forgets_everything(self):
        client = self.start("--clock", 3_000_000_000, "--fault", "reboot@5")
        client.beat()
        client.command("u 20p")
        client.beats = False
        new = next(HOSTS)
        client.send(set_ip(new))
        self.wait_for("move", client, address=new)
        self.wait_for("move", client, address=self.host)
        self.assertLess(client.clock(), 2_000_000_000)
        self.assertEqual(status_of(client.ask(tlv(1))) & 0x0A00, 0x0200)
        self.assertEqual(self.events("laser")[-1]["up"], False)
        self.assertEqual(self.events("stream")[-1]["to"], None)
        client.drain()
        self.assertIsNone(client.first(is_data, QUIET_S))

    def test_silence_hears_nothing_and_sends_nothing(self):
        client = self.start("--fault", "silence@0")
        self.assertIsNone(client.clock(QUIET_S))
        stop = self.stopped()
        self.assertGreater(stop["unheard"], 1)
        self.assertEqual((stop["heard"]["heartbeat"], stop["answers"], stop["packets"]), (0, 0, 0))

    def test_silence_passes(self):
        client = self.start("--frames", 1, "--fault", "silence@5-5.5")
        client.data(10)
        self.wait_for("fault", client, name="silence", ends=True)
        self.assertIsNotNone(client.clock())
        self.assertEqual(len(client.data(10)), 10)
        stop = self.stopped()
        self.assertGreater(stop["unheard"], 0)
        self.assertGreater(stop["unsent"], 100)


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


class Ends(Live):
    def test_a_signal_ends_it_well_with_a_summary(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            self.host = next(HOSTS)
            client = self.start()
            client.data(200)
            said = self.end(number)
            stop = self.events("stop")[-1]
            self.assertRegex(said, r"^lumsim: \d+\.\d s: heard [1-9]\d* heartbeats, 0 TLV .*; "
                                   rf"sent 0 answers and {stop['packets']} data packets\n$")
            self.assertGreaterEqual(stop["packets"], 200)

    def test_while_rendering_too(self):
        self.start("--lines", 640, "--frames", 100, beats=False)
        self.end()
        self.assertEqual(self.events("frames"), [])

    def test_a_duration_ends_it(self):
        r = run("lumsim", "--address", self.host, "--duration", 0.3, "--log", self.log)
        self.assertEqual((r.returncode, r.stderr.count("\n")), (0, 2))
        stop, start = self.events("stop")[0], self.events("start")[0]
        self.assertGreaterEqual(stop["t"] - start["t"], 0.3)

    def test_quiet_says_nothing(self):
        r = run("lumsim", "--address", self.host, "--duration", 0.1, "-q")
        self.assertEqual((r.returncode, r.stdout, r.stderr), (0, "", ""))

    def test_the_log_s_reader_may_leave(self):
        self.start(log="-")
        self.assertEqual(json.loads(self.process.stdout.readline())["event"], "start")
        self.process.stdout.close()
        client = Client(self, self.host)
        client.send(timestamp(1))
        client.send(timestamp(2))
        self.assertEqual(self.process.wait(timeout=PATIENCE_S), 0)

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
                (("--replay", "x", "--speed", 0), "from 0.001 to 1000"),
                (("--frames", 1001), "at most 1000"),
                (("--fault", "fan"), "NAME@SECONDS"),
                (("--fault", "fun@1"), "galvo-bx.*silence"),
                (("--fault", "fan@"), "NAME@SECONDS"),
                (("--fault", "fan@x"), "NAME@SECONDS"),
                (("--fault", "fan@-1"), "NAME@SECONDS"),
                (("--fault", "fan@2-1"), "the second is later"),
                (("--fault", "reboot@2-3"), "a reboot has only one"),
                ((x for i in range(65) for x in ("--fault", f"fan@{i}")), "at most 32")]:
            arguments = tuple(arguments)
            with self.subTest(arguments=arguments):
                r = run("lumsim", *arguments)
                self.assertEqual((r.returncode, r.stdout), (2, ""))
                self.assertRegex(r.stderr, says)


if __name__ == "__main__":
    shards.main()
