"""Hedges: foliage as what it is to a 17 mm wave, a cloud of leaf discs, each a mirror of its own."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch.support.arrays import Floats
from scenes.obstacles.measures import measured, require_least

LEAF_M = 0.08  # side of a leaf, with the area of a leaf of cherry laurel
LEAVES_M2 = 15.0  # one in five or so of the leaves that a wave meets first: paths between mirrors grow as their square
DEPTH_M = 0.10  # how deep those leaves lie
MOST_LEAVES = 100_000


@measured
def hedge(length_m: float = 1.2, height_m: float = 1.0, depth_m: float = 0.5) -> trimesh.Trimesh:
    """Square leaves within 10 cm of the front, back, ends and top of a box along y, at random angles about its normals.

    Args:
        length_m, height_m, depth_m: of the box.

    Returns:
        An open mesh, two triangles a leaf, both sides of which reflect.

    Raises:
        ValueError: a measure that is not positive or below the side of a leaf, or more than 100,000 leaves.
    """
    for label, value in (("length_m", length_m), ("height_m", height_m), ("depth_m", depth_m)):
        require_least(label, value, LEAF_M, "the side of a leaf")
    area = 2.0 * height_m * (length_m + depth_m) + length_m * depth_m
    if LEAVES_M2 * area > MOST_LEAVES:
        given = f"{length_m:g} x {height_m:g} x {depth_m:g} m"
        raise ValueError(f"a hedge must have at most {MOST_LEAVES} leaves, {LEAVES_M2:g} a m2, got {given}")
    rng, size = np.random.default_rng(0), np.array([depth_m, length_m, height_m])
    sides = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, 1.0)]
    middle, normal = (np.concatenate(part) for part in zip(*(_leaves(rng, size, k, s) for k, s in sides), strict=True))
    return _squares(middle, normal, rng)


def _leaves(rng: np.random.Generator, size_m: Floats, axis: int, side: float) -> tuple[Floats, Floats]:
    """(N, 3) middles and normals of the leaves behind one side of a box that stands on z = 0."""
    across = np.delete(size_m, axis)
    count = int(np.ceil(LEAVES_M2 * across.prod()))
    reach = 0.5 * LEAF_M
    place = rng.uniform(-0.5, 0.5, (count, 3)) * (size_m - 2.0 * reach)
    place[:, axis] = side * (0.5 * size_m[axis] - reach - rng.uniform(0.0, DEPTH_M, count))
    outwards = np.zeros(3)
    outwards[axis] = side
    normal = outwards + rng.normal(0.0, 0.5, (count, 3))
    return place + [0.0, 0.0, 0.5 * size_m[2]], normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _squares(middle_m: Floats, normal: Floats, rng: np.random.Generator) -> trimesh.Trimesh:
    """Squares about (N, 3) middles at right angles to unit normals, each rotated at random in its plane."""
    turn = Rotation.from_rotvec(rng.uniform(0.0, 2.0 * np.pi, len(normal))[:, None] * normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    first = turn.apply(first / np.linalg.norm(first, axis=1, keepdims=True)) * LEAF_M / 2
    second = np.cross(normal, first)
    corner = np.stack([first + second, second - first, -first - second, first - second], axis=1)
    start = 4 * np.arange(len(normal))[:, None, None]
    faces = (start + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    return trimesh.Trimesh((middle_m[:, None] + corner).reshape(-1, 3), faces, process=False)
