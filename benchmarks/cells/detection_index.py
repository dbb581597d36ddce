"""How well a target could be detected at best: the detection index of its strongest echo between 2 and 1 m.

d^2 = 2 E / N0 is the power that a matched filter's peak has over its noise (Kay 1998, Detection theory, section 4.3):
what a walk offers to any detector, from the simulated paths and the phone's noise alone. `snr_db` of a detection
estimates the same from a recording.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from benchmarks.cells.situations.situation import Situation
from obstaclewatch import BeepDesign
from obstaclewatch.support.arrays import Flags, Floats
from scenes.truth.truth import GroundTruth
from simulator import Fidelity, trace_paths
from simulator.paths import Paths
from simulator.phone.noise import noise_density

RANGE_M = (1.0, 2.0)
"""Ranges of the target at which its echo counts: where an alert has to be decided."""
NO_ECHO_DB = -100.0
MOST_POSES = 4
"""Poses at which it is traced, spread over those ranges."""
RATE_HZ = 40_000.0
"""At which the compressed envelope is looked at: four times the widest band, 0.03 dB at most off its peak."""


def detection_index_db(setting: Situation, truth: GroundTruth, beep: BeepDesign, fidelity: Fidelity) -> float:
    """Greatest 2E/N0 of the target's echoes at microphone 0, dB, over poses between 2 and 1 m.

    NaN if the target is never at such a range or the phone is silent; `NO_ECHO_DB` if it has no echo there.
    """
    near = np.flatnonzero((truth.range_m >= RANGE_M[0]) & (truth.range_m <= RANGE_M[1]))
    density = noise_density(setting.phone)
    if len(near) == 0 or density == 0.0:
        return np.nan
    time_s = truth.time_s[near[np.unique(np.linspace(0, len(near) - 1, MOST_POSES).round().astype(int))]]
    kept = tuple(o for o in setting.scene.obstacles if o.category == "ground" or o.name == setting.targets[0])
    alone, phone = replace(setting.scene, obstacles=kept), setting.phone.held_by(None)
    paths = trace_paths(alone, phone, setting.walk.pose(time_s), fidelity, time_s)
    grounds = [o.name for o in kept if o.category == "ground"]
    paths = paths[of_target_and_ground(paths, setting.targets[0], grounds) & (paths.mic == 0)]
    peak = max((_peak(paths[paths.pose == k], beep) for k in range(len(time_s))), default=0.0)
    energy = 0.5 * phone.full_scale_gain**2 * _window_energy_s(beep)
    index = 2.0 * peak**2 * energy / density
    return float(10.0 * np.log10(index)) if index > 0.0 else NO_ECHO_DB


def of_target_and_ground(paths: Paths, target: str, grounds: Collection[str]) -> Flags:
    """(P,) whether a path meets the target, and nothing else but the ground."""
    own = {target, *grounds}
    return np.array([target in met and own.issuperset(met) for met in paths.obstacles_met()], dtype=bool)


def _peak(paths: Paths, beep: BeepDesign) -> float:
    """Greatest amplitude of the paths' compressed beeps, which add up; 1 is that of a path of gain 1."""
    if len(paths) == 0:
        return 0.0
    frequency_hz, power = _spectrum(beep)
    gain = paths.gain_at(frequency_hz) * np.exp(-2j * np.pi * frequency_hz * paths.delay_s[:, None])
    response = paths.phone.speaker.response(frequency_hz) * paths.phone.mics[0].response(frequency_hz)
    compressed = np.fft.ifft(power * response * gain.sum(axis=0), n=4 * len(power)) * 4 * len(power)
    return float(np.abs(compressed).max())


def _spectrum(beep: BeepDesign) -> tuple[Floats, Floats]:
    """Frequencies, Hz, of the beep's band, and its power there, which sums to 1.

    The lines are so close that an echo of 7 m does not come round to the beginning.
    """
    count = round(RATE_HZ * (beep.duration_s + beep.gap_s))
    time_s = np.arange(count) / RATE_HZ
    envelope = beep.window(time_s) * np.exp(1j * (beep.phase_rad(time_s) - 2.0 * np.pi * beep.center_hz * time_s))
    power = np.abs(np.fft.fft(envelope)) ** 2
    offset_hz = np.fft.fftfreq(count, 1.0 / RATE_HZ)
    order = np.argsort(offset_hz)
    inside = order[np.abs(offset_hz[order]) <= abs(beep.stop_hz - beep.start_hz)]
    return beep.center_hz + offset_hz[inside], power[inside] / power[inside].sum()


def _window_energy_s(beep: BeepDesign) -> float:
    """Integral of the squared window, s."""
    time_s = np.arange(round(RATE_HZ * beep.duration_s)) / RATE_HZ
    return float(np.sum(beep.window(time_s) ** 2) / RATE_HZ)
