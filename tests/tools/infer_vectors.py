#!/usr/bin/env python3
"""infer_vectors.py BIN FOLDER...: lumdump --infer over captures whose layout is known: NAME.profile.yaml beside NAME.pcap, else the
usual one. Those of infer-* are as a sensor sends them: the profile is found, sure, and gives the points of the true one. In the
others times of capture are invented, 20 us a packet, so they tell no clock, and many have too few lines for all: what is found
there gives the points of the true profile with the true clock and the true values of what the report calls not told. That of
real-* is found. The last line counts: N passed, N failed."""
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import yaml

AS_SENT = re.compile(r"infer-")
SURE = re.compile(r"(infer|real)-")
# Line numbers with flipped bits: fewer bits of them explain more packets.
DAMAGED = ("line-flips",)
CLOCK = ("group.timestamp", "group.timestamp.unit_ns", "line_span_us")
USUAL = {"tag": 12, "eye": 13, "line": 14, "num_samples": 16, "first_sample_index": 18, "timestamp": 20, "samples": 24}


def call(*command):
    return subprocess.run([*map(str, command)], capture_output=True, timeout=120, check=False)


def take(profile, true, key):
    """The true value of a key; without one it is the default, which is what stands there if a key is not told."""
    name, _, field = key.partition(".")
    if name == "group":
        field = field.partition(".")[0]
        profile["group"][field] = {**USUAL, **true.get("group", {})}[field]
    elif name in true:
        profile[name] = true[name]


class Capture:
    def __init__(self, lumdump, path, folder):
        self.lumdump, self.path, self.folder = lumdump, path, folder
        beside = path.with_suffix(".profile.yaml")
        self.true = yaml.safe_load(beside.read_text()) if beside.exists() else {"version": 1}

    def points(self, profile, *options):
        """Their digest, of each sensor."""
        path = self.folder / "p.yaml"
        path.write_text(json.dumps(profile))
        options = ("--profile", path, *options)
        asked = call(self.lumdump, self.path, "--json", *options)
        sensors = [s["address"] for s in json.loads(asked.stdout).get("sensors", [])] if asked.stdout else []
        made = [call(self.lumdump, self.path, *options, *which, "-q", "-o", "-", "--format", "csv")
                for which in ([("--sensor", s) for s in sensors] if len(sensors) > 1 else [()])]
        return [(m.returncode, hashlib.sha256(m.stdout).hexdigest()) for m in made]

    def judge(self):
        """What was found, and what is wrong with it, or None."""
        r = call(self.lumdump, self.path, "--infer", "--json")
        got = json.loads(r.stdout)
        told = f"{got['verdict']}: {got['text']}"
        if (r.returncode == 0) != (got["profile"] is not None):
            return told, f"the exit status is {r.returncode}"
        if got["verdict"] != "found":
            return told, "it is not sure" if SURE.match(self.path.name) else None
        return told, self.complain(got)

    def complain(self, got):
        found = yaml.safe_load(got["profile"])
        if self.points(found)[0][0] != 0:
            return "the profile gives no points"
        if not AS_SENT.match(self.path.name):
            for key in [f["key"] for f in got["findings"] if not f["told"] or f["key"] in CLOCK]:
                take(found, self.true, key)
        same = self.points(found) == self.points(self.true)
        return None if same or self.path.stem in DAMAGED else "other points than by the true profile"


def main(bin_folder, *folders):
    lumdump = pathlib.Path(bin_folder).resolve() / "lumdump"
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(path for name in folders for path in pathlib.Path(name).glob("*.pcap")):
            told, why = Capture(lumdump, path, pathlib.Path(folder)).judge()
            passed += why is None
            failed += why is not None
            print(f"{'ok   ' if why is None else 'FAIL '} {path.stem}: {told}{'' if why is None else f'; {why}'}", flush=True)
    print(f"{passed} passed, {failed} failed")
    return failed > 0 or passed == 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
