"""Whether a straight line is free: rays that miss a blocker's box are not asked, which must not be seen."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from simulator.world.visibility import blocker

BODIES = {
    "bin": trimesh.creation.cylinder(radius=0.3, height=1.0, sections=48),
    "sheet": trimesh.Trimesh([[-2.0, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0]], [[0, 1, 2], [0, 2, 3]]),
    "box": trimesh.creation.box([0.6, 2.0, 1.1]),
}


@pytest.mark.parametrize("name", BODIES)
def test_lines_are_blocked_as_by_the_triangles_themselves(name):
    body, rng = BODIES[name], np.random.default_rng(3)
    shadow = blocker(
        [(np.asarray(body.vertices, dtype=float), np.asarray(body.faces))], np.zeros(len(body.faces), dtype=np.int64)
    )
    frame = np.array([[0.0, 0.0, 0.0, 0.0], [3.0, -1.0, 0.5, 2.2], [-2.0, 0.3, 0.0, -0.7]])
    pose = np.sort(rng.integers(0, 3, 3000))
    rest = rng.uniform(-1.6, 1.6, (2, 3000, 3))
    rest[1, ::5, 1:] = rest[0, ::5, 1:]  # along an axis
    rest[0, 1::5] *= 0.05  # from within
    c, s = np.cos(frame[pose, 3]), np.sin(frame[pose, 3])
    start, end = (
        np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1], p[:, 2]], axis=1) + frame[pose, :3]
        for p in rest
    )
    asked = rng.random(3000) < 0.9
    blocked = shadow.blocks_from(start, end, frame, pose, asked)
    np.testing.assert_array_equal(blocked, _crosses(body, *rest) & asked)
    assert 0.05 < blocked.mean() < 0.8


def _crosses(body: trimesh.Trimesh, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(R,) whether lines (R, 3) to (R, 3) pass through some triangle, by the signs of volumes."""

    def volume(a, b, c, d):
        return np.einsum("rtx,rtx->rt", np.cross(b - a, c - a), d - a)

    corner = np.asarray(body.triangles)[None]
    a, b, c = (np.broadcast_to(corner[:, :, i], (len(start), len(body.faces), 3)) for i in range(3))
    p, q = (np.broadcast_to(end[:, None], a.shape) for end in (start, end))
    through = (volume(a, b, c, p) > 0) != (volume(a, b, c, q) > 0)
    around = np.stack([volume(p, q, a, b) > 0, volume(p, q, b, c) > 0, volume(p, q, c, a) > 0])
    return (through & (around.all(axis=0) | ~around.any(axis=0))).any(axis=1)
