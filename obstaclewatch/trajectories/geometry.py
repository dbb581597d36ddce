"""What a straight trajectory lets both microphones read, and where it lies if it is read so: the formulas of
`posterior_grid`.

Each is of one trajectory at one beep; compiled loops over trajectories are vectorised. Single precision places
4 m to 0.2 um, a ten-thousandth of a cycle of the carrier.

Shared arguments, single precision:
    height_m: phone above the reflecting point.
    radius_m: of the body in plan.
    miss_m: by which its middle is missed.
    cos_angle: of a wall's normal to the trajectory; 1 for other things.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from obstaclewatch.support.arrays import Singles
from obstaclewatch.support.compiled import compiled, inlined

Single = np.float32

NEAREST_M = np.float32(0.05)
"""Least distance, for a line that runs on behind the walker."""
NONE, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)


class Bodies(NamedTuple):
    """What H trajectories lead to, (H,) each.

    Attributes:
        height_m, radius_m, miss_m, cos_angle: as above.
        stays: 1 where the reflecting point keeps its place while the phone bobs, 0 where it is as high as the phone.
        along_m2, up_m2: what a mirror takes off path differences, times sin^2 / range: in the level plane, and upright.
    """

    height_m: Singles
    radius_m: Singles
    miss_m: Singles
    cos_angle: Singles
    stays: Singles
    along_m2: Singles
    up_m2: Singles


@compiled
def bodies_at(table: Singles, ground_m: float) -> Bodies:
    """What a phone at that height has before it, from a (7, H) table of `Bodies` with corners infinitely far below."""
    height_m = np.minimum(table[0], np.float32(ground_m))
    return Bodies(height_m, table[1], table[2], table[3], table[4], table[5], table[6])


@inlined
def steady_range(read_m: Single, rise_m: Single, fore_aft_m: Single, height_m: Single, cos_angle: Single) -> Single:
    """Range as a phone would read it that moves neither up nor fore and aft; `rise_m` is 0 of what is as high as the
    phone."""
    down = min(height_m / read_m, ONE)
    return read_m - down * rise_m + np.sqrt(ONE - down * down) * cos_angle * fore_aft_m


@inlined
def distance_ahead(range_m: Single, height_m: Single, radius_m: Single, miss_m: Single) -> Single:
    """Distance ahead at which a trajectory is seen at that range; the least one if it never is."""
    plan = np.sqrt(max(range_m * range_m - height_m * height_m, NEAREST_M * NEAREST_M)) + radius_m
    return np.sqrt(max(plan * plan - miss_m * miss_m, NEAREST_M * NEAREST_M))


@compiled
def sight(
    ahead_m: Single, height_m: Single, radius_m: Single, miss_m: Single, cos_angle: Single
) -> tuple[Single, Single, Single]:
    """Range, distance in plan, and cosine of the level angle to the trajectory, of what is that far ahead."""
    middle = np.sqrt(ahead_m * ahead_m + miss_m * miss_m)
    plan = max(middle - radius_m, NEAREST_M)
    return np.sqrt(plan * plan + height_m * height_m), plan, ahead_m / middle * cos_angle


@compiled
def cone_cosine(
    range_m: Single, plan_m: Single, toward: Single, height_m: Single, cos_pitch: Single, sin_pitch: Single
) -> Single:
    """Cosine of the cone about the phone's long axis, of a `sight`, the phone pitched."""
    return (plan_m * toward * cos_pitch - height_m * sin_pitch) / range_m


@inlined
def path_difference(range_m: Single, cosine: Single, separation_m: Single) -> Single:
    """From microphone 1, a phone's length behind microphone 0, less that from microphone 0, of a point."""
    far2 = range_m * (range_m + TWO * separation_m * cosine) + separation_m * separation_m
    return np.sqrt(far2) - range_m


@inlined
def mirror_off(
    range_m: Single, cosine: Single, toward: Single, cos_pitch: Single, along_m2: Single, up_m2: Single
) -> Single:
    """What a mirror takes off the path difference, whose image is twice as far as a point would be."""
    level2 = cos_pitch * cos_pitch * (ONE - toward * toward)
    upright2 = max(ONE - cosine * cosine - level2, NONE)
    return (along_m2 * level2 + up_m2 * upright2) / range_m
