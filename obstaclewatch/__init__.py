"""ObstacleWatch: obstacle detection with a phone's speaker and two microphones (2018 paper), and its recordings.

Everything here needs numpy, scipy and numba only, and knows nothing of any simulator.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from obstaclewatch.support.former_places import keep
from obstaclewatch.support.on_demand import loaded_on_demand

if TYPE_CHECKING:
    from obstaclewatch.public import *  # noqa: F403
    from obstaclewatch.public import __all__ as __all__
else:
    __getattr__, __dir__ = loaded_on_demand(__name__)

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
