"""Path difference between the microphones from carriers and envelopes jointly, over many beeps.

At 20.5 kHz a cycle is 16.7 mm of path: the phase is tenfold finer than the envelope, but repeats. No cycle is chosen.
Microphone 1's envelope around a peak of microphone 0, rotated by that peak's phase, is kept; a trajectory predicts the
path difference of every beep, and what is kept adds up in phase over beeps along the true trajectory alone. The phase
of the sum gives the direction itself, if the phase that microphone 1's channel adds is known
(`log_agreement`).
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.argument_types import as_number
from obstaclewatch.support.arrays import Complexes, Floats, SingleComplexes, Singles
from obstaclewatch.support.compiled import compiled, inlined

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
it made bearings a little better and collisions worse: another height rotates it too."""
PI, HALF, MOST_CYCLES = np.float32(np.pi), np.float32(0.5), np.float32(64.0)
SERIES = tuple(
    (np.float32(s / factorial(k + 1)), np.float32(s / factorial(k)))
    for k, s in ((10, -1), (8, 1), (6, -1), (4, 1), (2, -1), (0, 1))
)
"""Taylor's, of sin(x) / x and cos(x), from the highest power of x^2 on: up to pi / 2 right to 6e-8 and 5e-7."""
I0_SERIES = tuple(1.0 / factorial(k) ** 2 for k in range(12, -1, -1))
ODD = 0.1
"""Share of echoes whose phase is another's: two that overlap, or from another height."""


def checked_mic_phase(mic_phase_rad: float | None) -> float | None:
    """What microphone 1's channel adds to the phase, if it can.

    Raises:
        ValueError: neither a finite number nor None, which stands for not known.
    """
    if mic_phase_rad is None:
        return None
    mic_phase_rad = as_number("mic_phase_rad", mic_phase_rad)
    if not np.isfinite(mic_phase_rad):
        raise ValueError(f"mic_phase_rad must be finite or None, got {mic_phase_rad}")
    return mic_phase_rad


@inlined
def second_channel(envelope: Complexes, position: Floats, offset: Floats, noise: float) -> SingleComplexes:
    """(n, W) envelope of microphone 1 at offsets (W,), samples, after n peaks of microphone 0 at positions (n,).

    Each row is rotated so that microphone 0's peak has phase 0, and divided by the rms of microphone 1's noise.
    The envelope of an echo at delay d has the phase -2 pi reference_hz d; a path longer by u rotates the row by
    -2 pi reference_hz u / c. `envelope` is (2, M).
    """
    rows, first, second = np.empty((len(position), len(offset)), dtype=np.complex64), envelope[0], envelope[1]
    for peak in range(len(position)):
        own = complex_at(first, position[peak])
        rotation = own.conjugate() / abs(own) / noise
        for column in range(len(offset)):
            rows[peak, column] = complex_at(second, position[peak] + offset[column]) * rotation
    return rows


@inlined
def received_at(received: Singles, sample: NDArray[np.int32], row: SingleComplexes, u_m: Singles) -> None:
    """Fill in (2, H) real and imaginary part of a row (W,) of `second_channel` at path differences.

    It is linear between samples; where to read, (H,), is found before reading, which would keep the loop from being
    vectorised.
    """
    first, per_m, last = np.float32(-REACH_M), np.float32(1.0 / STEP_M), np.float32(len(row) - 1.01)
    for trajectory in range(len(u_m)):
        position = (u_m[trajectory] - first) * per_m
        position = position if position > np.float32(0.0) else np.float32(0.0)  # so that NaN reads no other memory
        position = position if position < last else last
        sample[trajectory] = np.int32(position)
        received[0, trajectory] = position - np.float32(sample[trajectory])
    for trajectory in range(len(u_m)):
        low, rest = (
            np.uint64(sample[trajectory]),
            received[0, trajectory],
        )  # unsigned: there is no end to count back from
        before, after = row[low], row[low + np.uint64(1)]
        received[0, trajectory] = before.real + rest * (after.real - before.real)
        received[1, trajectory] = before.imag + rest * (after.imag - before.imag)


@inlined
def deviation_factor(row: SingleComplexes) -> np.float32:
    """Factor that brings a row (W,) to units of noise and of a deviation that is `WOBBLE` of the echo."""
    power = np.float32(0.0)
    for value in row:
        power = max(power, value.real * value.real + value.imag * value.imag)
    return np.float32(1.0) / np.sqrt(np.float32(1.0) + np.float32(WOBBLE**2) * power)


@inlined
def add_rotated(total: Singles, received: Singles, u_m: Singles, per_m: np.float32, factor: np.float32) -> None:
    """Add to totals (2, H) what was received (2, H), times a factor and rotated by path differences at cycles a
    metre."""
    for trajectory in range(len(u_m)):
        cosine, sine = cycle(u_m[trajectory] * per_m)
        cosine, sine = factor * cosine, factor * sine
        total[0, trajectory] += received[0, trajectory] * cosine - received[1, trajectory] * sine
        total[1, trajectory] += received[0, trajectory] * sine + received[1, trajectory] * cosine


@inlined
def cycle(cycles: np.float32) -> tuple[np.float32, np.float32]:
    """Cosine and sine of so many cycles, within 1e-6 and fewer than 64: series of half the angle, doubled.

    Written out, since a library's functions take one number at a time.
    """
    rest = cycles - (np.float32(np.int32(cycles + MOST_CYCLES + HALF)) - MOST_CYCLES)
    angle2 = (PI * rest) ** 2
    sine, cosine = np.float32(0.0), np.float32(0.0)
    for of_sine, of_cosine in SERIES:
        sine, cosine = sine * angle2 + of_sine, cosine * angle2 + of_cosine
    sine *= PI * rest
    return cosine * cosine - sine * sine, np.float32(2.0) * sine * cosine


@inlined
def log_agreement(real: float, imaginary: float, phase_rad: float) -> float:
    """Log likelihood ratio of the phase of a coherent sum: near the expected one, against anywhere.

    A von Mises density over the circle's, as wide as noise and `PHASE_STD` make it; one in ten is from elsewhere.

    Args:
        real, imaginary: of the sum; one that is not above noise, 1, says nothing.
        phase_rad: what microphone 1 adds to the phase, compared with microphone 0.
    """
    power = real * real + imaginary * imaginary
    if power <= 1.0:
        return 0.0
    narrow = 1.0 / (PHASE_STD**2 + 0.5 / (power - 1.0))
    near = (real * np.cos(phase_rad) + imaginary * np.sin(phase_rad)) / np.sqrt(power)
    return np.log((1.0 - ODD) * np.exp(narrow * near) / bessel_i0(narrow) + ODD)


@inlined
def bessel_i0(argument: float) -> float:
    """Modified Bessel function of order 0: the power series, to 1e-12 up to 1 / `PHASE_STD`^2."""
    total, quarter2 = 0.0, 0.25 * argument * argument
    for coefficient in I0_SERIES:
        total = total * quarter2 + coefficient
    return total


@compiled
def complex_at(envelope: Complexes, position: float) -> complex:
    """An envelope (M,) at any position within it, linear between samples."""
    low = min(max(int(np.floor(position)), 0), len(envelope) - 2)
    rest = position - low
    return (1.0 - rest) * envelope[low] + rest * envelope[low + 1]


@compiled
def phase_at(envelope: Complexes, position: float, second_position: float) -> float:
    """Phase, rad, of the second of two envelopes (2, M) at its position against the first at its own."""
    early, late = complex_at(envelope[0], position), complex_at(envelope[1], second_position)
    return float(np.angle(late * early.conjugate()))
