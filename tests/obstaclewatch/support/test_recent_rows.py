"""Rows that are kept, against a list."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from obstaclewatch.support.recent_rows import LastRows

STEPS = st.lists(st.one_of(st.just("append"), st.integers(0, 6), st.just("clear")), max_size=60)


@given(st.integers(1, 7), STEPS)
def test_as_a_list_that_loses_its_first(most, steps):
    kept, listed = LastRows(most, 2), []
    for number, step in enumerate(steps):
        if step == "append":
            kept.append((number, -number))
            listed = [*listed, [number, -number]][-most:]
        elif step == "clear":
            kept.clear()
            listed = []
        else:
            kept.drop(step)
            listed = listed[step:]
        assert len(kept) == len(listed)
        assert kept.rows.tolist() == listed


def test_rows_lie_side_by_side():
    kept = LastRows(3, 4, np.complex64)
    for number in range(20):
        kept.append(np.full(4, number))
        assert kept.rows.flags.c_contiguous
        assert kept.rows.dtype == np.complex64
