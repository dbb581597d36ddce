"""A suite of someone else runs no code and reads nothing outside of its folder; and no plan explodes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.plan.trust import check_trust

SUITE = {
    "name": "theirs", "title": "Theirs", "seed": 1, "tiers": {"smoke": {"fraction": 1.0}},
    "detectors": ["PaperDetector"],
    "groups": [{"scene": "supermarket", "phones": ["ideal"], "counts": {"wall": 1}}],
}  # fmt: skip
SPY = "from pathlib import Path\nPath('ran').touch()\nfrom obstaclewatch import PaperDetector\n"


def written(folder: Path, **changes: object) -> Path:
    path = folder / "theirs.yaml"
    path.write_text(yaml.safe_dump(SUITE | changes))
    return path


@pytest.mark.parametrize(
    "changes",
    [
        {"detectors": ["spy_of_suite:PaperDetector"]},
        {"standing": {"phones": ["ideal"], "counts": {"wall": 1}, "detectors": ["spy_of_suite:PaperDetector"]}},
        {"sweep": {"over": {"detector.name": ["spy_of_suite:PaperDetector"]}}},
        {"sweep": {"method": "list", "points": [{"detector.name": "spy_of_suite:PaperDetector"}]}},
    ],
)
def test_a_suite_file_imports_nothing_unless_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, object]
) -> None:
    """Cause: planning imports every detector named, and `validate` and `run -n` plan."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "spy_of_suite", raising=False)
    Path("spy_of_suite.py").write_text(SPY)
    path = written(tmp_path, **changes)
    for command in (["validate", str(path)], ["run", str(path), "--tier", "smoke", "-n"]):
        done = CliRunner().invoke(cli, command)
        assert isinstance(done.exception, ValueError)
        assert "run code of their own, ['spy_of_suite:PaperDetector']: --allow-code" in str(done.exception)
        assert not Path("ran").exists()
    done = CliRunner().invoke(cli, ["validate", str(path), "--allow-code"], catch_exceptions=False)
    assert done.exit_code == 0
    assert Path("ran").exists()


def test_a_suite_file_names_scenes_of_its_folder_or_the_working_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, theirs = tmp_path / "here", tmp_path / "theirs"
    for folder in (here, theirs):
        folder.mkdir()
    monkeypatch.chdir(here)
    for file, fine in (
        ("yard.yaml", True),
        (str(theirs / "a.yaml"), True),
        ("../x.yaml", False),
        ("/etc/x.yaml", False),
    ):
        path = written(theirs, scenes=[{"file": file, "count": 1}])
        if fine:
            check_trust(load_suite(str(path)), str(path), allow_code=False)
            continue
        with pytest.raises(ValueError, match="must name scene files below"):
            check_trust(load_suite(str(path)), str(path), allow_code=False)


@pytest.mark.parametrize(
    "settings",
    [
        ["groups=[{scene: supermarket, phones: [ideal], counts: {wall: 1000000000}}]"],
        ["sweep={over: {beep.start_hz: {low: 1.0, high: 2.0, count: 1000000000}}}"],
        ["sweep={method: random, over: {beep.start_hz: {low: 1.0, high: 2.0}}, samples: 1000000000}"],
        ["sweep={over: {" + ", ".join(f"walk.a{k}: [1, 2, 3, 4]" for k in range(40)) + "}}"],
        ["probes=[{kind: signal, name: x, over: {" + ", ".join(f"a{k}: [1, 2, 3, 4]" for k in range(40)) + "}}]"],
        ["scenes=[{file: x.yaml, count: 1000000000}]"],
    ],
)
def test_a_plan_too_large_is_counted_and_not_made(settings: list[str]) -> None:
    """Cause: `counts: {wall: 1000000000}` was planned cell by cell until memory ended."""
    with pytest.raises(ValueError, match="must have at most 200000 cells, got"):
        plan_cells(load_suite("paper", [*settings, "tiers={smoke: {fraction: 1.0}}"]), "smoke")


def test_every_suite_of_the_project_counts_as_many_cells_as_it_plans() -> None:
    suite = load_suite("bearing")
    assert suite.sweep is None or suite.sweep.size == len(suite.sweep.visited())
    for method in ("grid", "one-at-a-time", "latin-hypercube"):
        over = "{walk.pitch_rad: {low: 0.1, high: 0.5, count: 3}, air.temperature_c: {low: 1.0, high: 9.0, count: 4}}"
        sweep = load_suite("paper", [f"sweep={{method: {method}, over: {over}}}"]).sweep
        assert sweep is not None
        assert sweep.size == len(sweep.visited())
