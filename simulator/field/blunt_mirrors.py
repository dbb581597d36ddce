"""What planes that end at rounded edges return of the rays off them: the field through an opening of their outline.

A sharp edge diffracts by itself, and its waves make up for the mirror path that ends there. The face of a wheel has no
such edge: its border passes into a smooth surface. Seen unfolded, such a mirror is an opening in a screen, and what an
opening lets through and a screen of the same outline (`outlines`) leaves are the free field together (Babinet). So a
ray off the face fades over its border, and has what is left of it beside the face.

As one of several mirrors; what a body returns by itself past such a border is left to Kirchhoff's integral.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.vectors import norm
from simulator.field.outlines import behind_outlines, reach_at
from simulator.field.unfolded_segments import at_rest, segments_of
from simulator.world.candidates import Candidates
from simulator.world.search_context import Search


def off_blunt_mirrors(search: Search, found: Candidates, frequency_hz: Floats) -> Complexes:
    """(C, K) gain of each path at K frequencies, re that with all its mirrors without end (`images.image_method`)."""
    world, placed = search.tracing.world, search.tracing.placed
    factor = np.ones((len(found), len(frequency_hz)), dtype=np.complex128)
    row, slot = np.nonzero(world.is_blunt(found.sequence) & (found.edge < 0)[:, None] & (found.cell < 0)[:, None])
    if not len(row):
        return factor
    paths, which = np.unique(row, return_inverse=True)
    segments = segments_of(found[paths])
    before = np.searchsorted(segments.ray, which) + slot  # the segment that ends on the mirror
    after_m = norm(segments.end_m[before + 1] - segments.start_m[before + 1])
    straight = segments.taken(before)
    straight = straight._replace(
        ray=np.arange(len(row)),
        end_m=straight.end_m + after_m[:, None] * straight.ahead,
        facing=np.zeros((len(row), 2, 3)),
    )
    patch = found.sequence[row, slot]
    seen = at_rest(straight, placed[found.pose[row], world.patches.obstacle[patch]])
    number = np.searchsorted(np.flatnonzero(world.blunt), patch)
    left = behind_outlines(
        world.blunt_screens, number, seen, search.wavenumbers_1_m(frequency_hz), reach_at(search.wavenumber_1_m)
    )
    np.multiply.at(factor, row, 1.0 - left)
    return factor
