"""What surrounds a walker in each scene: the ground, a wall along the path, things beside it, other people.

The supermarket is an open street with few things about; the campus is crowded and its people walk (section 4.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scenes.obstacles import ground, random_obstacle, wall
from scenes.obstacles.person import random_person
from scenes.placing import Occupied, apart, extents, placed
from scenes.truth import comes_within
from scenes.walks import GaitWalk
from simulator.materials import Material
from simulator.scene import Obstacle

GROUND_M = (60.0, 60.0)
NEIGHBOUR_CLEARANCE_M = 0.30
NEIGHBOUR_GAP_M = 0.15
TRIES = 300


@dataclass(frozen=True)
class Setting:
    """How a scene is furnished.

    Attributes:
        ground: material of the ground.
        side_wall: probability of a wall along the path.
        side_wall_material: its material.
        kinds: categories of the things beside the path.
        things: least and greatest number of them.
        walkers: least and greatest number of other people who walk.
        pedestrian_kinds: probabilities that a pedestrian target stands, comes the other way, or crosses.
    """

    ground: str
    side_wall: float
    side_wall_material: str
    kinds: tuple[str, ...]
    things: tuple[int, int]
    walkers: tuple[int, int]
    pedestrian_kinds: tuple[float, float, float]


SETTINGS: dict[str, Setting] = {
    "supermarket": Setting(
        ground="asphalt",
        side_wall=0.4,
        side_wall_material="painted-brick",
        kinds=("dustbin", "sign", "car", "clutter"),
        things=(1, 3),
        walkers=(0, 0),
        pedestrian_kinds=(0.6, 0.4, 0.0),
    ),
    "campus": Setting(
        ground="concrete-paving",
        side_wall=0.4,
        side_wall_material="brick",
        kinds=("dustbin", "car", "clutter", "clutter"),
        things=(2, 4),
        walkers=(2, 4),
        pedestrian_kinds=(0.4, 0.45, 0.15),
    ),
}


def ground_of(setting: Setting) -> Obstacle:
    """The ground, 60 m square around the origin."""
    return Obstacle(ground(GROUND_M), Material.named(setting.ground), "ground", surface="flat", category="ground")


def neighbours(rng: np.random.Generator, setting: Setting, target: Obstacle, walk: GaitWalk) -> list[Obstacle]:
    """What stands and walks beside the path: never touched by the walker, never within 15 cm of one another.

    Raises:
        RuntimeError: no room was found for one of them.
    """
    around: list[Obstacle] = []
    taken = [Occupied.by(target)]

    def add(obstacle: Obstacle) -> None:
        around.append(obstacle)
        taken.append(Occupied.by(obstacle))

    if rng.random() < setting.side_wall and target.category != "wall":
        add(_side_wall(rng, setting, target, walk))
    for number in range(rng.integers(setting.things[0], setting.things[1] + 1)):
        kind = str(rng.choice(setting.kinds))
        thing = random_obstacle(kind, rng, f"{kind}-{number + 1}")
        add(_beside(rng, thing, taken, walk))
    for number in range(rng.integers(setting.walkers[0], setting.walkers[1] + 1)):
        someone = random_person(rng, f"passer-by-{number + 1}", walking=True)
        course = walk.heading_rad + rng.choice([0.0, np.pi]) + rng.normal(0.0, np.deg2rad(5.0))
        velocity = rng.uniform(0.8, 1.5) * np.array([np.cos(course), np.sin(course), 0.0])
        add(_beside(rng, placed(someone, np.zeros(2), course - np.pi, velocity), taken, walk))
    return around


def _side_wall(rng: np.random.Generator, setting: Setting, target: Obstacle, walk: GaitWalk) -> Obstacle:
    """A wall along the walk, on either side, beyond the target and at least 1.6 m from the path."""
    left = np.array([-np.sin(walk.heading_rad), np.cos(walk.heading_rad)])
    side = rng.choice([-1.0, 1.0])
    origin = walk.start_m[:2] @ left
    _, beyond = extents(target, side * left, 3.0)
    sweep = max(0.0, walk.duration_s * float(target.velocity_m_s[:2] @ left) * side)
    away = max(1.6, beyond + sweep - side * origin + 0.3) + rng.uniform(0.0, 2.0)
    length = rng.uniform(12.0, 20.0)
    middle = walk.start_m[:2] + 4.0 * np.array([left[1], -left[0]]) + side * (away + 0.125) * left
    mesh = wall(length, rng.uniform(2.5, 4.0), 0.25)
    obstacle = Obstacle(mesh, Material.named(setting.side_wall_material), "side-wall", category="wall")
    return placed(obstacle, middle, walk.heading_rad + np.pi / 2)


def _beside(rng: np.random.Generator, thing: Obstacle, taken: Sequence[Occupied], walk: GaitWalk) -> Obstacle:
    """The thing at a free place within reach of the beep: 1 m behind to 9 m ahead, up to 5 m to either side."""
    ahead = np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad)])
    left = np.array([-ahead[1], ahead[0]])
    if not thing.moves:
        thing = placed(thing, np.zeros(2), rng.uniform(-np.pi, np.pi))
    for attempt in range(TRIES):
        reach = 5.0 + 5.0 * attempt / TRIES  # a crowded place makes newcomers stand further off
        across = rng.choice([-1.0, 1.0]) * rng.uniform(0.6, reach)
        candidate = placed(thing, walk.start_m[:2] + rng.uniform(-1.0, 9.0) * ahead + across * left)
        if not apart(candidate, taken, walk.duration_s, NEIGHBOUR_GAP_M):
            continue
        if not comes_within(candidate, walk, NEIGHBOUR_CLEARANCE_M):
            return candidate
    raise RuntimeError(f"no room for '{thing.name}' beside the path in {TRIES} tries")
