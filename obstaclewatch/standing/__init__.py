"""Our detector for a phone held still."""

from obstaclewatch.standing.detector import StandingDetector

__all__ = ["StandingDetector"]
