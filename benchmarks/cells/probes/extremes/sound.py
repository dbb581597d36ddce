"""Rendered beeps against the chirp's formula at the retarded times, at any rate, length, band and speed.

Everything lies on the x axis, so that a moving wall, speaker and microphone each close in at a plain difference of
speeds and the instants of emission are closed forms.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.cells.probes.extremes.mirrors import AHEAD, MICS_M, SOUND_M_S, SPEAKER_M, moved, slab, wall
from benchmarks.cells.probes.extremes.verdict import Error, Errors, Refusal, must_refuse
from obstaclewatch import BeepDesign, Recording
from obstaclewatch.support.arrays import Floats, Singles
from simulator import Air, Fidelity, Phone, Scene, StraightWalk, render_pieces, render_walk

SHAPE = 1e-4
"""Of the peak: float32 samples have 6e-8, the band's nodes and the fit of motion leave 1e-5."""
PHASE_DEG = 0.04
"""A thousandth of a sample at the middle of the band, 20.5 kHz."""
MODELLED_HZ = (15_000.0, 25_000.0)
"""Where materials, air and phones have tables: what a short beep spills beyond it is not rendered."""
WALL_M = 1.5
LONG_M = 4.0


def sample_rate(sample_rate_hz: float) -> Errors:
    """One beep off a wall, rendered at this rate."""
    return _rendered(BeepDesign(18_000.0, 21_500.0, sample_rate_hz=sample_rate_hz))


def beep_length(duration_s: float) -> Errors:
    """One beep of this length."""
    return _rendered(BeepDesign(duration_s=duration_s, sample_rate_hz=192_000.0 if duration_s < 1.0 else 48_000.0))


def band_edge(stop_over_nyquist: float) -> Errors | Refusal:
    """A beep whose band ends at this share of half the sample rate; from 1 on it must be refused."""
    stop = 24_000.0 * stop_over_nyquist
    if stop_over_nyquist >= 1.0:
        return must_refuse(lambda: BeepDesign(18_000.0, stop, sample_rate_hz=48_000.0), f"got {stop} Hz")
    return _rendered(BeepDesign(18_000.0, stop, sample_rate_hz=48_000.0))


def walking(speed_m_s: float) -> Errors | Refusal:
    """A phone that walks at the wall at this speed; from a tenth of the speed of sound on it must be refused."""
    return _approaching(speed_m_s, 0.0)


def moving_wall(speed_m_s: float, walker_m_s: float) -> Errors | Refusal:
    """A wall that moves away from (or, negative, at) a phone that walks after it: also one that outruns the walker."""
    return _approaching(walker_m_s, speed_m_s)


def _approaching(walker_m_s: float, wall_m_s: float) -> Errors | Refusal:
    closing = walker_m_s - wall_m_s
    away = WALL_M + 0.1 * max(0.0, closing)
    if abs(closing) >= 0.1 * SOUND_M_S:
        return must_refuse(lambda: _rendered(BeepDesign(), walker_m_s, wall_m_s, away), f"got up to {abs(closing)} m/s")
    return _rendered(BeepDesign(), walker_m_s, wall_m_s, away)


def walk_length(duration_s: float) -> Errors | Refusal:
    """A walk of whole beeps; of none it must be refused."""
    beep = BeepDesign()
    if duration_s < beep.period_s:
        return must_refuse(lambda: _recorded(_walk(0.0, duration_s), beep), "must", f"got {duration_s}")
    recording = _recorded(_walk(0.0, duration_s), beep)
    wanted = beep.beeps_in(duration_s) * beep.period_samples
    return {"samples": Error(float(recording.samples.shape[1] - wanted), 0.5)}


def rendered_phase(distance_m: float, offset_m: float) -> Errors:
    """The phase of a rendered echo: a wall far away, after the direct sound and all of it far from the origin."""
    gap_s = max(0.04, float(np.ceil(2000.0 * distance_m / SOUND_M_S) + 10.0) / 1000.0)
    beep, shift = BeepDesign(gap_s=gap_s), np.array([offset_m, -offset_m, 0.5 * offset_m])
    scene = Scene([moved(wall(distance_m), shift, Rotation.identity())], Air.lossless(SOUND_M_S))
    fidelity = replace(_FIDELITY, max_range_m=2.0 * distance_m + 1.0)
    samples = render_walk(scene, _phone(), StraightWalk(shift, 0.0, 0.0, beep.period_s), beep, fidelity).samples
    time = np.arange(samples.shape[1]) / beep.sample_rate_hz
    worst = []
    for mic in (0, 1):
        length = 2.0 * distance_m - float(SPEAKER_M[1]) - float(MICS_M[mic, 1])
        received = (time > length / SOUND_M_S) & (time < length / SOUND_M_S + beep.duration_s)
        played = time[received] - length / SOUND_M_S
        parts = np.stack([chirp(played, beep), chirp(played, beep, -0.25)], axis=1)
        level, quadrature = np.linalg.lstsq(parts, samples[mic, received] / _phone().full_scale_gain, rcond=None)[0]
        worst.append((abs(level * length - 1.0), np.degrees(abs(np.arctan2(quadrature, level)))))
    amplitude, phase = np.max(worst, axis=0)
    return {"amplitude": Error(float(amplitude), SHAPE), "phase_deg": Error(float(phase), PHASE_DEG)}


def last_beep(duration_s: float) -> Errors:
    """The last beep of a long walk, rendered in pieces: after an hour it stands where it belongs, to 1e-3 samples."""
    beep, speed = BeepDesign(), 0.5e-3  # 1.8 m in an hour
    count = 0
    for piece in render_pieces(_scene(LONG_M, 0.0), _phone(), _walk(speed, duration_s), beep, _FIDELITY):
        count += piece.samples.shape[1]
        last = piece.samples
    beeps = beep.beeps_in(duration_s)
    away = LONG_M - speed * (beeps - 1) * beep.period_s
    errors = _of_samples(last[:, -beep.period_samples :], beep, speed, 0.0, away)
    return errors | {"samples": Error(float(count - beeps * beep.period_samples), 0.5)}


def _recorded(walk: StraightWalk, beep: BeepDesign) -> Recording:
    return render_walk(_scene(WALL_M, 0.0), _phone(), walk, beep, _FIDELITY)


def _rendered(beep: BeepDesign, walker_m_s: float = 0.0, wall_m_s: float = 0.0, wall_m: float = WALL_M) -> Errors:
    """Worst error of one rendered beep, relative to its peak, and of the echo's own amplitude against 1 / length."""
    recording = render_walk(_scene(wall_m, wall_m_s), _phone(), _walk(walker_m_s, beep.period_s), beep, _FIDELITY)
    return _of_samples(recording.samples, beep, walker_m_s, wall_m_s, wall_m)


def _of_samples(recorded: Singles, beep: BeepDesign, walker_m_s: float, wall_m_s: float, wall_m: float) -> Errors:
    samples = recorded / _phone().full_scale_gain
    time = np.arange(samples.shape[1]) / beep.sample_rate_hz
    errors = [_of_mic(samples[k], float(MICS_M[k, 1]), time, beep, walker_m_s, wall_m_s, wall_m) for k in (0, 1)]
    return {
        "shape": Error(max(shape for shape, _ in errors), SHAPE + spilled(beep)),
        "amplitude": Error(max(amplitude for _, amplitude in errors), SHAPE + spilled(beep)),
    }


def _of_mic(
    samples: Floats, mic_m: float, time_s: Floats, beep: BeepDesign, walker_m_s: float, wall_m_s: float, wall_m: float
) -> tuple[float, float]:
    """Residual of one microphone after direct sound and echo, and by how much their amplitudes are off."""
    c, speaker = SOUND_M_S, float(SPEAKER_M[1])
    mic = mic_m + walker_m_s * time_s
    met = (c * time_s - wall_m + mic) / (c + wall_m_s)  # when what is received was at the wall
    emitted = (c * met - wall_m - wall_m_s * met + speaker) / (c - walker_m_s)
    ahead = np.sign(mic_m - speaker)
    direct = (c * time_s - ahead * (mic - speaker)) / (c - ahead * walker_m_s)
    parts = np.stack([chirp(emitted, beep), chirp(direct, beep)], axis=1)
    first = np.array([2.0 * wall_m - speaker - mic_m, abs(mic_m - speaker)])
    lengths = c * (time_s[:, None] - np.stack([emitted, direct], axis=1))
    parts = parts / np.maximum(lengths, 0.5 * first)
    weights = np.linalg.lstsq(parts, samples, rcond=None)[0]
    shape = np.abs(samples - parts @ weights).max() / np.abs(samples).max()
    return float(shape), float(np.abs(weights - 1.0).max())


def chirp(time_s: Floats, beep: BeepDesign, early: float = 0.0) -> Floats:
    """The Hann-windowed linear chirp, of its numbers alone: phase 2 pi (f0 t + (f1 - f0) t^2 / 2T + early)."""
    share = time_s / beep.duration_s
    turns = beep.start_hz * time_s + 0.5 * (beep.stop_hz - beep.start_hz) * time_s * share + early
    inside = (share > 0.0) & (share < 1.0)
    sound: Floats = np.where(inside, 0.5 * (1.0 - np.cos(2.0 * np.pi * share)) * np.cos(2.0 * np.pi * turns), 0.0)
    return sound


def spilled(beep: BeepDesign) -> float:
    """Most that a beep's sound beyond the band modelled, or beyond half the sample rate, can add up to: sum of |S|."""
    rate = 192_000.0
    count = round(beep.duration_s * rate)
    spectrum = np.abs(np.fft.rfft(chirp(np.arange(count) / rate, beep)))
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    kept = (frequency > MODELLED_HZ[0]) & (frequency < min(MODELLED_HZ[1], 0.5 * beep.sample_rate_hz))
    return float(2.0 * spectrum[~kept].sum() / count)


_FIDELITY = Fidelity(max_order=1, max_range_m=30.0, mechanisms=("specular",))


def _phone() -> Phone:
    return Phone.ideal(SPEAKER_M, MICS_M)


def _walk(speed_m_s: float, duration_s: float) -> StraightWalk:
    return StraightWalk(np.zeros(3), 0.0, speed_m_s, duration_s)


def _scene(distance_m: float, speed_m_s: float) -> Scene:
    velocity = np.array([speed_m_s, 0.0, 0.0])
    wall = slab([distance_m, -20.0, -20.0], [distance_m + 0.1, 20.0, 20.0], velocity_m_s=velocity)
    return Scene([wall], Air.lossless(SOUND_M_S))


assert AHEAD.apply([0.0, 1.0, 0.0])[0] > 0.0  # the closed forms above need the phone's long edge along x
