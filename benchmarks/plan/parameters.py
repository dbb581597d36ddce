"""What sweeps call a parameter, and where cells and suites hold it."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from dataclasses import fields
from difflib import get_close_matches
from functools import cache

from benchmarks.cells.check import GIVEN
from benchmarks.cells.spec import (
    BeepSetting,
    Conditions,
    Interferer,
    Knowledge,
    PhoneChange,
    RecordingChange,
    SceneChange,
    Scoring,
    WalkChange,
)
from obstaclewatch import PaperSettings
from scenes import make_approach
from simulator import Air, Fidelity

PARTS = {
    "scene": ("approach",),
    "walk": ("walk",),
    "phone": ("phone_change",),
    "noise": ("phone_change",),
    "air": ("air",),
    "beep": ("beep",),
    "fidelity": ("fidelity",),
    "recording": ("recording",),
    "interferer": ("interferer",),
    "knowledge": ("knowledge",),
    "detector": ("settings",),
    "scoring": ("scoring",),
    "probe": ("probe",),
}
WHOLE = {
    "scene.name": "scene",
    "scene.category": "category",
    "scene.collision": "collision",
    "scene.range_m": "range_m",
    "scene.bearing_rad": "bearing_rad",
    "phone.name": "phone",
    "detector.name": "detectors",
}
"""Name -> field of a cell that holds one value."""
_RENAMED = {"noise.level_spl_db": ("phone_change", "noise_spl_db")} | {
    f"scene.{name}": ("scene_change", name) for name in SceneChange.model_fields
}
OPEN = "probe"
"""The part whose names no cell knows beforehand."""


def path_of(name: str) -> tuple[str, ...]:
    """Where a cell holds a parameter.

    >>> path_of("noise.level_spl_db"), path_of("detector.votes_needed")
    (('phone_change', 'noise_spl_db'), ('settings', 'votes_needed'))
    """
    part, *rest = name.split(".")
    return _RENAMED.get(name) or (*PARTS[part], *rest)


def check_parts(names: Iterable[str]) -> None:
    """Refuse names of another form than part.name, or of a part that cells have not.

    Raises:
        ValueError: the message gives the nearest name.
    """
    for name in names:
        part, _, rest = name.partition(".")
        if part not in PARTS or not rest:
            rule = f"a swept parameter must read part.name with part one of {sorted(PARTS)}"
            raise ValueError(f"{rule}, got '{name}'{_near(name)}")


def check_name(name: str) -> None:
    """Refuse a name that no cell has within its part; what lies deeper, as detector.errata.rim_angle, passes.

    Raises:
        ValueError: the message gives the names of the part, and the nearest.
    """
    part, _, rest = name.partition(".")
    if part != OPEN and "." not in rest and name not in _known():
        own = sorted(known for known in _known() if known.startswith(f"{part}."))
        raise ValueError(f"a swept parameter must be among {own}, got '{name}'{_near(name)}")


def suite_hint(key: str) -> str:
    """Which setting of a suite is meant by a key that it has not, as sweeps call it; empty where none is near.

    >>> suite_hint("noise.level_spl_db"), suite_hint("detector.votes_neded"), suite_hint("colour")
    (", did you mean 'phone_change.noise_spl_db'?", ", did you mean 'settings.votes_needed'?", '')
    """
    held = {name: path for name, path in _known().items() if path[0] in Conditions.model_fields}
    close = get_close_matches(key, held, n=1)
    return f", did you mean '{'.'.join(held[close[0]])}'?" if close and "." in key else ""


def _near(name: str) -> str:
    """The name that sweeps have for a place in a cell, or the nearest name."""
    named = {".".join(path): each for each, path in _known().items()}
    close = [named[name]] if name in named else get_close_matches(name, [*_known(), *named], n=1)
    return f", did you mean '{named.get(close[0], close[0])}'?" if close else ""


@cache
def _known() -> dict[str, tuple[str, ...]]:
    """Name -> where a cell holds it."""
    held: dict[str, Iterable[str]] = {
        "scene": [name for name in inspect.signature(make_approach).parameters if name not in GIVEN],
        "walk": WalkChange.model_fields,
        "phone": PhoneChange.model_fields,
        "air": [field.name for field in fields(Air)],
        "beep": BeepSetting.model_fields,
        "fidelity": [field.name for field in fields(Fidelity)],
        "recording": RecordingChange.model_fields,
        "interferer": Interferer.model_fields,
        "knowledge": Knowledge.model_fields,
        "detector": [field.name for field in fields(PaperSettings)],
        "scoring": Scoring.model_fields,
    }
    plain: dict[str, tuple[str, ...]] = {
        f"{part}.{name}": (*PARTS[part], name) for part, names in held.items() for name in names
    }
    return plain | {name: (field,) for name, field in WHOLE.items()} | _RENAMED
