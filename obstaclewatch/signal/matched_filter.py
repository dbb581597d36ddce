"""Pulse compression: a beep's worth of samples in, the complex envelope over delay out (paper section 3.4, Eq. 1).

The band of the beep is cropped in the frequency domain, correlated with the beep once, and brought back as a complex
envelope at a low rate. Cropping, band-pass and decimation are one slice of the spectrum, and only that is computed
(`band_spectrum`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from obstaclewatch.beep import BeepDesign
from obstaclewatch.signal.band_spectrum import BandSpectrum
from obstaclewatch.support.argument_types import as_number, as_numbers, as_reals, check_counts, check_types
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled

BAND_MARGIN = 0.1
"""Share of the bandwidth kept on either side: Doppler at 3 m/s moves 23 kHz by 400 Hz."""


@dataclass(frozen=True)
class EchoProfile:
    """Compressed echoes over delay: an echo of amplitude g leaves a peak of height |g|.

    Attributes:
        envelope: (2, M) complex; times exp(2j pi reference_hz delay) it is the analytic signal of the correlation.
        start_s: delay of the first sample, relative to the first sample of the block.
        rate_hz: samples per second of delay.
        reference_hz: frequency that was moved to zero.
        circular: (2, count) over the full period: `envelope` is its first part, and its end lies before its start.

    >>> import numpy as np
    >>> profile = EchoProfile(np.array([[0.0, 0.5j, 0.0]]), start_s=0.0, rate_hz=24_000.0, reference_hz=20_500.0)
    >>> profile.magnitude[0].tolist(), profile.position(4e-5)
    ([0.0, 0.5, 0.0], 1)
    """

    envelope: Complexes
    start_s: float
    rate_hz: float
    reference_hz: float
    circular: Complexes = field(default_factory=lambda: np.empty((2, 0), dtype=np.complex128), repr=False)

    @cached_property
    def magnitude(self) -> Floats:
        """(2, M) upper envelope of the correlation."""
        return np.abs(self.envelope)

    @property
    def delay_s(self) -> Floats:
        """(M,) delay of every sample."""
        return self.start_s + np.arange(self.envelope.shape[1]) / self.rate_hz

    def position(self, delay_s: float) -> int:
        """Index of the sample nearest to a delay, kept within the profile."""
        return int(nearest_sample.py_func(delay_s, self.start_s, self.rate_hz, self.envelope.shape[1]))


@compiled
def nearest_sample(delay_s: float, start_s: float, rate_hz: float, count: int) -> int:
    """`EchoProfile.position` in a profile of that start, rate and number of samples."""
    return min(max(round((delay_s - start_s) * rate_hz), 0), count - 1)


class MatchedFilter:
    """Correlates two-channel blocks with a beep; all spectra are computed once.

    Args:
        beep: the emitted signal.
        reach_s: greatest delay of interest.
        lead_s: delays before the block's first sample that are kept, for an early or misaligned direct sound.
        block_samples: length of a block; None is one beep period. The correlation is circular over the block.
            With one period that is harmless: delays up to the gap do not wrap but for the last fading millisecond.
        rate_hz: least rate of the envelope; 24 kHz puts 9 samples across the -3 dB width of the paper's pulse.
        reverse: correlate with the time-reversed beep, Eq. 1 as printed.

    Raises:
        ValueError: no BeepDesign, a delay that is negative or not finite, a rate that is not positive and finite, or a
            block that is shorter than the beep or no whole number of samples.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign
    >>> beep = BeepDesign()
    >>> time_s = np.arange(beep.period_samples) / beep.sample_rate_hz
    >>> profile = MatchedFilter(beep, reach_s=0.03).compress(0.5 * beep.waveform(time_s - 0.01)[None])
    >>> print(f"{profile.magnitude.max():.2f} at {1e3 * profile.delay_s[profile.magnitude[0].argmax()]:.2f} ms")
    0.50 at 10.00 ms
    """

    def __init__(
        self,
        beep: BeepDesign,
        reach_s: float,
        lead_s: float = 2e-3,
        block_samples: int | None = None,
        rate_hz: float = 24_000.0,
        reverse: bool = False,
    ) -> None:
        check_types(beep=(beep, BeepDesign), reverse=(reverse, bool))
        self.beep = beep
        self.block_samples = beep.period_samples if block_samples is None else block_samples
        reach_s, lead_s, rate_hz = as_numbers(reach_s=reach_s, lead_s=lead_s, rate_hz=rate_hz)
        self._check_arguments(reach_s, lead_s, rate_hz)
        self._length = BandSpectrum.fast_length(self.block_samples)
        bin_hz = beep.sample_rate_hz / self._length
        low, high = _band_bins(beep, bin_hz, self._length // 2)
        self._band = BandSpectrum(self._length, low, high)
        self._count = fft.next_fast_len(max(int(np.ceil(rate_hz / bin_hz)), high - low))
        center = round(beep.center_hz / bin_hz)
        self._below = center - low
        self._slots = (np.arange(low, high) - center) % self._count
        self._offset_hz = (np.arange(low, high) - center) * bin_hz
        self.rate_hz = self._count * bin_hz
        self.reference_hz = center * bin_hz
        self._lead = round(lead_s * self.rate_hz)
        self.start_s = -self._lead / self.rate_hz
        self._kept = min(self._lead + int(np.ceil(reach_s * self.rate_hz)) + 1, self._count)
        self._replica = self._conjugate_replica(reverse)

    def compress(self, block: ArrayLike, earlier_s: float = 0.0) -> EchoProfile:
        """Correlate a (C, block_samples) block with the beep.

        Args:
            block: samples.
            earlier_s: by how much everything is moved to smaller delays, by any part of a sample.

        Raises:
            ValueError: a block of another shape, samples that are not finite real numbers, or a move that is not one.
        """
        block = self._checked(block)
        earlier_s = as_number("earlier_s", earlier_s)
        if not abs(earlier_s) < np.inf:
            raise ValueError(f"earlier_s must be finite, got {earlier_s}")
        replica = self._replica
        if earlier_s != 0.0:
            replica = replica * np.exp(2j * np.pi * earlier_s * (self.reference_hz + self._offset_hz))
        circular = self._envelope(block, replica)
        envelope = np.ascontiguousarray(circular[:, : self._kept])
        return EchoProfile(envelope, self.start_s, self.rate_hz, self.reference_hz, circular)

    def band_signal(self, block: ArrayLike) -> Complexes:
        """(C, M) complex baseband of the block in the beep's band, at `rate_hz`, from the block's first sample on."""
        block = self._checked(block)
        return self._envelope(block, np.full(len(self._slots), 2.0 / self._length, dtype=np.complex128))

    def _envelope(self, block: NDArray[np.floating], weight: Complexes) -> Complexes:
        """(C, count) envelope of the weighted band: its middle goes to zero frequency, its lower half behind it."""
        spectrum, is_finite = _about_zero(self._band(block), weight, self._below, self._count)
        if not is_finite:  # any sample that is not finite reaches all bins
            bad = int((~np.isfinite(block)).sum())
            raise ValueError(f"a block must be finite and not overflow, got {bad} NaN or infinite samples")
        return fft.ifft(spectrum, norm="forward", overwrite_x=True)

    def _conjugate_replica(self, reverse: bool) -> Complexes:
        """Conjugate spectrum of the replica, scaled to unit gain, delayed so that the output starts `lead_s` early."""
        replica, beep = self.beep.replica(), self.beep.samples()
        bins, emitted = (self._band((x[::-1] if reverse else x)[None])[0] for x in (replica, beep))
        shift = -2j * np.pi * self._slots * self._lead / self._count
        return bins.conj() * np.exp(shift) / np.sum(bins.conj() * emitted).real

    def _check_arguments(self, reach_s: float, lead_s: float, rate_hz: float) -> None:
        for name, delay_s in (("reach_s", reach_s), ("lead_s", lead_s)):
            if not 0.0 <= delay_s < np.inf:
                raise ValueError(f"{name} must be finite and not negative, got {delay_s}")
        if not 0.0 < rate_hz < np.inf:
            raise ValueError(f"rate_hz must be positive and finite, got {rate_hz}")
        # the beep's own length: a shorter block does not hold it
        check_counts(round(self.beep.duration_s * self.beep.sample_rate_hz), block_samples=self.block_samples)

    def _checked(self, block: ArrayLike) -> NDArray[Any]:
        samples = as_reals("a block", block)
        if samples.ndim != 2 or len(samples) == 0 or samples.shape[1] != self.block_samples:
            raise ValueError(f"a block must have shape (channels, {self.block_samples}), got {samples.shape}")
        return samples


@compiled
def _about_zero(band: NDArray[np.complexfloating], weight: Complexes, below: int, count: int) -> tuple[Complexes, bool]:
    """(C, count) spectrum of bins (C, B) times weights (B,), the first `below` behind; whether all are finite."""
    spectrum, is_finite = np.zeros((len(band), count), dtype=np.complex128), True
    for channel in range(len(band)):
        for wanted in range(len(weight)):
            value = band[channel, wanted]
            is_finite &= np.isfinite(value.real) and np.isfinite(value.imag)
            slot = wanted - below if wanted >= below else wanted - below + count
            spectrum[channel, slot] = value * weight[wanted]
    return spectrum, is_finite


def _band_bins(beep: BeepDesign, bin_hz: float, last: int) -> tuple[int, int]:
    """First and one-past-last bin of the beep's band with its margin."""
    low, high = sorted((beep.start_hz, beep.stop_hz))
    margin = BAND_MARGIN * (high - low)
    return max(int((low - margin) / bin_hz), 1), min(int((high + margin) / bin_hz) + 1, last)
