"""What a phone receives of one body on the ground."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.linspace(18e3, 23e3, 11)
PLACE = Pose([0.0, 0.0, 1.3], held_rotation(0.05, pitch_rad=0.5))


def echo_on_ground(mesh: trimesh.Trimesh, place: Pose = PLACE) -> NDArray[np.complex128]:
    """(2, F) what both microphones receive of a body on the ground."""
    ground = trimesh.creation.box(bounds=[[-10.0, -10.0, -1.0], [10.0, 10.0, 0.0]])
    bodies = [Obstacle(ground, Material.rigid(), "ground"), Obstacle(mesh, Material.rigid(), "body")]
    paths = trace_paths(Scene(bodies), Phone.named("galaxy-s8-plus"), place, Fidelity())
    paths = paths[np.array(["body" in met for met in paths.obstacles_met()])]
    field = paths.gain_at(FREQUENCY_HZ) * np.exp(-2j * np.pi * FREQUENCY_HZ * paths.delay_s[:, None])
    return np.stack([field[paths.mic == mic].sum(axis=0) for mic in range(2)])
