"""How the cost of path search grows with triangles, obstacles, order and places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import trimesh

from benchmarks.cells.probes.speed.room import PATHS, SOUND_M_S, in_air, mirrors, paths_in, room, sources_m
from benchmarks.cells.probes.speed.timing import cpu_ms, require
from benchmarks.cells.spec import Cell
from simulator import Fidelity, Material, Obstacle, Paths

PLACES = 20
RADIUS_M, FAR_M, ECHO_M = 0.3, 2.0, 0.02
"""Of a ball, how far its middle is, and how much longer than twice the way to its skin an echo may be."""


def growth(cell: Cell, axis: str, values: Sequence[int]) -> tuple[dict[str, float], list[str]]:
    """Processor time a pair of source and microphone at each value of one of the `AXES`.

    Raises:
        ValueError: another axis, or a number of triangles that no ball has.
    """
    if axis not in AXES:
        raise ValueError(f"axis must be one of {sorted(AXES)}, got '{axis}'")
    found = {}
    for value in values:
        call = AXES[axis](value)
        found[f"{axis}_{value}_ms"] = cpu_ms(call, 3) / (2 * (value if axis == "places" else PLACES))
    return found, []


def _order(order: int) -> Callable[[], Paths]:
    return _mirrored(order, PLACES)


def _places(count: int) -> Callable[[], Paths]:
    return _mirrored(2, count)


def _mirrored(order: int, places: int) -> Callable[[], Paths]:
    """Paths off planes in a room."""
    call = partial(paths_in, room(), sources_m(places), mirrors(order))
    require(len(call()) == 2 * places * PATHS[order], f"a pair has not {PATHS[order]} paths of order {order}")
    return call


def _triangles(count: int) -> Callable[[], Paths]:
    times = round(np.log(count / 20.0) / np.log(4.0)) if count > 0 else 0
    if not (times >= 2 and count == 20 * 4**times):
        raise ValueError(f"triangles must be 20 times a power of 4, 320 or more, as a ball is divided, got {count}")
    call = _passing([trimesh.creation.icosphere(subdivisions=times, radius=RADIUS_M)])
    paths = call()
    excess = paths.delay_s * SOUND_M_S - 2.0 * (FAR_M - RADIUS_M)
    require(bool(np.any((paths.pose == 0) & (np.abs(excess) < ECHO_M))), "a ball has no echo")
    return call


def _obstacles(count: int) -> Callable[[], Paths]:
    """Posts to either side of the way."""
    places = [(0.5 * (k // 2) - 1.0, 1.0 if k % 2 else -1.0, 0.0) for k in range(count)]
    call = _passing([trimesh.creation.box([0.1, 0.1, 1.0]).apply_translation(place) for place in places])
    require({name for met in call().obstacles_met() for name in met} >= {"0", "1"}, "a post at the way is not met")
    return call


def _passing(meshes: list[trimesh.Trimesh]) -> Callable[[], Paths]:
    """Paths of first order on the way from 2 m before the origin to 1 m."""
    way = np.linspace([-FAR_M, 0.0, 0.0], [-1.0, 0.0, 0.0], PLACES)
    scene = in_air([Obstacle(mesh, Material.rigid(), str(k)) for k, mesh in enumerate(meshes)])
    return partial(paths_in, scene, way, Fidelity(max_order=1))


AXES = {"order": _order, "triangles": _triangles, "obstacles": _obstacles, "places": _places}
