"""calibrations.py COUNT BUILD FOLDER [--only WHAT] [--first N] [--lines N] [--moved M | --turned DEG]

lumcal on lumsim's rooms, of COUNT random true calibrations: each bar with how many meet it, the share of errors within two
standard deviations, and what is held where one street, one room or two captures cannot tell it; behind each seed what it
measured, and how far the poses are off. --first N: seeds from N on. --moved M, --turned DEG: the sensor is moved by so many
metres, or turned, half way through the second capture.
Exit status 0: at least nine of ten meet each bar, 90 % of the errors lie within, and nothing was refused.
"""
import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

POSES = ((0, 6, 0), (12, 0, 27), (-12, 0, -27), (-12, 6, 30), (12, 6, -30))
"""Roll, pitch and yaw of the captures, give or take 2 degrees: as docs/calibrate.md asks for."""

TURNED = (*POSES[:3], (12, 5, -52), (-12, -5, 52))
"""Turned further instead: the last mostly sees no floor."""

FRAMES = 22
PS_M = 1.5e-4  # metres a picosecond

FLAT, MILD, HALF = (0.3, 3, 4, math.inf, 0.02, 0.12), (0.6, 6, 10, 6, 0.05, 0.3), (0.3, 3, 5, 3, 0.025, 0.15)
ROUGH = (math.inf,) * 6

RUNS = {  # walls, poses, bars: mrad, mm, mm, mm, %, %
    "flat": ("flat", POSES[:3], FLAT),
    "flat-5": ("flat", POSES, FLAT),
    "mild": ("mild", POSES[:3], MILD),
    "mild-5": ("mild", POSES, HALF),
    "mild-5-turned": ("mild", TURNED, ROUGH),
    "rough": ("rough", POSES[:3], ROUGH),
    "rough-5": ("rough", POSES, ROUGH),
}
NAMES = ("angles mrad", "position mm", "offsets mm", "their difference mm", "width %", "elevation ends %")
HELD = {"one street": ("street", POSES[:1]), "one room": ("room", POSES[:1]), "two captures": ("room", POSES[:2])}
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


def record(o, folder, seed, kind, walls, poses):
    """Captures of a place, the true calibration, and the true poses."""
    import lumsdk

    random = np.random.default_rng([seed, 14])
    true = lumsdk.Calibration(draw(random))
    (folder / "true.yaml").write_text(true.to_yaml())
    made, stood = [], []

    def see(path, pose):
        subprocess.run([o.build / "bin" / "lumsim", "-o", path, "--scene", kind, *([] if kind == "street" else ["--walls", walls]), "--pose",
                        ",".join(f"{v:.6f}" for v in pose), "--frames", str(FRAMES), "--lines", str(o.lines), "--calibration",
                        folder / "true.yaml", "--seed", str(seed)], check=True, capture_output=True)

    for number, usual in enumerate(poses):
        place = (*random.uniform(-0.3, 0.3, 2), {"room": 1.2, "yard": 1.5, "street": 1.8}[kind] + random.uniform(-0.1, 0.1))
        pose = (*place, *(np.array(usual) + random.uniform(-2, 2, 3)))
        stood.append(pose)
        path = folder / f"{kind}-{number}.pcap"
        see(path, pose)
        if number == 1 and (o.moved or o.turned):
            way = np.random.default_rng([seed, 15]).normal(size=3)
            see(folder / "moved.pcap", np.array(pose) + np.r_[o.moved * way / np.linalg.norm(way), 0, 0, o.turned])
            move(path, folder / "moved.pcap")
        made.append(str(path))
    return made, true, stood


def move(path, other):
    """Give a capture another one's second half."""
    def records(path):
        data, at = path.read_bytes(), 24
        while at < len(data):
            seconds, part, size = struct.unpack_from("<III", data, at)
            yield (seconds, part), data[at:at + 16 + size]
            at += 16 + size

    kept = list(records(path))
    middle = kept[len(kept) // 2][0]
    made = [*(r for time, r in kept if time < middle), *(r for time, r in records(other) if time >= middle)]
    path.write_bytes(path.read_bytes()[:24] + b"".join(made))


def poses_off(solution, stood):
    """How far the poses are off, at most: metres and degrees."""
    from lumsdk.calibrate._planes import rotation

    turns, places = [rotation(*pose[3:]) for pose in stood], [np.array(pose[:3]) for pose in stood]
    far = turn = 0.0
    for (own, at), true, place in zip(solution.poses, turns, places):
        far = max(far, float(np.linalg.norm(at - turns[0].T @ (place - places[0]))))
        turn = max(turn, math.degrees(math.acos(min(1.0, (np.trace(own @ (turns[0].T @ true).T) - 1) / 2))))
    return far, turn


def calibrate(o, seed, kind, walls, poses):
    """A solution, its truth and its seconds; no solution where it was refused."""
    import lumsdk
    from lumsdk.calibrate import _eyes

    with tempfile.TemporaryDirectory(dir=o.folder) as name:
        paths, true, stood = record(o, pathlib.Path(name), seed, kind, walls, poses)
        begun = time.monotonic()
        try:
            solution = _eyes.run(_eyes.Options(paths))
        except lumsdk.CaptureError as error:
            print(f"  seed {seed}: refused: {error}", flush=True)
            solution = None
        if solution is not None:
            tell(seed, solution, true, stood)
        return solution, true, time.monotonic() - begun


def tell(seed, solution, true, stood):
    wrong = errors(solution, true)
    far, turn = poses_off(solution, stood)
    within = [abs(error) < 2 * sigma for error, sigma in wrong.values() if math.isfinite(sigma)]
    print(f"  seed {seed}: {' '.join(f'{value:.3f}' for value in measures(wrong))}; {sum(within)} of {len(within)} within 2 standard deviations; "
          f"{len(solution.planes)} faces; poses off by {far * 1e3:.1f} mm, {turn:.3f} degrees"
          f"{'' if solution.is_better else '; not better'}", *solution.notes, sep="\n    ", flush=True)


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
    walls, poses, bars = RUNS[name]
    every, within, seconds, sigmas, better = [], [], [], [], 0
    for seed in range(o.first, o.first + o.count):
        solution, true, spent = calibrate(o, seed, "room", walls, poses)
        seconds.append(spent)
        if solution is None:
            every.append((math.inf,) * len(bars))
            continue
        wrong = errors(solution, true)
        every.append(measures(wrong))
        sigmas.append({key: sigma for key, (_, sigma) in wrong.items()})
        within += [abs(error) < 2 * sigma for error, sigma in wrong.values() if math.isfinite(sigma)]
        better += solution.is_better
    share = float(np.mean(within)) if within else 0.0
    print(f"{name}: {len(poses)} captures, {o.count} calibrations, {np.median(seconds):.1f} s each; {better} better on faces held out; "
          f"{share:.1%} of errors within 2 standard deviations")
    good = share >= 0.9
    for index, what in enumerate(NAMES):
        values = np.array([measured[index] for measured in every])
        met = int((values <= bars[index]).sum())
        good = good and met >= 0.9 * o.count
        bar = f"{met}/{o.count} within {bars[index]}" if math.isfinite(bars[index]) else "no bar"
        print(f"  {what}: {bar}; median {np.median(values):.3f}, nine of ten {np.quantile(values, 0.9):.3f}", flush=True)
    # How sure they are said to be: of three captures and of five, what more of them bring.
    print(f"  standard deviations, median: {sure(sigmas)}", flush=True)
    return good


def sure(sigmas):
    """The median of the largest standard deviations, in the units of the bars but of the difference, which has none of its own."""
    middle = np.median([measures({key: (sigma, sigma) for key, sigma in each.items()}) for each in sigmas], 0) if sigmas else []
    return ", ".join(f"{what} {value:.3f}" for what, value in zip(NAMES, middle) if "difference" not in what)


def run_held(o, name):
    kind, poses = HELD[name]
    held, within = {}, []
    whole = refused = 0
    for seed in range(o.first, o.first + o.count):
        solution, true, _ = calibrate(o, seed, kind, "flat", poses)
        if solution is None:
            refused += 1
            continue
        wrong = errors(solution, true)
        names = [p.key for p in solution.parameters if p.held and p.key in wrong]
        for key in names:
            held[key] = held.get(key, 0) + 1
        whole += set(OPEN) <= set(names)
        within += [abs(error) < 2 * sigma for error, sigma in wrong.values() if math.isfinite(sigma)]
    share = f"{np.mean(within):.1%} of the other errors within 2 standard deviations" if within else "nothing else"
    print(f"{name}: yaw, x and y held in {whole} of {o.count}; {share}; {refused} refused; held {json.dumps(held)}", flush=True)
    return refused == 0 and (not within or np.mean(within) >= 0.9) and (name != "one street" or whole == o.count)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("count", type=int)
    p.add_argument("build", type=pathlib.Path)
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--only", choices=(*RUNS, *HELD))
    p.add_argument("--first", type=int, default=0)
    p.add_argument("--lines", type=int, default=64)
    p.add_argument("--moved", type=float, default=0.0)
    p.add_argument("--turned", type=float, default=0.0)
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
