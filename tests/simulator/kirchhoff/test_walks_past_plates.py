"""A sign behind its post, walked past: the shadow moves fast across the plate, and differs between transducers.

At `standard` the light on it was kept over 0.2 of the distance for all transducers, so that one echo in fifteen of this
walk was off by more than 2 dB. And facets of 8 cm did not see where the shadow ends: past the post, square-on, an echo
of -6 dB was off by 1 to 3 dB, and changed with the direction in which the scene lay.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.cells.probes.compressed_echoes import compressed, of_target, peak_levels_db
from benchmarks.cells.probes.echo_errors import AUDIBLE_DB
from scenes import make_approach
from scenes.obstacles.sign import pole_sign
from simulator import Fidelity, Material, Obstacle, Phone, Pose, PreparedScene, Scene, held_rotation, trace_paths


def test_a_walk_past_a_sign_has_the_echoes_of_each_pose():
    approach = make_approach("supermarket", "sign", 96, "galaxy-s5", 1659223589)
    time_s, scene = 0.09 * np.arange(20, 30), PreparedScene(approach.scene)

    def levels_db(at_s):
        paths = trace_paths(scene, approach.phone, approach.walk.pose(at_s), Fidelity(level="standard"), at_s)
        return np.array(peak_levels_db(compressed(paths, of_target(paths, approach.target))))

    together, alone = levels_db(time_s), np.concatenate([levels_db(time_s[[n]]) for n in range(len(time_s))])
    off = np.abs(together - alone)[alone > AUDIBLE_DB]
    assert len(off) >= 12
    assert np.mean(off > 0.5) < 0.1


@pytest.mark.parametrize("away_m", [0.6, 1.2, 2.0])
def test_a_plate_behind_its_post_echoes_alike_wherever_north_is(away_m):
    phone = Phone.ideal([0.0, 0.07, 0.0], [[0.0, 0.07, 0.005], [0.0, -0.07, 0.0]])

    def levels_db(north_rad, level):
        north, sign = Rotation.from_euler("z", north_rad), pole_sign(0.5, 1.25, "square")
        sign.vertices = Rotation.from_euler("z", north_rad + np.pi).apply(sign.vertices)  # its post towards the phone
        scene = Scene([Obstacle(sign, Material.rigid(), "sign")])
        pose = Pose(north.apply([-away_m, 0.1, 1.3]), held_rotation(north_rad, 0.5))
        paths = trace_paths(scene, phone, pose, Fidelity(level=level))
        return np.array(peak_levels_db(compressed(paths, paths.order > 0)))

    found = [levels_db(north_rad, "standard") for north_rad in (0.0, 1.03, 2.06)]
    assert np.ptp(found, axis=0).max() < 0.2
    assert np.abs(found - levels_db(0.0, "reference")).max() < 0.3
