"""What a straight course lets both microphones read, and where it lies if it is read so: the formulas of `courses`.

H courses by K beeps, compiled; without Python's check of every divisor, several beeps are handled at once.

Shared arguments:
    height_m: (H,) phone above the reflecting point.
    radius_m: (H,) of the body in plan.
    miss_m: (H,) by which its middle is missed.
    cos_angle: (H,) of a wall's normal to the course; 1 for other things.
    stays: (H,) 1 where the reflecting point keeps its place while the phone bobs, 0 where it is as high as the phone.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEAREST_M = 0.05
"""Least distance, for a line that runs on behind the walker."""


@numba.njit(cache=True, error_model="numpy")
def steady_ranges(
    range_m: Array, lift_m: Array, surge_m: Array, height_m: Array, cos_angle: Array, stays: Array
) -> Array:
    """(H, K) ranges as a phone would read them that neither bobs nor surges, from (K,) readings and departures."""
    steady = np.empty((len(height_m), len(range_m)))
    for course in range(len(height_m)):
        height, forwards, share = height_m[course], cos_angle[course], stays[course]
        for beep in range(len(range_m)):
            down = height / range_m[beep]
            down = down if down < 1.0 else 1.0
            level = np.sqrt(1.0 - down * down) * forwards
            steady[course, beep] = range_m[beep] - share * down * lift_m[beep] + level * surge_m[beep]
    return steady


@numba.njit(cache=True, error_model="numpy")
def distances_ahead(range_m: Array, height_m: Array, radius_m: Array, miss_m: Array) -> Array:
    """(H, K) distances ahead at which a course is seen at ranges (H, K); the least one if it never is."""
    ahead = np.empty(range_m.shape)
    for course in range(len(range_m)):
        height2, miss2 = height_m[course] ** 2, miss_m[course] ** 2
        for beep in range(range_m.shape[1]):
            plan = np.sqrt(max(range_m[course, beep] ** 2 - height2, NEAREST_M**2)) + radius_m[course]
            ahead[course, beep] = np.sqrt(max(plan**2 - miss2, NEAREST_M**2))
    return ahead


@numba.njit(cache=True, error_model="numpy")
def as_seen(
    ahead_m: Array,
    pitch_rad: Array,
    lift_m: Array,
    height_m: Array,
    radius_m: Array,
    miss_m: Array,
    cos_angle: Array,
    stays: Array,
) -> tuple[Array, Array]:
    """(H, K) ranges and cosines of the cone, with obstacles (H, K) ahead of a phone pitched and lifted by (K,)."""
    range_m, cosine = np.empty(ahead_m.shape), np.empty(ahead_m.shape)
    cos_pitch, sin_pitch = np.cos(pitch_rad), np.sin(pitch_rad)
    for course in range(len(ahead_m)):
        miss2, radius, own_height = miss_m[course] ** 2, radius_m[course], height_m[course]
        forwards, share = cos_angle[course], stays[course]
        for beep in range(ahead_m.shape[1]):
            ahead, height = ahead_m[course, beep], own_height + share * lift_m[beep]
            middle = np.sqrt(ahead * ahead + miss2)
            plan = middle - radius
            plan = plan if plan > NEAREST_M else NEAREST_M
            level, slant = plan * ahead / middle * forwards, np.sqrt(plan * plan + height * height)
            range_m[course, beep] = slant
            cosine[course, beep] = (level * cos_pitch[beep] - height * sin_pitch[beep]) / slant
    return range_m, cosine


@numba.njit(cache=True, error_model="numpy")
def path_differences(range_m: Array, cosine: Array, separation_m: float) -> Array:
    """(H, K) from microphone 1, a phone's length behind microphone 0, less that from microphone 0."""
    difference = np.empty(range_m.shape)
    for course in range(len(range_m)):
        for beep in range(range_m.shape[1]):
            near = range_m[course, beep]
            far2 = near * (near + 2.0 * separation_m * cosine[course, beep]) + separation_m**2
            difference[course, beep] = np.sqrt(far2) - near
    return difference


@numba.njit(cache=True, error_model="numpy")
def mirrors_off(
    ahead_m: Array,
    range_m: Array,
    cosine: Array,
    pitch_rad: Array,
    miss_m: Array,
    cos_angle: Array,
    along_m2: Array,
    up_m2: Array,
) -> Array:
    """(H, K) what mirrors take off path differences, whose images are twice as far as points would be.

    Args:
        ahead_m: (H, K) distance ahead of the obstacle's middle.
        range_m, cosine: (H, K) as seen.
        pitch_rad: (K,) lift of the phone's top edge.
        along_m2, up_m2: (H,) times sin^2 / range of the phone's axis in the level plane, and in the upright one.
    """
    off = np.empty(range_m.shape)
    cos2_pitch = np.cos(pitch_rad) ** 2
    for course in range(len(range_m)):
        miss2, turned2 = miss_m[course] ** 2, 1.0 - cos_angle[course] ** 2
        along, up = along_m2[course], up_m2[course]
        for beep in range(range_m.shape[1]):
            aside2 = turned2 + miss2 / (ahead_m[course, beep] ** 2 + miss2) if miss2 > 0.0 else turned2
            level2 = cos2_pitch[beep] * aside2
            upright2 = 1.0 - cosine[course, beep] ** 2 - level2
            upright2 = upright2 if upright2 > 0.0 else 0.0
            off[course, beep] = (along * level2 + up * upright2) / range_m[course, beep]
    return off
