"""The network against plain correlations and, where PyTorch is there, against it; files; unusual numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import correlate2d

from obstaclewatch.tracking.approach_picture import SHAPE
from obstaclewatch.tracking.collision_model import (
    WEIGHTS,
    CollisionModel,
    _convolved,
    _greatest_of_four,
    collision_model,
)
from obstaclewatch.tracking.deviations import MOST_DEVIATIONS
from obstaclewatch.tracking.evidence import NO_EVIDENCE, OF_TRACKS, Evidence

RNG = np.random.default_rng(0)
PICTURES = RNG.normal(size=(3, *SHAPE)).astype(np.float32)
EVIDENCE = np.array([np.array(NO_EVIDENCE) + k for k in range(3)])


def test_a_layer_is_a_sum_of_correlations():
    values = RNG.normal(size=(2, 3, 6, 8)).astype(np.float32)
    kernel, offset = RNG.normal(size=(4, 3, 3, 3)).astype(np.float32), RNG.normal(size=4).astype(np.float32)
    found = _convolved(values, kernel, offset)
    for n in range(2):
        for k in range(4):
            whole = sum(correlate2d(values[n, c], kernel[k, c], mode="same") for c in range(3)) + offset[k]
            assert found[n, k] == pytest.approx(np.maximum(whole, 0.0), abs=1e-5)
    assert _greatest_of_four(values)[1, 2, 1, 3] == values[1, 2, 2:4, 6:8].max()


def test_the_network_is_the_one_that_was_learned():
    torch = pytest.importorskip("torch", reason="PyTorch comes with the extra `training`")
    functional, network = torch.nn.functional, collision_model().networks[0]
    numbers = torch.from_numpy(collision_model().numbers(EVIDENCE))
    seen = torch.from_numpy(PICTURES)
    for layer, (kernel, offset) in enumerate(zip(network.kernels, network.kernel_offsets, strict=True)):
        seen = functional.relu(functional.conv2d(seen, torch.from_numpy(kernel), torch.from_numpy(offset), padding=1))
        seen = functional.max_pool2d(seen, 2) if layer < 2 else seen
    joined = torch.cat([seen.flatten(1), numbers], dim=1)
    hidden = functional.relu(joined @ torch.from_numpy(network.hidden).T + torch.from_numpy(network.hidden_offset))
    log_odds = (hidden @ torch.from_numpy(network.output)).numpy() + network.output_offset
    assert network.log_odds(PICTURES, numbers.numpy()) == pytest.approx(log_odds, abs=1e-4)


def test_one_beep_and_many_are_the_same():
    model = collision_model()
    many = model.probabilities(EVIDENCE, PICTURES)
    assert model.probability(Evidence(*EVIDENCE[1]), PICTURES[1]) == pytest.approx(many[1], abs=1e-6)
    assert ((many > 0.0) & (many < 1.0)).all()


def test_what_is_missing_is_marked_and_what_is_unusual_is_limited():
    model = collision_model()
    strange = EVIDENCE.copy()
    strange[0, OF_TRACKS:], strange[1, :OF_TRACKS] = 1e9, 0.0
    found = model.numbers(strange)
    assert np.abs(found).max() == MOST_DEVIATIONS
    assert found[:, len(Evidence._fields) :].tolist() == [[1.0] * OF_TRACKS, [0.0] * OF_TRACKS, [1.0] * OF_TRACKS]


def test_odds_that_suffice_are_in_proportion_to_the_cost_of_a_false_alert():
    """The threshold of 0.96 from 1 m on has odds of 24."""
    model = replace(collision_model(), left_m=np.array([0.5, 1.0]), thresholds=np.array([0.8, 0.96]))
    odds = np.array([7.9, 8.1, 47.0, 49.0])
    probability = odds / (1.0 + odds)
    assert model.suffices(probability, 0.5, 2.0).tolist() == [False, True, True, True]
    assert model.suffices(probability, 1.0, 2.0).tolist() == [False, False, False, True]
    assert (model.suffices(probability, 1.0) == (probability > 0.96)).all()


def test_a_file_is_read_as_it_was_written_and_another_one_refused(tmp_path):
    model = collision_model()
    model.write(tmp_path / "model.npz")
    again = CollisionModel.from_file(tmp_path / "model.npz")
    assert (again.probabilities(EVIDENCE, PICTURES) == model.probabilities(EVIDENCE, PICTURES)).all()
    network = model.networks[0]
    fewer = replace(network, kernels=(network.kernels[0][:, 1:], *network.kernels[1:]))
    replace(model, networks=(fewer,)).write(tmp_path / "fewer.npz")
    with pytest.raises(ValueError, match="must have kernels for 12 layers, got \\[11\\]"):
        CollisionModel.from_file(tmp_path / "fewer.npz")
    with np.load(WEIGHTS) as stored:
        other = dict(stored) | {"numbers": np.array(["hit"])}
    np.savez(tmp_path / "other.npz", **other)
    with pytest.raises(ValueError, match="must have numbers"):
        CollisionModel.from_file(tmp_path / "other.npz")
