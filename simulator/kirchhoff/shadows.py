"""Partial shadows: where something hides a part of the zone round a reflection point that makes the echo.

A ray is there or hidden as its point is. Its echo comes from the first Fresnel zone round it, of radius
sqrt(wavelength l m / (l + m)) at distances l and m of both ends: a pole that hides a strip of the zone takes a part of
the echo of a plate behind it, and all of the ray only if it stands on the point.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.world.candidates import Candidates
from simulator.world.world import Tracing

RINGS, SPOKES = (0.35, 0.7, 1.0), 8  # of the zone's radius, and directions in which it is asked


def hidden_share(tracing: Tracing, found: Candidates, slot: Ints, wavenumber: float) -> Floats:
    """(C,) how far the shadow over the zone round reflection point `slot` (C,) is from all or nothing, 0 to 1."""
    each, at = np.arange(len(found)), slot + 1
    ends = found.points_m[each, at - 1], found.points_m[each, at + 1]
    point, normal = found.points_m[each, at], found.normal[each, slot]
    l, m = (np.linalg.norm(end - point, axis=1) for end in ends)
    radius = np.sqrt(2.0 * np.pi / wavenumber * l * m / np.maximum(l + m, 1e-300))
    lifted = point + (found.standoff_m[each, slot] + tracing.world.clear_m)[:, None] * normal
    places = [lifted + spot for spot in _spots(normal, radius)]
    counted = np.stack([_this_side(found, slot, place) for place in places], axis=1)
    counted[:, 0] = True
    seen = np.stack([_seen(tracing, found.pose, ends, place) for place in places], axis=1)
    share = (seen & counted).sum(axis=1) / counted.sum(axis=1)
    return 2.0 * np.minimum(share, 1.0 - share)


def _spots(normal: Floats, radius: Floats) -> list[Floats]:
    """Offsets (C, 3) of the places that are asked: the point itself, then ring by ring in the tangent plane."""
    helper = np.where(np.abs(normal[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    east = np.cross(normal, helper)
    east /= np.maximum(np.linalg.norm(east, axis=1, keepdims=True), 1e-300)
    north = np.cross(normal, east)
    turns = 2.0 * np.pi * np.arange(SPOKES) / SPOKES
    around = [np.cos(turn) * east + np.sin(turn) * north for turn in turns]
    return [np.zeros_like(normal)] + [(ring * radius)[:, None] * spoke for ring in RINGS for spoke in around]


def _this_side(found: Candidates, slot: Ints, place: Floats) -> Flags:
    """(C,) whether a place lies before the mirrors met just before and after, as the reflection point does.

    Beyond them the zone goes on over the obstacle's image in them, which the path that meets the mirror on the other
    side makes up for.
    """
    each, before = np.arange(len(found)), np.ones(len(found), dtype=bool)
    for step in (-1, 1):
        other = np.clip(slot + step, 0, found.normal.shape[1] - 1)
        mirror = (slot + step == other) & (other < found.order)
        normal, on_it = found.normal[each, other], found.points_m[each, other + 1]
        here = np.sum(normal * (found.points_m[each, slot + 1] - on_it), axis=1)
        before &= ~mirror | (here * np.sum(normal * (place - on_it), axis=1) >= 0.0)
    return before


def _seen(tracing: Tracing, pose: Ints, ends: tuple[Floats, Floats], place: Floats) -> Flags:
    """(C,) whether nothing stands between a place and both ends."""
    free = np.ones(len(pose), dtype=bool)
    for shadow in tracing.world.blockers:
        frame = tracing.placed[:, shadow.obstacle]
        for end in ends:
            free &= ~shadow.blocks_from(end, place, frame, pose, free)
    return free
