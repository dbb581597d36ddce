"""Partial shadows over Fresnel zones: by what stands before them, not by the ground that an obstacle stands on."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from scenes import GaitWalk
from scenes.checks.requirements import integrals_needed
from simulator import Material, Obstacle, Phone, Scene

PHONE = Phone.named("ideal")
FLOOR = Obstacle(
    trimesh.creation.box(extents=(30.0, 30.0, 0.2)).apply_translation([0.0, 0.0, -0.1]),
    Material.named("concrete"),
    "floor",
)


def post(name: str, x_m: float, y_m: float, radius_m: float) -> Obstacle:
    mesh = trimesh.creation.cylinder(radius=radius_m, height=2.0, sections=32)
    return Obstacle(mesh.apply_translation([x_m, y_m, 1.0]), Material.named("concrete"), name)


@pytest.mark.parametrize(("screen_y_m", "needed"), [(None, []), (0.03, ["post"]), (-1.5, [])])
def test_a_pole_before_half_the_zone_asks_for_the_integral(screen_y_m: float | None, needed: list[str]) -> None:
    """The zone of a post 2.5 m away is 0.1 m wide; the ground, over which its image goes on, hides nothing of it."""
    things = [FLOOR, post("post", 2.75, 0.0, 0.2)]
    if screen_y_m is not None:
        things.append(post("pole", 1.2, screen_y_m, 0.015))
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), duration_s=0.1, speed_m_s=0.0)
    assert [name for name in integrals_needed(Scene(things), PHONE, walk) if name == "post"] == needed
