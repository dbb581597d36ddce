"""From envelopes about 20 kHz to real samples at the recording's rate, through the microphones.

The Fourier transform takes its samples for a circle. The sum therefore runs on until the last echo has arrived, silence
follows, and only then is the recording cut out of it: what its end cuts off would otherwise come in at its start.
"""

from __future__ import annotations

import numpy as np
import scipy.fft

from obstaclewatch.beep import BeepDesign
from obstaclewatch.support.arrays import Complexes, Singles
from simulator.phone.phone import Phone
from simulator.rendering.interpolation import between
from simulator.waves.band import REFERENCE_HZ

ENVELOPE_RATE_HZ = 24_000.0  # the beep's spectrum 12 kHz off its centre is below 1e-8 of its energy
BINS = 6  # a circle of a multiple of so many samples at 24 kHz has a bin at 20 kHz
RING_S = 0.5  # before and after all sounds; further off a galaxy-s5's microphone rings with 2e-6, a flat one with 0


def envelope_rate(beep: BeepDesign) -> float:
    """The recording's rate over a whole number, 24 kHz or little more."""
    return beep.sample_rate_hz / (beep.sample_rate_hz // ENVELOPE_RATE_HZ)


def to_rate(envelope: Complexes, phone: Phone, beep: BeepDesign, count: int) -> Singles:
    """(2, count) real samples at the beep's rate from envelopes about 20 kHz, through the microphones' responses.

    The envelopes must hold all sounds to their ends, as `sum_envelopes` leaves them: what breaks off rings over all of
    the recording.
    """
    return ringing(envelope, phone, beep)[:, lead_samples(beep) :][:, :count]


def lead_samples(beep: BeepDesign) -> int:
    """Samples of `ringing` before the first of the envelopes."""
    return _factor(beep) * _lead(beep)


def _factor(beep: BeepDesign) -> int:
    """Samples of the recording for each of the envelopes."""
    return int(beep.sample_rate_hz // ENVELOPE_RATE_HZ)


def _lead(beep: BeepDesign) -> int:
    return round(RING_S * envelope_rate(beep))


def ringing(envelope: Complexes, phone: Phone, beep: BeepDesign) -> Singles:
    """(2, n) the same from `RING_S` before the envelopes to as long after them: microphones ring before and after.

    Their responses are applied at the envelopes' rate, and only then are the samples in between worked out.
    """
    rate = envelope_rate(beep)
    size = BINS * scipy.fft.next_fast_len(int(np.ceil((envelope.shape[1] + 2.0 * RING_S * rate) / BINS)))
    period = size / rate
    carrier = round(REFERENCE_HZ * period)  # the bin nearest to 20 kHz
    if carrier != REFERENCE_HZ * period:
        turn = REFERENCE_HZ / rate - carrier / size
        envelope = envelope * np.exp(2j * np.pi * turn * np.arange(envelope.shape[1]))
    bins = np.arange(size)
    bins += size * np.ceil((carrier - size // 2 - bins) / size).astype(np.int64)  # those within 12 kHz of 20 kHz
    inside = (bins > 0) & (bins < 0.5 * beep.sample_rate_hz * period)
    spectrum = np.roll(scipy.fft.fft(envelope, n=size, axis=1), carrier, axis=1)
    for mic, row in zip(phone.mics, spectrum, strict=True):
        row *= np.where(inside, mic.response(bins / period), 0.0)
    received = scipy.fft.ifft(spectrum, axis=1, overwrite_x=True)
    return between(np.roll(received, _lead(beep), axis=1), rate, _factor(beep))
