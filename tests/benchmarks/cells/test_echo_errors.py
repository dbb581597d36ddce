"""Resolved echoes are judged one by one."""

import numpy as np
import pytest

from benchmarks.cells.probes.echo_errors import resolved_errors

RATE_HZ = 163_840.0


def pulses(*places_and_levels):
    """Pulses of 30 lags, as compressed beeps are, at places (lags) and levels (dB)."""
    lag = np.arange(2048)
    every = [10.0 ** (db / 20.0) * np.exp(-(((lag - at) / 30.0) ** 2)) for at, db in places_and_levels]
    return np.sum(every, axis=0)[None] + 0j


def test_a_fainter_echo_counts_beside_the_strongest():
    theirs = pulses((300, -10.0), (700, -30.0))
    ours = pulses((300, -10.0), (704, -31.0))
    found = resolved_errors(ours, theirs, RATE_HZ)
    assert found["resolved_db"] == pytest.approx([0.0, -1.0], abs=1e-6)
    assert found["resolved_samples"] == pytest.approx([0.0, 4 * 192_000 / RATE_HZ])


def test_what_is_lost_or_moved_far_is_an_error():
    theirs = pulses((300, -10.0), (700, -30.0))
    lost, moved = (resolved_errors(ours, theirs, RATE_HZ) for ours in (pulses((300, -10.0)), pulses((400, -10.0))))
    assert lost["resolved_db"][1] < -20.0
    assert moved["resolved_db"][0] < -6.0


@pytest.mark.parametrize("second", [(340, -10.5), (700, -46.0)], ids=["merged", "below the noise"])
def test_merged_and_faint_echoes_do_not_count(second):
    theirs = pulses((300, -10.0), second)
    assert len(resolved_errors(theirs, theirs, RATE_HZ)["resolved_db"]) == 1
