"""Rates by what decides how hard a walk is, and by what is assumed of it, as tables."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.figures.bench.alerts import plain_detectors
from benchmarks.figures.measured import percents, rules_text, walking_detectors
from benchmarks.figures.plots import TableFigure
from benchmarks.plan.unknowns import DRAWN, UNKNOWNS
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import same_walks, variants
from benchmarks.scoring.scores import (
    LEFT_M,
    Table,
    approach_table,
    chosen,
    swept,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate
from benchmarks.scoring.strata import strata
from obstaclewatch.support.words import counted

COLUMNS = ("detector", *(f"TP, {m:g} m left" if m else "TP before contact" for m in LEFT_M), "TN", "TP at TN 97 %")
NONE = "–"
STRICT = 0.97
WIDTHS = (2.15, 1.4, 1.2, 1.2, 1.2, 1.2, 1.2)


def rates_by_stratum(run: RunData) -> TableFigure:
    """TP at every distance left, TN, and TP before contact where the threshold leaves TN 97 %, of each stratum."""
    tables = {name: approach_table(run, name) for name in plain_detectors(run)}
    cut = {name: strata(table) for name, table in tables.items()}
    names = dict.fromkeys(stratum for found in cut.values() for stratum in found)
    rows = [_row(s, d, chosen(tables[d], cut[d][s])) for s in names for d in tables if s in cut[d]]
    note = (
        "In brackets: exact 95 % interval, %. Overlap: how far the target reaches into the walker's half width, seen "
        "from the line of the phone. Index: 2E/N0 of the target's strongest echo at microphone 0 between 2 and 1 m, "
        f"from the simulated paths and the phone's noise. {rules_text(run)}"
    )
    return _figure("strata", "TP and TN by how hard the walks are", "walks", rows, note)


def rates_by_point(run: RunData) -> TableFigure:
    """TP and TN at every point of a sweep, or as assumed and with the unknowns drawn."""
    parts = {name: part for name, part in variants(run).items() if walking_detectors(part)}
    rows = [_row(p, d, approach_table(part, d)) for p, part in parts.items() for d in plain_detectors(part)]
    note = f"{same_walks(parts)} In brackets: exact 95 % interval, %."
    if DRAWN in parts:
        drawn = "; ".join(f"{u.name} {u.low_db:+g} to {u.high_db:+g} dB ({u.source})" for u in UNKNOWNS)
        note += (
            f" Drawn evenly for every walk, added to what is assumed: {drawn}. So the rate is a mean over what phones "
        )
        note += "and people may be, and its interval that of the mean: one phone's rate may lie outside."
    return _figure("points", "TP and TN at the points of the run", "point", rows if len(parts) > 1 else [], note)


def _figure(name: str, title: str, first: str, rows: Sequence[tuple[str, ...]], note: str) -> TableFigure:
    kept = tuple(row for row in rows if set(row[2:]) != {NONE})
    reading = f"{counted(len(kept), 'row')}." if kept else "No data."
    return TableFigure(name, title, (first, *COLUMNS), kept, WIDTHS, reading, note)


def _row(first: str, detector: str, table: Table) -> tuple[str, ...]:
    rates = (*(true_positive_rate(table, left_m) for left_m in LEFT_M), true_negative_rate(table))
    strict = swept(table, 0.0, STRICT)
    return first, detector, *map(_shown, rates), NONE if strict is None else _shown(strict.true_positive)


def _shown(found: Rate) -> str:
    """ "84.3 (77-90), 108/128"."""
    if not found.n:
        return NONE
    value, low, high = percents(found)
    return f"{value:.1f} ({low:.0f}–{high:.0f}), {found.k}/{found.n}"
