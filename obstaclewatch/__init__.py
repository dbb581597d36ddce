"""ObstacleWatch: obstacle detection with a phone's speaker and two microphones (2018 paper), and its recordings.

Everything here needs numpy, scipy and numba only, and knows nothing of any simulator.
"""

from __future__ import annotations

from typing import Any

import obstaclewatch.support.compile_cache  # noqa: F401  before any function is compiled
from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Decision, Detection, Flag
from obstaclewatch.paper.detectors import DistanceOnlyDetector, PaperDetector, PaperStandingDetector
from obstaclewatch.paper.errata import Errata
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import NoBeepError
from obstaclewatch.recordings.health import Fault, RecordingHealth, inspect_recording
from obstaclewatch.recordings.mic_phase import MicPhase, measure_mic_phase
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.sound_speed import assumed_sound_speed
from obstaclewatch.standing.detector import StandingDetector
from obstaclewatch.support.former_places import keep
from obstaclewatch.tracking.detector import TrackingDetector
from obstaclewatch.tracking.settings import TrackingSettings

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
    "PaperStandingDetector",
    "PhoneGeometry",
    "Recording",
    "RecordingHealth",
    "StandingDetector",
    "TrackingDetector",
    "TrackingSettings",
    "assumed_sound_speed",
    "inspect_recording",
    "measure_mic_phase",
    "read_recording",
    "write_recording",
]

keep(
    __name__,
    {
        "alignment": "recordings.alignment",
        "collision": "detection",
        "detectors": "paper.detectors",
        "errata": "paper.errata",
        "matched_filter": "signal.matched_filter",
        "mic_phase": "recordings.mic_phase",
        "recording_health": "recordings.health",
        "settings": "paper.settings",
    },
)


def __getattr__(name: str) -> Any:
    """Audio files are opened on demand only, so that a detector needs no sound library."""
    if name in ("read_recording", "write_recording"):
        from obstaclewatch.recordings import audio

        return getattr(audio, name)
    raise AttributeError(f"module 'obstaclewatch' has no attribute '{name}'")
