"""Groups of neighbouring facets with like normals: whole groups that cannot mirror two points are passed over."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Floats, Ints

LEAF = 12  # facets a group at most; measured fastest between 8 and 24 on a body of 5,000 facets


@dataclass(frozen=True)
class Clusters:
    """Bounding spheres and cones of normals over groups of facets.

    Attributes:
        facet: (T,) facets in the order of the groups.
        start: (G + 1,) where each group begins in `facet`.
        center_m, radius_m: (G, 3), (G,) sphere round the group's rounded facets.
        axis: (G, 3) middle of its normals.
        spread_rad: (G,) greatest angle of a normal from the axis.
    """

    facet: Ints
    start: Ints
    center_m: Floats
    radius_m: Floats
    axis: Floats
    spread_rad: Floats


def clusters(corner_m: Floats, normal: Floats, sag_m: Floats) -> Clusters:
    """Group T facets from their corners (T, 3, 3), corner normals (T, 3, 3) and bulges (T,)."""
    center = corner_m.mean(axis=1)
    extent = max(float(np.ptp(center, axis=0).max(initial=0.0)), 1e-9)
    place = np.concatenate([center / extent, normal.mean(axis=1)], axis=1)
    facet, start = leaves(place, LEAF)
    group = np.repeat(np.arange(len(start) - 1), np.diff(start))
    middle, radius = _spheres(corner_m[facet], sag_m[facet], start, group)
    axis, spread = _cones(normal[facet], start, group)
    return Clusters(facet, start, middle, radius, axis, spread)


def leaves(place: Floats, most: int) -> tuple[Ints, Ints]:
    """Facets at places (T, D) in groups of `most` at most, group by group, and where each group begins."""
    tree = cKDTree(place, leafsize=most, compact_nodes=False, balanced_tree=False)
    nodes, ends = [tree.tree], []
    while nodes:
        node = nodes.pop()
        if node.split_dim == -1:
            ends.append((node.start_idx, node.end_idx))
        else:
            nodes += [node.greater, node.lesser]
    start = np.array([first for first, _ in ends] + [ends[-1][1]], dtype=np.int64)
    return tree.indices.astype(np.int64), start


def _spheres(corner_m: Floats, sag_m: Floats, start: Ints, group: Ints) -> tuple[Floats, Floats]:
    """Centres of the bounding boxes and the distances of the farthest corners."""
    low = np.minimum.reduceat(corner_m.min(axis=1), start[:-1])
    high = np.maximum.reduceat(corner_m.max(axis=1), start[:-1])
    center = 0.5 * (low + high)
    distance = np.linalg.norm(corner_m - center[group][:, None], axis=2).max(axis=1) + sag_m
    return center, np.maximum.reduceat(distance, start[:-1])


def _cones(normal: Floats, start: Ints, group: Ints) -> tuple[Floats, Floats]:
    """Mean normals, and the angles of the corners that lean away most; pi where the normals cancel."""
    total = np.add.reduceat(normal.sum(axis=1), start[:-1])
    size = np.linalg.norm(total, axis=1)
    axis = total / np.maximum(size, 1e-300)[:, None]
    lean = np.minimum.reduceat(np.einsum("tcx,tx->tc", normal, axis[group]).min(axis=1), start[:-1])
    return axis, np.where(size > 1e-6, np.arccos(np.clip(lean, -1.0, 1.0)), np.pi)


@numba.njit(cache=True)
def may_mirror(center, radius, axis, spread, closed, source, receiver):
    """Whether some normal of the group may halve the angle between the ways to both points.

    Over the sphere the direction to a point turns by asin(radius / distance) at most, the bisector by no more than
    both together.
    """
    to_source = to_receiver = 0.0
    for k in range(3):
        to_source += (source[k] - center[k]) ** 2
        to_receiver += (receiver[k] - center[k]) ** 2
    to_source, to_receiver = np.sqrt(to_source), np.sqrt(to_receiver)
    if to_source <= radius or to_receiver <= radius:
        return True
    along = size = 0.0
    for k in range(3):
        h = (source[k] - center[k]) / to_source + (receiver[k] - center[k]) / to_receiver
        along += h * axis[k]
        size += h * h
    size = np.sqrt(size)
    if size < 0.2:
        return True
    angle = np.arccos(min(1.0, max(-1.0, along / size)))
    if not closed:
        angle = min(angle, np.pi - angle)
    return angle <= spread + np.arcsin(radius / to_source) + np.arcsin(radius / to_receiver) + 1e-6
