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

FIGURE_SUBJECTS: dict[str, str] = {
    "fig1": "Figure 1: walker, phone, obstacle and the paths between them",
    "fig2": "Figure 2: stages of the paper's detector",
    "fig3": "Figure 3: response from speaker to microphone of every phone",
    "fig4": "Figure 4: envelope before one obstacle",
    "fig5": "Figure 5: envelopes while walking up to obstacles",
    "fig6": "Figure 6: envelope before several obstacles",
    "fig7": "Figure 7: triangle of obstacle and microphones",
    "fig8": "Figure 8: echo over the body after the obstacle's",
    "fig9": "Figure 9: the body's echo after the direct sound",
    "fig10": "Figure 10: crests of objects of different width",
    "fig11": "Figure 11: estimated against true radius",
    "fig12": "Figure 12: crest width against distance",
    "fig13": "Figure 13: walking angle against collision angle",
    "fig14": "Figure 14: the supermarket scene",
    "fig15": "Figure 15: the campus scene",
    "fig16": "Figure 16: TP and TN of every detector",
    "fig17": "Figure 17: TP and TN by scene",
    "fig19": "Figure 19: TP and TN by category of obstacle",
    "fig20": "Figure 20: TP and TN by phone",
    "fig21": "Figure 21: distance error of a standing phone, 1.5 m",
    "fig22": "Figure 22: distance error of a standing phone, 3 m",
    "fig23": "Figure 23: distance error of a standing phone, 5 m",
    "fig24": "Figure 24: bearing error, walking and standing",
    "fig24_bins": "Figure 24 by true bearing",
    "fig25": "Figure 25: radius error of people, signs and bins",
    "fig26": "Figure 26: false-alert rate with and without bearing and size",
    "fig27": "Figure 27: CPU time a beep, and the modelled charge",
    "table1": "Table 1: battery use, modelled and the paper's",
    "strata": "TP and TN by how hard the walks are",
    "det": "misses against false alerts as the threshold moves",
    "miss_distance": "share of walks alerted against miss distance",
    "alert_distance": "TP against the distance and time left to contact",
    "losses": "what became of every collision, stage by stage",
    "error_budget": "range error taken apart into its causes",
    "calibration": "claimed deviations against errors",
    "extremes": "numerical cases: error as a share of its limit",
    "extremes_axes": "the same over the parameter of each axis",
    "extremes_table": "the same in numbers, axis by axis",
    "fig18": "Figure 18: TP and TN by band of the beep",
    "holding": "TP and TN by how the phone is held",
    "sides": "share of obstacles whose side is right, by true bearing",
    "interference": "TP and TN with a second phone nearby",
    "tornado": "change of errors with each parameter",
    "tornado_alerts": "change of TP and TN with each parameter",
    "pareto": "error against cost of the simulator's levels",
    "fidelity": "cost and errors of every level and setting",
    "tolerance": "errors of every level, all pairs and by category",
    "speed_growth": "CPU time a pair against the size of the scene",
    "speed": "the same in numbers",
    "sweep": "TP, TN and range error over the points of a sweep",
    "points": "TP and TN at every point of a sweep",
    "cause_budget": "rates and errors with each cause of error removed",
    "cause_strata": "the same by category and scene",
    "cause_table": "the same in numbers",
    "claims": "the paper's claims beside what was measured",
}
"""Name -> what the figure shows, in a few words."""


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
