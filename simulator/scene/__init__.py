"""What stands in the world, what it is made of, and what is modelled of it: plain inputs."""

from simulator.scene.air import Air
from simulator.scene.fidelity import Fidelity
from simulator.scene.materials import Material
from simulator.scene.pose import Pose, StraightWalk, Walk, held_rotation
from simulator.scene.scene import Obstacle, Scene

__all__ = ["Air", "Fidelity", "Material", "Obstacle", "Pose", "Scene", "StraightWalk", "Walk", "held_rotation"]
