"""The emitted signal ("beep"): a windowed linear chirp, repeated after a gap without sound (paper section 3.3).

Phase and window are closed forms of time, so that a simulator can evaluate the beep at any retarded instant
and a detector can sample it at any rate; neither needs the other's samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, as_floats, as_number, hold_numbers
from obstaclewatch.support.arrays import Floats

LEAST_TAPER = 0.01  # what rises faster is a click
LOWEST_HZ = 1000.0  # no phone makes a beam of lower sound; 18 stands for 18 kHz
LONGEST_S = 10.0  # of a beep and of a gap: from 1.7 km sound is back; milliseconds given for seconds end here
HIGHEST_RATE_HZ = 1e6  # five times that of any phone: a beep's samples must fit memory


@dataclass(frozen=True)
class BeepDesign:
    """A linear chirp under a Hann window (paper section 3.3: 18-23 kHz, 50 ms, 40 ms gap, 192 kHz).

    Attributes:
        start_hz, stop_hz: instantaneous frequency at the start and the end of the beep.
        duration_s: length of the beep.
        gap_s: time without sound between the end of a beep and the start of the next.
        sample_rate_hz: rate at which the phone plays and records.
        taper: share of the beep over which the window rises and falls; 1 is the paper's Hann window, less a Tukey
            window, which emits more energy at the same peak.

    Raises:
        ValueError: a time is not a positive number or above 10 s, the sample rate is above 1 MHz, a frequency is below
            1 kHz (kHz given for Hz), the two frequencies are equal, the band passes half the sample rate, the beep is
            shorter than two samples, the period is not a whole number of samples, or the taper is not between 0.01 and
            1.

    >>> beep = BeepDesign()
    >>> beep.period_samples, len(beep.samples())
    (17280, 9600)
    >>> print(f"{beep.chirp_rate_hz_s:.0f} Hz/s, reads {beep.range_doppler_s:.3f} s ahead")
    100000 Hz/s, reads 0.205 s ahead
    """

    start_hz: float = 18_000.0
    stop_hz: float = 23_000.0
    duration_s: float = 0.050
    gap_s: float = 0.040
    sample_rate_hz: float = 192_000.0
    taper: float = 1.0

    def __post_init__(self) -> None:
        hold_numbers(self, "start_hz", "stop_hz", "duration_s", "gap_s", "sample_rate_hz", "taper")
        for name in ("start_hz", "stop_hz", "duration_s", "sample_rate_hz"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be positive, got {value}")
        if not (np.isfinite(self.gap_s) and self.gap_s >= 0):
            raise ValueError(f"gap_s must not be negative, got {self.gap_s}")
        for name in ("duration_s", "gap_s"):
            if getattr(self, name) > LONGEST_S:
                raise ValueError(f"{name} must be at most {LONGEST_S:g} s, got {getattr(self, name):g} s")
        if self.sample_rate_hz > HIGHEST_RATE_HZ:
            raise ValueError(f"sample_rate_hz must be at most {HIGHEST_RATE_HZ:g} Hz, got {self.sample_rate_hz:g} Hz")
        if self.start_hz == self.stop_hz:
            raise ValueError(f"start_hz and stop_hz must differ, got {self.start_hz} for both")
        if min(self.start_hz, self.stop_hz) < LOWEST_HZ:
            raise ValueError(
                f"start_hz and stop_hz must be in Hz, {LOWEST_HZ:.0f} or more, got {self.start_hz} and {self.stop_hz}"
            )
        top = max(self.start_hz, self.stop_hz)
        if top >= self.sample_rate_hz / 2:
            raise ValueError(
                f"the band must end below half the sample rate, got {top} Hz at {self.sample_rate_hz} Hz: "
                f"take more than {2.0 * top:g} samples a second"
            )
        if round(self.duration_s * self.sample_rate_hz) < 2:  # the window's first sample is 0
            raise ValueError(f"duration_s must be two samples or more, got {self.duration_s} s")
        if not LEAST_TAPER <= self.taper <= 1.0:
            raise ValueError(f"taper must be a share of the beep, {LEAST_TAPER} to 1, got {self.taper}")
        if abs(self.period_s * self.sample_rate_hz - self.period_samples) > 1e-6:
            raise ValueError(f"duration_s + gap_s must be a whole number of samples, got {self.period_s} s")

    @property
    def period_s(self) -> float:
        """From the start of one beep to the start of the next, s."""
        return self.duration_s + self.gap_s

    @property
    def period_samples(self) -> int:
        """Samples from the start of one beep to the start of the next."""
        return round(self.period_s * self.sample_rate_hz)

    def beeps_in(self, duration_s: float) -> int:
        """Whole periods within a duration, which rounding does not make one fewer.

        Raises:
            ValueError: a duration that is negative or not finite.

        >>> BeepDesign().beeps_in(0.27)
        3
        """
        duration_s = as_number("duration_s", duration_s)
        if not 0.0 <= duration_s < math.inf:
            raise ValueError(f"duration_s must be finite and not negative, got {duration_s}")
        return math.floor(duration_s / self.period_s + 1e-9)

    @property
    def center_hz(self) -> float:
        """Middle of the band."""
        return 0.5 * (self.start_hz + self.stop_hz)

    @property
    def chirp_rate_hz_s(self) -> float:
        """Slope of the instantaneous frequency, Hz/s; 100 kHz/s for the paper's beep."""
        return (self.stop_hz - self.start_hz) / self.duration_s

    @property
    def range_doppler_s(self) -> float:
        """How far ahead in time a moving range reads: center_hz / chirp_rate_hz_s (0.205 s for 18-23 kHz)."""
        return self.center_hz / self.chirp_rate_hz_s

    def window(self, time_s: ArrayLike) -> Floats:
        """Hann window, or Tukey's, at times after the start of the beep; exactly zero outside it.

        Raises:
            ValueError: times that are not numbers.
        """
        t = as_floats("time_s", time_s)
        if np.isnan(t).any():
            raise ValueError("time_s must be numbers, got NaN")
        to_end = np.minimum(t, self.duration_s - t)
        risen = np.minimum(np.maximum(to_end, 0.0) / (self.taper * self.duration_s), 0.5)
        return np.sin(np.pi * risen) ** 2

    def phase_rad(self, time_s: ArrayLike) -> Floats:
        """Phase of the chirp, 2 pi (f0 t + k t^2 / 2), rad.

        Raises:
            ValueError: times that are not finite numbers.
        """
        t = as_finite("time_s", time_s)
        return 2.0 * np.pi * (self.start_hz + 0.5 * self.chirp_rate_hz_s * t) * t

    def waveform(self, time_s: ArrayLike) -> Floats:
        """The beep at any times, s, peak 1; zero outside it, also at infinity.

        Raises:
            ValueError: times that are not numbers.
        """
        t = as_floats("time_s", time_s)
        return self.window(t) * np.cos(self.phase_rad(np.where(np.isinf(t), 0.0, t)))

    def samples(self) -> Floats:
        """(n,) the beep sampled at `sample_rate_hz`; 9600 samples for the paper's beep."""
        return self.waveform(self._sample_times_s())

    def replica(self) -> Floats:
        """(n,) what a receiver correlates with, so that an echo is compressed to a Hann chirp's pulse.

        Under the Hann window that is the beep. A Tukey window's own pulse has sidelobes 13 dB down; where the echo's
        window times the replica's is Hann's squared, they are 47 dB down as ever.
        """
        time = self._sample_times_s()
        hann, own = np.sin(np.pi * time / self.duration_s) ** 2, self.window(time)
        return hann * np.divide(hann, own, out=np.zeros_like(own), where=own > 0.0) * np.cos(self.phase_rad(time))

    def _sample_times_s(self) -> Floats:
        return np.arange(round(self.duration_s * self.sample_rate_hz)) / self.sample_rate_hz
