"""Our detector for a phone held still: beeps averaged, and what comes from behind and below left out.

While standing nothing moves, so that what moves along with the walker is not distinguished from obstacles by motion.
The direction of arrival decides: averaged beeps give the cosine of the cone about the phone's long axis to 0.05, and
the ground below a phone pitched by 30 degrees arrives at -0.5, the walker's body at -1, the foot of a wall alongside at
-0.3, a thing ahead at 0.4 to 0.9.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Decision, Detection, Flag
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.streaming import StreamingDetector
from obstaclewatch.signal.carrier_phase import checked_mic_phase
from obstaclewatch.signal.two_mics import cone_cosine
from obstaclewatch.standing.pipeline import StandingPipeline

CANDIDATES = 20
"""Measured before the direction is asked; of 96 rendered places none had more than 9."""
GATE_MARGIN_M = 0.015
"""How far a path difference may pass the phone's length: three deviations of what overlap leaves, 3.5 mm, and of noise
at 30 dB."""
OTHER_STD_M = 0.003
"""Deviation of a range by what is not noise: echoes that overlap, and the speed of sound."""
BEHIND = 0.1
"""How far below zero a cosine must lie to be from behind for certain, beside its noise."""
DIFFERENCE_TO_RANGE = 3.0
"""Deviation of the path difference over that of the range by noise: two full paths against half of one."""


class StandingDetector(StreamingDetector):
    """Measures what is ahead of a phone held still; nothing raises an alert.

    Beeps are averaged in phase, crests that no single pulse explains are parted, path differences are those of the
    carrier where its phase is known, and what arrives from behind the phone is left out. Bearings are over all heights
    once the ground is received and the pitch is known, else as if from the phone's height. No radius is estimated.

    Args:
        beep: the emitted signal.
        phone: where speaker and microphones are.
        settings: the ranges that are searched, thresholds and the number of candidates.
        sound_speed_m_s: speed of sound that the detector assumes.
        pitch_rad: pitch of the phone, its top edge above the level; None if not known.
        mic_phase_rad: as for `TrackingDetector`; None takes the envelopes alone.
        averaged_beeps: over how many beeps the running mean forgets; 1 takes every beep alone. 16 gain 12 dB over one
            beep after as many, 15 dB at most.

    Raises:
        ValueError: arguments out of range; the message names the value and the rule.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, StandingDetector, PhoneGeometry
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(beep.period_samples) / beep.sample_rate_hz
    >>> direct_m, echo_m = [0.0, 0.14], [4.0, 4.14]  # a wall straight ahead, 2 m away
    >>> block = [0.1 * beep.waveform(time_s - d / 343) + 0.001 * beep.waveform(time_s - e / 343)
    ...          for d, e in zip(direct_m, echo_m)]
    >>> found = StandingDetector(beep, phone).process(block)
    >>> print(f"{found.range_m[0]:.3f} m, {np.degrees(found.bearing_rad[0]):.0f} degrees")
    2.000 m, 0 degrees
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings | None = None,
        sound_speed_m_s: float = 343.0,
        pitch_rad: float | None = None,
        mic_phase_rad: float | None = 0.0,
        averaged_beeps: int = 16,
    ) -> None:
        self.settings = PaperSettings.of(settings)
        mic_phase_rad = checked_mic_phase(mic_phase_rad)
        measured = replace(
            self.settings, max_candidates=CANDIDATES, gate_margin_m=min(self.settings.gate_margin_m, GATE_MARGIN_M)
        )
        self._pipeline = StandingPipeline(
            beep, phone, measured, sound_speed_m_s, pitch_rad, mic_phase_rad, averaged_beeps
        )
        super().__init__(beep, phone, self._pipeline.direct_delay_s)

    def reset(self) -> None:
        """Forget all beeps so far."""
        self._pipeline.reset()
        self._blocks.clear()

    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Measure one beep; see `StreamingDetector.process`."""
        samples, begin_s = self._blocks.checked(block, time_s)
        found = self._pipeline.measure(samples, begin_s)
        emitted_s = begin_s + found.start_s
        no_alert = Decision(False, emitted_s, np.nan, np.nan, 0)
        none_collides = np.zeros(len(found), dtype=bool)
        detection = found.detection(self._blocks.passed(begin_s, time_s), emitted_s, none_collides, no_alert)
        return ahead_alone(detection, self.phone.mic_separation_m, self.settings.max_candidates)


def ahead_alone(found: Detection, separation_m: float, most: int) -> Detection:
    """The nearest candidates that do not arrive from behind the phone; their deviations count more than noise.

    Their radii are left out: by the width of crests they are 63 cm off in the median.

    Args:
        found: candidates, nearest first; those without a path difference stay.
        separation_m: between the microphones.
        most: how many are kept.
    """
    cosine = cone_cosine(found.range_m, found.range2_m, separation_m)
    noise = 2.0 * DIFFERENCE_TO_RANGE * found.range_std_m / separation_m
    kept = found.taken(np.flatnonzero(~(cosine < -(BEHIND + noise)))[:most])
    return replace(
        kept,
        radius_m=np.full(len(kept), np.nan),
        flags=kept.flags | int(Flag.NO_RADIUS),
        range_std_m=np.hypot(kept.range_std_m, OTHER_STD_M),
    )
