"""Candidates are made anew, never written into; numbers of reflectors and their interactions."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction, Numbering


@pytest.fixture
def unwritten_columns(monkeypatch):
    """Every array of candidates must be in the end as it was when they were made.

    Arrays that refuse to be written would be another kind, for which a third of the simulator is compiled once more.
    """
    made, kept = Candidates.__init__, []

    def kept_in_mind(self, *args, **named):
        made(self, *args, **named)
        columns = [(name, getattr(self, name)) for name in Candidates.__dataclass_fields__]
        kept.extend((name, column, column.copy()) for name, column in columns)

    monkeypatch.setattr(Candidates, "__init__", kept_in_mind)
    yield
    assert kept
    for name, column, as_made in kept:
        np.testing.assert_array_equal(column, as_made, name)


def _street() -> Scene:
    ground = Obstacle(trimesh.creation.box((8.0, 8.0, 0.1)), Material.rigid(), "ground")
    ground.mesh.apply_translation([2.0, 0.0, -0.05])
    panel = Obstacle(trimesh.creation.box((0.004, 0.3, 0.3)), Material.rigid(), "panel")
    panel.mesh.apply_transform(trimesh.transformations.rotation_matrix(0.9, (0.0, 0.0, 1.0)))
    panel.mesh.apply_translation([1.5, 0.0, 1.2])
    balls = []
    for name, place in (("ball", [1.2, 0.5, 1.0]), ("other ball", [1.2, -0.5, 1.0])):
        balls.append(Obstacle(trimesh.creation.icosphere(2, 0.15), Material.rigid(), name))
        balls[-1].mesh.apply_translation(place)
    return Scene([ground, panel, *balls], Air.lossless())


@pytest.mark.usefixtures("unwritten_columns")
@pytest.mark.parametrize(
    ("settings", "kinds"),
    [
        ({"edge_order": 3, "edge_floor_db": -70.0}, {"direct", "specular", "curved", "edge", "mixed"}),
        ({"mechanisms": ("specular", "kirchhoff"), "facet_m": 0.03}, {"direct", "specular", "kirchhoff", "mixed"}),
        ({"edge_order": 2, "mechanisms": ("edges",)}, {"direct", "edge", "mixed"}),
    ],
)
def test_no_search_writes_into_candidates(settings, kinds):
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.05, 0.0], [0.0, -0.05, 0.0]])
    paths = trace_paths(_street(), phone, Pose([0.0, 0.0, 1.2], held_rotation(0.0)), Fidelity(**settings))
    assert set(paths.kind) == kinds


def test_interactions_are_told_by_the_numbers_of_reflectors():
    """Three patches, no smooth surface, two edges: number 3 is an edge, 5 the first body."""
    numbering = Numbering(np.array([0, 3, 3, 5]))
    told = numbering.interaction(np.array([-1, 0, 2, 3, 4, 5]))
    assert told.tolist() == [-1, 0, 0, Interaction.EDGE, Interaction.EDGE, Interaction.KIRCHHOFF]
    assert numbering.number(Interaction.KIRCHHOFF, [0, 1]).tolist() == [5, 6]
