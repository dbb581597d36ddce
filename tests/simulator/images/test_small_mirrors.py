"""Small faces in paths of three reflections: at `standard` they are mirrors to their own obstacle alone."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from scenes.obstacles import ground
from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths


def over_all_three(side_m: float, fidelity: Fidelity) -> bool:
    """Whether there is a path over the ground, a post and a cube with faces of so many metres."""
    box = trimesh.creation.box(bounds=[[1.0, 0.6, 0.3], [1.0 + side_m, 0.6 + side_m, 0.3 + side_m]])
    post = trimesh.creation.box(bounds=[[1.2, -0.7, 0.0], [1.5, -0.4, 1.5]])
    bodies = [
        Obstacle(ground(), Material.rigid(), "ground"),
        Obstacle(box, Material.rigid(), "box"),
        Obstacle(post, Material.rigid(), "post"),
    ]
    paths = trace_paths(Scene(bodies), Phone.named("ideal"), Pose([0.0, 0.0, 1.0], held_rotation(0.0)), fidelity)
    return any(set(met) == {"ground", "box", "post"} for met in paths.obstacles_met())


@pytest.mark.parametrize(
    ("side_m", "mirror_m2", "there"), [(0.2, 0.01, False), (0.2, 0.0, True), (0.4, 0.01, True), (0.4, 0.1, False)]
)
def test_mirrors_on_the_way_to_another_obstacle_have_ten_times_the_least_area(side_m, mirror_m2, there):
    """They brought images and rays by the thousand and hardly an echo: a twentieth of a beep's time at `standard`."""
    assert over_all_three(side_m, Fidelity(mirror_m2=mirror_m2, edge_floor_db=-np.inf)) == there
