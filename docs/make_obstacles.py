"""Draw docs/obstacles.png, every kind of obstacle there is: `python docs/make_obstacles.py`, from the root."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from matplotlib.figure import Figure
from numpy.typing import NDArray
from trimesh.ray.ray_pyembree import RayMeshIntersector

from scenes import obstacles
from scenes.preview.pictures import COLORS

Array = NDArray[np.float64]

KINDS: dict[str, tuple[str, trimesh.Trimesh]] = {
    "wall": ("wall", obstacles.wall(5.0)),
    "wall with piers": ("wall", obstacles.wall_with_piers(7.0)),
    "shop front": ("wall", obstacles.shop_front()),
    "A-frame": ("sign", obstacles.a_frame()),
    "round sign": ("sign", obstacles.pole_sign()),
    "square sign": ("sign", obstacles.pole_sign(shape="square")),
    "octagon sign": ("sign", obstacles.pole_sign(shape="octagon")),
    "board on posts": ("sign", obstacles.board_on_posts()),
    "litter bin": ("dustbin", obstacles.litter_bin(taper=0.15, dome_m=0.12)),
    "wheeled bin": ("dustbin", obstacles.wheeled_bin()),
    "dumpster": ("dustbin", obstacles.dumpster()),
    "donation box": ("dustbin", obstacles.donation_box()),
    "sedan": ("car", obstacles.car("sedan")),
    "SUV": ("car", obstacles.car("suv")),
    "van": ("car", obstacles.car("van")),
    "man, standing": ("pedestrian", obstacles.pedestrian(1.78, "male", "average", "stand")),
    "woman, reading": ("pedestrian", obstacles.pedestrian(1.64, "female", "slim", "read")),
    "woman, walking": ("pedestrian", obstacles.pedestrian(1.68, "female", "average", "walk-0")),
    "heavy man, walking": ("pedestrian", obstacles.pedestrian(1.75, "male", "heavy", "walk-15")),
    "slim man, walking": ("pedestrian", obstacles.pedestrian(1.85, "male", "slim", "walk-30")),
    "lofted person": ("pedestrian", obstacles.person(1.75)),
    "tree": ("clutter", obstacles.tree()),
    "bench": ("clutter", obstacles.bench()),
    "bollard": ("clutter", obstacles.bollard()),
    "hydrant": ("clutter", obstacles.hydrant()),
    "planting tub": ("clutter", obstacles.tub()),
    "lamp post": ("clutter", obstacles.lamp_post()),
    "hedge (leaves)": ("clutter", obstacles.hedge()),
    "fence": ("clutter", obstacles.fence(5.0)),
    "kerb": ("clutter", obstacles.kerb(2.0)),
}
COLUMNS, PIXELS = 6, 260
AZIMUTH, ELEVATION = np.deg2rad(-145.0), np.deg2rad(16.0)
LAMP = np.array([-0.55, -0.45, 0.70])
GLASS, TYRE = np.array([0.55, 0.68, 0.76]), np.array([0.25, 0.25, 0.27])
PAPER, FLOOR = np.array([1.0, 1.0, 1.0]), np.array([0.91, 0.90, 0.87])


def main() -> None:
    """One cell a kind, each scaled to its cell, with its height or length below."""
    rows = -(-len(KINDS) // COLUMNS)
    figure = Figure(figsize=(2.1 * COLUMNS, 2.45 * rows), layout="constrained")
    for number, (name, (category, mesh)) in enumerate(KINDS.items(), start=1):
        axes = figure.add_subplot(rows, COLUMNS, number)
        axes.imshow(picture(mesh, painted(mesh, name, COLORS[category])), interpolation="antialiased")
        axes.set_title(f"{name}\n{mesh.extents[2]:.2f} m high, {len(mesh.faces)} triangles", fontsize=8)
        axes.set_axis_off()
    figure.savefig(Path(__file__).with_name("obstacles.png"), dpi=100)


def painted(mesh: trimesh.Trimesh, name: str, color: str) -> Array:
    """(T, 3) colours of the faces: the category's, but glass, tyres and number plates as they are."""
    base = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    paint = np.tile(0.35 + 0.65 * base, (len(mesh.faces), 1))
    middle = mesh.triangles_center
    if name == "shop front":
        paint[(middle[:, 0] > -0.06) & (np.abs(mesh.face_normals[:, 0]) > 0.9)] = GLASS
    if name in ("sedan", "SUV", "van"):
        part = trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
        for label in np.unique(part):
            rows = np.flatnonzero(part == label)
            low, high = (
                mesh.triangles[rows].reshape(-1, 3).min(axis=0),
                mesh.triangles[rows].reshape(-1, 3).max(axis=0),
            )
            if low[2] < 0.01:
                paint[rows] = TYRE
            elif high[0] - low[0] < 0.06:
                paint[rows] = PAPER
            elif high[2] == mesh.bounds[1, 2]:
                paint[rows[middle[rows, 2] < high[2] - 0.12]] = GLASS
    return paint


def picture(mesh: trimesh.Trimesh, paint: Array) -> Array:
    """(PIXELS, PIXELS, 3) parallel projection on a floor, lit from the front left above, with its shadow."""
    away, right, up = _camera()
    center, half = mesh.bounds.mean(axis=0), 0.56 * float(np.linalg.norm(mesh.extents))
    step = np.linspace(-half, half, PIXELS)
    across, rise = np.meshgrid(step, -step)
    origin = center + across.reshape(-1, 1) * right + rise.reshape(-1, 1) * up + 50.0 * away
    ray = RayMeshIntersector(mesh, scale_to_box=False)
    face = ray.intersects_first(origin, np.broadcast_to(-away, origin.shape))
    on_floor = origin - away * (origin[:, 2] / away[2])[:, None]
    shadow = ray.intersects_any(on_floor + [0.0, 0.0, 1e-3], np.broadcast_to(LAMP, origin.shape))
    near = np.hypot(*(on_floor - center)[:, :2].T) < 1.5 * half
    floor = np.where(near[:, None], FLOOR, PAPER) * np.where(shadow, 0.72, 1.0)[:, None]
    normal = mesh.face_normals[face]
    normal = np.where((normal @ away < 0.0)[:, None], -normal, normal)  # leaves have two sides
    light = 0.42 + 0.62 * np.clip(normal @ (LAMP / np.linalg.norm(LAMP)), 0.0, 1.0)
    lit = np.clip(paint[face] * light[:, None], 0.0, 1.0)
    return np.where((face >= 0)[:, None], lit, floor).reshape(PIXELS, PIXELS, 3)


def _camera() -> tuple[Array, Array, Array]:
    """Unit vectors towards the viewer, to the right and up in the picture."""
    cos, sin = np.cos(ELEVATION), np.sin(ELEVATION)
    away = np.array([cos * np.cos(AZIMUTH), cos * np.sin(AZIMUTH), sin])
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    return away, right, np.cross(away, right)


if __name__ == "__main__":
    main()
