"""A street in one mesh, made obstacles of: each has every echo then.

In one mesh a round bin lacked its echo over the ground that it stands on, by 55 dB.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from tests.references.meshes import soup

GROUND = trimesh.creation.box(bounds=[[-6.0, -6.0, -0.1], [6.0, 6.0, 0.0]])
BIN = trimesh.creation.cylinder(0.25, 0.9, sections=48).apply_translation([2.0, 0.3, 0.45])
CONCRETE = Material.named("concrete")


def echoes(obstacles):
    pose = Pose([0.0, 0.0, 1.3], held_rotation(np.zeros(1), np.array([0.5])))
    paths = trace_paths(Scene(obstacles), Phone.named("galaxy-s5"), pose)
    order = np.lexsort((np.abs(paths.gain), paths.delay_s))
    return paths.delay_s[order], np.abs(paths.gain[order])


@pytest.mark.parametrize("as_file", [lambda mesh: mesh, soup])
def test_parts_of_a_mesh_echo_as_obstacles_of_their_own(as_file):
    street = Obstacle(as_file(GROUND + BIN), CONCRETE, "street")
    alone = echoes([Obstacle(as_file(mesh), CONCRETE, name) for mesh, name in ((GROUND, "ground"), (BIN, "bin"))])
    for ours, theirs in zip(echoes(street.split()), alone, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


def test_parts_keep_what_is_said_of_the_whole():
    whole = Obstacle(BIN + GROUND, CONCRETE, "yard", "flat", [1.0, 0.0, 0.0], "clutter")
    parts = whole.split()
    assert [part.name for part in parts] == ["yard-1", "yard-2"]
    assert [len(part.mesh.faces) for part in parts] == [len(GROUND.faces), len(BIN.faces)], "the largest surface first"
    for part in parts:
        assert (part.material, part.surface, part.category) == (CONCRETE, "flat", "clutter")
        np.testing.assert_array_equal(part.velocity_m_s, whole.velocity_m_s)


def test_what_shares_a_point_stays_together():
    at_an_edge = trimesh.creation.box(bounds=[[6.0, 6.0, -0.1], [7.0, 7.0, 0.0]])
    for mesh in (BIN, GROUND + at_an_edge):
        whole = Obstacle(mesh, CONCRETE, "whole")
        assert whole.split() == (whole,)


def test_a_triangle_without_area_is_no_part():
    both = BIN + GROUND
    point = len(both.vertices)
    mesh = trimesh.Trimesh([*both.vertices, [4.0, 0.0, 1.0], [4.0, 0.0, 2.0]], [*both.faces, [point, point, point + 1]])
    assert [len(part.mesh.faces) for part in Obstacle(mesh, CONCRETE, "yard").split()] == [12, len(BIN.faces)]


def test_a_heap_of_triangles_is_not_split():
    corner = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    heap = np.arange(1001)[:, None, None] * np.array([0.0, 0.0, 0.2]) + corner
    mesh = trimesh.Trimesh(heap.reshape(-1, 3), np.arange(3 * len(heap)).reshape(-1, 3), process=False)
    with pytest.raises(ValueError, match="'heap' must have at most 1000 parts to be split, got 1001"):
        Obstacle(mesh, CONCRETE, "heap").split()
