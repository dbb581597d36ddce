"""One large wall: near and far, far from the origin, at grazing incidence, small, and with microphones near and far."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cells.probes.extremes.mirrors import (
    AHEAD,
    MICS_M,
    SPEAKER_M,
    against,
    echoes,
    image_lengths_m,
    length_m,
    moved,
    slab,
    wall,
)  # fmt: skip
from benchmarks.cells.probes.extremes.verdict import Errors
from simulator import Phone, Pose
from simulator.scene.pose import held_rotation

MIRRORS = ("specular",)
ORIGIN = np.zeros(3)


def wall_distance(distance_m: float) -> Errors:
    """A wall beside the phone, which lies along it."""
    along = Pose(ORIGIN, held_rotation(0.5 * np.pi))
    found = echoes([wall(distance_m)], along, 3.0 * distance_m + 1.0)
    image = np.array([2 * np.longdouble(distance_m), SPEAKER_M[1], 0])
    places = np.array([[0.0, mic[1], 0.0] for mic in MICS_M])
    return against(found, [0, 1], length_m(places - image))


def wall_offset(offset_m: float, yaw_rad: float) -> Errors:
    """A wall 1.5 m ahead, rotated with the phone and moved: the vertices round to 6e-11 m at 1e6 m."""
    turn, shift = Rotation.from_euler("z", yaw_rad), np.array([offset_m, -offset_m, 0.5 * offset_m])
    found = echoes([moved(wall(1.5), shift, turn)], Pose(shift, turn * AHEAD), 5.0)
    return against(found, [0, 1], image_lengths_m(1.5))


def grazing(angle_rad: float) -> Errors:
    """A speaker and two microphones 1 m apart along a floor, the reflection leaving it at this angle."""
    height = 0.5 * np.tan(angle_rad)
    phone = Phone.ideal(ORIGIN, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    floor = slab([-100.0, -100.0, -1.0], [100.0, 100.0, 0.0], "floor")
    found = echoes([floor], Pose(np.array([0.0, 0.0, height]), AHEAD), 10.0, phone, MIRRORS)
    return against(found, [0, 1], length_m([[1.0, 0.0, 2.0 * height]] * 2))


def microphone_distance(gap_m: float) -> Errors:
    """A microphone this close to the speaker or this far from it, a wall 1.5 m ahead of the farther of both."""
    mics = [[0.0, gap_m, 0.0], [0.0, -0.1, 0.0]]
    distance = 1.5 + gap_m
    found = echoes([wall(distance)], Pose(ORIGIN, AHEAD), 3.0 * distance, Phone.ideal(ORIGIN, mics), MIRRORS)
    return against(found, [0, 1], image_lengths_m(distance, ORIGIN, mics))


def wall_size(size_m: float, aside_m: float) -> Errors:
    """A square plate 1.5 m ahead: a mirror where the geometric reflection meets it, else none (edges left out)."""
    half = 0.5 * size_m
    plate = slab([1.5, aside_m - half, -half], [1.5 + min(0.1, half), aside_m + half, half])
    found = echoes([plate], Pose(ORIGIN, AHEAD), 5.0, mechanisms=MIRRORS)
    if abs(aside_m) > half:  # speaker and microphones lie on the x axis, and so does every mirror point
        return against(found, [], image_lengths_m(1.5)[:0])
    return against(found, [0, 1], image_lengths_m(1.5))
