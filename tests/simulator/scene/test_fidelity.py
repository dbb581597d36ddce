"""Levels of fidelity: what they imply and what they refuse."""

from __future__ import annotations

import pytest

from simulator import Fidelity


def test_levels_imply_their_settings_and_what_is_given_wins():
    assert Fidelity() == Fidelity(level="standard")
    assert Fidelity(level="reference").max_order == 3
    assert Fidelity(level="reference", max_order=1).max_order == 1
    fine, coarse = (Fidelity(level="auto", tolerance_db=t) for t in (0.1, 2.0))
    assert fine.max_order >= coarse.max_order
    assert fine.band_points > coarse.band_points
    assert fine.edge_share_db < coarse.edge_share_db


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"level": "draft"}, r"level must be one of \('standard', 'reference', 'auto'\), got 'draft'"),
        ({"tolerance_db": 0.0}, "tolerance_db must be positive"),
        ({"tolerance_db": float("nan")}, "tolerance_db must be positive"),
        ({"mechanisms": ("rays",)}, "mechanisms must be among"),
        ({"facet_m": 1.0}, "facet_m must lie"),
        ({"max_order": 2.5}, "max_order must be a whole number"),
        ({"max_range_m": float("inf")}, "max_range_m must be positive and finite"),
        ({"edge_floor_db": 3.0}, "edge_floor_db must not be positive"),
    ],
)
def test_what_is_out_of_range_is_refused_by_name(settings, rule):
    with pytest.raises(ValueError, match=rule):
        Fidelity(**settings)


def test_a_given_order_takes_mirrors_of_any_size():
    """The docstring said that whatever is not given follows from the level."""
    assert Fidelity().mirror_m2 > 0.0
    assert Fidelity(max_order=3).mirror_m2 == 0.0
    assert Fidelity(max_order=3, mirror_m2=0.02).mirror_m2 == 0.02
