"""lumcal check as a picture: what is left on faces over the view, and how each face goes on from eye to eye."""
from __future__ import annotations

from typing import Any

import numpy as np

from .._drawing import canvas, png
from .._grid import EYES
from ._check import Check, Seam
from ._solution import Array
from ._tell import MARKS, advice, azimuth, millimetres

COLOURS = ("#2166ac", "#1b7837")
"""Of the blue and the green eye."""

_SHOWN = 4
_BINS = 40


def angles(cloud: Array) -> tuple[Array, Array]:
    """Azimuth to the left and elevation, in degrees, of points in the frame of the sensor."""
    flat = np.hypot(cloud[:, 0], cloud[:, 1])
    return np.degrees(np.arctan2(cloud[:, 1], cloud[:, 0])), np.degrees(np.arctan2(cloud[:, 2], flat))


Limits = tuple[tuple[float, float], tuple[float, float]]


def binned(x: Array, y: Array, values: Array, shape: tuple[int, int], limits: Limits) -> Array:
    """Mean of the values in each cell of an image; rows are y; nan where there are none."""
    bins = (shape[1], shape[0])
    sums = np.histogram2d(x, y, bins, limits, weights=values)[0]
    counts = np.histogram2d(x, y, bins, limits)[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        made: Array = (sums / counts).T
    return made


def heights(found: Check) -> tuple[Array, Array, Array]:
    """Azimuth, elevation and height above its plane in metres of all cells on faces. Halves of one face have one plane."""
    parts = []
    joint = {id(half): seam for seam in found.seams for half in (seam.blue, seam.green)}
    for face in found.faces:
        seam = joint.get(id(face))
        normal, offset = (face.normal, face.offset) if seam is None else (seam.normal, float(seam.normal @ seam.middle))
        height = face.points @ normal - offset
        parts.append((*angles(face.points), height))
    azimuths, elevations, values = (np.concatenate([part[i] for part in parts]) for i in range(3))
    return azimuths, elevations, values


def _limit(values: Array) -> float:
    """The end of the colours, in mm."""
    return float(max(5.0, np.percentile(np.abs(values), 95))) if len(values) else 5.0


def _ends(values: Array) -> tuple[float, float]:
    return float(values.min()) - 0.5, float(values.max()) + 0.5


def _draw_view(axes: Any, figure: Any, found: Check) -> None:
    azimuths, elevations, values = heights(found)
    clouds = np.concatenate(found.clouds)
    all_azimuths, all_elevations = angles(clouds[np.isfinite(clouds[:, 0])])
    limits = _ends(all_azimuths), _ends(all_elevations)
    shape = (60, 240)
    seen = binned(all_azimuths, all_elevations, np.ones(len(all_azimuths)), shape, limits)
    image = binned(azimuths, elevations, 1000 * values, shape, limits)
    extent = (*limits[0], *limits[1])
    options = {"origin": "lower", "extent": extent, "aspect": "auto", "interpolation": "nearest"}
    axes.imshow(seen, cmap="Greys", vmin=0, vmax=5, **options)
    end = _limit(image[np.isfinite(image)])
    shown = axes.imshow(image, cmap="RdBu", vmin=-end, vmax=end, **options)
    axes.invert_xaxis()  # the left of the sensor is on the left
    axes.set_title("residuals on flat faces: red is behind its plane, blue in front of it; grey is not flat", fontsize=9, loc="left")
    axes.set_xlabel("azimuth, degrees (green eye on the left, blue eye on the right)", fontsize=8)
    axes.set_ylabel("elevation, degrees", fontsize=8)
    bar = figure.colorbar(shown, ax=axes, pad=0.01, extend="both")
    bar.set_label("mm", fontsize=8)
    for place in (axes, bar.ax):
        place.tick_params(labelsize=7)


def profile(seam: Seam, half: Any) -> tuple[Array, Array]:
    """Metres across the seam from its middle, and the mean height there."""
    local = half.points - seam.middle
    along, height = local @ seam.across, local @ seam.normal
    edges = np.linspace(along.min(), along.max(), _BINS + 1)
    place = np.clip(np.digitize(along, edges) - 1, 0, _BINS - 1)
    counts, sums = np.bincount(place, minlength=_BINS), np.bincount(place, height, minlength=_BINS)
    kept = counts > 0.1 * counts.mean()
    return ((edges[1:] + edges[:-1]) / 2)[kept], (sums / np.maximum(counts, 1))[kept]


def _draw_seam(axes: Any, seam: Seam) -> None:
    for eye, half in enumerate((seam.blue, seam.green)):
        along, height = profile(seam, half)
        axes.plot(along, 1000 * height, ".", color=COLOURS[eye], markersize=4, label=f"{EYES[eye]} eye")
    low, high = axes.get_ylim()
    end = max(10.0, abs(low), abs(high))
    axes.set_ylim(-end, end)
    axes.axvline(0, color="black", linewidth=0.6, linestyle=":")
    axes.axhspan(-2.5, 2.5, color="black", alpha=0.06, linewidth=0)
    axes.set_title(f"{seam.kind} at {seam.distance_m:.1f} m, {azimuth(seam):.0f} degrees\n"
                   f"step {millimetres(seam.step_m)}, tilt {seam.tilt_deg:.3f}, twist {seam.twist_deg:.3f} degrees"
                   + MARKS[seam.verdict], fontsize=8, loc="left", color="#b2182b" if seam.verdict == "apart" else "black")
    axes.invert_xaxis()  # as the view above
    axes.set_xlabel("metres across the seam, to the left", fontsize=8)
    axes.set_ylabel("mm in front of the plane of both", fontsize=8)
    axes.legend(fontsize=7, loc="best")
    axes.grid(alpha=0.3)
    axes.tick_params(labelsize=7)


def check_png(found: Check) -> bytes:
    """The picture of lumcal check."""
    shown = found.seams[:_SHOWN]
    figure, drawn = canvas(11, 7 if shown else 4)
    rows = figure.subfigures(2, 1) if shown else [figure]
    top = rows[0] if shown else figure
    _draw_view(top.subplots(), top, found)
    if shown:
        for axes, seam in zip(np.ravel(rows[1].subplots(1, len(shown), squeeze=False)), shown):
            _draw_seam(axes, seam)
    figure.suptitle(f"{found.capture}, {found.calibration}\n{advice(found)}", fontsize=10, x=0.01, ha="left",
                    color={"meet": "#1b7837", "apart": "#b2182b"}.get(found.verdict, "black"))
    return png(drawn)
