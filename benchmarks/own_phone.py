"""A phone of one's own: what a recording before a wall says of it, kept in a file for `detect`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import yaml
from pydantic import BaseModel, Field, ValidationError

from benchmarks.cells.spec import Angle, first_error
from obstaclewatch import BeepDesign, Fault, MicPhase, PhoneGeometry, Recording, measure_mic_phase
from obstaclewatch.recordings.calibration import Calibration
from obstaclewatch.recordings.streaming import check_size
from obstaclewatch.signal.direct_sound import expected_direct_delay_s
from scenes import load_encounter
from scenes.files.bounded_yaml import parsed, read_text
from scenes.files.field_types import Real

ADVICE = {
    Fault.NO_BEEP: "play the file of `obstaclewatch beep` on the phone while it records, with its volume up; record "
    "without noise suppression, automatic gain and compression, as WAV or FLAC, not AAC, Opus or MP3",
    Fault.OTHER_BEEP: "give --band, --beep-ms and --gap-ms of what was played",
    Fault.SWAPPED_CHANNELS: "add --swap, or leave it out",
    Fault.ABSURD_LEVEL: "save the recording as 16 or 24 bits",
    Fault.DEAF_MICROPHONE: "uncover the bottom microphone, or choose an app that records both; bearings need both",
    Fault.IDENTICAL_CHANNELS: "choose stereo and the unprocessed microphones in the recording app; bearings need both",
    Fault.CLIPPED: "play more quietly",
    Fault.LIMITED: "play more quietly, and record without automatic gain",
    Fault.DROPPED_SAMPLES: "close other apps and record again",
    Fault.CLOCK_DRIFT: "play and record on the same phone",
}
"""What to do about what `inspect_recording` finds."""

Metres = Annotated[Real, Field(ge=-10.0, le=10.0)]
"""Of the suite `extremes`: microphones farther apart are not tried. A detector's memory grows with their distance."""
Place = tuple[Metres, Metres, Metres]
SUFFIXES = (".yaml", ".yml")
"""Of the files of phones."""
TAPE_M = 0.005
"""Standard deviation of a distance to a wall by tape."""
TILT_RAD = math.radians(2.0)
"""The same of a phone pointed squarely at it by eye."""
REACH = (0.8, 1.2)
"""Where the wall's echo is looked for, relative to the tape: the ground and other walls are elsewhere."""


class PhoneFile(BaseModel, extra="forbid", frozen=True):
    """What `calibrate` writes and `detect` reads.

    Attributes:
        name: of the phone.
        speaker_m, mics_m: in the phone's frame; see `obstaclewatch.PhoneGeometry`.
        direct_delay_s: of the direct sound at microphone 0 after emission; None takes the path through the air.
        mic_phase_rad: what microphone 1's channel adds to the carrier's phase; None is not known.
    """

    name: str
    speaker_m: Place
    mics_m: tuple[Place, Place]
    direct_delay_s: Real | None = Field(None, gt=-1e-3, lt=1e-3)
    mic_phase_rad: Angle | None = None

    @property
    def geometry(self) -> PhoneGeometry:
        """As the detectors take it."""
        return PhoneGeometry(self.name, np.array(self.speaker_m), np.array(self.mics_m))


def phone_file(geometry: PhoneGeometry, delay_s: float | None = None, phase_rad: float | None = None) -> PhoneFile:
    """A phone as a file holds it."""
    places = geometry.speaker_m.tolist(), geometry.mics_m.tolist()
    return PhoneFile.model_validate(
        {"name": geometry.name, "speaker_m": places[0], "mics_m": places[1], "direct_delay_s": delay_s,
         "mic_phase_rad": phase_rad}
    )  # fmt: skip


def load_phone(path: Path) -> PhoneFile:
    """The phone of a file that `calibrate` wrote, or of a scene file.

    Raises:
        ValueError: not YAML, or neither.
    """
    if not path.is_file():
        raise ValueError(f"phone '{path}' must be a file, got {'a folder' if path.is_dir() else 'none of that name'}")
    data = parsed(read_text(path, "phone"), str(path), "phone")[0]
    if isinstance(data, dict) and "obstacles" in data:
        return phone_file(load_encounter(path).phone.geometry)
    try:
        return PhoneFile.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"phone '{path}': {first_error(error, PhoneFile)}") from error


def check_replaceable(path: Path) -> None:
    """Whether a calibration may be written there: nothing is there, or another calibration.

    Raises:
        ValueError: another file, such as a scene.
    """
    if not path.exists():
        return
    try:
        PhoneFile.model_validate(parsed(read_text(path, "phone"), str(path), "phone")[0])
    except ValueError as error:
        raise ValueError(f"--output must be new or hold a phone that `calibrate` wrote, got '{path}'") from error


def phone_text(phone: PhoneFile) -> str:
    """The file's text."""
    return yaml.safe_dump(phone.model_dump(mode="json"), sort_keys=False)


def middle_line(name: str, mics_m: float, speaker_m: float) -> PhoneGeometry:
    """A phone with microphones at the ends of its middle line, and the speaker so far below the top one.

    Raises:
        ValueError: the speaker is not between the microphones, or these are too far apart for a detector.

    >>> middle_line("mine", mics_m=0.14, speaker_m=0.03).speaker_to_mic_m.round(2).tolist()
    [0.03, 0.11]
    """
    if not 0.0 <= speaker_m < mics_m:
        raise ValueError(f"the speaker must be between the microphones, {mics_m:g} m apart, got {speaker_m:g} m")
    top = 0.5 * mics_m
    phone = PhoneGeometry(name, np.array([0.0, top - speaker_m, 0.0]), np.array([[0.0, top, 0.0], [0.0, -top, 0.0]]))
    check_size(phone)
    return phone


def measured_separation_m(found: Calibration, speaker_m: float, sound_speed_m_s: float) -> float:
    """Distance of the microphones of a phone with its speaker between them, from the direct sound's delay in air.

    Raises:
        ValueError: the bottom microphone does not receive the direct sound after the top one.
    """
    difference_m = sound_speed_m_s * found.mic_delay_s
    if not difference_m > 0.0:
        raise ValueError(
            f"the direct sound must reach the bottom microphone last, got {1e6 * found.mic_delay_s:.0f} us after the "
            "top one: give --mics-cm, or --swap"
        )
    return difference_m + 2.0 * speaker_m


@dataclass(frozen=True)
class AtWall:
    """What a wall at a known distance shows.

    Attributes:
        direct_delay_s, direct_delay_std_s: of the direct sound after emission.
        phase: what microphone 1's channel adds.
    """

    direct_delay_s: float
    direct_delay_std_s: float
    phase: MicPhase


def measured_at_wall(
    recording: Recording, beep: BeepDesign, phone: PhoneGeometry, wall_m: float, sound_speed_m_s: float
) -> AtWall:
    """Delay and phase from the echo of a wall at which the phone's long edge points squarely.

    Args:
        wall_m: from the speaker to the wall, by tape.

    Raises:
        ValueError: as `measure_mic_phase`.
    """
    assumed_s = expected_direct_delay_s(phone, sound_speed_m_s, None)

    def at(delay_s: float) -> MicPhase:
        reach = (REACH[0] * wall_m, REACH[1] * wall_m)
        return measure_mic_phase(recording, beep, phone, 0.0, TILT_RAD, reach, sound_speed_m_s, delay_s)

    delay_s = assumed_s + 2.0 * (wall_m - at(assumed_s).distance_m) / sound_speed_m_s
    return AtWall(delay_s, 2.0 * TAPE_M / sound_speed_m_s, at(delay_s))
