"""Patches of one obstacle that lie in one plane have one number, and the ends of edges know the planes they lie in."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation
from simulator.trace import still_tracing
from simulator.world import shared_planes


def _world(*boxes):
    obstacles = [Obstacle(trimesh.creation.box(bounds=box), Material.rigid(), f"{n}") for n, box in enumerate(boxes)]
    pose = Pose([-3.0, 0.0, 1.2], held_rotation(0.0))
    return still_tracing(Scene(obstacles), Phone.named("ideal"), pose, np.zeros(1), Fidelity()).world


@pytest.mark.parametrize("at_once", [shared_planes.AT_ONCE, 1])
def test_a_box_has_six_planes_and_its_edges_end_in_three(monkeypatch, at_once):
    monkeypatch.setattr(shared_planes, "AT_ONCE", at_once)
    world = _world([[0.0, 0.0, 0.0], [1.0, 0.7, 0.4]], [[0.0, 2.0, 0.0], [1.0, 2.7, 0.4]])
    assert len(set(world.planes)) == 12  # faces of two boxes in one plane remain two
    ends = world.planes_at_ends
    assert ends.shape == (24, 2, 3)
    for edge, (faces, planes) in enumerate(zip(world.wedges.patch, ends, strict=True)):
        assert {*world.planes[faces]} == {*planes[0]} & {*planes[1]}, edge


def test_two_boxes_of_one_mesh_share_the_planes_of_their_fronts():
    apart = [trimesh.creation.box(bounds=[[0.0, y, 0.0], [0.5, y + 0.4, 1.0]]) for y in (0.0, 1.0)]
    body = Obstacle(trimesh.util.concatenate(apart), Material.rigid(), "body")
    pose = Pose([-3.0, 0.0, 1.2], held_rotation(0.0))
    world = still_tracing(Scene([body]), Phone.named("ideal"), pose, np.zeros(1), Fidelity()).world
    assert len(world.patches) == 12
    assert len(set(world.planes)) == 8  # two fronts, backs, tops and soles share one each


def test_the_faces_of_a_thin_plate_are_one_and_those_across_a_gap_are_not():
    """Two boards of 3 mm that stand 3 mm apart, and a wall 3 mm thick of another obstacle."""
    boards = [trimesh.creation.box(bounds=[[x, 0.0, 0.0], [x + 3e-3, 0.4, 1.0]]) for x in (0.0, 6e-3)]
    rack = Obstacle(trimesh.util.concatenate(boards), Material.rigid(), "rack")
    wall = Obstacle(trimesh.creation.box(bounds=[[3.0, 0.0, 0.0], [3.003, 0.4, 1.0]]), Material.rigid(), "wall")
    pose = Pose([-3.0, 0.0, 1.2], held_rotation(0.0))
    world = still_tracing(Scene([rack, wall]), Phone.named("ideal"), pose, np.zeros(1), Fidelity()).world
    broad = np.flatnonzero(np.abs(world.patches.normal[:, 0]) > 0.5)
    plate = world.plates[world.planes[broad]]
    assert len(broad) == 6
    place = np.round(1e3 * world.patches.corner_m[broad, 0, 0]).astype(int)
    together = {frozenset(place[plate == each].tolist()) for each in set(plate.tolist())}
    assert together == {frozenset({0, 3}), frozenset({6, 9}), frozenset({3000, 3003})}
