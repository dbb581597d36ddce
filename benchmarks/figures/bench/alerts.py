"""When alerts come, and to whom: against miss distance, before contact, and as the margin grows (ROC and DET)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from benchmarks.cells.detectors import parse_detector
from benchmarks.cells.spec import Scoring, counts_as
from benchmarks.figures.measured import binned_rates, detectors_of, percents
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import approach_table, chosen, rate, true_negative_rate, true_positive_rate
from benchmarks.scoring.statistics import Rate
from obstaclewatch.support.arrays import Floats

MISS_BINS_M = (0.0, 1e-6, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5)
"""Distances in plan between obstacle and line of walk; the first bin holds those whose line meets the obstacle."""
AT_LEAST = np.linspace(0.0, 5.0, 101)
MARGINS_M = (0.0, 1.0, 2.0, 3.0)
"""Distances to contact at which TP is given with an interval: 1 m is the rule, 3 m the paper's danger distance."""
Families = dict[str, list[tuple[str, float, float, int, int]]]
"""Class of detectors -> of each its name, false and true alerts, and walks without and with a collision."""
DEVIATE_NOTE = "Dashed: chance. Rates of 0 and 1 are drawn half a walk inside."


def scoring_of(run: RunData) -> Scoring:
    """The rules that the run's walks are judged by; as they are by default where it has none."""
    rules = [cell["cell"]["scoring"] for cell in run.cells if counts_as(cell["cell"], "approach")]
    return Scoring.model_validate(rules[0]) if rules else Scoring()


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
        aside = 0.015 * (len(lines) - 1)
        line = binned_rates(detector, MISS_BINS_M, table["miss_distance_m"], table["alert"], aside)
        lines.append(line)
        if np.isfinite(line.y).any():
            far = rate(table["alert"][table["miss_distance_m"] > 0.5])
            said.append(
                f"{detector} alerts on {100 * far.value:.0f} % of the walks that miss by more than half a metre."
            )
    panel = Panel(
        "",
        "miss distance of the walk's line, m",
        "walks with an alert, %",
        tuple(lines),
        (Guide("x", scoring_of(run).half_width_m, "half a walker"),),
        x_range=(-0.1, 2.1),
        y_range=(0.0, 103.0),
        width_in=5.6,
    )
    return PlotFigure(
        "miss_distance",
        "Alert rate against miss distance",
        (panel,),
        " ".join(said) or "No data.",
        "Whiskers: 95 % Wilson intervals. At 0 the line meets the obstacle. An ideal detector falls from 100 to 0 % at "
        "half the walker's width.",
    )


def alert_distances(run: RunData) -> PlotFigure:
    """TP against the distance and the time that must remain to contact."""
    panels, said = [], []
    margin_m, within_m = scoring_of(run).alert_margin_m, scoring_of(run).alert_within_m
    for column, title, unit in (
        ("alert_distance_m", "distance from alert to contact, m", "m"),
        ("alert_lead_s", "time from alert to contact, s", "s"),
    ):
        lines: list[Line] = []
        for k, detector in enumerate(plain_detectors(run)):
            table = approach_table(run, detector)
            left = chosen(table, table["collides"])[column]
            lines.append(Line(detector, detector, AT_LEAST, 100.0 * _shares(left, AT_LEAST)))
            if unit == "m" and len(left):
                rates = [rate(left >= margin) for margin in MARGINS_M]
                lines.append(_margin_line(detector, rates, 0.03 * k))
                percents = ", ".join(
                    f"{100 * found.value:.1f} % with {m:g} m" for m, found in zip(MARGINS_M, rates, strict=True)
                )
                said.append(f"{detector} alerts on {percents} or more left, of {len(left)} collisions.")
        guides = (Guide("x", margin_m, "in time"), Guide("x", within_m, "danger distance")) if unit == "m" else ()
        panels.append(
            Panel(
                "",
                f"at least this {title}",
                "collisions alerted, %",
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
        f"At 0: all collisions alerted before contact. The rule of every other figure: {margin_m:g} m. The "
        f"paper's rule asks for alerts within {within_m:g} m. Whiskers: 95 % Wilson intervals.",
    )


def roc(run: RunData) -> PlotFigure:
    """True alerts against false ones for every detector, those that differ in constants alone joined by a line."""
    return _operating_points(run, "roc", "ROC · TP against the false-alert rate", False)


def det(run: RunData) -> PlotFigure:
    """Misses against false alerts on normal deviates, where chance is a straight line (Martin et al. 1997)."""
    return _operating_points(run, "det", "DET · Missed collisions against the false-alert rate", True)


def _shares(left: Floats, at_least: Floats) -> Floats:
    """Share of collisions with at least so much left at the alert; NaN without collisions. No alert leaves nothing."""
    if len(left) == 0:
        return np.full(len(at_least), np.nan)
    return np.mean(np.nan_to_num(left, nan=-1.0) >= at_least[:, None], axis=1)


def _margin_line(detector: str, rates: Sequence[Rate], shift_m: float) -> Line:
    value, low, high = np.array([percents(each) for each in rates]).T
    return Line("", detector, np.array(MARGINS_M) + shift_m, value, "points", low, high)


def _operating_points(run: RunData, name: str, title: str, deviates: bool) -> PlotFigure:
    families: Families = {}
    for detector in detectors_of(run):
        table = approach_table(run, detector)
        tp, tn = true_positive_rate(table), true_negative_rate(table)
        if tp.n and tn.n:
            point = (detector, 1.0 - tn.value, tp.value, tn.n, tp.n)
            families.setdefault(parse_detector(detector).cls, []).append(point)
    lines: list[Line] = []
    for family, points in families.items():
        points.sort(key=lambda point: (point[1], point[2]))
        false, true = (np.array([point[k] for point in points]) for k in (1, 2))
        if deviates:
            false = _deviate(false, np.array([point[3] for point in points]))
            true = _deviate(1.0 - true, np.array([point[4] for point in points]))
        else:
            false, true = 100.0 * false, 100.0 * true
        lines.append(Line(family, family, false, true, "points"))
        if len(points) > 1 and len(_constants([point[0] for point in points])) == 1:
            lines.append(Line("", family, false, true))
    panel = _deviate_panel(lines) if deviates else _roc_panel(lines)
    best = max((p for points in families.values() for p in points), key=lambda p: p[2] - p[1], default=None)
    reading = (
        "No data."
        if best is None
        else (
            f"The largest difference of true and false alerts is {best[0]}'s: {100 * best[2]:.1f} % in time, "
            f"{100 * best[1]:.1f} % false."
        )
    )
    return PlotFigure(
        name,
        title,
        (panel,),
        reading,
        f"{_swept_note(families)}{DEVIATE_NOTE if deviates else 'Dashed: chance.'}",
        height_in=3.6,
    )


def _constants(detectors: Sequence[str]) -> dict[str, list[Any]]:
    """The constants in brackets that some of these detectors have, and the values they take."""
    found: dict[str, list[Any]] = {}
    for detector in detectors:
        for name, value in parse_detector(detector).arguments.items():
            found.setdefault(name, []).append(value)
    return found


def _swept_note(families: Families) -> str:
    """What the points of one colour differ in, as the run's own detectors have it; empty where each stands alone."""
    told = []
    for family, points in families.items():
        for name, values in _constants([point[0] for point in points]).items() if len(points) > 1 else ():
            told.append(f"{family}'s {name}: {', '.join(str(value) for value in values)}")
    return f"Points of one colour differ in constants ({'; '.join(told)}). " if told else ""


def _roc_panel(lines: list[Line]) -> Panel:
    chance = Line("", "muted", np.array([0.0, 100.0]), np.array([0.0, 100.0]), "dashed")
    return Panel(
        "",
        "false alerts, % of walks without a collision",
        "alerts in time, % of collisions",
        (*lines, chance) if lines else (),
        x_range=(-2.0, 102.0),
        y_range=(-2.0, 102.0),
        width_in=5.6,
    )


def _deviate_panel(lines: list[Line]) -> Panel:
    shares = (0.1, 0.5, 1, 2, 5, 10, 20, 30, 50, 70, 80, 90, 95, 98, 99, 99.5, 99.9)
    drawn = np.abs(np.concatenate([np.zeros(1), *(values for line in lines for values in (line.x, line.y))]))
    end = max(2.2, 0.1 + float(drawn.max()))
    places = tuple((float(stats.norm.ppf(0.01 * share)), f"{share}") for share in shares)
    chance = Line("", "muted", np.array([-end, end]), np.array([end, -end]), "dashed")
    return Panel(
        "",
        "false alerts, % of walks without a collision",
        "collisions missed, %",
        (*lines, chance) if lines else (),
        x_range=(-max(end, 2.5), end),
        y_range=(-max(end, 2.5), end),
        places=tuple(place for place in places if -max(end, 2.5) <= place[0] <= end),
        width_in=5.6,
    )


def _deviate(share: Floats, count: NDArray[np.int_]) -> Floats:
    inside = np.clip(share, 0.5 / count, 1.0 - 0.5 / count)
    return np.asarray(stats.norm.ppf(inside), dtype=np.float64)
