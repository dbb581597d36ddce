"""What a mesh is read as: planes, smooth surfaces, and the normals and curvatures of the latter."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from scenes.obstacles.furniture import tree
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.surfaces.quadratic_triangles import edge_bulge
from simulator.surfaces.reflectors import read_mesh, reflectors_in
from simulator.surfaces.round_bodies import recognised
from tests.references import meshes


def _read(mesh, surface="auto"):
    return reflectors_in(read_mesh(Obstacle(mesh, Material.rigid(), "body", surface)))


def _pieces(surface):
    """Number of pieces of a smooth surface that no smooth edge joins."""
    label = np.arange(len(surface))
    for _ in range(len(surface)):
        across = np.where(surface.neighbor >= 0, label[surface.neighbor], label[:, None])
        lower = np.minimum(label, across.min(axis=1))
        if (lower == label).all():
            break
        label = lower
    return len(np.unique(label))


@pytest.mark.parametrize("sections", [16, 32, 128])
def test_cylinder_is_two_ends_and_one_smooth_side(sections):
    patches, side = _read(trimesh.creation.cylinder(0.25, 1.0, sections=sections))
    assert len(patches) == 2
    np.testing.assert_allclose(np.abs(patches.normal[:, 2]), 1.0)
    assert len(side) == 2 * sections
    assert _pieces(side) == 1
    assert side.closed


@pytest.mark.parametrize("splits", [0, 1, 3])
def test_box_is_six_patches_whatever_its_triangles(splits):
    mesh = trimesh.creation.box((1.0, 2.0, 3.0))
    for _ in range(splits):
        mesh = mesh.subdivide()
    patches, smooth = _read(mesh)
    assert len(patches) == 6
    assert smooth is None
    np.testing.assert_allclose(np.sort(patches.offset_m), [0.5, 0.5, 1.0, 1.0, 1.5, 1.5], rtol=1e-12)
    assert patches.one_sided.all()


@pytest.mark.parametrize("make", [meshes.uv_sphere, lambda a, n: meshes.icosphere(a, {32: 3, 256: 5}[n])])
@pytest.mark.parametrize("segments", [32, 256])
def test_a_fine_sphere_is_never_a_plane(make, segments):
    mesh = make(1.0, segments)
    patches, smooth = _read(mesh)
    assert len(patches) == 0
    assert len(smooth) == len(mesh.faces)
    assert _pieces(smooth) == 1


def test_rounded_box_is_six_panels_and_their_fillets():
    inner, radius = np.array([0.6, 0.4, 0.8]), 0.05
    up, around = np.meshgrid(np.arange(-8, 9) * np.pi / 16, np.arange(32) * np.pi / 16)
    ball = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1).reshape(-1, 3)
    sign = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    inside = (ball[None] * sign[:, None] >= -1e-9).all(axis=2)
    point = np.concatenate([radius * ball[inside[i]] + sign[i] * inner / 2.0 for i in range(8)])
    point = np.unique(point.round(12), axis=0)
    patches, fillets = _read(meshes.hull(point))
    assert len(patches) == 6
    np.testing.assert_allclose(np.sort(patches.offset_m), np.repeat(np.sort(inner / 2.0 + radius), 2), rtol=1e-9)
    assert len(fillets) > 100
    nearest = np.clip(fillets.corner_m, -inner / 2.0, inner / 2.0)
    np.testing.assert_allclose(fillets.normal, (fillets.corner_m - nearest) / radius, atol=0.12)
    # balls run into straight fillets, where no quadric fits: 0.25 mm off in the middle of the long edges, of 50 mm
    middle = 0.5 * (fillets.corner_m[:, [0, 1, 0]] + fillets.corner_m[:, [1, 2, 2]]) - 0.25 * fillets.bulge_m
    sag = np.linalg.norm(middle - np.clip(middle, -inner / 2.0, inner / 2.0), axis=2) - radius
    assert np.abs(sag).max() < 5e-4


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_flats_between_fillets_stay_flat_when_drawn_out_to_a_taper(steps):
    """A wheeled bin's front, in two planes 0.3 degrees apart, each the other's large neighbour, was one round surface.

    Its echo came 6 dB too weak and 12 mm from before it.
    """
    height = np.linspace(0.0, 1.0, steps + 1)
    scale = 0.8 + 0.2 * height + 0.02 * height * (1.0 - height)
    patches, fillets = _read(_drawn_out(0.5 * scale, 0.06 * scale, height))
    fronts = patches.normal[:, 0] > 0.9
    assert fronts.sum() == steps
    lower, upper = scale[:-1], scale[1:]
    slope = 0.5 * (upper - lower) * steps
    np.testing.assert_allclose(np.sort(patches.normal[fronts, 2]), np.sort(-slope / np.hypot(1.0, slope)), atol=1e-9)
    side = np.cross(fillets.corner_m[:, 1] - fillets.corner_m[:, 0], fillets.corner_m[:, 2] - fillets.corner_m[:, 0])
    assert 0.5 * np.linalg.norm(side, axis=1).max() < 0.02 / steps  # those of the flats have ten times as much


def _drawn_out(half_m, radius_m, height_m):
    """A square rod of such half widths at such heights, its edges rounded in four steps, closed by flat ends."""
    quarter = np.arange(5) * np.pi / 8
    turn = np.concatenate([quarter + k * np.pi / 2 for k in range(4)])
    sign = np.repeat([[1, 1], [-1, 1], [-1, -1], [1, -1]], 5, axis=0)
    ball = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rings = [(half - radius) * sign + radius * ball for half, radius in zip(half_m, radius_m, strict=True)]
    point = np.concatenate([np.column_stack([ring, np.full(20, z)]) for ring, z in zip(rings, height_m, strict=True)])
    low = np.array([[20 * row + k, 20 * row + (k + 1) % 20] for row in range(len(rings) - 1) for k in range(20)])
    sides = np.concatenate(
        [np.column_stack([low, low[:, 1] + 20]), np.column_stack([low[:, ::-1] + [20, 0], low[:, 0] + 20])]
    )
    last = 20 * (len(rings) - 1)
    ends = [[0, k + 1, k] for k in range(1, 19)] + [[last, last + k, last + k + 1] for k in range(1, 19)]
    return trimesh.Trimesh(point, np.concatenate([sides, ends]), process=True)


def test_almost_parallel_normals_do_not_bend_an_edge():
    # equal tilts of 1e-3 at both ends of a 1 m edge and normals 1e-6 apart: no quadratic obeys both
    a, b = np.array([[0.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    first, second = np.array([[1e-3, 0.0, 1.0]]), np.array([[1e-3, 1e-6, 1.0]])
    assert np.linalg.norm(edge_bulge(a, b, first, second)) < 1e-3


def test_rounded_edge_is_at_right_angles_to_its_normals():
    angle = np.array([0.1, 0.4])
    point = np.stack([np.cos(angle), 0.7 * np.sin(angle), 0.0 * angle], axis=1)
    normal = np.stack([np.cos(angle), np.sin(angle) / 0.7, 0.0 * angle], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    bulge = edge_bulge(point[:1], point[1:], normal[:1], normal[1:])[0]
    chord = point[1] - point[0]
    assert np.linalg.norm(bulge) > 0.01
    tilt = np.array([(chord - bulge) @ normal[0], (chord + bulge) @ normal[1]]) / np.linalg.norm(chord)
    np.testing.assert_allclose(tilt, 0.0, atol=1e-5)  # PARALLEL_RAD squared over the angle between the normals


@pytest.mark.parametrize(("surface", "patches", "smooth"), [("flat", 32 + 2, False), ("smooth", 2, True)])
def test_surface_setting_overrules(surface, patches, smooth):
    found, side = _read(trimesh.creation.cylinder(0.25, 1.0, sections=32), surface)
    assert len(found) == patches
    assert (side is not None) == smooth


def test_open_sheets_reflect_from_both_sides():
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    patches, smooth = _read(trimesh.Trimesh(corner, [[0, 1, 2], [0, 2, 3]], process=False))
    assert len(patches) == 1
    assert not patches.one_sided.any()
    assert smooth is None
    patches, half_pipe = _read(meshes.tube(0.5, 1.0, 32, 2))
    assert len(patches) == 0
    assert not half_pipe.closed


@pytest.mark.parametrize("make", [lambda: trimesh.creation.cylinder(0.25, 1.0, sections=32),
                                  lambda: trimesh.creation.box((1.0, 1.0, 1.0)),
                                  lambda: meshes.icosphere(0.3, 2)])  # fmt: skip
def test_triangle_soup_reads_like_the_mesh_it_came_from(make):
    whole, soup = _read(make()), _read(meshes.soup(make()))
    assert len(whole[0]) == len(soup[0])
    assert (whole[1] is None) == (soup[1] is None)
    if whole[1] is not None:
        assert soup[1].closed
        order = [np.lexsort(s.corner_m.mean(axis=1).T.round(9)) for s in (whole[1], soup[1])]
        np.testing.assert_allclose(
            whole[1].normal[order[0]].sum(axis=1), soup[1].normal[order[1]].sum(axis=1), atol=1e-9
        )


def test_parts_of_one_mesh_are_read_one_by_one():
    post = trimesh.creation.cylinder(0.1, 2.0, sections=24)
    ball = meshes.icosphere(0.3, 2)
    ball.apply_translation([0.0, 0.0, 2.0])
    foot = trimesh.creation.box((0.8, 0.8, 0.1), trimesh.transformations.translation_matrix([0.0, 0.0, -2.0]))
    patches, smooth = _read(trimesh.util.concatenate([post, ball, foot]))
    assert len(patches) == 2 + 6
    assert _pieces(smooth) == 2
    assert len(smooth) == 2 * 24 + len(ball.faces)


def test_closed_parts_that_share_an_edge_are_closed_together():
    """On the ring that boughs share more than two facets meet: trees were taken for open, and their insides echoed."""
    one = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    other = trimesh.creation.box(bounds=[[1.0, 1.0, 0.0], [2.0, 2.0, 1.0]])
    for mesh in (trimesh.util.concatenate([one, other]), tree()):
        assert read_mesh(Obstacle(mesh, Material.rigid(), "body")).closed
    assert _read(trimesh.util.concatenate([one, other]))[0].one_sided.all()


def test_slivers_do_no_harm():
    post = trimesh.creation.cylinder(0.25, 1.0, sections=32)
    vertices = np.vstack([post.vertices, post.vertices[post.faces[0]].mean(axis=0)])
    sliver = [[post.faces[0][0], post.faces[0][1], post.faces[0][0]], [post.faces[0][1], post.faces[0][1], 0]]
    patches, side = _read(trimesh.Trimesh(vertices, np.vstack([post.faces, sliver]), process=False))
    assert len(patches) == 2
    assert len(side) == 64
    assert np.isfinite(side.normal).all()
    assert np.isfinite(side.curvature).all()


def _turned(mesh, seed):
    turn = Rotation.random(random_state=seed).as_matrix()
    return trimesh.Trimesh(mesh.vertices @ turn.T, mesh.faces, process=False), turn


def _ellipsoid(point, semi_axes):
    """Normals and curvature tensors from the gradient and Hessian of sum (x/a)^2."""
    gradient = point / semi_axes**2
    size = np.linalg.norm(gradient, axis=-1)[..., None]
    normal = gradient / size
    onto = np.eye(3) - normal[..., :, None] * normal[..., None, :]
    return normal, onto @ (np.diag(1.0 / semi_axes**2) / size[..., None]) @ onto


@settings(max_examples=12, deadline=None)
@given(
    a=st.floats(0.1, 0.5), b=st.floats(0.1, 0.5), c=st.floats(0.1, 0.5), seed=st.integers(0, 2**16),
    segments=st.sampled_from([40, 64]),
)  # fmt: skip
def test_normals_and_curvatures_of_irregular_ellipsoids_are_exact(a, b, c, seed, segments):
    axes = np.array([a, b, c])
    sphere = meshes.jittered_sphere(1.0, segments, np.random.default_rng(seed), share=0.2)
    mesh, turn = _turned(meshes.stretched(sphere, axes), seed)
    _, smooth = _read(mesh, "smooth")
    assert len(smooth) == len(mesh.faces)
    normal, curvature = _ellipsoid(smooth.corner_m @ turn, axes)
    np.testing.assert_allclose(smooth.normal @ turn, normal, atol=1e-4)
    np.testing.assert_allclose(turn.T @ smooth.curvature @ turn, curvature, atol=1e-3 * np.abs(curvature).max())


@pytest.mark.parametrize("rows", [1, 2, 8])
@pytest.mark.parametrize("top", [0.25, 0.3, 0.1])
def test_normals_and_curvatures_of_irregular_cylinders_and_cones_are_exact(rows, top, rng):
    base, height = 0.25, 0.9
    mesh, turn = _turned(meshes.tube(base, height, 32, rows, top_radius_m=top, rng=rng), 5)
    _, smooth = _read(mesh)
    point, slope = smooth.corner_m @ turn, (top - base) / height
    radius = np.hypot(point[..., 0], point[..., 1])[..., None]
    outwards, up = point * [1.0, 1.0, 0.0] / radius, np.array([0.0, 0.0, 1.0])
    lean = np.hypot(1.0, slope)
    np.testing.assert_allclose(smooth.normal @ turn, (outwards - slope * up) / lean, atol=1e-6)
    around = np.cross(up, outwards)
    expected = around[..., :, None] * around[..., None, :] / (lean * radius)[..., None]
    np.testing.assert_allclose(turn.T @ smooth.curvature @ turn, expected, atol=1e-5 * expected.max())


def test_curvature_of_a_torus_converges_with_the_square_of_the_spacing():
    # no quadric: principal curvatures 1 / r and cos / (R + r cos)
    error = []
    for rings in (16, 32, 64):
        _, smooth = _read(meshes.torus(0.5, 0.15, 2 * rings, rings))
        distance = np.hypot(smooth.corner_m[..., 0], smooth.corner_m[..., 1])
        expected = 1.0 / 0.15 + (distance - 0.5) / 0.15 / distance
        error.append(np.abs(np.trace(smooth.curvature, axis1=2, axis2=3) - expected).max() * 0.15)
    assert error[0] < 0.2
    assert error[2] < error[1] / 2.5 < error[0] / 2.5**2


@pytest.mark.parametrize("noise_m", [0.0, 1e-13])
def test_rings_of_few_segments_are_bent_along_their_long_edges(noise_m, rng):
    """Cause: of two long edges that lead on either way one was taken for a straight line of the surface, by rounding:
    normals were off by up to 5.4 degrees, and echoes of shifted or turned rings differed by 2 dB."""
    for minor_m in (0.02, 0.08):
        ring = trimesh.creation.torus(0.3, minor_m, major_sections=32, minor_sections=32 if minor_m == 0.08 else 16)
        vertices = ring.vertices + noise_m * rng.standard_normal(ring.vertices.shape)
        mesh = trimesh.Trimesh(vertices, ring.faces, process=False)
        surface = reflectors_in(read_mesh(Obstacle(mesh, Material.rigid(), "ring")))[1]
        centre = surface.corner_m * [1.0, 1.0, 0.0]
        centre *= 0.3 / np.linalg.norm(centre, axis=-1, keepdims=True)
        cosine = np.abs(np.sum((surface.corner_m - centre) * surface.normal, axis=-1)) / minor_m
        assert np.degrees(np.arccos(cosine.min())) < (1.0 if minor_m == 0.08 else 1.8)


def test_what_is_no_round_body_is_not_taken_for_one(rng):
    for mesh in (
        meshes.torus(0.5, 0.15, 32, 16),
        meshes.stretched(meshes.icosphere(1.0, 2), np.array([0.2, 0.2, 0.21])),
    ):
        assert recognised(mesh.vertices, mesh.face_normals) is None
    post = meshes.tube(0.1, 2.2, 32, 1)
    assert recognised(post.vertices, post.face_normals) is not None
    post.vertices = np.round(post.vertices, 4)  # both rims lie on a sphere of 1.1 m as well
    assert recognised(post.vertices, post.face_normals) is None
    oval = meshes.tube(0.2, 1.0, 32, 1)
    oval.vertices = oval.vertices * [1.0, 1.002, 1.0]
    assert recognised(oval.vertices, oval.face_normals) is None
    ball = meshes.jittered_sphere(0.2, 16, rng)
    assert recognised(ball.vertices, ball.face_normals) is not None


@pytest.mark.parametrize("decimals", [3, 4, 5, 6])
def test_a_post_from_a_file_of_few_decimals_echoes_as_it_should(decimals):
    """Cause: its side was taken for a part of the sphere on which both rims lie: no echo with 4 decimals and with 5."""
    post = trimesh.creation.cylinder(0.1, 2.2, sections=32)
    post.apply_translation([1.2, 0.05, 1.1])
    level_db = [
        20.0 * np.log10(np.abs(_echo_of(trimesh.Trimesh(vertices, post.faces, process=False))).max())
        for vertices in (post.vertices, np.round(post.vertices, decimals))
    ]
    assert abs(level_db[1] - level_db[0]) < 0.5


def _echo_of(mesh):
    """(2, F) of a mesh in front of a level phone."""
    scene = Scene([Obstacle(mesh, Material.rigid(), "body")], Air.lossless(343.0))
    paths = trace_paths(scene, Phone.named("ideal"), Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0)))
    return paths[paths.order > 0].transfer_function(np.linspace(18_000.0, 23_000.0, 6))


@pytest.mark.parametrize(
    "fault", ["doubled", "doubled, the other way round", "every third turned over", "stray vertex"]
)
@pytest.mark.parametrize("level", ["standard", "reference"])
def test_badly_kept_meshes_echo_as_clean_ones_do(fault, level):
    # Cause: facets found no neighbour through doubles and turned-over ones, so that a cylinder was 32 planes (43 paths
    # for 2) or silent, and the choice of the integral took 369 GB; a stray vertex 1000 km away cleared 2 m of each ray.
    clean = trimesh.creation.cylinder(0.25, 1.4, sections=32)
    clean.apply_translation([2.0, 0.2, 0.05])
    vertices, faces = np.asarray(clean.vertices), np.asarray(clean.faces)
    if fault == "stray vertex":
        vertices = np.vstack([vertices, [[1e6, 1e6, 1e6]]])
    elif fault == "every third turned over":
        faces = np.where(np.arange(len(faces))[:, None] % 3 == 0, faces[:, ::-1], faces)
    else:
        faces = np.vstack([faces, faces if fault == "doubled" else faces[:, ::-1]])
    spoilt = trimesh.Trimesh(vertices, faces, process=False)
    want, got = (_echo(mesh, level) for mesh in (clean, spoilt))
    assert np.abs(want).max() > 0.01
    # the integral takes both sides of what is not wound as a closed body, and other facets on ties: 1.4 % here
    assert np.abs(got - want).max() < 2e-2 * np.abs(want).max()


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
def test_an_open_tube_echoes_alike_whichever_way_it_is_wound(level):
    # Causes: its rims counted as dark if the normals pointed inwards, so that the integral was not taken: 8 %. Facets
    # were halved along the other diagonal: 0.3 to 1.5 %.
    tube = trimesh.creation.cylinder(0.3, 1.0, sections=32)
    tube.update_faces(np.abs(tube.face_normals[:, 2]) < 0.5)
    tube.apply_translation([2.0, 0.2, 0.05])
    inwards = trimesh.Trimesh(tube.vertices, tube.faces[:, ::-1], process=False)
    want, got = (_echo(mesh, level) for mesh in (tube, inwards))
    assert np.abs(got - want).max() < 5e-4 * np.abs(want).max()


def test_a_band_that_cannot_be_wound_alike_keeps_its_facets():
    turn = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    along = np.stack([np.cos(turn), np.sin(turn), np.zeros(48)], axis=1)
    lean = 0.2 * (np.cos(0.5 * turn)[:, None] * along + np.sin(0.5 * turn)[:, None] * [0.0, 0.0, 1.0])
    vertices = np.concatenate([along - lean, along + lean])
    one, two = np.arange(47), np.arange(1, 48)
    strips = np.concatenate([np.stack([one, two, two + 48], 1), np.stack([one, two + 48, one + 48], 1)])
    faces = np.vstack([strips, [[47, 48, 0], [47, 0, 95]]])  # the last joins on upside down
    planes, surface = _read(trimesh.Trimesh(vertices, faces, process=False))
    assert len(planes) == 0
    assert surface is not None
    assert len(surface) == 96


def _echo(mesh, level):
    """(2, F) what comes back off a mesh 2 m ahead."""
    phone = Phone.ideal([0.01, 0.06, 0.0], [[0.0, 0.075, 0.002], [0.003, -0.07, 0.0]])
    scene = Scene([Obstacle(mesh, Material.named("brick"), "body")], Air.lossless())
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], held_rotation(0.1, 0.5)), Fidelity(level))
    return paths[paths.order > 0].transfer_function(np.linspace(18e3, 23e3, 21))


@pytest.mark.parametrize(("radius", "height", "sections"), [(0.4, 1.0, 48), (0.2, 1.0, 32), (0.8, 0.2, 64)])
def test_a_cone_echoes_off_its_side(radius, height, sections):
    # Cause: tip and rim lie on a sphere, as which the cone was read: no echo, or one 10 to 42 cm early.
    cone = Obstacle(trimesh.creation.cone(radius=radius, height=height, sections=sections), Material.rigid(), "cone")
    slope = np.arctan2(radius, height)
    for share, turn in ((0.3, 0.0), (0.5, 0.05), (0.7, 0.1)):  # up the side, and round it
        outwards, round_it = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
        middle = radius * (1.0 - share) * outwards + [0.0, 0.0, height * share]
        middle += 1.5 * (np.cos(slope) * outwards + [0.0, 0.0, np.sin(slope)])
        phone = Phone.ideal(middle + 0.02 * round_it, [middle - 0.02 * round_it, middle - 0.1 * round_it])
        pose, rays = Pose([0.0, 0.0, 0.0], Rotation.identity()), Fidelity(mechanisms=("specular", "curved", "edges"))
        paths = trace_paths(Scene([cone], Air.lossless()), phone, pose, rays)
        echo = paths[(paths.order == 1) & (paths.mic == 0)]
        assert len(echo) == 1
        curve = radius * (1.0 - share) / np.cos(slope)
        exact = np.sqrt(curve / (curve + 1.5)) / 3.0
        assert abs(20.0 * np.log10(np.abs(echo.gain[0]) / exact)) < 0.1
        # 2 um found: the ends lie 2 cm beside the normal, and rows of facets are round only in their corners
        assert abs(343.0 * echo.delay_s[0] - 2.0 * np.hypot(1.5, 0.02)) < 5e-6


@pytest.mark.parametrize("top", [0.1, 0.04])
def test_a_steeply_tapered_frustum_is_no_sphere(top):
    # Cause: a cone was looked for from a cylinder's guess only, and any two rims lie on a sphere: echoes 1 m off.
    side = [[0.0, 0.0], [0.4, 0.0], [top, 1.0], [0.0, 1.0]]
    _, surface = _read(trimesh.creation.revolve(np.array(side), sections=48))
    assert surface is not None
    lean = np.arctan2(0.4 - top, 1.0)
    np.testing.assert_allclose(surface.normal[:, :, 2], np.sin(lean), atol=1e-9)


def test_a_phone_that_nearly_touches_a_ball_hears_it():
    # Cause: the tapered guess at a cone lost its slope where that came out as exactly zero.
    ball = trimesh.creation.icosphere(3, 0.3)
    ball.apply_translation([1.0, 0.0, 0.0])
    scene = Scene([Obstacle(ball, Material.rigid(), "ball")], Air.lossless())
    paths = trace_paths(scene, Phone.named("ideal"), Pose([0.6, 0.0, 0.0], held_rotation(0.0)))
    assert (paths.kind == "curved").sum() == 2
    _, surface = _read(trimesh.Trimesh(ball.vertices - [0.69, 0.0, 0.0], ball.faces, process=False))
    np.testing.assert_allclose(np.trace(surface.curvature, axis1=2, axis2=3), 2.0 / 0.3, rtol=1e-6)


@pytest.mark.parametrize("fold_deg", [5.0, 15.0, 30.0])
def test_broad_planes_that_meet_at_less_than_the_crease_angle_stay_planes(fold_deg):
    """Cause: a facade that folds back 2 m beside the phone, as one mesh, was bent round: its echo came from 5 to 14 cm
    too near, and from elsewhere again where its triangles were smaller."""
    back = np.tan(np.deg2rad(fold_deg))
    low = np.array([[1.5, -3.0, -3.0], [1.5, 2.0, -3.0], [1.5 + 4.0 * back, 6.0, -3.0]])
    vertices = np.vstack([low, low + [0.0, 0.0, 6.0]])
    facade = trimesh.Trimesh(vertices, [[0, 4, 1], [0, 3, 4], [1, 5, 2], [1, 4, 5]], process=False)
    for mesh in (facade, facade.subdivide()):
        patches, smooth = _read(mesh)
        assert len(patches) == 2
        assert smooth is None


def test_facets_of_a_broad_column_are_no_broad_planes():
    patches, side = _read(trimesh.creation.cylinder(1.0, 3.0, sections=16))
    assert len(patches) == 2
    assert _pieces(side) == 1
