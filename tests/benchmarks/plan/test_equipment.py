"""Values that a detector refuses are refused while the run is planned: nothing is rendered or written."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite

OWN = """
BUILT = []


class Counts:
    def __init__(self, beep, phone, settings, pitch_rad, sound_speed_m_s=343.0):
        BUILT.append((phone.name, settings.danger_m, pitch_rad, sound_speed_m_s))

    def stream(self, recording):
        return iter(())


class Breaks(Counts):
    def __init__(self, beep, phone, settings, pitch_rad):
        raise RuntimeError("no such network")
"""

OUT_OF_RANGE = [
    (
        "settings.far_m=1e9",
        "'PaperDetector' cannot be made: far_m must be received within one beep period, got 1000000",
    ),
    ("settings.direct_delay_s=0.5", "direct sound must reach microphone 0 within 1.2 ms .* got direct_delay_s = 0.5"),
    ("detectors=[TrackingDetector(false_alert_cost=-1)]", "false_alert_cost must be positive and finite, got -1"),
    ("knowledge.temperature_error_c=1000", "temperature_error_c of 1000 .* must lie within -80..70, got 1020"),
    ("knowledge.pitch_error_rad=1.5", "knowledge.pitch_error_rad: must be less than or equal to 0.78.*, got 1.5"),
    ("walk.pitch_rad=1.6", "pitch_rad must lie within -pi/2..pi/2, got 1.6"),
    ("standing.detectors=[StandingDetector(averaged_beeps=0)]", "averaged_beeps must be .*, got 0"),
]


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "equipment_for_a_test.py").write_text(OWN)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "equipment_for_a_test", raising=False)
    return "equipment_for_a_test"


@pytest.mark.parametrize(("setting", "rule"), OUT_OF_RANGE)
def test_a_value_out_of_range_ends_the_plan(setting: str, rule: str) -> None:
    """Cause: cells failed one by one, each after its walk was rendered."""
    with pytest.raises(ValueError, match=rule):
        plan_cells(load_suite("paper", [setting]), "smoke")


def test_the_command_writes_nothing(tmp_path: Path) -> None:
    asked = ["run", "paper", "--tier", "smoke", "--set", "settings.far_m=1e9", "--out", str(tmp_path / "results")]
    result = CliRunner().invoke(cli, asked)
    assert "far_m must be received within one beep period" in str(result.exception)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("further", "points"),
    [("sweep={over: {detector.danger_m: [2.0, 3.0], knowledge.air: [true, false]}}", 4), ("unknowns=drawn", 1)],
)
def test_a_detector_is_built_once_for_each_phone_settings_and_knowledge(own: str, further: str, points: int) -> None:
    cells = plan_cells(load_suite("paper", [f"detectors=['{own}:Counts']", further]), "smoke")
    built = importlib.import_module(own).BUILT
    kinds = {(cell.kind, cell.phone) for cell in cells}
    assert len(built) == points * len(kinds) < len(cells)
    assert {phone for phone, *_ in built} == {phone for _, phone in kinds}


def test_what_a_class_of_one_s_own_raises_is_said(own: str) -> None:
    with pytest.raises(
        ValueError, match=r"cell 'supermarket/\w+/0': detector .*:Breaks' cannot be made: Runtime.* netw"
    ):
        plan_cells(load_suite("paper", [f"detectors=['{own}:Breaks']"]), "smoke")


def test_the_air_of_a_scene_file_counts(tmp_path: Path) -> None:
    scene = tmp_path / "yard.yaml"
    scene.write_text(
        "name: yard\nair: {temperature_c: 60}\nobstacles: [{kind: bollard, name: post, at_m: [4, 0]}]\n"
        "walk: {waypoints_m: [[0, 0], [6, 0]]}\n"
    )
    alone = ["groups=[]", "standing=null", f"scenes=[{{file: {scene}, count: 1}}]"]
    assert plan_cells(load_suite("paper", alone), "smoke")
    with pytest.raises(ValueError, match="air at 60 C give"):
        plan_cells(load_suite("paper", [*alone, "knowledge.temperature_error_c=15"]), "smoke")


def test_the_pitch_of_a_scene_file_counts(tmp_path: Path) -> None:
    """Cause: a phone of 60 degrees was taken for level, so that 40 more were refused in its cell alone."""
    scene = tmp_path / "yard.yaml"
    scene.write_text(
        "name: yard\nobstacles: [{kind: bollard, name: post, at_m: [4, 0]}]\n"
        "walk: {waypoints_m: [[0, 0], [6, 0]], pitch_deg: 60}\n"
    )
    asked = ["groups=[]", "standing=null", f"scenes=[{{file: {scene}, count: 1}}]", "knowledge.pitch_error_rad=0.7"]
    with pytest.raises(ValueError, match=r"pitch_rad must lie within -pi/2..pi/2, got 1\.7"):
        plan_cells(load_suite("paper", asked), "smoke")
