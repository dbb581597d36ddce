"""What surrounds a walker in each scene: the ground, walls and kerbs along the path, things beside it, other people.

A scene is a daily route with several stretches, one of which an approach happens on. The supermarket is an open street
with few people about; the campus is crowded, and most of its people walk (section 4.1 and figures 14 and 15).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh

from scenes.obstacles import ground, hedge, kerb, random_obstacle
from scenes.obstacles.furniture import fence
from scenes.obstacles.pedestrian import random_person
from scenes.obstacles.wall import shop_front, wall, wall_with_piers
from scenes.streets.placing import Occupied, apart, extents, placed
from scenes.truth.truth import comes_within
from scenes.walks.gait_walk import GaitWalk
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

GROUND_M = (60.0, 60.0)
NEIGHBOUR_CLEARANCE_M = 0.30
NEIGHBOUR_GAP_M = 0.15
TRIES = 300


@dataclass(frozen=True)
class Boundary:
    """What runs along a path: a mesh of a length and a height, its material and category."""

    mesh: Callable[[float, float], trimesh.Trimesh]
    material: str
    category: str = "wall"

    def along_y(self, length_m: float, height_m: float, name: str) -> Obstacle:
        """The boundary over the origin, its length along y."""
        mesh = self.mesh(length_m, height_m)
        return Obstacle(mesh, Material.named(self.material), name, category=self.category)


BOUNDARIES: dict[str, Boundary] = {
    "brick": Boundary(wall, "brick"),
    "brick-piers": Boundary(wall_with_piers, "brick"),
    "painted-brick": Boundary(wall, "painted-brick"),
    "glass": Boundary(wall, "glass"),
    "parapet": Boundary(lambda length_m, height_m: wall(length_m, min(height_m, 1.1)), "concrete"),
    "concrete": Boundary(wall, "concrete"),
    "shop-front": Boundary(lambda length_m, height_m: shop_front(min(length_m, 10.0), height_m), "glass"),
    "fence": Boundary(lambda length_m, height_m: fence(length_m, min(height_m, 1.2)), "metal", "clutter"),
    "kerb": Boundary(kerb, "concrete", "clutter"),
    "hedge": Boundary(lambda length_m, height_m: hedge(length_m, height_m), "foliage", "clutter"),
}


@dataclass(frozen=True)
class Stretch:
    """One part of a route, and how it is furnished.

    Its boundaries are plain: paths mix every plane with every smooth body, and the frames of a shop front, the rails
    of a fence or the leaves of a hedge would make a walk two to three times as costly. Full streets have them.

    Attributes:
        name: what it passes.
        ground: material of the ground.
        side_wall: probability of a boundary along the path.
        boundaries: what it may be, equally likely; names of BOUNDARIES.
        kerb: probability of a kerb along the other side.
        kinds: categories of the things beside the path, equally likely.
        things: least and greatest number of them.
        walkers: least and greatest number of other people who walk.
    """

    name: str
    ground: str
    side_wall: float
    boundaries: tuple[str, ...]
    kerb: float
    kinds: tuple[str, ...]
    things: tuple[int, int]
    walkers: tuple[int, int]


@dataclass(frozen=True)
class Setting:
    """A route.

    Attributes:
        stretches: its parts, equally likely.
        pedestrian_kinds: probabilities that a pedestrian target stands, comes towards the walker, or crosses.
    """

    stretches: tuple[Stretch, ...]
    pedestrian_kinds: tuple[float, float, float]


SETTINGS: dict[str, Setting] = {
    "supermarket": Setting(
        stretches=(
            Stretch("shop-front", "concrete-paving", 0.7, ("glass", "painted-brick"), 0.0,
                    ("sign", "clutter", "dustbin", "pedestrian"), (1, 3), (0, 1)),
            Stretch("car-park", "asphalt", 0.0, (), 0.3, ("car", "sign", "clutter"), (1, 3), (0, 1)),
            Stretch("side-street", "asphalt", 0.6, ("brick", "concrete"), 0.4,
                    ("dustbin", "sign", "car", "clutter"), (1, 3), (0, 0)),
            Stretch("apartments", "concrete-paving", 0.4, ("painted-brick", "parapet"), 0.4,
                    ("dustbin", "dustbin", "car", "clutter"), (1, 3), (0, 1)),
        ),
        pedestrian_kinds=(0.6, 0.4, 0.0),
    ),
    "campus": Setting(
        stretches=(
            Stretch("parking-lot", "asphalt", 0.0, (), 0.4, ("car", "clutter", "sign"), (1, 3), (1, 3)),
            Stretch("running-track", "asphalt", 0.8, ("parapet",), 0.2,
                    ("clutter", "clutter", "dustbin"), (1, 3), (2, 3)),
            Stretch("gym", "concrete-paving", 0.6, ("concrete", "glass"), 0.2,
                    ("dustbin", "clutter", "sign"), (1, 3), (2, 4)),
            Stretch("library", "concrete-paving", 0.6, ("brick", "painted-brick"), 0.2,
                    ("clutter", "clutter", "pedestrian", "dustbin"), (1, 3), (2, 3)),
            Stretch("dormitory", "concrete-paving", 0.5, ("brick", "painted-brick"), 0.3,
                    ("dustbin", "dustbin", "car", "clutter"), (1, 2), (2, 3)),
        ),
        pedestrian_kinds=(0.4, 0.4, 0.2),
    ),
}  # fmt: skip


def ground_of(material: str) -> Obstacle:
    """The ground, 60 m square around the origin."""
    return Obstacle(ground(GROUND_M), Material.named(material), "ground", surface="flat", category="ground")


def neighbours(rng: np.random.Generator, stretch: Stretch, target: Obstacle, walk: GaitWalk) -> list[Obstacle]:
    """What stands and walks beside the path: never touched by the walker, never within 15 cm of one another.

    Raises:
        RuntimeError: no room was found for one of them.
    """
    around: list[Obstacle] = []
    taken = [Occupied.by(target)]

    def add(obstacle: Obstacle) -> None:
        around.append(obstacle)
        taken.append(Occupied.by(obstacle))

    for boundary in _boundaries(rng, stretch, target, walk):
        add(boundary)
    for number in range(rng.integers(stretch.things[0], stretch.things[1] + 1)):
        kind = str(rng.choice(stretch.kinds))
        thing = _thing(rng, kind, f"{kind}-{number + 1}")
        add(_beside(rng, thing, taken, walk))
    for number in range(rng.integers(stretch.walkers[0], stretch.walkers[1] + 1)):
        add(_beside(rng, _passer_by(rng, f"passer-by-{number + 1}", walk.heading_rad), taken, walk))
    return around


def _boundaries(rng: np.random.Generator, stretch: Stretch, target: Obstacle, walk: GaitWalk) -> list[Obstacle]:
    """A wall or fence along one side of the path, and a kerb along the other; a target that is a wall stands alone."""
    side = float(rng.choice([-1.0, 1.0]))
    walled, edged = rng.random(2) < [stretch.side_wall, stretch.kerb]
    out: list[Obstacle] = []
    if target.category == "wall":
        return out
    if walled:
        kind = BOUNDARIES[str(rng.choice(stretch.boundaries))]
        boundary = kind.along_y(rng.uniform(12.0, 20.0), rng.uniform(2.5, 4.0), "side-wall")
        out.append(_alongside(boundary, target, walk, side, 1.6, rng.uniform(0.0, 2.0)))
    if edged:
        stones = BOUNDARIES["kerb"].along_y(20.0, rng.uniform(0.10, 0.15), "kerb")
        out.append(_alongside(stones, target, walk, -side, 1.2, rng.uniform(0.0, 1.5)))
    return out


def _alongside(
    boundary: Obstacle, target: Obstacle, walk: GaitWalk, side: float, nearest_m: float, further_m: float
) -> Obstacle:
    """The boundary along the walk, beyond the target wherever it moves, and no nearer to the path than a distance."""
    left = np.array([-np.sin(walk.heading_rad), np.cos(walk.heading_rad)])
    origin = walk.start_m[:2] @ left
    _, beyond = extents(target, side * left, 3.0)
    sweep = max(0.0, walk.duration_s * float(target.velocity_m_s[:2] @ left) * side)
    away = max(nearest_m, beyond + sweep - side * origin + 0.3) + further_m + 0.5 * float(boundary.mesh.extents[0])
    middle = walk.start_m[:2] + 4.0 * np.array([left[1], -left[0]]) + side * away * left
    return placed(boundary, middle, walk.heading_rad + side * np.pi / 2)  # its front to the path


def _thing(rng: np.random.Generator, kind: str, name: str) -> Obstacle:
    """Something that stands beside the path, rotated at random; a pedestrian among them waits there."""
    thing = random_person(rng, name, walking=False) if kind == "pedestrian" else random_obstacle(kind, rng, name)
    return placed(thing, np.zeros(2), rng.uniform(-np.pi, np.pi))


def _passer_by(rng: np.random.Generator, name: str, heading_rad: float) -> Obstacle:
    """Someone who walks along with the walker, comes towards them, or (one in five) crosses."""
    turn = rng.choice([0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi], p=[0.4, 0.4, 0.1, 0.1])
    heading = heading_rad + turn + rng.normal(0.0, np.deg2rad(5.0))
    velocity = rng.uniform(0.8, 1.5) * np.array([np.cos(heading), np.sin(heading), 0.0])
    return placed(random_person(rng, name, walking=True), np.zeros(2), heading - np.pi, velocity)


def _beside(rng: np.random.Generator, thing: Obstacle, taken: Sequence[Occupied], walk: GaitWalk) -> Obstacle:
    """The thing at a free place within reach of the beep: 1 m behind to 9 m ahead, up to 5 m to either side."""
    ahead = np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad)])
    left = np.array([-ahead[1], ahead[0]])
    for attempt in range(TRIES):
        reach = 5.0 + 5.0 * attempt / TRIES  # a crowded place makes newcomers stand further off
        across = rng.choice([-1.0, 1.0]) * rng.uniform(0.6, reach)
        candidate = placed(thing, walk.start_m[:2] + rng.uniform(-1.0, 9.0) * ahead + across * left)
        if not apart(candidate, taken, walk.duration_s, NEIGHBOUR_GAP_M):
            continue
        if not comes_within(candidate, walk, NEIGHBOUR_CLEARANCE_M):
            return candidate
    raise RuntimeError(f"no room for '{thing.name}' beside the path in {TRIES} tries")
