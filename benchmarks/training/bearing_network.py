"""The network that states bearings, learned with PyTorch and written down as plain arrays.

On one machine the same examples give the same weights: everything is drawn from a seed, in one thread.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from benchmarks.training.bearings import BearingExamples
from benchmarks.training.descent import descend, plain, usual_and_spread
from obstaclewatch.support.arrays import Ints
from obstaclewatch.tracking.bearing_evidence import NUMBERS
from obstaclewatch.tracking.bearing_model import EDGES_RAD, BearingModel, scaled

HIDDEN = (96, 48)
DROPPED = 0.1
"""Share of the values that a step leaves out after either hidden layer."""
WEIGHT_DECAY = 0.05
EPOCHS = 16
RATE = 2e-3
"""Highest rate of learning; it rises to it and falls again."""


def learned_bearings(examples: BearingExamples, seed: int = 0) -> BearingModel:
    """By weighted cross entropy of the bin that the true bearing is in.

    Raises:
        ValueError: there is nothing to learn from.
    """
    if not len(examples):
        raise ValueError("there must be examples to learn from, got none: add walks")
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    usual, spread = usual_and_spread(examples.evidence)
    numbers = torch.from_numpy(scaled(examples.evidence, usual, spread))
    right = torch.from_numpy(np.digitize(examples.true_rad, EDGES_RAD[1:-1]))
    weight = torch.from_numpy(examples.weights().astype(np.float32))
    net = _net()

    def loss_of(rows: Ints) -> torch.Tensor:
        loss = functional.cross_entropy(net(numbers[rows]), right[rows], reduction="none") @ weight[rows]
        return loss / len(rows)

    descend(net, loss_of, len(examples), rng, epochs=EPOCHS, rate=RATE, weight_decay=WEIGHT_DECAY)
    layers = [layer for layer in net if isinstance(layer, nn.Linear)]
    weights, offsets = tuple(plain(each.weight) for each in layers), tuple(plain(each.bias) for each in layers)
    return BearingModel(usual, spread, weights, offsets)


def _net() -> nn.Sequential:
    """As `BearingModel`."""
    layers: list[nn.Module] = []
    for taken, given in pairwise((NUMBERS, *HIDDEN)):
        layers += [nn.Linear(taken, given), nn.ReLU(), nn.Dropout(DROPPED)]
    return nn.Sequential(*layers, nn.Linear(HIDDEN[-1], len(EDGES_RAD) - 1))
