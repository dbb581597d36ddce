"""Sound that four or five edges of a thin panel diffract: what is left over where shorter chains nearly cancel.

Within some ten degrees of edge-on the first three orders add up to a tenth of each or less, and the next two to as
much as that. The sixth is a tenth of the fifth or less (plates of 0.2-0.45 m).

Of the edges met, the first and the last keep their windows and the ones between count over their full length: the
gains of these paths, their lengths taken off, are still smooth over the band (from eight nodes the fourth order comes
to 2e-3, the fifth, which is a tenth of it, to 4e-2). A chain is followed as long as it may be audible, and an order as
long as it may change what fewer edges of the panel add up to: well off edge-on it does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints, SingleComplexes
from simulator.diffraction.edge_integrals import Face, met, passed_on

Kept = Callable[[Floats], Flags]

LONGEST = 5  # edges in one chain
# how much louder than the loudest chain of one edge less, with the same first or last part, a chain is at most: of 180
# random plates and phones four exceed one of these, by up to 30 %
FOURTH_OF_THIRD, FIFTH_OF_FOURTH = 2.0, 1.0
# the same of orders, by their greatest magnitudes over the band; p_4 / p_3 is also at most SHRINKING times
# p_3 / p_2. Of 115 random plates of 5 to 90 cm four exceed one of these, by up to 30 %
WHOLE_FOURTH, WHOLE_FIFTH, SHRINKING = 0.5, 0.2, 1.5
NEGLIGIBLE = 2e-3  # 0.02 dB; what was left out on those plates comes to less than half of it


@dataclass(frozen=True)
class Order:
    """Chains of one order at one microphone, by L parts (edge and window) met first and L met last.

    Attributes:
        pressure: (L, E, E, L, D, K), the two edges after the first behind it; of five edges the one before the last
            behind that, D = E, of four D = 1. With the travel phase; 0 where not worked out.
        known: (L, L) what was worked out.
        bound: (L, L) no chain is louder.
        counts: whether it may change the panel's echo; if not, nothing was worked out.
    """

    pressure: Complexes
    known: Flags
    bound: Floats
    counts: bool


def longer_chains(
    face: Face, before: SingleComplexes, after: list[SingleComplexes], third: list[Complexes],
    lower: list[Complexes], kept: list[Kept], longest: int, negligible: float = NEGLIGIBLE,
) -> list[list[Order]]:  # fmt: skip
    """The fourth and, up to `longest`, the fifth order at each of M microphones.

    Args:
        before: (N, E, W, K, T) what the speaker sends to the nodes over one edge.
        after: M times the same from a microphone.
        third: M times (E, W, E, W, E, W, K) p_3.
        lower: M times (3, K) all that one, two and three edges diffract.
        kept: M times which of some magnitudes are loud enough.
        negligible: share of what fewer edges add up to; an order bounded by less is not followed.
    """
    sent, caught = _flat(before), [_flat(each) for each in after]
    bounds = [FOURTH_OF_THIRD * _between(*_loudest(np.abs(each).max(axis=-1))) for each in third]
    counts = [_fourth_counts(each, negligible) for each in lower]
    wanted = [loud(bound) & each for loud, bound, each in zip(kept, bounds, counts, strict=True)]
    first = np.flatnonzero(np.any(wanted, axis=(0, 2)))
    ahead = passed_on(face, sent[:, first]), first
    out = []
    for m, half in enumerate(caught):
        last = np.flatnonzero(wanted[m].any(axis=0))
        orders = [_order(face, ahead, (half[:, last, None], last), wanted[m], bounds[m], counts[m])]
        if longest > 4:
            top = orders[0].bound
            bound = FIFTH_OF_FOURTH * _between(top.max(axis=1), top.max(axis=0))
            more = counts[m] and _fifth_counts(lower[m], orders[0], negligible)
            loud = kept[m](bound) & more
            last = np.flatnonzero(loud.any(axis=0))
            orders.append(_order(face, ahead, (passed_on(face, half[:, last]), last), loud, bound, more))
        out.append(orders)
    return out


def _fourth_counts(lower: Complexes, negligible: float) -> bool:
    """Whether the fourth order may change the sum of three (3, K)."""
    second, third = np.abs(lower[1:]).max(axis=1)
    bound = third * min(WHOLE_FOURTH, SHRINKING * third / max(second, 1e-300))
    return bool(bound >= negligible * np.abs(lower.sum(axis=0)).max())


def _fifth_counts(lower: Complexes, fourth: Order, negligible: float) -> bool:
    """Whether the fifth order may change the sum of four."""
    total = fourth.pressure.sum(axis=(0, 1, 2, 3, 4))
    return bool(WHOLE_FIFTH * np.abs(total).max() >= negligible * np.abs(lower.sum(axis=0) + total).max())


def _flat(half: SingleComplexes) -> SingleComplexes:
    """(N, P D, K, T) of (N, P, D, K, T)."""
    return half.reshape(len(half), half.shape[1] * half.shape[2], *half.shape[3:])


def _loudest(third: Floats) -> tuple[Floats, Floats]:
    """(L,) greatest magnitudes of (E, W, E, W, E, W) by the part met first, and by the one met last."""
    parts = third.shape[0] * third.shape[1]
    flat = third.reshape(parts, -1, parts)
    return flat.max(axis=(1, 2)), flat.max(axis=(0, 1))


def _between(first: Floats, last: Floats) -> Floats:
    """(L, L) the lesser of what runs on from the first part and what reaches the last one."""
    return np.minimum(first[:, None], last)


def _order(
    face: Face,
    ahead: tuple[SingleComplexes, Ints],
    behind: tuple[SingleComplexes, Ints],
    wanted: Flags,
    bound: Floats,
    counts: bool,
) -> Order:
    """What meets on one more edge, from (N, P, D, K, T) halves by parts P and the D edges after them."""
    (before, first), (after, last) = ahead, behind
    edges, beside, parts = np.arange(len(face.linked)), np.arange(after.shape[2]), np.arange(len(bound))
    shape = len(first), before.shape[2], len(edges), len(last), len(beside), len(face.wavenumber)
    out = np.zeros((len(parts), len(edges), len(edges), len(parts), *shape[4:]), dtype=np.complex128)
    sums = met(face, _flat(before), _flat(after))
    out[np.ix_(first, edges, edges, last, beside)] = sums.reshape(shape)
    return Order(out, wanted, np.where(wanted, np.abs(out).max(axis=(1, 2, 4, 5)), bound), counts)
