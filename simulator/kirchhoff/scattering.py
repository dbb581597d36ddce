"""Echoes of bodies by Kirchhoff's integral, with mirrors before and after them.

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
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.image_pairs import Pairs
from simulator.kirchhoff.integral import Cells, scattered
from simulator.kirchhoff.lighting import Light, Sights, lit_spots, spots_of
from simulator.scene.fidelity import Fidelity
from simulator.surfaces.facets import Facets
from simulator.surfaces.reflectors import MeshReading
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates, joined
from simulator.world.frames import into_rest, out_of_rest, rotated
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

CELL_SHARE_A_DB, CELL_SHARES = 8e-3, (1e-3, 1.5e-2)  # of the strongest that may be left out, by tolerance
FINE_SPOT_M, SPOT_M, COARSE_SPOT_M = 0.015, 0.02, 0.032  # under FINE_DB of tolerance, under COARSE_DB, and from there
FINE_DB, COARSE_DB = 0.3, 1.0
HELD, COARSE_HELD = 0.2, 0.4  # of the body's distance: 0.05 changes echoes of people by 0.1 dB at P95
PLATE_FACET_M = 0.012  # coarser, and in coarser light, the shadow of a sign's post on its plate errs by 2-5 dB
COSINES = 257  # of incidence, between which the reflection is interpolated


def scattered_paths(search: Search, facets: Facets, pairs: Pairs) -> tuple[Candidates, Complexes]:
    """Paths over an obstacle by Kirchhoff's integral, and (M, K) gains of it; `cell` names the row.

    Args:
        pairs: the image pairs that are wanted.
    """
    tracing, wavenumber = search.tracing, search.band_wavenumber_1_m
    pairs = pairs[np.lexsort((pairs.mic, pairs.pose))]
    material = tracing.world.obstacles[facets.obstacle].material
    reflection = material.reflection(search.band_hz, np.linspace(0.0, 1.0, COSINES)[:, None])
    sights, first, second = _sights(pairs)
    light, kept = (
        light_of(search.fidelity, has_plates(tracing.world.skins[facets.obstacle][0])),
        faintest(search.fidelity, search.audible),
    )
    spots = spots_of(facets, light.spot_m)
    lit, view = lit_spots(tracing, facets, spots, sights, light)
    seen = np.flatnonzero(_share_light(lit, view[first], view[second]))
    used, which = np.unique([first[seen], second[seen]], return_inverse=True)
    frame = tracing.placed[sights.pose[used], facets.obstacle]
    ends = Ends(into_rest(sights.point_m[used], frame), sights.pose[used], view[used], lit)
    one, other = which.reshape(2, -1)
    every = scattered(facets, spots.of_facet, ends, one, other, wavenumber, reflection)
    every = replace(every, pair=seen[every.pair])
    parts, gains, count = [], [], 0
    for mic in range(2):
        cells = every[pairs.mic[every.pair] == mic]
        loud = _loud(cells, pairs.pose[cells.pair], kept)
        _reject_faint(search, facets, mic, pairs.before, pairs.after, cells[~loud])
        cells = cells[loud]
        parts.append(_over_body(search, facets, mic, pairs.before, pairs.after, cells, count))
        gains.append(cells.gain)
        count += len(cells)
    return joined(parts), np.concatenate(gains)


def _sights(pairs: Pairs) -> tuple[Sights, Ints, Ints]:
    """The images of all pairs, each once, by pose; and which of them begin and end each pair."""
    images = [pairs.before, pairs.after]
    pose, order = (np.concatenate([getattr(each, name) for each in images]) for name in ("pose", "order"))
    side = np.concatenate([np.zeros(len(pairs), dtype=np.int64), 1 + pairs.mic])
    sequence = np.concatenate([each.sequence for each in images])
    point = np.concatenate([each.point_m for each in images])
    key = np.column_stack([pose, side, sequence])
    _, rows, which = np.unique(key, axis=0, return_index=True, return_inverse=True)
    sights = Sights(pose[rows], side[rows], order[rows], sequence[rows], point[rows])
    first, second = which.reshape(2, -1)
    return sights, first, second


def _share_light(lit: Flags, first: Ints, second: Ints) -> Flags:
    """(R,) whether both views (R,) of a pair, -1 for none, show a spot of the body that is the same."""
    both, which = np.unique([first, second], axis=1, return_inverse=True)
    shared = [a >= 0 and b >= 0 and bool((lit[a] & lit[b]).any()) for a, b in both.T]
    return np.array(shared, dtype=bool)[which.ravel()]


def faintest(fidelity: Fidelity, audible: Audible) -> Audible:
    """What a cell must exceed, re the body's loudest: cells that cancel must stay far above what is left out."""
    share = np.clip(CELL_SHARE_A_DB * fidelity.tolerance_db, *CELL_SHARES)
    return replace(audible, share=min(audible.share, float(share)) if audible.floor > 0.0 else audible.share)


def _loud(cells: Cells, pose: Ints, kept: Audible) -> Flags:
    """(M,) cells that are not too long, and not lost under the noise or under the body's strongest."""
    gain = np.abs(cells.gain).max(axis=1, initial=0.0)
    strongest = np.zeros(pose.max(initial=-1) + 1)
    np.maximum.at(strongest, pose, gain)
    return (cells.length_m <= kept.limit_m) & kept(gain, strongest[pose])


def _turns(tracing: Tracing, facets: Facets, mic: int, before: Images, after: Images, cells: Cells) -> Turns:
    """Paths through the facets that stand for cells."""
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
    normal = rotated(facets.normal[cells.facet[ok]], search.tracing.placed[found.pose, facets.obstacle, 3])
    each = np.arange(len(ok))
    arriving = np.sum(normal * (found.points_m[each, place + 1] - found.points_m[each, place]), axis=1)
    normal = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    found = found.with_reflection(place, normal=normal, standoff_m=facets.standoff_m[cells.facet[ok]])
    return replace(found, cell=first + ok)


def has_plates(reading: MeshReading) -> bool:
    """Whether a body has thin plates, which are left to the integral where something close hides a part of them."""
    return bool((reading.sheet_m > 0.0).any())


def facet_size_m(fidelity: Fidelity, plates: bool) -> float:
    """Longest edge of the facets of a body with thin plates or without."""
    return min(fidelity.facet_m, PLATE_FACET_M) if _in_detail(fidelity, plates) else fidelity.facet_m


def _in_detail(fidelity: Fidelity, plates: bool) -> bool:
    return fidelity.tolerance_db < (COARSE_DB if plates else FINE_DB)


def light_of(fidelity: Fidelity, plates: bool) -> Light:
    """How finely light is asked for: where the finest tolerance is asked for, for each pose and transducer."""
    if _in_detail(fidelity, plates):
        return Light(FINE_SPOT_M, 0.0)
    if fidelity.tolerance_db < COARSE_DB:
        return Light(SPOT_M, HELD)
    return Light(COARSE_SPOT_M, COARSE_HELD)
