"""How far a face runs from each of its sharp edges to another one across it."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces.wedges import Wedges

CLOSE_M = 0.01  # what is so close to the line of an edge is part of it: the rim of a plate has two
AT_ONCE = 2**18  # pairs of edges: what is kept in memory, however many edges a face has


def runs_to_opposite_m(wedges: Wedges) -> Floats:
    """(W, 2) distance across face 0 and the last face to the middle of the nearest convex edge that shares no corner.

    Infinite without one.
    """
    edge, side = np.divmod(np.arange(2 * len(wedges)), 2)
    patch = wedges.patch[edge, side]
    order = np.argsort(patch, kind="stable")
    first, count = np.unique(patch[order], return_index=True, return_counts=True)[1:]
    entry, place = repeated(np.repeat(count, count))  # every edge of a face with every one
    entry, other = order[entry], edge[order[np.repeat(first, count)[entry] + place]]
    runs = np.full(2 * len(wedges), np.inf)
    for begin in range(0, len(entry), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        np.minimum.at(runs, entry[some], _runs_m(wedges, edge[entry[some]], other[some]))
    return runs.reshape(-1, 2)


def _runs_m(wedges: Wedges, one: Ints, other: Ints) -> Floats:
    """(R,) distance from the lines of some edges to the middle of others; infinite where these are not opposite."""
    ends = np.stack([wedges.start_m, wedges.end_m], axis=1)
    offset, along = ends[other].mean(axis=1) - wedges.start_m[one], wedges.along[one]
    across = norm(offset - dot(offset, along)[:, None] * along)
    apart = norm(ends[one][:, :, None] - ends[other][:, None]).min(axis=(1, 2), initial=np.inf)
    opposite = (wedges.free_angle_rad > np.pi)[other] & (np.minimum(across, apart) > CLOSE_M)
    return np.where(opposite, across, np.inf)
