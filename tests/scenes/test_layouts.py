"""Named streets and YAML scenes."""

from pathlib import Path

import numpy as np
import pytest

from scenes import list_scenes, load_scene
from scenes.approaches import DATA_COLLECTION
from scenes.preview import contact_sheet, preview_approach, preview_scene
from scenes.solids import box
from scenes.swept import Slab

YARD = """
name: back-yard
air: {temperature_c: 12, relative_humidity: 0.7}
ground: {material: asphalt, size_m: [40, 40]}
obstacles:
  - {kind: wall, name: garage, at_m: [6, 0], yaw_deg: 90, parameters: {length_m: 8, height_m: 3}, material: brick}
  - {kind: person, name: neighbour, at_m: [9, -1], velocity_m_s: [-1, 0, 0]}
  - {mesh: block.ply, units: mm, name: block, at_m: [4, -2], material: concrete, category: clutter}
"""


@pytest.mark.parametrize("name", ["campus", "supermarket"])
def test_a_street_has_all_the_papers_categories(name: str) -> None:
    scene = load_scene(name, seed=1)
    categories = {obstacle.category for obstacle in scene.obstacles}
    assert set(DATA_COLLECTION[name].cases) | {"ground", "clutter"} <= categories
    assert scene.name == name
    assert any(obstacle.moves for obstacle in scene.obstacles)


@pytest.mark.parametrize("name", ["campus", "supermarket"])
@pytest.mark.parametrize("seed", range(3))
def test_nothing_in_a_street_stands_in_anything_else(name: str, seed: int) -> None:
    things = [o for o in load_scene(name, seed).obstacles if o.category not in ("ground", "wall")]
    walls = [o for o in load_scene(name, seed).obstacles if o.category == "wall"]
    assert len(things) > 8
    for number, thing in enumerate(things):
        outline = _outline(thing)
        for other in [*walls, *things[number + 1 :]]:
            slab = Slab.of(other.mesh, 0.0, 3.0)
            assert min(slab.distance(edge) for edge in outline) > 0.05, (thing.name, other.name)


def test_seeds_give_other_streets_and_repeat() -> None:
    one, again, other = (load_scene("campus", seed) for seed in (1, 1, 2))
    vertices = [np.concatenate([o.mesh.vertices for o in scene.obstacles]) for scene in (one, again, other)]
    np.testing.assert_array_equal(vertices[0], vertices[1])
    assert vertices[0].shape != vertices[2].shape or not np.allclose(vertices[0], vertices[2])


def test_an_unknown_scene_is_refused_with_the_names_there_are() -> None:
    assert list_scenes() == ["campus", "supermarket"]
    with pytest.raises(ValueError, match=r"one of \['campus', 'supermarket'\] or a .yaml file, got 'moon'"):
        load_scene("moon")


def test_a_scene_from_yaml(tmp_path: Path) -> None:
    box([500.0, 1000.0, 800.0]).export(tmp_path / "block.ply")
    (tmp_path / "yard.yaml").write_text(YARD)
    scene = load_scene(tmp_path / "yard.yaml")
    assert scene.name == "back-yard"
    assert scene.air.temperature_c == 12.0
    np.testing.assert_allclose(scene.obstacle("garage").mesh.extents, [8.0, 0.25, 3.0], atol=1e-12)
    np.testing.assert_allclose(scene.obstacle("block").mesh.extents, [0.5, 1.0, 0.8], rtol=1e-6)
    np.testing.assert_allclose(scene.obstacle("block").mesh.bounds[:, :2].mean(axis=0), [4.0, -2.0], atol=1e-6)
    assert scene.obstacle("neighbour").category == "pedestrian"
    assert scene.obstacle("neighbour").moves
    assert scene.obstacles[0].category == "ground"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{kind: dragon, name: x}", "obstacles.0.kind: .*kind must be one of .*got 'dragon'"),
        ("{kind: wall, name: x, parameters: {lenght_m: 3}}", r"must be among .*got \['lenght_m'\]"),
        ("{kind: wall, name: x, colour: red}", "obstacles.0.colour: Extra inputs"),
        ("{name: x}", "'x' must have either a kind or a mesh"),
        ("{mesh: x.ply, name: x}", "'x' with a mesh must have a material"),
        ("{kind: wall, name: x, parameters: {length_m: -3}}", "must be positive, got -3"),
        ("{kind: wall, name: x, material: cheese}", "got 'cheese'"),
    ],
)
def test_mistakes_in_a_file_are_named(tmp_path: Path, line: str, message: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"name: test\nobstacles:\n  - {line}\n")
    with pytest.raises(ValueError, match=message):
        load_scene(path)


def test_a_file_that_is_not_yaml_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("name: [unclosed")
    with pytest.raises(ValueError, match="scene file must be YAML"):
        load_scene(path)


def test_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nowhere\.yaml"):
        load_scene(tmp_path / "nowhere.yaml")
    path = tmp_path / "scene.yaml"
    path.write_text("name: test\nobstacles:\n  - {mesh: lost.ply, name: x, material: brick}\n")
    with pytest.raises(FileNotFoundError, match=r"lost\.ply"):
        load_scene(path)


def test_previews_are_pictures(tmp_path: Path) -> None:
    from scenes import make_approach

    paths = [
        preview_scene(load_scene("campus"), tmp_path / "scene.png"),
        preview_approach(make_approach("supermarket", "sign", 1), tmp_path / "approach.png"),
        contact_sheet({"block": box([1.0, 1.0, 1.0])}, tmp_path / "sheet.png"),
    ]
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 5_000


def _outline(thing) -> list[np.ndarray]:
    """The sides of the bounding rectangle in plan."""
    (x, y), (right, top) = thing.mesh.bounds[:, :2]
    corner = np.array([[x, y], [right, y], [right, top], [x, top], [x, y]])
    return [corner[k : k + 2] for k in range(4)]
