"""How gait makes a walker's readings depart from a straight course at constant speed.

Once a step the trunk surges by about a centimetre, and through range-Doppler coupling the chirp reads 0.205 s of the
surge's speed as well: 2.8 cm at two steps a second, zero to peak. Deviations repeat with the step; so they are not
independent from beep to beep, of which a step holds six, and a straight line through few of them is worth less than
through as many independent readings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEP_HZ, STEP_STD_HZ = 1.85, 0.15
"""Steps per second of adults who walk at 1.0-1.5 m/s (Murakami and Otaka 2017: 1.6-2.0)."""
READING_M = 0.020
"""Standard deviation over a step: 2.8 cm / sqrt(2)."""
SWING_KNOWN_M = 0.010
"""The same with the swing known and taken off: half, as people surge by half as much or more."""
OTHER_M = 0.012
"""What is neither step nor noise: reflecting points that wander, echoes that overlap."""


def reading_covariance(time_s: Array, noise_std_m: Array, step_std_m: float = READING_M) -> Array:
    """(K, K) covariance, m^2, of K readings about a straight course.

    A sinusoid of random phase and of a frequency N(STEP_HZ, STEP_STD_HZ^2), and white noise.

    Args:
        time_s: (K,) times of the readings.
        noise_std_m: (K,) their deviations by noise.
        step_std_m: standard deviation over a step.
    """
    lag = 2.0 * np.pi * (time_s[:, None] - time_s)
    step = step_std_m**2 * np.cos(STEP_HZ * lag) * np.exp(-0.5 * (STEP_STD_HZ * lag) ** 2)
    covariance: Array = step + np.diag(OTHER_M**2 + noise_std_m**2)
    return covariance
