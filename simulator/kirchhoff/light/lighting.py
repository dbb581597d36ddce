"""Which spots of a body an image of speaker or microphone sees: asked of Embree once for each spot.

A spot is a patch of the skin, and one of its facets speaks for it. Where neighbouring spots differ, the border of a
shadow runs: there each facet is asked by itself. A border known to 15 mm alone moves echoes of people by 0.3 dB, up to
0.8. Along a walk the light on most of a body stays: of two poses in it everything is asked for, of those in between
only what the two do not agree on. Transducers of the phone that lie near each other may share an answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Bytes, Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import dot, norm
from simulator.kirchhoff.illuminating_images import Sights
from simulator.kirchhoff.light.paths_to_skin import Begins, Skin, paths_to
from simulator.kirchhoff.light.quarters import quartered
from simulator.kirchhoff.light.spots import Spots
from simulator.kirchhoff.light.views import Between, Views
from simulator.surfaces.facets import FACETS_A_SQUARE, Facets
from simulator.world.frames import into_rest, out_of_rest
from simulator.world.line_of_sight import free_between
from simulator.world.world import Tracing

DARK, LIT, BORDER, AWAY = range(4)  # what a spot says of its facets; the last two have them asked one by one
AT_ONCE = 2**16  # rays: what is kept in memory of them, however many images there are
SAMPLE_M = 0.08  # apart are, on average, the spots that are asked first: an image that sees none sees nothing


@dataclass(frozen=True)
class Light:
    """How finely the light on a body is asked for.

    Attributes:
        spot_m: size of the spots; no larger than a facet asks for each facet.
        agreed: how far the phone may move, re its distance from the body's centre, between two poses of which
            everything is asked for; 0 does so of each pose.
        alike: how far apart transducers may be, re their distance from the body's box, to share an answer.
        border_m: facets longer than this, on average, are asked for in quarters where the border of a shadow runs.
    """

    spot_m: float
    agreed: float
    alike: float
    border_m: float = np.inf


def seeing(tracing: Tracing, facets: Facets, spots: Spots, sights: Sights, light: Light) -> Flags:
    """(E,) which images show any of the spots that are asked first, or stand between two that do along the walk.

    Most images of second order and beyond see nothing of the body.
    """
    views, between, number = _views(tracing, facets, sights, light)
    sample, seen = Skin.of(facets, _asked_first(facets, spots)), np.zeros(len(views), dtype=bool)
    for view, item in _each_with_each(between.in_turn[0], len(sample.normal)):
        seen[view[_reached(tracing, sample, views, view, item)]] = True
    return (seen[between.before] | seen[between.after])[number]


def hidden_by_others(tracing: Tracing, facets: Facets, spots: Spots) -> Flags:
    """(N,) poses at which anything stands between the phone and the body's box.

    On the way to the spots that are asked first, each as far as the box: what the body hides of itself does not count.
    """
    facet = _asked_first(facets, spots)
    pose, item = (each.ravel() for each in np.indices((len(tracing.pose), len(facet))))
    frame, start = tracing.placed[pose, facets.obstacle], tracing.middle_m[pose]
    begin, place = into_rest(start, frame), facets.middle_m[facet[item]]
    step = np.where(place == begin, np.finfo(float).tiny, place - begin)
    sides = (facets.middle_m.min(axis=0) - begin) / step, (facets.middle_m.max(axis=0) - begin) / step
    entry = np.clip(np.minimum(*sides).max(axis=1), 0.0, 1.0)
    there = out_of_rest(begin + entry[:, None] * step, frame)
    free = free_between(tracing, start, there, pose, tracing.world.blockers)
    return np.asarray(~free.reshape(-1, len(facet)).all(axis=1))


def _asked_first(facets: Facets, spots: Spots) -> Ints:
    """Facets that speak for spots some `SAMPLE_M` apart."""
    return spots.facet[:: max(1, int(len(spots.facet) * SAMPLE_M**2 / facets.area_m2.sum()))]


def lit_facets(
    tracing: Tracing, facets: Facets, spots: Spots, sights: Sights, light: Light
) -> tuple[Facets, Flags, Ints]:
    """Which facets can be seen: those that face an image, with nothing between on any segment.

    Args:
        spots: of these facets, of the light's size.

    Returns:
        The facets that are seen from anywhere, those around them, and quarters where borders run; (V, F) which of these
        each distinct view of the body shows; (E,) the view that each image has.
    """
    views, between, number = _views(tracing, facets, sights, light)
    lit = _spot_by_spot(tracing, facets, spots, views, between)
    wanted = spots.around(np.logical_or.reduce(lit, axis=0))
    wanted[spots.of_facet[facets.creases.beside]] = True
    facets, spots, lit = facets[wanted[spots.of_facet]], spots.of(wanted), lit.compress(wanted, axis=1)
    if len(spots.facet) == len(facets):
        return facets, lit.take(spots.of_facet, axis=1), number
    state = _said(tracing, facets, spots, views, lit)
    large = facets.area_m2 > light.border_m**2 / FACETS_A_SQUARE
    facets = quartered(facets, large & (state == BORDER).any(axis=0)[spots.of_facet])
    return facets, _facet_by_facet(tracing, facets, spots.of_facet, views, between, state), number


def _views(tracing: Tracing, facets: Facets, sights: Sights, light: Light) -> tuple[Views, Between, Ints]:
    """The views that images (E,) have of a body, those that they lie between, and (E,) which view each has."""
    views, number = Views.distinct(tracing, facets, sights, light.alike)
    return views, Between.of(views, _runs(tracing, facets, light.agreed)), number


@compiled
def share_light(lit, first, second):
    """(R,) whether both views (R,) of a pair show a facet (V, F) of the body that is the same."""
    shared = np.zeros(len(first), np.bool_)
    for r in range(len(first)):
        a, b = first[r], second[r]
        for f in range(lit.shape[1]):
            if lit[a, f] and lit[b, f]:
                shared[r] = True
                break
    return shared


def _spot_by_spot(tracing: Tracing, facets: Facets, spots: Spots, views: Views, between: Between) -> Flags:
    """(V, S) which spots each view shows."""
    skin, lit = Skin.of(facets, spots.facet), np.empty((len(views), len(spots.facet)), dtype=bool)
    for chosen in between.in_turn:
        for view, spot in _each_with_each(chosen, lit.shape[1]):
            _ask(tracing, skin, views, between, lit, view, spot)
    return lit


def _each_with_each(views: Ints, items: int) -> Iterator[tuple[Ints, Ints]]:
    """(R,) views and (R,) items, view by view: all items of each of some views (V,), as many as fit in memory."""
    for some in _in_parts(np.full(len(views), items)):
        yield np.repeat(views[some], items), np.tile(np.arange(items), len(views[some]))


def _said(tracing: Tracing, facets: Facets, spots: Spots, views: Views, lit: Flags) -> Bytes:
    """(V, S) what spots say of their facets, where (V, S) of them are lit."""
    image = into_rest(views.image_m, tracing.placed[views.pose, facets.obstacle])
    middle, normal = facets.middle_m[spots.facet], facets.normal[spots.facet]
    apart, rise = np.zeros((2, len(spots.facet)))
    np.maximum.at(apart, spots.of_facet, norm(facets.normal - normal[spots.of_facet]))
    np.maximum.at(rise, spots.of_facet, dot(facets.normal, middle[spots.of_facet] - facets.middle_m))
    found: Bytes = _states(image, middle, normal, apart, rise, facets.closed, spots.beside, lit)  # type: ignore[call-arg]
    return found


def _facet_by_facet(
    tracing: Tracing, facets: Facets, of_facet: Ints, views: Views, between: Between, state: Bytes
) -> Flags:
    """(V, F) which facets each view shows: what their spots say (V, S), or what is asked of each by itself.

    Args:
        of_facet: spots of the facets, without those that are quarters of others.
    """
    by_spot = np.argsort(of_facet, kind="stable")
    begin = np.searchsorted(of_facet, np.arange(state.shape[1] + 1), sorter=by_spot)
    quarters = np.full(len(of_facet), -1)
    quarters[facets.part_of[len(of_facet) :: 4]] = np.arange(len(of_facet), len(facets), 4)
    every = np.zeros((len(views), len(facets)), dtype=bool)
    own = Skin(facets.obstacle, facets.asked_m, facets.normal, facets.standoff_m, facets.closed)
    image = into_rest(views.image_m, tracing.placed[views.pose, facets.obstacle])
    height = dot(facets.middle_m, facets.normal)
    by_spots = _BySpots(facets.normal, height, facets.closed, by_spot, begin, quarters)
    asked = np.bincount(of_facet, np.where(quarters < 0, 1, 4), state.shape[1])
    rays = ((state >= BORDER) @ asked).astype(np.int64)
    # made anew for each call the room takes half of the time of all
    room = np.empty((2, AT_ONCE + int(rays.max(initial=0))), dtype=np.int64)
    for chosen in between.in_turn:
        for some in _in_parts(rays[chosen]):
            view, item = _spread(image, chosen[some], by_spots, state, every, room)  # type: ignore[call-arg]
            _ask(tracing, own, views, between, every, view, item)
    return every


def _ask(tracing: Tracing, skin: Skin, views: Views, between: Between, known: Flags, view: Ints, item: Ints) -> None:
    """Fill in, in (V, I) `known`, what views (R,) show of pieces (R,) of the skin (I,)."""
    rows = np.flatnonzero(between.in_doubt(known, view, item))
    view, item = view[rows], item[rows]
    known[view, item] = _reached(tracing, skin, views, view, item)


@compiled
def _states(image, middle, normal, apart, rise, closed, beside, lit):
    """(V, S) what spots say of their facets, where (V, S) of them are lit.

    Facing an image needs no ray: it must be above the speaker's plane. Of a spot that is lit and one beside it that is
    dark, a border runs through both, but where the dark one merely faces away. Where a round body turns away no spot
    speaks; of those farther on all facets face away.

    Args:
        middle, normal: (S, 3) of the speakers.
        apart, rise: (S,) the most by which a facet's normal differs, and by which its plane is above the speaker.
    """
    state, faces = np.empty(lit.shape, np.int8), np.empty(lit.shape[1], np.bool_)
    for v in range(len(lit)):
        for s in range(lit.shape[1]):
            height = square = 0.0
            for k in range(3):
                away = image[v, k] - middle[s, k]
                height, square = height + away * normal[s, k], square + away * away
            faces[s] = not closed or height > 0.0
            if faces[s]:
                state[v, s] = LIT if lit[v, s] else DARK
            else:
                state[v, s] = AWAY if height + apart[s] * np.sqrt(square) + rise[s] > 0.0 else DARK
        for b in range(len(beside)):
            one, other = beside[b]
            if lit[v, one] != lit[v, other] and faces[other if lit[v, one] else one]:
                state[v, one] = state[v, other] = BORDER
    return state


class _BySpots(NamedTuple):
    """F facets, spot by spot.

    Attributes:
        normal, height: (F, 3), (F,) of their planes.
        closed: whether they show on one side alone.
        facet, start: (F,) facets in the order of their spots, and (S + 1,) where each spot begins among them.
        quarters: (F,) the first of the four quarters of each, -1 where it has none.
    """

    normal: Floats
    height: Floats
    closed: bool
    facet: Ints
    start: Ints
    quarters: Ints


@compiled
def _spread(image, chosen, by_spots, state, every, room):
    """Fill in for the facets (V, F) of chosen views, all dark so far, what their spots say (V, S) where they face it.

    Args:
        room: (2, R) or more.

    Returns (R,) views and (R,) facets to be asked one by one, in `room`: quarters instead of facets that have them.
    """
    normal, height, closed, start = by_spots.normal, by_spots.height, by_spots.closed, by_spots.start
    view, facet = room
    count = 0
    for v in chosen:
        x, y, z = image[v, 0], image[v, 1], image[v, 2]
        for s in range(len(start) - 1):
            says = state[v, s]
            if says == DARK:
                continue
            for i in range(start[s], start[s + 1]):
                f = by_spots.facet[i]
                if closed and not _faces(x, y, z, normal, height, f):
                    continue
                first = by_spots.quarters[f]
                if says == LIT:
                    every[v, f] = True
                    for q in range(first, first + 4 if first >= 0 else first):
                        every[v, q] = True
                elif first < 0:
                    view[count], facet[count] = v, f
                    count += 1
                else:
                    for q in range(first, first + 4):
                        if not closed or _faces(x, y, z, normal, height, q):
                            view[count], facet[count] = v, q
                            count += 1
    return view[:count], facet[:count]


@inlined
def _faces(x, y, z, normal, height, f):
    """Whether a point lies above the plane of a facet."""
    return x * normal[f, 0] + y * normal[f, 1] + z * normal[f, 2] > height[f]


def _in_parts(rays: Ints) -> list[slice]:
    """Views with so many rays (V,) each, some at a time: what is kept in memory of them stays small."""
    stop = np.flatnonzero(np.diff(np.cumsum(rays) // AT_ONCE, append=-1)) + 1
    return [slice(first, last) for first, last in pairwise([0, *stop.tolist()])]


def _reached(tracing: Tracing, skin: Skin, views: Views, view: Ints, item: Ints) -> Flags:
    """(R,) whether sound from the origins of views (R,) comes to pieces (R,) of a skin that face their images."""
    begins = Begins.of(tracing, views, skin.obstacle)
    row, stops = paths_to(tracing.mirrors, begins, skin, tracing.world.clear_m, view, item)  # type: ignore[call-arg]
    reached = np.zeros(len(view), dtype=bool)
    reached[row] = _free(tracing, stops, views.pose[view[row]], views.order[view[row]])
    return reached


def _free(tracing: Tracing, stops: Floats, pose: Ints, order: Ints) -> Flags:
    """(R,) whether nothing stands between the stops (K + 2, R, 3) of each path; the last `order` + 2 count.

    From the facet back: a body hides most of itself.
    """
    free = np.ones(len(pose), dtype=bool)
    for back in range(len(stops) - 1):
        met = order >= back
        for shadow in tracing.world.blockers:
            frame = tracing.placed[:, shadow.obstacle]
            free &= ~shadow.blocks_from(stops[-2 - back], stops[-1 - back], frame, pose, free & met)
    return free


def _runs(tracing: Tracing, facets: Facets, apart: float) -> Ints:
    """(N,) which run of poses each is of: within one nothing moves far, re the distance, relative to the body."""
    frame = tracing.placed[:, facets.obstacle]
    seen_from = into_rest(tracing.middle_m, frame)
    others = into_rest(tracing.placed[:, :, :3], frame[:, None])
    distance = np.linalg.norm(seen_from - facets.center_m, axis=1)
    run, k = np.zeros(len(seen_from), dtype=np.int64), 0
    for n in range(1, len(seen_from)):
        moved = np.linalg.norm(seen_from[n] - seen_from[k]) + np.linalg.norm(others[n] - others[k], axis=1).max()
        run[n] = run[n - 1]
        if moved > apart * distance[n]:
            run[n], k = run[n] + 1, n
    return run
