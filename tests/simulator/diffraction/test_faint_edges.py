"""Edges left out: too faint for themselves to matter, or of a patch whose reflection is left out as well."""

from __future__ import annotations

import numpy as np
import trimesh

from scenes.obstacles.dustbin import dumpster
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

FREQUENCY_HZ = np.arange(18e3, 23e3, 20.0)
LEVELS = {
    "reference": {"level": "reference"},
    "auto": {"level": "auto"},
    "-60 dB": {"level": "auto", "edge_floor_db": -60.0},
}


def _echo(**fidelity):
    """(2, K) sum over all paths that meet a sign of 45 cm at 4 m, yawed by 0.5 rad, above ground."""
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    sign = trimesh.creation.box([0.002, 0.45, 0.45])
    sign.apply_transform(trimesh.transformations.rotation_matrix(0.5, [0, 0, 1])).apply_translation([4.0, 0.0, 1.3])
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for mesh, name in ((ground, "ground"), (sign, "sign"))])
    return _echo_of(scene, "sign", **fidelity)


def _echo_of(scene, target, **fidelity):
    """(2, K) sum over all paths that meet the target, for a phone 1.3 m above the origin."""
    pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
    paths = trace_paths(scene, Phone.named("ideal"), pose, Fidelity(**fidelity))
    paths = paths[np.array([target in met for met in paths.obstacles_met()])]
    total = np.zeros((2, len(FREQUENCY_HZ)), dtype=complex)
    turn = np.exp(-2j * np.pi * FREQUENCY_HZ * paths.delay_s[:, None])
    np.add.at(total, paths.mic, paths.gain_at(FREQUENCY_HZ) * turn)
    return total


def test_edges_that_are_left_out_do_not_add_up_to_what_auto_may_err_by():
    """Each end below -60 dB was left out: the echo at the noise that they make together was off by 1.2 dB."""
    peak = {name: _peak(_echo(**some)) for name, some in LEVELS.items()}
    error_db = {name: 20.0 * np.log10(peak[name] / peak["reference"]) for name in LEVELS}
    assert np.abs(error_db["auto"]).max() < 0.5 < np.abs(error_db["-60 dB"]).min()


def test_edges_count_in_the_third_order_where_their_patch_does():
    """A patch under `mirror_m2` reflected nothing, yet its edges were diffracted: walls came 5-10 dB too loud."""
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    wall = trimesh.creation.box(bounds=[[-1.0, 1.5, 0.0], [5.0, 1.6, 3.0]])
    plate = trimesh.creation.box(bounds=[[2.0, -0.3, 0.9], [2.1, 0.2, 1.7]])
    parts = {"ground": ground, "wall": wall, "plate": plate}
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()], Air.lossless(343.0))
    pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
    third = {}
    for least_m2 in (0.0, 0.3, 0.5):
        fidelity = Fidelity(mirror_m2=least_m2, max_order=3)
        paths = trace_paths(scene, Phone.named("ideal"), pose, fidelity)
        paths = paths[(paths.order == 3) & np.array(["plate" in met for met in paths.obstacles_met()])]
        third[least_m2] = set(zip(paths.kind, paths.obstacle, strict=True))
    assert third[0.0]
    assert third[0.3] == third[0.0]  # its front has 0.4 m2
    assert third[0.5] == set()


def test_a_dumpsters_sleeves_reflect_in_the_third_order():
    """`standard` left out mirrors below 0.03 m2: the echo between sleeve, side and ground came 6 dB too loud."""
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    steel = dumpster()
    steel.apply_transform(trimesh.transformations.rotation_matrix(1.62, [0, 0, 1])).apply_translation([2.42, 0.51, 0.0])
    parts = {"ground": ground, "dumpster": steel}
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()])
    peak = {level: _peak(_echo_of(scene, "dumpster", level=level)) for level in ("standard", "reference")}
    assert np.abs(20.0 * np.log10(peak["standard"] / peak["reference"])).max() < 1.0


def _peak(echo):
    """(2,) highest peaks of the compressed echo of a beep with a Hann window."""
    return np.abs(np.fft.ifft(echo * np.hanning(echo.shape[1]) ** 2, n=8192, axis=1)).max(axis=1)
