"""A rigid prism without ends, lit by a line source along it: boundary elements round its cross-section.

Helmholtz's equation for the pressure on a rigid outline, by collocation at the middles of straight elements on which it
is constant. A little damping, a complex wavenumber, keeps clear of the resonances inside. Against the series of a round
cylinder: 0.1 % (`tests/simulator/field/test_pillars.py`).

A point source before a long prism sends along each path of length L what a line source sends, times
4 sqrt(pi k / 2) e^{j pi / 4} / sqrt(L): the same for all paths but for the root of L.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import hankel2

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

POINTS, WEIGHTS = (0.5 * each for each in np.polynomial.legendre.leggauss(4))
HALVINGS = 6  # of the elements next to a corner, where the pressure bends


def elements(corner_m: Floats, step_m: float) -> tuple[Floats, Floats]:
    """(N, 2) starts and ends of the elements of an outline, so long at most and shorter next to its corners."""
    ends = []
    for start, end in zip(corner_m, np.roll(corner_m, -1, axis=0), strict=True):
        even = np.linspace(0.0, 1.0, 1 + int(np.ceil(np.linalg.norm(end - start) / step_m)))
        fine = even[1] * 0.5 ** np.arange(HALVINGS, 0, -1)
        share = np.concatenate([[0.0], fine, even[1:-1], 1.0 - fine[::-1], [1.0]])
        ends.append(start + share[:, None] * (end - start))
    return np.concatenate([each[:-1] for each in ends]), np.concatenate([each[1:] for each in ends])


def scattered(outline: tuple[Floats, Floats], wavenumber: complex, source_m: Floats, receiver_m: Floats) -> Complexes:
    """(S, R) pressure that a rigid outline of elements scatters from line sources (S, 2) to receivers (R, 2)."""
    middle = 0.5 * (outline[0] + outline[1])
    system = 0.5 * np.eye(len(middle)) - _double_layer(middle, outline, wavenumber)
    pressure = np.linalg.solve(system, free(middle, source_m, wavenumber))
    return (_double_layer(receiver_m, outline, wavenumber) @ pressure).T


def free(point_m: Floats, source_m: Floats, wavenumber: complex) -> Complexes:
    """(P, S) free field of line sources."""
    distance = np.linalg.norm(point_m[:, None] - source_m, axis=2)
    return -0.25j * hankel2(0, wavenumber * distance)


def as_point_source(pressure: Complexes, wavenumber: complex) -> Complexes:
    """What a point source of 1 at 1 m sends along paths before a long prism, times sqrt(L)."""
    return pressure * 4.0 * np.sqrt(0.5 * np.pi * wavenumber) * np.exp(0.25j * np.pi)


def _double_layer(point_m: Floats, outline: tuple[Floats, Floats], wavenumber: complex) -> Complexes:
    """(P, N) integrals over elements of the free field's derivative along their outward normals."""
    start, step = outline[0], outline[1] - outline[0]
    length = np.linalg.norm(step, axis=1)
    normal = np.column_stack([step[:, 1], -step[:, 0]]) / length[:, None]
    total = np.zeros((len(point_m), len(start)), dtype=np.complex128)
    for place, weight in zip(0.5 + POINTS, WEIGHTS, strict=True):
        offset = point_m[:, None] - (start + place * step)
        distance, rise = np.linalg.norm(offset, axis=2), np.sum(offset * normal, axis=2)
        apart = np.abs(rise) > 1e-12  # on its own line an element has no derivative
        slope = np.zeros_like(total)
        slope[apart] = hankel2(1, wavenumber * distance[apart]) * -rise[apart] / distance[apart]
        total += 0.25j * wavenumber * weight * length * slope
    return total
