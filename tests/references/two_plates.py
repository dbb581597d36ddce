"""Full-wave echoes of two thin rigid plates, one behind the other: the boundary elements of `thin_plate`, coupled.

Both plates are of one size and one grid, in parallel planes. From one to the other the kernel

    -d2G/dx2 = [1 + jkr + (k^2 r^2 - 3jkr - 3) x^2 / r^2] e^{-jkr} / (4 pi r^3)

at a distance x between their planes is smooth, and depends on the difference of places alone: two more FFTs apply it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse.linalg import LinearOperator, gmres

from tests.references.thin_plate import _CUBIC, TOLERANCE, Plate, _spread

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def echo(
    size_m: tuple[float, float], behind_m: float, aside_m: float, wavenumber: float, source_m: Floats,
    receivers_m: Floats, steps: tuple[int, int],
) -> Complexes:  # fmt: skip
    """(P,) scattered pressures in units of the source's free field at 1 m, extrapolated from two grids.

    Args:
        size_m: along y and z; the front plate stands in the plane x = 0 about the origin.
        behind_m, aside_m: where the middle of the other one is, along -x and y.
        wavenumber: rad/m.
        source_m: (3,) off the plates.
        receivers_m: (P, 3) off the plates.
        steps: of the coarser grid along y and z; the finer one has twice as many.
    """
    grids = [(n * steps[0], n * steps[1]) for n in (1, 2)]
    coarse, fine = (TwoPlates(size_m, behind_m, aside_m, wavenumber, grid) for grid in grids)
    return 2.0 * fine.echo(source_m, receivers_m) - coarse.echo(source_m, receivers_m)


class TwoPlates:
    """One grid at one frequency."""

    def __init__(
        self, size_m: tuple[float, float], behind_m: float, aside_m: float, wavenumber: float, steps: tuple[int, int]
    ) -> None:
        self.plate = Plate(size_m, wavenumber, steps)
        self.offset_m = np.array([[0.0, 0.0, 0.0], [-behind_m, aside_m, 0.0]])

    def echo(self, source_m: Floats, receivers_m: Floats) -> Complexes:
        """(P,) scattered pressures of one source at points (P, 3)."""
        jump = self._jump(self._load(np.asarray(source_m)))
        return 4.0 * np.pi * np.array([self._load(np.asarray(point)) @ jump for point in receivers_m])

    def _load(self, point_m: Floats) -> Complexes:
        return np.concatenate([self.plate.load(point_m - offset) for offset in self.offset_m])

    def _jump(self, load: Complexes) -> Complexes:
        operator, preconditioner = (
            LinearOperator((load.size, load.size), apply, dtype=complex) for apply in (self._apply, self._precondition)
        )
        solved, code = gmres(operator, -load, M=preconditioner, rtol=TOLERANCE, restart=200, maxiter=3)
        if code:
            raise ArithmeticError(f"GMRES left a residual above {TOLERANCE}")
        return solved

    def _apply(self, vector: Complexes) -> Complexes:
        front, back = np.split(vector, 2)
        own, there, here = self.plate._symbols[0], *self._coupling
        plate = self.plate
        return np.concatenate(
            [plate._apply(own, front) + plate._apply(here, back), plate._apply(own, back) + plate._apply(there, front)]
        )

    def _precondition(self, vector: Complexes) -> Complexes:
        return np.concatenate([self.plate._apply(self.plate._symbols[1], half) for half in np.split(vector, 2)])

    @cached_property
    def _coupling(self) -> tuple[Complexes, Complexes]:
        """Transforms of the Toeplitz matrices from the front plate to the back one, and back."""
        plate = self.plate
        cells = [np.arange(-(n - 1) - 2, n + 1) for n in plate.shape]
        x, w = np.polynomial.legendre.leggauss(3)
        x, w = 0.5 * (x + 1.0), 0.5 * w
        power = x[None, :] ** np.arange(4)[:, None] * w
        moments = np.zeros((4, 4, len(cells[0]), len(cells[1])), dtype=complex)
        for a in range(3):
            for b in range(3):
                y = (cells[0][:, None] + x[a]) * plate.step_m[0] + self.offset_m[1, 1]
                z = (cells[1][None, :] + x[b]) * plate.step_m[1]
                moments += power[:, a, None, None, None] * power[None, :, b, None, None] * self._kernel(y, z)
        toeplitz = _spread(moments, _CUBIC, _CUBIC)[: 2 * plate.shape[0] - 1, : 2 * plate.shape[1] - 1]
        toeplitz *= (plate.step_m[0] * plate.step_m[1]) ** 2
        size = plate._symbols[0].shape
        return _wrapped(toeplitz, size), _wrapped(toeplitz[::-1, ::-1], size)

    def _kernel(self, y: Floats, z: Floats) -> Complexes:
        k, x = self.plate.wavenumber, self.offset_m[1, 0]
        r = np.sqrt(x**2 + y**2 + z**2)
        shape = 1.0 + 1j * k * r + ((k * r) ** 2 - 3j * k * r - 3.0) * (x / r) ** 2
        return shape * np.exp(-1j * k * r) / (4.0 * np.pi * r**3)


def _wrapped(toeplitz: Complexes, size: tuple[int, ...]) -> Complexes:
    """FFT of the circulant that holds a Toeplitz matrix, of differences from -(n - 1) to n - 1."""
    full = np.zeros(size, dtype=complex)
    full[: toeplitz.shape[0], : toeplitz.shape[1]] = toeplitz
    shift = tuple(-(n // 2) for n in toeplitz.shape)
    return fft.fft2(np.roll(full, shift, axis=(0, 1)))
