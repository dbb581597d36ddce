"""Pictures of scenes, approaches and obstacles, to judge by eye what the numbers are about."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.whole_file import whole_file
from scenes.truth.swept import Body
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle, Scene

COLORS = {
    "wall": "#a0522d",
    "dustbin": "#2e7d32",
    "car": "#1f5fa8",
    "sign": "#c62828",
    "pedestrian": "#8e44ad",
    "clutter": "#8d8d3d",
}
OTHER = "#777777"
LONG_M = 3.0
"""What is longer has its name in its middle."""
LIGHT = np.array([-0.5, -0.6, 0.75]) / np.linalg.norm([-0.5, -0.6, 0.75])


def preview_scene(
    scene: Scene,
    path: str | Path,
    walk: Walk | None = None,
    target: str | None = None,
    window_m: tuple[float, float, float, float] | None = None,
) -> Path:
    """Top view of a scene as a PNG, with the walked path, the swept body and the target if given.

    Args:
        scene: its obstacles are drawn where they are at time 0, with an arrow of one second of motion.
        path: file to write.
        walk: path to draw.
        target: name of the obstacle to frame.
        window_m: (x low, x high, y low, y high); None fits the obstacles other than the ground.

    Returns:
        The path.
    """
    figure = Figure(figsize=(10, 6.5), layout="constrained")
    axes = figure.add_subplot()
    axes.set_facecolor("#f1efe9")
    for obstacle in scene.obstacles:
        if obstacle.category != "ground":
            _draw_plan(axes, obstacle, framed=obstacle.name == target)
    if walk is not None:
        _draw_walk(axes, walk)
        axes.legend(loc="upper left", fontsize=9)
    left, right, bottom, top = _window(scene, walk) if window_m is None else window_m
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x (m)", ylabel="y (m)", title=scene.name)
    axes.grid(color="white", linewidth=0.8)
    axes.set_axisbelow(True)
    with whole_file(Path(path)) as partial:
        figure.savefig(partial, format="png", dpi=110, metadata={"Software": None})
    return Path(path)


def preview_around(scene: Scene, walk: Walk, target: str, path: str | Path) -> Path:
    """Top view of a walk as a PNG, its window 3 m around the walk and the middle of the target."""
    place = walk.pose(np.linspace(0.0, walk.duration_s, 50)).position_m[:, :2]
    middle = scene.obstacle(target).mesh.bounds[:, :2].mean(axis=0)[None]
    (left, bottom), (right, top) = (f(np.concatenate([place, middle]), axis=0) for f in (np.min, np.max))
    return preview_scene(scene, path, walk, target, (left - 3.0, right + 3.0, bottom - 3.0, top + 3.0))


def _draw_plan(axes: Axes, obstacle: Obstacle, framed: bool) -> None:
    """All triangles from above, highest last, lighter the higher they face up."""
    mesh, color = obstacle.mesh, COLORS.get(obstacle.category, OTHER)
    upward = np.flatnonzero(mesh.face_normals[:, 2] > 1e-6)
    order = upward[np.argsort(mesh.triangles_center[upward, 2])]
    outlines = list(mesh.triangles[order][:, :, :2])
    shades = _shaded(mesh.face_normals[order], color)
    axes.add_collection(PolyCollection(outlines, facecolors=shades, edgecolors="face"))
    center = mesh.bounds[:, :2].mean(axis=0)
    if obstacle.moves:
        axes.annotate(
            "",
            center + obstacle.velocity_m_s[:2],
            center,
            arrowprops={"arrowstyle": "->", "color": color, "lw": 1.6},
            annotation_clip=True,
        )
    (x, y), (right, top) = mesh.bounds[:, :2]
    if framed:
        axes.plot(
            [x, right, right, x, x],
            [y, y, top, top, y],
            color="black",
            linewidth=1.2,
            linestyle="--",
            label="the target",
        )
    long = max(right - x, top - y) > LONG_M  # above what lies askew there is nothing
    place, above = (center, "center") if long else ((center[0], top), "bottom")
    axes.annotate(
        obstacle.name, place, (0, 0 if long else 3), textcoords="offset points", ha="center", va=above, fontsize=8,
        annotation_clip=True, bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0, "pad": 1.0},
    )  # fmt: skip


def _draw_walk(axes: Axes, walk: Walk) -> None:
    """The phone's path, the body swept along it, the body at the start and the end."""
    time = np.linspace(0.0, walk.duration_s, 200)
    pose = walk.pose(time)
    body, heading = Body(), pose.body_heading_rad()
    cores = shapely.linestrings(body.core(pose.position_m, heading))
    stadiums = [shapely.get_coordinates(stadium) for stadium in shapely.buffer(cores, body.half_width_m)]
    axes.add_collection(
        PolyCollection(stadiums, facecolors="#f5d76e", edgecolors="none", label="swept by the walker's body")
    )
    axes.add_collection(PolyCollection([stadiums[0], stadiums[-1]], facecolors="none", edgecolors="#7f6000"))
    axes.plot(*pose.position_m[:, :2].T, color="#7f6000", linewidth=1.4, label="path of the phone, from the dot on")
    axes.plot(*pose.position_m[0, :2], "o", color="#7f6000", markersize=4)


def _shaded(normals: Floats, color: str) -> Floats:
    """(F, 3) colours under a lamp from the front left above."""
    base = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    light = 0.45 + 0.55 * np.clip(normals @ LIGHT, 0.0, 1.0)
    return np.clip(base * light[:, None] * 1.25, 0.0, 1.0)


def _window(scene: Scene, walk: Walk | None) -> tuple[float, float, float, float]:
    corners = [obstacle.mesh.bounds[:, :2] for obstacle in scene.obstacles if obstacle.category != "ground"]
    if walk is not None:
        corners.append(walk.pose([0.0, walk.duration_s]).position_m[:, :2])
    points = np.concatenate(corners) if corners else np.array([[-5.0, -5.0], [5.0, 5.0]])
    (left, bottom), (right, top) = points.min(axis=0) - 1.0, points.max(axis=0) + 1.0
    return left, right, bottom, top
