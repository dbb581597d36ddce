"""A second phone nearby (paper section 5.3): its beeps, as our two microphones receive them directly.

It stands still at the height of our phone. Its sound reaches each microphone along the straight line, weakened by
distance and by the microphone's own direction and response at the middle of the band; echoes of it are left out, which
are weaker than the direct sound by at least the echo's longer path.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.spec import Interferer
from obstaclewatch import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.support.arrays import Floats

KNOT_S = 0.01
"""Between two instants at which the geometry is solved; a walker's delay departs from a line by 20 ns in between."""


def with_interferer(recording: Recording, setting: Situation, beep: BeepDesign, other: Interferer | None) -> Recording:
    """The recording with the second phone's beeps added.

    Raises:
        ValueError: the second phone's beep is not a possible one at our sample rate.
    """
    if other is None:
        return recording
    theirs = other_beep(beep, other)
    time = np.arange(recording.samples.shape[1]) / recording.sample_rate_hz
    delay, gain = _paths(setting, other, theirs, time[-1])
    knots = np.arange(delay.shape[1]) * KNOT_S
    received = [
        np.interp(time, knots, g) * _emitted(theirs, time - np.interp(time, knots, d) - other.delay_s)
        for d, g in zip(delay, gain, strict=True)
    ]
    scale = 10.0 ** ((other.level_spl_db - setting.phone.full_scale_spl_db) / 20.0)
    return replace(recording, samples=recording.samples + (scale * np.stack(received)).astype(np.float32))


def other_beep(beep: BeepDesign, other: Interferer) -> BeepDesign:
    """The second phone's beep: ours where nothing else is said."""
    names = ("start_hz", "stop_hz", "duration_s", "gap_s")
    return replace(beep, **{name: value for name in names if (value := getattr(other, name)) is not None})


def _emitted(beep: BeepDesign, time_s: Floats) -> Floats:
    """Beeps one after another, the first at 0."""
    return np.where(time_s >= 0.0, beep.waveform(np.mod(time_s, beep.period_s)), 0.0)


def _paths(setting: Situation, other: Interferer, beep: BeepDesign, last_s: float) -> tuple[Floats, Floats]:
    """(2, K) delay and gain from the second phone to each microphone at knots over the recording."""
    pose = setting.walk.pose(np.arange(0.0, last_s + 2.0 * KNOT_S, KNOT_S))
    turn = pose.body_heading_rad()[0] + other.bearing_rad
    source = pose.position_m[0] + other.distance_m * np.array([np.cos(turn), np.sin(turn), 0.0])
    phone = setting.phone
    way = source - pose.to_world(phone.geometry.mics_m)  # (K, 2, 3)
    distance = np.linalg.norm(way, axis=-1)
    towards = np.einsum("kji,kmj->kmi", pose.rotation.as_matrix().reshape(-1, 3, 3), way / distance[..., None])
    weight = [mic.directivity(towards[:, k]) * float(mic.response(beep.center_hz)) for k, mic in enumerate(phone.mics)]
    delay = distance.T / setting.scene.air.sound_speed_m_s
    return delay, np.stack(weight) / distance.T
