"""Intervals and quantiles against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom, multinomial, norm, t

from benchmarks.scoring.operating_points import operating_point
from benchmarks.scoring.paired import change_of
from benchmarks.scoring.statistics import (
    exact_rate,
    expanded_confidence,
    lower_bound,
    mcnemar,
    needed_of,
    paired_interval,
    quantile_with_interval,
    share_of_clusters,
)


@given(n=st.integers(1, 2000), share=st.floats(0.0, 1.0))
@settings(max_examples=60)
def test_exact_ends_leave_two_and_a_half_percent_outside(n: int, share: float) -> None:
    """Clopper and Pearson: at the low end k or more, at the high end k or fewer have a chance of 2.5 %."""
    k = round(share * n)
    found = exact_rate(k, n)
    assert found.value == k / n
    assert found.low == 0.0 if k == 0 else binom.sf(k - 1, n, found.low) == pytest.approx(0.025, rel=1e-6)
    assert found.high == 1.0 if k == n else binom.cdf(k, n, found.high) == pytest.approx(0.025, rel=1e-6)


def test_nothing_tried_is_no_data_not_zero() -> None:
    nothing = exact_rate(0, 0)
    assert np.isnan([nothing.value, nothing.low, nothing.high]).all()
    assert str(nothing) == "no data"
    assert np.isnan(lower_bound(0, 0))


@pytest.mark.parametrize(("k", "n"), [(-1, 3), (4, 3)])
def test_impossible_counts_are_refused(k: int, n: int) -> None:
    with pytest.raises(ValueError, match=rf"k must lie within 0\.\.n, got {k} of {n}"):
        exact_rate(k, n)


@pytest.mark.parametrize("n", [1, 20, 300])
def test_exact_lower_bound_without_a_failure_is_the_nth_root(n: int) -> None:
    assert lower_bound(n, n) == pytest.approx(0.05 ** (1 / n), abs=1e-9)


def test_mcnemar_is_the_two_sided_binomial() -> None:
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(5, 5) == pytest.approx(1.0)
    assert mcnemar(0, 8) == pytest.approx(2 * 0.5**8)
    assert mcnemar(8, 0) == mcnemar(0, 8)


def test_median_and_its_interval_cover_the_true_median() -> None:
    values = np.random.default_rng(1).normal(3.0, 1.0, 801)
    median, low, high, count = quantile_with_interval(values, 0.5)
    assert count == 801
    assert median == np.sort(values)[400]
    assert low < 3.0 < high
    half_width = 1.96 * 1.2533 / np.sqrt(801)  # of a normal sample's median; the bootstrap is within a third of it
    assert (high - low) / 2 == pytest.approx(half_width, rel=0.35)


def test_repeating_each_walk_s_value_narrows_nothing() -> None:
    values = np.random.default_rng(2).normal(size=60)
    alone = quantile_with_interval(values, 0.5, np.arange(60))
    repeated = quantile_with_interval(np.repeat(values, 25), 0.5, np.repeat(np.arange(60), 25))
    assert repeated[:3] == pytest.approx(alone[:3])
    assert repeated[3] == 1500


def test_missing_estimates_are_left_out_and_order_does_not_matter() -> None:
    values = np.array([5.0, np.nan, 1.0, 3.0, np.nan, 2.0, 4.0, 6.0])
    walks = np.array(["a", "a", "b", "c", "d", "e", "f", "g"])
    found = quantile_with_interval(values, 0.5, walks)
    assert found[0] == 3.5
    assert found[3] == 6
    assert np.isfinite(found[1:3]).all()
    assert quantile_with_interval(values[::-1], 0.5, walks[::-1]) == found


def test_no_estimate_at_all_is_nan() -> None:
    value, low, high, count = quantile_with_interval([np.nan, np.nan], 0.5, ["one", "two"])
    assert np.isnan([value, low, high]).all()
    assert count == 0


def test_an_interval_holds_its_median_also_for_one_walk() -> None:
    value, low, high, _ = quantile_with_interval([2.0, 4.0], 0.5, ["one", "one"])
    assert np.isnan([low, high]).all() or low <= value <= high


@pytest.mark.parametrize(("q", "enough"), [(0.5, 6), (0.8, 14), (0.9, 29)])
def test_few_walks_have_no_interval_of_a_quantile(q: float, enough: int) -> None:
    """Cause: the greatest of 6 walks lies below P90 half of the time: 95 % intervals held it 73 times in 100."""
    for walks, has_one in ((enough - 1, False), (enough, True)):
        found = quantile_with_interval(np.random.default_rng(3).normal(size=4 * walks), q, np.repeat(range(walks), 4))
        assert np.isfinite(found[1:3]).all() == has_one
        assert np.isfinite(found[0])


@pytest.mark.parametrize(("walks", "q", "times"), [(8, 0.5, 272), (15, 0.5, 281), (15, 0.8, 275)])
def test_intervals_of_few_walks_hold_what_is_true(walks: int, q: float, times: int) -> None:
    """Cause: percentiles alone held these 261, 278 and 270 times in 300: resamples of few walks spread too little."""
    rng, held = np.random.default_rng(4), 0
    for _ in range(300):
        owner = np.repeat(np.arange(walks), rng.integers(1, 20, walks))
        values = np.sqrt(0.5) * (rng.standard_normal(walks)[owner] + rng.standard_normal(len(owner)))
        _, low, high, _ = quantile_with_interval(np.exp(values), q, owner)
        held += low <= np.exp(norm.ppf(q)) <= high
    assert held >= times


@pytest.mark.parametrize("n", [2, 5, 20, 500])
def test_of_a_mean_the_expanded_percentiles_are_student_s_interval(n: int) -> None:
    """The resamples' deviation is sqrt((n - 1) / n) times that of the mean; of 2 values nothing is left out."""
    ends = norm.ppf(0.5 * (1.0 + expanded_confidence(0.9, n))) * np.sqrt((n - 1) / n)
    assert ends == pytest.approx(t.ppf(0.95, n - 1), rel=1e-6) or expanded_confidence(0.9, n) == 1.0
    assert expanded_confidence(0.9, n) > 0.9


@pytest.mark.parametrize(("walks", "share"), [(30, 0.5), (100, 0.9), (100, 0.99)])
def test_a_share_of_beeps_is_as_sure_as_its_walks(walks: int, share: float) -> None:
    """Cause: beeps of a walk, of one outcome, counted as trials: 95 % intervals held the share 4 times in 10."""
    rng, held = np.random.default_rng(6), 0
    for _ in range(200):
        owner = np.repeat(np.arange(walks), rng.integers(1, 20, walks))
        _, low, high = share_of_clusters((rng.random(walks) < share)[owner], owner)
        held += low <= share <= high
    assert held >= 0.92 * 200


def test_a_share_of_walks_has_the_exact_interval() -> None:
    for k in range(10):
        exact = exact_rate(k, 9)
        assert share_of_clusters(np.arange(9) < k, np.arange(9)) == pytest.approx((exact.value, exact.low, exact.high))


@given(gained=st.integers(0, 40), lost=st.integers(0, 40), same=st.integers(1, 200))
@settings(max_examples=100)
def test_a_paired_interval_leaves_zero_out_where_mcnemar_says_so(gained: int, lost: int, same: int) -> None:
    n = gained + lost + same
    low, high = paired_interval(gained, lost, n)
    assert low <= (gained - lost) / n <= high
    assert (low > 0.0 or high < 0.0) == (mcnemar(gained, lost) < 0.05)
    mirrored = paired_interval(lost, gained, n)
    np.testing.assert_allclose([low, high], [-mirrored[1], -mirrored[0]], atol=1e-12)


def test_paired_intervals_at_their_ends() -> None:
    """With one walk all is open; with none of 50 that differs, d is below 1 - 0.025 ** (1 / 50)."""
    assert paired_interval(0, 0, 1) == pytest.approx((-0.975, 0.975))
    np.testing.assert_allclose(paired_interval(0, 0, 50), [-(1 - 0.025**0.02), 1 - 0.025**0.02], atol=1e-12)
    all_gained = paired_interval(20, 0, 20)
    assert all_gained == pytest.approx(((2 * 0.025**0.05 - 1) * 0.025**0.05, 1.0))
    assert np.isnan(paired_interval(0, 0, 0)).all()
    with pytest.raises(ValueError, match="got 3, 4 and 6"):
        paired_interval(3, 4, 6)


@pytest.mark.parametrize("shares", [(0.01, 0.01), (0.1, 0.02), (0.3, 0.0), (0.25, 0.2)])
def test_paired_intervals_cover_the_difference(shares: tuple[float, float]) -> None:
    """Over all outcomes of 15 walks, weighted by their probability."""
    covered = 0.0
    for gained in range(16):
        for lost in range(16 - gained):
            low, high = paired_interval(gained, lost, 15)
            if low <= shares[0] - shares[1] <= high:
                covered += multinomial.pmf([gained, lost, 15 - gained - lost], 15, [*shares, 1.0 - sum(shares)])
    assert covered >= 0.95


def test_ends_of_what_can_be_asked() -> None:
    """The least k of a claim of 0 was 1; no walks divided by zero; NaN and too great a rate came through or not."""
    assert needed_of(30, 0.0) == 0
    assert needed_of(30, 1e-9) == 1
    assert np.isnan(change_of({}, {}).loss_points)
    with pytest.raises(ValueError, match=r"k must lie within 0..n, got 5 of 0"):
        lower_bound(5, 0)
    with pytest.raises(ValueError, match="hits must be truth values, one for each of 2 clusters"):
        share_of_clusters([np.nan, 1.0], [1, 2])
    with pytest.raises(ValueError, match="hits must be truth values, one for each of 2 clusters"):
        share_of_clusters([True] * 3, [1, 2])
    with pytest.raises(ValueError, match=r"true_negative_rate must be above 0 and at most 1, got 1\.5"):
        operating_point(np.ones(5), np.ones(5), 1.5)
