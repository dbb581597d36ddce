"""How every figure looks, and how it becomes bytes that are the same on every run."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib.style
import pandas as pd
from matplotlib.figure import Figure as Canvas

from benchmarks.figures.plots import Figure
from scenes.obstacles import CATEGORIES

INK, MUTED, HAIR = "#1d2430", "#6a7280", "#d5d9e0"
PAPER_INK = "#b4432f"
PALETTE = ("#2c5f8a", "#d08a2e", "#1f8a70", "#7a5195", "#6b4f3a", "#5b9bd5", "#9aa331")
"""For series that are no detectors; told apart also in grey and by the colour-blind."""
_DETECTORS = {"PaperDetector": "#2c5f8a", "TrackingDetector": "#1f8a70", "DistanceOnlyDetector": "#b9822b"}
_COLOURS = _DETECTORS | dict(zip(CATEGORIES, PALETTE, strict=False))
_SPARE = ("#7a5195", "#5d7052", "#8c564b")

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": HAIR,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "hatch.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.dpi": 100,
    "savefig.dpi": 160,
    "svg.hashsalt": "obstaclewatch",
    "path.simplify": True,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Matplotlib's defaults and the above, whatever the user's own settings."""
    with matplotlib.style.context(["default", _STYLE]):
        yield


def colour(key: str) -> str:
    """The colour of a detector or a category of obstacles: the same in every figure."""
    return _COLOURS.get(key) or _SPARE[sum(key.encode()) % len(_SPARE)]


def series_colour(key: str) -> str:
    """The colour of a line: "paper", "muted", "ink", a digit of the palette, or what `colour` knows."""
    fixed = {"paper": PAPER_INK, "muted": MUTED, "ink": INK, "on image": "#ff6b4a", "on image too": "#58c4ff"}
    return fixed.get(key) or (PALETTE[int(key) % len(PALETTE)] if key.isdigit() else colour(key))


def lighter(hex_colour: str, share: float = 0.55) -> str:
    """A colour mixed with white."""
    channels = (int(hex_colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(255 - (255 - c) * (1.0 - share)):02x}" for c in channels)


def picture_bytes(canvas: Canvas, kind: str) -> bytes:
    """A drawn figure as "png" or "svg", without dates or versions."""
    metadata = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}}[kind]
    buffer = io.BytesIO()
    with house_style():  # the salt of the svg's ids and the resolution are read here, not when drawing
        canvas.savefig(buffer, format=kind, metadata=metadata)
    return buffer.getvalue()


def csv_text(figure: Figure) -> str:
    """What is plotted, one row a bar or a step; numbers to six digits, NaN empty."""
    rows = pd.DataFrame(figure.rows())
    return "" if rows.empty else rows.to_csv(index=False, lineterminator="\n", float_format="%.6g")
