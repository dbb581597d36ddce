"""Echoes that a recording's end cuts off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from obstaclewatch.beep import BeepDesign
from simulator import Air, Fidelity, Scene, StraightWalk, render_walk
from simulator.phone.transducers import StructureBorne
from simulator.render import sum_envelopes, to_rate, trace_walk

C = 343.0
MIRRORS = Fidelity(mechanisms=("specular",), max_range_m=12.5)


def _echo(scene, phone, walk, beep):
    """(2, N) the wall's echo alone, without the direct sound."""
    paths, motion, count = trace_walk(scene, phone, walk, beep, MIRRORS)
    echo = paths.order == 1
    assert echo.sum() == 2 * count
    return to_rate(sum_envelopes(paths[echo], motion[echo], beep, count), phone, beep, count * beep.period_samples)


@pytest.mark.parametrize(("beeps", "distance_m", "gap_s", "rate_hz"), [
    (1, 6.95, 0.04, 192_000.0), (3, 7.4, 0.04, 192_000.0), (2, 6.95, 0.04, 48_000.0), (2, 12.0, 0.04, 192_000.0),
    (1, 3.0, 0.0, 192_000.0), (1, 12.0, 0.0, 192_000.0), (3, 12.0, 0.0, 192_000.0), (2, 7.4, 7_681 / 192e3, 192e3),
])  # fmt: skip
def test_echo_beyond_the_end_is_not_heard_at_the_start(box, phone, beeps, distance_m, gap_s, rate_hz):
    # Cause: the envelopes ended with the recording, and the Fourier transform took them for a circle. An echo that the
    # end cut off came in again at sample 0: 2e-4 of it at 6.95 m, a tenth of it at 12 m or without a gap between beeps.
    beep = BeepDesign(gap_s=gap_s, sample_rate_hz=rate_hz)
    scene = Scene([box((0.2, 12.0, 12.0), (distance_m + 0.1, 0.0, 1.3), "wall")], Air.lossless(C))
    short, long = (
        _echo(scene, phone, StraightWalk([0.0, 0.0, 1.3], 0.0, 1.3, (beeps + more) * beep.period_s), beep)
        for more in (0, 2)
    )
    loudest = np.abs(long).max()
    np.testing.assert_allclose(short, long[:, : short.shape[1]], rtol=0.0, atol=1e-6 * loudest)
    time = np.arange(short.shape[1]) / rate_hz
    for mic, receiver in enumerate(phone.geometry.mics_m[:, 1]):  # square on: all in one line
        emitted = (time * (C + 1.3) - 2.0 * distance_m + receiver + phone.geometry.speaker_m[1]) / (C - 1.3)
        silent = emitted < -1e-3
        assert silent.any()
        assert np.abs(short[mic, silent]).max() < 1e-6 * loudest
        heard = beep.waveform(emitted % beep.period_s) * (emitted >= 0.0) / (C * (time - emitted))
        # the window's ends are kinks, the upper one 1 kHz below half of 48 kHz: 2e-5 without what lies above
        np.testing.assert_allclose(short[mic], heard, rtol=0.0, atol=3e-5 * loudest)


def test_case_sound_beyond_the_end_is_not_heard_at_the_start(phone):
    # Cause: as above; without a gap the end cuts the sound through the case by its delay.
    beep = BeepDesign(gap_s=0.0)
    late = replace(phone, structure_borne=StructureBorne(np.array([2e-3, 3e-3]), np.array([30.0, 20.0])))
    short, long = (
        render_walk(Scene([], Air.lossless(C)), late, StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, n * beep.period_s), beep)
        for n in (1, 3)
    )
    count = short.samples.shape[1]
    atol = 1e-6 * float(np.abs(long.samples).max())
    np.testing.assert_allclose(short.samples, long.samples[:, :count], rtol=0.0, atol=atol)


def test_no_paths_are_silence(phone):
    beep = BeepDesign()
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, beep.period_s)
    paths, motion, count = trace_walk(Scene([]), phone, walk, beep, MIRRORS)
    none = np.zeros(len(paths), dtype=bool)
    assert not sum_envelopes(paths[none], motion[none], beep, count).any()
