"""Bodies heard by Kirchhoff's integral, with mirrors before and after them.

As for curved surfaces, a mirror only moves the point that the body sees. The integral runs over the facets lit from
both sides.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Ints
from simulator.curved.single import Images
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.kirchhoff.image_pairs import Pairs
from simulator.kirchhoff.integral import Cells, scattered
from simulator.kirchhoff.lighting import lit_facets
from simulator.surfaces.facets import Facets
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates, joined
from simulator.world.frames import into_rest, out_of_rest, turned
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

CELL_SHARE = 1e-3  # of the strongest: at 2 % the echoes of people moved by 1.7 dB
COSINES = 257  # of incidence, between which the reflection is interpolated


def scattered_paths(search: Search, facets: Facets, pairs: Pairs) -> tuple[Candidates, Complexes]:
    """Paths over an obstacle heard as a whole, and (M, K) gains of it; `cell` names the row.

    Args:
        pairs: the ways that are wanted.
    """
    tracing, wavenumber = search.tracing, search.band_wavenumber_1_m
    parts, gains, first = [], [], 0
    material = tracing.world.obstacles[facets.obstacle].material
    reflection = material.reflection(search.band_hz, np.linspace(0.0, 1.0, COSINES)[:, None])
    for mic in range(2):
        some = pairs[pairs.mic == mic]
        frame = tracing.placed[some.pose, facets.obstacle]
        ends = into_rest(some.before.point_m, frame), into_rest(some.after.point_m, frame)
        seen = lit_facets(tracing, facets, tracing.source_m, some.before)
        seen &= lit_facets(tracing, facets, tracing.mics_m[:, mic], some.after)
        cells = scattered(facets, *ends, seen, wavenumber, reflection)
        loud = _loud(cells, some.pose[cells.pair], search.audible)
        _reject_faint(search, facets, mic, some.before, some.after, cells[~loud])
        cells = cells[loud]
        parts.append(_over_body(search, facets, mic, some.before, some.after, cells, first))
        gains.append(cells.gain)
        first += len(cells)
    return joined(parts), np.concatenate(gains)


def _loud(cells: Cells, pose: Ints, audible: Audible) -> Flags:
    """(M,) cells that are not too long, and not lost under the noise or under the body's strongest.

    Cells cancel down to a third of the loudest and lower between echoes, whatever is asked of the edges: those left
    out must stay far below it.
    """
    kept = replace(audible, share=min(audible.share, CELL_SHARE))
    gain = np.abs(cells.gain).max(axis=1, initial=0.0)
    strongest = np.zeros(pose.max(initial=-1) + 1)
    np.maximum.at(strongest, pose, gain)
    return (cells.length_m <= audible.limit_m) & kept(gain, strongest[pose])


def _turns(tracing: Tracing, facets: Facets, mic: int, before: Images, after: Images, cells: Cells) -> Turns:
    """Ways through the facets that stand for cells."""
    before, after = before[cells.pair], after[cells.pair]
    point = out_of_rest(facets.middle_m[cells.facet], tracing.placed[before.pose, facets.obstacle])
    number = np.full(len(cells), tracing.world.numbering.number(Interaction.KIRCHHOFF, facets.obstacle))
    return Turns(mic, before, after, point[:, None], number[:, None])


def _reject_faint(search: Search, facets: Facets, mic: int, before: Images, after: Images, cells: Cells) -> None:
    turns = _turns(search.tracing, facets, mic, before, after, cells)
    amplitude = np.abs(cells.gain).max(axis=1, initial=0.0)
    search.reject(Reason.FAINT_CELL, len(cells), lambda: Rejected(amplitude, partial(straightened, search, turns)))


def _over_body(
    search: Search, facets: Facets, mic: int, before: Images, after: Images, cells: Cells, first: int
) -> Candidates:
    """Candidates through the facet that stands for each cell."""
    turns = _turns(search.tracing, facets, mic, before, after, cells)
    found, ok, place = unfolded(search, turns, lambda: np.abs(cells.gain).max(axis=1, initial=0.0))
    normal = turned(facets.normal[cells.facet[ok]], search.tracing.placed[found.pose, facets.obstacle, 3])
    each = np.arange(len(ok))
    arriving = np.sum(normal * (found.points_m[each, place + 1] - found.points_m[each, place]), axis=1)
    normal = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    found = found.with_reflection(place, normal=normal, lift_m=facets.lift_m[cells.facet[ok]])
    return replace(found, cell=first + ok)
