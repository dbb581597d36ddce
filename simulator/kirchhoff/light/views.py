"""Views of a body from images of the phone's transducers, and which of them follow one another along a walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.rows import Rows
from simulator.images.given_planes import image_in
from simulator.kirchhoff.illuminating_images import Sights
from simulator.world.world import Tracing


@dataclass(frozen=True)
class Views(Rows):
    """V images that ask what they see of a body.

    Attributes:
        start_m: (V, 3) where sound starts.
        image_m: (V, 3) its image.
        pose, side: (V,) and which of the points at a pose it is.
        order, sequence: (V,) and (V, N) mirrors from the start on, -1 padded.
    """

    start_m: Floats
    image_m: Floats
    pose: Ints
    side: Ints
    order: Ints
    sequence: Ints

    @classmethod
    def distinct(
        cls, tracing: Tracing, points_m: Floats, pose: Ints, point: Ints, mirrors: Sights
    ) -> tuple[Views, Ints]:
        """The views from points (N, P, 3) at poses (E,) through mirrors, each once, and (E,) which each is."""
        key = np.column_stack([pose, point, mirrors.sequence])
        rows, which = distinct(key)
        start = points_m[pose[rows], point[rows]]
        return cls.of(tracing, start, pose[rows], point[rows], mirrors.order[rows], mirrors.sequence[rows]), which

    @classmethod
    def of(cls, tracing: Tracing, start_m: Floats, pose: Ints, side: Ints, order: Ints, sequence: Ints) -> Views:
        """The views from points (V, 3) at poses."""
        return cls(start_m, image_in(tracing.mirrors, start_m, pose, order, sequence), pose, side, order, sequence)


@dataclass(frozen=True)
class Between:
    """Views between two others, from the same side through the same mirrors, of which everything is asked for.

    Attributes:
        before, after: (V,) these two; itself where a view is one of them.
    """

    before: Ints
    after: Ints

    @classmethod
    def of(cls, views: Views, run: Ints) -> Between:
        """Of each view at successive poses the first and the last, and those that begin a run of poses (N,)."""
        order = np.lexsort((views.pose, *views.sequence.T, views.side))
        place, pose = np.column_stack([views.side, views.sequence])[order], views.pose[order]
        begins = np.ones(len(order) + 1, dtype=bool)
        begins[1:-1] = (place[1:] != place[:-1]).any(axis=1) | (np.diff(pose) != 1)
        in_full = begins[:-1] | begins[1:]
        in_full[1:] |= np.diff(run[pose]) != 0
        known, row = np.flatnonzero(in_full), np.arange(len(order))
        before, after = np.empty_like(order), np.empty_like(order)
        before[order] = order[known[np.searchsorted(known, row, side="right") - 1]]
        after[order] = order[known[np.searchsorted(known, row)]]
        return cls(before, after)

    @property
    def in_turn(self) -> tuple[Ints, Ints]:
        """The views of which everything is asked for, and the others."""
        in_full = self.before == np.arange(len(self.before))
        return np.flatnonzero(in_full), np.flatnonzero(~in_full)

    def in_doubt(self, known: Flags, view: Ints, item: Ints) -> Flags:
        """(R,) whether items (R,) have to be asked for in views (R,); the others are filled in, in (V, I) `known`."""
        found: Flags = _in_doubt(self.before, self.after, known, view, item)  # type: ignore[call-arg]
        return found


@compiled
def _in_doubt(before, after, known, view, item):
    """`Between.in_doubt`."""
    doubt = np.ones(len(view), np.bool_)
    for r in range(len(view)):
        v, i = view[r], item[r]
        if before[v] != v and known[before[v], i] == known[after[v], i]:
            known[v, i], doubt[r] = known[before[v], i], False
    return doubt
