"""Files of gates: the shipped ones are valid, and what cannot be is refused with the field that is meant."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.gates.config import LEAST_SHARE, gates_path, list_gates, load_gates
from benchmarks.gates.physics import CHECKS, GREATEST
from benchmarks.scoring.statistics import lower_bound

MEDIAN = "title: x\nclaims: [{detector: D"


@pytest.mark.parametrize("name", list_gates())
def test_shipped_gates_are_valid(name):
    assert load_gates(gates_path(name)).title


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("title: x\n", "must hold claims, regression or physics"),
        ("title: x\nphysics: {gravity: 1}\n", "physics checks must be among .*gravity"),
        ("title: x\nclaims: [{rate: TP, at_least: 0.9}]\n", "must name its detector"),
        ("title: x\nclaims: [{detector: D, rate: TP, at_least: 94.6}]\n", "at_least"),
        ("title: x\nregression: [{detector: D, approach: {speed: 1}}]\n", "a quantity must be one of .*'speed'"),
        ("title: [x\n", "must be YAML"),
        (
            f"{MEDIAN}, quantity: range_eror, at_most: 1}}]",
            r"claims\[0\].quantity: a quantity must be one of .*range_eror",
        ),
        (f"{MEDIAN}, quantity: snr, at_most: -1}}]", r"claims\[0\].at_most: must be greater than 0, got -1"),
        (
            f"{MEDIAN}, quantity: snr, at_most: 1, clear_cut: yes}}]",
            r"clear_cut: is not a field here; there are \['at_mo",
        ),
        (f"{MEDIAN}, at_most: 1}}]", r"claims\[0\].quantity: is missing$"),
        (f"{MEDIAN}}}]", r"claims\[0\]: must be a mapping with a rate or a quantity, got"),
        ("title: x\nclaims: [5]", r"claims\[0\]: must be a mapping with a rate or a quantity, got 5"),
        (
            f"{MEDIAN}, quantity: snr, at_most: 1, standing_range_m: 3}}]",
            "standing_range_m must be of kind 'standing', got 3",
        ),
        (
            "title: x\nclaimed: mine:Detector\nclaims: [{rate: TP, at_least: 0.9}]",
            "claimed: must be without its module, as results call it: 'Detector', got 'mine:Detector'",
        ),
        (
            "title: x\nregression: [{detector: PaperDetector(votes=3)}]",
            r"regression\[0\].detector: detector 'PaperDetector\(votes=3\)' cannot be made",
        ),
        (f"{MEDIAN}, rate: TX, at_least: 0.9}}]", r"claims\[0\].rate: must be 'TP' or 'TN', got 'TX'"),
        (f"{MEDIAN}, rate: TN, at_least: 0.9, left_m: 0.5}}]", r"must not be given for TN, .* got \{'left_m': 0.5\}"),
        (f"{MEDIAN}, rate: TN, at_least: 0.9, at_tnr: 0.9}}]", r"must not be given for TN, .* got \{'at_tnr': 0.9\}"),
        (
            f"{MEDIAN}, rate: TP, at_least: 0.9, least_index_db: .nan}}]",
            "least_index_db: must be a finite number, got nan",
        ),
        (
            "title: x\nregression: [{detector: D, rates: []}]",
            "a regression must watch rates or quantities, got none for D",
        ),
    ],
)
def test_gates_files_that_cannot_be_are_refused(tmp_path, text, says):
    (tmp_path / "gates.yaml").write_text(text)
    with pytest.raises(ValueError, match=says):
        load_gates(tmp_path / "gates.yaml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "title: x\nclaims: [{detector: D, rate: TN, at_least: 0.5, confidence: 0.0001}]",
            r"confidence: .*0\.5.*0\.0001",
        ),
        (
            "title: x\nclaims: [{detector: D, rate: TN, at_least: 1.0e-9}]",
            r"claims\[0\].at_least: must be .*0\.01, got 1e-09$",
        ),
        (
            "title: x\nclaims: [{detector: D, rate: TP, at_least: 0.9, at_tnr: 1.0e-9}]",
            r"claims\[0\].at_tnr: must be .*0\.01, got 1e-09$",
        ),
        ("title: x\nregression: [{detector: D, approach: {alerts: 1.0}}]", "alerts must be below 1, .* got 1$"),
        ("title: x\nregression: [{detector: D, standing: {snr: 1000000}}]", r"snr must be below 60, .* got 1e\+06$"),
        ("title: x\nphysics: {wall_level: 1000000}", r"physics: wall_level must be below 60, .* got 1e\+06$"),
        (f"{MEDIAN}, quantity: no_estimate, at_most: 1}}]", r"claims\[0\]: no_estimate must be below 1, .* got 1$"),
        ("title: x\nloss_points: 100\nphysics: {truth: 1}", "loss_points: .* got 100$"),
    ],
)
def test_a_gate_that_cannot_fail_is_refused(tmp_path, text, says):
    """Tolerances were any positive number, confidence any share: 2 of 2 walks passed with 0.01 % confidence. Claimed
    rates were any share: one right walk of 1299 passed, and TP with a threshold at which all others alert."""
    (tmp_path / "gates.yaml").write_text(text)
    with pytest.raises(ValueError, match=says):
        load_gates(tmp_path / "gates.yaml")


def test_a_single_right_walk_of_five_shows_the_least_that_is_claimed():
    assert lower_bound(1, 5) > LEAST_SHARE > lower_bound(1, 6)


def test_every_physics_check_has_a_greatest_value():
    assert CHECKS.keys() == GREATEST.keys()


def test_names_that_only_a_run_of_ones_own_can_have_are_said(tmp_path):
    """Cause: a misspelt detector or scene passed, and its gate measured nothing."""
    path = tmp_path / "gates.yaml"
    path.write_text(
        "title: x\nclaimed: PaperDetector(votes_needed=3)\nregression: [{detector: TrackingDetecter}]\nclaims:\n"
        "  - {rate: TP, at_least: 0.9, scene: supermarkt}\n"
        "  - {quantity: range_error, at_most: 0.9, kind: standing, scene: standing, category: wall}\n"
        "  - {rate: TN, at_least: 0.9, scene: campus, category: statue, phone: galaxy-s5}\n"
    )
    done = CliRunner().invoke(cli, ["validate", str(path)])
    end = "; if no run has it, the gate measures nothing"
    assert (done.exit_code, done.output.splitlines()) == (0, [
        "x: 3 claims, 2 regression gates, 0 physics gates",
        f"detector 'TrackingDetecter' is none of this project, did you mean 'TrackingDetector'?{end}",
        f"scene 'supermarkt' is none of this project, did you mean 'supermarket'?{end}",
        f"category 'statue' is none of this project{end}",
    ])  # fmt: skip
