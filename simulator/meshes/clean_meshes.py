"""Meshes as users have them, made fit to be read: joined at equal vertices, wound alike, each facet once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.scene.scene import welded, with_area

TOGETHER_M = 1e-5  # a two-thousandth of the wavelength; drawn together only what then is closed


def cleaned(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, bool]:
    """A cleaned copy, and whether it is closed: watertight and consistently wound."""
    copy = _joined(mesh)
    closed = _is_closed(copy)
    return copy if closed else _wound_alike(_each_once(copy)), closed


def _joined(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy with equal vertices merged (triangle soups included) and without facets of no area.

    Closed parts that touch along an edge stay apart: four facets on one edge belong to no closed surface, and a tree
    whose boughs share a ring would be taken for open.
    """
    apart = trimesh.Trimesh(np.array(mesh.vertices, float), np.array(mesh.faces), process=False)
    copy = next(filter(_is_closed, _readings(apart)), None)
    if copy is None:
        better = (_each_once(_with_area(each)) for each in (apart, _drawn_together(apart)))
        copy = next((each for mesh in better for each in _readings(mesh) if _is_closed(each)), welded(apart))
    return _with_area(copy)


def _drawn_together(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy whose vertices within `TOGETHER_M` of one another are one: of soups whose corners hardly agree."""
    joined = welded(mesh)
    pairs = cKDTree(joined.vertices).query_pairs(TOGETHER_M, output_type="ndarray")
    _, first, which = np.unique(components(pairs, len(joined.vertices)), return_index=True, return_inverse=True)
    return trimesh.Trimesh(joined.vertices[first], which[joined.faces], process=False)


def _readings(apart: trimesh.Trimesh) -> Iterator[trimesh.Trimesh]:
    """A mesh merged, as it is, and merged in parts."""
    merged = welded(apart)
    yield from (merged, apart)
    yield _in_parts(merged)


def _with_area(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy without facets of no area."""
    copy = mesh.copy()
    copy.update_faces(with_area(copy))
    copy.remove_unreferenced_vertices()
    return copy


def _in_parts(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh with vertices of its own for all facets that hang together over edges of two: soups of touching bodies."""
    label = components(mesh.face_adjacency, len(mesh.faces))
    corners = np.column_stack([np.repeat(label, 3), mesh.faces.ravel()])
    own, faces = np.unique(corners, axis=0, return_inverse=True)
    return trimesh.Trimesh(mesh.vertices[own[:, 1]], faces.reshape(-1, 3), process=False)


def _is_closed(mesh: trimesh.Trimesh) -> bool:
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


def _each_once(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh without facets on the same corners as earlier ones, through which no facet would find its neighbour."""
    first = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_index=True)[1]
    return trimesh.Trimesh(mesh.vertices, mesh.faces[np.sort(first)], process=False)


def _wound_alike(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh whose neighbouring facets are wound alike wherever they can be: smooth ones share their normals.

    Every facet has two copies, as it is and flipped; copies that agree across a shared edge are joined. On what
    cannot be wound alike, as Moebius' strip, both copies hang together, and it stays as it is.
    """
    if mesh.is_winding_consistent:
        return mesh
    pairs, edges, count = mesh.face_adjacency, mesh.face_adjacency_edges, len(mesh.faces)
    one, other = pairs.T
    against = _runs_along(mesh.faces[one], edges) == _runs_along(mesh.faces[other], edges)
    as_is, over = (
        np.column_stack([one, other + count * against]),
        np.column_stack([one + count, other + count * ~against]),
    )
    copy = components(np.concatenate([as_is, over]), 2 * count)
    _, first, part = np.unique(components(pairs, count), return_index=True, return_inverse=True)
    flipped = copy[:count] != copy[first[part]]
    faces = np.where(flipped[:, None], mesh.faces[:, ::-1], mesh.faces)
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def turned_inwards(closed: trimesh.Trimesh) -> Floats:
    """(B, 2, 3) boxes round pieces of a closed mesh that are wound inwards, as rooms are, and hollow out no other."""
    piece = components(closed.face_adjacency, len(closed.faces))
    corners = closed.vertices[closed.faces] - closed.bounds.mean(axis=0)
    volume = np.bincount(piece, np.einsum("tx,tx->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    inwards, outwards = (
        np.array([_box(closed.vertices[closed.faces[piece == each]]) for each in np.flatnonzero(wound)]).reshape(
            -1, 2, 3
        )
        for wound in (volume < 0.0, volume > 0.0)
    )
    low = np.all(inwards[:, None, 0] >= outwards[:, 0], axis=2)
    high = np.all(inwards[:, None, 1] <= outwards[:, 1], axis=2)
    boxes: Floats = inwards[~np.any(low & high, axis=1)]
    return boxes


def _box(corners_m: Floats) -> tuple[Floats, Floats]:
    """Lowest and highest corner of the box round facets (T, 3, 3)."""
    return corners_m.min(axis=(0, 1)), corners_m.max(axis=(0, 1))


def _runs_along(faces: Ints, edges: Ints) -> Flags:
    """(A,) whether facets (A, 3) run through their edges (A, 2) from the first vertex to the second."""
    forth = (faces == edges[:, :1]) & (np.roll(faces, -1, axis=1) == edges[:, 1:])
    found: Flags = forth.any(axis=1)
    return found


def components(pairs: Ints, count: int) -> Ints:
    """(count,) label of what hangs together by the pairs given."""
    return trimesh.graph.connected_component_labels(pairs, node_count=count).astype(np.int64)
