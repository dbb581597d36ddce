"""Faces that rounding has bent or moved apart, brought onto one plane: files round the coordinates of their corners.

A shelf or a bench is often several boxes in one mesh. Where it stands askew and its corners are kept to a millimetre,
boxes that stood flush have steps, slits and kinks between them. Each of these would be an edge, a corner or a mirror of
its own: echoes of -21 dB re 1 m were found that the body does not have. So faces of different pieces that fit one plane
are taken for it, and their corners move onto it, by a twentieth of the wavelength at the most. Within one piece a bend
is taken for meant, unless creases bound all of it and no corner leaves the plane by more than 0.4 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from simulator.meshes.pieces import components, pieces_of
from simulator.meshes.planar_regions import CREASE_RAD, curved_faces, mean_planes, planar_regions, plane_misfit
from simulator.scene.scene import Surface

WITHIN_M = 9e-4  # of a plane: as far as rounding to a millimetre moves corners; 0.7 rad of echo phase
LEVEL_M = 4e-4  # of a plane: a face that creases bound and that no corner leaves by more is flat
BROAD_M2 = 5e-4  # smaller ones stay as they are: folds of scanned skin and cloth
LEAST_M = 1e-5  # what lies so near to one plane is read as in it anyway
ALIKE = np.cos(np.deg2rad(3.0))  # rounding to a millimetre tilts a face of 3 cm by up to so much
FEWEST = 3  # corners, of which a face has more: one triangle's plane says little of what was meant
SEEDS = 2000  # largest planes that others are brought onto: bodies of more are scans, whose planes are small
KEPT = np.cos(np.deg2rad(20.0))  # a facet that would turn by more is no wider than what its corners move by
ALONG = 0.05  # of the largest singular value of a corner's planes: along lesser ones they leave it free


@dataclass(frozen=True)
class _Faces:
    """L flat regions of a mesh: mean planes (L, 3) and (L,), areas (L,), and the connected piece of each (L,).

    Their corners are vertices (C,) of the mesh, region by region, `start` (L + 1,) says from where.
    """

    normal: Floats
    offset_m: Floats
    area_m2: Floats
    piece: Ints
    corner: Ints
    start: Ints

    def corners_of(self, region: int) -> Ints:
        """Vertices of one region."""
        return self.corner[self.start[region] : self.start[region + 1]]


def on_common_planes(mesh: trimesh.Trimesh, surface: Surface) -> trimesh.Trimesh:
    """A clean mesh with flat faces level, and flush ones in one plane; the same object where they are already.

    Facets of curves stay as they are. So do planes of which a facet would turn over, as a chamfer of half a millimetre
    would.
    """
    label = _flat_labels(mesh, surface)
    if (label < 0).all():
        return mesh
    faces = _flat_faces(mesh, label)
    vertices, groups = np.asarray(mesh.vertices), _groups(np.asarray(mesh.vertices), faces)
    while any(_misfit(vertices, faces, group) > LEAST_M for group in groups):
        level = trimesh.Trimesh(_moved(vertices, faces, groups), mesh.faces, process=False)
        tipped = ~(np.einsum("tx,tx->t", mesh.face_normals, level.face_normals) > KEPT)
        if not tipped.any():
            return level
        spoilt = np.isin(np.arange(len(vertices)), mesh.faces[tipped])
        groups = [group for group in groups if not spoilt[_corners(faces, group)].any()]
    return mesh


def _flat_labels(mesh: trimesh.Trimesh, surface: Surface) -> Ints:
    """(T,) plane that each facet lies in, -1 for facets of curves; what creases bound and is level is one plane."""
    smooth = mesh.face_adjacency[mesh.face_adjacency_angles < max(CREASE_RAD[surface], CREASE_RAD["auto"])]
    region, island = planar_regions(mesh), components(smooth, len(mesh.faces))
    broad = np.bincount(island, mesh.area_faces) > BROAD_M2
    level = (broad & (plane_misfit(mesh, island) <= LEVEL_M))[island]
    curved = curved_faces(mesh, region, smooth)
    return np.where(level, len(mesh.faces) + island, np.where(curved, -1, region))


def _flat_faces(mesh: trimesh.Trimesh, label: Ints) -> _Faces:
    """The planes of the facets whose label is not -1."""
    flat = np.flatnonzero(label >= 0)
    label = np.unique(label[flat], return_inverse=True)[1]
    normal, offset = mean_planes(trimesh.Trimesh(mesh.vertices, mesh.faces[flat], process=False), label)
    corner = np.column_stack([np.repeat(label, 3), mesh.faces[flat].ravel()])
    corner = corner[distinct(corner)[0]]
    area, piece = np.zeros(len(offset)), np.zeros(len(offset), dtype=np.int64)
    np.add.at(area, label, mesh.area_faces[flat])
    piece[label] = pieces_of(mesh)[flat]
    return _Faces(normal, offset, area, piece, corner[:, 1], np.searchsorted(corner[:, 0], np.arange(len(offset) + 1)))


def _groups(vertices: Floats, faces: _Faces) -> list[list[int]]:
    """Regions that fit one plane, the largest first, each region in one group."""
    free = np.diff(faces.start) > FEWEST
    groups = []
    for seed in np.argsort(-faces.area_m2, kind="stable")[:SEEDS]:
        if free[seed]:
            group = _joined(vertices, faces, int(seed), free)
            free[group] = False
            groups.append(group)
    return groups


def _joined(vertices: Floats, faces: _Faces, seed: int, free: Flags) -> list[int]:
    """A region and the free ones that fit a plane with it, the nearest to its own plane first."""
    height = np.abs(vertices[faces.corner] @ faces.normal[seed] - faces.offset_m[seed])
    worst = np.maximum.reduceat(height, faces.start[:-1])
    worst[seed] = 0.0  # in its own plane, however uneven
    alike = free & (np.abs(faces.normal @ faces.normal[seed]) > ALIKE)
    group = np.flatnonzero(alike & (worst <= LEAST_M)).tolist()
    near = np.flatnonzero(alike & (worst > LEAST_M) & (worst < 4.0 * WITHIN_M))
    for region in near[np.argsort(worst[near], kind="stable")].tolist():
        if faces.piece[region] not in faces.piece[group] and _misfit(vertices, faces, [*group, region]) <= WITHIN_M:
            group.append(region)
    return group


def _corners(faces: _Faces, group: list[int]) -> Ints:
    """(C,) vertices of some regions, in turn."""
    return np.concatenate([faces.corners_of(region) for region in group])


def _plane(vertices: Floats, faces: _Faces, group: list[int]) -> tuple[Floats, float]:
    """(3,) unit normal and offset of the plane that some regions fit best, corners weighted by their region's area."""
    corner = vertices[_corners(faces, group)]
    weight = np.concatenate([np.full(n := len(faces.corners_of(r)), faces.area_m2[r] / n) for r in group])
    middle = np.average(corner, axis=0, weights=weight)
    normal = np.linalg.svd(np.sqrt(weight)[:, None] * (corner - middle), full_matrices=False)[2][-1]
    return normal, float(normal @ middle)


def _misfit(vertices: Floats, faces: _Faces, group: list[int]) -> float:
    """How far the farthest corner of some regions lies from the plane that they fit best, m."""
    normal, offset = _plane(vertices, faces, group)
    return float(np.abs(vertices[_corners(faces, group)] @ normal - offset).max())


def _moved(vertices: Floats, faces: _Faces, groups: list[list[int]]) -> Floats:
    """(V, 3) each vertex at the nearest place on the planes of all groups that it is a corner of."""
    corners = [np.unique(_corners(faces, group)) for group in groups]
    vertex, plane = np.concatenate(corners), np.repeat(np.arange(len(groups)), [len(each) for each in corners])
    normal, offset = (np.array(each) for each in zip(*(_plane(vertices, faces, g) for g in groups), strict=True))
    order = np.argsort(vertex, kind="stable")
    vertex, plane = vertex[order], plane[order]
    first = np.searchsorted(vertex, np.arange(len(vertices) + 1))
    place = np.arange(len(vertex)) - first[vertex]
    normals, gaps = np.zeros((len(vertices), place.max() + 1, 3)), np.zeros((len(vertices), place.max() + 1))
    normals[vertex, place] = normal[plane]
    gaps[vertex, place] = offset[plane] - np.einsum("cx,cx->c", vertices[vertex], normal[plane])
    moved: Floats = vertices + np.einsum("vxp,vp->vx", np.linalg.pinv(normals, rcond=ALONG), gaps)
    return moved
