"""Planar paths among boxes against exact rational images: corners, edges, points at exactly equal height."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from tests.references.exact_images import Box, ImagePath, image_paths

UNIT = 2.0**-16  # m; all coordinates are multiples, so floats hold them exactly
M = 2**16
CM = 655  # units in a centimetre


def _boxes_in_m(boxes: list[tuple[tuple[int, ...], tuple[int, ...]]]) -> list[Box]:
    return [(tuple(Fraction(x, M) for x in low), tuple(Fraction(x, M) for x in high)) for low, high in boxes]


def _point(units: tuple[int, ...]) -> tuple[Fraction, ...]:
    return tuple(Fraction(x, M) for x in units)


def _traced(boxes, source, mics, max_order):
    """Paths of order 1 on at both microphones."""
    obstacles = []
    for i, (low, high) in enumerate(boxes):
        low, high = np.array(low) * UNIT, np.array(high) * UNIT
        mesh = trimesh.creation.box(high - low, trimesh.transformations.translation_matrix(0.5 * (low + high)))
        obstacles.append(Obstacle(mesh, Material.rigid(), f"box {i}"))
    phone = Phone.ideal(np.zeros(3), (np.array(mics) - source) * UNIT)
    paths = trace_paths(
        Scene(obstacles, Air.lossless(1.0)), phone, Pose(np.array(source) * UNIT, Rotation.identity()),
        Fidelity(max_order=max_order, max_range_m=500.0, mechanisms=("specular",)),
    )  # fmt: skip
    return paths[paths.order > 0]


def _agree(boxes, source, mics, max_order) -> list[ImagePath]:
    """Assert that both searches find the same paths; returns the exact ones of both microphones."""
    paths, every = _traced(boxes, source, mics, max_order), []
    for mic, receiver in enumerate(mics):
        expected = image_paths(_boxes_in_m(boxes), _point(source), _point(receiver), max_order)
        every += expected
        ours = paths[paths.mic == mic]
        left = list(range(len(ours)))
        for exact in expected:
            way = np.array(exact.image, dtype=float) - np.array(receiver) * UNIT
            length = np.linalg.norm(way)
            match = [k for k in left if ours.order[k] == exact.order and _same(ours, k, exact, length)]
            assert match or exact.grazes, f"missing at {mic}: {_told(exact)}"
            left = [k for k in left if k not in match[:1]]
        assert not left, f"spurious at {mic}: {[ours.points_m[k].tolist() for k in left]}"
    return every


def _same(ours, k: int, exact: ImagePath, length: float) -> bool:
    points = np.array(exact.points, dtype=float)
    return abs(ours.delay_s[k] - length) < 1e-12 * length + 1e-14 and np.allclose(
        np.sort(ours.points_m[k, : exact.order + 2], axis=0), np.sort(points, axis=0), atol=1e-9
    )


def _told(path: ImagePath) -> str:
    return f"order {path.order} by {[tuple(float(x) for x in point) for point in path.points]}"


@st.composite
def _near_edges(draw):
    """Ground, a wall, a wall square to it, a free box; borders within 2 cm of the mirror points, or right on them."""
    near = st.one_of(st.just(0), st.integers(-2 * CM, 2 * CM), st.sampled_from([-1, 1, -4, 4, -30, 30]))
    height = draw(st.integers(30 * CM, 150 * CM))
    source = (0, 0, height)
    mics = []
    for side in (-1, 1):
        level = 0 if draw(st.booleans()) else draw(st.integers(-10 * CM, 10 * CM))
        across = side * draw(st.integers(CM, 15 * CM))
        ahead = 0 if draw(st.booleans()) else draw(st.integers(-15 * CM, 15 * CM))
        mics.append((ahead, across, height + level))
    wall = draw(st.integers(40 * CM, 250 * CM))
    mirror = mics[0][1] // 2, (height + mics[0][2]) // 2  # where the wall is met when both are equally far from it
    sides = [mirror[0] - draw(st.integers(20 * CM, 200 * CM)), mirror[0] + draw(st.integers(20 * CM, 200 * CM))]
    top = height + draw(st.integers(20 * CM, 100 * CM))
    cut = draw(st.sampled_from(["left", "right", "top", "none"]))
    if cut in ("left", "right"):
        sides[cut == "right"] = mirror[0] + draw(near)
    elif cut == "top":
        top = max(mirror[1] + draw(near), CM)
    boxes = [((-8 * M, -8 * M, -M // 4), (8 * M, 8 * M, 0))]
    if sides[0] < sides[1]:
        boxes.append(((wall, sides[0], 0), (wall + 10 * CM, sides[1], top)))
    if draw(st.booleans()):  # an inner corner with the first wall
        start = max(wall - draw(st.integers(5 * CM, 200 * CM)), 25 * CM)
        boxes.append(((start, sides[1], 0), (wall + 10 * CM, sides[1] + 9 * CM, top)))
    if draw(st.booleans()):
        low = (draw(st.integers(25 * CM, 35 * CM)), draw(st.integers(-80 * CM, 60 * CM)), 0)
        size = [draw(st.integers(3 * CM, 60 * CM)) for _ in range(3)]
        boxes.append((low, tuple(a + b for a, b in zip(low, size, strict=True))))
    return boxes, source, mics


@settings(max_examples=60, deadline=None)
@given(_near_edges())
def test_orders_one_and_two_near_corners_and_edges(case):
    _agree(*case, 2)


@settings(max_examples=30, deadline=None)
@given(_near_edges())
def test_orders_one_to_three_near_corners_and_edges(case):
    _agree(*case, 3)


@pytest.mark.slow
@settings(max_examples=400, deadline=None)
@given(_near_edges())
def test_many_scenes_to_order_three(case):
    _agree(*case, 3)


def _room_corner(reach: int) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Ground and two walls that meet in the origin."""
    thick = M // 8
    return [
        ((-thick, -thick, -thick), (reach, reach, 0)),
        ((-thick, -thick, 0), (0, reach, reach)),
        ((0, -thick, 0), (reach, 0, reach)),
    ]


def test_path_into_the_corner_of_three_faces_counts_once():
    # speaker and microphones on one line through the corner: all six orders of the three faces share one image
    source = (60 * CM, 48 * CM, 36 * CM)
    mics = [(50 * CM, 40 * CM, 30 * CM), (70 * CM, 56 * CM, 42 * CM)]
    exact = _agree(_room_corner(3 * M), source, mics, 3)
    assert sorted(path.order for path in exact) == [1] * 6 + [2] * 6 + [3] * 2


@pytest.mark.parametrize("gap", [1, 4, 30, 300, 2 * CM])
def test_corner_closer_to_the_mirror_point_than_any_tolerance(gap):
    # the wall ends `gap` short of the mirror point, on it, `gap` beyond it
    source, mics = (0, 0, 90 * CM), [(0, 10 * CM, 90 * CM), (0, -10 * CM, 90 * CM)]
    ground = ((-8 * M, -8 * M, -M // 4), (8 * M, 8 * M, 0))
    counts = []
    for side in (5 * CM - gap, 5 * CM, 5 * CM + gap):
        wall = ((90 * CM, -M, 0), (M, side, 2 * M))
        exact = _agree([ground, wall], source, mics, 2)
        counts.append(sum(path.order == 1 for path in exact))
    assert counts == [3, 4, 4]  # two over the ground, and one or two off the wall


@pytest.mark.parametrize("gap_m", [0.0, 1e-10, 1e-9, 1e-7, 1e-4, 1.9e-3])
def test_a_wall_that_ends_just_above_the_ground_makes_a_corner_with_it(gap_m):
    """Cause: right in the corner of a wall and the ground, where a level phone has its echo off both, neither patch was
    met, and no edge counts where faces touch: -71 dB of the image's."""
    ground = trimesh.creation.box(bounds=[[-9.0, -9.0, -0.5], [9.0, 9.0, 0.0]])
    wall = trimesh.creation.box(bounds=[[1.5, -4.0, gap_m], [1.7, 4.0, 2.0]])
    scene = Scene([Obstacle(ground, Material.rigid(), "ground"), Obstacle(wall, Material.rigid(), "wall")])
    pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.5 * np.pi))
    paths = trace_paths(scene, Phone.named("ideal"), pose)
    corner = paths[(paths.kind == "specular") & (paths.order == 2)]
    assert sorted(corner.mic[corner.obstacle == corner.obstacle[0]]) == [0, 1]
    np.testing.assert_allclose(corner.delay_s * 343.0, 2.0 * np.hypot(1.5, 1.3), atol=0.02)


@pytest.mark.parametrize("gap_m", [1e-9, 1e-3])
@pytest.mark.parametrize("side", [0, 1])
def test_walls_of_two_obstacles_make_a_corner_whichever_of_them_ends_before_the_other(gap_m, side):
    short = [gap_m if side == k else 0.0 for k in range(2)]
    one = trimesh.creation.box(bounds=[[1.5, -4.0, -3.0], [1.7, 1.0 - short[0], 3.0]])
    other = trimesh.creation.box(bounds=[[-4.0, 1.0, -3.0], [1.5 - short[1], 1.2, 3.0]])
    scene = Scene([Obstacle(one, Material.rigid(), "one"), Obstacle(other, Material.rigid(), "other")])
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.0, 0.07], [0.0, 0.0, -0.07]])
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], held_rotation(heading_rad=0.0)))
    corner = paths[(paths.kind == "specular") & (paths.order == 2)]
    assert sorted(corner.mic) == [0, 1]
    np.testing.assert_allclose(corner.delay_s * 343.0, 2.0 * np.hypot(1.5, 1.0), atol=0.01)


def test_walls_of_triangles_that_are_no_plane_make_corners_as_flat_ones_do():
    """Cause: a triangle's segments run either way, and of its corners one was not asked which patches it faces: a room
    whose vertices are off by 0.1 mm had lost 16 of 56 paths, the echoes of its upright corners among them."""
    room = trimesh.creation.box(bounds=[[-2.0, -2.0, 0.0], [3.0, 2.5, 2.6]])
    room.invert()
    bent = room.copy()
    bent.vertices = bent.vertices + np.random.default_rng(0).normal(scale=1e-4, size=bent.vertices.shape)
    phone = Phone.ideal([0.0, 0.05, 0.01], [[0.01, 0.07, 0.0], [-0.01, -0.07, 0.0]])
    pose = Pose([0.13, 0.21, 1.32], held_rotation(heading_rad=0.3))
    flat, bent = (
        trace_paths(Scene([Obstacle(mesh, Material.rigid(), "room")], Air.lossless(343.0)), phone, pose)
        for mesh in (room, bent)
    )
    flat, bent = (paths[(paths.kind == "specular") & (paths.mic == 0)] for paths in (flat, bent))
    apart_m = np.linalg.norm(np.diff(flat.points_m[:, 1:4], axis=1), axis=2)
    clear = np.all((apart_m > 5e-3) | (np.arange(2) >= flat.order[:, None] - 1), axis=1)  # no two points in one corner
    assert clear.sum() > 50
    assert max(np.abs(bent.delay_s - delay_s).min() for delay_s in flat.delay_s[clear]) < 2.5e-3 / 343.0
