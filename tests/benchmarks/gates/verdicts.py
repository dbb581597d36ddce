"""What tests of gates share: quantities watched, claims, and what became of them."""

from __future__ import annotations

from pathlib import Path

from benchmarks.gates.config import Gates
from benchmarks.gates.verdict import State, Verdict
from benchmarks.runs.results import RunData
from benchmarks.runs.store import cell_path, to_json, write_cell
from tests.benchmarks.gated_runs import DETECTOR

QUANTITIES = {
    "range_error": 0.005, "range_bias": 0.005, "path_difference_bias": 0.0005, "bearing_error": 0.02,
    "no_estimate": 0.02, "candidates": 0.1, "snr": 0.3, "alerts": 0.01,
}  # fmt: skip
REGRESSION = Gates.model_validate(
    {
        "title": "test",
        "regression": [{"detector": DETECTOR, "approach": QUANTITIES, "standing": {"range_error": 0.001}}],
    }
)


def states(verdicts: list[Verdict]) -> dict[str, State]:
    return {verdict.name: verdict.state for verdict in verdicts}


def red(verdicts: list[Verdict]) -> list[str]:
    return [verdict.name for verdict in verdicts if verdict.state is State.FAILED]


def claim(**values) -> Gates:
    return Gates.model_validate({"title": "test", "claims": [{"detector": DETECTOR, **values}]})


def stored(run: RunData, folder: Path) -> Path:
    """The run as files, as `obstaclewatch run` leaves it."""
    folder.mkdir()
    (folder / "manifest.json").write_text(to_json(run.manifest))
    for digest, cell in zip(run.manifest["plan"], run.cells, strict=False):
        write_cell(cell_path(folder, digest), to_json(cell | {"digest": digest}))
    return folder
