"""The field behind the outline of bodies, compiled: Kirchhoff's integral over what an opaque screen leaves open.

A path over a point at depth s and distance r from a ray of length L is longer by d = r^2 (1/s + 1/(L - s)) / 2. In the
plane of w, |w| = sqrt(2 d), the phase of the integral is k |w|^2 / 2 whatever the depth, and along each direction
from w = 0 it is closed: it depends on where the outline begins and ends along that direction alone.
"""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.field.unfolded_segments import Segments
from simulator.world.rounded_parts import Screens

OUTLINE_REACH_RAD = 20.0  # at mid-band: farther out nothing counts, and less and less towards it; errs by 0.04 at most
LONGEST_M = 0.1  # of a facet over which w is not linear
BENT = 0.001  # of the reach, by which w may depart from a line in the middle of an edge: errs by 0.0015 at most
TOUCHING = 1e-9  # of the reach: rounding of facets that share an edge
DEEPEST = 64  # halvings of a facet that wait at once: enough for a hundred kilometres
SPANS = 8  # along one direction, to begin with
_TURN = 2.0 * np.pi / 180.0 * np.arange(180)  # twice as many directions change the field by less than 0.01
DIRECTION = np.column_stack([np.cos(_TURN), np.sin(_TURN)])


def reach_at(wavenumber_1_m: float) -> float:
    """Greatest |w| that counts, sqrt(m), at a wavenumber in the middle of the band."""
    return float(np.sqrt(2.0 * OUTLINE_REACH_RAD / wavenumber_1_m))


def behind_outlines(
    screens: Screens, part: Ints, segments: Segments, wavenumber_1_m: Floats, reach: float
) -> Complexes:
    """(R, K) field behind the outlines of screens round each of R rays, re the free field, at K wavenumbers.

    Args:
        screens: what may be in the way.
        part: (Q,) number of a screen in the way of each segment, in whose rest frame the segment is.
        segments: (Q,) ray by ray, from 0 to R - 1; what is across is the same in all segments of the unfolded ray.
        reach: greatest |w|, sqrt(m).
    """
    field = np.ones((int(segments.ray.max(initial=-1)) + 1, len(wavenumber_1_m)), dtype=np.complex128)
    _fill_behind(screens, part, segments, wavenumber_1_m, reach, DIRECTION, field)  # type: ignore[call-arg]
    return field


@compiled
def _fill_behind(screens, part, segments, wavenumber, reach, direction, field):
    """Fill in what of a field of ones (R, K) is left, by its integral along directions (D, 2), cosine and sine."""
    stack, facet, at = np.empty((DEEPEST, 3, 3)), np.empty((3, 3)), np.empty((3, 3))
    x, y = np.empty(3), np.empty(3)
    spans, count = np.empty((len(direction), SPANS, 2)), np.empty(len(direction), np.int64)
    q = 0
    for r in range(len(field)):
        fullest = 0
        for n in range(len(count)):
            count[n] = 0
        while q < len(part) and segments.ray[q] == r:
            for f in range(screens.first[part[q]], screens.first[part[q] + 1]):
                if _apart(screens.ball_m[f], segments, q, reach):
                    continue
                _copy(screens.corner_m[f], stack[0])
                waiting = 1
                while waiting:
                    waiting -= 1
                    _copy(stack[waiting], facet)
                    if _away(facet, segments, q, reach):
                        continue
                    between = _projected(facet, segments, q, at, x, y)
                    bent = not between or _bent(at, segments.total_m[q], x, y, reach)
                    if bent and _halved(facet, stack, waiting):
                        waiting += 2
                    elif between and _within(x, y, reach):
                        if fullest == spans.shape[1]:
                            spans = _with_room(spans)
                        fullest = max(fullest, _cover(x, y, direction, reach, spans, count))
            q += 1
        _darken(spans, count, reach, wavenumber, field[r])


@inlined
def _copy(one, other):
    """Fill in the corners of another facet."""
    for i in range(3):
        for k in range(3):
            other[i, k] = one[i, k]


@inlined
def _with_room(spans):
    """The same with room for twice as many."""
    directions, many, _ = spans.shape
    found = np.empty((directions, 2 * many, 2))
    for n in range(directions):
        for m in range(many):
            found[n, m, 0], found[n, m, 1] = spans[n, m, 0], spans[n, m, 1]
    return found


@inlined
def _apart(ball, segments, q, reach):
    """Whether all of a ball is out of reach of the ray of segment q, which reaches farthest half way."""
    start, ahead, total = segments.start_m[q], segments.ahead[q], segments.total_m[q]
    x, y, z = ball[0] - start[0], ball[1] - start[1], ball[2] - start[2]
    depth = x * ahead[0] + y * ahead[1] + z * ahead[2]
    aside = np.sqrt(max(x * x + y * y + z * z - depth * depth, 0.0)) - ball[3]
    depth += segments.before_m[q]
    widest = min(max(0.5 * total, depth - ball[3]), depth + ball[3])
    return aside > 0.0 and aside * aside * total > reach * reach * widest * (total - widest)


@inlined
def _away(facet, segments, q, reach):
    """Whether a facet is out of reach of segment q, beyond the ends of the ray, or mostly behind a mirror."""
    start, end, ahead, total = segments.start_m[q], segments.end_m[q], segments.ahead[q], segments.total_m[q]
    facing = segments.facing[q]
    depth, square, here, there, radius = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        middle = (facet[0, k] + facet[1, k] + facet[2, k]) / 3.0
        step = middle - start[k]
        depth += step * ahead[k]
        square += step * step
        here += step * facing[0, k]
        there += (middle - end[k]) * facing[1, k]
        for i in range(3):
            radius = max(radius, abs(facet[i, k] - middle))
    radius *= 1.75  # sqrt(3) of the greatest coordinate holds all corners
    aside = np.sqrt(max(square - depth * depth, 0.0))
    depth += segments.before_m[q]
    wide = 0.5 * reach * np.sqrt(total) + radius  # the ray reaches farthest half way
    return here < 0.0 or there < 0.0 or aside > wide or depth < -radius or depth > total + radius


@inlined
def _halved(facet, stack, at):
    """Whether a facet is too long: if so, its halves are put on the stack."""
    widest, i = 0.0, 0
    for n in range(3):
        length = 0.0
        for k in range(3):
            length += (facet[n, k] - facet[n - 1, k]) ** 2
        if length > widest:
            widest, i = length, n
    if widest <= LONGEST_M * LONGEST_M:
        return False
    for k in range(3):  # the edge from corner i - 1 to i is the longest
        half = 0.5 * (facet[i, k] + facet[i - 1, k])
        stack[at, 0, k], stack[at, 1, k], stack[at, 2, k] = facet[i - 2, k], facet[i - 1, k], half
        stack[at + 1, 0, k], stack[at + 1, 1, k], stack[at + 1, 2, k] = facet[i - 2, k], half, facet[i, k]
    return True


@inlined
def _projected(facet, segments, q, at, x, y):
    """Fill in depths of the corners, their places across the ray (3, 3), and w; whether all are between the ends."""
    start, ahead, across, total = segments.start_m[q], segments.ahead[q], segments.across[q], segments.total_m[q]
    between = True
    for i in range(3):
        depth, one, other = segments.before_m[q], 0.0, 0.0
        for k in range(3):
            step = facet[i, k] - start[k]
            depth += step * ahead[k]
            one += step * across[0, k]
            other += step * across[1, k]
        at[i, 0], at[i, 1], at[i, 2] = depth, one, other
        between &= 0.0 < depth < total
        if between:
            scale = np.sqrt(1.0 / depth + 1.0 / (total - depth))
            x[i], y[i] = scale * one, scale * other
    return between


@inlined
def _bent(at, total, x, y, reach):
    """Whether w in the middle of an edge is not halfway between its corners'."""
    most = 0.0
    for i in range(3):
        depth = 0.5 * (at[i, 0] + at[i - 1, 0])
        scale = np.sqrt(1.0 / depth + 1.0 / (total - depth))
        one = scale * (at[i, 1] + at[i - 1, 1]) - (x[i] + x[i - 1])
        other = scale * (at[i, 2] + at[i - 1, 2]) - (y[i] + y[i - 1])
        most = max(most, one * one + other * other)
    return most > (2.0 * BENT * reach) ** 2


@inlined
def _within(x, y, reach):
    """Whether a facet with such corners in the plane of w may be within reach."""
    nearest, widest = np.inf, 0.0
    for i in range(3):
        nearest = min(nearest, x[i] * x[i] + y[i] * y[i])
        widest = max(widest, (x[i] - x[i - 1]) ** 2 + (y[i] - y[i - 1]) ** 2)
    return np.sqrt(nearest) - np.sqrt(widest) < reach


@inlined
def _cover(x, y, direction, reach, spans, count):
    """Add what a triangle covers along each direction from 0 that crosses it; the most spans that one now has."""
    turns, low, high, most = len(direction), 0.0, 0.0, 0
    per = turns / (2.0 * np.pi)
    at_corner = abs(x[0]) + abs(y[0]) < TOUCHING * reach
    for i in range(1, 3):
        at_corner |= abs(x[i]) + abs(y[i]) < TOUCHING * reach
        apart = np.arctan2(y[i] * x[0] - x[i] * y[0], x[i] * x[0] + y[i] * y[0])
        low, high = min(low, apart), max(high, apart)
    angle = np.arctan2(y[0], x[0])
    begin, last = int(np.ceil((angle + low) * per)), int(np.floor((angle + high) * per))
    if at_corner or high - low > np.pi:  # 0 is a corner, or within
        begin, last = 0, turns - 1
    for n in range(begin, last + 1):
        c, s = direction[n % turns]
        near, far = np.inf, -np.inf
        for i in range(3):
            one, other = y[i - 1] * c - x[i - 1] * s, y[i] * c - x[i] * s
            if (one < 0.0) != (other < 0.0):
                share = one / (one - other)
                along = (x[i - 1] + share * (x[i] - x[i - 1])) * c + (y[i - 1] + share * (y[i] - y[i - 1])) * s
                near, far = min(near, along), max(far, along)
        near = max(near, 0.0)
        if far > near and near < reach:
            _absorb(near, min(far, reach), TOUCHING * reach, spans, count, n % turns)
            most = max(most, count[n % turns])
    return most


@inlined
def _absorb(near, far, touching, spans, count, n):
    """Add a span to those of a direction, which stay apart: it swallows all that it touches."""
    m = 0
    while m < count[n]:
        if spans[n, m, 0] <= far + touching and near <= spans[n, m, 1] + touching:
            near, far = min(near, spans[n, m, 0]), max(far, spans[n, m, 1])
            count[n] -= 1
            spans[n, m, 0], spans[n, m, 1] = spans[n, count[n], 0], spans[n, count[n], 1]
            m = 0
        else:
            m += 1
    spans[n, m, 0], spans[n, m, 1] = near, far
    count[n] += 1


@inlined
def _darken(spans, count, reach, wavenumber, field):
    """Take the mean over all directions of what spans cover off a free field."""
    for n in range(len(count)):
        for m in range(count[n]):
            for k in range(len(wavenumber)):
                begin = _wave(spans[n, m, 0], reach, wavenumber[k])
                field[k] -= (begin - _wave(spans[n, m, 1], reach, wavenumber[k])) / len(count)


@inlined
def _wave(place, reach, wavenumber):
    """e^{-jkd} at |w| = `place`, faded out towards the reach."""
    share = place / reach
    fade = 1.0 - share**8
    phase = 0.5 * wavenumber * place * place
    return fade * complex(np.cos(phase), -np.sin(phase))
