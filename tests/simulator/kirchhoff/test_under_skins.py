"""A body just under another one, as skin under a coat, adds nothing to the echo.

Cause: the rounded surface stands off its mesh, and light was asked for from beyond both. What lay over a facet by less
than that hid nothing of it, and both surfaces echoed: 4.5 to 6 dB too loud at every level, 2 dB with 1 cm between them.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

HZ = np.linspace(18e3, 23e3, 41)
PHONE = Phone.ideal(np.zeros(3), [[0.02, 0.0, 0.0], [0.0, -0.02, 0.0]])
WALKING = (0.7, 0.2, 0.0)


def post(radius_m: float) -> trimesh.Trimesh:
    mesh = trimesh.creation.cylinder(radius_m, 1.6, sections=48)
    mesh.apply_translation([2.2, 0.3, 0.8])
    return mesh


def torso(under_m: float) -> trimesh.Trimesh:
    """An uneven body, or one that lies under it everywhere."""
    mesh = trimesh.creation.icosphere(subdivisions=4)
    x, y, z = mesh.vertices.T
    mesh.vertices *= (1.0 + 0.08 * np.sin(5.0 * x + 2.0) * np.sin(6.0 * y) * np.cos(7.0 * z))[:, None]
    mesh.vertices = mesh.vertices * [0.15, 0.22, 0.5] + [1.8, 0.1, 1.2]
    return trimesh.Trimesh(mesh.vertices - under_m * mesh.vertex_normals, mesh.faces)


def echo(level: str, *meshes: trimesh.Trimesh, velocity_m_s: tuple[float, ...] = (0.0, 0.0, 0.0)) -> np.ndarray:
    """(2, K) spectra of all that meshes echo, an obstacle each."""
    bodies = [Obstacle(mesh, Material.rigid(), str(n), velocity_m_s=velocity_m_s) for n, mesh in enumerate(meshes)]
    pose = Pose([0.0, 0.0, 1.1], held_rotation(0.0))
    paths = trace_paths(Scene(bodies, Air.lossless(343.0)), PHONE, pose, Fidelity(level=level))
    return np.asarray(paths[paths.order > 0].transfer_function(HZ))


def differs_db(found: np.ndarray, expected: np.ndarray) -> float:
    return float(20.0 * np.log10(np.abs(found - expected).max() / np.abs(expected).max() + 1e-15))


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
@pytest.mark.parametrize("gap_m", [1e-4, 1e-3])
def test_a_post_in_a_sleeve(level, gap_m):
    assert differs_db(echo(level, post(0.1), post(0.1 - gap_m)), echo(level, post(0.1))) < -50.0


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize("gap_m", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("velocity_m_s", [(0.0, 0.0, 0.0), WALKING])
def test_a_body_in_a_coat(level, gap_m, velocity_m_s):
    """At rest, and walking in it."""
    coat, body = torso(0.0), torso(gap_m)
    alone = echo(level, coat, velocity_m_s=velocity_m_s)
    assert differs_db(echo(level, coat, body, velocity_m_s=velocity_m_s), alone) < -40.0
    assert differs_db(echo(level, body, coat, velocity_m_s=velocity_m_s), alone) < -40.0


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize("gap_m", [1e-4, 1e-3, 5e-3, 1e-2])
def test_both_in_one_mesh(level, gap_m):
    """From 4 mm on the body spoke for the coat and the coat for the body, in spots that held facets of both."""
    both = trimesh.util.concatenate([torso(0.0), torso(gap_m)])
    assert differs_db(echo(level, both), echo(level, torso(0.0))) < -20.0


@pytest.mark.parametrize("gap_m", [1e-4, 1e-3, 3e-3])
@pytest.mark.parametrize("meshes", [1, 2])
def test_a_coat_that_is_open_below(meshes, gap_m):
    """As clothes of modelled people are: sheets, in one mesh with the closed body or apart from it."""
    whole, body = torso(0.0), torso(gap_m)
    coat = trimesh.Trimesh(whole.vertices, whole.faces[whole.triangles_center[:, 2] > 0.75])
    worn = (coat, body) if meshes == 2 else (trimesh.util.concatenate([coat, body]),)
    assert differs_db(echo("standard", *worn), echo("standard", whole)) < -20.0


def test_what_stands_out_of_its_cover_echoes_there():
    """A post in a short sleeve: above it the post is as it was, and no less loud for it."""
    sleeve = trimesh.creation.cylinder(0.1, 0.5, sections=48)
    sleeve.apply_translation([2.2, 0.3, 0.25])
    found = np.abs(echo("standard", post(0.0995), sleeve)).mean()
    assert found == pytest.approx(np.abs(echo("standard", post(0.0995))).mean(), rel=0.1)
