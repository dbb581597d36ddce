"""Named scenes, obstacle meshes, walks and gait, and ground truth from geometry."""

from typing import TYPE_CHECKING

from obstaclewatch.support.former_places import keep
from obstaclewatch.support.on_demand import loaded_on_demand

if TYPE_CHECKING:
    from scenes.public import *  # noqa: F403
    from scenes.public import __all__ as __all__
else:
    __getattr__, __dir__ = loaded_on_demand(__name__)

keep(
    __name__,
    {
        "approaches": "streets.approaches",
        "encounter": "files.encounter",
        "layouts": "files.layouts",
        "routes": "walks.routes",
    },
)
