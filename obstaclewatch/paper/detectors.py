"""The paper's detector and its section 4.8 baseline: one 90 ms beep in, one detection out, constant memory."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Decision, Detection, Flag
from obstaclewatch.paper.collision import CollisionVote, decide, on_course, on_course_printed
from obstaclewatch.paper.measurement import Measurement
from obstaclewatch.paper.pipeline import EchoPipeline
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import BeepFinder, NoBeepError
from obstaclewatch.recordings.block_alignment import BlockGate
from obstaclewatch.recordings.feed import SampleFeed
from obstaclewatch.support.argument_types import check_numbers, check_types
from obstaclewatch.support.arrays import Flags


class EchoDetector(ABC):
    """Streams beeps through the paper's measurements; what counts as a collision is left to the subclass.

    Args:
        beep: the emitted signal.
        phone: where speaker and microphones are.
        settings: the paper's constants and errata.
        sound_speed_m_s: speed of sound that the detector assumes, whatever the air really does.
        pitch_rad: lift of the phone's top edge; None if not known: bearings are then cone angles.

    Raises:
        ValueError: arguments out of range; the message names the value and the rule.
    """

    def __init__(
        self,
        beep: BeepDesign,
        phone: PhoneGeometry,
        settings: PaperSettings | None = None,
        sound_speed_m_s: float = 343.0,
        pitch_rad: float | None = None,
    ) -> None:
        check_types(beep=(beep, BeepDesign), phone=(phone, PhoneGeometry))
        check_numbers(sound_speed_m_s=sound_speed_m_s)
        if pitch_rad is not None:
            check_numbers(pitch_rad=pitch_rad)
        self.beep = beep
        self.phone = phone
        self.settings = PaperSettings() if settings is None else settings
        self._pipeline = EchoPipeline(beep, phone, self.settings, sound_speed_m_s, pitch_rad)
        self._vote = CollisionVote(self.settings.votes_needed, self.settings.votes_of)
        self._blocks = BlockGate(beep)

    def reset(self) -> None:
        """Forget everything heard so far."""
        self._pipeline.reset()
        self._vote.clear()
        self._blocks.clear()

    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Measure one beep and decide.

        Args:
            block: (2, period_samples) one beep period, starting at the beep's emission.
            time_s: time of the block's first sample; None takes whole periods since the last that was given, or 0.

        Returns:
            The detection. Without a beep it holds no candidates, the flag NO_BEEP, and casts no vote.

        Raises:
            ValueError: a block of another shape, samples that are not finite, or a time that is not finite or not
                later than the last block's. The detector is as it was before, ready for another block.
        """
        samples, begin_s = self._blocks.checked(block, time_s)
        found = self._pipeline.measure(samples, begin_s)
        collides = self._collides(found)
        emitted_s = begin_s + found.start_s
        decision = decide(
            self._vote, emitted_s, found.range_m, found.closing_speed_m_s, collides, self._alert_range_m()
        )
        return _detection(self._blocks.passed(begin_s, time_s), emitted_s, found, collides, decision)

    def stream(self, recording: Recording) -> Iterator[Detection]:
        """Detections of a recording that may start anywhere, one per whole beep period, from a fresh state.

        Where samples were dropped and the beep is not at its place, it is searched for anew.

        Raises:
            ValueError: what is not a recording, or one whose rate is not the beep's.
            NoBeepError: the recording holds no beep.
        """
        check_types(recording=(recording, Recording))
        return self.stream_pieces([recording])

    def stream_pieces(self, pieces: Iterable[Recording]) -> Iterator[Detection]:
        """The same, bit for bit, of a recording that arrives in pieces of any length, in constant memory.

        The pieces up to the first beep are read at once, so that what is wrong with them is said at once.

        Raises:
            ValueError, NoBeepError: as `stream`; a piece of another rate only when its turn comes.
        """
        self.reset()
        feed = SampleFeed(pieces, self.beep.sample_rate_hz)
        finder = BeepFinder(self.beep, self._pipeline.direct_delay_s)
        return self._stream(feed, finder, finder.next_emission(feed, 0))

    def run(self, recording: Recording) -> list[Decision]:
        """Decisions of a whole recording, one per beep; the same, bit for bit, as those of `stream`."""
        return [detection.decision for detection in self.stream(recording)]

    def _stream(self, feed: SampleFeed, finder: BeepFinder, begin: int) -> Iterator[Detection]:
        period = self.beep.period_samples
        while (block := feed.take(begin, begin + period)).shape[1] == period:
            detection = self.process(block, begin / self.beep.sample_rate_hz)
            yield detection
            begin += period
            feed.forget(begin - period)
            if Flag.NO_BEEP in detection.beep_flags:
                try:
                    begin = max(finder.next_emission(feed, begin - period // 2), begin - period // 2)
                except NoBeepError:
                    return

    @abstractmethod
    def _collides(self, found: Measurement) -> Flags:
        """(n,) which candidates vote for a collision."""

    @abstractmethod
    def _alert_range_m(self) -> float:
        """Range within which a predicted collision raises the alert."""


class PaperDetector(EchoDetector):
    """The detector of the paper: walking angle against collision angle, five votes in nine, alert within 3 m.

    It keeps the paper's range-Doppler bias: what closes in at 1.0-1.6 m/s reads 20-33 cm short.
    """

    def _collides(self, found: Measurement) -> Flags:
        settings = self.settings
        near = found.may_vote & (found.range_m <= settings.evaluation_m)
        if Flag.IDENTICAL_CHANNELS in found.beep_flags:
            return near
        if not settings.errata.walker_width:
            return near & on_course_printed(found.bearing_rad, found.collision_angle_rad)
        return near & on_course(found.range_m, found.bearing_rad, found.radius_m, settings.walker_half_width_m)

    def _alert_range_m(self) -> float:
        return self.settings.danger_m


class DistanceOnlyDetector(EchoDetector):
    """The baseline of section 4.8: anything that closes in within 4 m and ahead counts, whatever its bearing or size.

    The same measurements and vote as the paper's detector, so that the two differ in the information alone. "Ahead"
    stands for the baseline's camera: a bearing below 90 degrees, or none measured.
    """

    RANGE_M = 4.0

    def _collides(self, found: Measurement) -> Flags:
        ahead = ~(found.bearing_rad >= np.pi / 2)
        return found.may_vote & (found.range_m <= self.RANGE_M) & ahead

    def _alert_range_m(self) -> float:
        return self.RANGE_M


def _detection(index: int, time_s: float, found: Measurement, collides: Flags, decision: Decision) -> Detection:
    return Detection(
        index=index,
        time_s=time_s,
        range_m=found.range_m,
        range2_m=found.range2_m,
        bearing_rad=found.bearing_rad,
        radius_m=found.radius_m,
        level_db=found.level_db,
        snr_db=found.snr_db,
        closing_speed_m_s=found.closing_speed_m_s,
        range_std_m=found.range_std_m,
        bearing_std_rad=found.bearing_std_rad,
        radius_std_m=np.full(len(found.radius_m), np.nan),
        collides=collides,
        flags=found.flags,
        beep_flags=found.beep_flags,
        decision=decision,
    )
