"""Walls: house fronts with and without pilasters, garden walls with piers, shop fronts of glass in frames."""

from __future__ import annotations

import numpy as np
import trimesh

from scenes.obstacles.measures import measured, require_least
from scenes.obstacles.solids import box, merged, places_along
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

FINISHES = ("brick", "painted-brick", "concrete", "glass")
KINDS = {"plain": 0.7, "piers": 0.18, "front": 0.12}


@measured
def wall(length_m: float = 8.0, height_m: float = 3.0, thickness_m: float = 0.25) -> trimesh.Trimesh:
    """A free-standing wall along y, its faces to +x and -x.

    Raises:
        ValueError: a measure that is not positive.
    """
    return box([thickness_m, length_m, height_m])


@measured
def wall_with_piers(
    length_m: float = 8.0,
    height_m: float = 3.0,
    thickness_m: float = 0.25,
    spacing_m: float = 3.0,
    depth_m: float = 0.12,
) -> trimesh.Trimesh:
    """A wall along y with piers 0.4 m wide that stand out on either face, one at each end.

    Args:
        length_m, height_m, thickness_m: of the wall between the piers.
        spacing_m: greatest distance between the middles of neighbouring piers.
        depth_m: how far the piers stand out.

    Raises:
        ValueError: a measure that is not positive, or a length or spacing below the width of a pier.
    """
    body = wall(length_m, height_m, thickness_m)
    places = places_along(length_m, "spacing_m", spacing_m, 0.4)
    pier = [thickness_m + 2.0 * depth_m, 0.4, height_m + 0.05]
    return merged([body, *(box(pier, [0.0, y, 0.5 * pier[2]]) for y in places)])


@measured
def shop_front(
    length_m: float = 6.0, height_m: float = 2.8, pane_m: float = 2.4, setback_m: float = 0.06
) -> trimesh.Trimesh:
    """Panes of glass along y between mullions 6 cm wide, on a plinth and under a lintel; 0.2 m thick, its front to -x.

    Args:
        length_m, height_m: of the front.
        pane_m: greatest width of a pane.
        setback_m: how far the panes lie behind the frame, below 0.1.

    Raises:
        ValueError: a measure that is not positive, a front lower than plinth and lintel or shorter than a mullion is
            wide, a setback of half the front's thickness or more.
    """
    require_least("height_m", height_m, 0.7, "for plinth and lintel")
    if not 0.0 < setback_m < 0.1:
        raise ValueError(f"setback_m must lie between 0 and 0.1, got {setback_m}")
    plinth, lintel, front = 0.35, 0.3, -0.1 + 0.5 * setback_m
    panes = box([0.2 - setback_m, length_m, height_m], [0.5 * setback_m, 0.0, 0.5 * height_m])
    rails = [
        box([setback_m, length_m, plinth], [front, 0.0, 0.5 * plinth]),
        box([setback_m, length_m, lintel], [front, 0.0, height_m - 0.5 * lintel]),
    ]
    places = places_along(length_m, "pane_m", pane_m, 0.06)
    rise = [setback_m, 0.06, height_m - plinth - lintel]
    return merged([panes, *rails, *(box(rise, [front, y, plinth + 0.5 * rise[2]]) for y in places)])


def random_wall(rng: np.random.Generator, name: str = "wall") -> Obstacle:
    """A wall 4-20 m long, 2.5-4 m high: plain (seven in ten; brick, painted brick, concrete, glass), with piers
    (brick, painted brick, concrete), or a shop front.
    """
    kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
    length, height = rng.uniform(4.0, 20.0), rng.uniform(2.5, 4.0)
    if kind == "front":
        mesh = shop_front(min(length, 8.0), height, rng.uniform(2.0, 3.0), rng.uniform(0.04, 0.09))
        return Obstacle(mesh, Material.named("glass"), name, category="wall")
    thickness, finish = rng.uniform(0.2, 0.3), str(rng.choice(FINISHES if kind == "plain" else FINISHES[:3]))
    if kind == "piers":
        mesh = wall_with_piers(min(length, 14.0), height, thickness, rng.uniform(4.0, 7.0), rng.uniform(0.06, 0.15))
    else:
        mesh = wall(length, height, thickness)
    return Obstacle(mesh, Material.named(finish), name, category="wall")
