"""Round bodies meshed in every manner, with their vertices on the true surface, and one of leaning faces."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull


def soup(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The same triangles, each with corners of its own, as an STL file has them."""
    return trimesh.Trimesh(mesh.triangles.reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False)


def uv_sphere(radius_m: float, segments: int) -> trimesh.Trimesh:
    """Sphere of meridians and parallels; `segments` facets round the equator."""
    return trimesh.creation.uv_sphere(radius_m, count=[segments // 2 + 1, segments])


def icosphere(radius_m: float, subdivisions: int) -> trimesh.Trimesh:
    """Sphere of nearly equal triangles: 20 x 4^subdivisions of them."""
    return trimesh.creation.icosphere(subdivisions, radius_m)


def jittered_sphere(radius_m: float, segments: int, rng: np.random.Generator, share: float = 0.3) -> trimesh.Trimesh:
    """Sphere of evenly spread vertices, each moved along the surface by up to `share` of the spacing."""
    count = int(segments**2 / np.pi)  # spacing 2 pi a / segments
    step = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * step / count, np.pi * (1.0 + np.sqrt(5.0)) * step
    point = np.stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z], axis=1)
    point += share * (2.0 * np.pi / segments) * rng.uniform(-1.0, 1.0, point.shape)
    return hull(radius_m * point / np.linalg.norm(point, axis=1, keepdims=True))


def hull(point_m: NDArray[np.float64]) -> trimesh.Trimesh:
    """Convex hull of points that are all corners of it, wound outwards."""
    mesh = trimesh.Trimesh(point_m, ConvexHull(point_m).simplices, process=False)
    trimesh.repair.fix_normals(mesh)
    return mesh


def tube(radius_m: float, height_m: float, segments: int, rows: int, top_radius_m: float | None = None,
         rng: np.random.Generator | None = None, share: float = 0.3) -> trimesh.Trimesh:  # fmt: skip
    """Open upright cylinder or cone about the z axis, centred; with `rng` its vertices wander along the surface.

    Vertices move by up to `share` of the spacing each way, round the body and, but for the two rims, along it.
    """
    top = radius_m if top_radius_m is None else top_radius_m
    row, column = np.meshgrid(np.arange(rows + 1.0), np.arange(float(segments)), indexing="ij")
    if rng is not None:
        column += share * rng.uniform(-1.0, 1.0, column.shape)
        row[1:-1] += share * rng.uniform(-1.0, 1.0, row[1:-1].shape)
    angle, up = 2.0 * np.pi * column / segments, row / rows
    radius = radius_m + (top - radius_m) * up
    point = np.stack([radius * np.cos(angle), radius * np.sin(angle), height_m * (up - 0.5)], axis=-1)
    return grid(point)


def grid(point_m: NDArray[np.float64], closed: bool = False) -> trimesh.Trimesh:
    """(R, S, 3) rings of points, each closed on itself, joined by triangles; `closed` joins the last to the first."""
    rings, segments = point_m.shape[:2]
    index = np.arange(rings * segments).reshape(rings, segments)
    here = index if closed else index[:-1]
    above = np.roll(index, -1, axis=0)[: len(here)]
    right, across = np.roll(here, -1, axis=1), np.roll(above, -1, axis=1)
    faces = np.concatenate([np.stack([here, right, across], -1), np.stack([here, across, above], -1)]).reshape(-1, 3)
    return trimesh.Trimesh(point_m.reshape(-1, 3), faces, process=False)


def torus(major_m: float, minor_m: float, segments: int, rings: int) -> trimesh.Trimesh:
    """Ring about the z axis, wound outwards; `rings` round its tube."""
    around, tube_angle = np.arange(segments) * 2 * np.pi / segments, np.arange(rings) * 2 * np.pi / rings
    radius = major_m + minor_m * np.cos(tube_angle)[:, None]
    point = np.stack(np.broadcast_arrays(radius * np.cos(around), radius * np.sin(around),
                                         minor_m * np.sin(tube_angle)[:, None]), axis=-1)  # fmt: skip
    return grid(point, closed=True)


def stretched(mesh: trimesh.Trimesh, semi_axes_m: NDArray[np.float64]) -> trimesh.Trimesh:
    """Ellipsoid from a sphere of radius 1."""
    return trimesh.Trimesh(mesh.vertices * semi_axes_m, mesh.faces, process=False)


def frustum() -> trimesh.Trimesh:
    """Square and narrowing upwards, 80 to 50 cm over a height of 90: four leaning faces."""
    corners = [[x * half, y * half, z] for half, z in ((0.4, 0.0), (0.25, 0.9)) for x in (-1, 1) for y in (-1, 1)]
    return trimesh.convex.convex_hull(np.array(corners))
