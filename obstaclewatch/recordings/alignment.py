"""Finding beeps in a recording that starts anywhere: in a gap, in mid-beep, or with no beep at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.beep import BeepDesign
from obstaclewatch.recording import Recording
from obstaclewatch.recordings.sample_feed import SampleFeed
from obstaclewatch.signal.echoes import refine_peaks
from obstaclewatch.signal.matched_filter import MatchedFilter

LEAST_LIKENESS = 0.5
"""Share of the band's energy that a beep must explain while it sounds. White noise reached 0.04 in 200 trials; rendered
walks reach 0.89 and more, their phone's response and all echoes included."""
EARLY_S = 0.2e-3
"""How long before the recording's first sample a direct peak may lie: its beep lacks nothing but the first hundredth of
its rise. Sound through the case and through the air cancel in part, and the pulse, 0.2 ms long, leans away from where
they do: at -10 C the presets' peaks come 0.07 ms before the emission, at 20 C 0.01 ms after it."""


class NoBeepError(ValueError):
    """The recording holds no beep of the given design.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign, PaperDetector, PhoneGeometry, Recording
    >>> phone = PhoneGeometry("flat", [0, 0.07, 0], [[0, 0.07, 0], [0, -0.07, 0]])
    >>> PaperDetector(BeepDesign(), phone).run(Recording(np.zeros((2, 40_000)), 192_000.0))
    Traceback (most recent call last):
    obstaclewatch.recordings.alignment.NoBeepError
    """


class BeepFinder:
    """Searches a recording for the direct sound of a beep, one period at a time.

    Args:
        beep: the emitted signal.
        direct_delay_s: of the direct sound at microphone 0 after emission.
    """

    def __init__(self, beep: BeepDesign, direct_delay_s: float) -> None:
        self._period = beep.period_samples
        self._rate = beep.sample_rate_hz
        self._direct_delay_s = direct_delay_s
        self._filter = MatchedFilter(beep, 2.0 * beep.period_s, lead_s=EARLY_S, block_samples=2 * self._period)
        own = np.zeros((1, 2 * self._period))
        own[0, : len(beep.samples())] = beep.samples()
        signal = self._filter.band_signal(own)[0]
        self._beep_count = int(np.ceil(beep.duration_s * self._filter.rate_hz))
        self._beep_energy = float(np.sum(np.abs(signal) ** 2))
        self._search = round(beep.period_s * self._filter.rate_hz)

    def first_emission(self, samples: NDArray[np.floating], start: int = 0) -> int:
        """Sample at which the first complete beep was emitted, `start` or later, by its direct sound at microphone 0.

        Args:
            samples: (2, N) recording.
            start: sample from which to search.

        Raises:
            NoBeepError: there is none.
        """
        feed = SampleFeed([Recording(samples, self._rate)], self._rate)
        feed.forget(start)
        return self.next_emission(feed, start)

    def next_emission(self, feed: SampleFeed, start: int) -> int:
        """The same in a recording that arrives in pieces; one period before the emission is still held afterwards.

        Raises:
            NoBeepError: there is none.
        """
        begin = start
        while True:
            piece = feed.take(begin, begin + 2 * self._period)
            if piece.shape[1] == 0:
                raise NoBeepError(
                    f"no beep found at microphone 0 from sample {start} to {begin}: "
                    f"no stretch of the band is explained to {LEAST_LIKENESS:.0%} by the given beep"
                )
            delay_s = self._direct_peak(piece[:1])
            if delay_s is not None:
                return max(begin + round((delay_s - self._direct_delay_s) * self._rate), start)
            begin += self._period
            feed.forget(begin - self._period)

    def _direct_peak(self, piece: NDArray[np.floating]) -> float | None:
        """Delay of the strongest beep in one period of delays, from `EARLY_S` before the piece on, s; None without."""
        padded = np.zeros((1, 2 * self._period), dtype=piece.dtype)
        padded[:, : piece.shape[1]] = piece
        profile = self._filter.compress(padded)
        height = profile.magnitude[0, : self._search]
        peak = int(np.argmax(height))
        energy = self._energy(padded, peak + round(profile.start_s * profile.rate_hz))
        rising = profile.magnitude[0, peak + 1] > height[peak]
        if rising or energy == 0.0 or height[peak] ** 2 * self._beep_energy < LEAST_LIKENESS * energy:
            return None
        position = refine_peaks(profile.magnitude[0], np.array([peak]))[0][0]
        return float(profile.start_s + position / profile.rate_hz)

    def _energy(self, piece: NDArray[np.floating], start: int) -> float:
        """Energy of the beep's band while a beep that starts at that envelope sample would sound."""
        signal = self._filter.band_signal(piece)[0, max(start, 0) : start + self._beep_count]
        return float(np.sum(np.abs(signal) ** 2))
