"""Random layouts of data packets, as wire profiles, for script/soak infer."""
import hashlib
import json
import random
import subprocess
import sys

import sent

WIDTHS = (2, 2, 4)
UNITS_NS = (1, 100, 1000, 1000, 10_000)
FAULTS = ((), ("--loss", "0.02", "--reorder", "0.02", "--corrupt", "0.01"), ("--loss", "0.05", "--reorder", "0.05", "--corrupt", "0.02"))
# Frames of 64 lines, so that a layout takes a second; 640 lines now and then.
SCENES = ((64, 1, 10), (64, 2, 10), (64, 2, 20), (64, 3, 5), (640, 1, 2))


# Bits that numbers of the simulator need.
BITS = {"tag": (2, 4), "eye": (1, 4), "line": (10, 16), "first_sample_index": (14, 20), "num_samples": (9, 12)}


class Layout:
    """A profile of the wider kind, and how its sensor fills what no profile says. The lower eye value is blue's, since packets do not tell which it is."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.order = self.random.choice(("little", "little", "big"))
        self.sample_order = self.random.choice(("little", "little", "big"))
        self.angle_order = self.random.choice(("azimuth_elevation", "elevation_azimuth"))
        self.type = self.random.choice((8, 8, 8, 0, 1, 3, 9, 200))
        self.eyes = (0, 1)
        self.fields = {}
        self.samples = 64
        while self.samples > 60:
            self._place()

    def _field(self, width):
        return {"bytes": width, "order": self.order if self.random.random() < 0.9 else self.random.choice(("little", "big"))}

    def _clock(self):
        kind = self.random.random()
        if kind < 0.1:
            return None
        clock = self._field(self.random.choice((1, 2)) if kind < 0.2 else self.random.choice((4, 4, 8)))
        clock["unit_ns"] = self.random.choice(UNITS_NS) if clock["bytes"] >= 4 else 1000
        return clock

    def _packed(self):
        """As many fields as there is room for, as bits of 4 or 8 bytes; the others by themselves."""
        word = self._field(self.random.choice((4, 8)))
        names = ["line", "first_sample_index", *self.random.sample(("tag", "eye", "num_samples"), self.random.randint(0, 3))]
        self.random.shuffle(names)
        group, low = {}, 0
        for name in names:
            high = low + self.random.randint(*BITS[name]) - 1
            if high < 8 * word["bytes"]:
                group[name] = {**word, "bits": [low, high]}
                low = high + 1 + self.random.choice((0, 0, 1))
        bits = group["eye"]["bits"][1] - group["eye"]["bits"][0] + 1 if "eye" in group else 8
        self.eyes = tuple(sorted(self.random.sample(range(1 << bits), 2)))
        singles = {"line": 2, "first_sample_index": 2, "tag": 1, "eye": 1, "num_samples": 2}
        return [group, *({name: self._field(width)} for name, width in singles.items() if name not in group)]

    def _groups(self):
        """Groups of fields that share bytes, but for the clock."""
        if self.random.random() < 0.2:
            return self._packed()
        groups = self._eye_and_tag(self._field(self.random.choice(WIDTHS)))
        groups.append({"first_sample_index": self._field(self.random.choice(WIDTHS))})
        if self.random.random() < 0.8:
            groups.append({"num_samples": self._field(self.random.choice(WIDTHS))})
        return groups

    def _eye_and_tag(self, line):
        kind = self.random.choice(("own", "own", "top", "nibble"))
        tag = {"bytes": 1, "order": "little"}
        if kind == "nibble":
            self.eyes = tuple(sorted(self.random.sample(range(16), 2)))
            low, high = self.random.sample(([0, 3], [4, 7]), 2)
            return [{"line": line}, {"tag": {**tag, "bits": low}, "eye": {**tag, "bits": high}}]
        tags = [] if self.random.random() < 0.15 else [{"tag": tag}]
        if kind == "top":
            bits = 8 * line["bytes"]
            self.eyes = (0, 1)
            return [{"line": {**line, "bits": [0, bits - 2]}, "eye": {**line, "bits": [bits - 1, bits - 1]}}, *tags]
        self.eyes = tuple(sorted(self.random.sample(range(256), 2)))
        return [{"line": line}, {"eye": self._field(1)}, *tags]

    def _place(self):
        groups = self._groups()
        clock = self._clock()
        if clock:
            groups.append({"timestamp": clock})
        self.random.shuffle(groups)
        self.fields = {"tag": {"at": 8, "bytes": 1, "order": "little"}, "num_samples": None, "timestamp": None}
        at = 12
        for group in groups:
            at += self.random.choice((0, 0, 0, 1, 2, 3))
            for name, field in group.items():
                self.fields[name] = {"at": at, **field}
            at += next(iter(group.values()))["bytes"]
        self.samples = at + self.random.choice((0, 0, 1, 2, 4))
        self._send(set(range(12, self.samples)) - {field["at"] + i for field in self.fields.values() if field for i in range(field["bytes"])})

    def _send(self, free):
        """The bytes of no field are 0, all the same, each another one, or of that kind and one of noise."""
        kind = self.random.choice(("zero", "same", "each", "noise"))
        same = self.random.randint(1, 255)
        noise = self.random.choice(sorted(free)) if free and kind == "noise" else None
        self.filler = {} if kind == "zero" else {at: same if kind == "same" else self.random.randint(1, 255) for at in sorted(free)}
        if noise is not None:
            self.filler[noise] = None
        self.apart_us = self.random.choice((0, 3, 7, 20))
        self.step_us = self.random.choice((0, 0, 2, 9))

    def as_sent(self, capture):
        """Make a capture of the simulator one of this sensor."""
        noise = random.Random(1)
        filler = {at: (lambda: noise.getrandbits(8)) if value is None else (lambda value=value: value) for at, value in self.filler.items()}
        sent.edit(capture, self.fields, self.eyes, self.apart_us, self.step_us, filler)

    def yaml(self):
        group = {name: field or "none" for name, field in self.fields.items()}
        return json.dumps({"version": 1, "data_packet_type": self.type, "group": {**group, "samples": self.samples},
                           "eye_values": {"blue": self.eyes[0], "green": self.eyes[1]}, "angle_order": self.angle_order,
                           "sample_order": self.sample_order})


def digest(lumdump, capture, profile, out):
    """Of the points; None where lumdump fails."""
    out.unlink(missing_ok=True)
    r = subprocess.run([lumdump, capture, "--profile", profile, "-o", out, "-q"], capture_output=True, text=True)
    return hashlib.sha256(out.read_bytes()).hexdigest() if r.returncode == 0 and out.exists() else None


# A program's memory counts from that of the process that starts it, so a small one starts it.
START = """import json, os, subprocess, sys
process = subprocess.Popen(sys.argv[2:])
used = os.wait4(process.pid, 0)[2]
json.dump([used.ru_utime + used.ru_stime, used.ru_maxrss * 1024], open(sys.argv[1], "w"))"""


def infer(lumdump, capture, found):
    """lumdump's answer, its processor time in seconds and its memory in bytes."""
    found.unlink(missing_ok=True)
    usage = found.with_suffix(".usage")
    r = subprocess.run([sys.executable, "-I", "-S", "-c", START, usage, lumdump, capture, "--infer", "--json", "-o", found],
                       capture_output=True, text=True, check=True)
    return (json.loads(r.stdout) if r.stdout else None, *json.loads(usage.read_text()))


def run(build, folder, seed):
    """One layout: what came of it."""
    layout, chance = Layout(seed), random.Random(seed + 1_000_000)
    true, found, clean, spoiled, out = (folder / name for name in ("true.yaml", "found.yaml", "clean.pcap", "spoiled.pcap", "out.csv"))
    true.write_text(layout.yaml())
    lines, frames, rate = chance.choice(SCENES)
    scene = ("-q", "--profile", true, "--lines", str(lines), "--frames", str(frames), "--rate", str(rate), "--seed", str(seed))
    faults = chance.choice(FAULTS)
    lumdump = build / "bin" / "lumdump"
    for path, more in (clean, ()), (spoiled, faults):
        subprocess.run([build / "bin" / "lumsim", "-o", path, *scene, *more], check=True)
        layout.as_sent(path)
    got, seconds, memory = infer(lumdump, spoiled, found)
    same = {}
    for name, capture in (("spoiled", spoiled), ("clean", clean)):
        of_true = digest(lumdump, capture, true, out)
        same[name] = of_true is not None and found.exists() and digest(lumdump, capture, found, out) == of_true
    return {"seed": seed, "layout": layout.yaml(), "scene": (lines, frames, rate), "faults": faults, "seconds": seconds, "memory": memory,
            "verdict": got["verdict"] if got else "crashed", "margin": got and got["margin"], "text": got and got["text"], **same}
