"""The shortest path over several straight lines in turn: a convex problem, solved by damped Newton steps."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats

STEPS, HALVINGS = 40, 12
SETTLED = 1e-9  # slope of the length that is left
STIFF = 1e-9  # share added to the diagonal, where a path degenerates
STRIDE_M = 3.0  # longest step
APART_M = 1e-4  # points of neighbouring lines this close have met in a corner, where there is no apex


def joint_apexes(
    start_m: Floats, along: Floats, length_m: Floats, source_m: Floats, receiver_m: Floats
) -> tuple[Floats, Flags]:
    """Where the shortest path from sources to receivers meets chains of N endless lines.

    Args:
        start_m, along: (R, N, 3) a point of each line and its unit direction.
        length_m: (R, N) twice the distance along the line at which the search starts.
        source_m, receiver_m: (R, 3).

    Returns:
        (R, N) distances along the lines, m, and (R,) whether they settled with all points apart.
    """
    height = 0.5 * length_m
    settled = np.zeros(len(height), dtype=bool)
    active = np.arange(len(height))
    for _ in range(STEPS):
        if len(active) == 0:
            break
        lines = start_m[active], along[active], source_m[active], receiver_m[active]
        points = _points(height[active], *lines)
        apart = np.linalg.norm(np.diff(points, axis=1), axis=2).min(axis=1) > APART_M
        slope = _slope(points, along[active])
        done = (np.abs(slope) < SETTLED).all(axis=1)
        settled[active[done & apart]] = True
        on = ~done & apart
        active, slope = active[on], slope[on]
        bend = second_derivatives(points[on], along[active])
        each = np.arange(bend.shape[1])
        bend[:, each, each] += STIFF * (1.0 + bend[:, each, each])
        step = np.linalg.solve(bend, slope[:, :, None])[:, :, 0]
        step *= np.minimum(1.0, STRIDE_M / np.maximum(np.abs(step).max(axis=1), STRIDE_M))[:, None]
        height[active] -= _damped(height[active], step, slope, tuple(part[on] for part in lines))
    return height, settled


def second_derivatives(points_m: Floats, along: Floats) -> Floats:
    """(R, N, N) of the length over points (R, N + 2, 3) by the shifts of the inner N along `along` (R, N, 3)."""
    segments = np.diff(points_m, axis=1)
    length = np.linalg.norm(segments, axis=2)
    ray = segments / length[:, :, None]
    before, after = (np.einsum("rnx,rnx->rn", along, ray[:, n : n + along.shape[1]]) for n in (0, 1))
    count = along.shape[1]
    out = np.zeros((len(points_m), count, count))
    each = np.arange(count)
    out[:, each, each] = (1.0 - before**2) / length[:, :-1] + (1.0 - after**2) / length[:, 1:]
    both = np.einsum("rnx,rnx->rn", along[:, :-1], along[:, 1:])
    out[:, each[:-1], each[1:]] = -(both - after[:, :-1] * before[:, 1:]) / length[:, 1:-1]
    out[:, each[1:], each[:-1]] = out[:, each[:-1], each[1:]]
    return out


def _points(height: Floats, start: Floats, along: Floats, source: Floats, receiver: Floats) -> Floats:
    inner = start + height[:, :, None] * along
    return np.concatenate([source[:, None], inner, receiver[:, None]], axis=1)


def _length(height: Floats, lines: tuple[Floats, ...]) -> Floats:
    return np.linalg.norm(np.diff(_points(height, *lines), axis=1), axis=2).sum(axis=1)


def _slope(points: Floats, along: Floats) -> Floats:
    segments = np.diff(points, axis=1)
    ray = segments / np.maximum(np.linalg.norm(segments, axis=2), 1e-300)[:, :, None]
    return np.einsum("rnx,rnx->rn", along, ray[:, :-1] - ray[:, 1:])


def _damped(height: Floats, step: Floats, slope: Floats, lines: tuple[Floats, ...]) -> Floats:
    """Newton's steps, halved until the length falls (Armijo)."""
    share = np.ones(len(height))
    length, fall = _length(height, lines), 1e-4 * np.sum(step * slope, axis=1)
    for _ in range(HALVINGS):
        high = np.flatnonzero(_length(height - share[:, None] * step, lines) > length - share * fall + 1e-15)
        if len(high) == 0:
            break
        share[high] *= 0.5
    return share[:, None] * step
