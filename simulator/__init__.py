"""Echoes of meshed scenes as a phone records them: Scene, Phone, Pose -> Paths -> Recording."""

import obstaclewatch.compile_cache  # noqa: F401  before any function is compiled
from simulator.air import Air
from simulator.fidelity import Fidelity
from simulator.materials import Material
from simulator.paths import Paths
from simulator.phone import Phone
from simulator.pose import Pose, StraightWalk, Walk, held_rotation
from simulator.rejections import Rejections, trace_rejected
from simulator.render import render_walk
from simulator.scene import Obstacle, Scene
from simulator.trace import trace_paths

__all__ = [
    "Air",
    "Fidelity",
    "Material",
    "Obstacle",
    "Paths",
    "Phone",
    "Pose",
    "Rejections",
    "Scene",
    "StraightWalk",
    "Walk",
    "held_rotation",
    "render_walk",
    "trace_paths",
    "trace_rejected",
]
