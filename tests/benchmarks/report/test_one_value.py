"""A quantity has one definition and one value, wherever it is read: terminal, report, claims, tables and figures."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.bench import tabulated
from benchmarks.figures import figures_of, write_figures
from benchmarks.figures.paper.paper_claims import claim_rows, claims_markdown
from benchmarks.gates.quantities import per_walk, walk_tables
from benchmarks.report.report import write_report
from benchmarks.report.verdict_lines import verdict_lines
from benchmarks.runs.results import load_run
from benchmarks.runs.store import cell_path, to_json, write_cell
from tests.benchmarks.synthetic_run import MANIFEST, standing, walk

DETECTOR = "PaperDetector"
DEGREES, CM = 180.0 / math.pi, 100.0
RANGE, BEARING, RADIUS = ("range_m", CM), ("bearing_rad", DEGREES), ("radius_m", CM)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven collisions, six other walks and five standing phones, each beep with errors of its own; some walks with an
    even number of estimates, of which two are in the middle; one wide target,
    whose radius counts nowhere; stored, tabulated, drawn and reported as `run` does."""
    kept, rng = tmp_path_factory.mktemp("run"), np.random.default_rng(5)
    cells = [walk(index=k, alert_distance_m=(2.0, 0.7, None)[k % 3], detectors=(DETECTOR,)) for k in range(7)]
    cells += [walk(index=k, collides=False, alert_distance_m=(None, 1.0)[k == 8], detectors=(DETECTOR,),
                   radius_m=2.0 if k == 9 else 0.3) for k in range(7, 13)]  # fmt: skip
    cells += [standing(1.5, k, detectors=(DETECTOR,)) for k in range(5)]
    plan = [f"{k:064x}" for k in range(len(cells))]
    for k, (digest, cell) in enumerate(zip(plan, cells, strict=True)):
        own = json.loads(json.dumps(cell)) | {"digest": digest}
        beeps = own["result"]["detectors"][DETECTOR]["beeps"][0]
        for name, _ in (RANGE, BEARING, RADIUS):
            beeps[name] = [None if value is None else value + rng.normal(0.0, 0.05) for value in beeps[name]]
            beeps[name][-1] = None if k % 2 else beeps[name][-1]  # so that an odd and an even number are left
        write_cell(cell_path(kept, digest), to_json(own))
    (kept / "manifest.json").write_text(to_json(MANIFEST | {"plan": plan}))
    run, found = tabulated(kept)
    (kept / "terminal.txt").write_text("\n".join(verdict_lines(found)))
    (kept / "claims.md").write_text(claims_markdown(claim_rows([run], DETECTOR), DETECTOR))
    figures = figures_of(run)
    write_figures(kept, [drawn for drawn in figures if not drawn.figure.empty])
    write_report(run, (), figures)
    return kept


def test_tp_and_tn_are_one_number(folder: Path) -> None:
    table = pd.read_csv(folder / "results.csv")
    walks = table[table.kind == "approach"]
    for outcomes, terminal, report, claim, series in (
        (("TP", "FN"), "TP, before contact", "Alerts: TP: ", "TP, both scenes", "TP: "),
        (("TN", "FP"), "TN", "Alerts: TN: ", "TN, both scenes", "TN: "),
    ):
        right, wrong = ((walks.outcome == word).sum() for word in outcomes)
        bars = pd.read_csv(folder / "figures" / "fig16.csv")
        texts = {
            "terminal": _after(folder / "terminal.txt", terminal), "report": _after(folder / "report.md", report),
            "claims": _after(folder / "claims.md", claim),
            "figure": str(bars[bars.series.str.startswith(series)].value.item()),
        }  # fmt: skip
        _agree(100.0 * right / (right + wrong), texts)


@pytest.mark.parametrize(
    ("quantity", "state", "terminal", "report", "claim", "figure"),
    [
        (RANGE, "standing", "median range error, standing", "Standing: Distance1, median at 1.5 m",
         "Distance1 at 1.5 m, median", "fig21"),
        (BEARING, "approach", "median bearing error, walking", "Walking: bearing, median", "bearing, median", "fig24"),
        (RADIUS, "approach", "median radius error, up to 1 m wide, walking",
         "Walking: radius of targets up to 1 m wide, median", "radius, median", "fig25"),
    ],
)  # fmt: skip
def test_an_error_is_one_number(
    folder: Path, quantity: tuple[str, float], state: str, terminal: str, report: str, claim: str, figure: str
) -> None:
    (name, scale), beeps = quantity, pd.read_parquet(folder / "beeps.parquet")
    told = beeps[beeps.label.str.startswith("standing") == (state == "standing")]
    told = told[told.true_radius_m <= 0.5] if name == "radius_m" else told
    errors = scale * (told[name] - told[f"true_{name}"]).abs().dropna()
    curves = pd.read_csv(folder / "figures" / f"{figure}.csv")
    word = "Distance1" if figure == "fig21" else "walking"
    curve = curves[curves.curve == f"{DETECTOR}, {word}"]
    middle = [curve[share].error.iloc[0] for share in (curve.share >= 0.5, curve.share > 0.5)]
    texts = {
        "terminal": _after(folder / "terminal.txt", terminal), "report": _after(folder / "report.md", report),
        "claims": _after(folder / "claims.md", claim), "figure": f"{np.mean(middle):.4f}",
    }  # fmt: skip
    _agree(float(errors.median()), texts)


@pytest.mark.parametrize("quantity", ["range", "bearing", "radius"])
def test_a_row_of_results_is_the_median_of_its_beeps(folder: Path, quantity: str) -> None:
    unit = "rad" if quantity == "bearing" else "m"
    table, beeps = pd.read_csv(folder / "results.csv"), pd.read_parquet(folder / "beeps.parquet")
    error = (beeps[f"{quantity}_{unit}"] - beeps[f"true_{quantity}_{unit}"]).abs()
    if quantity == "radius":
        error = error.where(beeps.true_radius_m <= 0.5)
    assert set(error.groupby(beeps.label).count() % 2) == {0, 1}
    expected = error.groupby(beeps.label).median()
    found = table.set_index("label")[f"{quantity}_error_median_{unit}"]
    np.testing.assert_allclose(found, expected[found.index], rtol=1e-12)


@pytest.mark.parametrize("quantity", ["range_error", "range_bias", "range2_error", "bearing_error", "radius_error"])
def test_a_gate_sees_the_row_of_results(folder: Path, quantity: str) -> None:
    """Gates took the mean of the two values in the middle, and results the lower one; both took the radius of a wide
    target, which counts nowhere else."""
    table, run = pd.read_csv(folder / "results.csv").set_index("label"), load_run(folder)
    name, _, kind = quantity.rpartition("_")
    column = table[f"{name}_{kind}_median_{'rad' if name == 'bearing' else 'm'}"]
    for cells in ("approach", "standing"):
        gated = per_walk(walk_tables(run, DETECTOR, cells), quantity)
        assert len(gated) == (table.kind == cells).sum() > 0
        np.testing.assert_allclose(list(gated.values()), column[list(gated)], rtol=1e-12)


def _after(path: Path, label: str) -> str:
    """The first number after a label that begins a line or a cell."""
    (found,) = re.findall(rf"^[ |]*{re.escape(label)}[^\d\n]*?(?:\|[^|\n]*\|[^|\n]*)?[| ]+([\d.]+) ?(?:%|cm|degrees|°)",
                          path.read_text(), re.MULTILINE)  # fmt: skip
    return str(found)


def _agree(exact: float, texts: Mapping[str, str]) -> None:
    """Every place prints the exact value to its own digits."""
    for place, text in texts.items():
        digits = len(text.partition(".")[2])
        assert float(text) == pytest.approx(exact, abs=0.5000001 * 10.0**-digits), (place, text, exact)
