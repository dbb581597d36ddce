"""Rims of thin plates: faces narrower than a quarter wavelength between two parallel planes.

A sign of 3 mm sheet modelled as a box has a narrow strip round it. The strip is no mirror at these wavelengths, and
its two edges, each taken alone, are a poor picture of the plate's one edge: together they are the edge of a sheet.
"""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm

THIN_M = 343.0 / 20_000.0 / 4.0  # a quarter wavelength in the middle of the band: 4.3 mm
PARALLEL = 4e-3  # largest difference between the normals of the two sides
_IN_SLAB_M = 1e-6


def rims(mesh: trimesh.Trimesh, regions: Ints, normal: Floats, offset_m: Floats) -> tuple[Flags, Floats]:
    """Which faces are the rim of a thin plate, and how thick the plates are.

    Args:
        mesh: a closed body with outward normals.
        regions: (T,) plane of each facet; normal, offset_m: (L, 3), (L,) of the planes.

    Returns:
        (T,) bool; (L,) thickness of the plate whose face a plane is, 0 for all others.
    """
    rim, thickness = np.zeros(len(mesh.faces), dtype=bool), np.zeros(len(offset_m))
    area = np.bincount(regions, mesh.area_faces, len(offset_m))
    front, back, gap = _parallel_planes(normal, offset_m)
    taken = np.zeros(len(offset_m), dtype=bool)
    for pair in np.argsort(-area[front], kind="stable"):
        a, b = front[pair], back[pair]
        if taken[a] or taken[b] or thickness[a] > 0.0:
            continue
        side = _between(mesh, regions, a, b, normal[a], offset_m[a], gap[pair])
        if side.any() and mesh.area_faces[side].sum() < min(area[a], area[b]):
            rim |= side
            taken[np.unique(regions[side])] = True
            thickness[a] = thickness[b] = gap[pair]
    return rim, thickness


def _parallel_planes(normal: Floats, offset_m: Floats) -> tuple[Ints, Ints, Floats]:
    """Pairs of planes back to back at most `THIN_M` apart, and their distance."""
    here = cKDTree(np.column_stack([normal, offset_m]))
    facing = cKDTree(np.column_stack([-normal, 0.5 * THIN_M - offset_m]))
    near = here.sparse_distance_matrix(facing, 0.5 * THIN_M + PARALLEL, output_type="ndarray")
    a, b = near["i"].astype(np.int64), near["j"].astype(np.int64)
    gap = offset_m[a] + offset_m[b]
    keep = (a < b) & (gap > _IN_SLAB_M) & (gap < THIN_M) & (norm(normal[a] + normal[b]) < PARALLEL)
    return a[keep], b[keep], gap[keep]


def _between(
    mesh: trimesh.Trimesh, regions: Ints, a: int, b: int, normal: Floats, offset_m: float, gap_m: float
) -> Flags:
    """(T,) steep facets that hang on the borders of two planes and stay between them."""
    own = (regions == a) | (regions == b)
    border = np.zeros(len(mesh.vertices), dtype=bool)
    border[mesh.faces[own].ravel()] = True
    height = mesh.vertices @ normal - offset_m
    between = (height < _IN_SLAB_M) & (height > -gap_m - _IN_SLAB_M)
    steep = np.abs(mesh.face_normals @ normal) < 0.7
    return steep & ~own & between[mesh.faces].all(axis=1) & border[mesh.faces].any(axis=1)
