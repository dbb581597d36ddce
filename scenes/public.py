"""The public names of the scenes."""

from scenes.files.encounter import Encounter, load_encounter
from scenes.files.layouts import list_scenes, load_scene
from scenes.obstacles import walker_body
from scenes.streets.approaches import DATA_COLLECTION, Approach, make_approach
from scenes.truth.truth import GroundTruth, ground_truth
from scenes.walks.gait_walk import Gait, GaitWalk
from scenes.walks.routes import Pace, Route, RouteWalk, Stop

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
