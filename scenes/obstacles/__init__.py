"""Obstacles with metric parameters: one file per category.

A mesh function takes measures in metres and returns a mesh that stands on z = 0 over the origin, its front to -x.
`random_obstacle` draws one of a category with its material.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from scenes.obstacles.car import car, random_car
from scenes.obstacles.dustbin import donation_box, dumpster, litter_bin, random_dustbin, wheeled_bin
from scenes.obstacles.furniture import (
    bench,
    bollard,
    fence,
    ground,
    hydrant,
    kerb,
    lamp_post,
    random_clutter,
    tree,
    tub,
)
from scenes.obstacles.greenery import hedge
from scenes.obstacles.pedestrian import pedestrian, random_person
from scenes.obstacles.person import person, walker_body
from scenes.obstacles.sign import a_frame, board_on_posts, pole_sign, random_sign
from scenes.obstacles.wall import random_wall, shop_front, wall, wall_with_piers
from simulator.scene.scene import Obstacle

CATEGORIES: dict[str, Callable[[np.random.Generator, str], Obstacle]] = {
    "wall": random_wall,
    "dustbin": random_dustbin,
    "car": random_car,
    "sign": random_sign,
    "pedestrian": random_person,
    "clutter": random_clutter,
}


def random_obstacle(category: str, rng: np.random.Generator, name: str) -> Obstacle:
    """An obstacle of that category, over the origin, drawn from the generator.

    Raises:
        ValueError: an unknown category; the message lists those there are.

    >>> from scenes.obstacles import random_obstacle
    >>> sign = random_obstacle("sign", np.random.default_rng(1), "no parking")
    >>> sign.category, sign.name, sign.mesh.is_watertight
    ('sign', 'no parking', True)
    """
    if category not in CATEGORIES:
        raise ValueError(f"category must be one of {sorted(CATEGORIES)}, got {category!r}")
    return CATEGORIES[category](rng, name)


__all__ = [
    "CATEGORIES",
    "a_frame",
    "bench",
    "board_on_posts",
    "bollard",
    "car",
    "donation_box",
    "dumpster",
    "fence",
    "ground",
    "hedge",
    "hydrant",
    "kerb",
    "lamp_post",
    "litter_bin",
    "pedestrian",
    "person",
    "pole_sign",
    "random_obstacle",
    "shop_front",
    "tree",
    "tub",
    "walker_body",
    "wall",
    "wall_with_piers",
    "wheeled_bin",
]
