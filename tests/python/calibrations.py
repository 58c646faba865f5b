"""calibrations.py COUNT BUILD FOLDER [--only WHAT] [--lines N]: lumcal on lumsim's rooms, of COUNT random true calibrations.

Each bar with how many meet it, the share of errors within two standard deviations, and what is held where one street, one room or
two captures cannot tell it. Exit status 0: at least nine of ten meet each bar, and 90 % of the errors lie within.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

POSES = ((0, 0, 0), (12, 0, 27), (-12, 0, -27), (12, 5, -52), (-12, -5, 52))
"""Roll, pitch and yaw of the captures, give or take 2 degrees."""

FRAMES = 22
PS_M = 1.5e-4  # metres a picosecond

RUNS = {  # walls, captures, bars: mrad, mm, mm, mm, %, %
    "flat": ("flat", 3, (0.3, 3, 4, math.inf, 0.02, 0.12)),
    "mild": ("mild", 3, (0.6, 6, 10, 6, 0.05, 0.3)),
    "mild-5": ("mild", 5, (0.3, 3, 5, 3, 0.025, 0.15)),
    "rough": ("rough", 3, (math.inf,) * 6),
    "rough-5": ("rough", 5, (math.inf,) * 6),
}
NAMES = ("angles mrad", "position mm", "offsets mm", "their difference mm", "width %", "elevation ends %")
HELD = {"one street": ("street", 1), "one room": ("room", 1), "two captures": ("room", 2)}
OPEN = ("green.mount.yaw_deg", "green.mount.x_m", "green.mount.y_m")


def draw(random):
    """A true calibration: mounts to 2 degrees and 5 cm, offsets to 200 ps, widths to 1 %."""
    made = {}
    for eye, yaw in (("blue", -30.0), ("green", 30.0)):
        off = np.zeros(6) if eye == "blue" else np.r_[random.uniform(-0.05, 0.05, 3), random.uniform(-2, 2, 3)]
        half = 10 * (1 + random.uniform(-0.01, 0.01))
        mount = dict(zip(("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg"), np.round(off + (0, 0, 0, 0, 0, yaw), 6).tolist()))
        made[eye] = {"tof_offset_ps": round(random.uniform(-200, 200), 3), "azimuth": {"width_deg": round(60 * (1 + random.uniform(-0.01, 0.01)), 6)},
                     "elevation": {"min_deg": round(-7 - half, 6), "max_deg": round(-7 + half, 6)}, "mount": mount}
    return {"eyes": made}


def record(o, folder, seed, kind, walls, count):
    """Captures of a place, and the true calibration."""
    import lumsdk

    random = np.random.default_rng([seed, 14])
    true = lumsdk.Calibration(draw(random))
    (folder / "true.yaml").write_text(true.to_yaml())
    made = []
    for number in range(count):
        place = (*random.uniform(-0.3, 0.3, 2), {"room": 1.2, "yard": 1.5, "street": 1.8}[kind] + random.uniform(-0.1, 0.1))
        pose = (*place, *(np.array(POSES[number]) + random.uniform(-2, 2, 3)))
        path = folder / f"{kind}-{number}.pcap"
        subprocess.run([o.build / "bin" / "lumsim", "-o", path, "--scene", kind, *([] if kind == "street" else ["--walls", walls]), "--pose",
                        ",".join(f"{v:.6f}" for v in pose), "--frames", str(FRAMES), "--lines", str(o.lines), "--calibration",
                        folder / "true.yaml", "--seed", str(seed)], check=True, capture_output=True)
        made.append(str(path))
    return made, true


def calibrate(o, seed, kind, walls, count):
    """A solution, its truth and its seconds; no solution where it was refused."""
    import lumsdk
    from lumsdk.calibrate import _eyes

    with tempfile.TemporaryDirectory(dir=o.folder) as name:
        paths, true = record(o, pathlib.Path(name), seed, kind, walls, count)
        begun = time.monotonic()
        try:
            solution = _eyes.run(_eyes.Options(paths))
        except lumsdk.CaptureError as error:
            print(f"  {seed}: {error}")
            solution = None
        return solution, true, time.monotonic() - begun


def errors(solution, true):
    """Error and standard deviation by key."""
    return {p.key: (p.value - true[f"eyes.{p.key}"], p.sigma) for p in solution.parameters if not p.key.endswith("center_deg")}


def measures(wrong):
    """What the bars are about."""
    def most(*ends):
        return max(abs(error) for key, (error, _) in wrong.items() if key.endswith(ends))

    offsets = [wrong[f"{eye}.tof_offset_ps"][0] * PS_M * 1e3 for eye in ("blue", "green")]
    return (math.radians(most("roll_deg", "pitch_deg", "yaw_deg")) * 1e3, most("x_m", "y_m", "z_m") * 1e3, max(map(abs, offsets)),
            abs(offsets[0] - offsets[1]), most("width_deg") / 60 * 100, most("min_deg", "max_deg") / 20 * 100)


def run_bars(o, name):
    walls, count, bars = RUNS[name]
    every, within, seconds, better = [], [], [], 0
    for seed in range(o.count):
        solution, true, spent = calibrate(o, seed, "room", walls, count)
        seconds.append(spent)
        if solution is None:
            every.append((math.inf,) * len(bars))
            continue
        wrong = errors(solution, true)
        every.append(measures(wrong))
        within += [abs(error) < 2 * sigma for error, sigma in wrong.values() if math.isfinite(sigma)]
        better += solution.is_better
    share = float(np.mean(within)) if within else 0.0
    print(f"{name}: {count} captures, {o.count} calibrations, {np.median(seconds):.1f} s each; {better} better on faces held out; "
          f"{share:.1%} of errors within 2 standard deviations")
    good = share >= 0.9
    for index, what in enumerate(NAMES):
        values = np.array([measured[index] for measured in every])
        met = int((values <= bars[index]).sum())
        good = good and met >= 0.9 * o.count
        bar = f"{met}/{o.count} within {bars[index]}" if math.isfinite(bars[index]) else "no bar"
        print(f"  {what}: {bar}; median {np.median(values):.3f}, nine of ten {np.quantile(values, 0.9):.3f}", flush=True)
    return good


def run_held(o, name):
    kind, count = HELD[name]
    held, within = {}, []
    whole = 0
    for seed in range(o.count):
        solution, true, _ = calibrate(o, seed, kind, "flat", count)
        if solution is None:
            continue
        wrong = errors(solution, true)
        names = [p.key for p in solution.parameters if p.held and p.key in wrong]
        for key in names:
            held[key] = held.get(key, 0) + 1
        whole += set(OPEN) <= set(names)
        within += [abs(error) < 2 * sigma for error, sigma in wrong.values() if math.isfinite(sigma)]
    share = f"{np.mean(within):.1%} of the other errors within 2 standard deviations" if within else "nothing else"
    print(f"{name}: yaw, x and y held in {whole} of {o.count}; {share}; held {json.dumps(held)}", flush=True)
    return name != "one street" or whole == o.count


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("count", type=int)
    p.add_argument("build", type=pathlib.Path)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--only", choices=(*RUNS, *HELD))
    p.add_argument("--lines", type=int, default=64)
    o = p.parse_args()
    o.build = o.build.resolve()
    sys.path.insert(0, str(o.build / "python"))
    good = True
    for name in RUNS:
        if o.only in (None, name):
            good = run_bars(o, name) and good
    for name in HELD:
        if o.only in (None, name):
            good = run_held(o, name) and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
