"""Named streets."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from scenes import list_scenes, load_scene
from scenes.preview.pictures import preview_around, preview_scene
from scenes.streets.approaches import DATA_COLLECTION, make_approach
from scenes.truth.swept import Slab


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
    obstacles = [o for o in load_scene(name, seed).obstacles if o.category != "ground"]
    assert sum(o.category != "wall" for o in obstacles) > 8
    found = [(o, Slab.of(o.mesh, 0.0, 3.0), np.stack(_outline(o))) for o in obstacles]
    for (one, slab, sides), (other, its_slab, its_sides) in combinations(found, 2):
        if one.category != "wall" or other.category != "wall":
            gap_m = min(slab.distance(its_sides).min(), its_slab.distance(sides).min())
            assert gap_m > 0.05, (one.name, other.name)


def test_seeds_give_other_streets_and_repeat() -> None:
    one, again, other = (load_scene("campus", seed) for seed in (1, 1, 2))
    vertices = [np.concatenate([o.mesh.vertices for o in scene.obstacles]) for scene in (one, again, other)]
    np.testing.assert_array_equal(vertices[0], vertices[1])
    assert vertices[0].shape != vertices[2].shape or not np.allclose(vertices[0], vertices[2])


def test_an_unknown_scene_is_refused_with_the_names_there_are() -> None:
    assert list_scenes() == ["campus", "supermarket"]
    with pytest.raises(ValueError, match=r"one of \['campus', 'supermarket'\] or a .yaml file, got 'moon'"):
        load_scene("moon")


def test_previews_are_pictures(tmp_path: Path) -> None:
    approach = make_approach("supermarket", "sign", 1)
    paths = [
        preview_scene(load_scene("campus"), tmp_path / "scene.png"),
        preview_around(approach.scene, approach.walk, approach.target, tmp_path / "approach.png"),
    ]
    for path in paths:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 5_000


def _outline(thing) -> list[np.ndarray]:
    """The sides of the bounding rectangle in plan."""
    (x, y), (right, top) = thing.mesh.bounds[:, :2]
    corner = np.array([[x, y], [right, y], [right, top], [x, top], [x, y]])
    return [corner[k : k + 2] for k in range(4)]
