"""Thin flat panels, and the chains of their edges that a sound can meet one after the other.

A sound that one edge has bent over a face runs along it to the other edges. On a thin panel it does so on both faces,
with opposite signs and the same strength.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Ints
from simulator.diffraction.edge_view import APEX, END, START
from simulator.surfaces.wedges import Wedges

LONGEST = 3  # edges in one chain over apexes
MOST_EDGES, SHORTEST_M = 8, 0.05  # borders of more or shorter pieces are curves, on which no apex stands alone
FLAT_RAD = 1e-6
ON_LINE_M = 1e-4  # corners this close to an edge's line are its own


@dataclass(frozen=True)
class Chains:
    """C sequences of edges of one face.

    Attributes:
        edge: (C, N) wedges in the order met, -1 padded.
        count: (C,) edges met.
        core: (C,) slot of the edge that is met at one of its ends; -1 where every edge is met at its apex.
        part: (C,) START or END of that edge; APEX without one.
    """

    edge: Ints
    count: Ints
    core: Ints
    part: Ints

    def __len__(self) -> int:
        return len(self.count)

    def __getitem__(self, index: NDArray) -> Chains:
        return Chains(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


def merge_chains(parts: list[Chains]) -> Chains:
    """All parts as one set, in order; empty without parts."""
    none = np.zeros(0, dtype=np.int64)
    parts = [Chains(np.zeros((0, LONGEST), dtype=np.int64), none, none, none), *parts]
    return Chains(*(np.concatenate([getattr(part, n) for part in parts]) for n in Chains.__dataclass_fields__))


def panels_of(wedges: Wedges) -> list[Ints]:
    """Wedges of every convex face of a thin panel: two to `MOST_EDGES` of three wavelengths or more."""
    thin = (wedges.patch[:, 0] == wedges.patch[:, 1]) & (wedges.open_angle_rad > 2.0 * np.pi - FLAT_RAD)
    groups = [np.flatnonzero(thin & (wedges.patch[:, 0] == patch)) for patch in np.unique(wedges.patch[thin, 0])]
    return [group for group in groups if 1 < len(group) <= MOST_EDGES and _whole(wedges[group])]


def chains_of(wedges: Wedges, panel: Ints, longest: int) -> Chains:
    """Chains of up to `longest` edges of one panel: all at their apexes, or one of them at an end that is a corner."""
    own, linked = _own_corners(wedges[panel]), linked_edges(wedges[panel])
    rows: list[tuple[list[int], int, int]] = []
    for count in range(2, longest + 1):
        for chain in product(range(len(panel)), repeat=count):
            if not all(linked[a, b] for a, b in pairwise(chain)):
                continue
            edges = list(panel[list(chain)])
            rows.append((edges, -1, APEX))
            for core, part in product(range(count), (START, END)):
                if max(core, count - 1 - core) > 1:
                    continue
                beside = [chain[slot] for slot in (core - 1, core + 1) if 0 <= slot < count]
                foreign = not own[beside, chain[core], part - START].any()
                if foreign and wedges.radiates[edges[core], part - START]:
                    rows.append((edges, core, part))
    edge = np.array([chain + [-1] * (LONGEST - len(chain)) for chain, _, _ in rows]).reshape(-1, LONGEST)
    slot, which = (np.array([row[n] for row in rows], dtype=np.int64) for n in (1, 2))
    return Chains(edge.astype(np.int64), (edge >= 0).sum(axis=1), slot, which)


def linked_edges(wedges: Wedges) -> Flags:
    """(W, W) whether sound runs over the face from one edge of a panel to another: never along their common line."""
    same = _own_corners(wedges).all(axis=2)
    return np.asarray(~(same | same.T))


def _whole(wedges: Wedges) -> bool:
    """Whether no edge is short, and no corner lies outside any of them."""
    corners = np.concatenate([wedges.start_m, wedges.end_m])
    inside = np.einsum("wcx,wx->wc", corners[None] - wedges.start_m[:, None], wedges.inwards)
    return bool((wedges.length_m >= SHORTEST_M).all() and (inside > -ON_LINE_M).all())


def _own_corners(wedges: Wedges) -> Flags:
    """(W, W, 2) whether the start and the end of the second edge lie on the line of the first."""
    corners = np.stack([wedges.start_m, wedges.end_m], axis=1)
    off = np.einsum("vcwx,wx->wvc", corners[:, :, None] - wedges.start_m[None, None], wedges.inwards)
    return np.abs(off) < ON_LINE_M
