"""YAML of strangers ends with one clear error, in a blink and in little memory."""

from __future__ import annotations

import time

import pytest

from scenes.files.bounded_yaml import DEEPEST, MOST_CHARACTERS, parsed

BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 9)}]\n" for k in range(9)
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BOMB, r"^n\.yaml:6: a file must hold at most \d+ values, with every alias counted"),
        ("x: 1\na: &a [*a]", r"^n\.yaml:2: a file must not have '\*a' within what it names"),
        ("a: &a\n  b: *a", r"within what it names"),
        ("[" * (DEEPEST + 1), r"^n\.yaml:1: a file must be at most 30 levels deep"),
        ("{a: " * 2000, r"at most 30 levels deep"),
        ("- " * 2000, r"at most 30 levels deep"),
        ("a: b\nc: 2020-13-01", r"^n\.yaml:2: a file must be YAML: '2020-13-01' cannot be read: month must be"),
        ("a: " + "9" * 5000, r"cannot be read: Exceeds the limit"),
        ("a: !!timestamp z", r"'z' cannot be read"),
        ("a: !!python/object:os.system x", r"could not determine a constructor"),
        ("[1]: 2", r"found unhashable key"),
        ("a\n---\nb", r"^n\.yaml:2: a file must be YAML: but found another document"),
        ("x" * (MOST_CHARACTERS + 1), r"must have at most 1048576 characters"),
    ],
)  # fmt: skip
def test_what_would_hang_or_crash_is_one_error(text: str, message: str) -> None:
    """Cause: `yaml.safe_load` builds every alias, recurses over depth and lets the errors of single values through."""
    begin = time.process_time()
    with pytest.raises(ValueError, match=message):
        parsed(text, "n.yaml", "file")
    assert time.process_time() - begin < 1.0  # the bomb took more than 30 s


def test_aliases_and_merges_within_the_bounds_are_read() -> None:
    data, root = parsed("a: &a {x: 1}\nb: {<<: *a, y: [*a, *a]}", "n.yaml", "file")
    assert data == {"a": {"x": 1}, "b": {"x": 1, "y": [{"x": 1}, {"x": 1}]}}
    assert root is not None
    assert parsed("", "n.yaml", "file") == (None, None)


def test_a_key_given_twice_is_refused_with_its_line() -> None:
    """Cause: PyYAML keeps the last value, so that gates files lost the first of two `claims` and suites a `seed`."""
    with pytest.raises(ValueError, match=r"^n\.yaml:3: a file must give each key of a mapping once, got 'seed' twice$"):
        parsed("seed: 1\nlist: [{a: 1}, {a: 2}]\nseed: 2", "n.yaml", "file")
    assert parsed("a: &a {x: 1}\nb: {<<: *a, x: 2}", "n.yaml", "file")[0]["b"] == {"x": 2}
