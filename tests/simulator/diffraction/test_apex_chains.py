"""Chains of edges at their apexes: shortest ways, the double line integral, reciprocity, limits, visibility, walks."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.optimize import minimize

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
from simulator.diffraction.joint_apexes import joint_apexes, second_derivatives
from simulator.diffraction.thin_panels import chains_of, panels_of
from simulator.render import trace_walk
from simulator.scene.fidelity import LEVELS
from simulator.trace import still_tracing
from tests.references.panels import SPEED_M_S as C
from tests.references.panels import panel, towards, traced

FREQUENCY = np.linspace(18_000.0, 23_000.0, 11)


def _panel(width=0.3, height=0.4, material=None) -> Obstacle:
    return panel(width, height, material)


def _traced(obstacles, source, receiver, **fidelity):
    return traced(obstacles, source, receiver, **{"edge_chains": "apexes", **fidelity})


def _echo(*args, **fidelity):
    paths = trace_paths(*_traced(*args, **fidelity))
    return paths[(paths.order > 0) & (paths.mic == 0)]


def _random_lines(rng, rows, count):
    along = rng.normal(size=(rows, count, 3))
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    return rng.normal(size=(rows, count, 3)), along, rng.normal(size=(rows, 3)) + 3.0, rng.normal(size=(rows, 3)) - 3.0


@pytest.mark.parametrize("count", [1, 2, 3])
def test_joint_apexes_are_those_of_a_general_minimiser(count):
    start, along, source, receiver = _random_lines(np.random.default_rng(3), 12, count)
    height, settled = joint_apexes(start, along, np.ones((12, count)), source, receiver)
    assert settled.all()
    for r in range(12):

        def length(h, r=r):
            points = np.concatenate([source[r][None], start[r] + h[:, None] * along[r], receiver[r][None]])
            return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()

        found = minimize(length, np.zeros(count), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-15})
        assert length(height[r]) <= found.fun + 1e-12


def test_second_derivatives_are_differences_of_lengths():
    start, along, source, receiver = _random_lines(np.random.default_rng(4), 5, 3)
    points = np.concatenate([source[:, None], start, receiver[:, None]], axis=1)
    found = second_derivatives(points, along)
    step = 1e-4
    for i in range(3):
        for j in range(3):

            def length(a, b, i=i, j=j):
                moved = points.copy()
                moved[:, 1 + i] += a * step * along[:, i]
                moved[:, 1 + j] += b * step * along[:, j]
                return np.linalg.norm(np.diff(moved, axis=1), axis=2).sum(axis=1)

            slope = (length(1, 1) - length(1, -1) - length(-1, 1) + length(-1, -1)) / (4.0 * step**2)
            np.testing.assert_allclose(found[:, i, j], slope, atol=1e-5)


def test_chains_of_a_rectangle():
    scene, phone, pose, fidelity = _traced([_panel()], towards(70.0), towards(71.0))
    wedges = still_tracing(scene, phone, pose, np.zeros(1), fidelity).world.wedges
    (panel,) = panels_of(wedges)
    chains = chains_of(wedges, panel, 3)
    apexes = chains.core < 0
    assert ((chains.count == 2) & apexes).sum() == 12
    assert ((chains.count == 3) & apexes).sum() == 36
    assert ((chains.count == 2) & ~apexes).sum() == 32  # either edge at either end, off the line of the other one
    assert (chains.core[(chains.count == 3) & ~apexes] == 1).all()


def test_round_panels_have_no_chains():
    # 32 short pieces of a rim would make tens of thousands of them
    disc = trimesh.creation.cylinder(radius=0.3, height=0.002, sections=32)
    disc.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi, (0.0, 1.0, 0.0)))
    paths = _echo([Obstacle(disc, Material.rigid(), "disc")], towards(70.0), towards(72.0))
    assert (paths.kind == "edge").sum() > 20
    assert not (paths.kind == "mixed").any()


def test_apexes_are_the_stationary_part_of_the_double_line_integral():
    # Svensson, Fred and Vanderkooy 1999, second order over both faces: the edges end softly, so that apexes alone count
    edge_y, source, receiver = 0.15, towards(68.0), towards(63.0, height_m=0.1)
    k, z = 2.0 * np.pi * 20_000.0 / C, np.linspace(-0.8, 0.8, 900)
    near, far = (np.stack([0.0 * z, 0.0 * z + y, z], axis=1) for y in (-edge_y, edge_y))

    def beta(point, edge, inwards, other):
        """(Z, Z') the four terms for nu = 1/2 with the other end on the face; rows edge, columns other edge."""
        off = point - edge
        m, l = np.linalg.norm(off, axis=1), np.linalg.norm(other[None] - edge[:, None], axis=2)
        angle = np.arctan2(off[:, 0], inwards * off[:, 1])[:, None]
        across = (other[None] - edge[:, None])[:, :, 2]
        cosh = (m[:, None] * l + off[:, 2:] * across) / (np.hypot(off[:, 0], off[:, 1])[:, None] * 2.0 * edge_y)
        half = np.sqrt(0.5 * (cosh + 1.0))
        return sum(np.sin(0.5 * f) / (half - np.cos(0.5 * f)) for f in (np.pi + angle, np.pi - angle)) * 2.0

    taper = np.clip((0.8 - np.abs(z)) / 0.4, 0.0, 1.0)
    taper = taper**3 * (10.0 - 15.0 * taper + 6.0 * taper**2) * (z[1] - z[0])
    m, l = np.linalg.norm(source - near, axis=1), np.linalg.norm(receiver - far, axis=1)
    between = np.linalg.norm(near[:, None] - far[None], axis=2)
    weight = beta(source, near, 1.0, far) * beta(receiver, far, -1.0, near).T * taper[:, None] * taper
    phase = np.exp(-1j * k * (m[:, None] + between + l[None]))
    expected = np.sum(weight * phase / (m[:, None] * between * l[None])) / (64.0 * np.pi**2)
    paths = _echo([_panel(2.0 * edge_y, 1.6)], source, receiver, edge_order=2)
    rows = [
        n for n in np.flatnonzero(paths.kind == "mixed") if np.allclose(paths.points_m[n, 1:3, 1], [-edge_y, edge_y])
    ]
    rows = [n for n in rows if np.abs(paths.points_m[n, 1:3, 2]).max() < 0.79]
    assert len(rows) == 1
    ours = paths[rows].transfer_function([20_000.0])[0, 0]
    assert abs(ours - expected) < 0.02 * abs(expected)


def test_speaker_and_microphone_may_be_swapped():
    source, receiver = towards(72.0), towards(81.0, 1.3, 0.1)
    there, back = _echo([_panel()], source, receiver), _echo([_panel()], receiver, source)
    chains = (there.kind == "mixed").sum()
    assert chains == (back.kind == "mixed").sum() > 20
    both = [p[p.kind == "mixed"].transfer_function(FREQUENCY)[0] for p in (there, back)]
    np.testing.assert_allclose(*both, atol=1e-9 * np.abs(both[0]).max())


def test_panel_seen_edge_on_is_silent():
    # a sheet without thickness moves nothing; its far edge alone keeps -32 dB re a wall
    source = np.array([1e-3, -1.5, 0.03])
    receiver = source + [0.0, 0.0, 1e-3]
    first, chains = (
        np.abs(_echo([_panel(0.2, 0.3)], source, receiver, edge_order=n).transfer_function(FREQUENCY)[0]).max()
        for n in (1, 3)
    )
    assert 20.0 * np.log10(3.0 * first) > -33.0
    assert 20.0 * np.log10(3.0 * chains) < -65.0


def test_both_faces_of_a_plate_with_thickness_are_alike():
    mesh = trimesh.creation.box((0.002, 0.3, 0.4))
    mesh.apply_translation([-0.001, 0.0, 0.0])
    plate = Obstacle(mesh, Material.rigid(), "panel")
    ends = towards(70.0), towards(74.0)
    thick, thin = (_echo([o], *ends).transfer_function(FREQUENCY)[0] for o in (plate, _panel()))
    np.testing.assert_allclose(thick, thin, atol=1e-9 * np.abs(thin).max())


def test_chains_change_little_while_the_phone_rises_past_the_panel():
    steps = np.array([-2e-3, -1e-5, 1e-5, 2e-3]) + 0.2
    levels = []
    for height in steps:
        paths = _echo([_panel()], towards(75.0, height_m=height), towards(75.5, height_m=height))
        levels.append(paths[paths.kind == "mixed"].transfer_function(FREQUENCY)[0])
    inside = np.abs(_echo([_panel()], towards(75.0), towards(75.5)).transfer_function(FREQUENCY)[0]).max()
    assert np.abs(levels[2] - levels[1]).max() < 1e-3 * inside


def test_absorbing_faces_pass_less_on():
    ends = towards(70.0), towards(72.0)
    rigid, soft = (
        np.abs(p[p.kind == "mixed"].gain).max()
        for p in (_echo([_panel()], *ends), _echo([_panel(material=Material.uniform("felt", 0.2))], *ends))
    )
    assert rigid * 0.55 < soft < rigid * 0.65  # half of 1 + R


def test_hidden_and_faint_chains_are_booked(box):
    ends = towards(70.0), towards(72.0)
    screen = box((0.1, 0.1, 2.0), tuple(towards(70.0, 0.8)), "screen")
    paths = _echo([_panel(), screen], *ends)
    assert not ((paths.kind == "mixed") & (paths.obstacle == "panel > panel")).any()
    turned = trace_rejected(*_traced([_panel(), screen], *ends), limit=5000)
    assert ((turned.mask == "hidden") & (turned.obstacle == "panel > panel")).sum() > 2
    faint = trace_rejected(*_traced([_panel()], *ends, edge_floor_db=-40.0, edge_share_db=-20.0), limit=5000)
    assert (faint.mask == "faint chain of edges").sum() > 20


def test_levels_choose_the_order():
    assert Fidelity().edge_order == 1
    assert Fidelity(level="reference").edge_order == LEVELS["reference"]["edge_order"] == 5
    ends = towards(70.0), towards(72.0)
    assert "several edges of a thin panel" in _echo([_panel()], *ends, level="standard").explain()
    assert "several edges of a thin panel" not in _echo([_panel()], *ends).explain()
    with pytest.raises(ValueError, match="edge_order must be a whole number from 1 to 5, got 6"):
        Fidelity(edge_order=6)
    assert Fidelity(level="auto").edge_chains == "apexes"
    assert Fidelity(level="reference").edge_chains == "integrals"
    with pytest.raises(ValueError, match="edge_chains must be 'integrals' or 'apexes', got 'both'"):
        Fidelity(edge_chains="both")


def test_chains_are_followed_through_a_beep():
    # their points are held where they are in the middle of it: the way is the shortest there, and stays so to 1e-7 m
    beep = BeepDesign()
    walk = StraightWalk([0.0, 0.1, 1.3], 0.2, 1.4, 2 * beep.period_s, pitch_rad=0.5)
    mesh = _panel(0.3, 0.4).mesh.copy()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.deg2rad(250.0), (0.0, 0.0, 1.0)))
    mesh.apply_translation([2.0, 0.0, 1.4])
    panel = Obstacle(mesh, Material.rigid(), "panel")
    phone = Phone.ideal([0.0, 0.07, 0.0], [[0.02, 0.07, 0.0], [0.0, -0.07, 0.0]])
    fidelity = Fidelity(level="reference", edge_chains="apexes", edge_floor_db=-np.inf)
    paths, motion, _ = trace_walk(Scene([panel], Air.lossless(C)), phone, walk, beep, fidelity)
    rows = np.flatnonzero((paths.kind == "mixed") & (paths.pose == 1) & (paths.mic == 1))
    assert len(rows) > 20
    strongest = rows[np.argsort(-np.abs(paths.gain[rows]))[:2]]
    for row in strongest:
        reception = motion.middle_s[row] + 0.9 * motion.half_width_s
        delay = np.polynomial.chebyshev.chebval(0.9, motion.delay_s[row])
        source = walk.pose([reception - delay]).to_world(phone.geometry.speaker_m)[0]
        receiver = walk.pose([reception]).to_world(phone.geometry.mics_m[1])[0]
        still = _echo([panel], source, receiver)
        same = (still.sequence == paths.sequence[row]).all(axis=1)
        assert np.abs(still.delay_s[same] - delay).min() < 1e-9  # 1e-4 rad of phase at 20 kHz
