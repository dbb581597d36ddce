"""Every command and every block of code of the tutorials runs, and yields what the text says."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import pytest
import yaml

from .tutorial import run_tutorial

pytestmark = pytest.mark.usefixtures("suites_once")
DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_tutorial_on_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    done = run_tutorial(DOCS / "tutorial_scene.md")
    assert len([line for line in done if line.startswith("obstaclewatch")]) == 7
    assert done.count("python") == 2
    assert "collision: True" in capsys.readouterr().out
    assert "addFrames" in Path("yard.html").read_text()
    assert matplotlib.image.imread("yard.png").std() > 0.05
    assert matplotlib.image.imread("echogram.png").std() > 0.05
    assert any("statue" in path["obstacle"] for path in json.loads(Path("paths.json").read_text())["paths"])
    run = Path("results/mine/latest").resolve()
    assert (run / "report.html").stat().st_size > 20_000
    rows = (run / "results.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * 4
    assert sum("my phone" in row for row in rows) == 4
    assert {path.name for path in (run / "figures").glob("*.png")} >= {"fig16.png", "fig24.png"}


def test_the_tutorial_on_reports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    done = run_tutorial(DOCS / "tutorial_report.md")
    assert len([line for line in done if line.startswith("obstaclewatch")]) == 2
    assert done.count("python") == 2
    said = capsys.readouterr().out
    assert "TrackingDetector TP" in said
    assert "TrackingDetector: " in said
    first, alone = (Path(folder) / "paper" / "latest" for folder in ("results", "one"))
    page = (first / "report.html").read_text(encoding="utf-8")
    assert "TrackingDetector: TP" in page
    assert len(list((first / "replays").glob("*.json"))) == 2
    assert '<section id="walks">' in page
    assert '<section id="walks">' not in (alone / "report.html").read_text(encoding="utf-8")


def test_the_tutorial_on_gates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command ends with the exit code and the lines that the text says."""
    monkeypatch.chdir(tmp_path)
    done = run_tutorial(DOCS / "tutorial_gate.md")
    assert len([line for line in done if line.startswith("obstaclewatch")]) == 10
    bad = Path("bad/paper/latest")
    assert json.loads((bad / "gate.json").read_text())["exit_code"] == 1
    assert "candidates" in (bad / "gate.md").read_text()
    assert [entry["reason"] for entry in json.loads(Path("baseline.json").read_text())["history"]] == ["first run"]


def test_the_workflow_is_yaml_that_gates() -> None:
    data = yaml.safe_load((DOCS / "ci_example.yml").read_text(encoding="utf-8"))
    commands = "\n".join(step.get("run", "") for step in data["jobs"]["gates"]["steps"])
    assert [word for word in ("doctor", "run", "gate") if f"obstaclewatch {word} " in commands + " "]
    assert "obstaclewatch gate results/mine/latest --gates gates.yaml" in commands


ALONE = """
import sys
sys.path.insert(0, "walks")
from load import walks
found = [len(sound) for split in ("train", "validation", "test") for _, sound, *_ in walks("walks", split)]
ours = {"obstaclewatch", "simulator", "scenes", "benchmarks"} & set(sys.modules)
assert len(found) == 5 and not ours, (found, ours)
"""


def test_the_page_on_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    """And the data set's loader, printed in its card, needs nothing of ours."""
    monkeypatch.chdir(tmp_path)
    assert run_tutorial(DOCS / "data.md").count("python") == 3
    said = capsys.readouterr().out
    assert "range_error_median_m" in said
    assert "standing/wall/1.5m/0 (" in said
    card = Path("walks/README.md").read_text(encoding="utf-8")
    assert Path("walks/load.py").read_text(encoding="utf-8") in card
    assert "MIT" in Path("walks/LICENSE").read_text(encoding="utf-8")
    subprocess.run([sys.executable, "-I", "-c", ALONE], check=True)


def test_the_page_on_own_phones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = run_tutorial(DOCS / "own_phone.md")
    assert len([line for line in done if line.startswith("obstaclewatch")]) == 5
    assert matplotlib.image.imread("walk.png").std() > 0.05
