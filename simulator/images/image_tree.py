"""Images of points in sequences of mirrors: one walk, whatever the images are made for.

Level by level over arrays: each image is mirrored in every patch that sound can go on to. A patch that cannot be lit
through the one before it, or from which the goal is out of reach, is passed over with all that would lie behind it.
Who walks picks the images that light an end of his own: a microphone (`planar`), a body (`body_images`), an edge
(`edge_images`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numba
import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.images.image_pruning import dot, far_or_aside, grown
from simulator.world.mirrors import Mirrors

TRIED_AT_ONCE = 2**18  # images times patches: what is kept in memory of a level, however many sequences there are


@dataclass(frozen=True)
class Images:
    """Images of one point per pose in sequences of patches.

    Attributes:
        pose: (I,) sorted.
        order: (I,) number of mirrors.
        sequence: (I, N) patches from the point on, -1 padded.
        point_m: (I, 3) the image.
    """

    pose: Ints
    order: Ints
    sequence: Ints
    point_m: Floats

    def __len__(self) -> int:
        return len(self.pose)

    def __getitem__(self, index: NDArray) -> Self:
        return type(self)(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class Level:
    """Images of one order.

    Attributes:
        order: number of mirrors.
        pose: (I,).
        sequence: (I, N) patches from the point on, -1 padded.
        images_m: (I, N + 1, 3) the point, then its images in one mirror after the other; 0 padded.
    """

    order: int
    pose: Ints
    sequence: Ints
    images_m: Floats

    def __len__(self) -> int:
        return len(self.pose)

    def __getitem__(self, index: NDArray | slice) -> Level:
        return Level(self.order, self.pose[index], self.sequence[index], self.images_m[index])

    def lit(self, index: Ints) -> tuple[Ints, Ints, Ints, Floats]:
        """Chosen rows as the columns of `Images`."""
        order = np.full(len(index), self.order)
        return self.pose[index], order, self.sequence[index], self.images_m[index, self.order]


@dataclass(frozen=True)
class Goal:
    """What images are made for.

    Attributes:
        center_m, radius_m: (N, 3) and one ball a pose, somewhere in which sound is to arrive.
        limit_m: longest way, the part within the ball apart.
    """

    center_m: Floats
    radius_m: float
    limit_m: float


def image_levels(mirrors: Mirrors, allowed: Flags, point_m: Floats, max_order: int, goal: Goal) -> Iterator[Level]:
    """Images of (N, 3) points, one a pose, in up to `max_order` mirrors, each in one of the levels that come.

    The points themselves come first. An image may lie where its last mirror shows it to nobody.

    Args:
        allowed: (P,) patches that count as mirrors.
    """
    images = np.zeros((len(point_m), max_order + 1, 3))
    images[:, 0] = point_m
    level = Level(0, np.arange(len(point_m)), np.full((len(point_m), max_order), -1), images)
    at_once = max(1, TRIED_AT_ONCE // max(len(allowed), 1))
    yield level
    waiting = [level]
    while waiting:
        level = waiting.pop()
        if level.order == max_order or len(level) == 0:
            continue
        waiting.append(level[at_once:])
        level = _next_level(mirrors, allowed, level[:at_once], goal)
        yield level
        waiting.append(level)


def _next_level(mirrors: Mirrors, allowed: Flags, level: Level, goal: Goal) -> Level:
    """Images of a level in one more mirror each."""
    columns = _mirrored(
        mirrors, allowed, level.order, level.pose, level.sequence, level.images_m,
        np.ascontiguousarray(goal.center_m), goal.radius_m, goal.limit_m,
    )  # type: ignore[call-arg]  # fmt: skip
    return Level(level.order + 1, *columns)


@numba.njit(cache=True)
def _mirrored(mirrors, allowed, depth, pose, sequence, images, goal, goal_radius, limit):
    """Columns of the level after `depth` mirrors."""
    size = max(256, len(pose))
    poses, sequences = np.empty(size, np.int64), np.empty((size, sequence.shape[1]), np.int64)
    points = np.empty((size,) + images.shape[1:])
    found = 0
    for r in range(len(pose)):
        n, before = pose[r], images[r, depth]
        last = sequence[r, max(depth - 1, 0)]
        for p in range(len(allowed)):
            if not allowed[p] or (depth > 0 and not mirrors.follows[last, p]):
                continue
            normal, center, radius = mirrors.normal[n, p], mirrors.center_m[n, p], mirrors.radius_m[p]
            height = dot(before, normal) - mirrors.offset_m[n, p]
            if height == 0.0 or (depth == 0 and mirrors.one_sided[p] and height < 0.0):
                continue
            window, window_radius = center, 0.0
            if depth > 0:
                window, window_radius = mirrors.center_m[n, last], mirrors.radius_m[last]
            if far_or_aside(before, center, radius, window, window_radius, goal[n], goal_radius, limit):
                continue
            if found == len(poses):
                poses, sequences, points = grown(poses), grown(sequences), grown(points)
            poses[found], sequences[found], points[found] = n, sequence[r], images[r]
            sequences[found, depth] = p
            for x in range(3):
                points[found, depth + 1, x] = before[x] - 2.0 * height * normal[x]
            found += 1
    return poses[:found], sequences[:found], points[:found]


def in_turn(pose: Ints, sequence: Ints, *minor: Ints) -> Ints:
    """(I,) order of rows by pose, then `minor`, then sequence: the shorter of two that begin alike comes first."""
    return np.lexsort((*sequence.T[::-1], *minor, pose))
