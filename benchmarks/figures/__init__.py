"""The paper's figures from a run: numbers first (`FIGURES`), then pictures (`draw_figures`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.figures.data import BarFigure, Figure
from benchmarks.figures.errors import (
    DISTANCE_FIGURES,
    bearing_errors,
    bearing_errors_by_bin,
    radius_errors,
    radius_errors_of_all,
)
from benchmarks.figures.false_alerts import false_alert_rates
from benchmarks.figures.rates import overall_rates, rates_by_category, rates_by_phone, rates_by_scene
from benchmarks.results import RunData

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

FIGURES: dict[str, Callable[[RunData], Figure]] = {
    "fig16": overall_rates,
    "fig17": rates_by_scene,
    "fig19": rates_by_category,
    "fig20": rates_by_phone,
    **DISTANCE_FIGURES,
    "fig24": bearing_errors,
    "fig24_bins": bearing_errors_by_bin,
    "fig25": radius_errors,
    "fig25_all": radius_errors_of_all,
    "fig26": false_alert_rates,
}
"""Name to the function that computes what the figure shows."""


def draw_figures(run: RunData, names: Sequence[str] | None = None) -> list[Path]:
    """Write figures/<name>.{png,svg,csv} of a run; the csv is what is plotted, and the bytes repeat from run to run.

    Args:
        run: where it lies and what it holds.
        names: of `FIGURES`; None draws all.

    Returns:
        The files written.

    Raises:
        ValueError: an unknown name; the message lists those there are.
    """
    from benchmarks.figures.style import write_figure

    chosen = list(FIGURES) if names is None else list(names)
    unknown = [name for name in chosen if name not in FIGURES]
    if unknown:
        raise ValueError(f"figures must be among {list(FIGURES)}, got {unknown}")
    written = []
    for name in chosen:
        figure = FIGURES[name](run)
        written += write_figure(run.folder / "figures", figure, picture(figure))
    return written


def picture(figure: Figure) -> Canvas:
    """The figure drawn."""
    # matplotlib stays unimported until something is drawn, so that listing the names is quick
    from benchmarks.figures.bars import draw_bars
    from benchmarks.figures.curves import draw_curves
    from benchmarks.figures.style import house_style

    with house_style():
        return draw_bars(figure) if isinstance(figure, BarFigure) else draw_curves(figure)
