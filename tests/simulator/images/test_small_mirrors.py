"""Small faces in paths of three reflections: on the way to an edge or a smooth surface of another obstacle they are no
mirrors at `standard`."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from scenes.obstacles import ground
from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

SQUARE = trimesh.creation.box(bounds=[[1.2, -0.7, 0.0], [1.5, -0.4, 1.5]])
ROUND = trimesh.creation.cylinder(0.15, 1.5, sections=32).apply_translation([1.35, -0.55, 0.75])


def over_all_three(side_m: float, post: trimesh.Trimesh, fidelity: Fidelity) -> bool:
    """Whether there is a path over the ground, a post and a cube with faces of so many metres."""
    box = trimesh.creation.box([side_m] * 3).apply_translation([0.46, 0.6 + 0.5 * side_m, 0.59])
    bodies = [
        Obstacle(ground(), Material.rigid(), "ground"),
        Obstacle(box, Material.rigid(), "box"),
        Obstacle(post, Material.rigid(), "post"),
    ]
    paths = trace_paths(Scene(bodies), Phone.named("ideal"), Pose([0.0, 0.0, 1.0], held_rotation(0.0)), fidelity)
    return any(set(met) == {"ground", "box", "post"} for met in paths.obstacles_met())


@pytest.mark.parametrize("post", [SQUARE, ROUND], ids=["over edges", "over a smooth surface"])
@pytest.mark.parametrize(
    ("side_m", "mirror_m2", "there"), [(0.2, 0.01, False), (0.2, 0.0, True), (0.4, 0.01, True), (0.4, 0.1, False)]
)
def test_mirrors_on_the_way_to_another_obstacle_have_ten_times_the_least_area(side_m, mirror_m2, there, post):
    """They brought images and rays by the thousand and hardly an echo: a twentieth of a beep's time at `standard`."""
    assert over_all_three(side_m, post, Fidelity(mirror_m2=mirror_m2, edge_floor_db=-np.inf)) == there
