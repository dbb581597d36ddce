"""Make post_values.npz: exact fields past endless rigid posts, re the free field. Run from the repository root:

python -m tests.references.make_post_values

takes about 20 seconds on one core.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.references import rigid_cylinder, two_cylinders

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SPEED_M_S = 343.0
FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 5)
WAVENUMBER_1_M = 2.0 * np.pi * FREQUENCY_HZ / SPEED_M_S
HEIGHT_M = 1.3
STORED = Path(__file__).with_name("post_values.npz")

# speaker and microphone 2.4 m apart, a post in the way out alone: to a wall and back, and to a wall's edge
SPEAKER_M, MIC_M, WALL_M, EDGE_M = np.array([0.0, -1.2]), np.array([0.0, 1.2]), 1.0, np.array([1.0, 0.3])
ASIDE_M = (0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.25, 0.35)
RADII_M = (0.03, 0.1)
SHARES = (0.3, 0.6)
# a phone before a wall, and a post beside its way there and back: radii, distances of the post from its image
PAIRED_MIC_M, PAIRED_WALL_M, PAIRED_ASIDE_M = np.array([0.0, 0.15]), 2.0, (0.0, 0.03, 0.06, 0.1, 0.15)
PAIRS_M = ((0.03, 0.4), (0.1, 0.4), (0.1, 0.8), (0.25, 0.8))


def before_wall(aside_m: float) -> Floats:
    """(2,) a post so far beside the way from the speaker to the wall's mirror point, half a metre on."""
    half_m, ahead_m = MIC_M[1], 0.5
    aside_y_m = aside_m / np.cos(np.arctan(half_m / WALL_M))
    return np.array([ahead_m, -half_m + half_m * ahead_m / WALL_M - aside_y_m])


def past_wall_post(radius_m: float, aside_m: float) -> Complexes:
    """(F,) the wall's echo past that post; what the post sends over the wall is in it."""
    place, image = before_wall(aside_m), np.array([2.0 * WALL_M, 0.0])
    scattered = [
        _scattered(radius_m, place, end, point)
        for end, point in ((image + SPEAKER_M, MIC_M), (image + MIC_M, SPEAKER_M))
    ]
    return 1.0 + np.sum(scattered, axis=0)


def before_edge(share: float, aside_m: float) -> Floats:
    """(2,) a post so far beside the way from the speaker to the edge, at a share of it."""
    along = EDGE_M - SPEAKER_M
    return SPEAKER_M + share * along + aside_m * np.array([along[1], -along[0]]) / np.linalg.norm(along)


def past_edge_post(radius_m: float, share: float, aside_m: float) -> Complexes:
    """(F,) what the edge receives past that post."""
    return 1.0 + _scattered(radius_m, before_edge(share, aside_m), SPEAKER_M, EDGE_M)


def _scattered(radius_m: float, place_m: Floats, source_m: Floats, receiver_m: Floats) -> Complexes:
    ends = [np.append(end - place_m, HEIGHT_M) for end in (source_m, receiver_m)]
    length = np.linalg.norm(receiver_m - source_m)
    scattered = rigid_cylinder.scattered(radius_m, *ends, FREQUENCY_HZ, SPEED_M_S)
    return length * scattered * np.exp(1j * WAVENUMBER_1_M * length)


def paired(gap_m: float, aside_m: float) -> Floats:
    """(2,) a post before the wall, by half of a distance from its image."""
    return np.array([PAIRED_WALL_M - 0.5 * gap_m, aside_m])


def past_pair(radius_m: float, gap_m: float, aside_m: float) -> Complexes:
    """(F,) the wall's echo past that post and its image."""
    place = paired(gap_m, aside_m)
    pair, image = [place, [2.0 * PAIRED_WALL_M - place[0], aside_m]], [2.0 * PAIRED_WALL_M, 0.0]
    return np.array([two_cylinders.behind(pair, [radius_m] * 2, image, PAIRED_MIC_M, k) for k in WAVENUMBER_1_M])


def main() -> None:
    """Compute and store fields (..., P, F) at P distances aside: by radius; radius and share; radius with gap."""
    np.savez(
        STORED,
        wall=[[past_wall_post(radius, aside) for aside in ASIDE_M] for radius in RADII_M],
        edge=[[[past_edge_post(radius, s, aside) for aside in ASIDE_M] for s in SHARES] for radius in RADII_M],
        pair=[[past_pair(*pair, aside) for aside in PAIRED_ASIDE_M] for pair in PAIRS_M],
    )


if __name__ == "__main__":
    main()
