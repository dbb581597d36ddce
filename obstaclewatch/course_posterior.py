"""The posterior over courses: prior, agreement with ranges and with microphone 1, and how walkers walk."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from obstaclewatch.carrier_phase import log_agreement
from obstaclewatch.course_geometry import Singles

Array = NDArray[np.float64]

SHARE_HEARD = 0.4
"""Share of microphone 1's power that counts: beeps within a step share their deviations."""
MOST_MISFIT = 40.0
"""Squared deviations in all, beyond which a course is not thought less likely: some peaks are of another echo."""


@numba.njit(cache=True, error_model="numpy")
def posterior(
    log_prior: Array, misfit: Singles, total: Singles, tells_phase: NDArray[np.bool_], phase_rad: float, density: Array
) -> Array:
    """(H,) probabilities, 1 together.

    Args:
        log_prior: (H,).
        misfit: (H,) squared deviations of the ranges.
        total: (2, H) real and imaginary part of what adds up in phase at microphone 1.
        tells_phase: (H,) whether that sum's own phase is known: of upright things and walls alone, whose height is
            known, as 10 cm of another height turn it by a quarter of a cycle; and not of phones that were not measured.
        phase_rad: what microphone 1 adds to it.
        density: (H,) of the speed of approach.
    """
    log = np.empty(len(log_prior))
    for course in range(len(log)):
        real, imaginary = float(total[0, course]), float(total[1, course])
        heard = SHARE_HEARD * (real * real + imaginary * imaginary)
        if tells_phase[course]:
            heard += log_agreement(real, imaginary, phase_rad)
        log[course] = log_prior[course] + log_fit(float(misfit[course])) + heard + np.log(density[course])
    share = np.exp(log - log.max())
    return share / share.sum()


@numba.njit(cache=True, error_model="numpy")
def log_fit(misfit: float) -> float:
    """Log likelihood of squared deviations, which saturates."""
    return -0.5 * MOST_MISFIT * (1.0 - np.exp(-misfit / MOST_MISFIT))
