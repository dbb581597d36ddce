"""Inputs that are nearly right: bytes flipped, cut and repeated, values of data put in the place of others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 10**30, -(10**30), 1e308, -1e308, 1e-320, float("nan"), float("inf"), "", "x", "*",
    "\u0000", "../../x", "/etc/passwd", "a" * 5000, "<!--<script>", "2020-13-01", "1_0", "0x", [], {}, [1], [[]],
    {"a": {}}, [None, 1, "x"],
)  # fmt: skip
TOKENS = (
    b"{", b"[", b"]", b"}", b":", b"- ", b"&a ", b"*a", b"<<: *a", b"!!int ", b"!!python/object:os.system ", b"|\n",
    b"\t", b"#", b"\x00", b"\xff", b"\xfe\xff", b"'", b'"', b"1e999", b"-0", b"\n", b"---\n", b"%YAML 9\n",
    b"\xe2\x80\xa8",
)  # fmt: skip


def changed_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """The same with one to four small accidents."""
    for _ in range(int(rng.integers(1, 5))):
        data = _ACCIDENTS[int(rng.integers(len(_ACCIDENTS)))](data, rng)
    return data


def changed_data(value: Any, rng: np.random.Generator, depth: int = 0) -> Any:
    """The same tree with one value, key or item replaced, removed or repeated."""
    stop = depth > 0 and rng.random() < 0.25
    if isinstance(value, dict) and value and not stop:
        key = list(value)[int(rng.integers(len(value)))]
        kind = rng.random()
        if kind < 0.1:
            return {name: item for name, item in value.items() if name != key}
        if kind < 0.2:
            return value | {str(_any(rng))[:40]: value[key]}
        return value | {key: changed_data(value[key], rng, depth + 1)}
    if isinstance(value, list) and value and not stop:
        place = int(rng.integers(len(value)))
        kind = rng.random()
        if kind < 0.1:
            return value[:place] + value[place + 1 :]
        if kind < 0.2:
            return value + [value[place]]
        return [*value[:place], changed_data(value[place], rng, depth + 1), *value[place + 1 :]]
    return _any(rng)


def _any(rng: np.random.Generator) -> Any:
    return VALUES[int(rng.integers(len(VALUES)))]


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    if not data:
        return b"\x00"
    place = int(rng.integers(len(data)))
    return data[:place] + bytes([data[place] ^ (1 << int(rng.integers(8)))]) + data[place + 1 :]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def _drop(data: bytes, rng: np.random.Generator) -> bytes:
    begin, length = int(rng.integers(len(data) + 1)), int(rng.integers(1, 40))
    return data[:begin] + data[begin + length :]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    begin, length = int(rng.integers(len(data) + 1)), int(rng.integers(1, 200))
    return data[: begin + length] + data[begin:]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    place = int(rng.integers(len(data) + 1))
    return data[:place] + TOKENS[int(rng.integers(len(TOKENS)))] + data[place:]


def _number(data: bytes, rng: np.random.Generator) -> bytes:
    """Four bytes of an extreme number, as counts and lengths of headers are."""
    place, value = int(rng.integers(len(data) + 1)), (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)[int(rng.integers(5))]
    return data[:place] + value.to_bytes(4, "little") + data[place + 4 :]


_ACCIDENTS: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (_flip, _cut, _drop, _repeat, _insert, _number)
