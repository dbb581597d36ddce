"""Kirchhoff's integral: planes, full-wave bins, brute force, exact spheres, ground, reciprocity, motion."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch import BeepDesign
from scenes.obstacles import random_obstacle
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, StraightWalk, trace_paths
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.integral import scattered
from simulator.kirchhoff.path_length_grid import Grid
from simulator.render import sum_envelopes, trace_walk
from simulator.surfaces.creases import no_creases
from simulator.surfaces.facets import facets_of
from simulator.surfaces.reflectors import read_mesh, reflectors_in
from simulator.world.search_context import NOISE_MARGIN_DB
from tests.references import chirp, rigid_sphere
from tests.references.fullwave import damped, matched_peak

C = 343.0
WHOLE = Fidelity(mechanisms=("specular", "kirchhoff"), max_order=1, edge_floor_db=-np.inf, facet_m=0.013)


def _stored() -> dict:
    default = Path(__file__).resolve().parents[4] / "shared"
    path = Path(os.environ.get("OBSTACLEWATCH_SHARED", default)) / "reference" / "dustbin_fullwave.npz"
    if not path.exists():
        pytest.skip(f"no full-wave reference at {path}; OBSTACLEWATCH_SHARED names its folder")
    return dict(np.load(path))


def _phone(source, receiver) -> tuple[Phone, Pose]:
    phone = Phone.ideal(source, [receiver, np.asarray(receiver) + [0.0, 0.0, 0.11]])
    return phone, Pose([0.0, 0.0, 0.0], Rotation.identity())


def _bin(sections: int = 32, height: float = 0.9) -> trimesh.Trimesh:
    return trimesh.creation.cylinder(radius=0.25, height=height, sections=sections)


def _ground() -> Obstacle:
    corners = [[-20.0, -20.0, 0.0], [20.0, -20.0, 0.0], [20.0, 20.0, 0.0], [-20.0, 20.0, 0.0]]
    return Obstacle(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]), Material.rigid(), "ground")


def _echo(obstacles, source, receiver, fidelity):
    phone, pose = _phone(source, receiver)
    paths = trace_paths(Scene(obstacles, Air.lossless(C)), phone, pose, fidelity)
    return paths[(paths.order > 0) & (paths.mic == 0)]


@pytest.mark.parametrize("sections", [24, 32, pytest.param(48, marks=pytest.mark.slow)])
def test_dustbin_against_full_wave(sections):
    stored = _stored()
    middle = 0.5 * (stored["S"] + stored["R"])
    phone = Phone.ideal([0.0, -0.05, 0.0], [[0.0, 0.05, 0.0], [0.0, 0.05, 0.11]])
    scene = Scene([Obstacle(_bin(sections), Material.rigid(), "bin")], Air.lossless(C))
    pose = Pose(middle, Rotation.identity(len(middle)))
    every = trace_paths(scene, phone, pose, Fidelity(level="reference", max_order=1))
    for i, (source, receiver) in enumerate(zip(stored["S"], stored["R"], strict=True)):
        paths = every[(every.order > 0) & (every.mic == 0) & (every.pose == i)]
        assert len(paths)
        ours = damped(paths, stored["f"], float(stored["sigma"]))
        above = source[2] > 0.45 + 1e-9  # its echo is the rim's alone, 36 dB below a wall's
        level, samples = matched_peak(ours, stored["H"][i, 0], stored["f"], _rim_path(source, receiver) / C)
        assert abs(level) < (0.2 if above else 0.1), (i, level)
        assert abs(samples) < (0.7 if above else 0.25), (i, samples)


@pytest.mark.parametrize(
    "fidelity",
    [
        Fidelity(level="reference"),
        Fidelity(mechanisms=("specular", "kirchhoff"), max_order=3, band_points=8, facet_m=0.012),
    ],
)
def test_half_a_bin_on_the_ground_against_full_wave(fidelity):
    """A rigid ground through the middle of the free bin changes nothing for ends on it, but that both double."""
    stored = _stored()
    half = Obstacle(_bin(height=0.45).apply_translation([0.0, 0.0, 0.225]), Material.rigid(), "bin")
    for i in (5,):
        source, receiver = (stored[name][i] + [0.0, 0.0, 1e-3] for name in ("S", "R"))
        paths = _echo([half, _ground()], source, receiver, fidelity)
        paths = paths[np.char.find(paths.obstacle.astype(str), "bin") >= 0]
        assert "mixed" in paths.kind
        assert "kirchhoff" in paths.kind
        ours = damped(paths, stored["f"], float(stored["sigma"]))
        level, samples = matched_peak(ours, 4.0 * stored["H"][i, 0], stored["f"], _rim_path(source, receiver) / C)
        assert abs(level + 6.02) < 0.1, (i, level)  # the free field of the source at the ground doubles as well
        assert abs(samples) < 0.25


def _rim_path(source, receiver) -> float:
    nearest = np.array([0.25, 0.0, np.clip(source[2], -0.45, 0.45)])
    return float(np.linalg.norm(source - nearest) + np.linalg.norm(receiver - nearest))


def test_large_plate_is_a_mirror():
    """Square-on and well inside, the edges' own echoes come half a metre of path behind the image's."""
    plate = trimesh.creation.box((0.02, 1.5, 1.5)).apply_translation([-0.01, 0.0, 0.0])
    fidelity = Fidelity(mechanisms=("kirchhoff",), max_order=1, facet_m=0.02)
    paths = _echo([Obstacle(plate, Material.rigid(), "plate")], [1.0, 0.0, 0.0], [1.0, 0.1, 0.0], fidelity)
    assert len(paths) > 10
    length = np.hypot(2.0, 0.1)
    mirror = np.exp(-2j * np.pi * chirp.nodes_hz() * length / C) / length
    found = chirp.difference(_sum_of(paths, chirp.nodes_hz()), mirror, length / C)
    assert abs(found.level_db) < 0.05
    assert abs(found.delay_samples) < 0.1


def _sum_of(paths, frequency):
    gain = paths.gain_at(frequency)
    return (gain * np.exp(-2j * np.pi * frequency * paths.delay_s[:, None])).sum(axis=0)


@pytest.mark.parametrize(("radius", "distance"), [(0.1, 0.5), (0.1, 3.0), (0.25, 1.5)])
def test_sphere_against_the_exact_series(radius, distance):
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    source, receiver = np.array([radius + distance, 0.0, 0.0]), np.array([radius + distance, 0.14, 0.0])
    paths = _echo([Obstacle(sphere, Material.rigid(), "ball")], source, receiver, WHOLE)
    assert set(paths.kind) == {"kirchhoff"}
    exact = rigid_sphere.scattered(radius, source, receiver, chirp.nodes_hz(), C)
    found = chirp.difference(_sum_of(paths, chirp.nodes_hz()), exact, 2.0 * distance / C)
    assert abs(found.level_db) < 0.1
    assert abs(found.delay_samples) < 0.15


@pytest.mark.parametrize("name", ["rigid", "clothed-person"])
def test_cells_add_up_to_the_integral(name):
    """The closed form over facets against midpoint samples of a tenth of a wavelength on the true cylinder."""
    material = Material.named(name)
    reading = read_mesh(Obstacle(_bin(64), Material.rigid(), "bin"))
    facets = facets_of(reading, reflectors_in(reading)[1], 0, 0.012)
    facets = replace(facets, creases=no_creases())  # whose fringe waves are no part of the integral
    source, receiver = np.array([1.4, 0.3, 0.7]), np.array([1.35, 0.2, 0.75])
    frequency = np.array([18_000.0, 20_500.0, 23_000.0])
    k, table = 2.0 * np.pi * frequency / C, material.reflection(frequency, np.linspace(0.0, 1.0, 257)[:, None])
    cells = _cells(facets, source, receiver, k, table)
    assert len(cells) > 5
    ours = (cells.gain * np.exp(-1j * k * cells.length_m[:, None])).sum(axis=0)
    brute = _midpoints(source, receiver, k, material)
    assert np.abs(ours - brute).max() < 0.03 * np.abs(brute).max()


def _midpoints(source, receiver, k, material, step=1.5e-3):
    """Kirchhoff's integral over the lit side and top of the bin by plain sampling."""
    turn, rise = int(np.ceil(2 * np.pi * 0.25 / step)), int(np.ceil(0.9 / step))
    phi, z = (np.arange(turn) + 0.5) * 2 * np.pi / turn, (np.arange(rise) + 0.5) * 0.9 / rise - 0.45
    total = np.zeros(len(k), dtype=np.complex128)
    for angle in phi:
        normal = np.array([np.cos(angle), np.sin(angle), 0.0])
        points = 0.25 * normal + z[:, None] * [0.0, 0.0, 1.0]
        total += _integrand(points, normal, 2 * np.pi * 0.25 / turn * 0.9 / rise, source, receiver, k, material)
    for r in (np.arange(int(0.25 / step)) + 0.5) * 0.25 / int(0.25 / step):
        points = np.column_stack([r * np.cos(phi), r * np.sin(phi), np.full(turn, 0.45)])
        area = 0.25 / int(0.25 / step) * r * 2 * np.pi / turn
        total += _integrand(points, np.array([0.0, 0.0, 1.0]), area, source, receiver, k, material)
    return total


def _integrand(points, normal, area, source, receiver, k, material):
    l, m = np.linalg.norm(source - points, axis=1), np.linalg.norm(receiver - points, axis=1)
    a, b = (source - points) @ normal / l, (receiver - points) @ normal / m
    lit = (a > 0) & (b > 0)
    l, m, a, b = l[lit], m[lit], a[lit], b[lit]
    wave = np.exp(-1j * k[:, None] * (l + m)) / (4 * np.pi * l * m)
    wave *= material.reflection(k * C / (2.0 * np.pi), np.sqrt(a * b)[:, None]).T
    return (wave * ((1j * k[:, None] + 1 / l) * a + (1j * k[:, None] + 1 / m) * b)).sum(axis=1) * area


def test_ends_can_be_swapped():
    facets = _small_bin()
    a, b, k = np.array([1.1, 0.2, 0.3]), np.array([1.0, -0.1, 0.5]), np.array([300.0, 366.0, 420.0])
    there, back = (_cells(facets, *ends, k, _rigid(k)) for ends in ((a, b), (b, a)))
    sums = [(c.gain * np.exp(-1j * k * c.length_m[:, None])).sum(axis=0) for c in (there, back)]
    np.testing.assert_allclose(sums[0], sums[1], rtol=1e-9)


def test_few_lit_facets_have_their_own_delay():
    """Cause: one facet in three may stand for a cell's delay; where none of those was lit, far ones did, or the cell
    was left out."""
    facets = replace(_small_bin(), creases=no_creases())
    a, b, k = np.array([1.1, 0.2, 0.3]), np.array([1.0, -0.1, 0.5]), np.array([300.0, 366.0, 420.0])
    path_m = np.linalg.norm(facets.middle_m - a, axis=1) + np.linalg.norm(facets.middle_m - b, axis=1)
    facing = np.minimum(*(((end - facets.middle_m) * facets.normal).sum(axis=1) for end in (a, b))) > 0.0
    near = facing & ~facets.stands & (path_m < path_m.min() + 0.01)
    for others in (facing & (path_m > 2.1), np.zeros(len(facets), dtype=bool)):
        some = _cells(facets, a, b, k, _rigid(k), near | others)
        every = _cells(replace(facets, stands=facing), a, b, k, _rigid(k), near | others)
        np.testing.assert_allclose(some.length_m, every.length_m, atol=0.02)
        assert some.length_m.min() == pytest.approx(path_m[near].min(), abs=0.02)
    none = _cells(replace(facets, stands=np.zeros(len(facets), dtype=bool)), a, b, k, _rigid(k), near)
    np.testing.assert_array_equal(none.length_m, some.length_m)


def _cells(facets, source, receiver, k, reflection, lit=None):
    """Kirchhoff's sum between two points that see every facet, or those that are lit."""
    ends, every = np.stack([source, receiver]), np.ones(len(facets), dtype=bool)
    lit = (every if lit is None else lit)[None]
    ends = Ends(ends, 0.0 * ends, 0.0 * ends, *np.zeros((2, 2), dtype=np.int64), lit)
    return scattered(facets, ends, np.array([0]), np.array([1]), Grid.over(facets.radius_m, k), reflection)


def _rigid(k):
    return np.ones((2, len(k)), dtype=np.complex128)


def _small_bin():
    reading = read_mesh(Obstacle(_bin(24, 0.3), Material.rigid(), "bin"))
    return facets_of(reading, reflectors_in(reading)[1], 0, 0.03)


def test_facets_cover_the_true_surface():
    facets = _small_bin()
    assert facets.area_m2.sum() == pytest.approx(2 * np.pi * 0.25 * (0.3 + 0.25), rel=6e-3)  # the caps are 24-gons
    side = np.abs(facets.normal[:, 2]) < 0.5
    np.testing.assert_allclose(np.hypot(*facets.middle_m[side, :2].T), 0.25, atol=2e-4)
    edges = np.linalg.norm(facets.corner_m - np.roll(facets.corner_m, 1, axis=1), axis=2)
    assert edges.max() <= 0.03


def test_too_many_facets_is_one_clear_error():
    with pytest.raises(ValueError, match="more than"):
        _echo([_ground()], [1.0, 0.0, 1.0], [1.0, 0.1, 1.0], Fidelity(mechanisms=("kirchhoff",), max_order=1))


def test_a_plate_half_behind_a_post_does_not_depend_on_the_size_of_its_facets():
    """A cell is not lost because the one facet that stands for it is hidden."""
    plate = trimesh.creation.box((0.02, 0.4, 0.4)).apply_translation([-0.01, 0.0, 0.0])
    post = trimesh.creation.box((0.02, 0.06, 0.4)).apply_translation([0.1, 0.0, 0.0])
    obstacles = [Obstacle(plate, Material.rigid(), "plate"), Obstacle(post, Material.rigid(), "post")]
    levels = []
    for facet_m in (0.015, 0.012, 0.010):
        fidelity = Fidelity(mechanisms=("kirchhoff",), max_order=1, facet_m=facet_m, band_points=8)
        paths = _echo(obstacles, [1.0, 0.0, 0.0], [1.0, 0.1, 0.0], fidelity)
        mine = _sum_of(paths[paths.obstacle == "plate"], chirp.nodes_hz())
        levels.append(chirp.difference(mine, np.exp(-2j * np.pi * chirp.nodes_hz() * 2.0 / C) / 2.0, 2.0 / C).level_db)
    assert max(levels) > -12.0  # the greater part of the plate is seen
    assert np.ptp(levels) < 1.0  # the shadow ends where a facet does: 15 mm of the 170 seen on either side


def test_an_absorbing_body_does_not_depend_on_the_number_of_frequencies():
    """Once each cell took the reflection of the one facet that stands for it: cells that cancel no longer did."""
    body, levels = Obstacle(_bumpy(), Material.named("clothed-person"), "body"), []
    for band_points in (8, 10):
        fidelity = Fidelity(mechanisms=("kirchhoff",), max_order=1, edge_floor_db=-np.inf, band_points=band_points)
        paths = _echo([body], [1.5, 0.3, 0.4], [1.5, 0.2, 0.3], fidelity)
        mirror = np.exp(-2j * np.pi * chirp.nodes_hz() * 2.8 / C) / 2.8
        levels.append(chirp.difference(_sum_of(paths, chirp.nodes_hz()), mirror, 2.8 / C).level_db)
    assert min(levels) > -40.0
    assert np.ptp(levels) < 0.02, levels  # 0.17 once


def _bumpy() -> trimesh.Trimesh:
    """An ellipsoid of a torso's size with dents and bulges of a few centimetres."""
    ball, rng = trimesh.creation.icosphere(subdivisions=4), np.random.default_rng(3)
    waves, phases = 6.0 * rng.normal(size=(6, 3)), rng.uniform(0.0, 6.0, 6)
    swell = 1.0 + 0.03 * np.sin(ball.vertices @ waves.T + phases).sum(axis=1, keepdims=True)
    return trimesh.Trimesh(ball.vertices * swell * [0.12, 0.22, 0.5], ball.faces, process=False)


def test_a_body_behind_a_wall_is_silent():
    wall = trimesh.creation.box((0.05, 3.0, 3.0)).apply_translation([0.6, 0.0, 0.0])
    obstacles = [Obstacle(_bin(), Material.rigid(), "bin"), Obstacle(wall, Material.rigid(), "wall")]
    paths = _echo(obstacles, [1.6, 0.0, 0.4], [1.6, 0.1, 0.4], WHOLE)
    assert len(paths)
    assert set(paths.obstacle) == {"wall"}


def test_cells_move_with_the_walk():
    """A beep while walking has the level of one from where the walker is when its middle is on its way to the bin."""
    beep = BeepDesign()
    scene = Scene([Obstacle(_bin(), Material.rigid(), "bin")], Air.lossless(C))
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.05, 0.0], [0.0, -0.05, 0.0]])
    fidelity = Fidelity(mechanisms=("kirchhoff",), max_order=1)
    on_its_way = 0.5 * beep.duration_s + 1.25 / C
    energy = []
    for speed, start in ((0.0, 1.5 - on_its_way), (1.0, 1.5)):
        walk = StraightWalk([start, 0.0, 0.2], np.pi, speed, beep.period_s, 0.0)
        paths, motion, count = trace_walk(scene, phone, walk, beep, fidelity)
        assert (paths.kind == "kirchhoff").sum() > 5
        echo = np.flatnonzero(paths.order > 0)
        energy.append((np.abs(sum_envelopes(paths[echo], motion[echo], beep, count)) ** 2).sum())
    assert 10.0 * np.log10(energy[1] / energy[0]) == pytest.approx(0.0, abs=0.06)
    delay = np.polynomial.chebyshev.chebval([-1.0, 0.0, 1.0], motion.delay_s[echo].T)
    assert (np.diff(delay, axis=1) < 0.0).all()


def test_cells_of_one_way_are_weighed_together_against_the_noise():
    """The loudest cell alone stood for all: 0.5 dB of a person's echo came and went with the width of the cells."""
    body = random_obstacle("pedestrian", np.random.default_rng(3), "body")
    ideal = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    pose = Pose([float(body.mesh.bounds[0, 0]) - 2.0, 0.0, 1.3], Rotation.identity())
    paths = trace_paths(Scene([body]), ideal, pose, WHOLE)
    echo = paths[paths.order > 0]
    near = [echo[echo.mic == mic] for mic in (0, 1)]
    mean = np.array([np.abs(_sum_of(each, chirp.nodes_hz())).mean() for each in near])
    loudest = np.array([np.abs(each.band_gain).max() for each in near])
    mic = int((mean / loudest).argmax())
    assert mean[mic] > 1.1 * loudest[mic]
    floor_db = 20.0 * np.log10(np.sqrt(mean[mic] * loudest[mic]))
    noisy = replace(ideal, noise_spl_db=ideal.level_spl_db + NOISE_MARGIN_DB + floor_db)
    kept = trace_paths(Scene([body]), noisy, pose, WHOLE)
    assert ((kept.mic == mic) & (kept.order > 0)).sum() == len(near[mic])
