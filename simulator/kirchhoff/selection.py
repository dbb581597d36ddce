"""Which paths over doubted bodies are left to Kirchhoff's integral: those whose rays err by too much together."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from simulator.images.image_pairs import Pairs, pairs_over
from simulator.kirchhoff.doubtful_bodies import Doubt
from simulator.kirchhoff.ray_errors import ray_error_db
from simulator.world.candidates import Candidates
from simulator.world.rejection_log import Choice
from simulator.world.search_context import Search

FEW = 8.0  # pairs that err by less than the tolerance over this stay rays
CAUTION = 6.0  # on estimated errors: at 2, echoes of bins stayed 1.5-1.9 dB off where 0.5 dB was asked for


def left_to_integral(search: Search, doubts: list[Doubt], echoes: Candidates) -> list[Pairs]:
    """Pairs of images over bodies that Kirchhoff's integral is needed for, body by body.

    All those over a body that rays say nothing of, and those whose rims and shadows spoil its echo. The log books what
    was chosen for surfaces, and the estimates behind it.

    Args:
        echoes: what the rays found.
    """
    taken = []
    for doubt in doubts:
        pairs = pairs_over(search, doubt, search.max_order)
        if doubt.uneven:
            name = search.tracing.world.obstacles[doubt.obstacle].name
            search.log.choices.append(Choice(name, len(pairs), len(pairs), np.inf, 0.0))
        elif doubt.surface is not None:
            pairs = _spoilt(search, pairs, ray_error_db(search, doubt.surface, pairs, echoes))
        taken.append(pairs)
    return [pairs for pairs in taken if len(pairs)]


def _spoilt(search: Search, pairs: Pairs, error_db: Floats) -> Pairs:
    """Pairs over a body that err (R,) by too much together, each with the reverse one: they share a mirror."""
    poses, tolerance_db, at = len(search.tracing.pose), search.fidelity.tolerance_db, (pairs.pose, pairs.mic)
    careful = CAUTION * error_db
    total = _together(poses, pairs, careful)
    spoilt = _swapped_too(pairs, (total[at] > tolerance_db) & (careful > tolerance_db / FEW))
    doubts = (_together(poses, pairs, each).max(initial=0.0) for each in (error_db, np.where(spoilt, 0.0, error_db)))
    name = search.tracing.world.obstacles[pairs.obstacle].name
    search.log.choices.append(Choice(name, len(pairs), int(spoilt.sum()), *map(float, doubts)))
    return pairs[spoilt]


def _together(poses: int, pairs: Pairs, error_db: Floats) -> Floats:
    """(N, 2) errors of all pairs over an obstacle, added up at each pose and microphone."""
    total = np.zeros((poses, 2))
    np.add.at(total, (pairs.pose, pairs.mic), error_db)
    return total


def _swapped_too(pairs: Pairs, chosen: Flags) -> Flags:
    """(R,) the chosen pairs and those with the same mirrors in reverse."""
    sequences = np.concatenate([pairs.before.sequence, pairs.after.sequence])
    number = np.unique(sequences, axis=0, return_inverse=True)[1].reshape(2, -1)
    key = np.column_stack([pairs.pose, pairs.mic, number.min(axis=0), number.max(axis=0)])
    group = np.unique(key, axis=0, return_inverse=True)[1].ravel()
    any_chosen = np.zeros(group.max(initial=-1) + 1, dtype=bool)
    np.logical_or.at(any_chosen, group, chosen)
    return any_chosen[group]
