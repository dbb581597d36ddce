"""Obstacles that move alike, as the parts of a van do, stand together as obstacles at rest do.

Whatever had a velocity was taken to move against all other obstacles. So a face that leaned on another part had no
crease with it (-16 dB re 1 m), and a mirror point within a slit between two parts returned nothing (-9 dB).
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 11)
VELOCITY_M_S = np.array([-1.5, 0.5, 0.0])
TIME_S = 0.8
PLACE = Pose([0.0, 0.0, 1.0], held_rotation(0.0, pitch_rad=0.4))


def _leaning() -> dict[str, trimesh.Trimesh]:
    """A deck and a board on it that leans back by two degrees."""
    board = trimesh.creation.box(bounds=[[1.5, -0.5, 0.0], [1.54, 0.5, 1.2]])
    board.vertices[:, 0] += np.tan(np.deg2rad(2.0)) * board.vertices[:, 2]
    return {"deck": trimesh.creation.box(bounds=[[-1.0, -2.0, -0.1], [3.0, 2.0, 0.0]]), "board": board}


def _side_and_window() -> dict[str, trimesh.Trimesh]:
    """Two panes in one plane with a slit of 1 mm, in which the mirror points are."""
    side = trimesh.creation.box(bounds=[[1.5, -2.0, 0.0], [1.6, -0.0005, 2.0]])
    return {"side": side, "window": trimesh.creation.box(bounds=[[1.5, 0.0005, 0.0], [1.6, 2.0, 2.0]])}


def _echo(bodies: dict[str, trimesh.Trimesh], velocity_m_s: np.ndarray) -> np.ndarray:
    """(2, F) what comes back once the bodies are where they are given."""
    obstacles = [
        Obstacle(mesh.copy().apply_translation(-TIME_S * velocity_m_s), Material.rigid(), name, "flat", velocity_m_s)
        for name, mesh in bodies.items()
    ]
    phone = Phone.ideal([0.0, 0.03, 0.0], [[0.0, 0.08, 0.0], [0.0, -0.03, 0.0]])
    paths = trace_paths(Scene(obstacles, Air.lossless(343.0)), phone, PLACE, Fidelity(), TIME_S)
    return paths[paths.order > 0].transfer_function(FREQUENCY_HZ)


@pytest.mark.parametrize("bodies", [_leaning(), _side_and_window()], ids=["crease", "crack"])
def test_parts_of_a_van_echo_as_they_do_at_rest(bodies: dict[str, trimesh.Trimesh]) -> None:
    still, driven = _echo(bodies, np.zeros(3)), _echo(bodies, VELOCITY_M_S)
    np.testing.assert_allclose(driven, still, rtol=0.0, atol=1e-7 * np.abs(still).max())


def test_what_moves_apart_stays_apart() -> None:
    """A window that slides along the side makes no strip with it."""
    side, window = (Obstacle(mesh, Material.rigid(), name) for name, mesh in _side_and_window().items())
    sliding = Obstacle(window.mesh, window.material, "window", velocity_m_s=[0.0, 0.5, 0.0])
    driven = Obstacle(side.mesh, side.material, "side", velocity_m_s=[0.0, -0.5, 0.0])
    only = Fidelity(mechanisms=("specular",), max_order=1)
    paths = trace_paths(Scene([driven, sliding]), Phone.named("ideal"), PLACE, only)
    assert not (paths.order > 0).any()
