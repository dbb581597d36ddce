"""Every shipped suite from plan to report, and its figures drawn again from what is stored."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.figures import FIGURES
from benchmarks.plan.suite import list_suites, load_suite

QUICK = "extremes"
"""Run by default; all others are left to the slow tests."""


def run_and_draw(suite: str, limit: int, folder) -> None:
    call = ["run", suite, "--tier", "smoke", "--limit", str(limit), "--walks", "0", "-o", str(folder)]
    done = CliRunner().invoke(cli, call, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    run = folder / suite / "latest"
    manifest = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["figures"] == list(load_suite(suite).figures)
    drawn = {path.name: path.read_bytes() for path in (run / "figures").iterdir()}
    assert drawn
    named = set(load_suite(suite).figures) or set(FIGURES)
    assert {name.split(".")[0] for name in drawn} <= named
    again = CliRunner().invoke(cli, ["figures", str(run)], catch_exceptions=False)
    assert again.exit_code == 0
    assert {path.name: path.read_bytes() for path in (run / "figures").iterdir()} == drawn
    assert "svg+xml" in (run / "report.html").read_text(encoding="utf-8")


def test_a_quick_suite_runs_to_its_report_and_claims(tmp_path):
    run_and_draw(QUICK, 3, tmp_path)
    run = tmp_path / QUICK / "latest"
    call = ["figures", str(run), "extremes", "--claims", "TrackingDetector", "--with", str(run)]
    done = CliRunner().invoke(cli, call, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    text = (run / "claims.md").read_text(encoding="utf-8")
    assert "| TrackingDetector |" in text
    assert "0 reached" in text


@pytest.mark.slow
@pytest.mark.parametrize("suite", sorted(set(list_suites()) - {QUICK}))
def test_every_other_suite_runs_to_its_report(suite, tmp_path):
    run_and_draw(suite, 12, tmp_path)
