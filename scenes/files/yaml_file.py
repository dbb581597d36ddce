"""YAML files read so that what is wrong in them can be said with file, line and field."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError

from scenes.files.bounded_yaml import parsed, read_text

Model = TypeVar("Model", bound=BaseModel)
Place = Sequence[int | str]
"""The path to a field: names of mappings and positions in lists."""
KEY = "[key]"
"""Where pydantic says that a key is wrong, and not what stands under it."""


@dataclass(frozen=True)
class YamlFile:
    """A file that is YAML.

    Attributes:
        path: of the file.
        data: what it holds.
        root: the same with line numbers.
    """

    path: Path
    data: Any = field(repr=False)
    root: yaml.Node | None = field(repr=False)

    @classmethod
    def read(cls, path: str | Path) -> YamlFile:
        """Read a file.

        Raises:
            ValueError: it is not YAML, too large, not a mapping, or names a key twice; with the line.
            FileNotFoundError: there is no such file.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"scene file must exist, got '{path}'")
        data, root = parsed(read_text(path, "scene file"), path.name, "scene file")
        if not isinstance(data, dict):
            raise ValueError(f"{path.name}:1: a scene file must be a mapping of fields, got {data!r}")
        return cls(path, data, root)

    def as_model(self, model: type[Model]) -> Model:
        """The data as a pydantic model.

        Raises:
            ValueError: it does not fit; one "file:line: field: what is wrong" for each mistake, in order of lines.
        """
        try:
            return model.model_validate(self.data)
        except ValidationError as error:
            problems = [(self.line(e["loc"]), e) for e in error.errors()]
            lines = [self.message(e["loc"], said(e, model)) for _, e in sorted(problems, key=lambda item: item[0])]
            raise ValueError("; ".join(lines)) from error

    def message(self, place: Place, text: str) -> str:
        """One line about a field: "yard.yaml:7: obstacles[2].kind: text"."""
        return f"{self.path.name}:{self.line(place)}: {dotted(place)}{text}"

    def line(self, place: Place) -> int:
        """The line of a field, or of the nearest mapping or list that should hold it; from 1."""
        node, line = self.root, 1
        for step in place:
            below = _below(node, step)
            if below is None:
                break
            line, node = below
        return line

    @contextmanager
    def at(self, *place: int | str) -> Iterator[None]:
        """Whatever is refused inside is said with the line of that field."""
        try:
            yield
        except FileNotFoundError as error:
            raise FileNotFoundError(self.message(place, str(error))) from error
        except ValueError as error:
            raise ValueError(self.message(place, str(error))) from error


def _below(node: yaml.Node | None, step: int | str) -> tuple[int, yaml.Node] | None:
    """Line and node of one item of a mapping or list."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == step:
                return key.start_mark.line + 1, value
    if isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
        return node.value[step].start_mark.line + 1, node.value[step]
    return None


def dotted(place: Place) -> str:
    """ "obstacles[2].kind: ", or nothing for the file itself."""
    steps = [step for step in place if step != KEY]
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).lstrip(".")
    return f"{text}: " if text else ""


def said(error: Any, model: type[BaseModel]) -> str:
    """What is wrong with a field by one of pydantic's errors, in a line."""
    kind = error["type"]
    if kind == "missing":
        return "is missing"
    if kind == "extra_forbidden":
        known = sorted(_known_fields(model, error["loc"][:-1]))
        close = difflib.get_close_matches(str(error["loc"][-1]), known, n=1)
        return (
            f"is not a field here; did you mean '{close[0]}'?" if close else f"is not a field here; there are {known}"
        )
    if kind == "value_error":
        return str(error["ctx"]["error"])
    found = "nothing" if error["input"] is None else repr(error["input"])
    return f"{'a key ' * (error['loc'][-1:] == (KEY,))}{_rule(error)}, got {found}"


RULES = {
    **dict.fromkeys(("list_type", "tuple_type", "set_type"), "must be a list"),
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type"), "must be a table of keys"),
    "invalid_key": "must have texts as keys",
    "string_type": "must be a text",
}
"""What pydantic says with the names of Python's types and of our classes."""


def _rule(error: Any) -> str:
    """The rule that one of pydantic's errors is about."""
    kind, limits = error["type"], error.get("ctx", {})
    if kind in RULES:
        return RULES[kind]
    if kind == "too_short":
        least = limits["min_length"]
        return "must not be empty" if least == 1 else f"must have {least} values or more"
    if kind == "too_long":
        return f"must have {limits['max_length']} values at most"
    text = error["msg"].replace("Input should", "must")
    return f"{text[:1].lower()}{text[1:]}"


def _known_fields(model: type[BaseModel], place: Place) -> list[str]:
    """Names of the fields of the model that a place leads to."""
    for step in place:
        if isinstance(step, str) and step in model.model_fields:
            model = _model_in(model.model_fields[step].annotation) or model
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The model that an annotation such as list[Model] | None names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _model_in(part)) is not None), None)
