"""Images of points in sequences of mirrors: one walk, whatever the images are made for.

Level by level over arrays: each image is mirrored in every patch that sound can go on to. A patch that cannot be lit
through the one before it, or from which the goal is out of reach, is passed over with all that would lie behind it.
Who walks picks the images that light an end of his own: a microphone (`image_method`), a body or an edge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance, dot
from obstaclewatch.support.rows import Rows
from simulator.images.given_planes import fill_image
from simulator.surfaces.wedges import Wedges
from simulator.world.mirrors import FLUSH_M, Mirrors, lies_ahead

ROUNDING_M = 1e-5  # crossings this far outside a mirror's rectangle are tried: those on its border count
PENUMBRA_M = 0.4  # and those of paths to edges, which reach into shadows: 8 cm of detour where both ends are 2 m away
FLAT_M = 1e-9  # a rectangle seen at this height is a line and bounds nothing
TRIED_AT_ONCE = 2**18  # images times patches: what is kept in memory of a level, however many sequences there are


@dataclass(frozen=True)
class Images(Rows):
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


@dataclass(frozen=True)
class EdgeImages(Images):
    """One row for each edge that an image can light, sorted by pose, then wedge.

    Attributes:
        wedge: (I,).
    """

    wedge: Ints


class Level(NamedTuple):
    """Images of one order; a tuple of arrays, as compiled functions take it.

    Attributes:
        order: number of mirrors.
        pose: (I,).
        sequence: (I, N) patches from the point on, -1 padded.
        images_m: (I, N + 1, 3) the point, then its images in one mirror after the other; 0 padded.
        beam: (I, N, 4, 3) normals, inwards, of the planes through the last image that bound what is seen of it through
            each mirror, as the later ones show it; 0 where there is no bound.
    """

    order: int
    pose: Ints
    sequence: Ints
    images_m: Floats
    beam: Floats

    def taken(self, rows: Ints | slice) -> Level:
        """Some of them."""
        return Level(self.order, self.pose[rows], self.sequence[rows], self.images_m[rows], self.beam[rows])

    def lit(self, index: Ints) -> tuple[Ints, Ints, Ints, Floats]:
        """Chosen rows as the columns of `Images`."""
        order = np.full(len(index), self.order)
        return self.pose[index], order, self.sequence[index], self.images_m[index, self.order]


class Goal(NamedTuple):
    """What images are made for; a tuple, as compiled functions take it.

    Attributes:
        center_m, radius_m: (N, 3) and one ball a pose, somewhere in which sound is to arrive.
        limit_m: longest way, the part within the ball apart.
        beside_m: how far outside a mirror's rectangle a path may cross its plane.
    """

    center_m: Floats
    radius_m: float
    limit_m: float
    beside_m: float = ROUNDING_M


class _Edges(NamedTuple):
    """W edges that images are to light.

    Attributes:
        start_m, end_m: (N, W, 3) at each pose.
        patch: (W, 2) of their faces.
        mirror: (W,) patch that a crease shows itself in.
        obstacle: (W,) whose.
    """

    start_m: Floats
    end_m: Floats
    patch: Ints
    mirror: Ints
    obstacle: Ints


def images_lighting(mirrors: Mirrors, allowed: Flags, point_m: Floats, goal: Goal) -> Images:
    """Images of (N, 3) points, one a pose, that see some of the goal within the limit, through their last mirror.

    Args:
        allowed: (most, P) as in `image_levels`.
    """
    parts = []
    for level in image_levels(mirrors, allowed, point_m, goal):
        lit = np.flatnonzero(_lit_balls(mirrors, level, goal))  # type: ignore[call-arg]
        parts.append(Images(*level.lit(lit)))
    found = Images.joined(parts)
    return found[in_turn(found.pose, found.sequence)]


def images_lighting_edges(
    mirrors: Mirrors, wedges: Wedges, start_m: Floats, end_m: Floats, allowed: Flags, towards: Flags, point_m: Floats,
    limit_m: float,
) -> EdgeImages:  # fmt: skip
    """Images of (N, 3) points, one a pose, that see some of an edge within the limit, through their last mirror.

    Args:
        start_m, end_m: (N, W, 3) ends of the wedges at each pose.
        allowed: (most, P) as in `image_levels`.
        towards: (P, O) patches that may be met, where there are several, on the way to the edges of each obstacle.
    """
    # what is nearer than the limit may have an edge
    goal = Goal(np.ascontiguousarray(point_m), limit_m, limit_m, PENUMBRA_M)
    edges, parts = _Edges(start_m, end_m, wedges.patch, wedges.mirror, wedges.obstacle), []
    for level in image_levels(mirrors, allowed, point_m, goal):
        row, wedge = _lit_edges(mirrors, level, edges, towards, limit_m)  # type: ignore[call-arg]
        parts.append(EdgeImages(*level.lit(row), wedge))
    found = EdgeImages.joined(parts)
    return found[in_turn(found.pose, found.sequence, found.wedge)]


def image_levels(mirrors: Mirrors, allowed: Flags, point_m: Floats, goal: Goal) -> Iterator[Level]:
    """Images of (N, 3) points, one a pose, in up to so many mirrors, each in one of the levels that come.

    The points themselves come first. An image may lie where its last mirror shows it to nobody.

    Args:
        allowed: (most, P) patches that count as mirrors where an image is of that many.
    """
    max_order = len(allowed)
    images = np.zeros((len(point_m), max_order + 1, 3))
    images[:, 0] = point_m
    sequence, beam = np.full((len(point_m), max_order), -1), np.zeros((len(point_m), max_order, 4, 3))
    level = Level(0, np.arange(len(point_m)), sequence, images, beam)
    at_once = max(1, TRIED_AT_ONCE // max(allowed.shape[1], 1))
    yield level
    waiting = [level]
    while waiting:
        level = waiting.pop()
        if level.order == max_order or len(level.pose) == 0:
            continue
        waiting.append(level.taken(slice(at_once, None)))
        level = _next_level(mirrors, allowed[level.order], level.taken(slice(at_once)), goal)
        yield level
        waiting.append(level)


def _next_level(mirrors: Mirrors, allowed: Flags, level: Level, goal: Goal) -> Level:
    """Images of a level in one more mirror each."""
    level = level.taken(np.flatnonzero(allowed[level.sequence[:, : level.order]].all(axis=1)))
    row, patch = _onwards(mirrors, allowed, level, goal)  # type: ignore[call-arg]
    found = level.taken(row)
    found.sequence[:, level.order] = patch
    _mirror(mirrors, patch, found, goal.beside_m)  # type: ignore[call-arg]
    return found._replace(order=level.order + 1)


def in_turn(pose: Ints, sequence: Ints, *minor: Ints) -> Ints:
    """(I,) order of rows by pose, then `minor`, then sequence: the shorter of two that begin alike comes first."""
    return np.lexsort((*sequence.T[::-1], *minor, pose))


@compiled
def _mirror(mirrors, patch, level, beside):
    """Fill in the images of a level behind given patches, and their beams."""
    depth, pose, images, beam = level.order, level.pose, level.images_m, level.beam
    for r in range(len(pose)):
        n, p = pose[r], patch[r]
        normal = mirrors.normal[n, p]
        fill_image(images[r, depth], normal, mirrors.offset_m[n, p], images[r, depth + 1])
        for k in range(depth):
            for side in range(4):
                fill_image(beam[r, k, side], normal, 0.0, beam[r, k, side])
        wide = max(beside, PENUMBRA_M) if mirrors.endless[p] else beside
        bound(images[r, depth + 1], mirrors.corner_m[n, p], wide, beam[r, depth])


@compiled
def _onwards(mirrors, allowed, level, goal):
    """(R,) image of a level and (R,) patch of all that it is mirrored in."""
    depth, pose, sequence, images, beam = level
    rows, patches = np.empty(256, np.int64), np.empty(256, np.int64)
    found = 0
    for r in range(len(pose)):
        n, before = pose[r], images[r, depth]
        last = sequence[r, max(depth - 1, 0)]
        # that the image stands behind its mirror tells that the front reflects
        side = int(depth > 0 and dot(before, mirrors.normal[n, last]) > mirrors.offset_m[n, last])
        for p in range(len(allowed)):
            if not allowed[p]:
                continue
            height = dot(before, mirrors.normal[n, p]) - mirrors.offset_m[n, p]
            if (height == 0.0 and depth > 0) or (depth == 0 and mirrors.one_sided[p] and height < 0.0):
                continue
            center, radius = mirrors.center_m[n, p], mirrors.radius_m[p]
            gap = max(distance(before, center) - radius, 0.0)
            onwards = max(distance(goal.center_m[n], center) - radius - goal.radius_m, 0.0)
            if gap + onwards > goal.limit_m or aside(before, beam[r, :depth], mirrors.corner_m[n, p], 0.0):
                continue
            if depth > 0 and not (
                lies_ahead(mirrors.rest, side, last, p) and lies_ahead(mirrors.rest, int(height < 0.0), p, last)
            ):
                continue
            if found == len(rows):
                rows, patches = grown(rows), grown(patches)
            rows[found], patches[found] = r, p
            found += 1
    return rows[:found], patches[:found]


@compiled
def _lit_balls(mirrors, level, goal):
    """(I,) whether an image sees the ball, within the limit and, if it is one, through its mirrors."""
    order, pose, sequence, images, beam = level
    center, radius = goal.center_m, goal.radius_m
    out = np.zeros(len(pose), np.bool_)
    for r in range(len(pose)):
        n, image = pose[r], images[r, order]
        if distance(image, center[n]) - radius > goal.limit_m:
            continue
        out[r] = True
        if order > 0:
            p = sequence[r, order - 1]
            rise = dot(center[n], mirrors.normal[n, p]) - mirrors.offset_m[n, p]
            behind = mirrors.one_sided[p] and rise < -radius
            out[r] = not behind and not aside(image, beam[r, :order], center[n : n + 1], radius)
    return out


@compiled
def _lit_edges(mirrors, level, edges, towards, limit):
    """(R,) image and (R,) edge of all that can light an edge; a crease by its own mirror as by what comes before it."""
    order, pose, sequence, images, beam = level
    start, end, patch, own_mirror, obstacle = edges
    rows, wedges = np.empty(256, np.int64), np.empty(256, np.int64)
    middle, half = np.empty(start.shape), np.empty((start.shape[0], start.shape[1]))
    for n in range(half.shape[0]):
        for w in range(half.shape[1]):
            half[n, w] = 0.5 * distance(end[n, w], start[n, w])
            for x in range(3):
                middle[n, w, x] = 0.5 * (start[n, w, x] + end[n, w, x])
    ends = np.empty((2, 3))
    found = 0
    for r in range(len(pose)):
        n, image = pose[r], images[r, order]
        for w in range(start.shape[1]):
            if distance(image, middle[n, w]) - half[n, w] > limit:
                continue
            last = order - int(order > 0 and sequence[r, order - 1] == own_mirror[w])
            if last > 0:
                p = sequence[r, last - 1]
                if p == patch[w, 0] or p == patch[w, 1] or not _met(sequence[r, :order], towards, obstacle[w]):
                    continue
                for x in range(3):
                    ends[0, x], ends[1, x] = start[n, w, x], end[n, w, x]
                if not _beyond(mirrors, n, p, images[r, last], ends) or aside(image, beam[r, :last], ends, 0.0):
                    continue
            if found == len(rows):
                rows, wedges = grown(rows), grown(wedges)
            rows[found], wedges[found] = r, w
            found += 1
    return rows[:found], wedges[:found]


@inlined
def _met(sequence, towards, obstacle):
    """Whether all mirrors may be met on the way to an obstacle; one alone may always be."""
    small = 0
    for p in sequence:
        small += not towards[p, obstacle]
    return small == 0 or len(sequence) == 1


@inlined
def _beyond(mirrors, n, p, image, ends):
    """Whether some of an edge lies beyond a mirror as its image sees it."""
    normal, offset = mirrors.normal[n, p], mirrors.offset_m[n, p]
    side = -1.0 if dot(image, normal) - offset > 0.0 else 1.0
    return max(side * (dot(ends[0], normal) - offset), side * (dot(ends[1], normal) - offset)) > FLUSH_M


@inlined
def bound(image, corner, beside, beam):
    """Fill in (4, 3) normals, inwards, of the planes through an image and the sides of a rectangle, moved outwards."""
    one, other, across, normal = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for side in range(4):
        width = distance(corner[(side + 1) % 4], corner[(side + 2) % 4])
        for x in range(3):
            across[x] = corner[(side + 2) % 4, x] - corner[(side + 1) % 4, x]
            out = -beside * across[x] / width
            one[x] = corner[side, x] - image[x] + out
            other[x] = corner[(side + 1) % 4, x] - image[x] + out
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            normal[x] = one[y] * other[z] - one[z] * other[y]
        size, rise = np.sqrt(dot(normal, normal)), dot(normal, across)
        flat = abs(rise) <= FLAT_M * size
        for x in range(3):
            beam[side, x] = 0.0 if flat else normal[x] / (size if rise > 0.0 else -size)


@compiled
def aside(image, beam, point, radius):
    """Whether some plane of a beam leaves outside all points (Q, 3) and what is within a radius of them."""
    for k in range(len(beam)):
        for side in range(4):
            normal = beam[k, side]
            outside = normal[0] != 0.0 or normal[1] != 0.0 or normal[2] != 0.0
            for q in range(len(point)):
                rise = 0.0
                for x in range(3):
                    rise += (point[q, x] - image[x]) * normal[x]
                outside = outside and rise < -radius
            if outside:
                return True
    return False


@compiled
def grown(numbers):
    bigger = np.empty(2 * len(numbers), np.int64)
    for i in range(len(numbers)):
        bigger[i] = numbers[i]
    return bigger
