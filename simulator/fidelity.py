"""How much of the physics a run models, and at which numerical resolution."""

from __future__ import annotations

from dataclasses import dataclass

MECHANISMS = ("specular", "curved", "edges")


@dataclass(frozen=True)
class Fidelity:
    """What is traced, and how finely.

    Attributes:
        max_order: greatest number of reflections of a path; 0 leaves the direct sound alone.
        max_range_m: paths longer than twice this are not looked for (the paper's 7 m listening range).
        mechanisms: any of "specular" (planar image sources), "curved" (stationary points of smooth surfaces) and
            "edges" (first-order diffraction at sharp edges).
        edge_floor_db: contributions of edges that stay below this, dB re the free field 1 m in front of the speaker,
            and 50 dB below the strongest echo are left out. -60 is 15 dB under the noise of a quiet street after
            the matched filter, for a beep of 55 dB at 1 m. -inf keeps all.
        motion_degree: degree in time of delay and amplitude within one beep; 0 freezes the world for each beep.
        band_points: frequencies at which gains are evaluated between 15 and 25 kHz.

    Raises:
        ValueError: a number out of range or an unknown mechanism.
    """

    max_order: int = 2
    max_range_m: float = 7.0
    mechanisms: tuple[str, ...] = MECHANISMS
    motion_degree: int = 3
    band_points: int = 6
    edge_floor_db: float = -60.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mechanisms", tuple(self.mechanisms))
        unknown = sorted(set(self.mechanisms) - set(MECHANISMS))
        if unknown:
            raise ValueError(f"mechanisms must be among {MECHANISMS}, got {unknown}")
        if not (isinstance(self.max_order, int) and 0 <= self.max_order <= 8):
            raise ValueError(f"max_order must be a whole number from 0 to 8, got {self.max_order}")
        if not 0.0 < self.max_range_m < float("inf"):
            raise ValueError(f"max_range_m must be positive and finite, got {self.max_range_m}")
        if not (isinstance(self.motion_degree, int) and 0 <= self.motion_degree <= 8):
            raise ValueError(f"motion_degree must be a whole number from 0 to 8, got {self.motion_degree}")
        if not self.edge_floor_db <= 0.0:
            raise ValueError(f"edge_floor_db must not be positive, got {self.edge_floor_db}")
        if not (isinstance(self.band_points, int) and 1 <= self.band_points <= 64):
            raise ValueError(f"band_points must be a whole number from 1 to 64, got {self.band_points}")
