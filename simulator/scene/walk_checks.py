"""What all walks refuse alike: their measures when they are made, and the times at which they are asked for poses."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, as_floats, check_angles, hold_numbers
from obstaclewatch.support.arrays import Floats

MOST_TURNS = 4.0  # of a heading, as walks round a block wind it up; 30 degrees taken for radians are more


def hold_straight(walk: Any, *angles: str) -> None:
    """Check and hold start, heading, speed, duration and these angles of a straight walk, a frozen dataclass.

    Raises:
        ValueError: a start that is not three finite numbers, a speed that is negative or not finite; see `hold_held`.
    """
    hold_held(walk, *angles)
    hold_numbers(walk, "heading_rad", "speed_m_s")
    check_angles(MOST_TURNS, heading_rad=walk.heading_rad)
    if not 0.0 <= walk.speed_m_s < np.inf:
        raise ValueError(f"speed_m_s must be finite and not negative, got {walk.speed_m_s}")
    start = as_floats("start_m", walk.start_m)
    if start.shape != (3,) or not np.isfinite(start).all():
        raise ValueError(f"start_m must be three finite numbers, got {walk.start_m}")
    start.setflags(write=False)
    object.__setattr__(walk, "start_m", start)


def hold_held(walk: Any, *angles: str) -> None:
    """Check and hold duration and the angles at which the phone is held, of any walk.

    Raises:
        ValueError: a duration that is not positive and finite, an angle that is no number or beyond a turn.
    """
    hold_numbers(walk, "duration_s", *angles)
    if not 0.0 < walk.duration_s < np.inf:
        raise ValueError(f"duration_s must be positive, got {walk.duration_s}")
    check_angles(**{name: getattr(walk, name) for name in angles})


def times_of(time_s: ArrayLike) -> Floats:
    """(N,) times, s, of one or N of them.

    Raises:
        ValueError: what is not finite numbers, or has more axes.
    """
    time = np.atleast_1d(as_finite("time_s", time_s))
    if time.ndim != 1:
        raise ValueError(f"time_s must have shape () or (N,), got {time.shape}")
    return time
