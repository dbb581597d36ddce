"""Quarters of facets: they lie on the surface of their facets, and take their places."""

from __future__ import annotations

import numpy as np
import trimesh

from simulator import Material, Obstacle
from simulator.kirchhoff.light.quarters import quartered
from simulator.surfaces.facets import facets_of
from simulator.surfaces.reflectors import read_mesh, reflectors_in


def cut(mesh, facet_m):
    """Facets, and the same with a third of them in quarters."""
    reading = read_mesh(Obstacle(mesh, Material.rigid(), "body"))
    facets = facets_of(reading, reflectors_in(reading)[1], 0, facet_m)
    some = np.random.default_rng(3).random(len(facets)) < 0.3
    return facets, some, quartered(facets, some)


def small_bin():
    return trimesh.creation.cylinder(radius=0.25, height=0.6, sections=32)


def test_quarters_of_a_sphere_lie_on_it():
    """The mean of a cap lies half its height below its top: for a quarter that is a quarter as much."""
    radius = 0.15
    whole, _, both = cut(trimesh.creation.icosphere(subdivisions=3, radius=radius), 0.06)
    quarter = both.part_of >= 0
    assert np.abs(np.linalg.norm(both.corner_m[quarter], axis=2) - radius).max() < 3e-6
    below = [radius - np.linalg.norm(each, axis=1) for each in (both.middle_m[quarter], whole.middle_m)]
    assert np.abs(below[0]).max() < 0.3 * np.abs(below[1]).max()
    radial = both.middle_m / np.linalg.norm(both.middle_m, axis=1)[:, None]
    assert np.linalg.norm(both.normal - radial, axis=1).max() < 3e-4


def test_quarters_cover_their_facets():
    facets, some, both = cut(small_bin(), 0.05)
    whole, quarter = np.flatnonzero(some), np.flatnonzero(both.part_of >= 0)
    assert len(both) == len(facets) + 4 * some.sum()
    np.testing.assert_array_equal(both.part_of[quarter], np.repeat(whole, 4))
    area = np.bincount(both.part_of[quarter], both.area_m2[quarter], len(facets))
    np.testing.assert_allclose(area[some], facets.area_m2[some], rtol=0.02)
    weighted = both.area_m2[quarter, None] * both.middle_m[quarter]
    centroid = weighted.reshape(-1, 4, 3).sum(axis=1) / area[some, None]
    np.testing.assert_allclose(centroid, facets.middle_m[some], atol=3e-4)
    assert (both.start[0], both.start[-1]) == (0, len(both))
    assert (np.diff(both.start) > 0).all()
    assert len(facets) in both.start, "no block has both"


def test_quarters_stand_and_lie_beside_creases_in_place_of_their_facets():
    facets, some, both = cut(small_bin(), 0.05)
    mine = np.where(both.part_of < 0, np.arange(len(both)), both.part_of)
    np.testing.assert_array_equal(np.bincount(mine, both.stands, len(facets)), facets.stands)
    assert not both.stands[: len(facets)][some].any()
    beside = both.creases.beside
    np.testing.assert_array_equal(mine[beside], facets.creases.beside)
    assert (both.part_of[beside] >= 0).sum() == some[facets.creases.beside].sum() > 10
    away = np.linalg.norm(both.middle_m[beside] - facets.creases.middle_m[:, None], axis=2)
    before = np.linalg.norm(facets.middle_m[facets.creases.beside] - facets.creases.middle_m[:, None], axis=2)
    assert (away <= before + 1e-12).all()


def test_some_of_the_facets_know_their_quarters():
    _, _, both = cut(small_bin(), 0.05)
    kept = np.random.default_rng(4).random(len(both)) < 0.7
    kept[both.creases.beside] = True
    kept[both.part_of[kept & (both.part_of >= 0)]] = True
    fewer, rows = both[kept], np.flatnonzero(kept)
    own = fewer.part_of >= 0
    assert 100 < own.sum() < (both.part_of >= 0).sum()
    np.testing.assert_array_equal(rows[fewer.part_of[own]], both.part_of[rows[own]])
    np.testing.assert_array_equal(fewer.part_of[~own], -1)
