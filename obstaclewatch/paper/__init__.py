"""The paper's detector, section by section, with its errata named."""

from obstaclewatch.paper.detectors import DistanceOnlyDetector, PaperDetector, PaperStandingDetector
from obstaclewatch.paper.errata import Errata
from obstaclewatch.paper.settings import PaperSettings

__all__ = ["DistanceOnlyDetector", "Errata", "PaperDetector", "PaperSettings", "PaperStandingDetector"]
