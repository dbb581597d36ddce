"""What walks and workers take, said before they are begun: a process out of memory is killed without a word."""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
from pathlib import Path

from obstaclewatch.recordings.audio import MOST_WAV_BYTES

BYTES_A_SAMPLE = 24
"""Of both channels, at the peak: 3 times the recording itself over a minute, 2 times over two, measured."""

PROCESS_BYTES = 1.5e9
"""Of a worker with its libraries, compiled functions and kept meshes, and margin. Most that workers had resident: over
the paper's ci tier 0.80 GB, and 1.09 GB where they compiled as well; over its smoke tier after two other suites in one
process 1.10 GB, level from the twelfth walk on."""

FINE_FACET_M = 0.02
FINE_BYTES = 3.0e9
"""The same where facets are smaller than that, as at level `reference`: there it was 2.6 GB where cars are near, as a
body of 47 m2 takes 0.4 GB and six bodies are kept."""

BYTES_A_FRAME = 6
"""Of a WAV: two channels of 24 bits."""


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


def return_freed_memory() -> None:
    """Give the system back what was freed anywhere in the heap; by itself glibc does so at the heap's end alone.

    Worker processes do so after each piece of work. Where psutil is installed, joblib replaces one that holds 300 MB
    more than after its first, and what large arrays left in the heap counts. A new one takes some 5 s: it loads
    libraries and compiled functions, and prepares meshes anew. With other C libraries nothing is done.

    >>> return_freed_memory()
    """
    if sys.platform == "linux" and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)) is not None:
        trim(0)


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


def check_workers(jobs: int, longest_s: float, sample_rate_hz: float, process_bytes: float = PROCESS_BYTES) -> str:
    """What a run takes of memory and what is free, in words.

    Args:
        jobs: processes at a time.
        longest_s: duration of the longest walk.
        sample_rate_hz: of its recording.
        process_bytes: what a process takes beside its walk.

    Raises:
        ValueError: more than is free; with both, and how many jobs fit.
    """
    each, free = process_bytes + needed_bytes(longest_s, sample_rate_hz), free_bytes()
    takes = f"{jobs} {'process takes' if jobs == 1 else 'processes take'} about {jobs * each / 1e9:.1f} GB of memory"
    if jobs * each > free:
        fit = f"-j {int(free / each)}" if free >= each else "a machine with more, or shorter walks,"
        raise ValueError(f"{takes}, {free / 1e9:.1f} GB are free: {fit} fits")
    return f"{takes}, {free / 1e9:.1f} GB are free"


def check_file(path: Path, duration_s: float, sample_rate_hz: float) -> None:
    """Refuse a WAV that its disk or its header does not hold, before hours are rendered. FLAC is left to try.

    Raises:
        ValueError: more than is free, or than a WAV can have; with both.
    """
    size, free = BYTES_A_FRAME * duration_s * sample_rate_hz, shutil.disk_usage(path.parent).free
    if path.suffix.lower() != ".wav":
        return
    if size > MOST_WAV_BYTES:
        raise ValueError(
            f"'{path}' will have {size / 1e9:.1f} GB, a WAV holds {MOST_WAV_BYTES / 1e9:.1f} GB: use .flac"
        )
    if size > free:
        raise ValueError(f"'{path}' will have {size / 1e9:.1f} GB, its disk has {free / 1e9:.1f} GB free")
