"""Long walks in pieces: the same samples, and memory that does not grow with the walk."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from obstaclewatch.beep import BeepDesign
from simulator import Fidelity, Phone, Scene, StraightWalk, render_walk
from simulator.render import render_pieces, trace_walk

BEEP = BeepDesign()


@pytest.mark.parametrize(("name", "left"), [("galaxy-s8-plus", 5e-7), ("galaxy-s5", 6e-6)])
def test_blocks_join_without_a_seam(box, monkeypatch, name, left):
    # What is left of the direct sound: twice the rounding of a long transform in single precision, 2.5e-7, and how a
    # galaxy-s5's microphone rings after RING_S. Cause of the moving wall: its time is the walk's, not the block's.
    phone = Phone.named(name)
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.5, 40 * BEEP.period_s)
    wall = box((0.2, 12.0, 4.0), (4.1, 0.0, 1.5), "wall", velocity_m_s=[0.2, 0.0, 0.0])
    arguments = Scene([wall]), phone, walk, BEEP, Fidelity(mechanisms=("specular",))
    whole = render_walk(*arguments, seed=3).samples
    monkeypatch.setattr("simulator.render.BLOCK_BEEPS", 16)
    pieces = [piece.samples for piece in render_pieces(*arguments, seed=3)]
    assert len(pieces) == 3
    joined = np.concatenate(pieces, axis=1)
    assert joined.shape == whole.shape
    assert np.abs(joined - whole).max() < left * np.abs(whole).max()


def test_memory_does_not_grow_with_the_walk(monkeypatch):
    # Cause: paths, envelopes, spectra and samples of a walk were held at once: 7 GB for 10 minutes.
    monkeypatch.setattr("simulator.render.BLOCK_BEEPS", 16)
    peaks = []
    for blocks in (4, 12):
        walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, blocks * 16 * BEEP.period_s)
        tracemalloc.start()
        lengths = [piece.samples.shape[1] for piece in render_pieces(Scene([]), Phone.named("galaxy-s5"), walk, BEEP)]
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert sum(lengths) == blocks * 16 * BEEP.period_samples
    assert peaks[1] < 1.05 * peaks[0]


@pytest.mark.parametrize(("start_hz", "rate_hz"), [(2e3, 16e3), (10e3, 192e3)])
@pytest.mark.parametrize("render", [render_pieces, trace_walk])
def test_a_beep_outside_the_band_is_refused_at_once(start_hz, rate_hz, render):
    """`render_pieces` refused it with its first piece, and at 16 kHz divided by zero before that."""
    beep = BeepDesign(start_hz, start_hz + 1e3, sample_rate_hz=rate_hz)
    walk = StraightWalk([0.0, 0.0, 1.3], 0.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="the beep must lie within 15-25 kHz, got "):
        render(Scene([]), Phone.named("ideal"), walk, beep, Fidelity())
