"""Image sources in planar patches as candidates."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from simulator import specular
from simulator.candidates import Candidates, candidates, with_plane_normals
from simulator.ledger import Ledger, Turned
from simulator.world import Tracing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MISSES = {specular.BEHIND: "behind a patch", specular.OUTSIDE: "outside its patch"}


def planar(tracing: Tracing, max_order: int, limit_m: float, ledger: Ledger) -> Candidates:
    """Image sources in planar patches, up to `max_order`; what falls beside its patches is turned away."""
    world = tracing.world
    where, sequence, hits, counts = specular.planar_paths(
        tracing.source_m, tracing.mics_m, tracing.placed,
        *specular.arrays(world.patches), world.follows, max_order, limit_m, ledger.listed > 0,
    )  # type: ignore[call-arg]  # fmt: skip
    code = where[:, 3]
    for miss, name in MISSES.items():
        rows = np.flatnonzero(code == miss)
        ledger.turn_away(name, counts[miss], partial(_missed, tracing, where[rows], sequence[rows]))
    rows = np.flatnonzero(code == specular.REACHED)
    found = candidates(tracing, where[rows, 0], where[rows, 1], sequence[rows], hits[rows])
    return with_plane_normals(tracing, found)


def _missed(tracing: Tracing, where: Ints, sequence: Ints) -> Turned:
    """Sequences that miss a patch; their level is that of the image, as if the patches went on for ever."""
    source, mic = tracing.source_m[where[:, 0]], tracing.mics_m[where[:, 0], where[:, 1]]
    hits, length = straight(tracing, source, mic, where[:, 0], where[:, 2], sequence)

    def chosen(index: Ints) -> Candidates:
        found = candidates(tracing, where[index, 0], where[index, 1], sequence[index], hits[index])
        return with_plane_normals(tracing, found)

    return Turned(1.0 / length, chosen)


def crossed(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Ints, Floats]:
    """(R,) code and (R, N, 3) reflection points of given sequences from starts to targets."""
    return specular.crossings(*_given(tracing, start_m, target_m, pose, order, sequence))  # type: ignore[call-arg]


def straight(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Floats, Floats]:
    """(R, N, 3) where unfolded ways cross their planes, inside the patches or not, and (R,) their lengths."""
    return specular.straight_crossings(*_given(tracing, start_m, target_m, pose, order, sequence))  # type: ignore[call-arg]


def _given(tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints) -> tuple:
    ends = np.ascontiguousarray(start_m), np.ascontiguousarray(target_m)
    return *ends, tracing.placed, pose, order, sequence, *specular.arrays(tracing.world.patches)
