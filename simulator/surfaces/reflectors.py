"""Meshes read as reflectors: planar patches and smooth curved surfaces.

Neighbouring facets within a hair of one plane are merged into one patch, so that a wall returns one echo whatever
its triangles. Facets that meet at less than the crease angle belong to one smooth surface, which is rebuilt from
its vertex normals (Nagata 2005, quadratic triangles); a facet of such a surface is never a mirror of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import trimesh
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.vectors import norm
from simulator.meshes.clean_meshes import cleaned, rooms_in
from simulator.meshes.common_planes import on_common_planes
from simulator.meshes.cone_tips import tips_opened
from simulator.meshes.pieces import components, pieces_of
from simulator.meshes.planar_regions import CREASE_RAD, broad_folds, curved_faces, mean_planes, planar_regions
from simulator.scene.scene import Obstacle
from simulator.surfaces.facet_bounds import Clusters, clusters
from simulator.surfaces.quadratic_triangles import bulges
from simulator.surfaces.thin_plate_rims import rims
from simulator.surfaces.vertex_normals import vertex_geometry


@dataclass(frozen=True)
class PlanarPatches:
    """Merged coplanar facets of all obstacles.

    Attributes:
        normal: (P, 3) unit normal, outwards where the mesh is consistently wound.
        offset_m: (P,) plane n . x = offset.
        one_sided: (P,) bool, the back is inside a closed body.
        obstacle: (P,) index of the obstacle.
        center_m, radius_m: (P, 3), (P,) bounding sphere.
        area_m2: (P,).
        edge_m: (E, 2, 3) boundary segments of all patches, in order.
        edge_start: (P + 1,) where the segments of each patch begin.
    """

    normal: Floats
    offset_m: Floats
    one_sided: Flags
    obstacle: Ints
    center_m: Floats
    radius_m: Floats
    area_m2: Floats
    edge_m: Floats
    edge_start: Ints

    def __len__(self) -> int:
        return len(self.offset_m)

    @cached_property
    def corner_m(self) -> Floats:
        """(P, 4, 3) corners, one after the other, of a rectangle round each patch along its longest border."""
        start = self.edge_start[:-1]
        along = self.edge_m[:, 1] - self.edge_m[:, 0]
        length = norm(along)
        longest = np.lexsort((-length, np.repeat(np.arange(len(self)), np.diff(self.edge_start))))[start]
        one = along[longest] / length[longest, None]
        other = np.cross(self.normal, one)
        ends = []
        for axis in (one, other):
            place = np.einsum("eix,ex->ei", self.edge_m, np.repeat(axis, np.diff(self.edge_start), axis=0))
            ends.append((np.minimum.reduceat(place.min(axis=1), start), np.maximum.reduceat(place.max(axis=1), start)))
        foot = self.offset_m[:, None] * self.normal
        turns = ((0, 0), (1, 0), (1, 1), (0, 1))
        return np.stack([foot + ends[0][i][:, None] * one + ends[1][j][:, None] * other for i, j in turns], axis=1)


@dataclass(frozen=True, eq=False)
class SmoothSurface:
    """The curved facets of one obstacle as quadratic triangles.

    Attributes:
        obstacle: index of the obstacle.
        corner_m: (T, 3, 3) corners of the facets.
        normal: (T, 3, 3) unit normals at the corners, shared across smooth edges, split at creases.
        curvature: (T, 3, 3, 3) curvature tensors at the corners, dn = K dx, 1/m.
        bulge_m: (T, 3, 3) Nagata's edge vectors for edges 01, 12, 02.
        neighbor: (T, 3) facet across edges 01, 12, 20; -1 at a crease or border.
        sag_m: (T,) how far the rounded surface may stand off its facet.
        closed: the obstacle is watertight, so only its outside reflects.
        center_m, radius_m: bounding sphere.
        clusters: groups of facets for the search.
    """

    obstacle: int
    corner_m: Floats
    normal: Floats
    curvature: Floats
    bulge_m: Floats
    neighbor: Ints
    sag_m: Floats
    closed: bool
    center_m: Floats
    radius_m: float
    clusters: Clusters

    def __len__(self) -> int:
        return len(self.corner_m)


@dataclass(frozen=True, eq=False)
class MeshReading:
    """What each facet of an obstacle is: part of a plane, of a smooth surface, or of the rim of a thin plate.

    Attributes:
        mesh: cleaned copy, world frame.
        closed: watertight and consistently wound: only the outside reflects.
        solid: the closed mesh with the tips of its cones, which `mesh` lacks; None if it is not closed.
        patch: (T,) planar patch of each facet, -1 for smooth facets and rims.
        smooth_edges: (A, 2) pairs of facets that meet below the crease angle.
        curved: (T,) facets of the smooth surface.
        rim: (T,) facets of the rims of thin plates, which neither mirror nor bend.
        sheet_m: (T,) thickness of the thin plate whose face a facet is part of; 0 for all others.
    """

    mesh: trimesh.Trimesh
    closed: bool
    solid: trimesh.Trimesh | None
    patch: Ints
    smooth_edges: Ints
    curved: Flags
    rim: Flags
    sheet_m: Floats

    @cached_property
    def piece(self) -> Ints:
        """(T,) which of the mesh's connected pieces each facet is of."""
        return pieces_of(self.mesh)

    @cached_property
    def solid_pieces(self) -> Flags:
        """Which of the pieces are closed: all of a closed mesh, else those each of whose edges has two facets."""
        mesh, solid = self.mesh, np.ones(int(self.piece.max(initial=-1)) + 1, dtype=bool)
        if not self.closed:
            edge = mesh.edges_unique_inverse
            solid[self.piece[mesh.edges_face[(np.bincount(edge) != 2)[edge]]]] = False
        return solid

    @cached_property
    def rooms_m(self) -> Floats:
        """(B, 2, 3) boxes round closed pieces that reflect inwards: a phone outside of one has no echo of it."""
        return np.zeros((0, 2, 3)) if self.solid is None else rooms_in(self.solid)

    @property
    def planes(self) -> int:
        """Number of planar patches."""
        return int(self.patch.max(initial=-1)) + 1

    @property
    def plated(self) -> bool:
        """Whether any of it is a thin plate."""
        return bool((self.sheet_m > 0.0).any())


def read_mesh(obstacle: Obstacle) -> MeshReading:
    """Tell the facets of an obstacle apart, once its flush faces are on common planes."""
    mesh, closed = cleaned(obstacle.mesh)
    level = on_common_planes(mesh, obstacle.surface)
    if level is not mesh:
        mesh, closed = cleaned(level)
    solid = mesh if closed else None
    mesh = tips_opened(mesh, CREASE_RAD[obstacle.surface])
    regions = planar_regions(mesh)
    smooth = mesh.face_adjacency_angles < max(CREASE_RAD[obstacle.surface], 1e-6)
    if obstacle.surface == "auto":
        smooth[broad_folds(mesh, regions, np.flatnonzero(smooth))] = False
    smooth_edges = mesh.face_adjacency[smooth]
    curved = curved_faces(mesh, regions, smooth_edges)
    rim, sheet_m = np.zeros(len(curved), dtype=bool), np.zeros(len(curved))
    if closed:
        rim, thickness = rims(mesh, regions, *mean_planes(mesh, regions))
        sheet_m = thickness[regions]
    planar = ~(curved | rim)
    patch = np.full(len(curved), -1)
    patch[planar] = np.unique(regions[planar], return_inverse=True)[1]
    return MeshReading(mesh, closed, solid, patch, smooth_edges, curved & ~rim, rim, sheet_m)


def reflectors_in(reading: MeshReading) -> tuple[PlanarPatches, SmoothSurface | None]:
    """Planar patches of a mesh already read, and its smooth surface if it has one, as of obstacle 0."""
    mesh, curved, closed = reading.mesh, reading.curved, reading.closed
    patches = _patches(mesh, reading.patch, closed)
    surface = _smooth_surface(mesh, curved, reading.smooth_edges, closed) if curved.any() else None
    return patches, surface


def merge_patches(parts: list[PlanarPatches]) -> PlanarPatches:
    """All parts as one set, in order."""
    counts = np.concatenate([np.zeros(0, np.int64)] + [np.diff(part.edge_start) for part in parts])
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)

    def joined(name: str, shape: tuple[int, ...], dtype: type) -> NDArray:
        return np.concatenate([np.zeros((0, *shape), dtype)] + [getattr(part, name) for part in parts])

    return PlanarPatches(
        normal=joined("normal", (3,), float), offset_m=joined("offset_m", (), float),
        one_sided=joined("one_sided", (), bool), obstacle=joined("obstacle", (), np.int64),
        center_m=joined("center_m", (3,), float), radius_m=joined("radius_m", (), float),
        area_m2=joined("area_m2", (), float),
        edge_m=joined("edge_m", (2, 3), float), edge_start=start,
    )  # fmt: skip


def _patches(mesh: trimesh.Trimesh, regions: Ints, closed: bool) -> PlanarPatches:
    """One patch per region that is not -1."""
    faces = np.flatnonzero(regions >= 0)
    labels = np.full(len(regions), -1)
    labels[faces] = np.unique(regions[faces], return_inverse=True)[1]
    count = int(labels.max()) + 1
    edges, owner = _boundary_edges(mesh, labels)
    if count == 0:
        return merge_patches([])
    normal, offset = mean_planes(trimesh.Trimesh(mesh.vertices, mesh.faces[faces], process=False), labels[faces])
    corners = mesh.vertices[mesh.faces[faces]]
    center: Floats = np.stack([np.bincount(labels[faces], corners[:, :, k].mean(axis=1)) for k in range(3)], axis=1)
    center /= np.bincount(labels[faces])[:, None]
    radius = np.zeros(count)
    np.maximum.at(radius, labels[faces], norm(corners - center[labels[faces]][:, None]).max(axis=1))
    start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))]).astype(np.int64)
    return PlanarPatches(
        normal, offset, np.full(count, closed), np.zeros(count, dtype=np.int64), center, radius,
        np.bincount(labels[faces], mesh.area_faces[faces]).astype(np.float64),
        mesh.vertices[edges[np.argsort(owner, kind="stable")]], start,
    )  # fmt: skip


def _boundary_edges(mesh: trimesh.Trimesh, labels: Ints) -> tuple[Ints, Ints]:
    """(E, 2) vertex pairs that bound a region, and (E,) the region: edges used once by its facets."""
    faces = np.flatnonzero(labels >= 0)
    edges = np.sort(mesh.faces[faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owned = np.column_stack([np.repeat(labels[faces], 3), edges])
    first, which = distinct(owned)
    once = owned[first[np.bincount(which) == 1]]
    return once[:, 1:], once[:, 0]


def _smooth_surface(mesh: trimesh.Trimesh, curved: Flags, smooth_edges: Ints, closed: bool) -> SmoothSurface:
    """The curved facets with shared normals, rounded edges and neighbours."""
    faces = np.flatnonzero(curved)
    corner = mesh.vertices[mesh.faces[faces]]
    normal, curvature = _corner_geometry(mesh, curved, smooth_edges)
    bulge = bulges(corner, normal)
    center = 0.5 * (corner.min(axis=(0, 1)) + corner.max(axis=(0, 1)))
    sag = 0.25 * norm(bulge).sum(axis=1)
    return SmoothSurface(
        obstacle=0, corner_m=corner, normal=normal, curvature=curvature, bulge_m=bulge,
        neighbor=_neighbors(mesh, faces, smooth_edges), sag_m=sag, closed=closed,
        center_m=center, radius_m=float(norm(corner - center).max()),
        clusters=clusters(corner, normal, sag),
    )  # fmt: skip


def _corner_geometry(mesh: trimesh.Trimesh, curved: Flags, smooth_edges: Ints) -> tuple[Floats, Floats]:
    """(T, 3, 3) unit normals and (T, 3, 3, 3) curvature tensors at the corners of the T curved facets."""
    faces = np.flatnonzero(curved)
    every = _corner_groups(mesh, smooth_edges)
    mean, panel = _mean_normals(mesh, curved, every)
    label, group = np.unique(every[faces], return_inverse=True)
    group = group.reshape(-1, 3)
    point = np.zeros((len(label), 3))
    point[group] = mesh.vertices[mesh.faces[faces]]
    normal, curvature = vertex_geometry(point, group, mesh.face_normals[faces], mean[label], panel[label])
    return normal[group], curvature[group]


def _mean_normals(mesh: trimesh.Trimesh, curved: Flags, group: Ints) -> tuple[Floats, Flags]:
    """(G, 3) angle-weighted mean normal of each group of corners, and (G,) whether a panel takes part.

    A panel's normal is its own: where a curve runs tangentially into a panel, the corner takes the panel's normal.
    """
    weight = np.where(curved[:, None], mesh.face_angles, 1e6 * mesh.face_angles)
    total = np.zeros((group.max() + 1, 3))
    np.add.at(total, group.ravel(), (weight[:, :, None] * mesh.face_normals[:, None, :]).reshape(-1, 3))
    total /= norm(total)[..., None]
    panel = np.zeros(len(total), dtype=bool)
    panel[group[~curved].ravel()] = True
    return total, panel


def _corner_groups(mesh: trimesh.Trimesh, smooth_edges: Ints) -> Ints:
    """(T, 3) label of each facet corner; corners at one vertex share it if joined through smooth edges."""
    corner_of = {0: mesh.faces[smooth_edges[:, 0]], 1: mesh.faces[smooth_edges[:, 1]]}
    same = corner_of[0][:, :, None] == corner_of[1][:, None, :]
    row, first, second = np.nonzero(same)
    pairs = np.column_stack([3 * smooth_edges[row, 0] + first, 3 * smooth_edges[row, 1] + second])
    return components(pairs, 3 * len(mesh.faces)).reshape(-1, 3)


def _neighbors(mesh: trimesh.Trimesh, faces: Ints, smooth_edges: Ints) -> Ints:
    """(T, 3) index within `faces` of the smooth neighbour across edges 01, 12, 20; -1 where there is none."""
    position = np.full(len(mesh.faces), -1)
    position[faces] = np.arange(len(faces))
    neighbor = np.full((len(faces), 3), -1)
    for here, there in (smooth_edges.T, smooth_edges.T[::-1]):
        inside = position[here] >= 0
        shared = (mesh.faces[here][:, :, None] == mesh.faces[there][:, None, :]).any(axis=2)
        missing = np.argmin(shared, axis=1)  # the corner that the neighbour lacks is opposite the edge
        neighbor[position[here[inside]], (missing[inside] + 1) % 3] = position[there[inside]]
    return neighbor
