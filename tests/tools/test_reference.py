#!/usr/bin/env python3
"""test_reference.py [--seeds N] [--first SEED] [--keep DIRECTORY]

Makes captures full of faults near every limit of docs/protocol.md, section 6,
and holds lumdump (in $LUM_BIN) against the slow reading in reference.py. A
failure names its seed; --first SEED --seeds 1 repeats it.
"""
import argparse
import csv
import json
import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

import reference
from support import PATIENCE_S

MAGIC = reference.MAGIC
SENSOR = bytes((10, 42, 0, 37))
CLIENT = bytes((10, 42, 0, 1))
TOLERANCE = {"range": 1e-3, "azimuth": 5e-4, "elevation": 5e-4,
             "pulse_width": 1e-2}


class Scan:
    """What a sensor sends when nothing goes wrong."""

    def __init__(self, rng):
        self.rng = rng
        self.lines = rng.choice((10, 17, 24, 33, 64))
        self.frames = max(2, 160 // self.lines)
        self.line_us = rng.choice((0, 1, 100, 500, 1999, 2000, 2001, 4500))
        self.first_clock = rng.choice((0, 5, 2**31 - 3000, 2**32 - 9000,
                                       rng.getrandbits(32)))
        self.stamp = rng.choice(("line", "packet"))
        self.skew = rng.choice((0, 0, 1, 7, 8, 9, self.lines // 2))
        self.pixels = rng.randint(4, 24)

    def packets(self):
        """Tuples of eye, line, tag, first, samples, clock, in time's order."""
        step = 0
        for _ in range(self.frames):
            for line in range(self.lines):
                clock = self.first_clock + step * self.line_us
                for eye in (0, 1):
                    number = (line + eye * self.skew) % self.lines
                    yield from self.line(eye, number, clock)
                step += 1

    def line(self, eye, number, clock):
        rng = self.rng
        base = rng.randint(0, 1000 - self.pixels)
        index = 0
        packets = []
        for first, count in self.cuts(self.pixels):
            samples = [struct.pack("<hh", rng.randint(-32768, 32767),
                                   rng.randint(-32768, 32767))
                       for _ in range(count)]
            packets.append([eye, number, 2, base + first, samples])
        for first, count in self.cuts(self.pixels):
            words = []
            for pixel in range(base + first, base + first + count):
                words += self.words(pixel)
            if rng.random() < 0.15:
                rng.shuffle(words)
            if words:
                packets.append([eye, number, 3, index, words])
                index += len(words)
        if rng.random() < 0.2:
            rng.shuffle(packets)
        for i, packet in enumerate(packets):
            yield packet + [clock + (i * 7 if self.stamp == "packet" else 0)]

    def cuts(self, total):
        first = 0
        while first < total:
            count = min(self.rng.randint(1, 12), total - first)
            yield first, count
            first += count

    def words(self, pixel):
        rng = self.rng
        for _ in range(rng.choice((0, 1, 1, 1, 2, 2, 3, 4))):
            tof = rng.choice((rng.randint(-2, 2), rng.randint(1, 524287),
                              rng.randint(100, 9000), -524288, 524287))
            word = (tof & 0xFFFFF) << 12 | rng.randint(0, 1) << 10 | pixel
            if rng.random() < 0.02:
                word |= 0x800
            if rng.random() < 0.02:
                word = word & ~0x3FF | rng.randint(995, 1023)
            yield struct.pack("<I", word)


class Chaos:
    """What a network and a bad day make of it."""

    def __init__(self, rng, scan):
        self.rng = rng
        self.scan = scan
        self.loss = rng.choice((0, 0, 0.02, 0.1, 0.4))
        self.repeat = rng.choice((0, 0.05, 0.2))
        self.delay = rng.choice((0, 0.02, 0.15))
        self.twist = rng.choice((0, 0.01, 0.05, 0.15))
        self.reach = rng.choice((3, 12, 40, 90, 200))
        self.outage = 0.004 if rng.random() < 0.4 else 0
        self.clock_shift = 0
        self.silent = {0: 0, 1: 0}
        self.shift = rng.choice((0, 0, 0.003))

    def stream(self):
        placed = []
        for at, packet in enumerate(self.scan.packets()):
            packet = self.clock_jumps(packet)
            if self.is_lost(packet[0]):
                continue
            placed.append((at + self.wait(), packet))
            while self.rng.random() < self.repeat:
                placed.append((at + self.wait(always=True), packet))
        placed.sort(key=lambda p: p[0])
        for _, packet in placed:
            if self.rng.random() < self.twist:
                packet = self.twisted(packet)
            yield packet

    def clock_jumps(self, packet):
        if self.rng.random() < self.shift:
            far = reference.GAP_US + self.rng.randint(-2, 2)
            self.clock_shift += self.rng.choice(
                (far, -far, far, 10**6, -10**6, 2**31, 60000, -60000))
        return packet[:5] + [packet[5] + self.clock_shift]

    def is_lost(self, eye):
        if self.silent[eye] > 0:
            self.silent[eye] -= 1
            return True
        if self.rng.random() < self.outage:
            per_line = 8
            self.silent[eye] = per_line * self.rng.choice(
                (7, 8, 9, 10, self.scan.lines - 8, self.scan.lines,
                 2 * self.scan.lines + 5))
        return self.rng.random() < self.loss

    def wait(self, always=False):
        if always or self.rng.random() < self.delay:
            return self.rng.uniform(0, self.reach)
        return 0

    def twisted(self, packet):
        rng = self.rng
        eye, line, tag, first, samples, clock = packet
        what = rng.randrange(8)
        if what == 0:
            span = reference.LINE_SPAN_US
            clock += rng.choice((span, span + 1, -span, -span - 1, 1, -1,
                                 rng.randint(-9000, 9000)))
        elif what == 1:
            gap = reference.GAP_US
            clock += rng.choice((gap, gap + 1, -gap, -gap - 1, 1 << 20,
                                 1 << rng.randrange(32)))
        elif what == 2:
            line = (line + rng.choice((-9, -8, -7, -1, 1, 7, 8, 9, 16,
                                       1 << rng.randrange(16)))) & 0xFFFF
        elif what == 3:
            eye = 1 - eye
        elif what == 4:
            first = (first + rng.choice((-1, 1, 5, 16384, -first,
                                         1 << rng.randrange(16)))) & 0xFFFF
        elif what == 5 and tag == 3:
            samples = samples + self.strange_words()
        elif what == 6:
            samples = samples[rng.randrange(len(samples)):]
        else:
            return rng.choice(self.not_data(packet))
        return [eye, line, tag, first, samples, clock]

    def strange_words(self):
        rng = self.rng
        return [struct.pack("<I", rng.getrandbits(32))
                for _ in range(rng.randint(1, 4))]

    def not_data(self, packet):
        """Datagrams that never reach the assembler, as bytes."""
        rng = self.rng
        data = datagram(packet)
        return [
            data[:rng.randrange(len(data))],
            data[:12] + b"\x02\x02" + data[14:],
            data[:12] + bytes((rng.choice((0, 1, 4, 255)),)) + data[13:],
            data[:16] + b"\0\0" + data[18:],
            data[:16] + b"\xff\xff" + data[18:],
            data[:8] + bytes((rng.randrange(256), 0, 0, rng.randrange(2)))
            + data[12:],
            data + rng.randbytes(rng.randint(1, 9)),
            MAGIC + bytes((5, 0, 0, 0)) + rng.randbytes(rng.randint(0, 5)),
            MAGIC + bytes((6, 0, 0, 0)) + rng.randbytes(rng.randint(0, 9)),
            MAGIC + bytes((7, 0, 0, 0)) + rng.randbytes(rng.randint(0, 9)),
            MAGIC + bytes((8, 0, 0, 0)),
            rng.randbytes(rng.randint(0, 40)),
        ]


def fat_line(rng, clock):
    """Packets about the most words that a line can have."""
    most = reference.WORDS_OF_A_LINE
    index = 0
    pixels = list(range(1000))
    rng.shuffle(pixels)
    for count in (most // 2, most // 2 - rng.randint(0, 3), rng.randint(1, 4),
                  rng.randint(1, 4)):
        some = [pixels.pop() for _ in range(min(count, 300))]
        words = [struct.pack("<I", rng.randint(1, 99999) << 12 | rng.choice(
            (0, 0x400)) | some[i % len(some)]) for i in range(count)]
        yield [0, 1, 3, index, words, clock]
        index += count


def datagram(packet):
    if isinstance(packet, bytes):
        return packet
    eye, line, tag, first, samples, clock = packet
    return (MAGIC + struct.pack("<IBBHHHI", 8, tag, eye, line, len(samples),
                                first, clock & 0xFFFFFFFF)
            + b"".join(samples))


def ethernet(payload):
    udp = struct.pack(">HHHH", 5517, 40000, 8 + len(payload), 0) + payload
    ip = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(udp), 0, 0x4000, 64, 17,
                     0) + SENSOR + CLIENT + udp
    return b"\x02\0\0\0\0\1\x02\0\0\0\0\2\x08\0" + ip


def write_capture(path, packets):
    with open(path, "wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 262144, 1))
        for i, packet in enumerate(packets):
            frame = ethernet(datagram(packet))
            file.write(struct.pack("<IIII", 1_600_000_000 + i // 1000000,
                                   i % 1000000, len(frame), len(frame)))
            file.write(frame)


def make_capture(path, seed):
    rng = random.Random(seed)
    scan = Scan(rng)
    packets = list(Chaos(rng, scan).stream())
    if seed % 10 == 3:
        packets = [*fat_line(rng, scan.first_clock), *packets]
    write_capture(path, packets)


def lumdump(*arguments):
    tool = pathlib.Path(os.environ["LUM_BIN"]) / "lumdump"
    run = subprocess.run([tool, *map(str, arguments)], capture_output=True,
                         text=True, timeout=PATIENCE_S, check=False)
    if run.returncode != 0:
        raise RuntimeError(f"lumdump ends with {run.returncode}: "
                           f"{run.stderr.strip()}")
    return run.stdout


def differs(column, want, got):
    if column in TOLERANCE:
        return abs(want - float(got)) > TOLERANCE[column]
    return want != int(got)


def compare_rows(want, path):
    with open(path, newline="", encoding="ascii") as file:
        got = list(csv.DictReader(file))
    for i, (w, g) in enumerate(zip(want, got)):
        for column, value in zip(reference.COLUMNS, w):
            if differs(column, value, g[column]):
                return (f"row {i + 1}, {column}: want {value}, got "
                        f"{g[column]} ({g})")
    if len(want) != len(got):
        return f"{len(got)} points, want {len(want)}"
    return None


def compare(capture, folder, rows, counters):
    """What is wrong with lumdump's reading of a capture, or None."""
    out = folder / "out.csv"
    lumdump(capture, "--edge", "both", "-o", out)
    wrong = compare_rows(rows, out)
    if wrong:
        return wrong
    summary = json.loads(lumdump(capture, "--edge", "both", "--json"))
    wrong = {k: (v, summary.get(k)) for k, v in counters.items()
             if summary.get(k) != v}
    return f"counters (want, got): {wrong}" if wrong else None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    failed = 0
    totals = dict.fromkeys(reference.COUNTERS, 0)
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        for seed in range(options.first, options.first + options.seeds):
            capture = folder / f"seed-{seed}.pcap"
            make_capture(capture, seed)
            rows, counters = reference.run(capture)
            wrong = compare(capture, pathlib.Path(temporary), rows, counters)
            for key, value in counters.items():
                totals[key] += value
            if wrong:
                failed += 1
                print(f"seed {seed}: {wrong}")
            if not options.keep:
                capture.unlink()
    print(f"{options.seeds - failed} of {options.seeds} captures agree")
    unseen = [k for k, v in totals.items() if v == 0]
    if options.seeds >= 40 and unseen:
        print(f"no capture shows {', '.join(unseen)}")
        failed += 1
    print(json.dumps(totals))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
