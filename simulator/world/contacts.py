"""Where a sharp edge is free: not buried in another surface, and not run into one.

The lower edge of a box on the ground is no wedge: with the ground it makes a corner (`corners`), whose echo the mirrors
know. An upright edge that stands on the ground has no corner there: its image in the ground continues it. One that
leans makes a corner with its image, and ends there. What moves apart is no contact: it touches at one instant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.repeated import repeated
from obstaclewatch.support.vectors import dot, norm
from simulator.surfaces.near_balls import touching
from simulator.surfaces.reflectors import PlanarPatches
from simulator.surfaces.wedges import Wedges
from simulator.world.corners import STANDS_ON_M, STEEP, leaning_ends
from simulator.world.mirrors import Planes
from simulator.world.visibility import Blocker

CELL_M, MAX_CELLS = 0.1, 64  # what touches an edge between two places this far apart may be missed if it is a sheet
HALVINGS = 20  # of such a cell: 0.1 um
ROUNDED_M = 1e-4  # an edge that ends this close to a mirror ends on it
APART_M = 0.01  # by which bodies that move past each other are taken on: what still touches then stays in touch
SHARES = (0.11, 0.37, 0.63, 0.89)  # of the open angle, off the multiples of 30 degrees at which other faces lie

Blocked = Callable[[Ints, Floats, Floats], Flags]
"""(R,) whether anything that can touch an edge of an obstacle (R,) stands between two points (R, 3)."""


def exposed(
    wedges: Wedges, blockers: tuple[Blocker, ...], velocity_m_s: Floats, carried: Flags, patches: PlanarPatches,
    at_rest: Planes,
) -> Wedges:  # fmt: skip
    """The free stretches of wedges, and whether their ends are corners.

    Args:
        wedges: as recognised, body by body, where they stand at time 0.
        blockers: everything that stands there.
        velocity_m_s: (O, 3) of obstacles.
        carried: (O,) obstacles that go with the walker: they touch nothing but themselves.
        patches: mirrors that stand there.
        at_rest: the same, to be asked which may follow which.
    """
    if len(wedges) == 0:
        return wedges
    blocked = partial(_blocked, blockers, velocity_m_s, carried)
    row, low, high = _free_stretches(wedges, blocked)
    whole, cut = wedges[row], np.stack([low > 0.0, high < 1.0], axis=1)
    low, high = _ending_on_mirrors(whole, np.stack([low, high], axis=1), cut, patches).T
    stretch = replace(whole, start_m=_place(whole, low), end_m=_place(whole, high))
    runs_on = cut | np.stack([_runs_on(stretch, end, blocked) for end in (0, 1)], axis=1)
    leans_on = leaning_ends(stretch, runs_on, patches, at_rest, carried)
    return replace(stretch, radiates=~runs_on | (leans_on >= 0), leans_on=leans_on)


def _free_stretches(wedges: Wedges, blocked: Blocked) -> tuple[Ints, Floats, Floats]:
    """(F,) wedge of every stretch that no surface touches, and the shares of its length from which to which it runs."""
    cells = np.clip(np.ceil(wedges.length_m / CELL_M), 3, MAX_CELLS).astype(np.int64)
    row, place = repeated(cells)
    beside = 2.0 * _radius_m(wedges)[row] / wedges.length_m[row]  # at its very end an edge may stand on something
    near, far = (np.clip((place + end) / cells[row], beside, 1.0 - beside) for end in (0, 1))
    both = np.concatenate([near, far]), np.concatenate([far, near])
    onwards, back = np.split(_reach(wedges[np.tile(row, 2)], *both, blocked), 2)
    low, high = np.where(near <= beside, 0.0, near), np.where(far >= 1.0 - beside, 1.0, far)
    some, rest = onwards > near, back < far
    row = np.concatenate([row[some], row[rest]])
    low, high = np.concatenate([low[some], back[rest]]), np.concatenate([onwards[some], high[rest]])
    return _joined(row, low, high)


def _joined(row: Ints, low: Floats, high: Floats) -> tuple[Ints, Floats, Floats]:
    """Runs of one row each, from `low` to `high` (R,), with those that meet or overlap in one."""
    order = np.lexsort((low, row))
    row, low, high = row[order], low[order], high[order]
    first = np.append(True, (np.diff(row) != 0) | (low[1:] > high[:-1]))[: len(row)]
    last = np.append(first[1:], True)[: len(row)]
    return row[first], low[first], high[last]


def _reach(wedges: Wedges, start: Floats, end: Floats, blocked: Blocked) -> Floats:
    """(R,) share of the length up to which an edge is free, from one share towards another."""
    free, met = start.copy(), end.copy()
    open_ = ~_met(wedges, start, end, blocked)
    free[open_] = end[open_]
    rows = np.flatnonzero(~open_ & ~_touched(wedges, start, blocked))
    some = wedges[rows]
    for _ in range(HALVINGS):
        middle = 0.5 * (free[rows] + met[rows])
        beyond = _met(some, start[rows], middle, blocked)
        met[rows], free[rows] = np.where(beyond, middle, met[rows]), np.where(beyond, free[rows], middle)
    return free


def _met(wedges: Wedges, start: Floats, end: Floats, blocked: Blocked) -> Flags:
    """(R,) whether a surface touches an edge at one share of its length, or stands across it from another on."""
    before, there = _circuit(wedges, start), _circuit(wedges, end)
    return _any_blocked(wedges, [*there[:-1], *before], [*there[1:], *there], blocked)


def _touched(wedges: Wedges, share: Floats, blocked: Blocked) -> Flags:
    """(R,) whether a surface crosses the open side next to a place on the edge."""
    stops = _circuit(wedges, share)
    return _any_blocked(wedges, stops[:-1], stops[1:], blocked)


def _circuit(wedges: Wedges, share: Floats) -> list[Floats]:
    """(R, 3) points about places on edges, from one face to the other; on thin plates the last, inside, is left out."""
    furthest = np.where(np.isinf(wedges.sheet_m), SHARES[-1], SHARES[-2]) * wedges.free_angle_rad
    angles = (np.minimum(part * wedges.free_angle_rad, furthest) for part in SHARES)
    return [_place(wedges, share) + _radius_m(wedges)[:, None] * wedges.direction_at(angle) for angle in angles]


def _any_blocked(wedges: Wedges, start: list[Floats], end: list[Floats], blocked: Blocked) -> Flags:
    """(R,) whether anything stands between some of the points (R, 3) of circuits."""
    obstacle = np.tile(wedges.obstacle, len(start))
    hit = blocked(obstacle, np.concatenate(start), np.concatenate(end))
    return np.logical_or.reduce(hit.reshape(len(start), len(wedges)), axis=0)


def _ending_on_mirrors(wedges: Wedges, share: Floats, cut: Flags, patches: PlanarPatches) -> Floats:
    """(W, 2) shares of the length; those that are cut off (W, 2) within `ROUNDED_M` of a mirror end on it."""
    moved, (row, end) = share.copy(), np.nonzero(cut)
    point, along = _place(wedges[row], share[row, end]), wedges.along[row]

    def gap_and_cosine(at: Ints, patch: Ints) -> tuple[Floats, Floats]:
        normal = patches.normal[patch]
        return patches.offset_m[patch] - dot(point[at], normal), dot(along[at], normal)

    def close(at: Ints, patch: Ints) -> Flags:
        gap, cosine = gap_and_cosine(at, patch)
        return (np.abs(cosine) > STEEP) & (np.abs(gap) <= ROUNDED_M * np.abs(cosine))

    at, patch = touching((point, np.full(len(point), ROUNDED_M)), (patches.center_m, patches.radius_m), close)
    step = np.divide(*gap_and_cosine(at, patch))
    nearest_last = np.argsort(-np.abs(step), kind="stable")
    row, end = row[at[nearest_last]], end[at[nearest_last]]
    moved[row, end] = share[row, end] + step[nearest_last] / wedges.length_m[row]
    return moved


def _place(wedges: Wedges, share: Floats) -> Floats:
    """(W, 3) points of edges, at shares (W,) of their length."""
    return wedges.start_m + share[:, None] * (wedges.end_m - wedges.start_m)


def _radius_m(wedges: Wedges) -> Floats:
    """(W,) of the circuit on which what touches an edge is looked for."""
    return np.minimum(STANDS_ON_M, 0.1 * wedges.length_m)


def _runs_on(wedges: Wedges, end: int, blocked: Blocked) -> Flags:
    """(R,) whether a surface stands across the edge at its start (0) or end (1)."""
    radius = _radius_m(wedges)[:, None]
    corner = (wedges.end_m if end else wedges.start_m) + radius * wedges.direction_at(0.5 * wedges.free_angle_rad)
    reach = 2.0 * radius * wedges.along
    return blocked(wedges.obstacle, corner - reach, corner + reach)


def _blocked(
    blockers: tuple[Blocker, ...], velocity_m_s: Floats, carried: Flags, obstacle: Ints, start: Floats, end: Floats
) -> Flags:
    """(R,) whether anything that stays in touch with an edge of an obstacle (R,) stands between two points."""
    hit = np.zeros(len(obstacle), dtype=bool)
    for shadow in blockers:
        rows = np.flatnonzero(carried[obstacle] == carried[shadow.obstacle])
        rows = rows[shadow.blocks(start[rows], end[rows])]
        drift = velocity_m_s[obstacle[rows]] - velocity_m_s[shadow.obstacle]
        speed = norm(drift)
        past, on = rows[speed > 0.0], APART_M * drift[speed > 0.0] / speed[speed > 0.0, None]
        hit[rows[speed == 0.0]] = True
        hit[past] |= shadow.blocks(start[past] + on, end[past] + on)
    return hit
