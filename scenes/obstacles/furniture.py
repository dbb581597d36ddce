"""Clutter of a street: trees, bollards, lamp posts, benches, hydrants, tubs, kerbs, fences, and the ground itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh

from scenes.obstacles.measures import measured, require_least, require_length
from scenes.obstacles.solids import (
    box,
    cylinder,
    ellipse_rings,
    loft,
    merged,
    places_along,
    raised,
    shifted,
    tilted,
    wheel,
)
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle


def ground(size_m: tuple[float, float] = (60.0, 60.0)) -> trimesh.Trimesh:
    """A level rectangle in z = 0, centred, facing up: two triangles, open.

    Raises:
        ValueError: a side that is not positive.
    """
    x, y = (require_length("side of the ground", side) / 2 for side in size_m)
    corners = [[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


@measured
def bollard(radius_m: float = 0.08, height_m: float = 0.9) -> trimesh.Trimesh:
    """A post with a domed top.

    Raises:
        ValueError: a measure that is not positive, or a post no taller than its radius.
    """
    if not height_m > radius_m:
        raise ValueError(f"height_m must be above the radius {radius_m} m, got {height_m}")
    shoulder = height_m - radius_m
    latitude = np.linspace(0.0, np.pi / 2, 7)[1:-1]
    z = np.concatenate([np.linspace(0.0, shoulder, 5), shoulder + radius_m * np.sin(latitude)])
    radius = np.concatenate([np.full(5, radius_m), radius_m * np.cos(latitude)])
    return loft(ellipse_rings(z, radius, segments=32), top_m=[0.0, 0.0, height_m])


@measured
def lamp_post(radius_m: float = 0.08, height_m: float = 4.0) -> trimesh.Trimesh:
    """A slightly tapered mast with a lantern.

    Raises:
        ValueError: a measure that is not positive.
    """
    mast = cylinder(radius_m, height_m, 32, rows=8, top_radius_m=0.6 * radius_m)
    lantern = shifted(cylinder(0.12, 0.35, 32, rows=2, top_radius_m=0.2), [0.0, 0.0, height_m])
    return merged([mast, lantern])


@measured
def tree(trunk_radius_m: float = 0.14, fork_m: float = 2.2, height_m: float = 4.5) -> trimesh.Trimesh:
    """A leafless street tree: a tapered trunk with a root flare, and four boughs from the fork.

    Raises:
        ValueError: a measure that is not positive, or a fork above the top or below 0.5 m.
    """
    if not 0.0 < fork_m < height_m:
        raise ValueError(f"fork_m must lie between 0 and the height {height_m} m, got {fork_m}")
    require_least("fork_m", fork_m, 0.5, "for its root flare")
    z = np.concatenate([np.linspace(0.0, 0.4, 5), np.linspace(0.4, fork_m, 7)[1:]])
    radius = trunk_radius_m * (1.0 - 0.2 * z / fork_m + 0.35 * np.exp(-z / 0.15))
    trunk = loft(ellipse_rings(z, radius, segments=32))
    return merged([trunk, *(_bough(trunk_radius_m, fork_m, height_m, k) for k in range(4))])


@measured
def bench(length_m: float = 1.6) -> trimesh.Trimesh:
    """A bench along y with a seat, a back on its +x side, and two side supports.

    Raises:
        ValueError: a length that is not positive.
    """
    seat = box([0.42, length_m, 0.05], [0.0, 0.0, 0.43])
    back = shifted(tilted(box([0.04, length_m, 0.40]), np.deg2rad(12.0)), [0.23, 0.0, 0.47])
    legs = [box([0.40, 0.06, 0.405], [0.0, side * 0.4 * length_m, 0.2025]) for side in (-1.0, 1.0)]
    return merged([seat, back, *legs])


@measured
def hydrant(radius_m: float = 0.13, height_m: float = 0.75) -> trimesh.Trimesh:
    """A pillar hydrant: a domed barrel on a base plate, with an outlet on either side.

    Raises:
        ValueError: a measure that is not positive, or a barrel no taller than its radius.
    """
    barrel = bollard(radius_m, height_m)
    base = cylinder(1.4 * radius_m, 0.05, 32, rows=1)
    outlets = shifted(wheel(0.055, 2.0 * radius_m + 0.12), [0.0, 0.0, 0.65 * height_m])
    return merged([barrel, base, outlets])


@measured
def tub(size_m: float = 0.8, height_m: float = 0.55) -> trimesh.Trimesh:
    """A square planting tub, a fifth narrower at its foot.

    Raises:
        ValueError: a measure that is not positive.
    """
    half = size_m / 2
    square = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return loft(raised(np.stack([0.8 * square, square]), np.array([0.0, height_m])))


@measured
def kerb(length_m: float = 20.0, height_m: float = 0.12, width_m: float = 0.15) -> trimesh.Trimesh:
    """A row of kerb stones along y.

    Raises:
        ValueError: a measure that is not positive.
    """
    return box([width_m, length_m, height_m])


@measured
def fence(length_m: float = 12.0, height_m: float = 1.1, spacing_m: float = 2.5) -> trimesh.Trimesh:
    """Two rails 9 cm high on posts, along y, as round a running track.

    Raises:
        ValueError: a measure that is not positive, a fence lower than its rails, or a length or spacing below 0.1 m.
    """
    require_least("height_m", height_m, 0.2, "for its two rails")
    rails = [box([0.035, length_m, 0.09], [-0.055, 0.0, part * height_m - 0.045]) for part in (0.55, 1.0)]
    places = places_along(length_m, "spacing_m", spacing_m, 0.1)
    return merged([*rails, *(shifted(box([0.07, 0.07, height_m]), [0.0, y, 0.0]) for y in places)])


def random_clutter(rng: np.random.Generator, name: str = "clutter") -> Obstacle:
    """A tree, bollard, lamp post, bench, hydrant or planting tub; its category is "clutter"."""
    kind = str(rng.choice(list(_CLUTTER), p=CLUTTER_SHARES))
    return _CLUTTER[kind](rng, name)


def _random_tree(rng: np.random.Generator, name: str) -> Obstacle:
    mesh = tree(rng.uniform(0.08, 0.2), rng.uniform(1.9, 2.5), rng.uniform(4.0, 5.5))
    return _clutter(mesh, "bark", name)


def _random_bollard(rng: np.random.Generator, name: str) -> Obstacle:
    material = str(rng.choice(["metal", "concrete"]))
    return _clutter(bollard(rng.uniform(0.05, 0.12), rng.uniform(0.75, 1.0)), material, name)


def _random_lamp(rng: np.random.Generator, name: str) -> Obstacle:
    return _clutter(lamp_post(rng.uniform(0.05, 0.10), rng.uniform(3.5, 5.0)), "metal", name)


def _random_bench(rng: np.random.Generator, name: str) -> Obstacle:
    return _clutter(bench(rng.uniform(1.2, 1.8)), "wood", name)


def _random_hydrant(rng: np.random.Generator, name: str) -> Obstacle:
    return _clutter(hydrant(rng.uniform(0.11, 0.15), rng.uniform(0.65, 0.85)), "metal", name)


def _random_tub(rng: np.random.Generator, name: str) -> Obstacle:
    return _clutter(tub(rng.uniform(0.5, 1.0), rng.uniform(0.4, 0.7)), str(rng.choice(["concrete", "wood"])), name)


def _clutter(mesh: trimesh.Trimesh, material: str, name: str) -> Obstacle:
    return Obstacle(mesh, Material.named(material), name, category="clutter")


_CLUTTER: dict[str, Callable[[np.random.Generator, str], Obstacle]] = {
    "tree": _random_tree,
    "bollard": _random_bollard,
    "lamp": _random_lamp,
    "bench": _random_bench,
    "hydrant": _random_hydrant,
    "tub": _random_tub,
}
CLUTTER_SHARES = (0.2, 0.2, 0.2, 0.15, 0.1, 0.15)


def _bough(trunk_radius_m: float, fork_m: float, height_m: float, index: int) -> trimesh.Trimesh:
    """A bough that leans outwards by a quarter turn per index, each a little less than the one before."""
    azimuth, lean = np.pi / 2 * index + 0.4, np.deg2rad(38.0 - 5.0 * index)
    z = np.linspace(-0.1, (height_m - fork_m) * (1.0 - 0.08 * index), 6)
    out = np.tan(lean) * np.maximum(z, 0.0)
    center = out[:, None] * np.array([np.cos(azimuth), np.sin(azimuth)])
    radius = 0.55 * trunk_radius_m * np.linspace(1.0, 0.25, len(z))
    return loft(ellipse_rings(fork_m + z, radius, center, segments=16))
