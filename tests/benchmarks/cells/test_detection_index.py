"""The detection index: of one mirror path by hand, and of a recording's own peak."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from benchmarks.cells.detection_index import NO_ECHO_DB, detection_index_db
from benchmarks.cells.situations.situation import Situation
from obstaclewatch import BeepDesign
from scenes import ground_truth
from simulator import Air, Fidelity, Material, Obstacle, Phone, Scene, StraightWalk

BEEP, FIDELITY = BeepDesign(), Fidelity(max_order=1, max_range_m=7.0)
LOUD = replace(Phone.named("ideal"), level_spl_db=55.0, noise_spl_db=30.0)


def index_of(phone: Phone, front_m: float) -> float:
    """A phone held still before a rigid wall."""
    wall = trimesh.creation.box(bounds=[[front_m, -3.0, -3.0], [front_m + 0.2, 3.0, 3.0]])
    scene = Scene([Obstacle(wall, Material.rigid(), "wall", category="wall")], Air.lossless(343.0))
    walk = StraightWalk([0.0, 0.0, 0.0], heading_rad=0.0, speed_m_s=0.0, duration_s=0.09)
    truth = ground_truth(scene, walk, phone, [0.02, 0.04], "wall")
    return detection_index_db(Situation(scene, walk, phone, ("wall",)), truth, BEEP, FIDELITY)


def test_a_mirror_path_has_the_energy_of_its_length():
    """2 E / N0: a path of length s has 1 / s of the sine's amplitude, a Hann window 3/8 of its power for 50 ms."""
    path_m = 2.0 * 1.5 - float(np.sum(LOUD.geometry.speaker_m[1] + LOUD.geometry.mics_m[0, 1]))
    in_band = 10.0 ** ((55.0 - 30.0) / 10.0) * 5000.0  # power of the sine over the noise's density
    expected = 10.0 * np.log10(2.0 * in_band * 0.375 * 0.050 / path_m**2)
    assert index_of(LOUD, 1.5) == pytest.approx(expected, abs=0.15)  # the edges' echoes, 40 dB fainter, add to it


def test_level_and_noise_count_alone():
    louder = index_of(replace(LOUD, level_spl_db=65.0), 1.5)
    assert louder - index_of(LOUD, 1.5) == pytest.approx(10.0, abs=1e-9)
    assert louder - index_of(replace(LOUD, level_spl_db=65.0, noise_spl_db=37.0), 1.5) == pytest.approx(7.0, abs=1e-9)


def test_without_range_or_noise_it_is_not_known_and_without_an_echo_it_is_low():
    assert np.isnan(index_of(LOUD, 3.0))
    assert np.isnan(index_of(replace(LOUD, noise_spl_db=-np.inf), 1.5))
    assert NO_ECHO_DB < -90.0
