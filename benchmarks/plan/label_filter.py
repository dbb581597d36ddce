"""Which cells `-k` keeps: words that a label holds, joined by and, or, not and parentheses, as in pytest."""

from __future__ import annotations

import re
from collections.abc import Callable

Filter = Callable[[str], bool]
_TOKENS = re.compile(r"\(|\)|[^\s()]+")
_RESERVED = ("and", "or", "not", "(", ")")


def label_filter(expression: str) -> Filter:
    """A function that tells whether a label such as "supermarket/dustbin/17" fits.

    Raises:
        ValueError: the expression cannot be read.
    """
    tokens = _TOKENS.findall(expression)
    try:
        found = _either(tokens)
    except IndexError:
        tokens = ["its end"]
    if tokens:
        raise ValueError(f"-k must join words by and, or, not, parentheses, got '{expression}', wrong at {tokens[0]}")
    return found


def _either(tokens: list[str]) -> Filter:
    terms = [_both(tokens)]
    while tokens and tokens[0] == "or":
        tokens.pop(0)
        terms.append(_both(tokens))
    return lambda label: any(term(label) for term in terms)


def _both(tokens: list[str]) -> Filter:
    terms = [_one(tokens)]
    while tokens and tokens[0] == "and":
        tokens.pop(0)
        terms.append(_one(tokens))
    return lambda label: all(term(label) for term in terms)


def _one(tokens: list[str]) -> Filter:
    word = tokens.pop(0)
    if word == "not":
        negated = _one(tokens)
        return lambda label: not negated(label)
    if word == "(":
        inner = _either(tokens)
        if tokens.pop(0) != ")":
            raise IndexError
        return inner
    if word in _RESERVED:
        tokens.insert(0, word)
        raise IndexError
    return lambda label: word in label
