"""Real phones: recorded traces through the stages that take magnitudes, raw audio through all of them."""

from __future__ import annotations

import importlib.util
import os
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from docs.studies.real_traces import (
    Trace,
    false_detections,
    learn,
    load_trace,
    objects_at_label,
    track_from_hold,
    voted,
)
from docs.studies.real_vs_simulated import (
    CASES,
    excitation,
    line_db,
    real_levels,
    simulated_levels,
    to_db,
    to_magnitude,
)
from obstaclewatch import BeepDesign, Fault, Flag, PaperSettings, PaperStandingDetector, Recording, inspect_recording
from simulator import Phone

SHARED = Path(os.environ.get("OBSTACLEWATCH_SHARED", Path(__file__).resolve().parents[3] / "shared"))
DATA = SHARED / "realdata" / "open"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"no recordings of real phones at {DATA}")

BASELINES = ("6p_mic_base_1", "s5_reg_base_1", "s4_reg_base_1")
OBJECTS = (
    "6p_mic_2m_1", "6p_mic_2_5m_1", "6p_mic_3m_2", "6p_mic_3m_nouser_2", "6p_reg_3m_1",
    "s4_reg_2m_1", "s4_reg_3m_1", "s5_reg_2m_1", "s5_reg_3m_1",
)  # fmt: skip
MOVING = ("6p_mic_2m_1", "6p_mic_2_5m_1", "6p_mic_3m_2", "6p_mic_3m_nouser_2", "s5_reg_3m_1")


@lru_cache
def trace(name: str) -> Trace:
    return load_trace(DATA / "traces" / f"{name}.npz")


@lru_cache
def rule(halves=(0, 1)):
    return learn([trace(name) for name in BASELINES], halves)


def test_at_most_one_percent_of_the_baselines_beeps_are_false_detections():
    """Each half is judged by what the other half taught the factor: 195 beeps, up to two channels each."""
    judged = [false_detections(rule((half, 1 - half)), [trace(name) for name in BASELINES], half) for half in (0, 1)]
    false, total = np.sum(judged, axis=0)
    assert total == 195
    assert false / total <= 0.01


def test_no_vote_of_the_baselines_is_false():
    for name in BASELINES:
        held = trace(name).level[trace(name).hold]
        zone = (trace(name).range_m > 1.6) & (trace(name).range_m < 3.5)
        present = np.any(
            [(held[:, :, c] > rule().threshold(trace(name), c))[:, zone].any(axis=1) for c in range(held.shape[2])],
            axis=0,
        )
        assert len(present) > 40
        assert not voted(present).any()


@pytest.mark.parametrize("name", OBJECTS)
def test_the_object_is_detected_in_every_hold(name):
    """At its labelled distance, by the vote of five in nine, without a break; single beeps in at least nine of ten."""
    held = np.isfinite(objects_at_label(trace(name), rule())).any(axis=1)[trace(name).hold]
    assert len(held) >= 35
    assert held.mean() > 0.9
    assert voted(held)[8:].all()


@pytest.mark.parametrize("name", MOVING)
def test_the_range_track_follows_the_moving_ones(name):
    """Against the line that was followed by dynamic programming in a corridor drawn by eye."""
    error = track_from_hold(trace(name), rule()) - trace(name).wall_m
    error = np.abs(error[np.isfinite(error)])
    assert np.ptp(trace(name).wall_m[np.isfinite(trace(name).wall_m)]) > 0.3
    assert len(error) > 190
    assert np.median(error) < 0.01
    assert np.mean(error < 0.06) > 0.94


RAW_BEEP = BeepDesign(18_000.0, 23_950.0, 0.025, 0.025, 48_000.0)
"""18-24 kHz in 25 ms every 50 ms, a hair below half the rate."""


@lru_cache
def raw() -> Recording:
    with np.load(DATA / "raw_beeps_unknown_phone.npz") as stored:
        audio = stored["audio"].astype(np.float32) / 32768.0
        return Recording(np.stack([audio, audio]), float(stored["fs"]))


def test_raw_audio_is_inspected():
    """2.8 s of an unknown phone: a preamble, then 42 beeps from sample 31,444 on; both channels are equal."""
    health = inspect_recording(raw(), RAW_BEEP, Phone.named("galaxy-s5").geometry)
    assert health.faults == {Fault.IDENTICAL_CHANNELS}
    assert health.detected is not None
    assert health.detected.period_s == pytest.approx(0.05, rel=1e-3)
    assert health.detected.chirp_rate_hz_s == pytest.approx(RAW_BEEP.chirp_rate_hz_s, rel=0.05)
    assert health.calibration is not None
    assert len(health.calibration.emission_s) == 42
    assert health.calibration.emission_s[0] * 48_000.0 == pytest.approx(31_444, abs=30)
    assert np.abs(health.calibration.drift_s).max() * 48_000.0 < 0.5
    assert health.calibration.beep_to_beep_db[0] < 0.5


def test_raw_audio_passes_all_stages():
    """Every beep is found and measured by range alone; what stands there echoes beep after beep at the same range."""
    settings = PaperSettings(far_m=3.8)
    detections = list(PaperStandingDetector(RAW_BEEP, Phone.named("galaxy-s5").geometry, settings).stream(raw()))
    assert len(detections) == 42
    assert all(Flag.IDENTICAL_CHANNELS in found.beep_flags for found in detections)
    assert all(np.isnan(found.bearing_rad).all() and np.isfinite(found.range_m).all() for found in detections)
    assert np.diff([found.time_s for found in detections]) == pytest.approx(0.05, abs=1e-5)
    early = np.concatenate([found.range_m for found in detections[:12]])
    assert np.sum(np.abs(early - 2.0) < 0.03) + np.sum(np.abs(early - 2.12) < 0.03) >= 8


def test_simulated_beeps_are_processed_as_the_recorded_ones():
    """The recordings come with a copy of their authors' processing, which shares no code with ours."""
    spec = importlib.util.spec_from_file_location("realdata", DATA.parent / "realdata.py")
    assert spec is not None
    assert spec.loader is not None
    theirs = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(theirs)
    period = np.random.default_rng(0).standard_normal(2400)
    expected = theirs.to_magnitude(period)
    assert np.abs(excitation() - theirs.excitation()).max() < 1e-9
    assert np.abs(to_magnitude(period) - expected).max() < 1e-9 * expected.max()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.trace)
def test_a_simulated_counterpart_has_the_recordings_levels(case):
    """Nexus 6P towards a large object at 2 and 3 m, relative to the direct sound: what the preset was set from (object
    and noise of four recordings' mean), and what it was not (bin by bin). The bottom microphone hears no floor in
    reality: hand and body hide it."""
    recorded, simulated = to_db(real_levels(trace(case.trace))), to_db(simulated_levels(case, Phone.named("nexus-6p")))
    ranges = trace(case.trace).range_m
    for mic in (0, 1):
        lines = [line_db(profile[:, mic], ranges, case.wall_m) for profile in (recorded, simulated)]
        assert lines[1] - lines[0] == pytest.approx(0.0, abs=3.0)
        noise = [np.median(profile[ranges > 3.6, mic]) for profile in (recorded, simulated)]
        assert noise[1] - noise[0] == pytest.approx(0.0, abs=4.0)
    assert (np.median(np.abs(simulated - recorded), axis=0) < 5.0).all()
    floor = [line_db(profile[:, 1], ranges, case.phone_height_m) for profile in (recorded, simulated)]
    assert floor[1] - floor[0] < 4.5  # 5 to 7 dB while microphones were but 10 dB deafer to the rear
