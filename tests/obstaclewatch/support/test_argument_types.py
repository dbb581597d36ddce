"""Arguments that are converted: one clear error in place of one from deep inside."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.support.argument_types import as_complexes, as_floats


@pytest.mark.parametrize("value", ["abc", "1.0", None, True, [1.0, None], [[1.0, 2.0], [3.0]], 1j, object()])
def test_what_is_no_array_of_numbers_is_refused_by_name(value):
    """numpy's own words came through, or a TypeError; 1j lost its imaginary part."""
    with pytest.raises(ValueError, match="place_m must be numbers, got "):
        as_floats("place_m", value)


def test_numbers_are_copied():
    given = np.array([1.0, 2.0])
    copied = as_floats("place_m", given)
    given[0] = 9.0
    np.testing.assert_array_equal(copied, [1.0, 2.0])
    assert as_floats("count", 3).dtype == np.float64
    assert as_complexes("gain", [1, 1j]).tolist() == [1.0 + 0.0j, 1j]
