"""Kirchhoff's sum against plain quadrature: 3 mm elements of the true surface, in float64, at every frequency.

Nothing is shared but the integrand: the surfaces are formulas here and meshes there, so cutting, rounding, the closed
form over a facet, the grid, the cells and the transform to the band are all held at once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from simulator import Material, Obstacle
from simulator.kirchhoff.illuminating_images import Ends
from simulator.kirchhoff.integral import scattered
from simulator.kirchhoff.light.quarters import quartered
from simulator.kirchhoff.path_length_grid import Grid
from simulator.surfaces.creases import no_creases
from simulator.surfaces.facets import Facets, facets_of
from simulator.surfaces.reflectors import read_mesh, reflectors_in
from simulator.waves import band
from tests.references import chirp

C, STEP_M = 343.0, 3e-3
PHONE = np.array([[1.6, 0.1, 0.3], [1.55, -0.04, 0.35]])  # speaker and microphone
LEAN = np.array([[-0.3, 0.1, 0.2], [-0.1, -0.2, 0.8]])  # 6 and 14 dB weaker to the rear, not turned towards the body
TOLERANCE = {0.012: (0.05, 0.05), 0.025: (0.1, 0.1), 0.04: (0.2, 0.2)}  # level, dB, and delay, samples, by facet size
COARSE_M, COARSE_TOLERANCE = 0.08, (0.3, 0.5)  # with facets taken for flat 1.0 dB and 1.4 samples


def ball(u, v):
    """Points of a sphere of 15 cm at (u, v) in (0, 1)."""
    rise, turn = np.pi * u, 2.0 * np.pi * v
    return 0.15 * np.stack([np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)], axis=-1)


def body(u, v):
    """A torso with dents and bulges of a few centimetres, as a clothed person's."""
    unit = ball(u, v) / 0.15
    swell = 1.0 + 0.05 * np.sin(unit @ [9.0, 4.0, 7.0] + 1.0) + 0.04 * np.sin(unit @ [-3.0, 11.0, 5.0])
    return swell[..., None] * unit * [0.12, 0.2, 0.35]


def panel(u, v):
    """A car's door: an open sheet, bent one way by 1.2 m and the other by 3 m."""
    y, z = 1.0 * (u - 0.5), 0.6 * (v - 0.5)
    return np.stack([-(y**2) / 6.0 - z**2 / 2.4, y, z], axis=-1)


def shell(u, v):
    """The near half of a bin's side."""
    turn = np.pi * (v - 0.5)
    return np.stack([0.25 * np.cos(turn), 0.25 * np.sin(turn), 0.9 * (u - 0.5)], axis=-1)


SHAPES = {"ball": ball, "body": body, "panel": panel, "shell": shell}
MATERIALS = {"ball": "rigid", "body": "clothed-person", "panel": "metal", "shell": "bark"}
ROUND = ("ball", "body")  # closed; the sheets reflect on both sides


def mesh_of(name: str, size_m: float) -> trimesh.Trimesh:
    """Triangles of about a size with their corners on the surface: of a few centimetres, or of `COARSE_M`."""
    coarse = size_m >= COARSE_M
    if name in ROUND:
        unit = trimesh.creation.icosphere(subdivisions=3 if coarse else 5)
        u = np.arccos(np.clip(unit.vertices[:, 2], -1.0, 1.0)) / np.pi
        v = np.mod(np.arctan2(unit.vertices[:, 1], unit.vertices[:, 0]), 2.0 * np.pi) / (2.0 * np.pi)
        return trimesh.Trimesh(SHAPES[name](u, v), unit.faces, process=False)
    rows, columns = (8, 24) if coarse else (24, 96)
    u, v = np.meshgrid(np.linspace(0.0, 1.0, rows + 1), np.linspace(0.0, 1.0, columns + 1), indexing="ij")
    corner = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return trimesh.Trimesh(SHAPES[name](u, v).reshape(-1, 3), faces, process=False)


def quadrature(name: str, wavenumber: np.ndarray) -> np.ndarray:
    """Midpoint rule over both parameters, normals from their derivatives, all of it afresh at each wavenumber."""
    shape, material, near = SHAPES[name], Material.named(MATERIALS[name]), 1e-5
    u = (np.arange(round(1.2 / STEP_M)) + 0.5) / round(1.2 / STEP_M)
    v = (np.arange(round(1.6 / STEP_M)) + 0.5) / round(1.6 / STEP_M)
    u, v = (each.ravel() for each in np.meshgrid(u, v, indexing="ij"))
    point = shape(u, v)
    along, across = (shape(u + x, v + y) - shape(u - x, v - y) for x, y in ((near, 0.0), (0.0, near)))
    normal = np.cross(along, across) / (4.0 * near**2 * round(1.2 / STEP_M) * round(1.6 / STEP_M))
    area = np.linalg.norm(normal, axis=1)
    normal /= area[:, None]
    (l, a), (m, b) = ((np.linalg.norm(end - point, axis=1), np.sum((end - point) * normal, axis=1)) for end in PHONE)
    a, b = a / l, b / m
    directivity = np.prod([
        np.exp((point - end) @ lean / np.linalg.norm(end - point, axis=1) - np.linalg.norm(lean))
        for end, lean in zip(PHONE, LEAN, strict=True)
    ], axis=0)  # fmt: skip
    lit = (a > 0.0) & (b > 0.0) if name in ROUND else a * b > 0.0
    l, m, a, b, area = l[lit], m[lit], np.abs(a[lit]), np.abs(b[lit]), area[lit]
    total = []
    for k in wavenumber:
        factor = material.reflection([k * C / (2.0 * np.pi)], np.sqrt(a * b)[:, None])[:, 0]
        wave = np.exp(-1j * k * (l + m)) / (4.0 * np.pi * l * m)
        wave *= directivity[lit]
        total.append(np.sum(factor * wave * ((1j * k + 1.0 / l) * a + (1j * k + 1.0 / m) * b) * area))
    return np.array(total)


def shortest_m(name: str) -> float:
    """The shortest path over a surface."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 200), np.linspace(0.0, 1.0, 400))
    return float(sum(np.linalg.norm(end - SHAPES[name](u, v), axis=-1) for end in PHONE).min())


def cut(name: str, size_m: float) -> Facets:
    """The production's facets of a surface."""
    reading = read_mesh(Obstacle(mesh_of(name, size_m), Material.rigid(), name, surface="smooth"))
    return replace(facets_of(reading, reflectors_in(reading)[1], 0, size_m), creases=no_creases())


def summed(name: str, facets: Facets, lit: np.ndarray) -> np.ndarray:
    """The production sum between two points that see some facets (F,), at the chirp's frequencies."""
    nodes = band.nodes_hz(12)
    table = Material.named(MATERIALS[name]).reflection(nodes, np.linspace(0.0, 1.0, 257)[:, None])
    ends = Ends(PHONE, 0.0 * PHONE, LEAN, *np.zeros((2, 2), dtype=np.int64), lit[None])
    one = np.array([0]), np.array([1])
    grid = Grid.over(facets.radius_m, 2.0 * np.pi * nodes / C)
    cells = scattered(facets, ends, *one, grid, table)
    gain = band.evaluate(band.coefficients(cells.gain), chirp.nodes_hz())
    return np.sum(gain * np.exp(-2j * np.pi * chirp.nodes_hz() * cells.length_m[:, None] / C), axis=0)


@pytest.mark.parametrize("name", list(SHAPES))
def test_the_sum_converges_to_plain_quadrature(name):
    """Where the body itself is smooth, a tenth of what each level that uses a size may err by."""
    exact = quadrature(name, 2.0 * np.pi * chirp.nodes_hz() / C)
    coarse = {} if name == "body" else {COARSE_M: COARSE_TOLERANCE}  # whose dents a coarse mesh does not have
    for size_m, (level_db, samples) in (TOLERANCE | coarse).items():
        facets = cut(name, size_m)
        found = chirp.difference(summed(name, facets, np.ones(len(facets), bool)), exact, shortest_m(name) / C)
        assert abs(found.level_db) < level_db, (size_m, found)
        assert abs(found.delay_samples) < samples, (size_m, found)


@pytest.mark.parametrize("name", list(SHAPES))
def test_a_surface_is_summed_once_in_whole_facets_and_in_quarters(name):
    facets = cut(name, 0.04)
    some = np.arange(len(facets)) % 3 == 0
    both = quartered(facets, some)
    every = np.ones(len(both), dtype=bool)
    whole = summed(name, facets, np.ones(len(facets), dtype=bool))
    np.testing.assert_allclose(summed(name, both, every), whole, atol=1e-4 * np.abs(whole).max())
    every[: len(facets)] = ~some
    found = chirp.difference(summed(name, both, every), whole, shortest_m(name) / C)
    assert abs(found.level_db) < 0.2, found
    assert abs(found.delay_samples) < 0.2, found
