"""A suite: what is run, on which scenes and phones, and how it is scored. One YAML file a user can copy and change."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import AfterValidator, BaseModel, Field, ValidationError, field_validator, model_validator

from benchmarks.cells.detectors import detector_label, parse_detector
from benchmarks.cells.spec import Conditions, did_you_mean, first_error
from benchmarks.plan.figure_names import known_figures
from benchmarks.plan.parameters import suite_hint
from benchmarks.plan.sweep import MEMBERS, Sweep
from scenes.files.bounded_yaml import parsed, read_text
from scenes.files.field_types import Positive, Real, Whole, matching
from simulator.phone.presets import list_phones

FolderName = Annotated[str, matching(r"\w[\w .+-]*", "letters, digits, spaces and _ . + -, no sign or space first")]
"""A run's folder is called so: no path, and nothing that begins with a dot."""
Count = Annotated[Whole, Field(ge=0, le=10**9)]


def _preset(name: str) -> str:
    known = list_phones()
    if name not in known:
        raise ValueError(f"must be one of the phones {', '.join(known)}, got '{name}'{did_you_mean(name, known)}")
    return name


Preset = Annotated[str, AfterValidator(_preset)]
Fraction = Annotated[Real, Field(ge=0.0, le=1.0)]


class _ShellLoader(yaml.SafeLoader):
    """For values as shells, Python and JSON write them: YAML 1.1 reads 1e-5 as a text, 1.0e-5 as a number."""


_ShellLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"(?:[-+]?(?:\d+\.?\d*|\.\d+)[eE][-+]?\d+|NaN|-?Infinity)\Z"),
    None,  # whatever it begins with
)


class Group(BaseModel, extra="forbid", frozen=True):
    """Walks towards obstacles of one scene: how many for each category, with which phones in turn."""

    scene: str
    phones: Annotated[tuple[Preset, ...], Field(min_length=1)]
    counts: dict[str, Count]
    approach: dict[str, Any] = {}


class OwnScene(BaseModel, extra="forbid", frozen=True):
    """Walks through a scene file: how many, each with its own seed, and with which phones in turn.

    Attributes:
        file: a YAML file; a path relative to where the run starts.
        count: walks; they differ in their noise, and in what the walk of the file leaves open (`vary`).
        phones: presets; none takes the phone of the file.
    """

    file: str
    count: Count
    phones: tuple[Preset, ...] = ()


class Standing(BaseModel, extra="forbid", frozen=True):
    """Standing measurements: how many for each category, distance and bearing, and how near a candidate must be.

    Static peaks are kept there: a standing walker has no others.
    """

    phones: Annotated[tuple[Preset, ...], Field(min_length=1)]
    counts: dict[str, Count]
    range_m: tuple[Positive, ...] = (1.5, 3.0, 5.0)
    bearing_rad: Annotated[tuple[Annotated[Real, Field(gt=-1.6, lt=1.6)], ...], Field(min_length=1)] = (0.0,)
    detectors: tuple[str, ...] = ("PaperDetector",)
    gate_m: Positive = 0.2


class Probe(BaseModel, extra="forbid", frozen=True):
    """Cells that are neither walks nor standing measurements.

    Attributes:
        kind: "signal" stores what a figure shows, "numerics" judges one extreme, "fidelity"
            the errors and costs of levels of fidelity, "tessellation" of a body's segments, "motion" of following
            motion within a beep, "speed" what things cost.
        name: which signal or check; see `docs/suites.md`.
        phones: one cell for each.
        parameters: plain values that the probe understands.
        over: lists of values by parameter; every combination is a cell.
    """

    kind: Literal["signal", "numerics", "fidelity", "tessellation", "motion", "speed"]
    name: str
    phones: Annotated[tuple[Preset, ...], Field(min_length=1)] = ("ideal",)
    parameters: dict[str, Any] = {}
    over: dict[str, tuple[Any, ...]] = {}


class Tier(BaseModel, extra="forbid", frozen=True):
    """A stratified subset: this share of each stratum's walks, but not fewer than `at_least` where it has as many."""

    fraction: Fraction
    at_least: Count = 0

    def size(self, count: int) -> int:
        """Walks kept of a stratum of `count`."""
        return min(count, max(self.at_least, round(self.fraction * count)))


class Suite(Conditions, frozen=True):
    """A suite: what is planned, and the conditions that all of its cells share.

    Attributes:
        seed, split: which walks are drawn; what a detector is tuned on ("dev") is never what is reported ("test").
        recipe: which walks are drawn, one of `scenes.streets.approaches.RECIPES`: "paper" is the paper's field test,
            "mixed" the street as it is.
        collision_fraction: share of the walks that are on a collision course.
        groups, scenes, standing, probes: what is planned.
        sweep: the points at which all of it is planned.
        unknowns: "drawn" plans every walk of `groups` once more with what nobody has measured drawn from its
            uncertainty, see `benchmarks.plan.unknowns`, so that rates stand beside those of the assumed values.
        tiers: how much of it.
        detectors: classes of obstaclewatch or `package.module:Class`, with constants in brackets if wanted.
        figures: names of the figures that a run draws; none draws all that have data.
    """

    name: FolderName
    title: str
    reproduces: str = ""
    seed: Annotated[Whole, Field(ge=0)]
    split: Literal["dev", "test"] = "test"
    recipe: Literal["paper", "mixed"] = "mixed"
    collision_fraction: Fraction = 0.5
    groups: tuple[Group, ...] = ()
    scenes: tuple[OwnScene, ...] = ()
    standing: Standing | None = None
    probes: tuple[Probe, ...] = ()
    sweep: Sweep | None = None
    unknowns: Literal["assumed", "drawn"] = "assumed"
    tiers: dict[FolderName, Tier]
    detectors: Annotated[tuple[str, ...], Field(min_length=1)]
    figures: Annotated[tuple[str, ...], AfterValidator(known_figures)] = ()

    @field_validator("detectors")
    @classmethod
    def _told_apart(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        parsed = [parse_detector(name) for name in names]
        unknown = [name.text for name in parsed if not name.module and not name.cls.endswith("Detector")]
        if unknown:
            raise ValueError(
                f"detectors must be class names of obstaclewatch that end in 'Detector', or package.module:Class, "
                f"got {unknown}"
            )
        labels = [detector_label(name) for name in names]
        if len(set(labels)) < len(labels):
            raise ValueError(f"detectors must have different names, module apart, got {labels}")
        return names

    @model_validator(mode="after")
    def _something_to_do(self) -> Suite:
        if not (self.groups or self.scenes or self.standing or self.probes):
            raise ValueError("a suite must have groups, scenes, standing measurements or probes")
        if self.unknowns == "drawn" and self.sweep is not None:
            raise ValueError("unknowns must be 'assumed' in a suite with a sweep, got 'drawn'")
        return self

    def tier(self, name: str) -> Tier:
        """The tier of that name.

        Raises:
            ValueError: there is none; the message lists those there are.
        """
        if name not in self.tiers:
            raise ValueError(f"tier must be one of {sorted(self.tiers)}, got {name!r}")
        return self.tiers[name]


def list_suites() -> list[str]:
    """Names of the suites that come with the package."""
    folder = resources.files("benchmarks") / "suites"
    return sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml"))


def is_own(name_or_path: str) -> bool:
    """Whether that names a suite of the package, and not a file."""
    return not name_or_path.endswith((".yaml", ".yml"))


def load_suite(name_or_path: str, settings: Sequence[str] = (), seed: int | None = None) -> Suite:
    """A suite by name, or from a YAML file, with `--set`-like settings applied.

    Args:
        name_or_path: one of `list_suites()`, or a path that ends in .yaml or .yml.
        settings: "dotted.key=value" each; the value is read as YAML, 1e-5 without quotes as a number.
        seed: replaces the suite's seed.

    Raises:
        ValueError: an unknown name, a missing file, text that is not YAML, or a value that breaks the schema.
    """
    data = _read(name_or_path)
    for setting in settings:
        _apply(data, setting)
    if seed is not None:
        data["seed"] = seed
    try:
        return Suite.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"suite '{name_or_path}': {first_error(error, Suite, MEMBERS)}") from error


def _read(name_or_path: str) -> dict[str, Any]:
    if not is_own(name_or_path):
        path = Path(name_or_path)
        if not path.is_file():
            raise ValueError(f"suite file must exist, got '{name_or_path}'")
        text = read_text(path, "suite")
    elif name_or_path in list_suites():
        text = (resources.files("benchmarks") / "suites" / f"{name_or_path}.yaml").read_text(encoding="utf-8")
    else:
        names = list_suites()
        near = did_you_mean(name_or_path, names)
        raise ValueError(f"suite must be one of {names} or a .yaml file, got '{name_or_path}'{near}")
    return _mapping(text, name_or_path)


def _mapping(text: str, source: str) -> dict[str, Any]:
    data = parsed(text, source, "suite")[0]
    if not isinstance(data, dict):
        found = "nothing" if data is None else type(data).__name__
        raise ValueError(f"suite '{source}' must be a YAML mapping, got {found}")
    return data


def _apply(data: dict[str, Any], setting: str) -> None:
    key, found, value = setting.partition("=")
    if not found or not key:
        raise ValueError(f"a setting must read dotted.key=value, got '{setting}'")
    *parents, last = key.split(".")
    if parents and parents[0] not in Suite.model_fields and (near := suite_hint(key)):
        raise ValueError(f"setting '{key}' must begin with a field of a suite{near}")
    node: Any = data
    for parent in parents:
        node = node.setdefault(parent, {})
        if not isinstance(node, dict):
            raise ValueError(f"setting '{key}' must name a value inside mappings, but '{parent}' is not a mapping")
    node[last] = parsed(value, f"setting '{setting}'", "value", _ShellLoader)[0]
