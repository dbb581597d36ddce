"""Ground truth against dense sampling, on random walks past random obstacles of every category.

The default tests take 300 walks, whose samples are stored (`make_dense_passages`); `-m slow` takes 10,000.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from scenes.obstacles import random_obstacle
from scenes.truth.swept import Body, Slab
from scenes.truth.truth import ground_truth
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle, Scene
from tests.references.make_dense_passages import (
    PHONE,
    STORED,
    WALKS,
    Dense,
    fingerprint,
    instant_s,
    random_passage,
    sampled,
)
from tests.scenes.brute_force import nearest_distance, plan_samples

BAND_M = 1e-3


def compare(passages: Iterable[tuple[Obstacle, Walk, Dense]]) -> dict[str, float]:
    """Largest deviations over many walks, and how many there were of what; NaN where one is no number."""
    worst = {"range_m": 0.0, "radius_m": 0.0, "clearance_m": 0.0, "contact_s": 0.0, "miss_m": 0.0}
    counts = {"walks": 0, "met": 0, "close": 0, "wrong": 0, "moving": 0}
    for seed, (obstacle, walk, slow) in enumerate(passages):
        fast = ground_truth(Scene([obstacle]), walk, PHONE, [instant_s(walk, seed)], "thing")
        met = bool(np.isfinite(fast.contact_time_s))
        close = abs(slow.gap_m) < BAND_M
        counts["walks"] += 1
        counts["met"] += met
        counts["close"] += close
        counts["moving"] += obstacle.moves
        counts["wrong"] += not close and met != bool(np.isfinite(slow.contact_s))
        if not close and not met:
            worst["clearance_m"] = np.maximum(worst["clearance_m"], abs(fast.clearance_m - slow.gap_m))
        if slow.gap_m < -0.01 and met:  # not grazing: there the instant is a matter of micrometres
            worst["contact_s"] = np.maximum(worst["contact_s"], abs(fast.contact_time_s - slow.contact_s))
        if np.isfinite(slow.miss_m):  # not below 5 cm, where samples are too far apart
            off = abs(slow.miss_m - fast.miss_distance_m)
            near = 0.0 if fast.miss_distance_m <= 0.05 else np.inf
            worst["miss_m"] = np.maximum(worst["miss_m"], off if slow.miss_m > 0.05 else near)
        if slow.range_m >= 0.3:
            worst["range_m"] = np.maximum(worst["range_m"], abs(fast.range_m[0] - slow.range_m))
            worst["radius_m"] = np.maximum(worst["radius_m"], abs(fast.radius_m[0] - 0.5 * slow.across_m))
    return worst | counts


def computed(seeds: range) -> Iterator[tuple[Obstacle, Walk, Dense]]:
    """Passages as sampled now."""
    for seed in seeds:
        obstacle, walk = random_passage(seed)
        yield obstacle, walk, sampled(obstacle, walk, seed)


def _is_true(found: dict[str, float]) -> None:
    assert 0.15 * found["walks"] < found["met"] < 0.8 * found["walks"]
    assert found["moving"] > 0.2 * found["walks"]
    assert found["close"] < 0.05 * found["walks"]
    assert found["wrong"] == 0
    assert found["range_m"] < 1e-4
    assert found["radius_m"] < 1e-9
    assert found["clearance_m"] < 1e-3
    assert found["contact_s"] < 5e-3
    assert found["miss_m"] < 5e-4


def test_three_hundred_walks_agree_with_dense_sampling() -> None:
    passages = [random_passage(seed) for seed in range(WALKS)]
    with np.load(STORED) as stored:
        same = stored["fingerprint"] == [fingerprint(*passage) for passage in passages]
        assert same.all(), "these seeds yield other passages now: python -m tests.references.make_dense_passages"
        dense = [Dense(*row) for row in stored["values"]]
    _is_true(compare((*passage, slow) for passage, slow in zip(passages, dense, strict=True)))


@pytest.mark.slow
def test_the_stored_walks_are_what_sampling_yields() -> None:
    with np.load(STORED) as stored:
        values = stored["values"]
    again = np.array([slow for *_, slow in computed(range(WALKS))])
    np.testing.assert_allclose(again, values, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_ten_thousand_walks_agree_with_dense_sampling() -> None:
    found = compare(computed(range(10_000)))
    print(found)
    assert found["walks"] == 10_000
    _is_true(found)


def test_the_sampled_distance_of_a_cube_is_that_of_its_closed_form() -> None:
    """The reference itself, on what is known."""
    from scenes.obstacles.solids import box

    cube = box([1.0, 1.0, 1.0])
    assert nearest_distance(cube, np.array([1.3, 0.1, 0.4])) == pytest.approx(0.8, abs=2e-5)
    assert nearest_distance(cube, np.array([1.5, 1.5, 0.4])) == pytest.approx(np.sqrt(2.0), abs=2e-5)
    assert np.ptp(plan_samples(cube), axis=0) == pytest.approx([1.0, 1.0])


def test_the_body_is_the_one_that_is_sampled() -> None:
    body = Body()
    core = body.core(np.zeros((1, 3)), np.zeros(1))[0]
    np.testing.assert_allclose(core, [[-0.15, 0.0], [-0.35, 0.0]], atol=1e-15)
    assert (body.half_width_m, body.height_m) == (0.25, 1.8)
    assert len(Slab.of(random_obstacle("wall", np.random.default_rng(0), "w").mesh, 0.0, 1.8).triangle_m) > 0
