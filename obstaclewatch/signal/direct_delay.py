"""How early or late the direct sound may be; apart from what looks for it, which is compiled."""

from __future__ import annotations

DIRECT_SEARCH_S = 1.2e-3
"""How far from the block's start the direct peak may lie: the air path along a 16 cm phone takes 0.47 ms."""


def check_direct_delay(delay_s: float) -> None:
    """Refuse a delay of the direct peak at microphone 0 at which it is not looked for.

    Raises:
        ValueError: it is not within `DIRECT_SEARCH_S` of the emission: no beep of a recording would ever be found.

    >>> check_direct_delay(0.0002)
    """
    if not abs(delay_s) < DIRECT_SEARCH_S:
        raise ValueError(
            f"the direct sound must reach microphone 0 within {DIRECT_SEARCH_S * 1e3:g} ms of its emission, got "
            f"direct_delay_s = {delay_s:g}"
        )
