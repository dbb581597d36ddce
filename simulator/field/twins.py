"""Paths that are there twice, as their images coincide: both cross a common border of two mirrors."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_view import APEX, START, at_poses
from simulator.diffraction.single import left_by_mirrors, point_slot, views_of
from simulator.field.stacked_sheets import PARALLEL_COS
from simulator.images.image_method import REACHED, crossed
from simulator.world.candidates import Candidates
from simulator.world.contacts import SHARES
from simulator.world.corners import STEEP
from simulator.world.interactions import Interaction
from simulator.world.mirrors import FLUSH_M
from simulator.world.search_context import Search
from simulator.world.world import Tracing

SAME_IMAGE_M = 1e-7
BESIDE_M = 1e-4  # of the end of an edge, where it is asked how a mirror goes on


def first_of_twins(search: Search, found: Candidates) -> Flags:
    """(C,) False for a path whose image coincides with another's: both cross a common border. The earlier one is kept.

    Over an edge it is the one of which the mirrors leave most: in the plane of a mirror that is met, a second one may
    be missed by so little that a shadow of it arrives. The end of an edge that stands on a mirror is no twin of itself
    with the mirror on the other side. What is reflected at an edge by the edge's own face is: the edge's wave holds it.
    """
    image = _unfolded_source(found)
    key = np.round(image / (10.0 * SAME_IMAGE_M)).astype(np.int64)
    curved_hit = np.round(found.points_m[:, 1:-1].sum(axis=1) / (10.0 * SAME_IMAGE_M)).astype(np.int64)
    curved_hit[(found.face < 0).all(axis=1)] = 0
    end_slot = np.where((found.edge >= 0) & (found.part != APEX), point_slot(found), -1)
    blunt = np.where(search.tracing.world.is_blunt(found.sequence), found.sequence, -1)  # each one's share is its own
    columns = np.column_stack(
        [found.pose, found.mic, found.order, key, curved_hit, found.edge, found.part, end_slot, found.cell, blunt]
    )
    which = distinct(columns)[1]
    twins = np.flatnonzero((np.bincount(which)[which] > 1) & (found.edge >= 0))
    left = np.ones(len(found))
    left[twins] = _left_by_mirrors(search, found[twins])
    order = np.lexsort((-left, which))
    mask = np.zeros(len(found), dtype=bool)
    mask[order[distinct(which[order, None])[0]]] = True
    return mask & ~_off_own_face(search.tracing, found)


def _left_by_mirrors(search: Search, found: Candidates) -> Floats:
    """(C,) how much mirrors that end leave of the loudest wave of paths over edges."""
    if len(found) == 0:
        return np.zeros(0)
    view = views_of(search.tracing, found)[1]
    share = left_by_mirrors(search.tracing, found, view, np.array([search.wavenumber_1_m]))
    left: Floats = np.abs(share).max(axis=(1, 2))
    return left


def _off_own_face(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether a path over an edge meets one of its faces at the edge itself, as in a corner where both end.

    Or next to it what is level with one of them and has the edge in its plane, as the other half of a face whose
    corners are not quite in one. Or at its end another mirror that only touches it there, as the top of a box does on
    which another stands flush.
    """
    rows, off = np.flatnonzero(found.edge >= 0), np.zeros(len(found), dtype=bool)
    some, wedges, normal = found[rows], tracing.world.wedges[found.edge[rows]], tracing.world.patches.normal
    slot = point_slot(some)
    apart = some.points_m[:, 1:-1] - some.points_m[np.arange(len(rows)), slot + 1][:, None]
    at_edge, rises = norm(apart) < FLUSH_M, np.abs(dot(apart, some.normal))
    beside = (np.abs(np.arange(apart.shape[1]) - slot[:, None]) == 1) & (rises < FLUSH_M)
    path, place = np.nonzero((some.interaction == Interaction.SPECULAR) & (at_edge | beside))
    met, faces = some.sequence[path, place], wedges.patch[path]
    leans = np.where(some.part == START, wedges.leans_on[:, 0], wedges.leans_on[:, 1])
    support = (met == leans[path]) | (met == wedges.mirror[path])
    own, there = (met[:, None] == faces).any(axis=1), at_edge[path, place]
    level = (np.abs(dot(normal[met][:, None], normal[faces])) > PARALLEL_COS).any(axis=1)
    off[rows[path[(own & there) | (level & ~own & ~support)]]] = True
    across = np.abs(dot(normal[met], wedges.along[path])) > STEEP
    ends = np.flatnonzero(there & across & ~own & ~support & (some.part[path] != APEX))
    off[rows[path[ends[~_goes_on(tracing, some[path[ends]], place[ends])]]]] = True
    return off


def _goes_on(tracing: Tracing, found: Candidates, place: Ints) -> Flags:
    """(R,) whether mirrors met at the end of an edge are there anywhere on the open side of it."""
    each, wedges = np.arange(len(found)), at_poses(tracing, found.edge, found.pose)
    mirror, once = np.ascontiguousarray(found.sequence[each, place][:, None]), np.ones(len(found), dtype=np.int64)
    here, normal = found.points_m[each, place + 1], tracing.mirrors.normal[found.pose, mirror[:, 0]]
    onwards = np.where((found.part == START)[:, None], wedges.along, -wedges.along)
    up = np.sign(dot(onwards, normal))[:, None] * normal
    there = np.zeros(len(found), dtype=bool)
    for share in SHARES:
        over = here + BESIDE_M * (wedges.direction_at(share * wedges.open_angle_rad) + up)
        there |= crossed(tracing, over, over, found.pose, once, mirror)[0] == REACHED
    return there


def _unfolded_source(found: Candidates) -> Floats:
    """(C, 3) where the source seems to be from the receiver: the whole length back along the last segment."""
    every = np.arange(len(found))
    end, before = found.points_m[every, found.order + 1], found.points_m[every, found.order]
    for k in range(found.order.max(initial=0), 0, -1):  # the last two reflections of a corner path coincide
        short = (norm(end - before) < SAME_IMAGE_M) & (found.order >= k)
        before = np.where(short[:, None], found.points_m[every, np.maximum(found.order - k, 0)], before)
    direction = before - end
    direction /= np.maximum(norm(direction), 1e-300)[:, None]
    return end + found.length_m[:, None] * direction
