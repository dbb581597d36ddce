"""Thresholds by cost, what a model then does, and how far to trust what it says."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np

from benchmarks.training.examples import Examples
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.tracking.collision_model import CollisionModel
from obstaclewatch.tracking.detector import FARTHEST_M
from obstaclewatch.tracking.evidence import Evidence

LEFT_M = (0.5, 1.0)
"""Distances left between which the threshold goes from one value to another."""
THRESHOLDS = np.round(np.arange(0.50, 0.99, 0.01), 2)
IN_TIME_M = 0.5
"""Distance left up to which an alert counts when thresholds are chosen."""
BATCH = 256
MISS_COST, FALSE_COST = 1.0, 1.0
"""Of a collision without an alert in time, and of an alert on a walk without a collision."""


def stated(model: CollisionModel, examples: Examples) -> Floats:
    """(n,) probabilities that a model states, a batch at a time."""
    parts = [slice(first, first + BATCH) for first in range(0, len(examples), BATCH)]
    found = [model.probabilities(examples.evidence[p], examples.pictures[p].astype(np.float32)) for p in parts]
    return np.concatenate([np.zeros(0), *found])


def with_thresholds(model: CollisionModel, examples: Examples, probability: Floats) -> CollisionModel:
    """The thresholds that cost least on walks at whose beeps (n,) such probabilities are stated.

    Raises:
        ValueError: none of the walks collides, or all do.
    """
    if examples.collides.all() or not examples.collides.any():
        raise ValueError(f"thresholds take walks that collide and others, got {len(examples)} beeps of one kind")
    left_m = distances_left(examples)
    pairs = [
        replace(model, left_m=np.array(LEFT_M), thresholds=np.array(pair)) for pair in product(THRESHOLDS, THRESHOLDS)
    ]
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


def calibration(examples: Examples, probability: Floats) -> list[dict[str, Any]]:
    """Stated and observed shares of collisions by the probability that is stated, and the walks behind them."""
    rows, edge = [], np.linspace(0.0, 1.0, 11)
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
