"""From points on surfaces or edges, back through the mirrors on both sides to speaker and microphone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.images.image_method import MISSES, OUTSIDE, REACHED, crossed, straight
from simulator.images.image_pairs import Pairs
from simulator.world.candidates import Candidates, candidates, with_plane_normals
from simulator.world.rejection_log import Rejected
from simulator.world.search_context import Search


@dataclass(frozen=True)
class Turns:
    """R paths over K points of surfaces or edges, one after the other, with mirrors before and after them.

    Attributes:
        pairs: images of speaker and microphone, whose mirrors are met.
        point_m: (R, K, 3) where the surfaces or edges are met.
        reflector: (R, K) their numbers among the reflectors.
        known: (R, K, ...) what else is known of the surfaces there, by the name of the column of `Candidates`.
    """

    pairs: Pairs
    point_m: Floats
    reflector: Ints
    known: Mapping[str, NDArray] = field(default_factory=dict)

    def __getitem__(self, rows: Ints) -> Turns:
        known = {name: column[rows] for name, column in self.known.items()}
        return Turns(self.pairs[rows], self.point_m[rows], self.reflector[rows], known)


def unfolded(
    search: Search, turns: Turns, amplitude: Callable[[], Floats],
    arrives: Callable[[Candidates, Ints], Flags] | None = None,
) -> tuple[Candidates, Ints]:  # fmt: skip
    """Candidates all of whose mirrors are crossed inside their patches.

    Args:
        amplitude: (R,) estimated gains, asked for only to list what misses.
        arrives: which of some candidates that cross a mirror beside its patch, rows of the R, are kept all the same.

    Returns:
        The candidates, and which of the R they are.
    """
    sides = _ways(search, turns)
    code, hits = zip(*(crossed(search.tracing, *side) for side in sides), strict=True)
    worse = np.maximum(*code)
    ok, beside = np.flatnonzero(worse == REACHED), np.flatnonzero(worse == OUTSIDE)
    found = _assembled(search, turns[ok], hits[0][ok], hits[1][ok])
    if arrives is not None and len(beside):
        missing = straightened(search, turns, beside)
        kept = arrives(missing, beside)
        found, ok = Candidates.joined([found, missing[kept]]), np.append(ok, beside[kept])
        worse[beside[kept]] = REACHED
    for miss, reason in MISSES.items():
        rows = np.flatnonzero(worse == miss)
        search.reject(reason, len(rows), partial(_missed, search, turns, rows, amplitude))
    return found, ok


def straightened(search: Search, turns: Turns, rows: Ints) -> Candidates:
    """Candidates out of chosen rows whatever they miss: the mirrors are crossed as if they went on for ever."""
    chosen = turns[rows]
    sides = _ways(search, chosen)
    return _assembled(search, chosen, *(straight(search.tracing, *side)[0] for side in sides))


def _ways(search: Search, turns: Turns) -> list[tuple[Floats, Floats, Ints, Ints, Ints]]:
    """From speaker and microphone to the first and the last point: ends, poses, orders and sequences of mirrors."""
    pairs, tracing = turns.pairs, search.tracing
    ends = tracing.source_m[pairs.pose], tracing.mics_m[pairs.pose, pairs.mic]
    sides = zip(ends, (0, -1), (pairs.before, pairs.after), strict=True)
    return [(end, turns.point_m[:, k], pairs.pose, images.order, images.sequence) for end, k, images in sides]


def _missed(search: Search, turns: Turns, rows: Ints, amplitude: Callable[[], Floats]) -> Rejected:
    return Rejected(amplitude()[rows], lambda chosen: straightened(search, turns, rows[chosen]))


def _assembled(search: Search, turns: Turns, hits_before: Floats, hits_after: Floats) -> Candidates:
    """Candidates out of turning points and their mirrors' reflection points."""
    pairs, count, width = turns.pairs, len(turns.pairs), search.max_order
    sequence, hits = np.full((count, width), -1), np.zeros((count, width, 3))
    each, place, met = np.arange(count), pairs.before.order, turns.reflector.shape[1]
    mirrors, crossings = (pairs.before.sequence, pairs.after.sequence), (hits_before, hits_after)
    for side, rows, k, slot in pairs.mirror_slots(met):
        sequence[rows, slot], hits[rows, slot] = mirrors[side][rows, k], crossings[side][rows, k]
    for k in range(met):
        sequence[each, place + k], hits[each, place + k] = turns.reflector[:, k], turns.point_m[:, k]
    found = with_plane_normals(search.tracing, candidates(search.tracing, pairs.pose, pairs.mic, sequence, hits))
    columns = {name: getattr(found, name).copy() for name in turns.known}
    for name, column in columns.items():
        column[each[:, None], place[:, None] + np.arange(met)] = turns.known[name]
    return replace(found, **columns)
