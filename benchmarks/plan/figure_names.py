"""The figures by name: which runs show them. How each is made is the business of `benchmarks.figures`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from benchmarks.cells.spec import did_you_mean


@dataclass(frozen=True)
class FigureRule:
    """When a run shows a figure, and over what.

    Attributes:
        needs: kind of cells without which the figure is left out, or "sweep" for points of one; empty for no such rule.
        named_only: shown only for suites that name it: other runs have data for it, but not of the kind it is about.
        compares_points: made of all points of a sweep; every other figure of the first point alone.
    """

    needs: Literal["", "signal", "numerics", "fidelity", "speed", "sweep"] = ""
    named_only: bool = False
    compares_points: bool = False


_ALWAYS, _NAMED, _SIGNAL = FigureRule(), FigureRule(named_only=True), FigureRule(needs="signal")
_NUMERICS = FigureRule(needs="numerics")
_POINTS, _NAMED_POINTS = FigureRule(compares_points=True), FigureRule(named_only=True, compares_points=True)

FIGURE_RULES: dict[str, FigureRule] = {
    **dict.fromkeys([f"fig{number}" for number in range(1, 11)], _SIGNAL),
    "fig11": _ALWAYS,
    **dict.fromkeys(["fig12", "fig13", "fig14", "fig15"], _SIGNAL),
    **dict.fromkeys(["fig16", "fig17", "fig19", "fig20", "fig21", "fig22", "fig23"], _ALWAYS),
    **dict.fromkeys(["fig24", "fig24_bins", "fig25", "fig26"], _ALWAYS),
    **dict.fromkeys(["fig27", "table1"], _NAMED),
    **dict.fromkeys(["strata", "det", "miss_distance", "alert_distance", "losses"], _ALWAYS),
    **dict.fromkeys(["error_budget", "calibration"], _ALWAYS),
    **dict.fromkeys(["extremes", "extremes_axes", "extremes_table"], _NUMERICS),
    **dict.fromkeys(["fig18", "holding", "sides", "interference", "tornado", "tornado_alerts"], _NAMED_POINTS),
    **dict.fromkeys(["pareto", "fidelity"], FigureRule(needs="fidelity", compares_points=True)),
    "tolerance": FigureRule(needs="fidelity", named_only=True, compares_points=True),
    **dict.fromkeys(["speed_growth", "speed"], FigureRule(needs="speed")),
    **dict.fromkeys(["sweep", "points"], FigureRule(needs="sweep", compares_points=True)),
    **dict.fromkeys(["cause_budget", "cause_strata", "cause_table"], _NAMED_POINTS),
    "claims": _POINTS,
}  # fmt: skip
"""Name -> rule, in the order in which they are shown."""


def known_figures(names: tuple[str, ...]) -> tuple[str, ...]:
    """The names as they are.

    Raises:
        ValueError: a name that no figure has.
    """
    unknown = [name for name in names if name not in FIGURE_RULES]
    if unknown:
        near = did_you_mean(unknown[0], FIGURE_RULES)
        raise ValueError(f"figures must be among {list(FIGURE_RULES)}, got {unknown}{near}")
    return names
