"""Named scenes, obstacle meshes, walks and gait, and ground truth from geometry."""

from scenes.approaches import DATA_COLLECTION, Approach, make_approach
from scenes.encounter import Encounter, load_encounter
from scenes.layouts import list_scenes, load_scene
from scenes.obstacles import walker_body
from scenes.routes import Pace, Route, RouteWalk, Stop
from scenes.truth import GroundTruth, ground_truth
from scenes.walks import Gait, GaitWalk

__all__ = [
    "DATA_COLLECTION",
    "Approach",
    "Encounter",
    "Gait",
    "GaitWalk",
    "GroundTruth",
    "Pace",
    "Route",
    "RouteWalk",
    "Stop",
    "ground_truth",
    "list_scenes",
    "load_encounter",
    "load_scene",
    "make_approach",
    "walker_body",
]
