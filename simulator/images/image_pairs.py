"""Pairs of images over a body: an image of the speaker, the body, an image of a microphone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.repeated import repeated
from simulator.images.image_tree import Goal, Images, images_lighting
from simulator.world.frames import out_of_rest
from simulator.world.search_context import Search
from simulator.world.world import Tracing


class Body(Protocol):
    """What lighting needs to know of a surface: its obstacle and bounding sphere."""

    @property
    def obstacle(self) -> int: ...

    @property
    def center_m(self) -> Floats: ...

    @property
    def radius_m(self) -> float: ...


@dataclass(frozen=True)
class Pairs:
    """R pairs of images over one body, or over edges.

    Attributes:
        mic: (R,) microphone at which they end.
        before, after: images of speaker and microphone, aligned.
        obstacle: the body's; -1 for edges.
    """

    mic: Ints
    before: Images
    after: Images
    obstacle: int = -1

    def __len__(self) -> int:
        return len(self.mic)

    def __getitem__(self, index: NDArray) -> Pairs:
        rows = np.flatnonzero(index) if index.dtype == bool else index
        return Pairs(self.mic[rows], self.before[rows], self.after[rows], self.obstacle)

    @property
    def pose(self) -> Ints:
        """(R,)."""
        return self.before.pose

    def mirror_slots(self, between: int) -> Iterator[tuple[int, Ints, int, Ints]]:
        """Where the mirrors of paths come that meet `between` surfaces or edges after those of the speaker's image.

        Yields:
            0 before these and 1 behind them, rows of the R, which mirror of the image it is, and its slots (rows,).
        """
        place, late_order = self.before.order, self.after.order
        for k in range(self.before.sequence.shape[1]):
            early, late = np.flatnonzero(place > k), np.flatnonzero(late_order > k)
            yield 0, early, k, np.full(len(early), k)
            yield 1, late, k, place[late] + between + late_order[late] - 1 - k  # met in reverse


@dataclass(frozen=True)
class Taken:
    """What Kirchhoff's integral takes of the echoes over a body.

    Attributes:
        pairs: R pairs of images.
        share: (R,) of the echo over each; the rays over it keep the rest.
    """

    pairs: Pairs
    share: Floats

    def __getitem__(self, rows: Ints) -> Taken:
        return Taken(self.pairs[rows], self.share[rows])


def pairs_over(search: Search, body: Body) -> Pairs:
    """All pairs with mirrors of other obstacles before and after a body, up to all reflections with its own."""
    mirrors, parts = search.max_order - 1, []
    lit = images_of(search, body, search.tracing.source_m, mirrors)
    for mic in range(2):
        received = images_of(search, body, search.tracing.mics_m[:, mic], mirrors)
        left, right = _matched(search, body, lit, received)
        parts.append(Pairs(np.full(len(left), mic), lit[left], received[right], body.obstacle))
    return joined_pairs(parts)


def joined_pairs(parts: list[Pairs]) -> Pairs:
    """All parts over the same body, one after the other."""
    before, after = ([getattr(part, side) for part in parts] for side in ("before", "after"))
    mic, of = np.concatenate([part.mic for part in parts]), type(before[0])
    return Pairs(mic, of.joined(before), of.joined(after), parts[0].obstacle)


def images_of(search: Search, body: Body, point_m: Floats, max_order: int, extent_m: float = 0.0) -> Images:
    """Images of (N, 3) points in the patches from which a body, and `extent_m` around it, is reached.

    Patches of the body's own obstacle are no mirrors, and only large ones follow each other.
    """
    goal = Goal(centers(search.tracing, body), body.radius_m + extent_m, search.limit_m)
    allowed = np.tile(search.tracing.world.patches.obstacle != body.obstacle, (max_order, 1))
    allowed[1:] &= search.large_towards[:, body.obstacle]
    return images_lighting(search.tracing.mirrors, allowed, point_m, goal)


def _matched(search: Search, body: Body, lit: Images, received: Images) -> tuple[Ints, Ints]:
    """Indices of images of speaker and microphone at the same pose that make a path over a body.

    Within the order, not too long, and with large mirrors alone where there are several.
    """
    left, right = matches(lit.pose, lit.order, received.pose, received.order, search.max_order - 1)
    mirrors = lit.order[left] + received.order[right]
    small = np.append(~search.large_towards[:, body.obstacle], False)  # for -1
    alone = small[np.concatenate([lit.sequence[left], received.sequence[right]], axis=1)].any(axis=1)
    keep = np.flatnonzero((mirrors < 2) | ~alone)
    left, right = left[keep], right[keep]
    center = centers(search.tracing, body)[lit.pose[left]]
    way = sum(np.linalg.norm(point - center, axis=1) for point in (lit.point_m[left], received.point_m[right]))
    near = np.flatnonzero(way - 2.0 * body.radius_m <= search.limit_m)
    return left[near], right[near]


def centers(tracing: Tracing, body: Body) -> Floats:
    """(N, 3) middle of a body's bounding sphere at each pose."""
    frame = tracing.placed[:, body.obstacle]
    return np.ascontiguousarray(out_of_rest(np.broadcast_to(body.center_m, (len(frame), 3)), frame))


def matches(key: Ints, order: Ints, other: Ints, other_order: Ints, most: int) -> tuple[Ints, Ints]:
    """Indices of every pair of equal keys whose orders add up to `most` at most, in order; `other` is sorted.

    Most images are of the highest order, and go with few: all pairs would be twenty times as many.
    """
    found = [np.zeros((2, 0), dtype=np.int64)]
    for n in range(most + 1):
        rows, others = np.flatnonzero(order == n), np.flatnonzero(other_order <= most - n)
        first, end = (np.searchsorted(other[others], key[rows], side) for side in ("left", "right"))  # type: ignore[call-overload]
        row, step = repeated(end - first)
        found.append(np.stack([rows[row], others[first[row] + step]]))
    left, right = np.concatenate(found, axis=1)
    turn = np.lexsort((right, left))
    return left[turn], right[turn]
