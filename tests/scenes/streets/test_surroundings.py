"""What surrounds a walk: never nothing, other on every seed, the same on the same seed."""

from collections import Counter

import numpy as np
import pytest

from scenes import Approach, make_approach
from scenes.obstacles import random_obstacle
from scenes.streets.surroundings import SETTINGS

SEEDS = range(12)


@pytest.fixture(scope="module", params=["supermarket", "campus"])
def approaches(request: pytest.FixtureRequest) -> list[Approach]:
    return [make_approach(request.param, "dustbin", 0, seed=seed, collision=False) for seed in SEEDS]


def _around(approach: Approach) -> list:
    return [o for o in approach.scene.obstacles if o.name not in ("ground", approach.target)]


def test_no_target_stands_in_a_void(approaches: list[Approach]) -> None:
    around = [len(_around(approach)) for approach in approaches]
    assert min(around) >= 1
    assert np.mean(around) >= 2.5
    campus = approaches[0].scene_name == "campus"
    walkers = [sum(o.moves for o in _around(approach)) for approach in approaches]
    assert np.mean(walkers) > 1.0 if campus else np.mean(walkers) < 1.0


def test_seeds_vary_in_all_that_a_street_varies_in(approaches: list[Approach]) -> None:
    scene_name = approaches[0].scene_name
    names = {stretch.name for stretch in SETTINGS[scene_name].stretches}
    assert len({approach.stretch for approach in approaches}) >= len(names) - 1
    for vary in (
        lambda a: a.scene.obstacle("ground").material.name,
        lambda a: round(a.walk.speed_m_s, 6),
        lambda a: tuple(sorted(Counter(o.category for o in _around(a)).items())),
        lambda a: tuple(sorted(o.material.name for o in _around(a))),
        lambda a: any(o.name == "side-wall" for o in _around(a)),
        lambda a: any(o.name == "kerb" for o in _around(a)),
    ):
        assert len({vary(approach) for approach in approaches}) >= 2


def test_people_on_the_campus_go_both_ways_and_cross() -> None:
    turned = []
    for seed in range(16):
        approach = make_approach("campus", "car", 1, seed=seed, collision=False)
        for someone in (o for o in _around(approach) if o.moves):
            course = np.arctan2(someone.velocity_m_s[1], someone.velocity_m_s[0]) - approach.walk.heading_rad
            turned.append(np.cos(course))
    with_us, towards_us = np.sum(np.array(turned) > 0.9), np.sum(np.array(turned) < -0.9)
    assert with_us >= 5
    assert towards_us >= 5
    assert len(turned) - with_us - towards_us >= 2


@pytest.mark.parametrize("category", ["wall", "dustbin", "car", "sign", "pedestrian", "clutter"])
def test_every_category_has_variants(category: str) -> None:
    """Meshes of different make differ in their number of triangles, or in their shape from the side."""
    made = [random_obstacle(category, np.random.default_rng(seed), "x") for seed in range(30)]
    shape = [(len(o.mesh.faces), round(o.mesh.extents[0] / o.mesh.extents[2], 1)) for o in made]
    assert len(set(shape)) >= 3
    if category not in ("car", "sign"):  # all of sheet metal
        assert len({obstacle.material.name for obstacle in made}) >= 2
