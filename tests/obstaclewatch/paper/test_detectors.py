"""The paper's detector end to end, on points at known places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from obstaclewatch import (
    BeepDesign,
    DistanceOnlyDetector,
    Errata,
    Flag,
    NoBeepError,
    PaperDetector,
    PaperSettings,
    PaperStandingDetector,
    PhoneGeometry,
    Recording,
    StandingDetector,
    TrackingDetector,
    TrackingSettings,
)
from tests.obstaclewatch.synthetic import BEEP, PHONE, C, Point, record, recording, true_range

L = PHONE.mic_separation_m
GROUND = Point(1.3, gain=0.3, carried=True, bob_m=0.02)


def _standing(points, settings=None, **options):
    return PaperStandingDetector(BEEP, PHONE, settings).process(record(points, **options))


def _bearing(point):
    return np.arctan2(point.aside_m, point.ahead_m - 0.0705)


@pytest.mark.parametrize("ahead_m", [0.7, 1.5, 3.0, 5.0, 6.8])
@pytest.mark.parametrize("aside_m", [0.0, 0.4, 1.2])
def test_range_and_bearing_of_a_point(ahead_m, aside_m):
    """Without noise: 0.1 mm and, from cos within 1e-3 of its edge, 2 degrees at 0 and better elsewhere."""
    point = Point(ahead_m, aside_m)
    found = _standing([point])
    if np.hypot(ahead_m, aside_m) > 7.0:
        return
    assert len(found) == 1
    assert found.range_m[0] == pytest.approx(true_range(point, 0.0, 0.0), abs=2e-4)
    assert found.range2_m[0] == pytest.approx(true_range(point, 0.0, 0.0, mic=1), abs=3e-4)
    assert found.bearing_rad[0] == pytest.approx(_bearing(point), abs=np.radians(2.0 if aside_m == 0.0 else 0.5))


@pytest.mark.parametrize("speed", [1.0, 1.3, 1.6])
def test_walking_reads_the_range_ahead_of_time(speed):
    """Range-Doppler coupling: R at the beep's centre as it is hit, less speed x 0.205 s; the stretch of the chirp by
    2 v / c adds the third order, 2 mm."""
    wall = Point(4.0)
    found = _standing([wall], speed_m_s=speed)
    assert len(found) == 1
    centre = 0.025 + true_range(wall, speed, 0.03) / C
    bias = found.range_m[0] - true_range(wall, speed, centre)
    assert bias == pytest.approx(-speed * BEEP.range_doppler_s, abs=4e-3)


def test_static_echoes_go_and_the_obstacle_stays():
    """Ground under a gait, a wall alongside, and an obstacle ahead."""
    points = [GROUND, Point(2.0, gain=0.1, carried=True), Point(5.0, gain=0.06)]
    detections = list(PaperDetector(BEEP, PHONE).stream(recording(points, beeps=20, speed_m_s=1.3, noise=0.02)))
    assert len(detections) == 20
    assert all(Flag.UNCONFIRMED in Flag(int(detections[0].flags[0])) for _ in range(1))
    settled = detections[7:]
    assert all(len(found) >= 1 for found in settled)
    nearest = np.array([found.range_m[np.isfinite(found.closing_speed_m_s)][0] for found in settled])
    expected = [true_range(points[2], 1.3, found.time_s + 0.025 + 0.01) - 1.3 * 0.205 for found in settled]
    assert nearest == pytest.approx(expected, abs=0.03)
    assert np.mean([len(found) for found in settled]) < 1.3
    speeds = [found.closing_speed_m_s[np.isfinite(found.closing_speed_m_s)][0] for found in settled]
    assert speeds == pytest.approx([1.3] * len(speeds), abs=0.06)


def test_collision_course_alerts_and_passing_by_does_not():
    """At 30 dB and more the vote tells 0 from 1.2 m of miss; the distance alone does not."""
    options = {"beeps": 30, "speed_m_s": 1.4, "noise": 0.02}
    ahead = recording([GROUND, Point(5.0, 0.0, gain=0.1)], **options)
    aside = recording([GROUND, Point(5.0, 1.2, gain=0.1)], **options)
    paper, baseline = PaperDetector(BEEP, PHONE), DistanceOnlyDetector(BEEP, PHONE)
    alerts = [decision for decision in paper.run(ahead) if decision.alert]
    assert len(alerts) >= 1
    assert 2.0 < alerts[0].range_m <= 3.0
    assert alerts[0].time_to_collision_s == pytest.approx(alerts[0].range_m / 1.4, rel=0.1)
    assert not any(decision.alert for decision in paper.run(aside))
    assert any(decision.alert for decision in baseline.run(aside))
    first = next(decision for decision in baseline.run(ahead) if decision.alert)
    assert 3.0 < first.range_m <= 4.0


def test_standing_in_front_of_a_wall_is_no_collision():
    decisions = PaperDetector(BEEP, PHONE).run(recording([Point(2.0)], beeps=20))
    assert len(decisions) == 20
    assert not any(decision.alert for decision in decisions)


def test_streaming_equals_batch_bit_for_bit():
    samples = recording([GROUND, Point(4.0, 0.2, gain=0.06)], beeps=14, speed_m_s=1.3, noise=0.05)
    detector = PaperDetector(BEEP, PHONE)
    streamed = list(detector.stream(samples))
    repeated = detector.run(samples)
    detector.reset()
    blocks = samples.samples.reshape(2, -1, BEEP.period_samples)
    by_hand = [detector.process(blocks[:, k], k * BEEP.period_samples / BEEP.sample_rate_hz) for k in range(14)]
    assert len(streamed) == 14
    for one, two, three in zip(streamed, repeated, by_hand, strict=True):
        assert np.array_equal(one.range_m, three.range_m)
        assert np.array_equal(one.bearing_rad, three.bearing_rad, equal_nan=True)
        assert np.array_equal(one.radius_m, three.radius_m, equal_nan=True)
        assert repr(one.decision) == repr(two) == repr(three.decision)


def test_body_detour_is_deducted():
    """The obstacle reaches microphone 1 only by way of a plane body 0.3 m behind it, seen in the direct sound too."""
    body = 0.3
    mics = PHONE.mics_m[:, 1]
    image = np.hypot(3.0 - (mics[1] - 2.0 * body), 0.5) - np.hypot(3.0 - mics[1], 0.5)
    obstacle = Point(3.0, 0.5, gain=0.1, detour_m=(0.0, image))
    reflected = Point(mics[1] - body, gain=0.5)
    found = _standing([obstacle, reflected])
    flagged = np.flatnonzero(found.flags & Flag.BODY_DEDUCTED)
    assert len(flagged) == 1
    assert found.range_m[flagged[0]] == pytest.approx(true_range(obstacle, 0.0, 0.0), abs=2e-3)
    assert found.bearing_rad[flagged[0]] == pytest.approx(_bearing(obstacle), abs=np.radians(3.0))


def test_identical_channels_fall_back_to_range_only():
    samples = record([Point(4.5, 1.5)], beeps=25, speed_m_s=1.4, noise=0.02)
    samples[1] = samples[0]
    detector = PaperDetector(BEEP, PHONE)
    blocks = samples.reshape(2, -1, BEEP.period_samples)
    detections = [detector.process(blocks[:, k]) for k in range(25)]
    assert all(Flag.IDENTICAL_CHANNELS in found.beep_flags for found in detections)
    received = [found for found in detections if len(found)]
    assert len(received) > 15
    assert all(np.isnan(found.bearing_rad).all() and np.isfinite(found.range_m).all() for found in received)
    assert all((found.flags & Flag.IDENTICAL_CHANNELS).all() for found in received)
    assert any(found.decision.alert for found in detections)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_deaf_second_microphone_leaves_the_range_as_identical_channels_do(noise):
    """Cause: with a deaf microphone 1 nothing ever collided, while identical channels were judged by range."""
    samples = record([Point(4.5, 1.5)], beeps=25, speed_m_s=1.4, noise=0.02)
    deaf = np.stack([samples[0], noise * np.random.default_rng(1).standard_normal(samples.shape[1])])
    one, other = (
        [*PaperDetector(BEEP, PHONE).stream(Recording(s, BEEP.sample_rate_hz))] for s in (deaf, samples[[0, 0]])
    )
    assert all(found.beep_flags is Flag.NO_SECOND_MIC for found in one)
    received = [found for found in one if len(found)]
    assert len(received) > 15
    assert all(np.isnan(found.bearing_rad).all() and (found.flags & Flag.NO_SECOND_MIC).all() for found in received)
    assert any(found.decision.alert for found in one)
    assert [found.decision.alert for found in one] == [found.decision.alert for found in other]


def test_silence_is_a_beep_not_heard():
    found = PaperDetector(BEEP, PHONE).process(np.zeros((2, BEEP.period_samples)))
    assert len(found) == 0
    assert Flag.NO_BEEP in found.beep_flags
    assert not found.decision.alert


def test_at_most_five_candidates_nearest_first():
    found = _standing([Point(1.0 + 0.7 * k, gain=0.1) for k in range(8)])
    assert len(found) == 5
    assert (np.diff(found.range_m) > 0.0).all()
    assert found.range_m[0] == pytest.approx(1.0 - 0.0705, abs=1e-3)


def test_radius_of_points_and_of_wide_echoes():
    """A point reads as a radius near 0; a tail of echoes 7 mm farther, half as strong, reads as wider."""
    point = _standing([Point(3.0)]).radius_m
    wide = _standing([Point(3.0), Point(3.02, gain=0.05), Point(3.04, gain=0.05)]).radius_m
    assert len(point) == len(wide) == 1
    assert point[0] < 0.05
    assert 0.15 < wide[0] < 1.0


@pytest.mark.parametrize("detector", [PaperDetector, DistanceOnlyDetector, TrackingDetector])
def test_a_refused_block_leaves_the_detector_as_it_was(detector):
    """Wrong blocks and times between good ones: one clear error each, and what follows as if they had not been."""
    walked = record([GROUND, Point(3.0, gain=0.1)], beeps=16, speed_m_s=1.3, noise=0.02)
    first, second, *later = np.split(walked, 16, axis=1)
    undisturbed, disturbed = detector(BEEP, PHONE), detector(BEEP, PHONE)
    undisturbed.process(first)
    disturbed.process(first.tolist())
    for block, time_s, message in (
        (np.full_like(second, np.nan), None, "a block must be finite, got 34560 NaN"),
        (second.astype(complex), None, "a block must be numbers, got array"),
        (second[:, 1:], None, "17280"),
        (second, np.nan, "time_s must be finite and within .*, got nan"),
        (second, 0.0, "later than the last block's 0.0 s, got 0.0 s"),
    ):
        with pytest.raises(ValueError, match=message):
            disturbed.process(block, time_s)
    for k, block in enumerate((second, *later), start=1):
        expected, found = undisturbed.process(block), disturbed.process(block)
        assert (found.index, found.time_s, found.decision) == (k, expected.time_s, expected.decision)
        np.testing.assert_array_equal(found.range_m, expected.range_m)
    assert len(found) >= 1  # at the end all three follow the point


def test_blocks_without_a_time_follow_the_last_that_had_one():
    detector = PaperDetector(BEEP, PHONE)
    block = record([Point(3.0)])
    times = [detector.process(block, time_s).time_s for time_s in (None, 7.0, None, None)]
    assert np.diff(times) == pytest.approx([7.0, BEEP.period_s, BEEP.period_s], abs=1e-9)


def test_a_calibrated_radius_follows_its_line_and_decides_by_it():
    """Radius by a line over the crest as printed (Fig. 11), collision angle by that radius."""
    point, line = Point(2.0, 0.3), {"errata": Errata(pulse_width_removed=False)}
    crest_m = np.diff(
        [_standing([point], PaperSettings(crest_radius=(0.1, slope), **line)).radius_m[0] for slope in (0.0, 1.0)]
    )
    assert crest_m > 0.0
    found = _standing([point], PaperSettings(crest_radius=(0.05, 2.0), **line))
    assert found.radius_m == pytest.approx(0.05 + 2.0 * crest_m, abs=1e-9)
    assert not found.flags[0] & Flag.NO_RADIUS
    assert _standing([point], PaperSettings.calibrated()).radius_m == pytest.approx([0.306], abs=0.005)
    with pytest.raises(ValueError, match="crest_radius must be two numbers, with the crest as printed"):
        PaperSettings(crest_radius=(0.1, 0.0))


def test_bad_input_is_one_clear_error():
    detector = PaperDetector(BEEP, PHONE)
    with pytest.raises(ValueError, match=r"192000.0 Hz, got 44100.0 Hz"):
        detector.run(replace(recording([]), sample_rate_hz=44_100.0))
    with pytest.raises(ValueError, match="two channels"):
        detector.process(np.zeros(BEEP.period_samples))
    with pytest.raises(ValueError, match="17280"):
        detector.process(np.zeros((2, 100)))
    with pytest.raises(ValueError, match="sound_speed_m_s must be from 250 to 450 m"):
        PaperDetector(BEEP, PHONE, sound_speed_m_s=-1.0)
    with pytest.raises(ValueError, match="pitch_rad"):
        PaperDetector(BEEP, PHONE, pitch_rad=np.pi / 2)
    with pytest.raises(ValueError, match="votes_needed"):
        PaperSettings(votes_needed=10)
    with pytest.raises(ValueError, match="one beep period"):
        PaperDetector(BEEP, PHONE, PaperSettings(far_m=20.0))
    with pytest.raises(NoBeepError):
        detector.run(recording([], direct=(0.0, 0.0)))


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"danger_m": np.nan}, "danger_m must be positive, got nan"),
        ({"evaluation_m": -1.0}, "evaluation_m must be positive, got -1.0"),
        ({"peak_window_s": 0.0}, "peak_window_s must be positive, got 0.0"),
        ({"cfar_factor": np.nan}, "cfar_factor must be finite and not negative, got nan"),
        ({"walker_half_width_m": -0.1}, "walker_half_width_m must be finite and not negative, got -0.1"),
        ({"gate_margin_m": np.inf}, "gate_margin_m must be finite and not negative, got inf"),
        ({"floor_db": np.nan}, "floor_db must be a level in dB, got nan"),
        ({"history_s": np.inf}, "static_age_s must be positive and below history_s, got 0.25 and inf"),
        ({"max_candidates": np.nan}, "max_candidates must be a whole number, 1 or more, got nan"),
        ({"direct_delay_s": 0.5}, "within 1.2 ms of its emission, got direct_delay_s = 0.5"),
        ({"direct_delay_s": np.nan}, "within 1.2 ms of its emission, got direct_delay_s = nan"),
    ],
)
def test_settings_that_would_silence_the_detector_are_refused(wrong, rule):
    """NaN compares as false with everything: with danger_m or cfar_factor NaN nothing was ever received or alerted
    to."""
    with pytest.raises(ValueError, match=rule):
        PaperDetector(BEEP, PHONE, PaperSettings(**wrong))


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"danger_m": "x"}, "danger_m must be a number, got 'x'"),
        ({"near_m": None}, "near_m must be a number, got None"),
        ({"direct_delay_s": "x"}, "direct_delay_s must be a number, got 'x'"),
        ({"votes_of": 9.5}, "votes_of must be a whole number, 1 or more, got 9.5"),
        ({"max_candidates": 2.5}, "max_candidates must be a whole number, 1 or more, got 2.5"),
        ({"peak_window_s": np.inf}, "peak_window_s must be finite, got inf"),
        ({"closing_speed_m_s": 1.0}, "closing_speed_m_s must be two numbers, got 1.0"),
        ({"body_distance_m": (0.1, "x")}, r"body_distance_m\[1\] must be a number, got 'x'"),
        ({"errata": "x"}, "errata must be of type Errata, got 'x'"),
    ],
)
def test_settings_of_another_type_are_refused_by_name(wrong, rule):
    """Cause: values were compared before their types were checked: TypeError and OverflowError, or an error within the
    first beep."""
    with pytest.raises(ValueError, match=rule):
        PaperSettings(**wrong)


@pytest.mark.parametrize("settings", [PaperSettings, TrackingSettings])
@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"direct_delay_s": np.nan}, "within 1.2 ms of its emission, got direct_delay_s = nan"),
        ({"direct_delay_s": -np.inf}, "within 1.2 ms of its emission, got direct_delay_s = -inf"),
        ({"direct_delay_s": 0.5}, "within 1.2 ms of its emission, got direct_delay_s = 0.5"),
        ({"direct_delay_s": True}, "direct_delay_s must be a number, got True"),
        ({"floor_db": 7000.0}, "floor_db must be at most 500 dB, got 7000.0"),
        ({"walker_half_width_m": 1e12}, "walker_half_width_m must be at most 10 m, got 1000000000000.0"),
    ],
)
def test_settings_are_refused_where_they_are_made(settings, wrong, rule):
    """Causes: a delay was refused by the detector alone; levels and widths overflowed in the first beep."""
    with pytest.raises(ValueError, match=rule):
        settings(**wrong)


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"second_mic_snr_db": 1e12}, "second_mic_snr_db must be at most 500 dB"),
        ({"second_mic_level_db": 1e12}, "second_mic_level_db must be at most 500 dB"),
        ({"closing_speed_m_s": (0.4, np.inf)}, r"closing_speed_m_s must be .* with high at most 100, got \(0.4, inf\)"),
        ({"body_distance_m": (0.1, np.inf)}, r"body_distance_m must be .* with high at most 10, got \(0.1, inf\)"),
    ],
)
def test_settings_without_bounds_are_refused(wrong, rule):
    """Cause: levels overflowed, and speeds without end did not fit memory, in the first beep."""
    with pytest.raises(ValueError, match=rule):
        PaperSettings(**wrong)


@pytest.mark.parametrize("detector", [PaperDetector, StandingDetector])
@pytest.mark.parametrize("given", ["x", TrackingSettings()])
def test_what_is_not_the_paper_s_settings_is_refused(detector, given):
    """Cause: the settings' type was not checked: AttributeError."""
    with pytest.raises(ValueError, match="settings must be of type PaperSettings, got "):
        detector(BEEP, PHONE, given)


def test_a_speaker_too_far_off_is_refused():
    """Its direct sound came after the window in which it is looked for: every beep was one not received."""
    far = PhoneGeometry("apart", [0.0, 0.6, 0.0], PHONE.mics_m)
    with pytest.raises(ValueError, match=r"within 1.2 ms of its emission, got direct_delay_s = 0.00154"):
        PaperDetector(BEEP, far)


def test_samples_of_any_real_type():
    """Compiled loops know no long double: it ended in numba's TypingError."""
    block = record([Point(3.0)])
    found = [PaperDetector(BEEP, PHONE).process(block.astype(kind)).range_m for kind in (np.float64, np.longdouble)]
    np.testing.assert_array_equal(*found)
    with pytest.raises(ValueError, match="samples must be numbers, got array"):
        Recording(block.astype(complex), BEEP.sample_rate_hz)


def test_a_beep_of_one_sample_is_refused():
    """Its only sample is the window's first, 0: the matched filter divided by an energy of 0."""
    with pytest.raises(ValueError, match="duration_s must be two samples or more"):
        BeepDesign(duration_s=1.0 / 192_000.0, gap_s=0.09)


def test_pitch_known_to_the_detector_corrects_the_bearing():
    """A phone pitched by 40 degrees, seen from above, is shorter: the obstacle at 30 degrees reads cos 30 cos 40.
    The flat stand-in lacks the height L sin 40, which Eq. 2 expects: 0.9 % of the cosine, 1.3 degrees."""
    pitch = np.radians(40.0)
    short = PhoneGeometry("pitched", PHONE.speaker_m * np.cos(pitch), PHONE.mics_m * np.cos(pitch))
    samples = record([Point(3.0, 1.7)], phone=short)
    expected = np.arctan2(1.7, 3.0 - short.mics_m[0, 1])
    known = PaperStandingDetector(BEEP, PHONE, pitch_rad=pitch).process(samples)
    unknown = PaperStandingDetector(BEEP, PHONE).process(samples)
    assert len(known) == len(unknown) == 1
    assert known.bearing_rad[0] == pytest.approx(expected, abs=np.radians(1.5))
    assert np.degrees(unknown.bearing_rad[0] - expected) > 10.0


def _with(**errata):
    return PaperSettings(errata=Errata(**errata))


OBSTACLE = Point(3.0, 1.0)
TRUE = _standing([OBSTACLE])


@pytest.mark.parametrize(
    ("switch", "field", "printed"),
    [
        ("one_way_range", "range_m", lambda: TRUE.range_m + np.hypot(3.0 - 0.0405, 1.0)),
        ("speaker_leg", "range2_m", lambda: TRUE.range_m + 0.5 * (TRUE.range2_m - TRUE.range_m)),
        ("given_sound_speed", "range_m", lambda: TRUE.range_m * 340.0 / 343.0),
    ],
)
def test_each_erratum_changes_what_it_should(switch, field, printed):
    assert getattr(_standing([OBSTACLE], _with(**{switch: False})), field) == pytest.approx(printed(), abs=2e-3)


def test_own_direct_peaks_shift_u():
    """Erratum `shared_start`: microphone 1 lies 8.1 cm farther from the speaker than microphone 0."""
    printed = _standing([OBSTACLE], _with(shared_start=False))
    shift = (printed.range2_m - printed.range_m) - (TRUE.range2_m - TRUE.range_m)
    assert len(printed) == 1
    assert shift[0] == pytest.approx(-(0.111 - 0.03), abs=1e-3)
    assert printed.range_m[0] < TRUE.range_m[0] - 5e-3


def test_sound_speed_costs_7_6_degrees_straight_ahead():
    """Erratum `given_sound_speed`: u = L x 340 / 343."""
    printed = _standing([Point(3.0)], _with(given_sound_speed=False))
    assert np.degrees(printed.bearing_rad[0]) == pytest.approx(7.6, abs=1.0)


def test_printed_crest_width_of_a_point_is_most_of_a_metre():
    """Erratum `pulse_width_removed`: DETECTOR's 0.8-1.0 m at 3 m, above the average of a quiet recording."""
    printed = _standing([Point(3.0)], _with(pulse_width_removed=False), noise=0.02)
    near = np.flatnonzero(np.abs(printed.range_m - (3.0 - 0.0705)) < 0.02)
    assert len(near) == 1
    assert 0.6 < printed.radius_m[near[0]] < 1.2
    assert TRUE.radius_m[0] < 0.1


def test_printed_rim_angle_never_collides():
    """Erratum `rim_angle`: with Eq. 3 and 4 as printed nothing ever does."""
    printed = PaperSettings(errata=Errata.as_printed())
    samples = recording([Point(5.0, gain=0.1)], beeps=30, speed_m_s=1.4)
    detections = list(PaperDetector(BEEP, PHONE, printed).stream(samples))
    assert len(detections) == 30
    assert not any(found.collides.any() for found in detections)
    wide = [Point(3.0), Point(3.02, gain=0.05), Point(3.04, gain=0.05)]
    assert _standing(wide, _with(walker_width=False)).collides.tolist() == [True]
    assert _standing(wide, _with(walker_width=False, rim_angle=False)).collides.tolist() == [False]


def test_reversed_replica_loses_the_echo():
    """Erratum `correlate_once`: nothing is compressed, so the direct sound smears over everything."""
    found = PaperStandingDetector(BEEP, PHONE, _with(correlate_once=False)).process(record([OBSTACLE]))
    near = np.abs(found.range_m - TRUE.range_m[0]) < 0.02
    assert not near.any()


def test_walker_width_widens_the_course():
    """Erratum `walker_width`: 0.15 m off the line of a thin pole is a hit for a body, a miss for a point."""
    pole = Point(1.5, 0.15)
    assert _standing([pole]).collides.all()
    assert not _standing([pole], _with(walker_width=False)).collides.any()


def test_fixed_windows_find_an_echo_several_times():
    """Erratum `separated_peaks`: the skirts of a clean echo pass the threshold in the windows beside its own."""
    ranges = np.linspace(3.0, 3.1, 12)
    counts = [len(_standing([Point(ahead)], _with(separated_peaks=False))) for ahead in ranges]
    assert min(counts) >= 1
    assert max(counts) > 1
    assert all(len(_standing([Point(ahead)])) == 1 for ahead in ranges)
