"""Broken detectors through the whole bench: simulated, detected, stored, gated."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from benchmarks.cli import cli

UNTOUCHED = "PaperDetector"
SABOTAGED = {
    "threshold 3 dB up": ("PaperDetector(cfar_factor=4.2376)", "candidates"),
    "threshold 3 dB down": ("PaperDetector(cfar_factor=2.1238)", "candidates"),
    "one vote of nine": ("PaperDetector(votes_needed=1)", "alerts"),
    "one channel late": ("tests.benchmarks.sabotaged:LateChannelDetector", "path_difference_bias"),
}
QUANTITIES = {
    "range_error": 0.005,
    "path_difference_bias": 0.0005,
    "no_estimate": 0.02,
    "candidates": 0.1,
    "snr": 0.3,
    "alerts": 0.01,
}


def call(*arguments: str):
    return CliRunner().invoke(cli, list(arguments), catch_exceptions=False)


def label(detector: str) -> str:
    return detector.rpartition(":")[2]


def gates_for(detector: str, folder: Path) -> str:
    path = folder / f"{abs(hash(detector))}.yaml"
    # of 18 collisions too few are judged rightly for a fall of TP to be certain
    asked = {"detector": label(detector), "against": UNTOUCHED, "rates": ["TN"], "approach": QUANTITIES}
    path.write_text(yaml.safe_dump({"title": detector, "baseline": "baseline.json", "regression": [asked]}))
    return str(path)


@pytest.fixture(scope="module", params=[2018, 1, 2])
def run(request, tmp_path_factory):
    """Four walks of each kind with the untouched detector, stored as baseline, and another run with all of them."""
    folder = tmp_path_factory.mktemp(f"seed{request.param}")
    common = [
        "run",
        "paper",
        "--tier",
        "smoke",
        "-j",
        "2",
        "--seed",
        str(request.param),
        "-k",
        "not standing",
        "--walks",
        "0",
        "--set",
        "tiers={smoke: {fraction: 0.01, at_least: 4}}",
    ]
    first = call(*common, "--set", f"detectors=[{UNTOUCHED}]", "-o", str(folder / "first"))
    assert first.exit_code == 0, first.output
    update = ["baseline", "update", str(folder / "first/paper/latest"), "--reason", "untouched"]
    assert call(*update, "--baseline", str(folder / "baseline.json")).exit_code == 0
    names = [UNTOUCHED, *(detector for detector, _ in SABOTAGED.values())]
    second = call(*common, "--set", f"detectors={yaml.safe_dump(names, default_flow_style=True).strip()}",
                  "-o", str(folder / "second"))  # fmt: skip
    assert second.exit_code == 0, second.output
    return folder


@pytest.mark.slow
def test_untouched_is_green(run):
    done = call("gate", str(run / "second/paper/latest"), "--gates", gates_for(UNTOUCHED, run))
    assert done.exit_code == 0, done.output
    assert "7 gates green, 0 red" in done.output


@pytest.mark.slow
@pytest.mark.parametrize("mistake", SABOTAGED)
def test_sabotage_is_red_and_named(run, mistake):
    detector, metric = SABOTAGED[mistake]
    done = call("gate", str(run / "second/paper/latest"), "--gates", gates_for(detector, run))
    assert done.exit_code == 1, done.output
    assert [line for line in done.output.splitlines() if line.startswith("RED") and metric in line], done.output
