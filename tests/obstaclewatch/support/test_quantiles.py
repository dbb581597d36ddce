"""Order statistics against sorting."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from obstaclewatch.support.quantiles import median, order_statistic


@given(arrays(np.float64, st.integers(1, 40), elements=st.floats(-1e6, 1e6)), st.data())
def test_it_is_that_of_the_sorted_numbers(values, data):
    rank = data.draw(st.integers(0, len(values) - 1))
    assert order_statistic(values, rank) == np.sort(values)[rank]
    assert median(values) == pytest.approx(np.median(values), rel=1e-12)


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e300])
def test_echoes_a_thousand_times_louder_are_no_matter(scale):
    rng = np.random.default_rng(6)
    values = scale * np.abs(rng.standard_normal(977)) * np.where(rng.random(977) < 0.02, 1e3, 1.0)
    found = [order_statistic(values, rank) for rank in range(977)]
    assert found == np.sort(values).tolist()


def test_numbers_that_are_all_the_same():
    assert order_statistic(np.zeros(8), 3) == 0.0
    assert order_statistic(np.repeat([1.0, 2.0], 5), 4) == 1.0
    assert order_statistic(np.repeat([1.0, 2.0], 5), 5) == 2.0
