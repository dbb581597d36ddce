"""Where the phone is: single poses, arrays of them, and walks as functions of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from obstaclewatch.support.argument_types import as_floats, as_points, check_angles, check_broadcast, check_types
from obstaclewatch.support.arrays import Floats
from simulator.scene.walk_checks import MOST_TURNS, hold_straight, times_of

UPRIGHT = 1e-6  # horizontal part of a long edge: its direction is then rounding
FARTHEST_M = 1e9  # from the origin: farther out nothing is known to a micrometre
MOST_HEADING_RAD = 1e6  # of a pose, which may wind up with time; farther on a direction is rounding


@dataclass(frozen=True, eq=False)
class Pose:
    """One pose, or N of them, of the phone in the world.

    Attributes:
        position_m: (3,) or (N, 3) origin of the phone frame, m.
        rotation: scipy Rotation, phone frame -> world; one, or N.
        heading_rad: (N,) direction in which the walker's body faces, counter-clockwise from world +x; None takes
            the horizontal direction of the phone's long edge.

    Raises:
        ValueError: shapes that do not fit, numbers that are not finite.

    Example:
        >>> from simulator import Pose, held_rotation
        >>> pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
        >>> pose.to_world([0.0, 0.1, 0.0]).round(3)  # 10 cm up the long edge is 10 cm ahead
        array([[0.1, 0. , 1.3]])
    """

    position_m: Floats
    rotation: Rotation
    heading_rad: Floats | None = None

    def __post_init__(self) -> None:
        position = as_floats("position_m", self.position_m)
        if position.shape[-1:] != (3,) or position.ndim > 2 or position.size == 0 or not np.isfinite(position).all():
            raise ValueError(f"position_m must be finite with shape (3,) or (N, 3), N > 0, got {self.position_m}")
        if not isinstance(self.rotation, Rotation):
            raise ValueError(f"rotation must be a scipy Rotation, got {type(self.rotation).__name__}")
        if np.abs(position).max() > FARTHEST_M:
            raise ValueError(f"position_m must be within {FARTHEST_M:g} m of the origin, got {self.position_m}")
        object.__setattr__(self, "position_m", position)
        count = 1 if position.ndim == 1 else len(position)
        if not self.rotation.single and len(self.rotation) != count:
            raise ValueError(f"rotation must be one or {count} rotations, got {len(self.rotation)}")
        if not np.isfinite(self.rotation.as_quat()).all():
            raise ValueError(f"rotation must be finite, got {self.rotation.as_quat().tolist()} for its quaternion")
        if self.heading_rad is not None:
            heading = as_floats("heading_rad", self.heading_rad)
            if heading.shape not in ((), (1,), (count,)) or not np.isfinite(heading).all():
                raise ValueError(f"heading_rad must be finite with shape ({count},), got {self.heading_rad}")
            if np.abs(heading).max() > MOST_HEADING_RAD:
                raise ValueError(f"heading_rad must be within +-{MOST_HEADING_RAD:g} rad, got {self.heading_rad}")
            heading = np.broadcast_to(heading, (count,))
            object.__setattr__(self, "heading_rad", heading)

    def __len__(self) -> int:
        return 1 if self.position_m.ndim == 1 else len(self.position_m)

    def __getitem__(self, index: slice) -> Pose:
        """Some of N poses; there must be at least one."""
        rotation = self.rotation if self.rotation.single else self.rotation[index]
        heading = None if self.heading_rad is None else self.heading_rad[index]
        return Pose(np.atleast_2d(self.position_m)[index], rotation, heading)

    def to_world(self, point_m: ArrayLike) -> Floats:
        """(N, ..., 3) world positions of (..., 3) points of the phone frame."""
        points = as_points("point_m", point_m)
        matrices = np.broadcast_to(self.rotation.as_matrix().reshape(-1, 3, 3), (len(self), 3, 3))
        rotated = np.einsum("nij,...j->n...i", matrices, points)
        origins = self.position_m.reshape((-1,) + (1,) * (points.ndim - 1) + (3,))
        return rotated + origins

    def body_heading_rad(self) -> Floats:
        """(N,) direction in which the walker's body faces.

        Raises:
            ValueError: no heading is given, and the phone's long edge is upright.
        """
        if self.heading_rad is not None:
            return self.heading_rad
        edge = np.broadcast_to(self.rotation.as_matrix().reshape(-1, 3, 3), (len(self), 3, 3))[:, :, 1]
        if (np.hypot(edge[:, 0], edge[:, 1]) < UPRIGHT).any():
            raise ValueError("heading_rad must be given where the phone's long edge is upright, got None")
        return np.arctan2(edge[:, 1], edge[:, 0])


def held_rotation(heading_rad: ArrayLike, pitch_rad: ArrayLike = 0.0, roll_rad: ArrayLike = 0.0) -> Rotation:
    """Rotation of a phone held in portrait, top edge forwards, screen up, then pitched and rolled.

    At zero pitch the phone lies level: +y (long edge) along the heading, +x to the right, +z up.
    A positive pitch raises the top edge; a positive roll, about the long edge, lowers the right-hand side.

    Args:
        heading_rad, pitch_rad, roll_rad: scalars or arrays that broadcast, rad; a heading may wind up to four turns.

    Raises:
        ValueError: an angle that is not finite, or so large that it must be in degrees.

    Example:
        >>> import numpy as np
        >>> from simulator import held_rotation
        >>> upright = held_rotation(heading_rad=0.0, pitch_rad=np.pi / 2)
        >>> upright.apply([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).round(3) + 0.0  # top edge up, screen to the holder
        array([[ 0.,  0.,  1.],
               [-1.,  0.,  0.]])
    """
    check_angles(MOST_TURNS, heading_rad=heading_rad)
    check_angles(pitch_rad=pitch_rad, roll_rad=roll_rad)
    check_broadcast(heading_rad=heading_rad, pitch_rad=pitch_rad, roll_rad=roll_rad)
    angles = np.broadcast_arrays(np.asarray(heading_rad, float) - np.pi / 2, pitch_rad, roll_rad)
    (cz, cx, cy), (sz, sx, sy) = (np.stack([f(0.5 * a) for a in angles]) for f in (np.cos, np.sin))
    # the product of the quaternions about z, x and y, sixty times faster than Rotation.from_euler("ZXY", ...)
    vector = cz * sx * cy - sz * cx * sy, cz * cx * sy + sz * sx * cy, sz * cx * cy + cz * sx * sy
    return Rotation.from_quat(np.stack([*vector, cz * cx * cy - sz * sx * sy], axis=-1))


def poses_of(walk: Walk, time_s: Floats) -> Pose:
    """Where a walk is at times (N,).

    Raises:
        ValueError: it answers with something else, or with another number of poses.
    """
    there = walk.pose(time_s)
    check_types(pose=(there, Pose))
    if len(there) != len(time_s):
        raise ValueError(f"pose of the walk must give one pose for each of {len(time_s)} times, got {len(there)}")
    return there


@runtime_checkable
class Walk(Protocol):
    """Anything that can say where the phone is at any instant.

    Poses must be smooth functions of time over a beep: delays are followed inside it. `render_walk` asks for them from
    up to 2 ms before 0, and after `duration_s` until the last echo has arrived and 3 ms more: a walk must answer there.

    Example:
        >>> from simulator import StraightWalk, Walk
        >>> isinstance(StraightWalk([0.0, 0.0, 1.3], 0.0, 1.3, 4.0), Walk)
        True
    """

    @property
    def duration_s(self) -> float:
        """Length of the walk, s."""

    def pose(self, time_s: ArrayLike) -> Pose:
        """(N,) times, s, to N poses with headings."""


@dataclass(frozen=True, eq=False)
class StraightWalk:
    """Constant velocity, no gait: the walk against which exact formulas are checked.

    Attributes:
        start_m: (3,) position of the phone at time 0.
        heading_rad: direction of travel, counter-clockwise from +x.
        speed_m_s: not negative; 0 stands still.
        duration_s: length of the walk.
        pitch_rad: elevation of the phone's top edge.

    Raises:
        ValueError: a negative or infinite speed or duration, a start that is not finite, an angle in degrees.

    Example:
        >>> from simulator import StraightWalk
        >>> walk = StraightWalk([0.0, 0.0, 1.3], heading_rad=0.0, speed_m_s=1.5, duration_s=4.0)
        >>> walk.pose([0.0, 2.0]).position_m
        array([[0. , 0. , 1.3],
               [3. , 0. , 1.3]])
    """

    start_m: Floats
    heading_rad: float
    speed_m_s: float
    duration_s: float
    pitch_rad: float = 0.0

    def __post_init__(self) -> None:
        hold_straight(self, "pitch_rad")

    def pose(self, time_s: ArrayLike) -> Pose:
        """(N,) times, s, to N poses."""
        time = times_of(time_s)
        direction = np.array([np.cos(self.heading_rad), np.sin(self.heading_rad), 0.0])
        position = self.start_m + self.speed_m_s * time[:, None] * direction
        heading = np.full(len(time), self.heading_rad)
        return Pose(position, held_rotation(heading, self.pitch_rad), heading)
