"""Rendered beeps against the retarded-time formula, evaluated sample by sample with nothing shared."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.beep import BeepDesign
from simulator import Air, Fidelity, Scene, StraightWalk, held_rotation, render_walk
from simulator.images.given_planes import crossings_in_turn
from simulator.render import sum_envelopes, to_rate, trace_walk

C = 343.0
BEEP = BeepDesign()
MIRRORS = Fidelity(mechanisms=("specular", "curved"))


def _retarded(walk, phone, mic, mirror_x, mirror_speed, time):
    """Beep heard by a moving microphone off a moving mirror x = mirror_x + mirror_speed t, by fixed point."""
    velocity = walk.speed_m_s * np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad), 0.0])
    turn = held_rotation(walk.heading_rad, walk.pitch_rad).as_matrix()
    speaker = walk.start_m + turn @ phone.geometry.speaker_m
    receiver = walk.start_m + turn @ phone.geometry.mics_m[mic] + time[:, None] * velocity
    emitted, struck = time - 0.01, time - 0.005
    for _ in range(60):
        image = speaker + emitted[:, None] * velocity
        image[:, 0] = 2.0 * (mirror_x + mirror_speed * struck) - image[:, 0]
        length = np.linalg.norm(receiver - image, axis=1)
        x = mirror_x + mirror_speed * struck
        share = (x - receiver[:, 0]) / (image[:, 0] - receiver[:, 0])
        struck = time - share * length / C
        emitted = time - length / C
    beep_index = np.floor(emitted / BEEP.period_s)
    return np.where(emitted >= 0.0, BEEP.waveform(emitted - beep_index * BEEP.period_s) / length, 0.0)


@pytest.mark.parametrize(("speed", "heading"), [(0.0, 0.0), (1.0, 0.0), (1.6, 0.0), (1.4, 0.35)])
@pytest.mark.parametrize("mic", [0, 1])
def test_wall_echo_while_walking(box, phone, speed, heading, mic):
    walk = StraightWalk([0.0, 0.0, 1.3], heading, speed, 6 * BEEP.period_s, pitch_rad=0.5)
    scene = Scene([box((0.2, 12.0, 4.0), (3.1, 0.0, 1.5), "wall")], Air.lossless(C))
    paths, motion, count = trace_walk(scene, phone, walk, BEEP, MIRRORS)
    echo = paths.order == 1
    assert echo.sum() == 2 * count
    heard = to_rate(sum_envelopes(paths[echo], motion[echo], BEEP, count), phone, BEEP, count * BEEP.period_samples)
    time = np.arange(heard.shape[1]) / BEEP.sample_rate_hz
    exact = _retarded(walk, phone, mic, 3.0, 0.0, time)
    assert np.linalg.norm(heard[mic] - exact) < 1e-6 * np.linalg.norm(exact)


def test_closing_on_a_wall_stretches_time_by_the_doppler_factor(box):
    # t_r = (2 D0 + (c - v) t_e) / (c + v): emission time grows by (c + v) / (c - v) per reception time
    from simulator import Phone

    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.0, 1e-4], [0.0, 0.0, -1e-4]])
    walk = StraightWalk([0.0, 0.0, 1.5], 0.0, 1.5, 4 * BEEP.period_s)
    scene = Scene([box((0.2, 12.0, 4.0), (3.1, 0.0, 1.5), "wall")], Air.lossless(C))
    paths, motion, _ = trace_walk(scene, phone, walk, BEEP, MIRRORS)
    echo = motion[paths.order == 1]
    assert len(echo.middle_s) == 8
    slope = 1.0 - echo.delay_s[:, 1] / echo.half_width_s
    np.testing.assert_allclose(slope, (C + 1.5) / (C - 1.5), rtol=1e-9)


def test_receding_wall_is_followed(box, phone):
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 1.2, 5 * BEEP.period_s)
    wall = box((0.2, 12.0, 4.0), (3.1, 0.0, 1.5), "wall", velocity_m_s=[0.7, 0.0, 0.0])
    paths, motion, count = trace_walk(Scene([wall], Air.lossless(C)), phone, walk, BEEP, MIRRORS)
    echo = paths.order == 1
    assert echo.sum() == 2 * count
    heard = to_rate(sum_envelopes(paths[echo], motion[echo], BEEP, count), phone, BEEP, count * BEEP.period_samples)
    time = np.arange(heard.shape[1]) / BEEP.sample_rate_hz
    exact = _retarded(walk, phone, 0, 3.0, 0.7, time)
    # the mirror's own motion lengthens a slanted ray in second order of v / c: 5e-6 of 6 m is a thousandth of a wave
    assert np.linalg.norm(heard[0] - exact) < 1e-2 * np.linalg.norm(exact)


def test_same_seed_same_samples_and_noise_changes_with_it(box):
    from simulator import Phone

    phone = Phone.named("galaxy-s5")
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 1.2, 3 * BEEP.period_s)
    scene = Scene([box((0.2, 12.0, 4.0), (3.1, 0.0, 1.5), "wall")])
    first, again, other = (render_walk(scene, phone, walk, BEEP, seed=seed).samples for seed in (5, 5, 6))
    assert first.shape == (2, 3 * BEEP.period_samples)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_too_short_a_walk_is_refused(box, phone):
    with pytest.raises(ValueError, match=r"one beep period .* got 0.05"):
        render_walk(Scene([]), phone, StraightWalk([0, 0, 1.3], 0.0, 1.0, 0.05), BEEP)


def test_empty_scene_gives_the_direct_sound_alone(phone):
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, 2 * BEEP.period_s)
    recording = render_walk(Scene([], Air.lossless(C)), phone, walk, BEEP)
    samples = recording.samples[0] / phone.full_scale_gain
    direct = BEEP.waveform(np.arange(17_280) / BEEP.sample_rate_hz - 0.02 / C) / 0.02
    np.testing.assert_allclose(
        samples[:17_280], direct, atol=50 * 1e-6
    )  # the ends of the Hann window, a kink, are band-limited


@pytest.mark.parametrize(("start", "speed"), [(2.0, 15.0), (6.5, -30.0)])
def test_wall_as_fast_as_a_car(box, phone, speed, start):
    # Cause: what arrived outside the beep's length plus 2 % was cut, and five retardations did not settle: 3e-3 at
    # 15 m/s receding, 2e-3 at 30 m/s approaching.
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, 2 * BEEP.period_s)
    wall = box((0.2, 12.0, 4.0), (start + 0.1, 0.0, 1.3), "wall", velocity_m_s=[speed, 0.0, 0.0])
    paths, motion, count = trace_walk(Scene([wall], Air.lossless(C)), phone, walk, BEEP, MIRRORS)
    echo = paths.order == 1
    assert echo.sum() == 2 * count
    heard = to_rate(sum_envelopes(paths[echo], motion[echo], BEEP, count), phone, BEEP, count * BEEP.period_samples)
    time = np.arange(heard.shape[1]) / BEEP.sample_rate_hz
    speaker = phone.geometry.speaker_m[1]
    for mic, receiver in enumerate(phone.geometry.mics_m[:, 1]):
        struck = (time - (start - receiver) / C) / (1.0 + speed / C)  # square on: all in one line
        emitted = struck - (start + speed * struck - speaker) / C
        beep = BEEP.waveform(emitted % BEEP.period_s) * (emitted >= 0.0)
        exact = beep / (C * (time - emitted))
        assert np.linalg.norm(heard[mic] - exact) < 1e-6 * np.linalg.norm(exact)


def test_a_crossing_does_not_run_off_where_image_and_receiver_are_on_one_side():
    """A microphone that passes the plane of a bin's face within a beep made a path of 47 m."""
    start, image = np.array([[0.0, 0.0, 0.0100], [0.0, 0.0, 0.01]]), np.array([[[2.0, 0.0, 0.0099], [2.0, 0.0, -0.03]]])
    up = np.tile([0.0, 0.0, 1.0], (2, 1, 1))
    crossing = crossings_in_turn(start, image, up, np.zeros((2, 1)), [(0, np.array([True, True]))])
    np.testing.assert_allclose(crossing[:, 0], [[2.0, 0.0, 0.0099], [0.5, 0.0, 0.0]], atol=1e-12)


def test_cells_of_the_integral_grow_as_the_way_there_times_the_way_back(box, phone):
    """Cause: cells counted as apexes of edges, whose strength goes with the power 1.5 of the distance."""
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 1.3, BEEP.period_s)
    scene = Scene([box((0.2, 0.2, 0.2), (1.1, 0.0, 1.3), "box")], Air.lossless(C))
    paths, motion, _ = trace_walk(scene, phone, walk, BEEP, Fidelity(mechanisms=("kirchhoff",)))
    loudest = int(np.argmax(np.abs(paths.gain) * (paths.order == 1)))
    ends = np.array([-1.0, 0.0, 1.0])
    times_length, delay = (
        np.polynomial.chebyshev.chebval(ends, each[loudest]) for each in (motion.strength, motion.delay_s)
    )
    amplitude = times_length / delay
    np.testing.assert_allclose(amplitude / amplitude[1], (delay[1] / delay) ** 2, rtol=2e-3)
