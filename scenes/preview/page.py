"""A scene as one HTML file to rotate and zoom in a browser: obstacles, walk, phone, and where its sound goes.

The file needs no network: meshes are packed into it, and a few hundred lines of WebGL of our own draw them.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Floats
from scenes.obstacles.solids import merged
from scenes.preview.pictures import COLORS, OTHER
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Pose, Walk
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import trace_paths

GROUND = "#cfd2d4"
KINDS = {"specular": "#0072b2", "curved": "#d55e00", "edge": "#009e73", "kirchhoff": "#56b4e9", "mixed": "#cc79a7"}
"""Colours by mechanism, distinct for the colour-blind as well (Okabe and Ito)."""

SMOOTH_COS = float(np.cos(np.deg2rad(35.0)))
PHONE_HALF_M = np.array([0.036, 0.072, 0.005])
INSTANTS = 6
DRAWN_PATHS = 40
LISTED_PATHS = 9
PATH_RADIUS_M = 0.012
PATH_RADIUS_M = 0.015


def preview_html(
    scene: Scene,
    path: str | Path,
    walk: Walk | None = None,
    phone: Phone | None = None,
    instants_s: Sequence[float] | None = None,
    fidelity: Fidelity | None = None,
) -> Path:
    """Write a scene as an HTML file that shows it in three dimensions.

    Args:
        scene: obstacles, coloured by category; those that move do so with the slider of instants.
        path: file to write.
        walk: path of the phone to draw.
        phone: whose echoes are traced and drawn; needs a walk, None draws no sound.
        instants_s: when the sound is traced; None takes six over the walk.
        fidelity: what is traced.

    Returns:
        The path.
    """
    shown: list[dict[str, Any]] = []
    if walk is not None:
        times = np.linspace(0.0, walk.duration_s, INSTANTS) if instants_s is None else np.asarray(instants_s, float)
        shown = _instants(scene, walk, phone, times, fidelity)
    data = {
        "name": scene.name,
        "level": _level(scene),
        "reach": _radius(scene),
        "camera": _camera(scene, walk),
        "kinds": KINDS,
        "obstacles": [_obstacle(obstacle) for obstacle in scene.obstacles],
        "walk": None if walk is None else _packed(_walked_path(walk)),
        "instants": shown,
    }
    template = (resources.files("scenes") / "templates" / "preview.html").read_text(encoding="utf-8")
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")  # "<!--<script>" would hide the end of the element
    head, tail = template.split("__DATA__")
    page = head.replace("__TITLE__", html.escape(scene.name)) + text + tail
    Path(path).write_text(page, encoding="utf-8")
    return Path(path)


def _obstacle(obstacle: Obstacle) -> dict[str, Any]:
    low, high = obstacle.mesh.bounds
    return {
        "name": obstacle.name,
        "category": obstacle.category,
        "color": GROUND if obstacle.category == "ground" else COLORS.get(obstacle.category, OTHER),
        "velocity": obstacle.velocity_m_s.tolist(),
        "top": [*(0.5 * (low + high)[:2]).tolist(), float(high[2])],
        "mesh": _packed(obstacle.mesh),
    }


def _packed(mesh: trimesh.Trimesh) -> dict[str, str]:
    """Vertices as float32, faces as uint32, one int8 normal a corner, each as base64."""
    normals = np.rint(127.0 * _corner_normals(mesh)).astype(np.int8)
    return {
        "vertices": _text(np.asarray(mesh.vertices, dtype="<f4")),
        "faces": _text(np.asarray(mesh.faces, dtype="<u4")),
        "normals": _text(normals),
    }


def _text(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def _corner_normals(mesh: trimesh.Trimesh) -> Floats:
    """(T, 3, 3) normal of every corner: the vertex's where the surface bends little there, else the facet's."""
    joined = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    shared = np.asarray(joined.vertex_normals)[joined.faces]
    own = np.repeat(np.asarray(joined.face_normals)[:, None], 3, axis=1)
    smooth = np.sum(shared * own, axis=2) > SMOOTH_COS
    return np.where(smooth[:, :, None], shared, own)


def _instants(
    scene: Scene, walk: Walk, phone: Phone | None, time_s: Floats, fidelity: Fidelity | None
) -> list[dict[str, Any]]:
    """What changes from instant to instant: the phone, the walker, and the paths of sound."""
    pose = walk.pose(time_s)
    paths = None if phone is None else trace_paths(scene, phone, pose, fidelity, time_s)
    corners = pose.to_world(_phone_box())
    return [
        {
            "time_s": float(time),
            "phone": _packed(trimesh.Trimesh(corners[k], trimesh.creation.box().faces, process=False)),
            "walker": None if phone is None or phone.body is None else _packed(_walker(phone.body, pose, k)),
            "paths": {} if paths is None else _tubes(paths[(paths.pose == k) & (paths.mic == 0) & (paths.order > 0)]),
            "strongest": [] if paths is None else _strongest(paths, k, scene.air.sound_speed_m_s),
        }
        for k, time in enumerate(time_s)
    ]


def _phone_box() -> Floats:
    """(8, 3) corners of a phone, in its frame."""
    corners: Floats = np.asarray(trimesh.creation.box().vertices) * 2.0 * PHONE_HALF_M
    return corners


def _walker(body: Obstacle, pose: Pose, index: int) -> trimesh.Trimesh:
    """The walker's body where it stands at one pose."""
    heading = pose.body_heading_rad()[index]
    cos, sin = np.cos(heading), np.sin(heading)
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return trimesh.Trimesh(body.mesh.vertices @ rotation.T + pose.position_m[index], body.mesh.faces, process=False)


def _tubes(paths: Paths) -> dict[str, dict[str, str]]:
    """The strongest paths as thin tubes, by mechanism; thinner by a third every 10 dB below the strongest."""
    level = 20.0 * np.log10(np.abs(paths.gain))
    strongest = np.argsort(-level)[:DRAWN_PATHS]
    found: dict[str, list[trimesh.Trimesh]] = {}
    for row in strongest:
        radius = PATH_RADIUS_M * (2.0 / 3.0) ** min((level[strongest[0]] - level[row]) / 10.0, 3.0)
        points = paths.points_m[row, : paths.order[row] + 2]
        found.setdefault(str(paths.kind[row]), []).append(tube(points, radius))
    return {kind: _packed(merged(parts)) for kind, parts in found.items()}


def _strongest(paths: Paths, pose: int, sound_speed_m_s: float) -> list[dict[str, Any]]:
    """The loudest obstacle by obstacle: level re the free field at 1 m, half the length of its strongest path."""
    rows = np.flatnonzero((paths.pose == pose) & (paths.mic == 0) & (paths.order > 0))
    rows = rows[np.argsort(-np.abs(paths.gain[rows]))]
    _, first = np.unique(paths.obstacle[rows], return_index=True)
    return [
        {
            "level_db": float(20.0 * np.log10(np.abs(paths.gain[row]))),
            "range_m": float(0.5 * paths.delay_s[row] * sound_speed_m_s),
            "obstacle": str(paths.obstacle[row]),
        }
        for row in rows[np.sort(first)[:LISTED_PATHS]]
    ]


def tube(points_m: Floats, radius_m: float, sides: int = 6) -> trimesh.Trimesh:
    """A tube of straight pieces along (N, 3) points, open at its ends; repeated points are left out."""
    points = np.asarray(points_m, dtype=np.float64)
    points = points[np.r_[True, np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9]]
    along = np.diff(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    aside = np.cross(along, np.where(np.abs(along[:, 2:]) > 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[:, None] * aside[:, None] + np.sin(angle)[:, None] * np.cross(along, aside)[:, None]
    ends = np.stack([points[:-1], points[1:]], axis=1)
    vertices = (ends[:, :, None] + radius_m * ring[:, None]).reshape(-1, 3)
    here = np.arange(sides)
    after = (here + 1) % sides
    halves = [here, here + sides, after], [after, here + sides, after + sides]
    faces = np.concatenate([np.stack(half, axis=1) for half in halves])
    every = (faces[None] + 2 * sides * np.arange(len(along))[:, None, None]).reshape(-1, 3)
    return trimesh.Trimesh(vertices, every, process=False)


def _walked_path(walk: Walk) -> trimesh.Trimesh:
    time = np.linspace(0.0, walk.duration_s, max(2, 1 + int(np.ceil(walk.duration_s / 0.05))))
    place = walk.pose(time).position_m
    moved = np.linalg.norm(place[-1] - place[0]) > 1e-6 or np.ptp(place, axis=0).max() > 1e-6
    return tube(place if moved else place[0] + np.array([[0.0, 0.0, -0.02], [0.0, 0.0, 0.02]]), PATH_RADIUS_M)


def _level(scene: Scene) -> float:
    tops = [float(o.mesh.bounds[1, 2]) for o in scene.obstacles if o.category == "ground"]
    return max(tops, default=0.0)


def _corners(scene: Scene) -> Floats:
    """(2, 3) bounds of everything but the ground."""
    bounds = [np.asarray(o.mesh.bounds) for o in scene.obstacles if o.category != "ground"]
    points = np.concatenate(bounds) if bounds else np.array([[-2.0, -2.0, 0.0], [2.0, 2.0, 2.0]])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _radius(scene: Scene) -> float:
    return float(0.5 * np.linalg.norm(np.diff(_corners(scene), axis=0)))


def _camera(scene: Scene, walk: Walk | None) -> dict[str, Any]:
    """From behind the walker's right shoulder, far enough to see the walk and what it meets."""
    if walk is None:
        middle, size, heading = _corners(scene).mean(axis=0), _radius(scene), 0.0
    else:
        pose = walk.pose(np.linspace(0.0, walk.duration_s, 20))
        heading = float(pose.body_heading_rad()[0])
        ends = pose.position_m[[0, -1]]
        middle = ends.mean(axis=0) + np.array([np.cos(heading), np.sin(heading), 0.0])
        size = 0.5 * float(np.linalg.norm(ends[1] - ends[0])) + 1.5
    az = float(np.rad2deg(heading)) - 125.0
    return {"az": az, "el": 24.0, "d": 2.9 * size, "at": [float(middle[0]), float(middle[1]), _level(scene) + 0.8]}
