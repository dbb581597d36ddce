"""All gates of a file on one run."""

from __future__ import annotations

from benchmarks.gates.baseline import Baseline
from benchmarks.gates.claims import judge_claims
from benchmarks.gates.config import Gates
from benchmarks.gates.physics import judge_physics
from benchmarks.gates.regression import judge_regression
from benchmarks.gates.verdict import Verdict
from benchmarks.runs.results import RunData


def judge(run: RunData, gates: Gates, baseline: Baseline | None, seed: int = 0) -> list[Verdict]:
    """Claims, regression, then physics.

    Args:
        run: a run, read back.
        gates: what must hold.
        baseline: what the regression is judged against; None leaves it unmeasured.
        seed: of the noise in the physics.
    """
    return [*judge_claims(run, gates), *judge_regression(run, gates, baseline), *judge_physics(gates.physics, seed)]


def is_complete(run: RunData) -> bool:
    """Whether every cell of the plan is there and none failed."""
    return len(run.ok) == len(run.manifest["plan"])
