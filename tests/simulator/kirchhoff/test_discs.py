"""Discs and drums in the open against full-wave values, stored by tests/references/make_disc_values.

Cause: rays knew of the rims of smooth sides, not of those of the faces that end there. Where the mirror point lay
beside the face, as it does before a round sign that is not square-on, `standard` and `auto` had no echo at all.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
from tests.references import make_disc_values as reference
from tests.references.fullwave import correlation_peak, damped
from tests.references.make_revolved_values import DAMPING_1_S, MICS_M, SPEED_M_S

REACH_S = 2.4e-3  # the stored frequencies repeat after 5 ms
LOUD_DB = -30.0  # re the loudest echo of the body at the same distance
LIMITS = {"standard": (0.55, 1.8), "auto": (0.25, 0.4), "reference": (0.25, 0.4)}  # dB, samples
# of the disc, which is a thin plate: edge-on, 27 dB down, waves run along its faces
THIN_LIMITS = {"standard": (1.3, 2.0), "auto": (0.9, 0.8), "reference": (0.9, 0.8)}


@cache
def stored() -> dict:
    with np.load(reference.STORED) as arrays:
        return dict(arrays)


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
@pytest.mark.parametrize("name", list(reference.RADIUS_AND_LENGTH_M))
def test_echoes_have_the_level_and_delay_of_full_wave_values(name: str, level: str) -> None:
    values, source = stored(), reference.speakers()
    row, frequency = list(values["name"]).index(name), values["frequency_hz"]
    radius, length = reference.RADIUS_AND_LENGTH_M[name]
    body = Obstacle(trimesh.creation.cylinder(radius, length, sections=64), Material.rigid(), "body")
    scene, phone = Scene([body], Air.lossless(SPEED_M_S)), Phone.ideal([0.0, 0.0, 0.0], MICS_M)
    paths = trace_paths(scene, phone, Pose(source, Rotation.identity(len(source))), Fidelity(level=level))
    mine = paths[np.array(["body" in met for met in paths.obstacles_met()])]
    ours, exact = np.empty((2, len(source), 2, 2))
    for n, mic in np.ndindex(len(source), 2):
        about_s = 2.0 * (np.linalg.norm(source[n]) - 0.1) / SPEED_M_S
        echo = damped(mine[(mine.pose == n) & (mine.mic == mic)], frequency, DAMPING_1_S)
        ours[n, mic] = correlation_peak(echo, frequency, about_s, REACH_S)
        exact[n, mic] = correlation_peak(values["transfer"][row, n, mic], frequency, about_s, REACH_S)
    level_db, samples = (THIN_LIMITS if name == "disc" else LIMITS)[level]
    for near in (slice(0, 8), slice(8, 16)):
        loud = exact[near, :, 0] > exact[near, :, 0].max() + LOUD_DB
        assert loud.sum() >= 6
        error = np.abs(ours - exact)[near][loud]
        assert error[:, 0].max() < level_db
        assert error[:, 1].max() * 192e3 < samples


@pytest.mark.slow
@pytest.mark.parametrize("name", list(reference.RADIUS_AND_LENGTH_M))
def test_stored_values_are_what_is_made_today(name: str) -> None:
    values, some = stored(), [4, 19]
    made = reference.echoes(name, values["frequency_hz"][some])
    kept = values["transfer"][list(values["name"]).index(name)][..., some]
    np.testing.assert_allclose(made, kept, atol=1e-5 * np.abs(kept).max())
