"""Views of a body from images of the phone's transducers, and which of them follow one another along a walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import norm
from simulator.images.given_planes import image_in
from simulator.images.image_method import nearest_border_m
from simulator.kirchhoff.illuminating_images import Sights
from simulator.surfaces.facets import Facets
from simulator.world.frames import into_rest
from simulator.world.world import Tracing

PAST_BORDER = 0.02  # of the distance from a mirror's border: how far apart transducers may be to share an answer


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
    def distinct(cls, tracing: Tracing, facets: Facets, sights: Sights, alike: float) -> tuple[Views, Ints]:
        """The views of a body that images (E,) have, each once, and (E,) which each is; those alike share one.

        Args:
            alike: how far apart transducers may be for that, re their distance from the body's box.
        """
        start, first = _asked_from(tracing, facets, sights, alike)
        rows, which = distinct(np.column_stack([sights.pose, first, sights.sequence]))
        kept, sequence = sights.pose[rows], sights.sequence[rows]
        return cls.of(tracing, start[rows], kept, first[rows], sights.order[rows], sequence), which

    @classmethod
    def of(cls, tracing: Tracing, start_m: Floats, pose: Ints, side: Ints, order: Ints, sequence: Ints) -> Views:
        """The views from points (V, 3) at poses."""
        return cls(start_m, image_in(tracing.mirrors, start_m, pose, order, sequence), pose, side, order, sequence)


def _asked_from(tracing: Tracing, facets: Facets, sights: Sights, alike: float) -> tuple[Floats, Ints]:
    """(E, 3) where light is asked from for each image: the middle of its transducer and those alike; (E,) the first.

    Of the body its nearest part counts: 0.9 m before a car's bonnet its centre is 3 m off. A border of a mirror on the
    way shifts what is seen of the body by more: 1.3 m past a wall's, a shared answer moved an echo of a bin by 6.5 dB.
    """
    transducers, frame = tracing.transducers_m, tracing.placed[:, facets.obstacle]
    seen_from = into_rest(tracing.middle_m, frame)
    in_box = np.clip(seen_from, facets.middle_m.min(axis=0), facets.middle_m.max(axis=0))
    border = nearest_border_m(tracing.mirrors, tracing.middle_m, sights.pose, sights.sequence)  # type: ignore[call-arg]
    reach = np.minimum(alike * norm(seen_from - in_box)[sights.pose], PAST_BORDER * border)
    apart = norm(transducers[:, :, None] - transducers[:, None])
    together, each = apart[sights.pose] <= reach[:, None, None], np.arange(len(reach))
    first = together[each, sights.side].argmax(axis=1)
    group = together[each, first, :, None]
    return (group * transducers[sights.pose]).sum(axis=1) / group.sum(axis=1), first


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
