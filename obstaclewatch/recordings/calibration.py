"""What the direct sound of a recording shows of the phone that made it: clock, balance, response.

| quantity | observable from the recording |
|---|---|
| emission of the beeps, rate of the clock | yes: the direct peaks of all beeps |
| level and delay of microphone 1 against 0 | yes, with the path from the speaker and through the case in it |
| response of speaker and microphones | as it shapes the direct sound, not the echo: another direction |
| speed of sound | only if the direct sound comes through the air; sound in the case is faster, and says so |
| delay of the direct sound after emission | no: it is the origin of the clock |
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import BeepFinder, NoBeepError
from obstaclewatch.signal.direct_sound import direct_sound
from obstaclewatch.signal.matched_filter import MatchedFilter
from obstaclewatch.support.argument_types import check_types
from obstaclewatch.support.arrays import Complexes, Floats

AIR_M_S = (310.0, 365.0)
"""Speeds of sound in air between -35 and 50 C; a direct sound that seems to travel faster came through the case."""
NOMINAL_M_S = 343.0
DIRECT_GATE_S = (-0.7e-3, 0.9e-3)
"""Around the direct peak: the pulse, and no echo from beyond 15 cm."""
RESPONSE_STEP_HZ = 250.0


@dataclass(frozen=True)
class Calibration:
    """The direct sound of K beeps.

    Attributes:
        emission_s: (K,) when each beep was emitted, s from the start of the recording; the path from speaker to
            microphone 0 through the air is assumed.
        drift_s: (K, 2) how far each direct sound at each microphone lies off the first one plus full periods.
        level: (K, 2) height of the direct peak at each microphone, relative to full scale.
        mic_delay_s: microphone 1's direct sound after microphone 0's, median; NaN if it is deaf.
        mic_gain_db: microphone 1's direct sound over microphone 0's, median; -inf if it is deaf.
        sound_speed_m_s: from the direct sound's path between the microphones; NaN if it is no speed of sound in air.
        response_hz: (F,) frequencies within the beep's band.
        response_db: (2, F) direct sound over the beep's own spectrum, 0 dB at its highest, smoothed over 0.6 kHz by
            the gate that keeps echoes out.
    """

    emission_s: Floats
    drift_s: Floats
    level: Floats
    mic_delay_s: float
    mic_gain_db: float
    sound_speed_m_s: float
    response_hz: Floats
    response_db: Floats

    @property
    def beep_to_beep_db(self) -> Floats:
        """(2,) standard deviation of the direct level; 0 for a deaf microphone."""
        return np.std(20.0 * np.log10(np.maximum(self.level, np.finfo(float).tiny)), axis=0)

    def usable_band_hz(self, mic: int) -> tuple[float, float]:
        """Lowest and highest frequency at which a microphone's response is within 10 dB of its best."""
        received = self.response_hz[self.response_db[mic] >= -10.0]
        return float(received[0]), float(received[-1])


def calibrate(recording: Recording, beep: BeepDesign, phone: PhoneGeometry) -> Calibration:
    """Follow the direct sound through a recording.

    Where samples were dropped the beep is searched for anew, so that later beeps are still found.

    Args:
        recording: at the beep's rate.
        beep: the emitted signal.
        phone: speaker and microphones.

    Raises:
        NoBeepError: no complete beep.
        ValueError: the recording's rate is not the beep's.
    """
    check_types(recording=(recording, Recording), beep=(beep, BeepDesign), phone=(phone, PhoneGeometry))
    if recording.sample_rate_hz != beep.sample_rate_hz:
        raise ValueError(f"the recording's rate must be {beep.sample_rate_hz} Hz, got {recording.sample_rate_hz} Hz")
    finder = BeepFinder(beep, float(phone.speaker_to_mic_m[0]) / NOMINAL_M_S)
    compressor = MatchedFilter(
        beep, beep.period_s
    )  # all delays: where a direct sound is lost, the strongest is elsewhere
    rows, spectra = [], []
    begin = finder.first_emission(recording.samples)
    while begin + beep.period_samples <= recording.samples.shape[1]:
        profile = compressor.compress(recording.samples[:, begin : begin + beep.period_samples])
        direct = direct_sound(profile)
        if direct.found:
            rows.append((begin / recording.sample_rate_hz, *direct.delay_s, *direct.amplitude))
            spectra.append(_gated_power(profile.envelope, profile.position(direct.delay_s[0]), profile.rate_hz))
            begin += beep.period_samples
            continue
        try:
            begin = max(finder.first_emission(recording.samples, begin), begin + 1)
        except NoBeepError:
            break
    if not rows:
        raise NoBeepError("the recording holds no complete beep: less than one period after the first direct sound")
    return _calibration(np.array(rows), np.mean(spectra, axis=0), compressor, beep, phone)


def _calibration(
    rows: Floats, power: Floats, compressor: MatchedFilter, beep: BeepDesign, phone: PhoneGeometry
) -> Calibration:
    """From rows of (block start, two delays, two heights) and the direct sound's mean power spectrum."""
    emission = rows[:, 0] + rows[:, 1] - float(phone.speaker_to_mic_m[0]) / NOMINAL_M_S
    periods = np.round((emission - emission[0]) / beep.period_s)
    direct = rows[:, :1] + rows[:, 1:3]
    level = rows[:, 3:5]
    gain = np.median(level[:, 1] / level[:, 0])
    delay = float(np.median(rows[:, 2] - rows[:, 1])) if gain > 0.0 else np.nan
    path_m = float(phone.speaker_to_mic_m[1] - phone.speaker_to_mic_m[0])
    speed = path_m / delay if delay > 0.0 and path_m > 0.0 else np.nan
    frequency, response = _response(power, compressor, beep)
    return Calibration(
        emission_s=emission,
        drift_s=direct - direct[0] - periods[:, None] * beep.period_s,
        level=level,
        mic_delay_s=delay,
        mic_gain_db=float(20.0 * np.log10(gain)) if gain > 0.0 else -np.inf,
        sound_speed_m_s=speed if AIR_M_S[0] <= speed <= AIR_M_S[1] else np.nan,
        response_hz=frequency,
        response_db=response,
    )


def _gated_power(envelope: Complexes, center: int, rate_hz: float) -> Floats:
    """(2, n) power spectrum of the direct sound's compressed pulse, under a Hann gate of `DIRECT_GATE_S`."""
    first, last = (center + round(edge * rate_hz) for edge in DIRECT_GATE_S)
    index = np.arange(max(first, 0), min(last + 1, envelope.shape[1]))
    gate = np.sin(np.pi * (index - first + 0.5) / (last - first + 1)) ** 0.5
    return np.abs(fft.fft(envelope[:, index] * gate, _gate_bins(rate_hz))) ** 2


def _gate_bins(rate_hz: float) -> int:
    return int(fft.next_fast_len(round(rate_hz / RESPONSE_STEP_HZ)))


def _response(power: Floats, compressor: MatchedFilter, beep: BeepDesign) -> tuple[Floats, Floats]:
    """(F,) frequencies and (2, F) levels of the direct sound over the beep's own pulse, gated alike."""
    block = np.zeros((1, beep.period_samples))
    block[0, : len(beep.samples())] = beep.samples()
    own = compressor.compress(block)
    reference = _gated_power(own.envelope, own.position(0.0), own.rate_hz)[0]
    offset = fft.fftfreq(len(reference), 1.0 / own.rate_hz)
    order = np.argsort(offset)
    frequency = offset[order] + own.reference_hz
    low, high = sorted((beep.start_hz, beep.stop_hz))
    inside = (frequency >= low) & (frequency <= high) & (reference[order] > 1e-4 * reference.max())
    level = 10.0 * np.log10(np.maximum(power[:, order][:, inside], 1e-300) / reference[order][inside])
    return frequency[inside], level - level.max(axis=1, keepdims=True)
