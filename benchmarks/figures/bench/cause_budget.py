"""Alerts and errors with one cause of error removed: pooled, by kind of obstacle and scene, and as a table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.figures.bench.causes import (
    Count,
    Effect,
    Floats,
    Point,
    Spread,
    bearing_deg,
    before_contact,
    detected,
    effect,
    false_alerts,
    groups,
    in_time,
    medians_of_shared_beeps,
    no_alert,
    points_of,
    range_cm,
    spread,
)
from benchmarks.figures.bench.error_budget import DETECTED_BEEPS
from benchmarks.figures.measured import judged_detectors, rules_text, significant
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import same_walks, variants
from obstaclewatch.support.words import counted

UPPER = 0.8
RATES: tuple[tuple[str, Count], ...] = (
    ("TP: alert with 1 m left (%)", in_time),
    ("TN: other walks without an alert (%)", no_alert),
    ("collisions detected (%)", detected),
)
ERRORS: tuple[tuple[str, Callable[[Point], Floats]], ...] = (
    ("bearing error (°)", bearing_deg),
    ("range error (cm)", range_cm),
)
LATE, HIGH = "alert before contact, however late", f"{100 * UPPER:.0f} % of the errors are below"
PAIRED = (
    "Dashed: as it is. Whiskers of rates: the paired 95 % interval of the change "
    "(exact, by the walks that differ), set on the rate as it is: one that crosses the dashed line is not "
    "significant. Those of the first row are exact, those of medians a bootstrap over walks."
)
DETECTED = f"Detected: an estimate in at least {DETECTED_BEEPS} beeps between 5 and 1 m."
SHOWN = (-3.0, 103.0)


def cause_budget(run: RunData) -> PlotFigure:
    """Rates and errors with each cause removed, over all walks."""
    measured = {name: points for name in judged_detectors(run) if (points := points_of(run, name))}
    panels = [_rate_panel(label, count, measured) for label, count in RATES]
    panels += [_error_panel(label, errors, measured) for label, errors in ERRORS]
    return PlotFigure(
        "cause_budget",
        "TP, TN and errors with one cause of error removed",
        tuple(panels),
        " ".join(_said(name, points) for name, points in measured.items()) or "No data.",
        f"{same_walks(variants(run))} {PAIRED} {DETECTED} {rules_text(run)}",
        height_in=_height(measured),
    )


def cause_strata(run: RunData) -> PlotFigure:
    """TP and TN with each cause removed, by kind of obstacle and by scene."""
    panels, said, detectors = [], [], judged_detectors(run)
    for detector in detectors:
        points = points_of(run, detector)
        for name, column, value in groups(run)[1:] if points else ():
            title = name if len(detectors) == 1 else f"{detector}, {name}"
            there = {each: point.of(column, value) for each, point in points.items()}
            effects_of = {label: _effects(count, there) for label, count in RATES[:2]}
            panels.append(_group_panel(title, effects_of))
            best = _most(effects_of[RATES[0][0]])
            said.append(f"{title}: TP {_change(best)}" if best else f"{title}: no collisions")
    return PlotFigure(
        "cause_strata",
        "TP and TN with one cause of error removed, by kind of obstacle and by scene",
        tuple(panels),
        f"Largest gain, {'; '.join(said)}." if said else "No data.",
        f"{same_walks(variants(run))} {PAIRED}",
        height_in=max([2.7, *(0.27 * len(panel.ticks) + 0.3 for panel in panels)]),
    )


def cause_table(run: RunData) -> TableFigure:
    """Rates, changes and errors of all walks with each cause removed."""
    detectors = judged_detectors(run)
    rows: list[tuple[str, ...]] = []
    for detector in detectors:
        points = points_of(run, detector)
        prefix = detector + "; " if len(detectors) > 1 else ""
        rows += [(prefix + point, *_cells(points, point)) for point in points]
    heads = (
        "removed", "TP (%)", "change of TP (points)", "however late (%)", "TN (%)", "change of TN (points)",
        "mean of both (%)", "false alerts (%)", "detected (%)", "bearing (°)", "same beeps (°)", "range (cm)",
    )  # fmt: skip
    return TableFigure(
        "cause_table",
        "TP, TN and errors with one cause of error removed",
        heads,
        tuple(rows),
        (2.4, 1.0, 1.75, 1.2, 1.0, 1.75, 1.3, 1.2, 0.8, 0.9, 1.2, 0.9),
        f"{counted(len(rows), 'row')}." if rows else "No data.",
        "Changes: on the same walks, with the exact 95 % interval; walks that are right now and were wrong as it is, "
        "those the other way round, exact McNemar; one in twenty is below p = 0.05 by chance. However late: collisions "
        "alerted before contact. Mean of both: of TP and TN, which a detector's threshold trades against each other. "
        f"False alerts: over all walks. {DETECTED} Errors: the median, then what "
        f"{100 * UPPER:.0f} % are below; same beeps: the median as it is, then now, over the beeps with an estimate in "
        f"both. {rules_text(run)}",
    )


def _effects(count: Count, points: dict[str, Point]) -> dict[str, Effect]:
    first = next(iter(points.values()))
    return {name: effect(count, first, point) for name, point in points.items()}


def _spreads(errors: Callable[[Point], Floats], points: dict[str, Point]) -> dict[str, Spread]:
    return {name: spread(errors(point), point, UPPER) for name, point in points.items()}


def _as_it_is(value: float, key: str) -> list[Guide]:
    """A guide at what the first point has; none where it has no such walk."""
    return [Guide("x", value, "", key)] if np.isfinite(value) else []


def _rate_panel(label: str, count: Count, measured: dict[str, dict[str, Point]]) -> Panel:
    lines, guides = [], []
    for k, (detector, points) in enumerate(measured.items()):
        effects = _effects(count, points)
        aside = 0.2 * (k - 0.5 * (len(measured) - 1))
        guides += _as_it_is(next(iter(effects.values())).value, detector)
        if count is in_time:
            late = np.array([each.value for each in _effects(before_contact, points).values()])
            lines.append(Line(LATE, detector, late, np.arange(len(late)) + aside, "ring"))
        lines.append(_effect_line(detector, detector, effects, aside))
    return Panel(
        "", label, "", tuple(lines), tuple(guides), ticks=_ticks(measured), flat=True, x_range=SHOWN, width_in=2.2
    )


def _error_panel(label: str, errors: Callable[[Point], Floats], measured: dict[str, dict[str, Point]]) -> Panel:
    lines, guides, most = [], [], 0.0
    for k, (detector, points) in enumerate(measured.items()):
        spreads = list(_spreads(errors, points).values())
        place = np.arange(len(spreads)) + 0.2 * (k - 0.5 * (len(measured) - 1))
        median, low, high, upper = (
            np.array([getattr(s, n) for s in spreads]) for n in ("median", "low", "high", "upper")
        )
        ends = (np.where(np.isfinite(end), end, median) for end in (low, high))
        lines += [Line(detector, detector, median, place, "points", *ends), Line(HIGH, "muted", upper, place, "ring")]
        guides += _as_it_is(float(median[0]), detector)
        most = max([most, *upper[np.isfinite(upper)], *high[np.isfinite(high)]])
    return Panel(
        "", label, "", tuple(lines), tuple(guides), ticks=_ticks(measured), flat=True,
        x_range=(-0.03 * most, 1.06 * most) if most > 0.0 else None, width_in=1.7,
    )  # fmt: skip


def _group_panel(title: str, effects_of: dict[str, dict[str, Effect]]) -> Panel:
    lines, guides, sizes = [], [], []
    for k, (label, effects) in enumerate(effects_of.items()):
        lines.append(_effect_line(label, str(2 * k), effects, 0.24 * (k - 0.5)))
        guides += _as_it_is(next(iter(effects.values())).value, str(2 * k))
        sizes.append(str(next(iter(effects.values())).n))
    return Panel(
        title, f"% of {' and '.join(sizes)} walks", "", tuple(lines), tuple(guides),
        ticks=tuple(next(iter(effects_of.values()))), flat=True, x_range=SHOWN, width_in=1.35,
    )  # fmt: skip


def _effect_line(label: str, key: str, effects: dict[str, Effect], aside: float) -> Line:
    value, low, high = (np.array([getattr(e, name) for e in effects.values()]) for name in ("value", "low", "high"))
    return Line(label, key, value, np.arange(len(value)) + aside, "points", low, high)


def _ticks(measured: dict[str, dict[str, Point]]) -> tuple[str, ...]:
    return tuple(next(iter(measured.values()), {}))


def _height(measured: dict[str, dict[str, Point]]) -> float:
    return max(2.7, 0.27 * len(_ticks(measured)) + 0.3)


def _said(detector: str, points: dict[str, Point]) -> str:
    """The causes whose removal changes TP or TN beyond chance, and how much alerts are late."""
    clauses = []
    for word, count in (("TP", in_time), ("TN", no_alert)):
        effects = _effects(count, points)
        base, *others = effects.items()
        told = [_change(other) for other in others if other[1].p < 0.05]
        clauses.append(f"{word} {base[1].value:.1f} % as it is, {', '.join(told) if told else 'no significant change'}")
    late = next(iter(_effects(before_contact, points).values())).value
    return (
        f"{detector}: {'; '.join(clauses)}. Before contact, however late, {late:.1f} % of the collisions are alerted."
    )


def _change(one: tuple[str, Effect]) -> str:
    name, found = one
    return f"{found.value - found.before:+.1f} points with '{name}' ({_p(found.p)})"


def _most(effects: dict[str, Effect]) -> tuple[str, Effect] | None:
    known = [(name, one) for name, one in effects.items() if np.isfinite(one.value)]
    return max(known[1:], key=lambda pair: pair[1].value - pair[1].before, default=None)


def _cells(points: dict[str, Point], name: str) -> tuple[str, ...]:
    first, now = next(iter(points.values())), points[name]
    tp, late, tn, false, seen = (
        effect(count, first, now) for count in (in_time, before_contact, no_alert, false_alerts, detected)
    )
    errors = [spread(of(now), now, UPPER) for _, of in ERRORS]
    shared = "–" if now is first else ", ".join(significant(each) for each in medians_of_shared_beeps(first, now))
    return (
        _rate(tp), _pairs(tp, now is first), _percent(late), _rate(tn), _pairs(tn, now is first),
        _number(0.5 * (tp.value + tn.value)), _percent(false), _percent(seen), _both(errors[0]), shared,
        _both(errors[1]),
    )  # fmt: skip


def _rate(one: Effect) -> str:
    return f"{_percent(one)} of {one.n}"


def _percent(one: Effect) -> str:
    return _number(one.value)


def _number(value: float) -> str:
    return f"{value:.1f}" if np.isfinite(value) else "–"


def _pairs(one: Effect, first: bool) -> str:
    """ "+8.8 (+2.1 to +13.0) +13 -2, p = 0.01": the change with its interval, and the walks that differ."""
    if first or not one.n:
        return "–"
    by, low, high = (f"{round(each - one.before, 1) + 0.0:+.1f}" for each in (one.value, one.low, one.high))
    pairs = f"+{one.gained} -{one.lost}, {_p(one.p)}".replace(" ", "\N{NO-BREAK SPACE}")
    return f"{by} ({low} to {high}) {pairs}"


def _p(p: float) -> str:
    return "p < 0.001" if p < 0.001 else f"p = {p:.2g}"


def _both(one: Spread) -> str:
    return f"{significant(one.median)}, {significant(one.upper)}"
