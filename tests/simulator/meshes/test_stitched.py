"""A box one of whose facets is cut where its neighbour is not, as modellers leave it, is the box that it was.

Its mesh is not watertight, so it was read as sheets whose backs reflect, and the uncut edge as the borders of two of
them: edges lost their waves and paths came that are none, of up to -18 dB re 1 m. A sliver without area that bridges
the place was dropped, which opened the mesh again.
"""

from __future__ import annotations

import time

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.meshes.clean_meshes import cleaned
from simulator.meshes.stitched import stitched

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 11)
QUIET = 1e-3  # -60 dB re 1 m, 15 dB under a quiet street's noise
SEEDS = range(4)


def _box() -> trimesh.Trimesh:
    """A box whose front leans, on the ground."""
    box = trimesh.creation.box(bounds=[[1.4, -0.4, 0.0], [2.2, 0.4, 0.7]])
    box.vertices[box.vertices[:, 2] > 0.5, 0] += 0.1
    return box


def _cut(mesh: trimesh.Trimesh, rng: np.random.Generator, cuts: int, bridged: bool) -> trimesh.Trimesh:
    """The mesh with facets cut from a point on one of their edges, each with a sliver along that edge if bridged."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    for _ in range(cuts):
        row, share, new = rng.integers(len(faces)), rng.uniform(0.2, 0.8), len(vertices)
        a, b, c = np.roll(faces[row], rng.integers(3))
        vertices = np.concatenate([vertices, [share * vertices[a] + (1.0 - share) * vertices[b]]])
        added = [[a, new, c], [new, b, c], *([[a, b, new]] if bridged else [])]
        faces = np.concatenate([np.delete(faces, row, axis=0), added])
    return trimesh.Trimesh(vertices, faces, process=False)


def _echo(mesh: trimesh.Trimesh) -> np.ndarray:
    """(2, F) what comes back off it and the ground."""
    ground = trimesh.creation.box(bounds=[[-9.0, -9.0, -1.0], [9.0, 9.0, 0.0]])
    bodies = {"ground": ground, "box": mesh}
    scene = Scene([Obstacle(body, Material.named("concrete"), name) for name, body in bodies.items()])
    paths = trace_paths(scene, Phone.named("ideal"), Pose([0.0, 0.1, 1.2], held_rotation(0.1, pitch_rad=0.5)))
    return paths[paths.order > 0].transfer_function(FREQUENCY_HZ)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("bridged", [False, True])
def test_a_box_with_facets_cut_on_one_side_of_an_edge_echoes_as_the_box(seed: int, bridged: bool) -> None:
    cut = _cut(_box(), np.random.default_rng(seed), 5, bridged)
    np.testing.assert_allclose(_echo(cut), _echo(_box()), rtol=0.0, atol=QUIET)


@pytest.mark.parametrize("bridged", [False, True])
def test_it_is_closed_and_has_the_volume_that_it_had(bridged: bool) -> None:
    for seed in SEEDS:
        mesh, closed = cleaned(_cut(_box(), np.random.default_rng(seed), 20, bridged))
        assert closed
        assert mesh.volume == pytest.approx(_box().volume, rel=1e-12)


def test_a_mesh_with_an_opening_stays_as_it_is() -> None:
    """Only what is closed then is stitched."""
    lidless = _box()
    lidless.update_faces(lidless.face_normals[:, 2] < 0.5)
    cut = _cut(lidless, np.random.default_rng(0), 3, False)
    mesh, closed = cleaned(cut)
    assert not closed
    assert len(mesh.faces) == len(cut.faces)


def test_thousands_of_loose_triangles_are_read_at_once(rng):
    """Corners are looked for along free edges alone: asked of all within reach they took half a minute."""
    loose = trimesh.Trimesh(rng.random((9000, 3)), np.arange(9000).reshape(-1, 3), process=False)
    start_s = time.process_time()
    assert stitched(loose, 1e-5) is loose
    assert time.process_time() - start_s < 2.0
