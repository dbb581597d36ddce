"""What must change nothing: speaker and microphone in each other's place, and everything moved far away."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.gates.physics.measured import Measured
from simulator import Fidelity, Material, Obstacle, Paths, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 7)
TRIALS = 5
FAR_M = 1e6
RAYS = Fidelity(tolerance_db=np.inf)
TOP_M, BOTTOM_M = [0.0, 0.07, 0.0], [0.0, -0.07, 0.01]


def reciprocity_error(seed: int) -> Measured:
    """Greatest relative change of the transfer function when speaker and microphone trade places."""
    rng, errors, echoes = np.random.default_rng(seed), [], 0
    for _ in range(TRIALS):
        pose = _random_pose(rng, np.zeros(3), Rotation.identity())
        speaker = rng.uniform(-0.05, 0.05, 3).tolist()
        there = trace_paths(_street(), Phone.ideal(speaker, [BOTTOM_M, TOP_M]), pose)
        back = trace_paths(_street(), Phone.ideal(BOTTOM_M, [speaker, TOP_M]), pose)
        errors.append(_relative(_first(there), _first(back)))
        echoes += int(np.sum((there.order > 0) & (there.mic == 0)))
    return Measured(float(np.max(errors)), "relative", echoes)


def translation_error(seed: int) -> Measured:
    """Greatest relative change of the transfer function when all is turned and moved by up to 1000 km.

    Of rays: Kirchhoff's integral moves by up to 1 %, as rounding decides whether single spots at a shadow's border are
    lit.
    """
    rng, errors, echoes = np.random.default_rng(seed), [], 0
    phone = Phone.ideal([0.0, 0.05, 0.0], [TOP_M, BOTTOM_M])
    for _ in range(TRIALS):
        shift, turn = rng.uniform(-FAR_M, FAR_M, 3), Rotation.from_euler("ZYX", rng.uniform(-3.0, 3.0, 3))
        state = rng.bit_generator.state
        here = trace_paths(_street(), phone, _random_pose(rng, np.zeros(3), Rotation.identity()), RAYS)
        rng.bit_generator.state = state
        there = trace_paths(_street(shift, turn), phone, _random_pose(rng, shift, turn), RAYS)
        errors.append(_relative(*(paths.transfer_function(FREQUENCY_HZ) for paths in (here, there))))
        echoes += int(np.sum(here.order > 0))
    return Measured(float(np.max(errors)), "relative", echoes)


def _relative(first: NDArray, second: NDArray) -> float:
    return float(np.max(np.abs(first - second)) / np.max(np.abs(first)))


def _first(paths: Paths) -> NDArray:
    echoes = paths[(paths.mic == 0) & (paths.order > 0)]
    return echoes.transfer_function(FREQUENCY_HZ)[0]


def _random_pose(rng: np.random.Generator, shift: NDArray, turn: Rotation) -> Pose:
    place = np.array([0.0, 0.0, 1.3]) + rng.uniform(-0.2, 0.2, 3)
    held = held_rotation(float(rng.uniform(-0.4, 0.4)), float(rng.uniform(0.1, 0.7)))
    return Pose(turn.apply(place) + shift, turn * held)


def _street(shift: NDArray | None = None, turn: Rotation | None = None) -> Scene:
    """Wall, ground and post, with edges and mixed paths, moved as one."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if turn is None else turn.as_matrix()
    matrix[:3, 3] = 0.0 if shift is None else shift

    def placed(mesh: trimesh.Trimesh, centre: tuple[float, float, float], name: str) -> Obstacle:
        whole = trimesh.Trimesh(mesh.vertices + np.array(centre), mesh.faces, process=False)
        return Obstacle(whole.apply_transform(matrix), Material.rigid(), name)

    return Scene(
        [
            placed(trimesh.creation.box((0.2, 6.0, 3.0)), (3.1, 0.4, 1.5), "wall"),
            placed(trimesh.creation.box((20.0, 20.0, 0.2)), (0.0, 0.0, -0.1), "ground"),
            placed(trimesh.creation.cylinder(radius=0.3, height=2.0, sections=32), (1.8, -0.9, 1.0), "post"),
        ]
    )
