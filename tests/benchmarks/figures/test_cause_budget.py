"""The error budget: its plan repeats the same walks, and its figures show what was counted by hand."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from benchmarks.cells.compute import simulated_part
from benchmarks.cells.spec import Cell
from benchmarks.figures import FIGURES, draw_figures, picture
from benchmarks.figures.draw.interactive import interactive
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.plan.sweep import at_point
from scenes.preview.plotly_page import in_script
from tests.benchmarks.synthetic_run import made_up_run, walk

NAMES = ("cause_budget", "cause_strata", "cause_table")
TRACKING = ("TrackingDetector",)


def who(cell: Cell) -> tuple[Any, ...]:
    return cell.scene, cell.category, cell.index, cell.phone, cell.seed, cell.collision


def by_point(cells: list[Cell]) -> dict[str, list[Cell]]:
    points: dict[str, list[Cell]] = {}
    for cell in cells:
        points.setdefault(cell.variant["name"], []).append(cell)
    return points


@pytest.mark.parametrize("tier", ["smoke", "ci", "full"])
def test_every_point_has_the_same_walks_and_no_more_is_changed_than_it_says(tier: str) -> None:
    suite = load_suite("budget")
    points = by_point(plan_cells(suite, tier))
    first = points["as it is"]
    assert len(points) == len(suite.sweep.points) == 13
    assert {cell.collision for cell in first} == {True, False}
    for point in suite.sweep.points:
        there = points[point["name"]]
        assert [who(cell) for cell in there] == [who(cell) for cell in first]
        assert [at_point(cell, point) for cell in first] == there


def test_the_walks_are_those_of_the_paper_s_mix_on_the_split_for_tuning() -> None:
    """Shares of every stratum within one walk, and no walk of the split that is reported."""
    paper, budget = (load_suite(name) for name in ("paper", "budget"))
    mixes = [{(g.scene, c): n for g in suite.groups for c, n in g.counts.items()} for suite in (paper, budget)]
    totals = [sum(mix.values()) for mix in mixes]
    assert mixes[0].keys() == mixes[1].keys()
    for stratum, count in mixes[0].items():
        assert abs(count * totals[1] / totals[0] - mixes[1][stratum]) < 2.1, stratum  # counts are even: pairs
    seeds = [{cell.seed for cell in plan_cells(suite, "full")} for suite in (paper, budget)]
    assert not seeds[0] & seeds[1]


def test_what_changes_the_detector_alone_shares_the_simulation_of_the_point_before() -> None:
    first, told_less, *_ = plan_cells(load_suite("budget"), "smoke")
    assert told_less.knowledge.pitch is False
    assert simulated_part(first) == simulated_part(told_less)


def budget_run(tmp_path):
    """Six collisions and four others. "quiet" gains two collisions, loses one, and raises one false alert more."""
    distances = {"as it is": (2.0, 2.0, 0.5, None, None, None), "quiet": (2.0, None, 1.5, 1.5, None, None)}
    false = {"as it is": (True, False, False, False), "quiet": (True, True, False, False)}
    cells = []
    for name in distances:
        for k, distance in enumerate(distances[name]):
            scene = "campus" if k < 2 else "supermarket"
            cells.append(at_point_of(walk(scene, index=k, alert_distance_m=distance, detectors=TRACKING), name))
        for k, alert in enumerate(false[name], start=6):
            one = walk(
                "campus", "car", index=k, collides=False, alert_distance_m=2.0 if alert else None, detectors=TRACKING
            )
            cells.append(at_point_of(one, name))
    return made_up_run(tmp_path, cells, figures=list(NAMES))


def at_point_of(stored: dict, name: str) -> dict:
    return {**stored, "label": f"{stored['label']}[{name}]", "cell": {**stored["cell"], "variant": {"name": name}}}


def panel_of(figure, label: str):
    return next(panel for panel in figure.panels if panel.x_label.startswith(label))


def line_of(panel, label: str):
    return next(line for line in panel.lines if line.label == label)


def test_rates_and_paired_intervals_are_those_counted(tmp_path):
    figure = FIGURES["cause_budget"](budget_run(tmp_path))
    tp = line_of(panel_of(figure, "TP"), "TrackingDetector")
    np.testing.assert_allclose(tp.x, [100 * 2 / 6, 100 * 3 / 6])
    # two gained, one lost of six: Clopper and Pearson give 2 of 3 0.0943 to 0.9916, and 3 of 6 0.1181 to 0.8819
    shift = (2 * np.array([0.094299, 0.991596]) - 1) * 100.0 * 0.881883
    np.testing.assert_allclose([tp.low[1], tp.high[1]], np.clip(100 * 2 / 6 + shift, 0.0, 100.0), atol=1e-3)
    late = line_of(panel_of(figure, "TP"), "alert before contact, however late")
    np.testing.assert_allclose(late.x, [50.0, 50.0])  # one of them half a metre before
    assert line_of(panel_of(figure, "TN"), "TrackingDetector").x.tolist() == [75.0, 50.0]
    bearing = line_of(panel_of(figure, "bearing"), "TrackingDetector")
    np.testing.assert_allclose(bearing.x, 5.0)
    np.testing.assert_allclose(line_of(panel_of(figure, "range"), "80 % of the errors are below").x, 0.4)
    assert "no significant change" in figure.reading
    assert panel_of(figure, "TP").ticks == ("as it is", "quiet")


def test_strata_have_their_own_walks(tmp_path):
    figure = FIGURES["cause_strata"](budget_run(tmp_path))
    panels = {panel.title: panel for panel in figure.panels}
    assert list(panels) == ["wall", "car", "campus", "supermarket"]
    assert panels["campus"].x_label == "% of 2 and 4 walks"
    assert line_of(panels["campus"], "TP: alert with 1 m left (%)").x.tolist() == [100.0, 50.0]
    assert line_of(panels["supermarket"], "TP: alert with 1 m left (%)").x.tolist() == [0.0, 50.0]
    assert np.isnan(line_of(panels["car"], "TP: alert with 1 m left (%)").x).all()
    assert line_of(panels["car"], "TN: other walks without an alert (%)").x.tolist() == [75.0, 50.0]


def test_the_table_says_which_walks_differ(tmp_path):
    table = FIGURES["cause_table"](budget_run(tmp_path))
    rows = {row["removed"]: row for row in table.rows()}
    assert rows["as it is"]["change of TP (points)"] == "–"
    assert rows["as it is"]["TP (%)"] == "33.3 of 6"
    plain = {head: text.replace("\N{NO-BREAK SPACE}", " ") for head, text in rows["quiet"].items()}
    assert plain["change of TP (points)"].endswith("+2 -1, p = 1")
    assert plain["change of TN (points)"].endswith("+0 -1, p = 1")
    assert (plain["TP (%)"], plain["TN (%)"], plain["false alerts (%)"]) == ("50.0 of 6", "50.0 of 4", "20.0")
    assert plain["mean of both (%)"] == "50.0"
    assert plain["same beeps (°)"] == "5.0, 5.0"


def test_the_table_is_readable_at_the_report_s_width(tmp_path):
    """Twelve columns side by side took 16 inches, and heads ran into each other."""
    canvas = picture(FIGURES["cause_table"](budget_run(tmp_path)))
    canvas.draw_without_rendering()
    assert canvas.get_size_inches()[0] < 10.5
    words = [text.get_window_extent().padded(-0.5) for text in canvas.axes[0].texts]
    assert not any(one.overlaps(other) for one, other in itertools.combinations(words, 2))
    assert all(box.x1 <= canvas.bbox.width for box in words)


def test_a_walk_that_is_a_collision_at_one_point_alone_is_no_pair(tmp_path):
    """Without gait a body may pass what it met: such walks are left out, not counted as lost."""
    stays, turns = (walk(index=k, detectors=TRACKING) for k in range(2))
    passes = walk(index=1, collides=False, alert_distance_m=None, detectors=TRACKING)
    cells = [at_point_of(each, "as it is") for each in (stays, turns)]
    cells += [at_point_of(each, "no gait") for each in (stays, passes)]
    tp = line_of(panel_of(FIGURES["cause_budget"](made_up_run(tmp_path, cells)), "TP"), "TrackingDetector")
    assert tp.x.tolist() == [100.0, 100.0]
    table = FIGURES["cause_table"](made_up_run(tmp_path, cells))
    assert table.cells[1][1] == "100.0 of 1"
    assert math.isfinite(tp.low[1])


def test_figures_draw_and_a_run_without_a_sweep_has_none(tmp_path):
    drawn = draw_figures(budget_run(tmp_path), NAMES[::2])
    assert {path.name for path in drawn} == {f"{name}.{kind}" for name in NAMES[::2] for kind in ("png", "svg", "csv")}
    plain = made_up_run(tmp_path)
    assert all(FIGURES[name](plain).empty for name in NAMES)


def test_a_kind_without_a_collision_can_be_explored(tmp_path):
    """Its rate as it is was NaN, and with it a line of the chart: the run ended without a report."""
    charts = {name: interactive(FIGURES[name](budget_run(tmp_path))) for name in NAMES}
    assert charts["cause_strata"] is not None
    in_script(charts)
