"""Claims: exact bounds on the walks that each of them means, never green on a point estimate."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from benchmarks.gates.claims import judge_claims
from benchmarks.gates.quantities import per_walk, walk_tables
from benchmarks.gates.verdict import State
from benchmarks.runs.results import RunData
from benchmarks.scoring.statistics import lower_bound, needed_of, upper_quantile_bound
from tests.benchmarks.gated_runs import DETECTOR, good_run, run_of
from tests.benchmarks.gates.verdicts import claim
from tests.benchmarks.synthetic_run import walk


def test_a_point_estimate_equal_to_the_claim_does_not_pass(tmp_path):
    run = good_run(tmp_path)  # 36 of 40 in time
    (verdict,) = judge_claims(run, claim(rate="TP", at_least=0.9))
    assert verdict.state is State.FAILED
    assert "36 of 40 (90.0 %)" in verdict.message
    assert "40 of 40 needed" in verdict.message
    bound = stats.beta.ppf(0.05, 36, 5)  # Clopper and Pearson's closed form
    assert judge_claims(run, claim(rate="TP", at_least=bound - 1e-6))[0].state is State.PASSED
    assert judge_claims(run, claim(rate="TP", at_least=bound + 1e-6))[0].state is State.FAILED


def test_claims_look_at_their_own_walks_and_split(tmp_path):
    run = good_run(tmp_path)
    for verdict, n in (
        (judge_claims(run, claim(rate="TN", at_least=0.5, scene="supermarket"))[0], 40),
        (judge_claims(run, claim(rate="TN", at_least=0.5, scene="campus"))[0], 0),
    ):
        assert verdict.n == n
        assert verdict.state is (State.PASSED if n else State.UNMEASURED)
    dev = RunData(run.folder, run.manifest | {"split": "dev"}, run.cells)
    (verdict,) = judge_claims(dev, claim(rate="TN", at_least=0.5))
    assert verdict.state is State.UNMEASURED
    assert "claimed on split test, the run is dev" in verdict.message


def test_a_median_is_claimed_by_its_bound(tmp_path):
    run = good_run(tmp_path)
    values = np.sort(list(per_walk(walk_tables(run, DETECTOR, "approach"), "range_error").values()))
    (verdict,) = judge_claims(run, claim(quantity="range_error", at_most=float(np.median(values))))
    assert verdict.state is State.FAILED
    (verdict,) = judge_claims(run, claim(quantity="range_error", at_most=float(values[47])))
    assert verdict.state is State.PASSED
    (verdict,) = judge_claims(run, claim(quantity="range_error", kind="standing", standing_range_m=3.0, at_most=1.0))
    assert verdict.state is State.UNMEASURED


@pytest.mark.parametrize("n", [1, 5, 40, 300])
@pytest.mark.parametrize("share", [0.5, 0.9, 0.946])
def test_the_count_needed_is_the_least(n, share):
    needed = needed_of(n, share)
    reach = [k for k in range(n + 1) if lower_bound(k, n) >= share]
    assert needed == (reach[0] if reach else None)


def test_an_upper_bound_of_a_median_covers_it_19_times_in_20():
    rng = np.random.default_rng(4)
    covered = [upper_quantile_bound(rng.exponential(size=25), 0.5) >= np.log(2.0) for _ in range(2000)]
    exact = stats.binom.cdf(stats.binom.ppf(0.95, 25, 0.5), 25, 0.5)
    assert exact >= 0.95
    assert np.mean(covered) == pytest.approx(exact, abs=0.015)
    assert np.isnan(upper_quantile_bound([1.0, 2.0], 0.5))


def test_claims_count_a_walk_of_a_sweep_once(tmp_path):
    """Cause: one walk at 60 points of a sweep counted as 60 walks."""
    cells = list(good_run(tmp_path).cells)
    swept = [{**cell, "cell": cell["cell"] | {"variant": {"name": name}}} for name in ("one", "two") for cell in cells]
    assert judge_claims(run_of(tmp_path, swept), claim(rate="TP", at_least=0.5))[0].n == 40


def test_a_claim_at_a_swept_threshold_asks_for_walks_that_bound_the_threshold(tmp_path):
    """Cause: the threshold was taken as given, so that one claim in six that is not so passed, of one in twenty."""
    for walks, state in ((80, State.FAILED), (400, State.PASSED)):
        cells = [walk(index=k, collides=k % 2 == 0, probability=((0.9, 0.2)[k % 2],)) for k in range(walks)]
        (verdict,) = judge_claims(run_of(tmp_path, cells), claim(rate="TP", at_tnr=0.97, at_least=0.9))
        assert verdict.state is state
        assert f"with a threshold known from {walks // 2} other walks" in verdict.message
