"""A room with a pier in it against acoustic-spaces: the set of image paths and their lengths, orders 1 to 3."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, trace_paths

C = 343.0
# two rooms of 4 x 3.5 m and 2.7 x 3.5 m, open to each other beside a pier of 0.3 m: many images are hidden or missed
PLAN = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.6], [4.3, 1.6], [4.3, 0.0], [7.0, 0.0], [7.0, 3.5], [0.0, 3.5]]


def _peer(source: list[float], receivers: list[list[float]]) -> dict:
    if importlib.util.find_spec("acoustic_spaces") is None:
        pytest.skip("the peer acoustic-spaces is not installed")
    room = {"plan": PLAN, "height": 2.6, "source": source, "receivers": receivers, "order": 3}
    program = [sys.executable, "-m", "tests.references.acoustic_spaces_paths"]
    answer = subprocess.run(program, input=json.dumps(room), capture_output=True, text=True, check=True)
    return json.loads(answer.stdout)


@pytest.mark.parametrize(
    ("source", "receivers"),
    [
        ([1.2, 1.1, 1.3], [[1.3, 1.25, 1.3], [5.2, 2.9, 1.1]]),
        ([3.7, 1.8, 1.25], [[4.1, 2.0, 1.25], [4.6, 0.7, 0.9]]),  # beside the pier, and round it
    ],
)
def test_image_paths_of_a_room_with_a_pier(source, receivers):
    peer = _peer(source, receivers)
    mesh = trimesh.Trimesh(peer["vertices"], peer["faces"], process=False)
    if mesh.volume > 0.0:
        mesh.invert()  # the inside of the room reflects
    phone = Phone.ideal(np.zeros(3), np.array(receivers) - source)
    paths = trace_paths(
        Scene([Obstacle(mesh, Material.rigid(), "room")], Air.lossless(C)), phone, Pose(source, Rotation.identity()),
        Fidelity(max_order=3, max_range_m=100.0, mechanisms=("specular",)),
    )  # fmt: skip
    for mic, theirs in enumerate(peer["paths"]):
        ours = paths[paths.mic == mic]
        found, expected = (
            sorted(zip(order, np.round(length, 9), strict=True))
            for order, length in ((ours.order.tolist(), ours.delay_s * C), (theirs["order"], theirs["length_m"]))
        )
        found, expected = ([path for path in each if path[0] > 0] for each in (found, expected))
        assert len(found) >= 20
        np.testing.assert_allclose(found, expected, atol=1e-8)
