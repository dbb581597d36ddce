"""A detector as a stream: one 90 ms beep in, one detection out, constant memory."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Decision, Detection, Flag
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import BeepFinder, NoBeepError
from obstaclewatch.recordings.block_alignment import BlockAlignment
from obstaclewatch.recordings.sample_feed import SampleFeed
from obstaclewatch.support.argument_types import as_number, check_types

TAIL_S = 2e-3
"""How much of the envelope is kept beyond the farthest echo."""
MOST_APART_M = 1.5
"""From speaker to microphone, or between these; what is farther apart is given in another unit."""

MOST_ASKEW_RAD = np.deg2rad(45.0)
"""Between the phone's long edge and the line from microphone 1 to microphone 0; beyond, these are no bottom and top."""

SOUND_SPEEDS_M_S = (250.0, 450.0)
"""Air's is 283 m/s at -73 C and 375 at 60 C, dry or moist; what lies far outside is given in another unit."""


class StreamingDetector(ABC):
    """What all detectors share: blocks of one beep period, and recordings cut into such blocks.

    Args:
        beep: the emitted signal.
        phone: where speaker and microphones are.
        direct_delay_s: of the direct peak at microphone 0 after emission; a recording is cut by it.
    """

    def __init__(self, beep: BeepDesign, phone: PhoneGeometry, direct_delay_s: float) -> None:
        self.beep = beep
        self.phone = phone
        self._direct_delay_s = direct_delay_s
        self._blocks = BlockAlignment(beep)
        self._streams = 0

    def __repr__(self) -> str:
        low, high = 1e-3 * self.beep.start_hz, 1e-3 * self.beep.stop_hz
        return f"{type(self).__name__}({self.phone.name}, {low:g}-{high:g} kHz)"

    @abstractmethod
    def reset(self) -> None:
        """Forget all beeps so far."""

    @abstractmethod
    def process(self, block: ArrayLike, time_s: float | None = None) -> Detection:
        """Measure one beep and decide.

        Args:
            block: (2, period_samples) one beep period, starting at the beep's emission.
            time_s: time of the block's first sample; None counts full periods since the last that was given, or 0.

        Returns:
            The detection. Without a beep it holds no candidates, the flag NO_BEEP, and casts no vote.

        Raises:
            ValueError: a block of another shape, samples that are not finite or beyond +-1e10 re full scale, or a time
                that is not finite, beyond +-1e10 s or not later than the last block's. The detector is as it was
                before, ready for another block.
        """

    def stream(self, recording: Recording) -> Iterator[Detection]:
        """Detections of a recording that may start anywhere, one per full beep period, from a fresh state.

        Where samples were dropped and the beep is not at its place, it is searched for anew.

        Raises:
            ValueError: what is not a recording, or one whose rate is not the beep's.
            NoBeepError: the recording holds no beep.
        """
        check_types(recording=(recording, Recording))
        return self.stream_pieces([recording])

    def stream_pieces(self, pieces: Iterable[Recording]) -> Iterator[Detection]:
        """The same, bit for bit, of a recording that arrives in pieces of any length, in constant memory.

        The pieces up to the first beep are read by the call itself, so that it raises what is wrong with them. A
        detector follows one recording at a time: the next stream ends this one.

        Raises:
            ValueError, NoBeepError: as `stream`; a piece of another rate only when it is read.
            RuntimeError: from an iterator that is asked on after another stream of the same detector began.
        """
        self.reset()
        self._streams += 1
        feed = SampleFeed(pieces, self.beep.sample_rate_hz)
        finder = BeepFinder(self.beep, self._direct_delay_s)
        return self._stream(feed, finder, finder.next_emission(feed, 0), self._streams)

    def run(self, recording: Recording) -> list[Decision]:
        """Decisions of a recording, one per beep; the same, bit for bit, as those of `stream`."""
        return [detection.decision for detection in self.stream(recording)]

    def _stream(self, feed: SampleFeed, finder: BeepFinder, begin: int, own: int) -> Iterator[Detection]:
        period = self.beep.period_samples
        while (block := feed.take(begin, begin + period)).shape[1] == period:
            if own != self._streams:
                raise RuntimeError(f"this stream ended when {self!r} began another: take a detector for each recording")
            detection = self.process(block, begin / self.beep.sample_rate_hz)
            yield detection
            begin += period
            feed.forget(begin - period)
            if Flag.NO_BEEP in detection.beep_flags:
                try:
                    begin = max(finder.next_emission(feed, begin - period // 2), begin - period // 2)
                except NoBeepError:
                    return


def checked_arguments(
    beep: BeepDesign, phone: PhoneGeometry, sound_speed_m_s: float, pitch_rad: float | None
) -> tuple[float, float | None]:
    """Speed of sound and pitch of the microphones' line as numbers, where a detector can run on the arguments.

    Raises:
        ValueError: another type, transducers too far apart, microphones that are not one behind the other, a speed of
            sound that no air has, or a pitch of 90 degrees or more.
    """
    check_types(beep=(beep, BeepDesign), phone=(phone, PhoneGeometry))
    check_size(phone)
    check_axis(phone)
    sound_speed_m_s = as_number("sound_speed_m_s", sound_speed_m_s)
    least, most = SOUND_SPEEDS_M_S
    if not least <= sound_speed_m_s <= most:
        raise ValueError(f"sound_speed_m_s must be from {least:g} to {most:g} m/s, got {sound_speed_m_s}")
    if pitch_rad is None:
        return sound_speed_m_s, None
    pitch_rad = as_number("pitch_rad", pitch_rad)
    if not abs(pitch_rad) < np.pi / 2:
        raise ValueError(f"pitch_rad must lie within -pi/2..pi/2, got {pitch_rad}")
    line_rad = phone.line_pitch_rad(pitch_rad)
    if not abs(line_rad) < np.pi / 2:
        raise ValueError(
            f"pitch_rad must leave the microphones' line within -pi/2..pi/2, got {pitch_rad}, and {line_rad:.3f} of it"
        )
    return sound_speed_m_s, line_rad


def check_axis(phone: PhoneGeometry) -> None:
    """Refuse a phone whose microphone 0 is not towards the top edge from microphone 1: bearings are from that line.

    Raises:
        ValueError: the line between them is more than 45 degrees off the long edge; with the angle.

    >>> check_axis(PhoneGeometry("mine", [0, 0.04, 0], [[0, 0.07, 0], [0, -0.07, 0]]))
    """
    along = float(phone.mics_m[0, 1] - phone.mics_m[1, 1]) / phone.mic_separation_m
    askew_rad = float(np.arccos(np.clip(along, -1.0, 1.0)))
    if not askew_rad <= MOST_ASKEW_RAD:
        raise ValueError(
            f"microphone 0 must lie towards the phone's top edge (+y) from microphone 1, within "
            f"{np.degrees(MOST_ASKEW_RAD):.0f} degrees, got {np.degrees(askew_rad):.0f} degrees: "
            f"mics_m = {phone.mics_m.tolist()}"
        )


def check_size(phone: PhoneGeometry) -> None:
    """Refuse a phone whose speaker and microphones are farther apart than any phone is long.

    Raises:
        ValueError: they are; with the distance and the greatest one.

    >>> check_size(PhoneGeometry("mine", [0, 0.04, 0], [[0, 0.07, 0], [0, -0.07, 0]]))
    """
    apart_m = max(phone.mic_separation_m, *phone.speaker_to_mic_m.tolist())
    if apart_m > MOST_APART_M:
        raise ValueError(f"speaker and microphones must be within {MOST_APART_M:g} m, got {apart_m:g} m: in mm?")


def reach_s(beep: BeepDesign, far_m: float, sound_speed_m_s: float) -> float:
    """Delay up to which the envelope is kept for echoes from so far.

    Raises:
        ValueError: it is longer than one beep period.
    """
    reach = 2.0 * far_m / sound_speed_m_s + TAIL_S
    if reach > beep.period_s:
        raise ValueError(f"far_m must be received within one beep period, got {far_m} m in {beep.period_s} s")
    return reach
