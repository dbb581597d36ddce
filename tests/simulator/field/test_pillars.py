"""Walls with pillars, a niche and a step against boundary elements of their cross-sections.

They are stored by tests/references/make_pillar_values.

Cause: the pillar's front edge and its image in the wall are two edges of one face, its side. What passes both went
straight or not at all: 0.11 to 0.21 of a wall's echo were wrong on average, 0.36 at most, and before a wall with a
pillar -5 dB came and went within a millimetre.
"""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from scipy.special import h2vp, hankel2, jvp

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, PreparedScene, Scene, trace_paths
from simulator.diffraction.patch_borders import weights
from tests.references import make_pillar_values as made
from tests.references import prism

UNTURNED = Rotation.identity()
TALL_M, WIDE_M = 3.0, 20.0  # half of the pillar's height and of the wall's width: their ends return much later


@pytest.fixture(scope="module")
def stored():
    with np.load(made.STORED) as values:
        return dict(values)


def test_the_solver_agrees_with_the_series_of_a_round_cylinder():
    wavenumber, radius, source, receiver = made.wavenumbers()[4], 0.05, np.array([[1.0, 0.0]]), np.array([[1.0, 0.07]])
    turn = np.linspace(0.0, 2.0 * np.pi, 800, endpoint=False)
    corner = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    got = prism.scattered((corner, np.roll(corner, -1, axis=0)), wavenumber, source, receiver)[0, 0]
    away, angle = np.hypot(*receiver[0]), np.arctan2(receiver[0, 1], receiver[0, 0])
    order = np.arange(80)
    part = jvp(order, wavenumber * radius) / h2vp(order, wavenumber * radius)
    waves = part * hankel2(order, wavenumber) * hankel2(order, wavenumber * away)
    exact = 0.25j * np.sum(np.where(order == 0, 1.0, 2.0) * waves * np.cos(order * angle))
    assert abs(got - exact) < 2e-3 * abs(exact)


def test_stored_values_are_those_of_the_solver(stored):
    name, n = "pilaster", 6
    np.testing.assert_allclose(made.echoes(made.CASES[name], made.wavenumbers()[n]), stored[name][:, n], rtol=1e-6)


@pytest.mark.parametrize("level", ["standard", "auto"])
@pytest.mark.parametrize(
    ("name", "most", "mean"),
    [
        ("pillar", 0.006, 0.003), ("pilaster", 0.006, 0.003), ("pier", 0.006, 0.003), ("niche", 0.01, 0.008),
        ("step", 0.03, 0.012),
    ],
)  # fmt: skip
def test_what_passes_both_edges_of_a_face(stored, name, most, mean, level):
    error = _errors(stored, name, level)
    assert error.max() < most
    assert error.mean() < mean


def test_a_file_of_float32_has_the_same_echoes(stored):
    """Cause: where a corner was rounded, the wave along a face met no mirror in it."""
    turned = Rotation.from_euler("z", 0.7), np.array([3.1, -2.2, 0.0])
    assert _errors(stored, "step", "standard", *turned).max() < 0.03


def _errors(stored: dict, name: str, level: str, *moved) -> np.ndarray:
    """(Y,) re the echo of a wall at the front, rms over the band."""
    case = made.CASES[name]
    wall = np.exp(-made.DAMPING_1_S * 2.0 * case.away_m / made.SPEED_M_S) / np.sqrt(2.0 * case.away_m)
    return np.sqrt((np.abs(_echoes(case, level, *moved) - stored[name]) ** 2).mean(axis=1)) / wall


def _echoes(case: made.Case, level: str, turn: Rotation = UNTURNED, shift_m: np.ndarray | float = 0.0) -> np.ndarray:
    """(Y, F) damped echoes of paths in the plane of the phone, times sqrt(L); what is turned comes from a file."""
    boxes = [[[near, low, -TALL_M], [far, high, TALL_M]] for near, far, low, high in case.boxes]
    if case.wall_m is not None:
        boxes = [[low, [high[0] + 0.1, *high[1:]]] for low, high in boxes]
        boxes.append([[case.wall_m, -WIDE_M, -WIDE_M], [case.wall_m + 0.2, WIDE_M, WIDE_M]])
    bodies = []
    for n, box in enumerate(boxes):
        mesh = trimesh.creation.box(bounds=box)
        mesh.vertices = turn.apply(mesh.vertices) + shift_m
        if turn is not UNTURNED:
            mesh = trimesh.load_mesh(io.BytesIO(mesh.export(file_type="stl")), file_type="stl")
        bodies.append(Obstacle(mesh, Material.rigid(), f"box {n}"))
    scene = PreparedScene(Scene(bodies, Air.lossless(made.SPEED_M_S)))
    speaker = np.column_stack([case.source_m, np.zeros(len(case.aside_m))])
    mic = speaker + [0.0, case.beside_m, 0.0]
    speaker, mic = turn.apply(speaker) + shift_m, turn.apply(mic) + shift_m
    return np.array([_echo(scene, *ends, level) for ends in zip(speaker, mic, strict=True)])


def _echo(scene: PreparedScene, speaker_m: np.ndarray, mic_m: np.ndarray, level: str) -> np.ndarray:
    phone = Phone.ideal(speaker_m, [mic_m, mic_m + [0.0, 0.0, 0.11]])
    paths = trace_paths(scene, phone, Pose([0.0, 0.0, 0.0], UNTURNED), Fidelity(level=level))
    level_with_phone = np.abs(paths.points_m[:, :, 2]).max(axis=1) < 0.05
    paths = paths[(paths.order > 0) & (paths.mic == 0) & level_with_phone]
    delay = paths.delay_s[:, None]
    wave = np.exp(-(2j * np.pi * made.FREQUENCY_HZ + made.DAMPING_1_S) * delay)
    return (paths.gain_at(made.FREQUENCY_HZ) * wave * np.sqrt(delay * made.SPEED_M_S)).sum(axis=0)


def test_two_edges_share_the_wave_over_both():
    """Their weights add up to one, are a half each where the detours are alike, and go to the nearer edge."""
    p, q = np.meshgrid(10.0 ** np.arange(-11.0, 2.0, 0.5), 10.0 ** np.arange(-11.0, 1.6, 0.5))
    np.testing.assert_allclose(weights(p, q) + weights(q, p), 1.0, atol=2e-4)
    np.testing.assert_allclose(weights(p, p), 0.5, atol=1e-4)
    np.testing.assert_allclose(weights(np.array(50.0), np.array(1e-4)), 1.0, atol=2e-3)
    assert abs(weights(np.array(1e-4), np.array(20.0))) < 2e-3


@pytest.mark.parametrize("p", 10.0 ** np.arange(-10.0, -4.0))
@pytest.mark.parametrize("ratio", [0.01, 0.5, 30.0])
def test_close_to_both_edges_their_ratio_decides(p, ratio):
    """Owen's T over its limit is an arc tangent there. Cause: at 1e-7 rad 0.80 was found for 0.94."""
    assert abs(weights(np.array(p), np.array(ratio * p)) - (1.0 - np.arctan(np.sqrt(ratio)) * 2.0 / np.pi)) < 5e-3


def test_a_weight_is_the_integral_over_the_shadow_of_both_edges():
    p, q = 0.7, 0.2
    along = np.linspace(np.sqrt(q / p), 400.0, 4_000_001)
    damped = p * (1.0 - 1e-4j)  # what is far out adds nothing
    inside = np.trapezoid(np.exp(-1j * damped * (1.0 + along**2)) / (1.0 + along**2), along)
    share = 0.5 * inside / (0.5 * np.pi * _erfc(p))
    assert abs(share - 0.5 * weights(np.array(p), np.array(q)) * _erfc(q)) < 1e-3


def _erfc(phase_rad: float) -> complex:
    """erfc(sqrt(jx)) by its integral along the valley."""
    t = np.linspace(0.0, 8.0, 200_001)
    root = np.sqrt(1j * phase_rad)
    return complex(2.0 / np.sqrt(np.pi) * np.trapezoid(np.exp(-((root + t) ** 2)), t))


@pytest.mark.parametrize("thick_m", [0.0045, 0.005, 0.006, 0.01])
def test_a_plate_on_a_wall_echoes_as_the_integral_over_both_planes(thick_m):
    """Beside the plate's border, where the integral over planes is good for what is thin re the wavelength.

    Cause: the edge's image in the wall was nearer than 1 cm, and taken for the other edge of a rim (0.39 of a wall).
    """
    away_m, half_m, aside_m = 1.5, 0.4, 0.42
    frequency_hz = np.linspace(18_000.0, 23_000.0, 6)
    wavenumber = 2.0 * np.pi * frequency_hz / 343.0
    speaker, mic = np.zeros(3), np.array([0.0, 0.05, 0.0])

    def of_plate(ahead_m):
        place = (np.arange(800) + 0.5) / 800 * 2.0 * half_m - half_m
        y, z = np.meshgrid(place + aside_m, place, indexing="ij")
        there, back = (np.sqrt(ahead_m**2 + (y - end[1]) ** 2 + (z - end[2]) ** 2) for end in (speaker, mic))
        share = 0.5 * ahead_m * (1.0 / there + 1.0 / back) / (there * back) * (2.0 * half_m / 800) ** 2
        wave = np.exp(-1j * wavenumber[:, None, None] * (there + back))
        return 1j * wavenumber / (2.0 * np.pi) * (share * wave).sum(axis=(1, 2))

    length = np.hypot(2.0 * away_m, mic[1])
    exact = np.exp(-1j * wavenumber * length) / length - of_plate(away_m) + of_plate(away_m - thick_m)
    wall = trimesh.creation.box(bounds=[[away_m, -4.0, -4.0], [away_m + 0.2, 4.0, 4.0]])
    plate = trimesh.creation.box(
        bounds=[[away_m - thick_m, aside_m - half_m, -half_m], [away_m, aside_m + half_m, half_m]]
    )
    scene = Scene(
        [Obstacle(wall, Material.rigid(), "wall"), Obstacle(plate, Material.rigid(), "plate")], Air.lossless(343.0)
    )
    paths = trace_paths(scene, Phone.ideal(speaker, [mic, -mic]), Pose(np.zeros(3), UNTURNED))
    echo = paths[paths.order > 0].transfer_function(frequency_hz)[0]
    assert 2.0 * away_m * np.sqrt(np.mean(np.abs(echo - exact) ** 2)) < 0.1
