"""Which rays run over pairs of images that Kirchhoff's integral may take instead, and what it leaves them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from simulator.images.image_pairs import Pairs, Taken
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing


def beside_integral(search: Search, taken: list[Taken], found: Candidates) -> Candidates:
    """Candidates by any mechanism with what the integral leaves them; the log books those of which nothing is left."""
    if not taken:
        return found
    met, share = search.tracing.world.obstacle_of(found.sequence), found.share.copy()
    for body in taken:
        rows = np.flatnonzero((met == body.pairs.obstacle).any(axis=1))
        rays, numbers = _numbered(search.tracing, found[rows], body.pairs)
        of_number = np.zeros(max(rays.max(initial=-1), numbers.max(initial=-1)) + 1)
        of_number[numbers] = body.share
        share[rows] *= 1.0 - of_number[rays]
    rows = np.flatnonzero(share == 0.0)
    search.reject(
        Reason.LEFT_TO_INTEGRAL, len(rows),
        lambda: Rejected(found[rows].trusted_amplitude, lambda chosen: found[rows[chosen]]),
    )  # fmt: skip
    return replace(found, share=share)[share > 0.0]


def loudest_over(tracing: Tracing, found: Candidates, amplitude: Floats, pairs: Pairs) -> Floats:
    """(R,) greatest amplitude (C,) of the candidates that run over each pair; 0 without one."""
    rays, numbers = _numbered(tracing, found, pairs)
    loudest = np.zeros(max(rays.max(initial=0), numbers.max(initial=0)) + 1)
    np.maximum.at(loudest, rays, amplitude)
    return loudest[numbers]


def _numbered(tracing: Tracing, found: Candidates, pairs: Pairs) -> tuple[Ints, Ints]:
    """(C,) and (R,) numbers of the images that candidates and pairs run over; equal ones have equal numbers.

    Whatever a path meets of the pairs' body is the body. The faces of others are the mirrors that pairs know.
    """
    world = tracing.world
    body = world.numbering.number(Interaction.KIRCHHOFF, pairs.obstacle)
    met = np.where(world.obstacle_of(found.sequence) == pairs.obstacle, body, found.sequence)
    path = np.column_stack([found.pose, found.mic, met])
    every = np.concatenate([path, _sequences_of(tracing, pairs, found.sequence.shape[1])])
    number = distinct(every)[1]
    return number[: len(found)], number[len(found) :]


def _sequences_of(tracing: Tracing, pairs: Pairs, width: int) -> Ints:
    """(R, 2 + width) pose, microphone and the reflectors met in order, -1 padded."""
    sequence = np.full((len(pairs), width), -1)
    for side, rows, k, slot in pairs.mirror_slots(1):
        sequence[rows, slot] = (pairs.before, pairs.after)[side].sequence[rows, k]
    body = tracing.world.numbering.number(Interaction.KIRCHHOFF, pairs.obstacle)
    sequence[np.arange(len(pairs)), pairs.before.order] = body
    return np.column_stack([pairs.pose, pairs.mic, sequence])
