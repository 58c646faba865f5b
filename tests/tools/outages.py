"""Outages cut out of lumsim's captures: none is silent, and their lines are counted once (script/soak outages)."""
import json
import pathlib
import random
import struct
import subprocess

SPANS = (0.3, 0.5, 0.8, 0.88, 0.93, 0.97, 1.0, 1.03, 1.2, 1.5, 1.97, 2.0, 2.5, 3.0, 5.2, 9.95, 10.0)  # sweeps
SHORTEST = (9, 12, 20)  # lines
FIRST = 2  # the sweep that an outage begins in
BEHIND = 2  # sweeps that come after it
LINES_OFF = 8
SHARE_OFF = 0.05
STRAGGLERS = 2 * 7  # lines of both eyes that came, and count as skipped: docs/protocol.md, section 6, Frames
FAULTS = (("loss", 0.05), ("duplicate", 0.03), ("reorder", 0.06), ("corrupt", 0.02))
EYE, LINE, CLOCK = 42 + 13, 42 + 14, 42 + 20  # behind Ethernet, IPv4 and UDP


def simulate(bin_dir, path, *arguments):
    subprocess.run([bin_dir / "lumsim", "-q", "-o", path, "--returns-max", "1", *map(str, arguments)], check=True)


def summary(bin_dir, path):
    return json.loads(subprocess.run([bin_dir / "lumdump", path, "--json"], capture_output=True, text=True, check=True).stdout)


class Capture:
    """Records by the sensor's clock; of ranges one packet a line is kept."""

    def __init__(self, bin_dir, folder, lines, rate, sweeps, seed):
        self.bin_dir, self.path = bin_dir, folder / "outage.pcap"
        self.lines, self.sweep_us = lines, 1e6 / rate
        simulate(bin_dir, self.path, "--lines", lines, "--rate", rate, "--frames", sweeps, "--seed", seed, "--loss", 0.01)
        data = self.path.read_bytes()
        self.header, self.records, at, ranges = data[:24], [], 24, set()
        while at < len(data):
            end = at + 16 + struct.unpack_from("<I", data, at + 8)[0]
            record = data[at:end]
            line = record[16 + EYE], struct.unpack_from("<I", record, 16 + CLOCK)[0]
            if record[16 + EYE - 1] == 2 or line not in ranges:
                self.records.append((struct.unpack_from("<II", record), line, record))
            if record[16 + EYE - 1] != 2:
                ranges.add(line)
            at = end
        (s, ns), _, _ = self.records[0]  # lumsim writes nanoseconds
        self.records = [((t[0] - s) * 1e6 + (t[1] - ns) / 1e3, line, record) for t, line, record in self.records]

    def without(self, begin_us, length_us):
        """What the summary says, and lines that are not there."""
        end_us = begin_us + length_us
        seen = [r for r in self.records if r[0] < end_us + BEHIND * self.sweep_us]
        kept = [r for r in seen if not begin_us <= r[0] < end_us]
        self.path.write_bytes(self.header + b"".join(record for _, _, record in kept))
        return summary(self.bin_dir, self.path), len({line for _, line, _ in seen}) - len({line for _, line, _ in kept})


def check(capture, begin_us, length_us):
    """What is wrong with the summary of an outage; "" is nothing."""
    got, truth = capture.without(begin_us, length_us)
    off = got["lines_skipped"] + got["lines_in_pauses"] - truth
    most = max(LINES_OFF, SHARE_OFF * truth)
    told = f"{truth} lines are missing, lines_skipped {got['lines_skipped']}, lines_in_pauses {got['lines_in_pauses']}, pauses {got['pauses']}"
    if got["lines_skipped"] + got["pauses"] == 0:
        return "silent: " + told
    return told if off < -most or off > max(most, STRAGGLERS) or got["pauses"] > 1 else ""


def outages(bin_dir, folder, grids, spans, phases, seed):
    """Counts and failures, over grids of (lines, rate)."""
    runs, wrong = 0, []
    for lines, rate in grids:
        capture = Capture(bin_dir, folder, lines, rate, FIRST + BEHIND + int(max(spans)) + 2, seed)
        line_us = capture.sweep_us / lines
        lengths = [n * line_us for n in SHORTEST] + [s * capture.sweep_us for s in spans]
        calm, _ = capture.without(0, 0)
        if calm["pauses"]:
            wrong.append(f"{lines} lines, {rate} Hz: a pause without an outage")
        for length_us in lengths:
            for phase in range(phases):
                begin_us = (FIRST + (phase + 0.37) / phases) * capture.sweep_us
                runs += 1
                said = check(capture, begin_us, length_us)
                if said:
                    wrong.append(f"{lines} lines, {rate} Hz, {length_us / 1000:.2f} ms from {begin_us / 1000:.2f} ms, seed {seed}: {said}")
    return runs, wrong


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


def quick(bin_dir, folder):
    """A part that takes seconds."""
    runs, wrong = outages(bin_dir, pathlib.Path(folder), [(64, 10)], (0.5, 0.93, 1.0, 2.0), 5, 1)
    return runs, wrong + calm(bin_dir, pathlib.Path(folder), 4, 1)


def soak(bin_dir, folder, count, seed):
    folder = pathlib.Path(folder)
    runs, wrong = 0, []
    for lines, phases in ((64, 24), (640, 6)):
        for rate in (5, 10, 20):
            n, failed = outages(bin_dir, folder, [(lines, rate)], SPANS, phases, seed + rate)
            print(f"{lines} lines, {rate} Hz: {n} outages, {len(failed)} wrong", flush=True)
            runs, wrong = runs + n, wrong + failed
    wrong += calm(bin_dir, folder, count, seed)
    for line in wrong:
        print(line)
    print(f"{runs} outages and {count} captures without one: {len(wrong)} wrong")
    return not wrong
