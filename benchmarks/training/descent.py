"""What both networks are learned by: AdamW, at a rate that rises and falls again, a batch at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from torch import nn

from obstaclewatch.support.arrays import Floats, Ints, Singles

BATCH = 256
LEAST_SPREAD = 1e-3


def usual_and_spread(evidence: Floats) -> tuple[Floats, Floats]:
    """(F,) mean and deviation of numbers (n, F), as far as they are there: 0 and the least of those that never are."""
    numbers = np.ma.masked_array(evidence, np.isnan(evidence))
    usual, spread = (each.filled(0.0) for each in (numbers.mean(axis=0), numbers.std(axis=0)))
    return usual, np.maximum(spread, LEAST_SPREAD)


def descend(
    net: nn.Module,
    loss_of: Callable[[Ints], torch.Tensor],
    count: int,
    rng: np.random.Generator,
    *,
    epochs: int,
    rate: float,
    weight_decay: float,
) -> None:
    """Learn from `count` examples, in every epoch's own order.

    Args:
        net: what is learned.
        loss_of: the loss of some examples, by their rows.
        count: of examples.
        rng: of the orders.
        epochs: how often each is seen.
        rate: the highest.
        weight_decay: of AdamW.
    """
    optimizer = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=weight_decay)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=epochs * (-(-count // BATCH)) + 1)
    net.train()
    for _ in range(epochs):
        order = rng.permutation(count)
        for first in range(0, count, BATCH):
            loss = loss_of(order[first : first + BATCH])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()


def plain(values: Any) -> Singles:
    """A tensor's values, in an array of their own."""
    found: Singles = values.detach().numpy().copy()
    return found
