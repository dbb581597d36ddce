"""Scenes in which the phone has no room are refused, by the name of what is in its way; all others pass."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch import BeepDesign
from simulator import (
    Fidelity,
    Material,
    Obstacle,
    Phone,
    Pose,
    Scene,
    StraightWalk,
    held_rotation,
    render_walk,
    trace_paths,
)

DIRECT = Fidelity(max_order=0)
LEVEL = Pose([0.0, 0.0, 0.0], held_rotation(0.0))  # speaker at x = 0.05, microphones at 0.07 and -0.07


def _sheet(x_m: float, velocity_m_s: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Obstacle:
    corners = np.array([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]], float) + [x_m, 0.0, 0.0]
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    return Obstacle(mesh, Material.rigid(), "sheet", velocity_m_s=velocity_m_s)


def _ball(x_m: float, radius_m: float, velocity_m_s: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Obstacle:
    mesh = trimesh.creation.icosphere(3, radius_m).apply_translation([x_m, 0.0, 0.0])
    return Obstacle(mesh, Material.rigid(), "ball", velocity_m_s=velocity_m_s)


@pytest.mark.parametrize("shift_m", [0.0, 1e6])
def test_a_phone_inside_a_closed_body(box, phone, shift_m):
    """It was traced as if it stood outside: faces do not reflect inwards, and the walls hid all else."""
    room = box((4.0, 4.0, 3.0), (shift_m, 0.0, 0.0), "room")
    pose = Pose([[shift_m - 3.0, 0.0, 0.0], [shift_m, 0.0, 0.0]], held_rotation(0.0))
    with pytest.raises(ValueError, match=r"the speaker inside 'room' at pose 1 \(2.500 s\)"):
        trace_paths(Scene([room]), phone, pose, DIRECT, time_s=[0.0, 2.5])


@pytest.mark.parametrize(("x_m", "what"), [(0.56, "microphone 0"), (-0.565, "microphone 1"), (0.549, "the speaker")])
def test_a_phone_half_in_a_wall(box, phone, x_m, what):
    """Only what is outside of the wall was lit, at the level of free space."""
    wall = box((1.0, 4.0, 4.0), (x_m, 0.0, 0.0), "wall")
    with pytest.raises(ValueError, match=f"{what} inside 'wall' at pose 0"):
        trace_paths(Scene([wall]), phone, LEVEL, DIRECT)


def test_an_obstacle_between_speaker_and_microphone(phone):
    """The direct sound passed through it: paths of no reflection were asked for nothing in their way."""
    with pytest.raises(ValueError, match=r"got 'sheet' between the speaker and microphone 1 at pose 0"):
        trace_paths(Scene([_ball(3.0, 0.5), _sheet(0.0)]), phone, LEVEL, DIRECT)
    with pytest.raises(ValueError, match=r"got 'ball' between the speaker and microphone 1 at pose 0"):
        trace_paths(Scene([_sheet(3.0), _ball(0.0, 0.02)]), phone, LEVEL, DIRECT)


def test_a_speaker_apart_from_its_microphones_is_hidden_from_them(box):
    """A pair as far apart as no phone's stands in a room like any other; its direct sound passed through walls."""
    pair = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 2.0, 0.0], [2.0, 0.0, 0.0]])
    wall = box((0.2, 9.0, 9.0), (1.0, 0.0, 0.0), "wall")
    direct = trace_paths(Scene([wall]), pair, Pose(np.zeros(3), Rotation.identity()), DIRECT)
    assert direct.mic.tolist() == [0]
    assert direct.rejected["hidden"] == 1


def test_it_counts_where_an_obstacle_is_at_that_time(phone):
    moving = Scene([_sheet(-1.0, (0.5, 0.0, 0.0))])
    trace_paths(moving, phone, LEVEL, DIRECT, time_s=0.0)
    trace_paths(moving, phone, LEVEL, DIRECT, time_s=4.0)
    with pytest.raises(ValueError, match="'sheet'"):
        trace_paths(moving, phone, LEVEL, DIRECT, time_s=2.0)


@pytest.mark.parametrize(
    "scene",
    [Scene([_sheet(-1.0, (2.03, 0.0, 0.0))]), Scene([_sheet(0.8)]), Scene([_ball(-1.0, 0.3, (1.9, 0.0, 0.0))])],
    ids=["driven through", "walked through", "ball runs into the phone"],
)
def test_a_walk_through_an_obstacle(phone, scene):
    """From one beep to the next the obstacle was before the phone, then behind it, and both echoed."""
    walk = StraightWalk([0.0, 0.0, 0.0], 0.0, 0.0 if scene.obstacles[0].moves else 1.3, 1.2)
    with pytest.raises(ValueError, match=f"'{scene.obstacles[0].name}'.* s"):
        render_walk(scene, phone, walk, BeepDesign(), DIRECT)


def test_between_two_beeps_a_thin_sheet_is_met_as_well(phone):
    """It is through all three transducers from one pose to the next: neither pose shows it."""
    walk = StraightWalk([0.0, 0.0, 0.0], 0.0, 0.0, 0.5)
    with pytest.raises(ValueError, match=r"got 'sheet' through .* between 0.\d+ and 0.\d+ s"):
        render_walk(Scene([_sheet(-1.2, (5.0, 0.0, 0.0))]), phone, walk, BeepDesign(), DIRECT)


def test_what_leaves_room_passes(box, phone):
    """In a hall wound inwards, a niche of a body that is not convex, on a face, and between two near walls."""
    hall = trimesh.creation.box((6.0, 6.0, 4.0))
    hall.invert()
    niche = trimesh.creation.annulus(0.5, 0.7, 2.0)
    scenes = [
        Scene([Obstacle(hall, Material.rigid(), "hall")]),
        Scene([Obstacle(niche, Material.rigid(), "niche")]),
        Scene([box((1.0, 4.0, 4.0), (0.57, 0.0, 0.0), "wall")]),  # microphone 0 lies on it
        Scene([box((1.0, 4.0, 4.0), (0.571, 0.0, 0.0), "ahead"), box((1.0, 4.0, 4.0), (-0.571, 0.0, 0.0), "behind")]),
    ]
    for scene in scenes:
        assert len(trace_paths(scene, phone, LEVEL, DIRECT)) == 2


def test_the_walkers_own_body_is_not_asked_about():
    """It goes with the phone, and presets hold theirs where they say."""
    phone = Phone.named("galaxy-s5")
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 1.0, 0.3)
    assert render_walk(Scene(()), phone, walk, BeepDesign(), DIRECT).samples.any()
    assert len(trace_paths(Scene(()), phone, Pose([0.0, 0.0, 1.3], Rotation.identity()), DIRECT))


@pytest.mark.parametrize("make", [trimesh.creation.box, trimesh.creation.icosphere])
def test_a_body_wound_inwards_is_no_room_for_who_is_outside(make, phone):
    """It returned no echo, or ended in an error about an array."""
    mesh = make().apply_translation([3.0, 0.0, 0.0])
    mesh.invert()
    with pytest.raises(ValueError, match=r"outside of 'bin' at pose 0 .* mesh.invert\(\)"):
        trace_paths(Scene([Obstacle(mesh, Material.rigid(), "bin")]), phone, LEVEL)


def _prism(plan_m: list[tuple[float, float]], caps: list[list[int]], height_m: float) -> trimesh.Trimesh:
    """An upright prism over a plan, counter-clockwise, whose caps are these triangles."""
    count = len(plan_m)
    vertices = [[*place, z] for z in (0.0, height_m) for place in plan_m]
    here, there = np.arange(count), np.roll(np.arange(count), -1)
    sides = [np.stack([here, there, there + count], 1), np.stack([here, there + count, here + count], 1)]
    faces = np.concatenate([*sides, np.array(caps)[:, ::-1], np.array(caps) + count])
    return trimesh.Trimesh(vertices, faces, process=False)


def test_outside_of_a_room_that_is_not_a_box(phone):
    """Cause: the room's bounding box was asked, and in the notch of an L nothing echoed."""
    plan_m = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0)]
    mesh = _prism(plan_m, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 3.0)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(36.0)
    mesh.invert()
    room = Scene([Obstacle(mesh, Material.rigid(), "room")])
    assert len(trace_paths(room, phone, Pose([1.0, 1.0, 1.3], held_rotation(0.0)))) > 2
    with pytest.raises(ValueError, match="the speaker outside of 'room'"):
        trace_paths(room, phone, Pose([3.0, 3.0, 1.3], held_rotation(0.0)))


def test_a_small_cone_far_away_is_no_room(phone):
    """Cause: its tip is opened, and the volume of an open mesh depends on where the origin is."""
    cone = trimesh.creation.cone(radius=0.005, height=0.01, sections=32).apply_translation([30.0, 0.0, 0.0])
    scene = Scene([Obstacle(cone, Material.rigid(), "cone")])
    assert len(trace_paths(scene, phone, Pose([29.0, 0.0, 0.0], held_rotation(0.0)), DIRECT)) == 2


def test_a_part_wound_inwards_is_named_and_a_hollow_is_none(phone):
    """Of a bench with its seat turned over the echo was missing without a word, 74 dB of one of -13 dB re 1 m."""
    seat, back = (
        trimesh.creation.box(bounds=[[2.0, -0.5, z], [2.0 + x, 0.5, z + 0.1]]) for z, x in ((0, 0.5), (0.3, 0.6))
    )
    seat.invert()
    mesh = trimesh.util.concatenate([seat, back])
    with pytest.raises(ValueError, match=r"outside of one of 'bench' at pose 0 .*fix_inversion"):
        trace_paths(Scene([Obstacle(mesh, Material.rigid(), "bench")]), phone, LEVEL)
    trimesh.repair.fix_inversion(mesh, multibody=True)
    assert trace_paths(Scene([Obstacle(mesh, Material.rigid(), "bench")]), phone, LEVEL).order.max() > 0
    hollow = trimesh.creation.icosphere(2, 0.3)
    hollow.invert()
    ball = trimesh.util.concatenate([trimesh.creation.icosphere(2, 0.5), hollow]).apply_translation([3.0, 0.0, 0.0])
    assert trace_paths(Scene([Obstacle(ball, Material.rigid(), "ball")]), phone, LEVEL).order.max() > 0


def test_a_walkers_body_wound_inwards_is_refused_too():
    """Its echo, -6 dB re 1 m, was missing without a word."""
    mesh = trimesh.creation.box(bounds=[[-0.6, -0.3, -1.2], [-0.3, 0.3, 0.5]])
    mesh.invert()
    phone = Phone.named("galaxy-s5").held_by(Obstacle(mesh, Material.rigid(), "walker"))
    with pytest.raises(ValueError, match=r"outside of 'walker' at pose 0"):
        trace_paths(Scene(()), phone, Pose([0.0, 0.0, 1.3], held_rotation(0.0)), DIRECT)
