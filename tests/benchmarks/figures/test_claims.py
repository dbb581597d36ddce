"""The paper's claims: complete, measured with exact intervals, and judged by the interval alone."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.figures.paper import claims_measured
from benchmarks.figures.paper.claims_measured import Measurement, more_often, oftener_of_pairs
from benchmarks.figures.paper.paper_claims import Claim, claim_rows, claims, claims_markdown, verdict
from benchmarks.scoring import paper_values
from tests.benchmarks.gated_runs import run_of
from tests.benchmarks.gates.verdicts import stored
from tests.benchmarks.synthetic_run import default_cells, made_up_run, standing, walk


@pytest.mark.parametrize(
    ("more", "low", "high", "word"),
    [
        (True, 0.95, 0.99, "reached"),
        (True, 0.90, 0.99, "reached"),
        (True, 0.85, 0.95, "inconclusive"),
        (True, 0.50, 0.89, "not reached"),
        (False, 0.50, 0.89, "reached"),
        (False, 0.85, 0.95, "inconclusive"),
        (False, 0.91, 0.99, "not reached"),
        (True, np.nan, np.nan, "inconclusive"),
    ],
)
def test_the_interval_judges(more: bool, low: float, high: float, word: str) -> None:
    claim = Claim("x", "here", "90 %", lambda _run, _name: None, 0.90, more, "paper")  # type: ignore[arg-type]
    assert verdict(claim, Measurement(0.5 * (low + high), low, high, 9, "9", "1")) == word


def test_an_order_is_judged_by_its_test() -> None:
    claim = Claim("x", "here", "more", lambda _run, _name: None, None, True, "paper")  # type: ignore[arg-type]
    yes, no = np.ones(20, dtype=bool), np.zeros(20, dtype=bool)
    assert verdict(claim, more_often(yes, no)) == "reached"
    assert verdict(claim, more_often(no, yes)) == "not reached"
    assert verdict(claim, more_often(yes, yes)) == "inconclusive"
    assert verdict(claim, more_often(yes, yes[:0])) == "not measured"


def test_the_same_walks_are_held_against_each_other() -> None:
    """Cause: two points of a sweep were taken for different walks: Fisher's p is 0.12 here, McNemar's 0.004."""
    first = {str(k): k < 62 for k in range(100)}
    second = {str(k): 14 <= k < 64 for k in range(100)}
    found = oftener_of_pairs(first, second)
    assert found.p_value == pytest.approx(0.0041809, rel=1e-4)
    assert (found.value, found.text) == (pytest.approx(0.12), "62.0 against 50.0 %")
    assert oftener_of_pairs(first, {}).n == 0


def test_sides_are_decided_by_the_walks_that_the_test_counts(monkeypatch, tmp_path) -> None:
    """Cause: one walk of many beeps on the right side made 10 walks on the wrong one, p = 0.01, "reached"."""
    label = np.array(["long"] * 90 + [f"short {k}" for k in range(10)])
    calls = (np.full(100, 20.0), label == "long", label)
    monkeypatch.setattr(claims_measured, "side_calls", lambda run, detector: calls)
    monkeypatch.setattr(claims_measured, "variants", lambda run: {"horizontal": run})
    found = claims_measured.side_known(made_up_run(tmp_path), "PaperDetector")
    assert found.p_value is not None
    assert found.p_value < 0.05
    assert found.value < 0.0
    assert found.text == "90.0 % of sides right"


def test_every_printed_number_is_a_claim() -> None:
    printed = [claim.value for claim in claims() if claim.value is not None]
    values = [paper_values.OVERALL, *paper_values.BY_SCENE.values(), *paper_values.BY_BAND.values()]
    wanted = [value.value for pair in values for value in pair]
    wanted += [v.value for v in (*paper_values.FALSE_ALERTS.values(), *paper_values.DISTANCE1_MEDIAN.values())]
    wanted += [paper_values.DISTANCE1_P90.value, paper_values.DISTANCE2_P90.value, paper_values.BEARING_MEDIAN.value]
    wanted += [paper_values.BEARING_P80.value, paper_values.RADIUS_MEDIAN.value, paper_values.RADIUS_P80.value]
    wanted += [paper_values.RADIUS_CORRELATION, *(row.used_mah for row in paper_values.ENERGY)]
    for value in wanted:
        assert value in printed
    assert len({claim.text for claim in claims()}) == len(claims())


def test_rows_of_a_made_up_run(tmp_path) -> None:
    few = {row.claim: row for row in claim_rows([made_up_run(tmp_path)])}
    assert few["Distance1 at 1.5 m, P90"].verdict == "inconclusive"  # of two places
    cells = default_cells() + [standing(1.5, index=k) for k in range(2, 29)]
    rows = {row.claim: row for row in claim_rows([made_up_run(tmp_path, cells)])}
    tp = rows["TP, both scenes"]
    assert (tp.ours, tp.count, tp.paper) == ("75.0 %", "3/4", ">93 %")
    assert tp.verdict == "inconclusive"
    near = rows["Distance1 at 1.5 m, median"]
    assert (near.ours, near.verdict) == ("0.40 cm", "not reached")
    assert rows["Distance1 at 1.5 m, P90"].verdict == "reached"
    assert rows["TP, 16-23 kHz"].verdict == "not measured"
    assert "see suite bands" in rows["TP, 16-23 kHz"].count


def test_a_perfect_order_of_four_is_no_proof(tmp_path) -> None:
    """Of the 24 orders of four things one rises and one falls: two-sided p is 1 in 12."""
    stored = walk()
    stored["cell"] |= {"kind": "signal", "category": "crests"}
    stored["result"]["signal"] = {"true_radius_m": [0.1, 0.2, 0.3, 5.0], "crest_samples": [80.0, 136.0, 176.0, 192.0]}
    rows = {row.claim: row for row in claim_rows([made_up_run(tmp_path, [stored])])}
    found = rows["crest wider for larger things"]
    assert (found.ours, found.interval, found.verdict) == ("rank correlation 1.00", "p = 0.083", "inconclusive")


def test_bands_are_measured_where_they_are_swept(tmp_path) -> None:
    cells = []
    for start, hits in ((16_000.0, 8), (18_000.0, 0)):
        for k in range(8):
            stored = walk(index=k, alert_distance_m=2.0 if k < hits else None)
            stored["cell"]["beep"] = {**stored["cell"]["beep"], "start_hz": start}
            stored["cell"]["variant"] = {"beep.start_hz": start}
            cells.append(stored)
    rows = {row.claim: row for row in claim_rows([made_up_run(tmp_path, cells)])}
    assert (rows["TP, 16-23 kHz"].count, rows["TP, 18-23 kHz"].count) == ("8/8", "0/8")
    assert rows["16-23 kHz has more true positives"].verdict == "reached"
    assert "100.0 against 0.0 %" in rows["16-23 kHz has more true positives"].ours


def test_orders_are_measured_where_both_sides_have_walks_of_both_kinds(tmp_path) -> None:
    """Cause: of the smoke tier's S8+ no walk collides, so its TN stood against the accuracy of the S5.

    A detector that never alerts had "100.0 against 50.0 %".
    """
    claim = "S8+ does better than S5 at the same place"
    old = [walk(index=k, collides=k < 5, alert_distance_m=None) for k in range(10)]
    new = [walk(phone="galaxy-s8-plus", index=k, collides=False, alert_distance_m=None) for k in range(10, 15)]
    rows = {row.claim: row for row in claim_rows([made_up_run(tmp_path, [*old, *new])])}
    assert rows[claim].verdict == "not measured"
    hits = [walk(phone="galaxy-s8-plus", index=k, alert_distance_m=None) for k in range(15, 20)]
    rows = {row.claim: row for row in claim_rows([made_up_run(tmp_path, [*old, *new, *hits])])}
    assert rows[claim].ours == "50.0 against 50.0 %"


def test_a_claim_is_taken_from_the_first_run_that_can(tmp_path) -> None:
    empty, full = made_up_run(tmp_path, []), made_up_run(tmp_path)
    assert claim_rows([empty, full]) == claim_rows([full])
    assert all(row.verdict == "not measured" for row in claim_rows([empty]))


def test_markdown_has_a_line_a_claim(tmp_path) -> None:
    rows = claim_rows([made_up_run(tmp_path)])
    text = claims_markdown(rows)
    assert text.count("\n| ") == len(rows) + 0  # one for each; the head opens the text
    assert all(line.count("|") == 8 for line in text.splitlines() if line.startswith("| "))
    assert "not measured here" in text.splitlines()[-1]


def test_claims_of_a_detector_that_no_run_has_are_refused(tmp_path) -> None:
    """A name misspelt gave a table in which nothing was measured, and exit code 0."""
    run = stored(run_of(tmp_path, [walk(index=k) for k in range(4)]), tmp_path / "run")
    done = CliRunner().invoke(cli, ["figures", str(run), "fig16", "--claims", "PapreDetector"])
    assert "got 'PapreDetector'" in str(done.exception)
    assert not (run / "claims.md").exists()
    assert CliRunner().invoke(cli, ["figures", str(run), "fig16", "--claims", "PaperDetector"]).exit_code == 0
    assert (run / "claims.md").is_file()
