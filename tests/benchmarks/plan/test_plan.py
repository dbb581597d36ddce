"""Suites and the cells they plan."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import cell_seed, is_collision, plan_cells, plan_digest, thinned
from benchmarks.plan.suite import list_suites, load_suite
from scenes import DATA_COLLECTION


def walks(tier: str) -> list[Cell]:
    return [cell for cell in plan_cells(load_suite("paper"), tier) if cell.kind == "approach"]


def test_full_paper_suite_is_the_paper_s_data_collection() -> None:
    counts = Counter((cell.scene, cell.category) for cell in walks("full"))
    assert sum(counts.values()) == 1299
    assert sum(n for (scene, _), n in counts.items() if scene == "supermarket") == 821
    collected = {(scene, name): n for scene, study in DATA_COLLECTION.items() for name, n in study.cases.items()}
    assert counts == collected


def test_phones_are_those_of_the_scene_and_take_turns() -> None:
    for scene, study in DATA_COLLECTION.items():
        counts = Counter(cell.phone for cell in walks("full") if cell.scene == scene)
        assert set(counts) == set(study.phones)
        assert max(counts.values()) - min(counts.values()) <= 2 * len(study.cases)


@pytest.mark.parametrize("tier", ["smoke", "ci", "full"])
def test_every_tier_keeps_every_stratum_with_and_without_collision(tier: str) -> None:
    strata = {(cell.scene, cell.category, cell.collision) for cell in walks(tier)}
    assert strata == {(cell.scene, cell.category, cell.collision) for cell in walks("full")}


def test_half_of_the_walks_are_collisions() -> None:
    for tier in ("smoke", "ci", "full"):
        chosen = walks(tier)
        assert abs(sum(cell.collision for cell in chosen) - len(chosen) / 2) <= len(DATA_COLLECTION) * 5 / 2


def test_smaller_tiers_are_parts_of_larger_ones() -> None:
    digests = [{cell.digest("v") for cell in plan_cells(load_suite("paper"), t)} for t in ("smoke", "ci", "full")]
    assert digests[0]
    assert digests[0] < digests[1] < digests[2]


def test_cells_are_all_different() -> None:
    cells = plan_cells(load_suite("paper"), "full")
    assert len({cell.digest("v") for cell in cells}) == len({cell.label for cell in cells}) == len(cells)


@given(fraction=st.floats(0.0, 1.0), count=st.integers(1, 400))
@settings(max_examples=60)
def test_collisions_are_spread_evenly(fraction: float, count: int) -> None:
    assert abs(sum(is_collision(k, fraction) for k in range(count)) - fraction * count) <= 1.0


def test_splits_and_seeds_do_not_share_walks() -> None:
    test = load_suite("paper")
    others = [load_suite("paper", ["split=dev"]), load_suite("paper", seed=7)]
    used = {cell_seed(test, "s/wall", k) for k in range(50)}
    assert len(used) == 50
    for other in others:
        assert not used & {cell_seed(other, "s/wall", k) for k in range(50)}


def test_what_is_measured_and_by_which_source_names_a_cell() -> None:
    cells = plan_cells(load_suite("paper"), "smoke")
    changed = plan_cells(load_suite("paper", ["scoring.gate_m=0.4"]), "smoke")
    assert plan_digest(cells, "v") == plan_digest(cells, "v")
    assert plan_digest(cells, "v") != plan_digest(cells, "w")
    assert plan_digest(cells, "v") != plan_digest(changed, "v")


def test_limit_spreads_cells_over_the_list_and_a_larger_one_adds_some() -> None:
    whole = plan_cells(load_suite("paper"), "ci")
    kept = [thinned(whole, limit) for limit in (1, 7, 20)]
    assert kept[0] == whole[:1]
    for few, more in pairwise([*kept, whole]):
        assert all(cell in more for cell in few)
    place = [whole.index(cell) for cell in kept[2]]
    assert place == sorted(place)
    assert np.diff([*place, len(whole)]).max() < 2.0 * len(whole) / 20


def test_a_limit_keeps_the_walks_of_a_sweep_at_all_of_its_points() -> None:
    """Cause: cells were thinned one by one, so that two points of a sweep had different walks."""
    swept = plan_cells(load_suite("paper", ["sweep={over: {noise.level_spl_db: [20.0, 30.0, 50.0]}}"]), "smoke")
    kept = thinned(swept, 8)
    points = [{(c.scene, c.category, c.index) for c in kept if c.variant == point} for point in _points(kept)]
    assert [len(walks) for walks in points] == [2, 2, 2]
    assert points[0] == points[1] == points[2]
    assert [cell.variant for cell in thinned(swept, 2)] == _points(swept)[:2]


def _points(cells: list[Cell]) -> list[Any]:
    """The points of a sweep in the order of the plan."""
    found: list[Any] = []
    for cell in cells:
        if cell.variant not in found:
            found.append(cell.variant)
    return found


@pytest.mark.parametrize("parts", [2, 3, 4])
def test_limit_does_not_keep_step_with_what_alternates(parts: int) -> None:
    """Every other walk of the full tier was all of a campus's collisions and none of its other walks."""
    every = walks("full")
    kept = thinned(every, len(every) // parts)
    for scene in ("supermarket", "campus"):
        collisions = [cell.collision for cell in kept if cell.scene == scene]
        assert 0.4 < np.mean(collisions) < 0.6, scene


def test_a_stored_cell_can_be_read_back() -> None:
    for cell in plan_cells(load_suite("ranging"), "smoke"):
        assert Cell.model_validate_json(cell.model_dump_json()) == cell


@pytest.mark.parametrize("name", list_suites())
def test_shipped_suites_plan_cells_at_every_tier(name: str) -> None:
    suite = load_suite(name)
    assert {"smoke", "ci", "full"} <= set(suite.tiers)
    for tier in suite.tiers:
        assert plan_cells(suite, tier)


@pytest.mark.parametrize(
    ("settings_", "message"),
    [
        (["nonsense"], "dotted.key=value, got 'nonsense'"),
        (["colour=red"], "colour"),
        (["collision_fraction=1.5"], "collision_fraction: .* got 1.5"),
        (["scoring.gate_m=-1"], "scoring.gate_m: .* got -1"),
        (["split=train"], "split"),
        (["detectors=[Nothing]"], "Nothing"),
    ],
)
def test_bad_settings_are_one_clear_error(settings_: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_suite("paper", settings_)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-5", 1e-5), ("-2E3", -2e3), (".5e+1", 5.0), ("'1e-5'", "1e-5"), ('"1e-5"', "1e-5"), ("1e-5 m", "1e-5 m"),
        ("[1e-5, {a: 1e1, b: one}]", [1e-5, {"a": 10.0, "b": "one"}]), ("-Infinity", -np.inf), ("1.0e-5", 1e-5),
    ],
)  # fmt: skip
def test_a_number_with_an_exponent_is_a_number(text: str, value: object) -> None:
    """YAML 1.1 reads 1e-5 as a text, so that numbers handed over in Python became texts as well."""
    assert load_suite("paper", [f"settings.x={text}"]).settings == {"x": value}


def test_unknown_names_and_broken_files_say_what_there_is(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"suite must be one of .*paper.*got 'papers'"):
        load_suite("papers")
    with pytest.raises(ValueError, match="must exist"):
        load_suite(str(tmp_path / "none.yaml"))
    broken = tmp_path / "broken.yaml"
    broken.write_text("a: [1", encoding="utf-8")
    with pytest.raises(ValueError, match="must be YAML"):
        load_suite(str(broken))
    with pytest.raises(ValueError, match=r"tier must be one of .*smoke.* got 'tiny'"):
        plan_cells(load_suite("paper"), "tiny")
    with pytest.raises(ValueError, match="limit must be at least 1, got 0"):
        thinned(walks("smoke"), 0)


@pytest.mark.parametrize(
    ("name", "settings", "says"),
    [
        ("rangin", [], "got 'rangin', did you mean 'ranging'?"),
        ("paper", ["colision_fraction=0.3"], "n: is not a field here; did you mean 'collision_fraction'?"),
        ("paper", ["walk.speed=1.3"], "walk.speed: is not a field here; did you mean 'speed_m_s'?"),
        ("paper", ["standing.rang_m=[1.0]"], "standing.rang_m: is not a field here; did you mean 'range_m'?"),
        ("paper", ["groups=[{scene: campus, phones: [ideal], counts: {}, aproach: {}}]"], "did you mean 'approach'?"),
        ("paper", ["figures=[fig116]"], "did you mean 'fig16'?"),
        ("paper", ["zzz=1"], "zzz: is not a field here"),
    ],
)
def test_what_was_meant_is_said(name, settings, says):
    """A misspelt key was answered with "Extra inputs are not permitted"."""
    with pytest.raises(ValueError) as error:
        load_suite(name, settings)
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("scenes=[{file: a.yaml, count: 1, phones: [galaxy]}]", r"scenes\[0\].phones\[0\]: .*nexus-6p, got 'galaxy'"),
        ("name=../x", "name: must be letters, digits, spaces and _ . \\+ -, .* got '../x'"),
        ("tiers={smoke: }", "tiers.smoke: must be a table of keys, got nothing"),
        ("detectors=[]", r"detectors: must not be empty, got \[\]"),
        ("detectors=x", "detectors: must be a list, got 'x'"),
        ("split=all", "split: must be 'dev' or 'test', got 'all'"),
        ("title=3", "title: must be a text, got 3"),
    ],
)
def test_what_breaks_the_schema_is_said_in_plain_words(setting, says):
    """Pydantic's words were passed on: patterns, tuples, our classes; and for a scene's phone its whole dump."""
    with pytest.raises(ValueError, match=f"^suite 'paper': {says}"):
        load_suite("paper", [setting])
