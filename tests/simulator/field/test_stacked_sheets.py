"""Sheets on one another echo as the front one alone."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.array([20e3])


def _sheet(distance_m: float, half_m: float, material: Material, name: str) -> Obstacle:
    corners = half_m * np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]]) + [distance_m, 0.0, 0.0]
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False), material, name)


def _echo(obstacles, phone, fidelity):
    paths = trace_paths(Scene(obstacles, Air.lossless(343.0)), phone, Pose(np.zeros(3), held_rotation(0.0)), fidelity)
    echo = paths[paths.order > 0]
    return echo, echo.transfer_function(FREQUENCY_HZ)


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
@pytest.mark.parametrize("front_first", [True, False])
@pytest.mark.parametrize("gap_m", [1e-10, 1e-7, 3e-7, 3e-6, 3e-5])
def test_of_two_sheets_the_front_one_echoes(phone, gap_m, front_first, level):
    """Embree lets the last micrometres before a surface pass, so both echoed (+6 dB); where their images coincided to
    a tenth of a micrometre, the one listed first won; and edges of both counted whatever the gap."""
    brick, steel = (
        _sheet(1.5, 0.4, Material.named("brick"), "brick"),
        _sheet(1.5 + gap_m, 0.4, Material.rigid(), "steel"),
    )
    fidelity = Fidelity(level=level, max_order=1)
    found, both = _echo([brick, steel] if front_first else [steel, brick], phone, fidelity)
    alone = _echo([brick], phone, fidelity)[1]
    assert set(found.obstacle) == {"brick"}
    np.testing.assert_allclose(both, alone, rtol=1e-12)


@pytest.mark.parametrize("gap_m", [1e-9, 1e-6, 1e-4, 1e-3])
def test_a_kilometre_away(phone, gap_m):
    """What Embree lets pass grows with the distance: to a millimetre at a kilometre."""
    sheets = [_sheet(1000.0 + gap_m, 400.0, Material.rigid(), "back"), _sheet(1000.0, 400.0, Material.rigid(), "front")]
    found, _ = _echo(sheets, phone, Fidelity(mechanisms=("specular",), max_order=1, max_range_m=2000.0))
    assert found.obstacle.tolist() == ["front", "front"]


def test_of_coincident_sheets_the_first_listed_echoes(phone):
    """Their mirrors counted once, their edges twice (+1.6 dB on sheets of 0.8 m)."""
    sheets = [_sheet(1.5, 0.4, Material.rigid(), "first"), _sheet(1.5, 0.4, Material.rigid(), "second")]
    found, both = _echo(sheets, phone, Fidelity(max_order=1))
    assert set(found.obstacle) == {"first"}
    np.testing.assert_allclose(both, _echo(sheets[:1], phone, Fidelity(max_order=1))[1], rtol=1e-12)


def test_a_sheet_beside_another_in_one_plane_hides_nothing(phone):
    """Only what lies over the very point hides it: of two panes with a gap of 2 mm between them both echo."""
    panes = []
    for name, middle in (("left", 0.301), ("right", -0.301)):
        pane = _sheet(1.5, 0.3, Material.rigid(), name)
        pane.mesh.apply_translation([0.0, middle, 0.0])
        panes.append(pane)
    fidelity = Fidelity(max_order=1)
    both = _echo(panes, phone, fidelity)[0]
    alone = [_echo([pane], phone, fidelity)[0] for pane in panes]
    assert len(both) == sum(len(each) for each in alone) > 0


@pytest.mark.parametrize("gap_m", [0.0, 1e-6, 1e-4, 1e-3])
@pytest.mark.parametrize("front_first", [True, False])
def test_of_two_balls_the_outer_one_echoes(phone, gap_m, front_first):
    """Facets of a ball of 0.3 m stand off it by up to a millimetre, and what is closer did not hide it: +6 dB."""
    balls = []
    for name, radius in (("outer", 0.3), ("inner", 0.3 - gap_m)):
        mesh = trimesh.creation.icosphere(4, radius).apply_translation([1.8, 0.0, 0.1])
        balls.append(Obstacle(mesh, Material.rigid(), name))
    front = "outer" if front_first or gap_m else "inner"
    found, both = _echo(balls if front_first else balls[::-1], phone, Fidelity())
    assert set(found.obstacle) == {front}
    np.testing.assert_allclose(both, _echo(balls[:1], phone, Fidelity())[1], rtol=1e-9)


@pytest.mark.parametrize("level", ["standard", "auto"])
def test_a_sheet_in_the_plane_of_a_body_s_face_lies_upon_it(phone, level):
    """Which of the two answered hung on their order: a hard wall listed first echoed where a coat hangs on it."""
    wall = trimesh.creation.box(bounds=[[1.5, -2.0, -2.0], [1.7, 2.0, 2.0]])
    wall, coat = Obstacle(wall, Material.rigid(), "wall"), _sheet(1.5, 0.5, Material.named("coat"), "coat")
    mirrors = Fidelity(level=level, max_order=1, mechanisms=("specular",))
    for pair in ([coat, wall], [wall, coat]):
        assert set(_echo(pair, phone, mirrors)[0].obstacle) == {"coat"}
    one, other = (_echo(pair, phone, Fidelity(level=level))[1] for pair in ([coat, wall], [wall, coat]))
    np.testing.assert_allclose(one, other, rtol=1e-12)
