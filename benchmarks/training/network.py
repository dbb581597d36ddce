"""Networks learned with PyTorch, each from all folds of the walks but one, and written down as plain arrays.

PyTorch is needed here alone: `pip install 'obstaclewatch[training]'`. On one machine the same examples give the same
weights: everything is drawn from a seed, and sums run in one thread.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from joblib import Parallel, delayed
from torch import nn
from torch.nn import functional

from benchmarks.training.descent import descend, plain, usual_and_spread
from benchmarks.training.examples import FOLDS, Examples
from benchmarks.training.fit import stated
from obstaclewatch.support.arrays import Floats, Ints, Singles
from obstaclewatch.tracking.approach_picture import LAYERS, SHAPE
from obstaclewatch.tracking.collision_model import KERNEL, POOLED_LAYERS, CollisionModel, Network, limited, scaled

CHANNELS = (16, 24, 32)
HIDDEN = 32
DROPPED = 0.5
"""Share of the values that a step leaves out before either dense layer."""
WEIGHT_DECAY = 0.05
EPOCHS = 4
RATE = 3e-3
"""Highest rate of learning; it rises to it and falls again."""
SHIFTED_COLUMNS = 1
"""By which a batch's pictures are moved nearer or farther: 5 cm decide nothing."""
ADDED_NOISE = 0.1
LOUDNESS = 3.0
"""Factor up to which levels and microphone 1's agreement are raised or lowered, apart: phones and places differ."""
WITHOUT_NUMBER = 0.15
"""Share of the numbers that a step leaves out, so that none is relied on alone."""
WITHOUT_MIC_1 = 0.05
"""Share of the pictures from which microphone 1 is taken, as some recordings lack it."""


class _Net(nn.Module):
    """As `Network`."""

    def __init__(self, numbers: int) -> None:
        super().__init__()
        inputs = (SHAPE[0], *CHANNELS[:-1])
        self.layers = nn.ModuleList(
            nn.Conv2d(taken, given, KERNEL, padding=KERNEL // 2) for taken, given in zip(inputs, CHANNELS, strict=True)
        )
        share = 2**POOLED_LAYERS
        seen = CHANNELS[-1] * (SHAPE[1] // share) * (SHAPE[2] // share)
        self.hidden, self.output = nn.Linear(seen + numbers, HIDDEN), nn.Linear(HIDDEN, 1)
        self.dropped, self.left_out = nn.Dropout(DROPPED), nn.Dropout(WITHOUT_NUMBER)

    def forward(self, pictures: torch.Tensor, numbers: torch.Tensor) -> torch.Tensor:
        seen = pictures
        for layer, convolution in enumerate(self.layers):
            seen = functional.relu(convolution(seen))
            if layer < POOLED_LAYERS:
                seen = functional.max_pool2d(seen, 2)
        hidden = self.hidden(torch.cat([self.dropped(seen.flatten(1)), self.left_out(numbers)], dim=1))
        return self.output(self.dropped(functional.relu(hidden)))[:, 0]


def learned(examples: Examples, jobs: int = 1, seed: int = 0) -> tuple[CollisionModel, Floats]:
    """A model without thresholds, and (n,) probabilities at all beeps by the network that did not learn from them.

    Raises:
        ValueError: all walks are in one fold, so that a network would have none to learn from.
    """
    used, fold = examples.used, examples.fold
    evidence = examples.evidence[used]
    usual, spread = usual_and_spread(evidence)
    others = [np.flatnonzero(used & (fold != own)) for own in range(FOLDS)]
    if not all(len(rows) for rows in others):
        raise ValueError(f"walks must be in two of {FOLDS} folds or more, got {sorted(set(fold.tolist()))}: add walks")
    fitted = (delayed(_fitted)(examples, rows, usual, spread, seed + own) for own, rows in enumerate(others))
    networks = Parallel(n_jobs=jobs)(fitted)
    model = CollisionModel(tuple(networks), usual, spread, np.array([0.0, 1.0]), np.ones(2))
    probability = np.zeros(len(examples))
    for own, network in enumerate(networks):
        probability[fold == own] = stated(replace(model, networks=(network,)), examples[fold == own])
    return model, probability


def _fitted(every: Examples, learned_from: Ints, usual: Floats, spread: Floats, seed: int) -> Network:
    """By weighted cross entropy over those beeps.

    Pictures are taken from all, a batch at a time: copies of most of them for every fold do not fit into memory.
    """
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    examples = every.without_pictures[learned_from]
    rng = np.random.default_rng(seed)
    numbers = torch.from_numpy(scaled(examples.evidence, usual, spread))
    collides = torch.from_numpy(examples.collides.astype(np.float32))
    each = examples.weights()
    weight = torch.from_numpy((each / each.mean()).astype(np.float32))
    net = _Net(numbers.shape[1])

    def loss_of(rows: Ints) -> torch.Tensor:
        pictures = _varied(every.pictures[learned_from[rows]].astype(np.float32), rng)
        log_odds = net(torch.from_numpy(pictures), numbers[rows])
        return functional.binary_cross_entropy_with_logits(log_odds, collides[rows], weight[rows])

    descend(net, loss_of, len(examples), rng, epochs=EPOCHS, rate=RATE, weight_decay=WEIGHT_DECAY)
    return _as_network(net)


def _varied(pictures: Singles, rng: np.random.Generator) -> Singles:
    """Moved by a column, with noise, as loud as elsewhere, and now and then without microphone 1."""
    moved = np.roll(pictures, rng.integers(-SHIFTED_COLUMNS, SHIFTED_COLUMNS + 1), axis=3)
    moved += np.float32(ADDED_NOISE) * rng.standard_normal(moved.shape, dtype=np.float32)
    agreement, level = LOUDNESS ** rng.uniform(-1.0, 1.0, (2, len(moved)))
    agreement[rng.random(len(moved)) < WITHOUT_MIC_1] = 0.0
    layers = moved.reshape(len(moved), -1, LAYERS, *SHAPE[1:])
    layers[:, :, 1:3] *= agreement[:, None, None, None, None]
    layers[:, :, 3] *= level[:, None, None, None]
    return limited(moved)


def _as_network(net: _Net) -> Network:
    return Network(
        tuple(plain(layer.weight) for layer in net.layers),
        tuple(plain(layer.bias) for layer in net.layers),
        plain(net.hidden.weight),
        plain(net.hidden.bias),
        plain(net.output.weight[0]),
        plain(net.output.bias[0]),
    )
