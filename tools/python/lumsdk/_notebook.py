"""A frame as a picture, and what a notebook shows of it."""
from __future__ import annotations

import base64
import html
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._drawing import png
from ._errors import OptionError
from ._grid import EYES
from ._table import extra

if TYPE_CHECKING:
    from ._frame import Frame

_VIEW = (60.0, -60.0, 3.0, -17.0)
"""Degrees at the edges of the strip: left, right, top, bottom."""

COLOURS = {"range": ("range", "m"), "height": ("z", "m"), "pulse_width": ("pulse_width", "ns"), "label": ("label", "")}
"""What colours of a picture can mean: a column and its unit."""

_SIZE = (1600, 1200)
_COLUMNS = 800  # of the strip: in more, pixels of a line leave gaps
_SIDES = range(640, 8001)
_DPI = 100

_LABELS = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#e6e6e6")
"""Of Okabe and Ito, which colour-blind people can tell apart; the ninth label has the first again."""

_PAPER, _PANEL, _INK, _GRID = "#181a20", "#0c0d10", "#e6e8ec", "#3e424c"
_DARK = 0.12
"""Of viridis, the share that would not show on the dark ground."""


def _step(span: float, n: int) -> float:
    """A step of 1, 2 or 5 times a power of ten, so that a span has about n."""
    ten = 10.0 ** np.floor(np.log10(span / n))
    return float(min((ten, 2 * ten, 5 * ten, 10 * ten), key=lambda step: abs(np.log(span / n / step))))


class _Picture:
    """A frame as lumdump draws it (docs/formats.md, "PNG"), by matplotlib."""

    def __init__(self, frame: Frame, colour: str, size: tuple[int, int]) -> None:
        from matplotlib.figure import Figure

        column, self.unit = COLOURS[colour]
        self.frame, self.colour, self.size = frame, colour, size
        self.values: Any = frame[column]  # type: ignore[call-overload]
        self.image = frame.image(column, columns=_COLUMNS)  # type: ignore[arg-type]
        self.scale = max(min(size[0] / _SIZE[0], size[1] / _SIZE[1]), 0.5)
        self.figure = Figure(figsize=(size[0] / _DPI, size[1] / _DPI), dpi=_DPI, facecolor=_PAPER)
        self.map, self.norm = self._colours()

    def _limits(self) -> tuple[float, float]:
        """Values of the colours' ends: all but the lowest and the highest 2 %."""
        values = self.values[np.isfinite(self.values)]
        low, high = (float(v) for v in np.percentile(values, (2, 98))) if len(values) else (0.0, 0.0)
        if self.colour == "range":
            low = max(low, 0.5)
        return low, max(high, 2 * low if self.colour == "range" else low + 1)

    def _colours(self) -> tuple[Any, Any]:
        from matplotlib import colormaps
        from matplotlib.colors import ListedColormap, LogNorm, Normalize

        if self.colour == "label":
            self.labels = np.unique(self.values)
            self.values, self.image = self.values % len(_LABELS), self.image % len(_LABELS)
            return ListedColormap(_LABELS), Normalize(-0.5, len(_LABELS) - 0.5)
        viridis = ListedColormap(colormaps["viridis"](np.linspace(_DARK, 1, 256)))
        return viridis, (LogNorm if self.colour == "range" else Normalize)(*self._limits(), clip=True)

    def _box(self, left: float, top: float, width: float, height: float) -> Any:
        """Axes in a box of pixels."""
        across, down = self.size
        return self.figure.add_axes((left / across, 1 - (top + height) / down, width / across, height / down))

    def _text(self, x: float, y: float, text: str, size: float, align: Any = "left") -> None:
        self.figure.text(x / self.size[0], 1 - y / self.size[1], text, color=_INK, fontsize=size * self.scale * 72 / _DPI, ha=align,
                         va="center")

    def _dress(self, axes: Any) -> None:
        axes.set_facecolor(_PANEL)
        axes.tick_params(labelsize=16 * self.scale * 72 / _DPI, colors=_INK)
        for edge in axes.spines.values():
            edge.set_visible(False)

    def _title(self) -> None:
        frame, k = self.frame, self.scale
        self._text(20 * k, 30 * k, f"{frame.sensor}, frame {frame.number}", 28)
        time = f"{frame.time:%Y-%m-%d %H:%M:%S}.{frame.time.microsecond // 1000:03} UTC"
        self._text(self.size[0] - 20 * k, 30 * k, time, 22, "right")
        self._text(20 * k, 64 * k, f"{len(frame):,} points, {'complete' if frame.complete else 'incomplete'}", 18)

    def _both_eyes(self) -> tuple[float, float]:
        """The strip at the lower end: a degree is as wide as it is high. Returns where it begins and how high it is."""
        k = self.scale
        room = self.size[0] - 98 * k
        width = min(room, 6 * self.size[1] / 2)
        height = width / 6
        top = self.size[1] - 48 * k - height
        axes = self._box(78 * k + (room - width) / 2, top, width, height)
        axes.imshow(self.image, extent=_VIEW[:2] + _VIEW[:1:-1], aspect="auto", norm=self.norm, cmap=self.map,
                    interpolation="nearest", resample=False)
        axes.set_xticks(range(60, -61, -10))
        axes.set_yticks(range(-15, 1, 5))
        self._dress(axes)
        self._text(78 * k, top - 16 * k, "As both eyes see it", 18)
        self._text(self.size[0] - 20 * k, top - 16 * k, "azimuth and elevation in degrees", 16, "right")
        return top, height

    def _seen(self, rows: int, columns: int) -> tuple[Any, tuple[float, ...]]:
        """The points from above, as values of pixels, from the lower end up; and the metres at the edges."""
        is_somewhere = _somewhere(self.frame)
        x, y, z = self.frame.xyz[is_somewhere].T.astype(float)
        given = self.values[is_somewhere]
        distance = np.hypot(x, y)
        near = distance <= max(float(np.percentile(distance, 95)), 2.0)
        low, high = min(x[near].min(), 0), max(x[near].max(), 1)
        right, left = min(y[near].min(), -0.5), max(y[near].max(), 0.5)
        pixel = 1.06 * max((high - low) / rows, (left - right) / columns)
        low, left = low - 0.03 * (high - low), (left + right) / 2 + columns / 2 * pixel
        seen = np.full((rows, columns), np.nan)
        up = np.argsort(z, kind="stable")  # of points above each other one sees the highest
        row, column, values = (x[up] - low) // pixel, (left - y[up]) // pixel, given[up]
        side = max(round(self.scale * (3 if len(z) < 200_000 else 2)), 1)
        for i in range(side * side):
            inside = (row >= 0) & (row < rows - side) & (column >= 0) & (column < columns - side)
            seen[row[inside].astype(int) + i // side, column[inside].astype(int) + i % side] = values[inside]
        return seen, (left, left - columns * pixel, low, low + rows * pixel)

    def _from_above(self, top: float, height: float) -> None:
        k = self.scale
        width = self.size[0] - 184 * k
        axes = self._box(20 * k, top, width, height)
        seen, edges = self._seen(int(height), int(width))
        axes.imshow(seen, extent=edges, origin="lower", aspect="auto", norm=self.norm, cmap=self.map, interpolation="nearest",
                    resample=False, zorder=2)
        self._rings(axes, edges, edges[3] - edges[2])
        axes.set(xticks=[], yticks=[], xlim=edges[:2], ylim=edges[2:])
        self._dress(axes)
        self._text(20 * k, top - 16 * k, "From above", 18)
        self._text(20 * k + width, top - 16 * k, "x up, y to the left", 16, "right")

    def _rings(self, axes: Any, edges: tuple[float, ...], height: float) -> None:
        from matplotlib.patches import Circle

        step = _step(height, 5)
        for i in range(1, int((height + edges[0] - edges[1]) / step) + 1):
            axes.add_patch(Circle((0, 0), i * step, fill=False, edgecolor=_GRID, linewidth=0.8, zorder=1))
            if i * step < edges[3] - 0.03 * height:
                axes.text(0, i * step, f"{i * step:g} m", color=_INK, fontsize=18 * self.scale * 72 / _DPI, ha="center", va="center",
                          zorder=3, bbox={"facecolor": _PANEL, "alpha": 0.7, "edgecolor": "none", "pad": 2})
        axes.plot(0, 0, "+", color=_INK, markersize=11 * self.scale, markeredgewidth=2 * self.scale, zorder=3)

    def _numbers(self) -> tuple[list[float], list[str]]:
        """Places along the colours, and what stands there: the labels of each colour, or the ends and numbers between."""
        if self.colour == "label":
            of = [[f"{label:.0f}" for label in self.labels if label % len(_LABELS) == i] for i in range(len(_LABELS))]
            return list(range(len(of))), [", ".join(labels[:3]) + (", ..." if len(labels) > 3 else "") for labels in of]
        low, high = self.norm.vmin, self.norm.vmax
        if self.colour == "range":
            numbers = [digit * 10.0 ** power for power in range(-1, 6) for digit in (1, 2, 5)]
        else:
            step = _step(high - low, 6)
            numbers = [i * step for i in range(int(np.floor(low / step)), int(np.ceil(high / step)) + 1)]
        between = [number for number in numbers if low < number < high and 0.03 < self.norm(number) < 0.97]
        texts = [f"≤ {low:.3g}", *(f"{number:.4g}" for number in between), f"≥ {high:.3g}"]
        return [low, *between, high], [f"{text} {self.unit}" for text in texts]

    def _bar(self, top: float, height: float) -> None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.ticker import FixedLocator, NullLocator

        k = self.scale
        axes = self._box(self.size[0] - 144 * k, top + 10 * k, 28 * k, height - 20 * k)
        bar = self.figure.colorbar(ScalarMappable(self.norm, self.map), cax=axes)
        ticks, texts = self._numbers()
        axes.yaxis.set_major_locator(FixedLocator(ticks))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.set_yticklabels(texts)
        bar.outline.set_visible(False)
        self._dress(axes)
        self._text(self.size[0] - 144 * k, top - 16 * k, self.colour.replace("_", " ").capitalize(), 18)

    def draw(self) -> bytes:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        k = self.scale
        self._title()
        end = self._both_eyes()[0] - 52 * k
        self._from_above(112 * k, end - 112 * k)
        self._bar(112 * k, end - 112 * k)
        return png(FigureCanvasAgg(self.figure))


def _somewhere(frame: Frame) -> Any:
    """Which of its points have coordinates."""
    return np.isfinite(frame.xyz).all(axis=1)


def to_png(frame: Frame, colour: str = "range", size: tuple[int, int] = _SIZE) -> bytes:
    if colour not in COLOURS:
        raise OptionError(f"colour is {colour!r}; use one of {', '.join(COLOURS)}")
    if len(size) != 2 or not all(side in _SIDES for side in size):
        raise OptionError(f"size is {size!r}; use (width, height) in pixels, each from {_SIDES[0]} to {_SIDES[-1]}")
    for name in ("x", "y", "z", COLOURS[colour][0]):
        if name not in frame.columns:
            raise frame._refuse(name)
    if not _somewhere(frame).any():
        raise OptionError(f"frame {frame.number} has no points with coordinates")
    extra("matplotlib", "notebook")
    return _Picture(frame, colour, size).draw()


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
        made = to_png(frame, "range" if "range" in frame.columns else "height", (1000, 750))
    except Exception:  # what is shown by itself must never stop a notebook
        return ""
    text = base64.b64encode(made).decode()
    about = f"frame {frame.number} from above, and as both eyes see it"
    return f'<img alt="{about}" style="max-width:100%" src="data:image/png;base64,{text}">'


def to_html(frame: Frame) -> Optional[str]:
    """What a notebook shows of a frame: a table of counts, and with matplotlib its picture. Never raises."""
    try:
        title = f"<b>Frame {frame.number}</b> of {html.escape(str(frame.sensor))}"
        return f"<div>{title}{_image(frame)}{_table(frame)}</div>"
    except Exception:  # as above
        return None
