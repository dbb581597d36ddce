"""The sum over facets, compiled: one evaluation a facet and pair of ends at the band's centre, spread over path length.

Float32 and no branches within the rows, so that the compiler works on eight facets at a time: 0.05 mm of rounding in
a path of metres is 2e-4 rad of phase, -70 dB of what each facet adds, at random. No fastmath: it takes the phase's
reduction apart, gains no time here, and made functions just compiled differ in their last bits from stored ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.surfaces.facets import BLOCK, Facets

_F = np.float32
WIDE = BLOCK  # a constant: offsets known to the compiler spare it a check of every pair of rows for overlap
_ONE, _TWO, _THREE, _FOUR, _HALF, _NONE = _F(1), _F(2), _F(3), _F(4), _F(0.5), _F(0)
_PER_PI, _PI_HIGH, _PI_LOW = _F(0.3183098861837907), _F(3.140625), _F(9.67653589793e-4)
_C0, _C1, _C2, _C3 = _F(-0.5), _F(4.16666418e-2), _F(-1.38883e-3), _F(2.4433e-5)
_S0, _S1, _S2 = _F(-1.6666655e-1), _F(8.332161e-3), _F(-1.9515296e-4)
_FLAT = _F(0.1)  # rad of phase across a facet: what is less takes the series
_NEAR, _STEEP, _M2, _M3, _M4 = _F(1e-3), _F(1e8), _F(-1 / 12), _F(1 / 60), _F(1 / 360)
_PER_EIGHT, _SIXTH, _PER_24 = _F(1 / 8), _F(1 / 6), _F(1 / 24)
_PER_4_PI = _F(0.25 / np.pi)


Blocks = tuple[NDArray[np.float32], Ints, Ints]


def blocks_of(facets: Facets, spot: Ints) -> Blocks:
    """What `add_facets` takes: (B, 13 * WIDE) columns and (B, WIDE) spots block by block, and (B,) their numbers."""
    size = np.diff(facets.start)
    used = np.arange(WIDE) < size[:, None]
    one, other, third = facets.corner_m.transpose(1, 2, 0)
    mean = (one + other + third) / 3.0
    values = *(facets.middle_m - facets.center_m).T, *facets.normal.T, facets.area_m2, *(one - mean), *(other - mean)
    rows = np.zeros((len(size), 13, WIDE), dtype=np.float32)
    for column, value in enumerate(values):
        rows[:, column][used] = value
    spots = np.zeros((len(size), WIDE), dtype=np.int64)
    spots[used] = spot
    return rows.reshape(len(size), -1), spots, size


@compiled
def add_facets(
    rows, spot, size, ends, view, lit, end_start, first, second, pair_start, wavenumber, table, closed, lead, step,
    total,
):  # fmt: skip
    """Add all facets to the grids of all pairs, group by group of ends.

    Args:
        rows: (B, 13 * WIDE) float32, block by block and one after the other: x, y, z of the centroids about the body's
            centre, normal, area, first and second corner about the corners' mean.
        spot: (B, WIDE) which spot's light falls on each facet.
        size: (B,) facets of each block.
        ends: (E, 6) float32 points about the body's centre, then leans; end_start: (G + 1,) those of each group.
        view: (E,) which view each end has; lit: (V, S) bool, spots that each view shows.
        first, second: (R,) ends of each pair; pair_start: (G + 1,) those of each group.
        wavenumber: at the band's centre.
        table: (Q, C, 2) float32 parts of the reflection at C cosines of incidence.
        lead: from the grid's first point to the path over the body's centre; step: of the grid, m.
        total: (R, Q, N, 2) float64 sums on the grid.
    """
    most = 0
    for g in range(len(end_start) - 1):
        most = max(most, end_start[g + 1] - end_start[g])
    segments = np.empty((most, 8 * WIDE), np.float32)
    pair = np.empty(6 * WIDE, np.float32)
    shown = _shown(lit, spot, size)
    for g in range(len(end_start) - 1):
        first_end = end_start[g]
        for block in range(len(size)):
            count, part = size[block], rows[block]
            for e in range(first_end, end_start[g + 1]):
                if shown[view[e], block]:
                    segment = segments[e - first_end]
                    _light(lit[view[e]], spot[block], count, segment[6 * WIDE :])
                    _segment(part, count, ends[e], wavenumber, closed, segment)
            for r in range(pair_start[g], pair_start[g + 1]):
                a, b = first[r], second[r]
                if shown[view[a], block] and shown[view[b], block]:
                    here, there = segments[a - first_end], segments[b - first_end]
                    _pair(part, count, here, there, wavenumber, lead, _ONE / step, pair)
                    _onto_grid(pair, count, table, total[r])


@inlined
def _shown(lit, spot, size):
    """(V, B) whether a view shows any facet of a block."""
    shown = np.zeros((len(lit), len(size)), np.bool_)
    for v in range(len(lit)):
        for block in range(len(size)):
            for p in range(size[block]):
                if lit[v, spot[block, p]]:
                    shown[v, block] = True
                    break
    return shown


@inlined
def _light(lit, spot, count, light):
    """Fill in 1 for the facets that are lit, 0 for the others."""
    for p in range(count):
        light[p] = lit[spot[p]]


@inlined
def _segment(part, count, end, wavenumber, closed, segment):
    """Fill rows: excess length, cosine, 1 / length, unit vector, and the wave without the phase to the centre.

    Row 6 says beforehand which facets are lit. The transducer's directivity is taken facet by facet: that of one facet
    for a cell moved echoes of people by 0.5 dB, however fine the facets.
    """
    sx, sy, sz = end[0], end[1], end[2]
    lx, ly, lz = end[3], end[4], end[5]
    centre, lean = np.sqrt(sx * sx + sy * sy + sz * sz), np.sqrt(lx * lx + ly * ly + lz * lz)
    least = _NONE if closed else -_TWO
    for p in range(count):
        dx, dy, dz = sx - part[p], sy - part[WIDE + p], sz - part[2 * WIDE + p]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        per = _ONE / length
        dx, dy, dz = dx * per, dy * per, dz * per
        segment[p], segment[2 * WIDE + p] = length - centre, per
        segment[3 * WIDE + p], segment[4 * WIDE + p], segment[5 * WIDE + p] = dx, dy, dz
        segment[WIDE + p] = max(dx * part[3 * WIDE + p] + dy * part[4 * WIDE + p] + dz * part[5 * WIDE + p], least)
        sine, cosine = _turn(wavenumber * (length - centre))
        weight = segment[6 * WIDE + p] * per * _falling(lean + dx * lx + dy * ly + dz * lz)
        segment[6 * WIDE + p], segment[7 * WIDE + p] = weight * cosine, -weight * sine


@inlined
def _turn(phase):
    """Sine and cosine: half turns taken off, then polynomials."""
    turns = np.floor(phase * _PER_PI + _HALF)
    rest = (phase - turns * _PI_HIGH) - turns * _PI_LOW
    sign = _ONE - _TWO * (turns - _TWO * np.floor(turns * _HALF))
    square = rest * rest
    cosine = sign * (_ONE + square * (_C0 + square * (_C1 + square * (_C2 + square * _C3))))
    sine = sign * rest * (_ONE + square * (_S0 + square * (_S1 + square * _S2)))
    return sine, cosine


@inlined
def _falling(x):
    """e^-x, x from 0 to a few: the eighth power of a polynomial, to 2e-4 at -20 dB."""
    y = x * _PER_EIGHT
    root = _ONE - y * (_ONE - y * (_HALF - y * (_SIXTH - y * _PER_24)))
    square = root * root
    return (square * square) * (square * square)


@inlined
def _mean_wave(x, y):
    """Mean of e^{j phase} over a triangle on which it is linear, x and y at two corners, 0 in the middle; its growth.

    A divided difference of the exponential: of half the lowest and half the highest phase all of it follows. The growth
    is the derivative where all phases grow alike, as they do with frequency.
    """
    z = -(x + y)
    low, high = min(x, min(y, z)), max(x, max(y, z))
    sin_low, cos_low = _turn(_HALF * low)
    sin_high, cos_high = _turn(_HALF * high)
    sin_twice_low, cos_twice_low = _TWO * sin_low * cos_low, _ONE - _TWO * sin_low * sin_low
    sin_twice_high, cos_twice_high = _TWO * sin_high * cos_high, _ONE - _TWO * sin_high * sin_high
    up, down = high + _HALF * low, -low - _HALF * high  # half way from the middle phase to either
    safe_up, safe_down = max(up, _NEAR), max(down, _NEAR)
    sinc_up = (sin_twice_high * cos_low + cos_twice_high * sin_low + (safe_up - up)) / safe_up
    sinc_down = (safe_down - down - sin_twice_low * cos_high - cos_twice_low * sin_high) / safe_down
    rise_up = cos_twice_high * cos_low - sin_twice_high * sin_low - sinc_up
    rise_down = cos_twice_low * cos_high - sin_twice_low * sin_high - sinc_down
    span = high - low
    per = _TWO / max(span, _FLAT)
    real, imag = per * (sin_high * sinc_down - sin_low * sinc_up), per * (cos_high * sinc_down - cos_low * sinc_up)
    low_real = _HALF * (high * cos_high * sinc_down - low * cos_low * sinc_up)
    low_imag = _HALF * (low * sin_low * sinc_up - high * sin_high * sinc_down)
    more_real = low_real + sin_high * rise_down - sin_low * rise_up
    more_imag = low_imag + cos_high * rise_down - cos_low * rise_up
    square, cube = _HALF * (x * x + y * y + z * z), x * y * z
    wide = _either(span - _FLAT)
    flat_real, flat_imag = _ONE + square * (_M2 + square * _M4), -cube * _M3
    growth_real, growth_imag = square * (_TWO * _M2 + square * _FOUR * _M4), -_THREE * cube * _M3
    return (
        flat_real + wide * (real - flat_real),
        flat_imag + wide * (imag - flat_imag),
        growth_real + wide * (per * more_real - real - growth_real),
        growth_imag + wide * (per * more_imag - imag - growth_imag),
    )


@inlined
def _either(value):
    """1 above 0, 0 below: arithmetic, where a branch would stop the compiler."""
    return min(max(value * _STEEP, _NONE), _ONE)


@inlined
def _pair(part, count, a, b, wavenumber, lead, per_step, pair):
    """Fill rows: what each facet adds, complex, its first moment on the grid, complex, its place there, the cosine."""
    per_turn = per_step / wavenumber
    for p in range(count):
        both = a[WIDE + p] * b[WIDE + p]
        hx, hy = a[3 * WIDE + p] + b[3 * WIDE + p], a[4 * WIDE + p] + b[4 * WIDE + p]
        hz = a[5 * WIDE + p] + b[5 * WIDE + p]
        first = wavenumber * (hx * part[7 * WIDE + p] + hy * part[8 * WIDE + p] + hz * part[9 * WIDE + p])
        second = wavenumber * (hx * part[10 * WIDE + p] + hy * part[11 * WIDE + p] + hz * part[12 * WIDE + p])
        mean_real, mean_imag, more_real, more_imag = _mean_wave(first, second)
        weight = _PER_4_PI * part[6 * WIDE + p] * _either(both)
        ca, cb = abs(a[WIDE + p]), abs(b[WIDE + p])
        near, far = weight * (ca * a[2 * WIDE + p] + cb * b[2 * WIDE + p]), weight * wavenumber * (ca + cb)
        both_real = a[6 * WIDE + p] * b[6 * WIDE + p] - a[7 * WIDE + p] * b[7 * WIDE + p]
        both_imag = a[6 * WIDE + p] * b[7 * WIDE + p] + a[7 * WIDE + p] * b[6 * WIDE + p]
        real, imag = near * both_real - far * both_imag, near * both_imag + far * both_real
        pair[p] = real * mean_real - imag * mean_imag
        pair[WIDE + p] = real * mean_imag + imag * mean_real
        pair[2 * WIDE + p] = -per_turn * (real * more_imag + imag * more_real)
        pair[3 * WIDE + p] = per_turn * (real * more_real - imag * more_imag)
        pair[4 * WIDE + p] = (a[p] + b[p] + lead) * per_step
        pair[5 * WIDE + p] = np.sqrt(max(both, _NONE))


@inlined
def _onto_grid(pair, count, table, total):
    """Share what each facet adds between two points of the grid, so that sum and first moment over path are right."""
    steps = _F(table.shape[1] - 1)
    for p in range(count):
        real, imag = pair[p], pair[WIDE + p]
        if real == _NONE and imag == _NONE:
            continue
        slot = int(pair[4 * WIDE + p])
        right = pair[4 * WIDE + p] - slot
        right_real, right_imag = right * real + pair[2 * WIDE + p], right * imag + pair[3 * WIDE + p]
        at = min(pair[5 * WIDE + p], _ONE) * steps
        below = min(int(at), table.shape[1] - 2)
        rise = at - below
        for q in range(len(table)):
            fr = table[q, below, 0] + rise * (table[q, below + 1, 0] - table[q, below, 0])
            fi = table[q, below, 1] + rise * (table[q, below + 1, 1] - table[q, below, 1])
            x, y = real * fr - imag * fi, real * fi + imag * fr
            u, v = right_real * fr - right_imag * fi, right_real * fi + right_imag * fr
            total[q, slot, 0] += x - u
            total[q, slot, 1] += y - v
            total[q, slot + 1, 0] += u
            total[q, slot + 1, 1] += v
