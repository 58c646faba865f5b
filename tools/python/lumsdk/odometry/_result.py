"""What lumodom tells of a drive: its poses, and the result as text and as JSON."""
from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from .._poses import Poses
from ._drive import Drive
from ._estimate import STEP_S, Settings, Track
from ._metrics import CLOCKS, Errors, Path

SUDDEN_M_S2 = 30.0
"""A car cannot: it is three times what its tyres hold."""

MISFIT, AROUND = 3.0, 5
"""A frame is misaligned if its residual exceeds this many times the median of this many frames on each side. If the sensor
jumps along a street, nothing else may show it."""

MISFIT_CELLS = 0.3
"""And this many edges of the map's cells: residuals are far smaller while the sensor stands."""


@dataclass
class Result:
    """A drive, its poses, and what was measured by them."""

    name: str
    settings: Settings
    track: Track
    path: Path
    frames: int
    errors: Optional[Errors] = None
    notes: list[str] = field(default_factory=list)
    """What is doubtful or was left out."""


def residual_m(track: Track) -> float:
    """The median over the frames."""
    return float(np.median(track.residuals_m))


def sudden(path: Path, track: Track) -> list[int]:
    """The frames within which the speed changes more than that of a car can."""
    spans = np.diff(track.times_s())
    changes = np.abs(np.diff(path.speeds_m_s)) / np.maximum(spans[1:], spans[:-1])
    return [track.numbers[i] for i in np.flatnonzero(changes > SUDDEN_M_S2)]


def misfits(track: Track, voxel_m: float) -> list[int]:
    """The frames whose points are far from those of the frame before."""
    made, residuals = [], track.residuals_m
    for i, residual in enumerate(residuals):
        around = residuals[max(0, i - AROUND):i] + residuals[i + 1:i + 1 + AROUND]
        if around and residual > max(MISFIT * float(np.median(around)), MISFIT_CELLS * voxel_m):
            made.append(track.numbers[i + 1])
    return made


def _named(numbers: list[int]) -> str:
    listed = ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "")
    return f"{len(numbers)} frames ({listed})" if len(numbers) > 1 else f"frame {listed}"


def notes(drive: Drive, settings: Settings, path: Path, track: Track, clock: str, errors: Optional[Errors]) -> list[str]:
    """What is doubtful or was left out, in sentences."""
    made = []
    if drive.sparse:
        made.append(f"{drive.sparse} of {drive.frames} frames have too few points and no pose")
    apart_s = float(np.median(np.diff(track.times_s()[1:-1])))
    if apart_s > STEP_S:
        made.append(f"frames are {apart_s:.1f} s apart: the motion may come out far too short, and the residuals "
                    "do not show it; use about 10 frames a second")
    jumps = sudden(path, track)
    if jumps:
        made.append(f"the speed changes by more than {SUDDEN_M_S2:g} m/s2 at {_named(jumps)}: probably aligned wrongly; a smaller "
                    "--voxel may help, or a shorter part of the drive by --frames")
    apart = misfits(track, settings.voxel_size)
    if apart:
        made.append(f"the residual is more than {MISFIT:g} times that of the frames around at {_named(apart)}: aligned wrongly, as "
                    "in a sudden bend, or the sensor jumped, as in a drive that is played in a loop, and the poses do not show how "
                    "far; --report draws the residuals, and --frames takes the part between")
    if clock == "utc" and drive.without_utc_error:
        made.append(f"the error of UTC is unknown in {drive.without_utc_error} of {drive.frames} frames: --time sensor is exact")
    if errors is not None and errors.without:
        made.append(f"{errors.without} of {errors.count + errors.without} poses are outside the truth and not compared")
    return made


def poses_text(track: Track, clock: str, made_by: str, whose: str = "sensor") -> str:
    """The poses as TUM has them, by "utc" or the "sensor"'s clock."""
    full = track.filled()
    places = np.round(full.poses, 9)  # kiss-icp's threads add in any order, so that further digits change from run to run
    poses = Poses(np.array(full.utc_ns if clock == "utc" else full.clock_ns, "i8"), places)
    return f"# {made_by}: where the {whose} was, metres from where it was at the first line; {CLOCKS[clock]}\n{poses.to_text()}"


def _round(value: Optional[float], digits: int) -> Optional[float]:
    return None if value is None else round(value, digits)


def lengths(errors: Errors) -> str:
    """Which lengths the relative errors are over."""
    found = [f"{s.length_m:g}" for s in errors.segments]
    if not found:
        return "no length of 10 m or more fits into the drive"
    span = found[0] if len(found) == 1 else f"{found[0]} to {found[-1]}"
    return f"over {span} m" + ("" if errors.is_kitti else ": none of KITTI's, of 100 m and more, fits into the drive")


def _errors_lines(errors: Errors) -> list[str]:
    made = [f"absolute     {errors.absolute_rms_m:.3f} m rms, {errors.absolute_max_m:.3f} m at most, of {errors.count} poses"]
    mean = errors.translation_percent
    if mean is None:
        return [*made, f"relative     {lengths(errors)}"]
    made.append(f"relative     {mean:.3f} %, {errors.rotation_deg_m:.5f} deg/m {lengths(errors)}")
    made += [f"  {s.length_m:4g} m     {s.translation_percent:.3f} %, {s.rotation_deg_m:.5f} deg/m, {s.count} segments"
             for s in errors.segments]
    return made


def text(found: Result) -> str:
    """The summary."""
    path = found.path
    share = "" if path.closure_percent is None else f", {path.closure_percent:.2f} % of the distance"
    lines = [f"drive        {found.name}, {found.frames} frames, {path.seconds:.1f} s",
             f"distance     {path.distance_m:.1f} m",
             f"speed        {path.mean_m_s:.2f} m/s, {path.max_m_s:.2f} at most",
             f"closure      {path.closure_m:.2f} m and {path.closure_deg:.2f} degrees from the first pose to the last{share}",
             f"residuals    {100 * residual_m(found.track):.1f} cm (median over frames)"]
    if found.errors is not None:
        lines += _errors_lines(found.errors)
    lines += [f"note: {note}" for note in found.notes]
    return "\n".join(lines) + "\n"


def _errors_json(errors: Errors) -> dict[str, Any]:
    return {"poses": errors.count, "poses_without_truth": errors.without, "absolute_rms_m": _round(errors.absolute_rms_m, 4),
            "absolute_max_m": _round(errors.absolute_max_m, 4), "translation_percent": _round(errors.translation_percent, 4),
            "rotation_deg_m": _round(errors.rotation_deg_m, 6), "lengths_of_kitti": errors.is_kitti,
            "segments": [{"length_m": s.length_m, "count": s.count, "translation_percent": round(s.translation_percent, 4),
                          "rotation_deg_m": round(s.rotation_deg_m, 6)} for s in errors.segments]}


def to_json(found: Result) -> str:
    """What --json prints."""
    path, settings = found.path, found.settings
    made = {"drive": found.name, "frames": found.frames, "poses": len(found.track.poses), "seconds": _round(path.seconds, 4),
            "distance_m": _round(path.distance_m, 3), "mean_m_s": _round(path.mean_m_s, 4), "max_m_s": _round(path.max_m_s, 4),
            "closure_m": _round(path.closure_m, 4), "closure_deg": _round(path.closure_deg, 4),
            "closure_percent": _round(path.closure_percent, 4), "residual_m": _round(residual_m(found.track), 5),
            "deskew": settings.deskew, "voxel_m": settings.voxel_size, "max_range_m": settings.max_range,
            "errors": None if found.errors is None else _errors_json(found.errors), "notes": found.notes}
    return json.dumps(made, indent=2) + "\n"
