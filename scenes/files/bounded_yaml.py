"""YAML of strangers: depth, aliases and size are bounded before anything is built of it, and no key is given twice.

Nine aliases of nine aliases, nine deep, are 387 million values in 200 characters; a value that holds itself has no end.
The parser's events show both without building either.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

MOST_CHARACTERS = 1 << 20
DEEPEST = 30
"""Levels of mappings and lists; the deepest file of the project has 6."""
MOST_VALUES = 100_000
"""Keys, values, mappings and lists, each alias counted as what it stands for."""


@dataclass
class _Open:
    """A mapping or list whose end has not come."""

    anchor: str | None
    values: int = 1


@dataclass
class _Bounds:
    """What the events so far amount to."""

    open: list[_Open] = field(default_factory=lambda: [_Open(None, 0)])
    sizes: dict[str, int] = field(default_factory=dict)

    def add(self, event: yaml.Event) -> None:
        """Count one event.

        Raises:
            ValueError: too deep, too many, or a value within itself.
        """
        if isinstance(event, yaml.CollectionStartEvent):
            self.open.append(_Open(event.anchor))
            if len(self.open) - 1 > DEEPEST:
                raise ValueError(f"must be at most {DEEPEST} levels deep")
        elif isinstance(event, yaml.CollectionEndEvent):
            done = self.open.pop()
            self._count(done.values, done.anchor)
        elif isinstance(event, yaml.ScalarEvent):
            self._count(1, event.anchor)
        elif isinstance(event, yaml.AliasEvent):
            if any(event.anchor == each.anchor for each in self.open):
                raise ValueError(f"must not have '*{event.anchor}' within what it names")
            self._count(self.sizes.get(str(event.anchor), 1), None)

    def _count(self, values: int, anchor: str | None) -> None:
        if anchor is not None:
            self.sizes[anchor] = values
        self.open[-1].values += values
        if self.open[-1].values > MOST_VALUES:
            raise ValueError(f"must hold at most {MOST_VALUES} values, with every alias counted as what it stands for")


class _Builder(yaml.constructor.SafeConstructor):
    """PyYAML's own, whose errors about a single value lack the line: a date of month 13, a number of 5000 digits."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep=deep)
        except (ValueError, OverflowError, AttributeError) as error:
            raise yaml.constructor.ConstructorError(
                None, None, f"'{str(node.value)[:40]}' cannot be read: {error}", node.start_mark
            ) from error


def parsed(
    text: str, name: str, what: str, loader: type[yaml.SafeLoader] = yaml.SafeLoader
) -> tuple[Any, yaml.Node | None]:
    """What YAML text holds, as plain values and as nodes with line numbers.

    Args:
        text: of one document.
        name, what: of the file, for messages: "yard.yaml" and "scene file".
        loader: what says which of the values without quotes are numbers.

    Raises:
        ValueError: not YAML, beyond the bounds, or a key twice in one mapping; with the line.

    >>> parsed("name: yard", "yard.yaml", "scene file")[0]
    {'name': 'yard'}
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"{name}: a {what} must have at most {MOST_CHARACTERS} characters, got {len(text)}")
    bounds, line = _Bounds(), 1
    try:
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            line = line if event.start_mark is None else event.start_mark.line + 1
            bounds.add(event)
        root = yaml.compose(text, Loader=loader)
        repeated = next(_repeated_keys(root), None)  # before merges are built: what these bring in may be overridden
        if repeated is not None:
            key, line = repeated
            raise ValueError(f"must give each key of a mapping once, got '{key}' twice")
        return None if root is None else _Builder().construct_document(root), root
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or " ".join(str(error).split())
        where = name if mark is None else f"{name}:{mark.line + 1}"
        raise ValueError(f"{where}: a {what} must be YAML: {problem}") from error
    except ValueError as error:
        raise ValueError(f"{name}:{line}: a {what} {error}") from error


def _repeated_keys(node: yaml.Node | None) -> Iterator[tuple[str, int]]:
    """Keys of which PyYAML would keep the last value alone, with their lines."""
    if isinstance(node, yaml.MappingNode):
        seen: set[str] = set()
        for key, value in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    yield key.value, key.start_mark.line + 1
                seen.add(key.value)
            yield from _repeated_keys(value)
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _repeated_keys(item)


def read_text(path: Path, what: str) -> str:
    """A file's text, unless it is larger than YAML may be here.

    Raises:
        ValueError: too large, or not UTF-8.
    """
    size = path.stat().st_size
    if size > 4 * MOST_CHARACTERS:
        raise ValueError(f"{path.name}: a {what} must have at most {MOST_CHARACTERS} characters, got {size} bytes")
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path.name}: a {what} must be UTF-8 text: {error}") from error
