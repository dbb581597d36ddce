"""Walks: a straight heading at constant mean speed, with the bob, sway and fore-aft oscillation of human gait.

The phone is held as one holds it to read or type at chest height: in portrait, its top edge forwards and pitched up by
about 30 degrees (the paper's "vertical" holding, used in all its experiments), or in landscape, its top edge to the
left ("horizontal", section 5.1). Curved and interrupted walks are in `scenes.walks.routes`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from obstaclewatch.support.argument_types import as_numbers, check_types, hold_numbers
from obstaclewatch.support.arrays import Floats
from simulator.scene.pose import Pose, held_rotation
from simulator.scene.walk_checks import hold_straight, times_of

Holding = Literal["vertical", "horizontal"]

QUARTER_TURN = Rotation.from_euler("z", 90.0, degrees=True)

WALK_RATIO_M_PER_STEPS_MIN = 0.00646
"""Step length over cadence, constant above about 1 m/s: 62 m/min at 98 steps/min (Murakami and Otaka 2017,
J. Phys. Ther. Sci. 29:722)."""
WALK_RATIO_SPREAD = 0.12
"""Relative deviation among people: 0.60 +- 0.07 cm per step a minute (Bogen et al. 2018, Gait Posture 61)."""

ORENDURFF_SPEED_M_S = np.array([0.7, 1.6])
ORENDURFF_VERTICAL_M = np.array([0.0274, 0.0483])
ORENDURFF_LATERAL_M = np.array([0.0699, 0.0385])
"""Peak-to-peak displacement of the centre of mass at the slowest and fastest speed of Orendurff et al. 2004
(J. Rehabil. Res. Dev. 41(6A):829-834); linear between them."""


def grip(heading_rad: ArrayLike, pitch_rad: ArrayLike, roll_rad: ArrayLike, holding: Holding) -> Rotation:
    """Rotation of a phone held by someone who faces the heading, phone frame -> world.

    Args:
        heading_rad: counter-clockwise from +x.
        pitch_rad: elevation of the phone's far side: the top edge in portrait, a long side in landscape.
        roll_rad: positive lowers the right-hand side, as the walker sees it.
        holding: "vertical" is portrait, top edge forwards; "horizontal" is landscape, top edge to the left.

    Raises:
        ValueError: another holding.
    """
    check_holding(holding)
    portrait = held_rotation(heading_rad, pitch_rad, roll_rad)
    return portrait if holding == "vertical" else portrait * QUARTER_TURN


def check_holding(holding: str) -> None:
    """Refuse what is neither.

    Raises:
        ValueError: another holding.
    """
    if holding not in get_args(Holding):
        raise ValueError(f"holding must be one of {get_args(Holding)}, got {holding!r}")


class Wobble(NamedTuple):
    """Departure of the phone from its mean path, (N,) each: m ahead, to the left and up, rad of pitch and roll."""

    ahead_m: Floats
    left_m: Floats
    up_m: Floats
    pitch_rad: Floats
    roll_rad: Floats


@dataclass(frozen=True)
class Gait:
    """Periodic motion of the phone around its straight mean path. All amplitudes are zero to peak and may be 0.

    Attributes:
        step_hz: steps per second.
        bob_m: up and down, at the step frequency.
        sway_m: left and right, at half of it (once per stride).
        fore_aft_m: forwards and back, at the step frequency, fastest when lowest.
        pitch_wobble_rad: of the phone's pitch, at the step frequency.
        roll_wobble_rad: of its roll, at half of it.
        phase_rad: of the step cycle at time 0.

    Raises:
        ValueError: a step frequency or amplitude that is negative or not finite.

    Example:
        >>> from scenes import Gait
        >>> gait = Gait.at_speed(1.3)
        >>> print(f"{gait.step_hz:.2f} steps a second, up and down by {100 * gait.bob_m:.1f} cm")
        1.83 steps a second, up and down by 2.1 cm
    """

    step_hz: float = 0.0
    bob_m: float = 0.0
    sway_m: float = 0.0
    fore_aft_m: float = 0.0
    pitch_wobble_rad: float = 0.0
    roll_wobble_rad: float = 0.0
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        for name in ("step_hz", "bob_m", "sway_m", "fore_aft_m", "pitch_wobble_rad", "roll_wobble_rad"):
            hold_numbers(self, name)
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        hold_numbers(self, "phase_rad")
        if not np.isfinite(self.phase_rad):
            raise ValueError(f"phase_rad must be finite, got {self.phase_rad}")

    @classmethod
    def at_speed(
        cls, speed_m_s: float, phase_rad: float = 0.0, walk_ratio_m_min: float = WALK_RATIO_M_PER_STEPS_MIN
    ) -> Gait:
        """The gait of a healthy adult at that speed; none when standing.

        The cadence follows from the walk ratio, step length over cadence, which is a person's own. Bob and sway are
        those of the centre of mass, held outside the measured 0.7-1.6 m/s: that the phone follows the trunk is an
        assumption, arms damp some of it. The fore-aft oscillation (1 cm) and the wobble of the hand (1.5 and 1 degrees)
        are assumptions of the same order.

        Args:
            speed_m_s: mean speed of the walk.
            phase_rad: of the step cycle at time 0.
            walk_ratio_m_min: metres that a step is long for each step a minute.

        Raises:
            ValueError: a speed that is negative or not finite, a walk ratio that is not positive and finite.
        """
        speed_m_s, walk_ratio_m_min = as_numbers(speed_m_s=speed_m_s, walk_ratio_m_min=walk_ratio_m_min)
        if not 0.0 <= speed_m_s < np.inf:
            raise ValueError(f"speed_m_s must be finite and not negative, got {speed_m_s}")
        if not 0.0 < walk_ratio_m_min < np.inf:
            raise ValueError(f"walk_ratio_m_min must be positive and finite, got {walk_ratio_m_min}")
        if speed_m_s == 0.0:
            return cls()
        return cls(
            step_hz=float(np.sqrt(60.0 * speed_m_s / walk_ratio_m_min)) / 60.0,
            bob_m=0.5 * float(np.interp(speed_m_s, ORENDURFF_SPEED_M_S, ORENDURFF_VERTICAL_M)),
            sway_m=0.5 * float(np.interp(speed_m_s, ORENDURFF_SPEED_M_S, ORENDURFF_LATERAL_M)),
            fore_aft_m=0.010,
            pitch_wobble_rad=np.deg2rad(1.5),
            roll_wobble_rad=np.deg2rad(1.0),
            phase_rad=phase_rad,
        )

    def wobble(self, step_rad: Floats) -> Wobble:
        """The departure at (N,) phases of the step cycle."""
        return Wobble(
            ahead_m=self.fore_aft_m * np.sin(step_rad - np.pi),
            left_m=self.sway_m * np.sin(0.5 * step_rad),
            up_m=self.bob_m * np.cos(step_rad),
            pitch_rad=self.pitch_wobble_rad * np.sin(step_rad),
            roll_rad=self.roll_wobble_rad * np.cos(0.5 * step_rad),
        )


@dataclass(frozen=True, eq=False)
class GaitWalk:
    """A straight walk with gait.

    Attributes:
        start_m: (3,) place of the phone's mean path at time 0; its height is that of the phone.
        heading_rad: direction of travel, counter-clockwise from +x; the body faces it.
        speed_m_s: mean speed, not negative; 0 stands still.
        duration_s: length of the walk.
        pitch_rad: mean elevation of the phone's far side.
        roll_rad: mean lowering of its right-hand side.
        gait: motion around the mean path; None is the published one at that speed, `Gait()` is none at all.
        holding: "vertical" or "horizontal", see `grip`.

    Raises:
        ValueError: a negative speed, a duration that is not positive, numbers that are not finite, another holding.

    Example:
        >>> import numpy as np
        >>> from scenes import GaitWalk
        >>> walk = GaitWalk([0.0, 0.0, 1.3], speed_m_s=1.3, duration_s=4.0)
        >>> height_m = walk.pose(np.linspace(0.0, 4.0, 400)).position_m[:, 2]
        >>> print(f"{height_m.min():.3f} to {height_m.max():.3f} m")
        1.279 to 1.321 m
    """

    start_m: Floats
    heading_rad: float = 0.0
    speed_m_s: float = 1.3
    duration_s: float = 4.0
    pitch_rad: float = float(np.deg2rad(30.0))
    roll_rad: float = 0.0
    gait: Gait | None = None
    holding: Holding = "vertical"

    def __post_init__(self) -> None:
        check_holding(self.holding)
        check_types(gait=(self.gait, Gait | None))
        hold_straight(self, "pitch_rad", "roll_rad")

    @cached_property
    def motion(self) -> Gait:
        """The gait in use."""
        return Gait.at_speed(self.speed_m_s) if self.gait is None else self.gait

    @property
    def walk_ratio_m_min(self) -> float | None:
        """Metres that a step is long for each step a minute; None without steps."""
        cadence_min = 60.0 * self.motion.step_hz
        return 60.0 * self.speed_m_s / cadence_min**2 if self.speed_m_s * cadence_min else None

    def mean_plan_m(self, time_s: ArrayLike) -> Floats:
        """(N,) times, s, to (N, 2) places in plan without the gait."""
        ahead = np.array([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        walked_m = self.speed_m_s * times_of(time_s)
        found: Floats = self.start_m[:2] + walked_m[:, None] * ahead
        return found

    def pose(self, time_s: ArrayLike) -> Pose:
        """(N,) times, s, to N poses; smooth in time, also before 0 and after the end."""
        time = times_of(time_s)
        gait = self.motion
        wobble = gait.wobble(2.0 * np.pi * gait.step_hz * time + gait.phase_rad)
        along, left = self.speed_m_s * time + wobble.ahead_m, wobble.left_m
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        offset = np.stack([cos * along - sin * left, sin * along + cos * left, wobble.up_m], axis=-1)
        heading = np.full(len(time), self.heading_rad)
        pitch, roll = self.pitch_rad + wobble.pitch_rad, self.roll_rad + wobble.roll_rad
        return Pose(self.start_m + offset, grip(heading, pitch, roll, self.holding), heading)
