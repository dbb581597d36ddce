"""What an image sees of a body: nothing that sound reaches may be passed over before it is walked to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from benchmarks.cells.probes.compressed_echoes import compressed, of_target, peak_levels_db
from scenes.obstacles import random_obstacle
from scenes.streets.placing import placed
from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.images.given_planes import image_in
from simulator.images.image_method import REACHED, crossed
from simulator.images.image_pairs import images_of
from simulator.kirchhoff.illuminating_images import Ends, Sights
from simulator.kirchhoff.integral import cell_sums
from simulator.kirchhoff.light.lighting import Light, lit_facets
from simulator.kirchhoff.light.paths_to_skin import Begins, Skin, paths_to
from simulator.kirchhoff.light.spots import Spots, spots_of
from simulator.kirchhoff.light.views import Views
from simulator.kirchhoff.path_length_grid import Grid
from simulator.surfaces.facets import facets_of
from simulator.trace import still_tracing
from simulator.world.frames import out_of_rest
from simulator.world.search_context import Search


def test_paths_to_facets_are_those_of_the_image_method():
    """Facing, crossings and lifted stops are worked out in one loop, the images once a view."""
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    wall = trimesh.creation.box(bounds=[[1.0, 1.2, 0.0], [2.2, 1.3, 1.1]])
    body = trimesh.creation.icosphere(subdivisions=3, radius=0.4).apply_translation([2.0, 0.0, 0.9])
    parts = {"ground": ground, "wall": wall, "body": body}
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()], Air.lossless(343.0))
    pose = Pose([[0.0, 0.2, 1.3]], held_rotation(np.zeros(1)))
    phone, fidelity = Phone.named("ideal"), Fidelity(level="reference")
    tracing = still_tracing(scene, phone, pose, np.zeros(1), fidelity)
    surface = tracing.world.surfaces[0]
    facets = facets_of(*tracing.world.skins[2], 2, 0.05)
    images = images_of(Search(tracing, phone, scene.air, fidelity), surface, tracing.source_m, 2)
    side = np.zeros_like(images.pose)
    views = Views.of(tracing, tracing.source_m[images.pose], images.pose, side, images.order, images.sequence)
    np.testing.assert_allclose(views.image_m, images.point_m, atol=1e-12)
    view, place = (each.ravel() for each in np.indices((len(views), len(facets))))
    skin = Skin.of(facets, np.arange(len(facets)))
    row, stops = paths_to(tracing.mirrors, Begins.of(tracing, views, 2), skin, 0.0, view, place)
    view, place = view[row], place[row]
    in_view = np.zeros((len(views), len(facets)), dtype=bool)
    in_view[view, place] = True
    middle = out_of_rest(facets.middle_m, np.repeat(tracing.placed[:, 2], len(facets), axis=0))
    for v in range(len(views)):
        one, order = np.full(len(facets), v), views.order[v]
        code, hits = crossed(
            tracing, views.start_m[one], middle, views.pose[one], views.order[one], views.sequence[one]
        )
        facing = np.sum((views.image_m[v] - middle) * facets.normal, axis=1) > 0.0
        np.testing.assert_array_equal(in_view[v], facing & (code == REACHED), str(v))
        mine = stops[-2 - order :, view == v]
        for k in range(order):
            np.testing.assert_allclose(mine[k + 1], hits[in_view[v], k], atol=1e-12)
        lifted = middle + facets.standoff_m[:, None] * facets.normal
        np.testing.assert_allclose(mine[-1], lifted[in_view[v]], atol=1e-12)
    assert set(views.order[view]) == {0, 1, 2}
    assert not in_view.all(axis=1).any()


def test_the_border_of_a_shadow_is_known_facet_by_facet():
    """Spots of 15 mm spoke for all their facets: that moved a person's echo by 0.3-0.8 dB, even at `reference`."""
    body = random_obstacle("pedestrian", np.random.default_rng(5), "body")
    scene, phone = Scene([body]), Phone.named("ideal")
    pose = Pose([[float(body.mesh.bounds[0, 0]) - 1.5, 0.1, 1.3]], held_rotation(np.zeros(1)))
    tracing = still_tracing(scene, phone, pose, np.zeros(1), Fidelity(level="reference"))
    facets = facets_of(*tracing.world.skins[0], 0, 0.025)
    none, sides = np.zeros(3, dtype=np.int64), np.arange(3)
    straight = Sights(none, sides, none, np.full((3, 0), -1), np.concatenate([tracing.source_m, tracing.mics_m[0]]))

    def of_all(light):
        some, lit, view = lit_facets(tracing, facets, spots_of(facets, light.spot_m), straight, light)
        every = np.zeros((len(lit), len(facets)), dtype=bool)
        every[:, cKDTree(facets.middle_m).query(some.middle_m)[1]] = lit
        assert len(some) < 0.9 * len(facets), "what turns away from the phone is left out"
        return every, view

    exact, by_spots, alike, shared = (
        of_all(light)
        for light in (
            Light(1e-3, 0.0, 0.0),
            Light(0.05, 0.2, 0.0),
            Light(0.05, 0.2, 0.05),
            Light(0.05, 0.2, 1.0),
        )
    )
    assert [len(lit) for lit, _ in (exact, by_spots, alike, shared)] == [3, 3, 2, 1]
    cosine = np.sum((tracing.source_m - facets.middle_m) * facets.normal, axis=1)
    weight = np.maximum(cosine, 0.0) ** 2 * facets.area_m2  # as in the sum: facets at grazing incidence hardly count
    every = exact[0][exact[1]]
    for lit, view in (by_spots, alike, shared):
        assert ((lit[view] != every) * weight).sum(axis=1).max() < 0.002 * (every * weight).sum(axis=1).min()


def test_transducers_near_the_border_of_a_mirror_share_no_light():
    """Two 3 cm apart see a ball behind a wall's border, 1.3 m off, differently: an echo of a bin erred by 6.5 dB."""
    wall = trimesh.creation.box(bounds=[[0.75, 1.0, 0.0], [4.0, 1.1, 3.0]])
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.3).apply_translation([2.6, -1.5, 1.3])
    parts = [Obstacle(mesh, Material.rigid(), name) for mesh, name in ((wall, "wall"), (ball, "ball"))]
    tracing = _still(Scene(parts, Air.lossless(343.0)))
    (mirror,) = np.flatnonzero(np.abs(tracing.world.patches.normal[:, 1] + 1.0) < 1e-9)
    facets, sides, none = facets_of(*tracing.world.skins[1], 1, 0.025), np.arange(3), np.zeros(3, dtype=np.int64)
    sequence, order = np.full((3, 1), mirror), np.ones(3, dtype=np.int64)
    image = image_in(tracing.mirrors, tracing.transducers_m[0], none, order, sequence)
    through = Sights(none, sides, order, sequence, image)
    every = {}
    for share in (0.0, 0.02):
        some, lit, view = lit_facets(tracing, facets, spots_of(facets, 1e-3), through, Light(1e-3, 0.0, share))
        every[share] = np.zeros((3, len(facets)), dtype=bool)
        every[share][:, cKDTree(facets.middle_m).query(some.middle_m)[1]] = lit[view]
    assert 0.2 < every[0.0].sum(axis=1).min() / (0.5 * len(facets)) < 0.8, "the border runs through what faces the wall"
    np.testing.assert_array_equal(every[0.02], every[0.0])


def test_light_along_a_walk_is_that_of_each_pose():
    """Kept until the phone had moved by a tenth of the distance, it moved echoes of half hidden cars by up to 16 dB."""
    body = random_obstacle("pedestrian", np.random.default_rng(5), "body")
    post = trimesh.creation.cylinder(0.08, 2.4).apply_translation([1.1, 0.1, 1.2])
    body = replace(body, mesh=body.mesh.copy().apply_translation([2.2, 0.0, 0.0]))
    scene, phone = Scene([body, Obstacle(post, Material.rigid(), "post")]), Phone.named("ideal")
    count = 9
    place = np.column_stack([np.linspace(0.0, 0.5, count), np.linspace(-0.1, 0.1, count), np.full(count, 1.3)])
    pose = Pose(place, held_rotation(np.zeros(count)))
    tracing = still_tracing(scene, phone, pose, np.zeros(count), Fidelity(level="reference"))
    facets, pose = facets_of(*tracing.world.skins[0], 0, 0.025), np.arange(count)
    none = np.zeros_like(pose)
    straight = Sights(pose, none, none, np.full((count, 0), -1), tracing.source_m)
    lit = {}
    for agreed in (0.0, 0.2):
        some, shown, view = lit_facets(tracing, facets, spots_of(facets, 0.05), straight, Light(0.05, agreed, 0.0))
        lit[agreed] = np.zeros((count, len(facets)), dtype=bool)
        lit[agreed][:, cKDTree(facets.middle_m).query(some.middle_m)[1]] = shown[view]
    moved = (lit[0.0] != lit[0.0][:1]).mean(axis=1).max()
    assert moved > 0.05, "the post's shadow runs over the body"
    assert (lit[0.0] != lit[0.2]).mean(axis=1).max() < 0.1 * moved


def test_spots_of_one_facet_each_are_in_an_order_of_their_own():
    """Grouped by voxel, spot 0 need not be that of facet 0 even where there are as many of both."""
    body = trimesh.creation.icosphere(subdivisions=1, radius=0.3).apply_translation([2.0, 0.0, 1.2])
    tracing = _still(Scene([Obstacle(body, Material.rigid(), "body")], Air.lossless(343.0)))
    facets = facets_of(*tracing.world.skins[0], 0, 0.1)
    rows = np.random.default_rng(2).permutation(len(facets))
    none = np.zeros(1, dtype=np.int64)
    straight = Sights(none, none, none, np.full((1, 0), -1), tracing.source_m)

    def seen(of_facet):
        spots = Spots(of_facet, np.argsort(of_facet), np.zeros((0, 2), dtype=np.int64))
        some, lit, _ = lit_facets(tracing, facets, spots, straight, Light(0.01, 0.0, 0.0))
        return some.middle_m[lit[0]]

    np.testing.assert_array_equal(seen(rows), seen(np.arange(len(facets))))
    assert 0.3 * len(facets) < len(seen(rows)) < 0.5 * len(facets)


@pytest.mark.parametrize("spot_m", [1e-3, 0.2])
def test_light_lies_in_memory_view_by_view(spot_m):
    """Cause: where each spot is one facet it lay facet by facet, another kind to compiled loops: adding up facets and
    finding those that stand for cells was compiled once more, for 5 s."""
    body = trimesh.creation.icosphere(subdivisions=2, radius=0.3).apply_translation([2.0, 0.0, 1.2])
    tracing = _still(Scene([Obstacle(body, Material.rigid(), "body")], Air.lossless(343.0)))
    facets, sides, none = facets_of(*tracing.world.skins[0], 0, 0.1), np.arange(3), np.zeros(3, dtype=np.int64)
    straight = Sights(none, sides, none, np.full((3, 0), -1), tracing.transducers_m[0])
    some, lit, _ = lit_facets(tracing, facets, spots_of(facets, spot_m), straight, Light(spot_m, 0.0, 0.0))
    assert lit.shape == (3, len(some))
    assert lit.flags.c_contiguous


def test_borders_of_shadows_run_through_quarters_of_coarse_facets():
    """Facets of 4.5 cm, lit whole or not at all, moved one in ten echoes of cars by more than 0.5 dB, up to 6.8."""
    one, other, band = np.array([0]), np.array([1]), 2.0 * np.pi * np.linspace(18e3, 23e3, 6) / 343.0
    none, both, rigid = np.zeros(2, dtype=np.int64), np.arange(2), np.ones((3, len(band)), dtype=complex)

    def echo(aside_m, facet_m, border_m):
        panel = trimesh.creation.box(bounds=[[2.0, -0.6, 0.6], [2.2, 0.6, 1.8]])
        post = trimesh.creation.cylinder(0.06, 1.7, sections=48).apply_translation([1.2, aside_m, 1.25])
        parts = {"panel": panel, "post": post}
        tracing = _still(Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()]))
        points = np.stack([tracing.source_m[0], tracing.mics_m[0, 0]])
        straight = Sights(none, both, none, np.full((2, 0), -1), points)
        facets = facets_of(*tracing.world.skins[0], 0, facet_m)
        light = Light(0.03, 0.0, 0.0, border_m)
        facets, lit, view = lit_facets(tracing, facets, spots_of(facets, light.spot_m), straight, light)
        ends = Ends(points, 0.0 * points, 0.0 * points, none, view, lit)
        sums = cell_sums(facets, ends, one, other, Grid.over(facets.radius_m, band), rigid)
        return len(facets), np.sum(sums.gain * np.exp(-1j * band * sums.centre_m[:, None]), axis=0)

    for aside_m in (0.0, 0.02, 0.1):
        (_, right), (few, coarse), (some, quartered) = (
            echo(aside_m, *sizes) for sizes in ((0.008, np.inf), (0.045, np.inf), (0.045, 0.025))
        )
        rms = [np.sqrt(np.mean(np.abs(each - right) ** 2)) for each in (coarse, quartered)]
        assert rms[1] < 0.6 * rms[0], aside_m
        assert few < some < 2 * few, "away from the border facets stay whole"


def _still(scene):
    """A phone at rest that looks along x."""
    pose = Pose([[0.0, 0.0, 1.3]], held_rotation(np.zeros(1)))
    return still_tracing(scene, Phone.named("ideal"), pose, np.zeros(1), Fidelity(level="reference"))


@pytest.mark.parametrize("level", ["standard", "auto", "reference"])
def test_a_body_that_is_wholly_hidden_has_no_echo(level):
    """Cause: a sum over no facets was cut into columns of unknown width, and the run ended in an error of numpy's."""
    rock = trimesh.creation.icosphere(3, 0.3)
    rock.vertices *= 1.0 + 0.05 * np.random.default_rng(0).standard_normal((len(rock.vertices), 1))
    rock.apply_translation([4.0, 0.0, 1.3])
    wall = trimesh.creation.box(bounds=[[2.0, -3.0, -1.0], [2.2, 3.0, 3.0]])
    bodies = [Obstacle(mesh, Material.rigid(), name) for name, mesh in (("rock", rock), ("wall", wall))]
    pose = Pose([0.0, 0.0, 1.3], held_rotation(0.0))
    found = trace_paths(Scene(bodies), Phone.named("ideal"), pose, Fidelity(level=level, max_order=1))
    assert len(found)
    assert not any("rock" in met for met in found.obstacles_met())


@pytest.mark.parametrize("seed", [6, 7])
def test_cars_behind_people_echo_alike_at_every_level(seed):
    """Both microphones shared an answer 14 cm apart, and facets of 8 cm did not see where the person's shadow ended."""
    rng = np.random.default_rng(seed)
    car, person = (random_obstacle(category, rng, category) for category in ("car", "pedestrian"))
    scene = Scene([placed(car, [4.5, 0.0], rng.uniform(0.0, 6.28)), placed(person, [1.3, 0.1], rng.uniform(0.0, 6.28))])
    pose, phone = Pose([0.0, 0.0, 1.3], held_rotation(0.0, 0.5)), Phone.named("galaxy-s5")

    def levels_db(level):
        paths = trace_paths(scene, phone, pose, Fidelity(level=level))
        return np.array(peak_levels_db(compressed(paths, of_target(paths, "car"))))

    assert np.abs(levels_db("standard") - levels_db("reference")).max() < 0.6


def test_a_body_is_asked_for_finely_at_hidden_poses_alone():
    """Cause: one pose at which a person stands before a car had all others of the walk asked for as finely."""
    rng = np.random.default_rng(6)
    car, person = (random_obstacle(category, rng, category) for category in ("car", "pedestrian"))
    scene = Scene([placed(car, [4.5, 0.0], 1.0), placed(person, [1.3, 0.1], 0.0)])
    places, phone = np.array([[0.0, 0.0, 1.3], [0.0, 4.0, 1.3]]), Phone.named("galaxy-s5")

    def echoes(place_m):
        pose = Pose(place_m, held_rotation(np.zeros(len(place_m)), 0.5))
        paths = trace_paths(scene, phone, pose, Fidelity(level="standard"))
        return paths[of_target(paths, "car")].transfer_function(np.linspace(18e3, 23e3, 51))

    together = echoes(places)
    apart = np.stack([echoes(place[None]) for place in places])
    np.testing.assert_allclose(together.reshape(apart.shape), apart, atol=1e-9 * np.abs(apart).max())
