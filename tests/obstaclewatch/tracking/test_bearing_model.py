"""Bearings from known probabilities; the network against plain sums; files; unusual numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import softmax

from obstaclewatch.tracking.bearing_evidence import NUMBERS
from obstaclewatch.tracking.bearing_model import EDGES_RAD, WEIGHTS, BearingModel, bearing_model
from obstaclewatch.tracking.deviations import MOST_DEVIATIONS

RNG = np.random.default_rng(0)
BINS = len(EDGES_RAD) - 1


def _stating(share):
    """A model that states the same shares whatever it is given."""
    layers = (np.zeros((4, NUMBERS), np.float32), np.zeros((BINS, 4), np.float32))
    offsets = np.zeros(4, np.float32), np.log(np.maximum(share, 1e-30)).astype(np.float32)
    return BearingModel(np.zeros(NUMBERS), np.ones(NUMBERS), layers, offsets)


def _quantile(share, of):
    """By a fine table of the distribution, uniform within bins."""
    fine = np.linspace(0.0, EDGES_RAD[-1], 200_001)
    return np.interp(of, np.interp(fine, EDGES_RAD, np.concatenate([[0.0], np.cumsum(share)])), fine)


def test_the_bearing_is_the_median_and_the_claim_half_of_the_middle_68_percent():
    for share in (*RNG.dirichlet(0.2 * np.ones(BINS), 20), np.eye(BINS)[0], np.eye(BINS)[-1]):
        bearing_rad, std_rad = _stating(share).bearings(np.zeros((1, NUMBERS)))
        low, middle, high = (_quantile(share, of) for of in (0.16, 0.5, 0.84))
        assert bearing_rad[0] == pytest.approx(middle, abs=2e-4)
        assert std_rad[0] == pytest.approx(0.5 * (high - low), abs=2e-4)


def test_shares_are_those_of_plain_sums():
    model, evidence = bearing_model(), RNG.normal(size=(3, NUMBERS)) * bearing_model().spread + bearing_model().usual
    values = np.clip((evidence - model.usual) / model.spread, -MOST_DEVIATIONS, MOST_DEVIATIONS)
    for weight, offset in zip(model.weights[:-1], model.offsets[:-1], strict=True):
        values = np.maximum(values @ weight.T.astype(np.float64) + offset, 0.0)
    expected = softmax(values @ model.weights[-1].T.astype(np.float64) + model.offsets[-1], axis=1)
    assert model.shares(evidence) == pytest.approx(expected, abs=1e-5)
    assert model.shares(evidence[1:2]) == pytest.approx(expected[1:2], abs=1e-5)
    assert [len(found) for found in model.bearings(np.zeros((0, NUMBERS)))] == [0, 0]


def test_what_is_missing_is_usual_and_what_is_unusual_is_limited():
    model = bearing_model()
    usual = model.usual[None]
    missing, far, farther = usual.copy(), usual.copy(), usual.copy()
    missing[0, 3], far[0, 3] = np.nan, model.usual[3] + MOST_DEVIATIONS * model.spread[3]
    farther[0, 3] = np.inf
    assert (model.shares(missing) == model.shares(usual)).all()
    assert (model.shares(farther) == model.shares(far)).all()


def test_a_file_has_all_of_it_and_another_size_is_refused(tmp_path):
    model = bearing_model()
    model.write(tmp_path / "again.npz")
    again = BearingModel.from_file(tmp_path / "again.npz")
    evidence = RNG.normal(size=(5, NUMBERS))
    assert (again.shares(evidence) == model.shares(evidence)).all()
    fewer = replace(model, weights=(model.weights[0][:, 1:], *model.weights[1:]))
    fewer.write(tmp_path / "fewer.npz")
    with pytest.raises(
        ValueError, match=rf"fewer.npz must take {NUMBERS} numbers and give {BINS}, got \({NUMBERS - 1}"
    ):
        BearingModel.from_file(tmp_path / "fewer.npz")
    assert WEIGHTS.stat().st_size < 200_000
