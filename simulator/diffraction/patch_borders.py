"""What mirrors that end leave of the sound that an edge diffracts onto them: Fresnel's integral at a straight border.

A mirror path ends at a sharp edge, whose own waves make up for it. What an edge diffracts and a mirror reflects would
need waves diffracted twice. In their place stands the shadow of the border by Kirchhoff's approximation: with the
detour d over the border, beyond the straight way by the mirror image, so much of the reflected wave

    erfc(sqrt(jkd)) / 2

arrives where the way misses the mirror, and is taken off where it meets it: half of it on the border, from either side.
It fades out towards `REACH_RAD` of kd, where it is a wave of its own.

Where the mirror path off the edge's own face ends near the border of the next mirror, the wave over both edges belongs
to the path by the first as to that by the second: each has the more of it the nearer its own mirror's border is.

Borders are those that diffract. Where two mirrors meet in a corner images go on across it.
"""

from __future__ import annotations

import numpy as np
from scipy.special import wofz

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled
from simulator.diffraction.edge_view import EdgeView
from simulator.images.given_planes import image_in, last_image
from simulator.images.image_method import OUTSIDE, REACHED, crossed
from simulator.images.image_tree import dot
from simulator.world.candidates import Candidates
from simulator.world.frames import into_rest
from simulator.world.interactions import Interaction
from simulator.world.world import Tracing

REACH_RAD = 30.0  # 8 cm of detour: 5 % of the wave are left


def own_detour_m(view: EdgeView, part: Ints) -> Floats:
    """(R,) detour over edges beyond the nearer of the mirror paths whose zones end at them."""
    s, r, turn = view.source_angle_rad, view.receiver_angle_rad, view.open_angle_rad
    product = view.source_radius_m * view.receiver_radius_m
    nearest = np.minimum(np.cos(0.5 * (s + r)) ** 2, np.cos(turn - 0.5 * (s + r)) ** 2)
    mirrored = np.sqrt(np.maximum(view.apex_path_m**2 - 4.0 * product * nearest, 0.0))
    return view.path_m(part) - mirrored


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
    ends, patch = _unfolded(found, slot, k), found.sequence[:, k]
    code, _ = crossed(tracing, *ends, found.pose, np.ones(len(found), dtype=np.int64), patch[:, None])
    detour = np.minimum(_detours(tracing, found.pose, patch, *ends), 1.0)
    fading = 0.5 * np.cos(0.5 * np.pi * np.minimum(detour * wavenumber.mean() / REACH_RAD, 1.0)) ** 2
    turn = detour[:, None] * wavenumber
    fading *= own_m / np.maximum(own_m + detour, 1e-300)
    shadow = fading[:, None] * np.exp(-1j * turn) * wofz(1j * np.sqrt(1j * turn))
    return np.where((code == REACHED)[:, None], 1.0 - shadow, np.where((code == OUTSIDE)[:, None], shadow, 0.0))


def _unfolded(found: Candidates, slot: Ints, k: int) -> tuple[Floats, Floats]:
    """(R, 3) either end of the way over mirror k, transducer and edge, as it is seen in the mirrors between.

    The edge may stand on the mirror, so that the way to it is looked for from the transducer.
    """
    each, early, width = np.arange(len(found)), slot > k, found.sequence.shape[1]
    planes = found.normal, np.sum(found.normal * found.points_m[:, 1:-1], axis=2)
    first, last = np.where(early, 0, slot + 1), np.where(early, slot, found.order)
    before = [(i, i >= first) for i in range(k)]
    after = [(i, i < last) for i in reversed(range(k + 1, width))]
    one = last_image(found.points_m[each, first], *planes, before)
    other = last_image(found.points_m[each, last + 1], *planes, after)
    side = early[:, None]
    return np.where(side, one, other), np.where(side, other, one)


def _detours(tracing: Tracing, pose: Ints, patch: Ints, one_m: Floats, other_m: Floats) -> Floats:
    """(R,) least detour of paths over a patch by one of its sharp edges; infinite without one."""
    wedges = tracing.world.wedges
    edge, side = np.nonzero((wedges.mirror < 0)[:, None] & (wedges.patch >= 0))
    owner = wedges.patch[edge, side]
    order = np.argsort(owner, kind="stable")
    start = np.searchsorted(owner[order], np.arange(len(tracing.world.patches) + 1))
    image = image_in(tracing.mirrors, one_m, pose, np.ones(len(patch), dtype=np.int64), patch[:, None])
    frame = tracing.placed[pose, tracing.world.patches.obstacle[patch]]
    ends = into_rest(image, frame), into_rest(other_m, frame)
    return _least_detours(wedges.start_m, wedges.end_m, edge[order], start, patch, *ends)


@compiled
def _least_detours(starts, ends, edge, first, patch, image, other):
    """(R,) least detours between points over the edges of patches: those from `first[patch]` on in `edge`."""
    least, along, a, b = np.full(len(patch), np.inf), np.empty(3), np.empty(3), np.empty(3)
    for r in range(len(patch)):
        straight = 0.0
        for x in range(3):
            straight += (image[r, x] - other[r, x]) ** 2
        straight = np.sqrt(straight)
        for i in range(first[patch[r]], first[patch[r] + 1]):
            start, end = starts[edge[i]], ends[edge[i]]
            for x in range(3):
                along[x], a[x], b[x] = end[x] - start[x], image[r, x] - start[x], other[r, x] - start[x]
            length = np.sqrt(dot(along, along))
            ha, hb = dot(a, along) / length, dot(b, along) / length
            ra, rb = np.sqrt(max(dot(a, a) - ha**2, 0.0)), np.sqrt(max(dot(b, b) - hb**2, 0.0))
            h = min(max(ha + (hb - ha) * ra / max(ra + rb, 1e-300), 0.0), length)
            detour = np.hypot(ra, h - ha) + np.hypot(rb, h - hb) - straight
            least[r] = min(least[r], max(detour, 0.0))
    return least
