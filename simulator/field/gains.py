"""What a path loses on its way: spreading, air, surfaces, directivity."""

from __future__ import annotations

import numpy as np

from obstaclewatch.support.arrays import Complexes, Floats, Ints
from simulator.diffraction.edge_view import APEX, END, EdgeView
from simulator.diffraction.finite_edge import FACE_0, FACE_N, edge_terms
from simulator.diffraction.single import left_by_mirrors, views_of
from simulator.field.sharp_shadows import beside_edges
from simulator.phone.phone import Phone
from simulator.scene.pose import Pose
from simulator.waves import band
from simulator.waves.spreading import rays, spreading
from simulator.world.candidates import Candidates
from simulator.world.interactions import Interaction
from simulator.world.search_context import Search
from simulator.world.visibility import COINCIDENT_M
from simulator.world.world import World


def path_gain(search: Search, found: Candidates, sums: Complexes, frequency_hz: Floats) -> Complexes:
    """(C, K) complex gain of each path at K frequencies, without its travel phase; `sums` are those of `found.cell`."""
    tracing = search.tracing
    amplitude = np.empty((len(found), len(frequency_hz)), dtype=np.complex128)
    over, whole = found.edge >= 0, found.cell >= 0
    ray = ~(over | whole)
    mirrors = found if ray.all() else found[ray]
    amplitude[ray] = spreading(mirrors.points_m, mirrors.normal, mirrors.curvature, mirrors.order)[:, None]
    curved = np.flatnonzero((mirrors.interaction == Interaction.CURVED).any(axis=1))
    if len(curved):
        leads = bending_phase(mirrors.curvature[curved], search.wavenumbers_1_m(frequency_hz))
        amplitude[np.flatnonzero(ray)[curved]] *= leads
    if over.any():
        amplitude[over] = edge_gain(search, found[over], frequency_hz)
    if whole.any():
        amplitude[whole] = band.evaluate(band.coefficients(sums[found.cell[whole]]), frequency_hz)
    absorption_db = search.air.absorption_db_m(frequency_hz) * found.length_m[:, None]
    gain = amplitude * found.share[:, None] * 10.0 ** (-absorption_db / 20.0)
    segments = rays(found.points_m, found.normal)
    gain = gain * surface_reflection(search, found, segments, frequency_hz)
    return gain * directivity(search.phone, tracing.pose, found, segments[1])[:, None]


def bending_phase(curvature: Floats, wavenumber_rad_m: Floats) -> Complexes:
    """(C, K) phase factors that rays lack: the echo of a convex surface leads by O(1 / ka).

    exp(j c / k) with c = 3 (k1 + k2) / 4 - (k1 - k2)^2 / (16 (k1 + k2)) in the principal curvatures k1, k2: the next
    term of the exact series at normal incidence on a sphere, 3 / (2a), and on a cylinder, 11 / (16a), and the only
    symmetric form of that shape between the two. Concave and saddle-shaped points are left as they are.

    Args:
        curvature: (C, N, 3, 3) tensors along each path, 0 for planes.
        wavenumber_rad_m: (K,).
    """
    total = np.trace(curvature, axis1=2, axis2=3)
    square = np.einsum("cnij,cnij->cn", curvature, curvature)
    gauss = 0.5 * (total**2 - square)
    convex = (total > 0.0) & (gauss >= -1e-9 * total**2)
    safe = np.where(convex, total, 1.0)
    lead_1_m = np.where(convex, 0.75 * total - (2.0 * square - total**2) / (16.0 * safe), 0.0).sum(axis=1)
    return np.exp(1j * lead_1_m[:, None] / wavenumber_rad_m)


def edge_gain(search: Search, found: Candidates, frequency_hz: Floats) -> Complexes:
    """(C, K) strength of diffraction, spreading included, of paths that all have an edge.

    The integral is that of a rigid wedge. Its terms that continue the mirror images carry the reflection factor of
    the material, at the angle of the mirror path where there is one (Luebbers, IEEE Trans. Antennas Propag. 32 (1984)
    70-76): so the sum stays continuous where a mirror path ends. An approximation elsewhere.
    """
    if len(found) == 0:
        return np.zeros((0, len(frequency_hz)), dtype=np.complex128)
    tracing = search.tracing
    wedges, view = views_of(tracing, found)
    wavenumber = search.wavenumbers_1_m(frequency_hz)
    terms = edge_terms(view, found.part, wavenumber)
    path_rad = view.path_m(found.part)[:, None] * wavenumber
    for group, first in ((FACE_0, 0.0), (FACE_N, view.open_angle_rad)):
        cosine = _mirror_cosine(view, found.part, first)
        for index in np.unique(wedges.obstacle):
            rows = np.flatnonzero(wedges.obstacle == index)
            material = tracing.world.obstacles[index].material
            terms[rows, group] *= material.reflection(frequency_hz, cosine[rows, None], path_rad[rows])
    terms *= left_by_mirrors(tracing, found, view, wavenumber)
    loud = np.flatnonzero(np.abs(terms).sum(axis=1).max(axis=1) >= search.lost_in_noise)
    terms[loud] *= beside_edges(search, found[loud], wavenumber)
    return terms.sum(axis=1)


def _mirror_cosine(view: EdgeView, part: Ints, face_angle_rad: Floats | float) -> Floats:
    """(R,) cosine of incidence on a face, the same from both ends: that of the mirror path where its zone ends."""
    height = np.where(part == APEX, view.apex_height_m, np.where(part == END, view.length_m, 0.0))
    rise = np.ones(len(view))
    for radius, angle, along in (
        (view.source_radius_m, view.source_angle_rad, view.source_height_m),
        (view.receiver_radius_m, view.receiver_angle_rad, view.receiver_height_m),
    ):
        rise *= np.abs(np.sin(angle - face_angle_rad)) * radius / np.hypot(radius, height - along)
    return np.minimum(np.sqrt(rise), 1.0)


def surface_reflection(
    search: Search, found: Candidates, segments: tuple[Floats, Floats], frequency_hz: Floats
) -> Complexes:
    """(C, K) product of the reflection factors of the mirrors and smooth surfaces met; cells carry their own.

    Mirrors reflect spherical waves. Off smooth surfaces the waves that run along them are left out.

    Args:
        segments: lengths and directions, see `rays`.
    """
    world = search.tracing.world
    curved = found.interaction == Interaction.CURVED
    met = np.where((found.interaction == Interaction.SPECULAR) | curved, world.obstacle_of(found.sequence), -1)
    path_rad = segments[0].sum(axis=1)[:, None] * search.wavenumbers_1_m(frequency_hz)
    product = np.ones((len(found), len(frequency_hz)), dtype=np.complex128)
    cosines = _cosines(world, found, *segments)
    for index in np.unique(met[met >= 0]):
        row, slot = np.nonzero(met == index)
        phase = np.where(curved[row, slot, None], np.inf, path_rad[row])
        factor = world.obstacles[index].material.reflection(frequency_hz, cosines[row, slot, None], phase)
        for k in range(slot.max() + 1):
            product[row[slot == k]] *= factor[slot == k]
    return product


def _cosines(world: World, found: Candidates, length: Floats, ray: Floats) -> Floats:
    """(C, N) of incidence at every reflection, the same for a path and for its reverse.

    An end of an edge that stands on a mirror has no segment to that mirror: behind the edge, the segment that leaves
    the mirror counts. A crease on a mirror continues reflections both before and after its face: the mean of both
    segments counts.
    """
    if (found.edge < 0).all():
        return np.abs(np.einsum("cnx,cnx->cn", found.normal, ray[:, :-1]))
    slot = np.arange(found.sequence.shape[1])
    every = np.abs(np.einsum("cnx,cmx->cnm", found.normal, ray))
    cosine = every[:, slot, slot]
    short = (length[:, :-1] < COINCIDENT_M) & (found.edge >= 0)[:, None]
    cosine = np.where(short, every[:, slot, slot + 1], cosine)
    rows = np.flatnonzero(found.edge >= 0)
    rows = rows[world.wedges.mirror[found.edge[rows]] >= 0]
    row, at = np.nonzero(short[rows, 1:])  # the crease is one slot on, and the segment that leaves it another
    cosine[rows[row], at] = np.sqrt(every[rows[row], at, at] * every[rows[row], at, at + 2])
    return cosine


def directivity(phone: Phone, pose: Pose, found: Candidates, ray: Floats) -> Floats:
    """(C,) speaker's factor towards the first point times the microphone's towards the last.

    Kirchhoff's sum has them facet by facet, and direct sound runs along the case: its level is the response table's.

    Args:
        ray: directions of the segments, see `rays`: a transducer on a face has one of no length, but a direction.
    """
    leaving, arriving = ray[:, 0], -ray[np.arange(len(found)), found.order]
    matrices = np.broadcast_to(pose.rotation.as_matrix().reshape(-1, 3, 3), (len(pose), 3, 3))[found.pose]
    factor = phone.speaker.directivity(_in_phone(matrices, leaving))
    for mic, transducer in enumerate(phone.mics):
        rows = np.flatnonzero((found.mic == mic) & (found.order > 0))
        factor[rows] *= transducer.directivity(_in_phone(matrices[rows], arriving[rows]))
    apart = (found.order == 0) | (found.interaction == Interaction.KIRCHHOFF).any(axis=1)
    return np.where(apart, 1.0, factor)


def _in_phone(matrices: Floats, unit: Floats) -> Floats:
    return np.einsum("pji,pj->pi", matrices, unit)
