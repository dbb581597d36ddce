"""Levels of fidelity: what they imply, what they refuse, and the exact edge integral against the cheaper theory."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths


def _plate_echo(**settings) -> np.ndarray:
    plate = Obstacle(trimesh.creation.box((0.02, 0.6, 0.6)), Material.rigid(), "plate")
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.05, 0.0], [0.0, -0.05, 0.0]])
    paths = trace_paths(Scene([plate], Air.lossless()), phone, Pose([-1.5, 0.1, 0.05], held_rotation(0.0)), Fidelity(
        max_order=1, **settings,
    ))  # fmt: skip
    assert (paths.kind == "edge").any()
    return paths[paths.order > 0].transfer_function([18_000.0, 20_500.0, 23_000.0])


def test_uniform_theory_is_close_to_the_integral_on_a_plate_square_on():
    exact, cheaper = _plate_echo(), _plate_echo(diffraction="utd")
    ratio_db = 20.0 * np.log10(np.abs(cheaper) / np.abs(exact))
    assert 1e-3 < np.abs(ratio_db).max() < 3.0


def test_levels_imply_their_settings_and_what_is_given_wins():
    assert Fidelity() == Fidelity(level="standard")
    assert Fidelity(level="draft").diffraction == "utd"
    assert Fidelity(level="reference").max_order == 3
    assert Fidelity(level="reference", max_order=1).max_order == 1
    fine, coarse = (Fidelity(level="auto", tolerance_db=t) for t in (0.1, 2.0))
    assert fine.max_order >= coarse.max_order
    assert fine.band_points > coarse.band_points
    assert fine.edge_share_db < coarse.edge_share_db


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"level": "best"}, "level must be one of"),
        ({"tolerance_db": 0.0}, "tolerance_db must be positive"),
        ({"tolerance_db": float("nan")}, "tolerance_db must be positive"),
        ({"mechanisms": ("rays",)}, "mechanisms must be among"),
        ({"diffraction": "gtd"}, "diffraction must be"),
        ({"facet_m": 1.0}, "facet_m must lie"),
        ({"max_order": 2.5}, "max_order must be a whole number"),
        ({"max_range_m": float("inf")}, "max_range_m must be positive and finite"),
        ({"edge_floor_db": 3.0}, "edge_floor_db must not be positive"),
    ],
)
def test_what_is_out_of_range_is_refused_by_name(settings, rule):
    with pytest.raises(ValueError, match=rule):
        Fidelity(**settings)
