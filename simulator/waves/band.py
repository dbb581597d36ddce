"""Chebyshev nodes between 15 and 25 kHz, and the polynomials that carry gains from them to any frequency."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled

LOW_HZ, HIGH_HZ = 15_000.0, 25_000.0


def nodes_hz(count: int) -> Floats:
    """(count,) Chebyshev nodes of the band, increasing, Hz."""
    return to_hz(-np.cos(np.pi * (np.arange(count) + 0.5) / count))


def to_unit(frequency_hz: ArrayLike) -> Floats:
    """Frequency mapped so that the band becomes [-1, 1]."""
    return (2.0 * np.asarray(frequency_hz, dtype=np.float64) - LOW_HZ - HIGH_HZ) / (HIGH_HZ - LOW_HZ)


def to_hz(unit: ArrayLike) -> Floats:
    """The inverse of `to_unit`."""
    return 0.5 * (LOW_HZ + HIGH_HZ) + 0.5 * (HIGH_HZ - LOW_HZ) * np.asarray(unit, dtype=np.float64)


def coefficients(values: Complexes) -> Complexes:
    """(P, K) values at the nodes to (P, K) Chebyshev coefficients, exact at the nodes."""
    return _times(np.ascontiguousarray(values, dtype=np.complex128), _fit(values.shape[-1]))


@compiled
def _times(values: Complexes, matrix: Floats) -> Complexes:
    """(P, J) product: a library would call other threads for it, whose waiting costs more than the product."""
    product = np.zeros((values.shape[0], matrix.shape[1]), dtype=np.complex128)
    for p in range(len(values)):
        for k in range(values.shape[1]):
            value = values[p, k]
            for j in range(matrix.shape[1]):
                product[p, j] += value * matrix[k, j]
    return product


@lru_cache
def _fit(count: int) -> Floats:
    """(count, count) matrix from values at the nodes to coefficients."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(to_unit(nodes_hz(count)), count - 1)).T, dtype=np.float64)


def evaluate(coefficient: Complexes, frequency_hz: ArrayLike) -> Complexes:
    """(P, K) coefficients to (P, F) values; frequencies outside the band take the value at its nearer end."""
    unit = np.clip(to_unit(frequency_hz), -1.0, 1.0)
    return coefficient @ chebyshev.chebvander(unit, coefficient.shape[-1] - 1).T


REFERENCE_HZ = 20_000.0  # middle of the band in which gains are kept
