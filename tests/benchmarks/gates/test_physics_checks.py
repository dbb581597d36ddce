"""Checks of the physics: green on exact echoes, red on wrong ones, never green on nothing or NaN."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.gates.config import gates_path, load_gates
from benchmarks.gates.physics import CHECKS, judge_physics, moving, truth
from benchmarks.gates.physics.measured import Measured
from benchmarks.gates.verdict import State
from simulator import Air, Paths


def test_physics_is_exact_and_a_check_without_echoes_measured_nothing(monkeypatch):
    gates = load_gates(gates_path("project"))
    quick = {
        name: at_most
        for name, at_most in gates.physics.items()
        if not any(slow in name for slow in ("deviation", "moving", "extremes"))
    }
    quick |= {"range_deviation_30db": gates.physics["range_deviation_30db"]}
    assert len(quick) == 8
    assert [v.state for v in judge_physics(quick, seed=3)] == [State.PASSED] * len(quick)
    monkeypatch.setitem(CHECKS, "motion", lambda _: Measured(float("nan"), "relative", 0))
    assert judge_physics({"motion": 1.0})[0].state is State.UNMEASURED


def _nan_late(monkeypatch, owner, name, change):
    """What `owner.name` returns, changed after its first call."""
    real, calls = getattr(owner, name), []

    def late(*arguments, **named):
        calls.append(name)
        found = real(*arguments, **named)
        return change(found) if len(calls) > 2 else found

    monkeypatch.setattr(owner, name, late)


@pytest.mark.parametrize(
    ("check", "owner", "name", "change"),
    [
        ("reciprocity", Paths, "transfer_function", lambda found: np.nan * found),
        ("translation", Paths, "transfer_function", lambda found: np.nan * found),
        ("motion", moving, "to_rate", lambda found: np.nan * found),
        ("truth", truth, "ground_truth", lambda found: replace(found, range_m=np.nan * found.range_m)),
    ],
)
def test_physics_that_is_no_number_is_not_green(monkeypatch, check, owner, name, change):
    """Cause: max(worst, NaN) is `worst`, so that a check with a NaN after its first comparison passed."""
    _nan_late(monkeypatch, owner, name, change)
    assert judge_physics({check: 1.0})[0].state is State.UNMEASURED


def test_wrong_physics_is_red(monkeypatch):
    """Absorption off by a hundredth is 0.006 dB/m."""
    real = Air.absorption_db_m
    monkeypatch.setattr(Air, "absorption_db_m", lambda air, f: 1.01 * real(air, f))
    (verdict,) = judge_physics({"air_absorption": 1e-3})
    assert verdict.state is State.FAILED
    assert "air_absorption: worst" in verdict.message
