"""Signs: boards on a pole, and A-frame boards on the pavement."""

from __future__ import annotations

from typing import Literal

import numpy as np
import trimesh

from scenes.obstacles.measures import measured
from scenes.obstacles.solids import box, cylinder, disc, merged, shifted, tilted
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

POLE_RADIUS_M = 0.03
Outline = Literal["round", "square", "octagon", "triangle"]
OUTLINES: tuple[Outline, ...] = ("round", "square", "octagon", "triangle")
CORNERS = {"round": 48, "octagon": 8, "triangle": 3}


@measured
def pole_sign(
    board_m: float = 0.6,
    center_height_m: float = 1.3,
    shape: Outline = "round",
    thickness_m: float = 0.003,
    pole_radius_m: float = POLE_RADIUS_M,
) -> trimesh.Trimesh:
    """A sheet on the -x side of a pole, which ends at the sheet's upper edge.

    Args:
        board_m: diameter of a round sheet, side of a square one, twice the reach of the corners of another.
        center_height_m: height of the sheet's centre.
        shape: outline of the sheet.
        thickness_m: thickness of the sheet.
        pole_radius_m: radius of the pole.

    Raises:
        ValueError: a measure that is not positive, a sheet that reaches into the ground, or an unknown shape.
    """
    if center_height_m <= board_m / 2:
        raise ValueError(f"center_height_m must be above half the board {board_m / 2} m, got {center_height_m}")
    if shape not in ("square", *CORNERS):
        raise ValueError(f"shape must be one of square, {', '.join(CORNERS)}, got {shape!r}")
    if shape == "square":
        sheet = box([thickness_m, board_m, board_m], np.zeros(3))
    else:
        sheet = disc(board_m / 2, thickness_m, CORNERS[shape])
    clearance = pole_radius_m + thickness_m / 2 + 0.005
    pole = cylinder(pole_radius_m, center_height_m + board_m / 2, 32)
    return merged([pole, shifted(sheet, [-clearance, 0.0, center_height_m])])


@measured
def a_frame(
    width_m: float = 0.6, height_m: float = 0.9, opening_m: float = 0.5, thickness_m: float = 0.004
) -> trimesh.Trimesh:
    """Two sheets that lean together, facing -x and +x.

    Args:
        width_m: width of a sheet.
        height_m: height of its upper edge.
        opening_m: distance between the two feet.
        thickness_m: thickness of a sheet.

    Raises:
        ValueError: a measure that is not positive.
    """
    gap = 0.012
    lean = float(np.arctan2(opening_m / 2 - gap, height_m))
    sheet = box([thickness_m, width_m, height_m / np.cos(lean)])
    front = shifted(tilted(sheet, lean), [-opening_m / 2, 0.0, 0.0])
    back = shifted(tilted(sheet, -lean), [opening_m / 2, 0.0, 0.0])
    both = merged([front, back])
    return shifted(both, [0.0, 0.0, -both.bounds[0, 2]])


@measured
def board_on_posts(
    width_m: float = 1.2, height_m: float = 0.8, center_height_m: float = 1.3, thickness_m: float = 0.004
) -> trimesh.Trimesh:
    """A board on the -x side of two posts, which end at its upper edge: an information board or an advertisement.

    Raises:
        ValueError: a measure that is not positive, or a board that reaches into the ground.
    """
    if center_height_m <= height_m / 2:
        raise ValueError(f"center_height_m must be above half the board {height_m / 2} m, got {center_height_m}")
    board = box([thickness_m, width_m, height_m], [0.0, 0.0, center_height_m])
    post, behind = cylinder(POLE_RADIUS_M, center_height_m + height_m / 2, 32), POLE_RADIUS_M + thickness_m / 2 + 0.005
    posts = [shifted(post, [behind, side * 0.4 * width_m, 0.0]) for side in (-1.0, 1.0)]
    return merged([board, *posts])


def random_sign(rng: np.random.Generator, name: str = "sign") -> Obstacle:
    """An A-frame, a low board on a pole (round, square, octagon or triangle), or a board on two posts.

    Boards on a pole are about 0.6 m wide, those on posts 0.9-1.4 m; all are sheets of 2-4 mm.
    """
    kind, thickness = rng.choice(["a-frame", "pole", "posts"], p=[0.35, 0.5, 0.15]), rng.uniform(0.002, 0.004)
    if kind == "a-frame":
        mesh = a_frame(rng.uniform(0.55, 0.7), rng.uniform(0.85, 1.15), rng.uniform(0.4, 0.6), thickness)
    elif kind == "posts":
        mesh = board_on_posts(rng.uniform(0.9, 1.4), rng.uniform(0.6, 0.9), rng.uniform(1.1, 1.5), thickness)
    else:
        shape = OUTLINES[rng.choice(len(OUTLINES), p=[0.35, 0.35, 0.15, 0.15])]
        mesh = pole_sign(rng.uniform(0.5, 0.7), rng.uniform(1.1, 1.5), shape, thickness)
    return Obstacle(mesh, Material.named("sign-sheet"), name, category="sign")
