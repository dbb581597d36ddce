"""The tables of a run hold what the figures show, cell by cell and beep by beep."""

from __future__ import annotations

from typing import Any

import pandas as pd
import pytest

from benchmarks.figures.measured import error_curve
from benchmarks.scoring.frames import beeps_frame, costs_frame, results_frame, write_frames
from benchmarks.scoring.scores import TRUE, approach_table, beep_table
from tests.benchmarks.synthetic_run import (
    BEARING_ERROR_RAD,
    RADIUS_ERROR_M,
    RANGE2_ERROR_M,
    RANGE_ERROR_M,
    failed,
    made_up_run,
    standing,
    walk,
)


def swept(cell: dict[str, Any], **variant: Any) -> dict[str, Any]:
    """The cell as a point of a sweep of gait and detectors' names, which the cell holds, too."""
    changed = cell["cell"] | {"variant": variant, "walk": {"gait_scale": variant.get("walk.gait_scale", 1.0)}}
    return cell | {"cell": changed}


def test_a_row_tells_errors_and_alerts(tmp_path):
    row = results_frame(made_up_run(tmp_path, [walk(index=3)])).iloc[0]
    assert row.range_error_median_m == pytest.approx(RANGE_ERROR_M)
    assert row.range_bias_median_m == pytest.approx(-RANGE_ERROR_M)
    assert row.range2_error_median_m == pytest.approx(RANGE2_ERROR_M)
    assert row.bearing_error_median_rad == pytest.approx(BEARING_ERROR_RAD)
    assert row.radius_error_median_m == pytest.approx(RADIUS_ERROR_M)
    assert (row.beeps, row.range_estimates, row.outcome, row["index"]) == (4, 3, "TP", 3)


def test_a_standing_phone_has_no_outcome(tmp_path):
    """Cause: its "TN" made a TN of 51 of 54 from results.csv where the report counts 18 of 18 walks."""
    frame = results_frame(made_up_run(tmp_path, [walk(collides=False, alert_distance_m=None), standing(1.5)]))
    frame = frame[frame.detector == "PaperDetector"]
    assert frame.outcome.tolist()[0] == "TN"
    assert frame[["outcome", "true_alert"]].isna().to_numpy().tolist() == [[False, False], [True, True]]
    (alone,) = results_frame(made_up_run(tmp_path, [standing(1.5, detectors=("PaperDetector",))])).outcome.tolist()
    assert pd.isna(alone)


def test_a_swept_parameter_is_a_column_with_the_value_that_each_cell_has(tmp_path):
    """The unchanged point of a sweep has no variant; its row says the value all the same."""
    cells = [swept(walk()), swept(walk(), **{"walk.gait_scale": 2.0}), swept(walk(), **{"walk.gait_scale": 0.5})]
    frame = results_frame(made_up_run(tmp_path, cells)).query("detector == 'PaperDetector'")
    assert frame["walk.gait_scale"].tolist() == [1.0, 2.0, 0.5]
    assert frame["point"].tolist()[1:] == ["walk.gait_scale=2", "walk.gait_scale=0.5"]
    assert frame["point"].isna().tolist() == [True, False, False]


def test_files_hold_the_frames(tmp_path):
    """Failed cells, walks, standing measurements: every column has one type, and Parquet keeps it."""
    run = made_up_run(tmp_path)
    assert [path.name for path in write_frames(run)] == [
        "results.csv", "results.parquet", "beeps.parquet", "costs.parquet",
    ]  # fmt: skip
    results = pd.read_parquet(tmp_path / "results.parquet")
    pd.testing.assert_frame_equal(results, results_frame(run))
    again = pd.read_csv(tmp_path / "results.csv")
    assert again.columns.tolist() == results.columns.tolist()
    pd.testing.assert_series_equal(again.range_error_median_m, results.range_error_median_m)
    assert results.query("status == 'failed'").error.tolist() == ["ValueError: no <mesh>"] * 2
    assert len(pd.read_parquet(tmp_path / "costs.parquet")) == 2 * 12 == len(costs_frame(run))


@pytest.mark.parametrize("kind", ["approach", "standing"])
def test_beeps_hold_what_error_figures_are_made_of(tmp_path, kind):
    """The same quantity has one value in table and figure."""
    run = made_up_run(tmp_path)
    table = beep_table(run, "PaperDetector", kind)
    beeps = beeps_frame(run).merge(results_frame(run)[["label", "detector", "kind"]], on=["label", "detector"])
    beeps = beeps.query("kind == @kind and detector == 'PaperDetector'")
    assert len(beeps) == len(table["label"]) > 0
    for estimate, truth in TRUE.values():
        curve = error_curve(table, estimate, truth, estimate.rpartition("_")[2], "", "", 0.8)
        assert curve.n == (beeps[estimate] - beeps[truth]).count()
    assert set(table) - set(beeps) == {"scene", "category", "phone", "standing_range_m"}  # these are in `results`


def test_rates_follow_from_rows(tmp_path):
    run = made_up_run(tmp_path)
    rows = results_frame(run).query("kind == 'approach' and detector == 'PaperDetector' and status == 'ok'")
    table = approach_table(run, "PaperDetector")
    assert rows.query("collides").true_alert.mean() == table["true_alert"][table["collides"]].mean()
    assert set(table) <= set(rows)


def test_nothing_measured_is_an_empty_table_not_a_crash(tmp_path):
    run = made_up_run(tmp_path, [failed(walk()), failed(standing(1.5))])
    assert results_frame(run).status.tolist() == ["failed", "failed"]
    assert len(beeps_frame(run)) == len(costs_frame(run)) == 0
    assert write_frames(run)
