"""When alerts come, and to whom: against miss distance, and before contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.cells.spec import Scoring, counts_as
from benchmarks.figures.measured import binned_rates, detectors_of, percents
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import LEFT_M, approach_table, chosen, rate, true_positive_rate
from benchmarks.scoring.statistics import Rate
from obstaclewatch.support.arrays import Floats

MISS_BINS_M = (0.0, 1e-6, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5)
"""Distances in plan between obstacle and line of walk; the first bin holds those whose line meets the obstacle."""
AT_LEAST = np.linspace(0.0, 5.0, 101)
DANGER_M = 3.0
"""Within which the paper raises alerts (section 3.2)."""


def plain_detectors(run: RunData) -> list[str]:
    """Detectors without constants in brackets, unless there are no others."""
    names = detectors_of(run)
    return [name for name in names if "(" not in name] or names


def alert_rate_by_miss(run: RunData) -> PlotFigure:
    """The share of walks with any alert against how far the walk's line passes the obstacle."""
    lines: list[Line] = []
    said = []
    for detector in plain_detectors(run):
        table = approach_table(run, detector)
        aside = 0.015 * len(lines)
        line = binned_rates(detector, MISS_BINS_M, table["miss_distance_m"], table["alert"], aside)
        lines.append(line)
        if np.isfinite(line.y).any():
            far = rate(table["alert"][table["miss_distance_m"] > 0.5])
            if far.n:
                said.append(
                    f"{detector} alerts on {100 * far.value:.0f} % of the {far.n} walks that pass more than half a "
                    "metre aside."
                )
    panel = Panel(
        "",
        "miss distance of the walk's line (m)",
        "walks with an alert (%)",
        tuple(lines),
        (Guide("x", _half_width_m(run), "half a walker"),),
        x_range=(-0.1, 0.1 + max([1.0, *(float(line.x.max()) for line in lines if len(line.x))])),
        y_range=(0.0, 103.0),
        width_in=5.6,
    )
    return PlotFigure(
        "miss_distance",
        "Alert rate against miss distance",
        (panel,),
        " ".join(said) or "No data.",
        "Whiskers: exact 95 % intervals; points of one bin stand side by side. At 0 the line meets the obstacle. An "
        "ideal detector falls from 100 to 0 % at "
        "half the walker's width.",
    )


def alert_distances(run: RunData) -> PlotFigure:
    """TP against the distance and the time that must remain to contact."""
    panels, said = [], []
    for column, title, unit in (
        ("alert_distance_m", "distance from alert to contact (m)", "m"),
        ("alert_lead_s", "time from alert to contact (s)", "s"),
    ):
        lines: list[Line] = []
        for k, detector in enumerate(plain_detectors(run)):
            table = approach_table(run, detector)
            left = chosen(table, table["collides"])[column]
            lines.append(Line(detector, detector, AT_LEAST, 100.0 * _shares(left, AT_LEAST)))
            if unit == "m" and len(left):
                rates = [true_positive_rate(table, left_m) for left_m in LEFT_M]
                lines.append(_margin_line(detector, rates, 0.03 * k))
                told = ", ".join(f"{100 * r.value:.1f} % with {m:g} m" for m, r in zip(LEFT_M, rates, strict=True))
                said.append(f"{detector} alerts on {told} or more left, of {len(left)} collisions.")
        guides = (Guide("x", DANGER_M, "danger distance"),) if unit == "m" else ()
        panels.append(
            Panel(
                "",
                f"at least this {title}",
                "collisions alerted (%)",
                tuple(lines),
                guides,
                x_range=(0.0 if unit == "s" else -0.06, 5.0),
                y_range=(0.0, 103.0),
            )
        )
    return PlotFigure(
        "alert_distance",
        "TP against the distance and the time that must remain to contact",
        tuple(panels),
        " ".join(said) or "No data.",
        "At 0: all collisions alerted before contact, the paper's rule and that of every other figure. Whiskers: exact "
        "95 % intervals.",
    )


def _half_width_m(run: RunData) -> float:
    """Half the width of the walker that the run's walks are judged by; the usual one where it has none."""
    rules = [cell["cell"]["scoring"] for cell in run.cells if counts_as(cell["cell"], "approach")]
    return (Scoring.model_validate(rules[0]) if rules else Scoring()).half_width_m


def _shares(left: Floats, at_least: Floats) -> Floats:
    """Share of collisions with at least so much left at the alert; NaN without collisions. No alert leaves nothing."""
    if len(left) == 0:
        return np.full(len(at_least), np.nan)
    return np.mean(np.nan_to_num(left, nan=-1.0) >= at_least[:, None], axis=1)


def _margin_line(detector: str, rates: Sequence[Rate], shift_m: float) -> Line:
    value, low, high = np.array([percents(each) for each in rates]).T
    return Line("", detector, np.array(LEFT_M) + shift_m, value, "points", low, high)
