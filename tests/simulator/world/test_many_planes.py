"""Scenes of thousands of plane faces, as scans have them: memory grows with their number, not with its square."""

import tracemalloc

import numpy as np
import trimesh

from simulator import Fidelity, Material, Obstacle, Phone, Pose, PreparedScene, Scene, held_rotation, trace_paths

PHONE, POSE = Phone.named("ideal"), Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))


def _loose(count: int) -> PreparedScene:
    """So many triangles of some centimetres about a room of 30 m3, none of which touches another by intent."""
    draw = np.random.default_rng(5)
    middle = draw.uniform([1.5, -1.5, 0.1], [4.5, 1.5, 3.0], (count, 3))
    corner = (middle[:, None] + draw.normal(0.0, 0.05, (count, 3, 3))).reshape(-1, 3)
    mesh = trimesh.Trimesh(corner, np.arange(3 * count).reshape(-1, 3), process=False)
    return PreparedScene(Scene([Obstacle(mesh, Material.named("concrete"), "leaves")]))


def _peak_mb(scene: PreparedScene, fidelity: Fidelity) -> float:
    tracemalloc.start()
    try:
        trace_paths(scene, PHONE, POSE, fidelity)
        return tracemalloc.get_traced_memory()[1] / 1e6
    finally:
        tracemalloc.stop()


def test_preparation() -> None:
    """All corners were held against all planes at once, and all planes against each other: 920 MB of 3000 triangles."""
    fidelity = Fidelity(max_order=1, mechanisms=("specular",))
    _peak_mb(_loose(30), fidelity)  # compiles
    assert _peak_mb(_loose(3000), fidelity) < 60.0
