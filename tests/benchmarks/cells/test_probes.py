"""Cells that are no walks: extremes against formulas, and the signals behind the paper's first figures."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.cells import compute as computing
from benchmarks.cells.compute import compute, simulated_part
from benchmarks.cells.probes import tessellations
from benchmarks.cells.situations import situation
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.runs.store import to_json


def probe(kind: str, name: str, **parameters) -> dict:
    cell = Cell(
        kind=kind, scene=kind, category=name, index=0, phone="galaxy-s8-plus", seed=7, collision=False,
        probe=parameters, detectors=(),
    )  # fmt: skip
    return compute(cell)[kind]


@pytest.mark.parametrize(
    ("kind", "name", "parameters", "message"),
    [
        ("numerics", "nothing", {}, "must be one of .*wall-distance"),
        ("numerics", "slivers", {"aspect": 10.0, "colour": 1}, "colour"),
        ("signal", "nothing", {}, "must be one of .*response"),
        ("signal", "body", {"colour": 1}, "colour"),
    ],
)
def test_an_unknown_probe_is_one_clear_error(kind, name, parameters, message):
    with pytest.raises(ValueError, match=message):
        probe(kind, name, **parameters)


def test_an_envelope_peaks_where_the_wall_is():
    signal = probe("signal", "envelope", things=[["wall", 3.0, 0.0]])
    level, axis = np.array(signal["level_db"]), np.array(signal["range_m"])
    near = np.abs(axis - signal["true_m"][0]) < 0.3
    assert abs(axis[near][level[near].argmax()] - signal["true_m"][0]) < 0.05
    assert np.abs(np.array(signal["candidate_m"]) - signal["true_m"][0]).min() < 0.05
    assert len(signal["threshold_db"]) == len(level)


def test_a_walk_up_to_a_wall_shows_it_closing_in():
    signal = probe("signal", "approach", category="wall")
    true = np.array(signal["true_m"])
    assert (np.diff(true) < 0.0).all()
    found = [min(row, key=lambda r: abs(r - t)) for row, t in zip(signal["candidate_m"], true, strict=True) if row]
    assert len(found) > 0.4 * len(true)
    level = np.array(signal["level_db"])
    assert level.shape == (len(true), len(signal["range_m"]))
    assert np.isfinite(signal["crest_samples"]).mean() > 0.5


def test_the_body_raises_what_comes_after_the_direct_sound():
    signal = probe("signal", "body")
    path = np.array(signal["path_m"])
    behind = np.abs(path - signal["body_m"]) < 0.1
    gained = np.array(signal["with_db"])[behind].max() - np.array(signal["without_db"])[behind].max()
    assert gained > 6.0


def test_what_changes_only_the_listening_shares_a_simulation(monkeypatch):
    calls = []
    render = situation.render_walk
    monkeypatch.setattr(situation, "render_walk", lambda *a, **k: calls.append(1) or render(*a, **k))
    computing._simulated.cache_clear()
    sweep = "sweep={over: {detector.votes_needed: [1, 3], knowledge.pitch: [true, false]}}"
    cells = plan_cells(load_suite("ranging", [sweep]), "smoke")[:4]
    assert len({simulated_part(cell).model_dump_json() for cell in cells}) == 1
    _, shared = [compute(cell) for cell in (cells[0], cells[-1])]
    assert len(calls) == 1
    computing._simulated.cache_clear()
    alone = compute(cells[-1])
    for result in (alone, shared):
        del result["cost"]
    assert to_json(alone) == to_json(shared)


def test_segments_from_sixteen_on_hardly_matter(monkeypatch):
    """Below, a round body is taken for a prism, whose faces mirror."""
    monkeypatch.setattr(tessellations, "SEGMENTS", (8, 16, 32))
    cell = Cell(
        kind="tessellation", scene="tessellation", category="cylinder", index=0, phone="galaxy-s5", seed=7,
        collision=False, probe={"radius_m": 0.2, "distance_m": 1.5}, detectors=(),
    )  # fmt: skip
    found = compute(cell)["fidelity"]
    worst = {name: np.abs(found[f"{name} segments"]["level_db"]).max() for name in (8, 16, 32)}
    assert len(found["32 segments"]["level_db"]) == 12
    assert worst[32] < 1e-3
    assert worst[16] < 0.01
    assert worst[8] > 1.0
    with pytest.raises(ValueError, match=r"must be positive, got 0\.0 and 1\.5"):
        compute(cell.model_copy(update={"probe": {"radius_m": 0.0, "distance_m": 1.5}}))


def test_a_frozen_world_reads_no_range_ahead():
    """A closing speed of 1 m/s at least is read 0.205 s ahead: 230 samples there and back."""
    cell = Cell(
        kind="motion", scene="motion", category="wall", index=0, phone="galaxy-s5", seed=7, collision=True,
        probe={"scene": "supermarket", "index": 0}, detectors=(),
    )  # fmt: skip
    found = compute(cell)["fidelity"]
    assert len(found["degree 0"]["delay_samples"]) == 2
    assert np.abs(found["degree 0"]["delay_samples"]).min() > 100
    assert np.abs(found["degree 3"]["delay_samples"]).max() <= 1
    assert np.abs(found["degree 3"]["level_db"]).max() < 1e-3
