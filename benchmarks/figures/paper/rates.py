"""True positives and true negatives: overall, by scene, by category, by phone (Figures 16, 17, 19 and 20)."""

from __future__ import annotations

from collections.abc import Mapping

from benchmarks.cells.spec import counts_as
from benchmarks.figures.data import BarFigure, BarPanel
from benchmarks.figures.measured import (
    BASELINE,
    INTERVALS,
    NO_DATA,
    TOP,
    extreme,
    judged_detectors,
    rate_against,
    rate_pair,
    rate_text,
    rules_text,
    strata,
    walking_detectors,
)
from benchmarks.runs.results import RunData
from benchmarks.scoring import paper_values
from benchmarks.scoring.paper_values import RatePair
from benchmarks.scoring.scores import (
    PAPER_RECIPE,
    Table,
    approach_table,
    recipe_of,
    rows_where,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate
from scenes.streets.approaches import DATA_COLLECTION

NO_PAPER = "The paper shows this figure as bars without numbers, so none are drawn."


def overall_rates(run: RunData) -> BarFigure:
    """Figure 16: every detector over all walks."""
    names = walking_detectors(run) or ["PaperDetector"]
    tables = {name: approach_table(run, name) for name in names}
    known = {
        name: None if name == BASELINE else held_against(run, {"": paper_values.OVERALL}).get("") for name in names
    }
    bars = [bar for name in names for bar in rate_pair(name, tables[name], known[name])]
    mean = paper_values.case_weighted_mean()
    return BarFigure(
        name="fig16",
        title="Fig. 16 · TP and TN over all walks",
        y_label="share of walks (%)",
        unit="%",
        panels=(BarPanel("", tuple(bars)),),
        reading=" ".join(_sentence(name, tables[name], known[name]) for name in names),
        note=f'{INTERVALS} The paper prints "over 93 %" and "over 92 %"; the case-weighted mean of its own scenes is '
        f"{mean.true_positive.display:.1f} and {mean.true_negative.display:.1f} %. {rules_text(run)}",
        top=TOP,
    )


def rates_by_scene(run: RunData) -> BarFigure:
    """Figure 17: by scene."""
    groups = strata(run, "scene") or list(paper_values.BY_SCENE)
    note = f"{INTERVALS} The paper's walks, detector settings and share of collisions are not ours. {rules_text(run)}"
    known = held_against(run, paper_values.BY_SCENE)
    return _by(run, "fig17", "scene", groups, "Fig. 17 · TP and TN by scene", known, note)


def rates_by_category(run: RunData) -> BarFigure:
    """Figure 19: by category of obstacle, over both scenes."""
    groups = strata(run, "category") or list(DATA_COLLECTION["supermarket"].cases)
    note = f"{INTERVALS} {NO_PAPER}"
    return _by(run, "fig19", "category", groups, "Fig. 19 · TP and TN by kind of obstacle", {}, note)


def rates_by_phone(run: RunData) -> BarFigure:
    """Figure 20: by phone. Phones see different scenes, which the note says."""
    groups = strata(run, "phone") or [row.phone for row in paper_values.ENERGY]
    where = [f"{phone} in {' and '.join(_scenes_of(run, phone))}" for phone in groups if _scenes_of(run, phone)]
    apart = f"Phones walk in different scenes ({'; '.join(where)}), as in the paper. " if where else ""
    note = f"{INTERVALS} {apart}{NO_PAPER}"
    return _by(run, "fig20", "phone", groups, "Fig. 20 · TP and TN by phone", {}, note)


def _by(
    run: RunData, name: str, column: str, groups: list[str], title: str, paper: Mapping[str, RatePair], note: str
) -> BarFigure:
    detectors = [name for name in judged_detectors(run) if name in (walking_detectors(run) or [name])]
    tables = {detector: approach_table(run, detector) for detector in detectors}
    panels = []
    for detector in detectors:
        known = {} if detector == BASELINE else paper
        bars = [b for g in groups for b in rate_pair(g, rows_where(tables[detector], **{column: g}), known.get(g))]
        panels.append(BarPanel(detector, tuple(bars)))
    readings = [_group_sentence(d, column, groups, tables[d], paper) for d in detectors]
    return BarFigure(name, title, "share of walks (%)", "%", tuple(panels), " ".join(readings), note, TOP)


def held_against(run: RunData, paper: Mapping[str, RatePair]) -> Mapping[str, RatePair]:
    """The paper's rates, if the run's walks are of the recipe that they are about."""
    return paper if recipe_of(run) == PAPER_RECIPE else {}


def _scenes_of(run: RunData, phone: str) -> list[str]:
    cells = (record["cell"] for record in run.cells)
    return sorted({cell["scene"] for cell in cells if counts_as(cell, "approach") and cell["phone"] == phone})


def _sentence(detector: str, table: Table, paper: RatePair | None) -> str:
    tp, tn = true_positive_rate(table), true_negative_rate(table)
    clauses = [rate_text(tp), rate_text(tn)]
    if paper is not None:
        clauses[0] += f", {rate_against(tp, paper.true_positive)}"
        clauses[1] += f", {rate_against(tn, paper.true_negative)}"
    return f"{detector}: TP {clauses[0]}; TN {clauses[1]}."


def _group_sentence(detector: str, column: str, groups: list[str], table: Table, paper: Mapping[str, RatePair]) -> str:
    tables = {group: rows_where(table, **{column: group}) for group in groups}
    if paper and detector != BASELINE:
        return " ".join(_sentence(f"{detector} in {g}", tables[g], paper.get(g)) for g in groups)
    tp = {group: true_positive_rate(t) for group, t in tables.items()}
    tn = {group: true_negative_rate(t) for group, t in tables.items()}
    return f"{detector}: {_span('TP', column, tp)}; {_span('TN', column, tn)}."


def _span(label: str, column: str, groups: dict[str, Rate]) -> str:
    least, most = extreme(groups, min), extreme(groups, max)
    if not least:
        return f"{label} {NO_DATA}"
    if groups[least].value == groups[most].value:
        return f"{label} is {100.0 * groups[least].value:.1f} % for every {column}"
    low, high = rate_text(groups[least]), rate_text(groups[most])
    return f"{label} is lowest for {least}, {low}, and highest for {most}, {high}"
