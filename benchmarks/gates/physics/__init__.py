"""The physics that any installation can check in seconds against exact solutions, without stored references."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from benchmarks.gates.physics.absorption import air_error_db_m
from benchmarks.gates.physics.bounds import path_difference_over_bound, range_over_bound
from benchmarks.gates.physics.extremes import GROUPS, extremes_share
from benchmarks.gates.physics.invariance import reciprocity_error, translation_error
from benchmarks.gates.physics.measured import Check, Measured
from benchmarks.gates.physics.moving import motion_error, moving_bias_m
from benchmarks.gates.physics.truth import truth_error_m
from benchmarks.gates.physics.wall import wall_delay_samples, wall_level_db
from benchmarks.gates.verdict import Verdict

__all__ = ["CHECKS", "GREATEST", "Measured", "judge_physics"]

CHECKS: dict[str, Check] = {
    "wall_level": wall_level_db,
    "wall_delay": wall_delay_samples,
    "air_absorption": air_error_db_m,
    "reciprocity": reciprocity_error,
    "translation": translation_error,
    "motion": motion_error,
    "moving_range_bias": moving_bias_m,
    "range_deviation_20db": partial(range_over_bound, snr_db=20.0),
    "range_deviation_30db": partial(range_over_bound, snr_db=30.0),
    "range_deviation_40db": partial(range_over_bound, snr_db=40.0),
    "path_difference_deviation_20db": partial(path_difference_over_bound, snr_db=20.0),
    "path_difference_deviation_30db": partial(path_difference_over_bound, snr_db=30.0),
    "path_difference_deviation_40db": partial(path_difference_over_bound, snr_db=40.0),
    "truth": truth_error_m,
    **{f"extremes_{group}": partial(extremes_share, group=group) for group in GROUPS},
}

GREATEST: dict[str, float] = {
    "wall_level": 60.0,  # dB: from the wall's echo to what is no longer received
    "wall_delay": 7800.0,  # samples to 7 m and back at 192 kHz: the whole delay
    "air_absorption": 1.5,  # dB/m: of all climates at 25 kHz
    "reciprocity": 1.0,  # of the field: as wrong as silence
    "translation": 1.0,
    "motion": 1.0,
    "moving_range_bias": 0.5,  # m: estimates farther off are none of the wall's
    "range_deviation_20db": 12.0,  # bounds within 6 cm: estimates farther off are none of the point's
    "range_deviation_30db": 39.0,
    "range_deviation_40db": 120.0,
    "path_difference_deviation_20db": 10.0,
    "path_difference_deviation_30db": 34.0,
    "path_difference_deviation_40db": 100.0,
    "truth": 5.0,  # m: the whole distance to the box
    **{f"extremes_{group}": 100.0 for group in GROUPS},  # limits: of most references their whole value
}
"""Of each check, what its worst exceeds only where nothing is right, if at all: a gate must ask for less."""

GROUP = "physics"


def judge_physics(asked: Mapping[str, float], seed: int = 0) -> list[Verdict]:
    """One gate per check: its worst must not exceed the value asked for; unmeasured without a comparison.

    Raises:
        ValueError: an unknown check.
    """
    return [_judge(name, at_most, seed) for name, at_most in asked.items()]


def _judge(name: str, at_most: float, seed: int) -> Verdict:
    if name not in CHECKS:
        raise ValueError(f"a physics check must be one of {sorted(CHECKS)}, got '{name}'")
    found = CHECKS[name](seed)
    if found.n == 0 or not np.isfinite(found.value):
        return Verdict.unmeasured(GROUP, name, f"{name}: nothing came back that could be compared")
    text = f"{name}: worst {found.value:.3g} {found.unit} of {found.n}, at most {at_most:g} {found.unit}"
    return Verdict.of(GROUP, name, found.value <= at_most, text, found.n)
