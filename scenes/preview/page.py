"""A scene as one HTML file to rotate and zoom in a browser: obstacles, walk, phone, and where its sound goes."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.whole_file import whole_file
from scenes.preview.pictures import COLORS, LIGHT, OTHER
from scenes.preview.plotly_page import in_script, library_script, packed_array
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.scene.pose import Pose, Walk
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import trace_paths

GROUND = "#cfd2d4"
KINDS = {"specular": "#0072b2", "curved": "#d55e00", "edge": "#009e73", "kirchhoff": "#56b4e9", "mixed": "#cc79a7"}
"""Colours by mechanism, distinct for the colour-blind as well (Okabe and Ito)."""

PHONE_M = np.array([0.072, 0.144, 0.010])
INSTANTS, DRAWN_PATHS, LISTED_PATHS = 6, 40, 9
LOUD_DB = 10.0
"""Paths within this of the strongest are drawn thick."""
AROUND_M, SKY_M = 1.0, 3.0
UNLIT = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0}
"""Shades are painted on: Plotly's own light leaves faces towards the viewer dark."""

Trace = dict[str, Any]

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>html, body, #scene {{ margin: 0; height: 100%; background: #e9eef3; }}</style>
</head>
<body>
<div id="scene"></div>
<script>{library}</script>
<script id="data" type="application/json">{figure}</script>
<script>
plotly().then(async library => {{
  const {{frames, ...figure}} = JSON.parse(document.getElementById("data").textContent);
  await library.newPlot("scene", {{...figure, config: {{responsive: true, displaylogo: false}}}});
  await library.addFrames("scene", frames);
  document.title += " \\u2713";
}});
</script>
</body>
</html>
"""


def preview_html(scene: Scene, path: str | Path, walk: Walk | None = None, phone: Phone | None = None) -> Path:
    """Write a scene as an HTML file that shows it in three dimensions.

    Args:
        scene: obstacles, coloured by category; those that move do so with the slider of instants.
        path: file to write.
        walk: path of the phone to draw.
        phone: whose echoes are traced and drawn at six instants; needs a walk, None draws no sound.

    Returns:
        The path.
    """
    return write_page(preview_figure(scene, walk, phone), path)


def write_page(figure: dict[str, Any], path: str | Path) -> Path:
    """Write a figure with data, layout and frames as a page of its own; the path."""
    page = _PAGE.format(title=figure["layout"]["title"]["text"], library=library_script(), figure=in_script(figure))
    with whole_file(Path(path)) as partial:
        partial.write_text(page, encoding="utf-8")
    return Path(path)


def preview_figure(
    scene: Scene, walk: Walk | None = None, phone: Phone | None = None, instants_s: Sequence[float] | None = None
) -> dict[str, Any]:
    """Data, layout and frames of the page's figure, ready for JSON; arguments as of `preview_html`.

    Args:
        instants_s: when the sound is traced; None takes six over the walk.
    """
    shown = {obstacle.category: obstacle.name for obstacle in reversed(scene.obstacles)}
    low, high = _corners(scene, walk)
    still = [_obstacle(one, shown[one.category] == one.name) for one in scene.obstacles]
    still += [_names(scene), _metres(low, high)]
    moments: list[dict[str, Any]] = []
    if walk is not None:
        still.append(_walked_path(walk))
        times = np.linspace(0.0, walk.duration_s, INSTANTS) if instants_s is None else np.asarray(instants_s, float)
        moments = _moments(scene, walk, phone, times)
    moving = [k for k, obstacle in enumerate(scene.obstacles) if obstacle.moves]
    changing = [*moving, *range(len(still), len(still) + len(moments[0]["traces"]))] if moments else []
    frames = [
        {
            "name": f"{moment['time_s']:.2f} s",
            "data": [*(_places(scene.obstacles[k], moment["time_s"]) for k in moving), *moment["traces"]],
            "traces": changing,
            "layout": {"annotations": [_listed(moment["strongest"])]},
        }
        for moment in moments
    ]
    data = [*still, *(moments[0]["traces"] if moments else ())]
    return {"data": data, "layout": _layout(scene, walk, low, high, frames), "frames": frames}


def _obstacle(obstacle: Obstacle, first: bool) -> Trace:
    """Its mesh; the first of a category stands for it in the legend."""
    color = GROUND if obstacle.category == "ground" else COLORS.get(obstacle.category, OTHER)
    return _solid(obstacle.mesh, color, obstacle.category or "other", first, obstacle.name)


def _solid(mesh: trimesh.Trimesh, color: str, group: str, legend: bool, name: str) -> Trace:
    faces = {axis: packed_array(column, "i4") for axis, column in zip("ijk", np.asarray(mesh.faces).T, strict=True)}
    return {
        "type": "mesh3d", "name": group, "legendgroup": group, "showlegend": legend, "color": color,
        "intensity": packed_array(0.5 + 0.5 * mesh.face_normals @ LIGHT), "intensitymode": "cell", "cmin": 0, "cmax": 1,
        "colorscale": [[0.0, _mixed(color, 0.0)], [0.8, color], [1.0, _mixed(color, 1.0)]], "showscale": False,
        "lighting": UNLIT, "hovertext": _plain(name), "hoverinfo": "x+y+z+text",
        **_xyz(mesh.vertices), **faces,
    }  # fmt: skip


def _mixed(color: str, white: float) -> str:
    """Half the colour, half black (0) or white (1)."""
    channels = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(0.5 * channel + 127.5 * white):02x}" for channel in channels)


def _plain(text: str) -> str:
    """The text where Plotly would read markup."""
    return html.escape(text, quote=False)


def _xyz(points_m: Floats) -> Trace:
    return {axis: packed_array(column) for axis, column in zip("xyz", np.asarray(points_m).T, strict=True)}


def _places(obstacle: Obstacle, time_s: float) -> Trace:
    """Where its corners are at a time."""
    return {"type": "mesh3d", **_xyz(np.asarray(obstacle.mesh.vertices) + time_s * obstacle.velocity_m_s)}


def _names(scene: Scene) -> Trace:
    """The names of the obstacles above them, at time 0."""
    named = [one for one in scene.obstacles if one.category != "ground"]
    tops = [[*one.mesh.bounds[:, :2].mean(axis=0), one.mesh.bounds[1, 2] + 0.15] for one in named]
    return {
        "type": "scatter3d", "mode": "text", "name": "names", "text": [_plain(one.name) for one in named],
        "hoverinfo": "skip", "textfont": {"size": 11}, **_xyz(np.array(tops).reshape(-1, 3)),
    }  # fmt: skip


def _metres(low: Floats, high: Floats) -> Trace:
    """A grid of metres on the ground."""
    points = []
    for along, across in ((0, 1), (1, 0)):
        for place in range(int(np.ceil(low[along])), int(high[along]) + 1):
            ends = np.full((3, 3), low[2] + 0.03)
            ends[:, along], ends[:, across] = place, [low[across], high[across], np.nan]
            points.append(ends)
    return {
        "type": "scatter3d", "mode": "lines", "name": "metres", "hoverinfo": "skip",
        "line": {"color": "#b4babf", "width": 1}, **_xyz(np.concatenate(points)),
    }  # fmt: skip


def _walked_path(walk: Walk) -> Trace:
    time = np.linspace(0.0, walk.duration_s, max(2, 1 + int(np.ceil(walk.duration_s / 0.05))))
    return {
        "type": "scatter3d", "mode": "lines", "name": "path of the phone", "hoverinfo": "skip",
        "line": {"color": "#7f6000", "width": 4}, **_xyz(walk.pose(time).position_m),
    }  # fmt: skip


def _moments(scene: Scene, walk: Walk, phone: Phone | None, time_s: Floats) -> list[dict[str, Any]]:
    """What changes from instant to instant: the phone, the walker, and the paths of sound."""
    pose = walk.pose(time_s)
    paths = None if phone is None else trace_paths(scene, phone, pose, time_s=time_s)
    kinds = [] if paths is None else [kind for kind in KINDS if (paths.kind[paths.order > 0] == kind).any()]
    box = trimesh.creation.box(PHONE_M)
    corners = pose.to_world(np.asarray(box.vertices))
    found = []
    for k, time in enumerate(time_s):
        held = trimesh.Trimesh(corners[k], box.faces, process=False)
        traces = [_solid(held, "#111111", "phone", True, "phone")]
        if phone is not None and phone.body is not None:
            traces.append(_solid(_walker(phone.body, pose, k), "#c9a227", "walker", True, "walker"))
        here = paths if paths is None else _strongest(paths, k)
        listed = [] if here is None else _by_obstacle(here, scene.air.sound_speed_m_s)
        if here is not None:
            traces += [_lines(here, kind, loud, scene.air.sound_speed_m_s) for kind in kinds for loud in (True, False)]
        found.append({"time_s": float(time), "traces": traces, "strongest": listed})
    return found


def _walker(body: Obstacle, pose: Pose, index: int) -> trimesh.Trimesh:
    """The walker's body where it stands at one pose."""
    turned = body.mesh.copy()
    turned.apply_transform(trimesh.transformations.rotation_matrix(pose.body_heading_rad()[index], [0.0, 0.0, 1.0]))
    return turned.apply_translation(pose.position_m[index])


def _strongest(paths: Paths, pose: int) -> Paths:
    """The echoes at microphone 1 at one pose, the loudest first."""
    here = paths[(paths.pose == pose) & (paths.mic == 0) & (paths.order > 0)]
    return here[np.argsort(-np.abs(here.gain))]


def _lines(paths: Paths, kind: str, loud: bool, sound_speed_m_s: float) -> Trace:
    """The strongest paths of one mechanism, thick or thin, with a gap after each."""
    level = 20.0 * np.log10(np.abs(paths.gain))
    points, words = [np.full((1, 3), np.nan)], [""]  # the legend leaves out what has no points
    for row in range(min(len(level), DRAWN_PATHS)):
        if paths.kind[row] != kind or (level[row] > level[0] - LOUD_DB) != loud:
            continue
        corners = paths.points_m[row, : paths.order[row] + 2]
        points += [corners, np.full((1, 3), np.nan)]
        size = f"{level[row]:.1f} dB, {_range_m(paths, row, sound_speed_m_s):.2f} m"
        text = f"{_plain(str(paths.obstacle[row]))}, {kind}<br>{size}"
        words += [text] * (len(corners) + 1)
    return {
        "type": "scatter3d", "mode": "lines", "name": f"echoes, {kind}", "legendgroup": kind, "showlegend": loud,
        "line": {"color": KINDS[kind], "width": 6 if loud else 2}, "text": words, "hoverinfo": "text",
        **_xyz(np.concatenate(points)),
    }  # fmt: skip


def _range_m(paths: Paths, row: int, sound_speed_m_s: float) -> float:
    return float(0.5 * paths.delay_s[row] * sound_speed_m_s)


def _by_obstacle(paths: Paths, sound_speed_m_s: float) -> list[str]:
    """The loudest path of each of the loudest obstacles: level re the free field at 1 m, half its length."""
    _, first = np.unique(paths.obstacle, return_index=True)
    return [
        f"{20.0 * np.log10(np.abs(paths.gain[row])):.1f} dB  {_range_m(paths, row, sound_speed_m_s):.2f} m  "
        f"{_plain(str(paths.obstacle[row]))}"
        for row in np.sort(first)[:LISTED_PATHS]
    ]


def _listed(lines: Sequence[str]) -> Trace:
    head = ["<b>echoes at the top microphone</b>"] if lines else []
    return {
        "text": "<br>".join([*head, *lines]), "x": 0.99, "y": 0.02, "xref": "paper", "yref": "paper", "align": "left",
        "showarrow": False, "bgcolor": "rgba(255,255,255,.8)", "xanchor": "right", "yanchor": "bottom",
    }  # fmt: skip


def _layout(scene: Scene, walk: Walk | None, low: Floats, high: Floats, frames: list[Trace]) -> dict[str, Any]:
    scale = float(np.cbrt(np.prod(high - low)))
    at, eye = _camera(scene, walk)
    middle = 0.5 * (low + high)
    camera = {
        name: dict(zip("xyz", ((point - middle) / scale).tolist(), strict=True))
        for name, point in (("center", at), ("eye", eye))
    }
    axes = {f"{axis}axis": {"range": [low[k], high[k]], "visible": False} for k, axis in enumerate("xyz")}
    ratio = dict(zip("xyz", ((high - low) / scale).tolist(), strict=True))
    play = {"mode": "immediate", "frame": {"duration": 0, "redraw": True}, "transition": {"duration": 0}}
    steps = [{"label": frame["name"], "method": "animate", "args": [[frame["name"]], play]} for frame in frames]
    return {
        "title": {"text": _plain(scene.name)}, "margin": {"l": 0, "r": 0, "t": 50, "b": 30}, "paper_bgcolor": "#e9eef3",
        "scene": {**axes, "aspectmode": "manual", "aspectratio": ratio, "camera": camera, "dragmode": "turntable"},
        "legend": {"itemsizing": "constant", "x": 0.01, "y": 0.98, "bgcolor": "rgba(255,255,255,.8)"},
        "uirevision": "kept", "annotations": [frame["layout"]["annotations"][0] for frame in frames[:1]],
        "sliders": [{"steps": steps, "x": 0.3, "len": 0.6, "pad": {"t": 0, "b": 12}}] if steps else [],
    }  # fmt: skip


def _corners(scene: Scene, walk: Walk | None) -> tuple[Floats, Floats]:
    """What the axes hold: everything but the ground's far ends, m."""
    bounds = [np.asarray(o.mesh.bounds) for o in scene.obstacles if o.category != "ground"]
    bounds += [] if walk is None else [walk.pose(np.linspace(0.0, walk.duration_s, 20)).position_m]
    points = np.concatenate(bounds) if bounds else np.array([[-2.0, -2.0, 0.0], [2.0, 2.0, 2.0]])
    low, high = points.min(axis=0) - AROUND_M, points.max(axis=0) + AROUND_M
    tops = [float(o.mesh.bounds[1, 2]) for o in scene.obstacles if o.category == "ground"]
    low[2] = max(tops, default=low[2] + AROUND_M) - 0.02
    high[2] = max(high[2] - AROUND_M, low[2] + SKY_M)
    return low, high


def _camera(scene: Scene, walk: Walk | None) -> tuple[Floats, Floats]:
    """Where it looks and from where: from behind the walker's right shoulder, with the walk and what it meets."""
    low, high = _corners(scene, walk)
    middle, size, heading = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)), 0.0
    if walk is not None:
        pose = walk.pose(np.linspace(0.0, walk.duration_s, 20))
        heading = float(pose.body_heading_rad()[0])
        ends = pose.position_m[[0, -1]]
        middle = ends.mean(axis=0) + np.array([np.cos(heading), np.sin(heading), 0.0])
        size = 0.5 * float(np.linalg.norm(ends[1] - ends[0])) + 1.5
    middle[2] = low[2] + 0.8
    azimuth, elevation = heading - np.deg2rad(125.0), np.deg2rad(24.0)
    ahead = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    return middle, middle + 2.9 * size * np.array(ahead)
