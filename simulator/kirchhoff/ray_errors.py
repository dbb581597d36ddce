"""How far rays off a smooth surface err because it ends, or because something hides a part of it.

A ray knows nothing of the rim beyond its reflection point. The rim's own contribution is that of the end of a line
of stationary phase: the echo that an endless surface would return, times

    sqrt(1/l + 1/m) / (sqrt(2 pi k) g)

with the distances l, m of both ends and the slope g of the path length across the rim (0.225 over Fresnel's nu). Of a
rim that is as far from the phone all round, as that of a cone on whose axis it is, more is in phase. It
counts as an error as far as it reaches, after the matched filter, into any echo of the obstacle that stands apart from
louder ones. Where it is louder than what they leave at its own delay it is an echo of its own, which rays lack. Beside
louder waves of the rim over other images it counts even if it is under the noise by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.compiled_vectors import distance, dot
from simulator.images.image_pairs import Pairs
from simulator.kirchhoff.floors import gaps_to_floors
from simulator.kirchhoff.rays_over_pairs import loudest_over
from simulator.kirchhoff.shadows import hidden_share
from simulator.surfaces.surface_borders import Border
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest, rotated
from simulator.world.search_context import Search
from simulator.world.world import Tracing

PULSE_M = 0.107  # of path: exp(-(x / this)^2) is the compressed Hann chirp to its -3 dB points, 6.3 cm of range apart
UNFELT = 23.0  # of (x / PULSE_M)^2: beyond, an echo leaves less than 1e-10
MOST = 0.5  # of an endless surface's echo: what its rim returns at the most, with the mirror point on it
UPRIGHT = 1e-3  # sine of the lean: over a Fresnel zone (0.24 m at 7 m) the image is off by twice that, lambda / 35
LYING = 1.0 - UPRIGHT  # cosine: so a bin's bottom lies on the ground
DB_PER_SHARE = 20.0 / np.log(10.0)
FAINT_GAIN = 1e-3  # -60 dB re 1 m, under the noise of a quiet street: what is weaker stays rays
TOLERATED_DB = 0.5  # from which tolerance on a rim may be as loud as that before it counts; less in proportion


def ray_error_db(search: Search, index: int, pairs: Pairs, echoes: Candidates) -> Floats:
    """(R,) estimated error of rays over each pair off smooth surface `index`: by its rim and by shadows over it.

    Args:
        echoes: what the rays found, of any obstacle.
    """
    met = _met(search.tracing, pairs.obstacle, echoes)
    stacked, borders = _Echoes.of(search.tracing, met), search.tracing.world.borders[index]
    error = np.zeros(len(pairs))
    for border, ends in zip(borders, _ends_at(search.tracing, borders, pairs), strict=True):
        rim = _rim_echo(border, ends, search.wavenumber_1_m)
        error = np.maximum(error, _rim_error_db(search, *rim, pairs, stacked))
    return error + _shadow_error_db(search, pairs, met, stacked)


def _met(tracing: Tracing, obstacle: int, echoes: Candidates) -> Candidates:
    """Rays that meet an obstacle, edges apart."""
    meets = (tracing.world.obstacle_of(echoes.sequence) == obstacle).any(axis=1)
    return echoes[np.flatnonzero(meets & (echoes.edge < 0) & (echoes.order > 0))]


def _shadow_error_db(search: Search, pairs: Pairs, met: Candidates, echoes: _Echoes) -> Floats:
    """(R,) error of rays over pairs whose zone round the reflection point is hidden in part, as far as loud."""
    tracing = search.tracing
    slot = (tracing.world.obstacle_of(met.sequence) == pairs.obstacle).argmax(axis=1)
    loss = met.amplitude * hidden_share(tracing, met, slot, search.wavenumber_1_m)
    envelope = echoes.at_rays
    share = np.where(envelope > FAINT_GAIN, loss / np.maximum(envelope, FAINT_GAIN), 0.0)
    return DB_PER_SHARE * loudest_over(tracing, met, share, pairs)


def _rim_error_db(search: Search, rim: Floats, path: Floats, pairs: Pairs, echoes: _Echoes) -> Floats:
    """(R,) estimated error that echoes of a rim (R,) make on each pair, by their paths; infinite if they are all."""
    audible, at = search.audible, (pairs.pose, pairs.mic)
    floor = max(audible.floor, FAINT_GAIN * min(search.fidelity.tolerance_db / TOLERATED_DB, 1.0))
    beside = _reaching(echoes.level, echoes.length_m, path, *at)  # type: ignore[call-arg]
    apart = np.where(echoes.envelope >= floor, 1.0 / np.maximum(echoes.envelope, floor), 0.0)
    share = rim * _reaching(apart, echoes.length_m, path, *at)  # type: ignore[call-arg]
    level, length_m = _stacked(len(search.tracing.pose), _places(*at), rim, path)
    among = _reaching(level, length_m, path, *at)  # type: ignore[call-arg]
    share = np.where(among > beside, np.maximum(share, rim / np.maximum(among, floor)), share)
    error = np.where((rim > beside) & (rim >= floor), np.inf, DB_PER_SHARE * share)
    received = (path <= search.limit_m) & (np.maximum(among, beside) >= floor)
    return np.where(received, error, 0.0)


@dataclass(frozen=True)
class _Echoes:
    """Up to E echoes of one obstacle at each of N poses and each microphone; those that are not there have level 0.

    Attributes:
        level, length_m: (N, 2, E) amplitude and path.
        envelope: (N, 2, E) greatest amplitude that any of them has there after the matched filter.
        at_rays: (C,) the same for each ray that they came from.
    """

    level: Floats
    length_m: Floats
    envelope: Floats
    at_rays: Floats

    @classmethod
    def of(cls, tracing: Tracing, met: Candidates) -> _Echoes:
        """Those of the candidates, by pose and microphone."""
        where = _places(met.pose, met.mic)
        level, length = _stacked(len(tracing.pose), where, met.amplitude, met.length_m)
        at_rays = _reaching(level, length, met.length_m, met.pose, met.mic)  # type: ignore[call-arg]
        (envelope,) = _stacked(len(tracing.pose), where, at_rays)
        return cls(level, length, envelope, at_rays)


def _stacked(poses: int, where: tuple[Ints, Ints, Ints], *columns: Floats) -> list[Floats]:
    """(N, 2, E) of columns (R,) by pose, microphone and number there; 0 where there are fewer than E."""
    stacks = [np.zeros((poses, 2, where[2].max(initial=-1) + 1)) for _ in columns]
    for stack, column in zip(stacks, columns, strict=True):
        stack[where] = column
    return stacks


def _places(pose: Ints, mic: Ints) -> tuple[Ints, Ints, Ints]:
    """Pose and microphone (R,), and how many there are before each at these."""
    key = 2 * pose + mic
    order = np.argsort(key, kind="stable")
    place = np.empty(len(key), dtype=np.int64)
    place[order] = np.arange(len(key)) - np.searchsorted(key[order], key[order])
    return pose, mic, place


@compiled
def _reaching(level, length_m, path_m, pose, mic):
    """(R,) the most that any of E echoes (N, 2, E) leaves, after the matched filter, at a path (R,) of its own."""
    most = np.zeros(len(path_m))
    for r in range(len(path_m)):
        for e in range(level.shape[2]):
            apart = (path_m[r] - length_m[pose[r], mic[r], e]) / PULSE_M
            if apart * apart < UNFELT and level[pose[r], mic[r], e] > most[r]:
                most[r] = max(most[r], level[pose[r], mic[r], e] * np.exp(-(apart * apart)))
    return most


@dataclass(frozen=True)
class _Ends:
    """R pairs of images before a border, in its rest frame.

    Attributes:
        source, receiver: (R, 3).
        closed: whether what ends at the border is closed, so that its back makes no echo.
        touching: (U, B) whether points of the border are none at each pose that occurs, see `_touching`.
        row: (R,) which of these poses each pair is at.
    """

    source: Floats
    receiver: Floats
    closed: bool
    touching: Flags
    row: Ints


def _ends_at(tracing: Tracing, borders: Sequence[Border], pairs: Pairs) -> list[_Ends]:
    """The pairs before each of a body's borders."""
    if not borders:
        return []
    frame, closed = tracing.placed[pairs.pose, pairs.obstacle], tracing.world.skins[pairs.obstacle][0].closed
    ends = into_rest(pairs.before.point_m, frame), into_rest(pairs.after.point_m, frame)
    touching, row = _touching(tracing, pairs.obstacle, Border.joined(borders), pairs.pose)
    each = np.split(touching, np.cumsum([len(border) for border in borders])[:-1], axis=1)
    return [_Ends(*ends, closed, np.ascontiguousarray(part), row) for part in each]


def _rim_echo(border: Border, ends: _Ends, wavenumber: float) -> tuple[Floats, Floats]:
    """(R,) amplitude and (R,) path of what the border returns between images of speaker and microphone."""
    points = border.point_m, border.length_m, border.normal
    first, in_phase = _shortest(
        ends.source, ends.receiver, *points, ends.closed, ends.touching, ends.row, 0.5 * np.pi / wavenumber
    )  # type: ignore[call-arg]
    to_source, to_receiver = (end - border.point_m[first] for end in (ends.source, ends.receiver))
    l, m = np.linalg.norm(to_source, axis=1), np.linalg.norm(to_receiver, axis=1)
    both = to_source / l[:, None] + to_receiver / m[:, None]
    slope = np.abs(np.einsum("rx,rx->r", both, border.across[first]))
    facing = np.einsum("rx,rx->r", both, border.normal[first])
    bend = border.bend_1_m[first] * np.where(facing < 0.0, -1.0, 1.0)
    bent = 1.0 + 2.0 * np.maximum(bend, 0.0) * l * m / (l + m)
    share = np.sqrt(1.0 / l + 1.0 / m) / (np.sqrt(2.0 * np.pi * wavenumber) * np.maximum(slope, 1e-12))
    share *= _step(border, first, share, l * m / (l + m))
    straight = np.sqrt(4.0 * np.pi / wavenumber * l * m / (l + m))
    amplitude = np.minimum(share, MOST) / (l + m) * np.maximum(1.0 / np.sqrt(bent), in_phase / straight)
    return np.where(first >= 0, amplitude, 0.0), np.where(first >= 0, l + m, 0.0)


@compiled
def _shortest(source, receiver, point, part, normal, closed, touching, row, alike):
    """(R,) which border point (B, 3) makes the shortest way between source and receiver (R, 3), -1 without one, and
    (R,) length of the parts (B,) of the border that other points stand for over which it is longer by up to `alike`.

    Points that touch, by `touching` (U, B) in row `row` (R,), make none, nor does the back of a closed surface; both
    sides of an open one reflect.
    """
    first, length, way = np.full(len(source), -1), np.zeros(len(source)), np.empty(len(point))
    for r in range(len(source)):
        shortest = np.inf
        for b in range(len(point)):
            l, m = distance(source[r], point[b]), distance(receiver[r], point[b])
            way[b] = np.inf
            if l + m < shortest + alike and not touching[row[r], b]:
                height = dot(point[b], normal[b])
                facing = (dot(source[r], normal[b]) - height) / l + (dot(receiver[r], normal[b]) - height) / m
                if facing > 0.0 or not closed:
                    way[b] = l + m
                    if l + m < shortest:
                        first[r], shortest = b, l + m
        for b in range(len(point)):
            if b != first[r] and way[b] < shortest + alike:
                length[r] += part[b]
    return first, length


def _step(border: Border, at: Ints, share: Floats, arm_m: Floats) -> Floats:
    """(R,) factor for borders where only the curvature ends: what both sides send cancels to the next order in 1/k."""
    jump = 2.0 * np.abs(border.lost_1_m[at]) * arm_m
    return np.where(border.tangent[at], np.minimum(2.0 * np.pi * share**2 * jump, 1.0), 1.0)


def _touching(tracing: Tracing, obstacle: int, border: Border, pose: Ints) -> tuple[Flags, Ints]:
    """Points of the border where another obstacle touches the surface: that stands upright on it, so that its image
    continues it, or lies flat on it.

    A tapered bin and its image meet at an angle: both end there. Returns (U, B) whether they stand so at each pose that
    occurs, and (R,) which of these rows is each pose's.
    """
    unique, which = np.unique(pose, return_inverse=True)
    touching = np.zeros((len(unique), len(border)), dtype=bool)
    for row, n in enumerate(unique):
        gap, normal = gaps_to_floors(tracing, n, obstacle, border.point_m, border.normal)
        cosine = np.abs(rotated(border.normal, tracing.placed[n, obstacle, 3]) @ normal.T)
        touching[row] = (np.isfinite(gap) & ((cosine < UPRIGHT) | (cosine > LYING))).any(axis=1)
    return touching, which.ravel()
