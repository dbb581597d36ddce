"""Likelihood along lines against sums over explicit lines, and local noise against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch.signal.local_noise import local_noise
from obstaclewatch.tracking.track_before_detect import CHANGE, LineLikelihood, log_ratio
from obstaclewatch.tracking.tracks import Track

CELL_M, PERIOD_S = 0.0143, 0.09


def _slow(ratios, shifts):
    """(S, M) running sums by plain loops."""
    total = np.zeros((len(shifts), ratios.shape[1]))
    for ratio in ratios:
        before, total = total, np.empty_like(total)
        for row, _ in enumerate(shifts):
            for cell in range(len(ratio)):
                best = 0.0
                for near in (row - 1, row, row + 1):
                    at = cell + shifts[near] if 0 <= near < len(shifts) else -1
                    if 0 <= at < len(ratio):
                        best = max(best, before[near, at] - CHANGE * (near != row))
                total[row, cell] = best + ratio[cell]
    return total


def test_running_sums_are_those_of_plain_loops():
    rng = np.random.default_rng(2)
    ratios = rng.uniform(-1.2, 4.0, (7, 90)).astype(np.float32)
    likelihood = LineLikelihood(90, CELL_M, PERIOD_S)
    for ratio in ratios:
        likelihood.add(ratio)
    shifts = np.rint(likelihood.speeds_m_s * PERIOD_S / CELL_M).astype(int)
    expected = _slow(ratios, shifts)
    score, cell = likelihood.best()
    assert score == pytest.approx(expected.max(), rel=1e-5)
    assert expected[:, cell].max() == pytest.approx(score, rel=1e-5)
    row, at = np.unravel_index(np.argmax(expected), expected.shape)
    assert likelihood.speeds_m_s[row] in likelihood.speeds_to(at)


@pytest.mark.parametrize("speed", [0.8, 1.25, 1.6, 2.5])
def test_an_echo_too_weak_for_any_one_beep_adds_up(speed):
    """Power 5 over noise in a fluctuating echo; noise alone, with as many beeps, gathers less."""
    rng = np.random.default_rng(4)
    with_echo, alone = (LineLikelihood(400, CELL_M, PERIOD_S) for _ in range(2))
    for beep in range(16):
        power = rng.exponential(1.0, (2, 800))
        at = round((5.5 - speed * PERIOD_S * beep) / CELL_M)
        power[0, 2 * at : 2 * at + 2] = 5.0
        with_echo.add(log_ratio(power[0]))
        alone.add(log_ratio(power[1]))
    score, cell = with_echo.best()
    assert abs(cell - at) <= 2
    assert np.abs(with_echo.speeds_to(cell) - speed).min() < 0.1
    assert score > alone.best()[0] + 3.0
    with_echo.fade(at - 8, at + 9)
    assert with_echo.best()[0] < score
    with_echo.clear()
    assert with_echo.best()[0] == 0.0


def test_log_ratio_falls_on_noise():
    """Noise as wide as the compressed pulse, 9 samples at half power."""
    rng, pulse = np.random.default_rng(0), np.hanning(15)
    noise = np.convolve(rng.standard_normal(20_000) + 1j * rng.standard_normal(20_000), pulse, mode="same")
    ratio = log_ratio(np.abs(noise) ** 2 / (2.0 * np.sum(pulse**2)))
    assert len(ratio) == 10_000
    assert -0.9 < ratio.mean() < -0.2
    assert log_ratio(np.full(10, 100.0)).max() == 4.0


def test_local_noise_of_rayleigh_heights():
    rng = np.random.default_rng(1)
    height = np.abs(rng.standard_normal(40_000) + 1j * rng.standard_normal(40_000)) / np.sqrt(2.0)
    height[20_000:] *= 3.0
    noise = local_noise(height, 192)
    assert noise[:19_000].mean() == pytest.approx(1.0, rel=0.02)
    assert noise[21_000:].mean() == pytest.approx(3.0, rel=0.02)
    height[5_000:5_040] += 100.0
    assert local_noise(height, 192)[5_020] < 1.6


@pytest.mark.parametrize(("kept", "left"), [(24, 16), (9, 6), (8, 6), (7, 7), (3, 3)])
def test_a_track_forgets_its_oldest_third_if_enough_are_left(kept, left):
    track = Track(1.6, 1.3, np.eye(2), 0.9, 12.0)
    for k in range(kept):
        track.past.append((PERIOD_S * k, 1.0, 0.01))
        track.second.append(k)
        track.levels_db.append(-60.0)
    track.forget_oldest()
    assert [time_s for time_s, _, _ in track.past] == [PERIOD_S * k for k in range(kept - left, kept)]
    assert list(track.second) == list(range(kept - left, kept))
    assert len(track.levels_db) == left
