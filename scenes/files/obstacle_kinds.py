"""Kinds of obstacles that a scene file can name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import trimesh

import scenes.obstacles as obstacles
from scenes.obstacles.solids import box, cylinder


@dataclass(frozen=True)
class Kind:
    """A kind of obstacle: the function that makes its mesh, its category and its usual material."""

    mesh: Callable[..., trimesh.Trimesh]
    category: str
    material: str


KINDS: dict[str, Kind] = {
    "wall": Kind(obstacles.wall, "wall", "brick"),
    "wall_with_piers": Kind(obstacles.wall_with_piers, "wall", "brick"),
    "shop_front": Kind(obstacles.shop_front, "wall", "glass"),
    "litter_bin": Kind(obstacles.litter_bin, "dustbin", "metal"),
    "wheeled_bin": Kind(obstacles.wheeled_bin, "dustbin", "plastic"),
    "dumpster": Kind(obstacles.dumpster, "dustbin", "metal"),
    "donation_box": Kind(obstacles.donation_box, "dustbin", "metal"),
    "car": Kind(obstacles.car, "car", "metal"),
    "pole_sign": Kind(obstacles.pole_sign, "sign", "sign-sheet"),
    "a_frame": Kind(obstacles.a_frame, "sign", "sign-sheet"),
    "board_on_posts": Kind(obstacles.board_on_posts, "sign", "sign-sheet"),
    "pedestrian": Kind(obstacles.pedestrian, "pedestrian", "clothed-person"),
    "person": Kind(obstacles.person, "pedestrian", "clothed-person"),
    "tree": Kind(obstacles.tree, "clutter", "bark"),
    "hedge": Kind(obstacles.hedge, "clutter", "foliage"),
    "bollard": Kind(obstacles.bollard, "clutter", "metal"),
    "lamp_post": Kind(obstacles.lamp_post, "clutter", "metal"),
    "hydrant": Kind(obstacles.hydrant, "clutter", "metal"),
    "bench": Kind(obstacles.bench, "clutter", "wood"),
    "tub": Kind(obstacles.tub, "clutter", "concrete"),
    "kerb": Kind(obstacles.kerb, "clutter", "concrete"),
    "fence": Kind(obstacles.fence, "clutter", "metal"),
    "box": Kind(box, "clutter", "metal"),
    "cylinder": Kind(cylinder, "clutter", "metal"),
}
