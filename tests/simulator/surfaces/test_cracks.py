"""A face with a hairline crack echoes as the whole face, wherever the crack runs."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.array([18e3, 20e3, 22e3])
RIM_DB = 0.06  # of the far rim, 46 dB below the echo, halves may fall under `edge_floor_db`
AHEAD = held_rotation(0.0)


def _pane(low_m: float, high_m: float, name: str, x_m: float = 1.5) -> Obstacle:
    """A sheet across +x between y = low and high."""
    corners = np.array([[x_m, low_m, -4], [x_m, high_m, -4], [x_m, high_m, 4], [x_m, low_m, 4]])
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False), Material.rigid(), name)


def _in_one_mesh(*parts: Obstacle) -> list[Obstacle]:
    return [Obstacle(trimesh.util.concatenate([part.mesh for part in parts]), Material.rigid(), "wall")]


def _cracked(width_m: float, seam_m: float = 0.0) -> tuple[Obstacle, Obstacle]:
    return _pane(-4.0, seam_m - 0.5 * width_m, "left"), _pane(seam_m + 0.5 * width_m, 4.0, "right")


def _paths(obstacles: list[Obstacle], phone: Phone, level: str, shift_m=(0.0, 0.0, 0.0), yaw_rad: float = 0.0):
    turn = Rotation.from_euler("z", yaw_rad)
    moved = [Obstacle(trimesh.Trimesh(turn.apply(o.mesh.vertices) + shift_m, o.mesh.faces, process=False),
                      o.material, o.name) for o in obstacles]  # fmt: skip
    scene = Scene(moved, Air.lossless(343.0))
    paths = trace_paths(scene, phone, Pose(np.array(shift_m), turn * AHEAD), Fidelity(level, max_range_m=8.0))
    return paths[paths.order > 0]


def _level_db(paths) -> np.ndarray:
    return 20.0 * np.log10(np.abs(paths.transfer_function(FREQUENCY_HZ)))


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize("seam_m", [0.0, 0.0004])
@pytest.mark.parametrize("width_m", [1e-12, 1e-9, 3e-9, 1e-7, 1e-5, 1e-3, 1.9e-3])
def test_a_crack_at_the_mirror_point_takes_nothing_off_the_echo(phone, width_m, seam_m, level):
    """A mirror point in a crack of 3 nm to 2 mm lies in neither part, and their borders count as touching, so that no
    edge wave filled the gap: of the wall's echo its far rim was left, 33 dB down."""
    whole = _level_db(_paths([_pane(-4.0, 4.0, "wall")], phone, level))
    parts = _cracked(width_m, seam_m)
    for obstacles in (_in_one_mesh(*parts), list(parts)):
        np.testing.assert_allclose(_level_db(_paths(obstacles, phone, level)), whole, atol=RIM_DB)


def test_far_from_the_origin_and_rotated(phone):
    whole = _level_db(_paths([_pane(-4.0, 4.0, "wall")], phone, "standard"))
    cracked = _paths(_in_one_mesh(*_cracked(1e-4)), phone, "standard", (1e4, -2e4, 30.0), 0.3)
    np.testing.assert_allclose(_level_db(cracked), whole, atol=RIM_DB)


def test_nothing_is_heard_through_a_crack(phone):
    """The second wall would add 9 dB less than the first."""
    front, behind = _cracked(1e-3), _pane(-4.0, 4.0, "behind", 2.5)
    assert "behind" not in set(_paths([*front, behind], phone, "standard").obstacle)


def test_an_open_crack_is_left_to_its_edges(phone):
    """Wider than an eighth of the wavelength: half the echo from either edge, 0.3 dB less in all."""
    whole = _level_db(_paths([_pane(-4.0, 4.0, "wall")], phone, "standard"))
    found = _paths(list(_cracked(2.1e-3)), phone, "standard")
    assert "specular" not in set(found.kind)
    np.testing.assert_allclose(_level_db(found) - whole, -0.27, atol=0.05)


def test_what_moves_apart_is_not_joined(phone):
    """A leaf of a sliding door makes no strip with the wall, which would stay behind."""
    left, right = _cracked(1e-3)
    leaf = Obstacle(right.mesh, right.material, "leaf", velocity_m_s=np.array([0.0, 0.5, 0.0]))
    scene = Scene([left, leaf], Air.lossless(343.0))
    paths = trace_paths(scene, phone, Pose(np.zeros(3), AHEAD), Fidelity(mechanisms=("specular",), max_order=1))
    assert len(paths[paths.order > 0]) == 0
