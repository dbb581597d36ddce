"""Processor time of calls, and the unit that rendering is held against."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np
import scipy.fft

ROUNDS = 7


def cpu_ms(call: Callable[[], Any], rounds: int = ROUNDS) -> float:
    """Median processor time of a call, ms; the first, which may compile, does not count."""
    call()
    spent = []
    for _ in range(rounds):
        begin = process_time()
        call()
        spent.append(process_time() - begin)
    return 1e3 * float(np.median(spent))


def fft_ms(samples: int) -> float:
    """The Fourier transform of two channels of so many real samples, ms."""
    block = np.random.default_rng(0).standard_normal((2, samples))

    def hundred() -> None:
        for _ in range(100):
            scipy.fft.rfft(block, axis=1)

    return cpu_ms(hundred) / 100.0


def require(right: bool, what: str) -> None:
    """Refuse to time what is wrong.

    Raises:
        RuntimeError: it is.
    """
    if not right:
        raise RuntimeError(f"not timed, because {what}")
