"""Make dense_passages.npz: random walks past random obstacles, by dense sampling. From the repository root:

python -m tests.references.make_dense_passages

takes about a minute on one core. Half of the obstacles are placed so that the body's side passes within 6 cm of
contact, where a verdict is easily wrong.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np

from scenes import Pace, Route, RouteWalk, Stop
from scenes.obstacles import CATEGORIES, random_obstacle
from scenes.streets.placing import placed
from scenes.walks.gait_walk import Gait, GaitWalk
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle
from tests.scenes.brute_force import miss_distance, nearest_distance, passage, plan_samples

STORED = Path(__file__).with_name("dense_passages.npz")
WALKS = 300
PHONE = Phone.named("galaxy-s5")


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


class Dense(NamedTuple):
    """One passage by sampling; lengths in metres, NaN where there is nothing to compare."""

    gap_m: float
    contact_s: float
    miss_m: float
    """Of the mean way of a `RouteWalk`."""
    range_m: float
    """From the middle of speaker and microphone 0 at `instant_s`."""
    across_m: float
    """Width of the obstacle across the walker's way then."""


def instant_s(walk: Walk, seed: int) -> float:
    """When range and width are compared."""
    return walk.duration_s * (seed % 7) / 7.0


def sampled(obstacle: Obstacle, walk: Walk, seed: int) -> Dense:
    samples = plan_samples(obstacle.mesh)
    slow = passage(samples, obstacle, walk)
    miss_m = _missed(samples, obstacle, walk) if isinstance(walk, RouteWalk) else np.nan
    time = instant_s(walk, seed)
    pose = walk.pose([time])
    middle = pose.to_world(0.5 * (PHONE.geometry.speaker_m + PHONE.geometry.mics_m[0]))[0]
    heading = pose.body_heading_rad()[0]
    across = samples @ [-np.sin(heading), np.cos(heading)]
    range_m = nearest_distance(obstacle.mesh, middle - time * obstacle.velocity_m_s)
    return Dense(slow.gap_m, slow.contact_time_s, miss_m, range_m, float(np.ptp(across)))


def _missed(samples: np.ndarray, obstacle: Obstacle, walk: RouteWalk) -> float:
    """Distance by which the mean way misses the samples; NaN for who stands still relative to the obstacle."""
    end, velocity = walk.duration_s, obstacle.velocity_m_s[:2]
    time = np.linspace(0.0, end, 3000)
    heading = walk.route.heading_rad(walk.pace.distance(np.array([end])))[0]
    step = walk.mean_plan_m([end - 1e-6, end])
    speed = np.linalg.norm(step[1] - step[0]) / 1e-6
    ahead = speed * np.array([np.cos(heading), np.sin(heading)]) - velocity
    if np.linalg.norm(ahead) < 0.05:
        return np.nan
    return miss_distance(samples, walk.mean_plan_m(time) - time[:, None] * velocity, ahead)


def fingerprint(obstacle: Obstacle, walk: Walk) -> int:
    """Of what a seed yields: where it yields something else, the stored values are of another passage."""
    pose = walk.pose([0.0, 0.5 * walk.duration_s])
    numbers = np.concatenate([obstacle.mesh.vertices.ravel(), obstacle.velocity_m_s, pose.position_m.ravel()])
    return int.from_bytes(sha256(np.round(numbers, 6).astype(np.float32).tobytes()).digest()[:4])


def main() -> None:
    """Compute and store `Dense` of all seeds."""
    passages = [random_passage(seed) for seed in range(WALKS)]
    values = [sampled(*passage, seed) for seed, passage in enumerate(passages)]
    prints = np.array([fingerprint(*passage) for passage in passages], np.uint32)
    np.savez_compressed(STORED, values=np.array(values), fingerprint=prints)


if __name__ == "__main__":
    main()
