"""DET: misses against false alerts as the threshold on the stated probability moves, by the distance left."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike

from benchmarks.cells.detectors import parse_detector
from benchmarks.figures.measured import rate_text, sentences, walking_detectors
from benchmarks.figures.plots import Guide, Line, Panel, PlotFigure
from benchmarks.runs.results import RunData
from benchmarks.scoring.operating_points import TRUE_NEGATIVE_RATES, det_curve
from benchmarks.scoring.scores import (
    LEFT_M,
    Table,
    approach_table,
    left_in_words,
    stated_scores,
    swept,
    true_negative_rate,
    true_positive_rate,
)
from obstaclewatch.support.arrays import Floats

SHARES = (0.1, 1, 5, 10, 20, 50, 80, 90, 95, 99, 99.9)
"""Named on the axes, %: as many as do not touch."""


def det(run: RunData) -> PlotFigure:
    """On normal deviates, where chance is a straight line (Martin et al. 1997), one panel a distance left."""
    tables = {name: approach_table(run, name) for name in walking_detectors(run)}
    both = {name: table for name, table in tables.items() if table["collides"].any() and not table["collides"].all()}
    said = [
        f"{name}, {left_in_words(left_m)}, at TN {100 * tnr:g} %: TP {rate_text(point.true_positive)}"
        for name, table in both.items() for left_m in LEFT_M for tnr in TRUE_NEGATIVE_RATES
        if (point := swept(table, left_m, tnr)) is not None
    ]  # fmt: skip
    return PlotFigure(
        "det",
        "DET · Missed collisions against false alerts, by the distance left",
        tuple(_panel(both, left_m) for left_m in LEFT_M),
        sentences(said),
        "Lines: the threshold on the probability that a detector states moves; points: as it decides, also if run "
        "with other settings (the same colour). False alerts are counted over all of a walk. Rates of 0 and 1 are "
        "drawn half a walk inside. Dashed: chance; dotted: TN 90, 95 and 97 %.",
    )


def _panel(tables: dict[str, Table], left_m: float) -> Panel:
    lines = [line for name, table in tables.items() for line in _lines(name, table, left_m)]
    end = max([2.2, *(0.1 + float(np.abs(np.concatenate([line.x, line.y])).max()) for line in lines)])
    chance = Line("", "muted", np.array([-end, end]), np.array([end, -end]), "dashed")
    places = ((float(scipy.stats.norm.ppf(0.01 * share)), f"{share}") for share in SHARES)
    return Panel(
        left_in_words(left_m),
        "false alerts, % of walks without a collision",
        "collisions missed (%)",
        (*lines, chance) if lines else (),
        tuple(Guide("x", float(scipy.stats.norm.ppf(1.0 - tnr)), "") for tnr in TRUE_NEGATIVE_RATES),
        x_range=(-end, end),
        y_range=(-end, end),
        places=tuple(place for place in places if abs(place[0]) <= end),
    )


def _lines(name: str, table: Table, left_m: float) -> list[Line]:
    score, collides = stated_scores(table, left_m), table["collides"]
    hits, misses = int(collides.sum()), int((~collides).sum())
    tp, tn = true_positive_rate(table, left_m), true_negative_rate(table)
    family = parse_detector(name).cls
    lines = [Line(family, family, _deviate([1.0 - tn.value], misses), _deviate([1.0 - tp.value], hits), "points")]
    if not np.isnan(score).any():
        false, missed = det_curve(score[collides], score[~collides])
        lines.append(Line("", family, _deviate(false, misses), _deviate(missed, hits)))
    return lines


def _deviate(share: ArrayLike, count: int) -> Floats:
    return np.asarray(scipy.stats.norm.ppf(np.clip(share, 0.5 / count, 1.0 - 0.5 / count)), dtype=np.float64)
