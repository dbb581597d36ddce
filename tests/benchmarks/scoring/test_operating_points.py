"""Swept thresholds, by counting, and the scores that they are swept over."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from benchmarks.scoring.operating_points import det_curve, operating_point, true_positive_bounds
from benchmarks.scoring.scores import approach_table, swept
from tests.benchmarks.synthetic_run import made_up_run, walk

SCORES = st.lists(st.sampled_from([0.0, 0.1, 0.25, 0.5, 0.9, 1.0]), min_size=1, max_size=12)


@given(hits=SCORES, misses=SCORES, tnr=st.sampled_from([0.5, 0.9, 0.95, 0.97, 1.0]))
@settings(max_examples=100)
def test_no_threshold_finds_more_collisions_with_as_many_quiet(hits, misses, tnr):
    """Every threshold tried in turn: alerts are scores above it."""
    point = operating_point(np.array(hits), np.array(misses), tnr)
    assert point is not None
    allowed = [t for t in [-1.0, *misses, *hits] if sum(m <= t for m in misses) >= tnr * len(misses) - 1e-9]
    assert point.true_positive.k == max(sum(h > t for h in hits) for t in allowed)
    assert point.true_negative.k == sum(m <= point.threshold for m in misses) >= tnr * len(misses) - 1e-9
    false, missed = det_curve(np.array(hits), np.array(misses))
    corners = list(zip(false, missed, strict=True))
    assert (1 - point.true_negative.value, 1 - point.true_positive.value) in [pytest.approx(c) for c in corners]
    assert (false[0], missed[0], false[-1], missed[-1]) == (0.0, 1.0, 1.0, 0.0)


def test_a_collision_counts_what_was_stated_with_so_much_left_another_walk_all(tmp_path):
    """Gating misses by another distance than hits would tell them apart by the gate."""
    cells = [walk(index=0, probability=(0.1, 0.4, 0.8)), walk(index=1, collides=False, probability=(0.2, 0.3, 0.6))]
    table = approach_table(made_up_run(tmp_path, cells), "PaperDetector")
    assert [table[f"score_{left}m"].tolist() for left in ("1", "0.5", "0")] == [[0.1, 0.6], [0.4, 0.6], [0.8, 0.6]]
    found = {left_m: swept(table, left_m, 0.95) for left_m in (1.0, 0.5, 0.0)}
    assert [point.true_positive.k for point in found.values() if point] == [0, 0, 1]


def test_a_detector_that_states_nothing_has_no_threshold(tmp_path):
    table = approach_table(made_up_run(tmp_path), "PaperDetector")
    assert np.isnan(table["score_0m"]).all()
    assert swept(table, 0.0, 0.9) is None


@pytest.mark.parametrize(("hits", "misses", "tnr", "true"), [(57, 60, 0.97, 0.9), (120, 120, 0.95, 0.68)])
def test_the_interval_holds_the_rate_at_the_threshold_of_all_walks(hits, misses, tnr, true):
    """Cause: the interval took the threshold chosen on these walks as given, and held it 75 and 72 times in 100."""
    rng, apart = np.random.default_rng(5), stats.norm.ppf(tnr) + stats.norm.ppf(true)
    found = [operating_point(rng.normal(apart, size=hits), rng.normal(size=misses), tnr) for _ in range(200)]
    held = [point.true_positive.low <= true <= point.true_positive.high for point in found if point]
    assert np.mean(held) >= 0.95


def test_few_other_walks_bound_no_threshold():
    """60 walks all lie below the 97 % quantile one time in six."""
    hits, misses = np.linspace(2.0, 3.0, 57), np.linspace(0.0, 1.0, 60)
    assert true_positive_bounds(hits, misses, 0.97, 0.95)[0] == 0.0
    assert true_positive_bounds(hits, misses, 0.9, 0.95)[0] == pytest.approx(0.025 ** (1 / 57))
    assert true_positive_bounds(hits, np.tile(misses, 4), 0.97, 0.95)[0] == pytest.approx(0.025 ** (1 / 57))
