"""Draw distribution functions of errors, with the paper's printed points among them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.legend_handler import HandlerTuple

from benchmarks.figures.data import Curve, CurveFigure, Mark
from benchmarks.figures.draw.page import PANEL_HEIGHT, finish, panel_axes
from benchmarks.figures.draw.style import MUTED, PAPER_INK, colour

PANEL_WIDTH, LEGEND_WIDTH = 3.3, 2.3
MARKERS = {"diamond": "D", "circle": "o", "square": "s"}
"""Matplotlib's names for the shapes of the paper's points."""
LEGEND_LINE, LEGEND_GAP = 0.125, 0.115
"""Inches of the legend, which may be higher than other figures' panels."""
_ENDS = np.array([1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])


def draw_curves(figure: CurveFigure) -> Canvas:
    """The whole figure, its legend beside the axes where it hides nothing."""
    named = dict.fromkeys([*map(_words, figure.curves), *map(_mark_words, figure.marks)])
    legend_in = sum(LEGEND_LINE * (label.count("\n") + 1) + LEGEND_GAP for label in named if label)
    canvas, (ax, beside) = panel_axes([PANEL_WIDTH, LEGEND_WIDTH], 0.08, max(PANEL_HEIGHT, legend_in))
    for curve in figure.curves:
        _draw_curve(ax, curve)
    for mark in figure.marks:
        _draw_mark(ax, mark)
    ax.set_xlim(0.0, axis_end(figure))
    ax.set_ylim(0.0, 103.0)
    ax.set_yticks(np.arange(0, 101, 10))
    ax.grid(axis="x")
    ax.set_xlabel(figure.x_label)
    ax.set_ylabel("share of the estimates (%)")
    if figure.empty:
        ax.text(0.5, 0.5, "no data", transform=ax.transAxes, ha="center", color=MUTED, fontsize=14)
    beside.set_axis_off()
    handles, labels = _legend(ax)
    beside.legend(
        handles, labels, loc="center left", borderaxespad=0.0, labelspacing=1.0, handlelength=2.6,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )  # fmt: skip
    return finish(canvas, figure.title, figure.note)


def _legend(ax: Axes) -> tuple[list[Any], list[str]]:
    """Handles and labels; lines of one label share an entry, which shows both."""
    entries: dict[str, list[Any]] = {}
    for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
        entries.setdefault(label, []).append(handle)
    return [tuple(handles) if len(handles) > 1 else handles[0] for handles in entries.values()], list(entries)


def axis_end(figure: CurveFigure) -> float:
    """A round number past the 95th percentile of every curve but diagnostics and past the paper's points."""
    reach = [figure.reach, *(mark.paper.display * 1.1 for mark in figure.marks)]
    for curve in (curve for curve in figure.curves if curve.n and not curve.diagnostic):
        reach.append(float(curve.value[np.searchsorted(curve.share, 0.95).clip(max=len(curve.value) - 1)]))
    longest = max(reach, default=1.0)
    scale = 10.0 ** np.floor(np.log10(longest))
    return float(_ENDS[np.searchsorted(_ENDS, longest / scale)] * scale)


def _draw_curve(ax: Axes, curve: Curve) -> None:
    x, y = np.concatenate([[0.0], curve.value]), np.concatenate([[0.0], 100.0 * curve.share])
    solid, dashed = ("-", (0, (4, 1.6))) if not curve.diagnostic else ((0, (1, 1.2)), (0, (4, 1.6, 1, 1.6)))
    ax.plot(
        x, y, drawstyle="steps-post", color=colour(curve.key), linewidth=1.0 if curve.diagnostic else 1.7,
        linestyle=dashed if curve.dashed else solid, label=_words(curve) or None,
    )  # fmt: skip


def _words(curve: Curve) -> str:
    """In the legend, where both diagnostics of a detector share an entry."""
    if curve.diagnostic:
        return f"{curve.key}, both\nagainst the nearest loud echo"
    return "\n".join([curve.label, *curve.summary.split("; ")]) if curve.n else f"{curve.label}: no data"


def _mark_words(mark: Mark) -> str:
    return f"paper, {mark.label}: {mark.paper.text}"


def _draw_mark(ax: Axes, mark: Mark) -> None:
    x, y = mark.paper.display, 100.0 * mark.share
    ax.plot(
        x, y, MARKERS[mark.shape], color="white", markeredgecolor=PAPER_INK, markeredgewidth=1.4, markersize=6,
        zorder=5, label=_mark_words(mark),
    )  # fmt: skip
