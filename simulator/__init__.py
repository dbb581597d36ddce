"""Echoes of meshed scenes as a phone records them: Scene, Phone, Pose -> Paths -> Recording."""

from obstaclewatch.support.former_places import keep
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.phone.transducers import StructureBorne, Transducer
from simulator.rejections import Rejections, trace_rejected
from simulator.render import render_pieces, render_walk
from simulator.scene.air import Air
from simulator.scene.fidelity import Fidelity
from simulator.scene.materials import Material
from simulator.scene.pose import Pose, StraightWalk, Walk, held_rotation
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import trace_paths
from simulator.world.prepared_scene import PreparedScene

__all__ = [
    "Air",
    "Fidelity",
    "Material",
    "Obstacle",
    "Paths",
    "Phone",
    "Pose",
    "PreparedScene",
    "Rejections",
    "Scene",
    "StraightWalk",
    "StructureBorne",
    "Transducer",
    "Walk",
    "held_rotation",
    "render_pieces",
    "render_walk",
    "trace_paths",
    "trace_rejected",
]

keep(__name__, {"air": "scene.air", "fidelity": "scene.fidelity", "materials": "scene.materials", "pose": "scene.pose"})
