"""A prepared scene gives what its scene gives, whatever was changed since, and works out everything once."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from obstaclewatch import BeepDesign
from simulator import (
    Fidelity,
    Material,
    Obstacle,
    Phone,
    Pose,
    PreparedScene,
    Scene,
    StraightWalk,
    held_rotation,
    render_walk,
    trace_paths,
    trace_rejected,
)
from simulator.world import prepared_scene

PHONE = Phone.named("ideal")


def _box(x_m: float) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[[x_m, -0.5, 0.0], [x_m + 0.1, 0.5, 2.0]])


def _street(x_m: float = 2.0, material: str = "brick") -> Scene:
    ground = trimesh.Trimesh([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2], [0, 2, 3]])
    post = trimesh.creation.cylinder(
        0.1, 2.0, sections=24, transform=np.eye(4) + np.outer([1, 0, 0, 0], [0, 0, 0, 1.5])
    )
    asphalt = Material.named("asphalt")
    return Scene([
        Obstacle(ground, asphalt, "ground"), Obstacle(_box(x_m), Material.named(material), "box"),
        Obstacle(post, asphalt, "post"),
    ])  # fmt: skip


def _pose(x_m: float = 0.0) -> Pose:
    return Pose([x_m, 0.1, 1.3], held_rotation(0.0))


def _same(one, other) -> bool:
    columns = ("delay_s", "band_gain", "obstacle", "sequence", "points_m")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in columns)


@pytest.fixture
def read(monkeypatch) -> list[str]:
    """Names of the obstacles whose meshes are read."""
    names: list[str] = []
    prepared_scene._parts_of.cache_clear()

    def counted(obstacle):
        names.append(obstacle.name)
        return real(obstacle)

    real = prepared_scene.read_mesh
    monkeypatch.setattr(prepared_scene, "read_mesh", counted)
    return names


def test_the_answer_is_that_of_the_scene(read):
    scene = _street()
    prepared = PreparedScene(scene)
    for x in (0.0, 0.4, 40.0):  # the last about another origin
        assert _same(trace_paths(prepared, PHONE, _pose(x)), trace_paths(scene, PHONE, _pose(x)))
    assert len(trace_rejected(prepared, PHONE, _pose(), limit=9)) == 9
    walk = StraightWalk([0.0, 0.1, 1.3], heading_rad=0.0, speed_m_s=1.3, duration_s=0.1)
    one, other = (render_walk(each, PHONE, walk, BeepDesign()) for each in (prepared, scene))
    np.testing.assert_array_equal(one.samples, other.samples)
    assert sorted(read) == ["box", "box", "ground", "ground", "post", "post"]  # once about either origin


def test_meshes_are_read_once_for_all_scenes_that_they_stand_in(read):
    trace_paths(_street(2.0), PHONE, _pose())
    trace_paths(_street(2.5), PHONE, _pose())
    assert sorted(read) == ["box", "box", "ground", "post"]


def test_nothing_is_stale():
    """Kept under anything less than what it depends on, a preparation answers for another scene."""
    scene = _street()
    prepared = PreparedScene(scene)
    before = trace_paths(prepared, PHONE, _pose())
    fewer = trace_paths(prepared, PHONE, _pose(), Fidelity(mechanisms=("specular",)))
    assert set(fewer.kind) == {"direct", "specular"}
    held = PHONE.held_by(Obstacle(_box(-0.5), Material.rigid(), "walker"))
    assert "walker" in " ".join(trace_paths(prepared, held, _pose()).obstacle)
    softer = PHONE.held_by(Obstacle(_box(-0.5), Material.named("foliage"), "walker"))
    assert _same(trace_paths(prepared, softer, _pose()), trace_paths(scene, softer, _pose()))
    assert not _same(trace_paths(prepared, softer, _pose()), trace_paths(prepared, held, _pose()))
    assert _same(trace_paths(prepared, PHONE, _pose()), before)
    scene.obstacle("box").mesh.vertices += [0.25, 0.0, 0.0]
    assert _same(trace_paths(prepared, PHONE, _pose()), trace_paths(_street(2.25), PHONE, _pose()))
    untracked = np.asarray(scene.obstacle("box").mesh.vertices)  # a view of which trimesh does not know
    untracked[:, 0] += 0.25
    assert _same(trace_paths(prepared, PHONE, _pose()), trace_paths(_street(2.5), PHONE, _pose()))


@pytest.mark.parametrize("changed", ["material", "surface", "velocity"])
def test_another_scene_of_the_same_meshes_is_another(changed):
    scene = _street()
    fields = {
        "material": {"material": Material.named("foliage")}, "surface": {"surface": "flat"},
        "velocity": {"velocity_m_s": [-1.0, 0.0, 0.0]},
    }[changed]  # fmt: skip
    others = [replace(each, **fields) if each.name == "post" else each for each in scene.obstacles]
    before = trace_paths(scene, PHONE, _pose(), time_s=0.3)
    assert not _same(trace_paths(Scene(others), PHONE, _pose(), time_s=0.3), before)
    assert _same(trace_paths(PreparedScene(scene), PHONE, _pose(), time_s=0.3), before)


def test_other_processes_prepare_anew():
    prepared = PreparedScene(_street())
    paths = trace_paths(prepared, PHONE, _pose())
    assert _same(trace_paths(pickle.loads(pickle.dumps(prepared)), PHONE, _pose()), paths)


def test_what_is_no_scene_is_refused():
    with pytest.raises(ValueError, match="scene must be of type Scene, got 'street'"):
        PreparedScene("street")


def test_what_is_kept_of_a_mesh_is_not_the_users_array():
    """Cause: of two boxes that touch along an edge the reading was the user's own vertices. Their edges are found when
    they are first asked for, and were those of the mesh as it had been moved since."""

    def pair() -> trimesh.Trimesh:
        low, high = ([[2.0, 0.0, 0.0], [3.0, 1.0, 1.0]], [[3.0, 1.0, 0.0], [4.0, 2.0, 1.0]])
        return trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in (low, high)])

    def scene(mesh: trimesh.Trimesh) -> Scene:
        return Scene([Obstacle(mesh, Material.rigid(), "pair")])

    pose, mesh = Pose([0.0, 0.5, 0.5], held_rotation(0.0)), pair()
    prepared_scene._parts_of.cache_clear()
    trace_paths(scene(mesh), Phone.named("ideal"), pose, Fidelity(mechanisms=("specular",)))
    mesh.vertices[:] += 5.0
    after = trace_paths(scene(pair()), Phone.named("ideal"), pose)
    prepared_scene._parts_of.cache_clear()
    fresh = trace_paths(scene(pair()), Phone.named("ideal"), pose)
    assert (fresh.kind == "edge").any()
    np.testing.assert_array_equal(after.delay_s, fresh.delay_s)


@pytest.mark.parametrize(
    ("name", "velocity_m_s", "rule"),
    [
        ("box", 0.0, "the walker's body must have a name that no obstacle of the scene has, got 'box'"),
        ("walker", 1.0, r"the walker's body must have no velocity, .* got \[1.0, 0.0, 0.0\] m/s for 'walker'"),
    ],
)
def test_a_body_is_no_obstacle_of_the_scene_and_has_no_velocity(name, velocity_m_s, rule):
    """Gating one of two namesakes gated both, one object in both places was carried twice, a velocity was ignored."""
    body = Obstacle(_box(-0.5), Material.rigid(), name, velocity_m_s=[velocity_m_s, 0.0, 0.0])
    with pytest.raises(ValueError, match=rule):
        trace_paths(_street(), PHONE.held_by(body), _pose())


def test_an_obstacle_of_the_scene_is_nobody_s_body():
    scene = _street()
    with pytest.raises(ValueError, match=r"the walker's body must have a name .*, got 'post'"):
        trace_paths(scene, PHONE.held_by(scene.obstacle("post")), _pose())
