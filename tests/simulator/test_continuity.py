"""Echoes of all five categories as a phone moves on by millimetres: nothing may come or go at once.

Cause: mechanisms were chosen pose by pose and a ray was there or not, so that a bin's echo jumped by -3 dB re a wall's
and a person's by +9 dB within a millimetre.

An echo over a path that moves by up to 2 mm a step turns by 0.86 rad at most at 23 kHz; a high-pass filter over the
steps that stops all slower turns leaves the jumps. Places are ordinary ones: where a part of a bin hides the corner
echo of another, it still comes and goes at -12 dB.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.signal import firls

from scenes.obstacles import ground, random_obstacle
from simulator import Fidelity, Material, Obstacle, Phone, Pose, PreparedScene, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 26)
TURN = 2.0 * np.pi * 23_300.0 * 2e-3 / 340.0 / np.pi  # the fastest, re half a turn a step
TAPS, STEPS, AWAY_M = 19, 28, 2.0
HIGH_PASS = firls(TAPS, [0.0, TURN, TURN + 0.3, 1.0], [0.0, 0.0, 1.0, 1.0], weight=[3000.0, 1.0])
PHONE = Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])


def jump(echo: np.ndarray) -> float:
    """Greatest step of echoes (N, ...) over N poses, whatever turns slowly apart: rms over the last axis."""
    left = np.apply_along_axis(np.convolve, 0, echo, HIGH_PASS, "valid") / _of_a_step()
    return float(np.sqrt((np.abs(left) ** 2).mean(axis=-1)).max())


def _of_a_step() -> float:
    return float(np.abs(np.cumsum(HIGH_PASS)).max())


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.86])
def test_the_measure_tells_a_step_from_a_turning_echo(turn):
    wave = np.exp(1j * turn * np.arange(STEPS))[:, None]
    assert jump(wave) < 3e-3
    stepped = wave * (1.0 + 0.1 * (np.arange(STEPS) >= STEPS // 2)[:, None])
    assert 0.07 < jump(stepped) < 0.14


@cache
def street(category: str) -> tuple[PreparedScene, Obstacle]:
    target = random_obstacle(category, np.random.default_rng(3), "target")
    return PreparedScene(Scene([Obstacle(ground(), Material.named("asphalt"), "ground"), target])), target


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize("category", ["wall", "dustbin", "car", "sign", "pedestrian"])
def test_no_echo_jumps_in_steps_of_a_millimetre(category, level):
    scene, target = street(category)
    start = np.array([float(target.mesh.bounds[0, 0]) - AWAY_M, 0.1, 1.3])
    for axis in np.eye(3):
        place = start + 1e-3 * np.arange(STEPS)[:, None] * axis
        pose = Pose(place, held_rotation(np.zeros(STEPS), np.full(STEPS, np.deg2rad(30.0)), np.zeros(STEPS)))
        paths = trace_paths(scene, PHONE, pose, Fidelity(level=level))
        mine = paths[np.array(["target" in met for met in paths.obstacles_met()])]
        assert 2.0 * AWAY_M * jump(mine.transfer_function(FREQUENCY_HZ)) < 10.0 ** (-35.0 / 20.0)
