"""A gates file: what must hold, in YAML that a user copies and changes."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Discriminator, Field, Tag, ValidationError, field_validator, model_validator

from benchmarks.cells.spec import first_error
from benchmarks.gates.names import Detector
from benchmarks.gates.quantities import check_exceedable, check_quantity, check_tolerance
from benchmarks.scoring.scores import LEFT_M
from scenes.files.bounded_yaml import parsed, read_text
from scenes.files.field_types import Number, Positive, Real

LEAST_SHARE = 0.01
"""A single right walk of five shows that much with 95 % confidence: who claims less claims hardly more than one."""
Share = Annotated[Real, Field(gt=0.0, lt=1.0)]
ClaimedShare = Annotated[Real, Field(ge=LEAST_SHARE, lt=1.0)]
Confidence = Annotated[Real, Field(ge=0.5, lt=1.0)]
"""Below a half a bound lies on the good side of what was measured."""
Points = Annotated[Real, Field(gt=0.0, lt=100.0)]
Tolerances = dict[str, Annotated[Real, Field(ge=0.0, allow_inf_nan=False)]]


class RateClaim(BaseModel, extra="forbid", frozen=True):
    """A rate whose exact one-sided lower bound must reach `at_least`. A point estimate of that value does not pass.

    Attributes:
        detector: whose; the file's `claimed` by default.
        left_m: distance that must be left to contact at an alert; 0 is before contact, the paper's rule.
        at_tnr: of TP, with the threshold at which so many other walks stay quiet; as the detector decides by default.
        recipe: the claim is about walks of that recipe: of others nothing is measured.
        scene, category, phone: only those walks; all of them by default.
        clear_cut, least_index_db: only walks that hit or miss clearly, or with a detection index of at least so much.
    """

    detector: Detector = ""
    rate: Literal["TP", "TN"]
    at_least: ClaimedShare
    left_m: Real = 0.0
    at_tnr: ClaimedShare | None = None
    recipe: Literal["paper", "mixed"] | None = None
    scene: str | None = None
    category: str | None = None
    phone: str | None = None
    clear_cut: bool = False
    least_index_db: Number | None = None
    confidence: Confidence = 0.95

    @field_validator("left_m")
    @classmethod
    def _told(cls, left_m: float) -> float:
        if left_m not in LEFT_M:
            raise ValueError(f"left_m must be one of {LEFT_M}, got {left_m}")
        return left_m

    @model_validator(mode="after")
    def _of_its_rate(self) -> RateClaim:
        asked = {name: value for name in ("left_m", "at_tnr") if (value := getattr(self, name))}
        if self.rate == "TN" and asked:
            raise ValueError(f"left_m and at_tnr must not be given for TN, both are of TP, got {asked}")
        return self


class MedianClaim(BaseModel, extra="forbid", frozen=True):
    """A quantity's median over walks whose exact one-sided upper bound must not exceed `at_most`.

    Attributes:
        detector: whose; the file's `claimed` by default.
        quantity: see `benchmarks.gates.quantities`.
        standing_range_m: only standing measurements at that distance; of kind "standing".
    """

    detector: Detector = ""
    quantity: str
    at_most: Positive
    kind: Literal["approach", "standing"] = "approach"
    scene: str | None = None
    category: str | None = None
    standing_range_m: Positive | None = None
    confidence: Confidence = 0.95

    @field_validator("quantity")
    @classmethod
    def _known(cls, name: str) -> str:
        check_quantity(name)
        return name

    @model_validator(mode="after")
    def _of_its_kind(self) -> MedianClaim:
        if self.kind == "approach" and self.standing_range_m is not None:
            raise ValueError(
                f"standing_range_m must be of kind 'standing', got {self.standing_range_m:g} of 'approach'"
            )
        return self

    @model_validator(mode="after")
    def _can_fail(self) -> MedianClaim:
        check_tolerance(self.quantity, self.at_most)
        return self


CLAIMS: dict[str, type[BaseModel]] = {"RateClaim": RateClaim, "MedianClaim": MedianClaim}


def _which(claim: Any) -> str | None:
    """Which claim is meant: without this, a mistake in one kind is reported as a field of the other."""
    if isinstance(claim, BaseModel):
        return type(claim).__name__
    if not isinstance(claim, dict):
        return None
    names = {"RateClaim": {"rate", "at_least"}, "MedianClaim": {"quantity", "at_most"}}
    return next((kind for kind, fields in names.items() if fields & claim.keys()), None)


Claim = Annotated[
    Annotated[RateClaim, Tag("RateClaim")] | Annotated[MedianClaim, Tag("MedianClaim")],
    Discriminator(
        _which, custom_error_type="no_claim", custom_error_message="must be a mapping with a rate or a quantity"
    ),
]


class Regression(BaseModel, extra="forbid", frozen=True):
    """One detector against the baseline on the same walks.

    Attributes:
        detector: in the run.
        against: its name in the baseline; the same by default.
        rates: which rates must not fall.
        approach, standing: quantity -> how far its paired summary may shift for certain before it is a loss.
    """

    detector: Detector
    against: Detector | None = None
    rates: tuple[Literal["TP", "TN"], ...] = ("TP", "TN")
    approach: Tolerances = {}
    standing: Tolerances = {}

    @field_validator("approach", "standing")
    @classmethod
    def _known(cls, tolerances: dict[str, float]) -> dict[str, float]:
        for name, tolerance in tolerances.items():
            check_tolerance(name, tolerance)
        return tolerances

    @model_validator(mode="after")
    def _something(self) -> Regression:
        if not (self.rates or self.approach or self.standing):
            raise ValueError(f"a regression must watch rates or quantities, got none for {self.detector}")
        return self


class Gates(BaseModel, extra="forbid", frozen=True):
    """All gates of a file.

    Attributes:
        claimed: the detector of those claims that name none.
        baseline: file of the baseline, relative to the gates file.
        split: the split on which claims are judged.
        p_below, loss_points: a rate has fallen if McNemar's p is below the one and the loss is at least the other.
        confidence: of the intervals of shifts.
        physics: check -> greatest value allowed; see `benchmarks.gates.physics`.
    """

    title: str
    claimed: Detector = ""
    baseline: str | None = None
    split: Literal["dev", "test"] = "test"
    p_below: Share = 0.01
    loss_points: Points = 1.5
    confidence: Confidence = 0.95
    claims: tuple[Claim, ...] = ()
    regression: tuple[Regression, ...] = ()
    physics: dict[str, Positive] = {}

    @field_validator("physics")
    @classmethod
    def _known_checks(cls, asked: dict[str, float]) -> dict[str, float]:
        from benchmarks.gates.physics import CHECKS, GREATEST

        unknown = sorted(set(asked) - set(CHECKS))
        if unknown:
            raise ValueError(f"physics checks must be among {sorted(CHECKS)}, got {unknown}")
        for name, at_most in asked.items():
            check_exceedable(name, at_most, GREATEST[name])
        return asked

    @model_validator(mode="after")
    def _something(self) -> Gates:
        if not (self.claims or self.regression or self.physics):
            raise ValueError("a gates file must hold claims, regression or physics")
        if not self.claimed and not all(claim.detector for claim in self.claims):
            raise ValueError("a claim must name its detector, or the file one for all as `claimed`")
        return self


def list_gates() -> list[str]:
    """Names of the gates files that come with the package."""
    folder = resources.files("benchmarks") / "gates" / "files"
    return sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir() if entry.name.endswith(".yaml"))


def gates_path(name_or_path: str) -> Path:
    """Where a gates file lies, by name or by path.

    Raises:
        ValueError: there is none.
    """
    if name_or_path.endswith((".yaml", ".yml")):
        path = Path(name_or_path)
    elif name_or_path in list_gates():
        path = Path(str(resources.files("benchmarks") / "gates" / "files" / f"{name_or_path}.yaml"))
    else:
        raise ValueError(f"gates must be one of {list_gates()} or a .yaml file, got '{name_or_path}'")
    if not path.is_file():
        raise ValueError(f"a gates file must exist, got '{name_or_path}'")
    return path


def load_gates(path: Path) -> Gates:
    """Read and check a gates file.

    Raises:
        ValueError: not YAML, or a value that breaks the schema; the message names it.
    """
    data = parsed(read_text(path, "gates file"), path.name, "gates file")[0]
    try:
        return Gates.model_validate(data)
    except ValidationError as error:
        raise ValueError(f"gates file '{path}': {first_error(error, Gates, CLAIMS)}") from error
