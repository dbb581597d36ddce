"""What must hold of any scene: reciprocity, mirror images, scale, order of whatever is listed, passive surfaces.

Rigid motion is in `test_trace`. Five scenes a law by default; `OBSTACLEWATCH_FUZZ=10000` asks for 160.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.paths import Paths

EXAMPLES = max(2, int(os.environ.get("OBSTACLEWATCH_FUZZ", "300")) // 60)
LOUDEST = 1.0 + 1e-9
FRINGE = 1.5  # beside a round post a mirror's echo is louder than without it: by the exact series up to 1.25 times
FREQUENCY_HZ = np.linspace(18_000.0, 22_000.0, 5)
WHOLE = {"edge_floor_db": -np.inf, "edge_share_db": -np.inf}
"""Nothing left out for being faint: what is kept may hang on the last digit."""
RAYS = Fidelity(mechanisms=("specular", "curved", "edges"), max_order=2, **WHOLE)
MIRROR = np.array([1.0, -1.0, 1.0])
SPEAKER_M, MICS_M = np.array([0.01, 0.05, 0.0]), np.array([[0.0, 0.07, 0.01], [0.0, -0.07, 0.0]])


@dataclass(frozen=True)
class World:
    """Bodies as vertices and faces, and a phone among them.

    Attributes:
        bodies: by name.
        position_m, turn: where the phone is and how it is held.
        speaker_m, mics_m: of the phone.
    """

    bodies: dict[str, tuple[np.ndarray, np.ndarray]]
    position_m: np.ndarray
    turn: Rotation
    speaker_m: np.ndarray = field(default_factory=lambda: SPEAKER_M)
    mics_m: np.ndarray = field(default_factory=lambda: MICS_M)

    def paths(self, fidelity: Fidelity = RAYS, material: Material | None = None) -> Paths:
        obstacles = [Obstacle(trimesh.Trimesh(vertices, faces, process=False), material or Material.rigid(), name)
                     for name, (vertices, faces) in self.bodies.items()]  # fmt: skip
        phone = Phone.ideal(self.speaker_m, self.mics_m)
        scene = Scene(obstacles, Air.lossless(343.0))
        return trace_paths(scene, phone, Pose(self.position_m, self.turn), fidelity)


def _body(mesh: trimesh.Trimesh, at_m: tuple[float, float, float], yaw_rad: float) -> tuple[np.ndarray, np.ndarray]:
    return Rotation.from_euler("z", yaw_rad).apply(mesh.vertices) + at_m, np.asarray(mesh.faces)


@st.composite
def worlds(draw: st.DrawFn) -> World:
    """Ground, two boxes and a post of any yaw before a phone of any heading and pitch, clear of one another."""

    def between(low: float, high: float) -> float:
        return draw(st.floats(low, high))

    bodies = {"ground": _body(trimesh.creation.box((30.0, 30.0, 0.2)), (0.0, 0.0, -0.1), 0.0)}
    for name, side in (("left", 1.0), ("right", -1.0)):
        size = between(0.3, 0.9), between(0.3, 0.9), between(0.5, 2.0)
        place = between(1.5, 3.0), side * between(0.8, 1.2), 0.5 * size[2]
        bodies[name] = _body(trimesh.creation.box(size), place, between(0.0, 3.0))
    post = trimesh.creation.cylinder(0.1, 2.0, sections=24)
    bodies["post"] = _body(post, (between(1.0, 2.0), 0.0, 1.0), between(0.0, 1.0))
    turn = held_rotation(between(-0.4, 0.4), between(-0.6, 0.6))
    return World(bodies, np.array([between(0.0, 0.4), between(-0.2, 0.2), between(1.1, 1.4)]), turn)


def laws(world: st.SearchStrategy = worlds(), **others: st.SearchStrategy):  # noqa: B008
    """A law of any world, few of them by default."""
    return lambda test: settings(max_examples=EXAMPLES, deadline=None)(given(world=world, **others)(test))


def assert_alike(one: Paths, other: Paths, rtol: float = 1e-7) -> None:
    """The same sound at both microphones."""
    first, second = one.transfer_function(FREQUENCY_HZ), other.transfer_function(FREQUENCY_HZ)
    np.testing.assert_allclose(second, first, rtol=0.0, atol=rtol * np.abs(first).max())


@laws()
def test_speaker_and_microphone_may_change_places(world):
    there = world.paths()
    back = replace(world, speaker_m=world.mics_m[0], mics_m=np.stack([world.speaker_m, world.mics_m[1]])).paths()
    assert (there.order > 0).sum() >= 2
    first, second = (paths.transfer_function(FREQUENCY_HZ)[0] for paths in (there, back))
    np.testing.assert_allclose(second, first, rtol=0.0, atol=1e-7 * np.abs(first).max())


@laws()
def test_the_mirror_image_sounds_the_same(world):
    turn = np.diag(MIRROR) @ world.turn.as_matrix() @ np.diag(MIRROR)
    bodies = {name: (vertices * MIRROR, faces[:, ::-1]) for name, (vertices, faces) in world.bodies.items()}
    image = World(bodies, world.position_m * MIRROR, Rotation.from_matrix(turn), SPEAKER_M * MIRROR, MICS_M * MIRROR)
    assert_alike(world.paths(), image.paths())


@laws(factor=st.floats(0.92, 1.08))
def test_lengths_and_wavelength_scale_together(world, factor):
    bodies = {name: (factor * vertices, faces) for name, (vertices, faces) in world.bodies.items()}
    large = World(bodies, factor * world.position_m, world.turn, factor * SPEAKER_M, factor * MICS_M)
    first = world.paths(replace(RAYS, max_range_m=5.0)).transfer_function(FREQUENCY_HZ)
    second = large.paths(replace(RAYS, max_range_m=5.0 * factor)).transfer_function(FREQUENCY_HZ / factor)
    # edges are integrated to 1e-4 of their own wave at nodes of the band that do not scale
    np.testing.assert_allclose(factor * second, first, rtol=0.0, atol=3e-4 * np.abs(first).max())


@laws(seed=st.integers(0, 2**16))
def test_no_order_of_obstacles_faces_vertices_or_microphones_matters(world, seed):
    rng = np.random.default_rng(seed)
    bodies = {}
    for name in rng.permutation(list(world.bodies)):
        vertices, faces = world.bodies[str(name)]
        place = rng.permutation(len(vertices))
        first = rng.integers(0, 3, len(faces))[:, None]
        turned = np.take_along_axis(np.argsort(place)[faces], (np.arange(3) + first) % 3, axis=1)
        bodies[str(name)] = vertices[place], turned[rng.permutation(len(faces))]
    other = replace(world, bodies=bodies, mics_m=world.mics_m[::-1]).paths()
    first, second = world.paths().transfer_function(FREQUENCY_HZ), other.transfer_function(FREQUENCY_HZ)
    np.testing.assert_allclose(second[::-1], first, rtol=0.0, atol=1e-7 * np.abs(first).max())


@laws(seed=st.integers(0, 2**16))
def test_split_triangles_of_flat_faces_change_nothing(world, seed):
    rng = np.random.default_rng(seed)
    bodies = dict(world.bodies)
    for name in ("ground", "left", "right"):
        vertices, faces = bodies[name]
        for face in rng.integers(0, len(faces), 3):  # a point inside a triangle makes three of it
            weight = rng.dirichlet([2.0, 2.0, 2.0])
            a, b, c = faces[face]
            vertices = np.concatenate([vertices, [weight @ vertices[[a, b, c]]]])
            new = len(vertices) - 1
            faces = np.concatenate([np.delete(faces, face, axis=0), [[a, b, new], [b, c, new], [c, a, new]]])
        bodies[name] = vertices, faces
    assert_alike(world.paths(), replace(world, bodies=bodies).paths())


@laws(far_m=st.floats(7.5, 12.0), size_m=st.floats(0.1, 0.6))
def test_what_is_too_far_or_hidden_changes_nothing(world, far_m, size_m):
    wall = _body(trimesh.creation.box((0.2, 14.0, 8.0)), (4.5, 0.0, 0.0), 0.0)
    walled = replace(world, bodies=world.bodies | {"wall": wall})
    box = trimesh.creation.box((size_m, size_m, size_m))
    far = _body(box, (-far_m, 0.0, 1.0), 0.3)
    hidden = _body(box, (5.5, 0.0, 1.0), 0.3)
    with_both = replace(walled, bodies=walled.bodies | {"far": far, "hidden": hidden})
    assert_alike(walled.paths(), with_both.paths())


@laws()
def test_more_fidelity_keeps_what_less_has_found(world):
    """Orders, range and floor only add paths: those of the coarser run come out the same."""
    finer = world.paths(RAYS)
    for coarse in (
        replace(RAYS, max_order=1),
        replace(RAYS, max_range_m=2.0),
        replace(RAYS, edge_floor_db=-50.0),
    ):
        found = world.paths(coarse)
        assert len(found) <= len(finer)
        nearest = [np.abs(finer.band_gain - gain).max(axis=1).min() for gain in found.band_gain]
        assert (np.array(nearest) <= 1e-9 * np.abs(found.band_gain).max(axis=1)).all()


@laws(name=st.sampled_from(["brick", "asphalt", "glass", "coat"]))
def test_no_path_gains_energy(world, name):
    """No path is louder than a rigid mirror of its length, bright fringes beside the post apart; where mirrors and
    convex bodies reflect, no material is louder than the rigid one. (Where the waves of an edge's two faces cancel,
    another material may be.)"""
    rigid, other = world.paths(), world.paths(material=Material.named(name))
    length = 343.0 * rigid.delay_s
    beside = (rigid.kind == "specular") & ("post" in world.bodies)
    most = np.where(beside, FRINGE, LOUDEST)
    assert (np.abs(rigid.band_gain) * length[:, None] <= most[:, None]).all()
    assert len(other) == len(rigid)
    bare = replace(world, bodies={name: body for name, body in world.bodies.items() if name != "post"}).paths()
    mirror = bare.kind == "specular"
    assert mirror.any()
    assert (np.abs(bare.band_gain[mirror]) * 343.0 * bare.delay_s[mirror, None] <= LOUDEST).all()
    met = np.isin(rigid.kind, ["specular", "curved"])
    assert met.sum() >= 2
    assert (np.abs(other.band_gain[met]) < np.abs(rigid.band_gain[met])).all()


def test_a_mirror_that_gives_more_than_it_gets_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The law above is one that can fail."""
    made = World.paths

    def louder(*given, **named) -> Paths:
        paths = made(*given, **named)
        return replace(paths, band_gain=1.01 * paths.band_gain)

    monkeypatch.setattr(World, "paths", louder)
    ground = _body(trimesh.creation.box((30.0, 30.0, 0.2)), (0.0, 0.0, -0.1), 0.0)
    world = World({"ground": ground}, np.array([0.0, 0.0, 1.3]), held_rotation(0.0))
    with pytest.raises(AssertionError):
        test_no_path_gains_energy.hypothesis.inner_test(world, "brick")
