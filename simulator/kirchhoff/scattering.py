"""Echoes of bodies by Kirchhoff's integral, with mirrors before and after them.

As for curved surfaces, a mirror only moves the point that the body sees. The integral runs over the facets lit from
both sides.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from simulator.images.image_pairs import Pairs, Taken
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.kirchhoff.cells import Cells, CellSums, with_stand_ins
from simulator.kirchhoff.illuminating_images import Ends, Sights
from simulator.kirchhoff.integral import cell_sums
from simulator.kirchhoff.light.lighting import Light, hidden_by_others, lit_facets, seeing, share_light
from simulator.kirchhoff.light.spots import Spots, spots_of
from simulator.kirchhoff.path_length_grid import Grid
from simulator.kirchhoff.standing_creases import standing_on_mirrors
from simulator.kirchhoff.under_skins import outermost
from simulator.scene.fidelity import COARSE_DB, FINE_DB, Fidelity
from simulator.surfaces.facets import Facets, check_cut, facets_of
from simulator.surfaces.reflectors import MeshReading
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates
from simulator.world.frames import out_of_rest, rotated
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

CELL_SHARE_A_DB, CELL_SHARES = 8e-3, (1e-3, 1.5e-2)
"""Share of the strongest cell below which cells are dropped: this times the tolerance, within these limits."""
NOISE_SHARE_A_DB, NOISE_SHARE = 0.3, 0.3  # of the level that is lost in the noise: what cells must exceed, by tolerance
FINE_SPOT_M, SPOT_M, COARSE_SPOT_M = 0.03, 0.04, 0.065  # under FINE_DB of tolerance, under COARSE_DB, and from there
AGREED = 0.2  # of its centre's distance: at `auto` 1 of 1508 echoes differs by 0.5 dB from asking at each pose
BORDER_FACET_M = 0.025  # facets longer than this err by up to 7 dB where the border of a shadow runs, and not elsewhere
CHORD_M = 4e-4  # what edges stand off: with twice that, echoes of people err by 0.4 dB in 95 %, with this by 0.2
ALIKE, COARSE_ALIKE = 0.02, 0.1  # of its box's distance: with 0.02, those 3 cm apart see it alike from 1.5 m on
PLATE_FACET_M = 0.012  # coarser, and in coarser light, the shadow of a sign's post on its plate errs by 2-5 dB
COARSE_PLATE_FACET_M = 0.04  # from COARSE_DB on, with quarters along that shadow's border
COARSE_LIGHT = Light(COARSE_SPOT_M, AGREED, COARSE_ALIKE)
BEHIND_OTHERS = Light(COARSE_SPOT_M, AGREED, ALIKE, BORDER_FACET_M)
"""At `standard`: at poses where nothing stands before a body, and where another one does. Its shadow ends elsewhere for
each transducer, on facets of any size: 90 % of 20 cars behind people are within 0.6 dB, and were within 1.8."""
LIT_AT_ONCE = 2**26  # flags, of all facets for images that see any: bounds memory, however long the walk is
COSINES = 257  # of incidence, between which the reflection is interpolated


def scattered_paths(search: Search, wanted: Taken) -> list[tuple[Candidates, Complexes]]:
    """Paths over an obstacle by Kirchhoff's integral, and (M, K) gains of it; `cell` names the row. Part by part."""
    wanted = wanted[np.lexsort((wanted.pairs.mic, wanted.pairs.pose))]
    pairs = wanted.pairs
    reading, surface = search.tracing.world.skins[pairs.obstacle]
    light, *sizes_m = _fineness(search.fidelity, reading)
    check_cut(search.tracing.world.obstacles[pairs.obstacle].name, reading, sizes_m[0])
    facets = outermost(search.tracing.world, facets_of(reading, surface, pairs.obstacle, *sizes_m))
    if not len(facets):
        return []
    facets = standing_on_mirrors(search.tracing, facets)
    spots, hidden = spots_of(facets, light.spot_m), np.zeros(len(search.tracing.pose), dtype=bool)
    if light == COARSE_LIGHT:
        hidden = hidden_by_others(search.tracing, facets, spots)
    lights = (light, ~hidden), (BEHIND_OTHERS, hidden)
    return [
        part
        for each, poses in lights
        if poses.any()
        for part in _in_parts(search, facets, spots, each, wanted[np.flatnonzero(poses[pairs.pose])])
    ]


def _in_parts(
    search: Search, facets: Facets, spots: Spots, light: Light, wanted: Taken
) -> Iterator[tuple[Candidates, Complexes]]:
    """The same in one light, in parts that fit in memory."""
    sights, first, second = _sights(wanted.pairs)
    seen = seeing(search.tracing, facets, spots, sights, light)
    wanted = wanted[np.flatnonzero(seen[first] & seen[second])]
    flags = np.bincount(sights.pose[seen], minlength=len(search.tracing.pose)).cumsum() * len(facets)
    part = (flags // LIT_AT_ONCE)[wanted.pairs.pose]
    for each in np.unique(part):
        yield _in_part(search, facets, spots, light, wanted[np.flatnonzero(part == each)])


def _in_part(search: Search, facets: Facets, spots: Spots, light: Light, wanted: Taken) -> tuple[Candidates, Complexes]:
    """The same at some of the poses."""
    tracing, pairs = search.tracing, wanted.pairs
    material = tracing.world.obstacles[pairs.obstacle].material
    reflection = material.reflection(search.band_hz, np.linspace(0.0, 1.0, COSINES)[:, None])
    sights, first, second = _sights(pairs)
    facets, lit, view = lit_facets(tracing, facets, spots, sights, light)
    seen = np.flatnonzero(share_light(lit, view[first], view[second]))
    one, other, used, struck_from = _used(search, first[seen], second[seen])
    ends = Ends.of(search, facets, sights[used], sights.point_m[struck_from], view[used], lit)
    grid = Grid.over(facets.radius_m + ends.strays_m(facets), search.band_wavenumber_1_m)
    skin = facets, ends, one, other, grid
    sums = cell_sums(*skin, reflection)
    loudest = _loudest(sums)
    kept = faintest(search)(loudest, _strongest(pairs[seen[sums.pair]], loudest))
    faint = np.flatnonzero(~kept)

    def turns(cells: Cells) -> Turns:
        return _turns(tracing, facets, pairs[seen[cells.pair]], cells)

    def described() -> Rejected:
        cells = with_stand_ins(*skin, sums[faint])
        return Rejected(_loudest(cells), partial(straightened, search, turns(cells)))

    search.reject(Reason.FAINT_CELL, len(faint), described)
    cells = with_stand_ins(*skin, sums[np.flatnonzero(kept)])
    found, ok = unfolded(search, turns(cells), lambda: _loudest(cells))
    return replace(found, cell=ok, share=wanted.share[seen[cells.pair[ok]]]), cells.gain


def _sights(pairs: Pairs) -> tuple[Sights, Ints, Ints]:
    """The images of all pairs, each once, by pose; and which of them begin and end each pair."""
    images = [pairs.before, pairs.after]
    pose, order = (np.concatenate([getattr(each, name) for each in images]) for name in ("pose", "order"))
    side = np.concatenate([np.zeros(len(pairs), dtype=np.int64), 1 + pairs.mic])
    sequence = np.concatenate([each.sequence for each in images])
    point = np.concatenate([each.point_m for each in images])
    key = np.column_stack([pose, side, sequence])
    rows, which = distinct(key)
    sights = Sights(pose[rows], side[rows], order[rows], sequence[rows], point[rows])
    first, second = which.reshape(2, -1)
    return sights, first, second


def _used(search: Search, first: Ints, second: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Which ends R pairs of images have, (R,) and (R,); (E,) the images of these, and (E,) those that sound comes from.

    Each image once; where something moves, one of a microphone once for each of the speaker, from which sound takes
    its own time. Where nothing does, it does not matter from which.
    """
    origin = first if search.sweep is not None else np.zeros_like(first)
    image = np.column_stack([np.concatenate([first, second]), np.concatenate([first, origin])])
    rows, which = distinct(image)
    one, other = which.reshape(2, -1)
    return one, other, *image[rows].T


def faintest(search: Search) -> Audible:
    """What a cell must exceed: re the body's loudest, as cells that cancel must stay far above what is left out, and
    beside the noise."""
    audible, tolerance_db = search.audible, search.fidelity.tolerance_db
    if audible.floor == 0.0:
        return audible
    share = np.clip(CELL_SHARE_A_DB * tolerance_db, *CELL_SHARES)
    least = search.lost_in_noise * min(NOISE_SHARE_A_DB * tolerance_db, NOISE_SHARE)
    return replace(audible, share=min(audible.share, float(share)), least=least)


def _loudest(cells: Cells | CellSums) -> Floats:
    """(M,) greatest magnitude over the band."""
    found: Floats = np.abs(cells.gain).max(axis=1, initial=0.0)
    return found


def _strongest(pairs: Pairs, gain: Floats) -> Floats:
    """(M,) the body's strongest cell at the pose and microphone of each."""
    at = 2 * pairs.pose + pairs.mic
    strongest = np.zeros(at.max(initial=-1) + 1)
    np.maximum.at(strongest, at, gain)
    return strongest[at]


def _turns(tracing: Tracing, facets: Facets, pairs: Pairs, cells: Cells) -> Turns:
    """Paths through the facets that stand for cells."""
    frame, facet = tracing.placed[pairs.pose, facets.obstacle], cells.facet
    point, normal = out_of_rest(facets.middle_m[facet], frame), rotated(facets.normal[facet], frame[:, 3])
    arriving = np.sum(normal * (point - pairs.before.point_m), axis=1)
    normal = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    number = np.full((len(cells), 1), tracing.world.numbering.number(Interaction.KIRCHHOFF, facets.obstacle))
    known = {"normal": normal[:, None], "standoff_m": facets.standoff_m[facet, None]}
    return Turns(pairs, point[:, None], number, known)


def _fineness(fidelity: Fidelity, reading: MeshReading) -> tuple[Light, float, float]:
    """How finely light is asked for on a body, the longest edge of its facets, and how far it may stand off its chord.

    Thin plates are left to the integral where something close hides a part of them: that asks for more.
    """
    plates, size_m = reading.plated, fidelity.facet_m
    if fidelity.tolerance_db < (COARSE_DB if plates else FINE_DB):
        light = Light(FINE_SPOT_M, 0.0, 0.0 if fidelity.tolerance_db < FINE_DB else ALIKE)
        return light, min(size_m, PLATE_FACET_M) if plates else size_m, np.inf
    if fidelity.tolerance_db < COARSE_DB:
        return Light(SPOT_M, AGREED, ALIKE, BORDER_FACET_M), size_m, CHORD_M
    if plates:
        return Light(SPOT_M, AGREED, ALIKE, BORDER_FACET_M), min(size_m, COARSE_PLATE_FACET_M), np.inf
    return COARSE_LIGHT, size_m, np.inf
