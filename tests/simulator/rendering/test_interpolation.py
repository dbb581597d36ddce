"""Samples between those of an analytic signal, against the signal itself."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.rendering.interpolation import between

COUNT = 2400


@pytest.mark.parametrize(("rate_hz", "factor"), [(24e3, 8), (25e3, 4), (24e3, 2), (44.1e3, 1)])
def test_tones_of_the_band_come_out_as_they_are(rate_hz, factor):
    # 15 to 25 kHz, and 2 kHz more for what closes in fast; the circle holds a whole number of turns
    turns = np.rint(np.linspace(13e3, 27e3, 57) * COUNT / rate_hz)[:, None]
    tones = np.exp(2j * np.pi * turns * np.arange(COUNT) / COUNT)
    exact = np.exp(2j * np.pi * turns * np.arange(factor * COUNT) / (factor * COUNT))
    for tone, wanted in zip(tones, exact, strict=True):
        found = between(np.stack([tone, -1j * tone]), rate_hz, factor)
        np.testing.assert_allclose(found, [wanted.real, wanted.imag], rtol=0.0, atol=6e-7)
