"""False alerts with and without bearing and size (Figure 26)."""

from __future__ import annotations

from benchmarks.figures.data import Bar, BarFigure, BarPanel
from benchmarks.figures.measured import BASELINE, INTERVALS, detectors_of, rate_against, rate_bar, rate_text, rules_text
from benchmarks.runs.results import RunData
from benchmarks.scoring.paper_values import FALSE_ALERTS, PaperValue
from benchmarks.scoring.scores import (
    PAPER_RECIPE,
    Table,
    approach_table,
    false_alerts_over_all,
    false_alerts_over_negatives,
    recipe_of,
)

OVER_ALL, OVER_NEGATIVES = "of all walks", "of walks without a collision (1 - TN)"


def false_alert_rates(run: RunData) -> BarFigure:
    """Figure 26: the baseline that knows only distance, then the detectors that know bearing and size."""
    names = sorted(detectors_of(run) or list(FALSE_ALERTS), key=lambda name: name != BASELINE)
    tables = {name: approach_table(run, name) for name in names}
    paper = {name: _paper(name) for name in names if recipe_of(run) in (PAPER_RECIPE, "")}
    bars = [bar for name in names for bar in _pair(name, tables[name], paper.get(name))]
    return BarFigure(
        name="fig26",
        title="Fig. 26 · False-alert rate, with and without bearing and size",
        y_label="false alerts (%)",
        unit="%",
        panels=(BarPanel("", tuple(bars)),),
        reading=" ".join(_sentence(name, tables[name], paper.get(name)) for name in names),
        note=f"{INTERVALS} The paper does not state the denominator of its 3.5 and 32.1 %; over all walks is the one "
        f'that agrees with its TN. Its baseline also asks a camera, which ours replaces by "ahead". {rules_text(run)}',
    )


def _paper(name: str) -> PaperValue:
    """What the paper measured of the same kind of detector: with distance only, or with bearing and size."""
    return FALSE_ALERTS[BASELINE if name == BASELINE else "PaperDetector"]


def _pair(name: str, table: Table, paper: PaperValue | None) -> list[Bar]:
    return [
        rate_bar(name, OVER_ALL, false_alerts_over_all(table), paper),
        rate_bar(name, OVER_NEGATIVES, false_alerts_over_negatives(table)),
    ]


def _sentence(name: str, table: Table, paper: PaperValue | None) -> str:
    over_all, over_negatives = false_alerts_over_all(table), false_alerts_over_negatives(table)
    against = f", {rate_against(over_all, paper, higher_is_better=False)}" if paper else ""
    return (
        f"{name} alerts falsely on {rate_text(over_all)} of all walks{against}; "
        f"of those without a collision it is {rate_text(over_negatives)}."
    )
