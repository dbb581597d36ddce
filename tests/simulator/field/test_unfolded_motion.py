"""Delays of cells and mirrors that move, against fixed points worked out one path at a time."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.polynomial import chebyshev

from obstaclewatch.beep import BeepDesign
from simulator import Air, Fidelity, Material, Obstacle, Scene, StraightWalk, held_rotation
from simulator.field.unfolded_motion import track_of
from simulator.render import trace_walk

C = 343.0
BEEP = BeepDesign()
WALK = StraightWalk([0.0, 0.1, 1.3], 0.2, 1.4, 2 * BEEP.period_s, pitch_rad=0.4)
BALL_M_S, WALL_M_S = np.array([-2.0, 0.8, 0.0]), 1.5
WALL_M = 4.0  # where the wall's front is at time 0
DEGREE = 4


@pytest.fixture(scope="module")
def traced():
    from simulator import Phone

    phone = Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.2)
    ball.apply_translation([2.0, 0.5, 1.2])
    plate = trimesh.creation.box(bounds=[[WALL_M, -4.0, -2.0], [WALL_M + 0.1, 4.0, 4.0]])
    obstacles = [
        Obstacle(ball, Material.rigid(), "ball", velocity_m_s=BALL_M_S),
        Obstacle(plate, Material.rigid(), "wall", velocity_m_s=[WALL_M_S, 0.0, 0.0]),
    ]
    fidelity = Fidelity(mechanisms=("specular", "kirchhoff"), motion_degree=DEGREE, edge_floor_db=-np.inf)
    return phone, *trace_walk(Scene(obstacles, Air.lossless(C)), phone, WALK, BEEP, fidelity)[:2]


@pytest.mark.parametrize("names", ["ball", "wall", "wall > ball", "ball > wall"])
def test_moving_mirrors_and_cells(traced, names):
    phone, paths, motion = traced
    rows = np.flatnonzero((paths.obstacle == names) & (paths.pose == 1))
    assert len(rows) >= 2
    node = -np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    for row in rows[:: max(1, len(rows) // 6)]:
        delay = chebyshev.chebval(node, motion.delay_s[row])
        exact = [_delay(phone, paths, row, motion.middle_s[row] + x * motion.half_width_s) for x in node]
        np.testing.assert_allclose(delay, exact, rtol=0.0, atol=1e-9 / C)


def _delay(phone, paths, row, reception) -> float:
    """One path at one instant: 40 rounds, each of which settles it by the speeds over that of sound."""
    rotation = held_rotation(WALK.heading_rad, WALK.pitch_rad).as_matrix()
    ahead = WALK.speed_m_s * np.array([np.cos(WALK.heading_rad), np.sin(WALK.heading_rad), 0.0])
    receiver = WALK.start_m + rotation @ phone.geometry.mics_m[paths.mic[row]] + ahead * reception
    met = str(paths.obstacle[row]).split(" > ")
    traced_at = paths.pose[row] * BEEP.period_s + 0.5 * BEEP.duration_s
    delay, struck = paths.delay_s[row], np.full(len(met), traced_at)
    for _ in range(40):
        emission = reception - delay
        points = [WALK.start_m + rotation @ phone.geometry.speaker_m + ahead * emission, receiver]
        for k, name in enumerate(met):
            if name == "ball":
                points.insert(-1, paths.points_m[row, k + 1] + BALL_M_S * (struck[k] - traced_at))
        if "wall" in met:
            at = met.index("wall")
            front = WALL_M + WALL_M_S * struck[at]
            before, after = points[at], points[at + 1]
            share = (front - before[0]) / (2.0 * front - after[0] - before[0])  # along the line to the image
            hit = before + share * (after - before)
            points.insert(at + 1, np.array([front, hit[1], hit[2]]))
        legs = np.linalg.norm(np.diff(points, axis=0), axis=1) / C
        delay, struck = legs.sum(), emission + np.cumsum(legs)[:-1]
    return delay


def test_a_gait_is_followed():
    # Cause of the step: a cubic spline errs by h^4 / 384 of the fourth derivative; of steps of 2 Hz and 3 cm, 1e-11 m.
    from scenes import GaitWalk

    walk, speaker, mics = GaitWalk(np.zeros(3), duration_s=2.0), np.array([0.0, 0.05, 0.0]), np.eye(3)[:2] * 0.07
    track = track_of(walk, (speaker, mics), np.zeros(3), 0.0, 2.0)
    time = np.random.default_rng(1).uniform(0.0, 2.0, 200)
    place = ((time - track.start_s) / 1e-3).astype(int)
    rest = time - track.start_s - 1e-3 * place
    columns = sum(track.pieces[place, :, k] * rest[:, None] ** k for k in range(4))
    pose = walk.pose(time)
    np.testing.assert_allclose(columns[:, :3], pose.to_world(speaker), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(columns[:, 6:9], pose.to_world(mics[1]), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(columns[:, 12], pose.body_heading_rad(), rtol=0.0, atol=1e-9)
