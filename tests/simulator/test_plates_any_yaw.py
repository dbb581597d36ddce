"""Thin plates from square-on to edge-on against boundary elements, stored by tests/references/make_plate_values."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths
from tests.references import fullwave, thin_plate
from tests.references.make_plate_values import FREQUENCY_HZ, SPEED_M_S, STORED

REACH_S = 1.8e-3  # of a plate's far corners behind its centre
HEARD_DB = -40.0  # re a wall in the plate's place: fainter echoes are the rest of what nearly cancels


@pytest.fixture(scope="module")
def stored():
    with np.load(STORED) as values:
        return {name: values[name] for name in values.files}


def _plate(size_m) -> Obstacle:
    y, z = 0.5 * np.asarray(size_m)
    corners = [[0.0, -y, -z], [0.0, y, -z], [0.0, y, z], [0.0, -y, z]]
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]), Material.rigid(), "plate")


def _echo(plate, source, receiver, frequency_hz, **fidelity):
    """(F,) echo at the upper microphone; one at the speaker stands 0.1 mm off it, as no phone has it there."""
    receiver = receiver + 1e-4 * (np.linalg.norm(receiver - source) == 0.0)
    fidelity = {"level": "reference", "edge_floor_db": -np.inf, **fidelity}
    phone = Phone.ideal(source, [receiver, receiver + [0.0, 0.0, 0.11]])
    pose = Pose([0.0, 0.0, 0.0], Rotation.identity())
    paths = trace_paths(Scene([plate], Air.lossless(SPEED_M_S)), phone, pose, Fidelity(**fidelity))
    return paths[(paths.order > 0) & (paths.mic == 0)].transfer_function(frequency_hz)[0]


def _compared(stored, row, receiver, **fidelity):
    """Level re a wall of the stored echo, dB, ours re it, dB, and our delay behind it, samples."""
    source, point = stored["source_m"][row], stored["receiver_m"][row, receiver]
    ours = _echo(_plate(stored["size_m"][row]), source, point, FREQUENCY_HZ, **fidelity)
    middle = 2.0 * np.linalg.norm(source)
    (level, lag), (exact, exact_lag) = (
        fullwave.correlation_peak(h, FREQUENCY_HZ, middle / SPEED_M_S, REACH_S)
        for h in (ours, stored["transfer"][row, receiver])
    )
    return exact + 20.0 * np.log10(middle), level - exact, (lag - exact_lag) / fullwave.SAMPLE_S


def _rows(stored, width, height_m):
    return np.flatnonzero((stored["size_m"][:, 0] == width) & (stored["height_m"] == height_m))


def test_boundary_elements_repeat_the_given_references():
    # those are good to 0.02 dB near the mirror direction, and to 0.4 dB at 30 degrees
    given = fullwave.stored("plate_20x30")
    n = 30
    k = 2.0 * np.pi * given["f"][n] / SPEED_M_S
    for row, allowed_db in ((0, 0.03), (7, 0.6)):
        ends = np.stack([given["R"][row], given["S"][row]])
        ours = thin_plate.echo((float(given["w"]), float(given["h"])), k, given["S"][row], ends, (120, 180))
        assert np.abs(20.0 * np.log10(np.abs(ours / given["H"][row, :, n]))).max() < allowed_db


def test_stored_values_are_those_of_the_solver(stored):
    row, n = int(_rows(stored, 0.2, 0.03)[0]), 10
    k = 2.0 * np.pi * FREQUENCY_HZ[n] / SPEED_M_S
    again = thin_plate.echo((0.2, 0.3), k, stored["source_m"][row], stored["receiver_m"][row], (120, 180))
    np.testing.assert_allclose(again, stored["transfer"][row, :, n], rtol=1e-4)


@pytest.mark.parametrize(
    ("yaws_deg", "chains"),
    [
        ((0, 10, 30, 50, 60, 70, 75, 80), "apexes"),
        ((10, 65, 80), "integrals"),
        pytest.param(tuple(range(0, 91, 5)), "apexes", marks=pytest.mark.slow),
        pytest.param(tuple(range(0, 91, 5)), "integrals", marks=pytest.mark.slow),
    ],
)
def test_any_yaw(stored, yaws_deg, chains):
    # microphones 16 cm aside, at the speaker, 16 cm above
    rows = [row for row in _rows(stored, 0.2, 0.03) if stored["yaw_deg"][row] in yaws_deg]
    assert len(rows) == len(yaws_deg)
    compared = [_compared(stored, row, receiver, edge_chains=chains) for row in rows for receiver in range(3)]
    heard = [each for each in compared if each[0] > HEARD_DB]
    assert len(heard) > 0.8 * len(compared)
    for below_wall_db, level_db, samples in heard:
        step = np.searchsorted([-30.0, -20.0], below_wall_db)
        allowed_db, allowed_samples = ((3.0, 4.0), (0.5, 1.1), (0.1, 0.3))[step]
        assert abs(level_db) <= allowed_db
        assert abs(samples) <= allowed_samples


def test_first_order_alone_is_far_off_beyond_60_degrees(stored):
    worst = [
        max(
            abs(_compared(stored, row, 1, edge_order=order, edge_chains="apexes")[1])
            for row in _rows(stored, 0.2, 0.03)[:7]
        )
        for order in (1, 3)
    ]
    assert worst[0] > 24.0  # 25 dB too loud at 88 degrees
    assert worst[1] < 4.0  # down to -57 dB re a wall


def test_wider_plate(stored):
    # its far corners are 0.22 m above and below the phone: apexes leave out what edges pass on at a corner they share
    rows = _rows(stored, 0.45, 0.03)
    assert len(rows) >= 2
    for row in rows:
        for receiver in range(3):
            kinds = {"edge_order": 1}, {"edge_chains": "apexes"}, {"edge_chains": "integrals"}
            first, apexes, integrals = (_compared(stored, row, receiver, **kind) for kind in kinds)
            assert abs(apexes[1]) < 2.1
            assert abs(apexes[1]) < max(0.5, 0.5 * abs(first[1]))
            if integrals[0] > HEARD_DB:
                assert abs(integrals[1]) <= 0.15  # 1.9 dB at the apexes alone
                assert abs(integrals[2]) <= 0.7
