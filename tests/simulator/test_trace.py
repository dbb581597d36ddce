"""Planar paths against images computed by hand, limits and symmetries, and an exhaustive search."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.phone.transducers import Transducer
from simulator.scene.scene import with_area

C = 343.0
MIRRORS = Fidelity(mechanisms=("specular", "curved"))
SAMPLE_S = 1.0 / 192_000.0


def test_wall_three_metres_ahead_gives_the_hand_computed_delays(box, phone):
    # level phone at the origin, top edge forwards: speaker at x = 0.05, microphones at 0.07 and -0.07, wall at 3
    scene = Scene([box((0.2, 8.0, 4.0), (3.1, 0.0, 0.0), "wall")], Air.lossless(C))
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), MIRRORS)
    echo = paths[paths.order == 1]
    np.testing.assert_array_equal(echo.mic, [0, 1])
    np.testing.assert_allclose(echo.delay_s, np.array([2.95 + 2.93, 2.95 + 3.07]) / C, atol=1e-3 * SAMPLE_S)
    np.testing.assert_allclose(echo.gain, [1 / 5.88, 1 / 6.02], rtol=1e-12)
    assert echo.obstacle.tolist() == ["wall", "wall"]
    assert echo.kind.tolist() == ["specular", "specular"]


def test_transfer_function_is_the_sum_of_images(box, phone):
    scene = Scene([box((0.2, 8.0, 4.0), (3.1, 0.0, 0.0), "wall")], Air.lossless(C))
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), MIRRORS)
    f = np.array([18_000.0, 20_500.0, 23_000.0])
    expected = [
        sum(np.exp(-2j * np.pi * f * length / C) / length for length in lengths)
        for lengths in ((0.02, 5.88), (0.12, 6.02))
    ]
    np.testing.assert_allclose(paths.transfer_function(f), expected, rtol=1e-11)


def test_one_wall_of_many_triangles_gives_one_echo(phone):
    mesh = trimesh.creation.box((0.2, 8.0, 4.0), trimesh.transformations.translation_matrix((3.1, 0.0, 0.0)))
    for _ in range(4):
        mesh = mesh.subdivide()
    paths = trace_paths(
        Scene([Obstacle(mesh, Material.rigid(), "wall")]), phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), MIRRORS
    )
    assert (paths.order == 1).sum() == 2


def test_source_and_microphones_at_equal_height_meet_the_corner_once(box):
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.05, 0.0, 0.0], [-0.05, 0.0, 0.0]])
    wall = box((0.2, 8.0, 3.0), (3.1, 0.0, 1.5), "wall")
    ground = box((30.0, 30.0, 0.2), (0.0, 0.0, -0.1), "ground")
    pose = Pose([0.0, 0.0, 1.3], held_rotation(0.0))
    paths = trace_paths(Scene([wall, ground], Air.lossless(C)), phone, pose, MIRRORS)
    corner = paths[paths.order == 2]
    assert len(corner) == 2  # one a microphone, not one an order of reflection
    np.testing.assert_allclose(corner.delay_s * C, np.sqrt(6.0**2 + 2.6**2 + 0.05**2), rtol=1e-12)


def test_wall_behind_a_wall_is_hidden_and_counted(box, phone):
    near = box((0.2, 8.0, 4.0), (2.1, 0.0, 0.0), "near")
    far = box((0.2, 8.0, 4.0), (4.1, 0.0, 0.0), "far")
    once = Fidelity(max_order=1, mechanisms=("specular",))
    paths = trace_paths(Scene([near, far]), phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), once)
    assert set(paths.obstacle[paths.order == 1]) == {"near"}
    assert paths.rejected["hidden"] == 2
    assert "hidden: 2" in paths.explain()


def test_reciprocity_of_speaker_and_microphone(box, cylinder):
    scene = Scene(
        [
            box((0.2, 6.0, 3.0), (3.1, 0.4, 1.5), "wall"),
            box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground"),
            cylinder(0.3, 2.0, (1.8, -0.9, 1.0), 32),
        ]
    )
    pose = Pose([0.0, 0.0, 1.2], held_rotation(0.1, 0.3))
    f = np.linspace(18_000.0, 23_000.0, 7)
    speaker, mic, other = [0.02, 0.05, 0.0], [0.0, -0.07, 0.01], [0.0, 0.07, 0.0]
    there = trace_paths(scene, Phone.ideal(speaker, [mic, other]), pose)
    back = trace_paths(scene, Phone.ideal(mic, [speaker, other]), pose)
    assert (there.order[there.mic == 0] > 0).sum() >= 5
    np.testing.assert_allclose(there.transfer_function(f)[0], back.transfer_function(f)[0], rtol=1e-9)


@settings(max_examples=15, deadline=None)
@given(
    shift=st.tuples(*[st.floats(-1e6, 1e6)] * 3),
    angles=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_rigid_motion_of_everything_changes_nothing(shift, angles):
    turn = Rotation.from_euler("ZYX", angles)
    phone = Phone.ideal([0.0, 0.05, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    frequency = np.linspace(18_000.0, 23_000.0, 5)
    here, there = _street(np.zeros(3), Rotation.identity()), _street(np.array(shift), turn)
    results = []
    for scene, offset, rotation in ((here, np.zeros(3), Rotation.identity()), (there, np.array(shift), turn)):
        pose = Pose(rotation.apply([0.1, 0.2, 1.3]) + offset, rotation * held_rotation(0.2, 0.4))
        results.append(trace_paths(scene, phone, pose, Fidelity(tolerance_db=np.inf)))
    assert (results[0].order > 0).sum() >= 6
    np.testing.assert_array_equal(results[0].obstacle, results[1].obstacle)
    first, second = (paths.transfer_function(frequency) for paths in results)
    # coordinates of 1e6 m carry 1e-10 m of rounding: 4e-8 rad of phase a coordinate at 20 kHz
    np.testing.assert_allclose(first, second, rtol=1e-6, atol=1e-6 * np.abs(first).max())


def _street(shift: np.ndarray, turn: Rotation) -> Scene:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn.as_matrix(), shift

    def placed(mesh: trimesh.Trimesh, name: str) -> Obstacle:
        return Obstacle(
            trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).apply_transform(matrix), Material.rigid(), name
        )

    move = trimesh.transformations.translation_matrix
    return Scene(
        [
            placed(trimesh.creation.box((20.0, 20.0, 0.2), move((0.0, 0.0, -0.1))), "ground"),
            placed(trimesh.creation.box((0.2, 6.0, 3.0), move((3.1, 0.4, 1.5))), "wall"),
            placed(trimesh.creation.cylinder(0.3, 2.0, sections=32, transform=move((1.8, -0.9, 1.0))), "post"),
        ],
        Air.lossless(C),
    )


def _exhaustive(normals, offsets, inside, blocked, source, receiver, max_order, limit):
    """Every image path by brute force: all sequences of half-spaces' planes, all legs tested against all boxes."""
    found = []
    for order in range(1, max_order + 1):
        for sequence in itertools.product(range(len(offsets)), repeat=order):
            images = [source]
            for p in sequence:
                images.append(images[-1] - 2 * (images[-1] @ normals[p] - offsets[p]) * normals[p])
            if np.linalg.norm(images[-1] - receiver) > limit:
                continue
            points, ok = [receiver], True
            for k in range(order, 0, -1):
                n, d = normals[sequence[k - 1]], offsets[sequence[k - 1]]
                here, there = points[-1] @ n - d, images[k] @ n - d
                if not (here > 1e-12 and there < 0):
                    ok = False
                    break
                points.append(points[-1] + here / (here - there) * (images[k] - points[-1]))
                if not inside(sequence[k - 1], points[-1]):
                    ok = False
                    break
            if not ok:
                continue
            points.append(source)
            if any(blocked(a, b) for a, b in itertools.pairwise(points)):
                continue
            found.append(np.linalg.norm(images[-1] - receiver))
    return np.sort(found)


@pytest.mark.parametrize("seed", range(6))
def test_paths_are_those_of_an_exhaustive_search(seed, box):
    rng = np.random.default_rng(seed)
    bounds = [(np.array([-6.0, -6.0, -0.2]), np.array([6.0, 6.0, 0.0]))]
    for _ in range(3):
        low = np.array([rng.uniform(0.8, 2.5), rng.uniform(-2.0, 1.0), 0.0])
        bounds.append((low, low + rng.uniform(0.3, 1.5, 3)))
    obstacles = [box(tuple(high - low), tuple((low + high) / 2), f"box{i}") for i, (low, high) in enumerate(bounds)]
    normals, offsets, faces = [], [], []
    for low, high in bounds:
        for axis in range(3):
            for sign, value in ((-1, low), (1, high)):
                normal = np.zeros(3)
                normal[axis] = sign
                normals.append(normal)
                offsets.append(sign * value[axis])
                faces.append((axis, low, high))
    normals, offsets = np.array(normals), np.array(offsets)

    def inside(p, x):
        axis, low, high = faces[p]
        others = [a for a in range(3) if a != axis]
        return all(low[a] <= x[a] <= high[a] for a in others)

    def blocked(a, b):
        for low, high in bounds:
            with np.errstate(divide="ignore", invalid="ignore"):
                t1, t2 = (low + 1e-9 - a) / (b - a), (high - 1e-9 - a) / (b - a)
            enter, leave = np.nanmax(np.minimum(t1, t2)), np.nanmin(np.maximum(t1, t2))
            if max(enter, 0.0) < min(leave, 1.0) - 1e-9:
                return True
        return False

    source, receiver = np.array([0.0, 0.03, 0.61]), np.array([-0.1, -0.02, 0.57])
    phone = Phone.ideal(source, [receiver, receiver + [0.0, 0.3, 0.1]])
    paths = trace_paths(
        Scene(obstacles, Air.lossless(1.0)), phone, Pose([0.0, 0.0, 0.0], Rotation.identity()),
        Fidelity(max_order=3, mechanisms=("specular",)),
    )  # fmt: skip
    ours = np.sort(paths.delay_s[(paths.mic == 0) & (paths.order > 0)])
    expected = _exhaustive(normals, offsets, inside, blocked, source, receiver, 3, 14.0)
    assert len(expected) >= 3
    np.testing.assert_allclose(ours, expected, rtol=1e-12)


def test_poses_in_one_call_equal_poses_one_by_one(box, phone):
    scene = Scene([box((0.2, 6.0, 3.0), (3.1, 0.4, 1.5), "wall"), box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground")])
    positions = np.array([[0.0, 0.0, 1.3], [0.4, 0.1, 1.25], [1.0, -0.2, 1.35]])
    rotation = held_rotation([0.0, 0.1, -0.1], 0.5)
    f = np.array([18_000.0, 21_000.0])
    every = Pose(positions, rotation)
    together = trace_paths(scene, phone, every).transfer_function(f)
    for k in range(3):
        for pose in (Pose(positions[k], rotation[k]), every[k : k + 1]):
            alone = trace_paths(scene, phone, pose).transfer_function(f)
            np.testing.assert_allclose(together[k], alone, rtol=1e-9)


def test_memory_for_the_search_does_not_decide_what_is_found(box, cylinder, phone, monkeypatch):
    things = [
        box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground"),
        box((0.2, 3.0, 3.0), (2.1, 0.0, 1.5), "wall"),
        box((3.0, 0.2, 3.0), (0.0, 1.6, 1.5), "side"),
        cylinder(0.2, 1.2, (1.2, -0.6, 0.6), 24),
    ]
    pose = Pose(np.array([[0.0, 0.0, 1.2], [0.3, 0.1, 1.3]]), held_rotation(np.array([0.0, 0.2])))
    args = Scene(things, Air.lossless(C)), phone, pose, Fidelity(max_order=3)
    whole = trace_paths(*args)
    assert set(whole.order) == {0, 1, 2, 3}
    assert {"specular", "edge", "mixed"} <= set(whole.kind)
    monkeypatch.setattr("simulator.images.image_tree.TRIED_AT_ONCE", 50)  # three images at once
    parts = trace_paths(*args)
    np.testing.assert_array_equal(parts.sequence, whole.sequence)
    np.testing.assert_array_equal(parts.band_gain, whole.band_gain)
    assert parts.rejected == whole.rejected


def test_order_of_obstacles_changes_only_the_order_of_summation(box, phone):
    obstacles = [box((0.2, 6.0, 3.0), (3.1, 0.4, 1.5), "wall"), box((20.0, 20.0, 0.2), (0.0, 0.0, -0.1), "ground")]
    pose = Pose([0.0, 0.0, 1.3], held_rotation(0.0, 0.5))
    first = trace_paths(Scene(obstacles), phone, pose)
    second = trace_paths(Scene(obstacles[::-1]), phone, pose)
    np.testing.assert_allclose(np.sort(first.delay_s), np.sort(second.delay_s), rtol=1e-14)


@pytest.mark.parametrize(
    ("argument", "rule"),
    [
        ({"max_order": -1}, "max_order"),
        ({"max_range_m": 0.0}, "max_range_m"),
        ({"mechanisms": ("magic",)}, "mechanisms"),
    ],
)
def test_bad_fidelity_names_value_and_rule(argument, rule):
    with pytest.raises(ValueError, match=rule):
        Fidelity(**argument)


def test_nan_vertices_are_refused():
    mesh = trimesh.creation.box((1, 1, 1))
    vertices = mesh.vertices.copy()
    vertices[3, 1] = np.nan
    broken = trimesh.Trimesh(vertices, mesh.faces, process=False)
    with pytest.raises(ValueError, match=r"'broken'.*finite"):
        Obstacle(broken, Material.rigid(), "broken")


def test_a_mesh_without_area_is_refused_and_a_flat_triangle_among_others_left_out():
    """Regression: the first used to end in numpy's "zero-size array to reduction operation"."""
    line = trimesh.Trimesh([[2, -0.5, 0], [2, 0.5, 1], [2, 0, 0.5]], [[0, 1, 2]], process=False)
    with pytest.raises(ValueError, match=r"'line' must have a triangle with an area, got 1 without"):
        Obstacle(line, Material.rigid(), "line")
    box = trimesh.creation.box((0.3, 0.5, 0.8))
    tailed = trimesh.Trimesh(
        np.vstack([box.vertices, line.vertices]), np.vstack([box.faces, [[8, 9, 10]]]), process=False
    )
    assert with_area(tailed).tolist() == [True] * 12 + [False]


@pytest.mark.parametrize("max_range_m", [0.01, 0.05])
def test_direct_sound_is_heard_at_any_listening_range(box, max_range_m):
    # Cause: the direct sound to the far microphone counted as too long an echo, and the sound through the case was
    # given its rows: columns of unequal length.
    scene = Scene([box((1.0, 1.0, 1.0), (2.0, 0.0, 0.0), "box")])
    fidelity = Fidelity(max_range_m=max_range_m)
    paths = trace_paths(scene, Phone.named("galaxy-s5"), Pose([0.0, 0.0, 0.0], held_rotation(0.0)), fidelity)
    assert len(paths) == len(paths.order) == 4
    assert "direct: 4" in paths.explain()


def test_a_microphone_on_a_face_hears_its_echo(box):
    # Cause: the last leg has no length there; its direction was 0 / 0, and what is not a number is under the noise.
    scene = Scene([box((1.0, 1.0, 1.0), (2.0, 0.0, 0.0), "box")], Air.lossless(C))
    phone = Phone.ideal([0.0, 0.05, 0.0], [[1.5, 0.1, 0.1], [0.0, 0.0, 0.1]])
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], Rotation.identity()), MIRRORS)
    heard = paths[paths.mic == 0]
    np.testing.assert_array_equal(heard.order, [0, 1])
    np.testing.assert_allclose(heard.gain[1], heard.gain[0], rtol=1e-12)


@pytest.mark.parametrize("gap_m", [0.0, 1e-17, 1e-12, 1e-9, 1e-6])
def test_a_speaker_on_a_face_has_its_image(gap_m):
    """Cause: with no length before it the reflection was lost, or its wavefront had no direction: 6 and 3.5 dB less."""
    table = trimesh.creation.box(bounds=[[-5.0, -5.0, -0.2], [5.0, 5.0, -gap_m]])
    leaning = Transducer(axis=[0.0, 0.0, 1.0], rear_loss_db=12.0)
    phone = replace(Phone.ideal([0.0, 0.0, 0.0], [[0.1, 0.0, 0.5], [0.2, 0.1, 0.4]]), speaker=leaning)
    scene = Scene([Obstacle(table, Material.rigid(), "table")], Air.lossless(C))
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], Rotation.identity()), MIRRORS)
    for mic, place in enumerate(([0.1, 0.0, 0.5], [0.2, 0.1, 0.4])):
        mine, length = paths[paths.mic == mic], np.linalg.norm(place)
        downwards = 10.0 ** (-12.0 * (1.0 + place[2] / length) / 40.0)
        np.testing.assert_array_equal(mine.order, [0, 1])
        np.testing.assert_allclose(np.abs(mine.gain) * length, [1.0, downwards], rtol=1e-5)


def test_a_surface_too_rough_for_rays_is_named(rng):
    """The error named a place about the middle of the world, "m from the phone", and no obstacle."""
    rough = trimesh.creation.box((0.8, 0.8, 0.8)).subdivide_to_size(0.02)
    rough.vertices += rng.normal(0.0, 0.002, rough.vertices.shape)
    rough.apply_translation([2.0, 0.0, 0.0])
    scene = Scene([Obstacle(rough, Material.rigid(), "rough")], Air.lossless())
    phone = Phone.named("ideal")
    with pytest.raises(ValueError, match=r"of 'rough' must .* 32 places at most, got \d+: .* call it flat"):
        trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], held_rotation(0.0)), Fidelity(mechanisms=("curved",)))


def test_sound_through_the_case_is_there_where_the_direct_sound_is_hidden():
    """Cause: half of its columns were those of the direct paths that are left: tables with columns of two lengths."""
    phone = replace(Phone.named("galaxy-s8-plus"), body=None)
    apart = replace(phone.geometry, mics_m=phone.geometry.mics_m * [1.0, 8.0, 1.0])  # too far apart to be one phone
    phone = replace(phone, geometry=apart, noise_spl_db=-np.inf)
    sheet = trimesh.creation.box(bounds=[[-0.201, -1.0, 0.0], [-0.2, 1.0, 3.0]])
    scene = Scene([Obstacle(sheet, Material.rigid(), "sheet")])
    found = trace_paths(scene, phone, Pose(np.tile([0.0, 0.0, 1.3], (3, 1)), held_rotation(0.0)))
    case = found[found.obstacle == "case"]
    assert list(zip(case.pose, case.mic, strict=True)) == [(pose, mic) for pose in range(3) for mic in (0, 1)]
    assert ((found.order == 0) & (found.mic == 1) & (found.obstacle == "")).sum() == 0
    assert found.explain()
    assert {len(column) for column in (found.kind, found.delay_s, found.points_m, found.uv)} == {len(found)}
