"""From points on surfaces or edges, back through the mirrors on both sides to speaker and microphone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.images.image_method import MISSES, REACHED, crossed, straight
from simulator.world.candidates import Candidates, candidates, with_plane_normals
from simulator.world.rejection_log import Rejected
from simulator.world.search_context import Search


class Mirrors(Protocol):
    """Sequences of mirrors at poses: (R,) pose, (R,) order, (R, N) patches from the end on, -1 padded."""

    @property
    def pose(self) -> Ints: ...

    @property
    def order(self) -> Ints: ...

    @property
    def sequence(self) -> Ints: ...


@dataclass(frozen=True)
class Turns:
    """R paths over K points of surfaces or edges, one after the other, with mirrors before and after them.

    Attributes:
        mic: microphone at which they end.
        before, after: mirrors from the speaker and from the microphone on.
        point_m: (R, K, 3) where the surfaces or edges are met.
        reflector: (R, K) their numbers among the reflectors.
    """

    mic: int
    before: Mirrors
    after: Mirrors
    point_m: Floats
    reflector: Ints


def unfolded(search: Search, turns: Turns, amplitude: Callable[[], Floats]) -> tuple[Candidates, Ints, Ints]:
    """Candidates all of whose mirrors are crossed inside their patches.

    Args:
        amplitude: (R,) estimated gains, asked for only to list what misses.

    Returns:
        The candidates, which of the R they are, and the slot of the first turning point in their sequences.
    """
    tracing, before, after = search.tracing, turns.before, turns.after
    source, mics = tracing.source_m[before.pose], tracing.mics_m[before.pose, turns.mic]
    code_before, hits_before = crossed(tracing, source, turns.point_m[:, 0], before.pose, before.order, before.sequence)
    code_after, hits_after = crossed(tracing, mics, turns.point_m[:, -1], after.pose, after.order, after.sequence)
    code = np.maximum(code_before, code_after)
    for miss, reason in MISSES.items():
        rows = np.flatnonzero(code == miss)
        search.reject(reason, len(rows), partial(_missed, search, turns, rows, amplitude))
    ok = np.flatnonzero(code == REACHED)
    return _assembled(search, turns, ok, hits_before[ok], hits_after[ok]), ok, before.order[ok]


def straightened(search: Search, turns: Turns, rows: Ints) -> Candidates:
    """Candidates out of chosen rows whatever they miss: the mirrors are crossed as if they went on for ever."""
    tracing, hits = search.tracing, []
    ends = (tracing.source_m, turns.before, 0), (tracing.mics_m[:, turns.mic], turns.after, -1)
    for end, mirrors, turn in ends:
        pose, order, sequence = mirrors.pose[rows], mirrors.order[rows], mirrors.sequence[rows]
        hits.append(straight(tracing, end[pose], turns.point_m[rows, turn], pose, order, sequence)[0])
    return _assembled(search, turns, rows, *hits)


def _missed(search: Search, turns: Turns, rows: Ints, amplitude: Callable[[], Floats]) -> Rejected:
    return Rejected(amplitude()[rows], lambda chosen: straightened(search, turns, rows[chosen]))


def _assembled(search: Search, turns: Turns, rows: Ints, hits_before: Floats, hits_after: Floats) -> Candidates:
    """Candidates out of chosen rows and their mirrors' reflection points."""
    before, after = turns.before, turns.after
    width = search.max_order
    sequence, hits = np.full((len(rows), width), -1), np.zeros((len(rows), width, 3))
    each, place, late_order = np.arange(len(rows)), before.order[rows], after.order[rows]
    met = turns.reflector.shape[1]
    for k in range(before.sequence.shape[1]):
        early = np.flatnonzero(place > k)
        sequence[early, k], hits[early, k] = before.sequence[rows[early], k], hits_before[early, k]
        late = np.flatnonzero(late_order > k)
        slot = place[late] + met - 1 + late_order[late] - k  # mirrors behind the points are met in reverse
        sequence[late, slot], hits[late, slot] = after.sequence[rows[late], k], hits_after[late, k]
    for k in range(met):
        sequence[each, place + k], hits[each, place + k] = turns.reflector[rows, k], turns.point_m[rows, k]
    found = candidates(search.tracing, before.pose[rows], np.full(len(rows), turns.mic), sequence, hits)
    return with_plane_normals(search.tracing, found)
