"""Which cells `-k` keeps: words that a label holds, joined by and, or, not and parentheses, as in pytest."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable

_WORD = re.compile(r"[^\s()]+")
_OPERATORS = ("and", "or", "not")
_PARTS = (ast.Expression, ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.Name, ast.Load)


def label_filter(expression: str) -> Callable[[str], bool]:
    """A function that tells whether a label such as "supermarket/dustbin/17" fits.

    Words become the names w0, w1 ... of a Python expression, which holds nothing but them and the operators.

    Raises:
        ValueError: the expression cannot be read.
    """
    words = [word for word in _WORD.findall(expression) if word not in _OPERATORS]
    names = iter(range(len(words)))
    named = _WORD.sub(lambda found: found[0] if found[0] in _OPERATORS else f"w{next(names)}", expression)
    try:
        tree = ast.parse(named.strip(), "-k", mode="eval")
    except (SyntaxError, RecursionError, MemoryError):
        tree = None
    if tree is None or not all(isinstance(node, _PARTS) for node in ast.walk(tree)):
        raise ValueError(f"-k must join words by and, or, not, parentheses, got '{expression}'")
    code = compile(tree, "-k", "eval")
    return lambda label: eval(code, {"__builtins__": {}}, {f"w{k}": word in label for k, word in enumerate(words)})
