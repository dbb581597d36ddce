"""Tips of cones: where a fan of smooth facets meets in a point, no one normal holds.

A surface rebuilt from a normal at the tip would belly out by a good part of the cone's height. The fan is cut into
rows instead, each a frustum whose rims have normals of their own, and its last hundredth is left away.
"""

from __future__ import annotations

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Flags, Ints
from obstaclewatch.support.vectors import norm

LEAST_FAN = 10  # facets; where fewer meet, on scanned bodies, a point is one of the scan
LEAST_LEAN_RAD = np.deg2rad(10.0)
ONWARD = 0.5  # of the lean from the mean at a vertex: how far facets turn on at the least where a surface is round
ROW = 0.8  # radius of a row over that of the one below: curvature, linear in between, is then right to 0.05 dB
ROWS = 21  # to 0.9 % of the fan


def tips_opened(mesh: trimesh.Trimesh, crease_rad: float) -> trimesh.Trimesh:
    """The mesh with each fan of smooth facets round a tip in rows, and the tip itself away; the same if it has none."""
    tip = tips(mesh, crease_rad)
    faces = np.asarray(mesh.faces)
    corner = tip[faces].argmax(axis=1)
    fan = np.flatnonzero(tip[faces].sum(axis=1) == 1)
    if len(fan) == 0:
        return mesh
    apex, left, right = (faces[fan, (corner[fan] + k) % 3] for k in range(3))
    vertices, rows = [np.asarray(mesh.vertices)], [np.delete(faces, fan, axis=0)]
    spoke, of_left = np.unique(np.stack([apex, left], axis=1), axis=0, return_inverse=True)
    of_right = _row_of(spoke, np.stack([apex, right], axis=1), len(mesh.vertices))
    here, there = left, right
    for k in range(1, ROWS + 1):
        first = sum(len(part) for part in vertices)
        vertices.append(vertices[0][spoke[:, 0]] + ROW**k * (vertices[0][spoke[:, 1]] - vertices[0][spoke[:, 0]]))
        up, across = first + of_left.reshape(-1), first + of_right
        rows += [np.stack([up, here, there], axis=1), np.stack([up, there, across], axis=1)]
        here, there = up, across
    return trimesh.Trimesh(np.concatenate(vertices), np.concatenate(rows), process=False)


def tips(mesh: trimesh.Trimesh, crease_rad: float) -> Flags:
    """(V,) vertices in the middle of a whole fan of smooth facets that lean off their mean and turn on no more."""
    faces, count = np.asarray(mesh.faces), len(mesh.vertices)
    angle = np.asarray(mesh.face_adjacency_angles)
    smooth = angle < crease_rad
    mean = np.zeros((count, 3))
    np.add.at(mean, faces.ravel(), (mesh.face_angles[:, :, None] * mesh.face_normals[:, None]).reshape(-1, 3))
    mean /= np.maximum(norm(mean)[..., None], 1e-300)
    lean = np.arccos(np.clip(np.einsum("tcx,tx->tc", mean[faces], mesh.face_normals), -1.0, 1.0))
    onward = np.zeros(faces.shape)
    for side in range(2):
        facet, opposite = mesh.face_adjacency[smooth, side], mesh.face_adjacency_unshared[smooth, side]
        onward[facet, (faces[facet] == opposite[:, None]).argmax(axis=1)] = angle[smooth]
    pointed = (lean > LEAST_LEAN_RAD) & (onward < ONWARD * lean)
    around = np.bincount(faces.ravel(), minlength=count)
    spokes = np.bincount(mesh.face_adjacency_edges[smooth].ravel(), minlength=count)
    agreed = np.bincount(faces.ravel(), pointed.ravel(), minlength=count)
    found: Flags = (around >= LEAST_FAN) & (spokes == around) & (agreed == around)
    return found


def _row_of(pairs: Ints, wanted: Ints, count: int) -> Ints:
    """(W,) where each wanted pair of vertices stands among sorted pairs."""
    found: Ints = np.searchsorted(pairs[:, 0] * count + pairs[:, 1], wanted[:, 0] * count + wanted[:, 1])
    return found
