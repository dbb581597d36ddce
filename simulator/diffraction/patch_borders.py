"""What mirrors that end leave of the sound that an edge diffracts onto them: Fresnel's integral at a straight border.

A mirror path ends at a sharp edge, whose own waves make up for it. What an edge diffracts and a mirror reflects would
need waves diffracted twice. In their place stands the shadow of the border by Kirchhoff's approximation: with the
detour d over the border, beyond the straight way by the mirror image, so much of the reflected wave

    w erfc(sqrt(jkd)) / 2

arrives where the way misses the mirror, and is taken off where it meets it. It fades out towards `BORDER_REACH_RAD` of
kd, where it is a wave of its own.

A wave over two edges belongs to two paths, one over each alone. The share w (`weights`) of that over the first edge
depends on how far its own way is from where it began, straight on or by a mirror path. Each of the three waves of an
edge (`finite_edge`) has a beginning of its own, and so a share.

Where two mirrors meet in a corner images go on across it, and nothing fades.
"""

from __future__ import annotations

import numpy as np
from scipy.special import wofz

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import distance, dot
from simulator.diffraction.edge_view import EdgeView
from simulator.images.given_planes import last_image, planes_met
from simulator.images.image_method import OUTSIDE, REACHED, backtrack, fill_images
from simulator.world.candidates import Candidates
from simulator.world.frames import fill_rest
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

BORDER_REACH_RAD = 30.0  # 8 cm of detour: 5 % of the wave are left
LEAST_RAD = 1e-12  # detours are rounded by as much
FARTHEST = 6.0  # e^-36 of the integrand is left
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(32)


def own_detours_m(view: EdgeView, part: Ints) -> Floats:
    """(R, 3) detour over edges beyond the paths that end there: straight on, and off the mirror of either face."""
    s, r, turn = view.source_angle_rad, view.receiver_angle_rad, view.open_angle_rad
    product = view.source_radius_m * view.receiver_radius_m
    bends = np.stack([0.5 * (s - r), 0.5 * (s + r), turn - 0.5 * (s + r)], axis=1)
    drop = 4.0 * product[:, None] * np.cos(bends) ** 2
    way = np.sqrt(np.maximum(view.apex_path_m[:, None] ** 2 - drop, 0.0))
    own: Floats = view.path_m(part)[:, None] - way
    return own


def border_share(tracing: Tracing, found: Candidates, slot: Ints, own_m: Floats, wavenumber: Floats) -> Complexes:
    """(C, 3, K) what the mirrors of paths (C,) over an edge, met at `slot` (C,), leave of them; 0 far beside a mirror.

    Args:
        own_m: (C, 3) the edges' `own_detours_m`.
    """
    share = np.ones((len(found), 3, len(wavenumber)), dtype=np.complex128)
    for k in range(found.sequence.shape[1]):
        rows = np.flatnonzero(found.interaction[:, k] == Interaction.SPECULAR)
        if len(rows):
            share[rows] *= _of_one(tracing, found[rows], slot[rows], own_m[rows], k, wavenumber)
    return share


def _of_one(tracing: Tracing, found: Candidates, slot: Ints, own_m: Floats, k: int, wavenumber: Floats) -> Complexes:
    """(R, 3, K) what the mirror met at place k leaves."""
    mirror = np.ascontiguousarray(found.sequence[:, k : k + 1])
    code, detour = _crossed(tracing.mirrors, found.pose, mirror, *_unfolded(found, slot, k), tracing.world.patch_ends)  # type: ignore[call-arg]
    shadow, code = shadow_share(detour, own_m, wavenumber), code[:, None, None]
    return np.where(code == REACHED, 1.0 - shadow, np.where(code == OUTSIDE, shadow, 0.0))


def shadow_share(detour_m: Floats, own_m: Floats, wavenumber: Floats) -> Complexes:
    """(R, 3, K) what of an edge's waves arrives behind a border with a detour (R,).

    Args:
        own_m: (R, 3) the edge's `own_detours_m`.
    """
    share, middle = np.zeros((*own_m.shape, len(wavenumber)), dtype=np.complex128), wavenumber.mean()
    near = np.flatnonzero(middle * detour_m < BORDER_REACH_RAD)
    detour = detour_m[near, None]
    fading = 0.5 * np.cos(0.5 * np.pi * middle * detour / BORDER_REACH_RAD) ** 2
    wave = fading * np.exp(-1j * detour * wavenumber) * _fresnel(detour * wavenumber)
    share[near] = weights(middle * own_m[near], middle * detour)[:, :, None] * wave[:, None]
    return share


def weights(own_rad: Floats, detour_rad: Floats) -> Complexes:
    """Share of a wave over two edges that comes with the first, by the phases p and q of the detours over either.

    With h^2 / 2 = jp, a = sqrt(q / p) and Owen's T (Ann. Math. Statist. 27 (1956) 1075-1090) it is

        (1 - T(h, a) / T(h, inf)) / erfc(sqrt(jq))

    so that both together are what Kirchhoff's integral has behind two half-planes in turn: 1 / 2 where the detours are
    alike, and with p and q swapped 1 less the same.
    """
    p, q = np.broadcast_arrays(np.maximum(own_rad, LEAST_RAD), np.maximum(detour_rad, LEAST_RAD))
    inside = _inside(p.flatten(), q.flatten()).reshape(p.shape)  # type: ignore[call-arg]
    share: Complexes = 2.0 / np.pi * inside / (_fresnel(p) * _fresnel(q))
    return share


@compiled
def _inside(p, q):
    """(R,) integral of `weights` along the way of steepest descent, whose phase is that of the factor before it.

    Its nodes follow the logarithm, as the integrand runs over all decades from the root of p on.
    """
    total, down = np.zeros(len(p), np.complex128), np.exp(-0.25j * np.pi)
    for r in range(len(p)):
        root, ratio, steepness = np.sqrt(p[r]), np.sqrt(q[r] / p[r]), np.sqrt(2.0 * q[r])
        span = np.log1p(FARTHEST / root)
        for k in range(len(_NODE)):
            grown = np.exp(0.5 * span * (1.0 + _NODE[k]))
            place = root * (grown - 1.0)
            angle, x = steepness * place, ratio + down * (grown - 1.0)
            if place**2 + angle > FARTHEST**2:
                break
            steep = np.exp(-(place**2) - angle) * (np.cos(angle) - 1j * np.sin(angle))
            total[r] += _WEIGHT[k] * steep * grown / (1.0 + x * x)
        total[r] *= 0.5 * span * down
    return total


def _fresnel(phase_rad: Floats) -> Complexes:
    """erfc(sqrt(jx)) e^{jx}."""
    found: Complexes = wofz(1j * np.sqrt(1j * phase_rad))
    return found


def _unfolded(found: Candidates, slot: Ints, k: int) -> tuple[Floats, Floats]:
    """(R, 3) either end of the way over mirror k, transducer and edge, as it is seen in the mirrors between.

    The edge may stand on the mirror, so that the way to it is looked for from the transducer.
    """
    each, early, width = np.arange(len(found)), slot > k, found.sequence.shape[1]
    planes = planes_met(found)
    first, last = np.where(early, 0, slot + 1), np.where(early, slot, found.order)
    before = [(i, i >= first) for i in range(k)]
    after = [(i, i < last) for i in reversed(range(k + 1, width))]
    one = last_image(found.points_m[each, first], *planes, before)
    other = last_image(found.points_m[each, last + 1], *planes, after)
    side = early[:, None]
    return np.where(side, one, other), np.where(side, other, one)


@compiled
def _crossed(mirrors, pose, sequence, one, other, ends):
    """(R,) code of segments by one mirror (R, 1), and (R,) least detour over its ends; infinite without one.

    Args:
        one, other: (R, 3) ends of each segment.
        ends: `PatchEnds`.
    """
    code, least = np.empty(len(pose), np.int64), np.full(len(pose), np.inf)
    images, hits, a, b = np.empty((2, 3)), np.empty((1, 3)), np.empty(3), np.empty(3)
    for r in range(len(pose)):
        n, p = pose[r], sequence[r, 0]
        fill_images(mirrors, n, one[r], sequence[r], len(sequence[r]), images)
        code[r] = backtrack(mirrors, n, images, sequence[r], len(sequence[r]), other[r], hits)
        frame = mirrors.frames[n, mirrors.obstacle[p]]
        fill_rest(images[1], frame, a)
        fill_rest(other[r], frame, b)
        for i in range(ends.first[p], ends.first[p + 1]):
            if dot(a, ends.outwards[i]) <= dot(ends.start_m[i], ends.outwards[i]):  # behind it is the image
                least[r] = min(least[r], _detour(a, b, ends.start_m[i], ends.end_m[i]))
    return code, least


@inlined
def _detour(a, b, start, end):
    """How much longer than the straight way from a to b is the shortest one over an edge."""
    _, to, fro = over_edge(a, b, start, end)
    return max(to + fro - distance(a, b), 0.0)


@inlined
def over_edge(a, b, start, end):
    """Where the shortest way from a to b over an edge meets it, above its start, and its lengths up to there and on."""
    square = along_a = along_b = off_a = off_b = 0.0
    for x in range(3):
        along, from_a, from_b = end[x] - start[x], a[x] - start[x], b[x] - start[x]
        square, along_a, along_b = square + along * along, along_a + from_a * along, along_b + from_b * along
        off_a, off_b = off_a + from_a * from_a, off_b + from_b * from_b
    length = np.sqrt(square)
    ha, hb = along_a / length, along_b / length
    ra, rb = np.sqrt(max(off_a - ha**2, 0.0)), np.sqrt(max(off_b - hb**2, 0.0))
    h = min(max(ha + (hb - ha) * ra / max(ra + rb, 1e-300), 0.0), length)
    return h, np.hypot(ra, h - ha), np.hypot(rb, h - hb)
