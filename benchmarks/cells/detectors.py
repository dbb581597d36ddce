"""Detectors by name: obstaclewatch's own, or any class by its dotted path, with changed constants in brackets.

    PaperDetector
    PaperDetector(walker_half_width_m=0.35, votes_needed=3)
    PaperDetector(reading='calibrated')
    mine.detectors:CautiousDetector(reach_m=2.5)

A constant in brackets goes to `PaperSettings` or `Errata` where these know its name, else to the class itself. A
`reading` is a named group of settings, on top of which the others come.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import inspect
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import obstaclewatch
from benchmarks.cells.spec import check_known, did_you_mean
from obstaclewatch import BeepDesign, Errata, PaperSettings, PhoneGeometry
from obstaclewatch.paper.settings import READINGS

_NAME = re.compile(r"^(?:(?P<module>[A-Za-z_][\w.]*):)?(?P<cls>[A-Za-z_]\w*)(?:\((?P<arguments>.*)\))?$", re.DOTALL)
SETTINGS = frozenset(field.name for field in fields(PaperSettings)) - {"errata"}
ERRATA = frozenset(field.name for field in fields(Errata))


@dataclass(frozen=True)
class DetectorName:
    """A detector as a suite names it.

    Attributes:
        text: the whole of it.
        module: where the class is; empty for obstaclewatch.
        cls: name of the class.
        arguments: the constants in brackets.
    """

    text: str
    module: str
    cls: str
    arguments: dict[str, Any]

    @property
    def label(self) -> str:
        """How figures and results call it: without the module."""
        return self.text.removeprefix(f"{self.module}:")


def parse_detector(text: str) -> DetectorName:
    """Take a detector's name apart.

    Raises:
        ValueError: it is not a class name, package.module:Class, or either with constants in brackets.
    """
    match = _NAME.match(text.strip())
    if match is None:
        raise ValueError(f"a detector must read Class, package.module:Class or Class(constant=value), got '{text}'")
    arguments = _arguments(match["arguments"] or "", text)
    return DetectorName(text.strip(), match["module"] or "", match["cls"], arguments)


def own_detectors() -> list[str]:
    """Names of the project's detectors.

    >>> own_detectors()[0]
    'DistanceOnlyDetector'
    """
    return sorted(name for name in obstaclewatch.__all__ if name.endswith("Detector") and name != "Detector")


def detector_label(text: str) -> str:
    """How figures and results call a detector: without the module."""
    return parse_detector(text).label


def detector_class(name: DetectorName) -> type:
    """The class, imported if need be; the working directory counts as a place of modules.

    Raises:
        ValueError: there is no such module or class, or it cannot stream recordings.
    """
    if not name.module:
        found = getattr(obstaclewatch, name.cls, None) if name.cls.endswith("Detector") else None
    else:
        found = getattr(_imported(name.module), name.cls, None)
    if not inspect.isclass(found):
        where = name.module or "obstaclewatch"
        near = did_you_mean(name.cls, own_detectors()) if not name.module else ""
        raise ValueError(f"detectors must be classes of obstaclewatch or package.module:Class, "
                         f"got '{name.text}': {where} has no class '{name.cls}'{near}")  # fmt: skip
    if not callable(getattr(found, "stream", None)):
        raise ValueError(f"a detector must have a method stream(recording), which '{name.text}' has not")
    return found


def source_digest(name: DetectorName) -> str:
    """SHA-256 of the file that defines a detector, hexadecimal."""
    return hashlib.sha256(Path(inspect.getfile(detector_class(name))).read_bytes()).hexdigest()


STANDING = {
    "PaperDetector": "PaperStandingDetector",
    "DistanceOnlyDetector": "PaperStandingDetector",
    "TrackingDetector": "StandingDetector",
}
"""What measures for obstaclewatch's detectors while the phone is held still, under the same label."""


def standing_form(text: str) -> str:
    """The detector that measures for a named one while the phone is held still; what is not ours does so itself."""
    name = parse_detector(text)
    own = STANDING.get(name.cls, name.cls)
    return text if name.module else own + name.text.removeprefix(name.cls)


def build_detector(
    text: str,
    beep: BeepDesign,
    phone: PhoneGeometry,
    settings: PaperSettings,
    pitch_rad: float | None,
    known: Mapping[str, float] = MappingProxyType({}),
) -> Any:
    """The detector that a suite names, with the constants in brackets on top of the given settings.

    What is `known` besides, such as sound_speed_m_s, goes to those that take an argument of that name.

    Raises:
        ValueError: an unknown class or constant, or a value out of range.
    """
    wanted, settings, own = _taken_apart(text, settings)
    own = {name: value for name, value in known.items() if _takes(wanted, name)} | own
    try:
        return wanted(beep, phone, settings=settings, pitch_rad=pitch_rad, **own)
    except (TypeError, ValueError) as error:
        raise ValueError(f"detector '{text}' cannot be made: {error}") from error


def check_detector(text: str, settings: PaperSettings) -> None:
    """Whether `build_detector` could make it, without making it.

    Raises:
        ValueError: an unknown class or constant, or a value out of range of the settings.
    """
    wanted, settings, own = _taken_apart(text, settings)
    try:
        inspect.signature(wanted).bind(None, None, settings=settings, pitch_rad=None, **own)
    except TypeError as error:
        raise ValueError(f"detector '{text}' cannot be made: {error}") from error


def _taken_apart(text: str, settings: PaperSettings) -> tuple[type, Any, dict[str, Any]]:
    """The class, the settings with its constants in brackets, and those constants that are its own.

    A class with a `settings_type` of its own gets those of the suite's settings that it knows.
    """
    name = parse_detector(text)
    reading = name.arguments.get("reading", "")
    if reading not in ("", *READINGS):
        raise ValueError(f"reading must be one of {sorted(READINGS)}, got {reading!r} for detector '{text}'")
    settings = replace(settings, **READINGS.get(reading, {}))
    own = {key: value for key, value in name.arguments.items() if key not in SETTINGS | ERRATA | {"reading"}}
    errata = {key: value for key, value in name.arguments.items() if key in ERRATA}
    changed = {key: _tuple(value) for key, value in name.arguments.items() if key in SETTINGS}
    wanted, settings = detector_class(name), replace(settings, errata=replace(settings.errata, **errata), **changed)
    taken = getattr(wanted, "settings_type", PaperSettings)
    if taken is PaperSettings:
        return wanted, settings, own
    known = [each.name for each in fields(taken)]
    unknown = sorted(name.arguments.keys() - own.keys() - set(known))
    if unknown:
        raise ValueError(f"detector '{text}' has no use for {unknown[0]}, only for {', '.join(known)}")
    return wanted, taken(**{each: getattr(settings, each) for each in known}), own


def _takes(wanted: type, argument: str) -> bool:
    """Whether a class can be made with an argument of that name."""
    parameters = inspect.signature(wanted).parameters
    return argument in parameters or any(p.kind is p.VAR_KEYWORD for p in parameters.values())


def paper_settings(values: dict[str, Any]) -> PaperSettings:
    """Settings from plain values; `errata` is a mapping of switches.

    Raises:
        ValueError: an unknown name or a value out of range.
    """
    switches = values.get("errata", {})
    if not isinstance(switches, dict):
        raise ValueError(f"errata must be switches by name, such as {{rim_angle: false}}, got {switches!r}")
    check_known("settings", values, SETTINGS | {"errata"})
    check_known("errata", switches, ERRATA)
    plain = {key: _tuple(value) for key, value in values.items() if key != "errata"}
    return PaperSettings(**plain, errata=Errata(**switches))


def _arguments(text: str, whole: str) -> dict[str, Any]:
    try:
        call = ast.parse(f"f({text})", mode="eval").body
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)) or call.args:
            raise ValueError("constants must be named, in one pair of brackets")
        found = {keyword.arg: ast.literal_eval(keyword.value) for keyword in call.keywords if keyword.arg is not None}
        if len(found) < len(call.keywords):
            raise ValueError("each constant must have a name of its own")
        return found
    except (SyntaxError, TypeError, ValueError) as error:  # TypeError: of a list as a key
        raise ValueError(f"the brackets of detector '{whole}' must hold constant=value, ...: {error}") from error


def _imported(module: str) -> Any:
    here = str(Path.cwd())
    missing = here not in sys.path
    if missing:
        sys.path.append(here)
    try:
        return importlib.import_module(module)
    except (Exception, SystemExit) as error:  # a user's module may do anything
        raise ValueError(f"detector module '{module}' cannot be imported: {type(error).__name__}: {error}") from error
    finally:
        if missing:
            sys.path.remove(here)


def _tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
