"""One beep to the peaks that may move: ringing and clutter taken away, a low threshold, both microphones.

The threshold is meant for a tracker: it lets some noise pass, which no straight approach explains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.background import ClutterMap, CoherentBackground
from obstaclewatch.beep import BeepDesign
from obstaclewatch.carrier_phase import second_channel
from obstaclewatch.echoes import Echoes, echoes_at, noise_amplitude, os_cfar_threshold, separated_peaks, sidelobe_floor
from obstaclewatch.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.pulse import rms_bandwidth_hz
from obstaclewatch.ranging import direct_sound, one_way_range
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.settings import PaperSettings

Array = NDArray[np.float64]

BACKGROUND_BEEPS = 16
"""Beeps in the coherent mean; an echo that moves leaves 1/16 of itself in its earlier places."""
CLUTTER_BEEPS = 12
CLUTTER_HALF_WIDTH_S = 0.25e-3
"""How far a standing echo may wander between beeps: 4.3 cm of range. Range-Doppler coupling makes gait look larger."""
CLUTTER_FACTOR = 1.6
"""How far above clutter a peak must stand. At 1.2 the ground's echo, which gait moves, captured tracks that crossed it:
18 of 44 false alerts on 200 rendered walks of the development split."""
SETTLING_BEEPS = 2
"""Beeps without candidates, for the background to be known."""
CFAR_HALF_WIDTH_S = 6e-3
CFAR_FACTOR = 1.8
"""Multiple of the local 60 % quantile: 1.7 times the rms envelope, which noise alone passes in 5 % of the cells."""
QUANTILE_TO_RMS = float(np.sqrt(-np.log(0.4)))
"""A Rayleigh envelope's 60 % quantile as a share of its rms."""
MOST_PEAKS = 20
GROUND_M = (1.0, 1.7)
"""Heights above the ground at which a phone may be held."""
GROUND_CONTRAST = 3.0
"""How far above the clutter's median the ground's echo must stand."""
USUAL_GROUND_M = 1.35
"""Where no echo stands out: 0.745 of 1.74 m of stature, and half a phone's length at 30 degrees."""


@dataclass(frozen=True)
class MovingPeaks:
    """Peaks of one beep, nearest first, as the chirp reads them: `range_doppler_s` ahead of their time.

    Attributes:
        range_m: (n,) from microphone 0.
        power: (n,) height squared over the local noise power; 1 is noise, and half of 2E/N0.
        range_std_m: (n,) from noise alone.
        second: (n, W) microphone 1 around each peak, see `carrier_phase`; NaN if both channels are the same.
        level_db: (n,) echo relative to the direct sound, at microphone 0.
        snr_db: (n,) 2E/N0 at microphone 0.
    """

    range_m: Array
    power: Array
    range_std_m: Array
    second: NDArray[np.complex64]
    level_db: Array
    snr_db: Array

    def __len__(self) -> int:
        return len(self.range_m)


class PeakFinder:
    """Compresses beeps and hands out what may move, with the memory that this needs.

    Args:
        beep: the emitted signal.
        phone: speaker and microphones.
        settings: reach of the listening, and the calibrated direct sound.
        sound_speed_m_s: speed of sound.
        pitch_rad: lift of the phone's top edge, for the height above the ground.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings,
        sound_speed_m_s: float,
        pitch_rad: float = 0.0,
    ) -> None:
        self._settings, self._c = settings, sound_speed_m_s
        self._filter = MatchedFilter(beep, 2.0 * settings.far_m / sound_speed_m_s + 2e-3)
        self._bandwidth_hz = rms_bandwidth_hz(beep)
        self._baseline_m = float(phone.speaker_to_mic_m[0])
        calibrated = settings.direct_delay_s
        self._direct_delay_s = self._baseline_m / sound_speed_m_s if calibrated is None else calibrated
        self._background = CoherentBackground(BACKGROUND_BEEPS)
        self._clutter = ClutterMap(CLUTTER_BEEPS, round(CLUTTER_HALF_WIDTH_S * self._filter.rate_hz))
        # As many samples in every beep: rounding both ends of the reach apart would give the map one more or one less.
        self._span = round(2.0 * (settings.far_m - settings.near_m) / sound_speed_m_s * self._filter.rate_hz) + 1
        self._heard = 0
        self._sin_pitch = float(np.sin(pitch_rad))
        self.ground_m = USUAL_GROUND_M

    @property
    def wavelength_m(self) -> float:
        """Of the carrier whose phase `carrier_u_m` is read from."""
        return self._c / self._filter.reference_hz

    def reset(self) -> None:
        """Forget all beeps."""
        self._background.clear()
        self._clutter.clear()
        self._heard = 0
        self.ground_m = USUAL_GROUND_M

    def find(self, block: NDArray[np.floating]) -> tuple[float, MovingPeaks] | None:
        """Emission relative to the block's first sample, s, and the peaks; None if there is no beep."""
        profile = self._filter.compress(block)
        direct = direct_sound(profile)
        if not direct.found:
            return None
        start_s = float(direct.delay_s[0]) - self._direct_delay_s
        rest = EchoProfile(
            self._background.subtract(profile.envelope), profile.start_s, profile.rate_hz, profile.reference_hz
        )
        self._heard += 1
        near = profile.position(start_s + 2.0 * self._settings.near_m / self._c)
        first = min(near, profile.envelope.shape[1] - self._span)
        self._sound_the_ground(profile.start_s + first / profile.rate_hz - start_s)
        echoes, noise = self._echoes(rest, first, float(direct.amplitude[0]))
        return start_s, self._measured(rest, echoes, noise, start_s, float(direct.amplitude[0]), first, block)

    def _echoes(self, rest: EchoProfile, first: int, direct: float) -> tuple[Echoes, Array]:
        """The strongest peaks above clutter and noise, nearest first, and the rms of the noise at each."""
        heard = rest.magnitude[0, first : first + self._span]
        clutter = self._clutter.level(heard)
        if self._heard <= SETTLING_BEEPS:
            return echoes_at(rest, 0, np.empty(0, dtype=np.intp)), np.empty(0)
        local = os_cfar_threshold(heard, 1.0, round(CFAR_HALF_WIDTH_S * rest.rate_hz))
        least = np.maximum(CFAR_FACTOR * local, sidelobe_floor(heard, round(1e-3 * rest.rate_hz)))
        floor = direct * 10.0 ** (self._settings.floor_db / 20.0)
        threshold = np.maximum(np.maximum(least, CLUTTER_FACTOR * clutter), floor)
        peaks = separated_peaks(heard, threshold, round(0.35e-3 * rest.rate_hz))
        strongest = np.sort(peaks[np.argsort(-heard[peaks] / local[peaks], kind="stable")[:MOST_PEAKS]])
        return echoes_at(rest, 0, strongest + first), np.maximum(local[strongest] / QUANTILE_TO_RMS, 1e-3 * floor)

    def _sound_the_ground(self, first_s: float) -> None:
        """Height of microphone 0 above the ground: where clutter is strongest, if it stands out."""
        clutter = self._clutter.mean
        if clutter is None:
            return
        low, high = (round((2.0 * height / self._c - first_s) * self._filter.rate_hz) for height in GROUND_M)
        window = clutter[low:high]
        strongest = float(window.max())
        if strongest > GROUND_CONTRAST * np.median(clutter):
            middle = low + float(np.flatnonzero(window > 0.8 * strongest).mean())  # the map's peaks are widened
            path_m = self._c * (first_s + middle / self._filter.rate_hz)
            self.ground_m = float(one_way_range(path_m, self._baseline_m, self._sin_pitch))

    def _measured(
        self,
        rest: EchoProfile,
        echoes: Echoes,
        noise: Array,
        start_s: float,
        direct: float,
        first: int,
        block: NDArray[np.floating],
    ) -> MovingPeaks:
        power = (echoes.amplitude / noise) ** 2
        noise2 = max(noise_amplitude(rest.magnitude[1, first:]), np.finfo(float).tiny) if len(echoes) else 1.0
        second = second_channel(rest, echoes.delay_s, noise2, self._c)
        if np.array_equal(block[0], block[1]):
            second = np.full_like(second, np.nan)
        one_m = self._c / (2.0 * np.pi * self._bandwidth_hz)
        return MovingPeaks(
            range_m=one_way_range(self._c * (echoes.delay_s - start_s), self._baseline_m, -1.0),
            power=power,
            range_std_m=0.5 * one_m / np.sqrt(2.0 * power),
            second=second,
            level_db=20.0 * np.log10(echoes.amplitude / direct),
            snr_db=10.0 * np.log10(2.0 * power),
        )
