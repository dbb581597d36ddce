"""Ground truth against dense sampling, on random walks past random obstacles of every category.

The default tests take 300 walks; `-m slow` takes 10,000. Half of the obstacles are placed so that the body's side
passes within 6 cm of contact, where a verdict is easily wrong.
"""

from __future__ import annotations

import numpy as np
import pytest

from scenes import Pace, Route, RouteWalk, Stop
from scenes.obstacles import CATEGORIES, random_obstacle
from scenes.streets.placing import placed
from scenes.truth.swept import Body, Slab
from scenes.truth.truth import contact, ground_truth
from scenes.walks.gait_walk import Gait, GaitWalk
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle, Scene
from tests.scenes.brute_force import miss_distance, nearest_distance, passage, plan_samples

PHONE = Phone.named("galaxy-s5")
BAND_M = 1e-3


def random_walk(rng: np.random.Generator) -> Walk:
    """Straight with gait, curved, or stop-and-go, from about the origin along +x."""
    speed, phase = rng.uniform(0.7, 1.7), rng.uniform(0.0, 4.0 * np.pi)
    kind = rng.choice(["straight", "curved", "stops"], p=[0.6, 0.25, 0.15])
    if kind == "straight":
        start = np.array([0.0, 0.0, rng.uniform(1.1, 1.5)])
        return GaitWalk(start, rng.uniform(-0.3, 0.3), speed, rng.uniform(2.0, 5.0), gait=Gait.at_speed(speed, phase))
    turn = rng.uniform(-1.2, 1.2)
    corner = np.array([rng.uniform(1.7, 3.0), 0.0])
    route = Route(np.stack([np.zeros(2), corner, corner + 3.0 * np.array([np.cos(turn), np.sin(turn)])]))
    stops = [Stop(rng.uniform(0.2, 2.0), 2.5)] if kind == "stops" else []
    return RouteWalk(route, Pace(speed, stops), rng.uniform(2.5, 6.0), gait=Gait.at_speed(speed, phase))


def random_passage(seed: int) -> tuple[Obstacle, Walk]:
    """A walk, and an obstacle beside its middle; a third of the obstacles move."""
    rng = np.random.default_rng(np.random.SeedSequence(2026, spawn_key=(seed,)))
    walk = random_walk(rng)
    category = sorted(CATEGORIES)[seed % len(CATEGORIES)]
    obstacle = placed(random_obstacle(category, rng, "thing"), (0.0, 0.0), rng.uniform(-np.pi, np.pi), np.zeros(3))
    when = rng.uniform(0.5, 1.0) * walk.duration_s
    pose = walk.pose([when])
    heading = pose.body_heading_rad()[0]
    left = np.array([-np.sin(heading), np.cos(heading)])
    velocity = np.zeros(2)
    if rng.random() < 1.0 / 3.0:
        course = rng.uniform(-np.pi, np.pi)
        velocity = rng.uniform(0.3, 1.5) * np.array([np.cos(course), np.sin(course)])
    points = np.asarray(obstacle.mesh.vertices)[:, :2]
    side = rng.choice([-1.0, 1.0])
    edge = 0.25 + rng.uniform(-0.06, 0.06) if rng.random() < 0.5 else rng.uniform(-0.5, 1.5)
    near = float((points @ (side * left)).min())
    middle = points.mean(axis=0)
    at = pose.position_m[0, :2] + side * (edge - near) * left - (middle - (middle @ left) * left) - when * velocity
    return placed(obstacle, at, 0.0, np.append(velocity, 0.0)), walk


def compare(seeds: range) -> dict[str, float]:
    """Largest deviations over many walks, and how many there were of what."""
    worst = {"range_m": 0.0, "radius_m": 0.0, "clearance_m": 0.0, "contact_s": 0.0, "miss_m": 0.0}
    counts = {"walks": 0, "met": 0, "close": 0, "wrong": 0, "moving": 0}
    for seed in seeds:
        obstacle, walk = random_passage(seed)
        samples = plan_samples(obstacle.mesh)
        slow, fast = passage(samples, obstacle, walk), contact(obstacle, walk)
        met = bool(np.isfinite(fast.contact_time_s))
        close = abs(slow.gap_m) < BAND_M
        counts["walks"] += 1
        counts["met"] += met
        counts["close"] += close
        counts["moving"] += obstacle.moves
        counts["wrong"] += not close and met != bool(np.isfinite(slow.contact_time_s))
        if not close and not met:
            worst["clearance_m"] = max(worst["clearance_m"], abs(fast.clearance_m - slow.gap_m))
        if slow.gap_m < -0.01 and met:  # not grazing: there the instant is a matter of micrometres
            worst["contact_s"] = max(worst["contact_s"], abs(fast.contact_time_s - slow.contact_time_s))
        if isinstance(walk, RouteWalk):
            worst["miss_m"] = max(worst["miss_m"], _missed_by(samples, obstacle, walk, fast.miss_distance_m))
        for name, deviation in _deviations(samples, obstacle, walk, seed).items():
            worst[name] = max(worst[name], deviation)
    return worst | counts


def _missed_by(samples: np.ndarray, obstacle: Obstacle, walk: RouteWalk, found_m: float) -> float:
    """Deviation of the distance of the mean way; not below 5 cm, where samples are too far apart, nor from a stand."""
    end, velocity = walk.duration_s, obstacle.velocity_m_s[:2]
    time = np.linspace(0.0, end, 3000)
    heading = walk.route.heading_rad(walk.pace.distance(np.array([end])))[0]
    step = walk.mean_plan_m([end - 1e-6, end])
    speed = np.linalg.norm(step[1] - step[0]) / 1e-6
    ahead = speed * np.array([np.cos(heading), np.sin(heading)]) - velocity
    if np.linalg.norm(ahead) < 0.05:
        return 0.0
    slow = miss_distance(samples, walk.mean_plan_m(time) - time[:, None] * velocity, ahead)
    return abs(slow - found_m) if slow > 0.05 else float(found_m > 0.05)


def _deviations(samples: np.ndarray, obstacle: Obstacle, walk: Walk, seed: int) -> dict[str, float]:
    """Of range and radius at one instant."""
    time = walk.duration_s * (seed % 7) / 7.0
    truth = ground_truth(Scene([obstacle]), walk, PHONE, [time], "thing")
    pose = walk.pose([time])
    middle = pose.to_world(0.5 * (PHONE.geometry.speaker_m + PHONE.geometry.mics_m[0]))[0]
    if truth.range_m[0] < 0.3:
        return {}
    slow_range = nearest_distance(obstacle.mesh, middle - time * obstacle.velocity_m_s)
    heading = pose.body_heading_rad()[0]
    across = samples @ [-np.sin(heading), np.cos(heading)]
    return {
        "range_m": abs(truth.range_m[0] - slow_range),
        "radius_m": abs(truth.radius_m[0] - 0.5 * np.ptp(across)),
    }


def _is_true(found: dict[str, float]) -> None:
    assert 0.15 * found["walks"] < found["met"] < 0.8 * found["walks"]
    assert found["moving"] > 0.2 * found["walks"]
    assert found["close"] < 0.05 * found["walks"]
    assert found["wrong"] == 0
    assert found["range_m"] < 1e-4
    assert found["radius_m"] < 1e-9
    assert found["clearance_m"] < 1e-3
    assert found["contact_s"] < 5e-3
    assert found["miss_m"] < 5e-4


def test_three_hundred_walks_agree_with_dense_sampling() -> None:
    _is_true(compare(range(300)))


@pytest.mark.slow
def test_ten_thousand_walks_agree_with_dense_sampling() -> None:
    found = compare(range(10_000))
    print(found)
    assert found["walks"] == 10_000
    _is_true(found)


def test_the_sampled_distance_of_a_cube_is_that_of_its_closed_form() -> None:
    """The reference itself, on what is known."""
    from scenes.obstacles.solids import box

    cube = box([1.0, 1.0, 1.0])
    assert nearest_distance(cube, np.array([1.3, 0.1, 0.4])) == pytest.approx(0.8, abs=2e-5)
    assert nearest_distance(cube, np.array([1.5, 1.5, 0.4])) == pytest.approx(np.sqrt(2.0), abs=2e-5)
    assert np.ptp(plan_samples(cube), axis=0) == pytest.approx([1.0, 1.0])


def test_the_body_is_the_one_that_is_sampled() -> None:
    body = Body()
    core = body.core(np.zeros((1, 3)), np.zeros(1))[0]
    np.testing.assert_allclose(core, [[-0.15, 0.0], [-0.35, 0.0]], atol=1e-15)
    assert (body.half_width_m, body.height_m) == (0.25, 1.8)
    assert len(Slab.of(random_obstacle("wall", np.random.default_rng(0), "w").mesh, 0.0, 1.8).triangle_m) > 0
