"""Phones by name: what is measured of them, and what is assumed.

| | measured or published | assumed |
|---|---|---|
| microphones | the phone's length apart: 14.1, 15.3, 16.0 cm (paper, section 4.1) | at the ends of the middle line |
| speaker | "several centimeters" from the top microphone (paper, section 3.4) | 3 cm below it on the middle line |
| response | Galaxy S5: loudspeaker to own microphones | Note5, S8+: flat to 21 and 21.5 kHz, then falling |
| directivity | bottom microphone weaker to the front (paper, Fig. 8) | microphones 14 dB front to rear, speaker 6 dB |
| sound in the case | first and strongest arrival (paper, Fig. 9) | 1500 m/s, 1.5 times the direct sound in the air |
| level, noise | - | 55 dB SPL at 1 m; 30 dB SPL in 18-23 kHz |

The Nexus 6P is not one of the paper's phones: it is here because recordings of it towards a large object exist, and all
of it but the level is set from them (docs/real_recordings.md). Its loudspeaker is at the bottom.

| Nexus 6P | measured | assumed |
|---|---|---|
| microphones | path difference of 14 and 15 cm for an object ahead | on the middle line |
| speaker | direct over a mirror's echo 46 dB at the bottom one: 3.1 cm from it | above the bottom microphone |
| shadow | direct sound at the top microphone 7.5 dB below 1 / distance | - |
| response | loudspeaker to own microphones | - |
| directivity | bottom microphone 16 dB weaker to the front | speaker omnidirectional |
| noise | 22.5 dB below the beep at 1 m (17-26 dB in four recordings) | 55 dB SPL at 1 m |

The Galaxy S5's table is derived from LibAcousticSensing (https://github.com/yctung/LibAcousticSensing, commit
9279d2dd), Copyright 2017 Yu-Chih Tung, MIT licence (the terms of this project's LICENSE): 250 Hz power averages over
repeats of a sweep, phone in the hand, one unit; its channel 1 is taken for the top microphone, 2 for the bottom one.
It was recorded at 48 kHz, whose filters share in the fall above 22 kHz, and through the near field: that it stands for
the two-way response to a far obstacle is inferred. Below 16 kHz and above 23.5 kHz its end values are held.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.recording import PhoneGeometry
from obstaclewatch.support.argument_types import check_types
from obstaclewatch.support.arrays import Floats
from simulator.phone.transducers import StructureBorne, Transducer

SPEAKER_TO_TOP_MIC_M = 0.03
CASE_SOUND_SPEED_M_S = 1500.0
CASE_TO_AIR_GAIN = 1.5
MIC_REAR_LOSS_DB = 14.0
"""As in recordings: with 10 dB a phone received objects behind a microphone 4 dB too loud, and the floor 5 to 7."""
SPEAKER_REAR_LOSS_DB = 6.0
LEVEL_SPL_DB = 55.0
NOISE_SPL_DB = 30.0
REFERENCE_BAND_HZ = (18_000.0, 22_000.0)  # over which a response averages 0 dB in power

TABLE_HZ = np.arange(16_000.0, 23_501.0, 250.0)
S5_TOP_DB = np.array([
    -0.4, 2.2, 2.1, -0.2, -2.6, -1.9, -2.8, -2.5, 0.0, 1.4, -0.3, 0.6, 0.1, -2.2, -6.9, -7.5, -3.9, -5.5, -0.6, 3.1,
    3.5, 2.1, -0.2, -2.3, -4.2, -9.8, -17.8, -24.5, -31.0, -41.4, -52.4,
])  # fmt: skip
S5_BOTTOM_DB = np.array([
    5.3, 4.2, 4.0, 0.8, -6.9, -3.5, -2.3, -1.8, 0.0, -0.1, -0.0, -0.8, -3.9, -5.2, -2.4, -1.8, -1.6, -1.1, -4.9, -11.3,
    -4.9, -1.4, -0.2, -1.1, -3.5, -7.3, -13.5, -20.5, -27.8, -36.6, -50.1,
])  # fmt: skip

N6P_TOP_DB = np.array([
    3.8, 4.7, 6.9, 6.8, 6.3, 6.7, 5.6, 2.7, 0.0, -1.6, 0.8, 2.8, 2.9, 2.8, 2.9, 2.6, 0.9, 2.3, 2.5, 1.9, 0.9, 1.7,
    2.5, 1.6, -0.1, -3.6, -5.7, -8.8, -10.9, -14.2, -18.1,
])  # fmt: skip
N6P_BOTTOM_DB = np.array([
    -16.5, -17.3, -14.2, -10.1, -7.1, -4.8, -2.6, -1.0, 0.0, 0.7, 1.1, 1.5, 2.1, 2.3, 2.1, 1.2, -0.5, -1.8, -2.3,
    -2.8, -3.4, -4.1, -4.7, -5.6, -7.2, -9.9, -13.6, -19.4, -27.7, -40.0, -40.2,
])  # fmt: skip
MEASURED_RESPONSES = ("galaxy-s5", "nexus-6p")
"""Presets whose response is a table; that of the others is assumed."""
N6P_SEPARATION_M, N6P_SPEAKER_TO_BOTTOM_MIC_M = 0.145, 0.031
N6P_REAR_LOSS_DB = 16.0
N6P_SHADOW_DB = 7.5
AIR_M_S = 343.2
N6P_NOISE_SPL_DB = LEVEL_SPL_DB - 22.5

FORWARDS, BACKWARDS = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])


@dataclass(frozen=True)
class PhonePreset:
    """What a name stands for: the attributes of a `Phone` of these names."""

    geometry: PhoneGeometry
    speaker: Transducer
    mics: tuple[Transducer, Transducer]
    structure_borne: StructureBorne | None
    level_spl_db: float
    noise_spl_db: float


def preset(name: str) -> PhonePreset:
    """What makes the phone of that name, or of one of its short forms ("s5", "note5", "s8+").

    Raises:
        ValueError: an unknown name; the message lists those there are.
    """
    check_types(phone=(name, str))
    key = _ALIASES.get(name.lower(), name.lower())
    if key not in _PRESETS:
        raise ValueError(f"phone must be one of {', '.join(list_phones())}, got {name!r}")
    return _PRESETS[key]()


def list_phones() -> list[str]:
    """Names that `preset` and `Phone.named` know, short forms left out."""
    return list(_PRESETS)


def two_way_split(frequency_hz: ArrayLike, top_db: ArrayLike, bottom_db: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Speaker, top and bottom microphone responses, (K,) dB each, from two measured speaker-to-microphone responses.

    The measurement cannot tell speaker from microphone: what the two channels share (their mean in dB) is given to the
    speaker, what each deviates from it to its microphone, so that speaker plus microphone is the measured response.
    Each channel is first set to 0 dB mean power over 18-22 kHz: its absolute level belongs to the distance.
    """
    top, bottom = (_to_unit_power(frequency_hz, level) for level in (top_db, bottom_db))
    shared = 0.5 * (top + bottom)
    return shared, top - shared, bottom - shared


def _to_unit_power(frequency_hz: ArrayLike, level_db: ArrayLike) -> Floats:
    frequency, level = np.asarray(frequency_hz, dtype=np.float64), np.asarray(level_db, dtype=np.float64)
    inside = (frequency >= REFERENCE_BAND_HZ[0]) & (frequency <= REFERENCE_BAND_HZ[1])
    return level - 10.0 * np.log10(np.mean(10.0 ** (level[inside] / 10.0)))


def _geometry(name: str, length_m: float) -> PhoneGeometry:
    top = 0.5 * length_m
    mics = np.array([[0.0, top, 0.0], [0.0, -top, 0.0]])
    return PhoneGeometry(name, np.array([0.0, top - SPEAKER_TO_TOP_MIC_M, 0.0]), mics)


def _structure_borne(geometry: PhoneGeometry) -> StructureBorne:
    """Ahead of the sound in the air and stronger than it, at both microphones.

    The two overlap: through the matched filter they peak together 13-14 us after emission at the top microphone and
    39-187 us at the bottom one, depending on the phone (at 20 C).
    """
    length = geometry.speaker_to_mic_m
    return StructureBorne(length / CASE_SOUND_SPEED_M_S, CASE_TO_AIR_GAIN / length)


def _phone(
    geometry: PhoneGeometry, frequency_hz: Floats, speaker_db: Floats, top_db: Floats, bottom_db: Floats
) -> PhonePreset:
    return PhonePreset(
        geometry,
        Transducer(frequency_hz, speaker_db, FORWARDS, SPEAKER_REAR_LOSS_DB),
        (
            Transducer(frequency_hz, top_db, FORWARDS, MIC_REAR_LOSS_DB),
            Transducer(frequency_hz, bottom_db, BACKWARDS, MIC_REAR_LOSS_DB),
        ),
        _structure_borne(geometry),
        level_spl_db=LEVEL_SPL_DB,
        noise_spl_db=NOISE_SPL_DB,
    )


def _ideal() -> PhonePreset:
    """What `Phone.ideal` is, 15 cm long."""
    flat = Transducer()
    return PhonePreset(_geometry("ideal", 0.15), flat, (flat, flat), None, LEVEL_SPL_DB, -np.inf)


def _galaxy_s5() -> PhonePreset:
    return _phone(_geometry("galaxy-s5", 0.141), TABLE_HZ, *two_way_split(TABLE_HZ, S5_TOP_DB, S5_BOTTOM_DB))


def _galaxy_note5() -> PhonePreset:
    frequency = np.array([15.0, 21.0, 21.5, 22.0, 22.5, 23.0, 23.5, 24.0, 25.0]) * 1e3
    level = np.array([0.0, 0.0, -1.0, -3.0, -7.0, -13.0, -22.0, -33.0, -50.0])
    return _phone(_geometry("galaxy-note5", 0.153), frequency, level, np.zeros(9), np.zeros(9))


def _galaxy_s8_plus() -> PhonePreset:
    frequency = np.array([15.0, 21.5, 22.0, 22.5, 23.0, 23.5, 24.0, 25.0]) * 1e3
    level = np.array([0.0, 0.0, -1.0, -3.0, -7.0, -13.0, -22.0, -40.0])
    return _phone(_geometry("galaxy-s8-plus", 0.160), frequency, level, np.zeros(8), np.zeros(8))


def _nexus_6p() -> PhonePreset:
    half = 0.5 * N6P_SEPARATION_M
    mics = np.array([[0.0, half, 0.0], [0.0, -half, 0.0]])
    speaker = np.array([0.0, N6P_SPEAKER_TO_BOTTOM_MIC_M - half, 0.0])
    shared, top, bottom = two_way_split(TABLE_HZ, N6P_TOP_DB, N6P_BOTTOM_DB)
    return PhonePreset(
        PhoneGeometry("nexus-6p", speaker, mics),
        Transducer(TABLE_HZ, shared, FORWARDS),
        (
            Transducer(TABLE_HZ, top, FORWARDS, MIC_REAR_LOSS_DB),
            Transducer(TABLE_HZ, bottom, BACKWARDS, N6P_REAR_LOSS_DB),
        ),
        _shadow_of_the_case(np.linalg.norm(mics - speaker, axis=1)),
        level_spl_db=LEVEL_SPL_DB,
        noise_spl_db=N6P_NOISE_SPL_DB,
    )


def _shadow_of_the_case(distance_m: Floats) -> StructureBorne:
    """What the case takes from the direct sound at the top microphone: an arrival of opposite sign along with it.

    Between speaker and top microphone lies the phone's whole length, and the measured level is that much below
    1 / distance; the bottom microphone's is 1 / distance.
    """
    kept = 10.0 ** (-np.array([N6P_SHADOW_DB, 0.0]) / 20.0)
    return StructureBorne(distance_m / AIR_M_S, (kept - 1.0) / distance_m)


_PRESETS: dict[str, Callable[[], PhonePreset]] = {
    "ideal": _ideal,
    "galaxy-s5": _galaxy_s5,
    "galaxy-note5": _galaxy_note5,
    "galaxy-s8-plus": _galaxy_s8_plus,
    "nexus-6p": _nexus_6p,
}
_ALIASES = {
    "s5": "galaxy-s5",
    "6p": "nexus-6p",
    "note5": "galaxy-note5",
    "s8+": "galaxy-s8-plus",
    "s8-plus": "galaxy-s8-plus",
    "galaxy-s8+": "galaxy-s8-plus",
}
