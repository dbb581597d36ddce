"""Every rule of the check finds its defect and nothing else, and the command says so."""

import json
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.commands.scene import check as command
from scenes import Pace, Route, RouteWalk, load_scene
from scenes.checks.check import check_scene
from scenes.checks.requirements import INSTANTS, TIMED_STEPS, integrals_needed, needs_of, rendering_cost
from scenes.obstacles import car, ground, litter_bin, wall
from scenes.obstacles.solids import box, cylinder, shifted
from scenes.streets.placing import placed
from scenes.walks.gait_walk import GaitWalk
from simulator.phone.phone import Phone
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle, Scene
from simulator.world import prepared_scene

FLOOR = Obstacle(ground(), Material.rigid(), "ground", category="ground")
WALK = GaitWalk(np.array([0.0, 0.0, 1.3]), duration_s=3.0)
PHONE = Phone.named("ideal")


def thing(mesh: trimesh.Trimesh, name: str = "thing", at=(3.0, 2.0), velocity=(0.0, 0.0, 0.0)) -> Obstacle:
    return placed(Obstacle(mesh, Material.rigid(), name, category="thing"), at, 0.0, velocity)


def found(*obstacles: Obstacle, walk=WALK, floor: bool = True) -> list[tuple[str, str, str]]:
    scene = Scene([FLOOR, *obstacles] if floor else obstacles)
    return [(one.severity, one.obstacle, one.rule) for one in check_scene(scene, walk, PHONE)]


def changed(mesh: trimesh.Trimesh, faces: np.ndarray) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


CUBE = box([0.5, 0.5, 0.5])


def test_good_things_have_no_findings() -> None:
    cube, beside = thing(CUBE), thing(litter_bin(), "bin", (3.0, -2.0))
    assert found(cube, beside) == []
    touching = thing(CUBE, "touching", (3.5, 2.0))
    assert found(cube, touching) == []


def test_a_ground_with_what_stands_on_it_in_one_mesh_is_found() -> None:
    """The simulator leaves out the echo over both, of a bin -20 dB re 1 m."""
    both = trimesh.util.concatenate([box([6.0, 6.0, 0.05]), shifted(cylinder(0.25, 0.9), np.array([0.0, 0.0, 0.05]))])
    assert found(thing(both, at=(8.0, 0.0))) == [("warning", "thing", "merged")]


def test_faces_that_rounding_made_uneven_are_found() -> None:
    askew = CUBE.copy().apply_transform(trimesh.transformations.rotation_matrix(0.3, [1.0, 2.0, 3.0]))
    askew.apply_translation([0.0, 0.0, -askew.bounds[0, 2]])
    rounded = trimesh.Trimesh(np.round(askew.vertices, 4), askew.faces, process=False)
    assert found(thing(askew)) == []
    assert found(thing(rounded)) == [("warning", "thing", "uneven")]


@pytest.mark.parametrize(
    ("mesh", "rule"),
    [
        (box([500.0, 300.0, 800.0]), ("warning", "thing", "scale")),
        (box([5e-4, 3e-4, 8e-4]), ("warning", "thing", "scale")),
        (changed(CUBE, CUBE.faces[:, ::-1]), ("error", "thing", "normals")),
        (changed(CUBE, CUBE.faces[:-1]), ("warning", "thing", "open")),
        (changed(CUBE, np.vstack([CUBE.faces[:1, ::-1], CUBE.faces[1:]])), ("warning", "thing", "winding")),
        (changed(CUBE, np.vstack([CUBE.faces, CUBE.faces[:1]])), ("warning", "thing", "doubles")),
        (changed(CUBE, np.vstack([CUBE.faces, [[0, 1, 1]]])), ("warning", "thing", "slivers")),
        (shifted(CUBE, [0, 0, -0.1]), ("warning", "thing", "sunk")),
        (shifted(CUBE, [0, 0, 0.1]), ("warning", "thing", "afloat")),
    ],
)  # fmt: skip
def test_a_defect_of_a_mesh_is_found(mesh: trimesh.Trimesh, rule: tuple[str, str, str]) -> None:
    at = (300.0, 0.0) if mesh.extents.max() > 100 else (3.0, 2.0)
    assert rule in found(thing(mesh, at=at))


def test_one_inverted_body_among_good_ones_is_found() -> None:
    good, bad = CUBE, shifted(CUBE, [1.0, 0.0, 0.0])
    both = trimesh.util.concatenate([good, changed(bad, bad.faces[:, ::-1])])
    assert found(thing(both)) == [("error", "thing", "normals")]


def test_a_cavity_is_no_inverted_body() -> None:
    hollow = shifted(box([0.3, 0.3, 0.3]), [0.0, 0.0, 0.1])
    both = trimesh.util.concatenate([CUBE, changed(hollow, hollow.faces[:, ::-1])])
    assert found(thing(both)) == []


def test_a_triangle_soup_is_as_good_as_a_closed_mesh() -> None:
    soup = trimesh.Trimesh(CUBE.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3), process=False)
    assert found(thing(soup)) == []


def test_a_mesh_read_in_the_wrong_unit_is_told_the_right_one() -> None:
    scene = Scene([FLOOR, thing(box([500.0, 300.0, 800.0]), at=(900.0, 0.0))])
    message = next(one.message for one in check_scene(scene) if one.rule == "scale")
    assert message == "is 800 m large, outside 0.03-60 m; read in another of mm, cm it would be of usual size"


def test_overlaps_are_found_between_obstacles() -> None:
    assert found(thing(CUBE), thing(CUBE, "other", (3.4, 2.0))) == [("warning", "thing", "overlap")]
    street = check_scene(load_scene("supermarket"))
    assert [one.obstacle for one in street if one.rule == "overlap"] == []


def test_a_scene_without_ground_is_warned_of() -> None:
    assert found(thing(CUBE), floor=False) == [("warning", "scene", "ground")]


@pytest.mark.parametrize(
    ("walk", "obstacle", "rule"),
    [
        (GaitWalk(np.array([0.0, 0.0, -0.2]), duration_s=1.0), thing(CUBE), ("error", "phone", "below ground")),
        (GaitWalk(np.array([0.0, 0.0, 0.02]), duration_s=1.0), thing(CUBE), ("error", "phone", "below ground")),
        (WALK, thing(wall(), at=(2.0, 0.0)), ("error", "phone", "inside")),
        (WALK, thing(wall(), at=(6.0, 0.0), velocity=(-2.0, 0.0, 0.0)), ("error", "phone", "inside")),
        (WALK, thing(CUBE, at=(0.0, 0.4)), ("error", "thing", "start")),
        (WALK, thing(CUBE, at=(2.0, 0.0)), ("warning", "thing", "walked through")),
        (RouteWalk(Route(np.array([[0, 0], [3, 0], [3, 3]])), Pace(1.2), 5.0), thing(wall(), at=(3.0, 2.0)),
         ("error", "phone", "inside")),
    ],
)  # fmt: skip
def test_a_phone_where_it_cannot_be_is_found(walk, obstacle: Obstacle, rule: tuple[str, str, str]) -> None:
    assert rule in found(obstacle, walk=walk)


def test_needs_name_the_mechanisms() -> None:
    scene = Scene([FLOOR, thing(wall(), "wall"), thing(litter_bin(), "bin", (3, -2)), thing(car(), "car", (8, 0))])
    floor, plain, can, auto = needs_of(scene)
    assert (floor.planes, floor.curved, floor.edges, floor.closed) == (1, 0, 4, False)
    assert (plain.planes, plain.curved, plain.edges) == (6, 0, 12)
    assert plain.mechanisms == ("specular", "edges")
    assert can.curved > 100
    assert "curved" in can.mechanisms
    assert auto.mechanisms == ("specular", "curved", "edges")


def test_the_cost_is_measured() -> None:
    steps: list[None] = []
    cost = rendering_cost(Scene([FLOOR]), PHONE, WALK, lambda: steps.append(None))
    assert len(steps) == TIMED_STEPS
    assert cost.beeps == 33
    assert 0.0 < cost.walk_s < 60.0
    with pytest.raises(ValueError, match="must last one beep"):
        rendering_cost(Scene([FLOOR]), PHONE, GaitWalk(np.zeros(3), duration_s=0.01))


def test_a_scenes_meshes_are_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The campus has 26, of which 24 were kept: `scene check` read them four times, 3.4 s each time."""
    read = Mock(side_effect=prepared_scene.read_mesh)
    monkeypatch.setattr(prepared_scene, "read_mesh", read)
    prepared_scene._parts_of.cache_clear()
    scene = Scene([FLOOR, *(thing(CUBE, f"cube {k}", (3.0 + k, 2.0)) for k in range(25))])
    cost = rendering_cost(scene, PHONE, WALK)
    assert len(needs_of(scene)) == read.call_count == 26
    assert cost.prepare_s > 0.0 < cost.per_beep_s
    assert cost.walk_s == cost.prepare_s + 33 * cost.per_beep_s


def test_a_post_that_ends_at_the_phones_height_needs_the_integral() -> None:
    """Its rim lies in the first Fresnel zone of its mirror point; that of a mast of 9 m is out of range."""
    short, tall = thing(cylinder(0.2, 1.35), "short", (2.5, 0.4)), thing(cylinder(0.2, 9.0), "tall", (2.5, -0.8))
    scene = Scene([FLOOR, short, tall, thing(wall(), "wall", (8.0, 0.0))])
    steps: list[None] = []
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), duration_s=1.5)
    assert integrals_needed(scene, PHONE, walk, lambda: steps.append(None)) == ["short"]
    assert len(steps) == INSTANTS


YARD = """
name: yard
obstacles:
  - {kind: wall, name: garage, at_m: [5, 0]}
  - {kind: wall, name: shed, at_m: [5, 1], yaw_deg: 90}
walk: {start_m: [0, 0], duration_s: 2, height_m: HEIGHT}
"""


def test_the_command_shows_how_far_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Cause: of a scene with two dozen things it took four minutes, and printed nothing before it was done.
    path = tmp_path / "yard.yaml"
    path.write_text(YARD.replace("HEIGHT", "1.3"))
    shown = StringIO()
    monkeypatch.setattr(shown, "isatty", lambda: True, raising=False)
    with redirect_stderr(shown):
        command.main([str(path), "--auto"], standalone_mode=False)
    assert f"/{1 + TIMED_STEPS + INSTANTS} " in shown.getvalue()
    assert all(stage in shown.getvalue() for stage in ("meshes", "first beeps", "instants at level auto"))


def test_the_command_prints_a_table_and_json_and_its_exit_code_tells(tmp_path: Path) -> None:
    path = tmp_path / "yard.yaml"
    path.write_text(YARD.replace("HEIGHT", "1.3"))
    plain = CliRunner().invoke(cli, ["scene", "check", str(path), "--no-cost"])
    assert plain.exit_code == 0
    assert "garage  wall               12  yes          6       0     12  0.25 x 8 x 3" in plain.output
    assert "warning: garage: overlap: reaches 0.125 m or more into 'shed'" in plain.output
    machine = json.loads(CliRunner().invoke(cli, ["scene", "check", str(path), "--json"]).output)
    assert [row["planes"] for row in machine["obstacles"]] == [1, 6, 6]
    assert machine["cost"]["beeps"] == 22
    path.write_text(YARD.replace("HEIGHT", "0.05"))
    bad = CliRunner().invoke(cli, ["scene", "check", str(path)])
    assert bad.exit_code == 2
    assert "error: phone: below ground: comes down to z = " in bad.output
    assert bad.output.endswith("errors: 1, warnings: 1\n")


def test_bodies_that_touch_along_an_edge_are_closed() -> None:
    """Cause: joined at their corners, such as the pillars of a shop's wall, they were called open, and both sides of
    their faces to reflect; the simulator reads each by itself."""
    beside = shifted(CUBE, np.array([0.5, 0.5, 0.0]))
    assert found(thing(trimesh.util.concatenate([CUBE, beside]))) == []
    assert check_scene(load_scene("supermarket")) == []
