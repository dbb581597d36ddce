"""What cannot be simulated is refused with the value and the rule, before it becomes silence or NaN."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch.beep import BeepDesign
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, StraightWalk, held_rotation, render_walk

BOX = trimesh.creation.box((1.0, 1.0, 1.0), trimesh.transformations.translation_matrix((3.0, 0.0, 0.0)))
RIGID = Material.rigid()
NOWHERE = Rotation.identity()


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda: Obstacle(trimesh.Scene(BOX), RIGID, "box"), r"must be a trimesh.Trimesh, got Scene; its to_mesh\(\)"),
        (lambda: Obstacle(None, RIGID, "box"), "must be a trimesh.Trimesh, got NoneType"),
        (lambda: Obstacle(BOX, "brick", "box"), r"must be a Material, as Material.named\(...\), got 'brick'"),
        (lambda: Obstacle(BOX, RIGID, ""), "name of an obstacle must be a word or more, got ''"),
        (lambda: replace(Phone.named("ideal"), noise_spl_db=np.nan), "noise_spl_db must be finite or -inf, got nan"),
        (lambda: replace(Phone.named("ideal"), level_spl_db=-np.inf), "level_spl_db must be finite, got -inf"),
        (lambda: Pose(np.zeros((0, 3)), NOWHERE), r"shape \(3,\) or \(N, 3\), N > 0"),
        (lambda: Pose([0.0, 0.0, 0.0], np.eye(3)), "rotation must be a scipy Rotation, got ndarray"),
        (lambda: Pose([0.0, 0.0, 0.0], NOWHERE, np.nan), "heading_rad must be finite"),
        (lambda: Pose([0.0, 0.0, 0.0], NOWHERE, [0.1, 0.2]), r"heading_rad must be finite with shape \(1,\)"),
        (lambda: StraightWalk([np.nan, 0.0, 1.3], 0.0, 1.0, 1.0), "start_m must be three finite numbers"),
        (lambda: StraightWalk([0.0, 1.3], 0.0, 1.0, 1.0), "start_m must be three finite numbers"),
        (lambda: StraightWalk([0.0, 0.0, 1.3], np.inf, 1.0, 1.0), "heading_rad must be finite, got inf"),
        (lambda: StraightWalk([0.0, 0.0, 1.3], 0.0, 1.0, 1.0, np.nan), "pitch_rad must be finite, got nan"),
        (lambda: Fidelity("auto", 0.0), "tolerance_db must be positive, got 0.0"),
        (lambda: Fidelity("auto", -1.0), "tolerance_db must be positive, got -1.0"),
        (lambda: Fidelity(max_order=True), "max_order must be a whole number from 0 to 8, got True"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_refused(make, rule):
    with pytest.raises(ValueError, match=rule):
        make()


@pytest.mark.parametrize(("walking", "wall"), [(400.0, 0.0), (0.0, -500.0), (20.0, -20.0)])
def test_nothing_may_close_in_nearly_as_fast_as_sound(walking, wall):
    # Cause: retarded times did not settle, and the samples were made up.
    scene = Scene([Obstacle(BOX, RIGID, "box", velocity_m_s=[wall, 0.0, 0.0])], Air.lossless())
    walk = StraightWalk([0.0, 0.0, 0.0], 0.0, walking, 0.2)
    with pytest.raises(ValueError, match=f"close in at less than 34.3 m/s, got up to {walking - wall:.1f} m/s"):
        render_walk(scene, Phone.named("ideal"), walk, BeepDesign())


def test_whole_numbers_may_come_from_numpy():
    assert Fidelity(max_order=np.int64(2)) == Fidelity(max_order=2)
    assert type(Fidelity(max_order=np.int64(2)).max_order) is int


def test_one_heading_serves_all_poses():
    pose = Pose(np.zeros((3, 3)), held_rotation(0.0), 0.5)
    np.testing.assert_array_equal(pose.body_heading_rad(), [0.5, 0.5, 0.5])
