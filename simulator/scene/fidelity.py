"""How much of the physics a run models, and at which numerical resolution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from types import MappingProxyType
from typing import Any

import numpy as np

from obstaclewatch.support.argument_types import check_types, hold_numbers

MECHANISMS = ("specular", "curved", "edges", "kirchhoff")

LEVELS: Mapping[str, Mapping[str, Any]] = MappingProxyType({
    "standard": {
        "max_order": 3, "mirror_m2": 0.01, "mechanisms": MECHANISMS, "motion_degree": 3,
        "band_points": 10, "tolerance_db": 1.0, "facet_m": 0.08,
    },
    "reference": {
        "max_order": 3, "mechanisms": MECHANISMS, "motion_degree": 4, "band_points": 12, "edge_floor_db": -80.0,
        "edge_share_db": -60.0, "edge_order": 5, "facet_m": 0.012,
        "tolerance_db": 0.05,
    },
    "auto": {"mechanisms": MECHANISMS, "tolerance_db": 0.5},
})  # fmt: skip


FINE_DB, COARSE_DB = 0.3, 1.0  # tolerances below which settings are as fine as they get, and from which coarse ones do
BELOW_STRONGEST_DB = 40.0  # how far an obstacle's echo lies under the strongest, the ground's: it is to be kept as well

_FROM_LEVEL: Any = None


@dataclass(frozen=True)
class Fidelity:
    """What is traced, and how finely. Whatever is not given follows from the level.

    Attributes:
        level: "standard" (third order, coarse facets; the estimated error of rays may be 1 dB, and with everything else
            echoes are to be within 2 dB), "reference" (all mechanisms, third order off mirrors of any size) or
            "auto" (the cheapest that keeps every obstacle's echo within `tolerance_db` of the reference).
        tolerance_db: greatest estimated error of an obstacle's echo. Where rays would err by more, Kirchhoff's
            integral is taken if it is among the mechanisms; infinity takes it for uneven bodies alone.
        max_order: greatest number of reflections of a path; 0 leaves the direct sound alone. From 3 on, paths along a
            thin panel may meet more edges, up to `edge_order`. Given, it takes mirrors of any size: `mirror_m2` is then
            0 at every level, unless it is given too.
        mirror_m2: least area of the mirrors in paths of three reflections and more, and of a face of the edge in such
            paths. A Fresnel zone has 0.05 m2 at 1.5 m, 0.18 m2 at 7 m. Above 0.1 m2, echoes between the small faces of
            a wall with bays are lost, above 0.03 m2 those of some bins, above 0.01 m2 those of a dumpster's sleeves.
            On the way to a smooth surface or an edge, mirrors of other obstacles must have ten times as much.
        max_range_m: echoes longer than twice this are not looked for (the paper's range of 7 m).
        mechanisms: any of "specular" (planar image sources), "curved" (stationary points of smooth surfaces), "edges"
            (diffraction at sharp edges) and "kirchhoff" (integrals over surfaces that are neither).
        motion_degree: degree in time of delay and amplitude within one beep; 0 freezes the world for each beep.
        band_points: frequencies at which gains are evaluated between 15 and 25 kHz. The more, the wider the cells of
            Kirchhoff's integral may be, and the fewer.
        edge_floor_db: contributions of edges and cells of bodies that stay below this, dB re the free field 1 m in
            front of the speaker, and `edge_share_db` below the strongest echo are left out. -60 is 15 dB under the
            noise of a quiet street after the matched filter, for a beep of 55 dB at 1 m, but several of them move an
            echo at the noise by 2.5 dB; with -75 by 0.1 dB. -inf keeps all. Two curved
            reflections in one path must exceed it and be within 40 dB of the strongest.
        edge_share_db: see `edge_floor_db`.
        edge_order: greatest number of edges that a path meets along the face of a thin panel, 1 to 5. With a
            `max_order` of less than 3 it is that at most. First order is right to 0.1 dB until a panel is yawed by 10
            degrees, to 1 dB by 45, and 5 dB off at 75; three orders until 10 degrees before edge-on.
        facet_m: longest edge of the facets of Kirchhoff's integral where the surface is flat; facets are smaller where
            it bends, on thin plates, and at tolerances of 0.3 to 1 dB where a shadow ends. So with 4 cm 95 %
            of 82 echoes of 14 cars were within 0.4 dB of those with 12 mm.

    Raises:
        ValueError: what is not a number or out of its range, an unknown level or mechanism.

    Example:
        >>> from simulator import Fidelity
        >>> Fidelity(level="auto", tolerance_db=2.0).mechanisms
        ('specular', 'curved', 'edges', 'kirchhoff')
        >>> Fidelity(max_order=1, mechanisms=["specular"]).max_order  # explicit arguments override the level
        1
    """

    level: str = "standard"
    tolerance_db: float = _FROM_LEVEL
    max_order: int = _FROM_LEVEL
    mirror_m2: float = _FROM_LEVEL
    max_range_m: float = 7.0
    mechanisms: tuple[str, ...] = _FROM_LEVEL
    motion_degree: int = _FROM_LEVEL
    band_points: int = _FROM_LEVEL
    edge_floor_db: float = _FROM_LEVEL
    edge_share_db: float = _FROM_LEVEL
    edge_order: int = _FROM_LEVEL
    facet_m: float = _FROM_LEVEL

    def __post_init__(self) -> None:
        check_types(level=(self.level, str))
        if self.level not in LEVELS:
            raise ValueError(f"level must be one of {tuple(LEVELS)}, got {self.level!r}")
        if self.tolerance_db is not None:
            hold_numbers(self, "tolerance_db")
        if self.tolerance_db is not None and not self.tolerance_db > 0.0:
            raise ValueError(f"tolerance_db must be positive, got {self.tolerance_db}")
        implied = _settings(self.level, self.tolerance_db)
        if self.max_order is not None:
            implied |= {"mirror_m2": 0.0}  # whatever has so many reflections
        for name, value in implied.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        if isinstance(self.mechanisms, (str, Mapping)) or not np.iterable(self.mechanisms):
            raise ValueError(f"mechanisms must be several of {MECHANISMS}, got {self.mechanisms!r}")
        hold_numbers(self, "max_range_m", "facet_m", "mirror_m2", "edge_floor_db", "edge_share_db")
        object.__setattr__(self, "mechanisms", tuple(self.mechanisms))
        unknown = [each for each in self.mechanisms if each not in MECHANISMS]
        if unknown:
            raise ValueError(f"mechanisms must be among {MECHANISMS}, got {unknown}")
        whole = {"max_order": (0, 8), "motion_degree": (0, 8), "band_points": (1, 64), "edge_order": (1, 5)}
        for name, (low, high) in whole.items():
            object.__setattr__(self, name, _whole(name, getattr(self, name), low, high))
        if not 0.0 < self.max_range_m < np.inf:
            raise ValueError(f"max_range_m must be positive and finite, got {self.max_range_m}")
        if not 0.001 <= self.facet_m <= 0.1:
            raise ValueError(f"facet_m must lie within 1 mm and 10 cm, got {self.facet_m}")
        if not self.mirror_m2 >= 0.0:
            raise ValueError(f"mirror_m2 must not be negative, got {self.mirror_m2}")
        for name in ("edge_floor_db", "edge_share_db"):
            if not getattr(self, name) <= 0.0:
                raise ValueError(f"{name} must not be positive, got {getattr(self, name)}")


def _settings(level: str, tolerance_db: float | None) -> dict[str, Any]:
    """Every setting that a level implies."""
    common: dict[str, Any] = {
        "edge_floor_db": -60.0,
        "edge_share_db": -50.0,
        "edge_order": 1,
        "mirror_m2": 0.0,
    }
    chosen = common | dict(LEVELS[level])
    if level == "auto":
        chosen |= _for_tolerance(chosen["tolerance_db"] if tolerance_db is None else tolerance_db)
    return chosen


def _for_tolerance(tolerance_db: float) -> dict[str, Any]:
    """The coarsest settings that keep a tolerance; the third order alone moves one echo in ten by more than 0.5 dB."""
    fine = tolerance_db < FINE_DB
    return {
        "max_order": 3,
        "motion_degree": 4 if fine else 3 if tolerance_db < COARSE_DB else 2,
        "band_points": 12 if fine else 10,
        "edge_share_db": max(20.0 * np.log10(min(tolerance_db, 1.0) / 8.7) - BELOW_STRONGEST_DB, -60.0),
        "edge_order": 3 if tolerance_db < 3.0 else 1,
        "edge_floor_db": -80.0 if fine else -75.0 if tolerance_db < COARSE_DB else -60.0,
        "mirror_m2": 0.0 if tolerance_db < COARSE_DB else 0.01,
        "facet_m": 0.012 if fine else 0.04,
    }


def _whole(name: str, value: int, low: int, high: int) -> int:
    if not (isinstance(value, Integral) and not isinstance(value, bool) and low <= value <= high):
        raise ValueError(f"{name} must be a whole number from {low} to {high}, got {value}")
    return int(value)
