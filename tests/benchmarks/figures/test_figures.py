"""Figures: what they plot is what was counted, nothing is plotted where nothing was measured, and bytes repeat."""

from __future__ import annotations

import csv
import math
import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks import figures
from benchmarks.figures import FIGURES, draw_figures, picture
from benchmarks.figures.data import MOST_POINTS, Bar, BarFigure, BarPanel, distribution_steps
from benchmarks.figures.draw.curves import axis_end
from benchmarks.figures.draw.page import WIDEST, leads_row, panel_axes
from benchmarks.figures.measured import against_paper, significant
from benchmarks.plan.figure_names import FIGURE_RULES, FIGURE_SUBJECTS
from benchmarks.plan.suite import list_suites, load_suite
from benchmarks.report.provenance import cost_lines
from benchmarks.scoring.paper_values import PaperValue
from benchmarks.scoring.statistics import exact_rate
from tests.benchmarks.synthetic_run import DETECTORS, made_up_run, standing, walk


def bars_of(figure: BarFigure) -> dict:
    return {(bar.group, bar.series[:2]): bar for panel in figure.panels for bar in panel.bars}


def texts_of(figure) -> list[str]:
    return [text.get_text() for ax in picture(figure).axes for text in ax.texts]


def test_rates_are_those_counted_by_hand(tmp_path):
    """3 of 4 collisions alerted in time, 1 of 2 others without an alert."""
    bars = bars_of(FIGURES["fig16"](made_up_run(tmp_path)))
    tp, tn = bars["PaperDetector", "TP"], bars["PaperDetector", "TN"]
    assert (tp.count, tn.count) == ("3/4", "1/2")
    assert (tp.value, tn.value) == (75.0, 50.0)
    assert (tp.low, tp.high) == pytest.approx((100 * exact_rate(3, 4).low, 100 * exact_rate(3, 4).high))


def test_false_alerts_have_both_denominators(tmp_path):
    figure = FIGURES["fig26"](made_up_run(tmp_path))
    bars = [bar for panel in figure.panels for bar in panel.bars if bar.group == "PaperDetector"]
    assert [bar.count for bar in bars] == ["1/6", "1/2"]
    assert bars[0].paper is not None
    assert bars[0].paper.display == 3.5
    assert bars[1].paper is None


def test_the_paper_stands_beside_ours_only_where_it_prints_a_number(tmp_path):
    run = made_up_run(tmp_path)
    scenes = bars_of(FIGURES["fig17"](run))
    assert scenes["supermarket", "TP"].paper.display == 94.6
    assert scenes["campus", "TN"].paper.display == 89.1
    for name in ("fig19", "fig20"):
        bars = bars_of(FIGURES[name](run))
        assert bars
        assert all(bar.paper is None for bar in bars.values())


def test_a_stratum_that_failed_is_no_data_and_never_zero(tmp_path):
    run = made_up_run(tmp_path)
    figure = FIGURES["fig17"](run)
    campus = bars_of(figure)["campus", "TP"]
    assert campus.n == 0
    assert math.isnan(campus.value)
    assert texts_of(figure).count("no data") == 2
    draw_figures(run, ["fig17"])
    with (tmp_path / "figures" / "fig17.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["group"] == "campus"]
    assert len(rows) == 2
    assert all(row["value"] == "" and row["n"] == "0" for row in rows)


def test_known_errors_come_out_as_curves_and_words(tmp_path):
    """Every estimate is 4 mm short to mic 0 and 12 mm long to mic 1; one beep in four has none."""
    figure = FIGURES["fig21"](made_up_run(tmp_path))
    near, far = (next(c for c in figure.curves if c.label == f"PaperDetector, Distance{k}") for k in (1, 2))
    assert (near.n, near.total) == (6, 8)
    np.testing.assert_allclose(near.value, 0.4, atol=1e-9)
    np.testing.assert_allclose(far.value, 1.2, atol=1e-9)
    assert "Distance1: median 0.40 cm" in figure.reading
    assert "6 of 8 beeps" in figure.reading
    assert [mark.paper.display for mark in figure.marks] == [0.25, 1.0, 2.0]


def test_bearing_and_radius_errors_in_degrees_and_centimetres(tmp_path):
    run = made_up_run(tmp_path)
    bearing, radius = FIGURES["fig24"](run), FIGURES["fig25"](run)
    np.testing.assert_allclose(bearing.curves[0].value, 5.0, rtol=1e-12)
    np.testing.assert_allclose(radius.curves[0].value, 2.0, rtol=1e-12)
    bins = [bar for panel in FIGURES["fig24_bins"](run).panels for bar in panel.bars]
    assert [bar.n for bar in bars_in(bins, "0–10°")] == [18, 18]  # 0.1 rad, 6 walks of 3 estimates
    assert [bar.n for bar in bars_in(bins, "10–20°")] == [0, 0]


def bars_in(bars, group):
    return [bar for bar in bars if bar.group == group]


def test_wide_targets_are_left_out_of_the_radius_figure_alone(tmp_path):
    run = made_up_run(tmp_path, [walk(radius_m=3.0, index=0), walk(radius_m=0.3, index=1)])
    assert FIGURES["fig25"](run).curves[0].n == 3


def test_one_walk_gives_no_interval(tmp_path):
    figure = FIGURES["fig21"](made_up_run(tmp_path, [standing(1.5)]))
    assert "median 0.40 cm, " in figure.reading


def test_detectors_besides_the_paper_s_get_their_own_panels(tmp_path):
    names = ("PaperDetector", "TrackingDetector", "DistanceOnlyDetector")
    run = made_up_run(tmp_path, [walk(detectors=names, index=k) for k in range(2)])
    assert [panel.title for panel in FIGURES["fig19"](run).panels] == ["PaperDetector", "TrackingDetector"]
    assert len(picture(FIGURES["fig19"](run)).axes) == 2


@pytest.mark.parametrize("cells", [[], [walk()]], ids=["nothing", "one walk"])
def test_all_figures_can_be_drawn_of_little(tmp_path, cells):
    run = made_up_run(tmp_path, cells)
    for name, builder in FIGURES.items():
        figure = builder(run)
        assert figure.name == name
        assert figure.title
        assert figure.reading
        list(figure.rows())
    some = ["fig2", "fig5", "fig16", "fig21", "table1", "tornado", "det"]  # one of every kind
    paths = draw_figures(run, some)
    assert len(paths) == 3 * len(some)
    assert all(path.stat().st_size > 0 for path in paths if path.suffix != ".csv")


def test_without_names_only_figures_with_data_are_drawn(tmp_path):
    drawn = {path.stem for path in draw_figures(made_up_run(tmp_path, [standing(3.0)]))}
    assert "fig22" in drawn
    assert not drawn & {"fig16", "fig21", "fig27", "extremes", "det"}


def test_a_suite_names_its_figures(tmp_path):
    paths = draw_figures(made_up_run(tmp_path, figures=["det", "pareto"]))
    assert {path.stem for path in paths} == {"det"}  # no cells of fidelity, so no pareto
    with pytest.raises(ValueError, match="figures must be among"):
        draw_figures(made_up_run(tmp_path, figures=["fig99"]))


def test_every_builder_has_a_rule_and_every_rule_a_builder():
    """A builder that the rules of `benchmarks.plan` forget would never be drawn, and nothing would say so."""
    assert set(figures._BUILDERS) == set(FIGURE_RULES) == set(FIGURE_SUBJECTS)


@pytest.mark.parametrize("suite", list_suites())
def test_shipped_suites_name_figures_that_there_are(suite):
    assert set(load_suite(suite).figures) <= set(FIGURES)


def test_a_run_without_walks_has_empty_rate_figures(tmp_path):
    run = made_up_run(tmp_path, [standing(3.0)])
    assert all(FIGURES[name](run).empty for name in ("fig16", "fig17", "fig19", "fig20", "fig26", "fig21"))
    assert not FIGURES["fig22"](run).empty
    assert "no data" in texts_of(FIGURES["fig16"](run))


def test_bytes_repeat_whatever_the_user_s_style(tmp_path):
    names = ["fig17", "fig21"]
    first = draw_figures(made_up_run(tmp_path / "a"), names)
    with mpl.rc_context({"font.size": 30.0, "svg.hashsalt": None, "axes.grid": False}):
        second = draw_figures(made_up_run(tmp_path / "b"), names)
    assert [path.name for path in first] == [f"{name}.{kind}" for name in names for kind in ("png", "svg", "csv")]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes(), one.name


def test_no_date_and_no_version_in_the_files(tmp_path):
    for path in draw_figures(made_up_run(tmp_path), ["fig16"]):
        content = path.read_bytes()
        assert b"Software" not in content
        assert b"<dc:date>" not in content
        assert mpl.__version__.encode() not in content


def test_an_unknown_figure_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"figures must be among .*fig16.* got \['fig99'\]"):
        draw_figures(made_up_run(tmp_path), ["fig99"])


def test_listing_figures_does_not_load_matplotlib():
    code = "import sys, benchmarks.figures; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_modules_can_be_imported_first():
    """The claims once lay outside the package and closed a circle that only some orders of import ran into."""
    code = """
import importlib, sys
for module in ("paper.paper_claims", "plots", "bench.sweeps"):
    for known in [name for name in sys.modules if name.startswith("benchmarks")]:
        del sys.modules[known]
    importlib.import_module(f"benchmarks.figures.{module}")
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@given(st.lists(st.one_of(st.floats(0.0, 1e3), st.just(math.nan)), max_size=3 * MOST_POINTS))
@settings(max_examples=40, deadline=None)
def test_distribution_steps_lie_on_the_full_distribution(errors):
    value, share = distribution_steps(errors)
    finite = np.sort([error for error in errors if not math.isnan(error)])
    assert len(value) == min(len(finite), MOST_POINTS)
    if len(finite):
        assert share[-1] == 1.0
        assert value[0] == finite[0]
        assert np.all(np.diff(share) > 0.0)
        at = np.round(share * len(finite)).astype(int) - 1
        np.testing.assert_array_equal(value, finite[at])


def test_comparison_with_the_paper_goes_by_the_interval():
    paper = PaperValue(0.9, "1", "here")
    assert against_paper(0.88, 0.80, 0.95, paper, True) == "inconclusive"
    assert against_paper(0.99, 0.95, 1.00, paper, True) == "better"
    assert against_paper(0.99, 0.95, 1.00, paper, False) == "worse"
    assert against_paper(math.nan, math.nan, math.nan, paper, True) == ""


def test_two_digits_count():
    assert [significant(x) for x in (0.0412, 0.41, 4.12, 41.2, 412.0, 0.0)] == [
        "0.041",
        "0.41",
        "4.1",
        "41",
        "412",
        "0",
    ]


def test_every_detector_is_in_the_overall_figure(tmp_path):
    groups = {group for group, _ in bars_of(FIGURES["fig16"](made_up_run(tmp_path)))}
    assert groups == set(DETECTORS)


def test_the_bearing_caption_says_where_this_run_s_targets_stand(tmp_path):
    """The caption said "straight ahead" also for the suite `bearing`, whose targets stand at 0 to 60 degrees."""
    ahead, aside = standing(1.5), standing(3.0, 1)
    assert "straight ahead" in FIGURES["fig24"](made_up_run(tmp_path, [ahead])).note
    aside["cell"]["bearing_rad"] = math.radians(30.0)
    note = FIGURES["fig24"](made_up_run(tmp_path, [ahead, aside])).note
    assert "straight ahead" not in note
    assert "at 0°, 30°" in note
    assert "Standing targets" not in FIGURES["fig24"](made_up_run(tmp_path, [walk()])).note


def test_wide_figures_have_rows():
    """Cause: five panels side by side, shrunk to the report's width, had letters of 5 pixels."""
    canvas, axes = panel_axes([3.0] * 5)
    rows = [ax.get_subplotspec().get_topmost_subplotspec().rowspan.start for ax in axes]
    assert rows == [0, 0, 1, 1, 2]
    assert canvas.get_size_inches()[0] <= WIDEST
    assert [leads_row(ax) for ax in axes] == [True, False, True, False, True]


def test_figures_of_distance_errors_have_one_axis(tmp_path):
    run = made_up_run(tmp_path)
    assert len({axis_end(FIGURES[name](run)) for name in ("fig21", "fig22", "fig23")}) == 1


def test_a_processor_time_is_that_of_walks_wherever_it_is_shown(tmp_path):
    """Cause: the report's cost pooled standing phones and points of a sweep, so that one beep had three times."""
    cells = [walk(index=k) for k in range(3)] + [standing(1.5, k) for k in range(9)]
    run = made_up_run(tmp_path, cells)
    spent = {**run.costs[0], "detect_cpu_s": dict.fromkeys(DETECTORS, 5.0)}
    run = replace(run, costs=(*run.costs[:3], *[spent] * 9))
    assert dict(cost_lines(run))["processor time of detection, PaperDetector"] == "1.0 ms a beep, median over walks"
    assert {row[4] for row in FIGURES["table1"](run).cells} == {"1.0 ms"}
    assert "PaperDetector: 1.0 ms a beep" in FIGURES["fig27"](run).reading


def test_a_value_above_its_interval_stands_on_its_bar():
    """Cause: a resampled quantile's interval may lie wholly below the value, which was then written on the whisker."""
    bar = Bar("0–10°", "P80", value=20.0, low=10.0, high=16.3, count="40", n=40)
    canvas = picture(BarFigure("one", "One", "error (°)", "°", (BarPanel("PaperDetector", (bar,)),), "", ""))
    (label,) = [text for text in canvas.axes[0].texts if text.get_text() == "20"]
    assert label.xy[1] == 20.0


def test_a_quantity_of_the_paper_has_one_mark_in_figures_beside_each_other(tmp_path):
    # They went by their place in the figure: Fig. 22 has no median, and its circle was what Fig. 21 shows by a square.
    run = made_up_run(tmp_path)
    marks = {(mark.label, mark.shape) for name in ("fig21", "fig22", "fig23") for mark in FIGURES[name](run).marks}
    assert len(marks) == len({label for label, _ in marks}) == 3
