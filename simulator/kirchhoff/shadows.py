"""Partial shadows: where something hides a part of the zone round a reflection point that makes the echo.

A ray is there or hidden as its point is. Its echo comes from the first Fresnel zone round it, of radius
sqrt(wavelength l m / (l + m)) at distances l and m of both ends: a pole that hides a strip of the zone takes a part of
the echo of a plate behind it, and all of the ray only if it stands on the point.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.vectors import dot, norm, unit
from simulator.world.candidates import Candidates
from simulator.world.world import Tracing

SPOKES, RINGS = 16, 10  # of the zone: directions, and places along each
HALVINGS = 6  # of the way between two of them, where a border of the shadow runs
KNOWN_TO = 3e-3  # of the zone: halving leaves 2.7e-3 if all borders are off; at the foot of a post it was 1.2e-3


def hidden_share(tracing: Tracing, found: Candidates, slot: Ints, wavenumber: float) -> Floats:
    """(C,) how far the shadow over the zone round reflection point `slot` (C,) is from all or nothing, 0 to 1.

    It changes no faster than the border of the shadow moves: where an estimate came and went by spots of the zone, the
    integral took over from rays at once, and echoes of signs jumped by up to -27 dB re a wall.
    """
    each, at = np.arange(len(found)), slot + 1
    ends = found.points_m[each, at - 1], found.points_m[each, at + 1]
    point, normal = found.points_m[each, at], found.normal[each, slot]
    l, m = (norm(end - point) for end in ends)
    radius = np.sqrt(2.0 * np.pi / wavenumber * l * m / np.maximum(l + m, 1e-300))
    lifted = point + (found.standoff_m[each, slot] + tracing.world.clear_m)[:, None] * normal
    spokes, sides = radius[:, None, None] * _spokes(normal), _planes_beside(found, slot)

    def counted(row: Ints, spoke: Ints, reach: Floats) -> Flags:
        return _this_side(sides, row, lifted[row] + reach[:, None] * spokes[row, spoke])

    def seen(row: Ints, spoke: Ints, reach: Floats) -> Flags:
        place = lifted[row] + reach[:, None] * spokes[row, spoke]
        return _this_side(sides, row, place) & _seen(tracing, found.pose[row], [end[row] for end in ends], place)

    share = _covered(seen, len(found)) / np.maximum(_covered(counted, len(found)), 1e-300)
    return np.maximum(2.0 * np.minimum(share, 1.0 - share) - KNOWN_TO, 0.0)


def _covered(there: Callable[[Ints, Ints, Floats], Flags], count: int) -> Floats:
    """(C,) share of a disc in which something is there: asked at rows, spokes and radii (R,), borders by halving.

    Towards its border the disc counts less and less, as (1 - radius^2)^2.
    """
    shape = count, SPOKES, RINGS
    row, spoke, ring = (axis.ravel() for axis in np.indices(shape))
    known = there(row, spoke, (ring + 0.5) / RINGS).reshape(shape)
    border = np.broadcast_to(np.arange(RINGS + 1) / RINGS, (count, SPOKES, RINGS + 1)).copy()
    row, spoke, ring = np.nonzero(known[..., 1:] != known[..., :-1])
    before, step = known[row, spoke, ring], 0.5 / RINGS
    for _ in range(HALVINGS):
        step *= 0.5
        here = border[row, spoke, ring + 1]
        border[row, spoke, ring + 1] += np.where(there(row, spoke, here) == before, step, -step)
    inside = np.diff(1.0 - (1.0 - border**2) ** 3, axis=2)
    share: Floats = (known * inside).sum(axis=(1, 2)) / SPOKES
    return share


def _spokes(normal: Floats) -> Floats:
    """(C, SPOKES, 3) unit vectors in the tangent plane."""
    helper = np.where(np.abs(normal[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    east = unit(np.cross(normal, helper))
    angle = (2.0 * np.pi / SPOKES * np.arange(SPOKES))[:, None]
    return np.cos(angle) * east[:, None] + np.sin(angle) * np.cross(normal, east)[:, None]


def _planes_beside(found: Candidates, slot: Ints) -> list[tuple[Flags, Floats, Floats]]:
    """Of what is met just before and just after reflection point `slot`, flat or curved: (C,) whether anything is, (C,
    3) normals of its tangent plane that point to where the reflection point lies, and (C, 3) points on the plane.

    Beyond a mirror the zone goes on over the obstacle's image in it, which the path that meets the mirror on the other
    side makes up for.
    """
    each, sides = np.arange(len(found)), []
    for step in (-1, 1):
        other = np.clip(slot + step, 0, found.normal.shape[1] - 1)
        met = (slot + step == other) & (other < found.order)
        normal, on_it = found.normal[each, other], found.points_m[each, other + 1]
        above = dot(normal, found.points_m[each, slot + 1] - on_it)
        sides.append((met, np.where(above < 0.0, -1.0, 1.0)[:, None] * normal, on_it))
    return sides


def _this_side(sides: list[tuple[Flags, Floats, Floats]], row: Ints, place: Floats) -> Flags:
    """(R,) whether places of rows (R,) lie before the planes beside them, as the reflection point does."""
    before = np.ones(len(row), dtype=bool)
    for met, normal, on_it in sides:
        before &= ~met[row] | (dot(normal[row], place - on_it[row]) >= 0.0)
    return before


def _seen(tracing: Tracing, pose: Ints, ends: list[Floats], place: Floats) -> Flags:
    """(C,) whether nothing stands between a place and both ends."""
    free = np.ones(len(pose), dtype=bool)
    for shadow in tracing.world.blockers:
        frame = tracing.placed[:, shadow.obstacle]
        for end in ends:
            free &= ~shadow.blocks_from(end, place, frame, pose, free)
    return free
