"""Paths to samples: the beep, filtered as each path filters it, at each path's emission times.

Paths are summed as complex envelopes about 20 kHz at a low rate, where the beep is evaluated at the exact retarded
times and passes the microphones; then the samples in between are filled in.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.support.argument_types import as_number, check_seed, check_types
from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints, Singles
from simulator.field.motion import Motion, check_smooth, fastest_closing_m_s, motion_within, velocities_of
from simulator.paths import Paths
from simulator.phone.noise import noise_samples
from simulator.phone.phone import Phone
from simulator.phone.transducers import StructureBorne
from simulator.rendering.beep_table import SKIRT_S, beep_table
from simulator.rendering.overlap import overlapped
from simulator.rendering.sample_rate import envelope_rate, lead_samples, ringing
from simulator.rendering.sample_rate import to_rate as to_rate
from simulator.rendering.superposition import Sounds, add_sounds
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Walk, poses_of
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import traced
from simulator.waves import band
from simulator.waves.sweep import Sweep
from simulator.world.clearance import check_passage
from simulator.world.prepared_scene import PreparedScene, as_prepared
from simulator.world.search_context import Search
from simulator.world.world import Tracing

FASTEST = 0.1  # of the speed of sound
LONGEST_S = 4.0 * 3600.0  # of a walk: a row for each beep is kept, and its steps are followed, 100 a second
SOONEST_S = 1e-12  # after emission: levels are inverse to the delay
BLOCK_BEEPS = 64  # traced and rendered at a time


def render_walk(
    scene: Scene | PreparedScene,
    phone: Phone,
    walk: Walk,
    beep: BeepDesign,
    fidelity: Fidelity | None = None,
    seed: int = 0,
    gated: Collection[str] = (),
    seen: Callable[[Paths, int], None] | None = None,
) -> Recording:
    """What the phone's two microphones record on a walk; beep 0 leaves the speaker at sample 0.

    Args:
        scene: obstacles and air; prepared, it costs less from the second walk on.
        phone: transducers, levels, noise, and the walker's body if it is held.
        walk: where the phone is at every instant; whole beeps within its duration are rendered.
        beep: the emitted signal; its rate is the recording's.
        fidelity: what is modelled; None takes the defaults.
        seed: of the noise; the same seed gives the same samples bit for bit on the same machine and versions.
        gated: names of obstacles whose echoes are left out of the recording: paths that meet these obstacles and no
            other. What they hide, and what they add to the echoes of others, stays.
        seen: told the paths of every block of beeps that is rendered, and the number of its first beep, which
            `Paths.pose` counts from: for those who keep both sound and paths.

    Raises:
        ValueError: an argument of another type, a name that no obstacle has, a walk shorter than one beep period, a
            band that passes 15-25 kHz, in which gains are kept, a beep of less than about 1 ms, phone and obstacle that
            may close in at a tenth of the speed of sound or more or pass through each other, a phone that moves too
            abruptly within a beep to be followed, or poses or a walker's body that `trace_paths` refuses.

    Example:
        >>> import trimesh
        >>> from obstaclewatch import BeepDesign
        >>> from simulator import Material, Obstacle, Phone, Scene, StraightWalk, render_walk
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.named("brick"), "wall")])
        >>> walk = StraightWalk([0.0, 0.0, 1.3], heading_rad=0.0, speed_m_s=1.3, duration_s=0.1)
        >>> recording = render_walk(scene, Phone.named("galaxy-s8-plus"), walk, BeepDesign(), seed=1)
        >>> recording.samples.shape, recording.sample_rate_hz  # one beep of 90 ms at both microphones
        ((2, 17280), 192000.0)
    """
    pieces = render_pieces(scene, phone, walk, beep, fidelity, seed, gated, seen)
    samples, done = np.empty((2, beep_count(walk, beep) * beep.period_samples), dtype=np.float32), 0
    for piece in pieces:
        samples[:, done : done + piece.samples.shape[1]] = piece.samples
        done += piece.samples.shape[1]
    return Recording(samples, beep.sample_rate_hz)


def render_pieces(
    scene: Scene | PreparedScene,
    phone: Phone,
    walk: Walk,
    beep: BeepDesign,
    fidelity: Fidelity | None = None,
    seed: int = 0,
    gated: Collection[str] = (),
    seen: Callable[[Paths, int], None] | None = None,
) -> Iterator[Recording]:
    """The samples of `render_walk`, bit for bit, in pieces of seconds: in memory that no walk is too long for.

    Raises:
        ValueError: as `render_walk`; of what happens on the walk only when a piece gets there.

    Example:
        >>> from obstaclewatch import BeepDesign
        >>> from simulator import Phone, Scene, StraightWalk, render_pieces
        >>> walk = StraightWalk([0.0, 0.0, 1.3], heading_rad=0.0, speed_m_s=1.3, duration_s=12.0)
        >>> [round(piece.duration_s, 2) for piece in render_pieces(Scene([]), Phone.named("ideal"), walk, BeepDesign())]
        [5.26, 5.76, 0.95]
    """
    fidelity = Fidelity() if fidelity is None else fidelity
    check_seed(seed=seed)
    scene = as_prepared(scene)
    check_types(phone=(phone, Phone), walk=(walk, Walk), beep=(beep, BeepDesign), fidelity=(fidelity, Fidelity))
    _check_band(beep)
    if seen is not None and not callable(seen):
        raise ValueError(f"seen must be a function of paths and a beep's number, got {seen!r}")
    count, gated = beep_count(walk, beep), _known(gated, scene)
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    early = int(np.ceil(SKIRT_S * beep.sample_rate_hz))

    def sounds(first: int) -> tuple[int, Singles]:
        among = range(first, min(first + BLOCK_BEEPS, count))
        paths, motion = _traced_beeps(scene, phone, walk, beep, fidelity, among)
        if gated:
            kept = ungated(paths, gated)
            paths, motion = paths[kept], motion[kept]
        if seen is not None:
            seen(paths, first)
        motion = replace(motion, middle_s=motion.middle_s - first * beep.period_s + early / beep.sample_rate_hz)
        envelope = sum_envelopes(paths, motion, beep, len(among), early / beep.sample_rate_hz)
        return first * beep.period_samples - early, ringing(envelope, phone, beep)

    def noisy(echoes: Singles) -> Recording:
        noise = noise_samples(phone, echoes.shape[1], beep.sample_rate_hz, rng)
        return Recording((echoes * phone.full_scale_gain + noise).astype(np.float32), beep.sample_rate_hz)

    blocks = (sounds(first) for first in range(0, count, BLOCK_BEEPS))
    return (noisy(echoes) for echoes in overlapped(blocks, lead_samples(beep), count * beep.period_samples))


def beep_count(walk: Walk, beep: BeepDesign) -> int:
    """Whole beep periods within a walk.

    Raises:
        ValueError: there is none, or the duration is no finite number or above four hours.
    """
    duration_s = as_number("duration_s", walk.duration_s)
    if not np.isfinite(duration_s):
        raise ValueError(f"duration_s of the walk must be finite, got {duration_s}")
    if duration_s > LONGEST_S:
        raise ValueError(f"the walk must last at most {LONGEST_S:g} s, got {duration_s:g} s")
    count = beep.beeps_in(max(duration_s, 0.0))
    if count < 1:
        raise ValueError(f"the walk must last one beep period ({beep.period_s} s) or more, got {duration_s} s")
    return count


def ungated(paths: Paths, obstacles: Collection[str]) -> Flags:
    """(P,) False for the echoes of these obstacles alone; the direct sound is nobody's echo."""
    gated = set(obstacles)
    return np.array([not met or not set(met) <= gated for met in paths.obstacles_met()], dtype=bool)


def _known(names: Collection[str], scene: PreparedScene) -> Collection[str]:
    there = [obstacle.name for obstacle in scene.obstacles]
    if isinstance(names, str) or not isinstance(names, Collection):
        raise ValueError(f"gated must be several of the scene's obstacles, {there}, got {names!r}")
    unknown = [name for name in names if name not in there]
    if unknown:
        raise ValueError(f"gated must be names of the scene's obstacles, {there}, got {unknown}")
    return names


def trace_walk(
    scene: Scene | PreparedScene, phone: Phone, walk: Walk, beep: BeepDesign, fidelity: Fidelity
) -> tuple[Paths, Motion, int]:
    """Paths at the middle of every beep, how they move within it, and the number of beeps."""
    _check_band(beep)
    count = beep_count(walk, beep)
    return *_traced_beeps(as_prepared(scene), phone, walk, beep, fidelity, range(count)), count


def _traced_beeps(
    scene: PreparedScene, phone: Phone, walk: Walk, beep: BeepDesign, fidelity: Fidelity, beeps: range
) -> tuple[Paths, Motion]:
    """Paths at the middle of some beeps, counted from the first of them, and how they move within them."""
    start = np.arange(beeps.start, beeps.stop, dtype=np.float64) * beep.period_s
    middle = start + 0.5 * beep.duration_s
    points = phone.geometry.speaker_m, phone.geometry.mics_m
    pose = poses_of(walk, middle)
    _check_speeds(scene, walk, start, beep.duration_s)
    check_smooth(walk, points, start, beep.duration_s, fidelity.motion_degree)

    def carrier(_pose: Ints, time_s: Floats) -> tuple[Floats, Floats]:
        there = walk.pose(time_s)
        return there.position_m, there.body_heading_rad()

    tracing = scene.tracing(phone, pose, middle, fidelity.mechanisms, carrier)
    before = start[:1] - beep.period_s + beep.duration_s if beeps.start else start[:0]
    _check_passage(tracing, phone, walk, np.sort(np.concatenate([before, start, start + beep.duration_s])))
    sweep = Sweep.of(beep, velocities_of(walk, points, middle, beep.duration_s))
    paths, found = traced(Search(tracing, phone, scene.air, fidelity, sweep))
    return paths, motion_within(
        tracing, walk, points, found, start, beep.duration_s, scene.air.sound_speed_m_s, fidelity.motion_degree
    )


def _check_band(beep: BeepDesign) -> None:
    """Refuse frequencies at which no gains are kept."""
    if min(beep.start_hz, beep.stop_hz) < band.LOW_HZ or max(beep.start_hz, beep.stop_hz) > band.HIGH_HZ:
        raise ValueError(f"the beep must lie within 15-25 kHz, got {beep.start_hz:g}-{beep.stop_hz:g} Hz")


def _check_passage(tracing: Tracing, phone: Phone, walk: Walk, time_s: Floats) -> None:
    """Refuse what the phone would have to pass through from one instant to the next."""
    pose = walk.pose(time_s)
    pose = replace(pose, position_m=pose.position_m - tracing.world.origin_m)
    ends = pose.to_world(phone.geometry.speaker_m)[:, None], pose.to_world(phone.geometry.mics_m)
    check_passage(tracing, time_s, np.concatenate(ends, axis=1))


def _check_speeds(scene: Scene | PreparedScene, walk: Walk, start_s: Floats, duration_s: float) -> None:
    """Refuse what retarded times do not settle for."""
    closing = fastest_closing_m_s(scene.obstacles, walk, start_s, duration_s)
    limit = FASTEST * scene.air.sound_speed_m_s
    if not closing < limit:
        raise ValueError(
            f"phone and obstacles must close in at less than {limit:.1f} m/s, got up to {closing:.1f} m/s"
            f"{_fastest_named(scene.obstacles)}"
        )


def _fastest_named(obstacles: Sequence[Obstacle]) -> str:
    """ " with 'car' at 30.0 m/s", or nothing where none moves."""
    speeds = {obstacle.name: float(np.linalg.norm(obstacle.velocity_m_s)) for obstacle in obstacles if obstacle.moves}
    name = max(speeds, key=speeds.__getitem__, default=None)
    return "" if name is None else f" with '{name}' at {speeds[name]:.1f} m/s"


def sum_envelopes(paths: Paths, motion: Motion, beep: BeepDesign, count: int, first_s: float = 0.0) -> Complexes:
    """(2, n) complex envelopes about 20 kHz of all paths, at the envelope rate: all beeps, until all have arrived.

    Args:
        first_s: emission of the first beep, after the first sample of the sum; the motion counts from that sample, too.
    """
    rate = envelope_rate(beep)
    table = beep_table(beep, paths.phone.speaker, paths.band_gain.shape[1], rate)
    start = first_s + np.arange(count, dtype=np.float64) * beep.period_s
    sounds = [Sounds(start[paths.pose], paths.mic, band.coefficients(paths.band_gain), motion, paths.delay_s)]
    if paths.phone.structure_borne is not None:
        sounds.append(_structure_borne(paths.phone.structure_borne, start, beep.duration_s, paths.band_gain.shape[1]))
    end = max(first_s + count * beep.period_s, *(sound.end_s(beep.duration_s) for sound in sounds))
    total = np.zeros((2, 2, int(np.ceil(end * rate)) + 1))
    for sound in sounds:
        add_sounds(total, rate, table, sound)
    envelope = np.empty((2, total.shape[2]), dtype=np.complex128)
    envelope.real, envelope.imag = total[:, 0], total[:, 1]
    return envelope


def _structure_borne(sound: StructureBorne, start_s: Floats, duration_s: float, terms: int) -> Sounds:
    """Direct sound through the case: the same in every beep."""
    start, mic = np.repeat(start_s, 2), np.tile([0, 1], len(start_s))
    delay = np.maximum(sound.delay_s[mic], SOONEST_S)
    weight = np.zeros((len(mic), terms), dtype=np.complex128)
    weight[:, 0] = sound.gain[mic]
    still = Motion(start + delay + 0.5 * duration_s, duration_s, delay[:, None].copy(), np.ones((len(mic), 1)))
    return Sounds(start, mic, weight, still, delay)
