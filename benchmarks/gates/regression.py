"""Regression: the same walks as the baseline's, judged pair by pair."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from benchmarks.gates.baseline import Baseline, RunBaseline, baseline_walks, run_key
from benchmarks.gates.config import Gates, Regression
from benchmarks.gates.quantities import KINDS, QUANTITIES, judged_right, per_walk, walk_tables
from benchmarks.gates.verdict import Verdict
from benchmarks.runs.results import RunData
from benchmarks.scoring.paired import FEW_PAIRS, change_of, shift_of
from benchmarks.scoring.statistics import mcnemar
from obstaclewatch.support.words import counted

GROUP = "regression"


def judge_regression(run: RunData, gates: Gates, baseline: Baseline | None) -> list[Verdict]:
    """Every regression gate; unmeasured without a baseline of the same suite, tier, split and seed."""
    return [verdict for asked in gates.regression for verdict in _judge(run, gates, baseline, asked)]


def _judge(run: RunData, gates: Gates, baseline: Baseline | None, asked: Regression) -> Iterator[Verdict]:
    against = asked.against or asked.detector
    before = None if baseline is None else baseline.runs.get(run_key(run))
    why = _incomparable(run, baseline, before, asked.detector, against)
    if why is not None or before is None:
        yield Verdict.unmeasured(GROUP, asked.detector, f"{asked.detector}: {why}")
        return
    for rate in asked.rates:
        yield _rate(run, gates, before, asked.detector, against, rate)
    for kind, tolerances in zip(KINDS, (asked.approach, asked.standing), strict=True):
        tables = walk_tables(run, asked.detector, kind)
        for quantity, tolerance in tolerances.items():
            earlier = before.values[against].get(kind, {}).get(quantity, {})
            name = f"{asked.detector} {quantity}, {kind}"
            yield _quantity(name, quantity, earlier, per_walk(tables, quantity), tolerance, gates.confidence)


def _incomparable(
    run: RunData, baseline: Baseline | None, before: RunBaseline | None, detector: str, against: str
) -> str | None:
    """Why run and baseline cannot be compared; None if they can."""
    if baseline is None:
        return "no baseline was given; `obstaclewatch baseline update RUN --reason ...` makes one"
    if before is None:
        return f"the baseline holds {sorted(baseline.runs)}, not the run's {run_key(run)}"
    if against not in before.values:
        return f"the baseline holds {sorted(before.values)}, not {against}"
    now = judged_right(run, detector)
    here, there = {label: collides for label, (collides, _) in now.items()}, baseline_walks(before, against)
    if missing := sorted(there.keys() - here.keys()):
        absent = counted(len(missing), "walk of the baseline is", "walks of the baseline are")
        return f"{absent} not in the run, the first is {missing[0]}"
    if differ := [label for label in there if there[label] != here[label]]:
        apart = counted(len(differ), "walk collides", "walks collide")
        return f"{apart} here and not in the baseline or the reverse: scenes changed, update it"
    return None


def _rate(run: RunData, gates: Gates, before: RunBaseline, detector: str, against: str, rate: str) -> Verdict:
    name = f"{detector} {rate}"
    side = [label for label, collides in before.collides.items() if collides is (rate == "TP")]
    right = {label: good for label, (_, good) in judged_right(run, detector).items()}
    earlier = {label: before.right[against][label] for label in side if label in before.right.get(against, {})}
    found = change_of(earlier, right)
    if found.n == 0:
        return Verdict.unmeasured(GROUP, name, f"{name}: no such walk")
    if mcnemar(sum(earlier.values()), 0) >= gates.p_below:
        why = f"{sum(earlier.values())} of {found.n} walks were right, too few to lose significantly"
        return Verdict.unmeasured(GROUP, name, f"{name}: {why}")
    fell = found.p < gates.p_below and found.loss_points >= gates.loss_points
    text = (
        f"{name}: {found.lost} of {found.n} walks lost and {found.gained} gained against the baseline "
        f"({-found.loss_points:+.1f} points, McNemar p = {found.p:.2g}); red at p < {gates.p_below:g} and a loss of "
        f"{gates.loss_points:g} points"
    )
    return Verdict.of(GROUP, name, not fell, text, found.n)


def _quantity(
    name: str,
    quantity: str,
    earlier: Mapping[str, float],
    now: Mapping[str, float],
    tolerance: float,
    confidence: float,
) -> Verdict:
    """Whether a quantity, by walks, got worse by more than is tolerated."""
    rule = QUANTITIES[quantity]
    found = shift_of(earlier, now, rule.summary, confidence)
    if found.before == 0:
        return Verdict.unmeasured(GROUP, name, f"{name}: no estimate in baseline and run")
    if found.n == 0 or found.n < FEW_PAIRS <= found.before:
        now_has = f"only {found.n}" if found.n else "none has"
        return Verdict.of(
            GROUP, name, False, f"{name}: {found.before} walks had an estimate, now {now_has}", found.before
        )
    if found.n == 1:
        return Verdict.unmeasured(GROUP, name, f"{name}: one walk with an estimate in both, which has no spread")
    grew, fell = found.low > tolerance, rule.worse == "either" and found.high < -tolerance
    way = "shift" if rule.worse == "either" else "growth"
    text = (
        f"{name}: {_middle(rule.summary)} difference {found.value:+.3g} {rule.unit} over {counted(found.n, 'walk')}, "
        f"{found.low:+.3g} to {found.high:+.3g}; red if a {way} beyond {tolerance:g} {rule.unit} is certain"
    )
    return Verdict.of(GROUP, name, not (grew or fell), " ".join(text.split()), found.n)


def _middle(summary: object) -> str:
    return "mean" if summary is np.mean else "median"
