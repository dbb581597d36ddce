"""Learning the decision: from walks to a file, the same again, and what its card claims of walks it has not seen."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.training.__main__ import SEEDS, as_plain, main, read_table
from benchmarks.training.examples import Examples
from benchmarks.training.fit import alerts_by, calibration, distances_left, fitted, rates
from benchmarks.training.walks import development_cells, with_people_drawn
from obstaclewatch.tracking.collision_model import FILE, CollisionModel, collision_model
from obstaclewatch.tracking.evidence import Evidence

TABLE = Path(__file__).with_name("held_out.npz")
"""Evidence of the card's held-out walks of recipe `paper`, at the levels assumed; see `--table`."""


def _examples(walks=60, beeps=10, seed=0):
    """Walks whose evidence says a little about the outcome: log odds of the number `hit` are 0.4 a unit."""
    rng = np.random.default_rng(seed)
    walk, collides = np.repeat(np.arange(walks), beeps), np.repeat(np.arange(walks) % 2 == 0, beeps)
    evidence = rng.normal(size=(walks * beeps, len(Evidence._fields)))
    evidence[:, Evidence._fields.index("hit")] = rng.normal(np.where(collides, 2.0, -2.0), np.sqrt(10.0))
    evidence[rng.random(len(walk)) < 0.3, :4] = np.nan
    left_m = np.where(collides, np.tile(np.linspace(1.5, 0.0, beeps), walks), np.nan)
    return Examples(walk, np.zeros_like(walk), collides, left_m, evidence)


def _worst(found, probability):
    """Greatest deviation of observed from stated shares, in deviations of so many walks."""
    return max(
        abs(row["observed"] - row["stated"]) / np.sqrt(0.25 / row["walks"]) for row in calibration(found, probability)
    )


def test_walks_are_of_the_development_split_and_never_shared():
    learned = {r: development_cells(r, seed, 40) for r, seed in SEEDS["learned"].items()}
    unseen = development_cells("paper", SEEDS["held out"]["paper"], 40)
    seeds = [cell.seed for cells in (*learned.values(), unseen) for cell in cells]
    assert len(set(seeds)) == len(seeds) == 120
    assert not set(seeds) & {cell.seed for cell in plan_cells(load_suite("paper"), "full")}
    assert len({cell.seed for cell in development_cells("paper", 2018, 1400)}) == 1400  # a second seed's follow
    changed = [cell.scene_change.person_level_db != 0.0 for cell in with_people_drawn(learned["paper"])]
    assert changed == [k % 2 == 1 for k in range(40)]


def test_a_known_law_is_learned_and_calibrated():
    model, unseen = fitted(_examples(400)), _examples(400, seed=1)
    which = Evidence._fields.index("hit")
    slope = np.diff(model.values[which]) / np.diff(model.knots[which])
    assert slope[1:-1] == pytest.approx(np.full(len(slope) - 2, 0.4), abs=0.15)
    assert _worst(unseen, model.probabilities(unseen.evidence)) < 3.0
    one = unseen.evidence[3]
    assert model.probability(Evidence(*one)) == pytest.approx(model.probabilities(unseen.evidence)[3])


def _learned_again(folder, output):
    """Three walks to learn from and one held out."""
    asked = ["--walks=3", "--held-out=1", "--receptions=2", f"--examples={folder}", "-o", str(output)]
    done = CliRunner().invoke(main, asked, catch_exceptions=False)
    assert done.exit_code == 0
    return output.read_text()


def test_from_walks_to_a_file(tmp_path):
    """The second time from the walks' files."""
    first, second = (_learned_again(tmp_path / "kept", tmp_path / name) for name in ("one", "two"))
    assert first == second
    assert as_plain(CollisionModel.from_file(tmp_path / "one"))["curves"] == json.loads(first)["curves"]


@pytest.mark.slow
def test_from_scratch_the_same_again(tmp_path):
    assert _learned_again(tmp_path / "one", tmp_path / "1") == _learned_again(tmp_path / "two", tmp_path / "2")


def test_a_file_with_other_numbers_is_refused(tmp_path):
    stored = json.loads(FILE.read_text())
    stored["curves"]["another"] = stored["curves"].pop("hit")
    (tmp_path / "model.json").write_text(json.dumps(stored))
    with pytest.raises(ValueError, match="must have curves of"):
        CollisionModel.from_file(tmp_path / "model.json")


def test_the_card_is_that_of_the_weights():
    found, card = read_table(TABLE), json.loads(FILE.read_text())["card"]["held out"]["paper"]
    model = collision_model()
    alerts = alerts_by(model, model.probabilities(found.evidence), distances_left(found))
    claimed = card["assumed levels"]
    for left_m in (0.0, 0.5, 1.0):
        assert rates(found, alerts, left_m)[0] == pytest.approx(claimed[f"TP, {left_m:g} m left"], abs=0.006)
    assert rates(found, alerts, 0.0)[1] == pytest.approx(claimed["TN"], abs=0.006)
    assert len(np.unique(found.walk)) == card["walks"]


def test_stated_probabilities_are_observed_and_a_shift_is_seen():
    found, model = read_table(TABLE), collision_model()
    assert _worst(found, model.probabilities(found.evidence)) < 4.0
    for shift in (-1.5, 1.5):
        assert _worst(found, replace(model, constant=model.constant + shift).probabilities(found.evidence)) > 4.0
