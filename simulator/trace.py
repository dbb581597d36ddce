"""Scene, phone and poses to paths: candidates -> exact points -> named validity masks -> gains -> Paths."""

from __future__ import annotations

import reprlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_floats, check_types
from obstaclewatch.support.arrays import Complexes, Flags, Floats, Strings
from obstaclewatch.support.distinct_rows import distinct
from simulator.diffraction.off_planes import off_planes
from simulator.field.blunt_mirrors import off_blunt_mirrors
from simulator.field.free_segments import segments_free
from simulator.field.gains import path_gain
from simulator.field.not_modelled import not_modelled
from simulator.field.rounded_shadows import behind_rounded, passes_around
from simulator.field.sharp_shadows import passes_over_edges
from simulator.field.stacked_sheets import covered
from simulator.field.twins import first_of_twins
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.phone.transducers import StructureBorne
from simulator.scene.fidelity import MECHANISMS, Fidelity
from simulator.scene.pose import Pose
from simulator.scene.scene import CASE, Scene
from simulator.search import searched
from simulator.waves.band import REFERENCE_HZ
from simulator.world.candidates import FOCUS_GAIN, Candidates, direct
from simulator.world.prepared_scene import PreparedScene, as_prepared
from simulator.world.rejection_log import Reason, Rejected, RejectionLog
from simulator.world.search_context import Search
from simulator.world.world import Tracing, World


def trace_paths(
    scene: Scene | PreparedScene, phone: Phone, pose: Pose, fidelity: Fidelity | None = None, time_s: ArrayLike = 0.0
) -> Paths:
    """Every path of the fidelity's mechanisms between the phone's speaker and microphones.

    Args:
        scene: obstacles and air; prepared, it costs less from the second call on.
        phone: transducers, and the walker's body if it is held.
        pose: one pose or N; N poses cost one call.
        fidelity: what is modelled; None takes the defaults.
        time_s: scalar or (N,), when each pose is taken; obstacles with a velocity have moved by then.

    Raises:
        ValueError: an argument of another type, the speaker and a microphone coincide, a time is not finite, times
            and poses differ in number, a transducer is inside a closed body, an obstacle stands between speaker and
            microphone, the walker's body has a velocity or the name of an obstacle, a smooth surface mirrors two points
            in more than 32 places, or a body too large for Kirchhoff's integral is left to it.

    Example:
        >>> import trimesh
        >>> from simulator import Air, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.rigid(), "wall")], Air.lossless(343.0))
        >>> pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
        >>> paths = trace_paths(scene, Phone.named("ideal"), pose)
        >>> mirror = paths[paths.kind == "specular"]  # 1.955 m to the wall; 1.925 and 2.075 m back
        >>> mirror.mic, (mirror.delay_s * 343.0).round(3)
        (array([0, 1]), array([3.88, 4.03]))
    """
    search = still_search(scene, phone, pose, fidelity, time_s, RejectionLog())
    paths = traced(search)[0]
    if phone.structure_borne is None:
        return paths
    return paths + through_case(search, phone.structure_borne, paths.sequence.shape[1])


def still_search(
    scene: Scene | PreparedScene, phone: Phone, pose: Pose, fidelity: Fidelity | None, time_s: ArrayLike,
    log: RejectionLog,
) -> Search:  # fmt: skip
    """The arguments of `trace_paths`, checked."""
    fidelity = Fidelity() if fidelity is None else fidelity
    scene = as_prepared(scene)
    check_types(phone=(phone, Phone), pose=(pose, Pose), fidelity=(fidelity, Fidelity))
    tracing = still_tracing(scene, phone, pose, _instants(time_s, len(pose)), fidelity)
    return Search(tracing, phone, scene.air, fidelity, log=log)


def _instants(time_s: ArrayLike, poses: int) -> Floats:
    """(N,) when each of N poses is taken."""
    time = as_floats("time_s", time_s)
    if time.shape not in ((), (1,), (poses,)) or not np.isfinite(time).all():
        raise ValueError(f"time_s must be finite with shape ({poses},), got {reprlib.repr(time.tolist())}")
    return np.broadcast_to(time, (poses,))


def still_tracing(
    scene: Scene | PreparedScene, phone: Phone, pose: Pose, time_s: Floats, fidelity: Fidelity
) -> Tracing:
    """Poses taken one by one: the walker's body stands where its pose says."""
    position = np.atleast_2d(pose.position_m)
    heading = np.zeros(len(pose)) if phone.body is None else pose.body_heading_rad()
    return as_prepared(scene).tracing(
        phone, pose, time_s, fidelity.mechanisms, lambda index, _time_s: (position[index], heading[index])
    )


def traced(search: Search) -> tuple[Paths, Candidates]:
    """The paths that pass every mask, and their geometry about the world's origin; the log books what does not."""
    search = replace(search, tracing=off_planes(search.tracing))
    found, sums = searched(search)
    for reason, mask in MASKS.items():
        found = _passed(search, reason, found, mask(search, found), sums)
    gain = _gain(search, found, sums, search.band_hz)
    kept = _over_noise(search, found, gain) | (found.order == 0)
    found = _passed(search, Reason.UNDER_NOISE, found, kept, sums)
    return _paths(search, found, gain[kept]), found


def _gain(search: Search, found: Candidates, sums: Complexes, frequency_hz: Floats) -> Complexes:
    """(C, K) complex gain of each path, without its travel phase, off blunt mirrors and past rounded bodies."""
    gain = path_gain(search, found, sums, frequency_hz)
    kept = np.flatnonzero(np.abs(gain).max(axis=1, initial=0.0) >= search.lost_in_noise)
    gain[kept] *= off_blunt_mirrors(search, found[kept], frequency_hz)
    gain[kept] *= behind_rounded(search, found[kept], frequency_hz)
    return gain


def _passed(search: Search, reason: Reason, found: Candidates, kept: Flags, sums: Complexes) -> Candidates:
    """What a mask keeps. The rest is booked at the level it would have, at a focus at most `FOCUS_GAIN`."""

    def described() -> Rejected:
        rejected = found[~kept]
        gain = _gain(search, rejected, sums, np.array([REFERENCE_HZ]))
        return Rejected(np.minimum(np.abs(gain[:, 0]), FOCUS_GAIN / rejected.length_m), rejected.__getitem__)

    count = len(found) - int(kept.sum())
    search.reject(reason, count, described)
    return found[kept] if count else found


def _short_enough(search: Search, found: Candidates) -> Flags:
    """(C,) whether an echo is within the range; the direct sound always is."""
    return (found.order == 0) | (found.length_m <= search.limit_m)


def _unhidden(search: Search, found: Candidates) -> Flags:
    """(C,) whether nothing stands in the way.

    Facets of cells and edges of chains were asked before. What passes around rounded parts is weakened by them, but for
    those of the pieces of a mesh that it meets; and so is what an edge diffracts just behind a second one.
    """
    tracing, free = search.tracing, found.cell >= 0
    world, around = tracing.world, passes_around(found)
    for rows, blockers in ((around, world.sharp), (~(around | free), world.blockers)):
        free[rows] = segments_free(tracing, found[rows], blockers)
    behind = np.flatnonzero(around & ~free & (found.edge >= 0))
    free[behind] = passes_over_edges(search, found[behind])
    own = world.parts_met(found.sequence) & (around & free)[:, None]
    for part in np.flatnonzero(own.any(axis=0)):
        mine = own[:, part]
        free[mine] &= segments_free(tracing, found[mine], (world.rounded.blockers[part],))
    return free


def _uncovered(search: Search, found: Candidates) -> Flags:
    """(C,) False for what another sheet lies upon."""
    return ~covered(search.tracing, found)


def _over_noise(search: Search, found: Candidates, gain: Complexes) -> Flags:
    """(C,) False for what the matched filter leaves deep under the noise; a phone without noise keeps all.

    The cells of one way over a body stand or fall together, by the mean level of their sum over the band: no peak of
    the matched filter exceeds it. The loudest cell alone is up to 6 dB fainter than all of them, the more the narrower
    cells are: levels of fidelity then differed by 0.5 dB.
    """
    level = np.abs(gain).max(axis=1)
    cells = np.flatnonzero(found.cell >= 0)
    group = distinct(np.column_stack([found.pose[cells], found.mic[cells], found.sequence[cells]]))[1]
    total = np.zeros((group.max(initial=-1) + 1, gain.shape[1]), dtype=np.complex128)
    turn = np.exp(-1j * found.length_m[cells, None] * search.band_wavenumber_1_m)
    np.add.at(total, group, gain[cells] * turn)
    level[cells] = np.abs(total).mean(axis=1)[group]
    return (level >= search.lost_in_noise) & (level > 0.0)


def _out_of_focus(_search: Search, found: Candidates) -> Flags:
    """(C,) False where a concave mirror gathers rays on the receiver: the ray tube closes and its level diverges."""
    clear = np.ones(len(found), dtype=bool)
    rows = np.flatnonzero((found.face >= 0).any(axis=1))
    curved = found[rows]
    clear[rows] = curved.amplitude * curved.length_m <= FOCUS_GAIN
    return clear


MASKS: dict[Reason, Callable[[Search, Candidates], Flags]] = {
    Reason.TOO_LONG: _short_enough,
    Reason.HIDDEN: _unhidden,
    Reason.BEHIND_SHEET: _uncovered,
    Reason.TWIN: first_of_twins,
    Reason.AT_FOCUS: _out_of_focus,
}  # in turn: each is asked about what passed those before it


def _paths(search: Search, found: Candidates, gain: Complexes) -> Paths:
    tracing = search.tracing
    return Paths(
        delay_s=found.length_m / search.air.sound_speed_m_s,
        band_gain=gain, mic=found.mic, pose=found.pose, order=found.order,
        kind=found.kind,
        obstacle=names_of(tracing.world, found), sequence=found.sequence,
        points_m=found.points_m + tracing.world.origin_m, face=found.face, uv=found.uv,
        phone=search.phone, poses=len(tracing.pose), rejected=search.log.totals,
        left_out=_left_out(tracing.world, search.fidelity), choices=tuple(search.log.choices),
    )  # fmt: skip


def _left_out(world: World, fidelity: Fidelity) -> tuple[str, ...]:
    """What no run models of such a scene, and what this fidelity leaves out."""
    lines = not_modelled(world) + tuple(f"mechanism '{m}'" for m in MECHANISMS if m not in fidelity.mechanisms)
    several = min(fidelity.edge_order, fidelity.max_order) >= 2
    if "edges" in fidelity.mechanisms and not several and len(world.wedges) > 1:
        lines += ("paths over several edges of a thin panel (edge_order 1)",)
    return lines


def names_of(world: World, found: Candidates) -> Strings:
    """(C,) obstacles met, joined by " > "."""
    if not len(found):
        return np.zeros(0, dtype="<U1")
    met = world.obstacle_of(found.sequence)
    first, which = distinct(met)
    labels = [" > ".join(world.obstacles[i].name for i in row if i >= 0) for row in met[first]]
    return np.array(labels, dtype=np.str_)[which]


def through_case(search: Search, sound: StructureBorne, width: int) -> Paths:
    """One path a pose and microphone, in the form of airborne ones of at most so many reflections, named "case"."""
    found = direct(search.tracing, width)
    gain = np.repeat(sound.gain[found.mic, None].astype(np.complex128), len(search.band_hz), axis=1)
    return replace(_paths(search, found, gain), delay_s=sound.delay_s[found.mic], obstacle=np.full(len(found), CASE))
