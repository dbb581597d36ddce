"""The named scenes as streets, and scenes from YAML files.

A street runs along +x from the origin, its path about |y| < 1 m, and ends at a wall across it. What stands where is
fixed; which bin, car or person it is, and by how much it is off its place, comes from the seed. The campus passes
the five places of the paper's figure 15: parking lot, running track, gym, library and dormitory.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from obstaclewatch.support.argument_types import check_seed
from scenes.files.schema import read_scene
from scenes.obstacles import random_obstacle
from scenes.obstacles.pedestrian import random_person
from scenes.streets.placing import placed
from scenes.streets.surroundings import BOUNDARIES, ground_of
from simulator.scene.scene import Obstacle, Scene

JITTER_M = 0.15
JITTER_RAD = float(np.deg2rad(8.0))


@dataclass(frozen=True)
class Spot:
    """A place in a street.

    Attributes:
        category: of what stands there.
        at_m: (x, y) in the street.
        yaw_rad: its rotation; at 0 its front faces the oncoming walker.
        speed_m_s: of a pedestrian, in the direction they face; 0 stands.
    """

    category: str
    at_m: tuple[float, float]
    yaw_rad: float = 0.0
    speed_m_s: float = 0.0


@dataclass(frozen=True)
class BoundarySpot:
    """What bounds a street: the middle of its foot, length, height, turn (0 faces along x), one of BOUNDARIES."""

    name: str
    at_m: tuple[float, float]
    length_m: float
    height_m: float
    yaw_rad: float
    kind: str


LENGTHWISE = float(np.pi / 2)

BOUNDS: dict[str, tuple[BoundarySpot, ...]] = {
    "supermarket": (
        BoundarySpot("supermarket", (9.0, 7.0), 14.0, 4.0, LENGTHWISE, "shop-front"),
        BoundarySpot("side-street", (19.5, 7.0), 5.0, 3.5, LENGTHWISE, "painted-brick"),
        BoundarySpot("car-park-kerb", (10.0, -3.4), 18.0, 0.12, LENGTHWISE, "kerb"),
        BoundarySpot("apartments", (24.0, 0.0), 12.0, 3.0, 0.0, "concrete"),
    ),
    "campus": (
        BoundarySpot("parking-kerb", (4.5, -3.2), 9.0, 0.12, LENGTHWISE, "kerb"),
        BoundarySpot("running-track", (14.5, -4.0), 9.0, 1.1, LENGTHWISE, "fence"),
        BoundarySpot("hedge", (29.5, 3.6), 1.4, 1.0, LENGTHWISE, "hedge"),
        BoundarySpot("gym", (26.0, -6.0), 11.0, 4.0, LENGTHWISE, "concrete"),
        BoundarySpot("library", (14.0, 5.8), 18.0, 4.0, LENGTHWISE, "brick-piers"),
        BoundarySpot("dormitory", (34.0, 1.0), 14.0, 4.0, 0.0, "brick"),
    ),
}

SPOTS: dict[str, tuple[Spot, ...]] = {
    "supermarket": (
        Spot("dustbin", (4.0, 1.3)),
        Spot("dustbin", (13.5, -1.6)),
        Spot("dustbin", (19.0, 4.4), LENGTHWISE),
        Spot("sign", (7.0, -0.9)),
        Spot("sign", (10.5, 1.2)),
        Spot("car", (3.5, -6.6), LENGTHWISE),
        Spot("car", (7.0, -6.6), LENGTHWISE),
        Spot("car", (16.5, -6.6), -LENGTHWISE),
        Spot("pedestrian", (9.0, 4.0), 2.0),
        Spot("pedestrian", (16.0, 0.7), 0.0, 1.1),
        Spot("clutter", (6.0, 3.4)),
        Spot("clutter", (12.0, 3.6)),
        Spot("clutter", (20.5, -1.5)),
    ),
    "campus": (
        Spot("dustbin", (5.0, 1.2)),
        Spot("dustbin", (18.0, -1.6)),
        Spot("dustbin", (30.0, -3.0)),
        Spot("sign", (19.5, 1.5)),
        Spot("car", (2.5, -6.6), LENGTHWISE),
        Spot("car", (6.0, -6.6), -LENGTHWISE),
        Spot("pedestrian", (8.0, 0.9), 0.0, 1.2),
        Spot("pedestrian", (11.0, -1.0), np.pi, 1.0),
        Spot("pedestrian", (13.0, 2.4), 2.5),
        Spot("pedestrian", (13.6, 3.2), -0.8),
        Spot("pedestrian", (22.5, -0.8), 0.1, 1.3),
        Spot("pedestrian", (25.0, -2.6), LENGTHWISE, 0.9),
        Spot("pedestrian", (28.0, 1.5), np.pi, 1.1),
        Spot("pedestrian", (31.0, 2.5), -1.2),
        Spot("clutter", (2.5, 3.0)),
        Spot("clutter", (10.0, 3.3)),
        Spot("clutter", (15.5, -2.4)),
        Spot("clutter", (26.5, 3.4)),
    ),
}

GROUNDS = {"supermarket": "asphalt", "campus": "concrete-paving"}


def list_scenes() -> list[str]:
    """Names that `load_scene` and `make_approach` know.

    Example:
        >>> from scenes import list_scenes
        >>> list_scenes()
        ['campus', 'supermarket']
    """
    return sorted(SPOTS)


def load_scene(name_or_yaml: str | Path, seed: int = 0) -> Scene:
    """A named scene, or that of a YAML file (see `scenes.files.schema`).

    Args:
        name_or_yaml: one of `list_scenes()`, or the path of a file that ends in .yaml or .yml.
        seed: which of the many streets of that name; a file has only one.

    Raises:
        ValueError: an unknown scene, or a file that does not fit the schema.
        FileNotFoundError: there is no such file.

    Example:
        >>> from scenes import load_scene
        >>> street = load_scene("supermarket", seed=1)
        >>> sorted({obstacle.category for obstacle in street.obstacles})
        ['car', 'clutter', 'dustbin', 'ground', 'pedestrian', 'sign', 'wall']
    """
    check_seed(seed=seed)
    if not isinstance(name_or_yaml, str | Path):
        raise ValueError(f"scene must be one of {list_scenes()} or a .yaml file, got {name_or_yaml!r}")
    if Path(name_or_yaml).suffix in (".yaml", ".yml"):
        return read_scene(name_or_yaml)
    name = str(name_or_yaml)
    if name not in SPOTS:
        raise ValueError(f"scene must be one of {list_scenes()} or a .yaml file, got '{name}'")
    bounds = [_boundary(spot) for spot in BOUNDS[name]]
    streams = np.random.SeedSequence(seed).spawn(len(SPOTS[name]))
    things = [
        _thing(spot, number, np.random.default_rng(stream))
        for number, (spot, stream) in enumerate(zip(SPOTS[name], streams, strict=True), start=1)
    ]
    return Scene((ground_of(GROUNDS[name]), *bounds, *things), name=name)


def _boundary(spot: BoundarySpot) -> Obstacle:
    boundary = BOUNDARIES[spot.kind].along_y(spot.length_m, spot.height_m, spot.name)
    return placed(boundary, spot.at_m, spot.yaw_rad)


def _thing(spot: Spot, number: int, rng: np.random.Generator) -> Obstacle:
    name = f"{spot.category}-{number}"
    at = np.array(spot.at_m) + rng.uniform(-JITTER_M, JITTER_M, 2)
    yaw = spot.yaw_rad + rng.uniform(-JITTER_RAD, JITTER_RAD)
    if spot.category != "pedestrian":
        return placed(random_obstacle(spot.category, rng, name), at, yaw)
    facing = -np.array([np.cos(yaw), np.sin(yaw), 0.0])
    return placed(random_person(rng, name, walking=spot.speed_m_s > 0.0), at, yaw, spot.speed_m_s * facing)
