"""Rays off the face of a wheel, one of several mirrors: over its border they fade as Kirchhoff's integral says."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths

SPEED_M_S = 343.0
FREQUENCY_HZ = np.linspace(18_000.0, 23_000.0, 5)
AHEAD_M, ABOVE_M, RADIUS_M = 1.2, 0.12, 0.1
SPEAKER = np.array([0.0, 0.3, 0.0])
LENGTH_M = 2.0 * AHEAD_M


def wheel_by_a_wall():
    """One obstacle: a wall, the plane y = 0, and a disc that stands on end before it, its face to the phone."""
    wall = trimesh.creation.box(bounds=[[-3.0, -0.2, -3.0], [3.0, 0.0, 3.0]])
    wheel = trimesh.creation.cylinder(RADIUS_M, 0.03, sections=96)
    wheel.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0.0, 1.0, 0.0]))
    wheel.apply_translation([AHEAD_M + 0.015, ABOVE_M, 0.0])
    return Obstacle(trimesh.util.concatenate([wall, wheel]), Material.rigid(), "cart")


def echo(crossing_m):
    """(F,) of the rays off wall, then wheel, whose reflection point on the wheel's plane is so high over the wall."""
    mic = SPEAKER + [0.0, 2.0 * crossing_m, 0.0]
    scene = Scene([wheel_by_a_wall()], Air.lossless(SPEED_M_S))
    phone = Phone.ideal(SPEAKER, [mic, mic + [0.0, 0.02, 0.0]])
    paths = trace_paths(
        scene, phone, Pose([0.0, 0.0, 0.0], Rotation.identity()), Fidelity(mechanisms=("specular", "curved"))
    )
    paths = paths[(paths.mic == 0) & (paths.order == 2) & (np.abs(paths.points_m[:, 2, 0] - AHEAD_M) < 1e-6)]
    turn = np.exp(-2j * np.pi * FREQUENCY_HZ * paths.delay_s[:, None])
    return (paths.gain_at(FREQUENCY_HZ) * turn).sum(axis=0), mic


def by_integral(mic):
    """(F,) Kirchhoff's integral over the disc, summed, from the speaker as the wall shows it."""
    rings = 300
    radius, angle = np.meshgrid(
        (np.arange(rings) + 0.5) / rings * RADIUS_M, (np.arange(4 * rings) + 0.5) / (4 * rings) * 2.0 * np.pi
    )
    area = radius * (RADIUS_M / rings) * (2.0 * np.pi / (4 * rings))
    point = np.stack([np.full_like(radius, AHEAD_M), ABOVE_M + radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    there, back = (np.linalg.norm(point - end, axis=-1) for end in (SPEAKER * [1.0, -1.0, 1.0], mic))
    strength = area * 0.5 * (AHEAD_M / there + AHEAD_M / back) / (there * back)
    wavenumber = 2.0 * np.pi * FREQUENCY_HZ / SPEED_M_S
    return np.array([1j * k / (2.0 * np.pi) * (strength * np.exp(-1j * k * (there + back))).sum() for k in wavenumber])


@pytest.mark.parametrize("crossing_m", [0.01, 0.02, 0.05, 0.08, 0.12, 0.16, 0.21, 0.22, 0.24, 0.3, 0.4])
def test_a_ray_off_a_wheel_fades_over_its_border_as_the_integral_does(crossing_m):
    """On the disc, from 2 to 22 cm over the wall, and beside it: 0.02 of an endless mirror's echo, and 0.05 far off.
    A ray that is there or not errs by up to 1.1."""
    found, mic = echo(crossing_m)
    error = LENGTH_M * np.abs(found - by_integral(mic)).max()
    assert error < (0.02 if 0.0 < crossing_m <= 0.25 else 0.06)


def test_a_ray_off_a_wheel_has_no_steps():
    """In 1 mm steps of the reflection point over the border, where a ray that is there or not jumps by 0 dB."""
    rays = np.array([echo(crossing_m)[0] for crossing_m in np.arange(0.215, 0.226, 0.001)])
    steps = np.abs(np.diff(np.abs(rays), axis=0)).max()
    assert 20.0 * np.log10(LENGTH_M * steps) < -30.0
