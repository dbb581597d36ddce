"""Which paths over doubted bodies are left to Kirchhoff's integral: those whose rays err by too much together."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.distinct_rows import distinct
from simulator.images.image_pairs import Pairs, Taken, pairs_over
from simulator.kirchhoff.doubtful_bodies import Doubt
from simulator.kirchhoff.ray_errors import ray_error_db
from simulator.world.candidates import Candidates
from simulator.world.rejection_log import Choice
from simulator.world.search_context import Search

FEW = 8.0  # pairs that err by less than the tolerance over this stay rays
SHARED_FROM = 0.7  # of what is tolerated: from there to all of it rays and integral share an echo
CAUTION = 6.0  # on estimated errors: at 2, echoes of bins stayed 1.5-1.9 dB off where 0.5 dB was asked for


def left_to_integral(search: Search, doubts: list[Doubt], echoes: Candidates) -> list[Taken]:
    """What Kirchhoff's integral is needed for, body by body.

    All those over a body that rays say nothing of, and those whose rims and shadows spoil its echo. The log books what
    was chosen for surfaces, and the estimates behind it.

    Args:
        echoes: what the rays found.
    """
    taken: list[Taken] = []
    for doubt in doubts:
        pairs = pairs_over(search, doubt)
        body = Taken(pairs, np.ones(len(pairs)))
        if doubt.uneven:
            name = search.tracing.world.obstacles[doubt.obstacle].name
            search.log.choices.append(Choice(name, len(pairs), len(pairs), np.inf, 0.0))
        elif doubt.surface is not None:
            body = _spoilt(search, pairs, ray_error_db(search, doubt.surface, pairs, echoes))
        taken.append(body)
    return [body for body in taken if len(body.pairs)]


def _spoilt(search: Search, pairs: Pairs, error_db: Floats) -> Taken:
    """Pairs over a body that err (R,) by too much together, each with the reverse one: they share a mirror."""
    poses, tolerance_db, at = len(search.tracing.pose), search.fidelity.tolerance_db, (pairs.pose, pairs.mic)
    careful = CAUTION * error_db
    total = _together(poses, pairs, careful)
    share = _swapped_too(pairs, np.minimum(_over(total[at] / tolerance_db), _over(careful * FEW / tolerance_db)))
    left_db = np.where(share < 1.0, error_db, 0.0) * (1.0 - share)
    doubts = (_together(poses, pairs, each).max(initial=0.0) for each in (error_db, left_db))
    name = search.tracing.world.obstacles[pairs.obstacle].name
    search.log.choices.append(Choice(name, len(pairs), int((share > 0.0).sum()), *map(float, doubts)))
    return Taken(pairs, share)[np.flatnonzero(share)]


def _over(error: Floats) -> Floats:
    """Share of the integral where rays err by so much re what is tolerated: all from there on.

    A share that comes at once lets echoes of signs jump by up to -19 dB re a wall.
    """
    rise = np.clip((error - SHARED_FROM) / (1.0 - SHARED_FROM), 0.0, 1.0)
    found: Floats = rise * rise * (3.0 - 2.0 * rise)
    return found


def _together(poses: int, pairs: Pairs, error_db: Floats) -> Floats:
    """(N, 2) errors of all pairs over an obstacle, added up at each pose and microphone."""
    total = np.zeros((poses, 2))
    np.add.at(total, (pairs.pose, pairs.mic), error_db)
    return total


def _swapped_too(pairs: Pairs, share: Floats) -> Floats:
    """(R,) the greater of the shares of a pair and of that with the same mirrors in reverse."""
    sequences = np.concatenate([pairs.before.sequence, pairs.after.sequence])
    number = distinct(sequences)[1].reshape(2, -1)
    key = np.column_stack([pairs.pose, pairs.mic, number.min(axis=0), number.max(axis=0)])
    group = distinct(key)[1]
    greatest = np.zeros(group.max(initial=-1) + 1)
    np.maximum.at(greatest, group, share)
    return greatest[group]
