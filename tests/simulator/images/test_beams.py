"""Beams against straight lines through rectangles."""

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.images import image_tree
from simulator.images.image_tree import aside, bound

AXES = np.array([[0.3, 0.0, 0.0], [0.0, 0.8, 0.6]])  # half the sides of the rectangle, and across it
ACROSS = np.array([0.0, -0.6, 0.8])
CENTER = np.array([2.0, 0.4, 1.0])
TURNS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def seen_from(image, beside=0.0):
    """Beam (1, 4, 3) of an image through the rectangle."""
    beam = np.zeros((1, 4, 3))
    bound(image, CENTER + TURNS @ AXES, beside, beam[0])
    return beam


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_point_is_aside_where_the_line_to_it_misses_the_rectangle(turn):
    rng = np.random.default_rng(3)
    for _ in range(500):
        image = CENTER + rng.uniform(-2.0, 2.0, 2) @ AXES + turn * rng.uniform(0.01, 3.0) * ACROSS
        place = rng.uniform(-2.0, 2.0, 2)
        point = image + rng.uniform(1.0, 5.0) * (CENTER + place @ AXES - image)
        assert aside(image, seen_from(image), point[None], 0.0) == bool((np.abs(place) > 1.0).any())


def test_a_patch_is_aside_only_if_all_its_corners_are_beyond_one_side():
    image = CENTER + ACROSS
    beam = seen_from(image)
    beyond = CENTER - 0.5 * ACROSS
    assert aside(image, beam, beyond + np.array([[1.6], [3.0]]) * AXES[0], 0.0)
    assert not aside(image, beam, beyond + np.array([[1.4], [3.0]]) * AXES[0], 0.0)
    assert not aside(image, beam, beyond + np.array([[-3.0], [3.0]]) * AXES[0], 0.0)


def test_a_ball_is_aside_if_it_does_not_reach_the_side():
    image = CENTER + ACROSS
    ball = CENTER - ACROSS + 3.0 * AXES[0]  # 0.3 m beyond a side that leans by 0.3
    away = 0.3 / np.hypot(1.0, 0.3)
    assert aside(image, seen_from(image), ball[None], away - 1e-9)
    assert not aside(image, seen_from(image), ball[None], away + 1e-9)


def test_what_is_beside_the_rectangle_can_be_let_in():
    image = CENTER + ACROSS
    point = (CENTER - ACROSS + 2.5 * AXES[0])[None]  # crosses 7.5 cm beside it
    assert aside(image, seen_from(image, 0.07), point, 0.0)
    assert not aside(image, seen_from(image, 0.08), point, 0.0)


def test_a_rectangle_seen_edge_on_bounds_nothing():
    image = CENTER + 5.0 * AXES[0]
    assert not aside(image, seen_from(image), (CENTER + 9.0 * AXES[1])[None], 0.0)


def test_images_are_made_for_one_kind_of_arrays(monkeypatch):
    """Cause: microphones of one side are every second row of all, and `_onwards` was compiled once more for them."""
    onwards, kinds = image_tree._onwards, []

    def watched(mirrors, allowed, level, goal):
        kinds.append(goal.center_m.flags.c_contiguous)
        return onwards(mirrors, allowed, level, goal)

    monkeypatch.setattr(image_tree, "_onwards", watched)
    box = Obstacle(trimesh.creation.box(bounds=[[1.5, -0.5, 0.0], [2.0, 0.5, 1.0]]), Material.rigid(), "box")
    places = np.array([[0.0, 0.0, 1.3], [0.1, 0.0, 1.3]])
    trace_paths(Scene([box]), Phone.named("ideal"), Pose(places, held_rotation(np.zeros(2))))
    assert len(kinds) > 1
    assert all(kinds)
