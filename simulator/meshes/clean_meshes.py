"""Meshes as users have them, made fit to be read: joined at equal vertices, wound alike, each facet once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from simulator.meshes.pieces import components, pieces_of, with_own_corners
from simulator.meshes.stitched import stitched
from simulator.meshes.touching_bodies import read_apart
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
    merged = welded(apart)
    return next(filter(_is_closed, map(_with_area, _readings(apart, merged))), _with_area(merged))


def _readings(apart: trimesh.Trimesh, merged: trimesh.Trimesh) -> Iterator[trimesh.Trimesh]:
    """What may close a mesh, given as it is and merged: what changes it least comes first, and nothing twice."""
    yield from _mergings(apart, merged)
    once = _without_excess(apart)
    if len(once.faces) < len(apart.faces):
        yield from _mergings(once, welded(once))
    together = _drawn_together(merged)
    drawn = _without_excess(together)
    if len(together.vertices) < len(merged.vertices):
        yield from _mergings(drawn, welded(drawn))
    bodies = read_apart(merged)
    if bodies is not merged:
        yield bodies
    whole = stitched(drawn, TOGETHER_M)
    if len(whole.faces) > len(drawn.faces):
        yield from _mergings(whole, whole)
    if not (apart.is_winding_consistent and merged.is_winding_consistent):
        yield from _mergings(_wound_alike(apart), _wound_alike(merged))


def _mergings(apart: trimesh.Trimesh, merged: trimesh.Trimesh) -> Iterator[trimesh.Trimesh]:
    """A mesh merged, as it is, and merged in parts."""
    yield merged
    if len(merged.vertices) < len(apart.vertices):
        yield apart
    piece = pieces_of(merged)
    if piece.any():
        yield with_own_corners(merged, np.repeat(piece, 3))  # soups of touching bodies


def _drawn_together(merged: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy whose vertices within `TOGETHER_M` of one another are one: of soups whose corners hardly agree."""
    pairs = cKDTree(merged.vertices).query_pairs(TOGETHER_M, output_type="ndarray")
    _, first, which = np.unique(components(pairs, len(merged.vertices)), return_index=True, return_inverse=True)
    return trimesh.Trimesh(merged.vertices[first], which[merged.faces], process=False)


def _without_excess(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy without facets of no area, and with each of the others once."""
    return _each_once(_with_area(mesh))


def _with_area(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy without facets of no area."""
    copy = mesh.copy()
    copy.update_faces(with_area(copy))
    copy.remove_unreferenced_vertices()
    return copy


def _is_closed(mesh: trimesh.Trimesh) -> bool:
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


def _each_once(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh without facets on the same corners as earlier ones, through which no facet would find its neighbour."""
    first, _ = distinct(np.sort(mesh.faces, axis=1))
    return trimesh.Trimesh(mesh.vertices, mesh.faces[np.sort(first)], process=False)


def _wound_alike(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh whose neighbouring facets are wound alike wherever they can be: smooth ones share their normals.

    Every facet has two copies, as it is and flipped; copies that agree across a shared edge are joined. Of a piece the
    lesser area is flipped. On what cannot be wound alike, as Moebius' strip, both copies hang together, and it stays as
    it is.
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
    _, first, part = np.unique(pieces_of(mesh), return_index=True, return_inverse=True)
    flipped = copy[:count] != copy[first[part]]
    over_m2, all_m2 = np.bincount(part, mesh.area_faces * flipped), np.bincount(part, mesh.area_faces)
    flipped ^= (over_m2 > 0.5 * all_m2)[part] & (copy[:count] != copy[count:])
    faces = np.where(flipped[:, None], mesh.faces[:, ::-1], mesh.faces)
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def rooms_in(closed: trimesh.Trimesh) -> Floats:
    """(B, 2, 3) boxes round pieces of a closed mesh that are wound inwards, as rooms are, and hollow out no other."""
    piece, corners = pieces_of(closed), closed.vertices[closed.faces]
    about = corners - closed.bounds.mean(axis=0)
    volume = np.bincount(piece, np.einsum("tx,tx->t", about[:, 0], np.cross(about[:, 1], about[:, 2])))
    low, high = np.full((len(volume), 3), np.inf), np.full((len(volume), 3), -np.inf)
    np.minimum.at(low, piece, corners.min(axis=1))
    np.maximum.at(high, piece, corners.max(axis=1))
    inwards, outwards = volume < 0.0, volume > 0.0
    hollows = np.all((low[inwards, None] >= low[outwards]) & (high[inwards, None] <= high[outwards]), axis=2)
    boxes: Floats = np.stack([low[inwards], high[inwards]], axis=1)[~hollows.any(axis=1)]
    return boxes


def _runs_along(faces: Ints, edges: Ints) -> Flags:
    """(A,) whether facets (A, 3) run through their edges (A, 2) from the first vertex to the second."""
    forth = (faces == edges[:, :1]) & (np.roll(faces, -1, axis=1) == edges[:, 1:])
    found: Flags = forth.any(axis=1)
    return found
