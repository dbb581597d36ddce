"""A slice of the spectrum against numpy's whole one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obstaclewatch.signal.band_spectrum import PHASES, BandSpectrum


@settings(max_examples=60, deadline=None)
@given(slow=st.integers(1, 300), edges=st.tuples(st.floats(0, 1), st.floats(0, 1)), seed=st.integers(0, 999))
def test_equals_the_slice_of_the_whole(slow, edges, seed):
    length = PHASES * slow
    low, high = sorted(round(edge * (length // 2)) for edge in edges)
    samples = np.random.default_rng(seed).standard_normal((3, length))
    expected = np.fft.rfft(samples, axis=1)[:, low : high + 1]
    assert np.allclose(BandSpectrum(length, low, high + 1)(samples), expected, rtol=0.0, atol=1e-12 * length)


def test_shorter_blocks_are_padded_and_single_precision_stays():
    samples = np.random.default_rng(0).standard_normal((2, 3969))
    length = BandSpectrum.fast_length(3969)
    assert length == 4000
    band = BandSpectrum(length, 1600, 2001)
    expected = np.fft.rfft(samples, length, axis=1)[:, 1600:2001]
    single = band(samples.astype(np.float32))
    assert single.dtype == np.complex64
    assert np.allclose(band(samples), expected, rtol=0.0, atol=1e-10)
    assert np.abs(single - expected).max() < 1e-6 * np.abs(expected).max() * 10.0


@pytest.mark.parametrize(("length", "low", "high"), [(100, 0, 2), (80, 5, 5), (80, 0, 42), (80, -1, 3)])
def test_what_cannot_be_is_refused(length, low, high):
    with pytest.raises(ValueError, match=rf"got {length}|got {low} and {high}"):
        BandSpectrum(length, low, high)
