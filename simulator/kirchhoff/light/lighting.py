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
from simulator.images.image_method import REACHED, backtrack, fill_images
from simulator.kirchhoff.illuminating_images import Sights
from simulator.kirchhoff.light.quarters import quartered
from simulator.kirchhoff.light.spots import Spots
from simulator.kirchhoff.light.views import Between, Views
from simulator.surfaces.facets import FACETS_A_SQUARE, Facets
from simulator.world.frames import into_rest, rotated_back
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


class Skin(NamedTuple):
    """Where light on a body is asked for: close by one another in memory, since they are asked for again and again.

    Attributes:
        obstacle: the body.
        place_m: (I, 3) on the facets that speak.
        normal, standoff_m: (I, 3), (I,) of these.
        closed: whether they show on one side alone.
    """

    obstacle: int
    place_m: Floats
    normal: Floats
    standoff_m: Floats
    closed: bool

    @classmethod
    def of(cls, facets: Facets, rows: Ints) -> Skin:
        """Some of the facets."""
        middle, normal = facets.middle_m.take(rows, axis=0), facets.normal.take(rows, axis=0)
        return cls(facets.obstacle, middle, normal, facets.standoff_m.take(rows), facets.closed)


def seeing(tracing: Tracing, facets: Facets, spots: Spots, sights: Sights, light: Light) -> Flags:
    """(E,) which images show any of the spots that are asked first, or stand between two that do along the walk.

    Most images of second order and beyond see nothing of the body.
    """
    views, between, number = _views(tracing, facets, sights, light)
    every = max(1, int(len(spots.facet) * SAMPLE_M**2 / facets.area_m2.sum()))
    sample, seen = Skin.of(facets, spots.facet[::every]), np.zeros(len(views), dtype=bool)
    for view, item in _each_with_each(between.in_turn[0], len(sample.normal)):
        seen[view[_reached(tracing, sample, views, view, item)]] = True
    return (seen[between.before] | seen[between.after])[number]


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
        return facets, lit[:, spots.of_facet], number
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
    skin = facets.normal, dot(facets.middle_m, facets.normal), facets.closed, by_spot, begin, quarters
    asked = np.bincount(of_facet, np.where(quarters < 0, 1, 4), state.shape[1])
    rays = ((state >= BORDER) @ asked).astype(np.int64)
    # made anew for each call the room takes half of the time of all
    room = np.empty((2, AT_ONCE + int(rays.max(initial=0))), dtype=np.int64)
    for chosen in between.in_turn:
        for some in _in_parts(rays[chosen]):
            view, item = _spread(image, chosen[some], *skin, state, every, room)  # type: ignore[call-arg]
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


@compiled
def _spread(image, chosen, normal, height, closed, by_spot, begin, quarters, state, every, room):
    """Fill in for the facets (V, F) of chosen views, all dark so far, what their spots say (V, S) where they face it.

    Args:
        by_spot, begin: facets spot by spot, and (S + 1,) where each spot begins among them.
        quarters: the first of the four quarters of each facet, -1 where it has none.
        room: (2, R) or more.

    Returns (R,) views and (R,) facets to be asked one by one, in `room`: quarters instead of facets that have them.
    """
    view, facet = room
    count = 0
    for v in chosen:
        x, y, z = image[v, 0], image[v, 1], image[v, 2]
        for s in range(len(begin) - 1):
            says = state[v, s]
            if says == DARK:
                continue
            for i in range(begin[s], begin[s + 1]):
                f = by_spot[i]
                if closed and not _faces(x, y, z, normal, height, f):
                    continue
                first = quarters[f]
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
    row, stops = _paths_to(
        tracing.mirrors, views.pose, views.order, views.sequence, views.start_m,
        tracing.placed[views.pose, skin.obstacle], *skin[1:], tracing.world.clear_m, view, item,
    )  # type: ignore[call-arg]  # fmt: skip
    reached = np.zeros(len(view), dtype=bool)
    reached[row] = _free(tracing, stops, views.pose[view[row]], views.order[view[row]])
    return reached


@compiled
def _paths_to(mirrors, pose, order, sequence, start, frame, middle, normal, clearance, closed, gap, view, facet):
    """Which of some views (R,) and facets (R,) face each other through the mirrors of the view.

    Returns (P,) rows, and (K + 2, P, 3) where sound starts, its crossings of the mirrors `gap` off them, and
    the middle of the facet, off it by its clearance: the last ones of K + 2 where the view has fewer mirrors.
    """
    # numbers, not parts of arrays, as in `backtrack`
    width = sequence.shape[1]
    row, stops = np.empty(len(view), np.int64), np.empty((width + 2, len(view), 3))
    turns, images, hits, foot = np.empty(width, np.int64), np.empty((width + 1, 3)), np.empty((width, 3)), np.empty(3)
    count, c, s, x, y, z = 0, 1.0, 0.0, 0.0, 0.0, 0.0
    for r in range(len(view)):
        v, f = view[r], facet[r]
        n, last = pose[v], order[v]
        if r == 0 or view[r - 1] != v:
            for k in range(width):
                turns[k] = sequence[v, k]
            fill_images(mirrors, n, start[v], turns, last, images)
            c, s = np.cos(frame[v, 3]), np.sin(frame[v, 3])
            east, north, z = images[last, 0] - frame[v, 0], images[last, 1] - frame[v, 1], images[last, 2] - frame[v, 2]
            x, y = rotated_back(east, north, c, s)
        i, j, k = normal[f, 0], normal[f, 1], normal[f, 2]
        rise = (x - middle[f, 0]) * i + (y - middle[f, 1]) * j + (z - middle[f, 2]) * k
        if closed and rise <= 0.0:
            continue
        foot[0] = c * middle[f, 0] - s * middle[f, 1] + frame[v, 0]
        foot[1] = s * middle[f, 0] + c * middle[f, 1] + frame[v, 1]
        foot[2] = middle[f, 2] + frame[v, 2]
        if backtrack(mirrors, n, images, turns, last, foot, hits) != REACHED:
            continue
        offset = clearance[f] if rise >= 0.0 else -clearance[f]
        i, j = c * i - s * j, s * i + c * j
        _put(stops, width + 1, count, foot[0] + offset * i, foot[1] + offset * j, foot[2] + offset * k)
        here, there, up = start[v, 0], start[v, 1], start[v, 2]
        _put(stops, width - last, count, here, there, up)
        for m in range(last):
            i, j, k = mirrors.normal[n, turns[m], 0], mirrors.normal[n, turns[m], 1], mirrors.normal[n, turns[m], 2]
            above = (here - hits[m, 0]) * i + (there - hits[m, 1]) * j + (up - hits[m, 2]) * k
            offset = gap if above >= 0.0 else -gap
            here, there, up = hits[m, 0], hits[m, 1], hits[m, 2]
            _put(stops, width - last + 1 + m, count, here + offset * i, there + offset * j, up + offset * k)
        row[count] = r
        count += 1
    return row[:count], stops[:, :count]


@inlined
def _put(stops, place, row, x, y, z):
    """Fill in one of the stops of a path."""
    stops[place, row, 0], stops[place, row, 1], stops[place, row, 2] = x, y, z


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
