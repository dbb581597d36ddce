"""Paths to samples: the beep, filtered as each path filters it, at each path's emission times.

Paths are summed as complex envelopes about 20 kHz at a low rate, where the beep is evaluated at the exact retarded
times; one Fourier transform a microphone then brings the sum to the recording's rate. The envelope of the beep is
kept once for every Chebyshev polynomial of frequency, so a path's gain over frequency costs a few multiplications.

The transform takes its samples for a circle. The sum therefore runs on until the last echo has arrived whole, silence
follows, and only then is the recording cut out of it: what its end cuts off would otherwise come in at its start.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numba
import numpy as np
import scipy.fft
from numpy.polynomial import chebyshev

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.support.argument_types import check_seed, check_types
from obstaclewatch.support.arrays import Complexes, Flags, Floats, Ints
from simulator.field.motion import Motion, fastest_closing_m_s, motion_within
from simulator.paths import Paths
from simulator.phone.noise import noise_samples
from simulator.phone.phone import Phone
from simulator.phone.transducers import StructureBorne
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Walk
from simulator.scene.scene import Scene
from simulator.trace import traced, tracing_of
from simulator.waves import band
from simulator.waves.band import REFERENCE_HZ
from simulator.world.clearance import check_passage
from simulator.world.search_context import Search
from simulator.world.world import Tracing, prepare

ENVELOPE_RATE_HZ = 24_000.0  # the beep's spectrum 12 kHz off its centre is below 1e-8 of its energy
TABLE_RATE_HZ = 96_000.0
TABLE_MARGIN = 32  # table samples kept beyond both ends of the beep for the skirts of filtered beeps
TAPS = 8
SKIRT_S = (TABLE_MARGIN - TAPS) / TABLE_RATE_HZ
SILENCE_S = 0.1  # before the circle closes; of a sound are then left 1e-9, and 5e-5 after a galaxy-s5's microphone
FASTEST = 0.1  # of the speed of sound
NEGLIGIBLE = 1e-7  # of a path's strongest Chebyshev term; weaker ones are left out


def render_walk(
    scene: Scene,
    phone: Phone,
    walk: Walk,
    beep: BeepDesign,
    fidelity: Fidelity | None = None,
    seed: int = 0,
    unheard: Collection[str] = (),
) -> Recording:
    """What the phone's two microphones record on a walk; beep 0 leaves the speaker at sample 0.

    Args:
        scene: obstacles and air.
        phone: transducers, levels, noise, and the walker's body if it is held.
        walk: where the phone is at every instant; whole beeps within its duration are rendered.
        beep: the emitted signal; its rate is the recording's.
        fidelity: what is modelled; None takes the defaults.
        seed: of the noise; the same seed gives the same samples bit for bit.
        unheard: names of obstacles whose own echoes an oracle gates out: paths that meet these obstacles and no other.
            What they hide, and what they add to the echoes of others, stays.

    Raises:
        ValueError: an argument of another type, a name that no obstacle has, a walk shorter than one beep period, a
            band that passes what the tables hold (15-25 kHz), phone and obstacle that may close in at a tenth of the
            speed of sound or more or pass through each other, or poses that `trace_paths` refuses.

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
    fidelity = fidelity or Fidelity()
    check_seed(seed=seed)
    check_types(
        scene=(scene, Scene), phone=(phone, Phone), walk=(walk, Walk), beep=(beep, BeepDesign),
        fidelity=(fidelity, Fidelity),
    )  # fmt: skip
    paths, motion, count = trace_walk(scene, phone, walk, beep, fidelity)
    if unheard:
        kept = heard_without(paths, _known(unheard, scene))
        paths, motion = paths[kept], motion[kept]
    envelope = sum_envelopes(paths, motion, beep, count)
    samples = to_rate(envelope, phone, beep, count * beep.period_samples) * phone.full_scale_gain
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    samples += noise_samples(phone, samples.shape[1], beep.sample_rate_hz, rng)
    return Recording(samples.astype(np.float32), beep.sample_rate_hz)


def heard_without(paths: Paths, obstacles: Collection[str]) -> Flags:
    """(P,) False for the echoes of these obstacles alone; the direct sound is nobody's echo."""
    ways, which = np.unique(paths.obstacle, return_inverse=True)
    kept = np.array([way == "" or not set(way.split(" > ")) <= set(obstacles) for way in ways], dtype=bool)
    return kept[which] if len(paths) else np.zeros(0, dtype=bool)


def _known(names: Collection[str], scene: Scene) -> Collection[str]:
    there = [obstacle.name for obstacle in scene.obstacles]
    unknown = sorted(set(names) - set(there))
    if unknown:
        raise ValueError(f"unheard must be names of the scene's obstacles, {there}, got {unknown}")
    return names


def trace_walk(
    scene: Scene, phone: Phone, walk: Walk, beep: BeepDesign, fidelity: Fidelity
) -> tuple[Paths, Motion, int]:
    """Paths at the middle of every beep, how they move within it, and the number of beeps."""
    count = int(np.floor(walk.duration_s / beep.period_s + 1e-9))
    if count < 1:
        raise ValueError(f"the walk must last one beep period ({beep.period_s} s) or more, got {walk.duration_s} s")
    if min(beep.start_hz, beep.stop_hz) < band.LOW_HZ or max(beep.start_hz, beep.stop_hz) > band.HIGH_HZ:
        raise ValueError(f"the beep must lie within 15-25 kHz, got {beep.start_hz:g}-{beep.stop_hz:g} Hz")
    start = np.arange(count, dtype=np.float64) * beep.period_s
    middle = start + 0.5 * beep.duration_s
    pose = walk.pose(middle)
    _check_speeds(scene, walk, start, beep.duration_s)
    origin = pose.position_m.mean(axis=0)
    world = prepare(scene, phone, origin, fidelity.mechanisms)

    def carrier(_pose: Ints, time_s: Floats) -> tuple[Floats, Floats]:
        there = walk.pose(time_s)
        return there.position_m - origin, there.body_heading_rad()

    tracing = tracing_of(world, phone, replace(pose, position_m=pose.position_m - origin), middle, carrier)
    _check_passage(tracing, phone, walk, np.sort(np.concatenate([start, start + beep.duration_s])))
    paths, found = traced(Search(tracing, phone, scene.air, fidelity))
    points = phone.geometry.speaker_m, phone.geometry.mics_m
    motion = motion_within(
        tracing, walk, points, found, start, beep.duration_s, scene.air.sound_speed_m_s, fidelity.motion_degree
    )
    return paths, motion, count


def _check_passage(tracing: Tracing, phone: Phone, walk: Walk, time_s: Floats) -> None:
    """Refuse what the phone would have to pass through from one instant to the next."""
    pose = walk.pose(time_s)
    pose = replace(pose, position_m=pose.position_m - tracing.world.origin_m)
    ends = pose.to_world(phone.geometry.speaker_m)[:, None], pose.to_world(phone.geometry.mics_m)
    check_passage(tracing, time_s, np.concatenate(ends, axis=1))


def _check_speeds(scene: Scene, walk: Walk, start_s: Floats, duration_s: float) -> None:
    """Refuse what retarded times do not settle for."""
    closing = fastest_closing_m_s(scene.obstacles, walk, start_s, duration_s)
    limit = FASTEST * scene.air.sound_speed_m_s
    if not closing < limit:
        raise ValueError(f"phone and obstacles must close in at less than {limit:.1f} m/s, got up to {closing:.1f} m/s")


def sum_envelopes(paths: Paths, motion: Motion, beep: BeepDesign, count: int) -> Complexes:
    """(2, n) complex envelopes about 20 kHz of all paths, at the envelope rate: all beeps, until all have arrived."""
    rate = _envelope_rate(beep)
    table = beep_table(beep, paths.phone, paths.band_gain.shape[1])
    start = np.arange(count, dtype=np.float64) * beep.period_s
    sounds = [_Sounds(start[paths.pose], paths.mic, band.coefficients(paths.band_gain), motion, paths.delay_s)]
    if paths.phone.structure_borne is not None:
        sounds.append(_structure_borne(paths.phone.structure_borne, beep, count, len(table)))
    reaches = [sound.reach_s(beep.duration_s) for sound in sounds]
    ends = [(sound.motion.middle_s + reach).max(initial=0.0) for sound, reach in zip(sounds, reaches, strict=True)]
    total = np.zeros((2, int(np.ceil(max(count * beep.period_s, *ends) * rate)) + 1), dtype=np.complex128)
    for sound, reach in zip(sounds, reaches, strict=True):
        _accumulate(
            total, rate, table, sound.start_s, beep.duration_s, sound.mic, sound.weight, sound.motion.middle_s, reach,
            sound.motion.half_width_s, sound.motion.delay_s, sound.motion.strength, sound.center_delay_s,
        )  # fmt: skip
    return total


@dataclass(frozen=True)
class _Sounds:
    """P beeps under way: when each leaves, the microphone it reaches, its gain over frequency, and its motion.

    Attributes:
        start_s: (P,) emission of the beep's first sample.
        mic: (P,) microphone.
        weight: (P, K) Chebyshev coefficients of the gain.
        motion: delay and strength as they change within the beep.
        center_delay_s: (P,) travel time of the beep's middle, to which the gain belongs.
    """

    start_s: Floats
    mic: Ints
    weight: Complexes
    motion: Motion
    center_delay_s: Floats

    def reach_s(self, duration_s: float) -> Floats:
        """(P,) how far from the motion's middle anything of a beep may be heard."""
        delay = self.motion.delay_s
        late = np.abs(chebyshev.chebval(0.0, delay.T) - self.center_delay_s)
        receding = delay[:, 1] / self.motion.half_width_s if delay.shape[1] > 1 else 0.0  # over c; stretches the beep
        return (0.5 * duration_s + late) * np.maximum(1.02, 1.001 / (1.0 - receding)) + SKIRT_S


def beep_table(beep: BeepDesign, phone: Phone, terms: int) -> Complexes:
    """(K, n) envelopes about 20 kHz of the emitted beep through each Chebyshev polynomial of frequency.

    The speaker's response is in them. Row 0 of a flat speaker is the beep itself.
    """
    size = scipy.fft.next_fast_len(2 * TABLE_MARGIN + round(beep.duration_s * TABLE_RATE_HZ) + 1)
    time = (np.arange(size) - TABLE_MARGIN) / TABLE_RATE_HZ
    envelope = beep.window(time) * np.exp(1j * (beep.phase_rad(time) - 2.0 * np.pi * REFERENCE_HZ * time))
    spectrum = scipy.fft.fft(envelope)
    frequency = scipy.fft.fftfreq(size, 1.0 / TABLE_RATE_HZ) + REFERENCE_HZ
    unit = np.clip(band.to_unit(frequency), -1.0, 1.0)
    filters = chebyshev.chebvander(unit, terms - 1).T * phone.speaker.response(frequency)
    return scipy.fft.ifft(spectrum * filters, axis=1)


def to_rate(envelope: Complexes, phone: Phone, beep: BeepDesign, count: int) -> Floats:
    """(2, count) real samples at the beep's rate from envelopes about 20 kHz, through the microphones' responses.

    The envelopes must hold all sounds to their ends, as `sum_envelopes` leaves them: what breaks off rings over all of
    the recording.
    """
    rate = _envelope_rate(beep)
    size = scipy.fft.next_fast_len(envelope.shape[1] + round(SILENCE_S * rate))
    period = size / rate
    carrier = round(REFERENCE_HZ * period) / period  # the bin nearest to 20 kHz
    turn = np.exp(2j * np.pi * (REFERENCE_HZ - carrier) * np.arange(envelope.shape[1]) / rate)
    frequency = scipy.fft.fftfreq(size, 1.0 / rate) + carrier
    spectrum = scipy.fft.fft(envelope * turn, n=size, axis=1)
    spectrum *= np.stack([mic.response(frequency) for mic in phone.mics])
    fine = round(period * beep.sample_rate_hz)
    bins = np.round(frequency * period).astype(np.int64)
    inside = (bins > 0) & (bins < fine // 2)
    half = np.zeros((2, fine // 2 + 1), dtype=np.complex128)
    half[:, bins[inside]] = spectrum[:, inside] * (0.5 * fine / size)
    return scipy.fft.irfft(half, n=fine, axis=1)[:, :count]


def _envelope_rate(beep: BeepDesign) -> float:
    """The recording's rate over a whole number, 24 kHz or little more."""
    return beep.sample_rate_hz / (beep.sample_rate_hz // ENVELOPE_RATE_HZ)


def _structure_borne(sound: StructureBorne, beep: BeepDesign, count: int, terms: int) -> _Sounds:
    """Direct sound through the case: the same in every beep."""
    pose, mic = (index.ravel() for index in np.indices((count, 2)))
    start, delay = beep.period_s * pose.astype(np.float64), sound.delay_s[mic]
    weight = np.zeros((len(mic), terms), dtype=np.complex128)
    weight[:, 0] = sound.gain[mic]
    middle = start + delay + 0.5 * beep.duration_s
    still = Motion(middle, beep.duration_s, delay[:, None].copy(), np.ones((len(mic), 1)))
    return _Sounds(start, mic, weight, still, delay)


@numba.njit(cache=True)
def _chebyshev_sum(coefficient, x):
    """Clenshaw's recurrence."""
    b1 = b2 = 0.0
    for k in range(len(coefficient) - 1, 0, -1):
        b1, b2 = 2.0 * x * b1 - b2 + coefficient[k], b1
    return x * b1 - b2 + coefficient[0]


_LAGRANGE_SCALE = np.array(
    [1.0 / np.prod([float(i - j) for j in range(TAPS) if j != i]) for i in range(TAPS)]
)  # 1 / product of the distances between the taps


@numba.njit(cache=True)
def _lagrange(position, weight):
    """Weights of the 8 samples round a position (in samples); returns the first of them."""
    first = int(np.floor(position)) - TAPS // 2 + 1
    offset = position - first
    product = 1.0
    for i in range(TAPS):
        weight[i] = product * _LAGRANGE_SCALE[i]
        product *= offset - i
    product = 1.0
    for i in range(TAPS - 1, -1, -1):
        weight[i] *= product
        product *= offset - i
    return first


@numba.njit(cache=True)
def _accumulate(
    total, rate, table, start, duration, mic, weight, middle, reach, half_width, delay, strength, center_delay
):  # fmt: skip
    """Add every path's envelope at its retarded times, rows in order."""
    taps = np.empty(TAPS)
    terms, length = table.shape
    mixed = np.empty(length, np.complex128)
    for p in range(len(start)):
        mixed[:] = 0.0
        faintest = NEGLIGIBLE * np.abs(weight[p]).max()
        for k in range(terms):
            if np.abs(weight[p, k]) > faintest:
                for i in range(length):
                    mixed[i] += weight[p, k] * table[k, i]
        first = max(int(np.ceil((middle[p] - reach[p]) * rate)), 0)
        last = min(int(np.floor((middle[p] + reach[p]) * rate)), total.shape[1] - 1)
        for n in range(first, last + 1):
            time = n / rate
            x = (time - middle[p]) / half_width
            travel = _chebyshev_sum(delay[p], x)
            emitted = time - travel - start[p]
            if emitted < -SKIRT_S or emitted > duration + SKIRT_S:
                continue
            begin = _lagrange(emitted * TABLE_RATE_HZ + TABLE_MARGIN, taps)
            value = 0.0 + 0.0j
            for i in range(TAPS):
                value += taps[i] * mixed[begin + i]
            level = _chebyshev_sum(strength[p], x) * center_delay[p] / travel
            total[mic[p], n] += level * value * np.exp(-2j * np.pi * REFERENCE_HZ * (travel + start[p]))
