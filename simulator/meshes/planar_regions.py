"""Facets of one plane, and which planes are facets of a curve.

Neighbouring facets within a hair of one plane are one region, so that a wall returns one echo whatever its triangles.
Regions that bend into one another below the crease angle are facets of a smooth surface, but for large panels.
"""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import norm
from simulator.meshes.pieces import components

COPLANAR_RAD = 2e-3
PLANE_FIT_M = 2e-5  # a thousandth of the wavelength at 20 kHz: 0.015 rad of echo phase
CREASE_RAD = {"auto": np.deg2rad(35.0), "flat": 0.0, "smooth": np.deg2rad(60.0)}
MOST_BULGE_M = 0.025  # one and a half wavelengths: planes that rounding would raise by more are no facets of a curve
LONE_BULGE_M = 5e-4  # the same of two planes that bend into one another alone: in a curve each has a next one
LONE_WIDE_M = 0.1  # both are wider: pairs of facets of scanned skin are not
PANEL_AREA_RATIO = 8.0  # a plane this much larger than its curved neighbours is a panel, not a facet of a curve
PANEL_LEAST_M2 = 3e-4  # a wavelength at 20 kHz squared: smaller planes are not joined, such as those of scanned skin
PANEL_BEND_RAD = np.deg2rad(1.0)  # by which planes of one panel may depart from their mean


def planar_regions(mesh: trimesh.Trimesh) -> Ints:
    """(T,) label of the plane that each facet lies in; chains that bend away from their plane are cut again."""
    adjacency, angles = mesh.face_adjacency, mesh.face_adjacency_angles
    labels = components(adjacency[angles < COPLANAR_RAD], len(mesh.faces))
    bent = plane_misfit(mesh, labels) > PLANE_FIT_M
    strict = (angles < COPLANAR_RAD) & ~bent[labels[adjacency[:, 0]]] | (angles < 1e-6)
    return components(adjacency[strict], len(mesh.faces))


def plane_misfit(mesh: trimesh.Trimesh, labels: Ints) -> Floats:
    """(L,) largest distance of a corner from its region's plane, m; infinite of one that closes upon itself."""
    normal, offset = mean_planes(mesh, labels)
    distance = np.abs(np.einsum("tcx,tx->tc", mesh.vertices[mesh.faces], normal[labels]) - offset[labels, None])
    worst = np.zeros(labels.max() + 1)
    np.maximum.at(worst, labels, distance.max(axis=1))
    worst[~normal.any(axis=1)] = np.inf
    return worst


def mean_planes(mesh: trimesh.Trimesh, labels: Ints) -> tuple[Floats, Floats]:
    """(L, 3) area-weighted unit normal and (L,) offset of every region."""
    count, area, normal = labels.max() + 1, mesh.area_faces, _region_normals(mesh, labels)
    height = np.einsum("tcx,tx->tc", mesh.vertices[mesh.faces], normal[labels]).mean(axis=1)
    return normal, np.bincount(labels, area * height, count) / np.bincount(labels, area, count)


def _region_normals(mesh: trimesh.Trimesh, labels: Ints) -> Floats:
    """(L, 3) area-weighted unit normal of every region; 0 of one that closes upon itself."""
    weighted = mesh.area_faces[:, None] * mesh.face_normals
    normal: Floats = np.stack([np.bincount(labels, weighted[:, k]) for k in range(3)], axis=1)
    return normal / np.maximum(norm(normal)[..., None], 1e-300)


def broad_folds(mesh: trimesh.Trimesh, regions: Ints, rows: Ints) -> Ints:
    """Those of some pairs of facets (R,) between planes that rounding would both raise by more than `MOST_BULGE_M`, or
    by more than `LONE_BULGE_M` where these two alone bend into one another, as the halves of a wall do.

    An arc over a chord w whose ends turn by half a fold each rises by w / 8 times the fold.
    """
    vertices = np.asarray(mesh.vertices)
    order = np.argsort(regions, kind="stable")
    corners = vertices[mesh.faces[order]].reshape(-1, 3)
    first = 3 * np.searchsorted(regions[order], np.arange(regions.max() + 2))
    high, low = (take.reduceat(corners, first[:-1]) for take in (np.maximum, np.minimum))
    pair, fold = regions[mesh.face_adjacency[rows]], mesh.face_adjacency_angles[rows]
    bent = components(pair, len(first) - 1)
    lone = np.bincount(bent)[bent[pair[:, 0]]] == 2
    rise, chord = np.where(lone, LONE_BULGE_M, MOST_BULGE_M), np.where(lone, LONE_WIDE_M, 0.0)
    least = np.maximum(chord, 8.0 * rise / np.maximum(fold, 1e-9))
    wide = (pair[:, 0] != pair[:, 1]) & (norm(high - low)[pair] > least[:, None]).all(axis=1)
    found = []
    for row in np.flatnonzero(wide):
        start, end = vertices[mesh.face_adjacency_edges[rows[row]]]
        along = (end - start) / np.linalg.norm(end - start)
        sides = (np.cross(corners[first[region] : first[region + 1]] - start, along) for region in pair[row])
        if min(norm(side).max() for side in sides) > least[row]:
            found.append(rows[row])
    return np.array(found, dtype=np.int64)


def curved_faces(mesh: trimesh.Trimesh, regions: Ints, smooth_edges: Ints) -> Flags:
    """(T,) facets that bend smoothly into a neighbour and are not of large panels."""
    bends = smooth_edges[regions[smooth_edges[:, 0]] != regions[smooth_edges[:, 1]]]
    area = np.bincount(regions, mesh.area_faces)[regions]
    panel = _panels(mesh, regions, area, bends)
    across = bends[panel[bends[:, 0]] != panel[bends[:, 1]]]
    largest, largest_neighbor = np.zeros(panel.max() + 1), np.zeros(panel.max() + 1)
    np.maximum.at(largest, panel, area)
    for a, b in (across.T, across.T[::-1]):
        np.maximum.at(largest_neighbor, panel[a], area[b])
    return ~(largest > PANEL_AREA_RATIO * largest_neighbor)[panel]


def _panels(mesh: trimesh.Trimesh, regions: Ints, area: NDArray, bends: Ints) -> Ints:
    """(T,) label of each facet's plane, or of the planes that bend into one another by next to nothing in all.

    A flat that is drawn out to a taper in two steps is one panel. The facets of a fine cylinder bend as little from one
    to the next, but not in all.
    """
    normal = np.asarray(mesh.face_normals)
    slight = np.einsum("ax,ax->a", *normal[bends.T]) > np.cos(PANEL_BEND_RAD)
    joined = bends[slight & (area[bends] > PANEL_LEAST_M2).all(axis=1)]
    label = components(regions[joined], regions.max() + 1)[regions]
    mean = _region_normals(mesh, label)
    bent = np.zeros(len(mean), dtype=bool)
    np.logical_or.at(bent, label, np.einsum("tx,tx->t", normal, mean[label]) < np.cos(PANEL_BEND_RAD))
    return np.unique(np.where(bent[label], len(mean) + regions, label), return_inverse=True)[1].astype(np.int64)
