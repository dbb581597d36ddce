"""Trajectories against exact geometry: points, corners with the ground and walls, seen from a pitched phone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from obstaclewatch.signal.carrier_phase import OFFSETS_M
from obstaclewatch.tracking.detector import MOST_MISFIT
from obstaclewatch.trajectories.geometry import bodies_at
from obstaclewatch.trajectories.likelihood import path_differences
from obstaclewatch.trajectories.posterior_grid import Expectation, Samples, TrajectoryGrid
from obstaclewatch.trajectories.prior import (
    HEIGHTS_M,
    RADIUS_M,
    WALL_TILTS_RAD,
    hypotheses,
    speed_density,
)
from obstaclewatch.walker.gait import OTHER_M, READING_M, reading_covariance
from obstaclewatch.walker.pitch_oscillation import STEADY, Oscillation
from obstaclewatch.walker.walking_speed import ANYONE, USUAL, WalkingSpeed, walking_speed
from tests.obstaclewatch.synthetic import BEEP, PHONE, C

LENGTH = PHONE.mic_separation_m
WAVELENGTH = C / BEEP.center_hz
AHEAD_S = BEEP.range_doppler_s
BASELINE_M = float(PHONE.speaker_to_mic_m[0])
PITCH = np.deg2rad(30.0)
GROUND_M = 1.33


def _place(ahead, miss, height, radius):
    """(K, 3) where an upright cylinder's echo comes from, seen from the phone; its corner is at `height` below."""
    middle = np.hypot(ahead, miss)
    plan = middle - radius
    return np.stack([plan * ahead / middle, plan * miss / middle, np.full_like(ahead, -height)], axis=-1)


def _path_difference(place):
    """(K,) from microphone 1, a phone's length behind microphone 0 along the pitched axis, less that to 0."""
    behind = -LENGTH * np.array([np.cos(PITCH), 0.0, np.sin(PITCH)])
    return np.linalg.norm(place - behind, axis=-1) - np.linalg.norm(place, axis=-1)


def _upright_path_difference(place):
    """(K,) the same of an upright line, or of its corner with level ground: the image is upside down there, or not."""
    axis = np.array([np.cos(PITCH), 0.0, np.sin(PITCH)])
    speaker, mics = -BASELINE_M * axis, np.stack([0.0 * axis, -LENGTH * axis])
    plan = [np.linalg.norm(place[:, :2] - at[:2], axis=-1) for at in (speaker, *mics)]
    corner = place[0, 2] != 0.0
    heights = [at[2] - place[:, 2] if corner else at[2] for at in (speaker, *mics)]
    up = [(heights[0] + other) if corner else (heights[0] - other) for other in heights[1:]]
    near, far = (np.hypot(plan[0] + leg, rise) for leg, rise in zip(plan[1:], up, strict=True))
    return far - near


def _samples(speed=1.25, miss=0.0, height=0.0, radius=0.0, level=4.0, beeps=16, last_m=1.35):
    """Exact readings of a walk that is `last_m` short of the obstacle's middle when the last beep meets it."""
    time = 0.09 * np.arange(1 - beeps, 1)
    now = _place(last_m - speed * time, miss, height, radius)
    read = _place(last_m - speed * (time + AHEAD_S), miss, height, radius)
    shape = np.exp(-(((OFFSETS_M - _upright_path_difference(read)[:, None]) / 0.1) ** 2))
    second = level * shape * np.exp(-2j * np.pi * _upright_path_difference(now) / WAVELENGTH)[:, None]
    return Samples(time + AHEAD_S, np.linalg.norm(read, axis=1), np.full(beeps, 0.004), second.astype("c8"))


def _judge(samples, now_s=0.0) -> Expectation:
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M)
    return grid.trajectory(grid.posterior(samples, now_s, GROUND_M), now_s)


@pytest.mark.parametrize("height", [0.0, GROUND_M])
@pytest.mark.parametrize("radius", [0.0, 0.25])
@pytest.mark.parametrize(("miss", "collides"), [(0.0, True), (0.2, True), (1.0, False), (1.3, False)])
def test_course_is_told_from_ranges_and_phase(height, radius, miss, collides):
    """Regression: the corner of a round bin was taken for a point at a miss distance of 0.9 m whatever its own."""
    trajectory = _judge(_samples(miss=miss, height=height, radius=radius))
    assert (trajectory.collision > 0.5) == collides
    assert abs(trajectory.collision - collides) < 0.35
    assert trajectory.miss_m == pytest.approx(miss, abs=0.35)


def test_who_knows_the_walking_speed_knows_what_is_passed_sooner():
    """Half a second of a miss by 0.8 m says little of speed and bearing by itself."""
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, None, BASELINE_M)
    samples = _samples(speed=1.5, miss=0.8, height=0.35, level=0.5, beeps=6, last_m=1.6)
    anyone, own = (
        grid.trajectory(grid.posterior(samples, 0.0, GROUND_M, STEADY, walking), 0.0)
        for walking in (USUAL, WalkingSpeed(1.5, 0.05))
    )
    assert abs(own.speed_m_s - 1.5) < 0.5 * abs(anyone.speed_m_s - 1.5)
    assert own.bearing_std_rad < anyone.bearing_std_rad
    assert own.collision < anyone.collision


@pytest.mark.parametrize("angle", [0.1, 0.2, 0.3])
def test_the_phase_itself_tells_a_walls_direction(angle):
    """A second of walking: ranges and changes of phase tell hardly anything. 0.5 is nearly a cycle from straight on."""
    time, closing = 0.09 * np.arange(-11, 1), 0.8
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    u_m = _path_difference((2.0 - closing * time)[:, None] * direction)
    shape = np.exp(-(((OFFSETS_M - u_m[:, None]) / 0.1) ** 2))
    second = (12.0 * shape * np.exp(-2j * np.pi * u_m[:, None] / WAVELENGTH + 1.0j)).astype("c8")
    samples = Samples(time + AHEAD_S, 2.0 - closing * (time + AHEAD_S), np.full(12, 0.004), second)
    grids = [TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, phase) for phase in (1.0, None)]
    known, unknown = (grid.trajectory(grid.posterior(samples, 0.0, GROUND_M), 0.0) for grid in grids)
    assert known.bearing_rad == pytest.approx(angle, abs=0.08)
    assert known.bearing_std_rad < 0.95 * unknown.bearing_std_rad


def _row_and_difference(wanted, ahead_m):
    """The trajectory nearest to (miss, height, angle, whether a wall, tilt), and its path difference that far ahead."""
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M)
    miss, height, angle, is_wall, tilt = wanted
    other = (grid._all.height_m != height) | (grid._all.is_wall != is_wall) | (grid._all.tilt_rad != tilt)
    row = int(np.argmin(np.abs(grid._all.miss_m - miss) + np.abs(grid._all.angle_rad - angle) + 9.0 * other))
    bodies = bodies_at(grid._bodies, GROUND_M)
    bodies = bodies._replace(radius_m=np.zeros_like(bodies.radius_m))
    ahead = np.full(len(bodies.miss_m), ahead_m, dtype=np.float32)
    u_m = np.empty_like(ahead)
    path_differences(u_m, bodies, ahead, PITCH, 0.0, LENGTH)
    return grid._all, row, u_m[row]


@pytest.mark.parametrize("height", [0.0, np.inf])
@pytest.mark.parametrize("miss", [0.0, 0.6])
def test_path_difference_of_upright_things_is_that_of_their_image(height, miss):
    """Regression: taken for points, things straight ahead seemed 1.5 mm, 9 degrees, off their trajectory."""
    trajectories, row, found = _row_and_difference((miss, height, 0.0, False, 0.0), 1.4)
    place = _place(np.array([1.4]), trajectories.miss_m[row], min(height, GROUND_M), 0.0)
    assert found == pytest.approx(_upright_path_difference(place)[0], abs=2e-4)
    assert abs(_path_difference(place)[0] - found) > 6e-4


def _normal(angle, tilt):
    """Of a wall that is met at that angle and leans: towards its nearest point."""
    return np.array([np.cos(angle) * np.cos(tilt), np.sin(angle) * np.cos(tilt), -np.sin(tilt)])


def _mirrored_difference(normal, distance_m):
    """(K,) from microphone 1 to the speaker's image in a plane that far off, less that from microphone 0."""
    axis = np.array([np.cos(PITCH), 0.0, np.sin(PITCH)])
    speaker = -BASELINE_M * axis
    image = speaker + 2.0 * (np.atleast_1d(distance_m)[:, None] - speaker @ normal) * normal
    return np.linalg.norm(image + LENGTH * axis, axis=1) - np.linalg.norm(image, axis=1)


@pytest.mark.parametrize("angle", [0.0, 0.5])
@pytest.mark.parametrize("tilt", np.unique(WALL_TILTS_RAD))
def test_path_difference_of_walls_is_that_of_their_image(angle, tilt):
    trajectories, row, found = _row_and_difference((0.0, 0.0, angle, True, tilt), 1.5)
    assert found == pytest.approx(_mirrored_difference(_normal(trajectories.angle_rad[row], tilt), 1.5)[0], abs=2e-4)


def test_a_panel_that_leans_is_placed_where_it_is():
    """Regression: a leaning panel of a car, 15 degrees aside, was taken for a wall at 30, and half for a miss."""
    time, angle, tilt = 0.09 * np.arange(-23, 1), np.deg2rad(15.0), np.arctan(0.28)
    normal, closing = _normal(angle, tilt), 1.25 * np.cos(angle) * np.cos(tilt)
    read_m, now_m = (1.25 - closing * at for at in (time + AHEAD_S, time))
    u_read, u_now = (_mirrored_difference(normal, distance) for distance in (read_m, now_m))
    second = 6.0 * np.exp(-(((OFFSETS_M - u_read[:, None]) / 0.1) ** 2) - 2j * np.pi * u_now[:, None] / WAVELENGTH)
    samples = Samples(time + AHEAD_S, read_m, np.full(24, 0.004), second.astype("c8"))
    steps = Oscillation(2.0 * np.pi * np.sqrt(1.25 * 60.0 / ANYONE.m_min) / 60.0, 0.0j, 0.0j, 0.0j)
    walking = walking_speed(steps.step_rad_s / (2.0 * np.pi))
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M)
    trajectory = grid.trajectory(grid.posterior(samples, 0.0, GROUND_M, steps, walking), 0.0)
    assert trajectory.bearing_rad == pytest.approx(angle, abs=np.deg2rad(8.0))
    assert trajectory.collision > 0.7
    assert trajectory.speed_m_s == pytest.approx(1.25, abs=0.1)


def test_how_far_aside_a_collision_may_be_heard_depends_on_the_height():
    """Half a metre aside is a miss of what makes a corner with the ground, and may be a collision of a car."""
    trajectories = hypotheses(0.25)
    aside = ~trajectories.is_wall & (np.abs(trajectories.miss_m - 0.52) < 0.02)
    corner, between = (
        trajectories.collision[aside & (trajectories.height_m == height)].mean() for height in (np.inf, 0.5)
    )
    assert corner < 0.5
    assert between > 0.85
    assert np.all(np.diff(trajectories.collision[~trajectories.is_wall].reshape(len(HEIGHTS_M), -1), axis=1) < 1e-12)


MIC_AHEAD_M = 0.5 * LENGTH * np.cos(PITCH)


def test_distance_and_speed_of_a_collision():
    trajectory = _judge(_samples(speed=1.3, last_m=1.6))
    assert trajectory.left_m == pytest.approx(1.6 + MIC_AHEAD_M - 0.1, abs=0.1)  # a point is taken for a body of 15 cm
    assert trajectory.speed_m_s == pytest.approx(1.3, abs=0.05)
    assert trajectory.contact_s == pytest.approx(trajectory.left_m / trajectory.speed_m_s)
    oncoming = _judge(_samples(speed=2.5, last_m=2.0))
    assert oncoming.speed_m_s == pytest.approx(2.5, abs=0.1)
    assert oncoming.left_m == pytest.approx((1.9 + MIC_AHEAD_M) * 1.4 / 2.5, abs=0.1)
    assert oncoming.contact_s == pytest.approx((1.9 + MIC_AHEAD_M) / 2.5, abs=0.05)


def _walk_to_contact(outline):
    """Distance that a body of 0.25 m half width walks along x until its round front, 0.1 m ahead, meets points."""

    def gap_m(walked_m):
        return np.hypot(outline[:, 0] - (walked_m + 0.1 - 0.25), outline[:, 1]).min() - 0.25

    walked = np.arange(0.0, 3.0, 0.01)
    after = next(index for index, walked_m in enumerate(walked) if gap_m(walked_m) <= 0.0)
    return brentq(gap_m, walked[after - 1], walked[after])


@pytest.mark.parametrize("miss", [0.0, 0.15, 0.3])
def test_way_left_is_that_to_the_first_touch_of_a_round_body(miss):
    trajectories = hypotheses(0.25)
    row = int(np.argmin(np.abs(trajectories.miss_m - miss) + trajectories.is_wall))
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    outline = np.array([1.5, trajectories.miss_m[row]]) + RADIUS_M * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert 1.5 - trajectories.contact_m[row] == pytest.approx(_walk_to_contact(outline), abs=5e-4)


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.9])
def test_way_left_is_that_to_the_first_touch_of_a_wall(angle):
    """Regression: left was the way along the wall's normal, 40 cm too little where it met the walk at 50 degrees."""
    trajectories = hypotheses(0.25)
    row = int(np.argmin(np.abs(trajectories.angle_rad - angle) + ~trajectories.is_wall))
    rotated = trajectories.angle_rad[row]
    normal, along = np.array([np.cos(rotated), np.sin(rotated)]), np.array([-np.sin(rotated), np.cos(rotated)])
    outline = 1.2 * normal + np.linspace(-3.0, 3.0, 6001)[:, None] * along
    left = 1.2 / np.cos(rotated) - trajectories.contact_m[row]
    assert left == pytest.approx(_walk_to_contact(outline), abs=5e-4)


@pytest.mark.parametrize(("angle", "collides"), [(0.0, True), (0.35, True), (1.3, False)])
def test_walls_keep_their_angle(angle, collides):
    """A wall is received along its normal: range falls at v cos(angle), direction stays."""
    time = 0.09 * np.arange(-15, 1)
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    read_m = 1.5 - 1.25 * np.cos(angle) * (time + AHEAD_S)
    now_m = 1.5 - 1.25 * np.cos(angle) * time
    u_read, u_now = (_path_difference(distance[:, None] * direction) for distance in (read_m, now_m))
    second = 20.0 * np.exp(-(((OFFSETS_M - u_read[:, None]) / 0.05) ** 2) - 2j * np.pi * u_now[:, None] / WAVELENGTH)
    trajectory = _judge(Samples(time + AHEAD_S, read_m, np.full(16, 0.002), second.astype("c8")))
    assert (trajectory.collision > 0.5) == collides
    assert trajectory.bearing_rad == pytest.approx(angle, abs=0.3)


def test_cosine_is_that_of_the_cone():
    place = _place(np.array([1.35]), 0.3, GROUND_M, 0.0)[0]
    cosine = place @ [np.cos(PITCH), 0.0, np.sin(PITCH)] / np.linalg.norm(place)
    trajectory = _judge(_samples(miss=0.3, height=GROUND_M))
    assert trajectory.cosine == pytest.approx(cosine, abs=0.12)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.8, 2.6), st.floats(0.0, 2.0), st.floats(0.0, 1.3), st.floats(-1.0, 1.0), st.integers(3, 16))
def test_probabilities_stay_probabilities_and_time_has_no_origin(speed, miss, height, shift_s, beeps):
    samples = _samples(speed, miss, height, beeps=beeps)
    trajectory = _judge(samples)
    moved = Samples(samples.time_s + shift_s, samples.range_m, samples.range_std_m, samples.second)
    later = _judge(moved, shift_s)
    assert 0.0 <= trajectory.collision <= 1.0 + 1e-9
    assert 0.0 <= trajectory.bearing_rad <= np.pi / 2
    assert later.collision == pytest.approx(trajectory.collision, abs=1e-6)
    assert later.left_m == pytest.approx(trajectory.left_m, abs=1e-6)


@pytest.mark.parametrize("height", [0.0, GROUND_M])
def test_a_posterior_is_carried_along_its_courses(height):
    """Two beeps later it says what the same readings say if they are asked for that time."""
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M)
    samples = _samples(miss=0.3, height=height, last_m=1.8)
    before = grid.posterior(samples, 0.0, GROUND_M)
    carried, asked = grid.trajectory(before, 0.18), grid.trajectory(grid.posterior(samples, 0.18, GROUND_M), 0.18)
    assert carried == pytest.approx(asked, abs=2e-3)
    assert carried.left_m == pytest.approx(grid.trajectory(before, 0.0).left_m - 0.18 * carried.speed_m_s, abs=0.02)


def test_what_bob_and_surge_do_to_the_range_of_each_course():
    """Of every single trajectory: differences of the range with the phone 1 mm higher, and 1 mm further ahead."""
    grid = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M)
    judged, step_m = grid.posterior(_samples(miss=0.3, height=GROUND_M, last_m=1.8), 0.0, GROUND_M), 1e-3
    bodies, seen = bodies_at(judged.bodies, judged.ground_m), 0
    for trajectory in range(0, len(judged.share), 7):
        height, radius, miss, cos_angle, stays = (float(column[trajectory]) for column in bodies[:5])
        ahead = float(judged.ahead_m[trajectory])

        def range_m(higher_m, further_m, at=(height, radius, miss, cos_angle, stays, ahead)):
            height, radius, miss, cos_angle, stays, ahead = at
            plan = np.hypot(ahead - further_m * cos_angle, miss) - radius
            return np.hypot(plan, height + stays * higher_m)

        alone = grid.trajectory(judged._replace(share=np.eye(1, len(judged.share), trajectory)[0]), 0.0)
        seen += 1
        assert alone.bob == pytest.approx((range_m(step_m, 0.0) - range_m(-step_m, 0.0)) / 2e-3, abs=1e-4)
        assert alone.fore_aft == pytest.approx((range_m(0.0, -step_m) - range_m(0.0, step_m)) / 2e-3, abs=1e-4)
    assert seen == 55


def test_channels_that_say_nothing_leave_the_ranges():
    samples = _samples()
    silent = Samples(samples.time_s, samples.range_m, samples.range_std_m, np.full_like(samples.second, np.nan))
    assert np.isfinite(_judge(silent).collision)
    assert _judge(silent).left_m == pytest.approx(1.25 + MIC_AHEAD_M, abs=0.15)


def test_prior_is_half_collisions_and_a_density_of_speeds():
    prior = hypotheses(0.25)
    share = np.exp(prior.log_prior)
    assert share.sum() == pytest.approx(1.0)
    assert share @ prior.collision == pytest.approx(0.5)
    speed = np.linspace(0.0, 4.0, 4001)
    assert np.trapezoid(speed_density(speed, *USUAL), speed) == pytest.approx(1.0, abs=0.01)


def test_gait_covariance_is_that_of_many_random_steps():
    """Monte Carlo: sinusoids of random phase and frequency."""
    rng = np.random.default_rng(5)
    time = 0.09 * np.arange(8)
    frequency, phase = rng.normal(1.85, 0.15, (20_000, 1)), rng.uniform(0.0, 2.0 * np.pi, (20_000, 1))
    fore_aft = 0.020 * np.sqrt(2.0) * np.sin(2.0 * np.pi * frequency * time + phase)
    expected = reading_covariance(time, np.zeros(8), READING_M) - OTHER_M**2 * np.eye(8)
    assert fore_aft.T @ fore_aft / len(fore_aft) == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize("height", [0.0, GROUND_M])
def test_readings_of_another_echo_fit_no_course(height):
    """What a track began on shows in the misfit, and forgetting it mends it."""
    grid, own = TrajectoryGrid(LENGTH, WAVELENGTH, PITCH, 0.25, AHEAD_S, 0.0, BASELINE_M), _samples(height=height)
    off_m = np.where(np.arange(len(own.time_s)) < 8, 0.25, 0.0)
    mixed = own._replace(range_m=own.range_m + off_m)
    late = Samples(own.time_s[8:], own.range_m[8:], own.range_std_m[8:], own.second[8:])
    clean, jumped, left = (grid.posterior(samples, 0.0, GROUND_M).misfit for samples in (own, mixed, late))
    assert clean < 1.0
    assert left < 1.0
    assert jumped > MOST_MISFIT
