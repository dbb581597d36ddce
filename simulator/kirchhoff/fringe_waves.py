"""What Kirchhoff's integral leaves out at a rim: fringe waves (Ufimtsev, Method of Edge Waves, 1962).

The integral over the two faces of an edge has edge waves of its own, which are not those of a wedge. Of both the line
integrals along the edge are known, with the same exponential: the exact one of the wedge (Biot and Tolstoy 1957,
Medwin; as written by Svensson, Fred and Vanderkooy 1999), and the Maggi-Rubinowicz one of the integral over a face.
Their difference is summed along the rim:

    p = -1/(4 pi) int [nu sum sin(nu phi) / (cosh(nu eta) - cos(nu phi)) - sum sin x / (cosh eta + cos x)]
        e^{-jk(l + m)} / (l m) dz

with phi = pi +- t +- t' of the angles t, t' of source and receiver from a face, nu = pi over the open angle, and
x = t + t' from each face that both ends see. At the border of a reflection both parts grow without bound, their
difference does not: so the sum goes on smoothly where the point of reflection runs off the rim. A bin seen from above
its rim comes within 0.1 dB of full-wave values, where the integral alone errs by 1.4 dB.

Elements of which neither face is seen from both ends add nothing, nor does the body's own shadow. What hides a face
that both ends are before hides its reflection as well, and so the part of the wedge's wave that goes with it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.compiled_vectors import dot
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.path_length_grid import STEP_M, Grid
from simulator.surfaces.creases import Creases

ON_BORDER = 1e-12  # of eta^2 + (pi - x)^2: nearer to a border the two parts cancel by more digits than there are


def add_fringe_waves(
    creases: Creases, center_m: Floats, ends: Ends, first: Ints, second: Ints, reflection: Complexes, grid: Grid,
    total: Floats,
) -> None:  # fmt: skip
    """Add the fringe waves of all creases to grids of path length, at the band's centre.

    Args:
        center_m: (3,) the body's, about which the grid lies.
        first, second: (R,) ends of each pair.
        reflection: (Q, C) parts of the surface's reflection at C cosines of incidence from 0 to 1 in even steps.
        total: (R, Q, points, 2) added to.
    """
    elements = _Elements(
        creases.middle_m, creases.along_m, creases.inwards, creases.normal, creases.open_angle_rad, creases.beside,
        creases.share,
    )  # fmt: skip
    seen = _Seen(ends.point_m, ends.drift_m, ends.lean, ends.view, ends.lit, *ends.over(center_m))
    _add(elements, seen, first, second, grid.centre_rad_m, np.ascontiguousarray(reflection), grid.lead_m, total)


class _Elements(NamedTuple):
    """The elements of rims, as `Creases` has them."""

    middle: Floats
    along: Floats
    inwards: Floats
    normal: Floats
    open_angle: Floats
    beside: Ints
    weight: Floats


class _Seen(NamedTuple):
    """The ends, as `Ends` has them, and how far each is from the body's centre and how much farther it seems."""

    point: Floats
    drift: Floats
    lean: Floats
    view: Ints
    lit: Flags
    away: Floats
    coupled: Floats


@compiled
def _add(elements, ends, pair_first, pair_second, k, reflection, lead, total):
    """`add_fringe_waves`, element by element: the phase runs evenly along one, all else stands for its middle."""
    middle, along, inwards, normal, open_angle, beside, weight = elements
    point, drift, lean, view, lit, away, coupled = ends
    for r in range(len(pair_first)):
        a, b = pair_first[r], pair_second[r]
        here, there = lit[view[a]], lit[view[b]]
        for e in range(len(middle)):
            first = here[beside[e, 0]] and there[beside[e, 0]]
            second = here[beside[e, 1]] and there[beside[e, 1]]
            if not (first or second):
                continue
            length = np.sqrt(dot(along[e], along[e]))
            s = _about(point[a], middle[e], along[e], length, inwards[e], normal[e])
            t = _about(point[b], middle[e], along[e], length, inwards[e], normal[e])
            if s[1] >= open_angle[e] or t[1] >= open_angle[e]:
                continue
            second = second and open_angle[e] - min(s[1], t[1]) < np.pi  # a mirrored face is not asked for its light
            l, m = np.hypot(s[0], s[2]), np.hypot(t[0], t[2])
            strength = weight[e] * _fringe(s, t, l, m, open_angle[e], first, second) * length / (-4.0 * np.pi * l * m)
            strength *= _towards(point[a], lean[a], middle[e], l) * _towards(point[b], lean[b], middle[e], m)
            slope = 0.5 * length * (s[2] / l + t[2] / m)
            excess = l + m - away[a] - away[b]
            seeming = excess + _along(drift[a], point[a], middle[e]) / l + _along(drift[b], point[b], middle[e]) / m
            place = (seeming - coupled[a] - coupled[b] + lead) / STEP_M
            wave = strength * np.sinc(k * slope / np.pi) * np.exp(-1j * k * excess)
            below, rise = _step_of(s, t, l, m, open_angle[e], first, reflection.shape[1])
            slot = int(place)
            share = place - slot
            for q in range(len(reflection)):
                value = wave * ((1.0 - rise) * reflection[q, below] + rise * reflection[q, below + 1])
                total[r, q, slot, 0] += (1.0 - share) * value.real
                total[r, q, slot, 1] += (1.0 - share) * value.imag
                total[r, q, slot + 1, 0] += share * value.real
                total[r, q, slot + 1, 1] += share * value.imag


@compiled
def _towards(end, lean, middle, distance):
    """Directivity of the transducer at an end towards a point so far away."""
    return np.exp(-_along(lean, end, middle) / distance - np.sqrt(dot(lean, lean)))


@compiled
def _along(vector, end, middle):
    """Product of a vector with what leads from a point to an end."""
    along = 0.0
    for k in range(3):
        along += vector[k] * (end[k] - middle[k])
    return along


@compiled
def _about(end, middle, along, length, inwards, normal):
    """Distance of an end from an edge, angle from its face 0, 0 to 2 pi, and place along it."""
    x = y = z = 0.0
    for k in range(3):
        offset = end[k] - middle[k]
        x, y, z = x + offset * inwards[k], y + offset * normal[k], z + offset * (along[k] / length)
    return np.hypot(x, y), np.arctan2(y, x) % (2.0 * np.pi), z


@inlined
def _fringe(s, t, l, m, open_angle, first, second):
    """The bracket of the integral, for the faces that both ends see."""
    nu = np.pi / open_angle
    cosh = max((l * m + s[2] * t[2]) / (s[0] * t[0]), 1.0)
    eta = np.arccosh(cosh)
    x = s[1] + t[1]
    beyond = 2.0 * open_angle - x
    bracket = 0.0
    for sign in (-1.0, 1.0):
        bracket += nu * _share(nu * (np.pi + sign * (s[1] - t[1])), np.cosh(nu * eta))
    # x grows past pi at the border of face 0, what is left of it to 2 open angles past that of face 1
    faces = max(s[1], t[1]) < np.pi, open_angle - min(s[1], t[1]) < np.pi
    for angle, seen, faced in ((x, first, faces[0]), (beyond, second, faces[1])):
        if (faced and not seen) or eta**2 + (np.pi - angle) ** 2 < ON_BORDER:
            continue
        bracket += nu * _share(nu * (np.pi - angle), np.cosh(nu * eta))
        if seen:
            bracket -= np.sin(angle) / (cosh + np.cos(angle))
    return bracket


@compiled
def _share(angle, cosh):
    return np.sin(angle) / (cosh - np.cos(angle))


@inlined
def _step_of(s, t, l, m, open_angle, first, cosines):
    """Row of the reflection, and how far on to the next, of the face that both ends see, face 0 if that is both.

    Taken at the geometric mean of their cosines.
    """
    a, b = (s[1], t[1]) if first else (open_angle - s[1], open_angle - t[1])
    cosine = np.sqrt(abs(np.sin(a) * s[0] / l * np.sin(b) * t[0] / m))
    step = min(cosine, 1.0) * (cosines - 1)
    below = min(int(step), cosines - 2)
    return below, step - below
