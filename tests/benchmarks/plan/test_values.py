"""Numbers of a suite, of a gates file and of a phone's file are numbers: neither truth values nor NaN nor infinite."""

from __future__ import annotations

import math
from collections.abc import Iterator
from types import ModuleType
from typing import Any, get_args

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

from benchmarks import own_phone
from benchmarks.cells import spec
from benchmarks.gates import config
from benchmarks.plan import suite, sweep
from benchmarks.scoring.energy import EnergyModel


def models(module: ModuleType) -> Iterator[type[BaseModel]]:
    for thing in vars(module).values():
        if isinstance(thing, type) and issubclass(thing, BaseModel) and thing.__module__ == module.__name__:
            yield thing


def plain_types(annotation: Any) -> Iterator[Any]:
    """What an annotation is made of, and itself."""
    yield annotation
    for part in get_args(annotation):
        yield from plain_types(part)


FIELDS = [
    (model, name)
    for module in (spec, suite, sweep, config, own_phone)
    for model in models(module)
    for name, field in model.model_fields.items()
    if {float, int} & (kinds := {kind for kind in plain_types(field.annotation) if isinstance(kind, type)})
    and not {bool, list} & kinds
]


def refuses(model: type[BaseModel], name: str, value: Any) -> bool:
    """Whether a field is at fault with that value, whatever else is missing; pairs and mappings of it are tried too."""
    for given in (value, [value], [value, value], [value] * 3, [[value] * 3] * 2, {"wall": value}):
        try:
            model.model_validate({name: given})
        except ValidationError as error:
            if not any(each["loc"][:1] == (name,) for each in error.errors()):
                return False  # others are missing, this one is taken
        else:
            return False
    return True


@pytest.mark.parametrize("value", [True, math.nan, math.inf, -math.inf, "x"])
@pytest.mark.parametrize(("model", "name"), FIELDS, ids=lambda part: part if isinstance(part, str) else part.__name__)
def test_what_is_no_number_is_refused(model: type[BaseModel], name: str, value: Any) -> None:
    """Cause: true counted as 1, and a half width, a gap or a distance might be infinite."""
    assert refuses(model, name, value)


def test_all_numbers_are_tried() -> None:
    assert len(FIELDS) > 50
    assert {name for model, name in FIELDS if model is spec.Scoring} == {"half_width_m", "gate_m", "max_range_m"}


@pytest.mark.parametrize(
    ("model", "data"),
    [
        (spec.PhoneChange, {"level_spl_db": 1e12}),
        (spec.SceneChange, {"person_level_db": 1e12}),
        (spec.RecordingChange, {"mic_gain_db": [1e12, 0.0]}),
        (spec.Interferer, {"level_spl_db": 1e12}),
    ],
)
def test_a_level_that_overflows_is_refused(model: type[BaseModel], data: dict[str, Any]) -> None:
    """Cause: cells failed with OverflowError, after their walks were rendered."""
    with pytest.raises(ValidationError, match="less than or equal to 500"):
        TypeAdapter(model).validate_python(data)


@pytest.mark.parametrize("name", ["audio_w", "core_w", "slower", "battery_v"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 0.0])
def test_constants_of_the_energy_model_are_positive(name: str, value: float) -> None:
    """Cause: none was checked, and a voltage of 0 ended in ZeroDivisionError."""
    with pytest.raises(ValueError, match=f"{name} must be positive and finite, got"):
        EnergyModel(**{name: value})
    with pytest.raises(ValueError, match=f"{name} must be a number, got True"):
        EnergyModel(**{name: True})
