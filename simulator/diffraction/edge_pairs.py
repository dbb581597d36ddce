"""Pairs of images over a sharp edge: one of the speaker, the edge, and one of a microphone.

Millions of pairs are listed and thousands are kept. A pair is two row numbers until it is wanted, and where an image
stands about its edge is worked out once, however many pairs it is part of.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import norm
from simulator.diffraction.edge_view import EdgeView, cylindrical, row_of, this_side
from simulator.diffraction.faces_in_mirrors import bends_on
from simulator.images.image_pairs import Pairs, matches
from simulator.images.image_tree import EdgeImages, images_lighting_edges
from simulator.surfaces.wedges import Wedges
from simulator.world.search_context import Search

IN_PLANE_RAD = 1e-9  # from a mirror: what lies in its plane is its own image
AT_ONCE = 2**18  # pairs of a block


@dataclass(frozen=True)
class EdgeSights(Rows):
    """I images and the edges that they see.

    Attributes:
        images: by pose, then wedge.
        end: (I,) the microphone whose images they are; 0 for the speaker's.
        radius_m, angle_rad, height_m: (I,) distance from the edge's line, angle from face 0, height above its start.
        least_m: (I,) what the way from an image to its edge is not shorter than.
    """

    images: EdgeImages
    end: Ints
    radius_m: Floats
    angle_rad: Floats
    height_m: Floats
    least_m: Floats

    def place(self, rows: Ints) -> tuple[Floats, Floats, Floats]:
        """Distances, angles and heights of some rows."""
        return self.radius_m[rows], self.angle_rad[rows], self.height_m[rows]

    @cached_property
    def last(self) -> Ints:
        """(I,) mirror met next to the edge, -1 for none."""
        images = self.images
        if images.sequence.shape[1] == 0:
            return np.full(len(images), -1)
        last = images.sequence[np.arange(len(images)), images.order - 1]
        return np.where(images.order > 0, last, -1)


@dataclass(frozen=True)
class EdgePairs:
    """R pairs of images over an edge.

    Attributes:
        before, after: images of the speaker and of both microphones that see an edge.
        left, right: (R,) rows of these.
    """

    before: EdgeSights
    after: EdgeSights
    left: Ints
    right: Ints

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, rows: Ints) -> EdgePairs:
        return EdgePairs(self.before, self.after, self.left[rows], self.right[rows])

    @classmethod
    def joined(cls, parts: Sequence[EdgePairs]) -> EdgePairs:
        """All of several pairs of the same images."""
        left, right = (np.concatenate([getattr(part, name) for part in parts]) for name in ("left", "right"))
        return cls(parts[0].before, parts[0].after, left, right)

    @property
    def mic(self) -> Ints:
        """(R,) microphone at which each pair ends."""
        return self.after.end[self.right]

    @property
    def wedge(self) -> Ints:
        """(R,) edge."""
        return self.before.images.wedge[self.left]

    @property
    def pose(self) -> Ints:
        """(R,)."""
        return self.before.images.pose[self.left]

    @property
    def order(self) -> Ints:
        """(R,) number of mirrors."""
        return self.before.images.order[self.left] + self.after.images.order[self.right]

    def images(self) -> Pairs:
        """The images themselves."""
        return Pairs(self.mic, self.before.images[self.left], self.after.images[self.right])

    def view(self, wedges: Wedges) -> EdgeView:
        """How the images of each pair see their edge, of all wedges in the scene."""
        source, receiver, wedge = self.before.place(self.left), self.after.place(self.right), self.wedge
        return EdgeView(*source, *receiver, wedges.length_m[wedge], wedges.open_angle_rad[wedge])

    def beside(self, mirror: Ints) -> Flags:
        """(R,) whether either image is one in a given mirror of each pair, next to the edge; never for -1."""
        met = (self.before.last[self.left] == mirror) | (self.after.last[self.right] == mirror)
        return (mirror >= 0) & met


def edge_pairs(search: Search) -> Iterator[EdgePairs]:
    """Images of the speaker with those of a microphone at the same pose and edge, within order and range, by blocks.

    What a face on a mirror and its image diffract has that mirror before it or not: behind it, it would be the same.
    """
    wedges, tracing = search.tracing.world.wedges, search.tracing
    lit = _sights(search, tracing.source_m, 0)
    received = EdgeSights.joined([_sights(search, tracing.mics_m[:, mic], mic) for mic in range(2)])
    mirror = wedges.mirror[received.images.wedge]
    received = received[np.flatnonzero((mirror < 0) | (received.last != mirror))]
    received = received[np.argsort(_keys(received, wedges), kind="stable")]
    (key, order), (other, other_order) = ((_keys(each, wedges), _orders(search, each)) for each in (lit, received))
    begin, end = (np.searchsorted(other, key, side) for side in ("left", "right"))  # type: ignore[call-overload]
    most = search.max_order - 1
    for rows in _blocks(_partners(order, begin, end, other_order, most)):
        some = slice(begin[rows].min(initial=0), end[rows].max(initial=0))
        left, right = matches(key[rows], order[rows], other[some], other_order[some], most)
        yield _kept(search, EdgePairs(lit, received, rows[left], right + some.start))


def _partners(order: Ints, begin: Ints, end: Ints, other_order: Ints, most: int) -> Ints:
    """(R,) how many of the others from `begin` (R,) to `end` (R,) have at most `most` mirrors with each."""
    count = np.zeros(len(order), dtype=np.int64)
    for n in range(most + 1):
        rows, before = np.flatnonzero(order == n), np.append(0, np.cumsum(other_order <= most - n))
        count[rows] = before[end[rows]] - before[begin[rows]]
    return count


def _keys(sights: EdgeSights, wedges: Wedges) -> Ints:
    """(I,) the same for images that see one edge at one pose; they are sorted by it."""
    return sights.images.pose * len(wedges) + sights.images.wedge


def _blocks(partners: Ints) -> list[Ints]:
    """Rows in turn, some at a time, that have so many partners each (R,)."""
    stop = np.flatnonzero(np.diff(np.cumsum(partners) // AT_ONCE)) + 1
    return np.split(np.arange(len(partners)), stop)


def _sights(search: Search, point_m: Floats, end: int) -> EdgeSights:
    """Images of (N, 3) points, one a pose, and the edges that they see from outside."""
    tracing = search.tracing
    wedges, rest = tracing.wedges, tracing.world.wedges
    starts, ends = (each.reshape(len(tracing.pose), len(rest), 3) for each in (wedges.start_m, wedges.end_m))
    allowed = np.ones((search.max_order - 1, len(search.large_mirrors)), dtype=bool)
    allowed[1:] &= search.large_mirrors
    images = images_lighting_edges(
        tracing.mirrors, rest, starts, ends, allowed, search.large_towards, point_m, search.limit_m
    )
    row = row_of(tracing, images.wedge, images.pose)
    radius, angle, height = cylindrical(wedges, row, images.point_m)
    middle = (0.5 * (wedges.start_m + wedges.end_m)).take(row, axis=0)
    least = norm(images.point_m - middle) - 0.5 * rest.length_m[images.wedge]
    turn = rest.open_angle_rad[images.wedge]
    reached = (angle >= 0.0) & (angle <= turn)
    behind = np.flatnonzero(~reached)
    reached[behind] = bends_on(search, images[behind], radius[behind], angle[behind])
    sights = EdgeSights(images, np.full(len(images), end), radius, angle, height, least)
    return sights[reached & _before_mirror(sights, rest)]


def _before_mirror(sights: EdgeSights, wedges: Wedges) -> Flags:
    """(I,) whether images about corners come from before the mirror there: its image in it lies beyond, and only that.

    Behind a sheet that is folded a corner opens on the one side, and what is on the other has no part in it.
    """
    wedge = sights.images.wedge
    past = sights.angle_rad - wedges.free_angle_rad[wedge]
    mirrored = sights.last == wedges.mirror[wedge]
    return (wedges.mirror[wedge] < 0) | (np.where(mirrored, -past, past) <= IN_PLANE_RAD)


def _kept(search: Search, pairs: EdgePairs) -> EdgePairs:
    """Those within the range that may be met, on this side of their edge.

    Either may lie inside the edge: what runs along a face of it bends on there (`faces_in_mirrors`).
    """
    wedges = search.tracing.world.wedges
    least = pairs.before.least_m[pairs.left] + pairs.after.least_m[pairs.right]
    pairs = pairs[np.flatnonzero(least <= search.limit_m)]
    return pairs[np.flatnonzero(this_side(pairs.view(wedges), wedges.sheet_m[pairs.wedge]))]


def _orders(search: Search, sights: EdgeSights) -> Ints:
    """(I,) for how many mirrors images count: their own, or where patches are small all that a path may have, or more.

    One mirror alone may always be met. Where there are several, all of them must be large, and a face of the edge. So
    it is for paths without edges: what a small patch reflects and what its borders diffract nearly cancel, and one of
    them alone is far too loud.
    """
    orders, wedges = sights.images.order.copy(), search.tracing.world.wedges
    rows = np.flatnonzero(orders > 0)
    some = sights.images[rows]
    towards = np.pad(search.large_towards, ((0, 1), (0, 0)), constant_values=True)  # -1: no mirror
    large = np.append(search.large_mirrors, True)[wedges.patch[some.wedge]].any(axis=1)  # -1: curved
    large &= np.logical_and.reduce(towards[some.sequence, wedges.obstacle[some.wedge, None]], axis=1)
    orders[rows[~large]] = np.where(some.order[~large] == 1, search.max_order - 1, search.max_order)
    return orders
