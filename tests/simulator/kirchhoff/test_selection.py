"""Which ways over a bin are left to Kirchhoff's integral: its rim is an echo of its own, ground or not."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from scenes.obstacles import random_obstacle
from simulator import Air, Fidelity, Material, Obstacle, Paths, Phone, Pose, Scene, trace_paths
from simulator.kirchhoff.doubtful_bodies import UNEVEN, unevenness
from simulator.world.prepared_scene import prepare

C = 343.0
BEFORE_FOOT_M = 1.6  # from a phone 0.9 m high or more the foot of the bin is 1.7 m away
FREQUENCY = np.linspace(18_000.0, 23_000.0, 101)
COARSE = {"level": "auto", "max_order": 2, "facet_m": 0.03}  # the choice does not depend on the facets
PHONE = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.05, 0.0], [0.0, -0.05, 0.0]])


def _bin() -> Obstacle:
    mesh = trimesh.creation.cylinder(0.25, 0.9, sections=48)
    mesh.apply_translation([2.0, 0.0, 0.45])
    return Obstacle(mesh, Material.rigid(), "bin")


def _ground() -> Obstacle:
    corners = [[-20.0, -20.0, 0.0], [20.0, -20.0, 0.0], [20.0, 20.0, 0.0], [-20.0, 20.0, 0.0]]
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]), Material.rigid(), "ground")


def _paths(obstacles: list[Obstacle], heights_m, **fidelity) -> Paths:
    pose = Pose([[0.3, 0.05, z] for z in heights_m], Rotation.identity())
    return trace_paths(Scene(obstacles, Air.lossless(C)), PHONE, pose, Fidelity(**(COARSE | fidelity)))


def _rim(paths: Paths) -> np.ndarray:
    """(N, F) what comes straight from the bin."""
    return paths[paths.obstacle == "bin"].transfer_function(FREQUENCY).reshape(-1, 2, len(FREQUENCY))[:, 0]


@pytest.mark.parametrize("height_m", [0.9001, 1.0, 1.2])
def test_ground_takes_nothing_from_a_rim(height_m):
    """A rim counted only as far as it reached into the loudest echo, which comes over the ground, 30 cm behind it.

    Cells under the floor are left out beside the loudest of each pose, so the sums differ by a thousandth. The foot,
    whose wave the ground changes, is farther off.
    """
    found = [_paths(bodies, [height_m]) for bodies in ([_bin()], [_ground(), _bin()])]
    alone, on_ground = (_rim(paths[paths.delay_s * C < 2.0 * BEFORE_FOOT_M]) for paths in found)
    assert np.abs(alone).max() * 2.0 * np.hypot(1.45, height_m - 0.9) > 10.0 ** (-36.0 / 20.0)
    np.testing.assert_allclose(on_ground, alone, atol=0.01 * np.abs(alone).max())


def test_body_that_rays_reach_in_part_is_summed_once():
    """Without mirrors a bin's top is the integral's, and its side ends at a rim: it was summed for both, 6 dB up."""
    once, twice = (_rim(_paths([_bin()], [1.2], mechanisms=each)) for each in (["kirchhoff"], ["curved", "kirchhoff"]))
    np.testing.assert_allclose(twice, once, atol=1e-6 * np.abs(once).max())


def test_body_in_the_face_of_another_one_is_summed_once():
    """Rays over one body off the flat face of another that is left to the integral, too: 5 dB up at `reference`."""
    arc = np.linspace(np.pi, 2.0 * np.pi, 25)
    half = np.array([[1.3 + 0.45 * np.cos(a), -0.7 + 0.3 * np.sin(a), z] for a in arc for z in (0.0, 0.9)])
    other = Obstacle(trimesh.convex.convex_hull(half), Material.rigid(), "half")
    mechanisms = ["specular", "kirchhoff"], ["specular", "curved", "kirchhoff"]
    paths = [_paths([_bin(), other], [0.88], mechanisms=each) for each in mechanisms]
    assert {choice.obstacle for choice in paths[1].choices if choice.integrals} == {"bin", "half"}
    once, twice = (each[np.char.count(each.obstacle, ">") == 1].transfer_function(FREQUENCY)[0] for each in paths)
    np.testing.assert_allclose(twice, once, atol=1e-6 * np.abs(once).max())


def test_facets_are_of_the_size_that_is_asked_for():
    """At `reference` all bodies were cut to 12 mm, which only thin plates need."""
    fine, coarse = (_rim(_paths([_bin()], [1.2], level="reference", facet_m=each)) for each in (0.012, 0.03))
    apart_db = 20.0 * np.log10(np.abs(coarse).max() / np.abs(fine).max())
    assert 0.1 < abs(apart_db) < 2.0


def test_echo_does_not_jump_as_the_phone_passes_the_rim():
    """Under the rim the ray was the echo and over it there was none: -8 dB re a wall came and went in a millimetre.

    The second difference of an echo that only moves is (k dL)^2 of it: below 1e-3 for a millimetre aside of the way.
    """
    echo = _rim(_paths([_ground(), _bin()], [0.899, 0.9, 0.901]))
    path_m = 2.0 * (2.0 - 0.25 - 0.3)
    arrived = (echo[2] - 2.0 * echo[1] + echo[0]) * np.exp(2j * np.pi * FREQUENCY * path_m / C)
    jump = np.abs(np.mean(arrived)) * path_m
    assert 20.0 * np.log10(jump) < -35.0


def test_rim_under_the_floor_is_left_to_rays():
    paths = _paths([_ground(), _bin()], [1.2], edge_floor_db=-10.0)
    assert paths.choices[0].integrals == 0


@pytest.mark.parametrize("sections", [12, 16, 32])
def test_a_coarse_post_is_no_uneven_body(sections):
    """The turn of the curvature's axes within a facet once counted: posts of 16 segments were uneven."""
    post = Obstacle(trimesh.creation.cylinder(0.25, 2.0, sections=sections), Material.rigid(), "post")
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    world = prepare(Scene([post]), phone, np.zeros(3), ("curved",))
    assert [unevenness(surface) for surface in world.surfaces] == pytest.approx([0.0], abs=1e-9)


@pytest.mark.parametrize(("category", "uneven"), [("pedestrian", True), ("car", True), ("dustbin", False)])
def test_people_and_cars_are_uneven_bodies_and_bins_are_not(category, uneven):
    body = random_obstacle(category, np.random.default_rng(1), category)
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    world = prepare(Scene([body]), phone, np.zeros(3), ("curved",))
    assert world.surfaces
    assert all((unevenness(surface) > UNEVEN) == uneven for surface in world.surfaces)


def test_standard_has_the_corner_of_wall_and_ground_over_a_body():
    """It left the third order over integrals out: a car that only a wall and the ground show was 16 dB too faint."""
    wall = Obstacle(trimesh.creation.box(bounds=[[1.0, 1.5, 0.0], [4.0, 1.6, 2.0]]), Material.rigid(), "wall")
    body = random_obstacle("pedestrian", np.random.default_rng(1), "body")
    body.mesh.apply_translation([2.0, 0.5, 0.0])
    pose = Pose([[0.3, 0.05, 1.3]], Rotation.identity())
    paths = trace_paths(Scene([_ground(), wall, body], Air.lossless(C)), PHONE, pose, Fidelity(level="standard"))
    over_both = [met for met in paths.obstacles_met() if set(met) == {"ground", "wall", "body"}]
    assert over_both
