"""Detectors by name: with constants in brackets, and from a user's own module."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cells.compute import compute, situation_of
from benchmarks.cells.detectors import (
    build_detector,
    check_detector,
    detector_class,
    detector_label,
    parse_detector,
    source_digest,
)
from benchmarks.cells.equipment import detector_for
from benchmarks.cells.situations.standing import standing_situation
from benchmarks.cells.situations.variation import varied
from benchmarks.cells.spec import Cell, Knowledge
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from obstaclewatch import BeepDesign, PaperDetector, PaperSettings
from obstaclewatch.walker.walking_speed import ANYONE
from scenes import Gait
from simulator import Phone

PHONE = Phone.named("galaxy-s5").geometry


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A user's folder with a detector in it, as the working directory."""
    folder = tmp_path / "mine_for_a_test"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "detectors.py").write_text(
        "from obstaclewatch import PaperStandingDetector\n"
        "class Mine(PaperStandingDetector):\n    pass\nclass Odd:\n    pass\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    yield folder / "detectors.py"
    for name in [name for name in sys.modules if name.startswith("mine_for_a_test")]:
        del sys.modules[name]


def test_constants_in_brackets_reach_settings_errata_and_class():
    detector = build_detector(
        "PaperDetector(votes_needed=1, one_way_range=False, closing_speed_m_s=[0.2, 3.0], sound_speed_m_s=340.0)",
        BeepDesign(), PHONE, PaperSettings(), None,
    )  # fmt: skip
    assert isinstance(detector, PaperDetector)
    assert (detector.settings.votes_needed, detector.settings.errata.one_way_range) == (1, False)
    assert detector.settings.closing_speed_m_s == (0.2, 3.0)
    assert PaperSettings().votes_needed == 5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Paper Detector", "must read Class"),
        ("PaperDetector(3)", "constants must be named"),
        ("PaperDetector(votes_needed=)", "must hold constant=value"),
        ("PaperDetector(votes_needed=open('x'))", "must hold constant=value"),
        ("PaperDetector(no_such=1)", "cannot be made.*no_such"),
        ("PaperDetector(votes_needed=99)", "votes_needed must be"),
        ("PaperDetector(reading='aloud')", r"reading must be one of \['as_printed', 'calibrated'\], got 'aloud'"),
    ],
)
def test_wrong_names_are_one_clear_error(text, message):
    with pytest.raises(ValueError, match=message):
        build_detector(text, BeepDesign(), PHONE, PaperSettings(), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("PaperDetector(votes_needed=3)(danger_m=2.0)", "constants must be named, in one pair of brackets"),
        ("PaperDetector(votes_needed=3, votes_needed=4)", "each constant must have a name of its own"),
        ("PaperDetector(**{'votes_needed': 3})", "each constant must have a name of its own"),
        ("PaperDetector(votes_needed={[]: 1})", "must hold constant=value"),
        ("PaperDetector(reading=[])", r"reading must be one of .*, got \[\]"),
    ],
)
def test_no_constant_in_brackets_is_lost(text, message):
    """Cause: the last brackets and the last value of a name counted alone, and a list as a key ended in TypeError."""
    with pytest.raises(ValueError, match=message):
        check_detector(text, PaperSettings())


def test_a_reading_is_a_group_of_settings_on_which_others_come():
    built = build_detector("PaperDetector(reading='calibrated', threshold_factor=3.0)", BeepDesign(), PHONE,
                           PaperSettings(near_m=0.4), None)  # fmt: skip
    assert built.settings == replace(PaperSettings.calibrated(near_m=0.4), threshold_factor=3.0)


def test_a_module_is_left_out_of_the_label():
    assert detector_label("a.b:Mine(x=1)") == "Mine(x=1)"
    assert detector_label("PaperDetector") == "PaperDetector"


def test_a_user_s_class_is_found_in_the_working_directory(module):
    assert detector_class(parse_detector("mine_for_a_test.detectors:Mine")).__name__ == "Mine"
    with pytest.raises(ValueError, match="must have a method stream"):
        detector_class(parse_detector("mine_for_a_test.detectors:Odd"))
    with pytest.raises(ValueError, match="has no class 'None_'"):
        detector_class(parse_detector("mine_for_a_test.detectors:None_"))


def test_a_name_that_is_nearly_right_is_suggested():
    with pytest.raises(ValueError, match="has no class 'TrackngDetector', did you mean 'TrackingDetector'"):
        detector_class(parse_detector("TrackngDetector"))


def test_its_source_names_the_cells(module):
    suite = load_suite("paper", ["detectors=[PaperDetector, 'mine_for_a_test.detectors:Mine']"])
    first = plan_cells(suite, "smoke")[0]
    assert set(first.detector_sources) == {"mine_for_a_test.detectors:Mine"}
    module.write_text(module.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    assert plan_cells(suite, "smoke")[0].digest("v") != first.digest("v")
    assert source_digest(parse_detector("PaperDetector")) == source_digest(parse_detector("DistanceOnlyDetector"))


def test_two_detectors_of_one_label_are_refused():
    with pytest.raises(ValueError, match="different names"):
        load_suite("paper", ["detectors=['a.b:PaperDetector', PaperDetector]"])


def test_it_is_scored_beside_ours(module):
    cell = Cell(
        kind="standing", scene="standing", category="wall", index=0, phone="galaxy-s5", seed=1, collision=False,
        range_m=1.5,
        detectors=("PaperDetector", "mine_for_a_test.detectors:Mine", "PaperDetector(max_candidates=1)"),
    )  # fmt: skip
    found = compute(cell)["detectors"]
    assert set(found) == {"PaperDetector", "Mine", "PaperDetector(max_candidates=1)"}
    heard = [value for value in found["PaperDetector"]["beeps"][0]["range_m"] if value == value]
    assert heard
    np.testing.assert_equal(found["Mine"]["beeps"], found["PaperDetector"]["beeps"])  # NaN, "not known", equals itself
    assert max(found["PaperDetector(max_candidates=1)"]["beeps"][0]["candidates"]) == 1


def test_the_working_directory_is_not_left_on_the_path(module):
    detector_class(parse_detector("mine_for_a_test.detectors:Mine"))
    assert str(Path.cwd()) not in sys.path


@pytest.mark.parametrize(
    ("told", "assumed"), [({}, 351.5), ({"temperature_error_c": -12.0}, 343.9), ({"air": False}, 343.0)]
)
def test_the_weather_tells_the_speed_of_sound(told, assumed):
    cell = Cell(
        kind="standing", scene="standing", category="wall", index=0, phone="ideal", seed=3, collision=False,
        range_m=3.0, detectors=("PaperDetector",), air={"temperature_c": 32.0}, knowledge=Knowledge(**told),
    )  # fmt: skip
    setting = varied(standing_situation(cell), cell)
    found = detector_for(cell, "PaperDetector", setting, BeepDesign())
    assert found._pipeline.sound_speed_m_s == pytest.approx(assumed, abs=0.3)


def test_a_walker_s_own_walk_ratio_is_one_of_another_day():
    """The detector has it on demand: off by 3 %, the same in every run, and nothing where nobody walks in steps."""
    planned = plan_cells(load_suite("paper", ["knowledge.walk_ratio=true"]), "full")
    off = []
    for cell in [cell for cell in planned if cell.kind == "approach"][:200:10]:
        setting = situation_of(cell)
        built = [detector_for(cell, "TrackingDetector", setting, BeepDesign()) for _ in range(2)]
        assert built[0]._walk_ratio == built[1]._walk_ratio
        off.append(built[0]._walk_ratio.m_min / setting.walk.walk_ratio_m_min - 1.0)
        still = replace(setting, walk=replace(setting.walk, gait=Gait()))
        assert detector_for(cell, "TrackingDetector", still, BeepDesign())._walk_ratio == ANYONE
        assert isinstance(detector_for(cell, "PaperDetector", setting, BeepDesign()), PaperDetector)
    assert 0.015 < np.sqrt(np.mean(np.square(off))) < 0.045
    unknown = cell.model_copy(update={"knowledge": Knowledge()})
    assert detector_for(unknown, "TrackingDetector", setting, BeepDesign())._walk_ratio == ANYONE


def test_a_class_that_takes_no_speed_of_sound_is_not_told(module):
    module.write_text(
        "class Own:\n"
        "    def __init__(self, beep, phone, settings, pitch_rad):\n"
        "        self.pitch_rad = pitch_rad\n"
        "    def stream(self, recording):\n"
        "        return iter(())\n",
        encoding="utf-8",
    )
    own = build_detector(
        "mine_for_a_test.detectors:Own", BeepDesign(), PHONE, PaperSettings(), 0.5, {"sound_speed_m_s": 351.0}
    )
    assert own.pitch_rad == 0.5


def test_a_detector_with_settings_of_its_own_gets_those_alone():
    """A suite's settings are for all its detectors; what stands in a detector's brackets is meant for it."""
    check_detector("TrackingDetector(danger_m=2.0)", PaperSettings(cfar_factor=4.24))
    with pytest.raises(ValueError, match="has no use for votes_needed, only for near_m, far_m"):
        check_detector("TrackingDetector(votes_needed=3)", PaperSettings())
