"""A frame in a notebook: its range image, or its counts."""
from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from ._frame import Frame

EYES = ("blue", "green")

_ROWS, _COLUMNS = 64, 800
"""Cells of a picture, as many as can be seen."""

_VIEW = (60.0, -60.0, 3.0, -17.0)
"""Degrees at its edges: left, right, top, bottom."""

_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)


def _limits(image: Any) -> tuple[float, float]:
    """Ranges of the colours: all but the lowest and the highest 2 %."""
    values = image[image > 0]
    if not len(values):
        return 1.0, 100.0
    low, high = (float(v) for v in np.percentile(values, (2, 98)))
    return low, max(high, low * 1.1)


def _draw(axes: Any, image: Any, norm: Any) -> Any:
    shown = axes.imshow(image, extent=_VIEW[:2] + _VIEW[:1:-1], aspect="auto", norm=norm, cmap="turbo_r", interpolation="nearest")
    axes.set_facecolor("#202020")
    axes.tick_params(labelsize=7)
    axes.set_title("green eye", fontsize=9, loc="left")
    axes.set_title("blue eye", fontsize=9, loc="right")
    axes.set_xlabel("azimuth, degrees", fontsize=8)
    axes.set_ylabel("elevation, degrees", fontsize=8)
    return shown


def _scale(figure: Any, shown: Any, low: float, high: float) -> None:
    from matplotlib.ticker import FixedLocator, NullLocator

    bar = figure.colorbar(shown, cax=figure.add_axes((0.93, 0.19, 0.012, 0.71)), format="%g", extend="both",
                          ticks=FixedLocator([t for t in _TICKS if low <= t <= high]))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.tick_params(labelsize=7)
    bar.set_label("range, m", fontsize=8)


def to_png(frame: Frame) -> Optional[bytes]:
    """The range image of both eyes with a scale in metres, as PNG; None: matplotlib is missing, or there is nothing to show."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.colors import LogNorm
        from matplotlib.figure import Figure
    except ImportError:
        return None
    if not len(frame) or not {"range", "x", "y", "z"} <= set(frame.columns):
        return None
    image = frame.image("range", view=_VIEW, rows=_ROWS, columns=_COLUMNS)
    low, high = _limits(image)
    figure = Figure(figsize=(9.0, 2.6), dpi=80)
    canvas: Any = FigureCanvasAgg(figure)
    shown = _draw(figure.add_axes((0.06, 0.19, 0.855, 0.71)), image, LogNorm(low, high, clip=True))
    _scale(figure, shown, low, high)
    out = io.BytesIO()
    canvas.print_png(out)
    return out.getvalue()


def _rows(frame: Frame) -> list[tuple[str, str]]:
    lines: Any = frame.lines
    counts = ", ".join(f"{int((lines['eye'] == i).sum())} {eye}" for i, eye in enumerate(EYES))
    rows = [("points", f"{len(frame):,}"), ("lines", counts), ("time", f"{frame.time:%Y-%m-%d %H:%M:%S.%f} UTC")]
    if "range" in frame.columns and len(frame):
        ranges: Any = frame["range"]
        rows.append(("range", f"{float(ranges.min()):.2f} to {float(ranges.max()):.2f} m"))
    missing = ", ".join(f"{name} {count:,}" for name, count in frame.losses.items() if count)
    rows.append(("complete", "yes" if frame.complete else "no"))
    if missing:
        rows.append(("counted", missing))
    rows.append(("columns", ", ".join(frame.columns)))
    return rows


def _table(frame: Frame) -> str:
    cells = "".join(f'<tr><th style="text-align:left">{name}</th><td style="text-align:left">{html.escape(text)}</td></tr>'
                    for name, text in _rows(frame))
    return f"<table>{cells}</table>"


def _image(frame: Frame) -> str:
    try:
        made = to_png(frame)
    except Exception:  # what is shown by itself must never stop a notebook
        made = None
    if made is None:
        return ""
    text = base64.b64encode(made).decode()
    about = f"range image of both eyes of frame {frame.number}"
    return f'<img alt="{about}" style="max-width:100%" src="data:image/png;base64,{text}">'


def to_html(frame: Frame) -> Optional[str]:
    """What a notebook shows of a frame: a table of counts, and with matplotlib its range image. Never raises."""
    try:
        title = f"<b>Frame {frame.number}</b> of {html.escape(str(frame.sensor))}"
        return f"<div>{title}{_image(frame)}{_table(frame)}</div>"
    except Exception:  # as above
        return None
