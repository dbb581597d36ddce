"""A round body cut in two obstacles, one on the other, echoes as the whole does.

Cause: a cap that ends with the body counted as a floor, whose image would continue it: rays were taken for right just
below the cut, and the echo was up to 5 dB off at every level.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

HZ = np.linspace(18e3, 23e3, 41)
PHONE = Phone.ideal(np.zeros(3), [[0.02, 0.0, 0.0], [0.0, -0.02, 0.0]])
GROUND = trimesh.creation.box(bounds=[[-12.0, -12.0, -1.0], [12.0, 12.0, 0.0]])


def _level_db(radius_m, cuts_m, height_m, level):
    """(2,) level over the band of a post's echoes, but for those by the ground, to a phone 1.5 m before its axis."""
    scene = [Obstacle(GROUND, Material.rigid(), "ground")]
    for low, high in pairwise(cuts_m):
        part = trimesh.creation.cylinder(radius_m, high - low, sections=48)
        part.apply_translation([1.5, 0.1, 0.5 * (low + high)])
        scene.append(Obstacle(part, Material.rigid(), f"from {low} m"))
    pose = Pose([0.0, 0.0, height_m], held_rotation(0.0))
    paths = trace_paths(Scene(scene, Air.lossless(343.0)), PHONE, pose, Fidelity(level=level))
    paths = paths[np.array([bool(met) and set(met) != {"ground"} for met in paths.obstacles_met()])]
    paths = paths[343.0 * paths.delay_s < 3.4]
    echo = paths.gain_at(HZ) * np.exp(-2j * np.pi * HZ * paths.delay_s[:, None])
    return np.array([10.0 * np.log10((np.abs(echo[paths.mic == m].sum(axis=0)) ** 2).mean()) for m in (0, 1)])


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
@pytest.mark.parametrize(
    ("radius_m", "cut_m", "top_m", "phone_m"),
    [(0.1, 1.2, 1.8, 1.3), (0.1, 1.29, 1.8, 1.3), (0.1, 1.31, 1.8, 1.3), (0.1, 1.4, 1.8, 1.3), (0.25, 1.0, 1.05, 1.0)],
)
def test_a_body_in_two_pieces_echoes_as_one(level, radius_m, cut_m, top_m, phone_m):
    cut = _level_db(radius_m, (0.0, cut_m, top_m), phone_m, level)
    assert cut == pytest.approx(_level_db(radius_m, (0.0, top_m), phone_m, level), abs=0.4)
