"""Means over a triangle on which the phase runs linearly, in float32, against plain quadrature in float64."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.kirchhoff.facet_waves import SINGLE, facet_wave

POINTS = 600
PHASES = [
    (0.0, 0.0), (1e-3, -2e-3), (0.02, 0.05), (0.9, 0.4), (0.8, 0.8), (-1.0, 2.0), (2.0, -1.0), (3.0, 3.0), (-3.1, 0.2),
    (6.3, -6.3), (6.0, 0.0), (-12.0, 6.0), (16.0, 16.0),
]  # fmt: skip


def _shares() -> np.ndarray:
    """(3, P) barycentric coordinates of points that lie evenly over a triangle."""
    a, b = np.meshgrid(*[(np.arange(POINTS) + 0.5) / POINTS] * 2)
    root = np.sqrt(a)
    return np.stack([1.0 - root, root * (1.0 - b), root * b]).reshape(3, -1)


SHARES = _shares()


@pytest.mark.parametrize("phases", PHASES)
@pytest.mark.parametrize("bulge", np.eye(3).tolist())
def test_means_over_a_triangle(phases, bulge):
    corner, (one, other, third) = np.array([*phases, -sum(phases)]), SHARES
    wave = np.exp(1j * (corner @ SHARES))
    bent = 4.0 * np.array(bulge) @ np.stack([other * third, third * one, one * other])
    growth = np.mean(1j * (corner @ SHARES) * wave)
    real, imag, more_real, more_imag, *found = facet_wave(*(SINGLE(each) for each in (*phases, *bulge)))
    assert abs(complex(real, imag) - wave.mean()) < 2e-4
    assert abs(complex(more_real, more_imag) - growth) < 2e-3
    assert abs(complex(*found) - np.mean(bent * wave)) < 2e-4
