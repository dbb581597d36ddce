"""Suites of one's own scene files: planned, computed, scored as approaches, and never mixed with a changed file."""

import json
from pathlib import Path

import pytest
import yaml

from benchmarks.cells.compute import compute
from benchmarks.cells.situations.own_scene import scene_situation
from benchmarks.cells.spec import counts_as
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import Suite, load_suite
from scenes.obstacles.solids import box

YARD = """
name: yard
ground: {material: asphalt}
obstacles:
  - {mesh: block.ply, units: cm, name: block, at_m: [3, 0], material: concrete, category: clutter}
walk: {start_m: [0, 0], duration_s: 2.5, vary: {lateral_m: 0.1}}
phone: {name: mine, length_m: 0.15}
"""


@pytest.fixture
def suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Suite:
    monkeypatch.chdir(tmp_path)
    box([40.0, 60.0, 150.0]).export("block.ply")
    Path("yard.yaml").write_text(YARD)
    data = {
        "name": "mine", "title": "My yard", "seed": 1, "tiers": {"full": {"fraction": 1.0}},
        "scenes": [{"file": "yard.yaml", "count": 2}, {"file": "yard.yaml", "count": 1, "phones": ["galaxy-note5"]}],
        "detectors": ["DistanceOnlyDetector"], "fidelity": {"max_order": 1},
    }  # fmt: skip
    Path("mine.yaml").write_text(yaml.safe_dump(data))
    return load_suite("mine.yaml")


def test_a_suite_plans_walks_through_a_scene_file(suite: Suite) -> None:
    cells = plan_cells(suite, "full")
    assert [cell.label for cell in cells] == ["yard/clutter/0", "yard/clutter/1", "yard/clutter/0"]
    assert [cell.phone for cell in cells] == ["mine", "mine", "galaxy-note5"]
    assert cells[0].seed != cells[1].seed
    assert cells[0].seed == cells[2].seed
    assert all(counts_as(json.loads(cell.model_dump_json()), "approach") for cell in cells)


def test_a_walk_through_a_scene_file_is_rendered_and_judged(suite: Suite) -> None:
    result = compute(plan_cells(suite, "full")[0])
    assert result["truth"]["targets"] == ["block"]
    assert result["truth"]["collides"]
    assert result["truth"]["contact_time_s"] == pytest.approx((3.0 - 0.2 - 0.1) / 1.3, abs=0.05)
    beeps = result["detectors"]["DistanceOnlyDetector"]["beeps"][0]
    assert len(beeps["true_range_m"]) > 15
    alert = result["detectors"]["DistanceOnlyDetector"]
    assert alert["alert"]
    assert 0.5 < alert["alert_distance_m"] < 3.0


def test_a_changed_mesh_makes_other_cells_and_is_refused_within_a_run(suite: Suite) -> None:
    before = plan_cells(suite, "full")[0]
    box([40.0, 60.0, 151.0]).export("block.ply")
    after = plan_cells(suite, "full")[0]
    assert before.digest("") != after.digest("")
    with pytest.raises(ValueError, match=r"scene file 'yard.yaml' or one of its meshes must not change during a run"):
        scene_situation(before)


def test_mistakes_in_the_file_are_said_before_anything_runs(suite: Suite) -> None:
    Path("yard.yaml").write_text(YARD.replace("concrete", "cheese"))
    with pytest.raises(ValueError, match=r"yard.yaml:5: obstacles\[0\].material: material must be one of"):
        plan_cells(suite, "full")
    Path("block.ply").unlink()
    Path("yard.yaml").write_text(YARD)
    with pytest.raises(FileNotFoundError, match=r"mesh file must exist, got block\.ply"):
        plan_cells(suite, "full")
