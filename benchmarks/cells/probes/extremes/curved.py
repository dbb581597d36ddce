"""Spheres against the stationary path on the exact sphere, and the hollow ones whose echoes have a caustic."""

from __future__ import annotations

import math

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from benchmarks.cells.probes.extremes.mirrors import AHEAD, Long, against, echoes, length_m, moved, wall
from benchmarks.cells.probes.extremes.verdict import Error, Errors
from obstaclewatch.support.arrays import Floats
from simulator import Material, Obstacle, Phone, Pose

LIMITS = (0.15, 0.1)
"""Samples and dB: what triangles of a sphere may cost."""
CURVED = ("curved",)


def ball_radius(radius_m: float) -> Errors:
    """A sphere whose surface is 1.5 m ahead."""
    return _echo(radius_m, np.array([1.5 + radius_m, 0.0, 0.0]), np.array([0.0, 0.07, 0.0]), np.zeros(3), 0.0)


def ball_incidence(angle_rad: float) -> Errors:
    """A sphere of 0.3 m, a microphone so far aside that the reflection meets it at this angle, up to 89.95 degrees.

    Beyond 85 degrees the path is within a wavelength of the direct one, where no ray tells all of the field: what is
    judged is that the ray is found and is exact.
    """
    speaker_to_ball, radius = 1.5, 0.3
    bend = 2.0 * angle_rad  # the reflection leaves the sphere's point of incidence rotated by this
    point = np.array([speaker_to_ball, 0.0, 0.0])
    normal = np.array([-math.cos(angle_rad), math.sin(angle_rad), 0.0])
    mic = point + speaker_to_ball * np.array([-math.cos(bend), math.sin(bend), 0.0])
    return _echo(radius, point - radius * normal, mic, np.zeros(3), 0.0)


def ball_offset(offset_m: float, yaw_rad: float) -> Errors:
    """A sphere of 0.2 m ahead, all of it rotated and moved."""
    shift = np.array([offset_m, -offset_m, 0.5 * offset_m])
    return _echo(0.2, np.array([1.5, 0.4, 0.1]), np.array([0.0, 0.07, 0.0]), shift, yaw_rad)


def ball_and_wall_offset(offset_m: float) -> Errors:
    """A sphere before a wall, moved: as many paths, of one and two bounces, as at the origin."""
    shift, still = np.array([offset_m, -offset_m, 0.5 * offset_m]), Rotation.identity()
    ball = Obstacle(trimesh.creation.icosphere(3, 0.2), Material.rigid(), "ball")
    things = [wall(1.55), moved(ball, np.array([1.2, 0.5, 0.0]), still)]
    counts = [
        len(echoes([moved(thing, by, still) for thing in things], Pose(by, AHEAD), 6.0, max_order=2))
        for by in (np.zeros(3), shift)
    ]
    return {"echoes": Error(float(counts[1] - counts[0]), 0.5)}


def hollow(offset_m: float) -> Errors:
    """A phone this far from the centre of a hollow sphere of 2 m with a gap: a caustic, where rays are infinite."""
    bowl = trimesh.creation.icosphere(4, 2.0)
    kept = bowl.triangles_center[:, 0] > 0.0
    mesh = trimesh.Trimesh(bowl.vertices, bowl.faces[kept][:, ::-1], process=False)
    found = echoes([Obstacle(mesh, Material.rigid(), "bowl")], Pose(np.array([offset_m, 0.0, 0.0]), AHEAD), 6.0)
    focused = float(np.abs(found.gain).max(initial=0.0)) if np.isfinite(found.gain).all() else math.inf
    # 2 pi a^2 of bowl at distance a: no more than all its Huygens sources in phase, k a^2 / a^2 = k = 421 / m at 23 kHz
    return {"pressure": Error(focused, 2.0 * math.pi * 23_000.0 / 343.0)}


def _echo(radius_m: float, centre_m: Floats, mic_m: Floats, shift_m: Floats, yaw_rad: float) -> Errors:
    """Errors of a sphere's echo at a microphone (world axes, phone at the origin), rotated and moved as one."""
    turn = Rotation.from_euler("z", yaw_rad)
    fine = trimesh.creation.icosphere(4, radius_m)
    ball = moved(Obstacle(fine, Material.rigid(), "ball"), centre_m, Rotation.identity())
    other = np.array([0.0, 0.0, 10.0])  # the second microphone is out of the way
    local = [AHEAD.inv().apply(place) for place in (mic_m, other)]
    phone = Phone.ideal(np.zeros(3), local)
    found = echoes([moved(ball, shift_m, turn)], Pose(shift_m, turn * AHEAD), 50.0, phone, CURVED)
    length, level = stationary(radius_m, centre_m, mic_m)
    return against(found[found.mic == 0], [0], np.array([length]), np.array([level]), limits=LIMITS)


def stationary(radius_m: float, centre_m: Floats, mic_m: Floats) -> tuple[Long, Long]:
    """Length and pressure of the path from the origin by a rigid sphere: bisection, then Keller's ray tube.

    In the plane of speaker, centre and microphone the point of incidence lies between their directions, where the two
    angles with the normal are equal; 120 halvings leave nothing of an interval.
    """
    centre, mic = (np.asarray(place, dtype=np.longdouble) for place in (centre_m, mic_m))
    to_speaker, to_mic = -centre / length_m(centre), (mic - centre) / length_m(mic - centre)
    cosine = np.clip((to_speaker * to_mic).sum(), -1, 1)
    side = to_mic - cosine * to_speaker
    side = side / length_m(side) if length_m(side) > 0 else side
    low, high = np.longdouble(0), np.arccos(cosine)
    for _ in range(120):
        middle = (low + high) / 2
        normal = np.cos(middle) * to_speaker + np.sin(middle) * side
        point = centre + np.longdouble(radius_m) * normal
        leave, arrive = -point / length_m(point), (mic - point) / length_m(mic - point)
        low, high = (middle, high) if (leave * normal).sum() > (arrive * normal).sum() else (low, middle)
    r_i, r_r, cos_t = length_m(point), length_m(mic - point), (leave * normal).sum()
    rho_1, rho_2 = 1 / (1 / r_i + 2 / (radius_m * cos_t)), 1 / (1 / r_i + 2 * cos_t / radius_m)
    return r_i + r_r, np.sqrt(rho_1 * rho_2 / ((rho_1 + r_r) * (rho_2 + r_r))) / r_i
