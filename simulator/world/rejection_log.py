"""Why paths are rejected while they are traced: counted in every run, kept path by path where a run asks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.world.candidates import Candidates


class Reason(StrEnum):
    """Why a path is rejected, in the words that `Paths.rejected` and `Rejections.mask` give."""

    BEHIND_PATCH = "behind a patch"
    OUTSIDE_PATCH = "outside its patch"
    NO_MIRROR_POINT = "no mirror point on its curve"
    TOO_LONG = "too long"
    HIDDEN = "hidden"
    BEHIND_SHEET = "behind a sheet on its own"
    TWIN = "twin on a shared border"
    AT_FOCUS = "at a focus"
    UNDER_NOISE = "under the noise"
    FAINT_EDGE = "faint edge"
    FAINT_CHAIN = "faint chain of edges"
    FAINT_DOUBLE = "faint double bounce"
    FAINT_CELL = "faint cell"
    DROWNED_BY_MIRROR = "drowned by a mirror image"
    DROWNED_BY_FEWER_EDGES = "drowned by fewer edges"
    LARGE_PANEL = "edges of a panel too large"
    LEFT_TO_INTEGRAL = "left to Kirchhoff's integral"


@dataclass(frozen=True)
class Rejected:
    """R candidates rejected for one reason.

    Attributes:
        amplitude: (R,) estimated gain.
        candidates: the geometry of chosen ones of the R, worked out for these alone.
    """

    amplitude: Floats
    candidates: Callable[[Ints], Candidates]


@dataclass(frozen=True)
class Choice:
    """What the paths over an obstacle were left to.

    Attributes:
        obstacle: its name.
        pairs, integrals: how many pairs of images there are over it, and how many Kirchhoff's integral took.
        rays_db, left_db: estimated error of its echo had all been left to rays, and as it is: of the worst pose and
            microphone. Infinite where the rim is louder than any ray.
    """

    obstacle: str
    pairs: int
    integrals: int
    rays_db: float
    left_db: float

    def __str__(self) -> str:
        of = f"{self.integrals} of {self.pairs} pairs of speaker and microphone, their images counted"
        taken = f"{self.obstacle}: Kirchhoff's integral in place of rays for {of}"
        rays = f"would err by {self.rays_db:.2f} dB" if np.isfinite(self.rays_db) else "say nothing of its echo"
        return f"{taken}; rays alone {rays}, an error of {self.left_db:.2f} dB is left"


@dataclass(frozen=True)
class RejectionLog:
    """Collects what is rejected, in the order in which the masks are applied.

    Attributes:
        listed: strongest candidates kept of each group rejected; 0 only counts.
        counts: candidates rejected for each reason.
        entries: (reason, amplitude, candidates) of what is kept.
        choices: what was chosen for each obstacle whose rays were doubted.
    """

    listed: int = 0
    counts: dict[Reason, int] = field(default_factory=dict)
    entries: list[tuple[Reason, Floats, Candidates]] = field(default_factory=list)
    choices: list[Choice] = field(default_factory=list)

    @property
    def totals(self) -> dict[str, int]:
        """How many were rejected for each reason, by its words."""
        return {reason.value: count for reason, count in self.counts.items()}

    def reject(self, reason: Reason, count: int, describe: Callable[[], Rejected]) -> None:
        """Book `count` candidates; `describe` is asked about them only if they are listed."""
        self.counts[reason] = self.counts.get(reason, 0) + int(count)
        if not (self.listed and count):
            return
        rejected = describe()
        strongest = np.argsort(-rejected.amplitude, kind="stable")[: self.listed]
        self.entries.append((reason, rejected.amplitude[strongest], rejected.candidates(strongest)))
