"""The room in which simulators are compared, a shoebox with hard walls, and pairs of points in it."""

from __future__ import annotations

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Floats
from simulator import Air, Fidelity, Material, Obstacle, Paths, Phone, Pose, PreparedScene, Scene, held_rotation
from simulator.trace import trace_paths

SIZE_M = np.array([4.0, 3.0, 2.6])
SOUND_M_S = 343.0
ARMS_M = np.array([[0.01, 0.0, 0.0], [0.0, -0.01, 0.0]])
"""From a source to the two microphones beside it."""
PATHS = {1: 7, 2: 25, 3: 63}
"""From one point to another by order, the direct one included."""


def mirrors(order: int) -> Fidelity:
    """Image sources alone, as far as there are any."""
    return Fidelity(max_order=order, max_range_m=40.0, mechanisms=("specular",))


def sources_m(count: int) -> Floats:
    """(N, 3) places well inside."""
    return np.random.default_rng(7).uniform(0.2, 0.8, (count, 3)) * SIZE_M


def room() -> PreparedScene:
    """The room as an obstacle that encloses the phone."""
    box = trimesh.creation.box(SIZE_M, trimesh.transformations.translation_matrix(SIZE_M / 2.0))
    box.invert()
    return in_air([Obstacle(box, Material.rigid(), "room")])


def in_air(obstacles: list[Obstacle]) -> PreparedScene:
    """Obstacles in air that takes nothing off."""
    return PreparedScene(Scene(obstacles, Air.lossless(SOUND_M_S)))


def paths_in(scene: PreparedScene, source_m: Floats, fidelity: Fidelity) -> Paths:
    """All paths of sources (N, 3), a pose each, in one call."""
    return trace_paths(scene, Phone.ideal(np.zeros(3), ARMS_M), Pose(source_m, held_rotation(np.pi / 2.0)), fidelity)
