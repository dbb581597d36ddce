"""Path difference between the microphones from carriers and envelopes together, over many beeps.

At 20.5 kHz a cycle is 16.7 mm of path: the phase is tenfold finer than the envelope, but repeats. No cycle is chosen.
Microphone 1's envelope around a peak of microphone 0, turned by that peak's phase, is kept; a course predicts the path
difference of every beep, and what is kept adds up in phase over beeps along the true course alone. What the phase of
the sum is tells of the direction itself, if the phase that microphone 1's channel adds is known (`log_agreement`).
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e

from obstaclewatch.matched_filter import EchoProfile

Array = NDArray[np.float64]

REACH_M = 0.19
"""Path differences that are kept, on either side: the longest phone's 16 cm and 3 cm more."""
STEP_M = 0.0143
"""Between two of them: one sample at 24 kHz."""
OFFSETS_M = np.arange(-REACH_M, REACH_M + STEP_M, STEP_M)
WOBBLE = 0.5
"""Deviation of the phase by the hand, rad: 1.5 degrees of pitch are 1.8 mm of path at 30 degrees, 0.7 rad of carrier at
their peak. As noise it grows with the echo, so that no beep says more than 1 / WOBBLE^2."""
PHASE_STD = 0.6
"""Deviation of the sum's phase, rad, besides noise: 0.3 (median of its size) over the loud echoes of known direction of
96 rendered walks of the development split, and pitch that is wrong by a degree makes 0.45 at 30 degrees. Taken for 0.4,
it made bearings a little better and collisions worse told: another height turns it too."""
ODD = 0.1
"""Share of echoes whose phase is another's: two that overlap, or from another height."""


def second_channel(profile: EchoProfile, delay_s: Array, noise: float, sound_speed_m_s: float) -> NDArray[np.complex64]:
    """(n, W) envelope of microphone 1 at `OFFSETS_M` of path after n peaks of microphone 0.

    Each row is turned so that microphone 0's peak has phase 0, and divided by the rms of microphone 1's noise.
    The envelope of an echo at delay d has the phase -2 pi reference_hz d; a path longer by u turns the row by
    -2 pi reference_hz u / c.
    """
    peak = complex_at(profile, 0, delay_s)
    around = complex_at(profile, 1, delay_s[:, None] + OFFSETS_M / sound_speed_m_s)
    turned: NDArray[np.complex128] = around * (peak.conj() / np.abs(peak) / noise)[:, None]
    return turned.astype(np.complex64)


@numba.njit(cache=True, error_model="numpy")
def at_path_differences(second: NDArray[np.complex64], u_m: Array) -> NDArray[np.complex64]:
    """(H, K) rows (K, W) of `second_channel` at path differences (H, K), linear between `OFFSETS_M`."""
    value = np.empty(u_m.shape, dtype=np.complex64)
    first, step, last = np.float32(-REACH_M), np.float32(STEP_M), np.float32(second.shape[1] - 1.01)
    along = np.empty(len(second), dtype=np.float32)
    for course in range(len(u_m)):
        for beep in range(len(second)):  # apart from the reading, which keeps several from being handled at once
            position = (np.float32(u_m[course, beep]) - first) / step
            position = position if position > 0.0 else np.float32(0.0)
            along[beep] = position if position < last else last
        for beep in range(len(second)):
            low = int(along[beep])
            rest, before, after = along[beep] - np.float32(low), second[beep, low], second[beep, low + 1]
            real = before.real + rest * (after.real - before.real)
            value[course, beep] = complex(real, before.imag + rest * (after.imag - before.imag))
    return value


def with_deviation(second: NDArray[np.complex64], share: float) -> NDArray[np.float32]:
    """(K,) factors that bring rows (K, W) to units of noise and of a deviation that is a share of the echo."""
    strength = np.abs(second).max(axis=1)
    factor: NDArray[np.float32] = 1.0 / np.sqrt(np.float32(1.0) + (np.float32(share) * strength) ** 2)
    return factor


def coherent_sum(value: NDArray[np.complex64], u_now_m: Array, wavelength_m: float) -> NDArray[np.complex128]:
    """(H,) what H courses gather in phase at microphone 1 from K beeps; its squared size is 1 for noise.

    Args:
        value: (H, K) from `at_path_differences`, for the times that the envelope reads.
        u_now_m: (H, K) path differences at the times at which the beep met the obstacle, which the phase reads.
        wavelength_m: c / reference_hz.
    """
    turn = np.asarray(2.0 * np.pi / wavelength_m * u_now_m, dtype=np.float32)
    scaled: NDArray[np.complex128] = _turned_sum(value, np.cos(turn), np.sin(turn)) / np.sqrt(value.shape[1])
    return scaled


@numba.njit(cache=True)
def _turned_sum(
    value: NDArray[np.complex64], cosine: NDArray[np.float32], sine: NDArray[np.float32]
) -> NDArray[np.complex128]:
    """(H,) sums over K of values turned by angles of the given cosines and sines."""
    total = np.empty(len(value), dtype=np.complex128)
    for course in range(len(value)):
        real = imag = np.float32(0.0)
        for beep in range(value.shape[1]):
            own, turn = value[course, beep], (cosine[course, beep], sine[course, beep])
            real += own.real * turn[0] - own.imag * turn[1]
            imag += own.real * turn[1] + own.imag * turn[0]
        total[course] = complex(real, imag)
    return total


def log_agreement(total: NDArray[np.complex128], phase_rad: float) -> Array:
    """(H,) log likelihood ratio of the phases of `coherent_sum`: near the expected one, against anywhere.

    A von Mises density over the circle's, as wide as noise and `PHASE_STD` make it; one in ten is from elsewhere.

    Args:
        total: (H,) sums; one that is not above noise says nothing.
        phase_rad: what microphone 1 adds to the phase, compared with microphone 0.
    """
    heard = np.maximum(np.abs(total) ** 2 - 1.0, 1e-3)
    narrow = 1.0 / (PHASE_STD**2 + 0.5 / heard)
    likeness = np.exp(narrow * (np.cos(np.angle(total) - phase_rad) - 1.0)) / i0e(narrow)
    ratio: Array = np.log((1.0 - ODD) * likeness + ODD)
    return ratio


def complex_at(profile: EchoProfile, channel: int, delay_s: Array) -> NDArray[np.complex128]:
    """Envelope of a channel at any delays within the profile (any shape), linear between samples."""
    position = (delay_s - profile.start_s) * profile.rate_hz
    low = np.minimum(np.maximum(np.floor(position).astype(np.intp), 0), profile.envelope.shape[1] - 2)
    rest = position - low
    value: NDArray[np.complex128] = (1.0 - rest) * profile.envelope[channel, low]
    return value + rest * profile.envelope[channel, low + 1]
