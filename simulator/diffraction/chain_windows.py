"""Chains of edges of a thin panel by the windows in which they are met, and the paths that stand for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.chain_paths import ChainPaths
from simulator.diffraction.edge_nodes import WINDOWS
from simulator.diffraction.edge_view import APEX, END, START, at_poses
from simulator.diffraction.thin_panels import linked_edges
from simulator.surfaces.wedges import Wedges
from simulator.world.world import Tracing

ROUNDS = 32  # over the middles of a path, each put where its neighbours make the path shortest
EDGE_PARTS = (APEX, START, END)
IN_WINDOWS = 3  # of longer chains only the first and the last edge are told apart by windows


@dataclass(frozen=True)
class Windowed(Rows):
    """T chains of up to N edges of one panel, sorted by their number, window by window.

    Attributes:
        edge: (T, N) numbers among the panel's edges, -1 padded.
        part: (T, N) window: APEX for the middle, START or END. APEX also where an edge between the first and the last
            of more than three counts over its full length.
    """

    edge: Ints
    part: Ints

    @property
    def count(self) -> Ints:
        """(T,) edges met."""
        return (self.edge >= 0).sum(axis=1)

    def ends(self) -> tuple[Ints, Ints]:
        """(T,) first and last edge with its window, as one number."""
        each, last = np.arange(len(self)), self.count - 1
        return WINDOWS * self.edge[:, 0] + self.part[:, 0], WINDOWS * self.edge[each, last] + self.part[each, last]


def windowed_chains(wedges: Wedges, longest: int) -> Windowed:
    """All chains of two to `longest` linked edges in all windows, but at ends that are no corners."""
    linked, edges = linked_edges(wedges), np.arange(len(wedges))
    there = np.concatenate([np.ones((len(wedges), 1), dtype=bool), wedges.radiates], axis=1)  # in order of EDGE_PARTS
    met, parts = [], []
    for count in range(2, longest + 1):
        chain = _every([edges] * count)
        chain = chain[linked[chain[:, :-1], chain[:, 1:]].all(axis=1)]
        between = [(APEX,)] * (count - 2) if count > IN_WINDOWS else [EDGE_PARTS] * (count - 2)
        part = _every([EDGE_PARTS, *between, EDGE_PARTS])
        chain, part = np.repeat(chain, len(part), axis=0), np.tile(part, (len(chain), 1))
        rows, pad = there[chain, part].all(axis=1), ((0, 0), (0, longest - count))
        met.append(np.pad(chain[rows], pad, constant_values=-1))
        parts.append(np.pad(part[rows], pad))
    return Windowed(np.concatenate(met), np.concatenate(parts))


def _every(choices: list) -> Ints:
    """(T, N) all combinations of one of each."""
    return np.stack(np.meshgrid(*choices, indexing="ij"), axis=-1).reshape(-1, len(choices))


def paths_of(tracing: Tracing, panel: Ints, table: Windowed, pose: Ints, mic: Ints) -> ChainPaths:
    """The paths through the corners, and the points of the middles that make them shortest; one a row of the table."""
    chain, width = np.where(table.edge >= 0, panel[table.edge], -1), table.edge.shape[1]
    points = np.repeat(tracing.mics_m[pose, mic][:, None], width + 2, axis=1)
    points[:, 0] = tracing.source_m[pose]
    slots = [np.flatnonzero(table.count > slot) for slot in range(width)]
    wedges = [at_poses(tracing, chain[rows, slot], pose[rows]) for slot, rows in enumerate(slots)]
    for slot, (rows, edge) in enumerate(zip(slots, wedges, strict=True)):
        share = np.array([0.5, 0.0, 1.0])[table.part[rows, slot], None]
        points[rows, slot + 1] = edge.start_m + share * (edge.end_m - edge.start_m)
    for _ in range(ROUNDS):
        for slot, (rows, edge) in enumerate(zip(slots, wedges, strict=True)):
            free = np.flatnonzero(table.part[rows, slot] == APEX)
            some = rows[free]
            points[some, slot + 1] = _shortest(edge[free], points[some, slot], points[some, slot + 2])
    return ChainPaths(pose, mic, chain, points)


def _shortest(wedges: Wedges, source_m: Floats, receiver_m: Floats) -> Floats:
    """(R, 3) point of each edge that makes the path between its neighbours shortest; ends on its line may meet it."""
    along, start = wedges.along, wedges.start_m
    height = [dot(point - start, along) for point in (source_m, receiver_m)]
    radius = [norm(point - start - h[:, None] * along) for point, h in zip((source_m, receiver_m), height, strict=True)]
    total = np.maximum(radius[0] + radius[1], 1e-300)
    apex = height[0] + (height[1] - height[0]) * radius[0] / total
    return start + np.clip(apex, 0.0, wedges.length_m)[:, None] * along
