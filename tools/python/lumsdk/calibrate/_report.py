"""The report of lumcal eyes: one page of HTML with all that is in it."""
from __future__ import annotations

import base64
import html
import math
import os
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .._c import VERSION
from .._drawing import canvas, png, small
from .._grid import EYES
from ._model import ORDERS
from ._check_picture import binned
from ._solution import Array, Plane, Residuals, Solution
from ._tell import bends, change, compared, digits, millimetres, more, not_written, reasons, row

_STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222; background: #fff }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse } th, td { padding: .15em .8em .15em 0; text-align: left; vertical-align: top }
th { border-bottom: 1px solid #999 } td.n, th.n { text-align: right; font-variant-numeric: tabular-nums }
tr.held td { color: #777 } img { max-width: 100% } .good { color: #1b7837 } .bad { color: #b2182b }
"""

_BINS = 30
_FEWEST = 5
_NAMES = (("azimuth_deg", "azimuth in the eye, degrees"), ("elevation_deg", "elevation in the eye, degrees"), ("range_m", "range, m"))
_BEFORE, _AFTER = "#d6604d", "#2166ac"


def rms(values: Array) -> float:
    """Root mean square; nan of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan


# --- Pictures ---


def _img(drawn: Any, about: str) -> str:
    return f'<img alt="{html.escape(about)}" src="data:image/png;base64,{base64.b64encode(png(drawn)).decode()}">'


def bins(x: Array, values: Array) -> tuple[Array, Array, Array]:
    """Middle, median and half of the middle two thirds of the values in each of some bins of x that have enough."""
    edges = np.unique(np.quantile(x, np.linspace(0, 1, _BINS + 1))) if len(x) else np.zeros(1)
    place = np.clip(np.searchsorted(edges, x, "right") - 1, 0, max(len(edges) - 2, 0))
    made = [(float(x[place == i].mean()), *(float(v) for v in np.quantile(values[place == i], (0.5, 1 / 6, 5 / 6))))
            for i in range(len(edges) - 1) if (place == i).sum() >= _FEWEST]
    table = np.array(made).reshape(-1, 4)
    return table[:, 0], table[:, 1], (table[:, 3] - table[:, 2]) / 2


def _end(residuals: Array, share: float) -> float:
    """Where a scale in mm ends, so that a few outliers do not hide the others."""
    return max(5.0, float(np.percentile(np.abs(1000 * residuals), share))) if len(residuals) else 5.0


def _curves(found: Residuals) -> str:
    """Residuals by eye over angle and range."""
    figure, drawn = canvas(11, 5.5)
    places = figure.subplots(2, len(_NAMES), sharey="row")
    for eye, rows in enumerate(places):
        chosen = found.eye == eye
        end = _end(np.concatenate((found.before_m[chosen], found.after_m[chosen])), 97)
        for axes, (name, label) in zip(rows, _NAMES):
            x = np.asarray(getattr(found, name))[chosen]
            for values, colour, when in ((found.before_m, _BEFORE, "before"), (found.after_m, _AFTER, "after")):
                middle, median, spread = bins(x, 1000 * np.asarray(values)[chosen])
                axes.fill_between(middle, median - spread, median + spread, color=colour, alpha=0.2, linewidth=0)
                axes.plot(middle, median, color=colour, linewidth=1.4, label=when)
            axes.axhline(0, color="black", linewidth=0.5)
            axes.set_ylim(-end, end)
            axes.grid(alpha=0.3)
            small(axes, f"{EYES[eye]} eye", label, "mm")
        rows[0].legend(fontsize=7)
    return _img(drawn, "residuals before and after, by eye, over azimuth, elevation and range")


def _maps(found: Residuals) -> str:
    """What is left over the view of each eye, each row with its own scale."""
    figure, drawn = canvas(11, 5)
    for rows, (name, residuals) in zip(figure.subplots(2, 2), (("before", found.before_m), ("after", found.after_m))):
        values, end = 1000 * np.asarray(residuals), _end(residuals, 95)
        # The green eye looks left.
        shown = [_map(axes, found, eye, values, end, f"{EYES[eye]} eye, {name}") for axes, eye in zip(rows, (1, 0))]
        for image in [image for image in shown if image is not None][:1]:
            bar = figure.colorbar(image, ax=list(rows), extend="both", pad=0.01)
            bar.set_label("mm longer than expected", fontsize=8)
            bar.ax.tick_params(labelsize=7)
    return _img(drawn, "residuals before and after over the view of each eye")


def _map(axes: Any, found: Residuals, eye: int, values: Array, end: float, title: str) -> Any:
    chosen = np.asarray(found.eye) == eye
    small(axes, f"{title}: {millimetres(rms(values[chosen]) / 1000)}", "azimuth, degrees", "elevation, degrees")
    if not chosen.any():
        return None
    x, y = np.asarray(found.azimuth_deg)[chosen], np.asarray(found.elevation_deg)[chosen]
    limits = ((float(x.min()), float(x.max()) + 1e-6), (float(y.min()), float(y.max()) + 1e-6))
    columns = int(min(72, max(9, math.sqrt(chosen.sum()))))
    image = binned(x, y, values[chosen], (max(3, columns // 3), columns), limits)
    shown = axes.imshow(image, origin="lower", extent=(*limits[0], *limits[1]), aspect="auto", cmap="RdBu_r", vmin=-end,
                        vmax=end, interpolation="nearest")
    axes.invert_xaxis()
    axes.set_facecolor("#e8e8e8")
    return shown


def _planes(planes: Sequence[Plane]) -> str:
    """The faces from above and from the right."""
    from matplotlib import colormaps

    figure, drawn = canvas(11, 5.5)
    colours = colormaps["tab20"]
    names = ("x, m (forward)", "y, m (left)", "z, m (up)")
    for axes, (i, j), title in zip(figure.subplots(1, 2), ((1, 0), (0, 2)), ("from above", "from the right")):
        for number, plane in enumerate(planes):
            points = np.asarray(plane.points).reshape(-1, 3)
            if len(points):
                axes.plot(points[:, i], points[:, j], ".", markersize=2, color=colours(number % 20))
                middle = points.mean(0)
                box = {"boxstyle": "round,pad=.15", "fc": "white", "ec": colours(number % 20), "alpha": 0.85}
                axes.annotate(str(number + 1), (middle[i], middle[j]), fontsize=9, weight="bold", ha="center", va="center", bbox=box)
        axes.plot(0, 0, marker="^", color="black", markersize=7)
        axes.set_aspect("equal", adjustable="datalim")
        if i == 1:
            axes.invert_xaxis()
        axes.grid(alpha=0.3)
        small(axes, f"{title}; the triangle is the sensor of the first capture", names[i], names[j])
    return _img(drawn, "the faces that were found, from above and from the right")


# --- Tables ---


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1, held: Sequence[bool] = ()) -> str:
    """A table: the first columns are words, the others are numbers."""
    def cells(tag: str, values: Sequence[str]) -> str:
        return "".join(f'<{tag}{"" if i < words else " class=n"}>{html.escape(value)}</{tag}>' for i, value in enumerate(values))

    made = [f"<tr>{cells('th', heads)}</tr>"]
    for place, values in enumerate(rows):
        is_held = place < len(held) and held[place]
        made.append(f"<tr{' class=held' if is_held else ''}>{cells('td', values)}</tr>")
    return "<table>" + "\n".join(made) + "</table>"


def _values(found: Solution) -> str:
    rows, held = [], []
    for parameter in found.parameters:
        key, value, sigma, before = row(parameter)
        is_held = bool(parameter.held)
        rows.append((key, value, sigma, before, "" if is_held else f"{parameter.value - parameter.before:+.{digits(key)}f}"))
        held.append(is_held)
    return _table(("key, below eyes", "value", "standard deviation", "before", "change"), rows, held=held)


def _groups(found: Solution) -> str:
    r = found.residuals
    eye, capture = np.asarray(r.eye), np.asarray(r.capture)
    rows = [(f"{name} eye", eye == number) for number, name in enumerate(EYES)]
    for number, name in enumerate(found.captures):
        rows.append((os.path.basename(name), capture == number))
        rows += [(f"{os.path.basename(name)}, {EYES[e]} eye", (capture == number) & (eye == e)) for e in range(len(EYES))]
    before, after = np.asarray(r.before_m), np.asarray(r.after_m)
    return _table(("of", "before", "after", "residuals"), [
        (name, millimetres(rms(before[chosen])), millimetres(rms(after[chosen])), f"{int(chosen.sum()):,}") for name, chosen in rows])


def _faces(found: Solution) -> str:
    rows = [(str(number), ", ".join(str(i + 1) for i in plane.captures), ", ".join(EYES[i] for i in plane.eyes), f"{plane.cells:,}",
             millimetres(plane.rms_before_m), millimetres(plane.rms_after_m), f"{1000 * plane.bias_m:+.1f} mm")
            for number, plane in enumerate(found.planes, 1) if plane.cells]
    return _table(("face", "seen in captures", "by eyes", "cells", "before", "after", "bias"), rows, words=3)


def _besides(found: Solution) -> str:
    """What was found and is in no calibration."""
    table = _table(("mirror", *(f"term {order}" for order in ORDERS), "at most"), [
        (name, *(f"{term:+.4f}" for term in terms), f"{bent:.4f}")
        for (name, bent), terms in zip(bends(found), np.asarray(found.bends_deg).reshape(-1, len(ORDERS)))])
    uneven = _table(("of", "standard deviation"), [
        (name.removesuffix("_deg"), f"{value:.4f} degrees" if name.endswith("_deg") else f"{1000 * value:.2f} mm")
        for name, value in found.spread.items()])
    return f"""<h2>Found besides</h2>
<p>No calibration file holds these, and clouds are made without them. Readings of the mirrors depart from a straight line, by
Legendre terms, in degrees:</p>
{table}
<p>Faces and mirrors were taken to be this uneven, which the standard deviations of the values rest on; the bias of each face
is in the last table:</p>
{uneven}"""


def _held(found: Solution) -> str:
    rows = "".join(f"<li><b>{html.escape(', '.join(keys))}</b>: {html.escape(why)}</li>" for why, keys in reasons(found).items())
    told = "These captures cannot determine these values. They keep their starting values."
    return f"<h2>What is held</h2><p>{told}</p><ul>{rows}</ul>" if rows else ""


def _more(found: Solution) -> str:
    rows = "".join(f"<li>{html.escape(line)}</li>" for line in more(found))
    return f"<h2>What more captures would bring</h2><ul>{rows}</ul>" if rows else ""


def _verdict(found: Solution) -> str:
    if math.isfinite(found.held_out_after_m):
        told = f"On faces left out of the fit, residuals are {change(found.held_out_before_m, found.held_out_after_m)}."
    else:
        told = "No face could be left out, so the result has no independent test."
    before, after, _ = compared(found)
    word = f'<b class="good">The calibration is {"better" if after < before else "no worse"}.</b>'
    why = not_written(found)
    if why:
        word = f'<b class="bad">No calibration is written: {html.escape(why)}.</b>'
    over_all = f"Over all faces: {change(found.rms_before_m, found.rms_after_m)} (rms)."
    return f"<p>{word} {html.escape(told)} {over_all}</p>"


def page(found: Solution) -> str:
    """The whole report."""
    captures = "".join(f"<li>{html.escape(os.fspath(name))}</li>" for name in found.captures)
    notes = "".join(f"<li>{html.escape(note)}</li>" for note in found.notes)
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Calibration report</title><style>{_STYLE}</style></head><body>
<h1>Calibration of both eyes</h1>
{_verdict(found)}
<p>Before: {html.escape(found.began)}. Captures:</p><ol>{captures}</ol>
<h2>Values</h2>
{_values(found)}
{_held(found)}
{_more(found)}
{f"<h2>Notes</h2><ul>{notes}</ul>" if notes else ""}
<h2>Residuals by eye and capture</h2>
{_groups(found)}
{_besides(found)}
<h2>Residuals by angle and range</h2>
<p>Lines are medians, bands hold two thirds. A right calibration leaves lines flat at zero: what is left then is noise and
the walls' own waves.</p>
{_curves(found.residuals)}
<h2>Residuals over the view</h2>
{_maps(found.residuals)}
<h2>Faces</h2>
{_planes(found.planes)}
{_faces(found)}
<p>Made by lumcal {VERSION}.</p>
</body></html>
"""
