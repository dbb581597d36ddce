"""The paper's figures from a run: numbers first (`FIGURES`), then pictures (`draw_figures`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.figures.bench.alerts import alert_distances, alert_rate_by_miss
from benchmarks.figures.bench.cause_budget import cause_budget, cause_strata, cause_table
from benchmarks.figures.bench.det_curves import det
from benchmarks.figures.bench.error_budget import calibration, losses, range_budget
from benchmarks.figures.bench.extremes import extremes_axes, extremes_map, extremes_table
from benchmarks.figures.bench.fidelities import fidelity_pareto, fidelity_table, tolerance_table
from benchmarks.figures.bench.rate_tables import rates_by_point, rates_by_stratum
from benchmarks.figures.bench.sensitivity import alert_tornado, error_tornado, sides
from benchmarks.figures.bench.speed import speed_growth, speed_table
from benchmarks.figures.bench.sweeps import rates_by_band, rates_by_holding, rates_by_interference, sweep_curves
from benchmarks.figures.data import BarFigure, CurveFigure
from benchmarks.figures.paper.claims import claims_table
from benchmarks.figures.paper.diagrams import (
    bearing_drawing,
    collision_drawing,
    flow_drawing,
    sensing_drawing,
    street_drawings,
)
from benchmarks.figures.paper.energies import energy_figure, energy_table
from benchmarks.figures.paper.errors import DISTANCE_FIGURES, bearing_errors, bearing_errors_by_bin, radius_errors
from benchmarks.figures.paper.false_alerts import false_alert_rates
from benchmarks.figures.paper.rates import overall_rates, rates_by_category, rates_by_phone, rates_by_scene
from benchmarks.figures.paper.signals import (
    body_at_obstacle,
    body_at_phone,
    one_envelope,
    responses,
    several_envelopes,
    walking_envelopes,
)
from benchmarks.figures.paper.sizes import crest_against_distance, crest_shapes, radius_correlation
from benchmarks.figures.plots import DrawingFigure, Figure, PlotFigure
from benchmarks.plan.figure_names import FIGURE_RULES, known_figures
from benchmarks.runs.results import RunData
from benchmarks.runs.store import write_bytes_atomically
from benchmarks.runs.variants import first_point

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

Builder = Callable[[RunData], Figure]

_BUILDERS: dict[str, Builder] = {
    "fig1": sensing_drawing,
    "fig2": flow_drawing,
    "fig3": responses,
    "fig4": one_envelope,
    "fig5": walking_envelopes,
    "fig6": several_envelopes,
    "fig7": bearing_drawing,
    "fig8": body_at_obstacle,
    "fig9": body_at_phone,
    "fig10": crest_shapes,
    "fig11": radius_correlation,
    "fig12": crest_against_distance,
    "fig13": collision_drawing,
    **street_drawings(),
    "fig16": overall_rates,
    "fig17": rates_by_scene,
    "fig18": rates_by_band,
    "fig19": rates_by_category,
    "fig20": rates_by_phone,
    **DISTANCE_FIGURES,
    "fig24": bearing_errors,
    "fig24_bins": bearing_errors_by_bin,
    "fig25": radius_errors,
    "fig26": false_alert_rates,
    "fig27": energy_figure,
    "table1": energy_table,
    "miss_distance": alert_rate_by_miss,
    "alert_distance": alert_distances,
    "losses": losses,
    "det": det,
    "strata": rates_by_stratum,
    "points": rates_by_point,
    "error_budget": range_budget,
    "calibration": calibration,
    "extremes": extremes_map,
    "extremes_axes": extremes_axes,
    "extremes_table": extremes_table,
    "holding": rates_by_holding,
    "sides": sides,
    "interference": rates_by_interference,
    "tornado": error_tornado,
    "tornado_alerts": alert_tornado,
    "pareto": fidelity_pareto,
    "fidelity": fidelity_table,
    "speed_growth": speed_growth,
    "speed": speed_table,
    "tolerance": tolerance_table,
    "sweep": sweep_curves,
    "cause_budget": cause_budget,
    "cause_strata": cause_strata,
    "cause_table": cause_table,
    "claims": claims_table,
}


def _of_one_point(builder: Builder) -> Builder:
    """The builder, given the first point of a sweep alone: pooled points would be no measurement of anything."""

    def build(run: RunData) -> Figure:
        first, remark = first_point(run)
        figure = builder(first)
        return replace(figure, note=f"{remark} {figure.note}") if remark else figure

    return build


FIGURES: dict[str, Builder] = {
    name: _BUILDERS[name] if rule.compares_points else _of_one_point(_BUILDERS[name])
    for name, rule in FIGURE_RULES.items()
}
"""Name to the function that computes what the figure shows."""


def shown_figures(run: RunData) -> list[str]:
    """Names of the figures that a run shows: those its suite names, else all that do not need naming.

    Raises:
        ValueError: the suite names a figure that there is not.
    """
    named = run.manifest.get("figures") or ()
    if named:
        return list(known_figures(tuple(named)))
    held = {"", *(record["cell"]["kind"] for record in run.cells)}
    held |= {"sweep"} if any(record["cell"].get("variant") for record in run.cells) else set()
    return [name for name, rule in FIGURE_RULES.items() if rule.needs in held and not rule.named_only]


@dataclass(frozen=True)
class DrawnFigure:
    """A figure of a run, drawn once for all that show it, when the first of them does."""

    figure: Figure

    @cached_property
    def canvas(self) -> Canvas:
        """The picture."""
        return picture(self.figure)

    @cached_property
    def svg(self) -> bytes:
        """The picture as a file."""
        from benchmarks.figures.draw.style import picture_bytes

        return picture_bytes(self.canvas, "svg")


def figures_of(run: RunData) -> list[DrawnFigure]:
    """The figures that a run shows, empty ones too."""
    return [DrawnFigure(FIGURES[name](run)) for name in shown_figures(run)]


def draw_figures(run: RunData, names: Sequence[str] | None = None) -> list[Path]:
    """Write figures/<name>.{png,svg,csv} of a run; the csv is what is plotted, and the bytes repeat from run to run.

    Args:
        run: where it lies and what it holds.
        names: of `FIGURES`, drawn also where they are empty; None draws those shown that have data.

    Returns:
        The files written.

    Raises:
        ValueError: an unknown name; the message lists those there are.
    """
    if names is not None:
        return write_figures(run.folder, [DrawnFigure(FIGURES[name](run)) for name in known_figures(tuple(names))])
    return write_figures(run.folder, [drawn for drawn in figures_of(run) if not drawn.figure.empty])


def write_figures(folder: Path, figures: Sequence[DrawnFigure]) -> list[Path]:
    """Write figures/<name>.{png,svg,csv} of a run's folder; the paths."""
    from benchmarks.figures.draw.style import csv_text, picture_bytes

    written = []
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    for drawn in figures:
        contents = {"png": picture_bytes(drawn.canvas, "png"), "svg": drawn.svg, "csv": csv_text(drawn.figure).encode()}
        for kind, content in contents.items():
            written.append(folder / "figures" / f"{drawn.figure.name}.{kind}")
            write_bytes_atomically(written[-1], content)
    return written


def picture(figure: Figure) -> Canvas:
    """The figure drawn."""
    # matplotlib stays unimported until something is drawn, so that listing the names is quick
    from benchmarks.figures.draw.bars import draw_bars
    from benchmarks.figures.draw.curves import draw_curves
    from benchmarks.figures.draw.lines import draw_plots
    from benchmarks.figures.draw.shapes import draw_drawing
    from benchmarks.figures.draw.style import house_style
    from benchmarks.figures.draw.tables import draw_table

    with house_style():
        if isinstance(figure, BarFigure):
            return draw_bars(figure)
        if isinstance(figure, CurveFigure):
            return draw_curves(figure)
        if isinstance(figure, PlotFigure):
            return draw_plots(figure)
        return draw_drawing(figure) if isinstance(figure, DrawingFigure) else draw_table(figure)
