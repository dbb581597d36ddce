"""Every command and block of the suites' page and of the detector tutorial runs as it stands."""

from __future__ import annotations

import csv
import re
import shlex
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.plan.suite import Suite, list_suites

DOCS = Path(__file__).resolve().parents[2] / "docs"
pytestmark = pytest.mark.usefixtures("suites_once")


def blocks(page: str, language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return [text for name, text in found if name == language]


def commands(page: str) -> list[str]:
    lines = "\n".join(blocks(page, "")).splitlines()
    return [line for line in lines if line.startswith("obstaclewatch ")]


def save_named_blocks(page: str, folder: Path) -> list[str]:
    """Blocks whose first line is a comment with a file's name, written there."""
    names = []
    for block in blocks(page, "yaml") + blocks(page, "python"):
        match = re.match(r"# (\w+\.(?:py|yaml))\n", block)
        if match:
            (folder / match[1]).write_text(block, encoding="utf-8")
            names.append(match[1])
    return names


def called(line: str) -> str:
    result = CliRunner().invoke(cli, shlex.split(line)[1:], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize("line", commands("suites.md"))
def test_every_command_of_the_suites_page_plans_cells(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert save_named_blocks("suites.md", tmp_path) == ["cold_and_loud.yaml"]
    planned = re.search(r"(\d+) cells", called(line))
    assert planned
    assert int(planned[1]) > 0
    assert not (tmp_path / "results").exists()


def test_the_page_names_every_suite_and_every_field():
    page = (DOCS / "suites.md").read_text(encoding="utf-8")
    for name in list_suites():
        assert f"| `{name}` |" in page, name
    for field in Suite.model_fields:
        assert f"`{field}`" in page, field


def test_python_of_the_suites_page_runs(tmp_path):
    (block,) = blocks("suites.md", "python")
    names: dict = {}
    exec(compile(block, "suites.md", "exec"), names)
    assert callable(names["table"])


def test_the_tutorial_s_detector_runs_through_the_bench(tmp_path, monkeypatch):
    """As written, and it stands in every figure under its own name."""
    monkeypatch.chdir(tmp_path)
    assert save_named_blocks("tutorial_detector.md", tmp_path) == ["mine.py"]
    try:
        for line in commands("tutorial_detector.md"):
            assert "report:" in called(line)
    finally:
        sys.modules.pop("mine", None)
    folder = tmp_path / "results" / "paper" / "latest"
    with (folder / "figures" / "fig16.csv").open(encoding="utf-8") as stream:
        groups = {row["group"] for row in csv.DictReader(stream)}
    assert groups == {"PaperDetector", "SoonDetector", "SoonDetector(seconds=3.0)"}
    with (folder / "results.csv").open(encoding="utf-8") as stream:  # a detector of one's own had no standing cells
        standing = {row["detector"] for row in csv.DictReader(stream) if row["kind"] == "standing"}
    assert "SoonDetector" in standing
    for name in ("fig17", "fig20", "fig24", "miss_distance"):
        assert "SoonDetector" in (folder / "figures" / f"{name}.csv").read_text(encoding="utf-8"), name
    assert "SoonDetector" in (folder / "report.html").read_text(encoding="utf-8")
