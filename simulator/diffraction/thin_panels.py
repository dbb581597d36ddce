"""Thin flat panels, and which of their edges a diffracted sound reaches along the face.

A sound that one edge has diffracted runs along the face to the other edges. On a thin panel it does so on both faces,
with opposite signs and the same strength.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Ints
from simulator.surfaces.wedges import Wedges

MOST_EDGES, SHORTEST_M = 8, 0.05  # borders of more or shorter pieces are curves
ON_LINE_M = 1e-4  # corners this close to an edge's line are its own


def panels_of(wedges: Wedges) -> list[Ints]:
    """Wedges of every convex face of a thin panel: two to `MOST_EDGES` of three wavelengths or more."""
    thin = (wedges.patch[:, 0] == wedges.patch[:, 1]) & wedges.flat
    groups = [np.flatnonzero(thin & (wedges.patch[:, 0] == patch)) for patch in np.unique(wedges.patch[thin, 0])]
    return [group for group in groups if 1 < len(group) <= MOST_EDGES and _is_convex(wedges[group])]


def linked_edges(wedges: Wedges) -> Flags:
    """(W, W) whether sound runs over the face from one edge of a panel to another: never along their common line."""
    same = _own_corners(wedges).all(axis=2)
    return np.asarray(~(same | same.T))


def _is_convex(wedges: Wedges) -> bool:
    """Whether no edge is short, and no corner lies outside any of them."""
    corners = np.concatenate([wedges.start_m, wedges.end_m])
    inside = np.einsum("wcx,wx->wc", corners[None] - wedges.start_m[:, None], wedges.inwards)
    return bool((wedges.length_m >= SHORTEST_M).all() and (inside > -ON_LINE_M).all())


def _own_corners(wedges: Wedges) -> Flags:
    """(W, W, 2) whether the start and the end of the second edge lie on the line of the first."""
    corners = np.stack([wedges.start_m, wedges.end_m], axis=1)
    off = np.einsum("vcwx,wx->wvc", corners[:, :, None] - wedges.start_m[None, None], wedges.inwards)
    return np.abs(off) < ON_LINE_M
