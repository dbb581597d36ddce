"""How people walk: straight with gait, or along routes."""

from scenes.walks.gait_walk import Gait, GaitWalk
from scenes.walks.routes import Pace, Route, RouteWalk, Stop

__all__ = ["Gait", "GaitWalk", "Pace", "Route", "RouteWalk", "Stop"]
