"""Gait walks: straight on average, periodic around it, smooth, and refused when they make no sense."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.walks.gait_walk import Gait, GaitWalk
from scenes.walks.routes import Pace, Route, RouteWalk
from simulator.scene.pose import StraightWalk


def test_without_gait_it_is_a_straight_walk() -> None:
    start, time = np.array([1.0, 2.0, 1.3]), np.linspace(0.0, 4.0, 9)
    plain = StraightWalk(start, 0.4, 1.2, 4.0, pitch_rad=np.deg2rad(30.0)).pose(time)
    gait = GaitWalk(start, 0.4, 1.2, 4.0, gait=Gait()).pose(time)
    np.testing.assert_allclose(gait.position_m, plain.position_m, atol=1e-15)
    np.testing.assert_allclose(gait.rotation.as_matrix(), plain.rotation.as_matrix(), atol=1e-15)
    np.testing.assert_array_equal(gait.body_heading_rad(), plain.body_heading_rad())


def test_standing_still_has_no_gait() -> None:
    position = GaitWalk(np.array([0.0, 0.0, 1.3]), speed_m_s=0.0).pose(np.linspace(0.0, 4.0, 50)).position_m
    np.testing.assert_array_equal(position, np.tile([0.0, 0.0, 1.3], (50, 1)))


def test_a_walk_has_its_walkers_walk_ratio() -> None:
    """None without steps: standing, or gliding."""
    start = np.array([0.0, 0.0, 1.3])
    own = GaitWalk(start, speed_m_s=0.9, gait=Gait.at_speed(0.9, walk_ratio_m_min=0.0058))
    assert own.walk_ratio_m_min == pytest.approx(0.0058)
    assert GaitWalk(start, speed_m_s=0.0).walk_ratio_m_min is None
    assert GaitWalk(start, speed_m_s=0.9, gait=Gait()).walk_ratio_m_min is None


def test_cadence_follows_from_the_walk_ratio() -> None:
    """At 62 m/min people take 98 steps a minute (Murakami and Otaka 2017)."""
    assert Gait.at_speed(62.0 / 60.0).step_hz * 60.0 == pytest.approx(98.0, rel=0.002)
    assert 1.6 < Gait.at_speed(1.2).step_hz < 2.0


def test_who_takes_longer_steps_takes_fewer() -> None:
    usual, long = Gait.at_speed(1.2), Gait.at_speed(1.2, walk_ratio_m_min=0.00646 * 1.44)
    assert long.step_hz == pytest.approx(usual.step_hz / 1.2)
    for ratio in (0.0, -0.006, np.nan, np.inf):
        with pytest.raises(ValueError, match=f"walk_ratio_m_min must be positive and finite, got {ratio}"):
            Gait.at_speed(1.2, walk_ratio_m_min=ratio)


def test_bob_is_twice_as_fast_as_sway() -> None:
    gait = Gait.at_speed(1.3)
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), speed_m_s=1.3, duration_s=20.0)
    time = np.arange(0.0, 8.0 / gait.step_hz, 0.001)
    position = walk.pose(time).position_m
    assert np.ptp(position[:, 2]) == pytest.approx(2.0 * gait.bob_m, rel=1e-3)
    assert np.ptp(position[:, 1]) == pytest.approx(2.0 * gait.sway_m, rel=1e-3)
    bob_hz, sway_hz = (_strongest_hz(position[:, axis], 0.001) for axis in (2, 1))
    assert bob_hz == pytest.approx(gait.step_hz, rel=0.02)
    assert sway_hz == pytest.approx(0.5 * gait.step_hz, rel=0.02)


def test_the_body_is_fastest_when_lowest() -> None:
    """Kinetic and potential energy are exchanged, as in an inverted pendulum."""
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), speed_m_s=1.3)
    time = np.linspace(0.0, 3.0, 3000)
    position = walk.pose(time).position_m
    speed, height = np.gradient(position[:, 0], time), position[:, 2] - 1.3
    assert np.corrcoef(speed, height)[0, 1] < -0.999


def test_the_top_edge_is_lifted_and_points_forwards() -> None:
    walk = GaitWalk(np.zeros(3), heading_rad=0.7, pitch_rad=np.deg2rad(35.0), gait=Gait())
    top = walk.pose([0.0]).rotation.apply([0.0, 1.0, 0.0])[0]
    expected = [np.cos(0.7) * np.cos(np.deg2rad(35)), np.sin(0.7) * np.cos(np.deg2rad(35)), np.sin(np.deg2rad(35))]
    np.testing.assert_allclose(top, expected, atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(speed=st.floats(0.3, 1.6), heading=st.floats(-3.0, 3.0), phase=st.floats(0.0, 12.0), at=st.floats(0.0, 5.0))
def test_never_far_from_the_mean_path_and_smooth(speed: float, heading: float, phase: float, at: float) -> None:
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), heading, speed, 5.0, gait=Gait.at_speed(speed, phase))
    time = at + np.array([-1e-4, 0.0, 1e-4])
    position = walk.pose(time).position_m
    mean = speed * time[:, None] * [np.cos(heading), np.sin(heading), 0.0] + [0.0, 0.0, 1.3]
    assert np.linalg.norm(position - mean, axis=1).max() < 0.05
    acceleration = (position[0] - 2.0 * position[1] + position[2]) / 1e-8
    assert np.linalg.norm(acceleration) < 0.6 * 9.81


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed_m_s": -1.0}, "speed_m_s must be finite and not negative, got -1.0"),
        ({"duration_s": 0.0}, "duration_s must be positive, got 0.0"),
        ({"start_m": np.array([0.0, np.nan, 1.0])}, "start_m must be three finite numbers"),
        ({"heading_rad": np.inf}, "heading_rad must be in radians, finite"),
    ],
)
def test_senseless_walks_are_refused(change: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        GaitWalk(**({"start_m": np.zeros(3)} | change))


def test_negative_amplitudes_are_refused() -> None:
    with pytest.raises(ValueError, match="bob_m must not be negative"):
        Gait(step_hz=1.8, bob_m=-0.01)


def _strongest_hz(signal: np.ndarray, step_s: float) -> float:
    spectrum = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(len(signal)), 16 * len(signal)))
    return float(np.fft.rfftfreq(16 * len(signal), step_s)[np.argmax(spectrum)])


def test_held_horizontally_the_long_edge_lies_across_and_the_screen_faces_the_same_way() -> None:
    portrait, landscape = (
        GaitWalk(np.zeros(3), heading_rad=0.7, gait=Gait(), holding=holding).pose([0.0]).rotation
        for holding in ("vertical", "horizontal")
    )
    top = landscape.apply([0.0, 1.0, 0.0])[0]
    np.testing.assert_allclose(top, [-np.sin(0.7), np.cos(0.7), 0.0], atol=1e-12)
    np.testing.assert_allclose(landscape.apply([0.0, 0.0, 1.0]), portrait.apply([0.0, 0.0, 1.0]), atol=1e-12)


def test_another_holding_is_refused() -> None:
    with pytest.raises(ValueError, match=r"holding must be one of .*got 'sideways'"):
        GaitWalk(np.zeros(3), holding="sideways")


def test_the_mean_path_is_the_walk_without_its_gait() -> None:
    """Cause: truth took a straight line through the gait by least squares, off by up to 1 cm at the walk's end."""
    walk, time = GaitWalk(np.array([1.0, 2.0, 1.3]), 0.4, 1.2, 4.0), np.linspace(0.0, 4.0, 9)
    still = GaitWalk(walk.start_m, 0.4, 1.2, 4.0, gait=Gait())
    np.testing.assert_allclose(walk.mean_plan_m(time), still.pose(time).position_m[:, :2], atol=1e-15)


WALKS = {
    "straight": lambda **changed: StraightWalk(**{"start_m": [0.0, 0.0, 1.3], "heading_rad": 0.0, "speed_m_s": 1.3,
                                                  "duration_s": 4.0} | changed),
    "gait": lambda **changed: GaitWalk(**{"start_m": [0.0, 0.0, 1.3]} | changed),
    "route": lambda **changed: RouteWalk(**{"route": Route([[0.0, 0.0], [4.0, 0.0]]), "pace": Pace(1.3),
                                            "duration_s": 4.0} | changed),
}  # fmt: skip


@pytest.mark.parametrize("walk", WALKS)
@pytest.mark.parametrize("time_s", ["1.0", "x", True, None, np.nan, np.inf, 1j, [[0.0, 1.0]], [[0.0], [0.0, 1.0]]])
def test_all_walks_refuse_the_same_times(walk: str, time_s: Any) -> None:
    """Walks with gait took texts and truth values for numbers, and of NaN they said that the position was wrong."""
    with pytest.raises(ValueError, match="time_s must "):
        WALKS[walk]().pose(time_s)


@pytest.mark.parametrize("walk", WALKS)
@pytest.mark.parametrize("value", [[1.0, 2.0], [], None, "0.5", True, np.nan, 30.0])
def test_all_walks_refuse_the_same_angles(walk: str, value: Any) -> None:
    """Those with gait took two pitches for one, and no heading at all."""
    with pytest.raises(ValueError, match="pitch_rad must be "):
        WALKS[walk](pitch_rad=value)
    if walk != "route":
        with pytest.raises(ValueError, match="heading_rad must be "):
            WALKS[walk](heading_rad=value)
