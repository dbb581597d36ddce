"""Walls: house fronts, garden walls, panes of glass."""

from __future__ import annotations

import numpy as np
import trimesh

from scenes.solids import box
from simulator.materials import Material
from simulator.scene import Obstacle

FINISHES = ("brick", "painted-brick", "concrete", "glass")


def wall(length_m: float = 8.0, height_m: float = 3.0, thickness_m: float = 0.25) -> trimesh.Trimesh:
    """A free-standing wall along y, its faces to +x and -x.

    Raises:
        ValueError: a measure that is not positive.
    """
    return box([thickness_m, length_m, height_m])


def random_wall(rng: np.random.Generator, name: str = "wall") -> Obstacle:
    """A wall 4-20 m long, 2.5-4 m high, 0.2-0.3 m thick, of bare or painted brick, concrete or glass."""
    mesh = wall(rng.uniform(4.0, 20.0), rng.uniform(2.5, 4.0), rng.uniform(0.2, 0.3))
    return Obstacle(mesh, Material.named(str(rng.choice(FINISHES))), name, category="wall")
