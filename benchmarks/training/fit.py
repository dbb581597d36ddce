"""A sum of curves by penalised logistic regression, thresholds by cost, and how far to trust what it says."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.training.examples import Examples
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.tracking.collision_model import CollisionModel
from obstaclewatch.tracking.detector import FARTHEST_M
from obstaclewatch.tracking.evidence import Evidence

KNOTS = 5
OUTER_SHARE = 0.02
"""Share of the examples beyond either outer knot."""
PENALTY = 10.0
"""On the squared rise of a curve from knot to knot, against log likelihoods that weigh `EFFECTIVE_EXAMPLES` a walk."""
EFFECTIVE_EXAMPLES = 4.0
"""As many as the beeps of a reception are worth: they are alike."""
ITERATIONS = 500
FOLDS = 5
LEFT_M = (0.5, 1.0)
"""Distances left between which the threshold goes from one value to another."""
THRESHOLDS = np.round(np.arange(0.50, 0.99, 0.01), 2)
IN_TIME_M = 0.5
"""Distance left up to which an alert counts when thresholds are chosen."""
MISS_COST, FALSE_COST = 1.0, 1.5
"""Of a collision without an alert in time, and of an alert on a walk without a collision."""


def fitted(examples: Examples) -> CollisionModel:
    """The model that explains examples best; thresholds are 1 for now."""
    learned = examples[examples.used]
    knots = np.array([_knots(column) for column in learned.evidence.T])
    design = _design(learned.evidence, knots)
    receptions = len(np.unique(learned.received))
    weight = learned.weights() * EFFECTIVE_EXAMPLES * receptions
    sign = np.where(learned.collides, 1.0, -1.0)

    def cost(coefficients: Floats) -> tuple[float, Floats]:
        margin = sign * (design @ coefficients)
        rest = np.exp(-np.logaddexp(0.0, margin))  # 1 - the probability of what happened
        gradient = PENALTY * np.append(0.0, coefficients[1:]) - design.T @ (weight * sign * rest)
        value = float(weight @ np.logaddexp(0.0, -margin) + 0.5 * PENALTY * np.sum(coefficients[1:] ** 2))
        return value, gradient

    found = minimize(
        cost, np.zeros(design.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": ITERATIONS, "ftol": 1e-10}
    ).x
    own = found[1:].reshape(len(knots), KNOTS)
    values = np.concatenate([np.zeros((len(knots), 1)), np.cumsum(own[:, :-1], axis=1)], axis=1)
    return CollisionModel(knots, values, own[:, -1], float(found[0]), np.array(LEFT_M), np.ones(2))


def cross_validated(examples: Examples) -> Floats:
    """(n,) probabilities of a collision by models of the walks of other folds."""
    fold, found = examples.walk % FOLDS, np.zeros(len(examples))
    for own in range(FOLDS):
        if (fold == own).any():
            found[fold == own] = fitted(examples[fold != own]).probabilities(examples.evidence[fold == own])
    return found


def with_thresholds(model: CollisionModel, examples: Examples, probability: Floats) -> CollisionModel:
    """The thresholds that cost least on walks at whose beeps (n,) such probabilities are stated."""
    left_m = distances_left(examples)
    pairs = [replace(model, thresholds=np.array(pair)) for pair in product(THRESHOLDS, THRESHOLDS)]
    return min(pairs, key=lambda pair: _cost(examples, alerts_by(pair, probability, left_m)))


def alerts_by(model: CollisionModel, probability: Floats, left_m: Floats) -> Flags:
    """(n,) whether there is an alert after a beep."""
    return model.suffices(probability, left_m) & (left_m <= FARTHEST_M)


def distances_left(examples: Examples) -> Floats:
    """(n,) what the detector takes to be left to walk."""
    return np.array([Evidence(*row).distance_left_m for row in examples.evidence])


def rates(examples: Examples, alerts: Flags, in_time_m: float) -> tuple[float, ...]:
    """TP and TN of walks (every reception counts), of an alert at any beep with so much left or more; NaN of none."""
    own = examples.received
    receptions, which = np.unique(own, return_inverse=True)
    counts = alerts & np.where(examples.collides, examples.left_m > in_time_m, True)
    alerted, collides = np.zeros(len(receptions), dtype=bool), np.zeros(len(receptions), dtype=bool)
    np.logical_or.at(alerted, which, counts)
    collides[which] = examples.collides
    hits, others = alerted[collides], ~alerted[~collides]
    return tuple(float(own.mean()) if len(own) else np.nan for own in (hits, others))


def calibration(examples: Examples, probability: Floats, bins: int = 10) -> list[dict[str, Any]]:
    """Stated and observed shares of collisions by the probability that is stated, and the walks behind them."""
    rows, edge = [], np.linspace(0.0, 1.0, bins + 1)
    used, weight = examples.used, np.zeros(len(examples))
    weight[used] = examples[used].weights()
    for low, high in pairwise(edge):
        among = used & (probability >= low) & (probability < high if high < 1.0 else probability <= 1.0)
        if among.any():
            total = weight[among].sum()
            rows.append(
                {
                    "stated": round(float(weight[among] @ probability[among] / total), 3),
                    "observed": round(float(weight[among & examples.collides].sum() / total), 3),
                    "walks": len(np.unique(examples.walk[among])),
                }
            )
    return rows


def _cost(examples: Examples, alerts: Flags) -> float:
    true_positive, true_negative = rates(examples, alerts, IN_TIME_M)
    return MISS_COST * (1.0 - true_positive) + FALSE_COST * (1.0 - true_negative)


def _knots(column: Floats) -> Floats:
    """(KNOTS,) ascending, with as many examples between any two."""
    finite = column[np.isfinite(column)]
    found = np.quantile(finite, np.linspace(OUTER_SHARE, 1.0 - OUTER_SHARE, KNOTS)) if len(finite) else np.zeros(KNOTS)
    least = 1e-3 * max(float(np.ptp(found)), 1.0)
    return np.maximum.accumulate(np.round(found, 4) + least * np.arange(KNOTS))


def _design(evidence: Floats, knots: Floats) -> Floats:
    """(n, 1 + F x KNOTS) 1; of every number how much of each piece between knots lies below it, and whether it is
    missing."""
    columns = [np.ones(len(evidence))]
    for number, own in zip(evidence.T, knots, strict=True):
        missing = np.isnan(number)
        for low, high in pairwise(own):
            columns.append(np.where(missing, 0.0, (np.clip(number, low, high) - low) / (high - low)))
        columns.append(missing.astype(np.float64))
    return np.column_stack(columns)
