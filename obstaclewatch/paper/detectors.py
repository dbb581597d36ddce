"""The paper's detector, walking and standing, and its section 4.8 baseline."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Detection, Flag
from obstaclewatch.paper.collision import CollisionVote, decide, on_collision_course, on_collision_course_printed
from obstaclewatch.paper.measurement import Measurement
from obstaclewatch.paper.pipeline import EchoPipeline, StillPipeline
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.recordings.streaming import StreamingDetector
from obstaclewatch.support.arrays import Flags


class EchoDetector(StreamingDetector):
    """Streams beeps through the paper's measurements; what counts as a collision is left to the subclass.

    Args:
        beep: the emitted signal.
        phone: where speaker and microphones are.
        settings: the paper's constants and errata.
        sound_speed_m_s: speed of sound that the detector assumes, whatever the air really does.
        pitch_rad: pitch of the phone, its top edge above the level; None if not known: bearings are then cone angles.

    Raises:
        ValueError: arguments out of range; the message names the value and the rule.
    """

    _PIPELINE: ClassVar[type[EchoPipeline]] = EchoPipeline

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings | None = None,
        sound_speed_m_s: float = 343.0,
        pitch_rad: float | None = None,
    ) -> None:
        self.settings = PaperSettings.of(settings)
        self._pipeline = self._PIPELINE(beep, phone, self.settings, sound_speed_m_s, pitch_rad)
        self._vote = CollisionVote(self.settings.votes_needed, self.settings.votes_of)
        super().__init__(beep, phone, self._pipeline.direct_delay_s)

    def reset(self) -> None:
        """Forget all beeps so far."""
        self._pipeline.reset()
        self._vote.clear()
        self._blocks.clear()

    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Measure one beep and vote; see `StreamingDetector.process`."""
        samples, begin_s = self._blocks.checked(block, time_s)
        found = self._pipeline.measure(samples, begin_s)
        collides = self._collides(found)
        emitted_s = begin_s + found.start_s
        decision = decide(
            self._vote, emitted_s, found.range_m, found.closing_speed_m_s, collides, self._alert_range_m()
        )
        return found.detection(self._blocks.passed(begin_s, time_s), emitted_s, collides, decision)

    @abstractmethod
    def _collides(self, found: Measurement) -> Flags:
        """(n,) which candidates vote for a collision."""

    @abstractmethod
    def _alert_range_m(self) -> float:
        """Range within which a predicted collision raises the alert."""


class PaperDetector(EchoDetector):
    """The detector of the paper: walking angle against collision angle, five votes in nine, alert within 3 m.

    It keeps the paper's range-Doppler bias: what closes in at 1.0-1.6 m/s reads 20-33 cm short.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, PaperDetector, PhoneGeometry, Recording
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(24 * beep.period_samples) / beep.sample_rate_hz
    >>> def train(path_m, speed_m_s=0.0):  # beeps by a path that shortens by twice the speed of the walker
    ...     emitted_s = ((343 + speed_m_s) * time_s - path_m) / (343 - speed_m_s)
    ...     return beep.waveform(emitted_s % beep.period_s)
    >>> walk = [0.1 * train(d) + 0.001 * train(e, 1.3) for d, e in [(0.0, 8.0), (0.14, 8.0 + 0.14)]]
    >>> decisions = PaperDetector(beep, phone).run(Recording(walk, beep.sample_rate_hz))
    >>> first = next(decision for decision in decisions if decision.alert)
    >>> print(f"alert after {first.time_s:.2f} s, reads {first.range_m:.2f} m of {4.0 - 1.3 * first.time_s:.2f} m")
    alert after 0.99 s, reads 2.40 m of 2.71 m
    """

    def _collides(self, found: Measurement) -> Flags:
        settings = self.settings
        near = found.may_vote & (found.range_m <= settings.evaluation_m)
        if found.beep_flags & (Flag.IDENTICAL_CHANNELS | Flag.NO_SECOND_MIC):
            return near
        if not settings.errata.walker_width:
            return near & on_collision_course_printed(found.bearing_rad, found.collision_angle_rad)
        return near & on_collision_course(
            found.range_m, found.bearing_rad, found.radius_m, settings.walker_half_width_m
        )

    def _alert_range_m(self) -> float:
        return self.settings.danger_m


class PaperStandingDetector(PaperDetector):
    """The paper's measurement from a phone that stands still (section 4.6), where nothing comes nearer.

    Nothing is rejected for staying at its delay, and every candidate may vote.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, PaperStandingDetector, PhoneGeometry
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(beep.period_samples) / beep.sample_rate_hz
    >>> direct_m, echo_m = [0.0, 0.14], [4.0, 4.14]  # a wall straight ahead, 2 m away
    >>> block = [0.1 * beep.waveform(time_s - d / 343) + 0.001 * beep.waveform(time_s - e / 343)
    ...          for d, e in zip(direct_m, echo_m)]
    >>> found = PaperStandingDetector(beep, phone).process(block)
    >>> print(f"{found.range_m[0]:.3f} m")
    2.000 m
    """

    _PIPELINE = StillPipeline


class DistanceOnlyDetector(EchoDetector):
    """The baseline of section 4.8: anything that closes in within 4 m and ahead counts, whatever its bearing or size.

    The same measurements and vote as the paper's detector, so that the two differ in the information alone. "Ahead"
    stands for the baseline's camera: a bearing below 90 degrees, or none measured.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, DistanceOnlyDetector, PhoneGeometry, Recording
    >>> beep = BeepDesign()
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> time_s = np.arange(24 * beep.period_samples) / beep.sample_rate_hz
    >>> def train(path_m, speed_m_s=0.0):  # beeps by a path that shortens by twice the speed of the walker
    ...     emitted_s = ((343 + speed_m_s) * time_s - path_m) / (343 - speed_m_s)
    ...     return beep.waveform(emitted_s % beep.period_s)
    >>> walk = [0.1 * train(d) + 0.001 * train(e, 1.3) for d, e in [(0.0, 8.0), (0.14, 8.0 + 0.14)]]
    >>> decisions = DistanceOnlyDetector(beep, phone).run(Recording(walk, beep.sample_rate_hz))
    >>> print(f"alert after {next(decision.time_s for decision in decisions if decision.alert):.2f} s")
    alert after 0.81 s
    """

    RANGE_M = 4.0

    def _collides(self, found: Measurement) -> Flags:
        ahead = ~(found.bearing_rad >= np.pi / 2)
        return found.may_vote & (found.range_m <= self.RANGE_M) & ahead

    def _alert_range_m(self) -> float:
        return self.RANGE_M
