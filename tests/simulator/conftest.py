"""Small scenes that several tests share."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle, Phone


@pytest.fixture
def box() -> Callable[..., Obstacle]:
    """box(extents, centre, name): a rigid box."""

    def make(extents: tuple[float, ...], center: tuple[float, ...], name: str, **rest: object) -> Obstacle:
        mesh = trimesh.creation.box(extents, trimesh.transformations.translation_matrix(center))
        return Obstacle(mesh, Material.rigid(), name, **rest)

    return make


@pytest.fixture
def cylinder() -> Callable[..., Obstacle]:
    """cylinder(radius, height, centre, sections): a rigid upright cylinder named "cylinder"."""

    def make(radius: float, height: float, center: tuple[float, ...], sections: int) -> Obstacle:
        place = trimesh.transformations.translation_matrix(center)
        mesh = trimesh.creation.cylinder(radius=radius, height=height, sections=sections, transform=place)
        return Obstacle(mesh, Material.rigid(), "cylinder")

    return make


@pytest.fixture
def phone() -> Phone:
    """Speaker 2 cm below the upper of two microphones 14 cm apart."""
    return Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20180901)
