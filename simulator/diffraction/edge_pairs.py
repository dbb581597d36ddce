"""Pairs of images over edges: an image of the speaker, an edge that it lights, an image of a microphone that sees it.

Millions are listed and thousands are kept. A pair is two row numbers until it is wanted, and where an image stands
about its edge is worked out once, however many pairs it is part of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.diffraction.edge_view import EdgeView
from simulator.diffraction.wedge_coordinates import at_poses, cylindrical, outside
from simulator.images.image_pairs import Pairs, matches
from simulator.images.image_tree import EdgeImages, images_lighting_edges
from simulator.surfaces.wedges import Wedges
from simulator.world.frames import out_of_rest
from simulator.world.search_context import Search
from simulator.world.world import Tracing


@dataclass(frozen=True)
class EdgeSights:
    """I images and the edges that they see.

    Attributes:
        images: by pose, then wedge.
        place: (I, 3) distance from the edge's line, angle from face 0, height above the edge's start.
    """

    images: EdgeImages
    place: Floats

    def __getitem__(self, rows: Ints) -> EdgeSights:
        return EdgeSights(self.images[rows], self.place[rows])

    @property
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
        mic: (R,) microphone at which each pair ends.
    """

    before: EdgeSights
    after: EdgeSights
    left: Ints
    right: Ints
    mic: Ints

    def __len__(self) -> int:
        return len(self.left)

    def __getitem__(self, rows: Ints) -> EdgePairs:
        return EdgePairs(self.before, self.after, self.left[rows], self.right[rows], self.mic[rows])

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
        source, receiver, wedge = self.before.place[self.left].T, self.after.place[self.right].T, self.wedge
        length, turn = wedges.length_m[wedge], wedges.open_angle_rad[wedge]
        return EdgeView(source[0], source[1], source[2], receiver[0], receiver[1], receiver[2], length, turn)

    def beside(self, mirror: Ints) -> Flags:
        """(R,) whether either image is one in a given mirror of each pair, next to the edge; never for -1."""
        met = (self.before.last[self.left] == mirror) | (self.after.last[self.right] == mirror)
        return (mirror >= 0) & met


def edge_pairs(search: Search) -> EdgePairs:
    """Images of the speaker with those of a microphone at the same pose and edge, within order and range.

    What a face on a mirror and its image diffract has that mirror before it or not: behind it, it would be the same.
    """
    wedges, mirrors = search.tracing.world.wedges, search.max_order - 1
    lit = _sights(search, search.tracing.source_m)
    parts = []
    for mic in range(2):
        received = _sights(search, search.tracing.mics_m[:, mic])
        mirror = wedges.mirror[received.images.wedge]
        received = received[np.flatnonzero((mirror < 0) | (received.last != mirror))]
        key, other = (each.images.pose * len(wedges) + each.images.wedge for each in (lit, received))
        left, right = matches(key, lit.images.order, other, received.images.order, mirrors)
        parts.append(_kept(search, EdgePairs(lit, received, left, right, np.full(len(left), mic))))
    after = EdgeSights(
        EdgeImages.joined([part.after.images for part in parts]), np.concatenate([part.after.place for part in parts])
    )
    left, right, mics = (np.concatenate([getattr(part, name) for part in parts]) for name in ("left", "right", "mic"))
    return EdgePairs(lit, after, left, right + mics * len(parts[0].after.place), mics)


def _sights(search: Search, point_m: Floats) -> EdgeSights:
    """Images of (N, 3) points, one a pose, and the edges that they see from outside."""
    tracing = search.tracing
    wedges, (start, end) = tracing.world.wedges, _placed_edges(tracing)
    allowed = np.ones((search.max_order - 1, len(search.large_mirrors)), dtype=bool)
    allowed[1:] &= search.large_mirrors
    images = images_lighting_edges(tracing.mirrors, wedges, start, end, allowed, point_m, search.limit_m)
    place = np.stack(cylindrical(at_poses(tracing, images.wedge, images.pose), images.point_m), axis=1)
    return EdgeSights(images, place)[np.flatnonzero(place[:, 1] <= wedges.open_angle_rad[images.wedge])]


def _kept(search: Search, pairs: EdgePairs) -> EdgePairs:
    """Those within the range that may be met, whose edge faces both, and whose mirrors are large or one at most."""
    wedges = search.tracing.world.wedges
    least = [_least_m(search.tracing, sights.images) for sights in (pairs.before, pairs.after)]
    pairs = pairs[np.flatnonzero(least[0][pairs.left] + least[1][pairs.right] <= search.limit_m)]
    pairs = pairs[_by_large_patches(search, pairs)]
    return pairs[np.flatnonzero(outside(pairs.view(wedges), wedges.sheet_m[pairs.wedge]))]


def _least_m(tracing: Tracing, images: EdgeImages) -> Floats:
    """(I,) what the way from an image to its edge is not shorter than."""
    start, end = (each[images.pose, images.wedge] for each in _placed_edges(tracing))
    length = tracing.world.wedges.length_m[images.wedge]
    return np.linalg.norm(images.point_m - 0.5 * (start + end), axis=1) - 0.5 * length


def _by_large_patches(search: Search, pairs: EdgePairs) -> Ints:
    """Rows all of whose mirrors and a face of whose edge are large, or that have one mirror at most.

    So it is for paths without edges: what a small patch reflects and what its borders diffract nearly cancel, and one
    of them alone is far too loud.
    """
    large, wedges = np.append(search.large_mirrors, True), search.tracing.world.wedges  # -1: curved, or no mirror
    several = pairs.order > 1
    rows = np.flatnonzero(several)
    some = pairs[rows]
    kept = large[wedges.patch[some.wedge]].any(axis=1)
    for sights, row in ((some.before, some.left), (some.after, some.right)):
        kept &= np.logical_and.reduce(large[sights.images.sequence], axis=1)[row]
    several[rows] = ~kept
    return np.flatnonzero(~several)


def _placed_edges(tracing: Tracing) -> tuple[Floats, Floats]:
    """(N, W, 3) starts and ends of all edges at all poses."""
    wedges, poses = tracing.world.wedges, len(tracing.pose)
    frame = tracing.placed[:, wedges.obstacle]
    shape = (poses, len(wedges), 3)
    return (
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.start_m, shape), frame)),
        np.ascontiguousarray(out_of_rest(np.broadcast_to(wedges.end_m, shape), frame)),
    )
