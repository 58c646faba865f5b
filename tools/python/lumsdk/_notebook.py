"""A frame in a notebook: its range images, or its counts."""
from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from ._frame import Frame

EYES = ("blue", "green")

_ROWS, _COLUMNS = 320, 400
"""Most cells of a picture of an eye."""

_TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)


def _line_count(frame: Frame) -> int:
    """Lines of a picture. A damaged packet can claim any number, so numbers beyond those of whole lines do not count."""
    numbers: Any = np.sort(frame.lines["number"])
    if not len(numbers):
        return 0
    usual = int(numbers[len(numbers) * 9 // 10]) + 1
    return min(int(numbers[-1]) + 1, 64 if usual <= 64 else max(640, usual))


def _azimuths(frame: Frame) -> tuple[Any, str]:
    """Degrees of each point, positive to the left, and what they are: those of the column are of the eye, which is turned."""
    if {"x", "y"} <= set(frame.columns):
        return np.degrees(np.arctan2(frame["y"], frame["x"])), "azimuth from the sensor, degrees"
    return frame["azimuth"], "azimuth in the eye, degrees"


def range_image(frame: Frame, eye: str) -> tuple[Any, tuple[float, float]]:
    """The ranges of an eye by line and azimuth, as few cells as a picture needs.

    Lines are scanned in turn to one side and to the other, so that pixels of neighbours do not lie below each other.

    Returns:
        Metres, the nearest of each cell, NaN where there is no point; and the azimuths of the left and the right end.
    """
    count = _line_count(frame)
    chosen = (frame["eye"] == EYES.index(eye)) & (frame["line"] < count)
    azimuths, lines, ranges = _azimuths(frame)[0][chosen], frame["line"][chosen], frame["range"][chosen]
    step = max(1, -(-count // _ROWS))
    image: Any = np.full((max(1, -(-count // step)), _COLUMNS), np.inf, "f4")
    left, right = (float(azimuths.max()), float(azimuths.min())) if len(azimuths) else (30.0, -30.0)
    scale = (_COLUMNS - 1) / max(left - right, 1e-6)
    columns = np.rint((left - azimuths) * scale).astype(np.intp)
    np.minimum.at(image, (lines.astype(np.intp) // step, columns), ranges)
    image[np.isinf(image)] = np.nan
    return image, (left, right)


def _limits(images: list[Any]) -> tuple[float, float]:
    """Ranges of the colours: all but the lowest and the highest 2 %."""
    values = np.concatenate([image[~np.isnan(image)] for image in images])
    values = values[values > 0]
    if not len(values):
        return 1.0, 100.0
    low, high = (float(v) for v in np.percentile(values, (2, 98)))
    return low, max(high, low * 1.1)


def _draw(axes: Any, image: Any, ends: tuple[float, float], lines: int, norm: Any) -> Any:
    shown = axes.imshow(image, extent=(*ends, lines - 0.5, -0.5), aspect="auto", norm=norm, cmap="turbo_r",
                        interpolation="nearest")
    axes.set_facecolor("#202020")
    axes.tick_params(labelsize=7)
    return shown


def _scale(figure: Any, shown: Any, low: float, high: float) -> None:
    from matplotlib.ticker import FixedLocator, NullLocator

    bar = figure.colorbar(shown, cax=figure.add_axes((0.93, 0.19, 0.012, 0.71)), format="%g", extend="both",
                          ticks=FixedLocator([t for t in _TICKS if low <= t <= high]))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.tick_params(labelsize=7)
    bar.set_label("range, m", fontsize=8)


def to_png(frame: Frame) -> Optional[bytes]:
    """Both eyes' range images with a scale in metres, as PNG; None: matplotlib is missing, or there is nothing to show."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.colors import LogNorm
        from matplotlib.figure import Figure
    except ImportError:
        return None
    names = set(frame.columns)
    if not len(frame) or not {"range", "line", "eye"} <= names or not ("azimuth" in names or {"x", "y"} <= names):
        return None
    images = [range_image(frame, eye) for eye in EYES]
    low, high = _limits([image for image, _ in images])
    label = _azimuths(frame)[1]
    norm = LogNorm(low, high, clip=True)
    figure = Figure(figsize=(9.0, 2.6), dpi=80)
    canvas: Any = FigureCanvasAgg(figure)
    shown = None
    # The green eye looks left, and the blue one right.
    for place, which in enumerate((1, 0)):
        axes = figure.add_axes((0.06 + 0.435 * place, 0.19, 0.42, 0.71))
        shown = _draw(axes, *images[which], _line_count(frame), norm)
        axes.set_title(f"{EYES[which]} eye", fontsize=9, loc="left")
        axes.set_xlabel(label, fontsize=8)
        if place:
            axes.set_yticklabels([])
        else:
            axes.set_ylabel("line", fontsize=8)
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
    about = f"range images of both eyes of frame {frame.number}"
    return f'<img alt="{about}" style="max-width:100%" src="data:image/png;base64,{text}">'


def to_html(frame: Frame) -> Optional[str]:
    """What a notebook shows of a frame: a table of counts, and with matplotlib its range images. Never raises."""
    try:
        title = f"<b>Frame {frame.number}</b> of {html.escape(str(frame.sensor))}"
        return f"<div>{title}{_image(frame)}{_table(frame)}</div>"
    except Exception:  # as above
        return None
