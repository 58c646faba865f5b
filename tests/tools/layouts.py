"""Random layouts of data packets, as wire profiles, for script/soak infer."""
import hashlib
import json
import os
import random
import re
import subprocess

WIDTHS = (2, 2, 4)
UNITS_NS = (1, 100, 1000, 1000, 10_000)
FAULTS = ((), ("--loss", "0.02", "--reorder", "0.02", "--corrupt", "0.01"), ("--loss", "0.05", "--reorder", "0.05", "--corrupt", "0.02"))
# Frames of 64 lines, so that a layout takes a second; 640 lines now and then.
SCENES = ((64, 1, 10), (64, 2, 10), (64, 2, 20), (64, 3, 5), (640, 1, 2))


class Layout:
    """A profile of the wider kind. The lower eye value is blue's, since packets do not tell which it is."""

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

    def _eye_and_tag(self, line):
        """Groups of fields that share bytes."""
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
        groups = self._eye_and_tag(self._field(self.random.choice(WIDTHS)))
        groups.append({"first_sample_index": self._field(self.random.choice(WIDTHS))})
        if self.random.random() < 0.8:
            groups.append({"num_samples": self._field(self.random.choice(WIDTHS))})
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

    def yaml(self):
        group = {name: field or "none" for name, field in self.fields.items()}
        return json.dumps({"version": 1, "data_packet_type": self.type, "group": {**group, "samples": self.samples},
                           "eye_values": {"blue": self.eyes[0], "green": self.eyes[1]}, "angle_order": self.angle_order,
                           "sample_order": self.sample_order})


def digest(lumdump, capture, profile, out):
    """Of the points; None where lumdump fails."""
    r = subprocess.run([lumdump, capture, "--profile", profile, "-o", out, "-q"], capture_output=True, text=True)
    return hashlib.sha256(out.read_bytes()).hexdigest() if r.returncode == 0 else None


def run(build, folder, seed):
    """One layout: what came of it."""
    layout, chance = Layout(seed), random.Random(seed + 1_000_000)
    true, found, clean, spoiled, out = (folder / name for name in ("true.yaml", "found.yaml", "clean.pcap", "spoiled.pcap", "out.csv"))
    true.write_text(layout.yaml())
    found.unlink(missing_ok=True)
    lines, frames, rate = chance.choice(SCENES)
    scene = ("-q", "--profile", true, "--lines", str(lines), "--frames", str(frames), "--rate", str(rate), "--seed", str(seed))
    faults = chance.choice(FAULTS)
    subprocess.run([build / "bin" / "lumsim", "-o", clean, *scene], check=True)
    subprocess.run([build / "bin" / "lumsim", "-o", spoiled, *scene, *faults], check=True)
    lumdump = build / "bin" / "lumdump"
    with open(folder / "said.txt", "w+", encoding="utf-8") as said:
        process = subprocess.Popen([lumdump, spoiled, "--infer", "-o", found], stdout=said, stderr=said)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read()
    margin = re.search(r"margin[^\d]*([\d.]+)", text)
    result = {"seed": seed, "layout": layout.yaml(), "scene": (lines, frames, rate), "faults": faults, "status": process.returncode,
              "seconds": used.ru_utime + used.ru_stime, "margin": float(margin[1]) if margin else None, "is_unsure": "unsure" in text,
              "memory": used.ru_maxrss * 1024}
    same = {}
    for name, capture in (("spoiled", spoiled), ("clean", clean)):
        of_true = digest(lumdump, capture, true, out)
        same[name] = of_true is not None and found.exists() and digest(lumdump, capture, found, out) == of_true
    return {**result, **same}
