"""Flat faces that lean on a mirror: the crease that they make with their image there."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch.beep import BeepDesign
from simulator import Air, Fidelity, Material, Obstacle, Paths, Phone, Pose, Scene, StraightWalk, trace_paths
from simulator.render import trace_walk
from simulator.trace import still_tracing
from tests.references import chirp, leaning_face
from tests.references.leaning_face import Face

C = 343.0
WAVENUMBER = 2.0 * np.pi * chirp.GRID_HZ / C
SPEAKER, MIC = np.array([0.0, 0.0, 1.3]), np.array([0.03, 0.0, 1.32])
UNTURNED = Rotation.identity()
ON_A_WALL = Rotation.from_euler(
    "xyz", [90.0, 0.0, 37.0], degrees=True
)  # the ground stands up, the face lies on its side
ONE_CASE = Face(2.0, 0.9, 0.8, np.radians(1.0))


def _box(face: Face) -> trimesh.Trimesh:
    """A body with this front, upright elsewhere."""
    back = face.distance_m + 0.6 + max(face.height_m * np.tan(face.lean_rad), 0.0)
    corners = [
        (x, side * 0.5 * face.width_m, z)
        for z, side in product((0.0, face.height_m), (-1.0, 1.0))
        for x in (face.distance_m + z * np.tan(face.lean_rad), back)
    ]
    return trimesh.convex.convex_hull(np.array(corners))


def _ground() -> trimesh.Trimesh:
    corners = [(-20.0, -20.0, 0.0), (20.0, -20.0, 0.0), (20.0, 20.0, 0.0), (-20.0, 20.0, 0.0)]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def _scene(face: Face, turn: Rotation = UNTURNED, material: Material | None = None, **rest) -> Scene:
    pose = np.eye(4)
    pose[:3, :3] = turn.as_matrix()
    material = material or Material.rigid()
    meshes = {"ground": _ground(), "box": _box(face)}
    for mesh in meshes.values():
        mesh.apply_transform(pose)
    ground, box = (Obstacle(mesh, material, name) for name, mesh in meshes.items())
    return Scene([ground, Obstacle(box.mesh, material, "box", **rest)], Air.lossless(C))


def _paths(scene: Scene, speaker, mic, turn: Rotation = UNTURNED, time_s: float = 0.0, **fidelity) -> Paths:
    """What reaches the first microphone by way of the box."""
    phone = Phone.ideal([0.0, 0.0, 0.0], [turn.apply(mic - speaker), turn.apply(mic - speaker) + [0.0, 0.11, 0.0]])
    paths = trace_paths(scene, phone, Pose(turn.apply(speaker), UNTURNED), Fidelity(**fidelity), time_s)
    return paths[(paths.mic == 0) & (np.char.find(paths.obstacle, "box") >= 0)]


def _transfer(paths: Paths) -> np.ndarray:
    """(G,) sum of paths at the chirp's frequencies."""
    return (paths.gain_at(chirp.GRID_HZ) * np.exp(-1j * WAVENUMBER * C * paths.delay_s[:, None])).sum(axis=0)


def _peak(transfer: np.ndarray, face: Face, speaker, mic) -> tuple[float, float]:
    """Level in dB and path in m of the matched filter's peak near the path of the two images in an upright corner."""
    far = 2.0 * face.distance_m - speaker[0] - mic[0]
    path = np.linalg.norm([far, speaker[1] - mic[1], speaker[2] + mic[2]]) + np.linspace(-0.03, 0.03, 301)
    envelope = np.abs(np.exp(1j * np.outer(path, WAVENUMBER)) @ (chirp.beep_power() * transfer))
    return 20.0 * np.log10(envelope.max()), path[envelope.argmax()]


@cache
def _corner(face: Face) -> np.ndarray:
    """(G,) the line integral's echo at `MIC`, whatever way round all of it lies."""
    return leaning_face.by_edges(face, SPEAKER, MIC, WAVENUMBER)


@pytest.mark.parametrize("lean_deg", [-4.0, -1.0, -0.25, 0.25, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("turn", [UNTURNED, ON_A_WALL])
def test_corner_of_a_leaning_face_against_the_line_integral(lean_deg, turn):
    """Faces off the vertical by half a degree lost 24 dB, and gained 4 dB overhanging: their crease was no edge.

    What the reference lacks are order 3 (ground, face, ground), and edges that see none but other edges.
    """
    face = Face(2.0, 0.9, 0.8, np.radians(lean_deg))
    reference = _corner(face)
    expected_db, expected_m = _peak(reference, face, SPEAKER, MIC)
    level_db, path_m = _peak(_transfer(_paths(_scene(face, turn), SPEAKER, MIC, turn)), face, SPEAKER, MIC)
    assert level_db == pytest.approx(expected_db, abs=0.05)
    assert path_m == pytest.approx(expected_m, abs=5e-4)


@pytest.mark.parametrize("lean_deg", [-8.0, 3.0, 15.0, 28.0])
def test_a_concave_crease_within_one_body_is_that_of_a_face_on_the_ground(lean_deg):
    """Cause: only faces of two bodies made one. A star-shaped column jumped by -6 dB re a wall where a reflection runs
    into its valley."""
    face = Face(2.0, 0.9, 0.8, np.radians(lean_deg))
    slab, front = trimesh.creation.box(bounds=[[-20.0, -20.0, -1.0], [20.0, 20.0, 0.0]]), _box(face)
    parts = [Obstacle(mesh, Material.rigid(), name) for mesh, name in ((slab, "slab under the box"), (front, "box"))]
    whole = Obstacle(trimesh.util.concatenate([slab, front]), Material.rigid(), "box")
    apart, together = (_transfer(_paths(Scene(each, Air.lossless(C)), SPEAKER, MIC)) for each in (parts, [whole]))
    np.testing.assert_allclose(together, apart, atol=1e-9 * np.abs(apart).max())
    reference = _corner(face)
    expected_db, expected_m = _peak(reference, face, SPEAKER, MIC)
    level_db, path_m = _peak(together, face, SPEAKER, MIC)
    assert level_db == pytest.approx(expected_db, abs=0.2)
    assert path_m == pytest.approx(expected_m, abs=2e-3)


@pytest.mark.parametrize(("level", "lean_deg"), [("auto", -2.0), ("auto", 3.0), ("reference", 1.0)])
@pytest.mark.parametrize(
    ("place", "speaker", "mic"),
    [((1.1, 1.4, 1.5), (0.0, 0.2, 0.8), (0.05, 0.16, 0.75)), ((3.6, 0.5, 0.5), (0.0, -0.1, 1.5), (-0.02, -0.04, 1.5))],
)
def test_other_levels_distances_and_widths(level, lean_deg, place, speaker, mic):
    face, ends = Face(*place, np.radians(lean_deg)), (np.array(speaker), np.array(mic))
    expected_db, _ = _peak(leaning_face.by_edges(face, *ends, WAVENUMBER), face, *ends)
    level_db, _ = _peak(_transfer(_paths(_scene(face), *ends, level=level)), face, *ends)
    assert level_db == pytest.approx(expected_db, abs=0.15)


@pytest.mark.parametrize(("lean_deg", "worst_db"), [(0.5, 0.1), (2.0, 0.2)])
def test_line_integral_agrees_with_a_sum_over_the_faces(lean_deg, worst_db):
    """The references share no formula; Kirchhoff's errs by the wedge's bend, here up to 4 degrees."""
    face = Face(2.0, 0.9, 0.8, np.radians(lean_deg))
    some = WAVENUMBER[::10]
    edges, sums = (each(face, SPEAKER, MIC, some) for each in (leaning_face.by_edges, leaning_face.by_kirchhoff))
    path = np.linalg.norm([4.0 - MIC[0], 0.0, SPEAKER[2] + MIC[2]])
    level_db = [20.0 * np.log10(abs(np.mean(each * np.exp(1j * some * path)))) for each in (edges, sums)]
    assert level_db[0] == pytest.approx(level_db[1], abs=worst_db)


def test_lean_comes_in_smoothly():
    """From square to a lean that no mesh tells from square: the images part, the crease takes over from one of them.

    The level falls by 3.5 dB a degree: 1e-5 rad are worth 0.002 dB.
    """
    faces = [Face(2.0, 0.9, 0.8, lean) for lean in (0.0, -1e-5, -3e-7, -1e-9, 1e-9, 3e-7, 1e-5)]
    echoes = [_transfer(_paths(_scene(face), SPEAKER, MIC)) for face in faces]
    for echo in echoes[1:]:
        np.testing.assert_allclose(echo, echoes[0], atol=1e-3 * np.abs(echoes[0]).max())


def test_absorbing_crease_is_reciprocal():
    felt = Material.uniform("felt", 0.7)
    pairs = [_paths(_scene(ONE_CASE, material=felt), a, b, max_order=3) for a, b in ((SPEAKER, MIC), (MIC, SPEAKER))]
    there, back = (_transfer(paths) for paths in pairs)
    np.testing.assert_allclose(there, back, atol=1e-9 * np.abs(there).max())


def test_crease_moves_with_its_box():
    """A box that has slid over the ground echoes like one that was put there."""
    slid = _paths(_scene(ONE_CASE, velocity_m_s=(0.5, 0.0, 0.0)), SPEAKER, MIC, time_s=0.8)
    put = Face(ONE_CASE.distance_m + 0.4, *(0.9, 0.8, ONE_CASE.lean_rad))
    there = _paths(_scene(put), SPEAKER, MIC)
    assert len(slid) == len(there)
    np.testing.assert_allclose(np.sort(slid.delay_s), np.sort(there.delay_s), atol=1e-12)
    assert abs(slid.gain.sum() - there.gain.sum()) < 1e-9


def test_crease_is_followed_through_the_beep():
    """Apex, by symmetry, and ends stay where they are: the speaker is where it was at emission, the microphone not."""
    beep, phone = BeepDesign(), Phone.ideal([0.0, 0.0, 0.0], [[0.03, 0.0, 0.02], [0.03, 0.0, 0.12]])
    walk = StraightWalk(SPEAKER, 0.0, 1.0, 1.5 * beep.period_s)
    paths, motion, _ = trace_walk(_scene(ONE_CASE), phone, walk, beep, Fidelity())
    crease = np.flatnonzero((paths.order == 2) & (np.abs(paths.points_m[:, 1:3, 2]) < 1e-9).all(axis=1))
    assert len(crease) >= 2
    for row in crease:
        received, point = motion.middle_s[row], paths.points_m[row, 1]
        delay = np.polynomial.chebyshev.chebval(0.0, motion.delay_s[row])
        speaker = walk.pose([received - delay]).to_world(phone.geometry.speaker_m)[0]
        mic = walk.pose([received]).to_world(phone.geometry.mics_m)[0, paths.mic[row]]
        expected = np.linalg.norm(point - speaker) + np.linalg.norm(point - mic)
        assert delay * C == pytest.approx(expected, abs=1e-6)


def _creases(*obstacles: Obstacle) -> int:
    phone = Phone.ideal([0.0, 0.0, 0.0], [MIC - SPEAKER, MIC - SPEAKER + [0.0, 0.1, 0.0]])
    tracing = still_tracing(Scene(list(obstacles)), phone, Pose(SPEAKER, UNTURNED), np.zeros(1), Fidelity())
    return int((tracing.world.wedges.mirror >= 0).sum())


@pytest.mark.parametrize(
    ("lean_deg", "lifted_m", "creases"), [(1.0, 0.0, 1), (0.0, 0.0, 0), (1.0, 1e-3, 1), (1.0, 0.01, 0)]
)
def test_face_makes_a_crease_where_it_touches_at_an_angle(lean_deg, lifted_m, creases):
    """Three faces of the box are upright: they make none."""
    box = _box(Face(2.0, 0.9, 0.8, np.radians(lean_deg)))
    box.apply_translation([0.0, 0.0, lifted_m])
    bodies = [Obstacle(mesh, Material.rigid(), name) for name, mesh in (("ground", _ground()), ("box", box))]
    assert _creases(*bodies) == creases


def test_sunken_sheet_makes_a_crease_on_either_side_of_itself_and_of_a_sheet_of_ground():
    board = _ground()
    board.apply_scale(0.02)
    board.apply_transform(trimesh.transformations.rotation_matrix(1.4, (0.0, 1.0, 0.0)))
    board.apply_translation([2.0, 0.0, 0.3])
    bodies = [Obstacle(mesh, Material.rigid(), name) for name, mesh in (("ground", _ground()), ("board", board))]
    assert _creases(*bodies) == 4


@pytest.mark.parametrize("yaw_rad", [-1.4, 0.8, 1.2, 1.4])
def test_no_crease_is_lit_by_a_face_that_it_lies_behind(yaw_rad):
    """Cause: over its own mirror a crease was lit whatever came before: off the side of a leaning plate, behind which
    it begins, and in one sense alone (-37 dB re 1 m, 4.3 dB of the plate's echo)."""
    plate, turned = trimesh.creation.box((0.02, 0.6, 1.0)), trimesh.transformations.rotation_matrix
    plate.apply_transform(turned(yaw_rad, [0.0, 0.0, 1.0]) @ turned(-0.25, [0.0, 1.0, 0.0]))
    plate.apply_translation([1.9, 0.0, -plate.bounds[0, 2]])
    rigid = Material.rigid()
    scene = Scene([Obstacle(_ground(), rigid, "ground"), Obstacle(plate, rigid, "box")], Air.lossless(C))
    aside = SPEAKER + [0.03, 0.08, 0.02]
    there, back = (_transfer(_paths(scene, *ends)) for ends in ((SPEAKER, aside), (aside, SPEAKER)))
    assert np.abs(there).max() > 1e-3
    np.testing.assert_allclose(back, there, atol=1e-9)
