"""Two curved reflections in one path, off two different bodies, with mirrors before and after them.

Both reflection points are stationary at once. Each is found on its own first, with the other body represented by the
spot over which the way is shortest; from there the two settle together.

A second bounce off a convex body costs 15-25 dB, so most pairs are not worth the search. Before it, a pair is judged by
the single echoes of its two bodies, with `JUDGED_DB` to spare for what differs towards the other body; 10 dB instead
of 6 add 4 to 1460 paths. On campus walks among four to eight bodies tracing takes 1.05 to 1.09 times as long for it.

Round bodies have one such path a pair and direction, and it is found. On bodies of many humps the search is not
exhaustive: among cars and people, starts from ten other spots each added a third to the paths, -49 dB and less
beside a strongest of -39 dB.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.distinct_rows import distinct
from obstaclewatch.support.rows import Rows
from simulator.curved import stationary as curved
from simulator.curved.stationary_pairs import settle
from simulator.images.given_planes import image_in
from simulator.images.image_pairs import Pairs, centers, images_of, matches
from simulator.images.image_tree import Images
from simulator.images.unfolding import Turns, straightened, unfolded
from simulator.surfaces.reflectors import SmoothSurface
from simulator.waves.band import REFERENCE_HZ
from simulator.waves.spreading import spreading
from simulator.world.candidates import Candidates
from simulator.world.frames import out_of_rest
from simulator.world.interactions import Interaction
from simulator.world.rejection_log import Reason, Rejected
from simulator.world.search_context import Search
from simulator.world.world import Tracing

MASKED = 10.0 ** (-40.0 / 20.0)  # a contribution this far under the strongest echo is lost in it
OVER_SHARE = 10.0 ** (10.0 / 20.0)  # or this far over the share that edges are held to, where that is less
DIRECTIONS = ((0, False), (1, False), (0, True), (1, True))  # microphone, and whether the pair is run through backwards
JUDGED_DB = 6.0  # by how much a body may echo louder towards another body than it does towards the phone
SAME_M = 1e-6


@dataclass(frozen=True)
class Sighting(Rows):
    """R places of one surface that may pass sound on between the phone and another surface.

    Attributes:
        images: of the phone's middle, one a row, mirrors from the phone on.
        face, uv: (R,), (R, 2) place on the surface.
        point_m: (R, 3).
        factor: (R,) amplitude relative to that of a rigid plane.
    """

    images: Images
    face: Ints
    uv: Floats
    point_m: Floats
    factor: Floats


def twice_curved(search: Search, singles: list[Candidates | None], loudest: Floats) -> list[Candidates]:
    """Paths with two reflections off smooth surfaces of different obstacles.

    What is under the audible floor, or `MASKED` under the strongest echo of the pose, is left out; a floor of 0 keeps
    all.

    Args:
        singles: echoes with one curved reflection, in the order of the surfaces; None where a surface has no rays.
        loudest: (N, 2) strongest of all those found so far.
    """
    tracing, audible = search.tracing, search.audible
    middles = [centers(tracing, surface) for surface in tracing.world.surfaces]
    parts, factor = [], _factors(tracing, singles)
    masked = min(MASKED, OVER_SHARE * audible.share) if audible.floor > 0.0 else 0.0
    threshold = np.maximum(audible.floor, masked * loudest.max(axis=1))
    for a in range(len(factor)):
        for b in range(a + 1, len(factor)):
            shortest = _shortest(tracing, (a, b), middles)
            bound = 10.0 ** (JUDGED_DB / 20.0) * factor[a] * factor[b] / np.maximum(shortest, 1e-3)
            poses = np.flatnonzero((bound >= threshold) & (shortest <= search.limit_m))
            if len(poses):
                parts += _between(search, (a, b), middles, poses, threshold)
    return parts


def _factors(tracing: Tracing, singles: list[Candidates | None]) -> Floats:
    """(S, N) each surface's strongest echo at each pose relative to a rigid plane's; that of a plane where none is.

    0 for surfaces without rays.
    """
    out = np.zeros((len(singles), len(tracing.pose)))
    for found, factor, surface in zip(singles, out, tracing.world.surfaces, strict=True):
        if found is None:
            continue
        alone = found[found.order == 1]
        np.maximum.at(factor, alone.pose, alone.amplitude * alone.length_m)
        factor[factor == 0.0] = 1.0
        np.minimum(factor, 1.0, out=factor)
        factor *= _loss(tracing, surface)
    return out


def _loss(tracing: Tracing, surface: SmoothSurface) -> float:
    """Greatest reflection factor of a surface's material over the angles."""
    material = tracing.world.obstacles[surface.obstacle].material
    return float(np.abs(material.reflection(np.array([REFERENCE_HZ]), np.linspace(0.05, 1.0, 20)[:, None])).max())


def _shortest(tracing: Tracing, pair: tuple[int, int], middles: list[Floats]) -> Floats:
    """(N,) no way from the phone over both surfaces and back is shorter.

    Args:
        middles: (N, 3) of each surface's bounding sphere.
    """
    phone, (first, second) = tracing.middle_m, (middles[index] for index in pair)
    radius = [tracing.world.surfaces[index].radius_m for index in pair]
    out = np.maximum(np.linalg.norm(first - phone, axis=1) - radius[0], 0.0)
    back = np.maximum(np.linalg.norm(second - phone, axis=1) - radius[1], 0.0)
    return out + back + np.maximum(np.linalg.norm(second - first, axis=1) - sum(radius), 0.0)


def _between(
    search: Search, pair: tuple[int, int], middles: list[Floats], poses: Ints, threshold: Floats
) -> list[Candidates]:
    """Paths over two surfaces, either first."""
    tracing, (a, b) = search.tracing, pair
    left = _sighted(search, a, _spots(tracing, b, middles[a], poses), poses)
    right = _sighted(search, b, _spots(tracing, a, middles[b], poses), poses)
    left, right = _combined(left, right, search.max_order - 2)
    audible = _amplitude(left, right) >= threshold[left.images.pose]
    loud, faint = np.flatnonzero(audible), np.flatnonzero(~audible)
    _reject_faint(search, left[faint], right[faint], (a, b))
    _reject_faint(search, right[faint], left[faint], (b, a))
    return _both_directions(search, pair, left[loud], right[loud]) if len(loud) else []


def _spots(tracing: Tracing, index: int, other_m: Floats, poses: Ints) -> Floats:
    """(N, 3) the group of facets of a surface over which the way from the phone to another's middle (N, 3) is shortest.

    Worked out at `poses`; NaN at all others.
    """
    surface = tracing.world.surfaces[index]
    frame = tracing.placed[poses, surface.obstacle]
    groups = surface.clusters.spot_m
    place = out_of_rest(np.broadcast_to(groups, (len(frame), *groups.shape)), frame[:, None])
    ends = tracing.middle_m[poses], other_m[poses]
    way = sum(np.linalg.norm(place - end[:, None], axis=2) for end in ends)
    spot = np.full((len(tracing.pose), 3), np.nan)
    spot[poses] = place[np.arange(len(poses)), np.argmin(way, axis=1)]
    return spot


def _sighted(search: Search, index: int, target: Floats, poses: Ints) -> Sighting:
    """Where a surface mirrors images of the phone's middle into targets (N, 3)."""
    tracing = search.tracing
    surface, middle = tracing.world.surfaces[index], tracing.middle_m
    extent = float(np.linalg.norm(tracing.transducers_m - middle[:, None], axis=2).max())
    images = images_of(search, surface, middle, search.max_order - 2, extent)
    images = images[np.flatnonzero(np.isin(images.pose, poses))]
    frame = tracing.placed[images.pose, surface.obstacle]
    name = tracing.world.obstacles[surface.obstacle].name
    hit = curved.find(surface, name, frame, images.point_m, target[images.pose])
    images, once = images[hit.query], np.ones(len(hit), dtype=np.int64)
    points = np.stack([images.point_m, hit.point_m, target[images.pose]], axis=1)
    amplitude = np.abs(spreading(points, hit.normal[:, None], hit.curvature[:, None], once))
    length = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)
    factor = np.minimum(amplitude * length, 1.0) * _loss(tracing, surface)
    return Sighting(images, hit.face, hit.uv, points[:, 1], factor)


def _combined(left: Sighting, right: Sighting, mirrors: int) -> tuple[Sighting, Sighting]:
    """Every sighting of one surface with every one of the other at the same pose, within the order."""
    one, other = left.images, right.images
    first, second = matches(one.pose, one.order, other.pose, other.order, mirrors)
    return left[first], right[second]


def _amplitude(start: Sighting, end: Sighting) -> Floats:
    """(R,) estimated gain of the way over two places."""
    points = np.stack([start.images.point_m, start.point_m, end.point_m, end.images.point_m], axis=1)
    return start.factor * end.factor / np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)


def _reject_faint(search: Search, start: Sighting, end: Sighting, pair: tuple[int, int]) -> None:
    """Book paths to either microphone below the floor, over the places where they would have been looked for."""
    mic, (start, end) = np.repeat([0, 1], len(start)), (each[np.tile(np.arange(len(each)), 2)] for each in (start, end))
    points = np.stack([start.point_m, end.point_m], axis=1)
    turns = Turns(Pairs(mic, start.images, end.images), points, _numbers(search.tracing, pair, len(points)))
    search.reject(
        Reason.FAINT_DOUBLE, len(points),
        lambda: Rejected(_amplitude(start, end), partial(straightened, search, turns)),
    )  # fmt: skip


def _numbers(tracing: Tracing, pair: tuple[int, int], rows: int) -> Ints:
    """(R, 2) two surfaces among the reflectors."""
    return np.broadcast_to(tracing.world.numbering.number(Interaction.CURVED, pair), (rows, 2))


def _both_directions(search: Search, pair: tuple[int, int], left: Sighting, right: Sighting) -> list[Candidates]:
    """Candidates over two surfaces, from left to right and back; all settle at once, as lengths have no direction."""
    tracing = search.tracing
    source, mics = tracing.source_m[left.images.pose], tracing.mics_m[left.images.pose]
    near = [mics[:, mic] if back else source for mic, back in DIRECTIONS]
    far = [source if back else mics[:, mic] for mic, back in DIRECTIONS]
    rows = np.tile(np.arange(len(left.face)), len(DIRECTIONS))
    every_left, every_right = left[rows], right[rows]
    source = _through(tracing, np.concatenate(near), every_left.images)
    receiver = _through(tracing, np.concatenate(far), every_right.images)
    surfaces = [tracing.world.surfaces[index] for index in pair]
    frames = [tracing.placed[every_left.images.pose, surface.obstacle] for surface in surfaces]
    guess = (every_left.face, every_left.uv), (every_right.face, every_right.uv)
    first, second, settled = settle(surfaces, frames, source, receiver, guess, every_right.point_m)
    way = np.repeat(np.arange(len(DIRECTIONS)), len(left.face))
    settled &= _first_of_equals(way, every_left.images, every_right.images, first.point_m, second.point_m)
    parts = []
    for number, (mic, back) in enumerate(DIRECTIONS):
        kept = np.flatnonzero(settled & (way == number))
        met = [
            (pair[0], every_left.images[kept], first[kept], source[kept]),
            (pair[1], every_right.images[kept], second[kept], receiver[kept]),
        ]
        parts.append(_paths(search, mic, met[::-1] if back else met))
    return parts


def _paths(search: Search, mic: int, met: list[tuple[int, Images, curved.StationaryPoints, Floats]]) -> Candidates:
    """Candidates over two settled places, each given with its surface, the images on its side and the end's image."""
    (one, before, first, source), (two, after, second, receiver) = met
    points = np.stack([first.point_m, second.point_m], axis=1)

    def amplitude() -> Floats:
        way = np.stack([source, first.point_m, second.point_m, receiver], axis=1)
        return np.abs(spreading(way, both["normal"], both["curvature"], np.full(len(way), 2)))

    pairs = Pairs(np.full(len(points), mic), before, after)
    both = {name: np.stack([column, second.known[name]], axis=1) for name, column in first.known.items()}
    turns = Turns(pairs, points, _numbers(search.tracing, (one, two), len(points)), both)
    return unfolded(search, turns, amplitude)[0]


def _through(tracing: Tracing, point_m: Floats, images: Images) -> Floats:
    """(R, 3) images of points in the mirrors of other images."""
    return image_in(tracing.mirrors, point_m, images.pose, images.order, images.sequence)


def _first_of_equals(way: Ints, before: Images, after: Images, first: Floats, second: Floats) -> Flags:
    """(R,) False for paths that settled where an earlier one did."""
    places = np.round(np.concatenate([first, second], axis=1) / SAME_M)
    columns = np.column_stack([way, before.pose, before.sequence, after.sequence, places])
    mask = np.zeros(len(way), dtype=bool)
    mask[distinct(columns)[0]] = True
    return mask
