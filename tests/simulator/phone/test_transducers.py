"""Transducers that cannot be are refused, with the value and the rule."""

from __future__ import annotations

import numpy as np
import pytest

from simulator import StructureBorne, Transducer


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"rear_loss_db": np.nan}, "rear_loss_db must be 0 to 300 dB, got nan"),
        ({"rear_loss_db": -3.0}, "rear_loss_db must be 0 to 300 dB, got -3.0"),
        ({"rear_loss_db": "6"}, "rear_loss_db must be a number, got '6'"),
        ({"response_hz": [20e3, 15e3]}, r"response_hz must be one or more frequencies that increase, got \[20000"),
        ({"response_hz": [15e3, 20e3, 25e3]}, r"one level per frequency, got shape \(2,\) for \(3,\)"),
        ({"response_db": [0.0, np.inf]}, r"response_db must be finite, got \[0.0, inf\]"),
        ({"axis": [0.0, 2.0, 0.0]}, r"axis must be a unit vector, got \[0.0, 2.0, 0.0\]"),
        ({"axis": [1.0, 0.0]}, r"axis must be a unit vector, got \[1.0, 0.0\]"),
    ],
)
def test_a_transducer_that_cannot_be_is_refused(settings, rule):
    """Nothing was checked: a loss of NaN took echoes away, and a table that decreases gave another level."""
    with pytest.raises(ValueError, match=rule):
        Transducer(**settings)


def test_tables_may_be_lists_and_are_copied():
    """Lists were kept as they are, and sound through the case could not index them."""
    level = np.array([0.0, -6.0])
    transducer = Transducer([15e3, 25e3], level, [0, 1, 0], 6)
    level[:] = 0.0
    np.testing.assert_allclose(transducer.response([15e3, 20e3]), [1.0, 10.0 ** (-3.0 / 20.0)])
    case = StructureBorne([1e-5, 9e-5], [50, 10])
    np.testing.assert_array_equal(case.gain[np.array([1, 0])], [10.0, 50.0])


@pytest.mark.parametrize(
    ("delay_s", "gain", "rule"),
    [
        (1e-5, [50.0, 10.0], "delay_s must be one number per microphone, got 1e-05"),
        ([1e-5, 9e-5], [50.0, np.nan], r"gain must be finite, got \[50.0, nan\]"),
        ([1e-5, 9e-5], [50.0, 1j], "gain must be numbers, got"),
    ],
)
def test_sound_through_the_case_is_two_finite_numbers(delay_s, gain, rule):
    """It was taken as it came and failed within `through_case`."""
    with pytest.raises(ValueError, match=rule):
        StructureBorne(delay_s, gain)
