"""Geometry of two microphones: paths to distances, distances to the cosine to the phone's long axis, and back.

Ranges are those of the beep's centre as the chirp reads them. A closing obstacle's delay shrinks while the frequency
rises, and the matched filter reads the range center_hz / chirp_rate ahead: 0.205 s, or 20-33 cm short at 1.0-1.6 m/s.
The paper's method has that bias and `PaperDetector` keeps it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.arrays import Floats
from obstaclewatch.support.compiled import compiled


def one_way_range(path_m: ArrayLike, baseline_m: float, cosine: ArrayLike = 1.0) -> Floats:
    """Distance from a microphone to a point, from the path speaker - point - microphone.

    path = D + sqrt(D^2 + b^2 - 2 D b cos a), hence D = (path^2 - b^2) / (2 (path - b cos a)); for b = 0 path / 2.

    Args:
        path_m: length of that path.
        baseline_m: b, distance from microphone to speaker.
        cosine: cos a, of the angle at the microphone between the speaker and the point.

    Returns:
        Distances, NaN where the path is not longer than the baseline.
    """
    path = np.asarray(path_m, dtype=np.float64)
    path = np.where(path > baseline_m, path, np.nan)
    return np.asarray(distance_of.py_func(path, baseline_m, np.asarray(cosine, dtype=np.float64)))


@compiled
def distance_of(path_m: Any, baseline_m: float, cosine: Any) -> Any:
    """`one_way_range` of paths that are longer than the baseline; compiled loops hand it floats."""
    return (path_m**2 - baseline_m**2) / (2.0 * (path_m - baseline_m * cosine))


@compiled
def ranges_of_pairs(
    path1_m: Floats, u_m: Floats, separation_m: float, baseline_m: float, speaker_cosine: float
) -> Floats:
    """(n,) distances from microphone 0 by both microphones' paths, with the speaker somewhere between them.

    The triangle needs the bearing and the bearing the range: the second round moves it by less than 0.1 mm.

    Args:
        path1_m: (n,) paths from the speaker to microphone 0.
        u_m: (n,) path 2 - path 1; where it is NaN, echoes count as from straight ahead.
        separation_m: between the microphones.
        baseline_m: from microphone 0 to the speaker.
        speaker_cosine: of the angle at microphone 0 between the speaker and the line on from microphone 1.
    """
    range_m = np.empty(len(path1_m))
    for row, path in enumerate(path1_m):
        distance = 0.5 * path
        for _ in range(2):
            toward = law_of_cosines(distance, distance + u_m[row], separation_m)
            toward = 1.0 if np.isnan(toward) else min(max(toward, -1.0), 1.0)
            distance = distance_of(path, baseline_m, speaker_cosine * toward) if path > baseline_m else np.nan
        range_m[row] = distance
    return range_m


def cone_cosine(range_m: ArrayLike, range2_m: ArrayLike, separation_m: float) -> Floats:
    """Cosine of the angle between the phone's long axis and the obstacle, not clamped (Eq. 2).

    theta = pi - arccos((D1^2 + L^2 - D2^2) / (2 D1 L)), so cos theta = (D2^2 - D1^2 - L^2) / (2 D1 L).
    """
    d1, d2 = np.asarray(range_m, dtype=np.float64), np.asarray(range2_m, dtype=np.float64)
    return law_of_cosines.py_func(d1, d2, separation_m)


@compiled
def law_of_cosines(range_m: Any, range2_m: Any, separation_m: float) -> Any:
    """`cone_cosine` for compiled loops, which hand it floats."""
    return (range2_m**2 - range_m**2 - separation_m**2) / (2.0 * range_m * separation_m)


@compiled
def path_difference_at(range_m: Any, cosine: Any, separation_m: float) -> Any:
    """Its inverse: D2 - D1 of what is seen at a cosine to the phone's long axis, its waves from D1 away."""
    return np.sqrt(range_m * (range_m + 2.0 * separation_m * cosine) + separation_m**2) - range_m
