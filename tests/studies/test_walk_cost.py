"""What a walk costs: by beep and category, in the transforms that its own walks were timed beside."""

from __future__ import annotations

from docs.studies.walk_cost import HEADER, rows


def test_a_row_weighs_beeps_and_the_last_one_categories():
    costs = {"wall": [(10, 200.0, 0.1), (30, 600.0, 0.2)], "car": [(20, 2000.0, 0.1)]}
    wall, car, mean = rows(costs)
    assert len(wall) == len(HEADER)
    assert wall == ("wall", "2", "40", "20 ms", "125")
    assert car == ("car", "1", "20", "100 ms", "1000")
    assert mean == ("mean", "3", "60", "60 ms", "562")
