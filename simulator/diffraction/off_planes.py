"""A transducer in the plane of a face is taken for one just before it.

Where a face runs into a corner, the paths over that corner and over its image in the next face meet in its plane.
Rounding would say of each by itself whether it is there: an echo was up to 4 dB re a wall's too loud where the phone
was level with a shelf or in line with the side of a pillar, and right a hair beside it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from obstaclewatch.support.arrays import Flags
from simulator.world.mirrors import FLUSH_M
from simulator.world.world import Tracing, World

BEFORE_M = 2.0 * FLUSH_M  # 0.4 degrees of phase there and back at 20 kHz


def off_planes(tracing: Tracing) -> Tracing:
    """The same with all transducers that lie in planes of faces (`FLUSH_M`) moved to `BEFORE_M` in front of these."""
    mirrors, points = tracing.mirrors, tracing.transducers_m
    height = np.einsum("ntx,npx->ntp", points, mirrors.normal) - mirrors.offset_m[:, None]
    near = np.abs(height) < FLUSH_M
    if not near.any():
        return tracing
    moved = points.copy()
    for n, t, p in np.argwhere(near & _into_corners(tracing.world)):  # in turn: faces of several may lie in one plane
        above = moved[n, t] @ mirrors.normal[n, p] - mirrors.offset_m[n, p]
        if abs(above) < FLUSH_M:
            moved[n, t] += (BEFORE_M - above) * mirrors.normal[n, p]
    return replace(tracing, source_m=moved[:, 0], mics_m=moved[:, 1:])


def _into_corners(world: World) -> Flags:
    """(P,) whether a patch has a sharp edge and sees another patch, so that what that edge diffracts is reflected."""
    edged = np.zeros(len(world.patches), dtype=bool)
    if len(edged):
        edged[world.wedges.patch[world.wedges.free_angle_rad > np.pi]] = True
    return edged & world.sees_others
