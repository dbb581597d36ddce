"""Unknowns drawn for every walk: within their ends, by the walk's own seed, beside the walk as assumed."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.situations.variation import changed_scene
from benchmarks.cells.spec import SceneChange
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.plan.unknowns import DRAWN, UNKNOWNS, with_unknowns
from scenes import make_approach
from simulator import Phone


def test_every_walk_stands_beside_itself_with_unknowns_drawn():
    cells = plan_cells(load_suite("mixed", ["unknowns=drawn"]), "smoke")
    assumed, drawn = cells[::2], cells[1::2]
    assert assumed == plan_cells(load_suite("mixed"), "smoke")
    found = []
    for before, now in zip(assumed, drawn, strict=True):
        assert (before.seed, before.approach, before.collision) == (now.seed, now.approach, now.collision)
        assert now.label == f"{before.label}[{DRAWN}]"
        preset, phone = Phone.named(now.phone), now.phone_change
        changes = (phone.level_spl_db - preset.level_spl_db, phone.noise_spl_db - preset.noise_spl_db)
        found.append((*changes, now.scene_change.person_level_db, phone.mic_level_db[1]))
        assert phone.mic_level_db[0] == 0.0
    low, high = (np.array([getattr(u, name) for u in UNKNOWNS]) for name in ("low_db", "high_db"))
    shares = (np.array(found) - low) / (high - low)
    assert np.all((shares > 0.0) & (shares < 1.0))
    assert np.allclose(shares.mean(axis=0), 0.5, atol=5.0 / np.sqrt(12.0 * len(shares)))  # five deviations of a mean


def test_people_reflect_so_much_more_but_never_more_than_all():
    made = make_approach("campus", "pedestrian", 1)
    approach = Situation(made.scene, made.walk, made.phone, (made.target,))
    for level_db in (-4.0, 4.0, 30.0):
        scene = changed_scene(approach, SceneChange(person_level_db=level_db))
        for before, now in zip(approach.scene.obstacles, scene.obstacles, strict=True):
            reflected = [np.abs(np.array(o.material.normal_reflection)) for o in (before, now)]
            louder = 10.0 ** (level_db / 20.0) if before.category == "pedestrian" else 1.0
            assert reflected[1] == pytest.approx(np.minimum(reflected[0] * louder, 1.0), abs=1e-12)


def test_a_sweep_and_drawn_unknowns_are_refused_together():
    with pytest.raises(ValueError, match="unknowns must be 'assumed' in a suite with a sweep"):
        load_suite("bands", ["unknowns=drawn"])


def test_unknowns_do_not_follow_from_the_walk():
    """Cause: of a walk numbered 4 the beep's level and the walker's stature came from the same random numbers."""
    cell = next(cell for cell in plan_cells(load_suite("paper"), "ci") if cell.index == 4)
    walks = np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=(cell.index,))).uniform(size=5)
    drawn = with_unknowns(cell)
    share = (drawn.phone_change.level_spl_db - Phone.named(cell.phone).level_spl_db + 5.0) / 10.0
    assert np.abs(walks - share).min() > 1e-3
