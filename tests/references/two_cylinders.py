"""Exact field behind rigid cylinders in a plane: multiple scattering by addition theorems.

Waves e^{jwt}, H^(2). Each cylinder scatters sum_m c_m H_m(kr) e^{jm phi}; Graf's theorem expands the others' waves
about it, and the conditions on all surfaces together are one system of equations (Martin, Multiple Scattering,
Cambridge 2006, chapter 4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import h2vp, hankel2, jvp

Floats = NDArray[np.float64]


def behind(
    middle_m: ArrayLike, radius_m: ArrayLike, source_m: ArrayLike, receiver_m: ArrayLike, wavenumber_1_m: float
) -> complex:
    """Field of a line source past cylinders, re the free field.

    Args:
        middle_m, radius_m: (N, 2) and (N,) of cylinders that do not touch.
        source_m, receiver_m: (2,) outside them.
    """
    k, middle, radius = wavenumber_1_m, np.asarray(middle_m, float), np.asarray(radius_m, float)
    source, receiver = np.asarray(source_m, float), np.asarray(receiver_m, float)
    highest = (k * radius + 12.0 + 4.0 * (k * radius) ** (1 / 3)).astype(int)
    order = [np.arange(-n, n + 1) for n in highest]
    answer = [-jvp(m, k * r) / h2vp(m, k * r) for m, r in zip(order, radius, strict=True)]
    first = np.cumsum([0, *map(len, order)])
    system, right = np.eye(first[-1], dtype=complex), np.empty(first[-1], dtype=complex)
    for i, here in enumerate(middle):
        own = slice(first[i], first[i + 1])
        distance, angle = _polar(source - here)
        right[own] = answer[i] * hankel2(order[i], k * distance) * np.exp(-1j * order[i] * angle)
        for j, there in enumerate(middle):
            if j != i:
                distance, angle = _polar(here - there)
                step = order[j] - order[i][:, None]
                wave = hankel2(step, k * distance) * np.exp(1j * step * angle)
                system[own, first[j] : first[j + 1]] = -answer[i][:, None] * wave
    strength, total = np.linalg.solve(system, right), hankel2(0, k * _polar(receiver - source)[0])
    free = total
    for i, here in enumerate(middle):
        distance, angle = _polar(receiver - here)
        wave = hankel2(order[i], k * distance) * np.exp(1j * order[i] * angle)
        total = total + strength[first[i] : first[i + 1]] @ wave
    return complex(total / free)


def _polar(vector: Floats) -> tuple[float, float]:
    return float(np.hypot(*vector)), float(np.arctan2(vector[1], vector[0]))
