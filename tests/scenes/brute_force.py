"""Ground truth the slow way: meshes and walks sampled densely in float64; shares no code with `scenes.truth.truth`.

A body that comes from outside first touches an obstacle at an edge of one of its triangles as seen from above, so it
is the edges that are sampled, 4 mm apart, of the part between the ground and the walker's height.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle

Array = NDArray[np.float64]

SPACING_M = 0.008
HALF_WIDTH_M, FRONT_M, BACK_M, HEIGHT_M = 0.25, 0.10, 0.60, 1.8
"""The walker of `scenes.truth.swept.Body`, written down again."""


@dataclass(frozen=True)
class Passage:
    """How a walker passes an obstacle: smallest gap (below 0 if they meet), and the first contact."""

    gap_m: float
    contact_time_s: float


def passage(samples_m: Array, obstacle: Obstacle, walk: Walk) -> Passage:
    """The smallest gap between body and obstacle over a walk, and when they first meet; samples of its edges."""
    tree = cKDTree(samples_m)
    coarse = np.linspace(0.0, walk.duration_s, 1 + int(np.ceil(walk.duration_s / 0.01)))
    distance = _to_core(tree, obstacle, walk, coarse, 6)
    # In 10 ms bodies that close in at 3 m/s dip by up to 0.5 mm between two samples, and 4 cm between points of the
    # core hide 0.8 mm: what comes within 2 mm of the least, or of contact until the first, is looked at again.
    least, touching = float(distance.min()), np.flatnonzero(distance <= HALF_WIDTH_M)
    until = touching[0] if len(touching) else len(coarse)
    near = distance < max(least, HALF_WIDTH_M) + 0.002
    near &= np.arange(len(coarse)) <= until
    near[np.argmin(distance)] = True
    fine = coarse[near][:, None] + np.arange(-10, 11) * 1e-3
    fine = np.unique(np.clip(fine, 0.0, walk.duration_s))
    distance = _to_core(tree, obstacle, walk, fine, 21)
    touching = np.flatnonzero(distance <= HALF_WIDTH_M)
    return Passage(float(distance.min()) - HALF_WIDTH_M, float(fine[touching[0]]) if len(touching) else np.nan)


def _to_core(tree: cKDTree, obstacle: Obstacle, walk: Walk, time_s: Array, count: int) -> Array:
    """(N,) distance between the samples and points along the body's core."""
    pose = walk.pose(time_s)
    along = np.linspace(HALF_WIDTH_M - BACK_M, FRONT_M - HALF_WIDTH_M, count)
    heading = pose.body_heading_rad()
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    place = pose.position_m[:, :2] - np.outer(time_s, obstacle.velocity_m_s[:2])
    core = place[:, None] + along[:, None] * ahead[:, None]
    return np.asarray(tree.query(core.reshape(-1, 2))[0]).reshape(len(time_s), -1).min(axis=1)


def miss_distance(samples_m: Array, way_m: Array, ahead: Array) -> float:
    """Distance between samples and a way (N, 2) that goes on for 30 m in a direction (2,)."""
    line = np.concatenate([way_m, way_m[-1] + np.outer(np.arange(0.0, 30.0, 0.004), ahead / np.linalg.norm(ahead))])
    return float(cKDTree(samples_m).query(line)[0].min())


def plan_samples(mesh: trimesh.Trimesh) -> Array:
    """(K, 2) points of all edges of the part between the ground and the walker's height, in plan."""
    segments = _clipped_edges(mesh)
    count = np.maximum(1, np.ceil(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) / SPACING_M).astype(int))
    which = np.repeat(np.arange(len(segments)), count + 1)
    first = np.cumsum(count + 1) - (count + 1)
    step = (np.arange(len(which)) - first[which]) / count[which]
    start, end = segments[which, 0], segments[which, 1]
    return start + step[:, None] * (end - start)


def _clipped_edges(mesh: trimesh.Trimesh) -> Array:
    """(E, 2, 2) edges in plan within the heights, and the cuts of the triangles at both heights."""
    vertices = np.asarray(mesh.vertices)
    parts = [_within(vertices[mesh.edges_unique])]
    for height in (0.0, HEIGHT_M):
        cut = trimesh.intersections.mesh_plane(mesh, [0.0, 0.0, 1.0], [0.0, 0.0, height])
        parts.append(np.asarray(cut).reshape(-1, 2, 3)[..., :2])
    return np.concatenate(parts)


def _within(edges: Array) -> Array:
    """Edges (E, 2, 3) cut to the heights, in plan; those outside are left out."""
    low, high = edges[..., 2].min(axis=1), edges[..., 2].max(axis=1)
    edges = edges[(high >= 0.0) & (low <= HEIGHT_M)]
    z = edges[..., 2]
    rise = z[:, 1] - z[:, 0]
    level = np.abs(rise) < 1e-12
    safe = np.where(level, 1.0, rise)
    shares = np.sort(np.stack([(0.0 - z[:, 0]) / safe, (HEIGHT_M - z[:, 0]) / safe], axis=1), axis=1)
    shares = np.where(level[:, None], [0.0, 1.0], np.clip(shares, 0.0, 1.0))
    along = edges[:, 1] - edges[:, 0]
    return (edges[:, :1] + shares[:, :, None] * along[:, None])[..., :2]


def nearest_distance(mesh: trimesh.Trimesh, point_m: Array, finest_m: float = 0.004) -> float:
    """Distance from a point to a mesh: triangles are halved again and again, and dropped once they are too far.

    What is left is sampled by its corners, less than 4 mm from any point of it: at 0.3 m and more the distance to the
    nearest corner is too great by less than 0.03 mm.
    """
    triangles = np.asarray(mesh.triangles, dtype=np.float64) - point_m
    best = np.inf
    while len(triangles):
        corner = np.linalg.norm(triangles, axis=2)
        best = min(best, float(corner.min()))
        side = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
        longest = side.max(axis=1)
        kept = (corner.min(axis=1) - longest <= best) & (longest > finest_m)
        triangles, side = triangles[kept], side[kept]
        triangles = _halved(triangles, side)
    return best


def _halved(triangles: Array, side: Array) -> Array:
    """Every triangle cut in two at the middle of its longest side; side k joins the corners k and k - 1."""
    if len(triangles) == 0:
        return triangles
    rows, k = np.arange(len(triangles)), np.argmax(side, axis=1)
    a, b, c = triangles[rows, k], triangles[rows, k - 1], triangles[rows, (k + 1) % 3]
    middle = 0.5 * (a + b)
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
