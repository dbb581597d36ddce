"""Two runs on the same walks: which rates and medians differ, and how surely."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.gates.quantities import KINDS, QUANTITIES, judged_right, per_walk, walk_tables
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import first_point, variants
from benchmarks.scoring.paired import FEW_PAIRS, Change, Shift, change_of, shift_of
from benchmarks.scoring.paper_values import SHOWN
from obstaclewatch.support.words import counted

Walk = tuple[str, int]
"""Label and seed, which tell a walk."""


@dataclass(frozen=True)
class Comparison:
    """One detector in a first run against one in a second.

    Attributes:
        first, second: names of the detectors.
        rates: "TP" and "TN" -> what the second lost and gained.
        shifts: kind, quantity and unit -> paired difference, second - first; only those with a pair.
        outcome_differs: walks that collide in one run and not in the other; they are left out.
    """

    first: str
    second: str
    rates: Mapping[str, Change]
    shifts: Mapping[tuple[str, str, str], Shift]
    outcome_differs: int


@dataclass(frozen=True)
class LeftOut:
    """What a comparison leaves out of a run.

    Attributes:
        cells: walks, standing measurements and probes that the other run has not measured: no such cell, or it failed.
        failed: cells that failed in this run.
        detectors: names that the other run has not, and that are not compared with one of another name.
        points: of its sweep, all but the first.
    """

    cells: int
    failed: int
    detectors: tuple[str, ...]
    points: int


def left_out(run: RunData, other: RunData, compared: Iterable[str] = ()) -> LeftOut:
    """What `compare_runs` leaves out of a run beside another, of whose detectors these are compared."""
    own, others = first_point(run)[0], first_point(other)[0]
    cells = len(_walks(own) - _walks(others))
    detectors = tuple(sorted(detectors_of(own) - detectors_of(others) - set(compared)))
    return LeftOut(cells, len(own.cells) - len(own.ok), detectors, len(variants(run)) - 1)


def left_out_line(which: str, found: LeftOut) -> str:
    """What is left out of the "first" or "second" run, in words; empty where the other has everything.

    >>> left_out_line("first", LeftOut(cells=1, failed=0, detectors=(), points=3))
    'left out of the first run: 1 cell that the other has not measured, all but the first of 4 points'
    """
    parts = [
        f"{counted(found.cells, 'cell')} that the other has not measured" * (found.cells > 0),
        f"{counted(found.failed, 'cell')} that failed" * (found.failed > 0),
        f"the detectors {', '.join(found.detectors)}" * bool(found.detectors),
        f"all but the first of {found.points + 1} points" * (found.points > 0),
    ]
    said = ", ".join(part for part in parts if part)
    return said and f"left out of the {which} run: {said}"


def compare_runs(first: RunData, second: RunData, pairs: Sequence[tuple[str, str]] | None = None) -> list[Comparison]:
    """Compare detectors, first -> second; by default those that both runs have. Of sweeps, the first points alone.

    Raises:
        ValueError: no detector in common, an unknown one, or no walk in common: those of another seed or split have the
            same labels, but are others.
    """
    first, second = first_point(first)[0], first_point(second)[0]
    here, there = detectors_of(first), detectors_of(second)
    asked = [(name, name) for name in sorted(here & there)] if pairs is None else list(pairs)
    if not asked:
        raise ValueError(f"the runs must have a detector in common, got {sorted(here)} and {sorted(there)}")
    for known, side in ((here, 0), (there, 1)):
        if unknown := sorted({pair[side] for pair in asked} - known):
            raise ValueError(f"a detector must be one of {sorted(known)}, got {unknown}")
    shared = _walks(first) & _walks(second)
    if not shared:
        raise ValueError("the runs must have walks in common, got none; same suite, split and seed")
    alike = _only(first, shared), _only(second, shared)
    return [_compare(*alike, *pair) for pair in asked]


def detectors_of(run: RunData) -> set[str]:
    """Names of all detectors of a run."""
    return {name for record in run.ok for name in (record["result"].get("detectors") or {})}


def _walks(run: RunData) -> set[Walk]:
    return {_walk(record) for record in run.ok}


def _walk(record: Mapping[str, Any]) -> Walk:
    return record["label"], record["cell"]["seed"]


def _only(run: RunData, kept: set[Walk]) -> RunData:
    return RunData(run.folder, run.manifest, tuple(record for record in run.ok if _walk(record) in kept))


def _compare(first: RunData, second: RunData, name: str, other: str) -> Comparison:
    before, now = judged_right(first, name), judged_right(second, other)
    shared = {label for label in before.keys() & now.keys() if before[label][0] == now[label][0]}
    rates = {}
    for rate, side in (("TP", True), ("TN", False)):
        asked = [label for label in shared if before[label][0] is side]
        if asked:
            rates[rate] = change_of({k: before[k][1] for k in asked}, {k: now[k][1] for k in asked})
    apart = (before.keys() & now.keys()) - shared
    return Comparison(name, other, rates, dict(_shifts(first, second, name, other, apart)), len(apart))


def _shifts(
    first: RunData, second: RunData, name: str, other: str, apart: set[str]
) -> Iterator[tuple[tuple[str, str, str], Shift]]:
    """Of every quantity, but for the walks that are apart."""
    for kind in KINDS:
        tables = walk_tables(first, name, kind), walk_tables(second, other, kind)
        for quantity, rule in QUANTITIES.items():
            before, now = (
                {label: value for label, value in per_walk(table, quantity).items() if label not in apart}
                for table in tables
            )
            found = shift_of(before, now, rule.summary)
            if found.n:
                yield (kind, quantity, rule.unit), found


def comparison_lines(found: Comparison) -> list[str]:
    """A table in plain text, in cm and degrees."""
    lines = [found.first if found.first == found.second else f"{found.first} -> {found.second}"]
    if found.outcome_differs:
        apart = counted(found.outcome_differs, "walk collides", "walks collide")
        lines.append(f"  {apart} in one run only: left out")
    for rate, change in found.rates.items():
        lines.append(
            f"  {rate:<34}{0.0 - change.loss_points:+8.1f} points   {change.gained} gained, {change.lost} lost "
            f"of {change.n}, McNemar p = {change.p:.2g}"
        )
    for (kind, quantity, unit), shift in found.shifts.items():
        scale, shown = SHOWN.get(unit, (1.0, f" {unit}"))
        said = f"  {quantity + ', ' + kind:<34}{scale * shift.value:+8.3g} {shown.strip():<7}"
        lines.append(f"{said}  {_interval(shift, scale)}")
    return lines


def _interval(shift: Shift, scale: float) -> str:
    """Interval and star: of fewer than `FEW_PAIRS` walks neither, as the span of so few holds the median too seldom."""
    walks = f"over {counted(shift.n, 'walk')}"
    if shift.n < FEW_PAIRS:
        return f"{walks}, too few for an interval"
    star = "" if shift.low <= 0.0 <= shift.high else "   *"
    return f"{scale * shift.low:+.3g} to {scale * shift.high:+.3g} {walks}{star}"
