"""The phase of microphone 1's channel: put on it and found again, off mirrors made by images and off rendered walls."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch import Recording, TrackingDetector, measure_mic_phase
from obstaclewatch.recordings.mic_phase import image_difference_m
from simulator import Material, Obstacle, Phone, Scene, render_walk
from simulator.scene.pose import StraightWalk
from tests.obstaclewatch.synthetic import BEEP, FULL_SCALE, PHONE, C, Point, beep_train, recording

PHASES = (-2.5, 0.0, 1.2)


def _turned(received, phase_rad):
    """The recording with a phase added to channel 1 at all frequencies."""
    spectrum = np.fft.rfft(received.samples[1].astype(float)) * np.exp(1j * phase_rad)
    second = np.fft.irfft(spectrum, received.samples.shape[1])
    return Recording(np.stack([received.samples[0], second.astype(np.float32)]), received.sample_rate_hz)


def _image_paths(tilt_rad, distance_m, phone=PHONE):
    """(2,) paths off a wall, in the world: the phone's axis is pitched by the tilt, the image lies behind x = 0."""
    axis = np.array([np.cos(tilt_rad), np.sin(tilt_rad)])
    speaker, mics = phone.speaker_m[1] * axis, phone.mics_m[:, 1:2] * axis
    wall_m = speaker[0] + distance_m
    return np.linalg.norm(mics - [2.0 * wall_m - speaker[0], speaker[1]], axis=1)


def _before_a_mirror(tilt_rad, distance_m=1.0, beeps=10, noise=0.05):
    """A still phone's recording of one mirror, and of a weaker echo 40 cm behind it."""
    time = np.arange(beeps * BEEP.period_samples) / BEEP.sample_rate_hz
    samples = noise * np.random.default_rng(3).standard_normal((2, len(time)))
    for mic, path_m in enumerate(_image_paths(tilt_rad, distance_m)):
        for gain, way_m in ((10.0 - 6.0 * mic, PHONE.speaker_to_mic_m[mic]), (0.5, path_m), (0.1, path_m + 0.8)):
            samples[mic] += gain * beep_train(time - way_m / C)
    return Recording(FULL_SCALE * samples, BEEP.sample_rate_hz)


@given(st.floats(-1.4, 1.7), st.floats(0.3, 5.0))
@settings(max_examples=60)
def test_image_is_that_of_a_reflection_in_the_world(tilt_rad, distance_m):
    first, second = _image_paths(tilt_rad, distance_m)
    assert image_difference_m(PHONE, tilt_rad, first) == pytest.approx((second - first, distance_m), abs=1e-9)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.5, np.pi / 2 + 0.5])
@pytest.mark.parametrize("phase_rad", PHASES)
def test_a_phase_put_on_channel_1_is_found(tilt_rad, phase_rad):
    found = measure_mic_phase(_turned(_before_a_mirror(tilt_rad), phase_rad), BEEP, PHONE, tilt_rad, 0.0, (0.7, 1.3))
    assert found.beeps == 10
    assert found.phase_rad == pytest.approx(phase_rad, abs=0.05)
    assert found.distance_m == pytest.approx(1.0, abs=0.003)
    assert 0.1 <= found.std_rad < 0.12


def test_an_error_of_the_direction_counts_least_where_the_phone_points_at_the_mirror():
    """Told 2 degrees wrong with a deviation of 2 degrees: the error is claimed, and small when square."""
    off, claimed = np.deg2rad(2.0), {}
    for tilt_rad in (0.0, 0.5):
        found = measure_mic_phase(_before_a_mirror(tilt_rad), BEEP, PHONE, tilt_rad + off, off, (0.7, 1.3))
        assert abs(found.phase_rad) < 1.5 * found.std_rad
        claimed[tilt_rad] = found.std_rad
    assert claimed[0.0] < 0.15
    assert claimed[0.5] > 0.8


@pytest.mark.parametrize("name", ["ideal", "galaxy-s8-plus", "nexus-6p"])
@pytest.mark.parametrize("phase_rad", [0.0, 2.0])
def test_rendered_walls_tell_the_phase(name, phase_rad):
    """A phone on a table at 1.3 m points at a brick wall; equal channels have no phase. The floor is received
    besides."""
    wall, floor = trimesh.creation.box([0.1, 4.0, 3.0]), trimesh.creation.box([12.0, 12.0, 0.1])
    wall.apply_translation([1.05, 0.0, 1.5])
    floor.apply_translation([0.0, 0.0, -0.05])
    brick = Material.named("brick")
    scene, phone = Scene([Obstacle(wall, brick, "wall"), Obstacle(floor, brick, "ground")]), Phone.named(name)
    still = StraightWalk(np.array([0.0, 0.0, 1.3]), heading_rad=0.0, speed_m_s=0.0, duration_s=10 * BEEP.period_s)
    received = _turned(render_walk(scene, phone, still, BEEP, seed=1), phase_rad)
    found = measure_mic_phase(received, BEEP, phone.geometry, 0.0, np.deg2rad(2.0), (0.6, 1.2), 343.9)
    assert abs(found.phase_rad - phase_rad) < found.std_rad < 0.15


def test_bearings_need_the_phase_and_get_it():
    """A walk towards a point 15 cm aside, received by a phone whose channel 1 is rotated by 2.5 rad."""
    ground = Point(1.3, gain=0.3, carried=True, bob_m=0.02)
    point = Point(5.0, 0.15, gain=0.1)
    walk = _turned(recording([ground, point], beeps=34, noise=0.02, speed_m_s=1.3), 2.5)
    wall = _turned(_before_a_mirror(0.0), 2.5)
    measured = measure_mic_phase(wall, BEEP, PHONE, 0.0, np.deg2rad(2.0), (0.7, 1.3)).phase_rad
    error = {}
    for phase_rad in (0.0, measured):
        found = [d for d in TrackingDetector(BEEP, PHONE, mic_phase_rad=phase_rad).stream(walk) if len(d)][-10:]
        assert len(found) == 10
        true = [np.arctan2(0.15, 5.0 - 1.3 * d.time_s) for d in found]
        error[phase_rad] = np.median([abs(d.bearing_rad[0] - t) for d, t in zip(found, true, strict=True)])
    assert error[measured] < np.deg2rad(3.0)
    assert error[0.0] > 2.0 * error[measured]


def test_what_cannot_be_measured_is_said():
    received = _before_a_mirror(0.3)
    with pytest.raises(ValueError, match=r"both microphones must receive an echo 15 dB above the noise at 2 to 3 m"):
        measure_mic_phase(received, BEEP, PHONE, 0.3, 0.0, (2.0, 3.0))
    with pytest.raises(ValueError, match=r"in at least 8 beeps, got 5 of 5"):
        measure_mic_phase(_before_a_mirror(0.3, beeps=5), BEEP, PHONE, 0.3, 0.0, (0.7, 1.3))
    with pytest.raises(
        ValueError, match=r"must reach microphone 1 within 3 cm of the mirror's, got .* tilt_rad is not"
    ):
        measure_mic_phase(received, BEEP, PHONE, 1.2, 0.0, (0.7, 1.3))
    moved = np.concatenate([_before_a_mirror(tilt, beeps=4).samples for tilt in (0.3, 0.4, 0.5)], axis=1)
    with pytest.raises(ValueError, match=r"must stay within 0.7 rad from beep to beep, got .* hold the phone still"):
        measure_mic_phase(Recording(moved, BEEP.sample_rate_hz), BEEP, PHONE, 0.4, 0.0, (0.7, 1.3))


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"tilt_rad": np.nan}, "tilt_rad must be finite, got nan"),
        ({"tilt_std_rad": np.nan}, "tilt_std_rad must be finite, got nan"),
        ({"tilt_std_rad": -0.1}, "tilt_std_rad must be at least 0, got -0.1"),
        ({"reach_m": (1.0, 0.5)}, r"reach_m must rise from at least 0.3 m and be finite, got \(1.0, 0.5\)"),
        ({"sound_speed_m_s": 0.0}, "sound_speed_m_s must be positive and finite, got 0.0"),
        ({"direct_delay_s": np.inf}, "direct_delay_s must be finite, got inf"),
        ({"direct_delay_s": 0.44}, "within 1.2 ms of its emission, got direct_delay_s = 0.44"),
        ({"reach_m": (0.1, 0.5)}, "reach_m must rise from at least 0.3 m"),
    ],
)
def test_arguments_out_of_range(wrong, rule):
    given_ = {"tilt_rad": 0.0, "tilt_std_rad": 0.0, "reach_m": (0.7, 1.3)} | wrong
    with pytest.raises(ValueError, match=rule):
        measure_mic_phase(_before_a_mirror(0.0), BEEP, PHONE, **given_)


def test_another_rate_is_refused():
    with pytest.raises(ValueError, match="the recording's rate must be 192000"):
        measure_mic_phase(Recording(np.ones((2, 100)), 48_000.0), BEEP, PHONE, 0.0, 0.0, (0.7, 1.3))
