"""What callers get wrong ends in one ValueError that names the argument, its rule and the value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import trimesh

from obstaclewatch import BeepDesign, PhoneGeometry, Recording
from simulator import (
    Air,
    Fidelity,
    Material,
    Obstacle,
    Phone,
    Pose,
    Scene,
    StraightWalk,
    StructureBorne,
    Transducer,
    held_rotation,
    render_walk,
    trace_paths,
)

BOX = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
HERE = Pose([0.0, 0.0, 1.3], held_rotation(0.0))
BEEP = BeepDesign()


def wall(**settings: Any) -> Obstacle:
    return Obstacle(**{"mesh": BOX, "material": Material.rigid(), "name": "wall"} | settings)


def paths(material: Material | None = None):
    scene = Scene([wall(material=material or Material.rigid())], Air.lossless(343.0))
    return trace_paths(scene, Phone.named("ideal"), HERE)


@dataclass
class Moving:
    """A walk by a function of time."""

    answer: Callable[[np.ndarray], Any]
    duration_s: Any = 0.2

    def pose(self, time_s):
        return self.answer(np.atleast_1d(time_s))


def walked(answer: Callable[[np.ndarray], Any], duration_s: Any = 0.2, **settings: Any) -> Recording:
    return render_walk(Scene([]), Phone.named("ideal"), Moving(answer, duration_s), BEEP, **settings)


def swaying(time_s: np.ndarray, size_m: float, rate_hz: float) -> Pose:
    place = np.zeros((len(time_s), 3))
    place[:, 0] = size_m * np.sin(2.0 * np.pi * rate_hz * time_s)
    return Pose(place, held_rotation(np.zeros(len(time_s))))


def still(time_s: np.ndarray) -> Pose:
    return swaying(time_s, 0.0, 1.0)


WRONG = {
    "position_m must be within 1e\\+09 m": lambda: Pose([1e12, 0.0, 0.0], held_rotation(0.0)),
    "point_m must be numbers, got 'a'": lambda: HERE.to_world("a"),
    r"point_m must have shape \(..., 3\), got \(2,\)": lambda: HERE.to_world([0.0, 1.0]),
    "point_m must be finite": lambda: HERE.to_world([0.0, 0.0, np.nan]),
    r"roll_rad must broadcast, got shapes \[\(2,\), \(3,\), \(\)\]": lambda: held_rotation([0, 1], [0, 1, 2]),
    "time_s must be numbers, got 'x'": lambda: StraightWalk([0, 0, 1], 0.0, 1.0, 1.0).pose("x"),
    r"time_s must have shape \(\) or \(N,\), got \(1, 2\)": lambda: StraightWalk([0, 0, 1], 0.0, 1.0, 1.0).pose(
        [[0, 1]]
    ),
    "duration_s must be a number, got 'x'": lambda: walked(still, "x"),
    "duration_s of the walk must be finite, got inf": lambda: walked(still, np.inf),
    "pose must be of type Pose, got None": lambda: walked(lambda time_s: None),
    "must give one pose for each of 2 times, got 1": lambda: walked(lambda time_s: still(time_s[:1])),
    "must close in at less than 34.4 m/s, got up to 5": lambda: walked(lambda time_s: swaying(time_s, 0.5, 20.0)),
    "must follow the phone within each beep to 0.3 mm": lambda: walked(lambda time_s: swaying(time_s, 5e-3, 20.0)),
    "seen must be a function of paths and a beep's number, got 3": lambda: walked(still, seen=3),
    "frequency_hz must be finite": lambda: paths().transfer_function([20e3, np.nan]),
    "frequency_hz must be numbers, got None": lambda: paths().transfer_function(None),
    r"frequency_hz must have shape \(\) or \(F,\)": lambda: paths().gain_at([[20e3]]),
    "other must be of type Paths, got 3": lambda: paths() + 3,
    "frequency_hz of 'm' must span 15000 to 25000": lambda: paths(Material("m", (18e3, 23e3), (0.5, 0.5))),
    "name must be of type str, got None": lambda: Material(None, (0.0, 1e9), (1.0, 1.0)),
    "frequency_hz must be numbers, got 'x'": lambda: Material.rigid().reflection("x", 1.0),
    "path_rad must not be negative, got -3": lambda: Material.named("brick").reflection(20e3, 1.0, -3.0),
    r"path_rad must broadcast, got shapes \[\(3,\), \(2,\)": lambda: Material.rigid().reflection([2e4] * 3, [1.0] * 2),
    "frequency_hz must be numbers, got 'f'": lambda: Air().absorption_db_m("f"),
    "category must be of type str, got None": lambda: wall(category=None),
    "must be a word or more, got '  '": lambda: wall(name="  "),
    "must not be 'case', which paths through": lambda: wall(name="case"),
    "must lie within 1e\\+09 m of the origin": lambda: wall(mesh=trimesh.creation.box([1e12] * 3)),
    "speaker_m must be numbers, got 'a'": lambda: Phone.ideal("a", np.zeros((2, 3))),
    "mics_m must be numbers, got ": lambda: PhoneGeometry("p", np.zeros(3), [[0, 0], [0, 0, 1]]),
    "level_spl_db must be finite, within \\+-300 dB, got 100000": lambda: replace(
        Phone.named("ideal"), level_spl_db=1e5
    ),
    "noise_spl_db must be finite, within \\+-300 dB or -inf": lambda: replace(Phone.named("ideal"), noise_spl_db=1e4),
    "response_db must be within \\+-300 dB": lambda: Transducer([2e4], [5000.0]),
    "rear_loss_db must be 0 to 300 dB": lambda: Transducer(rear_loss_db=1e5),
    "direction must be numbers, got 'x'": lambda: Transducer().directivity("x"),
    "frequency_hz must be finite, got nan": lambda: Transducer().response(np.nan),
    "delay_s must not be negative": lambda: StructureBorne([-1e-3, 0.0], [1.0, 1.0]),
    "obstacles must be of type Iterable, got array": lambda: Scene(np.array(1.0)),
    r"mechanisms must be several of .*, got array\(1.\)": lambda: Fidelity(mechanisms=np.array(1.0)),
    "mechanisms must be several of .*, got {}": lambda: Fidelity(mechanisms={}),
    "surface must be of type str, got array": lambda: wall(surface=np.zeros((3, 3))),
    "name of a material must be a word or more, got ''": lambda: Material("", (0.0, 1e9), (1.0, 1.0)),
    "name must be of type str, got 3": lambda: PhoneGeometry(3, np.zeros(3), [[0, 0, 0], [0, 0, 1]]),
    r"heading_rad must be within \+-1e\+06 rad, got 1e\+300": lambda: Pose(
        [0.0, 0.0, 1.3], held_rotation(0.0), heading_rad=1e300
    ),
    "a mask must have one truth value for each of 2 paths, got 1": lambda: paths()[:2][np.array([True])],
    "samples must be numbers, got 'x'": lambda: Recording("x", 192e3),
}


@pytest.mark.parametrize("rule", WRONG)
def test_what_is_wrong_is_named_with_its_rule(rule):
    with pytest.raises(ValueError, match=rule):
        WRONG[rule]()


def test_a_sound_through_the_case_may_leave_at_once():
    """Cause: its level is inverse to its delay, and every sample was NaN."""
    silent = replace(Phone.named("ideal"), noise_spl_db=-np.inf)
    phones = (silent, replace(silent, structure_borne=StructureBorne([0.0, 1e-4], [1.0, 0.5])))
    air, both = (render_walk(Scene([]), phone, Moving(still), BEEP).samples.astype(float) for phone in phones)
    time_s = np.arange(air.shape[1]) / BEEP.sample_rate_hz
    for mic, (delay_s, gain) in enumerate(((0.0, 1.0), (1e-4, 0.5))):
        expected = gain * sum(BEEP.waveform(time_s - delay_s - n * BEEP.period_s) for n in range(2))
        expected *= silent.full_scale_gain
        assert np.linalg.norm(both[mic] - air[mic] - expected) < 1e-4 * np.linalg.norm(expected)


def test_nan_of_a_rejected_path_stays_nan():
    """It is neither taken for a reflection nor refused: gains are found of all candidates at once."""
    brick = Material.named("brick")
    assert np.isnan(brick.reflection(20e3, np.nan))
    assert np.isnan(brick.reflection(20e3, 1.0, np.nan))


def test_a_mesh_that_is_moved_later_moves_no_wall():
    """It was kept by reference: the wall of a scene, and what was kept of its planes, went along."""
    mesh = BOX.copy()
    kept = wall(mesh=mesh)
    mesh.apply_translation([1.0, 0.0, 0.0])
    np.testing.assert_array_equal(kept.mesh.vertices, BOX.vertices)
