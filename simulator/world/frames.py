"""Where every obstacle stands at any instant: still, drifting, or carried along with the walker."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.compiled import compiled, inlined
from simulator.surfaces.wedges import Wedges

Carrier = Callable[[Ints, Floats], tuple[Floats, Floats]]


@dataclass(frozen=True)
class Frames:
    """Rest frames of the obstacles; a frame is a shift and a turn about the vertical.

    Attributes:
        velocity_m_s: (O, 3) of drifting obstacles; 0 stands still.
        carried: (O,) bool, obstacles that go with the walker (the walker's body).
        carrier: (pose (R,), time (R,)) -> position (R, 3) and heading (R,) of the walker.
    """

    velocity_m_s: Floats
    carried: Flags
    carrier: Carrier

    @property
    def moves(self) -> Flags:
        """(O,) whether an obstacle ever leaves its rest frame."""
        return self.carried | np.any(self.velocity_m_s != 0.0, axis=1)

    def at(self, pose: Ints, time_s: Floats) -> Floats:
        """(R, O, 4) x, y, z, yaw of every obstacle's rest frame."""
        count = len(self.carried)
        rows = self.of(np.tile(np.arange(count), len(pose)), np.repeat(pose, count), np.repeat(time_s, count))
        return rows.reshape(len(pose), count, 4)

    def of(self, obstacle: Ints, pose: Ints, time_s: Floats) -> Floats:
        """(R, 4) frame of one obstacle a row."""
        rows = np.zeros((len(obstacle), 4))
        rows[:, :3] = time_s[:, None] * self.velocity_m_s[obstacle]
        carried = np.flatnonzero(self.carried[obstacle])
        if len(carried):
            rows[carried, :3], rows[carried, 3] = self.carrier(pose[carried], time_s[carried])
        return rows


def rest_frames(velocity_m_s: Floats, carried: Flags) -> Ints:
    """(O,) number of the rest frame of each obstacle, the same for those that never move against one another.

    Those at rest come first.
    """
    frame = np.column_stack([carried, velocity_m_s])
    _, first, group = np.unique(frame, axis=0, return_index=True, return_inverse=True)
    place = np.argsort(np.lexsort((first, frame[first].any(axis=1))))
    return place[group.ravel()].astype(np.int64)


def rotated(vector: Floats, yaw: Floats) -> Floats:
    """(R, 3) vectors rotated about the vertical, one angle a row."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = vector[..., 0], vector[..., 1]
    vectors = np.empty(np.broadcast_shapes(vector.shape, (*yaw.shape, 1)))
    vectors[..., 0], vectors[..., 1], vectors[..., 2] = c * x - s * y, s * x + c * y, vector[..., 2]
    return vectors


def into_rest(point_m: Floats, frame: Floats) -> Floats:
    """World points (R, 3) as seen in rest frames (R, 4)."""
    return rotated(point_m - frame[..., :3], -frame[..., 3])


def out_of_rest(point_m: Floats, frame: Floats) -> Floats:
    """The inverse of `into_rest`."""
    return rotated(point_m, frame[..., 3]) + frame[..., :3]


def wedges_out_of_rest(wedges: Wedges, frame: Floats) -> Wedges:
    """(R,) edges, one a row, where their obstacles' frames (R, 4) put them."""
    return replace(
        wedges, start_m=out_of_rest(wedges.start_m, frame), end_m=out_of_rest(wedges.end_m, frame),
        inwards=rotated(wedges.inwards, frame[:, 3]), normal=rotated(wedges.normal, frame[:, 3]),
    )  # fmt: skip


@inlined
def rotated_back(x, y, cosine, sine):
    """The level parts of a vector of the world as a frame sees it whose yaw has this cosine and sine."""
    return cosine * x + sine * y, cosine * y - sine * x


@compiled
def fill_rest(point, frame, local):
    """Fill in a world point (3,) as seen in a rest frame (4,)."""
    x, y = point[0] - frame[0], point[1] - frame[1]
    local[0], local[1] = rotated_back(x, y, np.cos(frame[3]), np.sin(frame[3]))
    local[2] = point[2] - frame[2]


def rotated_tensor(tensor: Floats, yaw: Floats) -> Floats:
    """(R, 3, 3) symmetric tensors rotated about the vertical."""
    return rotated(np.swapaxes(rotated(tensor, yaw[:, None]), -1, -2), yaw[:, None])
