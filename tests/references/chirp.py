"""Two transfer functions compared as a detector hears them: at the peak of the matched-filter envelope of the beep."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

START_HZ, STOP_HZ, BEEP_S, RATE_HZ = 18_000.0, 23_000.0, 0.050, 192_000.0
NODES = 28  # follows a creeping wave 0.8 ms behind the echo across the band
LOW_HZ, HIGH_HZ = 17_500.0, 23_500.0
GRID_HZ = np.linspace(LOW_HZ, HIGH_HZ, 301)


def nodes_hz() -> Floats:
    """(NODES,) frequencies at which transfer functions are compared: Chebyshev nodes of 17.5-23.5 kHz."""
    return 0.5 * (LOW_HZ + HIGH_HZ) + 0.5 * (HIGH_HZ - LOW_HZ) * chebyshev.chebpts1(NODES)


@dataclass(frozen=True)
class Difference:
    """An echo against its reference.

    Attributes:
        level_db: level at the envelope's peak above the reference's.
        delay_samples: time of the peak behind the reference's, samples at 192 kHz.
        correlation: of the two chirp responses as real waveforms, no shift allowed.
    """

    level_db: float
    delay_samples: float
    correlation: float


def difference(ours: ArrayLike, reference: ArrayLike, delay_s: float) -> Difference:
    """Compare two (NODES,) transfer functions at `nodes_hz` whose echo arrives near `delay_s`."""
    a, b = _on_grid(np.asarray(ours), delay_s), _on_grid(np.asarray(reference), delay_s)
    power = beep_power()
    (level_a, time_a), (level_b, time_b) = _peak(power * a), _peak(power * b)
    inner = np.real(np.sum(power * a * np.conj(b)))
    norms = np.sqrt(np.sum(power * np.abs(a) ** 2) * np.sum(power * np.abs(b) ** 2))
    return Difference(20.0 * np.log10(level_a / level_b), (time_a - time_b) * RATE_HZ, float(inner / norms))


@cache
def beep_power() -> Floats:
    """(G,) power spectrum of the Hann chirp at the grid, sum 1; 99.99 % of the beep's energy lies inside."""
    t = (np.arange(round(BEEP_S * RATE_HZ)) + 0.5) / RATE_HZ
    phase = 2.0 * np.pi * (START_HZ + 0.5 * (STOP_HZ - START_HZ) / BEEP_S * t) * t
    beep = np.sin(np.pi * t / BEEP_S) ** 2 * np.exp(1j * phase)
    power = np.abs(np.exp(-2j * np.pi * GRID_HZ[:, None] * t) @ beep) ** 2
    return power / power.sum()


def _on_grid(transfer: Complexes, delay_s: float) -> Complexes:
    """(G,) the transfer function between its nodes, without the travel phase that no polynomial could follow."""
    slow = transfer * np.exp(2j * np.pi * nodes_hz() * delay_s)
    x = (2.0 * GRID_HZ - LOW_HZ - HIGH_HZ) / (HIGH_HZ - LOW_HZ)
    nodes = chebyshev.chebpts1(NODES)
    fit = np.linalg.solve(chebyshev.chebvander(nodes, NODES - 1), slow)
    return chebyshev.chebvander(x, NODES - 1) @ fit


def _peak(spectrum: Complexes) -> tuple[float, float]:
    """Height and time, s, of the envelope's peak within two samples of time 0."""
    found = minimize_scalar(
        lambda t: -abs(np.sum(spectrum * np.exp(2j * np.pi * GRID_HZ * t))),
        bounds=(-4.0 / RATE_HZ, 4.0 / RATE_HZ), method="bounded", options={"xatol": 1e-10},
    )  # fmt: skip
    return -float(found.fun), float(found.x)
