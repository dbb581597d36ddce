"""Ways over chains of a thin panel's edges: their points, what hides them, and the candidates that they make."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.diffraction.single import at_poses, clear_of_faces, seen
from simulator.diffraction.thin_panels import Chains, merge_chains
from simulator.world.candidates import Candidates, candidates
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Rejected
from simulator.world.search_context import Search
from simulator.world.sight import free_between
from simulator.world.visibility import OFFSET
from simulator.world.world import Tracing


@dataclass(frozen=True)
class Ways:
    """R ways over chains of edges.

    Attributes:
        pose, mic: (R,).
        chain: the chains met.
        points_m: (R, N + 2, 3) speaker, points on up to N edges, microphone (repeated).
    """

    pose: Ints
    mic: Ints
    chain: Chains
    points_m: Floats

    def __len__(self) -> int:
        return len(self.pose)

    def __getitem__(self, index: NDArray) -> Ways:
        return Ways(self.pose[index], self.mic[index], self.chain[index], self.points_m[index])

    @property
    def legs_m(self) -> Floats:
        """(R, N + 1) lengths between the points."""
        return np.linalg.norm(np.diff(self.points_m, axis=1), axis=2)


def joined_ways(parts: list[Ways]) -> Ways:
    """All parts as one set, in order."""
    return Ways(
        np.concatenate([part.pose for part in parts]), np.concatenate([part.mic for part in parts]),
        merge_chains([part.chain for part in parts]),
        np.concatenate([part.points_m for part in parts]),
    )  # fmt: skip


def free_of_obstacles(tracing: Tracing, ways: Ways) -> Flags:
    """(R,) whether nothing stands between the phone and the first and last points."""
    extent = max((shadow.extent_m for shadow in tracing.world.blockers), default=1.0)
    each, last = np.arange(len(ways)), ways.chain.count - 1
    free = np.ones(len(ways), dtype=bool)
    for slot, end in ((np.zeros_like(last), 0), (last, -1)):
        phone, point = ways.points_m[:, end], ways.points_m[each, slot + 1]
        wedges = at_poses(tracing, ways.chain.edge[each, slot], ways.pose)
        lift = clear_of_faces(wedges, seen(wedges, phone, phone).source_angle_rad)
        free &= free_between(tracing, phone, point + OFFSET * extent * lift, ways.pose)
    return free


def rejected_ways(search: Search, ways: Ways, bound: Floats) -> Rejected:
    """Rejected ways, for the log."""
    return Rejected(bound, lambda chosen: candidates_over(search, ways[chosen]))


def candidates_over(search: Search, ways: Ways) -> Candidates:
    """Candidates through the points of ways, each a cell of its own."""
    most = int(ways.chain.count.max(initial=0))
    shape = len(ways), max(search.max_order, most)
    sequence, hits = np.full(shape, -1), np.zeros((*shape, 3))
    met = ways.chain.edge[:, :most]
    sequence[:, :most] = np.where(met >= 0, search.tracing.world.numbering.number(Interaction.EDGE, met), -1)
    hits[:, :most] = ways.points_m[:, 1 : 1 + most]
    found = candidates(search.tracing, ways.pose, ways.mic, sequence, hits)
    return replace(found, cell=np.arange(len(found)))


def face_factor(tracing: Tracing, ways: Ways, frequency_hz: Floats) -> Complexes:
    """(R, K) what the legs along faces lose to their materials: nothing if rigid, all if pressure vanishes there."""
    factor = np.ones((len(ways), len(frequency_hz)), dtype=np.complex128)
    obstacle = tracing.world.wedges.obstacle[ways.chain.edge[:, 0]]
    for index in np.unique(obstacle):
        rows = np.flatnonzero(obstacle == index)
        reflection = tracing.world.obstacles[index].material.reflection(frequency_hz, np.ones((1, 1)))
        factor[rows] = (0.5 + 0.5 * reflection) ** (ways.chain.count[rows, None] - 1)
    return factor
