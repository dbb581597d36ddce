"""Walking towards a wall: rendered beeps against retarded times, and the tracking detector's range."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.cells.association import nearest_within
from benchmarks.gates.physics.measured import Measured
from obstaclewatch import BeepDesign, Recording, TrackingDetector
from simulator import Air, Fidelity, Material, Obstacle, Phone, Scene, StraightWalk, held_rotation
from simulator.render import sum_envelopes, to_rate, trace_walk

SOUND_M_S = 343.0
BEEP = BeepDesign()
MIRRORS = Fidelity(mechanisms=("specular", "curved"))
PHONE = Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
START_M = np.array([0.0, 0.0, 1.3])
WALKING_M_S = (1.0, 1.3, 1.6)
DIRECT, ECHO, NOISE = 10.0, 1.0, 0.01
"""Amplitudes as recorded: the direct sound 40 dB over a wall's echo at 3 m (0.17), noise for 35 dB there."""


def motion_error(seed: int) -> Measured:
    """Greatest relative L2 difference of a wall's echo on straight walks from the retarded-time formula."""
    rng, errors, beeps = np.random.default_rng(seed), [], 0
    for speed in WALKING_M_S:
        walk = StraightWalk(START_M, float(rng.uniform(-0.35, 0.35)), speed, 3 * BEEP.period_s, pitch_rad=0.5)
        paths, motion, count = trace_walk(_wall(3.0), PHONE, walk, BEEP, MIRRORS)
        echo = paths.order == 1
        if echo.sum() != 2 * count:
            return Measured(np.nan, "relative", 0)
        block = to_rate(sum_envelopes(paths[echo], motion[echo], BEEP, count), PHONE, BEEP, count * BEEP.period_samples)
        time = np.arange(block.shape[1]) / BEEP.sample_rate_hz
        for mic in (0, 1):
            exact = _retarded(walk, mic, 3.0, time)
            errors.append(np.linalg.norm(block[mic] - exact) / np.linalg.norm(exact))
        beeps += count
    return Measured(float(np.max(errors)), "relative", beeps)


def moving_bias_m(seed: int) -> Measured:
    """Greatest median range error of `TrackingDetector` while walking at a wall at 1.0, 1.3 and 1.6 m/s."""
    found = [_median_range_error_m(speed, seed) for speed in WALKING_M_S]
    return Measured(float(np.max([abs(value) for value, _ in found])), "m", min(n for _, n in found) * len(found))


def _median_range_error_m(speed_m_s: float, seed: int) -> tuple[float, int]:
    """Median error over the beeps in which the wall is followed, and their number."""
    beeps, wall_x = 30, 5.2
    walk = StraightWalk(START_M, 0.0, speed_m_s, beeps * BEEP.period_s)
    time = np.arange(beeps * BEEP.period_samples) / BEEP.sample_rate_hz
    noise = NOISE * np.random.default_rng(seed).standard_normal((2, len(time)))
    samples = [ECHO * _retarded(walk, mic, wall_x, time) + DIRECT * _direct(mic, time) for mic in (0, 1)]
    recording = Recording((0.05 * (np.array(samples) + noise)).astype(np.float32), BEEP.sample_rate_hz)
    errors = []
    for detection in TrackingDetector(BEEP, PHONE.geometry).stream(recording):
        middle = detection.time_s + 0.5 * BEEP.duration_s
        # the wall is met (wall - x) / (c + v) after the beep's middle has left
        met = middle + (wall_x - speed_m_s * middle) / (SOUND_M_S + speed_m_s)
        truth = wall_x - speed_m_s * met - PHONE.geometry.mics_m[0, 1]
        nearest = nearest_within(detection.range_m, truth, 0.5)
        if nearest is not None:
            errors.append(float(detection.range_m[nearest]) - truth)
    return (float(np.median(errors)), len(errors)) if errors else (np.nan, 0)


def _wall(x_m: float) -> Scene:
    place = trimesh.transformations.translation_matrix((x_m + 0.1, 0.0, 1.5))
    return Scene(
        [Obstacle(trimesh.creation.box((0.2, 12.0, 4.0), place), Material.rigid(), "wall")], Air.lossless(SOUND_M_S)
    )


def _direct(mic: int, time_s: NDArray) -> NDArray:
    delay = np.linalg.norm(PHONE.geometry.speaker_m - PHONE.geometry.mics_m[mic]) / SOUND_M_S
    return _beeps(time_s - delay)


def _beeps(emitted_s: NDArray) -> NDArray:
    return np.where(emitted_s >= 0.0, BEEP.waveform(np.mod(emitted_s, BEEP.period_s)), 0.0)


def _retarded(walk: StraightWalk, mic: int, wall_x_m: float, time_s: NDArray) -> NDArray:
    """(N,) echo of a rigid wall x = wall_x_m at a walking microphone: emission times by fixed point, gain 1 / L."""
    velocity = walk.speed_m_s * np.array([np.cos(walk.heading_rad), np.sin(walk.heading_rad), 0.0])
    turn = held_rotation(walk.heading_rad, walk.pitch_rad).as_matrix()
    speaker = walk.start_m + turn @ PHONE.geometry.speaker_m
    receiver = walk.start_m + turn @ PHONE.geometry.mics_m[mic] + time_s[:, None] * velocity
    emitted = time_s - 0.02
    for _ in range(12):  # each round is v / c = 1/200 more exact
        image = speaker + emitted[:, None] * velocity
        image[:, 0] = 2.0 * wall_x_m - image[:, 0]
        length = np.linalg.norm(receiver - image, axis=1)
        emitted = time_s - length / SOUND_M_S
    return _beeps(emitted) / length
