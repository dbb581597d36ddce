"""The same body has the same echoes however a file holds it: rounded to float32, or as triangles that share nothing.

Causes: corners 3e-8 m above the plane of a face of their own body counted as before it, and reflections in that face,
at the corner itself, were up to -40 dB re the free field at 1 m. Closed bodies that touch along an edge, as triangles
that share nothing, were taken for one open surface: echoes up to 17 dB louder.
"""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh

from simulator import Pose, held_rotation
from tests.references.meshes import frustum
from tests.simulator.meshes.one_body import echo_on_ground

LEAST = 1e-5  # -100 dB re the free field at 1 m: rounding to float32 moves corners by 1e-7 m, and the echoes by 3e-6


def _panels() -> trimesh.Trimesh:
    """Four panels around a square that is open above and below, each closed; neighbours touch along edges."""
    ahead = [trimesh.creation.box(bounds=[[-0.3, y, 0.0], [0.3, y + 0.02, 0.8]]) for y in (-0.31, 0.29)]
    aside = [trimesh.creation.box(bounds=[[x, -0.29, 0.0], [x + 0.02, 0.29, 0.8]]) for x in (-0.3, 0.28)]
    return trimesh.util.concatenate([*ahead, *aside])


def _stored(mesh: trimesh.Trimesh, kind: str) -> trimesh.Trimesh:
    return trimesh.load(io.BytesIO(mesh.export(file_type=kind)), file_type=kind)


@pytest.mark.parametrize("kind", ["stl", "ply"])
@pytest.mark.parametrize(("yaw_deg", "ahead_m"), [(17.0, 2.8), (61.0, 1.6), (123.0, 2.8)])
@pytest.mark.parametrize("make", [frustum, _panels])
def test_a_file_of_float32_has_the_echoes_of_its_body(make, yaw_deg, ahead_m, kind):
    mesh = make()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.radians(yaw_deg), [0.0, 0.0, 1.0]))
    mesh.apply_translation([ahead_m, 0.13, 0.0])
    ours, exact = echo_on_ground(_stored(mesh, kind)), echo_on_ground(mesh)
    assert (np.abs(exact).max(axis=1) > 5e-4).all()
    np.testing.assert_allclose(ours, exact, rtol=0.0, atol=LEAST)


def _bench() -> trimesh.Trimesh:
    """A seat and a back that touch along an edge, on two legs: closed boxes in one mesh."""
    seat = trimesh.creation.box(bounds=[[0.0, 0.0, 0.42], [0.45, 1.5, 0.47]])
    back = trimesh.creation.box(bounds=[[0.4, 0.0, 0.47], [0.45, 1.5, 0.9]])
    legs = [trimesh.creation.box(bounds=[[0.05, y, 0.0], [0.4, y + 0.08, 0.42]]) for y in (0.2, 1.2)]
    return trimesh.util.concatenate([seat, *legs, back])


@pytest.mark.parametrize("spoilt", [[[0, 1, 1]], [[0, 1, 0], [2, 2, 2]], "twice"])
def test_facets_without_area_or_twice_open_no_bodies_that_touch(spoilt):
    """Cause: with such a facet no reading of the mesh was closed, and its bodies were joined: 6 dB at -34 dB re 1 m."""
    mesh = _bench().apply_translation([1.3, -0.7, 0.0])
    more = mesh.faces[:5] if spoilt == "twice" else spoilt
    kept_badly = trimesh.Trimesh(mesh.vertices, np.vstack([mesh.faces, more]), process=False)
    np.testing.assert_allclose(echo_on_ground(kept_badly), echo_on_ground(mesh), rtol=0.0, atol=LEAST)


@pytest.mark.parametrize("corner", range(4))
@pytest.mark.parametrize("off_m", [-1e-4, 1e-4])
def test_a_face_of_corners_a_tenth_of_a_millimetre_off_keeps_the_ends_of_its_edges(corner, off_m):
    """Causes: the half of a face beyond its diagonal covered the end of the upright edge beside it, as a sheet on its
    own half, and mirrored that end where it touches it: 4 dB of an echo of -17 dB re 1 m were wrong."""
    mesh = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.4, 0.6, 1.2]])
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.25, [0.0, 0.0, 1.0]))
    mesh.apply_translation([1.3 - mesh.bounds[0, 0], -0.25, 0.0])
    vertices = mesh.vertices.copy()
    vertices[corner, 0] += off_m
    moved = trimesh.Trimesh(vertices, mesh.faces, process=False)
    place = Pose([0.0, 0.0, 1.2], held_rotation(0.0, pitch_rad=0.5, roll_rad=0.1))
    ours, exact = echo_on_ground(moved, place), echo_on_ground(mesh, place)
    assert np.abs(ours - exact).max() < 0.1 * np.abs(exact).max()


@pytest.mark.parametrize("make", [frustum, _panels, _bench])
def test_loose_triangles_whose_corners_agree_to_a_micrometre_are_the_body_that_they_close(make, rng):
    """Each was a sheet on its own: a box had false echoes of -21 dB re 1 m, and 1280 triangles of a ball took 9 GB."""
    mesh = make().apply_translation([1.4, 0.13, 0.0])
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    loose = corners + rng.uniform(-1e-6, 1e-6, corners.shape)
    soup = trimesh.Trimesh(loose, np.arange(len(loose)).reshape(-1, 3), process=False)
    exact = echo_on_ground(mesh)
    assert np.abs(echo_on_ground(soup) - exact).max() < 0.1 * np.abs(exact).max()


@pytest.mark.parametrize("draw", range(4))
def test_a_bench_of_corners_a_fifth_of_a_millimetre_off_echoes_as_the_bench(draw):
    """Cause: each half of a face was a mirror of its own: 0.4 of the echo were wrong."""
    rng = np.random.default_rng(draw)
    bench = _bench().apply_transform(trimesh.transformations.rotation_matrix(rng.uniform(-0.6, 0.6), [0.0, 0.0, 1.0]))
    aside_m = rng.uniform(-0.3, 0.3) - bench.bounds[:, 1].mean()
    bench.apply_translation([1.3 - bench.bounds[0, 0], aside_m, 0.0])
    off = bench.vertices + rng.uniform(-2e-4, 2e-4, bench.vertices.shape)
    place = Pose([0.0, 0.0, 1.2], held_rotation(0.0, pitch_rad=0.5, roll_rad=0.1))
    ours, exact = (echo_on_ground(trimesh.Trimesh(v, bench.faces, process=False), place) for v in (off, bench.vertices))
    assert np.abs(ours - exact).max() < 0.1 * np.abs(exact).max()
