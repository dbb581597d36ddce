"""Beeps whose samples are damaged: by a click, a gap of zeros, drops, or samples that are missing.

Late in a period, and before its direct sound, an envelope holds little but noise, and that is about as loud in every
beep. A click is as long as the beep once it is compressed, and what is cut out of a beep leaves sidelobes for tens of
milliseconds on both sides: both raise that noise. An obstacle that is suddenly there does not: its echoes are earlier.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from obstaclewatch.signal.direct_sound import DirectSound
from obstaclewatch.signal.matched_filter import EchoProfile
from obstaclewatch.support.arrays import Complexes, Floats
from obstaclewatch.support.compiled import compiled
from obstaclewatch.support.order_statistic import order_statistic

LATE_S, BEFORE_S = 30e-3, 3e-3
"""From which delay on noise is measured, 5.1 m of range, and until when before the next direct sound."""
WINDOW_S, QUANTILE = 8e-3, 0.6
"""Noise is that quantile of windows, which overlap by half."""
REMEMBERED_BEEPS = 8
LOUDER = 10.0 ** (10.0 / 20.0)
"""Height of a window's noise over that of earlier beeps from which a beep is damaged. On 94 rendered walks and places
it is 5.4 dB at most. A mean power over 12 beeps rises by 2.4 dB at most with what stays below."""
QUIETER = 10.0 ** (-35.0 / 20.0)
"""Likewise, below which samples are missing, where there is noise: of those 6 dB at most."""
LEAST = 10.0 ** (-78.0 / 20.0)
"""Of the direct sound, that noise is taken for at least. Without any, late echoes reach -77 dB."""
REAL = 10.0 ** (-88.0 / 20.0)
"""Likewise; where a window has less than that there is no noise that could be missing."""


class DamagedBeeps:
    """Compares the noise of each beep with that of the last ones.

    Their median counts, damaged or not: one beep does not change it, and noise that stays is usual after five.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign
    >>> from obstaclewatch.signal.direct_sound import direct_sound
    >>> from obstaclewatch.signal.matched_filter import MatchedFilter
    >>> beep = BeepDesign()
    >>> noise, waveform = np.random.default_rng(0), beep.waveform(np.arange(beep.period_samples) / beep.sample_rate_hz)
    >>> blocks = waveform + 0.001 * noise.standard_normal((5, 2, beep.period_samples))
    >>> blocks[3, :, 9_000] = 10.0  # a click
    >>> damage, compressor = DamagedBeeps(), MatchedFilter(beep, reach_s=0.03)
    >>> profiles = [compressor.compress(block) for block in blocks]
    >>> [damage.found(profile, direct_sound(profile)) for profile in profiles]
    [False, False, False, True, False]
    """

    def __init__(self) -> None:
        self._noise: deque[Floats] = deque(maxlen=REMEMBERED_BEEPS)
        self.clear()

    def clear(self) -> None:
        """Forget all beeps."""
        self._noise.clear()
        self.was_first = False

    def found(self, profile: EchoProfile, direct: DirectSound) -> bool:
        """Whether a beep is damaged; then remember its noise.

        `was_first` says afterwards that the beep before was the first one, and that it was damaged, by what this one
        has: nothing could be known of it, and it is to be forgotten.
        """
        noise = noise_heights(profile)
        least, usual = LEAST * float(direct.amplitude.max()), self._usual(noise)
        real = usual.min(axis=1, keepdims=True, initial=np.inf) > REAL * float(direct.amplitude.max())
        missing = bool(np.any(real & (noise < QUIETER * usual)))
        self.was_first = len(self._noise) == 1 and self._is_louder(self._noise[0], noise, least)
        if self.was_first:
            self._noise.clear()
        self._noise.append(noise)
        return not self.was_first and (missing or self._is_louder(noise, usual, least))

    def _usual(self, noise: Floats) -> Floats:
        """Median of the last beeps, of two the quieter one; without any the noise itself."""
        if not self._noise:
            return noise
        usual: Floats = np.sort(np.array(self._noise), axis=0)[(len(self._noise) - 1) // 2]
        return usual

    @staticmethod
    def _is_louder(noise: Floats, usual: Floats, least: float) -> bool:
        return bool(np.any(noise > LOUDER * np.maximum(usual, least)))


def noise_heights(profile: EchoProfile) -> Floats:
    """(C, W) height of the noise in windows late in a beep's period; none where the period is too short.

    >>> import numpy as np
    >>> from obstaclewatch import BeepDesign
    >>> from obstaclewatch.signal.matched_filter import MatchedFilter
    >>> noise_heights(MatchedFilter(BeepDesign(), reach_s=0.03).compress(np.zeros((2, 17_280)))).shape
    (2, 13)
    """
    first = round((LATE_S - profile.start_s) * profile.rate_hz)
    last = profile.circular.shape[1] - round((BEFORE_S + profile.start_s) * profile.rate_hz)
    half = round(0.5 * WINDOW_S * profile.rate_hz)
    return _quantiles(profile.circular, first, max((last - first) // half - 1, 0), half)


@compiled
def _quantiles(envelope: Complexes, first: int, windows: int, half: int) -> Floats:
    """(C, windows) quantiles of an envelope (C, count) from a sample on, in windows that overlap by half."""
    heights, size = np.empty((len(envelope), windows)), np.empty((windows + 1) * half)
    for mic in range(len(envelope)):
        for sample in range(len(size) if windows > 0 else 0):
            size[sample] = abs(envelope[mic, first + sample])
        for window in range(windows):
            heights[mic, window] = order_statistic(size[window * half : (window + 2) * half], int(QUANTILE * 2 * half))
    return heights
