"""Beeps after the matched filter, straight from paths: no noise, no sampling, nothing that moves within a beep."""

from __future__ import annotations

from functools import cache

import numpy as np

from obstaclewatch import BeepDesign
from obstaclewatch.support.arrays import Complexes, Flags, Floats
from simulator import Paths

STEP_HZ, LAGS = 20.0, 8192
LAG_RATE_HZ = STEP_HZ * LAGS
FREQUENCY_HZ = np.arange(18_000.0, 23_000.0, STEP_HZ)  # 50 ms of lag: the longest path of the search range is 41 ms


def compressed(paths: Paths, mask: Flags) -> Complexes:
    """(2 N, LAGS) compressed beeps of some paths (P,), pose by pose and microphone by microphone, at `LAG_RATE_HZ`."""
    some = paths[mask]
    gain = some.gain_at(FREQUENCY_HZ) * np.exp(-2j * np.pi * FREQUENCY_HZ * some.delay_s[:, None])
    total = np.zeros((paths.poses * 2, len(FREQUENCY_HZ)), dtype=np.complex128)
    np.add.at(total, some.pose * 2 + some.mic, gain)
    return np.fft.ifft(total * _beep_power(), n=LAGS, axis=1) * LAGS


def of_target(paths: Paths, target: str) -> Flags:
    """(P,) paths that meet the target."""
    return np.array([target in met for met in paths.obstacles_met()], dtype=bool)


def levels_db(envelopes: Complexes) -> Floats:
    """Levels of compressed echoes (R, L), dB re the free field at 1 m; -240 where there is nothing."""
    return 20.0 * np.log10(np.abs(envelopes) + 1e-12)


def peak_levels_db(envelopes: Complexes) -> list[float]:
    """Levels of the highest peaks of compressed echoes (R, L), dB re the free field at 1 m."""
    found: list[float] = levels_db(envelopes).max(axis=1).tolist()
    return found


@cache
def _beep_power() -> Floats:
    """(F,) of the beep at `FREQUENCY_HZ`, re all of it."""
    beep = BeepDesign()
    time = np.arange(round(beep.duration_s * 192_000.0)) / 192_000.0
    power = np.abs(np.exp(-2j * np.pi * FREQUENCY_HZ[:, None] * time) @ beep.waveform(time)) ** 2
    return power / power.sum()
