"""Rooms against pyroomacoustics: the set of image paths, their delays and levels."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths

pra = pytest.importorskip("pyroomacoustics", reason="the peer simulator is not installed")

C = 343.0
SIZE_M = np.array([4.0, 3.0, 2.6])
PEER_ROUNDING_M = 5e-6  # the peer keeps its geometry in float32


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    pra.constants.set("num_threads", 1)
    pra.constants.set("c", C)


def _peer(source, mic, order):
    """Lengths and reflection counts of the shoebox's audible images."""
    room = pra.ShoeBox(SIZE_M, fs=192_000, max_order=order, materials=pra.Material(0.0), air_absorption=False)
    room.add_source(source)
    room.add_microphone(mic)
    room.image_source_model()
    heard = room.visibility[0][0].astype(bool)
    images = room.sources[0].images[:, heard].T.astype(np.float64)
    length = np.linalg.norm(images - mic, axis=1)
    count = room.sources[0].orders[heard]
    rank = np.lexsort((length, count))
    return length[rank], count[rank]


def _ours(source, mics, order, splits=0):
    room = trimesh.creation.box(SIZE_M, trimesh.transformations.translation_matrix(SIZE_M / 2.0))
    for _ in range(splits):
        room = room.subdivide()
    room.invert()
    scene = Scene([Obstacle(room, Material.rigid(), "room")], Air.lossless(C))
    phone = Phone.ideal([0.0, 0.0, 0.0], np.asarray(mics) - source)
    pose = Pose(source, held_rotation(np.pi / 2.0))
    paths = trace_paths(scene, phone, pose, Fidelity(max_order=order, max_range_m=40.0, mechanisms=("specular",)))
    return [paths[paths.mic == m] for m in range(2)]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_image_paths_of_a_shoebox(order):
    source = np.array([1.23, 1.71, 1.37])
    mics = np.array([[1.29, 1.83, 1.31], [1.17, 1.59, 1.43]])
    for mic, paths in zip(mics, _ours(source, mics, order), strict=True):
        length, count = _peer(source, mic, order)
        assert len(length) == {1: 7, 2: 25, 3: 63}[order]
        rank = np.lexsort((paths.delay_s, paths.order))
        np.testing.assert_array_equal(paths.order[rank], count)
        np.testing.assert_allclose(paths.delay_s[rank] * C, length, atol=PEER_ROUNDING_M)
        np.testing.assert_allclose(np.abs(paths.gain[rank]) * paths.delay_s[rank] * C, 1.0, rtol=1e-9)


def test_triangles_of_the_walls_do_not_matter():
    source, mics = np.array([2.4, 0.9, 1.1]), np.array([[2.4, 1.0, 1.1], [2.4, 0.8, 1.1]])
    coarse, fine = _ours(source, mics, 3), _ours(source, mics, 3, splits=2)
    for a, b in zip(coarse, fine, strict=True):
        assert len(a) == 63
        np.testing.assert_allclose(np.sort(a.delay_s), np.sort(b.delay_s), rtol=1e-12)


def test_impulse_response_of_the_peer_peaks_at_our_delays():
    # a filter of the peer's delays everything by 40 samples; amplitudes are 1 / d without the 4 pi
    source, mics = np.array([1.0, 1.4, 1.2]), np.array([[1.5, 1.4, 1.2], [1.0, 2.1, 1.2]])
    room = pra.ShoeBox(SIZE_M, fs=192_000, max_order=1, materials=pra.Material(0.0), air_absorption=False)
    room.add_source(source)
    room.add_microphone_array(mics.T)
    room.compute_rir()
    for m, paths in enumerate(_ours(source, mics, 1)):
        response = room.rir[m][0]
        strongest = np.argsort(-np.abs(paths.gain))[:2]
        assert len(paths) == 7
        for k in strongest:
            sample = paths.delay_s[k] * 192_000 + 40.0
            near = np.arange(int(sample) - 1, int(sample) + 3)
            assert np.abs(response[near]).max() == pytest.approx(
                abs(paths.gain[k]), rel=0.4
            )  # between samples: >= 0.64
