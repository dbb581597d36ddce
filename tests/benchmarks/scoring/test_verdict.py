"""What `obstaclewatch run` says at its end."""

from __future__ import annotations

from typing import Any

from benchmarks.report.verdict_lines import verdict_lines
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import variants
from benchmarks.scoring.scores import summary
from tests.benchmarks.synthetic_run import made_up_run, standing, walk


def at(cell: dict[str, Any], scale: float) -> dict[str, Any]:
    """The cell as a point of a sweep."""
    changed = cell["cell"] | {"variant": {"walk.gait_scale": scale}}
    return cell | {"cell": changed, "label": f"{cell['label']}[walk.gait_scale={scale:g}]"}


def told(run: RunData) -> list[str]:
    return verdict_lines(summary(run, variants(run)))


def test_the_points_of_a_sweep_are_never_pooled(tmp_path):
    """Three points of four walks were told as twelve walks, with intervals as narrow as those of twelve."""
    cells = [
        at(walk(index=k, alert_distance_m=None if scale == 2.0 else 2.0), scale)
        for k in range(4)
        for scale in (0.0, 1.0, 2.0)
    ]
    run = made_up_run(tmp_path, cells)
    found = summary(run, variants(run))
    assert "detectors" not in found
    rates = [part["PaperDetector"]["tp"]["1"] for part in found["points"].values()]
    counts = [(rate["k"], rate["n"]) for rate in rates]
    assert counts == [(4, 4), (4, 4), (0, 4)]
    lines = told(run)
    assert [line for line in lines if line.startswith("[")] == [f"[walk.gait_scale={k}]" for k in (0, 1, 2)]
    rates = [line for line in lines if line.strip().startswith("TP")]
    assert len(rates) >= 9
    assert not any("of 12" in line for line in rates)


def test_nothing_is_said_of_what_the_run_has_no_cells_for(tmp_path):
    """Every run of walks alone ended in four lines a detector of "no estimate in 0 beeps"."""
    walks = told(made_up_run(tmp_path, [walk(index=k) for k in range(3)]))
    assert any(line.strip().startswith("TP") for line in walks)
    assert not any("standing" in line for line in walks)
    still = told(made_up_run(tmp_path, [standing(1.5, k) for k in range(3)]))
    assert any("median range error, standing" in line for line in still)
    assert not any("walking" in line or "TP" in line for line in still)


def test_a_single_cell_is_one_cell(tmp_path):
    """Cause: "1 cells, 0 failed"."""
    run = made_up_run(tmp_path, [walk()])
    assert verdict_lines(summary(run, variants(run)))[0] == "1 cell, 0 failed"
