"""What a beep costs: the least of several rounds, each from a fresh state."""

from __future__ import annotations

import time

import numpy as np

from docs.studies.beep_cost import HEADER, beep_cost_ms, cost_row


class _Slow:
    """Takes 4 ms for the second beep of a round, 50 for that of the first round."""

    def __init__(self):
        self.rounds, self.beep = 0, 0

    def reset(self):
        self.rounds, self.beep = self.rounds + 1, 0

    def process(self, block):
        self.beep += 1
        if self.beep == 2:
            time.sleep(0.05 if self.rounds == 1 else 0.004)


def test_a_beep_counts_with_its_least_time():
    slow = _Slow()
    cost_ms = beep_cost_ms(slow, np.zeros((3, 2, 10), dtype=np.float32), rounds=4)
    assert slow.rounds == 4
    assert cost_ms.shape == (3,)
    assert 4.0 <= cost_ms[1] < 50.0
    assert cost_ms[[0, 2]].max() < 4.0


def test_a_row_says_how_many_beeps_keep_within_the_limit():
    row = cost_row("Mine", np.array([0.1, 0.2, 0.3, 0.6]))
    assert len(row) == len(HEADER)
    assert row == ("Mine", "4", "0.300 ms", "0.250 ms", "0.555 ms", "0.600 ms", "75.0%")
