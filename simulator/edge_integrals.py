"""The double and triple line integrals over the edges of a thin panel, by quadrature, corners included.

After Asheim and Svensson (J. Acoust. Soc. Am. 133 (2013) 3681-3691), for faces of open angle 2 pi: a sound that meets
edges at the points x, y (and z) and runs along the face between them contributes

    p_2 =   int int     b_S(x, y) b_R(y, x)               e^{-jk(m + |xy| + l)}        / (m |xy| l)        dx dy
    p_3 = - int int int b_S(x, y) b(x, y, z) b_R(z, y)    e^{-jk(m + |xy| + |yz| + l)} / (m |xy| |yz| l)   dx dy dz

with b = (1/8 pi) sum_4 beta, the other end of each leg on the face; its two faces and the halves by which a wave along
a face counts double make up for each other. Between points of the face b is 1 / (2 pi cosh(eta / 2)) with
eta = u + u', one term of each leg, and the hyperbolic secant is its own Fourier transform:

    sech(eta / 2) = int sech(pi s) (cos su cos su' - sin su sin su') ds.

So the legs on either side of y are summed apart, and three edges cost what two do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from simulator.edge_nodes import WINDOWS, EdgeNodes

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Flags = NDArray[np.bool_]

STEP, TERMS = 0.25, 9  # of s: 4e-3 of the kernel's greatest value
_S = STEP * np.arange(TERMS)
_AT_S = STEP / np.cosh(np.pi * _S) * np.where(_S > 0.0, 2.0, 1.0)
NO_WIDTH = 1e-14  # of a zone border, on which nothing is bent
FACTOR = np.concatenate([_AT_S, -_AT_S[1:]])  # of the cosines, then of the sines


@dataclass(frozen=True)
class Face:
    """What the legs along a panel's face have in common for all speakers and microphones.

    Attributes:
        nodes: N points on E edges.
        linked: (E, E) whether sound runs from one edge to another.
        wavenumber: (K,) rad/m.
        turn: (N, N, K) e^{-jk |xy|} / |xy|; 0 where the edges are not linked.
        swing: (N, N) e^{u / 2} of the second node as the edge at the first one sees it.
        step: (N, N, 2) cosine and sine of `STEP` u.
    """

    nodes: EdgeNodes
    linked: Flags
    wavenumber: Floats
    turn: NDArray[np.complex64]
    swing: Floats
    step: Floats


def face_of(nodes: EdgeNodes, linked: Flags, wavenumber: Floats) -> Face:
    """Work out all legs of a face once."""
    leg = nodes.point_m[None] - nodes.point_m[:, None]
    across = np.abs(np.einsum("ijx,ix->ij", leg, nodes.inwards))
    seen = linked[nodes.edge[:, None], nodes.edge[None]]
    slant = np.arcsinh(np.einsum("ijx,ix->ij", leg, nodes.along) / np.where(seen, across, 1.0))
    length = np.where(seen, np.linalg.norm(leg, axis=2), 1.0)
    turn = np.empty((*length.shape, len(wavenumber)), dtype=np.complex64)
    for n, k in enumerate(wavenumber):
        turn[:, :, n] = np.where(seen, np.exp(-1j * k * length) / length, 0.0)
    step = np.stack([np.cos(STEP * slant), np.sin(STEP * slant)], axis=2)
    return Face(nodes, linked, wavenumber, turn, np.exp(0.5 * slant), step)


def over_two(face: Face, source_m: Floats, receiver_m: Floats) -> Complexes:
    """(E, W, E, W, K) p_2 by the edges met and their windows, with its whole travel phase; points (3,)."""
    edges = len(face.linked)
    out = np.zeros((edges, WINDOWS, edges, WINDOWS, len(face.wavenumber)), dtype=np.complex128)
    _two(*_arrays(face), face.swing, *_end(face, source_m), *_end(face, receiver_m), out)  # type: ignore[call-arg]
    return out


def half_way(face: Face, point_m: Floats) -> NDArray[np.complex64]:
    """(N, E, W, K, T) what a point (3,) sends to each node over edges and windows before it, by Fourier terms."""
    shape = len(face.nodes), len(face.linked), WINDOWS, len(face.wavenumber), 2 * TERMS - 1
    real, imaginary = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.float32)
    _half(*_arrays(face), face.swing, face.step, *_end(face, point_m), real, imaginary)  # type: ignore[call-arg]
    return real + np.complex64(1j) * imaginary


def over_three(face: Face, before: NDArray[np.complex64], after: NDArray[np.complex64]) -> Complexes:
    """(E, W, E, W, E, W, K) p_3 by edges and windows, from what reaches the middle ones from both ends."""
    nodes, edges = face.nodes, len(face.linked)
    nodal = nodes.weight_m[:, None] * nodes.share
    out = np.zeros((edges, WINDOWS, edges, WINDOWS, edges, WINDOWS, len(face.wavenumber)), dtype=np.complex128)
    for b in range(edges):
        rows = slice(nodes.first[b], nodes.first[b + 1])
        left, right = (_by_frequency(part[rows]) for part in (before, after))
        for w in range(WINDOWS):
            weight = (nodal[rows, w, None] * FACTOR / (-2.0 * np.pi)).ravel().astype(np.float32)
            both = np.matmul(left * weight, right.transpose(0, 2, 1))
            shape = (len(both), edges, WINDOWS, edges, WINDOWS)
            out[:, :, b, w] = both.reshape(shape).transpose(1, 2, 3, 4, 0)
    return out


def _by_frequency(part: NDArray[np.complex64]) -> NDArray[np.complex64]:
    """(K, E W, N T)."""
    count, edges, windows, frequencies, terms = part.shape
    return part.transpose(3, 1, 2, 0, 4).reshape(frequencies, edges * windows, count * terms)


def _arrays(face: Face) -> tuple:
    return face.nodes.weight_m, face.nodes.share, face.nodes.first, face.linked, face.turn


def _end(face: Face, point_m: Floats) -> tuple[Floats, Floats, Floats, Complexes]:
    """How the nodes see a point: e^{u / 2} (N,), sines and cosines of half the angles (N, 2), e^{-jkm} / 8 pi m."""
    nodes = face.nodes
    offset = point_m - nodes.point_m
    across, rise = np.sum(offset * nodes.inwards, axis=1), offset @ nodes.normal
    far = np.linalg.norm(offset, axis=1)[:, None]
    angle = np.mod(np.arctan2(rise, across), 2.0 * np.pi)[:, None]
    half = 0.5 * (np.pi + angle * np.array([1.0, -1.0]))
    slant = np.arcsinh(np.sum(offset * nodes.along, axis=1) / np.hypot(across, rise))
    sent = np.exp(-1j * far * face.wavenumber) / (8.0 * np.pi * far)
    return np.exp(0.5 * slant), np.sin(half), np.cos(half), sent


@numba.njit(cache=True, inline="always")
def _beta(swing, sine, cosine):
    """The four terms for an open angle of 2 pi with one end on the face; 0 on the border of a zone."""
    cosh = 0.5 * (swing + 1.0 / swing)
    first, second = cosh - cosine[0], cosh - cosine[1]
    out = 0.0
    if first > NO_WIDTH:
        out += 2.0 * sine[0] / first
    if second > NO_WIDTH:
        out += 2.0 * sine[1] / second
    return out


@numba.njit(cache=True, fastmath=True)
def _two(
    weight, share, first, linked, turn, swing, swing_s, sin_s, cos_s, sent, swing_r, sin_r, cos_r, heard, out
):  # fmt: skip
    windows, nodes = share.shape[1], turn.shape[2]
    passed = np.empty((windows, nodes), np.complex128)
    for a in range(len(linked)):
        for b in range(len(linked)):
            if not linked[a, b]:
                continue
            for i in range(first[a], first[a + 1]):
                passed[:] = 0.0
                for j in range(first[b], first[b + 1]):
                    scale = _beta(swing_s[i] * swing[i, j], sin_s[i], cos_s[i]) * weight[j]
                    scale *= _beta(swing_r[j] * swing[j, i], sin_r[j], cos_r[j])
                    for w in range(windows):
                        part = scale * share[j, w]
                        if part != 0.0:
                            for n in range(nodes):
                                passed[w, n] += part * (turn[i, j, n] * heard[j, n])
                for v in range(windows):
                    part = weight[i] * share[i, v]
                    if part != 0.0:
                        for w in range(windows):
                            for n in range(nodes):
                                out[a, v, b, w, n] += part * sent[i, n] * passed[w, n]


@numba.njit(cache=True, fastmath=True)
def _half(weight, share, first, linked, turn, swing, step, swing_s, sin_s, cos_s, sent, real, imaginary):
    nodes, terms = real.shape[3:]
    half = terms // 2
    wave = np.empty(terms, dtype=np.float32)
    for b in range(len(linked)):
        for j in range(first[b], first[b + 1]):
            for a in range(len(linked)):
                if not linked[a, b]:
                    continue
                for i in range(first[a], first[a + 1]):
                    c, s = step[j, i]
                    wave[0], x, y = 1.0, 1.0, 0.0
                    for t in range(1, half + 1):
                        x, y = x * c - y * s, x * s + y * c
                        wave[t], wave[half + t] = x, y
                    scale = _beta(swing_s[i] * swing[i, j], sin_s[i], cos_s[i]) * weight[i]
                    for v in range(share.shape[1]):
                        part = scale * share[i, v]
                        if part == 0.0:
                            continue
                        for n in range(nodes):
                            value = part * (sent[i, n] * turn[i, j, n])
                            p, q = np.float32(value.real), np.float32(value.imag)
                            for t in range(terms):
                                real[j, a, v, n, t] += wave[t] * p
                            for t in range(terms):
                                imaginary[j, a, v, n, t] += wave[t] * q
