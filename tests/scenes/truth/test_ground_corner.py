"""Where an obstacle and the ground make a corner, against dense sampling, mirror images and what is to be expected."""

from itertools import product

import numpy as np
import pytest
import trimesh

from scenes import ground_truth
from scenes.obstacles import a_frame, ground, hydrant, litter_bin, pedestrian, wheeled_bin
from scenes.truth.ground_corner import corner_points
from scenes.truth.nearest import facing
from scenes.walks.gait_walk import GaitWalk
from simulator import Material, Obstacle, Phone, Scene, StraightWalk

PHONE_M = np.array([0.0, 0.0, 1.3])
MIRROR = np.array([1.0, 1.0, -1.0])
STEPS = np.stack(np.meshgrid(np.arange(41), np.arange(41)), axis=-1).reshape(-1, 2) / 40.0
SHARES = np.column_stack([STEPS, 1.0 - STEPS.sum(axis=1)])[STEPS.sum(axis=1) <= 1.0]
"""Corners, edges and inside of a triangle, evenly."""
BOX = trimesh.creation.box(bounds=[[1.75, -0.25, 0.0], [2.25, 0.25, 1.0]])


def way(point_m, from_m):
    return np.linalg.norm(point_m - from_m, axis=-1) + np.linalg.norm(point_m - from_m * MIRROR, axis=-1)


def leaning_face(foot_m, lean_rad):
    """A rectangle 2 m wide and 1.2 m high whose foot is ahead; it leans towards the phone."""
    up = np.array([-np.sin(lean_rad), 0.0, np.cos(lean_rad)]) * 1.2
    low = np.array([[foot_m, 1.0, 0.0], [foot_m, -1.0, 0.0]])
    return trimesh.Trimesh(np.concatenate([low, low + up]), [[0, 1, 2], [1, 3, 2]], process=False)


@pytest.mark.parametrize("lean", [0.0, 0.05, 0.12])
def test_a_leaning_face_is_touched_where_its_mirror_image_says(lean):
    """Phone, its image in the ground, and that one's image in the face: a straight line, in the plane y = 0."""
    point = corner_points(leaning_face(2.0, lean), PHONE_M)[0]
    normal = np.array([-np.cos(lean), 0.0, -np.sin(lean)])
    image = PHONE_M * MIRROR
    image = image - 2.0 * ((image - [2.0, 0.0, 0.0]) @ normal) * normal
    assert way(point, PHONE_M) == pytest.approx(np.linalg.norm(image - PHONE_M), abs=1e-12)
    assert point[2] == pytest.approx(0.0, abs=1e-12) if lean == 0.0 else point[2] > 0.05


def test_no_point_of_a_dense_sample_is_nearer():
    rng = np.random.default_rng(4)
    for _ in range(20):
        mesh = trimesh.convex.convex_hull(rng.normal(size=(12, 3)) * [0.3, 0.3, 0.5] + [2.5, rng.uniform(-1, 1), 0.8])
        query = rng.uniform([-0.5, -0.5, 0.8], [0.5, 0.5, 1.7])
        point = corner_points(mesh, query)
        sampled = way(np.einsum("kb,fbx->fkx", SHARES, mesh.triangles), query).min()
        assert way(point[0], query) <= sampled + 1e-12
        assert way(point[0], query) == pytest.approx(sampled, abs=1e-3)  # samples are 3 cm apart, and the least is flat
        assert trimesh.proximity.closest_point(mesh, point)[1][0] < 1e-9


def test_a_side_faces_and_a_rim_does_not():
    places = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 1.3], [0.0, 1.5, 0.5]])  # square, over the rim, past an edge
    assert facing(BOX, places, np.deg2rad(25.0)).tolist() == [True, False, False]
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.3)
    assert facing(ball, np.random.default_rng(1).normal(size=(50, 3)) + [3.0, 0.0, 0.0], np.deg2rad(25.0)).all()


def test_which_echo_is_to_be_heard_first():
    """Off a low box by way of the ground, off a leaning board that is met square directly, off a wall directly."""
    phone, walk = Phone.named("ideal"), StraightWalk(PHONE_M, 0.0, 0.0, 1.0)
    things = {
        "box": BOX,
        "board": leaning_face(2.6, -0.5 * np.arctan(1.3 / 2.6)),  # leans away: its normal points up to the phone
        "wall": trimesh.creation.box(bounds=[[3.9, -2.0, 0.0], [4.1, 2.0, 3.0]]),
    }
    obstacles = [Obstacle(mesh, Material.rigid(), name) for name, mesh in things.items()]
    scene = Scene([Obstacle(ground(), Material.rigid(), "ground", category="ground"), *obstacles])
    truth = {name: ground_truth(scene, walk, phone, [0.0], target=name) for name in things}
    assert {name: bool(found.by_ground[0]) for name, found in truth.items()} == {
        "box": True, "board": False, "wall": False,
    }  # fmt: skip
    ahead_m = 0.5 * (phone.geometry.speaker_m + phone.geometry.mics_m[0])[1]
    assert truth["box"].ground_range_m[0] == pytest.approx(np.hypot(1.75 - ahead_m, 1.3), abs=1e-9)


def heard_by_ground(mesh, away_m=3.0):
    """Whether a thing's corner is heard first by a phone so far before it, at six turns of it."""
    phone, walk = Phone.named("ideal"), StraightWalk(PHONE_M, 0.0, 0.0, 1.0)
    found = []
    for yaw in np.linspace(0.0, np.pi, 6):
        turned = mesh.copy()
        turned.apply_transform(trimesh.transformations.rotation_matrix(yaw, [0.0, 0.0, 1.0]))
        turned.apply_translation([away_m - turned.bounds[0, 0], 0.0, 0.0])
        scene = Scene([Obstacle(turned, Material.rigid(), "thing")])
        found.append(bool(ground_truth(scene, walk, phone, [0.0]).by_ground[0]))
    return found


@pytest.mark.parametrize("make", [litter_bin, wheeled_bin, hydrant])
def test_what_stands_upright_below_the_phone_is_heard_by_its_corner(make):
    """Of a wheeled bin too, whose body begins above its wheels."""
    assert any(heard_by_ground(make()))


@pytest.mark.parametrize("pose", ["stand", "read", "walk-0", "walk-15", "walk-30"])
def test_people_are_heard_where_they_are_nearest(pose):
    """Hands and shoes are coarse meshes of rounded things. Their facets once passed for rims, and the truth was the way
    by the ground, up to 70 cm behind the hand that is met first. Now and then a shin is upright."""
    for sex, build in product(("female", "male"), ("slim", "average", "heavy")):
        assert np.mean(heard_by_ground(pedestrian(1.7, sex, build, pose))) <= 1 / 6, (sex, build)


def test_a_board_that_leans_back_is_heard_where_it_is_nearest():
    """A corner of 105 degrees sends nothing back to where it came from."""
    assert not heard_by_ground(a_frame())[0]


@pytest.mark.parametrize("top_m", [1.26, 1.28, 1.30, 1.32])
def test_the_bob_of_the_gait_does_not_switch_between_the_two_echoes(top_m):
    """A box about as high as the phone bobs over and under; the truth once told another range every few beeps."""
    box = trimesh.creation.box(bounds=[[6.0, -0.25, 0.0], [6.5, 0.25, top_m]])
    scene = Scene([Obstacle(box, Material.rigid(), "box")])
    walk = GaitWalk([0.0, 0.0, 1.3], speed_m_s=1.3, duration_s=4.0)
    truth = ground_truth(scene, walk, Phone.named("galaxy-s8-plus"), np.arange(0.0, 4.0, 0.09), target="box")
    assert np.ptp(walk.pose(truth.time_s).position_m[:, 2]) > 0.02
    assert np.count_nonzero(np.diff(truth.by_ground.astype(int))) <= 1
