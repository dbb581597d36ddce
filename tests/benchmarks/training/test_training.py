"""Learning decisions and bearings: walks to files, the same again, what cards claim of walks that were not seen."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.special import expit, logit

from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import list_suites, load_suite
from benchmarks.training.__main__ import (
    HELD_OUT,
    SEEDS,
    WALKS,
    card,
    learned_from,
    learned_walks,
    main,
    shared,
    write_table,
)
from benchmarks.training.bearings import BearingExamples, bearings_of, errors
from benchmarks.training.examples import APART, FOLDS, Examples, examples_of
from benchmarks.training.fit import alerts_by, calibration, distances_left, rates, stated, with_thresholds
from benchmarks.training.walks import FEWER, development_cells, with_fewer_echoes, with_people_drawn
from obstaclewatch.tracking.approach_picture import SHAPE
from obstaclewatch.tracking.bearing_evidence import NUMBERS, TrackNumbers
from obstaclewatch.tracking.bearing_model import WEIGHTS as BEARING_WEIGHTS
from obstaclewatch.tracking.bearing_model import BearingModel, bearing_model
from obstaclewatch.tracking.collision_model import WEIGHTS, CollisionModel, collision_model
from obstaclewatch.tracking.evidence import NO_EVIDENCE, Evidence

TABLE = Path(__file__).with_name("held_out.npz")
"""What is stated on the card's held-out walks of recipe `paper`, at the levels assumed; see `--table`."""
BEARING_TABLE = Path(__file__).with_name("bearings.npz")
"""The candidates of the same walks; see `--table`."""
LEFT = Evidence._fields.index("left_m")


def _examples(walks=40, beeps=10, seed=0, told=1.0):
    """Walks whose pictures and numbers tell the outcome by so many deviations."""
    rng = np.random.default_rng(seed)
    walk, collides = np.repeat(np.arange(walks), beeps), np.repeat(np.arange(walks) % 2 == 0, beeps)
    evidence = np.array(NO_EVIDENCE) + rng.normal(size=(walks * beeps, len(NO_EVIDENCE)))
    evidence[:, Evidence._fields.index("hit")] += np.where(collides, told, -told)
    left_m = np.where(collides, np.tile(np.linspace(1.5, 0.0, beeps), walks), np.nan)
    evidence[:, LEFT] = np.where(collides, left_m, rng.uniform(0.3, 2.0, len(walk)))
    pictures = rng.normal(size=(walks * beeps, *SHAPE))
    pictures[:, 0, :, 20] += np.where(collides, told, -told)[:, None]
    return Examples(walk, np.zeros_like(walk), collides, left_m, evidence, pictures.astype(np.float16))


def _held_out(weights):
    """What the card beside the weights says of walks of recipe `paper` that they were not learned from."""
    return json.loads(weights.with_suffix(".json").read_text())["held out"]["paper"]


def _read_table(path):
    """Beeps without pictures, what was stated at them (n,), which of them have pictures (S,), and these."""
    with np.load(path) as stored:
        told = {name: stored[name] for name in ("walk", "collides", "left_m", "evidence")}
        none = np.zeros((len(told["walk"]), 0), dtype=np.float16)
        examples = Examples(reception=np.zeros_like(told["walk"]), pictures=none, **told)
        return examples, stored["probability"], stored["shown"], stored["pictures"]


def _worst(found, probability):
    """Greatest deviation of observed from stated shares, in deviations of so many walks."""
    return max(
        abs(row["observed"] - row["stated"]) / np.sqrt(0.25 / row["walks"]) for row in calibration(found, probability)
    )


def test_walks_are_of_the_development_split_and_never_shared():
    """All that the weights are learned from, or measured with. Where recipes share a seed, its walks share a fold.

    Cause of `swept`: `beeps` and `budget` walked the very walks that the networks had learned from.
    """
    learned = {r: development_cells(r, SEEDS["learned"][r], count) for r, count in shared(WALKS).items()}
    unseen = [cell for r, seed in SEEDS["held out"].items() for cell in development_cells(r, seed, HELD_OUT)]
    seeds = {recipe: {cell.seed for cell in cells} for recipe, cells in learned.items()}
    assert {recipe: len(own) for recipe, own in seeds.items()} == shared(WALKS)
    tested = {cell.seed for recipe in seeds for cell in plan_cells(load_suite("paper", [f"recipe={recipe}"]), "full")}
    suites = [suite for suite in map(load_suite, list_suites()) if suite.split == "dev"]
    swept = {cell.seed for suite in suites for cell in plan_cells(suite, "full")}
    apart = set().union(*seeds.values()), {cell.seed for cell in unseen}, tested, swept
    assert all(not one & other for one, other in combinations(apart, 2))
    assert APART % FOLDS == 0
    assert max(apart[0]) < APART
    changed = [cell.scene_change.person_level_db != 0.0 for cell in with_people_drawn(learned["paper"])[:40]]
    assert changed == [k % 2 == 1 for k in range(40)]


def test_walks_beyond_the_first_have_fewer_echoes_and_the_card_says_so():
    fewer = [[FEWER.items() <= cell.fidelity.items() for cell in cells] for cells in learned_walks(10, 2)]
    assert fewer == [[False] + 6 * [True], [False] + 2 * [True]]
    assert learned_from(10, 2, 2)["with fewer echoes"] == {"walks": {"paper": 6, "mixed": 2}, "fidelity": FEWER}
    assert learned_from(10, 10, 2) == {"walks": {"paper": 7, "mixed": 3}, "receptions": 2}


def test_what_two_pictures_differ_by_is_learned_and_the_same_again():
    network = pytest.importorskip("benchmarks.training.network", reason="PyTorch comes with the extra `training`")
    examples, unseen = _examples(160, told=3.0), _examples(seed=1, told=3.0)
    (model, probability), (again, _) = network.learned(examples), network.learned(examples)
    found = stated(model, unseen)
    assert np.mean((found > 0.5) == unseen.collides) > 0.9
    assert np.mean((probability > 0.5) == examples.collides) > 0.8  # by networks that had not seen them
    assert (stated(again, unseen) == found).all()


def _bearings(walks, seed=0):
    """Candidates of walks whose posterior says the bearing half as large as it is, give or take 1 degree."""
    rng = np.random.default_rng(seed)
    walk, true_deg = np.repeat(np.arange(walks), 10), rng.uniform(0.0, 50.0, 10 * walks)
    evidence = rng.normal(size=(10 * walks, NUMBERS))
    evidence[:, TrackNumbers._fields.index("bearing_rad")] = np.deg2rad(0.5 * true_deg + rng.normal(size=10 * walks))
    return BearingExamples(walk, np.zeros_like(walk), evidence, np.deg2rad(true_deg))


def test_a_bearing_that_is_half_as_large_as_it_should_be_is_learned_and_the_same_again():
    network = pytest.importorskip(
        "benchmarks.training.bearing_network", reason="PyTorch comes with the extra `training`"
    )
    examples, unseen = _bearings(400), _bearings(100, seed=1)
    model, again = network.learned_bearings(examples), network.learned_bearings(examples)
    stated_errors = errors(model, unseen)
    assert stated_errors["0-90 degrees"]["median"] < 3.0  # half of it is 12 degrees off
    assert 0.6 < stated_errors["within the claim"] < 0.97  # bins are wider than the deviation
    assert (model.shares(unseen.evidence) == again.shares(unseen.evidence)).all()
    with pytest.raises(ValueError, match="there must be examples to learn from, got none"):
        network.learned_bearings(examples[np.zeros(0, dtype=np.int64)])


def test_errors_are_those_of_bearings_stated():
    examples = _bearings(50)
    bearing_rad, std_rad = bearing_model().bearings(examples.evidence)
    off = np.abs(bearing_rad - examples.true_rad)
    found = errors(bearing_model(), examples)
    few = off[(examples.true_rad >= np.deg2rad(10.0)) & (examples.true_rad < np.deg2rad(20.0))]
    assert found["10-20 degrees"]["beeps"] == len(few)
    assert found["10-20 degrees"]["80 %"] == pytest.approx(np.rad2deg(np.quantile(few, 0.8)), abs=0.051)
    assert found["within the claim"] == pytest.approx(np.mean(off < std_rad), abs=5.1e-4)


def test_walks_of_one_fold_are_refused():
    network = pytest.importorskip("benchmarks.training.network", reason="PyTorch comes with the extra `training`")
    examples = _examples()
    with pytest.raises(ValueError, match=r"walks must be in two of 4 folds or more, got \[0\]"):
        network.learned(replace(examples, walk=FOLDS * examples.walk))


@pytest.mark.filterwarnings("error")
def test_numbers_that_are_missing_do_not_count_and_those_never_there_stand_at_zero():
    descent = pytest.importorskip("benchmarks.training.descent", reason="PyTorch comes with the extra `training`")
    usual, spread = descent.usual_and_spread(np.array([[1.0, np.nan, 2.0], [3.0, np.nan, np.nan]]))
    assert usual.tolist() == [2.0, 0.0, 2.0]
    assert spread.tolist() == [1.0, descent.LEAST_SPREAD, descent.LEAST_SPREAD]


def test_thresholds_are_those_that_cost_least():
    examples = _examples()
    rng = np.random.default_rng(2)
    probability = np.clip(np.where(examples.collides, 0.8, 0.3) + 0.15 * rng.normal(size=len(examples)), 0.0, 1.0)
    model = with_thresholds(collision_model(), examples, probability)

    def cost(thresholds):
        alerts = alerts_by(replace(model, thresholds=np.array(thresholds)), probability, distances_left(examples))
        true_positive, true_negative = rates(examples, alerts, 0.5)
        return (1.0 - true_positive) + (1.0 - true_negative)

    assert cost(model.thresholds) == min(cost((low, low)) for low in np.arange(0.5, 0.99, 0.05))
    assert cost(model.thresholds) < cost((0.5, 0.5))


def test_thresholds_take_walks_of_both_outcomes():
    """Cause: of collisions alone the cost is NaN, and the first pair of thresholds was taken without a word."""
    examples = _examples()
    rows = np.flatnonzero(examples.collides)
    with pytest.raises(ValueError, match="thresholds take walks that collide and others, got 200 beeps of one kind"):
        with_thresholds(collision_model(), examples[rows], np.full(len(rows), 0.5))


def _learned_again(folder, output):
    """Four walks to learn from and one of each recipe held out."""
    asked, found = ["--walks=4", "--whole=2", "--held-out=1", "--receptions=2", f"--examples={folder}"], []
    for command in ("decision", "bearing"):
        weights = output.with_name(f"{command}-{output.name}")
        done = CliRunner().invoke(main, [command, *asked, "-o", str(weights)], catch_exceptions=False)
        assert done.exit_code == 0
        found += [weights.read_bytes(), weights.with_suffix(".json").read_bytes()]
    return found


def test_from_walks_to_a_file(tmp_path):
    """The second time from the walks' files."""
    pytest.importorskip("torch", reason="PyTorch comes with the extra `training`")
    first, second = (_learned_again(tmp_path / "kept", tmp_path / name) for name in ("one.npz", "two.npz"))
    assert first == second
    assert len(CollisionModel.from_file(tmp_path / "decision-one.npz").networks) == len(collision_model().networks)
    assert BearingModel.from_file(tmp_path / "bearing-one.npz").bearings(np.zeros((1, NUMBERS)))[0] >= 0.0


@pytest.mark.parametrize(("command", "weights"), [("decision", WEIGHTS), ("bearing", BEARING_WEIGHTS)])
def test_a_command_learns_by_default_from_as_many_walks_as_its_card_says(command, weights):
    """Cause: bearings had 10,000 walks by default, and their card 2490."""
    learned = json.loads(weights.with_suffix(".json").read_text())["data"]["walks"]
    default = {option.name: option.default for option in main.commands[command].params}
    assert shared(default["walks"]) == learned


@pytest.mark.slow
def test_from_scratch_the_same_again(tmp_path):
    pytest.importorskip("torch", reason="PyTorch comes with the extra `training`")
    assert _learned_again(tmp_path / "a", tmp_path / "1.npz") == _learned_again(tmp_path / "b", tmp_path / "2.npz")


def test_a_walk_gives_examples_and_a_card(tmp_path):
    """All of it but the learning, which needs PyTorch."""
    cells = development_cells("paper", SEEDS["learned"]["paper"], 1)
    found = examples_of([cells], 2, 1, tmp_path)
    assert found.pictures.shape == (len(found), *SHAPE)
    assert found.pictures.any(axis=(1, 2, 3)).all()
    assert set(found.reception) == {0, 1}
    twice = examples_of([cells, cells], 2, 1, tmp_path)
    assert (twice.walk == np.repeat([cells[0].seed, cells[0].seed + APART], len(found))).all()
    assert (twice.pictures == np.concatenate([found.pictures, found.pictures])).all()
    fewer = examples_of([with_fewer_echoes(cells, 0)], 1, 1, tmp_path)
    assert len(fewer) == (found.reception == 0).sum()
    assert (fewer.pictures != found.pictures[found.reception == 0]).any()  # in a file of their own
    louder = cells[0].scene_change.model_copy(update={"person_level_db": 4.0})
    others = [cells[0].model_copy(update={"scene_change": louder})]
    made = len(list(tmp_path.glob("*.npz")))
    examples_of([others], 1, 1, tmp_path)
    assert len(list(tmp_path.glob("*.npz"))) == made + 1  # files were named by seed, and an earlier walk's were taken
    candidates = bearings_of([cells], 2, 1, tmp_path)
    assert candidates.evidence.shape == (len(candidates), NUMBERS)
    assert (candidates.walk == cells[0].seed).all()
    assert set(candidates.reception) <= {0, 1}
    assert len(candidates) > 5
    assert ((candidates.true_rad >= 0.0) & (candidates.true_rad <= np.pi)).all()
    candidates.write(tmp_path / "bearings.npz")
    first = candidates[candidates.reception == 0]
    assert errors(bearing_model(), BearingExamples.from_file(tmp_path / "bearings.npz"))["walks"] == len(
        np.unique(first.walk)
    )
    model = collision_model()
    entry = card(model, learned_from(1, 1, 2), {"paper": found})
    assert entry["data"]["walks"] == {"paper": 1}
    write_table(tmp_path / "table.npz", found, model)
    table, probability, shown, pictures = _read_table(tmp_path / "table.npz")
    assert len(table) == (found.reception == 0).sum()
    assert (pictures == found.pictures[found.reception == 0][shown]).all()
    assert probability == pytest.approx(stated(model, found[found.reception == 0]), abs=1e-6)


def test_the_card_is_that_of_the_weights():
    """The table's probabilities have the card's rates, and the weights state them for the pictures that are kept."""
    model, held_out = collision_model(), _held_out(WEIGHTS)
    found, probability, shown, pictures = _read_table(TABLE)
    assert len(shown) >= 30
    again = model.probabilities(found.evidence[shown].astype(np.float64), pictures.astype(np.float32))
    assert again == pytest.approx(probability[shown], abs=1e-3)
    alerts, claimed = alerts_by(model, probability, distances_left(found)), held_out["assumed levels"]
    for left_m in (0.0, 0.5, 1.0):
        assert rates(found, alerts, left_m)[0] == pytest.approx(claimed[f"TP, {left_m:g} m left"], abs=0.006)
    assert rates(found, alerts, 0.0)[1] == pytest.approx(claimed["TN"], abs=0.006)
    assert len(np.unique(found.walk)) == held_out["walks"]


def test_stated_probabilities_are_observed_and_a_shift_is_seen():
    found, probability, *_ = _read_table(TABLE)
    assert _worst(found, probability) < 4.0
    for shift in (-1.5, 1.5):
        assert _worst(found, expit(logit(probability) + shift)) > 4.0


def test_the_card_of_bearings_is_that_of_the_weights():
    stated_on_card = _held_out(BEARING_WEIGHTS)
    found = errors(bearing_model(), BearingExamples.from_file(BEARING_TABLE))
    assert found.keys() == stated_on_card.keys()
    for name, entry in found.items():
        if isinstance(entry, dict):
            assert entry["beeps"] == stated_on_card[name]["beeps"]
            assert entry["median"] == pytest.approx(stated_on_card[name]["median"], abs=0.11)
