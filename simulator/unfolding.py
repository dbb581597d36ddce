"""From a point on a surface or edge, back through the mirrors on both sides to speaker and microphone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulator import specular
from simulator.candidates import Candidates, candidates, with_plane_normals
from simulator.ledger import Ledger, Turned
from simulator.planar import MISSES, crossed, straight
from simulator.world import Tracing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    """R ways that turn at one point of a surface or edge each, with mirrors before and after it.

    Attributes:
        mic: microphone at which they end.
        before, after: mirrors from the speaker and from the microphone on.
        point_m: (R, 3) where the surface or edge is met.
        reflector: (R,) its number in the sequence of reflectors.
        width: reflections kept for each path.
    """

    mic: int
    before: Mirrors
    after: Mirrors
    point_m: Floats
    reflector: Ints
    width: int


def unfolded(
    tracing: Tracing, turns: Turns, ledger: Ledger, amplitude: Callable[[], Floats]
) -> tuple[Candidates, Ints, Ints]:
    """Candidates all of whose mirrors are crossed inside their patches.

    Args:
        ledger: of what misses a patch.
        amplitude: (R,) estimated gains, asked for only to list what misses.

    Returns:
        The candidates, which of the R they are, and the slot of the turning point in their sequences.
    """
    before, after, point = turns.before, turns.after, turns.point_m
    source, mics = tracing.source_m[before.pose], tracing.mics_m[before.pose, turns.mic]
    code_before, hits_before = crossed(tracing, source, point, before.pose, before.order, before.sequence)
    code_after, hits_after = crossed(tracing, mics, point, after.pose, after.order, after.sequence)
    code = np.maximum(code_before, code_after)
    for miss, name in MISSES.items():
        rows = np.flatnonzero(code == miss)
        ledger.turn_away(name, len(rows), partial(_missed, tracing, turns, rows, amplitude))
    ok = np.flatnonzero(code == specular.REACHED)
    return _assembled(tracing, turns, ok, hits_before[ok], hits_after[ok]), ok, before.order[ok]


def straightened(tracing: Tracing, turns: Turns, rows: Ints) -> Candidates:
    """Candidates out of chosen rows whatever they miss: the mirrors are crossed as if they went on for ever."""
    hits = []
    for end, mirrors in ((tracing.source_m, turns.before), (tracing.mics_m[:, turns.mic], turns.after)):
        pose, order, sequence = mirrors.pose[rows], mirrors.order[rows], mirrors.sequence[rows]
        hits.append(straight(tracing, end[pose], turns.point_m[rows], pose, order, sequence)[0])
    return _assembled(tracing, turns, rows, *hits)


def _missed(tracing: Tracing, turns: Turns, rows: Ints, amplitude: Callable[[], Floats]) -> Turned:
    return Turned(amplitude()[rows], lambda chosen: straightened(tracing, turns, rows[chosen]))


def _assembled(tracing: Tracing, turns: Turns, rows: Ints, hits_before: Floats, hits_after: Floats) -> Candidates:
    """Candidates out of chosen rows and their mirrors' reflection points."""
    before, after = turns.before, turns.after
    sequence, hits = np.full((len(rows), turns.width), -1), np.zeros((len(rows), turns.width, 3))
    each, place, late_order = np.arange(len(rows)), before.order[rows], after.order[rows]
    for k in range(turns.width - 1):
        early = np.flatnonzero(place > k)
        sequence[early, k], hits[early, k] = before.sequence[rows[early], k], hits_before[early, k]
        late = np.flatnonzero(late_order > k)
        slot = place[late] + late_order[late] - k  # mirrors behind the point are met in reverse
        sequence[late, slot], hits[late, slot] = after.sequence[rows[late], k], hits_after[late, k]
    sequence[each, place], hits[each, place] = turns.reflector[rows], turns.point_m[rows]
    found = candidates(tracing, before.pose[rows], np.full(len(rows), turns.mic), sequence, hits)
    return with_plane_normals(tracing, found)
