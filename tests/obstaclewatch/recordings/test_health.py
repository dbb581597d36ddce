"""Every kind of damage gets its finding, and clean recordings of every phone get none."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy import signal
from scipy.interpolate import CubicSpline

from obstaclewatch import BeepDesign, Fault, Recording, inspect_recording
from obstaclewatch.recordings.beep_identification import detected_beep
from scenes import make_approach
from simulator import Material, Obstacle, Phone, Scene, StraightWalk, render_walk
from simulator.phone.presets import list_phones
from tests.obstaclewatch.synthetic import BEEP, PHONE, Point, record

RATE = BEEP.sample_rate_hz
NOISY_PHONES = ["galaxy-s5", "galaxy-note5", "galaxy-s8-plus"]


@lru_cache
def walk(name):
    """(2, N) 1.35 s of a walk on hard ground towards a wall 4.5 m ahead."""
    ground = trimesh.creation.box((40.0, 40.0, 1.0))
    ground.apply_translation([0.0, 0.0, -0.5])
    wall = trimesh.creation.box((0.3, 6.0, 3.0))
    wall.apply_translation([4.65, 0.0, 1.5])
    scene = Scene([
        Obstacle(ground, Material.named("concrete"), "ground"),
        Obstacle(wall, Material.named("brick"), "wall"),
    ])  # fmt: skip
    path = StraightWalk([0.0, 0.0, 1.3], heading_rad=0.0, speed_m_s=1.3, duration_s=1.35, pitch_rad=0.5)
    samples = render_walk(scene, Phone.named(name), path, BEEP, seed=3).samples
    samples.setflags(write=False)
    return samples


def inspect(samples, name="galaxy-s5", beep=BEEP):
    recording = Recording(np.array(samples, dtype=np.float32), beep.sample_rate_hz)
    return inspect_recording(recording, beep, Phone.named(name).geometry)


def noise(shape, level, seed=0):
    return level * np.random.default_rng(seed).standard_normal(shape).astype(np.float32)


def limited(samples, depth):
    """A linked limiter: it takes at once and gives back over 30 ms whatever is louder than `depth` of the peak."""
    loud = np.abs(samples).max(axis=0)
    hops = loud.reshape(-1, 192).max(axis=1)
    level = np.empty(len(hops))
    held = 0.0
    for k, height in enumerate(hops):
        held = level[k] = max(height, held * np.exp(-1.0 / 30.0))
    gain = np.minimum(1.0, depth * loud.max() / np.maximum(level, 1e-12))
    return samples * np.repeat(gain, 192)


def at_another_clock(samples, ratio):
    """What a recorder receives whose clock runs that share faster than the player's, from 10 ms before the first
    beep."""
    time = np.arange(-1_920, samples.shape[1]) / (1.0 + ratio)
    detected = CubicSpline(np.arange(samples.shape[1]), samples, axis=1)(np.clip(time, 0, samples.shape[1] - 1))
    return np.where(time < 0.0, 0.0, detected)


@pytest.mark.parametrize("name", list_phones())
@pytest.mark.parametrize("bits", [24, 16])
def test_clean_recordings_raise_no_alarm(name, bits):
    steps = 2.0 ** (bits - 1)
    health = inspect(np.round(walk(name) * steps) / steps, name)
    assert health.findings == ()
    assert health.usable
    assert health.detected is not None
    assert health.calibration is not None
    assert len(health.calibration.emission_s) == 15


@pytest.mark.parametrize("name", NOISY_PHONES)
@pytest.mark.parametrize(
    ("fault", "damage"),
    [
        (Fault.IDENTICAL_CHANNELS, lambda x: x[[0, 0]]),
        (Fault.IDENTICAL_CHANNELS, lambda x: np.stack([x[0], -0.3 * x[0]])),
        (Fault.SWAPPED_CHANNELS, lambda x: x[::-1]),
        (Fault.DEAF_MICROPHONE, lambda x: np.stack([x[0], 0.0 * x[1]])),
        (Fault.DEAF_MICROPHONE, lambda x: np.stack([x[0], noise(x[1].shape, 1e-4)])),
        (Fault.DEAF_MICROPHONE, lambda x: np.stack([x[0], np.where(np.arange(x.shape[1]) < 60_000, x[1], 0.0)])),
        (Fault.NO_BEEP, lambda x: np.stack([0.0 * x[0], x[1]])),
        (Fault.NO_BEEP, lambda x: noise(x.shape, 1e-3)),
        (Fault.NO_BEEP, lambda x: 0.0 * x),
        (Fault.CLIPPED, lambda x: np.clip(x, -0.89 * x.max(), 0.89 * x.max())),
        (Fault.CLIPPED, lambda x: np.clip(x, None, 0.7 * x.max())),
        (Fault.LIMITED, lambda x: limited(x, 0.5)),
        (Fault.DROPPED_SAMPLES, lambda x: np.delete(x, 100_000, axis=1)),
        (Fault.DROPPED_SAMPLES, lambda x: np.delete(x, np.s_[150_000:150_480], axis=1)),
        (Fault.DROPPED_SAMPLES, lambda x: np.insert(x, np.full(20, 90_000), 0.0, axis=1)),
        (Fault.DROPPED_SAMPLES, lambda x: np.where((np.arange(x.shape[1]) // 96) == 1200, 0.0, x)),
        (Fault.CLOCK_DRIFT, lambda x: at_another_clock(x, 100e-6)),
        (Fault.CLOCK_DRIFT, lambda x: at_another_clock(x, -2e-3)),
        (Fault.MID_BEEP_START, lambda x: x[:, 4000:]),
    ],
)
def test_each_damage_has_its_finding_and_no_other(name, fault, damage):
    health = inspect(damage(walk(name)), name)
    assert health.faults == {fault}
    assert health.usable is not fault.fatal
    assert str(health.findings[0]).startswith(fault.label)


@pytest.mark.parametrize("ratio", [100e-6, -400e-6])
def test_the_clocks_drift_is_measured_beside_a_gap(ratio):
    """100 ppm moved the beat by 1.7 samples a beep, which was told as samples dropped after the first one."""
    drifting = at_another_clock(walk("galaxy-s8-plus"), ratio)
    health = inspect(drifting, "galaxy-s8-plus")
    assert health.faults == {Fault.CLOCK_DRIFT}
    told = float(health.findings[0].message.split(" is ")[1].split(" ppm")[0])
    assert told == pytest.approx(1e6 * ratio, abs=3.0)
    health = inspect(np.delete(drifting, np.s_[120_000:120_020], axis=1), "galaxy-s8-plus")
    assert health.faults == {Fault.CLOCK_DRIFT, Fault.DROPPED_SAMPLES}
    assert "by -20 samples" in str(health.findings[0])


def test_a_deaf_microphone_has_no_delay():
    """It was said to receive the speaker 1238 us before the other one, at the edge of where that is looked for."""
    health = inspect(np.stack([walk("galaxy-s5")[0], 0.0 * walk("galaxy-s5")[1]]))
    assert health.calibration is not None
    assert np.isnan(health.calibration.mic_delay_s)
    assert not any("receives the speaker" in line for line in health.lines())


@pytest.mark.parametrize("count", [5_000, 9_600, BEEP.period_samples - 1])
def test_a_recording_of_less_than_one_beep_is_said_to_be_short(count):
    """It was said that microphone 0 receives no beep and microphone 1 does."""
    health = inspect(walk("galaxy-s5")[:, :count])
    assert health.faults == {Fault.NO_BEEP}
    assert f"the recording ends {count / RATE:.3f} s after the first begins" in str(health.findings[0])


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(lost=st.integers(1, 5_000), at=st.integers(40_000, 200_000))
def test_any_gap_is_noticed(lost, at):
    """Whatever is lost: one sample or a third of a period, in a beep or between two."""
    health = inspect(np.delete(walk("galaxy-s8-plus"), np.s_[at : at + lost], axis=1), "galaxy-s8-plus")
    assert Fault.DROPPED_SAMPLES in health.faults


@settings(max_examples=8, deadline=None)
@given(start=st.integers(0, BEEP.period_samples - 1), gain=st.floats(1e-4, 10.0), seed=st.integers(0, 99))
def test_start_level_and_noise_raise_no_alarm(start, gain, seed):
    """Any start, any level of the file, and noise up to 20 dB more: a start within the loud part of a beep is said."""
    clean = walk("galaxy-note5")
    health = inspect(gain * (clean + noise(clean.shape, 1e-4, seed))[:, start:], "galaxy-note5")
    assert health.faults <= {Fault.MID_BEEP_START}
    if 600 < start < 6_000:
        assert Fault.MID_BEEP_START in health.faults
    if start >= 9_700:
        assert Fault.MID_BEEP_START not in health.faults


def test_a_start_in_mid_beep_inverts_no_channel():
    """The jump rings below 500 Hz with the beep's phases, which may be opposed between the microphones."""
    clean = walk("galaxy-note5")
    assert inspect((clean + noise(clean.shape, 1e-4, 0))[:, 1730:], "galaxy-note5").faults == {Fault.MID_BEEP_START}


def test_touching_a_wall_is_not_a_gap():
    """At 6 cm its echo runs into the direct sound and moves it by samples, as in the last beep of a rendered walk."""
    points = [Point(0.5, gain=8.0)]
    health = inspect_recording(Recording(record(points, beeps=5, speed_m_s=1.0, noise=0.01), RATE), BEEP, PHONE)
    assert health.calibration is not None
    assert np.abs(np.diff(health.calibration.drift_s, axis=0)).max() * RATE > 0.6
    assert health.faults == set()


def test_walking_into_a_wall_is_not_a_gap():
    """Cause: in the last beeps its echo moved both direct sounds by 0.8 samples: 9 of 48 such walks lost samples."""
    way = make_approach("campus", "wall", 8, phone_name="galaxy-note5", seed=11, recipe="paper")
    recording = render_walk(way.scene, way.phone, way.walk, BEEP, seed=1)
    assert inspect_recording(recording, BEEP, way.phone.geometry).findings == ()


OTHERS = {
    "lower band": BeepDesign(14_000.0, 19_000.0),
    "2 kHz lower": BeepDesign(16_000.0, 21_000.0),
    "downwards": BeepDesign(23_000.0, 18_000.0),
    "half as long": BeepDesign(duration_s=0.025, gap_s=0.065),
    "more often": BeepDesign(gap_s=0.010),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_another_beep_is_told_and_measured(other):
    samples = record([Point(2.0)], beeps=20, noise=0.01, beep=other)
    health = inspect_recording(Recording(samples, RATE), BEEP, PHONE)
    assert health.faults == {Fault.OTHER_BEEP}
    assert not health.usable
    assert health.detected is not None
    assert health.detected.start_hz == pytest.approx(other.start_hz, abs=150.0)
    assert health.detected.stop_hz == pytest.approx(other.stop_hz, abs=150.0)
    assert health.detected.duration_s == pytest.approx(other.duration_s, rel=0.04)
    assert health.detected.period_s == pytest.approx(other.period_s, rel=1e-3)
    assert inspect_recording(Recording(samples, RATE), other, PHONE).findings == ()


@pytest.mark.parametrize("duration_s", [0.005, 0.008, 0.010, 0.050])
@pytest.mark.parametrize(
    "band_hz", [(18_000.0, 23_000.0), (16_000.0, 20_000.0), (22_000.0, 15_000.0), (19_000.0, 19_500.0)]
)
def test_short_and_narrow_beeps_are_their_own(band_hz, duration_s):
    """Cause: the spectrogram's frame of 4 ms was part of the measured length, and its bins of 250 Hz were the ridge, so
    that short and narrow sweeps were found to be slower than designed, and refused."""
    beep = BeepDesign(*band_hz, duration_s)
    health = inspect_recording(Recording(record([Point(2.0)], beeps=20, noise=0.01, beep=beep), RATE), beep, PHONE)
    assert health.findings == ()


@pytest.mark.parametrize("rate", [44_100.0, 48_000.0, 88_200.0, 96_000.0, 176_400.0, 192_000.0])
def test_all_rates_of_phones(rate):
    """18-21.5 kHz is what 44.1 kHz can hold."""
    beep = replace(BEEP, stop_hz=21_500.0, sample_rate_hz=rate)
    health = inspect_recording(Recording(record([Point(2.0)], beeps=12, noise=0.02, beep=beep), rate), beep, PHONE)
    assert health.findings == ()
    assert health.detected is not None
    assert health.detected.stop_hz == pytest.approx(21_500.0, abs=200.0)


def test_the_direct_sound_calibrates_an_open_phone():
    """Through the air the way between the microphones gives the speed of sound: 8.1 cm, so 0.1 % at best."""
    samples = record([], beeps=8, noise=0.01, direct=(10.0, 4.0))
    calibration = inspect_recording(Recording(samples, RATE), BEEP, PHONE).calibration
    assert calibration is not None
    assert calibration.sound_speed_m_s == pytest.approx(343.0, rel=3e-3)
    assert calibration.mic_gain_db == pytest.approx(20.0 * np.log10(0.4), abs=0.01)
    assert calibration.emission_s == pytest.approx(0.09 * np.arange(8), abs=1e-6)
    assert np.abs(calibration.response_db).max() < 0.1


@pytest.mark.parametrize("name", NOISY_PHONES)
def test_sound_through_the_case_hides_the_speed_of_sound(name):
    health = inspect(walk(name), name)
    assert health.calibration is not None
    assert np.isnan(health.calibration.sound_speed_m_s)
    assert any("not observable" in line for line in health.lines())


def test_a_response_is_read_from_the_direct_sound():
    """A known filter on the whole recording: its level over the band comes back to 0.3 dB."""
    samples = record([], beeps=6)
    spectrum = np.fft.rfft(samples, axis=1)
    frequency = np.fft.rfftfreq(samples.shape[1], 1.0 / RATE)
    slope_db = -1.0 * (frequency - 20_500.0) / 1_000.0
    shaped = np.fft.irfft(spectrum * 10.0 ** (slope_db / 20.0), samples.shape[1], axis=1)
    calibration = inspect_recording(Recording(0.1 * shaped, RATE), BEEP, PHONE).calibration
    assert calibration is not None
    expected = -1.0 * (calibration.response_hz - calibration.response_hz[0]) / 1_000.0
    assert len(expected) > 10
    assert calibration.response_db[0] == pytest.approx(expected, abs=0.3)


def test_a_dead_top_microphone_is_named():
    """The message asked whether the channels are swapped, which zeros are not."""
    samples = walk("galaxy-s5")
    for first, word in ((0.0 * samples[0], "recorded zeros"), (noise(samples[0].shape, 1e-4), "receives none")):
        (finding,) = inspect(np.stack([first, samples[1]])).findings
        assert f"microphone 0 (top) {word}" in finding.message


def test_too_short_for_a_period_is_no_beep():
    assert inspect(walk("galaxy-s5")[:, :12_000]).faults == {Fault.NO_BEEP}
    assert detected_beep(np.zeros(100), RATE) is None


def surroundings(samples, level=1e-3):
    """The same recording with traffic at 100 to 400 Hz, which reaches both microphones alike."""
    shape = signal.butter(2, (100.0, 400.0), "bandpass", fs=RATE, output="sos")
    rumble = signal.sosfilt(shape, noise(samples.shape[1] + 20_000, 1.0, seed=5).astype(np.float64))[20_000:]
    return samples + (level / rumble.std() * rumble).astype(np.float32)


def without_beeps(samples, first, count, share=1.0):
    """`count` beep periods, or their first part, set to zero."""
    kept = samples.copy()
    for k in range(first, first + count):
        kept[:, k * BEEP.period_samples : round((k + share) * BEEP.period_samples)] = 0.0
    return kept


@pytest.mark.parametrize("name", NOISY_PHONES)
@pytest.mark.parametrize(
    ("fault", "damage"),
    [
        (Fault.MISSING_BEEPS, lambda x: without_beeps(x, 4, 2)),
        (Fault.LATE_CHANNEL, lambda x: np.stack([x[0], np.roll(x[1], 120)])),
        (Fault.LATE_CHANNEL, lambda x: np.stack([x[0], np.roll(x[1], 200)])),
        (Fault.LATE_CHANNEL, lambda x: np.stack([x[0], np.roll(x[1], -150)])),
        (Fault.INVERTED_CHANNEL, lambda x: surroundings(x) * np.array([[1.0], [-1.0]])),
        (Fault.OFFSET, lambda x: x + np.float32(0.5)),
        (Fault.OFFSET, lambda x: x + np.array([[0.0], [-0.01]], dtype=np.float32)),
        (Fault.COARSE_STEPS, lambda x: np.round(x / np.abs(x).max() * 7.0) / 8.0),
        (Fault.ABSURD_LEVEL, lambda x: 1e30 * x),
        (Fault.ABSURD_LEVEL, lambda x: np.where(np.arange(x.shape[1]) == 999, np.float32(1e6), x)),
    ],
)
def test_damage_that_passed_for_nothing_wrong_is_found_by_name(name, fault, damage):
    """Cause: none of these moves the beat of the beeps, so that each read "nothing wrong found"."""
    health = inspect(damage(walk(name)), name)
    assert fault in health.faults
    assert health.faults <= {fault, Fault.DROPPED_SAMPLES, Fault.SWAPPED_CHANNELS}
    assert health.usable is not any(found.fault.fatal for found in health.findings)


@pytest.mark.parametrize("name", list_phones())
def test_surroundings_that_reach_both_microphones_raise_no_alarm(name):
    assert inspect(surroundings(walk(name)), name).findings == ()
