"""What mirrors that end leave of the sound that an edge diffracts onto them: Fresnel's integral at a straight border.

A mirror path ends at a sharp edge, whose own waves make up for it. What an edge diffracts and a mirror reflects would
need waves diffracted twice. In their place stands the shadow of the border by Kirchhoff's approximation: with the
detour d over the border, beyond the straight way by the mirror image, so much of the reflected wave

    erfc(sqrt(jkd)) / 2

arrives where the way misses the mirror, and is taken off where it meets it: half of it on the border, from either side.
It fades out towards `REACH_RAD` of kd, where it is a wave of its own.

Where the mirror path off the edge's own face ends near the border of the next mirror, a wave over both edges belongs to
two paths. It is shared between them, more to the path whose mirror's border is nearer.

Where two mirrors meet in a corner images go on across it, and nothing fades.
"""

from __future__ import annotations

import numpy as np
from scipy.special import wofz

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import dot
from simulator.diffraction.edge_view import EdgeView
from simulator.images.given_planes import last_image
from simulator.images.image_method import OUTSIDE, REACHED, backtrack, fill_images
from simulator.images.image_tree import distance
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

REACH_RAD = 30.0  # 8 cm of detour: 5 % of the wave are left


def own_detour_m(view: EdgeView, part: Ints) -> Floats:
    """(R,) detour over edges beyond the nearest way that ends there: a mirror path off either face, or straight on."""
    s, r, turn = view.source_angle_rad, view.receiver_angle_rad, view.open_angle_rad
    product = view.source_radius_m * view.receiver_radius_m
    bends = 0.5 * (s + r), turn - 0.5 * (s + r), 0.5 * (s - r)
    nearest = np.minimum.reduce([np.cos(bend) ** 2 for bend in bends])
    way = np.sqrt(np.maximum(view.apex_path_m**2 - 4.0 * product * nearest, 0.0))
    return view.path_m(part) - way


def border_share(tracing: Tracing, found: Candidates, slot: Ints, own_m: Floats, wavenumber: Floats) -> Complexes:
    """(C, K) what the mirrors of paths (C,) over an edge, met at `slot` (C,), leave of them; 0 far beside a mirror.

    Args:
        own_m: (C,) the edges' `own_detour_m`.
    """
    share = np.ones((len(found), len(wavenumber)), dtype=np.complex128)
    for k in range(found.sequence.shape[1]):
        rows = np.flatnonzero(found.interaction[:, k] == Interaction.SPECULAR)
        if len(rows):
            share[rows] *= _of_one(tracing, found[rows], slot[rows], own_m[rows], k, wavenumber)
    return share


def _of_one(tracing: Tracing, found: Candidates, slot: Ints, own_m: Floats, k: int, wavenumber: Floats) -> Complexes:
    """(R, K) what the mirror met at place k leaves."""
    mirror = np.ascontiguousarray(found.sequence[:, k : k + 1])
    code, detour = _crossed(tracing.mirrors, found.pose, mirror, *_unfolded(found, slot, k), *tracing.world.patch_ends)  # type: ignore[call-arg]
    shadow = shadow_share(detour, own_m, wavenumber)
    return np.where((code == REACHED)[:, None], 1.0 - shadow, np.where((code == OUTSIDE)[:, None], shadow, 0.0))


def shadow_share(detour_m: Floats, own_m: Floats, wavenumber: Floats) -> Complexes:
    """(R, K) what arrives behind a border with a detour (R,), of a wave that is so far beyond its own edge's."""
    detour = np.minimum(detour_m, 1.0)
    fading = 0.5 * np.cos(0.5 * np.pi * np.minimum(detour * wavenumber.mean() / REACH_RAD, 1.0)) ** 2
    turn = detour[:, None] * wavenumber
    fading *= own_m / np.maximum(own_m + detour, 1e-300)
    share: Complexes = fading[:, None] * np.exp(-1j * turn) * wofz(1j * np.sqrt(1j * turn))
    return share


def _unfolded(found: Candidates, slot: Ints, k: int) -> tuple[Floats, Floats]:
    """(R, 3) either end of the way over mirror k, transducer and edge, as it is seen in the mirrors between.

    The edge may stand on the mirror, so that the way to it is looked for from the transducer.
    """
    each, early, width = np.arange(len(found)), slot > k, found.sequence.shape[1]
    planes = found.normal, dot(found.normal, found.points_m[:, 1:-1])
    first, last = np.where(early, 0, slot + 1), np.where(early, slot, found.order)
    before = [(i, i >= first) for i in range(k)]
    after = [(i, i < last) for i in reversed(range(k + 1, width))]
    one = last_image(found.points_m[each, first], *planes, before)
    other = last_image(found.points_m[each, last + 1], *planes, after)
    side = early[:, None]
    return np.where(side, one, other), np.where(side, other, one)


@compiled
def _crossed(mirrors, pose, sequence, one, other, start, end, first):
    """(R,) code of segments by one mirror (R, 1), and (R,) least detour over its edges (`patch_ends`); else infinite.

    Args:
        one, other: (R, 3) ends of each segment.
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
        for i in range(first[p], first[p + 1]):
            least[r] = min(least[r], _detour(a, b, start[i], end[i]))
    return code, least


@compiled
def fill_rest(point, frame, local):
    """Fill in a world point as seen in a rest frame."""
    c, s = np.cos(frame[3]), np.sin(frame[3])
    x, y = point[0] - frame[0], point[1] - frame[1]
    local[0], local[1], local[2] = c * x + s * y, c * y - s * x, point[2] - frame[2]


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
