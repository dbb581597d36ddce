"""Figures beyond bars and distribution functions: what they show is what was counted by hand."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.cells.compute import compute
from benchmarks.cells.spec import Cell
from benchmarks.figures import FIGURES, draw_figures, picture
from benchmarks.figures.plots import DrawingFigure, PlotFigure, TableFigure
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import variants
from benchmarks.scoring.energy import EnergyModel, charge_range_mah
from tests.benchmarks.synthetic_run import DETECTORS, default_cells, failed, made_up_run, record, standing, walk


def probe_record(kind: str, name: str, **parameters) -> dict:
    cell = Cell(
        kind=kind, scene=kind, category=name, index=0, phone="galaxy-s8-plus", seed=7, collision=False,
        probe=parameters, detectors=(),
    )  # fmt: skip
    return {**record(cell, {}, {}), "result": compute(cell)}


def at_variant(stored: dict, variant: dict) -> dict:
    return {**stored, "cell": {**stored["cell"], "variant": variant}}


def line_of(figure: PlotFigure, label: str, panel: int = 0):
    return next(line for line in figure.panels[panel].lines if line.label == label)


def test_a_run_is_cut_by_the_points_of_its_sweep(tmp_path):
    cells = [at_variant(walk(index=k), v) for k in range(3) for v in ({}, {"air.temperature_c": 40.0})]
    run = made_up_run(tmp_path, cells)
    parts = variants(run)
    assert list(parts) == ["as it is", "air.temperature_c=40"]
    assert [len(part.cells) for part in parts.values()] == [3, 3]
    assert [len(part.costs) for part in parts.values()] == [3, 3]


def test_other_figures_show_one_point_of_a_sweep_and_say_so(tmp_path):
    hot = {"air.temperature_c": 40.0}
    cells = [at_variant(walk(index=0), {}), at_variant(walk(index=0, alert_distance_m=None), hot)]
    figure = FIGURES["fig16"](made_up_run(tmp_path, cells))
    assert figure.panels[0].bars[0].count == "1/1"
    assert "'as it is' alone" in figure.note


def test_bands_stand_beside_the_paper_s(tmp_path):
    cells = []
    for start, hits in ((16_000.0, 2), (18_000.0, 1)):
        for k in range(4):
            stored = at_variant(walk(index=k, alert_distance_m=2.0 if k < hits else None), {"beep.start_hz": start})
            stored["cell"]["beep"] = {**stored["cell"]["beep"], "start_hz": start}
            cells.append(stored)
    bars = FIGURES["fig18"](made_up_run(tmp_path, cells)).panels[0].bars
    counts = {(bar.group, bar.series[:2]): (bar.count, bar.paper.display if bar.paper else None) for bar in bars}
    assert counts["16-23 kHz", "TP"] == ("2/4", 94.3)
    assert counts["18-23 kHz", "TP"] == ("1/4", 93.7)
    assert FIGURES["fig18"](made_up_run(tmp_path)).empty  # a run that sweeps nothing says nothing of bands


def test_tornado_shows_the_change_from_the_suite_as_it_is(tmp_path):
    cells = [at_variant(walk(index=k), {}) for k in range(4)]
    cells += [at_variant(walk(index=k, alert_distance_m=None), {"recording.identical": True}) for k in range(4)]
    figure = FIGURES["tornado_alerts"](made_up_run(tmp_path, cells))
    assert figure.panels[0].ticks == ("equal channels: yes",)
    assert line_of(figure, "PaperDetector, lower or only value").x.tolist() == [-100.0]
    errors = FIGURES["tornado"](made_up_run(tmp_path, cells))
    assert line_of(errors, "PaperDetector, lower or only value").x.tolist() == [0.0]  # the errors made up are the same


def test_alerts_by_miss_distance_and_before_contact(tmp_path):
    cells = [walk(index=k, alert_distance_m=distance) for k, distance in enumerate((2.0, 1.5, 3.0, 0.2))]
    run = made_up_run(tmp_path, [*cells, *default_cells()[4:]])  # misses of 0.8 and 0.9 m, one alerted
    by_miss = line_of(FIGURES["miss_distance"](run), "PaperDetector")
    assert by_miss.y.tolist() == [100.0, 50.0]
    early = line_of(FIGURES["alert_distance"](run), "PaperDetector")
    at = {distance: early.y[np.argmin(np.abs(early.x - distance))] for distance in (0.0, 1.0, 1.6, 2.5)}
    assert at == {0.0: 100.0, 1.0: 75.0, 1.6: 50.0, 2.5: 25.0}
    told = next(line for line in FIGURES["alert_distance"](run).panels[0].lines if line.style == "points")
    assert told.y.tolist() == [75.0, 75.0, 100.0]  # with 1, 0.5 and 0 m left
    np.testing.assert_allclose([told.low[1], told.high[1]], [19.41, 99.37], atol=0.01)  # exact, 3 of 4
    assert "75.0 % with 0.5 m, 100.0 % with 0 m or more left, of 4 collisions" in FIGURES["alert_distance"](run).reading


def test_fates_of_collisions_add_up(tmp_path):
    figure = FIGURES["losses"](made_up_run(tmp_path))
    shares = {line.label: line.x[0] for line in figure.panels[0].lines}
    assert [shares[name] for name in ("1 m left or more", "later", "not detected")] == [75.0, 25.0, 0.0]
    undetected = FIGURES["losses"](made_up_run(tmp_path, [walk(alert_distance_m=None)]))  # three beeps of four are few
    assert {line.label: line.x[0] for line in undetected.panels[0].lines}["not detected"] == 100.0


def test_calibration_of_claims_equal_to_the_errors(tmp_path):
    """Every made-up error is exactly one claimed deviation."""
    figure = FIGURES["calibration"](made_up_run(tmp_path))
    line = line_of(figure, "PaperDetector, walking")
    assert line.y[line.x < 0.99].max() == 0.0
    assert line.y[line.x > 1.01].min() == 100.0
    assert re.search(r"\b(100|0) % within one deviation", figure.reading)
    honest = line_of(figure, "as claimed")
    assert honest.y[np.argmin(np.abs(honest.x - 1.0))] == pytest.approx(68.27, abs=0.01)


def test_an_alert_after_contact_is_said_to_be_among_the_later_ones(tmp_path):
    figure = FIGURES["losses"](made_up_run(tmp_path, [walk(alert_distance_m=-0.2)]))
    assert "PaperDetector: 0 % alerted with 1 m left, 100 % later" in figure.reading
    assert "or after contact, where it is no true positive" in figure.note


def test_stated_probabilities_are_as_sure_as_their_walks(tmp_path):
    """Cause: three beeps each of four walks had the whiskers of twelve trials, though a walk has one outcome."""
    cells = [walk(index=k, probability=(0.95, 0.95, 0.95)) for k in range(4)]
    line = next(line for line in FIGURES["calibration"](made_up_run(tmp_path, cells)).panels[2].lines if len(line.x))
    assert (line.x.tolist(), line.y.tolist()) == ([pytest.approx(95.0)], [100.0])
    assert line.low is not None
    assert line.low[0] == pytest.approx(100.0 * 0.025**0.25)


def test_no_walk_that_passes_far_is_not_nan_percent(tmp_path):
    reading = FIGURES["miss_distance"](made_up_run(tmp_path, [walk()])).reading
    assert reading == "No data."


def test_error_budget_takes_the_reading_ahead_away(tmp_path):
    """A range read 0.205 s ahead of a walker at 1.3 m/s leaves nothing once that is removed."""
    stored = walk()
    beeps = stored["result"]["detectors"]["PaperDetector"]["beeps"][0]
    time = np.arange(40) * 0.09
    true = 5.0 - 1.3 * time
    beeps |= {"beep": list(range(40)), "time_s": time.tolist(), "true_range_m": true.tolist(),
              "range_m": (true - 0.205 * 1.3).tolist()}  # fmt: skip
    for name, values in list(beeps.items()):
        if len(values) != 40:
            beeps[name] = [values[-1]] * 40
    figure = FIGURES["error_budget"](made_up_run(tmp_path, [stored]))
    median = line_of(figure, "median").y
    assert median[0] == pytest.approx(26.65, abs=0.01)
    assert median[1] == pytest.approx(0.0, abs=0.01)
    assert [tick[:5] for tick in figure.panels[0].ticks] == ["walki", "walki", "noise"]  # nobody stood


def test_energy_is_the_stated_formula():
    model = EnergyModel(audio_w=0.4, core_w=0.8, slower=4.0, battery_v=4.0)
    assert model.charge_mah(0.00225, 0.09) == pytest.approx((0.4 + 0.1 * 0.8) * 0.5 / 4.0 * 1000.0)
    low, high = charge_range_mah(0.001, 0.09)
    assert low < EnergyModel().charge_mah(0.001, 0.09) < high


def test_energy_figures_read_the_costs(tmp_path):
    run = made_up_run(tmp_path)
    costs = tuple({"detect_cpu_s": dict.fromkeys(DETECTORS, 0.04), "beeps": 40} if c else {} for c in run.costs)
    figure = FIGURES["fig27"](replace(run, costs=costs))
    assert [line.y.tolist() for line in figure.panels[0].lines] == [[1.0], [1.0]]  # ms a beep
    assert line_of(figure, "the paper, measured", 1).y.tolist() == [64.0, 66.0, 50.0]
    table = FIGURES["table1"](replace(run, costs=costs))
    assert len(table.cells) == 6
    assert "model" in table.note


def test_fidelity_draws_error_against_cost(tmp_path):
    """Two poses of two microphones: 0.4 s of tracing is 0.2 s a pose. Each resolved echo counts: where two are equally
    loud the loudest is another one, hundreds of samples away, though both are right."""
    stored = standing(3.0)
    stored["cell"] |= {"kind": "fidelity"}
    errors = {"standard": [3.0] * 4, "auto 0.5 dB": [-0.1] * 4}
    stored["result"]["fidelity"] = {"reference": {"level_db": [0.0] * 4}} | {
        name: {
            "level_db": values, "delay_samples": [400.0] * 4, "correlation": [1.0] * 4,
            "resolved_db": [2.0 * value for value in values], "resolved_samples": [0.0] * 4,
        } for name, values in errors.items()
    }  # fmt: skip
    run = made_up_run(tmp_path, [stored])
    run = replace(run, costs=({"trace_cpu_s": {"reference": 4.0, "standard": 0.2, "auto 0.5 dB": 0.4}},))
    level, delay = FIGURES["pareto"](run).panels
    assert [(guide.text, guide.at) for guide in level.guides] == [
        ("standard", pytest.approx(100.0)),
        ("auto 0.5 dB", pytest.approx(200.0)),
    ]  # fmt: skip
    curve = level.lines[0]
    assert (curve.x, curve.y) == (pytest.approx([100.0, 200.0]), pytest.approx([6.0, 0.2]))
    assert delay.lines[0].y == pytest.approx([0.01, 0.01])  # none, drawn where the axis begins
    assert len(FIGURES["fidelity"](run).cells) == 3
    kept = {row[0]: row[5] for row in FIGURES["tolerance"](run).cells if row[1] == "all"}
    assert kept["reference"] == "-"
    assert kept["standard"].startswith("0.0 % (0/1")
    assert kept["auto 0.5 dB"].startswith("100.0 % (1/1")
    assert len(FIGURES["tolerance"](run).cells) == 6


def test_extremes_are_a_map_a_table_and_curves(tmp_path):
    cells = [probe_record("numerics", "wall-distance", distance_m=d) for d in (0.01, 1000.0)]
    cells.append(probe_record("numerics", "impossible", case="pressure of nothing"))
    bad = probe_record("numerics", "wall-distance", distance_m=1.0)
    bad["result"]["numerics"] |= {"verdict": "wrong", "worst": None}
    run = made_up_run(tmp_path, [*cells, bad])
    figure = FIGURES["extremes"](run)
    assert figure.panels[0].ticks == ("wall-distance", "impossible")
    assert line_of(figure, "correct").y.tolist() == [0.0, 0.0]
    assert (line_of(figure, "correct").x < 1e-6).all()
    assert line_of(figure, "wrong").x.tolist() == [1e3]
    assert "4 cases: 2 correct, 1 refused with a named error, 1 silently wrong" in figure.reading
    assert line_of(FIGURES["extremes_axes"](run), "correct").x.tolist() == [0.01, 1000.0]
    assert [row[:5] for row in FIGURES["extremes_table"](run).cells] == [
        ("wall-distance", "3", "2", "0", "1"), ("impossible", "1", "0", "1", "0"),
    ]  # fmt: skip
    assert FIGURES["extremes_table"](run).cells[1][5:] == ("–", "–")  # an error of 1e-15 was shown of what was refused


@pytest.fixture(scope="module")
def signals(tmp_path_factory) -> RunData:
    things = [["dustbin", 1.6, 0.35], ["wall", 4.2, 0.0]]
    cells = [
        probe_record("signal", "response"),
        probe_record("signal", "envelope", things=[["wall", 3.0, 0.0]]),
        probe_record("signal", "envelope", things=things),
        probe_record("signal", "approach", category="wall", start_m=2.5),
        probe_record("signal", "body"),
        probe_record("signal", "crests"),
    ]
    return made_up_run(tmp_path_factory.mktemp("signals"), cells)


@pytest.mark.parametrize("name", ["fig3", "fig4", "fig5", "fig6", "fig8", "fig9", "fig10", "fig12"])
def test_signals_are_drawn_from_what_is_stored(signals, name):
    figure = FIGURES[name](signals)
    assert not figure.empty
    assert "No data" not in figure.reading
    assert any(np.isfinite(line.y).any() for panel in figure.panels for line in panel.lines)
    assert len(list(figure.rows())) > 10


def test_drawings_show_the_bench_s_own_geometry(signals):
    bearing = FIGURES["fig7"](signals).panels[0]
    words = " ".join(shape.text for shape in bearing.shapes)
    d1, length, angle = 0.8, 0.16, math.radians(30.0)
    d2 = math.sqrt(d1**2 + length**2 + 2.0 * d1 * length * math.cos(angle))  # the law of cosines, by hand
    assert f"D2 = {100 * d2:.1f} cm" in words
    assert "L = 16.0 cm" in words
    flow = " ".join(shape.text for shape in FIGURES["fig2"](signals).panels[0].shapes)
    for name in ("MatchedFilter", "judge_motion", "walking_angle", "size_from_crest", "on_collision_course", "decide"):
        assert name in flow
    first = FIGURES["fig1"](signals).panels[0]
    assert sum(shape.role == "sound" for shape in first.shapes) >= 3
    street = FIGURES["fig14"](signals).panels[0]
    assert sum(shape.kind == "polygon" for shape in street.shapes) > 10
    assert len(FIGURES["fig13"](signals).panels) == 2


def test_drawings_and_tables_repeat_byte_for_byte(signals, tmp_path):
    names = ["fig5", "fig7", "claims"]
    first = draw_figures(replace(signals, folder=tmp_path / "a"), names)
    second = draw_figures(replace(signals, folder=tmp_path / "b"), names)
    kinds = {type(FIGURES[name](signals)) for name in names}
    assert kinds == {PlotFigure, DrawingFigure, TableFigure}
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
        assert one.stat().st_size > 0


def test_words_stay_on_the_page(signals):
    """No title, legend or small print is cut off at the picture's edge."""
    for name in ("fig3", "fig5", "fig12", "claims"):
        canvas = picture(FIGURES[name](signals))
        canvas.draw_without_rendering()
        edge = canvas.bbox.width
        for text in canvas.texts:
            assert text.get_window_extent().x1 <= edge + 1.0, (name, text.get_text())


def test_det_shows_every_operating_point_and_the_swept_threshold(tmp_path):
    """A detector with 1 false alert in 400 walks lay beyond the axis, which ended at 0.6 %."""
    stated = [(0.9, 0.95), (0.2, 0.3)]  # of collisions and of the other walks, but for one
    cells = [walk(index=k, collides=k % 2 == 0, alert_distance_m=None, probability=stated[k % 2]) for k in range(399)]
    cells += [walk(index=399, collides=False, probability=(0.5, 0.99))]
    figure = FIGURES["det"](made_up_run(tmp_path, cells))
    assert [panel.title for panel in figure.panels] == ["1 m left", "0.5 m left", "before contact"]
    for panel in figure.panels:
        assert panel.x_range is not None
        assert panel.y_range is not None
        for line in [line for line in panel.lines if line.key != "muted"]:
            assert panel.x_range[0] < line.x.min() <= line.x.max() < panel.x_range[1]
            assert panel.y_range[0] < line.y.min() <= line.y.max() < panel.y_range[1]
    assert "PaperDetector, 0.5 m left, at TN 97 %: TP 100.0 %" in figure.reading


def test_a_walk_without_a_beep_keeps_its_detectors_curve(tmp_path):
    """Cause: one score that is NaN took the line away, while sentences still had its operating points."""
    cells = [walk(index=k, collides=k % 2 == 0, probability=[0.1 * k, 0.05 * k]) for k in range(8)]
    cells.append(walk(index=8, probability=[]))
    lines = FIGURES["det"](made_up_run(tmp_path, cells)).panels[0].lines
    assert any(line.key == "PaperDetector" and line.style != "points" for line in lines)


def test_rates_by_stratum_count_the_walks_of_each(tmp_path):
    cells = [walk(index=0, overlap_m=0.05), walk(index=1, overlap_m=0.15, alert_distance_m=0.6)]
    cells += [walk(index=2, collides=False, clearance_m=0.2), walk(index=3, collides=False, alert_distance_m=None)]
    cells[0]["result"]["truth"] |= {"moving": True, "detection_index_db": 9.0}
    figure = FIGURES["strata"](made_up_run(tmp_path, cells))
    rows = {row[0]: row[2:] for row in figure.cells if row[1] == "PaperDetector"}
    counts = {name: [cell.rpartition(" ")[2] for cell in row[:4]] for name, row in rows.items()}
    assert counts["all walks"] == ["1/2", "2/2", "2/2", "1/2"]
    assert counts["close: overlap < 10 cm, clearance < 30 cm"] == ["1/1", "1/1", "1/1", "0/1"]
    assert counts["between: overlap 10–20 cm, clearance 30–50 cm"] == ["0/1", "1/1", "1/1", "–"]
    assert counts["clear-cut: overlap ≥ 20 cm, clearance ≥ 50 cm"] == ["–", "–", "–", "1/1"]
    assert counts["index < 10 dB"] == ["1/1", "1/1", "1/1", "–"]
    assert counts["target moves"] == ["1/1", "1/1", "1/1", "–"]
    assert rows["all walks"][4] == "–"  # no probability is stated


def test_at_tn_97_a_threshold_of_its_own_decides(tmp_path):
    """Two of three collisions are surer than the surest walk without one."""
    cells = [walk(index=i, probability=[p]) for i, p in enumerate((0.2, 0.6, 0.9))]
    cells += [walk(index=3 + i, collides=False, probability=[p]) for i, p in enumerate((0.1, 0.4))]
    rows = {row[:2]: row for row in FIGURES["strata"](made_up_run(tmp_path, cells)).cells}
    assert rows["all walks", "PaperDetector"][-1].endswith("2/3")


def test_strata_of_a_run_whose_standing_phones_have_a_detector_of_their_own(tmp_path):
    """A detector without walks has no categories: the table ended in a KeyError, and with it the run."""
    cells = [walk(detectors=["PaperDetector"]), standing(1.5, detectors=["OtherDetector"])]
    for order in (cells, cells[::-1]):
        rows = FIGURES["strata"](made_up_run(tmp_path, order)).cells
        assert {row[1] for row in rows} == {"PaperDetector"}
        assert ("wall", "PaperDetector") in [row[:2] for row in rows]


def test_only_walks_of_the_paper_s_recipe_are_held_against_it(tmp_path):
    """Close calls and people who cross were compared with the rates of a field test that had neither."""
    for recipe, held in (("paper", True), ("mixed", False)):
        run = made_up_run(tmp_path, [walk(index=k, collides=k < 4, recipe=recipe) for k in range(8)])
        for name in ("fig16", "fig17", "fig26"):
            assert any(bar.paper for panel in FIGURES[name](run).panels for bar in panel.bars) == held, name
        assert any(row[0].startswith("TP") for row in FIGURES["claims"](run).cells) == held


def test_the_guide_stands_at_the_run_s_own_half_width(tmp_path):
    """It stood at 0.25 m whatever the suite's scoring."""
    cells = [walk(index=k) for k in range(4)]
    for cell in cells:
        cell["cell"]["scoring"] |= {"half_width_m": 0.4}
    run = made_up_run(tmp_path, cells)
    assert [guide.at for guide in FIGURES["miss_distance"](run).panels[0].guides] == [0.4]


def test_a_tornado_says_points_and_walks_and_blows_up_no_zero(tmp_path):
    """Unchanged TN was drawn from -0.05 to 0.05, "change (%)", as if that were a scale."""
    cells = [at_variant(walk(index=k), {}) for k in range(4)]
    cells += [at_variant(walk(index=k), {"recording.identical": True}) for k in range(4)]
    figure = FIGURES["tornado_alerts"](made_up_run(tmp_path, cells))
    assert figure.panels[0].x_label == "change (percentage points)"
    assert figure.panels[0].x_range == (-1.2, 1.2)
    assert "The same walks (4)" in figure.note


def at_points(variants: list[dict[str, object]]) -> list[dict]:
    """Two walks at every point of a sweep."""
    walks = [walk(), walk(index=1, collides=False, alert_distance_m=None)]
    return [
        {**one, "label": f"{one['label']}{variant}", "cell": {**one["cell"], "variant": variant}}
        for variant in variants
        for one in walks
    ]


def test_a_sweep_of_one_number_has_its_axis(tmp_path):
    """Speeds of 0.8, 1.2 and 2 m/s were three rows of text at equal distances."""
    cells = at_points([{"walk.speed_m_s": speed} for speed in (2.0, 0.8, 1.2)])
    figure = FIGURES["sweep"](made_up_run(tmp_path, cells))
    assert figure.panels[0].x_label == "speed (m/s)"
    assert not figure.panels[0].ticks
    assert line_of(figure, "PaperDetector").x.tolist() == [0.8, 1.2, 2.0]


@pytest.mark.parametrize(
    "variants",
    [
        [{"name": "as it is"}, {"name": "quiet"}],
        [{"recording.identical": False}, {"recording.identical": True}],
        [{}, {"walk.speed_m_s": 2.0}, {"air.temperature_c": 40.0}],
    ],
    ids=["names", "flags", "two parameters"],
)
def test_points_that_are_no_numbers_of_one_kind_have_rows(tmp_path, variants):
    """Panels of a second row had no names, and those of the first the suite's, in rad."""
    panels = FIGURES["sweep"](made_up_run(tmp_path, at_points(variants))).panels
    assert [len(panel.ticks) for panel in panels] == [len(variants)] * 3
    assert "_rad=" not in "".join(panels[0].ticks)


def test_a_sweep_of_standing_phones_has_their_errors(tmp_path):
    """Cause: points without a walk were left out, and the figure was empty."""
    places = [standing(range_m, index=k) for k in range(3) for range_m in (1.5, 3.0)]
    cells = [at_variant(place, {"noise.level_spl_db": level}) for level in (20.0, 40.0) for place in places]
    figure = FIGURES["sweep"](made_up_run(tmp_path, cells))
    assert not figure.empty
    for panel, label, error in ((0, "range error, median (cm)", 0.4), (1, "bearing error, median (°)", 5.0)):
        line = line_of(figure, "PaperDetector", panel)
        assert figure.panels[panel].y_label == label
        assert (line.x.tolist(), line.y) == ([20.0, 40.0], pytest.approx([error, error]))
    assert "TP" not in figure.title + figure.reading


@pytest.mark.parametrize("name", ["points", "fig18", "tornado"])
def test_whether_points_have_the_same_walks_is_counted(tmp_path, name):
    """Cause: figures said so whatever the run held; a cell that fails at one point is missing there alone."""
    points = [{}, {"air.temperature_c": 40.0}]
    cells = [at_variant(walk(index=k), point) for point in points for k in range(4)]
    assert "The same walks (4) at every point." in FIGURES[name](made_up_run(tmp_path, cells)).note
    cells[-1] = failed(cells[-1])
    note = FIGURES[name](made_up_run(tmp_path, cells)).note
    assert "3 of 4 walks at every point, the others failed or are missing at some." in note
