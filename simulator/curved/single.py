"""Curved reflections with mirrors before and after them.

A mirror only moves the point that the smooth surface sees: the stationary point is looked for between the images
of speaker and microphone, and the crossings of the mirrors are found afterwards from both sides.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Ints
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.compiled_vectors import distance
from simulator.curved import stationary as curved
from simulator.images.image_pairs import Pairs, pairs_over
from simulator.images.shown import shown
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.reflectors import SmoothSurface
from simulator.waves.spreading import spreading
from simulator.world.candidates import Candidates
from simulator.world.frames import out_of_rest
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search

NEAR_MISS_M = 0.3  # what misses its mirrors by less is looked for all the same, so that it can be listed as rejected
ONE_PLACE_M, ONE_LENGTH_M = 0.01, 2e-4  # half and a hundredth of the shortest wavelength


def mixed(search: Search, index: int) -> Candidates:
    """One reflection off smooth surface `index`, with mirrors before and after it."""
    world = search.tracing.world
    surface = world.surfaces[index]
    name = world.obstacles[surface.obstacle].name
    pairs = pairs_over(search, surface)
    frame = search.tracing.placed[pairs.pose, surface.obstacle]
    ends = pairs.before, pairs.after
    within = np.concatenate([shown(search.tracing, images, surface.obstacle, NEAR_MISS_M) for images in ends], axis=1)
    hit = _each_once(curved.find(surface, name, frame, pairs.before.point_m, pairs.after.point_m, within), pairs)
    number = world.numbering.number(Interaction.CURVED, index)
    _book_missing(search, surface, number, pairs[np.setdiff1d(np.arange(len(pairs)), hit.query)])
    return _reflected(search, number, pairs, hit)


def _each_once(hit: curved.StationaryPoints, pairs: Pairs) -> curved.StationaryPoints:
    """Without points that lie beside another one and mirror as it does.

    Where path lengths hardly change along a surface, it may have three stationary points on neighbouring facets for one
    of the body that they stand for. Points that part at a caustic differ by a focus.
    """
    source, receiver = pairs.before.point_m[hit.query], pairs.after.point_m[hit.query]
    other = _beside(hit.query, hit.point_m, source, receiver)  # type: ignore[call-arg]
    rows = np.flatnonzero(other >= 0)
    alike = np.abs(np.angle(_spread(hit[rows], pairs) / _spread(hit[other[rows]], pairs))) < 1.0
    return hit[np.setdiff1d(np.arange(len(hit)), rows[alike])]


@compiled
def _beside(query, point, source, receiver):
    """(H,) an earlier point of the same query in the same place, over a path as long; -1 for none."""
    other = np.full(len(query), -1)
    for h in range(len(query)):
        length = distance(source[h], point[h]) + distance(point[h], receiver[h])
        k = h - 1
        while k >= 0 and query[k] == query[h]:
            longer = distance(source[k], point[k]) + distance(point[k], receiver[k]) - length
            if distance(point[k], point[h]) < ONE_PLACE_M and abs(longer) < ONE_LENGTH_M:
                other[h] = k
            k -= 1
    return other


def _spread(hit: curved.StationaryPoints, pairs: Pairs) -> Complexes:
    """(H,) amplitude of a unit source over each point."""
    points = np.stack([pairs.before.point_m[hit.query], hit.point_m, pairs.after.point_m[hit.query]], axis=1)
    return spreading(points, hit.normal[:, None], hit.curvature[:, None], np.ones(len(hit), dtype=np.int64))


def _book_missing(search: Search, surface: SmoothSurface, number: Ints, missing: Pairs) -> None:
    """Book the pairs of images that no point of the surface mirrors into each other.

    They are listed over the group of facets where the way is shortest, at the level of a plane there.
    """

    def described() -> Rejected:
        groups = surface.clusters.spot_m
        frame = search.tracing.placed[missing.pose, surface.obstacle]
        spots = out_of_rest(np.broadcast_to(groups, (len(frame), *groups.shape)), frame[:, None])
        length = sum(np.linalg.norm(spots - end.point_m[:, None], axis=2) for end in (missing.before, missing.after))
        each, nearest = np.arange(len(missing)), np.argmin(length, axis=1)
        turns = Turns(missing, spots[each, nearest][:, None], np.full((len(missing), 1), number))
        return Rejected(1.0 / length[each, nearest], partial(straightened, search, turns))

    search.reject(Reason.NO_MIRROR_POINT, len(missing), described)


def _reflected(search: Search, number: Ints, pairs: Pairs, hit: curved.StationaryPoints) -> Candidates:
    """Candidates from stationary points of a smooth surface, with what is known of the surface there."""
    known = {name: column[:, None] for name, column in hit.known.items()}
    turns = Turns(pairs[hit.query], hit.point_m[:, None], np.full((len(hit), 1), number), known)
    return unfolded(search, turns, lambda: np.abs(_spread(hit, pairs)))[0]
