"""Which of many balls come near which others: pairs worth asking, a block at a time, and groups of neighbours.

A scan has 10^5 patches, and all pairs of their corners and planes fill no memory.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import shapely
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm

ASLANT = np.array([[0.8, 0.0, -0.6], [-0.36, 0.8, -0.48]])  # a view in which no upright or level edge is a point
Balls = tuple[Floats, Floats]
AT_ONCE = 2**22  # pairs of a block
GROUP = 16  # balls: so many are asked one by one


def touching(one: Balls, other: Balls, holds: Callable[[Ints, Ints], Flags]) -> tuple[Ints, Ints]:
    """Pairs of balls of two sets that touch and of which something holds.

    Args:
        one, other: middles (N, 3) and radii (N,) of each set.
        holds: (K,) whether it does of the pairs that rows (K,) and (K,) of both sets make, `AT_ONCE` at most.

    Returns:
        (R,) and (R,) rows of both sets, in turn by the first and then the second.

    >>> balls = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), np.full(3, 0.6)
    >>> [rows.tolist() for rows in touching(balls, balls, lambda one, other: one < other)]
    [[1], [2]]
    """
    (center_m, reach_m), (other_m, radius_m) = one, other
    found = [np.zeros((2, 0), dtype=np.int64)]
    tree = shapely.STRtree(_squares(other_m, radius_m))
    squares, step = _squares(center_m, reach_m), max(AT_ONCE // max(len(other_m), 1), 1)
    for begin in range(0, len(squares), step):
        first, second = tree.query(squares[begin : begin + step])
        first = first + begin
        near = norm(center_m[first] - other_m[second]) <= reach_m[first] + radius_m[second]
        pair = np.stack([first[near], second[near]])
        found.append(pair[:, holds(*pair)])
    first, second = np.concatenate(found, axis=1)
    turn = np.lexsort((second, first))
    return first[turn], second[turn]


class Groups(NamedTuple):
    """Balls in groups of neighbours, each within a ball of its own; a tuple of arrays, as compiled functions take it.

    Attributes:
        member: rows of the balls, group by group.
        first: (G + 1,) where the members of each group begin.
        owner: (G,) whose the members are.
        ball: (G, 4) middles and radii.
    """

    member: Ints
    first: Ints
    owner: Ints
    ball: Floats


def grouped(center_m: Floats, radius_m: Floats, owner: Ints) -> Groups:
    """Balls (N, 3) and (N,) in groups of `GROUP` at most, all of one owner (N,) each.

    >>> groups = grouped(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), np.array([1.0, 1.0]), np.array([0, 0]))
    >>> groups.member.tolist(), groups.ball.tolist()
    ([0, 1], [[1.0, 0.0, 0.0, 2.0]])
    """
    runs: list[Ints] = []
    owners: list[int] = []
    for each in np.unique(owner):
        own = np.flatnonzero(owner == each)
        near = own[cKDTree(center_m[own], leafsize=GROUP).indices]  # leaf by leaf
        runs += np.split(near, range(GROUP, len(near), GROUP))
        owners += [each] * (len(runs) - len(owners))
    balls = np.zeros((len(runs), 4))
    for ball, run in zip(balls, runs, strict=True):
        reach = radius_m[run, None]
        middle = 0.5 * ((center_m[run] - reach).min(axis=0) + (center_m[run] + reach).max(axis=0))
        ball[:] = *middle, (norm(center_m[run] - middle) + radius_m[run]).max()
    member = np.concatenate([np.zeros(0, dtype=np.int64), *runs])
    return Groups(member, np.cumsum([0, *map(len, runs)]), np.array(owners, dtype=np.int64), balls)


def _squares(center_m: Floats, radius_m: Floats) -> np.ndarray:
    """(N,) boxes that hold balls as they are seen in the view `ASLANT`, in which all lengths shrink."""
    middle = center_m @ ASLANT.T
    return np.asarray(shapely.box(*(middle - radius_m[:, None]).T, *(middle + radius_m[:, None]).T))
