"""From a point on a surface or edge, back through the mirrors on both sides to speaker and microphone."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from simulator import specular
from simulator.candidates import Candidates, candidates, count_missed, with_plane_normals
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


def unfolded(
    tracing: Tracing, mic: int, before: Mirrors, after: Mirrors, point_m: Floats, reflector: Ints, width: int,
    rejected: dict[str, int],
) -> tuple[Candidates, Ints, Ints]:  # fmt: skip
    """Candidates that meet given points between their mirrors, all crossed inside their patches.

    Args:
        before, after: R mirrors from the speaker and from the microphone on.
        point_m: (R, 3) where the surface or edge is met.
        reflector: (R,) its number in the sequence of reflectors.
        width: reflections kept for each path.

    Returns:
        The candidates, which of the R they are, and the slot of the point in their sequences.
    """
    pose = before.pose
    code_before, hits_before = _crossings(tracing, tracing.source_m[pose], point_m, before)
    code_after, hits_after = _crossings(tracing, tracing.mics_m[pose, mic], point_m, after)
    code = np.maximum(code_before, code_after)
    count_missed(rejected, int((code == specular.BEHIND).sum()), int((code == specular.OUTSIDE).sum()))
    ok = np.flatnonzero(code == specular.REACHED)
    sequence, hits = np.full((len(ok), width), -1), np.zeros((len(ok), width, 3))
    each, place = np.arange(len(ok)), before.order[ok]
    for k in range(width - 1):
        early = np.flatnonzero(place > k)
        sequence[early, k], hits[early, k] = before.sequence[ok[early], k], hits_before[ok[early], k]
        late = np.flatnonzero(after.order[ok] > k)
        slot = place[late] + after.order[ok[late]] - k  # mirrors behind the point are met in reverse
        sequence[late, slot], hits[late, slot] = after.sequence[ok[late], k], hits_after[ok[late], k]
    sequence[each, place], hits[each, place] = reflector[ok], point_m[ok]
    found = candidates(tracing, pose[ok], np.full(len(ok), mic), sequence, hits)
    return with_plane_normals(tracing, found), ok, place


def _crossings(tracing: Tracing, start_m: Floats, target_m: Floats, mirrors: Mirrors) -> tuple[Ints, Floats]:
    return specular.crossings(
        np.ascontiguousarray(start_m), np.ascontiguousarray(target_m), tracing.placed, mirrors.pose, mirrors.order,
        mirrors.sequence, *specular.arrays(tracing.world.patches),
    )  # type: ignore[call-arg]  # fmt: skip
