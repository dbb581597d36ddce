"""Which mechanism suffices: where rays off a smooth surface err because the surface ends.

A ray knows nothing of the rim beyond its reflection point. The rim's own contribution is that of the end of a line
of stationary phase: the echo that an endless surface would return, times

    sqrt(1/l + 1/m) / (sqrt(2 pi k) g)

with the distances l, m of both ends and the slope g of the path length across the rim (0.225 over Fresnel's nu). It
counts as an error as far as it reaches, after the matched filter, into any echo of the obstacle that stands apart from
louder ones. Where it is louder than what they leave at its own delay it is an echo of its own, which rays lack. Paths
over an obstacle whose rims err together by more than the tolerance are left to Kirchhoff's integral, the others stay
rays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.kirchhoff.image_pairs import Pairs, loudest_over, pairs_over, swapped_too
from simulator.kirchhoff.shadows import hidden_share
from simulator.scene.fidelity import Fidelity
from simulator.surfaces.facets import can_cut
from simulator.surfaces.reflectors import SmoothSurface
from simulator.surfaces.surface_borders import Border
from simulator.waves.spreading import spreading
from simulator.world.audible import Audible
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest, out_of_rest, rotated
from simulator.world.rejection_log import Choice
from simulator.world.search_context import Search
from simulator.world.world import Tracing

PULSE_M = 0.107  # of path: exp(-(x / this)^2) is the compressed Hann chirp to its -3 dB points, 6.3 cm of range apart
MOST = 0.5  # of an endless surface's echo: what its rim returns at the most, with the mirror point on it
TOUCHING_M = 2e-3
UPRIGHT = 1e-3  # sine of the lean: over a Fresnel zone (0.24 m at 7 m) the image is off by twice that, lambda / 35
DB_PER_SHARE = 20.0 / np.log(10.0)
UNEVEN = 0.13  # scanned people have 0.18-0.21, cars 0.15-0.16; bins, posts and signs 0-0.1
FAINT_GAIN = 1e-3  # -60 dB re 1 m, under the noise of a quiet street: what is weaker stays rays
FEW = 8.0  # pairs that err by less than the tolerance over this stay rays
CAUTION = 6.0  # on estimated errors: at 2, echoes of bins stayed 1.5-1.9 dB off where 0.5 dB was asked for


def left_to_integral(search: Search, echoes: Candidates, uneven: set[int]) -> list[Pairs]:
    """Pairs of images over obstacles that Kirchhoff's integral is needed for, obstacle by obstacle.

    All those over an obstacle that no mechanism of the fidelity can reach otherwise, and those whose rims or whose
    uneven surface spoil its echo, unless it is too large to be cut into facets, or the walker's own body: those are
    left to rays. The log books what was chosen, and the estimates behind it.

    Args:
        echoes: what the rays found.
        uneven: `uneven_surfaces`, on which no ray was looked for.
    """
    tracing, fidelity, audible, wavenumber = search.tracing, search.fidelity, search.audible, search.wavenumber_1_m
    world, mechanisms = tracing.world, fidelity.mechanisms
    if "kirchhoff" not in mechanisms:
        return []
    chosen = []
    for obstacle, (reading, _) in enumerate(world.skins):
        flat, bent = bool((reading.patch >= 0).any()), bool(reading.curved.any())
        if (flat and "specular" not in mechanisms) or (bent and "curved" not in mechanisms):
            chosen.append(pairs_over(search, obstacle))
    rims_count = np.isfinite(fidelity.tolerance_db)
    for index, surface in enumerate(world.surfaces):
        if index in uneven:
            pairs = pairs_over(search, surface.obstacle)
            search.log.choices.append(
                Choice(world.obstacles[surface.obstacle].name, len(pairs), len(pairs), np.inf, 0.0)
            )
            chosen.append(pairs)
        elif rims_count and _may_be_cut(tracing, index, fidelity) and len(world.borders[index]):
            pairs = pairs_over(search, surface.obstacle)
            error = rim_error_db(tracing, index, pairs, echoes, audible, wavenumber)
            error += _shadow_error_db(tracing, surface.obstacle, pairs, echoes, wavenumber)
            needed = _needed(tracing, pairs, CAUTION * error, fidelity.tolerance_db)
            name = world.obstacles[surface.obstacle].name
            doubts = (
                _together(tracing, pairs, each).max(initial=0.0) for each in (error, np.where(needed, 0.0, error))
            )
            search.log.choices.append(Choice(name, len(pairs), int(needed.sum()), *map(float, doubts)))
            chosen.append(pairs[needed])
    return [pairs for pairs in chosen if len(pairs)]


def uneven_surfaces(tracing: Tracing, fidelity: Fidelity) -> set[int]:
    """Smooth surfaces whose rays say nothing, such as those of scanned people: no ray is looked for on them.

    Rays off people differ from the integral by 4 dB in the median and 10 dB at the 95th percentile, over 1.5-5 m.
    """
    if "kirchhoff" not in fidelity.mechanisms:
        return set()
    surfaces = enumerate(tracing.world.surfaces)
    return {i for i, each in surfaces if unevenness(each) > UNEVEN and _may_be_cut(tracing, i, fidelity)}


def _may_be_cut(tracing: Tracing, index: int, fidelity: Fidelity) -> bool:
    """Whether a surface may be left to the integral: not too large, nor part of the walker's own body."""
    obstacle = tracing.world.surfaces[index].obstacle
    reading = tracing.world.skins[obstacle][0]
    return not tracing.frames.carried[obstacle] and can_cut(reading, fidelity.facet_m)


def unevenness(surface: SmoothSurface) -> float:
    """How much the principal curvatures change within a facet, re their size, as a median.

    0 on spheres and cylinders of any number of facets: their axes turn within a facet, their curvatures do not change.
    """
    principal = np.linalg.eigvalsh(surface.curvature)
    size = np.linalg.norm(principal, axis=2).mean(axis=1)
    change = np.linalg.norm(principal - principal.mean(axis=1, keepdims=True), axis=2).mean(axis=1)
    return float(np.median(change / np.maximum(size, 1e-9)))


def _shadow_error_db(tracing: Tracing, obstacle: int, pairs: Pairs, echoes: Candidates, wavenumber: float) -> Floats:
    """(R,) error of rays over pairs whose zone round the reflection point is hidden in part, as far as loud."""
    met = _mirrored(_meeting(tracing, obstacle, echoes))
    slot = (tracing.world.obstacle_of(met.sequence) == obstacle).argmax(axis=1)
    loss = _amplitude(met) * hidden_share(tracing, met, slot, wavenumber)
    return DB_PER_SHARE * loudest_over(tracing, met, _share(tracing, met, loss), pairs)


def _share(tracing: Tracing, met: Candidates, part: Floats) -> Floats:
    """(C,) parts of rays re the obstacle's loudest echo at their delays; 0 of what is under the noise."""
    envelope = _Echoes.of(tracing, met).at_rays
    return np.where(envelope > FAINT_GAIN, part / np.maximum(envelope, FAINT_GAIN), 0.0)


def _needed(tracing: Tracing, pairs: Pairs, error_db: Floats, tolerance_db: float) -> Flags:
    """(R,) pairs to be left to the integral, each with the reverse one: they share a mirror."""
    total = _together(tracing, pairs, error_db)
    return swapped_too(pairs, (total[pairs.pose, pairs.mic] > tolerance_db) & (error_db > tolerance_db / FEW))


def _together(tracing: Tracing, pairs: Pairs, error_db: Floats) -> Floats:
    """(N, 2) errors of all pairs over an obstacle, added up at each pose and microphone."""
    total = np.zeros((len(tracing.pose), 2))
    np.add.at(total, (pairs.pose, pairs.mic), error_db)
    return total


def rim_error_db(
    tracing: Tracing, index: int, pairs: Pairs, echoes: Candidates, audible: Audible, wavenumber: float
) -> Floats:
    """(R,) estimated error that the rim of smooth surface `index` makes on each pair; infinite where it is the echo.

    Args:
        echoes: what the rays found, of any obstacle.
        audible: obstacles under its floor do no harm.
        wavenumber: rad/m.
    """
    surface = tracing.world.surfaces[index]
    echo = _Echoes.of(tracing, _mirrored(_meeting(tracing, surface.obstacle, echoes)))
    at = pairs.pose, pairs.mic
    rim, path = _rim_echo(tracing, index, pairs, wavenumber)
    near = _overlap(path[:, None] - echo.length_m[at])
    beside = (echo.level[at] * near).max(axis=1, initial=0.0)
    apart = echo.envelope[at]
    share = np.where(apart >= audible.floor, rim[:, None] * near / np.maximum(apart, audible.floor), 0.0)
    error = np.where(rim > beside, np.inf, DB_PER_SHARE * share.max(axis=1, initial=0.0))
    received = (path <= audible.limit_m) & (np.maximum(rim, beside) >= audible.floor)
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
        at = 2 * met.pose + met.mic
        order = np.argsort(at, kind="stable")
        place = np.arange(len(met)) - np.searchsorted(at[order], at[order])
        level, length = (np.zeros((len(tracing.pose), 2, place.max(initial=-1) + 1)) for _ in range(2))
        where = met.pose[order], met.mic[order], place
        level[where], length[where] = _amplitude(met)[order], met.length_m[order]
        envelope = level.copy()
        for k in range(level.shape[2]):
            np.maximum(envelope, level[..., k, None] * _overlap(length - length[..., k, None]), out=envelope)
        at_rays = np.empty(len(met))
        at_rays[order] = envelope[where]
        return cls(level, length, envelope, at_rays)


def _overlap(apart_m: Floats) -> Floats:
    """How much of an echo's peak is left, after the matched filter, at a path by so much longer or shorter."""
    return np.exp(-((apart_m / PULSE_M) ** 2))


def _meeting(tracing: Tracing, obstacle: int, echoes: Candidates) -> Candidates:
    return echoes[np.flatnonzero((tracing.world.obstacle_of(echoes.sequence) == obstacle).any(axis=1))]


def _mirrored(echoes: Candidates) -> Candidates:
    return echoes[np.flatnonzero((echoes.edge < 0) & (echoes.order > 0))]


def _amplitude(echoes: Candidates) -> Floats:
    return np.abs(spreading(echoes.points_m, echoes.normal, echoes.curvature, echoes.order))


def _rim_echo(tracing: Tracing, index: int, pairs: Pairs, wavenumber: float) -> tuple[Floats, Floats]:
    """(R,) amplitude and (R,) path of what the rim returns between images of speaker and microphone."""
    surface, border = tracing.world.surfaces[index], tracing.world.borders[index]
    obstacle = surface.obstacle
    frame = tracing.placed[pairs.pose, obstacle]
    source, receiver = into_rest(pairs.before.point_m, frame), into_rest(pairs.after.point_m, frame)
    to_source, to_receiver = (end[:, None] - border.point_m for end in (source, receiver))
    l, m = np.linalg.norm(to_source, axis=2), np.linalg.norm(to_receiver, axis=2)
    both = to_source / l[:, :, None] + to_receiver / m[:, :, None]
    facing = np.einsum("rbx,bx->rb", both, border.normal)
    lit = (facing > 0.0) | (not surface.closed)  # both sides of an open surface reflect
    path = np.where(lit & ~_touching(tracing, obstacle, border, pairs.pose), l + m, np.inf)
    first = path.argmin(axis=1)
    each = np.arange(len(pairs))
    l, m, shortest = l[each, first], m[each, first], path[each, first]
    slope = np.abs(np.einsum("rx,rx->r", both[each, first], border.across[first]))
    bend = border.bend_1_m[first] * np.where(facing[each, first] < 0.0, -1.0, 1.0)
    bent = 1.0 + 2.0 * np.maximum(bend, 0.0) * l * m / (l + m)
    share = np.sqrt(1.0 / l + 1.0 / m) / (np.sqrt(2.0 * np.pi * wavenumber) * np.maximum(slope, 1e-12))
    share *= _step(border, first, share, l * m / (l + m))
    amplitude = np.minimum(share, MOST) / ((l + m) * np.sqrt(bent))
    return np.where(np.isfinite(shortest), amplitude, 0.0), np.where(np.isfinite(shortest), shortest, 0.0)


def _step(border: Border, at: Ints, share: Floats, arm_m: Floats) -> Floats:
    """(R,) factor for borders where only the curvature ends: what both sides send cancels to the next order in 1/k."""
    jump = 2.0 * np.abs(border.lost_1_m[at]) * arm_m
    return np.where(border.tangent[at], np.minimum(2.0 * np.pi * share**2 * jump, 1.0), 1.0)


def _touching(tracing: Tracing, obstacle: int, border: Border, pose: Ints) -> Flags:
    """(R, B) points of the border that stand upright on another obstacle: its image continues the surface there.

    A tapered bin and its image meet at an angle: both end there.
    """
    patches = tracing.world.patches
    others = np.flatnonzero(patches.obstacle != obstacle)
    unique, which = np.unique(pose, return_inverse=True)
    touching = np.zeros((len(unique), len(border)), dtype=bool)
    for row, n in enumerate(unique):
        frame = tracing.placed[n]
        point = out_of_rest(border.point_m, frame[obstacle])
        normal = rotated(patches.normal[others], frame[patches.obstacle[others], 3])
        offset = patches.offset_m[others] + np.sum(normal * frame[patches.obstacle[others], :3], axis=1)
        center = out_of_rest(patches.center_m[others], frame[patches.obstacle[others]])
        gap = np.abs(point @ normal.T - offset)
        upright = np.abs(rotated(border.normal, frame[obstacle, 3]) @ normal.T) < UPRIGHT
        near = np.linalg.norm(point[:, None] - center, axis=2) <= patches.radius_m[others]
        touching[row] = ((gap < TOUCHING_M) & upright & near).any(axis=1)
    return touching[which.ravel()]
