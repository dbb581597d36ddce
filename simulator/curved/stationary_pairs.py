"""Two stationary points that depend on each other, on two smooth surfaces of one path.

They are followed in turns, x_1 between speaker and x_2, x_2 between x_1 and microphone. A turn multiplies the error
by J = H22^-1 H21 H11^-1 H12 in the second derivatives of the length, so dividing its step by 1 - J makes the turns
Newton's method: four or five of them settle to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.curved.stationary import StationaryPoints, follow
from simulator.surfaces.reflectors import SmoothSurface

TURNS, SETTLED_M = 16, 1e-11


def settle(
    surfaces: Sequence[SmoothSurface], frames: Sequence[Floats], source: Floats, receiver: Floats,
    guess: Sequence[tuple[Ints, Floats]], second_m: Floats,
) -> tuple[StationaryPoints, StationaryPoints, Flags]:  # fmt: skip
    """Both reflection points of R paths from rough ones.

    Args:
        surfaces: the two, in the order met; frames: where they stand, (R, 4) each.
        source, receiver: (R, 3) ends, or their images in mirrors.
        guess: for each surface (R,) facet and (R, 2) place on it.
        second_m: (R, 3) the second point that goes with the guess.

    Returns:
        The two places, and (R,) whether they settled, each within its facet and in front of its surface.
    """
    towards = second_m.copy()
    first = follow(surfaces[0], frames[0], source, towards, *guess[0])
    second = follow(surfaces[1], frames[1], first.point_m, receiver, *guess[1])
    moving, settled = np.arange(len(towards)), np.zeros(len(towards), dtype=bool)
    for turn in range(TURNS):
        here, there = first[moving], second[moving]
        step = there.point_m - towards[moving]
        rests = np.abs(step).max(axis=1) < SETTLED_M
        clear = here.clear & there.clear
        settled[moving] = rests & clear
        goes_on = ~rests & (clear | (turn == 0))
        moving, here, there, step = moving[goes_on], here[goes_on], there[goes_on], step[goes_on]
        if len(moving) == 0:
            break
        towards[moving] = there.point_m + _turns_to_come(step, source[moving], receiver[moving], here, there)
        here = follow(surfaces[0], frames[0][moving], source[moving], towards[moving], here.face, here.uv)
        there = follow(surfaces[1], frames[1][moving], here.point_m, receiver[moving], there.face, there.uv)
        first, second = first.with_rows(moving, here), second.with_rows(moving, there)
    return first, second, settled


def _turns_to_come(
    step: Floats, source: Floats, receiver: Floats, first: StationaryPoints, second: StationaryPoints
) -> Floats:
    """(R, 3) the steps of all turns after the last: ((1 - J)^-1 - 1) step, in the tangent plane."""
    own_1, frame_1 = _hessian(first, source, second.point_m)
    own_2, frame_2 = _hessian(second, first.point_m, receiver)
    across, distance = _unit(second.point_m - first.point_m)
    square = (np.eye(3) - across[:, :, None] * across[:, None, :]) / distance[:, None, None]
    cross = np.einsum("rai,rij,rbj->rab", frame_2, square, frame_1)  # H21 up to its sign, which J squares away
    turn = _solve(own_2, cross @ _solve(own_1, np.swapaxes(cross, 1, 2)))
    flat = np.einsum("rai,ri->ra", frame_2, step)
    ahead = _solve(np.eye(2) - turn, flat[:, :, None])[:, :, 0]
    size, whole = np.linalg.norm(flat, axis=1), np.linalg.norm(ahead, axis=1)
    ahead *= np.minimum(1.0, 10.0 * size / np.maximum(whole, 1e-300))[:, None]  # no further than ten such steps
    return np.einsum("rai,ra->ri", frame_2, ahead - flat)


def _hessian(place: StationaryPoints, source: Floats, receiver: Floats) -> tuple[Floats, Floats]:
    """(R, 2, 2) second derivatives of the length of both segments along the surface, and (R, 2, 3) the tangents."""
    normal = place.normal
    helper = np.where(np.abs(normal[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    tangent = _unit(np.cross(normal, helper))[0]
    frame = np.stack([tangent, np.cross(normal, tangent)], axis=1)
    bend = np.zeros((len(normal), 3, 3))
    for end in (source, receiver):
        ray, length = _unit(end - place.point_m)
        bend += (np.eye(3) - ray[:, :, None] * ray[:, None, :]) / length[:, None, None]
        bend += np.sum(ray * normal, axis=1)[:, None, None] * place.curvature
    return np.einsum("rai,rij,rbj->rab", frame, bend, frame), frame


def _unit(vector: Floats) -> tuple[Floats, Floats]:
    length = np.linalg.norm(vector, axis=1)
    return vector / np.maximum(length, 1e-300)[:, None], length


def _solve(matrix: Floats, right: Floats) -> Floats:
    """Solutions of (R, 2, 2) systems; 0 where a matrix is singular, which leaves the plain turn."""
    a, b, c, d = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1]
    det = a * d - b * c
    inverse = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    safe = np.abs(det) > 1e-12 * (np.abs(a * d) + np.abs(b * c))
    return np.where(safe, 1.0 / np.where(safe, det, 1.0), 0.0)[:, None, None] * (inverse @ right)
