"""Bodies heard by Kirchhoff's integral, with mirrors before and after them.

As for curved surfaces, a mirror only moves the point that the body sees. Which facets of the body an image lights is
asked once for every image; the integral runs over the facets lit from both sides.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from simulator import specular
from simulator.candidates import Candidates, candidates, joined, with_plane_normals
from simulator.facets import Facets
from simulator.floor import Audible
from simulator.frames import into_rest, out_of_rest, turned
from simulator.kirchhoff import Cells, scattered
from simulator.ledger import Ledger, Turned
from simulator.legs import legs_free
from simulator.mixed import Images
from simulator.pairs import Pairs
from simulator.planar import crossed
from simulator.unfolding import Turns, straightened, unfolded
from simulator.world import Tracing

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

IMAGES_AT_ONCE = 8  # times facets: what is asked of Embree in one batch
SAMPLES = (0.0, 0.33, 0.67, 1.0)  # places in a piece that are asked first


def scattered_paths(
    tracing: Tracing, facets: Facets, pairs: Pairs, max_order: int, audible: Audible, wavenumber: Floats, ledger: Ledger
) -> tuple[Candidates, Complexes]:
    """Paths over an obstacle heard as a whole, and (M, K) gains of it were it rigid; `cell` names the row.

    Args:
        pairs: the ways that are wanted.
        max_order: reflections in all, the body counting as one.
        wavenumber: (K,) rising, rad/m.
        ledger: of what is turned away.
    """
    parts, gains, first = [], [], 0
    for mic in range(2):
        some = pairs[pairs.mic == mic]
        frame = tracing.placed[some.pose, facets.obstacle]
        ends = into_rest(some.before.point_m, frame), into_rest(some.after.point_m, frame)
        seen = _lit_facets(tracing, facets, tracing.source_m, some.before)
        seen &= _lit_facets(tracing, facets, tracing.mics_m[:, mic], some.after)
        cells = scattered(facets, *ends, seen, wavenumber)
        loud = _loud(cells, some.pose[cells.pair], audible)
        _turn_faint_away(tracing, facets, mic, some.before, some.after, cells[~loud], max_order, ledger)
        cells = cells[loud]
        parts.append(_over_body(tracing, facets, mic, some.before, some.after, cells, first, max_order, ledger))
        gains.append(cells.gain)
        first += len(cells)
    return joined(parts), np.concatenate(gains)


def _loud(cells: Cells, pose: Ints, audible: Audible) -> Flags:
    """(M,) cells that are not too long, and not lost under the noise or under the body's strongest."""
    gain = np.abs(cells.gain).max(axis=1, initial=0.0)
    strongest = np.zeros(pose.max(initial=-1) + 1)
    np.maximum.at(strongest, pose, gain)
    return (cells.length_m <= audible.limit_m) & audible(gain, strongest[pose])


def _turns(
    tracing: Tracing, facets: Facets, mic: int, before: Images, after: Images, cells: Cells, width: int
) -> Turns:
    """Ways through the facets that stand for cells."""
    before, after = before[cells.pair], after[cells.pair]
    point = out_of_rest(facets.middle_m[cells.facet], tracing.placed[before.pose, facets.obstacle])
    number = np.full(len(cells), tracing.world.first_body + facets.obstacle)
    return Turns(mic, before, after, point[:, None], number[:, None], width)


def _turn_faint_away(
    tracing: Tracing, facets: Facets, mic: int, before: Images, after: Images, cells: Cells, width: int, ledger: Ledger
) -> None:
    turns = _turns(tracing, facets, mic, before, after, cells, width)
    amplitude = np.abs(cells.gain).max(axis=1, initial=0.0)
    ledger.turn_away("faint cell", len(cells), lambda: Turned(amplitude, partial(straightened, tracing, turns)))


def _over_body(
    tracing: Tracing, facets: Facets, mic: int, before: Images, after: Images, cells: Cells, first: int, width: int,
    ledger: Ledger,
) -> Candidates:  # fmt: skip
    """Candidates through the facet that stands for each cell."""
    turns = _turns(tracing, facets, mic, before, after, cells, width)
    found, ok, place = unfolded(tracing, turns, ledger, lambda: np.abs(cells.gain).max(axis=1, initial=0.0))
    normal = turned(facets.normal[cells.facet[ok]], tracing.placed[found.pose, facets.obstacle, 3])
    each = np.arange(len(ok))
    arriving = np.sum(normal * (found.points_m[each, place + 1] - found.points_m[each, place]), axis=1)
    found.normal[each, place] = np.where(arriving > 0.0, -1.0, 1.0)[:, None] * normal
    found.lift_m[each, place] = facets.lift_m[cells.facet[ok]]
    found.cell[:] = first + ok
    return found


def _lit_facets(tracing: Tracing, facets: Facets, start_m: Floats, images: Images) -> Flags:
    """(R, F) facets that each image sees: turned towards it, and nothing between on any leg."""
    key = np.column_stack([images.pose, images.sequence])
    first, which = np.unique(key, axis=0, return_index=True, return_inverse=True)[1:]
    lit = np.zeros((len(first), len(facets)), dtype=bool)
    for start in range(0, len(first), IMAGES_AT_ONCE):
        some = images[first[start : start + IMAGES_AT_ONCE]]
        lit[start : start + len(some.pose)] = _lit(tracing, facets, start_m, some)
    return lit[which.ravel()]


def _lit(tracing: Tracing, facets: Facets, start_m: Floats, images: Images) -> Flags:
    """(I, F) facets lit; where a piece's samples agree they speak for all of it, where not every facet is asked."""
    facing = _facing(tracing, facets, images)
    lit = np.zeros_like(facing)
    count = np.diff(facets.start)
    samples = np.unique(
        np.concatenate([facets.start[:-1] + (share * (count - 1)).astype(np.int64) for share in SAMPLES])
    )
    _ask(tracing, facets, start_m, images, facing, samples, lit)
    asked = np.zeros(len(facets), dtype=bool)
    asked[samples] = True
    seen, hidden = (np.add.reduceat(flags & asked, facets.start[:-1], axis=1) for flags in (lit, facing & ~lit))
    piece = np.repeat(np.arange(len(count)), count)
    mixed = ((seen > 0) & (hidden > 0))[:, piece]
    _ask(tracing, facets, start_m, images, facing & mixed & ~asked, np.arange(len(facets)), lit)
    return lit | (facing & ~mixed & (seen > 0)[:, piece])


def _facing(tracing: Tracing, facets: Facets, images: Images) -> Flags:
    """(I, F) facets whose outside is turned to the image; all of an open surface's."""
    point = into_rest(images.point_m, tracing.placed[images.pose, facets.obstacle])
    if not facets.closed:
        return np.ones((len(point), len(facets)), dtype=bool)
    return point @ facets.normal.T > np.sum(facets.middle_m * facets.normal, axis=1)


def _ask(
    tracing: Tracing, facets: Facets, start_m: Floats, images: Images, wanted: Flags, among: Ints, lit: Flags
) -> None:
    """Mark in `lit` (I, F) those of the wanted facets among some that sound from each image's origin reaches."""
    image, place = np.nonzero(wanted[:, among])
    facet = among[place]
    lit[image, facet] = _reached(tracing, facets, start_m, images[image], facet)


def _reached(tracing: Tracing, facets: Facets, start_m: Floats, images: Images, facet: Ints) -> Flags:
    """(R,) whether sound from each image's origin comes to each facet through its mirrors, with every leg free."""
    frame = tracing.placed[images.pose, facets.obstacle]
    target = out_of_rest(facets.middle_m[facet], frame)
    start = np.ascontiguousarray(start_m[images.pose])
    code, hits = crossed(tracing, start, target, images.pose, images.order, images.sequence)
    normal = turned(facets.normal[facet], frame[:, 3])
    found = candidates(tracing, images.pose, np.zeros_like(images.pose), images.sequence, hits)
    found.points_m[:, 0] = start
    last = found.points_m[np.arange(len(facet)), images.order]
    side = np.where(np.sum(normal * (last - target), axis=1) >= 0.0, 1.0, -1.0)
    lifted = target + (side * facets.lift_m[facet])[:, None] * normal
    beyond = np.arange(found.points_m.shape[1]) > images.order[:, None]
    found.points_m[:] = np.where(beyond[:, :, None], lifted[:, None], found.points_m)
    reached = np.flatnonzero(code == specular.REACHED)
    free = np.zeros(len(facet), dtype=bool)
    free[reached] = legs_free(tracing, with_plane_normals(tracing, found[reached]))
    return free
