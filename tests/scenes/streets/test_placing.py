"""Putting obstacles where they are wanted."""

import numpy as np
import pytest

from scenes.obstacles import litter_bin, wall
from scenes.streets.placing import (
    Occupied,
    apart,
    distance_along,
    extents,
    half_width_across,
    lateral_shift,
    moved_back,
    placed,
)
from scenes.truth.swept import Body, Slab
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

AHEAD = np.array([1.0, 0.0])


def a_bin(at=(0.0, 0.0), velocity=(0.0, 0.0, 0.0)) -> Obstacle:
    return placed(Obstacle(litter_bin(0.3), Material.rigid(), "bin"), at, 0.0, velocity)


def test_placing_turns_then_moves() -> None:
    turned = placed(Obstacle(wall(8.0, 3.0, 0.2), Material.rigid(), "wall"), (5.0, 1.0), np.pi / 2)
    np.testing.assert_allclose(turned.mesh.bounds, [[1.0, 0.9, 0.0], [9.0, 1.1, 3.0]], atol=1e-12)


def test_setting_the_clock_back_moves_what_moves() -> None:
    back = moved_back(a_bin((3.0, 0.0), (1.0, 0.5, 0.0)), 2.0)
    np.testing.assert_allclose(back.mesh.bounds[:, :2].mean(axis=0), [1.0, -1.0], atol=1e-12)
    still = a_bin((3.0, 0.0))
    assert moved_back(still, 2.0) is still


def test_a_near_edge_comes_where_it_is_wanted_on_either_side() -> None:
    extent = extents(a_bin(), np.array([0.0, 1.0]), 1.8)
    assert extent == pytest.approx((-0.3, 0.3), abs=1e-12)
    assert lateral_shift(0.5, 1.0, extent) == pytest.approx(0.8)
    assert lateral_shift(0.5, -1.0, extent) == pytest.approx(-0.8)


def test_a_body_is_wider_across_a_line_it_does_not_face() -> None:
    body = Body(half_width_m=0.25, front_m=0.1, back_m=0.6)
    assert half_width_across(body, 0.3, 0.3) == pytest.approx((0.25, 0.0), abs=1e-12)
    width, middle = half_width_across(body, np.pi / 2, 0.0)
    assert width == pytest.approx(0.35)
    assert middle == pytest.approx(-0.25)


@pytest.mark.parametrize(("yaw", "lateral"), [(0.0, 0.0), (0.0, 0.5), (0.7, 9.0), (-0.7, 9.0), (1.4, 2.0)])
def test_a_wall_askew_comes_to_the_wanted_distance(yaw: float, lateral: float) -> None:
    """A long wall's near end may lie metres ahead of its middle, or behind it: both once broke the search."""
    long = placed(Obstacle(wall(20.0), Material.rigid(), "wall"), (0.0, 0.0), yaw)
    along = distance_along(long, np.zeros(2), np.array([0.0, lateral]), AHEAD, 5.0)
    slab = Slab.of(placed(long, (along, lateral)).mesh, 0.0, 1.8)
    assert slab.distance(np.zeros((1, 2, 2)))[0] == pytest.approx(5.0, abs=1e-6)


def test_a_distance_below_the_offset_is_refused() -> None:
    with pytest.raises(ValueError, match="distance_m must be above the offset of 'bin' from the line"):
        distance_along(a_bin(), np.zeros(2), np.array([0.0, 5.0]), AHEAD, 2.0)


def test_apart_follows_what_moves() -> None:
    taken = [Occupied.by(a_bin((3.0, 0.0)))]
    assert apart(a_bin((0.0, 0.0)), taken, 4.0, 0.1)
    assert not apart(a_bin((0.0, 0.0), (1.0, 0.0, 0.0)), taken, 4.0, 0.1)
    assert apart(a_bin((0.0, 2.0), (1.0, 0.0, 0.0)), taken, 4.0, 0.1)
    assert not apart(a_bin((2.2, 0.0)), taken, 4.0, 0.1)
