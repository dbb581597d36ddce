"""The public names of the detector."""

from obstaclewatch.beep import BeepDesign
from obstaclewatch.detection import Decision, Detection, Flag
from obstaclewatch.paper.detectors import DistanceOnlyDetector, PaperDetector, PaperStandingDetector
from obstaclewatch.paper.errata import Errata
from obstaclewatch.paper.settings import PaperSettings
from obstaclewatch.recording import PhoneGeometry, Recording
from obstaclewatch.recordings.alignment import NoBeepError
from obstaclewatch.recordings.audio import read_recording, write_recording
from obstaclewatch.recordings.health import Fault, RecordingHealth, inspect_recording
from obstaclewatch.recordings.mic_phase import MicPhase, measure_mic_phase
from obstaclewatch.signal.matched_filter import EchoProfile, MatchedFilter
from obstaclewatch.sound_speed import assumed_sound_speed
from obstaclewatch.standing.detector import StandingDetector
from obstaclewatch.tracking.detector import TrackingDetector
from obstaclewatch.tracking.settings import TrackingSettings
from obstaclewatch.walker.walking_speed import measured_walk_ratio

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
    "measured_walk_ratio",
    "read_recording",
    "write_recording",
]
