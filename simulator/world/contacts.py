"""Where a sharp edge is free: not buried in another surface, and not run into one.

The lower edge of a box on the ground is no wedge: with the ground it makes a corner (`corners`), whose echo the mirrors
know. An upright edge that stands on the ground has no corner there: its image in the ground continues it. One that
leans makes a corner with its image, and ends there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats
from simulator.surfaces.reflectors import PlanarPatches
from simulator.surfaces.wedges import Wedges
from simulator.world.corners import TOUCHING_M, leaning_ends
from simulator.world.visibility import Blocker

CIRCUIT_M = TOUCHING_M  # a surface this close to an edge touches it
CELL_M, MAX_CELLS = 0.1, 64
SHARES = (0.11, 0.37, 0.63, 0.89)  # of the open angle, off the multiples of 30 degrees at which other faces lie


def exposed(wedges: Wedges, blockers: tuple[Blocker, ...], carried: Flags, patches: PlanarPatches) -> Wedges:
    """The free stretches of wedges, and whether their ends are corners.

    Args:
        wedges: as recognised, body by body, where they stand at time 0.
        blockers: everything that stands there.
        carried: (O,) obstacles that go with the walker: they touch nothing but themselves.
        patches: mirrors that stand there.
    """
    if len(wedges) == 0:
        return wedges
    cells = np.clip(np.ceil(wedges.length_m / CELL_M), 3, MAX_CELLS).astype(np.int64)
    owner = np.repeat(np.arange(len(wedges)), cells)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(cells) - cells, cells)
    share = (place + 0.5) / cells[owner]
    free = ~_touched(wedges[owner], share, blockers, carried)
    before = free & (place > 0) & np.concatenate([[False], free[:-1]])
    after = free & (place < cells[owner] - 1) & np.concatenate([free[1:], [False]])
    first, last = np.flatnonzero(free & ~before), np.flatnonzero(free & ~after)
    stretch = wedges[owner[first]]
    low, high = place[first] / cells[owner[first]], (place[last] + 1) / cells[owner[last]]
    along = stretch.end_m - stretch.start_m
    corner = np.stack([low == 0.0, high == 1.0], axis=1)
    runs_on = corner & np.stack([_runs_on(stretch, end, blockers, carried) for end in (0, 1)], axis=1)
    leans_on = leaning_ends(stretch, runs_on, patches, carried)
    corner &= ~runs_on | (leans_on >= 0)
    return Wedges(
        stretch.start_m + low[:, None] * along, stretch.start_m + high[:, None] * along, stretch.inwards,
        stretch.normal, stretch.open_angle_rad, stretch.patch, stretch.obstacle, stretch.sheet_m, corner,
        stretch.mirror, leans_on,
    )  # fmt: skip


def _touched(wedges: Wedges, share: Floats, blockers: tuple[Blocker, ...], carried: Flags) -> NDArray:
    """(R,) whether a surface crosses the open side next to a place on the edge."""
    point = wedges.start_m + share[:, None] * (wedges.end_m - wedges.start_m)
    radius = np.minimum(CIRCUIT_M, 0.1 * wedges.length_m)
    stops = [point + radius[:, None] * _open_direction(wedges, part) for part in SHARES]
    touched = np.zeros(len(wedges), dtype=bool)
    for k in range(len(SHARES) - 1):
        step = _blocked(wedges, stops[k], stops[k + 1], blockers, carried)
        touched |= step & ((k < len(SHARES) - 2) | np.isinf(wedges.sheet_m))  # the last is inside a thin plate
    return touched


def _runs_on(wedges: Wedges, end: int, blockers: tuple[Blocker, ...], carried: Flags) -> NDArray:
    """(R,) whether a surface stands across the edge at its start (0) or end (1)."""
    along = (wedges.end_m - wedges.start_m) / wedges.length_m[:, None]
    radius = np.minimum(CIRCUIT_M, 0.1 * wedges.length_m)[:, None]
    corner = (wedges.end_m if end else wedges.start_m) + radius * _open_direction(wedges, 0.5)
    reach = 2.0 * radius * along
    return _blocked(wedges, corner - reach, corner + reach, blockers, carried)


def _open_direction(wedges: Wedges, share: float) -> Floats:
    """(W, 3) unit vectors off the edge at a share of the angle without images."""
    angle = share * wedges.free_angle_rad[:, None]
    return np.cos(angle) * wedges.inwards + np.sin(angle) * wedges.normal


def _blocked(wedges: Wedges, start: Floats, end: Floats, blockers: tuple[Blocker, ...], carried: Flags) -> Flags:
    """(R,) whether anything that can touch the wedge's body stands between two points."""
    hit = np.zeros(len(wedges), dtype=bool)
    for shadow in blockers:
        rows = np.flatnonzero(carried[wedges.obstacle] == carried[shadow.obstacle])
        if len(rows):
            hit[rows] |= shadow.blocks(start[rows], end[rows])
    return hit
