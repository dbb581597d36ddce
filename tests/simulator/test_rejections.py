"""What the masks turn away can be asked for, and agrees with what tracing counts."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from simulator import Air, Fidelity, Obstacle, Pose, Scene, held_rotation, trace_paths, trace_rejected

C = 343.0


@pytest.fixture
def street(box, cylinder) -> Scene:
    obstacles: list[Obstacle] = [
        box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground"),
        box((0.2, 3.0, 3.0), (3.1, 0.4, 1.5), "wall"),
        box((0.2, 3.0, 3.0), (4.1, 0.4, 1.5), "house behind"),
        box((0.5, 0.5, 1.0), (1.5, -1.3, 0.5), "box"),
        cylinder(0.3, 2.0, (1.8, -0.4, 1.0), 32),
    ]
    return Scene(obstacles, Air.lossless(C))


POSES = Pose([[0.0, 0.0, 1.3], [0.3, 0.2, 0.9]], held_rotation([0.1, -0.2], [0.3, 0.4]))


def test_listing_agrees_with_the_counts_of_tracing(street, phone):
    fidelity = Fidelity(max_order=3, max_range_m=4.0, edge_floor_db=-40.0)
    paths = trace_paths(street, phone, POSES, fidelity)
    rejected = trace_rejected(street, phone, POSES, fidelity, limit=10**6)
    assert rejected.left_out == 0
    assert {name: count for name, count in paths.rejected.items() if count} == Counter(rejected.mask.tolist())
    assert {"outside its patch", "behind a patch", "hidden", "faint edge", "too long"} <= set(rejected.mask)
    assert {"specular", "edge", "mixed"} <= set(rejected.kind)
    assert dict(rejected.counts) == dict(paths.rejected)


def test_strongest_come_first_and_the_rest_is_counted(street, phone):
    every = trace_rejected(street, phone, POSES, limit=10**6)
    some = trace_rejected(street, phone, POSES, limit=20)
    assert len(some) == 20
    assert some.left_out == len(every) - 20 > 0
    assert (every.level_db[1:] <= every.level_db[:-1]).all()
    np.testing.assert_array_equal(some.level_db, every.level_db[:20])
    np.testing.assert_array_equal(some.points_m, every.points_m[:20])


def test_wall_behind_a_wall_says_where_and_how_loud_it_would_be(box, phone):
    near = box((0.2, 8.0, 4.0), (2.1, 0.0, 0.0), "near")
    far = box((0.2, 8.0, 4.0), (4.1, 0.0, 0.0), "far")
    once = Fidelity(max_order=1, mechanisms=("specular",))
    rejected = trace_rejected(
        Scene([near, far], Air.lossless(C)), phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), once
    )
    hidden = rejected[rejected.mask == "hidden"]
    assert hidden.obstacle.tolist() == ["far", "far"]
    assert sorted(hidden.mic.tolist()) == [0, 1]
    np.testing.assert_allclose(hidden.points_m[:, 1], [[4.0, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(hidden.level_db, -20.0 * np.log10([3.95 + 3.93, 3.95 + 4.07]), atol=1e-9)
    assert "far at (4.00, 0.00, 0.00): hidden" in rejected.explain()


def test_mirror_point_beside_its_wall_is_where_the_endless_wall_would_have_it(box, phone):
    aside = box((0.2, 1.0, 4.0), (3.1, 2.0, 0.0), "aside")
    once = Fidelity(max_order=1, mechanisms=("specular",))
    rejected = trace_rejected(Scene([aside], Air.lossless(C)), phone, Pose(np.zeros(3), held_rotation(0.0)), once)
    front = rejected[(rejected.mask == "outside its patch") & np.isclose(rejected.points_m[:, 1, 0], 3.0)]
    assert sorted(front.mic.tolist()) == [0, 1]
    np.testing.assert_allclose(front.points_m[:, 1], [[3.0, 0.0, 0.0]] * 2, atol=1e-12)
    np.testing.assert_allclose(10.0 ** (-front.level_db / 20.0), [2.95 + 2.93, 2.95 + 3.07], rtol=1e-12)


def test_missed_mirror_of_a_curved_path_keeps_the_level_between_the_images(box, cylinder, phone):
    # the ground ends before the post: every path by way of it misses, and would be as loud as with ground there
    post = cylinder(0.25, 3.0, (2.25, 0.0, 1.5), 48)
    pose = Pose([0.0, 0.0, 1.3], held_rotation(0.0, 0.6))
    short = Scene([post, box((1.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground")], Air.lossless(C))
    full = Scene([post, box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground")], Air.lossless(C))
    fidelity = Fidelity(mechanisms=("specular", "curved"))
    rejected = trace_rejected(short, phone, pose, fidelity)
    missed = rejected[(rejected.kind == "mixed") & (rejected.mask == "outside its patch")]
    paths = trace_paths(full, phone, pose, fidelity)
    there = paths[(paths.kind == "mixed")]
    assert len(missed) == len(there) >= 2
    np.testing.assert_allclose(np.sort(missed.level_db), np.sort(20 * np.log10(np.abs(there.gain))), atol=0.02)
    ours, theirs = np.sort(missed.points_m[:, 1:3].reshape(-1)), np.sort(there.points_m[:, 1:3].reshape(-1))
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_hidden_and_kept_together_are_the_paths_without_walls_between(box, phone):
    # nothing is lost between the two lists: what a screen hides is what the scene without it lets through
    wall, screen = box((0.2, 8.0, 4.0), (3.1, 0.0, 0.0), "wall"), box((0.02, 1.0, 1.0), (1.5, 0.0, 0.0), "screen")
    once, pose = Fidelity(max_order=1, mechanisms=("specular",)), Pose(np.zeros(3), held_rotation(0.0))
    open_ = trace_paths(Scene([wall], Air.lossless(C)), phone, pose, once)
    hidden = trace_rejected(Scene([wall, screen], Air.lossless(C)), phone, pose, once)
    hidden = hidden[(hidden.mask == "hidden") & (hidden.obstacle == "wall")]
    echo = open_[open_.order == 1]
    np.testing.assert_allclose(np.sort(hidden.level_db), np.sort(20.0 * np.log10(np.abs(echo.gain))), atol=1e-9)


@pytest.mark.parametrize("limit", [0, -3, 2.5, True])
def test_limit_must_be_a_count(street, phone, limit):
    with pytest.raises(ValueError, match=f"limit must be .* got {limit}"):
        trace_rejected(street, phone, POSES, limit=limit)


@pytest.mark.parametrize(
    ("changed", "rule"),
    [
        ({"pose": None}, "pose must be of type Pose, got None"),
        ({"phone": None}, "phone must be of type Phone, got None"),
        ({"fidelity": "standard"}, "fidelity must be of type Fidelity, got 'standard'"),
        ({"fidelity": 0}, "fidelity must be of type Fidelity, got 0"),
        ({"time_s": [0.0, 1.0, 2.0]}, r"time_s must be finite with shape \(2,\), got \[0.0, 1.0, 2.0\]"),
    ],
)
def test_what_tracing_refuses_is_refused(street, phone, changed, rule):
    """Only `trace_paths` checked types: the same mistakes were a TypeError or an AttributeError here."""
    with pytest.raises(ValueError, match=rule):
        trace_rejected(**({"scene": street, "phone": phone, "pose": POSES} | changed))


def test_limit_may_come_from_numpy(street, phone):
    """A numpy integer was refused, and True taken for 1."""
    rejected = trace_rejected(street, phone, POSES, Fidelity(mechanisms=("specular",)), limit=np.int64(3))
    assert len(rejected) == 3
    assert len(rejected[[]]) == 0
    with pytest.raises(ValueError, match="paths must be selected by a mask, an index array or a slice, got 0"):
        rejected[0]
