"""What cannot be simulated is refused with the value and the rule, before it becomes silence or NaN."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch import BeepDesign, PaperDetector, Recording
from scenes import load_scene, make_approach
from simulator import (
    Air,
    Fidelity,
    Material,
    Obstacle,
    Phone,
    Pose,
    Scene,
    StraightWalk,
    held_rotation,
    render_walk,
    trace_paths,
)

BOX = trimesh.creation.box((1.0, 1.0, 1.0), trimesh.transformations.translation_matrix((3.0, 0.0, 0.0)))
RIGID = Material.rigid()
NOWHERE = Rotation.identity()


def _rendered(walk=None, **rest):
    walk = walk or StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, 0.1)
    return render_walk(Scene([]), Phone.named("ideal"), walk, BeepDesign(), **rest)


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda: Obstacle(trimesh.Scene(BOX), RIGID, "box"), r"must be a trimesh.Trimesh, got Scene; its to_mesh\(\)"),
        (lambda: Obstacle(None, RIGID, "box"), "must be a trimesh.Trimesh, got NoneType"),
        (lambda: Obstacle(BOX, "brick", "box"), r"must be a Material, as Material.named\(...\), got 'brick'"),
        (lambda: Obstacle(BOX, RIGID, ""), "name of an obstacle must be a word or more, got ''"),
        (lambda: Obstacle(BOX, RIGID, "a > b"), "name of an obstacle must not hold ' > ', .*, got 'a > b'"),
        (lambda: Obstacle(BOX, RIGID, "> b"), "name of an obstacle must not hold ' > ', .*, got '> b'"),
        (
            lambda: replace(Phone.named("ideal"), noise_spl_db=np.nan),
            "noise_spl_db must be finite, within .* or -inf, got nan",
        ),
        (
            lambda: replace(Phone.named("ideal"), level_spl_db=-np.inf),
            "level_spl_db must be finite, within .* dB, got -inf",
        ),
        (lambda: Pose(np.zeros((0, 3)), NOWHERE), r"shape \(3,\) or \(N, 3\), N > 0"),
        (lambda: Pose([0.0, 0.0, 0.0], np.eye(3)), "rotation must be a scipy Rotation, got ndarray"),
        (lambda: Pose([0.0, 0.0, 0.0], Rotation.from_rotvec([np.nan, 0.0, 0.0])), "rotation must be finite, got .nan"),
        (lambda: Pose([0.0, 0.0, 0.0], NOWHERE, np.nan), "heading_rad must be finite"),
        (lambda: Pose([0.0, 0.0, 0.0], NOWHERE, [0.1, 0.2]), r"heading_rad must be finite with shape \(1,\)"),
        (lambda: StraightWalk([np.nan, 0.0, 1.3], 0.0, 1.0, 1.0), "start_m must be three finite numbers"),
        (lambda: StraightWalk([0.0, 1.3], 0.0, 1.0, 1.0), "start_m must be three finite numbers"),
        (
            lambda: StraightWalk([0.0, 0.0, 1.3], np.inf, 1.0, 1.0),
            "heading_rad must be in radians, finite and within .*, got inf",
        ),
        (
            lambda: StraightWalk([0.0, 0.0, 1.3], 0.0, 1.0, 1.0, np.nan),
            "pitch_rad must be in radians, finite and within .*, got nan",
        ),
        (lambda: Fidelity("auto", 0.0), "tolerance_db must be positive, got 0.0"),
        (lambda: Fidelity("auto", -1.0), "tolerance_db must be positive, got -1.0"),
        (lambda: Fidelity(max_order=True), "max_order must be a whole number from 0 to 8, got True"),
        (lambda: Air("20"), "temperature_c must be a number, got '20'"),
        (lambda: Air(relative_humidity=True), "relative_humidity must be a number, got True"),
        (lambda: Air(pressure_pa=[1e5, 1e5]), r"pressure_pa must be a number, got \[100000.0, 100000.0\]"),
        (lambda: Air(absorbs="no"), "absorbs must be of type bool, got 'no'"),
        (lambda: Air.lossless(None), "sound_speed_m_s must be a number, got None"),
        (lambda: Phone.named(None), "phone must be of type str, got None"),
        (lambda: Material.named(["brick"]), r"material must be of type str, got \['brick'\]"),
        (lambda: Scene(None), "obstacles must be of type Iterable, got None"),
        (lambda: Scene([BOX]), "obstacle must be of type Obstacle, got <trimesh"),
        (lambda: Scene([], 20.0), "air must be of type Air, got 20.0"),
        (lambda: StraightWalk([0.0, 0.0, 1.3], 0.0, "1", 1.0), "speed_m_s must be a number, got '1'"),
        (lambda: Fidelity(["auto"]), r"level must be of type str, got \['auto'\]"),
        (lambda: Fidelity("auto", "1"), "tolerance_db must be a number, got '1'"),
        (lambda: Fidelity(mechanisms="edges"), "mechanisms must be several of .*, got 'edges'"),
        (lambda: Fidelity(max_range_m="7"), "max_range_m must be a number, got '7'"),
        (lambda: BeepDesign("18000"), "start_hz must be a number, got '18000'"),
        (lambda: Recording(np.zeros((2, 5)), "192000"), "sample_rate_hz must be a number, got '192000'"),
        (lambda: PaperDetector(BeepDesign(), Phone.named("ideal")), "phone must be of type PhoneGeometry, got Phone"),
        (lambda: PaperDetector(None, Phone.named("ideal").geometry), "beep must be of type BeepDesign, got None"),
        (
            lambda: trace_paths(Scene([]), "ideal", Pose([0.0, 0.0, 0.0], NOWHERE)),
            "phone must be of type Phone, got 'ideal'",
        ),
        (lambda: trace_paths(Scene([]), Phone.named("ideal"), None), "pose must be of type Pose, got None"),
        (  # rows for 1e10 beeps filled the memory
            lambda: _rendered(walk=StraightWalk([0.0, 0.0, 0.0], 0.0, 0.0, 1e9)),
            r"the walk must last at most 14400 s, got 1e\+09 s",
        ),
        (lambda: _rendered(seed=1.5), "seed must be a whole number, 0 or more, got 1.5"),
        (lambda: _rendered(seed=None), "seed must be a whole number, 0 or more, got None"),
        (lambda: _rendered(fidelity="auto"), "fidelity must be of type Fidelity, got 'auto'"),
        (lambda: _rendered(walk=Pose([0.0, 0.0, 0.0], NOWHERE)), "walk must be of type Walk, got Pose"),
        (lambda: load_scene("supermarket", seed=0.5), "seed must be a whole number, 0 or more, got 0.5"),
        (lambda: load_scene(None), "scene must be one of .*, got None"),
        (lambda: make_approach("campus", "wall", 0.5), "index must be a whole number, 0 or more, got 0.5"),
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
    named = f" with 'box' at {-wall:.1f} m/s$" if wall else "$"
    with pytest.raises(ValueError, match=f"less than 34.3 m/s, got up to {walking - wall:.1f} m/s{named}"):
        render_walk(scene, Phone.named("ideal"), walk, BeepDesign())


def test_whole_numbers_may_come_from_numpy():
    assert Fidelity(max_order=np.int64(2)) == Fidelity(max_order=2)
    assert type(Fidelity(max_order=np.int64(2)).max_order) is int


def test_one_heading_serves_all_poses():
    pose = Pose(np.zeros((3, 3)), held_rotation(0.0), 0.5)
    np.testing.assert_array_equal(pose.body_heading_rad(), [0.5, 0.5, 0.5])


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda: Pose("abc", NOWHERE), "position_m must be numbers, got 'abc'"),
        (lambda: Pose([[0.0, 1.3], [1.0]], NOWHERE), r"position_m must be numbers, got \[\[0.0, 1.3\], \[1.0\]\]"),
        (lambda: Pose([0.0, 0.0, 1.3], NOWHERE, "north"), "heading_rad must be numbers, got 'north'"),
        (lambda: StraightWalk("x", 0.0, 1.0, 1.0), "start_m must be numbers, got 'x'"),
        (lambda: Obstacle(BOX, RIGID, "box", velocity_m_s="fast"), "velocity_m_s of 'box' must be numbers, got 'fast'"),
        (lambda: Material("m", 20e3, 0.5), r"'m' must have one reflection per frequency, got shape \(\) for \(\)"),
        (lambda: Material("m", "brick", [0.5]), "frequency_hz of 'm' must be numbers, got 'brick'"),
        (lambda: Material("m", [20e3], [None]), r"normal_reflection of 'm' must be numbers, got \[None\]"),
        (lambda: Material("m", [20e3], [0.5], "rough"), "roughness_m must be a number, got 'rough'"),
        (lambda: Fidelity(mechanisms=[["specular"]]), r"mechanisms must be among .*, got \[\['specular'\]\]"),
        (lambda: _rendered(gated=None), r"gated must be several of the scene's obstacles, \[\], got None"),
        (lambda: _rendered(gated="wall"), r"gated must be several of the scene's obstacles, \[\], got 'wall'"),
        (lambda: _rendered(fidelity=0), "fidelity must be of type Fidelity, got 0"),
        (
            lambda: trace_paths(Scene([]), Phone.named("ideal"), Pose([0.0, 0.0, 0.0], NOWHERE), time_s=[0.0, 1.0]),
            r"time_s must be finite with shape \(1,\), got \[0.0, 1.0\]",
        ),
        (
            lambda: trace_paths(Scene([]), Phone.named("ideal"), Pose([0.0, 0.0, 0.0], NOWHERE), time_s="now"),
            "time_s must be numbers, got 'now'",
        ),
        (
            lambda: trace_paths(Scene([]), Phone.named("ideal"), Pose([0.0, 0.0, 0.0], NOWHERE), fidelity=""),
            "fidelity must be of type Fidelity, got ''",
        ),
    ],
)
def test_no_words_of_numpy_or_python_come_through(make, rule):
    """What could not be converted was numpy's error or a TypeError; 0 and "" were taken for the default fidelity."""
    with pytest.raises(ValueError, match=rule):
        make()
