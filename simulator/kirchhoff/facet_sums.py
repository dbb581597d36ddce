"""The sum over facets, compiled: one evaluation a facet and pair of ends at the band's centre, spread over path length.

Float32 and no branches within the rows, so that the compiler works on eight facets at a time: 0.05 mm of rounding in
a path of metres is 2e-4 rad of phase, -70 dB of what each facet adds, at random. Rows are worked on as far as whole
vectors reach, one facet at a time being slow; what comes of it past the last of a block is not added.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Flags, Ints
from obstaclewatch.support.compiled import fused, fused_inline
from simulator.kirchhoff.facet_waves import HALF, NONE, ONE, SINGLE, THIRD, TWO, either, facet_wave, turn
from simulator.kirchhoff.illuminating_images import NOWHERE_M
from simulator.surfaces.facets import BLOCK, Facets

VECTOR = 16  # facets
WIDE = BLOCK  # a constant: offsets known to the compiler spare it a check of every pair of rows for overlap
_PER_EIGHT, _SIXTH, _PER_24 = SINGLE(1 / 8), SINGLE(1 / 6), SINGLE(1 / 24)
_PER_4_PI = SINGLE(0.25 / np.pi)
_NOWHERE = SINGLE(NOWHERE_M)

NOTHING, QUARTERS, SOME = range(3)  # what a view shows of a block: no facet, quarters of facets that are lit, others


class Blocks(NamedTuple):
    """F facets, block by block.

    Attributes:
        rows: (B, 16 * WIDE) columns of each block, one after the other: x, y, z of the centroids about the body's
            centre, normal, area, first and second corner about the corners' mean, the edges' bulges.
        start: (B + 1,) the facet with which each block begins.
        part_of: (F,) the facet that each is a quarter of, -1 where it is none.
    """

    rows: NDArray[np.float32]
    start: Ints
    part_of: Ints

    @classmethod
    def of(cls, facets: Facets) -> Blocks:
        """Those of a body."""
        about = facets.middle_m - facets.center_m
        rows = _rows(facets.start, about, facets.normal, facets.area_m2, facets.corner_m, facets.bulge_m)
        return cls(rows, facets.start, facets.part_of)


class GroupedEnds(NamedTuple):
    """E ends in G groups.

    Attributes:
        columns: (E, 9) points about the body's centre, leans, drifts.
        of_view: (E,) which view each end has; numba takes any other `view` for numpy's.
        lit: (V, F) facets that each view shows.
        start: (G + 1,) the end with which each group begins.
    """

    columns: NDArray[np.float32]
    of_view: Ints
    lit: Flags
    start: Ints


class GroupedPairs(NamedTuple):
    """R pairs of ends, and (G + 1,) the pair with which each group begins."""

    first: Ints
    second: Ints
    start: Ints


@fused
def _rows(start, about, normal, area, corner, bulge):
    """The columns from centroids (F, 3) about the body, normals, areas, corners (F, 3, 3) and bulges (F, 3)."""
    rows = np.zeros((len(start) - 1, 16 * WIDE), np.float32)
    for block in range(len(rows)):
        row = rows[block]
        for p in range(start[block + 1] - start[block]):
            f = start[block] + p
            row[6 * WIDE + p] = area[f]
            for k in range(3):
                mean = (corner[f, 0, k] + corner[f, 1, k] + corner[f, 2, k]) / 3.0
                row[k * WIDE + p], row[(3 + k) * WIDE + p] = about[f, k], normal[f, k]
                row[(7 + k) * WIDE + p], row[(10 + k) * WIDE + p] = corner[f, 0, k] - mean, corner[f, 1, k] - mean
                row[(13 + k) * WIDE + p] = bulge[f, k]
    return rows


@fused
def add_facets(blocks, ends, pairs, wavenumber, table, closed, lead, step, total):
    """Add all facets to the grids of all pairs, block by block and group by group of ends.

    Args:
        blocks, ends, pairs: `Blocks`, `GroupedEnds`, `GroupedPairs`.
        wavenumber: at the band's centre.
        table: (Q, C, 2) float32 parts of the reflection at C cosines of incidence.
        closed: whether facets show on one side alone.
        lead: from the grid's first point to the path over the body's centre; step: of the grid, m.
        total: (R, Q, N, 2) float64 sums on the grid.
    """
    rows, start, part_of, view, lit = blocks.rows, blocks.start, blocks.part_of, ends.of_view, ends.lit
    most = 0
    for g in range(len(ends.start) - 1):
        most = max(most, ends.start[g + 1] - ends.start[g])
    segments = np.empty((most, 9 * WIDE), np.float32)
    pair = np.empty(6 * WIDE, np.float32)
    shown = _shown(lit, start, part_of)
    for block in range(len(rows)):  # outside, since the rows of a body fill no processor's cache
        begin, part = start[block], rows[block]
        count = start[block + 1] - begin
        padded = (count + VECTOR - 1) // VECTOR * VECTOR
        for g in range(len(ends.start) - 1):
            first_end, best = ends.start[g], NOTHING
            for e in range(first_end, ends.start[g + 1]):
                best = max(best, shown[view[e], block])
            if best != SOME:
                continue
            for e in range(first_end, ends.start[g + 1]):
                if shown[view[e], block] != NOTHING:
                    segment = segments[e - first_end]
                    _light(lit[view[e]], begin, count, part_of, segment[6 * WIDE :])
                    _segment(part, padded, ends.columns[e], wavenumber, closed, segment)
            for r in range(pairs.start[g], pairs.start[g + 1]):
                a, b = pairs.first[r], pairs.second[r]
                here, there = shown[view[a], block], shown[view[b], block]
                if min(here, there) != NOTHING and max(here, there) == SOME:
                    here, there = segments[a - first_end], segments[b - first_end]
                    _pair(part, padded, here, there, wavenumber, lead, ONE / step, pair)
                    _onto_grid(pair, count, table, total[r])


@fused_inline
def _shown(lit, start, part_of):
    """(V, B) what each view shows of each block."""
    shown = np.full((len(lit), len(start) - 1), NOTHING, np.int8)
    for v in range(len(lit)):
        for block in range(len(start) - 1):
            for f in range(start[block], start[block + 1]):
                if lit[v, f]:
                    shown[v, block] = QUARTERS
                    if part_of[f] < 0 or not lit[v, part_of[f]]:
                        shown[v, block] = SOME
                        break
    return shown


@fused_inline
def _light(lit, begin, count, part_of, light):
    """Fill rows: 1 for the facets that are lit, 0 for others; two rows on 1 for quarters of a facet that is."""
    for p in range(count):
        whole = part_of[begin + p]
        light[p] = lit[begin + p]
        light[2 * WIDE + p] = whole >= 0 and lit[whole]


@fused_inline
def _segment(part, count, end, wavenumber, closed, segment):
    """Fill rows: excess of the seeming length, cosine, 1 / length, unit vector, and the wave without the phase to the
    centre.

    Row 6 says beforehand which facets are lit, row 8 which are quarters of such. The transducer's directivity is taken
    facet by facet: that of one facet for a cell moved echoes of people by 0.5 dB, however fine the facets.
    """
    sx, sy, sz = end[0], end[1], end[2]
    lx, ly, lz, vx, vy, vz = end[3], end[4], end[5], end[6], end[7], end[8]
    centre, lean = np.sqrt(sx * sx + sy * sy + sz * sz), np.sqrt(lx * lx + ly * ly + lz * lz)
    least, seeming = NONE if closed else -TWO, centre + (vx * sx + vy * sy + vz * sz) / max(centre, _NOWHERE)
    for p in range(count):
        dx, dy, dz = sx - part[p], sy - part[WIDE + p], sz - part[2 * WIDE + p]
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        per = ONE / length
        dx, dy, dz = dx * per, dy * per, dz * per
        segment[p], segment[2 * WIDE + p] = length + (dx * vx + dy * vy + dz * vz) - seeming, per
        segment[3 * WIDE + p], segment[4 * WIDE + p], segment[5 * WIDE + p] = dx, dy, dz
        segment[WIDE + p] = max(dx * part[3 * WIDE + p] + dy * part[4 * WIDE + p] + dz * part[5 * WIDE + p], least)
        sine, cosine = turn(wavenumber * (length - centre))
        weight = segment[6 * WIDE + p] * per * _falling(lean + dx * lx + dy * ly + dz * lz)
        segment[6 * WIDE + p], segment[7 * WIDE + p] = weight * cosine, -weight * sine


@fused_inline
def _falling(x):
    """e^-x, x from 0 to a few: the eighth power of a polynomial, to 2e-4 at -20 dB."""
    y = x * _PER_EIGHT
    root = ONE - y * (ONE - y * (HALF - y * (_SIXTH - y * _PER_24)))
    square = root * root
    return (square * square) * (square * square)


@fused_inline
def _pair(part, count, a, b, wavenumber, lead, per_step, pair):
    """Fill rows: what each facet adds, complex, its first moment on the grid, complex, its place there, the cosine."""
    per_turn = per_step / wavenumber
    for p in range(count):
        both = a[WIDE + p] * b[WIDE + p]
        hx, hy = a[3 * WIDE + p] + b[3 * WIDE + p], a[4 * WIDE + p] + b[4 * WIDE + p]
        hz = a[5 * WIDE + p] + b[5 * WIDE + p]
        first = wavenumber * (hx * part[7 * WIDE + p] + hy * part[8 * WIDE + p] + hz * part[9 * WIDE + p])
        second = wavenumber * (hx * part[10 * WIDE + p] + hy * part[11 * WIDE + p] + hz * part[12 * WIDE + p])
        steep = wavenumber * (a[WIDE + p] + b[WIDE + p])
        one, other, third = steep * part[13 * WIDE + p], steep * part[14 * WIDE + p], steep * part[15 * WIDE + p]
        mean_real, mean_imag, more_real, more_imag, bent_real, bent_imag = facet_wave(first, second, one, other, third)
        level = THIRD * (one + other + third)  # the centroid lies on the rounded surface: its phase has the mean
        bent_real, bent_imag = bent_real - level * mean_real, bent_imag - level * mean_imag
        mean_real, mean_imag = mean_real - bent_imag, mean_imag + bent_real
        apart = ONE - a[8 * WIDE + p] * b[8 * WIDE + p]  # 0 where the whole facet adds what its quarters would
        weight = _PER_4_PI * part[6 * WIDE + p] * either(both) * apart
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
        pair[5 * WIDE + p] = np.sqrt(max(both, NONE))


@fused_inline
def _onto_grid(pair, count, table, total):
    """Share what each facet adds between two points of the grid, so that sum and first moment over path are right."""
    steps = SINGLE(table.shape[1] - 1)
    for p in range(count):
        real, imag = pair[p], pair[WIDE + p]
        if real == NONE and imag == NONE:
            continue
        slot = int(pair[4 * WIDE + p])
        right = pair[4 * WIDE + p] - slot
        right_real, right_imag = right * real + pair[2 * WIDE + p], right * imag + pair[3 * WIDE + p]
        at = min(pair[5 * WIDE + p], ONE) * steps
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
