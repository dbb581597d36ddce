"""Paths that geometry allows, before anything stands in their way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints, Strings
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import norm
from simulator.waves.spreading import spreading
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

ON_PLANE_M = 1e-9
FOCUS_GAIN = 4.0  # a mirror this much stronger than a plane focuses on the receiver, where ray theory ends
KINDS = np.array(["specular", "curved", "edge", "kirchhoff", "direct"])  # by interaction; -1 is the last


@dataclass(frozen=True)
class Candidates(Rows):
    """Geometrically possible paths, world frame.

    Attributes:
        pose, mic, order: (C,).
        sequence: (C, N) numbers of the reflectors met (`interactions.Numbering`), -1 padded.
        interaction: (C, N) what happens at each (`interactions.Interaction`), -1 padded.
        points_m: (C, N + 2, 3) source, reflection points, receiver (repeated to the end of the row).
        normal: (C, N, 3) unit normals on the incident side.
        curvature: (C, N, 3, 3) curvature tensors, 0 for planes.
        standoff_m: (C, N) how far the true surface may stand off its mesh there.
        face, uv: (C, N), (C, N, 2) places on the smooth surfaces; -1 where none is met.
        edge: (C,) sharp edge, -1 without one.
        part: (C,) edge_view.APEX, START or END of that edge, or of the edges of a chain; -1 without one.
        cell: (C,) cell of a body by Kirchhoff's integral, or a chain of edges: both carry gains worked out
            beforehand. -1 for all others.
        share: (C,) of the echo that is its own, where rays and Kirchhoff's integral share it; else 1.

    No array is ever written again: what differs is made anew.
    """

    pose: Ints
    mic: Ints
    order: Ints
    sequence: Ints
    interaction: Ints
    points_m: Floats
    normal: Floats
    curvature: Floats
    standoff_m: Floats
    face: Ints
    uv: Floats
    edge: Ints
    part: Ints
    cell: Ints
    share: Floats

    @property
    def length_m(self) -> Floats:
        """(C,) of the path."""
        return norm(np.diff(self.points_m, axis=1)).sum(axis=1)

    @property
    def amplitude(self) -> Floats:
        """(C,) spreading of the ray tube alone: no air, no material, no edge."""
        return np.abs(spreading(self.points_m, self.normal, self.curvature, self.order))

    @property
    def trusted_amplitude(self) -> Floats:
        """(C,) the same, no more than a focus is trusted with."""
        return np.minimum(self.amplitude, FOCUS_GAIN / self.length_m)

    @property
    def kind(self) -> Strings:
        """(C,) "direct", "specular", "curved", "edge", "kirchhoff", or "mixed" for one of the latter among others."""
        kind = KINDS[self.interaction.max(axis=1, initial=-1)]
        return np.where((self.order > 1) & (kind != "specular"), "mixed", kind)


def concatenated(parts: list[Candidates]) -> Candidates:
    """All parts, one after the other, as wide as the widest of them."""
    width = max(part.sequence.shape[1] for part in parts)
    wide = [_widened(part, width) for part in parts]
    return Candidates.joined(wide)


def _widened(found: Candidates, width: int) -> Candidates:
    """The same with room for more reflections."""
    more = width - found.sequence.shape[1]
    if more == 0:
        return found
    wide = {"points_m": np.repeat(found.points_m[:, -1:], more, axis=1)}
    for name in ("sequence", "interaction", "normal", "curvature", "standoff_m", "face", "uv"):
        column = getattr(found, name)
        blank = -1 if name in ("sequence", "interaction", "face") else 0
        wide[name] = np.full((len(found), more, *column.shape[2:]), blank, dtype=column.dtype)
    return replace(found, **{name: np.concatenate([getattr(found, name), part], axis=1) for name, part in wide.items()})


def loudest_of(parts: list[Candidates], poses: int) -> Floats:
    """(N, 2) greatest amplitude of any candidate at each pose and microphone, edges apart; 0 without one."""
    loudest = np.zeros((poses, 2))
    for found in parts:
        np.maximum.at(loudest, (found.pose, found.mic), found.trusted_amplitude)
    return loudest


def nothing(width: int) -> Candidates:
    """No candidates, of up to `width` reflections."""
    none, shape = np.zeros(0, dtype=np.int64), (0, width)
    return Candidates(
        none, none, none, np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64), np.zeros((0, width + 2, 3)),
        np.zeros((*shape, 3)), np.zeros((*shape, 3, 3)), np.zeros(shape), np.zeros(shape, dtype=np.int64),
        np.zeros((*shape, 2)), none, none, none, np.zeros(0),
    )  # fmt: skip


def joined(parts: list[Candidates]) -> Candidates:
    """All parts, sorted by pose, microphone, order and sequence: the order in which they are summed."""
    whole = concatenated(parts)
    keys = tuple(whole.sequence.T[::-1]) + (whole.order, whole.mic, whole.pose)
    return whole[np.lexsort((whole.cell, whole.part, *whole.face.T[::-1], *keys))]


def direct(tracing: Tracing, width: int) -> Candidates:
    """The straight way from speaker to microphones."""
    pose, mic = np.divmod(np.arange(2 * len(tracing.source_m)), 2)
    return candidates(tracing, pose, mic, np.full((len(pose), width), -1), np.zeros((len(pose), width, 3)))


def candidates(tracing: Tracing, pose: Ints, mic: Ints, sequence: Ints, hits: Floats) -> Candidates:
    """Candidates without normals from sequences (C, N), -1 padded, and reflection points (C, N, 3)."""
    count, width = sequence.shape
    order = (sequence >= 0).sum(axis=1)
    receiver = tracing.mics_m[pose, mic]
    points = np.repeat(receiver[:, None], width + 2, axis=1)
    points[:, 0] = tracing.source_m[pose]
    for k in range(width):
        reflects = order > k
        points[reflects, 1 + k] = hits[reflects, k]
    return Candidates(
        pose, mic, order, sequence, tracing.world.numbering.interaction(sequence), points, np.zeros((count, width, 3)),
        np.zeros((count, width, 3, 3)), np.zeros((count, width)), np.full((count, width), -1),
        np.zeros((count, width, 2)), np.full(count, -1), np.full(count, -1), np.full(count, -1),
        np.ones(count),
    )  # fmt: skip


def with_plane_normals(tracing: Tracing, found: Candidates) -> Candidates:
    """The same with the normals of the planar reflections, on the incident side."""
    normals = found.normal.copy()
    for k in range(found.sequence.shape[1]):
        flat = np.flatnonzero(found.interaction[:, k] == Interaction.SPECULAR)
        normal = tracing.mirrors.normal[found.pose[flat], found.sequence[flat, k]]
        arriving, leaving = (
            np.sum(normal * (found.points_m[flat, k + 1 + i] - found.points_m[flat, k + i]), axis=1) for i in (0, 1)
        )
        arriving = np.where(np.abs(arriving) > ON_PLANE_M, arriving, -leaving)  # after the end of an edge on the plane
        normals[flat, k] = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    return replace(found, normal=normals)
