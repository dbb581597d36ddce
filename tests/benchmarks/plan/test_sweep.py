"""Sweeps: which points are visited, and what a point changes in a cell."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.plan.sweep import Sweep, at_point


def cell(**changes: Any) -> Cell:
    given_: dict[str, Any] = {
        "kind": "approach", "scene": "supermarket", "category": "wall", "index": 0, "phone": "galaxy-s5", "seed": 1,
        "collision": True, "detectors": ("PaperDetector",),
    }  # fmt: skip
    return Cell(**(given_ | changes))


def test_a_grid_is_every_combination() -> None:
    sweep = Sweep.model_validate(
        {"over": {"beep.start_hz": [16e3, 18e3], "air.temperature_c": {"low": -10, "high": 40, "count": 3}}}
    )
    points = sweep.visited()
    assert len(points) == 6
    assert {(p["beep.start_hz"], p["air.temperature_c"]) for p in points} == {
        (f, t) for f in (16e3, 18e3) for t in (-10.0, 15.0, 40.0)
    }


def test_one_at_a_time_starts_from_the_suite_as_it_is() -> None:
    points = Sweep(
        method="one-at-a-time", over={"walk.gait_scale": [0.0, 2.0], "recording.clock_ppm": [50.0]}
    ).visited()
    assert points == [{}, {"walk.gait_scale": 0.0}, {"walk.gait_scale": 2.0}, {"recording.clock_ppm": 50.0}]


@given(samples=st.integers(2, 40), seed=st.integers(0, 99))
@settings(max_examples=25, deadline=None)
def test_a_latin_hypercube_has_one_point_in_every_stratum_of_every_parameter(samples: int, seed: int) -> None:
    over = {"noise.level_spl_db": {"low": 20.0, "high": 60.0}, "walk.pitch_rad": {"low": 0.0, "high": 1.0}}
    sweep = Sweep.model_validate({"method": "latin-hypercube", "over": over, "samples": samples, "seed": seed})
    points = sweep.visited()
    for name, ends in over.items():
        share = (np.array([point[name] for point in points]) - ends["low"]) / (ends["high"] - ends["low"])
        assert sorted(np.floor(share * samples).astype(int)) == list(range(samples))
    assert points == sweep.visited()


def test_a_log_range_has_even_ratios_and_random_points_stay_inside() -> None:
    over = {"scene.range_m": {"low": 0.1, "high": 10.0, "count": 5, "scale": "log"}}
    grid = [point["scene.range_m"] for point in Sweep.model_validate({"over": over}).visited()]
    np.testing.assert_allclose(np.diff(np.log(grid)), np.log(10.0) / 2)
    random = Sweep.model_validate({"method": "random", "over": over, "samples": 50}).visited()
    values = np.array([point["scene.range_m"] for point in random])
    assert len(np.unique(values)) == 50
    assert ((values >= 0.1) & (values <= 10.0)).all()


@pytest.mark.parametrize(
    ("name", "value", "path"),
    [
        ("scene.name", "campus", ("scene",)),
        ("scene.category", "sign", ("category",)),
        ("scene.range_m", 2.5, ("range_m",)),
        ("scene.bearing_rad", 0.3, ("bearing_rad",)),
        ("scene.beep_period_s", 0.1, ("approach", "beep_period_s")),
        ("scene.target_material", "brick", ("scene_change", "target_material")),
        ("walk.speed_m_s", 1.1, ("walk", "speed_m_s")),
        ("phone.name", "galaxy-note5", ("phone",)),
        ("phone.level_spl_db", 60.0, ("phone_change", "level_spl_db")),
        ("noise.level_spl_db", 45.0, ("phone_change", "noise_spl_db")),
        ("air.temperature_c", -5.0, ("air", "temperature_c")),
        ("beep.start_hz", 16e3, ("beep", "start_hz")),
        ("fidelity.max_order", 1, ("fidelity", "max_order")),
        ("recording.clock_ppm", 30.0, ("recording", "clock_ppm")),
        ("interferer.distance_m", 1.5, ("interferer", "distance_m")),
        ("knowledge.pitch", False, ("knowledge", "pitch")),
        ("detector.votes_needed", 3, ("settings", "votes_needed")),
        ("detector.errata.one_way_range", False, ("settings", "errata", "one_way_range")),
        ("scoring.gate_m", 0.4, ("scoring", "gate_m")),
    ],
)
def test_a_point_changes_its_field_and_the_name_alone(name: str, value: Any, path: tuple[str, ...]) -> None:
    before, after = cell().model_dump(mode="json"), at_point(cell(), {name: value}).model_dump(mode="json")
    node = after
    for part in path:
        node = node[part]
    assert node == value
    assert after["variant"] == {name: value}
    changed = {key for key in after if after[key] != before[key]}
    assert changed == {path[0], "variant"}
    assert at_point(cell(), {name: value}).digest("v") != cell().digest("v")


def test_the_detector_itself_can_be_swept() -> None:
    assert at_point(cell(), {"detector.name": "TrackingDetector"}).detectors == ("TrackingDetector",)


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ({"over": {"colour.red": [1]}}, "part.name with part one of"),
        ({"over": {"beep": [1]}}, "part.name"),
        ({"over": {"beep.start_hz": []}}, "must have values"),
        ({"over": {"beep.start_hz": {"low": 2.0, "high": 1.0}}}, "low must lie below high"),
        ({"over": {"beep.start_hz": {"low": 0.0, "high": 1.0, "scale": "log"}}}, "log"),
        ({"method": "random", "over": {"beep.start_hz": [1, 2]}}, "ranges with low and high"),
        ({"method": "list"}, "must have points"),
        ({"method": "grid"}, "must have over"),
    ],
)
def test_a_wrong_sweep_is_one_clear_error(sweep: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Sweep.model_validate(sweep)


def test_a_suite_is_planned_at_every_point_with_the_same_walks() -> None:
    plain = plan_cells(load_suite("paper"), "smoke")
    sweep = "sweep={over: {air.temperature_c: [0.0, 40.0], noise.level_spl_db: [20.0, 50.0]}}"
    swept = plan_cells(load_suite("paper", [sweep]), "smoke")
    assert len(swept) == 4 * len(plain)
    assert len({c.digest("v") for c in swept}) == len({c.label for c in swept}) == len(swept)
    assert {(c.seed, c.index, c.category) for c in swept} == {(c.seed, c.index, c.category) for c in plain}
    assert swept[1].label.endswith("[air.temperature_c=0, noise.level_spl_db=50]")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("recording.mic_gain_db.0", r"but 'mic_gain_db' is \[0.0, 0.0\]"),
        ("beep.start_hz.x", "but 'start_hz' is 18000.0"),
    ],
)
def test_a_name_below_a_plain_value_is_refused(name: str, message: str) -> None:
    """Cause: a number or a list was taken for a mapping: TypeError."""
    with pytest.raises(ValueError, match=f"swept '{name}' must name a value inside mappings, {message}"):
        at_point(cell(), {name: 1.0})


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("fidelity.max_ordre=2", "max_ordre"),
        ("fidelity.max_order=99", "max_order must be .* got 99"),
        ("scene_change={target_material: cheese}", "cheese"),
        ("air={temperature_c: 99.0}", "temperature_c must be .* got 99"),
        ("air={temprature_c: 20.0}", "temprature_c"),
        ("settings={votes_needed: 12}", "votes_needed"),
        ("settings={errata: {no_such: true}}", "no_such"),
        ("beep.stop_hz=99000", "half the sample rate"),
        ("detectors=[NoSuchDetector]", "no class 'NoSuchDetector'"),
        ("detectors=['no.such.module:Thing']", "cannot be imported"),
        ("sweep={over: {fidelity.max_order: [1, -1]}}", "max_order=-1.*got -1"),
        ("sweep={over: {walk.gait_scale: [1.0, 1.0]}}", "stand more than once, the first is 'supermarket/wall/0"),
        ("sweep={over: {beep.start_hz: [18000.001, 18000.002]}}", "stand more than once"),
        ("sweep={method: list, points: [{name: a}, {name: a, walk.gait_scale: 2.0}]}", r"the first is .*\[a\]"),
        ("sweep={over: {walk.speed_m_s: [-1.0]}}", r"sweep, at \[walk.speed_m_s=-1\]: .* got -1.0$"),
        ("sweep={over: {scene.name: [atlantis]}}", "scene must be one of .* got 'atlantis'"),
        ("sweep={over: {scene.category: [whale]}}", "category must be one of .* got 'whale'"),
        ("detectors=['PaperDetector(votes=3)']", "cannot be made: .*'votes'"),
        ("detectors=['PaperDetector(votes_needed=12)']", "votes_needed"),
        ("figures=[fig61]", "got .'fig61'"),
        ("name=../elsewhere", "name: .* got '../elsewhere'"),
        ("groups=[{scene: campus, phones: [galaxy-s5], counts: {wall: 2}, approach: {sped: 1}}]", "'sped'"),
    ],
)
def test_what_cannot_run_is_refused_before_anything_runs(setting: str, message: str) -> None:
    """Points that were the same, or whose labels were, counted each walk twice; unknown scenes, obstacles, figures and
    constants of detectors were found only by every cell failing; a name with dots left the folder of results.
    """
    with pytest.raises(ValueError, match=message):
        plan_cells(load_suite("paper", [setting]), "smoke")


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("sweep={over: {phone_change.noise_spl_db: [1]}}", "one of .*, did you mean 'noise.level_spl_db'"),
        ("sweep={over: {settings.votes_needed: [1]}}", "one of .*, did you mean 'detector.votes_needed'"),
        ("sweep={over: {walk.speed: [1]}}", "among .*'walk.speed_m_s'.*, did you mean 'walk.speed_m_s'"),
        ("sweep={over: {air.temperatur_c: [1]}}", "got 'air.temperatur_c', did you mean 'air.temperature_c'"),
        ("noise.level_spl_db=3", "setting 'noise.level_spl_db' must .*, did you mean 'phone_change.noise_spl_db'"),
        ("detector.votes_needed=3", "did you mean 'settings.votes_needed'"),
        ("settings.votes_neded=3", "settings must be among .*, got 'votes_neded', did you mean 'votes_needed'"),
        ("settings.errata.rim_angel=true", "errata must be among .*, got 'rim_angel', did you mean 'rim_angle'"),
        ("fidelity.max_ordr=3", "fidelity must be among .*, got 'max_ordr', did you mean 'max_order'"),
        ("air.temperatur_c=3", "air must be among .*, got 'temperatur_c', did you mean 'temperature_c'"),
    ],
)
def test_the_nearest_name_is_said(setting: str, message: str) -> None:
    """Cause: sweeps and settings call one thing by two names, and who took one for the other read Python's words."""
    with pytest.raises(ValueError, match=message):
        plan_cells(load_suite("paper", [setting]), "smoke")


@pytest.mark.parametrize(
    ("over", "message"),
    [
        (
            "{beep.start_hz: {low: 3.0, high: 1.0}}",
            r"sweep.over.beep.start_hz: low must lie below high, got 3.0 and 1.0$",
        ),
        ("{beep.start_hz: {low: 3.0}}", r"sweep.over.beep.start_hz.high: is missing$"),
        ("{beep.start_hz: {low: 1, high: 2, cout: 3}}", r"start_hz.cout: is not a field here; did you mean 'count'\?$"),
        ("{beep.start_hz: 5}", r"start_hz: must be a list of values or a range with low and high, got 5$"),
        ("{5: [1]}", r"sweep.over\[5\]: a key must be a text, got 5$"),
    ],
)
def test_what_is_wrong_with_a_range_is_said_plainly(over: str, message: str) -> None:
    """Cause: the names that pydantic gives to validators and keys stood in the place."""
    with pytest.raises(ValueError, match=f"^suite 'paper': .*{message}"):
        load_suite("paper", [f"sweep={{over: {over}}}"])
