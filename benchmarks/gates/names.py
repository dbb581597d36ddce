"""Names in a gates file: detectors, scenes, categories and phones as results call them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import AfterValidator

from benchmarks.cells.detectors import check_detector, own_detectors, parse_detector
from benchmarks.cells.spec import did_you_mean
from obstaclewatch import PaperSettings
from scenes import list_scenes
from scenes.obstacles import CATEGORIES
from simulator.phone.presets import list_phones

if TYPE_CHECKING:
    from benchmarks.gates.config import Gates

STANDING = "standing"
"""The scene of standing measurements."""


def _label(text: str) -> str:
    """The name as it is; none stands for the detector of the file.

    Raises:
        ValueError: no name of a detector, one with its module, or constants that a detector of the project has not.
    """
    if not text:
        return text
    name = parse_detector(text)
    if name.module:
        raise ValueError(f"must be without its module, as results call it: '{name.label}', got '{text}'")
    if name.cls in own_detectors():
        check_detector(text, PaperSettings())
    return text


Detector = Annotated[str, AfterValidator(_label)]


def foreign_names(gates: Gates) -> list[str]:
    """What is named and is not of this project, a line each: a run may have it all the same, of its own.

    >>> from benchmarks.gates.config import Gates
    >>> gates = Gates(title="mine", claims=[{"detector": "TrakingDetector", "rate": "TP", "at_least": 0.9}])
    >>> print(*foreign_names(gates))
    detector 'TrakingDetector' is none of this project, did you mean 'TrackingDetector'?
    """
    known = {
        "detector": own_detectors(),
        "scene": [*list_scenes(), STANDING],
        "category": sorted(CATEGORIES),
        "phone": list_phones(),
    }
    named = [("detector", gates.claimed), *(("detector", asked.detector) for asked in gates.regression)]
    named += [(kind, getattr(claim, kind, None) or "") for claim in gates.claims for kind in known]
    strange = dict.fromkeys((kind, text) for kind, text in named if text and _bare(kind, text) not in known[kind])
    return [f"{kind} '{text}' is none of this project{did_you_mean(text, known[kind])}" for kind, text in strange]


def _bare(kind: str, text: str) -> str:
    """A detector without its constants."""
    return parse_detector(text).cls if kind == "detector" else text
