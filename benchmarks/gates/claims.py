"""Claims: what a run's rates and medians must be for certain, not on the point estimate."""

from __future__ import annotations

import numpy as np

from benchmarks.gates.config import Gates, MedianClaim, RateClaim
from benchmarks.gates.quantities import QUANTITIES, per_walk, tables_where, walk_tables
from benchmarks.gates.verdict import Verdict
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import first_point
from benchmarks.scoring.operating_points import true_positive_bounds
from benchmarks.scoring.scores import (
    Table,
    approach_table,
    chosen,
    recipe_of,
    rows_where,
    stated_scores,
    swept,
    true_negative_rate,
    true_positive_rate,
)
from benchmarks.scoring.statistics import Rate, lower_bound, needed_of, upper_quantile_bound
from benchmarks.scoring.strata import clear_cut
from obstaclewatch.support.words import counted

GROUP = "claim"


def judge_claims(run: RunData, gates: Gates) -> list[Verdict]:
    """Every claim, of a sweep's first point; unmeasured on another split than the one they are made for."""
    run, _ = first_point(run)
    named = [claim.model_copy(update={"detector": claim.detector or gates.claimed}) for claim in gates.claims]
    return [_judge(run, claim, gates.split) for claim in named]


def _judge(run: RunData, claim: RateClaim | MedianClaim, split: str) -> Verdict:
    name = _name(claim)
    if run.manifest["split"] != split:
        return Verdict.unmeasured(
            GROUP, name, f"{name} is claimed on split {split}, the run is {run.manifest['split']}"
        )
    return _rate(run, claim, name) if isinstance(claim, RateClaim) else _median(run, claim, name)


def _rate(run: RunData, claim: RateClaim, name: str) -> Verdict:
    if claim.recipe not in (None, recipe_of(run)):
        return Verdict.unmeasured(GROUP, name, f"{name} is claimed on recipe {claim.recipe}, not on these walks")
    walks = _asked_of(approach_table(run, claim.detector), claim)
    found = _measured(walks, claim)
    if found is None or found.n == 0:
        return Verdict.unmeasured(GROUP, name, f"{name}: no such walk in the run, or no probability stated")
    k, n = found.k, found.n
    bound, ask = _bound(walks, claim, k, n)
    text = (
        f"{name}: {k} of {n} ({100 * k / n:.1f} %), at least {100 * bound:.1f} % with {100 * claim.confidence:g} % "
        f"confidence; claimed {100 * claim.at_least:g} %, {ask}"
    )
    return Verdict.of(GROUP, name, bound >= claim.at_least, text, n)


def _bound(walks: Table, claim: RateClaim, k: int, n: int) -> tuple[float, str]:
    """Lower bound of a rate, and what would be enough; of a swept threshold the misses bound the threshold too."""
    if claim.at_tnr is not None:
        score, collides = stated_scores(walks, claim.left_m), walks["collides"]
        low, _ = true_positive_bounds(score[collides], score[~collides], claim.at_tnr, claim.confidence)
        return low, f"with a threshold known from {counted(int((~collides).sum()), 'other walk')}"
    needed = needed_of(n, claim.at_least, claim.confidence)
    ask = f"{needed} of {n} needed" if needed is not None else f"no count of {counted(n, 'walk')} is enough, run more"
    return lower_bound(k, n, claim.confidence), ask


def _asked_of(walks: Table, claim: RateClaim) -> Table:
    """The walks that a claim is about."""
    walks = rows_where(walks, scene=claim.scene, category=claim.category, phone=claim.phone)
    walks = chosen(walks, clear_cut(walks)) if claim.clear_cut else walks
    least_db = claim.least_index_db
    return walks if least_db is None else chosen(walks, walks["detection_index_db"] >= least_db)


def _measured(walks: Table, claim: RateClaim) -> Rate | None:
    """None if a threshold is to be swept and no probability is stated."""
    if claim.rate == "TN":
        return true_negative_rate(walks)
    if claim.at_tnr is None:
        return true_positive_rate(walks, claim.left_m)
    point = swept(walks, claim.left_m, claim.at_tnr)
    return None if point is None else point.true_positive


def _median(run: RunData, claim: MedianClaim, name: str) -> Verdict:
    tables = tables_where(
        walk_tables(run, claim.detector, claim.kind),
        scene=claim.scene,
        category=claim.category,
        standing_range_m=claim.standing_range_m,
    )
    values = np.array([value for value in per_walk(tables, claim.quantity).values() if np.isfinite(value)])
    if len(values) == 0:
        return Verdict.unmeasured(GROUP, name, f"{name}: no estimate in the run")
    middle, bound = float(np.median(values)), upper_quantile_bound(values, 0.5, claim.confidence)
    unit = QUANTITIES[claim.quantity].unit
    if np.isnan(bound):
        return Verdict.unmeasured(
            GROUP, name, f"{name}: {counted(len(values), 'walk is', 'walks are')} too few to bound a median, run more"
        )
    text = (
        f"{name}: median {middle:.4g} {unit} over {counted(len(values), 'walk')}, at most {bound:.4g} {unit} with "
        f"{100 * claim.confidence:g} % confidence; claimed {claim.at_most:g} {unit}"
    )
    return Verdict.of(GROUP, name, bound <= claim.at_most, text, len(values))


def _name(claim: RateClaim | MedianClaim) -> str:
    what = _rate_name(claim) if isinstance(claim, RateClaim) else f"{claim.quantity}, {claim.kind}"
    where = [part for part in (claim.scene, claim.category, getattr(claim, "phone", None)) if part]
    distance = getattr(claim, "standing_range_m", None)
    places = ", ".join([*where, *([f"{distance:g} m"] if distance else [])])
    return f"{claim.detector} {what}" + (f" ({places})" if places else "")


def _rate_name(claim: RateClaim) -> str:
    """ "TP at TN 95 %, 0.5 m left, clear-cut, index >= 15 dB"."""
    swept_to = "" if claim.at_tnr is None else f" at TN {100 * claim.at_tnr:g} %"
    parts = [f"{claim.left_m:g} m left"] if claim.left_m else []
    parts += ["clear-cut"] if claim.clear_cut else []
    parts += [] if claim.least_index_db is None else [f"index >= {claim.least_index_db:g} dB"]
    return ", ".join([claim.rate + swept_to, *parts])
