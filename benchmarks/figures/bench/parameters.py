"""Swept parameters in words and in the units that people read."""

from __future__ import annotations

from typing import Any

import numpy as np

_DEGREES = 180.0 / np.pi
_WORDS: dict[str, tuple[str, float]] = {
    "recording.mic_gain_db": ("gain of microphones (dB)", 1.0),
    "recording.mic_delay_samples": ("delay of microphones (samples)", 1.0),
    "recording.clock_ppm": ("recorder's clock (ppm)", 1.0),
    "recording.identical": ("equal channels", 1.0),
    "knowledge.pitch_error_rad": ("error of the pitch (°)", _DEGREES),
    "knowledge.temperature_error_c": ("error of the temperature (°C)", 1.0),
    "knowledge.walk_ratio": ("walker's own walk ratio known", 1.0),
    "noise.level_spl_db": ("noise (dB SPL)", 1.0),
    "phone.level_spl_db": ("beep (dB SPL)", 1.0),
    "walk.gait_scale": ("gait, times", 1.0),
    "walk.pitch_rad": ("pitch of the phone (°)", _DEGREES),
    "walk.speed_m_s": ("speed (m/s)", 1.0),
    "air.temperature_c": ("air (°C)", 1.0),
    "air.relative_humidity": ("relative humidity", 1.0),
    "beep.start_hz": ("start of the beep (kHz)", 1e-3),
    "beep.stop_hz": ("end of the beep (kHz)", 1e-3),
    "beep.taper": ("share of the beep in which it rises and falls", 1.0),
    "interferer.distance_m": ("distance of the second phone (m)", 1.0),
}
"""Parameter -> words with unit, and the factor to that unit."""


def in_words(parameter: str) -> str:
    """ "air, °C"; a parameter without words as the suite writes it."""
    return _WORDS.get(parameter, (parameter, 1.0))[0]


def scale_of(parameter: str) -> float:
    """Factor from the suite's unit to that of `in_words`."""
    return _WORDS.get(parameter, (parameter, 1.0))[1]


def value_text(parameter: str, value: Any) -> str:
    """A value in the unit of `in_words`."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{scale_of(parameter) * value:.3g}" if isinstance(value, int | float) else str(value)
