"""What the masks turn away while paths are traced: counted in every run, kept path by path where a run asks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from obstaclewatch.support.arrays import Floats, Ints
from simulator.world.candidates import Candidates


@dataclass(frozen=True)
class Turned:
    """R candidates that one mask turned away.

    Attributes:
        amplitude: (R,) estimated gain.
        candidates: the geometry of chosen ones of the R, worked out for these alone.
    """

    amplitude: Floats
    candidates: Callable[[Ints], Candidates]


@dataclass(frozen=True)
class Choice:
    """What an obstacle's ways were left to.

    Attributes:
        obstacle: its name.
        ways, integrals: how many ways there are over it, and how many Kirchhoff's integral took.
        rays_db, left_db: estimated error of its echo had all been left to rays, and as it is: of the worst pose and
            microphone. Infinite where the rim is louder than any ray.
    """

    obstacle: str
    ways: int
    integrals: int
    rays_db: float
    left_db: float

    def __str__(self) -> str:
        taken = f"{self.obstacle}: integral over {self.integrals} of {self.ways} ways"
        return f"{taken}; estimated error of rays {self.rays_db:.2f} dB, left {self.left_db:.2f} dB"


@dataclass
class Ledger:
    """Collects, in the order in which the masks are applied.

    Attributes:
        listed: strongest candidates kept of each group turned away; 0 only counts.
        counts: candidates turned away by each mask.
        entries: (mask, amplitude, candidates) of what is kept.
        choices: what was chosen for each obstacle whose rays were doubted.
    """

    listed: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    entries: list[tuple[str, Floats, Candidates]] = field(default_factory=list)
    choices: list[Choice] = field(default_factory=list)

    def turn_away(self, mask: str, count: int, describe: Callable[[], Turned]) -> None:
        """Book `count` candidates; `describe` is asked about them only if they are listed."""
        self.counts[mask] = self.counts.get(mask, 0) + int(count)
        if not (self.listed and count):
            return
        turned = describe()
        strongest = np.argsort(-turned.amplitude, kind="stable")[: self.listed]
        self.entries.append((mask, turned.amplitude[strongest], turned.candidates(strongest)))
