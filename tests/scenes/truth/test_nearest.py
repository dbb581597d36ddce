"""Nearest points of meshes: closed forms first, then dense sampling, then invariance."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.obstacles import car, person, pole_sign
from scenes.obstacles.solids import box, shifted
from scenes.truth.nearest import nearest_points


@pytest.mark.parametrize(
    ("query", "nearest"),
    [
        ([3.0, 0.0, 0.5], [0.5, 0.0, 0.5]),  # before a face
        ([3.0, 2.0, 0.5], [0.5, 0.5, 0.5]),  # before an edge
        ([3.0, 2.0, 4.0], [0.5, 0.5, 1.0]),  # before a corner
        ([0.1, 0.0, 0.5], [0.5, 0.0, 0.5]),  # inside: the surface is still what is asked for
        ([0.5, 0.2, 0.3], [0.5, 0.2, 0.3]),  # on the surface
    ],
)
def test_nearest_point_of_a_cube(query: list[float], nearest: list[float]) -> None:
    point, distance = nearest_points(box([1.0, 1.0, 1.0]), query)
    np.testing.assert_allclose(point[0], nearest, atol=1e-15)
    assert distance[0] == pytest.approx(np.linalg.norm(np.subtract(query, nearest)), abs=1e-15)


@pytest.mark.parametrize("mesh", [car("sedan"), person(), pole_sign()], ids=["car", "person", "sign"])
def test_agrees_with_dense_sampling_to_a_tenth_of_a_millimetre(mesh: trimesh.Trimesh) -> None:
    """Samples s apart miss the nearest point of a face by at most s / 2 sideways: s^2 / (8 d) in distance."""
    query = np.array([[-3.1, 0.3, 1.3], [0.4, -2.6, 1.2], [1.5, 1.8, 0.4]])
    point, distance = nearest_points(mesh, query)
    for q, found, exact in zip(query, point, distance, strict=True):
        near = np.linalg.norm(mesh.triangles - found, axis=2).min(axis=1) < 0.6
        assert near.any()
        samples = _sampled(mesh.triangles[near], 60)
        sampled = np.linalg.norm(samples - q, axis=1).min()
        assert exact <= sampled + 1e-12
        assert sampled - exact < 1e-4


def test_agrees_with_trimesh_on_small_meshes() -> None:
    mesh = pole_sign()
    query = np.random.default_rng(3).uniform(-2.0, 2.0, (40, 3))
    _, expected, _ = trimesh.proximity.closest_point(mesh, query)
    _, distance = nearest_points(mesh, query)
    np.testing.assert_allclose(distance, expected, rtol=1e-10)


def test_a_triangle_without_area_counts_as_its_edges() -> None:
    mesh = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
    point, distance = nearest_points(mesh, [[1.5, 2.0, 0.0]])
    np.testing.assert_allclose(point, [[1.5, 0.0, 0.0]], atol=1e-15)
    assert distance[0] == pytest.approx(2.0)


@settings(max_examples=25, deadline=None)
@given(offset=st.tuples(*[st.floats(-1e6, 1e6)] * 3))
def test_distances_do_not_depend_on_where_the_world_begins(offset: tuple[float, ...]) -> None:
    """Coordinates of 1e6 m round to 1e-10 m in float64."""
    mesh, query = box([0.4, 0.6, 0.9]), np.array([[2.0, 0.4, 1.3], [-1.0, -1.0, 0.2]])
    _, here = nearest_points(mesh, query)
    _, there = nearest_points(shifted(mesh, offset), query + np.asarray(offset))
    np.testing.assert_allclose(there, here, atol=1e-9)


def _sampled(triangles: np.ndarray, count: int) -> np.ndarray:
    """Barycentric grid on every triangle."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
    inside = i + j <= count
    u, v = i[inside] / count, j[inside] / count
    weights = np.stack([1.0 - u - v, u, v])
    return np.einsum("kw,fkc->fwc", weights, triangles).reshape(-1, 3)
