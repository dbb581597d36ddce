"""The simulator's echoes in the form in which references come: transfer functions at `chirp.nodes_hz`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Paths, Phone, Pose, Scene, trace_paths
from tests.references import chirp

SPEED_M_S = 343.0
CURVED = Fidelity(max_order=1, max_range_m=7.5, mechanisms=("curved",))


def echoes(mesh: trimesh.Trimesh, speaker_m: NDArray, mics_m: NDArray, fidelity: Fidelity = CURVED) -> list[Paths]:
    """Echoes (order 1) of one rigid body, for each of P speakers (P, 3) with their microphones (P, 2, 3)."""
    scene = Scene([Obstacle(mesh, Material.rigid(), "body")], Air.lossless(SPEED_M_S))
    pose = Pose([0.0, 0.0, 0.0], Rotation.identity())
    phones = [Phone.ideal(s, m) for s, m in zip(speaker_m, mics_m, strict=True)]
    every = [trace_paths(scene, phone, pose, fidelity) for phone in phones]
    return [paths[paths.order > 0] for paths in every]


def differences(found: Sequence[Paths], reference: NDArray[np.complex128]) -> list[chirp.Difference]:
    """Each of 2 P echoes against its (P, 2, NODES) reference.

    Raises:
        AssertionError: a microphone without exactly one echo.
    """
    out = []
    for paths, exact in zip(found, reference, strict=True):
        np.testing.assert_array_equal(np.sort(paths.mic), [0, 1], err_msg="one echo at each microphone")
        ours = paths.transfer_function(chirp.nodes_hz())
        delay = paths.delay_s[np.argsort(paths.mic)]
        out += [chirp.difference(ours[m], exact[m], delay[m]) for m in range(2)]
    return out


def worst(found: Sequence[chirp.Difference]) -> chirp.Difference:
    """Largest level and delay error of either sign, least correlation."""
    return chirp.Difference(
        max(abs(each.level_db) for each in found),
        max(abs(each.delay_samples) for each in found),
        min(each.correlation for each in found),
    )
