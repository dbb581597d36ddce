"""`explain` names of what is not modelled what the scene could make."""

from __future__ import annotations

import numpy as np
import trimesh

from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.field.not_modelled import NOT_MODELLED

POSE = Pose(np.array([0.0, 0.0, 1.3]), held_rotation(heading_rad=0.0, pitch_rad=0.5))


def box(low: list[float], high: list[float], name: str) -> Obstacle:
    return Obstacle(trimesh.creation.box(bounds=[low, high]), Material.named("concrete"), name)


def ball() -> Obstacle:
    mesh = trimesh.creation.icosphere(radius=0.3, subdivisions=3)
    mesh.apply_translation([2.0, 0.0, 1.2])
    return Obstacle(mesh, Material.rigid(), "ball")


WALL = box([2.0, -2.0, 0.0], [2.1, 2.0, 3.0], "wall")
GROUND = box([-9.0, -9.0, -0.1], [9.0, 9.0, 0.0], "ground")


def left_out(*obstacles: Obstacle, fidelity: Fidelity | None = None) -> tuple[str, ...]:
    return trace_paths(Scene(obstacles), Phone.named("ideal"), POSE, fidelity).left_out


def told(lines: tuple[str, ...]) -> set[str]:
    """Of which of a few things lines speak."""
    words = ("two diffractions", "curved reflections", "a diffraction and a curve", "two obstacles", "of less than 60")
    return {word for word in words if any(word in line for line in lines)}


def test_lines_follow_from_what_is_there() -> None:
    """Cause: eleven lines stood under every scene, an empty one included."""
    assert left_out() == ()
    assert told(left_out(WALL)) == {"two diffractions"}
    assert told(left_out(ball())) == {"curved reflections"}
    assert told(left_out(WALL, GROUND)) == {"two diffractions", "two obstacles", "of less than 60"}
    assert told(left_out(WALL, GROUND, ball())) == told(NOT_MODELLED)


def test_a_fidelity_s_own_lines_stay() -> None:
    assert left_out(fidelity=Fidelity(mechanisms=("specular",)))[0].startswith("mechanism '")
    assert any("edge_order 1" in line for line in left_out(WALL))


def test_it_is_in_the_explanation() -> None:
    paths = trace_paths(Scene([ball()]), Phone.named("ideal"), POSE)
    assert all(f"  left out: {line}" in paths.explain().splitlines() for line in paths.left_out)
    assert "diffractions" not in paths.explain()
