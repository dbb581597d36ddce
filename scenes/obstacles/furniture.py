"""Clutter of a street: trees, bollards, lamp posts, benches, and the ground itself."""

from __future__ import annotations

import numpy as np
import trimesh

from scenes.solids import box, cylinder, ellipse_rings, loft, merged, require_positive, shifted, tilted
from simulator.materials import Material
from simulator.scene import Obstacle


def ground(size_m: tuple[float, float] = (60.0, 60.0)) -> trimesh.Trimesh:
    """A level rectangle in z = 0, centred, facing up: two triangles, open.

    Raises:
        ValueError: a side that is not positive.
    """
    x, y = (require_positive("side of the ground", side) / 2 for side in size_m)
    corners = [[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def bollard(radius_m: float = 0.08, height_m: float = 0.9) -> trimesh.Trimesh:
    """A post with a domed top.

    Raises:
        ValueError: a measure that is not positive, or a post no taller than its radius.
    """
    if not height_m > require_positive("radius_m", radius_m):
        raise ValueError(f"height_m must be above the radius {radius_m} m, got {height_m}")
    shoulder = height_m - radius_m
    latitude = np.linspace(0.0, np.pi / 2, 7)[1:-1]
    z = np.concatenate([np.linspace(0.0, shoulder, 5), shoulder + radius_m * np.sin(latitude)])
    radius = np.concatenate([np.full(5, radius_m), radius_m * np.cos(latitude)])
    return loft(ellipse_rings(z, radius, segments=32), top_m=[0.0, 0.0, height_m])


def lamp_post(radius_m: float = 0.08, height_m: float = 4.0) -> trimesh.Trimesh:
    """A slightly tapered mast with a lantern.

    Raises:
        ValueError: a measure that is not positive.
    """
    mast = cylinder(radius_m, height_m, 32, rows=8, top_radius_m=0.6 * radius_m)
    lantern = shifted(cylinder(0.12, 0.35, 32, rows=2, top_radius_m=0.2), [0.0, 0.0, height_m])
    return merged([mast, lantern])


def tree(trunk_radius_m: float = 0.14, fork_m: float = 2.2, height_m: float = 4.5) -> trimesh.Trimesh:
    """A leafless street tree: a tapered trunk with a root flare, and four boughs from the fork.

    Raises:
        ValueError: a measure that is not positive, or a fork above the top.
    """
    require_positive("trunk_radius_m", trunk_radius_m)
    if not 0.0 < fork_m < height_m:
        raise ValueError(f"fork_m must lie between 0 and the height {height_m} m, got {fork_m}")
    z = np.concatenate([np.linspace(0.0, 0.4, 5), np.linspace(0.4, fork_m, 7)[1:]])
    radius = trunk_radius_m * (1.0 - 0.2 * z / fork_m + 0.35 * np.exp(-z / 0.15))
    trunk = loft(ellipse_rings(z, radius, segments=32))
    return merged([trunk, *(_bough(trunk_radius_m, fork_m, height_m, k) for k in range(4))])


def bench(length_m: float = 1.6) -> trimesh.Trimesh:
    """A bench along y with a seat, a back on its +x side, and two side supports.

    Raises:
        ValueError: a length that is not positive.
    """
    require_positive("length_m", length_m)
    seat = box([0.42, length_m, 0.05], [0.0, 0.0, 0.43])
    back = shifted(tilted(box([0.04, length_m, 0.40]), np.deg2rad(12.0)), [0.23, 0.0, 0.47])
    legs = [box([0.40, 0.06, 0.405], [0.0, side * 0.4 * length_m, 0.2025]) for side in (-1.0, 1.0)]
    return merged([seat, back, *legs])


def random_clutter(rng: np.random.Generator, name: str = "clutter") -> Obstacle:
    """A tree, a bollard, a lamp post or a bench; its category is "clutter"."""
    kind = rng.choice(["tree", "bollard", "lamp", "bench"])
    if kind == "tree":
        mesh, material = tree(rng.uniform(0.08, 0.2), rng.uniform(1.9, 2.5), rng.uniform(4.0, 5.5)), "wood"
    elif kind == "bollard":
        mesh, material = bollard(rng.uniform(0.05, 0.10), rng.uniform(0.75, 1.0)), "metal"
    elif kind == "lamp":
        mesh, material = lamp_post(rng.uniform(0.06, 0.10), rng.uniform(3.5, 5.0)), "metal"
    else:
        mesh, material = bench(rng.uniform(1.2, 1.8)), "wood"
    return Obstacle(mesh, Material.named(material), name, category="clutter")


def _bough(trunk_radius_m: float, fork_m: float, height_m: float, index: int) -> trimesh.Trimesh:
    """A bough that leans outwards by a quarter turn per index, each a little less than the one before."""
    azimuth, lean = np.pi / 2 * index + 0.4, np.deg2rad(38.0 - 5.0 * index)
    z = np.linspace(-0.1, (height_m - fork_m) * (1.0 - 0.08 * index), 6)
    out = np.tan(lean) * np.maximum(z, 0.0)
    center = out[:, None] * np.array([np.cos(azimuth), np.sin(azimuth)])
    radius = 0.55 * trunk_radius_m * np.linspace(1.0, 0.25, len(z))
    return loft(ellipse_rings(fork_m + z, radius, center, segments=32))
