"""Our detector: tracks over beeps, and a test of the trajectory of each."""

from obstaclewatch.tracking.detector import TrackingDetector

__all__ = ["TrackingDetector"]
