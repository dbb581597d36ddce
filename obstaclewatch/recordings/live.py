"""Beeps played and recorded on this machine, beep by beep: the extra `live`.

The one module that needs sounddevice; it is imported on use, so that the detectors run without it.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from types import ModuleType

import numpy as np

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.support.argument_types import as_numbers, check_types
from obstaclewatch.support.arrays import Singles


def live_pieces(beep: BeepDesign, duration_s: float, level: float = 0.5) -> Iterator[Recording]:
    """Play beeps on the default output and yield what the default stereo input receives, one period at a time.

    Where the machine lost samples the pieces simply follow one another: the detectors search the beep anew.

    Args:
        beep: what is played, and at which rate.
        duration_s: when to stop; infinity goes on until the reader stops.
        level: amplitude of the beep, full scale is 1.

    Raises:
        ValueError: a duration or level out of range; sounddevice is missing; or there is no such sound device.
    """
    check_types(beep=(beep, BeepDesign))
    duration_s, level = as_numbers(duration_s=duration_s, level=level)
    if not duration_s > 0.0:
        raise ValueError(f"duration_s must be positive, got {duration_s}")
    if not 0.0 < level <= 1.0:
        raise ValueError(f"level must lie in 0..1, got {level}")
    return _pieces(_sounddevice(), beep, duration_s, level)


def played_period(beep: BeepDesign, level: float) -> Singles:
    """(n,) what a loudspeaker is given of one beep and its gap."""
    return np.pad(level * beep.samples(), (0, beep.period_samples - len(beep.samples()))).astype(np.float32)


def _pieces(sound: ModuleType, beep: BeepDesign, duration_s: float, level: float) -> Iterator[Recording]:
    period = played_period(beep, level)[:, None]
    try:
        stream = sound.Stream(samplerate=beep.sample_rate_hz, channels=(2, 1), dtype="float32")
    except sound.PortAudioError as error:
        raise ValueError(f"a stereo input and an output at {beep.sample_rate_hz:.0f} Hz are needed: {error}") from error
    with stream:
        played = 0
        while played * beep.period_s < duration_s - 1e-9:
            stream.write(period)
            received, _ = stream.read(beep.period_samples)
            yield Recording(received.T, beep.sample_rate_hz)
            played += 1


def _sounddevice() -> ModuleType:
    try:
        return importlib.import_module("sounddevice")
    except (ImportError, OSError) as error:
        raise ValueError(f"live input needs the package sounddevice and PortAudio (extra 'live'): {error}") from error
