"""Outages cut out of lumsim's captures: none is silent, and their lines are counted once (script/soak outages)."""
import importlib
import json
import pathlib
import random
import struct
import subprocess
import sys

SPANS = (0.3, 0.5, 0.8, 0.88, 0.93, 0.97, 1.0, 1.03, 1.2, 1.5, 1.97, 2.0, 2.5, 3.0, 5.2, 9.95, 10.0)  # sweeps
SHORTEST = (9, 12, 20)  # lines
NEAR_GAP_US = (100500, 103000, 115000, 138000)  # a little beyond the longest silence that is no break
EYES = (None, 0, 1)  # that have the outage; None: both
LOSSES = (0, 0.01)
FIRST = 2  # the sweep that an outage begins in
BEHIND = 2  # sweeps that come after it
LINES_OFF = 8
SHARE_OFF = 0.05
FAULTS = (("loss", 0.05), ("duplicate", 0.03), ("reorder", 0.06), ("corrupt", 0.02))
EYE, LINE, CLOCK = 42 + 13, 42 + 14, 42 + 20  # behind Ethernet, IPv4 and UDP


def simulate(bin_dir, path, *arguments):
    subprocess.run([bin_dir / "lumsim", "-q", "-o", path, "--returns-max", "1", *map(str, arguments)], check=True)


def summary(bin_dir, path):
    return json.loads(subprocess.run([bin_dir / "lumdump", path, "--json"], capture_output=True, text=True, check=True).stdout)


def records_of(path):
    """Of a pcap with nanoseconds: time in us, (eye, number, clock), whether it has ranges, bytes."""
    data, at = path.read_bytes(), 24
    while at < len(data):
        s, ns, size = struct.unpack_from("<III", data, at)
        record = data[at:at + 16 + size]
        yield s * 1e6 + ns / 1e3, (record[16 + EYE], *struct.unpack_from("<H", record, 16 + LINE), *struct.unpack_from("<I", record, 16 + CLOCK)), \
            record[16 + EYE - 1] != 2, record
        at += 16 + size


class Capture:
    """Records by the sensor's clock; of ranges one packet a line is kept."""

    def __init__(self, bin_dir, folder, lines, rate, sweeps, seed, loss=0.01, lumsdk=None):
        self.bin_dir, self.path, self.lumsdk = bin_dir, folder / "outage.pcap", lumsdk
        self.lines, self.sweep_us = lines, 1e6 / rate
        simulate(bin_dir, self.path, "--lines", lines, "--rate", rate, "--frames", sweeps, "--seed", seed, "--loss", loss)
        self.header, self.records, ranges = self.path.read_bytes()[:24], [], set()
        for us, line, is_range, record in records_of(self.path):
            if not is_range or line not in ranges:
                self.records.append((us, line, record))
            if is_range:
                ranges.add(line)
        self.records = [(us - self.records[0][0], line, record) for us, line, record in self.records]
        self.calm = {}  # by where it ends

    def summary_of(self, records):
        self.path.write_bytes(self.header + b"".join(record for _, _, record in records))
        return summary(self.bin_dir, self.path)

    def cut(self, begin_us, length_us, eye=None):
        """Records without an outage, and with it."""
        end_us = begin_us + length_us + BEHIND * self.sweep_us
        seen = [r for r in self.records if r[0] < end_us]
        return seen, [r for r in seen if not begin_us <= r[0] < begin_us + length_us or eye not in (None, r[1][0])]

    def without(self, begin_us, length_us, eye=None):
        """What the summary says."""
        return self.summary_of(self.cut(begin_us, length_us, eye)[1])

    def calm_summary(self, seen):
        if len(seen) not in self.calm:
            self.calm[len(seen)] = self.summary_of(seen)
        return self.calm[len(seen)]

    def is_beside_whole_frame(self, begin_us, kept, eye):
        """Whether a line beside the outage, which is not at the end of a sweep, is in a frame that is called complete."""
        before = [line for us, line, _ in kept if us < begin_us and eye in (None, line[0])][-1]
        behind = next(line for us, line, _ in kept if us >= begin_us and eye in (None, line[0]))
        beside = {line for line, end in ((before, self.lines - 1), (behind, 0)) if line[1] != end}
        return any(frame.complete and not beside.isdisjoint(zip(*(frame.lines[key].tolist() for key in ("eye", "number", "clock_us"))))
                   for frame in self.lumsdk.open(self.path, columns=("range",)))


def check(capture, begin_us, length_us, eye):
    """What is wrong with what is said of an outage, "" if nothing, and how many lines the numbers show too many, if they alone do, as
    of one eye's."""
    seen, kept = capture.cut(begin_us, length_us, eye)
    calm = capture.calm_summary(seen)
    got = capture.summary_of(kept)
    truth = len({line for _, line, _ in seen}) - len({line for _, line, _ in kept})
    skipped = got["lines_skipped"] - calm["lines_skipped"]
    off = skipped + got["lines_in_pauses"] - truth
    most = max(LINES_OFF, SHARE_OFF * truth)
    told = f"{truth} lines are missing, lines_skipped {skipped}, lines_in_pauses {got['lines_in_pauses']}, pauses {got['pauses']}"
    if skipped <= 0 and got["pauses"] == 0:
        return "silent: " + told, 0
    if calm["pauses"] or got["pauses"] > 1:
        return "more pauses than outages: " + told, 0
    if capture.lumsdk and capture.is_beside_whole_frame(begin_us, kept, eye):
        return "in a frame that is called complete: " + told, 0
    if eye is not None and off > most and got["lines_in_pauses"] == 0:
        return "", off  # lines_skipped is the protocol's: docs/protocol.md, section 6, Pauses
    return told if abs(off) > most else "", 0


def outages(bin_dir, folder, grids, lengths, phases, seed, losses=LOSSES, lumsdk=None):
    """Runs, failures, and by how many lines lines_skipped alone is too high, over grids of (lines, rate); lengths: of (lines, sweep_us).
    With the package lumsdk frames are looked at, too."""
    runs, wrong, too_many = 0, [], []
    for lines, rate in grids:
        all_us = lengths(lines, 1e6 / rate)
        for loss in losses:
            capture = Capture(bin_dir, folder, lines, rate, FIRST + BEHIND + int(max(all_us) * rate / 1e6) + 2, seed, loss, lumsdk)
            for length_us, eye, phase in ((n, e, p) for n in all_us for e in EYES for p in range(phases)):
                begin_us = (FIRST + (phase + 0.37) / phases) * capture.sweep_us
                runs += 1
                said, more = check(capture, begin_us, length_us, eye)
                if more:
                    too_many.append(more)
                if said:
                    wrong.append(f"{lines} lines, {rate} Hz, loss {loss}, eye {eye}, {length_us / 1000:.2f} ms from {begin_us / 1000:.2f} ms, seed {seed}: {said}")
    return runs, wrong, too_many


def all_lengths(lines, sweep_us):
    return [n * sweep_us / lines for n in SHORTEST] + [s * sweep_us for s in SPANS] + list(NEAR_GAP_US)


def calm(bin_dir, folder, count, first):
    """Captures without an outage, some with other faults: failures."""
    wrong, path = [], folder / "calm.pcap"
    for seed in range(first, first + count):
        at = random.Random(seed)
        lines, frames = (640, 3) if seed % 8 == 0 else (64, 6)
        faults = [str(a) for name, most in FAULTS for a in (f"--{name}", round(at.random() * most, 4))] if seed % 2 else []
        arguments = ["--lines", lines, "--frames", frames, "--rate", 1 + seed % 25, "--seed", seed, *faults]
        simulate(bin_dir, path, *arguments)
        got = summary(bin_dir, path)
        if got["pauses"]:
            wrong.append(f"{got['pauses']} pauses: lumsim {' '.join(map(str, arguments))}")
    return wrong


def quick(bin_dir, folder, lumsdk=None):
    """A part that takes seconds."""
    folder = pathlib.Path(folder)
    runs, wrong, too_many = outages(bin_dir, folder, [(64, 10)], lambda _, us: [s * us for s in (0.5, 0.93, 1.0, 2.0)], 5, 1, lumsdk=lumsdk)
    n, failed, more = outages(bin_dir, folder, [(64, 5)], lambda *_: NEAR_GAP_US[1:3], 5, 1, (0,), lumsdk)
    return runs + n, wrong + failed + calm(bin_dir, folder, 4, 1), too_many + more


def package(bin_dir):
    """The build's Python package, or None."""
    sys.path.insert(0, str(bin_dir.parent / "python"))
    try:
        return importlib.import_module("lumsdk")
    except ImportError as missing:
        print(f"frames are not looked at: {missing}")
        return None


def soak(bin_dir, folder, count, seed):
    folder, lumsdk = pathlib.Path(folder), package(bin_dir)
    runs, wrong, too_many = 0, [], []
    for lines, phases in ((64, 24), (640, 6)):
        for rate in (5, 10, 20):
            n, failed, more = outages(bin_dir, folder, [(lines, rate)], all_lengths, phases, seed + rate, lumsdk=lumsdk)
            print(f"{lines} lines, {rate} Hz: {n} outages, {len(failed)} wrong; lines_skipped alone has too many in {len(more)} of one eye", flush=True)
            runs, wrong, too_many = runs + n, wrong + failed, too_many + more
    wrong += calm(bin_dir, folder, count, seed)
    for line in wrong:
        print(line)
    print(f"{runs} outages and {count} captures without one: {len(wrong)} wrong; lines_skipped alone has too many in {len(too_many)} of one eye,"
          f" at most {max(too_many, default=0)}")
    return not wrong
