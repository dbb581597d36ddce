"""The same wall by other triangles: slivers, flaws of meshes, a million facets, and sheets that nearly coincide."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.cells.probes.extremes.mirrors import AHEAD, against, echoes, image_lengths_m, slab
from benchmarks.cells.probes.extremes.verdict import Errors, Refusal, must_refuse
from obstaclewatch.support.arrays import Floats
from simulator import Material, Obstacle, Pose

Mesh = tuple[Floats, NDArray[np.intp]]
HALF_M, WALL_M = 4.0, 1.5
POSE = Pose(np.zeros(3), AHEAD)


def slivers(aspect: float) -> Errors:
    """A wall cut by slivers this many times longer than wide, one of them where the echo leaves it."""
    width = 2.0 * HALF_M / aspect
    return _mirror(*_sheet(np.array([-HALF_M, 0.0, width, 1.0, 1.0 + width, HALF_M]), np.array([-HALF_M, HALF_M])))


def triangles(count: int) -> Errors:
    """A wall of about that many triangles."""
    cuts = np.linspace(-HALF_M, HALF_M, max(2, round(np.sqrt(count / 2)) + 1))
    return _mirror(*_sheet(cuts, cuts))


def flaw(kind: str, seam_m: float) -> Errors | Refusal:
    """A wall of two halves that meet at y = seam, where 0 is the very place of the echo, with a flaw there."""
    if kind in IMPOSSIBLE:
        return must_refuse(lambda: _mirror(*FLAWS[kind](seam_m)), "mesh of 'wall' must", IMPOSSIBLE[kind])
    return _mirror(*FLAWS[kind](seam_m))


def crack(width_m: float, layout: str) -> Errors:
    """A wall with a crack of under 2 mm where the echo leaves it: an eighth of the wavelength takes nothing off it."""
    return _echo(*CRACKED[layout](0.5 * width_m))


def sheets(gap_m: float, distance_m: float) -> Errors:
    """Two open rigid sheets one behind the other: the front one echoes, and nothing passes it."""
    half = 4.0 * max(1.0, distance_m)
    cuts = np.array([-half, half])
    things = []
    for name, away in (("front", distance_m), ("back", distance_m + gap_m)):
        vertices, faces = _sheet(cuts, cuts)
        vertices[:, 0] = away
        things.append(Obstacle(trimesh.Trimesh(vertices, faces, process=False), Material.rigid(), name))
    found = echoes(things, POSE, 3.0 * distance_m + 1.0)
    return against(found, [0, 1], image_lengths_m(distance_m))


def _mirror(vertices: Floats, faces: NDArray[np.intp]) -> Errors:
    return _echo(Obstacle(trimesh.Trimesh(vertices, faces, process=False), Material.rigid(), "wall"))


def _echo(*obstacles: Obstacle) -> Errors:
    return against(echoes(obstacles, POSE, 5.0), [0, 1], image_lengths_m(WALL_M))


def _sheet(y_m: Floats, z_m: Floats) -> Mesh:
    """Two triangles for every cell of a grid in the plane of the wall, facing the phone."""
    rows, columns = len(z_m), len(y_m)
    vertices = np.stack([np.full(rows * columns, WALL_M), np.tile(y_m, rows), np.repeat(z_m, columns)], axis=1)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate([
        np.stack([corner, corner + columns, corner + 1], axis=1),
        np.stack([corner + 1, corner + columns, corner + columns + 1], axis=1),
    ])  # fmt: skip
    return vertices, faces


def _halves(seam_m: float) -> Mesh:
    return _sheet(np.array([-HALF_M, seam_m, HALF_M]), np.array([-HALF_M, 0.5, HALF_M]))


def _duplicate_faces(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    return vertices, np.concatenate([faces, faces[:3]])


def _all_inverted(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    return vertices, faces[:, ::-1]


def _one_inverted(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    faces[0] = faces[0, ::-1]
    return vertices, faces


def _inverted_twins(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    return vertices, np.concatenate([faces, faces[:, ::-1]])


def _degenerate_faces(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    flat = [[1, 1, 4], [0, 1, 2]]  # a point named twice, and three points in line
    return vertices, np.concatenate([faces, flat])


def _unmerged(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    return vertices[faces.ravel()], np.arange(3 * len(faces)).reshape(-1, 3)


def _t_junction(seam_m: float) -> Mesh:
    left, left_faces = _sheet(np.array([-HALF_M, seam_m]), np.array([-HALF_M, HALF_M]))
    right, right_faces = _sheet(np.array([seam_m, HALF_M]), np.array([-HALF_M, -0.3, 0.0, 0.7, HALF_M]))
    return np.concatenate([left, right]), np.concatenate([left_faces, right_faces + len(left)])


def _overlap(seam_m: float) -> Mesh:
    left, faces = _sheet(np.array([-HALF_M, seam_m + 0.5]), np.array([-HALF_M, HALF_M]))
    right, _ = _sheet(np.array([seam_m - 0.5, HALF_M]), np.array([-HALF_M, HALF_M]))
    return np.concatenate([left, right]), np.concatenate([faces, faces + len(left)])


def _loose_vertices(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    return np.concatenate([vertices, [[0.3, 0.0, 0.0], [1e6, 1e6, 1e6]]]), faces


def _not_finite(seam_m: float) -> Mesh:
    vertices, faces = _halves(seam_m)
    vertices[0, 0] = np.nan
    return vertices, faces


FLAWS: dict[str, Callable[[float], Mesh]] = {
    "none": _halves,
    "duplicate faces": _duplicate_faces,
    "all inverted": _all_inverted,
    "one inverted": _one_inverted,
    "inverted twins": _inverted_twins,
    "degenerate faces": _degenerate_faces,
    "vertices not merged": _unmerged,
    "T-junction": _t_junction,
    "overlap": _overlap,
    "loose vertices": _loose_vertices,
    "a vertex of NaN": _not_finite,
}
"""How a mesh may be flawed, to vertices and faces for a place of the seam."""
IMPOSSIBLE = {"a vertex of NaN": "got 1 of 9 with NaN"}
"""Flaws that no wall has, and what their error must say."""


def _cracked_sheets(half_m: float, right_z_m: Sequence[float] = (-HALF_M, HALF_M)) -> list[Obstacle]:
    """One mesh of two sheets; the right one may be cut where the left one is not."""
    left, faces = _sheet(np.array([-HALF_M, -half_m]), np.array([-HALF_M, HALF_M]))
    right, right_faces = _sheet(np.array([half_m, HALF_M]), np.array(right_z_m))
    mesh = trimesh.Trimesh(
        np.concatenate([left, right]), np.concatenate([faces, right_faces + len(left)]), process=False
    )
    return [Obstacle(mesh, Material.rigid(), "wall")]


def _slit(half_m: float) -> list[Obstacle]:
    """One sheet with a slit that ends within it."""
    cells = [([-HALF_M, -half_m], [-HALF_M, 1.0]), ([half_m, HALF_M], [-HALF_M, 1.0]),
             ([-HALF_M, -half_m, half_m, HALF_M], [1.0, HALF_M])]  # fmt: skip
    parts = [_sheet(np.array(y), np.array(z)) for y, z in cells]
    first = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = np.concatenate([own + start for (_, own), start in zip(parts, first, strict=False)])
    mesh = trimesh.Trimesh(np.concatenate([vertices for vertices, _ in parts]), faces, process=False)
    return [Obstacle(mesh, Material.rigid(), "wall")]


CRACKED: dict[str, Callable[[float], list[Obstacle]]] = {
    "two sheets": _cracked_sheets,
    "T-junction": lambda half: _cracked_sheets(half, [-HALF_M, -0.3, 0.0, 0.7, HALF_M]),
    "two boxes": lambda half: [slab([WALL_M, -HALF_M, -HALF_M], [WALL_M + 0.1, -half, HALF_M], "left"),
                               slab([WALL_M, half, -HALF_M], [WALL_M + 0.1, HALF_M, HALF_M], "right")],
    "a slit": _slit,
}  # fmt: skip
"""How a wall may be cracked, from half the width to obstacles."""
