"""Ground truth: closed forms for walls and posts, then invariance, then an independent slow reference."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.obstacles import ground, litter_bin, person, wall
from scenes.streets.placing import placed
from scenes.truth.swept import Body
from scenes.truth.truth import PASSING_M, comes_within, contact, ground_truth, passing_time
from scenes.walks.gait_walk import Gait, GaitWalk
from simulator.phone.phone import Phone
from simulator.scene.air import Air
from simulator.scene.materials import Material
from simulator.scene.pose import StraightWalk
from simulator.scene.scene import Obstacle, Scene

PHONE = Phone.ideal([0.0, 0.07, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
BODY = Body()


def obstacle(mesh: trimesh.Trimesh, name: str, at=(0.0, 0.0), velocity=(0.0, 0.0, 0.0)) -> Obstacle:
    return placed(Obstacle(mesh, Material.rigid(), name, category="thing"), at, 0.0, velocity)


def floor() -> Obstacle:
    return Obstacle(ground(), Material.rigid(), "ground", category="ground")


def walk_ahead(speed: float = 1.25, duration: float = 4.0, heading: float = 0.0) -> StraightWalk:
    return StraightWalk(np.array([0.0, 0.0, 1.3]), heading, speed, duration)


def test_walking_straight_at_a_wall() -> None:
    """The wall's face is at 4.9 m, the level phone's transducers 0.07 m ahead of its origin and 0.07 m behind it."""
    scene = Scene([floor(), obstacle(wall(thickness_m=0.2), "wall", (5.0, 0.0))])
    time = np.array([0.0, 1.0, 2.0])
    truth = ground_truth(scene, walk_ahead(), PHONE, time, "wall")
    gap = 4.9 - 1.25 * time
    np.testing.assert_allclose(truth.range_m, gap - 0.07, atol=1e-12)
    np.testing.assert_allclose(truth.mic_range_m, np.stack([gap - 0.07, gap + 0.07], axis=1), atol=1e-12)
    np.testing.assert_allclose(truth.nearest_point_m, np.tile([4.9, 0.0, 1.3], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(truth.ground_range_m, np.hypot(gap - 0.07, 1.3), atol=1e-12)
    np.testing.assert_allclose(truth.bearing_rad, 0.0, atol=1e-12)
    np.testing.assert_allclose(truth.radius_m, 4.0, atol=1e-12)
    assert truth.obstacle.tolist() == ["wall"] * 3
    assert truth.collides
    assert truth.line_collides
    assert truth.contact_obstacle == "wall"
    assert truth.contact_time_s == pytest.approx((4.9 - BODY.front_m) / 1.25, abs=1e-9)
    assert truth.clearance_m == 0.0
    assert truth.miss_distance_m == 0.0


def test_passing_a_post_on_the_left() -> None:
    """A post of radius 0.3 m whose middle is 1 m beside the path: miss distance 0.7 m, gap 0.45 m."""
    post = trimesh.creation.cylinder(0.3, 1.7, sections=720, transform=_lifted(0.85))
    scene = Scene([floor(), obstacle(post, "post", (4.0, 1.0))])
    truth = ground_truth(scene, walk_ahead(duration=6.0), PHONE, [0.0, 6.0], "post")
    assert not truth.collides
    assert not truth.line_collides
    assert np.isnan(truth.contact_time_s)
    assert truth.contact_obstacle is None
    assert truth.miss_distance_m == pytest.approx(0.7, abs=1e-5)
    assert truth.clearance_m == pytest.approx(0.45, abs=1e-5)
    assert truth.radius_m == pytest.approx([0.3, 0.3], abs=1e-5)
    ahead = np.array([4.0 - 0.07, 4.0 - 7.5 - 0.07])
    np.testing.assert_allclose(truth.range_m, np.hypot(ahead, 1.0) - 0.3, atol=1e-5)
    np.testing.assert_allclose(truth.signed_bearing_rad, np.arctan2(1.0, ahead), atol=1e-3)
    np.testing.assert_array_equal(truth.bearing_rad, np.abs(truth.signed_bearing_rad))


@pytest.mark.parametrize(("offset", "touches"), [(0.549, True), (0.551, False)])
def test_the_boundary_is_where_half_width_and_radius_meet(offset: float, touches: bool) -> None:
    post = trimesh.creation.cylinder(0.3, 1.7, sections=1440, transform=_lifted(0.85))
    met = contact(obstacle(post, "post", (3.0, offset)), walk_ahead(duration=5.0))
    assert np.isfinite(met.contact_time_s) == touches


def test_a_wider_walker_meets_more() -> None:
    scene = Scene([obstacle(litter_bin(0.3), "bin", (3.0, 0.7))])
    narrow, wide = (ground_truth(scene, walk_ahead(), PHONE, [0.0], "bin", w) for w in (0.25, 0.45))
    assert not narrow.collides
    assert wide.collides


def test_two_who_walk_towards_each_other_meet_in_between() -> None:
    someone = litter_bin(0.25)
    other = obstacle(someone, "other", (6.0, 0.0), (-1.0, 0.0, 0.0))
    truth = ground_truth(Scene([other]), walk_ahead(1.25), PHONE, [0.0, 1.0, 2.0], "other")
    assert truth.contact_time_s == pytest.approx((6.0 - 0.25 - BODY.front_m) / 2.25, abs=1e-9)
    # The rim is 0.4 m below the phone.
    ahead = 6.0 - 0.25 - 0.07 - 2.25 * truth.time_s
    np.testing.assert_allclose(truth.range_m, np.hypot(ahead, 0.4), atol=1e-12)


def test_who_walks_away_as_fast_is_never_met() -> None:
    scene = Scene([obstacle(litter_bin(), "other", (3.0, 0.0), (1.25, 0.0, 0.0))])
    truth = ground_truth(scene, walk_ahead(1.25), PHONE, [0.0, 2.0, 4.0], "other")
    assert not truth.collides
    np.testing.assert_allclose(truth.range_m, truth.range_m[0], atol=1e-12)


def test_without_a_target_the_nearest_counts_and_the_ground_never_does() -> None:
    near, far = obstacle(litter_bin(), "near", (2.0, 0.9)), obstacle(wall(), "far", (5.0, 0.0))
    truth = ground_truth(Scene([floor(), far, near]), walk_ahead(), PHONE, [0.0, 3.5])
    assert truth.obstacle.tolist() == ["near", "far"]
    assert truth.collides
    assert truth.contact_obstacle == "far"
    assert truth.contact_time_s == pytest.approx((5.0 - 0.125 - BODY.front_m) / 1.25, abs=1e-9)


def test_over_the_walkers_head_nothing_is_met() -> None:
    beam = trimesh.creation.box([0.3, 4.0, 0.3], transform=trimesh.transformations.translation_matrix([3, 0, 2.3]))
    truth = ground_truth(Scene([obstacle(beam, "beam")]), walk_ahead(), PHONE, [0.0], "beam")
    assert not truth.collides
    assert np.isnan(truth.radius_m).all()
    assert truth.miss_distance_m == np.inf


def test_passing_time_is_when_one_comes_alongside() -> None:
    """A wall along the path from 3 m on: its gap is least once the front core, 0.15 m behind the phone, is level."""
    along = placed(obstacle(wall(length_m=6.0), "wall"), (6.0, 1.0), np.pi / 2)
    time = passing_time(along, walk_ahead(1.0, 8.0))
    lateral = 1.0 - 0.125
    early = np.sqrt((lateral + PASSING_M) ** 2 - lateral**2)
    assert time == pytest.approx(3.0 + 0.15 - early, abs=1e-3)
    assert comes_within(along, walk_ahead(1.0, 8.0), lateral - 0.25 + 0.01)
    assert not comes_within(along, walk_ahead(1.0, 8.0), lateral - 0.25 - 0.01)


@settings(max_examples=15, deadline=None)
@given(turn=st.floats(-3.0, 3.0), x=st.floats(-1e4, 1e4), y=st.floats(-1e4, 1e4))
def test_turning_and_moving_the_world_changes_nothing(turn: float, x: float, y: float) -> None:
    thing = obstacle(person(), "thing", (4.0, 0.3), (-0.5, 0.1, 0.0))
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), 0.1, 1.2, 4.0)
    here = ground_truth(Scene([thing]), walk, PHONE, [0.0, 1.0, 2.0], "thing")
    cos, sin = np.cos(turn), np.sin(turn)
    spin = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    moved = placed(thing, (x, y), turn, spin @ thing.velocity_m_s)
    elsewhere = replace(walk, start_m=spin @ walk.start_m + [x, y, 0.0], heading_rad=0.1 + turn)
    there = ground_truth(Scene([moved]), elsewhere, PHONE, [0.0, 1.0, 2.0], "thing")
    np.testing.assert_allclose(there.range_m, here.range_m, atol=1e-9)
    np.testing.assert_allclose(there.mic_range_m, here.mic_range_m, atol=1e-9)
    np.testing.assert_allclose(there.signed_bearing_rad, here.signed_bearing_rad, atol=1e-6)
    assert there.collides == here.collides
    assert there.contact_time_s == pytest.approx(here.contact_time_s, abs=1e-6, nan_ok=True)
    assert there.clearance_m == pytest.approx(here.clearance_m, abs=1e-6)


def test_the_mirror_image_changes_the_sign_of_the_bearing_only() -> None:
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), gait=Gait())
    scenes = [Scene([obstacle(litter_bin(), "bin", (3.0, side * 0.8))]) for side in (1, -1)]
    left, right = (ground_truth(scene, walk, PHONE, [0.0]) for scene in scenes)
    np.testing.assert_allclose(left.signed_bearing_rad, -right.signed_bearing_rad, atol=1e-12)
    np.testing.assert_allclose(left.range_m, right.range_m, atol=1e-12)
    assert left.clearance_m == pytest.approx(right.clearance_m, abs=1e-12)


def test_an_unknown_target_is_refused_with_the_names_there_are() -> None:
    scene = Scene([floor(), obstacle(litter_bin(), "bin")])
    with pytest.raises(ValueError, match=r"got 'dog'; there are \['ground', 'bin'\]"):
        ground_truth(scene, walk_ahead(), PHONE, [0.0], "dog")


def test_a_scene_of_ground_alone_has_nothing_to_ask_about() -> None:
    with pytest.raises(ValueError, match="must have an obstacle to collide with, got none"):
        ground_truth(Scene([floor()]), walk_ahead(), PHONE, [0.0])


def _lifted(height: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix([0.0, 0.0, height])


def test_the_beep_at_the_end_of_a_walk_may_meet_its_obstacle_after_it() -> None:
    """The benches ask for the instant at which a beep meets the target: sound to 34 m takes 0.1 s."""
    scene = Scene([obstacle(trimesh.creation.box([1.0, 1.0, 2.0]), "far", (35.0, 0.0))], Air.lossless(340.0))
    walk = walk_ahead(duration=2.0)
    late = (35.0 - 2.0 * 1.3) / 340.0
    assert ground_truth(scene, walk, PHONE, [2.0 + 0.9 * late], "far").range_m[0] > 30.0
    with pytest.raises(ValueError, match="time_s must lie within the walk, 0 to 2 s"):
        ground_truth(scene, walk, PHONE, [2.0 + 1.1 * late], "far")
