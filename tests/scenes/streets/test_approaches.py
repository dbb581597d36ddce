"""Approaches: the outcome asked for, nothing else in the way, and the same whatever was made before."""

import numpy as np
import pytest

from scenes import DATA_COLLECTION, Approach, ground_truth, make_approach
from scenes.streets.approaches import LONGEST_S, RECIPES, _endless_walk
from scenes.truth.swept import Body
from scenes.walks.gait_walk import WALK_RATIO_M_PER_STEPS_MIN
from simulator.scene.scene import Obstacle

CASES = [(scene, category) for scene, collected in DATA_COLLECTION.items() for category in collected.cases]


def test_the_papers_counts() -> None:
    """821 cases around the supermarket and 478 on the campus, 1299 in all (section 4.1)."""
    totals = {scene: sum(collected.cases.values()) for scene, collected in DATA_COLLECTION.items()}
    assert totals == {"supermarket": 821, "campus": 478}
    assert {phone for collected in DATA_COLLECTION.values() for phone in collected.phones} == {
        "galaxy-s5",
        "galaxy-s8-plus",
        "galaxy-note5",
    }


@pytest.mark.parametrize("collision", [True, False])
@pytest.mark.parametrize(("scene", "category"), CASES)
def test_ground_truth_confirms_the_outcome(scene: str, category: str, collision: bool) -> None:
    for index in range(2):
        approach = make_approach(scene, category, index, seed=11, collision=collision)
        end = [0.0, approach.walk.duration_s]
        truth = ground_truth(approach.scene, approach.walk, approach.phone, end, approach.target)
        assert truth.collides == collision
        assert _collides_by_sampling(approach) == collision
        whole = ground_truth(approach.scene, approach.walk, approach.phone, end)
        assert whole.contact_obstacle == (approach.target if collision else None)
        if collision:
            assert end[1] - 0.05 < truth.contact_time_s < end[1]
            assert truth.range_m[0] > truth.range_m[1]
        else:
            assert 0.05 <= truth.clearance_m < 1.0


@pytest.mark.parametrize(("scene", "category"), CASES)
def test_the_papers_recipe_is_clear_cut(scene: str, category: str) -> None:
    """Half a metre clear or an overlap of 20 cm, as ground truth sees it; the same walker as in the mixed street."""
    for index in range(3):
        for collision in (True, False):
            kinds = {"seed": 5, "collision": collision}
            here, there = (make_approach(scene, category, index, recipe=recipe, **kinds) for recipe in RECIPES)
            truth = ground_truth(here.scene, here.walk, here.phone, [0.0], here.target)
            assert truth.collides == collision
            assert truth.miss_distance_m <= 0.05 if collision else truth.clearance_m >= 0.50
            assert (here.walk.speed_m_s, here.walk.heading_rad) == (there.walk.speed_m_s, there.walk.heading_rad)
            velocity = here.scene.obstacle(here.target).velocity_m_s
            assert velocity[0] < 0.0 or not velocity.any()


@pytest.mark.parametrize(("scene", "category"), CASES)
def test_walks_last_a_whole_number_of_beeps(scene: str, category: str) -> None:
    for collision in (True, False):
        walk = make_approach(scene, category, 2, collision=collision, beep_period_s=0.09).walk
        beeps = walk.duration_s / 0.09
        assert beeps == pytest.approx(round(beeps), abs=1e-9)
        assert 2.5 < walk.duration_s <= LONGEST_S


def test_the_same_whatever_was_made_before() -> None:
    alone = make_approach("campus", "dustbin", 5, seed=3)
    for index in (9, 1):
        make_approach("campus", "car", index, seed=3)
    again = make_approach("campus", "dustbin", 5, seed=3)
    assert _fingerprint(alone) == _fingerprint(again)
    assert _fingerprint(alone) != _fingerprint(make_approach("campus", "dustbin", 6, seed=3))
    assert _fingerprint(alone) != _fingerprint(make_approach("campus", "dustbin", 5, seed=4))


def test_steps_tell_the_speed_no_better_than_peoples_do() -> None:
    """Cause: every walker had the same walk ratio, so that a detector could read the speed off the steps exactly."""
    walks = [_endless_walk(np.random.default_rng(seed), 1.3) for seed in range(200)]
    ratios = np.array([walk.walk_ratio_m_min for walk in walks]) / WALK_RATIO_M_PER_STEPS_MIN
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.03)
    assert np.std(ratios) == pytest.approx(0.12, abs=0.02)


def test_phones_meet_the_same_walk() -> None:
    """Paired comparisons of phones need the same encounters."""
    one, other = (make_approach("supermarket", "sign", 7, phone) for phone in ("galaxy-s5", "galaxy-s8-plus"))
    assert _fingerprint(one) == _fingerprint(other)
    assert one.phone.geometry.name != other.phone.geometry.name


def test_a_scene_holds_ground_target_and_a_held_phone() -> None:
    approach = make_approach("campus", "pedestrian", 0)
    categories = [obstacle.category for obstacle in approach.scene.obstacles]
    assert categories.count("ground") == 1
    assert approach.scene.obstacle(approach.target).category == "pedestrian"
    assert sum(obstacle.moves for obstacle in approach.scene.obstacles) >= 2
    assert approach.phone.body is not None
    assert approach.phone.body.mesh.bounds[1, 0] < -0.25


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scene_name": "moon"}, "approaches are drawn in scenes of"),
        ({"category": "dragon"}, "category must be one of"),
        ({"phone_name": "brick"}, "brick"),
        ({"recipe": "cake"}, "recipe must be one of"),
        ({"beep_period_s": 0.0}, "beep_period_s must lie between 0 and 1, got 0.0"),
    ],
)
def test_unknown_names_are_refused(change: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_approach(**({"scene_name": "campus", "category": "car", "index": 0} | change))


def _fingerprint(approach: Approach) -> tuple:
    pose = approach.walk.pose([0.0, 1.0])
    meshes = tuple((o.name, o.mesh.vertices.tobytes(), tuple(o.velocity_m_s)) for o in approach.scene.obstacles)
    return pose.position_m.tobytes(), pose.rotation.as_quat().tobytes(), approach.walk.duration_s, meshes


def _collides_by_sampling(approach: Approach) -> bool:
    """Slow reference: does any of many points of the target ever lie in the walker's stadium?"""
    target, body = approach.scene.obstacle(approach.target), Body()
    time = np.linspace(0.0, approach.walk.duration_s, 150)
    pose = approach.walk.pose(time)
    heading = pose.body_heading_rad()
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    points = _points_of(target, body)
    for t, place, forward in zip(time, pose.position_m, ahead, strict=True):
        offset = points + t * target.velocity_m_s[:2] - place[:2]
        along = offset @ forward
        across = offset @ np.array([-forward[1], forward[0]])
        beyond = along - np.clip(along, body.half_width_m - body.back_m, body.front_m - body.half_width_m)
        if (np.hypot(beyond, across) <= body.half_width_m).any():
            return True
    return False


def _points_of(target: Obstacle, body: Body) -> np.ndarray:
    """(K, 2) points, 2 cm apart, on the edges of the target's triangles up to the walker's height."""
    edges = target.mesh.vertices[target.mesh.edges_unique]
    count = np.ceil(target.mesh.edges_unique_length / 0.02).astype(int) + 1
    step = np.concatenate([np.linspace(0.0, 1.0, n) for n in count])[:, None]
    start, end = np.repeat(edges[:, 0], count, axis=0), np.repeat(edges[:, 1], count, axis=0)
    cloud = start + step * (end - start)
    return np.unique(np.round(cloud[cloud[:, 2] <= body.height_m][:, :2], 2), axis=0)
