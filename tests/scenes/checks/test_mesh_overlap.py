"""What lies inside a mesh, and how deep two meshes overlap: closed forms, then independent answers."""

import numpy as np
import pytest
import trimesh

from scenes.checks.mesh_overlap import _crossings, inside, overlap_depth
from scenes.obstacles import person
from scenes.obstacles.solids import box, shifted


def test_inside_a_sphere_of_either_winding() -> None:
    sphere = trimesh.creation.icosphere(4, 1.0)
    direction = np.random.default_rng(1).normal(size=(200, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    inverted = trimesh.Trimesh(sphere.vertices, sphere.faces[:, ::-1], process=False)
    for mesh in (sphere, inverted):
        assert inside(mesh, 0.99 * direction).all()
        assert not inside(mesh, 1.001 * direction).any()


def test_inside_agrees_with_rays_on_a_person() -> None:
    body = person()
    points = np.random.default_rng(2).uniform(*body.bounds, (400, 3))
    found = inside(body, points)
    assert 20 < found.sum() < 380
    # A point is inside where a line from far away has entered more often than it has left.
    away = np.array([13.1, 7.7, 3.3])
    a, b, c = np.asarray(body.triangles).transpose(1, 0, 2)
    frame = np.stack([b - a, c - a, np.broadcast_to(-away, a.shape)], axis=2)  # u (b - a) + v (c - a) - t away = p - a
    u, v, t = np.moveaxis(np.linalg.solve(frame, (points[:, None] - a)[..., None])[..., 0], 2, 0)
    crossed = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)
    entered = crossed @ np.sign(body.face_normals @ away)  # from far away it comes against the normal of what it enters
    np.testing.assert_array_equal(found, entered > 0.0)


def test_crossings_agree_with_linear_equations() -> None:
    rng = np.random.default_rng(0)
    edges, triangles = rng.normal(size=(60, 2, 3)), rng.normal(size=(30, 3, 3))
    expected = []
    for e, (p, q) in enumerate(edges):
        for a, b, c in triangles:
            u, v, t = np.linalg.solve(np.stack([b - a, c - a, p - q], axis=1), p - a)
            if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < 1:
                expected.append((e, t))
    assert len(expected) > 50
    found = np.stack(_crossings(edges, triangles), axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize(
    ("offset", "depth"),
    [([0.9, 0.0, 0.0], 0.1), ([1.0, 0.0, 0.0], 0.0), ([1.2, 0.0, 0.0], 0.0), ([0.0, 0.0, -0.45], 0.05)],
)
def test_two_boxes(offset: list[float], depth: float) -> None:
    one = box([1.0, 1.0, 1.0])
    other = shifted(box([1.0, 0.5, 0.5]), offset)
    assert overlap_depth(one, other) == pytest.approx(depth, abs=1e-12)
    assert overlap_depth(other, one) == pytest.approx(depth, abs=1e-12)


def test_crossed_beams_without_a_vertex_inside_each_other() -> None:
    assert overlap_depth(box([4.0, 0.4, 0.4]), box([0.4, 4.0, 0.4])) == pytest.approx(0.2, abs=1e-9)


def test_one_within_the_other() -> None:
    assert overlap_depth(box([2.0, 2.0, 2.0]), shifted(box([0.2, 0.2, 0.2]), [0, 0, 0.9])) == pytest.approx(0.9)
