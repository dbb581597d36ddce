"""A walk past a round post outdoors, between ground and wall, by this simulator and acoustic-spaces, in one run.

A post of many sides is round here and returns an echo from everywhere; there each side is a mirror of its own, and
between their beams is nothing. pyroomacoustics has rooms only.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import trimesh

from benchmarks.cells.probes.speed.peers import ROUNDING_M, acoustic_spaces
from benchmarks.cells.probes.speed.room import SOUND_M_S, in_air, paths_in
from benchmarks.cells.probes.speed.timing import cpu_ms, require
from benchmarks.cells.spec import Cell
from obstaclewatch.support.arrays import Floats
from simulator import Fidelity, Material, Obstacle

SIDES, RADIUS_M, HEIGHT_M = 64, 0.3, 2.6
MIDDLE_M = np.array([2.0, 0.0])
GROUND_M, WALL_M = np.array([[-5.0, -5.0], [9.0, 8.0]]), np.array([[-4.9, 3.0], [8.9, 3.1]])
WALL_HEIGHT_M = 3.0
FLATNESS_M = 2.0 * RADIUS_M * (1.0 - np.cos(np.pi / SIDES)) + ROUNDING_M
"""By which a path off the middle of a side is longer than one off the round post."""


def past_a_post(cell: Cell, order: int = 2, places: int = 50) -> tuple[dict[str, float], list[str]]:
    """Processor time a pair of source and microphone on the walk, and that of acoustic-spaces if it is there."""
    walls = {"ground": _block(GROUND_M, -0.1, 0.0), "wall": _block(WALL_M, 0.0, WALL_HEIGHT_M)}
    post = trimesh.creation.cylinder(radius=RADIUS_M, height=HEIGHT_M, sections=SIDES)
    post.apply_translation([*MIDDLE_M, 0.5 * HEIGHT_M])
    scene = in_air([Obstacle(mesh, Material.rigid(), name) for name, mesh in (walls | {"post": post}).items()])
    way = np.linspace([0.5, 1.5, 1.3], [3.5, 1.0, 1.3], places)
    fidelity = Fidelity(max_order=order, max_range_m=40.0, mechanisms=("specular", "curved"))
    paths, pairs = paths_in(scene, way, fidelity), [(n, m) for n in range(places) for m in (0, 1)]
    ours = [np.flatnonzero((paths.pose == n) & (paths.mic == m)) for n, m in pairs]
    met = paths.obstacles_met()
    require(all(any(met[row] == ("post",) for row in rows) for rows in ours), "the post has no echo at a place")
    walk_ms = cpu_ms(lambda: paths_in(scene, way, fidelity)) / len(pairs)
    if find_spec("acoustic_spaces") is None:
        return {"walk_ms": walk_ms}, ["acoustic_spaces"]
    lengths, pair_ms = acoustic_spaces(_outdoors(), way, order)
    for rows, theirs in zip(ours, lengths, strict=True):
        length_m = paths.delay_s[rows] * SOUND_M_S
        planar_m = length_m[["post" not in met[row] for row in rows]]
        require(_farthest(theirs, length_m) < FLATNESS_M, "acoustic_spaces has a path that we have not")
        require(_farthest(planar_m, theirs) < ROUNDING_M, "we have a path off planes that acoustic_spaces has not")
    return {"walk_ms": walk_ms, "acoustic_spaces_ms": pair_ms, "acoustic_spaces_ratio": pair_ms / walk_ms}, []


def _block(ends_m: Floats, bottom_m: float, top_m: float) -> trimesh.Trimesh:
    (x, y), (far_x, far_y) = ends_m
    return trimesh.creation.box(bounds=[[x, y, bottom_m], [far_x, far_y, top_m]])


def _outdoors() -> dict[str, object]:
    """The same as acoustic-spaces has it."""
    turn = 2.0 * np.pi * np.arange(SIDES) / SIDES
    around = MIDDLE_M + RADIUS_M * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return {
        "ground": {"extent": GROUND_M.tolist()},
        "buildings": [{"name": "post", "footprint": around.tolist(), "height": HEIGHT_M}],
        "barriers": [{"name": "wall", "path": [[x, WALL_M[0, 1]] for x in WALL_M[:, 0]], "height": WALL_HEIGHT_M}],
    }


def _farthest(some_m: Floats, others_m: Floats) -> float:
    """The greatest difference of any of some lengths from the nearest of others."""
    return float(np.abs(some_m[:, None] - others_m).min(axis=1).max(initial=0.0))
