"""Image sources in planar patches as candidates."""

from __future__ import annotations

from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.images import image_method as specular
from simulator.images.image_tree import Goal, image_levels, in_turn
from simulator.world.candidates import Candidates, candidates, with_plane_normals
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

MISSES = {specular.BEHIND: Reason.BEHIND_PATCH, specular.OUTSIDE: Reason.OUTSIDE_PATCH}


def planar(search: Search) -> Candidates:
    """Image sources in planar patches; what falls beside its patches is rejected."""
    tracing = search.tracing
    where, sequence, hits, counts = _reached(tracing, search.max_order, search.limit_m, search.log.listed > 0)
    code = where[:, 3]
    for miss, reason in MISSES.items():
        rows = np.flatnonzero(code == miss)
        search.reject(reason, counts[miss], partial(_missed, tracing, where[rows], sequence[rows]))
    rows = np.flatnonzero(code == specular.REACHED)
    found = candidates(tracing, where[rows, 0], where[rows, 1], sequence[rows], hits[rows])
    return with_plane_normals(tracing, found)


def _reached(tracing: Tracing, max_order: int, limit_m: float, keep_missed: bool) -> tuple[Ints, Ints, Floats, Ints]:
    """Every sequence of patches that carries sound from the speaker to a microphone, walls transparent.

    Returns:
        where: (R, 4) pose, microphone, order, code; sequence: (R, max_order), -1 padded; hits: (R, max_order, 3);
        counts: (3,) sequences REACHED, BEHIND and OUTSIDE, kept or not.
    """
    mirrors, mics = tracing.mirrors, np.ascontiguousarray(tracing.mics_m)
    spread = float(np.linalg.norm(mics - mics[:, :1], axis=2).max())
    parts, counts = [], np.zeros(3, dtype=np.int64)
    every = np.ones(len(tracing.world.patches), dtype=bool)
    for level in image_levels(mirrors, every, tracing.source_m, max_order, Goal(mics[:, 0], spread, limit_m)):
        if level.order == 0:
            continue
        found, hits, codes = specular.heard(
            mirrors, level.order, level.pose, level.sequence, level.images_m, mics, limit_m, keep_missed
        )  # type: ignore[call-arg]
        row, mic, code = found.T
        where = np.column_stack([level.pose[row], mic, np.full(len(row), level.order), code])
        parts.append((where, level.sequence[row], hits))
        counts += codes
    where, sequence, hits = (np.concatenate(column) for column in zip(*parts, strict=True))
    rows = in_turn(where[:, 0], sequence)
    return where[rows], sequence[rows], hits[rows], counts


def _missed(tracing: Tracing, where: Ints, sequence: Ints) -> Rejected:
    """Sequences that miss a patch; their level is that of the image, as if the patches went on for ever."""
    source, mic = tracing.source_m[where[:, 0]], tracing.mics_m[where[:, 0], where[:, 1]]
    hits, length = straight(tracing, source, mic, where[:, 0], where[:, 2], sequence)

    def chosen(index: Ints) -> Candidates:
        found = candidates(tracing, where[index, 0], where[index, 1], sequence[index], hits[index])
        return with_plane_normals(tracing, found)

    return Rejected(1.0 / length, chosen)


def crossed(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Ints, Floats]:
    """(R,) code and (R, N, 3) reflection points of given sequences from starts to targets."""
    ends = np.ascontiguousarray(start_m), np.ascontiguousarray(target_m)
    return specular.crossings(tracing.mirrors, *ends, pose, order, sequence)  # type: ignore[call-arg]


def straight(
    tracing: Tracing, start_m: Floats, target_m: Floats, pose: Ints, order: Ints, sequence: Ints
) -> tuple[Floats, Floats]:
    """(R, N, 3) where unfolded ways cross their planes, inside the patches or not, and (R,) their lengths."""
    ends = np.ascontiguousarray(start_m), np.ascontiguousarray(target_m)
    return specular.straight_crossings(tracing.mirrors, *ends, pose, order, sequence)  # type: ignore[call-arg]
