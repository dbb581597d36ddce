"""Meshes that are not closed, both sides of which reflect: where two faces meet they are one, as in a closed mesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths

FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 101)
NO_TURN = Rotation.identity()


def _echo(meshes, speaker_m, mics_m, level="standard") -> np.ndarray:
    """(2, F) of all that is not direct, of rigid bodies."""
    bodies = [Obstacle(mesh, Material.rigid(), f"body {n}") for n, mesh in enumerate(meshes)]
    scene, phone = Scene(bodies, Air.lossless(343.0)), Phone.ideal(speaker_m, mics_m)
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], NO_TURN), Fidelity(level=level))
    return paths[paths.order > 0].transfer_function(FREQUENCY_HZ)


def _off_db(one: np.ndarray, other: np.ndarray) -> float:
    """Largest rms difference over the band, dB re 1 m."""
    return float(10.0 * np.log10((np.abs(one - other) ** 2).mean(axis=1).max() + 1e-30))


def _without(box: trimesh.Trimesh, axis: int, side: float) -> trimesh.Trimesh:
    return trimesh.Trimesh(box.vertices, box.faces[side * box.face_normals[:, axis] < 0.5], process=False)


@pytest.mark.parametrize("level", ["standard", "auto"])
def test_a_box_on_the_ground_needs_no_bottom(level):
    """Cause: where two faces meet, either counted as ending for sound from both sides, and echoes faded out there."""
    box = trimesh.creation.box(bounds=[[-0.25, -0.3, 0.0], [0.25, 0.3, 0.8]])
    ground = trimesh.creation.box(bounds=[[-15.0, -15.0, -1.0], [15.0, 15.0, 0.0]])
    place = trimesh.transformations.rotation_matrix(0.31, [0, 0, 1])
    place[:2, 3] = 1.7, 0.13
    whole, bare = (mesh.apply_transform(place) for mesh in (box.copy(), _without(box, 2, -1.0)))
    ends = [0.0, 0.0, 1.23], [[0.02, 0.05, 1.24], [0.01, -0.08, 1.26]]
    assert _off_db(*(_echo([mesh, ground], *ends, level) for mesh in (whole, bare))) < -75.0


@pytest.mark.parametrize("degrees", [60.0, 100.0])
def test_a_folded_sheet_is_the_corner_of_two(degrees):
    """Cause: as above; of the wave of a corner of 100 degrees a third was left, and one of 60 degrees had one."""
    x, y = 6.0 * np.cos(np.deg2rad(degrees)), 6.0 * np.sin(np.deg2rad(degrees))
    corner = [[0, 0, -4], [6, 0, -4], [6, 0, 4], [0, 0, 4], [x, y, -4], [x, y, 4]]
    folded = trimesh.Trimesh(corner, [[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]], process=False)
    apart = [folded.submesh([each])[0] for each in ([0, 1], [2, 3])]
    ends = [0.8, 0.4, 0.0], [[0.82, 0.37, 0.05], [0.82, 0.37, 0.15]]
    assert _off_db(*(_echo(meshes, *ends) for meshes in ([folded], apart))) < -150.0


@pytest.mark.parametrize("step_m", [0.0, 1e-6])
@pytest.mark.parametrize("flaw", ["no back", "one triangle wound wrongly"])
def test_a_fold_seen_from_outside_reflects_once(flaw, step_m):
    """Cause: a path that meets two faces in the edge between them was one of two reflections, 5 dB over the box."""
    box = trimesh.creation.box(bounds=[[1.0, -0.3, -0.3], [1.5, 0.3, 0.3]])
    faces, back = box.faces.copy(), box.face_normals[:, 0].argmax()
    faces[back] = faces[back, ::-1]
    flawed = _without(box, 0, 1.0) if flaw == "no back" else trimesh.Trimesh(box.vertices, faces, process=False)
    ends = [0.0, 0.0, 0.0], [[0.0, 0.05, step_m], [0.0, -0.08, step_m]]
    assert _off_db(*(_echo([mesh], *ends) for mesh in (box, flawed))) < -50.0


@pytest.mark.parametrize("seed", range(6))
def test_a_phone_in_the_plane_of_a_side_has_the_same_echo_however_the_scene_lies(seed):
    """Cause: Embree takes a triangle in whose plane a ray runs for one in its way, well before the ray is there."""
    turn, echo = Rotation.random(random_state=seed), []
    mics = np.array([[0.05, 0.0, 0.02], [-0.05, 0.0, 0.05]])
    for each in (NO_TURN, turn):
        place = np.eye(4)
        place[:3, :3] = each.as_matrix()
        box = trimesh.creation.box(bounds=[[1.0, 0.0, -2.0], [1.3, 0.3, 2.0]]).apply_transform(place)
        echo.append(_echo([box], [0.0, 0.0, 0.0], each.apply(mics)))
    assert _off_db(*echo) < -120.0
