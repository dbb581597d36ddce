"""Draw grouped bars with intervals, counts and the paper's values beside."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Patch

from benchmarks.figures.data import Bar, BarFigure, BarPanel
from benchmarks.figures.draw.page import finish, leads_row, panel_axes
from benchmarks.figures.draw.style import INK, MUTED, PAPER_INK, colour, lighter

BAR_WIDTH, PAPER_WIDTH, GAP = 1.0, 0.55, 0.9
INCHES_PER_UNIT = 0.44
_LIGHTER = (0.0, 0.55, 0.75)


def draw_bars(figure: BarFigure) -> Canvas:
    """The whole figure: one axes a panel, each as wide as its bars need."""
    inches = _inches_per_unit(figure)
    widths = [max(2.0, inches * (_places(panel)[-1] + GAP)) for panel in figure.panels]
    canvas, axes = panel_axes(widths)
    for ax, panel in zip(axes, figure.panels, strict=True):
        _draw_panel(ax, panel, figure, 7.0 if inches == INCHES_PER_UNIT else 6.0)
    _share_scale(axes, figure)
    return finish(canvas, figure.title, figure.note, _legend(figure))


def _inches_per_unit(figure: BarFigure) -> float:
    """A bar's width on paper: less where a single panel would otherwise be wider than the page."""
    units = _places(figure.panels[0])[-1] + GAP
    return min(INCHES_PER_UNIT, 5.7 / units) if len(figure.panels) == 1 else INCHES_PER_UNIT


def _draw_panel(ax: Axes, panel: BarPanel, figure: BarFigure, count_size: float) -> None:
    places = _places(panel)
    for bar, left in zip(panel.bars, places, strict=False):
        _draw_bar(ax, bar, left, shade(panel, bar), count_size)
    middles = [_middle_of(panel, places, group) for group in panel.groups]
    ax.set_xticks(middles, panel.groups)
    ax.tick_params(axis="x", length=0, pad=13)
    ax.set_xlim(places[0] - GAP, places[-1])
    if len(figure.panels) > 1:
        ax.set_title(panel.title, color=colour(panel.title))


def _places(panel: BarPanel) -> list[float]:
    """Left edge of every bar, and last the right end of the axis."""
    places, here, group = [], 0.0, panel.bars[0].group
    for bar in panel.bars:
        if bar.group != group:
            here, group = here + GAP, bar.group
        places.append(here)
        here += BAR_WIDTH + (PAPER_WIDTH if bar.paper is not None else 0.0) + 0.08
    return [*places, here + GAP]


def _middle_of(panel: BarPanel, places: list[float], group: str) -> float:
    """Middle of a group's bars, the paper's included."""
    mine = [(bar, left) for bar, left in zip(panel.bars, places, strict=False) if bar.group == group]
    right = mine[-1][1] + BAR_WIDTH + (PAPER_WIDTH if mine[-1][0].paper is not None else 0.0)
    return 0.5 * (mine[0][1] + right)


def _draw_bar(ax: Axes, bar: Bar, left: float, shade: str, count_size: float) -> None:
    middle = left + 0.5 * BAR_WIDTH
    if bar.n == 0:
        ax.text(middle, 0.02, "no data", rotation=90, ha="center", va="bottom", color=MUTED, fontsize=8,
                transform=ax.get_xaxis_transform())  # fmt: skip
    else:
        ax.bar(middle, bar.value, BAR_WIDTH, color=shade, linewidth=0)
        if np.isfinite([bar.low, bar.high]).all():
            ax.errorbar(middle, bar.value, yerr=_spread(bar), color=INK, elinewidth=1.0, capsize=2.5)
        reach = np.fmax(bar.value, bar.high)  # of a resampled quantile both ends may lie below it
        ax.annotate(f"{bar.value:.1f}".removesuffix(".0"), (middle, reach), (0, 2), textcoords="offset points",
                    ha="center", va="bottom", fontsize=8, fontweight="bold")  # fmt: skip
        ax.annotate(bar.count, (middle, 0.0), (0, -3), xycoords=ax.get_xaxis_transform(), textcoords="offset points",
                    ha="center", va="top", fontsize=count_size, color=MUTED)  # fmt: skip
    if bar.paper is not None:
        _draw_paper(ax, bar, left + BAR_WIDTH + 0.5 * PAPER_WIDTH)


def _spread(bar: Bar) -> list[list[float]]:
    """Lengths of the whiskers down and up; a resampled quantile's interval may lie wholly to one side of it."""
    return [[max(0.0, bar.value - bar.low)], [max(0.0, bar.high - bar.value)]]


def _draw_paper(ax: Axes, bar: Bar, middle: float) -> None:
    assert bar.paper is not None
    ax.bar(middle, bar.paper.display, PAPER_WIDTH, facecolor="white", edgecolor=PAPER_INK, hatch="////", linewidth=0.8)
    ax.annotate(bar.paper.short, (middle, bar.paper.display), (0, 2), textcoords="offset points",
                ha="center", va="bottom", fontsize=7.5, color=PAPER_INK)  # fmt: skip


def shade(panel: BarPanel, bar: Bar) -> str:
    """The colour of the bar's detector, which is its panel or else its group, lighter for every further series."""
    return lighter(colour(panel.title or bar.group), _LIGHTER[min(2, panel.series.index(bar.series))])


def _share_scale(axes: list[Axes], figure: BarFigure) -> None:
    bars = [bar for panel in figure.panels for bar in panel.bars]
    tops = [float(np.nanmax([bar.value, bar.high])) for bar in bars if bar.n]
    tops += [bar.paper.display for bar in bars if bar.paper is not None]
    top = figure.top if figure.top is not None else 1.15 * max(tops, default=1.0)
    for ax in axes:
        ax.set_ylim(0.0, top)
        if figure.unit == "%":
            ax.set_yticks(np.arange(0.0, min(top, 100.0) + 1e-9, 20.0 if top > 50.0 else 10.0))
    for ax in axes:
        if leads_row(ax):
            ax.set_ylabel(figure.y_label)
        else:
            ax.tick_params(axis="y", labelleft=False, length=0)


def _legend(figure: BarFigure) -> list[Patch]:
    panel = figure.panels[0]
    base = colour(panel.title) if len(figure.panels) == 1 and panel.title else MUTED
    handles = [Patch(color=lighter(base, _LIGHTER[min(2, k)]), label=name) for k, name in enumerate(panel.series)]
    if any(bar.paper is not None for p in figure.panels for bar in p.bars):
        handles.append(Patch(facecolor="white", edgecolor=PAPER_INK, hatch="////", label="the paper"))
    return handles
