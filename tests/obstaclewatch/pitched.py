"""A pitched phone above the ground, by coordinates: what mirrors and corners send to its microphones."""

from __future__ import annotations

import numpy as np

from obstaclewatch import Recording
from tests.obstaclewatch.synthetic import BEEP, FULL_SCALE, PHONE, C, beep_train

PITCH = np.deg2rad(30.0)
HEIGHT_M = 1.35
LENGTH = PHONE.mic_separation_m
MIRRORED = np.array([1.0, 1.0, -1.0])


def axis(pitch_rad=PITCH):
    """Direction of the phone's top edge: ahead, aside, up."""
    return np.array([np.cos(pitch_rad), 0.0, np.sin(pitch_rad)])


def transducers(pitch_rad=PITCH, height_m=HEIGHT_M):
    """Speaker, microphone 0 and microphone 1 above the ground at z = 0, microphone 0 above the origin."""
    first = np.array([0.0, 0.0, height_m])
    back_m = PHONE.mics_m[0, 1] - np.array([PHONE.speaker_m[1], PHONE.mics_m[0, 1], PHONE.mics_m[1, 1]])
    return first - back_m[:, None] * axis(pitch_rad)


def way_m(image, pitch_rad=PITCH, height_m=HEIGHT_M):
    """(2,) lengths from the speaker to microphones by way of what makes that image of it; `image` maps a point."""
    speaker, *mics = transducers(pitch_rad, height_m)
    return np.array([np.linalg.norm(image(speaker) - mic) for mic in mics])


def by_ground(point):
    """Image in the ground."""
    return point * MIRRORED


def by_wall(distance_m, bearing_rad=0.0, foot=False):
    """Image in an upright wall that far away whose normal lies aside, or in its corner with the ground."""
    normal = np.array([np.cos(bearing_rad), np.sin(bearing_rad), 0.0])

    def image(point):
        mirrored = point + 2.0 * (distance_m - point @ normal) * normal
        return mirrored * MIRRORED if foot else mirrored

    return image


def recorded(ways, beeps=8, noise=0.03, seed=0, direct=(10.0, 4.0)):
    """Recording of echoes: (path lengths (2,), gains (2,)) each, under noise."""
    time = np.arange(BEEP.period_samples) / BEEP.sample_rate_hz
    clean = np.zeros((2, len(time)))
    for mic in range(2):
        clean[mic] = direct[mic] * beep_train(time - PHONE.speaker_to_mic_m[mic] / C)
        for path_m, gain in ways:
            clean[mic] += gain[mic] * beep_train(time - path_m[mic] / C)
    tiled = np.tile(clean, beeps)
    tiled += noise * np.random.default_rng(seed).standard_normal(tiled.shape)
    return Recording((FULL_SCALE * tiled).astype(np.float32), BEEP.sample_rate_hz)
