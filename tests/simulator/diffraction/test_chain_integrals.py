"""Integrals over the edges of a thin panel: plain sums over the same points, reciprocity, limits, visibility, floor."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from obstaclewatch.beep import BeepDesign
from simulator import (
    Air,
    Fidelity,
    Material,
    Obstacle,
    Phone,
    Scene,
    StraightWalk,
    trace_paths,
    trace_rejected,
)
from simulator.diffraction.chain_bounds import chain_bounds
from simulator.diffraction.edge_integrals import face_of, half_way, over_three, over_two
from simulator.diffraction.edge_nodes import nodes_of
from simulator.diffraction.longer_chains import longer_chains
from simulator.diffraction.single import diffracted_once
from simulator.diffraction.thin_panels import linked_edges, panels_of
from simulator.render import trace_walk
from simulator.scene.fidelity import LEVELS
from simulator.trace import still_tracing
from simulator.waves.band import nodes_hz
from tests.references.panels import SPEED_M_S as C
from tests.references.panels import panel, towards, traced

FREQUENCY = np.linspace(18_000.0, 23_000.0, 11)


def _panel(width=0.2, height=0.3, material=None) -> Obstacle:
    return panel(width, height, material)


def _chains(*args, **fidelity):
    paths = trace_paths(*traced(*args, **fidelity))
    return paths[(paths.kind == "mixed") & (paths.mic == 0)]


def _wedges(panel):
    world = still_tracing(*traced([panel], towards(0.0), towards(5.0))[:3], np.zeros(1), Fidelity()).world
    (rows,) = panels_of(world.wedges)
    return world.wedges[rows], world.origin_m


def edges_of(nodes):
    """(N,) number of the edge that each node is on."""
    return np.repeat(np.arange(len(nodes.first) - 1), np.diff(nodes.first))


def _plain(nodes, wavenumber, source, receiver):
    """p_2 to p_5 as sums over all pairs, triples, ... of nodes, by the formula as it is printed."""
    point, weight, n = nodes.point_m, nodes.weight_m, len(nodes)

    def cylindrical(at, other):
        off = other - point[at]
        across, rise = off @ nodes.inwards[at], off @ nodes.normal
        angle = np.mod(np.arctan2(rise, across), 2.0 * np.pi)
        return np.linalg.norm(off), np.hypot(across, rise), off @ nodes.along[at], angle

    def beta(a, b):
        (m, r, z, s), (l, q, y, t) = a, b
        cosh = (m * l + z * y) / (r * q)
        angles = (np.pi + s + t, np.pi + s - t, np.pi - s + t, np.pi - s - t)
        return sum(np.sin(0.5 * f) / (np.sqrt(0.5 * (cosh + 1.0)) - np.cos(0.5 * f)) for f in angles) / (8.0 * np.pi)

    ends = [[cylindrical(i, end) for i in range(n)] for end in (source, receiver)]
    edge = edges_of(nodes)
    linked = edge[:, None] != edge[None]
    leg = [[cylindrical(i, point[j]) if linked[i, j] else None for j in range(n)] for i in range(n)]
    far = np.linalg.norm(point[:, None] - point[None], axis=2)
    run = np.where(linked, np.exp(-1j * wavenumber * far) / np.where(linked, far, 1.0), 0.0)
    sent, heard = (
        np.array([[beta(end[i], leg[i][j]) if linked[i, j] else 0.0 for j in range(n)] for i in range(n)])
        * (weight * np.array([np.exp(-1j * wavenumber * e[0]) / e[0] for e in end]))[:, None]
        for end in ends
    )
    leaving, orders = sent * run, []
    for _ in range(4):
        orders.append(np.sum(leaving * heard.T))
        passed = np.zeros_like(leaving)
        for j in range(n):
            i = np.flatnonzero(linked[j])
            seen = np.array([leg[j][a] for a in i]).T
            bent = beta(seen[:, :, None], seen[:, None])
            passed[j, i] = -weight[j] * (leaving[i, j] @ bent) * run[j, i]
        leaving = passed
    return orders


def test_sums_are_those_of_all_pairs_triples_and_more():
    wedges, origin = _wedges(_panel(0.05, 0.05))
    nodes, wavenumber = nodes_of(wedges, 4.0 * C), 2.0 * np.pi * 5_000.0 / C  # few nodes, at low k
    assert 60 < len(nodes) < 200
    source, receiver = towards(70.0) - origin, towards(62.0, height_m=0.2) - origin
    two, three, four, five = _plain(nodes, wavenumber, source, receiver)
    face = face_of(nodes, linked_edges(wedges), np.array([wavenumber]))
    assert over_two(face, source, receiver).sum() == pytest.approx(two, rel=1e-5)
    before, after = half_way(face, np.stack([source, receiver]))
    third = over_three(face, before, after)
    assert third.sum() == pytest.approx(three, rel=4e-3)  # what is left out of the secant's transform
    ((fourth, fifth),) = longer_chains(
        face, before, [after], [third], [np.zeros((3, 1))], [lambda bound: bound >= 0.0], 5
    )
    assert fourth.known.all()
    assert fourth.pressure.sum() == pytest.approx(four, rel=8e-3)
    assert fifth.pressure.sum() == pytest.approx(five, rel=1.2e-2)


def test_windows_add_up_to_one():
    wedges, _ = _wedges(_panel(0.2, 0.9))
    nodes = nodes_of(wedges, C)
    np.testing.assert_allclose(nodes.share.sum(axis=1), 1.0, atol=1e-12)
    assert (nodes.share >= 0.0).all()
    lengths = [nodes.weight_m[edges_of(nodes) == n].sum() for n in range(4)]
    np.testing.assert_allclose(lengths, wedges.length_m, atol=1e-12)


@pytest.mark.parametrize("yaws_deg", [(70.0, 62.0), (88.0, 85.0)])
def test_speaker_and_microphone_can_be_swapped(yaws_deg):
    ends = towards(yaws_deg[0]), towards(yaws_deg[1], height_m=0.2)
    scene, *_ = traced([_panel()], *ends)
    forth, back = (trace_paths(scene, *traced([_panel()], *pair)[1:]) for pair in (ends, ends[::-1]))
    forth, back = (paths[paths.mic == 0] for paths in (forth, back))
    assert (forth.order > 4).any()
    whole, chains = (np.abs(paths.transfer_function(FREQUENCY)[0]).max() for paths in (forth, forth[forth.order > 1]))
    assert chains > 1e-4
    turned = np.abs((forth.transfer_function(FREQUENCY) - back.transfer_function(FREQUENCY))[0]).max()
    assert turned < 1e-9 * whole
    assert turned < 1e-7 * chains  # what runs on from an edge is held in single precision


def test_turned_and_shifted_panel_sends_the_same():
    ends = np.array([towards(70.0), towards(62.0, height_m=0.2)])
    turn, shift = Rotation.from_euler("xyz", [0.3, -0.4, 1.0]), np.array([3.0, -2.0, 5.0])
    mesh = _panel().mesh.copy()
    mesh.vertices = turn.apply(mesh.vertices) + shift
    moved = Obstacle(mesh, Material.rigid(), "panel")
    here = _chains([_panel()], *ends, edge_order=3).transfer_function(FREQUENCY)[0]
    there = _chains([moved], *(turn.apply(ends) + shift), edge_order=3).transfer_function(FREQUENCY)[0]
    assert np.abs(here).max() > 1e-4
    np.testing.assert_allclose(there, here, atol=1e-6 * np.abs(here).max())


def test_gains_are_smooth_over_the_band(monkeypatch):
    """Each path has the delay of its windows, so that six frequencies tell what twelve do."""
    args = traced([_panel(0.3, 0.3)], towards(72.0, 0.8), towards(65.0, 0.8, 0.1), edge_order=3)
    few = trace_paths(*args)
    monkeypatch.setattr("simulator.diffraction.chain_integrals.FREQUENCIES", 12)
    few, many = (
        paths[(paths.kind == "mixed") & (paths.mic == 0)].transfer_function(FREQUENCY)[0]
        for paths in (few, trace_paths(*args))
    )
    assert np.abs(many).max() > 1e-4
    assert 0.0 < np.abs(few - many).max() < 3e-3 * np.abs(many).max()


def test_absorbing_faces_pass_less_on():
    ends = towards(70.0), towards(72.0)
    rigid, soft = (
        np.abs(_chains([panel], *ends, edge_order=2).gain).max()
        for panel in (_panel(), _panel(material=Material.uniform("felt", 0.2)))
    )
    assert soft == pytest.approx(0.6 * rigid, rel=1e-6)  # half of 1 + R


def test_hidden_and_faint_chains_are_booked(box):
    ends = towards(70.0), towards(72.0)
    screen = box((0.1, 0.1, 2.0), tuple(towards(70.0, 0.8)), "screen")
    assert not (_chains([_panel(), screen], *ends, edge_order=3).obstacle == "panel > panel").any()
    rejected = trace_rejected(*traced([_panel(), screen], *ends, edge_order=3), limit=9000)
    assert ((rejected.mask == "hidden") & (rejected.obstacle == "panel > panel")).sum() > 2
    faint = trace_rejected(*traced([_panel()], *ends, edge_floor_db=-40.0, edge_share_db=-20.0), limit=9000)
    assert (faint.mask == "faint chain of edges").sum() > 20


def test_what_the_floor_leaves_out_is_faint():
    ends = towards(75.0), towards(70.0)
    whole, kept = _chains([_panel()], *ends), _chains([_panel()], *ends, edge_floor_db=-80.0)
    assert 10 < len(kept) < 0.5 * len(whole)
    whole, kept = (paths.transfer_function(FREQUENCY)[0] for paths in (whole, kept))
    assert np.abs(kept - whole).max() < 0.02 * np.abs(whole).max()


def test_chains_of_panels_too_large_for_integrals_are_booked():
    args = traced([_panel(1.5, 1.5)], towards(70.0), towards(72.0), edge_order=3)
    paths = trace_paths(*args)
    assert not (paths.kind == "mixed").any()
    assert "5.5 m of rim" in paths.explain()
    booked = trace_rejected(*args, limit=100)
    assert booked.counts["edges of a panel too large"] == paths.rejected["edges of a panel too large"] > 2000
    assert np.isfinite(booked.level_db).all()


def test_no_chain_is_louder_than_the_bound_below_which_none_is_integrated():
    """Panels of streets are mostly too faint for chains, and each pose that is integrated takes up to a second."""
    rng = np.random.default_rng(7)
    for _ in range(8):
        width, height = rng.uniform(0.08, 0.25, 2)
        ends = [towards(rng.uniform(20.0, 88.0), rng.uniform(0.4, 4.0), rng.uniform(-0.3, 0.8)) for _ in range(2)]
        wedges, origin = _wedges(_panel(width, height))
        at_rest = ((end - origin)[None] for end in ends)
        bound = chain_bounds(wedges, linked_edges(wedges), *at_rest, 2.0 * np.pi * 20_000.0 / C)
        chains = _chains([_panel(width, height)], *ends, edge_order=3, band_points=4)
        assert 0.02 * bound[0] < np.abs(chains.gain).max() < bound[0]


def test_faint_panels_are_not_integrated(monkeypatch, box):
    monkeypatch.setattr("simulator.diffraction.chain_integrals.face_of", None)
    source = towards(40.0, 4.0)
    wall = box((0.1, 2.0, 2.0), tuple(source + [1.5, 0.0, 0.0]), "wall")
    ends = source, towards(41.0, 4.0)
    paths = trace_paths(*traced([_panel(), wall], *ends, edge_floor_db=-60.0, edge_share_db=-40.0))
    assert paths.rejected["faint chain of edges"] > 2000


def test_nothing_is_integrated_where_kirchhoff_s_integral_takes_care(monkeypatch):
    monkeypatch.setattr("simulator.diffraction.chain_integrals.face_of", None)
    args = traced([_panel()], towards(60.0), towards(63.0), mechanisms=("edges", "kirchhoff"), facet_m=0.1)
    rejected = trace_rejected(*args, limit=50)
    assert rejected.counts["left to Kirchhoff's integral"] > 2000
    assert np.isfinite(rejected.level_db).all()


def test_chains_are_left_out_where_a_mirror_image_drowns_them(monkeypatch):
    ends = towards(2.0), towards(3.0)
    paths = trace_paths(*traced([_panel(0.45, 0.45)], *ends))
    assert (paths.kind == "specular").any()
    assert not (paths.kind == "mixed").any()
    nowhere = "simulator.diffraction.panel_chains._mirrored", lambda tracing, *_: np.zeros((len(tracing.pose), 2), bool)
    monkeypatch.setattr(*nowhere)
    with_chains = trace_paths(*traced([_panel(0.45, 0.45)], *ends, edge_order=3))
    assert (with_chains.kind == "mixed").any()
    few, all_of_them = (p[(p.mic == 0) & (p.order > 0)].transfer_function(FREQUENCY)[0] for p in (paths, with_chains))
    np.testing.assert_allclose(few, all_of_them, atol=5e-3 * np.abs(few).max())  # 0.04 dB at one frequency


def test_chains_beside_a_mirror_image_are_booked_at_their_level():
    ends = towards(1.0), towards(1.5)
    args = traced([_panel(0.1, 0.1)], *ends)
    rejected = trace_rejected(*args, limit=20_000)
    drowned = rejected[(rejected.mask == "drowned by a mirror image") & (rejected.mic == 0)]
    assert rejected.counts["drowned by a mirror image"] == len(drowned) > 2000  # the lower one sees none
    assert set(drowned.order) == {2, 3, 4, 5}
    assert (drowned.obstacle[drowned.order == 5] == " > ".join(5 * ["panel"])).all()
    wedges, origin = _wedges(_panel(0.1, 0.1))
    face = face_of(nodes_of(wedges, C), linked_edges(wedges), 2.0 * np.pi * nodes_hz(6) / C)
    two = np.abs(over_two(face, *(end - origin for end in ends))).max()
    assert drowned.level_db[drowned.order == 2].max() == pytest.approx(20.0 * np.log10(two), abs=1e-6)
    weaker = [drowned.level_db[drowned.order == n].max() for n in (2, 3, 4, 5)]
    assert (np.diff(weaker) < 0.0).all()


def test_four_and_five_edges_are_met_near_edge_on_only():
    paths = {yaw: trace_paths(*_heard_at(yaw)) for yaw in (50.0, 88.0)}
    assert paths[50.0].order.max() == 3
    assert paths[50.0].sequence.shape[1] == 3
    long = paths[88.0][paths[88.0].order > 3]
    assert len(long) > 2
    assert "mixed: " in paths[88.0].explain()
    assert f"order up to {long.order.max()}" in paths[88.0].explain()
    assert ((long.sequence >= 0).sum(axis=1) == long.order).all()
    legs = np.linalg.norm(np.diff(long.points_m, axis=1), axis=2).sum(axis=1)
    np.testing.assert_allclose(legs, C * long.delay_s, rtol=1e-12)


def _heard_at(yaw_deg, **fidelity):
    """What a floor of -80 dB leaves of a small panel's chains."""
    fidelity = {"edge_floor_db": -80.0, "edge_share_db": -20.0, **fidelity}
    return traced([_panel(0.15, 0.15)], towards(yaw_deg), towards(yaw_deg - 2.0, height_m=0.1), **fidelity)


def test_echoes_go_on_smoothly_where_longer_chains_set_in():
    # a chain comes in at the floor: no step is greater than a few of them
    yaws = np.linspace(81.0, 86.0, 11)
    found = [trace_paths(*_heard_at(yaw)) for yaw in yaws]
    long = [(paths.order > 3).sum() for paths in found]
    assert long[0] == 0 < long[-1]
    more = [
        np.abs(paths[(paths.order > 3) & (paths.mic == 0)].transfer_function(FREQUENCY)[0]).max() for paths in found
    ]
    assert np.abs(np.diff(more)).max() < 3.0 * 10.0 ** (-80.0 / 20.0)


def test_what_is_not_followed_is_fainter_than_its_bound():
    wedges, origin = _wedges(_panel(0.1, 0.1))
    face = face_of(nodes_of(wedges, C), linked_edges(wedges), 2.0 * np.pi * np.array([20_000.0]) / C)
    source, receiver = towards(86.0) - origin, towards(80.0, height_m=0.1) - origin
    before, after = half_way(face, np.stack([source, receiver]))
    args = face, before, [after], [over_three(face, before, after)], [np.zeros((3, 1))]
    (every,) = longer_chains(*args, [lambda bound: bound >= 0.0], 5)
    (loud,) = longer_chains(*args, [lambda bound: bound >= 0.5 * every[0].bound.max()], 5)
    for whole, part in zip(every, loud, strict=True):
        assert 0 < part.known.sum() < part.known.size
        np.testing.assert_allclose(
            np.where(part.known[:, None, None, :, None, None], part.pressure - whole.pressure, 0.0), 0.0, atol=1e-10
        )
        assert (whole.bound <= part.bound * (1.0 + 1e-6))[~part.known].all()


@pytest.mark.parametrize(("yaw_deg", "longest"), [(4.0, 3), (35.0, 4)])
def test_orders_that_fewer_edges_drown_are_left_out(monkeypatch, yaw_deg, longest):
    args = traced([_panel(0.12, 0.2)], towards(yaw_deg), towards(yaw_deg + 1.0))
    few = trace_paths(*args)
    assert few.order[few.mic == 0].max() == longest
    assert few.rejected["drowned by fewer edges"] > 1000
    monkeypatch.setattr("simulator.diffraction.chain_integrals.NEGLIGIBLE", 0.0)
    every = trace_paths(*args)
    assert every.order[every.mic == 0].max() == 5
    few, every = (p[p.order > 0].transfer_function(FREQUENCY)[0] for p in (few, every))
    assert 0.0 < np.abs(few - every).max() <= 1e-3 * np.abs(every).max()


def test_chains_that_fewer_edges_drown_are_booked():
    rejected = trace_rejected(*traced([_panel(0.1, 0.1)], towards(4.0), towards(5.0)), limit=20_000)
    drowned = rejected[rejected.mask == "drowned by fewer edges"]
    assert set(drowned.order) == {4, 5}
    assert rejected.counts["drowned by fewer edges"] == len(drowned)
    assert np.isfinite(drowned.level_db).all()


def test_single_edges_bend_what_their_paths_carry():
    args = traced([_panel()], towards(40.0), towards(43.0), edge_order=1)
    paths = trace_paths(*args)
    tracing = still_tracing(*args[:3], np.zeros(1), args[3])
    (edges,) = panels_of(tracing.world.wedges)
    for mic in range(2):
        bent = paths[(paths.kind == "edge") & (paths.mic == mic)]
        assert len(bent) > 6
        ours = diffracted_once(tracing, edges, 0, mic, 2.0 * np.pi * nodes_hz(6) / C)
        np.testing.assert_allclose(ours, bent.transfer_function(nodes_hz(6))[mic], atol=1e-6 * np.abs(ours).max())


def test_both_faces_of_a_plate_with_thickness_are_alike():
    mesh = trimesh.creation.box((0.002, 0.2, 0.3))
    mesh.apply_translation([-0.001, 0.0, 0.0])
    ends = towards(70.0), towards(74.0)
    plates = Obstacle(mesh, Material.rigid(), "panel"), _panel()
    thick, thin = (_chains([plate], *ends).transfer_function(FREQUENCY)[0] for plate in plates)
    np.testing.assert_allclose(thick, thin, atol=1e-6 * np.abs(thin).max())


def test_chains_are_followed_through_a_beep():
    # their points are held where they are in the middle of it, where the way is the shortest
    beep = BeepDesign()
    walk = StraightWalk([0.0, 0.1, 1.3], 0.2, 1.4, 2 * beep.period_s, pitch_rad=0.5)
    mesh = _panel().mesh.copy()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.deg2rad(250.0), (0.0, 0.0, 1.0)))
    mesh.apply_translation([2.0, 0.0, 1.4])
    panel = Obstacle(mesh, Material.rigid(), "panel")
    phone = Phone.ideal([0.0, 0.07, 0.0], [[0.02, 0.07, 0.0], [0.0, -0.07, 0.0]])
    fidelity = Fidelity(level="reference", edge_order=3)
    paths, motion, _ = trace_walk(Scene([panel], Air.lossless(C)), phone, walk, beep, fidelity)
    rows = np.flatnonzero((paths.kind == "mixed") & (paths.pose == 1) & (paths.mic == 1))
    assert len(rows) > 20
    for row in rows[np.argsort(-np.abs(paths.gain[rows]))[:4]]:
        reception = motion.middle_s[row] + 0.9 * motion.half_width_s
        delay = np.polynomial.chebyshev.chebval(0.9, motion.delay_s[row])
        source = walk.pose([reception - delay]).to_world(phone.geometry.speaker_m)[0]
        receiver = walk.pose([reception]).to_world(phone.geometry.mics_m[1])[0]
        still = _chains([panel], source, receiver, edge_order=3)
        same = (still.sequence == paths.sequence[row]).all(axis=1)
        assert np.abs(still.delay_s[same] - delay).min() < 4e-9  # 5e-4 rad of phase at 20 kHz


def test_round_panels_have_no_chains():
    """32 short pieces of a rim would make tens of thousands of them."""
    disc = trimesh.creation.cylinder(radius=0.3, height=0.002, sections=32)
    disc.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, (0.0, 1.0, 0.0)))
    paths = trace_paths(*traced([Obstacle(disc, Material.rigid(), "disc")], towards(70.0), towards(72.0)))
    assert (paths.kind == "edge").sum() > 20
    assert not (paths.kind == "mixed").any()


def test_levels_choose_the_order():
    assert Fidelity().edge_order == 1
    assert Fidelity(level="auto").edge_order == 3
    assert Fidelity(level="reference").edge_order == LEVELS["reference"]["edge_order"] == 5
    ends = towards(40.0, 4.0), towards(42.0, 4.0)
    explained = [
        trace_paths(*traced([_panel()], *ends, level=level, edge_floor_db=-60.0)).explain()
        for level in ("standard", "auto")
    ]
    assert ["several edges of a thin panel" in each for each in explained] == [True, False]
    with pytest.raises(ValueError, match="edge_order must be a whole number from 1 to 5, got 6"):
        Fidelity(edge_order=6)
