"""The walks behind the rates: strata, worst cases with the command that repeats each, and failures."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.cells.spec import counts_as
from benchmarks.figures.measured import detectors_of, judged_detectors, strata
from benchmarks.report.verdict import Measured, rate_measured
from benchmarks.runs.manifest import options_in
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import Table, approach_table, chosen, rows_where, true_negative_rate, true_positive_rate
from obstaclewatch.support.arrays import Ints, Strings

UNKNOWN = "unknown"
MOST_CASES = 10


@dataclass(frozen=True)
class Stratum:
    """One line of the table: a scene, category and phone, and (TP, TN) per detector."""

    scene: str
    category: str
    phone: str
    rates: tuple[tuple[Measured, Measured], ...]


@dataclass(frozen=True)
class Case:
    """One walk that went wrong, in words, and how to repeat it alone."""

    label: str
    phone: str
    what: str
    command: str


@dataclass(frozen=True)
class WorstCases:
    """The worst of one kind for one detector; `total` counts all of them."""

    detector: str
    title: str
    total: int
    cases: tuple[Case, ...]


def strata_table(run: RunData) -> list[Stratum]:
    """Scenes by categories by phones that the plan holds."""
    names = detectors_of(run)
    tables = {name: approach_table(run, name) for name in names}
    planned = {
        (c["cell"]["scene"], c["cell"]["category"], c["cell"]["phone"])
        for c in run.cells
        if counts_as(c["cell"], "approach")
    }
    columns = ("scene", "category", "phone")
    every = product(*(strata(run, column) for column in columns))
    return [
        Stratum(
            *key, tuple(_both_rates(rows_where(tables[name], **dict(zip(columns, key, strict=True)))) for name in names)
        )
        for key in every
        if key in planned
    ]


def worst_cases(run: RunData, most: int = MOST_CASES) -> list[WorstCases]:
    """Missed collisions and false alerts of every detector but the baseline."""
    found = []
    for name in judged_detectors(run):
        table = approach_table(run, name)
        found += [_missed(run, name, table, most), _false(run, name, table, most)]
    return found


def rerun_command(run: RunData, label: str) -> str:
    """The command that computes one walk again, alone, with the run's own settings."""
    manifest = run.manifest
    parts = ["obstaclewatch", "run", _suite_of(run), "--tier", str(manifest.get("tier", UNKNOWN))]
    seed = ["--seed", str(manifest.get("seed", UNKNOWN))]
    argv = manifest.get("argv") or []
    trusted = ["--allow-code"] if "--allow-code" in argv else []
    return shlex.join([*parts, "--only", label, *seed, *options_in(argv, "--set", "--split"), *trusted])


def failures(run: RunData) -> list[tuple[str, str]]:
    """Labels of the failed cells, and the last line of each traceback."""
    return [(c["label"], _last_line(c.get("error"))) for c in run.cells if c["status"] != "ok"]


def _both_rates(table: Table) -> tuple[Measured, Measured]:
    return rate_measured(true_positive_rate(table)), rate_measured(true_negative_rate(table))


def _missed(run: RunData, name: str, table: Table, most: int) -> WorstCases:
    """Collisions without an alert in time: first those without any, spread over the strata, then the latest alerts."""
    wrong = chosen(table, table["collides"] & ~table["true_alert"])
    lateness = np.where(wrong["alert"], wrong["alert_distance_m"], -np.inf)
    order = np.lexsort((_turn(np.char.add(wrong["scene"], wrong["category"])), lateness))
    words = [_missed_words(wrong, row) for row in order[:most]]
    return WorstCases(name, "Missed collisions", len(order), _cases(run, wrong, order[:most], words))


def _missed_words(table: Table, row: int) -> str:
    if not table["alert"][row]:
        return "no alert"
    left = float(table["alert_distance_m"][row])
    return f"alert {left:.2f} m before contact" if left >= 0.0 else f"alert {-left:.2f} m after contact"


def _false(run: RunData, name: str, table: Table, most: int) -> WorstCases:
    """Alerts on walks without a collision: those that pass farthest from the target first."""
    wrong = chosen(table, table["alert"] & ~table["collides"])
    order = np.argsort(-wrong["miss_distance_m"], kind="stable")
    words = [
        f"line of walk passes at {wrong['miss_distance_m'][row]:.2f} m; alert at {wrong['alert_range_m'][row]:.2f} m"
        for row in order[:most]
    ]
    return WorstCases(name, "False alerts", len(order), _cases(run, wrong, order[:most], words))


def _turn(names: Strings) -> Ints:
    """How many earlier entries have the same name."""
    order = np.argsort(names, kind="stable")
    ordered = names[order]
    turn = np.empty(len(names), dtype=np.int64)
    turn[order] = np.arange(len(names)) - np.searchsorted(ordered, ordered)
    return turn


def _cases(run: RunData, table: Table, rows: Ints, words: Sequence[str]) -> tuple[Case, ...]:
    labels, phones = table["label"], table["phone"]
    return tuple(
        Case(str(labels[row]), str(phones[row]), what, rerun_command(run, str(labels[row])))
        for row, what in zip(rows, words, strict=True)
    )


def _suite_of(run: RunData) -> str:
    """The suite as it was named on the command line, if that was a file."""
    files = [word for word in run.manifest.get("argv") or [] if word.endswith((".yaml", ".yml"))]
    return files[0] if files else str(run.manifest.get("suite", UNKNOWN))


def _last_line(error: str | None) -> str:
    lines = (error or "").strip().splitlines()
    return lines[-1] if lines else UNKNOWN
