"""Two curved reflections in one path against exact round bodies, limits, symmetries and motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from obstaclewatch import BeepDesign
from simulator import (
    Air,
    Fidelity,
    Material,
    Obstacle,
    Paths,
    Phone,
    Pose,
    Scene,
    StraightWalk,
    trace_paths,
    trace_rejected,
)
from simulator.render import trace_walk
from tests.references import meshes
from tests.references.two_bounces import Round, way_over

C = 343.0
ROUND = Fidelity(max_order=2, mechanisms=("curved",), edge_floor_db=-np.inf)
SPEAKER, MICS = np.array([0.0, 0.05, 0.0]), np.array([[0.0, 0.07, 0.02], [0.0, -0.07, 0.0]])


def _obstacle(body: Round, name: str, segments: int) -> Obstacle:
    if body.upright:
        mesh = meshes.tube(body.radius_m, 6.0, segments, 24)
    else:
        mesh = meshes.uv_sphere(body.radius_m, segments)
    mesh.apply_translation(body.center_m)
    return Obstacle(mesh, Material.rigid(), name)


def _twice(paths: Paths) -> Paths:
    """Those over two different bodies."""
    return paths[np.char.find(paths.obstacle, " > ") >= 0]


PAIRS = {
    "two spheres": (Round(np.array([1.5, 0.4, 0.1]), 0.2, False), Round(np.array([0.7, -1.1, -0.2]), 0.3, False)),
    "two poles": (Round(np.array([2.0, 0.5, 0.0]), 0.15, True), Round(np.array([1.2, -0.9, 0.0]), 0.25, True)),
    "pole and person": (Round(np.array([2.0, 0.1, 0.0]), 0.1, True), Round(np.array([-0.5, 0.05, 0.0]), 0.2, True)),
    "ball near a pole": (Round(np.array([1.4, 0.5, 0.3]), 0.1, False), Round(np.array([1.3, -0.1, 0.0]), 0.3, True)),
}


def _scene(pair: tuple[Round, Round], segments: int, *more: Obstacle) -> Scene:
    bodies = [_obstacle(body, name, segments) for body, name in zip(pair, "ab", strict=True)]
    return Scene([*bodies, *more], Air.lossless(C))


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS.keys())
@pytest.mark.parametrize("segments", [32, 96])
def test_ways_over_two_round_bodies(pair, segments):
    pose = Pose(np.zeros(3), Rotation.identity())
    paths = _twice(trace_paths(_scene(pair, segments), Phone.ideal(SPEAKER, MICS), pose, ROUND))
    assert sorted(zip(paths.obstacle.tolist(), paths.mic.tolist(), strict=True)) == [
        ("a > b", 0), ("a > b", 1), ("b > a", 0), ("b > a", 1),
    ]  # fmt: skip
    assert set(paths.kind) == {"mixed"}
    assert set(paths.order) == {2}
    for k in range(4):
        first, second = pair if paths.obstacle[k] == "a > b" else pair[::-1]
        points, level = way_over(first, second, SPEAKER, MICS[paths.mic[k]])
        # the interpolated surface stands off the true one by a (2 pi / segments)^4 / 256: 2e-6 m at 32
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert abs(paths.delay_s[k] * C - length) < 2e-5 * (32 / segments) ** 4
        np.testing.assert_allclose(paths.points_m[k], points, atol=1e-4 * (32 / segments) ** 3)
        assert abs(20.0 * np.log10(abs(paths.gain[k]) / level)) < 5e-4


def test_ground_before_and_after_mirrors_speaker_and_microphone(box):
    # between two upright bodies the ground is met between them, which is left out; spheres send sound down as well
    pair = PAIRS["two spheres"]
    ground = box((20.0, 20.0, 0.2), (0.0, 0.0, -1.3), "ground")
    fidelity = Fidelity(max_order=3, mechanisms=("specular", "curved"), edge_floor_db=-np.inf)
    pose = Pose(np.zeros(3), Rotation.identity())
    paths = trace_paths(_scene(pair, 96, ground), Phone.ideal(SPEAKER, MICS), pose, fidelity)
    below = np.array([1.0, 1.0, -1.0]), np.array([0.0, 0.0, -2.4])
    for name, first, second in (("a > b", *pair), ("b > a", *pair[::-1])):
        for mic in range(2):
            ways = {f"ground > {name}": (SPEAKER * below[0] + below[1], MICS[mic]),
                    f"{name} > ground": (SPEAKER, MICS[mic] * below[0] + below[1])}  # fmt: skip
            for way, (source, receiver) in ways.items():
                there = np.flatnonzero((paths.obstacle == way) & (paths.mic == mic))
                assert len(there) == 1, way
                points, level = way_over(first, second, source, receiver)
                length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
                assert abs(paths.delay_s[there[0]] * C - length) < 1e-6
                assert abs(20.0 * np.log10(abs(paths.gain[there[0]]) / level)) < 5e-4


def _street(shift: np.ndarray, turn: Rotation) -> Scene:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn.as_matrix(), shift
    bodies = [_obstacle(body, name, 48) for body, name in zip(PAIRS["pole and person"], "ab", strict=True)]
    bodies.append(Obstacle(meshes.icosphere(0.15, 3).apply_translation([1.1, 0.8, 0.2]), Material.rigid(), "c"))
    for body in bodies:
        body.mesh.apply_transform(matrix)
    return Scene(bodies, Air.lossless(C))


def test_reciprocity_rigid_motion_and_repetition():
    frequency, still = np.linspace(18_000.0, 23_000.0, 7), Rotation.identity()
    here = _street(np.zeros(3), still)

    def heard(scene, speaker, mics, pose):
        return _twice(trace_paths(scene, Phone.ideal(speaker, mics), pose, ROUND)).transfer_function(frequency)

    pose = Pose(np.zeros(3), still)
    there = heard(here, SPEAKER, MICS, pose)
    assert (np.abs(there) > 0.0).all()
    np.testing.assert_array_equal(heard(here, SPEAKER, MICS, pose), there)
    back = heard(here, MICS[1], np.stack([MICS[0], SPEAKER]), pose)
    np.testing.assert_allclose(back[1], there[1], rtol=1e-9)
    shift, turn = np.array([1e6, -4e5, 3e5]), Rotation.from_euler("ZYX", [0.7, 0.3, -1.1])
    moved = heard(_street(shift, turn), SPEAKER, MICS, Pose(shift, turn))
    np.testing.assert_allclose(moved, there, rtol=1e-6, atol=1e-6 * np.abs(there).max())


def test_faint_ones_are_left_out_and_listed():
    scene, pose = _scene(PAIRS["two spheres"], 48), Pose(np.zeros(3), Rotation.identity())
    phone = Phone.ideal(SPEAKER, MICS)
    quiet = Fidelity(mechanisms=("curved",), edge_floor_db=-40.0)
    paths, rejected = trace_paths(scene, phone, pose, quiet), trace_rejected(scene, phone, pose, quiet)
    assert len(_twice(paths)) == 0
    assert paths.rejected["faint double bounce"] == 4
    assert sorted(rejected.obstacle.tolist()) == ["a > b", "a > b", "b > a", "b > a"]
    kept = _twice(trace_paths(scene, phone, pose, Fidelity(mechanisms=("curved",), edge_floor_db=-np.inf)))
    margin_db = rejected.level_db.mean() - 20.0 * np.log10(np.abs(kept.gain)).mean()
    assert 0.0 < margin_db < 4.0  # the product of two single bounces errs on the loud side
    assert len(_twice(trace_paths(scene, phone, pose, Fidelity(max_order=1, edge_floor_db=-np.inf)))) == 0


def test_ways_are_followed_through_a_beep():
    # both ends move: what leaves at t_e arrives after L(speaker(t_e), microphone(t_r)) / c, L over the exact bodies
    pair = PAIRS["ball near a pole"]
    walk = StraightWalk(np.array([-0.1, 0.1, 0.05]), 0.2, 1.4, 0.2, 0.3)
    phone, beep = Phone.ideal(SPEAKER, MICS), BeepDesign()
    paths, motion, _ = trace_walk(_scene(pair, 192), phone, walk, beep, ROUND)
    rows = np.flatnonzero(np.char.find(paths.obstacle, " > ") >= 0)
    assert len(rows) >= 4
    for k in rows[:: max(len(rows) // 6, 1)]:
        first, second = pair if paths.obstacle[k] == "a > b" else pair[::-1]
        for x in (-0.9, 0.1, 0.8):
            arrives = motion.middle_s[k] + x * motion.half_width_s
            delay = np.polynomial.chebyshev.chebval(x, motion.delay_s[k])
            source = walk.pose(arrives - delay).to_world(SPEAKER)[0]
            receiver = walk.pose(arrives).to_world(MICS[paths.mic[k]])[0]
            points, level = way_over(first, second, source, receiver)
            length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
            assert abs(delay * C - length) < 2e-8
            strength = np.polynomial.chebyshev.chebval(x, motion.strength[k])
            ours = abs(paths.gain[k]) * strength * paths.delay_s[k] / delay
            assert abs(ours / level - 1.0) < 2e-4
