"""Blocks of a recording that ring into each other, added up piece by piece in constant memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from obstaclewatch.support.arrays import Singles


def overlapped(blocks: Iterable[tuple[int, Singles]], lead: int, count: int) -> Iterator[Singles]:
    """(2, n) pieces of the first `count` samples of a sum of blocks; each as soon as no later block reaches it.

    Args:
        blocks: in the order of time, the sample at which each begins, and its samples from `lead` earlier on.

    Example:
        >>> import numpy as np
        >>> from simulator.rendering.overlap import overlapped
        >>> two = [(0, np.ones((2, 6))), (4, np.full((2, 6), 10.0))]
        >>> [piece[0].tolist() for piece in overlapped(two, lead=1, count=8)]
        [[1.0, 1.0, 1.0], [11.0, 11.0, 10.0, 10.0, 10.0]]
    """
    held, done = np.zeros((2, 0), dtype=np.float32), 0
    for first, block in blocks:
        ready = max(first - lead - done, 0)
        if ready:
            yield held[:, :ready]
        held, done = held[:, ready:].copy(), done + ready
        skipped = done - (first - lead)  # of the first block, what comes before the recording
        longer = np.zeros((2, max(held.shape[1], block.shape[1] - skipped)), dtype=np.float32)
        longer[:, : held.shape[1]] = held
        longer[:, : block.shape[1] - skipped] += block[:, skipped:]
        held = longer
    yield held[:, : count - done]
