"""Noise of the air and of the microphones: white, independent between microphones."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Singles
from simulator.phone.phone import Phone

BAND_HZ = (18_000.0, 23_000.0)  # where `Phone.noise_spl_db` is counted
_SAMPLES_AT_ONCE = 1 << 16  # samples drawn at a time: what is made of the draws stays in the cache
_DRAWN_NUMBERS = np.float32(2.0**32)


def noise_density(phone: Phone) -> float:
    """One-sided power density of the noise, 1/Hz, relative to digital full scale.

    A sine at `full_scale_spl_db` has amplitude 1, hence power 1/2; the level is spread evenly over 18-23 kHz.
    """
    band_power = 0.5 * 10.0 ** ((phone.noise_spl_db - phone.full_scale_spl_db) / 10.0)
    return float(band_power / (BAND_HZ[1] - BAND_HZ[0]))


def noise_rms(phone: Phone, sample_rate_hz: float) -> float:
    """Standard deviation per sample of white noise of that density, relative to digital full scale.

    Raises:
        ValueError: a sample rate that is not positive.
    """
    if not (np.isfinite(sample_rate_hz) and sample_rate_hz > 0.0):
        raise ValueError(f"sample_rate_hz must be positive, got {sample_rate_hz}")
    return float(np.sqrt(noise_density(phone) * 0.5 * sample_rate_hz))


def noise_samples(phone: Phone, count: int, sample_rate_hz: float, rng: np.random.Generator) -> Singles:
    """(2, count) noise, relative to digital full scale; exact zeros for a silent phone.

    Drawn in the order of time: a longer recording with the same generator begins with the same noise.

    Raises:
        ValueError: a negative count, or a sample rate that is not positive.
    """
    if count < 0:
        raise ValueError(f"count must not be negative, got {count}")
    samples = np.zeros((2, count), dtype=np.float32)
    rms = noise_rms(phone, sample_rate_hz)
    if rms > 0.0:
        for start in range(0, count, _SAMPLES_AT_ONCE):
            _draw(samples[:, start : start + _SAMPLES_AT_ONCE], np.float32(rms), rng)
    return samples


def _draw(block: Singles, rms: np.float32, rng: np.random.Generator) -> None:
    """Fill in normal pairs by the method of Box and Muller (1958): a third of the time of `standard_normal`.

    The 64 random bits of a pair are its length, to 6.7 standard deviations, and its angle.
    """
    bits = rng.integers(0, 1 << 64, block.shape[1], dtype=np.uint64).view(np.uint32).reshape(-1, 2)
    length, angle = bits.T.astype(np.float32, order="C")
    np.log((length + np.float32(0.5)) / _DRAWN_NUMBERS, out=length)
    np.sqrt(np.float32(-2.0) * length, out=length)
    angle *= np.float32(2.0 * np.pi) / _DRAWN_NUMBERS
    np.cos(angle, out=block[0])
    np.sin(angle, out=block[1])
    block *= rms * length
