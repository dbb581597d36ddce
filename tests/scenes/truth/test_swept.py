"""Contact between a moving stadium and a slab of a mesh."""

import numpy as np
import pytest

from scenes.obstacles import car, dumpster, person, wall
from scenes.obstacles.solids import box, cylinder
from scenes.truth.swept import Body, Slab


def straight_cores(start: tuple[float, float], end: tuple[float, float], count: int = 400) -> np.ndarray:
    """Cores without length, on a line."""
    step = np.linspace(0.0, 1.0, count)[:, None]
    place = np.array(start) + step * (np.array(end) - start)
    return np.repeat(place[:, None], 2, axis=1)


def first_contact(slab: Slab, cores: np.ndarray, half_width: float = 0.25) -> float:
    return slab.first_contact(cores, slab.distance(cores), half_width)


def test_distance_to_a_box_in_plan() -> None:
    """Ahead of it, off its corner, across it, and within it."""
    segments = [[[3.0, 0.0], [4.0, 0.0]], [[2.5, 2.5], [2.5, 2.5]], [[-3.0, 0.1], [3.0, 0.1]], [[0.1, 0.1], [0.2, 0.1]]]
    distance = Slab.of(box([1.0, 1.0, 1.0]), 0.0, 1.8).distance(np.array(segments))
    assert distance == pytest.approx([2.5, 2.0 * np.sqrt(2.0), 0.0, 0.0], abs=1e-15)


def test_only_what_is_within_the_slab_counts() -> None:
    """A cone is met where it is widest below the walker's height."""
    cone = cylinder(0.1, 4.0, segments=720, rows=1, top_radius_m=1.0)
    slab = Slab.of(cone, 0.0, 2.0)
    assert slab.distance(np.array([[[3.0, 0.0], [3.0, 0.0]]]))[0] == pytest.approx(3.0 - 0.55, abs=1e-5)
    beam = Slab.of(box([1.0, 1.0, 0.2], [0.0, 0.0, 2.5]), 0.0, 1.8)
    cores = straight_cores((-3, 0), (3, 0))
    assert len(beam.triangle_m) == 0
    assert np.isposinf(beam.distance(cores)).all()
    assert np.isnan(first_contact(beam, cores))


def test_first_contact_with_a_wall_is_where_the_gap_closes() -> None:
    slab = Slab.of(wall(thickness_m=0.2), 0.0, 1.8)
    index = first_contact(slab, straight_cores((-5.0, 0.0), (1.0, 0.0), 601))
    assert index == pytest.approx((5.0 - 0.1 - 0.25) / 0.01, abs=1e-6)


def test_passing_by_is_not_contact_and_its_gap_is_exact() -> None:
    slab = Slab.of(cylinder(0.3, 1.0, segments=720), 0.0, 1.8)
    cores = straight_cores((-4.0, 0.6), (4.0, 0.6))
    assert slab.distance(cores).min() == pytest.approx(0.3, abs=1e-4)
    assert np.isnan(first_contact(slab, cores, 0.299))
    assert np.isfinite(first_contact(slab, cores, 0.301))


@pytest.mark.parametrize("mesh", [car("suv"), person(), dumpster()], ids=["car", "person", "dumpster"])
def test_distances_agree_with_dense_samples(mesh) -> None:
    """Independent reference: the nearest of many surface samples to many points of the core."""
    slab = Slab.of(mesh, 0.0, 1.8)
    rng = np.random.default_rng(4)
    triangles = mesh.triangles
    weights = rng.dirichlet(np.full(3, 0.6), 150)  # thick near corners and edges, where the plan's outline lies
    samples = np.einsum("wk,fkc->fwc", weights, triangles).reshape(-1, 3)
    samples = np.unique(np.round(samples[samples[:, 2] <= 1.8][:, :2], 3), axis=0)
    for _ in range(4):
        angle, reach = rng.uniform(-np.pi, np.pi), rng.uniform(3.0, 4.0)
        core = reach * np.array([np.cos(angle), np.sin(angle)]) + rng.uniform(-0.2, 0.2, (2, 2))
        along = np.linspace(core[0], core[1], 20)
        expected = min(np.linalg.norm(samples - point, axis=1).min() for point in along)
        found = slab.distance(core[None])[0]
        assert found <= expected + 1e-3  # samples are rounded to 1 mm
        assert expected - found < 0.01


@pytest.mark.parametrize(("near_m", "beyond_m"), [(0.0, 0.0), (0.25, 0.0), (0.0, 0.3)])
def test_what_is_near_has_its_distance_and_the_rest_a_bound(near_m: float, beyond_m: float) -> None:
    """On crooked ways past a person, at even and at jumping pace, met and missed."""
    slab, rng, asked_of = Slab.of(person(), 0.0, 1.8), np.random.default_rng(6), []
    for _ in range(20):
        place = np.cumsum(rng.normal(0.0, 0.02, (200, 2)), axis=0) + np.linspace([-2.0, 0.0], [2.0, 0.0], 200)
        place += rng.uniform(-0.8, 0.8, 2) + (rng.random((200, 1)) < 0.01) * rng.normal(0.0, 1.0, (200, 2))
        core = np.stack([place, place + rng.uniform(-0.3, 0.3, 2)], axis=1)
        exact, found = slab.distance(core), slab.distance_where_near(core, near_m, beyond_m)
        near = exact <= max(near_m, exact.min() + beyond_m)
        np.testing.assert_array_equal(found[near], exact[near])
        assert (found <= exact + 1e-12).all()
        assert (found[~near] > max(near_m, exact.min() + beyond_m)).all()
        asked_of.append(np.mean(found == exact))
    assert np.mean(asked_of) < 0.7


def test_an_empty_slab_is_nowhere_near() -> None:
    assert np.isposinf(Slab(np.empty((0, 3, 2))).distance_where_near(straight_cores((-3, 0), (3, 0)))).all()


def test_contact_lies_between_the_last_core_apart_and_the_first_that_touches() -> None:
    """At the index that is found, between two cores, the distance is the half width: to 1e-12 of a step of 2 cm."""
    slab = Slab.of(person(), 0.0, 1.8)
    rng = np.random.default_rng(5)
    contacts = 0
    for _ in range(12):
        offset = rng.uniform(-0.8, 0.8)
        cores = straight_cores((-3.0, offset), (3.0, offset + rng.uniform(-0.2, 0.2)), 300)
        touching = np.flatnonzero(slab.distance(cores) <= 0.25)
        index = first_contact(slab, cores)
        assert np.isfinite(index) == (len(touching) > 0)
        if len(touching):
            contacts += 1
            assert touching[0] - 1 < index <= touching[0]
            share = index - (touching[0] - 1)
            core = (1.0 - share) * cores[touching[0] - 1] + share * cores[touching[0]]
            assert slab.distance(core[None])[0] == pytest.approx(0.25, abs=1e-12)
    assert 0 < contacts < 12


def test_the_body_reaches_from_its_back_to_its_front() -> None:
    body = Body(half_width_m=0.25, front_m=0.1, back_m=0.6)
    core = body.core(np.array([[2.0, 1.0, 1.3]]), np.array([np.pi / 2]))
    np.testing.assert_allclose(core, [[[2.0, 0.85], [2.0, 0.65]]], atol=1e-15)
    wide = Body(half_width_m=0.5, front_m=0.1, back_m=0.6).core(np.zeros((1, 3)), np.zeros(1))
    np.testing.assert_allclose(wide, [[[-0.25, 0.0], [-0.25, 0.0]]], atol=1e-15)


def test_a_body_of_negative_measure_is_refused() -> None:
    with pytest.raises(ValueError, match="half_width_m must not be negative"):
        Body(half_width_m=-0.1)
    with pytest.raises(ValueError, match="height_m must be positive, got 0"):
        Body(height_m=0.0)
