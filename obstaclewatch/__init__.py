"""ObstacleWatch: obstacle detection with a phone's speaker and two microphones (2018 paper), and its recordings.

Everything here needs numpy, scipy and numba only, and knows nothing of any simulator.
"""

from __future__ import annotations

from typing import Any

import obstaclewatch.compile_cache  # noqa: F401  before any function is compiled
from obstaclewatch.alignment import NoBeepError
from obstaclewatch.beep import BeepDesign
from obstaclewatch.collision import Decision
from obstaclewatch.detection import Detection, Flag
from obstaclewatch.detectors import DistanceOnlyDetector, PaperDetector
from obstaclewatch.errata import Errata
from obstaclewatch.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.mic_phase import MicPhase, measure_mic_phase
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recording_health import Fault, RecordingHealth, inspect_recording
from obstaclewatch.settings import PaperSettings
from obstaclewatch.sound_speed import assumed_sound_speed
from obstaclewatch.tracking import TrackingDetector

__all__ = [
    "BeepDesign",
    "Decision",
    "Detection",
    "DistanceOnlyDetector",
    "EchoProfile",
    "Errata",
    "Fault",
    "Flag",
    "MatchedFilter",
    "MicPhase",
    "NoBeepError",
    "PaperDetector",
    "PaperSettings",
    "PhoneGeometry",
    "Recording",
    "RecordingHealth",
    "TrackingDetector",
    "assumed_sound_speed",
    "inspect_recording",
    "measure_mic_phase",
    "read_recording",
    "write_recording",
]


def __getattr__(name: str) -> Any:
    """Audio files are opened on demand only, so that a detector needs no sound library."""
    if name in ("read_recording", "write_recording"):
        from obstaclewatch import audio

        return getattr(audio, name)
    raise AttributeError(f"module 'obstaclewatch' has no attribute '{name}'")
