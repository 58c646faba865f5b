"""Pictures by matplotlib, without a display."""
from __future__ import annotations

import io
from typing import Any


def canvas(width: float, height: float) -> tuple[Any, Any]:
    """A figure, and what draws it without a display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=100, layout="constrained")
    return figure, FigureCanvasAgg(figure)


def png(drawn: Any) -> bytes:
    """A canvas as bytes, which depend on nothing but what is drawn."""
    out = io.BytesIO()
    drawn.print_png(out, metadata={"Software": None})
    return out.getvalue()


def small(axes: Any, title: str, x: str, y: str) -> None:
    """Title and labels of a diagram among others."""
    axes.set_title(title, fontsize=9, loc="left")
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.tick_params(labelsize=7)
