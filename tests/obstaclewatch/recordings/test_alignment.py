"""Recordings that start anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from obstaclewatch import BeepDesign, Flag, NoBeepError, PaperDetector, PaperStandingDetector, Recording
from obstaclewatch.recordings.alignment import EARLY_S, BeepFinder
from obstaclewatch.signal.direct_sound import measured_direct_delay_s
from tests.obstaclewatch.synthetic import BEEP, PHONE, C, Point, beep_train, record

PERIOD = BEEP.period_samples
FINDER = BeepFinder(BEEP, 0.03 / C)
WALL = Point(3.0, gain=0.3)
NOISE = 0.05
THREE_BEEPS = record([WALL, Point(-0.37, gain=2.0)], beeps=3, noise=NOISE)


STILL_WHOLE = (0.03 / C + EARLY_S) * BEEP.sample_rate_hz  # the direct peak is no earlier than that
A_SAMPLE = 8  # of the 24 kHz envelope


@settings(max_examples=25, deadline=None)
@given(start=st.integers(0, PERIOD))
@example(start=20)
@example(start=21)
@example(start=round(STILL_WHOLE - A_SAMPLE) - 1)
@example(start=round(STILL_WHOLE + A_SAMPLE) + 1)
def test_the_first_whole_beep_is_found_wherever_the_recording_starts(start):
    """To a sample. A beep that lacks no more than the first 0.2 ms before its direct peak still counts as whole."""
    found = FINDER.first_emission(THREE_BEEPS[:, start:])
    if start < STILL_WHOLE - A_SAMPLE:
        assert found == 0
    else:
        assert abs(found - (PERIOD - start)) <= 1 or (found == 0 and start < STILL_WHOLE + A_SAMPLE)


COLD_M_S, WARM_M_S = 319.0, 358.0  # sound in air of -20 and 45 C


def _direct(case_to_air, sound_speed_m_s, beeps):
    """(2, N) direct sound through the case and, 3 cm, through the air."""
    time = np.arange(beeps * PERIOD) / BEEP.sample_rate_hz
    one = case_to_air * beep_train(time - 0.03 / 1500.0) + beep_train(time - 0.03 / sound_speed_m_s)
    return np.stack([one, one])


@pytest.mark.parametrize("case_to_air", [1.2, 1.5, 2.0])
@pytest.mark.parametrize("sound_speed_m_s", np.linspace(COLD_M_S, WARM_M_S, 7))
def test_the_first_beep_is_found_in_cold_and_hot_air(case_to_air, sound_speed_m_s):
    """Where the two ways of the direct sound cancel in part their peak lies before the emission: by 70 us for phones
    calibrated at 20 C (1.5) at -10 C. The first beep of recordings that begin with one was passed by."""
    finder = BeepFinder(BEEP, measured_direct_delay_s(_direct(case_to_air, C, 1), BEEP))
    assert finder.first_emission(_direct(case_to_air, sound_speed_m_s, 3)) <= 0.1e-3 * BEEP.sample_rate_hz


@pytest.mark.parametrize("silence", [1, 5_000, PERIOD - 10, PERIOD, 40_000])
def test_silence_and_noise_before_the_first_beep(silence):
    quiet = np.random.default_rng(6).standard_normal((2, silence)) * NOISE * 0.05
    assert abs(FINDER.first_emission(np.hstack([quiet, THREE_BEEPS])) - silence) <= 1
    assert abs(FINDER.first_emission(np.hstack([0.0 * quiet, THREE_BEEPS])) - silence) <= 1


@pytest.mark.parametrize(
    "samples",
    [
        np.zeros((2, 60_000)),
        np.random.default_rng(7).standard_normal((2, 400_000)),
        record([], beeps=4, beep=BeepDesign(start_hz=23_000.0, stop_hz=18_000.0)),
        record([], beeps=4, beep=BeepDesign(start_hz=12_000.0, stop_hz=17_000.0)),
        THREE_BEEPS[:, :500],
    ],
    ids=["silence", "noise", "falling chirp", "another band", "too short"],
)
def test_no_beep_is_an_error(samples):
    with pytest.raises(NoBeepError, match="no beep found at microphone 0"):
        FINDER.first_emission(samples)
    with pytest.raises(NoBeepError):
        PaperDetector(BEEP, PHONE).run(Recording(samples, BEEP.sample_rate_hz))


def test_a_recording_from_mid_beep_gives_the_same_ranges():
    whole = list(PaperDetector(BEEP, PHONE).stream(Recording(THREE_BEEPS, BEEP.sample_rate_hz)))
    cut = list(PaperDetector(BEEP, PHONE).stream(Recording(THREE_BEEPS[:, 5_001:], BEEP.sample_rate_hz)))
    assert len(whole) == 3
    assert len(cut) == 2
    assert len(cut[0]) >= 1
    assert cut[0].time_s == pytest.approx(whole[1].time_s - 5_001 / BEEP.sample_rate_hz, abs=1e-6)
    assert cut[0].range_m[-1] == pytest.approx(whole[1].range_m[-1], abs=1e-3)


def test_dropped_samples_are_survived():
    """800 samples missing: one beep is lost and said to be, then the beeps are found at their new places."""
    samples = np.delete(record([WALL], beeps=6), np.arange(40_000, 40_800), axis=1)
    detector = PaperStandingDetector(BEEP, PHONE)
    detections = list(detector.stream(Recording(samples, BEEP.sample_rate_hz)))
    lost = [Flag.NO_BEEP in detection.beep_flags for detection in detections]
    assert lost == [False, False, False, True, False, False]
    whole = [detections[k].range_m[0] for k in (0, 1, 4, 5)]
    assert whole == pytest.approx([3.0 - 0.0705] * 4, abs=1e-3)
