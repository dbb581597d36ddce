"""A thin panel about the origin, seen from aside: the scene of the tests of edges that follow one another."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene

SPEED_M_S = 343.0
SECOND_MIC_M = np.array([0.0, 0.0, 0.11])  # above the first


def panel(width_m: float, height_m: float, material: Material | None = None) -> Obstacle:
    """Of no thickness, its normal along +x; rigid if nothing else is said."""
    y, z = 0.5 * width_m, 0.5 * height_m
    corners = [[0.0, -y, -z], [0.0, y, -z], [0.0, y, z], [0.0, -y, z]]
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]), material or Material.rigid(), "panel")


def towards(yaw_deg: float, distance_m: float = 1.5, height_m: float = 0.03) -> NDArray[np.float64]:
    """(3,) point from which a panel is seen turned by an angle."""
    yaw = np.deg2rad(yaw_deg)
    return np.array([distance_m * np.cos(yaw), -distance_m * np.sin(yaw), height_m])


def traced(
    obstacles: list[Obstacle], source_m: ArrayLike, receiver_m: ArrayLike, **fidelity: Any
) -> tuple[Scene, Phone, Pose, Fidelity]:
    """Arguments of `trace_paths` at the level `reference` without a floor, unless told otherwise."""
    phone = Phone.ideal(source_m, [receiver_m, np.asarray(receiver_m) + SECOND_MIC_M])
    pose = Pose([0.0, 0.0, 0.0], Rotation.identity())
    chosen = Fidelity(**{"level": "reference", "edge_floor_db": -np.inf, **fidelity})
    return Scene(obstacles, Air.lossless(SPEED_M_S)), phone, pose, chosen
