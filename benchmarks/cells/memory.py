"""What a walk takes to render, said before it is begun: a process out of memory is killed without a word."""

from __future__ import annotations

import os

BYTES_A_SAMPLE = 24
"""Of both channels, at the peak: 3 times the recording itself over a minute, 2 times over two, measured."""


def needed_bytes(duration_s: float, sample_rate_hz: float) -> float:
    """Most memory that rendering a walk in one piece takes, as the cells of a suite do.

    >>> print(f"{needed_bytes(600.0, 192_000.0) / 1e9:.1f} GB")
    2.8 GB
    """
    return BYTES_A_SAMPLE * duration_s * sample_rate_hz


def free_bytes() -> float:
    """Memory that could be had now, as the system estimates it; infinite where it does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            kilobytes = next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
        return 1024.0 * kilobytes
    except (OSError, StopIteration):
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (OSError, ValueError, AttributeError):
        return float("inf")


def check_memory(duration_s: float, sample_rate_hz: float) -> None:
    """Refuse a walk that memory does not hold.

    Raises:
        ValueError: it needs more than is free; with both.
    """
    needed, free = needed_bytes(duration_s, sample_rate_hz), free_bytes()
    if needed > free:
        raise ValueError(
            f"a walk of {duration_s:g} s at {sample_rate_hz:g} Hz takes {needed / 1e9:.1f} GB to render, "
            f"{free / 1e9:.1f} GB are free: make it shorter"
        )
