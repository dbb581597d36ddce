"""The straight parts of unfolded rays, and what is ahead and across of each, mirrored from one to the next."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.single import point_slot
from simulator.images.given_planes import mirrored
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest, rotated
from simulator.world.interactions import Interaction
from simulator.world.visibility import COINCIDENT_M

STRAIGHT = 1e-6  # sine of the turn under which a path goes straight on


class Segments(NamedTuple):
    """The straight parts of unfolded rays, ray by ray; a tuple of arrays, as compiled functions take it.

    Attributes:
        ray: (Q,) rising.
        start_m, end_m: (Q, 3).
        ahead: (Q, 3) unit vector along each.
        across: (Q, 2, 3) unit vectors at right angles to it.
        facing: (Q, 2, 3) normals of the mirrors at its start and end: what lies behind them is not in its way; 0 at the
            ends of the ray.
        before_m, total_m: (Q,) length of the ray up to each, and of all of it.
    """

    ray: Ints
    start_m: Floats
    end_m: Floats
    ahead: Floats
    across: Floats
    facing: Floats
    before_m: Floats
    total_m: Floats

    def taken(self, rows: Ints) -> Segments:
        """Some of them, by their numbers."""
        return Segments._make(column.take(rows, axis=0) for column in self)


def segments_of(found: Candidates) -> Segments:
    """All segments of paths; what is ahead and across is mirrored from one to the next.

    Edges send it on as a mirror would whose plane is square to the turn of the path.
    """
    count, width = found.sequence.shape
    step = norm(np.diff(found.points_m, axis=1))
    before = np.cumsum(step, axis=1) - step
    ahead = _directions(found, step)
    normal = _turning_planes(found, ahead)
    axes = np.empty((count, width + 1, 3, 3))
    axes[:, 0, 0] = ahead[:, 0]
    axes[:, 0, 1] = _square_to(axes[:, 0, 0])
    axes[:, 0, 2] = np.cross(axes[:, 0, 0], axes[:, 0, 1])
    facing = np.zeros((count, width + 2, 3))
    facing[:, 1:-1] = normal
    for turn in range(width):
        across = 2.0 * dot(axes[:, turn], normal[:, None, turn])
        axes[:, turn + 1] = axes[:, turn] - across[..., None] * normal[:, None, turn]
    axes[..., 1:, :] = _half_way_to_the_end(axes, found.order)
    ray, k = np.nonzero(np.arange(width + 1) <= found.order[:, None])
    return Segments(
        ray, found.points_m[ray, k], found.points_m[ray, k + 1], axes[ray, k, 0], axes[ray, k, 1:],
        np.stack([facing[ray, k], facing[ray, k + 1]], axis=1), before[ray, k], step.sum(axis=1)[ray],
    )  # fmt: skip


def _square_to(ahead: Floats) -> Floats:
    """(C, 3) unit vectors across (C, 3) others: level ones, unless these are upright."""
    upright = np.abs(ahead[:, 2:]) > 0.9
    across = np.cross(ahead, np.where(upright, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    return across / norm(across)[:, None]


def _half_way_to_the_end(axes: Floats, order: Ints) -> Floats:
    """(C, N + 1, 2, 3) what is across, half-way from `_square_to` of the first segments to that of the last ones.

    A path and its reverse then have the same directions about them, and lose the same.
    """
    last = axes[np.arange(len(axes)), order]
    end = _square_to(last[:, 0])
    half = 0.5 * np.arctan2(dot(end, last[:, 2]), dot(end, last[:, 1]))[:, None, None]
    one, other = axes[..., 1, :], axes[..., 2, :]
    return np.stack([np.cos(half) * one + np.sin(half) * other, np.cos(half) * other - np.sin(half) * one], axis=2)


def _directions(found: Candidates, length_m: Floats) -> Floats:
    """(C, N + 1, 3) unit vectors along the segments of paths.

    Args:
        length_m: (C, N + 1) of the segments. Where the speaker lies on the first mirror, or the end of an edge on one,
            a segment is nothing: its direction is that of the next one as the mirror shows it.
    """
    width, at, normal = found.sequence.shape[1], point_slot(found), found.normal
    ahead = np.diff(found.points_m, axis=1) / np.maximum(length_m, 1e-300)[..., None]
    nothing = (length_m < COINCIDENT_M) & (np.arange(width + 1) <= found.order[:, None])
    for k in range(1, width + 1):
        rows = np.flatnonzero(nothing[:, k] & (k <= at))
        ahead[rows, k] = mirrored(ahead[rows, k - 1], normal[rows, k - 1], np.zeros(len(rows)))
    for k in reversed(range(width)):
        rows = np.flatnonzero(nothing[:, k] & ((k > at) | (k == 0)))
        ahead[rows, k] = mirrored(ahead[rows, k + 1], normal[rows, k], np.zeros(len(rows)))
    return ahead


def _turning_planes(found: Candidates, ahead: Floats) -> Floats:
    """(C, N, 3) unit normals of the mirrors, and at edges of the planes whose mirrors would bend a path as they do."""
    turn = np.diff(ahead, axis=1)
    size = norm(turn)
    over = (found.interaction == Interaction.EDGE)[..., None]
    return np.where(over, turn / np.where(size > STRAIGHT, size, np.inf)[..., None], found.normal)


def at_rest(segments: Segments, frame: Floats) -> Segments:
    """Segments (G,) as seen in rest frames (G, 4)."""
    yaw = -frame[:, 3]
    return segments._replace(
        start_m=into_rest(segments.start_m, frame),
        end_m=into_rest(segments.end_m, frame),
        ahead=rotated(segments.ahead, yaw),
        across=rotated(segments.across, yaw[:, None]),
        facing=rotated(segments.facing, yaw[:, None]),
    )
