"""Curved reflections with mirrors before and after them.

A mirror only moves the point that the smooth surface sees: the stationary point is looked for between the images
of speaker and microphone, and the crossings of the mirrors are found afterwards from both sides.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Floats
from simulator.curved import stationary as curved
from simulator.images.image_tree import Images, image_pairs, images_lighting
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.waves.spreading import spreading
from simulator.world.candidates import Candidates, concatenated
from simulator.world.frames import out_of_rest
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search


def mixed(search: Search, index: int) -> Candidates:
    """One reflection off smooth surface `index`, with mirrors before and after it."""
    tracing, surface, mirrors = search.tracing, search.tracing.world.surfaces[index], search.max_order - 1
    lit = images_lighting(search, surface, tracing.source_m, mirrors)
    parts = []
    for mic in range(2):
        received = images_lighting(search, surface, tracing.mics_m[:, mic], mirrors)
        left, right = image_pairs(search, surface, search.max_order, lit, received)
        before, after = lit[left], received[right]
        frame = tracing.placed[before.pose, surface.obstacle]
        hit = curved.find(surface, frame, before.point_m, after.point_m)
        _book_missing(search, index, mic, before, after, hit)
        parts.append(_reflected(search, index, mic, before[hit.query], after[hit.query], hit))
    return concatenated(parts)


def _book_missing(
    search: Search, index: int, mic: int, before: Images, after: Images, hit: curved.StationaryPoints
) -> None:
    """Book the pairs of images that no point of the surface mirrors into each other.

    They are listed over the group of facets where the way is shortest, at the level of a plane there.
    """
    tracing, surface = search.tracing, search.tracing.world.surfaces[index]
    missing = np.setdiff1d(np.arange(len(before)), hit.query)

    def described() -> Rejected:
        ends, groups = (before[missing], after[missing]), surface.clusters.spot_m
        frame = tracing.placed[ends[0].pose, surface.obstacle]
        spots = out_of_rest(np.broadcast_to(groups, (len(frame), *groups.shape)), frame[:, None])
        length = sum(np.linalg.norm(spots - end.point_m[:, None], axis=2) for end in ends)
        each, nearest = np.arange(len(missing)), np.argmin(length, axis=1)
        number = np.full((len(missing), 1), tracing.world.numbering.number(Interaction.CURVED, index))
        turns = Turns(mic, *ends, spots[each, nearest][:, None], number)
        return Rejected(1.0 / length[each, nearest], partial(straightened, search, turns))

    search.reject(Reason.NO_MIRROR_POINT, len(missing), described)


def _reflected(
    search: Search, index: int, mic: int, before: Images, after: Images, hit: curved.StationaryPoints
) -> Candidates:
    """Candidates from stationary points of a smooth surface, with what is known of the surface there."""
    surface = search.tracing.world.surfaces[index]
    number = np.full((len(hit), 1), search.tracing.world.numbering.number(Interaction.CURVED, index))

    def amplitude() -> Floats:
        points = np.stack([before.point_m, hit.point_m, after.point_m], axis=1)
        once = np.ones(len(hit), dtype=np.int64)
        return np.abs(spreading(points, hit.normal[:, None], hit.curvature[:, None], once))

    found, ok, place = unfolded(search, Turns(mic, before, after, hit.point_m[:, None], number), amplitude)
    return found.with_reflection(
        place, normal=hit.normal[ok], curvature=hit.curvature[ok], standoff_m=2.0 * surface.sag_m[hit.face[ok]],
        face=hit.face[ok], uv=hit.uv[ok],
    )  # fmt: skip
