"""Beeps that another clock plays, or from which samples are missing, in a coherent mean."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.signal.clock_slip import LEAST_SLIP_RAD, ClockSlip
from obstaclewatch.signal.direct_sound import direct_sound
from obstaclewatch.signal.matched_filter import MatchedFilter
from tests.obstaclewatch.synthetic import BEEP

FILTER = MatchedFilter(BEEP, reach_s=0.03)
TIME_S = np.arange(BEEP.period_samples) / BEEP.sample_rate_hz
CYCLE_S = 1.0 / FILTER.reference_hz


def _block(later_s):
    """(2, n) direct sound and an echo 80 dB below it, all of it so much later than in the first beep."""
    echo = 1e-4 * BEEP.waveform(TIME_S - 0.02 - later_s)
    return np.stack([BEEP.waveform(TIME_S - direct_s - later_s) + echo for direct_s in (0.3e-3, 0.7e-3)])


def _held(slip, later_s):
    block = _block(later_s)
    profile = FILTER.compress(block)
    return profile, *slip.held(block, profile, direct_sound(profile))


@pytest.mark.parametrize("later_s", [1.8e-6, -5.2e-6, 0.49 * CYCLE_S, 0.51 * CYCLE_S, -3.7 * CYCLE_S, 0.8e-3, -0.9e-3])
def test_a_beep_that_comes_later_is_put_where_the_first_one_was(later_s):
    """To any part of a sample and over any number of cycles: what is left is 60 dB below the direct sound."""
    slip = ClockSlip(FILTER)
    first, kept, none = _held(slip, 0.0)
    assert kept is first
    assert none == 0.0
    profile, held, slip_s = _held(slip, later_s)
    assert slip_s == pytest.approx(later_s, abs=0.02e-6)
    left = np.abs(held.envelope - first.envelope)
    assert left.max() < 1e-3
    assert np.abs(profile.envelope - first.envelope).max() > 0.2


def test_a_beep_in_its_place_is_handed_back_as_it_is():
    """Bit for bit: what one clock plays and records is not touched."""
    slip = ClockSlip(FILTER)
    _held(slip, 0.0)
    for later_s in (
        0.0,
        0.9 * LEAST_SLIP_RAD / (2.0 * np.pi) * CYCLE_S,
        -0.9 * LEAST_SLIP_RAD / (2.0 * np.pi) * CYCLE_S,
    ):
        profile, held, slip_s = _held(slip, later_s)
        assert held is profile
        assert slip_s == 0.0


def test_what_was_forgotten_is_no_measure():
    slip = ClockSlip(FILTER)
    _held(slip, 0.0)
    slip.clear()
    profile, held, _ = _held(slip, 5e-6)
    assert held is profile
