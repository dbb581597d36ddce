"""Full-wave echoes of a thin rigid rectangular plate in free space: Galerkin boundary elements, FFT and GMRES.

The jump of pressure u over the plate radiates as a double layer, p(x) = int u dG/dn' dS', G = e^{-jkr} / 4 pi r, and
must cancel the source's normal velocity. In the plane d2G/dn dn' = (k^2 + laplacian) G, so that tested with the basis

    A_ij = k^2 <t_i, G t_j> - <grad t_i, G grad t_j> = int G(s) [k^2 + laplacian_s] (t star t)(s - s_ij) ds:

for bilinear hats on a uniform grid t star t are cubic B-splines, their second derivatives differences of hats, and A is
a Toeplitz matrix that two FFTs apply. The single layer, with the same symbol upside down, preconditions it (Calderon).
Nothing is approximated but the grid. Its leading error is of the first order in the step, as if the plate's edges
stood a share of a step off, and goes away by extrapolation over two grids (`echo`).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse.linalg import LinearOperator, gmres

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

NEAR = 4  # cells this close to the singularity take the finer quadrature
TOLERANCE = 1e-6  # of the residual

_CUBIC = np.array([[0, 0, 0, 1], [1, 3, 3, -3], [4, 0, -6, 3], [1, -3, 3, -1]]) / 6.0  # from -2, by powers of x
_HAT = np.array([[0, 1, 0, 0], [1, -1, 0, 0]], dtype=float)  # from -1


def echo(
    size_m: tuple[float, float], wavenumber: float, source_m: Floats, receivers_m: Floats, steps: tuple[int, int]
) -> Complexes:
    """(P,) scattered pressures in units of the source's free field at 1 m, extrapolated from two grids.

    Args:
        size_m: along y and z; the plate stands in the plane x = 0 about the origin.
        wavenumber: rad/m.
        source_m: (3,) off the plate.
        receivers_m: (P, 3) off the plate.
        steps: of the coarser grid along y and z; the finer one has twice as many.
    """
    coarse, fine = (Plate(size_m, wavenumber, (n * steps[0], n * steps[1])) for n in (1, 2))
    return 2.0 * fine.echo(source_m, receivers_m) - coarse.echo(source_m, receivers_m)


class Plate:
    """One grid at one frequency."""

    def __init__(self, size_m: tuple[float, float], wavenumber: float, steps: tuple[int, int]) -> None:
        self.size_m, self.wavenumber, self.steps = size_m, wavenumber, steps
        self.step_m = (size_m[0] / steps[0], size_m[1] / steps[1])
        self.shape = (steps[0] - 1, steps[1] - 1)
        self.iterations = 0

    def echo(self, source_m: Floats, receivers_m: Floats) -> Complexes:
        """(P,) scattered pressures of one source at points (P, 3)."""
        jump = self.jump(self.load(np.asarray(source_m)))
        return 4.0 * np.pi * np.array([self.load(np.asarray(point)) @ jump for point in receivers_m])

    def load(self, point_m: Floats) -> Complexes:
        """(I,) hats times the normal derivative of G from a point."""
        grids = [_gauss_on_grid(w, n) for w, n in zip(self.size_m, self.steps, strict=True)]
        y, z = grids[0][0][:, None] - point_m[1], grids[1][0][None, :] - point_m[2]
        r = np.sqrt(point_m[0] ** 2 + y**2 + z**2)
        slope = (1j * self.wavenumber + 1.0 / r) * np.exp(-1j * self.wavenumber * r) / (4.0 * np.pi * r**2) * point_m[0]
        return (grids[0][1] @ slope @ grids[1][1].T).ravel()

    def jump(self, load: Complexes) -> Complexes:
        """(I,) pressure jump that cancels a source's normal velocity."""
        size = load.size
        kinds = [LinearOperator((size, size), lambda v, s=s: self._apply(s, v), dtype=complex) for s in self._symbols]

        def count(_: float) -> None:
            self.iterations += 1

        solved, code = gmres(
            kinds[0], -load, M=kinds[1], rtol=TOLERANCE, restart=200, maxiter=3, callback=count, callback_type="pr_norm"
        )
        if code:
            raise ArithmeticError(f"GMRES left a residual above {TOLERANCE} after {self.iterations} iterations")
        return solved

    def _apply(self, symbol: Complexes, vector: Complexes) -> Complexes:
        full = fft.ifft2(symbol * fft.fft2(vector.reshape(self.shape), symbol.shape))
        return full[: self.shape[0], : self.shape[1]].ravel()

    @cached_property
    def _symbols(self) -> tuple[Complexes, Complexes]:
        """Transforms of the hypersingular operator's and the preconditioner's Toeplitz matrices."""
        hy, hz = self.step_m
        moments = self._moments()
        both = _spread(moments, _CUBIC, _CUBIC)
        along_y, along_z = _curved(_spread(moments, _HAT, _CUBIC), 0), _curved(_spread(moments, _CUBIC, _HAT), 1)
        count = (self.shape[0], self.shape[1])
        single = both[1:-1, 1:-1][: count[0], : count[1]]
        second = (along_y[:, 1:-1] / hy**2)[: count[0], : count[1]] + (along_z[1:-1] / hz**2)[: count[0], : count[1]]
        hyper = (self.wavenumber**2 * single + second) * (hy * hz) ** 2
        size = tuple(fft.next_fast_len(2 * n) for n in count)
        mass = [(2.0 + np.cos(2.0 * np.pi * np.arange(n) / n)) / 3.0 for n in size]
        weight = (mass[0][:, None] * mass[1][None, :]) ** 2
        return _transform(hyper, size), -4.0 * _transform(single, size) / weight

    def _moments(self) -> Complexes:
        """(4, 4, Y, Z) int x^p y^q G over grid cells -3.. about the singularity, x and y from 0 to 1 in each."""
        cells = [np.arange(-3, n + 2) for n in self.shape]
        out = self._gauss(cells[0], cells[1], 4)
        near = [np.arange(-3, NEAR) for _ in cells]
        out[:, :, : len(near[0]), : len(near[1])] = self._gauss(near[0], near[1], 24)
        for i in (-1, 0):
            for j in (-1, 0):
                out[:, :, 3 + i, 3 + j] = self._corner(i, j)
        return out

    def _gauss(self, y: NDArray, z: NDArray, points: int) -> Complexes:
        x, w = np.polynomial.legendre.leggauss(points)
        x, w = 0.5 * (x + 1.0), 0.5 * w
        out = np.zeros((4, 4, len(y), len(z)), dtype=complex)
        power = x[None, :] ** np.arange(4)[:, None] * w
        for a in range(points):
            for b in range(points):
                kernel = self._kernel((y[:, None] + x[a]) * self.step_m[0], (z[None, :] + x[b]) * self.step_m[1])
                out += power[:, a, None, None, None] * power[None, :, b, None, None] * kernel
        return out

    def _corner(self, i: int, j: int) -> Complexes:
        """(4, 4) of a cell that touches the singularity: two triangles, each squeezed to its tip (Duffy)."""
        x, w = np.polynomial.legendre.leggauss(24)
        x, w = 0.5 * (x + 1.0), 0.5 * w
        s, t = np.meshgrid(x, x, indexing="ij")
        weight = w[:, None] * w[None, :] * s
        out = np.zeros((4, 4), dtype=complex)
        for u, v in ((s, s * t), (s * t, s)):  # distances from the tip, in cells
            kernel = weight * self._kernel(u * self.step_m[0], v * self.step_m[1])
            a, b = (u if i == 0 else 1.0 - u), (v if j == 0 else 1.0 - v)
            for p in range(4):
                for q in range(4):
                    out[p, q] += np.sum(kernel * a**p * b**q)
        return out

    def _kernel(self, y: Floats, z: Floats) -> Complexes:
        r = np.sqrt(y**2 + z**2)
        return np.exp(-1j * self.wavenumber * r) / (4.0 * np.pi * r)


def _gauss_on_grid(width_m: float, steps: int) -> tuple[Floats, Floats]:
    """(3 n,) Gauss points of a line's cells, (n - 1, 3 n) weights of the hats on them."""
    x, w = np.polynomial.legendre.leggauss(3)
    x, w, step = 0.5 * (x + 1.0), 0.5 * w, width_m / steps
    points = (np.arange(steps)[:, None] + x).ravel() * step - 0.5 * width_m
    weights = np.zeros((steps - 1, 3 * steps))
    for n in range(steps - 1):
        weights[n, 3 * n : 3 * n + 3] = w * x * step
        weights[n, 3 * n + 3 : 3 * n + 6] = w * (1.0 - x) * step
    return points, weights


def _spread(moments: Complexes, spline_y: Floats, spline_z: Floats) -> Complexes:
    """Splines centred on nodes -1, 0, 1, ... times G, in units of a cell's area."""
    half = [len(s) // 2 for s in (spline_y, spline_z)]
    count = [n - 4 for n in moments.shape[2:]]
    out = np.zeros(count, dtype=complex)
    for a, piece_y in enumerate(spline_y):
        for b, piece_z in enumerate(spline_z):
            y, z = 2 - half[0] + a, 2 - half[1] + b
            cells = moments[:, :, y : y + count[0], z : z + count[1]]
            out += np.einsum("p,q,pqyz->yz", piece_y, piece_z, cells)
    return out


def _curved(values: Complexes, axis: int) -> Complexes:
    """Second difference along an axis."""
    return np.diff(values, 2, axis=axis)


def _transform(quadrant: Complexes, size: tuple[int, ...]) -> Complexes:
    """FFT of the even circulant that holds a symmetric Toeplitz matrix's first column."""
    full = np.zeros(size, dtype=complex)
    ny, nz = quadrant.shape
    full[:ny, :nz] = quadrant
    full[size[0] - ny + 1 :, :nz] = quadrant[:0:-1]
    full[:, size[1] - nz + 1 :] = full[:, nz - 1 : 0 : -1]
    return fft.fft2(full)
