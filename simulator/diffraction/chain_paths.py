"""Paths over chains of a thin panel's edges: their points, what hides them, and the candidates that they make."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import norm
from simulator.diffraction.edge_view import APEX, at_poses, seen
from simulator.diffraction.single import clear_of_faces
from simulator.world.candidates import Candidates, candidates
from simulator.world.interactions import Interaction
from simulator.world.line_of_sight import free_between
from simulator.world.rejection_log import Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing


@dataclass(frozen=True)
class ChainPaths(Rows):
    """R paths over chains of edges.

    Attributes:
        pose, mic: (R,).
        edge: (R, N) wedges in the order met, -1 padded.
        points_m: (R, N + 2, 3) speaker, points on up to N edges, microphone (repeated).
    """

    pose: Ints
    mic: Ints
    edge: Ints
    points_m: Floats

    @property
    def count(self) -> Ints:
        """(R,) edges met."""
        return (self.edge >= 0).sum(axis=1)

    @property
    def segments_m(self) -> Floats:
        """(R, N + 1) lengths between the points."""
        return norm(np.diff(self.points_m, axis=1))


def free_of_obstacles(tracing: Tracing, paths: ChainPaths) -> Flags:
    """(R,) whether nothing stands between the phone and the first and last points."""
    each, last = np.arange(len(paths)), paths.count - 1
    free = np.ones(len(paths), dtype=bool)
    for slot, end in ((np.zeros_like(last), 0), (last, -1)):
        phone, point = paths.points_m[:, end], paths.points_m[each, slot + 1]
        wedges = at_poses(tracing, paths.edge[each, slot], paths.pose)
        outwards = clear_of_faces(wedges, seen(wedges, phone, phone).source_angle_rad)
        point = point + tracing.world.clear_m * outwards
        free &= free_between(tracing, phone, point, paths.pose, tracing.world.blockers)
    return free


def rejected_paths(search: Search, paths: ChainPaths, bound: Floats) -> Rejected:
    """Rejected paths, for the log."""
    return Rejected(bound, lambda chosen: candidates_over(search, paths[chosen]))


def candidates_over(search: Search, paths: ChainPaths) -> Candidates:
    """Candidates through the points of paths, each a cell of its own."""
    most = int(paths.count.max(initial=0))
    shape = len(paths), max(search.max_order, most)
    sequence, hits = np.full(shape, -1), np.zeros((*shape, 3))
    met = paths.edge[:, :most]
    sequence[:, :most] = np.where(met >= 0, search.tracing.world.numbering.number(Interaction.EDGE, met), -1)
    hits[:, :most] = paths.points_m[:, 1 : 1 + most]
    found = candidates(search.tracing, paths.pose, paths.mic, sequence, hits)
    return replace(found, cell=np.arange(len(found)), part=np.full(len(found), APEX))


def face_factor(tracing: Tracing, paths: ChainPaths, frequency_hz: Floats) -> Complexes:
    """(R, K) loss of the segments along faces to their materials: none if rigid, all if pressure vanishes there."""
    factor = np.ones((len(paths), len(frequency_hz)), dtype=np.complex128)
    obstacle = tracing.world.wedges.obstacle[paths.edge[:, 0]]
    for index in np.unique(obstacle):
        rows = np.flatnonzero(obstacle == index)
        reflection = tracing.world.obstacles[index].material.reflection(frequency_hz, np.ones((1, 1)))
        factor[rows] = (0.5 + 0.5 * reflection) ** (paths.count[rows, None] - 1)
    return factor
