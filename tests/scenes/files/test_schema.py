"""Scene files: what they become, and what is said about mistakes in them."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

from benchmarks.cli import cli
from scenes import load_encounter, load_scene, obstacles
from scenes.files.obstacle_kinds import KINDS
from scenes.obstacles.solids import box
from scenes.walks.gait_walk import GaitWalk
from scenes.walks.routes import RouteWalk

YARD = """
name: back-yard
air: {temperature_c: 12, relative_humidity: 0.7}
ground: {material: asphalt, size_m: [40, 40]}
obstacles:
  - {kind: wall, name: garage, at_m: [6, 0], yaw_deg: 90, parameters: {length_m: 8, height_m: 3}, material: brick}
  - {kind: person, name: neighbour, at_m: [9, -1], velocity_m_s: [-1, 0, 0]}
  - {mesh: block.ply, units: mm, name: block, at_m: [4, -2], material: concrete, category: clutter}
"""
WALK = """
name: path
obstacles:
  - {kind: litter_bin, name: bin, at_m: [4, 0.9]}
  - {kind: wall, name: end, at_m: [9, 0]}
walk: {start_m: [1, 0.5], heading_deg: 0, speed_m_s: 1.2, duration_s: 3, height_m: 1.25, pitch_deg: 25}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def test_a_scene_from_yaml(tmp_path: Path) -> None:
    box([500.0, 1000.0, 800.0]).export(tmp_path / "block.ply")
    scene = load_scene(written(tmp_path, YARD))
    assert scene.name == "back-yard"
    assert scene.air.temperature_c == 12.0
    np.testing.assert_allclose(scene.obstacle("garage").mesh.extents, [8.0, 0.25, 3.0], atol=1e-12)
    np.testing.assert_allclose(scene.obstacle("block").mesh.extents, [0.5, 1.0, 0.8], rtol=1e-6)
    np.testing.assert_allclose(scene.obstacle("block").mesh.bounds[:, :2].mean(axis=0), [4.0, -2.0], atol=1e-6)
    assert scene.obstacle("neighbour").category == "pedestrian"
    assert scene.obstacle("neighbour").moves
    assert scene.obstacles[0].category == "ground"


def test_a_street_in_one_mesh_is_split(tmp_path: Path) -> None:
    cube = box([1.0, 1.0, 1.0])
    trimesh.util.concatenate([box([9.0, 9.0, 0.1]), cube.apply_translation([0.0, 0.0, 2.0])]).export(tmp_path / "a.stl")
    line = "{mesh: a.stl, units: m, name: a, at_m: [3, 1], material: concrete, split: true}"
    scene = load_scene(written(tmp_path, f"name: t\nobstacles:\n  - {line}\n"))
    assert [obstacle.name for obstacle in scene.obstacles] == ["ground", "a-1", "a-2"]
    np.testing.assert_allclose(scene.obstacle("a-2").mesh.extents, 1.0)


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
@pytest.mark.parametrize(("units", "scale"), [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)])
def test_meshes_of_every_format_and_unit(tmp_path: Path, suffix: str, units: str, scale: float) -> None:
    mesh = box([0.5, 0.7, 1.1])
    mesh.apply_scale(1.0 / scale)
    up = "y" if suffix == "glb" else "z"
    if up == "y":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    mesh.export(tmp_path / f"block.{suffix}")
    line = f"{{mesh: block.{suffix}, units: {units}, up: {up}, name: b, at_m: [3, 1], lift_m: 0.2, material: concrete}}"
    block = load_scene(written(tmp_path, f"name: t\nobstacles:\n  - {line}\n")).obstacle("b").mesh
    np.testing.assert_allclose(block.bounds, [[2.75, 0.65, 0.2], [3.25, 1.35, 1.3]], atol=1e-6)
    assert block.volume == pytest.approx(0.5 * 0.7 * 1.1, rel=1e-5)


MISTAKES = [
    # the mistake, its line, what is said
    ("{kind: dragon, name: x}", 4, r"obstacles\[0\].kind: kind must be one of .*got 'dragon'"),
    ("{kind: wall, name: x, parameters: {lenght_m: 3}}", 4, r"obstacles\[0\]: parameters .*among .*got \['lenght_m'\]"),
    ("{kind: wall, name: x, colour: red}", 4, r"obstacles\[0\].colour: is not a field here; there are \["),
    ("{kind: wall, name: x, at: [3, 1]}", 4, r"obstacles\[0\].at: is not a field here; did you mean 'at_m'\?"),
    ("{name: x}", 4, r"obstacles\[0\]: obstacle 'x' must have either a kind or a mesh"),
    ("{mesh: x.ply, units: m, name: x}", 4, r"obstacles\[0\]: obstacle 'x' with a mesh must have a material"),
    ("{mesh: x.ply, name: x, material: brick}", 4, r"obstacles\[0\]: obstacle 'x' with a mesh must have units"),
    ("{mesh: x.ply, name: x, material: brick, units: km}", 4, r"obstacles\[0\].units: must be 'm', 'cm'.*got 'km'"),
    (
        "{mesh: broken.ply, name: x, material: brick, units: m}",
        4,
        r"obstacles\[0\]: mesh file must be one that trimesh",
    ),
    ("{kind: wall, name: x, parameters: {length_m: -3}}", 4, r"obstacles\[0\]: .*must be positive, got -3"),
    ("{kind: wall, name: x, parameters: {length_m: long}}", 4, r"obstacles\[0\]: .*'long'"),
    ("{kind: box, name: x}", 4, r"obstacles\[0\]: parameters of kind 'box' must include \['size_m'\]"),
    ("{kind: wall, name: x, material: cheese}", 4, r"obstacles\[0\].material: material must be one of .*got 'cheese'"),
    ("{kind: wall, name: x, at_m: [3]}", 4, r"obstacles\[0\].at_m\[1\]: is missing"),
    ("{kind: wall, name: x, at_m: [3, far]}", 4, r"obstacles\[0\].at_m\[1\]: must be a valid number.*got 'far'"),
    ("{kind: wall, name: x, velocity_m_s: [-100, 0, 0]}", 4, r"obstacles\[0\].velocity_m_s: .*30 m/s.*got 100 m/s"),
    ("{kind: wall, name: x, yaw_deg: yes}", 4, r"obstacles\[0\].yaw_deg: must be a number, got True"),
    ("{kind: wall, name: x, yaw_deg: .nan}", 4, r"obstacles\[0\].yaw_deg: must be a finite number, got nan"),
    ("{kind: wall, name: x, name: y}", 4, r"a scene file must give each key of a mapping once, got 'name'"),
    ("{kind: wall, name: x}\n  - {kind: car, name: x}", 3, r"obstacles: obstacle names must be unique, got \['x'\]"),
    ("{kind: wall, name: x}\nair: {relative_humidity: 40}", 5, r"air: relative_humidity must be a fraction .*got 40"),
    ("{kind: wall, name: x}\nwind: 3", 5, r"wind: is not a field here"),
    ("{kind: wall, name: x}\nwalk: {speed_m_s: -1}", 5, r"walk.speed_m_s: must be greater than or equal to 0, got -1"),
    ("{kind: wall, name: x}\nwalk: {holding: sideways}", 5, r"walk.holding: must be 'vertical' or 'horizontal'"),
    (
        "{kind: wall, name: x}\nwalk: {start_m: [0, 0], waypoints_m: [[0, 0], [5, 0]]}",
        5,
        r"walk: .*must have no start_m",
    ),
    ("{kind: wall, name: x}\nwalk: {speed_m_s: 1, vary: {speed_m_s: 1}}", 5, r"walk: vary must leave the speed 1 pos"),
    ("{kind: wall, name: x}\nwalk: {waypoints_m: [[0, 0]]}", 5, r"walk: waypoints_m must be at least two points, got"),
    ("{kind: wall, name: x}\nwalk: {start_m: [1.0e+300, 0]}", 5, r"walk.start_m\[0\]: .*equal to 1000000, got 1e\+300"),
    (
        "{kind: wall, name: x}\nwalk: {waypoints_m: [[0, 0], [0, -1.0e+300]]}",
        5,
        r"walk.waypoints_m\[1\]\[1\]: must be greater than or equal to -1000000, got -1e\+300$",
    ),
    ("{kind: wall, name: x}\nwalk: {speed_m_s: 1.0e+6}", 5, r"walk.speed_m_s: .*equal to 100, got 1000000"),
    ("{kind: wall, name: x}\nwalk: {arc: {radius_m: 1.0e+300, turn_deg: 9}}", 5, r"walk.arc.radius_m: .*got 1e\+300"),
    (
        "{kind: wall, name: x}\nwalk: {stops: [{at_s: 1, for_s: 1.0e+300}]}",
        5,
        r"walk.stops\[0\].for_s: .*equal to 14400",
    ),
    (
        "{kind: wall, name: x}\nground: {size_m: [1.0e+300, 3]}",
        5,
        r"ground: side of the ground must lie within .*1000 m",
    ),
    ("{kind: wall, name: x}\nphone: {length_m: 150}", 5, r"phone.length_m: must be less than or equal to 1, got 150"),
    (
        "{kind: wall, name: x}\nphone: {speaker_m: [0, 0.0701, 0], mics_m: [[0, 0.07, 0], [0, -0.07, 0]]}",
        5,
        r"phone: speaker_m must be 0.001 to 1 m from each microphone, got 0.0001 and 0.1401 m",
    ),
    (
        "{kind: wall, name: x}\nphone: {speaker_m: [0, 50, 0], mics_m: [[0, 70, 0], [0, -70, 0]]}",
        5,
        r"phone: mics_m must be 0.05 to 1 m apart, got 140 m",
    ),
    ("{kind: wall, name: x}\nwalk:\n  stops:\n  - {at_s: 1}", 7, r"walk.stops\[0\].for_s: is missing"),
    ("{kind: wall, name: x}\nphone: {preset: nokia}", 5, r"phone.preset: phone must be one of .*got 'nokia'"),
    ("{kind: box, name: x, parameters: {size_m: [1]}}", 4, r"obstacles\[0\]: size_m must be three numbers, got \[1\]"),
    ("{kind: fence, name: x, parameters: {height_m: 0.1}}", 4, r"obstacles\[0\]: height_m must be at least 0.2 m, for"),
    ("{kind: wall, name: x, parameters: {length_m: 1.0e+9}}", 4, r"obstacles\[0\]: length_m .* 1000 m, got 1e\+09"),
    (
        "{kind: box, name: x, parameters: {size_m: [1, .inf, 1]}}",
        4,
        r"obstacles\[0\]: size_m must be finite, got",
    ),
    ("[unclosed", 5, r"a scene file must be YAML"),
]


@pytest.mark.parametrize(("line", "number", "message"), MISTAKES)
def test_mistakes_in_a_file_are_named_with_line_and_field(tmp_path: Path, line: str, number: int, message: str) -> None:
    (tmp_path / "broken.ply").write_text("ply or not")
    path = written(tmp_path, f"# a file\nname: test\nobstacles:\n  - {line}\n")
    with pytest.raises(ValueError, match=rf"^scene\.yaml:{number}: {message}") as caught:
        load_scene(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: x\nobstacles: []\nwalk: {}", "scene.yaml:2: obstacles: a scene to walk through must have an obstacle"),
        (WALK + "target: dog", r"scene.yaml:6: target: .*got 'dog'; there are \['bin', 'end'\]"),
        (WALK.replace("walk:", "#"), "scene.yaml:1: walk: is missing"),
        (WALK.replace("start_m: [1, 0.5], heading_deg: 0", "waypoints_m: [[0, 0], [1, 0], [1, 9]]"),
         "scene.yaml:5: walk: parts of a route must be at least twice"),
        (WALK + "phone: {length_m: 0.15, mics_m: [[0, 1, 0], [0, 0, 0]], speaker_m: [0, 0, 1]}",
         "scene.yaml:6: phone: a phone must have either"),
        (WALK.replace("duration_s: 3", "duration_s: 1.0e+9"), "scene.yaml:5: walk: a walk must last at most 14400 s"),
        ("- 1", "scene.yaml:1: a scene file must be a mapping"),
        ("", "scene.yaml:1: a scene file must be a mapping"),
    ],
)  # fmt: skip
def test_mistakes_about_the_walk_are_named(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_encounter(written(tmp_path, text.lstrip("\n")))


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_bytes(b"name: \xff\xfe")
    with pytest.raises(ValueError, match=r"scene.yaml: a scene file must be UTF-8 text"):
        load_scene(path)


def test_two_mistakes_are_said_in_order_of_lines(tmp_path: Path) -> None:
    text = "obstacles:\n  - {kind: dragon, name: x}\nair: {temperature_c: hot}\n"
    with pytest.raises(ValueError, match=r"scene.yaml:1: name: is missing; scene.yaml:2: .*; scene.yaml:3: "):
        load_scene(written(tmp_path, text))


def test_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nowhere\.yaml"):
        load_scene(tmp_path / "nowhere.yaml")
    path = written(tmp_path, "name: test\nobstacles:\n  - {mesh: lost.ply, units: m, name: x, material: brick}\n")
    with pytest.raises(FileNotFoundError, match=r"scene\.yaml:3: obstacles\[0\]: mesh file must exist.*lost\.ply"):
        load_scene(path)


def test_a_walk_from_yaml(tmp_path: Path) -> None:
    met = load_encounter(written(tmp_path, WALK))
    assert isinstance(met.walk, GaitWalk)
    np.testing.assert_array_equal(met.walk.start_m, [1.0, 0.5, 1.25])
    assert (met.walk.speed_m_s, met.walk.duration_s) == (1.2, 3.0)
    assert met.walk.pitch_rad == pytest.approx(np.deg2rad(25.0))
    assert met.phone.geometry.name == "galaxy-s5"
    assert met.phone.body is not None
    assert met.targets == ("bin",)  # touched on the way to the wall, which is not reached
    assert load_encounter(written(tmp_path, WALK + "target: end\n")).target.category == "wall"


def test_a_route_with_stops_from_yaml(tmp_path: Path) -> None:
    route = "walk: {waypoints_m: [[0, 0], [4, 0], [4, 4]], stops: [{at_s: 1, for_s: 2}], holding: horizontal}"
    walk = load_encounter(written(tmp_path, WALK.split("walk:")[0] + route)).walk
    assert isinstance(walk, RouteWalk)
    assert walk.duration_s == pytest.approx(8.0 / 1.3 + 2.0, abs=1e-6)
    np.testing.assert_allclose(walk.mean_plan_m([walk.duration_s])[0], [4.0, 4.0], atol=1e-6)
    assert walk.holding == "horizontal"
    arc = "walk: {start_m: [0, 0], heading_deg: 90, arc: {radius_m: 3, turn_deg: -90}}"
    bent = load_encounter(written(tmp_path, WALK.split("walk:")[0] + arc)).walk
    assert bent.pose([bent.duration_s]).body_heading_rad()[0] == pytest.approx(0.0, abs=1e-6)


def test_the_seed_draws_only_what_the_file_leaves_open(tmp_path: Path) -> None:
    path = written(tmp_path, WALK)
    time = np.linspace(0.0, 3.0, 20)
    fixed = [load_encounter(path, seed).walk.pose(time).position_m for seed in (0, 1)]
    np.testing.assert_array_equal(*fixed)
    open_ = written(tmp_path, WALK.replace("}\nwalk: {", "}\nwalk: {vary: {lateral_m: 0.3, heading_deg: 4}, "))
    walks = [load_encounter(open_, seed).walk for seed in range(40)]
    start = np.array([walk.start_m for walk in walks])
    assert 0.2 < np.abs(start[:, 1] - 0.5).max() <= 0.3
    np.testing.assert_allclose(start[:, [0, 2]], np.tile([1.0, 1.25], (40, 1)), atol=1e-12)
    assert 2.0 < np.rad2deg([abs(walk.heading_rad) for walk in walks]).max() <= 4.0
    np.testing.assert_array_equal(start[3], load_encounter(open_, 3).walk.start_m)


def test_ones_own_phone(tmp_path: Path) -> None:
    own = "phone: {name: mine, length_m: 0.17, level_spl_db: 60}"
    phone = load_encounter(written(tmp_path, WALK + own)).phone
    assert phone.geometry.name == "mine"
    assert phone.geometry.mic_separation_m == pytest.approx(0.17)
    assert phone.geometry.speaker_to_mic_m == pytest.approx([0.03, 0.14])
    assert phone.level_spl_db == 60.0
    assert phone.structure_borne is not None
    np.testing.assert_allclose(phone.structure_borne.delay_s, np.array([0.03, 0.14]) / 1500.0)
    np.testing.assert_allclose(phone.structure_borne.gain, 1.5 / np.array([0.03, 0.14]))
    other = load_encounter(written(tmp_path, WALK + own), phone="galaxy-note5").phone
    assert other.geometry.name == "galaxy-note5"
    placed = "phone: {preset: ideal, speaker_m: [0, 0.05, 0], mics_m: [[0.03, 0.07, 0], [-0.03, -0.07, 0]]}"
    np.testing.assert_array_equal(
        load_encounter(written(tmp_path, WALK + placed)).phone.geometry.mics_m, [[0.03, 0.07, 0], [-0.03, -0.07, 0]]
    )


def test_simulate_takes_the_files_own_walk_and_refuses_another(tmp_path: Path) -> None:
    path = written(tmp_path, WALK.replace("duration_s: 3", "duration_s: 0.3"))
    sound = tmp_path / "walk.wav"
    done = CliRunner().invoke(cli, ["simulate", str(path), "-o", str(sound)])
    assert done.exit_code == 0, done.output
    assert "0.27 s, 2 microphones" in done.output
    clash = CliRunner().invoke(cli, ["simulate", str(path), "-o", str(sound), "--speed", "1", "--heading", "3"])
    assert "has a walk of its own, so --heading, --speed must not be given" in str(clash.exception)


@pytest.mark.parametrize(
    ("given", "named"), [(["--category", "wall", "--speed", "2"], "--speed"), (["--index", "3"], "--index")]
)
def test_simulate_refuses_options_that_would_do_nothing(tmp_path: Path, given: list[str], named: str) -> None:
    """An approach has a speed of its own: --speed was taken and ignored."""
    done = CliRunner().invoke(cli, ["simulate", "supermarket", "-o", str(tmp_path / "a.wav"), *given])
    assert f"so {named} must not be given" in str(done.exception)
    assert not (tmp_path / "a.wav").exists()


def test_every_obstacle_is_a_kind(tmp_path: Path) -> None:
    helpers = {"CATEGORIES", "ground", "random_obstacle", "walker_body"}
    assert set(obstacles.__all__) - helpers == set(KINDS) - {"box", "cylinder"}
    free = [kind for kind in KINDS if kind not in ("box", "cylinder")]  # the others have measures that must be given
    lines = [f"  - {{kind: {kind}, name: {kind}, at_m: [0, {5 * number}]}}" for number, kind in enumerate(free)]
    scene = load_scene(written(tmp_path, "name: all\nobstacles:\n" + "\n".join(lines) + "\n"))
    assert {one.name for one in scene.obstacles} == {"ground", *free}
    assert all(one.category == "ground" or one.category == KINDS[one.name].category for one in scene.obstacles)


def test_an_unknown_phone_asked_for_is_said_without_a_line_of_the_file(tmp_path):
    """The phone of a suite was checked as a field of the scene file: pydantic's dump, with a wrong place."""
    with pytest.raises(ValueError, match=r"^phone must be one of ideal, .*nexus-6p, got 'galaxy'$"):
        load_encounter(written(tmp_path, WALK), phone="galaxy")
