"""Faces that go on in a mirror on which they stand squarely: there an edge and its image are two edges of one face.

The side of a pillar on a wall is one face with its image. A phone before the pillar has its own image inside the
pillar, as the front edge sees it: nothing goes there straight, but what runs from the edge along the side and bends on
at the edge's image does, half of it where the image just drops behind the side. So it is with the far edge of a side
of a free box or pillar, as the phone itself drops behind that side.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot
from simulator.diffraction.edge_view import EdgeView, at_poses
from simulator.diffraction.patch_borders import BORDER_REACH_RAD
from simulator.images.image_method import REACHED, crossed
from simulator.images.image_tree import EdgeImages
from simulator.surfaces.wedges import Wedges
from simulator.world.candidates import Candidates
from simulator.world.search_context import Search
from simulator.world.world import Tracing

SQUARE_COSINE = 1e-3  # cosine between normals under which a face goes on in a mirror: files of float32 round by 1e-5
BEFORE_M = 5e-3  # a mirror that a face stands on begins nearer to it
ONTO_M = 1e-3  # over a face, so that the mirror on which it stands is met beside its foot, however that is rounded
SPARE = 2.0  # on the reach: aslant to the edge a detour is shorter than square to it


def bends_on(search: Search, images: EdgeImages, radius_m: Floats, angle_rad: Floats) -> Flags:
    """(I,) whether images inside an edge are reached all the same, the detour along its face being in reach.

    That is over the edge across the face, or over the image of their own edge. Mirrors square to the edge, as the
    ground is to a pillar's, leave it where it is.

    Args:
        radius_m, angle_rad: (I,) of the images about their edges.
    """
    tracing, wedges = search.tracing, search.tracing.world.wedges
    reached = np.zeros(len(images), dtype=bool)
    rows = np.flatnonzero(((wedges.mirror < 0) & ~wedges.flat)[images.wedge])
    wedge, pose, radius, angle = images.wedge[rows], images.pose[rows], radius_m[rows], angle_rad[rows]
    turn, side = wedges.open_angle_rad[wedge], (angle > 0.0).astype(np.int64)
    inside = np.maximum(angle - turn, -angle)
    reached[rows] = _in_reach(search, tracing.world.runs_to_opposite_m[wedge, side], radius, inside)
    mirrored = images.order[rows] > 0
    rows, wedge, pose, side = rows[mirrored], wedge[mirrored], pose[mirrored], side[mirrored]
    radius, inside = radius[mirrored], inside[mirrored]
    edge, face = at_poses(tracing, wedge, pose), tracing.mirrors.normal[pose, wedges.patch[wedge, side]]
    in_place = np.ones(len(rows), dtype=bool)
    for k in reversed(range(images.sequence.shape[1])):
        met, mirror = images.order[rows] > k, images.sequence[rows, k]
        normal, offset = tracing.mirrors.normal[pose, mirror], tracing.mirrors.offset_m[pose, mirror]
        along = np.abs(dot(normal, edge.along))
        near = _in_reach(search, 2.0 * np.abs(dot(normal, edge.start_m) - offset), radius, inside)
        square = np.maximum(along, np.abs(dot(normal, face))) < SQUARE_COSINE
        some = np.flatnonzero(met & in_place & square & near)
        reached[rows[some]] |= _stands(tracing, edge[some], face[some], pose[some], mirror[some])
        in_place &= ~met | (along > 1.0 - SQUARE_COSINE)
    return reached


def _in_reach(search: Search, run_m: Floats, radius_m: Floats, inside_rad: Floats) -> Flags:
    """(R,) whether points behind a face, so far from its edge, may be reached over what is across so long a run."""
    shorter = run_m < radius_m
    run = np.where(shorter, run_m, 0.0)
    bent = run + np.sqrt(radius_m**2 + run**2 - 2.0 * radius_m * run * np.cos(inside_rad))
    return np.asarray(shorter & (bent - radius_m < SPARE * BORDER_REACH_RAD / search.wavenumber_1_m))


def _stands(tracing: Tracing, edge: Wedges, face: Floats, pose: Ints, mirror: Ints) -> Flags:
    """(R,) whether a mirror is there just before a face that is square to it, below the middle of the face's edge."""
    normal, offset = tracing.mirrors.normal[pose, mirror], tracing.mirrors.offset_m[pose, mirror]
    before = 0.5 * (edge.start_m + edge.end_m) + BEFORE_M * face
    foot = before - (dot(normal, before) - offset)[:, None] * normal
    up = foot + BEFORE_M * normal
    order = np.ones(len(pose), dtype=np.int64)
    return np.asarray(crossed(tracing, up, up, pose, order, np.ascontiguousarray(mirror[:, None]))[0] == REACHED)


def onto_faces(tracing: Tracing, found: Candidates, view: EdgeView) -> Candidates:
    """Paths over edges, with transducers that lie inside their edge moved onto its face: what bends on runs along it.

    Mirrors square to a face leave its normal as it is, so that the move is the same in the images of a transducer.
    """
    faces = tracing.world.wedges.patch[found.edge]
    ends = (
        (view.source_angle_rad, view.source_radius_m, np.zeros(len(found), dtype=np.int64)),
        (view.receiver_angle_rad, view.receiver_radius_m, found.order + 1),
    )
    inside = [np.maximum(angle - view.open_angle_rad, -angle) for angle, _, _ in ends]
    if max(each.max(initial=0.0) for each in inside) <= 0.0:
        return found
    points = found.points_m.copy()
    for (angle, radius, at), deep in zip(ends, inside, strict=True):
        rows = np.flatnonzero(deep > 0.0)
        normal = tracing.mirrors.normal[found.pose[rows], faces[rows, (angle[rows] > 0.0).astype(np.int64)]]
        points[rows, at[rows]] += (radius[rows] * np.sin(deep[rows]) + ONTO_M)[:, None] * normal
    return replace(found, points_m=points)
