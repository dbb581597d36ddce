"""What an image sees of a body: nothing that sound reaches may be passed over before it is walked to."""

from __future__ import annotations

import numpy as np
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation
from simulator.images.image_method import REACHED, crossed
from simulator.images.image_pairs import images_of
from simulator.kirchhoff.lighting import _in_view, _Views
from simulator.surfaces.facets import facets_of
from simulator.trace import still_tracing
from simulator.world.frames import out_of_rest
from simulator.world.search_context import Search


def test_whatever_sound_reaches_through_the_mirrors_is_in_view():
    """Facets are asked about only on lines through the last mirror: a test of that alone must keep all that pass."""
    ground = trimesh.Trimesh([[-9.0, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    wall = trimesh.creation.box(bounds=[[1.0, 1.2, 0.0], [2.2, 1.3, 1.1]])
    body = trimesh.creation.icosphere(subdivisions=3, radius=0.4).apply_translation([2.0, 0.0, 0.9])
    parts = {"ground": ground, "wall": wall, "body": body}
    scene = Scene([Obstacle(mesh, Material.rigid(), name) for name, mesh in parts.items()], Air.lossless(343.0))
    pose = Pose([[0.0, 0.2, 1.3]], held_rotation(np.zeros(1)))
    phone, fidelity = Phone.named("ideal"), Fidelity(level="reference")
    tracing = still_tracing(scene, phone, pose, np.zeros(1), fidelity)
    surface = tracing.world.surfaces[0]
    facets = facets_of(*tracing.world.skins[2], 2, 0.05)
    images = images_of(Search(tracing, phone, scene.air, fidelity), surface, tracing.source_m, 2)
    views = _Views.of(tracing, tracing.source_m[images.pose], images.pose, images.order, images.sequence)
    np.testing.assert_allclose(views.image_m, images.point_m, atol=1e-12)
    frame = tracing.placed[views.pose, 2]
    args = frame, facets.middle_m, facets.normal, facets.closed
    view, place = _in_view(tracing.mirrors, views.pose, views.order, views.sequence, views.image_m, *args)
    asked = np.zeros((len(views), len(facets)), dtype=bool)
    asked[view, place] = True
    middle = out_of_rest(facets.middle_m, np.repeat(tracing.placed[:, 2], len(facets), axis=0))
    for v in range(len(views)):
        one = np.full(len(facets), v)
        code, _ = crossed(tracing, views.start_m[one], middle, views.pose[one], views.order[one], views.sequence[one])
        facing = np.sum((views.image_m[v] - middle) * facets.normal, axis=1) > 0.0
        reached = facing & (code == REACHED)
        assert not (reached & ~asked[v]).any(), v
    assert set(views.order[view]) == {0, 1, 2}
    assert not asked.all(axis=1).any()
