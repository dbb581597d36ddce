"""Half-spaces that mirrors show, against the image method: what is crossed inside every patch, and what is not."""

from dataclasses import replace

import numpy as np
import pytest

from simulator import Air, Fidelity, Phone, Pose, Scene, held_rotation
from simulator.images.image_method import REACHED, crossed
from simulator.images.image_pairs import images_of
from simulator.images.shown import shown
from simulator.trace import still_tracing
from simulator.world.frames import out_of_rest
from simulator.world.search_context import Search


@pytest.fixture
def corner(box, cylinder):
    """A post that drifts, beside two walls on the ground."""
    post = replace(cylinder(0.4, 2.0, (2.0, 0.3, 1.0), 24), velocity_m_s=(0.5, -0.2, 0.0))
    walls = [box((0.2, 1.2, 1.5), (3.0, 0.5, 0.75), "far"), box((1.5, 0.2, 1.2), (1.8, 1.5, 0.6), "side")]
    return Scene([post, *walls, box((6.0, 6.0, 0.2), (2.0, 0.0, -0.1), "ground")], Air.lossless(343.0))


def test_a_point_is_shown_where_every_mirror_is_crossed_inside(corner):
    pose, time = Pose([0.0, 0.0, 1.3], held_rotation(0.0)), np.array([0.4])
    tracing = still_tracing(corner, Phone.named("ideal"), pose, time, Fidelity())
    surface = tracing.world.surfaces[0]
    images = images_of(Search(tracing, Phone.named("ideal"), corner.air, Fidelity()), surface, tracing.source_m, 2)
    within = shown(tracing, images, surface.obstacle, 0.0)
    rng, met = np.random.default_rng(5), [0, 0]
    for row in np.flatnonzero(images.order > 0):
        one = np.full(200, row)
        rest = surface.center_m + rng.uniform(-1.2, 1.2, (200, 3))
        point = out_of_rest(rest, tracing.placed[np.zeros(200, int), surface.obstacle])
        ends = np.repeat(tracing.source_m, 200, axis=0), point
        code = crossed(tracing, *ends, images.pose[one], images.order[one], images.sequence[one])[0]
        inside = (np.einsum("kx,rx->rk", within[row, :, :3], rest) >= within[row, :, 3]).all(axis=1)
        assert inside[code == REACHED].all()
        if images.order[row] == 1:  # rectangles: what misses them is not shown
            assert not inside[code != REACHED].any()
        met[0] += int((code == REACHED).sum())
        met[1] += int((~inside).sum())
    assert min(met) > 200


def test_what_is_not_mirrored_is_not_bounded(corner):
    pose = Pose([0.0, 0.0, 1.3], held_rotation(0.0))
    tracing = still_tracing(corner, Phone.named("ideal"), pose, np.zeros(1), Fidelity())
    surface = tracing.world.surfaces[0]
    images = images_of(Search(tracing, Phone.named("ideal"), corner.air, Fidelity()), surface, tracing.source_m, 1)
    assert not shown(tracing, images[np.flatnonzero(images.order == 0)], surface.obstacle, 0.3).any()
