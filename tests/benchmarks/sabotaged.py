"""The paper's detector with its second channel two samples late: what a wrong offset into a buffer does."""

from __future__ import annotations

import numpy as np

from obstaclewatch import Detection, PaperDetector


class LateChannelDetector(PaperDetector):
    """Microphone 1 comes two samples late."""

    SAMPLES = 2

    def process(self, block: np.ndarray, time_s: float | None = None) -> Detection:
        """Measure the beep with one channel delayed."""
        late = np.zeros_like(block[1])
        late[self.SAMPLES :] = block[1, : -self.SAMPLES]
        return super().process(np.stack([block[0], late]), time_s)
