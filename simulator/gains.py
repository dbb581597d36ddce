"""What a path loses on its way: spreading, air, surfaces, directivity."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.air import Air
from simulator.candidates import Candidates
from simulator.phone import Phone
from simulator.pose import Pose
from simulator.spreading import spreading
from simulator.world import World

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def path_gain(world: World, phone: Phone, pose: Pose, air: Air, found: Candidates, frequency_hz: Floats) -> Complexes:
    """(C, K) complex gain of each path at K frequencies, without its travel phase."""
    amplitude = spreading(found.points_m, found.normal, found.curvature, found.order)
    absorption_db = air.absorption_db_m(frequency_hz) * found.length_m[:, None]
    gain = amplitude[:, None] * 10.0 ** (-absorption_db / 20.0)
    return gain * surface_reflection(world, found, frequency_hz) * directivity(phone, pose, found)[:, None]


def surface_reflection(world: World, found: Candidates, frequency_hz: Floats) -> Complexes:
    """(C, K) product of the reflection factors of the materials met."""
    owner = np.concatenate([world.patches.obstacle, [s.obstacle for s in world.surfaces]]).astype(np.int64)
    product = np.ones((len(found), len(frequency_hz)), dtype=np.complex128)
    for k in range(found.sequence.shape[1]):
        met = np.where(found.sequence[:, k] >= 0, owner[found.sequence[:, k]] if len(owner) else -1, -1)
        arriving = found.points_m[:, k + 1] - found.points_m[:, k]
        cosine = np.abs(np.sum(arriving * found.normal[:, k], axis=1)) / np.maximum(
            np.linalg.norm(arriving, axis=1), 1e-300
        )
        for index in np.unique(met[met >= 0]):
            rows = np.flatnonzero(met == index)
            product[rows] *= world.obstacles[index].material.reflection(frequency_hz, cosine[rows, None])
    return product


def directivity(phone: Phone, pose: Pose, found: Candidates) -> Floats:
    """(C,) speaker's factor towards the first point times the microphone's towards the last."""
    leaving = found.points_m[:, 1] - found.points_m[:, 0]
    every = np.arange(len(found))
    arriving = found.points_m[every, found.order] - found.points_m[every, found.order + 1]
    matrices = np.broadcast_to(pose.rotation.as_matrix().reshape(-1, 3, 3), (len(pose), 3, 3))[found.pose]
    factor = phone.speaker.directivity(_in_phone(matrices, leaving))
    for mic, transducer in enumerate(phone.mics):
        rows = np.flatnonzero((found.mic == mic) & (found.order > 0))
        factor[rows] *= transducer.directivity(_in_phone(matrices[rows], arriving[rows]))
    return np.where(found.order > 0, factor, 1.0)  # direct sound runs along the case: its level is the response table's


def _in_phone(matrices: Floats, vector: Floats) -> Floats:
    unit = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    return np.einsum("pji,pj->pi", matrices, unit)
