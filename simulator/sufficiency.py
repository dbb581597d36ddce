"""Which mechanism suffices: where rays off a smooth surface err because the surface ends.

A ray knows nothing of the rim beyond its reflection point. The rim's own contribution is that of the end of a line
of stationary phase: the echo that an endless surface would return, times

    sqrt(1/l + 1/m) / (sqrt(2 pi k) g)

with the distances l, m of both ends and the slope g of the path length across the rim (0.225 over Fresnel's nu). It
counts as an error as far as it reaches into the obstacle's strongest echo after the matched filter.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simulator.borders import Border
from simulator.candidates import Candidates
from simulator.fidelity import Fidelity
from simulator.floor import Audible
from simulator.frames import into_rest, out_of_rest, turned
from simulator.mixed import image_pairs, images_lighting
from simulator.spreading import spreading
from simulator.world import Tracing

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

PULSE_M = 0.107  # of path: exp(-(x / this)^2) is the compressed Hann chirp to its -3 dB points, 6.3 cm of range apart
MOST = 0.5  # of an endless surface's echo: what its rim returns at the most, with the mirror point on it
TOUCHING_M = 2e-3
DB_PER_SHARE = 20.0 / np.log(10.0)


def heard_whole(tracing: Tracing, fidelity: Fidelity, echoes: Candidates, audible: Audible, wavenumber: float) -> Flags:
    """(N, O) obstacles that Kirchhoff's integral is needed for, pose by pose.

    Those that no mechanism of the fidelity can hear otherwise, and those whose rims spoil their echo by more than the
    tolerance.
    """
    world, mechanisms = tracing.world, fidelity.mechanisms
    whole = np.zeros((len(tracing.pose), len(world.obstacles)), dtype=bool)
    if "kirchhoff" not in mechanisms:
        return whole
    for obstacle, (reading, _) in enumerate(world.skins):
        flat, bent = bool((reading.patch >= 0).any()), bool(reading.curved.any())
        whole[:, obstacle] = (flat and "specular" not in mechanisms) or (bent and "curved" not in mechanisms)
    for index, surface in enumerate(world.surfaces):
        error = rim_error_db(tracing, index, echoes, fidelity.max_order, audible, wavenumber)
        whole[:, surface.obstacle] |= (error > fidelity.tolerance_db).any(axis=1)
    return whole


def rim_error_db(
    tracing: Tracing, index: int, echoes: Candidates, max_order: int, audible: Audible, k: float
) -> Floats:
    """(N, 2) estimated error of an obstacle's echo by rays off its smooth surface `index`, dB; 0 where it has no rim.

    Args:
        echoes: what the rays found, of any obstacle.
        max_order: reflections in all.
        audible: rims that it would leave out do no harm.
        k: wavenumber, rad/m.
    """
    surface = tracing.world.surfaces[index]
    error = np.zeros((len(tracing.pose), 2))
    if not len(tracing.world.borders[index]):
        return error
    level, length = _strongest(tracing, surface.obstacle, echoes)
    lit = images_lighting(tracing, surface, tracing.source_m, max_order - 1, audible.limit_m)
    for mic in range(2):
        heard = images_lighting(tracing, surface, tracing.mics_m[:, mic], max_order - 1, audible.limit_m)
        left, right = image_pairs(lit, heard, max_order)
        pose = lit.pose[left]
        rim, path = _rim_echo(tracing, index, pose, lit.point_m[left], heard.point_m[right], k)
        rim = np.where((path <= audible.limit_m) & audible(rim, level[pose, mic]), rim, 0.0)
        near = np.exp(-(((path - length[pose, mic]) / PULSE_M) ** 2))
        louder = rim > level[pose, mic]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(louder, np.inf, rim * near / level[pose, mic])
        np.add.at(error[:, mic], pose, DB_PER_SHARE * np.where(rim > 0.0, share, 0.0))
    return error


def _strongest(tracing: Tracing, obstacle: int, echoes: Candidates) -> tuple[Floats, Floats]:
    """(N, 2) amplitude and (N, 2) path of the strongest echo that meets an obstacle; 0 and 0 without one."""
    owner = np.append(tracing.world.owner, -1)
    rows = np.flatnonzero((owner[echoes.sequence] == obstacle).any(axis=1) & (echoes.edge < 0))
    met = echoes[rows]
    amplitude = np.abs(spreading(met.points_m, met.normal, met.curvature, met.order))
    order = np.argsort(amplitude, kind="stable")
    level, length = (np.zeros((len(tracing.pose), 2)) for _ in range(2))
    level[met.pose[order], met.mic[order]] = amplitude[order]
    length[met.pose[order], met.mic[order]] = met.length_m[order]
    return level, length


def _rim_echo(
    tracing: Tracing, index: int, pose: Ints, source: Floats, receiver: Floats, k: float
) -> tuple[Floats, Floats]:
    """(R,) amplitude and (R,) path of what the rim returns between images of speaker and microphone."""
    obstacle, border = tracing.world.surfaces[index].obstacle, tracing.world.borders[index]
    frame = tracing.placed[pose, obstacle]
    source, receiver = into_rest(source, frame), into_rest(receiver, frame)
    to_source, to_receiver = (end[:, None] - border.point_m for end in (source, receiver))
    l, m = np.linalg.norm(to_source, axis=2), np.linalg.norm(to_receiver, axis=2)
    both = to_source / l[:, :, None] + to_receiver / m[:, :, None]
    lit = np.einsum("rbx,bx->rb", both, border.normal) > 0.0
    path = np.where(lit & ~_touching(tracing, obstacle, border, pose), l + m, np.inf)
    first = path.argmin(axis=1)
    each = np.arange(len(pose))
    l, m, shortest = l[each, first], m[each, first], path[each, first]
    slope = np.abs(np.einsum("rx,rx->r", both[each, first], border.across[first]))
    bent = 1.0 + 2.0 * np.maximum(border.bend_1_m[first], 0.0) * l * m / (l + m)
    share = np.sqrt(1.0 / l + 1.0 / m) / (np.sqrt(2.0 * np.pi * k) * np.maximum(slope, 1e-12))
    amplitude = np.minimum(share, MOST) / ((l + m) * np.sqrt(bent))
    return np.where(np.isfinite(shortest), amplitude, 0.0), np.where(np.isfinite(shortest), shortest, 0.0)


def _touching(tracing: Tracing, obstacle: int, border: Border, pose: Ints) -> Flags:
    """(R, B) points of the border that stand on another obstacle's plane: its image continues the surface there."""
    patches = tracing.world.patches
    others = np.flatnonzero(patches.obstacle != obstacle)
    unique, which = np.unique(pose, return_inverse=True)
    touching = np.zeros((len(unique), len(border)), dtype=bool)
    for row, n in enumerate(unique):
        frame = tracing.placed[n]
        point = out_of_rest(border.point_m, frame[obstacle])
        normal = turned(patches.normal[others], frame[patches.obstacle[others], 3])
        offset = patches.offset_m[others] + np.sum(normal * frame[patches.obstacle[others], :3], axis=1)
        center = out_of_rest(patches.center_m[others], frame[patches.obstacle[others]])
        gap = np.abs(point @ normal.T - offset)
        near = np.linalg.norm(point[:, None] - center, axis=2) <= patches.radius_m[others]
        touching[row] = ((gap < TOUCHING_M) & near).any(axis=1)
    return touching[which.ravel()]
