"""Scenes of thousands of plane faces, as scans have them: memory grows with their number, not with its square."""

import tracemalloc

import numpy as np
import pytest
import trimesh

import simulator.diffraction.edge_pairs
import simulator.diffraction.single
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


def _shelf(rows: int) -> PreparedScene:
    """A shelf of as many rows of as many boxes, on the ground."""
    boxes = [
        trimesh.creation.box(bounds=[[2.0 + 0.1 * (k % 3), y, z], [2.3, y + 0.3, z + 0.2]])
        for k, (y, z) in enumerate((0.35 * i - 1.0, 0.02 + 0.22 * j) for i in range(rows) for j in range(rows))
    ]
    ground = trimesh.Trimesh([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    goods = Obstacle(trimesh.util.concatenate(boxes), Material.named("concrete"), "goods")
    return PreparedScene(Scene([Obstacle(ground, Material.named("concrete"), "ground"), goods]))


def test_edges_of_many_boxes() -> None:
    """All pairs of images over all edges were unfolded at once: 750 MB of 64 boxes."""
    fidelity = Fidelity(mechanisms=("specular", "edges"))
    _peak_mb(_shelf(1), fidelity)  # compiles
    assert _peak_mb(_shelf(8), fidelity) < 400.0


def test_edges_a_block_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks bound memory; the paths are those that were found at once."""
    scene, fidelity = _shelf(2), Fidelity(mechanisms=("specular", "edges"))
    at_once = trace_paths(scene, PHONE, POSE, fidelity)
    for stage in simulator.diffraction.edge_pairs, simulator.diffraction.single:
        monkeypatch.setattr(stage, "AT_ONCE", 500)
    in_blocks = trace_paths(scene, PHONE, POSE, fidelity)
    hz = np.linspace(18e3, 23e3, 21)
    together = np.abs(at_once.transfer_function(hz))
    assert len(in_blocks) == len(at_once)
    np.testing.assert_allclose(
        in_blocks.transfer_function(hz), at_once.transfer_function(hz), atol=1e-12 * together.max()
    )
