"""Is a recording fit for a detector? One look at its first seconds, one named finding for each thing that is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import BeepFinder, NoBeepError
from obstaclewatch.recordings.beep_identification import DetectedBeep, detected_beep
from obstaclewatch.recordings.calibration import AIR_M_S, Calibration, calibrate
from obstaclewatch.recordings.channel_faults import absurd_level, coarse_steps, constant_offset, inverted_channel
from obstaclewatch.recordings.faults import Fault, Finding
from obstaclewatch.recordings.sample_faults import (
    ZERO_RUN_S,
    clipped_share,
    gain_dip_db,
    longest_zero_runs,
    one_is_the_other,
)
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.support.argument_types import check_types
from obstaclewatch.support.arrays import Floats, Singles

CLIPPED_SHARE = 2e-3
"""Share of the beep's samples at its extremes; clipping by 0.3 dB leaves 10e-3, a clean beep at most 0.1e-3."""
LIMITER_DB = 1.5
LIMITER_DEVIATIONS = 6.0
STEP_SAMPLES = 0.6
"""Jump of the direct sound from beep to beep that says samples are missing; clean recordings move by 0.01."""
LONE_STEP_SAMPLES = 1.5
"""The same where one microphone alone shows it: a wall that is walked into moves it by one."""
SETTLED_BEEPS = 3
"""Beeps later the jump is read in full: a beep that is damaged itself reads anything."""
ALIKE_SAMPLES, ALIKE_SHARE = 0.3, 0.1
"""How far the two microphones may differ in it: what is lost is lost to both, while an obstacle so near that its echo
runs into the direct sound shifts each differently."""
LEAST_PPM = 20.0
"""Clock drift that is reported; clean walks of 15 beeps read less than 1 ppm."""
MANY_BEEPS = 8
"""Beeps without which the clock's drift is not distinguished from a gap, nor deafness from walking into something."""
DEAF_DB, DEAF_S = -60.0, 0.2e-3
"""Level of the direct sound against microphone 0's below which, and median deviation of its delay beyond which it is
not received: phones have -8 to -35 dB and 0.01 ms, noise alone 0.6 ms, since it is highest anywhere."""
SWAPPED_S = 5e-6
SWAPPED_DB = 2.0
LATE_S = 40e-6
"""Beyond the path through air: an echo beside the phone that runs into the direct sound shifts it by less."""
OTHER_RATE = 0.15
"""Share by which the sweep may be faster or slower than designed; phones that swallow an edge read 0.03 off."""
OUTSIDE_SHARE = 0.08
"""Share of the bandwidth by which the core of the received energy may lie outside the design's band. What a phone's
response swallows of the band is no sign of another beep; energy where none was played is."""
OTHER_PERIOD = 0.01
MID_BEEP_ENERGY = 0.05
"""Share of a beep's energy before the first complete beep that shows that the recording began in one."""


@dataclass(frozen=True)
class RecordingHealth:
    """What was found.

    Attributes:
        findings: empty for a clean recording; where the beep is missing or another one, that alone.
        detected: the beep that repeats in the recording; None if none does.
        calibration: what the direct sound shows; None without a beep.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, PhoneGeometry, Recording, inspect_recording
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> health = inspect_recording(Recording(np.zeros((2, 40_000)), 192_000.0), BeepDesign(), phone)
    >>> health.usable, [finding.fault.label for finding in health.findings]
    (False, ['no beep'])
    """

    findings: tuple[Finding, ...]
    detected: DetectedBeep | None
    calibration: Calibration | None

    @property
    def faults(self) -> frozenset[Fault]:
        """Which faults were found."""
        return frozenset(finding.fault for finding in self.findings)

    @property
    def usable(self) -> bool:
        """No finding is fatal."""
        return not any(finding.fault.fatal for finding in self.findings)

    def lines(self) -> list[str]:
        """For people: the findings, and what was calibrated."""
        lines = [str(finding) for finding in self.findings] or ["recording: nothing wrong found"]
        if self.detected is not None:
            lines.append(f"beep received: {self.detected}")
        if self.calibration is not None:
            lines.extend(_calibration_lines(self.calibration, Fault.DEAF_MICROPHONE in self.faults))
        return lines


def inspect_recording(recording: Recording, beep: BeepDesign, phone: PhoneGeometry) -> RecordingHealth:
    """Look for everything that spoils a recording, and calibrate what can be.

    Ten seconds are plenty. NaN, mono and truncated files never become a `Recording`: see there and `read_recording`.

    Args:
        recording: at the beep's rate.
        beep: the beep that should be in it.
        phone: speaker and microphones.

    Raises:
        ValueError: an argument of another type, or the recording's rate is not the beep's.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, inspect_recording, PhoneGeometry, Recording
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(6 * beep.period_samples) / beep.sample_rate_hz
    >>> samples = [0.1 * beep.waveform((time_s - d / 343) % beep.period_s) for d in (0.0, 0.14)]
    >>> inspect_recording(Recording(samples, beep.sample_rate_hz), beep, phone).usable
    True
    """
    check_types(recording=(recording, Recording), beep=(beep, BeepDesign), phone=(phone, PhoneGeometry))
    absurd = absurd_level(recording)
    if absurd is not None:
        return RecordingHealth((absurd,), None, None)
    detected = detected_beep(recording.samples[0], recording.sample_rate_hz)
    try:
        calibration = calibrate(recording, beep, phone)
    except NoBeepError:
        return RecordingHealth((_without_beep(recording, beep, detected),), detected, None)
    other = _other_beep(detected, calibration, beep)
    if other is not None:
        return RecordingHealth((other,), detected, calibration)
    same = one_is_the_other(recording.samples)
    findings = [
        *_channels(recording, calibration, phone, same),
        _clipped(recording, beep),
        _limited(recording, calibration, beep),
        _dropped(recording, calibration, beep, same),
        _clock_drift(calibration, beep),
        _mid_beep_start(recording, calibration, beep),
        constant_offset(recording),
        coarse_steps(recording),
    ]
    return RecordingHealth(tuple(f for f in findings if f is not None), detected, calibration)


def _without_beep(recording: Recording, beep: BeepDesign, detected: DetectedBeep | None) -> Finding:
    left = _left_of_first(recording, beep)
    if left < beep.period_samples:
        left_s = left / recording.sample_rate_hz
        return Finding(
            Fault.NO_BEEP,
            f"the recording ends {left_s:.3f} s after the first begins, and a period lasts {beep.period_s:.3f} s",
        )
    swapped = Recording(recording.samples[::-1], recording.sample_rate_hz)
    try:
        BeepFinder(beep, 0.0).first_emission(swapped.samples)
        if not recording.samples[0].any():
            return Finding(Fault.NO_BEEP, "microphone 0 (top) recorded zeros, microphone 1 receives the beep")
        return Finding(
            Fault.NO_BEEP, "microphone 0 (top) receives none, microphone 1 does: is the first channel the top?"
        )
    except NoBeepError:
        pass
    if detected is not None:
        return Finding(Fault.OTHER_BEEP, f"expected {_designed(beep)}, received {detected}")
    return Finding(Fault.NO_BEEP, f"expected {_designed(beep)}, nothing of the kind repeats in the recording")


def _left_of_first(recording: Recording, beep: BeepDesign) -> float:
    """Samples from the first beep at microphone 0 to the end; infinite without any."""
    try:
        return recording.samples.shape[1] - BeepFinder(beep, 0.0).first_emission(recording.samples)
    except NoBeepError:
        return np.inf


def _other_beep(detected: DetectedBeep | None, calibration: Calibration, beep: BeepDesign) -> Finding | None:
    """A beep so like the design that it was found, yet another. Gaps may spoil the period received, but not both."""
    if detected is None:
        return None
    rate = abs(detected.chirp_rate_hz_s / beep.chirp_rate_hz_s - 1.0)
    low, high = sorted((beep.start_hz, beep.stop_hz))
    outside = max(low - detected.core_hz[0], detected.core_hz[1] - high) / (high - low)
    found_s = np.diff(calibration.emission_s)
    periods = np.array([detected.period_s, np.median(found_s) if len(found_s) else np.inf]) / beep.period_s
    if rate <= OTHER_RATE and outside <= OUTSIDE_SHARE and np.abs(periods - 1.0).min() <= OTHER_PERIOD:
        return None
    return Finding(Fault.OTHER_BEEP, f"expected {_designed(beep)}, received {detected}")


def _channels(recording: Recording, calibration: Calibration, phone: PhoneGeometry, same: bool) -> list[Finding | None]:
    if same:
        return [Finding(Fault.IDENTICAL_CHANNELS, "one is a multiple of the other: no bearing, range only")]
    if not recording.samples[1].any():
        return [Finding(Fault.DEAF_MICROPHONE, "microphone 1 recorded zeros: no bearing, range only")]
    if _is_deaf(calibration):
        return [Finding(Fault.DEAF_MICROPHONE, _no_difference(calibration))]
    return [_swapped(calibration, phone) or _late(calibration, phone), inverted_channel(recording)]


def _no_difference(calibration: Calibration) -> str:
    return (
        "microphone 1 does not receive the speaker, "
        f"{calibration.mic_gain_db:.0f} dB against microphone 0 where it should: no bearing, range only"
    )


def _is_deaf(calibration: Calibration) -> bool:
    """Whether what is loudest at microphone 1 around the direct sound is not that."""
    later_s = calibration.drift_s[:, 1] - calibration.drift_s[:, 0]
    scatter_s = float(np.median(np.abs(later_s - np.median(later_s))))
    return calibration.mic_gain_db < DEAF_DB or (len(later_s) >= MANY_BEEPS and scatter_s > DEAF_S)


def _swapped(calibration: Calibration, phone: PhoneGeometry) -> Finding | None:
    """The speaker's own microphone must receive it first and loudest."""
    own = phone.speaker_to_mic_m
    if own[0] >= own[1] or calibration.mic_delay_s > -SWAPPED_S or calibration.mic_gain_db < SWAPPED_DB:
        return None
    return Finding(
        Fault.SWAPPED_CHANNELS,
        f"microphone 1 receives the speaker {-calibration.mic_delay_s * 1e6:.0f} us before microphone 0 and "
        f"{calibration.mic_gain_db:.1f} dB louder, though {own[1] - own[0]:.3f} m farther from it",
    )


def _late(calibration: Calibration, phone: PhoneGeometry) -> Finding | None:
    """No sound takes longer between the microphones than through cold air."""
    own = phone.speaker_to_mic_m
    longest_s = abs(float(own[1] - own[0])) / AIR_M_S[0] + LATE_S
    if abs(calibration.mic_delay_s) <= longest_s:
        return None
    return Finding(
        Fault.LATE_CHANNEL,
        f"microphone 1 receives the speaker {calibration.mic_delay_s * 1e6:+.0f} us after microphone 0, where the air "
        f"takes {longest_s * 1e6:.0f} us at most: no bearing, range only",
    )


def _clipped(recording: Recording, beep: BeepDesign) -> Finding | None:
    sounding = round(recording.samples.shape[1] * beep.duration_s / beep.period_s)
    share = clipped_share(recording.samples, sounding)
    worst = int(np.argmax(share))
    if share[worst] < CLIPPED_SHARE:
        return None
    top = float(np.abs(recording.samples[worst]).max())
    return Finding(
        Fault.CLIPPED,
        f"microphone {worst} holds {share[worst]:.1%} of its beeps at {top:.3g} of full scale: play softer",
    )


def _limited(recording: Recording, calibration: Calibration, beep: BeepDesign) -> Finding | None:
    periods = _full_periods(recording, calibration, beep)
    for mic in range(2):
        depth, deviation = gain_dip_db(periods[:, mic], beep)
        if depth > max(LIMITER_DB, LIMITER_DEVIATIONS * deviation):
            return Finding(
                Fault.LIMITED,
                f"microphone {mic}'s noise sinks by {depth:.1f} dB while a beep sounds: levels are not to be trusted",
            )
    return None


def _dropped(recording: Recording, calibration: Calibration, beep: BeepDesign, same: bool) -> Finding | None:
    rate = recording.sample_rate_hz
    trend_s = _clock_ratio(calibration) * (calibration.emission_s - calibration.emission_s[0])
    drift = (calibration.drift_s - trend_s[:, None]) * rate
    alone = same or _is_deaf(calibration)
    steps = _steps_that_stay(drift[:, [0, 0]], LONE_STEP_SAMPLES) if alone else _steps_that_stay(drift, STEP_SAMPLES)
    jumps = np.flatnonzero(steps)
    if len(jumps):
        first = int(jumps[0])
        return Finding(
            Fault.DROPPED_SAMPLES,
            f"the beat of the beeps jumps by {steps[first]:+.0f} samples after "
            f"{max(calibration.emission_s[first], 0.0):.2f} s",
        )
    begin, end = (round(edge * rate) for edge in calibration.emission_s[[0, -1]])
    runs = longest_zero_runs(recording.samples[:, max(begin, 0) : end])
    for mic, (start, length) in enumerate(runs):
        if recording.samples[mic].any() and length >= ZERO_RUN_S * rate and _stands_out(recording, mic, begin + start):
            return Finding(
                Fault.DROPPED_SAMPLES,
                f"microphone {mic} holds {length} zeros in a row at {(begin + start) / rate:.2f} s",
            )
    return _missing(calibration, beep)


def _steps_that_stay(drift: Floats, least: float) -> Floats:
    """(K,) by how many samples the beeps have left their place `SETTLED_BEEPS` after each, at both microphones (K, 2).

    0 where they do not stay there for as many beeps more, or for the last ones, two or more: an echo that runs into the
    direct sound comes and goes.
    """
    found = np.zeros(len(drift))
    for beep in range(len(drift) - SETTLED_BEEPS - 1):
        steps = drift[beep + SETTLED_BEEPS : beep + 2 * SETTLED_BEEPS] - drift[beep]
        one, other = steps.mean(axis=0)
        stays = (np.sign(one) * steps > least).all()
        if stays and abs(one - other) < max(ALIKE_SAMPLES, ALIKE_SHARE * abs(one)):
            found[beep] = one
    return found


def _missing(calibration: Calibration, beep: BeepDesign) -> Finding | None:
    """Beeps that are not there between others that are at their places."""
    lost = np.round(np.diff(calibration.emission_s) / beep.period_s).astype(int) - 1
    if not (lost > 0).any() or _clock_ratio(calibration) != 0.0:  # beeps that leave their place are passed by
        return None
    first = calibration.emission_s[int(np.argmax(lost > 0))] + beep.period_s
    return Finding(Fault.MISSING_BEEPS, f"{int(lost.sum())} beeps are missing, the first at {max(first, 0.0):.2f} s")


def _clock_ratio(calibration: Calibration) -> float:
    """Share by which the beeps' period is received longer than designed; 0 if too few or too irregular to be a clock's.

    The median over a quarter of the beeps each, of which one gap spoils a third.
    """
    count = len(calibration.drift_s)
    if count < MANY_BEEPS:
        return 0.0
    span = count // 4
    elapsed_s = calibration.emission_s[span:] - calibration.emission_s[:-span]
    ratio = (calibration.drift_s[span:, 0] - calibration.drift_s[:-span, 0]) / elapsed_s
    middle = float(np.median(ratio))
    is_steady = np.median(np.abs(ratio - middle)) < 0.5 * abs(middle) < 0.5 * OTHER_PERIOD
    return middle if is_steady else 0.0


def _clock_drift(calibration: Calibration, beep: BeepDesign) -> Finding | None:
    ppm = 1e6 * _clock_ratio(calibration)
    if abs(ppm) < LEAST_PPM:
        return None
    return Finding(
        Fault.CLOCK_DRIFT,
        f"the beeps' period is {ppm:+.0f} ppm off: another clock plays than records, or samples are lost in every "
        "beep; where the beeps have left their place they are searched for anew",
    )


def _stands_out(recording: Recording, mic: int, start: int) -> bool:
    """Zeros are damage where the recorder's noise is there otherwise: in a simulated gap they are not."""
    before = recording.samples[mic, max(start - round(ZERO_RUN_S * recording.sample_rate_hz), 0) : start]
    return bool(np.mean(recording.samples[mic] == 0.0) < 0.1 and (before != 0.0).any())


def _mid_beep_start(recording: Recording, calibration: Calibration, beep: BeepDesign) -> Finding | None:
    first = round(calibration.emission_s[0] * recording.sample_rate_hz)
    tail = first - round(beep.gap_s * recording.sample_rate_hz)
    if tail <= 0:
        return None
    probe = MatchedFilter(beep, 1e-3, lead_s=0.0)
    energy = [
        _energy(probe, recording.samples[:1, begin : begin + length])
        for begin, length in ((0, tail), (first, beep.period_samples))
    ]
    if energy[0] < MID_BEEP_ENERGY * energy[1]:
        return None
    return Finding(Fault.MID_BEEP_START, f"the first complete beep is at {calibration.emission_s[0]:.3f} s")


def _energy(probe: MatchedFilter, piece: Singles) -> float:
    """Energy of the beep's band in a piece of at most one period."""
    padded = np.zeros((1, probe.block_samples), dtype=np.float32)
    padded[:, : piece.shape[1]] = piece[:, : probe.block_samples]
    return float(np.sum(np.abs(probe.band_signal(padded)) ** 2))


def _full_periods(recording: Recording, calibration: Calibration, beep: BeepDesign) -> Singles:
    """(K, 2, period_samples) from each emission on."""
    starts = np.maximum(np.round(calibration.emission_s * recording.sample_rate_hz).astype(int), 0)
    complete = starts[starts + beep.period_samples <= recording.samples.shape[1]]
    return np.stack([recording.samples[:, start : start + beep.period_samples] for start in complete])


def _designed(beep: BeepDesign) -> str:
    band = (beep.start_hz, beep.stop_hz)
    return str(DetectedBeep(*band, beep.duration_s, beep.period_s, band))


def _calibration_lines(calibration: Calibration, deaf: bool) -> list[str]:
    low, high = calibration.usable_band_hz(0)
    speed = calibration.sound_speed_m_s
    shown = f"{speed:.0f} m/s" if np.isfinite(speed) else "not observable, the direct sound comes through the case"
    balance = (
        f"microphone 1 receives the speaker {calibration.mic_delay_s * 1e6:+.0f} us and "
        f"{calibration.mic_gain_db:+.1f} dB against microphone 0"
    )
    return [
        *([] if deaf else [balance]),
        f"direct sound within 10 dB of its best from {low / 1e3:.1f} to {high / 1e3:.1f} kHz; "
        f"beep to beep {calibration.beep_to_beep_db[0]:.2f} dB",
        f"speed of sound: {shown}",
    ]
