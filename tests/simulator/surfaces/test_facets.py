"""How many facets a body is cut into: as many as the size asks for, or none."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.surfaces import facets as module
from simulator.surfaces.facets import COARSEST_M, FACETS_A_SQUARE, can_cut, check_cut, facets_of
from simulator.surfaces.reflectors import read_mesh, reflectors_in


def _ball():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.2)
    reading = read_mesh(Obstacle(mesh, Material.rigid(), "ball"))
    return reading, reflectors_in(reading)[1]


def test_a_large_body_is_as_fine_as_asked_for(monkeypatch):
    """At `reference` cars of 47 m2 had facets of 2 cm and not of 12 mm, as at `auto`: errors of both did not show."""
    skin = _ball()
    fitting = int(FACETS_A_SQUARE * skin[0].mesh.area / COARSEST_M**2) + 1
    monkeypatch.setattr(module, "MOST_COARSE", fitting)
    coarse, fine = (facets_of(*skin, 0, size_m) for size_m in (COARSEST_M, 0.4 * COARSEST_M))
    assert len(fine) > 3.0 * len(coarse)


def test_a_body_too_large_is_refused(monkeypatch):
    skin = _ball()
    monkeypatch.setattr(module, "MOST_COARSE", 1000)
    assert not can_cut(skin[0], 0.01)
    assert can_cut(skin[0], 0.1)
    rule = r"facets of 0\.025 m over the 0\.5 m2 of 'ball' must not be more than 1000: choose larger"
    with pytest.raises(ValueError, match=rule):
        check_cut("ball", skin[0], 0.01)


def test_more_than_memory_takes_are_larger(monkeypatch):
    skin = _ball()
    monkeypatch.setattr(module, "MOST_FACETS", 20_000)
    assert 10_000 < len(facets_of(*skin, 0, 0.002)) < 22_000


def test_light_on_a_plate_is_asked_for_in_each_facet_but_not_in_rows():
    """Cause: a post's shadow passed the middles of a whole row of facets within a millimetre (-27 dB re a wall)."""
    reading = read_mesh(Obstacle(trimesh.creation.box([0.002, 0.6, 0.9]), Material.rigid(), "plate"))
    facets = facets_of(reading, None, 0, 0.04)
    side = facets[np.abs(facets.normal[:, 0]) > 0.9]

    def most_at_once_m2(place_m: np.ndarray) -> float:
        return float(np.histogram(place_m[:, 1], np.arange(-0.3, 0.3, 1e-3), weights=side.area_m2)[0].max())

    edge = side.corner_m[:, [1, 2, 0]] - side.corner_m
    to_the_left = np.cross(edge, side.asked_m[:, None] - side.corner_m)[..., 0] > 0.0
    assert np.isin(to_the_left.sum(axis=1), (0, 3)).all()
    assert most_at_once_m2(side.asked_m) < 0.4 * most_at_once_m2(side.middle_m)


def test_tracing_names_the_body_that_is_too_large():
    """Which of a scene's bodies was too large was not said."""
    ground = trimesh.creation.box(bounds=[[-20, -20, -0.1], [20, 20, 0]])
    pose, integrals = Pose([0.0, 0.0, 1.3], held_rotation(0.0)), Fidelity(mechanisms=("kirchhoff",))
    with pytest.raises(ValueError, match=r"facets of 0\.08 m over the 3\.22e\+03 m2 of 'ground' must not be more"):
        trace_paths(Scene([Obstacle(ground, Material.rigid(), "ground")]), Phone.named("ideal"), pose, integrals)
