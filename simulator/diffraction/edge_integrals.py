"""Line integrals over two and more edges of a thin panel, by quadrature, corners included.

After Asheim and Svensson (J. Acoust. Soc. Am. 133 (2013) 3681-3691), for faces of open angle 2 pi: a sound that meets
edges at the points x, y (and z) and runs along the face between them contributes

    p_2 =   int int     b_S(x, y) b_R(y, x)               e^{-jk(m + |xy| + l)}        / (m |xy| l)        dx dy
    p_3 = - int int int b_S(x, y) b(x, y, z) b_R(z, y)    e^{-jk(m + |xy| + |yz| + l)} / (m |xy| |yz| l)   dx dy dz

with b = (1/8 pi) sum_4 beta, the other end of each segment on the face; the factor 2 for two faces and the factor 1/2
for a wave along a face cancel. Between points of the face b is 1 / (2 pi cosh(eta / 2)) with eta = u + u', one term of
each segment, and the hyperbolic secant is its own Fourier transform:

    sech(eta / 2) = int sech(pi s) (cos su cos su' - sin su sin su') ds.

So the segments on either side of y are summed apart, and three edges cost what two do. What a point sends to each y, by
the terms of this sum, is all that the edges before y are needed for; one sum over y gives the same for the points z
after it, with one edge more behind (`passed_on`). With i edges before z from the speaker and j from the microphone,

    p_(i + j + 1) = - sum_z w_z sum_s F(s) before_i(z, s) after_j(z, s),

F the transform times the edge's factor. Orders four and five are within 2e-3 and 8e-3 of plain sums over all points
(0.2 x 0.3 m, 5 degrees off edge-on).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.support.arrays import Complexes, Flags, Floats, SingleComplexes
from obstaclewatch.support.compiled import compiled, inlined
from obstaclewatch.support.vectors import dot, norm
from simulator.diffraction.edge_nodes import WINDOWS, EdgeNodes
from simulator.diffraction.edge_view import ON_FACE_RAD

STEP, TERMS = 0.25, 9  # of s: 4e-3 of the kernel's greatest value
_S = STEP * np.arange(TERMS)
_AT_S = STEP / np.cosh(np.pi * _S) * np.where(_S > 0.0, 2.0, 1.0)
RESOLVED_RAD = 4e-4  # from a panel's plane: nearer to it the nodes, 2 mm apart, miss the peaks or hit them
NO_WIDTH = 1e-14  # of a zone border, on which nothing is diffracted
FACTOR = np.concatenate([_AT_S, -_AT_S[1:]])  # of the cosines, then of the sines


@dataclass(frozen=True)
class Face:
    """What the segments along a panel's face have in common for all speakers and microphones.

    Attributes:
        nodes: N points on E edges.
        linked: (E, E) whether sound runs from one edge to another.
        wavenumber: (K,) rad/m.
        turn: (N, N, K) e^{-jk |xy|} / |xy|; 0 where the edges are not linked.
        slope: (N, N) e^{u / 2} of the second node as the edge at the first one sees it; 1 where not linked.
        back: (N, N) the same of the first node as the edge at the second one sees it.
        step: (N, N, 2) cosine and sine of `STEP` u; 0 where not linked.
    """

    nodes: EdgeNodes
    linked: Flags
    wavenumber: Floats
    turn: SingleComplexes
    slope: Floats
    back: Floats
    step: Floats


def face_of(nodes: EdgeNodes, linked: Flags, wavenumber: Floats) -> Face:
    """Work out all segments of a face once."""
    count = len(nodes)
    turn = np.zeros((count, count, len(wavenumber)), dtype=np.complex64)
    slope, step = np.ones((count, count)), np.zeros((count, count, 2))
    _segments(nodes.point_m, nodes.along, nodes.inwards, nodes.first, linked, wavenumber, turn, slope, step)  # type: ignore[call-arg]
    return Face(nodes, linked, wavenumber, turn, slope, np.ascontiguousarray(slope.T), step)


def over_two(face: Face, source_m: Floats, receiver_m: Floats) -> Complexes:
    """(E, W, E, W, K) p_2 by the edges met and their windows, with its travel phase; points (3,)."""
    edges = len(face.linked)
    out = np.zeros((edges, WINDOWS, edges, WINDOWS, len(face.wavenumber)), dtype=np.complex128)
    nodes, ends = face.nodes, (_end(face, point) for point in (source_m, receiver_m))
    _two(nodes.weight_m, nodes.share, nodes.first, face.linked, face.turn, face.slope, face.back, *ends, out)  # type: ignore[call-arg]
    return out


def half_way(face: Face, points_m: Floats) -> list[SingleComplexes]:
    """P times (N, E, W, K, T): what points (P, 3) send to each node over edges and windows, by Fourier terms."""
    edges, terms = len(face.linked), 2 * TERMS - 1
    shape = len(face.nodes), edges, WINDOWS, len(face.wavenumber), terms
    out = [np.zeros(shape, dtype=np.complex64) for _ in points_m]
    ends = [_end(face, point) for point in points_m]
    for a, b in np.argwhere(face.linked):
        here, there = (slice(face.nodes.first[edge], face.nodes.first[edge + 1]) for edge in (a, b))
        waves = _fourier(face.step[there, here])
        for end, half in zip(ends, out, strict=True):
            sent = np.empty((there.stop - there.start, 2 * len(face.wavenumber), here.stop - here.start), np.float32)
            _send(here.start, there.start, face.nodes.weight_m, face.turn, face.back, end, sent)  # type: ignore[call-arg]
            for window, share in enumerate(face.nodes.share[here].T.astype(np.float32)):
                some = slice(*(np.flatnonzero(share)[[0, -1]] + [0, 1]))
                arrived = (sent[:, :, some] * share[some]) @ waves[:, :, some].transpose(0, 2, 1)
                half[there, a, window] = arrived[:, 0::2] + np.complex64(1j) * arrived[:, 1::2]
    return out


def _fourier(step: Floats) -> NDArray[np.float32]:
    """(J, T, I) cosines, then sines, of multiples of steps given by theirs (J, I, 2)."""
    first = step.astype(np.float32).view(np.complex64)[:, :, 0]
    out = np.empty((len(first), 2 * TERMS - 1, first.shape[1]), dtype=np.float32)
    power = np.ones_like(first)
    out[:, 0] = 1.0
    for t in range(1, TERMS):
        power = power * first
        out[:, t], out[:, TERMS - 1 + t] = power.real, power.imag
    return out


def over_three(face: Face, before: SingleComplexes, after: SingleComplexes) -> Complexes:
    """(E, W, E, W, E, W, K) p_3 by edges and windows, from what reaches the middle ones from both ends."""
    edges, ends = len(face.linked), before.shape[1:3]
    left, right = (part.reshape(len(part), -1, *part.shape[3:]) for part in (before, after))
    out = np.zeros((*ends, edges, WINDOWS, *ends, len(face.wavenumber)), dtype=np.complex128)
    for w in range(WINDOWS):
        out[:, :, :, w] = met(face, left, right, face.nodes.share[:, w]).reshape(*ends, edges, *ends, -1)
    return out


def met(face: Face, before: SingleComplexes, after: SingleComplexes, share: Floats | float = 1.0) -> Complexes:
    """(L, E, M, K) sums over each edge, of L parts (N, L, K, T) of what comes from before it and M from after.

    `share` (N,) is what counts of each node. In double precision: that keeps them reciprocal.
    """
    first, weight = face.nodes.first, face.nodes.weight_m * share
    out = np.zeros((before.shape[1], len(face.linked), after.shape[1], len(face.wavenumber)), dtype=np.complex128)
    for edge in range(len(face.linked)):
        rows = slice(first[edge], first[edge + 1])
        factor = (weight[rows, None] * FACTOR / (-2.0 * np.pi)).ravel()
        left, right = (_by_frequency(part[rows]).astype(np.complex128) for part in (before, after))
        out[:, edge] = np.matmul(left * factor, right.transpose(0, 2, 1)).transpose(1, 2, 0)
    return out


def passed_on(face: Face, before: SingleComplexes) -> SingleComplexes:
    """(N, L, E, K, T) what L parts (N, L, K, T) of what reaches the nodes send to others, by the edge they leave."""
    first, edges = face.nodes.first, np.arange(len(face.linked))
    factor = (face.nodes.weight_m[:, None] * FACTOR / (-2.0 * np.pi)).astype(np.float32)
    out = np.zeros((*before.shape[:2], len(edges), *before.shape[2:]), dtype=np.complex64)
    for a in edges:
        rows = slice(first[a], first[a + 1])
        received = np.flatnonzero(before[rows].any(axis=(0, 2, 3)))  # what left this very edge does not reach it
        leaving = before[rows][:, received] * factor[rows, None, None]
        leaving = np.stack([leaving.real, leaving.imag], axis=2).transpose(0, 4, 1, 2, 3)  # (N, T, L, 2, K)
        leaving = np.ascontiguousarray(leaving).reshape(*leaving.shape[:2], -1)
        for b in np.flatnonzero(face.linked[a] & (len(received) > 0)):
            arriving = np.zeros((first[b + 1] - first[b], *leaving.shape[1:]), dtype=np.float32)
            _pass(first[a], first[b], face.turn, face.step, leaving, arriving)  # type: ignore[call-arg]
            parts = arriving.reshape(*arriving.shape[:2], len(received), 2, -1).transpose(3, 0, 2, 4, 1)
            out[first[b] : first[b + 1], received, a] = parts[0] + np.complex64(1j) * parts[1]
    return out


def _by_frequency(part: SingleComplexes) -> SingleComplexes:
    """(K, L, N T)."""
    count, labels, frequencies, terms = part.shape
    return part.transpose(2, 1, 0, 3).reshape(frequencies, labels, count * terms)


class _End(NamedTuple):
    """How the nodes see a point; compiled functions take it whole.

    Attributes:
        slope: (N,) e^{u / 2}.
        sine, cosine: (2, N) of half the angles.
        wave: (N, K) e^{-jkm} / 8 pi m.
    """

    slope: Floats
    sine: Floats
    cosine: Floats
    wave: Complexes


def _end(face: Face, point_m: Floats) -> _End:
    """How the nodes see a point (3,)."""
    nodes = face.nodes
    offset = point_m - nodes.point_m
    across, rise = dot(offset, nodes.inwards), offset @ nodes.normal
    far = norm(offset)[:, None]
    angle = _resolved(np.mod(np.arctan2(rise, across), 2.0 * np.pi))
    half = 0.5 * (np.pi + angle * np.array([[1.0], [-1.0]]))
    slant = np.arcsinh(dot(offset, nodes.along) / np.hypot(across, rise))
    wave = np.exp(-1j * far * face.wavenumber) / (8.0 * np.pi * far)
    return _End(np.exp(0.5 * slant), np.sin(half), np.cos(half), wave)


def _resolved(angle_rad: Floats) -> Floats:
    """(N,) angles, none closer to pi than nodes resolve, but for pi itself.

    Close to the panel's plane what edges diffract onto it is a peak, of the same area however narrow it is: it makes up
    for what the edges beyond lose in the shadow. In the plane there is none.
    """
    off = angle_rad - np.pi
    narrow = (np.abs(off) < RESOLVED_RAD) & (np.abs(off) > ON_FACE_RAD)
    found: Floats = np.where(narrow, np.pi + np.copysign(RESOLVED_RAD, off), angle_rad)
    return found


@compiled
def _segments(point, along, inwards, first, linked, wavenumber, turn, slope, step):
    for a in range(len(linked)):
        for b in range(len(linked)):
            if not linked[a, b]:
                continue
            for i in range(first[a], first[a + 1]):
                for j in range(first[b], first[b + 1]):
                    rise, across, square = 0.0, 0.0, 0.0
                    for x in range(3):
                        segment = point[j, x] - point[i, x]
                        rise, across, square = (
                            rise + segment * along[i, x],
                            across + segment * inwards[i, x],
                            square + segment**2,
                        )
                    slant = np.arcsinh(rise / np.abs(across))
                    slope[i, j] = np.exp(0.5 * slant)
                    step[i, j, 0], step[i, j, 1] = np.cos(STEP * slant), np.sin(STEP * slant)
                    if i > j:
                        continue
                    length = np.sqrt(square)
                    for n in range(len(wavenumber)):
                        phase = wavenumber[n] * length
                        turn[i, j, n] = (np.cos(phase) - 1j * np.sin(phase)) / length
                        turn[j, i, n] = turn[i, j, n]


@inlined
def _beta(end, node, slope):
    """The four terms for an open angle of 2 pi with one end on the face; 0 on the border of a zone.

    Without branches, and nodes in rows: loops over nodes take several at a time.
    """
    seen = end.slope[node] * slope
    cosh = 0.5 * (seen + 1.0 / seen)
    one, other = cosh - end.cosine[0, node], cosh - end.cosine[1, node]
    first = 2.0 * end.sine[0, node] / one if one > NO_WIDTH else 0.0
    second = 2.0 * end.sine[1, node] / other if other > NO_WIDTH else 0.0
    return first + second


@inlined
def _waves(step, wave):
    """Cosines, then sines, of multiples of a step."""
    half = len(wave) // 2
    wave[0], x, y = 1.0, 1.0, 0.0
    for t in range(1, half + 1):
        x, y = x * step[0] - y * step[1], x * step[1] + y * step[0]
        wave[t], wave[half + t] = x, y


@compiled
def _two(weight, share, first, linked, turn, slope, back, source, receiver, out):
    """Add double integrals over each two edges that are linked, by windows."""
    windows, frequencies = share.shape[1], turn.shape[2]
    passed, arrived = np.empty((windows, frequencies), np.complex128), np.empty(frequencies, np.complex128)
    scale = np.empty(len(weight))
    for a in range(len(linked)):
        for b in range(len(linked)):
            if not linked[a, b]:
                continue
            for i in range(first[a], first[a + 1]):
                for j in range(first[b], first[b + 1]):
                    scale[j] = _beta(source, i, slope[i, j]) * _beta(receiver, j, back[i, j]) * weight[j]
                passed[:] = 0.0
                for j in range(first[b], first[b + 1]):
                    for n in range(frequencies):
                        arrived[n] = scale[j] * (turn[i, j, n] * receiver.wave[j, n])
                    for w in range(windows):
                        if share[j, w] != 0.0:
                            for n in range(frequencies):
                                passed[w, n] += share[j, w] * arrived[n]
                for v in range(windows):
                    part = weight[i] * share[i, v]
                    if part != 0.0:
                        for w in range(windows):
                            for n in range(frequencies):
                                out[a, v, b, w, n] += part * source.wave[i, n] * passed[w, n]


@compiled
def _send(here, there, weight, turn, back, source, out):
    """What a point sends over nodes from `here` on to nodes from `there` on, (J, 2 K, I): real and imaginary parts."""
    scale = np.empty(out.shape[2])
    for j in range(out.shape[0]):
        for i in range(out.shape[2]):
            scale[i] = _beta(source, here + i, back[there + j, here + i]) * weight[here + i]
        for i in range(out.shape[2]):
            for n in range(turn.shape[2]):
                value = scale[i] * (source.wave[here + i, n] * turn[there + j, here + i, n])
                out[j, 2 * n, i], out[j, 2 * n + 1, i] = value.real, value.imag


@compiled
def _pass(here, there, turn, step, leaving, arriving):
    """Add what nodes from `here` on, (N, T, X), send to nodes from `there` on; X holds parts, real and imaginary, K."""
    terms, size = leaving.shape[1:]
    nodes, half = turn.shape[2], terms // 2
    out, back = np.empty(terms, dtype=np.float32), np.empty(terms, dtype=np.float32)
    sent = np.empty(size, dtype=np.float32)
    for j in range(len(arriving)):
        total = arriving[j]
        for i in range(len(leaving)):
            came = leaving[i]
            _waves(step[here + i, there + j], out)
            _waves(step[there + j, here + i], back)
            for x in range(size):
                sent[x] = came[0, x]
            for t in range(1, 2 * half, 4):  # by fours: as many operations for each number that is fetched
                c0, c1, c2, c3 = out[t], out[t + 1], out[t + 2], out[t + 3]
                for x in range(size):
                    sent[x] += c0 * came[t, x] + c1 * came[t + 1, x] + c2 * came[t + 2, x] + c3 * came[t + 3, x]
            for row in range(0, size, 2 * nodes):
                for n in range(nodes):
                    turning = turn[here + i, there + j, n]
                    p, q = sent[row + n], sent[row + nodes + n]
                    sent[row + n] = p * turning.real - q * turning.imag
                    sent[row + nodes + n] = p * turning.imag + q * turning.real
            for x in range(size):
                total[0, x] += sent[x]
            for t in range(1, 2 * half, 4):
                c0, c1, c2, c3 = back[t], back[t + 1], back[t + 2], back[t + 3]
                for x in range(size):
                    value = sent[x]
                    total[t, x] += c0 * value
                    total[t + 1, x] += c1 * value
                    total[t + 2, x] += c2 * value
                    total[t + 3, x] += c3 * value
