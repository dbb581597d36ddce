"""Which candidate is the target."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.cells.association import associate, nearest_within

NAN = float("nan")


def test_nearest_range_within_the_gate_is_the_target() -> None:
    assert nearest_within([1.0, 2.9, 3.3], 3.0, 0.5) == 1
    assert nearest_within([1.0, 2.9, 3.3], 2.0, 0.5) is None
    assert nearest_within([], 2.0, 0.5) is None
    assert nearest_within([NAN, 2.2], 2.0, 0.5) == 1
    assert nearest_within([NAN], 2.0, 0.5) is None


@given(
    ranges=st.lists(st.floats(0.3, 7.0) | st.just(NAN), max_size=5),
    truth=st.floats(0.3, 7.0),
    gate=st.floats(0.01, 1.0),
)
@settings(max_examples=80)
def test_association_is_the_slow_search(ranges: list[float], truth: float, gate: float) -> None:
    inside = [abs(r - truth) for r in ranges if abs(r - truth) <= gate]
    found = nearest_within(ranges, truth, gate)
    assert (found is None) == (not inside)
    if found is not None:
        assert abs(ranges[found] - truth) == min(inside)


def detection(*ranges: float) -> SimpleNamespace:
    """Candidates whose other estimates are told apart by their place."""
    place = np.arange(len(ranges), dtype=float)
    return SimpleNamespace(
        range_m=np.array(ranges),
        range2_m=np.array(ranges) + 0.1,
        bearing_rad=place,
        radius_m=place + 10.0,
        snr_db=place,
        range_std_m=place,
        bearing_std_rad=place,
        flags=place,
    )


def test_all_estimates_of_a_beep_are_one_candidate_s() -> None:
    found = associate([detection(1.0, 2.05), detection(), detection(4.0)], np.array([2.0, 2.0, 2.0]), 0.5)
    assert found.found.tolist() == [True, False, False]
    assert found.candidates.tolist() == [2, 0, 1]
    assert (found.columns["range_m"][0], found.columns["range2_m"][0]) == pytest.approx((2.05, 2.15))
    assert [found.columns[name][0] for name in ("bearing_rad", "radius_m", "snr_db")] == [1.0, 11.0, 1.0]
    assert np.isnan(found.columns["bearing_rad"][1:]).all()


def test_truth_must_have_a_row_per_beep() -> None:
    with pytest.raises(ValueError, match="one value per detection, got 1 for 2"):
        associate([detection(), detection()], np.array([1.0]), 0.5)
