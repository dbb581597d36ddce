"""Why a cell failed, in one line, out of the traceback that its record keeps."""

from __future__ import annotations

import re

CHAINED = re.compile(
    r"\n\n(?:During handling of the above exception, another exception occurred"
    r"|The above exception was the direct cause of the following exception):\n\n"
)
"""Between the tracebacks of errors of which one led to the next."""


def reason(error: str) -> str:
    """Type and first line of the message of the error that a traceback ends with.

    >>> reason("Traceback (most recent call last):\\n  File 'mine.py', line 7\\nRuntimeError: boom\\nmore\\n")
    'RuntimeError: boom'
    """
    last = CHAINED.split(error.strip())[-1].splitlines()
    said = [line for line in last if line.strip() and not line.startswith((" ", "Traceback"))]
    if not said:
        return last[0] if last else ""
    first = said[0].rstrip()
    return f"{first} {said[1]}" if first.endswith(":") and said[1:] else first
