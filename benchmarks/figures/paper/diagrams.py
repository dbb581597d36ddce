"""The paper's drawings (Figures 1, 2, 7 and 13 to 15), made from the bench's own phones, scenes, paths and stages.

They show what the bench is and need no run; they are drawn for runs that hold signals.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.figures.plots import Drawing, DrawingFigure, Role, Shape
from benchmarks.runs.results import RunData
from obstaclewatch.support.arrays import Floats
from scenes.preview.silhouette import outer_rings, silhouette

SIDE, PLAN = (0, 2), (0, 1)
HEIGHT_M, PITCH_RAD = 1.3, float(np.deg2rad(30.0))


def sensing_drawing(run: RunData) -> DrawingFigure:
    """Figure 1: a walker, the phone, an obstacle, and the paths that the simulator traces between them."""
    panels = (_sensing_panel(),) if has_signals(run) else ()
    return DrawingFigure(
        "fig1",
        "Fig. 1 · Obstacle detection with a phone",
        panels,
        "Traced paths to microphone 1: off the dustbin, off the ground, and by their corner.",
        "Side view of the meshes; every line is a path of at most two reflections.",
    )


def flow_drawing(run: RunData) -> DrawingFigure:
    """Figure 2: the stages of the paper's detector by the names of the functions that do them."""
    panels = (_flow_panel(),) if has_signals(run) else ()
    return DrawingFigure(
        "fig2",
        "Fig. 2 · System flow",
        panels,
        "Four components, one beep at a time.",
        "Upper line: the paper's component; lower line: the function of obstaclewatch.",
        height_in=3.4,
    )


def bearing_drawing(run: RunData) -> DrawingFigure:
    """Figure 7: the triangle of obstacle and microphones, to scale."""
    panels = (_bearing_panel("galaxy-s8-plus", 0.8, np.deg2rad(30.0)),) if has_signals(run) else ()
    return DrawingFigure(
        "fig7",
        "Fig. 7 · Angle between walking path and obstacle",
        panels,
        "The difference of the two distances gives the angle (Eq. 2).",
        "To scale, seen from above, the phone level; a Galaxy S8+ and an object at 0.8 m and 30°.",
    )


def collision_drawing(run: RunData) -> DrawingFigure:
    """Figure 13: walking angle against collision angle, a collision and none."""
    panels = tuple(_collision_panel(*case) for case in (("A: collision", 6.0), ("B: no collision", 28.0)))
    return DrawingFigure(
        "fig13",
        "Fig. 13 · Walking angle and collision angle",
        panels if has_signals(run) else (),
        "A collision is predicted where the walking angle is at most the collision angle (Eq. 4).",
        "To scale, seen from above: a round object of 40 cm radius at 2 m. θ, dashed arc: walking angle. δ, solid arc: "
        "collision angle, from D1, to the nearest point, to Df, past the rim. The bench's rule also counts half the "
        "walker's width.",
    )


def street_drawing(run: RunData, name: str, scene: str) -> DrawingFigure:
    """Figures 14 and 15: the bench's street in place of the paper's photographs of its own."""
    panels = (_street_panel(scene),) if has_signals(run) else ()
    return DrawingFigure(
        name,
        f"Fig. {name[3:]} · The {scene} street from above",
        panels,
        f"The bench's {scene}; the paper shows a map and photographs of its own.",
        "Seed 0. Every approach of a suite has a street of its own, drawn from its seed.",
        height_in=3.8,
    )


def has_signals(run: RunData) -> bool:
    """Whether a run holds signals, and so is about the paper's first figures."""
    return any(record["cell"]["kind"] == "signal" for record in run.cells)


def _sensing_panel() -> Drawing:
    from scenes import walker_body
    from scenes.obstacles import ground, random_obstacle
    from scenes.streets.placing import placed
    from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
    from simulator.scene.pose import held_rotation

    rng = np.random.default_rng(1)
    bin_ = placed(random_obstacle("dustbin", rng, "dustbin"), (2.3, 0.0), 0.0, (0.0, 0.0, 0.0))
    floor = Obstacle(ground(), Material.named("asphalt"), "ground", surface="flat", category="ground")
    pose = Pose(np.array([0.0, 0.0, HEIGHT_M]), held_rotation(0.0, PITCH_RAD))
    body = walker_body(phone_height_m=HEIGHT_M)
    phone = Phone.named("galaxy-s8-plus")
    paths = trace_paths(Scene([floor, bin_]), phone, pose, fidelity=Fidelity(mechanisms=("specular", "curved")))
    edges = pose.to_world(phone.geometry.mics_m)[0][:, SIDE]
    shapes = [
        Shape("line", np.array([[-0.7, 0.0], [3.2, 0.0]]), "axis"),
        *(Shape("polygon", ring, "thing") for ring in _outlines(bin_, SIDE)),
        *(Shape("polygon", ring + [0.0, HEIGHT_M], "person") for ring in _outlines(body, SIDE)),
    ]
    chosen = paths[(paths.mic == 0) & (paths.order > 0)]
    for points, order in zip(chosen.points_m, chosen.order, strict=True):
        shapes.append(Shape("arrow", points[: order + 2, SIDE], "sound"))
    shapes += [
        Shape("line", edges, "phone"),
        Shape("dot", edges[:1], "phone", "mic1"),
        Shape("dot", edges[1:], "phone"),
        Shape("text", edges[1:] - [[0.16, 0.0]], "text", "mic2"),
        Shape("arrow", np.array([[-0.6, 2.0], [0.2, 2.0]]), "walk", "walking"),
    ]
    return Drawing("", tuple(shapes), width_in=5.6, x_range=(-0.9, 3.2), y_range=(-0.1, 2.2))


def _flow_panel() -> Drawing:
    from obstaclewatch.paper.bearing import path_difference, walking_angle
    from obstaclewatch.paper.clutter import judge_motion
    from obstaclewatch.paper.collision import CollisionVote, decide, on_collision_course
    from obstaclewatch.paper.size import rim_excess, size_from_crest
    from obstaclewatch.signal.echoes import os_cfar_threshold, separated_peaks
    from obstaclewatch.signal.matched_filter import MatchedFilter
    from obstaclewatch.signal.two_mics import one_way_range

    columns: tuple[tuple[str, tuple[tuple[str, Callable[..., Any]], ...]], ...] = (
        (
            "Obstacle detection",
            (
                ("correlation", MatchedFilter.compress),
                ("threshold", os_cfar_threshold),
                ("peaks", separated_peaks),
                ("peak filtering", judge_motion),
                ("distance", one_way_range),
            ),
        ),
        ("Angle estimation", (("TDoA, body mitigation", path_difference), ("walking angle", walking_angle))),
        ("Size estimation", (("crest width", rim_excess), ("collision angle", size_from_crest))),
        (
            "Collision detection",
            (("Eq. 4", on_collision_course), ("five of nine", CollisionVote.cast), ("alert", decide)),
        ),
    )
    shapes: list[Shape] = []
    for x, (head, stages) in enumerate(columns):
        shapes.append(Shape("text", np.array([[x, 0.65]]), "text", head))
        for row, (words, function) in enumerate(stages):
            place = np.array([[x, -0.85 * row]])
            name = (
                function.__qualname__.split(".")[0] if words in ("correlation", "five of nine") else function.__name__
            )
            shapes.append(Shape("box", place, "sound", f"{words}\n{name}"))
            if row:
                shapes.append(Shape("arrow", np.array([[x, -0.85 * row + 0.54], [x, -0.85 * row + 0.31]]), "sound"))
    ends = [len(stages) - 1 for _, stages in columns]
    for x in range(3):
        start = np.array([x + 0.43, -0.85 * ends[x]])
        shapes.append(Shape("arrow", np.array([start, [x + 0.5, start[1]], [x + 0.5, 0.0], [x + 0.57, 0.0]]), "sound"))
    return Drawing("", tuple(shapes), axes=False, width_in=6.0, x_range=(-0.55, 3.55), y_range=(-3.8, 0.9))


def _bearing_panel(phone_name: str, range_m: float, bearing_rad: float) -> Drawing:
    from simulator import Phone

    mics = Phone.named(phone_name).geometry.mics_m
    first, second = (np.array([mic[1], 0.0]) for mic in mics)
    thing = first + range_m * np.array([np.cos(bearing_rad), np.sin(bearing_rad)])
    d1, d2 = range_m, float(np.linalg.norm(thing - second))
    arc = np.linspace(0.0, bearing_rad, 20)
    shapes = (
        Shape("line", np.array([second, first]), "phone"),
        Shape("line", np.array([first, [1.0, 0.0]]), "walk"),
        Shape("arrow", np.array([[0.85, 0.0], [1.0, 0.0]]), "walk"),
        Shape("text", np.array([[0.8, -0.04]]), "text", "walking path"),
        Shape("line", np.array([first, thing]), "sound"),
        Shape("line", np.array([second, thing]), "sound"),
        Shape("line", first + 0.3 * np.stack([np.cos(arc), np.sin(arc)], axis=1), "angle"),
        Shape("text", first + np.array([[0.37, 0.09]]), "text", f"θ = {np.rad2deg(bearing_rad):.0f}°"),
        Shape("dot", np.array([first]), "phone"),
        Shape("dot", np.array([second]), "phone"),
        Shape("text", np.array([[first[0] + 0.02, -0.04]]), "text", "mic1"),
        Shape("text", np.array([[second[0] - 0.02, -0.04]]), "text", "mic2"),
        Shape("text", np.array([[0.0, -0.1]]), "text", f"L = {100 * (first[0] - second[0]):.1f} cm"),
        Shape("text", 0.55 * first + 0.45 * thing + np.array([[0.13, -0.02]]), "text", f"D1 = {100 * d1:.1f} cm"),
        Shape("text", 0.6 * second + 0.4 * thing + np.array([[-0.12, 0.07]]), "text", f"D2 = {100 * d2:.1f} cm"),
        Shape("dot", np.array([thing]), "thing", "obstacle"),
    )
    return Drawing("", shapes, width_in=5.6, x_range=(-0.25, 1.1), y_range=(-0.16, 0.52))


def _collision_panel(title: str, walking_deg: float) -> Drawing:
    radius, distance = 0.4, 2.0
    angle = np.deg2rad(walking_deg)
    center = (distance + radius) * np.array([np.cos(angle), np.sin(angle)])
    near = distance * np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-np.sin(angle), np.cos(angle)])
    rim = near - radius * across
    delta = float(np.arctan2(radius, distance))
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    first, second = np.linspace(0.0, angle, 20), np.linspace(angle - delta, angle, 20)
    hit = angle <= delta
    shapes = (
        Shape("polygon", center + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1), "thing"),
        Shape("arrow", np.array([[0.0, 0.0], [2.9, 0.0]]), "hit" if hit else "safe"),
        Shape("line", np.array([[0.0, 0.0], near]), "sound"),
        Shape("line", np.array([[0.0, 0.0], rim]), "sound"),
        Shape("line", 0.9 * np.stack([np.cos(first), np.sin(first)], axis=1), "walk"),
        Shape("line", 1.3 * np.stack([np.cos(second), np.sin(second)], axis=1), "angle"),
        Shape("dot", np.array([[0.0, 0.0]]), "phone"),
        Shape("text", near * 0.8 + 0.16 * across[None, :], "text", "D1"),
        Shape("text", rim * 0.8 - 0.14 * across[None, :], "text", "Df"),
        Shape(
            "text",
            np.array([[1.2, 1.45]]),
            "text",
            f"θ = {walking_deg:.0f}° {'≤' if hit else '>'} δ = {np.rad2deg(delta):.0f}°",
        ),
    )
    return Drawing(title, shapes, width_in=3.4, x_range=(-0.2, 3.1), y_range=(-0.65, 1.75))


def _street_panel(scene: str) -> Drawing:
    from scenes import load_scene

    shapes: list[Shape] = []
    seen: set[str] = set()
    for obstacle in load_scene(scene, 0).obstacles:
        if obstacle.category == "ground":
            continue
        rings = _outlines(obstacle, PLAN)
        role: Role = "person" if obstacle.category == "pedestrian" else "thing"
        word = obstacle.name if obstacle.category in ("wall", "") else obstacle.category
        shapes += [Shape("polygon", ring, role) for ring in rings]
        if word not in seen:
            taken = [shape.points[0] for shape in shapes if shape.kind == "text"]
            shapes.append(Shape("text", _free_place(np.concatenate(rings), taken)[None, :], "text", word))
        seen.add(word)
    shapes.append(Shape("arrow", np.array([[-0.5, 0.0], [23.0, 0.0]]), "walk"))
    shapes.append(Shape("text", np.array([[1.2, -0.6]]), "text", "the walk"))
    return Drawing("", tuple(shapes), width_in=7.6, x_range=(-1.5, 25.5), y_range=(-9.8, 8.8))


def _free_place(outline: Floats, taken: Sequence[Floats]) -> Floats:
    """Just above a thing seen from above, or just below where another word stands already."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    above, below = (np.array([0.5 * (low[0] + high[0]), y]) for y in (high[1] + 0.5, low[1] - 0.5))
    crowded = any(abs(above[0] - x) < 3.0 and abs(above[1] - y) < 0.8 for x, y in taken)
    return below if crowded or above[1] > 8.0 else above


def _outlines(obstacle: Any, plane: tuple[int, int]) -> list[Floats]:
    """Outer borders (K, 2) of what an obstacle covers, seen along the axis that the plane lacks."""
    return outer_rings(silhouette(np.asarray(obstacle.mesh.triangles)[:, :, plane]))


def street_drawings() -> dict[str, Callable[[RunData], DrawingFigure]]:
    """Figures 14 and 15 by name."""
    streets: Sequence[tuple[str, str]] = (("fig14", "supermarket"), ("fig15", "campus"))
    return {name: _street(name, scene) for name, scene in streets}


def _street(name: str, scene: str) -> Callable[[RunData], DrawingFigure]:
    def build(run: RunData) -> DrawingFigure:
        return street_drawing(run, name, scene)

    return build
