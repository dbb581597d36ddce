"""Names and titles of others in Markdown: text, and nothing else."""

from __future__ import annotations

import re

_SPECIAL = re.compile(r"[\\`\[\]<>|]")


def plain(text: object) -> str:
    """Text that Markdown shows as it is, in one line: no link, no HTML, no end of a table's cell.

    >>> print(plain("<b>a|b</b>"))
    \\<b\\>a\\|b\\</b\\>
    """
    return _SPECIAL.sub(lambda found: f"\\{found[0]}", " ".join(str(text).split()))


def as_code(text: str) -> str:
    """Text as code, in one line, fenced by more backticks than it holds.

    >>> as_code("a `b`")
    '`` a `b` ``'
    """
    line = " ".join(text.split())
    longest = max((len(run) for run in re.findall("`+", line)), default=0)
    fence, pad = "`" * (longest + 1), " " if longest else ""
    return f"{fence}{pad}{line}{pad}{fence}"
