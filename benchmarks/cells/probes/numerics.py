"""The simulator and the detector at the extremes, against formulas that share no code with them.

Each check takes its parameters and returns errors by name; what the numbers are relative to stands beside them. The
exact field of a large rigid wall is that of the image: delay L / c, pressure 1 / L relative to 1 m.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import trimesh

from benchmarks.cells.spec import Cell
from obstaclewatch import BeepDesign, PaperStandingDetector, PhoneGeometry, Recording
from obstaclewatch.signal.pulse import rms_bandwidth_hz
from obstaclewatch.support.arrays import Complexes, Floats
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, StraightWalk, render_walk, trace_paths
from simulator.paths import Paths
from simulator.scene.pose import held_rotation

Errors = dict[str, float]

SPEED_M_S = 343.0
FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 51)
SPEAKER_M = np.array([0.0, 0.04, 0.0])
MICS_M = np.array([[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
TRIALS = 60


def numerics_result(cell: Cell) -> dict[str, Any]:
    """The errors of the check that the cell names, as `result["numerics"]`.

    Raises:
        ValueError: an unknown check or parameter.
    """
    if cell.category not in CHECKS:
        raise ValueError(f"a numerics probe must be one of {sorted(CHECKS)}, got '{cell.category}'")
    begin = perf_counter()
    try:
        errors = CHECKS[cell.category](**cell.probe)
    except TypeError as error:
        raise ValueError(f"numerics probe '{cell.category}': {error}") from error
    cost = {"simulate_s": 0.0, "detect_s": {}, "recording_s": 0.0, "total_s": perf_counter() - begin}
    return {"truth": {}, "detectors": {}, "numerics": errors, "cost": cost}


def wall_distance(distance_m: float) -> Errors:
    """A rigid wall from 1 cm to 1 km beside the phone, which lies along it, against its image."""
    pose = Pose(np.zeros(3), held_rotation(0.5 * np.pi))
    found = _echoes(Scene([_wall(distance_m)], Air.lossless(SPEED_M_S)), pose, distance_m)
    return _against_image(found, _length(pose, distance_m))


def wall_offset(offset_m: float) -> Errors:
    """A wall and a ball 1.5 m ahead, all of it moved far from the origin: the field must stay what it is.

    The vertices themselves round to 6e-11 m at 1e6 m, which is 2e-8 of the field.
    """
    move = np.array([offset_m, -offset_m, 0.0])
    fields = []
    for shift in (np.zeros(3), move):
        ball = trimesh.creation.icosphere(3, 0.2)
        ball.apply_translation(np.array([1.2, 0.5, 0.0]) + shift)
        things = [_wall(1.5, shift), Obstacle(ball, Material.rigid(), "ball")]
        pose = Pose(shift, held_rotation(0.0))
        found = _echoes(Scene(things, Air.lossless(SPEED_M_S)), pose, 5.0)
        fields.append(found.transfer_function(FREQUENCY_HZ))
    return {"field": _relative(fields[1], fields[0])}


def grazing(angle_rad: float) -> Errors:
    """A source and a microphone 1 m apart along a wall, the reflection leaving it at this angle."""
    height = 0.5 * np.tan(angle_rad)
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    floor = trimesh.creation.box((200.0, 200.0, 1.0))
    floor.apply_translation([0.0, 0.0, -0.5])
    pose = Pose(np.array([0.0, 0.0, height]), held_rotation(0.0))
    scene = Scene([Obstacle(floor, Material.rigid(), "floor")], Air.lossless(SPEED_M_S))
    paths = trace_paths(scene, phone, pose, fidelity=Fidelity(max_order=1, max_range_m=10.0, mechanisms=("specular",)))
    return _against_image(paths[paths.order == 1], np.full(2, np.hypot(1.0, 2.0 * height)))


def slivers(aspect: float) -> Errors:
    """A wall cut by slivers this many times longer than wide, one of them where the echo leaves it."""
    length = 8.0
    cuts = np.array([-length / 2, 0.0, length / aspect, 1.0, 1.0 + length / aspect, length / 2])
    vertices = np.array([[1.5, y, z] for z in (-length / 2, length / 2) for y in cuts])
    count = len(cuts)
    faces = [f for k in range(count - 1) for f in ([k, k + count, k + 1], [k + 1, k + count, k + count + 1])]
    wall = Obstacle(trimesh.Trimesh(vertices, faces, process=False), Material.rigid(), "wall")
    pose = Pose(np.zeros(3), held_rotation(0.0))
    found = _echoes(Scene([wall], Air.lossless(SPEED_M_S)), pose, 1.5)
    return _against_image(found, _length(pose, 1.5))


def coincident(gap_m: float) -> Errors:
    """A microphone this close to the speaker: direct sound 1 / gap, and the wall's echo as if nothing were odd."""
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, gap_m, 0.0], [0.0, -0.1, 0.0]])
    scene = Scene([_wall(1.5)], Air.lossless(SPEED_M_S))
    fidelity = Fidelity(max_order=1, max_range_m=5.0, mechanisms=("specular",))
    paths = trace_paths(scene, phone, Pose(np.zeros(3), held_rotation(0.0)), fidelity=fidelity)
    direct = paths[(paths.order == 0) & (paths.mic == 0)]
    echo = _against_image(paths[paths.order == 1], np.array([3.0 - gap_m, 3.1]))
    return echo | {"direct_level": float(abs(np.abs(direct.gain).sum() * gap_m - 1.0))}


def temperature(temperature_c: float) -> Errors:
    """A wall at 3 m in real air, against 2 d / c and the air's own absorption over that path."""
    air, pose = Air(temperature_c=temperature_c), Pose(np.zeros(3), held_rotation(0.0))
    found = _echoes(Scene([_wall(3.0)], air), pose, 3.0)
    length = _length(pose, 3.0)
    level = 10.0 ** (-air.absorption_db_m(20_000.0) * length / 20.0)
    dry = 331.45 * np.sqrt(1.0 + temperature_c / 273.15)  # dry air; half-humid air is up to 1.7 % faster at 60 C
    return _against_image(found, length, level, air.sound_speed_m_s) | {
        "speed_over_dry": float(air.sound_speed_m_s / dry - 1.0)
    }


def sample_rate(sample_rate_hz: float) -> Errors:
    """One beep off a wall at 1.5 m, rendered at this rate, against the beep's formula at the retarded times."""
    beep = BeepDesign(18_000.0, 21_500.0, sample_rate_hz=sample_rate_hz)
    scene, fidelity = Scene([_wall(1.5)], Air.lossless(SPEED_M_S)), Fidelity(max_order=1, mechanisms=("specular",))
    phone = Phone.ideal(SPEAKER_M, MICS_M)
    still = StraightWalk(np.zeros(3), 0.0, 0.0, beep.period_s)
    rendered = render_walk(scene, phone, still, beep, fidelity=fidelity).samples / phone.full_scale_gain
    time = np.arange(rendered.shape[1]) / sample_rate_hz
    direct = np.linalg.norm(MICS_M - SPEAKER_M, axis=1)
    lengths = np.stack([direct, _length(still.pose(0.0), 1.5)])
    expected = sum(beep.waveform(time - length[:, None] / SPEED_M_S) / length[:, None] for length in lengths)
    return {"samples": float(np.abs(rendered - expected).max() / np.abs(expected).max())}


def detector_snr(snr_db: float, seed: int = 0) -> Errors:
    """Standing points at 2 m under white noise of this 2E/N0: how often found, and the error against its bound."""
    beep, rng = BeepDesign(), np.random.default_rng(seed)
    phone = PhoneGeometry("ideal", SPEAKER_M, MICS_M)
    range_m = 2.0  # straight ahead of microphone 0
    point = MICS_M[0] + np.array([0.0, range_m, 0.0])
    lengths = np.stack([
        phone.speaker_to_mic_m, np.linalg.norm(point - SPEAKER_M) + np.linalg.norm(point - MICS_M, axis=1)
    ])  # fmt: skip
    block, echo = _beep_period(beep, lengths)
    noise = np.sqrt(np.sum(echo[0] ** 2) / 10.0 ** (snr_db / 10.0))
    samples = np.tile(block, TRIALS) + noise * rng.standard_normal((2, TRIALS * beep.period_samples))
    detector = PaperStandingDetector(beep, phone, sound_speed_m_s=SPEED_M_S)
    scale = 0.5 / np.abs(samples).max()
    recording = Recording((scale * samples).astype(np.float32), beep.sample_rate_hz)
    blocks = recording.samples.reshape(2, TRIALS, beep.period_samples)
    errors = [_nearest(detector.process(blocks[:, k], k * beep.period_s).range_m, range_m) for k in range(TRIALS)]
    near = np.array([e for e in errors if abs(e) < 0.05])
    bound = 0.5 * SPEED_M_S / (2.0 * np.pi * rms_bandwidth_hz(beep) * 10.0 ** (snr_db / 20.0))
    rms = float(np.sqrt(np.mean(near**2))) if len(near) else float("nan")
    return {"range_rms_m": rms, "bound_m": float(bound), "missed": 1.0 - len(near) / TRIALS}


CHECKS: dict[str, Callable[..., Errors]] = {
    "wall-distance": wall_distance,
    "wall-offset": wall_offset,
    "grazing": grazing,
    "slivers": slivers,
    "coincident": coincident,
    "temperature": temperature,
    "sample-rate": sample_rate,
    "detector-snr": detector_snr,
}
"""Name of a numerics probe to its check."""


def _wall(distance_m: float, shift_m: Floats | None = None) -> Obstacle:
    """A rigid slab across the x axis, so large that its rim does not matter for a mirror."""
    size = 20.0 * max(1.0, distance_m)
    slab = trimesh.creation.box((max(0.1, 0.01 * distance_m), size, size))
    slab.apply_translation([distance_m + 0.5 * max(0.1, 0.01 * distance_m), 0.0, 0.0])
    slab.apply_translation(np.zeros(3) if shift_m is None else shift_m)
    return Obstacle(slab, Material.rigid(), "wall")


def _echoes(scene: Scene, pose: Pose, distance_m: float) -> Paths:
    fidelity = Fidelity(max_order=1, max_range_m=3.0 * distance_m + 1.0, mechanisms=("specular", "curved"))
    paths = trace_paths(scene, Phone.ideal(SPEAKER_M, MICS_M), pose, fidelity=fidelity)
    return paths[paths.order == 1]


def _length(pose: Pose, distance_m: float) -> Floats:
    """(2,) path from the speaker over the wall's image to each microphone."""
    speaker, mics = pose.to_world(SPEAKER_M).reshape(3), pose.to_world(MICS_M).reshape(2, 3)
    image = np.array([2.0 * distance_m - speaker[0], speaker[1], speaker[2]])
    return np.linalg.norm(mics - image, axis=1)


def _against_image(found: Paths, length_m: Floats, level: Floats | float = 1.0, speed_m_s: float = SPEED_M_S) -> Errors:
    """Greatest relative errors of delay and pressure, and how many echoes are missing or too many."""
    error = {"delay": float("nan"), "pressure": float("nan"), "echoes": float(abs(len(found) - 2))}
    if len(found) != 2 or set(found.mic.tolist()) != {0, 1}:
        return error
    order = np.argsort(found.mic)
    delay, gain = found.delay_s[order], np.abs(found.gain[order])
    return error | {
        "delay": float(np.abs(delay * speed_m_s / length_m - 1.0).max()),
        "pressure": float(np.abs(gain * length_m / level - 1.0).max()),
    }


def _relative(field: Complexes, reference: Complexes) -> float:
    return float(np.linalg.norm(field - reference) / np.linalg.norm(reference))


def _beep_period(beep: BeepDesign, ways_m: Floats) -> tuple[Floats, Floats]:
    """(2, n) samples of direct sound and one echo (second row of the lengths), and of the echo alone."""
    time = np.arange(beep.period_samples) / beep.sample_rate_hz
    direct, echo = (beep.waveform(time - way[:, None] / SPEED_M_S) for way in ways_m)
    return 30.0 * direct + echo, echo


def _nearest(found_m: Floats, true_m: float) -> float:
    return float(found_m[np.argmin(np.abs(found_m - true_m))] - true_m) if len(found_m) else float("inf")
