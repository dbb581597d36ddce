"""Every command of the gate's tutorial runs and ends with the exit code and the lines that the text says."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from tests.tutorial import run_tutorial

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_the_tutorial_on_gates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
