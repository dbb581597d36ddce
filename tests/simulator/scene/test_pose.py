"""Poses: whose arrays they are, and where the walker's body faces; and what equality of such things means."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths


def test_a_pose_keeps_its_own_heading():
    """Cause: it was the caller's array, so that a change of that changed the pose."""
    heading_rad = np.zeros(2)
    pose = Pose(np.zeros((2, 3)), held_rotation(0.0), heading_rad)
    heading_rad[0] = 1.0
    assert not pose.heading_rad.any()


@pytest.mark.parametrize("place_m", [0.0, 5e6])
def test_the_body_faces_along_the_phone_wherever_it_is(place_m):
    """Cause: the long edge was the difference of two places in the world, which rounds."""
    pose = Pose([place_m, 0.0, place_m], held_rotation(0.3, 1.2))
    assert pose.body_heading_rad() == pytest.approx(0.3, abs=1e-14)


def test_an_upright_phone_does_not_say_where_the_body_faces():
    """Cause: the heading was that of rounding errors, 0.32 or 0 by the place."""
    with pytest.raises(ValueError, match="heading_rad must be given where the phone's long edge is upright"):
        Pose([0.0, 0.0, 1.3], held_rotation(0.3, 0.5 * np.pi)).body_heading_rad()
    assert Pose([0.0, 0.0, 1.3], held_rotation(0.3, 0.5 * np.pi), 0.3).body_heading_rad() == 0.3


def test_what_holds_arrays_is_equal_to_itself_alone():
    """Cause: to compare them, or to look one up among others, ended in numpy's error about the truth of an array."""
    post, phone, pose = trimesh.creation.box(), Phone.named("ideal"), Pose([3.0, 0.0, 0.0], held_rotation(0.0))
    obstacle = Obstacle(post, Material.rigid(), "post")
    scene = Scene([Obstacle(post, Material.rigid(), "other"), obstacle])
    for each in (obstacle, scene, phone, pose, phone.geometry, phone.speaker, trace_paths(scene, phone, pose)):
        assert each == each
        assert each in {each}
    assert scene.obstacles.index(obstacle) == 1
    assert phone != Phone.named("ideal")
