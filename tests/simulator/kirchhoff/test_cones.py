"""A cone on whose axis the phone is: all of its rim is at one distance, and the wedge's integral over it is closed.

Cause: of several rims only the one nearest to the phone was asked whether it echoes, and that as if the echo came from
about a single point. Every level but `reference` left it out, 12 dB under a wall's.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
from tests.references.fullwave import correlation_peak

C = 343.0
FREQUENCY_HZ = np.linspace(17_500.0, 23_500.0, 121)
RADIUS_M, HEIGHT_M, AWAY_M, MIC_M = 0.3, 0.6, 2.0, 0.05  # phone over the base, microphone over the speaker


def _rim() -> np.ndarray:
    """(F,) Svensson's integral over the rim, where source and receiver are at one height along every part of it."""
    nu = np.pi / (2.0 * np.pi - np.arctan2(HEIGHT_M, RADIUS_M))
    rise = np.array([AWAY_M, AWAY_M + MIC_M])
    s, r = np.arctan2(HEIGHT_M, -RADIUS_M) - np.arctan2(rise, -RADIUS_M)
    beta = sum(1.0 / np.tan(0.5 * nu * angle) for angle in (np.pi + s + r, np.pi + s - r, np.pi - s + r, np.pi - s - r))
    l, m = np.hypot(RADIUS_M, rise)
    wave = np.exp(-2j * np.pi * FREQUENCY_HZ / C * (l + m)) / (l * m)
    return -nu / (4.0 * np.pi) * beta * wave * 2.0 * np.pi * RADIUS_M


@pytest.mark.parametrize(("level", "most_db"), [("standard", 0.4), ("auto", 0.2), ("reference", 0.1)])
def test_all_of_a_rim_is_received_on_its_axis(level, most_db):
    cone = trimesh.creation.cone(RADIUS_M, HEIGHT_M, sections=64)
    cone.apply_translation([0.0, 0.0, -AWAY_M])
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.0, MIC_M], [0.0, 0.06, 0.0]])
    scene, pose = Scene([Obstacle(cone, Material.rigid(), "cone")], Air.lossless(C)), Rotation.identity()
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], pose), Fidelity(level=level))
    delay_s = (np.hypot(RADIUS_M, AWAY_M) + np.hypot(RADIUS_M, AWAY_M + MIC_M)) / C
    transfer = paths[paths.order > 0].transfer_function(FREQUENCY_HZ)[0], _rim()
    got, exact = (correlation_peak(each, FREQUENCY_HZ, delay_s)[0] for each in transfer)
    assert abs(got - exact) < most_db, (got, exact)
