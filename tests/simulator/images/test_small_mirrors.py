"""Which mirrors follow each other in paths of three reflections: all but one are large."""

from __future__ import annotations

import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

POSE = Pose([0.0, 0.0, 1.2], held_rotation(heading_rad=0.0))


def _paths(**fidelity):
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    box = trimesh.creation.box(bounds=[[1.5, -0.3, 0.0], [2.1, 0.3, 0.8]])
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.2).apply_translation([-0.8, 0.1, 1.1])
    parts = {"ground": ground, "box": box, "ball": ball}
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()], Air.lossless(343.0))
    return set(trace_paths(scene, Phone.named("ideal"), POSE, Fidelity(**fidelity)).obstacle.tolist())


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
def test_a_corner_of_ground_and_a_small_face_is_met_with_a_body_beside_the_phone(level):
    """`standard` had large mirrors alone in such paths: echoes of boxes by way of the walker lacked up to 70 dB."""
    assert {"box > ground > ball", "ball > ground > box"} <= _paths(level=level)
