"""Sheets that lie on one another count once: the front one, as seen from where the sound comes from or goes to.

Embree tells what hides what to within its float32, so it lets the last micrometres before a surface pass: two sheets
closer than that would both echo. Here the gap is resolved in float64. Of sheets closer than `RESOLVED_M`, which no
coordinate tells apart, the first listed is in front.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.images.image_method import inside_patch
from simulator.images.image_tree import distance, dot
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.visibility import OFFSET
from simulator.world.world import Tracing

RESOLVED_M = 1e-12  # rounding of coordinates up to some 1000 m
PARALLEL_COS = np.cos(np.deg2rad(1.0))
BLIND = 4.0  # times `OFFSET` of the largest coordinate: what Embree may let pass, along and across


def covered(tracing: Tracing, found: Candidates) -> Flags:
    """(C,) whether a sheet lies on a reflecting plane or sharp edge of a path, on the side of the path."""
    extent = max((shadow.extent_m for shadow in tracing.world.blockers), default=1.0)
    blind_m = BLIND * OFFSET * max(extent, float(np.abs(found.points_m).max(initial=0.0)))
    own = _own_patches(tracing, found)
    return _covered(tracing.mirrors, own, found.pose, found.points_m, blind_m)  # type: ignore[call-arg]


def _own_patches(tracing: Tracing, found: Candidates) -> Ints:
    """(C, N, 2) planar patches at each point of a path: a mirror, or both faces of a sharp edge; -1 without."""
    mirror = np.where(found.interaction == Interaction.SPECULAR, found.sequence, -1)
    own = np.stack([mirror, mirror], axis=2)
    edge = found.interaction == Interaction.EDGE
    own[edge] = tracing.world.wedges.patch[found.sequence[edge] - tracing.world.numbering.first[Interaction.EDGE]]
    return own


@compiled
def _covered(mirrors, own, pose, points, blind):
    out = np.zeros(len(pose), np.bool_)
    for r in range(len(pose)):
        for k in range(own.shape[1]):
            if max(own[r, k, 0], own[r, k, 1]) < 0:
                continue
            for p in range(len(mirrors.radius_m)):
                height = dot(points[r, k + 1], mirrors.normal[pose[r], p]) - mirrors.offset_m[pose[r], p]
                if abs(height) > blind or not _lies_on(mirrors, pose[r], p, own[r, k]):
                    continue
                for end in (points[r, k], points[r, k + 2]):
                    if _hides(mirrors, pose[r], p, max(own[r, k, 0], own[r, k, 1]), points[r, k + 1], end, height):
                        out[r] = True
    return out


@inlined
def _lies_on(mirrors, n, p, own):
    """Whether a patch is another than those at a point, and parallel to one of them."""
    parallel = False
    for other in own:
        if p == other:
            return False
        if other >= 0:
            parallel |= abs(dot(mirrors.normal[n, p], mirrors.normal[n, other])) > PARALLEL_COS
    return parallel


@inlined
def _hides(mirrors, n, p, own, point, end, height):
    """Whether a patch at a small height under a point hides it from an end."""
    there = dot(end, mirrors.normal[n, p]) - mirrors.offset_m[n, p]
    if abs(there) <= RESOLVED_M:  # in the sheet's own plane, as the next reflection in a corner: it hides nothing there
        return False
    if distance(point, mirrors.center_m[n, p]) > 1.01 * mirrors.radius_m[p]:
        return False
    if abs(height) <= RESOLVED_M:
        reflects = there > 0.0 or not mirrors.one_sided[p]
        return p < own and reflects and inside_patch(mirrors, n, p, point[0], point[1], point[2])
    if height * there >= 0.0:
        return False
    crossing, share = np.empty(3), height / (height - there)
    for x in range(3):
        crossing[x] = point[x] + share * (end[x] - point[x])
    return inside_patch(mirrors, n, p, crossing[0], crossing[1], crossing[2])
