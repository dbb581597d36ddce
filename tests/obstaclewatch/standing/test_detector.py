"""A phone held still: beeps add up in phase, another pose starts anew, and what comes from behind is explained away."""

import numpy as np
import pytest

from obstaclewatch import PaperSettings, PaperStandingDetector, StandingDetector
from obstaclewatch.recording import Recording
from obstaclewatch.signal.beep_averaging import AveragedBeeps
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.standing.detector import OTHER_STD_M
from tests.obstaclewatch.synthetic import (
    BEEP,
    FULL_SCALE,
    PHONE,
    Point,
    at_another_clock,
    noise_for,
    record,
    recording,
    true_range,
)


def averaging(beeps):
    return StandingDetector(BEEP, PHONE, mic_phase_rad=None, averaged_beeps=beeps)


def nearest_to(range_m, found):
    """(n,) index of each detection's candidate that is meant, not one that noise made; nothing if none is near."""
    best = [(d, int(np.argmin(np.abs(d.range_m - range_m)))) for d in found if len(d)]
    return [(d, k) for d, k in best if abs(d.range_m[k] - range_m) < 0.03]


def still(points, beeps, noise, seed=0):
    """(2, N) of a phone that nothing moves before: one beep again and again, under noise."""
    clean = np.tile(record(points), beeps)
    return clean + FULL_SCALE * noise * np.random.default_rng(seed).standard_normal(clean.shape)


@pytest.mark.parametrize("beeps", [2, 8])
def test_signal_to_noise_grows_as_a_running_mean_says(beeps):
    """Once it spans n beeps the mean forgets 1/n a beep: noise falls to 1 / (2 n - 1)."""
    received = Recording(still([Point(2.5)], 60, 0.35), BEEP.sample_rate_hz)
    range_m = true_range(Point(2.5), 0.0, 0.0)
    alone, held = (
        [d.snr_db[k] for d, k in nearest_to(range_m, list(averaging(n).stream(received))[20:])] for n in (1, beeps)
    )
    assert len(alone) == len(held) == 40
    assert np.mean(held) - np.mean(alone) == pytest.approx(10.0 * np.log10(2 * beeps - 1), abs=0.5)


@pytest.mark.parametrize("ratio", [20e-6, -100e-6])
def test_beeps_at_another_clock_add_up_as_well(ratio):
    """The mean started anew with every beep, and ranges at 20 dB erred by 3.0 and 3.4 instead of 1.4 mm."""
    point, errors = Point(3.0), {0.0: [], ratio: []}
    range_m, noise = true_range(point, 0.0, 0.0), noise_for(20.0, point.gain)
    for seed in range(4):
        samples = record([point], beeps=14, noise=noise, seed=seed)
        for each, kept in errors.items():
            received = Recording(at_another_clock(samples, each), BEEP.sample_rate_hz)
            found = list(StandingDetector(BEEP, PHONE).stream(received))
            kept.extend(d.range_m[k] - range_m for d, k in nearest_to(range_m, found[-4:]))
            passed_s = (len(found) - 1) * BEEP.period_s * (1.0 + each)
            assert found[-1].time_s - found[0].time_s == pytest.approx(passed_s, abs=0.5e-6)
    steady, drifting = (float(np.sqrt(np.mean(np.square(kept)))) for kept in errors.values())
    assert len(errors[ratio]) == len(errors[0.0]) == 16
    assert drifting < 1.3 * steady < 2e-3


def test_ranges_scatter_less_and_the_claim_follows():
    point = Point(2.5)
    received = Recording(still([point], 320, 0.35), BEEP.sample_rate_hz)
    range_m = true_range(point, 0.0, 0.0)
    errors = {}
    for beeps in (1, 16):
        found = nearest_to(range_m, list(averaging(beeps).stream(received))[15::16])
        assert len(found) == 20
        errors[beeps] = np.array([d.range_m[k] - range_m for d, k in found])
        by_noise = [np.sqrt(d.range_std_m[k] ** 2 - OTHER_STD_M**2) for d, k in found]
        assert np.std(errors[beeps]) == pytest.approx(np.mean(by_noise), rel=0.5)
    assert np.std(errors[16]) < 0.4 * np.std(errors[1])


def test_one_beep_is_handed_through_bit_for_bit():
    profile = MatchedFilter(BEEP, 0.02).compress(record([Point(2.0)], noise=1.0))
    assert AveragedBeeps(1).add(profile) is profile
    assert np.array_equal(AveragedBeeps(16).add(profile).envelope, profile.envelope)


@pytest.mark.parametrize("moved_m", [0.002, 0.5])
def test_another_pose_starts_anew(moved_m):
    here, there = (record([Point(2.0 + m)], beeps=5, noise=0.3, seed=m > 0) for m in (0.0, moved_m))
    detector = averaging(16)
    blocks = np.concatenate([here, there], axis=1).reshape(2, 10, -1)
    found = [detector.process(blocks[:, k]) for k in range(10)]
    single = averaging(1).process(blocks[:, 5])
    assert len(found[5]) == len(single) == 1
    assert found[5].range_m[0] == single.range_m[0]
    assert found[9].range_m[0] == pytest.approx(true_range(Point(2.0 + moved_m), 0.0, 0.0), abs=2e-3)
    assert found[4].snr_db[0] > single.snr_db[0] + 5.0


def test_what_arrives_from_behind_is_left_out():
    ahead, behind, beside = Point(2.0), Point(-1.2), Point(0.0, aside_m=1.6)
    received = recording([ahead, behind, beside], beeps=4, noise=0.3)
    paper = list(PaperStandingDetector(BEEP, PHONE).stream(received))[-1]
    ours = list(StandingDetector(BEEP, PHONE).stream(received))[-1]
    expected = [true_range(point, 0.0, 0.0) for point in (beside, ahead)]
    behind_m = true_range(behind, 0.0, 0.0)
    assert np.abs(paper.range_m - behind_m).min() < 4e-3 < 0.1 < np.abs(ours.range_m - behind_m).min()
    assert all(np.abs(ours.range_m - range_m).min() < 4e-3 for range_m in expected)
    assert (ours.range_std_m > 0.003).all()
    assert not ours.decision.alert
    assert np.isnan(ours.radius_m).all()


def test_the_nearest_are_kept_and_a_reset_forgets():
    points = [Point(0.8 + 0.4 * k) for k in range(8)]
    detector = StandingDetector(BEEP, PHONE)
    received = recording(points, beeps=3, noise=0.1)
    first, again = list(detector.stream(received)), list(detector.stream(received))
    assert len(first[-1]) == PaperSettings().max_candidates
    np.testing.assert_allclose(first[-1].range_m, [true_range(p, 0.0, 0.0) for p in points[:5]], atol=5e-3)
    assert all(np.array_equal(a.range_m, b.range_m) for a, b in zip(first, again, strict=True))


@pytest.mark.parametrize("beeps", [0, 2.5, np.nan])
def test_not_a_number_of_beeps_is_an_error(beeps):
    """Cause: NaN is not below 1, so that it was a number of beeps, and a fraction was."""
    for make in (averaging, AveragedBeeps):
        with pytest.raises(ValueError, match=f"averaged_beeps must be a whole number, 1 or more, got {beeps}"):
            make(beeps)


def test_one_beep_measures_as_the_paper_does_without_the_carrier():
    """Peaks are placed by another order of additions: 500 samples of 7 mm, rounded to 2^-53."""
    block = record([Point(2.0, 0.3)])
    ours = StandingDetector(BEEP, PHONE, mic_phase_rad=None).process(block)
    papers = PaperStandingDetector(BEEP, PHONE).process(block)
    assert len(ours) == 1
    np.testing.assert_allclose(ours.range_m, papers.range_m, atol=1e-12)
    assert not ours.decision.alert
