"""From one beep's samples to its candidates' range, bearing and size: the stages that the paper's detectors share."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Flag
from obstaclewatch.paper.bearing import PathDifference, bearing_std, body_distance, path_difference, walking_angle
from obstaclewatch.paper.body_path import nearest_body_path
from obstaclewatch.paper.clutter import Motion, PeakHistory, check_memory, judge_motion
from obstaclewatch.paper.measurement import Measurement, nothing_measured
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.paper.size import Size, printed_rim_excess, rim_excess, size_from_crest, size_from_radius
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.sample_faults import flag_of_second
from obstaclewatch.recordings.streaming import checked_arguments, reach_s
from obstaclewatch.signal.damaged_beeps import DamagedBeeps
from obstaclewatch.signal.direct_sound import DirectSound, direct_sound, expected_direct_delay_s
from obstaclewatch.signal.echoes import (
    Echoes,
    above_sidelobes,
    echoes_at,
    highest_of_windows,
    keep_separated,
    local_maxima,
    mean_threshold,
    noise_amplitude,
    os_cfar_passes,
    separated_peaks,
)
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.signal.pulse import pulse_shape
from obstaclewatch.signal.two_mics import cone_cosine, ranges_of_pairs
from obstaclewatch.support.arrays import Flags, Floats

PRINTED_SOUND_SPEED_M_S = 340.0
"""Section 3.4, "assuming the speed of sound is 340m/s"; section 3.3 uses 343."""
CFAR_HALF_WIDTH_S = 4e-3
"""Reference window of the OS-CFAR on either side: ten times the pulse."""
SIDELOBE_HALF_WIDTH_S = 2e-3
"""How far sidelobes reach at that height: at rest they are 95 dB down after 1 ms, at 1.3 m/s 113 dB after 3 ms."""
SEPARATION_SHARE = 0.7
"""Least separation of two peaks as a share of the 0.5 ms window: 0.35 ms, the pulse's -3 dB width."""


class Placed(NamedTuple):
    """Where n candidates are: (n,) each, as in `Measurement`; `clamped` where Eq. 2 left arccos's domain."""

    range_m: Floats
    range2_m: Floats
    bearing_rad: Floats
    bearing_std_rad: Floats
    clamped: Flags


class EchoPipeline:
    """The paper's measurements, section by section, with the memory that section 3.4 needs.

    Args:
        beep: the emitted signal.
        phone: speaker and microphones.
        settings: the paper's constants and errata.
        sound_speed_m_s: speed of sound that the detector assumes.
        pitch_rad: pitch of the phone, its top edge above the level; None if not known.

    Raises:
        ValueError: a speed of sound that is not positive, a pitch of 90 degrees or more, ranges beyond one period, a
            direct sound later than it is looked for, or beeps so rare that motion is never judged.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings,
        sound_speed_m_s: float,
        pitch_rad: float | None,
    ) -> None:
        sound_speed_m_s, pitch_rad = checked_arguments(beep, phone, sound_speed_m_s, pitch_rad)
        errata = settings.errata
        self.settings = settings
        self._check_memory(beep.period_s)
        self.sound_speed_m_s = sound_speed_m_s if errata.given_sound_speed else PRINTED_SOUND_SPEED_M_S
        self.direct_delay_s = expected_direct_delay_s(phone, self.sound_speed_m_s, settings.direct_delay_s)
        self._cos_pitch = float(np.cos(pitch_rad or 0.0))
        self._separation_m = phone.mic_separation_m
        self._speaker_m = phone.speaker_to_mic_m
        self._speaker_cosine = phone.speaker_cosine
        self._filter = MatchedFilter(
            beep, reach_s(beep, settings.far_m, self.sound_speed_m_s), reverse=not errata.correlate_once
        )
        self._pulse = pulse_shape(beep, settings.crest_level, self.sound_speed_m_s)
        self._damage, self._history = DamagedBeeps(), PeakHistory(settings.history_s)

    def _check_memory(self, period_s: float) -> None:
        """Refuse beeps so rare that no candidate would ever have a vote."""
        check_memory(self.settings.static_age_s, self.settings.history_s, period_s)

    def reset(self) -> None:
        """Forget earlier beeps."""
        self._damage.clear()
        self._forget()

    def _forget(self) -> None:
        """Forget all that beeps left but how loud their noise was."""
        self._history.clear()

    def measure(self, block: NDArray[np.floating], time_s: float) -> Measurement:
        """One beep period to its candidates. `time_s` is that of the block's first sample."""
        profile = self._filter.compress(block)
        direct = direct_sound(profile)
        if direct.found:
            if self._damage.found(profile, direct):
                return nothing_measured(Flag.DAMAGED | flag_of_second(block, direct), float(self._start_s(direct)[0]))
            if self._damage.was_first:
                self._forget()
        profile, direct = self._settled(block, profile, direct)
        if not direct.found:
            return nothing_measured(Flag.NO_BEEP)
        start_s = self._start_s(direct)
        beep_flags = flag_of_second(block, direct)
        echoes, noise = self._echoes(profile, start_s[0], direct.amplitude[0])
        motion = self._motion(self._path_m(echoes, start_s[0]) / 2.0, time_s + float(start_s[0]))
        nearest = np.flatnonzero(~motion.static)[: self.settings.max_candidates]
        if len(nearest) == 0:
            return nothing_measured(beep_flags, float(start_s[0]))
        echoes, speed = echoes[nearest], motion.closing_speed_m_s[nearest]
        snr = 2.0 * (echoes.amplitude / noise) ** 2
        path1_m = self._path_m(echoes, start_s[0])
        if beep_flags:
            difference = _no_difference(len(echoes))
        else:
            difference = self._difference(profile, path1_m, echoes.amplitude, start_s[1])
        placed = self._placed(profile, echoes, float(start_s[0]), snr, difference)
        size = self._size(profile, echoes, start_s[0], placed.range_m, speed)
        return Measurement(
            start_s=float(start_s[0]),
            range_m=placed.range_m,
            range2_m=placed.range2_m,
            bearing_rad=placed.bearing_rad,
            collision_angle_rad=size.collision_angle_rad,
            radius_m=size.radius_m,
            level_db=20.0 * np.log10(echoes.amplitude / direct.amplitude[0]),
            snr_db=10.0 * np.log10(snr),
            closing_speed_m_s=speed,
            range_std_m=self._range_std_m(self._pulse.delay_std_s(snr), placed.range2_m),
            bearing_std_rad=placed.bearing_std_rad,
            may_vote=motion.closing[nearest],
            flags=_flags(placed.clamped, difference, size, motion.judged, beep_flags),
            beep_flags=beep_flags,
        )

    def _settled(
        self, block: NDArray[np.floating], profile: EchoProfile, direct: DirectSound
    ) -> tuple[EchoProfile, DirectSound]:
        """What is measured of a block, its profile and direct sound: these themselves."""
        return profile, direct

    def _start_s(self, direct: DirectSound) -> Floats:
        """(2,) emission as each channel is to see it: one clock, one start; as printed, each one's own direct peak."""
        if self.settings.errata.shared_start:
            return np.full(2, direct.delay_s[0] - self.direct_delay_s)
        return direct.delay_s

    def _path_m(self, echoes: Echoes, start_s: float) -> Floats:
        return self.sound_speed_m_s * (echoes.delay_s - start_s)

    def _echoes(self, profile: EchoProfile, start_s: float, direct: float) -> tuple[Echoes, float]:
        """Microphone 0's peaks within the searched range, and the rms of its noise envelope."""
        settings = self.settings
        first, last = (
            profile.position(start_s + 2.0 * range_m / self.sound_speed_m_s)
            for range_m in (settings.near_m, settings.far_m)
        )
        received = profile.magnitude[0, first : last + 1]
        window = round(settings.peak_window_s * profile.rate_hz)
        if settings.errata.separated_peaks:
            high = self._high_enough(received, local_maxima(received), profile.rate_hz, direct)
            peaks = keep_separated(received, high, round(SEPARATION_SHARE * window))
        else:
            best = highest_of_windows(received, window)
            peaks = self._high_enough(received, best, profile.rate_hz, direct)
        noise = noise_amplitude(received)
        return self._echoes_of(profile, 0, peaks + first, noise), noise

    def _echoes_of(self, profile: EchoProfile, channel: int, peaks: NDArray[np.intp], noise: float) -> Echoes:
        """Echoes at peaks of a channel, under noise of that rms: one each."""
        return echoes_at(profile, channel, peaks)

    def _high_enough(
        self, received: Floats, peaks: NDArray[np.intp], rate_hz: float, direct: float
    ) -> NDArray[np.intp]:
        """Those of the peaks that reach the threshold."""
        settings = self.settings
        if not settings.errata.local_threshold:
            return peaks[received[peaks] >= mean_threshold(received, settings.threshold_factor)]
        least = direct * 10.0 ** (settings.floor_db / 20.0)
        peaks = above_sidelobes(received, peaks, round(SIDELOBE_HALF_WIDTH_S * rate_hz), least)
        return peaks[os_cfar_passes(received, peaks, settings.cfar_factor, round(CFAR_HALF_WIDTH_S * rate_hz))]

    def _motion(self, range_m: Floats, time_s: float) -> Motion:
        """Compare the peaks with those of earlier beeps, then remember them."""
        settings = self.settings
        age_s, past_m = self._history.before(time_s)
        motion = judge_motion(
            range_m,
            age_s,
            past_m,
            settings.static_tolerance_m,
            settings.static_age_s,
            settings.closing_speed_m_s,
            settings.closing_tolerance_m,
        )
        self._history.add(time_s, range_m)
        return motion

    def _difference(self, profile: EchoProfile, path1_m: Floats, amplitude1: Floats, start_s: float) -> PathDifference:
        """u of the candidates from microphone 1's peaks, freed of the walker's body."""
        settings, noise = self.settings, noise_amplitude(profile.magnitude[1, profile.position(0.0) :])
        least = noise * 10.0 ** (settings.second_mic_snr_db / 20.0) / np.sqrt(2.0)
        first = profile.position(start_s)
        peaks = separated_peaks(profile.magnitude[1, first:], least, 1) + first
        echoes2 = self._echoes_of(profile, 1, peaks, noise)
        return path_difference(
            path1_m,
            self._path_m(echoes2, start_s),
            echoes2.amplitude,
            separation_m=self._separation_m,
            margin_m=settings.gate_margin_m,
            body_distance_m=partial(self._body_distance_m, profile, start_s, least),
            least_amplitude=amplitude1 * 10.0 ** (settings.second_mic_level_db / 20.0),
            cos_pitch=self._cos_pitch,
            gated=settings.errata.gated_second_mic,
            whole_detour=settings.errata.whole_detour,
        )

    def _placed(
        self, profile: EchoProfile, echoes: Echoes, start_s: float, snr: Floats, difference: PathDifference
    ) -> Placed:
        """Ranges and bearings by the envelopes, as if from the phone's height."""
        u_std_m = np.sqrt(2.0) * self.sound_speed_m_s * self._pulse.delay_std_s(snr)
        return self._level(self._path_m(echoes, start_s), difference.u_m, u_std_m)

    def _level(self, path1_m: Floats, u_m: Floats, u_std_m: Floats) -> Placed:
        """Where things at the phone's height are that have those path differences: Eq. 2."""
        range_m, range2_m = self._ranges(path1_m, u_m)
        bearing_rad, clamped = self._bearing(range_m, range2_m)
        spread = bearing_std(bearing_rad, u_std_m, self._separation_m, self._cos_pitch)
        return Placed(range_m, range2_m, bearing_rad, spread, clamped)

    def _body_distance_m(self, profile: EchoProfile, start_s: float, least: float) -> float:
        """From microphone 1 to the walker's body; NaN if no echo of it is received."""
        near_m, far_m = self.settings.body_distance_m
        straight_m = float(self._speaker_m[1]) if self.settings.errata.shared_start else 0.0
        window = (straight_m + 2.0 * near_m, straight_m + 2.0 * far_m)
        path_m = nearest_body_path(profile, start_s, window, self.sound_speed_m_s, least)
        return body_distance(path_m - straight_m, self._separation_m, self._cos_pitch)

    def _ranges(self, path1_m: Floats, u_m: Floats) -> tuple[Floats, Floats]:
        """D1 and D2 (sections 3.4 and 3.5)."""
        errata = self.settings.errata
        if not errata.one_way_range:
            return path1_m, path1_m + u_m
        baseline_m = float(self._speaker_m[0])
        range_m = ranges_of_pairs(path1_m, u_m, self._separation_m, baseline_m, self._speaker_cosine)
        return range_m, range_m + (u_m if errata.speaker_leg else u_m / 2.0)

    def _range_std_m(self, delay_std_s: Floats, range2_m: Floats) -> Floats:
        """(n,) deviation of D1: half of path 1's, and what the triangle takes of u = path 2 - path 1.

        To first order D1 = path 1 / 2 + k u with k = b s / (2 L), for a speaker at b and cosine s from microphone 0.
        """
        share = 0.5 * self._speaker_m[0] * self._speaker_cosine / self._separation_m
        if not self.settings.errata.one_way_range:
            return self.sound_speed_m_s * delay_std_s
        both = np.hypot(0.5 - share, share)
        return self.sound_speed_m_s * delay_std_s * np.where(np.isnan(range2_m), 0.5, both)

    def _bearing(self, range_m: Floats, range2_m: Floats) -> tuple[Floats, Flags]:
        cosine = cone_cosine(range_m, range2_m, self._separation_m)
        return walking_angle(cosine, self._cos_pitch, self.settings.errata.clamped_angle)

    def _size(self, profile: EchoProfile, echoes: Echoes, start_s: float, range_m: Floats, speed_m_s: Floats) -> Size:
        """Collision angle and radius (Eq. 3)."""
        errata = self.settings.errata
        if errata.pulse_width_removed:
            extra_m, merged = rim_excess(profile, echoes, self._pulse, speed_m_s, self.sound_speed_m_s)
        else:
            first = profile.position(start_s + 2.0 * self.settings.near_m / self.sound_speed_m_s)
            average = mean_threshold(profile.magnitude[0, first:], 1.0)
            extra_m = printed_rim_excess(profile, echoes, average, self.sound_speed_m_s)
            if self.settings.crest_radius is not None:
                least_m, per_crest = self.settings.crest_radius
                return size_from_radius(range_m, np.maximum(least_m + per_crest * extra_m, 0.0))
            merged = np.zeros(len(echoes), dtype=bool)
        return size_from_crest(range_m, extra_m, merged, errata.rim_angle)


class StillPipeline(EchoPipeline):
    """The same from a phone that stands still: nothing is rejected for staying at its delay, and all may vote."""

    def _check_memory(self, period_s: float) -> None:
        """Every candidate has a vote, however rare the beeps are."""

    def _motion(self, range_m: Floats, time_s: float) -> Motion:
        speed_m_s = super()._motion(range_m, time_s).closing_speed_m_s
        every = np.ones(len(range_m), dtype=bool)
        return Motion(static=~every, closing=every, closing_speed_m_s=speed_m_s, judged=True)


def _flags(
    clamped: Flags, difference: PathDifference, size: Size, confirmed: bool, beep_flags: Flag
) -> NDArray[np.int_]:
    of_all = (0 if confirmed else int(Flag.UNCONFIRMED)) | int(beep_flags & Flag.IDENTICAL_CHANNELS)
    flags: NDArray[np.int_] = clamped * int(Flag.CLAMPED) + of_all
    flags += difference.body_deducted * int(Flag.BODY_DEDUCTED)
    flags += np.isnan(difference.u_m) * int(Flag.NO_SECOND_MIC)
    flags += size.merged * int(Flag.MERGED_CREST) + np.isnan(size.radius_m) * int(Flag.NO_RADIUS)
    return flags


def _no_difference(count: int) -> PathDifference:
    return PathDifference(np.full(count, np.nan), np.full(count, np.nan), np.zeros(count, dtype=bool))
