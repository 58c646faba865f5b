"""A drive as a picture: the path from above, speeds, residuals, and errors where there is a truth."""
from __future__ import annotations

from typing import Any

import numpy as np

from .._drawing import canvas, png, small
from ._result import Result, text

_LINE = {"color": "#2166ac", "linewidth": 1.0}
_SECONDS = "seconds from the beginning"


def _draw_path(axes: Any, found: Result) -> None:
    places = np.array(found.track.poses)[:, :3, 3]
    axes.plot(places[:, 0], places[:, 1], **_LINE)
    axes.plot(*places[0, :2], "o", color="#1b7837", markersize=6, label="beginning")
    axes.plot(*places[-1, :2], "s", color="#b2182b", markersize=5, label="end")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)
    small(axes, "from above", "x, m (forward at the beginning)", "y, m (left)")


def _draw_over_time(axes: Any, seconds: Any, values: Any, title: str, unit: str) -> None:
    axes.plot(seconds, values, **_LINE)
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.3)
    small(axes, title, _SECONDS, unit)


def to_png(found: Result) -> bytes:
    """The picture of --report."""
    times = found.track.times_s()
    figure, drawn = canvas(11, 7)
    left, right = figure.subfigures(1, 2)
    _draw_path(left.subplots(), found)
    rows = np.ravel(right.subplots(3 if found.errors is not None else 2, 1))
    _draw_over_time(rows[0], times[1:], found.path.speeds_m_s, "speed", "m/s")
    _draw_over_time(rows[1], times[2:-1], 100 * np.array(found.track.residuals_m),
                    "residuals: points from the nearest one of the frame before, median", "cm")
    if found.errors is not None:
        mean = found.errors.translation_percent
        told = "" if mean is None else f", on average {mean:.3f} % of a length"
        _draw_over_time(rows[2], times[list(found.errors.chosen)], found.errors.each_m, f"away from the truth{told}", "m")
    figure.suptitle("\n".join(text(found).splitlines()[:5]), fontsize=9, x=0.01, ha="left", family="monospace")
    return png(drawn)
