"""Obstacle meshes: closed, outward, on the ground, smooth where the real thing is and sharp where it is not."""

import re
from typing import get_type_hints

import numpy as np
import pytest
import trimesh

from scenes.files.obstacle_kinds import KINDS
from scenes.obstacles import (
    CATEGORIES,
    a_frame,
    bench,
    board_on_posts,
    bollard,
    car,
    donation_box,
    dumpster,
    fence,
    ground,
    hedge,
    hydrant,
    kerb,
    lamp_post,
    litter_bin,
    person,
    pole_sign,
    random_obstacle,
    shop_front,
    tree,
    tub,
    walker_body,
    wall,
    wall_with_piers,
    wheeled_bin,
)
from scenes.obstacles.solids import box, cylinder, ellipsoid, rounded_rectangle

MESHES = {
    "wall": wall,
    "litter_bin": litter_bin,
    "domed_bin": lambda: litter_bin(taper=0.15, dome_m=0.15),
    "wheeled_bin": wheeled_bin,
    "dumpster": dumpster,
    "donation_box": donation_box,
    "sedan": lambda: car("sedan"),
    "suv": lambda: car("suv"),
    "van": lambda: car("van"),
    "round_sign": pole_sign,
    "square_sign": lambda: pole_sign(shape="square"),
    "a_frame": a_frame,
    "person": person,
    "standing_person": lambda: person(stride_rad=0.0),
    "bollard": bollard,
    "lamp_post": lamp_post,
    "tree": tree,
    "bench": bench,
    "wall_with_piers": wall_with_piers,
    "shop_front": shop_front,
    "octagon_sign": lambda: pole_sign(shape="octagon"),
    "triangle_sign": lambda: pole_sign(shape="triangle"),
    "board_on_posts": board_on_posts,
    "hydrant": hydrant,
    "tub": tub,
    "kerb": kerb,
    "fence": fence,
}
SMOOTH = ["litter_bin", "domed_bin", "sedan", "suv", "van", "person", "standing_person", "bollard", "hydrant"]


@pytest.mark.parametrize("name", MESHES)
def test_every_part_is_closed_and_faces_outwards(name: str) -> None:
    mesh = MESHES[name]()
    parts = mesh.split(only_watertight=False)
    assert len(parts) >= 1
    for part in parts:
        assert part.is_watertight
        assert part.is_winding_consistent
        assert part.volume > 0.0


@pytest.mark.parametrize("name", MESHES)
def test_stands_on_the_ground_over_the_origin(name: str) -> None:
    low, high = MESHES[name]().bounds
    assert low[2] == pytest.approx(0.0, abs=1e-12)
    # Boughs, chutes, wheels and a stride reach out on one side; the origin stays well inside the footprint.
    assert (low[:2] < 0.0).all()
    assert (high[:2] > 0.0).all()
    assert np.abs(low + high)[:2].max() < 0.4 * (high - low)[:2].max()


@pytest.mark.parametrize("name", MESHES)
def test_no_degenerate_triangles(name: str) -> None:
    mesh = MESHES[name]()
    assert mesh.area_faces.min() > 1e-7
    assert len(mesh.faces) <= 4000


@pytest.mark.parametrize("name", SMOOTH)
def test_dihedral_angles_are_either_smooth_or_sharp(name: str) -> None:
    """The simulator reads angles below 35 degrees as one smooth surface; nothing may lie near that boundary."""
    angle = np.rad2deg(MESHES[name]().face_adjacency_angles)
    smooth = angle[angle < 60.0]
    assert len(smooth) > 100
    assert smooth.max() < 34.0


def test_bin_vertices_lie_on_the_true_cone() -> None:
    mesh = litter_bin(radius_m=0.3, height_m=1.0, taper=0.2)
    radius = np.hypot(*mesh.vertices[:, :2].T)
    side = radius > 1e-9
    assert side.sum() == 7 * 48
    expected = 0.3 * (1.0 - 0.2 * (1.0 - mesh.vertices[side, 2]))
    np.testing.assert_allclose(radius[side], expected, atol=1e-12)


def test_dome_vertices_lie_on_the_true_ellipsoid() -> None:
    mesh = litter_bin(radius_m=0.3, height_m=0.9, dome_m=0.12)
    lid = mesh.vertices[mesh.vertices[:, 2] > 0.9]
    assert len(lid) > 100
    value = (lid[:, :2] ** 2).sum(axis=1) / 0.3**2 + ((lid[:, 2] - 0.9) / 0.12) ** 2
    np.testing.assert_allclose(value, 1.0, atol=1e-12)


def test_volumes_converge_to_the_smooth_bodies() -> None:
    """An inscribed polygon of n sides has sin(2 pi / n) n / (2 pi) of the circle's area: 0.29 % less at 48."""
    assert cylinder(0.25, 0.9).volume == pytest.approx(np.pi * 0.25**2 * 0.9, rel=0.003)
    assert ellipsoid([0, 0, 0], [0.1, 0.2, 0.3], 96, 96).volume == pytest.approx(4 / 3 * np.pi * 0.006, rel=0.003)
    assert box([1.0, 2.0, 3.0]).volume == pytest.approx(6.0, rel=1e-12)


def test_a_rounded_rectangle_keeps_its_size_and_turns_once() -> None:
    outline = rounded_rectangle([2.0, 1.0], 0.2, corner_segments=6)
    np.testing.assert_allclose(np.ptp(outline, axis=0), [2.0, 1.0], atol=1e-12)
    ahead = np.roll(outline, -1, axis=0)
    area = 0.5 * np.sum(outline[:, 0] * ahead[:, 1] - ahead[:, 0] * outline[:, 1])
    assert area == pytest.approx(2.0 - (4.0 - np.pi) * 0.04, rel=0.002)


def test_a_hedge_is_leaves_within_its_box() -> None:
    mesh = hedge(1.2, 1.0, 0.5)
    assert len(mesh.faces) > 80
    np.testing.assert_allclose(mesh.area_faces, 0.5 * 0.08**2, rtol=1e-9)
    slack = 0.08 / np.sqrt(2.0) - 0.04
    assert (np.abs(mesh.bounds[:, :2]) <= np.array([0.25, 0.6]) + slack).all()
    assert mesh.bounds[0, 2] >= -slack
    assert mesh.bounds[1, 2] <= 1.0 + slack
    quads = mesh.face_normals.reshape(-1, 2, 3)
    np.testing.assert_allclose(quads[:, 0], quads[:, 1], atol=1e-9)


def test_a_shop_front_shows_panes_behind_its_frame() -> None:
    """Of the front, plinth, lintel and mullions lie in one plane, the panes 6 cm behind it."""
    mesh = shop_front(6.0, 2.8, pane_m=1.5, setback_m=0.06)
    facing = mesh.face_normals[:, 0] < -0.99
    place, area = mesh.triangles_center[facing, 0], mesh.area_faces[facing]
    assert set(np.round(place, 9)) == {-0.1, -0.04}
    assert mesh.bounds[1, 0] == pytest.approx(0.1)
    assert area[place < -0.05].sum() == pytest.approx(6.0 * 0.65 + 5 * 0.06 * 2.15)


@pytest.mark.parametrize("stature", [1.5, 1.75, 1.95])
def test_a_person_has_human_measures(stature: float) -> None:
    mesh = person(stature)
    depth, breadth, height = mesh.extents
    assert height == pytest.approx(stature, rel=1e-3)
    assert 0.25 * stature < breadth < 0.36 * stature
    assert depth < 0.5 * stature
    # About 1 kg per litre: the overlapping parts hold 45-75 kg for 1.5-1.95 m, at 985 kg/m3 and without clothes.
    assert 0.045 < mesh.volume < 0.13


def test_the_walker_stands_behind_the_phone_and_off_the_ground() -> None:
    body = walker_body(phone_distance_m=0.35, phone_height_m=1.3)
    low, high = body.mesh.bounds
    assert high[0] == pytest.approx(-0.35, abs=0.003)
    assert low[2] > -1.3 + 0.03
    assert high[2] == pytest.approx(1.75 - 1.3, abs=0.01)
    assert abs(low[1] + high[1]) < 1e-9


@pytest.mark.parametrize("category", sorted(CATEGORIES))
def test_random_obstacles_vary_repeat_and_carry_their_category(category: str) -> None:
    made = [random_obstacle(category, np.random.default_rng(seed), "thing") for seed in (1, 1, 2)]
    expected = category
    assert {obstacle.category for obstacle in made} == {expected}
    np.testing.assert_array_equal(made[0].mesh.vertices, made[1].mesh.vertices)
    assert made[0].mesh.vertices.shape != made[2].mesh.vertices.shape or not np.allclose(
        made[0].mesh.vertices, made[2].mesh.vertices
    )


def made_or_refused(make, given: dict):
    try:
        return make(**given), ""
    except ValueError as error:
        return None, str(error)


@pytest.mark.parametrize("name", sorted(KINDS))
@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 1e-300, 1e-9, 1e-3, 0.05, 0.11, 0.3, 30.0, 1e9, "a", None])
def test_an_absurd_measure_is_refused_or_makes_a_sound_mesh(name: str, value) -> None:
    """Sizes below those of fixed parts made solids inside out or below the ground, tiny spacings took all memory."""
    make = KINDS[name].mesh
    lengths = [key for key, kind in get_type_hints(make).items() if key.endswith("_m") and kind is float]
    given = {"box": {"size_m": [1.0, 1.0, 1.0]}, "cylinder": {"radius_m": 0.2, "height_m": 1.0}}.get(name, {})
    for key in lengths:
        mesh, said = made_or_refused(make, {**given, key: value})
        if mesh is None:
            assert re.search("must .*, got ", said)
            continue
        assert np.isfinite(mesh.vertices).all()
        assert mesh.area_faces.min() > 0.0
        assert len(mesh.faces) < 200_000
        if name != "hedge":  # leaves are open, and reach out of their box by half a diagonal
            assert mesh.volume > 0.0
            assert mesh.bounds[0, 2] > -1e-9


def test_the_ground_is_a_flat_patch_facing_up() -> None:
    mesh = ground((20.0, 10.0))
    assert isinstance(mesh, trimesh.Trimesh)
    assert mesh.area == pytest.approx(200.0)
    np.testing.assert_array_equal(mesh.face_normals, [[0.0, 0.0, 1.0]] * 2)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: wall(length_m=-1.0), "must be positive, got -1.0"),
        (lambda: litter_bin(radius_m=0.0), "radius_m must be positive, got 0.0"),
        (lambda: litter_bin(taper=1.0), "taper must be at least 0 and below 1, got 1.0"),
        (lambda: car("tank"), "style must be one of"),
        (lambda: pole_sign(center_height_m=0.2), "center_height_m must be above half the board"),
        (lambda: person(stature_m=9.0), "stature_m must lie between 1.0 and 2.3, got 9.0"),
        (lambda: walker_body(phone_distance_m=-0.1), "phone_distance_m must be positive, got -0.1"),
        (lambda: random_obstacle("dragon", np.random.default_rng(0), "x"), "category must be one of"),
        (lambda: dumpster(height_m=0.13), "height_m must be at least 0.25 m, for its feet, got 0.13"),
        (lambda: wheeled_bin(height_m=0.01), "height_m must be at least 0.25 m, for its wheels, got 0.01"),
        (lambda: wheeled_bin(width_m=0.1), "width_m must be at least 0.2 m, for rounded corners, got 0.1"),
        (lambda: fence(height_m=0.11), "height_m must be at least 0.2 m, for its two rails, got 0.11"),
        (lambda: fence(spacing_m=1e-3), "spacing_m must be at least 0.1 m, the width of one post, got 0.001"),
        (lambda: fence(spacing_m=1e-9), "spacing_m must lie within 0.0001 to 1000 m, got 1e-09"),
        (lambda: fence(length_m=1e6), r"length_m must lie within 0.0001 to 1000 m, got 1e\+06"),
        (lambda: wall_with_piers(spacing_m=0.1), "spacing_m must be at least 0.4 m, the width of one post, got 0.1"),
        (lambda: shop_front(pane_m=0.01), "pane_m must be at least 0.06 m, the width of one post, got 0.01"),
        (lambda: shop_front(height_m=0.6), "height_m must be at least 0.7 m, for plinth and lintel, got 0.6"),
        (lambda: hedge(height_m=0.05), "height_m must be at least 0.08 m, the side of a leaf, got 0.05"),
        (lambda: hedge(1000.0, 1000.0), "at most 100000 leaves, 15 a m2, got 1000 x 1000 x 0.5 m"),
        (lambda: tree(fork_m=0.05), "fork_m must be at least 0.5 m, for its root flare, got 0.05"),
        (lambda: litter_bin(dome_m=np.nan), "dome_m must be positive, got nan"),
        (lambda: car(scale=np.inf), "scale must lie within 0.01 to 100, got inf"),
        (lambda: car(["van"]), r"style must be one of .*, got \['van'\]"),
        (lambda: bollard(height_m=np.inf), "height_m must be positive, got inf"),
        (lambda: lamp_post("thin"), "radius_m must be a number, got 'thin'"),
        (lambda: person(arms="no"), "arms must be of type bool, got 'no'"),
        (lambda: walker_body(girth=0.0), "girth must lie between 0.5 and 2.0, got 0.0"),
        (lambda: box(1.0), "size_m must be three numbers, got 1.0"),
        (lambda: box([1.0, 2.0]), r"size_m must be three numbers, got \[1.0, 2.0\]"),
        (lambda: box([1.0, 1.0, 1.0], 2.0), "center_m must be three numbers, got 2.0"),
        (lambda: cylinder(0.2, 1.0, segments=2), "segments must be a whole number, 3 or more, got 2"),
        (lambda: cylinder(0.2, 1.0, rows=0), "rows must be a whole number, 1 or more, got 0"),
        (lambda: cylinder(0.2, 1.0, segments=10**9), "segments must be at most 1000, got 1000000000"),
    ],
)
def test_bad_measures_are_refused_by_name(make, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
