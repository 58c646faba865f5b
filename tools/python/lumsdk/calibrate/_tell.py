"""What lumcal prints: as text and as JSON."""
from __future__ import annotations

import json
import math
from typing import Any, Optional

import numpy as np

from .._grid import EYES
from ._check import TOLD_DEG, TOLD_M, Check, Seam
from ._solution import Parameter, Solution


def millimetres(value: Optional[float]) -> str:
    """A length for people."""
    return "-" if value is None or not math.isfinite(value) else f"{1000 * value:.1f} mm"


def _number(value: Optional[float], digits: int) -> Optional[float]:
    """For JSON, which has no infinities."""
    return None if value is None or not math.isfinite(value) else round(value, digits)


# --- lumcal check ---


def azimuth(seam: Seam) -> float:
    """Where a seam is, degrees to the left."""
    return math.degrees(math.atan2(seam.middle[1], seam.middle[0]))


MARKS = {"meet": "", "apart": "  APART", "unknown": "  cannot tell"}
"""What stands behind a face."""


def _seam_line(seam: Seam) -> str:
    side = "nearer" if seam.step_m > 0 else "farther"
    if seam.kind == "floor":
        side = "higher" if seam.step_m > 0 else "lower"
    elif seam.kind == "ceiling":
        side = "lower" if seam.step_m > 0 else "higher"
    return (f"{seam.kind:<7} at {seam.distance_m:5.1f} m  step {1000 * abs(seam.step_m):6.1f} +- {1000 * seam.step_sigma_m:.1f} mm,"
            f" green {side}; tilt {seam.tilt_deg:6.3f} +- {seam.tilt_sigma_deg:.3f},"
            f" twist {seam.twist_deg:6.3f} +- {seam.twist_sigma_deg:.3f} degrees" + MARKS[seam.verdict])


def exchange(eye_values: tuple[int, int]) -> str:
    """What to do where the eyes are exchanged."""
    blue, green = eye_values
    return ("a wall continues from eye to eye only with the eyes exchanged: the profile probably calls the blue eye green. Exchange "
            f"the two numbers of eye_values in it, or add --set eye_values.blue={green} --set eye_values.green={blue}, and run "
            "it again")


def _why_unknown(found: Check) -> str:
    if found.is_exchanged:
        return exchange(found.eye_values)
    if found.seams:
        return (f"what both eyes see here is too small or too uneven to measure a step within {1000 * TOLD_M:g} mm and angles within "
                f"{TOLD_DEG:g} degrees: let the sensor look at a larger wall straight ahead, or at the floor, with more frames")
    if found.strange:
        seam = found.strange[0]
        return (f"no face continues from eye to eye; the closest pair is {seam.apart_deg:.1f} degrees and {abs(seam.step_m):.2f} m "
                "apart. These are two faces, or the calibration is wrong by as much: lumcal eyes shows which")
    return ("no wall or floor continues from eye to eye: let the sensor look at a wall straight ahead, or at the floor; if it does, "
            "the eyes may be exchanged: eye_values of the profile")


def advice(found: Check) -> str:
    """The verdict as a sentence, and what to do."""
    if found.verdict == "unknown":
        return f"unknown: {_why_unknown(found)}"
    if found.verdict == "meet":
        step, angle = found.bounds
        return f"the eyes meet, within {1000 * step:.0f} mm and {angle:.2f} degrees"
    return "the eyes are apart: this calibration does not fit this sensor now; lumcal eyes finds one that does"


def check_text(found: Check) -> str:
    """The summary of lumcal check."""
    lines = [f"capture      {found.capture}, {found.frames} frames", f"calibration  {found.calibration}"]
    for eye, name in enumerate(EYES):
        count, flat = sum(face.eye == eye for face in found.faces), millimetres(found.flat_m[eye])
        told = f"{count} flat face{'' if count == 1 else 's'}, flat within {flat} (rms)" if count else "no flat faces"
        lines.append(f"{name + ' eye':<12} {told}")
    lines += [_seam_line(seam) for seam in found.seams]
    if found.seams:
        lines.append(f"step         {millimetres(found.step_m)} (rms of {len(found.seams)})")
    lines.append(f"verdict      {advice(found)}")
    return "\n".join(lines) + "\n"


def _seam_json(seam: Seam) -> dict[str, Any]:
    return {"kind": seam.kind, "distance_m": _number(seam.distance_m, 4), "azimuth_deg": _number(azimuth(seam), 3),
            "middle_m": [_number(float(v), 4) for v in seam.middle], "normal": [_number(float(v), 6) for v in seam.normal],
            "step_mm": _number(1000 * seam.step_m, 3), "step_sigma_mm": _number(1000 * seam.step_sigma_m, 3),
            "tilt_deg": _number(seam.tilt_deg, 5), "tilt_sigma_deg": _number(seam.tilt_sigma_deg, 5),
            "twist_deg": _number(seam.twist_deg, 5), "twist_sigma_deg": _number(seam.twist_sigma_deg, 5),
            "cells": {"blue": len(seam.blue.cells), "green": len(seam.green.cells)}, "verdict": seam.verdict}


def check_json(found: Check) -> str:
    """What --json prints."""
    flat = {name: _number(None if value is None else 1000 * value, 3) for name, value in zip(EYES, found.flat_m)}
    step = found.step_m
    return json.dumps({"capture": found.capture, "calibration": found.calibration, "frames": found.frames,
                       "faces": {name: sum(face.eye == eye for face in found.faces) for eye, name in enumerate(EYES)},
                       "flat_mm": flat, "step_mm": _number(None if step is None else 1000 * step, 3),
                       "seams": [_seam_json(seam) for seam in found.seams], "verdict": found.verdict,
                       "eyes_exchanged": found.is_exchanged, "advice": advice(found)}, indent=2) + "\n"


# --- lumcal eyes ---


def digits(key: str) -> int:
    """Decimals that a value of a key needs."""
    return 1 if key.endswith("_ps") else 5 if key.endswith("_m") else 4


def row(parameter: Parameter) -> tuple[str, str, str, str]:
    """Key, value, standard deviation and what it was before."""
    places = digits(parameter.key)
    sigma = "held" if parameter.held or not math.isfinite(parameter.sigma) else f"{parameter.sigma:.{places}f}"
    return parameter.key, f"{parameter.value:.{places}f}", sigma, f"{parameter.before:.{places}f}"


def change(before: float, after: float) -> str:
    """What became of a length."""
    return f"{millimetres(before)} before, {millimetres(after)} after"


def solution_text(found: Solution) -> str:
    """The summary of lumcal eyes."""
    rows = [("", "value", "+-", "before"), *(row(parameter) for parameter in found.parameters)]
    lines = [f"captures     {len(found.captures)}, {sum(plane.cells > 0 for plane in found.planes)} faces",
             f"residuals    {change(found.rms_before_m, found.rms_after_m)} (rms)"]
    if math.isfinite(found.held_out_after_m):
        lines.append(f"held out     {change(found.held_out_before_m, found.held_out_after_m)}, on faces left out of the fit")
    lines.append("bends        " + ", ".join(f"{name} {bent:.3f}" for name, bent in bends(found)) + " degrees")
    lines.append(f"begin        {found.began}")
    lines += [f"{key:<26}{value:>12}{sigma:>10}{before:>12}" for key, value, sigma, before in rows]
    lines += [f"held: {', '.join(keys)}: {why}" for why, keys in reasons(found).items()]
    lines += [f"note: {note}" for note in found.notes]
    lines += [f"more: {line}" for line in more(found)]
    return "\n".join(lines) + "\n"


def more_captures(found: Solution) -> dict[str, int]:
    """How many more captures would reach what is wished for, by key; 0 of all for a solution of no use."""
    is_of_use = not not_written(found)
    return {p.key: p.more(len(found.captures)) if is_of_use else 0 for p in found.parameters}


def more(found: Solution) -> list[str]:
    """What is told of them."""
    far = more_captures(found)
    made = [f"{p.key}: a standard deviation of {p.wish:g}, and not {p.sigma:.{digits(p.key)}f}, takes about {far[p.key]} "
            "more captures" for p in found.parameters if far[p.key]]
    if made:
        made.append("if they are as good as these and their errors are independent: other walls, other poses")
    return made


def bends(found: Solution) -> list[tuple[str, float]]:
    """How far the readings of each mirror depart from a straight line, at most, in degrees."""
    turn = np.linspace(-1, 1, 201)
    return [(f"{eye} {mirror}", float(np.abs(np.polynomial.legendre.legval(turn, [0.0, 0.0, *terms])).max()))
            for eye, both in zip(EYES, found.bends_deg) for mirror, terms in zip(("azimuth", "elevation"), both)]


def compared(found: Solution) -> tuple[float, float, str]:
    """What judges a solution: residuals before and after, and on what."""
    if math.isfinite(found.held_out_after_m):
        return found.held_out_before_m, found.held_out_after_m, "faces left out of the fit"
    return found.rms_before_m, found.rms_after_m, "the faces that it was fitted to"


MOUNT = "the mount of the green eye"
"""What a calibration is of no use without."""

ADD_TWO = ("add two of the same room, the sensor turned by 20 to 30 degrees to either side so that both eyes see the same faces, one "
           "of them rolled by about +12 degrees and the other by -12")


def not_written(found: Solution) -> str:
    """Why a solution is no calibration, and what to do; empty: it is one."""
    if found.exchanged:
        return found.exchanged
    if len(found.captures) == 1:
        return f"one capture does not determine {MOUNT}: {ADD_TWO}"
    open_keys = {why: [key for key in keys if ".mount." in key] for why, keys in reasons(found).items()}
    told = "; ".join(f"{', '.join(keys)}: {why}" for why, keys in open_keys.items() if keys)
    if told:
        return f"{MOUNT} is not determined: {told}"
    if not found.is_settled:
        return "the solution did not settle: its values and standard deviations cannot be trusted; record the room again"
    if found.is_better:
        return ""
    before, after, where = compared(found)
    allowed = f", and up to {1000 * found.allowed_m:.2f} mm count as no worse" if math.isfinite(found.allowed_m) else ""
    return (f"the result is worse than its start on {where}: {1000 * before:.2f} mm before, {1000 * after:.2f} mm after"
            f"{allowed}")


def reasons(found: Solution) -> dict[str, list[str]]:
    """Why values are held: the keys by the reason that they share."""
    made: dict[str, list[str]] = {}
    for parameter in found.parameters:
        if parameter.held:
            made.setdefault(parameter.held, []).append(parameter.key)
    return made
